"""A cube larger than memory, read one record at a time."""

from collections.abc import Callable, Iterator, Sequence

import xarray as xr


def one_record(cube: xr.Dataset, record: int | list[int], names: Sequence[str] = ()) -> xr.Dataset:
    """One record of a cube in memory, read at once: many small dask graphs cost more.

    Parameters
    ----------
    cube : Dataset
        In memory, or as lazy as `overturning.open_cube` opens it.
    record : int or list of int
        Its place; in a list the dimension of the records is kept.
    names : sequence of str
        Variables to read of those that the cube has; not given: all.
    """
    chosen = cube[[name for name in names if name in cube]] if names else cube
    return chosen.isel(record=record).load()


def each_record(cube: xr.Dataset, names: Sequence[str]) -> Iterator[xr.Dataset]:
    """The records of a cube in turn, each a cube of one record; variables as of `one_record`."""
    for record in range(cube.sizes["record"]):
        yield one_record(cube, [record], names)


def by_record(function: Callable[[xr.Dataset], xr.Dataset], cube: xr.Dataset, names: Sequence[str]) -> xr.Dataset:
    """What a function makes of each record, along their dimension; without that dimension, of the whole cube.

    The variables of what it makes have that dimension too; those that it is given are as of `one_record`.
    """
    if "record" not in cube.dims:
        return function(cube)
    made = [function(one) for one in each_record(cube, names)]
    return xr.concat(made, "record", data_vars="minimal", coords="minimal", compat="override", join="override")
