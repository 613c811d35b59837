"""Largest motion along many azimuths, of a motion or of an oscillator's response to it (compiled)."""

import math
from typing import Final

import numpy as np
from numba import njit

from overturning.arrays import FloatArray
from overturning.kernel_cache import cache_compiled_kernel

_AZIMUTH_COUNT_TESTED_TOGETHER_PER_SAMPLE: Final = 18
"""Number of azimuths that one test of a sample covers."""

_BOUND_FACTOR_FOR_ROUNDING: Final = 1.0 - 1e-9
"""Factor of a bound that covers rounding; keeping too many samples does not change the result."""

_IDENTITY_FILTER_COEFFICIENTS: Final = np.array([1.0, 0.0, 0.0])


def largest_motion_along_azimuths(
    north_and_east_sample_rows: FloatArray, north_east_cosines_by_azimuth: FloatArray
) -> FloatArray:
    """Return the largest absolute value, over time, of the horizontal motion along each of m azimuths.

    ``north_and_east_sample_rows`` has shape (2, n), ``north_east_cosines_by_azimuth`` (m, 2); the result has shape (m,)
    and the unit of the motion. If a sample is not finite, all results are NaN.
    """
    return largest_filtered_motion_along_azimuths(
        north_and_east_sample_rows,
        _IDENTITY_FILTER_COEFFICIENTS,
        _IDENTITY_FILTER_COEFFICIENTS,
        north_east_cosines_by_azimuth,
    )


def largest_filtered_motion_along_azimuths(
    north_and_east_sample_rows: FloatArray,
    filter_numerator_coefficients: FloatArray,
    filter_denominator_coefficients: FloatArray,
    north_east_cosines_by_azimuth: FloatArray,
) -> FloatArray:
    """Filter a horizontal motion; return its largest absolute value over time along each of m azimuths.

    Both components pass a recursive filter of second order with numerator and denominator coefficients of shape (3,);
    the first denominator coefficient is 1. The filtered samples equal those of `scipy.signal.lfilter` bit for bit.
    Shapes and units are those of `largest_motion_along_azimuths`.
    """
    north, east = (np.ascontiguousarray(component, dtype=np.float64) for component in north_and_east_sample_rows)
    cosines = np.ascontiguousarray(north_east_cosines_by_azimuth, dtype=np.float64)
    largest = np.zeros(len(cosines))
    coefficients = np.stack([filter_numerator_coefficients, filter_denominator_coefficients])
    _update_largest_filtered_motion(
        north, east, coefficients, cosines, _middle_cosines_and_max_sine_of_azimuth_groups(cosines), largest
    )
    return largest


def _middle_cosines_and_max_sine_of_azimuth_groups(north_east_cosines_by_azimuth: FloatArray) -> FloatArray:
    """Return, for groups of consecutive azimuths, the middle azimuth and the largest |sin δ|, δ: angle to the middle.

    The columns are the cosines of the middle azimuth towards north and east, |sin δ|, and a zero; shape (groups, 4).
    """
    table = np.zeros((-(-len(north_east_cosines_by_azimuth) // _AZIMUTH_COUNT_TESTED_TOGETHER_PER_SAMPLE), 4))
    for row, first in zip(
        table, range(0, len(north_east_cosines_by_azimuth), _AZIMUTH_COUNT_TESTED_TOGETHER_PER_SAMPLE), strict=True
    ):
        group = north_east_cosines_by_azimuth[first : first + _AZIMUTH_COUNT_TESTED_TOGETHER_PER_SAMPLE]
        row[:2] = group[len(group) // 2]
        row[2] = np.abs(row[0] * group[:, 1] - row[1] * group[:, 0]).max()
    return table


@cache_compiled_kernel
@njit(nogil=True, error_model="numpy")
def _update_largest_filtered_motion(
    unfiltered_north_samples: FloatArray,
    unfiltered_east_samples: FloatArray,
    numerator_and_denominator_coefficients: FloatArray,
    north_east_cosines_by_azimuth: FloatArray,
    azimuth_group_cosines_sine_and_bound_in_place: FloatArray,
    largest_absolute_value_by_azimuth_in_place: FloatArray,
) -> None:
    """Filter a motion and update, in place, its largest absolute value along each of the given azimuths.

    A sample p is skipped if |p| is 0 or below the smallest of the largest values so far. Otherwise each group of
    azimuths is tested: for an azimuth u at the angle δ from the middle azimuth m of the group,
    |p · u| ≤ |p · m| + |p × m| |sin δ|. With the group's largest |sin δ|, this limit holds for all its azimuths;
    the group is skipped if the limit is below the smallest of its largest values so far, which is stored in column 3
    of `azimuth_group_cosines_sine_and_bound_in_place`. If a sample is not finite, all results are NaN. Only plain
    loops are used, because they compile in less time.
    """
    count = north_east_cosines_by_azimuth.shape[0]
    b0, b1, b2 = (
        numerator_and_denominator_coefficients[0, 0],
        numerator_and_denominator_coefficients[0, 1],
        numerator_and_denominator_coefficients[0, 2],
    )
    a1, a2 = numerator_and_denominator_coefficients[1, 1], numerator_and_denominator_coefficients[1, 2]
    north_1 = north_2 = east_1 = east_2 = least = 0.0
    for sample in range(unfiltered_north_samples.shape[0]):
        x, y = unfiltered_north_samples[sample], unfiltered_east_samples[sample]
        n, e = north_1 + b0 * x, east_1 + b0 * y
        north_1, east_1 = (north_2 + x * b1) - n * a1, (east_2 + y * b1) - e * a1
        north_2, east_2 = x * b2 - n * a2, y * b2 - e * a2
        if n == e == 0.0 or n * n + e * e < least * least * _BOUND_FACTOR_FOR_ROUNDING:
            continue
        least = math.inf
        for group in range(azimuth_group_cosines_sine_and_bound_in_place.shape[0]):
            along = abs(
                azimuth_group_cosines_sine_and_bound_in_place[group, 0] * n
                + azimuth_group_cosines_sine_and_bound_in_place[group, 1] * e
            )
            across = abs(
                azimuth_group_cosines_sine_and_bound_in_place[group, 0] * e
                - azimuth_group_cosines_sine_and_bound_in_place[group, 1] * n
            )
            if (
                along + across * azimuth_group_cosines_sine_and_bound_in_place[group, 2]
                >= azimuth_group_cosines_sine_and_bound_in_place[group, 3]
            ):
                lowest = math.inf
                for k in range(
                    group * _AZIMUTH_COUNT_TESTED_TOGETHER_PER_SAMPLE,
                    min((group + 1) * _AZIMUTH_COUNT_TESTED_TOGETHER_PER_SAMPLE, count),
                ):
                    largest_absolute_value_by_azimuth_in_place[k] = max(
                        largest_absolute_value_by_azimuth_in_place[k],
                        abs(north_east_cosines_by_azimuth[k, 0] * n + north_east_cosines_by_azimuth[k, 1] * e),
                    )
                    lowest = min(lowest, largest_absolute_value_by_azimuth_in_place[k])
                azimuth_group_cosines_sine_and_bound_in_place[group, 3] = lowest * _BOUND_FACTOR_FOR_ROUNDING
            least = min(least, azimuth_group_cosines_sine_and_bound_in_place[group, 3])
    # A sample that is not finite stays in the state of the filter, and no comparison above sees it.
    if not abs(north_1) + abs(east_1) < math.inf:
        for k in range(count):
            largest_absolute_value_by_azimuth_in_place[k] = math.nan
