"""Exact solution of Housner's rigid rocking block, the limit of the block's kernel for stiff contacts without slip.

While the block turns about a corner, θ̈ = −p² [(1 + a_up/g) sin(±α − θ) + (a/g) cos(±α − θ)] (Housner
1963; Zhang and Makris 2001). Between two samples both accelerations are linear; θ is a Taylor series, whose
coefficients follow recursively with those of sine and cosine (docs/method.md, "The exact rigid block"). The loop uses
only ``+ - * /``, roots and comparisons, as the kernels do; a mirrored case gives exactly the mirrored result.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.block.tables import RIGID_CASE_TABLE_DTYPE
from overturning.dem.kernel.lanes import COMPILE_OPTIONS, INTERNAL_COMPILE_OPTIONS
from overturning.dem.kernel.mechanics import normalise_cosine_and_sine
from overturning.dem.limits import MAX_ROCKING_TIME_CONSTANTS_AFTER_RECORD
from overturning.dem.plan import azimuth_rows_and_base_accelerations, evaluate_and_round_results
from overturning.dem.time_step import rocking_time_constant
from overturning.kernel_cache import cache_compiled_kernel
from overturning.model.cases import Cases
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY

TAYLOR_SERIES_ORDER: Final = 8
"""Order of the Taylor series. In 5544 cases of the default study, nine flags differ between orders 4 and 16, at most
one for orders 5 to 8, none for order 10. Order 8 gives the peak rotation to 4e-8 α in 99 % of the standing cases."""

LONGEST_STEP_IN_ROCKING_TIME_CONSTANTS: Final = 0.25
"""Longest step, in units of 1/p; a longer sample is divided."""

SHORTEST_STEP_IN_SAMPLES: Final = 2.0**-30
"""Shortest step, as a share of a sample; it occurs only if a block balances without motion."""

MAX_REST_ANGULAR_VELOCITY_TO_P_RATIO: Final = 1e-6
"""Angular velocity, in units of p, below which a block that lands comes to rest. In the same 5544 cases, 1e-9 changes
no side, 1e-4 changes three."""

ROOT_TIME_TOLERANCE_IN_SAMPLES: Final = 1e-15
"""Accuracy of the times of impacts and turning points, as a share of a sample."""


class BaseAccelerationRampInG(NamedTuple):
    """Base acceleration, g, that changes linearly until the next sample; slopes are per sampling interval."""

    horizontal_at_origin: float
    horizontal_slope_per_sample: float
    apparent_gravity_at_origin: float
    """Apparent gravity over g, 1 + a_up/g."""
    apparent_gravity_slope_per_sample: float


class RigidRockingOutcomes(NamedTuple):
    """Outcomes of n rigid rocking blocks: side of the fall and peak rotation."""

    overturned: NDArray[np.int8]
    """+1 fallen towards the azimuth, −1 the other way, 0 standing, −128 undecided 20/p after the record; (n,)."""
    peak_rotation: FloatArray
    """Largest |θ|/α, π/2α for a block that fell, shape (n,)."""


@njit(**INTERNAL_COMPILE_OPTIONS)
def _base_motion_with_later_origin(base_motion: BaseAccelerationRampInG, delay: float) -> BaseAccelerationRampInG:
    """Return a linear base motion as a function of time, with a time origin that is `delay` later.

    Times are in sampling intervals.
    """
    ground = base_motion.horizontal_at_origin + base_motion.horizontal_slope_per_sample * delay
    weight = base_motion.apparent_gravity_at_origin + base_motion.apparent_gravity_slope_per_sample * delay
    return BaseAccelerationRampInG(
        ground, base_motion.horizontal_slope_per_sample, weight, base_motion.apparent_gravity_slope_per_sample
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def _rocking_side_and_start_time(
    base_motion: BaseAccelerationRampInG, remaining_time: float, b_over_h: float
) -> tuple[float, float]:
    """Return the side to which a resting block starts to rock within the rest of a sample, and the time until then.

    The side is 0, and the time `remaining_time`, if it does not start. Times are in samples.
    """
    end = _base_motion_with_later_origin(base_motion, remaining_time)
    side = -1.0 if base_motion.horizontal_at_origin > 0.0 else 1.0
    if -side * base_motion.horizontal_at_origin > base_motion.apparent_gravity_at_origin * b_over_h:
        return side, 0.0
    side = -1.0 if end.horizontal_at_origin > 0.0 else 1.0
    before, after = (
        -side * base_motion.horizontal_at_origin - base_motion.apparent_gravity_at_origin * b_over_h,
        -side * end.horizontal_at_origin - end.apparent_gravity_at_origin * b_over_h,
    )
    return (side, remaining_time * (before / (before - after))) if after > 0.0 else (0.0, remaining_time)


@njit(**INTERNAL_COMPILE_OPTIONS)
def _fill_taylor_series(
    taylor_series: Any, side: float, base_motion: BaseAccelerationRampInG, square_of_p_times_sampling_interval: float
) -> None:
    """Compute the higher Taylor coefficients of a rocking block's motion in a step; the first ones are given.

    The rows of `taylor_series`, shape (6, order + 1), are angle, velocity, sin and cos of (α − angle), acceleration,
    jerk. Angles are positive towards the side to which the block leans.
    """
    angle, velocity, sine, cosine, acceleration, jerk = (
        taylor_series[0], taylor_series[1], taylor_series[2], taylor_series[3], taylor_series[4], taylor_series[5]
    )  # fmt: skip
    slope = base_motion.horizontal_slope_per_sample
    for k in range(angle.size - 1):
        drive = -side * base_motion.horizontal_at_origin * cosine[k] - base_motion.apparent_gravity_at_origin * sine[k]
        if k > 0:
            drive -= side * slope * cosine[k - 1] + base_motion.apparent_gravity_slope_per_sample * sine[k - 1]
        of_sine, of_cosine = 0.0, 0.0
        for j in range(k + 1):
            of_sine -= velocity[j] * cosine[k - j]
            of_cosine += velocity[j] * sine[k - j]
        acceleration[k] = square_of_p_times_sampling_interval * drive
        angle[k + 1], velocity[k + 1] = velocity[k] / (k + 1), acceleration[k] / (k + 1)
        if k > 0:
            jerk[k - 1] = k * acceleration[k]
        sine[k + 1], cosine[k + 1] = of_sine / (k + 1), of_cosine / (k + 1)


@njit(**INTERNAL_COMPILE_OPTIONS)
def _series_value_and_slope(taylor_series: Any, time: float) -> tuple[float, float]:
    """Return the value and the slope of a Taylor series at a time."""
    value, slope = 0.0, 0.0
    for k in range(taylor_series.size - 1, -1, -1):
        slope, value = slope * time + value, value * time + taylor_series[k]
    return value, slope


@njit(**INTERNAL_COMPILE_OPTIONS)
def _find_series_root(taylor_series: Any, earliest_time: float, latest_time: float) -> float:
    """Return the root of a Taylor series between two times, by Newton's method and bisection."""
    rises = _series_value_and_slope(taylor_series, latest_time)[0] > 0.0
    t = 0.5 * (earliest_time + latest_time)
    for _ in range(100):
        value, slope = _series_value_and_slope(taylor_series, t)
        earliest_time, latest_time = (earliest_time, t) if (value > 0.0) == rises else (t, latest_time)
        before, t = t, t - value / slope if slope != 0.0 else earliest_time
        t = t if earliest_time <= t <= latest_time else 0.5 * (earliest_time + latest_time)
        if abs(t - before) <= ROOT_TIME_TOLERANCE_IN_SAMPLES:
            break
    return t


@njit(**INTERNAL_COMPILE_OPTIONS)
def _series_keeps_sign(taylor_series: Any, step_length: float) -> bool:
    """True if a Taylor series has no zero in a step, because its first term exceeds the sum of all others."""
    others = 0.0
    for k in range(taylor_series.size - 1, 0, -1):
        others = (others + abs(taylor_series[k])) * step_length
    return bool(abs(taylor_series[0]) > others)


@njit(**INTERNAL_COMPILE_OPTIONS)
def _limit_step_to_two_turning_points(taylor_series: Any, step_length: float) -> float:
    """Return a step's length, halved until the rotation of the block has at most two turning points in the step.

    There is at most one if velocity or acceleration keeps its sign, at most two if the jerk does.
    """
    while step_length > SHORTEST_STEP_IN_SAMPLES and not (
        _series_keeps_sign(taylor_series[1], step_length)
        or _series_keeps_sign(taylor_series[4], step_length)
        or _series_keeps_sign(taylor_series[5], step_length)
    ):
        step_length *= 0.5
    return step_length


@njit(**INTERNAL_COMPILE_OPTIONS)
def _first_two_turning_point_times(taylor_series: Any, step_length: float, starts_to_rock: bool) -> tuple[float, float]:
    """Return the times of the first two turning points of a block's rotation in a step, else the step's length.

    A block that starts to rock moves away from the base, even if rounding gives the first term the opposite sign.
    """
    velocity, acceleration = taylor_series[1], taylor_series[4]
    speeds_up = starts_to_rock or acceleration[0] > 0.0
    between = step_length
    if speeds_up != (_series_value_and_slope(acceleration, step_length)[0] > 0.0):
        between = _find_series_root(acceleration, 0.0, step_length)
    rises = velocity[0] > 0.0 or (velocity[0] == 0.0 and speeds_up)
    then, last = (
        _series_value_and_slope(velocity, between)[0] > 0.0, _series_value_and_slope(velocity, step_length)[0] > 0.0,
    )  # fmt: skip
    first = _find_series_root(velocity, 0.0, between) if rises != then else step_length
    second = _find_series_root(velocity, between, step_length) if then != last else step_length
    return min(first, second), max(first, second)


@njit(**INTERNAL_COMPILE_OPTIONS)
def _landing_time(
    angle_series: Any, first_turning_point: float, second_turning_point: float, step_length: float
) -> float:
    """Return the time at which a rocking block lands on its base in a step; infinity if it does not."""
    low = 0.0
    for high in (first_turning_point, second_turning_point, step_length):
        if _series_value_and_slope(angle_series, high)[0] < 0.0:
            return _find_series_root(angle_series, low, high)
        low = high
    return np.inf


@njit(**INTERNAL_COMPILE_OPTIONS)
def _base_motion_of_sample(
    horizontal_acceleration: Any, vertical_acceleration: Any, amplitude_factor_over_g: float, sample: int
) -> BaseAccelerationRampInG:
    """Return the base motion from a sample to the next, in units of g; `scale` multiplies the accelerations (m/s²)."""
    a, u = (
        amplitude_factor_over_g * horizontal_acceleration[sample],
        1.0 + amplitude_factor_over_g * vertical_acceleration[sample],
    )
    return BaseAccelerationRampInG(
        a, amplitude_factor_over_g * horizontal_acceleration[sample + 1] - a, u,
        1.0 + amplitude_factor_over_g * vertical_acceleration[sample + 1] - u,
    )  # fmt: skip


@njit(**INTERNAL_COMPILE_OPTIONS)
def _peak_angle_and_whether_case_ends(
    angle_series: Any,
    velocity_series: Any,
    turning_points: tuple[float, float],
    end_time: float,
    peak_angle: float,
    record_has_ended: bool,
) -> tuple[float, bool]:
    """Return a block's largest angle up to the end of a step, and True if the case ends at a turning point.

    A case ends if the block has fallen (π/2). After the record each peak is smaller than the one before, so that it
    also ends at its next peak. Turning points from `end_time` on do not count.
    """
    for time in turning_points:
        if time < end_time:
            peak_angle = max(peak_angle, _series_value_and_slope(angle_series, time)[0])
            if peak_angle >= 0.5 * np.pi or (
                record_has_ended and _series_value_and_slope(velocity_series, time)[1] < 0.0
            ):
                return peak_angle, True
    return peak_angle, False


@njit(**INTERNAL_COMPILE_OPTIONS)
def _simulate_rigid_block(
    horizontal_acceleration: Any, vertical_acceleration: Any, case_parameters: Any, taylor_series: Any
) -> tuple[float, float]:
    """Simulate one rigid block; return the side to which it falls and its largest angle, rad.

    The side is 0 if the block stands, NaN if it is undecided.
    """
    angle, velocity, sine, cosine = taylor_series[0], taylor_series[1], taylor_series[2], taylor_series[3]
    side = 1.0 if case_parameters.initial_tilt > 0.0 else -1.0 if case_parameters.initial_tilt < 0.0 else 0.0
    angle[0], velocity[0] = abs(case_parameters.initial_tilt), 0.0
    sine[0], cosine[0] = (
        case_parameters.sine_of_tilt_left_to_critical_angle,
        case_parameters.cosine_of_tilt_left_to_critical_angle,
    )
    sin_alpha, cos_alpha = case_parameters.sine_of_critical_angle, case_parameters.cosine_of_critical_angle
    peak, tangent, samples = angle[0], sin_alpha / cos_alpha, horizontal_acceleration.size - 3
    scale, i = case_parameters.amplitude_factor / STANDARD_GRAVITY, 0
    step_count, square_of_p_times_sampling_interval = (
        case_parameters.steps_per_sample,
        case_parameters.square_of_p_times_sampling_interval,
    )
    while i < case_parameters.end_sample_if_undecided and not (i >= samples and side == 0.0):
        n, t = min(i, samples + 1), 0.0
        sample = _base_motion_of_sample(horizontal_acceleration, vertical_acceleration, scale, n)
        while t < 1.0:
            starts = side == 0.0
            if starts:
                side, wait = _rocking_side_and_start_time(_base_motion_with_later_origin(sample, t), 1.0 - t, tangent)
                if side == 0.0:
                    break
                t += wait
                angle[0], velocity[0], sine[0], cosine[0] = 0.0, 0.0, sin_alpha, cos_alpha
            end = min((np.floor(t * step_count + 1e-9) + 1.0) / step_count, 1.0)
            _fill_taylor_series(
                taylor_series, side, _base_motion_with_later_origin(sample, t), square_of_p_times_sampling_interval
            )
            length = _limit_step_to_two_turning_points(taylor_series, end - t)
            end = end if length == end - t else t + length
            first, second = _first_two_turning_point_times(taylor_series, length, starts)
            then, rate = _series_value_and_slope(angle, length)[0], _series_value_and_slope(velocity, length)[0]
            if starts and first == length and then <= 0.0:  # the uplift is below rounding
                side, t = 0.0, end
                continue
            hit = _landing_time(angle, first, second, length)
            peak, ends = _peak_angle_and_whether_case_ends(
                angle, velocity, (first, second), min(hit, length), peak, i >= samples
            )
            if ends:
                return (side, 0.5 * np.pi) if peak >= 0.5 * np.pi else (0.0, peak)
            if hit <= length:
                angle[0], velocity[0] = (
                    0.0,
                    -case_parameters.restitution_coefficient * _series_value_and_slope(angle, hit)[1],
                )
                sine[0], cosine[0] = sin_alpha, cos_alpha
                t, side = (
                    t + hit,
                    -side if velocity[0] >= case_parameters.max_rest_angular_velocity_rad_per_sample else 0.0,
                )
                continue
            cosine[0], sine[0] = normalise_cosine_and_sine(
                _series_value_and_slope(cosine, length)[0], _series_value_and_slope(sine, length)[0]
            )
            t, angle[0], velocity[0] = end, then, rate
            if then >= 0.5 * np.pi:
                return side, 0.5 * np.pi
        i += 1
    return (0.0 if side == 0.0 else np.nan), max(peak, angle[0])


@njit(nogil=True, **COMPILE_OPTIONS)
def _simulate_rigid_blocks(
    horizontal_acceleration: Any,
    motion_row_by_case: Any,
    vertical_acceleration: Any,
    cases: Any,
    series_order: int,
    outcomes_out: Any,
) -> None:
    """Simulate n rigid blocks; fill `outcomes_out`, shape (n, 2), with side of the fall and largest angle (rad)."""
    series = np.zeros((6, series_order + 1))
    for k in range(cases.size):
        outcomes_out[k, 0], outcomes_out[k, 1] = _simulate_rigid_block(
            horizontal_acceleration[motion_row_by_case[k]], vertical_acceleration, cases[k], series
        )


cache_compiled_kernel(_simulate_rigid_blocks)


def simulate_rigid_rocking(
    motion: Motion, cases: Cases, series_order: int = TAYLOR_SERIES_ORDER
) -> RigidRockingOutcomes:
    """Simulate rigid blocks that rock without sliding or bouncing, whatever their friction.

    Parameters
    ----------
    motion : Motion
        Ground motion, linear between samples and from the last sample to zero; the base moves level if it has no
        vertical component.
    cases : Cases
        n blocks; `friction` and `damping_factor` are ignored.
    series_order : int
        Order of the Taylor series, at least 2.

    Returns
    -------
    RigidRockingOutcomes
        Outcomes in the order of the cases; the bits of a case do not depend on the others.

    Notes
    -----
    A block at rest starts to rock if |a| > (g + a_up) B/H. The coefficient of restitution is 1 − 1.5 sin²α, and 0
    for B/H ≥ √2. The block has fallen at |θ| = 90°. After the record it is simulated until its next turning
    point, since its later peaks are smaller, and for at most 20/p. It never leaves the ground: the outcome is
    meaningless if a_up < −g.
    """
    height, ratio, tilt = (np.asarray(values) for values in (cases.height, cases.b_over_h, cases.initial_tilt))
    row, ground = azimuth_rows_and_base_accelerations(motion, cases)
    up = np.zeros(ground.shape[1]) if motion.up is None else np.append(motion.up, np.zeros(3))
    per_sample = motion.sampling_interval / rocking_time_constant(ratio * height, height)
    diagonal, alpha = np.sqrt(1.0 + ratio * ratio), evaluate_and_round_results(np.arctan, ratio)
    table = np.zeros(cases.case_count, RIGID_CASE_TABLE_DTYPE)
    columns = {
        "sine_of_critical_angle": ratio / diagonal,
        "cosine_of_critical_angle": 1.0 / diagonal,
        "square_of_p_times_sampling_interval": per_sample**2,
        "restitution_coefficient": np.maximum(1.0 - 1.5 * ratio * ratio / (1.0 + ratio * ratio), 0.0),
        "steps_per_sample": np.ceil(per_sample / LONGEST_STEP_IN_ROCKING_TIME_CONSTANTS),
        "max_rest_angular_velocity_rad_per_sample": MAX_REST_ANGULAR_VELOCITY_TO_P_RATIO * per_sample,
        "end_sample_if_undecided": motion.sample_count + np.ceil(MAX_ROCKING_TIME_CONSTANTS_AFTER_RECORD / per_sample),
        "amplitude_factor": cases.amplitude,
        "initial_tilt": tilt,
        "sine_of_tilt_left_to_critical_angle": evaluate_and_round_results(np.sin, alpha - np.abs(tilt)),
        "cosine_of_tilt_left_to_critical_angle": evaluate_and_round_results(np.cos, alpha - np.abs(tilt)),
    }
    for name, values in columns.items():
        table[name] = values
    found = np.zeros((cases.case_count, 2))
    _simulate_rigid_blocks(ground, row, up, table, series_order, found)
    side = np.nan_to_num(found[:, 0], nan=INT8_MISSING).astype(np.int8)
    return RigidRockingOutcomes(side, found[:, 1] / alpha)
