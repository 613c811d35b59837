"""Shares of cases that change in a second computation, and axes on two grounds, with known values."""

import numpy as np
import pytest
import xarray as xr

from overturning.findings.comparison import comparisons_with_second_computations, share_of_changed_cases
from overturning.findings.exactness import _records_with_unusually_many_outcome_changes
from overturning.findings.soil import angles_between_soil_and_rock_fall_axes_deg
from overturning.study.convergence import (
    ChangesWithFinerSteps,
    ConvergenceCheckResult,
    FinerStepOutcomeChangeCountOfRecord,
    OutcomeChangesOfElement,
    RerunOutcomeChangesOrFailureReason,
    RigidComparison,
)

OUTCOME_CHANGE_COUNTS_OF_RERUN = {
    "cases": 100, "flags": 4, "fallen": 50, "sides": 5, "unanswered": 2, "cases_with_agreeing_members": 80,
    "falls_in_one_only_if_members_agree": 1,
    "different_fall_sides_if_members_agree": 3, "falls_in_both_if_members_agree": 40,
    "falls_in_both_if_members_fall_to_one_side": 30,
    "different_sides_if_members_fall_to_one_side": 3,
}  # fmt: skip


def test_interval_of_a_share_is_that_of_wilson() -> None:
    """Wilson (1927), written out: (p + z²/2n ± z √(p(1 − p)/n + z²/4n²))/(1 + z²/n)."""
    found, n, z = share_of_changed_cases(5, 50, compared_cases_are_random_sample=True), 50, 1.959964
    middle, half = 0.1 + z * z / (2 * n), z * np.sqrt(0.1 * 0.9 / n + z * z / (4 * n * n))
    assert found.low == pytest.approx((middle - half) / (1 + z * z / n), rel=1e-5)
    assert found.high == pytest.approx((middle + half) / (1 + z * z / n), rel=1e-5)
    every = share_of_changed_cases(5, 50, compared_cases_are_random_sample=False)
    assert (every.value, every.low, every.high) == (0.1, None, None), "a count of all cases has no interval"
    assert share_of_changed_cases(0, 0, compared_cases_are_random_sample=True).value is None


def test_finer_stiffer_and_rigid_computations_give_shares_of_changed_cases() -> None:
    one = OutcomeChangesOfElement(element="", **OUTCOME_CHANGE_COUNTS_OF_RERUN)
    rigid = RigidComparison(element="", non_sliding_block_cells=102, **OUTCOME_CHANGE_COUNTS_OF_RERUN)
    found = ConvergenceCheckResult(
        seed=1, wanted_case_count=100, rerun_case_count=102, rerun_cases_at_rest=0, study_cell_count=1000,
        simulated_study_cell_count=500, study_block_steps=1, max_cost_relative_to_study=1.0, time_step_refinement=8,
        contact_stiffness_factor=4.0, finer_step_rerun=RerunOutcomeChangesOrFailureReason(block_steps=1,
        changes_by_element=[one]),
        stiffer_contact_rerun=RerunOutcomeChangesOrFailureReason(block_steps=0, changes_by_element=[],
        refusal_reason="too stiff"),
        tests_of_finer_step_changes=ChangesWithFinerSteps(changed_cases=0, retested_cases=0, confirmed_cases=0,
        chaotic_cases=0, block_steps=0), amplitude_change_rerun=None,
        rigid_block_comparison=rigid,
    )  # fmt: skip
    finer, stiffer, exact = comparisons_with_second_computations(found)
    shares = [
        finer.fall_or_stand_changes,
        finer.fall_or_stand_changes_if_ensemble_agrees,
        finer.fall_side_changes,
        finer.fall_side_changes_if_ensemble_agrees,
    ]
    assert [one.value for one in shares] == pytest.approx([0.04, 1 / 80, 0.1, 0.1])
    assert (stiffer.refusal_reason, stiffer.fall_side_changes.value) == ("too stiff", None)
    assert exact.step_count_or_stiffness_factor is None
    assert exact.fall_side_changes.low is None, "all blocks that cannot slide are compared: no interval"
    assert finer.fall_side_changes.low is not None


def test_fall_axes_on_rock_and_soil_are_compared_where_both_are_clear() -> None:
    def dataset_of_fall_axes(axes: list[float], rates: list[float], resultants: list[float]) -> xr.Dataset:
        parts = {"fall_axis": axes, "fall_rate": rates, "fall_resultant": resultants}
        return xr.Dataset({name: ("record", values) for name, values in parts.items()})

    rock = dataset_of_fall_axes([10.0, 170.0, 50.0, 50.0, 20.0], [0.5, 0.5, 0.01, 0.5, 0.5], [0.5] * 5)
    soil = dataset_of_fall_axes([30.0, 5.0, 80.0, 80.0, 110.0], [0.5] * 5, [0.5, 0.5, 0.5, 0.01, 0.5])
    # 170° and 5° are 15° apart as axes; the third falls too rarely on rock, the fourth has no axis on soil.
    assert angles_between_soil_and_rock_fall_axes_deg(soil, rock) == pytest.approx([20.0, 15.0, 90.0])


def test_records_with_clearly_more_changed_outcomes_than_average_are_listed() -> None:
    """By Wilson's interval, 6 changed outcomes of 90 are clearly above the average of all records; 4 of 90 are not."""
    rows = [
        FinerStepOutcomeChangeCountOfRecord(record=f"calm-{number}", cases=90, changed_cases=1) for number in range(10)
    ]
    loud, doubtful = (
        FinerStepOutcomeChangeCountOfRecord(record=name, cases=90, changed_cases=changed)
        for name, changed in (("loud", 6), ("doubtful", 4))
    )
    found = _records_with_unusually_many_outcome_changes(
        [*rows, loud, doubtful, FinerStepOutcomeChangeCountOfRecord(record="few", cases=8, changed_cases=3)]
    )
    assert [(one.record, one.changes.changed_count, one.changes.compared_count) for one in found] == [("loud", 6, 90)]
    assert found[0].changes.low == pytest.approx(0.0309, abs=2e-4)
    assert _records_with_unusually_many_outcome_changes([]) == []
