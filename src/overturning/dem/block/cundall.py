"""Cundall's scheme: central differences, spring at the whole step, dashpot at the half step before (docs/method.md)."""

from typing import Final, NamedTuple

from numba import njit

from overturning.dem.block.state import (
    TICKS,
    Account,
    Block,
    Corner,
    Peaks,
    Shaking,
    State,
    arm_of,
    base_slip,
    drift_of,
    landing_of,
    lands_flat,
)
from overturning.dem.kernel.ground import within_sample
from overturning.dem.kernel.lanes import INLINE, select
from overturning.dem.kernel.mechanics import larger, turned, within
from overturning.units import STANDARD_GRAVITY as GRAVITY

WHOLE: Final = TICKS


class Force(NamedTuple):
    """What the base does to a corner."""

    n: float
    """Normal"""
    f: float
    """and tangential force, along s;"""
    arm: float
    """the corner from the centre, along s"""
    drop: float
    """and down;"""
    corner: Corner
    """what it remembers;"""
    opened: float
    """energy that its springs let go, normal"""
    shortened: float
    """and tangential, over half their stiffness;"""
    damping: float
    """the part of the normal force that is not the spring's,"""
    sliding: float
    """and of the tangential one."""


@njit(**INLINE)
def act(side: float, block: Block, s: State, old: Corner, rate: float, flat: tuple[bool, bool, float]) -> Force:
    """Contact law at a corner; `rate` is that of its dashpots per displacement of a step.

    `flat` says whether the block lands flat, and of `drift_of`, whether it slides meanwhile and by which ±μ.
    """
    held, drifts, drift = flat
    arm, drop = arm_of(side, block, s.cos, s.sin)
    place, depth = s.x + arm, drop - s.z
    slip, sinking = place - old.place, depth - old.depth
    inside, was = depth > 0.0, old.depth > 0.0
    # Spring and dashpot while the corner is in, never tension but in a flat landing.
    n = block.stiffness * depth + rate * sinking
    n = n if inside & (held | (n > 0.0)) else 0.0
    # A new contact starts with an unstretched spring; one that slips has it shortened to what friction holds.
    stretch = old.spring + slip if was else 0.0
    most = block.friction * n
    whole = -(block.tangential * stretch) - rate * slip
    slips = drifts if held else abs(whole) > most
    f = -drift * n if drifts else (within(whole, most) if slips else whole)
    kept = within(stretch, (most if most > 0.0 else 0.0) * block.compliance) if slips else stretch
    let_go = old.depth if was & (not inside) else 0.0
    return Force(
        n=n, f=f, arm=arm, drop=drop,
        corner=Corner(kept, place, depth, 0.0), opened=let_go * let_go,
        shortened=(old.spring + kept) * (stretch - kept),
        damping=n - block.stiffness * (depth if inside else 0.0), sliding=f + block.tangential * kept,
    )  # fmt: skip


@njit(**INLINE)
def lost_at(corner: Force, vx: float, vz: float, vw: float) -> float:
    """Power that the dashpots and the slider of a corner take from the block."""
    return corner.damping * (vz - corner.arm * vw) + corner.sliding * (vx - corner.drop * vw)


@njit(**INLINE)
def step(
    block: Block, s: State, peaks: Peaks, account: Account, shaking: Shaking, vertical: bool
) -> tuple[State, Peaks, Account]:
    """One step of one block."""
    dt = block.step * WHOLE
    push, lift = within_sample(shaking.push, s.tick), within_sample(shaking.lift, s.tick)
    rate = block.dashpot / dt
    (_, drop_left), (_, drop_right) = arm_of(-1.0, block, s.cos, s.sin), arm_of(1.0, block, s.cos, s.sin)
    held = lands_flat(s, drop_left - s.z, drop_right - s.z)
    flat = (held, *drift_of(block, held, s.vx, s.vz))
    left, right = act(-1.0, block, s, s.left, rate, flat), act(1.0, block, s, s.right, rate, flat)
    # Accelerations in the frame of the base; left and right corner as one pair.
    ax, az = (left.f + right.f) + push, (left.n + right.n) - (GRAVITY + lift if vertical else GRAVITY)
    aw = block.inertia * ((-left.drop * left.f - left.arm * left.n) + (-right.drop * right.f - right.arm * right.n))
    # The energy account takes the velocities at the whole step.
    half = 0.5 * dt
    cx, cz, cw = s.vx + half * ax, s.vz + half * az, s.vw + half * aw
    power = push * cx - lift * cz if vertical else push * cx
    let_go = 0.5 * (
        block.stiffness * (left.opened + right.opened) + block.tangential * (left.shortened + right.shortened)
    )
    lost = account.lost + (let_go - dt * (lost_at(left, cx, cz, cw) + lost_at(right, cx, cz, cw)))
    # Velocities half a step later, position one step later.
    vx, vz, vw = s.vx + dt * ax, s.vz + dt * az, s.vw + dt * aw
    turn, tick = dt * vw, s.tick + WHOLE
    c, sn = turned(s.cos, s.sin, turn)
    x, z, angle = s.x + dt * vx, s.z + dt * vz, s.angle + turn
    peaks = Peaks(
        larger(peaks.angle, abs(angle)),
        larger(peaks.slip, abs(base_slip(block, x, sn))),
        larger(peaks.depth, left.corner.depth if left.corner.depth > right.corner.depth else right.corner.depth),
        select(abs(angle) < block.alpha, tick, peaks.last_upright),
    )
    moved = State(
        x=x,
        z=z,
        angle=angle,
        cos=c,
        sin=sn,
        vx=vx,
        vz=vz,
        vw=vw,
        ax=ax,
        az=az,
        aw=aw,
        left=left.corner,
        right=right.corner,
        tick=tick,
        landing=landing_of(block, s, dt),
    )
    return moved, peaks, Account(account.work + dt * power, lost, 0.0, 0.0)
