"""Records of a cube, read in parts because a cube may be larger than memory, and groups of records."""

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.errors import ArgumentError

AT_ONCE: Final = 40_000
"""Number of cells read at once; with fewer, xarray's overhead dominates."""


def one_record(cube: xr.Dataset, record: int | list[int], names: Sequence[str] = ()) -> xr.Dataset:
    """Load one record of a cube into memory at once: many small dask graphs cost more.

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
    """Yield the records of a cube, each as a cube of one record (see `one_record` for the variables)."""
    for record in range(cube.sizes["record"]):
        yield one_record(cube, [record], names)


def few_records(cube: xr.Dataset, names: Sequence[str]) -> Iterator[tuple[list[int], xr.Dataset]]:
    """Yield the positions of a few records of about `AT_ONCE` cells together, and their cube (see `one_record`)."""
    count = cube.sizes["record"]
    few = max(1, AT_ONCE * count // max(cube["overturned"].size, 1))
    for first in range(0, count, few):
        places = list(range(first, min(first + few, count)))
        yield places, one_record(cube, places, names)


def by_record(function: Callable[[xr.Dataset], xr.Dataset], cube: xr.Dataset, names: Sequence[str]) -> xr.Dataset:
    """Apply a function to a few records at a time and concatenate the results along the records.

    The results must have the dimension of the records. A cube without that dimension is passed as a whole. See
    `one_record` for the variables.
    """
    if "record" not in cube.dims:
        return function(cube)
    made = [function(some) for _, some in few_records(cube, names)]
    return xr.concat(made, "record", data_vars="minimal", coords="minimal", compat="override", join="override")


def record_groups(cube: xr.Dataset, by: str = "pulse", edges: Sequence[float] = ()) -> dict[str, NDArray[np.bool_]]:
    """Return the members of each group of records, by name; a record of unknown group is in none.

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
