"""Settings run over a set of cases, and how far two answers to it differ: flags, sides, errors that are continuous."""

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.run import run_cases
from overturning.model.results import Results
from overturning.model.status import Status
from overturning.study.answers import Counts, compare
from verification.inputs import Group
from verification.timing import Answer, measured

Peaks = NDArray[np.floating[Any]]
Flags = NDArray[np.int8]

ROCKS: Final = 0.05
"""A block that stands counts for the error of peak rotation if it rocked to this share of the critical angle."""


def joined(found: Sequence[Results]) -> Results:
    """Results of several groups in a row."""
    return Results(**{name: np.concatenate([getattr(one, name) for one in found]) for name in vars(found[0])})


def answers(groups: Sequence[Group], repeats: int = 1, **settings: Any) -> Answer:
    """Run settings, arguments of `run_cases`, over a set, so often; the first group, run before, warms up."""
    found, seconds = measured(
        lambda: [run_cases(group.motion, group.cases, **settings) for group in groups],
        repeats,
        lambda: run_cases(*groups[0], **settings),
    )
    return Answer(joined(found), seconds)


def rotation_errors(flags: Flags, peaks: Peaks, right_flags: Flags, right_peaks: Peaks) -> FloatArray:
    """Error of peak rotation, as a share of the critical angle, of each block that rocks and stands in both."""
    both = (flags == 0) & (right_flags == 0) & (right_peaks > ROCKS)
    return np.abs(np.asarray(peaks, np.float64) - right_peaks)[both]


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
    """Cells whose neighbours in azimuth, over half a turn, and B/H have the same flag.

    The axes are those of `inputs.grid`, after any others.
    """
    along = np.moveaxis(flags, -4, 0)
    # Half a turn further the sides are exchanged.
    after, before = np.concatenate([along[1:], -along[:1]]), np.concatenate([-along[-1:], along[:-1]])
    agree = np.moveaxis((after == along) & (before == along), 0, -4)
    agree[..., 1:, :] &= flags[..., :-1, :] == flags[..., 1:, :]
    agree[..., :-1, :] &= flags[..., 1:, :] == flags[..., :-1, :]
    return np.asarray(agree)


class Difference(NamedTuple):
    """Answers compared with a reference."""

    counts: Counts
    firm: Counts
    """Of the cases whose neighbours agree in the reference; none where the set is no grid."""
    moving: Counts
    """Of the cases that the reference did not leave out."""
    rotation: FloatArray
    """Errors of peak rotation."""
    unstable: int
    block_steps: int
    energy_error: float
    """Largest of what was computed."""

    def costs(self, seconds: float) -> dict[str, float]:
        """What the answers cost and how far they are off, by the heads of the tables of the docs."""
        flags, sides = shares(self.counts)
        return {
            "million block steps": round(self.block_steps / 1e6, 1),
            "processor time, s": round(seconds, 2),
            "wrong flags, %": round(flags, 3),
            "wrong sides, %": round(sides, 3),
            "median error of peak rotation": digits(np.median(self.rotation)),
            "90th percentile": digits(np.quantile(self.rotation, 0.9)),
            "marked": self.unstable,
            "largest energy error": digits(self.energy_error),
        }


def difference(found: Results, exact: Results, shape: Sequence[int] = ()) -> Difference:
    """Compare answers with a reference; `shape` is that of a grid, one of its sizes may be -1."""
    right, flags = exact.overturned, found.overturned
    firm = neighbours_agree(right.reshape(shape)).ravel() if shape else np.zeros(right.size, bool)
    moves = exact.status != Status.AT_REST
    return Difference(
        compare(right, flags),
        compare(right[firm], flags[firm]),
        compare(right[moves], flags[moves]),
        rotation_errors(flags, found.peak_rotation, right, exact.peak_rotation),
        int((found.status == Status.UNSTABLE).sum()),
        int(found.block_steps.sum()),
        float(found.energy_error[found.status == Status.SIMULATED].max(initial=0.0)),
    )


def digits(value: Any) -> float:
    """A number with three digits."""
    return float(f"{value:.3g}")


def percent(part: float, of: float) -> float:
    """A share in percent; NaN where there is nothing to count."""
    return 100.0 * part / of if of else float("nan")


def shares(counts: Counts) -> tuple[float, float]:
    """Wrong flags in percent, and cases that do not end on the same side: wrong flags, or falls to the other side."""
    return percent(counts.flags, counts.cases), percent(counts.flags + counts.sides, counts.cases)
