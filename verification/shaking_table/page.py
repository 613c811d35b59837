"""The page of the shaking-table tests: tables between marks, and the reliability diagram."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from overturning.arrays import FloatArray
from overturning.figures.style import DASHED, INK, SERIES, caption, grid, labels, save, style
from verification.shaking_table.data import SPECIMENS, Tests
from verification.shaking_table.models import (
    B_OVER_H,
    BOTH,
    ENSEMBLE,
    HEIGHT,
    PEAKS,
    SPACE,
    most_likely_centre,
)
from verification.shaking_table.scores import NAMES, Bin, reliability
from verification.tables import lines_of, markdown

MODELS: Final = (PEAKS, ENSEMBLE, BOTH, SPACE)
SPLIT: Final = "motion left out"
AIMED: Final = (0.93, 0.91)
"""F1 of each specimen."""
CLAIMS: Final = {
    ENSEMBLE: "a better value of every score than the logistic of PGA and PGV for both specimens",
    BOTH: "F1 of at least .93 and .91, from odd to even",
}


def draw_reliability(tests: Tests, probabilities: Mapping[tuple[str, str, int], FloatArray], path: Path) -> None:
    """Draw share fallen over held-out probability, a panel for each model and specimen."""
    with style():
        figure, panels = grid(len(SPECIMENS), len(MODELS), 10.4, 5.6)
        for row, specimen in enumerate(SPECIMENS):
            for column, model in enumerate(MODELS):
                bins = reliability(probabilities[SPLIT, model, specimen], tests.fell[specimen], tests.motion)
                _draw_bins(panels[row, column], bins)
                panels[row, column].set_title(f"{model}\nspecimen {specimen}", fontsize=8)
        for axes in panels.ravel():
            labels(axes, "held-out probability of falling", "share that fell")
            axes.label_outer()
        caption(figure, "Reliability, each motion foretold from the others; 95 % intervals by motion")
        save(figure, path)


def _draw_bins(axes: Any, bins: list[Bin]) -> None:
    axes.plot([0, 1], [0, 1], color=INK, linewidth=0.9, linestyle=DASHED)
    x, y = [one.probability for one in bins], [one.fell for one in bins]
    spread = [[one.fell - one.low for one in bins], [one.high - one.fell for one in bins]]
    axes.errorbar(x, y, yerr=np.maximum(spread, 0), color=SERIES[0], marker="o", markersize=4, capsize=2, linewidth=1)
    for one in bins:
        axes.annotate(
            str(one.tests), (one.probability, one.fell), xytext=(4, -10), textcoords="offset points", fontsize=7
        )
    axes.set(xlim=(-0.03, 1.03), ylim=(-0.03, 1.03))
    axes.grid(True)


def bodies(tests: Tests, fractions: Mapping[str, FloatArray], rows: pd.DataFrame) -> dict[str, str]:
    """Text by mark; `fractions` are the shares of the neighbourhoods by model."""
    return of_scores(rows) | {"shaking-table-centres": _centres(tests, fractions)}


def of_scores(rows: pd.DataFrame) -> dict[str, str]:
    """The tables that are made of the kept scores alone, by their marks."""
    return {"shaking-table-scores": _scores(rows), "shaking-table-aims": _aims(rows)}


def damping(found: Mapping[float, FloatArray]) -> dict[str, str]:
    """The table of scores by damping ratio, by its mark."""
    head = ("ξ", *(f"{name}, specimen {specimen}" for specimen in SPECIMENS for name in NAMES))
    lines = [(f"{ratio:g}", *(f"{value:.3f}" for value in rows.ravel())) for ratio, rows in found.items()]
    return {"shaking-table-damping": markdown(head, lines)}


def _scores(rows: pd.DataFrame) -> str:
    lines = []
    for (split, specimen, model), own in rows.groupby(["split", "specimen", "model"], sort=False):
        by_score = {one.score: one for one in lines_of(own)}
        cells = [
            f"{by_score[name].value:.3f} ({by_score[name].low:.2f} to {by_score[name].high:.2f})" for name in NAMES
        ]
        lines.append((split, specimen, model, *cells, int(own["tests"].iloc[0])))
    return markdown(("split", "specimen", "model", *NAMES, "tests"), lines)


def _row(rows: pd.DataFrame, split: str, specimen: int, model: str, name: str) -> Any:
    own = rows[
        (rows["split"] == split) & (rows["specimen"] == specimen) & (rows["model"] == model) & (rows["score"] == name)
    ]
    return next(lines_of(own))


def _aims(rows: pd.DataFrame) -> str:
    """Whether each aim is met, with the figures that miss it."""
    lines = []
    for split in dict.fromkeys(rows["split"]):
        missed, sure = [], 0
        for specimen in SPECIMENS:
            for name in NAMES:
                one = _row(rows, split, specimen, ENSEMBLE, name)
                own, other = one.value, _row(rows, split, specimen, PEAKS, name).value
                sure += one.over_logistic_low > 0 or one.over_logistic_high < 0
                if (own >= other) if name == "Brier score" else (own <= other):
                    missed.append(f"{name} of specimen {specimen}: {own:.3f} against {other:.3f}")
        all_ = len(SPECIMENS) * len(NAMES)
        outcome = "met" if not missed else f"missed ({'; '.join(missed)})"
        outcome += f"; the interval of the difference leaves out 0 in {sure} of {all_}"
        lines.append((f"{ENSEMBLE}: {CLAIMS[ENSEMBLE]}, {split}", outcome))
    reached, told = [], []
    for specimen, aimed in zip(SPECIMENS, AIMED, strict=True):
        own = _row(rows, "odd to even", specimen, BOTH, "F1")
        reached.append(own.value >= aimed)
        told.append(f"{own.value:.3f}, interval {own.low:.2f} to {own.high:.2f}")
    lines.append((f"{BOTH}: {CLAIMS[BOTH]}", f"{'met' if all(reached) else 'missed'} ({'; '.join(told)})"))
    return markdown(("aim", "outcome"), lines)


def _centres(tests: Tests, fractions: Mapping[str, FloatArray]) -> str:
    """The stones that suit the odd-numbered tests best."""
    learn = np.flatnonzero(tests.number % 2 == 1)
    lines = []
    for model, shares in fractions.items():
        for specimen in SPECIMENS:
            shape, size = divmod(most_likely_centre(shares, tests.fell[specimen], learn), HEIGHT.size)
            lines.append((model, specimen, f"{B_OVER_H[shape]:.2f}", f"{HEIGHT[size]:.2f}"))
    return markdown(("model", "specimen", "B/H", "H, m"), lines)
