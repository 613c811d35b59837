"""A SLURM cluster of one node on the loopback address, started without systemd and stopped at the end of a block.

Its configuration must be at /etc/slurm/slurm.conf, because a job step removes SLURM_CONF from its environment. An
existing file is restored afterwards, unless a killed run of this module left it: with it, each start of Snakemake would
wait ten seconds. The cluster has no accounting, so Snakemake needs `--slurm-no-account --slurm-status-command squeue`
to notice that a job has ended.
"""

import os
import secrets
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Final

SLURM_CONFIGURATION_FILE: Final = Path("/etc/slurm/slurm.conf")

SNAKEMAKE_OPTIONS_FOR_SLURM: Final = ("--slurm-no-account", "--slurm-status-command", "squeue")
"""Options that Snakemake needs for this cluster."""

_REQUIRED_PROGRAMS: Final = ("munged", "slurmctld", "slurmd", "sbatch", "squeue")
_START_TIMEOUT_S: Final = 30.0  # s, for the node to be idle

_CONFIGURATION_FIRST_LINE: Final = "# A cluster of one node for a test of overturning; to be removed where none runs.\n"

_CONFIGURATION_TEMPLATE: Final = """\
ClusterName=one
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={daemon}
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
SlurmdParameters=config_overrides
SchedulerParameters=batch_sched_delay=0,sched_interval=1
MpiDefault=none
ReturnToService=2
MinJobAge=600
NodeName=one NodeHostname={host} NodeAddr=127.0.0.1 CPUs={processors} RealMemory={memory}
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


def slurm_unavailable_reason() -> str:
    """Return the reason why a SLURM cluster cannot run on this machine; empty if it can."""
    lacking = [name for name in _REQUIRED_PROGRAMS if shutil.which(name) is None]
    if lacking:
        return f"no {', '.join(lacking)} here; install Debian's slurm-wlm and munge"
    if os.geteuid() != 0:
        return "the configuration of SLURM is in /etc/slurm, which only root may write"
    return ""


@contextmanager
def run_one_node_slurm(processor_count: int = 2) -> Iterator[None]:
    """Run a SLURM cluster of one node during a `with` block.

    Raise a RuntimeError with the end of its logs if it does not start.
    """
    with ExitStack() as ending:
        folder = Path(ending.enter_context(tempfile.TemporaryDirectory(prefix="slurm-")))
        for name in ("state", "spool"):
            (folder / name).mkdir()
        key = folder / "munge.key"
        key.touch(mode=0o400)
        key.write_bytes(secrets.token_bytes(128))
        memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2**20
        about = {"host": socket.gethostname(), "folder": folder, "processors": processor_count, "memory": memory}
        ports = dict(zip(("controller", "daemon"), _free_ports(2), strict=True))
        ending.enter_context(_temporary_slurm_configuration(_CONFIGURATION_TEMPLATE.format(**about, **ports)))
        own = [f"--{name}={folder}/munge.{end}" for name, end in (("socket", "socket"), ("pid-file", "pid"))]
        own += [f"--key-file={key}", f"--seed-file={folder}/munge.seed", f"--log-file={folder}/munge.log"]
        ending.enter_context(_background_process(["munged", "--foreground", "--force", *own], folder))
        _wait_until((folder / "munge.socket").exists, folder)
        ending.enter_context(_background_process(["slurmctld", "-D"], folder))
        ending.enter_context(_background_process(["slurmd", "-D", "-N", "one"], folder))
        _wait_until(lambda: "idle" in _command_output_or_empty_if_failed("sinfo", "--noheader", "--format=%T"), folder)
        yield


def _free_ports(port_count: int) -> list[int]:
    """Return free TCP ports of the loopback address."""
    with ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(port_count)]
        for each in sockets:
            each.bind(("127.0.0.1", 0))
        return [int(each.getsockname()[1]) for each in sockets]


@contextmanager
def _temporary_slurm_configuration(text: str) -> Iterator[None]:
    """Write a SLURM configuration for a `with` block, and restore the former configuration at its end."""
    before = SLURM_CONFIGURATION_FILE.read_bytes() if SLURM_CONFIGURATION_FILE.is_file() else b""
    SLURM_CONFIGURATION_FILE.parent.mkdir(exist_ok=True)
    SLURM_CONFIGURATION_FILE.write_text(_CONFIGURATION_FIRST_LINE + text, encoding="utf-8")
    try:
        yield
    finally:
        if before and not before.startswith(_CONFIGURATION_FIRST_LINE.encode()):
            SLURM_CONFIGURATION_FILE.write_bytes(before)
        else:
            SLURM_CONFIGURATION_FILE.unlink()


@contextmanager
def _background_process(command: list[str], log_folder: Path) -> Iterator[None]:
    """Run a command in the background, with its output in a log file, and stop it at the end of the `with` block."""
    program = shutil.which(command[0]) or command[0]
    with (
        (log_folder / f"{command[0]}.log").open("w", encoding="utf-8") as log,
        subprocess.Popen([program, *command[1:]], stdout=log, stderr=log) as process,
    ):
        try:
            yield
        finally:
            process.terminate()
            try:
                process.wait(10)
            except subprocess.TimeoutExpired:
                process.kill()


def _command_output_or_empty_if_failed(*command: str) -> str:
    """Return the output of a command; empty if it fails."""
    done = subprocess.run(command, capture_output=True, text=True, timeout=20, check=False)
    return done.stdout if done.returncode == 0 else ""


def _wait_until(condition: Callable[[], bool], log_folder: Path) -> None:
    """Wait until a condition is true; raise a RuntimeError with the end of the logs after `_START_TIMEOUT_S` s."""
    deadline = time.monotonic() + _START_TIMEOUT_S
    while not condition():
        if time.monotonic() > deadline:
            logs = [
                log.read_text(encoding="utf-8", errors="replace")[-500:] for log in sorted(log_folder.glob("*.log"))
            ]
            raise RuntimeError("SLURM does not start: " + "\n".join(logs))
        time.sleep(0.2)
