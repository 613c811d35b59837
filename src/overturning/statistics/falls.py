"""Fall directions: falls by azimuth, shares of cases that overturn, mean fall directions and axes.

In shares and means each plane counts once. Azimuths between those of a regular grid add no weight: the weight of an
azimuth is the share of all azimuths that are nearest to it (see `Model.fall_probability_and_direction_by_case`). The
parameter ``summed_dims`` names dimensions that are summed together with the direction, with equal weights.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
import xarray as xr

from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.model.plane_weights import (
    MAX_RESULTANT_LENGTH_OF_UNIFORM_PLANE_AZIMUTHS,
    PLANE_WEIGHT_EQUALITY_TOLERANCE,
)
from overturning.statistics.circular import MAX_RESULTANT_LENGTH_FROM_ROUNDING
from overturning.statistics.opposite_azimuths import overturned_share

MAX_IGNORED_UNKNOWN_TO_FALL_RESULTANT_RATIO: Final = 0.5
"""Largest length of the sum of doubled axes of unknown outcomes, as a share of that of the falls, that is ignored.

It turns the mean axis by at most 15°: half of arcsin 0.5.
"""


@dataclass(frozen=True)
class FallDirectionBlockSelectionRule:
    """Rule that selects, for each record, the blocks whose falls count in statistics of fall directions.

    Attributes
    ----------
    description_template : str
        Description of the selected blocks; ``{}`` stands for the model's word for a direction, such as "plane".
    max_share_of_directions_with_overturning : float
        Largest share of directions in which a selected block overturns; above 1 for no limit.
    uses_all_blocks_if_none_selected : bool
        True: count all blocks of a record for which the rule selects none. False: such a record does not count.
    """

    description_template: str
    max_share_of_directions_with_overturning: float
    uses_all_blocks_if_none_selected: bool = False

    def selected_block_mask(self, share_of_directions_overturning_block: xr.DataArray) -> xr.DataArray:
        """Return a mask of the blocks that the rule selects, from the share of azimuths at which each overturns."""
        if self.max_share_of_directions_with_overturning > 1.0:
            return xr.ones_like(share_of_directions_overturning_block, dtype=bool)
        share = share_of_directions_overturning_block.variable  # a sum of weights, with rounding errors
        near = (
            (share > 0)
            & (share <= self.max_share_of_directions_with_overturning + PLANE_WEIGHT_EQUALITY_TOLERANCE)
            & (share < 1.0 - PLANE_WEIGHT_EQUALITY_TOLERANCE)
        )
        if self.uses_all_blocks_if_none_selected:
            near = near | ~near.any([name for name in near.dims if name != "record"])
        return xr.DataArray(
            near, share_of_directions_overturning_block.coords, name=share_of_directions_overturning_block.name
        )


BLOCKS_FALLING_IN_AT_MOST_HALF_PLANES_RULE: Final = FallDirectionBlockSelectionRule(
    "in at most half of the {}s, or all blocks of a record without such", 0.5, True
)
"""Rule of planar models: blocks that overturn in at least one plane, but in at most half of the planes of a record."""

ALL_BLOCKS_RULE: Final = FallDirectionBlockSelectionRule("all blocks", 2.0)
"""Rule of the 3-D model, where a block that falls in every orientation still shows the direction of the motion."""

BLOCK_SELECTION_RULES_IN_REPORT: Final = (
    BLOCKS_FALLING_IN_AT_MOST_HALF_PLANES_RULE,
    FallDirectionBlockSelectionRule("in at most half of the {}s", 0.5),
    FallDirectionBlockSelectionRule("in at most a quarter of the {}s", 0.25),
    FallDirectionBlockSelectionRule("in some {}s, but not in all", 1.0),
    ALL_BLOCKS_RULE,
)
"""Rules for which a report lists the alignment, to show how it depends on this choice."""


def block_selection_rule_for_cube(cube: xr.Dataset) -> FallDirectionBlockSelectionRule:
    """Return the rule that selects blocks for direction statistics: in 2-D those falling in few planes, in 3-D all."""
    is_planar = default_model_of_same_kind_as_results_cube(cube).is_planar
    return BLOCKS_FALLING_IN_AT_MOST_HALF_PLANES_RULE if is_planar else ALL_BLOCKS_RULE


def share_of_directions_with_overturning(cube: xr.Dataset) -> xr.DataArray:
    """Compute, per record and block, the share of azimuths (3-D: orientations) at which the block overturns.

    See `overturned_share`, also for the weights of azimuths. The result is in memory.
    """
    direction = default_model_of_same_kind_as_results_cube(cube).direction_dimension_name
    return overturned_share(cube, *(str(name) for name in cube["overturned"].dims if name != direction))


def mask_of_blocks_for_direction_statistics(cube: xr.Dataset) -> xr.DataArray:
    """Return a mask of the blocks used in direction statistics: in 2-D those that few azimuths overturn, in 3-D all.

    The mask has the dimensions of ``overturned`` without the direction (a single True in 3-D). In 2-D, a block counts
    under a record if it overturns in at least one plane, but in at most half of the planes; more slender blocks fall in
    nearly every plane, to both sides, and hide the direction. If a record has no such block, all blocks count. Each
    plane counts once; planes with a missing outcome do not count.
    """
    rule = block_selection_rule_for_cube(cube)
    return (
        xr.DataArray(True)
        if rule is ALL_BLOCKS_RULE
        else rule.selected_block_mask(share_of_directions_with_overturning(cube))
    )


def mean_fall_probability_over_directions(cube: xr.Dataset, *, summed_dims: Sequence[str] = ()) -> xr.DataArray:
    """Compute, per record and block, the weighted mean fall probability over azimuths (3-D: orientations).

    Cells with an unknown outcome do not count.
    """
    model = default_model_of_same_kind_as_results_cube(cube)
    falls, dims = model.fall_probability_and_direction_by_case(cube), (model.direction_dimension_name, *summed_dims)
    fell, of_direction = falls["falls"].variable, falls["weight"].variable
    weight = of_direction.where(fell.notnull(), 0.0).sum(dims)
    share = (fell * of_direction).sum(dims) / weight.where(weight > 0)
    share.attrs |= {"long_name": f"share of {model.direction_dimension_name}s in which the block falls", "units": "1"}
    return xr.DataArray(share, falls.drop_dims(dims).coords)


def fall_weights_and_direction_components_by_case(cube: xr.Dataset) -> xr.Dataset:
    """Return, for each case, its weighted fall probability and weighted cosines and sines of the fall azimuth.

    Variables: weight × each variable of `Model.fall_probability_and_direction_by_case`. In 2-D also ``known``, the
    weight of a case with a known outcome (otherwise 0), and ``unknown_cosine`` and ``unknown_sine``, the weight of a
    case with an unknown outcome (otherwise 0) times the cosine and sine of twice its azimuth. A 3-D model moves along
    both components of the record in each orientation, so that missing orientations impose no axis.
    """
    falls = default_model_of_same_kind_as_results_cube(cube).fall_probability_and_direction_by_case(cube)
    weight = falls["weight"].variable
    weighted = {str(name): values.variable * weight for name, values in falls.data_vars.items() if name != "weight"}
    if "azimuth" in falls["falls"].dims:
        doubled = np.radians(2.0 * falls["azimuth"].variable.to_base_variable().astype(np.float64))
        known = falls["falls"].variable.notnull()
        unknown = weight * ~known
        weighted |= {
            "known": weight * known,
            "unknown_cosine": unknown * np.cos(doubled),
            "unknown_sine": unknown * np.sin(doubled),
        }
    return xr.Dataset(weighted, falls.coords)


def unknown_outcomes_may_bias_fall_axis(fall_vector_sums: xr.Dataset) -> xr.DataArray:
    """Return True where missing outcomes may bias the mean fall axis towards the azimuths with known outcomes.

    Let U be the sum of the doubled-angle vectors of the unknown outcomes, as if all of them were falls. The axis may be
    biased if there are falls and |U| exceeds two limits: `MAX_RESULTANT_LENGTH_OF_UNIFORM_PLANE_AZIMUTHS` times the
    weight of the known outcomes (then falls in all known cases would show an axis by themselves), and
    `MAX_IGNORED_UNKNOWN_TO_FALL_RESULTANT_RATIO` times the length of the vector sum of the falls. So a few unknown
    outcomes, or unknown outcomes at evenly spread azimuths, do not matter. The result is False for a 3-D model.

    Parameters
    ----------
    fall_vector_sums : Dataset
        Result of `sum_fall_vectors_over_directions`, or its sums over more dimensions.
    """
    length = xr.apply_ufunc(np.hypot, fall_vector_sums["axis_cosine"], fall_vector_sums["axis_sine"], dask="allowed")
    if "known" not in fall_vector_sums:
        return xr.zeros_like(length, dtype=bool)
    added = xr.apply_ufunc(
        np.hypot, fall_vector_sums["unknown_cosine"], fall_vector_sums["unknown_sine"], dask="allowed"
    )
    uneven = (
        added
        > MAX_RESULTANT_LENGTH_OF_UNIFORM_PLANE_AZIMUTHS * fall_vector_sums["known"] + PLANE_WEIGHT_EQUALITY_TOLERANCE
    )
    return uneven & (added > MAX_IGNORED_UNKNOWN_TO_FALL_RESULTANT_RATIO * length) & (fall_vector_sums["falls"] > 0)


def sum_fall_vectors_over_directions(
    cube: xr.Dataset, *, summed_dims: Sequence[str] = (), only_informative_blocks: bool = False
) -> xr.Dataset:
    """Sum, over all azimuths, the falls of each block and the cosines and sines of (doubled) fall azimuths.

    The variables are the sums of those of `fall_weights_and_direction_components_by_case`, also over ``summed_dims``;
    sums over more dimensions may follow before an angle is computed. With ``only_informative_blocks`` only blocks of
    the `mask_of_blocks_for_direction_statistics` are summed; the variable ``all_falls`` always counts the falls of all
    blocks.
    """
    weighted, dims = (
        fall_weights_and_direction_components_by_case(cube),
        (default_model_of_same_kind_as_results_cube(cube).direction_dimension_name, *summed_dims),
    )
    vectors = {str(name): values.variable for name, values in weighted.data_vars.items()}
    all_falls = vectors["falls"].sum(dims)
    if only_informative_blocks:
        mask = mask_of_blocks_for_direction_statistics(cube).variable
        vectors = {name: values.where(mask) for name, values in vectors.items()}
    sums = {name: values.sum(dims) for name, values in vectors.items()}
    return xr.Dataset({**sums, "all_falls": all_falls}, weighted.drop_dims(dims).coords)


def mean_fall_directions_and_axes_over_azimuths(
    cube: xr.Dataset, *, summed_dims: Sequence[str] = (), only_informative_blocks: bool = False
) -> xr.Dataset:
    """Compute the mean direction and the mean axis of falls over all azimuths (3-D: orientations).

    Axes are averaged with doubled angles (Mardia & Jupp 2000, eqs 2.2.2 to 2.2.4 and section 9.1). For
    ``only_informative_blocks`` see `sum_fall_vectors_over_directions`.

    Returns
    -------
    Dataset
        ``mean_direction`` (degrees, 0 to 360; missing without falls, or if they cancel), ``mean_axis`` (0 to 180;
        missing without falls, or if all planes overturn equally), ``direction_resultant`` and ``axis_resultant`` (mean
        resultant lengths, 0 to 1, the latter of doubled angles; missing without falls).
    """
    return mean_directions_and_axes_from_vector_sums(
        sum_fall_vectors_over_directions(cube, summed_dims=summed_dims, only_informative_blocks=only_informative_blocks)
    )


def mean_directions_and_axes_from_vector_sums(fall_vector_sums: xr.Dataset) -> xr.Dataset:
    """Compute mean direction and mean axis of falls from summed fall vectors.

    The sums are those of `sum_fall_vectors_over_directions`.
    """
    means = dict[str, xr.Variable]()
    falls = fall_vector_sums["falls"].variable
    total = falls.where(falls > 0)
    for kind, full, of in (("direction", 360.0, "fall directions"), ("axis", 180.0, "doubled fall axes")):
        cosine, sine = fall_vector_sums[f"{kind}_cosine"].variable, fall_vector_sums[f"{kind}_sine"].variable
        length = (xr.apply_ufunc(np.hypot, cosine, sine, dask="allowed") / total).clip(0, 1)
        turned = xr.apply_ufunc(np.arctan2, sine, cosine, dask="allowed")
        angle = (turned * (full / (2 * np.pi)) % full).where(length > MAX_RESULTANT_LENGTH_FROM_ROUNDING)
        angle.attrs = {"long_name": f"mean fall {kind}", "units": "degree"}
        length.attrs = {"long_name": f"mean resultant length of {of}", "units": "1"}
        means |= {f"mean_{kind}": angle, f"{kind}_resultant": length}
    return xr.Dataset(means, fall_vector_sums.coords)


def mean_cosine_and_sine_to_reference(
    fall_vector_sums: xr.Dataset, reference_azimuth_deg: xr.DataArray, *, axial: bool = True
) -> xr.Dataset:
    """Compute the mean cosine and sine of the angle from a reference azimuth to the falls; for axes, of twice it.

    Parameters
    ----------
    fall_vector_sums : Dataset
        Result of `sum_fall_vectors_over_directions`.
    reference_azimuth_deg : DataArray
        Reference azimuth of each record, degrees; NaN if there is none.
    axial : bool
        Treat falls and reference as axes.

    Returns
    -------
    Dataset
        ``cosine`` (1 if all falls are along the reference, 0 if they do not depend on it, −1 if they are
        perpendicular to a reference axis or opposite to a reference direction) and ``sine``; missing without falls or
        reference.
    """
    kind, times = ("axis", 2) if axial else ("direction", 1)
    cosine, sine = fall_vector_sums[f"{kind}_cosine"].variable, fall_vector_sums[f"{kind}_sine"].variable
    falls, turn = fall_vector_sums["falls"].variable, times * np.radians(reference_azimuth_deg.variable.astype(float))
    along, across, total = np.cos(turn), np.sin(turn), falls.where(falls > 0)
    means = {"cosine": (cosine * along + sine * across) / total, "sine": (sine * along - cosine * across) / total}
    return xr.Dataset(means, fall_vector_sums.coords.merge(reference_azimuth_deg.coords).coords)
