"""Uncertainty of outcomes: ensemble runs that disagree, cases that change in a second computation, final rotation."""

import math
from functools import partial

import numpy as np
import xarray as xr

from overturning.findings.comparison import ChangedCases, SecondComputation, second_computations, share_of_changed_cases
from overturning.findings.results import StudyResults
from overturning.findings.values import Finding, Number
from overturning.model.model import Model
from overturning.settings import Ensemble
from overturning.statistics.by_record import apply_to_record_batches
from overturning.statistics.space import summarise_twist, twist_angles
from overturning.statistics.spread import Statistic, first_batch_estimate, runs_disagree, runs_fall_to_both_sides
from overturning.study.convergence import Convergence
from overturning.study.ensemble import BATCH


class EnsembleFindings(Finding):
    """Share of the cells whose ensemble runs, with slightly changed motion and block, disagree."""

    share_of_cells_repeated: Number
    """Share of all cells that lie near a change of outcome and were run again, several times."""
    fewest_runs_per_cell: Number
    """Smallest number of runs of a repeated cell."""
    most_runs_per_cell: Number
    """Largest number of runs of a repeated cell."""
    mean_runs_per_cell: Number
    """Mean number of runs of a repeated cell."""
    first_batch_runs: int
    """Number of runs per cell on which `share_disagreeing` and `share_falling_both_ways` are based."""
    share_disagreeing: Number
    """Share of the repeated cells in which some runs fall and others stand."""
    share_falling_both_ways: Number
    """Share of the repeated cells in which most runs fall, but not all to one side (3-D: directions far apart)."""


class ConvergenceFindings(Finding):
    """Shares of the cases that change if computed again with finer steps, stiffer springs, or as exact rigid blocks."""

    result: Convergence
    """Counts of the convergence check (`convergence.json`)."""
    is_sample: bool
    """True if a random sample of the cases was run again, False if all were."""
    comparisons: list[SecondComputation]
    """Cases that change in each second computation."""
    share_at_rest: Number
    """Share of the cases run again that lie below the thresholds of rocking and sliding and cannot change."""
    undecidable: ChangedCases
    """Cases that change under a motion stronger by a factor of 1 + 10⁻⁹: no computation can decide them."""
    moved_by_amplitude: ChangedCases | None
    """Falls in space whose azimuth moves by 30° or more within ± 1 % of the amplitude; None for planar models."""


class FinalTwist(Finding):
    """Rotation about the vertical of stones that moved and stand at the end, degrees."""

    stones: int
    """Number of stones that moved and stand."""
    median_deg: Number
    """Median of the absolute rotation."""
    percentile_90_deg: Number
    """90th percentile of the absolute rotation."""
    largest_deg: Number
    """Largest absolute rotation."""


def convergence_findings(results: StudyResults) -> ConvergenceFindings | None:
    """Return the results of the convergence check of a study; None if it has none."""
    found = results.convergence
    if found is None:
        return None
    is_sample, shift = found.chosen < found.computed, found.amplitude
    return ConvergenceFindings(
        result=found,
        is_sample=is_sample,
        comparisons=second_computations(found),
        share_at_rest=found.at_rest / found.chosen if found.chosen else math.nan,
        undecidable=share_of_changed_cases(found.settling.chaotic, found.chosen, is_sample),
        moved_by_amplitude=None if shift is None else share_of_changed_cases(shift.moved, shift.falls, is_sample),
    )


def final_twist(results: StudyResults) -> FinalTwist | None:
    """Summarise the final rotation about the vertical of stones that stand; None for planar models."""
    if not results.model.twists:
        return None
    found = summarise_twist(np.concatenate(list(twist_angles(results.cube).values())))
    return FinalTwist(
        stones=found.stones, median_deg=found.median, percentile_90_deg=found.most, largest_deg=found.largest
    )


def ensemble_findings(results: StudyResults) -> EnsembleFindings | None:
    """Compute the shares of cells whose ensemble runs disagree; None for a study without an ensemble."""
    cube, settings = results.cube, results.study.ensemble
    if "members" not in cube:
        return None
    found = apply_to_record_batches(
        partial(count_ensemble_cells, results.model, settings), cube, (*results.model.reads, "members")
    )
    sums = found.drop_vars(("fewest", "most")).sum()

    def share_of_sums(part: str, of: str) -> float:
        return float(sums[part]) / float(sums[of]) if float(sums[of]) else float("nan")

    return EnsembleFindings(
        share_of_cells_repeated=share_of_sums("run", "cells"),
        fewest_runs_per_cell=float(found["fewest"].min()),
        most_runs_per_cell=float(found["most"].max()),
        mean_runs_per_cell=share_of_sums("members", "with_members"),
        first_batch_runs=min(BATCH, settings.members),
        share_disagreeing=share_of_sums("divided", "run"),
        share_falling_both_ways=share_of_sums("apart", "agree"),
    )


def count_ensemble_cells(model: Model, ensemble_settings: Ensemble, cube: xr.Dataset) -> xr.Dataset:
    """Count cells for each record: all, repeated, with runs that disagree, with falls to both sides; and their runs."""
    found, half = model.ensemble_disagreement(cube), cube.isel({model.direction: model.distinct_direction_index(cube)})
    run, members = found["towards"].notnull(), half["members"].where(half["members"] > 0)

    def cell_statistic(statistic: Statistic) -> xr.DataArray:
        said = first_batch_estimate(statistic, found["towards"], found["away"], members.fillna(0), ensemble_settings)
        return run.copy(data=np.nan_to_num(said))

    over = [name for name in run.dims if name != "record"]
    counts = xr.Dataset({
        "cells": xr.ones_like(run),
        "run": run,
        "divided": cell_statistic(runs_disagree),
        "agree": found.get("agree", run),
        "apart": found["apart"] if "apart" in found else cell_statistic(runs_fall_to_both_sides),
        "members": members,
        "with_members": members.notnull(),
    }).sum(over)  # fmt: skip
    return counts.assign(fewest=members.min(over), most=members.max(over))
