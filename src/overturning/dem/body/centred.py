"""The centred scheme in space: the trapezoidal rule with springs and dashpots taken at the end of the step (docs/method.md).

From top to bottom the step of ONE body, `predict`, `solve` (in `equations`), `commit`, as in the plane (`overturning.dem.block.centred`),
each with what it does at a point of contact. The unknowns are the changes e of velocity and angular velocity at the end of the step.
`centred_loops` goes over the bodies.
"""

import math
from typing import Final

from numba import njit

from overturning.dem.body.centred_rows import Change, Largest, Predicted, PredictedPoint, Sum
from overturning.dem.body.state import (
    TICKS,
    Account,
    Body,
    Frame,
    Memory,
    Peaks,
    Shaking,
    State,
    Vector,
    angular_velocity,
    frame_of,
    lean_of,
    rotated,
)
from overturning.dem.kernel.clock import BODY, Attempt, Clock, Found
from overturning.dem.kernel.ground import at_tick
from overturning.dem.kernel.lanes import INLINE
from overturning.dem.kernel.mechanics import larger, within_circle
from overturning.units import STANDARD_GRAVITY as GRAVITY

WHOLE: Final = TICKS
FINE: Final = BODY.fine
FAST_TURN: Final = 0.1
"""Tangent of the angle by which the deepest point of a rim may run round it in a step that is not the finest."""
LEAST_FREEDOM: Final = 0.25
"""A sliding point sticks where less than this share of a normal force's effect on a free particle is left."""


# 1. Predict -----------------------------------------------------------------------------------------------------------


@njit(**INLINE)
def predict(body: Body, s: State, length: float, shaking: Shaking, ticks: float) -> Predicted:
    """Drift with the last forces: where the body would be without a change, after `ticks` per sample."""
    dt, tick = body.step * length, s.tick + length
    half, past = 0.5 * dt, tick - ticks
    past = past if past > 0.0 else 0.0
    vx, vy, vz = s.vx + half * s.ax, s.vy + half * s.ay, s.vz + half * s.az
    lx, ly, lz = s.lx + half * s.mx, s.ly + half * s.my, s.lz + half * s.mz
    w = angular_velocity(body, frame_of(s.qw, s.qx, s.qy, s.qz), lx, ly, lz)
    middle = rotated(s.qw, s.qx, s.qy, s.qz, half * w.x, half * w.y, half * w.z)
    w = angular_velocity(body, frame_of(*middle), lx, ly, lz)
    qw, qx, qy, qz = rotated(s.qw, s.qx, s.qy, s.qz, dt * w.x, dt * w.y, dt * w.z)
    e = angular_velocity(body, frame_of(qw, qx, qy, qz), lx + half * s.mx, ly + half * s.my, lz + half * s.mz)
    return Predicted(
        s.x + dt * vx, s.y + dt * vy, s.z + dt * vz, qw, qx, qy, qz, vx, vy, vz, lx, ly, lz,
        vx + half * s.ax, vy + half * s.ay, vz + half * s.az, e.x, e.y, e.z,
        at_tick(shaking.push_x, tick, past), at_tick(shaking.push_y, tick, past), at_tick(shaking.lift, tick, past), half,
    )  # fmt: skip


@njit(**INLINE)
def rim_point(body: Body, f: Frame, ahead: float, aside: float) -> Vector:
    """A point of the rim from the centre, ahead down the line along which the body leans, and aside of it."""
    square = f.xz * f.xz + f.yz * f.yz
    leans = square > 1e-30
    inverse = 1.0 / math.sqrt(square if leans else 1.0)
    tx, ty = (f.xz * inverse if leans else 1.0), (f.yz * inverse if leans else 0.0)
    a, b = body.radius * ahead, body.radius * aside
    return Vector(
        (a * f.zz * tx - b * ty) - body.foot * f.xz,
        (a * f.zz * ty + b * tx) - body.foot * f.yz,
        -(a * (square * inverse if leans else 0.0)) - body.foot * f.zz,
    )


@njit(**INLINE)
def is_fine(clock: Clock, attempt: Attempt) -> bool:
    """Whether a step is fine enough for the predicted forces to decide."""
    return attempt.length <= FINE * clock.finest


@njit(**INLINE)
def predict_point(
    body: Body, w: Predicted, f: Frame, r: Vector, old: Memory, fine: bool, round_: bool, waits: bool
) -> PredictedPoint:
    """A point at the predicted end: what it is taken to do.

    In a fine step the predicted forces decide what is in contact and slides. A longer one overshoots too far for that: there it is as last
    found.
    """
    ux, uy, uz = (
        w.ex + (w.wy * r.z - w.wz * r.y), w.ey + (w.wz * r.x - w.wx * r.z), w.ez + (w.wx * r.y - w.wy * r.x)
    )  # fmt: skip
    # A rim passes over its points: they remember their velocity in place of where they were.
    slip_x = w.half * (old.x + ux) if round_ else (w.x + r.x) - old.x
    slip_y = w.half * (old.y + uy) if round_ else (w.y + r.y) - old.y
    was = old.depth > 0.0
    tx, ty = (old.sx + slip_x if was else 0.0), (old.sy + slip_y if was else 0.0)
    depth = -(w.z + r.z)
    depth = 0.0 if waits & (depth > 0.0) else depth
    n = body.stiffness * depth - body.dashpot * uz
    in_contact = (n > 0.0) & (depth > 0.0) if fine else old.normal > 0.0
    hx, hy = -(body.tangential * tx) - body.dashpot * ux, -(body.tangential * ty) - body.dashpot * uy
    square = hx * hx + hy * hy
    some = square > 0.0
    inverse = 1.0 / math.sqrt(square if some else 1.0)
    dx, dy = hx * inverse, hy * inverse
    most = body.friction * (n if fine else old.normal)
    smooth = body.friction == 0.0
    slides = (square > most * most if fine else old.slid > 0.0) | smooth
    # A normal force on a sliding point must push it out; where friction would turn the body in instead, it sticks.
    mx, my, mz = r.y - r.z * body.friction * dy, r.z * body.friction * dx - r.x, body.friction * (r.x * dy - r.y * dx)
    turn = angular_velocity(body, f, mx, my, mz)
    free = 1.0 + (turn.x * r.y - turn.y * r.x) > LEAST_FREEDOM
    return PredictedPoint(
        r.x, r.y, r.z, depth, tx, ty, ux, uy, uz, 1.0 if in_contact else 0.0,
        1.0 if in_contact & slides & (some | smooth) & free else 0.0, dx, dy, 1.0 if waits else 0.0,
    )  # fmt: skip


# 3. Commit ------------------------------------------------------------------------------------------------------------


@njit(**INLINE)
def correct(
    body: Body, w: Predicted, t: PredictedPoint, old: Memory, d: Change, fine: bool, round_: bool
) -> tuple[Sum, Largest, Memory]:
    """Forces of a point at the solution, within their limits."""
    half = w.half
    du = d.vx + (d.wy * t.rz - d.wz * t.ry)
    dv = d.vy + (d.wz * t.rx - d.wx * t.rz)
    dw = d.vz + (d.wx * t.ry - d.wy * t.rx)
    ux, uy, uz = t.ux + du, t.uy + dv, t.uz + dw
    depth, tx, ty = t.depth - half * dw, t.tx + half * du, t.ty + half * dv
    depth = 0.0 if (t.waits > 0.0) & (depth > 0.0) else depth
    inside, was = depth > 0.0, old.depth > 0.0
    changed = t.depth if t.depth > depth else depth
    changed = -depth if was else changed
    spring = body.stiffness * depth if inside else 0.0
    n = spring - body.dashpot * uz
    n = n if inside & (n > 0.0) else 0.0
    tx, ty = (tx if inside else 0.0), (ty if inside else 0.0)
    most = body.friction * n
    hx, hy = -(body.tangential * tx) - body.dashpot * ux, -(body.tangential * ty) - body.dashpot * uy
    fx, fy, kx, ky, slips = within_circle(hx, hy, tx, ty, most, body.compliance)
    power = (spring - n) * uz - ((fx + body.tangential * kx) * ux + (fy + body.tangential * ky) * uy)
    sinking, over = depth - old.depth, depth * old.depth
    over = math.copysign(over if over < 0.0 else 0.0, sinking)
    let_go = 0.5 * (
        body.tangential * ((old.sx + kx) * (t.tx + half * du - kx) + (old.sy + ky) * (t.ty + half * dv - ky))
        + body.stiffness * over
    )
    let_go = let_go if inside | was else 0.0
    # One that has waited is met by a spring that is pressed in already.
    let_go = let_go - 0.5 * body.stiffness * (depth * depth) if inside & (old.depth == 0.0) else let_go
    # A contact that closed within the step acts from the touch on, not for half the step.
    fresh = inside & (not was)
    more = depth * (2.0 * half / (sinking if fresh else 1.0)) - half if fresh else 0.0
    let_go = let_go + more * power
    carries = most > 0.0
    taken = t.slides > 0.0
    wrong = carries & (slips != taken)
    backwards = carries & taken & (fx * t.dx + fy * t.dy < 0.0)
    # Over a long step its spring is stretched by the way there, though it comes back: its velocity tells that, too.
    back = carries & slips & ((fx * old.sx + fy * old.sy > 0.0) | (fx * ux + fy * uy > 0.0))
    ry, rz, rx = t.ry, t.rz, t.rx
    mx, my, mz = ry * n - rz * fy, rz * fx - rx * n, rx * fy - ry * fx
    return Sum(
        fx, fy, n, mx, my, mz, more * fx, more * fy, more * n, more * mx, more * my, more * mz, power, let_go,
    ), Largest(
        changed, 1.0 if wrong & (not fine) else 0.0, 1.0 if backwards & (not fine) else 0.0,
        1.0 if carries & (not slips) else 0.0,
        1.0 if back & (not fine) else 0.0, 0.0 if n > 0.0 else 1.0, depth,
    ), Memory(kx, ky, ux if round_ else (w.x + rx) + half * du, uy if round_ else (w.y + ry) + half * dv, depth, n, 1.0 if slips & carries else 0.0)  # fmt: skip


@njit(**INLINE)
def turns_fast(s: State, w: Predicted, t: Largest) -> bool:
    """Whether the deepest point of a rim that does not lie flat runs round it by more than a tenth of a radian in the step."""
    a, b = frame_of(s.qw, s.qx, s.qy, s.qz), frame_of(w.qw, w.qx, w.qy, w.qz)
    across, along = a.xz * b.yz - a.yz * b.xz, a.xz * b.xz + a.yz * b.yz
    return (t.off > 0.0) & (t.depth > 0.0) & ((abs(across) > FAST_TURN * along) | (along < 0.0))


@njit(**INLINE)
def found_of(t: Largest, weight: float, fast: bool) -> Found:
    """What an attempt at a step has found, for the clock; a rim that runs round too fast asks for a shorter step."""
    slides = (t.holds == 0.0) & (weight > 0.0)
    return Found(t.changed > 0.0, fast, False, t.wrong > 0.0, t.reversed > 0.0, t.back > 0.0, slides, False)


@njit(**INLINE)
def commit(
    body: Body, s: State, peaks: Peaks, account: Account, w: Predicted, d: Change, t: Sum, depth: float, length: float
) -> tuple[State, Peaks, Account]:
    """Forces at the end of the step, what they do, and the accounts."""
    half, tick = w.half, s.tick + length
    ax, ay, az = t.fx + w.push_x, t.fy + w.push_y, t.fz - (GRAVITY + w.lift)
    vx, vy, vz = w.vx + half * ax + t.px, w.vy + half * ay + t.py, w.vz + half * az + t.pz
    lx, ly, lz = w.lx + half * t.mx + t.qx, w.ly + half * t.my + t.qy, w.lz + half * t.mz + t.qz
    x, y, z = w.x + half * d.vx, w.y + half * d.vy, w.z + half * d.vz
    qw, qx, qy, qz = rotated(w.qw, w.qx, w.qy, w.qz, half * d.wx, half * d.wy, half * d.wz)
    f = frame_of(qw, qx, qy, qz)
    power = (w.push_x * vx + w.push_y * vy) - w.lift * vz
    torque = t.mz + (x * ay - y * ax)
    account = Account(
        account.work + half * (account.power + power), account.lost + (half * (account.loss + t.loss) + t.let_go),
        account.spin + (half * (account.torque + torque) + (t.qz + (x * t.py - y * t.px))), power, t.loss, torque,
    )  # fmt: skip
    lean, bx, by = lean_of(f), x - body.foot * f.xz, y - body.foot * f.yz
    peaks = Peaks(
        larger(peaks.lean, lean), larger(peaks.slip, bx * bx + by * by), larger(peaks.depth, depth),
        tick if lean < body.critical else peaks.last_upright,
    )  # fmt: skip
    moved = State(
        x, y, z, qw, qx, qy, qz, vx, vy, vz, lx, ly, lz, w.wx, w.wy, w.wz, ax, ay, az, t.mx, t.my, t.mz, tick
    )  # fmt: skip
    return moved, peaks, account
