"""Uncertainty: the spread of outcomes over the neighbourhood of each case."""

from functools import partial

import numpy as np
import xarray as xr

from overturning.model.falls import model_of
from overturning.model.model import Model
from overturning.report.blocks import Paragraph, Section
from overturning.report.results import Results
from overturning.report.text import number, percent
from overturning.report.words import words_of
from overturning.statistics.by_record import by_record


def ensemble(results: Results) -> Section | None:
    """How many cells near a change of flag have runs that are divided; none without an ensemble."""
    cube = results.cube
    if "members" not in cube:
        return None
    model = model_of(cube)
    found = by_record(partial(_counts, model), cube, (*model.reads, *model.reads_spread, "members"))
    sums = found.drop_vars(("fewest", "most")).sum()
    count, divided, agree = (int(sums[name]) for name in ("run", "divided", "agree"))
    text = "No cell lies near a change of flag, so the ensemble had nothing to run."
    if count:
        fewest, most = f"{float(found['fewest'].min()):.0f}", f"{float(found['most'].max()):.0f}"
        times, until = most, ""
        if fewest != most:
            mean = f"{float(sums['members']) / int(sums['with_members']):.0f}"
            times = f"{fewest} to {most}"
            until = f" (on average {mean}; no more once the 95 % intervals of its probabilities are narrow enough)"
        apart = words_of(results.cube).apart.format(percent(float(sums["apart"]) / agree if agree else float("nan"), 1))
        text = (
            f"Each cell near a change of flag ({percent(count / int(sums['cells']))} of all) was run {times} more "
            "times with "
            f"slightly different amplitude, shape, friction, damping and {model.direction}{until}. In "
            f"{percent(divided / count, 1)} of them some runs fall and others stand; {apart}"
        )
        if divided:
            gap = float(sums["gap"]) / divided
            text += f" Where runs are divided, the two halves of the ensemble differ by {number(gap)} in probability"
            text += " on average."
        text += " This is the spread over the neighbourhood stated in the study, not a probability of what happened."
    return Section("Uncertainty", (Paragraph(text),), anchor="uncertainty")


def _counts(model: Model, cube: xr.Dataset) -> xr.Dataset:
    """Of each record: cells, those that were run, divided, agreed on and apart, and how many members they had."""
    found, half = model.spread(cube), cube.isel({model.direction: model.representative(cube)})
    run, members = found["falls"].notnull(), half["members"].where(half["members"] > 0)
    divided = (found["falls"] > 0) & (found["falls"] < 1)
    over = [name for name in run.dims if name != "record"]
    counts = xr.Dataset({
        "cells": xr.ones_like(run),
        "run": run,
        "divided": divided,
        "agree": found["agree"],
        "apart": found["apart"],
        "gap": np.abs(found["gap"].where(divided).astype("float64")),
        "members": members,
        "with_members": members.notnull(),
    }).sum(over)  # fmt: skip
    return counts.assign(fewest=members.min(), most=members.max())
