"""`overturning records` as a user calls it."""

import numpy as np
import pytest
from record_writers import geonet_text, peer_text

from overturning.cli import main

A, B = (np.round(np.random.default_rng(k).normal(0, 50, 200), 1) for k in (1, 2))


def run(*arguments: object) -> int:
    try:
        main([str(a) for a in arguments])
    except SystemExit as end:
        return int(end.code or 0)
    return 0


def test_check_reads_what_can_be_read_and_says_why_for_the_rest(tmp_path, capsys):
    (tmp_path / "good.V2A").write_text(geonet_text({"N28W": (332, A), "S62W": (242, B)}, 0.02))
    (tmp_path / "bad.V2A").write_text(geonet_text({"N28W": (332, A), "S62W": (242, B)}, 0.02)[:3000])
    (tmp_path / "notes.txt").write_text("my notes")
    assert run("records", "check", tmp_path / "good.V2A") == 0
    out = capsys.readouterr().out
    for word in ("good.V2A", "N28W: azimuth 332", "S62W: azimuth 242", "header", "1 read, 0 refused"):
        assert word in out
    assert run("records", "check", tmp_path) == 1
    out = capsys.readouterr().out
    assert "bad.V2A\n  refused: bad.V2A line" in out
    assert "notes.txt\n  refused: notes.txt: the format is not recognised" in out
    assert "1 read, 2 refused" in out


def test_check_takes_what_the_files_do_not_say(tmp_path, capsys):
    paths = [tmp_path / "x1.AT2", tmp_path / "x2.AT2"]
    for path, samples, axis in zip(paths, (A, B), ("H1", "H2"), strict=True):
        path.write_text(peer_text(samples / 1000, 0.01, axis))
    assert run("records", "check", *paths) == 1
    assert run("records", "check", "--azimuths", "60,330", *paths) == 0
    assert run("records", "check", "--azimuths", "60;330", *paths) == 1
    assert "--azimuths" in capsys.readouterr().err
    table = tmp_path / "x.csv"
    table.write_text("".join(f"{a},{b}\n" for a, b in zip(A, B, strict=True)))
    assert run("records", "check", "--columns", "north:gal east:gal", "--interval", 0.01, "--raw", table) == 0
    assert run("records", "check", "--unit", "feet", table) == 1
    assert "known are" in capsys.readouterr().err


def test_check_goes_on_at_a_wrong_peak_only_on_trust(tmp_path, capsys):
    path = tmp_path / "x.V2A"
    text = geonet_text({"N28W": (332, A), "S62W": (242, B)}, 0.02)
    first = text.splitlines()[13]
    path.write_text(text.replace(first, first.replace(f"{A[np.abs(A).argmax()]:8.1f}", "   999.9")))
    assert run("records", "check", path) == 1
    assert "line 14" in capsys.readouterr().out
    assert run("records", "check", "--trust-data", path) == 0


@pytest.mark.parametrize(
    "arguments",
    [["fetch", "url", "ftp://x", "--sha256", "0" * 64], ["fetch", "fdsn", "x", "--network", "X", "--station", "Y"]],
)
def test_fetch_says_what_is_wrong_in_one_line(arguments, capsys, tmp_path):
    assert run("records", *arguments, "--folder", tmp_path) == 1
    assert capsys.readouterr().err.startswith("error: ")
