"""Many cases of a model under one motion: planned, shared out to threads, and collected in their own order."""

from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.dem.cluster import run_on_cluster
from overturning.dem.numerics import Numerics
from overturning.errors import suggest_keywords
from overturning.model.body import Body
from overturning.model.cases import Cases
from overturning.model.falls import as_model
from overturning.model.planes import Planes
from overturning.model.results import Results
from overturning.model.scene import Scene
from overturning.motion.motion import Accelerogram, Motion, as_motion

if TYPE_CHECKING:
    from overturning.dem.plan import Plan
    from overturning.model.model import Model
    from overturning.model.shapes import Shape

QUEUE: Final = 4096
"""Cases per call of the kernel: long enough to keep the columns full, short enough for the memory to stay flat."""


def plan_of(model: "Model", motion: Motion, cases: Cases, numerics: Numerics) -> "Plan":
    """Choose the kernel, check the arguments, and work out what each case needs; parameters and errors as of `run`."""
    # Imported here, since with the plan comes the kernel, and Numba.
    if isinstance(model, Body):
        from overturning.dem.body import plan as of_bodies

        return of_bodies.plan_body(model, motion, cases, numerics)
    assert isinstance(model, Planes)
    if model.scene.single_block and not numerics.general:
        from overturning.dem.block.plan import plan_block

        return plan_block(model, motion, cases, numerics)
    from overturning.dem.polygon.plan import plan_polygons

    return plan_polygons(model, motion, cases, numerics)


def run(
    model: "Model | Scene | Shape | str | int | None", motion: Motion, cases: Cases, numerics: Numerics | None = None
) -> Results:
    """Run cases of a model under one motion.

    Parameters
    ----------
    model : Model, Scene, Shape, str, int or None
        As of `overturning.model.falls.as_model`. A single block on the ground takes the block's kernel, any other scene
        the general one, a body in space its own.
    motion : Motion
        The ground's; without a vertical component the base moves level.
    cases : Cases
        `height` and `b_over_h` are those of a scene's reference element, `friction` that of every contact law without
        one.
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
    model, numerics = as_model(model), numerics or Numerics()
    if numerics.client is not None:
        found: Results = run_on_cluster(partial(run, model), motion, cases, numerics)
        return found
    planned = plan_of(model, motion, cases, numerics)
    results = planned.initial_results()
    counter = np.zeros(1, np.int64)
    moving = np.flatnonzero(~planned.stays_at_rest & ~planned.too_soft)
    length = planned.steps[moving] * np.maximum(motion.samples - planned.first[moving], 1)
    # The longest of a group first, so that the columns empty together.
    order = moving[np.lexsort((-length, planned.group[moving]))]

    def compute(chosen: NDArray[np.int64]) -> None:
        results.store(chosen, planned.compute(chosen, counter)[0])

    queues = split_into_queues(order, planned.group, planned.halved)
    run_queues(compute, queues, numerics, counter, int(length.sum()) * len(model.elements))
    return results


@suggest_keywords(Numerics)
def run_cases(
    motion: Accelerogram, cases: Cases, model: "Model | Scene | Shape | str | int | None" = None, **options: Any
) -> Results:
    """Run cases of a model that make no grid.

    Parameters
    ----------
    motion : Motion or Record
        The ground's; without a vertical component the base moves level.
    cases : Cases
        One row for each.
    model : Scene, str, int or Shape, optional
        What stands on the ground, as in `overturning.simulate`; a single block where not given.
    **options
        Fields of `overturning.dem.numerics.Numerics`.

    Returns
    -------
    Results
        An array for each variable of the cube, in the order of the cases. A missing flag is −128, a missing number
        NaN.

    Raises
    ------
    ArgumentError
        If an argument is outside its bounds, or the time step is not stable.
    """
    return run(model, as_motion(motion), cases, Numerics(**options))


def split_into_queues(order: NDArray[np.int64], group: NDArray[np.int64], halved: bool) -> list[NDArray[np.int64]]:
    """Queues of cases with the same number in `group`, by which they are ordered; long ones `halved`."""
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
