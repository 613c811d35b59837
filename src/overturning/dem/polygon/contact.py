"""What both schemes share of a contact's force: the tangential spring, the slider, and what an end's force does.

An end's force is ``n (n_x, n_z) + t (n_z, −n_x)`` on the pair's first element a, the opposite on its second, b.
"""

from typing import Any, NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import INLINE
from overturning.dem.kernel.mechanics import larger
from overturning.dem.polygon import rows
from overturning.dem.polygon.state import Action, End, Memory, Pair, Plane, Stretch


class Force(NamedTuple):
    """An end's normal and tangential force, N, and the stretch that is left of its tangential spring, m."""

    n: float
    t: float
    spring: float


@njit(**INLINE)
def stretched(old: Memory, end: End, ends: Stretch, compliance: float, drag: float) -> float:
    """Stretch of an end's spring: grown by the slip, or, where the end has changed, such that the force is kept.

    A new contact begins unstretched.
    """
    carrier = rows.MINE if end.mine else rows.THEIRS
    share = -((carrier * ends.turn_r) * old.normal) - old.tangent * ends.turn_q
    share = old.tangent if old.carrier == rows.HANDED_ON else share
    kept = -(share + drag) * compliance
    stretch = old.spring + end.slip if old.carrier == carrier else kept
    return stretch if old.carrier != rows.OPEN else 0.0


@njit(**INLINE)
def remembered(end: End, force: Force) -> Memory:
    """What an end remembers of its force until the next step."""
    carrier = rows.MINE if end.mine else rows.THEIRS
    return Memory(force.spring, carrier if end.closed else rows.OPEN, force.n, force.t)


@njit(**INLINE)
def twice_taken(end: End, old: Memory, force: Force) -> float:
    """Twice the energy that an end took from the elements since the last step: mean force times displacement, J."""
    return (old.normal + force.n) * (end.depth - end.before) - (old.tangent + force.t) * end.slip


@njit(**INLINE)
def action_of(one: End, two: End, f1: Force, f2: Force) -> Action:
    """What both ends' forces do to the elements."""
    return Action(
        (f1.n * one.nx + f1.t * one.nz) + (f2.n * two.nx + f2.t * two.nz),
        (f1.n * one.nz - f1.t * one.nx) + (f2.n * two.nz - f2.t * two.nx),
        (one.a.n * f1.n + one.a.t * f1.t) + (two.a.n * f2.n + two.a.t * f2.t),
        (one.b.n * f1.n + one.b.t * f1.t) + (two.b.n * f2.n + two.b.t * f2.t),
    )


@njit(**INLINE)
def act(q: Any, a: Any, b: Any, j: int, pair: Pair, ends: Stretch, f1: Force, f2: Force) -> None:
    """Let both ends' forces act on the elements and keep them."""
    one, two = ends.one, ends.two
    deepest = larger(pair.deepest, one.depth) if one.closed else pair.deepest
    deepest = larger(deepest, two.depth) if two.closed else deepest
    new = action_of(one, two, f1, f2)
    on_a, on_b = rows.load_force(a, j), rows.load_force(b, j)
    rows.store_force(a, j, Plane(on_a.x + new.x, on_a.z + new.z, on_a.w + new.moment_a))
    rows.store_force(b, j, Plane(on_b.x - new.x, on_b.z - new.z, on_b.w - new.moment_b))
    rows.store_vertices(q, j, ends.now)
    rows.store_memory(q, j, remembered(one, f1))
    rows.store_memory(q, j + rows.SECOND, remembered(two, f2))
    q[rows.DEEPEST + j] = deepest
    q[rows.TAKEN + j] = pair.taken + 0.5 * (twice_taken(one, pair.one, f1) + twice_taken(two, pair.two, f2))
