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


class StudyWorkflowCopy:
    """Copy of the project's workflow with one study, in a folder of its own; runs the study there.

    Parameters
    ----------
    folder : Path
        Created unless it already contains the study.
    study_yaml : str
        Study as YAML; empty: the default study.
    *options : str
        Options of Snakemake, for every run.
    uses_own_kernel_cache : bool
        True: use separate compiled kernels, which may be damaged; False: use the shared ones.
    source_checkout_folder : Path
        Checkout whose workflow and package are used, with the packages of this environment.
    """

    def __init__(
        self,
        folder: Path,
        study_yaml: str = "",
        *options: str,
        uses_own_kernel_cache: bool = False,
        source_checkout_folder: Path = ROOT,
    ) -> None:
        """Copy the workflow and a study into a folder; with `uses_own_kernel_cache` kernels are cached there, too."""
        self.folder, self.file = folder, "study.yaml" if study_yaml else "config/near-fault.yaml"
        if not (folder / self.file).exists():
            folder.mkdir(parents=True, exist_ok=True)
            for name in (*WORKFLOW_FILES_AND_FOLDERS, "config"):
                copy = shutil.copytree if (source_checkout_folder / name).is_dir() else shutil.copy2
                copy(source_checkout_folder / name, folder / name)
            if study_yaml:
                (folder / self.file).write_text(study_yaml, encoding="utf-8")
        self._options, self._own_kernels, self._checkout = options, uses_own_kernel_cache, source_checkout_folder
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

    def subprocess_arguments_of_snakemake_run(
        self, *options: str, result_file_name: str = CUBE_FILE_NAME
    ) -> dict[str, Any]:
        """Return keyword arguments of `subprocess` functions for the Snakemake command that makes a result file.

        With an empty `result_file_name`, the command makes all files.
        """
        environment = os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
        if self._own_kernels:
            environment["NUMBA_CACHE_DIR"] = str(self.folder / "kernels")
        if self._checkout != ROOT:
            environment["PYTHONPATH"] = str(self._checkout / "src")
        command = [sys.executable, "-m", "snakemake", "--configfile", self.file, *self._options, *options]
        wanted = ["--", str((self.results / result_file_name).relative_to(self.folder))] if result_file_name else []
        return {"args": [*command, *wanted], "cwd": self.folder, "env": environment}

    def run(self, *options: str, result_file_name: str = CUBE_FILE_NAME) -> subprocess.CompletedProcess[str]:
        """Run the Snakemake command of the study up to a result file and wait for its end."""
        return subprocess.run(
            **self.subprocess_arguments_of_snakemake_run(*options, result_file_name=result_file_name),
            capture_output=True,
            text=True,
            timeout=_RUN_TIMEOUT_S,
        )

    def start(self) -> psutil.Popen:
        """Start the Snakemake command of the study in a new process group."""
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        return psutil.Popen(**self.subprocess_arguments_of_snakemake_run(), **quiet, start_new_session=True)
