"""Fall of a stone from 2-D results in several vertical planes, each of which describes the fall over one edge."""

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray


def first_edge(falls: ArrayLike, time: ArrayLike, towards: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """Return the outcome of a stone from its outcomes in several planes.

    The stone falls if it falls in any plane. If it falls in several, it falls over the edge whose tipping angle it
    passes for the last time first: from then on it cannot return, so the other edges no longer matter.

    If the outcome in any plane is missing, the outcome of the stone is missing too: it may have fallen over that edge
    before.

    Parameters
    ----------
    falls : array_like, shape (planes, …)
        1 if it falls in the plane, 0 if it stands, NaN if the outcome is missing.
    time : array_like, shape (planes, …)
        Last time at which it passed its tipping angle, s; ignored for planes in which it stands.
    towards : array_like, shape (planes, …)
        Azimuth of the fall in each plane, degrees.

    Returns
    -------
    falls : ndarray, shape (…)
        1 (falls), 0 (stands), or NaN if an outcome is missing.
    azimuth : ndarray, shape (…)
        Azimuth of the fall, degrees. NaN if it does not fall, or falls in several planes and one of their times is
        missing. If times are equal, the first plane counts.
    """
    flags, times = np.asarray(falls, np.float64), np.asarray(time, np.float64)
    known, falling = np.isfinite(flags).all(axis=0), flags == 1
    fell = known & falling.any(axis=0)
    decided = fell & ((falling.sum(axis=0) == 1) | ~(falling & np.isnan(times)).any(axis=0))
    order = np.where(falling, np.nan_to_num(times, nan=np.inf), np.inf)
    # A fall without a time gets the same infinite time as planes without a fall; `falling` excludes the latter.
    first = np.argmax(falling & (order == order.min(axis=0)), axis=0)
    azimuth = np.take_along_axis(np.asarray(towards, np.float64), first[None], axis=0)[0]
    return np.where(known, fell, np.nan), np.where(decided, azimuth, np.nan)


def edge_probabilities(chance: FloatArray, time: FloatArray) -> FloatArray:
    """Return the probability of falling over each of two edges.

    If all probabilities are 0 or 1, the result agrees with `first_edge`.

    Parameters
    ----------
    chance : ndarray, shape (2, …)
        Probability of falling in each plane; the planes are taken as independent, and no value is missing.
    time : ndarray, shape (2, …)
        Times as in `first_edge`, s. If one is missing, or they are equal, each edge comes first in proportion to its
        probability.

    Returns
    -------
    ndarray, shape (2, …)
    """
    total = chance.sum(axis=0)
    in_proportion = np.divide(chance[0], total, out=np.full(total.shape, 0.5), where=total > 0)
    first = np.where(time[0] < time[1], 1.0, np.where(time[0] > time[1], 0.0, in_proportion))
    both = chance[0] * chance[1]
    return np.asarray(chance * (1 - chance[::-1]) + both * np.stack([first, 1 - first]))
