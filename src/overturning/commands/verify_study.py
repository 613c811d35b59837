"""`overturning verify-study`: a random part of a study again, with finer steps and with stiffer springs."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(rich_markup_mode=None)


@app.command()
def verify_study(
    study: Annotated[str, typer.Option(help="study file, or its content as JSON")],
    motions: Annotated[Path, typer.Option(help="folder of the motions")],
    cube: Annotated[Path, typer.Option(help="the study's cube (NetCDF)")],
    sweep: Annotated[Path, typer.Option(help="folder of the sweep's tables, one per record (CSV)")],
    output: Annotated[Path, typer.Option(help="outcome to make (JSON)")],
    timing: Annotated[Path, typer.Option(help="table of run times to make (CSV)")],
    threads: Annotated[int, typer.Option(min=1, help="number of threads")] = 1,
    log: Annotated[Path | None, typer.Option(help="file for progress lines and errors")] = None,
) -> None:
    """Run a part of a study again, with finer steps and with stiffer springs."""
    from overturning.errors import ConfigError
    from overturning.records.store import read_motion
    from overturning.study.choice import read_sample
    from overturning.study.load import study_from
    from overturning.study.own_error import repeat_sample
    from overturning.study.own_error_file import write_verification
    from overturning.study.progress import logged_to
    from overturning.study.timing import block_steps_of, timed

    with logged_to(log) as say, timed(timing) as row:
        settings = study_from(study)
        names = settings.records.use
        if isinstance(settings.verification, str):
            raise ConfigError(f"{settings.name}: verification: none; leave the key out to verify the study")
        sample = read_sample(cube, settings.verification)
        done = sum(block_steps_of(sweep / f"{name}.csv") for name in names)
        found = repeat_sample(
            settings,
            [read_motion(motions / f"{name}.nc") for name in names],
            sample,
            done,
            threads,
            lambda part, most: say(f"verification: {part} of at most {most} cases"),
        )
        row.update(record="all", variant="verification", cases=2 * found["chosen"])
        row["block_steps"] = sum(found[kind].get("block_steps", 0) for kind in ("finer", "stiffer"))
        write_verification(found, output)
