"""A grid of cases in space, and the turn after which a body looks the same."""

from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.model.grid import Axes
from overturning.model.shapes import Shape

SPACE_DIMENSIONS: Final = ("orientation", "height", "b_over_h", "aspect", "friction")


@dataclass(frozen=True)
class SpaceGrid(Axes):
    """Coordinates of the cases of one motion in space."""

    names: ClassVar[tuple[str, ...]] = SPACE_DIMENSIONS

    orientation: NDArray[Any]  # azimuth that the body's first side faces, degrees clockwise from north
    height: FloatArray  # m
    b_over_h: FloatArray
    aspect: FloatArray  # D/B
    friction: FloatArray
    element: tuple[str, ...] = ()
    amplitude: tuple[float, ...] = ()


def periods_of(shape: Shape, aspect: FloatArray) -> FloatArray:
    """Turn about the vertical after which the body of each aspect looks the same, degrees; 0 where any one does."""
    return np.array([shape.body(1.0, 0.5, float(value)).period for value in aspect])
