"""Cases under one motion, shared out to the workers of a dask cluster."""

from collections.abc import Callable
from dataclasses import fields, replace
from typing import Any, Final

import numpy as np

from overturning.dem.numerics import Numerics
from overturning.motion.motion import Motion

MOST: Final = 16384
"""Cases of a task: half a second's work or more, and no more than that is lost with a worker."""

FEWEST: Final = 256
"""Below so many the kernel's columns would not be full."""


def run_on_cluster(run: Callable[[Motion, Any, Numerics], Any], motion: Motion, cases: Any, numerics: Numerics) -> Any:
    """Run cases on the cluster of ``numerics.client``, with the same bits as here.

    Parameters
    ----------
    run : callable
        Runs some of the cases on a worker and returns a dataclass of arrays, a row per case.
    motion : Motion
        The ground's.
    cases : Cases
        All cases.
    numerics : Numerics
        How they are computed. Each task has one thread, and `progress` counts cases.

    Returns
    -------
    Results
        In the order of the cases, none of which depends on another. What a lost worker held or worked at is computed
        again by another.

    Raises
    ------
    Exception
        What `run` raises on a worker.
    """
    from distributed import as_completed

    client, progress = numerics.client, numerics.progress
    here = replace(numerics, client=None, progress=None, threads=1)
    wanted = min(cases.size // FEWEST, 4 * sum(client.ncores().values()))
    count = max(1, wanted, -(-cases.size // MOST))
    pieces = [np.arange(part, cases.size, count) for part in range(count)]
    # The result of a task and not scattered data, which would be gone with the worker that holds it.
    ground = client.submit(_itself, motion, pure=False)
    tasks = {client.submit(run, ground, _some(cases, piece), here, pure=False): piece for piece in pieces}
    done = 0
    for task in as_completed(tasks):
        done += tasks[task].size
        if progress and task.status == "finished":
            progress(done, cases.size)
    found = client.gather(list(tasks))
    order = np.argsort(np.concatenate(pieces))
    columns = {name: np.concatenate([getattr(each, name) for each in found])[order] for name in vars(found[0])}
    return type(found[0])(**columns)


def _itself(motion: Motion) -> Motion:
    return motion


def _some(cases: Any, rows: Any) -> Any:
    return replace(cases, **{item.name: np.asarray(getattr(cases, item.name))[rows] for item in fields(cases)})
