"""Uncertainty of outcomes: runs of the ensemble that disagree, and cases that change when computed again."""

from functools import partial

import numpy as np
import xarray as xr

from overturning.findings.results import Results
from overturning.findings.values import Finding, Number
from overturning.model.model import Model
from overturning.settings import Ensemble
from overturning.statistics.by_record import by_record
from overturning.statistics.space import summarise_twist, twist_angles
from overturning.statistics.spread import Statistic, falls_to_both_sides, first_batch_estimate, runs_disagree
from overturning.study.convergence import Convergence
from overturning.study.ensemble import BATCH


class EnsembleFindings(Finding):
    """Cells whose runs with slightly changed motion and block disagree."""

    share_of_cells_run: Number
    """Share of all cells that lie near a change of outcome and were run again."""
    fewest_runs: Number
    most_runs: Number
    mean_runs: Number
    first_batch: int
    """Number of runs to which the next two shares refer."""
    disagree: Number
    """Share of the cells that were run in which some runs fall and others stand."""
    both_ways: Number
    """Share of these cells in which most runs fall, but not all to the same side (in space: far apart)."""


class ConvergenceFindings(Finding):
    """Cases that change when they are computed again with finer steps, stiffer springs, or as exact rigid blocks."""

    result: Convergence
    sampled: bool
    """True if a random part of the cases was run again, False if all were."""


class Twist(Finding):
    """Rotation about the vertical of stones that moved and stand at the end, degrees."""

    stones: int
    median_deg: Number
    nine_of_ten_below_deg: Number
    largest_deg: Number


def convergence_of(results: Results) -> ConvergenceFindings | None:
    """Return the result of the convergence check; None if the study has none."""
    found = results.convergence
    return None if found is None else ConvergenceFindings(result=found, sampled=found.chosen < found.computed)


def twist_of(results: Results) -> Twist | None:
    """Summarise the rotation about the vertical; None for models that cannot twist."""
    if not results.model.twists:
        return None
    found = summarise_twist(np.concatenate(list(twist_angles(results.cube).values())))
    return Twist(
        stones=found.stones, median_deg=found.median, nine_of_ten_below_deg=found.most, largest_deg=found.largest
    )


def ensemble_of(results: Results) -> EnsembleFindings | None:
    """Count the cells whose runs disagree; None without an ensemble."""
    cube, settings = results.cube, results.study.ensemble
    if "members" not in cube:
        return None
    found = by_record(partial(ensemble_counts, results.model, settings), cube, (*results.model.reads, "members"))
    sums = found.drop_vars(("fewest", "most")).sum()

    def share(part: str, of: str) -> float:
        return float(sums[part]) / float(sums[of]) if float(sums[of]) else float("nan")

    return EnsembleFindings(
        share_of_cells_run=share("run", "cells"),
        fewest_runs=float(found["fewest"].min()),
        most_runs=float(found["most"].max()),
        mean_runs=share("members", "with_members"),
        first_batch=min(BATCH, settings.members),
        disagree=share("divided", "run"),
        both_ways=share("apart", "agree"),
    )


def ensemble_counts(model: Model, settings: Ensemble, cube: xr.Dataset) -> xr.Dataset:
    """Count for each record: cells, cells that were run, divided, agreed on and apart, and their runs."""
    found, half = model.ensemble_disagreement(cube), cube.isel({model.direction: model.distinct_direction_index(cube)})
    run, members = found["towards"].notnull(), half["members"].where(half["members"] > 0)

    def of_cells(statistic: Statistic) -> xr.DataArray:
        said = first_batch_estimate(statistic, found["towards"], found["away"], members.fillna(0), settings)
        return run.copy(data=np.nan_to_num(said))

    over = [name for name in run.dims if name != "record"]
    counts = xr.Dataset({
        "cells": xr.ones_like(run),
        "run": run,
        "divided": of_cells(runs_disagree),
        "agree": found.get("agree", run),
        "apart": found["apart"] if "apart" in found else of_cells(falls_to_both_sides),
        "members": members,
        "with_members": members.notnull(),
    }).sum(over)  # fmt: skip
    return counts.assign(fewest=members.min(over), most=members.max(over))
