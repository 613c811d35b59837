"""Fall of a stone from the 2-D results in several vertical planes, each for the fall over one edge of its base."""

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray


def fall_flag_and_azimuth_from_planes(
    fall_flag_by_plane: ArrayLike, last_tipping_time_by_plane: ArrayLike, fall_azimuth_by_plane_deg: ArrayLike
) -> tuple[FloatArray, FloatArray]:
    """Return whether a stone falls and the azimuth of the fall, from 2-D simulations in several vertical planes.

    The stone falls if it falls in any plane. If it falls in several, its azimuth is that of the plane in which it
    first passes its tipping angle for good: from then on it cannot return, so the other planes no longer matter.

    If the outcome in any plane is missing, the outcome of the stone is missing too: it may have fallen in that plane
    first.

    Parameters
    ----------
    fall_flag_by_plane : array_like, shape (planes, …)
        1 if the stone falls in the plane, 0 if it stands, NaN if the outcome is missing.
    last_tipping_time_by_plane : array_like, shape (planes, …)
        Last time at which the stone passed its tipping angle, s; ignored for planes in which it stands.
    fall_azimuth_by_plane_deg : array_like, shape (planes, …)
        Azimuth of the fall in each plane, degrees.

    Returns
    -------
    falls : ndarray, shape (…)
        1 (falls), 0 (stands), or NaN if an outcome is missing.
    azimuth : ndarray, shape (…)
        Azimuth of the fall, degrees. NaN if the stone stands, or falls in several planes and one of their times is
        missing. If times are equal, the first plane decides.
    """
    flags, times = np.asarray(fall_flag_by_plane, np.float64), np.asarray(last_tipping_time_by_plane, np.float64)
    known, falling = np.isfinite(flags).all(axis=0), flags == 1
    fell = known & falling.any(axis=0)
    decided = fell & ((falling.sum(axis=0) == 1) | ~(falling & np.isnan(times)).any(axis=0))
    order = np.where(falling, np.nan_to_num(times, nan=np.inf), np.inf)
    # A fall without a time gets the same infinite time as planes without a fall; `falling` excludes the latter.
    first = np.argmax(falling & (order == order.min(axis=0)), axis=0)
    azimuth = np.take_along_axis(np.asarray(fall_azimuth_by_plane_deg, np.float64), first[None], axis=0)[0]
    return np.where(known, fell, np.nan), np.where(decided, azimuth, np.nan)


def fall_probability_over_each_edge(
    fall_probability_by_plane: FloatArray, last_tipping_time_by_plane: FloatArray
) -> FloatArray:
    """Return the probability that a stone falls over each of two perpendicular base edges, shape (2, …).

    The result is computed from the fall probabilities of 2-D simulations in the two vertical planes across the edges.

    If all probabilities are 0 or 1, the result agrees with `fall_flag_and_azimuth_from_planes`.

    Parameters
    ----------
    fall_probability_by_plane : ndarray, shape (2, …)
        Probability of falling in each plane; the planes are taken as independent, and no value is missing.
    last_tipping_time_by_plane : ndarray, shape (2, …)
        Times as in `fall_flag_and_azimuth_from_planes`, s. If one is missing, or both are equal, the probability
        that an edge comes first is proportional to its probability of falling.

    Returns
    -------
    ndarray, shape (2, …)
    """
    total = fall_probability_by_plane.sum(axis=0)
    in_proportion = np.divide(fall_probability_by_plane[0], total, out=np.full(total.shape, 0.5), where=total > 0)
    first = np.where(
        last_tipping_time_by_plane[0] < last_tipping_time_by_plane[1],
        1.0,
        np.where(last_tipping_time_by_plane[0] > last_tipping_time_by_plane[1], 0.0, in_proportion),
    )
    both = fall_probability_by_plane[0] * fall_probability_by_plane[1]
    return np.asarray(
        fall_probability_by_plane * (1 - fall_probability_by_plane[::-1]) + both * np.stack([first, 1 - first])
    )
