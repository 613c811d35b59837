"""`overturning members`: draw the members of a study's ensemble."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(rich_markup_mode=None)


@app.command()
def members(
    study: Annotated[str, typer.Option(help="study file, or its content as JSON")],
    output: Annotated[Path, typer.Option(help="table of members to make (CSV)")],
) -> None:
    """Draw the members of a study's ensemble, once for all its jobs."""
    from overturning.study.load import study_from
    from overturning.study.members import draw_members, write_members

    write_members(draw_members(study_from(study).ensemble), output)
