"""What a whole run of the default study costs, from the records to the report, in a folder of its own."""

import resource
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Final

from verification.tables import ROOT, Figure

CORES: Final = 2
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
    spent = (after.ru_utime - before.ru_utime) + (after.ru_stime - before.ru_stime)
    return [
        Figure("default study, whole run: time on two cores", wall, "s", TARGET),
        Figure("default study, whole run: processor time", spent, "s"),
    ]
