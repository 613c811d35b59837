"""Mechanics shared by both schemes: motion of an element, tangential spring, friction, forces of a contact point.

The force at a contact point is ``n (n_x, n_z) + t (n_z, −n_x)`` on the pair's first element a, and the opposite on
the second, b.
"""

from typing import NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import INLINE_OPTIONS
from overturning.dem.kernel.mechanics import clamp_magnitude, rotate_cosine_and_sine_by_small_angle, updated_maximum
from overturning.dem.polygon.faces import ContactSegment, PlanarContactPoint
from overturning.dem.polygon.state import (
    CONTACT_CODE_OPEN,
    CONTACT_CODE_TRANSFERRED_FROM_OTHER_FACES,
    CONTACT_CODE_VERTEX_OF_A,
    CONTACT_CODE_VERTEX_OF_B,
    ContactPointConstants,
    ElementState,
    PairContactStateAfterLastStep,
    PlanarContactPointStateAfterLastStep,
    PlanarMotionOrForce,
    Pose,
    VertexPositionsAtOtherFace,
)


class PlanarContactPointForce(NamedTuple):
    """Normal and tangential force at a contact point of two elements, and stretch of the tangential spring."""

    normal_force: float
    """Normal force, N."""
    tangential_force: float
    """Tangential force, N."""
    tangential_spring_stretch: float
    """Stretch of the tangential spring after slip, m."""


class PlanarContactPointResult(NamedTuple):
    """Force, penetration and slip at a contact point of two elements after a step."""

    force: PlanarContactPointForce
    penetration: float
    """Penetration, m."""
    slip_of_a_in_step: float
    """Slip of a over b in the step, m."""
    is_in_contact: bool
    """True if the point is in contact."""


class PairForce(NamedTuple):
    """Resultant contact force between elements a and b, and its moments about the centres of both."""

    force_on_a_x: float
    """Force on a, N; the opposite acts on b."""
    force_on_a_z: float
    """Upward force on a, N."""
    moment_of_force_on_a_about_a: float
    """Moment about the centre of a, N m."""
    moment_of_force_on_a_about_b: float
    """Moment of the same force about the centre of b, N m; the opposite acts on b."""


class PredictedStretchAndAssumedFriction(NamedTuple):
    """Predicted tangential stretch and assumed ±μ (0: sticks) at a contact point in the equations of a step."""

    tangential_spring_stretch: float
    """Predicted stretch of the tangential spring, m."""
    signed_friction_coefficient_or_zero_if_sticking: float
    """±μ if the point is assumed to slide, else 0."""


class PairRelativeVelocityOrDirectionWithLeverArms(NamedTuple):
    """Velocity of element a relative to b and angular velocities of a and b; or a direction and lever arms."""

    x: float
    """Relative velocity, m/s, or component of the direction."""
    z: float
    """Upward component."""
    angular_velocity_or_lever_arm_of_a: float
    """Angular velocity of a, rad/s, or lever arm about its centre, m."""
    angular_velocity_or_lever_arm_of_b: float
    """Angular velocity of b, rad/s, or lever arm about its centre, m."""


class PairVelocityToForceMatrix(NamedTuple):
    """Matrix from the velocities of elements a and b to the contact forces between them.

    Force on a and its moments about a and b, per velocity of a relative to b, per angular velocity of a, and per
    negated angular velocity of b: N s/m, N s and N m s. The opposite force acts on b.
    """

    force_on_a_x_per_relative_velocity_x: float
    force_on_a_x_per_relative_velocity_z: float
    force_on_a_z_per_relative_velocity_x: float
    force_on_a_z_per_relative_velocity_z: float
    force_on_a_x_per_angular_velocity_a: float
    force_on_a_z_per_angular_velocity_a: float
    force_on_a_x_per_negated_angular_velocity_b: float
    force_on_a_z_per_negated_angular_velocity_b: float
    moment_on_a_per_relative_velocity_x: float
    moment_on_a_per_relative_velocity_z: float
    moment_on_b_per_relative_velocity_x: float
    moment_on_b_per_relative_velocity_z: float
    moment_on_a_per_angular_velocity_a: float
    moment_on_a_per_negated_angular_velocity_b: float
    moment_on_b_per_angular_velocity_a: float
    moment_on_b_per_negated_angular_velocity_b: float


@njit(**INLINE_OPTIONS)
def element_acceleration_relative_to_base(
    element: ElementState, horizontal_base_acceleration: float, upward_base_acceleration: float, gravity: float
) -> PlanarMotionOrForce:
    """Return the acceleration of an element relative to the base, m/s² and rad/s², from forces and base motion."""
    force, own = element.contact_force_sum, element.constants
    fall = gravity * own.is_subject_to_gravity + upward_base_acceleration
    return PlanarMotionOrForce(
        force.x * own.inverse_mass - horizontal_base_acceleration,
        force.z * own.inverse_mass - fall,
        force.angular * own.inverse_inertia,
    )


@njit(**INLINE_OPTIONS)
def extrapolate_velocity(
    velocity: PlanarMotionOrForce, acceleration: PlanarMotionOrForce, duration: float
) -> PlanarMotionOrForce:
    """Return the velocity of an element after `duration` (s) at constant acceleration."""
    return PlanarMotionOrForce(
        velocity.x + duration * acceleration.x,
        velocity.z + duration * acceleration.z,
        velocity.angular + duration * acceleration.angular,
    )


@njit(**INLINE_OPTIONS)
def extrapolate_pose(pose: Pose, velocity: PlanarMotionOrForce, duration: float) -> Pose:
    """Return the pose of an element after `duration` (s) at constant velocity."""
    c, s = rotate_cosine_and_sine_by_small_angle(pose.cos, pose.sin, duration * velocity.angular)
    return Pose(
        pose.x + duration * velocity.x, pose.z + duration * velocity.z, pose.angle + duration * velocity.angular, c, s
    )


@njit(**INLINE_OPTIONS)
def power_against_inertial_or_fixing_forces(
    element: ElementState,
    horizontal_base_acceleration: float,
    upward_base_acceleration: float,
    velocity: PlanarMotionOrForce,
) -> float:
    """Return the power (W) of an element against inertial forces, or, if it is held, against the holding forces."""
    own, force = element.constants, element.contact_force_sum
    return own.mass * (
        horizontal_base_acceleration * velocity.x + upward_base_acceleration * velocity.z
    ) + own.is_fixed_in_space * (force.x * velocity.x + force.z * velocity.z)


@njit(**INLINE_OPTIONS)
def owner_code_of_contact_vertex(contact_point: PlanarContactPoint) -> float:
    """Return whether a contact point lies at a vertex of element a or of element b.

    The result is `CONTACT_CODE_VERTEX_OF_A` or `CONTACT_CODE_VERTEX_OF_B`.
    """
    return CONTACT_CODE_VERTEX_OF_A if contact_point.vertex_is_of_a > 0.0 else CONTACT_CODE_VERTEX_OF_B


@njit(**INLINE_OPTIONS)
def trial_tangential_spring_stretch(
    point_history: PlanarContactPointStateAfterLastStep,
    contact_point: PlanarContactPoint,
    contact_segment: ContactSegment,
    tangential_compliance_or_zero_without_spring: float,
    dashpot_force_opposing_slip: float,
) -> float:
    """Return the stretch (m) of the tangential spring at a contact point of two elements, before friction limits it.

    The slip of the step is added. If the contact point now lies at another vertex, the stretch is set such that the
    force does not change. A new contact starts with 0.
    """
    carrier = owner_code_of_contact_vertex(contact_point)
    share = (
        -((carrier * contact_segment.sine_of_angle_between_outward_normals) * point_history.normal_force)
        - point_history.tangential_force * contact_segment.cosine_of_angle_between_outward_normals
    )
    share = (
        point_history.tangential_force
        if point_history.contact_vertex_status_code == CONTACT_CODE_TRANSFERRED_FROM_OTHER_FACES
        else share
    )
    equivalent = -(share + dashpot_force_opposing_slip) * tangential_compliance_or_zero_without_spring
    stretch = (
        point_history.tangential_spring_stretch + contact_point.slip_of_a_in_step
        if point_history.contact_vertex_status_code == carrier
        else equivalent
    )
    return stretch if point_history.contact_vertex_status_code != CONTACT_CODE_OPEN else 0.0


@njit(**INLINE_OPTIONS)
def sum_contact_point_forces(
    point_1: PlanarContactPoint,
    point_2: PlanarContactPoint,
    force_1: PlanarContactPointForce,
    force_2: PlanarContactPointForce,
) -> PairForce:
    """Return the sum of the contact forces at both contact points of two elements, with moments about both elements."""
    return PairForce(
        (force_1.normal_force * point_1.normal_towards_a_x + force_1.tangential_force * point_1.normal_towards_a_z)
        + (force_2.normal_force * point_2.normal_towards_a_x + force_2.tangential_force * point_2.normal_towards_a_z),
        (force_1.normal_force * point_1.normal_towards_a_z - force_1.tangential_force * point_1.normal_towards_a_x)
        + (force_2.normal_force * point_2.normal_towards_a_z - force_2.tangential_force * point_2.normal_towards_a_x),
        (
            point_1.lever_arms_about_a.of_normal_force * force_1.normal_force
            + point_1.lever_arms_about_a.of_tangential_force * force_1.tangential_force
        )
        + (
            point_2.lever_arms_about_a.of_normal_force * force_2.normal_force
            + point_2.lever_arms_about_a.of_tangential_force * force_2.tangential_force
        ),
        (
            point_1.lever_arms_about_b.of_normal_force * force_1.normal_force
            + point_1.lever_arms_about_b.of_tangential_force * force_1.tangential_force
        )
        + (
            point_2.lever_arms_about_b.of_normal_force * force_2.normal_force
            + point_2.lever_arms_about_b.of_tangential_force * force_2.tangential_force
        ),
    )


@njit(**INLINE_OPTIONS)
def element_force_sums_with_pair_force_added(
    force_sum_on_a: PlanarMotionOrForce, force_sum_on_b: PlanarMotionOrForce, pair_force: PairForce
) -> tuple[PlanarMotionOrForce, PlanarMotionOrForce]:
    """Return the forces on elements a and b with their mutual contact force added, in opposite directions."""
    return (
        PlanarMotionOrForce(
            force_sum_on_a.x + pair_force.force_on_a_x,
            force_sum_on_a.z + pair_force.force_on_a_z,
            force_sum_on_a.angular + pair_force.moment_of_force_on_a_about_a,
        ),
        PlanarMotionOrForce(
            force_sum_on_b.x - pair_force.force_on_a_x,
            force_sum_on_b.z - pair_force.force_on_a_z,
            force_sum_on_b.angular - pair_force.moment_of_force_on_a_about_b,
        ),
    )


@njit(**INLINE_OPTIONS)
def velocity_of_a_relative_to_b(
    velocity_a: PlanarMotionOrForce, velocity_b: PlanarMotionOrForce
) -> PairRelativeVelocityOrDirectionWithLeverArms:
    """Return the velocity of element a relative to element b, with the angular velocities of both."""
    return PairRelativeVelocityOrDirectionWithLeverArms(
        velocity_a.x - velocity_b.x, velocity_a.z - velocity_b.z, velocity_a.angular, velocity_b.angular
    )


@njit(**INLINE_OPTIONS)
def opening_and_slip_rates(
    contact_point: PlanarContactPoint,
    velocity_of_a_and_both_angular_velocities: PairRelativeVelocityOrDirectionWithLeverArms,
) -> tuple[float, float]:
    """Return opening and slip rates (m/s) at a contact point of two elements, from the velocity of a relative to b."""
    opening = (
        contact_point.normal_towards_a_x * velocity_of_a_and_both_angular_velocities.x
        + contact_point.normal_towards_a_z * velocity_of_a_and_both_angular_velocities.z
    ) + (
        velocity_of_a_and_both_angular_velocities.angular_velocity_or_lever_arm_of_a
        * contact_point.lever_arms_about_a.of_normal_force
        - velocity_of_a_and_both_angular_velocities.angular_velocity_or_lever_arm_of_b
        * contact_point.lever_arms_about_b.of_normal_force
    )
    return opening, (
        contact_point.normal_towards_a_z * velocity_of_a_and_both_angular_velocities.x
        - contact_point.normal_towards_a_x * velocity_of_a_and_both_angular_velocities.z
    ) + (
        velocity_of_a_and_both_angular_velocities.angular_velocity_or_lever_arm_of_a
        * contact_point.lever_arms_about_a.of_tangential_force
        - velocity_of_a_and_both_angular_velocities.angular_velocity_or_lever_arm_of_b
        * contact_point.lever_arms_about_b.of_tangential_force
    )


@njit(**INLINE_OPTIONS)
def friction_force_and_its_limit_and_slip_flag(
    tangential_force_without_friction_limit: float,
    normal_force: float,
    contact_law: ContactPointConstants,
    lands_flat_slides_and_signed_friction: tuple[bool, bool, float],
) -> tuple[float, float, bool]:
    """Return the limited friction force (N), its limit μ × normal force (N), and True if the contact slips.

    `lands_flat_slides_and_signed_friction` holds three values: whether the point is in contact in a flat landing (a
    point that has not touched yet has no friction), and the two results of
    `slides_in_landing_and_signed_friction_coefficient`.
    """
    (held, drifts, drift), limit = (
        lands_flat_slides_and_signed_friction,
        contact_law.friction_coefficient * normal_force,
    )
    slips = drifts if held else abs(tangential_force_without_friction_limit) > limit
    force = (
        drift * normal_force
        if drifts
        else (
            clamp_magnitude(tangential_force_without_friction_limit, limit)
            if slips
            else tangential_force_without_friction_limit
        )
    )
    return force, (limit if limit > 0.0 else 0.0), slips


@njit(**INLINE_OPTIONS)
def contact_point_history_after_step(
    point_history: PlanarContactPointStateAfterLastStep,
    other_point_history: PlanarContactPointStateAfterLastStep,
    contact_point: PlanarContactPoint,
    point_result: PlanarContactPointResult,
    contact_law: ContactPointConstants,
    step_duration: float,
) -> PlanarContactPointStateAfterLastStep:
    """Return the state of a contact point after a step, from its result and the earlier states of both points.

    If the other contact point of the two elements is already in contact, the flat landing of a point that touches now
    ends at the same time as that of the other point.
    """
    begun = (
        contact_law.prescribed_flat_landing_duration
        if other_point_history.contact_vertex_status_code == CONTACT_CODE_OPEN
        else other_point_history.remaining_flat_landing_time - step_duration
    )
    left = (
        point_history.remaining_flat_landing_time - step_duration
        if point_history.contact_vertex_status_code != CONTACT_CODE_OPEN
        else begun
    )
    carrier = owner_code_of_contact_vertex(contact_point) if point_result.is_in_contact else CONTACT_CODE_OPEN
    return PlanarContactPointStateAfterLastStep(
        point_result.force.tangential_spring_stretch,
        carrier,
        point_result.force.normal_force,
        point_result.force.tangential_force,
        left if point_result.is_in_contact else 0.0,
    )


@njit(**INLINE_OPTIONS)
def twice_energy_absorbed_at_contact_point(
    point_history: PlanarContactPointStateAfterLastStep,
    contact_point: PlanarContactPoint,
    point_result: PlanarContactPointResult,
) -> float:
    """Return twice the energy (J) that the contact at a contact point of two elements absorbed in a step."""
    value = (point_history.normal_force + point_result.force.normal_force) * (
        point_result.penetration - contact_point.previous_step_penetration
    ) - (point_history.tangential_force + point_result.force.tangential_force) * point_result.slip_of_a_in_step
    return (
        value if (point_history.contact_vertex_status_code != CONTACT_CODE_OPEN) | point_result.is_in_contact else 0.0
    )


@njit(**INLINE_OPTIONS)
def pair_history_after_step(
    pair_history: PairContactStateAfterLastStep,
    contact_segment: ContactSegment,
    face_vertex_positions: VertexPositionsAtOtherFace,
    point_results: tuple[PlanarContactPointResult, PlanarContactPointResult],
    contact_law: ContactPointConstants,
    step_duration: float,
) -> PairContactStateAfterLastStep:
    """Return the contact state of two elements after a step that ends with the given vertex positions."""
    s1, s2 = point_results
    deepest = updated_maximum(pair_history.peak_penetration, s1.penetration if s1.is_in_contact else 0.0)
    deepest = updated_maximum(deepest, s2.penetration if s2.is_in_contact else 0.0)
    absorbed = 0.5 * (
        twice_energy_absorbed_at_contact_point(pair_history.point_1, contact_segment.point_1, s1)
        + twice_energy_absorbed_at_contact_point(pair_history.point_2, contact_segment.point_2, s2)
    )
    return PairContactStateAfterLastStep(
        face_vertex_positions,
        contact_point_history_after_step(
            pair_history.point_1, pair_history.point_2, contact_segment.point_1, s1, contact_law, step_duration
        ),
        contact_point_history_after_step(
            pair_history.point_2, pair_history.point_1, contact_segment.point_2, s2, contact_law, step_duration
        ),
        deepest,
        pair_history.absorbed_energy + absorbed,
    )
