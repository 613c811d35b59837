"""Taylor series of the rotation of a rigid rocking block in time, and its roots."""

from typing import Any, Final, NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import INTERNAL_COMPILE_OPTIONS

ROOT_TIME_TOLERANCE_IN_SAMPLES: Final = 1e-15
"""Accuracy of the times of impacts and turning points, as a share of a sample."""


class BaseAccelerationAndGravityLinearInTime(NamedTuple):
    """Base acceleration and apparent gravity over g, linear in time until the next sample; slopes are per sample."""

    horizontal_in_g_at_time_zero: float
    horizontal_slope_per_sample: float
    apparent_gravity_over_g_at_time_zero: float
    """Apparent gravity over g, 1 + a_up/g."""
    apparent_gravity_slope_per_sample: float


@njit(**INTERNAL_COMPILE_OPTIONS)
def fill_higher_taylor_coefficients(
    taylor_coefficients_by_quantity: Any,
    rocking_side: float,
    base_motion: BaseAccelerationAndGravityLinearInTime,
    squared_product_of_p_and_sampling_interval: float,
) -> None:
    """Compute the Taylor coefficients of a rocking block's motion in a step from the motion at the start of the step.

    The rows of `taylor_coefficients_by_quantity`, shape (6, order + 1), are angle, velocity, sin and cos of (α −
    angle), acceleration, jerk; the first coefficients of the first four rows are given. Time is in samples. Angles are
    positive towards the side (±1) to which the block leans.
    """
    series, side = taylor_coefficients_by_quantity, rocking_side
    angle, velocity, sine, cosine, acceleration, jerk = series[0], series[1], series[2], series[3], series[4], series[5]
    slope = base_motion.horizontal_slope_per_sample
    for k in range(angle.size - 1):
        drive = -side * base_motion.horizontal_in_g_at_time_zero * cosine[k]
        drive -= base_motion.apparent_gravity_over_g_at_time_zero * sine[k]
        if k > 0:
            drive -= side * slope * cosine[k - 1] + base_motion.apparent_gravity_slope_per_sample * sine[k - 1]
        of_sine, of_cosine = 0.0, 0.0
        for j in range(k + 1):
            of_sine -= velocity[j] * cosine[k - j]
            of_cosine += velocity[j] * sine[k - j]
        acceleration[k] = squared_product_of_p_and_sampling_interval * drive
        angle[k + 1], velocity[k + 1] = velocity[k] / (k + 1), acceleration[k] / (k + 1)
        if k > 0:
            jerk[k - 1] = k * acceleration[k]
        sine[k + 1], cosine[k + 1] = of_sine / (k + 1), of_cosine / (k + 1)


@njit(**INTERNAL_COMPILE_OPTIONS)
def series_value_and_slope(taylor_coefficients: Any, time_from_step_start_in_samples: float) -> tuple[float, float]:
    """Return the value and the slope (per sample) of a Taylor series about the start of a step, at a time in it."""
    value, slope, time = 0.0, 0.0, time_from_step_start_in_samples
    for k in range(taylor_coefficients.size - 1, -1, -1):
        slope, value = slope * time + value, value * time + taylor_coefficients[k]
    return value, slope


@njit(**INTERNAL_COMPILE_OPTIONS)
def find_series_root(taylor_coefficients: Any, earliest_time_in_samples: float, latest_time_in_samples: float) -> float:
    """Return the root of a Taylor series between two times (in samples), by Newton's method and bisection."""
    low, high = earliest_time_in_samples, latest_time_in_samples
    rises = series_value_and_slope(taylor_coefficients, high)[0] > 0.0
    t = 0.5 * (low + high)
    for _ in range(100):
        value, slope = series_value_and_slope(taylor_coefficients, t)
        low, high = (low, t) if (value > 0.0) == rises else (t, high)
        before, t = t, t - value / slope if slope != 0.0 else low
        t = t if low <= t <= high else 0.5 * (low + high)
        if abs(t - before) <= ROOT_TIME_TOLERANCE_IN_SAMPLES:
            break
    return t


@njit(**INTERNAL_COMPILE_OPTIONS)
def series_certainly_keeps_sign(taylor_coefficients: Any, step_length_in_samples: float) -> bool:
    """True if a Taylor series has no zero in a step, since its first term exceeds the sum of all others in size."""
    others = 0.0
    for k in range(taylor_coefficients.size - 1, 0, -1):
        others = (others + abs(taylor_coefficients[k])) * step_length_in_samples
    return bool(abs(taylor_coefficients[0]) > others)
