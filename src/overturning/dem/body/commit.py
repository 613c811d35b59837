"""Third part of a step of the centred scheme for a 3-D body: forces at the solution, and the new state."""

import math
from typing import Final, NamedTuple

from numba import njit

from overturning.dem.body.centred import centre_acceleration, flat_landing_slip
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
    lean_measure,
)
from overturning.dem.body.vectors import (
    Vector,
    cross_product,
    extrapolate,
    plus,
    rotate_quaternion,
    rotation_matrix,
    scale_vector,
)
from overturning.dem.kernel.clock import StepFindings
from overturning.dem.kernel.ground import motion_at_tick_or_beyond
from overturning.dem.kernel.lanes import INLINE
from overturning.dem.kernel.mechanics import clamp_friction, updated_maximum
from overturning.units import STANDARD_GRAVITY as GRAVITY

FAST_TURN: Final = 0.1
"""Largest tangent of the angle by which the lowest point moves along a rim in a step that is not the finest."""


@njit(**INLINE)
def released_spring_energy(
    body: BodyConstants,
    previous_point: VertexHistory,
    depth: float,
    stretch_before_slip: tuple[float, float],
    stretch_after_slip: tuple[float, float],
) -> float:
    """Return the energy released by the springs of a point in a step, per mass, m²/s².

    `stretch_before_slip` is the tangential stretch before slip and `stretch_after_slip` that after slip, m.
    """
    kx, ky = stretch_after_slip
    inside, was = depth > 0.0, previous_point.depth > 0.0
    sinking, over = depth - previous_point.depth, depth * previous_point.depth
    over = math.copysign(over if over < 0.0 else 0.0, sinking)
    stretched_x, stretched_y = stretch_before_slip[0] - kx, stretch_before_slip[1] - ky
    let_go = 0.5 * (
        body.tangential * ((previous_point.sx + kx) * stretched_x + (previous_point.sy + ky) * stretched_y)
        + body.stiffness * over
    )
    let_go = let_go if inside | was else 0.0
    # A deferred point starts with a compressed spring.
    return let_go - 0.5 * body.stiffness * (depth * depth) if inside & (previous_point.depth == 0.0) else let_go


@njit(**INLINE)
def compute_point_forces(
    body: BodyConstants,
    predicted: PredictedBody,
    point: PredictedPoint,
    previous_point: VertexHistory,
    change: BodyChange,
    step_is_fine: bool,
    has_rim: bool,
) -> tuple[ContactSum, LargestFindings, VertexHistory]:
    """Compute the forces of a contact point at the solution, within their limits, its findings, and its new state."""
    half, r, e = predicted.half, point.arm, plus(change.velocity, cross_product(change.spin, point.arm))
    u = plus(point.velocity, e)
    depth, tx, ty = point.depth - half * e.z, point.tx + half * e.x, point.ty + half * e.y
    depth = 0.0 if (point.deferred > 0.0) & (depth > 0.0) else depth
    inside, was = depth > 0.0, previous_point.depth > 0.0
    changed = point.depth if point.depth > depth else depth
    changed = -depth if was else changed
    spring = body.stiffness * depth if inside else 0.0
    n = spring - body.dashpot * u.z
    n = n if inside & ((point.held > 0.0) | (n > 0.0)) else 0.0
    tx, ty = (tx if inside else 0.0), (ty if inside else 0.0)
    most = body.friction * n
    hx, hy = -(body.tangential * tx) - body.dashpot * u.x, -(body.tangential * ty) - body.dashpot * u.y
    spin = plus(predicted.spin, change.spin)
    drift_x, drift_y, drifts, tilting = flat_landing_slip(
        body, r, plus(predicted.end, change.velocity), spin, point.held > 0.0
    )
    hx, hy = (-drift_x if drifts else hx), (-drift_y if drifts else hy)
    fx, fy, kx, ky, slips = clamp_friction(hx, hy, tx, ty, most, body.compliance, (point.held > 0.0, drifts))
    lever = Vector(r.x, r.y, tilting * r.z)
    off = r.z - lever.z
    power = (spring - n) * u.z - (
        (fx + body.tangential * kx) * (u.x - spin.y * off) + (fy + body.tangential * ky) * (u.y + spin.x * off)
    )
    let_go = released_spring_energy(
        body, previous_point, depth, (point.tx + half * e.x, point.ty + half * e.y), (kx, ky)
    )
    # A contact that closed within the step acts from the first touch, not for half of the step.
    fresh = inside & (not was)
    more = depth * (2.0 * half / (depth - previous_point.depth if fresh else 1.0)) - half if fresh else 0.0
    landing = (point.new_landing if fresh else previous_point.landing) - 2.0 * half
    carries = most > 0.0
    assumed = point.slides > 0.0
    wrong = carries & (slips != assumed)
    backwards = carries & assumed & (fx * point.dx + fy * point.dy < 0.0)
    # In a long step the spring is stretched although the point comes back; the velocity shows this.
    back = carries & slips & ((fx * previous_point.sx + fy * previous_point.sy > 0.0) | (fx * u.x + fy * u.y > 0.0))
    force = Vector(fx, fy, n)
    moment = cross_product(lever, force)
    findings = LargestFindings(
        changed, 1.0 if wrong & (not step_is_fine) else 0.0, 1.0 if backwards & (not step_is_fine) else 0.0,
        1.0 if carries & (not slips) else 0.0, 1.0 if back & (not step_is_fine) else 0.0, 0.0 if n > 0.0 else 1.0,
        depth,
    )  # fmt: skip
    x, y = (
        (u.x if has_rim else (predicted.place.x + r.x) + half * e.x),
        (u.y if has_rim else (predicted.place.y + r.y) + half * e.y),
    )
    return (
        ContactSum(force, moment, scale_vector(more, force), scale_vector(more, moment), power, let_go + more * power),
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
def rim_contact_turns_fast(state: BodyState, predicted: PredictedBody, largest_findings: LargestFindings) -> bool:
    """True if the lowest point of a tilted rim moves along it by more than `FAST_TURN` in the step."""
    a, b = rotation_matrix(state.turn), rotation_matrix(predicted.turn)
    across, ahead = a.xz * b.yz - a.yz * b.xz, a.xz * b.xz + a.yz * b.yz
    return (
        (largest_findings.off > 0.0)
        & (largest_findings.depth > 0.0)
        & ((abs(across) > FAST_TURN * ahead) | (ahead < 0.0))
    )


@njit(**INLINE)
def shaking_stays_weak(shaking: BodyShaking, end_acceleration: Vector, ticks: float, horizontal_limit: float) -> bool:
    """True if the base motion stays below the limit of a standing body at the end of this step and of the next sample.

    Above it, sample-long steps would let the springs vibrate too strongly, with too much sliding and rocking.
    """
    end = 2.0 * ticks
    x, y, up = (
        motion_at_tick_or_beyond(shaking.push_x, end, ticks),
        motion_at_tick_or_beyond(shaking.push_y, end, ticks),
        motion_at_tick_or_beyond(shaking.lift, end, ticks),
    )
    first, second = horizontal_limit * (GRAVITY + end_acceleration.z), horizontal_limit * (GRAVITY + up)
    below = (end_acceleration.x * end_acceleration.x + end_acceleration.y * end_acceleration.y < first * first) & (
        x * x + y * y < second * second
    )
    return below & (first > 0.0) & (second > 0.0)


@njit(**INLINE)
def step_findings(
    largest_findings: LargestFindings, normal_force: float, turns_fast: bool, motion_is_steady: bool
) -> StepFindings:
    """Return the findings of an attempted step for the clock; `turns_fast` requests a shorter step."""
    slides = (largest_findings.holds == 0.0) & (normal_force > 0.0)
    stands = motion_is_steady & (largest_findings.off == 0.0)
    return StepFindings(
        changed=largest_findings.changed > 0.0,
        fast=turns_fast,
        gentle=False,
        wrong=largest_findings.wrong > 0.0,
        reversed=largest_findings.reversed > 0.0,
        back=largest_findings.back > 0.0,
        slides=slides,
        stands=stands,
    )


class AcceptedBodyStep(NamedTuple):
    """State, peaks and accounts of a body, which an accepted step changes."""

    state: BodyState
    peaks: BodyPeaks
    account: BodyAccount


@njit(**INLINE)
def complete_step(
    body: BodyConstants,
    previous_step: AcceptedBodyStep,
    predicted: PredictedBody,
    change: BodyChange,
    contact_sum: ContactSum,
    deepest: float,
    step_ticks: float,
) -> AcceptedBodyStep:
    """Compute state, peaks and accounts of a body at the end of the step; `deepest` is its largest penetration, m."""
    (s, peaks, account), half = previous_step, predicted.half
    a, push, tick = centre_acceleration(contact_sum.force, predicted.shaking), predicted.shaking, s.tick + step_ticks
    v = plus(extrapolate(predicted.velocity, half, a), contact_sum.impulse)
    momentum = plus(extrapolate(predicted.momentum, half, contact_sum.moment), contact_sum.twist)
    place, turn = (
        extrapolate(predicted.place, half, change.velocity),
        rotate_quaternion(predicted.turn, half, change.spin),
    )
    f = rotation_matrix(turn)
    power = (push.x * v.x + push.y * v.y) - push.z * v.z
    torque = contact_sum.moment.z + (place.x * a.y - place.y * a.x)
    account = BodyAccount(
        account.work + half * (account.power + power),
        account.lost + (half * (account.loss + contact_sum.loss) + contact_sum.let_go),
        account.spin
        + (
            half * (account.torque + torque)
            + (contact_sum.twist.z + (place.x * contact_sum.impulse.y - place.y * contact_sum.impulse.x))
        ),
        power,
        contact_sum.loss,
        torque,
    )
    lean, x, y = lean_measure(f), place.x - body.foot * f.xz, place.y - body.foot * f.yz
    peaks = BodyPeaks(
        updated_maximum(peaks.lean, lean),
        updated_maximum(peaks.slip, x * x + y * y),
        updated_maximum(peaks.depth, deepest),
        tick if lean < body.critical else peaks.last_upright,
    )
    return AcceptedBodyStep(
        BodyState(
            place=place,
            turn=turn,
            velocity=v,
            momentum=momentum,
            spin=predicted.spin,
            acceleration=a,
            moment=contact_sum.moment,
            tick=tick,
        ),
        peaks,
        account,
    )
