"""The convergence check: its sample, its counts, and its reproducibility."""

import json
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.stats import binomtest

from overturning.commands import workflow
from overturning.dem.numerics import NumericalOptions
from overturning.dem.polygon.prepare import prepare_scene
from overturning.dem.run import plan_simulation, run_cases, simulate_cases
from overturning.errors import ResultError
from overturning.findings.comparison import comparisons_with_second_computations
from overturning.model.cases import Cases
from overturning.model.contact import DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO, Contact
from overturning.model.planes import PlanarModel
from overturning.model.scene import gravestone
from overturning.motion.motion import Motion
from overturning.records.record import Record
from overturning.records.store import round_samples_to_stored_decimals
from overturning.settings import EnsembleSettings
from overturning.study.answers import (
    OutcomeDifferenceCountsOfTwoComputations,
    count_outcome_differences,
    create_outcome_array_to_fill,
)
from overturning.study.convergence import read_convergence_result
from overturning.study.convergence_check import (
    rerun_cases_with_finer_steps_and_stiffer_contacts,
    rerun_functions_by_rerun_kind,
)
from overturning.study.cube import open_cube
from overturning.study.ensemble import wilson_95_percent_interval
from overturning.study.load import study_from_content
from overturning.study.sample import (
    RandomCaseSample,
    choose_random_record_and_grid_indices,
    read_random_case_sample,
    read_sample_to_compare_with_rigid_block,
)
from overturning.study.scenes import variant_grid
from overturning.study.schema import Study
from overturning.study.sections import ConvergenceCheckSettings
from tests.dem.near_field import strong_part_of_near_field_record
from tests.study.small_study import simulate_study_cube, small_study

OUTCOME_CHANGE_COUNT_FIELDS = {
    "element": "", "cases": 200, "flags": 2, "cases_with_agreeing_members": 160,
    "falls_in_one_only_if_members_agree": 1,
    "different_fall_sides_if_members_agree": 0, "fallen": 50,
    "sides": 0, "falls_in_both_if_members_agree": 45, "falls_in_both_if_members_fall_to_one_side": 40,
    "different_sides_if_members_fall_to_one_side": 0, "unanswered": 0,
}  # fmt: skip
CONVERGENCE_RESULT_FIELDS = {
    "seed": 1, "wanted_case_count": 200, "rerun_case_count": 200, "rerun_cases_at_rest": 0, "study_cell_count": 9000,
    "simulated_study_cell_count": 4500, "study_block_steps": 1000,
    "max_cost_relative_to_study": 1.0, "time_step_refinement": 8, "contact_stiffness_factor": 4.0,
    "finer_step_rerun": {"block_steps": 500, "changes_by_element": [OUTCOME_CHANGE_COUNT_FIELDS]},
    "stiffer_contact_rerun": {"block_steps": 0, "changes_by_element": [], "refusal_reason": "too stiff"},
    "tests_of_finer_step_changes": {"changed_cases": 0, "retested_cases": 0, "confirmed_cases": 0, "chaotic_cases": 0,
    "block_steps": 0},
    "amplitude_change_rerun": None, "rigid_block_comparison": None,
}  # fmt: skip


def test_wilson_intervals_equal_those_of_scipy() -> None:
    count, total = np.array([0, 3, 200, 17, 1]), np.array([200, 200, 200, 40, 1])
    expected = [binomtest(n, of).proportion_ci(method="wilson") for n, of in zip(count, total, strict=True)]
    low, high = wilson_95_percent_interval(count, total)
    np.testing.assert_allclose(np.stack([low, high], axis=1), expected, rtol=0, atol=1e-12)


def test_the_wilson_interval_without_cases_is_0_to_1() -> None:
    assert wilson_95_percent_interval(0, 0) == (0.0, 1.0)


def test_comparison_of_outcomes_counts_each_kind_of_change_once() -> None:
    first = np.array([0, 0, 1, 1, -1, -1, -128, 1, -128], np.int8)
    second = np.array([0, 1, 0, -1, -1, 1, 0, -128, -128], np.int8)
    found = count_outcome_differences(first, second)
    assert found == OutcomeDifferenceCountsOfTwoComputations(cases=6, flags=2, fallen=3, sides=2, unanswered=3)
    assert found + found == OutcomeDifferenceCountsOfTwoComputations(cases=12, flags=4, fallen=6, sides=4, unanswered=6)


def test_cases_to_check_are_drawn_without_repetition_or_mirror_images() -> None:
    computed = np.ones((10, 1, 20, 2), bool)
    computed[5:] = False
    record, cells = choose_random_record_and_grid_indices(ConvergenceCheckSettings(share=0.1, at_least=7), 3, computed)
    assert len(record) == round(0.1 * 3 * 400)
    assert computed[tuple(cells.T)].all()
    assert len(np.unique(np.column_stack([record, cells]), axis=0)) == len(cells)
    fewer = choose_random_record_and_grid_indices(ConvergenceCheckSettings(share=0.001, at_least=50), 3, computed)
    assert len(fewer[0]) == 50
    np.testing.assert_array_equal(fewer[1], cells[:50], "a first part of the order is a choice too")
    assert (
        len(choose_random_record_and_grid_indices(ConvergenceCheckSettings(at_least=10_000), 3, computed)[0]) == 600
    ), "all of a small study"
    other = choose_random_record_and_grid_indices(ConvergenceCheckSettings(share=0.1, seed=2), 3, computed)
    assert not np.array_equal(other[1], cells)


@cache
def near_field_strong_part(number: int, name: str = "a") -> Record:
    """Return near-field record `number` from 4 s before its peak to 8 s after it, as a record called `name`."""
    motion = strong_part_of_near_field_record(number, 4.0, 8.0)
    return round_samples_to_stored_decimals(Record(name, motion.north, motion.east, None, motion.sampling_interval))


@dataclass(frozen=True)
class SimulatedRecordsAndCaseSample:
    """Records of a study that was simulated, and the cells drawn from its cube to be simulated again."""

    records: list[Record]
    sample: RandomCaseSample

    def sample_with_replaced_flags(self, overturned: Any, divided: Any = None) -> RandomCaseSample:
        """Return the sample with these overturning flags, as if the study had found them.

        `divided`, if given, replaces the flags of cells whose ensemble members disagree on the fall.
        """
        answers = self.sample.study_outcomes.copy()
        answers["overturned"] = overturned
        divided = self.sample.ensemble_members_disagree_on_fall if divided is None else divided
        return replace(
            self.sample,
            study_outcomes=answers,
            ensemble_members_disagree_on_fall=divided,
            ensemble_members_disagree_on_fall_or_side=self.sample.ensemble_members_disagree_on_fall_or_side | divided,
        )


def simulate_study_and_draw_case_sample(
    settings: Study, records: list[Record], folder: Path
) -> SimulatedRecordsAndCaseSample:
    """Simulate a small study without an ensemble and draw the cells to check from its cube."""
    alone = settings.model_copy(update={"ensemble": EnsembleSettings(members=0)})
    assert isinstance(settings.verification, ConvergenceCheckSettings)
    return SimulatedRecordsAndCaseSample(
        records, read_random_case_sample(simulate_study_cube(alone, records, folder), settings.verification)
    )


def test_convergence_check_counts_steps_and_changed_flags_for_any_number_of_threads(tmp_path: Path) -> None:
    settings = small_study(verification={"at_least": 10, "cost": 20})
    done = simulate_study_and_draw_case_sample(
        settings, [near_field_strong_part(7, "a"), near_field_strong_part(8, "b")], tmp_path
    )
    found = rerun_cases_with_finer_steps_and_stiffer_contacts(settings, done.records, done.sample)
    assert found.rerun_case_count == found.wanted_case_count == 10
    (finer,), (stiffer,) = found.finer_step_rerun.changes_by_element, found.stiffer_contact_rerun.changes_by_element
    assert finer.cases + finer.unanswered == 10

    def total_block_steps_of_sample_cases(**changed: Any) -> int:
        chosen = (
            study_cases_at_grid_indices(settings, done.sample.grid_indices[done.sample.record_indices == number])
            for number in (0, 1)
        )
        each = zip(map(Motion.of, done.records), chosen, strict=True)
        return sum(int(run_cases(motion, one, **changed).block_steps.sum()) for motion, one in each)

    def planned_time_steps_per_motion_sample(model: PlanarModel | None = None, **changed: Any) -> np.ndarray:
        numerics = NumericalOptions(time_step="0.01 stable", **changed)
        return plan_simulation(
            model or PlanarModel(),
            Motion.of(near_field_strong_part(7)),
            study_cases_at_grid_indices(settings, done.sample.grid_indices),
            numerics,
        ).steps_per_sample

    stiff = {
        "model": PlanarModel(gravestone(Contact(static_penetration=DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO / 4)))
    }
    np.testing.assert_array_equal(
        planned_time_steps_per_motion_sample(refinement=8), 8 * planned_time_steps_per_motion_sample()
    )
    # Whole steps follow the motion, whatever the contact.
    np.testing.assert_array_equal(planned_time_steps_per_motion_sample(**stiff), planned_time_steps_per_motion_sample())
    assert found.finer_step_rerun.block_steps == total_block_steps_of_sample_cases(refinement=8)
    assert found.stiffer_contact_rerun.block_steps == total_block_steps_of_sample_cases(**stiff)
    opposite = np.where(done.sample.study_outcomes["overturned"] == 0, 1, 0).astype(np.int8)
    wrong = rerun_cases_with_finer_steps_and_stiffer_contacts(
        settings, done.records, done.sample_with_replaced_flags(opposite)
    )
    assert wrong.finer_step_rerun.changes_by_element[0].flags == 10 - finer.flags
    assert wrong.stiffer_contact_rerun.changes_by_element[0].flags == 10 - stiffer.flags
    # Where the ensemble is divided anyway a changed flag is counted, but not among those that matter.
    assert (
        wrong.finer_step_rerun.changes_by_element[0].falls_in_one_only_if_members_agree
        == wrong.finer_step_rerun.changes_by_element[0].flags
    )
    assert (
        wrong.finer_step_rerun.changes_by_element[0].cases_with_agreeing_members
        == wrong.finer_step_rerun.changes_by_element[0].cases
    )
    unsure = done.sample_with_replaced_flags(opposite, divided=np.ones(opposite.shape, np.bool_))
    (all_divided,) = rerun_cases_with_finer_steps_and_stiffer_contacts(
        settings, done.records, unsure
    ).finer_step_rerun.changes_by_element
    zeros = (
        "cases_with_agreeing_members",
        "falls_in_one_only_if_members_agree",
        "falls_in_both_if_members_agree",
        "falls_in_both_if_members_fall_to_one_side",
        "different_sides_if_members_fall_to_one_side",
    )
    none = dict.fromkeys(zeros, 0)
    assert all_divided == wrong.finer_step_rerun.changes_by_element[0].model_copy(update=none)
    # Falls to the other side are counted where the members fall one way, and not where they fall to both.
    turned = done.sample_with_replaced_flags(-done.sample.study_outcomes["overturned"])
    (sides,) = rerun_cases_with_finer_steps_and_stiffer_contacts(
        settings, done.records, turned
    ).finer_step_rerun.changes_by_element
    assert sides.different_sides_if_members_fall_to_one_side == sides.sides == finer.fallen - finer.sides > 0
    (both,) = rerun_cases_with_finer_steps_and_stiffer_contacts(
        settings,
        done.records,
        replace(turned, ensemble_members_disagree_on_fall_or_side=~turned.ensemble_members_disagree_on_fall),
    ).finer_step_rerun.changes_by_element
    assert (both.sides, both.different_fall_sides_if_members_agree, both.falls_in_both_if_members_fall_to_one_side) == (
        sides.sides,
        sides.sides,
        0,
    )
    again = rerun_cases_with_finer_steps_and_stiffer_contacts(settings, done.records, done.sample, thread_count=2)
    assert again == found


def test_changed_cases_are_classified_as_confirmed_by_finer_steps_or_chaotic(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    settings = small_study(verification={"at_least": 10, "cost": 30})
    done = simulate_study_and_draw_case_sample(settings, [near_field_strong_part(7)], tmp_path)
    own = done.sample.study_outcomes["overturned"][:, 0]
    other = np.where(own == 0, 1, 0).astype(np.int8)
    position = {tuple(cell): row for row, cell in enumerate(done.sample.grid_indices.tolist())}
    grid = variant_grid(settings)
    axes = tuple(grid.values_by_dimension.values())

    def fake_rerun_function_of_kind(kind: str) -> Any:
        def fake_rerun_results(_: Motion, cases: Cases) -> Any:
            amplitude = np.asarray(cases.amplitude)
            nudged = bool((amplitude != 1.0).all())
            assert not nudged or np.allclose(amplitude - 1.0, 1e-9, rtol=1e-6)
            values = (cases.azimuth_deg, cases.height, cases.b_over_h, cases.friction)
            cells = np.stack([np.searchsorted(axis, value) for axis, value in zip(axes, values, strict=True)], axis=1)
            row = np.array([position[tuple(cell)] for cell in cells.tolist()])
            # Of those that change with finer steps, 0 to 3, one changes back with the finest and one with the nudge.
            changes = (row < 4) & ~((row == 1) & (kind == "finest")) & ~((row == 2) & nudged) & (kind != "stiffer")
            return SimpleNamespace(
                overturned=np.where(changes, other[row], own[row])[:, None],
                block_steps=np.full(row.size, 100 if kind == "stiffer" else 900),
            )

        return fake_rerun_results

    fakes = {kind: fake_rerun_function_of_kind(kind) for kind in ("finer", "finest", "stiffer")}
    monkeypatch.setattr("overturning.study.convergence_check.rerun_functions_by_rerun_kind", lambda _: fakes)
    found = rerun_cases_with_finer_steps_and_stiffer_contacts(
        settings, done.records, replace(done.sample, block_time_step_count_of_whole_study=1000)
    )
    assert found.tests_of_finer_step_changes.model_dump() == {
        "changed_cases": 4,
        "retested_cases": 4,
        "confirmed_cases": 2,
        "chaotic_cases": 1,
        "block_steps": 7200,
    }
    assert [one.record for one in found.finer_step_changes_by_record] == [record.record_id for record in done.records]
    assert sum(one.cases for one in found.finer_step_changes_by_record) == len(done.sample.record_indices)
    assert sum(one.changed_cases for one in found.finer_step_changes_by_record) == 4
    first_four = done.sample.record_indices[:4].tolist()
    assert [one.changed_cases for one in found.finer_step_changes_by_record] == [
        first_four.count(number) for number in range(len(done.records))
    ]
    # What is left of the allowance pays for three times a finer case each, as far as it goes.
    looked_at = set()
    for steps in range(300, 500, 10):
        found = rerun_cases_with_finer_steps_and_stiffer_contacts(
            settings, done.records, replace(done.sample, block_time_step_count_of_whole_study=steps)
        )
        assert (
            sum(
                part.block_steps
                for part in (found.finer_step_rerun, found.stiffer_contact_rerun, found.tests_of_finer_step_changes)
            )
            <= 30 * steps
        )
        looked_at.add(found.tests_of_finer_step_changes.retested_cases)
    assert len(looked_at) > 2


def study_cases_at_grid_indices(settings: Study, index: np.ndarray) -> Cases:
    """Return the cases of a study at index positions of its grid."""
    grid = variant_grid(settings)
    return grid.cases_at_grid_indices(list(index.T))


@pytest.mark.parametrize(("step", "least"), [(90, 0), (20, 3), (5, 12)])
def test_convergence_check_takes_no_more_steps_than_small_study(step: int, least: int, tmp_path: Path) -> None:
    settings = small_study(azimuth={"step": step}, verification={})
    done = simulate_study_and_draw_case_sample(
        settings, [near_field_strong_part(7, "a"), near_field_strong_part(8, "b")], tmp_path
    )
    found = rerun_cases_with_finer_steps_and_stiffer_contacts(settings, done.records, done.sample)
    assert found.wanted_case_count == min(200, done.sample.study_case_count_without_symmetry_copies)
    spent = found.finer_step_rerun.block_steps + found.stiffer_contact_rerun.block_steps
    assert spent <= done.sample.block_time_step_count_of_whole_study
    assert least <= found.rerun_case_count < found.wanted_case_count
    assert found.rerun_case_count < 4 or spent > 0.5 * done.sample.block_time_step_count_of_whole_study, (
        "the allowance is made use of"
    )


def test_convergence_is_checked_with_finer_steps_if_stiffer_springs_are_refused() -> None:
    settings = small_study(contact={"stiffness": 3e13}, verification={"at_least": 4, "cost": 50})
    none = np.zeros(2, np.bool_)
    sure, index = none[:, None], np.zeros((2, 4), np.int64)
    sample = RandomCaseSample(
        np.zeros(2, np.int64), index, create_outcome_array_to_fill(2, 1), none, sure, sure, np.ones(2), 36, 0
    )
    quiet = Record("a", np.zeros(50), np.zeros(50), None, 0.01)
    found = rerun_cases_with_finer_steps_and_stiffer_contacts(settings, [quiet], sample)
    assert "stiffness" in found.stiffer_contact_rerun.refusal_reason
    assert found.finer_step_rerun.changes_by_element[0].cases == found.rerun_case_count == 2


def test_blocks_that_cannot_slide_are_compared_with_the_rigid_block(tmp_path: Path) -> None:
    data = {"friction": [0.58, 1.0, 1.2], "b_over_h": [0.2, 0.3, 1.1], "ensemble": {"members": 0}}
    settings = small_study(**data, verification={"at_least": 2})
    records = [near_field_strong_part(7, "a"), near_field_strong_part(8, "b")]
    cube = simulate_study_cube(settings, records, tmp_path)
    rigid, sample = (
        read_sample_to_compare_with_rigid_block(cube, settings),
        read_random_case_sample(cube, settings.verification),
    )
    assert rigid is not None
    # Three azimuths of two records: µ = 1 holds two of the three, 1.2 all.
    assert rigid.study_case_count_without_symmetry_copies == len(rigid.record_indices) == 2 * 3 * (2 + 3)
    found = rerun_cases_with_finer_steps_and_stiffer_contacts(
        settings, records, sample, sample_for_rigid_block_comparison=rigid
    ).rigid_block_comparison
    assert found is not None
    assert found.non_sliding_block_cells == found.cases == 30
    assert found.fallen > 3
    assert found.flags == found.sides == 0
    overturned = rigid.study_outcomes["overturned"].copy()
    first, second = np.flatnonzero(overturned)[:2]
    overturned[first], overturned[second] = 0, -overturned[second]
    wrong = replace(rigid, study_outcomes=rigid.study_outcomes.copy())
    wrong.study_outcomes["overturned"] = overturned
    again = rerun_cases_with_finer_steps_and_stiffer_contacts(
        settings, records, sample, thread_count=2, sample_for_rigid_block_comparison=wrong
    ).rigid_block_comparison
    one_fall_less = dict.fromkeys(
        ("fallen", "falls_in_both_if_members_agree", "falls_in_both_if_members_fall_to_one_side"), found.fallen - 1
    )
    one_of_each = dict.fromkeys(
        (
            "flags",
            "sides",
            "falls_in_one_only_if_members_agree",
            "different_fall_sides_if_members_agree",
            "different_sides_if_members_fall_to_one_side",
        ),
        1,
    )
    assert again == found.model_copy(update=one_fall_less | one_of_each)
    workflow.recompute_sample_to_check_convergence(
        settings.model_dump_json(), tmp_path / "motion", cube, tmp_path / "found.json"
    )
    assert read_convergence_result(tmp_path / "found.json").rigid_block_comparison == found
    # From under one record's blocks the ground drops by more than g: the rigid block, which stays on it, knows nothing.
    drop = np.zeros(records[1].sample_count)
    drop[50] = -10.0
    hopping = rerun_cases_with_finer_steps_and_stiffer_contacts(
        settings, [records[0], replace(records[1], up=drop)], sample, sample_for_rigid_block_comparison=rigid
    ).rigid_block_comparison
    assert hopping is not None
    assert (hopping.cases, hopping.unanswered) == (15, 15)


SCENE_OF_TWO_STONES_SIDE_BY_SIDE = {
    "name": "row",
    "elements": [
        {"name": "ground", "kind": "driven", "width": 40, "height": 1, "at": [0, -1]},
        {"name": "slender", "width": 0.1, "height": 0.4, "at": [-0.6, 0]},
        {"name": "squat", "width": 0.3, "height": 0.2, "at": [0.6, 0]},
    ],
}


def study_of_two_stones_side_by_side(**keys: object) -> Study:
    """Return a study of a slender and a squat stone next to each other: two free elements."""
    return study_from_content(
        {
            "name": "row",
            "records": {"use": ["a"]},
            "scene": SCENE_OF_TWO_STONES_SIDE_BY_SIDE,
            "friction": [0.7],
            **keys,
        },
        "row",
    )


def test_sliding_blocks_and_other_shapes_are_not_compared_with_the_rigid_block() -> None:
    """No sample is read, and the cube is not opened, if no case can be compared with the rigid block."""
    nowhere = Path("nowhere.nc")
    assert read_sample_to_compare_with_rigid_block(nowhere, small_study(friction=[0.33, 0.99])) is None
    assert read_sample_to_compare_with_rigid_block(nowhere, small_study(friction=[1.0], b_over_h=[1.0, 1.5])) is None
    assert read_sample_to_compare_with_rigid_block(nowhere, study_of_two_stones_side_by_side(friction=[1.0])) is None
    body = {"body": {}, "azimuth": {}, "orientation": {"step": 30}}
    assert read_sample_to_compare_with_rigid_block(nowhere, small_study(friction=[1.0], b_over_h=[0.2], **body)) is None


def test_convergence_of_a_scene_is_checked_for_each_element(tmp_path: Path) -> None:
    settings = study_of_two_stones_side_by_side(azimuth={"step": 60}, verification={"at_least": 4, "cost": 20})
    done = simulate_study_and_draw_case_sample(settings, [near_field_strong_part(7)], tmp_path)
    found = rerun_cases_with_finer_steps_and_stiffer_contacts(settings, done.records, done.sample)
    assert [one.element for one in found.finer_step_rerun.changes_by_element] == ["slender", "squat"]
    for outcome in (*found.finer_step_rerun.changes_by_element, *found.stiffer_contact_rerun.changes_by_element):
        assert outcome.cases + outcome.unanswered == found.rerun_case_count == 4
    # The slender one alone is said to have stood where it fell.
    wrong = done.sample.study_outcomes["overturned"].copy()
    fell = int((wrong[:, 0] != 0).sum())
    assert fell > 0
    wrong[:, 0] = 0
    found = rerun_cases_with_finer_steps_and_stiffer_contacts(
        settings, done.records, done.sample_with_replaced_flags(wrong)
    )
    assert [one.flags for one in found.finer_step_rerun.changes_by_element] == [fell, 0]
    rows = comparisons_with_second_computations(found)[:2]
    assert [(one.element, one.fall_or_stand_changes.changed_count,
    one.fall_or_stand_changes.compared_count) for one in rows] == [
        ("slender", fell, 4), ("squat", 0, 4),
    ]  # fmt: skip
    assert rows[0].fall_or_stand_changes.value == fell / 4


def test_convergence_reruns_of_a_scene_use_finer_steps_and_stiffer_contacts() -> None:
    settings = study_of_two_stones_side_by_side()
    motion, cases = Motion.of(near_field_strong_part(7)), Cases([0.0, 60.0], 0.4, 0.25, 0.7)
    own = simulate_cases(settings.scene, motion, cases)
    steps = {
        name: again(motion, cases).block_steps.sum() / own.block_steps.sum()
        for name, again in rerun_functions_by_rerun_kind(settings).items()
    }
    finer, nominal = (
        plan_simulation(PlanarModel(settings.scene), motion, cases, NumericalOptions(refinement=refinement))
        for refinement in (8, 1)
    )
    assert rerun_functions_by_rerun_kind(settings)["finer"].keywords["numerics"].refinement == 8  # type: ignore[attr-defined]
    np.testing.assert_array_equal(
        finer.steps_per_sample, 8 * nominal.steps_per_sample
    )  # whole steps; ticks, and so finest ones, with them
    np.testing.assert_array_equal(
        finer.case_table["min_allowed_step_ticks"], nominal.case_table["min_allowed_step_ticks"]
    )
    # Of the steps from the finest to the whole ones after a change of contact there are as many as before.
    assert 5.0 < steps["finer"] <= 8.0
    # Whole steps follow the motion; the contact halves only the finest ones.
    assert 1.0 < steps["stiffer"] < 1.2
    soft, stiff = (
        prepare_scene(settings.scene).pair_contact_laws,
        prepare_scene(PlanarModel(settings.scene).with_stiffness_factor(4.0).scene).pair_contact_laws,
    )
    np.testing.assert_allclose(stiff.normal_stiffness, 4 * soft.normal_stiffness)
    np.testing.assert_allclose(
        stiff.dashpot_coefficient, 2 * soft.dashpot_coefficient, err_msg="the damping ratio stays"
    )


def test_gravestone_scene_is_rechecked_with_the_kernel_for_single_blocks() -> None:
    scene = small_study(scene="gravestone", ensemble={"members": 0}, b_over_h=[0.2], height=[0.6])
    block = small_study(ensemble={"members": 0}, b_over_h=[0.2])
    motion, cases = Motion.of(near_field_strong_part(7)), Cases([0.0, 60.0], 0.6, 0.2, 0.58)
    for kind, again in rerun_functions_by_rerun_kind(scene).items():
        found, expected = again(motion, cases), rerun_functions_by_rerun_kind(block)[kind](motion, cases)
        np.testing.assert_array_equal(found.overturned, expected.overturned)
        np.testing.assert_array_equal(found.block_steps, expected.block_steps)


def test_the_check_convergence_command_checks_a_scene_within_its_cost_limit(tmp_path: Path) -> None:
    settings = study_of_two_stones_side_by_side(azimuth={"step": 30}, friction=[0.4, 0.7], verification={"cost": 4})
    cube = simulate_study_cube(settings, [near_field_strong_part(7)], tmp_path)
    output = tmp_path / "convergence.json"
    workflow.recompute_sample_to_check_convergence(settings.model_dump_json(), tmp_path / "motion", cube, output)
    found = read_convergence_result(output)
    assert 6 <= found.rerun_case_count < found.wanted_case_count == 24, "none of the scene's azimuths is mirrored"
    spent = sum(
        part.block_steps
        for part in (found.finer_step_rerun, found.stiffer_contact_rerun, found.tests_of_finer_step_changes)
    )
    with open_cube(cube, element=None) as opened:
        assert 0 < spent <= 4 * found.study_block_steps == 4 * opened.attrs["block_steps"]
    # Few change with the step, so the answers read from the cube are those of the same cells.
    assert sum(outcome.fallen for outcome in found.finer_step_rerun.changes_by_element) > 0
    assert all(outcome.flags <= 1 for outcome in found.finer_step_rerun.changes_by_element)


def test_ensemble_members_disagree_if_some_fall_and_some_stand(tmp_path: Path) -> None:
    # The last cell has no ensemble; the third falls in every member, now to one side and now to the other.
    towards, away = np.array([0.0, 0.25, 0.75, 1.0, np.nan]), np.array([0.0, 0.25, 0.25, 0.0, np.nan])
    shape = (1, 5, 1, 1, 1)
    zeros = np.zeros(shape, np.int8)
    dims = ("record", "azimuth", "height", "b_over_h", "friction")
    given = {"overturned": zeros, "status": zeros, "mirrored": zeros}
    given |= {"probability_towards": towards.reshape(shape), "probability_away": away.reshape(shape)}
    table = xr.Dataset({name: (dims, values) for name, values in given.items()}, attrs={"block_steps": 1})
    table.to_netcdf(tmp_path / "cube.nc")
    sample = read_random_case_sample(tmp_path / "cube.nc", ConvergenceCheckSettings(at_least=5))
    divided = dict(
        zip(sample.grid_indices[:, 0].tolist(), sample.ensemble_members_disagree_on_fall[:, 0].tolist(), strict=True)
    )
    assert divided == {0: False, 1: True, 2: False, 3: False, 4: False}
    apart = dict(
        zip(
            sample.grid_indices[:, 0].tolist(),
            sample.ensemble_members_disagree_on_fall_or_side[:, 0].tolist(),
            strict=True,
        )
    )
    assert apart == {0: False, 1: True, 2: True, 3: False, 4: False}


def test_3d_ensemble_members_disagree_if_their_fall_directions_spread(tmp_path: Path) -> None:
    """Ensemble members whose falls spread by ±40° disagree on the direction, those within ±10° agree.

    In the first three of five cases all members fall, at 0°, ±10° and ±40° from their mean direction. In the
    fourth half of the members stand; in the fifth no member was run.
    """
    half = np.radians([0.0, 10.0, 40.0])
    falls = np.array([1.0, 1.0, 1.0, 0.5, np.nan])
    north = np.array([*np.cos(half), 0.5, np.nan])
    shape, dims = (1, 5, 1, 1, 1, 1), ("record", "orientation", "height", "b_over_h", "aspect", "friction")
    zeros = np.zeros(shape, np.int8)
    given = {"overturned": zeros, "status": zeros, "repeated": zeros, "fall_azimuth": np.zeros(shape, np.float32)}
    given |= {"probability_falls": falls.reshape(shape), "fall_north": north.reshape(shape), "fall_east": 0.0 * zeros}
    given |= {"members": np.full(shape, 8, np.int16)}
    table = xr.Dataset({name: (dims, values) for name, values in given.items()}, attrs={"block_steps": 1})
    table.to_netcdf(tmp_path / "cube.nc")
    sample = read_random_case_sample(tmp_path / "cube.nc", ConvergenceCheckSettings(at_least=5))
    place = np.argsort(sample.grid_indices[:, 0])
    assert sample.ensemble_members_disagree_on_fall[place, 0].tolist() == [False, False, False, True, False]
    assert sample.ensemble_members_disagree_on_fall_or_side[place, 0].tolist() == [False, False, True, True, False]
    # k R² is 8, 7.76 and 4.69 where all eight fall, 4 where four do, all the same way.
    assert sample.fall_direction_statistics_weight[place] == pytest.approx(
        [1.0, *np.sqrt((8 * np.cos(half[1:]) ** 2 - 1) / 7), 1.0, 1.0]
    )


def test_3d_falls_that_change_azimuth_under_slightly_scaled_motion_are_counted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Falls count as shifted if their azimuth turns by 140° at one of the amplitude factors, but not if by 29°.

    A stub turns a third of the falls by 140° at the factor 0.995, and another third by 29° at all factors. One block
    stands at 1.01.
    """
    body = {"body": {}, "azimuth": {}, "orientation": {"step": 30}, "b_over_h": [0.1, 0.15, 0.2, 0.25]}
    settings = small_study(**body, verification={"at_least": 24, "cost": 100})
    done = simulate_study_and_draw_case_sample(settings, [near_field_strong_part(7)], tmp_path)
    sample = done.sample
    fell = np.flatnonzero(sample.study_outcomes["overturned"][:, 0] == 1)
    assert fell.size >= 6
    rank = np.full(len(sample.record_indices), -1)
    rank[fell] = np.arange(fell.size)
    position = {tuple(cell): row for row, cell in enumerate(sample.grid_indices.tolist())}
    names, axes = zip(*variant_grid(settings).values_by_dimension.items(), strict=True)
    factors = set[float]()

    def fake_results_at_scaled_amplitude(_: Motion, cases: Cases) -> Any:
        (factor,) = np.unique(cases.amplitude)
        factors.add(round(float(factor), 6))
        values = [getattr(cases, {"orientation": "azimuth_deg"}.get(name, name)) for name in names]
        values = [np.broadcast_to(value, len(cases.azimuth_deg)) for value in values]
        cells = np.stack(
            [np.abs(axis[:, None] - one).argmin(axis=0) for axis, one in zip(axes, values, strict=True)], 1
        )
        row = np.array([position[tuple(cell)] for cell in cells.tolist()])
        turn = np.where(rank[row] % 3 == 0, 140.0 * (abs(factor - 0.995) < 1e-6), 29.0 * (rank[row] % 3 == 1))
        stands = (rank[row] == 2) & (factor > 1.005)
        return SimpleNamespace(
            overturned=np.where(stands, 0, 1).astype(np.int8)[:, None],
            fall_azimuth=np.where(stands, np.nan, (sample.study_outcomes["azimuth"][row, 0] + turn) % 360.0),
            block_steps=np.full(row.size, 10),
        )

    kinds = rerun_functions_by_rerun_kind(settings) | {"nominal": fake_results_at_scaled_amplitude}
    monkeypatch.setattr("overturning.study.convergence_check.rerun_functions_by_rerun_kind", lambda _: kinds)
    weight = np.linspace(0.2, 1.0, len(sample.record_indices))
    found = rerun_cases_with_finer_steps_and_stiffer_contacts(
        settings, done.records, replace(sample, fall_direction_statistics_weight=weight)
    ).amplitude_change_rerun
    assert found is not None
    assert factors == {0.99, 0.995, 1.005, 1.01}
    assert (found.rerun_falls, found.falls_with_shifted_azimuth, found.falls_standing_in_a_rerun) == (
        fell.size,
        len(fell[::3]),
        1,
    )
    assert found.weight_of_rerun_falls == pytest.approx(weight[fell].sum())
    assert found.weight_of_shifted_falls == pytest.approx(weight[fell[::3]].sum())
    assert found.block_steps == 4 * 10 * fell.size


@pytest.mark.parametrize(
    ("written", "said"),
    [
        (
            {name: value for name, value in CONVERGENCE_RESULT_FIELDS.items() if name != "seed"},
            "seed: this key is needed",
        ),
        (
            CONVERGENCE_RESULT_FIELDS | {"finer_step_rerun": {"changes_by_element": [OUTCOME_CHANGE_COUNT_FIELDS]}},
            "finer_step_rerun.block_steps: this key is needed",
        ),
        (
            CONVERGENCE_RESULT_FIELDS
            | {"finer_step_rerun": {"block_steps": 1, "changes_by_element": [{"element": ""}]}},
            "finer_step_rerun.changes_by_element.0.cases: this key is needed",
        ),
        (CONVERGENCE_RESULT_FIELDS | {"rerun_case_count": "many"}, "rerun_case_count: a whole number is needed"),
        (["old"], "keys with values are needed"),
    ],
)
def test_error_for_an_older_convergence_result_names_its_file_and_key(tmp_path: Path, written: Any, said: str) -> None:
    path = tmp_path / "convergence.json"
    path.write_text(json.dumps(written), encoding="utf-8")
    with pytest.raises(ResultError, match="run the study again to recreate") as error:
        read_convergence_result(path)
    assert str(error.value).startswith(f"{path}: {said}")
    assert "\n" not in str(error.value)
