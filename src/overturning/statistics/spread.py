"""Over the runs of an ensemble: in how many cells they are divided, whatever the rule by which each cell ended."""

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import comb

from overturning.arrays import FloatArray
from overturning.study.ensemble import BATCH, narrow
from overturning.study.sections import Ensemble

MOST_RUNS: Final = 128
"""Of a cell, up to which the orders are counted in which it is not settled before."""

Counts = NDArray[np.intp]

Statistic = Callable[[Counts, Counts, Any], FloatArray]
"""From counts of runs that fall towards and away, of so many, to what they say."""


def divided(towards: Counts, away: Counts, runs: Any) -> FloatArray:
    """1 where some runs fall and others stand."""
    return np.asarray((towards + away > 0) & (towards + away < runs), np.float64)


def to_both_sides(towards: Counts, away: Counts, runs: Any) -> FloatArray:
    """1 where most runs fall, but not all to the same side."""
    return np.asarray((np.minimum(towards, away) > 0) & (2 * (towards + away) > runs), np.float64)


def of_first_batch(
    statistic: Statistic, towards: ArrayLike, away: ArrayLike, members: ArrayLike, settings: Ensemble
) -> FloatArray:
    """What the first batch of each cell said, given the shares of all of its runs: unbiased, whatever ended them.

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
    batches = [min(BATCH, settings.members - made) for made in range(0, settings.members, BATCH)]
    say = np.zeros((batches[0] + 1,) * 2)
    found = np.zeros(runs.shape)
    for i, j in np.argwhere(np.add(*np.indices(say.shape)) <= batches[0]):
        say[i, j] = statistic(i, j, batches[0])
        found += say[i, j] * comb(fell, i) * comb(back, j) * comb(runs - fell - back, batches[0] - i - j)
    with np.errstate(invalid="ignore"):
        found /= comb(runs, batches[0])
    orders, told, made = np.ones((1, 1)), np.ones((1, 1)), 0
    for size in batches:
        if made >= min(runs.max(initial=0), MOST_RUNS):
            break
        i, j = np.indices((size + 1, size + 1))
        ways = np.asarray(comb(size, i) * comb(size - i, j), np.float64) / 3**size  # scaled: numbers hold more runs
        told = _with_more(told, ways * say if made == 0 else ways)
        orders, made = _with_more(orders, ways), made + size
        ended = (runs == made) & (orders[np.minimum(fell, made), np.minimum(back, made)] > 0)
        found[ended] = told[fell[ended], back[ended]] / orders[fell[ended], back[ended]]
        i, j = np.indices(orders.shape)
        unsettled = ~narrow(i, j, made, settings.half_width) & (i + j <= made)
        orders, told = orders * unsettled, told * unsettled
    return found


def _with_more(orders: FloatArray, ways: FloatArray) -> FloatArray:
    """Numbers of orders in which counts are reached, after a batch of which so many orders have so many falls."""
    size = len(orders)
    found = np.zeros((size + len(ways) - 1,) * 2)
    for (i, j), count in np.ndenumerate(ways):
        found[i : i + size, j : j + size] += count * orders
    return found
