"""Fourier amplitude spectra, raw and smoothed after Konno & Ohmachi."""

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError


def fourier_amplitude_spectrum(acceleration: ArrayLike, sampling_interval: float) -> tuple[FloatArray, FloatArray]:
    """Return frequencies, Hz, and Fourier amplitudes |∫ a exp(−2πift) dt| of n samples, shape (n // 2 + 1,)."""
    samples = np.asarray(acceleration, dtype=np.float64)
    if samples.ndim != 1 or samples.size < 2:
        raise ArgumentError(f"acceleration: shape {samples.shape}; a component is one row of at least 2 samples")
    return (
        np.asarray(np.fft.rfftfreq(samples.size, sampling_interval), dtype=np.float64),
        np.abs(np.fft.rfft(samples)) * sampling_interval,
    )


def cosine_taper_window(sample_count: int, sample_count_of_taper_at_each_end: int) -> FloatArray:
    """Return a Tukey window: weights 1, with a half-cosine taper over some samples at each end, shape (samples,)."""
    window = np.ones(sample_count)
    window[:sample_count_of_taper_at_each_end] = 0.5 * (
        1.0 - np.cos(np.pi * np.arange(sample_count_of_taper_at_each_end) / sample_count_of_taper_at_each_end)
    )
    window[-sample_count_of_taper_at_each_end:] = window[:sample_count_of_taper_at_each_end][::-1]
    return window


def rms_fourier_amplitude_in_bands(
    acceleration: FloatArray, sampling_interval: float, log_spaced_centre_frequencies_hz: FloatArray
) -> FloatArray:
    """Return the root mean square Fourier amplitude, m/s, in m bands around the centre frequencies, shape (m,).

    Neighbouring bands meet at the geometric mean of their centre frequencies. A short record is padded with zeros so
    that every band contains at least one frequency.
    """
    ratio = float(log_spaced_centre_frequencies_hz[1] / log_spaced_centre_frequencies_hz[0])
    needed = int(np.ceil(2.0 / (log_spaced_centre_frequencies_hz[0] * (ratio - 1.0)) / sampling_interval))
    padded = np.pad(acceleration, (0, max(0, needed - acceleration.size)))
    frequency, amplitude = fourier_amplitude_spectrum(padded, sampling_interval)
    edges = np.append(
        log_spaced_centre_frequencies_hz / np.sqrt(ratio), log_spaced_centre_frequencies_hz[-1] * np.sqrt(ratio)
    )
    bounds = np.searchsorted(frequency, edges)
    powers = np.concatenate([[0.0], np.cumsum(amplitude**2)])
    return np.sqrt((powers[bounds[1:]] - powers[bounds[:-1]]) / np.maximum(np.diff(bounds), 1))


def konno_ohmachi_smoothed_amplitude(
    frequencies_hz: FloatArray, fourier_amplitude: FloatArray, log_spaced_centre_frequencies_hz: ArrayLike
) -> FloatArray:
    """Return Fourier amplitudes smoothed at the centre frequencies (Konno & Ohmachi 1998, BSSA 88, 228, equation 4).

    Frequencies are in Hz. The amplitude at 0 Hz is left out; centre frequencies must be above 0. The bandwidth
    coefficient b is 40, as usual. The result is NaN where the smoothing weights sum to at most 0.3: the record is then
    too short, and the frequencies of its spectrum are too far apart.
    """
    wanted = np.atleast_1d(np.asarray(log_spaced_centre_frequencies_hz, dtype=np.float64))
    if not (np.isfinite(wanted) & (wanted > 0)).all():
        raise ArgumentError("centre_frequencies: smoothed spectra have positive frequencies only")
    positive = frequencies_hz > 0
    octaves, smoothed = 40.0 / np.pi * np.log10(frequencies_hz[positive]), np.full(wanted.size, np.nan)
    for place, centre in enumerate(40.0 / np.pi * np.log10(wanted)):
        weight = np.square(np.square(np.sinc(octaves - centre)))
        if (total := weight.sum()) > 0.3:
            smoothed[place] = (weight * fourier_amplitude[positive]).sum() / total
    return smoothed
