"""Cundall's scheme for a 3-D body, the reference for the centred scheme (docs/method.md).

Inside ``with allow_cundall_scheme_for_bodies():`` bodies accept the scheme "cundall". As in 2-D it uses central
differences: springs at the whole step, dashpots half a step earlier. Momenta are known at half steps, positions at
whole steps. The angular momentum in space changes only by the moment of the contact forces. The rotation of a step uses
the angular velocity in its middle, for which the body is first rotated by half of the step with the angular velocity at
its start. The forces of opposite vertices are summed first. Between samples, where the package reads the state, momenta
are stored at whole steps; `advance_momenta_with_last_forces` converts them.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from typing import Any, ClassVar, Final, NamedTuple
from unittest import mock

import numpy as np
from numba import njit

from overturning.dem.body import plan as body_plan
from overturning.dem.body.base_contact import (
    compute_base_contact_states,
    is_body_in_flat_landing,
    lowest_and_highest_base_points_rest,
    remaining_landing_time_of_new_contact,
    vertex_carries_no_load_until_base_ends_rest,
)
from overturning.dem.body.centred import (
    acceleration_of_body_centre_relative_to_base,
    rim_point_position_from_centre,
    slip_direction_and_tilting_share_in_flat_landing,
)
from overturning.dem.body.rotation import angular_velocity_from_momentum
from overturning.dem.body.rules import TIME_STEPPING_LOOP_BY_BASE_SHAPE_TAG
from overturning.dem.body.state import (
    PARALLEL_CASE_COUNT,
    STATE_ROW_LAYOUT,
    TICKS_PER_WHOLE_STEP,
    VERTEX_ROW_LAYOUT,
    BodyBaseContactState,
    BodyContactPointState,
    BodyEnergyAndMomentumAccount,
    BodyPeaksAndLastUprightTick,
    BodyState,
    BodyVertex,
    ContactPointAtStepStartAndEnd,
    InertialAndUpwardBaseAccelerations3D,
    squared_sine_of_lean_continued_beyond_90_deg,
)
from overturning.dem.body.state import BodyConstants as Constants
from overturning.dem.body.statics import largest_squared_frequency_on_springs_of_any_face
from overturning.dem.body.vectors import (
    Matrix3,
    Vector3,
    cross_product,
    dot_product,
    extrapolate_vector,
    matrix_times_vector,
    plus,
    rotate_quaternion,
    rotation_matrix,
)
from overturning.dem.kernel.ground import base_acceleration_at_tick
from overturning.dem.kernel.lanes import (
    ALLOCATING_INLINE_OPTIONS,
    COMPILE_OPTIONS,
    INLINE_OPTIONS,
    INTERNAL_COMPILE_OPTIONS,
    TupleRowLayout,
    cache_line_aligned_zeros,
    create_tuple_sum_difference_and_maximum_functions,
)
from overturning.dem.kernel.mechanics import limit_friction_force_and_stretch_and_test_slip, updated_maximum
from overturning.dem.kernel.queue import run_case_queue
from overturning.dem.numerics import NumericalOptions
from overturning.dem.time_step import IntegrationScheme, parse_scheme, steps_per_sample
from overturning.kernel_cache import cache_compiled_kernel
from overturning.model.body import Body
from overturning.model.cases import Cases
from overturning.motion.motion import Motion

TICKS_PER_STEP: Final = TICKS_PER_WHOLE_STEP


class CundallPolygonalBaseLoopTag(NamedTuple):
    """Marker type for bodies with vertices; from it the compiler chooses the loop written for them."""

    has_round_base: bool = False


class CundallRoundBaseLoopTag(NamedTuple):
    """Marker type for bodies with a rim; from it the compiler chooses the loop written for them."""

    has_round_base: bool = True


class ContactWrenchPerMass(NamedTuple):
    """Contact force of the base on a body and its moment, summed over contact points, divided by the mass."""

    force: Vector3
    moment_about_centre: Vector3
    non_spring_force: Vector3
    """Force without the springs."""
    non_spring_moment_about_centre: Vector3
    """Moment about the centre of the force without the springs."""
    released_normal_energy_over_half_stiffness: float
    """Energy released by normal springs, over half their stiffness, m²."""
    released_tangential_energy_over_half_stiffness: float
    """Energy released by tangential springs, over half their stiffness, m²."""


class ContactForceAndMaxPenetrationOverPoints(NamedTuple):
    """Contact force on a body in a step, and largest penetration of its contact points."""

    wrench: ContactWrenchPerMass
    max_penetration: float
    """Largest penetration, m."""


add_wrenches_per_mass = create_tuple_sum_difference_and_maximum_functions(ContactWrenchPerMass).plus


class ContactPoint(NamedTuple):
    """Contact point of a body: position from its centre, penetration, and displacement in the last step, m."""

    position_from_centre: Vector3
    penetration: float
    displacement_in_step_x: float
    displacement_in_step_y: float
    penetration_increase_in_step: float


@njit(**INLINE_OPTIONS)
def vertex_contact_point(
    body_state: BodyState, body_axes: Matrix3, vertex: BodyVertex, point_state_before_step: BodyContactPointState
) -> ContactPoint:
    """Return the contact point at a vertex; its displacement is the difference from its last position."""
    arm = matrix_times_vector(body_axes, vertex.position_from_centre_in_body_axes)
    place = plus(body_state.centre_position, arm)
    return ContactPoint(
        arm,
        -place.z,
        place.x - point_state_before_step.position_x_or_rim_point_velocity_x,
        place.y - point_state_before_step.position_y_or_rim_point_velocity_y,
        -place.z - point_state_before_step.penetration,
    )


@njit(**INLINE_OPTIONS)
def rim_contact_point(
    body: Constants,
    body_state: BodyState,
    body_axes: Matrix3,
    lean_component: float,
    transverse_component: float,
    time_step: float,
) -> ContactPoint:
    """Return the contact point at a point of a cylinder's rim; its displacement is that of the body at this point."""
    arm = rim_point_position_from_centre(body, body_axes, lean_component, transverse_component)
    v = plus(body_state.velocity_relative_to_base, cross_product(body_state.angular_velocity, arm))
    return ContactPoint(
        arm, -(body_state.centre_position.z + arm.z), time_step * v.x, time_step * v.y, -(time_step * v.z)
    )


@njit(**INLINE_OPTIONS)
def apply_contact_law(
    body: Constants,
    body_state: BodyState,
    contact_point: ContactPoint,
    point_state_before_step: BodyContactPointState,
    dashpot_per_mass_over_step: float,
    carries_later_lands_flat_duration_tilting_share: tuple[bool, bool, float, float],
) -> tuple[ContactWrenchPerMass, BodyContactPointState]:
    """Apply the contact law at a contact point; return its force and moment, and its new state.

    `dashpot_per_mass_over_step` is the dashpot constant over mass and time step, 1/s², so that it multiplies
    displacements. The items of `carries_later_lands_flat_duration_tilting_share` are: True if the point carries no load
    yet; True if the body is in a flat landing; the landing time, s, which a new contact gets; and the tilting share of
    the base (`BodyBaseContactState.tilting_share_of_friction_moment_in_flat_landing`).
    """
    waiting, flat, begun, base_tilting = carries_later_lands_flat_duration_tilting_share
    depth = 0.0 if waiting & (contact_point.penetration > 0.0) else contact_point.penetration
    inside, was = depth > 0.0, point_state_before_step.penetration > 0.0
    # Spring and dashpot while the point is in, never tension but in a flat landing.
    # A vertex that has waited does not remember how deep it was.
    sinking = 0.0 if point_state_before_step.penetration == 0.0 else contact_point.penetration_increase_in_step
    n = body.point_normal_stiffness_per_mass * depth + dashpot_per_mass_over_step * sinking
    n = n if inside & (flat | (n > 0.0)) else 0.0
    # A new contact starts with unstretched springs; those of a slipping one are shortened to the friction limit.
    tx, ty = (
        (point_state_before_step.tangential_spring_stretch_x + contact_point.displacement_in_step_x if was else 0.0),
        (point_state_before_step.tangential_spring_stretch_y + contact_point.displacement_in_step_y if was else 0.0),
    )
    most = body.friction * n
    hx, hy = (
        -(body.point_tangential_stiffness_per_mass * tx)
        - dashpot_per_mass_over_step * contact_point.displacement_in_step_x,
        -(body.point_tangential_stiffness_per_mass * ty)
        - dashpot_per_mass_over_step * contact_point.displacement_in_step_y,
    )
    drift_x, drift_y, drifts, tilting = slip_direction_and_tilting_share_in_flat_landing(
        body,
        contact_point.position_from_centre,
        body_state.velocity_relative_to_base,
        body_state.angular_velocity,
        (flat, base_tilting),
    )
    hx, hy = (-drift_x if drifts else hx), (-drift_y if drifts else hy)
    fx, fy, kx, ky, _ = limit_friction_force_and_stretch_and_test_slip(
        hx, hy, tx, ty, most, body.point_tangential_compliance_times_mass, (flat, drifts)
    )
    landing = (
        point_state_before_step.remaining_flat_landing_time if was else begun
    ) - body.tick_length_s * TICKS_PER_STEP
    landing = landing if inside else 0.0
    force = Vector3(fx, fy, n)
    spring = body.point_normal_stiffness_per_mass * (depth if inside else 0.0)
    damping = Vector3(
        fx + body.point_tangential_stiffness_per_mass * kx,
        fy + body.point_tangential_stiffness_per_mass * ky,
        n - spring,
    )
    opened = point_state_before_step.penetration * point_state_before_step.penetration if was & (not inside) else 0.0
    # One that has waited is met by a spring that is pressed in already.
    opened = -(depth * depth) if inside & (point_state_before_step.penetration == 0.0) else opened
    shortened = (point_state_before_step.tangential_spring_stretch_x + kx) * (tx - kx) + (
        point_state_before_step.tangential_spring_stretch_y + ky
    ) * (ty - ky)
    lever = Vector3(
        contact_point.position_from_centre.x,
        contact_point.position_from_centre.y,
        tilting * contact_point.position_from_centre.z,
    )
    # The springs are stretched at the point itself, at the full lever arm.
    moment = cross_product(lever, force)
    of_springs = cross_product(
        contact_point.position_from_centre,
        Vector3(body.point_tangential_stiffness_per_mass * kx, body.point_tangential_stiffness_per_mass * ky, -spring),
    )
    wrench = ContactWrenchPerMass(force, moment, damping, plus(moment, of_springs), opened, shortened)
    return wrench, BodyContactPointState(
        tangential_spring_stretch_x=kx,
        tangential_spring_stretch_y=ky,
        position_x_or_rim_point_velocity_x=body_state.centre_position.x + contact_point.position_from_centre.x,
        position_y_or_rim_point_velocity_y=body_state.centre_position.y + contact_point.position_from_centre.y,
        penetration=depth,
        normal_force_per_mass=n,
        slid_in_last_step_or_rejected_attempt=0.0,
        remaining_flat_landing_time=landing,
    )


@njit(**INLINE_OPTIONS)
def add_forces_of_contact_pair(
    contact_totals: ContactForceAndMaxPenetrationOverPoints,
    first_wrench: ContactWrenchPerMass,
    second_wrench: ContactWrenchPerMass,
    first_penetration: float,
    second_penetration: float,
) -> ContactForceAndMaxPenetrationOverPoints:
    """Add the forces of a pair of opposite contact points to the totals of a body."""
    return ContactForceAndMaxPenetrationOverPoints(
        add_wrenches_per_mass(contact_totals.wrench, add_wrenches_per_mass(first_wrench, second_wrench)),
        updated_maximum(contact_totals.max_penetration, updated_maximum(second_penetration, first_penetration)),
    )


@njit(**INLINE_OPTIONS)
def advance_body_one_step(
    body: Constants,
    body_state: BodyState,
    body_axes: Matrix3,
    contact_totals: ContactForceAndMaxPenetrationOverPoints,
    peak_values: BodyPeaksAndLastUprightTick,
    energy_and_momentum_account: BodyEnergyAndMomentumAccount,
    inertial_accelerations_in_sample: InertialAndUpwardBaseAccelerations3D,
) -> tuple[BodyState, BodyPeaksAndLastUprightTick, BodyEnergyAndMomentumAccount]:
    """Advance one body by one step under the contact force of the base."""
    t, dt = contact_totals.wrench, body.tick_length_s * TICKS_PER_STEP
    half = 0.5 * dt
    push = Vector3(
        base_acceleration_at_tick(
            inertial_accelerations_in_sample.negative_of_base_acceleration_x, body_state.ticks_since_sample_start
        ),
        base_acceleration_at_tick(
            inertial_accelerations_in_sample.inertial_acceleration_y, body_state.ticks_since_sample_start
        ),
        base_acceleration_at_tick(
            inertial_accelerations_in_sample.upward_base_acceleration, body_state.ticks_since_sample_start
        ),
    )
    a = acceleration_of_body_centre_relative_to_base(t.force, push)
    # The accounts take the velocities at the whole step.
    c = extrapolate_vector(body_state.velocity_relative_to_base, half, a)
    w = angular_velocity_from_momentum(
        body.mass_times_inverse_inertia,
        body_axes,
        extrapolate_vector(body_state.angular_momentum_per_mass, half, t.moment_about_centre),
    )
    work = energy_and_momentum_account.base_motion_work_per_mass + dt * ((push.x * c.x + push.y * c.y) - push.z * c.z)
    let_go = 0.5 * (
        body.point_normal_stiffness_per_mass * t.released_normal_energy_over_half_stiffness
        + body.point_tangential_stiffness_per_mass * t.released_tangential_energy_over_half_stiffness
    )
    loss = energy_and_momentum_account.lost_energy_per_mass + (
        let_go + dt * -(dot_product(t.non_spring_force, c) + dot_product(t.non_spring_moment_about_centre, w))
    )
    spin = energy_and_momentum_account.supplied_vertical_angular_momentum_per_mass + dt * (
        t.moment_about_centre.z + (body_state.centre_position.x * a.y - body_state.centre_position.y * a.x)
    )
    # Update the peaks and the last time before the critical tilt.
    lean, bx, by = (
        squared_sine_of_lean_continued_beyond_90_deg(body_axes),
        body_state.centre_position.x - body.centre_height * body_axes.xz,
        body_state.centre_position.y - body.centre_height * body_axes.yz,
    )
    peak_values = BodyPeaksAndLastUprightTick(
        updated_maximum(peak_values.peak_lean_as_continued_squared_sine, lean),
        updated_maximum(peak_values.peak_squared_base_slip, bx * bx + by * by),
        updated_maximum(peak_values.peak_penetration, contact_totals.max_penetration),
        body_state.ticks_since_sample_start
        if lean < body.critical_lean_as_continued_squared_sine
        else peak_values.last_upright_tick_in_sample,
    )
    # Momenta half a step later, position one step later.
    v, momentum = (
        extrapolate_vector(body_state.velocity_relative_to_base, dt, a),
        extrapolate_vector(body_state.angular_momentum_per_mass, dt, t.moment_about_centre),
    )
    w = angular_velocity_from_momentum(body.mass_times_inverse_inertia, body_axes, momentum)
    w = angular_velocity_from_momentum(
        body.mass_times_inverse_inertia, rotation_matrix(rotate_quaternion(body_state.rotation, half, w)), momentum
    )
    place, turn = extrapolate_vector(body_state.centre_position, dt, v), rotate_quaternion(body_state.rotation, dt, w)
    moved = BodyState(
        centre_position=place,
        rotation=turn,
        velocity_relative_to_base=v,
        angular_momentum_per_mass=momentum,
        angular_velocity=w,
        acceleration_relative_to_base=a,
        contact_moment_per_mass=t.moment_about_centre,
        ticks_since_sample_start=body_state.ticks_since_sample_start + TICKS_PER_STEP,
    )
    return moved, peak_values, BodyEnergyAndMomentumAccount(work, loss, spin, 0.0, 0.0, 0.0)


# Side by side ---------------------------------------------------------------------------------------------------------

load_body, load_body_state, load_rotation_matrix = (
    STATE_ROW_LAYOUT.tuple_reader_and_writer(of).load for of in (Constants, BodyState, Matrix3)
)
load_extreme_vertices_and_landing_state, store_extreme_vertices_and_landing_state, _ = (
    STATE_ROW_LAYOUT.tuple_reader_and_writer(BodyBaseContactState)
)
CONTACT_FORCE_AND_PENETRATION_LAYOUT: Final = TupleRowLayout(
    PARALLEL_CASE_COUNT, ContactForceAndMaxPenetrationOverPoints
)
CONTACT_FORCE_AND_PENETRATION_ARRAY_LENGTH: Final = CONTACT_FORCE_AND_PENETRATION_LAYOUT.array_length
load_contact_force_and_largest_penetration, store_contact_force_and_largest_penetration, _ = (
    CONTACT_FORCE_AND_PENETRATION_LAYOUT.tuple_reader_and_writer(ContactForceAndMaxPenetrationOverPoints)
)
create_zero_wrench_per_mass = create_tuple_sum_difference_and_maximum_functions(ContactWrenchPerMass).zero
load_accelerations_from_base_motion = STATE_ROW_LAYOUT.tuple_reader_and_writer(
    InertialAndUpwardBaseAccelerations3D
).load
load_peaks_and_last_upright_tick, load_energy_and_momentum_account = (
    STATE_ROW_LAYOUT.tuple_reader_and_writer(BodyPeaksAndLastUprightTick).load,
    STATE_ROW_LAYOUT.tuple_reader_and_writer(BodyEnergyAndMomentumAccount).load,
)
store_body_state, store_rotation_matrix = (
    STATE_ROW_LAYOUT.tuple_reader_and_writer(of).store for of in (BodyState, Matrix3)
)
store_peaks_and_last_upright_tick, store_energy_and_momentum_account = (
    STATE_ROW_LAYOUT.tuple_reader_and_writer(BodyPeaksAndLastUprightTick).store,
    STATE_ROW_LAYOUT.tuple_reader_and_writer(BodyEnergyAndMomentumAccount).store,
)
load_vertex, (load_memory, store_memory, _) = (
    VERTEX_ROW_LAYOUT.tuple_reader_and_writer(BodyVertex).load,
    VERTEX_ROW_LAYOUT.tuple_reader_and_writer(ContactPointAtStepStartAndEnd, "at_step_start"),
)
VALUE_COUNT_PER_VERTEX_IN_ALL_LANES: Final = VERTEX_ROW_LAYOUT.array_length


@njit(**INTERNAL_COMPILE_OPTIONS)
def compute_axes_and_reset_contact_forces(state: Any, contact_total_rows: Any, lane_count: int) -> None:
    """Compute the axes of all bodies from their rotations, and set their contact forces to zero."""
    for j in range(lane_count):
        s = load_body_state(state, j)
        store_rotation_matrix(state, j, rotation_matrix(s.rotation))
        store_contact_force_and_largest_penetration(
            contact_total_rows, j, ContactForceAndMaxPenetrationOverPoints(create_zero_wrench_per_mass(), -1.0)
        )


@njit(**INTERNAL_COMPILE_OPTIONS)
def add_vertex_contact_forces(
    state: Any, contact_total_rows: Any, first_vertex_rows: Any, second_vertex_rows_of_pair: Any, lane_count: int
) -> None:
    """Add the contact forces at a pair of opposite vertices, for all bodies."""
    for j in range(lane_count):
        body, s, f = load_body(state, j), load_body_state(state, j), load_rotation_matrix(state, j)
        rate, left, right = (
            body.point_dashpot_constant_per_mass / (body.tick_length_s * TICKS_PER_STEP),
            load_memory(first_vertex_rows, j),
            load_memory(second_vertex_rows_of_pair, j),
        )
        p, q, base_contact = (
            load_vertex(first_vertex_rows, j),
            load_vertex(second_vertex_rows_of_pair, j),
            load_extreme_vertices_and_landing_state(state, j),
        )
        at, on = vertex_contact_point(s, f, p, left), vertex_contact_point(s, f, q, right)
        a, left = apply_contact_law(
            body,
            s,
            at,
            left,
            rate,
            (
                vertex_carries_no_load_until_base_ends_rest(body, base_contact, p, at.position_from_centre.z, left),
                is_body_in_flat_landing(base_contact),
                remaining_landing_time_of_new_contact(body, base_contact),
                base_contact.tilting_share_of_friction_moment_in_flat_landing,
            ),
        )
        b, right = apply_contact_law(
            body,
            s,
            on,
            right,
            rate,
            (
                vertex_carries_no_load_until_base_ends_rest(body, base_contact, q, on.position_from_centre.z, right),
                is_body_in_flat_landing(base_contact),
                remaining_landing_time_of_new_contact(body, base_contact),
                base_contact.tilting_share_of_friction_moment_in_flat_landing,
            ),
        )
        store_memory(first_vertex_rows, j, left)
        store_memory(second_vertex_rows_of_pair, j, right)
        store_contact_force_and_largest_penetration(
            contact_total_rows,
            j,
            add_forces_of_contact_pair(
                load_contact_force_and_largest_penetration(contact_total_rows, j),
                a,
                b,
                left.penetration,
                right.penetration,
            ),
        )


@njit(**INTERNAL_COMPILE_OPTIONS)
def add_contact_forces_at_rim_point_pair(
    state: Any,
    contact_total_rows: Any,
    first_rim_point_history_rows: Any,
    opposite_point_rows: Any,
    lane_count: int,
    lean_component: float,
    transverse_component: float,
) -> None:
    """Add, for each body, the contact forces at two opposite points of the rim of its round base."""
    for j in range(lane_count):
        body, s, f = load_body(state, j), load_body_state(state, j), load_rotation_matrix(state, j)
        dt = body.tick_length_s * TICKS_PER_STEP
        rate, left, right = (
            body.point_dashpot_constant_per_mass / dt,
            load_memory(first_rim_point_history_rows, j),
            load_memory(opposite_point_rows, j),
        )
        base_contact = load_extreme_vertices_and_landing_state(state, j)
        between, flat, begun = (
            (transverse_component != 0.0) & (not lowest_and_highest_base_points_rest(base_contact)),
            is_body_in_flat_landing(base_contact),
            remaining_landing_time_of_new_contact(body, base_contact),
        )
        tilting = base_contact.tilting_share_of_friction_moment_in_flat_landing
        at, on = (
            rim_contact_point(body, s, f, lean_component, transverse_component, dt),
            rim_contact_point(body, s, f, -lean_component, -transverse_component, dt),
        )
        waits = between & (left.penetration <= 0.0), between & (right.penetration <= 0.0)
        a, left = apply_contact_law(body, s, at, left, rate, (waits[0], flat, begun, tilting))
        b, right = apply_contact_law(body, s, on, right, rate, (waits[1], flat, begun, tilting))
        store_memory(first_rim_point_history_rows, j, left)
        store_memory(opposite_point_rows, j, right)
        store_contact_force_and_largest_penetration(
            contact_total_rows,
            j,
            add_forces_of_contact_pair(
                load_contact_force_and_largest_penetration(contact_total_rows, j),
                a,
                b,
                left.penetration,
                right.penetration,
            ),
        )


@njit(**INTERNAL_COMPILE_OPTIONS)
def advance_all_bodies(state: Any, contact_total_rows: Any, lane_count: int) -> None:
    """Advance all bodies by one step under their contact forces."""
    for j in range(lane_count):
        s, peaks, account = advance_body_one_step(
            load_body(state, j), load_body_state(state, j), load_rotation_matrix(state, j),
            load_contact_force_and_largest_penetration(contact_total_rows, j),
            load_peaks_and_last_upright_tick(state, j), load_energy_and_momentum_account(state, j),
            load_accelerations_from_base_motion(state,
            j),
        )  # fmt: skip
        store_body_state(state, j, s)
        store_peaks_and_last_upright_tick(state, j, peaks)
        store_energy_and_momentum_account(state, j, account)


@njit(**INTERNAL_COMPILE_OPTIONS)
def advance_momenta_with_last_forces(state: Any, lane_count: int, signed_step_fraction: float) -> None:
    """Advance the momenta of all bodies by a number of steps (here ±½) with the last forces."""
    for j in range(lane_count):
        s, account = load_body_state(state, j), load_energy_and_momentum_account(state, j)
        time = signed_step_fraction * TICKS_PER_STEP * load_body(state, j).tick_length_s
        v, momentum = (
            extrapolate_vector(s.velocity_relative_to_base, time, s.acceleration_relative_to_base),
            extrapolate_vector(s.angular_momentum_per_mass, time, s.contact_moment_per_mass),
        )
        store_body_state(
            state,
            j,
            BodyState(
                centre_position=s.centre_position,
                rotation=s.rotation,
                velocity_relative_to_base=v,
                angular_momentum_per_mass=momentum,
                angular_velocity=s.angular_velocity,
                acceleration_relative_to_base=s.acceleration_relative_to_base,
                contact_moment_per_mass=s.contact_moment_per_mass,
                ticks_since_sample_start=s.ticks_since_sample_start,
            ),
        )
        torque = s.contact_moment_per_mass.z + (
            s.centre_position.x * s.acceleration_relative_to_base.y
            - s.centre_position.y * s.acceleration_relative_to_base.x
        )
        store_energy_and_momentum_account(
            state,
            j,
            BodyEnergyAndMomentumAccount(
                account.base_motion_work_per_mass,
                account.lost_energy_per_mass,
                account.supplied_vertical_angular_momentum_per_mass + time * torque,
                0.0,
                0.0,
                0.0,
            ),
        )


@cache
def compiled_loop_of_sampling_interval(has_rim: bool) -> Any:
    """Return the compiled loop over the time steps of one sampling interval, for bodies with vertices or with a rim.

    The type of its argument `marker_whose_type_selects_base_shape_loop` makes the compiled names of both loops differ;
    otherwise loops compiled by different processes would be confused in a process that loads both.
    """

    @njit(**ALLOCATING_INLINE_OPTIONS)
    def advance_bodies_by_sampling_interval(
        marker_whose_type_selects_base_shape_loop: Any,  # noqa: ARG001
        state: Any,
        vertex_rows: Any,
        contact_point_count: int,
        base_vertex_count: int,
        lane_count: int,
        steps_per_sample: int,
        ticks_per_sample: float,  # noqa: ARG001
    ) -> None:
        """Advance all bodies by the time steps of one sampling interval."""
        half, acting = (
            contact_point_count // 2 * VALUE_COUNT_PER_VERTEX_IN_ALL_LANES,
            cache_line_aligned_zeros(CONTACT_FORCE_AND_PENETRATION_ARRAY_LENGTH),
        )
        advance_momenta_with_last_forces(state, lane_count, -0.5)
        for _ in range(steps_per_sample):
            compute_axes_and_reset_contact_forces(state, acting, lane_count)
            compute_base_contact_states(state, vertex_rows, half, base_vertex_count, lane_count, has_rim)
            for pair in range(0, half, VALUE_COUNT_PER_VERTEX_IN_ALL_LANES):
                one, other = (
                    vertex_rows[pair : pair + VALUE_COUNT_PER_VERTEX_IN_ALL_LANES],
                    vertex_rows[half + pair : half + pair + VALUE_COUNT_PER_VERTEX_IN_ALL_LANES],
                )
                if has_rim:
                    ahead = 1.0 if pair == 0 else 0.0
                    add_contact_forces_at_rim_point_pair(state, acting, one, other, lane_count, ahead, 1.0 - ahead)
                else:
                    add_vertex_contact_forces(state, acting, one, other, lane_count)
            advance_all_bodies(state, acting, lane_count)
        advance_momenta_with_last_forces(state, lane_count, 0.5)

    return advance_bodies_by_sampling_interval


TIME_STEPPING_LOOP_BY_BASE_SHAPE_TAG.update(
    {
        CundallPolygonalBaseLoopTag: compiled_loop_of_sampling_interval(False),
        CundallRoundBaseLoopTag: compiled_loop_of_sampling_interval(True),
    }
)
_compiled_case_queue_runner = njit(nogil=True, **COMPILE_OPTIONS)(run_case_queue.py_func)


@njit(nogil=True, **COMPILE_OPTIONS)
def run_cundall_case_queue(
    kernel_input: Any, case_numbers_in_queue_order: Any, counter_of_block_steps_done: Any, trajectory: Any
) -> tuple[Any, int]:
    """Run a queue of cases like `run_case_queue`, with a compiled-code cache separate from that of the package."""
    return _compiled_case_queue_runner(
        kernel_input, case_numbers_in_queue_order, counter_of_block_steps_done, trajectory
    )


cache_compiled_kernel(run_cundall_case_queue)


class CundallSimulationPlan(body_plan.BodySimulationPlan):
    """Plan for cases of a 3-D body with Cundall's scheme."""

    run_case_queue_function: ClassVar[Any] = staticmethod(run_cundall_case_queue)

    @property
    def marker_whose_type_selects_base_shape_loop(self) -> Any:
        """Object from whose type the compiler chooses the loops for bodies with a rim or with vertices."""
        return CundallRoundBaseLoopTag() if self.solids_by_size[0].rim_radius > 0 else CundallPolygonalBaseLoopTag()


@contextmanager
def allow_cundall_scheme_for_bodies() -> Iterator[None]:
    """Let 3-D bodies use the scheme "cundall" in a `with` block; its automatic step is half the stable one."""
    plan_centred = body_plan.plan_body_simulation

    def plan_with_cundall_if_chosen(
        model: Body, motion: Motion, cases: Cases, numerics: NumericalOptions
    ) -> body_plan.BodySimulationPlan:
        """Plan cases as usual, but with the loops of Cundall's scheme where it is chosen."""
        if parse_scheme(numerics.scheme) != IntegrationScheme.CUNDALL:
            return plan_centred(model, motion, cases, numerics)
        planned = plan_centred(model, motion, cases, replace(numerics, scheme="centred", time_step="auto"))
        modes = np.array([largest_squared_frequency_on_springs_of_any_face(solid) for solid in planned.solids_by_size])[
            planned.case_table["body"]
        ]
        square = (
            np.maximum(
                planned.case_table["point_normal_stiffness_per_mass"],
                planned.case_table["point_tangential_stiffness_per_mass"],
            )
            * modes
        )
        rate, interval = planned.case_table["point_dashpot_constant_per_mass"] * modes, motion.sampling_interval
        steps = steps_per_sample(IntegrationScheme.CUNDALL, numerics.time_step, square, rate, interval)
        planned.case_table["min_allowed_step_ticks"] = planned.case_table[
            "steps_before_doubling_after_contact_change"
        ] = 1.0
        planned.case_table["longest_step_with_all_contacts_closed_ticks"] = TICKS_PER_STEP
        return CundallSimulationPlan(**vars(planned) | {"steps_per_sample": steps * numerics.refinement})

    with mock.patch("overturning.dem.body.plan.plan_body_simulation", plan_with_cundall_if_chosen):
        yield
