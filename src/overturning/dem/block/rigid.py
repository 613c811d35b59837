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
from overturning.dem.block.taylor_series import (
    BaseAccelerationAndGravityLinearInTime,
    fill_higher_taylor_coefficients,
    find_series_root,
    series_certainly_keeps_sign,
    series_value_and_slope,
)
from overturning.dem.kernel.lanes import COMPILE_OPTIONS, INTERNAL_COMPILE_OPTIONS
from overturning.dem.kernel.mechanics import normalise_cosine_and_sine
from overturning.dem.limits import MAX_ROCKING_TIME_CONSTANTS_AFTER_RECORD
from overturning.dem.plan import azimuth_row_by_case_and_base_accelerations, evaluate_and_round_to_12_decimals
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


class RigidRockingOutcomes(NamedTuple):
    """Outcomes of n rigid rocking blocks: side of the fall and peak rotation."""

    overturned: NDArray[np.int8]
    """+1 fallen towards the azimuth, −1 the other way, 0 standing, −128 undecided 20/p after the record; (n,)."""
    peak_rotation: FloatArray
    """Largest |θ|/α, π/2α for a block that fell, shape (n,)."""


@njit(**INTERNAL_COMPILE_OPTIONS)
def _base_motion_with_later_origin(
    base_motion: BaseAccelerationAndGravityLinearInTime, origin_delay_in_samples: float
) -> BaseAccelerationAndGravityLinearInTime:
    """Return a linear base motion, with time counted from an origin that lies `origin_delay_in_samples` later."""
    delay = origin_delay_in_samples
    ground = base_motion.horizontal_in_g_at_time_zero + base_motion.horizontal_slope_per_sample * delay
    weight = base_motion.apparent_gravity_over_g_at_time_zero + base_motion.apparent_gravity_slope_per_sample * delay
    return BaseAccelerationAndGravityLinearInTime(
        ground, base_motion.horizontal_slope_per_sample, weight, base_motion.apparent_gravity_slope_per_sample
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def _rocking_side_and_waiting_time(
    base_motion: BaseAccelerationAndGravityLinearInTime, remaining_time_in_samples: float, b_over_h: float
) -> tuple[float, float]:
    """Return the side to which a resting block starts to rock within the rest of a sample, and the time until then.

    The side is ±1. If the block stays at rest, the side is 0 and the time is `remaining_time_in_samples`. Times are in
    samples.
    """
    remaining = remaining_time_in_samples
    end = _base_motion_with_later_origin(base_motion, remaining)
    side = -1.0 if base_motion.horizontal_in_g_at_time_zero > 0.0 else 1.0
    if -side * base_motion.horizontal_in_g_at_time_zero > base_motion.apparent_gravity_over_g_at_time_zero * b_over_h:
        return side, 0.0
    side = -1.0 if end.horizontal_in_g_at_time_zero > 0.0 else 1.0
    before, after = (
        -side * base_motion.horizontal_in_g_at_time_zero - base_motion.apparent_gravity_over_g_at_time_zero * b_over_h,
        -side * end.horizontal_in_g_at_time_zero - end.apparent_gravity_over_g_at_time_zero * b_over_h,
    )
    return (side, remaining * (before / (before - after))) if after > 0.0 else (0.0, remaining)


@njit(**INTERNAL_COMPILE_OPTIONS)
def _limit_step_to_two_turning_points(taylor_coefficients_by_quantity: Any, step_length_in_samples: float) -> float:
    """Return a step's length, halved until the rotation of the block has at most two turning points in the step.

    There is at most one turning point if the velocity or acceleration keeps its sign, at most two if the jerk does.
    """
    series, length = taylor_coefficients_by_quantity, step_length_in_samples
    while length > SHORTEST_STEP_IN_SAMPLES and not (
        series_certainly_keeps_sign(series[1], length)
        or series_certainly_keeps_sign(series[4], length)
        or series_certainly_keeps_sign(series[5], length)
    ):
        length *= 0.5
    return length


@njit(**INTERNAL_COMPILE_OPTIONS)
def _first_two_turning_point_times(
    taylor_coefficients_by_quantity: Any, step_length_in_samples: float, starts_to_rock_at_step_start: bool
) -> tuple[float, float]:
    """Return the times of the first two turning points of a block's rotation in a step; the step's length if missing.

    Times are from the start of the step, in samples. A block that starts to rock is assumed to accelerate away from the
    base, even if rounding gives its first acceleration the opposite sign.
    """
    velocity, acceleration = taylor_coefficients_by_quantity[1], taylor_coefficients_by_quantity[4]
    speeds_up, end = starts_to_rock_at_step_start or acceleration[0] > 0.0, step_length_in_samples
    between = end
    if speeds_up != (series_value_and_slope(acceleration, end)[0] > 0.0):
        between = find_series_root(acceleration, 0.0, end)
    rises = velocity[0] > 0.0 or (velocity[0] == 0.0 and speeds_up)
    then, last = (
        series_value_and_slope(velocity, between)[0] > 0.0, series_value_and_slope(velocity, end)[0] > 0.0,
    )  # fmt: skip
    first = find_series_root(velocity, 0.0, between) if rises != then else end
    second = find_series_root(velocity, between, end) if then != last else end
    return min(first, second), max(first, second)


@njit(**INTERNAL_COMPILE_OPTIONS)
def _landing_time(
    angle_taylor_coefficients: Any,
    first_turning_time_in_samples: float,
    second_turning_time_in_samples: float,
    step_length_in_samples: float,
) -> float:
    """Return the time from a step's start at which a rocking block lands on its base, in samples; infinity if none."""
    low = 0.0
    for high in (first_turning_time_in_samples, second_turning_time_in_samples, step_length_in_samples):
        if series_value_and_slope(angle_taylor_coefficients, high)[0] < 0.0:
            return find_series_root(angle_taylor_coefficients, low, high)
        low = high
    return np.inf


@njit(**INTERNAL_COMPILE_OPTIONS)
def _base_motion_of_sample(
    horizontal_acceleration_by_sample_m_s2: Any,
    upward_acceleration_by_sample_m_s2: Any,
    amplitude_factor_divided_by_g: float,
    sample_index: int,
) -> BaseAccelerationAndGravityLinearInTime:
    """Return the base motion from a sample to the next, scaled by the amplitude factor, in units of g."""
    scale, across, up = (
        amplitude_factor_divided_by_g, horizontal_acceleration_by_sample_m_s2, upward_acceleration_by_sample_m_s2,
    )  # fmt: skip
    a, u = scale * across[sample_index], 1.0 + scale * up[sample_index]
    return BaseAccelerationAndGravityLinearInTime(
        a, scale * across[sample_index + 1] - a, u, 1.0 + scale * up[sample_index + 1] - u
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def _peak_angle_and_whether_case_ends(
    angle_taylor_coefficients: Any,
    angular_velocity_taylor_coefficients: Any,
    turning_times_in_samples: tuple[float, float],
    landing_or_step_end_in_samples: float,
    peak_angle_so_far_rad: float,
    record_has_ended: bool,
) -> tuple[float, bool]:
    """Return a block's largest angle up to a step's end, rad, and True if the case ends at one of its turning points.

    A case ends if the block has fallen (angle π/2). After the record it also ends at the next peak of the angle, since
    later peaks are smaller. Turning points from `landing_or_step_end_in_samples` on do not count.
    """
    peak = peak_angle_so_far_rad
    for time in turning_times_in_samples:
        if time < landing_or_step_end_in_samples:
            peak = max(peak, series_value_and_slope(angle_taylor_coefficients, time)[0])
            if peak >= 0.5 * np.pi or (
                record_has_ended and series_value_and_slope(angular_velocity_taylor_coefficients, time)[1] < 0.0
            ):
                return peak, True
    return peak, False


@njit(**INTERNAL_COMPILE_OPTIONS)
def _simulate_fall_side_and_peak_angle(
    horizontal_acceleration_by_sample_m_s2: Any,
    upward_acceleration_by_sample_m_s2: Any,
    case_table_row: Any,
    taylor_coefficients_by_quantity: Any,
) -> tuple[float, float]:
    """Simulate one rigid block; return the side to which it falls and its largest angle, rad.

    The side is 1 towards the azimuth, −1 away from it, 0 if the block stands, NaN if it is undecided.
    """
    series, across, up, case = (
        taylor_coefficients_by_quantity, horizontal_acceleration_by_sample_m_s2, upward_acceleration_by_sample_m_s2,
        case_table_row,
    )  # fmt: skip
    angle, velocity, sine, cosine = series[0], series[1], series[2], series[3]
    side = 1.0 if case.initial_tilt > 0.0 else -1.0 if case.initial_tilt < 0.0 else 0.0
    angle[0], velocity[0] = abs(case.initial_tilt), 0.0
    sine[0], cosine[0] = (
        case.sine_of_critical_angle_minus_initial_tilt,
        case.cosine_of_critical_angle_minus_initial_tilt,
    )
    sin_alpha, cos_alpha = case.sine_of_critical_angle, case.cosine_of_critical_angle
    peak, tangent, samples = angle[0], sin_alpha / cos_alpha, across.size - 3
    scale, i = case.amplitude_factor / STANDARD_GRAVITY, 0
    step_count, square = case.steps_per_sample, case.squared_product_of_p_and_sampling_interval
    while i < case.end_sample_if_undecided and not (i >= samples and side == 0.0):
        n, t = min(i, samples + 1), 0.0
        sample = _base_motion_of_sample(across, up, scale, n)
        while t < 1.0:
            starts = side == 0.0
            if starts:
                side, wait = _rocking_side_and_waiting_time(_base_motion_with_later_origin(sample, t), 1.0 - t, tangent)
                if side == 0.0:
                    break
                t += wait
                angle[0], velocity[0], sine[0], cosine[0] = 0.0, 0.0, sin_alpha, cos_alpha
            end = min((np.floor(t * step_count + 1e-9) + 1.0) / step_count, 1.0)
            fill_higher_taylor_coefficients(series, side, _base_motion_with_later_origin(sample, t), square)
            length = _limit_step_to_two_turning_points(series, end - t)
            end = end if length == end - t else t + length
            first, second = _first_two_turning_point_times(series, length, starts)
            then, rate = series_value_and_slope(angle, length)[0], series_value_and_slope(velocity, length)[0]
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
                angle[0], velocity[0] = 0.0, -case.restitution_coefficient * series_value_and_slope(angle, hit)[1]
                sine[0], cosine[0] = sin_alpha, cos_alpha
                t, side = t + hit, -side if velocity[0] >= case.max_rest_angular_velocity_rad_per_sample else 0.0
                continue
            cosine[0], sine[0] = normalise_cosine_and_sine(
                series_value_and_slope(cosine, length)[0], series_value_and_slope(sine, length)[0]
            )
            t, angle[0], velocity[0] = end, then, rate
            if then >= 0.5 * np.pi:
                return side, 0.5 * np.pi
        i += 1
    return (0.0 if side == 0.0 else np.nan), max(peak, angle[0])


@njit(nogil=True, **COMPILE_OPTIONS)
def _simulate_rigid_blocks(
    horizontal_acceleration_by_azimuth_m_s2: Any,
    motion_row_by_case: Any,
    upward_acceleration_by_sample_m_s2: Any,
    case_table: Any,
    taylor_series_order: int,
    fall_side_and_peak_angle_by_case_out: Any,
) -> None:
    """Simulate n rigid blocks; fill an array of shape (n, 2) with side of the fall and largest angle (rad).

    The side is that of `_simulate_fall_side_and_peak_angle`.
    """
    series, out = np.zeros((6, taylor_series_order + 1)), fall_side_and_peak_angle_by_case_out
    for k in range(case_table.size):
        out[k, 0], out[k, 1] = _simulate_fall_side_and_peak_angle(
            horizontal_acceleration_by_azimuth_m_s2[motion_row_by_case[k]], upward_acceleration_by_sample_m_s2,
            case_table[k], series,
        )  # fmt: skip


cache_compiled_kernel(_simulate_rigid_blocks)


def simulate_rigid_rocking(
    motion: Motion, cases: Cases, taylor_series_order: int = TAYLOR_SERIES_ORDER
) -> RigidRockingOutcomes:
    """Simulate rigid blocks that rock without sliding or bouncing, whatever their friction.

    Parameters
    ----------
    motion : Motion
        Ground motion, linear between samples, and from the last sample to zero within one sample; without a vertical
        component the base moves only horizontally.
    cases : Cases
        n blocks; `friction` and `damping_factor` are ignored.
    taylor_series_order : int
        Order of the Taylor series, at least 2.

    Returns
    -------
    RigidRockingOutcomes
        Outcomes in the order of the cases; the outcome of a case does not depend on the other cases, to the last bit.

    Notes
    -----
    A block at rest starts to rock if |a| > (g + a_up) B/H. The coefficient of restitution is 1 − 1.5 sin²α, and 0
    for B/H ≥ √2. The block has fallen at |θ| = 90°. After the record the block is simulated until the
    next peak of its rotation, since later peaks are smaller, and for at most 20/p (p: rocking frequency). The block
    never leaves the ground: the outcome is meaningless if a_up < −g.
    """
    height, ratio, tilt = (np.asarray(values) for values in (cases.height, cases.b_over_h, cases.initial_tilt))
    row, ground = azimuth_row_by_case_and_base_accelerations(motion, cases)
    up = np.zeros(ground.shape[1]) if motion.up is None else np.append(motion.up, np.zeros(3))
    per_sample = motion.sampling_interval / rocking_time_constant(ratio * height, height)
    diagonal, alpha = np.sqrt(1.0 + ratio * ratio), evaluate_and_round_to_12_decimals(np.arctan, ratio)
    table = np.zeros(cases.case_count, RIGID_CASE_TABLE_DTYPE)
    columns = {
        "sine_of_critical_angle": ratio / diagonal,
        "cosine_of_critical_angle": 1.0 / diagonal,
        "squared_product_of_p_and_sampling_interval": per_sample**2,
        "restitution_coefficient": np.maximum(1.0 - 1.5 * ratio * ratio / (1.0 + ratio * ratio), 0.0),
        "steps_per_sample": np.ceil(per_sample / LONGEST_STEP_IN_ROCKING_TIME_CONSTANTS),
        "max_rest_angular_velocity_rad_per_sample": MAX_REST_ANGULAR_VELOCITY_TO_P_RATIO * per_sample,
        "end_sample_if_undecided": motion.sample_count + np.ceil(MAX_ROCKING_TIME_CONSTANTS_AFTER_RECORD / per_sample),
        "amplitude_factor": cases.amplitude,
        "initial_tilt": tilt,
        "sine_of_critical_angle_minus_initial_tilt": evaluate_and_round_to_12_decimals(np.sin, alpha - np.abs(tilt)),
        "cosine_of_critical_angle_minus_initial_tilt": evaluate_and_round_to_12_decimals(np.cos, alpha - np.abs(tilt)),
    }
    for name, values in columns.items():
        table[name] = values
    found = np.zeros((cases.case_count, 2))
    _simulate_rigid_blocks(ground, row, up, table, taylor_series_order, found)
    side = np.nan_to_num(found[:, 0], nan=INT8_MISSING).astype(np.int8)
    return RigidRockingOutcomes(side, found[:, 1] / alpha)
