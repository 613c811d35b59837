"""Measures that add up over the record: Arias intensity, cumulative absolute velocity, significant duration."""

import math

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.motion.motion import Motion
from overturning.motion.rotation import cosines_of
from overturning.units import STANDARD_GRAVITY


def arias_intensity(motion: Motion, azimuth_deg: ArrayLike) -> FloatArray:
    """Arias intensity along azimuths, π/(2g) ∫ a² dt (Arias 1970), trapezoidal rule; m/s, shape (m,).

    a(φ)² is a quadratic form in cos φ and sin φ, so three integrals serve all azimuths.
    """
    cosines = cosines_of(azimuth_deg)
    squares = np.array([np.trapezoid(p, dx=motion.sampling_interval) for p in _products(motion)])
    return math.pi / (2.0 * STANDARD_GRAVITY) * (_forms(cosines) @ squares)


def cumulative_absolute_velocity(motion: Motion, azimuth_deg: ArrayLike) -> FloatArray:
    """CAV along azimuths, ∫ |a| dt (EPRI 1988), trapezoidal rule; m/s, shape (m,)."""
    cosines = cosines_of(azimuth_deg)
    sizes = (np.abs(c * motion.north + s * motion.east) for c, s in cosines)
    return np.array([np.trapezoid(size, dx=motion.sampling_interval) for size in sizes])


def significant_duration(motion: Motion, azimuth_deg: ArrayLike) -> FloatArray:
    """Time from 5 to 95 % of the Arias intensity along azimuths (Trifunac & Brady 1975); s, shape (m,).

    Between samples the cumulative intensity is taken as a straight line; 0 along an azimuth without motion.
    """
    cosines = cosines_of(azimuth_deg)
    interval = motion.sampling_interval
    summed = np.zeros((3, motion.samples))
    for row, product in enumerate(_products(motion)):
        np.cumsum(0.5 * interval * (product[1:] + product[:-1]), out=summed[row, 1:])
    time = np.arange(motion.samples) * interval
    measure = np.zeros(cosines.shape[0])
    for row, form in enumerate(_forms(cosines)):
        along = form @ summed
        # The form of a motion at right angles rounds to a tiny negative number: it must not fall.
        along = np.maximum.accumulate(along)
        if along[-1] > 1e-12 * (summed[0, -1] + summed[2, -1]):
            first, last = np.interp([0.05 * along[-1], 0.95 * along[-1]], along, time)
            measure[row] = last - first
    return measure


def _products(motion: Motion) -> FloatArray:
    """n², n e, e², shape (3, n)."""
    return np.stack([motion.north**2, motion.north * motion.east, motion.east**2])


def _forms(cosines: FloatArray) -> FloatArray:
    """Coefficients of n², n e, e² in a(φ)², shape (m, 3)."""
    c, s = cosines[:, 0], cosines[:, 1]
    return np.column_stack([c * c, 2.0 * c * s, s * s])
