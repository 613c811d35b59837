"""The centred scheme: springs and dashpots at the whole step.

The dashpot's velocity is that of both elements with all forces found so far, this pair's own solved for: first the normal
ones of both ends, then the tangential.
"""

from typing import Any, NamedTuple

from numba import njit

from overturning.dem.lanes import INLINE, OPTIONS
from overturning.dem.mechanics import within
from overturning.dem.polygon import rows
from overturning.dem.polygon.contact import Force, act, stretched
from overturning.dem.polygon.faces import End, Stretch, common_stretch
from overturning.dem.polygon.rows import Body, Element, Pair, Plane


class Centred(NamedTuple):
    """Stands for the scheme where the kernel is compiled."""


class Answer(NamedTuple):
    """How the elements' velocities answer to forces."""

    inverse: float
    """Inverse masses of both together, inverse inertias of a and b,"""
    ia: float
    ib: float
    beta: float
    """force of a dashpot per velocity times the time for which the answer is reckoned."""


class Coupled(NamedTuple):
    """Two equations for the changes of both ends' forces: each end's own answer and the other's; an open end's is 1 and 0."""

    own_1: float
    own_2: float
    other_1: float
    other_2: float
    determinant: float


@njit(**INLINE)
def coupled(one: End, two: End, r: Answer, a1: float, a2: float, b1: float, b2: float) -> Coupled:
    """How the velocities at both ends answer to forces there: levers a about the first element's centre, b about the second's."""
    own_1 = r.inverse + (r.ia * (a1 * a1) + r.ib * (b1 * b1))
    own_2 = r.inverse + (r.ia * (a2 * a2) + r.ib * (b2 * b2))
    own_1, own_2 = 1.0 + r.beta * own_1, 1.0 + r.beta * own_2
    cross = r.beta * (r.inverse + (r.ia * (a1 * a2) + r.ib * (b1 * b2)))
    own_1, own_2 = (own_1 if one.closed else 1.0), (own_2 if two.closed else 1.0)
    other_1, other_2 = (cross if one.closed else 0.0), (cross if two.closed else 0.0)
    return Coupled(own_1, own_2, other_1, other_2, own_1 * own_2 - other_1 * other_2)


@njit(**INLINE)
def solved(e: Coupled, inverse: float, old_1: float, old_2: float, new_1: float, new_2: float) -> tuple[float, float]:
    """Both forces, from those before and those that the velocities before would give; `inverse` of the determinant."""
    r1, r2 = new_1 - old_1, new_2 - old_2
    return old_1 + (e.own_2 * r1 - e.other_1 * r2) * inverse, old_2 + (e.own_1 * r2 - e.other_2 * r1) * inverse


@njit(**INLINE)
def dashpots(end: End, dash: float, ux: float, uz: float, wa: float, wb: float) -> tuple[float, float]:
    """Forces of an end's dashpots against opening and against slip, from the velocities of a relative to b's."""
    opening = (end.nx * ux + end.nz * uz) + (wa * end.a.n - wb * end.b.n)
    slipping = (end.nz * ux - end.nx * uz) + (wa * end.a.t - wb * end.b.t)
    return dash * opening, dash * slipping


@njit(**INLINE)
def forces(pair: Pair, a: Element, b: Element, dt: float, ends: Stretch) -> tuple[Force, Force]:
    """Spring, dashpot and slider of both ends, whose velocities answer to their forces."""
    law, one, two, old_1, old_2 = pair.law, ends.one, ends.two, pair.one, pair.two
    ia, ib = a.body.inverse_inertia, b.body.inverse_inertia
    ux, uz, wa, wb = a.now.x - b.now.x, a.now.z - b.now.z, a.now.w, b.now.w
    # Twice the answer over half a step: the other pairs' answer is a step old, and would else be overtaken.
    beta = dt * law.dashpot
    answer = Answer(a.body.inverse_mass + b.body.inverse_mass, ia, ib, beta)
    along = coupled(one, two, answer, one.a.n, two.a.n, one.b.n, two.b.n)
    across = coupled(one, two, answer, one.a.t, two.a.t, one.b.t, two.b.t)
    # One division for both pairs of equations.
    shared = 1.0 / (along.determinant * across.determinant)
    lost_1, drag_1 = dashpots(one, law.dashpot, ux, uz, wa, wb)
    lost_2, drag_2 = dashpots(two, law.dashpot, ux, uz, wa, wb)
    n1, n2 = law.normal * one.depth - lost_1, law.normal * two.depth - lost_2
    on_1, on_2 = one.closed & (n1 > 0.0), two.closed & (n2 > 0.0)
    n1, n2 = (n1 if on_1 else 0.0), (n2 if on_2 else 0.0)
    n1, n2 = solved(along, shared * across.determinant, old_1.normal, old_2.normal, n1, n2)
    n1, n2 = (n1 if on_1 & (n1 > 0.0) else 0.0), (n2 if on_2 & (n2 > 0.0) else 0.0)
    # What the new normal forces change in the slip.
    more_1, more_2 = n1 - old_1.normal, n2 - old_2.normal
    wa, wb = (beta * ia) * (one.a.n * more_1 + two.a.n * more_2), (beta * ib) * (one.b.n * more_1 + two.b.n * more_2)
    drag_1, drag_2 = drag_1 + (wa * one.a.t + wb * one.b.t), drag_2 + (wa * two.a.t + wb * two.b.t)
    stretch_1 = stretched(old_1, one, ends, law.compliance, drag_1)
    stretch_2 = stretched(old_2, two, ends, law.compliance, drag_2)
    t1, t2 = -(law.tangential * stretch_1) - drag_1, -(law.tangential * stretch_2) - drag_2
    t1, t2 = (t1 if on_1 else 0.0), (t2 if on_2 else 0.0)
    t1, t2 = solved(across, shared * along.determinant, old_1.tangent, old_2.tangent, t1, t2)
    hold_1, hold_2 = law.friction * n1, law.friction * n2
    # Shortened even where a dashpot keeps the end from slipping: explicit springs tremble else at the largest step.
    s1, s2 = within(stretch_1, hold_1 * law.compliance), within(stretch_2, hold_2 * law.compliance)
    return Force(n1, within(t1, hold_1), s1), Force(n2, within(t2, hold_2), s2)


@njit(**INLINE)
def corrected(now: Plane, body: Body, half: float, x: float, z: float, moment: float) -> Plane:
    """Velocity at the whole step after a change of force and moment."""
    m, i = body.inverse_mass, body.inverse_inertia
    return Plane(now.x + m * (half * x), now.z + m * (half * z), now.w + (half * i) * moment)


@njit(**OPTIONS)
def contact(q: Any, a: Any, b: Any, own: Any) -> None:
    """Forces of one pair: spring, dashpot and slider at both ends of the faces' common stretch."""
    for j in range(rows.COLUMNS):
        pair, first, second, dt = (
            rows.load_pair(q, j),
            rows.load_element(a, j),
            rows.load_element(b, j),
            rows.load_case(own, j).step,
        )
        ends = common_stretch(pair, first.pose, second.pose)
        f1, f2 = forces(pair, first, second, dt, ends)
        more = act(q, a, b, j, pair, first, second, ends, f1, f2)
        # The elements' velocities with this pair's new forces in place of its old.
        half = 0.5 * dt
        rows.store_now(a, j, corrected(first.now, first.body, half, more.x, more.z, more.moment_a))
        rows.store_now(b, j, corrected(second.now, second.body, half, -more.x, -more.z, -more.moment_b))
