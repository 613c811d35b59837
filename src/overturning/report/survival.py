"""Text of `overturning stood`: survival of stones under a hazard, and the bound that standing stones put on it."""

import math
from collections.abc import Iterator, Sequence
from typing import Final

from overturning.errors import ResultError
from overturning.report.blocks import Section, table
from overturning.report.plain import plain_lines
from overturning.report.text import counted, percent, share
from overturning.study.ensemble import wilson_interval
from overturning.surveys.standing import (
    BOUND_PROBABILITY,
    LARGEST_SHARE_BEYOND,
    Survival,
    fall_rate_below_curve,
    hazard_unit_warning,
    upper_bound_of_fall_rate,
    upper_bound_of_hazard_factor,
)
from overturning.surveys.stones import Stone

NEGLIGIBLE: Final = 0.01
"""Share of the falls from shaking below the hazard's first level up to which no note is printed."""


def survival_lines(found: Survival, stones: Sequence[Stone] | None) -> Iterator[str]:
    """Yield the lines of the result: doubts, a table of the classes, notes, and the bound from standing stones.

    A ResultError is raised if the unit of a hazard curve is doubtful and most falls come from beyond the records.
    """
    upright, fell = (sum(one.count for one in stones or () if one.fell is kind) for kind in (False, True))
    bound = upper_bound_of_fall_rate(found.years) if upright and not fell else math.nan
    yield from _hazard_doubts(found)
    for row in found.without_curve:
        why = "no curve fits the falls" if math.isnan(row.median) else "the median lies beyond the records"
        yield f"{row.stones}, {row.measure}: {why}; no result"
    if found.estimates:
        yield from plain_lines(_survival_table(found, bound))
    yield from _weaker_shaking_notes(found)
    if stones is not None:
        yield _standing_stones(upright, fell, found.years, bound)


def _hazard_doubts(found: Survival) -> list[str]:
    """Return doubts about the units of hazard curves; raise a ResultError if falls come from beyond the records."""
    doubts = {
        one.measure: f"{found.hazard}: {why}" for one in found.hazards.values() if (why := hazard_unit_warning(one))
    }
    for *_, one in found.estimates:
        if one.measure in doubts and not one.beyond <= LARGEST_SHARE_BEYOND:
            falls = "no falls" if math.isnan(one.beyond) else f"{percent(one.beyond)} of the falls of {one.stones}"
            raise ResultError(f"{doubts[one.measure]}; {falls} come from levels beyond the records")
    return list(doubts.values())


def _survival_table(found: Survival, bound: float) -> Section:
    """Return the table of the classes; `bound` is the upper bound of the rate of falls, 1/year."""
    lines = []
    for curve, hazard, one in found.estimates:
        most = upper_bound_of_hazard_factor(curve, hazard, found.years, bound)
        stands, factor = share(one.stands, one.low, one.high), "–" if math.isnan(most) else f"{most:.3g}"
        lines.append((one.stones, one.measure, f"{one.rate:.3g}", stands, one.share, one.beyond, factor))
    heads = ("stones", "measure", "falls a year", f"P(stands {found.years:g} years)", "share of the class that stands")
    more = ("of the falls, beyond the records", "largest factor on the hazard")
    return Section("What has stood", (table((*heads, *more), lines, "tttt%%t"),))


def _weaker_shaking_notes(found: Survival) -> Iterator[str]:
    """Yield a note for each class with more than `NEGLIGIBLE` additional falls below the first level of its hazard."""
    for curve, hazard, one in found.estimates:
        if (uncounted := fall_rate_below_curve(curve, hazard)) > NEGLIGIBLE * one.rate:
            yield (
                f"{one.stones}, {one.measure}: {percent(one.first, 1)} fall at the hazard's first level, "
                f"{hazard.level[0]:g} {hazard.unit}; weaker shaking is not counted, and would add {uncounted:.2g} "
                "falls a year down to a tenth of that level if the curve goes on as it begins: begin the hazard curve "
                "lower"
            )


def _standing_stones(upright: int, fell: int, years: float, bound: float) -> str:
    """Return the bound from the stones of a survey if none fell, else the share that stands."""
    if not math.isnan(bound):
        return (
            f"{counted(upright, 'stone')} stood {years:g} years: their rate of falls lies below {bound:.3g} a year "
            f"with {percent(BOUND_PROBABILITY)} probability; they share their earthquakes and count as one. The "
            "hazard is bounded in the line of their class alone, which is not sought by the sizes in the survey"
        )
    low, high = wilson_interval(upright, upright + fell)
    standing_share = share(upright / (upright + fell), float(low), float(high))
    return f"{upright} of {upright + fell} stones stand, {standing_share}; where some fell no bound is given"
