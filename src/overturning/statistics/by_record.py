"""The records of a cube: read a part at a time, since it may be larger than memory, and in groups that are compared."""

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.errors import ArgumentError

AT_ONCE: Final = 40_000
"""Cells that are read together: of fewer, xarray takes longer over its own work than over the numbers."""


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


def few_records(cube: xr.Dataset, names: Sequence[str]) -> Iterator[tuple[list[int], xr.Dataset]]:
    """Places of some records in turn, of about `AT_ONCE` cells, and the cube of these; variables as of `one_record`."""
    count = cube.sizes["record"]
    few = max(1, AT_ONCE * count // max(cube["overturned"].size, 1))
    for first in range(0, count, few):
        places = list(range(first, min(first + few, count)))
        yield places, one_record(cube, places, names)


def by_record(function: Callable[[xr.Dataset], xr.Dataset], cube: xr.Dataset, names: Sequence[str]) -> xr.Dataset:
    """What a function makes of each record, along their dimension; without that dimension, of the whole cube.

    It is given a few records at a time, with variables as of `one_record`; all that it makes has the dimension of the
    records, too.
    """
    if "record" not in cube.dims:
        return function(cube)
    made = [function(some) for _, some in few_records(cube, names)]
    return xr.concat(made, "record", data_vars="minimal", coords="minimal", compat="override", join="override")


def record_groups(cube: xr.Dataset, by: str = "pulse", edges: Sequence[float] = ()) -> dict[str, NDArray[np.bool_]]:
    """Members by name of the group; a record of which it is not known is in none.

    Parameters
    ----------
    cube : Dataset
        The cube.
    by : str
        Coordinate of the records: ``pulse`` (pulse records against the control where a study has both, otherwise all
        records together), a word such as ``site_class`` or ``wall``, a group per word, or a number such as ``vs30``.
    edges : sequence of float
        Of a number: where one group ends and the next begins, ascending; an edge belongs to the upper one.

    Raises
    ------
    ArgumentError
        If the cube has no such coordinate, or a number is without edges.
    """
    if by == "pulse":
        pulse = np.atleast_1d(cube["pulse"].to_numpy()).astype(np.float64)
        if (pulse == 1).any() and (pulse == 0).any():
            return {"with a velocity pulse": pulse == 1, "without (control)": pulse == 0}
        return {"all records": np.ones(pulse.size, dtype=bool)}
    if by not in cube.coords or cube[by].dims not in ((), ("record",)):
        known = sorted(str(name) for name in cube.coords if cube[name].dims == ("record",))
        raise ArgumentError(f"by: {by!r}; records are described by {', '.join(known)}")
    values = np.atleast_1d(cube[by].to_numpy())
    if values.dtype.kind not in "fiu":
        words = values.astype(str)
        return {f"{by} {word}": words == word for word in sorted(set(words.tolist()) - {""})}
    if not len(edges) or np.any(np.diff(edges) <= 0):
        raise ArgumentError(f"edges: {list(edges)}; give ascending values of {by} between the groups")
    bounds = [-np.inf, *edges, np.inf]
    groups = {}
    for low, high in pairwise(bounds):
        name = f"{by} below {high:g}" if low == -np.inf else f"{by} from {low:g}"
        groups[name + ("" if np.inf in (-low, high) else f" to below {high:g}")] = (values >= low) & (values < high)
    return groups
