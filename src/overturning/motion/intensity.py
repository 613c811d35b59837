"""Intensity measures by azimuth: peaks of acceleration, velocity and displacement."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.errors import ArgumentError
from overturning.motion.direction import direction_cosines
from overturning.motion.motion import Motion
from overturning.records.integration import integrate

if TYPE_CHECKING:
    import xarray

MEASURES = {
    "pga": ("m s-2", "peak ground acceleration"),
    "pgv": ("m s-1", "peak ground velocity"),
    "pgd": ("m", "peak ground displacement"),
}
"""Unit and long name of each measure."""


def peaks_by_azimuth(motion: Motion, azimuth_deg: ArrayLike) -> dict[str, NDArray[np.float64]]:
    """PGA, PGV and PGD along azimuths, without xarray.

    Velocity and displacement come from the trapezoidal rule, starting from rest; integration and rotation commute, so each
    component is integrated once and no rotated motion outlives its azimuth.

    Parameters
    ----------
    motion : Motion
    azimuth_deg : array_like, shape (m,)
        Azimuths φ, degrees clockwise from north.

    Returns
    -------
    dict of str to ndarray, shape (m,)
        ``pga`` in m/s², ``pgv`` in m/s, ``pgd`` in m.
    """
    azimuths = checked_azimuths(azimuth_deg)
    acceleration = np.stack([motion.north, motion.east])
    velocity = integrate(acceleration, motion.sampling_interval)
    displacement = integrate(velocity, motion.sampling_interval)
    found = {name: np.empty(azimuths.size) for name in MEASURES}
    for row, azimuth in enumerate(azimuths):
        cosines = np.array(direction_cosines(float(azimuth)))
        for name, pair in zip(MEASURES, (acceleration, velocity, displacement), strict=True):
            found[name][row] = np.abs(cosines @ pair).max()
    return found


def intensity_by_azimuth(motion: Motion, azimuth_deg: ArrayLike) -> "xarray.Dataset":
    """Intensity measures along azimuths.

    Parameters
    ----------
    motion : Motion
    azimuth_deg : array_like, shape (m,)
        Azimuths φ, degrees clockwise from north.

    Returns
    -------
    xarray.Dataset
        Dimension ``azimuth`` (degrees); variables ``pga`` (m/s²), ``pgv`` (m/s), ``pgd`` (m).
    """
    import xarray as xr

    azimuths = checked_azimuths(azimuth_deg)
    variables = {
        name: ("azimuth", values, {"units": MEASURES[name][0], "long_name": MEASURES[name][1]})
        for name, values in peaks_by_azimuth(motion, azimuths).items()
    }
    coordinate = ("azimuth", azimuths, {"units": "degree", "long_name": "azimuth of the motion, clockwise from north"})
    return xr.Dataset(variables, {"azimuth": coordinate})


def checked_azimuths(azimuth_deg: ArrayLike) -> NDArray[np.float64]:
    """Azimuths as a one-dimensional array.

    Raises
    ------
    ArgumentError
        If there are none, or one is not finite.
    """
    azimuths = np.atleast_1d(np.asarray(azimuth_deg, dtype=np.float64))
    if azimuths.ndim != 1 or azimuths.size == 0 or not np.isfinite(azimuths).all():
        raise ArgumentError("azimuth_deg: give one or more finite numbers of degrees, in one row")
    return azimuths
