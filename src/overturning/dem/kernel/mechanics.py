"""Mechanics that the kernels share, in the order of docs/method.md.

Only ``+ - * /``, comparisons and selections are used: the last bits of libm functions differ between processors.
"""

import math
from typing import Final

from numba import njit

from overturning.dem.kernel.lanes import INLINE_OPTIONS, select

FLAT_LANDING_DURATION_IN_DECAY_TIMES: Final = 4.0
"""Duration of a flat landing after a contact has closed, in h/K, the decay time of spring and dashpot.

Within this time the dashpots stop a block of B/H 0.15 or more, heave first and rotation last.
"""


@njit(**INLINE_OPTIONS)
def rotate_cosine_and_sine_by_small_angle(
    cosine: float, sine: float, further_rotation_rad: float
) -> tuple[float, float]:
    """Return cosine and sine of an angle after a further rotation by the small angle `further_rotation_rad`."""
    square = further_rotation_rad * further_rotation_rad
    angle_sine = further_rotation_rad * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0)))
    versine = square * (0.5 - square * (1.0 / 24.0))
    return cosine - (cosine * versine + sine * angle_sine), sine - (sine * versine - cosine * angle_sine)


@njit(**INLINE_OPTIONS)
def normalise_cosine_and_sine(cosine: float, sine: float) -> tuple[float, float]:
    """Scale cosine and sine of an angle so that their squares sum to 1, against accumulated rounding."""
    unit = 1.5 - 0.5 * (cosine * cosine + sine * sine)
    return cosine * unit, sine * unit


@njit(**INLINE_OPTIONS)
def clamp_magnitude(force_or_stretch: float, limit: float) -> float:
    """Return a force, or the stretch of a spring, limited to ±limit; the sign is kept, also of zero."""
    return math.copysign(limit, force_or_stretch) if abs(force_or_stretch) > limit else force_or_stretch


@njit(**INLINE_OPTIONS)
def base_slides_in_flat_landing(
    friction_coefficient: float, tangential_velocity: float, normal_velocity: float
) -> bool:
    """True if a body that lands flat slides: its tangential speed is at least μ × its normal speed, m/s.

    Both velocities leave out the rotation of the body relative to its support. The dashpots stop this rotation too, and
    friction depends on the slip that remains after it has stopped. All contact points thus slide in one direction.
    """
    return abs(tangential_velocity) >= friction_coefficient * abs(normal_velocity)


@njit(**INLINE_OPTIONS)
def max_time_between_touches_in_one_impact(
    normal_stiffness_of_one_end_per_mass: float, dashpot_constant_of_one_end_per_mass: float
) -> float:
    """Return the longest time (s) between touches of both ends of a body's lower side that still count as one impact.

    The arguments are stiffness K/m (1/s²) and dashpot constant h/m (1/s) of one end, m being the mass of the body. The
    time is m/h, in which the dashpot of one end alone stops the body, or h/K if this is shorter (h² < K m); 0 without
    dashpot.
    """
    dashpot = dashpot_constant_of_one_end_per_mass
    return min(1.0 / dashpot, dashpot / normal_stiffness_of_one_end_per_mass) if dashpot > 0.0 else 0.0


@njit(**INLINE_OPTIONS)
def base_end_touches_within_time(
    allowed_time_s: float, base_end_penetration_m: float, upward_velocity_m_s: float
) -> bool:
    """True if an end of a body's lower side touches the ground now, or within `allowed_time_s` at its present velocity.

    The penetration is negative above the ground.
    """
    return base_end_penetration_m > allowed_time_s * (upward_velocity_m_s if upward_velocity_m_s < 0.0 else 0.0)


@njit(**INLINE_OPTIONS)
def updated_maximum(peak_so_far: float, new_value: float) -> float:
    """Return the larger of the peak value so far and a new value; a NaN leaves the peak unchanged."""
    return select(new_value > peak_so_far, new_value, peak_so_far)


@njit(**INLINE_OPTIONS)
def limit_friction_force_and_stretch_and_test_slip(
    force_per_mass_x: float,
    force_per_mass_y: float,
    stretch_x: float,
    stretch_y: float,
    friction_limit_per_mass: float,
    tangential_compliance_times_mass: float,
    is_in_flat_landing_and_slides_meanwhile: tuple[bool, bool],
) -> tuple[float, float, float, float, bool]:
    """Limit friction force (per mass) and spring stretch of a contact point; return both, and True if the point slips.

    Force and stretch keep their directions. A point in a flat landing slips if, and only if, the base of its body
    slides in this landing (see `base_slides_in_flat_landing`).
    """
    (held, drifts), square, stretch = (
        is_in_flat_landing_and_slides_meanwhile,
        force_per_mass_x * force_per_mass_x + force_per_mass_y * force_per_mass_y,
        stretch_x * stretch_x + stretch_y * stretch_y,
    )
    slips, holds = (
        (drifts if held else square > friction_limit_per_mass * friction_limit_per_mass),
        friction_limit_per_mass * tangential_compliance_times_mass,
    )
    holds = holds if holds > 0.0 else 0.0
    cut = slips & (stretch > holds * holds)
    some = slips & (square > 0.0)
    share = friction_limit_per_mass / math.sqrt(square if some else 1.0) if slips else 1.0
    kept = holds / math.sqrt(stretch if cut else 1.0) if cut else 1.0
    return force_per_mass_x * share, force_per_mass_y * share, stretch_x * kept, stretch_y * kept, slips
