"""Onset of a motion, noise before it, and signal-to-noise ratio by frequency."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.motion.fourier import cosine_taper_window, rms_fourier_amplitude_in_bands

MIN_NOISE_WINDOW_S: Final = 2.0
"""Shortest time before the onset that is used as noise, s; longer if samples are more than 0.13 s apart."""

MIN_CYCLES_IN_NOISE_WINDOW: Final = 3.0
"""Cycles of the lowest frequency in the noise window; with one or two, mean removal and taper would distort it."""

MIN_SPECTRUM_FREQUENCY_HZ: Final = 0.01
"""Lowest frequency, Hz: below it accelerographs cannot distinguish motion from tilt."""

MAX_FREQUENCY_CYCLES_PER_SAMPLE: Final = 0.4
"""Highest frequency, in cycles per sample: a little below the Nyquist frequency."""

FREQUENCY_BANDS_PER_DECADE: Final = 20
"""Frequency bands per decade."""


@dataclass(frozen=True)
class SignalNoiseSpectra:
    """Signal and noise spectra of the components of a record, and the onset time of the motion."""

    onset_s: float  # s after the first sample; the noise is before it
    band_centre_frequencies_hz: FloatArray  # Hz, shape (m,); the noise window holds at least three cycles of the lowest
    # Fourier amplitudes in bands over the root of the window's length, m/s^1.5, shape (components, m)
    signal_amplitude_per_root_duration: FloatArray
    noise_amplitude_per_root_duration: FloatArray
    baseline_step_amplitude_per_root_duration: (
        FloatArray  # amplitude of a step between the levels before and after the signal (tilt of the sensor)
    )

    @property
    def signal_over_noise_plus_offset_spectrum(self) -> FloatArray:
        """Signal spectrum over the spectrum of noise and permanent offset, shape (components, m) for m frequencies."""
        return self.signal_amplitude_per_root_duration / np.hypot(
            self.noise_amplitude_per_root_duration, self.baseline_step_amplitude_per_root_duration
        )


def motion_onset_index(acceleration_samples: FloatArray) -> int:
    """Return the index of the acceleration sample at which a component starts to move; 0 if no noise precedes it.

    The differences of consecutive samples are used, because offset and drift do not affect them. Those before the
    largest one are split into noise and motion where the Akaike criterion of their two variances is smallest (Maeda
    1985, Zisin 38, 365-379).
    """
    steps = np.diff(acceleration_samples)
    size = int(np.abs(steps).argmax())
    if size < 4:
        return 0
    steps = steps[:size]
    k = np.arange(1, size)
    ahead = np.cumsum(steps)[:-1], np.cumsum(steps**2)[:-1]
    behind = steps.sum() - ahead[0], (steps**2).sum() - ahead[1]
    tiny = 1e-12 * float((steps**2).mean()) + np.finfo(float).tiny
    variances = [
        np.maximum(squares / n - (sums / n) ** 2, tiny) for (sums, squares), n in ((ahead, k), (behind, size - k))
    ]
    criterion = k * np.log(variances[0]) + (size - k) * np.log(variances[1])
    return int(k[criterion.argmin()])


def shortest_usable_noise_window_s(sampling_interval: float) -> float:
    """Return the shortest noise window before the onset, s: 2 s, or 3 cycles at half the highest frequency if more."""
    return max(
        MIN_NOISE_WINDOW_S, 2.0 * MIN_CYCLES_IN_NOISE_WINDOW * sampling_interval / MAX_FREQUENCY_CYCLES_PER_SAMPLE
    )


def signal_and_noise_spectra(
    acceleration_components: Sequence[FloatArray], sampling_interval: float
) -> SignalNoiseSpectra | None:
    """Return spectra of a record's motion (signal) and of the noise before it; None if there is too little noise.

    The noise window ends at the earliest onset of any component; the signal window extends from there to 95 % of the
    cumulative squared acceleration. Both are tapered over 5 % at each end. Amplitudes are divided by the square root of
    the window's length, so that those of stationary noise do not depend on it.

    Shaking may tilt the sensor and leave a permanent offset, which the noise before the onset does not contain. The
    offset a is the difference of the mean levels before and after the signal, each under a Hann window, which reduces
    the influence of slow coda waves (compare Boore 2001, BSSA 91, 1199-1211). It is added to the noise as a step with
    the amplitude a/(2πf).
    """
    moving = [samples - samples.mean() for samples in acceleration_components if np.ptp(samples) > 0]
    first = min((motion_onset_index(samples) for samples in moving), default=0)
    too_short = first * sampling_interval < shortest_usable_noise_window_s(sampling_interval)
    if too_short or not all(np.ptp(samples[:first]) > 0 for samples in moving):
        return None
    energy = np.cumsum(np.sum([samples[first:] ** 2 for samples in moving], axis=0))
    last = first + int(np.searchsorted(energy, 0.95 * energy[-1])) + 1
    lowest, highest = (
        max(MIN_CYCLES_IN_NOISE_WINDOW / (first * sampling_interval), MIN_SPECTRUM_FREQUENCY_HZ),
        MAX_FREQUENCY_CYCLES_PER_SAMPLE / sampling_interval,
    )
    frequency = np.geomspace(
        lowest, highest, max(2, round(FREQUENCY_BANDS_PER_DECADE * np.log10(highest / lowest)) + 1)
    )
    signal, noise = (
        np.stack(
            [_fourier_amplitude_per_root_duration(samples[part], sampling_interval, frequency) for samples in moving]
        )
        for part in (slice(first, last), slice(0, first))
    )
    steps = [abs(_hann_weighted_mean(samples[last:]) - _hann_weighted_mean(samples[:first])) for samples in moving]
    offset = np.outer(steps, 1.0 / (2.0 * np.pi * frequency * np.sqrt((last - first) * sampling_interval)))
    return SignalNoiseSpectra(first * sampling_interval, frequency, signal, noise, offset)


def _hann_weighted_mean(samples: FloatArray) -> float:
    """Return the mean of samples, weighted by a Hann window; 0 without samples."""
    weight = np.sin(np.pi * (np.arange(samples.size) + 0.5) / max(samples.size, 1)) ** 2
    return float(weight @ samples / weight.sum()) if samples.size else 0.0


def _fourier_amplitude_per_root_duration(
    acceleration_samples: FloatArray, sampling_interval: float, log_spaced_centre_frequencies_hz: FloatArray
) -> FloatArray:
    """Return rms Fourier amplitudes in bands around m frequencies, divided by √duration, m/s^1.5, shape (m,)."""
    window = cosine_taper_window(acceleration_samples.size, max(1, acceleration_samples.size // 20))
    amplitude = rms_fourier_amplitude_in_bands(
        (acceleration_samples - acceleration_samples.mean()) * window,
        sampling_interval,
        log_spaced_centre_frequencies_hz,
    )
    return amplitude / np.sqrt(acceleration_samples.size * sampling_interval)
