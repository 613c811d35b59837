"""Convergence check: a random sample of a study is run again with finer steps and with stiffer springs.

Cells whose blocks cannot slide are also compared with the exact rigid block.

A case whose outcome changes with finer steps is run again with half that step, and with the motion scaled by
1 + `RELATIVE_AMPLITUDE_PERTURBATION`. If both agree, the outcome of the finer steps stands; if the second differs, the
case is chaotic.
"""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.dem.numerics import ProgressCallback
from overturning.dem.run import simulate_cases
from overturning.errors import ArgumentError
from overturning.model.cases import Cases
from overturning.model.results import CaseResults
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion
from overturning.records.record import Record
from overturning.study.answers import (
    CaseOutcomeArray,
    count_outcome_differences,
    fall_azimuths_differ,
    mask_of_cases_with_different_falls,
)
from overturning.study.convergence import (
    LARGEST_AMPLITUDE_CHANGE_IN_COMPARED_RERUNS,
    MIN_COUNTED_FALL_AZIMUTH_SHIFT_DEG,
    RELATIVE_AMPLITUDE_PERTURBATION,
    ChangesWithFinerSteps,
    ConvergenceCheckResult,
    FallChangesUnderSlightlyChangedAmplitude,
    FinerStepOutcomeChangeCountOfRecord,
    OutcomeChangesOfElement,
    RerunOutcomeChangesOrFailureReason,
    RigidComparison,
)
from overturning.study.sample import RandomCaseSample
from overturning.study.scenes import (
    numerical_options_of_study,
    record_motion_with_up_only_if_variant_uses_it,
    variant_grid,
    variant_model,
)
from overturning.study.schema import Study
from overturning.units import STANDARD_GRAVITY

TIME_STEP_DIVISOR_OF_FINER_RERUN: Final = 8
"""Refinement factor of the time step."""

CONTACT_STIFFNESS_FACTOR_OF_STIFFER_RERUN: Final = 4.0
"""Factor on the contact stiffness; the finest steps are halved with it, the whole step is not."""

PILOT_CASE_COUNT: Final = 16
"""Number of cases that are run first, to estimate the cost of a case."""

ASSUMED_COST_RATIO_OF_FINER_TO_STIFFER_RERUN: Final = 9.0
"""Largest ratio of block steps with finer steps to those with stiffer springs: 8, plus reruns."""


def rerun_cases_with_finer_steps_and_stiffer_contacts(
    study: Study,
    records: Sequence[Record],
    case_sample: RandomCaseSample,
    thread_count: int = 1,
    progress: ProgressCallback | None = None,
    sample_for_rigid_block_comparison: RandomCaseSample | None = None,
) -> ConvergenceCheckResult:
    """Rerun a random sample of cases with finer steps and stiffer contacts, at a limited cost; count changed outcomes.

    The cost is counted in block time steps. Stiffer springs are run first, in growing batches; their cost predicts that
    of finer steps. Finer steps are run for the first cases of the same random order, as many as the remaining cost
    permits, and only these cases are evaluated, for stiffer springs as well. `records` are the processed records in the
    order of the study; the key `verification` of the study must hold settings, not a word such as "none". The result
    does not depend on the number of threads. `progress` is called with the number of finished cases and the largest
    possible number of cases of the two reruns. `sample_for_rigid_block_comparison`, from
    `read_sample_to_compare_with_rigid_block`, holds the cases to compare with the exact rigid block.
    """
    settings = study.verification
    assert not isinstance(settings, str)  # the workflow does not ask for it
    allowed = round(settings.cost * case_sample.block_time_step_count_of_whole_study)
    runs = _CaseReruns(study, records, case_sample, thread_count, progress)
    # If springs four times stiffer are refused (numerical limits), only the finer steps are run.
    if runs.rerun_affordable_cases_unless_refused(
        "stiffer", 1.0 + ASSUMED_COST_RATIO_OF_FINER_TO_STIFFER_RERUN, allowed
    ):
        spent = runs.rerun_outcomes_by_kind["stiffer"]["block_steps"]
        affordable = np.cumsum(ASSUMED_COST_RATIO_OF_FINER_TO_STIFFER_RERUN * spent)
        runs.rerun_missing_first_cases_unless_refused(
            "finer", int(np.searchsorted(affordable, allowed - int(spent.sum()), side="right"))
        )
    else:
        runs.rerun_affordable_cases_unless_refused("finer", 1.0, allowed)
    count = len(runs.rerun_outcomes_by_kind["finer"])
    done = sum(int(one["block_steps"].sum()) for one in runs.rerun_outcomes_by_kind.values())
    return ConvergenceCheckResult(
        seed=settings.seed,
        wanted_case_count=len(case_sample.record_indices),
        rerun_case_count=count,
        rerun_cases_at_rest=int(case_sample.is_below_rocking_and_sliding_thresholds[:count].sum()),
        study_cell_count=len(records) * runs.grid.case_count,
        simulated_study_cell_count=case_sample.study_case_count_without_symmetry_copies,
        study_block_steps=case_sample.block_time_step_count_of_whole_study,
        max_cost_relative_to_study=settings.cost,
        time_step_refinement=TIME_STEP_DIVISOR_OF_FINER_RERUN,
        contact_stiffness_factor=CONTACT_STIFFNESS_FACTOR_OF_STIFFER_RERUN,
        finer_step_rerun=runs.count_changed_outcomes("finer", count),
        stiffer_contact_rerun=runs.count_changed_outcomes("stiffer", count),
        tests_of_finer_step_changes=(
            settling := runs.rerun_and_count_confirmed_and_chaotic_changes(count, allowed - done)
        ),
        amplitude_change_rerun=runs.rerun_falls_and_count_changes_with_amplitude(
            count, allowed - done - settling.block_steps
        ),
        rigid_block_comparison=None
        if sample_for_rigid_block_comparison is None
        else _CaseReruns(
            study, records, sample_for_rigid_block_comparison, thread_count, None
        ).rerun_sample_as_rigid_blocks_and_compare(),
        finer_step_changes_by_record=runs.count_finer_step_changes_by_record(
            count, [record.record_id for record in records]
        ),
    )


class _CaseReruns:
    """Random sample of a study's cases, computed again with finer steps, stiffer springs etc., with all outcomes."""

    def __init__(
        self,
        study: Study,
        records: Sequence[Record],
        case_sample: RandomCaseSample,
        thread_count: int,
        progress: ProgressCallback | None,
    ) -> None:
        self.sample, self.threads, self.progress = case_sample, thread_count, progress
        self.motions, self.grid = (
            [record_motion_with_up_only_if_variant_uses_it(study, record) for record in records],
            variant_grid(study),
        )
        self.rerun_function_by_kind: dict[str, Callable[[Motion, Cases], Any]] = {
            **rerun_functions_by_rerun_kind(study),
            "rigid": simulate_cases_as_exact_rigid_blocks,
        }
        self.is_planar = variant_model(study).is_planar
        self.rerun_outcomes_by_kind = dict.fromkeys(("finer", "stiffer"), case_sample.study_outcomes[:0])
        self.refusal_reason_by_kind: dict[str, str] = {}

    def rerun_affordable_cases_unless_refused(
        self, rerun_kind: str, all_reruns_to_this_rerun_step_ratio: float, max_block_time_steps_of_reruns: int
    ) -> bool:
        """Rerun as many cases as a limit on block time steps permits; return False if the solver refuses the rerun."""
        most = len(self.sample.record_indices)
        size = min(PILOT_CASE_COUNT, most, max(self.sample.study_case_count_without_symmetry_copies // 12, 1))
        while size > 0:
            done = len(self.rerun_outcomes_by_kind[rerun_kind]) + size
            if not self.rerun_missing_first_cases_unless_refused(rerun_kind, done):
                return False
            mean = all_reruns_to_this_rerun_step_ratio * float(
                self.rerun_outcomes_by_kind[rerun_kind]["block_steps"].mean()
            )
            affordable = most if mean == 0 else min(most, int(0.95 * max_block_time_steps_of_reruns / mean))
            size = min(affordable - done, 3 * done)
        return True

    def rerun_missing_first_cases_unless_refused(self, rerun_kind: str, count_of_first_sample_cases: int) -> bool:
        """Rerun the first cases of the sample, but for those already done; return False if the solver refuses them."""
        try:
            more = self._rerun_cases(
                rerun_kind, np.arange(len(self.rerun_outcomes_by_kind[rerun_kind]), count_of_first_sample_cases)
            )
        except ArgumentError as error:
            self.refusal_reason_by_kind[rerun_kind] = str(error)
            return False
        self.rerun_outcomes_by_kind[rerun_kind] = np.concatenate([self.rerun_outcomes_by_kind[rerun_kind], more])
        if self.progress:
            self.progress(sum(map(len, self.rerun_outcomes_by_kind.values())), 2 * len(self.sample.record_indices))
        return True

    def _rerun_cases(
        self, rerun_kind: str, case_numbers_in_sample: NDArray[np.int64], motion_amplitude_factor: float = 1.0
    ) -> CaseOutcomeArray:
        """Compute the given cases of the sample again, with motions scaled by a factor; return the outcomes."""
        answers = np.zeros(case_numbers_in_sample.size, self.sample.study_outcomes.dtype)

        def rerun_sampled_cases_of_record(record_index: int) -> None:
            """Compute the chosen cases of one record again, and store their outcomes."""
            mine = self.sample.record_indices[case_numbers_in_sample] == record_index
            chosen = self.sample.grid_indices[case_numbers_in_sample[mine]]
            cases = self.grid.cases_at_grid_indices(list(chosen.T), amplitude=motion_amplitude_factor)
            results = self.rerun_function_by_kind[rerun_kind](self.motions[record_index], cases)
            answers["overturned"][mine] = results.overturned.reshape(len(chosen), -1)
            answers["azimuth"][mine] = np.nan
            if not self.is_planar:
                answers["azimuth"][mine] = results.fall_azimuth.reshape(len(chosen), -1)
            answers["block_steps"][mine] = getattr(results, "block_steps", 0)

        with ThreadPoolExecutor(max_workers=self.threads) as pool:
            list(
                pool.map(
                    rerun_sampled_cases_of_record,
                    np.unique(self.sample.record_indices[case_numbers_in_sample]).tolist(),
                )
            )
        return answers

    def count_changed_outcomes(
        self, rerun_kind: str, count_of_first_sample_cases: int
    ) -> RerunOutcomeChangesOrFailureReason:
        """Count the outcomes that one kind of rerun (such as finer steps) changes in the first cases of the sample."""
        if rerun_kind in self.refusal_reason_by_kind:
            return RerunOutcomeChangesOrFailureReason(
                block_steps=0, changes_by_element=[], refusal_reason=self.refusal_reason_by_kind[rerun_kind]
            )
        outcomes = self._count_changes_by_element(self.rerun_outcomes_by_kind[rerun_kind][:count_of_first_sample_cases])
        return RerunOutcomeChangesOrFailureReason(
            block_steps=int(self.rerun_outcomes_by_kind[rerun_kind]["block_steps"].sum()), changes_by_element=outcomes
        )

    def _count_changes_by_element(self, rerun_outcomes: CaseOutcomeArray) -> list[OutcomeChangesOfElement]:
        """Count, for each scene element, the cases whose outcome differs between the study and a second computation."""
        count, outcomes = len(rerun_outcomes), []
        own = self.sample.study_outcomes[:count]
        away = fall_azimuths_differ(own, rerun_outcomes)
        for column, name in enumerate(self.grid.free_element_names_if_several or ("",)):
            before, after = own["overturned"][:, column], rerun_outcomes["overturned"][:, column]
            sure = ~self.sample.ensemble_members_disagree_on_fall[:count, column]
            one_way = ~self.sample.ensemble_members_disagree_on_fall_or_side[:count, column]
            counts, those, agreed = (
                count_outcome_differences(before[chosen], after[chosen], away[chosen, column])
                for chosen in (np.ones_like(sure), sure, one_way)
            )
            undivided = {
                "cases_with_agreeing_members": those.cases, "falls_in_one_only_if_members_agree": those.flags,
                "different_fall_sides_if_members_agree": those.sides,
                "falls_in_both_if_members_agree": those.fallen,
                "falls_in_both_if_members_fall_to_one_side": agreed.fallen,
                "different_sides_if_members_fall_to_one_side": agreed.sides,
            }  # fmt: skip
            outcomes.append(OutcomeChangesOfElement(element=name, **undivided, **counts.model_dump()))
        return outcomes

    def rerun_sample_as_rigid_blocks_and_compare(self) -> RigidComparison:
        """Rerun all cases of the sample with the exact rigid block, and count the outcomes that differ."""
        every = np.arange(len(self.sample.record_indices))
        (found,) = self._count_changes_by_element(self._rerun_cases("rigid", every))
        return RigidComparison(
            non_sliding_block_cells=self.sample.study_case_count_without_symmetry_copies, **found.model_dump()
        )

    def count_finer_step_changes_by_record(
        self, count_of_first_sample_cases: int, record_ids: Sequence[str]
    ) -> list[FinerStepOutcomeChangeCountOfRecord]:
        """Count, by record, the outcomes that finer time steps change among the first cases of the sample."""
        known, changed = self._masks_of_known_and_changed_outcomes(count_of_first_sample_cases)
        record, found = self.sample.record_indices[:count_of_first_sample_cases], []
        for number, name in enumerate(record_ids):
            mine = known & (record == number)
            found.append(
                FinerStepOutcomeChangeCountOfRecord(
                    record=name, cases=int(mine.sum()), changed_cases=int((changed & mine).sum())
                )
            )
        return found

    def _masks_of_known_and_changed_outcomes(
        self, count_of_first_sample_cases: int
    ) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Return two masks of the first cases: outcome known with both time steps, and changed by the finer one."""
        own, finer = (
            self.sample.study_outcomes[:count_of_first_sample_cases],
            self.rerun_outcomes_by_kind["finer"][:count_of_first_sample_cases],
        )
        known = ((finer["overturned"] != INT8_MISSING) & (own["overturned"] != INT8_MISSING)).all(axis=1)
        return known, known & mask_of_cases_with_different_falls(finer, own)

    def rerun_and_count_confirmed_and_chaotic_changes(
        self, count_of_first_sample_cases: int, max_block_time_steps_of_reruns: int
    ) -> ChangesWithFinerSteps:
        """Rerun cases that finer steps change; count changes that are confirmed, and cases that are chaotic."""
        finer = self.rerun_outcomes_by_kind["finer"][:count_of_first_sample_cases]
        changed = np.flatnonzero(self._masks_of_known_and_changed_outcomes(count_of_first_sample_cases)[1])
        # Cost: steps half as long (2), and the finer steps once more (1).
        rows = changed[3 * np.cumsum(finer["block_steps"][changed]) <= max_block_time_steps_of_reruns]
        finest, nudged = (
            self._rerun_cases("finest", rows),
            self._rerun_cases("finer", rows, 1.0 + RELATIVE_AMPLITUDE_PERTURBATION),
        )
        kept = ~mask_of_cases_with_different_falls(nudged, finer[rows])
        return ChangesWithFinerSteps(
            changed_cases=changed.size,
            retested_cases=rows.size,
            confirmed_cases=int((~mask_of_cases_with_different_falls(finest, finer[rows]) & kept).sum()),
            chaotic_cases=int((~kept).sum()),
            block_steps=int(finest["block_steps"].sum() + nudged["block_steps"].sum()),
        )

    def rerun_falls_and_count_changes_with_amplitude(
        self, count_of_first_sample_cases: int, max_block_time_steps_of_reruns: int
    ) -> FallChangesUnderSlightlyChangedAmplitude | None:
        """Rerun 3-D falls with slightly weaker and stronger motions; count the falls that change (2-D: return None)."""
        own, finer = (
            self.sample.study_outcomes[:count_of_first_sample_cases],
            self.rerun_outcomes_by_kind["finer"][:count_of_first_sample_cases],
        )
        if self.is_planar:
            return None
        falls = np.flatnonzero((own["overturned"] == 1).any(axis=1))
        factors = 1.0 + LARGEST_AMPLITUDE_CHANGE_IN_COMPARED_RERUNS * np.array([-1.0, -0.5, 0.5, 1.0])
        # Estimate the cost from the finer steps.
        rows = falls[
            np.cumsum(finer["block_steps"][falls]) * (factors.size / TIME_STEP_DIVISOR_OF_FINER_RERUN)
            <= max_block_time_steps_of_reruns
        ]
        moved, stood, steps = np.zeros(rows.size, np.bool_), np.zeros(rows.size, np.bool_), 0
        for factor in factors:
            again = self._rerun_cases("nominal", rows, float(factor))
            moved |= fall_azimuths_differ(own[rows], again, MIN_COUNTED_FALL_AZIMUTH_SHIFT_DEG).any(axis=1)
            stood |= ((own["overturned"][rows] == 1) & (again["overturned"] == 0)).any(axis=1)
            steps += int(again["block_steps"].sum())
        weight = self.sample.fall_direction_statistics_weight[rows]
        return FallChangesUnderSlightlyChangedAmplitude(
            rerun_falls=rows.size,
            falls_with_shifted_azimuth=int(moved.sum()),
            falls_standing_in_a_rerun=int(stood.sum()),
            weight_of_rerun_falls=float(weight.sum()),
            weight_of_shifted_falls=float(weight[moved].sum()),
            block_steps=steps,
        )


def simulate_cases_as_exact_rigid_blocks(motion: Motion, cases: Cases) -> Any:
    """Simulate cases as exactly rigid blocks; no outcome if the ground accelerates downwards by g or more."""
    from overturning.dem.block.rigid import simulate_rigid_rocking  # imported lazily: imports Numba

    found, lowest = simulate_rigid_rocking(motion, cases), 0.0 if motion.up is None else float(motion.up.min())
    left = np.asarray(cases.amplitude) * lowest <= -STANDARD_GRAVITY
    return found._replace(overturned=np.where(left, np.int8(INT8_MISSING), found.overturned))


def rerun_functions_by_rerun_kind(study: Study) -> dict[str, Callable[[Motion, Cases], CaseResults]]:
    """Return functions that compute cases again: unchanged, with finer or finest time steps, or stiffer springs.

    With stiffer springs, a time step given in seconds is shortened like the period of the contact; an automatic time
    step follows the stable step.
    """
    numerics, model = numerical_options_of_study(study), variant_model(study)
    step = numerics.time_step
    finer, finest = (replace(numerics, refinement=times * TIME_STEP_DIVISOR_OF_FINER_RERUN) for times in (1, 2))
    shorter = replace(
        numerics, time_step=step if isinstance(step, str) else step / np.sqrt(CONTACT_STIFFNESS_FACTOR_OF_STIFFER_RERUN)
    )
    return {
        "nominal": partial(simulate_cases, model, numerics=numerics),
        "finer": partial(simulate_cases, model, numerics=finer),
        "finest": partial(simulate_cases, model, numerics=finest),
        "stiffer": partial(
            simulate_cases, model.with_stiffness_factor(CONTACT_STIFFNESS_FACTOR_OF_STIFFER_RERUN), numerics=shorter
        ),
    }
