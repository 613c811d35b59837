"""How well a share is known from a sample."""

import math
from typing import Final

Z_95: Final = 1.959963984540054
"""Two-sided 95 % point of the normal distribution."""


def wilson(count: int, total: int, z: float = Z_95) -> tuple[float, float]:
    """Interval of a share by Wilson (1927), Journal of the American Statistical Association 22.

    Written out here because a sweep's companion should not wait for scipy.stats; a test holds it against scipy.

    Parameters
    ----------
    count, total : int
        Cases with the property, and all.
    z : float
        Point of the normal distribution.

    Returns
    -------
    low, high : float
        Shares between 0 and 1; (0, 1) where there are no cases.
    """
    if total == 0:
        return 0.0, 1.0
    share, square = count / total, z * z / total
    middle = (share + 0.5 * square) / (1.0 + square)
    half = z / (1.0 + square) * math.sqrt(share * (1.0 - share) / total + 0.25 * square / total)
    return (0.0 if count == 0 else middle - half), (1.0 if count == total else middle + half)
