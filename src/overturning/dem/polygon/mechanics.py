"""What both schemes share: the motion of an element, the tangential spring, and what an end's force does.

An end's force is ``n (n_x, n_z) + t (n_z, −n_x)`` on the pair's first element a, the opposite on its second, b.
"""

import math
from typing import NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import INLINE
from overturning.dem.kernel.mechanics import larger, slides_flat, turned, within
from overturning.dem.polygon.faces import End, Stretch
from overturning.dem.polygon.state import (
    HANDED_ON,
    MINE,
    OPEN,
    THEIRS,
    Element,
    History,
    Inertia,
    Law,
    Memory,
    Plane,
    Pose,
    Vertices,
)


class Force(NamedTuple):
    """An end's normal and tangential force, N, and the stretch that is left of its tangential spring, m."""

    n: float
    t: float
    spring: float


class Loaded(NamedTuple):
    """What an end does in a step."""

    force: Force
    depth: float
    """At the end of the step, m;"""
    slip: float
    """slip in the step, m;"""
    inside: bool
    """whether it is in contact."""


class Action(NamedTuple):
    """What both ends do: force on a (N), the opposite on b; moments about the centres of a and, reversed, of b, N m."""

    x: float
    z: float
    moment_a: float
    moment_b: float


class Taken(NamedTuple):
    """What an end is taken to do in the equations of a step."""

    stretch: float
    """Stretch of its tangential spring as predicted, m,"""
    slid: float
    """±μ where it slides."""


class Relative(NamedTuple):
    """Velocity of a relative to b and both angular velocities, or a direction and its levers about both centres."""

    x: float
    z: float
    a: float
    b: float


class Outer(NamedTuple):
    """What the velocities of a pair's elements add to their forces (N s/m and so on): rows forces, columns velocities.

    Signs as if b were a: the opposite force acts on b, and the opposite velocity counts.
    """

    xx: float
    xz: float
    zx: float
    zz: float
    xa: float
    za: float
    xb: float
    zb: float
    ax: float
    az: float
    bx: float
    bz: float
    aa: float
    ab: float
    ba: float
    bb: float


@njit(**INLINE)
def acceleration(item: Element, ground: float, up: float, gravity: float) -> Plane:
    """Of an element in the frame of the base, under its contacts, its weight and the base's acceleration."""
    force, own = item.force, item.inertia
    fall = gravity * own.weight + up
    return Plane(force.x * own.inverse_mass - ground, force.z * own.inverse_mass - fall, force.w * own.inverse_inertia)


@njit(**INLINE)
def after(v: Plane, a: Plane, dt: float) -> Plane:
    """A velocity a time dt later."""
    return Plane(v.x + dt * a.x, v.z + dt * a.z, v.w + dt * a.w)


@njit(**INLINE)
def moved(pose: Pose, v: Plane, dt: float) -> Pose:
    """A pose a time dt later."""
    c, s = turned(pose.cos, pose.sin, dt * v.w)
    return Pose(pose.x + dt * v.x, pose.z + dt * v.z, pose.angle + dt * v.w, c, s)


@njit(**INLINE)
def power(item: Element, ground: float, up: float, v: Plane) -> float:
    """Of the inertia that the moving base causes, and of what holds an element, W."""
    own, force = item.inertia, item.force
    return own.mass * (ground * v.x + up * v.z) + own.held * (force.x * v.x + force.z * v.z)


@njit(**INLINE)
def carrier_of(end: End) -> float:
    """Which vertex carries an end, as of `Memory.carrier`."""
    return MINE if end.mine > 0.0 else THEIRS


@njit(**INLINE)
def stretched(old: Memory, end: End, ends: Stretch, compliance: float, drag: float) -> float:
    """Stretch of an end's spring: grown by the slip, or, where the end has changed, such that the force is kept.

    A new contact begins unstretched.
    """
    carrier = carrier_of(end)
    share = -((carrier * ends.turn_r) * old.normal) - old.tangent * ends.turn_q
    share = old.tangent if old.carrier == HANDED_ON else share
    kept = -(share + drag) * compliance
    stretch = old.spring + end.slip if old.carrier == carrier else kept
    return stretch if old.carrier != OPEN else 0.0


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
def pushed(on_a: Plane, on_b: Plane, new: Action) -> tuple[Plane, Plane]:
    """Forces on both elements of a pair with those of its ends."""
    return (
        Plane(on_a.x + new.x, on_a.z + new.z, on_a.w + new.moment_a),
        Plane(on_b.x - new.x, on_b.z - new.z, on_b.w - new.moment_b),
    )


@njit(**INLINE)
def lands(old: Memory, end: End) -> bool:
    """True if an end lands, or touches in this step."""
    return (old.landing > 0.0) | ((old.carrier == OPEN) & (end.faces > 0.0) & (end.depth > 0.0))


@njit(**INLINE)
def lands_flat(law: Law, old: History, ends: Stretch) -> bool:
    """True if both ends land at once, so that a dashpot may pull while its end is in contact."""
    return (law.landing > 0.0) & lands(old.one, ends.one) & lands(old.two, ends.two)


@njit(**INLINE)
def relative(a: Plane, b: Plane) -> Relative:
    """Of two elements' velocities."""
    return Relative(a.x - b.x, a.z - b.z, a.w, b.w)


@njit(**INLINE)
def rates(end: End, u: Relative) -> tuple[float, float]:
    """Velocities at which an end opens and slips."""
    opening = (end.nx * u.x + end.nz * u.z) + (u.a * end.a.n - u.b * end.b.n)
    return opening, (end.nz * u.x - end.nx * u.z) + (u.a * end.a.t - u.b * end.b.t)


@njit(**INLINE)
def drift_of(law: Law, end: End, u: Relative, a: Inertia, b: Inertia, held: bool) -> tuple[bool, float]:
    """Whether an end slides that is held in a flat landing, as of `slides_flat`, and ±μ of it.

    By velocities without the rotation of one element against the other: of both elements as one.
    """
    total = a.inverse_inertia + b.inverse_inertia
    w = (u.a * b.inverse_inertia + u.b * a.inverse_inertia) / (total if total > 0.0 else 1.0)
    opening, slipping = rates(end, Relative(u.x, u.z, w, w))
    return held & slides_flat(law.friction, slipping, opening), -math.copysign(law.friction, slipping)


@njit(**INLINE)
def slider(trial: float, n: float, law: Law, flat: tuple[bool, bool, float]) -> tuple[float, float, bool]:
    """Friction of an end, what its spring may hold at most, and whether it slips.

    `flat` says whether the end is held in a flat landing, and of `drift_of`, whether it slides and by which ±μ.
    """
    (held, drifts, drift), limit = flat, law.friction * n
    slips = drifts if held else abs(trial) > limit
    force = drift * n if drifts else (within(trial, limit) if slips else trial)
    return force, (limit if limit > 0.0 else 0.0), slips


@njit(**INLINE)
def remembered(old: Memory, other: Memory, end: End, now: Loaded, law: Law, dt: float) -> Memory:
    """What an end remembers until the next step, which begins a time dt after the last one.

    One that touches lands for as long as the other one, which has begun if it is not in the air.
    """
    begun = law.landing if other.carrier == OPEN else other.landing - dt
    left = old.landing - dt if old.carrier != OPEN else begun
    carrier = carrier_of(end) if now.inside else OPEN
    return Memory(now.force.spring, carrier, now.force.n, now.force.t, left if now.inside else 0.0)


@njit(**INLINE)
def twice_taken(old: Memory, end: End, now: Loaded) -> float:
    """Twice the energy that an end took from the elements in a step: mean force times displacement, J."""
    value = (old.normal + now.force.n) * (now.depth - end.before) - (old.tangent + now.force.t) * now.slip
    return value if (old.carrier != OPEN) | now.inside else 0.0


@njit(**INLINE)
def history_of(
    old: History, ends: Stretch, vertices: Vertices, both: tuple[Loaded, Loaded], law: Law, dt: float
) -> History:
    """What a pair remembers of a step, after which its vertices are there."""
    s1, s2 = both
    deepest = larger(old.deepest, s1.depth if s1.inside else 0.0)
    deepest = larger(deepest, s2.depth if s2.inside else 0.0)
    taken = 0.5 * (twice_taken(old.one, ends.one, s1) + twice_taken(old.two, ends.two, s2))
    return History(
        vertices,
        remembered(old.one, old.two, ends.one, s1, law, dt),
        remembered(old.two, old.one, ends.two, s2, law, dt),
        deepest,
        old.taken + taken,
    )
