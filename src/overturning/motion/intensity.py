"""Intensity measures by azimuth, and of the whole record."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.motion.direction import checked_azimuths, cosines_of, largest_along
from overturning.motion.integration import integrate
from overturning.motion.motion import Recorded
from overturning.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    import xarray


PEAKS = {
    "pga": ("m s-2", "peak ground acceleration"),
    "pgv": ("m s-1", "peak ground velocity"),
    "pgd": ("m", "peak ground displacement"),
}
"""Unit and long name of the measures that need no oscillator."""

MEASURES = PEAKS | {
    "arias": ("m s-1", "Arias intensity"),
    "cav": ("m s-1", "cumulative absolute velocity"),
    "duration": ("s", "significant duration, 5 to 95 % of the Arias intensity"),
    "si20": ("m s-1", "spectrum intensity, damping ratio 0.20"),
    "si05": ("m s-1", "spectrum intensity, damping ratio 0.05"),
    "predominant_period": ("s", "period of the largest pseudo-acceleration, damping ratio 0.05"),
}
"""Unit and long name of every measure by azimuth."""

PREDOMINANT_PERIODS = np.geomspace(0.04, 4.0, 81)
"""Periods among which the predominant one is sought, s: 6 % apart."""


def measures_by_azimuth(motion: Recorded, azimuth_deg: ArrayLike) -> dict[str, FloatArray]:
    """Every measure of ``MEASURES`` along azimuths, shape (m,), without xarray; see its functions for the definitions.

    The measures of φ and φ + 180° are the same, so half a turn is computed. Velocity and displacement come from the
    trapezoidal rule, starting from rest; integration and rotation commute, so each component is integrated once.
    """
    from overturning.motion.spectra import pseudo_acceleration, spectrum_intensity

    half, back = np.unique(np.round(checked_azimuths(azimuth_deg) % 180.0, 9), return_inverse=True)
    velocity = integrate(motion.horizontal, motion.sampling_interval)
    series = (motion.horizontal, velocity, integrate(velocity, motion.sampling_interval))
    measures = {name: largest_along(pair, cosines_of(half)) for name, pair in zip(PEAKS, series, strict=True)}
    measures["arias"] = arias_intensity(motion, half)
    measures["cav"] = cumulative_absolute_velocity(motion, half)
    measures["duration"] = significant_duration(motion, half)
    measures["si20"] = spectrum_intensity(motion, half, damping=0.20)
    measures["si05"] = spectrum_intensity(motion, half, damping=0.05)
    spectra = pseudo_acceleration(motion, PREDOMINANT_PERIODS, half, points_per_period=24)
    measures["predominant_period"] = PREDOMINANT_PERIODS[spectra.argmax(axis=0)]
    return {name: values[back] for name, values in measures.items()}


def intensity_by_azimuth(motion: Recorded, azimuth_deg: ArrayLike) -> "xarray.Dataset":
    """The measures of ``MEASURES`` along azimuths, degrees clockwise from north (dimension ``azimuth``)."""
    import xarray as xr

    azimuths = checked_azimuths(azimuth_deg)
    variables = {
        name: ("azimuth", values, {"units": MEASURES[name][0], "long_name": MEASURES[name][1]})
        for name, values in measures_by_azimuth(motion, azimuths).items()
    }
    coordinate = ("azimuth", azimuths, {"units": "degree", "long_name": "azimuth of the motion, clockwise from north"})
    return xr.Dataset(variables, {"azimuth": coordinate})


def record_measures(motion: Recorded, processing: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """JMA intensity of a whole processed record, and what the steps of its processing did to its peaks.

    Returns
    -------
    dict
        ``jma_intensity`` (None without a vertical component) and ``jma_intensity_horizontal`` of north and east alone;
        ``pga_unprocessed`` … and ``pga_processed`` … (largest of north and east, SI): the peaks before the first
        and after the last step, None for a record left alone.
    """
    from overturning.motion.jma_intensity import DURATION, instrumental_intensity

    measures: dict[str, Any] = {
        "jma_intensity": None if motion.up is None else instrumental_intensity(motion),
        "jma_intensity_horizontal": instrumental_intensity(motion, horizontal=True)
        if motion.duration >= DURATION
        else None,
    }
    for name in PEAKS:
        effects = [step["effect"][name] for step in processing]
        measures[f"{name}_unprocessed"] = effects[0][0] if effects else None
        measures[f"{name}_processed"] = effects[-1][1] if effects else None
    return measures


def arias_intensity(motion: Recorded, azimuth_deg: ArrayLike) -> FloatArray:
    """Arias intensity along azimuths, π/(2g) ∫ a² dt (Arias 1970), trapezoidal rule; m/s, shape (m,).

    a(φ)² is a quadratic form in cos φ and sin φ, so three integrals serve all azimuths.
    """
    cosines = cosines_of(azimuth_deg)
    squares = np.array([np.trapezoid(p, dx=motion.sampling_interval) for p in _products(motion)])
    return math.pi / (2.0 * STANDARD_GRAVITY) * (_forms(cosines) @ squares)


def cumulative_absolute_velocity(motion: Recorded, azimuth_deg: ArrayLike) -> FloatArray:
    """CAV along azimuths, ∫ |a| dt (EPRI 1988), trapezoidal rule; m/s, shape (m,)."""
    cosines = cosines_of(azimuth_deg)
    sizes = (np.abs(c * motion.north + s * motion.east) for c, s in cosines)
    return np.array([np.trapezoid(size, dx=motion.sampling_interval) for size in sizes])


def significant_duration(motion: Recorded, azimuth_deg: ArrayLike) -> FloatArray:
    """Time from 5 to 95 % of the Arias intensity along azimuths (Trifunac & Brady 1975); s, shape (m,).

    Between samples the cumulative intensity is taken as a straight line; 0 along an azimuth without motion.
    """
    cosines = cosines_of(azimuth_deg)
    summed = integrate(_products(motion), motion.sampling_interval)
    time = np.arange(motion.samples) * motion.sampling_interval
    measure = np.zeros(cosines.shape[0])
    for row, form in enumerate(_forms(cosines)):
        along = form @ summed
        # The form of a motion at right angles rounds to a tiny negative number: it must not fall.
        along = np.maximum.accumulate(along)
        if along[-1] > 1e-12 * (summed[0, -1] + summed[2, -1]):
            first, last = np.interp([0.05 * along[-1], 0.95 * along[-1]], along, time)
            measure[row] = last - first
    return measure


def _products(motion: Recorded) -> FloatArray:
    """n², n e, e², shape (3, n)."""
    return np.stack([motion.north**2, motion.north * motion.east, motion.east**2])


def _forms(cosines: FloatArray) -> FloatArray:
    """Coefficients of n², n e, e² in a(φ)², shape (m, 3)."""
    c, s = cosines[:, 0], cosines[:, 1]
    return np.column_stack([c * c, 2.0 * c * s, s * s])
