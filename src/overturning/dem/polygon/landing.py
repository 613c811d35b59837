"""Flat landing of a pair of elements: both ends touch in one impact (docs/method.md, "A flat landing")."""

import math
from typing import NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import INLINE
from overturning.dem.kernel.mechanics import slides_flat
from overturning.dem.polygon.faces import CommonStretch, ContactEnd, LeverArms
from overturning.dem.polygon.mechanics import EndResult, RelativeVector, opening_and_slip_rates
from overturning.dem.polygon.state import OPEN, ContactLaw, ElementConstants, EndHistory, PairHistory


class PairMotion(NamedTuple):
    """Relative motion of the elements of a pair, and their inertia."""

    velocity: RelativeVector
    a: ElementConstants
    b: ElementConstants


@njit(**INLINE)
def lands_now(contact_law: ContactLaw, previous_end: EndHistory, end: ContactEnd, motion: PairMotion) -> bool:
    """True if a contact end is landing, touches in this step, or will touch as part of the same impact.

    The time until it touches is at most `overturning.dem.kernel.mechanics.impact_time`, in products here.
    """
    opening, _ = opening_and_slip_rates(end, motion.velocity)
    sinking = opening if opening < 0.0 else 0.0
    rate = contact_law.dashpot * (motion.a.inverse_mass + motion.b.inverse_mass)
    soon = (rate * end.depth > sinking) & (contact_law.normal * end.depth > contact_law.dashpot * sinking)
    return (previous_end.landing > 0.0) | ((previous_end.carrier == OPEN) & (end.faces > 0.0) & soon)


@njit(**INLINE)
def lands_flat(
    contact_law: ContactLaw, previous_pair: PairHistory, both_ends: CommonStretch, motion: PairMotion
) -> bool:
    """True if both ends of a pair land in one impact, so that a dashpot may pull while its end is in contact."""
    one = lands_now(contact_law, previous_pair.one, both_ends.one, motion)
    return (contact_law.landing > 0.0) & one & lands_now(contact_law, previous_pair.two, both_ends.two, motion)


@njit(**INLINE)
def flat_landing_slip(
    contact_law: ContactLaw,
    end: ContactEnd,
    velocity: RelativeVector,
    inertia_a: ElementConstants,
    inertia_b: ElementConstants,
    is_flat: bool,
) -> tuple[bool, float]:
    """Return True if an end in a flat landing slides (`slides_flat`), and ±μ of its friction.

    Decided by the velocities without the rotation of one element relative to the other, as if both were one body.
    """
    total = inertia_a.inverse_inertia + inertia_b.inverse_inertia
    w = (velocity.a * inertia_b.inverse_inertia + velocity.b * inertia_a.inverse_inertia) / (
        total if total > 0.0 else 1.0
    )
    opening, slipping = opening_and_slip_rates(end, RelativeVector(velocity.x, velocity.z, w, w))
    return is_flat & slides_flat(contact_law.friction, slipping, opening), -math.copysign(
        contact_law.friction, slipping
    )


@njit(**INLINE)
def reduced_lever(lever_a: float, lever_b: float, inverse_a: float, inverse_b: float) -> float:
    """Return the lever arm (m) of a contact force that rotates one element relative to the other."""
    total = inverse_a + inverse_b
    return (lever_a * inverse_a + lever_b * inverse_b) / (total if total > 0.0 else 1.0)


@njit(**INLINE)
def shifted(end: ContactEnd, by: float) -> ContactEnd:
    """Return an end whose tangential force has shorter lever arms about both centres; `by` in m."""
    return ContactEnd(
        end.mine, end.faces, end.closed, end.nx, end.nz, end.depth, end.before, end.slip,
        LeverArms(end.a.n, end.a.t - by), LeverArms(end.b.n, end.b.t - by),
    )  # fmt: skip


@njit(**INLINE)
def landing_levers(
    contact_law: ContactLaw, both_ends: CommonStretch, motion: PairMotion, is_flat: bool
) -> tuple[ContactEnd, ContactEnd]:
    """Return both ends with the lever arms of their forces in a flat landing.

    The resultant impulse of a base that slides is inclined by μ. If it passes through the base, the normal impulses
    balance the moment of friction, and neither element rotates relative to the other. The tangential force then acts
    where it causes no such rotation.
    """
    one, two, (u, a, b) = both_ends.one, both_ends.two, motion
    slides_one, drift = flat_landing_slip(contact_law, one, u, a, b, is_flat)
    slides_two, other = flat_landing_slip(contact_law, two, u, a, b, is_flat)
    ia, ib = a.inverse_inertia, b.inverse_inertia
    t1, t2 = reduced_lever(one.a.t, one.b.t, ia, ib), reduced_lever(two.a.t, two.b.t, ia, ib)
    n1, n2 = reduced_lever(one.a.n, one.b.n, ia, ib), reduced_lever(two.a.n, two.b.n, ia, ib)
    # Place of the resultant normal impulse that causes no rotation, as a lever arm; it must lie between the ends.
    place = -0.5 * (drift * (t1 + t2))
    within = (place - n1) * (place - n2) <= 0.0
    share = 1.0 if slides_one & slides_two & (drift == other) & within else 0.0
    return shifted(one, share * t1), shifted(two, share * t2)


@njit(**INLINE)
def working_slips(
    both_ends: CommonStretch, levers: tuple[ContactEnd, ContactEnd], results: tuple[EndResult, EndResult]
) -> tuple[EndResult, EndResult]:
    """Return the results of both ends with the slip on which friction works, at the lever arms of `landing_levers`."""
    (end_1, end_2), (r1, r2), apart = levers, results, both_ends.one.a.n - both_ends.two.a.n
    sunk = (r1.depth - both_ends.one.before) - (r2.depth - both_ends.two.before)
    turn = -sunk / (apart if apart != 0.0 else 1.0)
    slip_1, slip_2 = (both_ends.one.a.t - end_1.a.t) * turn, (both_ends.two.a.t - end_2.a.t) * turn
    return (
        EndResult(r1.force, r1.depth, r1.slip - slip_1, r1.inside),
        EndResult(r2.force, r2.depth, r2.slip - slip_2, r2.inside),
    )
