"""Response spectra by azimuth and over all azimuths (RotD), and spectrum intensity."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.motion.integration import integrate
from overturning.motion.motion import Motion
from overturning.motion.oscillator import POINTS_PER_PERIOD, Oscillators, checked_periods
from overturning.motion.rotation import cosines_of, largest_along

PERIODS = np.geomspace(0.01, 10.0, 100)
"""Periods of the spectra unless others are asked for, s."""

SI_PERIODS = np.linspace(0.1, 2.5, 121)
"""Periods over which the spectrum intensity is integrated, s."""

ROTD_AZIMUTHS = np.arange(180.0)
"""Azimuths of RotD, degrees: half a turn, for the peaks of φ and φ + 180° are the same."""


def spectra_by_azimuth(
    motion: Motion,
    period_s: ArrayLike,
    azimuth_deg: ArrayLike,
    *,
    damping: float = 0.05,
    points_per_period: int = POINTS_PER_PERIOD,
) -> dict[str, FloatArray]:
    """Response spectra along azimuths.

    Parameters
    ----------
    motion : Motion
    period_s : array_like, shape (p,)
        Periods, s.
    azimuth_deg : array_like, shape (m,)
        Azimuths, degrees clockwise from north.
    damping : float
        Damping ratio.
    points_per_period : int
        Points per period at which the peaks are sought.

    Returns
    -------
    dict of str to ndarray, shape (p, m)
        ``displacement`` (m) and ``velocity`` (m/s) relative to the ground, ``acceleration`` = ω² × displacement (m/s²,
        pseudo-acceleration).
    """
    periods, cosines = checked_periods(period_s), cosines_of(azimuth_deg)
    acceleration = motion.horizontal
    oscillators = Oscillators(acceleration, motion.sampling_interval, float(periods.max()), points_per_period)
    spectra = {name: np.empty((periods.size, cosines.shape[0])) for name in ("displacement", "velocity")}
    for row, period in enumerate(periods):
        responses = oscillators.response(float(period), damping, ("displacement", "velocity"))
        for name, response in zip(("displacement", "velocity"), responses, strict=True):
            spectra[name][row] = largest_along(response, cosines)
    spectra["acceleration"] = spectra["displacement"] * (2.0 * np.pi / periods[:, None]) ** 2
    return spectra


def rotd(
    motion: Motion,
    period_s: ArrayLike = PERIODS,
    *,
    damping: float = 0.05,
    percentiles: Sequence[float] = (0.0, 50.0, 100.0),
    azimuth_deg: ArrayLike = ROTD_AZIMUTHS,
) -> dict[str, FloatArray]:
    """RotDnn of PGA, PGV and of the pseudo-acceleration spectrum (Boore 2010, BSSA 100, 1830-1835).

    Parameters
    ----------
    motion : Motion
    period_s : array_like, shape (p,)
        Periods, s.
    damping : float
        Damping ratio.
    percentiles : sequence of float, length q
        Percentiles over the azimuths: 0, 50 and 100 are RotD00, RotD50 and RotD100.
    azimuth_deg : array_like
        Azimuths over half a turn, degrees.

    Returns
    -------
    dict of str to ndarray
        ``pga`` (q,) in m/s², ``pgv`` (q,) in m/s, ``psa`` (q, p) in m/s².
    """
    periods, cosines = checked_periods(period_s), cosines_of(azimuth_deg)
    acceleration = motion.horizontal
    oscillators = Oscillators(acceleration, motion.sampling_interval, float(periods.max()))
    psa = np.empty((len(percentiles), periods.size))
    for column, period in enumerate(periods):
        (response,) = oscillators.response(float(period), damping, ("displacement",))
        peaks = largest_along(response, cosines) * (2.0 * np.pi / period) ** 2
        psa[:, column] = np.percentile(peaks, percentiles)
    velocity = integrate(acceleration, motion.sampling_interval)
    return {
        "pga": np.percentile(largest_along(acceleration, cosines), percentiles),
        "pgv": np.percentile(largest_along(velocity, cosines), percentiles),
        "psa": psa,
    }


def spectrum_intensity(motion: Motion, azimuth_deg: ArrayLike, *, damping: float = 0.20) -> FloatArray:
    """Housner's spectrum intensity as it is used in Japan: the mean of the velocity spectrum from 0.1 to 2.5 s.

    SI = 1/2.4 ∫ S_v(T, h) dT, S_v the largest velocity relative to the ground (Housner 1952; h = 0.20 after Katayama et al.
    1988), by the trapezoidal rule over 121 periods.

    Parameters
    ----------
    motion : Motion
    azimuth_deg : array_like, shape (m,)
        Azimuths, degrees clockwise from north.
    damping : float
        Damping ratio h: 0.20, or 0.05 for the other variant in use.

    Returns
    -------
    ndarray, shape (m,)
        m/s.
    """
    cosines = cosines_of(azimuth_deg)
    acceleration = motion.horizontal
    # A mean over 121 strongly damped spectra: 24 points per period (0.9 % at worst, 0.3 % on average for one of them) will do.
    oscillators = Oscillators(acceleration, motion.sampling_interval, float(SI_PERIODS.max()), points_per_period=24)
    peaks = np.empty((SI_PERIODS.size, cosines.shape[0]))
    for row, period in enumerate(SI_PERIODS):
        (response,) = oscillators.response(float(period), damping, ("velocity",))
        peaks[row] = largest_along(response, cosines)
    return np.asarray(np.trapezoid(peaks, SI_PERIODS, axis=0) / (SI_PERIODS[-1] - SI_PERIODS[0]))


def component_spectrum(
    acceleration: ArrayLike, sampling_interval: float, period_s: ArrayLike, *, damping: float = 0.05
) -> FloatArray:
    """Pseudo-acceleration spectrum of one component, shape (p,), m/s².

    Raises
    ------
    ArgumentError
        If the component is not one row of numbers.
    """
    samples = np.asarray(acceleration, dtype=np.float64)
    if samples.ndim != 1 or samples.size < 2:
        raise ArgumentError(f"acceleration: shape {samples.shape}; a component is one row of at least 2 samples")
    periods = checked_periods(period_s)
    oscillators = Oscillators(samples[None, :], sampling_interval, float(periods.max()))
    peaks = [np.abs(oscillators.response(float(t), damping, ("displacement",))[0]).max() for t in periods]
    return np.array(peaks) * (2.0 * np.pi / periods) ** 2
