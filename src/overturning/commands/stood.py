"""`overturning stood`: whether stones still stand after years of a hazard."""

from pathlib import Path
from typing import Annotated, Final

import typer

NEGLIGIBLE: Final = 0.01
"""Part of the falls that shaking below the hazard's first level may add without a word."""


def stood(
    fragility: Annotated[Path, typer.Argument(help="fragility curves of a run (CSV)")],
    hazard: Annotated[Path, typer.Argument(help="hazard curves (CSV): measure, unit, level, annual_rate")],
    years: Annotated[float, typer.Option(min=1e-3, max=1e7, help="how long the stones are exposed: their age")],
    stones: Annotated[
        Path | None, typer.Option(help="survey (CSV): where none of its stones fell it bounds the rate of falls")
    ] = None,
) -> None:
    """Say how probable it is that stones still stand after years of a hazard, and what stones that do stand say of it.

    Earthquakes are a Poisson process: λ = ∫ P(fall | x) |dν(x)|, P(stands) = exp(−λT).
    """
    import math

    from overturning.errors import ResultError
    from overturning.report.blocks import Section, table
    from overturning.report.plain import plain_lines
    from overturning.report.text import counted, percent, share
    from overturning.study.ensemble import wilson
    from overturning.surveys.standing import (
        BOUND,
        hazard_bound,
        rate_bound,
        read_curves,
        read_hazard,
        standing,
        weaker_falls,
    )
    from overturning.surveys.stones import read_survey

    curves, hazards = read_curves(fragility), read_hazard(hazard)
    rows = None if stones is None else read_survey(stones)
    upright, fell = (sum(one.count for one in rows or () if one.fell is kind) for kind in (False, True))
    bound = rate_bound(years) if upright and not fell else math.nan
    units = {one.measure: one.unit for one in curves}
    for measure in hazards.keys() & units.keys():
        own = hazards[measure].unit
        if own != units[measure]:
            raise ResultError(f"{hazard}: {measure} in {own}, but {fragility} has it in {units[measure]}; convert it")
    shared = [one for one in curves if one.measure in hazards]
    if not shared:
        raise ResultError(f"{hazard}: {', '.join(hazards)}; {fragility} has {', '.join(units)}: give one of these")
    known = [(one, hazards[one.measure]) for one in shared if math.isfinite(one.log_spread)]
    told = [standing(*one, years) for one in known]
    for row in shared:
        if not math.isfinite(row.log_spread):
            why = "no curve fits the falls" if math.isnan(row.median) else "the median lies beyond the records"
            print(f"{row.stones}, {row.measure}: {why}, so nothing is said")
    lines = [
        (
            *(one.stones, one.measure, f"{one.rate:.3g}", share(one.stands, one.low, one.high)),
            *(one.share, one.beyond, "–" if math.isnan(most := hazard_bound(*of, years, bound)) else f"{most:.3g}"),
        )
        for of, one in zip(known, told, strict=True)
    ]
    heads = ("stones", "measure", "falls a year", f"P(stands {years:g} years)", "share of the class that stands")
    more = ("of the falls, beyond the records", "hazard at most so many times")
    if lines:
        print(*plain_lines(Section("What has stood", (table((*heads, *more), lines, "tttt%%t"),))), sep="\n")
    for (row, curve), found in zip(known, told, strict=True):
        if (uncounted := weaker_falls(row, curve)) > NEGLIGIBLE * found.rate:
            print(
                f"{found.stones}, {found.measure}: {percent(found.first, 1)} fall at the hazard's first level, "
                f"{curve.level[0]:g} {curve.unit}; weaker shaking is not counted, and would add {uncounted:.2g} falls "
                "a year down to a tenth of that level if the curve goes on as it begins: begin the hazard curve lower"
            )
    if not math.isnan(bound):
        print(
            f"{counted(upright, 'stone')} stood {years:g} years: their rate of falls lies below {bound:.3g} a year "
            f"with {percent(BOUND)} probability; they share their earthquakes and count as one. The hazard is bounded "
            "in the line of their class alone, which is not sought by the sizes in the survey"
        )
    elif rows is not None:
        low, high = wilson(upright, upright + fell)
        standing_share = share(upright / (upright + fell), float(low), float(high))
        print(f"{upright} of {upright + fell} stones stand, {standing_share}; where some fell no bound is given")
