"""Explorer page of a cube: a map of each block, the outcome of the selected cell, and the command that films it."""

import base64
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from matplotlib.colors import to_hex
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.figures.maps import COLOURS, azimuth_edges, cell_edges, closed, out_to_the_first_ring_without_falls
from overturning.figures.page import embedded_json, page, template
from overturning.figures.style import DARKEST, FALLS, FAULT, MISSING, OTHER_SIDE, STANDS
from overturning.files import write_text
from overturning.model.falls import model_of
from overturning.model.planes import fall_probability, period_of
from overturning.model.symmetry import PLANE_PERIOD
from overturning.study.cube import shown_block, study_of, variant_said
from overturning.study.film_options import film_options
from overturning.study.preflight import MOST_CELLS
from overturning.study.scenes import scene_of
from overturning.study.schema import Study

if TYPE_CHECKING:
    import xarray as xr

PARTS_OF_ONE: Final = 240
"""Probabilities are whole numbers of such parts, rotations and times as below; the largest number means missing.

Shares of 8, 16 and 24 runs are such numbers; of others only 0 is no part, and only 1 all of them.
"""

_TIME: Final = 1e-2  # s, at least
_AZIMUTH: Final = 1e-2  # degrees
_ROTATION: Final = {"azimuth": "peak_rotation", "orientation": "peak_tilt"}
_OF_ALPHA: Final = 1e-3
_DEGREES: Final = 1e-2
_HUES: Final = 72


def explorer_data(
    cube: "xr.Dataset",
    apart: Callable[[int, dict[str, Any]], None] | None = None,
    study: Study | None = None,
) -> dict[str, Any]:
    """What the page needs of a cube with all elements or one, as plain data for JSON.

    Parameters
    ----------
    cube : Dataset
        In planes or in space; loaded a record at a time.
    apart : callable, optional
        Is given the number and the cells of each record, which then are not in the data.
    study : Study, optional
        Whose `figures` name the block that is shown first; not given: as `shown_block` has it.

    Returns
    -------
    dict
        Each record's cells are base64 of small whole numbers, over direction (round the compass in planes), height,
        B/H, aspect, friction and element.
    """
    one = cube if "element" in cube.dims else cube.expand_dims(element=[""], axis=-1)
    one = one if "aspect" in one.dims else one.expand_dims(aspect=[1.0])
    model, records, longest = model_of(cube), [], 0.0
    degrees = _in_degrees(cube, one.sizes["element"])
    turn_step = _DEGREES if any(degrees) else _OF_ALPHA
    names = [one[name].to_numpy().astype(str).tolist() for name in ("record_id", "station", "event")]
    for index, (key, station, event) in enumerate(zip(*names, strict=True)):
        part = one.isel(record=[index]).load()
        part = closed(part) if model.one_component else part
        cells, rings = _cells(part, turn_step)
        longest = float(np.fmax(longest, part["overturning_time"].max()))
        name = ", ".join(text for text in (station, event) if text) or key
        normal = float(part["fault_normal"][0])
        about = {"id": key, "name": name, "normal": None if np.isnan(normal) else round(normal, 6), "rings": rings}
        if apart is None:
            about["cells"] = cells
        else:
            apart(index, cells)
        records.append(about)
    sized = {name: part[name].to_numpy().astype(np.float64) for name in (model.direction, "b_over_h")}
    if model.one_component:
        edges = azimuth_edges(sized["azimuth"])
    else:
        turn = sized["orientation"]
        edges = cell_edges(turn) if turn.size > 1 else turn + np.array([-2.5, 2.5])
    return {
        "title": ", ".join(filter(None, [str(cube.attrs.get("title", "")), *variant_said(cube), *_whose(one)])),
        "space": not model.one_component,
        "mirrors": not model.one_component or period_of(cube) == PLANE_PERIOD,
        "records": records,
        "direction": _plain(sized[model.direction]),
        **{name: _plain(one[name].to_numpy()) for name in ("height", "b_over_h", "aspect", "friction")},
        "element": [str(name) for name in one["element"].to_numpy()],
        "shown": _shown(one, study),
        "degrees": degrees,
        "directionEdges": _plain(edges),
        "radiusEdges": _plain(cell_edges(sized["b_over_h"])),
        "steps": {"rotation": turn_step, "azimuth": _AZIMUTH, "chance": 1 / PARTS_OF_ONE},
        "longest": longest,
        "ensemble": "probability_towards" in one or "probability_falls" in one,
        "film": film_options(cube),
        "colours": {
            "falls": FALLS, "other": OTHER_SIDE, "stands": STANDS, "missing": MISSING, "fault": FAULT,
            "darkest": DARKEST, "azimuths": [to_hex(COLOURS((place + 0.5) / _HUES)) for place in range(_HUES)],
        },
    }  # fmt: skip


def _shown(one: "xr.Dataset", study: Study | None) -> dict[str, int]:
    """The places of height, friction and element that are shown first: those that the report shows."""
    names = one["element"].to_numpy().tolist()
    element = scene_of(study_of(one), one.attrs["variant"]).default_element if len(names) > 1 else names[0]
    block = {name: one[name].to_numpy().tolist().index(value) for name, (value,) in shown_block(one, study).items()}
    return {"height": 0, "friction": one.sizes["friction"] - 1, **block, "element": names.index(element)}


def _whose(one: "xr.Dataset") -> list[str]:
    """Of which element the heights and B/H are, of a cube of several."""
    if one.sizes["element"] == 1:
        return []
    return [f"H and B/H of the {scene_of(study_of(one), one.attrs['variant']).reference_name}"]


def _in_degrees(cube: "xr.Dataset", elements: int) -> list[bool]:
    """Of each element, whether its rotations are in degrees: a body's, and of what has no critical angle of its own."""
    if "critical_angle" not in cube:
        return elements * [not model_of(cube).one_component]
    unknown = cube["critical_angle"].isnull()
    return list(np.atleast_1d(unknown.any([name for name in unknown.dims if name != "element"]).to_numpy()).tolist())


def _cells(one: "xr.Dataset", turn_step: float) -> tuple[dict[str, Any], int]:
    """The cells of one record, packed, rotations in such steps, and the number of rings (of B/H) of its map."""
    model = model_of(one)
    order = (model.direction, "height", "b_over_h", "aspect", "friction", "element")

    def values(found: "xr.DataArray") -> FloatArray:
        return np.asarray(found.isel(record=0).transpose(*order).to_numpy(), dtype=np.float64)

    chance = fall_probability(one)
    ensemble = one.get("probability_falls", one.get("probability_towards"))
    if "probability_falls" in one:
        chance["towards"] = one["probability_falls"].fillna(chance["towards"])
    # Of a neighbourhood that was not run nothing is known, and the map has the cell's own flag in its place.
    known = chance if ensemble is None else chance.where(ensemble.notnull())
    time = values(one["overturning_time"])
    time_step = max(_TIME, float(np.nanmax(time, initial=0.0)) / (np.iinfo("<u2").max - 1))  # of an hour, too
    cells = {
        "flag": _base64(np.nan_to_num(values(one["overturned"]), nan=2.0).astype("i1")),
        "rotation": _packed(values(one[_ROTATION[model.direction]]), turn_step, "<u2"),
        "time": _packed(time, time_step, "<u2"),
        "timeStep": time_step,
        **{name: _packed(_told(values(known[name])), 1 / PARTS_OF_ONE, "u1") for name in ("towards", "away")},
    }
    if not model.one_component:
        cells["azimuth"] = _packed(values(one["fall_azimuth"]), _AZIMUTH, "<u2")
    shown = out_to_the_first_ring_without_falls(one, chance["towards"] + chance["away"], abs(one["overturned"]))
    return cells, shown.sizes["b_over_h"]


def _plain(values: NDArray[Any]) -> list[float]:
    return [round(float(value), 9) for value in values]


def _base64(values: NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")


def _packed(values: FloatArray, step: float, kind: str) -> str:
    """Values in whole steps; what is missing, or too large, as the largest number there is."""
    largest = np.iinfo(kind).max
    whole = np.where(np.isnan(values), largest, np.minimum(np.rint(np.nan_to_num(values) / step), largest - 1))
    return _base64(whole.astype(kind))


def _told(chance: FloatArray) -> FloatArray:
    """Probabilities that are told from 0 and 1 in parts of `PARTS_OF_ONE`."""
    return np.where((chance > 0) & (chance < 1), np.clip(chance, 1 / PARTS_OF_ONE, 1 - 1 / PARTS_OF_ONE), chance)


def explorer_page(data: dict[str, Any]) -> str:
    """The page (HTML) from `explorer_data`, the same each time; it needs nothing but the records' files, if any."""
    script = "".join(map(template, ("page.js", "explore_maps.js", "explore.js")))
    return page("explore.html.j2", template("explore.css"), script, data, title=data["title"])


def write_explorer(cube: "xr.Dataset", path: Path, study: Study | None = None) -> None:
    """Write the page of a cube to a .html file.

    Of more than `MOST_CELLS` cells those of each record go to a file of their own, ``NAME-records/0.js`` and so on
    beside ``NAME.html``, which the page loads when the record is chosen. See `explorer_data`
    for the study.
    """
    if cube["overturned"].size <= MOST_CELLS:
        write_text(path, explorer_page(explorer_data(cube, study=study)))
        return
    folder = path.with_name(f"{path.stem}-records")

    def apart(index: int, cells: dict[str, Any]) -> None:
        write_text(folder / f"{index}.js", f"explorerRecord({index},{embedded_json(cells)});\n")

    data = explorer_data(cube, apart, study)
    write_text(path, explorer_page({**data, "folder": folder.name}))
