"""`overturning stood`: whether stones still stand after years of a hazard."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

if TYPE_CHECKING:
    from overturning.surveys.standing import CurveRow, Hazard

LARGEST_FACTOR: Final = 1e6
"""On the hazard; where stones of a class would stand under so many times of it, none is bounded."""

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
    from overturning.report.text import counted, estimate, percent
    from overturning.study.ensemble import wilson
    from overturning.surveys.standing import BOUND, rate_bound, read_curves, read_hazard, standing
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
            print(f"{row.stones}, {row.measure}: the median lies beyond the records, so nothing is said")
    lines = [
        (
            *(one.stones, one.measure, f"{one.rate:.3g}", estimate(one.stands, one.low, one.high)),
            *(one.share, one.beyond, "–" if math.isnan(most := _most(*of, years, bound)) else f"{most:.3g}"),
        )
        for of, one in zip(known, told, strict=True)
    ]
    heads = ("stones", "measure", "falls a year", f"P(stands {years:g} years)", "share of the class that stands")
    more = ("of the falls, beyond the records", "hazard at most so many times")
    print(*plain_lines(Section("What has stood", (table((*heads, *more), lines, "tttt2%t"),))), sep="\n")
    for (row, curve), found in zip(known, told, strict=True):
        if (uncounted := _weaker(row, curve)) > NEGLIGIBLE * found.rate:
            print(
                f"{found.stones}, {found.measure}: {percent(found.first, 1)} fall at the hazard's first level, "
                f"{curve.level[0]:g} {curve.unit}; weaker shaking is not counted, and would add {uncounted:.2g} falls "
                "a year down to a tenth of that level if the curve goes on as it begins: begin the hazard curve lower"
            )
    if not math.isnan(bound):
        print(
            f"{counted(upright, 'stone')} stood {years:g} years: their rate of falls lies below {bound:.3g} a year "
            f"with {percent(BOUND)} probability; they share their earthquakes and count as one"
        )
    elif rows is not None:
        low, high = wilson(upright, upright + fell)
        share = estimate(upright / (upright + fell), float(low), float(high))
        print(f"{upright} of {upright + fell} stones stand, {share}; where some fell no bound is given")


def _most(curve: "CurveRow", hazard: "Hazard", years: float, bound: float) -> float:
    """Times the hazard under which but 5 % of a class stand so many years: a stone that stands says that it is less.

    Each stone keeps what sets it apart, and those that stand are the strong ones, so that this is more than the
    ``bound`` of the rate over the mean rate of the class; it is that where the parts of the spread are not known. NaN
    where no stone bounds it.
    """
    import math

    import scipy

    from overturning.surveys.standing import BOUND, standing

    rate = standing(curve, hazard, years).rate
    if math.isnan(bound) or not rate > 0:
        return math.nan

    def too_many(log_factor: float) -> float:
        return standing(curve, hazard, years * math.exp(log_factor)).share - (1 - BOUND)

    # Years count as the hazard does: twice the time is twice the hazard.
    first, last = math.log(bound / rate), math.log(LARGEST_FACTOR * max(1.0, bound / rate))
    if math.isnan(too_many(first)) or too_many(first) <= 0:
        return bound / rate
    return math.exp(scipy.optimize.brentq(too_many, first, last)) if too_many(last) < 0 else math.nan


def _weaker(curve: "CurveRow", hazard: "Hazard") -> float:
    """Falls a year from a tenth of the hazard's first level up to it, were the curve to go on there as it begins."""
    import numpy as np

    from overturning.surveys.standing import Hazard

    steepness = np.log(hazard.rate[0] / hazard.rate[1]) / np.log(hazard.level[1] / hazard.level[0])
    level = hazard.level[0] * np.array([0.1, 1.0])
    below = Hazard(hazard.measure, hazard.unit, level, hazard.rate[0] * (level / level[1]) ** -steepness)
    return float(below.falls(curve.median, curve.log_spread)[0])
