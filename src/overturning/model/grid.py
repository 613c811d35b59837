"""Grid of cases: values along each dimension of a model."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Final, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray, check_has_no_masked_values, convert_argument_to_float_array
from overturning.errors import ArgumentError
from overturning.model.cases import Cases, check_case_count, check_directions_within_allowed_range
from overturning.model.variables import OutcomeVariable

CF_ATTRIBUTES_BY_DIMENSION: Final[dict[str, dict[str, Any]]] = {
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


def checked_finite_values(argument_name: str, values: ArrayLike) -> FloatArray:
    """Convert an argument of a public function, one or several finite numbers, to an array of shape (n,).

    Raises
    ------
    ArgumentError
        If the argument is empty, nested, or not of finite numbers.
    """
    row = np.atleast_1d(convert_argument_to_float_array(argument_name, values))
    check_has_no_masked_values(argument_name, row)
    if row.ndim != 1 or row.size == 0:
        remedy = "at least one value" if row.size == 0 else "one row, without rows in it"
        raise ArgumentError(f"{argument_name}: shape {row.shape}; give {remedy}")
    if not np.isfinite(row).all():
        raise ArgumentError(f"{argument_name}: {row[~np.isfinite(row)][0]:g}; it must be finite")
    return row


@dataclass(frozen=True)
class CaseGrid:
    """Grid of the cases simulated under one motion: values of direction, height, B/H, friction and other dimensions.

    Parameters
    ----------
    values_by_dimension : dict of ndarray
        Values of each dimension by its name, in order: first the direction, degrees clockwise from north.
    free_element_names_if_several : tuple of str
        Names of the free elements of a scene that has more than one.
    motion_amplitude_factors_if_several : tuple of float
        Factors on the motion if there is more than one; first dimension of the stored arrays, not of the cases.
    """

    values_by_dimension: dict[str, NDArray[Any]]
    free_element_names_if_several: tuple[str, ...] = ()
    motion_amplitude_factors_if_several: tuple[float, ...] = ()

    @classmethod
    def from_values(cls, free_element_names_if_several: tuple[str, ...] = (), **dimension_values: ArrayLike) -> Self:
        """Return the grid of all combinations of given values of each dimension, such as azimuth and height.

        Raises
        ------
        ArgumentError
            If the values of a dimension are missing, nested or not finite, or the cases are too many.
        """
        checked = {}
        for name, values in dimension_values.items():
            row = checked_finite_values(name, values)
            if name.endswith("_deg"):
                check_directions_within_allowed_range(name, row)
            checked[name.removesuffix("_deg")] = row
        check_case_count(int(np.prod([float(row.size) for row in checked.values()])))
        return cls(checked, free_element_names_if_several)

    def __getitem__(self, name: str) -> NDArray[Any]:
        return self.values_by_dimension[name]

    @property
    def dimension_names(self) -> tuple[str, ...]:
        """Names of the grid's dimensions; the first is the azimuth of the motion or the orientation of the body."""
        return tuple(self.values_by_dimension)

    @property
    def direction_values_deg(self) -> FloatArray:
        """Values of the first grid dimension, degrees: azimuths of the motion (2-D) or orientations of a body (3-D)."""
        return self.values_by_dimension[self.dimension_names[0]].astype(np.float64)

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values along each dimension of the grid, such as azimuth, height, B/H and friction."""
        return tuple(row.size for row in self.values_by_dimension.values())

    @property
    def case_count(self) -> int:
        """Number of cases of the grid: the product of its numbers of values along all dimensions."""
        return int(np.prod(self.shape))

    def copy_with_dimension_values(self, **new_rows: NDArray[Any]) -> Self:
        """Return a copy of the grid with other values along some dimensions, given by dimension name."""
        return replace(self, values_by_dimension=self.values_by_dimension | new_rows)

    def broadcast_over_grid(self, values_by_direction_and_aspect: NDArray[Any]) -> NDArray[Any]:
        """Broadcast values by direction and aspect D/B, shape (directions, 1 or aspects), to the shape of the grid."""
        shape = [1] * len(self.dimension_names)
        shape[0] = values_by_direction_and_aspect.shape[0]
        if "aspect" in self.dimension_names:
            shape[self.dimension_names.index("aspect")] = values_by_direction_and_aspect.shape[1]
        return np.broadcast_to(values_by_direction_and_aspect.reshape(shape), self.shape)

    def cases_at_grid_indices(
        self,
        indices_along_dimensions: Sequence[NDArray[np.intp]],
        angle_subtracted_from_direction_deg: FloatArray | float = 0.0,
        **further_columns: ArrayLike,
    ) -> Cases:
        """Return the parameters (direction, height, B/H, …) of the cases at given indices along each dimension.

        Parameters
        ----------
        indices_along_dimensions : sequence of ndarray
            For each dimension, the index of each case along it.
        angle_subtracted_from_direction_deg : ndarray or float
            Angle subtracted from the azimuth or orientation of each case, degrees.
        **further_columns
            Further parameters of `Cases`, such as ``amplitude``, by name.
        """
        values = {
            name: self[name][at].astype(np.float64)
            for name, at in zip(self.dimension_names, indices_along_dimensions, strict=True)
        }
        return Cases(
            values.pop(self.dimension_names[0]) - angle_subtracted_from_direction_deg, **values, **further_columns
        )

    def one_record_cube_dimensions_of_variable(self, variable: OutcomeVariable) -> tuple[str, ...]:
        """Return an outcome variable's dimensions in one record's results: amplitude, those of the grid, element."""
        before = ("amplitude",) if self.motion_amplitude_factors_if_several else ()
        return (
            *before,
            *self.dimension_names,
            *(("element",) if self.free_element_names_if_several and variable.has_element_dimension else ()),
        )

    def one_record_cube_shape_of_variable(self, variable: OutcomeVariable) -> tuple[int, ...]:
        """Return the shape of an outcome variable in the results of one record."""
        sizes = self.values_by_dimension | {
            "element": np.array(self.free_element_names_if_several),
            "amplitude": np.array(self.motion_amplitude_factors_if_several),
        }
        return tuple(sizes[name].size for name in self.one_record_cube_dimensions_of_variable(variable))
