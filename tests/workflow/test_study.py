"""A whole small study: same bytes, resumed after a kill, computed again only where something changed."""

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from overturning.study.cube import open_cube
from tests.workflow.conftest import SMALL, Checkout

# make test keeps the tests of a file in one process: these share a finished study.
pytestmark = pytest.mark.workflow


def bytes_of(results: Path) -> dict[str, bytes]:
    """Everything made but logs, run times and progress."""
    return {
        str(path.relative_to(results)): path.read_bytes()
        for path in sorted(results.rglob("*"))
        if path.is_file() and path.suffix not in {".log", ".csv"} and ".progress" not in path.parts
    }


def test_report_and_cube_name_no_clock_no_host_no_path(finished: Checkout) -> None:
    report = (finished.results / "report.html").read_text(encoding="utf-8")
    with open_cube(finished.results / "cube.nc") as cube:
        text = report + repr(dict(cube.attrs))
    for word in (str(finished.folder), os.uname().nodename + " ", time.strftime("%Y-%m-%d"), time.strftime("%H:%M")):
        assert word not in text, word


def test_timing_has_a_row_per_record(finished: Checkout) -> None:
    lines = (finished.results / "timing.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0].startswith("record,variant,cases,block_steps,wall_s,cpu_s,processor")
    assert [line.split(",")[0] for line in lines[1:]] == ["rinaldi", "petrolia", "all"]


@pytest.mark.parametrize(
    ("change", "again"),
    [
        ("friction=[0.5]", {"sweep", "timing", "gather", "verification", "figures", "explore", "report", "all"}),
        ("amplitude=[1, 2]", {"sweep", "timing", "gather", "verification", "figures", "explore", "report", "all"}),
        (
            "site={layers: [{thickness_m: 20, velocity_m_s: 200}], rock: {velocity_m_s: 760}}",
            {"read", "rotate", "sweep", "timing", "gather", "verification", "figures", "explore", "report", "all"},
        ),
        ("title=Other", {"gather", "verification", "timing", "figures", "explore", "report", "all"}),
        (
            "processing=[{step: remove_mean}]",
            {"read", "rotate", "sweep", "timing", "gather", "verification", "figures", "explore", "report", "all"},
        ),
        ("verification=none", {"gather", "timing", "figures", "explore", "report", "all"}),
        ("surveys=[{stones: config/stones.csv, record: rinaldi}]", {"survey", "backwards", "report", "all"}),
        ("population={stones: 16}", {"fragility", "report", "all"}),
        ("figures={dpi: 100, formats: [svg]}", {"figures", "report", "all"}),
    ],
)
def test_change_of_a_key_runs_only_what_depends_on_it(finished: Checkout, change: str, again: set[str]) -> None:
    (finished.folder / "config" / "stones.csv").write_text("octant\nSE\n", encoding="utf-8")
    assert finished.planned("--config", change) == again


@pytest.fixture(scope="module")
def with_sources(tmp_path_factory: pytest.TempPathFactory, finished: Checkout) -> Checkout:
    """A copy of the finished study with sources of its own, in which a second run has nothing to do."""
    checkout = Checkout(tmp_path_factory.mktemp("sources") / "checkout", own_sources=True)
    shutil.copytree(finished.folder / "results", checkout.folder / "results")
    shutil.copytree(finished.folder / ".snakemake", checkout.folder / ".snakemake")
    done = checkout.run()
    assert "Nothing to be done" in done.stdout + done.stderr
    return checkout


@pytest.mark.parametrize(
    ("module", "again"),
    [
        ("figures/rose.py", {"figures", "report", "all"}),
        ("dem/block/queue.py", {"sweep", "timing", "gather", "verification", "figures", "explore", "report", "all"}),
        ("report/html.py", {"report", "all"}),
    ],
)
def test_change_of_a_source_runs_what_depends_on_it(with_sources: Checkout, module: str, again: set[str]) -> None:
    path = with_sources.folder / "src" / "overturning" / module
    text = path.read_text(encoding="utf-8")
    path.write_text(text + "\n# changed\n", encoding="utf-8")
    try:
        assert with_sources.planned() == again
    finally:
        path.write_text(text, encoding="utf-8")


def test_one_core_killed_in_the_sweep_and_resumed_in_another_folder_ends_in_the_bytes_of_two_cores(
    finished: Checkout, tmp_path: Path
) -> None:
    checkout = Checkout(tmp_path / "elsewhere")
    run = subprocess.Popen(
        checkout.command(cores=1),
        cwd=checkout.folder,
        env=checkout.environment,
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    parts = checkout.results / "sweep" / "nominal"
    deadline = time.monotonic() + 1200
    while not list(parts.glob("*.nc")):
        assert run.poll() is None, "the run ended before its first part"
        assert time.monotonic() < deadline
        time.sleep(0.05)
    os.killpg(run.pid, signal.SIGKILL)
    run.wait()
    assert not (checkout.results / "cube.nc").exists()
    kept = {path: path.stat().st_mtime_ns for path in parts.glob("*.nc")}
    # The part that Snakemake had not yet taken note of is made again; the motions were complete long before.
    motions = {path: path.stat().st_mtime_ns for path in (checkout.results / "motion").glob("*.nc")}
    time.sleep(1.1)
    done = checkout.run(cores=1)
    assert "results/small/cube.nc" in done.stdout
    assert "results/small/report.html" in done.stdout
    assert {path: path.stat().st_mtime_ns for path in motions} == motions
    assert sum(path.stat().st_mtime_ns != before for path, before in kept.items()) <= 1
    one, other = bytes_of(finished.results), bytes_of(checkout.results)
    assert {"cube.nc", "report.html", "intensity.nc", "figures/rose.svg"} <= one.keys() == other.keys()
    assert [name for name in one if one[name] != other[name]] == []


def test_a_second_run_of_either_kind_says_one_sentence(tmp_path: Path) -> None:
    """Also where the first is plain Snakemake, and only its job holds it up."""
    checkout = Checkout(tmp_path / "checkout")
    programs = tmp_path / "bin"
    programs.mkdir()
    (programs / "overturning").write_text("#!/bin/sh\nsleep 60\n", encoding="utf-8")
    (programs / "overturning").chmod(0o755)
    slow = checkout.environment | {"PATH": f"{programs}:{checkout.environment['PATH']}"}
    plain = [sys.executable, "-m", "snakemake", "--cores", "1", "--configfile", "config/mine.yaml"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    first = subprocess.Popen(plain, cwd=checkout.folder, env=slow, start_new_session=True, **quiet)
    lock = checkout.folder / ".snakemake" / "run.lock"
    try:
        deadline = time.monotonic() + 1200
        while not (lock.is_file() and lock.read_text(encoding="utf-8")):
            assert first.poll() is None
            assert time.monotonic() < deadline
            time.sleep(0.1)
        done = checkout.run(check=False)
        other = subprocess.run(
            plain, cwd=checkout.folder, env=checkout.environment, capture_output=True, text=True, check=False
        )
    finally:
        os.killpg(first.pid, signal.SIGKILL)
        first.wait()
    sentence = f"another run works in this folder (process {first.pid}); wait for it, or stop it and run again"
    assert done.returncode == 1
    assert done.stderr.strip() == f"error: {sentence}"
    assert other.returncode != 0
    assert sentence in other.stderr
    assert not checkout.results.exists() or not list(checkout.results.glob("*.nc"))


def test_cube_holds_what_the_config_asked_for(finished: Checkout) -> None:
    with open_cube(finished.results / "cube.nc", chunks={"record": 1}) as cube:
        assert cube["overturned"].chunks is not None
        assert dict(cube.sizes) == {"record": 2, "azimuth": 13, "height": 1, "b_over_h": 2, "friction": 2}
        assert 32 in cube["azimuth"]
        overturned = cube.set_index(record="record_id")["overturned"].sel(b_over_h=0.4, friction=1.0, height=0.6).load()
        # Rinaldi's fault-normal component overturns B/H = 0.4, and at N32E that is all there is.
        assert abs(float(overturned.sel(record="rinaldi", azimuth=32))) == 1
        assert np.isfinite(overturned).all()


def test_settings_too_long_for_a_command_go_through_a_file(tmp_path: Path) -> None:
    """Linux allows a command of a shell 128 KiB."""
    also = [round(0.01 * number, 2) for number in range(1, 18000)]
    small = SMALL.replace("rinaldi, petrolia", "rinaldi").replace("also: [32]", f"also: {also}")
    small = small.replace("[0.2, 0.4]", "[0.4]").replace("[0.33, 1.0]", "[1.0]") + "ensemble: {members: 0}\n"
    checkout = Checkout(tmp_path / "checkout", small + "verification: none\n")
    checkout.run("--", "results/small/cube.nc")
    assert list((checkout.folder / ".snakemake" / "settings").glob("*.yaml"))
    with open_cube(checkout.results / "cube.nc") as cube:
        assert set(also) <= set(cube["azimuth"].to_numpy().tolist())


def test_bad_record_is_named_and_leaves_nothing_half_written(tmp_path: Path) -> None:
    checkout = Checkout(tmp_path / "checkout", SMALL.replace("petrolia", "broken"))
    table = checkout.folder / "config" / "records.tsv"
    header = table.read_text(encoding="utf-8").splitlines()[0].split("\t")
    row = {"id": "broken", "format": "auto", "source": "broken.csv"}
    with table.open("a", encoding="utf-8") as file:
        file.write("\t".join(row.get(name, "") for name in header) + "\n")
    folder = checkout.folder / "resources" / "records"
    folder.mkdir(parents=True)
    (folder / "broken.csv").write_text("this is no record\n", encoding="utf-8")
    done = checkout.run(check=False)
    assert done.returncode != 0
    assert "broken.csv" in done.stdout + done.stderr
    assert "Traceback" not in done.stdout + done.stderr
    assert not checkout.results.exists(), "it is known before anything is computed"


def test_missing_files_of_a_user_stop_the_run_at_once(tmp_path: Path) -> None:
    tottori = (Path(__file__).parents[2] / "config" / "tottori.yaml").read_text(encoding="utf-8")
    checkout = Checkout(tmp_path / "checkout", tottori)
    done = checkout.run(check=False)
    assert done.returncode != 0
    text = done.stdout + done.stderr
    for word in ("TTRH020010061330.NS2", "NIED", "resources/records"):
        assert word in text
    assert "Traceback" not in text
    assert not (checkout.folder / "results" / "tottori" / "motion").exists()


def test_wrong_key_stops_the_run_with_one_line(tmp_path: Path) -> None:
    checkout = Checkout(tmp_path / "checkout", SMALL.replace("friction", "frictoin"))
    done = checkout.run(check=False)
    assert done.returncode != 0
    assert "mine.yaml: frictoin: unknown key; did you mean friction?" in done.stdout + done.stderr
