"""How far the answers hold: the spread of outcomes over the neighbourhood of each case."""

from typing import TYPE_CHECKING

import numpy as np

from overturning.report.blocks import Paragraph, Section
from overturning.report.results import Results
from overturning.report.text import percent

if TYPE_CHECKING:
    import xarray as xr


def ensemble(results: Results) -> Section | None:
    """What the ensemble shows; none where none was run."""
    if "probability_towards" not in results.cube:
        return None
    return Section("How far the answers hold", (Paragraph(ensemble_text(results.cube)),), anchor="uncertainty")


def ensemble_text(cube: "xr.Dataset") -> str:
    """Shares of the cells near a change of flag whose runs are divided, each plane once."""
    half = cube.isel(azimuth=np.flatnonzero(cube["azimuth"].to_numpy() < 180))
    towards, away = half["probability_towards"], half["probability_away"]
    run = towards.notnull()
    count = int(run.sum().compute())
    if count == 0:
        return "No cell lies near a change of flag, so the ensemble had nothing to run."
    falls = towards + away
    divided = (falls > 0) & (falls < 1)
    other_side = (np.minimum(towards, away) > 0) & (falls > 0.5)
    gap = abs(half["scramble_difference_towards"] + half["scramble_difference_away"])
    scrambles = f"{float(gap.where(divided).mean().compute()):.2f}" if bool(divided.any()) else "–"
    members = f"{float(half['members'].max().compute()):.0f}"
    return (
        f"Each cell near a change of flag ({percent(count / int(run.size))} of all) was run {members} more times with slightly "
        f"different amplitude, shape, friction, damping and azimuth. In {percent(float(divided.sum().compute()) / count, 1)} of "
        f"them some runs fall and others stand; in {percent(float(other_side.sum().compute()) / count, 1)} most runs fall, but "
        "not all to the same side. Where runs are divided, the two halves of the ensemble differ by "
        f"{scrambles} in probability on average: that well {members} runs know it. This is the spread over the neighbourhood "
        "stated in the study, not a probability of what happened."
    )
