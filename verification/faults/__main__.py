"""`python -m verification.faults`: cause fifty faults, run the usual command after each, and compare the cubes."""

import os
import random
import shutil
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Final

import typer

from overturning.study.resume import DAMAGED_FILE_LOG_PREFIX
from verification.faults.kinds import (
    FAULT_KINDS,
    FAULT_TEST_STUDY_YAML,
    InjectedFaultKind,
    unmount_results_folder_at_exit,
)
from verification.project import StudyWorkflowCopy
from verification.tables import markdown_table, update_marked_tables_and_sentences_in_docs

SEED: Final = 18


def cause_fault_and_describe_failure(
    fault_kind: InjectedFaultKind,
    workflow_copy: StudyWorkflowCopy,
    random_generator: random.Random,
    undisturbed_run_time_s: float,
    expected_cube_bytes: bytes,
    skips_check_that_rerun_does_nothing: bool,
) -> str:
    """Cause a fault, run the usual command, and return a description of what went wrong; empty if nothing did.

    The cube must equal `expected_cube_bytes`, and damage to a result must be reported. Unless
    `skips_check_that_rerun_does_nothing`, a further run must find nothing to do.
    """
    with unmount_results_folder_at_exit(workflow_copy):
        try:
            damaged = fault_kind.inject_fault(workflow_copy, random_generator, undisturbed_run_time_s)
        except AssertionError as other:
            return f"while it lasted: {other}"
        done = workflow_copy.run()
        if done.returncode:
            return f"the command failed: {done.stderr[-2000:]}"
        if damaged and f"{DAMAGED_FILE_LOG_PREFIX}{damaged}" not in done.stderr:
            return f"{damaged}: damage was not noticed: {done.stderr}"
        if workflow_copy.cube_path.read_bytes() != expected_cube_bytes:
            return "another cube"
        if not skips_check_that_rerun_does_nothing and "Nothing to be done" not in (more := workflow_copy.run()).stdout:
            return f"a further run does something: {more.stdout}{more.stderr}"
    return ""


def cause_faults_and_count_survived(
    fault_kinds_and_repetitions: Sequence[tuple[InjectedFaultKind, int]],
    folder: Path,
    seed: int = SEED,
    reuses_kernels_and_skips_further_run: bool = False,
) -> dict[str, tuple[int, int]]:
    """Cause faults of each kind in a study, print a line for each, and return (survived, caused) by kind.

    With `reuses_kernels_and_skips_further_run`, existing compiled kernels are used, and no further run is made.
    """
    options = ("--cores", "1", "--set-scatter", "sweep=2")
    study, dice = (
        StudyWorkflowCopy(
            folder / "study",
            FAULT_TEST_STUDY_YAML,
            *options,
            uses_own_kernel_cache=not reuses_kernels_and_skips_further_run,
        ),
        random.Random(seed),
    )
    seconds = _measure_undisturbed_run_time_s(study)
    wanted = study.cube_path.read_bytes()
    fresh = study.copy_to(folder / "fresh")
    for name in ("results", ".snakemake"):
        shutil.rmtree(fresh.folder / name)
    if not reuses_kernels_and_skips_further_run:  # the kernels have been compiled now
        again = fresh.copy_to(folder / "again")
        seconds = _measure_undisturbed_run_time_s(again)
        assert again.cube_path.read_bytes() == wanted
    found = {}
    for kind, times in fault_kinds_and_repetitions:
        if kind.needs_root_user and os.geteuid():
            print(f"{kind.label}: skipped, since only root may mount a file system")
            continue
        good = 0
        for _ in range(times):
            place = (study if kind.needs_finished_study else fresh).copy_to(folder / "place")
            wrong = cause_fault_and_describe_failure(
                kind, place, dice, seconds, wanted, reuses_kernels_and_skips_further_run
            )
            good += not wrong
            print(f"{kind.label}: {wrong or 'the same cube'}", flush=True)
        found[kind.label] = good, times
    return found


def _measure_undisturbed_run_time_s(workflow_copy: StudyWorkflowCopy) -> float:
    """Run a study without a fault and return the elapsed time, s."""
    begin = time.monotonic()
    done = workflow_copy.run()
    if done.returncode:
        raise SystemExit(f"the study fails even without a fault:\n{done.stderr}")
    return time.monotonic() - begin


def main(
    seed: Annotated[int, typer.Option(help="seed of the moments, files and bytes")] = SEED,
    page: Annotated[bool, typer.Option(help="write the table into the docs")] = True,
) -> None:
    """Cause faults of all kinds and publish how many the study survived."""
    with tempfile.TemporaryDirectory() as folder:
        found = cause_faults_and_count_survived(
            [(kind, kind.repetition_count) for kind in FAULT_KINDS], Path(folder), seed
        )
        good, total = map(sum, zip(*found.values(), strict=True))
        print(f"{good} of {total}")
        if page:
            rows = [
                (label, f"{fine} of {times}") for label, (fine, times) in {**found, "all faults": (good, total)}.items()
            ]
            update_marked_tables_and_sentences_in_docs({"faults": markdown_table(("fault", "survived"), rows)})
    if good < total:
        raise SystemExit(1)


if __name__ == "__main__":
    typer.run(main)
