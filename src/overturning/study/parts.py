"""Parts of a sweep (simulation of all cases): the cases of a record are divided into chunks, one file per chunk."""

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
from overturning.model.grid import CaseGrid
from overturning.model.variables import PLANAR_OUTCOME_VARIABLES, OutcomeVariable
from overturning.study.netcdf import (
    create_grid_dimensions_and_coordinates,
    create_outcome_variable,
    open_netcdf_without_masking_and_scaling,
)
from overturning.study.scenes import NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, variant_model
from overturning.study.schema import Study


@dataclass(frozen=True)
class SweepChunk:
    """Chunk (one job's part) of the cases of a record: its number, and the number of chunks of the record."""

    number_from_1: int = 1
    chunk_count_of_record: int = 1

    @classmethod
    def parse(cls, chunk_number_of_count_text: str) -> Self:
        """Parse the number of a chunk and the number of all chunks from a text such as ``3-of-8``.

        An `ArgumentError` is raised for any other text.
        """
        found = re.fullmatch(r"(\d{1,9})-of-(\d{1,9})", chunk_number_of_count_text)
        if found is None or not 1 <= int(found[1]) <= int(found[2]):
            raise ArgumentError(f"chunk: {chunk_number_of_count_text!r}; write a number and that of all chunks, 3-of-8")
        return cls(int(found[1]), int(found[2]))

    def __str__(self) -> str:
        return f"{self.number_from_1}-of-{self.chunk_count_of_record}"


WHOLE_RECORD_CHUNK: Final = SweepChunk()
"""Chunk with all cases of a record."""

_UNREADABLE_FILE_REMEDY: Final = "run again to recreate it"


def path_of_chunk_outcome_file(sweep_part_folder: Path, record_id: str, chunk: SweepChunk) -> Path:
    """Return the path of the file with one chunk of the outcomes of a record, such as ``rinaldi.3-of-8.nc``."""
    return sweep_part_folder / f"{record_id}.{chunk}.nc"


def paths_of_chunk_outcome_files(
    sweep_part_folder: Path, record_ids: Iterable[str], chunks_per_record: int
) -> list[Path]:
    """Return the paths of all outcome files: one for each given record and each chunk of its cases."""
    all_chunks = [SweepChunk(number, chunks_per_record) for number in range(1, chunks_per_record + 1)]
    return [
        path_of_chunk_outcome_file(sweep_part_folder, record, chunk) for record in record_ids for chunk in all_chunks
    ]


def grid_of_chunk(
    study: Study, grid: CaseGrid, chunk: SweepChunk, variant: str = NAME_OF_STUDY_ITSELF_AMONG_VARIANTS
) -> CaseGrid:
    """Return the part of a parameter grid that one chunk (job) of a record's simulation covers.

    Only the directions are divided: they go to the chunks in turn, so that run times are similar. Directions whose
    outcomes are symmetric copies of each other go to the same chunk. B/H is not divided, since the ensemble compares
    neighbours along B/H. If there are more chunks than groups of symmetric directions, some chunks are empty.
    """
    name = grid.dimension_names[0]
    directions = grid[name]
    group = np.arange(directions.size)
    for index, others in enumerate(
        variant_model(study, variant).simulated_direction_for_each_direction(grid).simulated_direction_index
    ):
        for other in others:
            group[group == group[index]] = group[other]
    number = np.unique(group, return_inverse=True)[1]
    return grid.copy_with_dimension_values(
        **{name: directions[number % chunk.chunk_count_of_record == chunk.number_from_1 - 1]}
    )


def write_outcome_file_of_chunk(
    sweep_part_path: Path,
    grid: CaseGrid,
    outcomes_by_variable_name: dict[str, NDArray[Any]],
    global_file_attributes: dict[str, str | int],
    outcome_variables: tuple[OutcomeVariable, ...] = PLANAR_OUTCOME_VARIABLES,
) -> None:
    """Write the outcomes of one chunk of cases to a NetCDF file; without cases the file has only attributes."""
    from netCDF4 import Dataset

    with atomic_write(sweep_part_path) as part, Dataset(part, "w", format="NETCDF4") as file:
        if grid.case_count:
            create_grid_dimensions_and_coordinates(file, grid)
            for variable in outcome_variables:
                create_outcome_variable(file, variable, grid)[:] = variable.encode(
                    outcomes_by_variable_name[variable.name]
                )
        file.setncatts(global_file_attributes)


class OpenedSweepPartFile(NamedTuple):
    """Open file with the outcomes of a chunk of cases, and the positions of these cases in the study's grid."""

    file: Any  # netCDF4 dataset without masking and scaling
    study_grid_indices_by_dimension: list[NDArray[np.intp]]  # positions of its cells in the whole grid

    def copy_variable_into(self, variable_name: str, output_array_over_study_grid: NDArray[Any]) -> None:
        """Copy this file's values of a variable to their positions in an array for the whole parameter grid."""
        if self.study_grid_indices_by_dimension[0].size:
            where: tuple[Any, ...] = np.ix_(*self.study_grid_indices_by_dimension)
            output_array_over_study_grid[(slice(None), *where) if "amplitude" in self.file.dimensions else where] = (
                self.file[variable_name][:]
            )


def read_record_id_and_variant_of_outcome_file(path: Path) -> tuple[str, str]:
    """Return the record id and variant stated in a file with outcomes; a `ResultError` if it is unreadable."""
    with open_netcdf_without_masking_and_scaling(path, "read", _UNREADABLE_FILE_REMEDY, require_checksum=True) as file:
        return file.record_id, file.variant


@contextmanager
def open_checked_outcome_file_for_reading(
    path: Path, grid: CaseGrid, outcome_variables: Sequence[OutcomeVariable]
) -> Iterator[OpenedSweepPartFile]:
    """Open a file with outcomes of a chunk of cases; a `ResultError` if its cases are not in the study's grid."""
    with open_netcdf_without_masking_and_scaling(path, "read", _UNREADABLE_FILE_REMEDY, require_checksum=True) as file:
        if not file.dimensions:  # empty chunk
            yield OpenedSweepPartFile(file, [np.zeros(0, np.intp)] * len(grid.dimension_names))
            return
        if wrong := _first_mismatch_with_grid(file, grid, outcome_variables):
            raise ResultError(f"{path}: {wrong}; it is of another study or version: remove it and run again")
        yield OpenedSweepPartFile(file, [np.searchsorted(grid[name], file[name][:]) for name in grid.dimension_names])


def _first_mismatch_with_grid(netcdf_file: Any, grid: CaseGrid, outcome_variables: Sequence[OutcomeVariable]) -> str:
    """Return the first difference between a file of outcomes and the study's grid; "" if there is none."""
    factors = (
        {"amplitude": np.array(grid.motion_amplitude_factors_if_several)}
        if grid.motion_amplitude_factors_if_several
        else {}
    )
    needed = [*(variable.name for variable in outcome_variables), *grid.dimension_names, *factors]
    if absent := [name for name in needed if name not in netcdf_file.variables]:
        return f"has no {absent[0]}"
    if (
        tuple(netcdf_file["element_name"][:] if "element" in netcdf_file.dimensions else ())
        != grid.free_element_names_if_several
    ):
        return "its elements are not those of the scene"
    for name, values in {**grid.values_by_dimension, **factors}.items():
        # Compare exactly: a part of this study has exactly the same numbers.
        if not np.isin(netcdf_file[name][:], values).all() or (
            name in factors and netcdf_file[name].size != values.size
        ):
            return f"its {name} values are not those of the study"
    return ""
