"""Disagreement of ensemble runs, independent of the stopping rule of each cell."""

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import comb

from overturning.arrays import FloatArray
from overturning.study.ensemble import BATCH, narrow
from overturning.study.sections import Ensemble

MOST_RUNS: Final = 128
"""Largest number of runs per cell for which stopping orders are enumerated."""

_WIDE: Final = MOST_RUNS + BATCH + 1

Counts = NDArray[np.intp]

Statistic = Callable[[Counts, Counts, Any], FloatArray]
"""Function of the numbers of runs that fall towards, away, and in all."""


def divided(towards: Counts, away: Counts, runs: Any) -> FloatArray:
    """Return 1 where some runs fall and others stand."""
    return np.asarray((towards + away > 0) & (towards + away < runs), np.float64)


def to_both_sides(towards: Counts, away: Counts, runs: Any) -> FloatArray:
    """Return 1 where most runs fall, but not all to the same side."""
    return np.asarray((np.minimum(towards, away) > 0) & (2 * (towards + away) > runs), np.float64)


def first_batch_estimate(
    statistic: Statistic, towards: ArrayLike, away: ArrayLike, members: ArrayLike, settings: Ensemble
) -> FloatArray:
    """Estimate a statistic of the first batch of each cell from the shares of all its runs, without bias from stopping.

    A cell that is `settled` gets no further runs, in which it could show that it is divided after all; a share of cells
    counted over all runs hangs on that. The first batch has the same size everywhere. Its statistic is averaged over
    all orders in which the runs of a cell may have come without settling it before the last batch, for runs drawn
    independently (Girshick, Mosteller & Savage 1946, Annals of Mathematical Statistics 17; Jung & Kim 2004, Statistics
    in Medicine 23). Of a scene of several elements the others are left out of account.

    Parameters
    ----------
    statistic : callable
        Such as `divided`.
    towards, away, members : array_like, of one shape
        Shares of the runs that fall to either side, and how many have an outcome; 0 where none was made.
    settings : Ensemble
        By which they were made.

    Returns
    -------
    ndarray, of that shape
        Missing where no run was made. Where the outcome of a run is not known, and from more than `MOST_RUNS` on, where
        it makes no difference, of all orders.
    """
    runs = np.where(np.isfinite(towards), np.asarray(members, np.float64), 0.0)
    fell, back = (np.rint(np.nan_to_num(np.asarray(side)) * runs).astype(np.intp) for side in (towards, away))
    first = min(BATCH, settings.members)
    orders, (i, j) = _orders(first), _sides(first)
    says, found = statistic(i, j, first), np.zeros(runs.shape)
    # Binomial coefficients from a table: there are few counts of runs, and many cells.
    stood = runs.astype(np.intp) - fell - back
    ways = comb(np.arange(runs.max(initial=0) + 1), np.arange(first + 1)[:, None])
    for place in np.flatnonzero(orders * says):
        some, others = i[place], j[place]
        found += says[place] * (ways[some][fell] * ways[others][back] * ways[first - some - others][stood])
    with np.errstate(invalid="ignore"):
        found /= comb(runs, first)
    sums, made = orders * says, first
    while made <= min(runs.max(initial=0), MOST_RUNS):
        ended = np.flatnonzero(runs == made)
        places = fell.flat[ended] * _WIDE + back.flat[ended]
        possible = orders[places] > 0
        found.flat[ended[possible]] = (sums[places] / np.where(possible, orders[places], 1.0))[possible]
        i, j = _sides(made)
        unsettled = ~narrow(i, np.minimum(j, made), made, settings.half_width)
        more = max(min(BATCH, settings.members - made), 1)
        orders, sums = (np.convolve(one * unsettled, _orders(more)) for one in (orders, sums))
        made += more
    return found


def _sides(runs: int) -> tuple[Counts, Counts]:
    """Return the runs that fall towards and away at each position of an array of orders (two-digit codes)."""
    towards, away = np.divmod(np.arange(runs * _WIDE + 1), _WIDE)
    return towards, away


def _orders(runs: int) -> FloatArray:
    """Count the orders of one batch with given numbers of falls to either side, as a share of all orders."""
    towards, away = _sides(runs)
    return np.asarray(comb(runs, towards) * comb(runs - towards, away) / 3.0**runs)
