"""Loops over the stacks computed in parallel that end a step: contact forces, acceptance, and the new state."""

import math
from typing import Any, Final

from numba import njit

from overturning.dem.body.commit import base_acceleration_stays_below_limit
from overturning.dem.body.state import StepRejectionFlags, lean_as_squared_sine
from overturning.dem.body.vectors import (
    Matrix3,
    Vector3,
    cross_product,
    extrapolate_vector,
    matrix_times_vector,
    minus,
    plus,
    rotate_quaternion,
    rotation_matrix,
    scale_vector,
    transpose,
)
from overturning.dem.kernel.clock import STACK_STEP_CONTROL, StepContactChanges, decide_rejection_and_next_step
from overturning.dem.kernel.lanes import (
    INLINE_OPTIONS,
    NO_ALIAS_COMPILE_OPTIONS,
    create_elementwise_tuple_functions,
    round_to_vector_multiple,
    select,
)
from overturning.dem.kernel.mechanics import updated_maximum
from overturning.dem.stack.access import (
    IS_SIMULATED_ROW_OFFSET,
    STIFFNESS_SHARE_ROW_OFFSET,
    USES_NON_CORNER_AT_STEP_END_ROW_OFFSET,
    add_losses,
    larger_of,
    load_account,
    load_arm,
    load_attempt,
    load_case,
    load_change,
    load_clock,
    load_constants,
    load_findings,
    load_frame,
    load_friction,
    load_history,
    load_inertial,
    load_joint,
    load_joint_change,
    load_joint_pose,
    load_landing,
    load_losses,
    load_next_history,
    load_next_point,
    load_peaks,
    load_place,
    load_point,
    load_point_sum,
    load_predicted,
    load_rejection,
    load_shaking,
    load_sum,
    load_time,
    store_account_unless,
    store_arm,
    store_attempt,
    store_findings,
    store_history_unless,
    store_joint_change,
    store_losses,
    store_next_history,
    store_next_point,
    store_peaks_unless,
    store_point_sum,
    store_point_unless,
    store_rejection,
    store_stone_unless,
    store_sum,
    store_time,
)
from overturning.dem.stack.joint import solve_joint_contact
from overturning.dem.stack.joint_point import solve_point_contact
from overturning.dem.stack.joint_state import (
    JOINT_ROW_LAYOUT,
    JointAtStepStartAndEnd,
    JointPointForceAndImpulse,
    SumOfForceTimesDistance,
)
from overturning.dem.stack.landing import (
    SHORTEST_LANDING_TIME_WITHOUT_POINTS_S,
    point_contact_is_deferred,
    remaining_landing_time_of_new_contact,
    stone_base_lands_flat,
)
from overturning.dem.stack.solve import shift_wrench_to_stone_centre, wrench_minus, wrench_plus
from overturning.dem.stack.state import (
    StackClockWithinSample,
    StackEnergyAccount,
    StoneContactForceSums,
    StonePeakTilt,
    StoneState,
    StoneVelocityCorrection,
    Wrench,
)
from overturning.units import STANDARD_GRAVITY as GRAVITY

add_end, no_end = (
    create_elementwise_tuple_functions(JointPointForceAndImpulse).plus,
    create_elementwise_tuple_functions(JointPointForceAndImpulse).zero,
)
MAX_PREDICTED_FORCE_STEP_TO_SHORTEST_STEP: Final = STACK_STEP_CONTROL.longest_predicted_force_step_in_shortest_steps
"""Longest step that uses predicted forces for contact and slip, as a multiple of the finest step."""
SLID, NEW_SLID = (
    JOINT_ROW_LAYOUT.row_offset_of_field(JointAtStepStartAndEnd, "old.slid_in_last_step"),
    JOINT_ROW_LAYOUT.row_offset_of_field(JointAtStepStartAndEnd, "new.slid_in_last_step"),
)


@njit(**INLINE_OPTIONS)
def relative_velocity_change_of_joint(
    upper_velocity_correction: StoneVelocityCorrection,
    lower_velocity_correction: StoneVelocityCorrection,
    contact_origin_from_upper_and_lower_centre: tuple[Vector3, Vector3],
    contact_frame_axes: Matrix3,
) -> tuple[Vector3, Vector3]:
    """Return the correction of the upper stone's velocity and spin relative to the lower, in their contact's frame."""
    to_face = transpose(contact_frame_axes)
    velocity = minus(
        plus(
            upper_velocity_correction.velocity,
            cross_product(upper_velocity_correction.angular_velocity, contact_origin_from_upper_and_lower_centre[0]),
        ),
        plus(
            lower_velocity_correction.velocity,
            cross_product(lower_velocity_correction.angular_velocity, contact_origin_from_upper_and_lower_centre[1]),
        ),
    )
    return matrix_times_vector(to_face, velocity), matrix_times_vector(
        to_face, minus(upper_velocity_correction.angular_velocity, lower_velocity_correction.angular_velocity)
    )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def store_joint_velocity_change_and_clear_sums(
    upper_stone_rows: Any, lower_stone_rows: Any, joint_rows: Any, lane_count: int, none_unless_on_ground: Any
) -> None:
    """Store the solved change of a stone's velocity relative to its support; clear their contact's force sums."""
    for j in range(round_to_vector_multiple(lane_count)):
        stone, one = load_predicted(upper_stone_rows, j), load_change(upper_stone_rows, j)
        if none_unless_on_ground is None:
            below, (axes, origin) = load_predicted(lower_stone_rows, j), load_joint_pose(joint_rows, j)
            arms = (minus(origin, stone.centre_position), minus(origin, below.centre_position))
            velocity, spin = relative_velocity_change_of_joint(one, load_change(lower_stone_rows, j), arms, axes)
        else:
            velocity, spin = (
                plus(one.velocity, cross_product(one.angular_velocity, scale_vector(-1.0, stone.centre_position))),
                one.angular_velocity,
            )
        store_joint_change(joint_rows, j, Wrench(velocity, spin))
        store_arm(joint_rows, j, SumOfForceTimesDistance(0.0))
        store_point_sum(joint_rows, j, no_end())


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def compute_point_normal_force_and_new_state(case_rows: Any, joint_rows: Any, point_rows: Any, lane_count: int) -> None:
    """Compute a contact point's normal force and new state at the step end; add the force to its contact's sums."""
    for j in range(round_to_vector_multiple(lane_count)):
        joint, frame, place = load_joint(joint_rows, j), load_frame(joint_rows, j), load_place(point_rows, j)
        change, landing = load_joint_change(joint_rows, j), load_landing(joint_rows, j)
        old = load_point(point_rows, j)
        end, findings, losses, new = solve_point_contact(
            joint, frame, place, old, (change.force_or_velocity, change.moment_or_angular_velocity),
            (load_time(case_rows, j).half_step_length_s, stone_base_lands_flat(landing),
             remaining_landing_time_of_new_contact(joint, landing),
             point_contact_is_deferred(joint, landing, place, old, frame.min_base_corner_distance_inside_rim),
             landing.shortest_landing_time_of_points < SHORTEST_LANDING_TIME_WITHOUT_POINTS_S),
        )  # fmt: skip
        store_next_point(point_rows, j, new)
        store_point_sum(joint_rows, j, add_end(load_point_sum(joint_rows, j), end))
        store_findings(case_rows, j, larger_of(load_findings(case_rows, j), findings))
        store_losses(case_rows, j, add_losses(load_losses(case_rows, j), losses))


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def add_force_times_pressure_centre_distance(joint_rows: Any, point_rows: Any, lane_count: int) -> None:
    """Add one contact point's normal force × distance from the centre of pressure (N·m) to the contact's sum."""
    for j in range(round_to_vector_multiple(lane_count)):
        total, place, new = load_point_sum(joint_rows, j), load_place(point_rows, j), load_next_point(point_rows, j)
        one = 1.0 / (total.normal_force if total.normal_force > 0.0 else 1.0)
        x, y = (
            place.x_in_joint_frame - total.normal_force_times_x * one,
            place.y_in_joint_frame - total.normal_force_times_y * one,
        )
        arm = (
            load_arm(joint_rows, j).force_times_pressure_centre_distance
            + place.joint_stiffness_share * new.force_per_stiffness_share * math.sqrt(x * x + y * y)
        )
        store_arm(joint_rows, j, SumOfForceTimesDistance(arm))


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def compute_joint_forces_and_add_to_stones(
    case_rows: Any,
    upper_stone_rows: Any,
    lower_stone_rows: Any,
    joint_rows: Any,
    lane_count: int,
    none_unless_on_ground: Any,
) -> None:
    """Compute force, moment and new state of a stone's contact with its support; add the force to both stones' sums."""
    for j in range(round_to_vector_multiple(lane_count)):
        change, flat = load_joint_change(joint_rows, j), stone_base_lands_flat(load_landing(joint_rows, j))
        fine = (
            load_attempt(case_rows, j).length_in_ticks
            <= MAX_PREDICTED_FORCE_STEP_TO_SHORTEST_STEP * load_clock(case_rows, j).shortest_step_ticks
        )
        at_end, early, findings, losses, new = solve_joint_contact(
            load_joint(joint_rows, j),
            load_frame(joint_rows, j),
            load_friction(joint_rows, j),
            (load_point_sum(joint_rows, j), load_arm(joint_rows, j).force_times_pressure_centre_distance),
            (change.force_or_velocity, change.moment_or_angular_velocity),
            load_history(joint_rows, j),
            (load_time(case_rows, j).half_step_length_s, fine, flat, load_constants(upper_stone_rows, j).centre_height),
        )
        store_next_history(joint_rows, j, new)
        store_findings(case_rows, j, larger_of(load_findings(case_rows, j), findings))
        store_losses(case_rows, j, add_losses(load_losses(case_rows, j), losses))
        stone, total = load_predicted(upper_stone_rows, j), load_sum(upper_stone_rows, j)
        if none_unless_on_ground is None:
            below, (axes, origin) = load_predicted(lower_stone_rows, j), load_joint_pose(joint_rows, j)
            at_end = Wrench(
                matrix_times_vector(axes, at_end.force_or_velocity),
                matrix_times_vector(axes, at_end.moment_or_angular_velocity),
            )
            early = Wrench(
                matrix_times_vector(axes, early.force_or_velocity),
                matrix_times_vector(axes, early.moment_or_angular_velocity),
            )
            arm, other = minus(origin, below.centre_position), load_sum(lower_stone_rows, j)
            store_sum(lower_stone_rows, j, StoneContactForceSums(
                wrench_minus(other.force_and_moment_at_step_end, shift_wrench_to_stone_centre(at_end, arm)),
                wrench_minus(other.extra_impulses_of_early_contacts, shift_wrench_to_stone_centre(early, arm)),
            ))  # fmt: skip
        else:
            origin = Vector3(0.0, 0.0, 0.0)
        arm = minus(origin, stone.centre_position)
        store_sum(upper_stone_rows, j, StoneContactForceSums(
            wrench_plus(total.force_and_moment_at_step_end, shift_wrench_to_stone_centre(at_end, arm)),
            wrench_plus(total.extra_impulses_of_early_contacts, shift_wrench_to_stone_centre(early, arm)),
        ))  # fmt: skip


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def mark_joints_that_use_a_non_corner_point(joint_rows: Any, point_rows: Any, lane_count: int) -> None:
    """Mark contacts of two stones that use a given point, no corner of the upper base: it has a share of stiffness.

    Such a base extends beyond the rim of the face below.
    """
    for j in range(round_to_vector_multiple(lane_count)):
        joint_rows[USES_NON_CORNER_AT_STEP_END_ROW_OFFSET + j] = select(
            point_rows[STIFFNESS_SHARE_ROW_OFFSET + j] > 0.0,
            1.0,
            joint_rows[USES_NON_CORNER_AT_STEP_END_ROW_OFFSET + j],
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def decide_step_acceptance_and_advance_clock(case_rows: Any, lane_count: int, ticks_per_sample: float) -> None:
    """Decide whether each stack's step is accepted, advance its clock if so, and choose the next attempt's length."""
    for j in range(round_to_vector_multiple(lane_count)):
        attempt, most, time = load_attempt(case_rows, j), load_findings(case_rows, j), load_time(case_rows, j)
        inertial = load_inertial(case_rows, j)
        at_end = Vector3(inertial.x, inertial.y, -(inertial.z + GRAVITY))
        steady = base_acceleration_stays_below_limit(
            load_shaking(case_rows, j),
            at_end,
            ticks_per_sample,
            load_case(case_rows, j).max_acceleration_for_sample_long_steps_g,
        )
        findings = StepContactChanges(
            contact_changed=most.positive_if_contact_opened_or_closed > 0.0,
            motion_requires_shorter_step=False,
            may_accept_despite_contact_change=False,
            has_wrong_slip_assumption=most.has_wrong_slip_assumption > 0.0,
            has_slip_reversal=most.has_friction_against_assumed_direction > 0.0,
            has_friction_reversal=most.has_friction_reversal > 0.0,
            slides_on_all_points=(most.has_sticking_loaded_joint == 0.0) & (most.has_loaded_joint > 0.0),
            all_contacts_are_closed=steady & (most.has_unloaded_point == 0.0) & (most.has_loaded_joint > 0.0),
        )
        again, sooner, following = decide_rejection_and_next_step(
            STACK_STEP_CONTROL,
            load_clock(case_rows, j),
            attempt,
            findings,
            time.ticks_since_sample_start + attempt.length_in_ticks,
            ticks_per_sample,
        )
        store_attempt(case_rows, j, following)
        store_rejection(case_rows, j, StepRejectionFlags(1.0 if again else 0.0, 1.0 if sooner else 0.0))
        store_time(
            case_rows,
            j,
            StackClockWithinSample(
                time.ticks_since_sample_start + (0.0 if again else attempt.length_in_ticks), time.half_step_length_s
            ),
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def store_stone_and_energy_if_step_accepted(
    case_rows: Any, stone_rows: Any, lane_count: int, none_unless_lowest_stone: Any
) -> None:
    """Store a stone's new state, and add the base motion's work on it, in stacks whose step is accepted.

    With the lowest stone the losses of the step are added too.
    """
    for j in range(round_to_vector_multiple(lane_count)):
        half, again, push = (
            load_time(case_rows, j).half_step_length_s,
            load_rejection(case_rows, j).is_step_rejected > 0.0,
            load_inertial(case_rows, j),
        )
        constants, p = load_constants(stone_rows, j), load_predicted(stone_rows, j)
        change, total, peaks = load_change(stone_rows, j), load_sum(stone_rows, j), load_peaks(stone_rows, j)
        present = stone_rows[IS_SIMULATED_ROW_OFFSET + j] > 0.0
        one = 1.0 / constants.mass
        f, m, i, t = (
            total.force_and_moment_at_step_end.force_or_velocity,
            total.force_and_moment_at_step_end.moment_or_angular_velocity,
            total.extra_impulses_of_early_contacts.force_or_velocity,
            total.extra_impulses_of_early_contacts.moment_or_angular_velocity,
        )
        acceleration = Vector3(one * f.x + push.x, one * f.y + push.y, one * f.z + push.z)
        moment = scale_vector(one, m)
        turn = rotate_quaternion(p.rotation, half, change.angular_velocity)
        velocity = plus(extrapolate_vector(p.velocity_at_half_step, half, acceleration), scale_vector(one, i))
        axes = rotation_matrix(turn)
        lean = lean_as_squared_sine(axes)
        tick = load_time(case_rows, j).ticks_since_sample_start
        skip = again | (not present)
        store_stone_unless(
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
        store_peaks_unless(stone_rows, j, skip, StonePeakTilt(
            updated_maximum(peaks.peak_lean_squared_sine, lean),
            tick if lean < constants.critical_lean_squared_sine_on_contact_patch else peaks.last_upright_tick_in_sample
        ))  # fmt: skip
        power = (push.x * velocity.x + push.y * velocity.y) + (push.z + GRAVITY) * velocity.z
        power = constants.mass * power if present else 0.0
        account, losses = load_account(case_rows, j), load_losses(case_rows, j)
        if none_unless_lowest_stone is not None:
            account = StackEnergyAccount(
                account.base_motion_work + half * account.base_motion_power_at_step_end,
                account.lost_energy
                + (
                    half * (account.dissipated_power_at_step_end + losses.dissipated_power_at_step_end)
                    + losses.lost_spring_energy_in_step
                ),
                0.0,
                losses.dissipated_power_at_step_end,
                updated_maximum(account.peak_penetration, load_findings(case_rows, j).largest_penetration),
            )
        store_account_unless(case_rows, j, again, StackEnergyAccount(
            account.base_motion_work + half * power, account.lost_energy, account.base_motion_power_at_step_end + power,
            account.dissipated_power_at_step_end, account.peak_penetration
        ))  # fmt: skip


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def store_joint_states_after_accepted_steps(case_rows: Any, joint_rows: Any, lane_count: int) -> None:
    """Store two stones' new contact state in stacks whose step is accepted; in others at most whether they slid."""
    for j in range(round_to_vector_multiple(lane_count)):
        rejected, slid = load_rejection(case_rows, j), joint_rows[NEW_SLID + j]
        store_history_unless(joint_rows, j, rejected.is_step_rejected > 0.0, load_next_history(joint_rows, j))
        joint_rows[SLID + j] = select(rejected.next_attempt_keeps_slip_assumption > 0.0, joint_rows[SLID + j], slid)


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def store_contact_point_states_after_accepted_steps(case_rows: Any, point_rows: Any, lane_count: int) -> None:
    """Store a contact point's new state in the stacks whose step is accepted."""
    for j in range(round_to_vector_multiple(lane_count)):
        store_point_unless(
            point_rows, j, load_rejection(case_rows, j).is_step_rejected > 0.0, load_next_point(point_rows, j)
        )
