"""Cost of a complete run of the default study, from the records to the report, in a separate folder."""

import csv
import resource
import tempfile
import time
from pathlib import Path
from typing import Final

from verification.project import Project
from verification.tables import MeasuredFigure

CORES: Final = 2
LONG: Final = 10.0
"""Rules whose jobs take at least this time in total, s, are listed."""


def measure_whole_run() -> list[MeasuredFigure]:
    """Measure elapsed and processor time with compiled kernels; ensemble, figures and report take most of it."""
    with tempfile.TemporaryDirectory() as scratch:
        project = Project(Path(scratch), "", "--cores", str(CORES))
        before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        project.run(file="").check_returncode()
        wall, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
        longest = job_times(project.results / "benchmarks")
    spent = (after.ru_utime - before.ru_utime) + (after.ru_stime - before.ru_stime)
    return [
        MeasuredFigure("default study, whole run: time on two cores", wall, "s"),
        MeasuredFigure("default study, whole run: processor time", spent, "s"),
        *(
            MeasuredFigure(
                f"default study, whole run: {count} job{'s'[: count > 1]} of `{rule}`, together", seconds, "s"
            )
            for rule, (count, seconds) in longest.items()
            if seconds >= LONG
        ),
    ]


def job_times(benchmarks: Path) -> dict[str, tuple[int, float]]:
    """Return number and total time, s, of the jobs of each rule, as measured by Snakemake, longest first."""
    found: dict[str, tuple[int, float]] = {}
    for path in benchmarks.rglob("*.tsv"):
        rule = path.relative_to(benchmarks).parts[0].partition(".")[0]
        with path.open(encoding="utf-8", newline="") as file:
            seconds = sum(float(row["s"]) for row in csv.DictReader(file, delimiter="\t"))
        count, before = found.get(rule, (0, 0.0))
        found[rule] = count + 1, before + seconds
    return dict(sorted(found.items(), key=lambda one: -one[1][1]))
