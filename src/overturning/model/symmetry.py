"""Symmetry of a grid: the simulated case that gives each case's outcome, and the rotation between both.

A block that is its own mirror image gives the mirrored outcome under the motion along φ + 180°: both are one vertical
plane, seen from either side. A 3-D body that looks the same after a rotation about the vertical is the same body. Both
are a rotation of the case by its *period*: 180° in 2-D, where an outcome rotated once is mirrored, and in 3-D the
rotation after which the body looks the same. A scene that is not its own mirror image has the period 360°.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray

PLANE_SYMMETRY_PERIOD_DEG: Final = 180.0
"""Rotation after which a vertical plane is the same plane seen from behind, degrees."""

FULL_TURN_DEG: Final = 360.0
"""Full rotation, degrees."""

_DIRECTION_DEG_DECIMALS: Final = 9
"""Decimals to which directions in degrees are compared: a period of 360/7 has no exact float."""


@dataclass(frozen=True)
class SimulatedDirectionsForRequestedDirections:
    """Simulated directions of a grid from which, by rotation or mirroring, the outcomes of requested directions follow.

    Attributes
    ----------
    simulated_direction_index : ndarray of int
        Index of the simulated direction among the directions of the grid.
    clockwise_rotation_from_simulated_deg : ndarray
        Clockwise rotation from the simulated to the requested direction, degrees: a whole number of periods, or any
        angle for a body of revolution. Azimuths of the outcome do not change, since north does not rotate. Side and
        face numbers do change, because the body's first side, from which they count, is rotated.
    is_mirrored : ndarray of bool
        True if the simulated plane is the requested one seen from behind: a fall towards its azimuth is a fall away
        from the requested azimuth. Always False in 3-D.
    is_within_simulated_directions : ndarray of bool
        True if the simulated directions on both sides of the requested one are at most 180° apart, or one equals it.
    """

    simulated_direction_index: NDArray[np.intp]
    clockwise_rotation_from_simulated_deg: FloatArray
    is_mirrored: NDArray[np.bool_]
    is_within_simulated_directions: NDArray[np.bool_]


def nearest_simulated_planes(
    simulated_azimuth_deg: ArrayLike,
    requested_azimuth_deg: ArrayLike,
    symmetry_period_deg: float = PLANE_SYMMETRY_PERIOD_DEG,
) -> SimulatedDirectionsForRequestedDirections:
    """Return the simulated vertical plane nearest to each azimuth; flagged as mirrored if seen from behind (+180°)."""
    return copy_with_mirrored_planes_marked(
        nearest_simulated_directions(simulated_azimuth_deg, requested_azimuth_deg, symmetry_period_deg),
        symmetry_period_deg,
    )


def nearest_simulated_directions(
    simulated_direction_deg: ArrayLike, requested_direction_deg: ArrayLike, symmetry_period_deg: float
) -> SimulatedDirectionsForRequestedDirections:
    """Return the simulated directions that, rotated by whole symmetry periods, are nearest to given directions.

    Parameters
    ----------
    simulated_direction_deg : array_like, shape (n,)
        Azimuths or orientations of a grid, degrees clockwise from north, in any order; at least one.
    requested_direction_deg : array_like, shape (m,)
        Requested directions, degrees, of any range. Half way between two simulated ones the anticlockwise one is taken.
    symmetry_period_deg : float
        Rotation period of a case: `PLANE_SYMMETRY_PERIOD_DEG` in 2-D, the body's own in 3-D, 360 without symmetry, 0
        for a body of revolution.

    Returns
    -------
    SimulatedDirectionsForRequestedDirections
        Shape (m,). Of simulated directions that coincide after rotation, the one with the least rotation is taken.
    """
    direction, asked = np.asarray(simulated_direction_deg, np.float64), np.asarray(requested_direction_deg, np.float64)
    if symmetry_period_deg == 0.0:
        cell = np.zeros(asked.shape, np.intp)
        return SimulatedDirectionsForRequestedDirections(
            cell, asked - direction[0], cell.astype(bool), ~cell.astype(bool)
        )
    turns: FloatArray = symmetry_period_deg * np.arange(round(FULL_TURN_DEG / symmetry_period_deg), dtype=np.float64)
    # Ends of the turned cells round the compass; of equal ones the first, which is turned least.
    end, first = np.unique(_reduce_to_period(turns[:, None] + direction, FULL_TURN_DEG), return_index=True)
    wanted = _reduce_to_period(asked, FULL_TURN_DEG)
    after = np.searchsorted(end, wanted, side="right")
    before, after = after - 1, after % end.size
    past, ahead = (wanted - end[before]) % FULL_TURN_DEG, (end[after] - wanted) % FULL_TURN_DEG
    chosen = first[np.where(ahead < past - 10.0**-_DIRECTION_DEG_DECIMALS, after, before)]
    known = (past == 0.0) | (past + ahead <= FULL_TURN_DEG / 2)
    return SimulatedDirectionsForRequestedDirections(
        chosen % direction.size, turns[chosen // direction.size], np.zeros(asked.shape, np.bool_), known
    )


def copy_with_mirrored_planes_marked(
    equivalent_directions: SimulatedDirectionsForRequestedDirections, symmetry_period_deg: float
) -> SimulatedDirectionsForRequestedDirections:
    """Return a copy with `is_mirrored` True where a plane is rotated by 180°, if this is the symmetry period."""
    return replace(
        equivalent_directions,
        is_mirrored=(equivalent_directions.clockwise_rotation_from_simulated_deg == PLANE_SYMMETRY_PERIOD_DEG)
        & (symmetry_period_deg == PLANE_SYMMETRY_PERIOD_DEG),
    )


def first_equivalent_of_each_direction(
    grid_direction_deg: ArrayLike, alternative_symmetry_periods_deg: ArrayLike
) -> SimulatedDirectionsForRequestedDirections:
    """Return, for each direction of a grid, the first direction of the grid that is equivalent by symmetry.

    Parameters
    ----------
    grid_direction_deg : array_like, shape (n,)
        Azimuths or orientations, degrees clockwise from north.
    alternative_symmetry_periods_deg : array_like, shape (p,)
        Rotation periods (see `nearest_simulated_directions`), for instance one for each aspect of a body.

    Returns
    -------
    SimulatedDirectionsForRequestedDirections
        Shape (n, p). Only a direction i whose `simulated_direction_index[i, k]` is i itself needs to be computed for
        the period k.
    """
    direction = np.asarray(grid_direction_deg, np.float64)
    periods = np.atleast_1d(np.asarray(alternative_symmetry_periods_deg, np.float64))
    cell = np.empty((direction.size, periods.size), np.intp)
    for column, period in enumerate(periods):
        within = _reduce_to_period(direction, period) if period > 0.0 else np.zeros(direction.size)
        first, place = np.unique(within, return_index=True, return_inverse=True)[1:]
        cell[:, column] = first[place]
    turn = _reduce_to_period(direction[:, None] - direction[cell], FULL_TURN_DEG)
    return SimulatedDirectionsForRequestedDirections(
        cell, turn, np.zeros(cell.shape, np.bool_), np.ones(cell.shape, np.bool_)
    )


def _reduce_to_period(angle_deg: FloatArray, period_deg: float) -> FloatArray:
    """Reduce angles to the range from 0 to below the period, rounded so that equal angles compare equal."""
    angle = np.round(np.mod(angle_deg, period_deg), _DIRECTION_DEG_DECIMALS)
    return np.where(angle >= np.round(period_deg, _DIRECTION_DEG_DECIMALS), 0.0, angle)
