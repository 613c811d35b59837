"""What makes a block fall: peak acceleration and velocity, shape and size."""

import math

from overturning.figures.style import short
from overturning.report.blocks import Block, Figure, Note, Paragraph, Section, Table
from overturning.report.results import Results
from overturning.report.text import counted, interval, number
from overturning.statistics.logistic import LogisticFit, describe, overturning_fit

DOUBLED = {1: "PGA, and PGV with it,", 2: "PGV alone", 4: "the size of a block alone"}
"""What doubles where a predictor of `statistics.logistic.overturning_fit` grows by ln 2, by its place."""

WIDEST = 100.0
"""An interval of odds whose ends differ by more than this factor tells nothing."""


def cause(results: Results) -> Section | None:
    """Falls in the plane of PGA and PGV/PGA, and the logistic fit; none where cases have no azimuth of their own."""
    if not results.model.one_component:
        return None
    fit = overturning_fit(results.cube, results.intensity)
    caption = (
        "Each point is one plane of one record. Lines: the field's criteria, by which a block falls to the right of "
        "them, and "
        "the fit to this study."
    )
    blocks: list[Block] = [
        Figure(results.figures / "plane.svg", "falls in the plane of PGA and PGV/PGA", caption, width=0.92)
    ]
    if sentence := doubling_sentence(fit):
        blocks.append(Paragraph(sentence))
    if fit.note:
        blocks.append(Paragraph(f"{fit.note[:1].upper()}{fit.note[1:]}."))
    if not fit.note.startswith("no fit"):
        note = (
            f"Logistic fit of the probability of overturning to {fit.rows:,} planes and blocks of "
            f"{counted(fit.clusters, 'earthquake')}; intervals clustered by earthquake. PGV/PGA in s, H in m. It says "
            "nothing outside the range of the data."
        )
        blocks += [_table(fit), Note(note)]
    return Section("What makes a block fall", tuple(blocks), anchor="intensity")


def _table(fit: LogisticFit) -> Table:
    rows = tuple(
        (name, number(value), interval(low, high), interval(least, most))
        for name, value, low, high, least, most in describe(fit)
    )
    return Table(("predictor", "coefficient", "95 % interval", "range of the data"), rows)


def doubling_sentence(fit: LogisticFit) -> str:
    """What doubling the motion or the block does to the odds of a fall; empty where nothing was fitted."""
    parts, untold = [], []
    for place, what in DOUBLED.items():
        factor, low, high = (2.0 ** float(values[place]) for values in (fit.coefficient, fit.low, fit.high))
        if math.isnan(factor):
            continue
        if high <= WIDEST * low:
            parts.append(f"by {short(factor)} ({short(low)} to {short(high)}) where {what} doubles")
        else:
            untold.append(what.strip(","))
    told = f"The odds of a fall are multiplied {'; '.join(parts)}." if parts else ""
    if not untold:
        return told
    unknown = (
        f"{counted(fit.clusters, 'earthquake')} cannot tell by how much the odds of a fall grow where "
        f"{' or '.join(untold)} doubles."
    )
    return f"{told} {unknown}".strip()
