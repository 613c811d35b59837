"""Mechanics shared by both schemes: motion of an element, tangential spring, friction, forces of a contact end.

An end's force is ``n (n_x, n_z) + t (n_z, −n_x)`` on the pair's first element a, and the opposite on the second, b.
"""

from typing import NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import INLINE
from overturning.dem.kernel.mechanics import clamp_magnitude, rotate_cosine_and_sine, updated_maximum
from overturning.dem.polygon.faces import CommonStretch, ContactEnd
from overturning.dem.polygon.state import (
    MINE,
    OPEN,
    THEIRS,
    TRANSFERRED,
    ContactLaw,
    ElementState,
    EndHistory,
    PairHistory,
    PlanarVector,
    Pose,
    VertexPositions,
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


class PairForce(NamedTuple):
    """Sum of the forces of both ends of a pair, with their moments."""

    x: float
    """Force on a, N; the opposite acts on b."""
    z: float
    """Upward force on a, N."""
    moment_a: float
    """Moment about the centre of a, N m."""
    moment_b: float
    """Moment of the same force about the centre of b, N m; the opposite acts on b."""


class AssumedContact(NamedTuple):
    """State of a contact end that the equations of a step assume."""

    stretch: float
    """Predicted stretch of the tangential spring, m."""
    slid: float
    """±μ if the end is assumed to slide, else 0."""


class RelativeVector(NamedTuple):
    """Velocity of a relative to b with both angular velocities, or a direction with lever arms about both centres."""

    x: float
    """Relative velocity, m/s, or component of the direction."""
    z: float
    """Upward component."""
    a: float
    """Angular velocity of a, rad/s, or lever arm about its centre, m."""
    b: float
    """Angular velocity of b, rad/s, or lever arm about its centre, m."""


class PairMatrix(NamedTuple):
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
def element_acceleration(
    element: ElementState, horizontal_ground: float, vertical_ground: float, gravity: float
) -> PlanarVector:
    """Return the acceleration of an element in the frame of the base: contacts, weight, base acceleration (m/s²)."""
    force, own = element.force, element.inertia
    fall = gravity * own.weight + vertical_ground
    return PlanarVector(
        force.x * own.inverse_mass - horizontal_ground, force.z * own.inverse_mass - fall, force.w * own.inverse_inertia
    )


@njit(**INLINE)
def velocity_after(velocity: PlanarVector, acceleration: PlanarVector, dt: float) -> PlanarVector:
    """Return a velocity after a time `dt` (s) with constant acceleration."""
    return PlanarVector(
        velocity.x + dt * acceleration.x, velocity.z + dt * acceleration.z, velocity.w + dt * acceleration.w
    )


@njit(**INLINE)
def pose_after(pose: Pose, velocity: PlanarVector, dt: float) -> Pose:
    """Return a pose after a time `dt` (s) with constant velocity."""
    c, s = rotate_cosine_and_sine(pose.cos, pose.sin, dt * velocity.w)
    return Pose(pose.x + dt * velocity.x, pose.z + dt * velocity.z, pose.angle + dt * velocity.w, c, s)


@njit(**INLINE)
def inertial_power(
    element: ElementState, horizontal_ground: float, vertical_ground: float, velocity: PlanarVector
) -> float:
    """Return the power of the inertial forces on an element, and of the forces that hold a fixed element, W."""
    own, force = element.inertia, element.force
    return own.mass * (horizontal_ground * velocity.x + vertical_ground * velocity.z) + own.held * (
        force.x * velocity.x + force.z * velocity.z
    )


@njit(**INLINE)
def carrier_code(end: ContactEnd) -> float:
    """Return the code of the element whose vertex is the contact vertex of an end: `MINE` (a) or `THEIRS` (b)."""
    return MINE if end.mine > 0.0 else THEIRS


@njit(**INLINE)
def spring_stretch(
    previous_end: EndHistory, end: ContactEnd, both_ends: CommonStretch, compliance: float, damping_force: float
) -> float:
    """Return the stretch (m) of an end's tangential spring before slip.

    The slip of the step is added. If another vertex now carries the end, the stretch is set such that the force does
    not change. A new contact starts with 0.
    """
    carrier = carrier_code(end)
    share = -((carrier * both_ends.turn_r) * previous_end.normal) - previous_end.tangent * both_ends.turn_q
    share = previous_end.tangent if previous_end.carrier == TRANSFERRED else share
    equivalent = -(share + damping_force) * compliance
    stretch = previous_end.spring + end.slip if previous_end.carrier == carrier else equivalent
    return stretch if previous_end.carrier != OPEN else 0.0


@njit(**INLINE)
def sum_end_forces(end_1: ContactEnd, end_2: ContactEnd, force_1: EndForce, force_2: EndForce) -> PairForce:
    """Return the sum of the contact forces of both ends of a pair, with their moments."""
    return PairForce(
        (force_1.n * end_1.nx + force_1.t * end_1.nz) + (force_2.n * end_2.nx + force_2.t * end_2.nz),
        (force_1.n * end_1.nz - force_1.t * end_1.nx) + (force_2.n * end_2.nz - force_2.t * end_2.nx),
        (end_1.a.n * force_1.n + end_1.a.t * force_1.t) + (end_2.a.n * force_2.n + end_2.a.t * force_2.t),
        (end_1.b.n * force_1.n + end_1.b.t * force_1.t) + (end_2.b.n * force_2.n + end_2.b.t * force_2.t),
    )


@njit(**INLINE)
def add_pair_force(
    force_on_a: PlanarVector, force_on_b: PlanarVector, pair_force: PairForce
) -> tuple[PlanarVector, PlanarVector]:
    """Add the forces of a pair's ends to the forces on its elements."""
    return (
        PlanarVector(force_on_a.x + pair_force.x, force_on_a.z + pair_force.z, force_on_a.w + pair_force.moment_a),
        PlanarVector(force_on_b.x - pair_force.x, force_on_b.z - pair_force.z, force_on_b.w - pair_force.moment_b),
    )


@njit(**INLINE)
def relative_velocity(velocity_a: PlanarVector, velocity_b: PlanarVector) -> RelativeVector:
    """Return the velocity of element a relative to element b, with the angular velocities of both."""
    return RelativeVector(velocity_a.x - velocity_b.x, velocity_a.z - velocity_b.z, velocity_a.w, velocity_b.w)


@njit(**INLINE)
def opening_and_slip_rates(end: ContactEnd, velocity: RelativeVector) -> tuple[float, float]:
    """Return the velocities (m/s) at which the faces of a contact end open and slip."""
    opening = (end.nx * velocity.x + end.nz * velocity.z) + (velocity.a * end.a.n - velocity.b * end.b.n)
    return opening, (end.nz * velocity.x - end.nx * velocity.z) + (velocity.a * end.a.t - velocity.b * end.b.t)


@njit(**INLINE)
def apply_friction(
    trial_force: float, normal_force: float, contact_law: ContactLaw, flat_landing: tuple[bool, bool, float]
) -> tuple[float, float, bool]:
    """Return the friction force of an end (N), the limit of its spring force (N), and whether the end slips.

    `trial_force` is the force without friction limit (N), `normal_force` the normal force (N). `flat_landing` holds
    whether the end is held in a flat landing, and the two results of `flat_landing_slip`.
    """
    (held, drifts, drift), limit = flat_landing, contact_law.friction * normal_force
    slips = drifts if held else abs(trial_force) > limit
    force = drift * normal_force if drifts else (clamp_magnitude(trial_force, limit) if slips else trial_force)
    return force, (limit if limit > 0.0 else 0.0), slips


@njit(**INLINE)
def next_end_history(
    previous_end: EndHistory,
    other_end: EndHistory,
    end: ContactEnd,
    result: EndResult,
    contact_law: ContactLaw,
    elapsed: float,
) -> EndHistory:
    """Return the contact history of an end for the next step; `elapsed` is the time since the last step, s.

    The landing of an end that touches now ends together with that of the other end, if that one is already in contact.
    """
    begun = contact_law.landing if other_end.carrier == OPEN else other_end.landing - elapsed
    left = previous_end.landing - elapsed if previous_end.carrier != OPEN else begun
    carrier = carrier_code(end) if result.inside else OPEN
    return EndHistory(result.force.spring, carrier, result.force.n, result.force.t, left if result.inside else 0.0)


@njit(**INLINE)
def twice_energy_absorbed(previous_end: EndHistory, end: ContactEnd, result: EndResult) -> float:
    """Return twice the energy that an end absorbed in a step, J: mean force times displacement."""
    value = (previous_end.normal + result.force.n) * (result.depth - end.before) - (
        previous_end.tangent + result.force.t
    ) * result.slip
    return value if (previous_end.carrier != OPEN) | result.inside else 0.0


@njit(**INLINE)
def next_pair_history(
    previous_pair: PairHistory,
    both_ends: CommonStretch,
    vertices: VertexPositions,
    results: tuple[EndResult, EndResult],
    contact_law: ContactLaw,
    elapsed: float,
) -> PairHistory:
    """Return the contact history of a pair after a step that ends with the given vertex positions."""
    s1, s2 = results
    deepest = updated_maximum(previous_pair.deepest, s1.depth if s1.inside else 0.0)
    deepest = updated_maximum(deepest, s2.depth if s2.inside else 0.0)
    absorbed = 0.5 * (
        twice_energy_absorbed(previous_pair.one, both_ends.one, s1)
        + twice_energy_absorbed(previous_pair.two, both_ends.two, s2)
    )
    return PairHistory(
        vertices,
        next_end_history(previous_pair.one, previous_pair.two, both_ends.one, s1, contact_law, elapsed),
        next_end_history(previous_pair.two, previous_pair.one, both_ends.two, s2, contact_law, elapsed),
        deepest,
        previous_pair.absorbed + absorbed,
    )
