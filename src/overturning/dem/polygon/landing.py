"""Flat landing of a pair of elements: both contact points touch in one impact (docs/method.md, "A flat landing")."""

import math
from typing import NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import INLINE_OPTIONS
from overturning.dem.kernel.mechanics import base_slides_in_flat_landing
from overturning.dem.polygon.faces import ContactSegment, LeverArmsAboutElementCentre, PlanarContactPoint
from overturning.dem.polygon.mechanics import (
    PairRelativeVelocityOrDirectionWithLeverArms,
    PlanarContactPointResult,
    opening_and_slip_rates,
)
from overturning.dem.polygon.state import (
    CONTACT_CODE_OPEN,
    ContactPointConstants,
    ElementConstants,
    PairContactStateAfterLastStep,
    PlanarContactPointStateAfterLastStep,
)


class RelativeVelocityAndConstantsOfPair(NamedTuple):
    """Velocity of element a relative to b, and the constants (among them the masses) of both elements."""

    relative_velocity: PairRelativeVelocityOrDirectionWithLeverArms
    """Velocity of a relative to b, and the angular velocities of both."""
    constants_of_a: ElementConstants
    constants_of_b: ElementConstants


@njit(**INLINE_OPTIONS)
def contact_point_lands_in_this_impact(
    contact_law: ContactPointConstants,
    point_history: PlanarContactPointStateAfterLastStep,
    contact_point: PlanarContactPoint,
    pair_motion_and_inertia: RelativeVelocityAndConstantsOfPair,
) -> bool:
    """True if a contact point of two elements is landing: it touches now or will touch within the same impact.

    The time until it touches is at most `dem.kernel.mechanics.max_time_between_touches_in_one_impact`; here both sides
    of this condition are multiplied to avoid a division.
    """
    opening, _ = opening_and_slip_rates(contact_point, pair_motion_and_inertia.relative_velocity)
    sinking = opening if opening < 0.0 else 0.0
    rate = contact_law.dashpot_coefficient * (
        pair_motion_and_inertia.constants_of_a.inverse_mass + pair_motion_and_inertia.constants_of_b.inverse_mass
    )
    soon = (rate * contact_point.penetration > sinking) & (
        contact_law.normal_stiffness * contact_point.penetration > contact_law.dashpot_coefficient * sinking
    )
    return (point_history.remaining_flat_landing_time > 0.0) | (
        (point_history.contact_vertex_status_code == CONTACT_CODE_OPEN)
        & (contact_point.vertex_projects_onto_other_face > 0.0)
        & soon
    )


@njit(**INLINE_OPTIONS)
def pair_lands_flat(
    contact_law: ContactPointConstants,
    pair_history: PairContactStateAfterLastStep,
    contact_segment: ContactSegment,
    pair_motion_and_inertia: RelativeVelocityAndConstantsOfPair,
) -> bool:
    """True if both contact points of two elements land in one impact; a dashpot may then pull."""
    one = contact_point_lands_in_this_impact(
        contact_law, pair_history.point_1, contact_segment.point_1, pair_motion_and_inertia
    )
    return (
        (contact_law.prescribed_flat_landing_duration > 0.0)
        & one
        & contact_point_lands_in_this_impact(
            contact_law, pair_history.point_2, contact_segment.point_2, pair_motion_and_inertia
        )
    )


@njit(**INLINE_OPTIONS)
def slides_in_landing_and_signed_friction_coefficient(
    contact_law: ContactPointConstants,
    contact_point: PlanarContactPoint,
    velocity_of_a_and_both_angular_velocities: PairRelativeVelocityOrDirectionWithLeverArms,
    constants_of_a: ElementConstants,
    constants_of_b: ElementConstants,
    lands_flat: bool,
) -> tuple[bool, float]:
    """Return whether a contact point slides in a flat landing, and its friction coefficient ±μ with the force's sign.

    The velocities are those without the rotation of one element relative to the other, as if both were one body.
    """
    total = constants_of_a.inverse_inertia + constants_of_b.inverse_inertia
    w = (
        velocity_of_a_and_both_angular_velocities.angular_velocity_or_lever_arm_of_a * constants_of_b.inverse_inertia
        + velocity_of_a_and_both_angular_velocities.angular_velocity_or_lever_arm_of_b * constants_of_a.inverse_inertia
    ) / (total if total > 0.0 else 1.0)
    opening, slipping = opening_and_slip_rates(
        contact_point,
        PairRelativeVelocityOrDirectionWithLeverArms(
            velocity_of_a_and_both_angular_velocities.x, velocity_of_a_and_both_angular_velocities.z, w, w
        ),
    )
    return lands_flat & base_slides_in_flat_landing(
        contact_law.friction_coefficient, slipping, opening
    ), -math.copysign(contact_law.friction_coefficient, slipping)


@njit(**INLINE_OPTIONS)
def lever_arm_of_force_rotating_a_relative_to_b(
    force_lever_arm_about_a: float, force_lever_arm_about_b: float, inverse_inertia_a: float, inverse_inertia_b: float
) -> float:
    """Return the lever arm (m) with which a contact force rotates element a relative to element b."""
    total = inverse_inertia_a + inverse_inertia_b
    return (force_lever_arm_about_a * inverse_inertia_a + force_lever_arm_about_b * inverse_inertia_b) / (
        total if total > 0.0 else 1.0
    )


@njit(**INLINE_OPTIONS)
def shift_tangential_force_towards_element_b(
    contact_point: PlanarContactPoint, shift_towards_b_along_normal: float
) -> PlanarContactPoint:
    """Return a contact point whose tangential force acts further towards b, by a signed distance (m) along the normal.

    The distance is subtracted from both signed lever arms of this force, so that one of them may grow.
    """
    end, arms_a, arms_b = contact_point, contact_point.lever_arms_about_a, contact_point.lever_arms_about_b
    return PlanarContactPoint(
        end.vertex_is_of_a, end.vertex_projects_onto_other_face, end.is_in_contact,
        end.normal_towards_a_x, end.normal_towards_a_z,
        end.penetration, end.previous_step_penetration, end.slip_of_a_in_step,
        LeverArmsAboutElementCentre(arms_a.of_normal_force, arms_a.of_tangential_force - shift_towards_b_along_normal),
        LeverArmsAboutElementCentre(arms_b.of_normal_force, arms_b.of_tangential_force - shift_towards_b_along_normal),
    )  # fmt: skip


@njit(**INLINE_OPTIONS)
def contact_points_with_flat_landing_lever_arms(
    contact_law: ContactPointConstants,
    contact_segment: ContactSegment,
    pair_motion_and_inertia: RelativeVelocityAndConstantsOfPair,
    lands_flat: bool,
) -> tuple[PlanarContactPoint, PlanarContactPoint]:
    """Return the contact points of two elements; in a flat landing, with corrected lever arms of tangential forces.

    If both points slide in one direction, and a resultant normal impulse between them can balance the moment of
    friction, neither element rotates relative to the other. The tangential forces then get lever arms with which they
    cause no such rotation. Else the points are unchanged.
    """
    one, two, (u, a, b) = contact_segment.point_1, contact_segment.point_2, pair_motion_and_inertia
    slides_one, drift = slides_in_landing_and_signed_friction_coefficient(contact_law, one, u, a, b, lands_flat)
    slides_two, other = slides_in_landing_and_signed_friction_coefficient(contact_law, two, u, a, b, lands_flat)
    ia, ib = a.inverse_inertia, b.inverse_inertia
    t1, t2 = (
        lever_arm_of_force_rotating_a_relative_to_b(
            one.lever_arms_about_a.of_tangential_force, one.lever_arms_about_b.of_tangential_force, ia, ib
        ),
        lever_arm_of_force_rotating_a_relative_to_b(
            two.lever_arms_about_a.of_tangential_force, two.lever_arms_about_b.of_tangential_force, ia, ib
        ),
    )
    n1, n2 = (
        lever_arm_of_force_rotating_a_relative_to_b(
            one.lever_arms_about_a.of_normal_force, one.lever_arms_about_b.of_normal_force, ia, ib
        ),
        lever_arm_of_force_rotating_a_relative_to_b(
            two.lever_arms_about_a.of_normal_force, two.lever_arms_about_b.of_normal_force, ia, ib
        ),
    )
    # Place of the resultant normal impulse that causes no rotation, as a lever arm; it must lie between the points.
    place = -0.5 * (drift * (t1 + t2))
    within = (place - n1) * (place - n2) <= 0.0
    share = 1.0 if slides_one & slides_two & (drift == other) & within else 0.0
    return shift_tangential_force_towards_element_b(one, share * t1), shift_tangential_force_towards_element_b(
        two, share * t2
    )


@njit(**INLINE_OPTIONS)
def results_with_slip_corrected_for_friction_work(
    contact_segment: ContactSegment,
    points_with_landing_lever_arms: tuple[PlanarContactPoint, PlanarContactPoint],
    point_results: tuple[PlanarContactPointResult, PlanarContactPointResult],
) -> tuple[PlanarContactPointResult, PlanarContactPointResult]:
    """Return the results of two contact points with slips corrected for the lever arms of a flat landing.

    Friction force times corrected slip is the work of friction at the lever arms that
    `contact_points_with_flat_landing_lever_arms` has changed.
    """
    (point_1, point_2), (r1, r2), apart = (
        points_with_landing_lever_arms,
        point_results,
        contact_segment.point_1.lever_arms_about_a.of_normal_force
        - contact_segment.point_2.lever_arms_about_a.of_normal_force,
    )
    sunk = (r1.penetration - contact_segment.point_1.previous_step_penetration) - (
        r2.penetration - contact_segment.point_2.previous_step_penetration
    )
    turn = -sunk / (apart if apart != 0.0 else 1.0)
    slip_1, slip_2 = (
        (
            contact_segment.point_1.lever_arms_about_a.of_tangential_force
            - point_1.lever_arms_about_a.of_tangential_force
        )
        * turn,
        (
            contact_segment.point_2.lever_arms_about_a.of_tangential_force
            - point_2.lever_arms_about_a.of_tangential_force
        )
        * turn,
    )
    return (
        PlanarContactPointResult(r1.force, r1.penetration, r1.slip_of_a_in_step - slip_1, r1.is_in_contact),
        PlanarContactPointResult(r2.force, r2.penetration, r2.slip_of_a_in_step - slip_2, r2.is_in_contact),
    )
