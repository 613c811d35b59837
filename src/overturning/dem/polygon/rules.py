"""Functions that the queue calls for scenes of polygons: start a case, compute a sample, skip samples, end a case.

Signs: x points to the azimuth, z up, rotation is positive clockwise (towards the azimuth). The point (p, q) of an
element is at ``(x + c p + s q, z − s p + c q)`` with c, s the cosine and sine of its rotation; a force (X, Z) at the
place (p', q') from the centre has the moment ``q' X − p' Z``. The tangent of a face with outward normal n is
``(−n_z, n_x)``; the force at a contact point is ``f_n n + f_t (n_z, −n_x)`` on the pair's first element.

docs/scenes.md derives the rules, `overturning.dem.polygon.rows` defines the memory layout. A scheme is one file with a
named tuple of constants and a function `advance_scene_one_step`, and an entry in `SCHEME_CONSTANTS` and
`STEP_FUNCTION_BY_SCHEME_CONSTANTS_TYPE`.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.kernel.ending import CASE_NOT_ENDED
from overturning.dem.kernel.ground import (
    BaseAccelerationsAndMaximaInWindowAhead,
    count_skippable_samples,
    is_rest_check_sample,
    next_window_motion_is_below_rest_limit,
)
from overturning.dem.kernel.lanes import (
    INLINE_OPTIONS,
    cache_line_aligned_zeros,
    view_without_reference_counts,
)
from overturning.dem.kernel.queue import (
    SettingsCommonToParallelCases,
    create_lookup_by_type,
    grow_trajectory_array_if_needed,
    register_model_functions,
)
from overturning.dem.polygon import cundall, equations, rows, step, submatrices
from overturning.dem.polygon.arrays import SceneArrays
from overturning.dem.polygon.case_end import case_status
from overturning.dem.polygon.energy import scene_energy
from overturning.dem.polygon.path import (
    TRAJECTORY_COLUMNS_PER_ELEMENT,
    add_first_case_contact_forces_to_trajectory,
    record_base_and_element_motion_of_first_case,
)
from overturning.dem.polygon.resting import all_elements_at_rest_in_initial_position
from overturning.dem.polygon.results import mark_fallen_and_write_case_results
from overturning.dem.polygon.sample import load_base_motion_of_current_sample, normalise_element_cosine_and_sine
from overturning.dem.polygon.slip import update_rest_poses_slips_and_sample_clock
from overturning.dem.polygon.start import CASE_END_TEST_INTERVAL_S, write_initial_case_state, write_initial_pair_states
from overturning.dem.polygon.suspended_pairs import (
    create_contact_test_schedule_of_all_pairs,
    resume_contact_tests_after_motion,
)
from overturning.dem.time_step import IntegrationScheme
from overturning.model.status import CaseStatus

SCHEME_CONSTANTS: Final[dict[IntegrationScheme, Any]] = {
    IntegrationScheme.CUNDALL: cundall.SceneCundallSchemeConstants(),
    IntegrationScheme.CENTRED: step.CentredSchemeLagAndTicksPerStep(),
}
"""Constants of each scheme; their type selects the step function."""

STEP_FUNCTION_BY_SCHEME_CONSTANTS_TYPE: Final = {
    cundall.SceneCundallSchemeConstants: cundall.advance_scene_one_step,
    step.CentredSchemeLagAndTicksPerStep: step.advance_scene_one_step,
}


class SceneKernelInput(NamedTuple):
    """Kernel input for cases of a scene that all have the same number of steps per sample."""

    settings: SettingsCommonToParallelCases
    cases: NDArray[np.void]
    """Case parameters, of type `tables.CASE_TABLE_DTYPE`, shape (cases,)."""
    motion_row_by_case: NDArray[np.int64]
    """Row of the base acceleration for each case, shape (cases,)."""
    results: NDArray[np.void]
    """Results to fill in, of type `tables.RESULT_TABLE_DTYPE`, shape (cases,)."""
    ground_motion: BaseAccelerationsAndMaximaInWindowAhead
    scheme_constants: Any
    """Constants of the scheme, from `SCHEME_CONSTANTS`."""
    rocking_groups_immovable_from_sample: FloatArray
    """Sample from which each group that can move as one stands for good, shape (cases, groups)."""
    scene_variant_index_by_case: NDArray[np.int64]
    """Index of each case's scene variant (size and damping), shape (cases,)."""
    scene_arrays: SceneArrays
    element_result_table: NDArray[np.void]
    """Results of elements to fill in, of type `tables.ELEMENT_RESULT_TABLE_DTYPE`, shape (cases, elements)."""


class ParallelScenesWorkspace(NamedTuple):
    """State, equations and active contacts of the scenes that the kernel simulates in parallel."""

    state: Any
    """Rows of all lanes: a view of `array_that_owns_state_memory` without reference count."""
    array_that_owns_state_memory: Any
    """Array that owns the memory of `state`."""
    motion_equation_submatrices: Any
    """Submatrices of the equations."""
    nonzero_pattern: Any
    """Nonzero pattern of the matrix."""
    pair_contact_test_schedule: Any
    """`PairContactTestSchedule`: pairs tested for contact at each step, and motions at which the distant ones are
    tested again."""
    moves_relative_to_base: Any
    """True for each element that is free or held, False if it moves with the base, shape (elements,)."""


step_function_of_scheme = create_lookup_by_type(STEP_FUNCTION_BY_SCHEME_CONSTANTS_TYPE)
"""Return the step function of a time integration scheme, selected by the type of its constants."""


def allocate_workspace(kernel_input: Any) -> Any:
    """Return empty arrays for the states and the equations of all cases that are computed in parallel."""
    elements, pairs, initial = (
        kernel_input.scene_arrays.fall_and_support_table.shape[1],
        kernel_input.scene_arrays.pair_element_and_piece_indices.shape[0],
        kernel_input.scene_arrays.initial_state_by_scene_variant,
    )
    owner = cache_line_aligned_zeros(initial.shape[1] * rows.PARALLEL_CASE_COUNT)
    moves = np.zeros(elements, np.bool_)
    for i in range(elements):
        moves[i] = (
            initial[
                0,
                (
                    rows.VALUE_COUNT_PER_CASE_IN_ALL_LANES
                    + i * rows.VALUE_COUNT_PER_ELEMENT_IN_ALL_LANES
                    + rows.MOVES_RELATIVE_TO_BASE_ROW_OFFSET
                )
                // rows.PARALLEL_CASE_COUNT,
            ]
            != 0.0
        )
    submatrix_count = elements * elements + equations.IGNORED_BASE_SUBMATRIX_COUNT
    matrix = cache_line_aligned_zeros(submatrix_count * submatrices.VALUE_COUNT_PER_SUBMATRIX_IN_ALL_LANES)
    return ParallelScenesWorkspace(
        view_without_reference_counts(owner),
        owner,
        matrix,
        equations.create_empty_nonzero_pattern(elements),
        create_contact_test_schedule_of_all_pairs(pairs),
        moves,
    )


@njit(**INLINE_OPTIONS)
def view_scene_arrays_without_reference_counts(scene_arrays: Any) -> Any:
    """Return views of a scene's arrays without reference counts, which compiled code would update at every step."""
    layout, parts, sizes = (
        view_without_reference_counts(scene_arrays.pair_element_and_piece_indices),
        view_without_reference_counts(scene_arrays.lowest_and_last_element_index_by_rocking_group),
        view_without_reference_counts(scene_arrays.piece_vertex_counts),
    )
    shapes, elements, limits = (
        view_without_reference_counts(scene_arrays.piece_face_tables),
        view_without_reference_counts(scene_arrays.fall_and_support_table),
        view_without_reference_counts(scene_arrays.termination_limits),
    )
    initial = view_without_reference_counts(scene_arrays.initial_state_by_scene_variant)
    return SceneArrays(
        initial_state_by_scene_variant=initial,
        pair_element_and_piece_indices=layout, lowest_and_last_element_index_by_rocking_group=parts,
        piece_vertex_counts=sizes, piece_face_tables=shapes, fall_and_support_table=elements,
        termination_limits=limits, gravity=scene_arrays.gravity,
    )  # fmt: skip


def start_case(kernel_input: Any, workspace: Any, lane: int, case_index: int) -> None:
    """Load case number `case_index` into column `lane`: the scene at rest, with the case's friction and damping."""
    state, scene, given, v = (
        workspace.state,
        kernel_input.scene_arrays,
        kernel_input.cases[case_index],
        kernel_input.scene_variant_index_by_case[case_index],
    )
    ticks, interval = kernel_input.settings.ticks_per_sample, kernel_input.settings.sampling_interval
    resume_contact_tests_after_motion(state, scene, workspace.pair_contact_test_schedule, np.inf)
    for row in range(scene.initial_state_by_scene_variant.shape[1]):
        state[row * rows.PARALLEL_CASE_COUNT + lane] = scene.initial_state_by_scene_variant[v, row]
    write_initial_case_state(
        state, lane, given, float(v), interval, ticks, kernel_input.scheme_constants.velocity_lag_behind_pose_steps
    )
    for i in range(scene.fall_and_support_table.shape[1]):
        e = rows.slice_element_rows(state, i)
        e[rows.LAST_TIME_ABLE_TO_RETURN_ROW_OFFSET + lane] = e[rows.LAST_TIME_ON_SUPPORT_ROW_OFFSET + lane] = (
            given.first_simulated_sample * interval
        )
    write_initial_pair_states(state, lane, given, scene, scene.piece_face_tables[v])
    state[rows.INITIAL_ENERGY_ROW_OFFSET + lane] = scene_energy(state, lane, scene)


def update_sample_and_load_motion(
    kernel_input: Any,
    workspace: Any,
    case_index_by_lane: Any,
    computed_lane_count: int,  # noqa: ARG001, all lanes are computed
) -> None:
    """Load each case's base motion in its current sample, and rescale (cos θ, sin θ) of each element to length 1."""
    for i in range(workspace.moves_relative_to_base.size):
        normalise_element_cosine_and_sine(rows.slice_element_rows(workspace.state, i))
    ground, samples_per_tick = kernel_input.ground_motion, 1.0 / kernel_input.settings.ticks_per_sample
    load_base_motion_of_current_sample(
        ground.upward_acceleration, workspace.state, ground.horizontal_acceleration, kernel_input.motion_row_by_case,
        case_index_by_lane, samples_per_tick,
    )  # fmt: skip


def attempt_steps_until_next_check(
    kernel_input: Any,
    workspace: Any,
    computed_lane_count: int,  # noqa: ARG001, all lanes are computed
    first_case_trajectory_rows: Any,
    recorded_trajectory_row_count: int,
) -> tuple[Any, int]:
    """Attempt the steps up to the next end check in all cases; return the first case's trajectory and row count.

    The row count is −1 if the trajectory would exceed its largest size.
    """
    advance_scene_one_step, settings, lag = (
        step_function_of_scheme(kernel_input.scheme_constants),
        kernel_input.settings,
        kernel_input.scheme_constants.velocity_lag_behind_pose_steps,
    )
    scene, up, state = (
        view_scene_arrays_without_reference_counts(kernel_input.scene_arrays),
        kernel_input.ground_motion.upward_acceleration,
        workspace.state,
    )
    elements, interval = workspace.moves_relative_to_base.size, settings.sampling_interval
    ticks = settings.ticks_per_sample
    # Without reference counts, which every step would update.
    matrix, pattern, moves = (
        view_without_reference_counts(workspace.motion_equation_submatrices),
        view_without_reference_counts(workspace.nonzero_pattern),
        view_without_reference_counts(workspace.moves_relative_to_base),
    )
    pairs = view_without_reference_counts(workspace.pair_contact_test_schedule)
    with_forces = (
        first_case_trajectory_rows.shape[0] > 0
        and first_case_trajectory_rows.shape[1] > 2 + TRAJECTORY_COLUMNS_PER_ELEMENT * elements
    )
    early = np.zeros((1, first_case_trajectory_rows.shape[1]))
    if first_case_trajectory_rows.shape[0] > 0:
        most_rows = settings.max_trajectory_rows // first_case_trajectory_rows.shape[1]
        # At most two rows: the start and the end of the sample.
        first_case_trajectory_rows = grow_trajectory_array_if_needed(
            first_case_trajectory_rows, recorded_trajectory_row_count + 2, most_rows
        )
        if first_case_trajectory_rows.shape[0] < recorded_trajectory_row_count + 2:
            return first_case_trajectory_rows, -1
    for _ in range(settings.attempted_steps_between_end_checks):
        if first_case_trajectory_rows.shape[0] == 0:
            advance_scene_one_step(up, state, matrix, pattern, pairs, moves, scene, ticks)
            continue
        tick, share = (
            state[rows.TICKS_SINCE_SAMPLE_START_ROW_OFFSET],
            state[rows.ATTEMPTED_STEP_TICKS_ROW_OFFSET] / ticks,
        )
        # Record once for each sample, even if its first step is repeated.
        if (tick == 0.0 or tick == ticks) and not state[rows.STEP_IS_REJECTED_ROW_OFFSET] > 0.0:
            record_base_and_element_motion_of_first_case(
                state, elements, interval, ticks, first_case_trajectory_rows[recorded_trajectory_row_count]
            )
            recorded_trajectory_row_count += 1
        # The forces at the start of the step count only if the step is accepted.
        # Pass array and row index: a slice would cost every step an atomic update of its reference count.
        if with_forces:
            for column in range(early.shape[1]):  # a loop: a slice assignment would compile its error message, too
                early[0, column] = 0.0
            add_first_case_contact_forces_to_trajectory(state, scene, (0.5 - lag) * share, early, early.shape[0] - 1)
        advance_scene_one_step(up, state, matrix, pattern, pairs, moves, scene, ticks)
        if with_forces and not state[rows.STEP_IS_REJECTED_ROW_OFFSET] > 0.0:
            for column in range(early.shape[1]):
                first_case_trajectory_rows[recorded_trajectory_row_count - 1, column] += early[0, column]
            add_first_case_contact_forces_to_trajectory(
                state, scene, (0.5 + lag) * share, first_case_trajectory_rows, recorded_trajectory_row_count - 1
            )
    update_rest_poses_slips_and_sample_clock(state, scene, ticks, interval)
    return first_case_trajectory_rows, recorded_trajectory_row_count


def mark_possibly_ended_cases(
    kernel_input: Any, workspace: Any, computed_lane_count: int, end_test_is_due_by_lane_out: Any
) -> int:
    """Set `end_test_is_due_by_lane_out` to 1 for each case whose end test is due, else 0; return their number."""
    stride, count = max(int(CASE_END_TEST_INTERVAL_S / kernel_input.settings.sampling_interval), 1), 0
    for j in range(computed_lane_count):
        part = workspace.state[rows.CURRENT_SAMPLE_ROW_OFFSET + j] // stride
        end_test_is_due_by_lane_out[j] = (
            1.0 if part != workspace.state[rows.LAST_END_TEST_INTERVAL_INDEX_ROW_OFFSET + j] else 0.0
        )
        workspace.state[rows.LAST_END_TEST_INTERVAL_INDEX_ROW_OFFSET + j] = part
        count += int(end_test_is_due_by_lane_out[j])
    return count


def skip_samples_too_weak_to_move_resting_cases(
    kernel_input: Any,
    workspace: Any,
    case_index_by_lane: Any,
    computed_lane_count: int,
    skipped_sample_count_by_lane_out: Any,
) -> None:
    """Skip, for each case at rest, the samples whose base motion is too weak to move any element."""
    state, ground, row, scene, ticks = (
        workspace.state,
        kernel_input.ground_motion,
        kernel_input.motion_row_by_case,
        kernel_input.scene_arrays,
        kernel_input.scheme_constants.ticks_per_whole_step,
    )
    for j in range(computed_lane_count):
        case = rows.load_scene_state(state, j)
        now = case.current_sample + case.base_acceleration.ticks_since_sample_start * (
            1.0 / kernel_input.settings.ticks_per_sample
        )
        long = case.current_step_length_and_repetitions.length_in_ticks >= ticks and is_rest_check_sample(now)
        # Test the shaking first: testing the elements takes longer.
        quiet = long and next_window_motion_is_below_rest_limit(
            ground, row[case_index_by_lane[j]], now, case.amplitude_factor, case.max_base_acceleration_without_motion_g
        )
        if quiet and all_elements_at_rest_in_initial_position(state, j, scene):
            samples = count_skippable_samples(
                ground,
                row[case_index_by_lane[j]],
                now,
                case.amplitude_factor,
                case.max_base_acceleration_without_motion_g,
            )
            state[rows.CURRENT_SAMPLE_ROW_OFFSET + j] += samples
            skipped_sample_count_by_lane_out[j] += samples


def current_case_status(kernel_input: Any, workspace: Any, lane: int, case_index: int) -> int:
    """Return the `CaseStatus` of case number `case_index` in column `lane`, or `CASE_NOT_ENDED` if the case goes on."""
    status = case_status(
        workspace.state,
        lane,
        kernel_input.scene_arrays,
        kernel_input.rocking_groups_immovable_from_sample[case_index],
        float(kernel_input.settings.sample_count),
        kernel_input.settings.sampling_interval,
    )
    kept = (
        status == CaseStatus.SIMULATED
        and workspace.state[rows.CURRENT_SAMPLE_ROW_OFFSET + lane]
        < kernel_input.cases[case_index].earliest_end_sample_if_decided
    )
    return CASE_NOT_ENDED if kept else status


def write_results_of_ended_case(
    kernel_input: Any,
    workspace: Any,
    lane: int,
    case_index: int,
    case_end_status: int,  # noqa: ARG001
) -> None:
    """Mark fallen elements of case number `case_index`, held in column `lane`; write its results into the tables."""
    mark_fallen_and_write_case_results(
        workspace.state,
        lane,
        kernel_input.scene_arrays,
        kernel_input.results[case_index],
        kernel_input.element_result_table[case_index],
    )


register_model_functions(
    SceneKernelInput, allocate_workspace, start_case, update_sample_and_load_motion, attempt_steps_until_next_check,
    mark_possibly_ended_cases, skip_samples_too_weak_to_move_resting_cases, current_case_status,
    write_results_of_ended_case,
)  # fmt: skip
