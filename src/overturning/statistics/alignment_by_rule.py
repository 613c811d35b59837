"""Alignment of falls with the fault normal, for each rule that selects blocks."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import xarray as xr

from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.model.plane_weights import azimuths_in_results_bias_mean_fall_axis
from overturning.statistics.bootstrap import MeanOverEarthquakes, mean_over_earthquakes
from overturning.statistics.by_record import apply_to_record_batches_and_join, record_masks_by_group
from overturning.statistics.falls import (
    BLOCK_SELECTION_RULES_IN_REPORT,
    FallDirectionBlockSelectionRule,
    fall_weights_and_direction_components_by_case,
    mean_cosine_and_sine_to_reference,
    share_of_directions_with_overturning,
    unknown_outcomes_may_bias_fall_axis,
)


@dataclass(frozen=True)
class FaultNormalAlignmentOfSelectedBlocks:
    """Mean alignment of fall directions with the fault normal, over the blocks that a selection rule accepts.

    Attributes
    ----------
    rule : FallDirectionBlockSelectionRule
        Rule that selects the blocks.
    records_with_falls_and_fault_normal : int
        Number of records with falls of these blocks and a known fault normal.
    mean_cos_of_doubled_angle : MeanOverEarthquakes
        Mean of cos 2Δ (Δ: angle from the fault normal to a fall) over the falls of a record, then over the records of
        an earthquake, then over earthquakes; with its 95 % interval.
    mean_resultant_length_of_doubled_fall_axes : float
        Largest mean of cos 2Δ that any reference axes could give: mean, over records and then earthquakes, of the mean
        resultant length of the doubled fall axes.
    """

    rule: FallDirectionBlockSelectionRule
    records_with_falls_and_fault_normal: int
    mean_cos_of_doubled_angle: MeanOverEarthquakes
    mean_resultant_length_of_doubled_fall_axes: float


def fault_normal_alignments_by_record_group(
    cube: xr.Dataset,
    block_selection_rules: Sequence[FallDirectionBlockSelectionRule] = BLOCK_SELECTION_RULES_IN_REPORT,
    *,
    bootstrap_sample_count: int = 10_000,
) -> dict[str, list[FaultNormalAlignmentOfSelectedBlocks]]:
    """Compute the alignment of falls with the fault normal, for each group of records and each block selection rule.

    The result has a list for each name of a group, with one entry for each rule, in the order of
    `block_selection_rules`. Alignments are NaN if the choice of simulated planes alone gives the falls a mean axis
    (`plane_azimuths_alone_impose_fall_axis`). Records whose unknown outcomes may do so are left out
    (`unknown_outcomes_may_bias_fall_axis`).

    The cube is read in parts. Each rule uses the same bootstrap samples of earthquakes as `summarise_fall_axes`, whose
    alignment is that of the rule `block_selection_rule_for_cube(cube)`.

    Parameters
    ----------
    cube : Dataset
        Cube with the coordinates ``fault_normal(record)``, degrees, and ``event(record)``.
    block_selection_rules : sequence of FallDirectionBlockSelectionRule
        Rules to compare.
    bootstrap_sample_count : int
        Bootstrap samples.
    """
    sums = apply_to_record_batches_and_join(
        partial(_count_falls_and_sum_fall_axes_by_selection_rule, block_selection_rules),
        cube,
        default_model_of_same_kind_as_results_cube(cube).variable_names_read_for_fall_probability,
    ).transpose("record", "rule")
    vectors = mean_cosine_and_sine_to_reference(sums, cube["fault_normal"]).where(
        ~unknown_outcomes_may_bias_fall_axis(sums) & (not azimuths_in_results_bias_mean_fall_axis(cube))
    )
    cosine, sine = vectors["cosine"].to_numpy(), vectors["sine"].to_numpy()
    lengths, events = np.hypot(cosine, sine), np.atleast_1d(cube["event"].to_numpy().astype(str))
    found = dict[str, list[FaultNormalAlignmentOfSelectedBlocks]]()
    for group, members in record_masks_by_group(cube).items():
        found[group] = []
        for place, rule in enumerate(block_selection_rules):
            own, most = (np.where(members, values[:, place], np.nan) for values in (cosine, lengths))
            alignment = mean_over_earthquakes(own, events, bootstrap_sample_count=bootstrap_sample_count)
            largest = mean_over_earthquakes(most, events, bootstrap_sample_count=1).mean
            found[group].append(
                FaultNormalAlignmentOfSelectedBlocks(rule, int(np.isfinite(own).sum()), alignment, largest)
            )
    return found


def _count_falls_and_sum_fall_axes_by_selection_rule(
    block_selection_rules: Sequence[FallDirectionBlockSelectionRule], cube: xr.Dataset
) -> xr.Dataset:
    """Count falls and sum cosines and sines of doubled fall azimuths, for each record and block selection rule.

    The result has the dimensions ``record`` and ``rule``.
    """
    model, share = default_model_of_same_kind_as_results_cube(cube), share_of_directions_with_overturning(cube)
    weighted = fall_weights_and_direction_components_by_case(cube).drop_vars(["direction_cosine", "direction_sine"])
    over = (model.direction_dimension_name, *model.case_dims_without_direction)
    return xr.concat(
        [weighted.where(rule.selected_block_mask(share)).sum(over) for rule in block_selection_rules], "rule"
    )
