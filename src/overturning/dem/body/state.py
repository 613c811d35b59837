"""What the kernel in space knows of a body: named tuples, and the rows of the arrays that hold them.

Units are per unit of mass, as in the plane (`overturning.dem.block.state`); an inertia is m². The frame moves with the
base and is turned with the body's orientation: x points to its azimuth, y 90° anticlockwise of it, z up. The body's
own axes coincide with these at rest. `overturning.dem.kernel.lanes` says how bodies lie side by side; the vertices of a
body have an array of their own, a table `VERTEX` after another.
"""

from typing import Final, NamedTuple

from numba import njit

from overturning.dem.body.vectors import Matrix, Quaternion, Symmetric, Vector, apply, frame_of, full, transposed
from overturning.dem.kernel.clock import BODY, Attempt, Clock
from overturning.dem.kernel.ending import CaseProgress, RestState
from overturning.dem.kernel.ground import Line
from overturning.dem.kernel.lanes import INLINE, Rows

COLUMNS: Final = 16
"""Bodies side by side: their rows fit into the nearest cache of a processor, 48 KB, those of more do not."""

RIGID: Final = 10.0
"""Whole samples are the steps of a body that stands where 1/ω is so many times shorter and nothing rings."""

TICKS: Final = BODY.whole
"""Ticks of a whole step."""


class Body(NamedTuple):
    """Constants of a case."""

    inverse: Symmetric
    """Inverse of the inertia in the body's own axes, m/I, 1/m²;"""
    inertia: Symmetric
    """the inertia itself, m²;"""
    foot: float
    """height of the centre above the base, m;"""
    radius: float
    """of a rim, m;"""
    stiffness: float
    """of the normal spring of a vertex, 1/s²,"""
    tangential: float
    """of either tangential one,"""
    compliance: float
    """1 over that, 0 where there is none;"""
    dashpot: float
    """1/s;"""
    friction: float
    """μ;"""
    critical: float
    """`lean` at the critical angle;"""
    ends: float
    """share of the rise from the lowest to the highest vertex of the base within which vertices belong to its ends;"""
    step: float
    """length of a tick, s;"""
    landing: float
    """how long a point lands after it has touched, s."""


class State(NamedTuple):
    """Where a body is, how it moves, and what acts on it."""

    place: Vector
    turn: Quaternion
    velocity: Vector
    momentum: Vector
    """Angular momentum in space, m²/s;"""
    spin: Vector
    """angular velocity in space, rad/s;"""
    acceleration: Vector
    moment: Vector
    """of the contact forces about the centre;"""
    tick: float
    """ticks since the sample began."""


class Vertex(NamedTuple):
    """A vertex."""

    own: Vector
    """Where it is in the body's axes, from the centre, m."""


class Memory(NamedTuple):
    """What a vertex remembers of the end of the last step."""

    sx: float
    """Stretch of its tangential springs, m;"""
    sy: float
    x: float
    """where it was, m; its velocity where it is a point of a rim, m/s;"""
    y: float
    depth: float
    """its penetration, m, negative in the air;"""
    normal: float
    """the normal force,"""
    slid: float
    """whether it slid,"""
    landing: float
    """and for how long it still lands, s, 0 or less where it does not."""


class Point(NamedTuple):
    """A point of contact before a step, and what it is to remember if the step is taken."""

    old: Memory
    new: Memory


IN_THE_AIR: Final = -1e300
"""For how long a base in the air lands, s: less than any that has touched."""


class Lying(NamedTuple):
    """How the base of a body lies on the ground."""

    low: float
    """Height of the lowest vertex of the base from the centre, m, negative,"""
    high: float
    """and of the highest;"""
    low_rests: float
    """1 where the lowest rests,"""
    high_rests: float
    """and the highest;"""
    landing: float
    """for how long all points of the base still land, s, 0 or less where one does not,"""
    begun: float
    """and the longest of those in contact, `IN_THE_AIR` where none is."""


class Peaks(NamedTuple):
    """What is kept of the path: largest lean and penetration, square of the largest slip, and last tick below α."""

    lean: float
    slip: float
    depth: float
    last_upright: float


class Account(NamedTuple):
    """Accounts, per mass: work of the shaking, losses, and vertical angular momentum brought in about the origin."""

    work: float
    lost: float
    spin: float
    power: float
    """Their rates at the last step."""
    loss: float
    torque: float


class Shaking(NamedTuple):
    """What the moving base does to the body in its own frame, m/s²."""

    push_x: Line
    """−a;"""
    push_y: Line
    lift: Line
    """a_up, which adds to gravity."""


class Loaded(NamedTuple):
    """Which shaking is in the lane: that of a sample counted from 1, 0 where none is."""

    sample: float


class Stance(NamedTuple):
    """Limits that terminate a case, next to its `CaseProgress`."""

    spin: float
    """Vertical angular momentum about the origin at the start;"""
    reach: float
    """least distance of an edge of the base from below the centre, m;"""
    fallen: float
    """cosine of the least tilt at which it has fallen;"""
    deepest: float
    """penetration beyond which the case has failed, m;"""
    steady: float
    """horizontal acceleration below which it stands in steps of a sample, as a share of its weight."""


class PredictedPoint(NamedTuple):
    """A point of contact at the predicted end of a step."""

    arm: Vector
    """From the centre, m;"""
    depth: float
    tx: float
    """stretch of the tangential springs, m;"""
    ty: float
    velocity: Vector
    on: float
    """1 where it is taken to be in contact,"""
    slides: float
    """and to slide,"""
    dx: float
    """friction pointing this way."""
    dy: float
    waits: float
    """1 where it does not carry before the ends of the base rest,"""
    held: float
    """1 where the body lands flat, so that the dashpot may pull,"""
    begun: float
    """and for how long the point lands if it touches now, s."""


class Rejected(NamedTuple):
    """Whether the last step was not accepted, and whether its points are taken as before in the next one: 1 or 0."""

    again: float
    sooner: float


class Predicted(NamedTuple):
    """A step of the centred scheme before its equations are solved."""

    place: Vector
    turn: Quaternion
    velocity: Vector
    """Velocity and angular momentum after half the step;"""
    momentum: Vector
    end: Vector
    """velocity at its end,"""
    spin: Vector
    """angular velocity there;"""
    shaking: Vector
    """−a along x and y, and a_up, m/s²;"""
    half: float
    """half its length, s."""


class Equations(NamedTuple):
    """Forces and moments at the predicted end, and what velocities there change of them, of all points of contact."""

    force: Vector
    moment: Vector
    a: Matrix
    """Force by velocity,"""
    b: Matrix
    """force by angular velocity,"""
    c: Matrix
    """moment by velocity,"""
    d: Matrix
    """moment by angular velocity."""


class Change(NamedTuple):
    """What the solution adds to the predicted velocity and angular velocity."""

    velocity: Vector
    spin: Vector


class Sum(NamedTuple):
    """What all points of contact do at the solution."""

    force: Vector
    moment: Vector
    impulse: Vector
    """What those closed within the step act for longer, as momentum"""
    twist: Vector
    """and angular momentum;"""
    loss: float
    """power of dashpots and sliders,"""
    let_go: float
    """energy that springs let go."""


class Largest(NamedTuple):
    """The largest of what is found at any point of contact, 0 or less where it is found at none."""

    changed: float
    """Above 0 where a contact opened or closed,"""
    wrong: float
    """1 where a point was taken to do otherwise,"""
    reversed: float
    """or to slide against its velocity,"""
    holds: float
    """or holds,"""
    back: float
    """or slides where friction held it the other way before,"""
    off: float
    """or is in the air;"""
    depth: float


ROWS: Final = Rows(
    COLUMNS, Body, Clock, State, Matrix, Lying, Peaks, Account, Shaking, Loaded, CaseProgress, Stance, Attempt,
    Rejected, Predicted, Equations, Change, Sum, Largest, RestState,
)  # fmt: skip
VERTEX: Final = Rows(COLUMNS, Vertex, Point, PredictedPoint)


@njit(**INLINE)
def angular_velocity(body: Body, f: Matrix, momentum: Vector) -> Vector:
    """Angular velocity in space by the angular momentum there, of a body with given axes."""
    return apply(f, apply(full(body.inverse), apply(transposed(f), momentum)))


@njit(**INLINE)
def spin_of(body: Body, s: State) -> Vector:
    """Angular velocity in space by the state's angular momentum."""
    return angular_velocity(body, frame_of(s.turn), s.momentum)


@njit(**INLINE)
def lean_of(f: Matrix) -> float:
    """How far the body leans: sin² of the tilt of its axis up to 90°, 2 − sin² beyond."""
    square = f.xz * f.xz + f.yz * f.yz
    return square if f.zz > 0.0 else 2.0 - square
