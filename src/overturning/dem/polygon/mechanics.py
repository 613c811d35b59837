"""Mechanics shared by both schemes: motion of an element, tangential spring, friction, forces of a contact end.

An end's force is ``n (n_x, n_z) + t (n_z, −n_x)`` on the pair's first element a, and the opposite on the second, b.
"""

import math
from typing import NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import INLINE
from overturning.dem.kernel.mechanics import clamp, larger, rotate_pair, slides_flat
from overturning.dem.polygon.faces import End, Stretch
from overturning.dem.polygon.state import (
    MINE,
    OPEN,
    THEIRS,
    TRANSFERRED,
    ElementState,
    History,
    Inertia,
    Law,
    Memory,
    Plane,
    Pose,
    Vertices,
)


class EndForce(NamedTuple):
    """Force of a contact end."""

    n: float
    """Normal force, N."""
    t: float
    """Tangential force, N."""
    spring: float
    """Stretch of the tangential spring after slip, m."""


class EndResult(NamedTuple):
    """State of a contact end at the end of a step."""

    force: EndForce
    depth: float
    """Penetration, m."""
    slip: float
    """Slip in the step, m."""
    inside: bool
    """True if the end is in contact."""


class PairAction(NamedTuple):
    """Sum of the forces of both ends of a pair, with their moments."""

    x: float
    """Force on a, N; the opposite acts on b."""
    z: float
    """Upward force on a, N."""
    moment_a: float
    """Moment about the centre of a, N m."""
    moment_b: float
    """Moment of the same force about the centre of b, N m; the opposite acts on b."""


class PredictedContact(NamedTuple):
    """State of a contact end that the equations of a step assume."""

    stretch: float
    """Predicted stretch of the tangential spring, m."""
    slid: float
    """±μ if the end is assumed to slide, else 0."""


class Relative(NamedTuple):
    """Velocity of a relative to b with both angular velocities, or a direction with lever arms about both centres."""

    x: float
    """Relative velocity, m/s, or component of the direction."""
    z: float
    """Upward component."""
    a: float
    """Angular velocity of a, rad/s, or lever arm about its centre, m."""
    b: float
    """Angular velocity of b, rad/s, or lever arm about its centre, m."""


class Outer(NamedTuple):
    """Matrix that gives a pair's forces from its velocities (N s/m, N s, N m s); first index force, second velocity.

    Forces and moments are those on a; the opposite act on b. Velocities of b count with the opposite sign.
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
def acceleration(item: ElementState, ground: float, up: float, gravity: float) -> Plane:
    """Return the acceleration of an element in the frame of the base: contacts, weight and base acceleration (m/s²)."""
    force, own = item.force, item.inertia
    fall = gravity * own.weight + up
    return Plane(force.x * own.inverse_mass - ground, force.z * own.inverse_mass - fall, force.w * own.inverse_inertia)


@njit(**INLINE)
def velocity_after(v: Plane, a: Plane, dt: float) -> Plane:
    """Return a velocity after a time `dt` (s) with constant acceleration."""
    return Plane(v.x + dt * a.x, v.z + dt * a.z, v.w + dt * a.w)


@njit(**INLINE)
def pose_after(pose: Pose, v: Plane, dt: float) -> Pose:
    """Return a pose after a time `dt` (s) with constant velocity."""
    c, s = rotate_pair(pose.cos, pose.sin, dt * v.w)
    return Pose(pose.x + dt * v.x, pose.z + dt * v.z, pose.angle + dt * v.w, c, s)


@njit(**INLINE)
def power(item: ElementState, ground: float, up: float, v: Plane) -> float:
    """Return the power of the inertial forces of the moving base, and of the forces that hold a fixed element, W."""
    own, force = item.inertia, item.force
    return own.mass * (ground * v.x + up * v.z) + own.held * (force.x * v.x + force.z * v.z)


@njit(**INLINE)
def carrier_of(end: End) -> float:
    """Return the vertex that carries an end, `MINE` or `THEIRS`; see `Memory.carrier`."""
    return MINE if end.mine > 0.0 else THEIRS


@njit(**INLINE)
def spring_stretch(old: Memory, end: End, ends: Stretch, compliance: float, drag: float) -> float:
    """Return the stretch (m) of an end's tangential spring before slip.

    The slip of the step is added. If another vertex now carries the end, the stretch is set such that the force does
    not change. A new contact starts with 0.
    """
    carrier = carrier_of(end)
    share = -((carrier * ends.turn_r) * old.normal) - old.tangent * ends.turn_q
    share = old.tangent if old.carrier == TRANSFERRED else share
    equivalent = -(share + drag) * compliance
    stretch = old.spring + end.slip if old.carrier == carrier else equivalent
    return stretch if old.carrier != OPEN else 0.0


@njit(**INLINE)
def combined_action(one: End, two: End, f1: EndForce, f2: EndForce) -> PairAction:
    """Return the sum of the forces of both ends, with their moments."""
    return PairAction(
        (f1.n * one.nx + f1.t * one.nz) + (f2.n * two.nx + f2.t * two.nz),
        (f1.n * one.nz - f1.t * one.nx) + (f2.n * two.nz - f2.t * two.nx),
        (one.a.n * f1.n + one.a.t * f1.t) + (two.a.n * f2.n + two.a.t * f2.t),
        (one.b.n * f1.n + one.b.t * f1.t) + (two.b.n * f2.n + two.b.t * f2.t),
    )


@njit(**INLINE)
def add_action(on_a: Plane, on_b: Plane, new: PairAction) -> tuple[Plane, Plane]:
    """Add the forces of a pair's ends to the forces on its elements."""
    return (
        Plane(on_a.x + new.x, on_a.z + new.z, on_a.w + new.moment_a),
        Plane(on_b.x - new.x, on_b.z - new.z, on_b.w - new.moment_b),
    )


@njit(**INLINE)
def lands(old: Memory, end: End) -> bool:
    """True if an end is in a landing, or first touches in this step."""
    return (old.landing > 0.0) | ((old.carrier == OPEN) & (end.faces > 0.0) & (end.depth > 0.0))


@njit(**INLINE)
def lands_flat(law: Law, old: History, ends: Stretch) -> bool:
    """True if both ends land at once, so that a dashpot may pull while its end is in contact."""
    return (law.landing > 0.0) & lands(old.one, ends.one) & lands(old.two, ends.two)


@njit(**INLINE)
def relative(a: Plane, b: Plane) -> Relative:
    """Return the velocity of a relative to b, with both angular velocities."""
    return Relative(a.x - b.x, a.z - b.z, a.w, b.w)


@njit(**INLINE)
def rates(end: End, u: Relative) -> tuple[float, float]:
    """Return the velocities (m/s) at which an end opens and slips."""
    opening = (end.nx * u.x + end.nz * u.z) + (u.a * end.a.n - u.b * end.b.n)
    return opening, (end.nz * u.x - end.nx * u.z) + (u.a * end.a.t - u.b * end.b.t)


@njit(**INLINE)
def flat_landing_slip(law: Law, end: End, u: Relative, a: Inertia, b: Inertia, held: bool) -> tuple[bool, float]:
    """Return whether an end that is held in a flat landing slides (`slides_flat`), and ±μ of its friction.

    Decided by the velocities without the rotation of one element relative to the other, as if both were one body.
    """
    total = a.inverse_inertia + b.inverse_inertia
    w = (u.a * b.inverse_inertia + u.b * a.inverse_inertia) / (total if total > 0.0 else 1.0)
    opening, slipping = rates(end, Relative(u.x, u.z, w, w))
    return held & slides_flat(law.friction, slipping, opening), -math.copysign(law.friction, slipping)


@njit(**INLINE)
def apply_friction(trial: float, n: float, law: Law, flat: tuple[bool, bool, float]) -> tuple[float, float, bool]:
    """Return the friction force of an end (N), the limit of its spring force (N), and whether it slips.

    `trial` is the force without friction limit (N), `n` the normal force (N). `flat` holds whether the end is held in a
    flat landing, and the two results of `flat_landing_slip`.
    """
    (held, drifts, drift), limit = flat, law.friction * n
    slips = drifts if held else abs(trial) > limit
    force = drift * n if drifts else (clamp(trial, limit) if slips else trial)
    return force, (limit if limit > 0.0 else 0.0), slips


@njit(**INLINE)
def next_memory(old: Memory, other: Memory, end: End, now: EndResult, law: Law, dt: float) -> Memory:
    """Return the contact history of an end for the next step; `dt` is the time since the last step, s.

    The landing of an end that touches now ends together with that of the other end, if that one is already in contact.
    """
    begun = law.landing if other.carrier == OPEN else other.landing - dt
    left = old.landing - dt if old.carrier != OPEN else begun
    carrier = carrier_of(end) if now.inside else OPEN
    return Memory(now.force.spring, carrier, now.force.n, now.force.t, left if now.inside else 0.0)


@njit(**INLINE)
def twice_energy_absorbed(old: Memory, end: End, now: EndResult) -> float:
    """Return twice the energy that an end absorbed in a step, J: mean force times displacement."""
    value = (old.normal + now.force.n) * (now.depth - end.before) - (old.tangent + now.force.t) * now.slip
    return value if (old.carrier != OPEN) | now.inside else 0.0


@njit(**INLINE)
def next_history(
    old: History, ends: Stretch, vertices: Vertices, both: tuple[EndResult, EndResult], law: Law, dt: float
) -> History:
    """Return the contact history of a pair after a step that ends with the given vertex positions."""
    s1, s2 = both
    deepest = larger(old.deepest, s1.depth if s1.inside else 0.0)
    deepest = larger(deepest, s2.depth if s2.inside else 0.0)
    absorbed = 0.5 * (twice_energy_absorbed(old.one, ends.one, s1) + twice_energy_absorbed(old.two, ends.two, s2))
    return History(
        vertices,
        next_memory(old.one, old.two, ends.one, s1, law, dt),
        next_memory(old.two, old.one, ends.two, s2, law, dt),
        deepest,
        old.absorbed + absorbed,
    )
