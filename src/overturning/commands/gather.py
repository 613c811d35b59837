"""`overturning gather`: the parts of a sweep into the cube."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(rich_markup_mode=None)


@app.command()
def gather(
    study: Annotated[str, typer.Option(help="study file, or its content as JSON")],
    motions: Annotated[Path, typer.Option(help="folder of the motions")],
    parts: Annotated[Path, typer.Option(help="folder of the parts, one per record")],
    output: Annotated[Path, typer.Option(help="cube to make (NetCDF)")],
    variant: Annotated[str, typer.Option(help="name of the contact setting")] = "nominal",
) -> None:
    """Gather the parts of a sweep into the cube."""
    from overturning.records.store import read_motion
    from overturning.study.gather import gather as gather_parts
    from overturning.study.load import study_from

    settings = study_from(study)
    names = settings.records.use
    records = [read_motion(motions / f"{name}.nc") for name in names]
    gather_parts(settings, records, [parts / f"{name}.nc" for name in names], output, variant)
