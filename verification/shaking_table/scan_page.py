"""`python -m verification.shaking_table.scan_page FOLDER`: predict the shaking-table tests from the boulder's scan.

The results go into docs/shaking-table.md, next to the models with two fitted numbers.
"""

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Final

import numpy as np
import pandas as pd
import typer
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import ResultError
from verification.shaking_table.clouds import (
    PRISM_DISTRIBUTION,
    RECTANGLE_DISTRIBUTION,
    simulate_random_stones_or_read_outcomes,
)
from verification.shaking_table.data import SPECIMEN_NUMBERS, ShakingTableTests, read_shaking_table_tests
from verification.shaking_table.models import (
    PGA_PGV_LOGISTIC_MODEL_NAME,
    PRISMS_MODEL_NAME,
    RECTANGLES_MODEL_NAME,
    FallPredictionModel,
    TestIndices,
    fall_prediction_models_by_name,
    predict_unseen_tests,
    smoothed_fall_shares_by_size_and_test,
    split_into_odd_learning_and_even_predicted_tests,
)
from verification.shaking_table.scan import (
    BOULDER_ORIENTATIONS_DEG,
    EXTRA_BASE_RELIEF_OUTSIDE_PREDICTION_M,
    SIMULATED_BASE_RELIEFS_M,
    index_of_most_likely_orientation,
    read_scanned_boulder,
    simulate_falls_of_boulder_by_orientation,
    smoothed_fall_probability_by_orientation_and_test,
    splits_into_halves_of_motions,
)
from verification.shaking_table.scores import (
    SCORE_NAMES,
    bootstrap_interval_over_motions,
    bootstrap_samples_of_test_indices,
    f1_auc_and_brier_score,
)
from verification.tables import (
    RESULT_TABLE_FOLDER,
    iterate_rows,
    markdown_table,
    update_marked_tables_and_sentences_in_docs,
    write_csv,
)

SCAN_MODEL_NAME: Final = "scan, orientation fitted"
TEST_SPLIT_FUNCTION_BY_NAME: Final[
    dict[str, Callable[[ShakingTableTests], Iterator[tuple[TestIndices, TestIndices]]]]
] = {
    "half of the motions": splits_into_halves_of_motions,
    "odd to even": split_into_odd_learning_and_even_predicted_tests,
}
"""Splits into tests for fitting and for prediction, by name."""

FITTED_PARAMETER_COUNT_BY_MODEL: Final = {
    PGA_PGV_LOGISTIC_MODEL_NAME: 3,
    RECTANGLES_MODEL_NAME: 2,
    PRISMS_MODEL_NAME: 2,
    SCAN_MODEL_NAME: 1,
}
"""Number of fitted numbers of each model."""


def model_with_orientation_fitted_to_other_tests(
    tests: ShakingTableTests, smoothed_fall_probability_by_orientation_and_test: FloatArray
) -> FallPredictionModel:
    """Return a model that predicts the simulated fall probability in the orientation that best fits the learning tests.

    `smoothed_fall_probability_by_orientation_and_test` has shape (orientations, tests).
    """

    def predict_with_best_orientation(
        specimen_number: int, learning_tests: TestIndices, predicted_tests: TestIndices
    ) -> FloatArray:
        """Predict fall probabilities in the orientation that best fits the tests to learn from."""
        return np.asarray(
            smoothed_fall_probability_by_orientation_and_test[
                index_of_most_likely_orientation(
                    smoothed_fall_probability_by_orientation_and_test,
                    tests.fell_by_specimen[specimen_number],
                    learning_tests,
                )
            ][predicted_tests]
        )

    return predict_with_best_orientation


def scores_on_unseen_tests(tests: ShakingTableTests, models: Mapping[str, FallPredictionModel]) -> pd.DataFrame:
    """Return the scores of every split, specimen and model on the predicted tests, with intervals over motions."""
    rows = []
    for split, divide in TEST_SPLIT_FUNCTION_BY_NAME.items():
        for specimen in SPECIMEN_NUMBERS:
            fell = tests.fell_by_specimen[specimen]
            held = {
                name: predict_unseen_tests(model, specimen, divide(tests), fell.size) for name, model in models.items()
            }
            known = np.isfinite(held[SCAN_MODEL_NAME])
            samples, motions = (
                bootstrap_samples_of_test_indices(tests.played_record_names[known]),
                np.unique(tests.played_record_names[known]).size,
            )
            for name, p in held.items():
                drawn = np.array([f1_auc_and_brier_score(p[known][one], fell[known][one]) for one in samples])
                for place, (what, value) in enumerate(
                    zip(SCORE_NAMES, f1_auc_and_brier_score(p[known], fell[known]), strict=True)
                ):
                    low, high = bootstrap_interval_over_motions(drawn[:, place], motions)
                    rows.append((split, specimen, name, what, value, low, high, int(known.sum())))
    columns = ["split", "specimen", "model", "score", "value", "low", "high", "tests"]
    return pd.DataFrame(rows, columns=columns)


def score_table(one_score_per_row: pd.DataFrame) -> str:
    """Return the table of scores as Markdown."""
    lines = []
    for (split, specimen, model), own in one_score_per_row.groupby(["split", "specimen", "model"], sort=False):
        cells = [f"{one.value:.3f} ({one.low:.2f} to {one.high:.2f})" for one in iterate_rows(own)]
        lines.append(
            (split, specimen, model, FITTED_PARAMETER_COUNT_BY_MODEL[str(model)], *cells, int(own["tests"].iloc[0]))
        )
    return markdown_table(("split", "specimen", "model", "fitted numbers", *SCORE_NAMES, "tests"), lines)


def table_of_orientation_chosen_by_each_fit(
    tests: ShakingTableTests, smoothed_fall_probability_by_orientation_and_test: FloatArray
) -> str:
    """Return a table of the orientations that best fit the odd tests, each half of the motions, and all tests."""
    names = {
        "odd-numbered tests": next(split_into_odd_learning_and_even_predicted_tests(tests))[0],
        **{
            f"{number} half of the motions": learn
            for number, (learn, _) in zip(("first", "second"), splits_into_halves_of_motions(tests), strict=True)
        },
        "all tests": np.arange(tests.laboratory_test_numbers.size),
    }

    def fitted_orientation_text(specimen_number: int, learning_tests: TestIndices) -> str:
        """Return the orientation that fits some tests of a specimen best, with its unit."""
        fell = tests.fell_by_specimen[specimen_number]
        index = index_of_most_likely_orientation(
            smoothed_fall_probability_by_orientation_and_test, fell, learning_tests
        )
        return f"{BOULDER_ORIENTATIONS_DEG[index]:g}°"

    lines = [
        (name, *(fitted_orientation_text(one, learn) for one in SPECIMEN_NUMBERS)) for name, learn in names.items()
    ]
    return markdown_table(("fitted to", *(f"orientation, specimen {one}" for one in SPECIMEN_NUMBERS)), lines)


def score_table_of_all_orientations(
    tests: ShakingTableTests, smoothed_fall_probability_by_orientation_and_test: FloatArray
) -> str:
    """Return a table of the scores of each orientation on all tests; no orientation is fitted."""
    lines = []
    for yaw, own in zip(BOULDER_ORIENTATIONS_DEG, smoothed_fall_probability_by_orientation_and_test, strict=True):
        found = [f1_auc_and_brier_score(own, tests.fell_by_specimen[one]) for one in SPECIMEN_NUMBERS]
        lines.append((f"{yaw:g}°", *(f"{value:.3f}" for scores in found for value in scores)))
    heads = (f"{what}, specimen {one}" for one in SPECIMEN_NUMBERS for what in SCORE_NAMES)
    return markdown_table(("orientation", *heads), lines)


def fall_share_table_by_max_bearing_height(
    tests: ShakingTableTests, falls_by_max_height_of_bearing_points: Mapping[float, NDArray[np.bool_]]
) -> str:
    """Return a table of the share of falls, and of F1 in the best orientation, by height limit of bearing points.

    Points of the base bear load up to this height above its lowest points. The falls for each height have shape
    (tests, orientations).
    """
    lines = []
    for relief, own in sorted(falls_by_max_height_of_bearing_points.items()):
        best = []
        for specimen in SPECIMEN_NUMBERS:
            shares = smoothed_fall_probability_by_orientation_and_test(own[None])
            chosen = index_of_most_likely_orientation(
                shares, tests.fell_by_specimen[specimen], np.arange(tests.laboratory_test_numbers.size)
            )
            best += [f"{f1_auc_and_brier_score(shares[chosen], tests.fell_by_specimen[specimen])[0]:.3f}"]
        used = "yes" if relief in SIMULATED_BASE_RELIEFS_M else "no"
        lines.append((f"{1000 * relief:.2g} mm", used, f"{own.mean():.3f}", *best))
    lines.append(
        (
            "shaking table",
            "",
            ", ".join(f"{tests.fell_by_specimen[one].mean():.3f}" for one in SPECIMEN_NUMBERS),
            "",
            "",
        )
    )
    heads = (
        "relief",
        "in the prediction",
        "share of falls",
        *(f"F1 at the best orientation, specimen {one}" for one in SPECIMEN_NUMBERS),
    )
    return markdown_table(heads, lines)


def main(
    folder: Annotated[Path, typer.Argument(help="folder with tests.npz; for its source see docs/shaking-table.md")],
    scans: Annotated[Path | None, typer.Option(help="folder with the scan SP1.ply (default: the same)")] = None,
    kept: Annotated[Path, typer.Option(help="folder for results that take long to compute")] = Path(
        "results/shaking-table"
    ),
    threads: Annotated[int, typer.Option(min=1, help="threads")] = 2,
) -> None:
    """Simulate the scanned boulder under every test, fit its orientation, predict tests, and write tables."""
    try:
        tests = read_shaking_table_tests(folder)
        boulder = read_scanned_boulder(scans or folder)
    except ResultError as error:
        print(f"skipped: {error}")
        return
    kept.mkdir(parents=True, exist_ok=True)
    fell = simulate_falls_of_boulder_by_orientation(boulder, tests, kept, threads)
    small = simulate_falls_of_boulder_by_orientation(
        boulder, tests, kept, threads, (EXTRA_BASE_RELIEF_OUTSIDE_PREDICTION_M,)
    )[0]
    by_relief = {
        **dict(zip(SIMULATED_BASE_RELIEFS_M, fell, strict=True)),
        EXTRA_BASE_RELIEF_OUTSIDE_PREDICTION_M: small,
    }
    shares = smoothed_fall_probability_by_orientation_and_test(fell)
    others = {
        name: smoothed_fall_shares_by_size_and_test(
            simulate_random_stones_or_read_outcomes(kind, tests, kept, threads=threads)
        )
        for name, kind in {RECTANGLES_MODEL_NAME: RECTANGLE_DISTRIBUTION, PRISMS_MODEL_NAME: PRISM_DISTRIBUTION}.items()
    }
    models = fall_prediction_models_by_name(tests, others[RECTANGLES_MODEL_NAME], others[PRISMS_MODEL_NAME])
    compared = {
        name: models[name] for name in (PGA_PGV_LOGISTIC_MODEL_NAME, RECTANGLES_MODEL_NAME, PRISMS_MODEL_NAME)
    } | {SCAN_MODEL_NAME: model_with_orientation_fitted_to_other_tests(tests, shares)}
    rows = scores_on_unseen_tests(tests, compared)
    write_csv(rows, RESULT_TABLE_FOLDER / "shaking-table-scan.csv")
    update_marked_tables_and_sentences_in_docs({
        "shaking-table-scan-scores": score_table(rows),
        "shaking-table-scan-fits": table_of_orientation_chosen_by_each_fit(tests, shares),
        "shaking-table-scan-orientations": score_table_of_all_orientations(tests, shares),
        "shaking-table-scan-relief": fall_share_table_by_max_bearing_height(tests, by_relief)
    })  # fmt: skip


if __name__ == "__main__":
    typer.run(main)
