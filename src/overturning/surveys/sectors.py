"""Sectors of azimuth in which the fall directions of stones are predicted."""

from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.model.plane_weights import plane_weights_by_azimuth_spacing
from overturning.model.symmetry import FULL_TURN_DEG, nearest_simulated_directions
from overturning.statistics.circular import sector_index

_OCTANT_ASSIGNMENT_PARTS_PER_SECTOR: Final = 64
"""Number of equal parts into which an azimuth sector is divided; each part counts in one octant."""


class AzimuthSectors:
    """Sectors of azimuth that divide the circle: each is about a given azimuth, half way to the neighbouring ones.

    Parameters
    ----------
    sector_azimuths_deg : ndarray, shape (sectors,)
        Azimuths of the sectors, degrees clockwise from north, ascending.

    Attributes
    ----------
    azimuth : ndarray, shape (sectors,)
        The azimuths `sector_azimuths_deg`.
    share : ndarray, shape (sectors,)
        Share of the circle that each sector covers; the sum is 1.
    borders : ndarray, shape (sectors + 1,)
        Borders of the sectors, degrees, ascending; the last one is the first one + 360°.
    """

    def __init__(self, sector_azimuths_deg: FloatArray) -> None:
        self.azimuth: FloatArray = sector_azimuths_deg
        self.share: FloatArray = plane_weights_by_azimuth_spacing(
            sector_azimuths_deg, FULL_TURN_DEG, divide_uncomputed_gaps_between_neighbours=True
        )
        start = (sector_azimuths_deg[0] + sector_azimuths_deg[-1] - 360) / 2
        self.borders: FloatArray = start + 360 * np.concatenate([[0.0], np.cumsum(self.share)])

    def nearest_sector_index(self, azimuth_deg: float) -> int:
        """Return the index of the sector whose azimuth is nearest to `azimuth_deg`."""
        return int(
            nearest_simulated_directions(self.azimuth, [azimuth_deg], FULL_TURN_DEG).simulated_direction_index[0]
        )

    def octant_probabilities_from_sectors(self, fall_direction_probability_by_sector: FloatArray) -> FloatArray:
        """Convert probabilities of azimuth sectors to probabilities of the 8 compass octants.

        The shape is (8,).
        """
        mass = np.repeat(
            fall_direction_probability_by_sector / _OCTANT_ASSIGNMENT_PARTS_PER_SECTOR,
            _OCTANT_ASSIGNMENT_PARTS_PER_SECTOR,
        )
        fine = np.bincount(self._octant_index_of_each_sector_part, mass, 8)
        return np.asarray(fine / fine.sum())

    @cached_property
    def _octant_index_of_each_sector_part(self) -> NDArray[np.intp]:
        """Index of the compass octant in which each part of each azimuth sector lies, shape (sectors × parts,).

        Each sector is divided into `_OCTANT_ASSIGNMENT_PARTS_PER_SECTOR` equal parts.
        """
        within = (np.arange(_OCTANT_ASSIGNMENT_PARTS_PER_SECTOR) + 0.5) / _OCTANT_ASSIGNMENT_PARTS_PER_SECTOR
        return sector_index(self.borders[:-1, None] + np.diff(self.borders)[:, None] * within, 8).ravel()
