"""Ensemble of a scanned stone whose members differ in relief and in orientation on the ground."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from overturning.errors import ConfigError
from overturning.model.body import Body
from overturning.model.scan import ScannedStone
from overturning.settings import EnsembleSettings
from overturning.study.ensemble import EnsembleRunner
from overturning.study.ensemble_members import EnsembleParameterChanges, draw_parameter_changes_of_members
from overturning.study.load import load_study_from_file_or_json, study_from_content

STONE_VERTICES = np.array(
    [[x, y, z] for a, z in ((0.05, 0.0), (0.07, 0.003), (0.07, 0.8)) for x in (-a, a) for y in (-a, a)]
)
STONE = ScannedStone(STONE_VERTICES, (0.0, 0.0, 0.4), (0.055, 0.055, 0.003, 0.0, 0.0, 0.0), 0.001)
SCANNED_BODY_SETTINGS = {
    "vertices": STONE_VERTICES.tolist(),
    "relief": 0.001,
    "scan": {"volume": 0.015, "tilt": 1.5, "centre_of_mass": [0, 0, 0.4], "inertia": [0.055, 0.055, 0.003, 0, 0, 0]},
}


def test_ensemble_members_vary_relief_and_orientation_only_on_request(tmp_path: Path) -> None:
    plain = draw_parameter_changes_of_members(EnsembleSettings(members=16))
    assert not plain.varies_scanned_base_relief
    assert not plain.orientation_change_deg.any()
    assert {"relief", "orientation"}.isdisjoint(EnsembleSettings().model_dump())
    varied = draw_parameter_changes_of_members(
        EnsembleSettings.model_validate({"members": 64, "relief": {"low": 0.001, "high": 0.005}, "orientation": 5.0})
    )
    assert varied.varies_scanned_base_relief
    assert (varied.relief_m >= 0.001).all()
    assert (varied.relief_m <= 0.005).all()
    assert varied.relief_m.mean() == pytest.approx(0.003, abs=2e-4)
    assert np.abs(varied.orientation_change_deg).max() == pytest.approx(5.0, abs=0.5)
    assert varied.above_median_relief_mask.sum() == 32
    for members, columns in ((plain, 7), (varied, 9)):
        members.write_csv(tmp_path / "members.csv")
        assert len((tmp_path / "members.csv").read_text().splitlines()[0].split(",")) == columns
        again = EnsembleParameterChanges.read_csv(tmp_path / "members.csv")
        for name in ("amplitude_factor", "orientation_change_deg", "relief_m"):
            np.testing.assert_array_equal(getattr(again, name), getattr(members, name))


class StubGridOfTwoOrientations:
    """Grid of one stone at two orientations, with only the methods that an ensemble needs."""

    dimension_names = ("orientation", "aspect", "height", "b_over_h", "friction")
    shape = (2, 1, 1, 1, 1)

    def __getitem__(self, name: str) -> np.ndarray:
        return {"orientation": np.array([0.0, 90.0]), "height": np.array([0.8])}.get(name, np.ones(1))


def test_ensemble_members_of_a_scan_have_their_own_relief_and_orientation(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ensemble members of a scanned stone are simulated with their own relief and orientation.

    A stub lets the stone fall if its relief is low, so that the fall shares are 1 for members of low and 0 for
    members of high relief.
    """
    members = draw_parameter_changes_of_members(
        EnsembleSettings.model_validate({"members": 16, "relief": {"low": 0.001, "high": 0.005}, "orientation": 5.0})
    )
    limit, seen = float(np.median(members.relief_m)), []

    def fake_results_falling_if_base_relief_is_low(cases: Any, progress: Any, relief: float) -> Any:
        seen.append((relief, np.asarray(cases.azimuth_deg)))
        falls = np.full(cases.case_count, relief <= limit)

        class StubCaseResults:
            block_steps = np.ones(cases.case_count, np.int64)
            overturned = falls.astype(np.int8)
            fall_azimuth = np.where(falls, 30.0, np.nan)

        return StubCaseResults()

    class StubMotion:
        sample_count = 100

    nominal = {
        "overturned": np.zeros(StubGridOfTwoOrientations.shape, np.int8),
        "repeated": np.zeros(StubGridOfTwoOrientations.shape, np.int8),
    }
    runner = EnsembleRunner(Body(STONE), members)
    monkeypatch.setattr(EnsembleRunner, "_copy_to_symmetric_cells", lambda *_: None)
    found, steps = runner.choose_cases_and_run_their_ensembles(
        StubMotion(), StubGridOfTwoOrientations(), nominal, fake_results_falling_if_base_relief_is_low
    )  # type: ignore[arg-type]
    assert steps == 2 * 16
    assert [relief for relief, _ in seen] == pytest.approx(
        np.concatenate(
            [members.relief_m[batch] for batch in members.split_members_into_batches_of_both_sequences(8)]
        ).tolist()
    )
    turned = {float(relief): azimuth for relief, azimuth in seen}
    for number in range(16):
        turn = members.azimuth_change_deg[number] + members.orientation_change_deg[number]
        np.testing.assert_allclose(turned[float(members.relief_m[number])], [turn, 90.0 + turn])
    np.testing.assert_array_equal(found["probability_falls_low_relief"].ravel(), [1.0, 1.0])
    np.testing.assert_array_equal(found["probability_falls_high_relief"].ravel(), [0.0, 0.0])
    np.testing.assert_allclose(found["probability_falls"].ravel(), 0.5)


def test_relief_spread_is_accepted_only_for_a_scanned_stone() -> None:
    about = {"name": "b", "records": {"use": ["a"]}}
    ensemble = {"relief": {"low": 0.001, "high": 0.005}, "members": 8}
    study = study_from_content(about | {"body": SCANNED_BODY_SETTINGS, "ensemble": ensemble}, "b")
    assert load_study_from_file_or_json(study.model_dump_json()) == study
    for wrong, words in (
        ({"body": {"plan": "circle"}, "ensemble": ensemble}, "only a scanned stone has a relief"),
        ({"ensemble": ensemble}, "only a single 3-D body has them"),
        ({"body": SCANNED_BODY_SETTINGS, "ensemble": {"relief": {"low": 1, "high": 5}}}, "the unit is the metre"),
    ):
        with pytest.raises(ConfigError, match=words):
            study_from_content(about | wrong, "b")
