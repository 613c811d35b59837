"""Entries of a film's title, from a model and the block of a case."""

from collections.abc import Mapping
from typing import Any

from overturning.figures.film_words import FilmTitleFacts
from overturning.model.body import Body
from overturning.model.model import Model
from overturning.model.planes import PlanarModel
from overturning.model.scene import Scene
from overturning.model.shapes import Cylinder, RectangularPrism, RegularPrism, Shape
from overturning.model.stack import Stack


def film_title_facts(
    model: Model, block_size_and_friction_by_name: Mapping[str, float], station_and_event: str, **more: Any
) -> FilmTitleFacts:
    """Return the entries of a film title: kind, size and friction of the stone, and the name of the record.

    Parameters
    ----------
    model : Model
        Model of the case.
    block_size_and_friction_by_name : mapping
        ``height`` (m), ``b_over_h`` and ``friction`` of the reference element or body, and ``aspect``, the ratio of
        depth to width, of a 3-D body (1 if not given).
    station_and_event : str
        Name of the record; see `overturning.figures.film_words.station_and_event_text`.
    **more
        ``motion_azimuth_or_orientation_deg``, ``amplitude_factor`` and ``is_simulated_without_vertical_motion`` of
        `FilmTitleFacts`.
    """
    height, width = (
        block_size_and_friction_by_name["height"],
        block_size_and_friction_by_name["height"] * block_size_and_friction_by_name["b_over_h"],
    )
    given = {
        "width": width,
        "height": height,
        "friction": block_size_and_friction_by_name["friction"],
        "station_and_event": station_and_event,
        **more,
    }
    if isinstance(model, Body):
        return FilmTitleFacts(
            **_title_fields_for_stone_of_body(model.shape, width, block_size_and_friction_by_name.get("aspect", 1.0)),
            is_3d=True,
            **given,
        )
    if isinstance(model, Stack):
        return FilmTitleFacts(**(given | _title_fields_for_stone_of_scene(model.scene)), is_3d=True)
    assert isinstance(model, PlanarModel)
    return FilmTitleFacts(**(given | _title_fields_for_stone_of_scene(model.scene)))


def _title_fields_for_stone_of_scene(scene: Scene) -> dict[str, Any]:
    """Return fields of `FilmTitleFacts` for a scene: kind, names, and friction None if the scene sets the friction."""
    own = {} if scene.has_contact_with_unset_friction else {"friction": None}
    if scene.can_use_single_block_kernel and scene.name == "gravestone":
        return {"stone_kind": "stone", **own}
    return {
        "stone_kind": "scene",
        "scene_name": scene.title or scene.name,
        "size_reference_element_name": scene.size_reference_element_name,
        **own,
    }


def _title_fields_for_stone_of_body(shape: Shape, width_m: float, depth_to_width_ratio: float) -> dict[str, Any]:
    """Return fields of `FilmTitleFacts` for a 3-D body: kind, and depth if oblong or number of sides if a prism."""
    if isinstance(shape, RectangularPrism):
        return (
            {"stone_kind": "square"}
            if depth_to_width_ratio == 1.0
            else {"stone_kind": "oblong", "depth": depth_to_width_ratio * width_m}
        )
    if isinstance(shape, Cylinder):
        return {"stone_kind": "round"}
    return (
        {"stone_kind": "prism", "prism_side_count": shape.sides}
        if isinstance(shape, RegularPrism)
        else {"stone_kind": "solid"}
    )
