"""Over earthquakes: means of their records, and intervals by bootstrap.

Records of one earthquake share its source, so they are averaged first and count as one; what is drawn with replacement
is earthquakes.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray

FEWEST_EARTHQUAKES: Final = 8
"""Earthquakes below which no interval is given, nor anything said of odds.

A bootstrap of few knows less than it says: of intervals for the mean of n normal values that are said to hold it in 95
% of samples, 88 % hold it for n = 8, 84 for 5, 81 for 4 and 73 for 3, of which the ends are the least and the largest
value.
"""


class Interval(NamedTuple):
    """Ends of an interval; NaN where there is none."""

    low: float = math.nan
    high: float = math.nan


@dataclass(frozen=True)
class Mean:
    """A mean over earthquakes: how many of them, the value, and ends of its interval; NaN where there is none."""

    n: int
    value: float
    low: float
    high: float


def event_means(values: FloatArray, events: Sequence[str] | NDArray[np.str_]) -> FloatArray:
    """Means over the records of each earthquake, in the order of `event_names`.

    Parameters
    ----------
    values : ndarray, shape (records, …)
        NaN where a record has none; such a record does not count, and the mean of none is NaN.
    events : sequence of str, length records
        Earthquake of each record.
    """
    of_record, means = np.asarray(events), []
    for name in event_names(events):
        own = values[of_record == name]
        known = np.isfinite(own)
        count = known.sum(axis=0)
        means.append(np.where(count > 0, np.where(known, own, 0.0).sum(axis=0) / np.maximum(count, 1), np.nan))
    return np.array(means).reshape(len(means), *values.shape[1:])


def event_names(events: Sequence[str] | NDArray[np.str_]) -> list[str]:
    """The earthquakes of some records, each once, in the order in which they first appear."""
    return list(dict.fromkeys(str(event) for event in events))


def resampled(
    statistic: Callable[[NDArray[Any]], FloatArray], per_event: NDArray[Any], draws: int, seed: int = 1
) -> FloatArray:
    """Values of a statistic in bootstrap samples of earthquakes, where it has one; shape (n,).

    Parameters
    ----------
    statistic : callable
        From samples, shape (draws, earthquakes, …), to its values, shape (draws,), NaN where a sample tells nothing.
    per_event : ndarray, shape (earthquakes, …)
        What each earthquake says. Of fewer than `FEWEST_EARTHQUAKES` there are no values, nor where less than half of
        the samples tell anything.
    draws, seed : int
        Samples, each of as many earthquakes drawn with replacement, and their seed.
    """
    n = len(per_event)
    if n < FEWEST_EARTHQUAKES:
        return np.zeros(0)
    values = statistic(per_event[np.random.Generator(np.random.PCG64(seed)).integers(0, n, size=(draws, n))])
    known = values[np.isfinite(values)]
    return known if 2 * known.size >= draws else np.zeros(0)


def bootstrap(
    statistic: Callable[[NDArray[Any]], FloatArray],
    per_event: NDArray[Any],
    *,
    level: float = 0.95,
    draws: int = 4000,
    seed: int = 1,
) -> Interval:
    """Percentile interval of a statistic over earthquakes (Efron & Tibshirani 1993, chapter 13), as of `resampled`."""
    values = resampled(statistic, per_event, draws, seed)
    if not values.size:
        return Interval()
    low, high = np.quantile(values, [(1 - level) / 2, (1 + level) / 2])
    return Interval(float(low), float(high))


def mean_of_sample(drawn: NDArray[Any]) -> FloatArray:
    """The statistic for `bootstrap` of a mean over earthquakes."""
    return np.asarray(drawn.mean(axis=1))


def mean_over_earthquakes(values: FloatArray, events: Sequence[str] | NDArray[np.str_], *, draws: int = 4000) -> Mean:
    """Mean over earthquakes of the means of their records, as of `event_means`, with its `bootstrap` interval."""
    known = np.isfinite(values)
    means = event_means(values[known], np.asarray(events)[known])
    if means.size == 0:
        return Mean(0, *(math.nan,) * 3)
    ends = bootstrap(mean_of_sample, means, draws=draws)
    return Mean(int(means.size), float(means.mean()), *ends)
