import numpy as np
import pytest

from overturning.errors import ConfigError, MissingDataError
from overturning.records.catalogue import (
    COLUMNS_NOT_AFFECTING_SAMPLES,
    METADATA_KEYS_OF_FAULT_TRACE_AND_SOURCES,
    RecordTableRow,
    paths_of_record_files,
    read_record_table,
)
from overturning.records.fault_trace import parse_fault_trace
from overturning.records.read import (
    COORDINATES_WITHOUT_SOURCE_NOTE,
    copy_record_with_metadata_of_table_row,
    read_record,
    read_record_without_station_and_event_names,
)
from overturning.records.store import write_record_to_motion_file
from tests.expect import expect_error
from tests.records.record_writers import geonet_text

RECORD_TABLE_HEADER_LINE = "id\tformat\tsource\tstation\tevent\tfault_strike_deg\tpulse\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["empty"]),
        ("id\tformat\tsuorce\nx\tauto\ty\n", ["line 1", "suorce", "did you mean source?"]),
        ("id\tid\n", ["named twice"]),
        (RECORD_TABLE_HEADER_LINE + "a\tauto\tx\t\t\t400\t\n", ["line 2", "fault_strike_deg", "400"]),
        (RECORD_TABLE_HEADER_LINE + "a\tauto\tx\t\t\t\tmaybe\n", ["line 2", "pulse", "maybe"]),
        (RECORD_TABLE_HEADER_LINE + "A b\tauto\tx\t\t\t\t\n", ["line 2", "column id", "A b"]),
        (RECORD_TABLE_HEADER_LINE + "a\tauto\tx\na\tauto\ty\n", ["line 3", "twice"]),
        (RECORD_TABLE_HEADER_LINE + "a\tauto\tx\t1\t2\t3\ttrue\t8\n", ["line 2", "8 cells"]),
        (RECORD_TABLE_HEADER_LINE + "a\tauto\t\n", ["line 2", "source"]),
        ("id\tsource\tstation_latitude_deg\na\tx\t35\n", ["line 2", "station_longitude_deg", "both"]),
        ("id\tsource\tepicentre_latitude_deg\na\tx\t95\n", ["line 2", "epicentre_latitude_deg", "95"]),
        ("id\tsource\tfault_trace\na\tx\t35 133, 36 134\n", ["line 2", "fault_trace_source", "catalogue"]),
        ("id\tsource\tfault_trace\na\tx\t35 133\n", ["line 2", "fault_trace", "'35 133' is one point"]),
        ("id\tsource\tfault_trace\na\tx\t35 133, 36\n", ["line 2", "fault_trace", "'36' is no point"]),
        ("id\tsource\tfault_trace\na\tx\t35 133, 133 35\n", ["line 2", "fault_trace", "'133 35' is off the globe"]),
        ("id\tsource\tfault_trace\na\tx\t35 133, nan 35\n", ["line 2", "fault_trace", "'nan 35' is off the globe"]),
    ],
)
def test_the_error_names_an_invalid_line_of_the_record_table(tmp_path, text, words):
    path = tmp_path / "records.tsv"
    path.write_text(text)
    with expect_error(ConfigError, "records.tsv", *words):
        read_record_table(path)


def test_the_record_table_may_have_comments_a_bom_and_empty_cells(tmp_path):
    path = tmp_path / "records.tsv"
    path.write_text(
        "\ufeff# mine\n"
        + RECORD_TABLE_HEADER_LINE
        + "\n# second\na\tauto\tx.V2A\t\t\t\t\nb\tauto\ty\tSt\tEv\t12.5\tfalse\n",
        encoding="utf-8",
    )
    table = read_record_table(path)
    assert list(table) == ["a", "b"]
    assert table["a"].fault_strike_deg is None
    assert table["a"].pulse is None
    assert (table["b"].fault_strike_deg, table["b"].pulse) == (12.5, False)


def test_the_error_names_a_missing_record_table(tmp_path):
    with pytest.raises(ConfigError, match=r"none\.tsv"):
        read_record_table(tmp_path / "none.tsv")


def test_a_record_table_row_with_a_missing_file_is_refused(tmp_path):
    for name in ("x.NS", "x.EW"):
        (tmp_path / name).write_text("")
    entry = RecordTableRow(id="x", source="x.NS x.EW x.UD")
    with expect_error(MissingDataError, "record x", "x.UD is not in"):
        paths_of_record_files(entry, tmp_path)
    (tmp_path / "x.UD").write_text("")
    assert [path.name for path in paths_of_record_files(entry, tmp_path)] == ["x.NS", "x.EW", "x.UD"]


ROW_WITH_ALL_DESCRIPTIVE_COLUMNS = RecordTableRow(
    id="mine",
    source="mine.V2A",
    station="Church",
    event="Darfield 2010",
    event_id="e1",
    origin_time="2010-09-03T16:35:46",
    fault_strike_deg=90,
    pulse=True,
    magnitude=7.1,
    rupture_distance_km=5,
    site_class="D",
    vs30_m_s=200,
    pulse_period_s=1.5,
    wall="foot",
    station_latitude_deg=-43.5,
    station_longitude_deg=172.5,
    epicentre_latitude_deg=-43.6,
    epicentre_longitude_deg=172.1,
    coordinates_source="survey of 2011",
    fault_trace="-43.6 172.0, -43.6 172.3",
    fault_trace_source="map of 2011",
    licence="CC-BY",
)
"""Line of the record table with every column that does not affect the samples."""


def test_descriptive_columns_of_the_record_table_change_no_sample(tmp_path):
    """Columns such as station and event names describe a record; samples are the same with and without them."""
    assert {name for name in RecordTableRow.model_fields if getattr(ROW_WITH_ALL_DESCRIPTIVE_COLUMNS, name) not in ("",
    None, False, 0.0)} == {
        *COLUMNS_NOT_AFFECTING_SAMPLES, "id", "source", "format",
    }  # fmt: skip
    wave = 100 * np.sin(np.arange(400) / 5)
    text = geonet_text({"N28W": (332, wave), "S62W": (242, 2 * wave)}, 0.02)
    (tmp_path / "mine.V2A").write_text(text, encoding="utf-8")
    bare, labelled = (
        read_record_without_station_and_event_names(one, tmp_path)
        for one in (RecordTableRow(id="mine", source="mine.V2A"), ROW_WITH_ALL_DESCRIPTIVE_COLUMNS)
    )
    write_record_to_motion_file(bare, tmp_path / "bare.nc")
    write_record_to_motion_file(labelled, tmp_path / "labelled.nc")
    assert (tmp_path / "bare.nc").read_bytes() == (tmp_path / "labelled.nc").read_bytes()
    described = copy_record_with_metadata_of_table_row(bare, ROW_WITH_ALL_DESCRIPTIVE_COLUMNS)
    assert (described.station, described.event, described.latitude) == ("Church", "Darfield 2010", -43.5)
    assert described.extra["magnitude"] == 7.1
    assert {name: described.extra[name] for name in METADATA_KEYS_OF_FAULT_TRACE_AND_SOURCES} == {
        "coordinates_source": "survey of 2011",
        "fault_trace": "-43.6 172.0, -43.6 172.3",
        "fault_trace_source": "map of 2011",
    }
    write_record_to_motion_file(described, tmp_path / "described.nc")
    write_record_to_motion_file(read_record(ROW_WITH_ALL_DESCRIPTIVE_COLUMNS, tmp_path), tmp_path / "whole.nc")
    assert (tmp_path / "described.nc").read_bytes() == (tmp_path / "whole.nc").read_bytes()


def test_a_fault_trace_is_split_into_pieces_at_semicolons() -> None:
    """Latitude before longitude; a semicolon begins another piece, and one at the end begins none."""
    assert parse_fault_trace("40.71 29.34, 40.73  29.52;40.7 -29.61,-40.75 29.88 ,0 0;") == (
        ((40.71, 29.34), (40.73, 29.52)),
        ((40.7, -29.61), (-40.75, 29.88), (0.0, 0.0)),
    )


def test_record_table_coordinates_without_a_source_are_noted(tmp_path):
    """Coordinates in the record table need a source; those in a record file do not, as the file is their source."""
    wave = 100 * np.sin(np.arange(400) / 5)
    text = geonet_text({"N28W": (332, wave), "S62W": (242, 2 * wave)}, 0.02)
    (tmp_path / "mine.V2A").write_text(text, encoding="utf-8")
    samples = read_record_without_station_and_event_names(RecordTableRow(id="mine", source="mine.V2A"), tmp_path)
    stated = {"station_latitude_deg": -43.5, "station_longitude_deg": 172.5}
    of_file, bare, sourced = (
        copy_record_with_metadata_of_table_row(samples, RecordTableRow(id="mine", source="mine.V2A", **cells))
        for cells in ({}, stated, stated | {"coordinates_source": "survey of 2011"})
    )
    assert of_file.latitude is not None
    assert [one.extra.get("coordinates_source") for one in (of_file, bare, sourced)] == [None, "", "survey of 2011"]
    assert [COORDINATES_WITHOUT_SOURCE_NOTE in one.notes for one in (of_file, bare, sourced)] == [False, True, False]
