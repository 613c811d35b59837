"""How far the answers hold: the spread of outcomes over the neighbourhood of each case."""

import numpy as np
import xarray as xr

from overturning.report.blocks import Paragraph, Section
from overturning.report.results import Results
from overturning.report.text import number, percent
from overturning.statistics.by_record import by_record
from overturning.statistics.planes import plane_index


def ensemble(results: Results) -> Section | None:
    """Shares of the cells near a change of flag whose runs are divided, each plane once; none without an ensemble."""
    if results.in_space:
        return _in_space(results)
    if "probability_towards" not in results.cube:
        return None
    half = results.cube.isel(azimuth=plane_index(results.cube["azimuth"].to_numpy()))
    towards, away = half["probability_towards"], half["probability_away"]
    run = towards.notnull()
    count = int(run.sum().compute())
    text = "No cell lies near a change of flag, so the ensemble had nothing to run."
    if count:
        falls = towards + away
        divided = (falls > 0) & (falls < 1)
        other_side = (np.minimum(towards, away) > 0) & (falls > 0.5)
        gap = abs(half["scramble_difference_towards"] + half["scramble_difference_away"]).where(divided).mean()
        members = half["members"].where(half["members"] > 0)
        fewest, most, mean = (f"{float(of().compute()):.0f}" for of in (members.min, members.max, members.mean))
        times, until = most, ""
        if fewest != most:
            times = f"{fewest} to {most}"
            until = f" (on average {mean}; no more once the 95 % intervals of its probabilities are narrow enough)"
        shares = [percent(float(cells.sum().compute()) / count, 1) for cells in (divided, other_side)]
        text = (
            f"Each cell near a change of flag ({percent(count / int(run.size))} of all) was run {times} more times with "
            f"slightly different amplitude, shape, friction, damping and azimuth{until}. In "
            f"{shares[0]} of them some runs fall and others stand; in {shares[1]} most runs fall, but not all to the same "
            f"side. Where runs are divided, the two halves of the ensemble differ by {number(float(gap.compute()))} in "
            "probability on average: that well their runs know it. This is the spread over the neighbourhood stated in "
            "the study, not a probability of what happened."
        )
    return Section("How far the answers hold", (Paragraph(text),), anchor="uncertainty")


OF_ONE_MIND = float(np.cos(np.radians(15.0)))
"""Mean resultant of directions that lie 15° to either side of their mean."""


def _in_space(results: Results) -> Section | None:
    """The same in space, where runs that fall may also go different ways."""
    cube = results.cube
    if "probability_falls" not in cube:
        return None
    names = ("probability_falls", "fall_north", "fall_east", "scramble_difference")
    sums = by_record(_sums_in_space, cube, names).sum()
    count, divided, sure = (int(sums[name]) for name in ("run", "divided", "sure"))
    text = "No cell lies near a change of flag, so the ensemble had nothing to run."
    if count:
        members = f"{float(cube['members'].max().compute()):.0f}"
        astray = float(sums["astray"]) / sure if sure else float("nan")
        text = (
            f"Each cell near a change of flag ({percent(count / cube['probability_falls'].size)} of all) was run {members} more times with slightly "
            f"different amplitude, shape, friction, damping and orientation. In {percent(divided / count, 1)} of them "
            f"some runs fall and others stand. Where all runs fall, their directions spread by more than 15° about their mean in "
            f"{percent(astray, 1)} (mean resultant below {OF_ONE_MIND:.3f})."
        )
        if divided:
            gap = float(sums["gap"]) / divided
            text += f" Where runs are divided, the two halves of the ensemble differ by {number(gap)} in probability."
        text += " This is the spread over the neighbourhood stated in the study, not a probability of what happened."
    return Section("How far the answers hold", (Paragraph(text),), anchor="uncertainty")


def _sums_in_space(cube: xr.Dataset) -> xr.Dataset:
    """Of each record the cells that were run, in which runs are divided, and in which all fall, and those that go astray."""
    falls = cube["probability_falls"]
    length = xr.apply_ufunc(np.hypot, cube["fall_north"], cube["fall_east"]) / falls.where(falls > 0)
    divided, sure = (falls > 0) & (falls < 1), falls == 1
    found = xr.Dataset({
        "run": falls.notnull(),
        "divided": divided,
        "sure": sure,
        "astray": sure & (length < OF_ONE_MIND),
        "gap": np.abs(cube["scramble_difference"].where(divided).astype("float64")),
    })  # fmt: skip
    return found.sum([name for name in falls.dims if name != "record"])
