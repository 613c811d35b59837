"""What `make run` says: in the words of the steps, without Snakemake's talk."""

import fcntl
import subprocess
import sys
from pathlib import Path

import pytest

from tests.workflow.conftest import ROOT, SMALL, Checkout

sys.path.insert(0, str(ROOT / "workflow" / "scripts"))
from run import cubes_kept
from talk import failures, made, steps

pytestmark = pytest.mark.workflow

TALK = """\
Building DAG of jobs...
[Sat Nov 21 23:00:00 2026]
Error in rule sweep:
    message: None
    jobid: 3
    input: results/small/motion/a.nc
    log: {log} (check log file(s) for error details)
    shell:
        overturning sweep --study '{{"name": "small", "azimuth": {{"step": 30}}}}'
        (command exited with non-zero exit code)
3 of 12 steps (25%) done
Error in rule read:
    jobid: 4
    log: {gone} (check log file(s) for error details)
    shell:
        overturning read

4 of 12 steps (33%) done
"""


def test_errors_in_the_words_of_the_steps(tmp_path: Path) -> None:
    log = tmp_path / "sweep.log"
    log.write_text("a: begins\nerror: mine.yaml: key: wrong\n       another line\n", encoding="utf-8")
    talk = TALK.format(log=log, gone=tmp_path / "gone.log")
    found = list(failures(talk))
    assert found[0] == "error: mine.yaml: key: wrong\n       another line"
    assert found[1].startswith("error: the step read failed without a word")
    assert not any("{" in line for line in found)
    assert steps(talk) == (4, 12)
    log.write_text("Traceback (most recent call last):\n  File\nValueError: that\n", encoding="utf-8")
    assert next(failures(talk)) == f"error: ValueError: that (see {log})"


def test_what_stops_a_run_before_it_begins() -> None:
    talk = 'WorkflowError in file "/a/common.smk", line 36:\nrecord p1: x is not there;\n       nor y\n  File "/a/common.smk", line 3\n'
    assert list(failures(talk)) == ["error: record p1: x is not there;\n       nor y"]
    assert steps("") is None


def test_what_was_made() -> None:
    assert made(
        "…\nCube and report of the study 'a':\n  results/a/cube.nc\n  results/a/report.html\nComplete log(s): x\n"
    ) == ("Cube and report of the study 'a':\n  results/a/cube.nc\n  results/a/report.html")
    assert made("x\nNothing to be done (all requested files are present and up to date).\n").startswith(
        "Nothing to be done"
    )


@pytest.fixture(scope="module")
def checkout(tmp_path_factory: pytest.TempPathFactory) -> Checkout:
    return Checkout(tmp_path_factory.mktemp("messages") / "checkout")


def test_a_second_run_is_refused_at_once(checkout: Checkout) -> None:
    lock = checkout.folder / ".snakemake" / "run.lock"
    lock.parent.mkdir(exist_ok=True)
    with lock.open("w") as held:
        held.write("4711")
        held.flush()
        fcntl.flock(held, fcntl.LOCK_EX)
        done = checkout.run(check=False)
    assert done.returncode == 1
    assert done.stderr.strip() == (
        "error: another run works in this folder (process 4711); wait for it, or stop it and run again"
    )


def test_a_study_that_is_not_there(checkout: Checkout) -> None:
    done = checkout.run("--configfile", "config/gone.yaml", check=False)
    assert done.returncode == 1
    assert "error: no study config/gone.yaml; there are " in done.stderr
    assert "config/mine.yaml" in done.stderr
    assert "Traceback" not in done.stderr


def test_a_missing_file_is_named_before_the_run(checkout: Checkout) -> None:
    table = checkout.folder / "config" / "records.tsv"
    with table.open("a", encoding="utf-8") as rows:
        rows.write("mine\tauto\tmine.V2A\n")
    (checkout.folder / "config" / "mine.yaml").write_text(SMALL.replace("rinaldi,", "mine,"), encoding="utf-8")
    done = checkout.run(check=False)
    assert done.returncode == 1
    lines = done.stderr.strip().splitlines()
    assert lines[0] == lines[-1]
    assert lines[0].startswith("error: record mine: mine.V2A is not in resources/records; ")
    assert done.stdout == ""
    folder = checkout.folder / "resources" / "records"
    folder.mkdir(parents=True)
    (folder / "mine.V2A").write_text("no record\n")
    done = checkout.run(check=False)
    assert done.stderr.count("mine.V2A: ") == 2
    assert not (checkout.results / "motion").exists()


def test_another_workflow_uses_it_as_a_module(tmp_path: Path) -> None:
    """As snakedeploy has it: a Snakefile of one's own, a whole study in its config."""
    checkout = Checkout(tmp_path / "module", SMALL.replace("name: small", "name: deployed"))
    (checkout.folder / "config" / "near-fault.yaml").unlink()
    used = checkout.folder / "workflow"
    used.rename(checkout.folder / "used")
    used.mkdir()
    (used / "Snakefile").write_text(
        'configfile: "config/mine.yaml"\n\nmodule overturning:\n    snakefile: "../used/Snakefile"\n    config: config\n\n'
        "use rule * from overturning\n",
        encoding="utf-8",
    )
    command = [sys.executable, "-m", "snakemake", "--dry-run", "--cores", "1", "--quiet", "host"]
    done = subprocess.run(
        command, cwd=checkout.folder, env=checkout.environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "results/deployed/report.html" in done.stdout + done.stderr


def test_a_step_that_fails_is_told_first_and_last_without_its_command(tmp_path: Path) -> None:
    checkout = Checkout(tmp_path / "failing", SMALL.replace("rinaldi, petrolia", "rinaldi"))
    programs = tmp_path / "bin"
    programs.mkdir()
    (programs / "overturning").write_text(
        "#!/bin/sh\necho 'error: motion.nc: broken; mend it' >&2\nexit 1\n", encoding="utf-8"
    )
    (programs / "overturning").chmod(0o755)
    checkout.environment["PATH"] = f"{programs}:{checkout.environment['PATH']}"
    done = checkout.run(check=False)
    assert done.returncode == 1
    lines = done.stderr.strip().splitlines()
    assert lines[0] == lines[-1] == "error: motion.nc: broken; mend it"
    assert "run.log" in lines[1]
    assert len(done.stdout + done.stderr) < 500
    assert "Error in rule read" in (checkout.folder / ".snakemake" / "run.log").read_text(encoding="utf-8")
    plain = [sys.executable, "-m", "snakemake", "--cores", "1", "--configfile", "config/mine.yaml"]
    done = subprocess.run(
        plain, cwd=checkout.folder, env=checkout.environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert "error: motion.nc: broken; mend it" in done.stderr.strip().splitlines()[-6:]


def test_a_failed_run_does_not_cost_the_cube(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    cubes = [tmp_path / "results" / "mine" / name for name in ("cube.nc", "cube.other.nc")]
    cubes[0].parent.mkdir(parents=True)
    for cube in cubes:
        cube.write_text("earlier", encoding="utf-8")
    with cubes_kept():
        cubes[0].unlink()  # as Snakemake does before the step that fails
        cubes[1].unlink()
        cubes[1].write_text("new", encoding="utf-8")
    assert [cube.read_text(encoding="utf-8") for cube in cubes] == ["earlier", "new"]
    assert cubes[0].stat().st_mtime == 0, "the next run makes it again"
    assert cubes[1].stat().st_mtime > 0
    with cubes_kept():
        pass
    assert sorted(path.name for path in cubes[0].parent.iterdir()) == ["cube.nc", "cube.other.nc"]
