"""Symmetry: which cell of a grid answers for which case, and how its answer is turned.

A block that is its own mirror image gives the mirrored answer under the motion along φ + 180°: both are one vertical
plane, seen from either side. A body in space that looks the same after a turn about the vertical is the same body after
it. Both are a turn of the case by its *period*: 180° in planes, where an answer that was turned once is mirrored, and
in space the turn after which the body looks the same. A scene that is not its own mirror image has the period 360°.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray

PLANE_PERIOD: Final = 180.0
"""Turn after which a vertical plane is the same, seen from behind, degrees."""

FULL_TURN: Final = 360.0
"""Turn after which anything is the same, degrees."""

_DIGITS: Final = 9
"""Directions in degrees that agree to so many decimals are the same: a period of 360/7 has no exact number."""


@dataclass(frozen=True)
class Sources:
    """For each case that is asked for, the cell that answers; arrays of the shape of what is asked.

    Attributes
    ----------
    cell : ndarray of int
        Its place among the directions of the grid.
    turn_deg : ndarray
        A whole number of periods, degrees, by which the cell is turned clockwise to be the case that is asked for; of a
        body that looks the same from everywhere any angle. Azimuths of its answer stay as they are, since north does
        not turn; a side or a face that is counted from the body's own is to be counted from the turned one.
    mirrored : ndarray of bool
        Whether the cell is a plane seen from behind: its fall towards the azimuth is one away from it. Never in space.
    known : ndarray of bool
        Whether the cell is an answer: none is in a gap of the grid, turned by all periods, of more than half a circle.
    """

    cell: NDArray[np.intp]
    turn_deg: FloatArray
    mirrored: NDArray[np.bool_]
    known: NDArray[np.bool_]


def nearest_planes(azimuth_deg: ArrayLike, asked_deg: ArrayLike, period_deg: float = PLANE_PERIOD) -> Sources:
    """The planes nearest to azimuths asked for, as of `nearest`, mirrored where they must be turned by 180°."""
    return mirrored_planes(nearest(azimuth_deg, asked_deg, period_deg), period_deg)


def nearest(direction_deg: ArrayLike, asked_deg: ArrayLike, period_deg: float) -> Sources:
    """The cells whose directions, turned by whole periods, are nearest to those asked for.

    Parameters
    ----------
    direction_deg : array_like, shape (n,)
        Azimuths or orientations of a grid, degrees clockwise from north, in any order; at least one.
    asked_deg : array_like, shape (m,)
        Directions asked for, any real numbers. Half way between two cells the one before it, anticlockwise, answers.
    period_deg : float
        Turn after which a case is the same: `PLANE_PERIOD` in planes, a body's own in space, 360 for none, 0 where any
        turn is.

    Returns
    -------
    Sources
        Shape (m,). Of a cell and one that must be turned to be it, the former, so that nothing is taken from behind
        which the grid holds itself.
    """
    direction, asked = np.asarray(direction_deg, np.float64), np.asarray(asked_deg, np.float64)
    if period_deg == 0.0:
        cell = np.zeros(asked.shape, np.intp)
        return Sources(cell, asked - direction[0], cell.astype(bool), ~cell.astype(bool))
    turns: FloatArray = period_deg * np.arange(round(FULL_TURN / period_deg), dtype=np.float64)
    # Ends of the turned cells round the compass; of equal ones the first, which is turned least.
    end, first = np.unique(_within(turns[:, None] + direction, FULL_TURN), return_index=True)
    wanted = _within(asked, FULL_TURN)
    after = np.searchsorted(end, wanted, side="right")
    before, after = after - 1, after % end.size
    past, ahead = (wanted - end[before]) % FULL_TURN, (end[after] - wanted) % FULL_TURN
    chosen = first[np.where(ahead < past - 10.0**-_DIGITS, after, before)]
    known = (past == 0.0) | (past + ahead <= FULL_TURN / 2)
    return Sources(chosen % direction.size, turns[chosen // direction.size], np.zeros(asked.shape, np.bool_), known)


def mirrored_planes(sources: Sources, period_deg: float) -> Sources:
    """Planes of that period, those that were turned by 180° mirrored."""
    return replace(sources, mirrored=(sources.turn_deg == PLANE_PERIOD) & (period_deg == PLANE_PERIOD))


def representatives(direction_deg: ArrayLike, period_deg: ArrayLike) -> Sources:
    """For each direction of a grid the first one of the grid that is the same case, itself where it is that.

    Parameters
    ----------
    direction_deg : array_like, shape (n,)
        Azimuths or orientations, degrees clockwise from north.
    period_deg : array_like, shape (p,)
        As of `nearest`, for instance for each aspect of a body.

    Returns
    -------
    Sources
        Shape (n, p). Only cells that answer for themselves need be computed.
    """
    direction, periods = np.asarray(direction_deg, np.float64), np.atleast_1d(np.asarray(period_deg, np.float64))
    cell = np.empty((direction.size, periods.size), np.intp)
    for column, period in enumerate(periods):
        within = _within(direction, period) if period > 0.0 else np.zeros(direction.size)
        first, place = np.unique(within, return_index=True, return_inverse=True)[1:]
        cell[:, column] = first[place]
    turn = _within(direction[:, None] - direction[cell], FULL_TURN)
    return Sources(cell, turn, np.zeros(cell.shape, np.bool_), np.ones(cell.shape, np.bool_))


def _within(angle_deg: FloatArray, period: float) -> FloatArray:
    """Angles brought into [0, period), rounded so that equal ones are equal."""
    angle = np.round(np.mod(angle_deg, period), _DIGITS)
    return np.where(angle >= np.round(period, _DIGITS), 0.0, angle)
