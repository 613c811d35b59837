"""Azimuths of a motion's peak acceleration and velocity, and axis and period of its strongest velocity pulse."""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.motion.integration import integrate
from overturning.motion.motion import Accelerogram

PULSE_PERIOD_CANDIDATES_S = np.geomspace(0.4, 12.0, 36)
"""Periods at which pulses are searched, s, in steps of 10 %."""

_DAUBECHIES_SCALING_FILTER = np.array([
    0.23037781330885523, 0.7148465705525415, 0.6308807679295904, -0.02798376941698385,
    -0.18703481171888114, 0.030841381835986965, 0.032883011666982945, -0.010597401784997278,
])  # fmt: skip
"""Scaling filter of the Daubechies wavelet with four vanishing moments (Daubechies 1992, Ten Lectures, table 6.1)."""

_WAVELET_PEAK_FREQUENCY_CYCLES_IN_SUPPORT, _WAVELET_SUPPORT_LENGTH_IN_ARGUMENT_UNITS = 5, 7
"""Number of cycles in the support of the wavelet, at the peak of its Fourier amplitude, and length of the support."""

_WAVELET_SAMPLES_PER_ARGUMENT_UNIT = 256
"""Points of the wavelet per unit of its argument."""


def azimuths_of_peak_acceleration_and_velocity(motion: Accelerogram) -> dict[str, float]:
    """Return the azimuths, degrees, of the largest horizontal acceleration and velocity; NaN without motion."""
    acceleration = motion.horizontal_components
    velocity = integrate(acceleration, motion.sampling_interval)
    return {name: _azimuth_deg_of_largest_vector(series) for name, series in (("pga", acceleration), ("pgv", velocity))}


def _azimuth_deg_of_largest_vector(north_and_east_sample_rows: FloatArray) -> float:
    """Return the azimuth, degrees, at which a horizontal motion, shape (2, n), is largest; NaN without motion."""
    square = (north_and_east_sample_rows**2).sum(axis=0)
    at = int(square.argmax())
    return _azimuth_deg_of_vector(*north_and_east_sample_rows[:, at]) if square[at] > 0 else float("nan")


def _azimuth_deg_of_vector(northward_component: float, eastward_component: float) -> float:
    """Return the azimuth of a horizontal vector, degrees clockwise from north, rounded to 1e-6."""
    return float(np.round(np.degrees(np.arctan2(eastward_component, northward_component)) % 360.0, 6) % 360.0)


@cache
def daubechies_wavelet_values() -> FloatArray:
    """Return the Daubechies wavelet db4 (unit energy) at arguments from 0 to 7 in steps of 1/256, shape (1793,)."""

    def wavelet_filter_response_over_sqrt_2(
        filter_taps: FloatArray, frequencies_in_cycles_per_sample: FloatArray
    ) -> NDArray[np.complex128]:
        turns = np.exp(-2j * np.pi * np.multiply.outer(frequencies_in_cycles_per_sample, np.arange(filter_taps.size)))
        return np.asarray(turns @ filter_taps / np.sqrt(2.0), dtype=np.complex128)

    period = _WAVELET_SUPPORT_LENGTH_IN_ARGUMENT_UNITS + 1  # slightly more than the support, to avoid wrap-around
    half = np.arange(period * _WAVELET_SAMPLES_PER_ARGUMENT_UNIT // 2 + 1) / (2.0 * period)
    transform = wavelet_filter_response_over_sqrt_2(
        _DAUBECHIES_SCALING_FILTER[::-1] * (-1.0) ** np.arange(_DAUBECHIES_SCALING_FILTER.size), half
    )
    for level in range(1, 25):
        transform *= wavelet_filter_response_over_sqrt_2(_DAUBECHIES_SCALING_FILTER, half / 2.0**level)
    return (
        np.fft.irfft(transform, period * _WAVELET_SAMPLES_PER_ARGUMENT_UNIT)[
            : _WAVELET_SUPPORT_LENGTH_IN_ARGUMENT_UNITS * _WAVELET_SAMPLES_PER_ARGUMENT_UNIT + 1
        ]
        * _WAVELET_SAMPLES_PER_ARGUMENT_UNIT
    )


def strongest_pulse_axis_deg_and_period_s(motion: Accelerogram) -> tuple[float, float]:
    """Return the axis (degrees, 0 to 180) and period (s) of the strongest velocity pulse; NaN without motion.

    The pulse has the largest wavelet coefficient over times, periods and horizontal directions (Shahi & Baker 2014,
    Bulletin of the Seismological Society of America 104). The coefficient along φ is n cos φ + e sin φ, with the
    coefficients n and e of the north and east components; its largest magnitude is √(n² + e²). As in that paper,
    the wavelet is Daubechies' with four vanishing moments, and its period is that of its largest Fourier amplitude.
    """
    velocity = integrate(motion.horizontal_components, motion.sampling_interval)
    if not np.abs(velocity).max() > 0:
        return float("nan"), float("nan")
    step = max(1, int(np.floor(0.1 * PULSE_PERIOD_CANDIDATES_S[0] / motion.sampling_interval)))
    interval, series = step * motion.sampling_interval, velocity[:, ::step]
    count = (
        series.shape[1] + int(_WAVELET_PEAK_FREQUENCY_CYCLES_IN_SUPPORT * PULSE_PERIOD_CANDIDATES_S[-1] / interval) + 1
    )
    spectrum = np.fft.rfft(series, count)
    wavelet = daubechies_wavelet_values()
    places = np.arange(wavelet.size) / _WAVELET_SAMPLES_PER_ARGUMENT_UNIT
    best, found = 0.0, (float("nan"), float("nan"))
    for period in PULSE_PERIOD_CANDIDATES_S:
        scale = _WAVELET_PEAK_FREQUENCY_CYCLES_IN_SUPPORT / _WAVELET_SUPPORT_LENGTH_IN_ARGUMENT_UNITS * period
        stretched = np.interp(
            np.arange(0.0, _WAVELET_SUPPORT_LENGTH_IN_ARGUMENT_UNITS, interval / scale), places, wavelet
        ) / np.sqrt(scale)
        coefficient = np.fft.irfft(spectrum * np.fft.rfft(stretched, count).conj(), count)
        strength = (coefficient**2).sum(axis=0)
        at = int(strength.argmax())
        if strength[at] > best * (1.0 + 1e-9):
            best = float(strength[at])
            north, east = coefficient[:, at]
            found = (float(np.round(_azimuth_deg_of_vector(north, east) % 180.0, 4) % 180.0), float(period))
    return found
