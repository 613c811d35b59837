"""A small study in a folder of its own, and the one command that runs it, and runs it again."""

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

import psutil

from verification.whole_run import copy_project

STUDY: Final = """\
name: faults
records: {use: [rinaldi, petrolia]}
azimuth: {step: 45}
b_over_h: [0.2, 0.3]
height: [0.6]
friction: [0.5]
ensemble: {members: 0}
verification: none
"""
_LONG: Final = 600.0  # s, in which any of these runs must end


class Place:
    """A folder with the workflow, a study and compiled kernels of its own.

    Parameters
    ----------
    folder : Path
        Made, as a copy of `like` where given.
    like : Place, optional
        One whose results, Snakemake's notes and kernels are taken over.
    own_kernels : bool
        Whether its kernels are its own, so that they can be damaged; else those of all.
    """

    def __init__(self, folder: Path, like: "Place | None" = None, own_kernels: bool = True) -> None:
        self.folder = folder
        self._own_kernels: bool = like._own_kernels if like else own_kernels
        shutil.rmtree(folder, ignore_errors=True)
        if like:
            # A copy is as old as what it was made from; only then is nothing to be done in it.
            shutil.copytree(like.folder, folder, copy_function=shutil.copy2)
        else:
            copy_project(folder)
            (folder / "config" / "faults.yaml").write_text(STUDY, encoding="utf-8")
        path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
        self.environment = os.environ | {"PATH": path}
        if self._own_kernels:
            self.environment["NUMBA_CACHE_DIR"] = str(folder / "kernels")

    @property
    def results(self) -> Path:
        """Folder of the study's results."""
        return self.folder / "results" / "faults"

    @property
    def cube(self) -> Path:
        """The cube that the command makes."""
        return self.results / "cube.nc"

    def command(self) -> list[str]:
        """The command, that of `make run`."""
        ask = ["--cores", "1", "--set-scatter", "sweep=2", "--configfile", "config/faults.yaml"]
        ask += ["--", "results/faults/cube.nc"]
        return [sys.executable, "-m", "snakemake", *ask]

    def run(self) -> subprocess.CompletedProcess[str]:
        """Run the command to its end."""
        return subprocess.run(
            self.command(), cwd=self.folder, env=self.environment, capture_output=True, text=True, timeout=_LONG
        )

    def begin(self) -> psutil.Popen:
        """Let the command run, in a group of processes of its own."""
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        where = {"cwd": self.folder, "env": self.environment, "start_new_session": True}
        return psutil.Popen(self.command(), **where, **quiet)


def jobs(run: psutil.Popen) -> Iterator[psutil.Process]:
    """Each step of a run when it begins, until the run ends."""
    seen = set()
    for _ in until(lambda: run.poll() is not None):
        for process in _below(run):
            words = _words(process)
            if process.pid not in seen and any(Path(word).name == "overturning" for word in words[:2]):
                seen.add(process.pid)
                yield process


def _below(run: psutil.Popen) -> list[psutil.Process]:
    try:
        found: list[psutil.Process] = run.children(recursive=True)
    except psutil.Error:
        return []
    return found


def _words(process: psutil.Process) -> list[str]:
    try:
        words: list[str] = process.cmdline()
    except psutil.Error:
        return []
    return words


def until(done: Callable[[], bool]) -> Iterator[None]:
    """Look again and again, for a minute or ten at most."""
    end = time.monotonic() + _LONG
    while not done():
        if time.monotonic() > end:
            raise RuntimeError("no end")
        yield
        time.sleep(0.01)
