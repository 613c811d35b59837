"""Run settings over a set of cases, and compare two results: flags, sides and continuous errors."""

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.run import run_cases
from overturning.model.results import CaseResults
from overturning.model.status import CaseStatus
from overturning.study.answers import OutcomeDifferenceCountsOfTwoComputations, count_outcome_differences
from verification.inputs import CaseGroup
from verification.timing import ResultsWithProcessorTime, run_and_measure_min_processor_time

PeakRotationsOverAlpha = NDArray[np.floating[Any]]
OverturningFlags = NDArray[np.int8]

MIN_COMPARED_PEAK_ROTATION_OVER_ALPHA: Final = 0.05
"""Smallest peak rotation, as a share of α, of blocks that count in the error of peak rotation."""


def join_results(group_results: Sequence[CaseResults]) -> CaseResults:
    """Join the results of several groups of cases, in order."""
    return CaseResults(
        **{name: np.concatenate([getattr(one, name) for one in group_results]) for name in vars(group_results[0])}
    )


def run_case_groups(
    case_groups: Sequence[CaseGroup], repetition_count: int = 1, **settings: Any
) -> ResultsWithProcessorTime:
    """Run groups of cases after a warm-up run; return the joined results and the minimum processor time, s.

    Each group is run `repetition_count` times; `settings` are those of `run_cases`.
    """
    found, seconds = run_and_measure_min_processor_time(
        lambda: [run_cases(group.motion, group.cases, **settings) for group in case_groups],
        repetition_count,
        lambda: run_cases(*case_groups[0], **settings),
    )
    return ResultsWithProcessorTime(join_results(found), seconds)


def standing_block_peak_rotation_errors_over_alpha(
    flags: OverturningFlags,
    peak_rotations_over_alpha: PeakRotationsOverAlpha,
    reference_flags: OverturningFlags,
    reference_peak_rotations_over_alpha: PeakRotationsOverAlpha,
) -> FloatArray:
    """Return the absolute errors of the peak rotation over α, for the blocks that stand in results and in reference.

    Blocks whose peak rotation in the reference is at most `MIN_COMPARED_PEAK_ROTATION_OVER_ALPHA` of α are left out.
    """
    both = (
        (flags == 0)
        & (reference_flags == 0)
        & (reference_peak_rotations_over_alpha > MIN_COMPARED_PEAK_ROTATION_OVER_ALPHA)
    )
    return np.abs(np.asarray(peak_rotations_over_alpha, np.float64) - reference_peak_rotations_over_alpha)[both]


def median_peak_rotation_error_over_alpha(
    flags: OverturningFlags,
    peak_rotations_over_alpha: PeakRotationsOverAlpha,
    reference_flags: OverturningFlags,
    reference_peak_rotations_over_alpha: PeakRotationsOverAlpha,
) -> float:
    """Return the median error of peak rotation over α of the blocks that stand and rock; NaN if there is none."""
    errors = standing_block_peak_rotation_errors_over_alpha(
        flags, peak_rotations_over_alpha, reference_flags, reference_peak_rotations_over_alpha
    )
    return float(np.median(errors)) if errors.size else float("nan")


def convergence_order(time_steps: FloatArray, error_by_time_step: FloatArray) -> float:
    """Return the order of convergence: least-squares slope of log error over log time step."""
    good = (error_by_time_step > 0) & np.isfinite(error_by_time_step)
    if good.sum() < 2:
        return float("nan")
    return float(np.polyfit(np.log(time_steps[good]), np.log(error_by_time_step[good]), 1)[0])


def all_azimuth_and_b_over_h_neighbours_agree(flags: OverturningFlags) -> NDArray[np.bool_]:
    """Return True for cells whose neighbours in azimuth and B/H have the same overturning flag, side included.

    The last four axes of `flags` are azimuth (over half a circle), height, B/H and friction.
    """
    along = np.moveaxis(flags, -4, 0)
    # At the azimuth + 180° the sides are exchanged.
    after, before = np.concatenate([along[1:], -along[:1]]), np.concatenate([-along[-1:], along[:-1]])
    agree = np.moveaxis((after == along) & (before == along), 0, -4)
    agree[..., 1:, :] &= flags[..., :-1, :] == flags[..., 1:, :]
    agree[..., :-1, :] &= flags[..., 1:, :] == flags[..., :-1, :]
    return np.asarray(agree)


class DifferencesFromReferenceResults(NamedTuple):
    """Differences between results and a reference: changed flags and sides, rotation errors, and cost."""

    counts_of_all_cases: OutcomeDifferenceCountsOfTwoComputations
    counts_where_neighbours_agree: OutcomeDifferenceCountsOfTwoComputations
    """Counts over the cases whose neighbours agree in the reference; empty if the set is not a grid."""
    counts_of_cases_simulated_in_reference: OutcomeDifferenceCountsOfTwoComputations
    """Counts over the cases that the reference simulates."""
    standing_block_peak_rotation_errors_over_alpha: FloatArray
    """Errors of peak rotation, as a share of α."""
    count_of_cases_with_unstable_status: int
    computed_steps_times_elements: int
    max_energy_balance_error: float
    """Largest energy error of the simulated cases."""

    def cost_and_error_columns(self, processor_time_s: float) -> dict[str, float]:
        """Return the columns of a table in the docs by title: cost and errors of the results.

        `processor_time_s` is the processor time of the results. Wrong flags, and wrong sides (which
        include wrong flags), are percentages of all cases; the errors of peak rotation are those of
        `standing_block_peak_rotation_errors_over_alpha`.
        """
        flags, sides = wrong_flag_and_flag_or_side_percentages(self.counts_of_all_cases)
        return {
            "million block steps": round(self.computed_steps_times_elements / 1e6, 1),
            "processor time, s": round(processor_time_s, 2),
            "wrong flags, %": round(flags, 3),
            "wrong sides, %": round(sides, 3),
            "median error of peak rotation": round_to_three_significant_digits(
                np.median(self.standing_block_peak_rotation_errors_over_alpha)
            ),
            "90th percentile": round_to_three_significant_digits(
                np.quantile(self.standing_block_peak_rotation_errors_over_alpha, 0.9)
            ),
            "marked": self.count_of_cases_with_unstable_status,
            "largest energy error": round_to_three_significant_digits(self.max_energy_balance_error),
        }


def differences_from_reference_results(
    results: CaseResults, reference_results: CaseResults, case_grid_shape: Sequence[int] = ()
) -> DifferencesFromReferenceResults:
    """Compare results with reference results of the same cases.

    With `case_grid_shape`, the shape of the grid of cases (one size may be -1), differences are also counted in the
    cells whose neighbours have the same flag in the reference.
    """
    right, flags = reference_results.overturned, results.overturned
    firm = (
        all_azimuth_and_b_over_h_neighbours_agree(right.reshape(case_grid_shape)).ravel()
        if case_grid_shape
        else np.zeros(right.size, bool)
    )
    moves = reference_results.status != CaseStatus.AT_REST
    return DifferencesFromReferenceResults(
        count_outcome_differences(right, flags),
        count_outcome_differences(right[firm], flags[firm]),
        count_outcome_differences(right[moves], flags[moves]),
        standing_block_peak_rotation_errors_over_alpha(
            flags, results.peak_rotation, right, reference_results.peak_rotation
        ),
        int((results.status == CaseStatus.UNSTABLE).sum()),
        int(results.block_steps.sum()),
        float(results.energy_error[results.status == CaseStatus.SIMULATED].max(initial=0.0)),
    )


def round_to_three_significant_digits(number: Any) -> float:
    """Round a number to three significant digits."""
    return float(f"{number:.3g}")


def percentage(part: float, total: float) -> float:
    """Return a part of a total in percent; NaN if the total is 0."""
    return 100.0 * part / total if total else float("nan")


def wrong_flag_and_flag_or_side_percentages(counts: OutcomeDifferenceCountsOfTwoComputations) -> tuple[float, float]:
    """Return two percentages: cases that wrongly fall or stand, and these with those that fall to the wrong side."""
    return percentage(counts.flags, counts.cases), percentage(counts.flags + counts.sides, counts.cases)
