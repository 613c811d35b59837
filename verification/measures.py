"""How far two answers to the same cases differ: flags, sides, and errors that are continuous."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.model.results import Results
from overturning.model.status import Status
from overturning.study.convergence import Counts, compare

Peaks = NDArray[np.floating[Any]]
Flags = NDArray[np.int8]

ROCKS: Final = 0.05
"""A block that stands counts for the error of peak rotation if it rocked to this share of the critical angle."""


def rotation_errors(flags: Flags, peaks: Peaks, right_flags: Flags, right_peaks: Peaks) -> FloatArray:
    """Error of peak rotation, as a share of the critical angle, of each block that rocks and stands in both."""
    both = (flags == 0) & (right_flags == 0) & (right_peaks > ROCKS)
    return np.asarray(np.abs(peaks - right_peaks)[both])


def rotation_error(flags: Flags, peaks: Peaks, right_flags: Flags, right_peaks: Peaks) -> float:
    """Median of `rotation_errors`; NaN where no block counts."""
    errors = rotation_errors(flags, peaks, right_flags, right_peaks)
    return float(np.median(errors)) if errors.size else float("nan")


def order(steps: FloatArray, errors: FloatArray) -> float:
    """Order of convergence: slope of the line through log error over log step (least squares)."""
    good = (errors > 0) & np.isfinite(errors)
    if good.sum() < 2:
        return float("nan")
    return float(np.polyfit(np.log(steps[good]), np.log(errors[good]), 1)[0])


def neighbours_agree(flags: Flags) -> NDArray[np.bool_]:
    """Cells whose neighbours in azimuth and B/H have the same flag.

    Parameters
    ----------
    flags : ndarray of int8, shape (azimuth, height, b_over_h, friction)
        Over half a turn.
    """
    after = np.roll(flags, -1, axis=0)
    after[-1] = -flags[0]  # half a turn further the sides are exchanged
    before = np.roll(flags, 1, axis=0)
    before[0] = -flags[-1]
    agree = (after == flags) & (before == flags)
    agree[:, :, 1:] &= flags[:, :, :-1] == flags[:, :, 1:]
    agree[:, :, :-1] &= flags[:, :, 1:] == flags[:, :, :-1]
    return np.asarray(agree)


@dataclass(frozen=True)
class Difference:
    """Answers to the same cases under several motions, compared with a reference.

    Attributes
    ----------
    counts, firm : Counts
        Of all cases, and of those whose neighbours agree in the reference; none where the cases are no grid.
    moving : Counts
        Of those that the reference did not leave out.
    rotation : ndarray
        Errors of peak rotation.
    marked : int
        Cases without an answer.
    unstable : int
        Of them those whose energy does not balance or that sink in too far.
    block_steps : int
        Work.
    energy_error : float
        The largest of the simulated cases.
    """

    counts: Counts
    firm: Counts
    moving: Counts
    rotation: FloatArray
    marked: int
    unstable: int
    block_steps: int
    energy_error: float


def difference(found: Mapping[str, Results], exact: Mapping[str, Results], shape: Sequence[int] = ()) -> Difference:
    """Compare answers with a reference.

    Parameters
    ----------
    found, exact : mapping of str to Results
        Answers by motion.
    shape : sequence of int, optional
        Of the grid (azimuth, height, b_over_h, friction).
    """
    nothing = np.zeros(0, np.int8)
    counts = firm = moving = compare(nothing, nothing)
    rotation = []
    for name, right in exact.items():
        one = found[name]
        counts += compare(right.overturned, one.overturned)
        computed = right.status != Status.AT_REST
        moving += compare(right.overturned[computed], one.overturned[computed])
        if shape:
            agree = neighbours_agree(right.overturned.reshape(shape)).ravel()
            firm += compare(right.overturned[agree], one.overturned[agree])
        rotation.append(rotation_errors(one.overturned, one.peak_rotation, right.overturned, right.peak_rotation))
    status = np.concatenate([one.status for one in found.values()])
    energy = np.concatenate([one.energy_error for one in found.values()])
    return Difference(
        counts, firm, moving, np.concatenate(rotation), int((status > Status.AT_REST).sum()),
        int((status == Status.UNSTABLE).sum()), sum(int(one.block_steps.sum()) for one in found.values()),
        float(energy[status == Status.SIMULATED].max(initial=0.0)),
    )  # fmt: skip


def percent(part: float, of: float) -> float:
    """A share in percent; NaN where there is nothing to count."""
    return 100.0 * part / of if of else float("nan")


def wrong_sides(counts: Counts) -> int:
    """Cases that do not end on the same side: those with another flag, and those that fall to the other side."""
    return counts.flags + counts.sides
