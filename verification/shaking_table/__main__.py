"""`python -m verification.shaking_table FOLDER`: compare predictions with shaking-table tests.

The results go into docs/shaking-table.md.
"""

from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Annotated

import numpy as np
import pandas as pd
import typer

from overturning.arrays import FloatArray
from overturning.errors import ResultError
from overturning.model.contact import DEFAULT_CONTACT_DAMPING_RATIO
from verification.shaking_table import page
from verification.shaking_table.clouds import (
    PRISM_DISTRIBUTION,
    RECTANGLE_DISTRIBUTION,
    StonesWithSimulatedOutcomes,
    simulate_random_stones_or_read_outcomes,
)
from verification.shaking_table.data import SPECIMEN_NUMBERS, ShakingTableTests, read_shaking_table_tests
from verification.shaking_table.models import (
    PGA_PGV_LOGISTIC_MODEL_NAME,
    PRISMS_MODEL_NAME,
    RECTANGLES_MODEL_NAME,
    fall_prediction_models_by_name,
    predict_unseen_tests,
    smoothed_fall_shares_by_size_and_test,
    split_into_odd_learning_and_even_predicted_tests,
    splits_leaving_out_one_motion,
)
from verification.shaking_table.scores import (
    BOOTSTRAP_SAMPLE_COUNT,
    SCORE_NAMES,
    bootstrap_interval_over_motions,
    bootstrap_samples_of_test_indices,
    f1_auc_and_brier_score,
)
from verification.tables import RESULT_TABLE_FOLDER, ROOT, update_marked_tables_and_sentences_in_docs, write_csv

TEST_SPLIT_FUNCTION_BY_NAME = {
    "odd to even": split_into_odd_learning_and_even_predicted_tests,
    "motion left out": splits_leaving_out_one_motion,
}
_LOW, _HIGH = (DEFAULT_CONTACT_DAMPING_RATIO * end for end in RECTANGLE_DISTRIBUTION.bounds_by_parameter["damping"])
DAMPING_RATIO_CLASS_BOUNDS = np.geomspace(_LOW, _HIGH, 5)
"""Bounds of the four classes of damping ratio."""


def model_scores_with_intervals_and_predictions(
    tests: ShakingTableTests,
    size_neighbourhood_fall_shares_by_model: Mapping[str, FloatArray],
    bootstrap_sample_count: int = BOOTSTRAP_SAMPLE_COUNT,
) -> tuple[pd.DataFrame, dict[tuple[str, str, int], FloatArray]]:
    """Return a table of scores with bootstrap intervals, and fall probabilities by split, model and specimen.

    A split divides the tests into tests to learn from and tests to predict. `size_neighbourhood_fall_shares_by_model`
    are the shares of `smoothed_fall_shares_by_size_and_test`, by model name.
    """
    rows, probabilities = [], {}
    for split, divide in TEST_SPLIT_FUNCTION_BY_NAME.items():
        for specimen in SPECIMEN_NUMBERS:
            fell = tests.fell_by_specimen[specimen]
            held = {
                name: predict_unseen_tests(model, specimen, divide(tests), fell.size)
                for name, model in fall_prediction_models_by_name(
                    tests,
                    size_neighbourhood_fall_shares_by_model[RECTANGLES_MODEL_NAME],
                    size_neighbourhood_fall_shares_by_model[PRISMS_MODEL_NAME],
                ).items()
            }
            known = np.isfinite(held[PGA_PGV_LOGISTIC_MODEL_NAME])
            samples = bootstrap_samples_of_test_indices(tests.played_record_names[known], bootstrap_sample_count)
            motion_count = np.unique(tests.played_record_names[known]).size
            outcome, predicted = fell[known], {name: p[known] for name, p in held.items()}
            drawn = {
                name: np.array([f1_auc_and_brier_score(p[s], outcome[s]) for s in samples])
                for name, p in predicted.items()
            }
            for name, p in held.items():
                probabilities[split, name, specimen] = p
                found = f1_auc_and_brier_score(predicted[name], outcome)
                for place, what in enumerate(SCORE_NAMES):
                    low, high = bootstrap_interval_over_motions(drawn[name][:, place], motion_count)
                    over = bootstrap_interval_over_motions(
                        drawn[name][:, place] - drawn[PGA_PGV_LOGISTIC_MODEL_NAME][:, place], motion_count
                    )
                    rows.append({
                        "split": split, "specimen": specimen, "model": name, "score": what,
                        "value": found[place], "low": low, "high": high,
                        "over_logistic_low": over[0], "over_logistic_high": over[1], "tests": int(known.sum()),
                    })  # fmt: skip
    return pd.DataFrame(rows), probabilities


def counts_and_scores_of_rectangles_by_damping_class(
    tests: ShakingTableTests, stones: StonesWithSimulatedOutcomes
) -> dict[str, tuple[int, FloatArray]]:
    """Return, by class of damping ratio, the number of random rectangles and the scores of a model that uses them.

    The model learns from odd-numbered tests and predicts the others; the scores have the shape (specimens, scores).
    """
    found: dict[str, tuple[int, FloatArray]] = {}
    ratio = stones.damping_ratio_over_default * DEFAULT_CONTACT_DAMPING_RATIO
    for low, high in pairwise(DAMPING_RATIO_CLASS_BOUNDS):
        own = (low <= ratio) & (ratio < high)
        part = StonesWithSimulatedOutcomes(
            stones.b_over_h[own],
            stones.height[own],
            stones.damping_ratio_over_default[own],
            stones.fell_by_test_and_stone[:, own],
        )
        fractions = smoothed_fall_shares_by_size_and_test(part)
        model, rows = fall_prediction_models_by_name(tests, fractions, fractions)[RECTANGLES_MODEL_NAME], []
        for specimen in SPECIMEN_NUMBERS:
            fell = tests.fell_by_specimen[specimen]
            p = predict_unseen_tests(
                model, specimen, split_into_odd_learning_and_even_predicted_tests(tests), fell.size
            )
            rows.append(f1_auc_and_brier_score(p[np.isfinite(p)], fell[np.isfinite(p)]))
        found[f"{low:.1f} to {high:.1f}"] = int(own.sum()), np.array(rows)
    return found


def main(
    folder: Annotated[Path, typer.Argument(help="folder with tests.npz; for its source see docs/shaking-table.md")],
    kept: Annotated[Path, typer.Option(help="folder for results that take long to compute")] = Path(
        "results/shaking-table"
    ),
    threads: Annotated[int, typer.Option(min=1, help="threads")] = 2,
) -> None:
    """Run every stone under every test, fit the models, predict tests, and write tables and figures."""
    try:
        tests = read_shaking_table_tests(folder)
    except ResultError as error:
        print(f"skipped: {error}")
        return
    kinds = {RECTANGLES_MODEL_NAME: RECTANGLE_DISTRIBUTION, PRISMS_MODEL_NAME: PRISM_DISTRIBUTION}
    made = {
        name: simulate_random_stones_or_read_outcomes(kind, tests, kept, threads=threads)
        for name, kind in kinds.items()
    }
    fractions = {name: smoothed_fall_shares_by_size_and_test(one) for name, one in made.items()}
    rows, probabilities = model_scores_with_intervals_and_predictions(tests, fractions)
    write_csv(rows, RESULT_TABLE_FOLDER / "shaking-table.csv")
    page.draw_reliability_diagrams(tests, probabilities, ROOT / "docs" / "images" / "shaking-table-reliability.svg")
    update_marked_tables_and_sentences_in_docs(
        page.markdown_by_marker(tests, fractions, rows)
        | page.damping_score_table_by_marker(
            counts_and_scores_of_rectangles_by_damping_class(tests, made[RECTANGLES_MODEL_NAME])
        )
    )


if __name__ == "__main__":
    typer.run(main)
