"""Scores of predicted probabilities, with bootstrap intervals over motions.

Tests of one record are not independent, so whole motions are drawn.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.stats import rankdata

from overturning.arrays import FloatArray

NAMES: Final = ("F1", "AUC", "Brier score")
DRAWS: Final = 1000


class ReliabilityBin(NamedTuple):
    """Bin of a reliability diagram: mean probability, share that fell with its 95 % interval, and number of tests."""

    probability: float
    fell: float
    low: float
    high: float
    tests: int


def prediction_scores(probabilities: FloatArray, fell: NDArray[np.bool_]) -> FloatArray:
    """Return F1 at probability ½, area under the ROC curve and Brier score; NaN if all fell or all stood."""
    predicted = probabilities >= 0.5
    hits, wrong = int((predicted & fell).sum()), int((predicted != fell).sum())
    falls, stands = int(fell.sum()), int((~fell).sum())
    if not (falls and stands):
        return np.full(3, np.nan)
    area = (rankdata(probabilities)[fell].sum() - falls * (falls + 1) / 2) / (falls * stands)
    return np.array([2 * hits / (2 * hits + wrong), area, float(np.mean((probabilities - fell) ** 2))])


def bootstrap_samples(test_motions: NDArray[np.str_], draws: int = DRAWS, seed: int = 1) -> list[NDArray[np.intp]]:
    """Return the test indices of each bootstrap sample; motions are drawn with replacement, each with all its tests."""
    names, member = np.unique(test_motions, return_inverse=True)
    own = [np.flatnonzero(member == i) for i in range(names.size)]
    generator = np.random.Generator(np.random.PCG64(seed))
    return [np.concatenate([own[i] for i in generator.integers(names.size, size=names.size)]) for _ in range(draws)]


def percentile_interval(sample_values: FloatArray) -> tuple[float, float]:
    """Return the 2.5 and 97.5 % quantiles of bootstrap values, without NaN."""
    low, high = np.nanquantile(sample_values, [0.025, 0.975])
    return float(low), float(high)


def reliability_bins(
    probabilities: FloatArray, fell: NDArray[np.bool_], test_motions: NDArray[np.str_], draws: int = DRAWS
) -> list[ReliabilityBin]:
    """Return the share that fell in bins of probability, with bootstrap intervals; omit bins below five tests."""
    edges = np.array([0, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0 + 1e-9])
    place = np.searchsorted(edges, probabilities, side="right") - 1
    samples = bootstrap_samples(test_motions, draws)
    bins = []
    for index in range(edges.size - 1):
        own = place == index
        if own.sum() < 5:
            continue
        shares = [fell[drawn][own[drawn]].mean() for drawn in samples if own[drawn].any()]
        bins.append(
            ReliabilityBin(
                float(probabilities[own].mean()),
                float(fell[own].mean()),
                *percentile_interval(np.array(shares)),
                int(own.sum()),
            )
        )
    return bins
