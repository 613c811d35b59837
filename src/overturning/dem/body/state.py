"""What the kernel in space knows of a body: named tuples, and the rows of the arrays that hold them.

Units are per unit of mass, as in the plane (`overturning.dem.block.state`); an inertia is m². The frame moves with the base and is
turned with the body's orientation: x points to its azimuth, y 90° anticlockwise of it, z up. The body's own axes coincide with these
at rest. `overturning.dem.kernel.lanes` says how bodies lie side by side; the vertices of a body have an array of their own, a table
`VERTEX` after another.
"""

from typing import Final, NamedTuple

from numba import njit

from overturning.dem.body.centred_rows import Change, Equations, Largest, Predicted, PredictedPoint, Rejected, Sum
from overturning.dem.kernel.clock import BODY, Attempt, Clock
from overturning.dem.kernel.ending import Course
from overturning.dem.kernel.ground import Line
from overturning.dem.kernel.lanes import INLINE, Rows

COLUMNS: Final = 48
"""Bodies side by side."""

TICKS: Final = BODY.whole
"""Ticks of a whole step."""


class Body(NamedTuple):
    """Constants of a case."""

    ixx: float
    """Inverse of the inertia in the body's own axes, m/I, 1/m²;"""
    iyy: float
    izz: float
    ixy: float
    ixz: float
    iyz: float
    axx: float
    """The inertia itself, m²;"""
    ayy: float
    azz: float
    axy: float
    axz: float
    ayz: float
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
    """length of a tick, s."""


class State(NamedTuple):
    """Where a body is, how it moves, and what acts on it."""

    x: float
    y: float
    z: float
    qw: float
    """Rotation from the rest position, a quaternion;"""
    qx: float
    qy: float
    qz: float
    vx: float
    vy: float
    vz: float
    lx: float
    """angular momentum in space, m²/s;"""
    ly: float
    lz: float
    wx: float
    """angular velocity in space, rad/s;"""
    wy: float
    wz: float
    ax: float
    ay: float
    az: float
    mx: float
    """moment of the contact forces about the centre;"""
    my: float
    mz: float
    tick: float
    """ticks since the sample began."""


class Frame(NamedTuple):
    """The body's axes in space: `xy` is the x of its y-axis."""

    xx: float
    xy: float
    xz: float
    yx: float
    yy: float
    yz: float
    zx: float
    zy: float
    zz: float


class Vertex(NamedTuple):
    """A vertex: where it is in the body's axes, from the centre."""

    px: float
    py: float
    pz: float


class Memory(NamedTuple):
    """What a vertex remembers of the end of the last step."""

    sx: float
    """Stretch of its tangential springs, m;"""
    sy: float
    x: float
    """where it was, m;"""
    y: float
    depth: float
    """its penetration, m, negative in the air;"""
    normal: float
    """the normal force,"""
    slid: float
    """and whether it slid."""


class Point(NamedTuple):
    """A point of contact before a step, and what it is to remember if the step is taken."""

    old: Memory
    new: Memory


class Lying(NamedTuple):
    """How the base of a body lies on the ground."""

    low: float
    """Height of the lowest vertex of the base from the centre, m, negative,"""
    high: float
    """and of the highest;"""
    low_rests: float
    """1 where the lowest rests,"""
    high_rests: float
    """and the highest."""


class Peaks(NamedTuple):
    """What is kept of the path: largest lean and penetration, the square of the largest slip, and the last tick below α."""

    lean: float
    slip: float
    depth: float
    last_upright: float


class Account(NamedTuple):
    """The accounts, per mass: work of the shaking, losses, and vertical angular momentum brought in about the origin."""

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


class Stance(NamedTuple):
    """What a case is judged by beside its `Course`."""

    spin: float
    """Vertical angular momentum about the origin at the start;"""
    reach: float
    """least distance of an edge of the base from below the centre, m;"""
    fallen: float
    """cosine of the tilt at which it has fallen;"""
    deepest: float
    """penetration beyond which the case has failed, m."""


class Vector(NamedTuple):
    """Of three components."""

    x: float
    y: float
    z: float


ROWS: Final = Rows(
    COLUMNS,
    Body,
    Clock,
    State,
    Frame,
    Lying,
    Peaks,
    Account,
    Shaking,
    Course,
    Stance,
    Attempt,
    Rejected,
    Predicted,
    Equations,
    Change,
    Sum,
    Largest,
)
VERTEX: Final = Rows(COLUMNS, Vertex, Point, PredictedPoint)


@njit(**INLINE)
def frame_of(w: float, x: float, y: float, z: float) -> Frame:
    """The body's axes from the quaternion of its rotation."""
    return Frame(
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y),
        2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x),
        2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y),
    )  # fmt: skip


@njit(**INLINE)
def in_space(f: Frame, x: float, y: float, z: float) -> Vector:
    """A vector of the body's axes in those of space. Sums keep x and y together, which makes mirror images exact."""
    return Vector((f.xx * x + f.xy * y) + f.xz * z, (f.yx * x + f.yy * y) + f.yz * z, (f.zx * x + f.zy * y) + f.zz * z)


@njit(**INLINE)
def angular_velocity(body: Body, f: Frame, lx: float, ly: float, lz: float) -> Vector:
    """Angular velocity in space by the angular momentum there: turned into the body's axes, divided by the inertia, and back."""
    x = (f.xx * lx + f.yx * ly) + f.zx * lz
    y = (f.xy * lx + f.yy * ly) + f.zy * lz
    z = (f.xz * lx + f.yz * ly) + f.zz * lz
    return in_space(
        f,
        (body.ixx * x + body.ixy * y) + body.ixz * z,
        (body.ixy * x + body.iyy * y) + body.iyz * z,
        (body.ixz * x + body.iyz * y) + body.izz * z,
    )


@njit(**INLINE)
def rotated(
    w: float, x: float, y: float, z: float, tx: float, ty: float, tz: float
) -> tuple[float, float, float, float]:
    """A quaternion turned about axes in space by a small rotation vector, rad, by series to the fifth order."""
    hx, hy, hz = 0.5 * tx, 0.5 * ty, 0.5 * tz
    square = (hx * hx + hy * hy) + hz * hz
    c = 1.0 - square * (0.5 - square * (1.0 / 24.0))
    s = 1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0))
    ax, ay, az = s * hx, s * hy, s * hz
    return (
        c * w - ((ax * x + ay * y) + az * z),
        (c * x + ax * w) + (ay * z - az * y),
        (c * y + ay * w) + (az * x - ax * z),
        (c * z + az * w) + (ax * y - ay * x),
    )


@njit(**INLINE)
def lean_of(f: Frame) -> float:
    """How far the body leans: sin² of the tilt of its axis up to 90°, 2 − sin² beyond."""
    square = f.xz * f.xz + f.yz * f.yz
    return square if f.zz > 0.0 else 2.0 - square
