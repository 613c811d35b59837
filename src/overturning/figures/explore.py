"""Explorer page of a cube: a map of each block, the outcome of the selected cell, and the command that films it."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.colors import to_hex
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.figures.cells import (
    azimuth_edges,
    cell_edges,
    close_circle,
    simulated_azimuths,
    slenderness_edges,
    trim_empty_rings,
)
from overturning.figures.explore_cells import (
    ALPHA_STEP,
    AZIMUTH_STEP,
    DEGREE_STEP,
    PROBABILITY_STEPS,
    choose_initial_case,
    encode_cells,
    ensemble_probabilities,
    fall_probabilities_to_show,
)
from overturning.figures.maps import COLOURS
from overturning.figures.page import json_for_script, read_template, render_page
from overturning.figures.style import FAULT, HATCH_COLOUR, MISSING, PROBABILITY, STANDS
from overturning.files import write_text
from overturning.labels import variant_label
from overturning.model.falls import model_of_cube
from overturning.model.planes import azimuth_period_of_cube_deg
from overturning.model.symmetry import PLANE_PERIOD
from overturning.study.cube import first_shown_height_and_friction, study_for_presentation, study_of_cube
from overturning.study.film_options import film_command_options
from overturning.study.preflight import MAX_CELLS_PER_PAGE
from overturning.study.scenes import variant_scene
from overturning.study.schema import Study
from overturning.translation.texts import ENGLISH, current_language, read_table, translate

if TYPE_CHECKING:
    import xarray as xr

_HUES: Final = 72
"""Number of colours for the azimuths of falls."""

_SCRIPTS: Final = (
    "page.js",
    "explore_cells.js",
    "explore_maps.js",
    "explore_colours.js",
    "explore_address.js",
    "explore.js",
)


def explorer_data(
    cube: "xr.Dataset",
    store_cells: Callable[[int, dict[str, Any]], None] | None = None,
    study: Study | None = None,
) -> dict[str, Any]:
    """Return the data of the explorer page for a cube, ready for JSON.

    Parameters
    ----------
    cube : Dataset
        2-D or 3-D cube, with all elements or one; loaded one record at a time.
    store_cells : callable, optional
        Function that receives the number and the cells of each record and stores them; the returned data then does not
        contain them.
    study : Study, optional
        Study whose title, question and `figures` the page shows; by default the `study_for_presentation`.

    Returns
    -------
    dict
        Data of the page. The cells of a record are base64-encoded integers over direction (the full circle for a 2-D
        cube), height, B/H, aspect, friction and element.
    """
    one = cube if "element" in cube.dims else cube.expand_dims(element=[""], axis=-1)
    one = one if "aspect" in one.dims else one.expand_dims(aspect=[1.0])
    model, study = model_of_cube(cube), study_for_presentation(cube, study)
    degrees = _has_rotation_in_degrees(cube, one.sizes["element"])
    turn_step = DEGREE_STEP if any(degrees) else ALPHA_STEP
    first, options = _initial_selection(one, study), film_command_options(cube)
    records, rings, clear = [], 1, []
    for index in range(one.sizes["record"]):
        part = one.isel(record=[index]).load()
        part = close_circle(part) if model.one_component else part
        chance = fall_probabilities_to_show(part)
        shown = trim_empty_rings(part, chance["towards"] + chance["away"], abs(part["overturned"]))
        rings = max(rings, shown.sizes["b_over_h"])
        clear.append(choose_initial_case(part.isel({"record": 0, "aspect": 0, **first}), model.one_component))
        about, cells = {**_record_metadata(part), "clear": clear[-1].cell}, encode_cells(part, chance, turn_step)
        if store_cells is None:
            about["cells"] = cells
        else:
            store_cells(index, cells)
        records.append(about)
    direction = part[model.direction].to_numpy().astype(np.float64)
    return {
        "title": _page_title(one, study),
        "question": translate(study.question) if study else "",
        "space": not model.one_component,
        "mirrors": not model.one_component or azimuth_period_of_cube_deg(cube) == PLANE_PERIOD,
        "records": records,
        "rings": rings,
        "direction": _json_list(direction),
        "computed": np.isin(direction, simulated_azimuths(cube) if model.one_component else direction).tolist(),
        **{name: _json_list(one[name].to_numpy()) for name in ("height", "b_over_h", "aspect", "friction")},
        "element": [str(name) for name in one["element"].to_numpy()],
        "shown": {"record": max(range(len(clear)), key=lambda k: clear[k].clarity), "aspect": 0, **first},
        "degrees": degrees,
        "directionEdges": _json_list(_direction_edges(direction, model.one_component)),
        "radiusEdges": _json_list(slenderness_edges(part["b_over_h"].to_numpy().astype(np.float64))),
        "steps": {"rotation": turn_step, "azimuth": AZIMUTH_STEP, "chance": 1 / PROBABILITY_STEPS},
        "ensemble": ensemble_probabilities(one) is not None,
        "film": options | {"missing": translate(options["missing"])},
        "colours": {
            "probability": PROBABILITY, "stands": STANDS, "hatch": HATCH_COLOUR, "missing": MISSING, "fault": FAULT,
            "azimuths": [to_hex(COLOURS((place + 0.5) / _HUES)) for place in range(_HUES)],
        },
        **_page_words(one),
    }  # fmt: skip


def _page_words(cube: "xr.Dataset") -> dict[str, dict[str, str]]:
    """Return the words of the page in the current language, as an entry of its data; none for English."""
    if (language := current_language()) == ENGLISH:
        return {}
    elements = {name: translate(name) for name in cube["element"].to_numpy().astype(str).tolist()}
    return {"words": elements | read_table(language, "explorer")}


def _record_metadata(record_cube: "xr.Dataset") -> dict[str, Any]:
    """Return id, name, fault normal (degrees) and range of the times of falls (s) of the record of a dataset."""
    key, station, event = (str(record_cube[name].item()) for name in ("record_id", "station", "event"))
    normal, times = float(record_cube["fault_normal"][0]), record_cube["overturning_time"].to_numpy().astype(np.float64)
    return {
        "id": key,
        "name": ", ".join(text for text in (station, event) if text) or key,
        "normal": None if np.isnan(normal) else round(normal, 6),
        "times": _json_list(np.array([np.nanmin(times), np.nanmax(times)])) if np.isfinite(times).any() else None,
    }


def _json_list(values: NDArray[Any]) -> list[float]:
    """Convert an array to a list of Python values for JSON."""
    return [round(float(value), 9) for value in values]


def _direction_edges(direction: FloatArray, planar: bool) -> FloatArray:
    """Return the edges of the cells along the direction: radians of azimuths, degrees of orientations."""
    if planar:
        return azimuth_edges(direction)
    return cell_edges(direction) if direction.size > 1 else direction + np.array([-2.5, 2.5])


def _page_title(cube: "xr.Dataset", study: Study | None) -> str:
    """Return the title of the page: study, variant, and the element to which heights and B/H refer."""
    title = (study.title if study else "") or str(cube.attrs.get("title", ""))
    parts = filter(None, [title, *variant_label(cube), *_reference_note(cube)])
    return translate(", ").join(map(translate, parts))


def _initial_selection(cube: "xr.Dataset", study: Study | None) -> dict[str, int]:
    """Return the indices of the height, friction and element shown first: those that the report shows."""
    names = cube["element"].to_numpy().tolist()
    element = (
        variant_scene(study_of_cube(cube), cube.attrs["variant"]).default_output_element if len(names) > 1 else names[0]
    )
    block = {
        name: cube[name].to_numpy().tolist().index(value)
        for name, (value,) in first_shown_height_and_friction(cube, study).items()
    }
    return {"height": 0, "friction": cube.sizes["friction"] - 1, **block, "element": names.index(element)}


def _reference_note(cube: "xr.Dataset") -> list[str]:
    """Return a note that names the element to which heights and B/H refer; empty for a cube of one element."""
    if cube.sizes["element"] == 1:
        return []
    return [f"H and B/H of the {variant_scene(study_of_cube(cube), cube.attrs['variant']).reference_name}"]


def _has_rotation_in_degrees(cube: "xr.Dataset", element_count: int) -> list[bool]:
    """Return a flag per element: True if rotations are in degrees (3-D bodies, elements without critical angle)."""
    if "critical_angle" not in cube:
        return element_count * [not model_of_cube(cube).one_component]
    unknown = cube["critical_angle"].isnull()
    return list(np.atleast_1d(unknown.any([name for name in unknown.dims if name != "element"]).to_numpy()).tolist())


def explorer_page(data: dict[str, Any], report: str = "") -> str:
    """Return the explorer page (HTML) for `explorer_data`; it is reproducible and loads only files of the records.

    Its texts are in the current language, as those of its data. It has a link to a report if the address of one is
    given.
    """
    script = "".join(map(read_template, _SCRIPTS))
    shown = {name: data[name] for name in ("title", "question", "space", "mirrors", "ensemble")}
    shown["language"] = current_language()
    return render_page("explore.html.j2", read_template("explore.css"), script, data, report=report, **shown)


def write_explorer(cube: "xr.Dataset", path: Path, study: Study | None = None, report: str = "") -> None:
    """Write the explorer page of a cube to a .html file.

    If the cube has more than `MAX_CELLS_PER_PAGE` cells, those of each record go into a separate file,
    ``NAME-records/0.js`` and so on next to ``NAME.html``, which the page loads when the record is selected. See
    `explorer_data` for the study, and `explorer_page` for the report.
    """
    if cube["overturned"].size <= MAX_CELLS_PER_PAGE:
        write_text(path, explorer_page(explorer_data(cube, study=study), report))
        return
    folder = path.with_name(f"{path.stem}-records")

    def store_cells(index: int, cells: dict[str, Any]) -> None:
        write_text(folder / f"{index}.js", f"explorerRecord({index},{json_for_script(cells)});\n")

    data = explorer_data(cube, store_cells, study)
    write_text(path, explorer_page({**data, "folder": folder.name}, report))
