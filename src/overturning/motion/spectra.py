"""Response spectra by azimuth and over all azimuths (RotD), and spectrum intensity."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.motion.direction import north_east_cosines_of_azimuths
from overturning.motion.integration import integrate
from overturning.motion.motion import Accelerogram
from overturning.motion.oscillator import (
    INTERPOLATED_POINTS_PER_OSCILLATOR_PERIOD,
    OscillatorResponseCalculator,
    ResponseQuantity,
    checked_periods,
)

SPECTRUM_INTENSITY_PERIODS_S = np.linspace(0.1, 2.5, 121)
"""Periods over which the spectrum intensity is integrated, s."""

ROTD_AZIMUTHS_DEG = np.arange(180.0)
"""Azimuths of RotD, degrees: half a circle, because the peaks of φ and φ + 180° are the same."""


def response_spectra_by_azimuth(
    motion: Accelerogram,
    period_s: ArrayLike,
    azimuth_deg: ArrayLike,
    *,
    damping_ratio: float = 0.05,
    interpolated_points_per_oscillator_period: int = INTERPOLATED_POINTS_PER_OSCILLATOR_PERIOD,
) -> dict[str, FloatArray]:
    """Return the response spectra of a motion along m azimuths (degrees), for p periods (s) and a damping ratio.

    Returns
    -------
    dict of str to ndarray, shape (p, m)
        ``displacement`` (m) and ``velocity`` (m/s) relative to the ground, ``acceleration`` = ω² × displacement
        (m/s², pseudo-acceleration).
    """
    periods, cosines = checked_periods(period_s), north_east_cosines_of_azimuths(azimuth_deg)
    both = _peak_oscillator_responses(
        motion, periods, cosines, damping_ratio, ("displacement", "velocity"), interpolated_points_per_oscillator_period
    )
    spectra = dict(zip(("displacement", "velocity"), both, strict=True))
    spectra["acceleration"] = _pseudo_acceleration_from_displacement(spectra["displacement"], periods)
    return spectra


def pseudo_acceleration_spectra(
    motion: Accelerogram,
    period_s: ArrayLike,
    azimuth_deg: ArrayLike,
    *,
    damping_ratio: float = 0.05,
    interpolated_points_per_oscillator_period: int = INTERPOLATED_POINTS_PER_OSCILLATOR_PERIOD,
) -> FloatArray:
    """Return pseudo-acceleration spectra along m azimuths (degrees), for p periods (s), m/s², shape (p, m).

    This takes half the time of `response_spectra_by_azimuth`, which computes the velocity too.
    """
    periods = checked_periods(period_s)
    peaks = _peak_oscillator_responses(
        motion,
        periods,
        north_east_cosines_of_azimuths(azimuth_deg),
        damping_ratio,
        ("displacement",),
        interpolated_points_per_oscillator_period,
    )
    return _pseudo_acceleration_from_displacement(peaks[0], periods)


def _pseudo_acceleration_from_displacement(
    peak_displacement_by_period_and_azimuth: FloatArray, periods_s: FloatArray
) -> FloatArray:
    """Return pseudo-accelerations ω² × displacement, m/s², shape (p, azimuths), from peak displacements (m)."""
    return np.asarray(peak_displacement_by_period_and_azimuth * (2.0 * np.pi / periods_s[:, None]) ** 2)


def _peak_oscillator_responses(
    motion: Accelerogram,
    periods_s: FloatArray,
    north_east_cosines_by_azimuth: FloatArray,
    damping_ratio: float,
    response_quantities: Sequence[ResponseQuantity],
    interpolated_points_per_oscillator_period: int = INTERPOLATED_POINTS_PER_OSCILLATOR_PERIOD,
) -> FloatArray:
    """Return oscillators' peak responses (m, m/s): q quantities, p periods (s) and m azimuths, shape (q, p, m)."""
    oscillators = OscillatorResponseCalculator(
        motion.horizontal_components,
        motion.sampling_interval,
        float(periods_s.max()),
        interpolated_points_per_oscillator_period,
    )
    peaks = np.empty((len(response_quantities), periods_s.size, north_east_cosines_by_azimuth.shape[0]))
    for column, period in enumerate(periods_s):
        peaks[:, column] = oscillators.peak_responses(
            float(period), damping_ratio, response_quantities, north_east_cosines_by_azimuth
        )
    return peaks


def rotd_percentile_measures(
    motion: Accelerogram, period_s: ArrayLike, *, percentiles_over_azimuths: Sequence[float] = (0.0, 50.0, 100.0)
) -> dict[str, FloatArray]:
    """Return percentiles over all azimuths (RotD) of PGA, PGV and pseudo-acceleration at 5 % damping.

    See Boore (2010, BSSA 100, 1830-1835). The azimuths are those of half a circle; the percentiles 0, 50 and 100 give
    RotD00, RotD50 and RotD100.

    Returns
    -------
    dict of str to ndarray
        ``pga`` (q,) in m/s², ``pgv`` (q,) in m/s, ``psa`` (q, p) in m/s², for q percentiles and p periods (s).
    """
    from overturning.motion.peaks import largest_motion_along_azimuths

    periods, cosines = checked_periods(period_s), north_east_cosines_of_azimuths(ROTD_AZIMUTHS_DEG)
    (displacement,) = _peak_oscillator_responses(motion, periods, cosines, 0.05, ("displacement",))
    psa = _pseudo_acceleration_from_displacement(displacement, periods)
    velocity = integrate(motion.horizontal_components, motion.sampling_interval)
    return {
        "pga": np.percentile(
            largest_motion_along_azimuths(motion.horizontal_components, cosines), percentiles_over_azimuths
        ),
        "pgv": np.percentile(largest_motion_along_azimuths(velocity, cosines), percentiles_over_azimuths),
        "psa": np.percentile(psa, percentiles_over_azimuths, axis=1),
    }


def housner_spectrum_intensity(
    motion: Accelerogram, azimuth_deg: ArrayLike, *, damping_ratio: float = 0.20
) -> FloatArray:
    """Return Housner's spectrum intensity in the Japanese definition along m azimuths, m/s, shape (m,).

    SI = 1/2.4 ∫ S_v(T, h) dT from 0.1 to 2.5 s, by the trapezoidal rule over 121 periods. S_v is the largest velocity
    relative to the ground (Housner 1952), the damping ratio h is 0.20 (Katayama et al. 1988) or 0.05.
    """
    # 24 points per period (error at most 0.9 %, on average 0.3 % for one period) suffice for a mean over 121 periods.
    (peaks,) = _peak_oscillator_responses(
        motion,
        SPECTRUM_INTENSITY_PERIODS_S,
        north_east_cosines_of_azimuths(azimuth_deg),
        damping_ratio,
        ("velocity",),
        24,
    )
    return np.asarray(
        np.trapezoid(peaks, SPECTRUM_INTENSITY_PERIODS_S, axis=0)
        / (SPECTRUM_INTENSITY_PERIODS_S[-1] - SPECTRUM_INTENSITY_PERIODS_S[0])
    )
