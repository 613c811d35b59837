"""Termination of a stack: stones that have fallen, energy, the tests for the end of a case, and its results."""

import math
from typing import Any, Final

import numpy as np
from numba import njit

from overturning.dem.body.state import squared_sine_of_lean_continued_beyond_90_deg
from overturning.dem.body.vectors import (
    Matrix3,
    Vector3,
    rotation_matrix,
)
from overturning.dem.kernel.ending import (
    CASE_NOT_ENDED,
    CaseProgress,
    LastSampleOfContinuedSlidingCase,
    set_slide_end_once_and_check_case_continues,
)
from overturning.dem.kernel.lanes import INTERNAL_COMPILE_OPTIONS
from overturning.dem.quiet import MAX_REST_LIMIT_TO_ONSET_ACCELERATION_RATIO, SIMULATION_START_TO_ONSET_THRESHOLD_RATIO
from overturning.dem.stack.access import (
    VALUE_COUNT_PER_CASE_IN_ALL_LANES,
    VALUE_COUNT_PER_JOINT_IN_ALL_LANES,
    VALUE_COUNT_PER_POINT_IN_ALL_LANES,
    VALUE_COUNT_PER_STONE_IN_ALL_LANES,
    load_case_progress,
    load_clock_within_sample,
    load_energy_account,
    load_face_corner,
    load_fall_flags_and_last_upright_time,
    load_joint_constants,
    load_joint_state_at_step_start,
    load_peaks_and_last_upright_tick,
    load_stone_constants,
    load_stone_state,
    load_tick_length_failure_and_rest_limits,
    slice_stone_rows,
    store_energy_account,
    store_fall_flags_and_last_upright_time,
)
from overturning.dem.stack.energy import (
    energy_of_unfallen_stones_and_contact_springs,
    pose_relative_to_stone_below,
    stack_energy_is_too_small_to_overturn,
    stone_kinetic_energy,
    stone_state_sum_for_finite_check,
)
from overturning.dem.stack.rest import (
    all_points_under_unfallen_stones_carry_load,
    onset_acceleration_g_of_current_stack_state,
    time_until_upright_stack_stops_sliding,
)
from overturning.dem.stack.state import (
    CASE_ROW_LAYOUT,
    StackEnergyAccountAndPeakPenetration,
    StoneFallState,
)
from overturning.dem.stack.step import state_array_length_per_joint
from overturning.model.status import CaseStatus

INITIAL_ENERGY_ROW_OFFSET = CASE_ROW_LAYOUT.row_offset_of_field(CaseProgress, "initial_energy")
CURRENT_SAMPLE_ROW_OFFSET = CASE_ROW_LAYOUT.row_offset_of_field(CaseProgress, "current_sample")
SLIDING_CASE_END_SAMPLE_ROW_OFFSET = CASE_ROW_LAYOUT.row_offset_of_field(
    LastSampleOfContinuedSlidingCase, "end_sample_while_sliding_or_zero_if_unknown"
)


MIN_ONSET_TO_LONG_STEP_LIMIT_RATIO_AT_CASE_END: Final = (
    SIMULATION_START_TO_ONSET_THRESHOLD_RATIO / MAX_REST_LIMIT_TO_ONSET_ACCELERATION_RATIO**2
)
"""Least acceleration that may move a stack when its case ends, over `max_base_acceleration_for_sample_long_steps_g`.

The rest of the record then stays below the part `MAX_REST_LIMIT_TO_ONSET_ACCELERATION_RATIO` of this acceleration."""

MIN_RELATIVE_CORNER_DEPTH_TO_FALL_OVER_RIM: Final = 0.001
"""Depth of a corner of a leaning stone below the face that carries it, as a share of the height of its centre.

Beyond this depth, and beyond the critical angle of its base, the stone tips over the rim of the face, and has fallen.
Between the critical angle of its contact at rest and that of its base, a stone that overhangs may still come back."""


@njit(**INTERNAL_COMPILE_OPTIONS)
def base_corner_hangs_below_supporting_face(
    stack_states: Any, lane: int, stone_index: int, stone_count: int, max_corner_count_per_face: int
) -> bool:
    """True if a corner of a stone's base lies below its supporting face by over 0.001 × the height of its centre."""
    below, lower, rows = (
        slice_stone_rows(stack_states, stone_index - 1),
        load_stone_constants(slice_stone_rows(stack_states, stone_index - 1), lane),
        slice_stone_rows(stack_states, stone_index),
    )  # fmt: skip
    upper, stone, base = load_stone_constants(rows, lane), load_stone_state(rows, lane), load_stone_state(below, lane)
    axes = rotation_matrix(base.rotation)
    apart, turn = pose_relative_to_stone_below(stone, base.centre_position, axes)
    at = (
        VALUE_COUNT_PER_CASE_IN_ALL_LANES
        + stone_count * VALUE_COUNT_PER_STONE_IN_ALL_LANES
        + stone_index * state_array_length_per_joint(max_corner_count_per_face)
        + VALUE_COUNT_PER_JOINT_IN_ALL_LANES
    )
    lowest = 0.0
    for i in range(
        int(
            load_joint_constants(
                stack_states[at - VALUE_COUNT_PER_JOINT_IN_ALL_LANES : at], lane
            ).upper_base_corner_count
        )
    ):
        corner = load_face_corner(
            stack_states[
                at + i * VALUE_COUNT_PER_POINT_IN_ALL_LANES : at + (i + 1) * VALUE_COUNT_PER_POINT_IN_ALL_LANES
            ],
            lane,
        )
        height = (
            turn.zx * corner.x_from_face_centre + turn.zy * corner.y_from_face_centre
        ) - upper.centre_height * turn.zz
        lowest = min(lowest, apart.z - lower.upper_face_height_above_centre + height)
    return lowest < -MIN_RELATIVE_CORNER_DEPTH_TO_FALL_OVER_RIM * upper.centre_height


@njit(**INTERNAL_COMPILE_OPTIONS)
def centre_depth_below_rest_along_face_normal(stack_states: Any, lane: int, stone_index: int) -> float:
    """Return how far a stone's centre lies below its position at rest on its support, along the face's normal, m."""
    rows = slice_stone_rows(stack_states, stone_index)
    upper, stone = load_stone_constants(rows, lane), load_stone_state(rows, lane)
    if stone_index == 0:
        return upper.centre_height - stone.centre_position.z
    below = slice_stone_rows(stack_states, stone_index - 1)
    base = load_stone_state(below, lane)
    apart, _ = pose_relative_to_stone_below(stone, base.centre_position, rotation_matrix(base.rotation))
    return load_stone_constants(below, lane).upper_face_height_above_centre + upper.centre_height - apart.z


@njit(**INTERNAL_COMPILE_OPTIONS)
def lowest_newly_fallen_stone_index(
    stack_states: Any, lane: int, stone_count: int, max_corner_count_per_face: int
) -> int:
    """Return the index of the lowest fallen stone that is still simulated; the number of stones if there is none."""
    for s in range(stone_count):
        rows = slice_stone_rows(stack_states, s)
        if not load_fall_flags_and_last_upright_time(rows, lane).is_still_simulated > 0.0:
            continue
        constants, stone = load_stone_constants(rows, lane), load_stone_state(rows, lane)
        axes = rotation_matrix(stone.rotation)
        if (
            axes.zz <= constants.fall_tilt_cosine
            or centre_depth_below_rest_along_face_normal(stack_states, lane, s) > constants.max_centre_drop_without_fall
        ):
            return s
        leans = (
            s > 0
            and squared_sine_of_lean_continued_beyond_90_deg(axes) > constants.critical_lean_squared_sine_on_whole_base
        )
        if leans and base_corner_hangs_below_supporting_face(
            stack_states, lane, s, stone_count, max_corner_count_per_face
        ):
            return s
    return stone_count


@njit(**INTERNAL_COMPILE_OPTIONS)
def stop_fallen_and_upper_stones_true_if_none_left(
    stack_states: Any,
    lane: int,
    stone_count: int,
    max_corner_count_per_face: int,
    ticks_per_sample: float,
    zero_energy_height_by_stone: Any,
) -> bool:
    """Stop the simulation of the lowest fallen stone and of all stones above it; True if no stone remains.

    The energy account counts the energy of the stopped stones as removed.
    """
    fallen = lowest_newly_fallen_stone_index(stack_states, lane, stone_count, max_corner_count_per_face)
    if fallen == stone_count:
        return False
    before = energy_of_unfallen_stones_and_contact_springs(
        stack_states, lane, stone_count, max_corner_count_per_face, zero_energy_height_by_stone
    )
    start_of_sample = load_case_progress(stack_states, lane).current_sample * ticks_per_sample
    tick = load_tick_length_failure_and_rest_limits(stack_states, lane).tick_length_s
    for s in range(fallen, stone_count):
        rows = slice_stone_rows(stack_states, s)
        outcome, constants = load_fall_flags_and_last_upright_time(rows, lane), load_stone_constants(rows, lane)
        if not outcome.is_still_simulated > 0.0:
            continue
        last = load_peaks_and_last_upright_tick(rows, lane).last_upright_tick_in_sample
        upright_until = (start_of_sample + last) * tick if last >= 0.0 else outcome.last_upright_time_s
        slid_off = (
            squared_sine_of_lean_continued_beyond_90_deg(rotation_matrix(load_stone_state(rows, lane).rotation))
            < constants.critical_lean_squared_sine_on_contact_at_rest
        )
        slid_off = slid_off or (
            s > 0
            and base_corner_hangs_below_supporting_face(stack_states, lane, s, stone_count, max_corner_count_per_face)
        )
        store_fall_flags_and_last_upright_time(rows, lane, StoneFallState(
            0.0, upright_until, 1.0 if slid_off and s == fallen else 0.0
        ))  # fmt: skip
    account = load_energy_account(stack_states, lane)
    gone = before - energy_of_unfallen_stones_and_contact_springs(
        stack_states, lane, stone_count, max_corner_count_per_face, zero_energy_height_by_stone
    )
    store_energy_account(
        stack_states,
        lane,
        StackEnergyAccountAndPeakPenetration(
            account.base_motion_work,
            account.dissipated_or_removed_energy + gone,
            account.base_motion_power_at_step_end,
            account.dissipated_power_at_step_end,
            account.peak_penetration,
        ),
    )
    return fallen == 0


@njit(**INTERNAL_COMPILE_OPTIONS)
def end_simulation_of_fallen_stones_and_return_status(
    stack_states: Any,
    lane: int,
    stone_count: int,
    max_corner_count_per_face: int,
    ticks_per_sample: float,
    record_sample_count: float,
    stone_table_rows: Any,
) -> int:
    """Stop simulating a fallen stone and those above it; return the `CaseStatus` after a sample, or `CASE_NOT_ENDED`.

    `stone_table_rows` has the rows of the stack in the kernel's table of stones.
    """
    case = load_tick_length_failure_and_rest_limits(stack_states, lane)
    course = load_case_progress(stack_states, lane)
    time = load_clock_within_sample(stack_states, lane)
    kinetic, loaded = 0.0, True
    first, size = (
        VALUE_COUNT_PER_CASE_IN_ALL_LANES + stone_count * VALUE_COUNT_PER_STONE_IN_ALL_LANES,
        state_array_length_per_joint(max_corner_count_per_face),
    )
    for s in range(stone_count):
        rows = slice_stone_rows(stack_states, s)
        if not load_fall_flags_and_last_upright_time(rows, lane).is_still_simulated > 0.0:
            continue
        stone = load_stone_state(rows, lane)
        if not np.isfinite(stone_state_sum_for_finite_check(stone)):
            return CaseStatus.UNSTABLE
        kinetic += stone_kinetic_energy(load_stone_constants(rows, lane), stone)
        at = first + s * size
        loaded = (
            loaded
            and load_joint_state_at_step_start(
                stack_states[at : at + VALUE_COUNT_PER_JOINT_IN_ALL_LANES], lane
            ).normal_force
            > 0.0
        )
    if load_energy_account(stack_states, lane).peak_penetration > case.max_penetration:
        return CaseStatus.UNSTABLE
    if stop_fallen_and_upper_stones_true_if_none_left(
        stack_states,
        lane,
        stone_count,
        max_corner_count_per_face,
        ticks_per_sample,
        stone_table_rows.centre_height_at_rest,
    ):
        return CaseStatus.SIMULATED
    sample = course.current_sample + time.ticks_since_sample_start / ticks_per_sample
    if (
        sample >= min(course.cannot_start_moving_from_sample, record_sample_count)
        and kinetic < case.max_kinetic_energy_at_rest
        and loaded
        and all_points_under_unfallen_stones_carry_load(stack_states, lane, stone_count, max_corner_count_per_face)
    ):
        # The rest of the record is weak for the stack as it stood at first; it may have lost a stone since, or slid.
        least = MIN_ONSET_TO_LONG_STEP_LIMIT_RATIO_AT_CASE_END * case.max_base_acceleration_for_sample_long_steps_g
        if (
            sample >= record_sample_count
            or onset_acceleration_g_of_current_stack_state(stack_states, lane, stone_count, max_corner_count_per_face)
            >= least
        ):
            return CaseStatus.SIMULATED
    if sample < course.end_sample_if_undecided or sample < record_sample_count:
        return CASE_NOT_ENDED
    # An upright stack that slides is simulated until friction has stopped it.
    sliding_time = time_until_upright_stack_stops_sliding(stack_states, lane, stone_count, max_corner_count_per_face)
    if set_slide_end_once_and_check_case_continues(
        stack_states,
        SLIDING_CASE_END_SAMPLE_ROW_OFFSET + lane,
        sample,
        sliding_time,
        case.tick_length_s * ticks_per_sample,
    ):
        return CASE_NOT_ENDED
    stands = stack_energy_is_too_small_to_overturn(stack_states, lane, max_corner_count_per_face, stone_table_rows)
    return CaseStatus.SIMULATED if stands else CaseStatus.UNDECIDED


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_stack_results(
    stack_states: Any,
    lane: int,
    stone_count: int,
    max_corner_count_per_face: int,
    status: int,
    zero_energy_height_by_stone: Any,
    result_row: Any,
    stone_result_rows: Any,
) -> None:
    """Write the results of the case in column `lane` to `result_row`, those of its stones to `stone_result_rows`."""
    account, course = load_energy_account(stack_states, lane), load_case_progress(stack_states, lane)
    energy = energy_of_unfallen_stones_and_contact_springs(
        stack_states, lane, stone_count, max_corner_count_per_face, zero_energy_height_by_stone
    )
    balance = (energy - course.initial_energy) - account.base_motion_work + account.dissipated_or_removed_energy
    result_row.energy_error = abs(balance) / max(account.base_motion_work, course.energy_needed_to_overturn)
    result_row.peak_penetration = account.peak_penetration
    below, axes = Vector3(0.0, 0.0, 0.0), Matrix3(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
    for s in range(stone_count):
        rows = slice_stone_rows(stack_states, s)
        constants = load_stone_constants(rows, lane)
        stone = load_stone_state(rows, lane)
        outcome = load_fall_flags_and_last_upright_time(rows, lane)
        own = rotation_matrix(stone.rotation)
        fallen = not outcome.is_still_simulated > 0.0 and status == CaseStatus.SIMULATED
        stone_result_rows[s].fallen = 1.0 if fallen else 0.0
        stone_result_rows[s].slid_off_support = outcome.slid_off_support
        stone_result_rows[s].last_upright_time_if_fallen = outcome.last_upright_time_s if fallen else np.nan
        stone_result_rows[s].peak_lean_as_continued_squared_sine = max(
            load_peaks_and_last_upright_tick(rows, lane).peak_lean_as_continued_squared_sine,
            squared_sine_of_lean_continued_beyond_90_deg(own),
        )
        place, turn = pose_relative_to_stone_below(stone, below, axes)
        stone_result_rows[s].slip_x_on_support_at_end, stone_result_rows[s].slip_y_on_support_at_end = (
            place.x - constants.centre_height * turn.xz, place.y - constants.centre_height * turn.yz,
        )  # fmt: skip
        # The axes of what the stone stands on, seen along its normal; not by angles, whose last digits differ.
        cosine, sine = axes.xx + axes.yy, axes.yx - axes.xy
        one = 1.0 / math.sqrt(cosine * cosine + sine * sine)
        stone_result_rows[s].support_twist_cosine, stone_result_rows[s].support_twist_sine = one * cosine, one * sine
        stone_result_rows[s].twist_relative_to_support_rad = math.atan2(turn.yx - turn.xy, turn.xx + turn.yy)
        stone_result_rows[s].stone_axis_unit_vector_x_at_end, stone_result_rows[s].stone_axis_unit_vector_y_at_end = (
            own.xz,
            own.yz,
        )
        below, axes = stone.centre_position, own
