"""Termination of a case of a single block: its energy, the tests for its end, and its results (docs/method.md)."""

from typing import Any

import numpy as np
from numba import njit

from overturning.dem.block.state import (
    ROWS,
    TICKS,
    Block,
    BlockAccount,
    BlockPeaks,
    BlockShaking,
    BlockState,
    base_slip,
)
from overturning.dem.kernel.ending import GOES_ON, REST_ENERGY, STILL_TO_SLIDE, CaseProgress
from overturning.dem.kernel.lanes import INLINE, INNER
from overturning.model.status import Status
from overturning.units import STANDARD_GRAVITY as GRAVITY

load_block, load_state, load_peaks = (ROWS.access(of).load for of in (Block, BlockState, BlockPeaks))
load_account, load_course = ROWS.access(BlockAccount).load, ROWS.access(CaseProgress).load
load_shaking = ROWS.access(BlockShaking).load


@njit(**INLINE)
def whole_step(block: Block, s: BlockState, lag: float) -> tuple[float, float, float]:
    """Return the velocities at the whole step; the stored ones lag `lag` steps behind."""
    time = lag * TICKS * block.step
    return s.vx + time * s.ax, s.vz + time * s.az, s.vw + time * s.aw


@njit(**INLINE)
def energy(block: Block, s: BlockState, lag: float) -> float:
    """Compute the kinetic, gravitational and spring energy per mass, m²/s²."""
    vx, vz, vw = whole_step(block, s, lag)
    motion = (vx * vx + vz * vz) + vw * vw / block.inertia
    ul, ur, tl, tr = max(s.left.depth, 0.0), max(s.right.depth, 0.0), s.left.spring, s.right.spring
    springs = block.stiffness * (ul * ul + ur * ur) + block.tangential * (tl * tl + tr * tr)
    return float(0.5 * (motion + springs) + GRAVITY * (s.z - block.half_height))


@njit(**INLINE)
def tilt_energy(block: Block, peak: float) -> float:
    """Return the energy per mass that rotates a block at rest to `peak`, at most to α; by series, without libm."""
    angle = min(peak, block.alpha)
    square = angle * angle
    sine = angle * (1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0)))
    versine = square / 2.0 * (1.0 - square / 12.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0)))
    return float(GRAVITY * (block.half_width * sine - block.half_height * versine))


@njit(**INLINE)
def outcome_is_final(block: Block, s: BlockState, peak: float, barrier: float, lag: float) -> bool:
    """True if a block on a base at rest stands for good, and its peak rotation and slip are final."""
    now = energy(block, s, lag)
    if not (now < barrier and abs(s.angle) < block.alpha):
        return False
    # It can no longer fall, but its peak rotation is final only if its energy cannot reach it again. On one corner the
    # weight compresses the spring: g²/2k less energy than in the rigid block.
    if now + 0.5 * GRAVITY * GRAVITY / block.stiffness > tilt_energy(block, peak):
        return False
    # Let it slide to its end, v²/2μg ahead; without friction it never stops.
    slide = s.vx - block.half_height * s.cos * s.vw
    return bool(slide * slide < 2.0 * STILL_TO_SLIDE * GRAVITY * block.friction or block.friction == 0.0)


@njit(**INNER)
def has_ended(state: Any, j: int, lag: float, ticks: float, end: float, deepest: float) -> int:
    """Return the `Status` of a case at the end of a sample, or `GOES_ON`."""
    block, s, peaks, course = load_block(state, j), load_state(state, j), load_peaks(state, j), load_course(state, j)
    if not np.isfinite(s.vx + s.vz + s.vw + s.x + s.z + s.cos + s.sin):
        return Status.UNSTABLE
    if peaks.depth > deepest * min(block.half_width, block.half_height):
        return Status.UNSTABLE
    if s.cos <= 0.0:
        return Status.SIMULATED
    sample = course.sample + s.tick / ticks
    if sample >= course.calm and s.left.depth > 0.0 and s.right.depth > 0.0:
        # A block that rests on both corners after the last time at which it could start to move stays there.
        kinetic = 0.5 * (s.vx * s.vx + s.vz * s.vz + s.vw * s.vw / block.inertia)
        if kinetic < REST_ENERGY * GRAVITY * block.half_width:
            return Status.SIMULATED
    if sample < end:
        return GOES_ON
    if outcome_is_final(block, s, peaks.angle, course.barrier, lag):
        return Status.SIMULATED
    if sample < course.after:
        return GOES_ON
    standing = energy(block, s, lag) < course.barrier and abs(s.angle) < block.alpha
    return Status.SIMULATED if standing else Status.UNDECIDED


@njit(**INNER)
def finish_block(state: Any, j: int, status: int, lag: float, out: Any) -> None:
    """Write the results of case j."""
    block, s, peaks = load_block(state, j), load_state(state, j), load_peaks(state, j)
    account, course = load_account(state, j), load_course(state, j)
    fallen = status == Status.SIMULATED and s.cos <= 0.0
    out.overturned = (1.0 if s.angle > 0.0 else -1.0) if fallen else 0.0
    out.overturning_time = course.upright_until if fallen else np.nan
    # The angle sums up rotations, the cosine multiplies them: in steps of 0.25 rad they differ by 0.1 %.
    out.peak_rotation = (0.5 * np.pi if fallen else min(peaks.angle, 0.5 * np.pi)) / block.alpha
    out.peak_slip, out.residual_slip = peaks.slip, base_slip(block, s.x, s.sin)
    out.peak_penetration = peaks.depth
    balance = (energy(block, s, lag) - course.energy) - account.work + account.lost
    out.energy_error = abs(balance) / max(account.work, course.barrier)


@njit(**INNER)
def record_state(state: Any, j: int, lag: float, interval: float, ticks: float, path: Any) -> None:
    """Write the state of case j into a row of its trajectory."""
    block, s, push = load_block(state, j), load_state(state, j), load_shaking(state, j).push
    path.time = (load_course(state, j).sample + s.tick / ticks) * interval
    path.x, path.z, path.angle = s.x, s.z, s.angle
    path.vx, path.vz, path.vw = whole_step(block, s, lag)
    path.ground = -(push.value + push.slope * s.tick)
