"""Motions that a survey is asked about: synthetic pulses where there is no record."""

from typing import Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.motion.intensity import intensity_by_azimuth
from overturning.motion.motion import Motion
from overturning.records.pulses import parse_pulse, pulse_record
from overturning.surveys.inversion import STEP_DEG, WAYS

PERIODS: Final = (0.3, 0.5, 0.8, 1.2, 2.0, 3.0)
"""Periods of the pulses, s."""


def pulse_motions() -> dict[str, Motion]:
    """One-cycle sine and cosine pulses towards the north, 400 Gal, by name."""
    return {
        f"{shape} {period:g} s": Motion.of(
            pulse_record(parse_pulse(f"{shape} amplitude_gal=400 period_s={period} sampling_interval_s=0.01"))
        )
        for shape in ("sine", "cosine")
        for period in PERIODS
    }


def largest_peaks(motion: Motion) -> tuple[float, float]:
    """Largest PGA, m/s², and PGV, m/s, of a motion over all azimuths."""
    along: FloatArray = STEP_DEG * np.arange(WAYS, dtype=np.float64)
    peaks = intensity_by_azimuth(motion, along)
    return float(peaks["pga"].max()), float(peaks["pgv"].max())
