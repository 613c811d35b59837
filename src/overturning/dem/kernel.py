"""Gravestones side by side: up to `COLUMNS` blocks on one moving base; a finished column takes the next case.

The mechanics, the schemes and the order of the operations are derived in docs/method.md; the layout of the columns is in
`overturning.dem.columns`, the two schemes are in `overturning.dem.centred` and `overturning.dem.cundall`. What matters
for speed and for equal bits:

- the loops over the columns have no branches, only selections, and no libm; fast-math and contraction are off;
- left and right corner are summed as one pair, which makes the mirrored case exact;
- a column never sees another one: what it computes depends on its case alone.
"""

from typing import Any, Final

import numpy as np
from numba import njit

from overturning.dem.cache import keep_compiled
from overturning.dem.centred import advance_centred
from overturning.dem.cundall import advance_cundall

# isort: off
from overturning.dem.columns import (
    AFTER, ALPHA, AMPLITUDE, ANGLE, AW, AX, AZ, BARRIER, BASE, BEND, CALM, COLUMNS, COMPLIANCE, COS, DASHPOT,
    ENERGY, FINE, FRICTION, HALF_HEIGHT, HALF_WIDTH, INERTIA, LAST_UPRIGHT, LOOK, LOST, OLD_UL, OLD_UR, OLD_XL,
    OLD_XR, OPTIONS, PEAK_ANGLE, PEAK_DEPTH, PEAK_SLIP, ROWS, SAMPLE, SIN, SLOPE, SPRING_L, SPRING_R, STEP,
    STIFFNESS, TAIL_TICKS, TANGENTIAL, TICK, TICKS, UPRIGHT_UNTIL, UP_BASE, UP_BEND, UP_SLOPE, VW, VX, VZ, WINDOW,
    WORK, X, Z,
)  # fmt: skip
# isort: on

# Columns of the case table that `run_queue` takes.
(P_WIDTH, P_HEIGHT, P_STIFFNESS, P_TANGENTIAL, P_DASHPOT, P_FRICTION, P_ALPHA, P_AMPLITUDE) = range(8)
(P_TILT_COS, P_TILT_SIN, P_TILT, P_FIRST, P_CALM, P_AFTER, P_WINDOW, P_TAIL) = range(8, 16)
PARAMETERS: Final = 16

# Columns of its results.
(R_STATUS, R_SIDE, R_TIME, R_ANGLE, R_SLIP, R_RESIDUAL, R_DEPTH, R_ENERGY, R_STEPS) = range(9)
RESULTS: Final = 9

# Columns of a trajectory.
(
    T_TIME, T_X, T_Z, T_ANGLE, T_VX, T_VZ, T_VW, T_BASE_SLIP, T_DEPTH_L, T_DEPTH_R, T_GROUND
) = range(11)  # fmt: skip
TRAJECTORY: Final = 11

REST_ENERGY: Final = 1e-9
"""Kinetic energy, as a fraction of g B/2, below which a block on both corners is at rest."""


@njit(**OPTIONS)
def start(state: Any, j: int, case: Any, interval: float, ticks: float, gravity: float) -> None:
    """Put a case into column j: at static equilibrium on both corners, or tilted on one."""
    for row in range(ROWS):
        state[row * COLUMNS + j] = 0.0
    b, h = 0.5 * case[P_WIDTH], 0.5 * case[P_HEIGHT]
    k, ks = case[P_STIFFNESS], case[P_TANGENTIAL]
    c, s = case[P_TILT_COS], case[P_TILT_SIN]
    state[HALF_WIDTH + j], state[HALF_HEIGHT + j] = b, h
    state[INERTIA + j] = 3.0 / (b * b + h * h)
    state[STIFFNESS + j], state[TANGENTIAL + j] = k, ks
    state[COMPLIANCE + j] = 1.0 / ks if ks > 0.0 else 0.0
    state[DASHPOT + j], state[FRICTION + j] = case[P_DASHPOT], case[P_FRICTION]
    state[ALPHA + j], state[STEP + j] = case[P_ALPHA], interval / ticks
    state[WINDOW + j], state[TAIL_TICKS + j] = case[P_WINDOW], case[P_TAIL]
    state[FINE + j] = case[P_WINDOW]
    tilted = s != 0.0
    depth = gravity / k if tilted else 0.5 * gravity / k
    state[Z + j] = (b * abs(s) + h * c) - depth
    state[X + j] = b * ((1.0 - c) if s > 0.0 else (c - 1.0)) + h * s if tilted else 0.0
    state[COS + j], state[SIN + j], state[ANGLE + j] = c, s, case[P_TILT]
    x, z = state[X + j], state[Z + j]
    state[OLD_XL + j], state[OLD_UL + j] = x + (-(b * c) - h * s), -(z + (b * s - h * c))
    state[OLD_XR + j], state[OLD_UR + j] = x + (b * c - h * s), -(z + (-(b * s) - h * c))
    ul, ur = max(state[OLD_UL + j], 0.0), max(state[OLD_UR + j], 0.0)
    state[AZ + j] = k * (ul + ur) - gravity
    lever_l, lever_r = b * c + h * s, h * s - b * c
    state[AW + j] = state[INERTIA + j] * k * (lever_l * ul + lever_r * ur)
    state[PEAK_ANGLE + j] = abs(case[P_TILT])
    state[LAST_UPRIGHT + j] = -1.0
    state[AMPLITUDE + j], state[SAMPLE + j] = case[P_AMPLITUDE], case[P_FIRST]
    state[UPRIGHT_UNTIL + j] = case[P_FIRST] * interval
    state[BARRIER + j] = gravity * (np.sqrt(b * b + h * h) - h)
    state[CALM + j], state[AFTER + j] = case[P_CALM], case[P_AFTER]
    state[ENERGY + j] = energy(state, j, 0.0, gravity)


@njit(**OPTIONS)
def energy(state: Any, j: int, lag: float, gravity: float) -> float:
    """Kinetic, gravitational and spring energy per mass; `lag` brings half-step velocities to the whole step."""
    step = lag * TICKS * state[STEP + j]
    vx, vz = state[VX + j] + step * state[AX + j], state[VZ + j] + step * state[AZ + j]
    vw = state[VW + j] + step * state[AW + j]
    motion = (vx * vx + vz * vz) + vw * vw / state[INERTIA + j]
    ul = state[OLD_UL + j] if state[OLD_UL + j] > 0.0 else 0.0
    ur = state[OLD_UR + j] if state[OLD_UR + j] > 0.0 else 0.0
    tl, tr = state[SPRING_L + j], state[SPRING_R + j]
    springs = state[STIFFNESS + j] * (ul * ul + ur * ur) + state[TANGENTIAL + j] * (tl * tl + tr * tr)
    return float(0.5 * (motion + springs) + gravity * (state[Z + j] - state[HALF_HEIGHT + j]))


@njit(**OPTIONS)
def next_sample(state: Any, columns: int, row: Any, ground: Any, upward: Any, ticks: float, interval: float) -> None:
    """Bring the turning pair back to length 1 and load the ground motion of the sample that each column is in."""
    scale = 1.0 / ticks
    for j in range(columns):
        c, s = state[COS + j], state[SIN + j]
        passed, until, sample, tick = (
            state[LAST_UPRIGHT + j],
            state[UPRIGHT_UNTIL + j],
            state[SAMPLE + j],
            state[TICK + j],
        )
        unit = 1.5 - 0.5 * (c * c + s * s)
        then = (sample + passed * scale) * interval
        state[COS + j], state[SIN + j] = c * unit, s * unit
        state[UPRIGHT_UNTIL + j] = then if passed >= 0.0 else until
        state[LAST_UPRIGHT + j] = -1.0
        state[SAMPLE + j] = sample + 1.0 if tick >= ticks else sample
        state[TICK + j] = tick - ticks if tick >= ticks else tick
    last = ground.shape[1] - 3
    for j in range(columns):
        i = min(int(state[SAMPLE + j]), last)
        # A base that accelerates towards +s pushes the block towards −s.
        factor = -state[AMPLITUDE + j]
        a0, a1, a2 = ground[row[j], i] * factor, ground[row[j], i + 1] * factor, ground[row[j], i + 2] * factor
        state[BASE + j], state[SLOPE + j] = a0, (a1 - a0) * scale
        state[BEND + j] = ((a2 - a1) - (a1 - a0)) * scale
        if upward is not None:
            factor = state[AMPLITUDE + j]
            a0, a1, a2 = upward[i] * factor, upward[i + 1] * factor, upward[i + 2] * factor
            state[UP_BASE + j], state[UP_SLOPE + j] = a0, (a1 - a0) * scale
            state[UP_BEND + j] = ((a2 - a1) - (a1 - a0)) * scale


@njit(**OPTIONS)
def look_at(state: Any, columns: int, ticks: float, end: float, deepest: float) -> None:
    """Find the columns of which there may be something to say at the end of a sample; the others simply go on."""
    scale = 1.0 / ticks
    for j in range(columns):
        c, x, z = state[COS + j], state[X + j], state[Z + j]
        vx, vz, vw = state[VX + j], state[VZ + j], state[VW + j]
        b, h, depth = state[HALF_WIDTH + j], state[HALF_HEIGHT + j], state[PEAK_DEPTH + j]
        sample, calm = state[SAMPLE + j] + state[TICK + j] * scale, state[CALM + j]
        sum_of_all = (vx + vz + vw) + (x + z + c)
        until = calm if calm < end else end
        most = deepest * (b if b < h else h)
        # Not finite minus not finite is never 0.
        goes_on = (sum_of_all - sum_of_all == 0.0) & (c > 0.0) & (sample < until) & (depth <= most)
        state[LOOK + j] = 0.0 if goes_on else 1.0


@njit(**OPTIONS)
def rise(state: Any, j: int, gravity: float) -> float:
    """Energy that takes a block at rest to its largest rotation so far, or over, per mass; by series, without libm."""
    peak = min(state[PEAK_ANGLE + j], state[ALPHA + j])
    square = peak * peak
    sine = peak * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0)))
    versine = square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0)))
    return float(gravity * (state[HALF_WIDTH + j] * sine - state[HALF_HEIGHT + j] * versine))


@njit(**OPTIONS)
def verdict(state: Any, j: int, lag: float, ticks: float, end: float, gravity: float, deepest: float) -> int:
    """Status of a column at the end of a sample: -1 to go on, else a `Status`."""
    c, s, vx = state[COS + j], state[SIN + j], state[VX + j]
    if not np.isfinite(vx + state[VZ + j] + state[VW + j] + state[X + j] + state[Z + j] + c + s):
        return 3
    if state[PEAK_DEPTH + j] > deepest * min(state[HALF_WIDTH + j], state[HALF_HEIGHT + j]):
        return 3
    if c <= 0.0:
        return 0
    sample = state[SAMPLE + j] + state[TICK + j] / ticks
    if sample < end and sample < state[CALM + j]:
        return -1
    now = energy(state, j, lag, gravity)
    on_base = state[OLD_UL + j] > 0.0 and state[OLD_UR + j] > 0.0
    if sample >= state[CALM + j] and on_base:
        # A block that rests on both corners after the last instant at which it could start stays there.
        vz, vw = state[VZ + j], state[VW + j]
        kinetic = 0.5 * (vx * vx + vz * vz + vw * vw / state[INERTIA + j])
        if kinetic < REST_ENERGY * gravity * state[HALF_WIDTH + j]:
            return 0
    if sample >= end:
        if now < state[BARRIER + j] and abs(state[ANGLE + j]) < state[ALPHA + j]:
            # It can no longer fall, but while its energy reaches higher than it has been, its largest rotation is to come.
            # On one corner the weight has pressed the spring in, which lies g²/2k below the rigid block.
            if now + 0.5 * gravity * gravity / state[STIFFNESS + j] > rise(state, j, gravity):
                return 0 if sample >= state[AFTER + j] else -1
            # Let it slide to the end (v²/2μg ahead) unless nothing would stop it.
            slide = vx - state[HALF_HEIGHT + j] * c * state[VW + j]
            if slide * slide < 2e-6 * gravity * state[FRICTION + j] or state[FRICTION + j] == 0.0:
                return 0
            return 0 if sample >= state[AFTER + j] else -1
        return 2 if sample >= state[AFTER + j] else -1
    return -1


@njit(**OPTIONS)
def finish(state: Any, j: int, status: int, lag: float, steps: int, gravity: float, out: Any) -> None:
    """Write the results of a column."""
    c, s, angle = state[COS + j], state[SIN + j], state[ANGLE + j]
    fallen = status == 0 and c <= 0.0
    out[R_STATUS] = status
    out[R_SIDE] = (1.0 if angle > 0.0 else -1.0) if fallen else 0.0
    out[R_TIME] = state[UPRIGHT_UNTIL + j] if fallen else np.nan
    out[R_ANGLE] = min(state[PEAK_ANGLE + j], 0.5 * np.pi) / state[ALPHA + j]
    out[R_SLIP] = state[PEAK_SLIP + j]
    out[R_RESIDUAL] = state[X + j] - state[HALF_HEIGHT + j] * s
    out[R_DEPTH] = state[PEAK_DEPTH + j]
    balance = (energy(state, j, lag, gravity) - state[ENERGY + j]) - state[WORK + j] + state[LOST + j]
    out[R_ENERGY] = abs(balance) / max(state[WORK + j], state[BARRIER + j])
    out[R_STEPS] = steps


@njit(**OPTIONS)
def note(state: Any, j: int, lag: float, interval: float, ticks: float, path: Any) -> None:
    """Write a column's state into a row of its trajectory."""
    step = lag * TICKS * state[STEP + j]
    path[T_TIME] = (state[SAMPLE + j] + state[TICK + j] / ticks) * interval
    path[T_X], path[T_Z], path[T_ANGLE] = state[X + j], state[Z + j], state[ANGLE + j]
    path[T_VX], path[T_VZ] = state[VX + j] + step * state[AX + j], state[VZ + j] + step * state[AZ + j]
    path[T_VW] = state[VW + j] + step * state[AW + j]
    path[T_BASE_SLIP] = state[X + j] - state[HALF_HEIGHT + j] * state[SIN + j]
    b, h, c, s = state[HALF_WIDTH + j], state[HALF_HEIGHT + j], state[COS + j], state[SIN + j]
    path[T_DEPTH_L], path[T_DEPTH_R] = (h * c - b * s) - state[Z + j], (h * c + b * s) - state[Z + j]
    path[T_GROUND] = -(state[BASE + j] + state[SLOPE + j] * state[TICK + j])


@njit(nogil=True, **OPTIONS)
def run_queue(
    scheme: int,
    queue: Any,
    cases: Any,
    row_of_case: Any,
    ground: Any,
    upward: Any,
    rough: Any,
    samples: int,
    interval: float,
    steps: int,
    gravity: float,
    deepest: float,
    budget: int,
    counter: Any,
    path: Any,
    results: Any,
) -> int:
    """Run the cases of a queue, all with the same number of steps per sample; a finished column takes the next one.

    Parameters
    ----------
    scheme : int
        0 for Cundall's, 1 for the centred one.
    queue : ndarray of int64, shape (m,)
        Rows of `cases` to run, in this order.
    cases : ndarray, shape (n, PARAMETERS)
        The case table.
    row_of_case : ndarray of int64, shape (n,)
        Row of `ground` that shakes each case.
    ground : ndarray, shape (azimuths, samples + 3)
        Acceleration of the base towards +s, m/s², padded with zeros.
    upward : ndarray, shape (samples + 3,), or None
        Upward acceleration, m/s², padded with zeros; None where there is none, which compiles a kernel without it.
    rough : bool or None
        None where no case of the queue has friction, which compiles a kernel without tangential springs.
    samples, interval : int, float
        Length of the record and time between samples, s.
    steps : int
        Steps per sample.
    gravity : float
        m/s².
    deepest : float
        Penetration, as a fraction of the smaller half side, beyond which a case has failed.
    budget : int
        Largest number of block steps of one case.
    counter : ndarray of int64, shape (1,)
        Grows by the block steps done; for progress.
    path : ndarray, shape (rows, TRAJECTORY)
        Filled with the first column's state each `steps` steps: once per sample, more often where it steps finely; no
        rows to leave out.
    results : ndarray, shape (n, RESULTS)
        Filled in the rows of the queue.

    Returns
    -------
    int
        Rows of `path` that were filled.
    """
    state = np.zeros(ROWS * COLUMNS)
    case = np.zeros(COLUMNS, np.int64)
    row = np.zeros(COLUMNS, np.int64)
    done = np.zeros(COLUMNS, np.int64)
    ticks = 1.0 * TICKS * steps
    lag = 0.5 if scheme == 0 else 0.0
    end = float(samples)
    # Not literals: the counters would have a type of their own, and all they are handed to be compiled twice.
    none = int(np.int64(0))
    active, head, noted = none, none, none
    for j in range(COLUMNS):
        start(state, j, cases[queue[0]], interval, ticks, gravity)
        row[j] = row_of_case[queue[0]]
    while True:
        while active < COLUMNS and head < queue.size:
            case[active] = queue[head]
            row[active] = row_of_case[queue[head]]
            done[active] = 0
            start(state, active, cases[queue[head]], interval, ticks, gravity)
            active, head = active + 1, head + 1
        if active == 0:
            return noted
        columns = (active + 7) // 8 * 8
        next_sample(state, columns, row, ground, upward, ticks, interval)
        if noted < path.shape[0]:
            note(state, 0, lag, interval, ticks, path[noted])
            noted += 1
        if scheme == 0:
            advance_cundall(state, columns, steps, gravity, upward)
        else:
            advance_centred(state, columns, steps, gravity, upward, rough)
        look_at(state, columns, ticks, end, deepest)
        counter[0] += active * steps
        j = none
        while j < active:
            done[j] += steps
            if state[LOOK + j] == 0.0 and done[j] < budget:
                j += 1
                continue
            ended = verdict(state, j, lag, ticks, end, gravity, deepest)
            if ended < 0 and done[j] >= budget:
                ended = 5
            if ended < 0:
                j += 1
                continue
            finish(state, j, ended, lag, done[j], gravity, results[case[j]])
            # The last column moves into the free place.
            active -= 1
            case[j], row[j], done[j] = case[active], row[active], done[active]
            for r in range(ROWS):
                state[r * COLUMNS + j] = state[r * COLUMNS + active]


keep_compiled(run_queue)
