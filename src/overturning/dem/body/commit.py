"""Third part of a step of the centred scheme for a 3-D body: forces at the solution, and the new state."""

import math
from typing import Final, NamedTuple

from numba import njit

from overturning.dem.body.centred import acceleration, flat_landing_slip
from overturning.dem.body.state import (
    BodyAccount,
    BodyChange,
    BodyConstants,
    BodyPeaks,
    BodyShaking,
    BodyState,
    ContactSum,
    LargestFindings,
    PredictedBody,
    PredictedPoint,
    VertexHistory,
    lean_of,
)
from overturning.dem.body.vectors import (
    Vector,
    along,
    cross,
    frame_of,
    plus,
    rotated,
    scaled,
)
from overturning.dem.kernel.clock import StepFindings
from overturning.dem.kernel.ground import at_tick
from overturning.dem.kernel.lanes import INLINE
from overturning.dem.kernel.mechanics import clamp_friction, larger
from overturning.units import STANDARD_GRAVITY as GRAVITY

FAST_TURN: Final = 0.1
"""Largest tangent of the angle by which the lowest point moves along a rim in a step that is not the finest."""


@njit(**INLINE)
def released_energy(
    body: BodyConstants, old: VertexHistory, depth: float, reached: tuple[float, float], kept: tuple[float, float]
) -> float:
    """Return the energy released by the springs of a point in a step, per mass, m²/s².

    `reached` is the tangential stretch before slip and `kept` that after slip, m.
    """
    kx, ky = kept
    inside, was = depth > 0.0, old.depth > 0.0
    sinking, over = depth - old.depth, depth * old.depth
    over = math.copysign(over if over < 0.0 else 0.0, sinking)
    stretched_x, stretched_y = reached[0] - kx, reached[1] - ky
    let_go = 0.5 * (
        body.tangential * ((old.sx + kx) * stretched_x + (old.sy + ky) * stretched_y) + body.stiffness * over
    )
    let_go = let_go if inside | was else 0.0
    # A deferred point starts with a compressed spring.
    return let_go - 0.5 * body.stiffness * (depth * depth) if inside & (old.depth == 0.0) else let_go


@njit(**INLINE)
def correct(
    body: BodyConstants,
    w: PredictedBody,
    t: PredictedPoint,
    old: VertexHistory,
    d: BodyChange,
    fine: bool,
    round_: bool,
) -> tuple[ContactSum, LargestFindings, VertexHistory]:
    """Compute the forces of a point at the solution, within their limits, its findings, and its new state."""
    half, r, e = w.half, t.arm, plus(d.velocity, cross(d.spin, t.arm))
    u = plus(t.velocity, e)
    depth, tx, ty = t.depth - half * e.z, t.tx + half * e.x, t.ty + half * e.y
    depth = 0.0 if (t.deferred > 0.0) & (depth > 0.0) else depth
    inside, was = depth > 0.0, old.depth > 0.0
    changed = t.depth if t.depth > depth else depth
    changed = -depth if was else changed
    spring = body.stiffness * depth if inside else 0.0
    n = spring - body.dashpot * u.z
    n = n if inside & ((t.held > 0.0) | (n > 0.0)) else 0.0
    tx, ty = (tx if inside else 0.0), (ty if inside else 0.0)
    most = body.friction * n
    hx, hy = -(body.tangential * tx) - body.dashpot * u.x, -(body.tangential * ty) - body.dashpot * u.y
    drift_x, drift_y, drifts = flat_landing_slip(body, r, plus(w.end, d.velocity), plus(w.spin, d.spin), t.held > 0.0)
    hx, hy = (-drift_x if drifts else hx), (-drift_y if drifts else hy)
    fx, fy, kx, ky, slips = clamp_friction(hx, hy, tx, ty, most, body.compliance, (t.held > 0.0, drifts))
    power = (spring - n) * u.z - ((fx + body.tangential * kx) * u.x + (fy + body.tangential * ky) * u.y)
    let_go = released_energy(body, old, depth, (t.tx + half * e.x, t.ty + half * e.y), (kx, ky))
    # A contact that closed within the step acts from the first touch, not for half of the step.
    fresh = inside & (not was)
    more = depth * (2.0 * half / (depth - old.depth if fresh else 1.0)) - half if fresh else 0.0
    landing = (t.new_landing if fresh else old.landing) - 2.0 * half
    carries = most > 0.0
    assumed = t.slides > 0.0
    wrong = carries & (slips != assumed)
    backwards = carries & assumed & (fx * t.dx + fy * t.dy < 0.0)
    # In a long step the spring is stretched although the point comes back; the velocity shows this.
    back = carries & slips & ((fx * old.sx + fy * old.sy > 0.0) | (fx * u.x + fy * u.y > 0.0))
    force = Vector(fx, fy, n)
    moment = cross(r, force)
    findings = LargestFindings(
        changed, 1.0 if wrong & (not fine) else 0.0, 1.0 if backwards & (not fine) else 0.0,
        1.0 if carries & (not slips) else 0.0, 1.0 if back & (not fine) else 0.0, 0.0 if n > 0.0 else 1.0, depth,
    )  # fmt: skip
    x, y = (u.x if round_ else (w.place.x + r.x) + half * e.x), (u.y if round_ else (w.place.y + r.y) + half * e.y)
    return (
        ContactSum(force, moment, scaled(more, force), scaled(more, moment), power, let_go + more * power),
        findings,
        VertexHistory(
            sx=kx,
            sy=ky,
            x=x,
            y=y,
            depth=depth,
            normal=n,
            slid=1.0 if slips & (most != 0.0) else 0.0,
            landing=landing if inside else 0.0,
        ),
    )


@njit(**INLINE)
def turns_fast(s: BodyState, w: PredictedBody, t: LargestFindings) -> bool:
    """True if the lowest point of a tilted rim moves along it by more than `FAST_TURN` in the step."""
    a, b = frame_of(s.turn), frame_of(w.turn)
    across, ahead = a.xz * b.yz - a.yz * b.xz, a.xz * b.xz + a.yz * b.yz
    return (t.off > 0.0) & (t.depth > 0.0) & ((abs(across) > FAST_TURN * ahead) | (ahead < 0.0))


@njit(**INLINE)
def is_steady(shaking: BodyShaking, now: Vector, ticks: float, steady: float) -> bool:
    """True if the motion stays below the limit of a standing body at the end of the step and of the next sample.

    Above it, sample-long steps would let the springs vibrate too strongly, with too much sliding and rocking.
    """
    end = 2.0 * ticks
    x, y, up = (
        at_tick(shaking.push_x, end, ticks), at_tick(shaking.push_y, end, ticks), at_tick(shaking.lift, end, ticks)
    )  # fmt: skip
    first, second = steady * (GRAVITY + now.z), steady * (GRAVITY + up)
    below = (now.x * now.x + now.y * now.y < first * first) & (x * x + y * y < second * second)
    return below & (first > 0.0) & (second > 0.0)


@njit(**INLINE)
def step_findings(t: LargestFindings, weight: float, fast: bool, steady: bool) -> StepFindings:
    """Return the findings of an attempted step for the clock; `fast` requests a shorter step."""
    slides = (t.holds == 0.0) & (weight > 0.0)
    stands = steady & (t.off == 0.0)
    return StepFindings(
        changed=t.changed > 0.0,
        fast=fast,
        gentle=False,
        wrong=t.wrong > 0.0,
        reversed=t.reversed > 0.0,
        back=t.back > 0.0,
        slides=slides,
        stands=stands,
    )


class AcceptedBodyStep(NamedTuple):
    """Parts of a case that an accepted step changes."""

    state: BodyState
    peaks: BodyPeaks
    account: BodyAccount


@njit(**INLINE)
def commit(
    body: BodyConstants,
    old: AcceptedBodyStep,
    w: PredictedBody,
    d: BodyChange,
    t: ContactSum,
    depth: float,
    length: float,
) -> AcceptedBodyStep:
    """Compute state, peaks and accounts at the end of the step; `depth` is the largest penetration, m."""
    (s, peaks, account), half = old, w.half
    a, push, tick = acceleration(t.force, w.shaking), w.shaking, s.tick + length
    v = plus(along(w.velocity, half, a), t.impulse)
    momentum = plus(along(w.momentum, half, t.moment), t.twist)
    place, turn = along(w.place, half, d.velocity), rotated(w.turn, half, d.spin)
    f = frame_of(turn)
    power = (push.x * v.x + push.y * v.y) - push.z * v.z
    torque = t.moment.z + (place.x * a.y - place.y * a.x)
    account = BodyAccount(
        account.work + half * (account.power + power),
        account.lost + (half * (account.loss + t.loss) + t.let_go),
        account.spin
        + (half * (account.torque + torque) + (t.twist.z + (place.x * t.impulse.y - place.y * t.impulse.x))),
        power,
        t.loss,
        torque,
    )
    lean, x, y = lean_of(f), place.x - body.foot * f.xz, place.y - body.foot * f.yz
    peaks = BodyPeaks(
        larger(peaks.lean, lean),
        larger(peaks.slip, x * x + y * y),
        larger(peaks.depth, depth),
        tick if lean < body.critical else peaks.last_upright,
    )
    return AcceptedBodyStep(
        BodyState(
            place=place,
            turn=turn,
            velocity=v,
            momentum=momentum,
            spin=w.spin,
            acceleration=a,
            moment=t.moment,
            tick=tick,
        ),
        peaks,
        account,
    )
