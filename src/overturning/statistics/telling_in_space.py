"""Telling cases in space: those that a reader should watch, chosen by rule and not by eye."""

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.arrays import FloatArray

DIMENSIONS = ("record", "orientation", "height", "b_over_h", "aspect", "friction")


@dataclass(frozen=True)
class SpaceCase:
    """One case in space: what it shows and by which rule it was chosen, record (place in the cube) and block."""

    title: str
    rule: str
    record: int
    orientation: float
    height: float
    b_over_h: float
    aspect: float
    friction: float


def telling_in_space(cube: xr.Dataset) -> list[SpaceCase]:
    """The telling cases of a study in space: at most one of each kind, of equals the first."""
    falls, flat = (_values(cube, name) for name in ("overturned", "residual_twist"))
    ratio = np.broadcast_to(cube["b_over_h"].to_numpy()[:, None, None], falls.shape)
    chosen = []
    if "plane_overturned" in cube:
        alone = (falls == 1) & (_values(cube, "plane_overturned") == 0)
        title, rule = "Falls, though both planes of its faces say it stands", "the broadest block that does so"
        chosen.append((title, rule, alone, ratio))
        turn = np.mod(_values(cube, "fall_azimuth") - cube["orientation"].to_numpy()[:, None, None, None, None], 90.0)
        across = (falls == 1) & (np.abs(np.nan_to_num(turn) - 45.0) < 10.0)
        title = "Falls over a corner"
        rule = "the broadest block whose fall lies within 10° of the middle between the normals of two faces"
        chosen.append((title, rule, across, ratio))
    title, rule = "Stands, and has turned", "the block with the largest turn about the vertical of all that stand"
    chosen.append((title, rule, (falls == 0) & (np.nan_to_num(flat) != 0), np.abs(np.nan_to_num(flat))))
    return [_case(cube, title, rule, which, score) for title, rule, which, score in chosen if which.any()]


def _values(cube: xr.Dataset, name: str) -> FloatArray:
    return np.asarray(cube[name].transpose(*DIMENSIONS).to_numpy().astype(np.float64))


def _case(cube: xr.Dataset, title: str, rule: str, which: NDArray[np.bool_], score: FloatArray) -> SpaceCase:
    place = np.unravel_index(int(np.where(which, score, -np.inf).argmax()), which.shape)
    values = {name: float(cube[name].values[at]) for name, at in zip(DIMENSIONS[1:], place[1:], strict=True)}
    return SpaceCase(title, rule, int(place[0]), **values)
