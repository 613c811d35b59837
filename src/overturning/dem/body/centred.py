"""The centred scheme in space: the trapezoidal rule with springs and dashpots at the end of the step (docs/method.md).

From top to bottom the step of ONE body: `predict`, `solve`, `commit`, as in the plane
(`overturning.dem.block.centred`), each with what it does at a point of contact above it. The unknowns are the changes e
of velocity and angular velocity at the end of the step. `centred_loops` goes over the bodies.
"""

import math
from typing import Final, NamedTuple

from numba import njit

from overturning.dem.body.state import (
    Account,
    Body,
    Change,
    Equations,
    Largest,
    Memory,
    Peaks,
    Predicted,
    PredictedPoint,
    Shaking,
    State,
    Sum,
    angular_velocity,
    lean_of,
)
from overturning.dem.body.vectors import (
    Matrix,
    Vector,
    along,
    apply,
    cross,
    frame_of,
    full,
    inverse,
    matrix_minus,
    matrix_plus,
    minus,
    plus,
    rotated,
    scaled,
    times,
    transposed,
)
from overturning.dem.kernel.clock import BODY, Attempt, Clock, Found
from overturning.dem.kernel.ground import at_tick
from overturning.dem.kernel.lanes import INLINE
from overturning.dem.kernel.mechanics import larger, within_circle
from overturning.units import STANDARD_GRAVITY as GRAVITY

FINE: Final = BODY.fine

FAST_TURN: Final = 0.1
"""Tangent of the angle by which the deepest point of a rim may run round it in a step that is not the finest."""

LEAST_FREEDOM: Final = 0.25
"""A point sticks where sliding would leave less than this share of a normal force's effect on a free particle."""


@njit(**INLINE)
def acceleration(force: Vector, shaking: Vector) -> Vector:
    """Of the centre, in the frame of the base."""
    return Vector(force.x + shaking.x, force.y + shaking.y, force.z - (GRAVITY + shaking.z))


# 1. Predict -----------------------------------------------------------------------------------------------------------


@njit(**INLINE)
def predict(body: Body, s: State, length: float, shaking: Shaking, ticks: float) -> Predicted:
    """The body at the end of a step, were its acceleration to stay; a sample has so many `ticks`."""
    dt, tick = body.step * length, s.tick + length
    half, past = 0.5 * dt, tick - ticks
    past = past if past > 0.0 else 0.0
    v, momentum = along(s.velocity, half, s.acceleration), along(s.momentum, half, s.moment)
    w = angular_velocity(body, frame_of(s.turn), momentum)
    w = angular_velocity(body, frame_of(rotated(s.turn, half, w)), momentum)
    turn = rotated(s.turn, dt, w)
    spin = angular_velocity(body, frame_of(turn), along(momentum, half, s.moment))
    at_end = Vector(
        at_tick(shaking.push_x, tick, past), at_tick(shaking.push_y, tick, past), at_tick(shaking.lift, tick, past)
    )
    return Predicted(
        along(s.place, dt, v), turn, v, momentum, along(v, half, s.acceleration), spin, at_end, half
    )  # fmt: skip


@njit(**INLINE)
def rim_point(body: Body, f: Matrix, ahead: float, aside: float) -> Vector:
    """A point of the rim from the centre, ahead down the line along which the body leans, and aside of it.

    So the deepest point of the rim is always among them, and all four carry alike where the rim lies flat. Of an
    upright body any line will do.
    """
    square = f.xz * f.xz + f.yz * f.yz
    leans = square > 1e-30
    one = 1.0 / math.sqrt(square if leans else 1.0)
    tx, ty = (f.xz * one if leans else 1.0), (f.yz * one if leans else 0.0)
    a, b = body.radius * ahead, body.radius * aside
    return Vector(
        (a * f.zz * tx - b * ty) - body.foot * f.xz,
        (a * f.zz * ty + b * tx) - body.foot * f.yz,
        -(a * (square * one if leans else 0.0)) - body.foot * f.zz,
    )


@njit(**INLINE)
def is_fine(clock: Clock, attempt: Attempt) -> bool:
    """Whether a step is fine enough for the predicted forces to decide."""
    return attempt.length <= FINE * clock.finest


@njit(**INLINE)
def drift_of(body: Body, r: Vector, v: Vector, spin: Vector, flat: bool) -> tuple[float, float, bool]:
    """Direction in which a point slides in a flat landing, and whether it does, as of `slides_flat`.

    Of the rotation only that about the vertical counts.
    """
    x, y = v.x - spin.z * r.y, v.y + spin.z * r.x
    square, least = x * x + y * y, body.friction * v.z
    drifts = flat & (square >= least * least)
    one = 1.0 / math.sqrt(square if drifts & (square > 0.0) else 1.0)
    return x * one, y * one, drifts


@njit(**INLINE)
def predict_point(
    body: Body,
    w: Predicted,
    f: Matrix,
    r: Vector,
    old: Memory,
    fine: bool,
    round_: bool,
    rule: tuple[bool, bool, float],
) -> PredictedPoint:
    """A point at the predicted end: what it is taken to do.

    In a fine step the predicted forces decide what is in contact and slides. A longer one overshoots too far for that:
    there it is as last found. `rule` says whether the point waits, whether the body lands flat, and for how long the
    point lands if it touches now.
    """
    waits, flat, begun = rule
    u = plus(w.end, cross(w.spin, r))
    # A rim passes over its points: they remember their velocity in place of where they were.
    slip_x = w.half * (old.x + u.x) if round_ else (w.place.x + r.x) - old.x
    slip_y = w.half * (old.y + u.y) if round_ else (w.place.y + r.y) - old.y
    was = old.depth > 0.0
    tx, ty = (old.sx + slip_x if was else 0.0), (old.sy + slip_y if was else 0.0)
    depth = -(w.place.z + r.z)
    depth = 0.0 if waits & (depth > 0.0) else depth
    n = body.stiffness * depth - body.dashpot * u.z
    in_contact = ((n > 0.0) | flat) & (depth > 0.0) if fine else old.normal != 0.0
    hx, hy = -(body.tangential * tx) - body.dashpot * u.x, -(body.tangential * ty) - body.dashpot * u.y
    square = hx * hx + hy * hy
    some = square > 0.0
    one = 1.0 / math.sqrt(square if some else 1.0)
    dx, dy = hx * one, hy * one
    most = body.friction * (n if fine else old.normal)
    smooth = body.friction == 0.0
    drift_x, drift_y, drifts = drift_of(body, r, w.end, w.spin, flat)
    dx, dy = (-drift_x if drifts else dx), (-drift_y if drifts else dy)
    slides = square > most * most if fine else old.slid > 0.0
    slides = drifts if flat else slides | smooth
    # A normal force on a sliding point must push it out; where friction would turn the body in instead, it sticks.
    turn = angular_velocity(body, f, Vector(
        r.y - r.z * body.friction * dy, r.z * body.friction * dx - r.x, body.friction * (r.x * dy - r.y * dx)
    ))  # fmt: skip
    free = 1.0 + (turn.x * r.y - turn.y * r.x) > LEAST_FREEDOM
    slides = in_contact & slides & (some | smooth | drifts) & free
    return PredictedPoint(
        r,
        depth,
        tx,
        ty,
        u,
        1.0 if in_contact else 0.0,
        1.0 if slides else 0.0,
        dx,
        dy,
        1.0 if waits else 0.0,
        1.0 if flat else 0.0,
        begun,
    )


# 2. Solve -------------------------------------------------------------------------------------------------------------


@njit(**INLINE)
def held(most: float, square: float, slides: bool) -> float:
    """Which part of the force that would hold a sliding point, given by its square, friction is: from 0 to 1."""
    part = most / math.sqrt(square if slides else 1.0)
    part = part if part < 1.0 else 1.0
    return part if part > 0.0 else 0.0


@njit(**INLINE)
def contribution(body: Body, half: float, t: PredictedPoint, old: Memory, fine: bool) -> Equations:
    """A point's part in the equations, f' = f − G (e_v + e_w × r): a sliding one carries μ times its normal force.

    Across its direction a sliding point is held as if it stuck, in the proportion of friction to what would hold it.
    """
    on, slides, r, u = t.on > 0.0, t.slides > 0.0, t.arm, t.velocity
    press, stick = body.dashpot + half * body.stiffness, body.dashpot + half * body.tangential
    n = body.stiffness * t.depth - body.dashpot * u.z
    hx, hy = -(body.tangential * t.tx) - body.dashpot * u.x, -(body.tangential * t.ty) - body.dashpot * u.y
    part = held(body.friction * (n if fine else old.normal), hx * hx + hy * hy, slides)
    mx, my = body.friction * t.dx, body.friction * t.dy
    fx, fy = (mx * n if slides else hx), (my * n if slides else hy)
    across = half * (stick * part if slides else stick)
    gxx = across * (1.0 - t.dx * t.dx if slides else 1.0)
    gyy = across * (1.0 - t.dy * t.dy if slides else 1.0)
    gxy = -(across * (t.dx * t.dy)) if slides else 0.0
    gzz = half * press
    gxz, gyz = (mx * gzz if slides else 0.0), (my * gzz if slides else 0.0)
    n, fx, fy = (n if on else 0.0), (fx if on else 0.0), (fy if on else 0.0)
    gxx, gyy, gxy = (gxx if on else 0.0), (gyy if on else 0.0), (gxy if on else 0.0)
    gxz, gyz, gzz = (gxz if on else 0.0), (gyz if on else 0.0), (gzz if on else 0.0)
    f = Vector(fx, fy, n)
    # Rows of G(·× r), and the moments r × column of both, without what is 0 of them.
    bx, by = cross(r, Vector(gxx, gxy, gxz)), cross(r, Vector(gxy, gyy, gyz))
    bz = Vector(r.y * gzz, -(r.x * gzz), 0.0)
    cz = cross(r, Vector(gxz, gyz, gzz))
    dx, dy = cross(r, Vector(bx.x, by.x, bz.x)), cross(r, Vector(bx.y, by.y, bz.y))
    dz = cross(r, Vector(bx.z, by.z, bz.z))
    return Equations(
        f,
        cross(r, f),
        Matrix(gxx, gxy, gxz, gxy, gyy, gyz, 0.0, 0.0, gzz),
        Matrix(bx.x, bx.y, bx.z, by.x, by.y, by.z, bz.x, bz.y, bz.z),
        Matrix(
            -(r.z * gxy), -(r.z * gyy), cz.x, r.z * gxx, r.z * gxy, cz.y,
            r.x * gxy - r.y * gxx, r.x * gyy - r.y * gxy, cz.z,
        ),
        Matrix(dx.x, dy.x, dz.x, dx.y, dy.y, dz.y, dx.z, dy.z, dz.z),
    )  # fmt: skip


@njit(**INLINE)
def solve(body: Body, s: State, w: Predicted, q: Equations) -> Change:
    """Velocities at the end of the step, with springs and dashpots taken there, by blocks."""
    a, b, c, d = q.a, q.b, q.c, q.d
    u = scaled(w.half, minus(acceleration(q.force, w.shaking), s.acceleration))
    t = scaled(w.half, minus(q.moment, s.moment))
    f = frame_of(w.turn)
    i = times(times(f, full(body.inertia)), transposed(f))
    a = inverse(Matrix(1.0 + a.xx, a.xy, a.xz, a.yx, 1.0 + a.yy, a.yz, a.zx, a.zy, 1.0 + a.zz))
    c = times(c, a)
    e = apply(inverse(matrix_minus(matrix_plus(i, d), times(c, b))), minus(t, apply(c, u)))
    return Change(apply(a, minus(u, apply(b, e))), e)


# 3. Commit ------------------------------------------------------------------------------------------------------------


@njit(**INLINE)
def released(body: Body, old: Memory, depth: float, reached: tuple[float, float], kept: tuple[float, float]) -> float:
    """Spring energy let go within a step: of `depth` and of the part of the tangential way that slips away."""
    kx, ky = kept
    inside, was = depth > 0.0, old.depth > 0.0
    sinking, over = depth - old.depth, depth * old.depth
    over = math.copysign(over if over < 0.0 else 0.0, sinking)
    stretched_x, stretched_y = reached[0] - kx, reached[1] - ky
    let_go = 0.5 * (
        body.tangential * ((old.sx + kx) * stretched_x + (old.sy + ky) * stretched_y) + body.stiffness * over
    )
    let_go = let_go if inside | was else 0.0
    # One that has waited is met by a spring that is pressed in already.
    return let_go - 0.5 * body.stiffness * (depth * depth) if inside & (old.depth == 0.0) else let_go


@njit(**INLINE)
def correct(
    body: Body, w: Predicted, t: PredictedPoint, old: Memory, d: Change, fine: bool, round_: bool
) -> tuple[Sum, Largest, Memory]:
    """Forces of a point at the solution, within their limits."""
    half, r, e = w.half, t.arm, plus(d.velocity, cross(d.spin, t.arm))
    u = plus(t.velocity, e)
    depth, tx, ty = t.depth - half * e.z, t.tx + half * e.x, t.ty + half * e.y
    depth = 0.0 if (t.waits > 0.0) & (depth > 0.0) else depth
    inside, was = depth > 0.0, old.depth > 0.0
    changed = t.depth if t.depth > depth else depth
    changed = -depth if was else changed
    spring = body.stiffness * depth if inside else 0.0
    n = spring - body.dashpot * u.z
    n = n if inside & ((t.held > 0.0) | (n > 0.0)) else 0.0
    tx, ty = (tx if inside else 0.0), (ty if inside else 0.0)
    most = body.friction * n
    hx, hy = -(body.tangential * tx) - body.dashpot * u.x, -(body.tangential * ty) - body.dashpot * u.y
    drift_x, drift_y, drifts = drift_of(body, r, plus(w.end, d.velocity), plus(w.spin, d.spin), t.held > 0.0)
    hx, hy = (-drift_x if drifts else hx), (-drift_y if drifts else hy)
    fx, fy, kx, ky, slips = within_circle(hx, hy, tx, ty, most, body.compliance, (t.held > 0.0, drifts))
    power = (spring - n) * u.z - ((fx + body.tangential * kx) * u.x + (fy + body.tangential * ky) * u.y)
    let_go = released(body, old, depth, (t.tx + half * e.x, t.ty + half * e.y), (kx, ky))
    # A contact that closed within the step acts from the touch on, not for half the step.
    fresh = inside & (not was)
    more = depth * (2.0 * half / (depth - old.depth if fresh else 1.0)) - half if fresh else 0.0
    landing = (t.begun if fresh else old.landing) - 2.0 * half
    carries = most > 0.0
    taken = t.slides > 0.0
    wrong = carries & (slips != taken)
    backwards = carries & taken & (fx * t.dx + fy * t.dy < 0.0)
    # Over a long step its spring is stretched by the way there, though it comes back: its velocity tells that, too.
    back = carries & slips & ((fx * old.sx + fy * old.sy > 0.0) | (fx * u.x + fy * u.y > 0.0))
    force = Vector(fx, fy, n)
    moment = cross(r, force)
    found = Largest(
        changed, 1.0 if wrong & (not fine) else 0.0, 1.0 if backwards & (not fine) else 0.0,
        1.0 if carries & (not slips) else 0.0, 1.0 if back & (not fine) else 0.0, 0.0 if n > 0.0 else 1.0, depth,
    )  # fmt: skip
    x, y = (u.x if round_ else (w.place.x + r.x) + half * e.x), (u.y if round_ else (w.place.y + r.y) + half * e.y)
    return (
        Sum(force, moment, scaled(more, force), scaled(more, moment), power, let_go + more * power),
        found,
        Memory(kx, ky, x, y, depth, n, 1.0 if slips & (most != 0.0) else 0.0, landing if inside else 0.0),
    )


@njit(**INLINE)
def turns_fast(s: State, w: Predicted, t: Largest) -> bool:
    """Whether the deepest point of a rim that does not lie flat runs round it by more than `FAST_TURN` in the step."""
    a, b = frame_of(s.turn), frame_of(w.turn)
    across, ahead = a.xz * b.yz - a.yz * b.xz, a.xz * b.xz + a.yz * b.yz
    return (t.off > 0.0) & (t.depth > 0.0) & ((abs(across) > FAST_TURN * ahead) | (ahead < 0.0))


@njit(**INLINE)
def is_steady(shaking: Shaking, now: Vector, ticks: float, steady: float) -> bool:
    """Whether the shaking, at the end of a step and of the next sample, stays below what a standing body bears.

    In a step of a sample the springs would keep ringing with what sets it going: it slid or rocked too far.
    """
    end = 2.0 * ticks
    x, y, up = (
        at_tick(shaking.push_x, end, ticks), at_tick(shaking.push_y, end, ticks), at_tick(shaking.lift, end, ticks)
    )  # fmt: skip
    first, second = steady * (GRAVITY + now.z), steady * (GRAVITY + up)
    below = (now.x * now.x + now.y * now.y < first * first) & (x * x + y * y < second * second)
    return below & (first > 0.0) & (second > 0.0)


@njit(**INLINE)
def found_of(t: Largest, weight: float, fast: bool, steady: bool) -> Found:
    """What an attempt at a step has found, for the clock; a rim that runs round too fast asks for a shorter step."""
    slides = (t.holds == 0.0) & (weight > 0.0)
    stands = steady & (t.off == 0.0)
    return Found(t.changed > 0.0, fast, False, t.wrong > 0.0, t.reversed > 0.0, t.back > 0.0, slides, stands)


class Kept(NamedTuple):
    """What a step that is accepted changes of a case."""

    state: State
    peaks: Peaks
    account: Account


@njit(**INLINE)
def commit(body: Body, kept: Kept, w: Predicted, d: Change, t: Sum, depth: float, length: float) -> Kept:
    """Forces at the end of the step, what they do, and the accounts; `depth` is the largest penetration."""
    (s, peaks, account), half = kept, w.half
    a, push, tick = acceleration(t.force, w.shaking), w.shaking, s.tick + length
    v = plus(along(w.velocity, half, a), t.impulse)
    momentum = plus(along(w.momentum, half, t.moment), t.twist)
    place, turn = along(w.place, half, d.velocity), rotated(w.turn, half, d.spin)
    f = frame_of(turn)
    power = (push.x * v.x + push.y * v.y) - push.z * v.z
    torque = t.moment.z + (place.x * a.y - place.y * a.x)
    account = Account(
        account.work + half * (account.power + power),
        account.lost + (half * (account.loss + t.loss) + t.let_go),
        account.spin
        + (half * (account.torque + torque) + (t.twist.z + (place.x * t.impulse.y - place.y * t.impulse.x))),
        power,
        t.loss,
        torque,
    )
    lean, x, y = lean_of(f), place.x - body.foot * f.xz, place.y - body.foot * f.yz
    peaks = Peaks(
        larger(peaks.lean, lean),
        larger(peaks.slip, x * x + y * y),
        larger(peaks.depth, depth),
        tick if lean < body.critical else peaks.last_upright,
    )
    return Kept(State(place, turn, v, momentum, w.spin, a, t.moment, tick), peaks, account)
