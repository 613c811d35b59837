"""The centred scheme for a block: trapezoidal rule, springs and dashpots at the end of the step (docs/method.md).

The step of one block has three parts, as in docs/method.md: `predict` and `solve` are here, `correct` and `commit` in
`overturning.dem.block.commit`. `overturning.dem.block.loops` has the loops over the blocks.

Signs: a corner's penetration u and its upward velocity u̇_z give n = K u − h u̇_z upwards, its stretch t and
velocity u̇_x along s give f = K_s t + h u̇_x against s. Left and right corner are summed as one pair, which makes the
mirrored case exact.
"""

import math
from typing import Final

from numba import njit

from overturning.dem.block.state import (
    AssumedCorner,
    AssumedSlip,
    Block,
    BlockChange,
    BlockShaking,
    BlockState,
    Contribution,
    Corner,
    Drift,
    PredictedBlock,
    PredictedCorner,
    Sliding,
    arm_of,
    flat_landing_slip,
    lands_flat,
)
from overturning.dem.kernel.clock import BLOCK
from overturning.dem.kernel.ground import at_tick
from overturning.dem.kernel.lanes import INLINE
from overturning.dem.kernel.mechanics import rotate_pair
from overturning.units import STANDARD_GRAVITY as GRAVITY

FINE: Final = BLOCK.fine

LEAST_FREEDOM: Final = 0.25
"""Least effect of a normal force on a sliding corner, as a share of its effect on a free particle; below, it sticks."""


# 1. Predict -----------------------------------------------------------------------------------------------------------


@njit(**INLINE)
def predict_corner(side: float, block: Block, old: Corner, at: Drift) -> PredictedCorner:
    """Predict the state of a corner; a new contact starts with an unstretched spring."""
    arm, drop = arm_of(side, block, at.cos, at.sin)
    stretch = old.spring + ((at.x + arm) - old.place)
    stretch = stretch if old.depth > 0.0 else 0.0
    return PredictedCorner(arm, drop, drop - at.z, stretch, at.vx - drop * at.vw, at.vz - arm * at.vw)


@njit(**INLINE)
def predict(block: Block, s: BlockState, length: float, shaking: BlockShaking, ticks: float) -> PredictedBlock:
    """Predict block and corners at the end of a step with constant acceleration; `ticks` is the length of a sample."""
    dt, tick = block.step * length, s.tick + length
    half = 0.5 * dt
    kx, kz, kw = half * s.ax, half * s.az, half * s.aw
    vx, vz, vw = s.vx + kx, s.vz + kz, s.vw + kw
    ex, ez, ew = vx + kx, vz + kz, vw + kw
    turn = dt * vw
    c, sn = rotate_pair(s.cos, s.sin, turn)
    x, z = s.x + dt * vx, s.z + dt * vz
    past = tick - ticks
    past = past if past > 0.0 else 0.0
    at = Drift(x, z, c, sn, ex, ez, ew)
    left, right = predict_corner(-1.0, block, s.left, at), predict_corner(1.0, block, s.right, at)
    push, lift = at_tick(shaking.push, tick, past), at_tick(shaking.lift, tick, past)
    return PredictedBlock(
        x=x,
        z=z,
        angle=s.angle + turn,
        cos=c,
        sin=sn,
        vx=vx,
        vz=vz,
        vw=vw,
        ex=ex,
        ez=ez,
        ew=ew,
        push=push,
        lift=lift,
        half=half,
        left=left,
        right=right,
    )


# 2. Solve -------------------------------------------------------------------------------------------------------------


@njit(**INLINE)
def in_contact(block: Block, r: PredictedCorner, old: Corner, fine: bool, held: bool) -> tuple[float, bool]:
    """Return the predicted normal force per mass (m/s²), and whether the corner is in contact.

    In a fine step the predicted force decides. In a longer step it overshoots too far; the last state is used.
    """
    n = block.stiffness * r.depth - block.dashpot * r.uz
    return n, ((held | (n > 0.0)) & (r.depth > 0.0)) | ((not fine) & (old.normal != 0.0))


@njit(**INLINE)
def guess(block: Block, r: PredictedCorner, n: float, assumption: AssumedCorner) -> Sliding:
    """Return whether a corner would slide, and in which direction: as predicted in fine steps, else as in the last one.

    A long step for which this proves wrong is repeated. A normal force on a sliding corner must push it out; where
    friction would rotate the block further in instead (Painlevé's paradox, possible from μ = 4/3), the corner sticks.
    In a flat landing both corners slide or stick together (`flat_landing_slip`).
    """
    slid, fine = assumption.slid, assumption.fine
    f = block.tangential * r.stretch + block.dashpot * r.ux
    excess = abs(f) - block.friction * n if fine else abs(slid)
    slid = math.copysign(block.friction, f) if fine else slid
    slides, slid = (assumption.drifts, assumption.drift) if assumption.held else (excess > 0.0, slid)
    freedom = 1.0 + block.inertia * r.arm * (r.arm - slid * r.drop)
    return Sliding(f, slides, slid, freedom > LEAST_FREEDOM)


@njit(**INLINE)
def sliding_of(one: Sliding, other: Sliding, other_in_contact: bool) -> tuple[float, bool]:
    """Return ±μ of a corner that slides, and whether it slides.

    A corner that is not free to slide sticks, unless the other corner sticks: then it can only rotate out.
    """
    free = one.free | (other_in_contact & (not other.slides))
    return (one.slid if free else 0.0), one.slides & free


@njit(**INLINE)
def normal_contribution(block: Block, r: PredictedCorner, half: float, n: float, on: bool) -> tuple[float, float]:
    """Return the normal force for zero velocity at the end of the step, and its coefficient of that velocity."""
    normal = block.dashpot + half * block.stiffness
    return (n + normal * r.uz if on else 0.0), (half * normal if on else 0.0)


@njit(**INLINE)
def contribution(
    block: Block, r: PredictedCorner, half: float, n: float, on: bool, f: float, slides: bool, slid: float
) -> Contribution:
    """Return a corner's contribution to the equations; a sliding corner has ±μ times its normal force as friction."""
    n, press = normal_contribution(block, r, half, n, on)
    tangential = block.dashpot + half * block.tangential
    sticks = on & (not slides)
    f = f - tangential * r.ux if sticks else slid * n
    return Contribution(n, f, press, half * tangential if sticks else 0.0, slid * press if slides else 0.0)


@njit(**INLINE)
def solve(block: Block, s: BlockState, assumed: AssumedSlip, fine: bool, w: PredictedBlock) -> BlockChange:
    """Solve for the velocities at the end of the step, with springs and dashpots of closed corners evaluated there.

    The three equations are solved by elimination without pivoting: the matrix is the identity plus a positive part,
    except for sliding corners, which are made to stick before they reduce it too much.
    """
    half, inertia, left, right = w.half, block.inertia, w.left, w.right
    held = lands_flat(s, left.depth, right.depth)
    nl, on_l = in_contact(block, left, s.left, fine, held)
    nr, on_r = in_contact(block, right, s.right, fine, held)
    # A corner in the air has no force, so the last step does not tell whether it slid.
    drifts, drift = flat_landing_slip(block, held, w.ex, w.ez)
    guess_l = guess(block, left, nl, AssumedCorner(assumed.left, fine | (s.left.normal == 0.0), held, drifts, drift))
    guess_r = guess(block, right, nr, AssumedCorner(assumed.right, fine | (s.right.normal == 0.0), held, drifts, drift))
    slid_l, slides_l = sliding_of(guess_l, guess_r, on_r)
    slid_r, slides_r = sliding_of(guess_r, guess_l, on_l)
    p = contribution(block, left, half, nl, on_l, guess_l.f, slides_l, slid_l)
    q = contribution(block, right, half, nr, on_r, guess_r.f, slides_r, slid_r)
    hx = w.vx + half * (w.push - (p.f + q.f))
    hz = w.vz + half * ((p.n + q.n) - (GRAVITY + w.lift))
    hw = w.vw + half * (inertia * ((left.drop * p.f - left.arm * p.n) + (right.drop * q.f - right.arm * q.n)))
    wl, wr = p.press * left.arm, q.press * right.arm
    el, er = p.slide * left.drop - wl, q.slide * right.drop - wr
    gl, gr = p.stick * left.drop, q.stick * right.drop
    lever = gl + gr
    a11, a12, a13 = 1.0 + (p.stick + q.stick), -(p.slide + q.slide), (q.slide * right.arm + p.slide * left.arm) - lever
    a22, a23 = 1.0 + (p.press + q.press), -(wl + wr)
    a31, a32 = inertia * lever, inertia * (el + er)
    a33 = 1.0 + inertia * ((gl * left.drop - el * left.arm) + (gr * right.drop - er * right.arm))
    both, first, second = a11 * a22, a31 * a22, a32 * a11 + a31 * a12
    last = (a33 * both + first * a13) - second * a23
    inverse = 1.0 / (both * last)
    ew = ((hw * both + first * hx) - second * hz) * (inverse * both)
    inverse = inverse * last
    ez = (hz - a23 * ew) * (inverse * a11)
    ex = ((hx - a12 * ez) - a13 * ew) * (inverse * a22)
    return BlockChange(ex - w.ex, ez - w.ez, ew - w.ew, slid_l, slid_r)


@njit(**INLINE)
def solve_smooth(
    block: Block,
    s: BlockState,
    assumed: AssumedSlip,  # noqa: ARG001, as `solve`
    fine: bool,
    w: PredictedBlock,
) -> BlockChange:
    """Solve for the velocities without friction, where the horizontal motion is independent; see `solve`."""
    half, inertia, left, right = w.half, block.inertia, w.left, w.right
    held = lands_flat(s, left.depth, right.depth)
    nl, on_l = in_contact(block, left, s.left, fine, held)
    nr, on_r = in_contact(block, right, s.right, fine, held)
    nl, press_l = normal_contribution(block, left, half, nl, on_l)
    nr, press_r = normal_contribution(block, right, half, nr, on_r)
    ex = w.vx + half * w.push
    hz = w.vz + half * ((nl + nr) - (GRAVITY + w.lift))
    hw = w.vw - half * (inertia * (left.arm * nl + right.arm * nr))
    wl, wr = press_l * left.arm, press_r * right.arm
    a22, a23 = 1.0 + (press_l + press_r), -(wl + wr)
    a32, a33 = inertia * a23, 1.0 + inertia * (wl * left.arm + wr * right.arm)
    last = a33 * a22 - a32 * a23
    inverse = 1.0 / (a22 * last)
    ew = (hw * a22 - a32 * hz) * (inverse * a22)
    ez = (hz - a23 * ew) * (inverse * last)
    return BlockChange(ex - w.ex, ez - w.ez, ew - w.ew, 0.0, 0.0)
