"""`overturning explore`: a cube as a page to look around in."""

from pathlib import Path
from typing import Annotated

import typer


def explore(
    cube: Annotated[Path, typer.Argument(help="cube of a study (NetCDF)")],
    output: Annotated[Path | None, typer.Option(help="page to make (default: explore.html beside the cube)")] = None,
    record: Annotated[list[str] | None, typer.Option(help="id of a record to show; may be given several times")] = None,
) -> None:
    """Write one self-contained page with the polar maps of a cube, which says of each cell what is known."""
    from overturning.errors import ArgumentError
    from overturning.figures.explore import write_explorer
    from overturning.files import check_output
    from overturning.study.cube import open_cube

    path = output or cube.with_name("explore.html")
    check_output(path, "--output", ".html")
    with open_cube(cube, element=None) as data:
        if "azimuth" not in data.dims:
            raise ArgumentError(f"{cube}: a cube in space; its report has the maps, this page shows planes")
        names = [str(name) for name in data["record_id"].to_numpy()]
        unknown = [name for name in record or () if name not in names]
        if unknown:
            raise ArgumentError(f"--record {unknown[0]}: not in {cube}; it has {', '.join(names)}")
        write_explorer(data.isel(record=[names.index(name) for name in record or names]), path)
    print(path)
