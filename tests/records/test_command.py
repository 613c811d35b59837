"""The commands `overturning records …`."""

import numpy as np
import pytest

import overturning
from overturning.cli import main
from overturning.errors import ArgumentError
from overturning.records.catalogue import read_record_table
from overturning.records.read import read_record
from overturning.records.record import processing_peaks_and_notes_of_record
from tests.expect import expect_error
from tests.records.record_writers import csmip_text, geonet_text, peer_text
from tests.records.seed_writers import write_mseed, write_stationxml_of_channels
from tests.records.world_writers import unam_text

A, B = (np.round(np.random.default_rng(k).normal(0, 50, 200), 1) for k in (1, 2))


def exit_status_of_overturning_command(*arguments: object) -> int:
    """Run an `overturning` command in this process and return its exit status."""
    try:
        main([str(a) for a in arguments])
    except SystemExit as end:
        return int(end.code or 0)
    return 0


def test_records_check_reads_valid_files_and_gives_reasons_for_the_others(tmp_path, capsys):
    (tmp_path / "good.V2A").write_text(geonet_text({"N28W": (332, A), "S62W": (242, B)}, 0.02))
    (tmp_path / "bad.V2A").write_text(geonet_text({"N28W": (332, A), "S62W": (242, B)}, 0.02)[:3000])
    (tmp_path / "notes.txt").write_text("my notes")
    assert exit_status_of_overturning_command("records", "check", tmp_path / "good.V2A") == 0
    out = capsys.readouterr().out
    for word in ("good.V2A", "N28W: azimuth 332", "S62W: azimuth 242", "header", "1 read, 0 refused"):
        assert word in out
    assert exit_status_of_overturning_command("records", "check", tmp_path) == 1
    out = capsys.readouterr().out
    assert "bad.V2A\n  refused: bad.V2A line" in out
    assert "notes.txt\n  refused: notes.txt: the format is not recognised" in out
    assert "1 read, 2 refused" in out


def test_records_check_accepts_declared_properties(tmp_path, capsys):
    paths = [tmp_path / "x1.AT2", tmp_path / "x2.AT2"]
    for path, samples, axis in zip(paths, (A, B), ("H1", "H2"), strict=True):
        path.write_text(peer_text(samples / 1000, 0.01, axis))
    assert exit_status_of_overturning_command("records", "check", *paths) == 1
    assert exit_status_of_overturning_command("records", "check", "--azimuths", "60,330", *paths) == 0
    for impossible in ("60;330", "nan,90", "0,inf", "0,6e9"):
        assert exit_status_of_overturning_command("records", "check", "--azimuths", impossible, *paths) == 1
        assert "--azimuths" in capsys.readouterr().err
    table = tmp_path / "x.csv"
    table.write_text("".join(f"{a},{b}\n" for a, b in zip(A, B, strict=True)))
    assert exit_status_of_overturning_command("records", "check", "--columns", "north:gal east:gal", table) == 1
    reasons = [line for line in capsys.readouterr().out.splitlines() if "refused: x.csv: " in line]
    assert ["no sampling_interval_s" in reasons[0], "--processed or --raw" in reasons[1]] == [True, True]
    assert (
        exit_status_of_overturning_command(
            "records", "check", "--columns", "north:gal east:gal", "--sampling-interval", 0.01, "--raw", table
        )
        == 0
    )
    assert exit_status_of_overturning_command("records", "check", "--unit", "feet", table) == 1
    assert "--unit: \"feet\" – it should be 'm/s2'" in capsys.readouterr().err


def test_records_check_accepts_a_wrong_header_peak_only_with_trust_data(tmp_path, capsys):
    path = tmp_path / "x.V2A"
    text = geonet_text({"N28W": (332, A), "S62W": (242, B)}, 0.02)
    first = text.splitlines()[13]
    path.write_text(text.replace(first, first.replace(f"{A[np.abs(A).argmax()]:8.1f}", "   999.9")))
    assert exit_status_of_overturning_command("records", "check", path) == 1
    assert "line 14" in capsys.readouterr().out
    assert exit_status_of_overturning_command("records", "check", "--trust-data", path) == 0


@pytest.mark.parametrize(
    "arguments",
    [["fetch", "url", "ftp://x", "--sha256", "0" * 64], ["fetch", "fdsn", "x", "--network", "X", "--station", "Y"]],
)
def test_invalid_arguments_of_records_fetch_end_with_an_error_message(arguments, capsys, tmp_path):
    assert exit_status_of_overturning_command("records", *arguments, "--folder", tmp_path) == 1
    assert capsys.readouterr().err.startswith("error: ")


def test_a_file_of_another_sensor_than_declared_is_refused(capsys, tmp_path):
    path = write_time_north_and_east_columns(tmp_path / "x.csv")
    words = ("--columns", "time:s north:gal east:gal", "--processed", "--sensor")
    assert exit_status_of_overturning_command("records", "check", path, *words, "surface") == 0
    assert exit_status_of_overturning_command("records", "check", path, *words, "borehole") == 1
    said = capsys.readouterr().out
    assert "refused: of the surface sensor; borehole is declared" in said
    assert "0 read, 1 refused" in said


def test_the_error_names_an_impossible_declared_property(tmp_path):
    path = write_time_north_and_east_columns(tmp_path / "x.csv")
    for name, value, known in (
        ("format", "geonett", "known are"),
        ("unit", "feet", "it should be 'm/s2', "),
        ("sensor", "roof", "it should be 'surface' or 'borehole'"),
        ("vertical_sense", "left", "it should be 'up', 'down' or 'none'"),
        ("sampling_interval_s", 2.0, "less than or equal to 1"),
        ("azimuths_deg", (0.0, 45.0, 90.0), "at most 2 values allowed"),
        ("azimuths_deg", (0.0, 900.0), "less than or equal to 540"),
        ("azimuths_deg", (np.nan, 90.0), "NaN"),
        ("correction_deg", np.inf, "a finite number is needed"),
        ("x", 1, "known are"),
    ):
        with expect_error(ArgumentError, name, known):
            overturning.read(path, **{name: value})


WAVE = 300 * np.sin(np.arange(4000) * 0.05) * np.exp(-(((np.arange(4000) - 2000) / 600) ** 2))


def write_time_north_and_east_columns(path, scale=1.0, offset=0.0):
    """Write a file with columns of time, north and east, whose samples are scaled and offset."""
    rows = zip(np.arange(WAVE.size) * 0.01, scale * WAVE + offset, -scale * WAVE + offset, strict=True)
    path.write_text("".join(f"{t:.2f},{n:.6f},{e:.6f}\n" for t, n, e in rows))
    return path


def test_an_omitted_vertical_axis_is_noted_by_read_and_every_command(tmp_path, capsys):
    path = tmp_path / "x.asa"
    path.write_text(unam_text({"N00E": A, "N90E": B, "V": A}))
    word = "vertical axis 'V' left out: x.asa does not say whether up or down"
    with pytest.warns(UserWarning, match=word):
        record = overturning.read(path)
    assert record.up is None
    assert word in processing_peaks_and_notes_of_record(record)["notes"][0]
    table = tmp_path / "records.tsv"
    place = ("--table", table, "--folder", tmp_path / "data")
    for command in (
        ("records", "check", path),
        ("records", "plot", path, "--output", tmp_path / "x.png"),
        ("records", "add", path, *place),
        ("one", "--record", path, "--azimuth", 0),
    ):
        assert exit_status_of_overturning_command(*command) == 0
        assert word in capsys.readouterr().out, command
    assert (tmp_path / "x.png").read_bytes().startswith(b"\x89PNG")


def test_records_check_and_add_include_files_of_the_other_components(tmp_path, capsys):
    there = tmp_path / "there"
    there.mkdir()
    files = {f"x_{axis}.AT2": peer_text(samples / 1000, 0.01, axis) for axis, samples in (("000", A), ("090", B))}
    files["x_UPP.AT2"] = peer_text(A / 1000, 0.01, "UP")
    for name, text in files.items():
        (there / name).write_text(text)
    (there / "y_000.AT2").write_text(peer_text(A / 1000, 0.01, "000"))
    assert exit_status_of_overturning_command("records", "check", there / "x_090.AT2") == 0
    checked = capsys.readouterr().out
    assert all(name in checked for name in files)
    assert "1 read, 0 refused" in checked
    table, folder = tmp_path / "records.tsv", tmp_path / "data"
    assert (
        exit_status_of_overturning_command(
            "records", "add", there / "x_090.AT2", "--id", "x", "--table", table, "--folder", folder
        )
        == 0
    )
    assert sorted(path.name for path in folder.iterdir()) == sorted(files)
    entry = read_record_table(table)["x"]
    assert sorted(entry.source.split()) == sorted(files)
    assert read_record(entry, folder).up is not None
    # MiniSEED needs its StationXML.
    write_stationxml_of_channels(there / "s.xml", {"HNN": (0.0, 0.0), "HNE": (90.0, 0.0)})
    write_mseed(there / "z.mseed", {"HNN": np.int64(1000 * A), "HNE": np.int64(1000 * B)})
    assert (
        exit_status_of_overturning_command("records", "add", there / "z.mseed", "--table", table, "--folder", folder)
        == 0
    )
    assert read_record_table(table)["z"].source == "z.mseed s.xml"


def test_records_add_prints_the_notes_of_check_and_names_duplicates(tmp_path, capsys):
    time = np.arange(3000) / 100
    for name, more in (("a", 0), ("b", 5)):
        wave = np.random.default_rng(4).normal(0, 50, (2, time.size)) * np.exp(-(((time - 15) / 4) ** 2))
        wave = np.pad([np.convolve(axis, np.ones(9) / 2, "same") for axis in wave], ((0, 0), (more, 0)))
        np.savetxt(tmp_path / f"{name}.csv", np.clip(wave, -90, 90).T, fmt="%.2f", delimiter=",")
    columns = "north:gal east:gal"
    declared = ("--columns", columns, "--sampling-interval", "0.01", "--processed")
    exit_status_of_overturning_command("records", "check", tmp_path / "a.csv", *declared)
    checked = [line for line in capsys.readouterr().out.splitlines() if "  declared: " in line or "clipped" in line]
    assert len(checked) == 3
    table = ("--table", tmp_path / "records.tsv", "--folder", tmp_path / "data")
    values = (f"columns={columns}", "sampling_interval_s=0.01", "processed=true", "format=csv")
    sets = [word for value in values for word in ("--set", value)]
    assert exit_status_of_overturning_command("records", "add", tmp_path / "a.csv", *table, *sets) == 0
    added = capsys.readouterr().out
    assert all(line in added.splitlines() for line in checked)
    assert "have the same samples" not in added
    assert exit_status_of_overturning_command("records", "add", tmp_path / "b.csv", *table, *sets) == 0
    assert "records a and b have the same samples" in capsys.readouterr().out
    assert (
        exit_status_of_overturning_command("records", "check", tmp_path / "a.csv", tmp_path / "b.csv", *declared) == 0
    )
    assert "records a.csv and b.csv have the same samples" in capsys.readouterr().out


def test_records_add_refuses_invalid_table_cells(tmp_path, capsys):
    path = tmp_path / "my site.V2A"
    path.write_text(geonet_text({"N28W": (332, A), "S62W": (242, B)}, 0.02))
    table, folder = tmp_path / "records.tsv", tmp_path / "data"
    place = ("--table", table, "--folder", folder)
    assert exit_status_of_overturning_command("records", "add", path, *place) == 1
    assert "'my site.V2A': blanks set off the files" in capsys.readouterr().err
    path = path.rename(tmp_path / "mine.V2A")
    for text in ("Te\tMara", '"Te Mara"', "Te\nMara"):
        assert exit_status_of_overturning_command("records", "add", path, *place, "--set", f"station={text}") == 1
        assert "a cell of the record table has no tab" in capsys.readouterr().err
    for twice in (("--set", "event=A", "--set", "event=B"), ("--id", "a", "--set", "id=b")):
        assert exit_status_of_overturning_command("records", "add", path, *place, *twice) == 1
        assert "given twice; keep one" in capsys.readouterr().err
    assert not table.exists()
    assert not folder.exists()
    assert exit_status_of_overturning_command("records", "add", path, *place, "--set", 'station=Te "Mara"') == 0
    assert read_record_table(table)["mine"].station == 'Te "Mara"'


def test_records_add_preserves_the_records_shipped_with_the_package(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "x.V2A"
    path.write_text(geonet_text({"N28W": (332, A), "S62W": (242, B)}, 0.02))
    one = ("one", "--azimuth", 0, "--record")
    assert exit_status_of_overturning_command(*one, "rinaldi") == 0
    assert exit_status_of_overturning_command("records", "add", path, "--id", "mine") == 0
    assert (tmp_path / "config" / "records.tsv").is_file()
    for record in ("rinaldi", "mine"):
        assert exit_status_of_overturning_command(*one, record) == 0
    assert exit_status_of_overturning_command("records", "add", path, "--id", "rinaldi") == 1
    assert "id 'rinaldi' is there already" in capsys.readouterr().err


def test_the_refusal_of_an_implausible_unit_names_a_plausible_one(tmp_path, capsys):
    path = write_time_north_and_east_columns(tmp_path / "x.csv")
    given = ("records", "check", "--raw", path)
    assert exit_status_of_overturning_command(*given, "--columns", "time:s north:g east:g") == 1
    out = capsys.readouterr().out
    assert "refused: x.csv: peak acceleration 300 g" in out
    assert "declared in g look like Gal (0.31 g)" in out
    assert exit_status_of_overturning_command(*given, "--columns", "time:s north:gal east:gal") == 0
    assert "declared: columns time:s north:gal east:gal; raw" in capsys.readouterr().out
    assert exit_status_of_overturning_command(*given, "--columns", "time:s north:g east:g", "--trust-data") == 0
    assert "trusted although peak acceleration 300 g" in capsys.readouterr().out


def test_a_columns_file_must_be_declared_raw_or_processed(tmp_path, capsys):
    path = write_time_north_and_east_columns(tmp_path / "x.csv", offset=5.0)
    given = ("records", "check", path, "--columns", "time:s north:gal east:gal")
    assert exit_status_of_overturning_command(*given) == 1
    assert "--processed or --raw" in capsys.readouterr().out
    assert exit_status_of_overturning_command(*given, "--processed") == 0
    out = capsys.readouterr().out
    assert "csv, processed, as declared" in out
    assert "agency" not in out
    assert "as the file is" in out
    assert exit_status_of_overturning_command(*given, "--raw") == 0
    out = capsys.readouterr().out
    # An offset of 5 Gal for 40 s is 40 m of displacement; the default processing takes it away.
    assert "after the default processing (mean removed" in out
    assert float(out.split("PGD ")[1].split(" cm")[0]) < 100


def test_records_check_is_recursive_and_skips_other_files(tmp_path, capsys):
    inside = tmp_path / "a" / "b"
    inside.mkdir(parents=True)
    (inside / "good.V2A").write_text(geonet_text({"N28W": (332, A), "S62W": (242, B)}, 0.02))
    for name in ("study.yaml", "event.json", ".hidden"):
        (tmp_path / "a" / name).write_text("{}")
    assert exit_status_of_overturning_command("records", "check", tmp_path) == 0
    out = capsys.readouterr().out
    assert "geonet, processed by GNS Science" in out
    assert "by the agency: band-pass filter, transition bands .10-.25 Hz and 24.50-25.50 Hz" in out
    assert "skipped because of their names: 3 (.hidden, event.json, study.yaml)" in out
    assert (
        exit_status_of_overturning_command("records", "check", inside / "good.V2A", tmp_path / "a" / "study.yaml") == 0
    )
    assert "1 (study.yaml)" in capsys.readouterr().out
    assert "1 read, 0 refused" in out
    # A name near that of the epicentre does not name the station.
    assert "TEST (-42.6194, 173.0536); earthquake of 2016 November 13 11:02:56 UT (epicentre 5 km south-west" in out
    (tmp_path / "none").mkdir()
    (tmp_path / "none" / "event.json").write_text("{}")
    assert exit_status_of_overturning_command("records", "check", tmp_path / "none") == 1
    assert "1 files, none of them a record" in capsys.readouterr().out


def test_records_plot_draws_a_page_and_prints_corner_frequency_and_reason(tmp_path, capsys):
    path = tmp_path / "good.V1A"
    path.write_text(geonet_text({"N28W": (332, A), "S62W": (242, B)}, 0.02, corrected=False))
    assert (
        exit_status_of_overturning_command("records", "plot", path, "--corner", "auto", "--output", tmp_path / "x.pdf")
        == 0
    )
    out = capsys.readouterr().out
    assert "high-pass 0.1 Hz, order 2 (no noise of 2 s before the onset" in out
    assert (tmp_path / "x.pdf").read_bytes().startswith(b"%PDF")
    # A folder with a file of the same name, processed by its agency, and one that is no record.
    again = tmp_path / "again"
    again.mkdir()
    (again / "good.V1A").write_text(geonet_text({"N28W": (332, A), "S62W": (242, B)}, 0.02))
    (again / "note.json").write_text("{}")
    assert exit_status_of_overturning_command("records", "plot", path, again, "--output", tmp_path / "x.png") == 1
    assert "there are 2 records" in capsys.readouterr().err
    assert (
        exit_status_of_overturning_command(
            "records", "plot", path, again, "--corner", 0.2, "--output", tmp_path / "both"
        )
        == 0
    )
    raw, of_agency = capsys.readouterr().out.split(f"{tmp_path / 'both' / 'good.V1A-2.svg'}: ")
    assert raw.startswith(f"{tmp_path / 'both' / 'good.V1A.svg'}: ")
    for out, no_effect in ((raw, False), (of_agency, True)):
        assert ("--corner has no effect" in out, "high-pass 0.2 Hz" in out) == (no_effect, not no_effect)
    pages = sorted((tmp_path / "both").iterdir())
    assert [page.name for page in pages] == ["good.V1A-2.svg", "good.V1A.svg"]
    assert all(page.read_text().startswith("<?xml") for page in pages)
    assert exit_status_of_overturning_command("records", "plot", path, "--corner", "low") == 1
    assert "--corner: 'low'" in capsys.readouterr().err
    for corner in ("nan", "0", "-1", "inf"):
        assert exit_status_of_overturning_command("records", "plot", path, f"--corner={corner}") == 1
        assert f"--corner: '{corner}'" in capsys.readouterr().err


def test_channels_of_different_lengths_in_one_file_are_cut_to_the_shortest(tmp_path, capsys):
    path = tmp_path / "x.v1"
    path.write_text(csmip_text({"90 Deg": (90, A / 1000), "360 Deg": (360, B[:90] / 1000)}, 20))
    assert exit_status_of_overturning_command("records", "check", path) == 0
    assert (
        "cut to the common 90 samples (chan 1 (90) = 200, chan 2 (360) = 90), 5.5 s left out" in capsys.readouterr().out
    )


def test_overturning_one_accepts_a_declared_file_or_a_pulse_as_its_record(tmp_path, capsys):
    path = write_time_north_and_east_columns(tmp_path / "x.csv")
    given = ("one", "--azimuth", 0, "--b-over-h", 0.2)
    assert (
        exit_status_of_overturning_command(
            *given, "--record", path, "--columns", "time:s north:gal east:gal", "--processed"
        )
        == 0
    )
    assert exit_status_of_overturning_command(*given, "--record", "sine amplitude_gal=800 period_s=1 cycles=1") == 0
    assert "pulse, sine pulse: B/H = 0.2" in capsys.readouterr().out
    assert exit_status_of_overturning_command(*given, "--record", path, "--columns", "time:s north:gal east:gal") == 1
    assert exit_status_of_overturning_command(*given, "--record", path, "--format", "geonet") == 1
    assert exit_status_of_overturning_command(*given, "--record", "rinaldi", "--unit", "g") == 1
    assert "no such file; options that describe a file" in capsys.readouterr().err
    assert exit_status_of_overturning_command(*given, "--record", path, "--sensor", "roof") == 1
    capsys.readouterr()
    for record, what in ((path, "a file"), ("sine amplitude_gal=800 period_s=1", "a pulse")):
        for option in ("--table", "--folder"):
            assert exit_status_of_overturning_command(*given, "--record", record, option, tmp_path) == 1
            assert f"is {what}, not in a record table; leave them out" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("text", "columns", "words"),
    [
        ("0;1,5;2\n", "time:s north:gal east:gal", "'1,5' has decimal commas"),
        ("0,0,1,5,2,5\n", "time:s north:gal east:gal", "decimal commas"),
        ("t,n,e\n0,1,2\n0;1;2\n", "time:s north:gal east:gal", "set off by semicolons here"),
        ("0,1,2\n", "time:s,north:gal,east:gal", "set them off by blanks"),
    ],
)
def test_the_error_names_commas_and_semicolons_in_a_columns_file(tmp_path, capsys, text, columns, words):
    (tmp_path / "x.csv").write_text(text)
    assert (
        exit_status_of_overturning_command("records", "check", tmp_path / "x.csv", "--raw", "--columns", columns) == 1
    )
    assert words in capsys.readouterr().out
