"""Direction cosines that are the same on every processor, and differences of azimuths."""

import math
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray, convert_argument_to_float_array
from overturning.errors import ArgumentError

_COSINE_DECIMALS = 12


def cosine_and_sine_of_azimuth(azimuth_deg: float) -> tuple[float, float]:
    """Return the cosine and sine of an azimuth φ, degrees clockwise from north.

    The motion along φ is ``north * cos + east * sin``.

    The angle is reduced to the first quadrant and the result rounded to 1e-12, so that the cosines of φ + 180° are
    exactly the negatives of those of φ, and do not depend on the processor's libm.
    """
    try:
        known = math.isfinite(azimuth_deg)
    except TypeError:
        known = False
    if not known:
        raise ArgumentError(f"azimuth_deg: {str(azimuth_deg)[:60]}; azimuths are finite numbers of degrees")
    quadrant, within = divmod(math.fmod(azimuth_deg, 360.0) + (360.0 if azimuth_deg < 0 else 0.0), 90.0)
    first = round(math.cos(math.radians(within)), _COSINE_DECIMALS)
    second = round(math.sin(math.radians(within)), _COSINE_DECIMALS)
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
def angle_between_azimuths(first_azimuth_deg: float, second_azimuth_deg: float) -> float: ...
@overload
def angle_between_azimuths(first_azimuth_deg: Any, second_azimuth_deg: Any) -> Any: ...
def angle_between_azimuths(first_azimuth_deg: Any, second_azimuth_deg: Any) -> Any:
    """Return the angle between two azimuths, degrees, 0 to 180; of numbers, arrays or data arrays."""
    return abs((first_azimuth_deg - second_azimuth_deg + 180.0) % 360.0 - 180.0)


def checked_azimuths(azimuth_deg: ArrayLike) -> FloatArray:
    """Return azimuths as a 1-D array; raise an `ArgumentError` if there are none, or one is not finite."""
    azimuths = np.atleast_1d(convert_argument_to_float_array("azimuth_deg", azimuth_deg))
    if azimuths.ndim != 1 or azimuths.size == 0 or not np.isfinite(azimuths).all():
        raise ArgumentError("azimuth_deg: give one or more finite numbers of degrees, in one row")
    return azimuths


def north_east_cosines_of_azimuths(azimuth_deg: ArrayLike) -> FloatArray:
    """Return the direction cosines towards north and east, shape (m, 2), of m azimuths in degrees."""
    return np.array([cosine_and_sine_of_azimuth(float(azimuth)) for azimuth in checked_azimuths(azimuth_deg)])
