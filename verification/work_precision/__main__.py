"""`python -m verification.work_precision --part PART --output TABLE.nc`: measure one part of error against run time."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from overturning.errors import ArgumentError
from verification.tables import write_table
from verification.work_precision.parts import COLUMN_MEANINGS, PARTS, result_table


def main(
    part: Annotated[str, typer.Option(help=", ".join(PARTS))],
    output: Annotated[Path, typer.Option(help="table to write (NetCDF; also as CSV)")],
) -> None:
    """Measure error and run time of schemes, time steps, stiffnesses or engines."""
    if part not in PARTS:
        raise ArgumentError(f"part: {part!r}; known: {', '.join(PARTS)}")
    rows = []
    for measure in PARTS[part]:
        for row in measure():
            rows.append(row)
            print(*(row.get(name) for name in ("cases_of", "method", "step_fraction")), file=sys.stderr, flush=True)
    write_table(result_table(rows), output, meanings=COLUMN_MEANINGS)


if __name__ == "__main__":
    typer.run(main)
