"""How many of a cemetery's stones fall, by record, amplitude and intensity."""

import math
from collections.abc import Iterator
from functools import partial
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.figures.fall_rate import fall_rate_figure
from overturning.labels import azimuth_gap_label
from overturning.motion.jma_intensity import SURVEY_RULE, VERTICAL_INTENSITY_INCREMENT, published_intensity
from overturning.report.blocks import Caution, Disclosure, Figure, Note, Said, Table, section, table
from overturning.report.results import Results
from overturning.report.text import censored, counted, degrees, number, percent, share
from overturning.report.words import Words
from overturning.settings import Population
from overturning.statistics.bootstrap import bootstrap, unanimous_share_interval
from overturning.study.scenes import NOMINAL
from overturning.surveys.population import fragility_curves, intensities, jma_intensities

_DEGREES = (("5 upper", 5, 5.5), ("6 lower", 5.5, 6), ("6 upper", 6, 6.5), ("7", 6.5, 99))
"""Of the JMA scale, with their instrumental intensities."""

MUCH_OUTSIDE: Final = 0.2
"""Share of the stones beyond the study's grid from which their rates are said not to be their own."""

_BEYOND: Final = (
    "{} of the stones are larger or smaller, slenderer or stouter, rougher or smoother than any block of the study and "
    "do what its nearest one does: these rates and curves are not theirs. Widen height, b_over_h and friction of the "
    "study."
)

BoolArray = NDArray[np.bool_]
StrArray = NDArray[np.str_]


@section("How many stones of a cemetery fall", "population")
def population(results: Results) -> Said:
    """Fall rates of the study's population; none where it has none."""
    stones = results.study.population
    if stones is None:
        return
    found, tells_moved = results.populations[NOMINAL], results.model.twists
    curves = fragility_curves(found, results.intensity)
    jma, rates = jma_intensities(found, results.intensity), found["fall_rate"].to_numpy()
    horizontal = results.intensity["jma_intensity"].isnull().to_numpy()
    whole = [one for one in curves if one.name == "all stones"]
    levels, events = intensities(found, results.intensity), found["event"].to_numpy().astype(str)
    draw = partial(fall_rate_figure, found["amplitude"].to_numpy(), rates, levels, whole, jma)
    caption = "Each thin line or point is a record; PGA and PGV are medians over azimuths (RotD50)."
    caption += " Red: the lognormal curve." if any(math.isfinite(one.median) for one in whole) else ""
    scale = " Dashed: where JMA 5 upper, 6 lower, 6 upper and 7 begin; shaded: what surveys infer the last two from."
    caption += scale if np.isfinite(jma).any() else ""
    yield _as_recorded(found, tells_moved)
    yield _unanswered(found)
    yield from _over_intensity(rates, jma, horizontal, events)
    yield from caution(found)
    yield Figure(results.drawn("fall-rate", draw), "fall rate over amplitude and intensity", caption)
    yield Note(_assumed(stones, float(found.attrs["outside"]), results.words, azimuth_gap_label(results.cube)))
    fitted = []
    for one in curves:
        if math.isfinite(one.median):
            median, ends, spread = one.within_data
            half = censored(median, *ends, one.least, one.most)
            fitted.append((one.name, f"{one.measure}, {one.unit}", *half, spread, *one.spreads))
    if fitted:
        heads = ["stones", "measure", "half of them fall at", "95 % interval", "spread of the logarithm"]
        yield table([*heads, "from record to record", "all other"], fitted, "ttnn222", anchor="fragility")
    if unfit := [one.measure for one in whole if math.isnan(one.median)]:
        why = "the rate hardly grows with it, or leaps from 0 to 100 %"
        yield Note(f"No lognormal curve fits over {' and '.join(unfit)}: {why}.")
    by_record, amplitude = [_by_record(results, found)], found["amplitude"].to_numpy()
    if amplitude.size > 1:
        heads = ["fall rate of the record", *(f"× {factor:g}" for factor in amplitude)]
        each = [(name.heading, *of_record) for name, of_record in zip(results.names, rates, strict=True)]
        by_record.append(table(heads, each, "t" + "%" * amplitude.size, sortable=True))
    yield Disclosure("By record", tuple(by_record))


def caution(found: xr.Dataset) -> tuple[Caution, ...]:
    """That the rates are not those of the population, where many of its stones lie beyond the study's grid."""
    outside = float(found.attrs["outside"])
    return (Caution(_BEYOND.format(percent(outside))),) if outside > MUCH_OUTSIDE else ()


def _as_recorded(found: xr.Dataset, tells_moved: bool) -> str:
    """Fall rates under the records, and how many stones that stand moved, where the model can tell.

    Where all stones fall none stands shifted, which says nothing of the other records.
    """
    own = found.sel(amplitude=1.0)
    rate = own["fall_rate"].dropna("record").to_numpy()
    if not rate.size:
        return "Under the records as they are no stone has an answer."
    low, middle, high = np.quantile(rate, [0.25, 0.5, 0.75])
    shift, turn = (float(own[f"{name}_rate"].median()) for name in ("shift", "rotation"))
    stands = f"; {percent(shift)} of the stones stand shifted in the median and {percent(turn)} stand rotated"
    return (
        f"Under the records as they are the fall rate is {percent(middle)} in the median, {percent(low)} to "
        f"{percent(high)} for the middle half of them, {percent(rate.min())} to {percent(rate.max())} for all"
        f"{stands if tells_moved and math.isfinite(shift) else ''}."
    )


def _unanswered(found: xr.Dataset) -> str:
    """How many stones the rates leave out since a cell that answers for them has no outcome; empty of none."""
    unknown = found["unknown"].sel(amplitude=1.0)
    if not float(unknown.max()) > 0.0:
        return ""
    mean, most = percent(float(unknown.mean())), percent(float(unknown.max()))
    return f"Rates are of the stones with an answer: {mean} of them have none in the mean, {most} under one record."


def _over_intensity(rates: FloatArray, jma: FloatArray, horizontal: BoolArray, events: StrArray) -> Iterator[str]:
    """Which intensity goes with which rate, and how well surveys' rule does; `horizontal` records have no vertical."""
    known = np.isfinite(jma) & np.isfinite(rates)
    inside = {text: known & (jma >= low) & (jma < high) for text, low, high in _DEGREES}
    parts = [
        f"{percent(float(np.median(rates[own])))} at {text} ({_motions(own, events)})"
        for text, own in inside.items()
        if own.sum() >= 3
    ]
    if parts:
        have = (
            "none of the records has"
            if horizontal.all()
            else f"{horizontal.sum()} of the records {'lacks' if horizontal.sum() == 1 else 'lack'}"
        )
        of = (
            f" ({have} a vertical component, which would add about {VERTICAL_INTENSITY_INCREMENT:g})"
            if horizontal.any()
            else ""
        )
        scale = f"JMA instrumental intensity{of}"
        yield f"The median fall rate over records and amplitudes, by {scale}: {'; '.join(parts)}."
    rules = []
    for low, high, least, most, text in SURVEY_RULE:
        own = known & (rates >= low) & ((rates < high) | (high >= 1))
        if own.sum() < 3:
            continue
        ends = f"{100 * low:.0f} to {100 * high:.0f} %" if high < 1 else f"{100 * low:.0f} % or more"
        more = jma + VERTICAL_INTENSITY_INCREMENT * horizontal[:, None]
        hits, hits_more, higher = ((own & (one >= a) & (one < b)) for one, a, b in (
            (jma, least, most), (more, least, most), (jma, most, math.inf),
        ))  # fmt: skip
        beyond = f", higher in {_share_of_motions(higher, own, events)}" if most < 99 else ""
        added = f"; with {VERTICAL_INTENSITY_INCREMENT:g} for the vertical component of that degree in "
        added = f"{added}{_share_of_motions(hits_more, own, events)}" if (own & horizontal[:, None]).any() else ""
        rules.append(
            f"where {ends} fall, which they take for {text}, the instrumental intensity is "
            f"{number(float(published_intensity(np.median(jma[own]))), 1)} in the median, and is of that degree in "
            f"{_share_of_motions(hits, own, events)} of {_motions(own, events)}{beyond}{added}"
        )
    if rules:
        yield (
            f"Surveys infer the intensity from the rate of fallen stones: {'; '.join(rules)}. Intervals: 95 %, over "
            "earthquakes, exact where all of these agree."
        )


def _motions(own: BoolArray, events: StrArray) -> str:
    """How many motions, shape (record, amplitude), are of how many records and earthquakes."""
    records = own.any(axis=1)
    of = f"{counted(int(records.sum()), 'record')} of {counted(np.unique(events[records]).size, 'earthquake')}"
    return f"{own.sum()} motions, {of}"


def _share_of_motions(hits: BoolArray, own: BoolArray, events: StrArray) -> str:
    """Share of motions with its interval over earthquakes: exact where all agree, else where there are enough."""
    records = own.any(axis=1)
    names, member = np.unique(events[records], return_inverse=True)
    counts = np.stack([np.bincount(member, each[records].sum(axis=1), names.size) for each in (hits, own)], axis=1)
    interval = unanimous_share_interval(counts[:, 0] / counts[:, 1]) or bootstrap(
        lambda drawn: drawn[..., 0].sum(axis=1) / drawn[..., 1].sum(axis=1), counts
    )
    return share(hits.sum() / own.sum(), *interval)


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
    for index, name in enumerate(results.names):
        own = found.isel(record=index).sel(amplitude=1.0)
        most = own.isel(octant=int(np.argmax(own["fall_octant"].to_numpy())))
        towards = (degrees(float(most["octant"])), _share(most, "fall_octant", "octant_interval"))
        shares = (_share(own, f"{what}_rate", f"{what}_interval") for what in outcomes.values())
        rows.append((name.heading, *shares, *(towards if float(own["fall_rate"]) > 0 else "––")))
    shown = (f"{text}, % (95 %)" for text in outcomes)
    heads = ("record", *shown, "most fell towards ± 22.5°", "share of all (95 %)")
    return table(heads, rows, "t", sortable=True)
