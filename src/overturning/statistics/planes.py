"""Planes and probabilities: the cells of a cube counted once per vertical plane.

φ and φ + 180° are one vertical plane and one run of the block, so shares, means and roses take each plane once. The
azimuths of one record are the same ground motion seen from many sides, not independent samples: nothing in this module
gives a p-value.
"""

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.dem.variables import INT8_MISSING
from overturning.errors import ResultError
from overturning.model.symmetry import PLANE_PERIOD, nearest_planes

FALLS = ("overturned", "probability_towards", "probability_away")
"""Variables of a cube that `fall_probability` takes."""


def plane_index(azimuth_deg: ArrayLike) -> NDArray[np.intp]:
    """Positions of one azimuth per plane, in the order of azimuth modulo 180°.

    Parameters
    ----------
    azimuth_deg : array_like, shape (n,)
        Azimuths, degrees.

    Returns
    -------
    ndarray of int
        Of φ and φ + 180° the one below 180° where both are there.
    """
    azimuth = np.asarray(azimuth_deg, dtype=np.float64)
    planes = np.unique(np.round(azimuth % PLANE_PERIOD, 6) % PLANE_PERIOD)
    return nearest_planes(azimuth, planes).cell if azimuth.size else np.zeros(0, np.intp)


def plane_weight(plane_azimuth_deg: ArrayLike) -> FloatArray:
    """Share of the half circle that each plane stands for: half the way to both neighbours (trapezoidal rule).

    A regular grid gets equal weights; azimuths added between its points share the weight of their neighbourhood, so that
    a study's extra azimuths do not count twice.

    Parameters
    ----------
    plane_azimuth_deg : array_like, shape (n,)
        Ascending azimuths of the planes, modulo 180°.

    Returns
    -------
    ndarray, shape (n,)
        Sums to 1.
    """
    plane = np.round(np.asarray(plane_azimuth_deg, dtype=np.float64) % 180.0, 6)
    if plane.size == 1:
        return np.ones(1)
    gap = np.diff(plane, append=plane[0] + 180.0)
    return (gap + np.roll(gap, 1)) / 360.0


def azimuth_weight(azimuth_deg: ArrayLike) -> FloatArray:
    """How much each azimuth of a whole circle counts: 1 on a regular grid; one added shares the part of its neighbours."""
    azimuth = np.asarray(azimuth_deg, dtype=np.float64)
    index = plane_index(azimuth)
    weight = plane_weight(azimuth[index]) * index.size
    return np.asarray(weight[nearest_planes(azimuth[index], azimuth).cell])


def fall_probability(cube: xr.Dataset, *, ensemble: bool = True) -> xr.Dataset:
    """Probability of falling towards φ and towards φ + 180°, cell by cell.

    Parameters
    ----------
    cube : Dataset
        The cube; ``overturned`` as stored or decoded.
    ensemble : bool
        Take the ensemble's probabilities where the cube has them, else (and elsewhere) the nominal flag as 0 or 1.

    Returns
    -------
    Dataset
        ``towards``, ``away`` (float32, dimensions of ``overturned``; missing where the outcome is), as lazy as the cube.

    Raises
    ------
    ResultError
        If the dataset has no variable ``overturned``.
    """
    if "overturned" not in cube:
        raise ResultError("the dataset has no variable 'overturned'; it is not a cube of this program")
    flag = cube["overturned"]
    known = flag.notnull() & (flag != INT8_MISSING)
    made = {}
    for sign, name, where in ((1, "towards", "azimuth"), (-1, "away", "azimuth + 180°")):
        chance = (flag == sign).where(known).astype("float32")
        if ensemble and "probability_towards" in cube:
            chance = cube[f"probability_{name}"].astype("float32").fillna(chance)
        chance.attrs = {"long_name": f"probability of falling towards the {where}", "units": "1"}
        made[name] = chance
    return xr.Dataset(made)


def by_plane(cube: xr.Dataset, *, ensemble: bool = True) -> xr.Dataset:
    """Fall probabilities with each plane once, and the weight of each plane.

    Returns
    -------
    Dataset
        ``towards``, ``away``, their sum ``falls``, and ``weight(azimuth)`` (sums to 1); ``azimuth`` holds one azimuth per
        plane.
    """
    index = plane_index(cube["azimuth"].values)
    result = fall_probability(cube, ensemble=ensemble).isel(azimuth=index)
    weight = plane_weight(cube["azimuth"].values[index])
    falls = (result["towards"] + result["away"]).assign_attrs(long_name="probability of falling", units="1")
    return result.assign(falls=falls, weight=xr.DataArray(weight, dims="azimuth"))
