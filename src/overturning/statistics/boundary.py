"""Overturning boundary: the B/H at which the probability of falling crosses one half, for each azimuth.

Overturning is not monotonic in B/H: a block may stand between two that fall. The *boundary* is the last crossing, above
which no block falls.
"""

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.model.plane_weights import (
    distinct_plane_indices,
    plane_azimuth_period_deg,
    plane_weights_by_azimuth_spacing,
)
from overturning.model.planes import fall_probabilities_towards_and_away
from overturning.statistics.circular import mean_angle_deg_and_mean_resultant_length

BOUNDARY_FALL_PROBABILITY = 0.5


def boundary_b_over_h_and_whether_stoutest_falls(
    fall_probability_by_b_over_h: ArrayLike, ascending_b_over_h: ArrayLike
) -> tuple[float, bool]:
    """Return the largest B/H where the fall probability crosses 1/2, and whether the block of largest known B/H falls.

    Parameters
    ----------
    fall_probability_by_b_over_h, ascending_b_over_h : array_like, shape (n,)
        Probability of falling, NaN where unknown, and the ascending B/H. Interpolation is linear between known values.

    Returns
    -------
    (float, bool)
        B/H of the last crossing, NaN if there is none; and True if the block of largest known B/H has a fall
        probability of at least 1/2.
    """
    line, slenderness = (
        np.asarray(fall_probability_by_b_over_h, dtype=np.float64),
        np.asarray(ascending_b_over_h, dtype=np.float64),
    )
    known = np.isfinite(line)
    p, x = line[known] - BOUNDARY_FALL_PROBABILITY, slenderness[known]
    places = np.flatnonzero((p[:-1] >= 0) != (p[1:] >= 0))
    falls = bool(p.size and p[-1] >= 0)
    if not places.size:
        return np.nan, falls
    at = places[-1]
    return float(x[at] + (x[at + 1] - x[at]) * p[at] / (p[at] - p[at + 1])), falls


def overturning_boundary_b_over_h_by_azimuth(cube: xr.Dataset) -> xr.Dataset:
    """Compute, by azimuth, the largest B/H at which the fall probability crosses 1/2, and its range over the ensemble.

    Parameters
    ----------
    cube : Dataset
        Results of a study. The two scrambled Sobol sequences of the ensemble give the range, from the variables
        ``scramble_difference_towards`` and ``scramble_difference_away``.

    Returns
    -------
    Dataset
        Computed lazily if the cube is lazy. ``boundary``: B/H at the crossing, missing without a crossing or if
        ``falls_beyond``. ``boundary_low`` and ``boundary_high``: smallest and largest of ``boundary`` and of the
        boundaries of the two sequences (equal to ``boundary`` without an ensemble). If a sequence has the block fall
        at the largest known B/H, this B/H stands for its boundary; if the block never falls, the smallest known B/H
        does. ``largest_known``: largest B/H with a known outcome. ``falls_beyond``: True if the block falls at
        ``largest_known``, so that the boundary lies above it. ``stands_throughout``: True if an outcome is known and
        the block never falls.
    """
    if "b_over_h" not in cube.dims:
        raise ArgumentError("cube: no dimension b_over_h; the boundary is computed along it")

    def boundary_and_whether_stoutest_falls(fall_probability_by_case: xr.Variable) -> tuple[xr.Variable, xr.Variable]:
        lazy = (
            fall_probability_by_case.chunk({"b_over_h": -1})
            if fall_probability_by_case.chunks is not None
            else fall_probability_by_case
        )
        found: tuple[xr.Variable, xr.Variable] = xr.apply_ufunc(
            boundary_b_over_h_and_whether_stoutest_falls, lazy, slenderness,
            input_core_dims=[["b_over_h"]] * 2,
            output_core_dims=[[], []], vectorize=True, dask="parallelized", output_dtypes=[np.float64, np.bool_],
        )  # fmt: skip
        return found

    # Variables have no coordinates, which need not be compared at each operation.
    p, slenderness = fall_probabilities_towards_and_away(cube), cube["b_over_h"].variable
    falls = p["towards"].variable + p["away"].variable
    middle, beyond = boundary_and_whether_stoutest_falls(falls)
    known = slenderness.to_base_variable().where(falls.notnull())
    largest, smallest = known.max("b_over_h"), known.min("b_over_h")
    low = high = middle
    if "scramble_difference_towards" in cube:
        towards, away = (cube[f"scramble_difference_{side}"].variable for side in ("towards", "away"))
        gap = (towards + away).fillna(0.0)
        for half_falls in (falls + gap / 2, falls - gap / 2):
            crossing, still_falls = boundary_and_whether_stoutest_falls(half_falls)
            end = crossing.where(~still_falls, largest).fillna(smallest)
            low = xr.apply_ufunc(np.minimum, low, end, dask="allowed")
            high = xr.apply_ufunc(np.maximum, high, end, dask="allowed")
    named = {
        "boundary": (middle, "overturning boundary"),
        "boundary_low": (low, "overturning boundary, lower of two scrambles"),
        "boundary_high": (high, "overturning boundary, upper of two scrambles"),
    }
    made = {name: one.where(~beyond) for name, (one, _) in named.items()}
    for name, (_, text) in named.items():
        made[name].attrs |= {"long_name": text, "units": "1"}
    stands = (falls.fillna(0.0) < BOUNDARY_FALL_PROBABILITY).all("b_over_h") & falls.notnull().any("b_over_h")
    made |= {"falls_beyond": beyond, "largest_known": largest, "stands_throughout": stands}
    return xr.Dataset(made, p.drop_dims("b_over_h").coords)


def easiest_axis_and_extreme_overturning_boundaries(
    boundary_dataset_by_azimuth: xr.Dataset, b_over_h_values_of_cube: ArrayLike
) -> xr.Dataset:
    """Compute the axis along which a block overturns most easily, and the extremes of the boundary B/H over azimuths.

    Parameters
    ----------
    boundary_dataset_by_azimuth : Dataset
        From `overturning_boundary_b_over_h_by_azimuth`.
    b_over_h_values_of_cube : array_like
        B/H of the cube. If a block never falls at an azimuth, the smallest of them stands for the boundary, which lies
        below it. If a block falls at the largest B/H with a known outcome, this B/H stands for the boundary, which
        lies above it.

    Returns
    -------
    Dataset
        ``easiest_axis`` (degrees, 0 to 180; the mean axis of planes that tie; missing if all planes tie or no block
        falls), ``highest_boundary``, ``lowest_boundary`` (B/H), ``ratio``: highest over lowest
        boundary, and ``bounded``: False if a boundary lies outside the known B/H, so that the ratio is only a lower
        bound.
    """
    grid = np.asarray(b_over_h_values_of_cube, dtype=np.float64)
    period = plane_azimuth_period_deg(boundary_dataset_by_azimuth)
    index = distinct_plane_indices(boundary_dataset_by_azimuth["azimuth"].values, period)
    planes = (
        boundary_dataset_by_azimuth[["boundary", "falls_beyond", "largest_known", "stands_throughout"]]
        .isel(azimuth=index)
        .compute()
    )
    weight = plane_weights_by_azimuth_spacing(planes["azimuth"].values, period)
    edge = planes["boundary"].where(~planes["falls_beyond"], planes["largest_known"])
    edge = edge.where(~planes["stands_throughout"], grid.min())
    highest, lowest = edge.max("azimuth"), edge.min("azimuth")

    def mean_axis_of_largest_boundary_azimuths(
        boundary_b_over_h_by_azimuth: FloatArray, never_falls_mask_by_azimuth: NDArray[np.bool_]
    ) -> float:
        if (never_falls_mask_by_azimuth | np.isnan(boundary_b_over_h_by_azimuth)).all():
            return np.nan
        ties = np.abs(boundary_b_over_h_by_azimuth - np.nanmax(boundary_b_over_h_by_azimuth)) < 1e-9
        return mean_angle_deg_and_mean_resultant_length(planes["azimuth"].values[ties], weight[ties], axial=True)[0]

    stands = planes["stands_throughout"]
    easiest = xr.apply_ufunc(
        mean_axis_of_largest_boundary_azimuths, edge, stands, input_core_dims=[["azimuth"], ["azimuth"]], vectorize=True
    )
    never = (stands | edge.isnull()).all("azimuth")
    return xr.Dataset(
        {
            "easiest_axis": easiest.assign_attrs(long_name="axis of easiest overturning", units="degree"),
            "highest_boundary": highest.where(~never),
            "lowest_boundary": lowest.where(~never),
            "ratio": (highest / lowest).where(~never),
            "bounded": ~(planes["falls_beyond"] | stands).any("azimuth"),
        }
    )
