"""Step of the centred scheme for the stacks in all lanes: order of the loops over stones, joints and points."""

from typing import Any

from numba import njit

from overturning.dem.kernel.lanes import INTERNAL_COMPILE_OPTIONS
from overturning.dem.stack.acceptance_loops import (
    decide_step_acceptance_and_advance_clock,
    store_joint_states_after_accepted_steps,
    store_stone_and_add_work_if_step_accepted,
    update_contact_point_states_after_attempted_steps,
)
from overturning.dem.stack.access import (
    VALUE_COUNT_PER_CASE_IN_ALL_LANES,
    VALUE_COUNT_PER_JOINT_IN_ALL_LANES,
    VALUE_COUNT_PER_POINT_IN_ALL_LANES,
    VALUE_COUNT_PER_STONE_IN_ALL_LANES,
    slice_stone_rows,
)
from overturning.dem.stack.clip import (
    clip_base_sides_and_add_patch_perimeter,
    clip_lower_sides_and_add_lengths_to_perimeter,
    slice_contact_point_rows,
)
from overturning.dem.stack.end_loops import (
    add_force_times_pressure_centre_distance,
    compute_joint_forces_and_add_to_stones,
    mark_joints_bearing_on_non_corner_point,
    store_joint_velocity_change_and_clear_sums,
    store_point_state_and_add_normal_force_to_joint,
)
from overturning.dem.stack.patch import (
    any_stack_uses_contact_point,
    place_partial_patch_points_with_stiffness,
    predict_base_corner_positions,
    update_corner_rim_distance_and_check_full_support,
)
from overturning.dem.stack.predict_loops import (
    back_substitute_upper_stone_velocity_corrections,
    eliminate_upper_stone_of_each_stack,
    include_point_in_joint_landing_times_and_heights,
    predict_joint_friction_and_equations,
    predict_normal_force_and_add_to_joint_sums,
    predict_stone_motion_and_equations,
    reset_landing_extremes_and_normal_force_sums,
    rotate_joint_equations_to_ground_axes,
    solve_velocity_corrections_of_lowest_stones,
    start_step_and_predict_inertial_acceleration,
)
from overturning.dem.stack.relative_motion import (
    predict_lowest_stone_motion_relative_to_ground,
    predict_motion_relative_to_stone_below,
)
from overturning.dem.stack.rim import (
    express_point_in_mean_normal_frame,
    rotate_contact_frame_and_motion_to_mean_normal,
    sum_contact_loads_positions_and_normals,
)


@njit(**INTERNAL_COMPILE_OPTIONS)
def state_array_length_per_joint(max_corner_count_per_face: int) -> int:
    """Return the number of values in the state array for one contact of two stones, in all columns (lanes)."""
    return VALUE_COUNT_PER_JOINT_IN_ALL_LANES + 6 * max_corner_count_per_face * VALUE_COUNT_PER_POINT_IN_ALL_LANES


@njit(**INTERNAL_COMPILE_OPTIONS)
def predict_contact_points_and_patch_forces(
    case_rows: Any,
    upper_stone_rows: Any,
    lower_stone_rows: Any,
    joint_rows: Any,
    joint_point_rows: Any,
    base_and_lower_face_corner_counts: tuple[int, int],
    used_point_count_and_indices_of_joint: Any,
    lane_count: int,
) -> None:
    """Compute the contact points of two stones at the predicted step end, and sum their predicted forces.

    `base_and_lower_face_corner_counts` holds the numbers of corners of the base and of the lower face (0 on the
    ground). `used_point_count_and_indices_of_joint` receives the number of points that have a share of stiffness in any
    stack, followed by the indices of these points.
    """
    upper_count, lower_count = base_and_lower_face_corner_counts
    predict_base_corner_positions(upper_stone_rows, joint_rows, joint_point_rows, upper_count, lane_count)
    for i in range(upper_count):
        used_point_count_and_indices_of_joint[1 + i] = i
    count = upper_count
    if lower_count > 0 and not update_corner_rim_distance_and_check_full_support(
        joint_rows, joint_point_rows, upper_count, lower_count, lane_count
    ):
        clip_base_sides_and_add_patch_perimeter(joint_rows, joint_point_rows, upper_count, lower_count, lane_count)
        clip_lower_sides_and_add_lengths_to_perimeter(
            joint_rows, joint_point_rows, upper_count, lower_count, lane_count
        )
        place_partial_patch_points_with_stiffness(joint_rows, joint_point_rows, upper_count, lower_count, lane_count)
        sum_contact_loads_positions_and_normals(
            upper_stone_rows, joint_rows, joint_point_rows, upper_count, lower_count, lane_count
        )
        rotate_contact_frame_and_motion_to_mean_normal(upper_stone_rows, lower_stone_rows, joint_rows, lane_count)
        for i in range(upper_count, 3 * (upper_count + lower_count)):
            used_point_count_and_indices_of_joint[1 + count] = i
            count += 1 if any_stack_uses_contact_point(slice_contact_point_rows(joint_point_rows, i), lane_count) else 0
        for n in range(count):
            express_point_in_mean_normal_frame(
                joint_rows,
                slice_contact_point_rows(joint_point_rows, used_point_count_and_indices_of_joint[1 + n]),
                lane_count,
            )
    used_point_count_and_indices_of_joint[0] = count
    reset_landing_extremes_and_normal_force_sums(joint_rows, lane_count)
    for n in range(count):
        include_point_in_joint_landing_times_and_heights(
            joint_rows,
            slice_contact_point_rows(joint_point_rows, used_point_count_and_indices_of_joint[1 + n]),
            lane_count,
        )
    for n in range(count):
        predict_normal_force_and_add_to_joint_sums(
            case_rows,
            joint_rows,
            slice_contact_point_rows(joint_point_rows, used_point_count_and_indices_of_joint[1 + n]),
            lane_count,
        )
    predict_joint_friction_and_equations(case_rows, upper_stone_rows, joint_rows, lane_count)


@njit(**INTERNAL_COMPILE_OPTIONS)
def apply_solved_contact_patch_forces_to_stones(
    case_rows: Any,
    upper_stone_rows: Any,
    lower_stone_rows: Any,
    joint_rows: Any,
    joint_point_rows: Any,
    used_point_count_and_indices_of_joint: Any,
    lane_count: int,
    marker_if_support_is_ground_else_none: Any,
) -> None:
    """Compute the contact forces of two stones at the end of the step, from the solved equations."""
    store_joint_velocity_change_and_clear_sums(
        upper_stone_rows, lower_stone_rows, joint_rows, lane_count, marker_if_support_is_ground_else_none
    )
    for n in range(used_point_count_and_indices_of_joint[0]):
        store_point_state_and_add_normal_force_to_joint(
            case_rows,
            joint_rows,
            slice_contact_point_rows(joint_point_rows, used_point_count_and_indices_of_joint[1 + n]),
            lane_count,
        )
    for n in range(used_point_count_and_indices_of_joint[0]):
        add_force_times_pressure_centre_distance(
            joint_rows,
            slice_contact_point_rows(joint_point_rows, used_point_count_and_indices_of_joint[1 + n]),
            lane_count,
        )
    compute_joint_forces_and_add_to_stones(
        case_rows, upper_stone_rows, lower_stone_rows, joint_rows, lane_count, marker_if_support_is_ground_else_none
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def store_accepted_stack_states(
    stack_states: Any,
    stone_count: int,
    state_array_length_per_joint: int,
    used_point_count_and_indices_of_joint: Any,
    lane_count: int,
) -> None:
    """Store the new states of stones, contacts and contact points in the stacks whose step is accepted."""
    case, first = (
        stack_states[:VALUE_COUNT_PER_CASE_IN_ALL_LANES],
        VALUE_COUNT_PER_CASE_IN_ALL_LANES + stone_count * VALUE_COUNT_PER_STONE_IN_ALL_LANES,
    )
    for s in range(stone_count):
        stone = slice_stone_rows(stack_states, s)
        if s == 0:
            store_stone_and_add_work_if_step_accepted(case, stone, lane_count, 1)
        else:
            store_stone_and_add_work_if_step_accepted(case, stone, lane_count, None)
        at = first + s * state_array_length_per_joint
        store_joint_states_after_accepted_steps(
            case, stack_states[at : at + VALUE_COUNT_PER_JOINT_IN_ALL_LANES], lane_count
        )
        points = stack_states[at + VALUE_COUNT_PER_JOINT_IN_ALL_LANES : at + state_array_length_per_joint]
        for n in range(used_point_count_and_indices_of_joint[s, 0]):
            update_contact_point_states_after_attempted_steps(
                case, slice_contact_point_rows(points, used_point_count_and_indices_of_joint[s, 1 + n]), lane_count
            )


@njit(**INTERNAL_COMPILE_OPTIONS)
def attempt_time_steps_of_stacks(
    stack_states: Any,
    stone_count: int,
    max_corner_count_per_face: int,
    corner_count_by_stone: Any,
    used_point_count_and_indices_of_joint: Any,
    lane_count: int,
    attempted_step_count: int,
    ticks_per_sample: float,
) -> None:
    """Attempt `attempted_step_count` time steps of all stacks.

    `used_point_count_and_indices_of_joint` is a work array.
    """
    case = stack_states[:VALUE_COUNT_PER_CASE_IN_ALL_LANES]
    first, size = (
        VALUE_COUNT_PER_CASE_IN_ALL_LANES + stone_count * VALUE_COUNT_PER_STONE_IN_ALL_LANES,
        state_array_length_per_joint(max_corner_count_per_face),
    )
    for _ in range(attempted_step_count):
        start_step_and_predict_inertial_acceleration(case, lane_count, ticks_per_sample)
        for s in range(stone_count):
            stone = slice_stone_rows(stack_states, s)
            predict_stone_motion_and_equations(case, stone, lane_count)
        for s in range(stone_count):
            stone = slice_stone_rows(stack_states, s)
            at = first + s * size
            joint = stack_states[at : at + VALUE_COUNT_PER_JOINT_IN_ALL_LANES]
            points = stack_states[at + VALUE_COUNT_PER_JOINT_IN_ALL_LANES : at + size]
            if s == 0:
                predict_lowest_stone_motion_relative_to_ground(stone, joint, lane_count)
                predict_contact_points_and_patch_forces(
                    case,
                    stone,
                    stone,
                    joint,
                    points,
                    (int(corner_count_by_stone[s]), 0),
                    used_point_count_and_indices_of_joint[s],
                    lane_count,
                )
            else:
                lower = slice_stone_rows(stack_states, s - 1)
                predict_motion_relative_to_stone_below(stone, lower, joint, lane_count)
                both = (int(corner_count_by_stone[s]), int(corner_count_by_stone[s - 1]))
                predict_contact_points_and_patch_forces(
                    case, stone, lower, joint, points, both, used_point_count_and_indices_of_joint[s], lane_count
                )
                rotate_joint_equations_to_ground_axes(joint, lane_count)
        for s in range(stone_count - 1, 0, -1):
            stone = slice_stone_rows(stack_states, s)
            lower = slice_stone_rows(stack_states, s - 1)
            eliminate_upper_stone_of_each_stack(
                case,
                stone,
                lower,
                stack_states[first + s * size : first + s * size + VALUE_COUNT_PER_JOINT_IN_ALL_LANES],
                lane_count,
            )
        solve_velocity_corrections_of_lowest_stones(
            case,
            slice_stone_rows(stack_states, 0),
            stack_states[first : first + VALUE_COUNT_PER_JOINT_IN_ALL_LANES],
            lane_count,
        )
        for s in range(1, stone_count):
            stone = slice_stone_rows(stack_states, s)
            back_substitute_upper_stone_velocity_corrections(stone, slice_stone_rows(stack_states, s - 1), lane_count)
        for s in range(stone_count):
            stone = slice_stone_rows(stack_states, s)
            at = first + s * size
            joint = stack_states[at : at + VALUE_COUNT_PER_JOINT_IN_ALL_LANES]
            points = stack_states[at + VALUE_COUNT_PER_JOINT_IN_ALL_LANES : at + size]
            if s == 0:
                apply_solved_contact_patch_forces_to_stones(
                    case, stone, stone, joint, points, used_point_count_and_indices_of_joint[s], lane_count, 1
                )
            else:
                lower = slice_stone_rows(stack_states, s - 1)
                apply_solved_contact_patch_forces_to_stones(
                    case, stone, lower, joint, points, used_point_count_and_indices_of_joint[s], lane_count, None
                )
                for n in range(corner_count_by_stone[s], used_point_count_and_indices_of_joint[s, 0]):
                    mark_joints_bearing_on_non_corner_point(
                        joint,
                        slice_contact_point_rows(points, used_point_count_and_indices_of_joint[s, 1 + n]),
                        lane_count,
                    )
        decide_step_acceptance_and_advance_clock(case, lane_count, ticks_per_sample)
        store_accepted_stack_states(stack_states, stone_count, size, used_point_count_and_indices_of_joint, lane_count)
