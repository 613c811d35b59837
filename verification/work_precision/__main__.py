"""`python -m verification.work_precision --part PART --output TABLE.nc`: measure one part of error against run time."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from overturning.errors import ArgumentError
from verification.tables import write_table_as_netcdf_and_csv
from verification.work_precision.parts import (
    COLUMN_LONG_NAMES_AND_UNITS,
    MEASUREMENT_FUNCTIONS_BY_PART,
    error_table_with_nan_if_not_measured,
)


def main(
    part: Annotated[str, typer.Option(help=", ".join(MEASUREMENT_FUNCTIONS_BY_PART))],
    output: Annotated[Path, typer.Option(help="table to write (NetCDF; also as CSV)")],
) -> None:
    """Measure error and run time of schemes, time steps, stiffnesses or engines."""
    if part not in MEASUREMENT_FUNCTIONS_BY_PART:
        raise ArgumentError(f"part: {part!r}; known: {', '.join(MEASUREMENT_FUNCTIONS_BY_PART)}")
    rows = []
    for measure in MEASUREMENT_FUNCTIONS_BY_PART[part]:
        for row in measure():
            rows.append(row)
            print(*(row.get(name) for name in ("cases_of", "method", "step_fraction")), file=sys.stderr, flush=True)
    write_table_as_netcdf_and_csv(
        error_table_with_nan_if_not_measured(rows), output, long_name_and_unit_by_column=COLUMN_LONG_NAMES_AND_UNITS
    )


if __name__ == "__main__":
    typer.run(main)
