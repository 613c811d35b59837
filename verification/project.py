"""A separate folder with the workflow and a study, and the command that runs or resumes it."""

import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any, Final, Self

import psutil
import yaml

from overturning.commands.study import WORKFLOW_FILES_AND_FOLDERS
from verification.tables import ROOT

CUBE_FILE_NAME: Final = "cube.nc"
_RUN_TIMEOUT_S: Final = 900.0  # s, in which any run must end


class WorkflowFolder:
    """Copy of the project's workflow with a study.

    Parameters
    ----------
    folder : Path
        Created unless it already contains the study.
    study : str
        Study as YAML; empty: the default study.
    *options : str
        Options of Snakemake, for every run.
    own_kernels : bool
        True: use separate compiled kernels, which may be damaged; False: use the shared ones.
    checkout : Path
        Checkout whose workflow and package are used, with the packages of this environment.
    """

    def __init__(
        self, folder: Path, study: str = "", *options: str, own_kernels: bool = False, checkout: Path = ROOT
    ) -> None:
        """Copy the workflow and a study into a folder; with `own_kernels` kernels are cached there, too."""
        self.folder, self.file = folder, "study.yaml" if study else "config/near-fault.yaml"
        if not (folder / self.file).exists():
            folder.mkdir(parents=True, exist_ok=True)
            for name in (*WORKFLOW_FILES_AND_FOLDERS, "config"):
                copy = shutil.copytree if (checkout / name).is_dir() else shutil.copy2
                copy(checkout / name, folder / name)
            if study:
                (folder / self.file).write_text(study, encoding="utf-8")
        self._options, self._own_kernels, self._checkout = options, own_kernels, checkout
        self.results = folder / "results" / yaml.safe_load((folder / self.file).read_text(encoding="utf-8"))["name"]

    def copy_to(self, folder: Path) -> Self:
        """Return a copy in another folder, with results, Snakemake's metadata and kernels."""
        shutil.rmtree(folder, ignore_errors=True)
        # Keep the file times: otherwise Snakemake would run the copied steps again.
        shutil.copytree(self.folder, folder, copy_function=shutil.copy2)
        other = object.__new__(type(self))
        other.__dict__ |= vars(self) | {"folder": folder, "results": folder / self.results.relative_to(self.folder)}
        return other

    @property
    def cube_path(self) -> Path:
        """Path of the cube (NetCDF file with all outcomes of the study)."""
        return self.results / CUBE_FILE_NAME

    def subprocess_arguments(self, *options: str, file: str = CUBE_FILE_NAME) -> dict[str, Any]:
        """Return arguments of `subprocess` for the command that makes a file of the results (empty: all)."""
        environment = os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
        if self._own_kernels:
            environment["NUMBA_CACHE_DIR"] = str(self.folder / "kernels")
        if self._checkout != ROOT:
            environment["PYTHONPATH"] = str(self._checkout / "src")
        command = [sys.executable, "-m", "snakemake", "--configfile", self.file, *self._options, *options]
        wanted = ["--", str((self.results / file).relative_to(self.folder))] if file else []
        return {"args": [*command, *wanted], "cwd": self.folder, "env": environment}

    def run(self, *options: str, file: str = CUBE_FILE_NAME) -> subprocess.CompletedProcess[str]:
        """Run the Snakemake command of the study up to a result file and wait for its end."""
        return subprocess.run(
            **self.subprocess_arguments(*options, file=file), capture_output=True, text=True, timeout=_RUN_TIMEOUT_S
        )

    def start(self) -> psutil.Popen:
        """Start the Snakemake command of the study in a new process group."""
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        return psutil.Popen(**self.subprocess_arguments(), **quiet, start_new_session=True)
