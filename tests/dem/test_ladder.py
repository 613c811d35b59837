"""Step control: whole steps resolve the motion, shorter ones the contact; cases with an energy error are rerun."""

import numpy as np
import pytest

from overturning.dem.block.commit import (
    SolvedCornerContact,
    SolvedCornerContactPair,
    contact_changes_in_block_step,
    corner_forces_new_state_and_contact_changes,
)
from overturning.dem.block.state import (
    MAX_UNHALVED_CONTACT_CHANGE_STEP_IN_SHORTEST_STEPS,
    AssumedCornerContact,
    BlockConstants,
    BlockPredictedAtStepEnd,
    BlockVelocityCorrectionAndCornerFriction,
    CornerPredictedAtStepEnd,
    CornerState,
)
from overturning.dem.kernel import balance
from overturning.dem.kernel.balance import MAX_ENERGY_ERROR_TO_INPUT_ENERGY_RATIO, STEP_DIVISOR_PER_RERUN
from overturning.dem.kernel.clock import (
    BLOCK_STEP_CONTROL,
    BODY_STEP_CONTROL,
    MAX_SLIP_ONSET_STEP_IN_SAMPLES,
    SCENE_STEP_CONTROL,
    CaseStepLengthsAndDoublingCounts,
    NextStepToAttempt,
    StepContactChanges,
    StepLimitsCommonToAllCases,
    decide_rejection_sliding_and_next_step,
)
from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import plan_simulation, run_cases
from overturning.dem.time_step import block_highest_eigenvalue_bound, inverse_contact_frequency_reduced_at_high_damping
from overturning.dem.trajectory import trajectory
from overturning.model.cases import Cases
from overturning.model.contact import DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO, Contact
from overturning.model.planes import PlanarModel
from overturning.model.scene import gravestone
from overturning.model.status import CaseStatus
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion
from tests.dem.polygon_scenes import load_shipped_scene

TICKS_PER_WHOLE_STEP = BLOCK_STEP_CONTROL.ticks_per_whole_step
COMPARED_RESULTS = ("overturned", "peak_rotation", "peak_slip", "residual_slip", "peak_penetration", "energy_error")


def motion_of_two_cycles_with_vertical() -> Motion:
    """Return a pulse of two cycles with north, east and vertical components."""
    t = np.arange(300) * 0.01
    along = 4.0 * np.sin(2 * np.pi * t / 0.8) * (t < 1.6)
    return Motion(along, 0.6 * along, 2.0 * np.sin(7.0 * t) * (t < 2), sampling_interval=0.01)


def block_cases() -> Cases:
    """Return cases of blocks of several azimuths, heights, B/H and frictions."""
    axes = np.meshgrid([0.0, 40.0, 130.0], [0.3, 1.2], np.arange(0.1, 0.6, 0.1), [0.3, 1.0], indexing="ij")
    return Cases(*(axis.ravel() for axis in axes))


@pytest.mark.parametrize("step", ["auto", "0.1 stable", 1e-4])
def test_planned_steps_per_sample_do_not_depend_on_contact_parameters(step: float | str) -> None:
    made = [
        plan_simulation(PlanarModel(gravestone(Contact(static_penetration=delta, damping_ratio=ratio))),
        motion_of_two_cycles_with_vertical(),
        block_cases(), NumericalOptions(time_step=step)).steps_per_sample
        for delta in (2e-3, 2e-5, 1e-9) for ratio in (0.02, 1.0, 8.0)
    ]  # fmt: skip
    for steps in made[1:]:
        np.testing.assert_array_equal(steps, made[0])


@pytest.mark.parametrize("damping_ratio", [0.1, 1.0, 64.0, 3e5])
@pytest.mark.parametrize("refinement", [1, 8])
def test_the_finest_time_step_resolves_very_stiff_or_damped_contacts(damping_ratio: float, refinement: int) -> None:
    contact = Contact(static_penetration=1e-9, damping_ratio=damping_ratio)
    cases = block_cases()
    made = plan_simulation(
        PlanarModel(gravestone(contact)),
        motion_of_two_cycles_with_vertical(),
        cases,
        NumericalOptions(refinement=refinement),
    )
    width = cases.b_over_h * cases.height
    normal, tangential, dashpot = contact.corner_stiffness_and_damping_per_mass(width, cases.height, 2650.0)
    square, rate = (
        block_highest_eigenvalue_bound(one, other, 0.5 * width, 0.5 * cases.height)
        for one, other in ((normal, tangential), (dashpot, dashpot))
    )
    ticks = made.case_table["min_allowed_step_ticks"]
    assert (ticks >= 1).all()
    finest = 0.01 / made.steps_per_sample / TICKS_PER_WHOLE_STEP * ticks * refinement
    assert (
        finest
        <= BLOCK_STEP_CONTROL.max_contact_change_step_times_omega
        * inverse_contact_frequency_reduced_at_high_damping(square, rate)
    ).all()
    assert (
        finest
        > 0.49
        * BLOCK_STEP_CONTROL.max_contact_change_step_times_omega
        * inverse_contact_frequency_reduced_at_high_damping(square, rate)
    ).all()


NO_CONTACT_CHANGES = StepContactChanges(False, False, False, False, False, False, False, False)


def step_control_of_case(
    kernel_step_control: StepLimitsCommonToAllCases, longest_step_with_all_contacts_closed_ticks: float | None = None
) -> CaseStepLengthsAndDoublingCounts:
    """Return the step control of a case whose finest step is 64 ticks (time units of the kernel)."""
    return CaseStepLengthsAndDoublingCounts(
        64.0,
        longest_step_with_all_contacts_closed_ticks or kernel_step_control.ticks_per_whole_step,
        8.0,
        kernel_step_control.long_steps_before_doubling,
    )


@pytest.mark.parametrize("pace", [BLOCK_STEP_CONTROL, SCENE_STEP_CONTROL, BODY_STEP_CONTROL])
@pytest.mark.parametrize("steps", [1, 3, 4])
def test_no_time_step_crosses_the_end_of_a_sample(pace: StepLimitsCommonToAllCases, steps: int) -> None:
    whole, random = pace.ticks_per_whole_step, np.random.default_rng(1)
    sample = steps * whole
    case_step_control = step_control_of_case(pace, sample)
    attempt, tick, change, stands = (
        NextStepToAttempt(
            case_step_control.min_allowed_step_ticks, case_step_control.steps_before_doubling_after_contact_change, 0.0
        ),
        0.0,
        0.6 * whole,
        True,
    )
    lengths, changes = {True: set[float](), False: set[float]()}, 0
    while tick < 400 * sample:
        length, end = attempt.length_in_ticks, tick + attempt.length_in_ticks
        assert tick // sample == (end - 1.0) // sample, "a step crosses the end of a sample"
        changed = tick < change <= end
        again, _, attempt = decide_rejection_sliding_and_next_step.py_func(
            pace,
            case_step_control,
            attempt,
            NO_CONTACT_CHANGES._replace(contact_opened_or_closed=changed, all_contacts_are_closed=stands),
            end,
            sample,
        )
        assert again == (changed and length > case_step_control.min_allowed_step_ticks)
        if not again:
            tick = end
            lengths[stands].add(attempt.length_in_ticks)
            if changed:
                changes += 1
                assert attempt.length_in_ticks == case_step_control.min_allowed_step_ticks
                change, stands = tick + random.exponential(3 * sample), not stands
    assert changes > 50
    ladder = {2.0**power for power in range(6, pace.max_step_halvings + 1)}
    assert lengths == {True: ladder | {sample}, False: ladder}


def sticking_corner_with_changed_penetration(before: float, after: float) -> SolvedCornerContact:
    """Return a sticking corner whose penetration changes from `before` to `after` (m) in a step."""
    there = CornerPredictedAtStepEnd(
        x_from_centre=1.0,
        depth_below_centre=1.0,
        penetration=after,
        tangential_stretch=0.0,
        velocity_x=0.0,
        velocity_z=0.0,
    )
    block = BlockConstants(**dict.fromkeys(BlockConstants._fields, 1.0))
    nothing = BlockVelocityCorrectionAndCornerFriction(0.0, 0.0, 0.0, 0.0, 0.0)
    step = BlockPredictedAtStepEnd(
        **dict.fromkeys(BlockPredictedAtStepEnd._fields[:-3], 0.0), half_step_duration=0.5, left=there, right=there
    )
    return corner_forces_new_state_and_contact_changes.py_func(
        block,
        step,
        there,
        CornerState(0.0, 0.0, before, 1.0),
        AssumedCornerContact(0.0, True, False, False, 0.0, 1.0),
        nothing,
        True,
    )


def step_is_rejected(
    length_in_finest_steps: float,
    left: SolvedCornerContact,
    right: SolvedCornerContact,
    max_corner_travel_without_halving_step_m: float = 1e-6,
) -> bool:
    """True if a step of `length_in_finest_steps` finest steps is rejected."""
    case_step_control, block = (
        step_control_of_case(BLOCK_STEP_CONTROL),
        BlockConstants(
            **dict.fromkeys(BlockConstants._fields, 1.0)
            | {"max_contact_change_travel_without_halving_step": max_corner_travel_without_halving_step_m}
        ),
    )
    length = length_in_finest_steps * case_step_control.min_allowed_step_ticks
    found = contact_changes_in_block_step.py_func(
        block, case_step_control, length, False, SolvedCornerContactPair(left, right), False
    )
    return bool(
        decide_rejection_sliding_and_next_step.py_func(
            BLOCK_STEP_CONTROL,
            case_step_control,
            NextStepToAttempt(length, 8.0, 0.0),
            found,
            TICKS_PER_WHOLE_STEP,
            TICKS_PER_WHOLE_STEP,
        )[0]
    )


def test_a_gentle_touch_of_corners_is_accepted_in_steps_above_the_finest() -> None:
    near, far = (
        sticking_corner_with_changed_penetration(-0.5e-6, 0.4e-6),
        sticking_corner_with_changed_penetration(-0.5e-6, 0.6e-6),
    )
    assert not step_is_rejected(MAX_UNHALVED_CONTACT_CHANGE_STEP_IN_SHORTEST_STEPS, near, near)
    assert step_is_rejected(MAX_UNHALVED_CONTACT_CHANGE_STEP_IN_SHORTEST_STEPS, far, far)
    assert step_is_rejected(2 * MAX_UNHALVED_CONTACT_CHANGE_STEP_IN_SHORTEST_STEPS, near, near)
    assert not step_is_rejected(
        1.0, sticking_corner_with_changed_penetration(-1.0, 1.0), sticking_corner_with_changed_penetration(-1.0, 1.0)
    )


def test_only_the_travel_of_a_corner_that_touches_or_lifts_off_rejects_a_step() -> None:
    """One corner touches after 4e-7 m; the other stays closed, stays in the air, or lifts off by 2e-6 m (rejected)."""
    touches = sticking_corner_with_changed_penetration(-1e-7, 3e-7)
    assert touches.vertical_travel_if_contact_changed_else_zero == pytest.approx(4e-7)
    for other in (
        sticking_corner_with_changed_penetration(5e-7, 6e-7),
        sticking_corner_with_changed_penetration(-6e-7, -5e-7),
    ):
        assert not step_is_rejected(MAX_UNHALVED_CONTACT_CHANGE_STEP_IN_SHORTEST_STEPS, touches, other)
    assert step_is_rejected(
        MAX_UNHALVED_CONTACT_CHANGE_STEP_IN_SHORTEST_STEPS,
        touches,
        sticking_corner_with_changed_penetration(1e-6, -1e-6),
    )


@pytest.mark.parametrize("pace", [BLOCK_STEP_CONTROL, SCENE_STEP_CONTROL, BODY_STEP_CONTROL])
def test_sliding_correction_repeats_restart_at_each_step(pace: StepLimitsCommonToAllCases) -> None:
    """A step is repeated with other contact points assumed to slide; repetitions of earlier steps do not count."""
    case_step_control, length = step_control_of_case(pace), 0.5 * pace.ticks_per_whole_step
    attempt, tries, lengths = NextStepToAttempt(length, 8.0, 0.0), [], []
    most = int(pace.max_repetitions_with_corrected_sliding)
    for wrong in (False, *[True] * (most + 2), False, True):
        again, _, attempt = decide_rejection_sliding_and_next_step.py_func(
            pace,
            case_step_control,
            attempt,
            NO_CONTACT_CHANGES._replace(has_wrong_slip_assumption=wrong),
            length,
            TICKS_PER_WHOLE_STEP,
        )
        tries.append(attempt.repetitions_with_corrected_sliding_so_far)
        lengths.append(attempt.length_in_ticks)
        assert again == wrong
    assert tries == [*range(most + 1), 0, 1, 0, 1]
    assert lengths == [length] * (most + 1) + [0.5 * length] * 4


@pytest.mark.parametrize("pace", [BLOCK_STEP_CONTROL, SCENE_STEP_CONTROL, BODY_STEP_CONTROL])
def test_a_step_in_which_sliding_begins_is_halved_with_unchanged_assumptions(pace: StepLimitsCommonToAllCases) -> None:
    """The step is halved with the same assumptions until it is short enough, and only then repeated with sliding."""
    case_step_control, begins = (
        step_control_of_case(pace),
        NO_CONTACT_CHANGES._replace(has_wrong_slip_assumption=True, slides_on_all_points=True),
    )
    attempt, lengths = NextStepToAttempt(pace.ticks_per_whole_step, 8.0, 0.0), []
    while attempt.repetitions_with_corrected_sliding_so_far == 0.0:
        again, as_before, attempt = decide_rejection_sliding_and_next_step.py_func(
            pace, case_step_control, attempt, begins, pace.ticks_per_whole_step, pace.ticks_per_whole_step
        )
        assert again
        assert as_before == (attempt.repetitions_with_corrected_sliding_so_far == 0.0)
        lengths.append(attempt.length_in_ticks)
    assert lengths[-1] == lengths[-2] == MAX_SLIP_ONSET_STEP_IN_SAMPLES * pace.ticks_per_whole_step
    # Sliding that was assumed is accepted in steps of any length.
    slides = NO_CONTACT_CHANGES._replace(slides_on_all_points=True)
    assert not decide_rejection_sliding_and_next_step.py_func(
        pace,
        case_step_control,
        NextStepToAttempt(pace.ticks_per_whole_step, 8.0, 0.0),
        slides,
        pace.ticks_per_whole_step,
        pace.ticks_per_whole_step,
    )[0]


@pytest.mark.parametrize("step", ["auto", "0.5 stable", "0.125 stable", 2e-4])
def test_a_block_standing_on_a_rigid_contact_takes_several_planned_steps_at_once(step: float | str) -> None:
    contacts = [Contact(static_penetration=delta) for delta in (2e-5, 1e-8)]
    soft, rigid = (
        plan_simulation(
            PlanarModel(gravestone(one)),
            motion_of_two_cycles_with_vertical(),
            block_cases(),
            NumericalOptions(time_step=step),
        )
        for one in contacts
    )
    usual = plan_simulation(
        PlanarModel(gravestone(contacts[1])), motion_of_two_cycles_with_vertical(), block_cases(), NumericalOptions()
    ).steps_per_sample
    assert (soft.case_table["longest_step_with_all_contacts_closed_ticks"] == TICKS_PER_WHOLE_STEP).all()
    standing = rigid.case_table["longest_step_with_all_contacts_closed_ticks"] / TICKS_PER_WHOLE_STEP
    np.testing.assert_array_equal(rigid.steps_per_sample % standing, 0.0)
    np.testing.assert_array_equal(standing, np.gcd(usual, rigid.steps_per_sample))


@pytest.mark.parametrize("general", [False, True])
def test_a_case_whose_energy_does_not_balance_is_rerun_in_shorter_steps(
    general: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    cases, kernel = block_cases(), {"general": general}
    first, finer = (
        run_cases(motion_of_two_cycles_with_vertical(), cases, refinement=times, **kernel)
        for times in (1, STEP_DIVISOR_PER_RERUN)
    )
    moved = first.status == CaseStatus.SIMULATED
    bound = float(np.median(first.energy_error[moved]))
    monkeypatch.setattr(balance, "MAX_ENERGY_ERROR_TO_INPUT_ENERGY_RATIO", bound)
    monkeypatch.setattr(balance, "MAX_RERUNS_UNTIL_ENERGY_BALANCES", 1)
    found = run_cases(motion_of_two_cycles_with_vertical(), cases, **kernel)
    again = moved & (first.energy_error > bound)
    assert 0.2 < again.sum() / moved.sum() < 0.8
    never = again & (finer.energy_error > bound)
    np.testing.assert_array_equal(found.status == CaseStatus.UNSTABLE, never)
    for name in COMPARED_RESULTS:
        expected = np.where(again, getattr(finer, name), getattr(first, name))
        expected = np.where(never, INT8_MISSING, expected) if name == "overturned" else expected
        np.testing.assert_array_equal(getattr(found, name), expected, err_msg=name)
    np.testing.assert_array_equal(found.block_steps, first.block_steps + np.where(again, finer.block_steps, 0))
    one = int(np.flatnonzero(again)[0])
    cell = {name: float(getattr(cases, name)[one]) for name in ("azimuth_deg", "height", "b_over_h", "friction")}
    path = trajectory(motion_of_two_cycles_with_vertical(), **cell, **kernel)
    assert path.attrs["block_steps"] == found.block_steps[one]
    assert float(path["peak_rotation"].sel(element="stone")) == found.peak_rotation[one]
    assert (np.diff(path["time"]) >= 0).all()


@pytest.mark.parametrize("general", [False, True])
def test_a_case_whose_energy_never_balances_is_marked_unstable(general: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(balance, "MAX_ENERGY_ERROR_TO_INPUT_ENERGY_RATIO", -1.0)
    found = run_cases(motion_of_two_cycles_with_vertical(), Cases([0.0], [0.6], [0.3], [0.5]), general=general)
    assert found.status.tolist() == [CaseStatus.UNSTABLE]
    assert found.overturned.tolist() == [-128]


@pytest.mark.parametrize("damping_ratio", [0.02, 0.25, 1.0, 16.0])
@pytest.mark.parametrize("penetration", [2e-3, 2e-5, 1e-7, 1e-9])
def test_cases_of_any_contact_balance_their_energy_or_have_no_outcome(penetration: float, damping_ratio: float) -> None:
    contact = Contact(static_penetration=penetration, damping_ratio=damping_ratio)
    found = run_cases(motion_of_two_cycles_with_vertical(), block_cases(), gravestone(contact))
    simulated = found.status == CaseStatus.SIMULATED
    assert (found.energy_error[simulated] <= MAX_ENERGY_ERROR_TO_INPUT_ENERGY_RATIO).all()
    assert (found.overturned[~simulated & (found.status != CaseStatus.AT_REST)] == -128).all()
    assert simulated.sum() > 0.95 * (found.status != CaseStatus.AT_REST).sum()


def test_blocks_and_scenes_have_the_same_default_contact() -> None:
    stone, scene = gravestone(), load_shipped_scene("three-tier")
    assert (
        stone.contact_law(*stone.elements).contact_without_friction
        == scene.contact_law(*scene.elements[:2]).contact_without_friction
        == Contact()
    )
    assert Contact().static_penetration == DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO
    given = gravestone(Contact(static_penetration=3e-6))
    assert given.contact_law(*given.elements).static_penetration == 3e-6
