"""How many of a cemetery's stones fall: rates by record and amplitude, intensity, and fragility."""

import math

import numpy as np
import xarray as xr

from overturning.report.blocks import Block, Disclosure, Figure, Note, Paragraph, Section, Table
from overturning.report.results import Results
from overturning.report.text import interval, number, percent
from overturning.statistics.fragility import Fragility
from overturning.study.population import Population
from overturning.surveys.population_file import fragility_curves, intensities, jma_intensities


def population(results: Results) -> Section | None:
    """Fall rates of the study's population; none where it has none."""
    found, stones = results.population, results.study.population
    if found is None or stones is None:
        return None
    from overturning.figures.fall_rate import fall_rate_figure
    from overturning.figures.style import save, style

    curves = fragility_curves(found, results.intensity)
    jma, rates = jma_intensities(found, results.intensity), found["fall_rate"].to_numpy()
    drawing = results.drawings / "fall-rate.svg"
    whole = [one for one in curves if one.name == "all stones"]
    with style():
        levels = intensities(found, results.intensity)
        save(fall_rate_figure(found["amplitude"].to_numpy(), rates, levels, whole, jma), drawing)
    shown = "Each thin line or point is a record; PGA and PGV are medians over azimuths (RotD50)"
    scale = ". Dashed: JMA 5 upper, 6 lower, 6 upper, 7." if np.isfinite(jma).any() else "."
    blocks: list[Block] = [
        *(Paragraph(text) for text in _sentences(found, jma)),
        Figure(drawing, "fall rate over amplitude and intensity", shown + scale),
        Note(_assumed(stones)),
        _curves(curves),
        Disclosure("By record", (_by_record(results, found),)),
    ]
    return Section("How many stones of a cemetery fall", tuple(blocks), anchor="population")


def _sentences(found: xr.Dataset, jma: np.ndarray) -> list[str]:
    sentences = []
    amplitude = found["amplitude"].to_numpy()
    as_recorded = int(np.argmin(np.abs(np.log(amplitude))))
    rate = found["fall_rate"].to_numpy()[:, as_recorded]
    low, middle, high = np.quantile(rate, [0.25, 0.5, 0.75])
    factor = "" if amplitude[as_recorded] == 1 else f" times {amplitude[as_recorded]:g}"
    shift = float(np.median(found["shift_rate"].to_numpy()[:, as_recorded]))
    sentences.append(
        f"Under the records{factor} the fall rate is {percent(middle)} in the median, {percent(low)} to {percent(high)} for the "
        f"middle half of them, {percent(rate.min())} to {percent(rate.max())} for all; {percent(shift)} of the stones stand "
        "shifted in the median."
    )
    known = np.isfinite(jma)
    share = found["fall_rate"].to_numpy()
    parts = [
        f"{text} in {percent(float(np.median(share[known & (jma >= low) & (jma < high)])))}"
        for text, low, high in (("5 upper", 5, 5.5), ("6 lower", 5.5, 6), ("6 upper", 6, 6.5), ("7", 6.5, 99))
        if (known & (jma >= low) & (jma < high)).sum() >= 3
    ]
    if parts:
        sentences.append(f"Stones fall, in the median of records and amplitudes, at JMA intensity {'; '.join(parts)}.")
    return sentences


def _assumed(stones: Population) -> str:
    looks = "any way" if stones.face is None else f"towards {stones.face:g}° ± {stones.face_spread:g}°"
    return (
        f"{stones.stones} stones of square plan, {stones.width.low:g} to {stones.width.high:g} m wide and "
        f"{stones.height.low:g} to {stones.height.high:g} m high, µ {stones.friction.low:g} to {stones.friction.high:g}, faces "
        f"looking {looks}; {percent(stones.fixed)} are fixed and, as in surveys, not counted: rate = fallen/(all − fixed). A "
        "stone falls if it falls in one of the planes of its faces. Shifted: it stands, its base moved by "
        f"{100 * stones.shifted:g} cm or more. That stones turn about their vertical axis no plane can show, so there is no "
        "rate of rotated stones."
    )


def _curves(curves: list[Fragility]) -> Table:
    rows = tuple(
        (one.name, f"{one.measure}, {one.unit}", number(one.median), interval(*one.median_interval), number(one.spread))
        for one in curves
        if math.isfinite(one.median)
    )
    heads = ("stones", "measure", "half of them fall at", "95 % interval", "spread of the logarithm")
    return Table(heads, rows, "tt", anchor="fragility")


def _by_record(results: Results, found: xr.Dataset) -> Table:
    amplitude = found["amplitude"].to_numpy()
    rows = tuple(
        (name.heading, *(percent(float(value)) for value in rates))
        for name, rates in zip(results.names, found["fall_rate"].to_numpy(), strict=True)
    )
    return Table(("record", *(f"× {factor:g}" for factor in amplitude)), rows, "t", sortable=True)
