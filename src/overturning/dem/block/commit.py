"""Third part of a step of the centred scheme for a block: forces at the solution within limits, and the new state."""

import math

from numba import njit

from overturning.dem.block.state import (
    GENTLE_STEPS,
    AcceptedStep,
    AssumedCorner,
    AssumedSlip,
    Block,
    BlockAccount,
    BlockChange,
    BlockPeaks,
    BlockState,
    Corner,
    Corners,
    Corrected,
    PredictedBlock,
    PredictedCorner,
    base_slip,
    remaining_landing,
)
from overturning.dem.kernel.clock import Clock, StepFindings
from overturning.dem.kernel.lanes import INLINE
from overturning.dem.kernel.mechanics import clamp, larger
from overturning.units import STANDARD_GRAVITY as GRAVITY


@njit(**INLINE)
def correct(
    block: Block,
    w: PredictedBlock,
    r: PredictedCorner,
    old: Corner,
    assumption: AssumedCorner,
    d: BlockChange,
    with_friction: bool,
) -> Corrected:
    """Compute the state of a corner at the solution, with forces within their limits.

    Velocity corrections act on the position over half a step. A corner that the solution pushes out again has touched
    the base. (A corner in the air counts as slipping; its direction is never used.)
    """
    du, dw = d.vx - r.drop * d.vw, d.vz - r.arm * d.vw
    ux, uz = r.ux + du, r.uz + dw
    half = w.half
    depth, stretch, place = r.depth - half * dw, r.stretch + half * du, (w.x + r.arm) + half * du
    inside, was = depth > 0.0, old.depth > 0.0
    changed = r.depth if r.depth > depth else depth
    changed = -depth if was else changed
    # No tension except in a flat landing.
    spring = block.stiffness * depth if inside else 0.0
    n = spring - block.dashpot * uz
    n = n if assumption.held | (n > 0.0) else 0.0
    n = n if inside else 0.0
    # Friction; the spring of a slipping corner is shortened to the force that friction can hold.
    most = block.friction * n
    f = block.tangential * stretch + block.dashpot * ux
    sign, slips = math.copysign(block.friction, f), abs(f) > most
    sign, slips = (assumption.drift, assumption.drifts) if assumption.held else (sign, slips)
    found, assumed = sign if slips else 0.0, 0.0 if assumption.fine else assumption.slid
    f = sign * n if slips else f
    remaining = clamp(stretch, (most if most > 0.0 else 0.0) * block.compliance) if slips else stretch
    damping, sliding = (spring - n) * uz, (f - block.tangential * remaining) * ux
    sinking = depth - old.depth
    cut = depth * old.depth
    cut = math.copysign(cut if cut < 0.0 else 0.0, sinking)
    fresh, loaded = inside & (not was), most > 0.0
    moment, let_go = r.drop * f - r.arm * n, (old.spring + remaining) * (stretch - remaining)
    return Corrected(
        corner=Corner(remaining, place, depth, n),
        f=f,
        moment=moment if with_friction else -(r.arm * n),
        loss=damping + sliding if with_friction else damping,
        let_go=let_go if with_friction else 0.0,
        cut=cut,
        fresh=fresh,
        sunk=sinking if fresh else 1.0,
        changed=changed,
        far=abs(sinking) if changed > 0.0 else 0.0,
        found=found,
        wrong=(found != assumed) & loaded,
        reversed=(assumed * ux < 0.0) & loaded,
        back=(found * old.spring < 0.0) & loaded,
    )


@njit(**INLINE)
def step_findings(
    block: Block, clock: Clock, length: float, fine: bool, both: Corners, with_friction: bool
) -> StepFindings:
    """Return the findings of an attempted step for the clock."""
    left, right = both.left, both.right
    changed = (left.changed if left.changed > right.changed else right.changed) > 0.0
    far = left.far if left.far > right.far else right.far
    gentle = (far <= block.gentle) & (length <= GENTLE_STEPS * clock.finest)
    stands = (left.corner.normal > 0.0) & (right.corner.normal > 0.0)
    if not with_friction:
        return StepFindings(
            changed=changed,
            fast=False,
            gentle=gentle,
            wrong=False,
            reversed=False,
            back=False,
            slides=False,
            stands=stands,
        )
    wrong, back = (left.wrong | right.wrong) & (not fine), (left.back | right.back) & (not fine)
    slides = (left.found != 0.0) & (right.found != 0.0) & (left.corner.normal + right.corner.normal > 0.0)
    return StepFindings(
        changed=changed,
        fast=False,
        gentle=gentle,
        wrong=wrong,
        reversed=left.reversed | right.reversed,
        back=back,
        slides=slides,
        stands=stands,
    )


@njit(**INLINE)
def next_assumed_slip(assumed: AssumedSlip, fine: bool, both: Corners, retry: bool, sooner: bool) -> AssumedSlip:
    """Return the slip directions to assume in the next attempt: those found, or in a retry the correct old ones."""
    of_left, of_right = (0.0 if fine else assumed.left), (0.0 if fine else assumed.right)
    left, right = both.left, both.right
    keeps_left, keeps_right = sooner | (retry & (not left.wrong)), sooner | (retry & (not right.wrong))
    return AssumedSlip(of_left if keeps_left else left.found, of_right if keeps_right else right.found)


@njit(**INLINE)
def acting(half: float, one: Corrected, other: Corrected) -> float:
    """Return the time beyond half of the step during which a contact that closed within it acts, s.

    One division serves both corners.
    """
    inverse = 2.0 * half / (one.sunk * other.sunk)
    time = one.corner.depth * (inverse * other.sunk) - half
    return time if one.fresh else 0.0


@njit(**INLINE)
def commit(
    block: Block,
    old: AcceptedStep,
    w: PredictedBlock,
    d: BlockChange,
    both: Corners,
    length: float,
    vertical: bool,
    with_friction: bool,
) -> AcceptedStep:
    """Compute the state, peaks and energy account at the end of the step."""
    (s, peaks, account), (left, right) = old, both
    half, turn, tick = w.half, w.half * d.vw, s.tick + length
    x, z, angle = w.x + half * d.vx, w.z + half * d.vz, w.angle + turn
    c, sn = w.cos - w.sin * turn, w.sin + w.cos * turn
    nl, nr = left.corner.normal, right.corner.normal
    ax, az = w.push - (left.f + right.f) if with_friction else w.push, (nl + nr) - (GRAVITY + w.lift)
    aw = block.inertia * (left.moment + right.moment)
    vx, vz, vw = w.vx + half * ax, w.vz + half * az, w.vw + half * aw
    pl, pr = acting(half, left, right), acting(half, right, left)
    vx = vx - (pl * left.f + pr * right.f) if with_friction else vx
    vz, vw = vz + (pl * nl + pr * nr), vw + block.inertia * (pl * left.moment + pr * right.moment)
    # Work of the base motion; loss in dashpots, friction, and contacts that open or close within the step.
    power, loss = w.push * vx - w.lift * vz if vertical else w.push * vx, left.loss + right.loss
    springs = block.tangential * (left.let_go + right.let_go) + block.stiffness * (left.cut + right.cut)
    lost = account.lost + ((half * (account.loss + loss) + (pl * left.loss + pr * right.loss)) + 0.5 * springs)
    peaks = BlockPeaks(
        larger(peaks.angle, abs(angle)),
        larger(peaks.slip, abs(base_slip(block, x, sn))),
        larger(peaks.depth, left.corner.depth if left.corner.depth > right.corner.depth else right.corner.depth),
        tick if abs(angle) < block.alpha else peaks.last_upright,
    )
    account = BlockAccount(account.work + half * (account.power + power), lost, power, loss)
    landing = remaining_landing(block, s, 2.0 * half)
    state = BlockState(
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
        landing=landing,
    )
    return AcceptedStep(state, peaks, account)
