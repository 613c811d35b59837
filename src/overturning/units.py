"""Units and constants. The package uses SI units; names of values in other units contain the unit."""

from typing import Final

STANDARD_GRAVITY: Final = 9.80665
"""Standard acceleration of gravity, m/s² (3rd CGPM, 1901)."""

GAL: Final = 0.01
"""One Gal in m/s²."""

CM: Final = 0.01
"""One centimetre in m."""

EARTH_RADIUS_KM: Final = 6371.0
"""Mean radius of the Earth, km."""

DEFAULT_STONE_DENSITY_KG_M3: Final = 2650.0
"""Default density of a gravestone, kg/m³."""

ACCELERATION_UNITS_IN_M_S2: Final[dict[str, float]] = {
    "m/s2": 1.0,
    "cm/s2": GAL,
    "gal": GAL,
    "mm/s2": 1e-3,
    "nm/s2": 1e-9,
    "g": STANDARD_GRAVITY,
    "mg": 1e-3 * STANDARD_GRAVITY,
}
"""Units of acceleration for input data, each in m/s²."""
