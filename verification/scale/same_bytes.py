"""One study on one core, on two, in chunks, on SLURM and on a dask cluster: the cube's bytes, and the time of each."""

import hashlib
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Final, NamedTuple

from overturning.records.store import read_motion
from overturning.study.cube import open_cube, study_of
from overturning.study.gather import gather
from overturning.study.parts import WHOLE, part_path
from overturning.study.scenes import numerics_of
from overturning.study.sweep import sweep_record
from verification.one_node_slurm import OPTIONS, missing, one_node_slurm
from verification.project import CUBE, Project

STUDY: Final = """\
name: scale
records: {use: [rinaldi, petrolia]}
azimuth: {step: 10, also: [32]}
b_over_h: {start: 0.1, stop: 0.6, step: 0.05}
friction: [0.33, 1.0]
ensemble: {members: 16}
verification: none
"""

SMALL: Final = (
    STUDY.replace("step: 10", "step: 60")
    .replace("0.05", "0.25")
    .replace("rinaldi, petrolia", "rinaldi")
    .replace("16", "0")
)
"""Much the same in a few seconds."""

REPORT: Final = "report.html"

SLURM: Final = (
    *("--workflow-profile", "profiles/slurm"),
    *(*OPTIONS, "--slurm-init-seconds-before-status-checks", "6", "--seconds-between-status-checks", "6"),
    *("--latency-wait", "10"),
)
"""The project's profile for SLURM, with what the cluster of one node needs.

Its executor asks after a job when it should have ended: each time that it has not, it waits ten seconds longer."""


class Run(NamedTuple):
    """What one way of running the study gave."""

    way: str
    file: str  # that was asked for
    seconds: float
    sha256: str  # of that file
    kept: int  # parts of the sweep that are still there


@contextmanager
def fresh(study: str) -> Iterator[Project]:
    """A folder with a study that has not run."""
    with tempfile.TemporaryDirectory(prefix="scale-") as name:
        yield Project(Path(name) / "project", study)


def made(project: Project, way: str, *options: str, file: str = CUBE) -> Run:
    """Run a study up to a file of its results; a RuntimeError with what Snakemake says where that fails."""
    begin = time.perf_counter()
    done = project.run(*options, file=file)
    if done.returncode:
        raise RuntimeError(f"{way}: {done.stdout[-2000:]}{done.stderr[-4000:]}")
    seconds, kept = time.perf_counter() - begin, len(list(project.results.glob("sweep/*/*.nc")))
    return Run(way, file, seconds, hashlib.sha256((project.results / file).read_bytes()).hexdigest(), kept)


def local(study: str, cores: int, chunks: int, file: str = CUBE) -> Run:
    """On some cores of this machine."""
    words = f"{cores} core{'s' * (cores > 1)}" + (f", {chunks} chunks of each record" if chunks > 1 else "")
    with fresh(study) as folder:
        return made(folder, words, "--cores", str(cores), "--set-scatter", f"sweep={chunks}", file=file)


def on_slurm(study: str = STUDY, chunks: int = 3, files: tuple[str, ...] = (CUBE,)) -> list[Run]:
    """By the profile for SLURM on a cluster of one node, one result after another; none where there is none."""
    if missing():
        return []
    words = f"SLURM, one node of two cores, {chunks} chunks of each record"
    with one_node_slurm(), fresh(study) as folder:
        return [made(folder, words, *SLURM, "--set-scatter", f"sweep={chunks}", file=file) for file in files]


def without_snakemake(folder: Project, way: str, client: object = None) -> Run:
    """By the package alone, in one piece, from motions that the workflow has read; on a dask cluster where given."""
    begin = time.perf_counter()
    with open_cube(folder.cube) as cube:
        settings = study_of(cube)
    records = [read_motion(folder.cube.parent / "motion" / f"{name}.nc") for name in settings.records.use]
    parts = [part_path(folder.folder / "again", name, WHOLE) for name in settings.records.use]
    for record, part in zip(records, parts, strict=True):
        sweep_record(settings, record, part, numerics=numerics_of(settings, client=client))
    gather(settings, records, parts, folder.folder / "cube.nc")
    content = (folder.folder / "cube.nc").read_bytes()
    return Run(way, CUBE, time.perf_counter() - begin, hashlib.sha256(content).hexdigest(), len(parts))


def on_dask(study: str, workers: int = 2) -> Run:
    """On a dask cluster."""
    from distributed import Client, LocalCluster

    with fresh(study) as folder:
        made(folder, "first", "--cores", "1")
        cluster = LocalCluster(n_workers=workers, threads_per_worker=1, dashboard_address=None, host="127.0.0.1")
        with cluster, Client(cluster) as client:
            return without_snakemake(folder, f"dask, {workers} workers, without Snakemake", client)


def here(study: str = STUDY) -> list[Run]:
    """The study in every way that needs no cluster, and its report."""
    cubes = [local(study, cores, chunks) for cores, chunks in ((1, 1), (2, 1), (2, 3), (2, 19))]
    return [*cubes, on_dask(study), local(study, 1, 1, REPORT)]
