"""Shares of cases that change when part of a study is computed again."""

import math

from overturning.findings.values import FindingBaseClass, OptionalNumberOrInfinity
from overturning.study.convergence import ConvergenceCheckResult, OutcomeChangesOfElement
from overturning.study.ensemble import wilson_95_percent_interval


class ChangedCaseCountAndShare(FindingBaseClass):
    """Number and share of cases whose outcome changes if they are computed again in another way.

    The interval of the share is that of Wilson, for a random sample of the cases.
    """

    changed_count: int
    """Number of cases that change."""
    compared_count: int
    """Number of cases that are compared."""
    value: OptionalNumberOrInfinity
    """Share of the compared cases that change; None if none is compared."""
    low: OptionalNumberOrInfinity
    """Lower end of the 95 % interval; None if all cases of the study are compared."""
    high: OptionalNumberOrInfinity


class ComparisonWithMoreExactComputation(FindingBaseClass):
    """Changes of outcomes if cases are computed again with shorter steps, stiffer contacts or a rigid block."""

    more_exact_computation_kind: str
    """"finer" (shorter steps), "stiffer" (stiffer contact), or "rigid" (exact rigid block without sliding)."""
    step_count_or_stiffness_factor: OptionalNumberOrInfinity
    """Factor on the number of steps or on the stiffness; None for the rigid block."""
    element: str
    """Element that is compared; empty for a single block."""
    refusal_reason: str
    """Reason why the computation was not possible; otherwise empty."""
    fall_or_stand_changes: ChangedCaseCountAndShare
    """Cases that fall in one computation and stand in the other."""
    fall_or_stand_changes_if_ensemble_agrees: ChangedCaseCountAndShare
    """Share of `fall_or_stand_changes` among the cases whose ensemble agrees whether the block falls."""
    fall_side_changes: ChangedCaseCountAndShare
    """Cases that fall in both computations, but to different sides (in 3-D: 30° or more apart)."""
    fall_side_changes_if_ensemble_agrees: ChangedCaseCountAndShare
    """Share of `fall_side_changes` among the cases whose ensemble falls to one side only."""


def share_of_changed_cases(
    changed_case_count: int, compared_case_count: int, compared_cases_are_random_sample: bool
) -> ChangedCaseCountAndShare:
    """Return the share of compared cases whose outcome changed in a second computation.

    It has Wilson's 95 % interval if the compared cases are a random sample.
    """
    low, high = (
        map(float, wilson_95_percent_interval(changed_case_count, compared_case_count))
        if compared_cases_are_random_sample and compared_case_count
        else (math.nan, math.nan)
    )
    share = changed_case_count / compared_case_count if compared_case_count else math.nan
    return ChangedCaseCountAndShare(
        changed_count=changed_case_count, compared_count=compared_case_count, value=share, low=low, high=high
    )


def comparisons_with_second_computations(
    convergence: ConvergenceCheckResult,
) -> list[ComparisonWithMoreExactComputation]:
    """Return how many outcomes, by scene element, change in each second computation of a convergence check.

    Second computations use shorter time steps, stiffer contacts, or the exact solution for rigid blocks.
    """
    rows = []
    for name, factor, part in (
        ("finer", convergence.time_step_refinement, convergence.finer_step_rerun), ("stiffer",
        convergence.contact_stiffness_factor, convergence.stiffer_contact_rerun)
    ):  # fmt: skip
        sampled = convergence.rerun_case_count < convergence.simulated_study_cell_count
        rows += [
            _comparison_of_element_with_second_computation(name, factor, one, sampled)
            for one in part.changes_by_element
        ]
        if not part.changes_by_element:
            none = share_of_changed_cases(0, 0, sampled)
            rows.append(
                ComparisonWithMoreExactComputation(
                    more_exact_computation_kind=name, step_count_or_stiffness_factor=factor, element="",
                    refusal_reason=part.refusal_reason,
                    fall_or_stand_changes=none,
                    fall_or_stand_changes_if_ensemble_agrees=none, fall_side_changes=none,
                    fall_side_changes_if_ensemble_agrees=none,
                )
            )  # fmt: skip
    rigid = convergence.rigid_block_comparison
    if rigid is not None and rigid.cases:
        rows.append(
            _comparison_of_element_with_second_computation(
                "rigid", math.nan, rigid, rigid.cases + rigid.unanswered < rigid.non_sliding_block_cells
            )
        )
    return rows


def _comparison_of_element_with_second_computation(
    more_exact_computation_kind: str,
    step_count_or_stiffness_factor: float,
    element_changes: OutcomeChangesOfElement,
    compared_cases_are_random_sample: bool,
) -> ComparisonWithMoreExactComputation:
    """Return how many outcomes of one scene element change in a second computation, such as with shorter steps."""
    return ComparisonWithMoreExactComputation(
        more_exact_computation_kind=more_exact_computation_kind,
        step_count_or_stiffness_factor=step_count_or_stiffness_factor,
        element=element_changes.element,
        refusal_reason="",
        fall_or_stand_changes=share_of_changed_cases(
            element_changes.flags, element_changes.cases, compared_cases_are_random_sample
        ),
        fall_or_stand_changes_if_ensemble_agrees=share_of_changed_cases(
            element_changes.falls_in_one_only_if_members_agree,
            element_changes.cases_with_agreeing_members,
            compared_cases_are_random_sample,
        ),
        fall_side_changes=share_of_changed_cases(
            element_changes.sides, element_changes.fallen, compared_cases_are_random_sample
        ),
        fall_side_changes_if_ensemble_agrees=share_of_changed_cases(
            element_changes.different_sides_if_members_fall_to_one_side,
            element_changes.falls_in_both_if_members_fall_to_one_side,
            compared_cases_are_random_sample,
        ),
    )
