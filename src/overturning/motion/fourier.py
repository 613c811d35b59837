"""Fourier amplitude spectra, raw and smoothed after Konno & Ohmachi."""

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError


def amplitude_spectrum(acceleration: ArrayLike, sampling_interval: float) -> tuple[FloatArray, FloatArray]:
    """Fourier amplitude |∫ a exp(−2πift) dt| at the frequencies of the record.

    Parameters
    ----------
    acceleration : array_like, shape (n,)
        m/s².
    sampling_interval : float
        s.

    Returns
    -------
    frequency, amplitude : ndarray, shape (n // 2 + 1,)
        Hz; m/s.
    """
    samples = np.asarray(acceleration, dtype=np.float64)
    if samples.ndim != 1 or samples.size < 2:
        raise ArgumentError(f"acceleration: shape {samples.shape}; a component is one row of at least 2 samples")
    return (
        np.asarray(np.fft.rfftfreq(samples.size, sampling_interval), dtype=np.float64),
        np.abs(np.fft.rfft(samples)) * sampling_interval,
    )


def konno_ohmachi(
    frequency: FloatArray, amplitude: FloatArray, at: ArrayLike, *, bandwidth: float = 40.0
) -> FloatArray:
    """Smooth a spectrum (Konno & Ohmachi 1998, BSSA 88, 228-241), by pykooh.

    Parameters
    ----------
    frequency, amplitude : ndarray, shape (k,)
        The raw spectrum; a frequency of 0 is left out.
    at : array_like, shape (q,)
        Frequencies at which the smoothed spectrum is wanted, Hz.
    bandwidth : float
        Coefficient b; 40 is usual, smaller is smoother.

    Returns
    -------
    ndarray, shape (q,)
        Same unit as the amplitude.

    Raises
    ------
    ArgumentError
        If a frequency is not positive.
    """
    import pykooh

    wanted = np.atleast_1d(np.asarray(at, dtype=np.float64))
    if not (np.isfinite(wanted) & (wanted > 0)).all():
        raise ArgumentError("at: smoothed spectra have positive frequencies only")
    positive = frequency > 0
    return np.asarray(pykooh.smooth(wanted, frequency[positive], amplitude[positive], bandwidth), dtype=np.float64)
