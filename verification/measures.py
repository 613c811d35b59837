"""Run settings over a set of cases, and compare two results: flags, sides and continuous errors."""

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.run import run_cases
from overturning.model.results import CaseResults
from overturning.model.status import Status
from overturning.study.answers import DifferenceCounts, count_differences
from verification.inputs import Group
from verification.timing import Answer, time_run

Peaks = NDArray[np.floating[Any]]
Flags = NDArray[np.int8]

ROCKS: Final = 0.05
"""Smallest peak rotation, as a share of α, of blocks that count in the error of peak rotation."""


def join_results(found: Sequence[CaseResults]) -> CaseResults:
    """Return the results of several groups, joined in order."""
    return CaseResults(**{name: np.concatenate([getattr(one, name) for one in found]) for name in vars(found[0])})


def answers(groups: Sequence[Group], repeats: int = 1, **settings: Any) -> Answer:
    """Run a set `repeats` times with settings (arguments of `run_cases`), after the first group as a warm-up."""
    found, seconds = time_run(
        lambda: [run_cases(group.motion, group.cases, **settings) for group in groups],
        repeats,
        lambda: run_cases(*groups[0], **settings),
    )
    return Answer(join_results(found), seconds)


def rotation_errors(flags: Flags, peaks: Peaks, right_flags: Flags, right_peaks: Peaks) -> FloatArray:
    """Return the errors of peak rotation, as a share of α, of blocks that rock and stand in both."""
    both = (flags == 0) & (right_flags == 0) & (right_peaks > ROCKS)
    return np.abs(np.asarray(peaks, np.float64) - right_peaks)[both]


def rotation_error(flags: Flags, peaks: Peaks, right_flags: Flags, right_peaks: Peaks) -> float:
    """Return the median of `rotation_errors`; NaN if no block counts."""
    errors = rotation_errors(flags, peaks, right_flags, right_peaks)
    return float(np.median(errors)) if errors.size else float("nan")


def order(steps: FloatArray, errors: FloatArray) -> float:
    """Return the order of convergence: least-squares slope of log error over log step."""
    good = (errors > 0) & np.isfinite(errors)
    if good.sum() < 2:
        return float("nan")
    return float(np.polyfit(np.log(steps[good]), np.log(errors[good]), 1)[0])


def neighbours_agree(flags: Flags) -> NDArray[np.bool_]:
    """Return True for cells whose neighbours in azimuth (over half a circle) and B/H have the same flag.

    The last axes are those of `inputs.grid`.
    """
    along = np.moveaxis(flags, -4, 0)
    # At the azimuth + 180° the sides are exchanged.
    after, before = np.concatenate([along[1:], -along[:1]]), np.concatenate([-along[-1:], along[:-1]])
    agree = np.moveaxis((after == along) & (before == along), 0, -4)
    agree[..., 1:, :] &= flags[..., :-1, :] == flags[..., 1:, :]
    agree[..., :-1, :] &= flags[..., 1:, :] == flags[..., :-1, :]
    return np.asarray(agree)


class Difference(NamedTuple):
    """Comparison of results with a reference."""

    counts: DifferenceCounts
    firm: DifferenceCounts
    """Counts over the cases whose neighbours agree in the reference; empty if the set is not a grid."""
    moving: DifferenceCounts
    """Counts over the cases that the reference simulates."""
    rotation: FloatArray
    """Errors of peak rotation, as a share of α."""
    unstable: int
    block_steps: int
    energy_error: float
    """Largest energy error of the simulated cases."""

    def costs(self, seconds: float) -> dict[str, float]:
        """Return cost and errors by the column titles of the tables in the docs."""
        flags, sides = error_shares(self.counts)
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


def difference(found: CaseResults, exact: CaseResults, shape: Sequence[int] = ()) -> Difference:
    """Compare results with a reference; `shape` is that of the grid, and one size may be -1."""
    right, flags = exact.overturned, found.overturned
    firm = neighbours_agree(right.reshape(shape)).ravel() if shape else np.zeros(right.size, bool)
    moves = exact.status != Status.AT_REST
    return Difference(
        count_differences(right, flags),
        count_differences(right[firm], flags[firm]),
        count_differences(right[moves], flags[moves]),
        rotation_errors(flags, found.peak_rotation, right, exact.peak_rotation),
        int((found.status == Status.UNSTABLE).sum()),
        int(found.block_steps.sum()),
        float(found.energy_error[found.status == Status.SIMULATED].max(initial=0.0)),
    )


def digits(value: Any) -> float:
    """Round a number to three significant digits."""
    return float(f"{value:.3g}")


def percent(part: float, of: float) -> float:
    """Return a share in percent; NaN for an empty total."""
    return 100.0 * part / of if of else float("nan")


def error_shares(counts: DifferenceCounts) -> tuple[float, float]:
    """Return wrong flags, and cases that do not end on the same side (wrong flags included), both in percent."""
    return percent(counts.flags, counts.cases), percent(counts.flags + counts.sides, counts.cases)
