"""Assignment of records to earthquakes."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from overturning.commands.application import app
from overturning.errors import ArgumentError, ConfigError
from overturning.records.catalogue import RecordTableRow, read_record_table
from overturning.records.earthquakes import (
    RecordEarthquakesAndAssignmentNotes,
    assign_records_to_earthquakes,
    great_circle_distance_km,
)
from overturning.records.formats import fema_p695
from overturning.records.read import read_record
from overturning.records.record import Record
from tests.records.record_writers import write_knet_component_files

DEFAULT_RECORD_TABLE_PATH = Path(__file__).parents[2] / "config" / "records.tsv"


def table_row(name: str, event: str = "", **more: object) -> RecordTableRow:
    """Return a row of the record table for a record of an earthquake."""
    return RecordTableRow(id=name, source=name, event=event, **more)  # type: ignore[arg-type]


def earthquake_assignment_of_table_rows(*entries: RecordTableRow) -> RecordEarthquakesAndAssignmentNotes:
    """Return the earthquakes to which rows of the record table are assigned."""
    return assign_records_to_earthquakes(entries)


def test_one_origin_under_two_names_becomes_one_earthquake_with_a_note() -> None:
    """The origin of the Loma Prieta earthquake as the ISC and the USGS have it: half a second and 2 km apart."""
    found = earthquake_assignment_of_table_rows(
        table_row("a", "Loma Prieta 10/18/1989", origin_time="1989-10-18T00:04:15.2Z"),
        table_row("b", "Northridge 1994"),
        table_row(
            "c",
            "Santa Cruz mountains",
            origin_time="1989-10-18T00:04:14.7",
            epicentre_latitude_deg=37.04,
            epicentre_longitude_deg=-121.88,
        ),
    )
    assert found.earthquake_labels_in_record_order == (
        "Loma Prieta 10/18/1989",
        "Northridge 1994",
        "Loma Prieta 10/18/1989",
    )
    assert len(found.notes_on_earthquakes_with_several_names) == 1
    assert (
        "'Loma Prieta 10/18/1989' and 'Santa Cruz mountains' are one earthquake"
        in found.notes_on_earthquakes_with_several_names[0]
    )
    assert found.doubtful_assignment_notes == ()


def test_origin_times_in_two_time_zones_are_one_earthquake() -> None:
    found = earthquake_assignment_of_table_rows(
        table_row("a", "x", origin_time="2000-10-06T13:30:18+09:00"),
        table_row("b", "y", origin_time="2000-10-06T04:30:00Z"),
    )
    assert found.earthquake_labels_in_record_order == ("x", "x")


@pytest.mark.parametrize("text", ["1989", "1989-10-18", "10/18/1989 00:04", "1989-02-30T00:04:15"])
def test_invalid_origin_time_is_refused(tmp_path: Path, text: str) -> None:
    table = tmp_path / "r.tsv"
    table.write_text(f"id\tsource\torigin_time\na\tx\t{text}\n")
    with pytest.raises(ConfigError, match=r"line 2: column origin_time .*: give date and time in UTC, like 2016"):
        read_record_table(table)


def test_one_name_with_two_origins_becomes_two_earthquakes() -> None:
    """Kumamoto foreshock and mainshock, 28 h apart; a record without origin is assigned to the first, with a note."""
    found = earthquake_assignment_of_table_rows(
        table_row("fore", "Kumamoto 2016", origin_time="2016-04-14T12:26:36Z"),
        table_row("main", "Kumamoto 2016", origin_time="2016-04-15T16:25:06Z"),
        table_row("open", "Kumamoto 2016"),
    )
    assert found.earthquake_labels_in_record_order[0] != found.earthquake_labels_in_record_order[1]
    assert (
        found.earthquake_labels_in_record_order[2]
        == found.earthquake_labels_in_record_order[0]
        == "Kumamoto 2016 (2016-04-14 12:26)"
    )
    assert len(found.doubtful_assignment_notes) == 2
    assert "record open may be of" in found.doubtful_assignment_notes[0]
    assert (
        "names 2 earthquakes by their origins (2016-04-14 12:26 fore, 2016-04-15 16:25 main)"
        in found.doubtful_assignment_notes[1]
    )


def test_simultaneous_distant_epicentres_become_two_earthquakes() -> None:
    place = ("epicentre_latitude_deg", "epicentre_longitude_deg")
    first, second = (dict(zip(place, at, strict=True)) for at in ((35.27, 133.35), (38.27, 141.0)))
    moment = "2000-10-06T04:30:18Z"
    found = earthquake_assignment_of_table_rows(
        table_row("a", "x", origin_time=moment, **first), table_row("b", "y", origin_time=moment, **second)
    )
    assert found.earthquake_labels_in_record_order == ("x", "y")


def test_event_ids_override_earthquake_names_and_origins() -> None:
    same = earthquake_assignment_of_table_rows(
        table_row("a", "Chi-Chi", event_id="e1"), table_row("b", "Taiwan 1999", event_id="e1")
    )
    assert same.earthquake_labels_in_record_order == ("Chi-Chi", "Chi-Chi")
    moment = "1999-09-20T17:47:16Z"
    apart = earthquake_assignment_of_table_rows(
        table_row("a", "Chi-Chi", event_id="e1", origin_time=moment),
        table_row("b", "Chi-Chi", event_id="e2", origin_time=moment),
    )
    assert apart.earthquake_labels_in_record_order == ("Chi-Chi (e1)", "Chi-Chi (e2)")
    assert apart.notes == ()


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("Loma Prieta 10/18/1989", "Loma Prieta, CA"),
        ("Loma Prieta 1989", "Loma Prieta 10/18/89 00:05"),
        ("Northridge 1994", "Northrigde 1994"),
        ("Western Tottori 2000", "Tottori 2000"),
        ("2000/10/06 13:30:00 JST", "Tottori 2000-10-06"),
        ("Earthquake of Fri Nov 30, 2018 17:29 UTC", "Anchorage 11/30/2018"),
    ],
)
def test_similar_earthquake_names_are_noted_with_both_names(first: str, second: str) -> None:
    found = earthquake_assignment_of_table_rows(
        table_row("a", first), table_row("b", "Gazli 1976"), table_row("c", second)
    )
    assert len(set(found.earthquake_labels_in_record_order)) == 3
    assert len(found.doubtful_assignment_notes) == 1
    assert first in found.doubtful_assignment_notes[0]
    assert second in found.doubtful_assignment_notes[0]
    assert "event_id" in found.doubtful_assignment_notes[0]


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("Imperial Valley 1979", "Imperial Valley 1940"),
        ("Loma Prieta 10/18/1989", "Loma Prieta 10/25/1989"),
        ("Chi-Chi, Taiwan-03", "Chi-Chi, Taiwan-06"),
        ("Kocaeli 1999", "Duzce 1999"),
    ],
)
def test_names_of_two_different_earthquakes_are_not_noted_as_similar(first: str, second: str) -> None:
    assert earthquake_assignment_of_table_rows(table_row("a", first), table_row("b", second)).notes == ()


def test_earthquake_names_ignore_capitals_and_blanks() -> None:
    assert (
        earthquake_assignment_of_table_rows(
            table_row("a", "LOMA PRIETA  1989"), table_row("b", "Loma Prieta 1989")
        ).earthquake_labels_in_record_order[1]
        == "LOMA PRIETA 1989"
    )


def test_records_without_an_earthquake_are_noted_as_a_joint_one() -> None:
    found = earthquake_assignment_of_table_rows(table_row("a"), table_row("b", "Gazli 1976"), table_row("c"))
    assert found.earthquake_labels_in_record_order == ("", "Gazli 1976", "")
    assert "2 records (a, c) name no earthquake and count as one" in found.doubtful_assignment_notes[0]


def test_record_start_times_that_contradict_earthquake_names_are_noted() -> None:
    rest = np.zeros(2)
    one = Record("a", rest, rest, None, 0.01, start="2016-11-13T11:03:00Z", event="Kaikoura 2016")
    other = replace(one, record_id="b", event="Culverden", start="2016-11-13T11:03:20Z")
    assert "start together" in assign_records_to_earthquakes([one, other]).doubtful_assignment_notes[0]
    late = replace(one, record_id="c", start="2016-11-14T00:34:00Z")
    assert (
        "records a and c start 13.5 h apart" in assign_records_to_earthquakes([one, late]).doubtful_assignment_notes[0]
    )
    known = replace(one, extra={"origin_time": "2016-11-13T11:02:56Z"})
    assert (
        "records a and c start 13.5 h apart"
        in assign_records_to_earthquakes([known, late]).doubtful_assignment_notes[0]
    )
    assert assign_records_to_earthquakes([known, replace(one, record_id="b")]).notes == ()


def test_a_start_time_without_a_zone_is_in_utc() -> None:
    still = np.zeros(3)
    starts = ("1994-01-17T12:31:00", "1994-01-17T12:30:30+00:00", "1994-01-17T14:40:00")  # `Record` treats it as UTC
    records = [Record(f"r{n}", still, still, None, 0.01, start=start, event=f"E{n}") for n, start in enumerate(starts)]
    assert len(assign_records_to_earthquakes(records[:2]).doubtful_assignment_notes) == 1
    assert assign_records_to_earthquakes(records[1:]).doubtful_assignment_notes == ()


@pytest.mark.parametrize("start", ["1994-01-17", "noon"])
def test_the_error_names_an_invalid_start_time(start: str) -> None:
    record = Record("r", np.zeros(3), np.zeros(3), None, 0.01, start=start)
    with pytest.raises(ArgumentError, match=f"record r: start '{start}', .*: give date and time in UTC, like 2016"):
        assign_records_to_earthquakes([record])


def test_each_shipped_earthquake_name_is_one_earthquake() -> None:
    """Each name in the record table is one earthquake, and no name resembles another."""
    entries = read_record_table(DEFAULT_RECORD_TABLE_PATH)
    found = assign_records_to_earthquakes(entries.values())
    assert found.earthquake_labels_in_record_order == tuple(one.event for one in entries.values())
    assert found.notes == ()


def test_two_names_of_one_earthquake_in_fema_p695_are_noted() -> None:
    """FEMA P-695 writes three of its earthquakes in two ways, with and without PEER's number."""
    sources = [f"{kind}:{number}" for kind, number in (("farfield", 1), ("nearfield_pulse", 9), ("nearfield_pulse", 8))]
    names = [fema_p695.read_components(source)[0].event for source in sources]
    assert names[:2] == ["Northridge", "Northridge-01"]
    found = earthquake_assignment_of_table_rows(*(table_row(f"r{index}", name) for index, name in enumerate(names)))
    assert len(found.doubtful_assignment_notes) == 1
    assert "'Northridge' (r0) and 'Northridge-01' (r1)" in found.doubtful_assignment_notes[0]


WAVE = np.round(900 * np.sin(np.arange(800) / 7.0))


def _write_text_file(folder: Path, name: str, text: str) -> Path:
    """Write a text file into a folder and return its path."""
    (folder / name).write_text(text)
    return folder / name


def test_the_record_table_overrides_the_origin_time_in_the_file_header(tmp_path: Path) -> None:
    write_knet_component_files(tmp_path, "TST0010102031305", WAVE, -WAVE)
    line = table_row("t", "Tottori", event_id="e1", origin_time="2000-10-06T04:30:18Z").model_copy(
        update={"source": "TST0010102031305"}
    )
    extra = read_record(line, tmp_path).extra
    assert (extra["origin_time"], extra["event_id"]) == ("2000-10-06T04:30:18+00:00", "e1")


def test_records_check_and_add_print_notes_on_shared_earthquakes(tmp_path: Path) -> None:
    for number in (1, 2):
        write_knet_component_files(tmp_path, f"TST00{number}0102031305", WAVE, -WAVE, station=f"TST00{number}")
    files = [str(tmp_path / f"TST0020102031305.{end}") for end in ("NS", "EW")]
    table = tmp_path / "records.tsv"
    table.write_text("id\tsource\tevent\torigin_time\nold\told\tTottori 2001\t2001-02-03T04:05:10\n")
    given = ["records", "add", *files, "--id", "new", "--set", "event=Hino", "--table", str(table)]
    result = CliRunner().invoke(app, [*given, "--folder", str(tmp_path / "files")])
    assert result.exit_code == 0, result.output
    assert "earthquakes: 'Tottori 2001' and 'Hino' are one earthquake (one origin, 2001-02-03 04:05)" in result.output
    # The table states no origin, but the header of the record's file does.
    table.write_text("id\tsource\tevent\nold\tTST0010102031305\tTottori 2001\n")
    for file in tmp_path.glob("TST001*"):
        (tmp_path / "files" / file.name).write_bytes(file.read_bytes())
    result = CliRunner().invoke(app, [*given, "--folder", str(tmp_path / "files")])
    assert "earthquakes: 'Tottori 2001' and 'Hino' are one earthquake (one origin" in result.output, result.output
    loose = tmp_path / "loose"
    loose.mkdir()
    _write_text_file(loose, "a.csv", "\n".join(f"{v},{-v}" for v in WAVE / 100) + "\n")
    _write_text_file(loose, "b.csv", "\n".join(f"{-v},{v}" for v in WAVE / 100) + "\n")
    columns = ["--columns", "north:gal east:gal", "--sampling-interval", "0.01", "--processed"]
    result = CliRunner().invoke(app, ["records", "check", str(loose), *columns])
    assert "2 records (a, b) name no earthquake and count as one" in result.output


@pytest.mark.parametrize(
    ("first", "second", "degrees"),
    [
        ((0, 0), (0, 1), 1),
        ((10, 20), (11, 20), 1),
        ((0, 0), (0, 180), 180),
        ((90, 0), (0, 77), 90),
        ((60, 0), (60, 180), 60),
    ],
)
def test_distances_are_measured_along_great_circles(
    first: tuple[float, float], second: tuple[float, float], degrees: float
) -> None:
    """Arcs of given angles on a sphere of 6371 km: along the equator, a meridian, and over the pole from 60° N."""
    assert great_circle_distance_km(first, second) == pytest.approx(6371 * np.pi * degrees / 180, rel=1e-9)
