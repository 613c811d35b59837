"""`overturning read`: one record of the table, processed, into motion.nc."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(rich_markup_mode=None)


@app.command()
def read(
    study: Annotated[str, typer.Option(help="study file, or its content as JSON")],
    record: Annotated[str, typer.Option(help="id in the record table")],
    output: Annotated[Path, typer.Option(help="NetCDF file to make")],
) -> None:
    """Read one record of the table, process it, and write its motion."""
    from overturning.records.processing import process
    from overturning.records.read import read_record
    from overturning.records.store import write_motion
    from overturning.study.load import entries_of, study_from

    settings = study_from(study)
    entry = entries_of(settings, settings.name)[record]
    raw = read_record(entry, Path(settings.records.folder))
    write_motion(process(raw, settings.processing), output)
