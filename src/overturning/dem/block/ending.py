"""Termination of a case of a single block: its energy, the tests for its end, and its results (docs/method.md)."""

from typing import Any

import numpy as np
from numba import njit

from overturning.dem.block.access import (
    LARGEST_TILT_RATIO_AT_END_ROW_OFFSET,
    load_accelerations_from_base_motion,
    load_block_constants,
    load_block_state,
    load_case_progress,
    load_energy_account,
    load_peaks_and_last_upright_tick,
)
from overturning.dem.block.state import (
    TICKS_PER_WHOLE_STEP,
    BlockConstants,
    BlockState,
    displacement_of_block_lower_side_middle,
)
from overturning.dem.kernel.ending import (
    CASE_NOT_ENDED,
    MAX_KINETIC_ENERGY_AT_REST_OVER_MG_HALF_WIDTH,
    MAX_LATE_TILT_RATIO_COUNTED_AS_STANDING,
    NEGLIGIBLE_REMAINING_SLIP_M,
    largest_tilt_ratio_in_second_half_after_record,
)
from overturning.dem.kernel.lanes import INLINE_OPTIONS, INTERNAL_COMPILE_OPTIONS
from overturning.model.status import CaseStatus
from overturning.units import STANDARD_GRAVITY as GRAVITY


@njit(**INLINE_OPTIONS)
def velocities_at_time_of_position(
    block: BlockConstants, state: BlockState, velocity_lag_behind_position_in_steps: float
) -> tuple[float, float, float]:
    """Return a block's velocities (x, z, angular) at the time of its position; the stored velocities may lag behind."""
    time = velocity_lag_behind_position_in_steps * TICKS_PER_WHOLE_STEP * block.seconds_per_tick
    return (
        state.centre_vx + time * state.centre_ax,
        state.centre_vz + time * state.centre_az,
        state.angular_velocity + time * state.angular_acceleration,
    )


@njit(**INLINE_OPTIONS)
def block_mechanical_energy_per_mass(
    block: BlockConstants, state: BlockState, velocity_lag_behind_position_in_steps: float
) -> float:
    """Return the kinetic (relative to the base), gravitational and spring energy of a block per mass, m²/s²."""
    vx, vz, vw = velocities_at_time_of_position(block, state, velocity_lag_behind_position_in_steps)
    motion = (vx * vx + vz * vz) + vw * vw / block.mass_over_moment_of_inertia
    ul, ur, tl, tr = (
        max(state.left.penetration, 0.0),
        max(state.right.penetration, 0.0),
        state.left.tangential_stretch,
        state.right.tangential_stretch,
    )
    springs = block.normal_stiffness_per_mass * (ul * ul + ur * ur) + block.tangential_stiffness_per_mass * (
        tl * tl + tr * tr
    )
    return float(0.5 * (motion + springs) + GRAVITY * (state.centre_z - block.half_height))


@njit(**INLINE_OPTIONS)
def energy_per_mass_to_tilt_block(block: BlockConstants, tilt_angle_rad: float) -> float:
    """Return the energy per mass (m²/s²) that tilts a rigid block from rest to `tilt_angle_rad` (at most α)."""
    angle = min(tilt_angle_rad, block.critical_angle)
    square = angle * angle
    sine = angle * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0)))
    versine = square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0)))
    return float(GRAVITY * (block.half_width * sine - block.half_height * versine))


@njit(**INLINE_OPTIONS)
def results_of_block_on_resting_base_are_final(
    block: BlockConstants,
    state: BlockState,
    max_abs_angle_so_far_rad: float,
    overturning_energy_per_mass: float,
    velocity_lag_behind_position_in_steps: float,
) -> bool:
    """True if a block on a resting base can no longer fall, exceed its peak rotation, or slide further (if μ > 0)."""
    now = block_mechanical_energy_per_mass(block, state, velocity_lag_behind_position_in_steps)
    if not (now < overturning_energy_per_mass and abs(state.angle) < block.critical_angle):
        return False
    # It can no longer fall, but its peak rotation is final only if its energy cannot reach it again. On one corner the
    # weight compresses the spring: g²/2k less energy than in the rigid block.
    if now + 0.5 * GRAVITY * GRAVITY / block.normal_stiffness_per_mass > energy_per_mass_to_tilt_block(
        block, max_abs_angle_so_far_rad
    ):
        return False
    # Let it slide to its end; without friction it never stops.
    return (
        abs(signed_remaining_slide_or_zero_if_frictionless(block, state)) < NEGLIGIBLE_REMAINING_SLIP_M
        or block.friction == 0.0
    )


@njit(**INLINE_OPTIONS)
def signed_remaining_slide_or_zero_if_frictionless(block: BlockConstants, state: BlockState) -> float:
    """Return the signed distance (m) that a block still slides along x until friction stops it; 0 if μ = 0.

    It is v²/2μg, with the velocity v of the middle of the block's lower side relative to the base.
    """
    speed = state.centre_vx - block.half_height * state.cos * state.angular_velocity
    return float(speed * abs(speed) / (2.0 * GRAVITY * block.friction) if block.friction > 0.0 else 0.0)


@njit(**INTERNAL_COMPILE_OPTIONS)
def update_late_largest_tilt_and_return_case_status(
    state: Any,
    lane: int,
    velocity_lag_behind_position_in_steps: float,
    ticks_per_sample: float,
    record_end_sample: float,
    max_penetration_to_half_side_ratio: float,
) -> int:
    """Return the `CaseStatus` of the case in column `lane`, or `CASE_NOT_ENDED`; update its largest late tilt.

    The late tilt is the tilt over the critical angle in the second half of the time after the record.
    """
    block, s, peaks, course = (
        load_block_constants(state, lane),
        load_block_state(state, lane),
        load_peaks_and_last_upright_tick(state, lane),
        load_case_progress(state, lane),
    )
    if not np.isfinite(s.centre_vx + s.centre_vz + s.angular_velocity + s.centre_x + s.centre_z + s.cos + s.sin):
        return CaseStatus.UNSTABLE
    if peaks.max_corner_penetration > max_penetration_to_half_side_ratio * min(block.half_width, block.half_height):
        return CaseStatus.UNSTABLE
    if s.cos <= 0.0:
        return CaseStatus.SIMULATED
    sample = course.current_sample + s.ticks_since_sample_start / ticks_per_sample
    if sample >= course.cannot_start_moving_from_sample and s.left.penetration > 0.0 and s.right.penetration > 0.0:
        # A block that rests on both corners after the last time at which it could start to move stays there.
        kinetic = 0.5 * (
            s.centre_vx * s.centre_vx
            + s.centre_vz * s.centre_vz
            + s.angular_velocity * s.angular_velocity / block.mass_over_moment_of_inertia
        )
        if kinetic < MAX_KINETIC_ENERGY_AT_REST_OVER_MG_HALF_WIDTH * GRAVITY * block.half_width:
            return CaseStatus.SIMULATED
    if sample < record_end_sample:
        return CASE_NOT_ENDED
    if results_of_block_on_resting_base_are_final(
        block, s, peaks.max_abs_angle, course.energy_needed_to_overturn, velocity_lag_behind_position_in_steps
    ):
        return CaseStatus.SIMULATED
    tilt, rise = abs(s.angle) / block.critical_angle, s.centre_z - block.half_height
    late_tilt = largest_tilt_ratio_in_second_half_after_record(
        state[LARGEST_TILT_RATIO_AT_END_ROW_OFFSET + lane], course, sample, record_end_sample, tilt, rise
    )
    state[LARGEST_TILT_RATIO_AT_END_ROW_OFFSET + lane] = late_tilt
    if sample < course.end_sample_if_undecided:
        return CASE_NOT_ENDED
    stands = (
        block_mechanical_energy_per_mass(block, s, velocity_lag_behind_position_in_steps)
        < course.energy_needed_to_overturn
        and tilt < 1.0
    )
    return (
        CaseStatus.SIMULATED if stands or late_tilt < MAX_LATE_TILT_RATIO_COUNTED_AS_STANDING else CaseStatus.UNDECIDED
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_case_results_except_status_and_counters(
    state: Any,
    lane: int,
    status: int,
    velocity_lag_behind_position_in_steps: float,
    ticks_per_sample: float,
    result_row_out: Any,
) -> None:
    """Write the results of the case in column `lane`, except status and counters, into a row of the result table."""
    block, s, peaks = (
        load_block_constants(state, lane),
        load_block_state(state, lane),
        load_peaks_and_last_upright_tick(state, lane),
    )
    account, course = load_energy_account(state, lane), load_case_progress(state, lane)
    fallen = status == CaseStatus.SIMULATED and s.cos <= 0.0
    result_row_out.overturned = (1.0 if s.angle > 0.0 else -1.0) if fallen else 0.0
    result_row_out.overturning_time = course.last_time_below_critical_angle if fallen else np.nan
    # The angle sums up rotations, the cosine multiplies them: in steps of 0.25 rad they differ by 0.1 %.
    result_row_out.peak_rotation = (
        0.5 * np.pi if fallen else min(peaks.max_abs_angle, 0.5 * np.pi)
    ) / block.critical_angle
    peak_slip, residual_slip = (
        peaks.max_abs_base_slip,
        displacement_of_block_lower_side_middle(block, s.centre_x, s.sin),
    )
    if (
        status == CaseStatus.SIMULATED
        and not fallen
        and course.current_sample + s.ticks_since_sample_start / ticks_per_sample >= course.end_sample_if_undecided
    ):
        residual_slip += signed_remaining_slide_or_zero_if_frictionless(block, s)
        peak_slip = max(peak_slip, abs(residual_slip))
    result_row_out.peak_slip, result_row_out.residual_slip = peak_slip, residual_slip
    result_row_out.peak_penetration = peaks.max_corner_penetration
    balance = (
        (block_mechanical_energy_per_mass(block, s, velocity_lag_behind_position_in_steps) - course.initial_energy)
        - account.base_motion_work_per_mass
        + account.lost_energy_per_mass
    )
    result_row_out.energy_error = abs(balance) / max(
        account.base_motion_work_per_mass, course.energy_needed_to_overturn
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_block_trajectory_row(
    state: Any,
    lane: int,
    velocity_lag_behind_position_in_steps: float,
    sampling_interval: float,
    ticks_per_sample: float,
    trajectory_row_out: Any,
) -> None:
    """Write the block's motion, from column `lane` of the state array, into a row of its trajectory."""
    block, s, push = (
        load_block_constants(state, lane),
        load_block_state(state, lane),
        load_accelerations_from_base_motion(state, lane).negative_of_base_acceleration_x,
    )
    trajectory_row_out.time = (
        load_case_progress(state, lane).current_sample + s.ticks_since_sample_start / ticks_per_sample
    ) * sampling_interval
    trajectory_row_out.centre_x, trajectory_row_out.centre_z, trajectory_row_out.angle = s.centre_x, s.centre_z, s.angle
    trajectory_row_out.centre_vx, trajectory_row_out.centre_vz, trajectory_row_out.angular_velocity = (
        velocities_at_time_of_position(block, s, velocity_lag_behind_position_in_steps)
    )
    trajectory_row_out.ground_acceleration = -(
        push.value_at_sample_start + push.slope_per_tick * s.ticks_since_sample_start
    )
