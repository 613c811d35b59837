"""Start of a 3-D case: constants, initial state and limits of a body in the column of a lane."""

from typing import Any

import numpy as np
from numba import njit

from overturning.dem.body.access import (
    REST_ACCELERATION_LIMIT_ROW_OFFSET,
    STATE_ROW_COUNT,
    VALUE_COUNT_PER_VERTEX_IN_ALL_LANES,
    store_body_constants,
    store_body_state,
    store_case_progress,
    store_next_step_to_attempt,
    store_peaks_and_last_upright_tick,
    store_point_state_at_step_start,
    store_step_lengths_and_doubling_counts,
    store_termination_limits,
    store_vertex,
)
from overturning.dem.body.ending import (
    kinetic_gravity_and_spring_energy_per_mass,
    vertical_angular_momentum_about_origin_per_mass,
)
from overturning.dem.body.state import (
    PARALLEL_CASE_COUNT,
    BodyConstants,
    BodyContactPointState,
    BodyPeaksAndLastUprightTick,
    BodyState,
    BodyTerminationLimits,
    BodyVertex,
    squared_sine_of_lean_continued_beyond_90_deg,
)
from overturning.dem.body.vectors import (
    Matrix3,
    Quaternion,
    SymmetricMatrix,
    Vector3,
    cross_product,
    expand_symmetric_matrix,
    matrix_times_vector,
    plus,
    rotation_matrix,
    scale_vector,
    transpose,
)
from overturning.dem.kernel.clock import CaseStepLengthsAndDoublingCounts, NextStepToAttempt
from overturning.dem.kernel.ending import CaseProgress
from overturning.dem.kernel.lanes import INTERNAL_COMPILE_OPTIONS
from overturning.dem.kernel.mechanics import FLAT_LANDING_DURATION_IN_DECAY_TIMES
from overturning.units import STANDARD_GRAVITY as GRAVITY


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_body_constants_and_initial_state(
    body_states: Any, vertex_rows: Any, lane: int, case_table_row: Any, body_table_row: Any,
    vertices_and_base_edges: Any, sampling_interval_s: float, ticks_per_sample: float,
) -> None:  # fmt: skip
    """Write the constants and initial state of a body and its vertices into column `lane` of both state arrays."""
    for row in range(STATE_ROW_COUNT):
        body_states[row * PARALLEL_CASE_COUNT + lane] = 0.0
    body = body_constants_of_case(case_table_row, body_table_row, sampling_interval_s / ticks_per_sample)
    begin = write_vertex_states_and_return_body_state(
        vertex_rows, lane, body, case_table_row.start, vertices_and_base_edges
    )
    store_body_constants(body_states, lane, body)
    case_step_control = CaseStepLengthsAndDoublingCounts(
        case_table_row.min_allowed_step_ticks,
        case_table_row.longest_step_with_all_contacts_closed_ticks,
        case_table_row.steps_before_doubling_after_contact_change,
        case_table_row.long_steps_before_doubling,
    )
    store_step_lengths_and_doubling_counts(body_states, lane, case_step_control)
    store_body_state(body_states, lane, begin)
    store_next_step_to_attempt(
        body_states,
        lane,
        NextStepToAttempt(
            case_table_row.min_allowed_step_ticks, case_table_row.steps_before_doubling_after_contact_change, 0.0
        ),
    )
    store_peaks_and_last_upright_tick(
        body_states,
        lane,
        BodyPeaksAndLastUprightTick(
            squared_sine_of_lean_continued_beyond_90_deg(rotation_matrix(begin.rotation)), 0.0, 0.0, -1.0
        ),
    )
    barrier = GRAVITY * (
        np.sqrt(
            body_table_row.min_base_edge_distance_from_centre * body_table_row.min_base_edge_distance_from_centre
            + body_table_row.centre_height * body_table_row.centre_height
        )
        - body_table_row.centre_height
    )
    store_case_progress(body_states, lane, CaseProgress(
        case_table_row.amplitude_factor, case_table_row.first_simulated_sample,
        case_table_row.cannot_start_moving_from_sample,
        case_table_row.end_sample_if_undecided,
        case_table_row.first_simulated_sample * sampling_interval_s,
        kinetic_gravity_and_spring_energy_per_mass(body, begin, vertex_rows, vertices_and_base_edges.shape[0], lane),
        barrier,
    ))  # fmt: skip
    body_states[REST_ACCELERATION_LIMIT_ROW_OFFSET + lane] = case_table_row.max_base_acceleration_without_motion_g
    store_termination_limits(body_states, lane, BodyTerminationLimits(
        vertical_angular_momentum_about_origin_per_mass(begin), body_table_row.min_base_edge_distance_from_centre,
        body_table_row.fall_tilt_cosine,
        body_table_row.max_penetration, case_table_row.max_base_acceleration_for_sample_long_steps_g,
    ))  # fmt: skip


@njit(**INTERNAL_COMPILE_OPTIONS)
def body_constants_of_case(case_table_row: Any, body_table_row: Any, tick_length_s: float) -> BodyConstants:
    """Return a body's constants combined with the contact law of a case; `tick_length_s` (s) is the time unit."""
    c, ks = body_table_row, case_table_row.point_tangential_stiffness_per_mass
    return BodyConstants(
        mass_times_inverse_inertia=SymmetricMatrix(
            c.mass_times_inverse_inertia_xx,
            c.mass_times_inverse_inertia_yy,
            c.mass_times_inverse_inertia_zz,
            c.mass_times_inverse_inertia_xy,
            c.mass_times_inverse_inertia_xz,
            c.mass_times_inverse_inertia_yz,
        ),
        inertia_per_mass=SymmetricMatrix(
            c.inertia_per_mass_xx,
            c.inertia_per_mass_yy,
            c.inertia_per_mass_zz,
            c.inertia_per_mass_xy,
            c.inertia_per_mass_xz,
            c.inertia_per_mass_yz,
        ),
        centre_height=c.centre_height,
        round_base_radius_or_zero=c.round_base_radius_or_zero,
        point_normal_stiffness_per_mass=case_table_row.point_normal_stiffness_per_mass,
        point_tangential_stiffness_per_mass=ks,
        point_tangential_compliance_times_mass=1.0 / ks if ks > 0.0 else 0.0,
        point_dashpot_constant_per_mass=case_table_row.point_dashpot_constant_per_mass,
        friction=case_table_row.friction,
        critical_lean_as_continued_squared_sine=c.critical_lean_as_continued_squared_sine,
        extreme_vertex_tolerance_to_height_range=c.extreme_vertex_tolerance_to_height_range,
        tick_length_s=tick_length_s,
        flat_landing_duration_s=FLAT_LANDING_DURATION_IN_DECAY_TIMES
        * case_table_row.point_dashpot_constant_per_mass
        / case_table_row.point_normal_stiffness_per_mass,
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_vertex_states_and_return_body_state(
    vertex_rows: Any, lane: int, body: BodyConstants, initial_state_row: Any, vertices_and_base_edges: Any
) -> BodyState:
    """Write a body's vertices at their start positions into column `lane`; return the body's initial state.

    `initial_state_row` (type `INITIAL_STATE_DTYPE`) has the pose and velocities; the initial acceleration and moment
    are those of gravity and springs.
    """
    place = Vector3(initial_state_row.x, initial_state_row.y, initial_state_row.z)
    turn = Quaternion(initial_state_row.qw, initial_state_row.qx, initial_state_row.qy, initial_state_row.qz)
    v = Vector3(initial_state_row.vx, initial_state_row.vy, initial_state_row.vz)
    w = Vector3(initial_state_row.wx, initial_state_row.wy, initial_state_row.wz)
    f = rotation_matrix(turn)
    az, mx, my = -GRAVITY, 0.0, 0.0
    for i in range(vertices_and_base_edges.shape[0]):
        one = vertex_rows[i * VALUE_COUNT_PER_VERTEX_IN_ALL_LANES : (i + 1) * VALUE_COUNT_PER_VERTEX_IN_ALL_LANES]
        own = Vector3(vertices_and_base_edges[i, 0], vertices_and_base_edges[i, 1], vertices_and_base_edges[i, 2])
        arm = matrix_times_vector(f, own)
        store_vertex(
            one,
            lane,
            BodyVertex(
                own, vertices_and_base_edges[i, 3], vertices_and_base_edges[i, 4], vertices_and_base_edges[i, 5]
            ),
        )
        # Velocity is stored for points of a rim, position for vertices.
        known = plus(v, cross_product(w, arm)) if body.round_base_radius_or_zero > 0.0 else plus(place, arm)
        depth = -(place.z + arm.z)
        n = body.point_normal_stiffness_per_mass * max(depth, 0.0)
        store_point_state_at_step_start(
            one,
            lane,
            BodyContactPointState(
                tangential_spring_stretch_x=0.0,
                tangential_spring_stretch_y=0.0,
                position_x_or_rim_point_velocity_x=known.x,
                position_y_or_rim_point_velocity_y=known.y,
                penetration=depth,
                normal_force_per_mass=n,
                slid_in_last_step_or_rejected_attempt=0.0,
                remaining_flat_landing_time=0.0,
            ),
        )
        az, mx, my = az + n, mx + arm.y * n, my - arm.x * n
    return BodyState(
        centre_position=place,
        rotation=turn,
        velocity_relative_to_base=v,
        angular_momentum_per_mass=angular_momentum_per_mass_from_velocity(body.mass_times_inverse_inertia, f, w),
        angular_velocity=w,
        acceleration_relative_to_base=Vector3(0.0, 0.0, az),
        contact_moment_per_mass=Vector3(mx, my, 0.0),
        ticks_since_sample_start=0.0,
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def angular_momentum_per_mass_from_velocity(
    mass_times_inverse_inertia: SymmetricMatrix, body_axes: Matrix3, angular_velocity: Vector3
) -> Vector3:
    """Return the angular momentum per mass (m²/s) of a body, in the axes of the base.

    `mass_times_inverse_inertia` is in the axes of the body, 1/m², `angular_velocity` in the axes of the base, rad/s.
    """
    a = mass_times_inverse_inertia
    cofactors = SymmetricMatrix(
        a.yy * a.zz - a.yz**2, a.xx * a.zz - a.xz**2, a.xx * a.yy - a.xy**2,
        a.xz * a.yz - a.xy * a.zz, a.xy * a.yz - a.xz * a.yy, a.xy * a.xz - a.xx * a.yz,
    )  # fmt: skip
    inverse = 1.0 / ((a.xx * cofactors.xx + a.xy * cofactors.xy) + a.xz * cofactors.xz)
    own = matrix_times_vector(
        expand_symmetric_matrix(cofactors), matrix_times_vector(transpose(body_axes), angular_velocity)
    )
    return matrix_times_vector(body_axes, scale_vector(inverse, own))
