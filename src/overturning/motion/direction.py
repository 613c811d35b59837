"""Directions in the horizontal plane, the same on every processor."""

import math

from overturning.errors import ArgumentError

_DECIMALS = 12


def direction_cosines(azimuth_deg: float) -> tuple[float, float]:
    """Cosine and sine of an azimuth φ, degrees clockwise from north: motion along φ is ``north * cos + east * sin``.

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
