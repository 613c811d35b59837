"""Weights of the vertical planes in which blocks rock, by the spacing of the azimuths."""

from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.model.symmetry import (
    PLANE_SYMMETRY_PERIOD_DEG,
    nearest_simulated_directions,
)

if TYPE_CHECKING:
    import xarray as xr


def plane_azimuth_period_deg(cube: "xr.Dataset | xr.DataArray") -> float:
    """Return the azimuth period of 2-D results: 180° if outcomes at φ + 180° mirror those at φ, otherwise 360°."""
    return float(cube["azimuth"].attrs.get("period", PLANE_SYMMETRY_PERIOD_DEG))


def distinct_plane_indices(
    plane_azimuth_deg: ArrayLike, symmetry_period_deg: float = PLANE_SYMMETRY_PERIOD_DEG
) -> NDArray[np.intp]:
    """Return the index of one azimuth in each distinct vertical plane, sorted by azimuth modulo the period.

    Parameters
    ----------
    plane_azimuth_deg : array_like, shape (n,)
        Azimuths of the planes, degrees.
    symmetry_period_deg : float
        Period of the azimuth, degrees (see `plane_azimuth_period_deg`).

    Returns
    -------
    ndarray of int
        Indices in `plane_azimuth_deg`; of two azimuths φ and φ + 180° of one plane, that of the one below 180°.
    """
    azimuth = np.asarray(plane_azimuth_deg, dtype=np.float64)
    planes = np.unique(np.round(azimuth % symmetry_period_deg, 6) % symmetry_period_deg)
    if not azimuth.size:
        return np.zeros(0, np.intp)
    return nearest_simulated_directions(azimuth, planes, symmetry_period_deg).simulated_direction_index


def mask_of_azimuths_before_gap_and_grid_step(
    plane_azimuth_deg: ArrayLike, symmetry_period_deg: float = PLANE_SYMMETRY_PERIOD_DEG
) -> tuple[NDArray[np.bool_], float]:
    """Return a mask of the azimuths just before a gap in the grid of azimuths, and the step of the grid, degrees.

    Parameters
    ----------
    plane_azimuth_deg : array_like, shape (n,)
        Ascending azimuths modulo the period, each once, degrees.
    symmetry_period_deg : float
        Period of the azimuth, degrees.

    Returns
    -------
    not_computed : ndarray of bool, shape (n,)
        True where the distance to the next azimuth is at least twice the distances before and after it, and twice
        the step: at least one azimuth of a regular grid is missing. After the last azimuth follows the first.
    step : float
        Median of the distances other than gaps, weighted by their lengths, degrees: the step of a regular grid, even
        if azimuths were added between its points.
    """
    azimuth = np.round(np.asarray(plane_azimuth_deg, dtype=np.float64), 6)
    gap = np.diff(azimuth, append=azimuth[:1] + symmetry_period_deg)
    wide: NDArray[np.bool_] = gap >= 2.0 * np.maximum(np.roll(gap, 1), np.roll(gap, -1)) * (1.0 - 1e-9)
    computed = np.sort(gap[~wide])
    step = float(computed[np.searchsorted(np.cumsum(computed), 0.5 * computed.sum())])
    return wide & (gap >= 2.0 * step * (1.0 - 1e-9)), step


def plane_weights_by_azimuth_spacing(
    plane_azimuth_deg: ArrayLike,
    symmetry_period_deg: float = PLANE_SYMMETRY_PERIOD_DEG,
    *,
    divide_uncomputed_gaps_between_neighbours: bool = False,
) -> FloatArray:
    """Return the weight of each vertical plane: the share of all azimuths that are nearest to it (sum 1).

    A regular grid gets equal weights; azimuths added between its points share the weight of the azimuths beside them,
    so that a study's extra azimuths do not count twice. The planes next to a gap
    (`mask_of_azimuths_before_gap_and_grid_step`) represent only half a grid step on its side, since the outcome in
    the gap is unknown.

    Parameters
    ----------
    plane_azimuth_deg : array_like, shape (n,)
        Ascending azimuths of the planes, modulo the period.
    symmetry_period_deg : float
        Period of the azimuth, degrees; 360 for shares of the whole circle.
    divide_uncomputed_gaps_between_neighbours : bool
        Let each of the two planes next to a gap represent half of the gap instead.

    Returns
    -------
    ndarray, shape (n,)
        Weights that sum to 1.
    """
    plane = np.round(np.asarray(plane_azimuth_deg, dtype=np.float64) % symmetry_period_deg, 6)
    gap = np.diff(plane, append=plane[:1] + symmetry_period_deg)
    represented = symmetry_period_deg
    if not divide_uncomputed_gaps_between_neighbours:
        not_computed, step = mask_of_azimuths_before_gap_and_grid_step(plane, symmetry_period_deg)
        represented -= float((gap[not_computed] - step).sum())
        gap[not_computed] = step
    return (gap + np.roll(gap, 1)) / (2.0 * represented)


MAX_RESULTANT_LENGTH_OF_UNIFORM_PLANE_AZIMUTHS: Final = 0.05
"""Largest mean resultant length of doubled plane azimuths with which planes count as spread over the half circle."""


PLANE_WEIGHT_EQUALITY_TOLERANCE: Final = 1e-9
"""Largest difference between weights of planes that are equal but for rounding."""


def plane_azimuths_alone_impose_fall_axis(plane_azimuth_deg: ArrayLike) -> bool:
    """Return True if the choice of azimuths to simulate already gives falls a mean axis, whatever the motion.

    This is so with a single plane, and with planes spread unequally over the half circle. The test assumes one fall in
    each plane, weighted by `plane_weights_by_azimuth_spacing`: the resultant of the doubled axis angles must exceed
    `MAX_RESULTANT_LENGTH_OF_UNIFORM_PLANE_AZIMUTHS`. One missing plane of a fine grid does not suffice. The azimuths
    φ and φ + 180° are one plane, also for scenes without mirror symmetry: they have one axis.

    Parameters
    ----------
    plane_azimuth_deg : array_like, shape (n,)
        Azimuths of the motion, degrees, in any order.
    """
    azimuth = np.asarray(plane_azimuth_deg, dtype=np.float64)
    plane = azimuth[distinct_plane_indices(azimuth)] % PLANE_SYMMETRY_PERIOD_DEG
    if plane.size <= 1:
        return True
    doubled = np.radians(2.0 * plane)
    share = plane_weights_by_azimuth_spacing(plane)
    resultant = float(np.hypot(share @ np.cos(doubled), share @ np.sin(doubled)))
    return resultant > MAX_RESULTANT_LENGTH_OF_UNIFORM_PLANE_AZIMUTHS


def azimuths_in_results_bias_mean_fall_axis(cube: "xr.Dataset") -> bool:
    """Return True if the choice of azimuths in 2-D results already gives falls a mean axis; False for 3-D.

    See `plane_azimuths_alone_impose_fall_axis`.
    """
    return "azimuth" in cube.dims and plane_azimuths_alone_impose_fall_axis(cube["azimuth"].to_numpy())


def case_weights_by_azimuth_spacing(
    plane_azimuth_deg: ArrayLike, symmetry_period_deg: float = PLANE_SYMMETRY_PERIOD_DEG
) -> FloatArray:
    """Return the weight of the cases at each azimuth in shares over all cases; the mean weight is 1.

    Azimuths φ and φ + 180° of one plane share the weight of this plane (`plane_weights_by_azimuth_spacing`).
    All weights of a regular grid round the half or the full circle are exactly 1.
    """
    azimuth = np.asarray(plane_azimuth_deg, dtype=np.float64)
    index = distinct_plane_indices(azimuth, symmetry_period_deg)
    plane = nearest_simulated_directions(azimuth[index], azimuth, symmetry_period_deg).simulated_direction_index
    plane_weights = plane_weights_by_azimuth_spacing(azimuth[index], symmetry_period_deg)
    weight = (plane_weights / np.bincount(plane, minlength=index.size))[plane]
    return np.ones(azimuth.size) if np.ptp(weight) <= PLANE_WEIGHT_EQUALITY_TOLERANCE else weight * azimuth.size
