"""Explorer page of a cube: a map of each block, the outcome of the selected cell, and the command that films it."""

import base64
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.colors import to_hex
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.figures.cells import azimuth_edges, cell_edges, close_circle, trim_empty_rings
from overturning.figures.maps import COLOURS
from overturning.figures.page import embedded_json, page, template
from overturning.figures.style import DARKEST, FALLS, FAULT, MISSING, OTHER_SIDE, STANDS
from overturning.files import write_text
from overturning.labels import variant_label
from overturning.model.falls import model_of
from overturning.model.planes import fall_probability, period_of
from overturning.model.symmetry import PLANE_PERIOD
from overturning.study.cube import shown_block, study_of
from overturning.study.film_options import film_options
from overturning.study.preflight import MAX_CELLS_PER_PAGE
from overturning.study.scenes import scene_of
from overturning.study.schema import Study

if TYPE_CHECKING:
    import xarray as xr

PROBABILITY_STEPS: Final = 240
"""Number of steps of a probability from 0 to 1 in the page's data, in which the largest integer means missing.

Shares of 8, 16 and 24 runs are represented exactly. Other shares are rounded, but only 0 becomes 0 and only 1
becomes 1.
"""

_TIME_STEP: Final = 1e-2
"""Smallest step of times, s."""

_AZIMUTH_STEP: Final = 1e-2
"""Step of azimuths, degrees."""

_ROTATION: Final = {"azimuth": "peak_rotation", "orientation": "peak_tilt"}
"""Name of the rotation variable, by the direction of the model."""

_ALPHA_STEP: Final = 1e-3
"""Step of rotations in units of the critical angle α."""

_DEGREE_STEP: Final = 1e-2
"""Step of rotations in degrees."""

_HUES: Final = 72
"""Number of colours for the azimuths of falls."""


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
        Study whose `figures` settings choose the block shown first; by default `shown_block` chooses it.

    Returns
    -------
    dict
        Data of the page. The cells of a record are base64-encoded integers over direction (the full circle for a 2-D
        cube), height, B/H, aspect, friction and element.
    """
    one = cube if "element" in cube.dims else cube.expand_dims(element=[""], axis=-1)
    one = one if "aspect" in one.dims else one.expand_dims(aspect=[1.0])
    model, records, longest = model_of(cube), [], 0.0
    degrees = _rotations_in_degrees(cube, one.sizes["element"])
    turn_step = _DEGREE_STEP if any(degrees) else _ALPHA_STEP
    names = [one[name].to_numpy().astype(str).tolist() for name in ("record_id", "station", "event")]
    for index, (key, station, event) in enumerate(zip(*names, strict=True)):
        part = one.isel(record=[index]).load()
        part = close_circle(part) if model.one_component else part
        cells, rings = _cells(part, turn_step)
        longest = float(np.fmax(longest, part["overturning_time"].max()))
        name = ", ".join(text for text in (station, event) if text) or key
        normal = float(part["fault_normal"][0])
        about = {"id": key, "name": name, "normal": None if np.isnan(normal) else round(normal, 6), "rings": rings}
        if store_cells is None:
            about["cells"] = cells
        else:
            store_cells(index, cells)
        records.append(about)
    sized = {name: part[name].to_numpy().astype(np.float64) for name in (model.direction, "b_over_h")}
    if model.one_component:
        edges = azimuth_edges(sized["azimuth"])
    else:
        turn = sized["orientation"]
        edges = cell_edges(turn) if turn.size > 1 else turn + np.array([-2.5, 2.5])
    return {
        "title": _title(one),
        "space": not model.one_component,
        "mirrors": not model.one_component or period_of(cube) == PLANE_PERIOD,
        "records": records,
        "direction": _plain(sized[model.direction]),
        **{name: _plain(one[name].to_numpy()) for name in ("height", "b_over_h", "aspect", "friction")},
        "element": [str(name) for name in one["element"].to_numpy()],
        "shown": _initial_selection(one, study),
        "degrees": degrees,
        "directionEdges": _plain(edges),
        "radiusEdges": _plain(cell_edges(sized["b_over_h"])),
        "steps": {"rotation": turn_step, "azimuth": _AZIMUTH_STEP, "chance": 1 / PROBABILITY_STEPS},
        "longest": longest,
        "ensemble": "probability_towards" in one or "probability_falls" in one,
        "film": film_options(cube),
        "colours": {
            "falls": FALLS, "other": OTHER_SIDE, "stands": STANDS, "missing": MISSING, "fault": FAULT,
            "darkest": DARKEST, "azimuths": [to_hex(COLOURS((place + 0.5) / _HUES)) for place in range(_HUES)],
        },
    }  # fmt: skip


def _title(one: "xr.Dataset") -> str:
    """Return the title of the page: study, variant, and the element to which heights and B/H refer."""
    return ", ".join(filter(None, [str(one.attrs.get("title", "")), *variant_label(one), *_reference_note(one)]))


def _initial_selection(one: "xr.Dataset", study: Study | None) -> dict[str, int]:
    """Return the indices of the height, friction and element shown first: those that the report shows."""
    names = one["element"].to_numpy().tolist()
    element = scene_of(study_of(one), one.attrs["variant"]).default_element if len(names) > 1 else names[0]
    block = {name: one[name].to_numpy().tolist().index(value) for name, (value,) in shown_block(one, study).items()}
    return {"height": 0, "friction": one.sizes["friction"] - 1, **block, "element": names.index(element)}


def _reference_note(one: "xr.Dataset") -> list[str]:
    """Return a note that names the element to which heights and B/H refer; empty for a cube of one element."""
    if one.sizes["element"] == 1:
        return []
    return [f"H and B/H of the {scene_of(study_of(one), one.attrs['variant']).reference_name}"]


def _rotations_in_degrees(cube: "xr.Dataset", elements: int) -> list[bool]:
    """Return a flag per element: True if rotations are in degrees (3-D bodies, elements without critical angle)."""
    if "critical_angle" not in cube:
        return elements * [not model_of(cube).one_component]
    unknown = cube["critical_angle"].isnull()
    return list(np.atleast_1d(unknown.any([name for name in unknown.dims if name != "element"]).to_numpy()).tolist())


def _cells(one: "xr.Dataset", turn_step: float) -> tuple[dict[str, Any], int]:
    """Return the encoded cells of one record, with rotations in units of `turn_step`, and its number of B/H rings."""
    model = model_of(one)
    order = (model.direction, "height", "b_over_h", "aspect", "friction", "element")

    def values(found: "xr.DataArray") -> FloatArray:
        return np.asarray(found.isel(record=0).transpose(*order).to_numpy(), dtype=np.float64)

    chance = fall_probability(one)
    ensemble = one.get("probability_falls", one.get("probability_towards"))
    if "probability_falls" in one:
        chance["towards"] = one["probability_falls"].fillna(chance["towards"])
    # The probability is missing where the ensemble was not run: the map then shows the flag of the cell itself.
    known = chance if ensemble is None else chance.where(ensemble.notnull())
    time = values(one["overturning_time"])
    time_step = max(_TIME_STEP, float(np.nanmax(time, initial=0.0)) / (np.iinfo("<u2").max - 1))  # 16 bits must hold it
    cells = {
        "flag": _base64(np.nan_to_num(values(one["overturned"]), nan=2.0).astype("i1")),
        "rotation": _packed(values(one[_ROTATION[model.direction]]), turn_step, "<u2"),
        "time": _packed(time, time_step, "<u2"),
        "timeStep": time_step,
        **{
            name: _packed(_clip_away_from_certainty(values(known[name])), 1 / PROBABILITY_STEPS, "u1")
            for name in ("towards", "away")
        },
    }
    if not model.one_component:
        cells["azimuth"] = _packed(values(one["fall_azimuth"]), _AZIMUTH_STEP, "<u2")
    shown = trim_empty_rings(one, chance["towards"] + chance["away"], abs(one["overturned"]))
    return cells, shown.sizes["b_over_h"]


def _plain(values: NDArray[Any]) -> list[float]:
    return [round(float(value), 9) for value in values]


def _base64(values: NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")


def _packed(values: FloatArray, step: float, kind: str) -> str:
    """Return values as base64-encoded integers in units of `step`.

    The largest integer stands for missing; larger values are clipped to the second largest.
    """
    largest = np.iinfo(kind).max
    whole = np.where(np.isnan(values), largest, np.minimum(np.rint(np.nan_to_num(values) / step), largest - 1))
    return _base64(whole.astype(kind))


def _clip_away_from_certainty(chance: FloatArray) -> FloatArray:
    """Clip probabilities between 0 and 1 by one of `PROBABILITY_STEPS`, so that rounding does not make them certain."""
    return np.where(
        (chance > 0) & (chance < 1), np.clip(chance, 1 / PROBABILITY_STEPS, 1 - 1 / PROBABILITY_STEPS), chance
    )


def explorer_page(data: dict[str, Any]) -> str:
    """Return the explorer page (HTML) for `explorer_data`; it is reproducible and loads only files of the records."""
    script = "".join(map(template, ("page.js", "explore_maps.js", "explore.js")))
    return page("explore.html.j2", template("explore.css"), script, data, title=data["title"])


def write_explorer(cube: "xr.Dataset", path: Path, study: Study | None = None) -> None:
    """Write the explorer page of a cube to a .html file.

    If the cube has more than `MAX_CELLS_PER_PAGE` cells, those of each record go into a separate file,
    ``NAME-records/0.js`` and so on next to ``NAME.html``, which the page loads when the record is selected. See
    `explorer_data` for the study.
    """
    if cube["overturned"].size <= MAX_CELLS_PER_PAGE:
        write_text(path, explorer_page(explorer_data(cube, study=study)))
        return
    folder = path.with_name(f"{path.stem}-records")

    def store_cells(index: int, cells: dict[str, Any]) -> None:
        write_text(folder / f"{index}.js", f"explorerRecord({index},{embedded_json(cells)});\n")

    data = explorer_data(cube, store_cells, study)
    write_text(path, explorer_page({**data, "folder": folder.name}))
