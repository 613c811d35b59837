"""Types of arrays that the whole package uses, and datasets of them."""

import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt
from typing_extensions import TypeAliasType

if TYPE_CHECKING:
    import xarray as xr

# By their names in `help`, which else would spell out all that numpy takes for an array.
ArrayLike = TypeAliasType("ArrayLike", npt.ArrayLike)
"""What numpy makes an array of."""

FloatArray = TypeAliasType("FloatArray", npt.NDArray[np.float64])
"""Array of numbers in double precision, of any shape."""


def dataset(
    variables: Mapping[str, tuple[Any, ...]], coordinates: Mapping[str, tuple[Any, ...]], attributes: Mapping[str, Any]
) -> "xr.Dataset":
    """A dataset of dimensions, array and, where there are any, attributes of each variable and coordinate.

    The constructor by itself would import dask, a third of a second, to see whether the arrays are dask's.
    """
    import xarray as xr

    def taken(given: Mapping[str, tuple[Any, ...]]) -> "dict[str, xr.Variable]":
        return {
            name: xr.Variable(dimensions, np.asarray(values), attrs=about[0] if about else None, fastpath=True)
            for name, (dimensions, values, *about) in given.items()
        }

    return xr.Dataset(taken(variables), taken(coordinates), attributes)


class _Dask:
    @property
    def type(self) -> tuple[Any, ...]:
        """The class of dask's arrays, or none."""
        dask: Any = sys.modules.get("dask.array")
        return (dask.Array,) if hasattr(dask, "Array") else ()


def spare_dask() -> None:
    """Keep xarray from importing dask's arrays, a third of a second, to see that what it holds is none of them.

    Nothing can be one before something has imported them. A version of xarray that keeps no such table imports them.
    """
    from xarray.namedarray import pycompat

    table: Any = getattr(pycompat, "_cached_duck_array_modules", {})
    table.setdefault("dask", _Dask())
