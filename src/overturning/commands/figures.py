"""`overturning figures`: draw the figures of a study."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(rich_markup_mode=None)


@app.command()
def figures(
    cube: Annotated[Path, typer.Option(help="the cube (NetCDF)")],
    intensity: Annotated[Path, typer.Option(help="intensity measures by azimuth (NetCDF)")],
    motions: Annotated[Path, typer.Option(help="folder of the processed motions")],
    output: Annotated[Path, typer.Option(help="folder for the figures")],
    threads: Annotated[int, typer.Option(min=1, help="number of processes that draw")] = 1,
) -> None:
    """Draw the figures of a study."""
    from overturning.figures.study import draw_study

    draw_study(cube, intensity, motions, output, threads)
