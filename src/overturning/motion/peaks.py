"""Largest motion along many azimuths, of a motion or of an oscillator's response to it (compiled)."""

import math
from typing import Final

import numpy as np
from numba import njit

from overturning.arrays import FloatArray
from overturning.kernel_cache import cache_compiled_kernel

_AZIMUTHS_PER_GROUP: Final = 18
"""Number of azimuths that one test of a sample covers."""

_BOUND_FACTOR_FOR_ROUNDING: Final = 1.0 - 1e-9
"""Factor of a bound that covers rounding; keeping too many samples does not change the result."""

_IDENTITY_FILTER_COEFFICIENTS: Final = np.array([1.0, 0.0, 0.0])


def largest_motion_along_azimuths(horizontal_motion: FloatArray, azimuth_cosines: FloatArray) -> FloatArray:
    """Return the largest absolute value, over time, of the horizontal motion along each of m azimuths.

    ``horizontal_motion`` has shape (2, n), ``azimuth_cosines`` (m, 2), towards north and east; the result has shape
    (m,) and the unit of the motion. If a sample is not finite, all results are NaN.
    """
    return largest_filtered_motion_along_azimuths(
        horizontal_motion, _IDENTITY_FILTER_COEFFICIENTS, _IDENTITY_FILTER_COEFFICIENTS, azimuth_cosines
    )


def largest_filtered_motion_along_azimuths(
    horizontal_motion: FloatArray, numerator: FloatArray, denominator: FloatArray, azimuth_cosines: FloatArray
) -> FloatArray:
    """Filter a horizontal motion; return its largest absolute value over time along each of m azimuths.

    Both components pass a recursive filter of second order with the coefficients `numerator` and `denominator`, shape
    (3,) each, and ``denominator[0]`` = 1. The filtered samples have the bits of `scipy.signal.lfilter`. Shapes and
    units as in `largest_motion_along_azimuths`.
    """
    north, east = (np.ascontiguousarray(component, dtype=np.float64) for component in horizontal_motion)
    cosines = np.ascontiguousarray(azimuth_cosines, dtype=np.float64)
    largest, coefficients = np.zeros(len(cosines)), np.stack([numerator, denominator])
    _update_largest_filtered_motion(
        north, east, coefficients, cosines, _middle_cosines_and_max_sine_by_azimuth_group(cosines), largest
    )
    return largest


def _middle_cosines_and_max_sine_by_azimuth_group(azimuth_cosines: FloatArray) -> FloatArray:
    """Return the middle azimuth of each group of azimuths, and the largest sine of the angle to it.

    The columns are the cosines of the middle azimuth towards north and east, the sine, and a zero; shape (groups, 4).
    """
    table = np.zeros((-(-len(azimuth_cosines) // _AZIMUTHS_PER_GROUP), 4))
    for row, first in zip(table, range(0, len(azimuth_cosines), _AZIMUTHS_PER_GROUP), strict=True):
        group = azimuth_cosines[first : first + _AZIMUTHS_PER_GROUP]
        row[:2] = group[len(group) // 2]
        row[2] = np.abs(row[0] * group[:, 1] - row[1] * group[:, 0]).max()
    return table


@cache_compiled_kernel
@njit(nogil=True, error_model="numpy")
def _update_largest_filtered_motion(
    north: FloatArray,
    east: FloatArray,
    filter_coefficients: FloatArray,
    azimuth_cosines: FloatArray,
    azimuth_groups_in_place: FloatArray,
    largest_out: FloatArray,
) -> None:
    """Filter a motion and update, in place, its largest value so far along each of the given azimuths.

    A sample that is nearer to the origin than the smallest of all largest values so far cannot be the largest along
    any azimuth, and neither can a sample without motion. For other samples, each group of azimuths is tested: for the
    sample p and an azimuth u at the angle δ from the middle azimuth m of the group,
    |p · u| ≤ |p · m| + |p × m| |sin δ|. The fourth column of `azimuth_groups_in_place` becomes the bound that a sample
    must reach. If a sample is not finite, all results are NaN. The function has plain loops only, which compile in less
    time.
    """
    count = azimuth_cosines.shape[0]
    b0, b1, b2 = filter_coefficients[0, 0], filter_coefficients[0, 1], filter_coefficients[0, 2]
    a1, a2 = filter_coefficients[1, 1], filter_coefficients[1, 2]
    north_1 = north_2 = east_1 = east_2 = least = 0.0
    for sample in range(north.shape[0]):
        x, y = north[sample], east[sample]
        n, e = north_1 + b0 * x, east_1 + b0 * y
        north_1, east_1 = (north_2 + x * b1) - n * a1, (east_2 + y * b1) - e * a1
        north_2, east_2 = x * b2 - n * a2, y * b2 - e * a2
        if n == e == 0.0 or n * n + e * e < least * least * _BOUND_FACTOR_FOR_ROUNDING:
            continue
        least = math.inf
        for group in range(azimuth_groups_in_place.shape[0]):
            along = abs(azimuth_groups_in_place[group, 0] * n + azimuth_groups_in_place[group, 1] * e)
            across = abs(azimuth_groups_in_place[group, 0] * e - azimuth_groups_in_place[group, 1] * n)
            if along + across * azimuth_groups_in_place[group, 2] >= azimuth_groups_in_place[group, 3]:
                lowest = math.inf
                for k in range(group * _AZIMUTHS_PER_GROUP, min((group + 1) * _AZIMUTHS_PER_GROUP, count)):
                    largest_out[k] = max(largest_out[k], abs(azimuth_cosines[k, 0] * n + azimuth_cosines[k, 1] * e))
                    lowest = min(lowest, largest_out[k])
                azimuth_groups_in_place[group, 3] = lowest * _BOUND_FACTOR_FOR_ROUNDING
            least = min(least, azimuth_groups_in_place[group, 3])
    # A sample that is not finite stays in the state of the filter, and no comparison above sees it.
    if not abs(north_1) + abs(east_1) < math.inf:
        for k in range(count):
            largest_out[k] = math.nan
