"""What both schemes share of a contact's force: the tangential spring, the slider, and what an end's force does.

An end's force is ``f_n n + f_t (n_z, −n_x)`` on the pair's first element, the opposite on its second.
"""

from typing import Any

from numba import njit

# isort: off
from overturning.dem.polygon.columns import (
    COMPLIANCE, CONTACT, DEEPEST, FX, FZ, HANDED_ON, INLINE, MINE, MOMENT, MOMENT_A, MOMENT_B, NORMAL, OPEN, SECOND,
    SPRING, SUM_X, SUM_Z, TAKEN, TANGENT, THEIRS,
)  # fmt: skip

# isort: on
from overturning.dem.polygon.faces import End


@njit(**INLINE)
def stretched(q: Any, at: int, j: int, end: End, turn_q: float, turn_r: float, drag: float) -> float:
    """Stretch of an end's spring: grown by the slip, or, where the end has changed, such that the force is kept.

    A new contact begins unstretched.
    """
    whose = MINE if end.mine else THEIRS
    memory, n, t = q[CONTACT + at], q[NORMAL + at], q[TANGENT + at]
    share = t if memory == HANDED_ON else -((whose * turn_r) * n) - t * turn_q
    kept = -(share + drag) * q[COMPLIANCE + j]
    stretch = q[SPRING + at] + end.slip if memory == whose else kept
    return stretch if memory != OPEN else 0.0


@njit(**INLINE)
def held_to(value: float, most: float) -> float:
    """A value brought between −most and most."""
    value = most if value > most else value
    least = -most
    return least if value < least else value


@njit(**INLINE)
def keep(q: Any, at: int, end: End, spring: float, n: float, t: float) -> float:
    """Keep an end's spring and forces for the next step; energy that it took from the elements since the last one, twice."""
    whose = MINE if end.mine else THEIRS
    taken = (q[NORMAL + at] + n) * (end.depth - end.before) - (q[TANGENT + at] + t) * end.slip
    q[SPRING + at], q[CONTACT + at] = spring, whose if end.closed else OPEN
    q[NORMAL + at], q[TANGENT + at] = n, t
    return taken


@njit(**INLINE)
def push(
    q: Any, a: Any, b: Any, j: int, one: End, two: End, n1: float, n2: float, t1: float, t2: float, s1: float, s2: float
) -> tuple[float, float, float, float]:
    """Let both ends' forces act on the elements and book them; their change since the last step: force on a, moments."""
    taken_1, taken_2 = keep(q, j, one, s1, n1, t1), keep(q, j + SECOND, two, s2, n2, t2)
    deepest = q[DEEPEST + j]
    deepest = one.depth if one.closed & (one.depth > deepest) else deepest
    deepest = two.depth if two.closed & (two.depth > deepest) else deepest
    sum_x = (n1 * one.nx + t1 * one.nz) + (n2 * two.nx + t2 * two.nz)
    sum_z = (n1 * one.nz - t1 * one.nx) + (n2 * two.nz - t2 * two.nx)
    moment_a = (one.an * n1 + one.at * t1) + (two.an * n2 + two.at * t2)
    moment_b = (one.bn * n1 + one.bt * t1) + (two.bn * n2 + two.bt * t2)
    a[FX + j], b[FX + j] = a[FX + j] + sum_x, b[FX + j] - sum_x
    a[FZ + j], b[FZ + j] = a[FZ + j] + sum_z, b[FZ + j] - sum_z
    a[MOMENT + j], b[MOMENT + j] = a[MOMENT + j] + moment_a, b[MOMENT + j] - moment_b
    more_x, more_z = sum_x - q[SUM_X + j], sum_z - q[SUM_Z + j]
    more_a, more_b = moment_a - q[MOMENT_A + j], moment_b - q[MOMENT_B + j]
    q[DEEPEST + j] = deepest
    q[TAKEN + j] = q[TAKEN + j] + 0.5 * (taken_1 + taken_2)
    q[SUM_X + j], q[SUM_Z + j], q[MOMENT_A + j], q[MOMENT_B + j] = sum_x, sum_z, moment_a, moment_b
    return more_x, more_z, more_a, more_b
