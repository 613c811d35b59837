"""Telling cases: those that a reader should watch, chosen by rule and not by eye."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from overturning.statistics.circular import wrap_axis
from overturning.statistics.planes import fall_probability, plane_index

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


def _normal_against_parallel(cube: "xr.Dataset") -> TellingCase | None:
    azimuth = cube["azimuth"].to_numpy().astype(np.float64)
    planes = plane_index(azimuth)
    best: tuple[float, TellingCase] | None = None
    for record in range(cube.sizes["record"]):
        normal = float(cube["fault_normal"].values[record])
        if not np.isfinite(normal):
            continue
        distance = np.abs(wrap_axis(azimuth[planes] - normal))
        along, across = planes[distance.argmin()], planes[distance.argmax()]
        if distance.min() > NEAR_DEG or distance.max() < 90 - NEAR_DEG:
            continue
        flags = cube["overturned"].isel(record=record).transpose("azimuth", "height", "b_over_h", "friction")
        one = flags.to_numpy()
        splits = np.argwhere((np.abs(one[along]) == 1) & (one[across] == 0))
        if splits.size == 0:
            continue
        place = max(map(tuple, splits), key=lambda p: (p[1], p[2], -p[0]))  # broadest, then roughest, then lowest
        block = _block(cube, place)
        case = TellingCase(
            "Falls normal to the fault, stands along it",
            "the broadest block of any record that falls in the plane nearest to the fault normal and stands in the one "
            "nearest to the fault (of several the first record, with the highest friction)",
            record, **block, azimuth_deg=(float(azimuth[along]), float(azimuth[across])), amplitude=(1.0, 1.0),
        )  # fmt: skip
        if best is None or block["b_over_h"] > best[0] + 1e-9:
            best = (block["b_over_h"], case)
    return best[1] if best else None


def _which_side(cube: "xr.Dataset") -> TellingCase | None:
    if "probability_towards" not in cube:
        return None
    best: tuple[float, TellingCase] | None = None
    azimuth = cube["azimuth"].to_numpy().astype(np.float64)
    planes = plane_index(azimuth)
    for record in range(cube.sizes["record"]):
        p = fall_probability(cube.isel(record=record)).isel(azimuth=planes)
        p = p.transpose("azimuth", "height", "b_over_h", "friction")
        split = np.minimum(p["towards"].to_numpy(), p["away"].to_numpy())
        sure = (p["towards"] + p["away"]).to_numpy() > 0.99
        split = np.where(sure & np.isfinite(split), split, 0.0)
        if split.max(initial=0.0) <= (best[0] if best else 0.1):
            continue
        # Of those that divide most evenly the broadest block: its fall is the one least expected to be a toss-up.
        candidates = np.argwhere(split >= split.max() - 1e-9)
        place = max(map(tuple, candidates), key=lambda q: (q[2], q[3], -q[1], -q[0]))
        best = (
            float(split.max()),
            TellingCase(
                "Falls, but to which side?",
                "the broadest block that falls in every run of the ensemble, as often to one side as to the other as any; "
                "shown with 0.98, 1 and 1.02 times the motion",
                record, **_block(cube, place[1:]), azimuth_deg=(float(azimuth[planes][place[0]]),) * 3,
                amplitude=AMPLITUDES,
            ),
        )  # fmt: skip
    return best[1] if best else None


def _closest_call(cube: "xr.Dataset") -> TellingCase | None:
    best: tuple[float, TellingCase] | None = None
    azimuth = cube["azimuth"].to_numpy().astype(np.float64)
    planes = plane_index(azimuth)
    for record in range(cube.sizes["record"]):
        one = cube[["overturned", "peak_rotation"]].isel(record=record, azimuth=planes)
        one = one.transpose("azimuth", "height", "b_over_h", "friction")
        rotation = np.where(one["overturned"].to_numpy() == 0, np.nan_to_num(one["peak_rotation"].to_numpy()), -1.0)
        if rotation.max(initial=-1.0) <= (best[0] if best else 0.0):
            continue
        place = np.unravel_index(int(rotation.argmax()), rotation.shape)
        best = (
            float(rotation.max()),
            TellingCase(
                "Stands, but only just",
                "the block with the largest rotation, in parts of α, of all that stand",
                record, **_block(cube, tuple(int(i) for i in place[1:])),
                azimuth_deg=(float(azimuth[planes][place[0]]),), amplitude=(1.0,),
            ),
        )  # fmt: skip
    return best[1] if best else None


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
    found = (_normal_against_parallel(cube), _which_side(cube), _closest_call(cube))
    return [case for case in found if case is not None]
