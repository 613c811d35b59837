"""Tables of a verification as NetCDF and as CSV, the same bytes for the same numbers."""

import csv
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overturning.errors import ResultError
from overturning.files import atomic_write

Columns = dict[str, NDArray[Any]]


def write_table(
    columns: Mapping[str, NDArray[Any]],
    path: Path,
    *,
    meanings: Mapping[str, tuple[str, str]],
    attributes: Mapping[str, Any] | None = None,
    dimension: str = "row",
) -> None:
    """Write columns of equal length as NetCDF, and as CSV beside it.

    Parameters
    ----------
    columns : mapping of str to ndarray, shape (n,)
        Numbers and texts.
    path : Path
        The NetCDF file; the CSV file has the same name with another ending.
    meanings : mapping of str to (str, str)
        Long name and unit of each column.
    attributes : mapping, optional
        What else to say of the table; written as JSON.
    dimension : str
        Name of the dimension.
    """
    from netCDF4 import Dataset

    length = len(next(iter(columns.values())))
    with atomic_write(path) as part, Dataset(part, "w", format="NETCDF4") as file:
        file.createDimension(dimension, length)
        for name, values in columns.items():
            text = values.dtype.kind in "UO"
            made = file.createVariable(
                name, str if text else values.dtype, (dimension,), zlib=not text, complevel=1, shuffle=not text
            )
            long_name, unit = meanings[name]
            made.setncatts({"long_name": long_name} | ({} if text else {"units": unit}))
            made[:] = values.astype(object) if text else values
        file.setncatts({name: json.dumps(value) for name, value in (attributes or {}).items()})
    with atomic_write(path.with_suffix(".csv")) as part, part.open("w", encoding="utf-8", newline="") as text_file:
        table = csv.writer(text_file, lineterminator="\n")
        table.writerow(columns)
        table.writerows(
            [f"{value:.6g}" if isinstance(value, float) else value for value in row]
            for row in zip(*(values.tolist() for values in columns.values()), strict=True)
        )


def read_table(path: Path) -> tuple[Columns, dict[str, Any]]:
    """Read what `write_table` wrote as NetCDF.

    Raises
    ------
    ResultError
        If the file is missing or no such table.
    """
    from netCDF4 import Dataset

    try:
        file = Dataset(path)
    except OSError as error:
        raise ResultError(f"{path}: cannot be read ({error}); run `make verify`") from None
    with file:
        file.set_auto_mask(False)
        columns = {name: np.asarray(variable[:]) for name, variable in file.variables.items()}
        return columns, {name: json.loads(file.getncattr(name)) for name in file.ncattrs()}
