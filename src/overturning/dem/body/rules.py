"""What the queue asks of a body in space: its rules, how a case begins, how a sample goes, how a case ends.

Vertices i and i + count/2 stand opposite each other; the rows of vertex i lie behind those of the body, `VERTEX.size`
numbers for each.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.body.centred_loops import loops
from overturning.dem.body.ending import energy, finish_body, has_ended, note, rests, spin_about_origin, total_of
from overturning.dem.body.state import (
    COLUMNS,
    ROWS,
    TICKS,
    VERTEX,
    Body,
    Loaded,
    Memory,
    Peaks,
    Point,
    Shaking,
    Stance,
    State,
    Vertex,
    lean_of,
)
from overturning.dem.body.vectors import (
    Matrix,
    Quaternion,
    Symmetric,
    Vector,
    apply,
    cross,
    frame_of,
    full,
    plus,
    scaled,
    transposed,
)
from overturning.dem.kernel.clock import Attempt, Clock
from overturning.dem.kernel.ending import STILL, CaseProgress, RestState, begin_sample, cannot_end_yet
from overturning.dem.kernel.ground import Ground, below_rest_threshold, is_rest_check_sample, piece, samples_at_rest
from overturning.dem.kernel.lanes import INNER, aligned
from overturning.dem.kernel.mechanics import LANDING
from overturning.dem.kernel.queue import Job, by_type, implement, with_room
from overturning.units import STANDARD_GRAVITY as GRAVITY


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

    job: Job
    cases: NDArray[np.void]
    """Table of `CASE`;"""
    row: NDArray[np.int64]
    results: NDArray[np.void]
    """table of `RESULT`;"""
    ground: Ground
    kind: Any
    """mark of the bodies, of a type in `LOOPS`;"""
    bodies: NDArray[np.void]
    """table of bodies, of `BODY`;"""
    points: FloatArray
    """vertices of each body from its centre, m, shape (bodies, vertices, 3);"""
    base: int
    """how many of them a body rests on;"""
    sectors: FloatArray
    """of each body `overturning.model.solid.Solid.sectors`, shape (bodies, sectors, 5)."""


class Work(NamedTuple):
    """What bodies are computed in."""

    state: Any
    """All rows, those of"""
    vertices: Any
    """the vertices behind those of the body."""


load_body, store_body, _ = ROWS.access(Body)
load_state, store_state, _ = ROWS.access(State)
store_turn = ROWS.access(State, "turn").store
load_peaks, store_peaks, _ = ROWS.access(Peaks)
load_course, store_course, _ = ROWS.access(CaseProgress)
load_stance, store_stance, _ = ROWS.access(Stance)
store_shaking, store_attempt, store_clock = (ROWS.access(of).store for of in (Shaking, Attempt, Clock))
store_vertex, store_memory = VERTEX.access(Vertex).store, VERTEX.access(Point, "old").store
NUMBERS: Final = ROWS.count
OF_A_VERTEX: Final = VERTEX.size
TICK, LAST_UPRIGHT = ROWS.row(State, "tick"), ROWS.row(Peaks, "last_upright")
LENGTH, LOADED = ROWS.row(Attempt, "length"), ROWS.row(Loaded, "sample")
BEARS, FOUND = ROWS.row(RestState, "bears"), ROWS.row(RestState, "found")
SAMPLE, UPRIGHT_UNTIL = ROWS.row(CaseProgress, "sample"), ROWS.row(CaseProgress, "upright_until")


loops_of = by_type(LOOPS)
"""The loops of bodies, by the type of their mark."""


def workspace(rules: Any) -> Any:
    """Rows of all lanes, and of as many vertices as the bodies have."""
    state = aligned(NUMBERS * COLUMNS + rules.points.shape[1] * OF_A_VERTEX)
    return Work(state, state[NUMBERS * COLUMNS :])


def start(rules: Any, work: Any, lane: int, case: int) -> None:
    """Put a case into a lane, at the place and with the velocities of its table."""
    given = rules.cases[case]
    body, points, interval = rules.bodies[given.body], rules.points[given.body], rules.job.interval
    put(work.state, work.vertices, lane, given, body, points, interval, rules.job.ticks)


@njit(**INNER)
def put(state: Any, vertices: Any, j: int, case: Any, of: Any, points: Any, interval: float, ticks: float) -> None:
    """Put a case into lane j; `ticks` is their number in a sample."""
    for row in range(NUMBERS):
        state[row * COLUMNS + j] = 0.0
    ks, at = case.tangential, case.start
    body = Body(
        inverse=Symmetric(of.ixx, of.iyy, of.izz, of.ixy, of.ixz, of.iyz),
        inertia=Symmetric(of.axx, of.ayy, of.azz, of.axy, of.axz, of.ayz),
        foot=of.foot,
        radius=of.radius,
        stiffness=case.stiffness,
        tangential=ks,
        compliance=1.0 / ks if ks > 0.0 else 0.0,
        dashpot=case.dashpot,
        friction=case.friction,
        critical=of.critical,
        ends=of.ends,
        step=interval / ticks,
        landing=LANDING * case.dashpot / case.stiffness,
    )
    place, turn = Vector(at.x, at.y, at.z), Quaternion(at.qw, at.qx, at.qy, at.qz)
    v, w, f = Vector(at.vx, at.vy, at.vz), Vector(at.wx, at.wy, at.wz), frame_of(turn)
    # What gravity and the springs do at the start.
    az, mx, my = -GRAVITY, 0.0, 0.0
    for i in range(points.shape[0]):
        one, own = vertices[i * OF_A_VERTEX : (i + 1) * OF_A_VERTEX], Vector(points[i, 0], points[i, 1], points[i, 2])
        arm = apply(f, own)
        store_vertex(one, j, Vertex(own))
        # Points of a rim remember their velocity, vertices their place.
        known = plus(v, cross(w, arm)) if body.radius > 0.0 else plus(place, arm)
        depth = -(place.z + arm.z)
        n = body.stiffness * max(depth, 0.0)
        store_memory(one, j, Memory(sx=0.0, sy=0.0, x=known.x, y=known.y, depth=depth, normal=n, slid=0.0, landing=0.0))
        az, mx, my = az + n, mx + arm.y * n, my - arm.x * n
    momentum = momentum_of(body.inverse, f, w)
    begin = State(
        place=place,
        turn=turn,
        velocity=v,
        momentum=momentum,
        spin=w,
        acceleration=Vector(0.0, 0.0, az),
        moment=Vector(mx, my, 0.0),
        tick=0.0,
    )
    store_body(state, j, body)
    store_clock(state, j, Clock(case.finest, case.standing, case.dwell, case.settled))  # fmt: skip
    store_state(state, j, begin)
    store_attempt(state, j, Attempt(case.finest, case.dwell, 0.0))
    store_peaks(state, j, Peaks(lean_of(f), 0.0, 0.0, -1.0))
    barrier = GRAVITY * (np.sqrt(of.reach * of.reach + of.foot * of.foot) - of.foot)
    store_course(state, j, CaseProgress(
        case.amplitude, case.first, case.calm, case.after, case.first * interval,
        energy(body, begin, vertices, points.shape[0], j), barrier,
    ))  # fmt: skip
    state[BEARS + j] = case.bears
    store_stance(state, j, Stance(spin_about_origin(begin), of.reach, of.fallen, of.deepest, case.steady))


@njit(**INNER)
def momentum_of(a: Symmetric, f: Matrix, w: Vector) -> Vector:
    """Angular momentum in space by the angular velocity there; the inertia is that of the inverse a, by cofactors."""
    cofactors = Symmetric(
        a.yy * a.zz - a.yz**2, a.xx * a.zz - a.xz**2, a.xx * a.yy - a.xy**2,
        a.xz * a.yz - a.xy * a.zz, a.xy * a.yz - a.xz * a.yy, a.xy * a.xz - a.xx * a.yz,
    )  # fmt: skip
    inverse = 1.0 / ((a.xx * cofactors.xx + a.xy * cofactors.xy) + a.xz * cofactors.xz)
    return apply(f, scaled(inverse, apply(full(cofactors), apply(transposed(f), w))))


def load(rules: Any, work: Any, cases: Any, columns: int) -> None:
    """Begin a sample."""
    next_sample(work.state, columns, rules.row, cases, rules.ground, rules.job)


@njit(**INNER)
def next_sample(state: Any, columns: int, row: Any, cases: Any, ground: Any, job: Job) -> None:
    """Bring the quaternions back to length 1 and load the ground motion of the sample that each lane is in."""
    along, up, ticks, interval, scale = ground.along, ground.up, job.ticks, job.interval, 1.0 / job.ticks
    for j in range(columns):
        s = load_state(state, j)
        q = s.turn
        unit = 1.5 - 0.5 * ((q.w * q.w + q.z * q.z) + (q.x * q.x + q.y * q.y))
        store_turn(state, j, Quaternion(q.w * unit, q.x * unit, q.y * unit, q.z * unit))
        begun = begin_sample(load_course(state, j), s.tick, state[LAST_UPRIGHT + j], ticks, interval)
        state[SAMPLE + j], state[TICK + j], state[UPRIGHT_UNTIL + j] = begun
        state[LAST_UPRIGHT + j] = -1.0
    last = up.shape[0] - 3
    for j in range(columns):
        course = load_course(state, j)
        if state[LOADED + j] == course.sample + 1.0:
            continue
        state[LOADED + j] = course.sample + 1.0
        i = min(int(course.sample), last)
        # A base that accelerates one way pushes the body the other way.
        push_x = piece(along[row[cases[j]], 0], i, -course.amplitude, scale)
        push_y = piece(along[row[cases[j]], 1], i, -course.amplitude, scale)
        store_shaking(state, j, Shaking(push_x, push_y, piece(up, i, course.amplitude, scale)))


def advance(rules: Any, work: Any, columns: int, path: Any, noted: int) -> tuple[Any, int]:
    """Compute the steps of a sample; the first lane is noted at its begin, where time has passed since the last row."""
    # All at once, for `rules` kept beyond a branch would count a use of each of its arrays, for every sample.
    job, kind, count, base = rules.job, rules.kind, rules.points.shape[1], rules.base
    if path.shape[0] > 0:
        path = with_room(path, noted + 1, job.most_rows)
        if path.shape[0] == noted:
            return path, -1
        note(work.state, 0, job.interval, job.ticks, path[noted])
        noted += 1 if noted == 0 or path[noted].time > path[noted - 1].time else 0
    loops_of(kind)(kind, work.state, work.vertices, count, base, columns, job.at_once, job.ticks)
    return path, noted


def count_due(rules: Any, work: Any, active: int, due: Any) -> int:
    """Mark lanes of which there may be something to say; the others simply go on."""
    return mark_due(work.state, active, due, rules.job.ticks, float(rules.job.samples))


@njit(**INNER)
def mark_due(state: Any, active: int, due: Any, ticks: float, end: float) -> int:
    """Mark and count the lanes that have fallen, are past the samples in which something can start, or have failed."""
    count = 0.0
    for j in range(active):
        s, stance = load_state(state, j), load_stance(state, j)
        sound = (frame_of(s.turn).zz > stance.fallen) & (load_peaks(state, j).depth <= stance.deepest)
        due[j] = 0.0 if cannot_end_yet(load_course(state, j), s.tick, ticks, end, total_of(s), sound) else 1.0
    for j in range(active):
        count += due[j]
    return int(count)


@njit(**INNER)
def find_slow(state: Any, active: int) -> int:
    """Mark and count lanes that may be at rest: a quick test, for all lanes at once, that none of these fails."""
    number = 0
    for j in range(active):
        s, length, least = load_state(state, j), state[LENGTH + j], STILL * state[BEARS + j] * GRAVITY
        v, a, most = s.velocity, s.acceleration, 1.001 * least
        still = (abs(a.x) < most) & (abs(a.y) < most) & (abs(a.z) < most)
        slow = 2.0 * abs(v.z) < most * (load_body(state, j).step * length)
        may = (length >= TICKS) & still & slow
        state[FOUND + j] = 1.0 if may else 0.0
        number += 1 if may else 0
    return number


def leave_out(rules: Any, work: Any, cases: Any, active: int, left_out: Any) -> None:
    """Leave out samples of lanes at rest."""
    job, state, ground, row, base = rules.job, work.state, rules.ground, rules.row, rules.base
    count = rules.points.shape[1]
    if find_slow(state, active) == 0:
        return
    for j in range(active):
        course, over, bears = load_course(state, j), state[TICK + j] * (1.0 / job.ticks), state[BEARS + j]
        now = course.sample + over
        # The shaking first, then the body, which takes longer to look at.
        quiet = state[FOUND + j] > 0.0 and is_rest_check_sample(now)
        quiet = quiet and below_rest_threshold(ground, row[cases[j]], now, course.amplitude, bears)
        if quiet and rests(state, work.vertices, count, base, j, bears):
            samples = samples_at_rest(ground, row[cases[j]], now, course.amplitude, bears)
            state[SAMPLE + j] += samples
            left_out[j] += samples


def ended(rules: Any, work: Any, lane: int, case: int) -> int:
    """`Status` of a lane, or that it goes on."""
    end, sectors = float(rules.job.samples), rules.sectors[rules.cases[case].body]
    return has_ended(work.state, work.vertices, rules.base, lane, rules.job.ticks, end, sectors)


def finish(rules: Any, work: Any, lane: int, case: int, status: int) -> None:
    """Write the results of a lane."""
    sectors = rules.sectors[rules.cases[case].body]
    finish_body(work.state, work.vertices, lane, status, rules.results[case], sectors)


implement(BodyRules, workspace, start, load, advance, count_due, leave_out, ended, finish)
