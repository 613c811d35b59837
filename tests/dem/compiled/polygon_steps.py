"""Steps of a scene, and the elimination of its equations, with counts of the operations; called by Python."""

import numpy as np
from numba import njit

from overturning.dem.kernel.lanes import view_without_reference_counts
from overturning.dem.kernel.queue import allocate_workspace, start_case, update_sample_and_load_motion
from overturning.dem.polygon import equations, rows, submatrices
from overturning.dem.polygon.rules import view_scene_arrays_without_reference_counts
from overturning.dem.polygon.slip import update_rest_poses_slips_and_sample_clock
from overturning.dem.polygon.step import advance_scene_one_step
from overturning.dem.polygon.suspended_pairs import resume_contact_tests_after_motion
from overturning.kernel_cache import cache_compiled_kernel


@cache_compiled_kernel
@njit
def solve_equations_and_count_nonzero_submatrices(state, blocks, links, size):  # type: ignore[no-untyped-def]
    """Solve the equations of elements linked by contacts in `state`; return the number of nonzero 3 × 3 submatrices.

    Returned, too: whether the cleared pattern of nonzero submatrices still marks any, and two values without meaning.
    """
    pattern, matrix = (
        equations.create_empty_nonzero_pattern(size),
        np.zeros(size * size * submatrices.VALUE_COUNT_PER_SUBMATRIX_IN_ALL_LANES),
    )
    for k in range(size):
        pattern.is_submatrix_nonzero[k, k] = True
    for i, k in links:
        if not pattern.is_submatrix_nonzero[i, k]:
            equations.mark_submatrix_nonzero(pattern, i, k)
            equations.mark_submatrix_nonzero(pattern, k, i)
    for i in range(size):
        for k in range(size):
            if pattern.is_submatrix_nonzero[i, k]:
                for number in range(9):
                    for j in range(rows.PARALLEL_CASE_COUNT):
                        place = (
                            (i * size + k) * submatrices.VALUE_COUNT_PER_SUBMATRIX_IN_ALL_LANES
                            + number * rows.PARALLEL_CASE_COUNT
                            + j
                        )
                        matrix[place] = blocks[i, k, number // 3, number % 3]
    equations.solve_velocity_changes_in_place(
        view_without_reference_counts(state), view_without_reference_counts(matrix), pattern, size
    )
    used = pattern.is_submatrix_nonzero.sum()
    equations.clear_nonzero_pattern(pattern)
    # Use the owners once more, so that borrowed arrays are not freed earlier.
    return (
        used,
        pattern.is_submatrix_nonzero.any() or pattern.coupled_higher_index_element_counts.any(),
        matrix[0],
        state[0],
    )


@cache_compiled_kernel
@njit
def subtract_product_and_divide_submatrices(fresh, added, one, other):  # type: ignore[no-untyped-def]
    """Set fresh = −one · other, added −= one · other, and then one = one · other⁻¹ and other = other⁻¹.

    The arguments hold a 3 × 3 submatrix of each of the cases computed in parallel, and are changed in place.
    """
    submatrices.subtract_submatrix_product(fresh, one, other, True)
    submatrices.subtract_submatrix_product(added, one, other, False)
    submatrices.invert_submatrix_in_place(other)
    submatrices.right_multiply_submatrix_by_pivot_inverse(one, other)


@cache_compiled_kernel
@njit
def run_case_and_return_max_tested_pairs_and_state(inputs, samples, sleep):  # type: ignore[no-untyped-def]
    """Simulate one case; return the most element pairs tested in a step after the first, and the final state.

    If `sleep` is False, tests of distant pairs are resumed before each step. A third value returned has no meaning.
    """
    workspace, cases = allocate_workspace(inputs), np.zeros(rows.PARALLEL_CASE_COUNT, np.int64)
    scene, most, state = view_scene_arrays_without_reference_counts(inputs.scene_arrays), 0, workspace.state
    for lane in range(rows.PARALLEL_CASE_COUNT):
        start_case(inputs, workspace, lane, 0)
    for sample in range(samples):
        update_sample_and_load_motion(inputs, workspace, cases, rows.PARALLEL_CASE_COUNT)
        for n in range(inputs.settings.attempted_steps_between_end_checks):
            if not sleep:
                resume_contact_tests_after_motion(state, scene, workspace.pair_contact_test_schedule, np.inf)
            advance_scene_one_step(
                inputs.ground_motion.upward_acceleration, state,
                view_without_reference_counts(workspace.motion_equation_submatrices),
                view_without_reference_counts(workspace.nonzero_pattern),
                view_without_reference_counts(workspace.pair_contact_test_schedule),
                view_without_reference_counts(workspace.moves_relative_to_base), scene,
                inputs.settings.ticks_per_sample,
            )  # fmt: skip
            if n + sample > 0:
                most = max(most, workspace.pair_contact_test_schedule.active_pair_count[0])
        update_rest_poses_slips_and_sample_clock(
            state, scene, inputs.settings.ticks_per_sample, inputs.settings.sampling_interval
        )
    found = state[
        : rows.VALUE_COUNT_PER_CASE_IN_ALL_LANES
        + scene.fall_and_support_table.shape[1] * rows.VALUE_COUNT_PER_ELEMENT_IN_ALL_LANES
    ].copy()
    # Use the owners once more, so that borrowed arrays are not freed earlier.
    held = (
        workspace.array_that_owns_state_memory[0]
        + workspace.motion_equation_submatrices[0]
        + workspace.nonzero_pattern.coupled_higher_index_element_counts[0]
    )
    held += workspace.pair_contact_test_schedule.active_pair_count[0] + workspace.moves_relative_to_base[0]
    return most, found, held + inputs.scene_arrays.initial_state_by_scene_variant[0, 0]
