"""`python -m verification.work_precision --part PART --output TABLE.nc`: one part of error against run time."""

import sys
from functools import partial
from pathlib import Path
from typing import Annotated

import typer

from overturning.errors import ArgumentError
from verification.tables import write_table
from verification.work_precision import finer_steps, rigid_solutions
from verification.work_precision.table import MEANINGS, PARTS, table_of

say = partial(print, file=sys.stderr, flush=True)


def main(
    part: Annotated[str, typer.Option(help=", ".join(PARTS))],
    output: Annotated[Path, typer.Option(help="table to make (NetCDF, CSV beside it)")],
) -> None:
    """Set the error of schemes, time steps, stiffnesses or engines against their run time."""
    match part:
        case "sliding" | "rocking":
            rows = finer_steps.against_finer_steps(part, say)
        case "stiffness":
            rows = finer_steps.over_stiffness("rocking", say) + finer_steps.over_stiffness("sliding", say)
        case "rigid":
            rows = rigid_solutions.against_rigid_rocking(say) + rigid_solutions.against_exact_sliding(say)
        case "energy":
            rows = finer_steps.energy_balance(say)
        case "peers":
            rows = rigid_solutions.engines_against_rigid_rocking(say)
        case _:
            raise ArgumentError(f"part: {part!r}; known: {', '.join(PARTS)}")
    write_table(table_of(rows), output, meanings=MEANINGS)


if __name__ == "__main__":
    typer.run(main)
