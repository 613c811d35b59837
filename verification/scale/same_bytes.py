"""Bytes of the cube and run time of one study on one and two cores, in chunks, on SLURM and on a dask cluster."""

import hashlib
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final, NamedTuple

from overturning.records.store import read_record_from_motion_file
from overturning.study.cube import open_cube, study_of_cube
from overturning.study.gather import merge_outcome_files_into_cube
from overturning.study.parts import WHOLE_RECORD_CHUNK, path_of_chunk_outcome_file
from overturning.study.scenes import numerical_options_of_study
from overturning.study.sweep import simulate_and_write_cases_of_record
from verification.one_node_slurm import SNAKEMAKE_OPTIONS_FOR_SLURM, run_one_node_slurm, slurm_unavailable_reason
from verification.project import CUBE_FILE_NAME, StudyWorkflowCopy

STUDY_YAML: Final = """\
name: scale
records: {use: [rinaldi, petrolia]}
azimuth: {step: 10, also: [32]}
b_over_h: {start: 0.1, stop: 0.6, step: 0.05}
friction: [0.33, 1.0]
ensemble: {members: 16}
verification: none
"""

SMALL_STUDY_YAML: Final = (
    STUDY_YAML.replace("step: 10", "step: 60")
    .replace("0.05", "0.25")
    .replace("rinaldi, petrolia", "rinaldi")
    .replace("16", "0")
)
"""A smaller version of `STUDY_YAML` that takes a few seconds."""

REPORT_FILE_NAME: Final = "report.html"

SLURM_OPTIONS: Final = (
    *("--workflow-profile", "profiles/slurm"),
    *(
        *SNAKEMAKE_OPTIONS_FOR_SLURM,
        "--slurm-init-seconds-before-status-checks",
        "6",
        "--seconds-between-status-checks",
        "6",
    ),
    *("--latency-wait", "10"),
)
"""The profile of the project for SLURM, with the options of the one-node cluster.

The executor polls a job after its expected end; each time it is still running, the interval grows by ten seconds."""


class StudyRunTimeAndResultHash(NamedTuple):
    """Run time, and hash of a result file, of a study run in one way, such as on two cores or on a cluster."""

    way: str
    requested_result_file: str
    run_time_s: float
    sha256_of_result: str
    sweep_part_count: int  # number of parts of the sweep that still exist after the run


@contextmanager
def temporary_project_with_study(study_yaml: str) -> Iterator[StudyWorkflowCopy]:
    """Provide a temporary folder with the workflow and a study that has not run."""
    with tempfile.TemporaryDirectory(prefix="scale-") as name:
        yield StudyWorkflowCopy(Path(name) / "project", study_yaml)


def run_study_up_to_result_file(
    workflow_copy: StudyWorkflowCopy,
    run_label_in_result_table: str,
    *options: str,
    result_file_name: str = CUBE_FILE_NAME,
) -> StudyRunTimeAndResultHash:
    """Run a study up to a file of its results; raise a RuntimeError with the output of Snakemake if it fails."""
    begin = time.perf_counter()
    done = workflow_copy.run(*options, result_file_name=result_file_name)
    if done.returncode:
        raise RuntimeError(f"{run_label_in_result_table}: {done.stdout[-2000:]}{done.stderr[-4000:]}")
    seconds, kept = time.perf_counter() - begin, len(list(workflow_copy.results.glob("sweep/*/*.nc")))
    return StudyRunTimeAndResultHash(
        run_label_in_result_table,
        result_file_name,
        seconds,
        hashlib.sha256((workflow_copy.results / result_file_name).read_bytes()).hexdigest(),
        kept,
    )


def run_study_locally(
    study_yaml: str, core_count: int, chunk_count_per_record: int, result_file_name: str = CUBE_FILE_NAME
) -> StudyRunTimeAndResultHash:
    """Run a study on some cores of this machine."""
    words = f"{core_count} core{'s' * (core_count > 1)}" + (
        f", {chunk_count_per_record} chunks of each record" if chunk_count_per_record > 1 else ""
    )
    with temporary_project_with_study(study_yaml) as folder:
        return run_study_up_to_result_file(
            folder,
            words,
            "--cores",
            str(core_count),
            "--set-scatter",
            f"sweep={chunk_count_per_record}",
            result_file_name=result_file_name,
        )


def run_study_on_slurm(
    study_yaml: str = STUDY_YAML,
    chunk_count_per_record: int = 3,
    result_file_name_of_each_run: tuple[str, ...] = (CUBE_FILE_NAME,),
) -> list[StudyRunTimeAndResultHash]:
    """Run a study up to each result file on a one-node SLURM cluster; return an empty list if there is no SLURM."""
    if slurm_unavailable_reason():
        return []
    words = f"SLURM, one node of two cores, {chunk_count_per_record} chunks of each record"
    with run_one_node_slurm(), temporary_project_with_study(study_yaml) as folder:
        return [
            run_study_up_to_result_file(
                folder, words, *SLURM_OPTIONS, "--set-scatter", f"sweep={chunk_count_per_record}", result_file_name=file
            )
            for file in result_file_name_of_each_run
        ]


def simulate_study_without_snakemake(
    workflow_copy: StudyWorkflowCopy, run_label_in_result_table: str, dask_client: object = None
) -> StudyRunTimeAndResultHash:
    """Simulate a study with the package alone, from the motion files of a workflow run, and hash its cube.

    If `dask_client` is given, the cases run on its dask cluster.
    """
    begin = time.perf_counter()
    with open_cube(workflow_copy.cube_path) as cube:
        settings = study_of_cube(cube)
    records = [
        read_record_from_motion_file(workflow_copy.cube_path.parent / "motion" / f"{name}.nc")
        for name in settings.records.use
    ]
    parts = [
        path_of_chunk_outcome_file(workflow_copy.folder / "again", name, WHOLE_RECORD_CHUNK)
        for name in settings.records.use
    ]
    for record, part in zip(records, parts, strict=True):
        simulate_and_write_cases_of_record(
            settings, record, part, numerics=numerical_options_of_study(settings, dask_client=dask_client)
        )
    merge_outcome_files_into_cube(settings, records, parts, workflow_copy.folder / "cube.nc")
    content = (workflow_copy.folder / "cube.nc").read_bytes()
    return StudyRunTimeAndResultHash(
        run_label_in_result_table,
        CUBE_FILE_NAME,
        time.perf_counter() - begin,
        hashlib.sha256(content).hexdigest(),
        len(parts),
    )


def run_study_on_dask(study_yaml: str, worker_count: int = 2) -> StudyRunTimeAndResultHash:
    """Simulate a study on a dask cluster without Snakemake; a run with Snakemake first provides the motion files."""
    from distributed import Client, LocalCluster

    with temporary_project_with_study(study_yaml) as folder:
        run_study_up_to_result_file(folder, "first", "--cores", "1")
        cluster = LocalCluster(n_workers=worker_count, threads_per_worker=1, dashboard_address=None, host="127.0.0.1")
        with cluster, Client(cluster) as client:
            return simulate_study_without_snakemake(folder, f"dask, {worker_count} workers, without Snakemake", client)


def run_study_in_every_local_way(study_yaml: str = STUDY_YAML) -> list[StudyRunTimeAndResultHash]:
    """Run the study in every way that needs no SLURM cluster, and once more on one core to make its report."""
    cubes = [run_study_locally(study_yaml, cores, chunks) for cores, chunks in ((1, 1), (2, 1), (2, 3), (2, 19))]
    return [*cubes, run_study_on_dask(study_yaml), run_study_locally(study_yaml, 1, 1, REPORT_FILE_NAME)]
