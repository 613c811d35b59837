"""`overturning sweep`: simulate every case of one record."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(rich_markup_mode=None)


@app.command()
def sweep(
    study: Annotated[str, typer.Option(help="study file, or its content as JSON")],
    motion: Annotated[Path, typer.Option(help="processed motion (NetCDF)")],
    output: Annotated[Path, typer.Option(help="part of the cube to make (NetCDF)")],
    timing: Annotated[Path, typer.Option(help="table of run times to make (CSV)")],
    variant: Annotated[str, typer.Option(help="name of the contact setting")] = "nominal",
    records: Annotated[
        int, typer.Option(min=1, help="number of records of the whole study, for the progress line")
    ] = 1,
    members: Annotated[Path | None, typer.Option(help="members of the ensemble (CSV)")] = None,
    threads: Annotated[int, typer.Option(min=1, help="number of threads")] = 1,
    log: Annotated[Path | None, typer.Option(help="file for progress lines and errors")] = None,
) -> None:
    """Simulate every case of one record."""
    from overturning.records.store import read_motion
    from overturning.study.load import study_from
    from overturning.study.members import read_members
    from overturning.study.progress import Progress, logged_to
    from overturning.study.sweep import sweep_record
    from overturning.study.timing import timed

    with logged_to(log) as say:
        settings = study_from(study)
        record = read_motion(motion)
        with (
            Progress(output.parent, record.record_id, records, say) as progress,
            timed(timing) as row,
        ):
            row.update(record=record.record_id, variant=variant, cases=settings.cases)
            drawn = read_members(members) if members else None
            row["block_steps"] = sweep_record(settings, record, output, variant, threads, progress, drawn)
