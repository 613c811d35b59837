"""Unbiased share of cases whose ensemble runs have different outcomes, although runs stop when shares are accurate."""

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import comb

from overturning.arrays import FloatArray
from overturning.settings import EnsembleSettings
from overturning.study.ensemble import MEMBERS_PER_BATCH, mask_of_narrow_fall_share_intervals

MAX_ENSEMBLE_RUNS_TO_ENUMERATE_STOPPING_ORDERS: Final = 128
"""Largest number of runs per cell for which stopping orders are enumerated."""

_CODE_FACTOR_OF_COUNT_OF_FALLS_TO_PLUS_1: Final = MAX_ENSEMBLE_RUNS_TO_ENUMERATE_STOPPING_ORDERS + MEMBERS_PER_BATCH + 1

RunCountArray = NDArray[np.intp]

RunCountStatistic = Callable[[RunCountArray, RunCountArray, Any], FloatArray]
"""Function of the number of runs that fall to +1, the number that fall to −1, and the number of runs."""


def indicator_that_some_runs_fall_and_others_stand(
    plus_1_fall_counts: RunCountArray, run_counts_of_falls_to_minus_1: RunCountArray, known_run_counts: Any
) -> FloatArray:
    """Return, for each case, 1 if some of its ensemble runs fall and others stand; otherwise 0.

    Of `known_run_counts` runs, `plus_1_fall_counts` fall to +1 and `run_counts_of_falls_to_minus_1` fall to −1.
    """
    fall_counts = plus_1_fall_counts + run_counts_of_falls_to_minus_1
    return np.asarray((fall_counts > 0) & (fall_counts < known_run_counts), np.float64)


def indicator_that_most_runs_fall_and_sides_differ(
    plus_1_fall_counts: RunCountArray, run_counts_of_falls_to_minus_1: RunCountArray, known_run_counts: Any
) -> FloatArray:
    """Return, for each case, 1 if most of its ensemble runs fall, some of these to each side; otherwise 0.

    Of `known_run_counts` runs, `plus_1_fall_counts` fall to +1 and
    `run_counts_of_falls_to_minus_1` fall to −1.
    """
    smaller_counts = np.minimum(plus_1_fall_counts, run_counts_of_falls_to_minus_1)
    fall_counts = plus_1_fall_counts + run_counts_of_falls_to_minus_1
    return np.asarray((smaller_counts > 0) & (2 * fall_counts > known_run_counts), np.float64)


def average_first_batch_statistic_over_run_orders(
    statistic_of_run_counts_function: RunCountStatistic,
    share_of_runs_falling_to_plus_1: ArrayLike,
    share_of_runs_falling_to_minus_1: ArrayLike,
    known_run_counts: ArrayLike,
    ensemble_settings: EnsembleSettings,
) -> FloatArray:
    """Estimate a statistic of each case's first batch of ensemble runs, without bias from sequential stopping.

    A case gets no further runs once its fall probabilities have converged, so a statistic of all its runs depends on
    when they stopped. The first batch has the same size in every case. Its statistic is averaged over all orders of the
    outcomes of a case's runs for which convergence is not reached before the last batch, for independent runs
    (Girshick, Mosteller & Savage 1946, Annals of Mathematical Statistics 17; Jung & Kim 2004, Statistics in Medicine
    23). For a scene with several elements, the convergence of the other elements is neglected.

    Parameters
    ----------
    statistic_of_run_counts_function : callable
        Statistic of a batch, such as `indicator_that_some_runs_fall_and_others_stand`.
    share_of_runs_falling_to_plus_1, share_of_runs_falling_to_minus_1, known_run_counts : array_like, of one shape
        Shares of the runs that fall to +1 and −1, and number of runs with an outcome; 0 if the case was not run.
    ensemble_settings : EnsembleSettings
        Settings of the ensemble.

    Returns
    -------
    ndarray, of that shape
        NaN if the case was not run. Averaged over all orders, without regard to stopping, if the outcome of a run is
        unknown, or with more than `MAX_ENSEMBLE_RUNS_TO_ENUMERATE_STOPPING_ORDERS` runs, for which the difference is
        negligible.
    """
    runs = np.where(np.isfinite(share_of_runs_falling_to_plus_1), np.asarray(known_run_counts, np.float64), 0.0)
    fell, back = (
        np.rint(np.nan_to_num(np.asarray(side)) * runs).astype(np.intp)
        for side in (share_of_runs_falling_to_plus_1, share_of_runs_falling_to_minus_1)
    )
    first = min(MEMBERS_PER_BATCH, ensemble_settings.members)
    orders, (i, j) = (
        _run_sequence_share_by_code_of_two_fall_counts(first),
        _decode_plus_1_and_minus_1_fall_counts(first),
    )
    says, found = statistic_of_run_counts_function(i, j, first), np.zeros(runs.shape)
    # Tabulate the binomial coefficients: there are few different counts of runs, and many cells.
    stood = runs.astype(np.intp) - fell - back
    ways = comb(np.arange(runs.max(initial=0) + 1), np.arange(first + 1)[:, None])
    for place in np.flatnonzero(orders * says):
        some, others = i[place], j[place]
        found += says[place] * (ways[some][fell] * ways[others][back] * ways[first - some - others][stood])
    with np.errstate(invalid="ignore"):
        found /= comb(runs, first)
    sums, made = orders * says, first
    while made <= min(runs.max(initial=0), MAX_ENSEMBLE_RUNS_TO_ENUMERATE_STOPPING_ORDERS):
        ended = np.flatnonzero(runs == made)
        places = fell.flat[ended] * _CODE_FACTOR_OF_COUNT_OF_FALLS_TO_PLUS_1 + back.flat[ended]
        possible = orders[places] > 0
        found.flat[ended[possible]] = (sums[places] / np.where(possible, orders[places], 1.0))[possible]
        i, j = _decode_plus_1_and_minus_1_fall_counts(made)
        unsettled = ~mask_of_narrow_fall_share_intervals(i, np.minimum(j, made), made, ensemble_settings.half_width)
        more = max(min(MEMBERS_PER_BATCH, ensemble_settings.members - made), 1)
        orders, sums = (
            np.convolve(one * unsettled, _run_sequence_share_by_code_of_two_fall_counts(more)) for one in (orders, sums)
        )
        made += more
    return found


def _decode_plus_1_and_minus_1_fall_counts(run_count: int) -> tuple[RunCountArray, RunCountArray]:
    """Return the numbers of runs that fall to +1 and to −1 for each code, an integer that encodes both numbers.

    A code is the first number times `_CODE_FACTOR_OF_COUNT_OF_FALLS_TO_PLUS_1`, plus the second; codes are 0 to
    `run_count` × `_CODE_FACTOR_OF_COUNT_OF_FALLS_TO_PLUS_1`.
    """
    towards, away = np.divmod(
        np.arange(run_count * _CODE_FACTOR_OF_COUNT_OF_FALLS_TO_PLUS_1 + 1), _CODE_FACTOR_OF_COUNT_OF_FALLS_TO_PLUS_1
    )
    return towards, away


def _run_sequence_share_by_code_of_two_fall_counts(run_count: int) -> FloatArray:
    """Return, for each code of two fall counts, the share of all possible sequences of runs that have these counts.

    A sequence has `run_count` outcomes (+1, −1 or stands). For codes see `_decode_plus_1_and_minus_1_fall_counts`.
    """
    towards, away = _decode_plus_1_and_minus_1_fall_counts(run_count)
    return np.asarray(comb(run_count, towards) * comb(run_count - towards, away) / 3.0**run_count)
