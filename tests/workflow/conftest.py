"""Small studies, each in a checkout of its own; questions about plans are asked of Snakemake in this process."""

import logging
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable
from contextlib import chdir
from pathlib import Path
from typing import Any

import pytest

from overturning.cli import main
from overturning.commands.init import WORKFLOW

ROOT = Path(__file__).parents[2]
SMALL = """\
name: small
question: Which way?
records: {use: [rinaldi, petrolia]}
azimuth: {step: 30, also: [32]}
b_over_h: [0.2, 0.4]
height: [0.6]
friction: [0.33, 1.0]
figures: {formats: [svg]}
"""


class Plan(logging.Handler):
    """Takes from Snakemake's events which rules it would carry out, and by which commands."""

    def __init__(self) -> None:
        super().__init__()
        self.rules: frozenset[str] = frozenset()
        self.commands: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.rules |= set(getattr(record, "stats", ())) - {"total"}
        command = getattr(record, "shellcmd", None)
        if command and command not in self.commands:  # which more than one event has
            self.commands.append(command)


class Checkout:
    """A copy of the project's workflow in a folder of its own."""

    def __init__(self, folder: Path, config: str = SMALL, like: "Checkout | None" = None) -> None:
        self.folder = folder
        if like is not None:  # as old as that one is
            shutil.copytree(like.folder, folder, copy_function=shutil.copy2)
        elif not folder.exists():
            folder.mkdir(parents=True)
            for name in (*WORKFLOW, "config"):
                copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy2
                copy(ROOT / name, folder / name)
        if not (folder / "results").exists():
            (folder / "config" / "mine.yaml").write_text(config, encoding="utf-8")
        self.environment = os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}

    @property
    def results(self) -> Path:
        return self.folder / "results" / "small"

    def command(self, *arguments: str, cores: int = 2) -> list[str]:
        """That of `make run`."""
        words = ["-m", "snakemake", "--cores", str(cores), "--configfile", "config/mine.yaml"]
        return [sys.executable, *words, *arguments]

    def run(self, *arguments: str, cores: int = 2, check: bool = True) -> subprocess.CompletedProcess[str]:
        done = subprocess.run(
            self.command(*arguments, cores=cores),
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=1200,  # so that nothing hangs, however busy the machine
            check=False,
        )
        head, _, done.stderr = done.stderr.partition("\n")
        assert head.startswith("Using workflow specific profile profiles/default"), head
        if check:
            assert done.returncode == 0, done.stdout + done.stderr
        return done

    def planned(self, **config: Any) -> frozenset[str]:
        """Rules that a run would carry out with some keys of the study changed; raises what would stop it."""
        return self.plan(**config).rules

    def plan(self, look: bool = True, **config: Any) -> Plan:
        """What a run would do with some keys of the study changed; raises what would stop it, or who only looks."""
        from snakemake.api import SnakemakeApi
        from snakemake.logging import logger
        from snakemake.settings import types

        found = Plan()
        with chdir(self.folder), SnakemakeApi(types.OutputSettings(dryrun=look, quiet=set(types.Quietness))) as api:
            logger.handlers = [found]
            workflow = api.workflow(
                types.ResourceSettings(cores=1),
                types.ConfigSettings(configfiles=[Path("config/mine.yaml")], config=config),
                types.StorageSettings(notemp=True),
                snakefile=Path("Snakefile"),
            )
            plan = workflow.dag(types.DAGSettings(force_incomplete=True))
            plan.execute_workflow(executor="dryrun", execution_settings=types.ExecutionSettings(lock=False))
        return found

    def run_here(self) -> None:
        """Carry out the steps of the plan in this process, where Snakemake itself is not the question."""
        commands = self.plan().commands
        with chdir(self.folder):
            for command in commands:
                program, *words = shlex.split(re.sub(r" 2?> .*", "", command))
                assert program == "overturning"
                with pytest.raises(SystemExit) as end:
                    main(words)
                assert end.value.code == 0, command


@pytest.fixture(scope="session")
def finished(made_once: Callable[[str, Callable[[Path], object]], Path]) -> Checkout:
    """A study computed on two cores, from start to end. Tests must not change it."""
    return Checkout(made_once("study", lambda folder: Checkout(folder).run(cores=2)))
