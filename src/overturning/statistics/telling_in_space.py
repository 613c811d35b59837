"""Telling cases in space: those that a reader should watch, chosen by rule and not by eye."""

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.statistics.by_record import one_record

DIMENSIONS = ("orientation", "height", "b_over_h", "aspect", "friction")


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


Candidate = tuple[float, tuple[int, ...]]
"""How well a case tells what it shows, and its place along `DIMENSIONS` after the record."""

ALONE = "Falls, though both planes of its faces say it stands", "the broadest block that does so"
CORNER = (
    "Falls over a corner",
    "the broadest block whose fall lies within 10° of the middle between the normals of two faces",
)
TURNED = "Stands, and has turned", "the block with the largest turn about the vertical of all that stand"


def telling_in_space(cube: xr.Dataset) -> list[SpaceCase]:
    """The telling cases of a study in space, read one record at a time: at most one of each kind, of equals the first."""
    best: dict[tuple[str, str], tuple[float, int, tuple[int, ...]]] = {}
    names = ("overturned", "plane_overturned", "fall_azimuth", "residual_twist")
    for record in range(cube.sizes["record"]):
        for kind, (score, place) in _candidates(one_record(cube, record, names)).items():
            if kind not in best or score > best[kind][0]:
                best[kind] = score, record, place
    cases = []
    for kind in (ALONE, CORNER, TURNED):
        if kind in best:
            _, record, place = best[kind]
            values = (float(cube[name].values[at]) for name, at in zip(DIMENSIONS, place, strict=True))
            cases.append(SpaceCase(*kind, record, *values))
    return cases


def _candidates(cube: xr.Dataset) -> dict[tuple[str, str], Candidate]:
    """The best case of each kind in one record, if there is one."""
    falls, turned = (_values(cube, name) for name in ("overturned", "residual_twist"))
    ratio = np.broadcast_to(cube["b_over_h"].to_numpy()[:, None, None], falls.shape)
    turned = np.abs(np.nan_to_num(turned))
    chosen = {TURNED: ((falls == 0) & (turned != 0), turned)}
    if "plane_overturned" in cube:
        chosen[ALONE] = (falls == 1) & (_values(cube, "plane_overturned") == 0), ratio
        off = np.mod(_values(cube, "fall_azimuth") - cube["orientation"].to_numpy()[:, None, None, None, None], 90.0)
        chosen[CORNER] = (falls == 1) & (np.abs(np.nan_to_num(off) - 45.0) < 10.0), ratio
    return {kind: _largest(which, score) for kind, (which, score) in chosen.items() if which.any()}


def _values(cube: xr.Dataset, name: str) -> FloatArray:
    return np.asarray(cube[name].transpose(*DIMENSIONS).to_numpy().astype(np.float64))


def _largest(which: NDArray[np.bool_], score: FloatArray) -> Candidate:
    place = int(np.where(which, score, -np.inf).argmax())
    return float(score.flat[place]), tuple(int(at) for at in np.unravel_index(place, which.shape))
