"""Loops over the stacks computed in parallel that compute contact forces and states at the end of a step."""

import math
from typing import Any

from numba import njit

from overturning.dem.body.centred import step_is_short_enough_for_predicted_forces
from overturning.dem.body.vectors import (
    Matrix3,
    Vector3,
    cross_product,
    matrix_times_vector,
    minus,
    plus,
    scale_vector,
    transpose,
)
from overturning.dem.kernel.lanes import (
    INLINE_OPTIONS,
    NO_ALIAS_COMPILE_OPTIONS,
    assume_lane_count_is_multiple_of_8,
    create_tuple_sum_difference_and_maximum_functions,
    select,
)
from overturning.dem.stack.access import (
    STIFFNESS_SHARE_IN_ATTEMPTED_STEP_ROW_OFFSET,
    USES_NON_CORNER_AT_STEP_END_ROW_OFFSET,
    add_energy_losses,
    larger_value_of_each_contact_change,
    load_assumed_joint_friction_state,
    load_clock_within_sample,
    load_flat_landing_times_and_point_heights,
    load_force_sums,
    load_force_times_pressure_centre_distance,
    load_joint_constants,
    load_joint_force_and_impulse_sums,
    load_joint_frame,
    load_joint_state_at_step_start,
    load_joint_wrench_or_velocity_change,
    load_largest_contact_changes,
    load_next_step_to_attempt,
    load_point_position,
    load_point_state_at_step_end,
    load_point_state_at_step_start,
    load_power_loss_and_lost_spring_energy,
    load_predicted_stone,
    load_relative_motion,
    load_step_lengths_and_doubling_counts,
    load_stone_constants,
    load_velocity_correction,
    store_force_sums,
    store_force_times_pressure_centre_distance,
    store_joint_force_and_impulse_sums,
    store_joint_state_at_step_end,
    store_joint_wrench_or_velocity_change,
    store_largest_contact_changes,
    store_point_state_at_step_end,
    store_power_loss_and_lost_spring_energy,
)
from overturning.dem.stack.joint import joint_contact_forces_and_state_at_step_end
from overturning.dem.stack.joint_point import point_contact_forces_and_state_at_step_end
from overturning.dem.stack.joint_state import (
    HalfStepAndFlatLandingConditionsOfPoint,
    JointFrictionSolutionInputs,
    NormalForceAndEarlyContactImpulseSums,
    SumOfForceTimesDistanceToPressureCentre,
)
from overturning.dem.stack.landing import (
    LANDING_TIME_PLACEHOLDER_WITHOUT_POINTS_S,
    flat_landing_of_stone_is_under_way,
    point_contact_is_deferred,
    remaining_landing_time_of_new_contact,
)
from overturning.dem.stack.solve import (
    add_wrenches_or_velocities,
    shift_wrench_to_stone_centre,
    subtract_wrenches_or_velocities,
)
from overturning.dem.stack.state import (
    ForceAndMomentOrVelocities,
    StoneContactForceSums,
    StoneVelocityCorrection,
)

add_normal_force_and_early_impulse_sums = create_tuple_sum_difference_and_maximum_functions(
    NormalForceAndEarlyContactImpulseSums
).plus
create_zero_normal_force_and_impulse_sums = create_tuple_sum_difference_and_maximum_functions(
    NormalForceAndEarlyContactImpulseSums
).zero


@njit(**INLINE_OPTIONS)
def velocity_correction_of_upper_relative_to_lower(
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
    upper_stone_rows: Any,
    lower_stone_rows: Any,
    joint_rows: Any,
    lane_count: int,
    marker_if_support_is_ground_else_none: Any,
) -> None:
    """Store the solved change of a stone's velocity relative to its support; clear their contact's force sums."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        stone, one = load_predicted_stone(upper_stone_rows, j), load_velocity_correction(upper_stone_rows, j)
        if marker_if_support_is_ground_else_none is None:
            below, (axes, origin) = load_predicted_stone(lower_stone_rows, j), load_joint_frame(joint_rows, j)
            arms = (minus(origin, stone.centre_position), minus(origin, below.centre_position))
            velocity, spin = velocity_correction_of_upper_relative_to_lower(
                one, load_velocity_correction(lower_stone_rows, j), arms, axes
            )
        else:
            velocity, spin = (
                plus(one.velocity, cross_product(one.angular_velocity, scale_vector(-1.0, stone.centre_position))),
                one.angular_velocity,
            )
        store_joint_wrench_or_velocity_change(joint_rows, j, ForceAndMomentOrVelocities(velocity, spin))
        store_force_times_pressure_centre_distance(joint_rows, j, SumOfForceTimesDistanceToPressureCentre(0.0))
        store_joint_force_and_impulse_sums(joint_rows, j, create_zero_normal_force_and_impulse_sums())


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def store_point_state_and_add_normal_force_to_joint(
    case_rows: Any, joint_rows: Any, point_rows: Any, lane_count: int
) -> None:
    """Compute a contact point's normal force and new state at the step end; add the force to its contact's sums."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        joint = load_joint_constants(joint_rows, j)
        frame = load_relative_motion(joint_rows, j)
        place = load_point_position(point_rows, j)
        change, landing = (
            load_joint_wrench_or_velocity_change(joint_rows, j),
            load_flat_landing_times_and_point_heights(joint_rows, j),
        )
        old = load_point_state_at_step_start(point_rows, j)
        end, findings, losses, new = point_contact_forces_and_state_at_step_end(
            joint, frame, place, old, (change.force_or_velocity, change.moment_or_angular_velocity),
            HalfStepAndFlatLandingConditionsOfPoint(
                load_clock_within_sample(case_rows, j).half_step_length_s, flat_landing_of_stone_is_under_way(landing),
                remaining_landing_time_of_new_contact(joint, landing),
                point_contact_is_deferred(joint, landing, place, old,
                frame.smallest_distance_of_base_corners_inside_rim),
                landing.shortest_remaining_impact_time_in_flat_landing < LANDING_TIME_PLACEHOLDER_WITHOUT_POINTS_S,
            ),
        )  # fmt: skip
        store_point_state_at_step_end(point_rows, j, new)
        store_joint_force_and_impulse_sums(
            joint_rows,
            j,
            add_normal_force_and_early_impulse_sums(load_joint_force_and_impulse_sums(joint_rows, j), end),
        )
        store_largest_contact_changes(
            case_rows, j, larger_value_of_each_contact_change(load_largest_contact_changes(case_rows, j), findings)
        )
        store_power_loss_and_lost_spring_energy(
            case_rows, j, add_energy_losses(load_power_loss_and_lost_spring_energy(case_rows, j), losses)
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def add_force_times_pressure_centre_distance(joint_rows: Any, point_rows: Any, lane_count: int) -> None:
    """Add one contact point's normal force × distance from the centre of pressure (N·m) to the contact's sum."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        total = load_joint_force_and_impulse_sums(joint_rows, j)
        place = load_point_position(point_rows, j)
        new = load_point_state_at_step_end(point_rows, j)
        one = 1.0 / (total.normal_force if total.normal_force > 0.0 else 1.0)
        x = place.x_in_lower_face_frame - total.normal_force_times_x * one
        y = place.y_in_lower_face_frame - total.normal_force_times_y * one
        arm = (
            load_force_times_pressure_centre_distance(joint_rows, j).force_times_distance_from_pressure_centre
            + place.joint_stiffness_share * new.force_per_stiffness_share * math.sqrt(x * x + y * y)
        )
        store_force_times_pressure_centre_distance(joint_rows, j, SumOfForceTimesDistanceToPressureCentre(arm))


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def compute_joint_forces_and_add_to_stones(
    case_rows: Any,
    upper_stone_rows: Any,
    lower_stone_rows: Any,
    joint_rows: Any,
    lane_count: int,
    marker_if_support_is_ground_else_none: Any,
) -> None:
    """Compute force, moment and new state of a stone's contact with its support; add the force to both stones' sums."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        change = load_joint_wrench_or_velocity_change(joint_rows, j)
        flat = flat_landing_of_stone_is_under_way(load_flat_landing_times_and_point_heights(joint_rows, j))
        fine = step_is_short_enough_for_predicted_forces(
            load_step_lengths_and_doubling_counts(case_rows, j), load_next_step_to_attempt(case_rows, j)
        )
        at_end, early, findings, losses, new = joint_contact_forces_and_state_at_step_end(
            load_joint_constants(joint_rows, j),
            load_relative_motion(joint_rows, j),
            load_assumed_joint_friction_state(joint_rows, j),
            (
                load_joint_force_and_impulse_sums(joint_rows, j),
                load_force_times_pressure_centre_distance(joint_rows, j).force_times_distance_from_pressure_centre,
            ),
            (change.force_or_velocity, change.moment_or_angular_velocity),
            load_joint_state_at_step_start(joint_rows, j),
            JointFrictionSolutionInputs(
                load_clock_within_sample(case_rows, j).half_step_length_s,
                fine,
                flat,
                load_stone_constants(upper_stone_rows, j).centre_height,
            ),
        )
        store_joint_state_at_step_end(joint_rows, j, new)
        store_largest_contact_changes(
            case_rows, j, larger_value_of_each_contact_change(load_largest_contact_changes(case_rows, j), findings)
        )
        store_power_loss_and_lost_spring_energy(
            case_rows, j, add_energy_losses(load_power_loss_and_lost_spring_energy(case_rows, j), losses)
        )
        stone, total = load_predicted_stone(upper_stone_rows, j), load_force_sums(upper_stone_rows, j)
        if marker_if_support_is_ground_else_none is None:
            below, (axes, origin) = load_predicted_stone(lower_stone_rows, j), load_joint_frame(joint_rows, j)
            at_end = ForceAndMomentOrVelocities(
                matrix_times_vector(axes, at_end.force_or_velocity),
                matrix_times_vector(axes, at_end.moment_or_angular_velocity),
            )
            early = ForceAndMomentOrVelocities(
                matrix_times_vector(axes, early.force_or_velocity),
                matrix_times_vector(axes, early.moment_or_angular_velocity),
            )
            arm, other = minus(origin, below.centre_position), load_force_sums(lower_stone_rows, j)
            store_force_sums(lower_stone_rows, j, StoneContactForceSums(
                subtract_wrenches_or_velocities(other.force_and_moment_at_step_end, shift_wrench_to_stone_centre(at_end,
                arm)),
                subtract_wrenches_or_velocities(other.extra_impulses_of_early_contacts,
                shift_wrench_to_stone_centre(early, arm)),
            ))  # fmt: skip
        else:
            origin = Vector3(0.0, 0.0, 0.0)
        arm = minus(origin, stone.centre_position)
        store_force_sums(upper_stone_rows, j, StoneContactForceSums(
            add_wrenches_or_velocities(total.force_and_moment_at_step_end, shift_wrench_to_stone_centre(at_end, arm)),
            add_wrenches_or_velocities(total.extra_impulses_of_early_contacts, shift_wrench_to_stone_centre(early,
            arm)),
        ))  # fmt: skip


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def mark_joints_bearing_on_non_corner_point(joint_rows: Any, point_rows: Any, lane_count: int) -> None:
    """Mark contacts of two stones where a given point, no corner of the upper base, has a share of the stiffness.

    The upper base then extends beyond the rim of the face below.
    """
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        joint_rows[USES_NON_CORNER_AT_STEP_END_ROW_OFFSET + j] = select(
            point_rows[STIFFNESS_SHARE_IN_ATTEMPTED_STEP_ROW_OFFSET + j] > 0.0,
            1.0,
            joint_rows[USES_NON_CORNER_AT_STEP_END_ROW_OFFSET + j],
        )
