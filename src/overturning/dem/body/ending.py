"""Termination of a 3-D case: its energy, the tests for its end, and its results (docs/method.md)."""

from typing import Any, Final

import numpy as np
from numba import njit

from overturning.dem.body.state import (
    ROWS,
    VERTEX,
    BodyAccount,
    BodyConstants,
    BodyPeaks,
    BodyShaking,
    BodyState,
    Point,
    TerminationLimits,
    lean_of,
    spin_of,
)
from overturning.dem.body.vectors import Matrix, Vector, apply, cross, dot, frame_of, full, plus
from overturning.dem.kernel.clock import Attempt
from overturning.dem.kernel.ending import GOES_ON, REST_ENERGY, STILL_TO_SLIDE, UPRIGHT, CaseProgress, is_still
from overturning.dem.kernel.ground import within_sample
from overturning.dem.kernel.lanes import INLINE, INNER
from overturning.model.status import Status
from overturning.units import STANDARD_GRAVITY as GRAVITY

load_body, load_state, load_peaks = (ROWS.access(of).load for of in (BodyConstants, BodyState, BodyPeaks))
load_account, load_course, load_limits = (ROWS.access(of).load for of in (BodyAccount, CaseProgress, TerminationLimits))
load_shaking = ROWS.access(BodyShaking).load
load_memory = VERTEX.access(Point, "old").load
VERTEX_SIZE: Final = VERTEX.size
LENGTH: Final = ROWS.row(Attempt, "length")


@njit(**INLINE)
def twice_kinetic_energy(body: BodyConstants, s: BodyState) -> float:
    """Return twice the kinetic energy per mass, m²/s²."""
    return dot(s.velocity, s.velocity) + dot(s.momentum, spin_of(body, s))


@njit(**INLINE)
def total_of(s: BodyState) -> float:
    """Return a sum that is finite if position, rotation and velocity are."""
    v, p, q = s.velocity, s.place, s.turn
    return (v.x + v.y + v.z) + (p.x + p.y + p.z) + (q.w + q.x + q.y + q.z)


@njit(**INNER)
def energy(body: BodyConstants, s: BodyState, vertices: Any, count: int, j: int) -> float:
    """Compute the kinetic, gravitational and spring energy per mass, m²/s²."""
    springs = 0.0
    for i in range(count):
        one = load_memory(vertices[i * VERTEX_SIZE : (i + 1) * VERTEX_SIZE], j)
        depth = max(one.depth, 0.0)
        springs += body.stiffness * depth * depth + body.tangential * (one.sx * one.sx + one.sy * one.sy)
    return 0.5 * (twice_kinetic_energy(body, s) + springs) + GRAVITY * (s.place.z - body.foot)


@njit(**INLINE)
def spin_about_origin(s: BodyState) -> float:
    """Return the vertical angular momentum about the origin per mass, m²/s."""
    return float(s.momentum.z + (s.place.x * s.velocity.y - s.place.y * s.velocity.x))


@njit(**INNER)
def count_contacts(vertices: Any, count: int, j: int) -> int:
    """Count the vertices that penetrate the ground."""
    number = 0
    for i in range(count):
        number += 1 if load_memory(vertices[i * VERTEX_SIZE : (i + 1) * VERTEX_SIZE], j).depth > 0.0 else 0
    return number


@njit(**INLINE)
def tilt_energy(body: BodyConstants, reach: float, lean: float) -> float:
    """Return the energy per mass that tilts a body over the nearest edge to `lean`, at most to the critical angle."""
    square = min(lean, body.critical)
    return float(GRAVITY * (reach * np.sqrt(square) - body.foot * square / (1.0 + np.sqrt(1.0 - square))))


@njit(**INLINE)
def is_upright(body: BodyConstants, s: BodyState) -> bool:
    """True if the tilt of a body is below its critical angle."""
    return bool(lean_of(frame_of(s.turn)) < body.critical)


@njit(**INLINE)
def is_sliding(body: BodyConstants, s: BodyState, reach: float) -> bool:
    """True if a body will still slide or spin farther than `STILL_TO_SLIDE`; False without friction."""
    w, f = spin_of(body, s), frame_of(s.turn)
    v = plus(s.velocity, cross(w, Vector(-body.foot * f.xz, -body.foot * f.yz, -body.foot * f.zz)))
    turn = w.z * reach
    square = (v.x * v.x + v.y * v.y) + turn * turn
    return bool(body.friction > 0.0 and square >= 2.0 * STILL_TO_SLIDE * GRAVITY * body.friction)


@njit(**INLINE)
def pseudo_angle(x: float, y: float) -> float:
    """Return a measure of direction that increases with the angle, anticlockwise from x: 0 to 4, 1 per quarter."""
    share = abs(x) / (abs(x) + abs(y))
    if y >= 0.0:
        return 1.0 - share if x >= 0.0 else 1.0 + share
    return 3.0 - share if x < 0.0 else 3.0 + share


@njit(**INNER)
def has_fallen(f: Matrix, limits: TerminationLimits, sectors: Any) -> bool:
    """True if a body is tilted by at least its angle of fall in the direction in which it leans.

    For `sectors` see `overturning.model.solid.Solid`.
    """
    if not f.zz <= limits.fallen:
        return False
    if sectors.shape[0] == 0 or f.zx * f.zx + f.zy * f.zy == 0.0:
        return True
    turn, k = pseudo_angle(-f.zx, -f.zy), 0
    while k + 1 < sectors.shape[0] and turn >= sectors[k + 1, 0]:
        k += 1
    return bool(-((sectors[k, 1] * f.zx + sectors[k, 2] * f.zy) + sectors[k, 3] * f.zz) >= sectors[k, 4])


@njit(**INNER)
def has_ended(state: Any, vertices: Any, base: int, j: int, ticks: float, end: float, sectors: Any) -> int:
    """Return the `Status` of a case at the end of a sample, or `GOES_ON`; `base` counts the vertices of the base."""
    count = vertices.size // VERTEX_SIZE
    body, s, peaks = load_body(state, j), load_state(state, j), load_peaks(state, j)
    course, limits = load_course(state, j), load_limits(state, j)
    if not np.isfinite(total_of(s)) or peaks.depth > limits.deepest:
        return Status.UNSTABLE
    if has_fallen(frame_of(s.turn), limits, sectors):
        return Status.SIMULATED
    sample = course.sample + s.tick / ticks
    # A body that rests on its base after the last time at which it could start to move stays there.
    still = 0.5 * twice_kinetic_energy(body, s) < REST_ENERGY * GRAVITY * limits.reach
    if sample >= course.calm and still and count_contacts(vertices, count, j) >= base:
        return Status.SIMULATED
    if sample < end:
        return GOES_ON
    now = energy(body, s, vertices, count, j)
    stands = now < course.barrier and is_upright(body, s)
    # It can no longer fall, but its peak tilt is final only when its energy cannot reach it again. On one vertex the
    # weight compresses the spring: g²/2k less energy than in the rigid body.
    past = now + 0.5 * GRAVITY * GRAVITY / body.stiffness <= tilt_energy(body, limits.reach, peaks.lean)
    if stands and past and not is_sliding(body, s, limits.reach):
        return Status.SIMULATED
    if sample < course.after:
        return GOES_ON
    return Status.SIMULATED if stands else Status.UNDECIDED


@njit(**INNER)
def rests(state: Any, vertices: Any, count: int, base: int, j: int, rest_limit: float) -> bool:
    """True if a body rests upright on all vertices of its base, and none of them slides."""
    body, s, held = load_body(state, j), load_state(state, j), 0
    w, turning = s.spin, apply(full(body.inverse), s.moment)
    speed = norm(s.velocity) + body.foot * norm(w)
    step = body.step * state[LENGTH + j]
    if not is_still(speed, norm(s.acceleration) + body.foot * norm(turning), step, rest_limit):
        return False
    for i in range(count):
        one = load_memory(vertices[i * VERTEX_SIZE : (i + 1) * VERTEX_SIZE], j)
        held += 1 if one.normal > 0.0 and one.slid == 0.0 else 0
    return bool(held >= base and lean_of(frame_of(s.turn)) < UPRIGHT * UPRIGHT * body.critical)


@njit(**INLINE)
def norm(v: Vector) -> float:
    """Return the length of a vector."""
    return float(np.sqrt(dot(v, v)))


@njit(**INNER)
def finish_body(state: Any, vertices: Any, j: int, status: int, out: Any, sectors: Any) -> None:
    """Write the results of case j."""
    count = vertices.size // VERTEX_SIZE
    body, s, peaks = load_body(state, j), load_state(state, j), load_peaks(state, j)
    account, course, limits = load_account(state, j), load_course(state, j), load_limits(state, j)
    f = frame_of(s.turn)
    fallen = status == Status.SIMULATED and has_fallen(f, limits, sectors)
    out.fallen = 1.0 if fallen else 0.0
    out.overturning_time = course.upright_until if fallen else np.nan
    out.lean = max(peaks.lean, lean_of(f))
    out.peak_slip = np.sqrt(peaks.slip)
    out.slip_x, out.slip_y = s.place.x - body.foot * f.xz, s.place.y - body.foot * f.yz
    out.peak_penetration = peaks.depth
    balance = (energy(body, s, vertices, count, j) - course.energy) - account.work + account.lost
    out.energy_error = abs(balance) / max(account.work, course.barrier)
    swing = np.sqrt(GRAVITY * (body.foot * body.foot + limits.reach * limits.reach) ** 1.5)
    out.angular_momentum_error = abs(spin_about_origin(s) - limits.spin - account.spin) / swing
    out.qw, out.qx, out.qy, out.qz = s.turn


@njit(**INNER)
def record_state(state: Any, j: int, interval: float, ticks: float, path: Any) -> None:
    """Write the state of case j into a row of its trajectory."""
    body, s, shaking = load_body(state, j), load_state(state, j), load_shaking(state, j)
    path.time = (load_course(state, j).sample + s.tick / ticks) * interval
    path.x, path.y, path.z = s.place
    path.qw, path.qx, path.qy, path.qz = s.turn
    path.vx, path.vy, path.vz = s.velocity
    path.wx, path.wy, path.wz = spin_of(body, s)
    path.ground_x = -within_sample(shaking.push_x, s.tick)
    path.ground_y = -within_sample(shaking.push_y, s.tick)
    path.ground_z = within_sample(shaking.lift, s.tick)
