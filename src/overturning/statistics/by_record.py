"""Read the records of a cube in parts, since it may be larger than memory, and sort them into groups."""

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.errors import ArgumentError

TARGET_CASES_PER_READ_BATCH: Final = 40_000
"""Number of cells that are read together; with fewer, the overhead of xarray exceeds the computation."""


def load_results_of_records(
    cube: xr.Dataset, record_indices: int | list[int], variable_names: Sequence[str] = ()
) -> xr.Dataset:
    """Load variables of some records of a cube into memory in a single read.

    A single read is faster than many small dask graphs.

    Parameters
    ----------
    cube : Dataset
        In memory, or lazy as returned by `overturning.open_cube`.
    record_indices : int or list of int
        Index of the record; with a list, the dimension ``record`` stays.
    variable_names : sequence of str
        Names of the variables to read, as far as the cube has them; not given: all.
    """
    chosen = cube[[name for name in variable_names if name in cube]] if variable_names else cube
    return chosen.isel(record=record_indices).load()


def iterate_results_by_record(cube: xr.Dataset, variable_names: Sequence[str]) -> Iterator[xr.Dataset]:
    """Yield the results of one record after the other, with the variables named in `variable_names`."""
    for record in range(cube.sizes["record"]):
        yield load_results_of_records(cube, [record], variable_names)


def iterate_record_result_batches(
    cube: xr.Dataset, variable_names: Sequence[str]
) -> Iterator[tuple[list[int], xr.Dataset]]:
    """Yield indices and loaded results of batches of records, each about `TARGET_CASES_PER_READ_BATCH` cases."""
    count = cube.sizes["record"]
    few = max(1, TARGET_CASES_PER_READ_BATCH * count // max(cube["overturned"].size, 1))
    for first in range(0, count, few):
        places = list(range(first, min(first + few, count)))
        yield places, load_results_of_records(cube, places, variable_names)


def apply_to_record_batches_and_join(
    function_of_record_batch: Callable[[xr.Dataset], xr.Dataset], cube: xr.Dataset, variable_names: Sequence[str]
) -> xr.Dataset:
    """Apply a function to successive batches of a dataset's records, and join the results along ``record``.

    A cube without the dimension ``record`` is passed whole. The function gets a few records at a time with the
    variables ``variable_names`` (see `load_results_of_records`); all variables that it returns must have the dimension
    ``record``.
    """
    if "record" not in cube.dims:
        return function_of_record_batch(cube)
    made = [function_of_record_batch(some) for _, some in iterate_record_result_batches(cube, variable_names)]
    return xr.concat(made, "record", data_vars="minimal", coords="minimal", compat="override", join="override")


def record_masks_by_group(
    cube: xr.Dataset, coordinate: str = "pulse", edges: Sequence[float] = ()
) -> dict[str, NDArray[np.bool_]]:
    """Return, by group name, a mask of the records in each group, such as records with a velocity pulse.

    A record without the grouping value is in no group.

    Parameters
    ----------
    cube : Dataset
        The cube.
    coordinate : str
        Name of a coordinate of the records. ``pulse``: one group with a velocity pulse and a control group without, or
        a single group of all records if one of these is empty. A coordinate of texts, such as ``site_class`` or
        ``wall``: one group for each text. A coordinate of numbers, such as ``vs30``: groups between `edges`.
    edges : sequence of float
        Limits between the groups of a coordinate of numbers, ascending; a limit belongs to the upper group.

    Raises
    ------
    ArgumentError
        If the cube has no such coordinate, or if ascending edges are missing for a coordinate of numbers.
    """
    if coordinate == "pulse":
        pulse = np.atleast_1d(cube["pulse"].to_numpy()).astype(np.float64)
        if (pulse == 1).any() and (pulse == 0).any():
            return {"with a velocity pulse": pulse == 1, "without (control)": pulse == 0}
        return {"all records": np.ones(pulse.size, dtype=bool)}
    if coordinate not in cube.coords or cube[coordinate].dims not in ((), ("record",)):
        known = sorted(str(name) for name in cube.coords if cube[name].dims == ("record",))
        raise ArgumentError(f"coordinate: {coordinate!r}; records are described by {', '.join(known)}")
    values = np.atleast_1d(cube[coordinate].to_numpy())
    if values.dtype.kind not in "fiu":
        words = values.astype(str)
        return {f"{coordinate} {word}": words == word for word in sorted(set(words.tolist()) - {""})}
    if not len(edges) or np.any(np.diff(edges) <= 0):
        raise ArgumentError(f"edges: {list(edges)}; give ascending values of {coordinate} between the groups")
    bounds = [-np.inf, *edges, np.inf]
    groups = {}
    for low, high in pairwise(bounds):
        name = f"{coordinate} below {high:g}" if low == -np.inf else f"{coordinate} from {low:g}"
        groups[name + ("" if np.inf in (-low, high) else f" to below {high:g}")] = (values >= low) & (values < high)
    return groups
