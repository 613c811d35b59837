"""Means over earthquakes and their intervals, compared with hand computation and SciPy."""

import math

import numpy as np
import pytest
from scipy import stats

from overturning.statistics.bootstrap import (
    MIN_EARTHQUAKES_FOR_INTERVAL,
    bootstrap_interval,
    exact_interval_if_all_0_or_all_1,
    interval_tail_share_for_few_earthquakes,
    mean_of_each_bootstrap_sample,
    mean_over_earthquakes,
    mean_share_interval,
    mean_share_over_earthquakes,
    means_by_earthquake,
)

RECORD_VALUES = np.array([0.1, 0.5, 0.9, -0.2, 0.4, np.nan, 0.7, 1.1, -0.6, 0.0])
EARTHQUAKE_NAMES_BY_RECORD = list("AABCDEFGHI")
EARTHQUAKE_MEANS = np.array([0.3, 0.9, -0.2, 0.4, 0.7, 1.1, -0.6, 0.0])


def test_records_are_averaged_within_their_earthquake() -> None:
    found = means_by_earthquake(np.array([[1.0, 2.0], [5.0, 6.0], [3.0, np.nan], [np.nan] * 2]), ["B", "A", "B", "C"])
    np.testing.assert_array_equal(found, [[2.0, 2.0], [5.0, 6.0], [np.nan, np.nan]])


def test_interval_of_a_mean_over_earthquakes_matches_scipy() -> None:
    found = mean_over_earthquakes(RECORD_VALUES, EARTHQUAKE_NAMES_BY_RECORD, bootstrap_sample_count=20_000)
    assert (found.earthquake_count, found.mean) == (8, pytest.approx(EARTHQUAKE_MEANS.mean()))
    # The expanded percentile by SciPy: its percentile interval of the wider level that Hesterberg (2015) gives.
    level = 1 - 2 * stats.norm.cdf(-math.sqrt(8 / 7) * stats.t.ppf(0.975, 7))
    other = stats.bootstrap(
        (EARTHQUAKE_MEANS,),
        np.mean,
        method="percentile",
        confidence_level=level,
        n_resamples=40_000,
        rng=np.random.default_rng(5),
    )
    assert (found.interval_low, found.interval_high) == pytest.approx(tuple(other.confidence_interval), abs=0.03)


def test_mean_over_few_earthquakes_lacks_an_interval_and_over_none_is_nan() -> None:
    few = mean_over_earthquakes(RECORD_VALUES[:-1], EARTHQUAKE_NAMES_BY_RECORD[:-1])
    assert (few.earthquake_count, few.mean) == (
        MIN_EARTHQUAKES_FOR_INTERVAL - 1,
        pytest.approx(EARTHQUAKE_MEANS[:-1].mean()),
    )
    assert math.isnan(few.interval_low)
    nothing = mean_over_earthquakes(np.array([np.nan]), ["A"])
    assert nothing.earthquake_count == 0
    assert math.isnan(nothing.mean)


def test_tail_of_the_expanded_percentile_interval_matches_hesterbergs_table() -> None:
    """Reference: table of the expanded tail probability α/2 of 95 % intervals (Hesterberg 2015, section 5.3)."""
    assert [interval_tail_share_for_few_earthquakes(n) for n in (5, 10, 20)] == pytest.approx(
        [0.0010, 0.0086, 0.0159], abs=6e-5
    )
    assert interval_tail_share_for_few_earthquakes(10**6) == pytest.approx(0.025, abs=1e-5)


def test_interval_of_a_share_of_0_in_most_earthquakes_covers_the_true_share() -> None:
    """The interval of a mean share covers it even if one earthquake in five has the share 1 and the others 0.

    In 13 % of samples of nine all shares are 0, and a plain bootstrap interval would have zero width.
    """
    generator = np.random.default_rng(7)
    samples = (generator.random((400, 9)) < 0.2).astype(float)
    ends = np.array([mean_share_interval(shares, bootstrap_sample_count=2000) for shares in samples])
    assert ((ends[:, 0] <= 0.2) & (ends[:, 1] >= 0.2)).mean() > 0.95
    empty = ends[samples.sum(axis=1) == 0]
    assert len(empty) > 40
    assert empty[:, 1] == pytest.approx(1 - 0.05 ** (1 / 9))


@pytest.mark.parametrize("usual", [0.0, -0.25, 1.0])
@pytest.mark.parametrize("other", [-1.0, 0.5])
def test_interval_of_a_difference_equal_in_most_earthquakes_covers_its_mean(usual: float, other: float) -> None:
    """The interval of a mean difference covers it even if only one earthquake in five differs from the rest.

    In 13 % of samples of nine all are equal, and a plain bootstrap interval would have zero width.
    """
    generator = np.random.default_rng(7)
    samples = np.where(generator.random((400, 9)) < 0.2, other, usual)
    found = [mean_over_earthquakes(sample, [*"ABCDEFGHI"], bootstrap_sample_count=2000) for sample in samples]
    mean = usual + 0.2 * (other - usual)
    assert np.mean([one.interval_low <= mean <= one.interval_high for one in found]) > 0.95
    same = [one for one, sample in zip(found, samples, strict=True) if (sample == usual).all()]
    assert len(same) > 40
    least = stats.binomtest(9, 9, alternative="greater").proportion_ci(0.95, method="exact").low
    for one in same:  # at least this share of all earthquakes has the value, the others have -1 or 1
        assert (one.mean, one.interval_low, one.interval_high) == pytest.approx(
            (usual, least * usual - (1 - least), least * usual + (1 - least))
        )


def test_a_share_that_is_the_same_in_all_earthquakes_has_an_interval() -> None:
    """The interval of a share has a width even if the share is 0.3 in all of eight earthquakes.

    The bounds assume that at least a fraction 0.05^(1/8) of all earthquakes has the share 0.3, and the others any
    share from 0 to 1.
    """
    assert mean_share_interval(np.full(8, 0.3)) == pytest.approx((0.3 * 0.05 ** (1 / 8), 1 - 0.7 * 0.05 ** (1 / 8)))
    assert math.isnan(mean_over_earthquakes(np.zeros(7), [*"ABCDEFG"]).interval_low), "too few earthquakes"


def test_interval_for_eight_earthquakes_covers_95_percent() -> None:
    """The interval covers the mean in 94 % of samples of eight earthquakes, a plain percentile interval in 88 %."""
    generator, held = np.random.default_rng(1), 0
    for seed in range(1000):
        low, high = bootstrap_interval(
            mean_of_each_bootstrap_sample,
            generator.normal(size=MIN_EARTHQUAKES_FOR_INTERVAL),
            bootstrap_sample_count=1000,
            seed=seed,
        )
        held += low <= 0 <= high
    assert held / 1000 == pytest.approx(0.94, abs=0.02)


def test_bounds_at_99_percent_do_not_depend_on_the_number_of_draws() -> None:
    """At 99 % and n = 8, each bound of the expanded percentile interval cuts off about 1 in 10,000 resamples.

    Of only 100 resamples, the bounds would be the smallest and the largest mean.
    """
    few, many = (
        bootstrap_interval(
            mean_of_each_bootstrap_sample, EARTHQUAKE_MEANS, confidence_level=0.99, bootstrap_sample_count=draws
        )
        for draws in (100, 300_000)
    )
    assert few == pytest.approx(many, abs=0.03)


def test_share_of_0_or_1_in_all_earthquakes_has_the_exact_bound() -> None:
    """The bound equals SciPy's Clopper–Pearson bound for n of n; a bootstrap would give an interval of zero width."""
    for n in (1, 4, 11):
        exact = stats.binomtest(n, n, alternative="greater").proportion_ci(0.95, method="exact")
        assert exact_interval_if_all_0_or_all_1(np.ones(n)) == pytest.approx((exact.low, 1.0))
        none = stats.binomtest(0, n, alternative="less").proportion_ci(0.95, method="exact")
        assert exact_interval_if_all_0_or_all_1(np.zeros(n)) == pytest.approx((0.0, none.high))
    assert exact_interval_if_all_0_or_all_1(np.array([1.0, 0.9])) is None
    assert exact_interval_if_all_0_or_all_1(np.zeros(0)) is None
    # Two records of an earthquake are one earthquake.
    found = mean_share_over_earthquakes(np.ones(16), [*"AABBCCDDEEFFGGHH"])
    assert (found.earthquake_count, found.mean, found.interval_low, found.interval_high) == pytest.approx(
        (8, 1.0, 0.05 ** (1 / 8), 1.0)
    )
    assert math.isnan(mean_share_over_earthquakes(np.ones(3), [*"ABC"]).interval_low)


@pytest.mark.parametrize("share", [0.3, 0.7])
def test_statistic_undefined_in_most_resamples_has_no_interval(share: float) -> None:
    def mean_undefined_in_some_resamples(drawn: np.ndarray) -> np.ndarray:
        return np.where(np.arange(len(drawn)) < share * len(drawn), drawn.mean(axis=1), np.nan)

    assert math.isnan(bootstrap_interval(mean_undefined_in_some_resamples, EARTHQUAKE_MEANS).low) == (share < 0.5)
