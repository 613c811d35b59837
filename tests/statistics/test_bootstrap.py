"""Means over earthquakes and their intervals, by hand and beside scipy."""

import math

import numpy as np
import pytest
from scipy import stats

from overturning.statistics.bootstrap import (
    FEWEST_EARTHQUAKES,
    bootstrap,
    event_means,
    mean_of_sample,
    mean_over_earthquakes,
)

VALUES = np.array([0.1, 0.5, 0.9, -0.2, 0.4, np.nan, 0.7, 1.1, -0.6, 0.0])
EVENTS = list("AABCDEFGHI")
MEANS = np.array([0.3, 0.9, -0.2, 0.4, 0.7, 1.1, -0.6, 0.0])


def test_records_of_an_earthquake_are_averaged_first() -> None:
    found = event_means(np.array([[1.0, 2.0], [5.0, 6.0], [3.0, np.nan], [np.nan] * 2]), ["B", "A", "B", "C"])
    np.testing.assert_array_equal(found, [[2.0, 2.0], [5.0, 6.0], [np.nan, np.nan]])


def test_a_mean_over_earthquakes_has_scipys_interval() -> None:
    found = mean_over_earthquakes(VALUES, EVENTS, draws=20_000)
    assert (found.n, found.value) == (8, pytest.approx(MEANS.mean()))
    other = stats.bootstrap((MEANS,), np.mean, method="percentile", n_resamples=20_000, rng=np.random.default_rng(5))
    assert (found.low, found.high) == pytest.approx(tuple(other.confidence_interval), abs=0.02)


def test_few_earthquakes_have_no_interval_and_none_no_mean() -> None:
    few = mean_over_earthquakes(VALUES[:-1], EVENTS[:-1])
    assert (few.n, few.value) == (FEWEST_EARTHQUAKES - 1, pytest.approx(MEANS[:-1].mean()))
    assert math.isnan(few.low)
    nothing = mean_over_earthquakes(np.array([np.nan]), ["A"])
    assert nothing.n == 0
    assert math.isnan(nothing.value)


def test_the_fewest_are_those_whose_interval_holds_what_it_says_in_seven_of_eight_samples() -> None:
    """The reason for the number: of fewer the interval for a mean of normal values holds it less often still."""
    generator, held = np.random.default_rng(1), 0
    for seed in range(1000):
        low, high = bootstrap(mean_of_sample, generator.normal(size=FEWEST_EARTHQUAKES), draws=400, seed=seed)
        held += low <= 0 <= high
    assert held / 1000 == pytest.approx(0.878, abs=0.03)


@pytest.mark.parametrize("share", [0.3, 0.7])
def test_a_statistic_that_most_samples_do_not_have_has_no_interval(share: float) -> None:
    def sometimes(drawn: np.ndarray) -> np.ndarray:
        return np.where(np.arange(len(drawn)) < share * len(drawn), drawn.mean(axis=1), np.nan)

    assert math.isnan(bootstrap(sometimes, MEANS).low) == (share < 0.5)
