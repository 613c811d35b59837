"""Largest motion along many azimuths, without holding the rotated motions."""

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.motion.direction import direction_cosines

_SEEDS = 12
_STRIDE = 8
_GROUP = 12
_BLOCK = 4096


def checked_azimuths(azimuth_deg: ArrayLike) -> FloatArray:
    """Azimuths as a one-dimensional array; an ArgumentError where there are none, or one is not finite."""
    azimuths = np.atleast_1d(np.asarray(azimuth_deg, dtype=np.float64))
    if azimuths.ndim != 1 or azimuths.size == 0 or not np.isfinite(azimuths).all():
        raise ArgumentError("azimuth_deg: give one or more finite numbers of degrees, in one row")
    return azimuths


def cosines_of(azimuth_deg: ArrayLike) -> FloatArray:
    """Direction cosines, shape (m, 2): north, east; azimuths as in `checked_azimuths`."""
    return np.array([direction_cosines(float(azimuth)) for azimuth in checked_azimuths(azimuth_deg)])


def largest_along(pair: FloatArray, cosines: FloatArray) -> FloatArray:
    """Largest absolute motion along each of m azimuths, max_t |n(t) cos φ + e(t) sin φ|, in the unit of the motion.

    Samples that cannot be the largest along any of the azimuths are left out first: those nearer to the origin than the
    smallest of lower bounds, which a few extreme samples give. ``pair`` has shape (2, n), ``cosines`` (m, 2).
    """
    turns = np.pi * np.arange(_SEEDS) / _SEEDS
    some = pair[:, ::_STRIDE]
    seeds = [int(np.abs(np.cos(t) * some[0] + np.sin(t) * some[1]).argmax()) for t in turns]
    bounds = np.abs(cosines @ some[:, seeds]).max(axis=1)
    # The margins are for rounding; to keep a sample too many changes nothing.
    far = pair[:, pair[0] ** 2 + pair[1] ** 2 >= bounds.min() ** 2 * (1.0 - 1e-9)]
    largest = np.zeros(cosines.shape[0])
    for first in range(0, cosines.shape[0], _GROUP):
        group = cosines[first : first + _GROUP]
        largest[first : first + _GROUP] = _largest(
            _within_reach(far, group, bounds[first : first + _GROUP].min()), group
        )
    return largest


def _within_reach(pair: FloatArray, group: FloatArray, bound: float) -> FloatArray:
    """Samples that may reach the bound along one of a group of azimuths."""
    middle = group[len(group) // 2]
    along = np.abs(middle[0] * pair[0] + middle[1] * pair[1])
    across = np.abs(middle[0] * pair[1] - middle[1] * pair[0])
    # |p · u| ≤ |p · m| + |p × m| |sin δ| for an azimuth u at δ from the middle one m.
    sine = np.abs(middle[0] * group[:, 1] - middle[1] * group[:, 0]).max()
    return pair[:, along + across * sine >= bound * (1.0 - 1e-9)]


def _largest(pair: FloatArray, cosines: FloatArray) -> FloatArray:
    largest = np.zeros(cosines.shape[0])
    for first in range(0, pair.shape[1], _BLOCK):
        block = pair[:, first : first + _BLOCK]
        # Spelt out instead of a matrix product, whose last bit may differ with the width of the block.
        np.maximum(largest, np.abs(cosines[:, :1] * block[0] + cosines[:, 1:] * block[1]).max(axis=1), out=largest)
    return largest
