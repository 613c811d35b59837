"""The published coverage of `overturning backwards`: its intervals by earthquake, and its parts."""

import numpy as np
import pandas as pd
import pytest

from verification import backwards_coverage
from verification.backwards_coverage import confidence_interval_of_coverage, covered_share_with_interval_text, main


def surveys_with_given_coverage_by_event(shares: list[float], size: int = 10) -> pd.DataFrame:
    """Return a table of surveys; intervals of a given share of each earthquake's surveys hold the true value."""
    rows = [(f"E{event}", k < round(share * size)) for event, share in enumerate(shares) for k in range(size)]
    return pd.DataFrame(rows, columns=["event", "holds"])


def test_surveys_under_one_earthquake_are_not_independent_samples() -> None:
    """More surveys per earthquake with the same covered shares do not narrow the coverage's confidence interval.

    The numbers of surveys per earthquake differ by a factor of ten.
    """
    shares = [1.0, 1.0, 0.9, 1.0, 0.5, 0.8, 1.0, 0.7, 0.9, 1.0]
    few, many = (
        confidence_interval_of_coverage(surveys_with_given_coverage_by_event(shares, size), "holds")
        for size in (10, 100)
    )
    assert many == pytest.approx(few)
    assert few.low < np.mean(shares) < few.high
    binomial = 1.96 * np.sqrt(np.mean(shares) * (1 - np.mean(shares)) / 1000)
    assert few.high - few.low > 4 * 2 * binomial


def test_most_confidence_intervals_by_earthquake_contain_the_true_coverage() -> None:
    """More than 88 % of 120 confidence intervals contain the true coverage of 0.9.

    The coverages under 19 earthquakes, with 20 surveys each, are drawn from a beta distribution with mean 0.9.
    """
    generator, held = np.random.default_rng(7), 0
    for _ in range(120):
        shares = generator.binomial(20, generator.beta(9.0, 1.0, 19)) / 20
        low, high = confidence_interval_of_coverage(surveys_with_given_coverage_by_event(shares.tolist(), 20), "holds")
        held += low <= 0.9 <= high
    assert held / 120 > 0.88


def test_the_coverage_bound_is_exact_if_all_surveys_or_none_are_covered() -> None:
    low, high = confidence_interval_of_coverage(surveys_with_given_coverage_by_event([1.0] * 9), "holds")
    assert high == 1.0
    assert low**9 == pytest.approx(0.05)
    assert confidence_interval_of_coverage(surveys_with_given_coverage_by_event([0.0] * 9), "holds") == pytest.approx(
        (0.0, 1 - low)
    )
    assert np.isnan(confidence_interval_of_coverage(surveys_with_given_coverage_by_event([1.0, 0.5, 0.8]), "holds").low)
    assert covered_share_with_interval_text(surveys_with_given_coverage_by_event([1.0, 0.5, 0.9]), "holds") == "80 %"
    assert (
        covered_share_with_interval_text(surveys_with_given_coverage_by_event([1.0] * 9), "holds")
        == "100 % (72 to 100)"
    )


def test_renewing_the_ruin_example_measures_no_coverage(monkeypatch: pytest.MonkeyPatch) -> None:
    """Renewing the ruin example in docs/surveys.md does not measure the coverage, which takes an hour.

    Regression: the numbers in docs/surveys.md were out of date, since renewing them also measured the coverage.
    """
    published: list[str] = []
    monkeypatch.setattr(
        backwards_coverage, "update_marked_tables_and_sentences_in_docs", lambda bodies: published.extend(bodies)
    )
    monkeypatch.setattr(
        backwards_coverage, "draw_ruin_motion_figure_and_return_markdown", lambda _: "- PGV at least 36.9 cm/s"
    )
    monkeypatch.setattr(
        backwards_coverage, "measure_interval_coverage", lambda *_: pytest.fail("the coverage was measured")
    )
    main(["ruin"])
    assert published == ["example-ruin"]
