"""`overturning records`: check, plot and add record files, and fetch new ones."""

from collections.abc import Iterable
from dataclasses import astuple, dataclass, replace
from itertools import chain, count
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from overturning.commands.declared import (
    DEFAULT_RECORD_FOLDER,
    DEFAULT_RECORD_TABLE_PATH,
    RecordFileOptions,
    expand_dataclass_parameters_to_options,
)

if TYPE_CHECKING:
    from overturning.records.record import Record

RecordPathsArgument = Annotated[
    list[Path], typer.Argument(help="files or folders; for one file, the other files of its record are found")
]

app = typer.Typer(no_args_is_help=True, help="Check, plot, add or fetch record files.")


@app.command("check")
@expand_dataclass_parameters_to_options
def check_record_files(paths: RecordPathsArgument, file_options: RecordFileOptions) -> None:
    """Read record files of any known format, and print each record, or the reason why a file is refused.

    Folders are read recursively. The exit status is 1 if a file was refused.
    """
    from overturning.records.check import (
        check_records_in_files,
        format_record_check,
        names_of_files_skipped_by_name,
    )
    from overturning.records.duplicates import (
        duplicate_record_messages,
        find_id_pairs_of_duplicate_records,
        fingerprint_of_recorded_motion,
    )
    from overturning.records.earthquakes import assign_records_to_earthquakes

    findings = check_records_in_files(paths, file_options.to_declared_file_properties())
    for finding in findings:
        typer.echo(format_record_check(finding))
    _print_notes_on_assignment_to_earthquakes(
        assign_records_to_earthquakes(f.unprocessed_record for f in findings if f.unprocessed_record is not None).notes
    )
    named = [
        replace(f.record_after_default_processing, record_id=", ".join(f.file_names))
        for f in findings
        if f.record_after_default_processing is not None
    ]
    for text in duplicate_record_messages(
        find_id_pairs_of_duplicate_records(map(fingerprint_of_recorded_motion, named))
    ):
        typer.echo(text)
    read = sum(f.unprocessed_record is not None for f in findings)
    if no_records := names_of_files_skipped_by_name(paths):
        shown = ", ".join(no_records[:5]) + (" …" if len(no_records) > 5 else "")
        typer.echo(f"skipped because of their names: {len(no_records)} ({shown})")
    refused = sum(f.unprocessed_record is None and not f.is_skipped_for_no_acceleration for f in findings)
    typer.echo(f"{read} read, {refused} refused")
    if refused:
        raise typer.Exit(1)


def _print_notes_on_assignment_to_earthquakes(earthquake_notes: Iterable[str]) -> None:
    """Print notes on the assignment of records to earthquakes, each on its own line after "earthquakes:"."""
    for note in earthquake_notes:
        typer.echo(f"earthquakes: {note}")


def _print_record_notes(record: "Record") -> None:
    """Print the notes on a record, such as doubts and omitted files."""
    from overturning.records.check import notes_for_check_report

    for note in notes_for_check_report(record):
        typer.echo(f"  {note}")


@app.command("plot")
@expand_dataclass_parameters_to_options
def plot_records(
    paths: RecordPathsArgument,
    file_options: RecordFileOptions,
    output: Annotated[
        Path,
        typer.Option(
            "--output",
            "-o",
            help="folder for the figures, named after the record files; or a file .svg, .png or .pdf for one record",
        ),
    ] = Path(),
    corner: Annotated[
        str, typer.Option(help="corner of the default high-pass filter, Hz; auto: from the noise before the onset")
    ] = "auto",
) -> None:
    """Draw each record before and after default processing: time histories, spectra, and their difference.

    The exit status is 1 if a file was refused.
    """
    from overturning.errors import ArgumentError
    from overturning.figures.history import record_before_and_after_processing_figure
    from overturning.figures.style import use_package_matplotlib_settings
    from overturning.figures.write import save_figure_files
    from overturning.records.check import check_records_in_files, format_record_check
    from overturning.records.processing import default_processing_steps, process_record
    from overturning.records.record import processing_entry_text

    declared = file_options.to_declared_file_properties()
    try:
        frequency: float | Literal["auto"] = "auto" if corner == "auto" else float(corner)
    except ValueError:
        frequency = 0.0
    if frequency != "auto" and not 0 < frequency < float("inf"):
        raise ArgumentError(f"--corner: {corner!r}; give a frequency in Hz, or auto")
    findings = check_records_in_files(paths, declared)
    records = [
        (finding.file_names[0], finding.unprocessed_record)
        for finding in findings
        if finding.unprocessed_record is not None
    ]
    unread = [finding for finding in findings if finding.unprocessed_record is None]
    page = output.suffix.lower() in (".svg", ".png", ".pdf")
    if page and len(records) > 1:
        raise ArgumentError(f"--output: {output.name} is one page, but there are {len(records)} records; name a folder")
    made: set[Path] = set()
    for file, record in records:
        steps = default_processing_steps(record, frequency)
        used = process_record(record, steps)
        name = file.replace(":", "-")
        numbered = (output / f"{name}-{number}.svg" for number in count(2))
        # Files with the same name in several folders get numbered figures.
        target = output if page else next(one for one in chain([output / f"{name}.svg"], numbered) if one not in made)
        made.add(target)
        with use_package_matplotlib_settings():
            save_figure_files(record_before_and_after_processing_figure(record, used), target)
        typer.echo(f"{target}: {', '.join(map(processing_entry_text, used.processing)) or 'not processed'}")
        if frequency != "auto" and not steps:
            typer.echo("  --corner has no effect: only raw records get the default high-pass filter")
        _print_record_notes(record)
    for finding in unread:
        typer.echo(format_record_check(finding))
    if any(not finding.is_skipped_for_no_acceleration for finding in unread):
        raise typer.Exit(1)


@app.command("add")
def add_record(
    paths: Annotated[
        list[Path], typer.Argument(help="files of one record; for one file, the other files of its record are found")
    ],
    record_id: Annotated[
        str, typer.Option("--id", help="short name, lower case; default: from the first file name")
    ] = "",
    values: Annotated[
        list[str] | None,
        typer.Option("--set", help="value of a column: event='Kaikoura 2016', unit=gal; may be given several times"),
    ] = None,
    table: Annotated[Path, typer.Option(help="record table")] = DEFAULT_RECORD_TABLE_PATH,
    folder: Annotated[Path, typer.Option(help="folder to which the files are copied")] = DEFAULT_RECORD_FOLDER,
) -> None:
    """Copy the files of a record into the folder of record files, and add a line for it to the record table."""
    from overturning.errors import ArgumentError
    from overturning.records.table_line import (
        copy_files_and_add_record_to_table,
        earthquake_and_duplicate_notes_on_new_record,
    )

    if wrong := [pair for pair in values or () if "=" not in pair]:
        raise ArgumentError(f"--set {wrong[0]}: write column=value")
    pairs = [*(pair.partition("=")[::2] for pair in values or ()), *([("id", record_id)] if record_id else [])]
    given = dict(pairs)
    if twice := next((name for name in given if [one for one, _ in pairs].count(name) > 1), ""):
        raise ArgumentError(f"--set {twice}: given twice; keep one")
    record = copy_files_and_add_record_to_table(paths, given, table, folder)
    place = ", ".join(text for text in (record.station, record.event) if text)
    typer.echo(f"{table}: {record.record_id}{f' ({place})' if place else ''}")
    _print_record_notes(record)
    for line in earthquake_and_duplicate_notes_on_new_record(record, table, folder):
        typer.echo(line)
    typer.echo(f"look at it: overturning one --record {record.record_id} --azimuth 0 --animate {record.record_id}.html")


fetch_app = typer.Typer(no_args_is_help=True, help="Download record files into a folder.")
app.add_typer(fetch_app, name="fetch")

DownloadFolderOption = Annotated[
    Path, typer.Option(help="folder for the files; existing files are not downloaded again")
]


@fetch_app.command("url")
def fetch_file_from_url(
    address: Annotated[str, typer.Argument(help="http or https, without credentials")],
    sha256: Annotated[str, typer.Option(help="SHA-256 of the file")],
    folder: DownloadFolderOption = DEFAULT_RECORD_FOLDER,
    name: Annotated[str, typer.Option(help="file name; default: the end of the address")] = "",
    timeout: Annotated[float, typer.Option(help="longest time without data from the server, s")] = 30.0,
) -> None:
    """Download a file from a URL, and check its SHA-256.

    Credentials come from OVERTURNING_FETCH_USER and OVERTURNING_FETCH_PASSWORD in the environment.
    """
    from overturning.records.download import fetch_url

    typer.echo(fetch_url(address, sha256, folder, name=name or None, timeout_s=timeout))


@dataclass(frozen=True)
class WaveformWindowOptions:
    """Options for the time window of waveforms to download: start and end, or an earthquake and times around it."""

    window_start_utc: Annotated[str, typer.Option("--start", help="start of the window, UTC: 2016-11-13T11:02:00")] = ""
    window_end_utc: Annotated[str, typer.Option("--end", help="end of the window, UTC")] = ""
    event_id: Annotated[str, typer.Option("--event", help="event id of the server, instead of start and end")] = ""
    before_origin_time_s: Annotated[
        float | None, typer.Option("--before", help="time before the origin time of the event, s (default 30)")
    ] = None
    after_origin_time_s: Annotated[
        float | None, typer.Option("--after", help="time after the origin time of the event, s (default 270)")
    ] = None


@fetch_app.command("fdsn")
@expand_dataclass_parameters_to_options
def fetch_records_from_fdsn(
    server: Annotated[str, typer.Argument(help="address of FDSN services, or a name that obspy knows")],
    network: Annotated[str, typer.Option(help="network code")],
    station: Annotated[str, typer.Option(help="station code")],
    window: WaveformWindowOptions,
    channel: Annotated[
        str, typer.Option(help="channel codes; HN? selects the three components of an accelerometer")
    ] = "HN?",
    location: Annotated[str, typer.Option(help="location code")] = "*",
    folder: DownloadFolderOption = DEFAULT_RECORD_FOLDER,
    timeout: Annotated[float, typer.Option(help="longest time without an answer, s")] = 60.0,
) -> None:
    """Download the records of a station and their StationXML from FDSN web services, and check them."""
    from overturning.records.check import check_records_in_files, format_record_check
    from overturning.records.fdsn import FdsnWaveformRequest, fetch_fdsn_record

    request = FdsnWaveformRequest(server, network, station, location, channel, *astuple(window))
    for finding in check_records_in_files(
        fetch_fdsn_record(request, folder, timeout_s=timeout, report_missing_window_part=typer.echo)
    ):
        typer.echo(format_record_check(finding))
