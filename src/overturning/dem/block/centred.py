"""The centred scheme: the trapezoidal rule with springs and dashpots taken at the end of the step (docs/method.md).

From top to bottom the step of ONE block: `foresee`, `solve`, `commit`, as under "`centred`" there, each with what it does at a
corner above it. The last function lays blocks side by side: three loops, for speed alone. The chain of dependent operations of a
whole step is longer than what a processor looks ahead, that of a third of it is not.

Signs: a corner's penetration u and its upward velocity u̇_z give n = K u − h u̇_z upwards, its stretch t and velocity u̇_x
along s give f = K_s t + h u̇_x against s. Left and right corner are summed as one pair, which makes the mirrored case exact.
"""

import math
from functools import cache
from typing import Any, Final, NamedTuple

from numba import njit

from overturning.dem.block.state import (
    GENTLE_STEPS,
    ROWS,
    Account,
    Block,
    Change,
    Corner,
    Foreseen,
    ForeseenCorner,
    Met,
    Peaks,
    Shaking,
    Share,
    Sliding,
    State,
    Taken,
    arm_of,
    base_slip,
)
from overturning.dem.kernel.clock import BLOCK, Attempt, Clock, Found, next_attempt
from overturning.dem.kernel.ground import at_tick
from overturning.dem.kernel.lanes import INLINE, OPTIONS
from overturning.dem.kernel.mechanics import larger, turned, within
from overturning.units import STANDARD_GRAVITY as GRAVITY

PREDICTED: Final = BLOCK.predicted

LEAST_FREEDOM: Final = 0.25
"""A sliding corner jams where less than this share of a normal force's effect on a free particle is left."""


class Centred(NamedTuple):
    """What the kernel has to know of the scheme."""

    lag: float = 0.0
    """Steps by which velocities lag behind positions;"""
    ahead: int = 1
    """steps that may follow those of a whole sample before the shaking of the next but one is needed."""


# 1. Foresee -----------------------------------------------------------------------------------------------------------


@njit(**INLINE)
def foresee_corner(
    side: float, block: Block, old: Corner, x: float, z: float, c: float, s: float, ex: float, ez: float, ew: float
) -> ForeseenCorner:
    """A corner at the foreseen position and velocities; a new contact starts with an unstretched spring."""
    arm, drop = arm_of(side, block, c, s)
    stretch = old.spring + ((x + arm) - old.place)
    return ForeseenCorner(
        arm, drop, drop - z, stretch if old.depth > 0.0 else 0.0, ex - drop * ew, ez - arm * ew
    )  # fmt: skip


@njit(**INLINE)
def foresee(block: Block, s: State, length: float, shaking: Shaking, ticks: float) -> Foreseen:
    """Drift with the last acceleration: where the block and its corners would be without a change, after `ticks` per sample."""
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
    left = foresee_corner(-1.0, block, s.left, x, z, c, sn, ex, ez, ew)
    right = foresee_corner(1.0, block, s.right, x, z, c, sn, ex, ez, ew)
    push, lift = at_tick(shaking.push, tick, past), at_tick(shaking.lift, tick, past)
    return Foreseen(x, z, s.angle + turn, c, sn, vx, vz, vw, ex, ez, ew, push, lift, half, left, right)


# 2. Solve -------------------------------------------------------------------------------------------------------------


@njit(**INLINE)
def presses(block: Block, r: ForeseenCorner, old: Corner, late: bool) -> tuple[float, bool]:
    """Normal force as foreseen, and whether the corner presses.

    In a fine step the foreseen force tells. A longer one overshoots too far for that: there a corner presses as last found.
    """
    n = block.stiffness * r.depth - block.dashpot * r.uz
    foreseen = n if n > 0.0 else 0.0
    foreseen = foreseen if r.depth > 0.0 else 0.0
    return n, foreseen + (0.0 if late else old.pressed) > 0.0


@njit(**INLINE)
def guess(block: Block, r: ForeseenCorner, n: float, slid: float, late: bool) -> Sliding:
    """Whether a corner would slide, and which way: in fine steps as foreseen, in long ones as last found.

    `commit` has a long step done again where that proves wrong. A normal force on a sliding corner must push it out. Where
    friction would turn the block in instead (Painlevé's paradox, from μ = 4/3 on), the corner jams.
    """
    f = block.tangential * r.stretch + block.dashpot * r.ux
    excess = abs(f) - block.friction * n if late else abs(slid)
    slid = math.copysign(block.friction, f) if late else slid
    freedom = 1.0 + block.inertia * r.arm * (r.arm - slid * r.drop)
    return Sliding(f, excess > 0.0, slid, freedom > LEAST_FREEDOM)


@njit(**INLINE)
def jam(one: Sliding, other: Sliding, other_presses: bool) -> tuple[float, bool]:
    """±μ of a corner that slides, and whether it does: a jammed one sticks, unless the other sticks and it can only turn out."""
    free = one.free | (other_presses & (not other.slides))
    return (one.slid if free else 0.0), one.slides & free


@njit(**INLINE)
def normal_share(block: Block, r: ForeseenCorner, half: float, n: float, on: bool) -> tuple[float, float]:
    """Normal force at rest at the end of the step, and what the velocity there adds."""
    normal = block.dashpot + half * block.stiffness
    return (n + normal * r.uz if on else 0.0), (half * normal if on else 0.0)


@njit(**INLINE)
def share(
    block: Block, r: ForeseenCorner, half: float, n: float, on: bool, f: float, slides: bool, slid: float
) -> Share:
    """A corner's part in the equations: a sliding one carries ±μ times its normal force."""
    n, press = normal_share(block, r, half, n, on)
    tangential = block.dashpot + half * block.tangential
    sticks = on & (not slides)
    f = f - tangential * r.ux if sticks else slid * n
    return Share(n, f, press, half * tangential if sticks else 0.0, slid * press if slides else 0.0)


@njit(**INLINE)
def solve(block: Block, s: State, taken: Taken, late: bool, w: Foreseen) -> Change:
    """Velocities at the end of the step, with springs and dashpots of the corners that press and stick taken there.

    The three equations are solved by elimination without a pivot: the matrix is 1 plus something that only adds, but for sliding
    corners, which jam before they take too much away.
    """
    half, inertia, left, right = w.half, block.inertia, w.left, w.right
    nl, on_l = presses(block, left, s.left, late)
    nr, on_r = presses(block, right, s.right, late)
    # A corner in the air carries nothing, so whether it slid is not known from the last step.
    guess_l = guess(block, left, nl, taken.left, late | (s.left.pressed == 0.0))
    guess_r = guess(block, right, nr, taken.right, late | (s.right.pressed == 0.0))
    slid_l, slides_l = jam(guess_l, guess_r, on_r)
    slid_r, slides_r = jam(guess_r, guess_l, on_l)
    p = share(block, left, half, nl, on_l, guess_l.f, slides_l, slid_l)
    q = share(block, right, half, nr, on_r, guess_r.f, slides_r, slid_r)
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
def solve_smooth(block: Block, s: State, taken: Taken, late: bool, w: Foreseen) -> Change:  # noqa: ARG001
    """The same without friction, where heave and rotation stand alone."""
    half, inertia, left, right = w.half, block.inertia, w.left, w.right
    nl, on_l = presses(block, left, s.left, late)
    nr, on_r = presses(block, right, s.right, late)
    nl, press_l = normal_share(block, left, half, nl, on_l)
    nr, press_r = normal_share(block, right, half, nr, on_r)
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
def meet(
    block: Block, r: ForeseenCorner, old: Corner, slid: float, late: bool, x: float, half: float, d: Change, rough: bool
) -> Met:
    """Forces of a corner at the solution, within their limits.

    What the solution adds to the velocities moves the block by half a step of it. A corner that it has just pushed out again has
    met the base all the same. (A corner in the air "slips"; nothing asks which way.)
    """
    du, dw = d.vx - r.drop * d.vw, d.vz - r.arm * d.vw
    ux, uz = r.ux + du, r.uz + dw
    depth, stretch, place = r.depth - half * dw, r.stretch + half * du, (x + r.arm) + half * du
    inside, was = depth > 0.0, old.depth > 0.0
    changed = r.depth if r.depth > depth else depth
    changed = -depth if was else changed
    # Never tension.
    spring = block.stiffness * depth if inside else 0.0
    n = spring - block.dashpot * uz
    n = n if n > 0.0 else 0.0
    n = n if inside else 0.0
    # Friction; the spring of a corner that slips is shortened to what it holds.
    most = block.friction * n
    f = block.tangential * stretch + block.dashpot * ux
    sign, slips = math.copysign(block.friction, f), abs(f) > most
    found, taken = sign if slips else 0.0, 0.0 if late else slid
    f = sign * n if slips else f
    kept = within(stretch, most * block.compliance) if slips else stretch
    damping, sliding = (spring - n) * uz, (f - block.tangential * kept) * ux
    sinking = depth - old.depth
    cut = depth * old.depth
    cut = math.copysign(cut if cut < 0.0 else 0.0, sinking)
    fresh = inside & (not was)
    return Met(
        Corner(kept, place, depth, n), f, r.drop * f - r.arm * n if rough else -(r.arm * n),
        damping + sliding if rough else damping, (old.spring + kept) * (stretch - kept) if rough else 0.0, cut,
        fresh, sinking if fresh else 1.0, changed, abs(sinking) if changed > 0.0 else 0.0,
        found, (found != taken) & (most > 0.0), (taken * ux < 0.0) & (most > 0.0), (found * old.spring < 0.0) & (most > 0.0),
    )  # fmt: skip


@njit(**INLINE)
def found_of(block: Block, clock: Clock, length: float, late: bool, left: Met, right: Met, rough: bool) -> Found:
    """What an attempt at a step has found, for the clock."""
    changed = (left.changed if left.changed > right.changed else right.changed) > 0.0
    far = left.far if left.far > right.far else right.far
    gentle = (far <= block.gentle) & (length <= GENTLE_STEPS * clock.finest)
    stands = (left.corner.pressed > 0.0) & (right.corner.pressed > 0.0)
    if not rough:
        return Found(changed, False, gentle, False, False, False, False, stands)
    wrong, back = (left.wrong | right.wrong) & (not late), (left.back | right.back) & (not late)
    slides = (left.found != 0.0) & (right.found != 0.0) & (left.corner.pressed + right.corner.pressed > 0.0)
    return Found(changed, False, gentle, wrong, left.reversed | right.reversed, back, slides, stands)


@njit(**INLINE)
def taken_next(taken: Taken, late: bool, left: Met, right: Met, retry: bool, sooner: bool) -> Taken:
    """What the corners are taken to do in the next attempt: as found; in a retry one that was right keeps what it was taken to do."""
    of_left, of_right = (0.0 if late else taken.left), (0.0 if late else taken.right)
    keeps_left, keeps_right = sooner | (retry & (not left.wrong)), sooner | (retry & (not right.wrong))
    return Taken(of_left if keeps_left else left.found, of_right if keeps_right else right.found)


@njit(**INLINE)
def acting(half: float, one: Met, other: Met) -> float:
    """By how much longer than half the step a contact acts that closed within it: from the touch on. One division for both."""
    inverse = 2.0 * half / (one.sunk * other.sunk)
    time = one.corner.depth * (inverse * other.sunk) - half
    return time if one.fresh else 0.0


@njit(**INLINE)
def commit(
    block: Block, s: State, peaks: Peaks, account: Account, w: Foreseen, d: Change, left: Met, right: Met, length: float,
    vertical: bool, rough: bool,
) -> tuple[State, Peaks, Account]:  # fmt: skip
    """Forces at the end of the step, within their limits, what they do, and the energy account."""
    half, turn, tick = w.half, w.half * d.vw, s.tick + length
    x, z, angle = w.x + half * d.vx, w.z + half * d.vz, w.angle + turn
    c, sn = w.cos - w.sin * turn, w.sin + w.cos * turn
    nl, nr = left.corner.pressed, right.corner.pressed
    ax, az = w.push - (left.f + right.f) if rough else w.push, (nl + nr) - (GRAVITY + w.lift)
    aw = block.inertia * (left.moment + right.moment)
    vx, vz, vw = w.vx + half * ax, w.vz + half * az, w.vw + half * aw
    pl, pr = acting(half, left, right), acting(half, right, left)
    vx = vx - (pl * left.f + pr * right.f) if rough else vx
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
    return State(x, z, angle, c, sn, vx, vz, vw, ax, az, aw, left.corner, right.corner, tick), peaks, account


# Side by side ---------------------------------------------------------------------------------------------------------


@cache
def loops(vertical: bool, rough: bool) -> Any:
    """The step over the lanes, for bases that move up and down or do not, and blocks with friction or without.

    The loops take `kind`, of a type that says so too, as a part of their compiled names: without it the loops of variants that
    different processes have compiled would be called in each other's place once one process has loaded both.
    """
    springs = [] if rough else ["spring", "place", "stretch", "ux", "slid_left", "slid_right"]
    unused = springs if vertical else [*springs, "lift"]
    solution = solve if rough else solve_smooth
    load_block, load_shaking, load_clock = ROWS.access(Block).load, ROWS.access(Shaking).load, ROWS.access(Clock).load
    load_state, _, store_state = ROWS.access(State, without=unused)
    load_attempt, store_attempt, _ = ROWS.access(Attempt, without=[] if rough else ["tries"])
    load_taken, store_taken, _ = ROWS.access(Taken, without=[] if rough else ["left", "right"])
    load_peaks, _, store_peaks = ROWS.access(Peaks)
    load_account, _, store_account = ROWS.access(Account)
    load_foreseen, store_foreseen, _ = ROWS.access(Foreseen, without=unused)
    load_change, store_change, _ = ROWS.access(Change, without=unused)

    @njit(**OPTIONS)
    def foresee_all(kind: Any, state: Any, columns: int, ticks: float) -> None:  # noqa: ARG001
        for j in range(columns):
            block, s, length = load_block(state, j), load_state(state, j), load_attempt(state, j).length
            store_foreseen(state, j, foresee(block, s, length, load_shaking(state, j), ticks))

    @njit(**OPTIONS)
    def solve_all(kind: Any, state: Any, columns: int) -> None:  # noqa: ARG001
        for j in range(columns):
            late = load_attempt(state, j).length <= PREDICTED * load_clock(state, j).finest
            block, s, taken = load_block(state, j), load_state(state, j), load_taken(state, j)
            store_change(state, j, solution(block, s, taken, late, load_foreseen(state, j)))

    @njit(**OPTIONS)
    def commit_all(kind: Any, state: Any, columns: int, ticks: float) -> None:  # noqa: ARG001
        for j in range(columns):
            block, s, attempt, clock = (
                load_block(state, j),
                load_state(state, j),
                load_attempt(state, j),
                load_clock(state, j),
            )
            w, d, length = load_foreseen(state, j), load_change(state, j), attempt.length
            late = length <= PREDICTED * clock.finest
            left = meet(block, w.left, s.left, d.slid_left, late, w.x, w.half, d, rough)
            right = meet(block, w.right, s.right, d.slid_right, late, w.x, w.half, d, rough)
            found = found_of(block, clock, length, late, left, right, rough)
            again, sooner, attempt = next_attempt(BLOCK, clock, attempt, found, s.tick + length, ticks)
            taken = taken_next(Taken(d.slid_left, d.slid_right), late, left, right, attempt.tries > 0.0, sooner)
            peaks, account = load_peaks(state, j), load_account(state, j)
            s, peaks, account = commit(block, s, peaks, account, w, d, left, right, length, vertical, rough)
            store_attempt(state, j, attempt)
            store_taken(state, j, taken)
            store_state(state, j, again, s)
            store_peaks(state, j, again, peaks)
            store_account(state, j, again, account)

    @njit(**OPTIONS)
    def advance(kind: Any, state: Any, columns: int, steps: int, ticks: float) -> None:
        for _ in range(steps):
            foresee_all(kind, state, columns, ticks)
            solve_all(kind, state, columns)
            commit_all(kind, state, columns, ticks)

    return advance
