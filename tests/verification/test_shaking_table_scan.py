"""Prediction of shaking-table tests from a scan, with a synthetic boulder and synthetic tests."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from overturning.errors import ResultError
from overturning.model.scan import ScannedStone, stone_in_nearest_stable_pose_from_surface
from tests.model.solids import column_with_overhanging_slab, mass_properties_of_solid_from_its_boxes, write_mesh
from tests.verification.test_shaking_table import synthetic_shaking_table_tests
from verification.shaking_table import scan
from verification.shaking_table.data import SPECIMEN_NUMBERS, ShakingTableTests
from verification.shaking_table.models import PGA_PGV_LOGISTIC_MODEL_NAME, fall_prediction_models_by_name
from verification.shaking_table.scan import (
    BOULDER_ORIENTATIONS_DEG,
    index_of_most_likely_orientation,
    read_scanned_boulder,
    simulate_falls_of_boulder_by_orientation,
    smoothed_fall_probability_by_orientation_and_test,
    splits_into_halves_of_motions,
)
from verification.shaking_table.scan_page import (
    SCAN_MODEL_NAME,
    fall_share_table_by_max_bearing_height,
    model_with_orientation_fitted_to_other_tests,
    score_table,
    score_table_of_all_orientations,
    scores_on_unseen_tests,
    table_of_orientation_chosen_by_each_fit,
)

TRUE_YAW_INDEX = 7
"""Index of the orientation of the synthetic boulder."""


@pytest.fixture
def synthetic_tests_and_simulated_boulder_falls(
    monkeypatch: pytest.MonkeyPatch,
) -> tuple[ShakingTableTests, np.ndarray]:
    """Return 240 tests of twelve motions, and falls of a boulder that is weakest towards one orientation."""
    generator = np.random.default_rng(3)
    monkeypatch.setattr("verification.shaking_table.scores.BOOTSTRAP_SAMPLE_COUNT", 40)
    peak = np.exp(generator.uniform(np.log(0.5), np.log(8), 240))
    limit = 2.5 - 1.2 * np.cos(np.radians(BOULDER_ORIENTATIONS_DEG))
    fell = peak[None, :, None] * np.array([1.1, 1.0])[:, None, None] > limit[None, None, :]
    threshold = limit[TRUE_YAW_INDEX] * np.exp(generator.normal(0, 0.25, 240))
    return synthetic_shaking_table_tests(peak, threshold, generator), fell


def test_the_boulder_orientation_is_recovered_from_each_half_of_the_tests(
    synthetic_tests_and_simulated_boulder_falls: tuple[ShakingTableTests, np.ndarray],
) -> None:
    """The boulder's orientation is recovered from each half of the tests, up to mirroring about 0°.

    The falls of the synthetic boulder are symmetric about orientation 0°, so the mirrored orientation is accepted,
    too.
    """
    tests, fell = synthetic_tests_and_simulated_boulder_falls
    shares = smoothed_fall_probability_by_orientation_and_test(fell)
    assert shares.shape == (BOULDER_ORIENTATIONS_DEG.size, 240)
    assert ((shares > 0) & (shares < 1)).all()
    for learn, _ in splits_into_halves_of_motions(tests):
        chosen = index_of_most_likely_orientation(shares, tests.fell_by_specimen[1], learn)
        assert min(abs(chosen - TRUE_YAW_INDEX), abs(BOULDER_ORIENTATIONS_DEG.size - chosen - TRUE_YAW_INDEX)) <= 2


def test_no_motion_is_in_both_halves_of_the_tests(
    synthetic_tests_and_simulated_boulder_falls: tuple[ShakingTableTests, np.ndarray],
) -> None:
    tests, _ = synthetic_tests_and_simulated_boulder_falls
    predicted = []
    for learn, predict in splits_into_halves_of_motions(tests):
        assert not set(tests.played_record_names[learn]) & set(tests.played_record_names[predict])
        assert abs(len(learn) - len(predict)) <= 20
        predicted.append(predict)
    assert np.array_equal(np.sort(np.concatenate(predicted)), np.arange(240))


def test_scores_and_tables_of_a_scanned_boulder_are_complete(
    synthetic_tests_and_simulated_boulder_falls: tuple[ShakingTableTests, np.ndarray],
) -> None:
    tests, fell = synthetic_tests_and_simulated_boulder_falls
    shares = smoothed_fall_probability_by_orientation_and_test(fell)
    unknown = np.full((576, 240), 0.5)
    models = {
        PGA_PGV_LOGISTIC_MODEL_NAME: fall_prediction_models_by_name(tests, unknown, unknown)[
            PGA_PGV_LOGISTIC_MODEL_NAME
        ],
        SCAN_MODEL_NAME: model_with_orientation_fitted_to_other_tests(tests, shares),
    }
    rows = scores_on_unseen_tests(tests, models)
    values = rows.set_index(["split", "specimen", "model", "score"])["value"]
    assert values["half of the motions", 1, SCAN_MODEL_NAME, "F1"] > 0.85
    assert isinstance(rows, pd.DataFrame)
    own = rows[rows["model"] == SCAN_MODEL_NAME]
    assert (own["low"] <= own["value"] + 0.02).all()
    assert score_table(rows).count("\n") == 1 + 2 * 2 * 2
    assert score_table_of_all_orientations(tests, shares).count("\n") == 1 + 24
    assert "first half of the motions" in table_of_orientation_chosen_by_each_fit(tests, shares)
    lines = fall_share_table_by_max_bearing_height(
        tests, {scan.SIMULATED_BASE_RELIEFS_M[0]: fell[0], scan.EXTRA_BASE_RELIEF_OUTSIDE_PREDICTION_M: fell[1]}
    ).splitlines()
    assert [line.split("|")[2].strip() for line in lines[2:]] == ["no", "yes", ""]
    assert f"{fell[1].mean():.3f}" in lines[2]


def test_fall_fractions_are_averaged_over_neighbouring_orientations() -> None:
    fell = np.zeros((2, 1, BOULDER_ORIENTATIONS_DEG.size), bool)
    fell[:, 0, 0] = True
    shares = smoothed_fall_probability_by_orientation_and_test(fell)[:, 0]
    np.testing.assert_allclose(shares[[0, 1, -1, 2]], (np.array([0.5, 0.25, 0.25, 0.0]) + 0.25) / 1.5)


def test_a_scanned_statue_falls_only_under_the_strong_motion(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A scanned statue stands far below its threshold and falls under a strong, long pulse at every orientation.

    The results are stored and read again.
    """
    time = np.arange(300) * 0.005
    pulse = np.where(time < 1, np.sin(2 * np.pi * time), 0.0)
    tests = ShakingTableTests(
        np.arange(2), np.array(["a", "b"]), [0.1 * pulse, 9.0 * pulse], 0.005, np.array([0.1, 9.0]), np.ones(2),
        dict.fromkeys(SPECIMEN_NUMBERS, np.zeros(2, bool)),
    )  # fmt: skip
    stone = stone_in_nearest_stable_pose_from_surface(column_with_overhanging_slab(), [], "statue").shape
    assert isinstance(stone, ScannedStone)
    fell = simulate_falls_of_boulder_by_orientation(stone, tests, tmp_path, 1, (0.002,))
    assert fell.shape == (1, 2, BOULDER_ORIENTATIONS_DEG.size)
    assert not fell[0, 0].any()
    assert fell[0, 1].all()
    monkeypatch.setattr(scan, "simulate_cases", None)
    assert np.array_equal(simulate_falls_of_boulder_by_orientation(stone, tests, tmp_path, 1, (0.002,)), fell)


def test_a_boulder_mesh_is_read_with_its_unit_and_volume(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("trimesh")
    with pytest.raises(ResultError, match=r"no SP1\.ply"):
        read_scanned_boulder(tmp_path)
    write_mesh(column_with_overhanging_slab(), tmp_path / "SP1.ply")
    stone = read_scanned_boulder(tmp_path)
    assert f"{mass_properties_of_solid_from_its_boxes('statue')[0]:.4f} m³" in capsys.readouterr().out
    assert stone.unscaled_solid.base_vertex_count == 4
