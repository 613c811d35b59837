"""What the queue asks of a body in space: its rules, how a case begins, how a sample goes, how a case ends.

Vertices i and i + count/2 stand opposite each other; the rows of vertex i lie behind those of the body, `VERTEX.size` numbers for
each.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit
from numba.extending import overload
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.body.centred_loops import loops
from overturning.dem.body.ending import energy, finish_body, has_ended, note, spin_about_origin
from overturning.dem.body.state import (
    COLUMNS,
    ROWS,
    TICKS,
    VERTEX,
    Body,
    Memory,
    Peaks,
    Point,
    Shaking,
    Stance,
    State,
    Vertex,
    frame_of,
    in_space,
    lean_of,
)
from overturning.dem.kernel.clock import Attempt, Clock
from overturning.dem.kernel.ending import Course
from overturning.dem.kernel.ground import Ground, piece
from overturning.dem.kernel.lanes import INNER, aligned
from overturning.dem.kernel.queue import implement, with_room
from overturning.units import STANDARD_GRAVITY as GRAVITY

START: Final = np.dtype([(name, "f8") for name in (
    "x", "y", "z", "qw", "qx", "qy", "qz", "vx", "vy", "vz", "wx", "wy", "wz",
)])  # fmt: skip
"""How a body begins: place (m), rotation from the pose at rest, velocity (m/s) and angular velocity (rad/s) in its own frame."""

CASE: Final = np.dtype([("body", "i8"), *((name, "f8") for name in (
    "stiffness", "tangential", "dashpot", "friction", "amplitude", "first", "calm", "after", *Clock._fields,
)), ("start", START)])  # fmt: skip
"""What a case is computed with, in the units of `Body`, `Course` and `Clock`; `body` is the row of `BODY`."""

BODY: Final = np.dtype([(name, "f8") for name in (
    "ixx", "iyy", "izz", "ixy", "ixz", "iyz", "axx", "ayy", "azz", "axy", "axz", "ayz", "foot", "radius", "reach", "critical",
    "fallen", "deepest", "ends",
)])  # fmt: skip
"""Constants of a body, as of `Body` and `Stance`."""

RESULT: Final = np.dtype([(name, "f8") for name in (
    "status", "fallen", "time", "lean", "slip", "slip_x", "slip_y", "depth", "energy", "spin", "steps", "qw", "qx", "qy", "qz",
)])  # fmt: skip
"""What is found of a case, with the rotation at its end."""

ROW: Final = np.dtype([("time", "f8"), *START.descr, *((name, "f8") for name in ("ground_x", "ground_y", "ground_z"))])
"""A row of a trajectory."""


class Vertices(NamedTuple):
    """Marks bodies with vertices."""

    round: bool = False


class Rim(NamedTuple):
    """Marks bodies with a rim."""

    round: bool = True


LOOPS: Final = {Vertices: loops(False), Rim: loops(True)}
"""The steps of a sample by the type of the mark."""


class BodyRules(NamedTuple):
    """Rules of cases of bodies in space, all with the same steps per sample and as many vertices."""

    kind: Any
    """mark of the bodies, of a type in `LOOPS`;"""
    cases: NDArray[np.void]
    """table of cases, of `CASE`;"""
    row: NDArray[np.int64]
    """row of the ground motion that shakes each case;"""
    bodies: NDArray[np.void]
    """table of bodies, of `BODY`;"""
    points: FloatArray
    """vertices of each body from its centre, m, shape (bodies, vertices, 3);"""
    base: int
    """how many of them a body rests on;"""
    results: NDArray[np.void]
    """table to fill, of `RESULT`;"""
    ground: Ground
    at_once: int
    """whole steps per sample;"""
    budget: int
    """largest number of steps of a case;"""
    most_rows: int
    """rows that a path may have."""
    weight: int = 1
    lanes: int = COLUMNS


class Work(NamedTuple):
    """What bodies are computed in."""

    state: Any
    """All rows, those of"""
    vertices: Any
    """the vertices behind those of the body."""


load_body, store_body, _ = ROWS.access(Body)
load_state, store_state, _ = ROWS.access(State)
load_peaks, store_peaks, _ = ROWS.access(Peaks)
load_course, store_course, _ = ROWS.access(Course)
load_stance, store_stance, _ = ROWS.access(Stance)
store_shaking, store_attempt, store_clock = (ROWS.access(of).store for of in (Shaking, Attempt, Clock))
store_vertex, store_memory = VERTEX.access(Vertex).store, VERTEX.access(Point, "old").store
NUMBERS: Final = ROWS.count
OF_A_VERTEX: Final = VERTEX.size
QW, QX, QY, QZ = (ROWS.row(State, name) for name in ("qw", "qx", "qy", "qz"))
TICK, LAST_UPRIGHT = ROWS.row(State, "tick"), ROWS.row(Peaks, "last_upright")
SAMPLE, UPRIGHT_UNTIL, DUE = (ROWS.row(Course, name) for name in ("sample", "upright_until", "due"))


def loops_of(kind: Any) -> Any:
    """The loops of bodies with a mark; for compiled code, by its type."""
    return LOOPS[type(kind)]


@overload(loops_of, strict=False)
def _loops_of(kind: Any) -> Any:
    advance_sample = LOOPS[kind.instance_class]
    return lambda kind: advance_sample  # noqa: ARG005, Numba wants the same arguments


def workspace(rules: Any) -> Any:
    """Rows of all lanes, and of as many vertices as the bodies have."""
    state = aligned(NUMBERS * COLUMNS + rules.points.shape[1] * OF_A_VERTEX)
    return Work(state, state[NUMBERS * COLUMNS :])


def start(rules: Any, work: Any, lane: int, case: int) -> int:
    """Put a case into a lane, at the place and with the velocities of its table."""
    given = rules.cases[case]
    ticks, body = 1.0 * TICKS * rules.at_once, rules.bodies[given.body]
    points, interval = rules.points[given.body], rules.ground.interval
    put(work.state, work.vertices, lane, given, body, points, interval, ticks)
    return int(rules.results[case].steps)


@njit(**INNER)
def put(state: Any, vertices: Any, j: int, case: Any, of: Any, points: Any, interval: float, ticks: float) -> None:
    """Put a case into lane j; `ticks` is their number in a sample."""
    for row in range(NUMBERS):
        state[row * COLUMNS + j] = 0.0
    ks, at = case.tangential, case.start
    body = Body(
        of.ixx, of.iyy, of.izz, of.ixy, of.ixz, of.iyz, of.axx, of.ayy, of.azz, of.axy, of.axz, of.ayz, of.foot, of.radius,
        case.stiffness, ks, 1.0 / ks if ks > 0.0 else 0.0, case.dashpot, case.friction, of.critical, of.ends, interval / ticks,
    )  # fmt: skip
    f = frame_of(at.qw, at.qx, at.qy, at.qz)
    lx, ly, lz = momentum_of(body, f, at.wx, at.wy, at.wz)
    # What gravity and the springs do at the start.
    az, mx, my = -GRAVITY, 0.0, 0.0
    for i in range(points.shape[0]):
        one, p = vertices[i * OF_A_VERTEX : (i + 1) * OF_A_VERTEX], points[i]
        arm = in_space(f, p[0], p[1], p[2])
        depth = -(at.z + arm.z)
        store_vertex(one, j, Vertex(p[0], p[1], p[2]))
        rolls = body.radius > 0.0
        # Points of a rim remember their velocity, vertices their place.
        x = at.vx + (at.wy * arm.z - at.wz * arm.y) if rolls else at.x + arm.x
        y = at.vy + (at.wz * arm.x - at.wx * arm.z) if rolls else at.y + arm.y
        store_memory(one, j, Memory(0.0, 0.0, x, y, depth, body.stiffness * max(depth, 0.0), 0.0))
        n = body.stiffness * max(depth, 0.0)
        az, mx, my = az + n, mx + arm.y * n, my - arm.x * n
    begin = State(
        at.x, at.y, at.z, at.qw, at.qx, at.qy, at.qz, at.vx, at.vy, at.vz, lx, ly, lz,
        at.wx, at.wy, at.wz, 0.0, 0.0, az, mx, my, 0.0, 0.0,
    )  # fmt: skip
    store_body(state, j, body)
    store_clock(state, j, Clock(case.finest, case.standing, case.dwell, case.settled))  # fmt: skip
    store_state(state, j, begin)
    store_attempt(state, j, Attempt(case.finest, case.dwell, 0.0))
    store_peaks(state, j, Peaks(lean_of(f), 0.0, 0.0, -1.0))
    barrier = GRAVITY * (np.sqrt(of.reach * of.reach + of.foot * of.foot) - of.foot)
    store_course(state, j, Course(
        case.amplitude, case.first, case.calm, case.after, case.first * interval,
        energy(body, begin, vertices, points.shape[0], j), barrier, 0.0,
    ))  # fmt: skip
    store_stance(state, j, Stance(spin_about_origin(begin), of.reach, of.fallen, of.deepest))


@njit(**INNER)
def momentum_of(body: Body, f: Any, wx: float, wy: float, wz: float) -> tuple[float, float, float]:
    """Angular momentum in space by the angular velocity there; the inertia is the inverse of its inverse, by cofactors."""
    x, y, z = (
        (f.xx * wx + f.yx * wy) + f.zx * wz,
        (f.xy * wx + f.yy * wy) + f.zy * wz,
        (f.xz * wx + f.yz * wy) + f.zz * wz,
    )
    a, b, c = (
        body.iyy * body.izz - body.iyz**2,
        body.ixz * body.iyz - body.ixy * body.izz,
        body.ixy * body.iyz - body.ixz * body.iyy,
    )
    d, e, g = (
        body.ixx * body.izz - body.ixz**2,
        body.ixy * body.ixz - body.ixx * body.iyz,
        body.ixx * body.iyy - body.ixy**2,
    )
    inverse = 1.0 / ((body.ixx * a + body.ixy * b) + body.ixz * c)
    momentum = in_space(
        f, inverse * ((a * x + b * y) + c * z), inverse * ((b * x + d * y) + e * z), inverse * ((c * x + e * y) + g * z)
    )
    return momentum.x, momentum.y, momentum.z


def load(rules: Any, work: Any, cases: Any, columns: int) -> None:
    """Begin a sample."""
    ticks, ground = 1.0 * TICKS * rules.at_once, rules.ground
    next_sample(work.state, columns, rules.row, cases, ground.along, ground.up, ticks, ground.interval)


@njit(**INNER)
def next_sample(
    state: Any, columns: int, row: Any, cases: Any, along: Any, up: Any, ticks: float, interval: float
) -> None:  # fmt: skip
    """Bring the quaternions back to length 1 and load the ground motion of the sample that each lane is in."""
    scale = 1.0 / ticks
    for j in range(columns):
        s, course, passed = load_state(state, j), load_course(state, j), state[LAST_UPRIGHT + j]
        then = (course.sample + passed * scale) * interval
        unit = 1.5 - 0.5 * ((s.qw * s.qw + s.qz * s.qz) + (s.qx * s.qx + s.qy * s.qy))
        state[QW + j], state[QX + j], state[QY + j], state[QZ + j] = s.qw * unit, s.qx * unit, s.qy * unit, s.qz * unit
        state[UPRIGHT_UNTIL + j] = then if passed >= 0.0 else course.upright_until
        state[LAST_UPRIGHT + j] = -1.0
        state[SAMPLE + j] = course.sample + 1.0 if s.tick >= ticks else course.sample
        state[TICK + j] = s.tick - ticks if s.tick >= ticks else s.tick
    last = up.shape[0] - 3
    for j in range(columns):
        course = load_course(state, j)
        i = min(int(course.sample), last)
        # A base that accelerates one way pushes the body the other way.
        push_x = piece(along[row[cases[j]], 0], i, -course.amplitude, scale)
        push_y = piece(along[row[cases[j]], 1], i, -course.amplitude, scale)
        store_shaking(state, j, Shaking(push_x, push_y, piece(up, i, course.amplitude, scale)))


def advance(rules: Any, work: Any, columns: int, path: Any, noted: int) -> tuple[Any, int]:
    """Compute the steps of a sample; the first lane is noted at its begin."""
    if path.shape[0] > 0:
        path = with_room(path, noted + 1, rules.most_rows)
        if path.shape[0] == noted:
            return path, -1
        note(work.state, 0, rules.ground.interval, 1.0 * TICKS * rules.at_once, path[noted])
        noted += 1
    step = loops_of(rules.kind)
    step(rules.kind, work.state, work.vertices, rules.points.shape[1], rules.base, columns, rules.at_once)
    return path, noted


def count_due(rules: Any, work: Any, active: int) -> int:
    """Mark lanes of which there may be something to say; the others simply go on."""
    return mark_due(work.state, active, 1.0 * TICKS * rules.at_once, float(rules.ground.samples))


@njit(**INNER)
def mark_due(state: Any, active: int, ticks: float, end: float) -> int:
    """Mark and count the lanes that have fallen, are past the samples in which something can start, or have failed."""
    scale, count = 1.0 / ticks, 0.0
    for j in range(active):
        s, course, stance = load_state(state, j), load_course(state, j), load_stance(state, j)
        total = (s.vx + s.vy + s.vz) + (s.x + s.y + s.z) + (s.qw + s.qx + s.qy + s.qz)
        sample, until = course.sample + s.tick * scale, course.calm if course.calm < end else end
        # Not finite minus not finite is never 0.
        finite = total - total == 0.0
        stands = 1.0 - 2.0 * (s.qx * s.qx + s.qy * s.qy) > stance.fallen
        goes_on = finite & stands & (sample < until) & (load_peaks(state, j).depth <= stance.deepest)
        state[DUE + j] = 0.0 if goes_on else 1.0
    for j in range(active):
        count += state[DUE + j]
    return int(count)


def is_due(rules: Any, work: Any, lane: int) -> bool:  # noqa: ARG001
    """Whether a lane is marked."""
    return bool(work.state[DUE + lane] != 0.0)


def ended(rules: Any, work: Any, lane: int, case: int) -> int:  # noqa: ARG001
    """`Status` of a lane, or that it goes on."""
    ticks, end = 1.0 * TICKS * rules.at_once, float(rules.ground.samples)
    return has_ended(work.state, work.vertices, rules.points.shape[1], rules.base, lane, ticks, end)


def finish(rules: Any, work: Any, lane: int, case: int, status: int, steps: int) -> None:
    """Write the results of a lane."""
    count = rules.points.shape[1]
    finish_body(work.state, work.vertices, count, lane, status, steps, rules.results[case])


implement(BodyRules, workspace, start, load, advance, count_due, is_due, ended, finish)
