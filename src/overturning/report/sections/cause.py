"""What makes a block fall: peak acceleration and velocity, shape and size."""

import math

from overturning.figures.style import short
from overturning.report.blocks import Block, Column, Figure, Note, Paragraph, Section, Table, number_columns
from overturning.report.results import Results
from overturning.report.text import counted, interval, number
from overturning.statistics.logistic import LogisticFit, describe, overturning_fit

DOUBLED = {1: "PGA, and PGV with it,", 2: "PGV alone", 4: "the size of a block alone"}
"""What doubles where a predictor of `statistics.logistic.overturning_fit` grows by ln 2, by its place."""


def cause(results: Results) -> Section:
    """Falls in the plane of PGA and PGV/PGA, and the logistic fit."""
    fit = overturning_fit(results.cube, results.intensity)
    figure = Figure(
        results.figures / "plane.svg",
        "falls in the plane of PGA and PGV/PGA",
        "Each point is one plane of one record. West: a block cannot rock below a = g B/H. Ishiyama: below this peak velocity "
        "a rocking block does not overturn.",
        width=0.92,
    )
    blocks: list[Block] = [figure]
    if sentence := doubling_sentence(fit):
        blocks.append(Paragraph(sentence))
    if fit.note:
        blocks.append(Paragraph(f"{fit.note[:1].upper()}{fit.note[1:]}."))
    if not fit.note.startswith("no fit"):
        blocks.append(_table(fit))
        blocks.append(
            Note(
                f"Logistic fit of the probability of overturning to {fit.rows:,} planes and cases of "
                f"{counted(fit.clusters, 'earthquake')}; intervals clustered by earthquake. PGV/PGA in s, H in m. It says "
                "nothing outside the range of the data."
            )
        )
    return Section("What makes a block fall", tuple(blocks), anchor="intensity")


def _table(fit: LogisticFit) -> Table:
    rows = []
    for entry in describe(fit):
        value, low, high, least, most = (
            float(entry[name])  # type: ignore[arg-type]
            for name in ("coefficient", "low", "high", "minimum", "maximum")
        )
        rows.append((str(entry["name"]), number(value), interval(low, high), interval(least, most)))
    columns = number_columns("coefficient", "95 % interval", "range of the data")
    return Table((Column("predictor", "text"), *columns), tuple(rows))


def doubling_sentence(fit: LogisticFit) -> str:
    """What doubling the motion or the block does to the odds of a fall; empty where nothing was fitted.

    Parameters
    ----------
    fit : LogisticFit
        From `statistics.logistic.overturning_fit`.

    Returns
    -------
    str
    """
    parts = []
    for place, what in DOUBLED.items():
        factor, low, high = (2.0 ** float(values[place]) for values in (fit.coefficient, fit.low, fit.high))
        if not math.isnan(factor):
            known = "" if math.isnan(low) else f" ({short(low)} to {short(high)})"
            parts.append(f"by {short(factor)}{known} where {what} doubles")
    return f"The odds of a fall are multiplied {'; '.join(parts)}." if parts else ""
