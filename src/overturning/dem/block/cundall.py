"""Cundall's scheme for a block: central differences, spring at the whole step, dashpot half a step earlier."""

from typing import Final, NamedTuple

from numba import njit

from overturning.dem.block.state import (
    TICKS,
    Block,
    BlockAccount,
    BlockPeaks,
    BlockShaking,
    BlockState,
    Corner,
    arm_of,
    base_slip,
    flat_landing_slip,
    lands_flat,
    remaining_landing,
)
from overturning.dem.kernel.ground import within_sample
from overturning.dem.kernel.lanes import INLINE, select
from overturning.dem.kernel.mechanics import clamp, larger, rotate_pair
from overturning.units import STANDARD_GRAVITY as GRAVITY

WHOLE: Final = TICKS


class CornerForce(NamedTuple):
    """Contact force of the base on a corner, per mass."""

    n: float
    """Normal force, m/s²."""
    f: float
    """Tangential force along s, m/s²."""
    arm: float
    """Position of the corner from the centre, along s, m."""
    drop: float
    """Depth of the corner below the centre, m."""
    corner: Corner
    """State of the corner for the next step."""
    opened: float
    """Energy released by the normal spring, over half its stiffness, m²."""
    shortened: float
    """Energy released by the tangential spring, over half its stiffness, m²."""
    damping: float
    """Normal force without the spring, m/s²."""
    sliding: float
    """Tangential force without the spring, m/s²."""


@njit(**INLINE)
def act(
    side: float, block: Block, s: BlockState, old: Corner, rate: float, flat: tuple[bool, bool, float]
) -> CornerForce:
    """Apply the contact law at a corner; `rate` is the dashpot over the step, so that it multiplies displacements.

    `flat` holds whether the block lands flat, and the two results of `flat_landing_slip`.
    """
    held, drifts, drift = flat
    arm, drop = arm_of(side, block, s.cos, s.sin)
    place, depth = s.x + arm, drop - s.z
    slip, sinking = place - old.place, depth - old.depth
    inside, was = depth > 0.0, old.depth > 0.0
    # Spring and dashpot while the corner is in contact; no tension except in a flat landing.
    n = block.stiffness * depth + rate * sinking
    n = n if inside & (held | (n > 0.0)) else 0.0
    # A new contact starts with an unstretched spring; slip shortens the spring to the force that friction can hold.
    stretch = old.spring + slip if was else 0.0
    most = block.friction * n
    whole = -(block.tangential * stretch) - rate * slip
    slips = drifts if held else abs(whole) > most
    f = -drift * n if drifts else (clamp(whole, most) if slips else whole)
    remaining = clamp(stretch, (most if most > 0.0 else 0.0) * block.compliance) if slips else stretch
    let_go = old.depth if was & (not inside) else 0.0
    return CornerForce(
        n=n, f=f, arm=arm, drop=drop,
        corner=Corner(remaining, place, depth, 0.0), opened=let_go * let_go,
        shortened=(old.spring + remaining) * (stretch - remaining),
        damping=n - block.stiffness * (depth if inside else 0.0), sliding=f + block.tangential * remaining,
    )  # fmt: skip


@njit(**INLINE)
def lost_at(corner: CornerForce, vx: float, vz: float, vw: float) -> float:
    """Return the power of dashpots and friction of a corner on the block, per mass, m²/s³; negative for losses."""
    return corner.damping * (vz - corner.arm * vw) + corner.sliding * (vx - corner.drop * vw)


@njit(**INLINE)
def step(
    block: Block, s: BlockState, peaks: BlockPeaks, account: BlockAccount, shaking: BlockShaking, vertical: bool
) -> tuple[BlockState, BlockPeaks, BlockAccount]:
    """Compute one step of one block."""
    dt = block.step * WHOLE
    push, lift = within_sample(shaking.push, s.tick), within_sample(shaking.lift, s.tick)
    rate = block.dashpot / dt
    (_, drop_left), (_, drop_right) = arm_of(-1.0, block, s.cos, s.sin), arm_of(1.0, block, s.cos, s.sin)
    held = lands_flat(s, drop_left - s.z, drop_right - s.z)
    flat = (held, *flat_landing_slip(block, held, s.vx, s.vz))
    left, right = act(-1.0, block, s, s.left, rate, flat), act(1.0, block, s, s.right, rate, flat)
    # Accelerations in the frame of the base; left and right corner as one pair.
    ax, az = (left.f + right.f) + push, (left.n + right.n) - (GRAVITY + lift if vertical else GRAVITY)
    aw = block.inertia * ((-left.drop * left.f - left.arm * left.n) + (-right.drop * right.f - right.arm * right.n))
    # The energy account uses the velocities at the whole step.
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
    c, sn = rotate_pair(s.cos, s.sin, turn)
    x, z, angle = s.x + dt * vx, s.z + dt * vz, s.angle + turn
    peaks = BlockPeaks(
        larger(peaks.angle, abs(angle)),
        larger(peaks.slip, abs(base_slip(block, x, sn))),
        larger(peaks.depth, left.corner.depth if left.corner.depth > right.corner.depth else right.corner.depth),
        select(abs(angle) < block.alpha, tick, peaks.last_upright),
    )
    moved = BlockState(
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
        landing=remaining_landing(block, s, dt),
    )
    return moved, peaks, BlockAccount(account.work + dt * power, lost, 0.0, 0.0)
