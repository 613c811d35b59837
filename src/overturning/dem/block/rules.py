"""Functions that the queue calls for a single block: start a case, compute a sample, skip samples, end a case.

For speed and equal bits, loops over the lanes have no branches, only selections, and use no libm functions. Left and
right corner are summed as one pair, so that mirrored cases are exact. To add a scheme, write a file with a named tuple
of constants, a function in `overturning.dem.block.loops`, and an entry in its
`CONSTANTS_AND_LOOP_CREATOR_BY_SCHEME`.
"""

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from overturning.dem.block.access import (
    AT_REST_AT_SAMPLE_START_ROW_OFFSET,
    CURRENT_SAMPLE_ROW_OFFSET,
    LAST_UPRIGHT_TICK_OF_SAMPLE_ROW_OFFSET,
    LAST_UPRIGHT_TIME_ROW_OFFSET,
    NEXT_STEP_LENGTH_ROW_OFFSET,
    REST_ACCELERATION_LIMIT_ROW_OFFSET,
    ROTATION_COSINE_ROW_OFFSET,
    ROTATION_SINE_ROW_OFFSET,
    STATE_ROW_COUNT,
    TICKS_SINCE_SAMPLE_START_ROW_OFFSET,
    load_block_constants,
    load_block_state,
    load_case_progress,
    load_peaks_and_last_upright_tick,
    load_signed_friction_or_zero_if_sticking,
    store_inertial_acceleration_x,
    store_upward_base_acceleration,
)
from overturning.dem.block.ending import (
    update_late_largest_tilt_and_return_case_status,
    write_block_trajectory_row,
    write_case_results_except_status_and_counters,
)
from overturning.dem.block.loops import select_time_stepping_loop
from overturning.dem.block.start import write_block_constants_and_initial_state
from overturning.dem.block.state import (
    PARALLEL_CASE_COUNT,
    TICKS_PER_WHOLE_STEP,
    BlockConstants,
)
from overturning.dem.kernel.ending import (
    body_is_still,
    case_cannot_have_ended,
    continuation_sample_tick_and_last_upright_time,
)
from overturning.dem.kernel.ground import (
    BaseAccelerationsAndMaximaInWindowAhead,
    count_skippable_samples,
    is_rest_check_sample,
    linear_base_acceleration_of_sample,
)
from overturning.dem.kernel.lanes import (
    INLINE_OPTIONS,
    INTERNAL_COMPILE_OPTIONS,
    assume_lane_count_is_multiple_of_8,
    cache_line_aligned_zeros,
)
from overturning.dem.kernel.mechanics import (
    normalise_cosine_and_sine,
)
from overturning.dem.kernel.queue import (
    SettingsCommonToParallelCases,
    grow_trajectory_array_if_needed,
    register_model_functions,
)


class BlockKernelInput(NamedTuple):
    """Input of the compiled block simulation, for cases with equal numbers of time steps per sample."""

    settings: SettingsCommonToParallelCases
    cases: NDArray[np.void]
    """Case parameters, of type `CASE_TABLE_DTYPE`, shape (n,)."""
    motion_row_by_case: NDArray[np.int64]
    results: NDArray[np.void]
    """Results to fill in, of type `RESULT_TABLE_DTYPE`, shape (n,)."""
    ground_motion: BaseAccelerationsAndMaximaInWindowAhead
    scheme_constants: Any
    """Constants of the scheme, from `overturning.dem.block.loops.CONSTANTS_AND_LOOP_CREATOR_BY_SCHEME`."""
    none_if_all_cases_frictionless: Any
    """None if all cases are frictionless: a kernel without tangential springs is compiled. Otherwise any value."""
    max_penetration_to_half_side_ratio: float
    """Penetration beyond which a case has failed, as a share of the smaller half side."""


class ParallelBlockStates(NamedTuple):
    """State array of the blocks that the kernel computes in parallel, one column (lane) per block."""

    state: Any


def allocate_workspace(kernel_input: Any) -> Any:  # noqa: ARG001, its type selects this function
    """Allocate the array for the states of the blocks that are simulated in parallel, one column (lane) each."""
    return ParallelBlockStates(cache_line_aligned_zeros(STATE_ROW_COUNT * PARALLEL_CASE_COUNT))


def start_case(kernel_input: Any, workspace: Any, lane: int, case: int) -> None:
    """Load a case's block into column `lane` of the state array, in equilibrium on both corners or tilted on one."""
    write_block_constants_and_initial_state(
        workspace.state,
        lane,
        kernel_input.cases[case],
        kernel_input.settings.sampling_interval,
        kernel_input.settings.ticks_per_sample,
    )


def update_sample_and_load_motion(
    kernel_input: Any, workspace: Any, case_index_by_lane: Any, computed_lane_count: int
) -> None:
    """Advance each case to its next sample, load the base motion, and normalise (cos θ, sin θ) of its block."""
    advance_sample_load_motion_and_normalise_rotation(
        workspace.state, computed_lane_count, kernel_input.motion_row_by_case, case_index_by_lane,
        kernel_input.ground_motion.horizontal_acceleration, kernel_input.ground_motion.upward_acceleration,
        kernel_input.settings,
    )  # fmt: skip


@njit(**INTERNAL_COMPILE_OPTIONS)
def advance_sample_load_motion_and_normalise_rotation(
    state: Any,
    computed_lane_count: int,
    motion_row_by_case: Any,
    case_index_by_lane: Any,
    horizontal_acceleration_by_azimuth_m_s2: Any,
    numba_type_of_upward_acceleration: Any,
    settings: SettingsCommonToParallelCases,
) -> None:
    """Advance each case to its next sample, load the base motion, and normalise (cos θ, sin θ) of its block.

    `motion_row_by_case` has the row of `horizontal_acceleration_by_azimuth_m_s2` for each case; the upward
    acceleration, m/s², has a value for each sample.
    """
    across, up = horizontal_acceleration_by_azimuth_m_s2, numba_type_of_upward_acceleration
    ticks, interval, scale = settings.ticks_per_sample, settings.sampling_interval, 1.0 / settings.ticks_per_sample
    for j in range(assume_lane_count_is_multiple_of_8(computed_lane_count)):
        s = load_block_state(state, j)
        state[ROTATION_COSINE_ROW_OFFSET + j], state[ROTATION_SINE_ROW_OFFSET + j] = normalise_cosine_and_sine(
            s.cos, s.sin
        )
        begun = continuation_sample_tick_and_last_upright_time(
            load_case_progress(state, j),
            s.ticks_since_sample_start,
            state[LAST_UPRIGHT_TICK_OF_SAMPLE_ROW_OFFSET + j],
            ticks,
            interval,
        )
        (
            state[CURRENT_SAMPLE_ROW_OFFSET + j],
            state[TICKS_SINCE_SAMPLE_START_ROW_OFFSET + j],
            state[LAST_UPRIGHT_TIME_ROW_OFFSET + j],
        ) = begun
        state[LAST_UPRIGHT_TICK_OF_SAMPLE_ROW_OFFSET + j] = -1.0
    last = across.shape[1] - 3
    for j in range(assume_lane_count_is_multiple_of_8(computed_lane_count)):
        course = load_case_progress(state, j)
        i = min(int(course.current_sample), last)
        # A base that accelerates towards +s pushes the block towards −s.
        store_inertial_acceleration_x(
            state,
            j,
            linear_base_acceleration_of_sample(
                across[motion_row_by_case[case_index_by_lane[j]]], i, -course.amplitude_factor, scale
            ),
        )
        if numba_type_of_upward_acceleration is not None:
            store_upward_base_acceleration(
                state, j, linear_base_acceleration_of_sample(up, i, course.amplitude_factor, scale)
            )


def attempt_steps_until_next_check(
    kernel_input: Any, workspace: Any, computed_lane_count: int, trajectory_of_first_lane: Any, recorded_row_count: int
) -> tuple[Any, int]:
    """Attempt a fixed number of steps of all blocks, until the next test for ended cases; record the first block.

    If `trajectory_of_first_lane` has rows, the motion of the block in the first column is recorded before the first
    step, and whenever this block is at the end of its sample. Returns the trajectory and the number of recorded rows,
    −1 if these would be too many.
    """
    # Unpack the input before the branch: otherwise Numba increments the reference count of every array once per sample.
    settings, scheme, state = kernel_input.settings, kernel_input.scheme_constants, workspace.state
    path = trajectory_of_first_lane
    up, with_friction = (
        kernel_input.ground_motion.upward_acceleration, kernel_input.none_if_all_cases_frictionless,
    )  # fmt: skip
    step, ticks = select_time_stepping_loop(scheme, up, with_friction), settings.ticks_per_sample
    attempted_steps_between_end_checks = settings.attempted_steps_between_end_checks
    stride = attempted_steps_between_end_checks if path.shape[0] == 0 else 1
    if path.shape[0] > 0:
        path = grow_trajectory_array_if_needed(
            path, recorded_row_count + attempted_steps_between_end_checks, settings.max_trajectory_rows
        )
        if path.shape[0] < recorded_row_count + attempted_steps_between_end_checks:
            return path, -1
    for done in range(0, attempted_steps_between_end_checks, stride):
        if path.shape[0] > 0 and (done == 0 or state[TICKS_SINCE_SAMPLE_START_ROW_OFFSET] == ticks):
            write_block_trajectory_row(
                state,
                0,
                scheme.velocity_lag_behind_position_in_steps,
                settings.sampling_interval,
                ticks,
                path[recorded_row_count],
            )
            recorded_row_count += 1
        step((up, with_friction), state, computed_lane_count, stride, ticks)
    return path, recorded_row_count


def mark_possibly_ended_cases(
    kernel_input: Any, workspace: Any, active_lane_count: int, possibly_ended_mark_by_lane_out: Any
) -> int:
    """Mark, by a quick test, the cases that may have ended; return the number of marked cases."""
    return mark_possibly_ended_block_cases(
        workspace.state, active_lane_count, possibly_ended_mark_by_lane_out, kernel_input.settings.ticks_per_sample,
        float(kernel_input.settings.sample_count), kernel_input.max_penetration_to_half_side_ratio,
    )  # fmt: skip


@njit(**INTERNAL_COMPILE_OPTIONS)
def mark_possibly_ended_block_cases(
    state: Any,
    active_lane_count: int,
    possibly_ended_mark_by_lane_out: Any,
    ticks_per_sample: float,
    record_end_sample: float,
    max_penetration_to_half_side_ratio: float,
) -> int:
    """Mark and count cases that may have ended: block fallen, state invalid, or only weak base motion from now on."""
    count = 0
    for j in range(active_lane_count):
        block, s, b = (
            load_block_constants(state, j),
            load_block_state(state, j),
            load_block_constants(state, j).half_width,
        )
        most = max_penetration_to_half_side_ratio * (b if b < block.half_height else block.half_height)
        sound = (s.cos > 0.0) & (load_peaks_and_last_upright_tick(state, j).max_corner_penetration <= most)
        total = (s.centre_vx + s.centre_vz + s.angular_velocity) + (s.centre_x + s.centre_z + s.cos)
        goes_on = case_cannot_have_ended(
            load_case_progress(state, j), s.ticks_since_sample_start, ticks_per_sample, record_end_sample, total, sound
        )
        possibly_ended_mark_by_lane_out[j] = 0.0 if goes_on else 1.0
        count += 0 if goes_on else 1
    return count


def skip_samples_too_weak_to_move_resting_cases(
    kernel_input: Any,
    workspace: Any,
    case_index_by_lane: Any,
    active_lane_count: int,
    skipped_sample_count_by_lane_out: Any,
) -> None:
    """Skip, for blocks at rest, the samples in which the base motion cannot move the block."""
    mark_resting_blocks_and_skip_samples(
        workspace.state, case_index_by_lane, active_lane_count, kernel_input.motion_row_by_case,
        kernel_input.ground_motion, kernel_input.settings.ticks_per_sample, skipped_sample_count_by_lane_out,
    )  # fmt: skip


@njit(**INTERNAL_COMPILE_OPTIONS)
def mark_resting_blocks_and_skip_samples(
    state: Any,
    case_index_by_lane: Any,
    active_lane_count: int,
    motion_row_by_case: Any,
    ground_motion: Any,
    ticks_per_sample: float,
    skipped_sample_count_by_lane_out: Any,
) -> None:
    """Mark the blocks at rest at the start of a sample; skip the samples in which the base motion cannot move them."""
    count = 0
    for j in range(active_lane_count):
        course = load_case_progress(state, j)
        s = load_block_state(state, j)
        block = load_block_constants(state, j)
        length = state[NEXT_STEP_LENGTH_ROW_OFFSET + j]
        mu_left, mu_right = load_signed_friction_or_zero_if_sticking(state, j)
        now = course.current_sample + s.ticks_since_sample_start * (1.0 / ticks_per_sample)
        still = body_is_still(
            max_of_translation_and_half_height_rotation(s.centre_vx, s.centre_vz, s.angular_velocity, block),
            max_of_translation_and_half_height_rotation(s.centre_ax, s.centre_az, s.angular_acceleration, block),
            length * block.seconds_per_tick,
            state[REST_ACCELERATION_LIMIT_ROW_OFFSET + j],
        )
        held = (
            (s.left.normal_force_per_mass > 0.0)
            & (s.right.normal_force_per_mass > 0.0)
            & ((mu_left == 0.0) & (mu_right == 0.0))
        )
        resting = (length >= TICKS_PER_WHOLE_STEP) & is_rest_check_sample(now) & held & still
        state[AT_REST_AT_SAMPLE_START_ROW_OFFSET + j] = 1.0 if resting else 0.0
        count += 1 if resting else 0
    for j in range(active_lane_count if count > 0 else 0):
        if state[AT_REST_AT_SAMPLE_START_ROW_OFFSET + j] > 0.0:
            course = load_case_progress(state, j)
            now = course.current_sample + state[TICKS_SINCE_SAMPLE_START_ROW_OFFSET + j] * (1.0 / ticks_per_sample)
            samples = count_skippable_samples(
                ground_motion, motion_row_by_case[case_index_by_lane[j]], now, course.amplitude_factor,
                state[REST_ACCELERATION_LIMIT_ROW_OFFSET + j],
            )  # fmt: skip
            state[CURRENT_SAMPLE_ROW_OFFSET + j] += samples
            skipped_sample_count_by_lane_out[j] += samples


@njit(**INLINE_OPTIONS)
def max_of_translation_and_half_height_rotation(
    velocity_or_acceleration_x: float,
    velocity_or_acceleration_z: float,
    angular_velocity_or_acceleration: float,
    block: BlockConstants,
) -> float:
    """Return the largest of |x|, |z| and half height × |angular| component of a block's velocity or acceleration."""
    x, z = abs(velocity_or_acceleration_x), abs(velocity_or_acceleration_z)
    turn, most = abs(angular_velocity_or_acceleration) * block.half_height, x if x > z else z
    return most if most > turn else turn


def current_case_status(kernel_input: Any, workspace: Any, lane: int, case: int) -> int:  # noqa: ARG001
    """Return the `CaseStatus` of the case in column `lane` of the state array; `CASE_NOT_ENDED` if it has not ended."""
    return update_late_largest_tilt_and_return_case_status(
        workspace.state,
        lane,
        kernel_input.scheme_constants.velocity_lag_behind_position_in_steps,
        kernel_input.settings.ticks_per_sample,
        float(kernel_input.settings.sample_count),
        kernel_input.max_penetration_to_half_side_ratio,
    )


def write_results_of_ended_case(kernel_input: Any, workspace: Any, lane: int, case: int, status: int) -> None:
    """Write the results of the case in column `lane` of the state array into the table of results."""
    write_case_results_except_status_and_counters(
        workspace.state, lane, status, kernel_input.scheme_constants.velocity_lag_behind_position_in_steps,
        kernel_input.settings.ticks_per_sample, kernel_input.results[case],
    )  # fmt: skip


register_model_functions(
    BlockKernelInput, allocate_workspace, start_case, update_sample_and_load_motion, attempt_steps_until_next_check,
    mark_possibly_ended_cases, skip_samples_too_weak_to_move_resting_cases, current_case_status,
    write_results_of_ended_case,
)  # fmt: skip
