"""Fourier amplitude spectra, raw and smoothed after Konno & Ohmachi."""

from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError

_RAW_PER_LOWEST: Final = 16
"""Frequencies of a spectrum up to the lowest at which it is smoothed: the window, b = 40, is a few percent wide."""


def amplitude_spectrum(acceleration: ArrayLike, sampling_interval: float) -> tuple[FloatArray, FloatArray]:
    """Fourier amplitude |∫ a exp(−2πift) dt| of one component, and the frequencies of the record, Hz; shape (n // 2 + 1,)."""
    samples = np.asarray(acceleration, dtype=np.float64)
    if samples.ndim != 1 or samples.size < 2:
        raise ArgumentError(f"acceleration: shape {samples.shape}; a component is one row of at least 2 samples")
    return (
        np.asarray(np.fft.rfftfreq(samples.size, sampling_interval), dtype=np.float64),
        np.abs(np.fft.rfft(samples)) * sampling_interval,
    )


def smoothed_amplitude(acceleration: FloatArray, sampling_interval: float, at: FloatArray) -> FloatArray:
    """Fourier amplitude of one component, smoothed after Konno and Ohmachi at the frequencies ``at``, Hz, however short it is.

    Zeros are put behind it until its own frequencies are so dense that some lie in the narrow window about the lowest
    wanted one.
    """
    needed = int(np.ceil(_RAW_PER_LOWEST / float(np.min(at)) / sampling_interval))
    padded = np.pad(acceleration, (0, max(0, needed - acceleration.size)))
    return konno_ohmachi(*amplitude_spectrum(padded, sampling_interval), at)


def konno_ohmachi(frequency: FloatArray, amplitude: FloatArray, at: ArrayLike) -> FloatArray:
    """Smooth a raw spectrum at the frequencies ``at`` (Konno & Ohmachi 1998, BSSA 88, 228-241), by pykooh.

    A frequency of 0 is left out of the spectrum and refused in ``at``. The coefficient b is the usual 40.
    """
    import pykooh

    wanted = np.atleast_1d(np.asarray(at, dtype=np.float64))
    if not (np.isfinite(wanted) & (wanted > 0)).all():
        raise ArgumentError("at: smoothed spectra have positive frequencies only")
    positive = frequency > 0
    return np.asarray(pykooh.smooth(wanted, frequency[positive], amplitude[positive], 40.0), dtype=np.float64)
