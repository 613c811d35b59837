"""Two answers to the same cases, counted, and how well a share is known from a sample."""

from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.dem.variables import INT8_MISSING

Z_95: Final = NormalDist().inv_cdf(0.975)
"""Two-sided 95 % point of the normal distribution."""


ASIDE: Final = 15.0
"""Degrees between two azimuths of a fall in space from which they are not the same."""


@dataclass(frozen=True)
class Counts:
    """How far the answers to the same cases differ."""

    cases: int = 0  # with an answer in both
    flags: int = 0  # of these, that fall in one answer and stand in the other
    fallen: int = 0  # that fall in both
    sides: int = 0  # of these, that fall to the other side, in space `ASIDE` or more away
    unanswered: int = 0  # without an answer in one or both

    def __add__(self, other: "Counts") -> "Counts":
        names = self.__dataclass_fields__
        return Counts(**{name: getattr(self, name) + getattr(other, name) for name in names})


def apart(first: NDArray[Any], second: NDArray[Any], both: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Which of the cases that fall in both answers go `ASIDE` or more apart, by their azimuths in degrees."""
    turn = np.where(both, first, 0.0) - np.where(both, second, 0.0)
    return np.asarray(np.abs((turn + 180.0) % 360.0 - 180.0) >= ASIDE)


def differ(
    first: NDArray[np.int8], second: NDArray[np.int8], azimuths: tuple[NDArray[Any], NDArray[Any]] | None = None
) -> NDArray[np.bool_]:
    """Which cases have another answer, by arrays of `overturned`, shape (n, elements), and in space of azimuths, (n,)."""
    other = (first != second).any(axis=1)
    if azimuths is not None:
        other |= apart(*azimuths, (first == 1).all(axis=1) & (second == 1).all(axis=1))
    return np.asarray(other)


def compare(
    first: NDArray[np.int8], second: NDArray[np.int8], azimuths: tuple[NDArray[Any], NDArray[Any]] | None = None
) -> Counts:
    """Count how far two arrays of `overturned` differ: +1, −1, 0, or −128 where there is no answer.

    In space the `azimuths` of the falls, degrees, say whether two go the same way.
    """
    known = (first != INT8_MISSING) & (second != INT8_MISSING)
    fell, fell_too = first != 0, second != 0
    both = known & fell & fell_too
    other = first != second if azimuths is None else apart(*azimuths, both)
    return Counts(
        cases=int(known.sum()),
        flags=int((known & (fell != fell_too)).sum()),
        fallen=int(both.sum()),
        sides=int((both & other).sum()),
        unanswered=int((~known).sum()),
    )


def wilson(count: ArrayLike, total: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """95 % interval of a share (Wilson 1927, Journal of the American Statistical Association 22).

    Written out here because scipy's takes one share at a time, and a sweep should not wait for it; a test holds it to scipy's.

    Parameters
    ----------
    count, total : array_like
        Cases counted, of so many.

    Returns
    -------
    (low, high) : ndarray, of the shape of both
        0 and 1 without cases.
    """
    n, k = np.asarray(total, np.float64), np.asarray(count, np.float64)
    known = np.maximum(n, 1.0)
    share, square = k / known, Z_95 * Z_95 / known
    middle = (share + 0.5 * square) / (1.0 + square)
    half = Z_95 / (1.0 + square) * np.sqrt(share * (1.0 - share) / known + 0.25 * square / known)
    return np.where(k == 0, 0.0, middle - half), np.where(k == n, 1.0, middle + half)
