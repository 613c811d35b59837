"""Cundall's scheme: springs at the whole step, dashpots at the half step before it, from the difference of depths."""

from typing import Any

from numba import njit

# isort: off
from overturning.dem.polygon.columns import (
    COLUMNS, COMPLIANCE, DASHPOT, FRICTION, INLINE, KN, KS, OPTIONS, RATE, SECOND,
)  # fmt: skip

# isort: on
from overturning.dem.polygon.contact import held_to, push, stretched
from overturning.dem.polygon.faces import End, ends


@njit(**INLINE)
def shortened(stretch: float, force: float, most: float, compliance: float) -> float:
    """Stretch of an end's spring after its slider: where the force would be more than friction holds, no more than that."""
    limit = most * compliance
    return held_to(stretch, limit) if abs(force) > most else stretch


@njit(**INLINE)
def end_force(q: Any, at: int, j: int, own: Any, end: End, turn_q: float, turn_r: float) -> tuple[float, float, float]:
    """Force of an end along its normal and tangent, N, and the stretch of its tangential spring, m."""
    fade = q[DASHPOT + j] * own[RATE + j]
    n = q[KN + j] * end.depth + fade * (end.depth - end.before)
    n = n if end.closed & (n > 0.0) else 0.0
    drag = fade * end.slip
    stretch = stretched(q, at, j, end, turn_q, turn_r, drag)
    cap = q[FRICTION + j] * n
    force = -(q[KS + j] * stretch) - drag
    return n, held_to(force, cap), shortened(stretch, force, cap, q[COMPLIANCE + j])


@njit(**OPTIONS)
def contact_cundall(q: Any, a: Any, b: Any, own: Any) -> None:
    """Forces of one pair: spring, dashpot and slider at both ends of the faces' common stretch."""
    for j in range(COLUMNS):
        turn_q, turn_r, one, two = ends(q, a, b, j)
        n1, t1, s1 = end_force(q, j, j, own, one, turn_q, turn_r)
        n2, t2, s2 = end_force(q, j + SECOND, j, own, two, turn_q, turn_r)
        push(q, a, b, j, one, two, n1, n2, t1, t2, s1, s2)
