"""A cube as one self-contained page: a polar map of each block, and what is known of the cell pointed at."""

import base64
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.figures.maps import azimuth_edges, cell_edges, closed
from overturning.figures.page import page, template
from overturning.figures.style import DARKEST, FALLS, FAULT, MISSING, OTHER_SIDE, STANDS
from overturning.files import write_text
from overturning.model.planes import fall_probability
from overturning.study.preflight import MOST_CELLS

if TYPE_CHECKING:
    import xarray as xr

DIMENSIONS = ("record", "azimuth", "height", "b_over_h", "friction", "element")

PARTS_OF_ONE = 200
"""Probabilities are whole numbers of such parts, rotations and times as below; the largest number means missing."""

_ROTATION, _TIME = 1e-3, 1e-2  # of α; s


def explorer_data(cube: "xr.Dataset") -> dict[str, Any]:
    """What the page needs of a cube with all elements or one, as plain data for JSON.

    Arrays over `DIMENSIONS` are base64 of small whole numbers. An `ArgumentError` refuses more than `MOST_CELLS` cells.
    """
    one = cube if "element" in cube.dims else cube.expand_dims(element=[""], axis=-1)
    if one["overturned"].size > MOST_CELLS:
        raise ArgumentError(
            f"{one['overturned'].size:,} cells are too many for a page, at most {MOST_CELLS:,}; choose records with "
            "--record"
        )

    one = closed(one.load())
    chance = fall_probability(one)

    def values(name: str) -> FloatArray:
        found = chance if name in chance else one
        return np.asarray(found[name].transpose(*DIMENSIONS).to_numpy(), dtype=np.float64)

    names = [one[name].to_numpy().astype(str).tolist() for name in ("record_id", "station", "event")]
    return {
        "title": str(cube.attrs.get("title", "")),
        "records": [
            {"id": key, "name": ", ".join(text for text in (station, event) if text) or key, "normal": normal}
            for key, station, event, normal in zip(*names, _known(one["fault_normal"].to_numpy()), strict=True)
        ],
        **{name: _plain(one[name].to_numpy()) for name in ("azimuth", "height", "b_over_h", "friction")},
        "element": [str(name) for name in one["element"].to_numpy()],
        "azimuthEdges": _plain(azimuth_edges(one["azimuth"].to_numpy().astype(np.float64))),
        "radiusEdges": _plain(cell_edges(one["b_over_h"].to_numpy().astype(np.float64))),
        "steps": {"rotation": _ROTATION, "time": _TIME, "chance": 1 / PARTS_OF_ONE},
        "ensemble": "probability_towards" in one,
        "colours": {
            "falls": FALLS, "other": OTHER_SIDE, "stands": STANDS, "missing": MISSING, "fault": FAULT,
            "darkest": DARKEST,
        },
        "data": {
            "flag": _base64(np.nan_to_num(values("overturned"), nan=2.0).astype("i1")),
            "rotation": _packed(values("peak_rotation"), _ROTATION, "<u2"),
            "time": _packed(values("overturning_time"), _TIME, "<u2"),
            **{name: _packed(values(name), 1 / PARTS_OF_ONE, "u1") for name in ("towards", "away")},
        },
    }  # fmt: skip


def _plain(values: NDArray[Any]) -> list[float]:
    return [round(float(value), 9) for value in values]


def _known(values: NDArray[Any]) -> list[float | None]:
    return [None if np.isnan(value) else round(float(value), 6) for value in values.astype(np.float64)]


def _base64(values: NDArray[Any]) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode("ascii")


def _packed(values: FloatArray, step: float, kind: str) -> str:
    """Values in whole steps; what is missing, or too large, as the largest number there is."""
    largest = np.iinfo(kind).max
    whole = np.where(np.isnan(values), largest, np.minimum(np.rint(np.nan_to_num(values) / step), largest - 1))
    return _base64(whole.astype(kind))


def explorer_page(data: dict[str, Any]) -> str:
    """The page (HTML) from `explorer_data`, which needs nothing from outside; the same each time."""
    return page("explore.html.j2", template("explore.css"), template("explore.js"), data, title=data["title"])


def write_explorer(cube: "xr.Dataset", path: Path) -> None:
    """Write the page of a cube to a .html file."""
    write_text(path, explorer_page(explorer_data(cube)))
