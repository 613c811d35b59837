"""Mechanics shared by the block and polygon kernels, in the order of docs/method.md.

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
def rotate_cosine_and_sine(cosine: float, sine: float, angle: float) -> tuple[float, float]:
    """Return cosine and sine of an angle after a further rotation by the small angle `angle`, rad."""
    square = angle * angle
    angle_sine = angle * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0)))
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
def base_slides_in_flat_landing(friction: float, slip_velocity: float, opening_velocity: float) -> bool:
    """True if a base that lands flat slides: its tangential velocity is at least μ × its vertical velocity (m/s).

    The dashpots stop the vertical motion first, and the contribution of the rotation to the slip only later. Friction
    in a plastic landing depends on the slip that remains afterwards, so rotation is left out: all contact points slide
    the same way.
    """
    return abs(slip_velocity) >= friction * abs(opening_velocity)


@njit(**INLINE_OPTIONS)
def max_time_between_touches_in_one_impact(stiffness_per_mass: float, dashpot_constant_per_mass: float) -> float:
    """Return the longest time (s) between the touches of a base's two ends that still counts as one impact.

    Stiffness (1/s²) and dashpot (1/s) of an end are per mass. The time is m/h (mass over dashpot), in which the
    dashpot of one end alone stops the mass: the other end touches before the first one has stopped the body. For a
    weaker dashpot (h² < K m, K: stiffness) it is the shorter time h/K.
    """
    dashpot = dashpot_constant_per_mass
    return min(1.0 / dashpot, dashpot / stiffness_per_mass) if dashpot > 0.0 else 0.0


@njit(**INLINE_OPTIONS)
def base_end_touches_within_time(time: float, depth: float, opening_velocity: float) -> bool:
    """True if an end of a base is in contact, or comes into contact within `time` (s) at its present velocity.

    `depth` is the penetration, m, `opening_velocity` the velocity at which the end rises, m/s.
    """
    return depth > time * (opening_velocity if opening_velocity < 0.0 else 0.0)


@njit(**INLINE_OPTIONS)
def updated_maximum(peak: float, new_value: float) -> float:
    """Return the larger of the peak value so far and a new value; a NaN leaves the peak unchanged."""
    return select(new_value > peak, new_value, peak)


@njit(**INLINE_OPTIONS)
def clamp_friction_and_stretch(
    force_x: float,
    force_y: float,
    stretch_x: float,
    stretch_y: float,
    friction_limit: float,
    compliance: float,
    flat_landing: tuple[bool, bool],
) -> tuple[float, float, float, float, bool]:
    """Limit friction force and spring stretch of a contact point; return both, and True if the point slips.

    Force and stretch keep their directions. `flat_landing` holds whether the point is in a flat landing, and whether it
    slides meanwhile (see `base_slides_in_flat_landing`).
    """
    (held, drifts), square, stretch = (
        flat_landing,
        force_x * force_x + force_y * force_y,
        stretch_x * stretch_x + stretch_y * stretch_y,
    )
    slips, holds = (drifts if held else square > friction_limit * friction_limit), friction_limit * compliance
    holds = holds if holds > 0.0 else 0.0
    cut = slips & (stretch > holds * holds)
    some = slips & (square > 0.0)
    share = friction_limit / math.sqrt(square if some else 1.0) if slips else 1.0
    kept = holds / math.sqrt(stretch if cut else 1.0) if cut else 1.0
    return force_x * share, force_y * share, stretch_x * kept, stretch_y * kept, slips
