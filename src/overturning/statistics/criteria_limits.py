"""Published overturning criteria: limits of peak acceleration and velocity of a block."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.units import CM, GAL, STANDARD_GRAVITY


def _checked_positive_array(argument_name: str, argument_values: ArrayLike) -> FloatArray:
    """Return `argument_values` as an array; raise an `ArgumentError` unless all are positive and finite."""
    array = np.asarray(argument_values, dtype=np.float64)
    if not (np.isfinite(array).all() and (array > 0).all()):
        raise ArgumentError(
            f"{argument_name}: {array.min() if array.size else 'nothing'}; it must be positive and finite"
        )
    return array


def west_acceleration_limit(b_over_h: ArrayLike) -> FloatArray:
    """Return West's limit g B/H, m/s²: the acceleration above which a rigid block of width B, height H rocks.

    West's formula as given by Milne (1885, Transactions of the Seismological Society of Japan 8).
    """
    return STANDARD_GRAVITY * _checked_positive_array("b_over_h", b_over_h)


def ishiyama_velocity_limit(height: ArrayLike, b_over_h: ArrayLike) -> FloatArray:
    """Return Ishiyama's limit of peak ground velocity, m/s, below which a block of height H (m) does not overturn.

    v = 0.4 √(8 g R/3 · (1 − cos α)/cos² α), R half the diagonal, tan α = B/H (Ishiyama 1982, Earthquake
    Engineering and Structural Dynamics 10); about 10 B/√H in cm and cm/s for slender blocks.
    """
    tall, slenderness = _checked_positive_array("height", height), _checked_positive_array("b_over_h", b_over_h)
    alpha = np.arctan(slenderness)
    radius = tall * np.sqrt(1 + slenderness**2) / 2
    # 1 − cos α = 2 sin²(α/2), without cancellation for slender blocks.
    return np.asarray(
        0.4 * np.sqrt(8 * STANDARD_GRAVITY * radius / 3 * 2 * np.sin(alpha / 2) ** 2) / np.cos(alpha), dtype=np.float64
    )


def max_of_west_and_ishiyama_acceleration_limits(
    height: ArrayLike, b_over_h: ArrayLike, pgv_over_pga: ArrayLike
) -> FloatArray:
    """Return the PGA (m/s²) above which a block overturns: the larger of West's and Ishiyama's limits.

    The limits are g B/H and `ishiyama_velocity_limit` divided by PGV/PGA, s.
    """
    by_velocity = ishiyama_velocity_limit(height, b_over_h) / _checked_positive_array("pgv_over_pga", pgv_over_pga)
    return np.maximum(west_acceleration_limit(b_over_h), by_velocity)


def kaneko_hayashi_transition_frequency(height: ArrayLike, b_over_h: ArrayLike) -> FloatArray:
    """Return the frequency, Hz, above which the Kaneko–Hayashi criterion uses its formula for high frequencies.

    F_b = 15.6/√H (1 + B/H)^−1.5 with H in cm; `height` is in m.
    """
    tall, slenderness = _checked_positive_array("height", height) / CM, _checked_positive_array("b_over_h", b_over_h)
    return np.asarray(15.6 / np.sqrt(tall) * (1 + slenderness) ** -1.5)


def kaneko_hayashi_median_fall_pga(height: ArrayLike, b_over_h: ArrayLike, pgv_over_pga: ArrayLike) -> FloatArray:
    """Return the PGA, m/s², at which half of the blocks of height H, m, overturn (Kaneko & Hayashi).

    The PGA is g B/H (1 + B/H) if the motion's frequency F = PGA/(2π PGV) is at most F_b
    (`kaneko_hayashi_transition_frequency`), else 10 B/√H (1 + B/H)^2.5 · 2π F, in cm, cm/s² and Hz (Kaneko &
    Hayashi 2000, Journal of Structural and Construction Engineering, AIJ, 536). The paper was not available. The
    branches meet at F_b within 0.05 % (10 · 15.6 · 2π = 980.2 cm/s², which is g), so the coefficients are
    consistent with each other.
    """
    tall, slenderness = _checked_positive_array("height", height) / CM, _checked_positive_array("b_over_h", b_over_h)
    frequency = 1 / (2 * np.pi * _checked_positive_array("pgv_over_pga", pgv_over_pga))
    low = STANDARD_GRAVITY * slenderness * (1 + slenderness)
    high = 10 * slenderness * np.sqrt(tall) * (1 + slenderness) ** 2.5 * 2 * np.pi * frequency * GAL
    return np.where(frequency > kaneko_hayashi_transition_frequency(height, b_over_h), high, low)


def block_frequency_parameter(height: ArrayLike, b_over_h: ArrayLike) -> FloatArray:
    """Return p = √(3g/4R), rad/s, of a rectangular block of given height, m, and B/H; R is half its diagonal."""
    tall, slenderness = _checked_positive_array("height", height), _checked_positive_array("b_over_h", b_over_h)
    return np.asarray(np.sqrt(1.5 * STANDARD_GRAVITY / (tall * np.sqrt(1 + slenderness**2))))


def _pulse_to_block_frequency_ratio(height: ArrayLike, b_over_h: ArrayLike, pgv_over_pga: ArrayLike) -> FloatArray:
    """Return ω/p: angular frequency ω = 2 PGA/PGV of a one-sine pulse, over the block's p = √(3g/4R)."""
    # A one-sine pulse of amplitude a and angular frequency ω has the peak velocity 2a/ω.
    return 2 / _checked_positive_array("pgv_over_pga", pgv_over_pga) / block_frequency_parameter(height, b_over_h)


def pulse_acceleration_to_overturn_after_impact(
    height: ArrayLike, b_over_h: ArrayLike, pgv_over_pga: ArrayLike
) -> FloatArray:
    """Return the PGA, m/s², at which a single sine pulse overturns a block after one impact on its base.

    a = g B/H (1 + ω/6p), ω = 2 PGA/PGV the pulse's frequency (Makris & Roussos 2000, Géotechnique 50, for
    near-source pulses). The paper was not available. Compared with the rocking block, the formula is 0 to 11 % too
    high for ω/p of 1 to 4 and B/H = 0.1, and far too low for ω/p above 5.
    """
    ratio = _pulse_to_block_frequency_ratio(height, b_over_h, pgv_over_pga)
    return west_acceleration_limit(b_over_h) * (1 + ratio / 6)


def sine_pulse_pga_to_overturn_without_impact(
    height: ArrayLike, b_over_h: ArrayLike, pgv_over_pga: ArrayLike
) -> FloatArray:
    """Return the PGA, m/s², at which a single sine pulse overturns a block without any impact on its base.

    The PGA is A g B/H, where A solves √(A² − 1) − A exp(−(2π − arcsin 1/A) p/ω) = ω/p, with the pulse's
    ω = 2 PGA/PGV and the block's p (`block_frequency_parameter`). The linearised slender block then reaches its
    unstable equilibrium exactly at the end of the pulse (the mode without impact of Zhang & Makris 2001, Journal of
    Engineering Mechanics 127; in closed form as in Dimitrakopoulos & DeJong 2012, Proceedings of the Royal Society A
    468).
    """
    ratio = _pulse_to_block_frequency_ratio(height, b_over_h, pgv_over_pga)

    def left_minus_right_of_amplitude_equation(pulse_over_west_limit: FloatArray) -> FloatArray:
        length = (2 * np.pi - np.arcsin(1 / pulse_over_west_limit)) / ratio
        return np.asarray(np.sqrt(pulse_over_west_limit**2 - 1) - pulse_over_west_limit * np.exp(-length) - ratio)

    # The left side increases with A without bound, so bisection finds the root.
    low, high = np.ones_like(ratio), 2.0 + ratio + ratio**2
    for _ in range(60):
        middle = (low + high) / 2
        above = left_minus_right_of_amplitude_equation(middle) > 0
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return west_acceleration_limit(b_over_h) * high


@dataclass(frozen=True)
class OverturningCriterion:
    """Published overturning criterion: name, rule in words, and function that computes the PGA for overturning.

    The function gives the limit in m/s² from height (m), B/H and PGV/PGA (s).
    """

    name: str
    rule_text: str
    pga_limit_from_height_b_over_h_pgv_over_pga: Callable[[ArrayLike, ArrayLike, ArrayLike], FloatArray]


def _west_limit_of_each_block_and_motion(height: ArrayLike, b_over_h: ArrayLike, pgv_over_pga: ArrayLike) -> FloatArray:
    return west_acceleration_limit(b_over_h) * np.ones(np.broadcast_shapes(np.shape(height), np.shape(pgv_over_pga)))


OVERTURNING_CRITERIA: Final = (
    OverturningCriterion("West", "PGA above g B/H", _west_limit_of_each_block_and_motion),
    OverturningCriterion(
        "Ishiyama",
        "PGA above g B/H, and PGV above the velocity of Ishiyama (1982)",
        max_of_west_and_ishiyama_acceleration_limits,
    ),
    OverturningCriterion(
        "Kaneko–Hayashi", "PGA above the median of Kaneko and Hayashi (2000)", kaneko_hayashi_median_fall_pga
    ),
    OverturningCriterion(
        "pulse, one impact", "PGA above g B/H (1 + ω/6p), ω = 2 PGA/PGV", pulse_acceleration_to_overturn_after_impact
    ),
    OverturningCriterion(
        "pulse, no impact",
        "PGA above that of the one-sine pulse without impact",
        sine_pulse_pga_to_overturn_without_impact,
    ),
)
"""Criteria in the order of tables and figures."""


NAMES_OF_CRITERIA_FROM_SECONDARY_SOURCES: Final = ("Kaneko–Hayashi", "pulse, one impact")
"""Criteria taken from secondary sources; the docstring of each function states how it was checked."""
