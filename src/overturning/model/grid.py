"""A grid of cases: rows of values over the dimensions of a model."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.model.cases import Cases, check_count
from overturning.model.variables import Variable

AXES: Final[dict[str, dict[str, Any]]] = {
    "azimuth": {"long_name": "azimuth of the vertical plane of motion, clockwise from north", "units": "degree"},
    "orientation": {
        "long_name": "azimuth that the first side of the body faces, clockwise from north",
        "units": "degree",
    },
    "aspect": {"long_name": "width across the orientation over width along it", "units": "1"},
    # Without a standard name: in CF `height` is the distance of a place above the ground, not a size.
    "height": {"long_name": "height of the block", "units": "m"},
    "b_over_h": {"long_name": "slenderness, width over height of the block", "units": "1"},
    "friction": {"long_name": "friction coefficient between block and base", "units": "1"},
}
"""Dimensions of models, and their CF attributes."""


@dataclass(frozen=True)
class Grid:
    """Coordinates of the cases of one motion.

    Parameters
    ----------
    rows : dict of ndarray
        Values of each dimension by its name, in order: first the direction, degrees clockwise from north.
    element : tuple of str
        Names of the free elements of a scene that has more than one.
    amplitude : tuple of float
        Factors on the motion where there is more than one: the first dimension of what is stored, none of the cases'.
    """

    rows: dict[str, NDArray[Any]]
    element: tuple[str, ...] = ()
    amplitude: tuple[float, ...] = ()

    @classmethod
    def over(cls, element: tuple[str, ...] = (), **rows: ArrayLike) -> Self:
        """The grid over rows of values, shape (n,); `ArgumentError` if one is empty or the cases are too many."""
        checked = {}
        for name, values in rows.items():
            row = np.atleast_1d(np.asarray(values, dtype=np.float64))
            if row.ndim != 1 or row.size == 0:
                raise ArgumentError(f"{name}: shape {row.shape}; give a row of at least one value")
            checked[name.removesuffix("_deg")] = row
        check_count(int(np.prod([float(row.size) for row in checked.values()])))
        return cls(checked, element)

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.rows[name]

    @property
    def names(self) -> tuple[str, ...]:
        """Of the dimensions, in order."""
        return tuple(self.rows)

    @property
    def directions(self) -> FloatArray:
        """Azimuths or orientations, degrees."""
        return self.rows[self.names[0]].astype(np.float64)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each dimension."""
        return tuple(row.size for row in self.rows.values())

    @property
    def size(self) -> int:
        """Number of cases."""
        return int(np.prod(self.shape))

    def changed(self, **rows: NDArray[Any]) -> Self:
        """The same grid with other values of some dimensions."""
        return replace(self, rows=self.rows | rows)

    def over_all(self, values: NDArray[Any]) -> NDArray[Any]:
        """Values of each direction and aspect, shape (directions, 1) or (directions, aspects), in the grid's shape."""
        shape = [1] * len(self.names)
        shape[0] = values.shape[0]
        if "aspect" in self.names:
            shape[self.names.index("aspect")] = values.shape[1]
        return np.broadcast_to(values.reshape(shape), self.shape)

    def cases(
        self, places: Sequence[NDArray[np.intp]], turn_deg: FloatArray | float = 0.0, **columns: ArrayLike
    ) -> Cases:
        """Cases of cells at places along each dimension, turned back so far from their directions; further columns."""
        values = {name: self[name][at].astype(np.float64) for name, at in zip(self.names, places, strict=True)}
        return Cases(values.pop(self.names[0]) - turn_deg, **values, **columns)

    def dimensions(self, variable: Variable) -> tuple[str, ...]:
        """Dimensions of a variable of the outcome, without that of the records."""
        before = ("amplitude",) if self.amplitude else ()
        return (*before, *self.names, *(("element",) if self.element and variable.per_element else ()))

    def shape_of(self, variable: Variable) -> tuple[int, ...]:
        """Sizes of those dimensions."""
        sizes = self.rows | {"element": np.array(self.element), "amplitude": np.array(self.amplitude)}
        return tuple(sizes[name].size for name in self.dimensions(variable))
