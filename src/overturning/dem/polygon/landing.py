"""Flat landing of a pair of elements: both ends touch in one impact (docs/method.md, "A flat landing")."""

import math
from typing import NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import INLINE
from overturning.dem.kernel.mechanics import base_slides_in_flat_landing
from overturning.dem.polygon.faces import ForceLeverArms, SegmentEnd, SharedSegment
from overturning.dem.polygon.mechanics import PairRelativeVector, SegmentEndResult, opening_and_slip_rates
from overturning.dem.polygon.state import OPEN, ContactLaw, ElementConstants, PairHistory, SegmentEndHistory


class PairMotionAndInertia(NamedTuple):
    """Velocity of element a relative to b, and the inverse masses and inertias of both elements."""

    velocity: PairRelativeVector
    a: ElementConstants
    b: ElementConstants


@njit(**INLINE)
def segment_end_lands_now(
    contact_law: ContactLaw, end_history: SegmentEndHistory, segment_end: SegmentEnd, pair_motion: PairMotionAndInertia
) -> bool:
    """True if one end of a contact segment is landing: it touches now or will touch within the same impact.

    The time until it touches is at most `dem.kernel.mechanics.max_touch_delay_of_one_impact`, in products here.
    """
    opening, _ = opening_and_slip_rates(segment_end, pair_motion.velocity)
    sinking = opening if opening < 0.0 else 0.0
    rate = contact_law.dashpot * (pair_motion.a.inverse_mass + pair_motion.b.inverse_mass)
    soon = (rate * segment_end.depth > sinking) & (
        contact_law.normal * segment_end.depth > contact_law.dashpot * sinking
    )
    return (end_history.landing > 0.0) | ((end_history.carrier == OPEN) & (segment_end.faces > 0.0) & soon)


@njit(**INLINE)
def pair_lands_flat(
    contact_law: ContactLaw, pair_history: PairHistory, shared_segment: SharedSegment, pair_motion: PairMotionAndInertia
) -> bool:
    """True if both ends of two elements' contact segment land in one impact; a dashpot may then pull."""
    one = segment_end_lands_now(contact_law, pair_history.one, shared_segment.one, pair_motion)
    return (
        (contact_law.landing > 0.0)
        & one
        & segment_end_lands_now(contact_law, pair_history.two, shared_segment.two, pair_motion)
    )


@njit(**INLINE)
def flat_landing_slip_and_friction(
    contact_law: ContactLaw,
    segment_end: SegmentEnd,
    velocity: PairRelativeVector,
    inertia_a: ElementConstants,
    inertia_b: ElementConstants,
    lands_flat: bool,
) -> tuple[bool, float]:
    """Return if one end of a contact segment slides in a flat landing, and ±μ with the sign of its friction.

    The velocities decide without the rotation of one element relative to the other, as if both were one body.
    """
    total = inertia_a.inverse_inertia + inertia_b.inverse_inertia
    w = (velocity.a * inertia_b.inverse_inertia + velocity.b * inertia_a.inverse_inertia) / (
        total if total > 0.0 else 1.0
    )
    opening, slipping = opening_and_slip_rates(segment_end, PairRelativeVector(velocity.x, velocity.z, w, w))
    return lands_flat & base_slides_in_flat_landing(contact_law.friction, slipping, opening), -math.copysign(
        contact_law.friction, slipping
    )


@njit(**INLINE)
def relative_rotation_lever(
    lever_a: float, lever_b: float, inverse_inertia_a: float, inverse_inertia_b: float
) -> float:
    """Return the lever arm (m) with which a contact force rotates element a relative to element b."""
    total = inverse_inertia_a + inverse_inertia_b
    return (lever_a * inverse_inertia_a + lever_b * inverse_inertia_b) / (total if total > 0.0 else 1.0)


@njit(**INLINE)
def shorten_tangential_levers(segment_end: SegmentEnd, lever_reduction: float) -> SegmentEnd:
    """Return one end of a contact segment, with `lever_reduction` (m) subtracted from the tangential lever arms."""
    end = segment_end
    return SegmentEnd(
        end.mine, end.faces, end.closed, end.nx, end.nz, end.depth, end.before, end.slip,
        ForceLeverArms(end.a.n, end.a.t - lever_reduction), ForceLeverArms(end.b.n, end.b.t - lever_reduction),
    )  # fmt: skip


@njit(**INLINE)
def segment_ends_with_flat_landing_levers(
    contact_law: ContactLaw, shared_segment: SharedSegment, pair_motion: PairMotionAndInertia, lands_flat: bool
) -> tuple[SegmentEnd, SegmentEnd]:
    """Return both ends of a contact segment; in a flat landing, with corrected lever arms of the tangential forces.

    The resultant impulse of a base that slides is inclined by μ. If it passes through the base, the normal impulses
    balance the moment of friction, and neither element rotates relative to the other. The tangential force then acts
    where it causes no such rotation.
    """
    one, two, (u, a, b) = shared_segment.one, shared_segment.two, pair_motion
    slides_one, drift = flat_landing_slip_and_friction(contact_law, one, u, a, b, lands_flat)
    slides_two, other = flat_landing_slip_and_friction(contact_law, two, u, a, b, lands_flat)
    ia, ib = a.inverse_inertia, b.inverse_inertia
    t1, t2 = relative_rotation_lever(one.a.t, one.b.t, ia, ib), relative_rotation_lever(two.a.t, two.b.t, ia, ib)
    n1, n2 = relative_rotation_lever(one.a.n, one.b.n, ia, ib), relative_rotation_lever(two.a.n, two.b.n, ia, ib)
    # Place of the resultant normal impulse that causes no rotation, as a lever arm; it must lie between the ends.
    place = -0.5 * (drift * (t1 + t2))
    within = (place - n1) * (place - n2) <= 0.0
    share = 1.0 if slides_one & slides_two & (drift == other) & within else 0.0
    return shorten_tangential_levers(one, share * t1), shorten_tangential_levers(two, share * t2)


@njit(**INLINE)
def correct_slip_for_friction_work(
    shared_segment: SharedSegment,
    landing_ends: tuple[SegmentEnd, SegmentEnd],
    end_results: tuple[SegmentEndResult, SegmentEndResult],
) -> tuple[SegmentEndResult, SegmentEndResult]:
    """Return force and slip at both ends of a contact segment; slips fit the lever arms of a flat landing.

    With these slips, friction does its work at the lever arms of `segment_ends_with_flat_landing_levers`.
    """
    (end_1, end_2), (r1, r2), apart = landing_ends, end_results, shared_segment.one.a.n - shared_segment.two.a.n
    sunk = (r1.depth - shared_segment.one.before) - (r2.depth - shared_segment.two.before)
    turn = -sunk / (apart if apart != 0.0 else 1.0)
    slip_1, slip_2 = (shared_segment.one.a.t - end_1.a.t) * turn, (shared_segment.two.a.t - end_2.a.t) * turn
    return (
        SegmentEndResult(r1.force, r1.depth, r1.slip - slip_1, r1.inside),
        SegmentEndResult(r2.force, r2.depth, r2.slip - slip_2, r2.inside),
    )
