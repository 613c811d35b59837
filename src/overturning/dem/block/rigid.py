"""Housner's rigid rocking block, solved exactly: what the block's kernel tends to where nothing slides.

While the block turns about a corner, θ̈ = −p² [(1 + a_up/g) sin(±α − θ) + (a/g) cos(±α − θ)] (Housner
1963; Zhang and Makris 2001). Between two samples both accelerations are linear; θ is a Taylor series, whose
coefficients follow from one another with those of sine and cosine (docs/method.md, "The exact rigid block"). Only ``+ -
* /``, roots and comparisons in the loop, as in the kernels; a mirrored case is exactly the mirror image.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.kernel.cache import keep_compiled
from overturning.dem.kernel.lanes import INNER, OPTIONS
from overturning.dem.kernel.mechanics import renormalised
from overturning.dem.limits import AFTERMATH
from overturning.dem.plan import rounded, shaking
from overturning.dem.time_step import rocking_time
from overturning.model.cases import Cases
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY

ORDER: Final = 8
"""Of the series. Of 5544 cases of the default study 4 gives nine flags other than 16 does, 5 to 8 at most one, 10 none;
of those that stand 8 gives the largest rotation to 4e-8 α in all but one of a hundred."""

LONGEST: Final = 0.25
"""Longest step, in 1/p; a sample is divided where it is longer."""

SHORTEST: Final = 2.0**-30
"""Shortest step, as a share of a sample; it is met only where a block stands still on its balance."""

REST: Final = 1e-6
"""Angular velocity over p below which a block that lands rests. Of these cases 1e-9 changes none, 1e-4 three sides."""

NEWTON: Final = 1e-15
"""Share of a sample to which impacts and turning points are found."""

CASE: Final = np.dtype([(name, "f8") for name in (
    "sine", "cosine", "square", "kept", "steps", "rest", "after", "amplitude", "tilt", "tilt_sine", "tilt_cosine",
)])  # fmt: skip
"""Of each case: sin α, cos α, (p · sampling interval)², the share of the velocity that an impact leaves, steps in a
sample, the velocity at rest (rad per sample), the sample at which it is undecided, the factor on the motion, the tilt
at the start (rad), and sine and cosine of what is left of α then."""


class Push(NamedTuple):
    """The base's motion from an instant of a sample on, over g; slopes are per sample."""

    ground: float
    ground_slope: float
    weight: float
    """1 + a_up/g"""
    weight_slope: float


class Rocking(NamedTuple):
    """What becomes of n rocking blocks."""

    overturned: NDArray[np.int8]
    """+1 fallen towards the azimuth, −1 the other way, 0 standing, −128 undecided 20/p after the record; (n,)."""
    peak_rotation: FloatArray
    """largest |θ|/α, π/2α of a block that fell, shape (n,)."""


@njit(**INNER)
def _from(push: Push, t: float) -> Push:
    """The motion from an instant later on."""
    ground, weight = push.ground + push.ground_slope * t, push.weight + push.weight_slope * t
    return Push(ground, push.ground_slope, weight, push.weight_slope)


@njit(**INNER)
def _lift_off(push: Push, left: float, tangent: float) -> tuple[float, float]:
    """Side over which a block at rest begins to rock in what is `left` of a sample, and how soon; else 0."""
    end = _from(push, left)
    side = -1.0 if push.ground > 0.0 else 1.0
    if -side * push.ground > push.weight * tangent:
        return side, 0.0
    side = -1.0 if end.ground > 0.0 else 1.0
    before, after = -side * push.ground - push.weight * tangent, -side * end.ground - end.weight * tangent
    return (side, left * (before / (before - after))) if after > 0.0 else (0.0, left)


@njit(**INNER)
def _expand(series: Any, side: float, push: Push, square: float) -> None:
    """Fill in the series of angle, velocity, and sine and cosine of what is left of α, from their first terms.

    Also of acceleration and jerk. Angles count towards the side over which the block leans; shape (6, order + 1).
    """
    angle, velocity, sine, cosine, acceleration, jerk = (
        series[0], series[1], series[2], series[3], series[4], series[5]
    )  # fmt: skip
    for k in range(angle.size - 1):
        drive = -side * push.ground * cosine[k] - push.weight * sine[k]
        if k > 0:
            drive -= side * push.ground_slope * cosine[k - 1] + push.weight_slope * sine[k - 1]
        of_sine, of_cosine = 0.0, 0.0
        for j in range(k + 1):
            of_sine -= velocity[j] * cosine[k - j]
            of_cosine += velocity[j] * sine[k - j]
        acceleration[k] = square * drive
        angle[k + 1], velocity[k + 1] = velocity[k] / (k + 1), acceleration[k] / (k + 1)
        if k > 0:
            jerk[k - 1] = k * acceleration[k]
        sine[k + 1], cosine[k + 1] = of_sine / (k + 1), of_cosine / (k + 1)


@njit(**INNER)
def _at(series: Any, t: float) -> tuple[float, float]:
    """A series at an instant, and its slope there."""
    value, slope = 0.0, 0.0
    for k in range(series.size - 1, -1, -1):
        slope, value = slope * t + value, value * t + series[k]
    return value, slope


@njit(**INNER)
def _root(series: Any, low: float, high: float) -> float:
    """Where a series changes its sign between two instants: by Newton's rule, by halving where that leads out."""
    rises = _at(series, high)[0] > 0.0
    t = 0.5 * (low + high)
    for _ in range(100):
        value, slope = _at(series, t)
        low, high = (low, t) if (value > 0.0) == rises else (t, high)
        before, t = t, t - value / slope if slope != 0.0 else low
        t = t if low <= t <= high else 0.5 * (low + high)
        if abs(t - before) <= NEWTON:
            break
    return t


@njit(**INNER)
def _keeps_sign(series: Any, length: float) -> bool:
    """Whether the first term of a series outweighs all others over a step, so that it has no zero there."""
    others = 0.0
    for k in range(series.size - 1, 0, -1):
        others = (others + abs(series[k])) * length
    return bool(abs(series[0]) > others)


@njit(**INNER)
def _longest_of_two_turns(series: Any, length: float) -> float:
    """The step, or a half of a half … of it, in which the block turns back at most twice.

    Once or never where velocity or acceleration keep their sign; twice where the jerk does.
    """
    while length > SHORTEST and not (
        _keeps_sign(series[1], length) or _keeps_sign(series[4], length) or _keeps_sign(series[5], length)
    ):
        length *= 0.5
    return length


@njit(**INNER)
def _turning_points(series: Any, length: float, starts: bool) -> tuple[float, float]:
    """First and second instant at which the block turns back in a step; the step's length where there is none.

    A block that starts moves away from the base, whatever the sign of a first term that rounding leaves.
    """
    velocity, acceleration = series[1], series[4]
    speeds_up = starts or acceleration[0] > 0.0
    between = length
    if speeds_up != (_at(acceleration, length)[0] > 0.0):
        between = _root(acceleration, 0.0, length)
    rises = velocity[0] > 0.0 or (velocity[0] == 0.0 and speeds_up)
    then, last = _at(velocity, between)[0] > 0.0, _at(velocity, length)[0] > 0.0
    first = _root(velocity, 0.0, between) if rises != then else length
    second = _root(velocity, between, length) if then != last else length
    return min(first, second), max(first, second)


@njit(**INNER)
def _landing(angle: Any, first: float, second: float, length: float) -> float:
    """Instant at which the block lands in a step with these turning points, else infinity."""
    low = 0.0
    for high in (first, second, length):
        if _at(angle, high)[0] < 0.0:
            return _root(angle, low, high)
        low = high
    return np.inf


@njit(**INNER)
def _follow(along: Any, up: Any, case: Any, series: Any) -> tuple[float, float]:
    """Side to which a block falls, not a number where it is undecided, and its largest angle, rad."""
    angle, velocity, sine, cosine = series[0], series[1], series[2], series[3]
    side = 1.0 if case.tilt > 0.0 else -1.0 if case.tilt < 0.0 else 0.0
    angle[0], velocity[0], sine[0], cosine[0] = abs(case.tilt), 0.0, case.tilt_sine, case.tilt_cosine
    peak, tangent, samples = angle[0], case.sine / case.cosine, along.size - 3
    scale, i = case.amplitude / STANDARD_GRAVITY, 0
    while i < case.after and not (i >= samples and side == 0.0):
        n, t = min(i, samples + 1), 0.0
        a, u = scale * along[n], 1.0 + scale * up[n]
        sample = Push(a, scale * along[n + 1] - a, u, 1.0 + scale * up[n + 1] - u)
        while t < 1.0:
            starts = side == 0.0
            if starts:
                side, wait = _lift_off(_from(sample, t), 1.0 - t, tangent)
                if side == 0.0:
                    break
                t += wait
                angle[0], velocity[0], sine[0], cosine[0] = 0.0, 0.0, case.sine, case.cosine
            end = min((np.floor(t * case.steps + 1e-9) + 1.0) / case.steps, 1.0)
            _expand(series, side, _from(sample, t), case.square)
            length = _longest_of_two_turns(series, end - t)
            end = end if length == end - t else t + length
            first, second = _turning_points(series, length, starts)
            then, rate = _at(angle, length)[0], _at(velocity, length)[0]
            if starts and first == length and then <= 0.0:  # it lifts by less than the digits hold
                side, t = 0.0, end
                continue
            hit = _landing(angle, first, second, length)
            for turn in (first, second):
                if turn < min(hit, length):
                    peak = max(peak, _at(angle, turn)[0])
                    if peak >= 0.5 * np.pi:
                        return side, 0.5 * np.pi
                    if i >= samples and _at(velocity, turn)[1] < 0.0:  # on a base at rest it never leans as far again
                        return 0.0, peak
            if hit <= length:
                angle[0], velocity[0], sine[0], cosine[0] = 0.0, -case.kept * _at(angle, hit)[1], case.sine, case.cosine
                t, side = t + hit, -side if velocity[0] >= case.rest else 0.0
                continue
            cosine[0], sine[0] = renormalised(_at(cosine, length)[0], _at(sine, length)[0])
            t, angle[0], velocity[0] = end, then, rate
            if then >= 0.5 * np.pi:
                return side, 0.5 * np.pi
        i += 1
    return (0.0 if side == 0.0 else np.nan), max(peak, angle[0])


@njit(nogil=True, **OPTIONS)
def _follow_all(ground: Any, row: Any, up: Any, cases: Any, order: int, found: Any) -> None:
    """Fill in side and largest angle of each case, shape (n, 2)."""
    series = np.zeros((6, order + 1))
    for k in range(cases.size):
        found[k, 0], found[k, 1] = _follow(ground[row[k]], up, cases[k], series)


keep_compiled(_follow_all)


def rocking(motion: Motion, cases: Cases, order: int = ORDER) -> Rocking:
    """Follow rigid blocks that rock and neither slide nor bounce, whatever their friction.

    Parameters
    ----------
    motion : Motion
        The ground's, linear between samples and from the last one to rest; without a vertical component the base moves
        level.
    cases : Cases
        n blocks; `friction` and `damping_factor` do not count.
    order : int
        Of the Taylor series, at least 2.

    Returns
    -------
    Rocking
        In the order of the cases; the bits of a case do not depend on the others.

    Notes
    -----
    A block at rest begins to rock where |a| > (g + a_up) B/H. An impact leaves 1 − 1.5 sin²α of the angular
    velocity, nothing from B/H = √2 on. The block has fallen at |θ| = 90°; after the record it is followed to its
    next turning point, after which it leans less, at most for 20/p. It never leaves the ground: where a_up < −g the
    answer means nothing.
    """
    height, ratio, tilt = (np.asarray(values) for values in (cases.height, cases.b_over_h, cases.initial_tilt))
    row, ground = shaking(motion, cases)
    up = np.zeros(ground.shape[1]) if motion.up is None else np.append(motion.up, np.zeros(3))
    per_sample = motion.sampling_interval / rocking_time(ratio * height, height)
    diagonal, alpha = np.sqrt(1.0 + ratio * ratio), rounded(np.arctan, ratio)
    table = np.zeros(cases.size, CASE)
    columns = {
        "sine": ratio / diagonal,
        "cosine": 1.0 / diagonal,
        "square": per_sample**2,
        "kept": np.maximum(1.0 - 1.5 * ratio * ratio / (1.0 + ratio * ratio), 0.0),
        "steps": np.ceil(per_sample / LONGEST),
        "rest": REST * per_sample,
        "after": motion.samples + np.ceil(AFTERMATH / per_sample),
        "amplitude": cases.amplitude,
        "tilt": tilt,
        "tilt_sine": rounded(np.sin, alpha - np.abs(tilt)),
        "tilt_cosine": rounded(np.cos, alpha - np.abs(tilt)),
    }
    for name, values in columns.items():
        table[name] = values
    found = np.zeros((cases.size, 2))
    _follow_all(ground, row, up, table, order, found)
    side = np.nan_to_num(found[:, 0], nan=INT8_MISSING).astype(np.int8)
    return Rocking(side, found[:, 1] / alpha)
