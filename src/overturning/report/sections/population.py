"""How many of a cemetery's stones fall, by record, amplitude and intensity."""

import math
from collections.abc import Iterator
from functools import partial
from typing import Final

import numpy as np
import xarray as xr

from overturning.figures.fall_rate import fall_rate_figure
from overturning.findings.population import (
    MotionCount,
    PopulationFindings,
    ShareOfMotions,
    SurveyRuleCheck,
    population_findings,
)
from overturning.labels import azimuth_gap_label
from overturning.report.blocks import Caution, Disclosure, Figure, Note, Said, Table, section, table
from overturning.report.results import Results
from overturning.report.text import censored, counted, degrees, number, percent, share
from overturning.report.words import Words
from overturning.settings import Population
from overturning.study.scenes import NOMINAL
from overturning.surveys.population import record_intensities, record_jma_intensities

MUCH_OUTSIDE: Final = 0.2
"""Share of the stones beyond the study's grid from which their rates are said not to be their own."""

_BEYOND: Final = (
    "{} of the stones are larger or smaller, slenderer or stouter, rougher or smoother than any block of the study and "
    "do what its nearest one does: these rates and curves are not theirs. Widen height, b_over_h and friction of the "
    "study."
)


@section("How many stones of a cemetery fall", "population")
def population(results: Results) -> Said:
    """Fall rates of the study's population; none where it has none."""
    stones = results.study.population
    if stones is None:
        return
    found = results.populations[NOMINAL]
    curves, numbers = results.fragility_curves, population_findings(results)
    assert numbers is not None
    jma, rates = record_jma_intensities(found, results.intensity), found["fall_rate"].to_numpy()
    whole = [one for one in curves if one.name == "all stones"]
    levels = record_intensities(found, results.intensity)
    draw = partial(fall_rate_figure, found["amplitude"].to_numpy(), rates, levels, whole, jma)
    caption = "Each thin line or point is a record; PGA and PGV are medians over azimuths (RotD50)."
    caption += " Red: the lognormal curve." if any(math.isfinite(one.median) for one in whole) else ""
    scale = " Dashed: where JMA 5 upper, 6 lower, 6 upper and 7 begin; shaded: what surveys infer the last two from."
    caption += scale if np.isfinite(jma).any() else ""
    yield _as_recorded(numbers)
    yield _unanswered(numbers)
    yield from _over_intensity(numbers, found.sizes["record"])
    yield from caution(found)
    yield Figure(results.drawn("fall-rate", draw), "fall rate over amplitude and intensity", caption)
    yield Note(_assumed(stones, float(found.attrs["outside"]), results.words, azimuth_gap_label(results.cube)))
    fitted = []
    for one in curves:
        if math.isfinite(one.median):
            median, ends, spread = one.within_data
            half = censored(median, *ends, one.least, one.most)
            fitted.append((one.name, f"{one.measure}, {one.unit}", *half, spread, *one.spread_components))
    if fitted:
        heads = ["stones", "measure", "half of them fall at", "95 % interval", "spread of the logarithm"]
        yield table([*heads, "from record to record", "all other"], fitted, "ttnn222", anchor="fragility")
    if unfit := [one.measure for one in whole if math.isnan(one.median)]:
        why = "the rate hardly grows with it, or leaps from 0 to 100 %"
        yield Note(f"No lognormal curve fits over {' and '.join(unfit)}: {why}.")
    by_record, amplitude = [_by_record(results, found)], found["amplitude"].to_numpy()
    if amplitude.size > 1:
        heads = ["fall rate of the record", *(f"× {factor:g}" for factor in amplitude)]
        each = [(name.heading, *of_record) for name, of_record in zip(results.record_names, rates, strict=True)]
        by_record.append(table(heads, each, "t" + "%" * amplitude.size, sortable=True))
    yield Disclosure("By record", tuple(by_record))


def caution(found: xr.Dataset) -> tuple[Caution, ...]:
    """That the rates are not those of the population, where many of its stones lie beyond the study's grid."""
    outside = float(found.attrs["outside"])
    return (Caution(_BEYOND.format(percent(outside))),) if outside > MUCH_OUTSIDE else ()


def _as_recorded(numbers: PopulationFindings) -> str:
    """Fall rates under the records, and how many stones that stand moved, where the model can tell.

    Where all stones fall none stands shifted, which says nothing of the other records.
    """
    if numbers.median_fall_rate is None:
        return "Under the records as they are no stone has an answer."
    low, middle, high, least, most = (
        percent(one)
        for one in (numbers.lower_quartile_fall_rate, numbers.median_fall_rate, numbers.upper_quartile_fall_rate,
                    numbers.smallest_fall_rate, numbers.largest_fall_rate)
        if one is not None
    )  # fmt: skip
    stands = ""
    if numbers.median_share_shifted is not None and numbers.median_share_rotated is not None:
        shifted, rotated = percent(numbers.median_share_shifted), percent(numbers.median_share_rotated)
        stands = f"; {shifted} of the stones stand shifted in the median and {rotated} stand rotated"
    return (
        f"Under the records as they are the fall rate is {middle} in the median, {low} to {high} for the middle half "
        f"of them, {least} to {most} for all{stands}."
    )


def _unanswered(numbers: PopulationFindings) -> str:
    """How many stones the rates leave out since a cell that answers for them has no outcome; empty of none."""
    if not numbers.largest_share_without_outcome or numbers.mean_share_without_outcome is None:
        return ""
    mean, most = percent(numbers.mean_share_without_outcome), percent(numbers.largest_share_without_outcome)
    return f"Rates are of the stones with an answer: {mean} of them have none in the mean, {most} under one record."


def _over_intensity(numbers: PopulationFindings, records: int) -> Iterator[str]:
    """Which intensity goes with which rate, and how well surveys' rule does."""
    lacking, added = numbers.records_without_vertical, f"{numbers.vertical_intensity_increment:g}"
    parts = [
        f"{_percent(one.median_fall_rate)} at {one.jma_degree} ({_motions(one.count)})" for one in numbers.by_intensity
    ]
    if parts:
        lack = f"{lacking} of the records {'lacks' if lacking == 1 else 'lack'}"
        have = "none of the records has" if lacking == records else lack
        of = f" ({have} a vertical component, which would add about {added})" if lacking else ""
        scale = f"JMA instrumental intensity{of}"
        yield f"The median fall rate over records and amplitudes, by {scale}: {'; '.join(parts)}."
    rules = [_rule(one, added) for one in numbers.survey_rules]
    if rules:
        yield (
            f"Surveys infer the intensity from the rate of fallen stones: {'; '.join(rules)}. Intervals: 95 %, over "
            "earthquakes, exact where all of these agree."
        )


def _rule(one: SurveyRuleCheck, added: str) -> str:
    """One rule of surveys beside the instrumental intensity, as part of a sentence."""
    more = f"{100 * one.fall_rate_from:.0f} % or more"
    ends = (
        more
        if math.isinf(one.fall_rate_below)
        else f"{100 * one.fall_rate_from:.0f} to {100 * one.fall_rate_below:.0f} %"
    )
    beyond = f", higher in {_share_of(one.share_higher)}" if one.share_higher else ""
    corrected, with_vertical = one.share_agreeing_with_vertical, ""
    if corrected:
        with_vertical = f"; with {added} for the vertical component of that degree in {_share_of(corrected)}"
    return (
        f"where {ends} fall, which they take for {one.inferred_jma_degree}, the instrumental intensity is "
        f"{number(_known(one.median_jma_intensity), 1)} in the median, and is of that degree in "
        f"{_share_of(one.share_agreeing)} of {_motions(one.count)}{beyond}{with_vertical}"
    )


def _motions(of: MotionCount) -> str:
    """How many motions are of how many records and earthquakes."""
    return f"{of.motions} motions, {counted(of.records, 'record')} of {counted(of.earthquakes, 'earthquake')}"


def _known(value: float | None) -> float:
    return math.nan if value is None else value


def _percent(value: float | None) -> str:
    return percent(_known(value))


def _share_of(one: ShareOfMotions) -> str:
    return share(_known(one.value), _known(one.low), _known(one.high))


def _assumed(stones: Population, outside: float, words: Words, gaps: str) -> str:
    fixed = f"{percent(stones.fixed)} are fixed and, as in surveys, not counted: rate = fallen/(all − fixed)"
    fixed = fixed if stones.fixed else "none is fixed to its base"
    looks = "any way" if stones.face is None else f"towards {stones.face:g}° ± {stones.face_spread:g}°"
    beyond = f" {percent(outside)} of them lie beyond the study's grid and take its nearest value." if outside else ""
    beyond += f" No plane {gaps} was computed: a face that looks there falls as in the nearest plane." if gaps else ""
    stays = words.stone_stays.format(100 * stones.shifted, stones.rotated)
    return (
        f"{stones.stones} stones of square footprint, {stones.width.low:g} to {stones.width.high:g} m wide and "
        f"{stones.height.low:g} to {stones.height.high:g} m high, µ {stones.friction.low:g} to "
        f"{stones.friction.high:g}, faces looking {looks}; {fixed}. A stone {words.stone_falls} in the cell of the "
        f"cube that is like it, of two neighbours by lot.{beyond} {stays} Intervals are those of a "
        "cemetery of so many stones (95 %, Wilson)."
    )


def _share(own: xr.Dataset, rate: str, ends: str) -> str:
    return share(float(own[rate]), *own[ends].to_numpy())


def _by_record(results: Results, found: xr.Dataset) -> Table:
    """Rates as recorded, with intervals, and the octant into which most stones fell."""
    outcomes = {"fell": "fall"} | ({"shifted": "shift", "rotated": "rotation"} if results.model.twists else {})
    rows = []
    for index, name in enumerate(results.record_names):
        own = found.isel(record=index).sel(amplitude=1.0)
        most = own.isel(octant=int(np.argmax(own["fall_octant"].to_numpy())))
        towards = (degrees(float(most["octant"])), _share(most, "fall_octant", "octant_interval"))
        shares = (_share(own, f"{what}_rate", f"{what}_interval") for what in outcomes.values())
        rows.append((name.heading, *shares, *(towards if float(own["fall_rate"]) > 0 else "––")))
    shown = (f"{text}, % (95 %)" for text in outcomes)
    heads = ("record", *shown, "most fell towards ± 22.5°", "share of all (95 %)")
    return table(heads, rows, "t", sortable=True)
