"""Outcomes at opposite azimuths, and shares of cases that overturn."""

import math

import numpy as np
import xarray as xr

from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.model.plane_weights import (
    PLANE_WEIGHT_EQUALITY_TOLERANCE,
    plane_azimuth_period_deg,
    plane_weights_by_azimuth_spacing,
)
from overturning.model.planes import VARIABLE_NAMES_READ_FOR_FALL_PROBABILITY, fall_probabilities_towards_and_away
from overturning.model.symmetry import PLANE_SYMMETRY_PERIOD_DEG, nearest_simulated_planes
from overturning.model.variables import PLANAR_OUTCOME_VARIABLES, PLANE_ENSEMBLE_VARIABLES, mask_of_known_outcomes


def cube_with_opposite_azimuths(cube: xr.Dataset) -> xr.Dataset:
    """Return 2-D results with the azimuth φ + 180° of each azimuth φ added, as mirror image of the plane φ.

    Azimuths ascend in the result. Motions along φ and φ + 180° are one plane with one outcome: if the cube has only
    one of the two azimuths, the other is added as its mirror image; if it has both, they stay unchanged. In a scene
    without mirror symmetry the two azimuths are different cases; an opposite azimuth that was not simulated is added
    with missing values. Computed lazily if the cube is lazy.
    """
    azimuth = cube["azimuth"].to_numpy()
    opposite = np.round((azimuth.astype(np.float64) + 180.0) % 360.0, 10).astype(azimuth.dtype)
    everywhere = np.union1d(azimuth, opposite)
    if np.array_equal(everywhere, azimuth):
        return cube
    sources = nearest_simulated_planes(azimuth, everywhere, plane_azimuth_period_deg(cube))
    if plane_azimuth_period_deg(cube) != PLANE_SYMMETRY_PERIOD_DEG:
        return cube.reindex(azimuth=everywhere[np.isin(everywhere, azimuth) | ~sources.is_within_simulated_directions])
    turned = cube.isel(azimuth=sources.simulated_direction_index).assign_coords(
        azimuth=("azimuth", everywhere, cube["azimuth"].attrs)
    )
    behind = xr.Variable("azimuth", sources.is_mirrored)  # variables have no coordinates, which need not be compared
    changed = {}
    for variable in (*PLANAR_OUTCOME_VARIABLES, *PLANE_ENSEMBLE_VARIABLES):
        if variable.name in cube and (variable.is_odd_under_mirroring or variable.mirror_counterpart_name):
            values, seen = (
                turned[name].variable for name in (variable.name, variable.mirror_counterpart_name or variable.name)
            )
            changed[variable.name] = xr.where(
                behind, -seen if variable.is_odd_under_mirroring else seen, values
            ).transpose(*values.dims)
            changed[variable.name].attrs = values.attrs
    return turned.assign(changed)


def fall_count_or_probability_by_fall_azimuth(cube: xr.Dataset, *, use_ensemble: bool = False) -> xr.DataArray:
    """Return, by azimuth and block, the number (or probability) of falls towards the azimuth; NaN if unknown.

    Computed lazily if the cube is lazy.

    A block with the flag −1 at the azimuth φ falls towards φ + 180°, and is counted there. So each fall counts
    exactly once, whether the cube has one or both azimuths of its plane. For a scene without mirror symmetry, the
    number at an azimuth is the sum over two cases: motion along this azimuth and along the opposite one.

    Parameters
    ----------
    cube : Dataset
        With ``overturned`` and ``azimuth``.
    use_ensemble : bool
        Use probabilities instead of flags (see `fall_probabilities_towards_and_away`).

    Returns
    -------
    DataArray
        Azimuths as from `cube_with_opposite_azimuths`; for a scene without mirror symmetry including all opposites.
    """
    names = VARIABLE_NAMES_READ_FOR_FALL_PROBABILITY if use_ensemble else ("overturned",)
    used = [name for name in names if name in cube]
    p = fall_probabilities_towards_and_away(cube_with_opposite_azimuths(cube[used]), use_ensemble=use_ensemble)
    falls, azimuth = p["towards"], p["azimuth"]
    if plane_azimuth_period_deg(cube) != PLANE_SYMMETRY_PERIOD_DEG:
        away = p["away"].assign_coords(azimuth=((azimuth + 180) % 360).astype(azimuth.dtype)).sortby("azimuth")
        both = xr.concat(xr.align(falls, away, join="outer"), "side")
        falls = both.sum("side", min_count=1).transpose(*falls.dims)
    return falls.assign_attrs(long_name="falls towards the azimuth", units="1")


def overturning_indicator(cube: xr.Dataset) -> xr.DataArray:
    """Return, for each simulated case, 1 if the block falls to any side, 0 if it stands, NaN if this is unknown."""
    overturned = cube["overturned"]
    flag = overturned.variable
    falls = xr.where(mask_of_known_outcomes(flag), (flag != 0).astype("float32"), np.nan)
    falls.attrs |= {"long_name": "block overturns to either side", "units": "1"}
    return xr.DataArray(falls, overturned.coords, name="overturned")


def overturned_share(cube: xr.Dataset, *kept_dims: str) -> xr.DataArray:
    """Compute the share of cases with a known outcome in which the block overturns; NaN without such cases.

    Dimensions in ``kept_dims`` are kept, all others are averaged over. Each plane counts once, also if the cube has
    the opposite azimuths of some planes only. The weight of a plane is the share of all azimuths that are
    nearest to it (`plane_weights_by_azimuth_spacing`); on a regular grid all planes count the same.
    """
    falls = overturning_indicator(cube)
    dims = [name for name in falls.dims if name not in kept_dims]
    if "azimuth" not in dims:
        return falls.mean(dims).compute()
    planes = default_model_of_same_kind_as_results_cube(cube).distinct_direction_indices(cube)
    weight = plane_weights_by_azimuth_spacing(cube["azimuth"].to_numpy()[planes], plane_azimuth_period_deg(cube))
    once = falls.isel(azimuth=planes)
    if np.ptp(weight) <= PLANE_WEIGHT_EQUALITY_TOLERANCE:
        return once.mean(dims).compute()
    weights = xr.DataArray(weight, dims="azimuth")
    known = weights.where(once.notnull(), 0.0).sum(dims)
    return ((once * weights).sum(dims) / known.where(known > 0)).compute()


def overturned_shares_by_record(cube: xr.Dataset, *kept_dims: str) -> xr.DataArray:
    """Compute, for each record, the share of cases (with a known outcome) in which the block overturns.

    Dimensions in ``kept_dims`` are kept as well; all others are averaged over, see `overturned_share`.
    """
    return overturned_share(cube, "record", *kept_dims).transpose(..., "record").astype("float64")


def overturned_shares_near_and_off_fault_normal(cube: xr.Dataset) -> tuple[float, float]:
    """Return the shares of cases that overturn at azimuths within 45° of the fault normal, and at all others.

    Unknown outcomes do not count. Both shares are NaN without azimuths of the motion (3-D) or without a known fault
    normal.
    """
    if "azimuth" not in cube.dims or not bool(cube["fault_normal"].notnull().any()):
        return math.nan, math.nan
    flags = cube["overturned"].where(cube["fault_normal"].notnull()).compute()
    near = abs((cube["azimuth"] - cube["fault_normal"] + 90.0) % 180.0 - 90.0) < 45.0
    within, beyond = (
        float(overturned_share(cube.assign(overturned=flags.where(near == side)))) for side in (True, False)
    )
    return within, beyond


def count_differing_and_all_neighbour_pairs(cube: xr.Dataset, dimension_name: str) -> tuple[int, int]:
    """Count pairs of neighbouring cases along a dimension with different outcomes, and all pairs with known outcomes.

    Outcomes are: stands, falls to +1, falls to −1. Both numbers are of pairs with two known outcomes. For azimuths
    round the full circle the last and the first are neighbours.
    """
    flags, at = cube["overturned"].compute(), cube[dimension_name].to_numpy().astype(np.float64)
    gap = float(np.diff(at).max(initial=0.0))
    round_about = dimension_name == "azimuth" and at[0] + 360.0 - at[-1] <= gap * (1 + 1e-9)
    beyond = flags.roll({dimension_name: -1}, roll_coords=False) if round_about else flags.shift({dimension_name: -1})
    known = mask_of_known_outcomes(flags) & mask_of_known_outcomes(beyond)
    return int(((flags != beyond) & known).sum()), int(known.sum())
