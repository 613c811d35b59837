"""Write dimensions, coordinates and outcome variables to a NetCDF file; for results cubes and their parts."""

import hashlib
from collections.abc import Iterable, Sequence
from math import prod
from pathlib import Path
from typing import Any, Final

import numpy as np

from overturning.errors import ResultError
from overturning.files import checksum_at_end_matches
from overturning.model.grid import CF_ATTRIBUTES_BY_DIMENSION, CaseGrid
from overturning.model.variables import OutcomeVariable


def open_netcdf_without_masking_and_scaling(
    path: Path, action_participle_in_error_message: str, remedy_in_error_message: str, require_checksum: bool = False
) -> Any:
    """Open a netCDF4 file for reading its values as they are stored, without masking and scaling.

    A `ResultError` is raised if the file cannot be opened, or if its checksum is wrong or, with `require_checksum`,
    absent. `action_participle_in_error_message`, such as "read", completes "cannot be" in the message.
    """
    from netCDF4 import Dataset

    found = checksum_at_end_matches(path)
    if found is False or (require_checksum and path.is_file() and not found):
        raise ResultError(f"{path}: damaged, its checksum does not match; {remedy_in_error_message}")
    try:
        file = Dataset(path)
    except OSError as error:
        raise ResultError(
            f"{path}: cannot be {action_participle_in_error_message} ({error}); {remedy_in_error_message}"
        ) from None
    file.set_auto_maskandscale(False)
    return file


def create_coordinate_variable(
    netcdf_file: Any,
    dimension_name: str,
    variable_name: str,
    dtype_in_file: Any,
    coordinate_values: Iterable[Any],
    fill_value: Any = None,
    **attributes: Any,
) -> None:
    """Create a coordinate variable in an open netCDF4 file; None among the values is stored as the fill value."""
    variable = netcdf_file.createVariable(variable_name, dtype_in_file, (dimension_name,), fill_value=fill_value)
    variable.setncatts(attributes)
    variable.set_auto_maskandscale(False)
    stored = [fill_value if value is None else value for value in coordinate_values]
    if dtype_in_file is not str and stored:
        variable[:] = np.array(stored, dtype_in_file)
        return
    for index, text in enumerate(stored):  # one by one, as an array of texts would change the bytes of the file
        variable[index] = text


def create_grid_dimensions_and_coordinates(netcdf_file: Any, grid: CaseGrid) -> None:
    """Create the dimensions and coordinates of a parameter grid in an open netCDF4 file."""
    for name, values in grid.values_by_dimension.items():
        netcdf_file.createDimension(name, values.size)
        create_coordinate_variable(netcdf_file, name, name, values.dtype, values, **CF_ATTRIBUTES_BY_DIMENSION[name])
    if grid.motion_amplitude_factors_if_several:
        netcdf_file.createDimension("amplitude", len(grid.motion_amplitude_factors_if_several))
        create_coordinate_variable(
            netcdf_file,
            "amplitude",
            "amplitude",
            "f8",
            grid.motion_amplitude_factors_if_several,
            long_name="factor on the motion",
            units="1",
        )
    if count := len(grid.free_element_names_if_several):
        netcdf_file.createDimension("element", count)
        about = "of the free element of the scene"
        create_coordinate_variable(
            netcdf_file, "element", "element", "i4", range(count), long_name=f"number {about}", units="1"
        )
        create_coordinate_variable(
            netcdf_file, "element", "element_name", str, grid.free_element_names_if_several, long_name=f"name {about}"
        )


MAX_VALUES_PER_HDF5_CHUNK: Final = 1 << 20
"""Number of values in an HDF5 or dask chunk of a variable, unless a single azimuth or orientation has more."""


def hdf5_chunk_shape(variable_shape_for_one_record: tuple[int, ...]) -> tuple[int, ...]:
    """Return the HDF5 chunk shape of one record's variable: the whole array, or only some directions if it is large."""
    return (
        min(
            variable_shape_for_one_record[0],
            max(1, MAX_VALUES_PER_HDF5_CHUNK // max(1, prod(variable_shape_for_one_record[1:]))),
        ),
        *variable_shape_for_one_record[1:],
    )


def create_outcome_variable(
    netcdf_file: Any, outcome_variable: OutcomeVariable, grid: CaseGrid, *leading_dimensions: str
) -> Any:
    """Create an outcome variable over a grid in an open netCDF4 file, with all values missing."""
    dimensions = (*leading_dimensions, *grid.one_record_cube_dimensions_of_variable(outcome_variable))
    own = hdf5_chunk_shape(
        grid.one_record_cube_shape_of_variable(outcome_variable)[1 if grid.motion_amplitude_factors_if_several else 0 :]
    )
    created = netcdf_file.createVariable(
        outcome_variable.name, outcome_variable.dtype_in_file, dimensions,
        fill_value=outcome_variable.fill_value_in_file,
        zlib=True, complevel=1, shuffle=outcome_variable.dtype_in_file != "i1",
        chunksizes=(1,) * (len(dimensions) - len(own)) + own,
    )  # fmt: skip
    created.setncatts(outcome_variable.cf_attributes)
    created.set_auto_maskandscale(False)
    return created


def outcome_content_hash(netcdf_file: Any, outcome_variables: Sequence[OutcomeVariable]) -> str:
    """Return a SHA-256 hash of the names and values of all outcome variables in an open netCDF4 file."""
    digest = hashlib.sha256()
    for variable in outcome_variables:
        digest.update(variable.name.encode())
        for index in range(netcdf_file.dimensions["record"].size):
            digest.update(np.ascontiguousarray(netcdf_file[variable.name][index]).tobytes())
    return digest.hexdigest()
