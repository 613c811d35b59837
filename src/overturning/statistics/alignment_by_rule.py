"""Alignment of falls with the fault normal, for each rule that selects blocks."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
import xarray as xr

from overturning.model.falls import model_of
from overturning.statistics.bootstrap import EarthquakeMean, mean_over_earthquakes
from overturning.statistics.by_record import apply_to_record_batches, record_groups
from overturning.statistics.falls import (
    BLOCK_RULES,
    BlockRule,
    mean_cosine_and_sine_to_reference,
    overturned_shares_of_directions,
)


@dataclass(frozen=True)
class RuleAlignment:
    """Alignment of falls with the fault normal under one rule that selects blocks.

    Attributes
    ----------
    rule : BlockRule
        Rule that selects the blocks.
    records : int
        Records with falls of these blocks and a known fault normal.
    alignment : Mean
        Mean of cos 2Δ over the falls of a record, the records of an earthquake, and earthquakes; 95 % interval.
    largest : float
        Largest possible alignment: the same mean of the resultants of the doubled fall axes of each record.
    """

    rule: BlockRule
    records: int
    alignment: EarthquakeMean
    largest: float


def alignment_by_rule(
    cube: xr.Dataset, block_rules: Sequence[BlockRule] = BLOCK_RULES, *, draws: int = 10_000
) -> dict[str, list[RuleAlignment]]:
    """Compute the alignment of falls with the fault normal under each rule that selects blocks, by group of records.

    The cube is read in parts. Each rule uses the same bootstrap samples of earthquakes as `summarise_fall_axes`, whose
    alignment is that of the rule `block_rule_of_model(cube)`.

    Parameters
    ----------
    cube : Dataset
        Cube with the coordinates ``fault_normal(record)``, degrees, and ``event(record)``.
    block_rules : sequence of BlockRule
        Rules to compare.
    draws : int
        Bootstrap samples.
    """
    sums = apply_to_record_batches(
        partial(_sum_falls_by_block_rule, block_rules), cube, model_of(cube).reads
    ).transpose("record", "rule")
    vectors = mean_cosine_and_sine_to_reference(sums, cube["fault_normal"])
    cosine, sine = vectors["cosine"].to_numpy(), vectors["sine"].to_numpy()
    lengths, events = np.hypot(cosine, sine), np.atleast_1d(cube["event"].to_numpy().astype(str))
    found = dict[str, list[RuleAlignment]]()
    for group, members in record_groups(cube).items():
        found[group] = []
        for place, rule in enumerate(block_rules):
            own, most = (np.where(members, values[:, place], np.nan) for values in (cosine, lengths))
            alignment = mean_over_earthquakes(own, events, draws=draws)
            largest = mean_over_earthquakes(most, events, draws=1).value
            found[group].append(RuleAlignment(rule, int(np.isfinite(own).sum()), alignment, largest))
    return found


def _sum_falls_by_block_rule(block_rules: Sequence[BlockRule], cube: xr.Dataset) -> xr.Dataset:
    """Sum falls and cosines and sines of doubled fall axes over the blocks of each rule; dimensions (record, rule)."""
    model, share = model_of(cube), overturned_shares_of_directions(cube)
    falls = model.falls_in_distinct_cells(cube)
    names = ["falls", "axis_cosine", "axis_sine"]
    weighted = falls[names] * falls["weight"]
    over = (model.direction, *model.case_dims)
    return xr.concat([weighted.where(rule.selects_blocks(share)).sum(over) for rule in block_rules], "rule")
