"""Messages of a run, by the logger plugin of the default profile."""

import fcntl
import logging
import os
import re
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from snakemake_interface_common.exceptions import WorkflowError
from snakemake_interface_logger_plugins.common import LogEvent
from snakemake_interface_logger_plugins.tests import TestLogHandlerBase

from overturning.study.load import load_study
from snakemake_logger_plugin_overturning import LogHandler
from tests.records.record_writers import geonet_text
from tests.workflow.conftest import SMALL_STUDY, StudyWorkflowCopyWithPlanning
from verification.tables import ROOT

pytestmark = pytest.mark.workflow


class TestLoggerPluginInterface(TestLogHandlerBase):
    """Tests that Snakemake provides for logger plugins, applied to the plugin of this project."""

    __test__ = True

    def get_log_handler_cls(self) -> type[LogHandler]:
        return LogHandler

    def get_log_handler_settings(self) -> Any:
        return None

    @pytest.fixture(autouse=True)
    def close_log_handlers(self) -> Iterator[None]:
        """Close the log handler after each test, so that it prints no progress into the next one."""
        self.made: list[Any] = []
        yield
        for handler in self.made:
            handler.close()

    def _create_handler(self) -> Any:
        self.made.append(super()._create_handler())
        return self.made[-1]


def create_log_handler(verbose: bool) -> LogHandler:
    """Return a log handler of the workflow with the given verbosity."""
    about = {"verbose": verbose, "dryrun": False, "stdout": False, "nocolor": True, "quiet": (), "debug_dag": False}
    return LogHandler(SimpleNamespace(**about, show_failed_logs=False, printshellcmds=False), None)


@pytest.fixture
def log_handler(monkeypatch: pytest.MonkeyPatch) -> LogHandler:
    """A log handler of a run with default verbosity."""
    monkeypatch.setattr(sys, "argv", ["snakemake", "--cores", "2"])
    return create_log_handler(verbose=False)


def emit_event(handler: LogHandler, text: str = "", level: int = logging.INFO, **about: Any) -> None:
    """Send an event of Snakemake to the log handler."""
    record = logging.LogRecord("snakemake", level, "", 1, text, (), None)
    vars(record).update(about)
    handler.emit(record)


@pytest.mark.parametrize("exists_before", [False, True])
def test_the_first_new_polar_map_is_announced_once(
    log_handler: LogHandler, tmp_path: Path, capsys: pytest.CaptureFixture[str], exists_before: bool
) -> None:
    figure = tmp_path / "rinaldi.svg"
    if exists_before:
        figure.touch()
    emit_event(log_handler, expected_s={"sweep": 4.0}, first_figure=str(figure))
    emit_event(log_handler, event=LogEvent.JOB_FINISHED, job_id=1)
    assert capsys.readouterr().err == ""
    figure.touch()
    for job_id in (2, 3):
        emit_event(log_handler, event=LogEvent.JOB_FINISHED, job_id=job_id)
    assert capsys.readouterr().err == ("" if exists_before else f"First polar map: {figure}\n")


def test_error_of_a_failed_step_is_printed_once_without_traceback(
    log_handler: LogHandler, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    emit_event(log_handler, event=LogEvent.RUN_INFO, stats={"sweep": 2, "read": 1, "total": 3})
    log = tmp_path / "sweep.log"
    about = {"event": LogEvent.JOB_ERROR, "level": logging.ERROR, "jobid": 3, "shellcmd": "overturning sweep {json}"}
    log.write_text("12%\nerror: mine.yaml: key: wrong\n       another line\nmore\n", encoding="utf-8")
    for _ in range(2):  # each once
        emit_event(log_handler, "Error in rule sweep", rule_name="sweep", log=[str(log)], **about)
    first = "error: mine.yaml: key: wrong\n       another line\n"
    assert capsys.readouterr().err == first
    log.write_text("Traceback (most recent call last):\n  File\nValueError: that\n", encoding="utf-8")
    emit_event(log_handler, rule_name="sweep", log=[str(log)], **about)
    second = f"error: ValueError: that (see {log})\n"
    assert capsys.readouterr().err == second
    emit_event(log_handler, rule_name="read", log=["gone.log"], **about)
    third = "error: the step read failed without a message; see gone.log\n"
    assert capsys.readouterr().err == third
    empty = tmp_path / "empty.log"
    empty.touch()
    monkeypatch.setattr("shutil.disk_usage", lambda _: SimpleNamespace(free=44_000))
    emit_event(log_handler, rule_name="gather", log=[str(empty)], **about)
    fourth = capsys.readouterr().err
    assert fourth.startswith(f"error: {empty}: no space left on device; free some space")
    emit_event(
        log_handler, "WorkflowError:\nAt least one job did not complete successfully.", logging.ERROR, event="error"
    )
    log_handler.close()
    said = capsys.readouterr().err.splitlines(keepends=True)
    assert said[0].startswith("The run failed; all messages of Snakemake are in .snakemake/log; ")
    assert "".join(said[1:]) == first + second + third + fourth, "last, where it is seen"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            'WorkflowError in file "/a/common.smk", line 36:\nrecord p1: x is not there;\n       nor y\n'
            '  File "/a/c.smk", line 3',
            "error: record p1: x is not there;\n       nor y\n",
        ),
        ("WorkflowError:\nNo rule makes that.", "error: No rule makes that.\n"),
        ("Traceback (most recent call last):\n  File x\nOSError: that\n", "error: that\n"),
        ("FileNotFoundError: [Errno 2] No such file: 'x.csv'", "error: [Errno 2] No such file: 'x.csv'\n"),
        (
            "Traceback (most recent call last):\nFileNotFoundError: [Errno 2] No such file: 'config/gone.yaml'",
            "error: no study config/gone.yaml; existing studies: config/mine.yaml\n",
        ),
        *(
            (
                f"Traceback (most recent call last):\n{kind}: [Errno 13] {reason}: '{path}'",
                f"error: {path}: {reason}; Snakemake needs the cache folder /.cache/snakemake: set HOME or "
                "XDG_CACHE_HOME to a folder that can be written\n",
            )
            for kind, reason, path in (
                ("PermissionError", "Permission denied", "/.cache"),
                ("OSError", "Read-only file system", "/.cache/snakemake/snakemake/source-cache"),
            )
        ),
        (
            "Traceback (most recent call last):\nPermissionError: [Errno 13] Permission denied: '/.cached'",
            "error: [Errno 13] Permission denied: '/.cached'\n",
        ),
    ],
)
def test_errors_found_before_a_run_are_printed_in_plain_words(
    log_handler: LogHandler,
    text: str,
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (tmp_path / "config").mkdir()
    (tmp_path / "config" / "mine.yaml").touch()
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", "/.cache")  # as HOME=/ in a container
    emit_event(log_handler, text, logging.ERROR, event=LogEvent.ERROR)
    log_handler.close()
    assert capsys.readouterr().err == said


def test_a_run_prints_results_and_warnings_but_no_progress(
    log_handler: LogHandler, capsys: pytest.CaptureFixture[str]
) -> None:
    for text in ("Building DAG of jobs...", "Select jobs to execute...", "Complete log(s): x"):
        emit_event(log_handler, text)
    emit_event(log_handler, "sweep 7", event=LogEvent.JOB_FINISHED, job_id=7)
    emit_event(log_handler, "a\n  b", result=True)
    emit_event(log_handler, "Nothing to be done (all requested files are present and up to date).")
    emit_event(log_handler, "damaged: x", logging.WARNING)
    out, err = capsys.readouterr()
    assert out == "a\n  b\nNothing to be done (all requested files are present and up to date).\n"
    assert err == "damaged: x\n"


def test_an_interrupted_run_reports_no_failures(log_handler: LogHandler, capsys: pytest.CaptureFixture[str]) -> None:
    emit_event(log_handler, event=LogEvent.RUN_INFO, stats={"sweep": 2, "total": 2})
    emit_event(log_handler, "Terminating processes on user request, this might take some time.")
    emit_event(
        log_handler, "Error in rule sweep", logging.ERROR, event=LogEvent.JOB_ERROR, rule_name="sweep", log=[], jobid=3
    )
    log_handler.close()
    assert capsys.readouterr().err == ("Stopped; finished results are kept, and the same command resumes the run.\n")


def test_a_verbose_run_shows_the_output_of_snakemake(capsys: pytest.CaptureFixture[str]) -> None:
    emit_event(create_log_handler(verbose=True), "Building DAG of jobs...")
    assert capsys.readouterr().err == "Building DAG of jobs...\n"


@pytest.fixture(scope="module")
def checkout_with_small_study(tmp_path_factory: pytest.TempPathFactory) -> StudyWorkflowCopyWithPlanning:
    """A copy of the workflow with the small study."""
    return StudyWorkflowCopyWithPlanning(tmp_path_factory.mktemp("messages") / "checkout")


def test_a_second_concurrent_run_in_a_folder_is_refused(
    checkout_with_small_study: StudyWorkflowCopyWithPlanning,
) -> None:
    lock = checkout_with_small_study.folder / ".snakemake" / "run.lock"
    lock.parent.mkdir(exist_ok=True)
    with lock.open("w") as held:
        held.write("4711")
        held.flush()
        fcntl.flock(held, fcntl.LOCK_EX)
        with pytest.raises(WorkflowError, match=r"another run works in this folder \(process 4711\); wait for it, or"):
            checkout_with_small_study.plan(dry_run=False)
        assert "sweep" in checkout_with_small_study.planned_rules(), "who only looks is not in the way"


def test_a_missing_record_file_is_named_before_the_run(tmp_path: Path) -> None:
    checkout = StudyWorkflowCopyWithPlanning(tmp_path / "checkout", SMALL_STUDY.replace("rinaldi,", "mine,"))
    with (checkout.folder / "config" / "records.tsv").open("a", encoding="utf-8") as rows:
        rows.write("mine\tauto\tmine.V2A\n")
    with pytest.raises(WorkflowError, match=r"record mine: mine\.V2A is not in resources/records; "):
        checkout.planned_rules()
    folder = checkout.folder / "resources" / "records"
    folder.mkdir(parents=True)
    (folder / "mine.V2A").write_text("no record\n")
    with pytest.raises(WorkflowError, match=r"mine\.V2A: "):
        checkout.planned_rules()
    assert not checkout.results.exists(), "it is known before anything is computed"


@pytest.mark.long
def test_a_replaced_record_file_is_read_again_even_if_it_is_older(tmp_path: Path) -> None:
    checkout = StudyWorkflowCopyWithPlanning(tmp_path / "checkout", SMALL_STUDY.replace("rinaldi, petrolia", "mine"))
    with (checkout.folder / "config" / "records.tsv").open("a", encoding="utf-8") as rows:
        rows.write("mine\tauto\tmine.V2A\n")
    file = checkout.folder / "resources" / "records" / "mine.V2A"
    file.parent.mkdir(parents=True)
    samples = 100 * np.sin(np.arange(400) / 5)
    for factor, date in ((1, 2e9), (2, 1e9)):
        axes = {"N28W": (332, factor * samples), "S62W": (242, factor * samples)}
        file.write_text(geonet_text(axes, 0.02), encoding="utf-8")
        os.utime(file, (min(date, time.time()),) * 2)
        assert "read" in checkout.planned_rules()
        assert checkout.run(result_file_name="motion/mine.nc").returncode == 0
        assert "read" not in checkout.planned_rules()


def test_missing_record_files_are_named_with_the_expected_folder(tmp_path: Path) -> None:
    checkout = StudyWorkflowCopyWithPlanning(
        tmp_path / "checkout", (ROOT / "config" / "tottori.yaml").read_text(encoding="utf-8")
    )
    with pytest.raises(WorkflowError, match=r"(?s)TTRH020010061330\.NS2.*resources/records.*NIED"):
        checkout.planned_rules()


@pytest.mark.parametrize("key", ["site", "variants"])
def test_a_missing_soil_package_is_named_before_anything_runs(
    checkout_with_small_study: StudyWorkflowCopyWithPlanning, monkeypatch: pytest.MonkeyPatch, key: str
) -> None:
    """None in sys.modules makes the import fail, as if pystrata were not installed."""
    monkeypatch.setitem(sys.modules, "pystrata", None)
    site = {"layers": [{"thickness_m": 20, "velocity_m_s": 200}], "rock": {"velocity_m_s": 760}}
    with pytest.raises(WorkflowError, match=r"study\.yaml: .*site: soil layers need pystrata.*pip install"):
        checkout_with_small_study.planned_rules(**{key: site if key == "site" else {"soft": {"site": site}}})
    assert not checkout_with_small_study.results.exists()


def test_a_wrong_study_key_is_named_before_a_run(checkout_with_small_study: StudyWorkflowCopyWithPlanning) -> None:
    with pytest.raises(WorkflowError, match=r"study\.yaml: frictoin: unknown key; did you mean friction\?"):
        checkout_with_small_study.planned_rules(frictoin=[1.0])


def test_a_duplicate_study_key_is_named_before_a_run(tmp_path: Path) -> None:
    checkout = StudyWorkflowCopyWithPlanning(tmp_path / "twice", SMALL_STUDY + "friction: [0.5]\n")
    with pytest.raises(WorkflowError, match=r"study\.yaml, line 9: friction is given twice; keep one"):
        checkout.planned_rules()


def test_each_workflow_step_gets_a_valid_study_of_a_scanned_body(tmp_path: Path) -> None:
    """Every workflow step, that of the ensemble included, gets a valid study of a scanned body.

    Regression: the step of the ensemble got the key `relief` without the key `body` that it refers to, and was
    refused.
    """
    corners = [
        [a * x, a * y, z] for a, z in ((0.05, 0.0), (0.07, 0.003), (0.07, 0.8)) for x in (-1, 1) for y in (-1, 1)
    ]
    scan = "{volume: 0.015, tilt: 1.5, centre_of_mass: [0, 0, 0.4], inertia: [0.055, 0.055, 0.003, 0, 0, 0]}"
    checkout = StudyWorkflowCopyWithPlanning(
        tmp_path / "scan",
        "name: scan\nrecords: {use: [rinaldi]}\norientation: {step: 90}\n"
        f"body: {{vertices: {corners}, relief: 0.002, scan: {scan}}}\n"
        "ensemble: {members: 8, relief: {low: 0.001, high: 0.005}, where: everywhere}\n",
    )
    assert {"members", "sweep", "report"} <= checkout.planned_rules()


def test_figure_jobs_get_only_their_own_pulse_motions(tmp_path: Path) -> None:
    pulses = ", ".join(f"p{n}: sine amplitude_gal={n}00 period_s=1" for n in range(1, 10))
    published = "published: [{record: rinaldi, azimuth: 32, b_over_h: 0.4, overturns: true}]\n"
    checkout = StudyWorkflowCopyWithPlanning(
        tmp_path / "pulses",
        SMALL_STUDY.replace("use: [rinaldi, petrolia]", f"use: [rinaldi], pulses: {{{pulses}}}") + published,
    )
    commands = [command for command in checkout.plan().commands if "record-figures" in command]
    used = [re.search(r'"use": \[(.*?)\]', command) for command in commands]
    batches = ['"p4", "p5", "p6", "p7"', '"p8", "p9"', '"rinaldi", "p1", "p2", "p3"']
    assert sorted(found[1] for found in used if found) == batches


def test_keys_of_the_command_line_replace_those_of_the_default_study(tmp_path: Path) -> None:
    checkout, stones = (
        StudyWorkflowCopyWithPlanning(tmp_path / "keys"),
        {"shifted": 0.02, "period": [1.0]},
    )  # which in space alone are told
    keys = {"records": {"use": ["rinaldi"]}, "body": {}, "population": stones, "figures": {"friction": 1.0}}
    plan = checkout.plan(file=None, name="mine", **keys)
    (sweep,) = (command for command in plan.commands if "overturning sweep" in command)
    assert "results/mine/" in sweep
    values = list(load_study(ROOT / "config" / "near-fault.yaml").b_over_h)
    assert f'"b_over_h": {values}' in sweep, "of near-fault.yaml"
    (figures,) = (command for command in plan.commands if command.startswith("overturning figures"))
    assert '"height": 0.6, "friction": 1.0' in figures, "below the key that is named"


def test_the_error_for_a_missing_default_study_names_the_option_for_another(tmp_path: Path) -> None:
    checkout = StudyWorkflowCopyWithPlanning(tmp_path / "none")
    (checkout.folder / "config" / "near-fault.yaml").unlink()
    with pytest.raises(WorkflowError, match=r"cannot be read .*; name a study file with --configfile"):
        checkout.plan(file=None)


def test_another_snakemake_workflow_can_use_this_one_as_a_module(tmp_path: Path) -> None:
    """Another workflow with its own Snakefile and a whole study as configuration can use this one as a module.

    Workflows deployed by snakedeploy have this form.
    """
    checkout = StudyWorkflowCopyWithPlanning(tmp_path / "module", SMALL_STUDY.replace("name: small", "name: deployed"))
    (checkout.folder / "config" / "near-fault.yaml").unlink()
    (checkout.folder / "Snakefile").rename(checkout.folder / "used.smk")
    (checkout.folder / "Snakefile").write_text(
        'configfile: "study.yaml"\n\nmodule overturning:\n    snakefile: "used.smk"\n    config: config\n\n'
        "use rule * from overturning\n",
        encoding="utf-8",
    )
    assert {"sweep", "report"} <= checkout.planned_rules()


def test_a_failed_step_is_reported_when_it_fails_and_at_the_end(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    checkout = StudyWorkflowCopyWithPlanning(tmp_path / "failing", SMALL_STUDY.replace("rinaldi, petrolia", "rinaldi"))
    programs = tmp_path / "bin"
    programs.mkdir()
    (programs / "overturning").write_text(
        "#!/bin/sh\necho 'error: motion.nc: broken; mend it' >&2\nexit 1\n", encoding="utf-8"
    )
    (programs / "overturning").chmod(0o755)
    how = checkout.subprocess_arguments_of_snakemake_run()
    how["env"] |= {"PATH": f"{programs}:{how['env']['PATH']}"}
    monkeypatch.setattr(checkout, "subprocess_arguments_of_snakemake_run", lambda *_, **__: how)
    done = checkout.run()
    assert done.returncode == 1
    assert done.stdout == ""
    lines = done.stderr.splitlines()
    assert lines[0] == lines[-1] == "error: motion.nc: broken; mend it"
    assert ".snakemake/log" in lines[1]
    assert len(lines) == 3
    (log,) = (checkout.folder / ".snakemake" / "log").iterdir()
    assert "Error in rule read" in log.read_text(encoding="utf-8")
