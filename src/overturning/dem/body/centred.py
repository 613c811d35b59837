"""The centred scheme for a 3-D body: trapezoidal rule, springs and dashpots at the end of the step (docs/method.md).

The step of one body has three parts, as for a block: `predict` and `solve` are here, `correct` and `commit` in
`overturning.dem.body.commit`. The unknowns are the corrections e of velocity and angular velocity at the end of the
step. `centred_loops` has the loops over the bodies.
"""

import math
from typing import Final

from numba import njit

from overturning.dem.body.state import (
    BodyChange,
    BodyConstants,
    BodyShaking,
    BodyState,
    Equations,
    PredictedBody,
    PredictedPoint,
    VertexHistory,
    angular_velocity,
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
from overturning.dem.kernel.clock import BODY, Attempt, Clock
from overturning.dem.kernel.ground import at_tick
from overturning.dem.kernel.lanes import INLINE
from overturning.units import STANDARD_GRAVITY as GRAVITY

FINE: Final = BODY.fine

LEAST_FREEDOM: Final = 0.25
"""Least effect of a normal force on a sliding point, as a share of its effect on a free particle; below, it sticks."""


@njit(**INLINE)
def acceleration(force: Vector, shaking: Vector) -> Vector:
    """Return the acceleration of the centre in the frame of the base, m/s²."""
    return Vector(force.x + shaking.x, force.y + shaking.y, force.z - (GRAVITY + shaking.z))


# 1. Predict -----------------------------------------------------------------------------------------------------------


@njit(**INLINE)
def predict(body: BodyConstants, s: BodyState, length: float, shaking: BodyShaking, ticks: float) -> PredictedBody:
    """Predict the body at the end of a step with constant acceleration; `ticks` is the length of a sample."""
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
    return PredictedBody(
        place=along(s.place, dt, v),
        turn=turn,
        velocity=v,
        momentum=momentum,
        end=along(v, half, s.acceleration),
        spin=spin,
        shaking=at_end,
        half=half,
    )


@njit(**INLINE)
def rim_point(body: BodyConstants, f: Matrix, ahead: float, aside: float) -> Vector:
    """Return the position of a point of the rim from the centre, m.

    `ahead` and `aside` (−1, 0 or 1) are its direction, along the direction of the lean and across it. The lowest point
    of the rim is always one of the four points, and all four carry equally if the rim lies flat. For an upright body
    the direction is arbitrary.
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
    """True if a step is so fine that predicted forces decide about contact and slip."""
    return attempt.length <= FINE * clock.finest


@njit(**INLINE)
def flat_landing_slip(body: BodyConstants, r: Vector, v: Vector, spin: Vector, flat: bool) -> tuple[float, float, bool]:
    """Return the direction in which a point slides in a flat landing (unit vector), and whether it slides.

    See `overturning.dem.kernel.mechanics.slides_flat`; only the rotation about the vertical is included.
    """
    x, y = v.x - spin.z * r.y, v.y + spin.z * r.x
    square, least = x * x + y * y, body.friction * v.z
    drifts = flat & (square >= least * least)
    one = 1.0 / math.sqrt(square if drifts & (square > 0.0) else 1.0)
    return x * one, y * one, drifts


@njit(**INLINE)
def predict_point(
    body: BodyConstants,
    w: PredictedBody,
    f: Matrix,
    r: Vector,
    old: VertexHistory,
    fine: bool,
    round_: bool,
    rule: tuple[bool, bool, float],
) -> PredictedPoint:
    """Predict a contact point at the end of a step, and what the equations assume of it.

    In a fine step the predicted forces decide about contact and slip. In a longer step they overshoot too far; the last
    state is used. `rule` holds whether the point carries only later, whether the body lands flat, and the landing time
    of the point if it touches now (s).
    """
    deferred, flat, new_landing = rule
    u = plus(w.end, cross(w.spin, r))
    # Points of a rim move along it: their velocity is stored instead of their position.
    slip_x = w.half * (old.x + u.x) if round_ else (w.place.x + r.x) - old.x
    slip_y = w.half * (old.y + u.y) if round_ else (w.place.y + r.y) - old.y
    was = old.depth > 0.0
    tx, ty = (old.sx + slip_x if was else 0.0), (old.sy + slip_y if was else 0.0)
    depth = -(w.place.z + r.z)
    depth = 0.0 if deferred & (depth > 0.0) else depth
    n = body.stiffness * depth - body.dashpot * u.z
    in_contact = ((n > 0.0) | flat) & (depth > 0.0) if fine else old.normal != 0.0
    hx, hy = -(body.tangential * tx) - body.dashpot * u.x, -(body.tangential * ty) - body.dashpot * u.y
    square = hx * hx + hy * hy
    some = square > 0.0
    one = 1.0 / math.sqrt(square if some else 1.0)
    dx, dy = hx * one, hy * one
    most = body.friction * (n if fine else old.normal)
    smooth = body.friction == 0.0
    drift_x, drift_y, drifts = flat_landing_slip(body, r, w.end, w.spin, flat)
    dx, dy = (-drift_x if drifts else dx), (-drift_y if drifts else dy)
    slides = square > most * most if fine else old.slid > 0.0
    slides = drifts if flat else slides | smooth
    # A normal force on a sliding point must push it out; where friction would rotate the body in instead, it sticks.
    turn = angular_velocity(body, f, Vector(
        r.y - r.z * body.friction * dy, r.z * body.friction * dx - r.x, body.friction * (r.x * dy - r.y * dx)
    ))  # fmt: skip
    free = 1.0 + (turn.x * r.y - turn.y * r.x) > LEAST_FREEDOM
    slides = in_contact & slides & (some | smooth | drifts) & free
    return PredictedPoint(
        arm=r,
        depth=depth,
        tx=tx,
        ty=ty,
        velocity=u,
        on=1.0 if in_contact else 0.0,
        slides=1.0 if slides else 0.0,
        dx=dx,
        dy=dy,
        deferred=1.0 if deferred else 0.0,
        held=1.0 if flat else 0.0,
        new_landing=new_landing,
    )


# 2. Solve -------------------------------------------------------------------------------------------------------------


@njit(**INLINE)
def friction_share(most: float, square: float, slides: bool) -> float:
    """Return friction as a share (0 to 1) of the force that would hold a sliding point, whose square is `square`."""
    part = most / math.sqrt(square if slides else 1.0)
    part = part if part < 1.0 else 1.0
    return part if part > 0.0 else 0.0


@njit(**INLINE)
def contribution(body: BodyConstants, half: float, t: PredictedPoint, old: VertexHistory, fine: bool) -> Equations:
    """Return a point's contribution to the equations, f' = f − G (e_v + e_w × r).

    Friction of a sliding point is μ times its normal force. Across its direction the point is held as if it stuck,
    times the ratio of friction to the force that would hold it.
    """
    on, slides, r, u = t.on > 0.0, t.slides > 0.0, t.arm, t.velocity
    press, stick = body.dashpot + half * body.stiffness, body.dashpot + half * body.tangential
    n = body.stiffness * t.depth - body.dashpot * u.z
    hx, hy = -(body.tangential * t.tx) - body.dashpot * u.x, -(body.tangential * t.ty) - body.dashpot * u.y
    part = friction_share(body.friction * (n if fine else old.normal), hx * hx + hy * hy, slides)
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
    # Rows of G(·× r), and the moments r × column of both; zero terms are left out.
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
def solve(body: BodyConstants, s: BodyState, w: PredictedBody, q: Equations) -> BodyChange:
    """Solve for the velocities at the end of the step by 3 × 3 blocks, with springs and dashpots evaluated there."""
    a, b, c, d = q.a, q.b, q.c, q.d
    u = scaled(w.half, minus(acceleration(q.force, w.shaking), s.acceleration))
    t = scaled(w.half, minus(q.moment, s.moment))
    f = frame_of(w.turn)
    i = times(times(f, full(body.inertia)), transposed(f))
    a = inverse(Matrix(1.0 + a.xx, a.xy, a.xz, a.yx, 1.0 + a.yy, a.yz, a.zx, a.zy, 1.0 + a.zz))
    c = times(c, a)
    e = apply(inverse(matrix_minus(matrix_plus(i, d), times(c, b))), minus(t, apply(c, u)))
    return BodyChange(apply(a, minus(u, apply(b, e))), e)
