"""Queue of cases for the lanes of a kernel: a lane whose case has ended gets the next case of the queue."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np
from numba import njit
from numba.extending import overload
from numpy.typing import NDArray

from overturning.dem.kernel.ending import CASE_NOT_ENDED
from overturning.dem.kernel.ground import BaseAccelerationsAndMaximaInWindowAhead
from overturning.dem.kernel.lanes import (
    ALLOCATING_INLINE_OPTIONS,
    COMPILE_OPTIONS,
    INLINE_OPTIONS,
    INTERNAL_COMPILE_OPTIONS,
    PYTHON_CALLABLE_COMPILE_OPTIONS,
    cache_line_aligned_zeros,
    view_without_reference_counts,
)
from overturning.kernel_cache import cache_compiled_kernel
from overturning.model.status import CaseStatus


class SettingsCommonToParallelCases(NamedTuple):
    """Settings common to all cases that the kernel computes in parallel; numbers only, as arrays are slow to pass."""

    sample_count: int
    """Number of samples of the record."""
    sampling_interval: float
    """Time between samples, s."""
    ticks_per_sample: float
    """Ticks per sample."""
    attempted_steps_between_end_checks: int
    """Number of attempted steps between two tests of the lanes; none ends after the next sample."""
    free_element_count: int
    """Number of stones: elements that move freely. One attempted step of a case counts as so many block steps."""
    max_steps_times_elements_per_case: int
    """Largest number of attempted steps of a case, times its number of stones; beyond it the case is over budget."""
    max_trajectory_rows: int
    """Largest number of rows of a trajectory."""
    parallel_case_count: int
    """Number of cases computed side by side."""


class KernelInput(Protocol):
    """Input fields common to the kernels of all models, for cases with equal numbers of time steps per sample."""

    settings: SettingsCommonToParallelCases
    """Settings shared by all cases."""
    cases: NDArray[np.void]
    """Table of cases, shape (n,)."""
    motion_row_by_case: NDArray[np.int64]
    """Row of the ground motion for each case, shape (n,)."""
    results: NDArray[np.void]
    """Table to fill, shape (n,), with the columns `status`, `block_steps` (those of earlier runs included) and
    `samples_left_out` (number of samples that were skipped while the case was at rest)."""
    ground_motion: BaseAccelerationsAndMaximaInWindowAhead
    """Motion of the base."""


class ParallelCaseStateArrays(Protocol):
    """Arrays with the states of the cases that a kernel computes in parallel."""

    state: Any
    """Flat array with a row per quantity and a column per lane."""


# Signatures of the functions that each model implements; `register_model_functions` registers the implementations.


def allocate_workspace(kernel_input: KernelInput) -> ParallelCaseStateArrays:
    """Allocate the state arrays, with one column (lane) for each case computed in parallel."""
    raise NotImplementedError


def start_case(kernel_input: KernelInput, workspace: ParallelCaseStateArrays, lane: int, case: int) -> None:
    """Load the initial state of case number `case` into column `lane` of the workspace's state arrays."""
    raise NotImplementedError


def update_sample_and_load_motion(
    kernel_input: KernelInput, workspace: ParallelCaseStateArrays, case_index_by_lane: Any, computed_lane_count: int
) -> None:
    """Load the base motion of the next sample for each of the first `computed_lane_count` cases.

    `case_index_by_lane` holds the index of the case in each lane.
    """
    raise NotImplementedError


def attempt_steps_until_next_check(
    kernel_input: KernelInput,
    workspace: ParallelCaseStateArrays,
    computed_lane_count: int,
    trajectory_of_first_lane: Any,
    recorded_row_count: int,
) -> tuple[Any, int]:
    """Attempt a fixed number of steps of the first `computed_lane_count` cases; record the motion of the first one.

    Returns the trajectory of the first case, in a longer copy of the given array if that was too short, and its number
    of recorded rows. This number is −1 if the trajectory would exceed its largest number of rows.
    """
    raise NotImplementedError


def mark_possibly_ended_cases(
    kernel_input: KernelInput,
    workspace: ParallelCaseStateArrays,
    active_lane_count: int,
    possibly_ended_mark_by_lane_out: Any,
) -> int:
    """Set the mark of each active case to 1 if it may have ended, else to 0; return the number of ones.

    This quick test covers all cases at once; `current_case_status` decides whether a marked case has ended.
    """
    raise NotImplementedError


def skip_samples_too_weak_to_move_resting_cases(
    kernel_input: KernelInput,
    workspace: ParallelCaseStateArrays,
    case_index_by_lane: Any,
    active_lane_count: int,
    skipped_sample_count_by_lane_out: Any,
) -> None:
    """Skip, for cases with a body at rest, the samples in which the base motion is too weak to move it.

    The number of samples skipped in a lane is added to `skipped_sample_count_by_lane_out`.

    At rest all contacts are closed, nothing slides, the last step was a long one, and residual motion and vibration are
    small compared with the acceleration that the body resists (`dem.kernel.ground.count_skippable_samples`).
    """
    raise NotImplementedError


def current_case_status(kernel_input: KernelInput, workspace: ParallelCaseStateArrays, lane: int, case: int) -> int:
    """Return the `CaseStatus` of the case in column `lane` of the state array, `CASE_NOT_ENDED` before its end."""
    raise NotImplementedError


def write_results_of_ended_case(
    kernel_input: KernelInput, workspace: ParallelCaseStateArrays, lane: int, case: int, status: int
) -> None:
    """Write the results of the case in column `lane` of the state array into the table of results.

    The queue itself writes the status of the case and its numbers of steps and skipped samples.
    """
    raise NotImplementedError


def register_model_functions(kernel_input_type: type, *functions: Callable[..., Any]) -> None:
    """Register a model's functions under the type of its kernel input, by which compiled code selects them.

    Each function has the name of a function of this module that only declares the parameters.
    """
    for function in functions:

        def implementation_for_type(
            numba_type_of_kernel_input: Any, *_: Any, model_function: Callable[..., Any] = function
        ) -> Callable[..., Any] | None:
            """Return the model's function if the argument has the type of the model's kernel input, else None."""
            return model_function if numba_type_of_kernel_input.instance_class is kernel_input_type else None

        options = (
            ALLOCATING_INLINE_OPTIONS
            if function.__name__ in {"allocate_workspace", "attempt_steps_until_next_check"}
            else INLINE_OPTIONS
        )
        register = overload(globals()[function.__name__], jit_options=options, strict=False)  # type: ignore[arg-type]
        register(implementation_for_type)


def create_lookup_by_type(value_by_argument_type: Mapping[Any, Any]) -> Callable[[Any], Any]:
    """Return a compiled function that looks up, in `value_by_argument_type`, the value for the type of its argument."""

    def look_up_value_by_argument_type(argument_whose_type_selects_value: Any) -> Any:
        """Return the value for the argument's Python type."""
        return value_by_argument_type[type(argument_whose_type_selects_value)]

    @overload(look_up_value_by_argument_type, strict=False)
    def declare_type_lookup_to_numba(argument_whose_type_selects_value: Any) -> Any:
        """Tell Numba which value `look_up_value_by_argument_type` returns for an argument of this type."""
        entry = value_by_argument_type[argument_whose_type_selects_value.instance_class]
        return lambda argument_whose_type_selects_value: entry  # noqa: ARG005, Numba requires the same arguments

    return look_up_value_by_argument_type


@njit(**INTERNAL_COMPILE_OPTIONS)
def copy_case_state(state_array: Any, lanes_per_state_array_row: int, source_lane: int, target_lane: int) -> None:
    """Copy the state of a case from column `source_lane` of the state array to column `target_lane`."""
    for row in range(state_array.size // lanes_per_state_array_row):
        state_array[row * lanes_per_state_array_row + target_lane] = state_array[
            row * lanes_per_state_array_row + source_lane
        ]


@njit(**COMPILE_OPTIONS)
def grow_trajectory_array_if_needed(trajectory_rows: Any, min_rows: int, max_rows: int) -> Any:
    """Return a trajectory array with space for `min_rows` rows: the given one, or a copy at least twice as long.

    The copy has at most `max_rows` rows. If `min_rows` exceeds `max_rows`, the trajectory is returned unchanged.
    """
    if min_rows <= trajectory_rows.shape[0] or min_rows > max_rows:
        return trajectory_rows
    longer = np.zeros(
        (min(max(min_rows, 2 * trajectory_rows.shape[0]), max_rows), *trajectory_rows.shape[1:]), trajectory_rows.dtype
    )
    for row in range(trajectory_rows.shape[0]):
        longer[row] = trajectory_rows[row]
    return longer


@njit(**PYTHON_CALLABLE_COMPILE_OPTIONS)
def run_case_queue(
    kernel_input: Any,
    case_numbers_in_queue_order: Any,
    counter_of_block_steps_done: Any,
    trajectory_buffer_of_first_case: Any,
) -> tuple[Any, int]:
    """Simulate a group of cases, several in parallel, until all have ended; the next case starts when one has ended.

    All cases have equal numbers of steps per sample.

    Parameters
    ----------
    kernel_input : NamedTuple
        Input of the model's kernel, with the cases and the table of results; see `KernelInput`.
    case_numbers_in_queue_order : ndarray of int64, shape (m,)
        Indices of the cases to run, in this order.
    counter_of_block_steps_done : ndarray of int64, shape (1,)
        Incremented by the block steps done, to show progress.
    trajectory_buffer_of_first_case : ndarray, shape (rows, …)
        Filled with the trajectory of the first case; without rows, no trajectory is recorded.

    Returns
    -------
    trajectory : ndarray
        The trajectory; a longer copy if it was too short.
    recorded : int
        Number of rows filled; −1 if the trajectory has reached its limit, in which case the results are incomplete.
    """
    kernel_input = view_without_reference_counts(kernel_input)  # the caller keeps the arrays alive
    settings, workspace = kernel_input.settings, allocate_workspace(kernel_input)
    lanes, steps, results = (
        settings.parallel_case_count,
        settings.attempted_steps_between_end_checks * settings.free_element_count,
        kernel_input.results,
    )
    case, done, due = np.zeros(lanes, np.int64), np.zeros(lanes, np.int64), cache_line_aligned_zeros(lanes)
    left_out = np.zeros(lanes, np.int64)
    # Force int64; Numba would type these as literals and compile every callee twice.
    none = int(np.int64(0))
    active, head, recorded, filled = none, none, none, none
    while True:
        while active < lanes and (head < case_numbers_in_queue_order.size or filled < lanes):
            # Unused lanes compute the first case too, so that no lane computes with undefined numbers.
            lane = active if head < case_numbers_in_queue_order.size else filled
            case[lane] = case_numbers_in_queue_order[head if head < case_numbers_in_queue_order.size else 0]
            done[lane], left_out[lane] = int(results[case[lane]].block_steps), none
            start_case(kernel_input, workspace, lane, case[lane])
            filled = max(filled, lane + 1)
            if head < case_numbers_in_queue_order.size:
                active, head = active + 1, head + 1
        if active == 0 or recorded < 0:
            return trajectory_buffer_of_first_case, recorded
        skip_samples_too_weak_to_move_resting_cases(kernel_input, workspace, case, active, left_out)
        columns = (active + 7) // 8 * 8
        update_sample_and_load_motion(kernel_input, workspace, case, columns)
        trajectory_buffer_of_first_case, recorded = attempt_steps_until_next_check(
            kernel_input, workspace, columns, trajectory_buffer_of_first_case, recorded
        )
        counter_of_block_steps_done[0] += active * steps
        spent = none
        for lane in range(active):
            done[lane] += steps
            spent += 1 if done[lane] >= settings.max_steps_times_elements_per_case else 0
        lane = none if mark_possibly_ended_cases(kernel_input, workspace, active, due) + spent > 0 else active
        while lane < active:
            status, over = CASE_NOT_ENDED, done[lane] >= settings.max_steps_times_elements_per_case
            if over or due[lane] > 0.0:
                status = current_case_status(kernel_input, workspace, lane, case[lane])
                # A case that is unstable when its budget runs out is reported as over budget.
                status = CaseStatus.OVER_BUDGET if over and status != CaseStatus.SIMULATED else status
            if status == CASE_NOT_ENDED:
                lane += 1
                continue
            write_results_of_ended_case(kernel_input, workspace, lane, case[lane], status)
            results[case[lane]].status, results[case[lane]].block_steps = status, done[lane]
            results[case[lane]].samples_left_out = left_out[lane]
            # The last active lane moves into the free lane.
            active -= 1
            case[lane], done[lane], due[lane] = case[active], done[active], due[active]
            left_out[lane] = left_out[active]
            copy_case_state(workspace.state, lanes, active, lane)


cache_compiled_kernel(run_case_queue)
