"""Cundall's scheme: springs at the whole step, dashpots at the half step before it, from the difference of depths."""

from typing import Any, NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import INLINE, OPTIONS
from overturning.dem.kernel.mechanics import within
from overturning.dem.polygon import rows
from overturning.dem.polygon.contact import Force, act, stretched
from overturning.dem.polygon.faces import common_stretch
from overturning.dem.polygon.state import End, Law, Memory, Stretch


class Cundall(NamedTuple):
    """What the kernel has to know of the scheme."""

    lag: float = 0.5
    """Steps by which velocities lag behind poses;"""
    ticks: float = 1.0
    """ticks of a whole step."""


@njit(**INLINE)
def end_force(law: Law, old: Memory, end: End, ends: Stretch, rate: float) -> Force:
    """Spring, dashpot and slider of an end."""
    fade = law.dashpot * rate
    n = law.normal * end.depth + fade * (end.depth - end.before)
    n = n if end.closed & (n > 0.0) else 0.0
    drag = fade * end.slip
    stretch = stretched(old, end, ends, law.compliance, drag)
    hold = law.friction * n
    t = -(law.tangential * stretch) - drag
    # The spring is shortened where the slider slips, to what friction holds.
    return Force(n, within(t, hold), within(stretch, hold * law.compliance) if abs(t) > hold else stretch)


@njit(**OPTIONS)
def contact(q: Any, a: Any, b: Any, own: Any) -> None:
    """Forces of one pair: spring, dashpot and slider at both ends of the faces' common stretch."""
    for j in range(rows.COLUMNS):
        pair, first, second, case = (
            rows.load_pair(q, j),
            rows.load_element(a, j),
            rows.load_element(b, j),
            rows.load_case(own, j),
        )
        ends = common_stretch(pair, first.pose, second.pose)
        f1 = end_force(pair.law, pair.one, ends.one, ends, case.rate)
        f2 = end_force(pair.law, pair.two, ends.two, ends, case.rate)
        act(q, a, b, j, pair, ends, f1, f2)
