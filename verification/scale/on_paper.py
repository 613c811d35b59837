"""What a study of ten thousand records and a million cases each would take, worked out from what was measured."""

import json
import resource
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from verification.project import Project
from verification.scale.large import Taken, taken_by
from verification.tables import Figure

RECORDS: Final = 10_000
CASES: Final = 1_000_000
CHUNKS: Final = 8
LONGEST_ARGUMENT: Final = 32 * resource.getpagesize()
"""Bytes of one argument of a command (Linux: MAX_ARG_STRLEN); a rule's whole command is one."""


NEEDED: Final = {
    *("real chunk: processor time", "real chunk: cases", "real chunk: disk per case"),
    *("made parts: gathering", "made parts: cases", "made cube: cells", "made cube: report, time"),
    *("made cube: figures of all records together, time", "made cube: figures of a record, time"),
    *(f"planning: {name} per record, {CHUNKS} chunks each" for name in ("time", "memory")),
}
"""What must have been measured for it."""


def planned(records: int) -> Taken:
    """Plan a study of so many records, each the same file under a name of its own, and measure its longest command."""
    with tempfile.TemporaryDirectory(prefix="scale-") as name:
        names = [f"record-{number:05d}" for number in range(records)]
        # Few cases of each, which planning does not count, so that the disk would hold them.
        study = {"name": "scale", "records": {"use": names}, "verification": "none", "b_over_h": [0.3]}
        project = Project(Path(name) / "project", json.dumps(study), "--dry-run", "--printshellcmds")
        table = project.folder / "config" / "records.tsv"
        head, *rows = table.read_text(encoding="utf-8").splitlines()
        one = next(row for row in rows if row.startswith("rinaldi\t"))
        made = [one.replace("rinaldi", each, 1) for each in names]
        table.write_text("\n".join([head, *made]) + "\n", encoding="utf-8")
        how = project.how("--set-scatter", f"sweep={CHUNKS}", file="")
        return taken_by(**how, begins=b"Shell command: ", stderr=subprocess.DEVNULL)


def measure_planning(few: int = 20, many: int = 220) -> list[Figure]:
    """Time and memory that a record more takes Snakemake to plan, from two studies; the larger's longest command."""
    less, more = planned(few), planned(many)
    per_record = {
        "time": ((more.seconds - less.seconds) / (many - few), "s"),
        "memory": ((more.memory_mb - less.memory_mb) / (many - few), "MB"),
    }
    each = [Figure(f"planning: {name} per record, {CHUNKS} chunks each", *value) for name, value in per_record.items()]
    said = f"planning: longest command, {many} records in {CHUNKS} chunks each"
    return [*each, Figure(said, more.longest, "bytes")]


def on_paper(measured: Mapping[str, float]) -> list[Figure]:
    """The large study, by quantities of `large` and of `measure_planning`."""
    cases = RECORDS * CASES
    per_case = measured["real chunk: processor time"] / measured["real chunk: cases"]
    gathering = measured["made parts: gathering"] / measured["made parts: cases"]
    disk = measured["real chunk: disk per case"]
    planning = measured[f"planning: time per record, {CHUNKS} chunks each"] * RECORDS
    memory = measured[f"planning: memory per record, {CHUNKS} chunks each"] * RECORDS
    reports = measured["made cube: report, time"] + measured["made cube: figures of all records together, time"]
    reports = reports / measured["made cube: cells"] + measured["made cube: figures of a record, time"] / CASES
    # One file of part and of run time per chunk, two logs; a motion, a figure or three, and their logs, per record.
    files = RECORDS * (CHUNKS * 3 + 7)
    return [
        Figure("cases", cases),
        Figure("sweep: core hours", per_case * cases / 3600, "h"),
        Figure("sweep: jobs", RECORDS * CHUNKS),
        Figure("storage of parts, or of the cube", disk * cases / 1e9, "GB"),
        Figure("files", files),
        Figure("gathering, one process", gathering * cases / 3600, "h"),
        Figure("figures and report, one process", reports * cases / 3600, "h"),
        Figure("Snakemake: planning before the first job", planning / 3600, "h"),
        Figure("Snakemake: memory", memory / 1000, "GB"),
    ]
