"""Simulation of many cases of a model under one motion, distributed to threads."""

from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from functools import partial
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.dem.cluster import simulate_cases_on_cluster
from overturning.dem.numerics import NumericalOptions
from overturning.errors import ArgumentError, refuse_unknown_keywords
from overturning.model.body import Body
from overturning.model.cases import Cases
from overturning.model.falls import model_from_scene_or_shape
from overturning.model.planes import PlanarModel
from overturning.model.results import CaseResults
from overturning.model.scene import Scene
from overturning.model.stack import Stack
from overturning.motion.motion import Accelerogram, Motion, as_motion

if TYPE_CHECKING:
    from overturning.dem.plan import SimulationPlan
    from overturning.model.model import Model
    from overturning.model.shapes import Shape

MAX_CASES_PER_KERNEL_CALL: Final = 4096
"""Largest number of cases per call of a kernel: enough to keep its lanes full, few enough to bound the memory."""


def plan_simulation(model: "Model", motion: Motion, cases: Cases, numerics: NumericalOptions) -> "SimulationPlan":
    """Check the arguments and return the plan (compiled kernel and its input) for simulating cases of a model.

    Parameters and exceptions are those of `simulate_cases`.
    """
    # Imported lazily: importing a plan imports Numba.
    if isinstance(model, Stack):
        from overturning.dem.stack.plan import plan_stack_simulation

        return plan_stack_simulation(model, motion, cases, numerics)
    if isinstance(model, Body):
        from overturning.dem.body import plan as of_bodies

        return of_bodies.plan_body_simulation(model, motion, cases, numerics)
    assert isinstance(model, PlanarModel)
    if model.scene.can_use_single_block_kernel and not numerics.general:
        from overturning.dem.block.plan import plan_block_simulation

        return plan_block_simulation(model, motion, cases, numerics)
    from overturning.dem.polygon.plan import plan_scene_simulation

    return plan_scene_simulation(model, motion, cases, numerics)


def simulate_cases(
    model: "Model | Scene | Shape | str | int | None",
    motion: Motion,
    cases: Cases,
    numerics: NumericalOptions | None = None,
) -> CaseResults:
    """Simulate cases of a model under one motion; return the results in the order of the cases.

    Parameters
    ----------
    model : Model, Scene, Shape, str, int or None
        Model, or an argument of `overturning.model.falls.model_from_scene_or_shape`. A single block on the ground is
        computed by the block kernel, any other scene by the scene kernel, a 3-D body by the body kernel.
    motion : Motion
        Input motion; without a vertical component the base moves horizontally.
    cases : Cases
        Cases to simulate. `height` and `b_over_h` are those of the reference element of a scene; `friction` applies to
        every contact law that has no coefficient.
    numerics : NumericalOptions, optional
        Numerical options; default `NumericalOptions()`.

    Returns
    -------
    CaseResults
        Results in the order of the cases.

    Raises
    ------
    ArgumentError
        If an argument is outside its bounds, or the time step is not stable.
    """
    if not isinstance(cases, Cases):
        raise ArgumentError(f"cases: a {type(cases).__name__}; give Cases(azimuth_deg, height, b_over_h, friction)")
    model, numerics = model_from_scene_or_shape(model), numerics or NumericalOptions()
    if numerics.client is not None:
        distributed: CaseResults = simulate_cases_on_cluster(partial(simulate_cases, model), motion, cases, numerics)
        return distributed
    plan = plan_simulation(model, motion, cases, numerics)
    results = plan.initial_results_at_rest_or_missing()
    counter = np.zeros(1, np.int64)
    moving = np.flatnonzero(~plan.stays_at_rest & ~plan.has_too_soft_contacts)
    length = plan.steps_per_sample[moving] * np.maximum(motion.sample_count - plan.first_simulated_sample[moving], 1)
    # The longest cases of a group first, so that all lanes finish at about the same time.
    order = moving[np.lexsort((-length, plan.parallel_group_by_case[moving]))]

    def simulate_case_group(case_numbers: NDArray[np.int64]) -> None:
        """Simulate the cases with the indices `case_numbers`, and store their outcomes in `results`."""
        results.store_outcomes(case_numbers, plan.simulate_group_with_reruns_on_energy_error(case_numbers, counter)[0])

    case_groups = split_into_case_groups(order, plan.parallel_group_by_case, plan.shares_long_queue_between_two_threads)
    simulate_groups_in_threads(
        simulate_case_group, case_groups, numerics, counter, int(length.sum()) * len(model.free_element_names)
    )
    return results


@refuse_unknown_keywords(NumericalOptions)
def run_cases(
    motion: Accelerogram, cases: Cases, model: "Model | Scene | Shape | str | int | None" = None, **options: Any
) -> CaseResults:
    """Check and simulate a list of cases, which need not form a grid, under one motion; return their results.

    Parameters
    ----------
    motion : Motion or Record
        Input motion; without a vertical component the base moves horizontally.
    cases : Cases
        Cases to simulate, one row each.
    model : Scene, str, int or Shape, optional
        Model, as in `overturning.simulate`; default: a single 2-D block.
    **options
        Fields of `overturning.dem.numerics.NumericalOptions`.

    Returns
    -------
    CaseResults
        One array per variable of the cube, in the order of the cases. A missing flag is −128, a missing number NaN.

    Raises
    ------
    ArgumentError
        If an argument is outside its bounds, or the time step is not stable.
    """
    return simulate_cases(model, as_motion(motion), cases, NumericalOptions(**options))


def split_into_case_groups(
    case_numbers_ordered_by_parallel_group: NDArray[np.int64],
    parallel_group_by_case: NDArray[np.int64],
    share_groups_between_two_threads: bool,
) -> list[NDArray[np.int64]]:
    """Split cases into groups of at most `MAX_CASES_PER_KERNEL_CALL` cases with equal `parallel_group_by_case`.

    `case_numbers_ordered_by_parallel_group` are indices of cases, sorted by their values in `parallel_group_by_case`.
    With `share_groups_between_two_threads`, 128 or more cases with the same value make at least two groups, so that two
    threads share them.
    """
    case_groups = []
    for chosen in np.split(
        case_numbers_ordered_by_parallel_group,
        np.flatnonzero(np.diff(parallel_group_by_case[case_numbers_ordered_by_parallel_group])) + 1,
    ):
        if chosen.size:
            count = max(
                -(-chosen.size // MAX_CASES_PER_KERNEL_CALL),
                min(2, chosen.size // 64) if share_groups_between_two_threads else 1,
            )
            # Interleaved, so that long and short cases are spread evenly.
            case_groups += [chosen[part::count] for part in range(count)]
    return case_groups


def simulate_groups_in_threads(
    simulate_case_group: Callable[[NDArray[np.int64]], None],
    case_groups: list[NDArray[np.int64]],
    numerics: NumericalOptions,
    counter_of_block_steps_done: NDArray[np.int64],
    expected_total_block_steps: int,
) -> None:
    """Simulate groups of cases on `numerics.threads` threads, and report the numbers of block steps done and expected.

    Block steps are time steps × stones; `simulate_case_group` adds to `counter_of_block_steps_done`, shape (1,).
    """
    progress = numerics.progress
    with ThreadPoolExecutor(max_workers=numerics.threads) as pool:
        waiting = {pool.submit(simulate_case_group, chosen) for chosen in case_groups}
        while waiting:
            finished, waiting = wait(waiting, timeout=0.2 if progress else None, return_when=FIRST_COMPLETED)
            for future in finished:
                future.result()
            if progress:
                progress(
                    min(int(counter_of_block_steps_done[0]), expected_total_block_steps), expected_total_block_steps
                )
    if progress:
        progress(expected_total_block_steps, expected_total_block_steps)
