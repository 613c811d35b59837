"""A vertical component in the folder of a record that lacks it."""

import numpy as np
import pytest

from overturning.records.catalogue import RecordTableRow
from overturning.records.check import check_records_in_files
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.read import read_record, read_record_without_processing
from tests.records.record_writers import peer_text

A, B, C = np.random.default_rng(2).normal(0, 0.05, (3, 500))


@pytest.mark.parametrize(
    "names", [("N55W", "N35E", "UP", 2), ("NS", "EW", "UD", 2), ("000", "090", "DWN", 2), ("055", "325", "UP", 1)]
)
def test_a_note_names_a_vertical_component_file_in_the_folder_that_was_not_read(tmp_path, names):
    *axes, given = names
    paths = [tmp_path / f"RSN1_TEST_{axis}.AT2" for axis in axes]
    for path, axis, samples in zip(paths, axes, (A, B, C), strict=True):
        path.write_text(peer_text(samples, 0.01, axis))
    (tmp_path / "RSN2_TEST_UP.AT2").write_text(peer_text(C, 0.01, "UP").replace("Receiving", "Other"))
    note = f"vertical component left out: {paths[2].name} in the same folder holds it; name it too"
    named = paths[0] if given == 1 else paths[:2]
    assert note in read_record_without_processing(named).notes
    (finding,) = check_records_in_files([named] if given == 1 else named)
    assert note in finding.unprocessed_record.notes
    entry = RecordTableRow(id="x", source=" ".join(path.name for path in paths[:2]))
    assert note in read_record(entry, tmp_path).notes
    assert note not in read_record_without_processing(paths).notes
    assert note not in read_record_without_processing(paths[:2], DeclaredFileProperties(vertical_sense="none")).notes
    paths[2].unlink()
    assert read_record_without_processing(paths[:2]).notes == []
