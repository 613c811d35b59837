"""Independent references for bodies that slide without rotation, by explicit steps: on a plane, on a slope, in hops."""

import math

import numpy as np
from numba import njit

from overturning.kernel_cache import cache_compiled_kernel
from overturning.units import STANDARD_GRAVITY

STEPS_PER_SAMPLE = 200
SECONDS_AFTER_RECORD = 3.0
"""Time after the record in which a body comes to rest, s."""


@cache_compiled_kernel
@njit
def _final_slip_on_plane(base, dt, friction):  # type: ignore[no-untyped-def]
    """Return the final displacement (m) of a mass with friction on a horizontal base, by steps of `dt`."""
    x, y, vx, vy, brake = 0.0, 0.0, 0.0, 0.0, friction * STANDARD_GRAVITY * dt
    for step in range(base.shape[1]):
        vx, vy = vx - dt * base[0, step], vy - dt * base[1, step]
        speed = math.sqrt(vx * vx + vy * vy)
        kept = max(speed - brake, 0.0) / speed if speed > 0.0 else 0.0
        vx, vy = kept * vx, kept * vy
        x, y = x + dt * vx, y + dt * vy
    return x, y


@cache_compiled_kernel
@njit
def _final_slip_on_slope(base, dt, friction, cosine, sine):  # type: ignore[no-untyped-def]
    """Return the final displacement (m) up a slope of a mass with friction, by steps of `dt`."""
    place = velocity = 0.0
    for a in base:
        velocity -= dt * (a * cosine + STANDARD_GRAVITY * sine)
        drag = dt * friction * (STANDARD_GRAVITY * cosine - a * sine)
        velocity -= math.copysign(min(abs(velocity), drag), velocity)
        place += dt * velocity
    return place


@cache_compiled_kernel
@njit
def _final_slip_with_flights(along, up, dt, friction):  # type: ignore[no-untyped-def]
    """Return the final displacement (m) of a mass that slides and flies over its base, by steps of `dt`."""
    x, z, vx, vz = 0.0, 0.0, 0.0, 0.0
    for step in range(along.size):
        vx -= dt * along[step]
        vz -= dt * (STANDARD_GRAVITY + up[step])
        impulse = max(-vz, 0.0) if z <= 0.0 else 0.0
        vz += impulse
        vx -= math.copysign(min(abs(vx), friction * impulse), vx)
        x, z = x + dt * vx, z + dt * vz
    return x


def _acceleration_in_each_time_step(
    samples: np.ndarray, dt: float, interval: float, relative_time_in_step: float
) -> np.ndarray:
    """Return the acceleration at the same point of each time step; one value per step of `dt` s.

    `relative_time_in_step`: point of the step, 0 at its start, 1 at its end. The acceleration is linear between the
    samples, and 0 for `SECONDS_AFTER_RECORD` s after the record.
    """
    time = (np.arange(round((samples.size * interval + SECONDS_AFTER_RECORD) / dt)) + relative_time_in_step) * dt
    return np.interp(time, np.arange(samples.size + 1) * interval, np.append(samples, 0.0))


def final_slip_on_horizontal_plane(components: np.ndarray, interval: float, friction: float) -> tuple[float, float]:
    """Return the final slip (m) of a mass with isotropic friction on a base that moves in two directions."""
    dt = interval / STEPS_PER_SAMPLE
    return _final_slip_on_plane(
        np.stack([_acceleration_in_each_time_step(row, dt, interval, 0.5) for row in components]), dt, friction
    )


def final_slip_on_slope(acceleration: np.ndarray, interval: float, friction: float, tangent: float) -> float:
    """Return the final slip (m) of a mass with friction on a slope that rises towards the motion of its base."""
    dt, slant = interval / STEPS_PER_SAMPLE, math.hypot(1.0, tangent)
    base = _acceleration_in_each_time_step(acceleration, dt, interval, 0.5)
    return float(_final_slip_on_slope(base, dt, friction, 1.0 / slant, tangent / slant))


def final_slip_with_flights_and_landings(
    along: np.ndarray, up: np.ndarray, interval: float, friction: float, amplitude: float = 1.0
) -> float:
    """Return the final slip (m) of a block that slides, flies and lands without rotation or bounce.

    A plastic landing at velocity v reduces the horizontal velocity by µ·v, at most to zero.
    """
    dt = interval / STEPS_PER_SAMPLE
    return float(
        _final_slip_with_flights(
            *(_acceleration_in_each_time_step(amplitude * row, dt, interval, 0.0) for row in (along, up)), dt, friction
        )
    )
