"""Step of the centred scheme for the stacks in all lanes: order of the loops over stones, joints and points."""

from typing import Any

from numba import njit

from overturning.dem.kernel.lanes import INNER
from overturning.dem.stack.end_loops import (
    accept_or_reject_steps,
    add_point_to_pressure_arm_sum,
    complete_stone_step,
    compute_joint_wrench,
    compute_point_normal_force,
    mark_joints_with_crossing_points,
    store_accepted_joint_histories,
    store_accepted_point_histories,
    store_relative_velocity_changes,
)
from overturning.dem.stack.joint_state import JOINT, POINT
from overturning.dem.stack.patch import (
    any_lane_uses_point,
    clip_lower_sides,
    clip_upper_sides,
    patch_is_whole,
    place_corners,
    place_crossings,
    point_window,
    predict_ground_frame,
    predict_relative_frame,
)
from overturning.dem.stack.predict_loops import (
    add_point_landing,
    begin_joint,
    eliminate_stones,
    predict_base,
    predict_joint,
    predict_point,
    predict_stones,
    rotate_joint,
    solve_lowest_stones,
    substitute_stones,
)
from overturning.dem.stack.state import CASE, STONE

CASE_SIZE, STONE_SIZE, JOINT_SIZE, P = CASE.size, STONE.size, JOINT.size, POINT.size


@njit(**INNER)
def joint_size(corner_limit: int) -> int:
    """Return the length of the state array of a joint and its points; faces have at most `corner_limit` corners."""
    return JOINT_SIZE + 6 * corner_limit * P


@njit(**INNER)
def predict_patch(
    case_rows: Any, upper: Any, joint: Any, points: Any, corners: tuple[int, int], used: Any, lane_count: int
) -> None:
    """Compute the contact points of a joint at the predicted step end, and sum their predicted forces.

    `corners` holds the numbers of corners of the base and of the lower face (0 on the ground). The numbers of the
    points that have weight in any lane are written to `used`, after their count.
    """
    upper_count, lower_count = corners
    place_corners(upper, joint, points, upper_count, lane_count)
    for i in range(upper_count):
        used[1 + i] = i
    count = upper_count
    if lower_count > 0 and not patch_is_whole(joint, points, upper_count, lower_count, lane_count):
        clip_upper_sides(joint, points, upper_count, lower_count, lane_count)
        clip_lower_sides(joint, points, upper_count, lower_count, lane_count)
        place_crossings(joint, points, upper_count, lower_count, lane_count)
        for i in range(upper_count, 3 * (upper_count + lower_count)):
            used[1 + count] = i
            count += 1 if any_lane_uses_point(point_window(points, i), lane_count) else 0
    used[0] = count
    begin_joint(joint, lane_count)
    for n in range(count):
        add_point_landing(joint, point_window(points, used[1 + n]), lane_count)
    for n in range(count):
        predict_point(case_rows, joint, point_window(points, used[1 + n]), lane_count)
    predict_joint(case_rows, upper, joint, lane_count)


@njit(**INNER)
def end_patch(
    case_rows: Any, upper: Any, lower: Any, joint: Any, points: Any, used: Any, lane_count: int, on_ground: Any
) -> None:
    """Compute the contact forces of a joint at the solved end of the step, after `predict_patch`."""
    store_relative_velocity_changes(upper, lower, joint, lane_count, on_ground)
    for n in range(used[0]):
        compute_point_normal_force(case_rows, joint, point_window(points, used[1 + n]), lane_count)
    for n in range(used[0]):
        add_point_to_pressure_arm_sum(joint, point_window(points, used[1 + n]), lane_count)
    compute_joint_wrench(case_rows, upper, lower, joint, lane_count, on_ground)


@njit(**INNER)
def complete_stacks(state: Any, stone_count: int, size: int, used: Any, lane_count: int) -> None:
    """Store the new states of stones, joints and points after accepted steps; a joint has `size` values."""
    case, first = state[:CASE_SIZE], CASE_SIZE + stone_count * STONE_SIZE
    for s in range(stone_count):
        stone = state[CASE_SIZE + s * STONE_SIZE : CASE_SIZE + (s + 1) * STONE_SIZE]
        if s == 0:
            complete_stone_step(case, stone, lane_count, 1)
        else:
            complete_stone_step(case, stone, lane_count, None)
        at = first + s * size
        store_accepted_joint_histories(case, state[at : at + JOINT_SIZE], lane_count)
        points = state[at + JOINT_SIZE : at + size]
        for n in range(used[s, 0]):
            store_accepted_point_histories(case, point_window(points, used[s, 1 + n]), lane_count)


@njit(**INNER)
def advance_stacks(
    state: Any,
    stone_count: int,
    corner_limit: int,
    corners: Any,
    used: Any,
    lane_count: int,
    steps: int,
    ticks: float,
) -> None:
    """Attempt `steps` time steps of all stacks; `corners`: corners per stone's faces, `used`: work array."""
    case = state[:CASE_SIZE]
    first, size = CASE_SIZE + stone_count * STONE_SIZE, joint_size(corner_limit)
    for _ in range(steps):
        predict_base(case, lane_count, ticks)
        for s in range(stone_count):
            stone = state[CASE_SIZE + s * STONE_SIZE : CASE_SIZE + (s + 1) * STONE_SIZE]
            predict_stones(case, stone, lane_count)
        for s in range(stone_count):
            stone = state[CASE_SIZE + s * STONE_SIZE : CASE_SIZE + (s + 1) * STONE_SIZE]
            at = first + s * size
            joint, points = state[at : at + JOINT_SIZE], state[at + JOINT_SIZE : at + size]
            if s == 0:
                predict_ground_frame(stone, joint, lane_count)
                predict_patch(case, stone, joint, points, (int(corners[s]), 0), used[s], lane_count)
            else:
                lower = state[CASE_SIZE + (s - 1) * STONE_SIZE : CASE_SIZE + s * STONE_SIZE]
                predict_relative_frame(stone, lower, joint, lane_count)
                both = (int(corners[s]), int(corners[s - 1]))
                predict_patch(case, stone, joint, points, both, used[s], lane_count)
                rotate_joint(lower, joint, lane_count)
        for s in range(stone_count - 1, 0, -1):
            stone = state[CASE_SIZE + s * STONE_SIZE : CASE_SIZE + (s + 1) * STONE_SIZE]
            lower = state[CASE_SIZE + (s - 1) * STONE_SIZE : CASE_SIZE + s * STONE_SIZE]
            eliminate_stones(case, stone, lower, state[first + s * size : first + s * size + JOINT_SIZE], lane_count)
        solve_lowest_stones(
            case, state[CASE_SIZE : CASE_SIZE + STONE_SIZE], state[first : first + JOINT_SIZE], lane_count
        )
        for s in range(1, stone_count):
            stone = state[CASE_SIZE + s * STONE_SIZE : CASE_SIZE + (s + 1) * STONE_SIZE]
            substitute_stones(stone, state[CASE_SIZE + (s - 1) * STONE_SIZE : CASE_SIZE + s * STONE_SIZE], lane_count)
        for s in range(stone_count):
            stone = state[CASE_SIZE + s * STONE_SIZE : CASE_SIZE + (s + 1) * STONE_SIZE]
            at = first + s * size
            joint, points = state[at : at + JOINT_SIZE], state[at + JOINT_SIZE : at + size]
            if s == 0:
                end_patch(case, stone, stone, joint, points, used[s], lane_count, 1)
            else:
                lower = state[CASE_SIZE + (s - 1) * STONE_SIZE : CASE_SIZE + s * STONE_SIZE]
                end_patch(case, stone, lower, joint, points, used[s], lane_count, None)
                for n in range(corners[s], used[s, 0]):
                    mark_joints_with_crossing_points(joint, point_window(points, used[s, 1 + n]), lane_count)
        accept_or_reject_steps(case, lane_count, ticks)
        complete_stacks(state, stone_count, size, used, lane_count)
