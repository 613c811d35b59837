"""Functions that the queue calls for 3-D stacks: start a case, compute a sample, end a case."""

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.body.state import (
    LoadedBaseMotionSampleNumber,
    inertial_accelerations_until_next_sample,
    lean_as_squared_sine,
)
from overturning.dem.body.vectors import Quaternion, SymmetricMatrix, Vector3, normalise_quaternion, rotation_matrix
from overturning.dem.kernel.clock import CaseStepControl, NextStepToAttempt
from overturning.dem.kernel.ending import CaseProgress, next_sample_tick_and_last_upright_time
from overturning.dem.kernel.ground import (
    GroundMotion,
    count_skippable_samples,
    is_rest_check_sample,
    upcoming_motion_is_below_rest_limit,
)
from overturning.dem.kernel.lanes import INTERNAL_COMPILE_OPTIONS, cache_line_aligned_zeros, round_to_vector_multiple
from overturning.dem.kernel.queue import SettingsOfParallelCases, grow_trajectory_array, register_model_functions
from overturning.dem.stack.access import (
    load_course,
    load_outcome,
    load_rest,
    load_stone,
    stone_window,
    store_attempt,
    store_case,
    store_clock,
    store_constants,
    store_course,
    store_history,
    store_joint,
    store_outcome,
    store_outline,
    store_peaks,
    store_rest,
    store_rotation,
    store_shaking,
    store_stone,
)
from overturning.dem.stack.ending import (
    lowest_newly_fallen_stone_index,
    stone_state_sum_for_finite_check,
    stop_fallen_stones_and_return_status,
    write_stack_results,
)
from overturning.dem.stack.joint_state import (
    JOINT_ROW_LAYOUT,
    POINT_ROW_LAYOUT,
    FaceCorner,
    JointConstants,
    JointContactState,
    TangentTwistVector,
)
from overturning.dem.stack.path import record_motion_of_first_stack
from overturning.dem.stack.rest import (
    MAY_BE_AT_REST_ROW,
    base_acceleration_limit_of_stack_at_rest,
    mark_possibly_resting_stacks,
)
from overturning.dem.stack.state import (
    CASE_ROW_LAYOUT,
    PARALLEL_CASE_COUNT,
    STONE_ROW_LAYOUT,
    StackClockWithinSample,
    StackRestFlagAndLimits,
    StackTickLengthAndLimits,
    StoneConstants,
    StoneFallState,
    StonePeakTilt,
    StoneState,
)
from overturning.dem.stack.step import advance_stacks, joint_state_size

CASE_SIZE, STONE_SIZE, JOINT_SIZE, P = (
    CASE_ROW_LAYOUT.size, STONE_ROW_LAYOUT.size, JOINT_ROW_LAYOUT.size, POINT_ROW_LAYOUT.size,
)  # fmt: skip
TICK, SAMPLE, ENERGY, LOADED = (
    CASE_ROW_LAYOUT.row_offset_of_field(StackClockWithinSample, "ticks_since_sample_start"),
    CASE_ROW_LAYOUT.row_offset_of_field(CaseProgress, "current_sample"),
    CASE_ROW_LAYOUT.row_offset_of_field(CaseProgress, "initial_energy"),
    CASE_ROW_LAYOUT.row_offset_of_field(LoadedBaseMotionSampleNumber, "sample"),
)
LAST_UPRIGHT, UPRIGHT_UNTIL = (
    STONE_ROW_LAYOUT.row_offset_of_field(StonePeakTilt, "last_upright_tick"),
    STONE_ROW_LAYOUT.row_offset_of_field(StoneFallState, "last_upright_time"),
)


class StackKernelInput(NamedTuple):
    """Input of the stack kernel, for cases with equal steps per sample and equal numbers of stones and corners."""

    settings: SettingsOfParallelCases
    cases: NDArray[np.void]
    """Case parameters, of type `CASE_ROW_LAYOUT`, shape (n,)."""
    motion_rows: NDArray[np.int64]
    results: NDArray[np.void]
    """Results to fill in, of type `RESULT_TABLE_DTYPE`, shape (n,)."""
    stone_results: NDArray[np.void]
    """Results of each stone to fill in, of type `STONE_RESULT_TABLE_DTYPE`, shape (n, stones)."""
    ground_motion: GroundMotion
    friction: FloatArray
    """Coefficient of friction of each joint, shape (n, stones)."""
    stones: NDArray[np.void]
    """Constants and initial state of the stones of each stack, of type `STONE_ROW_LAYOUT`, shape (stacks, stones)."""
    joints: NDArray[np.void]
    """Contact constants of the joint below each stone, of type `JOINT_ROW_LAYOUT`, shape (stacks, stones)."""
    corner_counts: NDArray[np.int64]
    """Number of corners of each stone's faces, shape (stones,)."""
    face_corners: FloatArray
    """Corners of each stone's base and upper face, shape (stacks, stones, 2, corners, 6): fields of `FaceCorner`."""


class StackWorkspace(NamedTuple):
    """Working arrays of the stack kernel: states of the cases, and indices of the contact points in use."""

    state: Any
    used_contact_points: Any


def allocate_workspace(kernel_input: Any) -> Any:
    """Allocate the state arrays of the stacks that are simulated in parallel, one column (lane) each."""
    stones, corners = kernel_input.face_corners.shape[1], kernel_input.face_corners.shape[3]
    size = CASE_SIZE + stones * (STONE_SIZE + joint_state_size(corners))
    return StackWorkspace(cache_line_aligned_zeros(size), np.zeros((stones, 1 + 6 * corners), np.int64))


def start_case(kernel_input: Any, workspace: Any, lane: int, case: int) -> None:
    """Load the initial state of case number `case`, a stack at rest, into column `lane` of the state array."""
    given, settings = kernel_input.cases[case], kernel_input.settings
    write_initial_stack_state(
        workspace.state, lane, given, (kernel_input.stones[given.stack], kernel_input.joints[given.stack]),
        kernel_input.friction[case], kernel_input.face_corners[given.stack], kernel_input.corner_counts,
        (settings.sampling_interval, settings.ticks_per_sample),
    )  # fmt: skip


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_initial_stack_state(
    state: Any, lane: int, case: Any, stones_and_joints: tuple[Any, Any], friction: Any, outlines: Any, corners: Any,
    sampling_interval_and_ticks: tuple[float, float],
) -> None:  # fmt: skip
    """Load a stack at rest into column `lane` of the state array.

    `sample` is the sampling interval in seconds and in ticks, the unit of time of the steps.
    """
    (stones, joints), (sampling_interval, ticks_per_sample) = stones_and_joints, sampling_interval_and_ticks
    for row in range(state.size // PARALLEL_CASE_COUNT):
        state[row * PARALLEL_CASE_COUNT + lane] = 0.0
    first, size = CASE_SIZE + stones.size * STONE_SIZE, joint_state_size(outlines.shape[2])
    store_clock(state, lane, CaseStepControl(
        case.shortest_step, case.longest_step_at_rest, case.steps_per_length_after_contact_change,
        case.long_steps_before_doubling,
    ))  # fmt: skip
    store_case(state, lane, StackTickLengthAndLimits(
        sampling_interval / ticks_per_sample, case.max_penetration, case.max_acceleration_for_sample_long_steps_g,
        case.max_kinetic_energy_at_rest, case.min_mass_centre_to_side_distance
    ))  # fmt: skip
    store_rest(
        state,
        lane,
        StackRestFlagAndLimits(case.max_share_of_onset_acceleration_at_rest, case.max_base_acceleration_at_rest_g, 0.0),
    )
    store_attempt(state, lane, NextStepToAttempt(case.shortest_step, case.steps_per_length_after_contact_change, 0.0))
    for s in range(stones.size):
        at, stone = first + s * size, stones[s]
        write_initial_stone_state(stone_window(state, s), lane, stone)
        write_initial_joint_state(
            state[at : at + size], lane, joints[s], friction[s], case.damping_factor, stone.centre_height,
            stone.side_distance,
        )  # fmt: skip
        for i in range(corners[s]):
            begin = at + JOINT_SIZE + i * P
            o = outlines[s, 0, i]
            store_outline(state[begin : begin + P], lane, FaceCorner(o[0], o[1], o[2], o[3], o[4], o[5]))
        if s > 0:
            for i in range(corners[s - 1]):
                begin = at + JOINT_SIZE + (corners[s] + i) * P
                o = outlines[s - 1, 1, i]
                store_outline(state[begin : begin + P], lane, FaceCorner(o[0], o[1], o[2], o[3], o[4], o[5]))
    store_course(state, lane, CaseProgress(
        case.amplitude_factor, case.first_simulated_sample, case.last_onset_sample, case.end_sample_if_undecided,
        case.first_simulated_sample * sampling_interval, case.spring_energy_at_rest,
        case.min_overturning_energy,
    ))  # fmt: skip


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_initial_stone_state(rows: Any, lane: int, constants: Any) -> None:
    """Write the constants and the initial state of a stone into column `lane` of its rows of the state array."""
    store_constants(rows, lane, StoneConstants(
        inverse_inertia=SymmetricMatrix(
            constants.inverse_inertia_xx, constants.inverse_inertia_yy, constants.inverse_inertia_zz,
            constants.inverse_inertia_xy, constants.inverse_inertia_xz, constants.inverse_inertia_yz
        ),
        inertia_per_mass=SymmetricMatrix(
            constants.inertia_xx, constants.inertia_yy, constants.inertia_zz, constants.inertia_xy,
            constants.inertia_xz, constants.inertia_yz
        ),
        mass=constants.mass, centre_height=constants.centre_height, upper_face_height=constants.upper_face_height,
        critical_lean_squared_sine=constants.critical_lean_squared_sine,
        base_critical_lean_squared_sine=constants.base_critical_lean_squared_sine,
        fall_tilt_cosine=constants.fall_tilt_cosine,
        max_centre_drop_without_fall=constants.max_centre_drop_without_fall,
    ))  # fmt: skip
    at, still = constants.start, Vector3(0.0, 0.0, 0.0)
    turn = Quaternion(at.qw, at.qx, at.qy, at.qz)
    store_stone(rows, lane, StoneState(Vector3(at.x, at.y, at.z), turn, still, still, still, still))
    store_peaks(rows, lane, StonePeakTilt(lean_as_squared_sine(rotation_matrix(turn)), -1.0))
    store_outcome(rows, lane, StoneFallState(1.0, 0.0, 0.0))


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_initial_joint_state(
    rows: Any,
    lane: int,
    constants: Any,
    friction: float,
    damping_factor: float,
    centre_height: float,
    edge_distance: float,
) -> None:
    """Write contact constants and load at rest of a stone's contact with its support into column `lane`."""
    store_joint(rows, lane, JointConstants(
        normal_stiffness=constants.normal_stiffness, normal_dashpot=constants.normal_dashpot * damping_factor,
        tangential_stiffness=constants.tangential_stiffness, tangential_compliance=constants.tangential_compliance,
        tangential_dashpot=constants.tangential_dashpot * damping_factor, friction=friction,
        landing_duration=constants.landing_duration * damping_factor,
        friction_moment_share=0.0 if friction * centre_height <= edge_distance else 1.0,
        min_rim_distance_of_waiting_corners=constants.min_rim_distance_of_waiting_corners,
        base_corner_count=constants.base_corner_count,
    ))  # fmt: skip
    still = TangentTwistVector(0.0, 0.0, 0.0)
    store_history(rows, lane, JointContactState(
        still, still, constants.pressure_centre_x, constants.pressure_centre_y, constants.mean_pressure_radius,
        constants.normal_force, 0.0, 0.0
    ))  # fmt: skip


def update_sample_and_load_motion(kernel_input: Any, workspace: Any, lane_cases: Any, lane_count: int) -> None:
    """Load the base motion of the next sample for each stack, and rescale all quaternions to length 1."""
    start_sample_and_load_base_motion(
        workspace.state, kernel_input.corner_counts.size, lane_count, kernel_input.motion_rows, lane_cases,
        kernel_input.ground_motion, kernel_input.settings,
    )  # fmt: skip


@njit(**INTERNAL_COMPILE_OPTIONS)
def start_sample_and_load_base_motion(
    state: Any,
    stone_count: int,
    lane_count: int,
    motion_rows: Any,
    lane_cases: Any,
    ground: Any,
    settings: SettingsOfParallelCases,
) -> None:
    """Load the base motion of the current sample for each stack, and rescale all quaternions to length 1."""
    along, up, ticks, interval, scale = (
        ground.along, ground.up, settings.ticks_per_sample, settings.sampling_interval,
        1.0 / settings.ticks_per_sample,
    )  # fmt: skip
    for s in range(stone_count):
        rows = stone_window(state, s)
        for j in range(round_to_vector_multiple(lane_count)):
            store_rotation(rows, j, normalise_quaternion(load_stone(rows, j).rotation))
            then = (load_course(state, j).current_sample + rows[LAST_UPRIGHT + j] * scale) * interval
            present = load_outcome(rows, j).is_simulated > 0.0
            rows[UPRIGHT_UNTIL + j] = then if (rows[LAST_UPRIGHT + j] >= 0.0) & present else rows[UPRIGHT_UNTIL + j]
            rows[LAST_UPRIGHT + j] = -1.0
    for j in range(round_to_vector_multiple(lane_count)):
        # The times at which the stones were upright are their own, above.
        begun = next_sample_tick_and_last_upright_time(load_course(state, j), state[TICK + j], -1.0, ticks, interval)
        state[SAMPLE + j], state[TICK + j] = begun[0], begun[1]
    last = up.shape[0] - 3
    for j in range(round_to_vector_multiple(lane_count)):
        course = load_course(state, j)
        if state[LOADED + j] == course.current_sample + 1.0:
            continue
        state[LOADED + j] = course.current_sample + 1.0
        i = min(int(course.current_sample), last)
        horizontal = along[motion_rows[lane_cases[j]]]
        store_shaking(
            state, j, inertial_accelerations_until_next_sample(horizontal, up, i, course.amplitude_factor, scale)
        )


def attempt_steps_until_next_check(
    kernel_input: Any, workspace: Any, lane_count: int, trajectory: Any, recorded_row_count: int
) -> tuple[Any, int]:
    """Attempt a sample's time steps for all stacks in parallel; record the first stack once per sample."""
    settings, interval = kernel_input.settings, kernel_input.settings.sampling_interval
    corners, limit, stones = (
        kernel_input.corner_counts,
        kernel_input.face_corners.shape[3],
        kernel_input.corner_counts.size,
    )
    if trajectory.shape[0] > 0:
        most_rows = settings.max_trajectory_rows // trajectory.shape[1]
        trajectory = grow_trajectory_array(trajectory, recorded_row_count + 1, most_rows)
        if trajectory.shape[0] == recorded_row_count:
            return trajectory, -1
        record_motion_of_first_stack(
            workspace.state, stones, interval, settings.ticks_per_sample, trajectory[recorded_row_count]
        )
        due = trajectory[recorded_row_count - 1, 0] + 0.999 * interval if recorded_row_count > 0 else 0.0
        recorded_row_count += 1 if trajectory[recorded_row_count, 0] >= due else 0
    advance_stacks(
        workspace.state, stones, limit, corners, workspace.used_contact_points, lane_count, settings.steps_per_check,
        settings.ticks_per_sample,
    )  # fmt: skip
    return trajectory, recorded_row_count


def mark_possibly_ended_cases(kernel_input: Any, workspace: Any, active_lane_count: int, end_marks_out: Any) -> int:
    """Mark and count the stacks whose case may have ended or in which a stone may have fallen."""
    return mark_stacks_due_for_end_test(
        workspace.state, kernel_input.corner_counts.size, kernel_input.face_corners.shape[3], active_lane_count,
        end_marks_out, kernel_input.settings.ticks_per_sample, float(kernel_input.settings.sample_count),
    )  # fmt: skip


@njit(**INTERNAL_COMPILE_OPTIONS)
def mark_stacks_due_for_end_test(
    state: Any,
    stone_count: int,
    max_corner_count: int,
    active_lane_count: int,
    end_marks_out: Any,
    ticks_per_sample: float,
    last_sample: float,
) -> int:
    """Mark and count the stacks with a fallen stone, a state that is not finite, or no strong motion left."""
    count = 0
    for j in range(active_lane_count):
        course, total = load_course(state, j), 0.0
        for s in range(stone_count):
            total += stone_state_sum_for_finite_check(load_stone(stone_window(state, s), j))
        sample = course.current_sample + state[TICK + j] / ticks_per_sample
        due = total - total != 0.0 or sample >= min(course.last_onset_sample, last_sample)
        due = due or lowest_newly_fallen_stone_index(state, j, stone_count, max_corner_count) < stone_count
        end_marks_out[j] = 1.0 if due else 0.0
        count += 1 if due else 0
    return count


def skip_quiet_samples_of_resting_cases(
    kernel_input: Any, workspace: Any, lane_cases: Any, active_lane_count: int, skipped_sample_counts_out: Any
) -> None:
    """Skip, for each stack at rest, the samples whose base motion is too weak to move the stack."""
    settings, state, ground = kernel_input.settings, workspace.state, kernel_input.ground_motion
    row = kernel_input.motion_rows
    stones, corners = kernel_input.corner_counts.size, kernel_input.face_corners.shape[3]
    if mark_possibly_resting_stacks(state, stones, active_lane_count) == 0:
        return
    for j in range(active_lane_count):
        course, bound = load_course(state, j), load_rest(state, j).max_base_acceleration_g
        now = course.current_sample + state[TICK + j] * (1.0 / settings.ticks_per_sample)
        # Test the motion first: testing the stack takes longer.
        if not (state[MAY_BE_AT_REST_ROW + j] > 0.0 and is_rest_check_sample(now)):
            continue
        direction = row[lane_cases[j]]
        if not upcoming_motion_is_below_rest_limit(ground, direction, now, course.amplitude_factor, bound):
            continue
        rest_limit = base_acceleration_limit_of_stack_at_rest(state, j, stones, corners)
        if rest_limit > 0.0:
            samples = count_skippable_samples(ground, direction, now, course.amplitude_factor, rest_limit)
            state[SAMPLE + j] += samples
            skipped_sample_counts_out[j] += samples


def current_case_status(kernel_input: Any, workspace: Any, lane: int, case: int) -> int:
    """Stop simulating fallen stones; return the `CaseStatus` of the case in column `lane`."""
    stones, corners = kernel_input.corner_counts.size, kernel_input.face_corners.shape[3]
    return stop_fallen_stones_and_return_status(
        workspace.state, lane, stones, corners, kernel_input.settings.ticks_per_sample,
        float(kernel_input.settings.sample_count),
        kernel_input.stones[kernel_input.cases[case].stack],
    )  # fmt: skip


def write_results_of_ended_case(kernel_input: Any, workspace: Any, lane: int, case: int, status: int) -> None:
    """Write the results of case number `case`, stored in column `lane`, into the tables of results."""
    stones, corners = kernel_input.corner_counts.size, kernel_input.face_corners.shape[3]
    write_stack_results(
        workspace.state, lane, stones, corners, status, kernel_input.stones[kernel_input.cases[case].stack].rest,
        kernel_input.results[case], kernel_input.stone_results[case],
    )  # fmt: skip


register_model_functions(
    StackKernelInput, allocate_workspace, start_case, update_sample_and_load_motion, attempt_steps_until_next_check,
    mark_possibly_ended_cases, skip_quiet_samples_of_resting_cases, current_case_status, write_results_of_ended_case,
)  # fmt: skip
