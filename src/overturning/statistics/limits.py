"""The classical overturning limits, drawn beside the simulated ones."""

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.units import STANDARD_GRAVITY


def _positive(name: str, values: ArrayLike) -> FloatArray:
    array = np.asarray(values, dtype=np.float64)
    if not (np.isfinite(array).all() and (array > 0).all()):
        raise ArgumentError(f"{name}: {array.min() if array.size else 'nothing'}; it must be positive and finite")
    return array


def west_acceleration(b_over_h: ArrayLike) -> FloatArray:
    """Acceleration, m/s², at which a rigid block begins to rock: a = g B/H; `ArgumentError` if B/H is not positive.

    West's formula as given by Milne (1885, Transactions of the Seismological Society of Japan 8).
    """
    return STANDARD_GRAVITY * _positive("b_over_h", b_over_h)


def ishiyama_velocity(height: ArrayLike, b_over_h: ArrayLike) -> FloatArray:
    """Peak ground velocity, m/s, below which a block of height H, m, that rocks does not overturn.

    v = 0.4 √(8 g R/3 · (1 − cos α)/cos² α), R half the diagonal, tan α = B/H (Ishiyama 1982, Earthquake Engineering and
    Structural Dynamics 10); about 10 B/√H in cm and cm/s for slender blocks. `ArgumentError` if H or B/H is not positive.
    """
    tall, slenderness = _positive("height", height), _positive("b_over_h", b_over_h)
    alpha = np.arctan(slenderness)
    radius = tall * np.sqrt(1 + slenderness**2) / 2
    # 1 − cos α = 2 sin²(α/2), which keeps its digits for slender blocks.
    return np.asarray(
        0.4 * np.sqrt(8 * STANDARD_GRAVITY * radius / 3 * 2 * np.sin(alpha / 2) ** 2) / np.cos(alpha), dtype=np.float64
    )
