"""Telling cases: those that a reader should watch, chosen by rule and not by eye."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.statistics.by_record import one_record
from overturning.statistics.circular import wrap_axis
from overturning.statistics.direction import CASE_DIMS
from overturning.statistics.planes import FALLS, fall_probability, plane_index

AMPLITUDES = (0.98, 1.0, 1.02)
"""Factors of the motion that show how little turns a fall to the other side."""

MOVES = 0.1
"""A block that stands moves to be seen where its largest rotation, in parts of α, is above this."""

NEAR_DEG = 22.5
"""Farthest that a plane may lie from the fault normal, or from the fault, to stand for it."""


@dataclass(frozen=True)
class TellingCase:
    """One case, or a few side by side: what it shows and by which rule it was chosen, record (place in the cube) and block.

    Azimuth and amplitude have an entry per panel.
    """

    title: str
    rule: str
    record: int
    height: float
    b_over_h: float
    friction: float
    azimuth_deg: tuple[float, ...]
    amplitude: tuple[float, ...]


Candidate = tuple[tuple[float, ...], Sequence[int], tuple[float, ...], tuple[float, ...]]
"""How well a case tells what it shows; the block's place by height, B/H and friction; azimuths and amplitudes."""


def _values(cube: xr.Dataset, name: str, record: int) -> FloatArray:
    """A variable of one record by azimuth, height, B/H and friction."""
    return np.asarray(cube[name].isel(record=record).transpose("azimuth", *CASE_DIMS).to_numpy())


def _normal_against_parallel(cube: xr.Dataset, record: int, planes: NDArray[np.intp]) -> Candidate | None:
    azimuth = cube["azimuth"].to_numpy().astype(np.float64)
    distance = np.abs(wrap_axis(azimuth[planes] - float(cube["fault_normal"].values[record])))
    if not (distance.min() <= NEAR_DEG and distance.max() >= 90 - NEAR_DEG):  # nor where the normal is not known
        return None
    along, across = planes[distance.argmin()], planes[distance.argmax()]
    flags = _values(cube, "overturned", record)
    splits = np.argwhere((np.abs(flags[along]) == 1) & (flags[across] == 0))
    if splits.size == 0:
        return None
    moves = _values(cube, "peak_rotation", record)[across] > MOVES
    # One that moves in both planes, then broadest, then roughest, then lowest.
    place = max(map(tuple, splits), key=lambda p: (moves[p], p[1], p[2], -p[0]))
    broad = round(float(cube["b_over_h"].values[place[1]]), 9)
    return (float(moves[place]), broad), place, (float(azimuth[along]), float(azimuth[across])), (1.0, 1.0)


def _which_side(cube: xr.Dataset, record: int, planes: NDArray[np.intp]) -> Candidate | None:
    if "probability_towards" not in cube:
        return None
    p = fall_probability(one_record(cube, record, FALLS)).isel(azimuth=planes).transpose("azimuth", *CASE_DIMS)
    split = np.minimum(p["towards"].to_numpy(), p["away"].to_numpy())
    sure = (p["towards"] + p["away"]).to_numpy() > 0.99
    split = np.where(sure & np.isfinite(split), split, 0.0)
    if split.max(initial=0.0) <= 0.1:
        return None
    # Of those that divide most evenly the broadest block: its fall is the one least expected to be a toss-up.
    at, *place = max(map(tuple, np.argwhere(split >= split.max() - 1e-9)), key=lambda q: (q[2], q[3], -q[1], -q[0]))
    return (float(split.max()),), place, (float(cube["azimuth"].values[planes[at]]),) * 3, AMPLITUDES


def _closest_call(cube: xr.Dataset, record: int, planes: NDArray[np.intp]) -> Candidate | None:
    rotation = np.nan_to_num(_values(cube, "peak_rotation", record)[planes])
    rotation = np.where(_values(cube, "overturned", record)[planes] == 0, rotation, -1.0)
    if rotation.max(initial=-1.0) <= 0.0:
        return None
    at, *place = (int(i) for i in np.unravel_index(int(rotation.argmax()), rotation.shape))
    return (float(rotation.max()),), place, (float(cube["azimuth"].values[planes[at]]),), (1.0,)


KINDS = (
    (
        _normal_against_parallel,
        "Falls normal to the fault, stands along it",
        "the broadest block of any record that falls in the plane nearest to the fault normal and rocks but stands in the "
        "one nearest to the fault (of several the first record, with the highest friction; where none rocks there, one that "
        "only stands)",
    ),
    (
        _which_side,
        "Falls, but to which side?",
        "the broadest block that falls in every run of the ensemble, as often to one side as to the other as any; "
        "shown with 0.98, 1 and 1.02 times the motion",
    ),
    (
        _closest_call,
        "Stands, but only just",
        "the block with the largest rotation, in parts of α, of all that stand",
    ),
)
"""How the candidate of a record is found, what it shows, and by which rule it is chosen."""


def telling_cases(cube: xr.Dataset) -> list[TellingCase]:
    """The telling cases of a study, read one record at a time: at most one of each of `KINDS`, none where no block moves."""
    planes = plane_index(cube["azimuth"].to_numpy())
    cases = []
    for candidate_of, title, rule in KINDS:
        candidates = [(candidate_of(cube, record, planes), record) for record in range(cube.sizes["record"])]
        known = [(candidate, record) for candidate, record in candidates if candidate is not None]
        if known:
            (_, place, azimuths, amplitudes), record = max(known, key=lambda one: one[0][0])  # of equals the first
            block = {name: float(cube[name].values[index]) for name, index in zip(CASE_DIMS, place, strict=True)}
            cases.append(TellingCase(title, rule, record, **block, azimuth_deg=azimuths, amplitude=amplitudes))
    return cases
