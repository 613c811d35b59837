"""Result of a convergence check: changes of outcomes with finer steps, stiffer springs, and a rigid block."""

from pathlib import Path
from typing import Final

from pydantic import BaseModel

from overturning.stored import read_json_result
from overturning.study.answers import OutcomeDifferenceCountsOfTwoComputations

RELATIVE_AMPLITUDE_PERTURBATION: Final = 1e-9
"""Relative increase of the motion, far below its accuracy, that shows whether an outcome is chaotic."""

LARGEST_AMPLITUDE_CHANGE_IN_COMPARED_RERUNS: Final = 0.01
"""Largest relative change of the motion's amplitude with which falls are simulated again, to compare them."""

MIN_COUNTED_FALL_AZIMUTH_SHIFT_DEG: Final = 30.0
"""Smallest change of azimuth of a fall that counts as moved, degrees."""

MAX_CHANGED_SHARE_WITHOUT_WARNING: Final = 0.01
"""Share of changed fall flags above which the report warns; cases whose ensemble members disagree do not count."""


class OutcomeChangesOfElement(OutcomeDifferenceCountsOfTwoComputations):
    """Numbers of cases in which a second, more exact computation changes whether or how one scene element falls."""

    element: str  # name of the element; "" for a single block
    cases_with_agreeing_members: int  # cases with an outcome in both whose ensemble is not divided
    falls_in_one_only_if_members_agree: int  # of these, fall in one computation and stand in the other
    different_fall_sides_if_members_agree: int  # of these, that fall to the other side
    falls_in_both_if_members_agree: int  # undivided cases that fall in both
    falls_in_both_if_members_fall_to_one_side: (
        int  # fall in both, and all ensemble members fall to one side (or none was run)
    )
    different_sides_if_members_fall_to_one_side: int  # of these, that fall to the other side


class RigidComparison(OutcomeChangesOfElement):
    """Numbers of cases in which the outcome of the study differs from the solution for an exactly rigid block."""

    non_sliding_block_cells: int  # number of cells of the study with blocks that cannot slide


class RerunOutcomeChangesOrFailureReason(BaseModel):
    """Result of computing cases again, with finer time steps or stiffer springs: changed outcomes, or why it failed."""

    block_steps: int
    changes_by_element: list[OutcomeChangesOfElement]
    refusal_reason: str = ""


class ChangesWithFinerSteps(BaseModel):
    """Numbers of cases whose outcome changes with finer time steps, and of those confirmed or chaotic in a retest.

    A change is confirmed if two further runs, one with still finer steps and one with a motion larger by
    `RELATIVE_AMPLITUDE_PERTURBATION`, have the new outcome, too; a case is chaotic if the larger motion changes it.
    """

    changed_cases: int
    retested_cases: int
    confirmed_cases: int
    chaotic_cases: int
    block_steps: int


class FinerStepOutcomeChangeCountOfRecord(BaseModel):
    """Number of cases under one record whose outcome (fall or side) changes with finer time steps."""

    record: str
    cases: int  # cases with an outcome in both computations
    changed_cases: int


class FallChangesUnderSlightlyChangedAmplitude(BaseModel):
    """Numbers of 3-D falls that change if the motion is slightly weaker or stronger."""

    rerun_falls: int  # falls of the study that were run again
    falls_with_shifted_azimuth: (
        int  # falls whose azimuth moves by `MIN_COUNTED_FALL_AZIMUTH_SHIFT_DEG` under one of the motions
    )
    falls_standing_in_a_rerun: int  # falls whose stone stands under one of the motions
    weight_of_rerun_falls: float  # sum of the weights of these falls (`model.body.case_weight_in_direction_statistics`)
    weight_of_shifted_falls: float  # part of `weight_of_rerun_falls` whose fall direction changes
    block_steps: int


class ConvergenceCheckResult(BaseModel):
    """Result of a convergence check (cases computed again more exactly), stored in ``convergence.json``."""

    seed: int
    wanted_case_count: int
    rerun_case_count: int
    rerun_cases_at_rest: int
    study_cell_count: int
    simulated_study_cell_count: int  # of these, not copied by symmetry; if all were chosen there is no sampling error
    study_block_steps: int
    max_cost_relative_to_study: float
    time_step_refinement: int
    contact_stiffness_factor: float
    finer_step_rerun: RerunOutcomeChangesOrFailureReason
    stiffer_contact_rerun: RerunOutcomeChangesOrFailureReason
    tests_of_finer_step_changes: ChangesWithFinerSteps
    amplitude_change_rerun: FallChangesUnderSlightlyChangedAmplitude | None  # None for planar models
    rigid_block_comparison: RigidComparison | None  # None if no cell has a block that cannot slide
    finer_step_changes_by_record: list[FinerStepOutcomeChangeCountOfRecord] = []  # changes with finer steps


def read_convergence_result(convergence_json_path: Path) -> ConvergenceCheckResult:
    """Read the result of a convergence check; a `ResultError` if it is missing, damaged, or from another version."""
    return read_json_result(ConvergenceCheckResult, convergence_json_path, "convergence check")
