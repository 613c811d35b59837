"""Start of the fork server by a workflow, and its clients: steps that run in the server and are waited for here.

A client imports few modules, since its start is most of its cost.
"""

import os
import sys
from collections.abc import Callable, Sequence
from typing import Final

SERVER_MODULE: Final = "overturning.commands.fork_server"
"""Module of the server, which this module must not import."""

SERVER_SOCKET_ENVIRONMENT_VARIABLE: Final = "OVERTURNING_FORK_SERVER"
"""Environment variable with the path of the server's socket."""

STEP_THREAD_COUNT_ENVIRONMENT_VARIABLE: Final = "OPENBLAS_NUM_THREADS"
"""Environment variable that Snakemake sets to the number of threads of a step."""

ENVIRONMENT_VARIABLES_OF_LIBRARY_THREAD_COUNTS: Final = (
    *(STEP_THREAD_COUNT_ENVIRONMENT_VARIABLE, "OMP_NUM_THREADS", "GOTO_NUM_THREADS", "MKL_NUM_THREADS"),
    *("VECLIB_MAXIMUM_THREADS", "NUMEXPR_NUM_THREADS"),
)
"""Environment variables with the number of threads of numerical libraries, as Snakemake sets them for a step."""

REQUEST_SIZE_HEADER_BYTE_COUNT: Final = 4
"""Length of the number before a request: the size of the request, bytes."""

STEP_STARTED_ANSWER: Final = b"+"
"""First byte of the answer: the step has begun. Its exit status follows as text at its end."""


def python_executable_and_package_folder() -> list[str]:
    """Return the paths of Python and of this package, which must be the same in fork server and client."""
    return [sys.executable, os.path.dirname(os.path.dirname(os.path.abspath(__file__)))]


def run_workflow_step_in_fork_server_if_possible(arguments: Sequence[str]) -> int | None:
    """Run a workflow step in a copy (fork) of the workflow's server process, and return the step's exit status.

    Returns None if the step must run in this process: without a server, with a server of another installation, and for
    a step with several threads, because the server has loaded its libraries for one thread.
    """
    path = os.environ.get(SERVER_SOCKET_ENVIRONMENT_VARIABLE)
    if not arguments or not path or os.environ.get(STEP_THREAD_COUNT_ENVIRONMENT_VARIABLE) != "1":
        return None
    import json
    import signal
    import socket

    about = {"arguments": list(arguments), "folder": os.getcwd(), "environment": dict(os.environ)}
    request = json.dumps(about | {"installation": python_executable_and_package_folder()}).encode()
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as server:
        # Ctrl-C ends this process, and thereby the step, if the step does not exist yet.
        interrupt_handler = signal.getsignal(signal.SIGINT)
        if interrupt_handler != signal.SIG_IGN:
            signal.signal(signal.SIGINT, signal.SIG_DFL)
        try:
            server.connect(path)
            # Standard output and error of the step are those of this process.
            socket.send_fds(server, [len(request).to_bytes(REQUEST_SIZE_HEADER_BYTE_COUNT, "big")], [1, 2])
            server.sendall(request)
            accepted = server.recv(1) == STEP_STARTED_ANSWER
        except OSError:  # the server has ended
            accepted = False
        if not accepted:
            signal.signal(signal.SIGINT, interrupt_handler)
            return None
        # Later it also reaches the step: wait for its message and status.
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        answer = b""
        while received := server.recv(64):
            answer += received
    if not answer:
        print("error: the fork server of the run has ended; run again", file=sys.stderr)
        return 1
    return int(answer)


def start_fork_server(resource_use_table_path: str | os.PathLike[str]) -> Callable[[], None]:
    """Start a server process that forks itself for each workflow step; return a function that ends the server.

    No server starts on systems other than Linux, where a fork of a process with loaded libraries may fail, or if the
    folder of temporary files accepts no socket. Nor does one start if the environment variable that
    `SERVER_SOCKET_ENVIRONMENT_VARIABLE` names is set, to the socket of a running server or to a text such as ``off``.
    Without any server each step runs in a process of its own.

    Parameters
    ----------
    resource_use_table_path : path
        Table (TSV) to which processor time and memory of each step are appended.

    Returns
    -------
    callable
        Function that ends the server before this process ends.
    """
    if sys.platform != "linux" or os.environ.get(SERVER_SOCKET_ENVIRONMENT_VARIABLE):
        return _do_nothing
    import atexit
    import shutil
    import socket
    import subprocess
    import tempfile

    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as listener:
        folder = ""
        try:
            folder = tempfile.mkdtemp(prefix="overturning-")
            path = os.path.join(folder, "socket")
            listener.bind(path)
        except OSError:  # such as a path that is too long
            shutil.rmtree(folder, ignore_errors=True)
            return _do_nothing
        listener.listen(128)  # clients can connect from now on; the server answers as soon as it has started
        server = subprocess.Popen(
            [sys.executable, "-P", "-m", SERVER_MODULE, str(listener.fileno()), str(resource_use_table_path)],
            stdin=subprocess.PIPE,
            pass_fds=[listener.fileno()],
            env=os.environ | dict.fromkeys(ENVIRONMENT_VARIABLES_OF_LIBRARY_THREAD_COUNTS, "1"),
        )
    os.environ[SERVER_SOCKET_ENVIRONMENT_VARIABLE] = path

    def stop_fork_server() -> None:
        """End the server by closing its input, and wait until it has ended."""
        os.environ.pop(SERVER_SOCKET_ENVIRONMENT_VARIABLE, None)
        server.communicate()  # its input ends, and so does the server

    atexit.register(stop_fork_server)
    return stop_fork_server


def _do_nothing() -> None:
    """Do nothing; used in place of the function that stops the fork server if no server was started."""
