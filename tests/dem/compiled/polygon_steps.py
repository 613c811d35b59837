"""Steps of a scene, and the elimination of its equations, with counts of the operations; called by Python."""

import numpy as np
from numba import njit

from overturning.dem.kernel.lanes import borrowed
from overturning.dem.kernel.queue import allocate_workspace, load_motion_of_next_sample, start_case
from overturning.dem.polygon import equations, rows
from overturning.dem.polygon.rules import (
    store_slip_and_support_times_of_sample,
    view_scene_arrays_without_reference_counts,
)
from overturning.dem.polygon.step import advance_scene_one_step
from overturning.dem.polygon.suspended_pairs import resume_contact_tests_after_motion
from overturning.kernel_cache import cache_compiled_kernel


@cache_compiled_kernel
@njit
def solve_equations_and_count_submatrices(state, blocks, links, size):  # type: ignore[no-untyped-def]
    """Solve the equations of elements linked by contacts; return first the number of 3 × 3 submatrices used."""
    pattern, matrix = equations.create_empty_nonzero_pattern(size), np.zeros(size * size * equations.SIZE)
    for k in range(size):
        pattern.used[k, k] = True
    for i, k in links:
        if not pattern.used[i, k]:
            equations.mark_submatrix_nonzero(pattern, i, k)
            equations.mark_submatrix_nonzero(pattern, k, i)
    for i in range(size):
        for k in range(size):
            if pattern.used[i, k]:
                for number in range(9):
                    for j in range(rows.COLUMNS):
                        place = (i * size + k) * equations.SIZE + number * rows.COLUMNS + j
                        matrix[place] = blocks[i, k, number // 3, number % 3]
    equations.solve_velocity_changes(borrowed(state), borrowed(matrix), pattern, size)
    used = pattern.used.sum()
    equations.clear_nonzero_pattern(pattern)
    # Use the owners once more, so that borrowed arrays are not freed earlier.
    return used, pattern.used.any() or pattern.count.any(), matrix[0], state[0]


@cache_compiled_kernel
@njit
def multiply_and_divide_submatrices(fresh, added, one, other):  # type: ignore[no-untyped-def]
    """Set fresh = −one · other, then added −= one · other, then one = one · other⁻¹, in place, in every lane."""
    equations.subtract_submatrix_product(fresh, one, other, True)
    equations.subtract_submatrix_product(added, one, other, False)
    equations.invert_submatrix_in_place(other)
    equations.multiply_by_pivot_inverse(one, other)


@cache_compiled_kernel
@njit
def run_case_and_count_tested_pairs(inputs, samples, sleep):  # type: ignore[no-untyped-def]
    """Simulate one case; return the most element pairs tested in a step after the first, and the elements' state."""
    workspace, cases = allocate_workspace(inputs), np.zeros(rows.COLUMNS, np.int64)
    scene, most, state = view_scene_arrays_without_reference_counts(inputs.scene), 0, workspace.state
    for lane in range(rows.COLUMNS):
        start_case(inputs, workspace, lane, 0)
    for sample in range(samples):
        load_motion_of_next_sample(inputs, workspace, cases, rows.COLUMNS)
        for n in range(inputs.settings.steps_per_check):
            if not sleep:
                resume_contact_tests_after_motion(state, scene, workspace.pairs, np.inf)
            advance_scene_one_step(
                inputs.ground.up, state, borrowed(workspace.matrix), borrowed(workspace.pattern),
                borrowed(workspace.pairs), borrowed(workspace.moves), scene, inputs.settings.ticks,
            )  # fmt: skip
            if n + sample > 0:
                most = max(most, workspace.pairs.count[0])
        store_slip_and_support_times_of_sample(state, scene, inputs.settings.ticks, inputs.settings.interval)
    found = state[: rows.CASE_SIZE + scene.elements.shape[1] * rows.ELEMENT_SIZE].copy()
    # Use the owners once more, so that borrowed arrays are not freed earlier.
    held = workspace.owner[0] + workspace.matrix[0] + workspace.pattern.count[0]
    held += workspace.pairs.count[0] + workspace.moves[0]
    return most, found, held + inputs.scene.initial[0, 0]
