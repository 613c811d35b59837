"""Fork server: a process that runs each step of a workflow in a copy of itself, with modules and kernels loaded.

Starting Python, importing packages and loading compiled kernels takes a second, more than the work of many steps. The
server does it once; a copy of it (fork) is ready in milliseconds. Each step still has its own process, output, log and
exit status. `overturning.cli` sends a step to the server named in the environment, and otherwise runs it itself.
"""

import contextlib
import ctypes
import gc
import json
import os
import selectors
import shutil
import signal
import socket
import sys
import tempfile
import traceback
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from typing import Any, Final, NamedTuple, NoReturn

from overturning.commands.application import run_command_line
from overturning.commands.fork_client import (
    REQUEST_SIZE_HEADER_BYTE_COUNT,
    SERVER_SOCKET_ENVIRONMENT_VARIABLE,
    STEP_STARTED_ANSWER,
    python_executable_and_package_folder,
)

_PRELOADED_MODULES_BY_COMMAND: Final = {
    "read": ("overturning.records.processing", "overturning.records.read", "overturning.study.load", "netCDF4"),
    "members": ("scipy.stats",),
    "rotate": ("overturning.study.intensity", "scipy.fft", "xarray", "dask.base"),
    "sweep": ("overturning.study.sweep", "overturning.dem.block.plan"),
    "record-figures": ("overturning.figures.record", "matplotlib.backends.backend_svg"),
    "findings": ("overturning.findings.collect",),
}
"""Modules that the server imports before the first step of a command, because later steps use them, too."""

_REQUEST_TIMEOUT_S: Final = 30.0  # s until a client must have sent its request
_PRCTL_SET_PARENT_DEATH_SIGNAL: Final = 1  # PR_SET_PDEATHSIG of prctl(2)


class RunningWorkflowStep(NamedTuple):
    """Workflow step that runs in a forked copy of the server, and whose client waits for its exit status."""

    command_line_arguments: list[str]
    client_connection: socket.socket


class ForkServer:
    """Server that runs each workflow step in a forked copy of itself, which saves the time to import modules."""

    def __init__(self, listening_socket: socket.socket, resource_use_table_path: Path) -> None:
        self._listener, self._resource_use_table_path = listening_socket, resource_use_table_path
        self._running_step_by_process_id: dict[int, RunningWorkflowStep] = {}  # by process id
        # Arguments of a successful sweep of each variant; None once its kernels are loaded.
        self._sweep_arguments_by_variant: dict[str, list[str] | None] = {}
        self._selector = selectors.DefaultSelector()
        self._interrupt_handler_of_steps: Any = signal.SIG_DFL  # that of the steps

    def run_requested_steps_until_workflow_ends(self) -> None:
        """Run requested workflow steps until all steps and the process that started the server have ended."""
        # Ctrl-C stops steps and workflow; the server ends after them.
        self._interrupt_handler_of_steps = signal.signal(signal.SIGINT, signal.SIG_IGN)
        ended_step, wake_up = socket.socketpair()
        wake_up.setblocking(False)
        signal.signal(signal.SIGCHLD, lambda *_: None)
        signal.set_wakeup_fd(wake_up.fileno())
        self._selector.register(self._listener, selectors.EVENT_READ)
        self._selector.register(ended_step, selectors.EVENT_READ)
        self._selector.register(sys.stdin, selectors.EVENT_READ)
        going_on = True
        while going_on or self._running_step_by_process_id:
            for key, _ in self._selector.select():
                if key.fileobj is self._listener:
                    self._accept_request_and_fork_workflow_step()
                elif key.fileobj is ended_step:
                    ended_step.recv(4096)
                    self._store_resource_use_and_send_exit_statuses()
                elif key.fileobj is sys.stdin:
                    self._selector.unregister(sys.stdin)
                    going_on = False
                elif key.data in self._running_step_by_process_id:  # its client was killed
                    self._selector.unregister(key.fileobj)
                    os.kill(key.data, signal.SIGKILL)

    def _accept_request_and_fork_workflow_step(self) -> None:
        """Accept a client's request to run a workflow step, and fork a copy of this process that runs it."""
        connection = self._listener.accept()[0]
        connection.settimeout(_REQUEST_TIMEOUT_S)
        try:
            request, outputs = _receive_request_and_output_descriptors(connection)
        except (OSError, ValueError):
            connection.close()
            return
        with contextlib.ExitStack() as stack:
            for output in outputs:
                stack.callback(os.close, output)
            if request["installation"] != python_executable_and_package_folder():
                connection.close()
                return
            self._preload_modules_and_code_for_command(request["arguments"])
            gc.freeze()  # garbage collection of a step need not visit, and so copy, what is loaded
            server_process = os.getpid()
            try:
                process = os.fork()
            except OSError:  # no memory or too many processes: the client runs the step itself
                connection.close()
                return
            if not process:
                _run_workflow_step_and_exit(request, outputs, self._interrupt_handler_of_steps, server_process)
        with contextlib.suppress(OSError):  # the client was killed: the selector notices
            connection.sendall(STEP_STARTED_ANSWER)
        self._running_step_by_process_id[process] = RunningWorkflowStep(request["arguments"], connection)
        self._selector.register(connection, selectors.EVENT_READ, process)

    def _preload_modules_and_code_for_command(self, command_line_arguments: list[str]) -> None:
        """Import the modules that a command needs, before the fork; for a simulation, also load compiled code."""
        with contextlib.suppress(Exception):  # the step reports it
            for name in _PRELOADED_MODULES_BY_COMMAND.get(command_line_arguments[0], ()):
                import_module(name)
            variant = _values_by_command_line_option(command_line_arguments).get("--variant", "")
            if (
                command_line_arguments[0] == "sweep"
                and (last := self._sweep_arguments_by_variant.get(variant)) is not None
            ):
                self._sweep_arguments_by_variant[variant] = None
                _load_compiled_code_cached_by_earlier_step(last)

    def _store_resource_use_and_send_exit_statuses(self) -> None:
        """Store processor time and memory of ended steps, and send their exit statuses to their clients."""
        while self._running_step_by_process_id:
            process, wait_status, used = os.wait4(-1, os.WNOHANG)
            if not process:
                return
            step, status = self._running_step_by_process_id.pop(process), os.waitstatus_to_exitcode(wait_status)
            with contextlib.suppress(KeyError, ValueError):
                self._selector.unregister(step.client_connection)
            self._store_processor_time_and_memory(
                step.command_line_arguments, used
            )  # first: who waits for the step may read them at once
            with contextlib.suppress(OSError):
                step.client_connection.sendall(str(status if status >= 0 else 128 - status).encode())
            step.client_connection.close()
            if step.command_line_arguments[0] == "sweep" and status == 0:
                self._sweep_arguments_by_variant.setdefault(
                    _values_by_command_line_option(step.command_line_arguments).get("--variant", ""),
                    step.command_line_arguments,
                )

    def _store_processor_time_and_memory(self, command_line_arguments: list[str], resource_use: Any) -> None:
        """Append the processor time (s) and memory (MB) of a workflow step to the table of resource use."""
        options = _values_by_command_line_option(command_line_arguments)
        output = options.get("--output") or options.get("--results", "")
        with contextlib.suppress(OSError):
            self._resource_use_table_path.parent.mkdir(parents=True, exist_ok=True)
            with self._resource_use_table_path.open("a", encoding="utf-8") as table:
                if not table.tell():
                    table.write("command\toutput\tcpu_time\tmax_rss\n")  # s and MB, like Snakemake's tables
                time, memory = resource_use.ru_utime + resource_use.ru_stime, resource_use.ru_maxrss / 1000
                table.write(f"{command_line_arguments[0]}\t{output}\t{time:.2f}\t{memory:.1f}\n")


def _values_by_command_line_option(command_line_arguments: list[str]) -> dict[str, str]:
    """Map each argument of a workflow step to the argument after it: an option such as --output to its value."""
    return dict(pairwise(command_line_arguments))


def _receive_request_and_output_descriptors(client_connection: socket.socket) -> tuple[dict[str, Any], list[int]]:
    """Receive a client's request; return it, and the file descriptors of the client's standard output and error."""
    header, outputs, *_ = socket.recv_fds(client_connection, REQUEST_SIZE_HEADER_BYTE_COUNT, 2)
    size, data = int.from_bytes(header, "big"), b""
    while len(data) < size:
        if not (received := client_connection.recv(size - len(data))):
            raise OSError("the client has ended")
        data += received
    return json.loads(data), outputs


def _load_compiled_code_cached_by_earlier_step(arguments_of_earlier_simulation_step: list[str]) -> None:
    """Load the compiled simulation code that a finished simulation step of the same variant has stored on disk."""
    from overturning.records.store import read_record_from_motion_file
    from overturning.study.load import load_study_from_file_or_json
    from overturning.study.sweep import load_compiled_simulation_code

    options = _values_by_command_line_option(arguments_of_earlier_simulation_step)
    record = read_record_from_motion_file(Path(options["--motion"]))
    load_compiled_simulation_code(load_study_from_file_or_json(options["--study"]), record, options["--variant"])


def _run_workflow_step_and_exit(
    request: dict[str, Any],
    stdout_and_stderr_descriptors: list[int],
    sigint_handler_of_step: Any,
    server_process_id: int,
) -> NoReturn:
    """Run a workflow step in this forked process, with the client's folder, environment and outputs; then exit.

    If the server (process number `server_process_id`) ends, the step is killed.
    """
    status: Any = 1
    try:
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        signal.signal(signal.SIGINT, sigint_handler_of_step)
        ctypes.CDLL(None).prctl(_PRCTL_SET_PARENT_DEATH_SIGNAL, signal.SIGKILL)
        if os.getppid() != server_process_id:  # the server ended before the call above
            os._exit(1)
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        for number, output in enumerate(stdout_and_stderr_descriptors, start=1):
            os.dup2(output, number)
        os.closerange(3, os.sysconf("SC_OPEN_MAX"))  # sockets of the server and of other steps
        os.environ.clear()
        os.environ.update(request["environment"])
        del os.environ[SERVER_SOCKET_ENVIRONMENT_VARIABLE]
        tempfile.tempdir = None  # the folder of temporary files is that of the step
        os.chdir(request["folder"])
        sys.argv = ["overturning", *request["arguments"]]
        run_command_line(request["arguments"])
        status = 0
    except SystemExit as end:
        status = 0 if end.code is None else end.code
    except BaseException:
        traceback.print_exc()
    finally:
        with contextlib.suppress(OSError):
            sys.stdout.flush()
            sys.stderr.flush()
        os._exit(status if isinstance(status, int) else 1)


def main(listening_socket_descriptor: int, resource_use_table_path: str) -> None:
    """Run the fork server on an open socket until the workflow has ended, then remove the socket's folder."""
    with socket.socket(fileno=listening_socket_descriptor) as accepted:
        folder = Path(accepted.getsockname()).parent
        try:
            ForkServer(accepted, Path(resource_use_table_path)).run_requested_steps_until_workflow_ends()
        finally:
            shutil.rmtree(folder, ignore_errors=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2])
