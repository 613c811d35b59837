"""The centred scheme: springs and dashpots at the whole step.

The dashpot's velocity is that of both elements with all forces found so far, this pair's own solved for: first the normal
ones of both ends, then the tangential.
"""

from typing import Any, NamedTuple

from numba import njit

# isort: off
from overturning.dem.polygon.columns import (
    COLUMNS, COMPLIANCE, DASHPOT, FRICTION, INLINE, INVERSE_INERTIA, INVERSE_MASS, KN, KS, NORMAL, NOW_W, NOW_X, NOW_Z,
    OPTIONS, SECOND, STEP, TANGENT,
)  # fmt: skip

# isort: on
from overturning.dem.polygon.contact import held_to, push, stretched
from overturning.dem.polygon.faces import End, ends


class Coupled(NamedTuple):
    """Two equations for the changes of both ends' forces: each end's own answer and the other's; an open end's is 1 and 0."""

    own_1: float
    own_2: float
    other_1: float
    other_2: float
    determinant: float


@njit(**INLINE)
def coupled(
    one: End, two: End, inverse: float, ia: float, ib: float, a1: float, a2: float, b1: float, b2: float, beta: float
) -> Coupled:
    """How the velocities at both ends answer to forces of their own and of each other: levers a on the first element, b on the second."""
    own_1 = inverse + (ia * (a1 * a1) + ib * (b1 * b1))
    own_2 = inverse + (ia * (a2 * a2) + ib * (b2 * b2))
    own_1, own_2 = 1.0 + beta * own_1, 1.0 + beta * own_2
    cross = beta * (inverse + (ia * (a1 * a2) + ib * (b1 * b2)))
    own_1, own_2 = (own_1 if one.closed else 1.0), (own_2 if two.closed else 1.0)
    other_1, other_2 = (cross if one.closed else 0.0), (cross if two.closed else 0.0)
    return Coupled(own_1, own_2, other_1, other_2, own_1 * own_2 - other_1 * other_2)


@njit(**INLINE)
def solved(e: Coupled, inverse: float, old_1: float, old_2: float, r1: float, r2: float) -> tuple[float, float]:
    """Both forces from what they lack; `inverse` of the equations' determinant."""
    return old_1 + (e.own_2 * r1 - e.other_1 * r2) * inverse, old_2 + (e.own_1 * r2 - e.other_2 * r1) * inverse


@njit(**INLINE)
def dashpots(end: End, dash: float, ux: float, uz: float, wa: float, wb: float) -> tuple[float, float]:
    """Forces of an end's dashpots against opening and against slip, from the velocities of a relative to b's."""
    opening = (end.nx * ux + end.nz * uz) + (wa * end.an - wb * end.bn)
    slipping = (end.nz * ux - end.nx * uz) + (wa * end.at - wb * end.bt)
    return dash * opening, dash * slipping


@njit(**OPTIONS)
def contact_centred(q: Any, a: Any, b: Any, own: Any) -> None:
    """Forces of one pair: spring, dashpot and slider at both ends of the faces' common stretch."""
    for j in range(COLUMNS):
        turn_q, turn_r, one, two = ends(q, a, b, j)
        ma, mb = a[INVERSE_MASS + j], b[INVERSE_MASS + j]
        ia, ib = a[INVERSE_INERTIA + j], b[INVERSE_INERTIA + j]
        inverse = ma + mb
        kn, ks, dash = q[KN + j], q[KS + j], q[DASHPOT + j]
        old_n1, old_n2, old_t1, old_t2 = q[NORMAL + j], q[NORMAL + SECOND + j], q[TANGENT + j], q[TANGENT + SECOND + j]
        ux, uz = a[NOW_X + j] - b[NOW_X + j], a[NOW_Z + j] - b[NOW_Z + j]
        wa, wb = a[NOW_W + j], b[NOW_W + j]
        dt = own[STEP + j]
        half = 0.5 * dt
        # Twice the response over half a step: the other pairs' answer is a step old, and would else be overtaken.
        beta = dt * dash
        lost_1, drag_1 = dashpots(one, dash, ux, uz, wa, wb)
        lost_2, drag_2 = dashpots(two, dash, ux, uz, wa, wb)
        n1, n2 = kn * one.depth - lost_1, kn * two.depth - lost_2
        on_1, on_2 = one.closed & (n1 > 0.0), two.closed & (n2 > 0.0)
        along = coupled(one, two, inverse, ia, ib, one.an, two.an, one.bn, two.bn, beta)
        across = coupled(one, two, inverse, ia, ib, one.at, two.at, one.bt, two.bt, beta)
        # One division for both pairs of equations.
        shared = 1.0 / (along.determinant * across.determinant)
        r1, r2 = (n1 if on_1 else 0.0) - old_n1, (n2 if on_2 else 0.0) - old_n2
        n1, n2 = solved(along, shared * across.determinant, old_n1, old_n2, r1, r2)
        n1, n2 = (n1 if on_1 & (n1 > 0.0) else 0.0), (n2 if on_2 & (n2 > 0.0) else 0.0)
        # What the new normal forces change in the slip.
        more_1, more_2 = n1 - old_n1, n2 - old_n2
        wa, wb = (beta * ia) * (one.an * more_1 + two.an * more_2), (beta * ib) * (one.bn * more_1 + two.bn * more_2)
        drag_1, drag_2 = drag_1 + (wa * one.at + wb * one.bt), drag_2 + (wa * two.at + wb * two.bt)
        stretch_1 = stretched(q, j, j, one, turn_q, turn_r, drag_1)
        stretch_2 = stretched(q, j + SECOND, j, two, turn_q, turn_r, drag_2)
        t1, t2 = -(ks * stretch_1) - drag_1, -(ks * stretch_2) - drag_2
        r1, r2 = (t1 if on_1 else 0.0) - old_t1, (t2 if on_2 else 0.0) - old_t2
        t1, t2 = solved(across, shared * along.determinant, old_t1, old_t2, r1, r2)
        cap_1, cap_2 = q[FRICTION + j] * n1, q[FRICTION + j] * n2
        # Shortened even where a dashpot keeps the end from slipping: explicit springs tremble else at the largest step.
        s1, s2 = held_to(stretch_1, cap_1 * q[COMPLIANCE + j]), held_to(stretch_2, cap_2 * q[COMPLIANCE + j])
        t1, t2 = held_to(t1, cap_1), held_to(t2, cap_2)
        more_x, more_z, more_a, more_b = push(q, a, b, j, one, two, n1, n2, t1, t2, s1, s2)
        # The elements' velocities with this pair's new forces in place of its old.
        more_x, more_z = half * more_x, half * more_z
        a[NOW_X + j], b[NOW_X + j] = a[NOW_X + j] + ma * more_x, b[NOW_X + j] - mb * more_x
        a[NOW_Z + j], b[NOW_Z + j] = a[NOW_Z + j] + ma * more_z, b[NOW_Z + j] - mb * more_z
        a[NOW_W + j] = a[NOW_W + j] + (half * ia) * more_a
        b[NOW_W + j] = b[NOW_W + j] - (half * ib) * more_b
