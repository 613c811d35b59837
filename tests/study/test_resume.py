"""Resuming an earlier run: lock, damaged files and file times."""

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from overturning.errors import ResultError
from overturning.files import atomic_write, checksum_at_end_matches
from overturning.records.record import Record
from overturning.records.store import read_record_from_motion_file, write_record_to_motion_file
from overturning.settings import EnsembleSettings
from overturning.study.ensemble_members import EnsembleParameterChanges, draw_parameter_changes_of_members
from overturning.study.resume import (
    back_up_cubes,
    lock_results_folder_or_refuse,
    remove_damaged_results_and_fix_future_times,
    remove_files_of_dropped_records,
    restore_deleted_cubes_from_backups,
)


def write_motion_file(path: Path) -> Path:
    """Write a motion file of a short sine and return its path."""
    samples = np.sin(np.arange(50.0))
    write_record_to_motion_file(Record(path.stem, samples, samples, None, 0.01), path)
    return path


def test_a_change_of_any_byte_of_a_motion_file_is_detected(tmp_path: Path) -> None:
    path = write_motion_file(tmp_path / "a.nc")
    content = path.read_bytes()
    assert checksum_at_end_matches(path)
    assert read_record_from_motion_file(path).north.size == 50
    for place in range(0, len(content), len(content) // 97):
        path.write_bytes(content[:place] + bytes([content[place] ^ 1]) + content[place + 1 :])
        assert not checksum_at_end_matches(path), place
        with pytest.raises(ResultError, match=r"a\.nc: damaged"):
            read_record_from_motion_file(path)
    for length in (0, 1, len(content) // 2, len(content) - 1):
        path.write_bytes(content[:length])
        assert not checksum_at_end_matches(path)
    assert checksum_at_end_matches(tmp_path / "none.nc") is None


def test_an_edited_table_of_ensemble_members_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "members.csv"
    drawn = draw_parameter_changes_of_members(EnsembleSettings(members=16))
    drawn.write_csv(path)
    np.testing.assert_array_equal(EnsembleParameterChanges.read_csv(path).friction_factor, drawn.friction_factor)
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("1.", "2.", 1), encoding="utf-8")
    with pytest.raises(ResultError, match="damaged"):
        EnsembleParameterChanges.read_csv(path)


def test_resuming_removes_only_damaged_and_incomplete_files(tmp_path: Path) -> None:
    kept = [write_motion_file(tmp_path / "motion" / "a.nc"), write_motion_file(tmp_path / "cube.nc")]
    cut = write_motion_file(tmp_path / "sweep" / "nominal" / "a.nc")
    emptied = write_motion_file(tmp_path / "motion" / "b.nc")
    cut.write_bytes(cut.read_bytes()[:-200])
    emptied.write_bytes(b"")
    (tmp_path / ".a.nc.x.part").write_bytes(b"half")
    (tmp_path / "convergence.json").write_text("{", encoding="utf-8")
    assert set(remove_damaged_results_and_fix_future_times(tmp_path)) == {cut, emptied, tmp_path / "convergence.json"}
    left = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file()}
    assert left == {"motion/a.nc", "cube.nc"}
    assert all(map(checksum_at_end_matches, kept))
    assert remove_damaged_results_and_fix_future_times(tmp_path) == []
    assert remove_damaged_results_and_fix_future_times(tmp_path / "none") == []


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("figures/polar/rinaldi.svg", b"<svg>\n</svg>\n"),
        ("figures/rose.pdf", b"%PDF-1.4\n%%EOF\n"),
        ("figures/rose.png", b"\x89PNG\x00\x00\x00\x00IEND\xaeB`\x82"),
        ("report.html", b"<!DOCTYPE html>\n</html>\n"),
        ("explore-records/0.js", b"explorerRecord(0,{});\n"),
        ("findings.json", b'{"study": {}}\n'),
        ("fragility/fragility-pga.xml", b"<nrml>\n</nrml>\n"),
    ],
)
def test_resuming_removes_a_truncated_file(tmp_path: Path, name: str, content: bytes) -> None:
    path = tmp_path / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
    assert remove_damaged_results_and_fix_future_times(tmp_path) == []
    for length in (0, 1, len(content) - 3):
        path.write_bytes(content[:length])
        assert remove_damaged_results_and_fix_future_times(tmp_path) == [path], length
        assert not path.exists()


def test_resuming_does_not_remove_an_unfinished_file_of_the_user(tmp_path: Path) -> None:
    (tmp_path / "figures").mkdir()
    for name in ("figures/for-a-paper.svg", "figures/notes.json", "notes.html"):
        (tmp_path / name).write_text("not finished", encoding="utf-8")
    assert remove_damaged_results_and_fix_future_times(tmp_path) == []


def test_resuming_removes_only_files_of_records_dropped_from_the_study(tmp_path: Path) -> None:
    """Files that a run wrote for a dropped record are removed; the user's files and those outside the results stay."""
    results, outside = tmp_path / "results" / "mine", tmp_path / "elsewhere"
    of_record = (
        *("read/{}.nc", "read/soft/{}.nc", "motion/{}.nc", "motion/soft/{}.nc"),
        *("sweep/nominal/{}.1-of-2.nc", "sweep/soft/{}.2-of-2.nc"),
    )
    drawn = ("figures/polar/{}.svg", "figures/blocks/{}.pdf", "figures/intensity/{}.png")
    notes = ("logs/read/{}.log", "logs/sweep/nominal/{}.1-of-2.log", "benchmarks/sweep/nominal/{}.1-of-2.tsv")
    samples = np.sin(np.arange(50.0))
    for name in ("kept", "gone"):
        for pattern in of_record:
            write_record_to_motion_file(Record(name, samples, samples, None, 0.01), results / pattern.format(name))
        for pattern in (*drawn, *notes):
            path = results / pattern.format(name)
            path.parent.mkdir(parents=True, exist_ok=True)
            path.touch()
    own = ["figures/polar/gone-2.svg", "figures/polar/mine.svg", "motion/notes.txt", "gone.csv", "cube.nc"]
    for name in own:
        (results / name).touch()
    write_motion_file(results / "motion" / "renamed.nc").rename(results / "motion" / "other.nc")
    write_record_to_motion_file(Record("gone", samples, samples, None, 0.01), outside / "gone.nc")
    (results / "motion" / "linked").symlink_to(outside)
    assert remove_files_of_dropped_records(results, ["kept"]) == {"gone": len((*of_record, *drawn, *notes))}
    left = {path.relative_to(results).as_posix() for path in results.rglob("*") if path.is_file()}
    expected = {pattern.format("kept") for pattern in (*of_record, *drawn, *notes)} | {*own, "motion/other.nc"}
    assert left - {"motion/linked/gone.nc"} == expected
    assert (outside / "gone.nc").is_file()
    assert remove_files_of_dropped_records(results, ["kept"]) == {}
    assert remove_files_of_dropped_records(tmp_path / "none", ["kept"]) == {}


def test_a_deleted_figure_makes_its_workflow_rule_run_again(tmp_path: Path) -> None:
    figures = tmp_path / "figures"
    (figures / "illustrative").mkdir(parents=True)
    for name in ("1-response.svg", "illustrative.json"):
        (figures / "illustrative" / name).write_text("<svg></svg>" if name.endswith("svg") else "[]", encoding="utf-8")
    (figures / "illustrative.txt").write_text(
        "illustrative/1-response.svg\nillustrative/illustrative.json\n", encoding="utf-8"
    )
    assert remove_damaged_results_and_fix_future_times(tmp_path) == []
    (figures / "illustrative" / "1-response.svg").unlink()
    assert remove_damaged_results_and_fix_future_times(tmp_path) == [figures / "illustrative" / "1-response.svg"]
    assert not (figures / "illustrative.txt").exists(), "an output of the rule, which is made again then"


def test_a_failed_run_restores_only_the_cubes_it_has_not_made_again(tmp_path: Path) -> None:
    cubes = [tmp_path / name for name in ("cube.nc", "cube.other.nc", "cube.third.nc")]
    for cube in cubes:
        cube.write_text("earlier", encoding="utf-8")
    back_up_cubes(tmp_path)
    cubes[0].unlink()  # as Snakemake does before the step that fails
    cubes[1].unlink()
    cubes[1].write_text("new", encoding="utf-8")
    restore_deleted_cubes_from_backups(tmp_path)
    assert [cube.read_text(encoding="utf-8") for cube in cubes] == ["earlier", "new", "earlier"]
    assert cubes[0].stat().st_mtime == 0, "the next run makes it again"
    assert min(cube.stat().st_mtime for cube in cubes[1:]) > 0
    back_up_cubes(tmp_path)
    restore_deleted_cubes_from_backups(tmp_path)
    assert sorted(tmp_path.iterdir()) == cubes


def test_future_modification_times_become_past_in_same_order(tmp_path: Path) -> None:
    now = time.time()
    paths = [write_motion_file(tmp_path / f"{name}.nc") for name in "abcd"]
    for path, moment in zip(paths, (now - 100, now + 7200, now + 3600, now + 3601), strict=True):
        os.utime(path, (moment, moment))
    assert remove_damaged_results_and_fix_future_times(tmp_path) == []
    after = [path.stat().st_mtime for path in paths]
    assert after[0] == pytest.approx(now - 100, abs=1e-3)
    assert after[0] < after[2] < after[3] < after[1] <= time.time()


def test_the_folder_lock_is_released_when_its_process_ends(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "hidden" / "run.lock"
    code = (
        "import sys, time\nfrom pathlib import Path\n"
        "from overturning.study.resume import lock_results_folder_or_refuse\n"
        "lock_results_folder_or_refuse(Path(sys.argv[1]))\nprint('holds', flush=True)\ntime.sleep(60)\n"
    )
    other = subprocess.Popen([sys.executable, "-c", code, str(file)], stdout=subprocess.PIPE, text=True, cwd=tmp_path)
    assert other.stdout is not None
    assert other.stdout.readline() == "holds\n"
    with pytest.raises(ResultError, match=rf"another run works in this folder \(process {other.pid}\)"):
        lock_results_folder_or_refuse(file)
    other.kill()
    other.communicate()
    descriptor = lock_results_folder_or_refuse(file)
    assert descriptor is not None
    assert file.read_text(encoding="utf-8") == str(os.getpid())
    os.close(descriptor)


def test_a_new_run_waits_for_a_running_step_of_a_killed_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "overturning").write_text("import time\ntime.sleep(1)\n", encoding="utf-8")
    step = subprocess.Popen(
        [sys.executable, str(tmp_path / "overturning"), "sweep", "--output", "results/a/sweep/b.nc"]
    )
    while Path(f"/proc/{step.pid}/cmdline").read_bytes().split(b"\0")[0] != sys.executable.encode():
        time.sleep(0.01)
    descriptor = lock_results_folder_or_refuse(tmp_path / "run.lock")
    assert descriptor is not None
    os.close(descriptor)
    assert step.poll() is not None or step.wait(1) == 0
    assert capsys.readouterr().err == f"A step of a killed run is still at work (process {step.pid}); waiting for it.\n"


def test_a_new_run_does_not_wait_for_a_command_that_only_reads_results(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "overturning").write_text("import time\nprint(1, flush=True)\ntime.sleep(60)\n", encoding="utf-8")
    reads = subprocess.Popen(
        [sys.executable, str(tmp_path / "overturning"), "survey", "a.csv", "--cube", "results/a/cube.nc"],
        stdout=subprocess.PIPE,
    )
    assert reads.stdout is not None
    assert reads.stdout.readline() == b"1\n"
    waited_for: list[int] = []
    monkeypatch.setattr("psutil.Process.wait", lambda process: waited_for.append(process.pid))
    descriptor = lock_results_folder_or_refuse(tmp_path / "run.lock")
    assert descriptor is not None
    os.close(descriptor)
    reads.kill()
    reads.communicate()
    assert waited_for == []


def test_no_checksum_is_appended_to_a_csv_file(tmp_path: Path) -> None:
    with atomic_write(tmp_path / "a.csv") as part:
        part.write_text("a\n", encoding="utf-8")
    assert (tmp_path / "a.csv").read_text(encoding="utf-8") == "a\n"
