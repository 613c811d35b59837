"""What a whole run of the default study costs, from the records to the report, in a folder of its own."""

import re
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from datetime import datetime
from pathlib import Path
from typing import Final

from verification.tables import ROOT, Figure

CORES: Final = 2
LONG: Final = 10.0
"""Seconds from which the jobs of a rule are shown."""

TARGET: Final = "<= 75"
"""Seconds that it may take on two cores."""


def whole_run() -> list[Figure]:
    """Time and processor time, kernels compiled before; the ensemble, figures and report are most of it."""
    with tempfile.TemporaryDirectory() as scratch:
        for name in ("workflow", "config"):
            shutil.copytree(ROOT / name, Path(scratch) / name)
        before, begin = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
        command = [sys.executable, "workflow/scripts/run.py", "--cores", str(CORES)]
        subprocess.run(command, cwd=scratch, check=True, stdout=subprocess.DEVNULL)
        wall, after = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_CHILDREN)
        longest = job_times((Path(scratch) / ".snakemake" / "run.log").read_text(encoding="utf-8"))
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


def job_times(talk: str) -> dict[str, tuple[int, float]]:
    """Number and time, s, of the jobs of each rule, from what Snakemake said; the longest first."""
    now, rule = datetime.min, ""
    begun: dict[str, tuple[str, datetime]] = {}
    found: dict[str, tuple[int, float]] = {}
    for line in talk.splitlines():
        if clock := re.fullmatch(r"\[(\w+ \w+ +\d+ [\d:]+ \d+)\]", line):
            now = datetime.strptime(clock[1], "%a %b %d %H:%M:%S %Y")
        elif name := re.fullmatch(r"(?:local)?rule (\w+):", line):
            rule = name[1]
        elif job := re.fullmatch(r"    jobid: (\d+)", line):
            begun[job[1]] = rule, now
        elif job := re.match(r"Finished jobid: (\d+)", line):
            name_of, start = begun[job[1]]
            count, seconds = found.get(name_of, (0, 0.0))
            found[name_of] = count + 1, seconds + (now - start).total_seconds()
    return dict(sorted(found.items(), key=lambda one: -one[1][1]))
