"""Spread of ensembles, and the share of it that the relief explains, against runs with known shares."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr

from overturning.findings.collect import Findings
from overturning.findings.exactness import EnsembleDisagreementFindings, ensemble_findings
from overturning.findings.relief import (
    FallSharesByBaseRelief,
    estimate_variance_between_run_halves_and_total,
    share_of_fall_variance_due_to_base_relief,
)
from overturning.model.planes import PlanarModel
from overturning.report.render import LANGUAGES, render_template_as_markdown
from overturning.settings import EnsembleSettings
from tests.report.by_hand import STUDY_FINDINGS


@pytest.mark.parametrize(("low", "high"), [(0.9, 0.1), (0.5, 0.5), (0.7, 0.4)])
def test_estimates_of_variance_between_low_and_high_relief_runs_are_unbiased(low: float, high: float) -> None:
    """If half of the runs fall with probability a and half with b, the variance between halves is (a − b)²/4."""
    generator = np.random.default_rng(5)
    shares = [generator.binomial(12, share, 40_000) / 12 for share in (low, high)]
    between, total = estimate_variance_between_run_halves_and_total(*shares, np.full(40_000, 24.0))
    mean = 0.5 * (low + high)
    assert between.mean() == pytest.approx(0.25 * (low - high) ** 2, abs=1e-3)
    assert total.mean() == pytest.approx(mean * (1.0 - mean), abs=2e-3)


class StubReliefResults:
    """Stand-in for study results with only the variables used by the findings on the relief under the base."""

    def __init__(self, low: np.ndarray, high: np.ndarray, settings: dict) -> None:
        dims = ("record", "orientation")
        self.reference_element_cube = xr.Dataset({
            "probability_falls_low_relief": (dims, low.astype("f4")),
            "probability_falls_high_relief": (dims, high.astype("f4")),
            "members": (dims, np.full(low.shape, 24)),
            "overturned": (dims, np.zeros(low.shape)),
        })  # fmt: skip
        self.study = type("S", (), {"ensemble": EnsembleSettings.model_validate(settings)})


RELIEF_SETTINGS = {"relief": {"low": 0.001, "high": 0.005}}


def test_share_of_variance_explained_by_base_relief_matches_known_outcomes() -> None:
    """The relief under the base decides all falls in the first record and none in the second; one case was not run."""
    low, high = np.array([[1.0, 1.0], [0.5, np.nan]]), np.array([[0.0, 0.0], [0.5, np.nan]])
    found = share_of_fall_variance_due_to_base_relief(StubReliefResults(low, high, RELIEF_SETTINGS))  # type: ignore[arg-type]
    assert found is not None
    assert found.midrange_base_relief_mm == pytest.approx(3.0)
    assert (found.share_of_low_relief_runs_falling, found.share_of_high_relief_runs_falling) == pytest.approx(
        (2.5 / 3, 0.5 / 3)
    )
    # Between 2 × 0.25, less the sampling variance 0.25 × 0.5 / 11 of the third case; in total 3 × 0.25.
    noise = 0.25 * 0.5 / 11
    total = 0.5 + 0.5 * 12 / 11 * 0.5 - noise
    assert found.variance_share_explained_by_base_relief == pytest.approx((0.5 - noise) / total, abs=1e-6)
    assert share_of_fall_variance_due_to_base_relief(StubReliefResults(low, high, {})) is None  # type: ignore[arg-type]


@pytest.mark.parametrize("language", LANGUAGES)
def test_report_states_the_share_of_variance_explained_by_base_relief(language: str) -> None:
    relief = FallSharesByBaseRelief(
        midrange_base_relief_mm=3.0,
        share_of_low_relief_runs_falling=0.61,
        share_of_high_relief_runs_falling=0.17,
        variance_share_explained_by_base_relief=0.43,
    )
    ensemble = EnsembleDisagreementFindings(
        share_of_cells_repeated=0.5, repeats_every_cell=False, fewest_runs_per_cell=8, most_runs_per_cell=24,
        mean_runs_per_cell=12, runs_per_cell_in_first_batch=8, share_of_repeated_cells_with_fall_and_stand=0.4,
        share_of_repeated_cells_falling_to_both_sides=0.1,
        fall_shares_by_base_relief=relief,
    )  # fmt: skip
    plain = ensemble.model_copy(update={"fall_shares_by_base_relief": None})
    with_relief, without = (
        render_template_as_markdown(Findings.model_validate(STUDY_FINDINGS["direction"] | {"ensemble": one}), language)
        for one in (ensemble, plain)
    )
    new = set(with_relief.splitlines()) - set(without.splitlines())
    assert len(new) == 1
    for number in ("43", "61", "17", "3"):
        assert number in (sentence := next(iter(new)))
    if language == "en":
        assert sentence.replace("\u00a0", " ") == (
            "The relief under the base explains 43 % of this spread: with a relief below 3 mm the stone falls in 61 % "
            "of the runs, and above it in 17 %."
        )


@pytest.mark.parametrize("language", LANGUAGES)
def test_report_states_volume_tilt_and_relief_of_a_scanned_body(language: str) -> None:
    content = Findings.model_validate(STUDY_FINDINGS["reference"]).model_dump()
    content["study"]["scan"] = {
        "volume_m3": 0.53173,
        "tilt_from_scan_to_stable_pose_deg": 7.43,
        "load_bearing_height_above_lowest_point_mm": 8.35,
    }
    plain, text = (
        render_template_as_markdown(Findings.model_validate(one), language)
        for one in (STUDY_FINDINGS["reference"], content)
    )
    new = [line for line in text.splitlines() if line and line not in plain.splitlines()]
    setup, method = new
    assert ("scanned stone" if language == "en" else "スキャンした石") in setup
    assert all(number in method and number not in plain for number in ("0.532", "7.4°", "8.35"))


def test_disagreement_shares_count_only_cells_with_a_full_batch_of_runs() -> None:
    """In three cells of 4 runs, all fall, half fall to each side, or half stand; a cell of 3 runs is not counted."""
    towards, away = np.array([[1.0, 0.5, 0.5, 1 / 3], [0.0, 0.5, 0.0, 1 / 3]])
    dims = ("record", "azimuth", "height", "b_over_h", "friction")
    values = {"probability_towards": towards, "probability_away": away, "members": np.array([4, 4, 4, 3])}
    cube = xr.Dataset(
        {name: (dims, one.reshape(1, 1, 1, 4, 1)) for name, one in values.items()},
        {"azimuth": [30.0], "b_over_h": [0.2, 0.3, 0.4, 0.5]},
    ).assign(overturned=(dims, np.ones((1, 1, 1, 4, 1))))
    study = SimpleNamespace(ensemble=EnsembleSettings(members=4))
    found = ensemble_findings(SimpleNamespace(reference_element_cube=cube, model=PlanarModel(), study=study))  # type: ignore[arg-type]
    assert found is not None
    assert (found.runs_per_cell_in_first_batch, found.fewest_runs_per_cell, found.share_of_cells_repeated) == (
        4,
        3,
        1.0,
    )
    assert (
        found.share_of_repeated_cells_with_fall_and_stand,
        found.share_of_repeated_cells_falling_to_both_sides,
    ) == pytest.approx((1 / 3, 1 / 3))
