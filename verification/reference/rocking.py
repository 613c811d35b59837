"""Housner's rocking block, event-driven: an answer that shares nothing with the distinct element kernel.

θ̈ = −p² [(1 + a_up/g) sin(α sgn θ − θ) + (a/g) cos(α sgn θ − θ)], p² = 3g/4R, while the block turns about a corner;
at θ = 0 the angular velocity is multiplied by e = 1 − 1.5 sin²α (Housner 1963; Makris & Konstantinidis 2003).
The block neither slides nor bounces. Between the events the Dormand–Prince pair 5(4) runs with a tight tolerance; an
impact is found by bisection of the step.
"""

from typing import Any, Final

import numpy as np
from numba import njit
from numpy.typing import ArrayLike

from overturning.dem.kernel.cache import keep_compiled
from overturning.units import STANDARD_GRAVITY

TOLERANCE: Final = 1e-10
"""Local error of angle (rad) and of angular velocity over p."""

REST: Final = 1e-7
"""Angular velocity over p below which a block on its base stops rocking: an amplitude of about 1e-14/α."""


@njit
def _acceleration(t: float, angle: float, side: float, a: Any, interval: float, alpha: float, square: float) -> float:
    i = min(int(t / interval), a.size - 2)
    ground = a[i] + (a[i + 1] - a[i]) * (t / interval - i)
    lean = alpha * side - angle
    return -square * (np.sin(lean) + ground * np.cos(lean))


@njit
def _step(
    t: float, x: float, v: float, h: float, side: float, a: Any, interval: float, alpha: float, square: float
) -> tuple[float, float, float]:
    """One step of Dormand and Prince; angle, angular velocity, and the estimated error."""
    f = _acceleration
    k1x, k1v = v, f(t, x, side, a, interval, alpha, square)
    k2x = v + h * k1v / 5
    k2v = f(t + h / 5, x + h * k1x / 5, side, a, interval, alpha, square)
    k3x = v + h * (3 * k1v + 9 * k2v) / 40
    k3v = f(t + 3 * h / 10, x + h * (3 * k1x + 9 * k2x) / 40, side, a, interval, alpha, square)
    k4x = v + h * (44 * k1v / 45 - 56 * k2v / 15 + 32 * k3v / 9)
    x4 = x + h * (44 * k1x / 45 - 56 * k2x / 15 + 32 * k3x / 9)
    k4v = f(t + 4 * h / 5, x4, side, a, interval, alpha, square)
    k5x = v + h * (19372 * k1v / 6561 - 25360 * k2v / 2187 + 64448 * k3v / 6561 - 212 * k4v / 729)
    x5 = x + h * (19372 * k1x / 6561 - 25360 * k2x / 2187 + 64448 * k3x / 6561 - 212 * k4x / 729)
    k5v = f(t + 8 * h / 9, x5, side, a, interval, alpha, square)
    k6x = v + h * (9017 * k1v / 3168 - 355 * k2v / 33 + 46732 * k3v / 5247 + 49 * k4v / 176 - 5103 * k5v / 18656)
    x6 = x + h * (9017 * k1x / 3168 - 355 * k2x / 33 + 46732 * k3x / 5247 + 49 * k4x / 176 - 5103 * k5x / 18656)
    k6v = f(t + h, x6, side, a, interval, alpha, square)
    xn = x + h * (35 * k1x / 384 + 500 * k3x / 1113 + 125 * k4x / 192 - 2187 * k5x / 6784 + 11 * k6x / 84)
    vn = v + h * (35 * k1v / 384 + 500 * k3v / 1113 + 125 * k4v / 192 - 2187 * k5v / 6784 + 11 * k6v / 84)
    k7v = f(t + h, xn, side, a, interval, alpha, square)
    ex = 71 * k1x / 57600 - 71 * k3x / 16695 + 71 * k4x / 1920 - 17253 * k5x / 339200 + 22 * k6x / 525 - vn / 40
    ev = 71 * k1v / 57600 - 71 * k3v / 16695 + 71 * k4v / 1920 - 17253 * k5v / 339200 + 22 * k6v / 525 - k7v / 40
    return xn, vn, max(abs(h * ex), abs(h * ev) / np.sqrt(square))


@njit
def rock(
    a: Any, interval: float, end: float, alpha: float, square: float, ratio: float, tolerance: float, rest: float
) -> tuple[float, float]:
    """Side (+1, −1, 0) and largest abs(θ)/α of a block at rest under the accelerations a/g."""
    t, x, v, side, peak = 0.0, 0.0, 0.0, 0.0, 0.0
    h = interval
    threshold = np.tan(alpha)
    while t < end:
        if side == 0.0:
            # At rest: find the sample in which the threshold is passed, and the instant within.
            i = int(t / interval + 1e-9)
            if i >= a.size - 1:
                break
            left = a[i] + (a[i + 1] - a[i]) * max(t / interval - i, 0.0)
            if abs(left) <= threshold * (1 + 1e-12) and abs(a[i + 1]) <= threshold:
                t = (i + 1) * interval
                continue
            if abs(left) > threshold:
                side = -1.0 if left > 0 else 1.0
            else:
                level = threshold if a[i + 1] > 0 else -threshold
                t += (level - left) / (a[i + 1] - left) * ((i + 1) * interval - t) + 1e-12
                side = -1.0 if a[i + 1] > 0 else 1.0
            h = interval * 1e-3
            continue
        # A kink of the motion ends every step.
        border = (int(t / interval + 1e-9) + 1) * interval
        h = min(h, border - t, end - t + 1e-12)
        xn, vn, error = _step(t, x, v, h, side, a, interval, alpha, square)
        if error > tolerance and h > 1e-12:
            h *= max(0.2, 0.9 * (tolerance / error) ** 0.2)
            continue
        grown = h * min(4.0, 0.9 * (tolerance / max(error, 1e-30)) ** 0.2)
        if xn * side < 0.0:
            low, high = 0.0, h
            for _ in range(60):
                middle = 0.5 * (low + high)
                xm, _vm, _e = _step(t, x, v, middle, side, a, interval, alpha, square)
                if xm * side < 0.0:
                    high = middle
                else:
                    low = middle
            _xn, vn, _e = _step(t, x, v, high, side, a, interval, alpha, square)
            t += high
            x, v, side = 0.0, vn * ratio, -side
            h = interval * 1e-2
            if abs(v) < rest * np.sqrt(square):
                v, side = 0.0, 0.0
            continue
        t, x, v, h = t + h, xn, vn, max(grown, 1e-12)
        peak = max(peak, abs(x))
        if abs(x) >= 0.5 * np.pi:
            return side, peak / alpha
    return 0.0, peak / alpha


keep_compiled(rock)


def rocking_outcome(
    acceleration: ArrayLike, sampling_interval: float, height: float, b_over_h: float, *, aftermath: float = 20.0
) -> tuple[int, float]:
    """Side to which a block that rocks without sliding falls, +1, −1 or 0 for standing, and its largest abs(θ)/α.

    The acceleration of the base, m/s² towards +s, is linear between the samples and zero after them; the block is H
    metres high, and followed for ``aftermath``/p after the record.
    """
    samples = np.asarray(acceleration, dtype=np.float64) / STANDARD_GRAVITY
    ratio = b_over_h**2 / (1.0 + b_over_h**2)
    square = 1.5 * STANDARD_GRAVITY / (height * np.sqrt(1.0 + b_over_h**2))
    end = samples.size * sampling_interval + aftermath / np.sqrt(square)
    padded = np.concatenate([samples, np.zeros(3)])
    side, peak = rock(padded, sampling_interval, end, np.arctan(b_over_h), square, 1.0 - 1.5 * ratio, TOLERANCE, REST)
    return int(side), float(peak)
