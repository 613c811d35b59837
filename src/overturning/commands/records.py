"""`overturning records`: say what record files are, and fetch new ones."""

from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(rich_markup_mode=None, no_args_is_help=True, help="Check record files, or fetch them.")


@app.command()
def check(
    paths: Annotated[list[Path], typer.Argument(help="files or folders")],
    trust_data: Annotated[
        bool, typer.Option("--trust-data", help="go on where a header's peak contradicts the data")
    ] = False,
    azimuths: Annotated[
        str, typer.Option(help="azimuths of the two horizontal axes where the files do not state them: 0,90")
    ] = "",
    unit: Annotated[
        str, typer.Option(help="unit of the samples where the format leaves it open (SAC): m/s2, gal, g…")
    ] = "",
    columns: Annotated[str, typer.Option(help="read as columns: 'time:s north:gal east:gal up:gal'")] = "",
    interval: Annotated[float | None, typer.Option(help="sampling interval of columns without a time, s")] = None,
) -> None:
    """Read files of any known format and print what was found, or why they are refused.

    Exit status 1 if anything was refused.
    """
    from overturning.errors import ArgumentError
    from overturning.records.check import check_paths, describe
    from overturning.records.options import UNITS, ReadOptions

    if unit and unit not in UNITS:
        raise ArgumentError(f"--unit: {unit!r}; known are {', '.join(UNITS)}")
    try:
        pair = [float(a) for a in azimuths.replace(",", " ").split()] or None
    except ValueError:
        raise ArgumentError(f"--azimuths: {azimuths!r}; two numbers of degrees, e.g. 0,90") from None
    findings = check_paths(
        paths,
        options=ReadOptions(unit or None, columns, interval),
        azimuths_deg=pair,
        trust_data=trust_data,
    )
    for finding in findings:
        typer.echo(describe(finding))
    read = sum(f.record is not None for f in findings)
    typer.echo(f"{read} read, {len(findings) - read} refused")
    if read < len(findings):
        raise typer.Exit(1)
