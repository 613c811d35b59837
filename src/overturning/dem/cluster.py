"""Cases under one motion, distributed to the workers of a dask cluster."""

from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any, Final

import numpy as np

from overturning.dem.numerics import NumericalOptions
from overturning.motion.motion import Motion

MAX_CASES_PER_TASK: Final = 16384
"""Largest number of cases in a task, at least half a second of work; limits what is lost with a worker."""

MIN_CASES_PER_TASK: Final = 256
"""Smallest number of cases in a task; fewer would not fill the kernel's lanes."""


def simulate_cases_on_cluster(
    simulate_cases: Callable[[Motion, Any, NumericalOptions], Any],
    motion: Motion,
    cases: Any,
    numerics: NumericalOptions,
) -> Any:
    """Simulate cases on the dask cluster of ``numerics.client``; the results are bit-equal to those of a local run.

    Parameters
    ----------
    simulate_cases : callable
        Function run on a worker with a subset of the cases; returns a dataclass of arrays, one row per case.
    motion : Motion
        Input motion.
    cases : Cases
        All cases.
    numerics : NumericalOptions
        Numerical options. Each task has one thread, and `progress` counts cases.

    Returns
    -------
    CaseResults
        Results in the order of the cases. Tasks of a lost worker are computed again by another.

    Raises
    ------
    Exception
        Any exception that `simulate_cases` raises on a worker.
    """
    from distributed import as_completed

    client: Any = numerics.client  # not None here
    progress = numerics.progress
    here = replace(numerics, client=None, progress=None, threads=1)
    wanted = min(cases.case_count // MIN_CASES_PER_TASK, 4 * sum(client.ncores().values()))
    count = max(1, wanted, -(-cases.case_count // MAX_CASES_PER_TASK))
    pieces = [np.arange(part, cases.case_count, count) for part in range(count)]
    # Submitted as the result of a task: scattered data would be lost with the worker that holds it.
    ground = client.submit(_return_motion_unchanged_as_dask_task, motion, pure=False)
    tasks = {
        client.submit(simulate_cases, ground, _select_cases(cases, piece), here, pure=False): piece for piece in pieces
    }
    done = 0
    for task in as_completed(tasks):
        done += tasks[task].size
        if progress and task.status == "finished":
            progress(done, cases.case_count)
    parts = client.gather(list(tasks))
    order = np.argsort(np.concatenate(pieces))
    columns = {name: np.concatenate([getattr(part, name) for part in parts])[order] for name in vars(parts[0])}
    return type(parts[0])(**columns)


def _return_motion_unchanged_as_dask_task(motion: Motion) -> Motion:
    """Return the motion unchanged: run as a dask task, whose result all simulation tasks on the cluster share."""
    return motion


def _select_cases(cases: Any, case_numbers: Any) -> Any:
    """Return the subset of cases with the indices `case_numbers`, in this order."""
    return replace(cases, **{item.name: np.asarray(getattr(cases, item.name))[case_numbers] for item in fields(cases)})
