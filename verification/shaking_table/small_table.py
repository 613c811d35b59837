"""`python -m verification.shaking_table.small_table`: predict tests of a rock on a small shaking table.

The tests are from DREAMS-lab/shakebot_motion (MIT licence, in `shakebot/`): one rock at two orientations on each of
two days, with the commanded PGA (g), PGV/PGA (s), and the outcome. The ground acceleration is one
period of PGA cos(2πFt), F = 1/(2π PGV/PGA).
"""

from pathlib import Path
from typing import Final

import numpy as np
import pandas as pd

from overturning.arrays import FloatArray
from overturning.dem.block.rigid import simulate_rigid_rocking
from overturning.model.cases import Cases
from overturning.motion.motion import Motion
from overturning.statistics.logistic import fit_logistic_model
from overturning.units import STANDARD_GRAVITY
from verification.shaking_table.models import (
    NEIGHBOURHOOD_HALF_WIDTH_LN_B_OVER_H,
    NEIGHBOURHOOD_HALF_WIDTH_LN_HEIGHT,
    TestIndices,
    index_of_most_likely_size_neighbourhood,
)
from verification.shaking_table.scores import (
    SCORE_NAMES,
    bootstrap_interval_over_motions,
    bootstrap_samples_of_test_indices,
    f1_auc_and_brier_score,
)
from verification.tables import (
    RESULT_TABLE_FOLDER,
    markdown_table,
    update_marked_tables_and_sentences_in_docs,
    write_csv,
)

SHAKING_TEST_FOLDER: Final = Path(__file__).with_name("shakebot")
DATE_AND_ORIENTATION_BY_TEST_FILE: Final = {
    "exp0": "2022-09-07, 0°", "exp270": "2022-09-07, 270°", "PBR_0": "2022-10-24, 0°", "PBR_90": "2022-10-24, 90°",
}  # fmt: skip
"""Day and orientation of the tests, by file."""

CENTRE_B_OVER_H_OF_SIMILAR_SIZE_RANGES: Final = np.geomspace(0.02, 0.6, 50)
CENTRE_HEIGHTS_OF_SIMILAR_SIZE_RANGES_M: Final = np.geomspace(0.01, 1.5, 38)
"""Centres of the neighbourhoods, which are as wide as those for the boulder: B/H, and height in m."""

INTERVAL_COLUMNS_BY_SCORE: Final = {what: (f"{what} low", f"{what} high") for what in SCORE_NAMES}

REST_TIME_BEFORE_AND_AFTER_CYCLE_S: Final = 0.5
"""Rest before and after the period, s."""


def read_small_table_tests(file_name_without_suffix: str) -> pd.DataFrame:
    """Read a file of tests, in their order: ``ratio`` (PGV/PGA, s), ``pga`` (g) and ``fell``.

    Tests with an outcome other than Y or N, or without a motion, are omitted.
    """
    rows = pd.read_csv(
        SHAKING_TEST_FOLDER / f"{file_name_without_suffix}.csv", names=["when", "ratio", "pga", "fell"], skiprows=1
    ).dropna()
    fell = rows["fell"].str.strip(".").str.upper()
    found = rows[["ratio", "pga"]].astype(float).assign(fell=fell == "Y")[fell.isin(("Y", "N"))]
    return found[(found["pga"] > 0) & (found["ratio"] > 0)].reset_index(drop=True)


def one_cosine_cycle(pga_g: float, pgv_over_pga_s: float, sampling_interval: float = 0.001) -> Motion:
    """Return the commanded motion of a test, one cycle of a cosine towards azimuth 0; PGA in g, PGV/PGA in s."""
    duration = 2.0 * np.pi * pgv_over_pga_s
    along = np.zeros(round((2.0 * REST_TIME_BEFORE_AND_AFTER_CYCLE_S + duration) / sampling_interval))
    time = sampling_interval * np.arange(along.size) - REST_TIME_BEFORE_AND_AFTER_CYCLE_S
    own = (time >= 0.0) & (time <= duration)
    along[own] = pga_g * STANDARD_GRAVITY * np.cos(time[own] / pgv_over_pga_s)
    return Motion(along, np.zeros_like(along), sampling_interval=sampling_interval)


def simulate_fall_shares_by_size_and_test(tests: pd.DataFrame) -> FloatArray:
    """Return the share of stones of similar size that fall in each test, never 0 or 1: shape (sizes, tests).

    A size is a neighbourhood: B/H and height are within a fixed logarithmic distance of a centre. The centres are all
    pairs of `CENTRE_B_OVER_H_OF_SIMILAR_SIZE_RANGES` and `CENTRE_HEIGHTS_OF_SIMILAR_SIZE_RANGES_M`; the height varies
    fastest. All blocks of a neighbourhood count equally.
    """
    grid = np.meshgrid(CENTRE_B_OVER_H_OF_SIMILAR_SIZE_RANGES, CENTRE_HEIGHTS_OF_SIMILAR_SIZE_RANGES_M, indexing="ij")
    cases = Cases(0.0, grid[1].ravel(), grid[0].ravel(), 1.0)
    pairs, of_test = np.unique(tests[["pga", "ratio"]].to_numpy(), axis=0, return_inverse=True)
    fell = np.array([simulate_rigid_rocking(one_cosine_cycle(*pair), cases).overturned != 0 for pair in pairs])
    of_pair = fell.reshape(
        len(pairs), CENTRE_B_OVER_H_OF_SIMILAR_SIZE_RANGES.size, CENTRE_HEIGHTS_OF_SIMILAR_SIZE_RANGES_M.size
    ).astype(float)
    near = [
        (np.abs(np.log(values[:, None] / values)) < width).astype(float)
        for values, width in (
            (CENTRE_B_OVER_H_OF_SIMILAR_SIZE_RANGES, NEIGHBOURHOOD_HALF_WIDTH_LN_B_OVER_H),
            (CENTRE_HEIGHTS_OF_SIMILAR_SIZE_RANGES_M, NEIGHBOURHOOD_HALF_WIDTH_LN_HEIGHT),
        )
    ]
    falls = np.einsum("bi,pij,hj->bhp", near[0], of_pair, near[1])
    members = near[0].sum(axis=1)[:, None] * near[1].sum(axis=1)
    found = (falls + 0.5) / (members[..., None] + 1.0)
    return np.asarray(found.reshape(-1, len(pairs))[:, of_test.ravel()])


def predict_each_half_from_the_other(
    tests: pd.DataFrame, fall_share_by_size_neighbourhood_and_test: FloatArray
) -> tuple[dict[str, FloatArray], list[tuple[float, float]]]:
    """Predict odd tests from even ones and the reverse; return fall probabilities by model, and fitted block sizes.

    The fitted sizes are the most likely B/H and height (m) for the odd tests, then for the even ones. Both halves are
    predicted, since the scores of a single half depend on which one it is.
    """
    fell = tests["fell"].to_numpy()
    peaks = np.log(np.column_stack([tests["pga"], tests["pga"] * tests["ratio"]]))
    made = {name: np.full(len(tests), np.nan) for name in ("logistic of PGA and PGV", "rigid block")}
    logistic, rigid = made.values()
    halves: list[TestIndices] = [np.arange(len(tests))[begin::2] for begin in (0, 1)]  # the first test is number 1
    centres = []
    for learn, other in (halves, halves[::-1]):
        fit = fit_logistic_model(
            peaks[learn],
            fell[learn].astype(float),
            motion_name_by_test(tests)[learn],
            compute_jackknife_intervals=False,
        )
        best = index_of_most_likely_size_neighbourhood(fall_share_by_size_neighbourhood_and_test, fell, learn)
        logistic[other], rigid[other] = (
            fit.fall_probability(peaks[other]),
            fall_share_by_size_neighbourhood_and_test[best][other],
        )
        centres.append(
            (
                float(CENTRE_B_OVER_H_OF_SIMILAR_SIZE_RANGES[best // CENTRE_HEIGHTS_OF_SIMILAR_SIZE_RANGES_M.size]),
                float(CENTRE_HEIGHTS_OF_SIMILAR_SIZE_RANGES_M[best % CENTRE_HEIGHTS_OF_SIMILAR_SIZE_RANGES_M.size]),
            )
        )
    return made, centres


def motion_name_by_test(tests: pd.DataFrame) -> np.ndarray:
    """Return the name of the motion of each test; repetitions of a motion are not independent."""
    return np.array([f"{pga:g} {ratio:g}" for pga, ratio in zip(tests["pga"], tests["ratio"], strict=True)])


def score_models_and_find_likeliest_small_table_blocks() -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return a table of scores by set of tests and model, and a table of the most likely block sizes.

    The scores have bootstrap intervals over motions.
    """
    rows, blocks = [], []
    for name, label in DATE_AND_ORIENTATION_BY_TEST_FILE.items():
        tests = read_small_table_tests(name)
        probabilities, centres = predict_each_half_from_the_other(tests, simulate_fall_shares_by_size_and_test(tests))
        fell, motions = tests["fell"].to_numpy(), motion_name_by_test(tests)
        samples, motion_count = bootstrap_samples_of_test_indices(motions), np.unique(motions).size
        for half, (b_over_h, height) in zip(("odd", "even"), centres, strict=True):
            blocks.append({"tests": label, "fitted to": half, "B/H": b_over_h, "H, m": height})
        for model, p in probabilities.items():
            if not np.isfinite(p).all():
                continue  # no regression: a straight line separates the falls from the stands of a half
            drawn, own = (
                np.array([f1_auc_and_brier_score(p[s], fell[s]) for s in samples]),
                f1_auc_and_brier_score(p, fell),
            )
            row: dict[str, str | float | int] = {"set": label, "model": model, "tests": len(tests), "fell": fell.sum()}
            for place, what in enumerate(SCORE_NAMES):
                interval = bootstrap_interval_over_motions(drawn[:, place], motion_count)
                row |= {what: own[place]} | dict(zip(INTERVAL_COLUMNS_BY_SCORE[what], interval, strict=True))
            rows.append(row)
    return pd.DataFrame(rows), pd.DataFrame(blocks)


def main() -> None:
    """Write the scores to verification/results/small-table.csv and into the docs."""
    rows, blocks = score_models_and_find_likeliest_small_table_blocks()
    write_csv(rows, RESULT_TABLE_FOLDER / "small-table.csv")
    lines = [
        (
            *(str(row[key]) for key in ("set", "model")),
            *(f"{row[what]:.2f} ({row[f'{what} low']:.2f} to {row[f'{what} high']:.2f})" for what in SCORE_NAMES),
            f"{row['fell']} of {row['tests']}",
        )
        for _, row in rows.iterrows()
    ]
    centres = [
        (str(one["tests"]), str(one["fitted to"]), f"{one['B/H']:.3f}", f"{one['H, m']:.2f}")
        for _, one in blocks.iterrows()
    ]
    update_marked_tables_and_sentences_in_docs({
        "small-table-scores": markdown_table(("tests", "model", *SCORE_NAMES, "fell"), lines),
        "small-table-blocks": markdown_table(("tests", "fitted to", "B/H", "H, m"), centres),
    })  # fmt: skip


if __name__ == "__main__":
    main()
