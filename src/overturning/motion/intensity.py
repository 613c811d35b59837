"""Intensity measures by azimuth, and of the three-component record."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray, create_xarray_dataset
from overturning.motion.direction import checked_azimuths, north_east_cosines_of_azimuths
from overturning.motion.integration import integrate
from overturning.motion.motion import Accelerogram
from overturning.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    import xarray


PEAK_UNITS_AND_LONG_NAMES = {
    "pga": ("m s-2", "peak ground acceleration"),
    "pgv": ("m s-1", "peak ground velocity"),
    "pgd": ("m", "peak ground displacement"),
}
"""Unit and long name of the peak values."""

MEASURE_UNITS_AND_LONG_NAMES = PEAK_UNITS_AND_LONG_NAMES | {
    "arias": ("m s-1", "Arias intensity"),
    "cav": ("m s-1", "cumulative absolute velocity"),
    "duration": ("s", "significant duration, 5 to 95 % of the Arias intensity"),
    "si20": ("m s-1", "spectrum intensity, damping ratio 0.20"),
    "si05": ("m s-1", "spectrum intensity, damping ratio 0.05"),
    "predominant_period": ("s", "period of the largest pseudo-acceleration, damping ratio 0.05"),
}
"""Unit and long name of every measure by azimuth."""

PREDOMINANT_PERIOD_CANDIDATES_S = np.geomspace(0.04, 4.0, 81)
"""Periods at which the predominant period is searched, s, in steps of 6 %."""


def intensity_measures_by_azimuth(motion: Accelerogram, azimuth_deg: ArrayLike) -> dict[str, FloatArray]:
    """Return the intensity measures of a motion along m azimuths in degrees, by name, shape (m,) each.

    The measures of φ and φ + 180° are the same, so only half a circle is computed. Velocity and displacement come
    from the trapezoidal rule, starting from rest; integration and rotation commute, so each component is integrated
    once. Along an azimuth without motion, the predominant period is NaN and all other measures are 0.
    """
    from overturning.motion.peaks import largest_motion_along_azimuths
    from overturning.motion.spectra import housner_spectrum_intensity, pseudo_acceleration_spectra

    half, back = np.unique(np.round(checked_azimuths(azimuth_deg) % 180.0, 9), return_inverse=True)
    velocity = integrate(motion.horizontal_components, motion.sampling_interval)
    series = (motion.horizontal_components, velocity, integrate(velocity, motion.sampling_interval))
    measures = {
        name: largest_motion_along_azimuths(pair, north_east_cosines_of_azimuths(half))
        for name, pair in zip(PEAK_UNITS_AND_LONG_NAMES, series, strict=True)
    }
    measures["arias"] = arias_intensity(motion, half)
    measures["cav"] = cumulative_absolute_velocity(motion, half)
    measures["duration"] = significant_duration(motion, half)
    measures["si20"] = housner_spectrum_intensity(motion, half, damping_ratio=0.20)
    measures["si05"] = housner_spectrum_intensity(motion, half, damping_ratio=0.05)
    spectra = pseudo_acceleration_spectra(
        motion, PREDOMINANT_PERIOD_CANDIDATES_S, half, interpolated_points_per_oscillator_period=24
    )
    of_largest = PREDOMINANT_PERIOD_CANDIDATES_S[spectra.argmax(axis=0)]
    measures["predominant_period"] = np.where(measures["duration"] > 0, of_largest, np.nan)
    return {name: values[back] for name, values in measures.items()}


def intensity_dataset_by_azimuth(motion: Accelerogram, azimuth_deg: ArrayLike) -> "xarray.Dataset":
    """Return the intensity measures of a motion along azimuths, degrees clockwise from north, as an xarray dataset."""
    azimuths = checked_azimuths(azimuth_deg)
    variables = {
        name: (
            "azimuth",
            values,
            {"units": MEASURE_UNITS_AND_LONG_NAMES[name][0], "long_name": MEASURE_UNITS_AND_LONG_NAMES[name][1]},
        )
        for name, values in intensity_measures_by_azimuth(motion, azimuths).items()
    }
    coordinate = ("azimuth", azimuths, {"units": "degree", "long_name": "azimuth of the motion, clockwise from north"})
    return create_xarray_dataset(variables, {"azimuth": coordinate}, {})


def jma_intensity_and_raw_and_processed_peaks(
    motion: Accelerogram, processing_steps_of_record: Sequence[Mapping[str, Any]]
) -> dict[str, Any]:
    """Return JMA intensities of a record, with and without the vertical, and its peaks before and after processing.

    Returns
    -------
    dict
        ``jma_intensity`` (None without a vertical component) and ``jma_intensity_horizontal`` (north and east only);
        both None if the motion is shorter than the 0.3 s that define the intensity.
        ``pga_unprocessed``, ``pga_processed`` and so on: peaks (largest of north and east, SI units) before the first
        and after the last processing step; None if the record was not processed.
    """
    from overturning.motion.jma_intensity import JMA_LEVEL_DURATION_S, jma_instrumental_intensity

    defined = motion.duration >= JMA_LEVEL_DURATION_S
    measures: dict[str, Any] = {
        "jma_intensity": jma_instrumental_intensity(motion) if defined and motion.up is not None else None,
        "jma_intensity_horizontal": jma_instrumental_intensity(motion, horizontal_only=True) if defined else None,
    }
    for name in PEAK_UNITS_AND_LONG_NAMES:
        effects = [step["effect"][name] for step in processing_steps_of_record]
        measures[f"{name}_unprocessed"] = effects[0][0] if effects else None
        measures[f"{name}_processed"] = effects[-1][1] if effects else None
    return measures


def arias_intensity(motion: Accelerogram, azimuth_deg: ArrayLike) -> FloatArray:
    """Return the Arias intensity π/(2g) ∫ a² dt (Arias 1970), m/s, along m azimuths in degrees, shape (m,).

    The integral uses the trapezoidal rule. a(φ)² is a quadratic form in cos φ and sin φ, so three integrals give
    the intensity along all azimuths.
    """
    cosines = north_east_cosines_of_azimuths(azimuth_deg)
    squares = np.array(
        [np.trapezoid(p, dx=motion.sampling_interval) for p in _products_nn_ne_ee_of_horizontal_components(motion)]
    )
    # Perpendicular to a linear motion, rounding may give a tiny negative sum.
    return (
        math.pi / (2.0 * STANDARD_GRAVITY) * np.maximum(_north_east_product_factors_by_azimuth(cosines) @ squares, 0.0)
    )


def cumulative_absolute_velocity(motion: Accelerogram, azimuth_deg: ArrayLike) -> FloatArray:
    """Return the cumulative absolute velocity ∫ |a| dt (EPRI 1988), m/s, along m azimuths in degrees, shape (m,).

    The integral uses the trapezoidal rule.
    """
    cosines = north_east_cosines_of_azimuths(azimuth_deg)
    sizes = (np.abs(c * motion.north + s * motion.east) for c, s in cosines)
    return np.array([np.trapezoid(size, dx=motion.sampling_interval) for size in sizes])


def significant_duration(motion: Accelerogram, azimuth_deg: ArrayLike) -> FloatArray:
    """Return the time from 5 to 95 % of the Arias intensity along m azimuths (Trifunac & Brady 1975), s, shape (m,).

    The cumulative intensity is interpolated linearly between samples. The duration is 0 along an azimuth without
    motion.
    """
    cosines = north_east_cosines_of_azimuths(azimuth_deg)
    summed = integrate(_products_nn_ne_ee_of_horizontal_components(motion), motion.sampling_interval)
    time = np.arange(motion.sample_count) * motion.sampling_interval
    measure = np.zeros(cosines.shape[0])
    for row, form in enumerate(_north_east_product_factors_by_azimuth(cosines)):
        along = form @ summed
        # Perpendicular to a linear motion, rounding gives tiny negative increments: keep the integral monotonic.
        along = np.maximum.accumulate(along)
        if along[-1] > 1e-12 * (summed[0, -1] + summed[2, -1]):
            first, last = np.interp([0.05 * along[-1], 0.95 * along[-1]], along, time)
            measure[row] = last - first
    return measure


def _products_nn_ne_ee_of_horizontal_components(motion: Accelerogram) -> FloatArray:
    """Return the products n², n e and e² of the north (n) and east (e) accelerations, m²/s⁴, (3, samples)."""
    return np.stack([motion.north**2, motion.north * motion.east, motion.east**2])


def _north_east_product_factors_by_azimuth(north_east_cosines_by_azimuth: FloatArray) -> FloatArray:
    """Return the factors of n², n e and e² (n north, e east) in the squared motion along m azimuths, shape (m, 3)."""
    c, s = north_east_cosines_by_azimuth[:, 0], north_east_cosines_by_azimuth[:, 1]
    return np.column_stack([c * c, 2.0 * c * s, s * s])
