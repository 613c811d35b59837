"""A grid of cases in space: which orientations another one answers for, by the body's symmetry."""

from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.grid import Axes
from overturning.dem.solid.shapes import Shape

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


def reduced(orientation: NDArray[Any], period: FloatArray) -> FloatArray:
    """Orientations brought within the body's periods, degrees, shape (orientations, aspects)."""
    rows, columns = np.asarray(orientation, np.float64)[:, None], period[None, :]
    return np.asarray(np.round(np.where(columns > 0.0, np.mod(rows, np.where(columns > 0.0, columns, 1.0)), 0.0), 9))


def answering(orientation: NDArray[Any], period: FloatArray) -> NDArray[np.int64]:
    """For each orientation and period the position of the orientation that answers for it, itself where there is no other."""
    within = reduced(orientation, period)
    own = np.arange(within.shape[0])[:, None]
    same = within[:, None, :] == reduced(orientation, np.full(period.size, 360.0))[None, :, :]
    return np.where(same.any(axis=1), same.argmax(axis=1), own)
