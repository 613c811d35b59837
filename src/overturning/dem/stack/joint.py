"""Friction of a joint, and the equations of its contact (docs/method.md); `joint_point` has the normal forces.

Friction acts at the centre of pressure: a spring in each tangential direction and one against twist. The twist counts
as a displacement at the mean distance r of the normal forces from that centre, so that the three are one vector, which
is limited by μ N: a moment alone by μ Σ n r.
"""

import math
from typing import NamedTuple

from numba import njit

from overturning.dem.body.centred import sliding_point_friction_to_sticking_force_ratio
from overturning.dem.body.vectors import Matrix3, Vector3, plus
from overturning.dem.kernel.lanes import INLINE_OPTIONS
from overturning.dem.kernel.mechanics import base_slides_in_flat_landing
from overturning.dem.stack.joint_state import (
    AssumedJointFrictionInStep,
    JointConstants,
    JointContactState,
    JointFrictionSolutionInputs,
    JointNormalForceSumsWithDerivatives,
    JointRelativePoseAndVelocity,
    NormalForceAndEarlyContactImpulseSums,
    PredictedJointForceAndDerivatives,
    TangentialVectorWithScaledTwist,
    scale_tangent_twist_vector,
    squared_length,
    unit_tangent_twist_vector,
)
from overturning.dem.stack.state import (
    ContactPowerLossAndLostSpringEnergy,
    ForceAndMomentOrVelocities,
    LargestContactChangesOfStack,
    VelocityToForceBlocks,
)


@njit(**INLINE_OPTIONS)
def tangential_contact_force(
    joint_constants: JointConstants,
    tangential_spring_stretch: TangentialVectorWithScaledTwist,
    slip_velocity: TangentialVectorWithScaledTwist,
) -> TangentialVectorWithScaledTwist:
    """Return the tangential force between two stones (x, y, twist) from springs and dashpots at their contact, N."""
    k, h = joint_constants.tangential_stiffness, joint_constants.tangential_dashpot
    return TangentialVectorWithScaledTwist(
        -(k * tangential_spring_stretch.x) - h * slip_velocity.x,
        -(k * tangential_spring_stretch.y) - h * slip_velocity.y,
        -(k * tangential_spring_stretch.twist_times_radius) - h * slip_velocity.twist_times_radius,
    )


@njit(**INLINE_OPTIONS)
def slide_direction_and_slide_flag_in_flat_landing(
    joint_constants: JointConstants,
    relative_velocity_at_origin: Vector3,
    relative_angular_velocity: Vector3,
    centre_height_above_base: float,
    pressure_centre_xy_and_mean_force_distance: tuple[float, float, float],
) -> tuple[TangentialVectorWithScaledTwist, bool]:
    """Return the direction in which the upper stone slides in a flat landing, and True if it slides.

    Of the rotation only the part about the contact normal counts; see
    `overturning.dem.kernel.mechanics.base_slides_in_flat_landing`. `pressure_centre_xy_and_mean_force_distance` holds
    x and y of the centre of pressure, and the mean distance of the normal forces from this centre, m.
    """
    cx, cy, arm = pressure_centre_xy_and_mean_force_distance
    slip = TangentialVectorWithScaledTwist(
        (relative_velocity_at_origin.x + relative_angular_velocity.y * centre_height_above_base)
        - relative_angular_velocity.z * cy,
        (relative_velocity_at_origin.y - relative_angular_velocity.x * centre_height_above_base)
        + relative_angular_velocity.z * cx,
        arm * relative_angular_velocity.z,
    )  # fmt: skip
    square = squared_length(slip)
    up = relative_velocity_at_origin.z + (relative_angular_velocity.x * cy - relative_angular_velocity.y * cx)
    return unit_tangent_twist_vector(slip), base_slides_in_flat_landing(
        joint_constants.friction, math.sqrt(square), up
    ) & (square > 0.0)


@njit(**INLINE_OPTIONS)
def slip_velocity_at_contact(
    relative_velocity_at_origin: Vector3,
    relative_angular_velocity: Vector3,
    friction_application_point_x: float,
    friction_application_point_y: float,
    mean_distance_of_forces_from_pressure_centre: float,
) -> TangentialVectorWithScaledTwist:
    """Return the slip velocity (x, y, twist), m/s, of the upper stone on the lower one at a point of the contact."""
    return TangentialVectorWithScaledTwist(
        relative_velocity_at_origin.x - relative_angular_velocity.z * friction_application_point_y,
        relative_velocity_at_origin.y + relative_angular_velocity.z * friction_application_point_x,
        mean_distance_of_forces_from_pressure_centre * relative_angular_velocity.z,
    )


@njit(**INLINE_OPTIONS)
def spring_stretch_after_step(
    stretch_at_step_start: TangentialVectorWithScaledTwist,
    half_step_length_s: float,
    slip_velocity_at_start: TangentialVectorWithScaledTwist,
    slip_velocity_at_end: TangentialVectorWithScaledTwist,
) -> TangentialVectorWithScaledTwist:
    """Return the stretch of a tangential spring after a step with given slip velocities at its start and end."""
    first, second = slip_velocity_at_start, slip_velocity_at_end
    return TangentialVectorWithScaledTwist(
        stretch_at_step_start.x + half_step_length_s * (first.x + second.x),
        stretch_at_step_start.y + half_step_length_s * (first.y + second.y),
        stretch_at_step_start.twist_times_radius
        + half_step_length_s * (first.twist_times_radius + second.twist_times_radius),
    )


@njit(**INLINE_OPTIONS)
def predict_friction(
    joint_constants: JointConstants, relative_motion: JointRelativePoseAndVelocity,
    normal_force_sums: JointNormalForceSumsWithDerivatives,
    joint_state_at_step_start: JointContactState, half_step_and_flat_landing_conditions: JointFrictionSolutionInputs,
) -> AssumedJointFrictionInStep:  # fmt: skip
    """Predict tangential spring stretch, sliding and friction direction between two stones for a step's equations."""
    joint, frame, sums, previous = joint_constants, relative_motion, normal_force_sums, joint_state_at_step_start
    half_step, forces_decide_contact, lands_flat, centre_height = half_step_and_flat_landing_conditions
    was, loaded = previous.normal_force > 0.0, sums.normal_force > 0.0
    one = 1.0 / (sums.normal_force if loaded else 1.0)
    cx = previous.pressure_centre_x if was else (sums.normal_force_times_x * one if loaded else 0.0)
    cy = previous.pressure_centre_y if was else (sums.normal_force_times_y * one if loaded else 0.0)
    spin, arm = frame.angular_velocity, previous.mean_distance_of_forces_from_pressure_centre
    velocity = slip_velocity_at_contact(frame.velocity_at_origin, spin, cx, cy, arm)
    stretch = scale_tangent_twist_vector(
        1.0 if was else 0.0,
        spring_stretch_after_step(
            previous.tangential_spring_stretch, half_step, previous.slip_velocity_at_pressure_centre, velocity
        ),
    )
    force = tangential_contact_force(joint, stretch, velocity)
    most = joint.friction * (sums.normal_force if forces_decide_contact | (not was) else previous.normal_force)
    slip, drifts = slide_direction_and_slide_flag_in_flat_landing(
        joint, frame.velocity_at_origin, spin, centre_height, (cx, cy, arm)
    )
    drifts = drifts & lands_flat
    square, smooth, decides = squared_length(force), joint.friction == 0.0, forces_decide_contact | (not was)
    slides = square > most * most if decides else previous.slid_in_last_step_or_rejected_attempt > 0.0
    slides = drifts if lands_flat else slides | smooth
    slides = slides & ((square > 0.0) | smooth | drifts)
    direction = unit_tangent_twist_vector(force)
    dx = -slip.x if drifts else direction.x
    dy = -slip.y if drifts else direction.y
    dt = -slip.twist_times_radius if drifts else direction.twist_times_radius
    cz = centre_height * (1.0 - joint.tilting_share_of_friction_moment_in_flat_landing) if drifts else 0.0
    in_contact, sliding = (1.0 if loaded else 0.0), (1.0 if loaded & slides else 0.0)
    return AssumedJointFrictionInStep(
        cx, cy, cz, arm, stretch, velocity, in_contact, sliding, TangentialVectorWithScaledTwist(dx, dy, dt)
    )


@njit(**INLINE_OPTIONS)
def predicted_joint_force_moment_and_derivatives(
    joint_constants: JointConstants,
    normal_force_sums: JointNormalForceSumsWithDerivatives,
    assumed_friction: AssumedJointFrictionInStep,
    half_step_length_s: float,
    normal_force_for_friction_across_sliding: float,
) -> PredictedJointForceAndDerivatives:
    """Return predicted force and moment (about the contact frame's origin) on the upper stone, and derivatives.

    `PredictedJointForceAndDerivatives` describes the derivatives. Friction across the direction of sliding is limited
    by μ × `normal_force_for_friction_across_sliding`, N.
    """
    joint, sums, friction = joint_constants, normal_force_sums, assumed_friction
    in_contact, slides = friction.is_assumed_loaded > 0.0, friction.is_assumed_to_slide > 0.0
    d = friction.friction_direction
    held = tangential_contact_force(joint, friction.tangential_spring_stretch, friction.slip_velocity_at_friction_point)
    part = sliding_point_friction_to_sticking_force_ratio(
        joint.friction * normal_force_for_friction_across_sliding, squared_length(held), slides
    )
    mu = joint.friction if slides & in_contact else 0.0
    mx, my, mt = mu * d.x, mu * d.y, mu * d.twist_times_radius
    fx, fy, ft = (
        (mx * sums.normal_force if slides else held.x), (my * sums.normal_force if slides else held.y),
        (mt * sums.normal_force if slides else held.twist_times_radius),
    )  # fmt: skip
    fx, fy, ft = (fx if in_contact else 0.0), (fy if in_contact else 0.0), (ft if in_contact else 0.0)
    stick = half_step_length_s * (joint.tangential_dashpot + half_step_length_s * joint.tangential_stiffness)
    across = stick * part if slides else stick
    across = across if in_contact else 0.0
    along = across if slides else 0.0
    a, b, c = across - along * (d.x * d.x), -(along * (d.x * d.y)), across - along * (d.y * d.y)
    ta = -(along * (d.x * d.twist_times_radius))
    tb = -(along * (d.y * d.twist_times_radius))
    tt = across - along * (d.twist_times_radius * d.twist_times_radius)
    cx = friction.friction_application_point_x
    cy = friction.friction_application_point_y
    cz = friction.friction_application_point_height_above_lower_face
    arm, g = (
        friction.mean_distance_of_forces_from_pressure_centre,
        sums.half_step_times_normal_force_decrease_per_velocity,
    )
    gx, gy = (
        sums.half_step_times_normal_force_decrease_per_velocity_times_x,
        sums.half_step_times_normal_force_decrease_per_velocity_times_y,
    )
    # Rows of the tangential forces by velocity and angular velocity; the slip is (ex - wz cy, ey + wz cx, arm wz).
    xv, xw = Vector3(a, b, mx * g), Vector3(mx * gy, -(mx * gx), (b * cx - a * cy) + ta * arm)
    yv, yw = Vector3(b, c, my * g), Vector3(my * gy, -(my * gx), (c * cx - b * cy) + tb * arm)
    tv, tw = Vector3(ta, tb, mt * g), Vector3(mt * gy, -(mt * gx), (tb * cx - ta * cy) + tt * arm)
    zv, zw = Vector3(0.0, 0.0, g), Vector3(gy, -gx, 0.0)
    pv = Vector3(-(cz * yv.x), -(cz * yv.y), gy - cz * yv.z)
    pw = Vector3(
        sums.half_step_times_normal_force_decrease_per_velocity_times_y_squared - cz * yw.x,
        -sums.half_step_times_normal_force_decrease_per_velocity_times_xy - cz * yw.y,
        -(cz * yw.z),
    )
    qv = Vector3(cz * xv.x, cz * xv.y, -gx + cz * xv.z)
    qw = Vector3(
        -sums.half_step_times_normal_force_decrease_per_velocity_times_xy + cz * xw.x,
        sums.half_step_times_normal_force_decrease_per_velocity_times_x_squared + cz * xw.y,
        cz * xw.z,
    )
    rv = Vector3(
        (cx * yv.x - cy * xv.x) + arm * tv.x, (cx * yv.y - cy * xv.y) + arm * tv.y,
        (cx * yv.z - cy * xv.z) + arm * tv.z,
    )  # fmt: skip
    rw = Vector3(
        (cx * yw.x - cy * xw.x) + arm * tw.x, (cx * yw.y - cy * xw.y) + arm * tw.y,
        (cx * yw.z - cy * xw.z) + arm * tw.z,
    )  # fmt: skip
    return PredictedJointForceAndDerivatives(
        ForceAndMomentOrVelocities(
            Vector3(fx, fy, sums.normal_force),
            Vector3(
                sums.normal_force_times_y - cz * fy,
                -sums.normal_force_times_x + cz * fx,
                (cx * fy - cy * fx) + arm * ft,
            ),
        ),
        VelocityToForceBlocks(
            Matrix3(xv.x, xv.y, xv.z, yv.x, yv.y, yv.z, zv.x, zv.y, zv.z),
            Matrix3(xw.x, xw.y, xw.z, yw.x, yw.y, yw.z, zw.x, zw.y, zw.z),
            Matrix3(pv.x, pv.y, pv.z, qv.x, qv.y, qv.z, rv.x, rv.y, rv.z),
            Matrix3(pw.x, pw.y, pw.z, qw.x, qw.y, qw.z, rw.x, rw.y, rw.z),
        ),
    )


class AssumedAndActualJointSlidingFlags(NamedTuple):
    """Flags to compare assumed and actual sliding of two stones in a step, and conditions under which this counts."""

    has_friction_limit_above_zero: bool
    carries_force: bool
    assumption_follows_last_step_state: bool
    was_assumed_to_slide: bool
    slides: bool


@njit(**INLINE_OPTIONS)
def differences_of_friction_from_assumption(
    assumed_friction_direction: TangentialVectorWithScaledTwist, end_friction_force: TangentialVectorWithScaledTwist,
    end_slip_velocity: TangentialVectorWithScaledTwist, stretch_at_step_start: TangentialVectorWithScaledTwist,
    joint_friction_flags: AssumedAndActualJointSlidingFlags,
) -> LargestContactChangesOfStack:  # fmt: skip
    """Return how friction of two stones at the end of a step differs from that assumed in its equations.

    `assumed_friction_direction` is a unit vector; `stretch_at_step_start` is that of the tangential springs, m.
    """
    direction = assumed_friction_direction
    force = end_friction_force
    velocity = end_slip_velocity
    stretch = stretch_at_step_start
    carries, loaded, coarse, assumed, slips = joint_friction_flags
    wrong = carries & (slips != assumed)
    backwards = (
        carries
        & assumed
        & (
            ((force.x * direction.x + force.y * direction.y) + force.twist_times_radius * direction.twist_times_radius)
            < 0.0
        )
    )
    back = (
        carries
        & slips
        & (
            ((force.x * stretch.x + force.y * stretch.y) + force.twist_times_radius * stretch.twist_times_radius > 0.0)
            | (
                (force.x * velocity.x + force.y * velocity.y) + force.twist_times_radius * velocity.twist_times_radius
                > 0.0
            )
        )
    )
    return LargestContactChangesOfStack(
        positive_if_contact_opened_or_closed=0.0,
        has_wrong_slip_assumption=1.0 if wrong & coarse else 0.0,
        has_friction_opposite_to_assumption=1.0 if backwards & coarse else 0.0,
        has_sticking_loaded_joint=1.0 if carries & (not slips) else 0.0,
        friction_sign_changed_in_step=1.0 if back & coarse else 0.0,
        some_point_carries_no_load=0.0,
        largest_penetration=0.0,
        has_loaded_joint=1.0 if loaded else 0.0,
    )


@njit(**INLINE_OPTIONS)
def joint_contact_forces_and_state_at_step_end(
    joint_constants: JointConstants, relative_motion: JointRelativePoseAndVelocity,
    assumed_friction: AssumedJointFrictionInStep,
    point_sums_and_force_times_distance_sum: tuple[NormalForceAndEarlyContactImpulseSums, float],
    relative_velocity_and_spin_changes: tuple[Vector3, Vector3], joint_state_at_step_start: JointContactState,
    half_step_and_flat_landing_conditions: JointFrictionSolutionInputs,
) -> tuple[ForceAndMomentOrVelocities, ForceAndMomentOrVelocities, LargestContactChangesOfStack,
ContactPowerLossAndLostSpringEnergy,
JointContactState]:  # fmt: skip
    """Return forces, early impulses, changes, losses and new state of two stones' contact from a step's solution.

    Forces, and impulses of points that closed early in the step, come with moments about the contact frame's origin.
    `point_sums_and_force_times_distance_sum` holds the sums over the contact points and Σ normal force × distance
    from the pressure centre (N·m).
    """
    joint, friction, change = joint_constants, assumed_friction, relative_velocity_and_spin_changes
    half_step, forces_decide_contact, lands_flat, centre_height = half_step_and_flat_landing_conditions
    ends, arm_sum = point_sums_and_force_times_distance_sum
    cx, cy = friction.friction_application_point_x, friction.friction_application_point_y
    arm = friction.mean_distance_of_forces_from_pressure_centre
    more = slip_velocity_at_contact(change[0], change[1], cx, cy, arm)
    first = friction.slip_velocity_at_friction_point
    twist = first.twist_times_radius + more.twist_times_radius
    velocity = TangentialVectorWithScaledTwist(first.x + more.x, first.y + more.y, twist)
    loaded, zero = ends.normal_force > 0.0, TangentialVectorWithScaledTwist(0.0, 0.0, 0.0)
    stretch = scale_tangent_twist_vector(
        1.0 if loaded else 0.0, spring_stretch_after_step(friction.tangential_spring_stretch, half_step, more, zero)
    )
    most = joint.friction * ends.normal_force
    force = tangential_contact_force(joint, stretch, velocity)
    at_origin = plus(relative_motion.velocity_at_origin, change[0])
    spin = plus(relative_motion.angular_velocity, change[1])
    slip, drifts = slide_direction_and_slide_flag_in_flat_landing(joint, at_origin, spin, centre_height, (cx, cy, arm))
    drifts = drifts & lands_flat
    hx, hy = (-slip.x if drifts else force.x), (-slip.y if drifts else force.y)
    ht = -slip.twist_times_radius if drifts else force.twist_times_radius
    square = squared_length(TangentialVectorWithScaledTwist(hx, hy, ht))
    # The equations of a joint assumed to slide contain no dashpot, so its force without a limit would be unstable.
    slips = (
        drifts | ((friction.is_assumed_to_slide > 0.0) & (square > most * most)) if lands_flat else square > most * most
    )
    share = most / math.sqrt(square if slips & (square > 0.0) else 1.0) if slips else 1.0
    share = share if loaded else 0.0
    fx, fy, ft = share * hx, share * hy, share * ht
    # Springs are shortened to what friction can hold.
    holds, long = most * joint.tangential_compliance_or_zero_without_spring, squared_length(stretch)
    cut = slips & (long > holds * holds)
    kept = scale_tangent_twist_vector(holds / math.sqrt(long if cut else 1.0) if cut else 1.0, stretch)
    cz = centre_height * (1.0 - joint.tilting_share_of_friction_moment_in_flat_landing) if drifts else 0.0
    k = joint.tangential_stiffness
    power = -(
        ((fx + k * kept.x) * (velocity.x + spin.y * cz) + (fy + k * kept.y) * (velocity.y - spin.x * cz))
        + (ft + k * kept.twist_times_radius) * velocity.twist_times_radius
    ) + k * cz * (kept.x * spin.y - kept.y * spin.x)
    s = joint_state_at_step_start.tangential_spring_stretch
    released = ((s.x + kept.x) * (stretch.x - kept.x) + (s.y + kept.y) * (stretch.y - kept.y)) + (
        s.twist_times_radius + kept.twist_times_radius
    ) * (stretch.twist_times_radius - kept.twist_times_radius)
    let_go = (
        0.5 * k * (released if loaded else (squared_length(s) if joint_state_at_step_start.normal_force > 0.0 else 0.0))
    )
    findings = differences_of_friction_from_assumption(
        friction.friction_direction, TangentialVectorWithScaledTwist(fx, fy, ft), velocity, s,
        AssumedAndActualJointSlidingFlags(most > 0.0, loaded, not forces_decide_contact,
        friction.is_assumed_to_slide > 0.0, slips),
    )  # fmt: skip
    one = 1.0 / (ends.normal_force if loaded else 1.0)
    early = ends.extra_impulse_of_points_closed_early_in_step * one if loaded else 0.0
    mx, my, mz = -(cz * fy), cz * fx, (cx * fy - cy * fx) + arm * ft
    at_end = ForceAndMomentOrVelocities(
        Vector3(fx, fy, ends.normal_force), Vector3(ends.normal_force_times_y + mx, -ends.normal_force_times_x + my, mz)
    )
    sooner = ForceAndMomentOrVelocities(
        Vector3(early * fx, early * fy, ends.extra_impulse_of_points_closed_early_in_step),
        Vector3(
            ends.early_contact_impulse_times_y + early * mx,
            -ends.early_contact_impulse_times_x + early * my,
            early * mz,
        ),
    )
    in_contact = 1.0 if loaded else 0.0
    new = JointContactState(
        kept, velocity, ends.normal_force_times_x * one * in_contact, ends.normal_force_times_y * one * in_contact,
        arm_sum * one * in_contact,
        ends.normal_force if loaded else 0.0, 1.0 if slips & (most != 0.0) else 0.0, 0.0,
    )  # fmt: skip
    return at_end, sooner, findings, ContactPowerLossAndLostSpringEnergy(power, let_go + early * power), new
