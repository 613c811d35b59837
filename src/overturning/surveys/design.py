"""Fraction of the grid of stones that is simulated to infer a motion, and the average over neighbouring faces.

The probability of an outcome is an average over neighbouring sizes, levels, frictions and faces, so that not every
combination of them is needed. Of a rectangular stone every sixth is simulated, in a Latin square: every second
combination of size, level and orientation, with one of the three frictions, so that neighbours differ in friction.
Round stones have no orientations, hence few combinations, and all of them are simulated.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray

ORIENTATION_WEIGHTS: Final = {-1: 0.25, 0: 0.5, 1: 0.25}
"""Weights of a stone's orientation and of its two neighbours: survey azimuths of faces scatter by about 10°."""


def simulated_cells_mask(
    height_index: int, shape_index: int, friction_count: int, level_count: int, orientation_count: int
) -> NDArray[np.bool_]:
    """Return the mask of the simulated combinations for stones of one size, shape (frictions, levels, orientations).

    Indices are those of height and B/H in the grid of sizes. The pattern has the period six along orientations, so
    that it closes after a turn for 6 and 12 orientations. A round stone, with one orientation, has all combinations.
    """
    if orientation_count == 1:
        return np.ones((friction_count, level_count, 1), np.bool_)
    friction, level, orientation = np.ix_(*map(np.arange, (friction_count, level_count, orientation_count)))
    place = height_index + shape_index + level + orientation
    return np.asarray((place % 2 == 0) & (friction == place % friction_count))


def average_over_orientations(shares: FloatArray, direction_bins: int, bins_per_step: int) -> FloatArray:
    """Average shares of outcomes over neighbouring orientations, with directions relative to the face of the stone.

    Parameters
    ----------
    shares : ndarray, shape (levels, orientations, outcomes)
        Shares by outcome: first the direction bins, clockwise from the north of the motion, then others, such as
        standing. Orientations cover the turn after which the stone looks the same.
    direction_bins : int
        Number of direction bins, which cover the circle.
    bins_per_step : int
        Step of the orientation in direction bins.

    Returns
    -------
    ndarray, shape (levels, orientations, outcomes)
        Weighted sums over each orientation and its neighbours; a stone with one orientation keeps its shares.
    """
    if shares.shape[1] == 1:
        return shares
    found = np.zeros_like(shares)
    for step, weight in ORIENTATION_WEIGHTS.items():
        neighbour = np.roll(shares, -step, axis=1)
        # A neighbour that faces further clockwise falls further clockwise by the same angle.
        falls = np.roll(neighbour[..., :direction_bins], -step * bins_per_step, axis=-1)
        found += weight * np.concatenate([falls, neighbour[..., direction_bins:]], axis=-1)
    return found
