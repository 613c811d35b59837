"""Run times: into a table of their own, since a cube must be the same each time it is made."""

import csv
import platform
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from overturning.errors import ResultError
from overturning.files import atomic_write


@contextmanager
def timed(path: Path) -> Iterator[dict[str, Any]]:
    """Measure a block of code and write a table (CSV) of one row; the block fills in the further columns yielded."""
    row: dict[str, Any] = {}
    wall, cpu = time.perf_counter(), time.process_time()
    yield row
    row |= {
        "wall_s": round(time.perf_counter() - wall, 3),
        "cpu_s": round(time.process_time() - cpu, 3),
        "processor": _processor(),
    }
    with atomic_write(path) as part, part.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, list(row), lineterminator="\n")
        table.writeheader()
        table.writerow(row)


def join_timings(paths: Sequence[Path], output: Path) -> None:
    """Join the rows of tables that `timed` wrote into one table; a `ResultError` where one has no row."""
    lines: list[str] = []
    for path in paths:
        head, *rows = path.read_text(encoding="utf-8").splitlines() or [""]
        if not rows:
            raise _no_timing(path)
        lines += rows if lines else [head, *rows]
    with atomic_write(output) as part:
        part.write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")


def block_steps_of(path: Path) -> int:
    """Block steps in a table that `timed` wrote; the one column that is the same for every run.

    Raises
    ------
    ResultError
        If the file is no such table.
    """
    try:
        with path.open(encoding="utf-8", newline="") as file:
            steps = [int(row["block_steps"]) for row in csv.DictReader(file)]
        if not steps:
            raise ValueError("no row")
    except (OSError, KeyError, TypeError, ValueError):
        raise _no_timing(path) from None
    return sum(steps)


def _no_timing(path: Path) -> ResultError:
    return ResultError(f"{path}: damaged, or no table of run times; run again, which makes it anew")


def _processor() -> str:
    try:
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
