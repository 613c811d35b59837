"""Command `overturning stood`: the probability that stones survive the seismic hazard."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    pass
from overturning.commands.surveys import _print_results_with_template


def print_survival_probability(
    fragility: Annotated[Path, typer.Argument(help="fragility curves of a run (CSV)")],
    hazard: Annotated[Path, typer.Argument(help="hazard curves (CSV): measure, unit, level, annual_rate")],
    years: Annotated[float, typer.Option(min=1e-3, max=1e7, help="exposure time of the stones (their age), years")],
    stones: Annotated[
        Path | None, typer.Option(help="survey (CSV); if none of its stones fell, it bounds the rate of falls")
    ] = None,
) -> None:
    """Print the probability that stones survive a seismic hazard for some years.

    If no stone of the survey --stones fell, also print a bound of the rate of falls.

    Earthquakes are a Poisson process: λ = ∫ P(fall | x) |dν(x)|, P(stands) = exp(−λT), where ν(x) is the annual
    rate at which the intensity x is exceeded, λ the annual rate of falls, and T the exposure time in years.
    """
    from overturning.findings.standing import survival_findings
    from overturning.surveys.counted_stones import read_fallen_and_standing_stones_notes_and_warnings
    from overturning.surveys.hazard import read_fragility_curves, read_hazard_curves_by_intensity_measure
    from overturning.surveys.standing import survival_probability_by_stone_class

    curves, hazards = read_fragility_curves(fragility), read_hazard_curves_by_intensity_measure(hazard)
    rows, notes, _ = (None, [], []) if stones is None else read_fallen_and_standing_stones_notes_and_warnings(stones)
    for note in notes:
        print(note)
    found = survival_probability_by_stone_class(
        curves, hazards, years, fragility_and_hazard_file_names=(str(fragility), str(hazard))
    )
    _print_results_with_template(survival_findings(found, rows), "stood")
