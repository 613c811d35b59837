"""JMA instrumental seismic intensity, from three components (JMA notice of 1996)."""

import math
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.motion.motion import Recorded
from overturning.units import GAL

DURATION = 0.3
"""The filtered acceleration is exceeded for this long in all, s."""


VERTICAL_ADDS: Final = 0.1
"""What a vertical motion half as strong at every moment adds to the horizontal intensity: log₁₀ 1.25."""

SURVEY_RULE: Final = ((0.4, 0.9, 6.0, 6.5, "6 upper"), (0.9, 1.0, 6.5, 99.0, "7"))
"""Fall rates, from and to, that field surveys take for a degree of the JMA scale, with its instrumental intensity.

40 to below 90 % for 6 upper, 90 % and more for 7: the rule of the survey of Yamagata University after the 2019
Yamagata-oki earthquake, as the press of 26 July 2019 states it.
"""


def as_published(intensity: ArrayLike) -> FloatArray:
    """Instrumental intensity as JMA publishes it: rounded to two decimals, of which the second is dropped.

    So a degree that begins at 6.5 begins there in print too: 6.46 is 6.4, not 6.5.
    """
    return np.asarray(np.floor(np.round(100.0 * np.asarray(intensity)) / 10.0) / 10.0)


def amplitude(frequency: FloatArray) -> FloatArray:
    """The three filters of the notice: period effect (f^-½), high cut, low cut; 0 at f = 0."""
    x = frequency / 10.0
    high_cut = (
        1.0 + 0.694 * x**2 + 0.241 * x**4 + 0.0557 * x**6 + 0.009664 * x**8 + 0.00134 * x**10 + 0.000155 * x**12
    ) ** -0.5
    low_cut = np.sqrt(1.0 - np.exp(-((frequency / 0.5) ** 3)))
    period_effect = np.zeros_like(frequency)
    np.divide(1.0, np.sqrt(frequency), out=period_effect, where=frequency > 0)
    return period_effect * high_cut * low_cut


def instrumental_intensity(motion: Recorded, *, horizontal: bool = False) -> float:
    """JMA instrumental intensity I = 2 log₁₀ a₀ + 0.94, a₀ in Gal, before it is rounded for publication.

    With `horizontal` it is that of north and east alone, which is never more.

    a₀ is the largest level that the vector sum of the filtered components reaches or exceeds for 0.3 s in all; −inf
    for no motion at all. An ArgumentError says so where there is no vertical component, or the motion is shorter
    than 0.3 s.
    """
    if motion.up is None and not horizontal:
        raise ArgumentError("motion: no vertical component; the JMA intensity needs three components")
    count = math.ceil(DURATION / motion.sampling_interval - 1e-9)
    if motion.samples < count:
        raise ArgumentError(f"motion: {motion.duration:g} s; the JMA intensity needs at least {DURATION} s")
    vertical = [] if motion.up is None or horizontal else [motion.up]
    components = np.stack([motion.north, motion.east, *vertical]) / GAL
    spectrum = np.fft.rfft(components, axis=1)
    spectrum *= amplitude(np.asarray(np.fft.rfftfreq(motion.samples, motion.sampling_interval), dtype=np.float64))
    filtered = np.fft.irfft(spectrum, motion.samples, axis=1)
    level = np.partition(np.sqrt((filtered**2).sum(axis=0)), -count)[-count]
    return 2.0 * math.log10(level) + 0.94 if level > 0 else -math.inf
