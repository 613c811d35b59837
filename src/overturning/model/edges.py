"""Which edge first: the fall of a stone that several vertical planes describe, each the fall over one of its edges."""

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray


def first_edge(falls: ArrayLike, time: ArrayLike, towards: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Outcome of a stone from those in its planes.

    A stone falls where it falls in any of its planes; where in several, over the edge that it is past first: in a plane
    a block past its tipping angle for the last time cannot come back, so it goes over that edge before the others are
    due.

    *Missing stays missing.* Where the outcome in any plane is missing, so is the stone's: it is not said to stand, nor
    to have fallen as another plane has it, since it may have gone over the unknown edge before.

    Parameters
    ----------
    falls : array_like, shape (planes, …)
        1 where it falls in a plane, 0 where it stands, NaN where the outcome is missing.
    time : array_like, shape (planes, …)
        Last time at which it passed its tipping angle, s; of those that stand it is not looked at.
    towards : array_like, shape (planes, …)
        Azimuth towards which it falls there, degrees.

    Returns
    -------
    falls : ndarray, shape (…)
        1, 0, or NaN where an outcome is missing.
    azimuth : ndarray, shape (…)
        Azimuth of the fall, degrees; NaN where it does not fall, and where it falls in several planes and one of these
        times is missing. Of equal times the first plane's.
    """
    flags, times = np.asarray(falls, np.float64), np.asarray(time, np.float64)
    known, falling = np.isfinite(flags).all(axis=0), flags == 1
    fell = known & falling.any(axis=0)
    decided = fell & ((falling.sum(axis=0) == 1) | ~(falling & np.isnan(times)).any(axis=0))
    order = np.where(falling, np.nan_to_num(times, nan=np.inf), np.inf)
    # A fall whose time is missing is as late as what stands, but it falls.
    first = np.argmax(falling & (order == order.min(axis=0)), axis=0)
    azimuth = np.take_along_axis(np.asarray(towards, np.float64), first[None], axis=0)[0]
    return np.where(known, fell, np.nan), np.where(decided, azimuth, np.nan)


def edge_probabilities(chance: FloatArray, time: FloatArray) -> FloatArray:
    """Probability of falling over each of two edges; where both are 0 or 1 it says what `first_edge` says.

    Parameters
    ----------
    chance : ndarray, shape (2, …)
        Probability of falling in each plane, taken as independent; none is missing.
    time : ndarray, shape (2, …)
        As of `first_edge`. Where one is missing, or they tie, each edge comes first in proportion to its probability.

    Returns
    -------
    ndarray, shape (2, …)
    """
    total = chance.sum(axis=0)
    in_proportion = np.divide(chance[0], total, out=np.full(total.shape, 0.5), where=total > 0)
    first = np.where(time[0] < time[1], 1.0, np.where(time[0] > time[1], 0.0, in_proportion))
    both = chance[0] * chance[1]
    return np.asarray(chance * (1 - chance[::-1]) + both * np.stack([first, 1 - first]))
