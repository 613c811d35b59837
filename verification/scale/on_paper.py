"""Extrapolation to a study of 10,000 records with a million cases each, from measured figures."""

import json
import resource
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from verification.project import StudyWorkflowCopy
from verification.scale.large import ResourceUse, run_program_and_measure_resource_use
from verification.tables import MeasuredNumber

EXTRAPOLATED_RECORD_COUNT: Final = 10_000
EXTRAPOLATED_CASE_COUNT_PER_RECORD: Final = 1_000_000
EXTRAPOLATED_CHUNK_COUNT_PER_RECORD: Final = 8
MAX_COMMAND_ARGUMENT_BYTES: Final = 32 * resource.getpagesize()
"""Largest argument of a command, bytes (Linux: MAX_ARG_STRLEN); the command of a rule is one argument."""


QUANTITIES_NEEDED_TO_EXTRAPOLATE: Final = {
    *("real chunk: processor time", "real chunk: cases", "real chunk: disk per case"),
    *("synthetic parts: gathering", "synthetic parts: cases", "synthetic cube: cells", "synthetic cube: report, time"),
    *("synthetic cube: figures of all records together, time", "synthetic cube: figures of a record, time"),
    *(f"planning: {name} per record, {EXTRAPOLATED_CHUNK_COUNT_PER_RECORD} chunks each" for name in ("time", "memory")),
}
"""Figures that the extrapolation needs."""


def measure_planning_of_study(record_count: int) -> ResourceUse:
    """Let Snakemake plan a study of `record_count` synthetic records, and measure its longest command."""
    with tempfile.TemporaryDirectory(prefix="scale-") as name:
        pulses = {
            f"record-{number:05d}": f"sine amplitude_gal={300 + number} period_s=1 azimuth_deg=60"
            for number in range(record_count)
        }
        # Few cases of each, which planning does not count, so that the disk would hold them.
        study = {"name": "scale", "records": {"pulses": pulses}, "verification": "none", "b_over_h": [0.3]}
        project = StudyWorkflowCopy(Path(name) / "project", json.dumps(study), "--dry-run", "--printshellcmds")
        how = project.subprocess_arguments_of_snakemake_run(
            "--set-scatter", f"sweep={EXTRAPOLATED_CHUNK_COUNT_PER_RECORD}", result_file_name=""
        )
        return run_program_and_measure_resource_use(
            **how, prefix_of_lines_to_find_longest=b"Shell command: ", stderr=subprocess.DEVNULL
        )


def measure_planning_per_record_and_longest_command(
    small_record_count: int = 20, large_record_count: int = 220
) -> list[MeasuredNumber]:
    """Measure time and memory of planning per additional record, from two studies, and the longest command."""
    less, more = measure_planning_of_study(small_record_count), measure_planning_of_study(large_record_count)
    per_record = {
        "time": ((more.elapsed_time_s - less.elapsed_time_s) / (large_record_count - small_record_count), "s"),
        "memory": ((more.peak_memory_mb - less.peak_memory_mb) / (large_record_count - small_record_count), "MB"),
    }
    each = [
        MeasuredNumber(f"planning: {name} per record, {EXTRAPOLATED_CHUNK_COUNT_PER_RECORD} chunks each", *value)
        for name, value in per_record.items()
    ]
    label = (
        f"planning: longest command, {large_record_count} records in {EXTRAPOLATED_CHUNK_COUNT_PER_RECORD} chunks each"
    )
    return [*each, MeasuredNumber(label, more.longest_selected_output_line_bytes, "bytes")]


def extrapolate_resources_to_large_study(measured_number_by_quantity: Mapping[str, float]) -> list[MeasuredNumber]:
    """Return the resources that a far larger study needs, extrapolated from measured numbers.

    The measured numbers come from the functions of `verification.scale.large` and from
    `measure_planning_per_record_and_longest_command`.
    """
    cases = EXTRAPOLATED_RECORD_COUNT * EXTRAPOLATED_CASE_COUNT_PER_RECORD
    per_case = (
        measured_number_by_quantity["real chunk: processor time"] / measured_number_by_quantity["real chunk: cases"]
    )
    gathering = (
        measured_number_by_quantity["synthetic parts: gathering"]
        / measured_number_by_quantity["synthetic parts: cases"]
    )
    disk = measured_number_by_quantity["real chunk: disk per case"]
    planning = (
        measured_number_by_quantity[f"planning: time per record, {EXTRAPOLATED_CHUNK_COUNT_PER_RECORD} chunks each"]
        * EXTRAPOLATED_RECORD_COUNT
    )
    memory = (
        measured_number_by_quantity[f"planning: memory per record, {EXTRAPOLATED_CHUNK_COUNT_PER_RECORD} chunks each"]
        * EXTRAPOLATED_RECORD_COUNT
    )
    reports = (
        measured_number_by_quantity["synthetic cube: report, time"]
        + measured_number_by_quantity["synthetic cube: figures of all records together, time"]
    )
    reports = (
        reports / measured_number_by_quantity["synthetic cube: cells"]
        + measured_number_by_quantity["synthetic cube: figures of a record, time"] / EXTRAPOLATED_CASE_COUNT_PER_RECORD
    )
    # Per chunk: a part, a benchmark and logs; per record: a motion, one to three figures, and their logs.
    files = EXTRAPOLATED_RECORD_COUNT * (EXTRAPOLATED_CHUNK_COUNT_PER_RECORD * 3 + 7)
    return [
        MeasuredNumber("cases", cases),
        MeasuredNumber("sweep: core hours", per_case * cases / 3600, "h"),
        MeasuredNumber("sweep: jobs", EXTRAPOLATED_RECORD_COUNT * EXTRAPOLATED_CHUNK_COUNT_PER_RECORD),
        MeasuredNumber("storage of parts, or of the cube", disk * cases / 1e9, "GB"),
        MeasuredNumber("files", files),
        MeasuredNumber("gathering, one process", gathering * cases / 3600, "h"),
        MeasuredNumber("figures and report, one process", reports * cases / 3600, "h"),
        MeasuredNumber("Snakemake: planning before the first job", planning / 3600, "h"),
        MeasuredNumber("Snakemake: memory", memory / 1000, "GB"),
    ]
