"""A folder of its own with the workflow and a study, and the one command that runs it, and runs it again."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any, Final, Self

import psutil
import yaml

from overturning.commands.study import WORKFLOW
from verification.tables import ROOT

CUBE: Final = "cube.nc"
_LONG: Final = 900.0  # s, in which any run must end


class Project:
    """A copy of the project's workflow with a study.

    Parameters
    ----------
    folder : Path
        Made, where it is not there with the study.
    study : str
        The study as YAML; the default one where empty.
    *options : str
        Snakemake's, each time that it runs.
    own_kernels : bool
        Whether its compiled kernels are its own, so that they can be damaged; else those of all.
    """

    def __init__(self, folder: Path, study: str = "", *options: str, own_kernels: bool = False) -> None:
        self.folder, self.file = folder, "study.yaml" if study else "config/near-fault.yaml"
        if not (folder / self.file).exists():
            folder.mkdir(parents=True, exist_ok=True)
            for name in (*WORKFLOW, "config"):
                copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy2
                copy(ROOT / name, folder / name)
            if study:
                (folder / self.file).write_text(study, encoding="utf-8")
        self._options, self._own_kernels = options, own_kernels
        self.results = folder / "results" / yaml.safe_load((folder / self.file).read_text(encoding="utf-8"))["name"]

    def copied(self, folder: Path) -> Self:
        """A copy in another folder, with results, Snakemake's notes and kernels."""
        shutil.rmtree(folder, ignore_errors=True)
        # A copy is as old as what it was made from; only then is nothing to be done in it.
        shutil.copytree(self.folder, folder, copy_function=shutil.copy2)
        other = object.__new__(type(self))
        other.__dict__ |= vars(self) | {"folder": folder, "results": folder / self.results.relative_to(self.folder)}
        return other

    @property
    def cube(self) -> Path:
        """The study's cube."""
        return self.results / CUBE

    def how(self, *options: str, file: str = CUBE) -> dict[str, Any]:
        """The command that makes a file of the results, all where none is named, and its surroundings."""
        environment = os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
        if self._own_kernels:
            environment["NUMBA_CACHE_DIR"] = str(self.folder / "kernels")
        command = [sys.executable, "-m", "snakemake", "--configfile", self.file, *self._options, *options]
        wanted = ["--", str((self.results / file).relative_to(self.folder))] if file else []
        return {"args": [*command, *wanted], "cwd": self.folder, "env": environment}

    def run(self, *options: str, file: str = CUBE) -> subprocess.CompletedProcess[str]:
        """Run the command to its end."""
        return subprocess.run(**self.how(*options, file=file), capture_output=True, text=True, timeout=_LONG)

    def begin(self) -> psutil.Popen:
        """Let the command run, in a group of processes of its own."""
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        return psutil.Popen(**self.how(), **quiet, start_new_session=True)
