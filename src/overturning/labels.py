"""Labels and notes that describe a cube in figures, reports and printed lines."""

from typing import TYPE_CHECKING

import numpy as np

from overturning.model.plane_weights import mask_of_azimuths_before_gap_and_grid_step, plane_azimuth_period_deg
from overturning.study.cube import element_name_to_show, parse_json_attribute, study_of_cube
from overturning.study.scenes import (
    NAME_OF_STUDY_ITSELF_AMONG_VARIANTS,
    note_on_different_stone_size_of_variant,
    variant_scene,
)
from overturning.study.schema import Study

if TYPE_CHECKING:
    import xarray as xr


def friction_label(cube_or_study: "xr.Dataset | Study", friction: float) -> str:
    """Return the label of a friction coefficient for titles: "µ = 0.6", or "µ of the scene".

    Parameters
    ----------
    cube_or_study : Dataset or Study
        Cube or study that the coefficient belongs to. A cube without a study is labelled as a single block, "µ = …".
    friction : float
        Friction coefficient, a value of the dimension ``friction`` of the cube.
    """
    study, variant = None, NAME_OF_STUDY_ITSELF_AMONG_VARIANTS
    if isinstance(cube_or_study, Study):
        study = cube_or_study
    elif "study" in cube_or_study.attrs:
        study, variant = study_of_cube(cube_or_study), cube_or_study.attrs["variant"]
    scene_has_own = (
        study is not None and study.body is None and not variant_scene(study, variant).has_contact_with_unset_friction
    )
    return "µ of the scene" if scene_has_own else f"µ = {friction:g}"


def variant_label_in_list_if_not_nominal(cube: "xr.Dataset") -> list[str]:
    """Return the label of a cube's variant for titles, in a list such as ["variant soil"].

    A variant is a study with changed settings. The list is empty for a cube of the study itself or without a study.
    """
    name = str(cube.attrs.get("variant", NAME_OF_STUDY_ITSELF_AMONG_VARIANTS))
    if name == NAME_OF_STUDY_ITSELF_AMONG_VARIANTS:
        return []
    sizes = note_on_different_stone_size_of_variant(study_of_cube(cube), name)
    return [f"variant {name}{f' ({sizes})' if sizes else ''}"]


def note_if_sizes_are_not_those_of_shown_stone(cube: "xr.Dataset") -> str:
    """Return a note if the cube's coordinates height and B/H are not those of the stone shown; otherwise ""."""
    study, variant = study_of_cube(cube), cube.attrs["variant"]
    reference = variant_scene(study, variant).size_reference_element_name
    if element_name_to_show(cube) != reference:
        return f"H and B/H are those of the {reference}, not of the {element_name_to_show(cube)}"
    return note_on_different_stone_size_of_variant(study, variant)


def earthquake_assignment_notes(cube: "xr.Dataset") -> list[str]:
    """Return notes on earthquakes to which records give different names, and on doubtful assignments of records."""
    return list(parse_json_attribute(cube, "earthquakes", list)) if "earthquakes" in cube.attrs else []


def unsimulated_azimuth_ranges_deg(cube: "xr.Dataset") -> list[tuple[float, float]]:
    """Return start and end, degrees, of the azimuth ranges without simulations; empty for a full circle."""
    if "azimuth" not in cube.dims:
        return []
    period = plane_azimuth_period_deg(cube)
    planes = np.unique(cube["azimuth"].to_numpy().astype(np.float64) % period)
    following = np.append(planes[1:], planes[:1] + period)
    ranges = zip(
        planes.tolist(), following.tolist(), mask_of_azimuths_before_gap_and_grid_step(planes, period)[0], strict=True
    )
    return [(begin, end) for begin, end, missing in ranges if missing]


def unsimulated_azimuth_ranges_text(cube: "xr.Dataset") -> str:
    """Return the azimuth ranges without simulations as text: "between 90° and 180°"; "" for a full circle."""
    return " or ".join(f"between {begin:g}° and {end:g}°" for begin, end in unsimulated_azimuth_ranges_deg(cube))
