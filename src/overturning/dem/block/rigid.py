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
from overturning.dem.kernel.cache import cache_compiled_kernel
from overturning.dem.kernel.lanes import INNER, OPTIONS
from overturning.dem.kernel.mechanics import normalise_cosine_and_sine
from overturning.dem.kernel.tuples import table_dtype
from overturning.dem.limits import MAX_TIME_AFTER_RECORD
from overturning.dem.plan import base_motions_by_azimuth, evaluate_rounded
from overturning.dem.time_step import rocking_time
from overturning.model.cases import Cases
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY

ORDER: Final = 8
"""Order of the Taylor series. In 5544 cases of the default study, nine flags differ between orders 4 and 16, at most
one for orders 5 to 8, none for order 10. Order 8 gives the peak rotation to 4e-8 α in 99 % of the standing cases."""

LONGEST: Final = 0.25
"""Longest step, in units of 1/p; a longer sample is divided."""

SHORTEST: Final = 2.0**-30
"""Shortest step, as a share of a sample; it occurs only if a block balances without motion."""

REST: Final = 1e-6
"""Angular velocity, in units of p, below which a block that lands comes to rest. In the same 5544 cases, 1e-9 changes
no side, 1e-4 changes three."""

NEWTON: Final = 1e-15
"""Accuracy of the times of impacts and turning points, as a share of a sample."""


class RigidCaseColumns(NamedTuple):
    """Columns of the table of cases."""

    sine: float
    """Sine of α."""
    cosine: float
    """Cosine of α."""
    square: float
    """Square of p times the sampling interval."""
    restitution: float
    """Coefficient of restitution."""
    steps: float
    """Steps per sample."""
    rest: float
    """Angular velocity below which the block comes to rest, rad per sample."""
    after: float
    """Sample at which the case ends as undecided."""
    amplitude: float
    """Factor on the motion."""
    tilt: float
    """Initial rotation θ₀, rad."""
    tilt_sine: float
    """Sine of α − |θ₀|."""
    tilt_cosine: float
    """Cosine of α − |θ₀|."""


CASE: Final = table_dtype(RigidCaseColumns)


class LinearBaseMotion(NamedTuple):
    """Base motion over g from a given time within a sample, linear in time; slopes are per sample."""

    ground: float
    ground_slope: float
    weight: float
    """Apparent gravity over g, 1 + a_up/g."""
    weight_slope: float


class RigidRockingOutcomes(NamedTuple):
    """Outcomes of n rocking blocks."""

    overturned: NDArray[np.int8]
    """+1 fallen towards the azimuth, −1 the other way, 0 standing, −128 undecided 20/p after the record; (n,)."""
    peak_rotation: FloatArray
    """Largest |θ|/α, π/2α for a block that fell, shape (n,)."""


@njit(**INNER)
def _base_motion_after(base_motion: LinearBaseMotion, delay: float) -> LinearBaseMotion:
    """Return the base motion from a time `delay` later, in samples."""
    ground, weight = (
        base_motion.ground + base_motion.ground_slope * delay,
        base_motion.weight + base_motion.weight_slope * delay,
    )
    return LinearBaseMotion(ground, base_motion.ground_slope, weight, base_motion.weight_slope)


@njit(**INNER)
def _rocking_start(base_motion: LinearBaseMotion, remaining_time: float, b_over_h: float) -> tuple[float, float]:
    """Return side and time at which a block at rest starts to rock in the rest of a sample; side 0 if it does not."""
    end = _base_motion_after(base_motion, remaining_time)
    side = -1.0 if base_motion.ground > 0.0 else 1.0
    if -side * base_motion.ground > base_motion.weight * b_over_h:
        return side, 0.0
    side = -1.0 if end.ground > 0.0 else 1.0
    before, after = (
        -side * base_motion.ground - base_motion.weight * b_over_h,
        -side * end.ground - end.weight * b_over_h,
    )
    return (side, remaining_time * (before / (before - after))) if after > 0.0 else (0.0, remaining_time)


@njit(**INNER)
def _fill_taylor_series(series: Any, side: float, base_motion: LinearBaseMotion, squared_frequency: float) -> None:
    """Fill in the Taylor series from their first terms.

    The rows of `series`, shape (6, order + 1), are angle, velocity, sin and cos of (α − angle), acceleration, jerk.
    Angles are positive towards the side to which the block leans.
    """
    angle, velocity, sine, cosine, acceleration, jerk = (
        series[0], series[1], series[2], series[3], series[4], series[5]
    )  # fmt: skip
    for k in range(angle.size - 1):
        drive = -side * base_motion.ground * cosine[k] - base_motion.weight * sine[k]
        if k > 0:
            drive -= side * base_motion.ground_slope * cosine[k - 1] + base_motion.weight_slope * sine[k - 1]
        of_sine, of_cosine = 0.0, 0.0
        for j in range(k + 1):
            of_sine -= velocity[j] * cosine[k - j]
            of_cosine += velocity[j] * sine[k - j]
        acceleration[k] = squared_frequency * drive
        angle[k + 1], velocity[k + 1] = velocity[k] / (k + 1), acceleration[k] / (k + 1)
        if k > 0:
            jerk[k - 1] = k * acceleration[k]
        sine[k + 1], cosine[k + 1] = of_sine / (k + 1), of_cosine / (k + 1)


@njit(**INNER)
def _series_value_and_slope(series: Any, time: float) -> tuple[float, float]:
    """Evaluate a series and its slope at time t."""
    value, slope = 0.0, 0.0
    for k in range(series.size - 1, -1, -1):
        slope, value = slope * time + value, value * time + series[k]
    return value, slope


@njit(**INNER)
def _find_series_root(series: Any, low: float, high: float) -> float:
    """Find the root of a series between two times: by Newton's method, by bisection if that leaves the interval."""
    rises = _series_value_and_slope(series, high)[0] > 0.0
    t = 0.5 * (low + high)
    for _ in range(100):
        value, slope = _series_value_and_slope(series, t)
        low, high = (low, t) if (value > 0.0) == rises else (t, high)
        before, t = t, t - value / slope if slope != 0.0 else low
        t = t if low <= t <= high else 0.5 * (low + high)
        if abs(t - before) <= NEWTON:
            break
    return t


@njit(**INNER)
def _series_keeps_sign(series: Any, length: float) -> bool:
    """True if the first term of a series exceeds the sum of all others over a step, so that it has no zero there."""
    others = 0.0
    for k in range(series.size - 1, 0, -1):
        others = (others + abs(series[k])) * length
    return bool(abs(series[0]) > others)


@njit(**INNER)
def _limit_turning_points(series: Any, length: float) -> float:
    """Halve the step until the block has at most two turning points in it, and return its length.

    At most one if velocity or acceleration keeps its sign, at most two if the jerk does.
    """
    while length > SHORTEST and not (
        _series_keeps_sign(series[1], length)
        or _series_keeps_sign(series[4], length)
        or _series_keeps_sign(series[5], length)
    ):
        length *= 0.5
    return length


@njit(**INNER)
def _turning_points(series: Any, length: float, starts_to_rock: bool) -> tuple[float, float]:
    """Return the times of the first and second turning point in a step; the step length if there is none.

    A block that starts to rock moves away from the base, even if rounding gives the first term the opposite sign.
    """
    velocity, acceleration = series[1], series[4]
    speeds_up = starts_to_rock or acceleration[0] > 0.0
    between = length
    if speeds_up != (_series_value_and_slope(acceleration, length)[0] > 0.0):
        between = _find_series_root(acceleration, 0.0, length)
    rises = velocity[0] > 0.0 or (velocity[0] == 0.0 and speeds_up)
    then, last = _series_value_and_slope(velocity, between)[0] > 0.0, _series_value_and_slope(velocity, length)[0] > 0.0
    first = _find_series_root(velocity, 0.0, between) if rises != then else length
    second = _find_series_root(velocity, between, length) if then != last else length
    return min(first, second), max(first, second)


@njit(**INNER)
def _landing_time(angle: Any, first_turning_point: float, second_turning_point: float, length: float) -> float:
    """Return the time at which the block lands in a step with these turning points; infinity if it does not."""
    low = 0.0
    for high in (first_turning_point, second_turning_point, length):
        if _series_value_and_slope(angle, high)[0] < 0.0:
            return _find_series_root(angle, low, high)
        low = high
    return np.inf


@njit(**INNER)
def _simulate_block(horizontal_ground: Any, vertical_ground: Any, case: Any, series: Any) -> tuple[float, float]:
    """Simulate one block: return the side to which it falls (0 standing, NaN undecided) and its largest angle, rad."""
    angle, velocity, sine, cosine = series[0], series[1], series[2], series[3]
    side = 1.0 if case.tilt > 0.0 else -1.0 if case.tilt < 0.0 else 0.0
    angle[0], velocity[0], sine[0], cosine[0] = abs(case.tilt), 0.0, case.tilt_sine, case.tilt_cosine
    peak, tangent, samples = angle[0], case.sine / case.cosine, horizontal_ground.size - 3
    scale, i = case.amplitude / STANDARD_GRAVITY, 0
    while i < case.after and not (i >= samples and side == 0.0):
        n, t = min(i, samples + 1), 0.0
        a, u = scale * horizontal_ground[n], 1.0 + scale * vertical_ground[n]
        sample = LinearBaseMotion(a, scale * horizontal_ground[n + 1] - a, u, 1.0 + scale * vertical_ground[n + 1] - u)
        while t < 1.0:
            starts = side == 0.0
            if starts:
                side, wait = _rocking_start(_base_motion_after(sample, t), 1.0 - t, tangent)
                if side == 0.0:
                    break
                t += wait
                angle[0], velocity[0], sine[0], cosine[0] = 0.0, 0.0, case.sine, case.cosine
            end = min((np.floor(t * case.steps + 1e-9) + 1.0) / case.steps, 1.0)
            _fill_taylor_series(series, side, _base_motion_after(sample, t), case.square)
            length = _limit_turning_points(series, end - t)
            end = end if length == end - t else t + length
            first, second = _turning_points(series, length, starts)
            then, rate = _series_value_and_slope(angle, length)[0], _series_value_and_slope(velocity, length)[0]
            if starts and first == length and then <= 0.0:  # the uplift is below rounding
                side, t = 0.0, end
                continue
            hit = _landing_time(angle, first, second, length)
            for turn in (first, second):
                if turn < min(hit, length):
                    peak = max(peak, _series_value_and_slope(angle, turn)[0])
                    if peak >= 0.5 * np.pi:
                        return side, 0.5 * np.pi
                    # On a base at rest each peak is smaller than the one before.
                    if i >= samples and _series_value_and_slope(velocity, turn)[1] < 0.0:
                        return 0.0, peak
            if hit <= length:
                angle[0], velocity[0] = 0.0, -case.restitution * _series_value_and_slope(angle, hit)[1]
                sine[0], cosine[0] = case.sine, case.cosine
                t, side = t + hit, -side if velocity[0] >= case.rest else 0.0
                continue
            cosine[0], sine[0] = normalise_cosine_and_sine(
                _series_value_and_slope(cosine, length)[0], _series_value_and_slope(sine, length)[0]
            )
            t, angle[0], velocity[0] = end, then, rate
            if then >= 0.5 * np.pi:
                return side, 0.5 * np.pi
        i += 1
    return (0.0 if side == 0.0 else np.nan), max(peak, angle[0])


@njit(nogil=True, **OPTIONS)
def _simulate_blocks(
    horizontal_ground: Any, motion_rows: Any, vertical_ground: Any, cases: Any, series_order: int, outcomes: Any
) -> None:
    """Fill in the side and the largest angle of each case, shape (n, 2)."""
    series = np.zeros((6, series_order + 1))
    for k in range(cases.size):
        outcomes[k, 0], outcomes[k, 1] = _simulate_block(
            horizontal_ground[motion_rows[k]], vertical_ground, cases[k], series
        )


cache_compiled_kernel(_simulate_blocks)


def rocking(motion: Motion, cases: Cases, series_order: int = ORDER) -> RigidRockingOutcomes:
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
    Rocking
        Outcomes in the order of the cases; the bits of a case do not depend on the others.

    Notes
    -----
    A block at rest starts to rock if |a| > (g + a_up) B/H. The coefficient of restitution is 1 − 1.5 sin²α, and 0
    for B/H ≥ √2. The block has fallen at |θ| = 90°. After the record it is simulated until its next turning
    point, since its later peaks are smaller, and for at most 20/p. It never leaves the ground: the outcome is
    meaningless if a_up < −g.
    """
    height, ratio, tilt = (np.asarray(values) for values in (cases.height, cases.b_over_h, cases.initial_tilt))
    row, ground = base_motions_by_azimuth(motion, cases)
    up = np.zeros(ground.shape[1]) if motion.up is None else np.append(motion.up, np.zeros(3))
    per_sample = motion.sampling_interval / rocking_time(ratio * height, height)
    diagonal, alpha = np.sqrt(1.0 + ratio * ratio), evaluate_rounded(np.arctan, ratio)
    table = np.zeros(cases.size, CASE)
    columns = {
        "sine": ratio / diagonal,
        "cosine": 1.0 / diagonal,
        "square": per_sample**2,
        "restitution": np.maximum(1.0 - 1.5 * ratio * ratio / (1.0 + ratio * ratio), 0.0),
        "steps": np.ceil(per_sample / LONGEST),
        "rest": REST * per_sample,
        "after": motion.samples + np.ceil(MAX_TIME_AFTER_RECORD / per_sample),
        "amplitude": cases.amplitude,
        "tilt": tilt,
        "tilt_sine": evaluate_rounded(np.sin, alpha - np.abs(tilt)),
        "tilt_cosine": evaluate_rounded(np.cos, alpha - np.abs(tilt)),
    }
    for name, values in columns.items():
        table[name] = values
    found = np.zeros((cases.size, 2))
    _simulate_blocks(ground, row, up, table, series_order, found)
    side = np.nan_to_num(found[:, 0], nan=INT8_MISSING).astype(np.int8)
    return RigidRockingOutcomes(side, found[:, 1] / alpha)
