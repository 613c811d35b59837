"""Independent references for a rigid body on a plane: its plastic landing, and its rocking in short steps."""

import math

import numpy as np
from numba import njit

from overturning.kernel_cache import cache_compiled_kernel


@cache_compiled_kernel
@njit
def velocities_and_impulses_of_flat_landing_without_bounce(arms, pivot_inertia):  # type: ignore[no-untyped-def]
    """Compute velocities and impulses of a body that lands flat without bounce, by Gauss-Seidel iteration.

    `arms`: positions of the points that touch, from the middle of the base, m. `pivot_inertia`: moment of inertia over
    mass, m², about the middle. Before the landing the body rotates with 1 rad/s about the point at −max(`arms`).
    Returns the upward velocity of the middle, m/s, the angular velocity, rad/s, and the impulses at the points over
    mass, m/s.
    """
    v, w, p = -arms.max(), 1.0, np.zeros(arms.size)
    for _ in range(2000):
        # Process the fastest descending point first.
        for i in np.argsort(v - w * arms):
            change = max(p[i] - (v - w * arms[i]) / (1.0 + arms[i] ** 2 / pivot_inertia), 0.0) - p[i]
            p[i], v, w = p[i] + change, v + change, w - change * arms[i] / pivot_inertia
    return v, w, p


@njit
def _base_acceleration_over_g_at_time(time, wave, interval):  # type: ignore[no-untyped-def]
    """Return the base acceleration over g at a time, s, of a `wave` that is linear between samples and ends with 0."""
    place = time / interval
    sample = int(place)
    if sample >= wave.size - 1:
        return 0.0
    return wave[sample] + (wave[sample + 1] - wave[sample]) * (place - sample)


@cache_compiled_kernel
@njit
def normalised_restoring_moment(time, lean, along, up, interval):  # type: ignore[no-untyped-def]
    """Return the moment that rotates a block back to rest, over m g R (weight times half the diagonal).

    `lean`: angle of the diagonal through the pivot corner to the vertical, rad.
    `along`, `up`: base acceleration over g.
    """
    weight = 1.0 + _base_acceleration_over_g_at_time(time, up, interval)
    return weight * math.sin(lean) + _base_acceleration_over_g_at_time(time, along, interval) * math.cos(lean)


@njit
def _angular_acceleration(time, lean, side, wave, interval, alpha, square):  # type: ignore[no-untyped-def]
    """Return the angular acceleration away from rest (1/s²) of a block that leans to a `side` by `lean` (rad)."""
    left = alpha - lean
    return -square * (math.sin(left) + side * _base_acceleration_over_g_at_time(time, wave, interval) * math.cos(left))


@njit
def _runge_kutta_step(time, lean, rate, h, side, wave, interval, alpha, square):  # type: ignore[no-untyped-def]
    """Return the lean of a rocking block (rad) and its rate (rad/s) after a Runge–Kutta step of length `h`, s."""
    first = rate, _angular_acceleration(time, lean, side, wave, interval, alpha, square)
    half = 0.5 * h
    middle = time + half
    second = (
        rate + half * first[1],
        _angular_acceleration(middle, lean + half * first[0], side, wave, interval, alpha, square),
    )
    third = (
        rate + half * second[1],
        _angular_acceleration(middle, lean + half * second[0], side, wave, interval, alpha, square),
    )
    fourth = (
        rate + h * third[1],
        _angular_acceleration(time + h, lean + h * third[0], side, wave, interval, alpha, square),
    )
    return (
        lean + h / 6.0 * (first[0] + 2.0 * second[0] + 2.0 * third[0] + fourth[0]),
        rate + h / 6.0 * (first[1] + 2.0 * second[1] + 2.0 * third[1] + fourth[1]),
    )


@cache_compiled_kernel
@njit
def fall_side_and_peak_rotation(
    wave, interval, b_over_h, alpha, frequency_parameter_squared, angular_velocity_after_over_before_impact
):  # type: ignore[no-untyped-def]
    """Return the side to which a rocking block falls, and its largest |θ|/α, with bisection at each impact.

    `wave`: base acceleration over g, linear between samples, with a 0 at the end. `alpha`: slenderness, rad.
    `frequency_parameter_squared`: p², 1/s². `angular_velocity_after_over_before_impact`: ratio of the angular
    velocities after and before an impact. Computed until 2 s after the record.
    """
    end = wave.size * interval + 2.0
    now, lean, rate, side, peak = 0.0, 0.0, 0.0, 0, 0.0
    while now < end:
        h = interval / 40
        if side == 0:
            if abs(_base_acceleration_over_g_at_time(now, wave, interval)) > b_over_h:
                side, lean, rate = (-1 if _base_acceleration_over_g_at_time(now, wave, interval) > 0.0 else 1), 0.0, 0.0
            else:
                now += 0.1 * h
                continue
        then = _runge_kutta_step(now, lean, rate, h, side, wave, interval, alpha, frequency_parameter_squared)
        if then[0] < 0.0:
            low, high = 0.0, h
            for _ in range(40):
                middle = 0.5 * (low + high)
                if (
                    _runge_kutta_step(
                        now, lean, rate, middle, side, wave, interval, alpha, frequency_parameter_squared
                    )[0]
                    < 0.0
                ):
                    high = middle
                else:
                    low = middle
            rate = (
                -angular_velocity_after_over_before_impact
                * _runge_kutta_step(now, lean, rate, high, side, wave, interval, alpha, frequency_parameter_squared)[1]
            )
            now, lean = now + high, 0.0
            side = -side if rate > 1e-6 * math.sqrt(frequency_parameter_squared) else 0
            continue
        now, lean, rate = now + h, then[0], then[1]
        peak = max(peak, lean)
        if lean > 0.5 * math.pi:
            return side, 0.5 * math.pi / alpha
    return 0, peak / alpha
