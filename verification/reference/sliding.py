"""The exact sliding block: a mass on a moving base with friction only (Newmark 1965).

The acceleration of the base is linear between samples, and so is the relative acceleration while the block slides in
one direction. Velocity and displacement are its integrals, and the instants at which sliding starts or stops are roots
of linear or quadratic polynomials: there is no time step and no tolerance.
"""

import itertools
import math

import numpy as np
from numpy.typing import ArrayLike

from overturning.units import STANDARD_GRAVITY


def peak_and_final_slip(base_acceleration: ArrayLike, sampling_interval: float, friction: float) -> tuple[float, float]:
    """Return the largest and the final slip, m, of a rigid mass on a base that shakes horizontally.

    The acceleration of the base, m/s² towards +s, is linear between the samples; after the last one it is 0. Returns
    the largest absolute displacement relative to the base, and the final displacement, positive towards +s, both in m.
    Raises a ValueError unless μ > 0: without friction the block never stops.
    """
    if not friction > 0:
        raise ValueError(f"friction: {friction}; it must be above 0")
    limit = friction * STANDARD_GRAVITY
    samples = np.asarray(base_acceleration, dtype=np.float64)
    base = np.concatenate([samples, [0.0]])
    displacement = velocity = peak = 0.0
    for left, right in itertools.pairwise(base):
        displacement, velocity, highest = _slip_velocity_and_max_slip_after_interval(
            displacement, velocity, left, right, sampling_interval, limit
        )
        peak = max(peak, highest)
    # The base moves steadily: friction stops the block.
    displacement += math.copysign(velocity**2 / (2.0 * limit), velocity) if velocity else 0.0
    return max(peak, abs(displacement)), displacement


def _slip_velocity_and_max_slip_after_interval(
    slip: float,
    slip_velocity: float,
    base_acceleration_at_start: float,
    base_acceleration_at_end: float,
    sampling_interval: float,
    friction_times_gravity: float,
) -> tuple[float, float, float]:
    """Return slip and slip velocity after one sampling interval, and the largest absolute slip in it.

    The slip, m, is the displacement of the block relative to the base since the start of the record. The accelerations
    of the base are in m/s², and `friction_times_gravity` is μ g, m/s².
    """
    slope = (base_acceleration_at_end - base_acceleration_at_start) / sampling_interval
    t, peak = 0.0, abs(slip)
    while t < sampling_interval:
        ground = base_acceleration_at_start + slope * t
        if slip_velocity == 0.0:
            if abs(ground) <= friction_times_gravity:
                start = _time_until_sliding(ground, slope, friction_times_gravity)
                if t + start >= sampling_interval:
                    break
                t += start
                ground = math.copysign(friction_times_gravity, slope)
            direction = -math.copysign(1.0, ground)
        else:
            direction = math.copysign(1.0, slip_velocity)
        # Relative acceleration −a(t) − direction · μg; the velocity is a parabola.
        first, second = -ground - direction * friction_times_gravity, -slope
        rest = sampling_interval - t
        stop = _time_until_stop(slip_velocity, first, second, rest)
        slip += slip_velocity * stop + first * stop**2 / 2.0 + second * stop**3 / 6.0
        slip_velocity += first * stop + second * stop**2 / 2.0
        peak = max(peak, abs(slip))
        t += stop
        if stop < rest:
            slip_velocity = 0.0
    return slip, slip_velocity, peak


def _time_until_sliding(
    base_acceleration: float, base_acceleration_rate: float, friction_times_gravity: float
) -> float:
    """Return the time, s, until the base acceleration, which changes at a constant rate, reaches μ g or −μ g."""
    if base_acceleration_rate == 0.0:
        return math.inf
    return max(
        (math.copysign(friction_times_gravity, base_acceleration_rate) - base_acceleration) / base_acceleration_rate,
        0.0,
    )


def _time_until_stop(
    relative_velocity: float, relative_acceleration: float, relative_acceleration_rate: float, remaining_time: float
) -> float:
    """Return the first positive time, s, at which the sliding velocity is zero; at most `remaining_time`.

    Velocity, acceleration and its rate are those of the block relative to the base, now; the velocity at the time t is
    v + a t + ȧ t²/2.
    """
    first, second = relative_acceleration, relative_acceleration_rate
    if relative_velocity == 0.0:
        # Sliding has just begun; the velocity returns to zero at −2 first/second.
        roots = [-2.0 * first / second] if second else []
    else:
        discriminant = first**2 - 2.0 * second * relative_velocity
        if discriminant < 0:
            return remaining_time
        q = -(first + math.copysign(math.sqrt(discriminant), first))
        roots = [2.0 * relative_velocity / q] if q else []
        if second:
            roots.append(q / second)
    later = [root for root in roots if root > 1e-15]
    return min([remaining_time, *later])
