"""The steps of the workflow: each subcommand does the work of one rule, from a study given as JSON.

What a step needs is imported inside its function, so that it starts quickly and that a change of another step's sources
does not run it again (`overturning.study.sources`).
"""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(rich_markup_mode=None)

Study = Annotated[str, typer.Option(help="study file, or its content as JSON")]
Motions = Annotated[Path, typer.Option(help="folder of the motions")]
Variant = Annotated[str, typer.Option(help="name of the contact setting")]
Threads = Annotated[int, typer.Option(min=1, help="number of threads or processes")]
Log = Annotated[Path | None, typer.Option(help="file for progress lines and errors")]
NetCDF = Annotated[Path, typer.Option(help="NetCDF file to make")]


@app.command()
def read(
    study: Study,
    record: Annotated[str, typer.Option(help="id in the record table")],
    output: NetCDF,
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


@app.command()
def rotate(study: Study, motions: Motions, output: NetCDF) -> None:
    """Write the intensity measures of all records along every azimuth."""
    from overturning.records.store import read_motion
    from overturning.study.intensity import write_intensity
    from overturning.study.load import study_from

    settings = study_from(study)
    write_intensity(settings, [read_motion(motions / f"{name}.nc") for name in settings.records.use], output)


@app.command()
def members(study: Study, output: Annotated[Path, typer.Option(help="table of members to make (CSV)")]) -> None:
    """Draw the members of a study's ensemble, once for all its jobs."""
    from overturning.study.load import study_from
    from overturning.study.members import draw_members, write_members

    write_members(draw_members(study_from(study).ensemble), output)


@app.command()
def sweep(
    study: Study,
    motion: Annotated[Path, typer.Option(help="processed motion (NetCDF)")],
    output: NetCDF,
    timing: Annotated[Path, typer.Option(help="table of run times to make (CSV)")],
    variant: Variant = "nominal",
    records: Annotated[
        int, typer.Option(min=1, help="number of records of the whole study, for the progress line")
    ] = 1,
    members: Annotated[Path | None, typer.Option(help="members of the ensemble (CSV)")] = None,
    threads: Threads = 1,
    log: Log = None,
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


@app.command()
def gather(
    study: Study,
    motions: Motions,
    parts: Annotated[Path, typer.Option(help="folder of the parts, one per record")],
    output: NetCDF,
    variant: Variant = "nominal",
) -> None:
    """Gather the parts of a sweep into the cube."""
    from overturning.records.store import read_motion
    from overturning.study.gather import gather as gather_parts
    from overturning.study.load import study_from

    settings = study_from(study)
    names = settings.records.use
    records = [read_motion(motions / f"{name}.nc") for name in names]
    gather_parts(settings, records, [parts / f"{name}.nc" for name in names], output, variant)


@app.command()
def figures(
    cube: Annotated[Path, typer.Option(help="the cube (NetCDF)")],
    intensity: Annotated[Path, typer.Option(help="intensity measures by azimuth (NetCDF)")],
    motions: Motions,
    output: Annotated[Path, typer.Option(help="folder for the figures")],
    threads: Threads = 1,
) -> None:
    """Draw the figures of a study."""
    from overturning.figures.study import draw_study

    draw_study(cube, intensity, motions, output, threads)


@app.command()
def report(
    results: Annotated[Path, typer.Option(help="folder of the study's results")],
    output: Annotated[Path, typer.Option(help="page to make (HTML)")],
    pdf: Annotated[Path | None, typer.Option(help="the same on paper (PDF)")] = None,
) -> None:
    """Write the report of a study."""
    from overturning.report.write import write_report

    write_report(results, output, pdf)
