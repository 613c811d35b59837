"""The centred scheme: the trapezoidal rule with springs and dashpots taken at the end of the step (docs/method.md).

From top to bottom the step of ONE block: `predict`, `solve`, `commit`, as under "`centred`" there, each with what it
does at a corner above it. `overturning.dem.block.loops` goes over the blocks.

Signs: a corner's penetration u and its upward velocity u̇_z give n = K u − h u̇_z upwards, its stretch t and
velocity u̇_x along s give f = K_s t + h u̇_x against s. Left and right corner are summed as one pair, which makes the
mirrored case exact.
"""

import math
from typing import Final

from numba import njit

from overturning.dem.block.state import (
    GENTLE_STEPS,
    Account,
    Block,
    Change,
    Contribution,
    Corner,
    Corners,
    Corrected,
    Drift,
    Given,
    Kept,
    Peaks,
    Predicted,
    PredictedCorner,
    Shaking,
    Sliding,
    State,
    Taken,
    arm_of,
    base_slip,
    drift_of,
    landing_of,
    lands_flat,
)
from overturning.dem.kernel.clock import BLOCK, Clock, Found
from overturning.dem.kernel.ground import at_tick
from overturning.dem.kernel.lanes import INLINE
from overturning.dem.kernel.mechanics import larger, turned, within
from overturning.units import STANDARD_GRAVITY as GRAVITY

FINE: Final = BLOCK.fine

LEAST_FREEDOM: Final = 0.25
"""A corner sticks where sliding would leave less than this share of a normal force's effect on a free particle."""


# 1. Predict -----------------------------------------------------------------------------------------------------------


@njit(**INLINE)
def predict_corner(side: float, block: Block, old: Corner, at: Drift) -> PredictedCorner:
    """A corner at the predicted position and velocities; a new contact starts with an unstretched spring."""
    arm, drop = arm_of(side, block, at.cos, at.sin)
    stretch = old.spring + ((at.x + arm) - old.place)
    stretch = stretch if old.depth > 0.0 else 0.0
    return PredictedCorner(arm, drop, drop - at.z, stretch, at.vx - drop * at.vw, at.vz - arm * at.vw)


@njit(**INLINE)
def predict(block: Block, s: State, length: float, shaking: Shaking, ticks: float) -> Predicted:
    """The block and its corners at the end of a step, were the acceleration to stay; a sample has so many `ticks`."""
    dt, tick = block.step * length, s.tick + length
    half = 0.5 * dt
    kx, kz, kw = half * s.ax, half * s.az, half * s.aw
    vx, vz, vw = s.vx + kx, s.vz + kz, s.vw + kw
    ex, ez, ew = vx + kx, vz + kz, vw + kw
    turn = dt * vw
    c, sn = turned(s.cos, s.sin, turn)
    x, z = s.x + dt * vx, s.z + dt * vz
    past = tick - ticks
    past = past if past > 0.0 else 0.0
    at = Drift(x, z, c, sn, ex, ez, ew)
    left, right = predict_corner(-1.0, block, s.left, at), predict_corner(1.0, block, s.right, at)
    push, lift = at_tick(shaking.push, tick, past), at_tick(shaking.lift, tick, past)
    return Predicted(x, z, s.angle + turn, c, sn, vx, vz, vw, ex, ez, ew, push, lift, half, left, right)


# 2. Solve -------------------------------------------------------------------------------------------------------------


@njit(**INLINE)
def in_contact(block: Block, r: PredictedCorner, old: Corner, fine: bool, held: bool) -> tuple[float, bool]:
    """Normal force as predicted, and whether the corner is in contact.

    In a fine step the predicted force decides. A longer one overshoots too far for that: there it is as last found.
    """
    n = block.stiffness * r.depth - block.dashpot * r.uz
    return n, ((held | (n > 0.0)) & (r.depth > 0.0)) | ((not fine) & (old.normal != 0.0))


@njit(**INLINE)
def guess(block: Block, r: PredictedCorner, n: float, given: Given) -> Sliding:
    """Whether a corner would slide, and which way: in fine steps as predicted, in long ones as last found.

    A long step in which that proves wrong is done again. A normal force on a sliding corner must push it out. Where
    friction would turn the block in instead (Painlevé's paradox, from μ = 4/3 on), the corner sticks. In a flat landing
    both slide or stick as one, as of `drift_of`.
    """
    slid, fine = given.slid, given.fine
    f = block.tangential * r.stretch + block.dashpot * r.ux
    excess = abs(f) - block.friction * n if fine else abs(slid)
    slid = math.copysign(block.friction, f) if fine else slid
    slides, slid = (given.drifts, given.drift) if given.held else (excess > 0.0, slid)
    freedom = 1.0 + block.inertia * r.arm * (r.arm - slid * r.drop)
    return Sliding(f, slides, slid, freedom > LEAST_FREEDOM)


@njit(**INLINE)
def sliding_of(one: Sliding, other: Sliding, other_in_contact: bool) -> tuple[float, bool]:
    """±μ of a corner that slides, and whether it does.

    One that is not free to slide sticks, unless the other one sticks and it can only turn out.
    """
    free = one.free | (other_in_contact & (not other.slides))
    return (one.slid if free else 0.0), one.slides & free


@njit(**INLINE)
def normal_contribution(block: Block, r: PredictedCorner, half: float, n: float, on: bool) -> tuple[float, float]:
    """Normal force at rest at the end of the step, and what the velocity there adds."""
    normal = block.dashpot + half * block.stiffness
    return (n + normal * r.uz if on else 0.0), (half * normal if on else 0.0)


@njit(**INLINE)
def contribution(
    block: Block, r: PredictedCorner, half: float, n: float, on: bool, f: float, slides: bool, slid: float
) -> Contribution:
    """A corner's part in the equations: a sliding one carries ±μ times its normal force."""
    n, press = normal_contribution(block, r, half, n, on)
    tangential = block.dashpot + half * block.tangential
    sticks = on & (not slides)
    f = f - tangential * r.ux if sticks else slid * n
    return Contribution(n, f, press, half * tangential if sticks else 0.0, slid * press if slides else 0.0)


@njit(**INLINE)
def solve(block: Block, s: State, taken: Taken, fine: bool, w: Predicted) -> Change:
    """Velocities at the end of the step, with springs and dashpots of the corners in contact taken there.

    The three equations are solved by elimination without a pivot: the matrix is 1 plus something that only adds, but
    for sliding corners, which stick before they take too much away.
    """
    half, inertia, left, right = w.half, block.inertia, w.left, w.right
    held = lands_flat(s, left.depth, right.depth)
    nl, on_l = in_contact(block, left, s.left, fine, held)
    nr, on_r = in_contact(block, right, s.right, fine, held)
    # A corner in the air carries nothing, so whether it slid is not known from the last step.
    drifts, drift = drift_of(block, held, w.ex, w.ez)
    guess_l = guess(block, left, nl, Given(taken.left, fine | (s.left.normal == 0.0), held, drifts, drift))
    guess_r = guess(block, right, nr, Given(taken.right, fine | (s.right.normal == 0.0), held, drifts, drift))
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
    return Change(ex - w.ex, ez - w.ez, ew - w.ew, slid_l, slid_r)


@njit(**INLINE)
def solve_smooth(block: Block, s: State, taken: Taken, fine: bool, w: Predicted) -> Change:  # noqa: ARG001
    """The same without friction, where heave and rotation stand alone."""
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
    return Change(ex - w.ex, ez - w.ez, ew - w.ew, 0.0, 0.0)


# 3. Commit ------------------------------------------------------------------------------------------------------------


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
        Corner(kept, place, depth, n), f, moment if with_friction else -(r.arm * n),
        damping + sliding if with_friction else damping, let_go if with_friction else 0.0, cut,
        fresh, sinking if fresh else 1.0, changed, abs(sinking) if changed > 0.0 else 0.0,
        found, (found != taken) & loaded, (taken * ux < 0.0) & loaded, (found * old.spring < 0.0) & loaded,
    )  # fmt: skip


@njit(**INLINE)
def found_of(block: Block, clock: Clock, length: float, fine: bool, both: Corners, with_friction: bool) -> Found:
    """What an attempt at a step has found, for the clock."""
    left, right = both.left, both.right
    changed = (left.changed if left.changed > right.changed else right.changed) > 0.0
    far = left.far if left.far > right.far else right.far
    gentle = (far <= block.gentle) & (length <= GENTLE_STEPS * clock.finest)
    stands = (left.corner.normal > 0.0) & (right.corner.normal > 0.0)
    if not with_friction:
        return Found(changed, False, gentle, False, False, False, False, stands)
    wrong, back = (left.wrong | right.wrong) & (not fine), (left.back | right.back) & (not fine)
    slides = (left.found != 0.0) & (right.found != 0.0) & (left.corner.normal + right.corner.normal > 0.0)
    return Found(changed, False, gentle, wrong, left.reversed | right.reversed, back, slides, stands)


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
    state = State(x, z, angle, c, sn, vx, vz, vw, ax, az, aw, left.corner, right.corner, tick, landing)
    return Kept(state, peaks, account)
