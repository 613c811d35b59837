"""JMA instrumental seismic intensity, from three components (JMA notice of 1996)."""

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.motion.motion import Accelerogram
from overturning.units import GAL

JMA_LEVEL_DURATION_S = 0.3
"""Total time during which the filtered acceleration reaches the level a₀, s."""


ASSUMED_JMA_INTENSITY_ADDED_BY_VERTICAL_MOTION: Final = 0.1
"""Increase of the horizontal intensity by a vertical motion of half the amplitude: log₁₀ 1.25 = 0.1."""

JMA_DEGREE_RANGES_BY_OVERTURNED_FRACTION: Final = ((0.4, 0.9, 6.0, 6.5, "6 upper"), (0.9, 1.0, 6.5, 99.0, "7"))
"""Rule of field surveys: range of the fraction overturned, range of instrumental intensity, degree of the JMA scale.

40 to below 90 % overturned means 6 upper, 90 % and more means 7: the rule of the survey of Yamagata University after
the 2019 Yamagata-oki earthquake, according to the press of 26 July 2019.
"""


def round_and_truncate_to_published_intensity(instrumental_intensity: ArrayLike) -> FloatArray:
    """Return the intensity as JMA publishes it: rounded to two decimals, then the second decimal is dropped.

    The degree of the JMA scale follows from the published value: 6.46 becomes 6.4 (6 upper), 6.496 becomes 6.5 (7).
    """
    return np.asarray(np.floor(np.round(100.0 * np.asarray(instrumental_intensity)) / 10.0) / 10.0)


def is_published_intensity_in_range(
    instrumental_intensity: ArrayLike, inclusive_lower_limit: float, exclusive_upper_limit: float
) -> NDArray[np.bool_]:
    """Return True for each motion whose published JMA intensity is ≥ the lower and < the upper limit.

    Each degree of the JMA scale is such a range. `instrumental_intensity` is unrounded;
    `round_and_truncate_to_published_intensity` converts it to the published one.
    """
    published = round_and_truncate_to_published_intensity(instrumental_intensity)
    return np.asarray((published >= inclusive_lower_limit) & (published < exclusive_upper_limit))


def jma_filter_gain(frequencies_hz: FloatArray) -> FloatArray:
    """Return the gain of the filter for the JMA intensity at frequencies in Hz; 0 at 0 Hz.

    It is the product of three filters of the notice of 1996: the period effect (f^-½), a high cut and a low cut.
    """
    x = frequencies_hz / 10.0
    high_cut = (
        1.0 + 0.694 * x**2 + 0.241 * x**4 + 0.0557 * x**6 + 0.009664 * x**8 + 0.00134 * x**10 + 0.000155 * x**12
    ) ** -0.5
    low_cut = np.sqrt(1.0 - np.exp(-((frequencies_hz / 0.5) ** 3)))
    period_effect = np.zeros_like(frequencies_hz)
    np.divide(1.0, np.sqrt(frequencies_hz), out=period_effect, where=frequencies_hz > 0)
    return period_effect * high_cut * low_cut


def jma_instrumental_intensity(motion: Accelerogram, *, horizontal_only: bool = False) -> float:
    """Return the JMA instrumental intensity I = 2 log₁₀ a₀ + 0.94, a₀ in Gal, unrounded; −inf without motion.

    a₀ is the largest level that the vector sum of the filtered components reaches or exceeds for 0.3 s in total. With
    `horizontal_only`, only north and east are used; the intensity is then never larger. Raises an ArgumentError if
    the vertical component is needed but missing, or if the motion is shorter than 0.3 s.
    """
    if motion.up is None and not horizontal_only:
        raise ArgumentError("motion: no vertical component; the JMA intensity needs three components")
    count = math.ceil(JMA_LEVEL_DURATION_S / motion.sampling_interval - 1e-9)
    if motion.sample_count < count:
        raise ArgumentError(f"motion: {motion.duration:g} s; the JMA intensity needs at least {JMA_LEVEL_DURATION_S} s")
    vertical = [] if motion.up is None or horizontal_only else [motion.up]
    components = np.stack([motion.north, motion.east, *vertical]) / GAL
    spectrum = np.fft.rfft(components, axis=1)
    spectrum *= jma_filter_gain(
        np.asarray(np.fft.rfftfreq(motion.sample_count, motion.sampling_interval), dtype=np.float64)
    )
    filtered = np.fft.irfft(spectrum, motion.sample_count, axis=1)
    level = np.partition(np.sqrt((filtered**2).sum(axis=0)), -count)[-count]
    return 2.0 * math.log10(level) + 0.94 if level > 0 else -math.inf
