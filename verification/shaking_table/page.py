"""Tables and the reliability diagram of docs/shaking-table.md."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from overturning.arrays import FloatArray
from overturning.figures.style import (
    DASHED_LINE_STYLE,
    INK,
    SERIES_COLOURS,
    add_title_and_legend,
    create_panel_grid,
    label_axes,
    use_package_matplotlib_settings,
)
from overturning.figures.write import save_figure_files
from verification.shaking_table.data import SPECIMEN_NUMBERS, ShakingTableTests
from verification.shaking_table.models import (
    ENSEMBLE_AND_PEAKS_MODEL_NAME,
    NEIGHBOURHOOD_CENTRE_B_OVER_H,
    NEIGHBOURHOOD_CENTRE_HEIGHTS_M,
    PGA_PGV_LOGISTIC_MODEL_NAME,
    PRISMS_MODEL_NAME,
    RECTANGLES_MODEL_NAME,
    index_of_most_likely_size_neighbourhood,
)
from verification.shaking_table.scores import SCORE_NAMES, ReliabilityBin, reliability_bins
from verification.tables import iterate_rows, markdown_table

MODELS_IN_RELIABILITY_DIAGRAMS: Final = (
    PGA_PGV_LOGISTIC_MODEL_NAME,
    RECTANGLES_MODEL_NAME,
    ENSEMBLE_AND_PEAKS_MODEL_NAME,
    PRISMS_MODEL_NAME,
)
TEST_SPLIT_OF_RELIABILITY_DIAGRAM: Final = "motion left out"


def draw_reliability_diagrams(
    tests: ShakingTableTests,
    probabilities_by_split_model_and_specimen: Mapping[tuple[str, str, int], FloatArray],
    path: Path,
) -> None:
    """Draw the share of tests with a fall over the predicted fall probability; a panel for each model and specimen."""
    with use_package_matplotlib_settings():
        figure, panels = create_panel_grid(len(SPECIMEN_NUMBERS), len(MODELS_IN_RELIABILITY_DIAGRAMS), 10.4, 5.6)
        for row, specimen in enumerate(SPECIMEN_NUMBERS):
            for column, model in enumerate(MODELS_IN_RELIABILITY_DIAGRAMS):
                bins = reliability_bins(
                    probabilities_by_split_model_and_specimen[TEST_SPLIT_OF_RELIABILITY_DIAGRAM, model, specimen],
                    tests.fell_by_specimen[specimen],
                    tests.played_record_names,
                )
                _draw_reliability_bins(panels[row, column], bins)
                panels[row, column].set_title(f"{model}\nspecimen {specimen}", fontsize=8)
        for axes in panels.ravel():
            label_axes(axes, "predicted probability of falling", "share that fell")
            axes.label_outer()
        add_title_and_legend(figure, "Reliability; each motion is predicted from the others; 95 % intervals by motion")
        save_figure_files(figure, path)


def _draw_reliability_bins(axes: Any, bins: list[ReliabilityBin]) -> None:
    """Draw the share of tests with a fall over the predicted fall probability, with intervals and numbers of tests."""
    axes.plot([0, 1], [0, 1], color=INK, linewidth=0.9, linestyle=DASHED_LINE_STYLE)
    x, y = [one.mean_probability for one in bins], [one.fallen_share for one in bins]
    spread = [
        [one.fallen_share - one.fallen_share_interval_low for one in bins],
        [one.fallen_share_interval_high - one.fallen_share for one in bins],
    ]
    axes.errorbar(
        x, y, yerr=np.maximum(spread, 0), color=SERIES_COLOURS[0], marker="o", markersize=4, capsize=2, linewidth=1
    )
    for one in bins:
        axes.annotate(
            str(one.test_count),
            (one.mean_probability, one.fallen_share),
            xytext=(4, -10),
            textcoords="offset points",
            fontsize=7,
        )
    axes.set(xlim=(-0.03, 1.03), ylim=(-0.03, 1.03))
    axes.grid(True)


def markdown_by_marker(
    tests: ShakingTableTests,
    size_neighbourhood_fall_shares_by_model: Mapping[str, FloatArray],
    one_score_per_row: pd.DataFrame,
) -> dict[str, str]:
    """Return the tables of docs/shaking-table.md as Markdown, by marker.

    `size_neighbourhood_fall_shares_by_model` has the results of `smoothed_fall_shares_by_size_and_test`.
    """
    return score_tables_by_marker(one_score_per_row) | {
        "shaking-table-centres": _table_of_b_over_h_and_height_fitted_to_odd_tests(
            tests, size_neighbourhood_fall_shares_by_model
        )
    }


def score_tables_by_marker(one_score_per_row: pd.DataFrame) -> dict[str, str]:
    """Return, by marker, Markdown tables of the scores and of their comparison with the logistic model."""
    return {
        "shaking-table-scores": _table_of_scores_by_split_specimen_and_model(one_score_per_row),
        "shaking-table-improvement": _count_table_of_scores_better_than_logistic(one_score_per_row),
    }


def damping_score_table_by_marker(
    stone_count_and_scores_by_damping_class: Mapping[str, tuple[int, FloatArray]],
) -> dict[str, str]:
    """Return the table of scores by damping ratio as Markdown, with its marker as key."""
    head = (
        "ξ",
        "rectangles",
        *(f"{name}, specimen {specimen}" for specimen in SPECIMEN_NUMBERS for name in SCORE_NAMES),
    )
    lines = [
        (name, count, *(f"{value:.3f}" for value in rows.ravel()))
        for name, (count, rows) in stone_count_and_scores_by_damping_class.items()
    ]
    return {"shaking-table-damping": markdown_table(head, lines)}


def _table_of_scores_by_split_specimen_and_model(one_score_per_row: pd.DataFrame) -> str:
    """Return the table of scores of each split, specimen and model."""
    lines = []
    for (split, specimen, model), own in one_score_per_row.groupby(["split", "specimen", "model"], sort=False):
        by_score = {one.score: one for one in iterate_rows(own)}
        cells = [
            f"{by_score[name].value:.3f} ({by_score[name].low:.2f} to {by_score[name].high:.2f})"
            for name in SCORE_NAMES
        ]
        lines.append((split, specimen, model, *cells, int(own["tests"].iloc[0])))
    return markdown_table(("split", "specimen", "model", *SCORE_NAMES, "tests"), lines)


def _count_table_of_scores_better_than_logistic(one_score_per_row: pd.DataFrame) -> str:
    """Return a table of how many scores of each model are better than those of the logistic model."""
    known = {(one.model, one.split, one.specimen, one.score): one for one in iterate_rows(one_score_per_row)}
    counts: dict[tuple[str, str], list[int]] = {}
    for (model, *what), one in known.items():
        if model != PGA_PGV_LOGISTIC_MODEL_NAME:
            less = one.score == "Brier score"
            over = one.value - known[PGA_PGV_LOGISTIC_MODEL_NAME, *what].value
            sure = one.over_logistic_high < 0 if less else one.over_logistic_low > 0
            found = counts.setdefault((model, one.split), [0, 0, 0])
            for place, holds in enumerate((over < 0 if less else over > 0, sure, True)):
                found[place] += bool(holds)
    lines = [(*name, f"{better} of {of}", f"{sure} of {of}") for name, (better, sure, of) in counts.items()]
    heads = ("model", "split", "scores better than those of the logistic", "significantly better (95 %)")
    return markdown_table(heads, lines)


def _table_of_b_over_h_and_height_fitted_to_odd_tests(
    tests: ShakingTableTests, size_neighbourhood_fall_shares_by_model: Mapping[str, FloatArray]
) -> str:
    """Return a table of the most likely B/H and height, fitted to the odd-numbered tests."""
    learn = np.flatnonzero(tests.laboratory_test_numbers % 2 == 1)
    lines = []
    for model, shares in size_neighbourhood_fall_shares_by_model.items():
        for specimen in SPECIMEN_NUMBERS:
            shape, size = divmod(
                index_of_most_likely_size_neighbourhood(shares, tests.fell_by_specimen[specimen], learn),
                NEIGHBOURHOOD_CENTRE_HEIGHTS_M.size,
            )
            lines.append(
                (
                    model,
                    specimen,
                    f"{NEIGHBOURHOOD_CENTRE_B_OVER_H[shape]:.2f}",
                    f"{NEIGHBOURHOOD_CENTRE_HEIGHTS_M[size]:.2f}",
                )
            )
    return markdown_table(("model", "specimen", "B/H", "H, m"), lines)
