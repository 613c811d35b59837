"""The published coverage of `overturning backwards`: its intervals by earthquake, and its parts."""

import numpy as np
import pandas as pd
import pytest

from verification import backwards_coverage
from verification.backwards_coverage import coverage_label, covered_share_interval, main


def survey_table(shares: list[float], size: int = 10) -> pd.DataFrame:
    """Table of surveys: for each earthquake, a share of its surveys has an interval that contains the true value."""
    rows = [(f"E{event}", k < round(share * size)) for event, share in enumerate(shares) for k in range(size)]
    return pd.DataFrame(rows, columns=["event", "holds"])


def test_surveys_under_one_earthquake_are_not_independent_samples() -> None:
    """Ten times as many surveys under the same earthquakes, alike in each, tell no more of the coverage."""
    shares = [1.0, 1.0, 0.9, 1.0, 0.5, 0.8, 1.0, 0.7, 0.9, 1.0]
    few, many = (covered_share_interval(survey_table(shares, size), "holds") for size in (10, 100))
    assert many == pytest.approx(few)
    assert few.low < np.mean(shares) < few.high
    binomial = 1.96 * np.sqrt(np.mean(shares) * (1 - np.mean(shares)) / 1000)
    assert few.high - few.low > 4 * 2 * binomial


def test_the_interval_over_earthquakes_covers_the_true_coverage() -> None:
    """Coverage under an earthquake varies by a beta distribution of mean 0.9, over 19 earthquakes of 20 surveys."""
    generator, held = np.random.default_rng(7), 0
    for _ in range(120):
        shares = generator.binomial(20, generator.beta(9.0, 1.0, 19)) / 20
        low, high = covered_share_interval(survey_table(shares.tolist(), 20), "holds")
        held += low <= 0.9 <= high
    assert held / 120 > 0.88


def test_the_bound_for_unanimous_earthquakes_is_exact() -> None:
    low, high = covered_share_interval(survey_table([1.0] * 9), "holds")
    assert high == 1.0
    assert low**9 == pytest.approx(0.05)
    assert covered_share_interval(survey_table([0.0] * 9), "holds") == pytest.approx((0.0, 1 - low))
    assert np.isnan(covered_share_interval(survey_table([1.0, 0.5, 0.8]), "holds").low)
    assert coverage_label(survey_table([1.0, 0.5, 0.9]), "holds") == "80 %"
    assert coverage_label(survey_table([1.0] * 9), "holds") == "100 % (72 to 100)"


def test_the_example_ruin_page_is_made_without_computing_coverage(monkeypatch: pytest.MonkeyPatch) -> None:
    """The figures of docs/surveys.md were old because making them took an hour of other work with it."""
    published: list[str] = []
    monkeypatch.setattr(backwards_coverage, "publish_markdown", lambda bodies: published.extend(bodies))
    monkeypatch.setattr(backwards_coverage, "estimate_ruin_motion", lambda _: "- PGV at least 36.9 cm/s")
    monkeypatch.setattr(backwards_coverage, "measure_coverage", lambda *_: pytest.fail("the coverage was measured"))
    main(["ruin"])
    assert published == ["example-ruin"]
