"""Whole small studies, each in a checkout of its own."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

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


class Checkout:
    """A copy of the project's workflow in a folder of its own."""

    def __init__(self, folder: Path, config: str = SMALL, own_sources: bool = False) -> None:
        self.folder = folder
        for name in ("workflow", "config"):
            shutil.copytree(ROOT / name, folder / name)  # makes the folder too
        (folder / "config" / "mine.yaml").write_text(config, encoding="utf-8")
        self.environment = os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
        if own_sources:
            shutil.copytree(ROOT / "src", folder / "src", ignore=shutil.ignore_patterns("__pycache__"))
            self.environment["PYTHONPATH"] = str(folder / "src")

    @property
    def results(self) -> Path:
        return self.folder / "results" / "small"

    def command(self, *arguments: str, cores: int = 2) -> list[str]:
        return [
            sys.executable,
            "workflow/scripts/run.py",
            "--cores",
            str(cores),
            "--configfile",
            "config/mine.yaml",
            *arguments,
        ]

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
        if check:
            assert done.returncode == 0, done.stdout + done.stderr
        return done

    def planned(self, *arguments: str) -> set[str]:
        """Rules that a run would carry out."""
        text = self.run("--dry-run", "--quiet", "host", *arguments).stdout
        return {line.split()[1].rstrip(":") for line in text.splitlines() if line.startswith(("rule ", "localrule "))}


@pytest.fixture(scope="session")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Checkout:
    """A study computed on two cores, from start to end. Tests must not change it."""
    checkout = Checkout(tmp_path_factory.mktemp("finished") / "checkout")
    checkout.run(cores=2)
    return checkout
