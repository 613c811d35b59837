"""A grid of cases over azimuth, height, slenderness and friction: which cells are computed, and what all of them hold."""

from dataclasses import dataclass
from typing import Any, ClassVar, Final, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.model.cases import Cases, check_count
from overturning.model.results import Results
from overturning.model.symmetry import representative_planes
from overturning.model.variables import VARIABLES, Variable

DIMENSIONS: Final = ("azimuth", "height", "b_over_h", "friction")


class Axes:
    """Coordinates of the cases of one motion: a row of values for each dimension, by its name."""

    names: ClassVar[tuple[str, ...]]
    """Of the dimensions, in order."""
    element: tuple[str, ...]
    """Names of the free elements of a scene that has more than one."""
    amplitude: tuple[float, ...]
    """Factors on the motion where there is more than one: the first dimension of what is stored, none of the cases'."""

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values of each dimension."""
        return tuple(getattr(self, name).size for name in self.names)

    @property
    def size(self) -> int:
        """Number of cases."""
        return int(np.prod(self.shape))

    def dimensions(self, variable: Variable) -> tuple[str, ...]:
        """Dimensions of a variable of the outcome, without that of the records."""
        before = ("amplitude",) if self.amplitude else ()
        return (*before, *self.names, *(("element",) if self.element and variable.per_element else ()))

    def shape_of(self, variable: Variable) -> tuple[int, ...]:
        """Sizes of those dimensions."""
        return tuple(np.size(getattr(self, name)) for name in self.dimensions(variable))

    def coordinates(self) -> dict[str, NDArray[Any]]:
        """The coordinates by name of dimension."""
        return {name: getattr(self, name) for name in self.names}


@dataclass(frozen=True)
class Grid(Axes):
    """Coordinates of the cases of one motion in planes."""

    names: ClassVar[tuple[str, ...]] = DIMENSIONS

    azimuth: NDArray[Any]  # degrees clockwise from north
    height: FloatArray  # of the reference element, m
    b_over_h: FloatArray  # its slenderness
    friction: FloatArray
    element: tuple[str, ...] = ()
    amplitude: tuple[float, ...] = ()

    @classmethod
    def over(cls, element: tuple[str, ...] = (), **axes: ArrayLike) -> Self:
        """The grid over rows of values, shape (n,); `ArgumentError` if one is none or the cases are too many for one call."""
        rows = {}
        for name, values in axes.items():
            row = np.atleast_1d(np.asarray(values, dtype=np.float64))
            if row.ndim != 1 or row.size == 0:
                raise ArgumentError(f"{name}: shape {row.shape}; give a row of at least one value")
            rows[name.removesuffix("_deg")] = row
        check_count(int(np.prod([float(row.size) for row in rows.values()])))
        return cls(**rows, element=element, amplitude=())

    def cases(self, period: float) -> Cases:
        """The cases to compute where the motion turned by the period, degrees, is the same case."""
        azimuth = self.azimuth[np.unique(representative_planes(self.azimuth, period).cell)].astype(np.float64)
        cells = np.meshgrid(azimuth, self.height, self.b_over_h, self.friction, indexing="ij")
        return Cases(*(values.ravel() for values in cells))

    def spread(self, results: Results, period: float) -> dict[str, NDArray[Any]]:
        """The outcome of these cases in the grid's shape, mirrored where another azimuth answers, and ``block_steps``."""
        sources = representative_planes(self.azimuth, period)
        # Where each azimuth's answer stands among the computed ones.
        computed, place = np.unique(sources.cell, return_inverse=True)
        mirrored = sources.mirrored
        shape = (computed.size, *self.shape[1:])
        arrays = {name: values.reshape(*shape, *values.shape[1:])[place] for name, values in vars(results).items()}
        for variable in VARIABLES:
            if variable.name == "mirrored":
                arrays["mirrored"] = np.broadcast_to(mirrored[:, None, None, None], self.shape).astype(np.int8)
            else:
                arrays[variable.name][mirrored] = variable.from_behind(arrays, mirrored)
        arrays["block_steps"][sources.cell != np.arange(place.size)] = 0
        return arrays
