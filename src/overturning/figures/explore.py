"""Explorer page of a cube: a map of each block, the outcome of the selected cell, and the command that films it."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.colors import to_hex
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.figures.cells import (
    azimuth_cell_edges_rad,
    azimuths_simulated_or_known_by_symmetry_deg,
    b_over_h_cell_edges,
    cell_edges,
    extend_azimuths_to_full_circle,
    trim_rings_without_falls_except_innermost,
)
from overturning.figures.explore_cells import (
    ENCODED_AZIMUTH_STEP_DEG,
    ENCODED_PROBABILITY_STEP_COUNT,
    ENCODED_ROTATION_STEP_DEG,
    ENCODED_ROTATION_STEP_IN_CRITICAL_ANGLES,
    choose_initial_explorer_case,
    encode_outcomes_of_record,
    ensemble_fall_or_fall_towards_probability,
    explorer_probabilities_towards_and_away,
)
from overturning.figures.film_words import station_and_event_text_of_cube
from overturning.figures.maps import AZIMUTH_COLOURMAP
from overturning.figures.page import json_for_script, read_template_text, render_page_template
from overturning.figures.style import (
    FAULT_COLOUR,
    HATCH_COLOUR,
    MISSING_COLOUR,
    PROBABILITY_COLOUR_STOPS,
    STANDS_COLOUR,
)
from overturning.files import write_text
from overturning.labels import variant_label_in_list_if_not_nominal
from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.model.plane_weights import plane_azimuth_period_deg
from overturning.model.symmetry import PLANE_SYMMETRY_PERIOD_DEG
from overturning.study.cube import (
    default_height_and_friction_of_figures,
    find_study_with_title_and_figure_settings,
    study_of_cube,
)
from overturning.study.film_options import film_command_options_and_stone_sizes
from overturning.study.preflight import MAX_CELLS_OF_SINGLE_EXPLORER_PAGE
from overturning.study.scenes import variant_scene
from overturning.study.schema import Study
from overturning.translation.texts import ENGLISH, current_language, read_translation_table, translate

if TYPE_CHECKING:
    import xarray as xr

_AZIMUTH_COLOUR_COUNT: Final = 72
"""Number of colours for the azimuths of falls."""

_SCRIPT_FILE_NAMES: Final = (
    "page.js",
    "explore_cells.js",
    "explore_maps.js",
    "explore_colours.js",
    "explore_address.js",
    "explore.js",
)


def explorer_page_data(
    cube: "xr.Dataset",
    store_record_cells: Callable[[int, dict[str, Any]], None] | None = None,
    study: Study | None = None,
) -> dict[str, Any]:
    """Return everything that the interactive results page shows, as a dictionary that can be written as JSON.

    Parameters
    ----------
    cube : Dataset
        2-D or 3-D results cube, with one or all elements of a scene; one record at a time is loaded into memory.
    store_record_cells : callable, optional
        Function that receives the index of each record and the encoded outcomes of its cells, and stores them; the
        returned dictionary then does not contain the outcomes.
    study : Study, optional
        Study whose title, question and `figures` the page shows; by default that of
        `find_study_with_title_and_figure_settings`.

    Returns
    -------
    dict
        Data of the page. The outcomes under a record are arrays over direction (the full circle for a 2-D cube),
        height, B/H, aspect, friction and element, as integers in base64 text.
    """
    one = cube if "element" in cube.dims else cube.expand_dims(element=[""], axis=-1)
    one = one if "aspect" in one.dims else one.expand_dims(aspect=[1.0])
    model, study = (
        default_model_of_same_kind_as_results_cube(cube),
        find_study_with_title_and_figure_settings(cube, study),
    )
    degrees = _is_rotation_in_degrees_by_element(cube, one.sizes["element"])
    turn_steps = [
        ENCODED_ROTATION_STEP_DEG if one_in_degrees else ENCODED_ROTATION_STEP_IN_CRITICAL_ANGLES
        for one_in_degrees in degrees
    ]
    first, options = _initial_block_and_element_indices(one, study), film_command_options_and_stone_sizes(cube)
    records, rings, clear = [], 1, []
    for index in range(one.sizes["record"]):
        part = one.isel(record=[index]).load()
        part = extend_azimuths_to_full_circle(part) if model.is_planar else part
        chance = explorer_probabilities_towards_and_away(part)
        shown = trim_rings_without_falls_except_innermost(
            part, chance["towards"] + chance["away"], abs(part["overturned"])
        )
        rings = max(rings, shown.sizes["b_over_h"])
        clear.append(choose_initial_explorer_case(part.isel({"record": 0, "aspect": 0, **first}), model.is_planar))
        about, cells = (
            {**_record_name_fault_normal_and_fall_times(part), "clear": clear[-1].direction_and_b_over_h_indices},
            encode_outcomes_of_record(part, chance, turn_steps),
        )
        if store_record_cells is None:
            about["cells"] = cells
        else:
            store_record_cells(index, cells)
        records.append(about)
    direction = part[model.direction_dimension_name].to_numpy().astype(np.float64)
    return {
        "title": _explorer_title(one, study),
        "question": translate(study.question) if study else "",
        "space": not model.is_planar,
        "mirrors": not model.is_planar or plane_azimuth_period_deg(cube) == PLANE_SYMMETRY_PERIOD_DEG,
        "records": records,
        "rings": rings,
        "direction": _list_with_nine_decimals(direction),
        "computed": np.isin(direction,
        azimuths_simulated_or_known_by_symmetry_deg(cube) if model.is_planar else direction).tolist(),
        **{name: _list_with_nine_decimals(one[name].to_numpy())
           for name in ("height", "b_over_h", "aspect", "friction")},
        "element": [str(name) for name in one["element"].to_numpy()],
        "shown": {"record": max(range(len(clear)), key=lambda k: clear[k].fall_clarity_sort_key), "aspect": 0, **first},
        "degrees": degrees,
        "directionEdges": _list_with_nine_decimals(_azimuth_edges_rad_or_orientation_edges_deg(direction,
        model.is_planar)),
        "radiusEdges": _list_with_nine_decimals(b_over_h_cell_edges(part["b_over_h"].to_numpy().astype(np.float64))),
        "steps": {"rotation": turn_steps, "azimuth": ENCODED_AZIMUTH_STEP_DEG,
        "chance": 1 / ENCODED_PROBABILITY_STEP_COUNT},
        "ensemble": ensemble_fall_or_fall_towards_probability(one) is not None,
        "film": options | {
            "missing": translate(options["missing"]),
            "options": options["options"] + _film_command_language_option_and_value(),
        },
        "colours": {
            "probability": PROBABILITY_COLOUR_STOPS, "stands": STANDS_COLOUR, "hatch": HATCH_COLOUR,
            "missing": MISSING_COLOUR, "fault": FAULT_COLOUR,
            "azimuths": [
                to_hex(AZIMUTH_COLOURMAP((place + 0.5) / _AZIMUTH_COLOUR_COUNT))
                for place in range(_AZIMUTH_COLOUR_COUNT)
            ],
        },
        **_translation_entry_of_page_data(one),
    }  # fmt: skip


def _film_command_language_option_and_value() -> list[str]:
    """Return the command-line words that make `overturning film` use the language of the page; [] for English."""
    return [] if current_language() == ENGLISH else ["--language", current_language()]


def _translation_entry_of_page_data(cube: "xr.Dataset") -> dict[str, dict[str, str]]:
    """Return {"words": translations by English text} as an entry of the page data; {} for an English page."""
    if (language := current_language()) == ENGLISH:
        return {}
    elements = {name: translate(name) for name in cube["element"].to_numpy().astype(str).tolist()}
    return {"words": elements | read_translation_table(language, "explorer")}


def _record_name_fault_normal_and_fall_times(record_cube: "xr.Dataset") -> dict[str, Any]:
    """Return a record's id, name, fault normal (degrees), and times (s) of its earliest and latest fall, as a dict."""
    normal, times = float(record_cube["fault_normal"][0]), record_cube["overturning_time"].to_numpy().astype(np.float64)
    return {
        "id": str(record_cube["record_id"].item()),
        "name": station_and_event_text_of_cube(record_cube),
        "normal": None if np.isnan(normal) else round(normal, 6),
        "times": _list_with_nine_decimals(np.array([np.nanmin(times), np.nanmax(times)]))
        if np.isfinite(times).any()
        else None,
    }


def _list_with_nine_decimals(values: NDArray[Any]) -> list[float]:
    """Return an array of numbers as a list, rounded to nine decimals, for JSON."""
    return [round(float(value), 9) for value in values]


def _azimuth_edges_rad_or_orientation_edges_deg(
    azimuths_or_orientations_deg: FloatArray, is_planar: bool
) -> FloatArray:
    """Return the boundaries between neighbouring direction cells: radians for azimuths, degrees for orientations."""
    if is_planar:
        return azimuth_cell_edges_rad(azimuths_or_orientations_deg)
    return (
        cell_edges(azimuths_or_orientations_deg)
        if azimuths_or_orientations_deg.size > 1
        else azimuths_or_orientations_deg + np.array([-2.5, 2.5])
    )


def _explorer_title(cube: "xr.Dataset", study: Study | None) -> str:
    """Return the title of the interactive page: study, variant, and the element to which height and B/H refer."""
    title = (study.title if study else "") or str(cube.attrs.get("title", ""))
    parts = filter(
        None, [title, *variant_label_in_list_if_not_nominal(cube), *_list_with_note_on_size_reference_element(cube)]
    )
    return translate(", ").join(map(translate, parts))


def _initial_block_and_element_indices(cube: "xr.Dataset", study: Study | None) -> dict[str, int]:
    """Return the indices of the height, friction and scene element that the interactive page shows when it opens."""
    names = cube["element"].to_numpy().tolist()
    element = (
        variant_scene(study_of_cube(cube), cube.attrs["variant"]).name_of_element_shown_by_default
        if len(names) > 1
        else names[0]
    )
    block = {
        name: cube[name].to_numpy().tolist().index(value)
        for name, (value,) in default_height_and_friction_of_figures(cube, study).items()
    }
    return {"height": 0, "friction": cube.sizes["friction"] - 1, **block, "element": names.index(element)}


def _list_with_note_on_size_reference_element(cube: "xr.Dataset") -> list[str]:
    """Return a list with a note that names the scene element to which height and B/H refer; [] for a single element."""
    if cube.sizes["element"] == 1:
        return []
    return [f"H and B/H of the {variant_scene(study_of_cube(cube), cube.attrs['variant']).size_reference_element_name}"]


def _is_rotation_in_degrees_by_element(cube: "xr.Dataset", element_count: int) -> list[bool]:
    """Return, per scene element, True if its rotation is in degrees, False if it is a share of its critical angle."""
    if "critical_angle" not in cube:
        return element_count * [not default_model_of_same_kind_as_results_cube(cube).is_planar]
    unknown = cube["critical_angle"].isnull()
    return list(np.atleast_1d(unknown.any([name for name in unknown.dims if name != "element"]).to_numpy()).tolist())


def explorer_page_html(page_data: dict[str, Any], report_address: str = "") -> str:
    """Return the HTML text of the interactive results page from the dictionary of `explorer_page_data`.

    The same data give the same bytes. The page loads no files except the scripts with the outcomes of single records;
    see `write_explorer`. Its texts are in the current language. With `report_address` it has a link to the report.
    """
    script = "".join(map(read_template_text, _SCRIPT_FILE_NAMES))
    shown = {name: page_data[name] for name in ("title", "question", "space", "mirrors", "ensemble")}
    shown["language"] = current_language()
    return render_page_template(
        "explore.html.j2", read_template_text("explore.css"), script, page_data, report=report_address, **shown
    )


def write_explorer(cube: "xr.Dataset", path: Path, study: Study | None = None, report_address: str = "") -> None:
    """Write the interactive results page of a results cube to a .html file.

    If the cube has more than `MAX_CELLS_OF_SINGLE_EXPLORER_PAGE` cells, the cells of each record go into a separate
    file, ``NAME-records/0.js`` and so on next to ``NAME.html``, which the page loads when the record is selected. For
    `study` see `explorer_page_data`, for `report_address` `explorer_page_html`.
    """
    if cube["overturned"].size <= MAX_CELLS_OF_SINGLE_EXPLORER_PAGE:
        write_text(path, explorer_page_html(explorer_page_data(cube, study=study), report_address))
        return
    folder = path.with_name(f"{path.stem}-records")

    def write_record_script(record_index: int, encoded_cells: dict[str, Any]) -> None:
        """Write the JavaScript file with the outcomes under one record, which the page loads on demand."""
        write_text(folder / f"{record_index}.js", f"explorerRecord({record_index},{json_for_script(encoded_cells)});\n")

    data = explorer_page_data(cube, write_record_script, study)
    write_text(path, explorer_page_html({**data, "folder": folder.name}, report_address))
