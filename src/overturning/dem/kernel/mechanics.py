"""Mechanics shared by the block and polygon kernels, in the order of docs/method.md.

Only ``+ - * /``, comparisons and selections are used: the last bits of libm functions differ between processors.
"""

import math

from numba import njit

from overturning.dem.kernel.lanes import INLINE, select


@njit(**INLINE)
def turned(c: float, s: float, turn: float) -> tuple[float, float]:
    """Cosine and sine of an angle turned by a small one, rad, by series to the fifth order."""
    square = turn * turn
    sine = turn * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0)))
    versine = square * (0.5 - square * (1.0 / 24.0))
    return c - (c * versine + s * sine), s - (s * versine - c * sine)


@njit(**INLINE)
def renormalised(c: float, s: float) -> tuple[float, float]:
    """A pair (c, s) near length 1 brought back to it: one step of Newton's rule for the inverse root."""
    unit = 1.5 - 0.5 * (c * c + s * s)
    return c * unit, s * unit


@njit(**INLINE)
def within(force: float, limit: float) -> float:
    """A force, or a spring's stretch, brought within ±limit; it keeps its sign."""
    return math.copysign(limit, force) if abs(force) > limit else force


@njit(**INLINE)
def larger(peak: float, value: float) -> float:
    """The larger of a peak so far and a value; a value that is not a number leaves the peak as it is."""
    return select(value > peak, value, peak)


@njit(**INLINE)
def within_circle(
    hx: float, hy: float, tx: float, ty: float, limit: float, compliance: float
) -> tuple[float, float, float, float, bool]:
    """A force in a plane and its spring's stretch brought within a limit along their directions; whether it slips."""
    square, stretch = hx * hx + hy * hy, tx * tx + ty * ty
    slips, holds = square > limit * limit, limit * compliance
    cut = slips & (stretch > holds * holds)
    share = limit / math.sqrt(square if slips else 1.0) if slips else 1.0
    kept = holds / math.sqrt(stretch if cut else 1.0) if cut else 1.0
    return hx * share, hy * share, tx * kept, ty * kept, slips
