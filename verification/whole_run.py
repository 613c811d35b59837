"""What a whole run of the default study costs, from the records to the report, in a folder of its own."""

import csv
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Final

from overturning.commands.init import WORKFLOW
from verification.tables import ROOT, Figure

CORES: Final = 2
LONG: Final = 10.0
"""Seconds from which the jobs of a rule are shown."""

TARGET: Final = "<= 75"
"""Seconds that it may take on two cores."""


def whole_run() -> list[Figure]:
    """Time and processor time, kernels compiled before; the ensemble, figures and report are most of it."""
    with tempfile.TemporaryDirectory() as scratch:
        copy_project(Path(scratch))
        before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        command = [sys.executable, "-m", "snakemake", "--cores", str(CORES)]
        subprocess.run(command, cwd=scratch, check=True, stdout=subprocess.DEVNULL)
        wall, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
        longest = job_times(Path(scratch, "results", "near-fault", "benchmarks"))
    spent = (after.ru_utime - before.ru_utime) + (after.ru_stime - before.ru_stime)
    return [
        Figure("default study, whole run: time on two cores", wall, "s", TARGET),
        Figure("default study, whole run: processor time", spent, "s"),
        *(
            Figure(f"default study, whole run: {count} job{'s'[: count > 1]} of `{rule}`, together", seconds, "s")
            for rule, (count, seconds) in longest.items()
            if seconds >= LONG
        ),
    ]


def copy_project(folder: Path) -> None:
    """Make a folder with all that the workflow needs."""
    folder.mkdir(parents=True, exist_ok=True)
    for name in (*WORKFLOW, "config"):
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy2
        copy(ROOT / name, folder / name)


def job_times(benchmarks: Path) -> dict[str, tuple[int, float]]:
    """Number and time, s, of the jobs of each rule, from what Snakemake measured; the longest first."""
    found: dict[str, tuple[int, float]] = {}
    for path in benchmarks.rglob("*.tsv"):
        rule = path.relative_to(benchmarks).parts[0].partition(".")[0]
        with path.open(encoding="utf-8", newline="") as file:
            seconds = sum(float(row["s"]) for row in csv.DictReader(file, delimiter="\t"))
        count, before = found.get(rule, (0, 0.0))
        found[rule] = count + 1, before + seconds
    return dict(sorted(found.items(), key=lambda one: -one[1][1]))
