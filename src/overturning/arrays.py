"""Array types of the package, and fast construction of datasets."""

import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from typing_extensions import TypeAliasType

from overturning.errors import ArgumentError

if TYPE_CHECKING:
    import xarray as xr

# Named types: otherwise `help` would print the complete definition of numpy's unions.
ArrayLike = TypeAliasType("ArrayLike", npt.ArrayLike)
"""Any value that numpy can convert to an array."""

FloatArray = TypeAliasType("FloatArray", npt.NDArray[np.float64])
"""Array of numbers in double precision, of any shape."""


def convert_argument_to_float_array(argument_name: str, values: Any, *, copy: bool = False) -> FloatArray:
    """Convert the argument `argument_name` of a public function to a float array; a masked array keeps its mask.

    Parameters
    ----------
    argument_name : str
        Name of the argument in the error message.
    values : array_like
        A number or numbers.
    copy : bool
        Return a new array also where the conversion needs none.

    Raises
    ------
    ArgumentError
        If a value is no real number, such as a date, a time difference or a complex number.
    """
    try:
        if (given := np.asanyarray(values)).dtype.kind not in "mMc":
            return np.array(given, dtype=np.float64, copy=copy or None, subok=np.ma.is_masked(values))
    except (TypeError, ValueError, OverflowError):
        pass
    raise ArgumentError(f"{argument_name}: {str(values)[:60]!r}; it must be a number or a row of numbers") from None


def check_has_no_masked_values(argument_name: str, values: FloatArray) -> None:
    """Raise an ArgumentError for the argument `argument_name` if it is an array with masked values."""
    if np.ma.is_masked(values):
        count = int(np.ma.getmaskarray(values).sum())
        raise ArgumentError(f"{argument_name}: {count} masked values; leave them out")


def convert_argument_to_finite_array(argument_name: str, values: Any, required_shape: tuple[int, ...]) -> FloatArray:
    """Convert the argument `argument_name` of a public function to a new array of finite numbers with the given shape.

    A size of −1 in `required_shape` stands for any number of rows.

    Raises
    ------
    ArgumentError
        If a value is no finite number, or the shape differs from `required_shape`.
    """
    array = np.asarray(convert_argument_to_float_array(argument_name, values, copy=True))
    if array.ndim != len(required_shape) or any(
        size not in (-1, own) for size, own in zip(required_shape, array.shape, strict=True)
    ):
        wanted = str(required_shape).replace("-1", "n")
        raise ArgumentError(f"{argument_name}: shape {array.shape}; give numbers of shape {wanted}")
    if not np.isfinite(array).all():
        raise ArgumentError(f"{argument_name}: {float(array[~np.isfinite(array)][0])}; all numbers must be finite")
    return array


def create_xarray_dataset(
    variables: Mapping[str, tuple[Any, ...]], coordinates: Mapping[str, tuple[Any, ...]], attributes: Mapping[str, Any]
) -> "xr.Dataset":
    """Create an xarray dataset from tuples (dimensions, array, optional attributes) without importing dask.

    `xarray.Dataset` with plain tuples would import dask (0.3 s) to check for dask arrays.
    """
    import xarray as xr

    def to_xarray_variables(array_tuples_by_name: Mapping[str, tuple[Any, ...]]) -> "dict[str, xr.Variable]":
        """Convert tuples (dimensions, array, optional attributes) to xarray variables, by name."""
        return {
            name: xr.Variable(dimensions, np.asarray(values), attrs=about[0] if about else None, fastpath=True)
            for name, (dimensions, values, *about) in array_tuples_by_name.items()
        }

    return xr.Dataset(to_xarray_variables(variables), to_xarray_variables(coordinates), attributes)


class _DaskArrayTypeEntryWithoutImport:
    """Substitute for the dask entry in xarray's table of array types; unlike that entry, it does not import dask."""

    @property
    def type(self) -> tuple[Any, ...]:
        """Tuple with the class of dask arrays, for `isinstance`; empty if dask has not been imported."""
        dask: Any = sys.modules.get("dask.array")
        return (dask.Array,) if hasattr(dask, "Array") else ()


def keep_xarray_from_importing_dask() -> None:
    """Add a substitute for dask to xarray's private table of array types, so that no type check imports dask (0.3 s).

    No array can be a dask array before dask is imported. If xarray has no such table, it imports dask as usual.
    """
    from xarray.namedarray import pycompat

    table: Any = getattr(pycompat, "_cached_duck_array_modules", {})
    table.setdefault("dask", _DaskArrayTypeEntryWithoutImport())
