"""Scores of predicted probabilities, with bootstrap intervals over motions.

Tests of one record are not independent, so whole motions are drawn. The intervals are those of the package
(`overturning.statistics.bootstrap`), with motions in the place of earthquakes.
"""

import math
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.statistics.bootstrap import (
    MIN_BOOTSTRAP_SAMPLES_PER_TAIL,
    MIN_EARTHQUAKES_FOR_INTERVAL,
    ConfidenceInterval,
    exact_interval_if_all_0_or_all_1,
    interval_tail_share_for_few_earthquakes,
    means_by_earthquake,
)

SCORE_NAMES: Final = ("F1", "AUC", "Brier score")
BOOTSTRAP_SAMPLE_COUNT: Final = 1000


class ReliabilityBin(NamedTuple):
    """Bin of a reliability diagram: mean probability, share that fell with its 95 % interval, and number of tests."""

    mean_probability: float
    fallen_share: float
    fallen_share_interval_low: float
    fallen_share_interval_high: float
    test_count: int


def f1_auc_and_brier_score(predicted_fall_probabilities: FloatArray, fell_by_test: NDArray[np.bool_]) -> FloatArray:
    """Return F1 at probability ½, area under the ROC curve and Brier score; NaN unless there are falls and stands."""
    predicted = predicted_fall_probabilities >= 0.5
    hits, wrong = np.count_nonzero(predicted & fell_by_test), np.count_nonzero(predicted != fell_by_test)
    falls, stands = np.count_nonzero(fell_by_test), np.count_nonzero(~fell_by_test)
    if not (falls and stands):
        return np.full(3, np.nan)
    below = np.sort(predicted_fall_probabilities[~fell_by_test])  # a pair of equal probabilities counts as half
    pairs = sum(
        below.searchsorted(predicted_fall_probabilities[fell_by_test], side).sum() for side in ("left", "right")
    )
    return np.array(
        [
            2 * hits / (2 * hits + wrong),
            0.5 * pairs / (falls * stands),
            float(np.mean((predicted_fall_probabilities - fell_by_test) ** 2)),
        ]
    )


def bootstrap_samples_of_test_indices(
    motion_name_by_test: NDArray[np.str_], bootstrap_sample_count: int = BOOTSTRAP_SAMPLE_COUNT, seed: int = 1
) -> list[NDArray[np.intp]]:
    """Return the test indices of each bootstrap sample; motions are drawn with replacement, each with all its tests.

    More samples than asked for are drawn if fewer than `MIN_BOOTSTRAP_SAMPLES_PER_TAIL` would lie beyond each end of
    the interval of `bootstrap_interval_over_motions`.
    """
    names, member = np.unique(motion_name_by_test, return_inverse=True)
    own = [np.flatnonzero(member == i) for i in range(names.size)]
    if names.size >= MIN_EARTHQUAKES_FOR_INTERVAL:
        bootstrap_sample_count = max(
            bootstrap_sample_count,
            math.ceil(MIN_BOOTSTRAP_SAMPLES_PER_TAIL / interval_tail_share_for_few_earthquakes(names.size)),
        )
    generator = np.random.Generator(np.random.PCG64(seed))
    drawn = generator.integers(names.size, size=(bootstrap_sample_count, names.size)).tolist()
    return [np.concatenate([own[i] for i in sample]) for sample in drawn]


def bootstrap_interval_over_motions(statistic_by_bootstrap_sample: FloatArray, motion_count: int) -> ConfidenceInterval:
    """Return the 95 % percentile interval of a statistic over bootstrap samples, wider for a small number of motions.

    NaN values are left out. With fewer than `MIN_EARTHQUAKES_FOR_INTERVAL` motions both limits are NaN.
    """
    if motion_count < MIN_EARTHQUAKES_FOR_INTERVAL:
        return ConfidenceInterval()
    tail = interval_tail_share_for_few_earthquakes(motion_count)
    low, high = np.nanquantile(statistic_by_bootstrap_sample, [tail, 1 - tail])
    return ConfidenceInterval(float(low), float(high))


def reliability_bins(
    predicted_fall_probabilities: FloatArray,
    fell_by_test: NDArray[np.bool_],
    motion_name_by_test: NDArray[np.str_],
    bootstrap_sample_count: int = BOOTSTRAP_SAMPLE_COUNT,
) -> list[ReliabilityBin]:
    """Return the share of tests with a fall in each bin of predicted probability; omit bins of fewer than five tests.

    Intervals are from a bootstrap over motions, or exact if all tests of a bin fell, or none. A bin with fewer than
    `MIN_EARTHQUAKES_FOR_INTERVAL` motions has no interval.
    """
    edges = np.array([0, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0 + 1e-9])
    place = np.searchsorted(edges, predicted_fall_probabilities, side="right") - 1
    samples = bootstrap_samples_of_test_indices(motion_name_by_test, bootstrap_sample_count)
    bins = []
    for index in range(edges.size - 1):
        own = place == index
        if own.sum() < 5:
            continue
        shares = [fell_by_test[drawn][own[drawn]].mean() for drawn in samples if own[drawn].any()]
        motion_shares = means_by_earthquake(fell_by_test[own].astype(float), motion_name_by_test[own])
        exact = (
            exact_interval_if_all_0_or_all_1(motion_shares)
            if motion_shares.size >= MIN_EARTHQUAKES_FOR_INTERVAL
            else None
        )
        interval = exact or bootstrap_interval_over_motions(np.array(shares), motion_shares.size)
        bins.append(
            ReliabilityBin(
                float(predicted_fall_probabilities[own].mean()),
                float(fell_by_test[own].mean()),
                *interval,
                int(own.sum()),
            )
        )
    return bins
