"""Third part of a step of the centred scheme: forces at the solution, cut to their limits, and the new state."""

import math

from numba import njit

from overturning.dem.block.state import (
    GENTLE_STEPS,
    Account,
    Block,
    Change,
    Corner,
    Corners,
    Corrected,
    Given,
    Kept,
    Peaks,
    Predicted,
    PredictedCorner,
    State,
    Taken,
    base_slip,
    landing_of,
)
from overturning.dem.kernel.clock import Clock, Found
from overturning.dem.kernel.lanes import INLINE
from overturning.dem.kernel.mechanics import larger, within
from overturning.units import STANDARD_GRAVITY as GRAVITY


@njit(**INLINE)
def correct(
    block: Block, w: Predicted, r: PredictedCorner, old: Corner, given: Given, d: Change, with_friction: bool
) -> Corrected:
    """Forces of a corner at the solution, within their limits.

    What the solution adds to the velocities moves the block by half a step of it. A corner that it has just pushed out
    again has touched the base all the same. (A corner in the air "slips"; nothing asks which way.)
    """
    du, dw = d.vx - r.drop * d.vw, d.vz - r.arm * d.vw
    ux, uz = r.ux + du, r.uz + dw
    half = w.half
    depth, stretch, place = r.depth - half * dw, r.stretch + half * du, (w.x + r.arm) + half * du
    inside, was = depth > 0.0, old.depth > 0.0
    changed = r.depth if r.depth > depth else depth
    changed = -depth if was else changed
    # Never tension, but in a flat landing.
    spring = block.stiffness * depth if inside else 0.0
    n = spring - block.dashpot * uz
    n = n if given.held | (n > 0.0) else 0.0
    n = n if inside else 0.0
    # Friction; the spring of a corner that slips is shortened to what it holds.
    most = block.friction * n
    f = block.tangential * stretch + block.dashpot * ux
    sign, slips = math.copysign(block.friction, f), abs(f) > most
    sign, slips = (given.drift, given.drifts) if given.held else (sign, slips)
    found, taken = sign if slips else 0.0, 0.0 if given.fine else given.slid
    f = sign * n if slips else f
    kept = within(stretch, (most if most > 0.0 else 0.0) * block.compliance) if slips else stretch
    damping, sliding = (spring - n) * uz, (f - block.tangential * kept) * ux
    sinking = depth - old.depth
    cut = depth * old.depth
    cut = math.copysign(cut if cut < 0.0 else 0.0, sinking)
    fresh, loaded = inside & (not was), most > 0.0
    moment, let_go = r.drop * f - r.arm * n, (old.spring + kept) * (stretch - kept)
    return Corrected(
        corner=Corner(kept, place, depth, n),
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
        wrong=(found != taken) & loaded,
        reversed=(taken * ux < 0.0) & loaded,
        back=(found * old.spring < 0.0) & loaded,
    )


@njit(**INLINE)
def found_of(block: Block, clock: Clock, length: float, fine: bool, both: Corners, with_friction: bool) -> Found:
    """What an attempt at a step has found, for the clock."""
    left, right = both.left, both.right
    changed = (left.changed if left.changed > right.changed else right.changed) > 0.0
    far = left.far if left.far > right.far else right.far
    gentle = (far <= block.gentle) & (length <= GENTLE_STEPS * clock.finest)
    stands = (left.corner.normal > 0.0) & (right.corner.normal > 0.0)
    if not with_friction:
        return Found(
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
    return Found(
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
def taken_next(taken: Taken, fine: bool, both: Corners, retry: bool, sooner: bool) -> Taken:
    """What the corners are taken to do in the next attempt: as found; in a retry a corner taken rightly stays so."""
    of_left, of_right = (0.0 if fine else taken.left), (0.0 if fine else taken.right)
    left, right = both.left, both.right
    keeps_left, keeps_right = sooner | (retry & (not left.wrong)), sooner | (retry & (not right.wrong))
    return Taken(of_left if keeps_left else left.found, of_right if keeps_right else right.found)


@njit(**INLINE)
def acting(half: float, one: Corrected, other: Corrected) -> float:
    """By how much longer than half the step a contact acts that closed within it; one division for both corners."""
    inverse = 2.0 * half / (one.sunk * other.sunk)
    time = one.corner.depth * (inverse * other.sunk) - half
    return time if one.fresh else 0.0


@njit(**INLINE)
def commit(
    block: Block, kept: Kept, w: Predicted, d: Change, both: Corners, length: float, vertical: bool, with_friction: bool
) -> Kept:
    """Forces at the end of the step, within their limits, what they do, and the energy account."""
    (s, peaks, account), (left, right) = kept, both
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
    # Work of the shaking, loss in dashpots, sliders and contacts that open or close within the step.
    power, loss = w.push * vx - w.lift * vz if vertical else w.push * vx, left.loss + right.loss
    springs = block.tangential * (left.let_go + right.let_go) + block.stiffness * (left.cut + right.cut)
    lost = account.lost + ((half * (account.loss + loss) + (pl * left.loss + pr * right.loss)) + 0.5 * springs)
    peaks = Peaks(
        larger(peaks.angle, abs(angle)),
        larger(peaks.slip, abs(base_slip(block, x, sn))),
        larger(peaks.depth, left.corner.depth if left.corner.depth > right.corner.depth else right.corner.depth),
        tick if abs(angle) < block.alpha else peaks.last_upright,
    )
    account = Account(account.work + half * (account.power + power), lost, power, loss)
    landing = landing_of(block, s, 2.0 * half)
    state = State(
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
    return Kept(state, peaks, account)
