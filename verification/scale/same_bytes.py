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
from overturning.study.parts import SINGLE_CHUNK_OF_RECORD, sweep_part_path
from overturning.study.scenes import numerical_options_of_study
from overturning.study.sweep import simulate_and_write_cases_of_record
from verification.one_node_slurm import SNAKEMAKE_OPTIONS_FOR_SLURM, run_one_node_slurm, slurm_unavailable_reason
from verification.project import CUBE_FILE_NAME, WorkflowFolder

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


class StudyRun(NamedTuple):
    """Result of running the study in one way, such as on two cores or on a cluster."""

    way: str
    requested_result_file: str
    run_time_s: float
    sha256_of_result: str
    sweep_part_count: int  # number of parts of the sweep that still exist after the run


@contextmanager
def temporary_project_with_study(study: str) -> Iterator[WorkflowFolder]:
    """Provide a temporary folder with the workflow and a study that has not run."""
    with tempfile.TemporaryDirectory(prefix="scale-") as name:
        yield WorkflowFolder(Path(name) / "project", study)


def run_study_up_to_result_file(
    project: WorkflowFolder, way: str, *options: str, file: str = CUBE_FILE_NAME
) -> StudyRun:
    """Run a study up to a file of its results; raise a RuntimeError with the output of Snakemake if it fails."""
    begin = time.perf_counter()
    done = project.run(*options, file=file)
    if done.returncode:
        raise RuntimeError(f"{way}: {done.stdout[-2000:]}{done.stderr[-4000:]}")
    seconds, kept = time.perf_counter() - begin, len(list(project.results.glob("sweep/*/*.nc")))
    return StudyRun(way, file, seconds, hashlib.sha256((project.results / file).read_bytes()).hexdigest(), kept)


def run_study_locally(study: str, cores: int, chunks: int, file: str = CUBE_FILE_NAME) -> StudyRun:
    """Run a study on some cores of this machine."""
    words = f"{cores} core{'s' * (cores > 1)}" + (f", {chunks} chunks of each record" if chunks > 1 else "")
    with temporary_project_with_study(study) as folder:
        return run_study_up_to_result_file(
            folder, words, "--cores", str(cores), "--set-scatter", f"sweep={chunks}", file=file
        )


def run_study_on_slurm(
    study: str = STUDY_YAML, chunks: int = 3, files: tuple[str, ...] = (CUBE_FILE_NAME,)
) -> list[StudyRun]:
    """Run a study with the SLURM profile on a one-node cluster, for each file; empty if there is no SLURM."""
    if slurm_unavailable_reason():
        return []
    words = f"SLURM, one node of two cores, {chunks} chunks of each record"
    with run_one_node_slurm(), temporary_project_with_study(study) as folder:
        return [
            run_study_up_to_result_file(folder, words, *SLURM_OPTIONS, "--set-scatter", f"sweep={chunks}", file=file)
            for file in files
        ]


def simulate_study_without_snakemake(folder: WorkflowFolder, way: str, client: object = None) -> StudyRun:
    """Simulate a study with the package alone, from the motion files of a workflow run, and hash its cube.

    With `client` on a dask cluster.
    """
    begin = time.perf_counter()
    with open_cube(folder.cube_path) as cube:
        settings = study_of_cube(cube)
    records = [
        read_record_from_motion_file(folder.cube_path.parent / "motion" / f"{name}.nc") for name in settings.records.use
    ]
    parts = [sweep_part_path(folder.folder / "again", name, SINGLE_CHUNK_OF_RECORD) for name in settings.records.use]
    for record, part in zip(records, parts, strict=True):
        simulate_and_write_cases_of_record(
            settings, record, part, numerics=numerical_options_of_study(settings, dask_client=client)
        )
    merge_outcome_files_into_cube(settings, records, parts, folder.folder / "cube.nc")
    content = (folder.folder / "cube.nc").read_bytes()
    return StudyRun(way, CUBE_FILE_NAME, time.perf_counter() - begin, hashlib.sha256(content).hexdigest(), len(parts))


def run_study_on_dask(study: str, workers: int = 2) -> StudyRun:
    """Run a study on a dask cluster."""
    from distributed import Client, LocalCluster

    with temporary_project_with_study(study) as folder:
        run_study_up_to_result_file(folder, "first", "--cores", "1")
        cluster = LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None, host="127.0.0.1")
        with cluster, Client(cluster) as client:
            return simulate_study_without_snakemake(folder, f"dask, {workers} workers, without Snakemake", client)


def run_study_in_every_local_way(study: str = STUDY_YAML) -> list[StudyRun]:
    """Run the study in every way that needs no SLURM cluster; make its report once, on one core."""
    cubes = [run_study_locally(study, cores, chunks) for cores, chunks in ((1, 1), (2, 1), (2, 3), (2, 19))]
    return [*cubes, run_study_on_dask(study), run_study_locally(study, 1, 1, REPORT_FILE_NAME)]
