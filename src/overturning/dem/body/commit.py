"""Third part of a step of the centred scheme for a 3-D body: forces at the end of the step, and the new state."""

import math
from typing import Final, NamedTuple

from numba import njit

from overturning.dem.body.centred import (
    acceleration_of_body_centre_relative_to_base,
    slip_direction_and_tilting_share_in_flat_landing,
)
from overturning.dem.body.state import (
    BodyConstants,
    BodyContactPointState,
    BodyEnergyAndMomentumAccount,
    BodyPeaksAndLastUprightTick,
    BodyPredictedForStepEnd,
    BodyState,
    BodyVelocityCorrection,
    ContactForceAndMomentSum,
    InertialAndUpwardBaseAccelerations3D,
    LargestContactChangesOfBody,
    PredictedContactPoint,
    squared_sine_of_lean_continued_beyond_90_deg,
)
from overturning.dem.body.vectors import (
    Vector3,
    cross_product,
    extrapolate_vector,
    plus,
    rotate_quaternion,
    rotation_matrix,
    scale_vector,
)
from overturning.dem.kernel.clock import StepContactChanges
from overturning.dem.kernel.ground import base_acceleration_in_this_or_next_sample
from overturning.dem.kernel.lanes import INLINE_OPTIONS
from overturning.dem.kernel.mechanics import limit_friction_force_and_stretch_and_test_slip, updated_maximum
from overturning.units import STANDARD_GRAVITY as GRAVITY

MAX_LOWEST_RIM_POINT_ROTATION_TANGENT_IN_STEP: Final = 0.1
"""Largest tangent of the angle by which the lowest point moves along a rim in a step that is not the finest."""


@njit(**INLINE_OPTIONS)
def point_spring_energy_loss_per_mass(
    body: BodyConstants,
    point_state_at_step_start: BodyContactPointState,
    penetration_at_step_end: float,
    tangential_stretch_before_slip: tuple[float, float],
    tangential_stretch_after_slip: tuple[float, float],
) -> float:
    """Return the spring energy that a contact point loses in a step when it slips or opens, per mass, m²/s².

    `tangential_stretch_before_slip` and `tangential_stretch_after_slip` are the stretches (m) of the tangential springs
    at the end of the step, before and after slip or opening reduces them.
    """
    kx, ky = tangential_stretch_after_slip
    inside, was = penetration_at_step_end > 0.0, point_state_at_step_start.penetration > 0.0
    sinking = penetration_at_step_end - point_state_at_step_start.penetration
    over = penetration_at_step_end * point_state_at_step_start.penetration
    over = math.copysign(over if over < 0.0 else 0.0, sinking)
    stretched_x, stretched_y = tangential_stretch_before_slip[0] - kx, tangential_stretch_before_slip[1] - ky
    let_go = 0.5 * (
        body.point_tangential_stiffness_per_mass
        * (
            (point_state_at_step_start.tangential_spring_stretch_x + kx) * stretched_x
            + (point_state_at_step_start.tangential_spring_stretch_y + ky) * stretched_y
        )
        + body.point_normal_stiffness_per_mass * over
    )
    let_go = let_go if inside | was else 0.0
    # A deferred point starts with a compressed spring.
    return (
        let_go - 0.5 * body.point_normal_stiffness_per_mass * (penetration_at_step_end * penetration_at_step_end)
        if inside & (point_state_at_step_start.penetration == 0.0)
        else let_go
    )


@njit(**INLINE_OPTIONS)
def contact_changes_of_point(
    predicted_point: PredictedContactPoint,
    point_state_at_step_start: BodyContactPointState,
    penetration_at_step_end: float,
    contact_force_per_mass: Vector3,
    point_velocity: Vector3,
    friction_limit_per_mass: float,
    point_slides: bool,
    contact_vibration_is_resolved: bool,
) -> LargestContactChangesOfBody:
    """Return the changes (opening, closing, sliding…) of one contact point of a body in an attempted step.

    If the predicted forces decided about its contact (`contact_vibration_is_resolved`), sliding contrary to the
    assumption does not count as a change.
    """
    carries = friction_limit_per_mass > 0.0
    assumed = predicted_point.is_assumed_to_slide > 0.0
    long = not contact_vibration_is_resolved
    deeper = (
        predicted_point.penetration
        if predicted_point.penetration > penetration_at_step_end
        else penetration_at_step_end
    )
    wrong = carries & (point_slides != assumed)
    backwards = (
        carries
        & assumed
        & (
            contact_force_per_mass.x * predicted_point.friction_direction_x
            + contact_force_per_mass.y * predicted_point.friction_direction_y
            < 0.0
        )
    )
    # In a long step the spring is stretched although the point comes back; the velocity shows this.
    back = (
        carries
        & point_slides
        & (
            (
                contact_force_per_mass.x * point_state_at_step_start.tangential_spring_stretch_x
                + contact_force_per_mass.y * point_state_at_step_start.tangential_spring_stretch_y
                > 0.0
            )
            | (contact_force_per_mass.x * point_velocity.x + contact_force_per_mass.y * point_velocity.y > 0.0)
        )
    )
    changed = -penetration_at_step_end if point_state_at_step_start.penetration > 0.0 else deeper
    return LargestContactChangesOfBody(
        changed, 1.0 if wrong & long else 0.0, 1.0 if backwards & long else 0.0,
        1.0 if carries & (not point_slides) else 0.0, 1.0 if back & long else 0.0,
        0.0 if contact_force_per_mass.z > 0.0 else 1.0, penetration_at_step_end,
    )  # fmt: skip


@njit(**INLINE_OPTIONS)
def compute_point_forces(
    body: BodyConstants,
    predicted_body: BodyPredictedForStepEnd,
    predicted_point: PredictedContactPoint,
    point_state_at_step_start: BodyContactPointState,
    velocity_correction: BodyVelocityCorrection,
    contact_vibration_is_resolved: bool,
    base_is_round: bool,
) -> tuple[ContactForceAndMomentSum, LargestContactChangesOfBody, BodyContactPointState]:
    """Return a contact point's forces and losses per body mass, contact changes and state at the end of a step."""
    half, r, old = predicted_body.half_step_length_s, predicted_point.position_from_centre, point_state_at_step_start
    e = plus(velocity_correction.velocity, cross_product(velocity_correction.angular_velocity, r))
    u = plus(predicted_point.velocity, e)
    depth = predicted_point.penetration - half * e.z
    tx = predicted_point.tangential_spring_stretch_x + half * e.x
    ty = predicted_point.tangential_spring_stretch_y + half * e.y
    depth = 0.0 if (predicted_point.is_load_deferred_until_both_base_ends_rest > 0.0) & (depth > 0.0) else depth
    inside, was = depth > 0.0, old.penetration > 0.0
    spring = body.point_normal_stiffness_per_mass * depth if inside else 0.0
    n = spring - body.point_dashpot_constant_per_mass * u.z
    n = n if inside & ((predicted_point.body_lands_flat > 0.0) | (n > 0.0)) else 0.0
    tx, ty = (tx if inside else 0.0), (ty if inside else 0.0)
    most = body.friction * n
    stiffness, dashpot = body.point_tangential_stiffness_per_mass, body.point_dashpot_constant_per_mass
    hx, hy = -(stiffness * tx) - dashpot * u.x, -(stiffness * ty) - dashpot * u.y
    spin = plus(predicted_body.end_angular_velocity, velocity_correction.angular_velocity)
    drift_x, drift_y, drifts, tilting = slip_direction_and_tilting_share_in_flat_landing(
        body, r, plus(predicted_body.end_velocity, velocity_correction.velocity), spin,
        (predicted_point.body_lands_flat > 0.0, predicted_point.tilting_share_of_friction_moment_in_flat_landing),
    )  # fmt: skip
    hx, hy = (-drift_x if drifts else hx), (-drift_y if drifts else hy)
    lands_flat = (predicted_point.body_lands_flat > 0.0) & inside
    fx, fy, kx, ky, slips = limit_friction_force_and_stretch_and_test_slip(
        hx, hy, tx, ty, most, body.point_tangential_compliance_times_mass, (lands_flat, drifts)
    )
    lever = Vector3(r.x, r.y, tilting * r.z)
    off = r.z - lever.z
    # Friction acts at the shortened lever arm; the springs are stretched at the point itself.
    sliding = (fx + stiffness * kx) * u.x + (fy + stiffness * ky) * u.y
    power = (spring - n) * u.z - (sliding + off * (fy * spin.x - fx * spin.y))
    before_slip = (
        predicted_point.tangential_spring_stretch_x + half * e.x,
        predicted_point.tangential_spring_stretch_y + half * e.y,
    )
    let_go = point_spring_energy_loss_per_mass(body, old, depth, before_slip, (kx, ky))
    # A contact that closed within the step acts from the first touch, not for half of the step.
    fresh = inside & (not was)
    more = depth * (2.0 * half / (depth - old.penetration if fresh else 1.0)) - half if fresh else 0.0
    landing = (
        predicted_point.flat_landing_time_left_if_contact_begins_now if fresh else old.remaining_flat_landing_time
    ) - 2.0 * half
    force = Vector3(fx, fy, n)
    moment = cross_product(lever, force)
    findings = contact_changes_of_point(
        predicted_point, old, depth, force, u, most, slips, contact_vibration_is_resolved
    )
    x = u.x if base_is_round else (predicted_body.centre_position.x + r.x) + half * e.x
    y = u.y if base_is_round else (predicted_body.centre_position.y + r.y) + half * e.y
    return (
        ContactForceAndMomentSum(
            force, moment, scale_vector(more, force), scale_vector(more, moment), power, let_go + more * power
        ),
        findings,
        BodyContactPointState(
            tangential_spring_stretch_x=kx,
            tangential_spring_stretch_y=ky,
            position_x_or_rim_point_velocity_x=x,
            position_y_or_rim_point_velocity_y=y,
            penetration=depth,
            normal_force_per_mass=n,
            slid_in_last_step_or_rejected_attempt=1.0 if slips & (most != 0.0) else 0.0,
            remaining_flat_landing_time=landing if inside else 0.0,
        ),
    )


@njit(**INLINE_OPTIONS)
def lowest_rim_point_moves_too_far_in_step(
    state_at_step_start: BodyState,
    predicted_body: BodyPredictedForStepEnd,
    largest_contact_changes: LargestContactChangesOfBody,
) -> bool:
    """True if the lowest point of a tilted round base moves along its rim by too large an angle in the step."""
    a, b = rotation_matrix(state_at_step_start.rotation), rotation_matrix(predicted_body.rotation)
    across, ahead = a.xz * b.yz - a.yz * b.xz, a.xz * b.xz + a.yz * b.yz
    return (
        (largest_contact_changes.some_point_carries_no_load > 0.0)
        & (largest_contact_changes.largest_penetration > 0.0)
        & ((abs(across) > MAX_LOWEST_RIM_POINT_ROTATION_TANGENT_IN_STEP * ahead) | (ahead < 0.0))
    )


@njit(**INLINE_OPTIONS)
def base_acceleration_allows_sample_long_steps(
    inertial_and_upward_base_accelerations: InertialAndUpwardBaseAccelerations3D,
    inertial_xy_and_up_acceleration_at_step_end: Vector3,
    ticks_per_sample: float,
    max_horizontal_to_effective_gravity_ratio: float,
) -> bool:
    """True if the base acceleration stays below a limit at the end of this step and of the next sample.

    The horizontal base acceleration must be below `max_horizontal_to_effective_gravity_ratio` × (gravity + upward base
    acceleration). Above this limit, sample-long steps would let the springs vibrate too strongly, with too much sliding
    and rocking.
    """
    end = 2.0 * ticks_per_sample
    x, y, up = (
        base_acceleration_in_this_or_next_sample(
            inertial_and_upward_base_accelerations.negative_of_base_acceleration_x, end, ticks_per_sample
        ),
        base_acceleration_in_this_or_next_sample(
            inertial_and_upward_base_accelerations.inertial_acceleration_y, end, ticks_per_sample
        ),
        base_acceleration_in_this_or_next_sample(
            inertial_and_upward_base_accelerations.upward_base_acceleration, end, ticks_per_sample
        ),
    )
    first = max_horizontal_to_effective_gravity_ratio * (GRAVITY + inertial_xy_and_up_acceleration_at_step_end.z)
    second = max_horizontal_to_effective_gravity_ratio * (GRAVITY + up)
    below = (
        inertial_xy_and_up_acceleration_at_step_end.x * inertial_xy_and_up_acceleration_at_step_end.x
        + inertial_xy_and_up_acceleration_at_step_end.y * inertial_xy_and_up_acceleration_at_step_end.y
        < first * first
    ) & (x * x + y * y < second * second)
    return below & (first > 0.0) & (second > 0.0)


@njit(**INLINE_OPTIONS)
def contact_changes_in_body_step(
    largest_contact_changes: LargestContactChangesOfBody,
    normal_force_per_mass: float,
    lowest_rim_point_moves_too_far: bool,
    base_motion_is_weak_enough_for_long_steps: bool,
) -> StepContactChanges:
    """Return the contact changes of a body in an attempted step, by which the step is accepted or rejected."""
    slides = (largest_contact_changes.some_loaded_point_sticks == 0.0) & (normal_force_per_mass > 0.0)
    stands = base_motion_is_weak_enough_for_long_steps & (largest_contact_changes.some_point_carries_no_load == 0.0)
    return StepContactChanges(
        contact_opened_or_closed=largest_contact_changes.positive_if_contact_opened_or_closed > 0.0,
        motion_requires_shorter_step=lowest_rim_point_moves_too_far,
        may_accept_despite_contact_change=False,
        has_wrong_slip_assumption=largest_contact_changes.has_wrong_slip_assumption > 0.0,
        has_velocity_against_assumed_slip=largest_contact_changes.has_friction_opposite_to_assumption > 0.0,
        friction_sign_changed_in_step=largest_contact_changes.friction_sign_changed_in_step > 0.0,
        slides_on_all_points=slides,
        all_contacts_are_closed=stands,
    )


class BodyAfterAcceptedStep(NamedTuple):
    """State, peak values and energy account of a body after its last accepted step."""

    state: BodyState
    peak_values_so_far: BodyPeaksAndLastUprightTick
    energy_account: BodyEnergyAndMomentumAccount


@njit(**INLINE_OPTIONS)
def complete_body_step(
    body: BodyConstants,
    body_at_step_start: BodyAfterAcceptedStep,
    predicted_body: BodyPredictedForStepEnd,
    velocity_correction: BodyVelocityCorrection,
    contact_force_sum: ContactForceAndMomentSum,
    largest_penetration_at_step_end: float,
    step_length_ticks: float,
) -> BodyAfterAcceptedStep:
    """Return a body's state, peak values and energy account at the end of a step, valid if the step is accepted."""
    (s, peaks, account), half = body_at_step_start, predicted_body.half_step_length_s
    a, push, tick = (
        acceleration_of_body_centre_relative_to_base(
            contact_force_sum.force_per_mass, predicted_body.negative_horizontal_and_upward_base_acceleration
        ),
        predicted_body.negative_horizontal_and_upward_base_acceleration,
        s.ticks_since_sample_start + step_length_ticks,
    )
    v = plus(
        extrapolate_vector(predicted_body.velocity_at_half_step, half, a),
        contact_force_sum.extra_impulse_per_mass_from_early_closure,
    )
    momentum = plus(
        extrapolate_vector(
            predicted_body.angular_momentum_per_mass_at_half_step, half, contact_force_sum.moment_per_mass
        ),
        contact_force_sum.extra_angular_impulse_per_mass_from_early_closure,
    )
    place = extrapolate_vector(predicted_body.centre_position, half, velocity_correction.velocity)
    turn = rotate_quaternion(predicted_body.rotation, half, velocity_correction.angular_velocity)
    f = rotation_matrix(turn)
    power = (push.x * v.x + push.y * v.y) - push.z * v.z
    torque = contact_force_sum.moment_per_mass.z + (place.x * a.y - place.y * a.x)
    account = BodyEnergyAndMomentumAccount(
        account.base_motion_work_per_mass + half * (account.base_motion_power_per_mass_at_step_end + power),
        account.lost_energy_per_mass
        + (
            half * (account.dissipated_power_per_mass_at_step_end + contact_force_sum.dissipated_power_per_mass)
            + contact_force_sum.lost_spring_energy_per_mass
        ),
        account.supplied_vertical_angular_momentum_per_mass
        + (
            half * (account.vertical_torque_per_mass_at_step_end + torque)
            + (
                contact_force_sum.extra_angular_impulse_per_mass_from_early_closure.z
                + (
                    place.x * contact_force_sum.extra_impulse_per_mass_from_early_closure.y
                    - place.y * contact_force_sum.extra_impulse_per_mass_from_early_closure.x
                )
            )
        ),
        power,
        contact_force_sum.dissipated_power_per_mass,
        torque,
    )
    lean, x, y = (
        squared_sine_of_lean_continued_beyond_90_deg(f),
        place.x - body.centre_height * f.xz,
        place.y - body.centre_height * f.yz,
    )
    peaks = BodyPeaksAndLastUprightTick(
        updated_maximum(peaks.peak_lean_as_continued_squared_sine, lean),
        updated_maximum(peaks.peak_squared_base_slip, x * x + y * y),
        updated_maximum(peaks.peak_penetration, largest_penetration_at_step_end),
        tick if lean < body.critical_lean_as_continued_squared_sine else peaks.last_upright_tick_in_sample,
    )
    return BodyAfterAcceptedStep(
        BodyState(
            centre_position=place,
            rotation=turn,
            velocity_relative_to_base=v,
            angular_momentum_per_mass=momentum,
            angular_velocity=predicted_body.end_angular_velocity,
            acceleration_relative_to_base=a,
            contact_moment_per_mass=contact_force_sum.moment_per_mass,
            ticks_since_sample_start=tick,
        ),
        peaks,
        account,
    )
