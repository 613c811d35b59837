"""Queue of cases for the lanes of a kernel: a lane whose case has ended takes the next case.

The queue is independent of the model. Each model has a named tuple with the input of its kernel, and functions that
are selected by the type of that tuple (`register_implementations`): Numba caches machine code selected by type, but not
that of closures. Lanes do not share data, so the result of a case depends on the case alone.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np
from numba import njit
from numba.extending import overload
from numpy.typing import NDArray

from overturning.dem.kernel.cache import cache_compiled_kernel
from overturning.dem.kernel.ending import GOES_ON
from overturning.dem.kernel.ground import Ground
from overturning.dem.kernel.lanes import INLINE, INNER, OPTIONS, OWNER, QUEUE, aligned_zeros, borrowed
from overturning.model.status import Status


class QueueSettings(NamedTuple):
    """Settings shared by all cases of a queue. Scalars only: passing a tuple of arrays increments reference counts."""

    samples: int
    """Number of samples of the record."""
    interval: float
    """Time between samples, s."""
    ticks: float
    """Ticks per sample."""
    steps_per_check: int
    """Number of attempted steps between two tests of the lanes; none ends after the next sample."""
    step_weight: int
    """Block steps charged to the budget, and to progress, for one attempted step."""
    budget: int
    """Largest number of block steps of a case."""
    max_rows: int
    """Largest number of rows of a path."""
    lanes: int
    """Number of cases computed side by side."""


class KernelInput(Protocol):
    """Fields that the kernel input of every model has, for cases with the same number of steps per sample."""

    settings: QueueSettings
    """Settings shared by all cases."""
    cases: NDArray[np.void]
    """Table of cases, shape (n,)."""
    row: NDArray[np.int64]
    """Row of the ground motion for each case, shape (n,)."""
    results: NDArray[np.void]
    """Table to fill, shape (n,), with the columns `status`, `block_steps` (those of earlier runs included) and
    `samples_left_out` (number of samples that were skipped while the case was at rest)."""
    ground: Ground
    """Motion of the base."""


class KernelWorkspace(Protocol):
    """Arrays in which a kernel keeps the state of the cases that it computes."""

    state: Any
    """Flat array with a row per quantity and a column per lane."""


# Signatures of the functions that each model implements; `register_implementations` registers the implementations.


def allocate_workspace(inputs: KernelInput) -> KernelWorkspace:
    """Return the arrays that the kernel computes in, a named tuple."""
    raise NotImplementedError


def start_case(inputs: KernelInput, workspace: KernelWorkspace, lane: int, case: int) -> None:
    """Put a case into a lane (a column of the arrays), before its first step."""
    raise NotImplementedError


def load_sample_motion(inputs: KernelInput, workspace: KernelWorkspace, cases: Any, lane_count: int) -> None:
    """Begin a sample: load the base motion of the first `lane_count` lanes; `cases` holds the case of each lane."""
    raise NotImplementedError


def advance_one_sample(
    inputs: KernelInput, workspace: KernelWorkspace, lane_count: int, path: Any, recorded_rows: int
) -> tuple[Any, int]:
    """Compute the steps of a sample and record the path of the first lane; return the path and its number of rows.

    The returned path may be a longer copy of `path`. The number of rows is −1 if the path has reached its limit.
    """
    raise NotImplementedError


def mark_ending_lanes(inputs: KernelInput, workspace: KernelWorkspace, active_count: int, marks: Any) -> int:
    """Set `marks` to 1 for each lane that may have ended and to 0 for the others; return the number of ones.

    A quick test for all lanes at once; `lane_end_status` decides.
    """
    raise NotImplementedError


def skip_quiet_samples(
    inputs: KernelInput, workspace: KernelWorkspace, cases: Any, active_count: int, skipped_samples: Any
) -> None:
    """Skip, in lanes at rest, samples in which the motion cannot move the body; add their number to `skipped_samples`.

    At rest all contacts are closed, nothing slides, the last step was a long one, and residual motion and vibration are
    small compared with the acceleration that the body resists (`dem.kernel.ground.count_skippable_samples`).
    """
    raise NotImplementedError


def lane_end_status(inputs: KernelInput, workspace: KernelWorkspace, lane: int, case: int) -> int:
    """Return the `Status` of a lane whose case has ended, or `GOES_ON`."""
    raise NotImplementedError


def write_lane_results(inputs: KernelInput, workspace: KernelWorkspace, lane: int, case: int, status: int) -> None:
    """Write the results of a lane's case, except status, steps and skipped samples."""
    raise NotImplementedError


def register_implementations(input_type: type, *functions: Callable[..., Any]) -> None:
    """Register the functions of a model, named like those above, for kernel input of the type `input_type`."""
    for function in functions:

        def choose(actual: Any, *_: Any, function: Callable[..., Any] = function) -> Callable[..., Any] | None:
            return function if actual.instance_class is input_type else None

        options = OWNER if function.__name__ in {"allocate_workspace", "advance_one_sample"} else INLINE
        overload(globals()[function.__name__], jit_options=options, strict=False)(choose)  # type: ignore[arg-type]


def lookup_by_type(value_by_type: Mapping[Any, Any]) -> Callable[[Any], Any]:
    """Return a function, usable in compiled code, that looks up the type of its argument in a table."""

    def look_up(mark: Any) -> Any:
        return value_by_type[type(mark)]

    @overload(look_up, strict=False)
    def choose(mark: Any) -> Any:
        entry = value_by_type[mark.instance_class]
        return lambda mark: entry  # noqa: ARG005, Numba requires the same arguments

    return look_up


@njit(**INNER)
def copy_lane(state: Any, lanes: int, source: int, target: int) -> None:
    """Copy the state of the case in lane (column) `source` to lane `target`."""
    for row in range(state.size // lanes):
        state[row * lanes + target] = state[row * lanes + source]


@njit(**OPTIONS)
def path_with_room(path: Any, min_rows: int, max_rows: int) -> Any:
    """Return a path with at least `min_rows` rows: the same one, or a copy twice as long or longer, up to `max_rows`.

    If `min_rows` exceeds `max_rows`, the path is returned unchanged.
    """
    if min_rows <= path.shape[0] or min_rows > max_rows:
        return path
    longer = np.zeros(min(max(min_rows, 2 * path.shape[0]), max_rows), path.dtype)
    for row in range(path.shape[0]):
        longer[row] = path[row]
    return longer


@njit(**QUEUE)
def run_queue(inputs: Any, ordered_cases: Any, steps_done: Any, path: Any) -> tuple[Any, int]:
    """Run cases, all with the same steps per sample.

    Parameters
    ----------
    inputs : NamedTuple
        Input of the model's kernel, with the cases and the table of results; see `KernelInput`.
    ordered_cases : ndarray of int64, shape (m,)
        Indices of the cases to run, in this order.
    steps_done : ndarray of int64, shape (1,)
        Incremented by the block steps done, to show progress.
    path : ndarray, shape (rows, …)
        Filled with the path of the first case; pass an array without rows if the path is not needed.

    Returns
    -------
    path : ndarray
        The path; a longer copy if it was too short.
    recorded : int
        Number of rows filled; −1 if the path has reached its limit, in which case the results are incomplete.
    """
    inputs = borrowed(inputs)  # the caller keeps the arrays alive
    settings, workspace = inputs.settings, allocate_workspace(inputs)
    lanes, steps, results = settings.lanes, settings.steps_per_check * settings.step_weight, inputs.results
    case, done, due = np.zeros(lanes, np.int64), np.zeros(lanes, np.int64), aligned_zeros(lanes)
    left_out = np.zeros(lanes, np.int64)
    # Force int64; Numba would type these as literals and compile every callee twice.
    none = int(np.int64(0))
    active, head, recorded, filled = none, none, none, none
    while True:
        while active < lanes and (head < ordered_cases.size or filled < lanes):
            # Unused lanes compute the first case too, so that no lane computes with undefined numbers.
            lane = active if head < ordered_cases.size else filled
            case[lane] = ordered_cases[head if head < ordered_cases.size else 0]
            done[lane], left_out[lane] = int(results[case[lane]].block_steps), none
            start_case(inputs, workspace, lane, case[lane])
            filled = max(filled, lane + 1)
            if head < ordered_cases.size:
                active, head = active + 1, head + 1
        if active == 0 or recorded < 0:
            return path, recorded
        skip_quiet_samples(inputs, workspace, case, active, left_out)
        columns = (active + 7) // 8 * 8
        load_sample_motion(inputs, workspace, case, columns)
        path, recorded = advance_one_sample(inputs, workspace, columns, path, recorded)
        steps_done[0] += active * steps
        spent = none
        for lane in range(active):
            done[lane] += steps
            spent += 1 if done[lane] >= settings.budget else 0
        lane = none if mark_ending_lanes(inputs, workspace, active, due) + spent > 0 else active
        while lane < active:
            status, over = GOES_ON, done[lane] >= settings.budget
            if over or due[lane] > 0.0:
                status = lane_end_status(inputs, workspace, lane, case[lane])
                # A case that is unstable when its budget runs out is reported as over budget.
                status = Status.OVER_BUDGET if over and status != Status.SIMULATED else status
            if status == GOES_ON:
                lane += 1
                continue
            write_lane_results(inputs, workspace, lane, case[lane], status)
            results[case[lane]].status, results[case[lane]].block_steps = status, done[lane]
            results[case[lane]].samples_left_out = left_out[lane]
            # The last active lane moves into the free lane.
            active -= 1
            case[lane], done[lane], due[lane] = case[active], done[active], due[active]
            left_out[lane] = left_out[active]
            copy_lane(workspace.state, lanes, active, lane)


cache_compiled_kernel(run_queue)
