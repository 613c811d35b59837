"""Loops over the stacks computed in parallel that accept or reject a step, and store the accepted state."""

from typing import Any

from numba import njit

from overturning.dem.body.commit import base_acceleration_allows_sample_long_steps
from overturning.dem.body.state import (
    StepRejectedAndSameContactStateFlags,
    squared_sine_of_lean_continued_beyond_90_deg,
)
from overturning.dem.body.vectors import (
    Vector3,
    extrapolate_vector,
    plus,
    rotate_quaternion,
    rotation_matrix,
    scale_vector,
)
from overturning.dem.kernel.clock import STACK_STEP_CONTROL, StepContactChanges, decide_rejection_sliding_and_next_step
from overturning.dem.kernel.lanes import (
    NO_ALIAS_COMPILE_OPTIONS,
    assume_lane_count_is_multiple_of_8,
    select,
)
from overturning.dem.kernel.mechanics import updated_maximum
from overturning.dem.stack.access import (
    IS_SIMULATED_ROW_OFFSET,
    load_clock_within_sample,
    load_energy_account,
    load_force_sums,
    load_gravity_and_inertial_acceleration,
    load_inertial_and_upward_base_accelerations,
    load_joint_state_at_step_end,
    load_largest_contact_changes,
    load_next_step_to_attempt,
    load_peaks_and_last_upright_tick,
    load_point_state_at_step_end,
    load_power_loss_and_lost_spring_energy,
    load_predicted_stone,
    load_step_lengths_and_doubling_counts,
    load_step_rejection_flags,
    load_stone_constants,
    load_tick_length_failure_and_rest_limits,
    load_velocity_correction,
    store_clock_within_sample,
    store_energy_and_penetration_unless_rejected,
    store_joint_state_at_step_start_unless_rejected,
    store_next_step_to_attempt,
    store_peaks_and_upright_tick_unless_rejected,
    store_point_state_at_step_start_unless_rejected,
    store_step_rejection_flags,
    store_stone_state_unless_rejected,
)
from overturning.dem.stack.joint_state import JOINT_ROW_LAYOUT, JointAtStepStartAndEnd
from overturning.dem.stack.state import (
    StackClockWithinSample,
    StackEnergyAccountAndPeakPenetration,
    StonePeakLeanAndLastUprightTick,
    StoneState,
)
from overturning.units import STANDARD_GRAVITY as GRAVITY

SLID_BEFORE_STEP_ROW_OFFSET = JOINT_ROW_LAYOUT.row_offset_of_field(
    JointAtStepStartAndEnd, "at_step_start.slid_in_last_step_or_rejected_attempt"
)
SLID_AT_STEP_END_ROW_OFFSET = JOINT_ROW_LAYOUT.row_offset_of_field(
    JointAtStepStartAndEnd, "at_step_end.slid_in_last_step_or_rejected_attempt"
)


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def decide_step_acceptance_and_advance_clock(case_rows: Any, lane_count: int, ticks_per_sample: float) -> None:
    """Decide whether each stack's step is accepted, advance its clock if so, and choose the next attempt's length."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        attempt = load_next_step_to_attempt(case_rows, j)
        most = load_largest_contact_changes(case_rows, j)
        time = load_clock_within_sample(case_rows, j)
        inertial = load_gravity_and_inertial_acceleration(case_rows, j)
        at_end = Vector3(inertial.x, inertial.y, -(inertial.z + GRAVITY))
        steady = base_acceleration_allows_sample_long_steps(
            load_inertial_and_upward_base_accelerations(case_rows, j),
            at_end,
            ticks_per_sample,
            load_tick_length_failure_and_rest_limits(case_rows, j).max_base_acceleration_for_sample_long_steps_g,
        )
        findings = StepContactChanges(
            contact_opened_or_closed=most.positive_if_contact_opened_or_closed > 0.0,
            motion_requires_shorter_step=False,
            may_accept_despite_contact_change=False,
            has_wrong_slip_assumption=most.has_wrong_slip_assumption > 0.0,
            has_velocity_against_assumed_slip=most.has_friction_opposite_to_assumption > 0.0,
            friction_sign_changed_in_step=most.friction_sign_changed_in_step > 0.0,
            slides_on_all_points=(most.has_sticking_loaded_joint == 0.0) & (most.has_loaded_joint > 0.0),
            all_contacts_are_closed=steady & (most.some_point_carries_no_load == 0.0) & (most.has_loaded_joint > 0.0),
        )
        again, sooner, following = decide_rejection_sliding_and_next_step(
            STACK_STEP_CONTROL,
            load_step_lengths_and_doubling_counts(case_rows, j),
            attempt,
            findings,
            time.ticks_since_sample_start + attempt.length_in_ticks,
            ticks_per_sample,
        )
        store_next_step_to_attempt(case_rows, j, following)
        store_step_rejection_flags(
            case_rows, j, StepRejectedAndSameContactStateFlags(1.0 if again else 0.0, 1.0 if sooner else 0.0)
        )
        store_clock_within_sample(
            case_rows,
            j,
            StackClockWithinSample(
                time.ticks_since_sample_start + (0.0 if again else attempt.length_in_ticks), time.half_step_length_s
            ),
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def store_stone_and_add_work_if_step_accepted(
    case_rows: Any, stone_rows: Any, lane_count: int, none_unless_lowest_stone: Any
) -> None:
    """Store a stone's new state, and add the base motion's work on it, in stacks whose step is accepted.

    With the lowest stone (`none_unless_lowest_stone` is not None) the step's energy losses of all contacts are added.
    """
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        half = load_clock_within_sample(case_rows, j).half_step_length_s
        again = load_step_rejection_flags(case_rows, j).is_step_rejected > 0.0
        push = load_gravity_and_inertial_acceleration(case_rows, j)
        constants, p = load_stone_constants(stone_rows, j), load_predicted_stone(stone_rows, j)
        change = load_velocity_correction(stone_rows, j)
        total = load_force_sums(stone_rows, j)
        peaks = load_peaks_and_last_upright_tick(stone_rows, j)
        present = stone_rows[IS_SIMULATED_ROW_OFFSET + j] > 0.0
        one = 1.0 / constants.mass
        f = total.force_and_moment_at_step_end.force_or_velocity
        m = total.force_and_moment_at_step_end.moment_or_angular_velocity
        i = total.extra_impulses_of_early_contacts.force_or_velocity
        t = total.extra_impulses_of_early_contacts.moment_or_angular_velocity
        acceleration = Vector3(one * f.x + push.x, one * f.y + push.y, one * f.z + push.z)
        moment = scale_vector(one, m)
        turn = rotate_quaternion(p.rotation, half, change.angular_velocity)
        velocity = plus(extrapolate_vector(p.velocity_at_half_step, half, acceleration), scale_vector(one, i))
        axes = rotation_matrix(turn)
        lean = squared_sine_of_lean_continued_beyond_90_deg(axes)
        tick = load_clock_within_sample(case_rows, j).ticks_since_sample_start
        skip = again | (not present)
        store_stone_state_unless_rejected(
            stone_rows,
            j,
            skip,
            StoneState(
                centre_position=extrapolate_vector(p.centre_position, half, change.velocity),
                rotation=turn,
                velocity_relative_to_base=velocity,
                angular_momentum_per_mass=plus(
                    extrapolate_vector(p.angular_momentum_per_mass_at_half_step, half, moment), scale_vector(one, t)
                ),
                acceleration_relative_to_base=acceleration,
                contact_moment_per_mass=moment,
            ),
        )
        store_peaks_and_upright_tick_unless_rejected(stone_rows, j, skip, StonePeakLeanAndLastUprightTick(
            updated_maximum(peaks.peak_lean_as_continued_squared_sine, lean),
            select(
                lean < constants.critical_lean_squared_sine_on_contact_at_rest, tick, peaks.last_upright_tick_in_sample
            ),
        ))  # fmt: skip
        power = (push.x * velocity.x + push.y * velocity.y) + (push.z + GRAVITY) * velocity.z
        power = constants.mass * power if present else 0.0
        account, losses = load_energy_account(case_rows, j), load_power_loss_and_lost_spring_energy(case_rows, j)
        if none_unless_lowest_stone is not None:
            account = StackEnergyAccountAndPeakPenetration(
                account.base_motion_work + half * account.base_motion_power_at_step_end,
                account.dissipated_or_removed_energy
                + (
                    half * (account.dissipated_power_at_step_end + losses.dissipated_power_at_step_end)
                    + losses.lost_spring_energy_in_step
                ),
                0.0,
                losses.dissipated_power_at_step_end,
                updated_maximum(
                    account.peak_penetration, load_largest_contact_changes(case_rows, j).largest_penetration
                ),
            )
        store_energy_and_penetration_unless_rejected(case_rows, j, again, StackEnergyAccountAndPeakPenetration(
            account.base_motion_work + half * power, account.dissipated_or_removed_energy,
            account.base_motion_power_at_step_end + power,
            account.dissipated_power_at_step_end, account.peak_penetration
        ))  # fmt: skip


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def store_joint_states_after_accepted_steps(case_rows: Any, joint_rows: Any, lane_count: int) -> None:
    """Store two stones' new contact state in stacks whose step is accepted.

    After a rejected step, store only whether the stones slid, unless the next attempt keeps the slip assumption.
    """
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        rejected, slid = load_step_rejection_flags(case_rows, j), joint_rows[SLID_AT_STEP_END_ROW_OFFSET + j]
        store_joint_state_at_step_start_unless_rejected(
            joint_rows, j, rejected.is_step_rejected > 0.0, load_joint_state_at_step_end(joint_rows, j)
        )
        joint_rows[SLID_BEFORE_STEP_ROW_OFFSET + j] = select(
            rejected.next_attempt_keeps_slip_assumption > 0.0, joint_rows[SLID_BEFORE_STEP_ROW_OFFSET + j], slid
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def update_contact_point_states_after_attempted_steps(case_rows: Any, point_rows: Any, lane_count: int) -> None:
    """Store a contact point's new state in the stacks whose step is accepted."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        store_point_state_at_step_start_unless_rejected(
            point_rows,
            j,
            load_step_rejection_flags(case_rows, j).is_step_rejected > 0.0,
            load_point_state_at_step_end(point_rows, j),
        )
