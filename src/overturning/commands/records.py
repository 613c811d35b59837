"""`overturning records`: say what record files are, and fetch new ones."""

from pathlib import Path
from typing import Annotated, get_args

import typer

from overturning.commands.add import add

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
    vertical_sense: Annotated[
        str,
        typer.Option(help="up, down or none (leave out), for a vertical axis that does not say which way it points"),
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
    from overturning.records.assembly import VerticalSense
    from overturning.records.check import check_paths, describe
    from overturning.records.options import UNITS, ReadOptions

    sense: VerticalSense | None = next((word for word in get_args(VerticalSense) if word == vertical_sense), None)
    if vertical_sense and sense is None:
        raise ArgumentError(f"--vertical-sense: {vertical_sense!r}; known are {', '.join(get_args(VerticalSense))}")
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
        vertical_sense=sense,
    )
    for finding in findings:
        typer.echo(describe(finding))
    read = sum(f.record is not None for f in findings)
    typer.echo(f"{read} read, {len(findings) - read} refused")
    if read < len(findings):
        raise typer.Exit(1)


app.command()(add)

fetch = typer.Typer(rich_markup_mode=None, no_args_is_help=True, help="Fetch records into a folder, checked and whole.")
app.add_typer(fetch, name="fetch")

Folder = Annotated[Path, typer.Option(help="where files go; what is there already is not fetched again")]
RESOURCES = Path("resources/records")


@fetch.command()
def url(
    address: Annotated[str, typer.Argument(help="http or https, without credentials")],
    sha256: Annotated[str, typer.Option(help="SHA-256 of the file")],
    folder: Folder = RESOURCES,
    name: Annotated[str, typer.Option(help="file name; default: as the address ends")] = "",
    timeout: Annotated[float, typer.Option(help="longest silence of the server, s")] = 30.0,
) -> None:
    """Fetch a file by address and hash.

    Credentials come from OVERTURNING_FETCH_USER and OVERTURNING_FETCH_PASSWORD in the environment.
    """
    from overturning.records.download import fetch_url

    typer.echo(fetch_url(address, sha256, folder, name=name or None, timeout=timeout))


@fetch.command()
def fdsn(
    server: Annotated[str, typer.Argument(help="address of FDSN services, or a name that obspy knows")],
    network: Annotated[str, typer.Option(help="network code")],
    station: Annotated[str, typer.Option(help="station code")],
    channel: Annotated[str, typer.Option(help="channel codes; HN? is an accelerometer's three")] = "HN?",
    location: Annotated[str, typer.Option(help="location code")] = "*",
    start: Annotated[str, typer.Option(help="start of the window, UTC: 2016-11-13T11:02:00")] = "",
    end: Annotated[str, typer.Option(help="end of the window, UTC")] = "",
    event: Annotated[str, typer.Option(help="event id of the server instead of a window")] = "",
    before: Annotated[float, typer.Option(help="seconds before the event's origin")] = 30.0,
    after: Annotated[float, typer.Option(help="seconds after it")] = 270.0,
    folder: Folder = RESOURCES,
    timeout: Annotated[float, typer.Option(help="longest wait for an answer, s")] = 60.0,
) -> None:
    """Fetch waveforms and StationXML from FDSN web services, then say what they are."""
    from overturning.records.check import check_paths, describe
    from overturning.records.fdsn import Request, fetch_fdsn

    request = Request(server, network, station, location, channel, start, end, event, before, after)
    for finding in check_paths(fetch_fdsn(request, folder, timeout=timeout)):
        typer.echo(describe(finding))
