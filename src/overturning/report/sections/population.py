"""How many of a cemetery's stones fall: rates by record and amplitude, intensity, and fragility."""

import math

import numpy as np
import xarray as xr

from overturning.motion.jma_intensity import SURVEY_RULE
from overturning.report.blocks import Block, Disclosure, Figure, Note, Paragraph, Section, Table
from overturning.report.results import Results
from overturning.report.text import degrees, interval, number, percent
from overturning.report.words import Words
from overturning.statistics.fragility import Fragility
from overturning.study.scenes import NOMINAL
from overturning.study.sections import Population
from overturning.surveys.population import (
    fragility_curves,
    intensities,
    jma_intensities,
)

_DEGREES = (("5 upper", 5, 5.5), ("6 lower", 5.5, 6), ("6 upper", 6, 6.5), ("7", 6.5, 99))
"""Of the JMA scale, with their instrumental intensities."""


def population(results: Results) -> Section | None:
    """Fall rates of the study's population; none where it has none."""
    stones = results.study.population
    if stones is None:
        return None
    from overturning.figures.fall_rate import fall_rate_figure
    from overturning.figures.style import save, style

    found = results.populations[NOMINAL]
    curves = fragility_curves(found, results.intensity)
    jma, rates = jma_intensities(found, results.intensity), found["fall_rate"].to_numpy()
    missing = int(results.intensity["jma_intensity"].isnull().sum())
    drawing = results.drawings / "fall-rate.svg"
    whole = [one for one in curves if one.name == "all stones"]
    with style():
        levels = intensities(found, results.intensity)
        save(fall_rate_figure(found["amplitude"].to_numpy(), rates, levels, whole, jma), drawing)
    shown = "Each thin line or point is a record; PGA and PGV are medians over azimuths (RotD50)."
    scale = " Dashed: JMA 5 upper, 6 lower, 6 upper, 7; shaded: the rates from which surveys infer the last two."
    fitted: list[Block] = [_curves(curves)] if any(math.isfinite(one.median) for one in curves) else []
    unfit = [one.measure for one in whole if math.isnan(one.median)]
    fitted += (
        [Note(f"No lognormal curve fits over {' and '.join(unfit)}: the rate hardly grows with it.")] if unfit else []
    )
    blocks: list[Block] = [
        *(Paragraph(text) for text in (_as_recorded(found), *_over_intensity(rates, jma, missing))),
        Figure(drawing, "fall rate over amplitude and intensity", shown + (scale if np.isfinite(jma).any() else "")),
        Note(_assumed(stones, float(found.attrs["outside"]), results.words)),
        *fitted,
        Disclosure("By record", (_by_record(results, found), *_by_amplitude(results, found))),
    ]
    return Section("How many stones of a cemetery fall", tuple(blocks), anchor="population")


def _as_recorded(found: xr.Dataset) -> str:
    own = found.sel(amplitude=1.0)
    rate = own["fall_rate"].to_numpy()
    low, middle, high = np.quantile(rate, [0.25, 0.5, 0.75])
    shift, turn = (float(np.median(own[f"{name}_rate"].to_numpy())) for name in ("shift", "rotation"))
    stands = f"{percent(shift)} of the stones stand shifted in the median"
    stands += f" and {percent(turn)} stand rotated" if math.isfinite(turn) else ""
    return (
        f"Under the records as they are the fall rate is {percent(middle)} in the median, {percent(low)} to "
        f"{percent(high)} "
        f"for the middle half of them, {percent(rate.min())} to {percent(rate.max())} for all; {stands}."
    )


def _over_intensity(rates: np.ndarray, jma: np.ndarray, horizontal: int) -> list[str]:
    """Which intensity goes with which rate, and how well surveys' rule does; `horizontal` records have no vertical."""
    known = np.isfinite(jma)
    inside = {text: known & (jma >= low) & (jma < high) for text, low, high in _DEGREES}
    parts = [f"{percent(float(np.median(rates[own])))} at {text}" for text, own in inside.items() if own.sum() >= 3]
    said = []
    if parts:
        have = "none of the records has" if horizontal == len(rates) else f"{horizontal} of the records lack"
        of = f" ({have} a vertical component, which would add about 0.1)" if horizontal else ""
        said.append(
            f"The median fall rate over records and amplitudes, by JMA instrumental intensity{of}: {'; '.join(parts)}."
        )
    rules = []
    for low, high, least, most, text in SURVEY_RULE:
        own = known & (rates >= low) & ((rates < high) | (high >= 1))
        if own.sum() >= 3:
            hit, above = (
                float(np.mean(share)) for share in ((jma[own] >= least) & (jma[own] < most), jma[own] >= most)
            )
            ends = f"{100 * low:.0f} to {100 * high:.0f} %" if high < 1 else f"{100 * low:.0f} % or more"
            beyond = f", in {percent(above)} it is higher" if most < 99 else ""
            rules.append(
                f"where {ends} fall, which they take for {text}, the instrumental intensity is "
                f"{number(float(np.median(jma[own])), 1)} "
                f"in the median, and is of that degree in {percent(hit)} of {int(own.sum())} motions{beyond}"
            )
    if rules:
        said.append(f"Surveys infer the intensity from the rate of fallen stones: {'; '.join(rules)}.")
    return said


def _assumed(stones: Population, outside: float, words: Words) -> str:
    fixed = f"{percent(stones.fixed)} are fixed and, as in surveys, not counted: rate = fallen/(all − fixed)"
    fixed = fixed if stones.fixed else "none is fixed to its base"
    looks = "any way" if stones.face is None else f"towards {stones.face:g}° ± {stones.face_spread:g}°"
    beyond = f" {percent(outside)} of them lie beyond the study's grid and take its nearest value." if outside else ""
    turned = words.stone_turns.format(stones.rotated)
    return (
        f"{stones.stones} stones of square footprint, {stones.width.low:g} to {stones.width.high:g} m wide and "
        f"{stones.height.low:g} to {stones.height.high:g} m high, µ {stones.friction.low:g} to "
        f"{stones.friction.high:g}, faces "
        f"looking {looks}; {fixed}. A "
        f"stone {words.stone_falls} in the cell of the cube that is like it, of two neighbours by lot.{beyond} "
        "Shifted: it "
        f"stands, its base moved by {100 * stones.shifted:g} cm or more. {turned} Intervals are those of a cemetery of "
        "so many "
        "stones (95 %, Wilson)."
    )


def _curves(curves: list[Fragility]) -> Table:
    rows = tuple(
        (one.name, f"{one.measure}, {one.unit}", number(one.median), interval(*one.median_interval), number(one.spread))
        for one in curves
        if math.isfinite(one.median)
    )
    heads = ("stones", "measure", "half of them fall at", "95 % interval", "spread of the logarithm")
    return Table(heads, rows, "tt", anchor="fragility")


def _share(own: xr.Dataset, rate: str, ends: str) -> str:
    low, high = own[ends].to_numpy()
    value = float(own[rate])
    return "–" if math.isnan(value) else f"{percent(value)} ({100 * low:.0f} to {100 * high:.0f})"


def _by_record(results: Results, found: xr.Dataset) -> Table:
    """Rates as recorded, with intervals, and the octant into which most stones fell."""
    outcomes = [("fell", "fall"), ("shifted", "shift"), *([("rotated", "rotation")] if results.model.twists else [])]
    rows = []
    for index, name in enumerate(results.names):
        own = found.isel(record=index).sel(amplitude=1.0)
        most = own.isel(octant=int(np.argmax(own["fall_octant"].to_numpy())))
        fell = float(own["fall_rate"]) > 0
        rows.append((
            name.heading, *(_share(own, f"{what}_rate", f"{what}_interval") for _, what in outcomes),
            degrees(float(most["octant"])) if fell else "–",
            _share(most, "fall_octant", "octant_interval") if fell else "–",
        ))  # fmt: skip
    heads = (
        "record",
        *(f"{text}, % (95 %)" for text, _ in outcomes),
        "most fell towards ± 22.5°",
        "share of all (95 %)",
    )
    return Table(heads, tuple(rows), "t", sortable=True)


def _by_amplitude(results: Results, found: xr.Dataset) -> tuple[Table, ...]:
    amplitude = found["amplitude"].to_numpy()
    if amplitude.size == 1:
        return ()
    rows = tuple(
        (name.heading, *(percent(float(value)) for value in rates))
        for name, rates in zip(results.names, found["fall_rate"].to_numpy(), strict=True)
    )
    return (Table(("fall rate of the record", *(f"× {factor:g}" for factor in amplitude)), rows, "t", sortable=True),)
