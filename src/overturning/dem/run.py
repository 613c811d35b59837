"""Many cases of a scene under one motion: planned, shared out to threads, and collected in their own order."""

from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.dem.cluster import run_on_cluster
from overturning.dem.numerics import Numerics
from overturning.dem.plan import Plan
from overturning.model.cases import Cases
from overturning.model.contact import Contact
from overturning.model.results import Results
from overturning.model.scene import Scene, gravestone
from overturning.motion.motion import Motion
from overturning.units import GRANITE_DENSITY

if TYPE_CHECKING:
    from overturning.dem.body.plan import SpacePlan

QUEUE: Final = 4096
"""Cases per call of the kernel: long enough to keep the columns full, short enough for the memory to stay flat."""


def plan(scene: Scene, motion: Motion, cases: Cases, numerics: Numerics) -> Plan:
    """Choose the kernel, check the arguments, and work out what each case needs; parameters and errors as of `run`."""
    # Imported here, since with the plan comes the kernel, and Numba.
    if scene.single_block and not numerics.general:
        from overturning.dem.block.plan import plan_block

        return plan_block(scene, motion, cases, numerics)
    from overturning.dem.polygon.plan import plan_polygons

    return plan_polygons(scene, motion, cases, numerics)


def run(scene: Scene, motion: Motion, cases: Cases, numerics: Numerics | None = None) -> Results:
    """Run cases of a scene under one motion.

    Parameters
    ----------
    scene : Scene
        A single block on the ground takes the block's kernel, anything else the general one.
    motion : Motion
        The ground's.
    cases : Cases
        `height` and `b_over_h` are those of the scene's reference element, `friction` that of every contact law
        without one.
    numerics : Numerics, optional
        How they are computed; `Numerics()` where not given.

    Returns
    -------
    Results
        In the order of the cases.

    Raises
    ------
    ArgumentError
        If an argument is outside its bounds, or the time step is not stable.
    """
    numerics = numerics or Numerics()
    if numerics.client is not None:
        return run_on_cluster(partial(run, scene), motion, cases, numerics)
    planned = plan(scene, motion, cases, numerics)
    results = planned.uncomputed()
    run_planned(planned, results.store)
    return results


def run_planned(planned: "Plan | SpacePlan", store: Callable[[NDArray[np.int64], Any], None]) -> None:
    """Compute what of a plan has to be, and store the answers to chosen cases as they come: ``store(chosen, answers)``."""
    counter = np.zeros(1, np.int64)
    moving = np.flatnonzero(~planned.never & ~planned.hopeless)
    length = planned.steps[moving] * np.maximum(planned.motion.samples - planned.first[moving], 1)
    # The longest of a group first, so that the columns empty together.
    order = moving[np.lexsort((-length, planned.group[moving]))]

    def compute(chosen: NDArray[np.int64]) -> None:
        store(chosen, planned.compute(chosen, counter)[0])

    queues = shared_out(order, planned.group, planned.halved)
    run_queues(compute, queues, planned.numerics, counter, int(length.sum()) * planned.free)


def run_cases(
    motion: Motion,
    cases: Cases,
    *,
    density: float = GRANITE_DENSITY,
    contact: Contact | None = None,
    **options: Any,
) -> Results:
    """Run cases of a single block under one motion: `run` on the gravestone.

    Parameters
    ----------
    motion, cases
        As of `run`.
    density : float
        kg/m³; matters only where stiffness or damping are given in absolute terms.
    contact : Contact, optional
        Springs and dashpots; `Contact()` where not given.
    **options
        Fields of `overturning.dem.numerics.Numerics`.

    Returns
    -------
    Results
        In the order of the cases, all of shape (n,).

    Raises
    ------
    ArgumentError
        If an argument is outside its bounds, or the time step is not stable.
    """
    return run(gravestone(contact, density), motion, cases, Numerics(**options)).element(0)


def shared_out(order: NDArray[np.int64], group: NDArray[np.int64], halved: bool) -> list[NDArray[np.int64]]:
    """Queues of cases with the same number in `group` each, from cases ordered by it; long ones `halved` for a second thread."""
    queues = []
    for chosen in np.split(order, np.flatnonzero(np.diff(group[order])) + 1):
        if chosen.size:
            count = max(-(-chosen.size // QUEUE), min(2, chosen.size // 64) if halved else 1)
            # Interleaved, so that each part has its share of long and short cases.
            queues += [chosen[part::count] for part in range(count)]
    return queues


def run_queues(
    compute: Callable[[NDArray[np.int64]], None],
    queues: list[NDArray[np.int64]],
    numerics: Numerics,
    counter: NDArray[np.int64],
    total: int,
) -> None:
    """Run queues on some threads and tell how far they are: `counter` of `total` steps."""
    progress = numerics.progress
    with ThreadPoolExecutor(max_workers=numerics.threads) as pool:
        waiting = {pool.submit(compute, chosen) for chosen in queues}
        while waiting:
            finished, waiting = wait(waiting, timeout=0.2 if progress else None, return_when=FIRST_COMPLETED)
            for future in finished:
                future.result()
            if progress:
                progress(min(int(counter[0]), total), total)
    if progress:
        progress(total, total)
