"""The record that comes with the package: three components of the 2016 Kaikoura earthquake."""

from pathlib import Path

import numpy as np
import pytest

from overturning.errors import MissingDataError
from overturning.records.catalogue import RecordTableRow, paths_of_record_files, read_record_table
from overturning.records.processing import process_record
from overturning.records.read import read_record
from overturning.records.record import processing_peaks_and_notes_of_record
from overturning.records.steps import Highpass
from overturning.records.store import (
    read_record_before_processing_if_processed,
    read_record_from_motion_file,
    write_record_to_motion_file,
)
from tests.expect import expect_error

DEFAULT_RECORD_TABLE_PATH = Path(__file__).parents[2] / "config" / "records.tsv"


def test_the_example_record_agrees_with_its_row_of_the_record_table(tmp_path):
    entry = read_record_table(DEFAULT_RECORD_TABLE_PATH)["wtmc"]
    record = read_record(entry, tmp_path)
    north, east = np.cos(np.radians(332)), np.sin(np.radians(332))
    assert np.abs(record.north * north + record.east * east).max() == pytest.approx(9.7331, abs=1e-4)
    assert record.up is not None
    assert np.abs(record.up).max() / 9.80665 == pytest.approx(1.84, abs=0.005)
    assert record.sha256 == entry.sha256
    assert "CC BY" in record.licence
    assert (record.extra["magnitude"], record.extra["rupture_distance"]) == (7.8, 1.5)
    assert [path.suffix for path in paths_of_record_files(entry, tmp_path)] == [".zip"]


def test_an_unknown_example_record_is_refused_with_the_known_names(tmp_path):
    with expect_error(MissingDataError, "record x", "'none.V2A'", "20161113_110259_WTMC_20.V2A"):
        read_record(RecordTableRow(id="x", source="example:none.V2A"), tmp_path)


def test_the_example_processed_by_its_agency_is_not_processed_by_default(tmp_path):
    raw = read_record(read_record_table(DEFAULT_RECORD_TABLE_PATH)["wtmc"], tmp_path)
    assert process_record(raw, None) is raw
    told = processing_peaks_and_notes_of_record(raw)
    assert told["data"] == "processed by GNS Science"
    assert told["agency"].startswith("band-pass filter")
    assert told["peaks"]["pga"][0] == told["peaks"]["pga"][1]
    done = process_record(raw, [Highpass(corner_hz=0.5)])
    write_record_to_motion_file(done, tmp_path / "m.nc", raw)
    kept, before = (
        read_record_from_motion_file(tmp_path / "m.nc"),
        read_record_before_processing_if_processed(tmp_path / "m.nc"),
    )
    assert before is not None
    np.testing.assert_allclose(before.north, raw.north, atol=1e-9)
    assert (before.start, kept.start) == (raw.start, done.start)
    assert kept.start != before.start
    assert (
        processing_peaks_and_notes_of_record(kept)["peaks"]["pgd"][0]
        > 2 * processing_peaks_and_notes_of_record(kept)["peaks"]["pgd"][1]
    )
    write_record_to_motion_file(raw, tmp_path / "m.nc")
    assert read_record_before_processing_if_processed(tmp_path / "m.nc") is None
