"""Slip of elements on their supports, and last times upright and supported: stored between attempted steps."""

from typing import Any

from numba import njit

from overturning.dem.kernel.lanes import INLINE_OPTIONS, INTERNAL_COMPILE_OPTIONS, NO_ALIAS_COMPILE_OPTIONS, select
from overturning.dem.kernel.mechanics import updated_maximum
from overturning.dem.polygon import rows
from overturning.dem.polygon.faces import rotate_to_scene_axes
from overturning.dem.polygon.resting import count_closed_contact_points
from overturning.dem.polygon.state import (
    ElementRestPoseAndSlipMeasurementPoints,
    ElementSlipFallSideAndLastUprightTime,
    Pose,
)


@njit(**INLINE_OPTIONS)
def element_point_in_scene_axes(
    element_pose: Pose, x_from_centre_in_element_axes: float, z_from_centre_in_element_axes: float
) -> tuple[float, float]:
    """Return the scene coordinates (m) of a point given in the element's own axes, relative to its centre."""
    x, z = rotate_to_scene_axes(element_pose, x_from_centre_in_element_axes, z_from_centre_in_element_axes)
    return element_pose.x + x, element_pose.z + z


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def shift_rest_position_by_motion_of_held_support(element_state_rows: Any, support_state_rows: Any) -> None:
    """Shift an element's rest position by the motion, relative to the base, of its support that is held in space."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        pose, at, home = (
            rows.load_pose(support_state_rows, j),
            rows.load_rest_pose_and_slip_measurement_points(support_state_rows, j),
            rows.load_rest_pose_and_slip_measurement_points(element_state_rows, j),
        )
        x, z = pose.x - at.centre_x, pose.z - at.centre_z
        rows.store_rest_pose_and_slip_measurement_points(element_state_rows, j, ElementRestPoseAndSlipMeasurementPoints(
            home.slip_reference_point_x_in_element_axes, home.base_point_z_in_element_axes,
            home.base_point_x_in_support_axes, home.base_point_z_in_support_axes,
            home.centre_x + x, home.centre_z + z, home.fallen_if_centre_z_below + z,
        ))  # fmt: skip


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def store_slip_and_last_time_rotation_recoverable(
    element_state_rows: Any,
    support_state_rows: Any,
    scene_state_rows: Any,
    samples_per_tick: float,
    sampling_interval: float,
) -> None:
    """Store an element's slip on its support, and the last time at which it could come back from its rotation."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        item, support, sample = (
            rows.load_element_state(element_state_rows, j), rows.load_pose(support_state_rows, j),
            rows.load_scene_state(scene_state_rows, j).current_sample,
        )  # fmt: skip
        old, home, passed = (
            item.slip_fall_side_and_last_upright_time,
            item.rest_pose_and_slip_measurement_points,
            item.step_motion_with_work_and_peaks_so_far.last_recoverable_tick_in_sample,
        )
        x, z = element_point_in_scene_axes(
            item.pose, home.slip_reference_point_x_in_element_axes, home.base_point_z_in_element_axes
        )
        ox, oz = element_point_in_scene_axes(
            support, home.base_point_x_in_support_axes, home.base_point_z_in_support_axes
        )
        slip = support.cos * (x - ox) - support.sin * (z - oz)
        stood = (passed >= 0.0) & (old.fall_side == 0.0) & (item.pose.z >= home.fallen_if_centre_z_below)
        upright = select(
            stood,
            (sample + passed * samples_per_tick) * sampling_interval,
            old.last_time_recoverable_and_above_fall_limit,
        )
        rows.store_slip_and_fall_state(
            element_state_rows,
            j,
            ElementSlipFallSideAndLastUprightTime(
                upright,
                old.last_time_on_support,
                old.fall_side,
                updated_maximum(old.peak_slip_on_support, abs(slip)),
                slip,
            ),
        )
        element_state_rows[rows.LAST_TICK_ABLE_TO_RETURN_UPRIGHT_ROW_OFFSET + j] = -1.0


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def store_support_time_of_upper_element_if_touching(
    pair_state_rows: Any,
    element_a_state_rows: Any,
    element_b_state_rows: Any,
    scene_state_rows: Any,
    samples_per_tick: float,
    sampling_interval: float,
) -> None:
    """Store the present time as the upper element's last time on its support, if two stacked elements touch."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        pair, case = rows.load_pair_state(pair_state_rows, j), rows.load_scene_state(scene_state_rows, j)
        touches = count_closed_contact_points(pair) > 0
        now = (
            case.current_sample + case.base_acceleration.ticks_since_sample_start * samples_per_tick
        ) * sampling_interval
        element_a_state_rows[rows.LAST_TIME_ON_SUPPORT_ROW_OFFSET + j] = select(
            touches & (pair.rest_support_sign_plus_if_a_on_b > 0.0),
            now,
            element_a_state_rows[rows.LAST_TIME_ON_SUPPORT_ROW_OFFSET + j],
        )
        element_b_state_rows[rows.LAST_TIME_ON_SUPPORT_ROW_OFFSET + j] = select(
            touches & (pair.rest_support_sign_plus_if_a_on_b < 0.0),
            now,
            element_b_state_rows[rows.LAST_TIME_ON_SUPPORT_ROW_OFFSET + j],
        )


@njit(**INTERNAL_COMPILE_OPTIONS)
def update_rest_poses_slips_and_sample_clock(
    case_states: Any, scene_arrays: Any, ticks_per_sample: float, sampling_interval: float
) -> None:
    """Update rest positions, slips, last times upright and on support; start the next sample where one has ended."""
    limits = scene_arrays.fall_and_support_table[0]
    for i in range(limits.size):
        held = int(limits[i].index_of_held_element_at_stack_bottom)
        if held >= 0 and limits[i].is_free > 0.0:
            shift_rest_position_by_motion_of_held_support(
                rows.slice_element_rows(case_states, i), rows.slice_element_rows(case_states, held)
            )
    for i in range(limits.size):
        if limits[i].index_of_held_element_at_stack_bottom == i:
            shift_rest_position_by_motion_of_held_support(
                rows.slice_element_rows(case_states, i), rows.slice_element_rows(case_states, i)
            )
    for i in range(limits.size):
        if limits[i].is_free > 0.0:
            on = rows.slice_element_rows(case_states, int(limits[i].first_support_or_own_element_index))
            store_slip_and_last_time_rotation_recoverable(
                rows.slice_element_rows(case_states, i), on, case_states, 1.0 / ticks_per_sample, sampling_interval
            )
    for p in range(scene_arrays.pair_element_and_piece_indices.shape[0]):
        q, a, b = rows.slice_pair_and_element_rows(case_states, scene_arrays, p)
        store_support_time_of_upper_element_if_touching(q, a, b, case_states, 1.0 / ticks_per_sample, sampling_interval)
    for j in range(rows.PARALLEL_CASE_COUNT):
        sample, tick = (
            case_states[rows.CURRENT_SAMPLE_ROW_OFFSET + j],
            case_states[rows.TICKS_SINCE_SAMPLE_START_ROW_OFFSET + j],
        )
        case_states[rows.CURRENT_SAMPLE_ROW_OFFSET + j] = sample + 1.0 if tick >= ticks_per_sample else sample
        case_states[rows.TICKS_SINCE_SAMPLE_START_ROW_OFFSET + j] = (
            tick - ticks_per_sample if tick >= ticks_per_sample else tick
        )
