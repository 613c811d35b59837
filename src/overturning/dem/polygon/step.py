"""Step of all cases with the centred scheme (trapezoidal rule); each case has its own step length."""

from typing import Any, NamedTuple

from numba import njit

from overturning.dem.kernel.clock import (
    SCENE_STEP_CONTROL,
    StepContactChanges,
    decide_rejection_sliding_and_next_step,
)
from overturning.dem.kernel.ground import base_acceleration_in_this_or_next_sample
from overturning.dem.kernel.lanes import INLINE_OPTIONS, INTERNAL_COMPILE_OPTIONS, NO_ALIAS_COMPILE_OPTIONS, select
from overturning.dem.kernel.mechanics import updated_maximum
from overturning.dem.polygon import rows
from overturning.dem.polygon.centred import add_pair_contact_terms_to_equations, step_resolves_contact_vibration
from overturning.dem.polygon.centred_solution import (
    add_solved_pair_forces_and_store_trial_history,
    store_accepted_pair_history,
)
from overturning.dem.polygon.equations import (
    clear_nonzero_pattern,
    mark_nonzero_and_return_pair_submatrices,
    solve_velocity_changes_in_place,
)
from overturning.dem.polygon.mechanics import (
    element_acceleration_relative_to_base,
    extrapolate_pose,
    extrapolate_velocity,
    power_against_inertial_or_fixing_forces,
)
from overturning.dem.polygon.search import update_nearest_faces_and_check_possible_contact
from overturning.dem.polygon.state import (
    ElementConstants,
    ElementStepMotionWorkAndPeaks,
    PlanarMotionOrForce,
    Pose,
    PredictedElement,
    SceneStateAndConstants,
    StepDecisionAndNextAttempt,
)
from overturning.dem.polygon.suspended_pairs import (
    keep_contact_tests_unless_distant,
    sum_motions_and_resume_contact_tests,
)


class CentredSchemeLagAndTicksPerStep(NamedTuple):
    """Constants of the centred scheme: lag of velocities behind poses, and ticks (time units) in a whole step."""

    velocity_lag_behind_pose_steps: float = 0.0
    """Lag of velocities behind poses, steps."""
    ticks_per_whole_step: float = SCENE_STEP_CONTROL.ticks_per_whole_step
    """Ticks in a whole step."""


@njit(**INLINE_OPTIONS)
def base_acceleration_acting_on_element_at_step_end(
    upward_base_acceleration_or_none: Any,
    scene_state: SceneStateAndConstants,
    element_constants: ElementConstants,
    ticks_per_sample: float,
) -> tuple[float, float]:
    """Return the base acceleration (horizontal, vertical, m/s²) that acts on an element at the end of a step.

    Both components are 0 for an element that moves with the base. The base moves only horizontally if
    `upward_base_acceleration_or_none` is None; its values are not used.
    """
    tick = (
        scene_state.base_acceleration.ticks_since_sample_start
        + scene_state.current_step_length_and_repetitions.length_in_ticks
    )
    past = tick - ticks_per_sample
    past = past if past > 0.0 else 0.0
    lift = 0.0
    if upward_base_acceleration_or_none is not None:
        lift = (
            base_acceleration_in_this_or_next_sample(scene_state.base_acceleration.vertical, tick, past)
            * element_constants.has_inertial_forces_in_base_frame
        )
    return base_acceleration_in_this_or_next_sample(
        scene_state.base_acceleration.horizontal, tick, past
    ) * element_constants.has_inertial_forces_in_base_frame, lift


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def predict_element_motion(
    upward_base_acceleration_or_none: Any,
    element_state_rows: Any,
    scene_state_rows: Any,
    ticks_per_sample: float,
    gravity: float,
) -> None:
    """Predict the motion of an element in a step with constant acceleration, for all cases in parallel."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        item, case = rows.load_element_state(element_state_rows, j), rows.load_scene_state(scene_state_rows, j)
        dt, a = case.tick_duration * case.current_step_length_and_repetitions.length_in_ticks, item.acceleration
        half = 0.5 * dt
        ground, lift = base_acceleration_acting_on_element_at_step_end(
            upward_base_acceleration_or_none, case, item.constants, ticks_per_sample
        )
        v = extrapolate_velocity(item.velocity, a, half)
        # Right-hand side of the equations, still without the contacts.
        fall = gravity * item.constants.is_subject_to_gravity + lift
        change = PlanarMotionOrForce(half * (-ground - a.x), half * (-fall - a.z), half * -a.angular)
        far, turn = dt * (abs(v.x) + abs(v.z)), abs(dt * v.angular)
        rows.store_predicted_motion(
            element_state_rows,
            j,
            PredictedElement(
                extrapolate_pose(item.pose, v, dt), v, extrapolate_velocity(v, a, half), far, turn, change
            ),
        )
        rows.store_contact_force_sum(element_state_rows, j, PlanarMotionOrForce(0.0, 0.0, 0.0))


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def store_element_state_of_accepted_step(
    upward_base_acceleration_or_none: Any,
    element_state_rows: Any,
    scene_state_rows: Any,
    ticks_per_sample: float,
    gravity: float,
) -> None:
    """Store the corrected state of an element at the end of the step, in cases whose step is accepted."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        item, case = rows.load_element_state(element_state_rows, j), rows.load_scene_state(scene_state_rows, j)
        dt, trial, old, again = (
            case.tick_duration * case.current_step_length_and_repetitions.length_in_ticks,
            item.predicted,
            item.step_motion_with_work_and_peaks_so_far,
            case.step_decision_and_next_attempt.positive_if_rejected > 0.0,
        )
        half, tick, d, p = (
            0.5 * dt,
            case.base_acceleration.ticks_since_sample_start + case.current_step_length_and_repetitions.length_in_ticks,
            trial.step_end_velocity_correction,
            trial.pose,
        )
        ground, lift = base_acceleration_acting_on_element_at_step_end(
            upward_base_acceleration_or_none, case, item.constants, ticks_per_sample
        )
        a = element_acceleration_relative_to_base(item, ground, lift, gravity)
        v = extrapolate_velocity(trial.velocity_at_half_step, a, half)
        turn = half * d.angular
        pose = Pose(p.x + half * d.x, p.z + half * d.z, p.angle + turn, p.cos - p.sin * turn, p.sin + p.cos * turn)
        rate, on = power_against_inertial_or_fixing_forces(item, ground, lift, v), pose.angle
        last = (
            tick
            if (on < item.constants.max_recoverable_rotation_to_plus_x)
            & (-on < item.constants.max_recoverable_rotation_to_minus_x)
            else old.last_recoverable_tick_in_sample
        )
        work = old.work_by_base_and_fixing_forces_so_far - half * (old.power_against_inertial_or_fixing_forces + rate)
        far = abs(pose.x - item.pose.x) + abs(pose.z - item.pose.z)
        back, on = updated_maximum(old.peak_rotation_to_minus_x, -on), updated_maximum(old.peak_rotation_to_plus_x, on)
        totals = ElementStepMotionWorkAndPeaks(far, abs(pose.angle - item.pose.angle), work, back, on, last, rate)
        rows.store_pose_unless_rejected(element_state_rows, j, again, pose)
        rows.store_velocity_unless_rejected(element_state_rows, j, again, v)
        rows.store_acceleration_unless_rejected(element_state_rows, j, again, a)
        rows.store_step_motion_work_and_peaks_unless_rejected(element_state_rows, j, again, totals)
        element_state_rows[rows.STEP_ABS_DX_PLUS_ABS_DZ_ROW_OFFSET + j] = select(again, 0.0, far)
        element_state_rows[rows.STEP_ABS_ROTATION_ROW_OFFSET + j] = select(again, 0.0, totals.abs_rotation_in_step)


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def reset_step_contact_changes(scene_state_rows: Any) -> None:
    """Reset the contact changes of the attempted step to "no change", for all cases in parallel."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        rows.store_largest_contact_changes(scene_state_rows, j, rows.create_zero_step_contact_changes())


@njit(**INLINE_OPTIONS)
def contact_changes_in_scene_step(scene_state: SceneStateAndConstants) -> StepContactChanges:
    """Return the contact changes of a case in an attempted step, by which the step is accepted or rejected."""
    findings, long = scene_state.contact_changes, not step_resolves_contact_vibration(scene_state)
    wrong, reverse, back = (
        (findings.has_wrong_slip_assumption > 0.0) & long,
        (findings.has_velocity_against_assumed_slip > 0.0) & long,
        (findings.friction_sign_changed_in_step > 0.0) & long,
    )
    return StepContactChanges(
        contact_opened_or_closed=findings.contact_or_nearest_faces_changed > 0.0,
        motion_requires_shorter_step=False,
        may_accept_despite_contact_change=False,
        has_wrong_slip_assumption=wrong,
        has_velocity_against_assumed_slip=reverse,
        friction_sign_changed_in_step=back,
        slides_on_all_points=findings.pair_slides_on_both_points > 0.0,
        all_contacts_are_closed=False,
    )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def accept_or_reject_steps(scene_state_rows: Any, ticks_per_sample: float) -> None:
    """Accept or reject the attempted step of each case, and choose the length of the next attempt."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        case = rows.load_scene_state(scene_state_rows, j)
        tick = (
            case.base_acceleration.ticks_since_sample_start + case.current_step_length_and_repetitions.length_in_ticks
        )
        again, sooner, then = decide_rejection_sliding_and_next_step(
            SCENE_STEP_CONTROL,
            case.case_step_length_settings,
            case.current_step_length_and_repetitions,
            contact_changes_in_scene_step(case),
            tick,
            ticks_per_sample,
        )
        rows.store_step_decision_and_next_attempt(
            scene_state_rows, j, StepDecisionAndNextAttempt(1.0 if again else 0.0, 1.0 if sooner else 0.0, then)
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def advance_accepted_steps_and_set_next_attempts(scene_state_rows: Any) -> None:
    """Advance the time of each case whose step is accepted; set the next attempted step of all cases."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        case = rows.load_scene_state(scene_state_rows, j)
        tick = case.base_acceleration.ticks_since_sample_start
        scene_state_rows[rows.TICKS_SINCE_SAMPLE_START_ROW_OFFSET + j] = (
            tick
            if case.step_decision_and_next_attempt.positive_if_rejected > 0.0
            else tick + case.current_step_length_and_repetitions.length_in_ticks
        )
        rows.store_next_step_to_attempt(scene_state_rows, j, case.step_decision_and_next_attempt.next_attempt)


@njit(**INTERNAL_COMPILE_OPTIONS)
def advance_scene_one_step(
    upward_base_acceleration_or_none: Any,
    case_states: Any,
    equation_submatrices_of_all_cases: Any,
    nonzero_pattern: Any,
    pair_contact_test_schedule: Any,
    moves_relative_to_base_by_element: Any,
    scene_arrays: Any,
    ticks_per_sample: float,
) -> None:
    """Attempt one step of the centred scheme in all cases of a scene; None means no vertical base motion."""
    reset_step_contact_changes(case_states)
    size, near = moves_relative_to_base_by_element.size, pair_contact_test_schedule.may_touch_by_pair
    clear_nonzero_pattern(nonzero_pattern)
    for i in range(size):
        predict_element_motion(
            upward_base_acceleration_or_none,
            rows.slice_element_rows(case_states, i),
            case_states,
            ticks_per_sample,
            scene_arrays.gravity,
        )
    sum_motions_and_resume_contact_tests(case_states, scene_arrays, pair_contact_test_schedule, size)
    kept = 0
    for n in range(pair_contact_test_schedule.active_pair_count[0]):
        p = pair_contact_test_schedule.indices_of_pairs_tested_each_step[n]
        q, a, b = rows.slice_pair_and_element_rows(case_states, scene_arrays, p)
        near[p] = update_nearest_faces_and_check_possible_contact(
            case_states,
            q,
            a,
            b,
            scene_arrays.pair_element_and_piece_indices[p, 2],
            scene_arrays.pair_element_and_piece_indices[p, 3],
            scene_arrays.piece_vertex_counts,
            scene_arrays.piece_face_tables,
        )
        if near[p]:
            into, fresh = mark_nonzero_and_return_pair_submatrices(
                equation_submatrices_of_all_cases,
                nonzero_pattern,
                moves_relative_to_base_by_element,
                scene_arrays.pair_element_and_piece_indices[p, 0],
                scene_arrays.pair_element_and_piece_indices[p, 1],
            )
            add_pair_contact_terms_to_equations(q, a, b, case_states, into, fresh)
        if near[p] or keep_contact_tests_unless_distant(q, a, b, p, pair_contact_test_schedule):
            pair_contact_test_schedule.indices_of_pairs_tested_each_step[kept] = p
            kept += 1
    pair_contact_test_schedule.active_pair_count[0] = kept
    solve_velocity_changes_in_place(case_states, equation_submatrices_of_all_cases, nonzero_pattern, size)
    for n in range(kept):
        p = pair_contact_test_schedule.indices_of_pairs_tested_each_step[n]
        if near[p]:
            q, a, b = rows.slice_pair_and_element_rows(case_states, scene_arrays, p)
            add_solved_pair_forces_and_store_trial_history(q, a, b, case_states)
    accept_or_reject_steps(case_states, ticks_per_sample)
    for i in range(size):
        if moves_relative_to_base_by_element[i]:
            store_element_state_of_accepted_step(
                upward_base_acceleration_or_none,
                rows.slice_element_rows(case_states, i),
                case_states,
                ticks_per_sample,
                scene_arrays.gravity,
            )
    for n in range(kept):
        p = pair_contact_test_schedule.indices_of_pairs_tested_each_step[n]
        if near[p]:
            q, _, _ = rows.slice_pair_and_element_rows(case_states, scene_arrays, p)
            store_accepted_pair_history(q, case_states)
    advance_accepted_steps_and_set_next_attempts(case_states)
