"""Read the records of a cube in parts, since it may be larger than memory, and sort them into groups."""

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.errors import ArgumentError

CELLS_PER_READ: Final = 40_000
"""Number of cells that are read together; with fewer, the overhead of xarray exceeds the computation."""


def load_record(cube: xr.Dataset, record: int | list[int], variables: Sequence[str] = ()) -> xr.Dataset:
    """Load one record (or several) of a cube with a single read; many small dask graphs are slower.

    Parameters
    ----------
    cube : Dataset
        In memory, or lazy as returned by `overturning.open_cube`.
    record : int or list of int
        Position of the record; with a list, the dimension ``record`` stays.
    variables : sequence of str
        Names of the variables to read, as far as the cube has them; not given: all.
    """
    chosen = cube[[name for name in variables if name in cube]] if variables else cube
    return chosen.isel(record=record).load()


def iterate_records(cube: xr.Dataset, variables: Sequence[str]) -> Iterator[xr.Dataset]:
    """Yield a cube with a single record for each record, with the named variables; see `load_record`."""
    for record in range(cube.sizes["record"]):
        yield load_record(cube, [record], variables)


def record_batches(cube: xr.Dataset, variables: Sequence[str]) -> Iterator[tuple[list[int], xr.Dataset]]:
    """Yield the positions and the cube of successive records with together about `CELLS_PER_READ` cells."""
    count = cube.sizes["record"]
    few = max(1, CELLS_PER_READ * count // max(cube["overturned"].size, 1))
    for first in range(0, count, few):
        places = list(range(first, min(first + few, count)))
        yield places, load_record(cube, places, variables)


def apply_by_record(
    function: Callable[[xr.Dataset], xr.Dataset], cube: xr.Dataset, variables: Sequence[str]
) -> xr.Dataset:
    """Apply a function to batches of records and concatenate the results along ``record``.

    A cube without that dimension is passed whole. The function gets a few records at a time with the variables
    ``variables`` (see `load_record`); all variables that it returns must have the dimension ``record``.
    """
    if "record" not in cube.dims:
        return function(cube)
    made = [function(some) for _, some in record_batches(cube, variables)]
    return xr.concat(made, "record", data_vars="minimal", coords="minimal", compat="override", join="override")


def record_groups(cube: xr.Dataset, by: str = "pulse", edges: Sequence[float] = ()) -> dict[str, NDArray[np.bool_]]:
    """Return a Boolean mask of the records for each group of records, by the name of the group.

    A record without the grouping value is in no group.

    Parameters
    ----------
    cube : Dataset
        The cube.
    by : str
        Coordinate of the records: ``pulse`` (records with a pulse and their control if the study has both, otherwise
        all records together), a text such as ``site_class`` or ``wall`` (a group for each value), or a number such as
        ``vs30``.
    edges : sequence of float
        Limits between the groups of a number, ascending; a limit belongs to the upper group.

    Raises
    ------
    ArgumentError
        If the cube has no such coordinate, or a number is given without edges.
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
