"""Functions that each cause a fault in a project, and raise an AssertionError if the project reacts wrongly.

A fault that damages a file which must be reported returns its path. After each fault the usual command must resume.
"""

import os
import random
import shutil
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final, NamedTuple

import psutil

from verification.project import StudyWorkflowCopy

FaultFunction = Callable[[StudyWorkflowCopy, random.Random, float], Path | None]
"""Function of a project, a random generator and the time of an undisturbed run, s; returns the damaged file, if any."""

FAULT_TEST_STUDY_YAML: Final = """\
name: faults
records: {use: [rinaldi, petrolia]}
azimuth: {step: 45}
b_over_h: [0.2, 0.3]
height: [0.6]
friction: [0.5]
ensemble: {members: 0}
verification: none
"""
SWEEP_PART_FILE_PATTERN, MOTION_FILE_PATTERN = "sweep/nominal/*.nc", "motion/*.nc"
FAULT_TEST_STUDY_JOB_COUNT: Final = (
    8  # of the study: two records to read, their labels, two parts of each to compute, and gathering
)
TOO_SMALL_FREE_DISK_SPACES_KB: Final = (100, 400)  # kB: too little for the first motion; too little for all parts


def yield_study_jobs_as_they_start(study_process: psutil.Popen) -> Iterator[psutil.Process]:
    """Yield each job (process) of a running study when it begins, until the run ends."""
    seen: set[int] = set()
    while study_process.poll() is None:
        with suppress(psutil.Error):  # the process has just ended
            for process in study_process.children(recursive=True):
                words = process.cmdline() if process.pid not in seen else []
                if any(Path(word).name == "overturning" for word in words[:2]):
                    seen.add(process.pid)
                    yield process
        time.sleep(0.01)


def start_run_and_kill_its_process_group(
    workflow_copy: StudyWorkflowCopy, random_generator: random.Random, undisturbed_run_time_s: float
) -> None:
    """Start a run and kill its process group at a random moment."""
    run = workflow_copy.start()
    time.sleep(random_generator.uniform(0.05, 0.95) * undisturbed_run_time_s)
    os.killpg(run.pid, signal.SIGKILL)
    run.wait()


def fault_killing_job_or_snakemake(kills_snakemake: bool, max_delay_after_job_start_s: float) -> FaultFunction:
    """Return a fault that kills a random job (Snakemake goes on), or only Snakemake (the job goes on)."""

    def kill_job_or_snakemake_during_run(
        workflow_copy: StudyWorkflowCopy, random_generator: random.Random, _undisturbed_run_time_s: float
    ) -> None:
        """Start a run, and kill a random job, or Snakemake, at a random moment after this job begins."""
        run, chosen = workflow_copy.start(), random_generator.randrange(FAULT_TEST_STUDY_JOB_COUNT)
        for number, job in enumerate(yield_study_jobs_as_they_start(run)):
            if number == chosen:
                time.sleep(random_generator.uniform(0.0, max_delay_after_job_start_s))
                with suppress(psutil.NoSuchProcess):
                    (run if kills_snakemake else job).kill()
                if kills_snakemake:
                    break
        run.wait()

    return kill_job_or_snakemake_during_run


def fault_damaging_file(file_name_pattern: str, damage_kind: str) -> FaultFunction:
    """Return a fault that damages a file of results or kernels without changing its time.

    The file is truncated, emptied, or a byte of it is changed.
    """

    def damage_random_file_and_return_path_to_report(
        workflow_copy: StudyWorkflowCopy, random_generator: random.Random, _undisturbed_run_time_s: float
    ) -> Path | None:
        """Damage a random file; return its path, which the next run must report, or None for a compiled kernel."""
        kernel = file_name_pattern.startswith("*.nb")
        path = random_generator.choice(
            sorted(
                (workflow_copy.folder / "kernels").rglob(file_name_pattern)
                if kernel
                else workflow_copy.results.glob(file_name_pattern)
            )
        )
        content, time_ns = bytearray(path.read_bytes()), path.stat().st_mtime_ns
        where = random_generator.randrange(1, len(content))
        if damage_kind == "changed":
            content[where] ^= 1 << random_generator.randrange(8)
        path.write_bytes(b"" if damage_kind == "emptied" else content[:where] if damage_kind == "cut" else content)
        os.utime(path, ns=(time_ns, time_ns))
        if file_name_pattern != "cube.nc":
            workflow_copy.cube_path.unlink()
        if kernel:  # a kernel is loaded only if a part must be computed
            random_generator.choice(sorted(workflow_copy.results.glob(SWEEP_PART_FILE_PATTERN))).unlink()
        return None if kernel else path.relative_to(workflow_copy.folder)

    return damage_random_file_and_return_path_to_report


def fill_disk_during_run(
    workflow_copy: StudyWorkflowCopy, random_generator: random.Random, _undisturbed_run_time_s: float
) -> None:
    """Run the study, fill its disk during the run so that the run fails, then free the disk."""
    results = workflow_copy.folder / "results"
    results.mkdir()
    _run_mount("-t", "tmpfs", "-o", "size=100m", "none", str(results))
    run = psutil.Popen(
        **workflow_copy.subprocess_arguments_of_snakemake_run(),
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    next(yield_study_jobs_as_they_start(run))
    other = results / "other"
    with other.open("wb") as file:
        os.posix_fallocate(
            file.fileno(),
            0,
            shutil.disk_usage(results).free - 1000 * random_generator.choice(TOO_SMALL_FREE_DISK_SPACES_KB),
        )
    errors = run.communicate()[1]
    assert run.returncode != 0, "the run did not fail"
    assert "no space left" in errors, errors
    other.unlink()


def run_with_read_only_results(
    workflow_copy: StudyWorkflowCopy, _random_generator: random.Random, _undisturbed_run_time_s: float
) -> None:
    """Run the study with a read-only folder of results, which the run must report."""
    workflow_copy.cube_path.unlink()
    results = str(workflow_copy.folder / "results")
    _run_mount("--bind", results, results)
    _run_mount("-o", "remount,ro,bind", results)
    done = workflow_copy.run()
    assert done.returncode != 0
    assert "cannot be written to" in done.stderr, done.stderr
    _run_mount("-o", "remount,rw,bind", results)


def start_second_run_during_first(
    workflow_copy: StudyWorkflowCopy, _random_generator: random.Random, _undisturbed_run_time_s: float
) -> None:
    """Start a second run in the same folder while a job of the first is suspended."""
    first = workflow_copy.start()
    for step in yield_study_jobs_as_they_start(first):
        with suppress(psutil.NoSuchProcess):  # the job has just ended: use the next one
            step.suspend()
            break
    second = workflow_copy.run()
    step.resume()
    assert second.returncode != 0
    assert "another run works in this folder" in second.stderr, second.stderr
    assert "Traceback" not in second.stderr
    assert first.wait() == 0


def kill_run_and_move_file_times_ahead(
    workflow_copy: StudyWorkflowCopy, random_generator: random.Random, undisturbed_run_time_s: float
) -> None:
    """Kill a run, then move all file times two hours ahead, as if the clock had been set back."""
    start_run_and_kill_its_process_group(workflow_copy, random_generator, undisturbed_run_time_s)
    for path in (path for name in ("results", ".snakemake") for path in (workflow_copy.folder / name).rglob("*")):
        if path.is_file():
            moment = path.stat().st_mtime + 7200
            os.utime(path, (moment, moment))


def run_on_dask_and_kill_worker(
    _workflow_copy: StudyWorkflowCopy, random_generator: random.Random, _undisturbed_run_time_s: float
) -> None:
    """Run cases on a dask cluster and kill a worker; the outcome must be bit-equal to that of one process."""
    import numpy as np
    from distributed import Client, LocalCluster

    import overturning

    motion = overturning.Motion.sine(amplitude=5.0, period=0.8, azimuth_deg=60)
    azimuth, ratio = (axis.ravel() for axis in np.meshgrid(np.arange(0.0, 360.0, 6.0), np.linspace(0.1, 0.5, 9)))
    cases = overturning.Cases(azimuth, 0.6, ratio, 0.7)
    killed: list[int] = []
    with (
        LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1") as cluster,
        Client(cluster) as client,
    ):

        def kill_one_worker(_finished_case_count: int, _total_case_count: int) -> None:
            """Kill one worker when the first cases are finished."""
            if not killed:
                killed.append(random_generator.choice(sorted(client.run(os.getpid).values())))
                os.kill(killed[0], signal.SIGKILL)

        spread = overturning.run_cases(motion, cases, client=client, progress=kill_one_worker)
    assert killed, "no worker was killed"
    for name, values in vars(overturning.run_cases(motion, cases)).items():
        assert np.array_equal(getattr(spread, name), values, equal_nan=values.dtype.kind == "f"), f"another {name}"


def _run_mount(*words: str) -> None:
    """Run the command mount with some arguments."""
    subprocess.run(["mount", *words], check=True, capture_output=True)


@contextmanager
def unmount_results_folder_at_exit(workflow_copy: StudyWorkflowCopy) -> Iterator[None]:
    """Unmount the folder of results at the end of a `with` block, if a fault has mounted it."""
    try:
        yield
    finally:
        # A bind mount of a folder onto itself does not look like a mount, so try until umount fails.
        while not subprocess.run(
            ["umount", str(workflow_copy.folder / "results")], capture_output=True, check=False
        ).returncode:
            pass


class InjectedFaultKind(NamedTuple):
    """Kind of fault: its label, function, number of repetitions, and conditions."""

    label: str
    inject_fault: FaultFunction
    repetition_count: int
    needs_finished_study: bool = False
    """True: applied to a finished study; False: to one that has not begun."""
    needs_root_user: bool = False
    """True if only root can cause it."""


FAULT_KINDS: Final = (
    InjectedFaultKind("disk full", fill_disk_during_run, 2, needs_root_user=True),
    InjectedFaultKind(
        "results read-only", run_with_read_only_results, 1, needs_finished_study=True, needs_root_user=True
    ),
    InjectedFaultKind("two runs at once", start_second_run_during_first, 2),
    InjectedFaultKind("clock set back", kill_run_and_move_file_times_ahead, 2),
    InjectedFaultKind("a worker of a dask cluster killed", run_on_dask_and_kill_worker, 2, needs_finished_study=True),
    InjectedFaultKind(
        "a partial result truncated",
        fault_damaging_file(SWEEP_PART_FILE_PATTERN, "cut"),
        3,
        needs_finished_study=True,
    ),
    InjectedFaultKind(
        "a partial result emptied",
        fault_damaging_file(SWEEP_PART_FILE_PATTERN, "emptied"),
        2,
        needs_finished_study=True,
    ),
    InjectedFaultKind(
        "a byte of a partial result changed",
        fault_damaging_file(SWEEP_PART_FILE_PATTERN, "changed"),
        5,
        needs_finished_study=True,
    ),
    InjectedFaultKind(
        "a motion truncated", fault_damaging_file(MOTION_FILE_PATTERN, "cut"), 1, needs_finished_study=True
    ),
    InjectedFaultKind(
        "a byte of a motion changed", fault_damaging_file(MOTION_FILE_PATTERN, "changed"), 1, needs_finished_study=True
    ),
    InjectedFaultKind(
        "a byte of the cube changed", fault_damaging_file("cube.nc", "changed"), 1, needs_finished_study=True
    ),
    InjectedFaultKind("a compiled kernel truncated", fault_damaging_file("*.nbc", "cut"), 1, needs_finished_study=True),
    InjectedFaultKind(
        "a byte of a compiled kernel changed", fault_damaging_file("*.nbc", "changed"), 2, needs_finished_study=True
    ),
    InjectedFaultKind(
        "the index of the compiled kernels emptied",
        fault_damaging_file("*.nbi", "emptied"),
        1,
        needs_finished_study=True,
    ),
    InjectedFaultKind("process group killed", start_run_and_kill_its_process_group, 10),
    InjectedFaultKind(
        "one job killed", fault_killing_job_or_snakemake(kills_snakemake=False, max_delay_after_job_start_s=1.0), 7
    ),
    InjectedFaultKind(
        "only Snakemake killed",
        fault_killing_job_or_snakemake(kills_snakemake=True, max_delay_after_job_start_s=0.7),
        7,
    ),
)
