"""Statistics of the 3-D model only: agreement with the 2-D model of its faces, and turns about the vertical."""

from typing import Final, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.motion.direction import angle_between_azimuths
from overturning.statistics.by_record import apply_to_record_batches_and_join, iterate_results_by_record
from overturning.statistics.circular import wrap_axis_difference_to_90_deg

_NUMERATOR_AND_DENOMINATOR_BY_SHARE: Final = {
    "flag": ("right", "cases"), "flag_beside": ("right_beside", "beside"), "only_space": ("only_space", "cases"),
    "only_plane": ("only_plane", "cases"), "face": ("over_edge", "both"), "axis": ("axes_apart", "both"),
}  # fmt: skip
"""Counts that are numerator and denominator of each variable of `shares_of_agreeing_2d_and_3d_outcomes`."""


def count_agreeing_and_differing_2d_3d_outcomes(cube: xr.Dataset) -> xr.Dataset:
    """Count, by record and B/H, cases in which 2-D simulation in the planes of the faces agrees with 3-D simulation.

    Cases in which the two models differ have counts of their own; ``axes_apart`` is the sum of the angles between the
    fall axes of the two models, degrees. Nominal outcomes are used, and the cube is read in batches of records. The
    result is the input of `shares_of_agreeing_2d_and_3d_outcomes`.
    """
    variables = ("overturned", "fall_azimuth", "plane_overturned", "plane_fall_azimuth")
    return apply_to_record_batches_and_join(_count_2d_and_3d_agreements_of_batch, cube, variables)


def _count_2d_and_3d_agreements_of_batch(cube: xr.Dataset) -> xr.Dataset:
    space, plane = cube["overturned"], cube["plane_overturned"]
    known = space.notnull() & plane.notnull()
    both = (space == 1) & (plane == 1)
    slenderer, stouter = (space.shift(b_over_h=by) for by in (1, -1))
    beside = known & (((space != slenderer) & slenderer.notnull()) | ((space != stouter) & stouter.notnull()))
    apart = (cube["fall_azimuth"].astype("float64") - cube["plane_fall_azimuth"].astype("float64")).where(both)
    found = xr.Dataset({
        "cases": known,
        "right": known & (space == plane),
        "beside": beside,
        "right_beside": beside & (space == plane),
        "only_space": (space == 1) & (plane == 0),
        "only_plane": (space == 0) & (plane == 1),
        "both": both,
        "over_edge": angle_between_azimuths(apart, 0.0) <= 45.0,
        "axes_apart": np.abs(xr.apply_ufunc(wrap_axis_difference_to_90_deg, apart)),
    })  # fmt: skip
    return found.sum([name for name in space.dims if name not in ("record", "b_over_h")])


def shares_of_agreeing_2d_and_3d_outcomes(agreement_counts: xr.Dataset, *kept_dims: str) -> xr.Dataset:
    """Compute shares of cases in which 2-D simulation in the planes of the faces agrees with 3-D simulation.

    The counts of `count_agreeing_and_differing_2d_3d_outcomes` are summed over all dimensions but those of
    ``kept_dims``.

    Returns
    -------
    Dataset
        ``cases``: number of cases with an outcome in both models. Shares of these cases, missing if there are none:
        ``flag``, the 2-D model predicts correctly whether the stone falls; ``flag_beside``, the same for cases whose
        neighbour in B/H has a different outcome; ``only_space`` and ``only_plane``, the stone falls in the 3-D model
        only, or in the 2-D model only. For cases that fall in both models: ``face``, the share whose 3-D fall is within
        45° of the 2-D fall (over the same edge), and ``axis``, the mean angle between the two fall axes, degrees (45°
        for random axes).
    """
    total = agreement_counts.sum([name for name in agreement_counts.dims if name not in kept_dims])
    shares = {
        name: total[part] / total[of].where(total[of] > 0)
        for name, (part, of) in _NUMERATOR_AND_DENOMINATOR_BY_SHARE.items()
    }
    return xr.Dataset({"cases": total["cases"], **shares})


class AbsTwistSummaryOfMovedStandingStones(NamedTuple):
    """Absolute rotation about the vertical where a stone moves but stands: number of cases, quantiles in degrees."""

    stone_count: int
    median_deg: float
    upper_quantile_deg: float
    largest_deg: float


def moved_stone_twist_deg_by_b_over_h_and_friction(cube: xr.Dataset) -> dict[tuple[float, float], NDArray[np.float32]]:
    """Return, by (B/H, friction), the absolute rotations about the vertical of stones that moved without falling.

    The rotations are in degrees, shape (stones,).

    The cube is read one record at a time. All rotations are kept in memory for the quantiles (four bytes each).
    """
    shapes = [(ratio, friction) for ratio in cube["b_over_h"].to_numpy() for friction in cube["friction"].to_numpy()]
    # Allocate the largest possible size; pages that are never written take no memory.
    kept = np.empty((len(shapes), cube["residual_twist"].size // len(shapes)), np.float32)
    count = np.zeros(len(shapes), np.int64)
    for one in iterate_results_by_record(cube, ("overturned", "status", "residual_twist")):
        turned = one["residual_twist"].where((one["status"] == 0) & (one["overturned"] == 0))
        rows = np.abs(turned.transpose("b_over_h", "friction", ...).to_numpy()).reshape(len(shapes), -1)
        for place, row in enumerate(rows):
            known = row[np.isfinite(row)]
            kept[place, count[place] : count[place] + known.size] = known
            count[place] += known.size
    return {shape: kept[place, : count[place]] for place, shape in enumerate(shapes)}


def summarise_twists_sorting_in_place(
    absolute_twists_deg: NDArray[np.float32], probability_of_upper_quantile: float = 0.9
) -> AbsTwistSummaryOfMovedStandingStones:
    """Compute number, median, upper quantile and maximum of absolute twists, degrees; the array gets partly sorted."""
    if absolute_twists_deg.size == 0:
        return AbsTwistSummaryOfMovedStandingStones(0, *(float("nan"),) * 3)
    return AbsTwistSummaryOfMovedStandingStones(
        absolute_twists_deg.size,
        *(
            _rotation_quantile_deg_by_sorting_in_place(absolute_twists_deg, share)
            for share in (0.5, probability_of_upper_quantile, 1.0)
        ),
    )


def _rotation_quantile_deg_by_sorting_in_place(
    absolute_twists_deg: NDArray[np.float32], quantile_probability: float
) -> float:
    """Compute a quantile of rotations (degrees) at a share from 0 to 1; partly sort the array in place.

    The quantile is interpolated linearly, in double precision.
    """
    place = quantile_probability * (absolute_twists_deg.size - 1)
    first = int(place)
    ends = [first, min(first + 1, absolute_twists_deg.size - 1)]
    absolute_twists_deg.partition(ends)
    return float(np.quantile(absolute_twists_deg[ends].astype(np.float64), place - first))
