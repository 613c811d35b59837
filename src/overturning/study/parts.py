"""Parts of a sweep: each record's cases shared out to chunks, a file for each; named, written and read here alone."""

import re
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple, Self

import numpy as np
from numpy.typing import NDArray

from overturning.errors import ArgumentError, ResultError
from overturning.files import atomic_write
from overturning.model.grid import Grid
from overturning.model.variables import VARIABLES, Variable
from overturning.study.netcdf import add_grid, add_variable, open_raw
from overturning.study.scenes import NOMINAL, model_for
from overturning.study.schema import Study


@dataclass(frozen=True)
class Chunk:
    """One of the chunks into which the cases of each record are shared out."""

    number: int = 1  # from 1
    of: int = 1

    @classmethod
    def parse(cls, text: str) -> Self:
        """The chunk that a text such as ``3-of-8`` names; an `ArgumentError` where it names none."""
        found = re.fullmatch(r"(\d{1,9})-of-(\d{1,9})", text)
        if found is None or not 1 <= int(found[1]) <= int(found[2]):
            raise ArgumentError(f"chunk: {text!r}; write a number and that of all chunks, 3-of-8")
        return cls(int(found[1]), int(found[2]))

    def __str__(self) -> str:
        return f"{self.number}-of-{self.of}"


WHOLE: Final = Chunk()
"""All cases of a record."""

_REMEDY: Final = "run again, which makes it anew"


def part_path(folder: Path, record_id: str, chunk: Chunk) -> Path:
    """File of a part in a folder, ``rinaldi.3-of-8.nc``."""
    return folder / f"{record_id}.{chunk}.nc"


def parts_of(folder: Path, records: Iterable[str], chunks: int) -> list[Path]:
    """Files of all parts of some records."""
    all_chunks = [Chunk(number, chunks) for number in range(1, chunks + 1)]
    return [part_path(folder, record, chunk) for record in records for chunk in all_chunks]


def piece_of(study: Study, grid: Grid, chunk: Chunk, variant: str = NOMINAL) -> Grid:
    """The piece of the grid of a study's variant that a chunk computes.

    Only the directions are shared out, by turns, so that each chunk has its share of long and short cases; those that
    answer for one another by symmetry stay together, and so do all B/H, along which the ensemble looks at neighbours.
    Of more chunks than there are such groups some have no direction at all.
    """
    name = grid.names[0]
    directions = grid[name]
    group = np.arange(directions.size)
    for index, others in enumerate(model_for(study, variant).sources(grid).cell):
        for other in others:
            group[group == group[index]] = group[other]
    number = np.unique(group, return_inverse=True)[1]
    return grid.replace_rows(**{name: directions[number % chunk.of == chunk.number - 1]})


def write_part(
    path: Path,
    grid: Grid,
    outcome: dict[str, NDArray[Any]],
    attributes: dict[str, str | int],
    variables: tuple[Variable, ...] = VARIABLES,
) -> None:
    """Write the outcome on a grid, or on a piece of one, as a part of the cube; without cells there is none."""
    from netCDF4 import Dataset

    with atomic_write(path) as part, Dataset(part, "w", format="NETCDF4") as file:
        if grid.size:
            add_grid(file, grid)
            for variable in variables:
                add_variable(file, variable, grid)[:] = variable.stored(outcome[variable.name])
        file.setncatts(attributes)


class Part(NamedTuple):
    """An open part that was found to be of the study."""

    file: Any  # netCDF4, masks and scales nothing
    places: list[NDArray[np.intp]]  # of its cells, along each dimension of the whole grid

    def put(self, name: str, cells: NDArray[Any]) -> None:
        """Put the values of a variable into their places in an array like the whole grid."""
        if self.places[0].size:
            where: tuple[Any, ...] = np.ix_(*self.places)
            cells[(slice(None), *where) if "amplitude" in self.file.dimensions else where] = self.file[name][:]


def record_of(path: Path) -> tuple[str, str]:
    """Record and variant of a part; a `ResultError` where it cannot be read."""
    with open_raw(path, "read", _REMEDY, sealed=True) as file:
        return file.record_id, file.variant


@contextmanager
def open_part(path: Path, grid: Grid, variables: Sequence[Variable]) -> Iterator[Part]:
    """Open a part and check that its cells are some of a grid; a `ResultError` where they are not."""
    with open_raw(path, "read", _REMEDY, sealed=True) as file:
        if not file.dimensions:  # of a chunk without cells
            yield Part(file, [np.zeros(0, np.intp)] * len(grid.names))
            return
        if wrong := _find_mismatch(file, grid, variables):
            raise ResultError(f"{path}: {wrong}; it is of another study or version: remove it and run again")
        yield Part(file, [np.searchsorted(grid[name], file[name][:]) for name in grid.names])


def _find_mismatch(file: Any, grid: Grid, variables: Sequence[Variable]) -> str:
    """What of an open part is not of a grid; empty where nothing is."""
    factors = {"amplitude": np.array(grid.amplitude)} if grid.amplitude else {}
    needed = [*(variable.name for variable in variables), *grid.names, *factors]
    if absent := [name for name in needed if name not in file.variables]:
        return f"has no {absent[0]}"
    if tuple(file["element_name"][:] if "element" in file.dimensions else ()) != grid.element:
        return "its elements are not those of the scene"
    for name, values in {**grid.rows, **factors}.items():
        # Equal, not close: a part of this study was made from the very same numbers.
        if not np.isin(file[name][:], values).all() or (name in factors and file[name].size != values.size):
            return f"its {name} values are not those of the study"
    return ""
