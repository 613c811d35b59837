"""How far the answers hold: the spread of outcomes over the neighbourhood of each case."""

import numpy as np

from overturning.report.blocks import Paragraph, Section
from overturning.report.results import Results
from overturning.report.text import number, percent


def ensemble(results: Results) -> Section | None:
    """Shares of the cells near a change of flag whose runs are divided, each plane once; none without an ensemble."""
    if results.in_space:
        return _in_space(results)
    if "probability_towards" not in results.cube:
        return None
    half = results.cube.isel(azimuth=np.flatnonzero(results.cube["azimuth"].to_numpy() < 180))
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
    falls = cube["probability_falls"].to_numpy()
    run = np.isfinite(falls)
    count = int(run.sum())
    text = "No cell lies near a change of flag, so the ensemble had nothing to run."
    if count:
        length = np.hypot(cube["fall_north"].to_numpy(), cube["fall_east"].to_numpy()) / np.where(
            falls > 0, falls, np.nan
        )
        divided, sure = run & (falls > 0) & (falls < 1), run & (falls == 1)
        gap = np.abs(cube["scramble_difference"].to_numpy()[divided])
        members = f"{float(cube['members'].max().compute()):.0f}"
        astray = float((length[sure] < OF_ONE_MIND).mean()) if sure.any() else float("nan")
        text = (
            f"Each cell near a change of flag ({percent(count / run.size)} of all) was run {members} more times with slightly "
            f"different amplitude, shape, friction, damping and orientation. In {percent(float(divided.sum()) / count, 1)} of them "
            f"some runs fall and others stand. Where all runs fall, their directions spread by more than 15° about their mean in "
            f"{percent(astray, 1)} (mean resultant below {OF_ONE_MIND:.3f})."
        )
        if gap.size:
            text += f" Where runs are divided, the two halves of the ensemble differ by {number(float(gap.mean()))} in probability."
        text += " This is the spread over the neighbourhood stated in the study, not a probability of what happened."
    return Section("How far the answers hold", (Paragraph(text),), anchor="uncertainty")
