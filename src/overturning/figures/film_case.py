"""Facts of a film's title, from a model and the block of a case."""

from collections.abc import Mapping
from typing import Any

from overturning.figures.film_words import FilmedCase
from overturning.model.body import Body
from overturning.model.model import Model
from overturning.model.planes import PlanarModel
from overturning.model.scene import Scene
from overturning.model.shapes import Cylinder, RectangularPrism, RegularPrism, Shape


def filmed_case(model: Model, block: Mapping[str, float], place: str, **more: Any) -> FilmedCase:
    """Return the model, the block and the place of a motion, as the title of a film states them.

    Parameters
    ----------
    model : Model
        Model of the case.
    block : mapping
        ``height`` (m), ``b_over_h`` and ``friction`` of the reference element or body, and ``aspect`` of an oblong one.
    place : str
        Name of the record; see `overturning.figures.film_words.place_text`.
    **more
        ``direction`` (degrees), ``amplitude`` and ``level`` of `FilmedCase`.
    """
    height, width = block["height"], block["height"] * block["b_over_h"]
    given = {"width": width, "height": height, "friction": block["friction"], "place": place, **more}
    if isinstance(model, Body):
        return FilmedCase(**_stone_of_body(model.shape, width, block.get("aspect", 1.0)), in_space=True, **given)
    assert isinstance(model, PlanarModel)
    return FilmedCase(**(given | _stone_of_scene(model.scene)))


def _stone_of_scene(scene: Scene) -> dict[str, Any]:
    """Return the kind of stone of a scene; a scene of its own friction states none."""
    own = {} if scene.varies_friction else {"friction": None}
    if scene.is_single_block and scene.name == "gravestone":
        return {"kind": "stone", **own}
    return {"kind": "scene", "scene": scene.title or scene.name, "element": scene.reference_name, **own}


def _stone_of_body(shape: Shape, width: float, aspect: float) -> dict[str, Any]:
    """Return the kind of stone of a 3-D body."""
    if isinstance(shape, RectangularPrism):
        return {"kind": "square"} if aspect == 1.0 else {"kind": "oblong", "depth": aspect * width}
    if isinstance(shape, Cylinder):
        return {"kind": "round"}
    return {"kind": "prism", "sides": shape.sides} if isinstance(shape, RegularPrism) else {"kind": "solid"}
