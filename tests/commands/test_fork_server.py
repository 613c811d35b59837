"""Steps in the fork server of a run: what they write and return is that of a process of their own."""

import os
import re
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import psutil
import pytest

from overturning.cli import main
from overturning.commands import fork_client
from overturning.commands.fork_client import (
    SERVER_SOCKET_ENVIRONMENT_VARIABLE,
    STEP_THREAD_COUNT_ENVIRONMENT_VARIABLE,
    run_workflow_step_in_fork_server_if_possible,
)

pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="the server runs on Linux only")

STUDY = '{"name": "small", "records": {"use": ["rinaldi"]}}'
COMMAND_OF_PROGRAM = [sys.executable, "-m", "overturning.cli"]
READ_STEP_ARGUMENTS = ("read", "--study", STUDY, "--record", "rinaldi")


@contextmanager
def running_server(table: Path) -> Iterator[psutil.Process]:
    """Start the fork server, which logs time and memory of workflow steps to `table`; yield its process."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv(STEP_THREAD_COUNT_ENVIRONMENT_VARIABLE, "1")
        patch.setenv(SERVER_SOCKET_ENVIRONMENT_VARIABLE, "")
        stop = fork_client.start_fork_server(table)
        (server,) = (one for one in psutil.Process().children() if str(table) in one.cmdline())
        assert fork_client.SERVER_MODULE in server.cmdline()
        try:
            yield server
        finally:
            stop()


@pytest.fixture(scope="module")
def step_time_and_memory_log_path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the path of the table in which the fork server logs time and memory of each step."""
    return tmp_path_factory.mktemp("server") / "steps.tsv"


@pytest.fixture(scope="module")
def get_or_restart_server(step_time_and_memory_log_path: Path) -> Iterator[Callable[[], psutil.Process]]:
    """Return a function that gives the fork server of this file, or a new one after a test that killed it."""
    started: list[psutil.Process] = []
    with ExitStack() as stack:

        def running_server_process() -> psutil.Process:
            if not started or not started[-1].is_running() or started[-1].status() == psutil.STATUS_ZOMBIE:
                stack.close()
                started.append(stack.enter_context(running_server(step_time_and_memory_log_path)))
            return started[-1]

        yield running_server_process


@pytest.fixture
def fork_server_process(get_or_restart_server: Callable[[], psutil.Process]) -> psutil.Process:
    """Process of the server, shared by the tests of this file, as it takes a second to start."""
    return get_or_restart_server()


def run_step_in_server_or_separate_process(*words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run a workflow step in the fork server if the environment names one, otherwise in a separate process."""
    return subprocess.run(
        [*COMMAND_OF_PROGRAM, *words], env=os.environ | environment, capture_output=True, text=True, check=False
    )


def rows_of_steps_run_in_server(step_time_and_memory_table: Path) -> list[list[str]]:
    """Return the rows below the heading of the server's table: one for each step that ran in the server."""
    lines = (
        step_time_and_memory_table.read_text(encoding="utf-8").splitlines()
        if step_time_and_memory_table.exists()
        else []
    )
    return [line.split("\t") for line in lines[1:]]


def wait_until(condition: Callable[[], object]) -> None:
    """Wait until a condition is true; fail after a minute."""
    end = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.02)


def open_pipe_for_writing(pipe: Path) -> list[int]:
    """Open a named pipe for writing; return [file descriptor], or [] if no process reads the pipe yet."""
    try:
        return [os.open(pipe, os.O_WRONLY | os.O_NONBLOCK)]
    except OSError:
        return []


def ignores_interrupt(process: int) -> bool:
    """True if a process ignores Ctrl-C, as a client does while its step runs."""
    (mask,) = re.findall(r"^SigIgn:\s*(\w+)$", Path(f"/proc/{process}/status").read_text(), re.MULTILINE)
    return bool(int(mask, 16) >> (signal.SIGINT - 1) & 1)


@contextmanager
def client_and_process_of_endless_step(
    server: psutil.Process, folder: Path
) -> Iterator[tuple[subprocess.Popen[str], psutil.Process]]:
    """Start a step that waits forever for its study file; yield the client and the server's child that runs it."""
    study, writers = folder / "study.yaml", list[int]()
    os.mkfifo(study)
    words = ["read", "--study", str(study), "--record", "rinaldi", "--output", str(folder / "never.nc")]
    client = subprocess.Popen([*COMMAND_OF_PROGRAM, *words], stderr=subprocess.PIPE, text=True)
    try:
        wait_until(lambda: writers.extend(open_pipe_for_writing(study)) or writers)  # past the begin of a step
        wait_until(lambda: ignores_interrupt(client.pid))  # the server has answered it
        yield client, server.children()[0]
    finally:  # without it, the server of a failed test would wait for ever
        client.kill()
        for writer in writers:
            os.close(writer)


def test_a_step_in_the_fork_server_gives_the_output_of_a_separate_process(
    fork_server_process: psutil.Process, step_time_and_memory_log_path: Path, tmp_path: Path
) -> None:
    for name, environment in (("own.nc", {SERVER_SOCKET_ENVIRONMENT_VARIABLE: ""}), ("server.nc", {})):
        done = run_step_in_server_or_separate_process(
            *READ_STEP_ARGUMENTS, "--output", str(tmp_path / name), **environment
        )
        assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert (tmp_path / "own.nc").read_bytes() == (tmp_path / "server.nc").read_bytes()
    (row,) = (one for one in rows_of_steps_run_in_server(step_time_and_memory_log_path) if str(tmp_path) in one[1])
    assert row[:2] == ["read", str(tmp_path / "server.nc")]
    head = step_time_and_memory_log_path.read_text(encoding="utf-8").splitlines()[0].split("\t")
    used = dict(zip(head, row, strict=True))
    assert 0.0 < float(used["cpu_time"]) < 60.0
    assert 10.0 < float(used["max_rss"]) < 2000.0


@pytest.mark.parametrize("words", [("read", "--study", STUDY, "--record", "none", "--output", "x.nc"), ("read",)])
def test_a_failing_step_has_the_same_message_and_status_in_the_fork_server(
    fork_server_process: psutil.Process,
    step_time_and_memory_log_path: Path,
    words: tuple[str, ...],
    capsys: pytest.CaptureFixture[str],
) -> None:
    before = len(rows_of_steps_run_in_server(step_time_and_memory_log_path))
    served = run_step_in_server_or_separate_process(*words)
    assert len(rows_of_steps_run_in_server(step_time_and_memory_log_path)) == before + 1, "it ran in the server"
    with pytest.raises(SystemExit) as end:
        main(list(words))  # as a process of its own does
    own = capsys.readouterr()
    assert end.value.code not in (None, 0)
    assert (served.returncode, served.stdout, served.stderr) == (end.value.code, own.out, own.err)


def test_a_fork_server_step_has_the_folder_and_environment_of_its_client(
    fork_server_process: psutil.Process,
    step_time_and_memory_log_path: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    before = len(rows_of_steps_run_in_server(step_time_and_memory_log_path))
    monkeypatch.chdir(tmp_path)
    (tmp_path / "config").mkdir()
    (tmp_path / "config" / "records.tsv").write_text("id\tformat\tsource\nmine\tauto\tgone.V2A\n", encoding="utf-8")
    words = ("read", "--study", STUDY.replace("rinaldi", "mine"), "--record", "mine", "--output", "mine.nc")
    assert "mine: gone.V2A is not in resources/records" in run_step_in_server_or_separate_process(*words).stderr
    (tmp_path / "config" / "records.tsv").unlink()
    (tmp_path / "temporary").mkdir(mode=0o500)
    assert (
        run_step_in_server_or_separate_process(
            *READ_STEP_ARGUMENTS, "--output", "motion.nc", TMPDIR=str(tmp_path / "temporary")
        ).returncode
        == 0
    )
    assert (tmp_path / "motion.nc").is_file()
    assert len(rows_of_steps_run_in_server(step_time_and_memory_log_path)) == before + 2


def test_the_fork_server_runs_steps_concurrently(fork_server_process: psutil.Process, tmp_path: Path) -> None:
    with client_and_process_of_endless_step(fork_server_process, tmp_path) as (client, process):
        assert (
            run_step_in_server_or_separate_process(
                *READ_STEP_ARGUMENTS, "--output", str(tmp_path / "other.nc")
            ).returncode
            == 0
        )
        assert client.poll() is None
        process.kill()
        client.communicate(timeout=60.0)
    assert client.returncode == 128 + signal.SIGKILL, "as a shell returns it"
    assert (
        run_step_in_server_or_separate_process(*READ_STEP_ARGUMENTS, "--output", str(tmp_path / "third.nc")).returncode
        == 0
    ), "the server goes on"


def test_a_fork_server_step_ends_when_its_client_is_killed(fork_server_process: psutil.Process, tmp_path: Path) -> None:
    with client_and_process_of_endless_step(fork_server_process, tmp_path) as (client, process):
        client.kill()
        client.communicate(timeout=60.0)
        process.wait(60.0)
    assert (
        run_step_in_server_or_separate_process(*READ_STEP_ARGUMENTS, "--output", str(tmp_path / "other.nc")).returncode
        == 0
    ), "the server goes on"


ORPHANED_STEP_PROGRAM = """
import os, signal, sys
from overturning.commands import fork_server
for server in (os.getpid(), 1):
    if not (step := os.fork()):
        request = {"environment": dict(os.environ), "folder": os.getcwd(), "arguments": ["init", f"of-{server > 1}"]}
        fork_server._run_workflow_step_and_exit(request, [1, 2], signal.SIG_DFL, server)
    print(os.waitstatus_to_exitcode(os.waitpid(step, 0)[1]), flush=True)
"""
"""Program that runs a step as a forked copy of its parent, and one as that of another process; prints their status."""


def test_a_step_does_not_run_if_its_fork_server_ended_before_the_step_began(tmp_path: Path) -> None:
    environment = os.environ | {SERVER_SOCKET_ENVIRONMENT_VARIABLE: "of the server"}
    command = [sys.executable, "-c", ORPHANED_STEP_PROGRAM]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=True)
    lines = done.stdout.splitlines()
    assert ([line for line in lines if line.isdecimal()], lines[-1]) == (["0", "1"], "1")
    assert [path.name for path in tmp_path.iterdir()] == ["of-True"], "made by the step whose server is there"


def test_the_fork_server_of_a_killed_workflow_ends_after_the_running_steps(tmp_path: Path) -> None:
    """The steps that run when a workflow is killed go on to their end, and a new run of the workflow waits for them."""
    motion = tmp_path / "motion.nc"
    code = (
        "import subprocess, sys\nfrom overturning.commands.fork_client import start_fork_server\n"
        f"start_fork_server({str(tmp_path / 'steps.tsv')!r})\n"
        f"print(subprocess.Popen([*{COMMAND_OF_PROGRAM}, *{[*READ_STEP_ARGUMENTS, '--output', str(motion)]}]).pid, "
        "flush=True)\ninput()\n"
    )
    environment = os.environ | {
        STEP_THREAD_COUNT_ENVIRONMENT_VARIABLE: "1",
        SERVER_SOCKET_ENVIRONMENT_VARIABLE: "",
        "TMPDIR": str(tmp_path),
    }
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    workflow = subprocess.Popen([sys.executable, "-c", code], env=environment, text=True, **pipes)
    assert workflow.stdout is not None
    client = psutil.Process(int(workflow.stdout.readline()))
    (server,) = (one for one in psutil.Process(workflow.pid).children() if fork_client.SERVER_MODULE in one.cmdline())
    wait_until(lambda: server.children() or motion.exists())
    workflow.kill()
    workflow.communicate()
    for process in (client, server):
        wait_until(lambda process=process: not process.is_running() or process.status() == psutil.STATUS_ZOMBIE)
    assert motion.is_file()
    assert not list(tmp_path.glob("overturning-*")), "the folder of its socket is gone"


@pytest.mark.parametrize(
    ("variable", "value"),
    [
        (STEP_THREAD_COUNT_ENVIRONMENT_VARIABLE, "2"),
        (SERVER_SOCKET_ENVIRONMENT_VARIABLE, ""),
        (SERVER_SOCKET_ENVIRONMENT_VARIABLE, "/no/socket"),
    ],
)
def test_a_step_without_a_suitable_fork_server_is_left_to_its_caller(
    fork_server_process: psutil.Process,
    step_time_and_memory_log_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    variable: str,
    value: str,
) -> None:
    """A step runs in its caller if there is no server, or if the server was started for another number of threads."""
    before = rows_of_steps_run_in_server(step_time_and_memory_log_path)
    monkeypatch.setenv(variable, value)
    assert run_workflow_step_in_fork_server_if_possible(["--version"]) is None
    assert rows_of_steps_run_in_server(step_time_and_memory_log_path) == before


def test_no_fork_server_is_used_if_its_variable_is_off(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(SERVER_SOCKET_ENVIRONMENT_VARIABLE, "off")
    monkeypatch.setenv(STEP_THREAD_COUNT_ENVIRONMENT_VARIABLE, "1")
    fork_client.start_fork_server(tmp_path / "steps.tsv")
    assert os.environ[SERVER_SOCKET_ENVIRONMENT_VARIABLE] == "off"
    assert run_workflow_step_in_fork_server_if_possible(["--version"]) is None


@pytest.mark.parametrize("folder", ["gone", "long" * 30])
def test_a_run_continues_without_a_fork_server_if_no_socket_can_be_made(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, folder: str
) -> None:
    """The folder of temporary files does not exist, or its path is too long for a socket."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / folder))
    if folder != "gone":
        (tmp_path / folder).mkdir()
    monkeypatch.delenv(SERVER_SOCKET_ENVIRONMENT_VARIABLE, raising=False)
    fork_client.start_fork_server(tmp_path / "steps.tsv")()
    assert SERVER_SOCKET_ENVIRONMENT_VARIABLE not in os.environ
    assert [path.name for path in tmp_path.rglob("*")] == [folder] * (folder != "gone")


def test_a_fork_server_of_another_installation_is_not_used(
    fork_server_process: psutil.Process, step_time_and_memory_log_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    before = rows_of_steps_run_in_server(step_time_and_memory_log_path)
    monkeypatch.setattr(fork_client, "python_executable_and_package_folder", lambda: [sys.executable, "/elsewhere"])
    assert run_workflow_step_in_fork_server_if_possible(["--version"]) is None
    assert rows_of_steps_run_in_server(step_time_and_memory_log_path) == before


def test_the_fork_server_loads_kernels_once_per_study_variant(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The kernels of a variant are loaded before its second sweep, because the first one compiles and stores them."""
    from overturning.commands import fork_server

    loaded: list[str] = []
    monkeypatch.setattr(
        fork_server, "_load_compiled_code_cached_by_earlier_step", lambda arguments: loaded.append(arguments[-1])
    )
    with socket.socket(socket.AF_UNIX) as listener:
        server = fork_server.ForkServer(listener, tmp_path / "steps.tsv")
        for variant in ("nominal", "nominal", "soft", "nominal", "soft", "soft"):
            arguments = ["sweep", "--variant", variant]
            server._preload_modules_and_code_for_command(arguments)
            ours, theirs = socket.socketpair()
            process = os.fork()
            if not process:
                os._exit(0)
            os.waitid(os.P_PID, process, os.WEXITED | os.WNOWAIT)
            server._running_step_by_process_id[process] = fork_server.RunningWorkflowStep(arguments, ours)
            server._store_resource_use_and_send_exit_statuses()
            assert theirs.recv(9) == b"0"
            theirs.close()
    assert loaded == ["nominal", "soft"]


def test_steps_end_when_their_fork_server_is_killed(fork_server_process: psutil.Process, tmp_path: Path) -> None:
    """A running step is stopped if its fork server is killed."""
    # The last test of the file: a test after it would start a new server.
    with client_and_process_of_endless_step(fork_server_process, tmp_path) as (client, process):
        fork_server_process.kill()
        assert "error: the fork server of the run has ended; run again" in client.communicate(timeout=60.0)[1]
        assert client.returncode == 1
        wait_until(lambda: not process.is_running() or process.status() == psutil.STATUS_ZOMBIE)
        done = run_step_in_server_or_separate_process("--version")
        assert (done.returncode, done.stderr) == (0, ""), "a step without a server runs in a process of its own"
