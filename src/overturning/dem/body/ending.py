"""Termination of a 3-D case: its energy, the tests for its end, and its results (docs/method.md)."""

from typing import Any

import numpy as np
from numba import njit

from overturning.dem.body.access import (
    LARGEST_TILT_RATIO_AFTER_RECORD_ROW_OFFSET,
    NEXT_STEP_TICKS_ROW_OFFSET,
    SLIDING_CASE_END_SAMPLE_ROW_OFFSET,
    VALUE_COUNT_PER_VERTEX_IN_ALL_LANES,
    load_body_constants,
    load_body_state,
    load_case_progress,
    load_energy_account,
    load_inertial_and_upward_base_accelerations,
    load_peaks_and_last_upright_tick,
    load_point_state_at_step_start,
    load_termination_limits,
)
from overturning.dem.body.rotation import angular_velocity_of_state
from overturning.dem.body.state import (
    BodyConstants,
    BodyState,
    BodyTerminationLimits,
    squared_sine_of_lean_continued_beyond_90_deg,
)
from overturning.dem.body.vectors import (
    Matrix3,
    Vector3,
    cross_product,
    dot_product,
    expand_symmetric_matrix,
    matrix_times_vector,
    plus,
    rotation_matrix,
    vector_length,
)
from overturning.dem.kernel.ending import (
    CASE_NOT_ENDED,
    MAX_KINETIC_ENERGY_AT_REST_OVER_MG_HALF_WIDTH,
    MAX_LATE_TILT_RATIO_COUNTED_AS_STANDING,
    MAX_TILT_RATIO_AT_REST,
    NEGLIGIBLE_REMAINING_SLIP_M,
    body_is_still,
    largest_tilt_ratio_in_second_half_after_record,
    set_slide_end_once_and_check_case_continues,
)
from overturning.dem.kernel.ground import base_acceleration_at_tick
from overturning.dem.kernel.lanes import INLINE_OPTIONS, INTERNAL_COMPILE_OPTIONS
from overturning.model.status import CaseStatus
from overturning.units import STANDARD_GRAVITY as GRAVITY


@njit(**INLINE_OPTIONS)
def twice_kinetic_energy_per_mass(body: BodyConstants, state: BodyState) -> float:
    """Return twice the kinetic energy of a body per mass, m²/s²."""
    return dot_product(state.velocity_relative_to_base, state.velocity_relative_to_base) + dot_product(
        state.angular_momentum_per_mass, angular_velocity_of_state(body, state)
    )


@njit(**INLINE_OPTIONS)
def state_sum_for_finite_check(state: BodyState) -> float:
    """Return the sum of all position, rotation and velocity components of a body, which is finite if each one is."""
    v, p, q = state.velocity_relative_to_base, state.centre_position, state.rotation
    return (v.x + v.y + v.z) + (p.x + p.y + p.z) + (q.w + q.x + q.y + q.z)


@njit(**INTERNAL_COMPILE_OPTIONS)
def kinetic_gravity_and_spring_energy_per_mass(
    body: BodyConstants, state: BodyState, vertex_rows: Any, vertex_count: int, lane: int
) -> float:
    """Return a body's kinetic, gravitational (0 if upright without penetration) and spring energy per mass, m²/s²."""
    springs = 0.0
    for i in range(vertex_count):
        one = load_point_state_at_step_start(
            vertex_rows[i * VALUE_COUNT_PER_VERTEX_IN_ALL_LANES : (i + 1) * VALUE_COUNT_PER_VERTEX_IN_ALL_LANES], lane
        )
        depth = max(one.penetration, 0.0)
        springs += body.point_normal_stiffness_per_mass * depth * depth + body.point_tangential_stiffness_per_mass * (
            one.tangential_spring_stretch_x * one.tangential_spring_stretch_x
            + one.tangential_spring_stretch_y * one.tangential_spring_stretch_y
        )
    return 0.5 * (twice_kinetic_energy_per_mass(body, state) + springs) + GRAVITY * (
        state.centre_position.z - body.centre_height
    )


@njit(**INLINE_OPTIONS)
def vertical_angular_momentum_about_origin_per_mass(state: BodyState) -> float:
    """Return the vertical component of a body's angular momentum about the origin, per mass, m²/s."""
    return float(
        state.angular_momentum_per_mass.z
        + (
            state.centre_position.x * state.velocity_relative_to_base.y
            - state.centre_position.y * state.velocity_relative_to_base.x
        )
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def count_penetrating_vertices(vertex_rows: Any, vertex_count: int, lane: int) -> int:
    """Count the vertices of a body, in column `lane`, that penetrate the ground at the end of the last step."""
    number = 0
    for i in range(vertex_count):
        number += (
            1
            if load_point_state_at_step_start(
                vertex_rows[i * VALUE_COUNT_PER_VERTEX_IN_ALL_LANES : (i + 1) * VALUE_COUNT_PER_VERTEX_IN_ALL_LANES],
                lane,
            ).penetration
            > 0.0
            else 0
        )
    return number


@njit(**INLINE_OPTIONS)
def energy_per_mass_to_tilt_body_about_edge(
    body: BodyConstants, base_edge_distance_from_centre: float, tilt_squared_sine: float
) -> float:
    """Return the energy per mass (m²/s²) that tilts an upright body over a base edge to a given tilt.

    Beyond the critical tilt the energy is that for the critical tilt.
    """
    square = min(tilt_squared_sine, body.critical_lean_as_continued_squared_sine)
    return float(
        GRAVITY
        * (
            base_edge_distance_from_centre * np.sqrt(square)
            - body.centre_height * square / (1.0 + np.sqrt(1.0 - square))
        )
    )


@njit(**INLINE_OPTIONS)
def body_is_below_critical_tilt(body: BodyConstants, state: BodyState) -> bool:
    """True if the tilt of a body's vertical axis is below the critical angle."""
    return bool(
        squared_sine_of_lean_continued_beyond_90_deg(rotation_matrix(state.rotation))
        < body.critical_lean_as_continued_squared_sine
    )


@njit(**INLINE_OPTIONS)
def squared_base_speed_including_spin(body: BodyConstants, state: BodyState, radius_for_spin_speed: float) -> float:
    """Return the squared base speed v² + (ω r)² of a body, m²/s², from its translation and its spin.

    v is the horizontal velocity of the base, ω the spin about the vertical, and r the distance of a base edge
    (`radius_for_spin_speed`).
    """
    w, f = angular_velocity_of_state(body, state), rotation_matrix(state.rotation)
    v = plus(
        state.velocity_relative_to_base,
        cross_product(w, Vector3(-body.centre_height * f.xz, -body.centre_height * f.yz, -body.centre_height * f.zz)),
    )
    turn = w.z * radius_for_spin_speed
    return float((v.x * v.x + v.y * v.y) + turn * turn)


@njit(**INLINE_OPTIONS)
def body_will_slide_noticeably(body: BodyConstants, state: BodyState, base_edge_distance_from_centre: float) -> bool:
    """True if an upright body will slide or spin by `NEGLIGIBLE_REMAINING_SLIP_M` or more before friction stops it."""
    square = squared_base_speed_including_spin(body, state, base_edge_distance_from_centre)
    return bool(body.friction > 0.0 and square >= 2.0 * NEGLIGIBLE_REMAINING_SLIP_M * GRAVITY * body.friction)


@njit(**INLINE_OPTIONS)
def pseudo_angle_of_vector_0_to_4(x: float, y: float) -> float:
    """Return a number from 0 to 4 that grows with the angle of (x, y), anticlockwise from x, without trigonometry."""
    share = abs(x) / (abs(x) + abs(y))
    if y >= 0.0:
        return 1.0 - share if x >= 0.0 else 1.0 + share
    return 3.0 - share if x < 0.0 else 3.0 + share


@njit(**INTERNAL_COMPILE_OPTIONS)
def body_has_fallen(
    body_axes: Matrix3, termination_limits: BodyTerminationLimits, fall_limits_by_lean_sector: Any
) -> bool:
    """True if the tilt of a body has reached the angle of fall for the direction in which the body leans.

    For `fall_limits_by_lean_sector` see `overturning.model.solid.RigidSolid`.
    """
    if not body_axes.zz <= termination_limits.fall_tilt_cosine:
        return False
    if fall_limits_by_lean_sector.shape[0] == 0 or body_axes.zx * body_axes.zx + body_axes.zy * body_axes.zy == 0.0:
        return True
    turn, k = pseudo_angle_of_vector_0_to_4(-body_axes.zx, -body_axes.zy), 0
    while k + 1 < fall_limits_by_lean_sector.shape[0] and turn >= fall_limits_by_lean_sector[k + 1, 0]:
        k += 1
    return bool(
        -(
            (fall_limits_by_lean_sector[k, 1] * body_axes.zx + fall_limits_by_lean_sector[k, 2] * body_axes.zy)
            + fall_limits_by_lean_sector[k, 3] * body_axes.zz
        )
        >= fall_limits_by_lean_sector[k, 4]
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def update_peak_tilt_near_end_and_return_status(
    body_states: Any,
    vertex_rows: Any,
    base_vertex_count: int,
    lane: int,
    ticks_per_sample: float,
    record_sample_count: float,
    fall_limits_by_lean_sector: Any,
) -> int:
    """Return the `CaseStatus` of the case in column `lane`, or `CASE_NOT_ENDED`; update two stored values.

    These are `LargestTiltRatioInSecondHalfAfterRecord` and `LastSampleOfContinuedSlidingCase`.
    """
    count = vertex_rows.size // VALUE_COUNT_PER_VERTEX_IN_ALL_LANES
    body = load_body_constants(body_states, lane)
    s = load_body_state(body_states, lane)
    peaks = load_peaks_and_last_upright_tick(body_states, lane)
    course, limits = load_case_progress(body_states, lane), load_termination_limits(body_states, lane)
    if not np.isfinite(state_sum_for_finite_check(s)) or peaks.peak_penetration > limits.max_penetration:
        return CaseStatus.UNSTABLE
    if body_has_fallen(rotation_matrix(s.rotation), limits, fall_limits_by_lean_sector):
        return CaseStatus.SIMULATED
    sample = course.current_sample + s.ticks_since_sample_start / ticks_per_sample
    # A body that rests on its base after the last time at which it could start to move stays there.
    still = (
        0.5 * twice_kinetic_energy_per_mass(body, s)
        < MAX_KINETIC_ENERGY_AT_REST_OVER_MG_HALF_WIDTH * GRAVITY * limits.min_base_edge_distance_from_centre
    )
    if (
        sample >= course.cannot_start_moving_from_sample
        and still
        and count_penetrating_vertices(vertex_rows, count, lane) >= base_vertex_count
    ):
        return CaseStatus.SIMULATED
    if sample < record_sample_count:
        return CASE_NOT_ENDED
    now = kinetic_gravity_and_spring_energy_per_mass(body, s, vertex_rows, count, lane)
    stands = now < course.energy_needed_to_overturn and body_is_below_critical_tilt(body, s)
    # It can no longer fall, but its peak tilt is final only when its energy cannot reach it again. On one vertex the
    # weight compresses the spring: g²/2k less energy than in the rigid body.
    past = (
        now + 0.5 * GRAVITY * GRAVITY / body.point_normal_stiffness_per_mass
        <= energy_per_mass_to_tilt_body_about_edge(
            body, limits.min_base_edge_distance_from_centre, peaks.peak_lean_as_continued_squared_sine
        )
    )
    if stands and past and not body_will_slide_noticeably(body, s, limits.min_base_edge_distance_from_centre):
        return CaseStatus.SIMULATED
    tilt = np.sqrt(
        squared_sine_of_lean_continued_beyond_90_deg(rotation_matrix(s.rotation))
        / body.critical_lean_as_continued_squared_sine
    )
    rise = s.centre_position.z - body.centre_height
    late_tilt = largest_tilt_ratio_in_second_half_after_record(
        body_states[LARGEST_TILT_RATIO_AFTER_RECORD_ROW_OFFSET + lane], course, sample, record_sample_count, tilt, rise
    )
    body_states[LARGEST_TILT_RATIO_AFTER_RECORD_ROW_OFFSET + lane] = late_tilt
    if sample < course.end_sample_if_undecided:
        return CASE_NOT_ENDED
    if not (stands or late_tilt < MAX_LATE_TILT_RATIO_COUNTED_AS_STANDING):
        return CaseStatus.UNDECIDED
    # A body that slides upright is simulated until friction has stopped it.
    if late_tilt < MAX_TILT_RATIO_AT_REST and body_will_slide_noticeably(
        body, s, limits.min_base_edge_distance_from_centre
    ):
        # A spin lasts as long as a slide with the speed of a point at the radius of gyration, or less.
        gyration = max(limits.min_base_edge_distance_from_centre, 1.0 / np.sqrt(body.mass_times_inverse_inertia.zz))
        time = np.sqrt(squared_base_speed_including_spin(body, s, gyration)) / (GRAVITY * body.friction)
        if set_slide_end_once_and_check_case_continues(
            body_states, SLIDING_CASE_END_SAMPLE_ROW_OFFSET + lane, sample, time, body.tick_length_s * ticks_per_sample
        ):
            return CASE_NOT_ENDED
    return CaseStatus.SIMULATED


@njit(**INTERNAL_COMPILE_OPTIONS)
def body_rests_upright_on_all_base_vertices(
    body_states: Any,
    vertex_rows: Any,
    vertex_count: int,
    base_vertex_count: int,
    lane: int,
    max_base_acceleration_without_motion_g: float,
) -> bool:
    """True if a body is upright, still and held without sliding by at least as many points as its base has vertices."""
    body, s, held = load_body_constants(body_states, lane), load_body_state(body_states, lane), 0
    w = s.angular_velocity
    turning = matrix_times_vector(expand_symmetric_matrix(body.mass_times_inverse_inertia), s.contact_moment_per_mass)
    speed = vector_length(s.velocity_relative_to_base) + body.centre_height * vector_length(w)
    step = body.tick_length_s * body_states[NEXT_STEP_TICKS_ROW_OFFSET + lane]
    if not body_is_still(
        speed,
        vector_length(s.acceleration_relative_to_base) + body.centre_height * vector_length(turning),
        step,
        max_base_acceleration_without_motion_g,
    ):
        return False
    for i in range(vertex_count):
        one = load_point_state_at_step_start(
            vertex_rows[i * VALUE_COUNT_PER_VERTEX_IN_ALL_LANES : (i + 1) * VALUE_COUNT_PER_VERTEX_IN_ALL_LANES], lane
        )
        held += 1 if one.normal_force_per_mass > 0.0 and one.slid_in_last_step_or_rejected_attempt == 0.0 else 0
    return bool(
        held >= base_vertex_count
        and squared_sine_of_lean_continued_beyond_90_deg(rotation_matrix(s.rotation))
        < MAX_TILT_RATIO_AT_REST * MAX_TILT_RATIO_AT_REST * body.critical_lean_as_continued_squared_sine
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_case_results(
    body_states: Any, vertex_rows: Any, lane: int, status: int, result_row: Any, fall_limits_by_lean_sector: Any
) -> None:
    """Write the results of the case in column `lane` of the state array into `result_row`."""
    count = vertex_rows.size // VALUE_COUNT_PER_VERTEX_IN_ALL_LANES
    body = load_body_constants(body_states, lane)
    s = load_body_state(body_states, lane)
    peaks = load_peaks_and_last_upright_tick(body_states, lane)
    account = load_energy_account(body_states, lane)
    course = load_case_progress(body_states, lane)
    limits = load_termination_limits(body_states, lane)
    f = rotation_matrix(s.rotation)
    fallen = status == CaseStatus.SIMULATED and body_has_fallen(f, limits, fall_limits_by_lean_sector)
    result_row.fallen = 1.0 if fallen else 0.0
    result_row.last_upright_time_if_fallen = course.last_time_below_critical_angle if fallen else np.nan
    result_row.peak_lean_as_continued_squared_sine = max(
        peaks.peak_lean_as_continued_squared_sine, squared_sine_of_lean_continued_beyond_90_deg(f)
    )
    result_row.peak_slip = np.sqrt(peaks.peak_squared_base_slip)
    result_row.slip_x_at_end, result_row.slip_y_at_end = (
        s.centre_position.x - body.centre_height * f.xz,
        s.centre_position.y - body.centre_height * f.yz,
    )
    result_row.peak_penetration = peaks.peak_penetration
    balance = (
        (kinetic_gravity_and_spring_energy_per_mass(body, s, vertex_rows, count, lane) - course.initial_energy)
        - account.base_motion_work_per_mass
        + account.lost_energy_per_mass
    )
    result_row.energy_error = abs(balance) / max(
        account.base_motion_work_per_mass, course.energy_needed_to_overturn, course.initial_energy
    )
    swing = np.sqrt(
        GRAVITY
        * (
            body.centre_height * body.centre_height
            + limits.min_base_edge_distance_from_centre * limits.min_base_edge_distance_from_centre
        )
        ** 1.5
    )
    result_row.vertical_angular_momentum_error_ratio = (
        abs(
            vertical_angular_momentum_about_origin_per_mass(s)
            - limits.initial_vertical_angular_momentum_per_mass
            - account.supplied_vertical_angular_momentum_per_mass
        )
        / swing
    )
    result_row.qw_at_end, result_row.qx_at_end, result_row.qy_at_end, result_row.qz_at_end = s.rotation


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_body_trajectory_row(
    body_states: Any, lane: int, sampling_interval_s: float, ticks_per_sample: float, trajectory_row: Any
) -> None:
    """Write time, pose, velocities and base acceleration of the body in column `lane` into `trajectory_row`."""
    body = load_body_constants(body_states, lane)
    s = load_body_state(body_states, lane)
    shaking = load_inertial_and_upward_base_accelerations(body_states, lane)
    trajectory_row.time = (
        load_case_progress(body_states, lane).current_sample + s.ticks_since_sample_start / ticks_per_sample
    ) * sampling_interval_s
    trajectory_row.x, trajectory_row.y, trajectory_row.z = s.centre_position
    trajectory_row.qw, trajectory_row.qx, trajectory_row.qy, trajectory_row.qz = s.rotation
    trajectory_row.vx, trajectory_row.vy, trajectory_row.vz = s.velocity_relative_to_base
    trajectory_row.wx, trajectory_row.wy, trajectory_row.wz = angular_velocity_of_state(body, s)
    trajectory_row.base_acceleration_x = -base_acceleration_at_tick(
        shaking.negative_of_base_acceleration_x, s.ticks_since_sample_start
    )
    trajectory_row.base_acceleration_y = -base_acceleration_at_tick(
        shaking.inertial_acceleration_y, s.ticks_since_sample_start
    )
    trajectory_row.base_acceleration_z = base_acceleration_at_tick(
        shaking.upward_base_acceleration, s.ticks_since_sample_start
    )
