"""`overturning rotate`: intensity measures along every azimuth, for all records, into intensity.nc."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(rich_markup_mode=None)


@app.command()
def rotate(
    study: Annotated[str, typer.Option(help="study file, or its content as JSON")],
    motions: Annotated[Path, typer.Option(help="folder of the motions")],
    output: Annotated[Path, typer.Option(help="NetCDF file to make")],
) -> None:
    """Write the intensity measures of all records along every azimuth."""
    from overturning.records.store import read_motion
    from overturning.study.intensity import write_intensity
    from overturning.study.load import study_from

    settings = study_from(study)
    write_intensity(settings, [read_motion(motions / f"{name}.nc") for name in settings.records.use], output)
