"""What the queue asks of a block: its rules, how a case begins, how a sample goes, how a case ends.

What matters for speed and for equal bits: the loops over the lanes have no branches, only selections, and no libm; left
and right corner are summed as one pair, which makes the mirrored case exact. A scheme is one file with a named tuple, a
function in `overturning.dem.block.loops`, and one row of `SCHEMES` there.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from overturning.dem.block.ending import energy, finish_block, has_ended, note
from overturning.dem.block.loops import loops_of
from overturning.dem.block.state import COLUMNS, ROWS, TICKS, Block, Corner, Peaks, Shaking, State, Taken, arm_of
from overturning.dem.kernel.clock import Attempt, Clock
from overturning.dem.kernel.ending import CaseProgress, RestState, begin_sample, cannot_end_yet, is_still
from overturning.dem.kernel.ground import Ground, is_rest_check_sample, piece, samples_at_rest
from overturning.dem.kernel.lanes import INLINE, INNER, aligned
from overturning.dem.kernel.mechanics import LANDING, renormalised
from overturning.dem.kernel.queue import Job, implement, with_room
from overturning.units import STANDARD_GRAVITY as GRAVITY


class BlockRules(NamedTuple):
    """Rules of cases of a single block, all with the same steps per sample, standing or not."""

    job: Job
    cases: NDArray[np.void]
    """Table of `CASE`;"""
    row: NDArray[np.int64]
    results: NDArray[np.void]
    """table of `RESULT`;"""
    ground: Ground
    scheme: Any
    """constants of the scheme, from `overturning.dem.block.loops.SCHEMES`;"""
    with_friction: Any
    """anything where there is friction; None where no case has any: a kernel without tangential springs is compiled;"""
    deepest: float
    """penetration, as a share of the smaller half side, beyond which a case has failed."""


class Work(NamedTuple):
    """What blocks are computed in."""

    state: Any


load_block, store_block, _ = ROWS.access(Block)
load_state, store_state, _ = ROWS.access(State)
load_peaks, store_peaks, _ = ROWS.access(Peaks)
load_course, store_course, _ = ROWS.access(CaseProgress)
store_attempt, store_taken, store_clock = (ROWS.access(of).store for of in (Attempt, Taken, Clock))
load_taken = ROWS.access(Taken).load
store_push, store_lift = ROWS.access(Shaking, "push").store, ROWS.access(Shaking, "lift").store
NUMBERS: Final = ROWS.count
COS, SIN, TICK, LAST_UPRIGHT = (
    ROWS.row(State, "cos"), ROWS.row(State, "sin"), ROWS.row(State, "tick"), ROWS.row(Peaks, "last_upright")
)  # fmt: skip
LENGTH, BEARS, FOUND = ROWS.row(Attempt, "length"), ROWS.row(RestState, "bears"), ROWS.row(RestState, "found")
SAMPLE, UPRIGHT_UNTIL = ROWS.row(CaseProgress, "sample"), ROWS.row(CaseProgress, "upright_until")


def workspace(rules: Any) -> Any:  # noqa: ARG001, its type picks this function
    """Rows of all lanes."""
    return Work(aligned(NUMBERS * COLUMNS))


def start(rules: Any, work: Any, lane: int, case: int) -> None:
    """Put a case into a lane: at static equilibrium on both corners, or tilted on one."""
    put(work.state, lane, rules.cases[case], rules.job.interval, rules.job.ticks)


@njit(**INNER)
def put(state: Any, j: int, case: Any, interval: float, ticks: float) -> None:
    """Put a case into lane j; `ticks` is their number in a sample."""
    for row in range(NUMBERS):
        state[row * COLUMNS + j] = 0.0
    b, h, c, s = 0.5 * case.width, 0.5 * case.height, case.tilt_cos, case.tilt_sin
    k, ks = case.stiffness, case.tangential
    inertia = 3.0 / (b * b + h * h)
    block = Block(
        half_width=b,
        half_height=h,
        inertia=inertia,
        stiffness=k,
        tangential=ks,
        compliance=1.0 / ks if ks > 0.0 else 0.0,
        dashpot=case.dashpot,
        friction=case.friction,
        alpha=case.alpha,
        step=interval / ticks,
        gentle=case.gentle,
        landing=LANDING * case.dashpot / k,
    )
    tilted = s != 0.0
    z = (b * abs(s) + h * c) - (GRAVITY / k if tilted else 0.5 * GRAVITY / k)
    x = b * ((1.0 - c) if s > 0.0 else (c - 1.0)) + h * s if tilted else 0.0
    (arm_l, drop_l), (arm_r, drop_r) = arm_of(-1.0, block, c, s), arm_of(1.0, block, c, s)
    left, right = Corner(0.0, x + arm_l, drop_l - z, 0.0), Corner(0.0, x + arm_r, drop_r - z, 0.0)
    ul, ur = max(left.depth, 0.0), max(right.depth, 0.0)
    az, aw = k * (ul + ur) - GRAVITY, inertia * k * (-arm_l * ul + -arm_r * ur)
    at_rest = State(
        x=x,
        z=z,
        angle=case.tilt,
        cos=c,
        sin=s,
        vx=0.0,
        vz=0.0,
        vw=0.0,
        ax=0.0,
        az=az,
        aw=aw,
        left=left,
        right=right,
        tick=0.0,
        landing=0.0,
    )
    store_block(state, j, block)
    store_clock(state, j, Clock(case.finest, case.standing, case.dwell, case.settled))  # fmt: skip
    store_state(state, j, at_rest)
    store_attempt(state, j, Attempt(case.finest, case.dwell, 0.0))
    store_taken(state, j, Taken(0.0, 0.0))
    store_peaks(state, j, Peaks(abs(case.tilt), 0.0, 0.0, -1.0))
    barrier, first = GRAVITY * (np.sqrt(b * b + h * h) - h), energy(block, at_rest, 0.0)
    state[BEARS + j], course = (
        case.bears,
        CaseProgress(case.amplitude, case.first, case.calm, case.after, case.first * interval, first, barrier),
    )
    store_course(state, j, course)


def load(rules: Any, work: Any, cases: Any, columns: int) -> None:
    """Begin a sample."""
    next_sample(work.state, columns, rules.row, cases, rules.ground.along, rules.ground.up, rules.job)


@njit(**INNER)
def next_sample(state: Any, columns: int, row: Any, cases: Any, along: Any, up: Any, job: Job) -> None:
    """Bring the turning pair back to length 1 and load the ground motion of the sample that each lane is in."""
    ticks, interval, scale = job.ticks, job.interval, 1.0 / job.ticks
    for j in range(columns):
        s = load_state(state, j)
        state[COS + j], state[SIN + j] = renormalised(s.cos, s.sin)
        begun = begin_sample(load_course(state, j), s.tick, state[LAST_UPRIGHT + j], ticks, interval)
        state[SAMPLE + j], state[TICK + j], state[UPRIGHT_UNTIL + j] = begun
        state[LAST_UPRIGHT + j] = -1.0
    last = along.shape[1] - 3
    for j in range(columns):
        course = load_course(state, j)
        i = min(int(course.sample), last)
        # A base that accelerates towards +s pushes the block towards −s.
        store_push(state, j, piece(along[row[cases[j]]], i, -course.amplitude, scale))
        if up is not None:
            store_lift(state, j, piece(up, i, course.amplitude, scale))


def advance(rules: Any, work: Any, columns: int, path: Any, noted: int) -> tuple[Any, int]:
    """Compute the steps of a sample; the first lane is noted at its begin and wherever it ends before the others."""
    # All at once, for `rules` kept beyond a branch would count a use of each of its arrays, for every sample.
    job, scheme, up, with_friction, state = rules.job, rules.scheme, rules.ground.up, rules.with_friction, work.state
    step, ticks, at_once = loops_of(scheme, up, with_friction), job.ticks, job.at_once
    stride = at_once if path.shape[0] == 0 else 1
    if path.shape[0] > 0:
        path = with_room(path, noted + at_once, job.most_rows)
        if path.shape[0] < noted + at_once:
            return path, -1
    for done in range(0, at_once, stride):
        if path.shape[0] > 0 and (done == 0 or state[TICK] == ticks):
            note(state, 0, scheme.lag, job.interval, ticks, path[noted])
            noted += 1
        step((up, with_friction), state, columns, stride, ticks)
    return path, noted


def count_due(rules: Any, work: Any, active: int, due: Any) -> int:
    """Mark lanes of which there may be something to say; the others simply go on."""
    return mark_due(work.state, active, due, rules.job.ticks, float(rules.job.samples), rules.deepest)


@njit(**INNER)
def mark_due(state: Any, active: int, due: Any, ticks: float, end: float, deepest: float) -> int:
    """Mark and count the lanes that have fallen, are past the samples in which something can start, or have failed."""
    count = 0
    for j in range(active):
        block, s, b = load_block(state, j), load_state(state, j), load_block(state, j).half_width
        most = deepest * (b if b < block.half_height else block.half_height)
        sound = (s.cos > 0.0) & (load_peaks(state, j).depth <= most)
        total = (s.vx + s.vz + s.vw) + (s.x + s.z + s.cos)
        goes_on = cannot_end_yet(load_course(state, j), s.tick, ticks, end, total, sound)
        due[j] = 0.0 if goes_on else 1.0
        count += 0 if goes_on else 1
    return count


def leave_out(rules: Any, work: Any, cases: Any, active: int, left_out: Any) -> None:
    """Leave out samples of lanes at rest."""
    leave_out_samples(work.state, cases, active, rules.row, rules.ground, rules.job.ticks, left_out)


@njit(**INNER)
def leave_out_samples(state: Any, cases: Any, active: int, row: Any, ground: Any, ticks: float, left_out: Any) -> None:
    """Let blocks that rest at the begin of a sample go on as they are while the shaking cannot move them."""
    count = 0
    for j in range(active):
        course, s, length, bears = load_course(state, j), load_state(state, j), state[LENGTH + j], state[BEARS + j]
        taken, block, now = load_taken(state, j), load_block(state, j), course.sample + s.tick * (1.0 / ticks)
        still = is_still(
            motion_of(s.vx, s.vz, s.vw, block), motion_of(s.ax, s.az, s.aw, block), length * block.step, bears
        )
        held = (s.left.normal > 0.0) & (s.right.normal > 0.0) & (taken.left == 0.0) & (taken.right == 0.0)
        found = (length >= TICKS) & is_rest_check_sample(now) & held & still
        state[FOUND + j] = 1.0 if found else 0.0
        count += 1 if found else 0
    for j in range(active if count > 0 else 0):
        if state[FOUND + j] > 0.0:
            course = load_course(state, j)
            now = course.sample + state[TICK + j] * (1.0 / ticks)
            samples = samples_at_rest(ground, row[cases[j]], now, course.amplitude, state[BEARS + j])
            state[SAMPLE + j] += samples
            left_out[j] += samples


@njit(**INLINE)
def motion_of(x: float, z: float, w: float, block: Block) -> float:
    """Largest of velocities or accelerations, of the rotation half the height up."""
    turn, most = abs(w) * block.half_height, abs(x) if abs(x) > abs(z) else abs(z)
    return most if most > turn else turn


def ended(rules: Any, work: Any, lane: int, case: int) -> int:  # noqa: ARG001
    """`Status` of a lane, or that it goes on."""
    return has_ended(work.state, lane, rules.scheme.lag, rules.job.ticks, float(rules.job.samples), rules.deepest)


def finish(rules: Any, work: Any, lane: int, case: int, status: int) -> None:
    """Write the results of a lane."""
    finish_block(work.state, lane, status, rules.scheme.lag, rules.results[case])


implement(BlockRules, workspace, start, load, advance, count_due, leave_out, ended, finish)
