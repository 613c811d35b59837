"""The cases of a study: every azimuth × height × slenderness × friction."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.variables import PER_ELEMENT
from overturning.study.config import Study
from overturning.study.scenes import NOMINAL, scene_of

DIMENSIONS = ("azimuth", "height", "b_over_h", "friction")

WITH_ELEMENT = (
    *PER_ELEMENT,
    "probability_towards",
    "probability_away",
    "scramble_difference_towards",
    "scramble_difference_away",
)
"""Variables with the dimension `element` where a scene has several free ones: of the outcome, and of the ensemble."""


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
    element : tuple of str
        Names of the free elements of a scene that has more than one; empty otherwise.
    """

    azimuth: NDArray[np.generic]
    height: FloatArray
    b_over_h: FloatArray
    friction: FloatArray
    element: tuple[str, ...] = ()

    @classmethod
    def of(cls, study: Study, variant: str = NOMINAL) -> "Grid":
        """The grid of a study, or of one of its variants."""
        scene = scene_of(study, variant)
        azimuth = np.array(study.azimuth.values(), dtype=np.float64)
        whole = np.array_equal(azimuth, np.round(azimuth))
        return cls(
            azimuth.astype(np.int16) if whole else azimuth,
            np.array(study.height, dtype=np.float64),
            np.array(study.b_over_h, dtype=np.float64),
            np.array(study.friction, dtype=np.float64),
            scene.free if scene is not None and len(scene.free) > 1 else (),
        )

    @property
    def shape(self) -> tuple[int, int, int, int]:
        """Numbers of azimuths, heights, slendernesses and frictions."""
        return (self.azimuth.size, self.height.size, self.b_over_h.size, self.friction.size)

    def dimensions(self, variable: str) -> tuple[str, ...]:
        """Dimensions of a variable of the outcome, without that of the records."""
        return (*DIMENSIONS, "element") if self.element and variable in WITH_ELEMENT else DIMENSIONS

    def shape_of(self, variable: str) -> tuple[int, ...]:
        """Sizes of those dimensions."""
        return (*self.shape, len(self.element)) if len(self.dimensions(variable)) > len(DIMENSIONS) else self.shape

    @property
    def size(self) -> int:
        """Number of cases."""
        return int(np.prod(self.shape))

    def coordinates(self) -> dict[str, NDArray[np.generic]]:
        """The coordinates by name of dimension."""
        return {name: getattr(self, name) for name in DIMENSIONS}
