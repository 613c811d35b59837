"""Functions that the queue of cases calls for 3-D bodies: start a case, compute a sample, skip samples, end a case.

Vertices i and i + count/2 are opposite each other. The rows of the vertices follow those of the body,
`VERTEX_ROW_LAYOUT.array_length` numbers per vertex.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.body.access import (
    AT_REST_AT_SAMPLE_START_ROW_OFFSET,
    CURRENT_SAMPLE_ROW_OFFSET,
    LAST_UPRIGHT_TICK_OF_SAMPLE_ROW_OFFSET,
    LAST_UPRIGHT_TIME_ROW_OFFSET,
    LOADED_SAMPLE_NUMBER_ROW_OFFSET,
    NEXT_STEP_TICKS_ROW_OFFSET,
    REST_ACCELERATION_LIMIT_ROW_OFFSET,
    STATE_ROW_COUNT,
    TICKS_SINCE_SAMPLE_START_ROW_OFFSET,
    VALUE_COUNT_PER_VERTEX_IN_ALL_LANES,
    load_body_constants,
    load_body_state,
    load_case_progress,
    load_peaks_and_last_upright_tick,
    load_termination_limits,
    store_inertial_and_upward_base_accelerations,
    store_rotation_quaternion,
)
from overturning.dem.body.centred_loops import build_time_stepping_loop
from overturning.dem.body.ending import (
    body_rests_upright_on_all_base_vertices,
    state_sum_for_finite_check,
    update_peak_tilt_near_end_and_return_status,
    write_body_trajectory_row,
    write_case_results,
)
from overturning.dem.body.rotation import inertial_accelerations_until_next_sample
from overturning.dem.body.start import write_body_constants_and_initial_state
from overturning.dem.body.state import PARALLEL_CASE_COUNT, TICKS_PER_WHOLE_STEP
from overturning.dem.body.vectors import renormalise_nearly_unit_quaternion, rotation_matrix
from overturning.dem.kernel.ending import (
    MAX_ACCELERATION_AT_REST_TO_REST_LIMIT_RATIO,
    case_cannot_have_ended,
    continuation_sample_tick_and_last_upright_time,
)
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
    create_lookup_by_type,
    grow_trajectory_array_if_needed,
    register_model_functions,
)
from overturning.units import STANDARD_GRAVITY as GRAVITY


class PolygonalBaseTimeSteppingLoopTag(NamedTuple):
    """Type that selects, at compile time, the loop for bodies with a polygonal base.

    See `TIME_STEPPING_LOOP_BY_BASE_SHAPE_TAG`.
    """

    has_round_base: bool = False


class RoundBaseTimeSteppingLoopTag(NamedTuple):
    """Type that selects, at compile time, the loop for bodies with a round base.

    See `TIME_STEPPING_LOOP_BY_BASE_SHAPE_TAG`.
    """

    has_round_base: bool = True


TIME_STEPPING_LOOP_BY_BASE_SHAPE_TAG: Final[dict[type, Any]] = {
    PolygonalBaseTimeSteppingLoopTag: build_time_stepping_loop(False),
    RoundBaseTimeSteppingLoopTag: build_time_stepping_loop(True),
}
"""Compiled function that attempts time steps, by the type of the tag that selects it."""


class BodyKernelInput(NamedTuple):
    """Kernel input for cases of 3-D bodies with equal numbers of steps per sample and equal numbers of vertices."""

    settings: SettingsCommonToParallelCases
    cases: NDArray[np.void]
    """Case parameters, of type `CASE_TABLE_DTYPE`, shape (n,)."""
    motion_row_by_case: NDArray[np.int64]
    results: NDArray[np.void]
    """Results to fill in, of type `RESULT_TABLE_DTYPE`, shape (n,)."""
    ground_motion: BaseAccelerationsAndMaximaInWindowAhead
    marker_whose_type_selects_base_shape_loop: Any
    """Value whose type, a key of `TIME_STEPPING_LOOP_BY_BASE_SHAPE_TAG`, selects the time loop."""
    body_constants_by_size: NDArray[np.void]
    """Constants of the bodies, of type `BODY_TABLE_DTYPE`, shape (bodies,)."""
    vertices_and_base_edges_by_size: FloatArray
    """Vertices of each body, shape (bodies, vertices, 6): position from its centre, m, and the outward normal and the
    distance (m) of the edge of the base that starts there."""
    base_vertex_count: int
    """Number of vertices of the base."""
    lean_sector_vectors_and_fall_limits_by_size: FloatArray
    """Sectors of each body, see `overturning.model.solid.RigidSolid`, shape (bodies, sectors, 5)."""


class ParallelBodiesStateArrays(NamedTuple):
    """Arrays with the states of the 3-D bodies that the kernel computes in parallel, one column (lane) each."""

    state: Any
    """Rows of the bodies, followed by those of the vertices."""
    vertex_rows: Any
    """Rows of the vertices: a view of `state`."""


select_time_stepping_loop_by_base_shape = create_lookup_by_type(TIME_STEPPING_LOOP_BY_BASE_SHAPE_TAG)
"""Return the loops of bodies, selected by the type of their loop selector."""


def allocate_workspace(kernel_input: Any) -> Any:
    """Return empty state arrays of bodies and their vertices, one column (lane) per case computed in parallel."""
    state = cache_line_aligned_zeros(
        STATE_ROW_COUNT * PARALLEL_CASE_COUNT
        + kernel_input.vertices_and_base_edges_by_size.shape[1] * VALUE_COUNT_PER_VERTEX_IN_ALL_LANES
    )
    return ParallelBodiesStateArrays(state, state[STATE_ROW_COUNT * PARALLEL_CASE_COUNT :])


def start_case(kernel_input: Any, workspace: Any, lane: int, case_index: int) -> None:
    """Load the initial state of the 3-D body of case number `case_index` into column `lane` of the state arrays."""
    given = kernel_input.cases[case_index]
    body = kernel_input.body_constants_by_size[given.body]
    points = kernel_input.vertices_and_base_edges_by_size[given.body]
    interval = kernel_input.settings.sampling_interval
    write_body_constants_and_initial_state(
        workspace.state,
        workspace.vertex_rows,
        lane,
        given,
        body,
        points,
        interval,
        kernel_input.settings.ticks_per_sample,
    )


def update_sample_and_load_motion(kernel_input: Any, workspace: Any, case_index_by_lane: Any, lane_count: int) -> None:
    """Load the base motion of the next sample for each case, and rescale each quaternion to length 1."""
    advance_sample_and_load_base_motion(
        workspace.state,
        lane_count,
        kernel_input.motion_row_by_case,
        case_index_by_lane,
        kernel_input.ground_motion,
        kernel_input.settings,
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def advance_sample_and_load_base_motion(
    body_states: Any,
    lane_count: int,
    motion_row_by_case: Any,
    case_index_by_lane: Any,
    ground_motion: Any,
    queue_settings: SettingsCommonToParallelCases,
) -> None:
    """Go on to the next sample where one has ended, rescale each quaternion to length 1, and load the base motion."""
    along = ground_motion.horizontal_acceleration
    up = ground_motion.upward_acceleration
    ticks = queue_settings.ticks_per_sample
    interval = queue_settings.sampling_interval
    scale = 1.0 / queue_settings.ticks_per_sample
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        s = load_body_state(body_states, j)
        store_rotation_quaternion(body_states, j, renormalise_nearly_unit_quaternion(s.rotation))
        begun = continuation_sample_tick_and_last_upright_time(
            load_case_progress(body_states, j),
            s.ticks_since_sample_start,
            body_states[LAST_UPRIGHT_TICK_OF_SAMPLE_ROW_OFFSET + j],
            ticks,
            interval,
        )
        (
            body_states[CURRENT_SAMPLE_ROW_OFFSET + j],
            body_states[TICKS_SINCE_SAMPLE_START_ROW_OFFSET + j],
            body_states[LAST_UPRIGHT_TIME_ROW_OFFSET + j],
        ) = begun
        body_states[LAST_UPRIGHT_TICK_OF_SAMPLE_ROW_OFFSET + j] = -1.0
    last = up.shape[0] - 3
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        course = load_case_progress(body_states, j)
        if body_states[LOADED_SAMPLE_NUMBER_ROW_OFFSET + j] == course.current_sample + 1.0:
            continue
        body_states[LOADED_SAMPLE_NUMBER_ROW_OFFSET + j] = course.current_sample + 1.0
        i = min(int(course.current_sample), last)
        horizontal = along[motion_row_by_case[case_index_by_lane[j]]]
        store_inertial_and_upward_base_accelerations(
            body_states, j, inertial_accelerations_until_next_sample(horizontal, up, i, course.amplitude_factor, scale)
        )


def attempt_steps_until_next_check(
    kernel_input: Any, workspace: Any, lane_count: int, trajectory_buffer: Any, recorded_row_count: int
) -> tuple[Any, int]:
    """Attempt time steps of all bodies until the next end test; return the trajectory and its number of rows.

    Only the body in column 0 has a trajectory. If it is full, no steps are attempted and the number is −1.
    """
    # Unpack the input before the branch: otherwise Numba increments the reference count of every array once per sample.
    settings = kernel_input.settings
    marker = kernel_input.marker_whose_type_selects_base_shape_loop
    count = kernel_input.vertices_and_base_edges_by_size.shape[1]
    base = kernel_input.base_vertex_count
    if trajectory_buffer.shape[0] > 0:
        trajectory_buffer = grow_trajectory_array_if_needed(
            trajectory_buffer, recorded_row_count + 1, settings.max_trajectory_rows
        )
        if trajectory_buffer.shape[0] == recorded_row_count:
            return trajectory_buffer, -1
        write_body_trajectory_row(
            workspace.state,
            0,
            settings.sampling_interval,
            settings.ticks_per_sample,
            trajectory_buffer[recorded_row_count],
        )
        recorded_row_count += (
            1
            if recorded_row_count == 0
            or trajectory_buffer[recorded_row_count].time > trajectory_buffer[recorded_row_count - 1].time
            else 0
        )
    select_time_stepping_loop_by_base_shape(marker)(
        marker,
        workspace.state,
        workspace.vertex_rows,
        count,
        base,
        lane_count,
        settings.attempted_steps_between_end_checks,
        settings.ticks_per_sample,
    )
    return trajectory_buffer, recorded_row_count


def mark_possibly_ended_cases(
    kernel_input: Any, workspace: Any, active_lane_count: int, possible_end_flag_by_lane_out: Any
) -> int:
    """Set the flag of each case that may have ended to 1, those of others to 0; return the number of ones."""
    return mark_possibly_ended_body_cases(
        workspace.state,
        active_lane_count,
        possible_end_flag_by_lane_out,
        kernel_input.settings.ticks_per_sample,
        float(kernel_input.settings.sample_count),
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def mark_possibly_ended_body_cases(
    body_states: Any,
    active_lane_count: int,
    possible_end_flag_by_lane_out: Any,
    ticks_per_sample: float,
    record_sample_count: float,
) -> int:
    """Mark and count cases that may have ended: fall, invalid state, or no sample left that can start a motion."""
    count = 0.0
    for j in range(active_lane_count):
        s, limits = load_body_state(body_states, j), load_termination_limits(body_states, j)
        sound = (rotation_matrix(s.rotation).zz > limits.fall_tilt_cosine) & (
            load_peaks_and_last_upright_tick(body_states, j).peak_penetration <= limits.max_penetration
        )
        possible_end_flag_by_lane_out[j] = (
            0.0
            if case_cannot_have_ended(
                load_case_progress(body_states, j),
                s.ticks_since_sample_start,
                ticks_per_sample,
                record_sample_count,
                state_sum_for_finite_check(s),
                sound,
            )
            else 1.0
        )
    for j in range(active_lane_count):
        count += possible_end_flag_by_lane_out[j]
    return int(count)


@njit(**INTERNAL_COMPILE_OPTIONS)
def mark_possibly_resting_bodies(body_states: Any, active_lane_count: int) -> int:
    """Mark and count, by a quick test, the cases whose body may be at rest.

    The mark is the field `was_at_rest_at_sample_start` of `RestAccelerationLimitAndAtRestFlag`.
    """
    number = 0
    for j in range(active_lane_count):
        s = load_body_state(body_states, j)
        length = body_states[NEXT_STEP_TICKS_ROW_OFFSET + j]
        least = (
            MAX_ACCELERATION_AT_REST_TO_REST_LIMIT_RATIO * body_states[REST_ACCELERATION_LIMIT_ROW_OFFSET + j] * GRAVITY
        )
        v, a, most = s.velocity_relative_to_base, s.acceleration_relative_to_base, 1.001 * least
        still = (abs(a.x) < most) & (abs(a.y) < most) & (abs(a.z) < most)
        slow = 2.0 * abs(v.z) < most * (load_body_constants(body_states, j).tick_length_s * length)
        may = (length >= TICKS_PER_WHOLE_STEP) & still & slow
        body_states[AT_REST_AT_SAMPLE_START_ROW_OFFSET + j] = 1.0 if may else 0.0
        number += 1 if may else 0
    return number


def skip_samples_too_weak_to_move_resting_cases(
    kernel_input: Any,
    workspace: Any,
    case_index_by_lane: Any,
    active_lane_count: int,
    skipped_sample_totals_by_lane_in_place: Any,
) -> None:
    """Skip, for each case with a body at rest, the samples whose base motion is too weak to move the body."""
    settings = kernel_input.settings
    state = workspace.state
    ground = kernel_input.ground_motion
    row = kernel_input.motion_row_by_case
    base = kernel_input.base_vertex_count
    count = kernel_input.vertices_and_base_edges_by_size.shape[1]
    if mark_possibly_resting_bodies(state, active_lane_count) == 0:
        return
    for j in range(active_lane_count):
        course = load_case_progress(state, j)
        over = state[TICKS_SINCE_SAMPLE_START_ROW_OFFSET + j] * (1.0 / settings.ticks_per_sample)
        rest_limit = state[REST_ACCELERATION_LIMIT_ROW_OFFSET + j]
        now = course.current_sample + over
        # Test the motion first: testing the body takes longer.
        quiet = state[AT_REST_AT_SAMPLE_START_ROW_OFFSET + j] > 0.0 and is_rest_check_sample(now)
        quiet = quiet and next_window_motion_is_below_rest_limit(
            ground, row[case_index_by_lane[j]], now, course.amplitude_factor, rest_limit
        )
        if quiet and body_rests_upright_on_all_base_vertices(state, workspace.vertex_rows, count, base, j, rest_limit):
            samples = count_skippable_samples(
                ground, row[case_index_by_lane[j]], now, course.amplitude_factor, rest_limit
            )
            state[CURRENT_SAMPLE_ROW_OFFSET + j] += samples
            skipped_sample_totals_by_lane_in_place[j] += samples


def current_case_status(kernel_input: Any, workspace: Any, lane: int, case_index: int) -> int:
    """Return the `CaseStatus` of the case in column `lane` of the state array; `CASE_NOT_ENDED` if it has not ended."""
    end = float(kernel_input.settings.sample_count)
    sectors = kernel_input.lean_sector_vectors_and_fall_limits_by_size[kernel_input.cases[case_index].body]
    return update_peak_tilt_near_end_and_return_status(
        workspace.state,
        workspace.vertex_rows,
        kernel_input.base_vertex_count,
        lane,
        kernel_input.settings.ticks_per_sample,
        end,
        sectors,
    )


def write_results_of_ended_case(kernel_input: Any, workspace: Any, lane: int, case_index: int, status: int) -> None:
    """Write the results of case number `case_index`, stored in column `lane`, into `kernel_input.results`."""
    sectors = kernel_input.lean_sector_vectors_and_fall_limits_by_size[kernel_input.cases[case_index].body]
    write_case_results(workspace.state, workspace.vertex_rows, lane, status, kernel_input.results[case_index], sectors)


register_model_functions(
    BodyKernelInput, allocate_workspace, start_case, update_sample_and_load_motion, attempt_steps_until_next_check,
    mark_possibly_ended_cases, skip_samples_too_weak_to_move_resting_cases, current_case_status,
    write_results_of_ended_case,
)  # fmt: skip
