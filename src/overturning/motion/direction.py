"""Direction cosines that are the same on every processor, and the largest motion along many azimuths."""

import math
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError

_DECIMALS = 12
_TURNS = np.array([[np.cos(t), np.sin(t)] for t in np.pi * np.arange(12) / 12])
_STRIDE = 8
_GROUP = 12
_FEW = 400  # samples; with fewer it is not worth selecting them for each group of azimuths
_BLOCK = 4096


def cosine_and_sine_of_azimuth(azimuth_deg: float) -> tuple[float, float]:
    """Return the cosine and sine of an azimuth φ, degrees clockwise from north.

    The motion along φ is ``north * cos + east * sin``.

    The angle is reduced to the first quadrant and the result rounded to 1e-12, so that the cosines of φ + 180° are
    exactly the negatives of those of φ, and do not depend on the processor's libm.
    """
    if not math.isfinite(azimuth_deg):
        raise ArgumentError(f"azimuth_deg: {azimuth_deg}; azimuths are finite numbers of degrees")
    quadrant, within = divmod(math.fmod(azimuth_deg, 360.0) + (360.0 if azimuth_deg < 0 else 0.0), 90.0)
    first = round(math.cos(math.radians(within)), _DECIMALS)
    second = round(math.sin(math.radians(within)), _DECIMALS)
    match int(quadrant) % 4:
        case 0:
            return first, second
        case 1:
            return -second, first
        case 2:
            return -first, -second
        case _:
            return second, -first


@overload
def azimuth_difference(first_deg: float, second_deg: float) -> float: ...
@overload
def azimuth_difference(first_deg: Any, second_deg: Any) -> Any: ...
def azimuth_difference(first_deg: Any, second_deg: Any) -> Any:
    """Return the angle between two azimuths, degrees, 0 to 180; of numbers, arrays or data arrays."""
    return abs((first_deg - second_deg + 180.0) % 360.0 - 180.0)


def checked_azimuths(azimuth_deg: ArrayLike) -> FloatArray:
    """Return azimuths as a 1-D array; raise an `ArgumentError` if there are none or one is not finite."""
    azimuths = np.atleast_1d(np.asarray(azimuth_deg, dtype=np.float64))
    if azimuths.ndim != 1 or azimuths.size == 0 or not np.isfinite(azimuths).all():
        raise ArgumentError("azimuth_deg: give one or more finite numbers of degrees, in one row")
    return azimuths


def north_east_cosines_of_azimuths(azimuth_deg: ArrayLike) -> FloatArray:
    """Return the direction cosines towards north and east, shape (m, 2), of m azimuths in degrees."""
    return np.array([cosine_and_sine_of_azimuth(float(azimuth)) for azimuth in checked_azimuths(azimuth_deg)])


def largest_motion_along_azimuths(horizontal_motion: FloatArray, azimuth_cosines: FloatArray) -> FloatArray:
    """Return the largest absolute value, over time, of the horizontal motion along each of m azimuths.

    ``horizontal_motion`` has shape (2, n), ``azimuth_cosines`` (m, 2); the result has shape (m,) and the unit of the
    motion. Samples that cannot be the largest along any azimuth are left out first: a few extreme samples give a lower
    bound of each result, and samples closer to the origin than the smallest of these bounds are skipped.
    """
    some = np.ascontiguousarray(horizontal_motion[:, ::_STRIDE])
    seeds = np.abs(_TURNS @ some).argmax(axis=1)
    bounds = np.abs(azimuth_cosines @ some[:, seeds]).max(axis=1)
    # The margin covers rounding; keeping too many samples does not change the result.
    far = horizontal_motion[
        :, horizontal_motion[0] ** 2 + horizontal_motion[1] ** 2 >= bounds.min() ** 2 * (1.0 - 1e-9)
    ]
    if far.shape[1] < _FEW:
        return _largest_motion_of_samples(far, azimuth_cosines)
    largest = np.zeros(azimuth_cosines.shape[0])
    for first in range(0, azimuth_cosines.shape[0], _GROUP):
        group = azimuth_cosines[first : first + _GROUP]
        largest[first : first + _GROUP] = _largest_motion_of_samples(
            _samples_that_may_reach_bound(far, group, bounds[first : first + _GROUP].min()), group
        )
    return largest


def _samples_that_may_reach_bound(
    horizontal_motion: FloatArray, azimuth_cosines: FloatArray, lower_bound: float
) -> FloatArray:
    """Return the samples of a motion whose absolute value may reach a lower bound along one of the azimuths."""
    middle = azimuth_cosines[len(azimuth_cosines) // 2]
    along = np.abs(middle[0] * horizontal_motion[0] + middle[1] * horizontal_motion[1])
    across = np.abs(middle[0] * horizontal_motion[1] - middle[1] * horizontal_motion[0])
    # |p · u| ≤ |p · m| + |p × m| |sin δ| for an azimuth u at δ from the middle one m.
    sine = np.abs(middle[0] * azimuth_cosines[:, 1] - middle[1] * azimuth_cosines[:, 0]).max()
    return horizontal_motion[:, along + across * sine >= lower_bound * (1.0 - 1e-9)]


def _largest_motion_of_samples(horizontal_motion: FloatArray, azimuth_cosines: FloatArray) -> FloatArray:
    """Return the largest absolute value over all samples of the horizontal motion along each of m azimuths."""
    largest = np.zeros(azimuth_cosines.shape[0])
    for first in range(0, horizontal_motion.shape[1], _BLOCK):
        block = horizontal_motion[:, first : first + _BLOCK]
        # Not a matrix product: its last bit may depend on the width of the block.
        np.maximum(
            largest,
            np.abs(azimuth_cosines[:, :1] * block[0] + azimuth_cosines[:, 1:] * block[1]).max(axis=1),
            out=largest,
        )
    return largest
