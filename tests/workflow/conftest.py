"""Small studies in separate checkouts; plans are computed by Snakemake in this process."""

import logging
import re
import shlex
import subprocess
from collections.abc import Callable
from contextlib import chdir
from itertools import chain
from pathlib import Path
from typing import Any

import pytest

from overturning.cli import main
from overturning.study.load import load_study_from_file_or_json
from verification.project import CUBE_FILE_NAME, StudyWorkflowCopy

SMALL_STUDY = """\
name: small
question: Which way?
records: {use: [rinaldi, petrolia]}
azimuth: {step: 30, also: [32]}
b_over_h: [0.2, 0.4]
height: [0.6]
friction: [0.33, 1.0]
population: {stones: 16}
"""


class SnakemakePlanCollector(logging.Handler):
    """Logging handler that collects planned rules, commands and warnings from Snakemake's events."""

    def __init__(self) -> None:
        super().__init__()
        self.rules: frozenset[str] = frozenset()
        self.commands: list[str] = []
        self.warnings = ""

    def emit(self, record: logging.LogRecord) -> None:
        self.warnings += record.getMessage() if record.levelno == logging.WARNING else ""
        self.rules |= set(getattr(record, "stats", ())) - {"total"}
        command = getattr(record, "shellcmd", None)
        if command and command not in self.commands:  # which more than one event has
            self.commands.append(command)


class StudyWorkflowCopyWithPlanning(StudyWorkflowCopy):
    """A copy of the project's workflow with a study in a folder of its own."""

    def __init__(self, folder: Path, study: str = SMALL_STUDY, *, cores: int = 2, chunks: int = 1) -> None:
        super().__init__(folder, study, "--cores", str(cores), "--set-scatter", f"sweep={chunks}")
        self._chunks = chunks

    def run(self, *options: str, result_file_name: str = CUBE_FILE_NAME) -> subprocess.CompletedProcess[str]:
        """Run Snakemake and check that it uses the profile of the workflow."""
        done = super().run(*options, result_file_name=result_file_name)
        head, _, done.stderr = done.stderr.partition("\n")
        assert head.startswith("Using workflow specific profile profiles/default"), head
        return done

    def planned_rules(self, **config: Any) -> frozenset[str]:
        """Return the rules that a run would execute with some keys of the study changed.

        Raise the errors that would stop the run.
        """
        return self.plan(**config).rules

    def plan(self, dry_run: bool = True, file: str | None = "", **config: Any) -> SnakemakePlanCollector:
        """Return the plan of a run with some keys of the study changed; raise the errors of the run or its steps."""
        from snakemake.api import SnakemakeApi
        from snakemake.logging import logger
        from snakemake.settings import types

        found = SnakemakePlanCollector()
        with chdir(self.folder), SnakemakeApi(types.OutputSettings(dryrun=dry_run, quiet=set(types.Quietness))) as api:
            logger.handlers = [found]
            workflow = api.workflow(
                types.ResourceSettings(cores=1, overwrite_scatter={"sweep": self._chunks}),
                types.ConfigSettings(configfiles=[] if file is None else [Path(file or self.file)], config=config),
                types.StorageSettings(),
                snakefile=Path("Snakefile"),
            )
            plan = workflow.dag(types.DAGSettings(force_incomplete=True))
            plan.execute_workflow(executor="dryrun", execution_settings=types.ExecutionSettings(lock=False))
            for word in chain.from_iterable(map(shlex.split, found.commands)):
                if word.startswith("{"):  # the part of a study that a step is given must be a study
                    load_study_from_file_or_json(word)
        return found

    def execute_steps_in_this_process(self, commands: list[str]) -> None:
        """Execute the steps of a plan in this process, for tests that do not concern Snakemake itself."""
        with chdir(self.folder):
            for command in commands:
                program, *words = shlex.split(re.sub(r" 2?> .*", "", command))
                assert program == "overturning"
                for word in words:
                    if word.startswith("results/"):  # Snakemake makes the folders of what a step writes
                        Path(word).parent.mkdir(parents=True, exist_ok=True)
                with pytest.raises(SystemExit) as end:
                    main(words)
                assert end.value.code == 0, command


def reproducible_result_file_contents(results: Path) -> dict[str, bytes]:
    """Return the contents of results by path, except logs, run times, partial cubes and motions not yet labelled."""
    return {
        str(path.relative_to(results)): path.read_bytes()
        for path in sorted(results.rglob("*"))
        if path.is_file()
        and path.name[0] != "."
        and path.suffix not in {".log", ".tsv"}
        and not {"sweep", "read"} & set(path.parts)
    }


@pytest.fixture(scope="session")
def checkout_with_finished_run(
    make_folder_once: Callable[[str, Callable[[Path], object]], Path],
) -> StudyWorkflowCopyWithPlanning:
    """A study computed on two cores, in two chunks of each record. Tests must not change it."""

    def run_workflow_of_small_study_in_two_chunks(folder: Path) -> None:
        done = StudyWorkflowCopyWithPlanning(folder, chunks=2).run(result_file_name="")
        assert done.returncode == 0, done.stdout + done.stderr
        assert "results/small/report.html" in done.stdout

    return StudyWorkflowCopyWithPlanning(make_folder_once("study", run_workflow_of_small_study_in_two_chunks), chunks=2)
