"""Functions that the queue of cases calls for 3-D stacks: start a case, compute a sample, end a case."""

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.body.rotation import inertial_accelerations_until_next_sample
from overturning.dem.body.state import LoadedBaseMotionSampleNumber
from overturning.dem.body.vectors import renormalise_nearly_unit_quaternion
from overturning.dem.kernel.ending import CaseProgress, continuation_sample_tick_and_last_upright_time
from overturning.dem.kernel.ground import (
    BaseAccelerationsAndMaximaInWindowAhead,
    count_skippable_samples,
    is_rest_check_sample,
    next_window_motion_is_below_rest_limit,
)
from overturning.dem.kernel.lanes import (
    INTERNAL_COMPILE_OPTIONS,
    assume_lane_count_is_multiple_of_8,
    cache_line_aligned_zeros,
)
from overturning.dem.kernel.queue import (
    SettingsCommonToParallelCases,
    grow_trajectory_array_if_needed,
    register_model_functions,
)
from overturning.dem.stack.access import (
    VALUE_COUNT_PER_CASE_IN_ALL_LANES,
    VALUE_COUNT_PER_STONE_IN_ALL_LANES,
    load_case_progress,
    load_fall_flags_and_last_upright_time,
    load_rest_flag_and_acceleration_limits,
    load_stone_state,
    slice_stone_rows,
    store_inertial_and_upward_base_accelerations,
    store_rotation,
)
from overturning.dem.stack.ending import (
    end_simulation_of_fallen_stones_and_return_status,
    lowest_newly_fallen_stone_index,
    write_stack_results,
)
from overturning.dem.stack.energy import stone_state_sum_for_finite_check
from overturning.dem.stack.path import write_stack_trajectory_row
from overturning.dem.stack.rest import (
    MAY_BE_AT_REST_ROW_OFFSET,
    mark_possibly_resting_stacks,
    rest_acceleration_limit_g_or_0_if_moving,
)
from overturning.dem.stack.start import write_stack_constants_and_initial_state
from overturning.dem.stack.state import (
    CASE_ROW_LAYOUT,
    STONE_ROW_LAYOUT,
    StackClockWithinSample,
    StoneFallState,
    StonePeakLeanAndLastUprightTick,
)
from overturning.dem.stack.step import attempt_time_steps_of_stacks, state_array_length_per_joint

(
    TICKS_SINCE_SAMPLE_START_ROW_OFFSET,
    CURRENT_SAMPLE_ROW_OFFSET,
    INITIAL_ENERGY_ROW_OFFSET,
    LOADED_SAMPLE_NUMBER_ROW_OFFSET,
) = (
    CASE_ROW_LAYOUT.row_offset_of_field(StackClockWithinSample, "ticks_since_sample_start"),
    CASE_ROW_LAYOUT.row_offset_of_field(CaseProgress, "current_sample"),
    CASE_ROW_LAYOUT.row_offset_of_field(CaseProgress, "initial_energy"),
    CASE_ROW_LAYOUT.row_offset_of_field(LoadedBaseMotionSampleNumber, "one_based_sample_number_or_zero"),
)
LAST_UPRIGHT_TICK_OF_SAMPLE_ROW_OFFSET = STONE_ROW_LAYOUT.row_offset_of_field(
    StonePeakLeanAndLastUprightTick, "last_upright_tick_in_sample"
)
LAST_UPRIGHT_TIME_ROW_OFFSET = STONE_ROW_LAYOUT.row_offset_of_field(StoneFallState, "last_upright_time_s")


class StackKernelInput(NamedTuple):
    """Input of the stack kernel, for cases with equal steps per sample and equal numbers of stones and corners."""

    settings: SettingsCommonToParallelCases
    cases: NDArray[np.void]
    """Case parameters, of type `CASE_TABLE_DTYPE`, shape (n,)."""
    motion_row_by_case: NDArray[np.int64]
    results: NDArray[np.void]
    """Results to fill in, of type `RESULT_TABLE_DTYPE`, shape (n,)."""
    stone_results: NDArray[np.void]
    """Results of each stone to fill in, of type `STONE_RESULT_TABLE_DTYPE`, shape (n, stones)."""
    ground_motion: BaseAccelerationsAndMaximaInWindowAhead
    friction_by_case_and_joint: FloatArray
    """Coefficient of friction of each joint, shape (n, stones)."""
    stone_table_by_stack: NDArray[np.void]
    """Constants and initial state of the stones of each stack, of type `STONE_TABLE_DTYPE`, shape (stacks, stones)."""
    joint_table_by_stack: NDArray[np.void]
    """Contact constants of the joint below each stone, of type `JOINT_TABLE_DTYPE`, shape (stacks, stones)."""
    corner_counts_by_stone: NDArray[np.int64]
    """Number of corners of each stone's faces, shape (stones,)."""
    base_and_upper_face_corners_by_stack: FloatArray
    """Corners of each stone's base and upper face, shape (stacks, stones, 2, corners, 6): fields of `FaceCorner`."""


class ParallelStacksStateArrays(NamedTuple):
    """Working arrays of the stack kernel: states of the cases, and indices of the contact points in use."""

    state: Any
    used_point_count_and_indices_of_joint: Any


def allocate_workspace(kernel_input: Any) -> Any:
    """Allocate the state arrays of the stacks that are simulated in parallel, one column (lane) each."""
    stones, corners = (
        kernel_input.base_and_upper_face_corners_by_stack.shape[1],
        kernel_input.base_and_upper_face_corners_by_stack.shape[3],
    )
    size = VALUE_COUNT_PER_CASE_IN_ALL_LANES + stones * (
        VALUE_COUNT_PER_STONE_IN_ALL_LANES + state_array_length_per_joint(corners)
    )
    return ParallelStacksStateArrays(cache_line_aligned_zeros(size), np.zeros((stones, 1 + 6 * corners), np.int64))


def start_case(kernel_input: Any, workspace: Any, lane: int, case_index: int) -> None:
    """Load the initial state of case number `case_index`, a stack at rest, into column `lane` of the state array."""
    given, settings = kernel_input.cases[case_index], kernel_input.settings
    write_stack_constants_and_initial_state(
        workspace.state,
        lane,
        given,
        (kernel_input.stone_table_by_stack[given.stack], kernel_input.joint_table_by_stack[given.stack]),
        kernel_input.friction_by_case_and_joint[case_index],
        kernel_input.base_and_upper_face_corners_by_stack[given.stack],
        kernel_input.corner_counts_by_stone,
        (settings.sampling_interval, settings.ticks_per_sample),
    )


def update_sample_and_load_motion(kernel_input: Any, workspace: Any, case_index_by_lane: Any, lane_count: int) -> None:
    """Advance each stack to its current sample, load its base motion, and rescale all quaternions to length 1."""
    advance_sample_and_load_base_motion(
        workspace.state, kernel_input.corner_counts_by_stone.size, lane_count, kernel_input.motion_row_by_case,
        case_index_by_lane, kernel_input.ground_motion, kernel_input.settings,
    )  # fmt: skip


@njit(**INTERNAL_COMPILE_OPTIONS)
def advance_sample_and_load_base_motion(
    stack_states: Any,
    stone_count: int,
    lane_count: int,
    motion_row_by_case: Any,
    case_index_by_lane: Any,
    ground_motion: Any,
    queue_settings: SettingsCommonToParallelCases,
) -> None:
    """Advance each stack to its current sample, load its base motion, and rescale all quaternions to length 1.

    The time at which each stone was last upright is stored too.
    """
    along, up, ticks, interval, scale = (
        ground_motion.horizontal_acceleration, ground_motion.upward_acceleration, queue_settings.ticks_per_sample,
        queue_settings.sampling_interval, 1.0 / queue_settings.ticks_per_sample,
    )  # fmt: skip
    for s in range(stone_count):
        rows = slice_stone_rows(stack_states, s)
        for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
            store_rotation(rows, j, renormalise_nearly_unit_quaternion(load_stone_state(rows, j).rotation))
            then = (
                load_case_progress(stack_states, j).current_sample
                + rows[LAST_UPRIGHT_TICK_OF_SAMPLE_ROW_OFFSET + j] * scale
            ) * interval
            present = load_fall_flags_and_last_upright_time(rows, j).is_still_simulated > 0.0
            rows[LAST_UPRIGHT_TIME_ROW_OFFSET + j] = (
                then
                if (rows[LAST_UPRIGHT_TICK_OF_SAMPLE_ROW_OFFSET + j] >= 0.0) & present
                else rows[LAST_UPRIGHT_TIME_ROW_OFFSET + j]
            )
            rows[LAST_UPRIGHT_TICK_OF_SAMPLE_ROW_OFFSET + j] = -1.0
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        # The times at which the stones were upright are their own, above.
        begun = continuation_sample_tick_and_last_upright_time(
            load_case_progress(stack_states, j),
            stack_states[TICKS_SINCE_SAMPLE_START_ROW_OFFSET + j],
            -1.0,
            ticks,
            interval,
        )
        stack_states[CURRENT_SAMPLE_ROW_OFFSET + j], stack_states[TICKS_SINCE_SAMPLE_START_ROW_OFFSET + j] = (
            begun[0],
            begun[1],
        )
    last = up.shape[0] - 3
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        course = load_case_progress(stack_states, j)
        if stack_states[LOADED_SAMPLE_NUMBER_ROW_OFFSET + j] == course.current_sample + 1.0:
            continue
        stack_states[LOADED_SAMPLE_NUMBER_ROW_OFFSET + j] = course.current_sample + 1.0
        i = min(int(course.current_sample), last)
        horizontal = along[motion_row_by_case[case_index_by_lane[j]]]
        store_inertial_and_upward_base_accelerations(
            stack_states, j, inertial_accelerations_until_next_sample(horizontal, up, i, course.amplitude_factor, scale)
        )


def attempt_steps_until_next_check(
    kernel_input: Any, workspace: Any, lane_count: int, trajectory_buffer: Any, recorded_row_count: int
) -> tuple[Any, int]:
    """Attempt time steps of all stacks until the next end test; record the first stack at most once per sample.

    Return the trajectory buffer and its number of recorded rows; −1, without steps, if the buffer must not grow.
    """
    settings, interval = kernel_input.settings, kernel_input.settings.sampling_interval
    corners = kernel_input.corner_counts_by_stone
    limit = kernel_input.base_and_upper_face_corners_by_stack.shape[3]
    stones = kernel_input.corner_counts_by_stone.size
    if trajectory_buffer.shape[0] > 0:
        most_rows = settings.max_trajectory_rows // trajectory_buffer.shape[1]
        trajectory_buffer = grow_trajectory_array_if_needed(trajectory_buffer, recorded_row_count + 1, most_rows)
        if trajectory_buffer.shape[0] == recorded_row_count:
            return trajectory_buffer, -1
        write_stack_trajectory_row(
            workspace.state, stones, interval, settings.ticks_per_sample, trajectory_buffer[recorded_row_count]
        )
        due = trajectory_buffer[recorded_row_count - 1, 0] + 0.999 * interval if recorded_row_count > 0 else 0.0
        recorded_row_count += 1 if trajectory_buffer[recorded_row_count, 0] >= due else 0
    attempt_time_steps_of_stacks(
        workspace.state, stones, limit, corners, workspace.used_point_count_and_indices_of_joint, lane_count,
        settings.attempted_steps_between_end_checks, settings.ticks_per_sample,
    )  # fmt: skip
    return trajectory_buffer, recorded_row_count


def mark_possibly_ended_cases(
    kernel_input: Any, workspace: Any, active_lane_count: int, possible_end_flag_by_lane_out: Any
) -> int:
    """Mark (flag 1) and count the stacks whose case may have ended or in which a stone may have fallen."""
    return mark_possibly_ended_stacks(
        workspace.state,
        kernel_input.corner_counts_by_stone.size,
        kernel_input.base_and_upper_face_corners_by_stack.shape[3],
        active_lane_count,
        possible_end_flag_by_lane_out,
        kernel_input.settings.ticks_per_sample,
        float(kernel_input.settings.sample_count),
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def mark_possibly_ended_stacks(
    stack_states: Any,
    stone_count: int,
    max_corner_count_per_face: int,
    active_lane_count: int,
    possible_end_flag_by_lane_out: Any,
    ticks_per_sample: float,
    record_sample_count: float,
) -> int:
    """Mark and count stacks with a newly fallen stone, a state not finite, or no later sample that can move them."""
    count = 0
    for j in range(active_lane_count):
        course, total = load_case_progress(stack_states, j), 0.0
        for s in range(stone_count):
            total += stone_state_sum_for_finite_check(load_stone_state(slice_stone_rows(stack_states, s), j))
        sample = course.current_sample + stack_states[TICKS_SINCE_SAMPLE_START_ROW_OFFSET + j] / ticks_per_sample
        due = total - total != 0.0 or sample >= min(course.cannot_start_moving_from_sample, record_sample_count)
        due = (
            due
            or lowest_newly_fallen_stone_index(stack_states, j, stone_count, max_corner_count_per_face) < stone_count
        )
        possible_end_flag_by_lane_out[j] = 1.0 if due else 0.0
        count += 1 if due else 0
    return count


def skip_samples_too_weak_to_move_resting_cases(
    kernel_input: Any,
    workspace: Any,
    case_index_by_lane: Any,
    active_lane_count: int,
    skipped_sample_totals_by_lane_in_place: Any,
) -> None:
    """Skip, for each stack at rest, the samples whose base motion is too weak to move the stack."""
    settings, state, ground = kernel_input.settings, workspace.state, kernel_input.ground_motion
    row = kernel_input.motion_row_by_case
    stones, corners = (
        kernel_input.corner_counts_by_stone.size,
        kernel_input.base_and_upper_face_corners_by_stack.shape[3],
    )
    if mark_possibly_resting_stacks(state, stones, active_lane_count) == 0:
        return
    for j in range(active_lane_count):
        course = load_case_progress(state, j)
        bound = load_rest_flag_and_acceleration_limits(state, j).max_possible_base_acceleration_without_motion_g
        now = course.current_sample + state[TICKS_SINCE_SAMPLE_START_ROW_OFFSET + j] * (1.0 / settings.ticks_per_sample)
        # Test the motion first: testing the stack takes longer.
        if not (state[MAY_BE_AT_REST_ROW_OFFSET + j] > 0.0 and is_rest_check_sample(now)):
            continue
        direction = row[case_index_by_lane[j]]
        if not next_window_motion_is_below_rest_limit(ground, direction, now, course.amplitude_factor, bound):
            continue
        rest_limit = rest_acceleration_limit_g_or_0_if_moving(state, j, stones, corners)
        if rest_limit > 0.0:
            samples = count_skippable_samples(ground, direction, now, course.amplitude_factor, rest_limit)
            state[CURRENT_SAMPLE_ROW_OFFSET + j] += samples
            skipped_sample_totals_by_lane_in_place[j] += samples


def current_case_status(kernel_input: Any, workspace: Any, lane: int, case_index: int) -> int:
    """Stop simulating fallen stones; return the `CaseStatus` of the case in column `lane`."""
    stones, corners = (
        kernel_input.corner_counts_by_stone.size,
        kernel_input.base_and_upper_face_corners_by_stack.shape[3],
    )
    return end_simulation_of_fallen_stones_and_return_status(
        workspace.state, lane, stones, corners, kernel_input.settings.ticks_per_sample,
        float(kernel_input.settings.sample_count),
        kernel_input.stone_table_by_stack[kernel_input.cases[case_index].stack],
    )  # fmt: skip


def write_results_of_ended_case(kernel_input: Any, workspace: Any, lane: int, case_index: int, status: int) -> None:
    """Write the results of case number `case_index`, stored in column `lane`, into the tables of results."""
    stones, corners = (
        kernel_input.corner_counts_by_stone.size,
        kernel_input.base_and_upper_face_corners_by_stack.shape[3],
    )
    write_stack_results(
        workspace.state,
        lane,
        stones,
        corners,
        status,
        kernel_input.stone_table_by_stack[kernel_input.cases[case_index].stack].centre_height_at_rest,
        kernel_input.results[case_index],
        kernel_input.stone_results[case_index],
    )


register_model_functions(
    StackKernelInput, allocate_workspace, start_case, update_sample_and_load_motion, attempt_steps_until_next_check,
    mark_possibly_ended_cases, skip_samples_too_weak_to_move_resting_cases, current_case_status,
    write_results_of_ended_case,
)  # fmt: skip
