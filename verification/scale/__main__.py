"""`make scale`: measure large studies and write the tables of docs/scale.md."""

import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import pandas as pd
import typer

from verification.scale import large, on_paper, same_bytes
from verification.scale.made import MILLION_CASE_3D_STUDY_SETTINGS
from verification.tables import (
    RESULT_TABLE_FOLDER,
    MeasuredNumber,
    iterate_rows,
    markdown_table,
    measured_numbers_table,
    named_parts_or_all_if_none,
    read_measured_numbers,
    update_marked_tables_and_sentences_in_docs,
    write_csv,
    write_measured_numbers,
)

SELECTABLE_PARTS = ("bytes", "slurm", "chunk", "gather", "lazy", "lazy-space", "planning")
MEASURED_NUMBERS_FILE = RESULT_TABLE_FOLDER / "scale.csv"
RUN_TIMES_AND_RESULT_HASHES_TABLE_FILE = RESULT_TABLE_FOLDER / "scale-bytes.csv"


def main(
    parts: Annotated[
        list[str] | None, typer.Argument(help=f"{', '.join(SELECTABLE_PARTS)}; all where none is named")
    ] = None,
    records: Annotated[int, typer.Option(help="records, of a million cases each, in the synthetic cubes")] = 100,
) -> None:
    """Measure the chosen parts, by default all, store their numbers, and publish the tables of all stored numbers."""
    chosen = named_parts_or_all_if_none(parts, SELECTABLE_PARTS)
    if {"bytes", "slurm"} & set(chosen):
        runs = same_bytes.run_study_in_every_local_way() if "bytes" in chosen else []
        if "slurm" in chosen:
            runs += same_bytes.run_study_on_slurm(
                result_file_name_of_each_run=(same_bytes.CUBE_FILE_NAME, same_bytes.REPORT_FILE_NAME)
            )
        update_marked_tables_and_sentences_in_docs(
            {"scale-bytes": table_of_runs_and_result_hashes(merge_with_stored_runs_and_store(runs))}
        )
    measures: dict[str, Callable[[Path], list[MeasuredNumber]]] = {
        "chunk": large.measure_simulation_of_case_chunk,
        "gather": large.measure_merging_of_parts_into_cube,
        "lazy": lambda folder: large.measure_report_on_cube_larger_than_memory(folder, records),
        "lazy-space": lambda folder: large.measure_report_on_cube_larger_than_memory(
            folder, records, MILLION_CASE_3D_STUDY_SETTINGS, "synthetic cube in space"
        ),
        "planning": lambda _: on_paper.measure_planning_per_record_and_longest_command(),
    }
    for name, measure in measures.items():
        if name in chosen:
            with tempfile.TemporaryDirectory(prefix="scale-") as folder:
                write_measured_numbers(measure(Path(folder)), MEASURED_NUMBERS_FILE, keep_other_stored_numbers=True)
    figures = read_measured_numbers(MEASURED_NUMBERS_FILE)
    update_marked_tables_and_sentences_in_docs({"scale": measured_numbers_table(figures)})
    if {one.quantity for one in figures} >= on_paper.QUANTITIES_NEEDED_TO_EXTRAPOLATE:
        update_marked_tables_and_sentences_in_docs({"scale-on-paper": extrapolated_resource_table(figures)})


def merge_with_stored_runs_and_store(
    runs: list[same_bytes.StudyRunTimeAndResultHash],
) -> list[same_bytes.StudyRunTimeAndResultHash]:
    """Store runs with the earlier stored ones, replacing those that were repeated; return all runs."""
    known = {(run.way, run.requested_result_file): run for run in runs}
    if RUN_TIMES_AND_RESULT_HASHES_TABLE_FILE.is_file():
        old = [
            same_bytes.StudyRunTimeAndResultHash(*row)
            for row in iterate_rows(pd.read_csv(RUN_TIMES_AND_RESULT_HASHES_TABLE_FILE))
        ]
        known = {(run.way, run.requested_result_file): run for run in old} | known
    write_csv(pd.DataFrame(list(known.values())), RUN_TIMES_AND_RESULT_HASHES_TABLE_FILE)
    return list(known.values())


def table_of_runs_and_result_hashes(runs: list[same_bytes.StudyRunTimeAndResultHash]) -> str:
    """Return a table of runs of one study in several ways (cores, cluster): time, result file and its hash."""
    cores = len(os.sched_getaffinity(0))
    first = {run.requested_result_file: run.sha256_of_result for run in reversed(runs)}
    rows = []
    for run in sorted(runs, key=lambda run: run.requested_result_file):
        same = "yes" if run.sha256_of_result == first[run.requested_result_file] else "**no**"
        file, sha256 = run.requested_result_file, run.sha256_of_result
        rows.append((run.way, f"{run.run_time_s:.0f}", f"`{file}`", f"`{sha256[:16]}`", same))
    table = markdown_table(("run", "time, s", "file", "SHA-256", "same bytes"), rows)
    return f"{table}\n\nMeasured with {cores} core{'s' * (cores > 1)} available."


def extrapolated_resource_table(measured_numbers: list[MeasuredNumber]) -> str:
    """Return the table of the resources that a study too large for this machine would need, by extrapolation."""
    return measured_numbers_table(
        on_paper.extrapolate_resources_to_large_study({one.quantity: one.value for one in measured_numbers})
    )


if __name__ == "__main__":
    typer.run(main)
