"""`overturning report`: write the report of a study."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(rich_markup_mode=None)


@app.command()
def report(
    results: Annotated[Path, typer.Option(help="folder of the study's results")],
    output: Annotated[Path, typer.Option(help="page to make (HTML)")],
    pdf: Annotated[Path | None, typer.Option(help="the same on paper (PDF)")] = None,
) -> None:
    """Write the report of a study."""
    from overturning.report.write import write_report

    write_report(results, output, pdf)
