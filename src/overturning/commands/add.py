"""`overturning records add`: a line of the record table."""

from pathlib import Path
from typing import Annotated

import typer


def add(
    paths: Annotated[list[Path], typer.Argument(help="the files of one record")],
    record_id: Annotated[
        str, typer.Option("--id", help="short name, lower case; default: that of the first file")
    ] = "",
    values: Annotated[
        list[str] | None,
        typer.Option(
            "--set", help="a column of the table: event='Kaikoura 2016', unit=gal; may be given several times"
        ),
    ] = None,
    table: Annotated[Path, typer.Option(help="record table")] = Path("config/records.tsv"),
    folder: Annotated[Path, typer.Option(help="folder of the record files, to which they are copied")] = Path(
        "resources/records"
    ),
) -> None:
    """Read the files of a record, put them into the folder, and write the table's line."""
    from overturning.errors import ArgumentError
    from overturning.records.catalogue import read_catalogue
    from overturning.records.earthquakes import earthquakes_of
    from overturning.records.table_line import add_line

    given = dict(pair.partition("=")[::2] for pair in values or ())
    wrong = [pair for pair in values or () if "=" not in pair]
    if wrong:
        raise ArgumentError(f"--set {wrong[0]}: write column=value")
    if record_id:
        given["id"] = record_id
    record = add_line(paths, given, table, folder)
    place = ", ".join(text for text in (record.station, record.event) if text)
    print(f"{table}: {record.record_id}{f' ({place})' if place else ''}")
    others = [entry for entry in read_catalogue(table).values() if entry.id != record.record_id]
    known = set(earthquakes_of(others).said)
    for said in earthquakes_of([*others, record]).said:
        if said not in known:
            print(f"earthquakes: {said}")
    print(f"look at it: overturning one --record {record.record_id} --azimuth 0 --animate {record.record_id}.html")
