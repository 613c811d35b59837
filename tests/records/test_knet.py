import hashlib
from datetime import UTC
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import overturning
from overturning.commands.application import app
from overturning.errors import MissingDataError, RecordError
from overturning.records.catalogue import RecordTableRow
from overturning.records.component import checked_relative_header_peak_difference
from overturning.records.declared_properties import DeclaredFileProperties
from overturning.records.formats import knet
from overturning.records.processing import process_record
from overturning.records.read import read_record, read_record_without_processing
from overturning.records.record import processing_peaks_and_notes_of_record
from overturning.records.source import SourceFile, read_source_file
from tests.expect import expect_error, skip_test_unless_skipping_is_forbidden
from tests.records.record_writers import knet_text, write_knet_component_files
from tests.records.test_archives import tar_archive, zip_archive

ACCELERATION_PER_COUNT_M_S2 = 2000 / 8388608 * 0.01
random = np.random.default_rng(20001006)
NORTH, EAST, UP = (random.integers(-400_000, 400_000, 1000) + 12_345 for _ in range(3))


def test_kik_net_surface_and_borehole_sensors_have_their_own_gains(tmp_path):
    deep = write_knet_component_files(
        tmp_path, "TTRH02X", NORTH, EAST, UP, kik=1, station="TTRH02", scale=(3920, 6182761), rate="200Hz"
    )
    top = write_knet_component_files(
        tmp_path, "TTRH02X", UP, NORTH, EAST, kik=2, station="TTRH02", scale=(7845, 8223790), rate="200Hz"
    )
    surface = read_record_without_processing([*deep, *top])
    np.testing.assert_allclose(surface.north, UP * 7845 / 8223790 * 0.01, rtol=1e-12)
    borehole = read_record_without_processing([*top, *deep], DeclaredFileProperties(sensor="borehole"))
    np.testing.assert_allclose(borehole.north, NORTH * 3920 / 6182761 * 0.01, rtol=1e-12)
    assert surface.sampling_interval == 0.005
    assert surface.station == "TTRH02"
    with pytest.raises(RecordError, match="borehole"):
        read_record_without_processing(top, DeclaredFileProperties(sensor="borehole"))
    assert surface.notes == []  # the other sensor gives a separate record
    mixed = read_record_without_processing(
        [*(path for path in top if ".UD" not in path.name), *(p for p in deep if ".UD" in p.name)]
    )
    assert mixed.up is None
    assert mixed.notes == ["axis 'UD1' left out: TTRH02X.UD1 is of the borehole sensor"]


def test_a_kik_net_borehole_alone_is_refused_unless_declared(tmp_path):
    files = write_knet_component_files(tmp_path, "ISKH010705060000", NORTH, EAST, UP, kik=1, station="ISKH01")
    refused = r"axis (NS|EW)1 is of the borehole sensor of ISKH01; declare it .*--sensor borehole"
    with pytest.raises(RecordError, match=refused):
        read_record_without_processing(files[0])
    with pytest.raises(RecordError, match=refused):
        overturning.read(files)
    assert overturning.read(files, sensor="borehole").station == "ISKH01 (borehole)"
    line = {"id": "iskh01", "source": "ISKH010705060000"}
    with pytest.raises(RecordError, match=refused):
        read_record(RecordTableRow.model_validate(line), tmp_path)
    named = RecordTableRow.model_validate(line | {"sensor": "borehole", "station": "ISKH01 Otani"})
    record = read_record(named, tmp_path)
    assert record.station == "ISKH01 Otani (borehole)"
    assert processing_peaks_and_notes_of_record(process_record(record, None))["declared"] == ["borehole sensor"]


def test_commands_refuse_a_borehole_record_unless_declared_and_name_it(tmp_path):
    files = write_knet_component_files(tmp_path, "ISKH010705060000", NORTH, EAST, UP, kik=1, station="ISKH01")
    table, folder = tmp_path / "records.tsv", tmp_path / "files"
    add = ["records", "add", *map(str, files), "--table", str(table), "--folder", str(folder)]
    result = CliRunner().invoke(app, add)
    assert result.exit_code != 0
    assert "borehole" in str(result.exception)
    assert not table.exists()
    assert not folder.exists()
    result = CliRunner().invoke(app, [*add, "--set", "sensor=borehole"])
    assert result.exit_code == 0, result.output
    assert "ISKH01 (borehole)" in result.output
    looked_at = CliRunner().invoke(app, ["records", "check", str(folder)]).output
    assert "ISKH01 (borehole)" in looked_at
    assert "of a borehole: refused unless it is declared (--sensor borehole" in looked_at
    assert "declared: " not in looked_at
    declared = CliRunner().invoke(app, ["records", "check", str(folder), "--sensor", "borehole"]).output
    assert "declared: borehole sensor" in declared
    assert "refused unless" not in declared


@pytest.mark.parametrize("kind", ["tar.gz", "zip", "nested"])
def test_k_net_files_are_read_from_an_archive_of_many_stations(tmp_path, kind):
    files = write_knet_component_files(tmp_path, "TTRH020010061330", NORTH, EAST, UP, kik=2, station="TTRH02")
    files += write_knet_component_files(tmp_path, "SMNH010010061330", UP, UP, UP, kik=2, station="SMNH01")
    members = {f"20001006/{file.name}": file.read_bytes() for file in files}
    out = tmp_path / "data"
    out.mkdir()
    data = {
        "zip": zip_archive(members),
        "tar.gz": tar_archive(members),
        "nested": tar_archive({"kik.tar.gz": tar_archive(members)}, "w"),
    }
    (out / f"20001006.{kind.replace('nested', 'tar')}").write_bytes(data[kind])
    entry = RecordTableRow(id="ttrh02", format="kik-net", source="TTRH020010061330", event="Western Tottori 2000")
    record = read_record(entry, out)
    np.testing.assert_allclose(record.north, NORTH * ACCELERATION_PER_COUNT_M_S2, rtol=1e-12)
    assert record.station == "TTRH02"


def test_k_net_and_kik_net_records_name_their_network(tmp_path):
    for kik, name in ((None, "k-net"), (2, "kik-net")):
        folder = tmp_path / name
        folder.mkdir()
        first = write_knet_component_files(folder, "TST0010102031305", NORTH, EAST, kik=kik)[0]
        assert f"\n  {name}, raw: TST001" in CliRunner().invoke(app, ["records", "check", str(folder)]).output
        for declared in (name, "kik-net", "auto"):  # older tables have one name for both
            record = read_record(RecordTableRow(id="x", format=declared, source="TST0010102031305"), folder)
            assert record.source == f"{name} TST0010102031305"
        with expect_error(RecordError, "not a K-NET ASCII file" if kik else "not a GeoNet"):
            read_record_without_processing(first, DeclaredFileProperties(format="k-net" if kik else "geonet"))
    with expect_error(MissingDataError, "TST001.NS, TST001.EW, TST001.UD (or"):
        read_record(RecordTableRow(id="x", format="k-net", source="TST001"), tmp_path)


def test_missing_k_net_files_are_named_with_source_and_folder(tmp_path):
    entry = RecordTableRow(id="ttrh02", format="kik-net", source="TTRH020010061330")
    words = ("TTRH020010061330.NS2", "EW2", "UD2", "NIED", "kyoshin.bosai.go.jp", str(tmp_path / "nied"))
    with expect_error(MissingDataError, *words, brief=True):
        read_record(entry, tmp_path / "nied")


def test_a_single_k_net_component_is_refused(tmp_path):
    north, east = write_knet_component_files(tmp_path, "T", NORTH, EAST)
    assert read_record_without_processing(north).north.size == NORTH.size  # the other component is in the same folder
    east.unlink()
    with pytest.raises(RecordError, match="two horizontal"):
        read_record_without_processing(north)


def read_knet_text(text: str, name: str = "T.NS"):
    """Read the component in the text of a K-NET file."""
    return knet.read_components(SourceFile(name, text.encode("utf-8")))[0]


def test_fractional_k_net_rates_and_scale_factors_are_read_exactly():
    """Obspy's reader drops the decimals: 99.5Hz is 99 and 7845.6(gal) is 7845."""
    component = read_knet_text(knet_text(NORTH[:199], rate="99.5Hz", scale=("7845.6", 8223790)))
    assert component.sampling_interval == 1 / 99.5
    np.testing.assert_allclose(component.acceleration, NORTH[:199] * 7845.6 / 8223790 * 0.01, rtol=1e-12)


def test_a_k_net_file_with_blank_magnitude_and_japanese_memo_is_read():
    text = knet_text(NORTH, magnitude="", memo="補正なし")
    assert "magnitude" not in read_knet_text(text).extra_metadata
    component = knet.read_components(SourceFile("T.NS", text.encode("shift_jis")))[0]
    np.testing.assert_allclose(component.acceleration, NORTH * ACCELERATION_PER_COUNT_M_S2, rtol=1e-12)


@pytest.mark.parametrize(
    ("change", "line", "word"),
    [
        (lambda t: t[:150], 6, "ends in the header"),
        (lambda t: t.replace("100Hz", "0Hz"), 11, "0 Hz"),
        (lambda t: t.replace("100Hz", "******"), 11, "not a number"),
        (lambda t: t.replace("2000(gal)", "2000.5.1(gal)"), 14, "not a number"),
        (lambda t: t.replace("(gal)/", " "), 14, "scale factor"),
        (lambda t: t.replace("2001/02/03 13:05:21", "2001/02/33 13:05:21"), 1, "Origin|Record Time"),
        (lambda t: t.replace("Dir.              N-S", "Dir.              H1"), 13, "direction"),
        (lambda t: t.replace("Dir.              N-S", "Dir.              E-W"), 13, "swapped"),
        (lambda t: t[:-300], 12, "header promises 1000 samples, the file has"),
        (lambda t: t + t, 143, "whole number"),
        (lambda t: t.replace(f"{NORTH[16]:>9d}", "      NaN"), 20, "whole number"),
        (lambda t: t.replace(f"{NORTH[16]:>9d}", " ********"), 20, "whole number"),
        (lambda t: t.replace(f"{NORTH[16]:>9d}{NORTH[17]:>9d}", f" {NORTH[16]}-{abs(NORTH[17])}"), 20, "whole number"),
    ],
)
def test_k_net_errors_name_the_file_and_line(change, line, word):
    text = change(knet_text(NORTH))
    with pytest.raises(RecordError, match=word) as problem:
        read_knet_text(text)
    assert "T.NS" in str(problem.value)
    if line:
        assert f"line {line}" in str(problem.value)


def test_an_archive_of_many_stations_needs_the_station_to_be_named(tmp_path):
    files = [
        file
        for station in ("TST001", "TST002")
        for file in write_knet_component_files(tmp_path, f"{station}0102031305", NORTH, EAST, UP, station=station)
    ]
    path = tmp_path / "data" / "event.zip"
    path.parent.mkdir()
    path.write_bytes(zip_archive({file.name: file.read_bytes() for file in files}))
    with expect_error(RecordError, "2 records (TST001, TST002)"):
        read_record_without_processing(path)
    with expect_error(RecordError, "2 records"):
        read_record(RecordTableRow(id="all", source="event.zip"), path.parent)
    entry = RecordTableRow(id="two", format="kik-net", source="TST0020102031305")
    assert read_record(entry, path.parent).station == "TST002"


def test_orientation_corrections_in_the_record_table_rotate_the_components(tmp_path):
    """The sensor's north is 7° west of magnetic north, which is 5° east of true north: azimuths −2° and 88°."""
    write_knet_component_files(tmp_path, "T", NORTH, EAST)
    entry = RecordTableRow(
        id="t", format="kik-net", source="T", orientation_correction_deg=-7, magnetic_declination_deg=5
    )
    record = read_record(entry, tmp_path)
    assert set(record.component_azimuths_deg) == {358.0, 88.0}
    c, s = np.cos(np.radians(-2)), np.sin(np.radians(-2))
    np.testing.assert_allclose(record.north, (NORTH * c - EAST * s) * ACCELERATION_PER_COUNT_M_S2, atol=1e-9)
    np.testing.assert_allclose(record.east, (NORTH * s + EAST * c) * ACCELERATION_PER_COUNT_M_S2, atol=1e-9)


def test_declared_azimuths_replace_azimuths_in_the_files_with_a_note(tmp_path):
    """Files are sorted by name, EW before NS, so declared azimuths 0 and 90 would exchange the components."""
    write_knet_component_files(tmp_path, "T", NORTH, EAST)
    record = read_record(RecordTableRow(id="t", format="kik-net", source="T", azimuths_deg=(0, 90)), tmp_path)
    assert record.notes == [
        f"axis '{axis}' is taken at {declared}°, as declared; its file says {stated}°"
        for axis, declared, stated in (("EW", 0, 90), ("NS", 90, 0))
    ]
    np.testing.assert_allclose(record.north, EAST * ACCELERATION_PER_COUNT_M_S2, atol=1e-9)
    same = read_record(RecordTableRow(id="t", format="kik-net", source="T", azimuths_deg=(90, 360)), tmp_path)
    assert same.notes == []


def test_pictures_with_the_same_stem_as_a_record_are_skipped(tmp_path):
    """Regression: a picture next to the files made a record of the table unreadable."""
    write_knet_component_files(tmp_path, "T", NORTH, EAST)
    for name in ("T.pdf", "T.PNG", "T.ps.gz", "T.json"):
        (tmp_path / name).write_bytes(b"%PDF")
    record = read_record(RecordTableRow(id="t", format="kik-net", source="T"), tmp_path)
    np.testing.assert_allclose(record.north, NORTH * ACCELERATION_PER_COUNT_M_S2, atol=1e-9)
    (tmp_path / "P.pdf").write_bytes(b"%PDF")
    with expect_error(MissingDataError, "record p: P is not in"):
        read_record(RecordTableRow(id="p", source="P"), tmp_path)


def test_the_hash_of_several_files_is_compared_with_the_record_table(tmp_path):
    paths = write_knet_component_files(tmp_path, "T", NORTH, EAST, UP)
    own = [hashlib.sha256(path.read_bytes()).hexdigest() for path in sorted(paths)]
    joint = hashlib.sha256("".join(own).encode("ascii")).hexdigest()
    line = {"id": "t", "format": "kik-net", "source": "T"}
    assert read_record(RecordTableRow(**line, sha256=joint), tmp_path).sha256 == joint
    with expect_error(RecordError, "the record table says 0000"):
        read_record(RecordTableRow(**line, sha256="0" * 64), tmp_path)


@pytest.mark.parametrize("end", ["", "\n"])
@pytest.mark.parametrize("count", [8, 24])
def test_a_complete_last_line_of_a_k_net_file_is_not_called_truncated(count, end):
    """A last line is complete if it ends in a line break, is as wide as the line before, or is the only one."""
    text = knet_text(NORTH[:count]).rstrip("\n")
    if end and count > 8:
        text = text[: text.rindex("\n") + 1] + " ".join(text[text.rindex("\n") :].split())
    component = knet.read_components(SourceFile("T.NS", (text + end).encode("ascii")))[0]
    np.testing.assert_allclose(component.acceleration, NORTH[:count] * ACCELERATION_PER_COUNT_M_S2, rtol=1e-12)


def test_a_real_k_net_file_agrees_with_its_own_header():
    """Obspy brings one K-NET file for its own tests; NIED's files may not be redistributed."""
    import obspy

    path = Path(obspy.__file__).parent / "io" / "nied" / "tests" / "data" / "test.knet"
    if not path.exists():
        skip_test_unless_skipping_is_forbidden("this obspy comes without its test data")
    component = knet.read_components(read_source_file(path))[0]
    trace = obspy.read(str(path), format="KNET")[0]
    np.testing.assert_allclose(component.acceleration, trace.data * trace.stats.calib, rtol=1e-12)
    assert component.start_time_utc == trace.stats.starttime.datetime.replace(tzinfo=UTC)
    difference = checked_relative_header_peak_difference(component, lambda *why: pytest.fail("; ".join(why)))
    assert difference is not None
    assert difference < 0.001
