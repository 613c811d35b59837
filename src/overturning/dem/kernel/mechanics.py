"""Mechanics shared by the block and polygon kernels, in the order of docs/method.md.

Only ``+ - * /``, comparisons and selections are used: the last bits of libm functions differ between processors.
"""

import math
from typing import Final

from numba import njit

from overturning.dem.kernel.lanes import INLINE, select

LANDING: Final = 4.0
"""How long a contact lands after it has closed, in h/K, the time in which a spring pushes out what it has caught: by
then the dashpots have stopped a block of B/H 0.15 or more, heave first and rotation last."""


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
def slides_flat(friction: float, slip: float, opening: float) -> bool:
    """Whether a base that lands flat slides, by its velocities along and off the ground, both without rotation.

    Dashpots stop the base before its rotation, which stops only later what it adds to the slip. Friction of a plastic
    landing goes by what remains after it, hence without rotation: all ends slide the same way.
    """
    return abs(slip) >= friction * abs(opening)


@njit(**INLINE)
def larger(peak: float, value: float) -> float:
    """The larger of a peak so far and a value; a value that is not a number leaves the peak as it is."""
    return select(value > peak, value, peak)


@njit(**INLINE)
def within_circle(
    hx: float, hy: float, tx: float, ty: float, limit: float, compliance: float, flat: tuple[bool, bool]
) -> tuple[float, float, float, float, bool]:
    """A force in a plane and its spring's stretch brought within a limit along their directions; whether it slips.

    `flat` says whether the point is held in a flat landing, and whether it slides meanwhile, as of `slides_flat`.
    """
    (held, drifts), square, stretch = flat, hx * hx + hy * hy, tx * tx + ty * ty
    slips, holds = (drifts if held else square > limit * limit), limit * compliance
    holds = holds if holds > 0.0 else 0.0
    cut = slips & (stretch > holds * holds)
    some = slips & (square > 0.0)
    share = limit / math.sqrt(square if some else 1.0) if slips else 1.0
    kept = holds / math.sqrt(stretch if cut else 1.0) if cut else 1.0
    return hx * share, hy * share, tx * kept, ty * kept, slips
