"""The centred scheme for a 3-D body: trapezoidal rule, springs and dashpots at the end of the step (docs/method.md).

The step of one body has three parts, as for a block: `predict_body_with_step_start_forces` and
`solve_velocity_correction` are here, `compute_point_forces` and `complete_body_step` in `overturning.dem.body.commit`.
The unknowns are the corrections e of velocity and angular velocity at the end of the step. `centred_loops` has the
loops over the bodies.
"""

import math
from typing import Final, NamedTuple

from numba import njit

from overturning.dem.body.rotation import angular_velocity_from_momentum, rotation_and_angular_velocity_after_step
from overturning.dem.body.state import (
    BodyConstants,
    BodyContactPointState,
    BodyPredictedForStepEnd,
    BodyState,
    BodyVelocityCorrection,
    ContactForcesAndNegatedVelocityDerivatives,
    InertialAndUpwardBaseAccelerations3D,
    PredictedContactPoint,
)
from overturning.dem.body.vectors import (
    Matrix3,
    Vector3,
    cross_product,
    expand_symmetric_matrix,
    extrapolate_vector,
    inverse_matrix,
    matrix_minus,
    matrix_plus,
    matrix_product,
    matrix_times_vector,
    minus,
    plus,
    rotation_matrix,
    scale_vector,
    transpose,
)
from overturning.dem.kernel.clock import BODY_STEP_CONTROL, CaseStepLengthsAndDoublingCounts, NextStepToAttempt
from overturning.dem.kernel.ground import base_acceleration_in_this_or_next_sample
from overturning.dem.kernel.lanes import INLINE_OPTIONS
from overturning.units import STANDARD_GRAVITY as GRAVITY

MAX_PREDICTED_FORCE_STEP_TO_SHORTEST_STEP: Final = BODY_STEP_CONTROL.max_predicted_force_step_in_shortest_steps
"""Longest step that uses predicted forces for contact and slip, as a multiple of the finest step."""

MIN_MOBILITY_RATIO_WITHOUT_FORCED_STICKING: Final = 0.25
"""Least effect of a normal force on a sliding point, as a share of its effect on a free particle; below, it sticks."""


@njit(**INLINE_OPTIONS)
def acceleration_of_body_centre_relative_to_base(
    contact_force_per_mass: Vector3, negative_horizontal_and_upward_base_acceleration: Vector3
) -> Vector3:
    """Return a body centre's acceleration (m/s²) relative to the base, from contact force, gravity and base motion."""
    return Vector3(
        contact_force_per_mass.x + negative_horizontal_and_upward_base_acceleration.x,
        contact_force_per_mass.y + negative_horizontal_and_upward_base_acceleration.y,
        contact_force_per_mass.z - (GRAVITY + negative_horizontal_and_upward_base_acceleration.z),
    )


# 1. Predict -----------------------------------------------------------------------------------------------------------


@njit(**INLINE_OPTIONS)
def predict_body_with_step_start_forces(
    body: BodyConstants,
    state_at_step_start: BodyState,
    step_length_ticks: float,
    inertial_and_upward_base_accelerations: InertialAndUpwardBaseAccelerations3D,
    ticks_per_sample: float,
) -> BodyPredictedForStepEnd:
    """Predict the state of a body at the end of a step with its acceleration and contact moment at the step's start."""
    dt, tick = body.tick_length_s * step_length_ticks, state_at_step_start.ticks_since_sample_start + step_length_ticks
    half, past = 0.5 * dt, tick - ticks_per_sample
    past = past if past > 0.0 else 0.0
    v, momentum = (
        extrapolate_vector(
            state_at_step_start.velocity_relative_to_base, half, state_at_step_start.acceleration_relative_to_base
        ),
        extrapolate_vector(
            state_at_step_start.angular_momentum_per_mass, half, state_at_step_start.contact_moment_per_mass
        ),
    )
    turn, spin = rotation_and_angular_velocity_after_step(
        body.mass_times_inverse_inertia,
        state_at_step_start.rotation,
        momentum,
        state_at_step_start.contact_moment_per_mass,
        dt,
    )
    at_end = Vector3(
        base_acceleration_in_this_or_next_sample(
            inertial_and_upward_base_accelerations.negative_of_base_acceleration_x, tick, past
        ),
        base_acceleration_in_this_or_next_sample(
            inertial_and_upward_base_accelerations.inertial_acceleration_y, tick, past
        ),
        base_acceleration_in_this_or_next_sample(
            inertial_and_upward_base_accelerations.upward_base_acceleration, tick, past
        ),
    )
    return BodyPredictedForStepEnd(
        centre_position=extrapolate_vector(state_at_step_start.centre_position, dt, v),
        rotation=turn,
        velocity_at_half_step=v,
        angular_momentum_per_mass_at_half_step=momentum,
        end_velocity=extrapolate_vector(v, half, state_at_step_start.acceleration_relative_to_base),
        end_angular_velocity=spin,
        negative_horizontal_and_upward_base_acceleration=at_end,
        half_step_length_s=half,
    )


@njit(**INLINE_OPTIONS)
def rim_point_position_from_centre(
    body: BodyConstants, body_axes: Matrix3, unit_component_along_lean: float, unit_component_across_lean: float
) -> Vector3:
    """Return the vector (m) from the centre of a body to one of four contact points on the rim of its round base.

    `unit_component_along_lean` and `unit_component_across_lean` (−1, 0 or 1) give the direction of the point from the
    axis: along the direction in which the body leans, and across it. The lowest point of the rim is always one of the
    four points, and all four carry equally if the rim lies flat. For an upright body the direction is arbitrary.
    """
    square = body_axes.xz * body_axes.xz + body_axes.yz * body_axes.yz
    leans = square > 1e-30
    one = 1.0 / math.sqrt(square if leans else 1.0)
    tx, ty = (body_axes.xz * one if leans else 1.0), (body_axes.yz * one if leans else 0.0)
    a = body.round_base_radius_or_zero * unit_component_along_lean
    b = body.round_base_radius_or_zero * unit_component_across_lean
    return Vector3(
        (a * body_axes.zz * tx - b * ty) - body.centre_height * body_axes.xz,
        (a * body_axes.zz * ty + b * tx) - body.centre_height * body_axes.yz,
        -(a * (square * one if leans else 0.0)) - body.centre_height * body_axes.zz,
    )


@njit(**INLINE_OPTIONS)
def step_is_short_enough_for_predicted_forces(
    case_step_control: CaseStepLengthsAndDoublingCounts, step_attempt: NextStepToAttempt
) -> bool:
    """True if an attempted step resolves the contact vibration, so that predicted forces decide about contact and slip.

    Longer steps use the contact state after the last step.
    """
    return (
        step_attempt.length_in_ticks
        <= MAX_PREDICTED_FORCE_STEP_TO_SHORTEST_STEP * case_step_control.min_allowed_step_ticks
    )


@njit(**INLINE_OPTIONS)
def slip_direction_and_tilting_share_in_flat_landing(
    body: BodyConstants,
    point_position_from_centre: Vector3,
    centre_velocity: Vector3,
    angular_velocity: Vector3,
    lands_flat_and_tilting_moment_share: tuple[bool, float],
) -> tuple[float, float, bool, float]:
    """Return a point's slip direction (x, y), whether it slides in a flat landing, and its tilting share.

    The tilting share is the part of the moment of the point's friction that tilts the body: 1 unless the point slides.
    `lands_flat_and_tilting_moment_share` holds whether the body lands flat, and the tilting share of a sliding point
    (`BodyBaseContactState.tilting_share_of_friction_moment_in_flat_landing`). The slip velocity includes only the
    rotation about the vertical; see `overturning.dem.kernel.mechanics.base_slides_in_flat_landing`.
    """
    lands_flat, tilting = lands_flat_and_tilting_moment_share
    x = centre_velocity.x - angular_velocity.z * point_position_from_centre.y
    y = centre_velocity.y + angular_velocity.z * point_position_from_centre.x
    square, least = x * x + y * y, body.friction * centre_velocity.z
    drifts = lands_flat & (square >= least * least)
    one = 1.0 / math.sqrt(square if drifts & (square > 0.0) else 1.0)
    return x * one, y * one, drifts, (tilting if drifts else 1.0)


class FlatLandingInputsOfContactPoint(NamedTuple):
    """Conditions of a flat landing for the prediction of one contact point of a body."""

    is_load_deferred_in_flat_landing: bool
    """True if the point carries load only later in the landing."""
    body_lands_flat: bool
    """True if the body lands flat."""
    landing_time_if_touching_now_s: float
    """Landing time of the point if it touches now, s."""
    tilting_friction_share: float
    """See `BodyBaseContactState.tilting_share_of_friction_moment_in_flat_landing`."""


@njit(**INLINE_OPTIONS)
def predict_contact_point(
    body: BodyConstants,
    predicted_body: BodyPredictedForStepEnd,
    body_axes: Matrix3,
    point_position_from_centre: Vector3,
    point_state_at_step_start: BodyContactPointState,
    contact_vibration_is_resolved: bool,
    base_is_round: bool,
    flat_landing_inputs: FlatLandingInputsOfContactPoint,
) -> PredictedContactPoint:
    """Predict a body's contact point at the end of a step, and whether it is assumed to touch and to slide.

    If the step resolves the contact vibration (`contact_vibration_is_resolved`), the predicted forces decide about
    contact and slip. In a longer step these forces would be too large, and contact and slip are taken from
    `point_state_at_step_start`.
    """
    old, r = point_state_at_step_start, point_position_from_centre
    deferred, flat, new_landing, base_tilting = flat_landing_inputs
    u = plus(predicted_body.end_velocity, cross_product(predicted_body.end_angular_velocity, r))
    # Points of a rim move along it: their velocity is stored instead of their position.
    slip_x = (
        predicted_body.half_step_length_s * (old.position_x_or_rim_point_velocity_x + u.x)
        if base_is_round
        else (predicted_body.centre_position.x + r.x) - old.position_x_or_rim_point_velocity_x
    )
    slip_y = (
        predicted_body.half_step_length_s * (old.position_y_or_rim_point_velocity_y + u.y)
        if base_is_round
        else (predicted_body.centre_position.y + r.y) - old.position_y_or_rim_point_velocity_y
    )
    was = old.penetration > 0.0
    tx = old.tangential_spring_stretch_x + slip_x if was else 0.0
    ty = old.tangential_spring_stretch_y + slip_y if was else 0.0
    depth = -(predicted_body.centre_position.z + r.z)
    depth = 0.0 if deferred & (depth > 0.0) else depth
    n = body.point_normal_stiffness_per_mass * depth - body.point_dashpot_constant_per_mass * u.z
    in_contact = (
        ((n > 0.0) | flat) & (depth > 0.0) if contact_vibration_is_resolved else old.normal_force_per_mass != 0.0
    )
    hx = -(body.point_tangential_stiffness_per_mass * tx) - body.point_dashpot_constant_per_mass * u.x
    hy = -(body.point_tangential_stiffness_per_mass * ty) - body.point_dashpot_constant_per_mass * u.y
    square = hx * hx + hy * hy
    some = square > 0.0
    one = 1.0 / math.sqrt(square if some else 1.0)
    dx, dy = hx * one, hy * one
    most = body.friction * (n if contact_vibration_is_resolved else old.normal_force_per_mass)
    smooth = body.friction == 0.0
    drift_x, drift_y, drifts, tilting = slip_direction_and_tilting_share_in_flat_landing(
        body, r, predicted_body.end_velocity, predicted_body.end_angular_velocity, (flat, base_tilting)
    )
    dx, dy = (-drift_x if drifts else dx), (-drift_y if drifts else dy)
    slides = square > most * most if contact_vibration_is_resolved else old.slid_in_last_step_or_rejected_attempt > 0.0
    slides = drifts if flat else slides | smooth
    # A normal force on a sliding point must push it out; where friction would rotate the body in instead, it sticks.
    turn = angular_velocity_from_momentum(body.mass_times_inverse_inertia, body_axes, Vector3(
        r.y - r.z * body.friction * dy, r.z * body.friction * dx - r.x,
        body.friction * (r.x * dy - r.y * dx),
    ))  # fmt: skip
    free = 1.0 + (turn.x * r.y - turn.y * r.x) > MIN_MOBILITY_RATIO_WITHOUT_FORCED_STICKING
    slides = in_contact & slides & (some | smooth | drifts) & free
    return PredictedContactPoint(
        position_from_centre=r,
        penetration=depth,
        tangential_spring_stretch_x=tx,
        tangential_spring_stretch_y=ty,
        velocity=u,
        is_assumed_in_contact=1.0 if in_contact else 0.0,
        is_assumed_to_slide=1.0 if slides else 0.0,
        friction_direction_x=dx,
        friction_direction_y=dy,
        is_load_deferred_until_both_base_ends_rest=1.0 if deferred else 0.0,
        body_lands_flat=1.0 if flat else 0.0,
        tilting_share_of_friction_moment=tilting,
        tilting_share_of_friction_moment_in_flat_landing=base_tilting,
        flat_landing_time_left_if_contact_begins_now=new_landing,
    )


# 2. Solve -------------------------------------------------------------------------------------------------------------


@njit(**INLINE_OPTIONS)
def sliding_point_friction_to_sticking_force_ratio(
    friction_limit: float, squared_sticking_force: float, is_assumed_to_slide: bool
) -> float:
    """Return the ratio, clipped to 0…1, of a sliding point's friction limit to the force that would make it stick.

    The value has no meaning for a point that is not assumed to slide.
    """
    part = friction_limit / math.sqrt(squared_sticking_force if is_assumed_to_slide else 1.0)
    part = part if part < 1.0 else 1.0
    return part if part > 0.0 else 0.0


@njit(**INLINE_OPTIONS)
def contact_force_and_derivatives_of_point(
    body: BodyConstants,
    half_step_length_s: float,
    predicted_point: PredictedContactPoint,
    point_state_at_step_start: BodyContactPointState,
    contact_vibration_is_resolved: bool,
) -> ContactForcesAndNegatedVelocityDerivatives:
    """Return the terms of one contact point in the linear equations for a body's velocity corrections in a step.

    The force at the end of the step is f' = f − G (e_v + e_w × r): f is the force at the predicted velocities, e_v
    and e_w are the corrections of velocity and angular velocity, r is the position of the point. The returned
    derivatives are multiplied by half the step. Friction of a sliding point is μ times its normal force. Across the
    direction of friction, G is that of a sticking point times the ratio of the friction limit to the force that would
    make the point stick.
    """
    on = predicted_point.is_assumed_in_contact > 0.0
    slides = predicted_point.is_assumed_to_slide > 0.0
    r = predicted_point.position_from_centre
    u = predicted_point.velocity
    press = body.point_dashpot_constant_per_mass + half_step_length_s * body.point_normal_stiffness_per_mass
    stick = body.point_dashpot_constant_per_mass + half_step_length_s * body.point_tangential_stiffness_per_mass
    n = body.point_normal_stiffness_per_mass * predicted_point.penetration - body.point_dashpot_constant_per_mass * u.z
    hx, hy = (
        -(body.point_tangential_stiffness_per_mass * predicted_point.tangential_spring_stretch_x)
        - body.point_dashpot_constant_per_mass * u.x,
        -(body.point_tangential_stiffness_per_mass * predicted_point.tangential_spring_stretch_y)
        - body.point_dashpot_constant_per_mass * u.y,
    )
    part = sliding_point_friction_to_sticking_force_ratio(
        body.friction * (n if contact_vibration_is_resolved else point_state_at_step_start.normal_force_per_mass),
        hx * hx + hy * hy,
        slides,
    )
    mx, my = body.friction * predicted_point.friction_direction_x, body.friction * predicted_point.friction_direction_y
    fx, fy = (mx * n if slides else hx), (my * n if slides else hy)
    across = half_step_length_s * (stick * part if slides else stick)
    gxx = across * (
        1.0 - predicted_point.friction_direction_x * predicted_point.friction_direction_x if slides else 1.0
    )
    gyy = across * (
        1.0 - predicted_point.friction_direction_y * predicted_point.friction_direction_y if slides else 1.0
    )
    gxy = -(across * (predicted_point.friction_direction_x * predicted_point.friction_direction_y)) if slides else 0.0
    gzz = half_step_length_s * press
    gxz, gyz = (mx * gzz if slides else 0.0), (my * gzz if slides else 0.0)
    n, fx, fy = (n if on else 0.0), (fx if on else 0.0), (fy if on else 0.0)
    gxx, gyy, gxy = (gxx if on else 0.0), (gyy if on else 0.0), (gxy if on else 0.0)
    gxz, gyz, gzz = (gxz if on else 0.0), (gyz if on else 0.0), (gzz if on else 0.0)
    f = Vector3(fx, fy, n)
    # Rows of G(·× r), and the moments r × column of both; zero terms are left out. In a flat landing the moment of
    # friction has a shorter lever arm.
    at = Vector3(r.x, r.y, predicted_point.tilting_share_of_friction_moment * r.z)
    bx, by = cross_product(r, Vector3(gxx, gxy, gxz)), cross_product(r, Vector3(gxy, gyy, gyz))
    bz = Vector3(r.y * gzz, -(r.x * gzz), 0.0)
    cz = cross_product(at, Vector3(gxz, gyz, gzz))
    dx, dy = cross_product(at, Vector3(bx.x, by.x, bz.x)), cross_product(at, Vector3(bx.y, by.y, bz.y))
    dz = cross_product(at, Vector3(bx.z, by.z, bz.z))
    return ContactForcesAndNegatedVelocityDerivatives(
        f,
        cross_product(at, f),
        Matrix3(gxx, gxy, gxz, gxy, gyy, gyz, 0.0, 0.0, gzz),
        Matrix3(bx.x, bx.y, bx.z, by.x, by.y, by.z, bz.x, bz.y, bz.z),
        Matrix3(
            -(at.z * gxy), -(at.z * gyy), cz.x, at.z * gxx, at.z * gxy, cz.y,
            r.x * gxy - r.y * gxx, r.x * gyy - r.y * gxy, cz.z,
        ),
        Matrix3(dx.x, dy.x, dz.x, dx.y, dy.y, dz.y, dx.z, dy.z, dz.z),
    )  # fmt: skip


@njit(**INLINE_OPTIONS)
def solve_velocity_correction(
    body: BodyConstants,
    state_at_step_start: BodyState,
    predicted_body: BodyPredictedForStepEnd,
    contact_terms_of_all_points: ContactForcesAndNegatedVelocityDerivatives,
) -> BodyVelocityCorrection:
    """Solve the linear equations of a step for the corrections of a body's predicted velocity and angular velocity."""
    a = contact_terms_of_all_points.half_step_times_force_decrease_per_velocity
    b = contact_terms_of_all_points.half_step_times_force_decrease_per_angular_velocity
    c = contact_terms_of_all_points.half_step_times_moment_decrease_per_velocity
    d = contact_terms_of_all_points.half_step_times_moment_decrease_per_angular_velocity
    u = scale_vector(
        predicted_body.half_step_length_s,
        minus(
            acceleration_of_body_centre_relative_to_base(
                contact_terms_of_all_points.force_per_mass,
                predicted_body.negative_horizontal_and_upward_base_acceleration,
            ),
            state_at_step_start.acceleration_relative_to_base,
        ),
    )
    t = scale_vector(
        predicted_body.half_step_length_s,
        minus(contact_terms_of_all_points.moment_per_mass, state_at_step_start.contact_moment_per_mass),
    )
    f = rotation_matrix(predicted_body.rotation)
    i = matrix_product(matrix_product(f, expand_symmetric_matrix(body.inertia_per_mass)), transpose(f))
    a = inverse_matrix(Matrix3(1.0 + a.xx, a.xy, a.xz, a.yx, 1.0 + a.yy, a.yz, a.zx, a.zy, 1.0 + a.zz))
    c = matrix_product(c, a)
    e = matrix_times_vector(
        inverse_matrix(matrix_minus(matrix_plus(i, d), matrix_product(c, b))), minus(t, matrix_times_vector(c, u))
    )
    return BodyVelocityCorrection(matrix_times_vector(a, minus(u, matrix_times_vector(b, e))), e)
