"""Functions that the queue calls for 3-D bodies: start a case, compute a sample, skip samples, end a case.

Vertices i and i + count/2 are opposite each other. The rows of the vertices follow those of the body, `VERTEX.size`
numbers per vertex.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.body.centred_loops import sample_loops
from overturning.dem.body.ending import (
    angular_momentum_about_origin,
    body_energy,
    case_status,
    finite_check_sum,
    is_at_rest,
    record_body_motion,
    write_case_results,
)
from overturning.dem.body.state import (
    COLUMNS,
    ROWS,
    TICKS,
    VERTEX,
    BodyConstants,
    BodyPeaks,
    BodyShaking,
    BodyState,
    BodyVertex,
    LoadedSample,
    PointBeforeAndAfter,
    TerminationLimits,
    VertexHistory,
    lean_measure,
)
from overturning.dem.body.vectors import (
    Matrix,
    Quaternion,
    SymmetricMatrix,
    Vector,
    cross_product,
    full_matrix,
    matrix_times_vector,
    plus,
    rotation_matrix,
    scale_vector,
    transpose,
)
from overturning.dem.kernel.clock import Clock, StepAttempt
from overturning.dem.kernel.ending import STILL, CaseProgress, RestState, begin_sample, cannot_end_yet
from overturning.dem.kernel.ground import (
    Ground,
    below_rest_threshold,
    count_skippable_samples,
    is_rest_check_sample,
    motion_over_sample,
)
from overturning.dem.kernel.lanes import INNER, aligned_zeros
from overturning.dem.kernel.mechanics import LANDING
from overturning.dem.kernel.queue import QueueSettings, lookup_by_type, path_with_room, register_implementations
from overturning.units import STANDARD_GRAVITY as GRAVITY


class VertexBodies(NamedTuple):
    """Marker of bodies with vertices; its type selects their loops."""

    round: bool = False


class RimBodies(NamedTuple):
    """Marker of bodies with a rim; its type selects their loops."""

    round: bool = True


LOOPS: Final = {VertexBodies: sample_loops(False), RimBodies: sample_loops(True)}
"""Function that computes the steps of a sample, by the type of the marker."""


class BodyKernelInput(NamedTuple):
    """Input of the kernel for cases of 3-D bodies, all with the same numbers of steps per sample and of vertices."""

    settings: QueueSettings
    cases: NDArray[np.void]
    """Case parameters, of type `CASE`, shape (n,)."""
    row: NDArray[np.int64]
    results: NDArray[np.void]
    """Results to fill in, of type `RESULT`, shape (n,)."""
    ground: Ground
    kind: Any
    """Marker of the bodies, of a type in `LOOPS`."""
    bodies: NDArray[np.void]
    """Constants of the bodies, of type `BODY`, shape (bodies,)."""
    points: FloatArray
    """Vertices of each body from its centre, m, shape (bodies, vertices, 3)."""
    base: int
    """Number of vertices of the base."""
    sectors: FloatArray
    """Sectors of each body, see `overturning.model.solid.Solid.sectors`, shape (bodies, sectors, 5)."""


class BodyWorkspace(NamedTuple):
    """Working memory of a queue of bodies."""

    state: Any
    """Rows of the bodies, followed by those of the vertices."""
    vertices: Any
    """Rows of the vertices: a view of `state`."""


load_body, store_body, _ = ROWS.access(BodyConstants)
load_state, store_state, _ = ROWS.access(BodyState)
store_turn = ROWS.access(BodyState, "turn").store
load_peaks, store_peaks, _ = ROWS.access(BodyPeaks)
load_course, store_course, _ = ROWS.access(CaseProgress)
load_limits, store_limits, _ = ROWS.access(TerminationLimits)
store_shaking, store_attempt, store_clock = (ROWS.access(of).store for of in (BodyShaking, StepAttempt, Clock))
store_vertex, store_memory = VERTEX.access(BodyVertex).store, VERTEX.access(PointBeforeAndAfter, "old").store
NUMBERS: Final = ROWS.count
OF_A_VERTEX: Final = VERTEX.size
TICK, LAST_UPRIGHT = ROWS.row(BodyState, "tick"), ROWS.row(BodyPeaks, "last_upright")
LENGTH, LOADED = ROWS.row(StepAttempt, "length"), ROWS.row(LoadedSample, "sample")
REST_LIMIT, AT_REST = ROWS.row(RestState, "rest_limit"), ROWS.row(RestState, "at_rest")
SAMPLE, UPRIGHT_UNTIL = ROWS.row(CaseProgress, "sample"), ROWS.row(CaseProgress, "upright_until")


loops_of = lookup_by_type(LOOPS)
"""Return the loops of bodies, selected by the type of their marker."""


def allocate_workspace(inputs: Any) -> Any:
    """Allocate the state rows of all cases that are computed together, and the rows of their vertices."""
    state = aligned_zeros(NUMBERS * COLUMNS + inputs.points.shape[1] * OF_A_VERTEX)
    return BodyWorkspace(state, state[NUMBERS * COLUMNS :])


def start_case(inputs: Any, workspace: Any, lane: int, case: int) -> None:
    """Load a case into a lane, in its initial state."""
    given = inputs.cases[case]
    body, points, interval = inputs.bodies[given.body], inputs.points[given.body], inputs.settings.interval
    initialise_lane(workspace.state, workspace.vertices, lane, given, body, points, interval, inputs.settings.ticks)


@njit(**INNER)
def initialise_lane(
    state: Any, vertex_rows: Any, lane: int, case: Any, solid: Any, points: Any,
    sampling_interval: float, ticks_per_sample: float,
) -> None:  # fmt: skip
    """Load the initial state of a case into a lane."""
    for row in range(NUMBERS):
        state[row * COLUMNS + lane] = 0.0
    ks, at = case.tangential, case.start
    body = BodyConstants(
        inverse=SymmetricMatrix(solid.ixx, solid.iyy, solid.izz, solid.ixy, solid.ixz, solid.iyz),
        inertia=SymmetricMatrix(solid.axx, solid.ayy, solid.azz, solid.axy, solid.axz, solid.ayz),
        foot=solid.foot,
        radius=solid.radius,
        stiffness=case.stiffness,
        tangential=ks,
        compliance=1.0 / ks if ks > 0.0 else 0.0,
        dashpot=case.dashpot,
        friction=case.friction,
        critical=solid.critical,
        ends=solid.ends,
        step=sampling_interval / ticks_per_sample,
        landing=LANDING * case.dashpot / case.stiffness,
        tilting=0.0 if case.friction * solid.foot <= solid.reach else 1.0,
    )
    place, turn = Vector(at.x, at.y, at.z), Quaternion(at.qw, at.qx, at.qy, at.qz)
    v, w, f = Vector(at.vx, at.vy, at.vz), Vector(at.wx, at.wy, at.wz), rotation_matrix(turn)
    # Acceleration and moment from gravity and springs at the start.
    az, mx, my = -GRAVITY, 0.0, 0.0
    for i in range(points.shape[0]):
        one = vertex_rows[i * OF_A_VERTEX : (i + 1) * OF_A_VERTEX]
        own = Vector(points[i, 0], points[i, 1], points[i, 2])
        arm = matrix_times_vector(f, own)
        store_vertex(one, lane, BodyVertex(own))
        # Velocity is stored for points of a rim, position for vertices.
        known = plus(v, cross_product(w, arm)) if body.radius > 0.0 else plus(place, arm)
        depth = -(place.z + arm.z)
        n = body.stiffness * max(depth, 0.0)
        store_memory(
            one, lane, VertexHistory(sx=0.0, sy=0.0, x=known.x, y=known.y, depth=depth, normal=n, slid=0.0, landing=0.0)
        )
        az, mx, my = az + n, mx + arm.y * n, my - arm.x * n
    momentum = angular_momentum(body.inverse, f, w)
    begin = BodyState(
        place=place,
        turn=turn,
        velocity=v,
        momentum=momentum,
        spin=w,
        acceleration=Vector(0.0, 0.0, az),
        moment=Vector(mx, my, 0.0),
        tick=0.0,
    )
    store_body(state, lane, body)
    store_clock(state, lane, Clock(case.finest, case.standing, case.dwell, case.settled))  # fmt: skip
    store_state(state, lane, begin)
    store_attempt(state, lane, StepAttempt(case.finest, case.dwell, 0.0))
    store_peaks(state, lane, BodyPeaks(lean_measure(f), 0.0, 0.0, -1.0))
    barrier = GRAVITY * (np.sqrt(solid.reach * solid.reach + solid.foot * solid.foot) - solid.foot)
    store_course(state, lane, CaseProgress(
        case.amplitude, case.first, case.calm, case.after, case.first * sampling_interval,
        body_energy(body, begin, vertex_rows, points.shape[0], lane), barrier,
    ))  # fmt: skip
    state[REST_LIMIT + lane] = case.rest_limit
    store_limits(state, lane, TerminationLimits(
        angular_momentum_about_origin(begin), solid.reach, solid.fallen, solid.deepest, case.steady
    ))  # fmt: skip


@njit(**INNER)
def angular_momentum(a: SymmetricMatrix, f: Matrix, w: Vector) -> Vector:
    """Return the angular momentum of a body in space; `a` is its inverse inertia, `f` its axes, `w` its rate."""
    cofactors = SymmetricMatrix(
        a.yy * a.zz - a.yz**2, a.xx * a.zz - a.xz**2, a.xx * a.yy - a.xy**2,
        a.xz * a.yz - a.xy * a.zz, a.xy * a.yz - a.xz * a.yy, a.xy * a.xz - a.xx * a.yz,
    )  # fmt: skip
    inverse = 1.0 / ((a.xx * cofactors.xx + a.xy * cofactors.xy) + a.xz * cofactors.xz)
    return matrix_times_vector(
        f, scale_vector(inverse, matrix_times_vector(full_matrix(cofactors), matrix_times_vector(transpose(f), w)))
    )


def load_sample_motion(inputs: Any, workspace: Any, cases: Any, lane_count: int) -> None:
    """Begin a sample: normalise the rotations and load the base motion."""
    load_next_sample(workspace.state, lane_count, inputs.row, cases, inputs.ground, inputs.settings)


@njit(**INNER)
def load_next_sample(
    state: Any, lane_count: int, motion_rows: Any, cases: Any, ground: Any, settings: QueueSettings
) -> None:
    """Scale the quaternions to length 1, and load the base motion of the current sample of each lane."""
    along, up, ticks, interval, scale = ground.along, ground.up, settings.ticks, settings.interval, 1.0 / settings.ticks
    for j in range(lane_count):
        s = load_state(state, j)
        q = s.turn
        unit = 1.5 - 0.5 * ((q.w * q.w + q.z * q.z) + (q.x * q.x + q.y * q.y))
        store_turn(state, j, Quaternion(q.w * unit, q.x * unit, q.y * unit, q.z * unit))
        begun = begin_sample(load_course(state, j), s.tick, state[LAST_UPRIGHT + j], ticks, interval)
        state[SAMPLE + j], state[TICK + j], state[UPRIGHT_UNTIL + j] = begun
        state[LAST_UPRIGHT + j] = -1.0
    last = up.shape[0] - 3
    for j in range(lane_count):
        course = load_course(state, j)
        if state[LOADED + j] == course.sample + 1.0:
            continue
        state[LOADED + j] = course.sample + 1.0
        i = min(int(course.sample), last)
        # A base that accelerates one way pushes the body the other way.
        push_x = motion_over_sample(along[motion_rows[cases[j]], 0], i, -course.amplitude, scale)
        push_y = motion_over_sample(along[motion_rows[cases[j]], 1], i, -course.amplitude, scale)
        store_shaking(state, j, BodyShaking(push_x, push_y, motion_over_sample(up, i, course.amplitude, scale)))


def advance_one_sample(inputs: Any, workspace: Any, lane_count: int, path: Any, recorded_rows: int) -> tuple[Any, int]:
    """Compute the steps of a sample; record the first lane at its start, if time has passed since the last row."""
    # Unpack the input before the branch: otherwise Numba increments the reference count of every array once per sample.
    settings, kind, count, base = inputs.settings, inputs.kind, inputs.points.shape[1], inputs.base
    if path.shape[0] > 0:
        path = path_with_room(path, recorded_rows + 1, settings.max_rows)
        if path.shape[0] == recorded_rows:
            return path, -1
        record_body_motion(workspace.state, 0, settings.interval, settings.ticks, path[recorded_rows])
        recorded_rows += 1 if recorded_rows == 0 or path[recorded_rows].time > path[recorded_rows - 1].time else 0
    loops_of(kind)(
        kind, workspace.state, workspace.vertices, count, base, lane_count, settings.steps_per_check, settings.ticks
    )
    return path, recorded_rows


def mark_ending_lanes(inputs: Any, workspace: Any, active_count: int, marks: Any) -> int:
    """Mark the lanes whose case may have ended, and count them."""
    return mark_possibly_ended(
        workspace.state, active_count, marks, inputs.settings.ticks, float(inputs.settings.samples)
    )


@njit(**INNER)
def mark_possibly_ended(state: Any, active_count: int, marks: Any, ticks_per_sample: float, last_sample: float) -> int:
    """Mark and count lanes that fell, failed, or are past the samples in which the motion can move their body."""
    count = 0.0
    for j in range(active_count):
        s, limits = load_state(state, j), load_limits(state, j)
        sound = (rotation_matrix(s.turn).zz > limits.fallen) & (load_peaks(state, j).depth <= limits.deepest)
        marks[j] = (
            0.0
            if cannot_end_yet(load_course(state, j), s.tick, ticks_per_sample, last_sample, finite_check_sum(s), sound)
            else 1.0
        )
    for j in range(active_count):
        count += marks[j]
    return int(count)


@njit(**INNER)
def mark_possibly_at_rest(state: Any, active_count: int) -> int:
    """Mark and count lanes whose body may be at rest: a quick test that every body at rest passes."""
    number = 0
    for j in range(active_count):
        s, length, least = load_state(state, j), state[LENGTH + j], STILL * state[REST_LIMIT + j] * GRAVITY
        v, a, most = s.velocity, s.acceleration, 1.001 * least
        still = (abs(a.x) < most) & (abs(a.y) < most) & (abs(a.z) < most)
        slow = 2.0 * abs(v.z) < most * (load_body(state, j).step * length)
        may = (length >= TICKS) & still & slow
        state[AT_REST + j] = 1.0 if may else 0.0
        number += 1 if may else 0
    return number


def skip_quiet_samples(inputs: Any, workspace: Any, cases: Any, active_count: int, skipped_samples: Any) -> None:
    """Skip, for bodies at rest, the samples in which the motion cannot move them."""
    settings, state, ground, row, base = inputs.settings, workspace.state, inputs.ground, inputs.row, inputs.base
    count = inputs.points.shape[1]
    if mark_possibly_at_rest(state, active_count) == 0:
        return
    for j in range(active_count):
        course, over = load_course(state, j), state[TICK + j] * (1.0 / settings.ticks)
        rest_limit = state[REST_LIMIT + j]
        now = course.sample + over
        # Test the motion first: testing the body takes longer.
        quiet = state[AT_REST + j] > 0.0 and is_rest_check_sample(now)
        quiet = quiet and below_rest_threshold(ground, row[cases[j]], now, course.amplitude, rest_limit)
        if quiet and is_at_rest(state, workspace.vertices, count, base, j, rest_limit):
            samples = count_skippable_samples(ground, row[cases[j]], now, course.amplitude, rest_limit)
            state[SAMPLE + j] += samples
            skipped_samples[j] += samples


def lane_end_status(inputs: Any, workspace: Any, lane: int, case: int) -> int:
    """Return the `Status` of the case in a lane, or `GOES_ON` if it has not ended."""
    end, sectors = float(inputs.settings.samples), inputs.sectors[inputs.cases[case].body]
    return case_status(workspace.state, workspace.vertices, inputs.base, lane, inputs.settings.ticks, end, sectors)


def write_lane_results(inputs: Any, workspace: Any, lane: int, case: int, status: int) -> None:
    """Write the results of the case in a lane."""
    sectors = inputs.sectors[inputs.cases[case].body]
    write_case_results(workspace.state, workspace.vertices, lane, status, inputs.results[case], sectors)


register_implementations(
    BodyKernelInput, allocate_workspace, start_case, load_sample_motion, advance_one_sample, mark_ending_lanes,
    skip_quiet_samples, lane_end_status, write_lane_results,
)  # fmt: skip
