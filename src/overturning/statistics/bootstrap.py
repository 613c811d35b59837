"""Means over earthquakes, and their bootstrap intervals.

Records of one earthquake share its source, so they are averaged first and count as one value. The bootstrap resamples
earthquakes, not records.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Final, NamedTuple

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray

MIN_EARTHQUAKES_FOR_INTERVAL: Final = 8
"""Smallest number of earthquakes with a bootstrap interval.

No bootstrap interval reaches beyond the smallest and the largest value. The range of n normal values contains their
true mean in 75 % of samples of n = 3, 88 % of n = 4 and 94 % of n = 5; skewed values need more.
"""

MIN_BOOTSTRAP_SAMPLES_PER_TAIL: Final = 10
"""Smallest number of bootstrap samples beyond each end of an interval; with fewer, the end is mostly noise."""

MAX_ABSOLUTE_DIFFERENCE_OF_EQUAL_VALUES: Final = 1e-12
"""Largest difference between values that are equal but for rounding."""


class ConfidenceInterval(NamedTuple):
    """Lower and upper limit of a confidence interval; both are NaN if there is no interval."""

    low: float = math.nan
    high: float = math.nan


@dataclass(frozen=True)
class MeanOverEarthquakes:
    """Mean of a quantity over earthquakes, and limits of its 95 % confidence interval; NaN if unknown."""

    earthquake_count: int
    mean: float
    interval_low: float
    interval_high: float


def means_by_earthquake(
    value_by_record: FloatArray, earthquake_name_by_record: Sequence[str] | NDArray[np.str_]
) -> FloatArray:
    """Average a quantity of each record over the records of each earthquake, shape (earthquakes, …).

    Earthquakes are in the order of `distinct_earthquake_names`.

    Parameters
    ----------
    value_by_record : ndarray, shape (records, …)
        NaN where a record has no value; such a record does not count. A mean of no values is NaN.
    earthquake_name_by_record : sequence of str, length records
        Earthquake of each record.
    """
    of_record, means = np.asarray(earthquake_name_by_record), []
    for name in distinct_earthquake_names(earthquake_name_by_record):
        own = value_by_record[of_record == name]
        known = np.isfinite(own)
        count = known.sum(axis=0)
        means.append(np.where(count > 0, np.where(known, own, 0.0).sum(axis=0) / np.maximum(count, 1), np.nan))
    return np.array(means).reshape(len(means), *value_by_record.shape[1:])


def distinct_earthquake_names(earthquake_name_by_record: Sequence[str] | NDArray[np.str_]) -> list[str]:
    """Return each earthquake name in `earthquake_name_by_record` once, in order of first appearance."""
    return list(dict.fromkeys(str(event) for event in earthquake_name_by_record))


@lru_cache(maxsize=4)
def _random_earthquake_indices_of_bootstrap_samples(
    earthquake_count: int, bootstrap_sample_count: int, seed: int
) -> NDArray[np.int64]:
    """Draw with replacement the earthquakes of each bootstrap sample, as indices of shape (draws, earthquakes).

    The last results are cached, since many statistics use the same samples.
    """
    return np.random.Generator(np.random.PCG64(seed)).integers(
        0, earthquake_count, size=(bootstrap_sample_count, earthquake_count)
    )


def finite_statistics_of_bootstrap_samples(
    statistic: Callable[[NDArray[Any]], FloatArray],
    data_by_earthquake: NDArray[Any],
    bootstrap_sample_count: int,
    seed: int = 1,
) -> FloatArray:
    """Compute a statistic for each bootstrap sample of earthquakes, shape (finite values,); empty if most are NaN.

    Parameters
    ----------
    statistic : callable
        Maps samples, shape (draws, earthquakes, …), to values, shape (draws,); NaN if a sample has no value.
    data_by_earthquake : ndarray, shape (earthquakes, …)
        Data of each earthquake. The result is empty for fewer than `MIN_EARTHQUAKES_FOR_INTERVAL` earthquakes, or if
        fewer than half of the samples have a value.
    bootstrap_sample_count, seed : int
        Number of samples, and seed. Each sample has as many earthquakes as the data, drawn with replacement.
    """
    n = len(data_by_earthquake)
    if n < MIN_EARTHQUAKES_FOR_INTERVAL:
        return np.zeros(0)
    # For rows of several values, take is ten times as fast as an index.
    values = statistic(
        np.take(
            data_by_earthquake, _random_earthquake_indices_of_bootstrap_samples(n, bootstrap_sample_count, seed), axis=0
        )
    )
    known = values[np.isfinite(values)]
    return known if 2 * known.size >= bootstrap_sample_count else np.zeros(0)


def interval_tail_share_for_few_earthquakes(earthquake_count: int, confidence_level: float = 0.95) -> float:
    """Return the share of bootstrap values to cut off at each end of an interval, corrected for few earthquakes.

    The share is Φ(−√(n/(n − 1)) t), with the normal distribution function Φ and the (1 + level)/2 quantile t of
    Student's distribution with n − 1 degrees of freedom (Hesterberg 2015, American Statistician 69, 371). The plain
    percentile interval is too short, because the variance of bootstrap means of n values is only (n − 1)/n of the
    estimated variance of the mean, and because this variance is treated as known: for the mean of n normal values its
    95 % interval contains the true mean in 88 % of cases for n = 8, and 91 % for n = 11.

    Parameters
    ----------
    earthquake_count : int
        Number of independent values (earthquakes), at least 2.
    confidence_level : float
        Probability of the interval.
    """
    quantile = float(scipy.special.stdtrit(earthquake_count - 1, (1 + confidence_level) / 2))
    return float(scipy.special.ndtr(-math.sqrt(earthquake_count / (earthquake_count - 1)) * quantile))


def bootstrap_interval(
    statistic: Callable[[NDArray[Any]], FloatArray],
    data_by_earthquake: NDArray[Any],
    *,
    confidence_level: float = 0.95,
    bootstrap_sample_count: int = 4000,
    seed: int = 1,
    count_of_earthquakes_that_matter: int | None = None,
    statistic_bounds: tuple[float, float] | None = None,
) -> ConfidenceInterval:
    """Compute a confidence interval from bootstrap samples of earthquakes: percentiles, widened for small samples.

    See `interval_tail_share_for_few_earthquakes` for the share of bootstrap samples beyond its ends.

    Parameters
    ----------
    statistic, data_by_earthquake, bootstrap_sample_count, seed
        See `finite_statistics_of_bootstrap_samples`. More samples are drawn if fewer than
        `MIN_BOOTSTRAP_SAMPLES_PER_TAIL` would lie beyond an end.
    confidence_level : float
        Probability of the interval.
    count_of_earthquakes_that_matter : int, optional
        Number of earthquakes that determine the statistic, if smaller than the number of rows of
        ``data_by_earthquake``, such as that of the smaller of two sets. There is no interval for fewer than
        `MIN_EARTHQUAKES_FOR_INTERVAL`.
    statistic_bounds : (float, float), optional
        Smallest and largest possible value of the statistic, used if it is the same in all bootstrap samples: the
        interval is then that of `mean_interval_for_equal_earthquake_values`.
    """
    n = (
        len(data_by_earthquake)
        if count_of_earthquakes_that_matter is None
        else min(count_of_earthquakes_that_matter, len(data_by_earthquake))
    )
    if n < MIN_EARTHQUAKES_FOR_INTERVAL:
        return ConfidenceInterval()
    tail = interval_tail_share_for_few_earthquakes(n, confidence_level)
    values = finite_statistics_of_bootstrap_samples(
        statistic,
        data_by_earthquake,
        max(bootstrap_sample_count, math.ceil(MIN_BOOTSTRAP_SAMPLES_PER_TAIL / tail)),
        seed,
    )
    if not values.size:
        return ConfidenceInterval()
    if statistic_bounds is not None and np.ptp(values) <= MAX_ABSOLUTE_DIFFERENCE_OF_EQUAL_VALUES:
        return mean_interval_for_equal_earthquake_values(float(values[0]), n, statistic_bounds, confidence_level)
    low, high = np.quantile(values, [tail, 1 - tail])
    return ConfidenceInterval(float(low), float(high))


def mean_interval_for_equal_earthquake_values(
    value_in_every_earthquake: float,
    earthquake_count: int,
    value_bounds: tuple[float, float],
    confidence_level: float = 0.95,
) -> ConfidenceInterval:
    """Return the interval of the mean of a bounded quantity that has the same value in all earthquakes.

    All bootstrap samples of equal values are equal, so the bootstrap interval would have no width. If an earthquake has
    this value with probability p, all n have it with probability pⁿ, so p is at least (1 − level)^(1/n) (Clopper &
    Pearson 1934, Biometrika 26, one-sided), for any n. Earthquakes with another value have the probability 1 − p, and
    move the mean towards a bound by at most 1 − p times the distance from the value to the bound.

    Parameters
    ----------
    value_in_every_earthquake : float
        Value in each earthquake.
    earthquake_count : int
        Number n of earthquakes.
    value_bounds : (float, float)
        Smallest and largest possible value of the quantity, such as 0 and 1 of a share.
    confidence_level : float
        Probability of the interval.
    """
    other = 1 - (1 - confidence_level) ** (1 / earthquake_count)
    return ConfidenceInterval(
        value_in_every_earthquake - other * (value_in_every_earthquake - value_bounds[0]),
        value_in_every_earthquake + other * (value_bounds[1] - value_in_every_earthquake),
    )


def mean_of_each_bootstrap_sample(values_by_bootstrap_sample_and_earthquake: NDArray[Any]) -> FloatArray:
    """Return the mean over the earthquakes (axis 1) of each bootstrap sample (axis 0)."""
    return np.asarray(values_by_bootstrap_sample_and_earthquake.mean(axis=1))


def mean_vector_of_each_bootstrap_sample(vectors_by_bootstrap_sample_and_observation: FloatArray) -> FloatArray:
    """Return the mean over the earthquakes (axis 1) of the vectors (axis 2) of each sample, shape (samples, 2).

    The result is bit by bit that of ``mean(axis=1)``, which takes five times as long for vectors of two components.
    """
    return np.asarray(
        np.einsum("ijk->ik", vectors_by_bootstrap_sample_and_observation)
        / vectors_by_bootstrap_sample_and_observation.shape[1]
    )


def mean_over_earthquakes(
    value_by_record: FloatArray,
    earthquake_name_by_record: Sequence[str] | NDArray[np.str_],
    *,
    bootstrap_sample_count: int = 4000,
    value_bounds: tuple[float, float] = (-1.0, 1.0),
) -> MeanOverEarthquakes:
    """Average a quantity of each record over the records of an earthquake, then over earthquakes, with an interval.

    The interval of the mean is that of `bootstrap_interval`. `value_bounds` are the smallest and largest possible value
    of the quantity, such as −1 and 1 of a cosine, or of the difference between two shares.
    """
    means = _means_of_earthquakes_with_finite_values(value_by_record, earthquake_name_by_record)
    if means.size == 0:
        return MeanOverEarthquakes(0, *(math.nan,) * 3)
    ends = bootstrap_interval(
        mean_of_each_bootstrap_sample,
        means,
        bootstrap_sample_count=bootstrap_sample_count,
        statistic_bounds=value_bounds,
    )
    return MeanOverEarthquakes(int(means.size), float(means.mean()), *ends)


def mean_share_over_earthquakes(
    share_by_record: FloatArray,
    earthquake_name_by_record: Sequence[str] | NDArray[np.str_],
    *,
    bootstrap_sample_count: int = 4000,
) -> MeanOverEarthquakes:
    """Average a share (0 to 1) of each record over the records of an earthquake, then over earthquakes.

    The interval is that of `mean_share_interval`.
    """
    means = _means_of_earthquakes_with_finite_values(share_by_record, earthquake_name_by_record)
    if means.size == 0:
        return MeanOverEarthquakes(0, *(math.nan,) * 3)
    return MeanOverEarthquakes(
        int(means.size), float(means.mean()), *mean_share_interval(means, bootstrap_sample_count=bootstrap_sample_count)
    )


def mean_share_interval(
    share_by_earthquake: FloatArray, *, confidence_level: float = 0.95, bootstrap_sample_count: int = 4000
) -> ConfidenceInterval:
    """Compute the confidence interval of the mean of a share (0 to 1) over earthquakes.

    The interval is that of `mean_interval_for_equal_earthquake_values` if the share is the same in all earthquakes,
    such as 0 or 1. Otherwise it is the `bootstrap_interval`. There is no interval for fewer than
    `MIN_EARTHQUAKES_FOR_INTERVAL`.

    Parameters
    ----------
    share_by_earthquake : ndarray, shape (earthquakes,)
        Share in each earthquake, 0 to 1.
    confidence_level, bootstrap_sample_count
        See `bootstrap_interval`.
    """
    if share_by_earthquake.size < MIN_EARTHQUAKES_FOR_INTERVAL:
        return ConfidenceInterval()
    return exact_interval_if_all_0_or_all_1(share_by_earthquake, confidence_level) or bootstrap_interval(
        mean_of_each_bootstrap_sample,
        share_by_earthquake,
        confidence_level=confidence_level,
        bootstrap_sample_count=bootstrap_sample_count,
        statistic_bounds=(0.0, 1.0),
    )


def exact_interval_if_all_0_or_all_1(
    share_by_earthquake: FloatArray, confidence_level: float = 0.95
) -> ConfidenceInterval | None:
    """Return the exact interval of a mean share if it is 0 in all earthquakes, or 1 in all earthquakes; else None.

    See `mean_interval_for_equal_earthquake_values`.

    Parameters
    ----------
    share_by_earthquake : ndarray, shape (earthquakes,)
        Share in each earthquake, 0 to 1.
    confidence_level : float
        Probability of the interval.
    """
    for value in (0.0, 1.0):
        if share_by_earthquake.size and np.allclose(
            share_by_earthquake, value, rtol=0.0, atol=MAX_ABSOLUTE_DIFFERENCE_OF_EQUAL_VALUES
        ):
            return mean_interval_for_equal_earthquake_values(
                value, share_by_earthquake.size, (0.0, 1.0), confidence_level
            )
    return None


def exact_share_interval(matching_count: int, total_count: int, confidence_level: float = 0.95) -> ConfidenceInterval:
    """Return the exact binomial interval of the share `matching_count`/`total_count` of independent cases.

    The method is that of Clopper & Pearson (1934, Biometrika 26).

    The interval is 0 to 1 if there are no cases.

    Parameters
    ----------
    matching_count, total_count : int
        Number of cases with the property, and of all cases.
    confidence_level : float
        Probability of the interval.
    """
    tail = (1.0 - confidence_level) / 2.0
    low = scipy.special.betaincinv(matching_count, total_count - matching_count + 1, tail) if matching_count else 0.0
    high = (
        scipy.special.betaincinv(matching_count + 1, total_count - matching_count, 1.0 - tail)
        if matching_count < total_count
        else 1.0
    )
    return ConfidenceInterval(float(low), float(high))


def exact_median_interval(independent_values: ArrayLike, confidence_level: float = 0.95) -> ConfidenceInterval:
    """Return the exact interval of the median of independent values: two of the values, chosen by their ranks.

    The ends are the order statistics of David & Nagaraja (2003, Order Statistics, section 7.1). The interval is NaN for
    fewer than six values, whose smallest and largest enclose the median with a probability below 95 %.

    Parameters
    ----------
    independent_values : array_like, shape (n,)
        Values.
    confidence_level : float
        Smallest probability with which the interval contains the median.
    """
    ordered = np.sort(np.asarray(independent_values, np.float64))
    below = int(scipy.stats.binom.ppf((1.0 - confidence_level) / 2.0, ordered.size, 0.5)) if ordered.size else 0
    if below == 0:
        return ConfidenceInterval(math.nan, math.nan)
    return ConfidenceInterval(float(ordered[below - 1]), float(ordered[ordered.size - below]))


def _means_of_earthquakes_with_finite_values(
    value_by_record: FloatArray, earthquake_name_by_record: Sequence[str] | NDArray[np.str_]
) -> FloatArray:
    """Average the finite values of each earthquake's records, shape (earthquakes with a finite value,)."""
    known = np.isfinite(value_by_record)
    return means_by_earthquake(value_by_record[known], np.asarray(earthquake_name_by_record)[known])
