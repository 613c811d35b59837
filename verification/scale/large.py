"""Resource use of large studies: a chunk of a sweep, gathering, statistics and figures, each in a separate process."""

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Final, NamedTuple

from overturning.study.ensemble_members import draw_parameter_changes_of_members
from verification.scale.made import (
    synthetic_study,
    write_study_as_json,
    write_synthetic_cube,
    write_synthetic_motions,
    write_synthetic_partial_results,
)
from verification.tables import MeasuredNumber

ASSUMED_SNAKEMAKE_MEMORY_MB: Final = 250.0
"""Memory assumed for Snakemake itself, MB."""


class ResourceUse(NamedTuple):
    """Elapsed and processor time, s, and peak memory, MB, of a process.

    If output lines with some prefix were selected, also the length of the longest one.
    """

    elapsed_time_s: float
    processor_time_s: float
    peak_memory_mb: float  # largest resident set
    longest_selected_output_line_bytes: int = 0  # bytes of the longest selected line of its output


def run_overturning_command_and_measure_resources(*command: object) -> ResourceUse:
    """Run a subcommand of the package and return its resource use."""
    return run_program_and_measure_resource_use([sys.executable, "-m", "overturning.cli", *map(str, command)])


def run_program_and_measure_resource_use(
    args: list[str], prefix_of_lines_to_find_longest: bytes = b"", **popen_arguments: Any
) -> ResourceUse:
    """Run a program; return its resource use, with the length of the longest output line that has a given prefix.

    The prefix is `prefix_of_lines_to_find_longest`. `args` and `popen_arguments` are passed to `subprocess.Popen`.
    Raises a RuntimeError if the program fails.
    """
    begin = time.perf_counter()
    process = subprocess.Popen(args, stdout=subprocess.PIPE, **popen_arguments)
    assert process.stdout
    longest = max(
        (
            len(line)
            for line in process.stdout
            if prefix_of_lines_to_find_longest and line.startswith(prefix_of_lines_to_find_longest)
        ),
        default=0,
    )
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        raise RuntimeError(f"{args[-1]} failed")
    return ResourceUse(time.perf_counter() - begin, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024, longest)


def measure_simulation_of_case_chunk(folder: Path, chunk_count_of_record: int = 8) -> list[MeasuredNumber]:
    """Measure time, memory and disk use of simulating a chunk of cases, with their ensemble, under a real record.

    By default, the chunk has 1/8 million cases.
    """
    study = synthetic_study(1)
    write_study_as_json(study, folder / "study.json")
    own = study.model_copy(update={"records": study.records.model_copy(update={"use": ("rinaldi",)})})
    write_study_as_json(own, folder / "own.json")
    run_overturning_command_and_measure_resources(
        "read", "--study", folder / "own.json", "--record", "rinaldi", "--output", folder / "motion.nc"
    )
    draw_parameter_changes_of_members(study.ensemble).write_csv(folder / "members.csv")
    part = folder / f"rinaldi.1-of-{chunk_count_of_record}.nc"
    took = run_overturning_command_and_measure_resources(
        "sweep", "--study", folder / "study.json", "--motion", folder / "motion.nc", "--output", part,
        "--members", folder / "members.csv", "--chunk", f"1-of-{chunk_count_of_record}",
    )  # fmt: skip
    cases = study.cases_per_record / chunk_count_of_record
    return [
        MeasuredNumber("real chunk: cases", cases),
        MeasuredNumber("real chunk: processor time", took.processor_time_s, "s"),
        MeasuredNumber("real chunk: peak memory of its process", took.peak_memory_mb, "MB"),
        MeasuredNumber("two such processes and Snakemake", 2 * took.peak_memory_mb + ASSUMED_SNAKEMAKE_MEMORY_MB, "MB"),
        MeasuredNumber("real chunk: disk per case", part.stat().st_size / cases, "bytes"),
    ]


def measure_merging_of_parts_into_cube(
    folder: Path,
    record_count: int = 10,
    chunk_count_per_record: int = 8,
    grid_settings: dict[str, object] | None = None,
) -> list[MeasuredNumber]:
    """Measure time, memory and disk use of merging synthetic results of chunks, by default of ten million cases."""
    study = synthetic_study(record_count, grid_settings)
    write_study_as_json(study, folder / "study.json")
    write_synthetic_motions(study, folder / "motion")
    parts = write_synthetic_partial_results(study, folder / "sweep", chunk_count_per_record)
    took = run_overturning_command_and_measure_resources(
        "gather", "--study", folder / "study.json", "--motions", folder / "motion", "--parts", folder / "sweep",
        "--chunks", chunk_count_per_record, "--output", folder / "cube.nc",
    )  # fmt: skip
    cases = record_count * study.cases_per_record
    of_parts, of_cube = sum(part.stat().st_size for part in parts), (folder / "cube.nc").stat().st_size
    return [
        MeasuredNumber("synthetic parts: cases", cases),
        MeasuredNumber("synthetic parts: gathering", took.elapsed_time_s, "s"),
        MeasuredNumber("synthetic parts: peak memory of gathering", took.peak_memory_mb, "MB"),
        MeasuredNumber("synthetic parts and their cube: disk per case", (of_parts + of_cube) / cases, "bytes"),
        MeasuredNumber("synthetic cube alone: disk per case", of_cube / cases, "bytes"),
    ]


def measure_report_on_cube_larger_than_memory(
    folder: Path,
    record_count: int = 100,
    grid_settings: dict[str, object] | None = None,
    cube_label: str = "synthetic cube",
) -> list[MeasuredNumber]:
    """Measure time and memory of statistics, figures and report of a synthetic cube larger than memory.

    `cube_label` begins the names of the measured numbers.
    """
    study = synthetic_study(record_count, grid_settings)
    write_study_as_json(study, folder / "study.json")
    write_synthetic_motions(study, folder / "motion")
    write_synthetic_cube(study, folder / "cube.nc", distinct_record_count=min(2, record_count))
    draw_parameter_changes_of_members(study.ensemble).write_csv(folder / "members.csv")
    base = ("--study", folder / "study.json", "--motions", folder / "motion")
    size = (folder / "cube.nc").stat().st_size
    found = [
        MeasuredNumber(f"{cube_label}: cells", record_count * study.cases_per_record),
        MeasuredNumber(f"{cube_label}: size", size / 1e9, "GB"),
    ]

    def append_measured_time_and_memory_of_process(process_label: str, resource_use: ResourceUse) -> None:
        """Add time and peak memory of a process to the measured figures."""
        found.append(MeasuredNumber(f"{cube_label}: {process_label}, time", resource_use.elapsed_time_s, "s"))
        found.append(MeasuredNumber(f"{cube_label}: {process_label}, peak memory", resource_use.peak_memory_mb, "MB"))

    append_measured_time_and_memory_of_process(
        "intensities",
        run_overturning_command_and_measure_resources("rotate", *base, "--output", folder / "intensity.nc"),
    )
    for what, call in (
        (
            "figures of a record",
            "record import draw_record_figures; draw_record_figures(cube, intensity, figures, write, [0])",
        ),
        (
            "figures of all records together",
            "study import draw_study_figures; draw_study_figures(cube, intensity, figures, write)",
        ),
    ):
        program = f"""
from functools import partial
from pathlib import Path
from overturning.figures.write import write_figure_and_delete_files_in_other_formats
from overturning.study.load import load_study_from_file_or_json
folder = Path({str(folder)!r})
cube, intensity, motions, figures = (folder / name for name in ("cube.nc", "intensity.nc", "motion", "figures"))
figure_settings = load_study_from_file_or_json(str(folder / "study.json")).figures
write = partial(write_figure_and_delete_files_in_other_formats, figure_settings)
from overturning.figures.{call}
"""
        append_measured_time_and_memory_of_process(
            what, run_program_and_measure_resource_use([sys.executable, "-c", program])
        )
    drawn_cases = folder / "figures" / "illustrative"
    append_measured_time_and_memory_of_process(
        "illustrative cases",
        run_overturning_command_and_measure_resources(
            "illustrative", "--cube", folder / "cube.nc", *base[2:], "--output", drawn_cases
        ),
    )
    # The report needs figures of each record: copy those of the first.
    for drawn in list((folder / "figures").glob(f"*/{study.records.use[0]}.*")):
        for name in study.records.use[1:]:
            shutil.copy(drawn, drawn.with_name(f"{name}{drawn.suffix}"))
    append_measured_time_and_memory_of_process(
        "findings",
        run_overturning_command_and_measure_resources(
            "findings", folder / "cube.nc", "--output", folder / "findings.json"
        ),
    )
    append_measured_time_and_memory_of_process(
        "report",
        run_overturning_command_and_measure_resources(
            "report", "--results", folder, "--output", folder / "report.html"
        ),
    )
    return found
