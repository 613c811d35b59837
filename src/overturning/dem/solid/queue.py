"""Bodies in space side by side on moving bases: a queue of cases; a finished column takes the next one.

As in the plane (`overturning.dem.block.queue`), with a second array for the vertices. Vertex i of column j is at
``vertices[i * VERTEX.size + row + j]``; vertices i and i + count/2 stand opposite each other.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit
from numba.extending import overload

from overturning.arrays import FloatArray
from overturning.dem.cache import keep_compiled
from overturning.dem.lanes import INNER, OPTIONS, aligned
from overturning.dem.single_body import Course, Ground, Schemes, maker, piece, with_room
from overturning.dem.solid import centred, centred_loops, cundall, tables
from overturning.dem.solid.centred_rows import Attempt
from overturning.dem.solid.rows import (
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
from overturning.dem.solid.verdict import GOES_ON, energy, finish, note, spin_about_origin, verdict
from overturning.dem.status import Status
from overturning.dem.time_step import Scheme

SCHEMES: Final[Schemes] = {
    Scheme.CUNDALL: (cundall.Cundall(), cundall.loops),
    Scheme.CENTRED: (centred.Centred(), centred_loops.loops),
}
"""The type of what the kernel is told picks the loops."""


class Bodies(NamedTuple):
    """The bodies that cases refer to; all have as many vertices, and stand on as many."""

    table: FloatArray
    """Constants, shape (bodies, BODY);"""
    points: FloatArray
    """vertices from the centre, m, shape (bodies, vertices, 3);"""
    base: int
    """how many of them a body rests on;"""
    round: bool
    """whether it stands on a rim."""


class Limits(NamedTuple):
    """What bounds every case."""

    gravity: float
    """m/s²;"""
    budget: int
    """largest number of block steps of one case."""


class Vertices(NamedTuple):
    """Marks bodies with vertices."""

    round: bool = False


class Rim(NamedTuple):
    """Marks bodies with a rim."""

    round: bool = True


load_body, store_body, _ = ROWS.access(Body)
load_state, store_state, _ = ROWS.access(State)
load_peaks, store_peaks, _ = ROWS.access(Peaks)
load_course, store_course, _ = ROWS.access(Course)
load_stance, store_stance, _ = ROWS.access(Stance)
store_shaking, store_attempt = ROWS.access(Shaking).store, ROWS.access(Attempt).store
store_vertex, store_memory = VERTEX.access(Vertex).store, VERTEX.access(Point, "old").store
NUMBERS: Final = ROWS.count
OF_A_VERTEX: Final = VERTEX.size
NUMBERS_OF_A_VERTEX: Final = VERTEX.count
QW, QX, QY, QZ = (ROWS.row(State, name) for name in ("qw", "qx", "qy", "qz"))
TICK, LAST_UPRIGHT = ROWS.row(State, "tick"), ROWS.row(Peaks, "last_upright")
SAMPLE, UPRIGHT_UNTIL, LOOK = (ROWS.row(Course, name) for name in ("sample", "upright_until", "look"))


@njit(**INNER)
def start(
    state: Any, vertices: Any, j: int, lag: float, case: Any, constants: Any, points: Any, interval: float, ticks: float,
    gravity: float,
) -> None:  # fmt: skip
    """Put a case into column j, at the place and with the velocities of its table."""
    for row in range(NUMBERS):
        state[row * COLUMNS + j] = 0.0
    ks, own = case[tables.P_TANGENTIAL], constants[tables.B_INERTIA :]
    body = Body(
        constants[tables.B_IXX], constants[tables.B_IYY], constants[tables.B_IZZ], constants[tables.B_IXY],
        constants[tables.B_IXZ], constants[tables.B_IYZ], own[0], own[1], own[2], own[3], own[4], own[5], constants[tables.B_FOOT], constants[tables.B_RADIUS],
        case[tables.P_STIFFNESS], ks, 1.0 / ks if ks > 0.0 else 0.0, case[tables.P_DASHPOT], case[tables.P_FRICTION],
        constants[tables.B_CRITICAL], constants[tables.B_ENDS], interval / ticks, case[tables.P_FINEST], case[tables.P_DWELL],
    )  # fmt: skip
    at = case[tables.P_START :]
    f = frame_of(at[3], at[4], at[5], at[6])
    lx, ly, lz = momentum_of(body, f, at[10], at[11], at[12])
    # What gravity and the springs do at the start, by which momenta that lag behind are what they are half a step before.
    az, mx, my = -gravity, 0.0, 0.0
    for i in range(points.shape[0]):
        one, p = vertices[i * OF_A_VERTEX : (i + 1) * OF_A_VERTEX], points[i]
        arm = in_space(f, p[0], p[1], p[2])
        depth = -(at[2] + arm.z)
        store_vertex(one, j, Vertex(p[0], p[1], p[2]))
        rolls = body.radius > 0.0
        # Points of a rim remember their velocity, vertices their place.
        x = at[7] + (at[11] * arm.z - at[12] * arm.y) if rolls else at[0] + arm.x
        y = at[8] + (at[12] * arm.x - at[10] * arm.z) if rolls else at[1] + arm.y
        store_memory(one, j, Memory(0.0, 0.0, x, y, depth, body.stiffness * max(depth, 0.0), 0.0))
        n = body.stiffness * max(depth, 0.0)
        az, mx, my = az + n, mx + arm.y * n, my - arm.x * n
    back = lag * TICKS * body.step
    begin = State(
        at[0], at[1], at[2], at[3], at[4], at[5], at[6], at[7], at[8], at[9] - back * az, lx - back * mx, ly - back * my, lz,
        at[10], at[11], at[12], 0.0, 0.0, az, mx, my, 0.0, 0.0,
    )  # fmt: skip
    store_body(state, j, body)
    store_state(state, j, begin)
    store_attempt(state, j, Attempt(body.finest, body.dwell, 0.0, 0.0))
    store_peaks(state, j, Peaks(lean_of(f), 0.0, 0.0, -1.0))
    first, foot, reach = case[tables.P_FIRST], body.foot, constants[tables.B_REACH]
    store_course(state, j, Course(
        case[tables.P_AMPLITUDE], first, case[tables.P_CALM], case[tables.P_AFTER], first * interval,
        energy(body, begin, vertices, points.shape[0], j, lag, gravity), gravity * (np.sqrt(reach * reach + foot * foot) - foot), 0.0,
    ))  # fmt: skip
    store_stance(state, j, Stance(spin_about_origin(begin), reach, constants[tables.B_FALLEN]))


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


@njit(**INNER)
def next_sample(state: Any, columns: int, row: Any, along: Any, up: Any, ticks: float, interval: float) -> None:
    """Bring the quaternions back to length 1 and load the ground motion of the sample that each column is in."""
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
        push_x = piece(along[row[j], 0], i, -course.amplitude, scale)
        push_y = piece(along[row[j], 1], i, -course.amplitude, scale)
        store_shaking(state, j, Shaking(push_x, push_y, piece(up, i, course.amplitude, scale)))


@njit(**INNER)
def look_at(
    state: Any, active: int, done: Any, steps: int, ticks: float, end: float, deepest: Any, limits: Limits
) -> int:
    """How many of the active columns there may be something to say of at the end of a sample; the others simply go on."""
    scale, count, spent = 1.0 / ticks, 0.0, 0
    for j in range(active):
        done[j] += steps
        spent += 1 if done[j] >= limits.budget else 0
    for j in range(active):
        s, course = load_state(state, j), load_course(state, j)
        total = (s.vx + s.vy + s.vz) + (s.x + s.y + s.z) + (s.qw + s.qx + s.qy + s.qz)
        sample, until = course.sample + s.tick * scale, course.calm if course.calm < end else end
        # Not finite minus not finite is never 0.
        finite = total - total == 0.0
        stands = 1.0 - 2.0 * (s.qx * s.qx + s.qy * s.qy) > load_stance(state, j).fallen
        goes_on = finite & stands & (sample < until) & (load_peaks(state, j).depth <= deepest[j])
        state[LOOK + j] = 0.0 if goes_on else 1.0
    for j in range(active):
        count += state[LOOK + j]
    return int(count) + spent


def loops_of(scheme: Any, kind: Any) -> Any:
    """The loops of a scheme for a kind of body; for compiled code, by their types."""
    return maker(SCHEMES, scheme)(kind.instance_class is Rim)


@overload(loops_of)
def _loops_of(scheme: Any, kind: Any) -> Any:
    loops = loops_of(scheme, kind)

    def chosen(scheme: Any, kind: Any) -> Any:  # noqa: ARG001, Numba wants the same arguments
        return loops

    return chosen


@njit(nogil=True, **OPTIONS)
def run_queue(
    scheme: Any, kind: Any, queue: Any, cases: Any, row_of_case: Any, bodies: Bodies, ground: Ground, steps: int,
    limits: Limits, counter: Any, path: Any, results: Any,
) -> Any:  # fmt: skip
    """Run the cases of a queue, all with the same number of steps per sample; a finished column takes the next one.

    Parameters
    ----------
    scheme, kind : NamedTuple
        What the kernel is told of the scheme, from `SCHEMES`, and `Vertices()` or `Rim()`.
    queue : ndarray of int64, shape (m,)
        Rows of `cases` to run, in this order.
    cases : ndarray, shape (n, PARAMETERS)
        The case table (`overturning.dem.solid.tables`).
    row_of_case : ndarray of int64, shape (n,)
        Row of the ground motion that shakes each case.
    bodies, ground, steps, limits : Bodies, Ground, int, Limits
        Bodies that the cases refer to, motion of the base, steps per sample, and what bounds every case.
    counter : ndarray of int64, shape (1,)
        Grows by the block steps done; for progress.
    path : ndarray, shape (rows, TRAJECTORY)
        Filled with the first column's state each `steps` steps; no rows to leave out.
    results : ndarray, shape (n, RESULTS)
        Filled in the rows of the queue; the steps found there, of runs before, count.

    Returns
    -------
    ndarray
        The rows of `path` that were filled, in a longer copy where it was too short. Where that would be longer than `MOST_PATH`
        the run ends without results but the status `GOES_ON`.
    """
    count = bodies.points.shape[1]
    state, vertices = aligned(NUMBERS * COLUMNS), aligned(count * OF_A_VERTEX)
    case, row, done = np.zeros(COLUMNS, np.int64), np.zeros(COLUMNS, np.int64), np.zeros(COLUMNS, np.int64)
    deepest = np.zeros(COLUMNS)
    ticks, end, gravity, lag = 1.0 * TICKS * steps, float(ground.samples), limits.gravity, scheme.lag
    advance = loops_of(scheme, kind)
    # Not literals: the counters would have a type of their own, and all they are handed to be compiled twice.
    none = int(np.int64(0))
    active, head, noted = none, none, none
    filled = none
    while True:
        while active < COLUMNS and (head < queue.size or filled < COLUMNS):
            # Columns that no case takes hold the first one: nothing undefined is computed beside the others.
            j = active if head < queue.size else filled
            i = queue[head if head < queue.size else 0]
            b = int(cases[i, tables.P_BODY])
            start(state, vertices, j, lag, cases[i], bodies.table[b], bodies.points[b], ground.interval, ticks, gravity)
            case[j], row[j], deepest[j] = i, row_of_case[i], bodies.table[b, tables.B_DEEPEST]
            done[j] = int(results[i, tables.R_STEPS])
            filled = max(filled, j + 1)
            if head < queue.size:
                active, head = active + 1, head + 1
        if active == 0:
            return path[:noted]
        columns = (active + 7) // 8 * 8
        next_sample(state, columns, row, ground.along, ground.up, ticks, ground.interval)
        if path.shape[0] > 0:
            path = with_room(path, noted)
            if noted == path.shape[0]:
                results[case[0], tables.R_STATUS] = GOES_ON
                return path
            note(state, 0, lag, ground.interval, ticks, path[noted])
            noted += 1
        advance(kind, state, vertices, count, bodies.base, columns, steps, gravity)
        counter[0] += active * steps
        j = none if look_at(state, active, done, steps, ticks, end, deepest, limits) > 0 else active
        while j < active:
            ended, spent = GOES_ON, done[j] >= limits.budget
            if state[LOOK + j] != 0.0 or spent:
                ended = verdict(state, vertices, count, bodies.base, j, lag, ticks, end, gravity, deepest[j])
                ended = Status.OVER_BUDGET if spent and ended == GOES_ON else ended
            if ended == GOES_ON:
                j += 1
                continue
            finish(state, vertices, count, j, ended, lag, done[j], gravity, results[case[j]])
            # The last column moves into the free place.
            active -= 1
            case[j], row[j], done[j], deepest[j] = case[active], row[active], done[active], deepest[active]
            for r in range(NUMBERS):
                state[r * COLUMNS + j] = state[r * COLUMNS + active]
            for r in range(count * NUMBERS_OF_A_VERTEX):
                vertices[r * COLUMNS + j] = vertices[r * COLUMNS + active]


keep_compiled(run_queue)
