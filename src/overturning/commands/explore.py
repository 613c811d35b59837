"""`overturning explore`: a cube as a page to look around in."""

from pathlib import Path
from typing import Annotated

import typer


def explore(
    cube: Annotated[Path, typer.Argument(help="cube of a study (NetCDF)")],
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="page to make (default: beside the cube, explore.html of cube.nc)"),
    ] = None,
    record: Annotated[list[str] | None, typer.Option(help="id of a record to show; may be given several times")] = None,
    study: Annotated[
        str | None,
        typer.Option(help="study file or JSON whose block is shown first (default: study.yaml beside the cube)"),
    ] = None,
) -> None:
    """Write a page with the maps of a cube: the outcome of each cell, and the command that films it."""
    from overturning.figures.explore import write_explorer
    from overturning.files import check_output
    from overturning.study.cube import open_cube, record_number
    from overturning.study.load import study_from

    # That of a variant, explore.NAME.html, does not take the place of the study's own.
    path = output or cube.with_name(cube.name.replace("cube", "explore", 1)).with_suffix(".html")
    check_output(path, "--output", ".html")
    with open_cube(cube, element=None) as data:
        names = dict.fromkeys(record or data["record_id"].to_numpy().astype(str).tolist())
        chosen = data.isel(record=[record_number(data, name) for name in names])
        write_explorer(chosen, path, study_from(study) if study else None)
    print(path)
