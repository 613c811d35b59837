"""Share of the variance within ensembles that the relief of the base of a scanned stone explains.

The relief is the height above the lowest point of the base up to which its points bear load.
"""

import numpy as np
import xarray as xr

from overturning.arrays import FloatArray
from overturning.findings.results import StudyResults
from overturning.findings.values import FindingBaseClass, OptionalNumberOrInfinity
from overturning.model.variables import RELIEF_ENSEMBLE_VARIABLES
from overturning.statistics.by_record import apply_to_record_batches_and_join

_LOW, _HIGH = (variable.name for variable in RELIEF_ENSEMBLE_VARIABLES)


class FallSharesByBaseRelief(FindingBaseClass):
    """Falls of a scanned stone in ensemble runs with a low and with a high relief of its base.

    The relief is the height above the lowest point of the base up to which its points bear load.
    """

    midrange_base_relief_mm: OptionalNumberOrInfinity
    """Relief that divides the runs of a case into two halves, mm."""
    share_of_low_relief_runs_falling: OptionalNumberOrInfinity
    """Share of the runs with a lower relief that fall, over the cases that were run again."""
    share_of_high_relief_runs_falling: OptionalNumberOrInfinity
    """Share of the runs with a higher relief that fall, over the cases that were run again."""
    variance_share_explained_by_base_relief: OptionalNumberOrInfinity
    """Share of the variance of the outcome (1 fall, 0 stand) within ensembles that lies between both halves of runs."""


def share_of_fall_variance_due_to_base_relief(results: StudyResults) -> FallSharesByBaseRelief | None:
    """Compute the share of the variance of falls within ensembles that is due to the relief of a scanned stone's base.

    The relief is the height above the lowest point of the base up to which its points bear load. The result is
    None unless the relief varies between the runs of an ensemble.
    """
    relief = results.study.ensemble.relief
    if relief is None or _LOW not in results.reference_element_cube:
        return None
    found = apply_to_record_batches_and_join(
        _sum_falls_for_low_and_high_base_relief,
        results.reference_element_cube,
        (_LOW, _HIGH, "members", "overturned"),
    ).sum()
    cells, total = float(found["cells"]), float(found["total"])
    return FallSharesByBaseRelief(
        midrange_base_relief_mm=500.0 * (relief.low + relief.high),
        share_of_low_relief_runs_falling=float(found["low"]) / cells if cells else float("nan"),
        share_of_high_relief_runs_falling=float(found["high"]) / cells if cells else float("nan"),
        variance_share_explained_by_base_relief=min(max(float(found["between"]) / total, 0.0), 1.0)
        if total > 0.0
        else float("nan"),
    )


def _sum_falls_for_low_and_high_base_relief(cube: xr.Dataset) -> xr.Dataset:
    """Return, for each record, sums over its cases with ensemble runs, to compare runs of low and high base relief.

    Variables: number of cases ``cells``; fall shares ``low`` and ``high`` of the runs with a relief in the lower and
    in the upper half of its range; variances of the outcome, ``between`` these halves and ``total``.
    """
    low, high, members = (cube[name].astype("float64") for name in (_LOW, _HIGH, "members"))
    over = [name for name in low.dims if name != "record"]
    between, total = estimate_variance_between_run_halves_and_total(low.to_numpy(), high.to_numpy(), members.to_numpy())
    known = low.notnull() & high.notnull()
    sums = {
        "cells": known.astype("float64"),
        "low": low.where(known),
        "high": high.where(known),
        "between": low.copy(data=between),
        "total": low.copy(data=total),
    }
    return xr.Dataset({name: values.fillna(0.0).sum(over) for name, values in sums.items()})


def estimate_variance_between_run_halves_and_total(
    low_relief_half_fall_share_by_case: FloatArray,
    high_relief_half_fall_share_by_case: FloatArray,
    run_count_of_both_halves_by_case: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Estimate the variance of an outcome (0 or 1) between the low- and high-relief half of the runs, and in total.

    Both halves have equal numbers of runs. The estimates are unbiased: the sampling variance of the observed fall
    shares is removed.

    Parameters
    ----------
    low_relief_half_fall_share_by_case, high_relief_half_fall_share_by_case : ndarray
        Share of the runs that fall in each half; NaN where a case has no runs.
    run_count_of_both_halves_by_case : ndarray
        Number of runs of both halves together.
    """
    half = np.maximum(0.5 * run_count_of_both_halves_by_case, 2.0)
    low, high = low_relief_half_fall_share_by_case, high_relief_half_fall_share_by_case
    noise = (low * (1.0 - low) + high * (1.0 - high)) / (half - 1.0)
    between = 0.25 * ((high - low) ** 2 - noise)
    within = 0.5 * half / (half - 1.0) * (low * (1.0 - low) + high * (1.0 - high))
    return between, between + within
