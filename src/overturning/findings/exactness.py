"""Uncertainty of outcomes: ensemble runs that disagree, cases that change in a second computation, final rotation."""

import math
from functools import partial
from typing import Final

import numpy as np
import xarray as xr

from overturning.findings.comparison import (
    ChangedCaseCountAndShare,
    ComparisonWithMoreExactComputation,
    comparisons_with_second_computations,
    share_of_changed_cases,
)
from overturning.findings.relief import FallSharesByBaseRelief, share_of_fall_variance_due_to_base_relief
from overturning.findings.results import StudyResults
from overturning.findings.values import FindingBaseClass, OptionalNumberOrInfinity
from overturning.model.model import Model
from overturning.settings import EnsembleSettings
from overturning.statistics.by_record import apply_to_record_batches_and_join
from overturning.statistics.space import (
    moved_stone_twist_deg_by_b_over_h_and_friction,
    summarise_twists_sorting_in_place,
)
from overturning.statistics.spread import (
    RunCountStatistic,
    average_first_batch_statistic_over_run_orders,
    indicator_that_most_runs_fall_and_sides_differ,
    indicator_that_some_runs_fall_and_others_stand,
)
from overturning.study.convergence import ConvergenceCheckResult, FinerStepOutcomeChangeCountOfRecord
from overturning.study.ensemble import MEMBERS_PER_BATCH

MIN_COMPARED_CASES_PER_RECORD: Final = 20
"""Smallest number of compared cases of a record of which the share of changes is judged."""


class EnsembleDisagreementFindings(FindingBaseClass):
    """Shares of cases whose ensemble runs, with slightly changed parameters, disagree about the fall."""

    share_of_cells_repeated: OptionalNumberOrInfinity
    """Share of all cells that were run again, several times."""
    repeats_every_cell: bool
    """True if the study repeats all cells, False if it repeats those near a change of outcome along B/H."""
    fewest_runs_per_cell: OptionalNumberOrInfinity
    """Smallest number of runs of a repeated cell."""
    most_runs_per_cell: OptionalNumberOrInfinity
    """Largest number of runs of a repeated cell."""
    mean_runs_per_cell: OptionalNumberOrInfinity
    """Mean number of runs of a repeated cell."""
    runs_per_cell_in_first_batch: int
    """Number of runs per cell to which the shares of cells with falls and stands and (2-D) with both sides refer."""
    share_of_repeated_cells_with_fall_and_stand: OptionalNumberOrInfinity
    """Estimated share of the repeated cells in which some runs of the first batch fall and others stand.

    Cells with an outcome of fewer runs are left out.
    """
    share_of_repeated_cells_falling_to_both_sides: OptionalNumberOrInfinity
    """Estimated share of the repeated cells in which most runs of the first batch fall, but not all to one side; in
    3-D the share, of the repeated cells in which all runs fall, whose directions are far apart."""
    fall_shares_by_base_relief: FallSharesByBaseRelief | None = None
    """Share of the variance of outcomes that the relief of a scanned base explains; None unless the relief varies.

    The relief is the height above the lowest point of the base up to which its points bear load.
    """


class FinerStepChangeFindingOfRecord(FindingBaseClass):
    """Cases of one record whose outcome changes with finer time steps."""

    record: str
    changes: ChangedCaseCountAndShare


class OutcomeChangesInConvergenceCheck(FindingBaseClass):
    """Shares of the cases whose outcome changes in a more exact computation.

    The convergence check computes cases again with finer steps, stiffer springs, or exact rigid blocks.
    """

    result: ConvergenceCheckResult
    """Counts of the convergence check (`convergence.json`)."""
    only_random_sample_was_rerun: bool
    """True if a random sample of the cases was run again, False if all were."""
    comparisons: list[ComparisonWithMoreExactComputation]
    """Cases that change in each second computation."""
    share_below_rocking_and_sliding_thresholds: OptionalNumberOrInfinity
    """Share of the cases run again that lie below the thresholds of rocking and sliding and cannot change."""
    changes_under_tiny_amplitude_increase: ChangedCaseCountAndShare
    """Cases that change under a motion stronger by a factor of 1 + 10⁻⁹: no computation can decide them."""
    fall_azimuth_changes_with_amplitude: ChangedCaseCountAndShare | None
    """Falls in space whose azimuth moves by 30° or more within ± 1 % of the amplitude; None for planar models."""
    records_with_more_changes_than_average: list[FinerStepChangeFindingOfRecord]
    """Records under which finer steps change clearly more outcomes than in the whole study, the largest share first.

    The lower end of the 95 % interval of the record's share lies above the share over all records; records with fewer
    than 20 compared cases are left out.
    """


class FinalTwistOfMovedStandingStones(FindingBaseClass):
    """Final rotation about the vertical, degrees, of stones that moved and stand."""

    moved_standing_stone_count: int
    """Number of stones that moved and stand."""
    median_abs_twist_deg: OptionalNumberOrInfinity
    """Median of the absolute rotation."""
    percentile_90_abs_twist_deg: OptionalNumberOrInfinity
    """90th percentile of the absolute rotation."""
    largest_abs_twist_deg: OptionalNumberOrInfinity
    """Largest absolute rotation."""


def convergence_findings(results: StudyResults) -> OutcomeChangesInConvergenceCheck | None:
    """Return the report's numbers on the convergence check of the study; None if there was no check."""
    found = results.convergence
    if found is None:
        return None
    is_sample, shift = found.rerun_case_count < found.simulated_study_cell_count, found.amplitude_change_rerun
    return OutcomeChangesInConvergenceCheck(
        result=found,
        only_random_sample_was_rerun=is_sample,
        comparisons=comparisons_with_second_computations(found),
        share_below_rocking_and_sliding_thresholds=found.rerun_cases_at_rest / found.rerun_case_count
        if found.rerun_case_count
        else math.nan,
        changes_under_tiny_amplitude_increase=share_of_changed_cases(
            found.tests_of_finer_step_changes.chaotic_cases, found.rerun_case_count, is_sample
        ),
        fall_azimuth_changes_with_amplitude=None
        if shift is None
        else share_of_changed_cases(shift.falls_with_shifted_azimuth, shift.rerun_falls, is_sample),
        records_with_more_changes_than_average=_records_with_unusually_many_outcome_changes(
            found.finer_step_changes_by_record
        ),
    )


def _records_with_unusually_many_outcome_changes(
    step_changes_of_each_record: list[FinerStepOutcomeChangeCountOfRecord],
) -> list[FinerStepChangeFindingOfRecord]:
    """Return the records under which significantly more outcomes change with finer steps than over all records."""
    changed, cases = (
        sum(one.changed_cases for one in step_changes_of_each_record),
        sum(one.cases for one in step_changes_of_each_record),
    )
    found = []
    for one in step_changes_of_each_record:
        changes = share_of_changed_cases(one.changed_cases, one.cases, compared_cases_are_random_sample=True)
        if one.cases >= MIN_COMPARED_CASES_PER_RECORD and (changes.low or 0.0) * cases > changed:
            found.append(FinerStepChangeFindingOfRecord(record=one.record, changes=changes))
    return sorted(found, key=lambda one: -(one.changes.value or 0.0))


def final_twist_findings(results: StudyResults) -> FinalTwistOfMovedStandingStones | None:
    """Summarise the rotation about the vertical, degrees, of bodies that moved and stand; None in 2-D and for stacks.

    The findings `element_displacements` have the rotations of the stones of a stack.
    """
    if results.study.is_stack or not results.model.can_rotate_about_vertical:
        return None
    found = summarise_twists_sorting_in_place(
        np.concatenate(list(moved_stone_twist_deg_by_b_over_h_and_friction(results.reference_element_cube).values()))
    )
    return FinalTwistOfMovedStandingStones(
        moved_standing_stone_count=found.stone_count,
        median_abs_twist_deg=found.median_deg,
        percentile_90_abs_twist_deg=found.upper_quantile_deg,
        largest_abs_twist_deg=found.largest_deg,
    )


def ensemble_findings(results: StudyResults) -> EnsembleDisagreementFindings | None:
    """Compute the shares of cases whose ensemble runs disagree about the fall; None without an ensemble."""
    cube, settings = results.reference_element_cube, results.study.ensemble
    if "members" not in cube:
        return None
    found = apply_to_record_batches_and_join(
        partial(count_cases_with_disagreeing_runs_by_record, results.model, settings),
        cube,
        (*results.model.variable_names_read_for_fall_probability, "members"),
    )
    sums = found.drop_vars(("fewest", "most")).sum()

    def ratio_of_sums_over_records(numerator_count_name: str, denominator_count_name: str) -> float:
        """Return the ratio of two counts, given by name and summed over all records; NaN if the second sum is 0."""
        return (
            float(sums[numerator_count_name]) / float(sums[denominator_count_name])
            if float(sums[denominator_count_name])
            else float("nan")
        )

    return EnsembleDisagreementFindings(
        share_of_cells_repeated=ratio_of_sums_over_records("run", "cells"),
        repeats_every_cell=settings.has_ensemble_runs_for_all_cases(cube.sizes["b_over_h"]),
        fewest_runs_per_cell=float(found["fewest"].min()),
        most_runs_per_cell=float(found["most"].max()),
        mean_runs_per_cell=ratio_of_sums_over_records("members", "with_members"),
        runs_per_cell_in_first_batch=min(MEMBERS_PER_BATCH, settings.members),
        share_of_repeated_cells_with_fall_and_stand=ratio_of_sums_over_records("divided", "with_first_batch"),
        share_of_repeated_cells_falling_to_both_sides=ratio_of_sums_over_records("apart", "agree"),
        fall_shares_by_base_relief=share_of_fall_variance_due_to_base_relief(results),
    )


def count_cases_with_disagreeing_runs_by_record(
    model: Model, ensemble_settings: EnsembleSettings, cube: xr.Dataset
) -> xr.Dataset:
    """Count by record the ensemble runs and the cases: all, with runs, with disagreeing runs, with falls to both sides.

    Runs are slightly changed repetitions of a case. Disagreement is estimated for the cases ``with_first_batch``, in
    which no fewer runs have an outcome than the first batch contains.
    """
    found, half = (
        model.ensemble_fall_shares_by_side_and_case(cube),
        cube.isel({model.direction_dimension_name: model.distinct_direction_indices(cube)}),
    )
    run, members = found["towards"].notnull(), half["members"].where(half["members"] > 0)

    def unbiased_first_batch_statistic_by_case(run_statistic: RunCountStatistic) -> xr.DataArray:
        """Estimate, for each case, a statistic of the first batch of its runs, unbiased by early stopping of runs."""
        return run.copy(
            data=average_first_batch_statistic_over_run_orders(
                run_statistic, found["towards"], found["away"], members.fillna(0), ensemble_settings
            )
        )

    over = [name for name in run.dims if name != "record"]
    divided = unbiased_first_batch_statistic_by_case(indicator_that_some_runs_fall_and_others_stand)
    counts = xr.Dataset({
        "cells": xr.ones_like(run),
        "run": run,
        "with_first_batch": divided.notnull(),
        "divided": divided,
        "agree": found.get("agree", divided.notnull()),
        "apart": (
            found["apart"] if "apart" in found else
            unbiased_first_batch_statistic_by_case(indicator_that_most_runs_fall_and_sides_differ)
        ),
        "members": members,
        "with_members": members.notnull(),
    }).sum(over)  # fmt: skip
    return counts.assign(fewest=members.min(over), most=members.max(over))
