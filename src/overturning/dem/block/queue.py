"""Blocks side by side on one moving base: a queue of cases; a finished column takes the next one.

The mechanics, the schemes and the order of the operations are derived in docs/method.md; `overturning.dem.block.rows` says what
is known of a block. A scheme is one file with a named tuple and a function `loops`, and one row of `SCHEMES`. What matters for
speed and for equal bits:

- the loops over the columns have no branches, only selections, and no libm; fast-math and contraction are off;
- left and right corner are summed as one pair, which makes the mirrored case exact;
- a column never sees another one: what it computes depends on its case alone.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit, types
from numba.extending import overload

from overturning.dem.block import centred, cundall, tables
from overturning.dem.block.rows import (
    COLUMNS,
    ROWS,
    TICKS,
    Attempt,
    Block,
    Corner,
    Peaks,
    Shaking,
    State,
    arm_of,
)
from overturning.dem.block.verdict import GOES_ON, energy, finish, note, verdict
from overturning.dem.cache import keep_compiled
from overturning.dem.lanes import OPTIONS, aligned
from overturning.dem.mechanics import renormalised
from overturning.dem.single_body import Course, Ground, Schemes, maker, piece, with_room
from overturning.dem.status import Status
from overturning.dem.time_step import Scheme

SCHEMES: Final[Schemes] = {
    Scheme.CUNDALL: (cundall.Cundall(), cundall.loops),
    Scheme.CENTRED: (centred.Centred(), centred.loops),
}
"""The type of what the kernel is told picks the loops."""


class Limits(NamedTuple):
    """What bounds every case."""

    gravity: float
    """m/s²;"""
    deepest: float
    """penetration, as a fraction of the smaller half side, beyond which a case has failed;"""
    budget: int
    """largest number of block steps of one case."""


load_block, store_block, _ = ROWS.access(Block)
load_state, store_state, _ = ROWS.access(State)
load_peaks, store_peaks, _ = ROWS.access(Peaks)
load_course, store_course, _ = ROWS.access(Course)
store_attempt, store_push, store_lift = (
    ROWS.access(Attempt).store, ROWS.access(Shaking, "push").store, ROWS.access(Shaking, "lift").store
)  # fmt: skip
NUMBERS: Final = ROWS.count
COS, SIN, TICK, LAST_UPRIGHT = (
    ROWS.row(State, "cos"), ROWS.row(State, "sin"), ROWS.row(State, "tick"), ROWS.row(Peaks, "last_upright")
)  # fmt: skip
SAMPLE, UPRIGHT_UNTIL, LOOK = (ROWS.row(Course, name) for name in ("sample", "upright_until", "look"))


@njit(**OPTIONS)
def start(state: Any, j: int, case: Any, friction: float, interval: float, ticks: float, gravity: float) -> None:
    """Put a case into column j: at static equilibrium on both corners, or tilted on one."""
    for row in range(NUMBERS):
        state[row * COLUMNS + j] = 0.0
    b, h = 0.5 * case[tables.P_WIDTH], 0.5 * case[tables.P_HEIGHT]
    k, ks = case[tables.P_STIFFNESS], case[tables.P_TANGENTIAL]
    c, s = case[tables.P_TILT_COS], case[tables.P_TILT_SIN]
    inertia = 3.0 / (b * b + h * h)
    block = Block(
        b, h, inertia, k, ks, 1.0 / ks if ks > 0.0 else 0.0, case[tables.P_DASHPOT], friction, case[tables.P_ALPHA], interval / ticks,
        case[tables.P_FINEST], case[tables.P_DWELL], case[tables.P_SETTLED], case[tables.P_GENTLE], case[tables.P_STANDING],
    )  # fmt: skip
    tilted = s != 0.0
    z = (b * abs(s) + h * c) - (gravity / k if tilted else 0.5 * gravity / k)
    x = b * ((1.0 - c) if s > 0.0 else (c - 1.0)) + h * s if tilted else 0.0
    (arm_l, drop_l), (arm_r, drop_r) = arm_of(-1.0, block, c, s), arm_of(1.0, block, c, s)
    left, right = Corner(0.0, x + arm_l, drop_l - z, 0.0), Corner(0.0, x + arm_r, drop_r - z, 0.0)
    ul, ur = max(left.depth, 0.0), max(right.depth, 0.0)
    az, aw = k * (ul + ur) - gravity, inertia * k * (-arm_l * ul + -arm_r * ur)
    at_rest = State(x, z, case[tables.P_TILT], c, s, 0.0, 0.0, 0.0, 0.0, az, aw, left, right, 0.0)
    store_block(state, j, block)
    store_state(state, j, at_rest)
    store_attempt(state, j, Attempt(block.finest, block.dwell, 0.0, 0.0, 0.0))
    store_peaks(state, j, Peaks(abs(case[tables.P_TILT]), 0.0, 0.0, -1.0))
    barrier = gravity * (np.sqrt(b * b + h * h) - h)
    store_course(state, j, Course(
        case[tables.P_AMPLITUDE], case[tables.P_FIRST], case[tables.P_CALM], case[tables.P_AFTER], case[tables.P_FIRST] * interval,
        energy(block, at_rest, 0.0, gravity), barrier, 0.0,
    ))  # fmt: skip


@njit(**OPTIONS)
def next_sample(state: Any, columns: int, row: Any, along: Any, up: Any, ticks: float, interval: float) -> None:
    """Bring the turning pair back to length 1 and load the ground motion of the sample that each column is in."""
    scale = 1.0 / ticks
    for j in range(columns):
        s, course, passed = load_state(state, j), load_course(state, j), state[LAST_UPRIGHT + j]
        then = (course.sample + passed * scale) * interval
        state[COS + j], state[SIN + j] = renormalised(s.cos, s.sin)
        state[UPRIGHT_UNTIL + j] = then if passed >= 0.0 else course.upright_until
        state[LAST_UPRIGHT + j] = -1.0
        over = (1.0 if s.tick >= ticks else 0.0) + (1.0 if s.tick >= 2.0 * ticks else 0.0)
        state[SAMPLE + j] = course.sample + over
        state[TICK + j] = s.tick - over * ticks
    last = along.shape[1] - 3
    for j in range(columns):
        course = load_course(state, j)
        i = min(int(course.sample), last)
        # A base that accelerates towards +s pushes the block towards −s.
        store_push(state, j, piece(along[row[j]], i, -course.amplitude, scale))
        if up is not None:
            store_lift(state, j, piece(up, i, course.amplitude, scale))


@njit(**OPTIONS)
def look_at(state: Any, active: int, done: Any, steps: int, ticks: float, end: float, limits: Limits) -> int:
    """How many of the active columns there may be something to say of at the end of a sample; the others simply go on."""
    scale, count, spent = 1.0 / ticks, 0.0, 0
    for j in range(active):
        done[j] += steps
        spent += 1 if done[j] >= limits.budget else 0
    for j in range(active):
        block, s, course = load_block(state, j), load_state(state, j), load_course(state, j)
        b, h = block.half_width, block.half_height
        sum_of_all = (s.vx + s.vz + s.vw) + (s.x + s.z + s.cos)
        sample, until = course.sample + s.tick * scale, course.calm if course.calm < end else end
        most = limits.deepest * (b if b < h else h)
        # Not finite minus not finite is never 0.
        finite = sum_of_all - sum_of_all == 0.0
        goes_on = finite & (s.cos > 0.0) & (sample < until) & (load_peaks(state, j).depth <= most)
        state[LOOK + j] = 0.0 if goes_on else 1.0
    for j in range(active):
        count += state[LOOK + j]
    return int(count) + spent


def loops_of(scheme: Any, upward: Any, friction: Any) -> Any:
    """The loops of a scheme, without what takes no part where an argument is None; for compiled code, by its types."""
    return maker(SCHEMES, scheme)(not isinstance(upward, types.NoneType), not isinstance(friction, types.NoneType))


@overload(loops_of)
def _loops_of(scheme: Any, upward: Any, friction: Any) -> Any:
    loops = loops_of(scheme, upward, friction)

    def chosen(scheme: Any, upward: Any, friction: Any) -> Any:  # noqa: ARG001, Numba wants the same arguments
        return loops

    return chosen


@njit(**OPTIONS)
def ending(state: Any, j: int, spent: bool, lag: float, ticks: float, end: float, limits: Limits) -> int:
    """`Status` of a column that may have ended or has spent its steps, or `GOES_ON`."""
    if state[LOOK + j] == 0.0 and not spent:
        return GOES_ON
    ended = verdict(state, j, lag, ticks, end, limits.gravity, limits.deepest)
    return Status.OVER_BUDGET if spent and ended == GOES_ON else ended


@njit(nogil=True, **OPTIONS)
def run_queue(
    scheme: Any, queue: Any, cases: Any, row_of_case: Any, friction: Any, ground: Ground, steps: int, limits: Limits,
    counter: Any, path: Any, results: Any,
) -> Any:  # fmt: skip
    """Run the cases of a queue, all with the same steps per sample, standing or not; a finished column takes the next one.

    Parameters
    ----------
    scheme : NamedTuple
        What the kernel is told of the scheme, from `SCHEMES`.
    queue : ndarray of int64, shape (m,)
        Rows of `cases` to run, in this order.
    cases : ndarray, shape (n, PARAMETERS)
        The case table (`overturning.dem.block.tables`).
    row_of_case : ndarray of int64, shape (n,)
        Row of the ground motion that shakes each case.
    friction : ndarray, shape (n,), or None
        μ of each case; None where none of the queue has any, which compiles a kernel without tangential springs.
    ground, steps, limits : Ground, int, Limits
        Motion of the base, steps per sample, and what bounds every case.
    counter : ndarray of int64, shape (1,)
        Grows by the block steps done; for progress.
    path : ndarray, shape (rows, TRAJECTORY)
        Filled with the first column's state at each sample, more often where it rocks or steps finely; no rows to leave out.
    results : ndarray, shape (n, RESULTS)
        Filled in the rows of the queue; the steps found there, of runs before, count.

    Returns
    -------
    ndarray
        The rows of `path` that were filled, in a longer copy where it was too short. Where that would be longer than `MOST_PATH`
        the run ends without results but the status `GOES_ON`.
    """
    state = aligned(NUMBERS * COLUMNS)
    case, row, done = np.zeros(COLUMNS, np.int64), np.zeros(COLUMNS, np.int64), np.zeros(COLUMNS, np.int64)
    ticks, end, gravity, lag = 1.0 * TICKS * steps, float(ground.samples), limits.gravity, scheme.lag
    advance = loops_of(scheme, ground.up, friction)
    # Not literals: the counters would have a type of their own, and all they are handed to be compiled twice.
    none = int(np.int64(0))
    active, head, noted = none, none, none
    # Many steps between two looks at the columns, but none beyond the next sample, as far as the shaking is loaded.
    at_once = int(ticks / cases[queue[0], tables.P_STANDING]) + scheme.ahead
    stride = at_once if path.shape[0] == 0 else 1
    for j in range(COLUMNS):
        # Columns that no case takes hold the first one: nothing undefined is computed beside the others.
        i = queue[0]
        start(state, j, cases[i], 0.0 if friction is None else friction[i], ground.interval, ticks, gravity)
        row[j] = row_of_case[i]
    while True:
        while active < COLUMNS and head < queue.size:
            i = queue[head]
            case[active], row[active], done[active] = i, row_of_case[i], int(results[i, tables.R_STEPS])
            start(state, active, cases[i], 0.0 if friction is None else friction[i], ground.interval, ticks, gravity)
            active, head = active + 1, head + 1
        if active == 0:
            return path[:noted]
        columns = (active + 7) // 8 * 8
        next_sample(state, columns, row, ground.along, ground.up, ticks, ground.interval)
        for step in range(0, at_once, stride):
            if path.shape[0] > 0 and (step == 0 or state[TICK] == ticks):
                path = with_room(path, noted)
                if noted == path.shape[0]:
                    results[case[0], tables.R_STATUS] = GOES_ON
                    return path
                note(state, 0, lag, ground.interval, ticks, path[noted])
                noted += 1
            advance(state, columns, stride, ticks, gravity)
        counter[0] += active * at_once
        j = none if look_at(state, active, done, at_once, ticks, end, limits) > 0 else active
        while j < active:
            ended = ending(state, j, done[j] >= limits.budget, lag, ticks, end, limits)
            if ended == GOES_ON:
                j += 1
                continue
            finish(state, j, ended, lag, done[j], gravity, results[case[j]])
            # The last column moves into the free place.
            active -= 1
            case[j], row[j], done[j] = case[active], row[active], done[active]
            for r in range(NUMBERS):
                state[r * COLUMNS + j] = state[r * COLUMNS + active]


keep_compiled(run_queue)
