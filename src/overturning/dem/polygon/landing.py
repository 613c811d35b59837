"""Flat landing of a pair of elements: both contact points touch in one impact (docs/method.md, "A flat landing")."""

import math
from typing import NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import INLINE_OPTIONS
from overturning.dem.kernel.mechanics import base_slides_in_flat_landing
from overturning.dem.polygon.faces import ContactSegment, ForceLeverArms, PlanarContactPoint
from overturning.dem.polygon.mechanics import PairRelativeVector, PlanarContactPointResult, opening_and_slip_rates
from overturning.dem.polygon.state import (
    OPEN,
    ContactPointLaw,
    ElementConstants,
    PairHistory,
    PlanarContactPointHistory,
)


class PairMotionAndInertia(NamedTuple):
    """Velocity of element a relative to b, and the inverse masses and inertias of both elements."""

    velocity: PairRelativeVector
    a: ElementConstants
    b: ElementConstants


@njit(**INLINE_OPTIONS)
def contact_point_lands_in_this_impact(
    contact_law: ContactPointLaw,
    point_history: PlanarContactPointHistory,
    contact_point: PlanarContactPoint,
    pair_motion: PairMotionAndInertia,
) -> bool:
    """True if a contact point of two elements is landing: it touches now or will touch within the same impact.

    The time until it touches is at most `dem.kernel.mechanics.max_time_between_touches_in_one_impact`; here both sides
    of this condition are multiplied to avoid a division.
    """
    opening, _ = opening_and_slip_rates(contact_point, pair_motion.velocity)
    sinking = opening if opening < 0.0 else 0.0
    rate = contact_law.dashpot * (pair_motion.a.inverse_mass + pair_motion.b.inverse_mass)
    soon = (rate * contact_point.depth > sinking) & (
        contact_law.normal_stiffness * contact_point.depth > contact_law.dashpot * sinking
    )
    return (point_history.remaining_flat_landing_time > 0.0) | (
        (point_history.vertex_owner == OPEN) & (contact_point.vertex_is_opposite_face > 0.0) & soon
    )


@njit(**INLINE_OPTIONS)
def pair_lands_flat(
    contact_law: ContactPointLaw,
    pair_history: PairHistory,
    contact_segment: ContactSegment,
    pair_motion: PairMotionAndInertia,
) -> bool:
    """True if both contact points of two elements land in one impact; a dashpot may then pull."""
    one = contact_point_lands_in_this_impact(contact_law, pair_history.point_1, contact_segment.point_1, pair_motion)
    return (
        (contact_law.landing_duration > 0.0)
        & one
        & contact_point_lands_in_this_impact(contact_law, pair_history.point_2, contact_segment.point_2, pair_motion)
    )


@njit(**INLINE_OPTIONS)
def flat_landing_slip_flag_and_signed_mu(
    contact_law: ContactPointLaw,
    contact_point: PlanarContactPoint,
    velocity: PairRelativeVector,
    inertia_a: ElementConstants,
    inertia_b: ElementConstants,
    lands_flat: bool,
) -> tuple[bool, float]:
    """Return whether a contact point of two elements slides in a flat landing, and ±μ with the sign of its friction.

    The velocities are those without the rotation of one element relative to the other, as if both were one body.
    """
    total = inertia_a.inverse_inertia + inertia_b.inverse_inertia
    w = (velocity.rotation_a * inertia_b.inverse_inertia + velocity.rotation_b * inertia_a.inverse_inertia) / (
        total if total > 0.0 else 1.0
    )
    opening, slipping = opening_and_slip_rates(contact_point, PairRelativeVector(velocity.x, velocity.z, w, w))
    return lands_flat & base_slides_in_flat_landing(contact_law.friction, slipping, opening), -math.copysign(
        contact_law.friction, slipping
    )


@njit(**INLINE_OPTIONS)
def relative_rotation_lever_arm(
    lever_a: float, lever_b: float, inverse_inertia_a: float, inverse_inertia_b: float
) -> float:
    """Return the lever arm (m) with which a contact force rotates element a relative to element b."""
    total = inverse_inertia_a + inverse_inertia_b
    return (lever_a * inverse_inertia_a + lever_b * inverse_inertia_b) / (total if total > 0.0 else 1.0)


@njit(**INLINE_OPTIONS)
def reduce_tangential_lever_arms(contact_point: PlanarContactPoint, lever_reduction: float) -> PlanarContactPoint:
    """Return a contact point, with `lever_reduction` (m) subtracted from the lever arms of its tangential force."""
    end = contact_point
    return PlanarContactPoint(
        end.vertex_is_of_a, end.vertex_is_opposite_face, end.closed, end.nx, end.nz, end.depth,
        end.previous_penetration, end.slip,
        ForceLeverArms(end.lever_a.n, end.lever_a.t - lever_reduction), ForceLeverArms(end.lever_b.n,
        end.lever_b.t - lever_reduction),
    )  # fmt: skip


@njit(**INLINE_OPTIONS)
def contact_points_with_landing_lever_arms(
    contact_law: ContactPointLaw, contact_segment: ContactSegment, pair_motion: PairMotionAndInertia, lands_flat: bool
) -> tuple[PlanarContactPoint, PlanarContactPoint]:
    """Return both contact points of two elements; in a flat landing, with corrected lever arms of tangential forces.

    The resultant impulse of a base that slides is inclined by μ. If it passes through the base, the normal impulses
    balance the moment of friction, and neither element rotates relative to the other. The tangential force then acts
    where it causes no such rotation.
    """
    one, two, (u, a, b) = contact_segment.point_1, contact_segment.point_2, pair_motion
    slides_one, drift = flat_landing_slip_flag_and_signed_mu(contact_law, one, u, a, b, lands_flat)
    slides_two, other = flat_landing_slip_flag_and_signed_mu(contact_law, two, u, a, b, lands_flat)
    ia, ib = a.inverse_inertia, b.inverse_inertia
    t1, t2 = (
        relative_rotation_lever_arm(one.lever_a.t, one.lever_b.t, ia, ib),
        relative_rotation_lever_arm(two.lever_a.t, two.lever_b.t, ia, ib),
    )
    n1, n2 = (
        relative_rotation_lever_arm(one.lever_a.n, one.lever_b.n, ia, ib),
        relative_rotation_lever_arm(two.lever_a.n, two.lever_b.n, ia, ib),
    )
    # Place of the resultant normal impulse that causes no rotation, as a lever arm; it must lie between the points.
    place = -0.5 * (drift * (t1 + t2))
    within = (place - n1) * (place - n2) <= 0.0
    share = 1.0 if slides_one & slides_two & (drift == other) & within else 0.0
    return reduce_tangential_lever_arms(one, share * t1), reduce_tangential_lever_arms(two, share * t2)


@njit(**INLINE_OPTIONS)
def correct_slip_for_friction_work(
    contact_segment: ContactSegment,
    landing_points: tuple[PlanarContactPoint, PlanarContactPoint],
    point_results: tuple[PlanarContactPointResult, PlanarContactPointResult],
) -> tuple[PlanarContactPointResult, PlanarContactPointResult]:
    """Return both contact points' results of a flat landing, slips corrected for friction's changed lever arms.

    The slips are corrected for the changed lever arms of friction in a flat landing.

    With these slips, friction does its work at the lever arms of `contact_points_with_landing_lever_arms`.
    """
    (point_1, point_2), (r1, r2), apart = (
        landing_points,
        point_results,
        contact_segment.point_1.lever_a.n - contact_segment.point_2.lever_a.n,
    )
    sunk = (r1.depth - contact_segment.point_1.previous_penetration) - (
        r2.depth - contact_segment.point_2.previous_penetration
    )
    turn = -sunk / (apart if apart != 0.0 else 1.0)
    slip_1, slip_2 = (
        (contact_segment.point_1.lever_a.t - point_1.lever_a.t) * turn,
        (contact_segment.point_2.lever_a.t - point_2.lever_a.t) * turn,
    )
    return (
        PlanarContactPointResult(r1.force, r1.depth, r1.slip - slip_1, r1.is_in_contact),
        PlanarContactPointResult(r2.force, r2.depth, r2.slip - slip_2, r2.is_in_contact),
    )
