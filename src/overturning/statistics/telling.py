"""Telling cases: those that a reader should watch, chosen by rule and not by eye."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.statistics.circular import wrap_axis
from overturning.statistics.planes import fall_probability, falls_of_record, plane_index

if TYPE_CHECKING:
    import xarray as xr

AMPLITUDES = (0.98, 1.0, 1.02)
"""Factors of the motion that show how little turns a fall to the other side."""

NEAR_DEG = 22.5
"""Farthest that a plane may lie from the fault normal, or from the fault, to stand for it."""


@dataclass(frozen=True)
class TellingCase:
    """One case, or a few side by side.

    Attributes
    ----------
    title, rule : str
        What it shows, and how it was chosen.
    record : int
        Position of the record in the cube.
    height, b_over_h, friction : float
        The block.
    azimuth_deg, amplitude : tuple of float
        One entry per panel.
    """

    title: str
    rule: str
    record: int
    height: float
    b_over_h: float
    friction: float
    azimuth_deg: tuple[float, ...]
    amplitude: tuple[float, ...]


def _block(cube: "xr.Dataset", place: tuple[int, ...]) -> dict[str, float]:
    names = ("height", "b_over_h", "friction")
    return {name: float(cube[name].values[index]) for name, index in zip(names, place, strict=True)}


Candidate = tuple[float, TellingCase]
"""How well a case tells what it shows, and the case."""


def _values(cube: "xr.Dataset", name: str, record: int) -> FloatArray:
    """A variable of one record by azimuth, height, B/H and friction."""
    return np.asarray(cube[name].isel(record=record).transpose("azimuth", "height", "b_over_h", "friction").to_numpy())


def _normal_against_parallel(cube: "xr.Dataset", record: int, planes: NDArray[np.intp]) -> Candidate | None:
    azimuth = cube["azimuth"].to_numpy().astype(np.float64)
    distance = np.abs(wrap_axis(azimuth[planes] - float(cube["fault_normal"].values[record])))
    if not (distance.min() <= NEAR_DEG and distance.max() >= 90 - NEAR_DEG):  # nor where the normal is not known
        return None
    along, across = planes[distance.argmin()], planes[distance.argmax()]
    flags = _values(cube, "overturned", record)
    splits = np.argwhere((np.abs(flags[along]) == 1) & (flags[across] == 0))
    if splits.size == 0:
        return None
    place = max(map(tuple, splits), key=lambda p: (p[1], p[2], -p[0]))  # broadest, then roughest, then lowest
    block = _block(cube, place)
    case = TellingCase(
        "Falls normal to the fault, stands along it",
        "the broadest block of any record that falls in the plane nearest to the fault normal and stands in the one "
        "nearest to the fault (of several the first record, with the highest friction)",
        record, **block, azimuth_deg=(float(azimuth[along]), float(azimuth[across])), amplitude=(1.0, 1.0),
    )  # fmt: skip
    return round(block["b_over_h"], 9), case


def _which_side(cube: "xr.Dataset", record: int, planes: NDArray[np.intp]) -> Candidate | None:
    if "probability_towards" not in cube:
        return None
    p = fall_probability(falls_of_record(cube, record)).isel(azimuth=planes)
    p = p.transpose("azimuth", "height", "b_over_h", "friction")
    split = np.minimum(p["towards"].to_numpy(), p["away"].to_numpy())
    sure = (p["towards"] + p["away"]).to_numpy() > 0.99
    split = np.where(sure & np.isfinite(split), split, 0.0)
    if split.max(initial=0.0) <= 0.1:
        return None
    # Of those that divide most evenly the broadest block: its fall is the one least expected to be a toss-up.
    place = max(map(tuple, np.argwhere(split >= split.max() - 1e-9)), key=lambda q: (q[2], q[3], -q[1], -q[0]))
    case = TellingCase(
        "Falls, but to which side?",
        "the broadest block that falls in every run of the ensemble, as often to one side as to the other as any; "
        "shown with 0.98, 1 and 1.02 times the motion",
        record, **_block(cube, place[1:]), azimuth_deg=(float(cube["azimuth"].values[planes[place[0]]]),) * 3,
        amplitude=AMPLITUDES,
    )  # fmt: skip
    return float(split.max()), case


def _closest_call(cube: "xr.Dataset", record: int, planes: NDArray[np.intp]) -> Candidate | None:
    rotation = np.nan_to_num(_values(cube, "peak_rotation", record)[planes])
    rotation = np.where(_values(cube, "overturned", record)[planes] == 0, rotation, -1.0)
    if rotation.max(initial=-1.0) <= 0.0:
        return None
    place = np.unravel_index(int(rotation.argmax()), rotation.shape)
    case = TellingCase(
        "Stands, but only just",
        "the block with the largest rotation, in parts of α, of all that stand",
        record, **_block(cube, tuple(int(i) for i in place[1:])),
        azimuth_deg=(float(cube["azimuth"].values[planes[place[0]]]),), amplitude=(1.0,),
    )  # fmt: skip
    return float(rotation.max()), case


def telling_cases(cube: "xr.Dataset") -> list[TellingCase]:
    """The telling cases of a study: at most three, none where no block moves.

    Parameters
    ----------
    cube : Dataset
        The cube; read one record at a time.

    Returns
    -------
    list of TellingCase
        Falls normal to the fault and stands along it; falls to an uncertain side; stands, but only just.
    """
    planes = plane_index(cube["azimuth"].to_numpy())
    cases = []
    for kind in (_normal_against_parallel, _which_side, _closest_call):
        candidates = [kind(cube, record, planes) for record in range(cube.sizes["record"])]
        known = [candidate for candidate in candidates if candidate is not None]
        if known:
            cases.append(max(known, key=lambda candidate: candidate[0])[1])  # of equals the first
    return cases
