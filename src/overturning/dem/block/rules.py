"""Functions that the queue calls for a single block: start a case, compute a sample, skip samples, end a case.

For speed and equal bits, loops over the lanes have no branches, only selections, and use no libm functions. Left and
right corner are summed as one pair, so that mirrored cases are exact. To add a scheme, write a file with a named tuple
of constants, a function in `overturning.dem.block.loops`, and an entry in `SCHEMES` there.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from overturning.dem.block.ending import block_energy, case_status, record_block_motion, write_case_results
from overturning.dem.block.loops import select_loops
from overturning.dem.block.state import (
    COLUMNS,
    ROWS,
    TICKS,
    AssumedSlip,
    BlockConstants,
    BlockPeaks,
    BlockShaking,
    BlockState,
    CornerState,
    corner_position,
)
from overturning.dem.kernel.clock import Clock, StepAttempt
from overturning.dem.kernel.ending import CaseProgress, RestState, begin_sample, cannot_end_yet, is_still
from overturning.dem.kernel.ground import Ground, count_skippable_samples, is_rest_check_sample, motion_over_sample
from overturning.dem.kernel.lanes import INLINE, INNER, aligned_zeros
from overturning.dem.kernel.mechanics import LANDING, impact_time, normalise_cosine_and_sine
from overturning.dem.kernel.queue import QueueSettings, path_with_room, register_implementations
from overturning.units import STANDARD_GRAVITY as GRAVITY


class BlockKernelInput(NamedTuple):
    """Input of the kernel for cases of a single block, all with the same number of steps per sample, also at rest."""

    settings: QueueSettings
    cases: NDArray[np.void]
    """Case parameters, of type `CASE`, shape (n,)."""
    row: NDArray[np.int64]
    results: NDArray[np.void]
    """Results to fill in, of type `RESULT`, shape (n,)."""
    ground: Ground
    scheme: Any
    """Constants of the scheme, from `overturning.dem.block.loops.SCHEMES`."""
    with_friction: Any
    """None if all cases are frictionless: a kernel without tangential springs is compiled. Otherwise any value."""
    deepest: float
    """Penetration beyond which a case has failed, as a share of the smaller half side."""


class BlockWorkspace(NamedTuple):
    """Working memory of a queue of blocks."""

    state: Any


load_block, store_block, _ = ROWS.access(BlockConstants)
load_state, store_state, _ = ROWS.access(BlockState)
load_peaks, store_peaks, _ = ROWS.access(BlockPeaks)
load_course, store_course, _ = ROWS.access(CaseProgress)
store_attempt, store_assumed_slip, store_clock = (ROWS.access(of).store for of in (StepAttempt, AssumedSlip, Clock))
load_assumed_slip = ROWS.access(AssumedSlip).load
store_push, store_lift = ROWS.access(BlockShaking, "push").store, ROWS.access(BlockShaking, "lift").store
NUMBERS: Final = ROWS.count
COS, SIN, TICK, LAST_UPRIGHT = (
    ROWS.row(BlockState, "cos"), ROWS.row(BlockState, "sin"), ROWS.row(BlockState, "tick"),
    ROWS.row(BlockPeaks, "last_upright"),
)  # fmt: skip
LENGTH, REST_LIMIT, AT_REST = (
    ROWS.row(StepAttempt, "length"),
    ROWS.row(RestState, "rest_limit"),
    ROWS.row(RestState, "at_rest"),
)
SAMPLE, UPRIGHT_UNTIL = ROWS.row(CaseProgress, "sample"), ROWS.row(CaseProgress, "upright_until")


def allocate_workspace(inputs: Any) -> Any:  # noqa: ARG001, its type selects this function
    """Allocate the rows of all lanes."""
    return BlockWorkspace(aligned_zeros(NUMBERS * COLUMNS))


def start_case(inputs: Any, workspace: Any, lane: int, case: int) -> None:
    """Load a case into a lane (column): at static equilibrium on both corners, or tilted on one corner."""
    initialise_lane(workspace.state, lane, inputs.cases[case], inputs.settings.interval, inputs.settings.ticks)


@njit(**INNER)
def initialise_lane(state: Any, lane: int, case: Any, sampling_interval: float, ticks_per_sample: float) -> None:
    """Load the initial state of a case into a lane."""
    for row in range(NUMBERS):
        state[row * COLUMNS + lane] = 0.0
    b, h, c, s = 0.5 * case.width, 0.5 * case.height, case.tilt_cos, case.tilt_sin
    k, ks = case.stiffness, case.tangential
    inertia = 3.0 / (b * b + h * h)
    block = BlockConstants(
        half_width=b,
        half_height=h,
        inertia=inertia,
        stiffness=k,
        tangential=ks,
        compliance=1.0 / ks if ks > 0.0 else 0.0,
        dashpot=case.dashpot,
        friction=case.friction,
        alpha=case.alpha,
        step=sampling_interval / ticks_per_sample,
        gentle=case.gentle,
        landing=LANDING * case.dashpot / k,
        together=impact_time(k, case.dashpot),
        tilting=0.0 if case.friction * h <= b else 1.0,
    )
    tilted = s != 0.0
    z = (b * abs(s) + h * c) - (GRAVITY / k if tilted else 0.5 * GRAVITY / k)
    x = b * ((1.0 - c) if s > 0.0 else (c - 1.0)) + h * s if tilted else 0.0
    (arm_l, drop_l), (arm_r, drop_r) = corner_position(-1.0, block, c, s), corner_position(1.0, block, c, s)
    left, right = CornerState(0.0, x + arm_l, drop_l - z, 0.0), CornerState(0.0, x + arm_r, drop_r - z, 0.0)
    ul, ur = max(left.depth, 0.0), max(right.depth, 0.0)
    az, aw = k * (ul + ur) - GRAVITY, inertia * k * (-arm_l * ul + -arm_r * ur)
    at_rest = BlockState(
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
    store_block(state, lane, block)
    store_clock(state, lane, Clock(case.finest, case.standing, case.dwell, case.settled))  # fmt: skip
    store_state(state, lane, at_rest)
    store_attempt(state, lane, StepAttempt(case.finest, case.dwell, 0.0))
    store_assumed_slip(state, lane, AssumedSlip(0.0, 0.0))
    store_peaks(state, lane, BlockPeaks(abs(case.tilt), 0.0, 0.0, -1.0))
    barrier, first = GRAVITY * (np.sqrt(b * b + h * h) - h), block_energy(block, at_rest, 0.0)
    state[REST_LIMIT + lane], course = (
        case.rest_limit,
        CaseProgress(case.amplitude, case.first, case.calm, case.after, case.first * sampling_interval, first, barrier),
    )
    store_course(state, lane, course)


def load_sample_motion(inputs: Any, workspace: Any, cases: Any, lane_count: int) -> None:
    """Begin a sample: normalise the rotations and load the base motion."""
    load_next_sample(
        workspace.state, lane_count, inputs.row, cases, inputs.ground.along, inputs.ground.up, inputs.settings
    )


@njit(**INNER)
def load_next_sample(
    state: Any,
    lane_count: int,
    motion_rows: Any,
    cases: Any,
    horizontal_ground: Any,
    vertical_ground: Any,
    settings: QueueSettings,
) -> None:
    """Scale cosine and sine of the rotation to length 1; load the base motion of the current sample of each lane."""
    ticks, interval, scale = settings.ticks, settings.interval, 1.0 / settings.ticks
    for j in range(lane_count):
        s = load_state(state, j)
        state[COS + j], state[SIN + j] = normalise_cosine_and_sine(s.cos, s.sin)
        begun = begin_sample(load_course(state, j), s.tick, state[LAST_UPRIGHT + j], ticks, interval)
        state[SAMPLE + j], state[TICK + j], state[UPRIGHT_UNTIL + j] = begun
        state[LAST_UPRIGHT + j] = -1.0
    last = horizontal_ground.shape[1] - 3
    for j in range(lane_count):
        course = load_course(state, j)
        i = min(int(course.sample), last)
        # A base that accelerates towards +s pushes the block towards −s.
        store_push(state, j, motion_over_sample(horizontal_ground[motion_rows[cases[j]]], i, -course.amplitude, scale))
        if vertical_ground is not None:
            store_lift(state, j, motion_over_sample(vertical_ground, i, course.amplitude, scale))


def advance_one_sample(inputs: Any, workspace: Any, lane_count: int, path: Any, recorded_rows: int) -> tuple[Any, int]:
    """Compute the steps of a sample; record the first lane at its start, and when it reaches the end of its sample."""
    # Unpack the input before the branch: otherwise Numba increments the reference count of every array once per sample.
    settings, scheme, state = inputs.settings, inputs.scheme, workspace.state
    up, with_friction = inputs.ground.up, inputs.with_friction
    step, ticks, steps_per_check = select_loops(scheme, up, with_friction), settings.ticks, settings.steps_per_check
    stride = steps_per_check if path.shape[0] == 0 else 1
    if path.shape[0] > 0:
        path = path_with_room(path, recorded_rows + steps_per_check, settings.max_rows)
        if path.shape[0] < recorded_rows + steps_per_check:
            return path, -1
    for done in range(0, steps_per_check, stride):
        if path.shape[0] > 0 and (done == 0 or state[TICK] == ticks):
            record_block_motion(state, 0, scheme.lag, settings.interval, ticks, path[recorded_rows])
            recorded_rows += 1
        step((up, with_friction), state, lane_count, stride, ticks)
    return path, recorded_rows


def mark_ending_lanes(inputs: Any, workspace: Any, active_count: int, marks: Any) -> int:
    """Mark the lanes whose case may have ended, and count them."""
    return mark_possibly_ended(
        workspace.state, active_count, marks, inputs.settings.ticks, float(inputs.settings.samples), inputs.deepest
    )


@njit(**INNER)
def mark_possibly_ended(
    state: Any, active_count: int, marks: Any, ticks_per_sample: float, last_sample: float, max_penetration: float
) -> int:
    """Mark and count lanes that fell, failed, or are past the samples in which the motion can move their block."""
    count = 0
    for j in range(active_count):
        block, s, b = load_block(state, j), load_state(state, j), load_block(state, j).half_width
        most = max_penetration * (b if b < block.half_height else block.half_height)
        sound = (s.cos > 0.0) & (load_peaks(state, j).depth <= most)
        total = (s.vx + s.vz + s.vw) + (s.x + s.z + s.cos)
        goes_on = cannot_end_yet(load_course(state, j), s.tick, ticks_per_sample, last_sample, total, sound)
        marks[j] = 0.0 if goes_on else 1.0
        count += 0 if goes_on else 1
    return count


def skip_quiet_samples(inputs: Any, workspace: Any, cases: Any, active_count: int, skipped_samples: Any) -> None:
    """Skip, for blocks at rest, the samples in which the motion cannot move them."""
    skip_samples_at_rest(
        workspace.state, cases, active_count, inputs.row, inputs.ground, inputs.settings.ticks, skipped_samples
    )


@njit(**INNER)
def skip_samples_at_rest(
    state: Any,
    cases: Any,
    active_count: int,
    motion_rows: Any,
    ground: Any,
    ticks_per_sample: float,
    skipped_samples: Any,
) -> None:
    """Skip, for blocks at rest at the start of a sample, the samples in which the motion cannot move them."""
    count = 0
    for j in range(active_count):
        course, s, length, rest_limit = (
            load_course(state, j),
            load_state(state, j),
            state[LENGTH + j],
            state[REST_LIMIT + j],
        )
        assumed, block, now = (
            load_assumed_slip(state, j),
            load_block(state, j),
            course.sample + s.tick * (1.0 / ticks_per_sample),
        )
        still = is_still(
            largest_motion_component(s.vx, s.vz, s.vw, block),
            largest_motion_component(s.ax, s.az, s.aw, block),
            length * block.step,
            rest_limit,
        )
        held = (s.left.normal > 0.0) & (s.right.normal > 0.0) & (assumed.left == 0.0) & (assumed.right == 0.0)
        resting = (length >= TICKS) & is_rest_check_sample(now) & held & still
        state[AT_REST + j] = 1.0 if resting else 0.0
        count += 1 if resting else 0
    for j in range(active_count if count > 0 else 0):
        if state[AT_REST + j] > 0.0:
            course = load_course(state, j)
            now = course.sample + state[TICK + j] * (1.0 / ticks_per_sample)
            samples = count_skippable_samples(
                ground, motion_rows[cases[j]], now, course.amplitude, state[REST_LIMIT + j]
            )
            state[SAMPLE + j] += samples
            skipped_samples[j] += samples


@njit(**INLINE)
def largest_motion_component(horizontal: float, vertical: float, rotational: float, block: BlockConstants) -> float:
    """Return the largest component of a velocity or acceleration; rotation counts at half the height."""
    turn, most = (
        abs(rotational) * block.half_height,
        abs(horizontal) if abs(horizontal) > abs(vertical) else abs(vertical),
    )
    return most if most > turn else turn


def lane_end_status(inputs: Any, workspace: Any, lane: int, case: int) -> int:  # noqa: ARG001
    """Return the `Status` of the case in a lane, or `GOES_ON` if it has not ended."""
    return case_status(
        workspace.state, lane, inputs.scheme.lag, inputs.settings.ticks, float(inputs.settings.samples), inputs.deepest
    )


def write_lane_results(inputs: Any, workspace: Any, lane: int, case: int, status: int) -> None:
    """Write the results of the case in a lane into the table of results."""
    write_case_results(workspace.state, lane, status, inputs.scheme.lag, inputs.results[case])


register_implementations(
    BlockKernelInput, allocate_workspace, start_case, load_sample_motion, advance_one_sample, mark_ending_lanes,
    skip_quiet_samples, lane_end_status, write_lane_results,
)  # fmt: skip
