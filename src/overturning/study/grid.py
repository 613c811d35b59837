"""The cases of a study: every azimuth × height × slenderness × friction."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overturning.study.config import Study

DIMENSIONS = ("azimuth", "height", "b_over_h", "friction")


@dataclass(frozen=True)
class Grid:
    """Coordinates of the cases of one record.

    Attributes
    ----------
    azimuth : ndarray, shape (n_azimuth,)
        Degrees clockwise from north, ascending; int16 where all are whole, float64 otherwise.
    height : ndarray, shape (n_height,)
        Height of the block, m.
    b_over_h : ndarray, shape (n_b_over_h,)
        Slenderness.
    friction : ndarray, shape (n_friction,)
        Friction coefficient.
    """

    azimuth: NDArray[np.generic]
    height: NDArray[np.float64]
    b_over_h: NDArray[np.float64]
    friction: NDArray[np.float64]

    @classmethod
    def of(cls, study: Study) -> "Grid":
        """The grid of a study."""
        azimuth = np.array(study.azimuth.values(), dtype=np.float64)
        whole = np.array_equal(azimuth, np.round(azimuth))
        return cls(
            azimuth.astype(np.int16) if whole else azimuth,
            np.array(study.height, dtype=np.float64),
            np.array(study.b_over_h, dtype=np.float64),
            np.array(study.friction, dtype=np.float64),
        )

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """Numbers of azimuths, heights, slendernesses and frictions."""
        return (self.azimuth.size, self.height.size, self.b_over_h.size, self.friction.size)

    @property
    def size(self) -> int:
        """Number of cases."""
        return int(np.prod(self.shape))

    def coordinates(self) -> dict[str, NDArray[np.generic]]:
        """The coordinates by name of dimension."""
        return {name: getattr(self, name) for name in DIMENSIONS}
