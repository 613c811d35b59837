"""A queue of cases through the lanes of a kernel: a finished lane takes the next case.

The queue knows lanes, not stones. A model has a named tuple of rules, which holds all that its cases need, and
functions that are picked by the type of that tuple (`implement`): Numba keeps the machine code of what is picked by
type, but not that of closures. No lane sees another one, so that what a case gets depends on the case alone.
"""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, Protocol

import numpy as np
from numba import njit
from numba.extending import overload
from numpy.typing import NDArray

from overturning.dem.kernel.cache import keep_compiled
from overturning.dem.kernel.ending import GOES_ON
from overturning.dem.kernel.ground import Ground
from overturning.dem.kernel.lanes import INLINE, INNER, OPTIONS, OWNER, QUEUE, aligned, borrowed
from overturning.model.status import Status


class Job(NamedTuple):
    """What holds for all cases of a queue. Numbers alone: whoever takes a tuple with arrays counts a use of each."""

    samples: int
    """Samples of the record;"""
    interval: float
    """time between them, s;"""
    ticks: float
    """ticks of a sample;"""
    at_once: int
    """attempts at a step between two looks at the lanes, none of them beyond the next sample;"""
    weight: int
    """what an attempt counts for in the budget and for progress;"""
    budget: int
    """count after which a case is over its budget;"""
    most_rows: int
    """rows that a path may have;"""
    lanes: int
    """cases side by side."""


class Rules(Protocol):
    """What the rules of all models hold, for cases with the same steps per sample."""

    job: Job
    cases: NDArray[np.void]
    """Table of cases;"""
    row: NDArray[np.int64]
    """row of the ground motion that shakes each case;"""
    results: NDArray[np.void]
    """table to fill, with columns `status`, `steps` and `left_out`, the samples for which a case at rest was not
    followed; steps that it has of earlier runs count for the budget;"""
    ground: Ground
    """motion of the base."""


class Work(Protocol):
    """What a kernel computes in."""

    state: Any
    """Flat array with a row per quantity and a column per lane."""


# What a model does; stubs, for which `implement` gives each model's own functions.


def workspace(rules: Rules) -> Work:
    """Arrays to compute in, a named tuple."""
    raise NotImplementedError


def start(rules: Rules, work: Work, lane: int, case: int) -> None:
    """Put a case into a lane, before its first step."""
    raise NotImplementedError


def load(rules: Rules, work: Work, cases: Any, columns: int) -> None:
    """Begin a sample: load the motion of the base under the first lanes, whose cases are given."""
    raise NotImplementedError


def advance(rules: Rules, work: Work, columns: int, path: Any, noted: int) -> tuple[Any, int]:
    """Compute the steps of a sample and note the way of the first lane; returns the path and the rows that are filled.

    The path may be a longer copy of the one that was given; the number of rows is −1 where there is no room.
    """
    raise NotImplementedError


def count_due(rules: Rules, work: Work, active: int, due: Any) -> int:
    """Mark the lanes that may have ended, by 1 and else 0, and count them; a quick test, for all lanes at once."""
    raise NotImplementedError


def leave_out(rules: Rules, work: Work, cases: Any, active: int, left_out: Any) -> None:
    """Let lanes that are at rest go on as they are by the samples in which the shaking cannot move them; counts these.

    At rest all contacts are pressed, nothing slides, the last step was a long one, and what moves or rings is small
    against the acceleration that the case bears (`overturning.dem.kernel.ground.samples_at_rest`).
    """
    raise NotImplementedError


def ended(rules: Rules, work: Work, lane: int, case: int) -> int:
    """`Status` of a lane whose case has ended, or `GOES_ON`."""
    raise NotImplementedError


def finish(rules: Rules, work: Work, lane: int, case: int, status: int) -> None:
    """Write the results of a lane's case but for its status and its steps."""
    raise NotImplementedError


def implement(rules: type, *functions: Callable[..., Any]) -> None:
    """Let functions with the names of the stubs above answer for models whose rules are of a type."""
    for function in functions:

        def choose(given: Any, *_: Any, function: Callable[..., Any] = function) -> Callable[..., Any] | None:
            return function if given.instance_class is rules else None

        options = OWNER if function.__name__ in {"workspace", "advance"} else INLINE
        overload(globals()[function.__name__], jit_options=options, strict=False)(choose)  # type: ignore[arg-type]


def by_type(table: Mapping[Any, Any]) -> Callable[[Any], Any]:
    """A function, for compiled code too, that gives what a table has for the type of its argument."""

    def found(mark: Any) -> Any:
        return table[type(mark)]

    @overload(found, strict=False)
    def choose(mark: Any) -> Any:
        chosen = table[mark.instance_class]
        return lambda mark: chosen  # noqa: ARG005, Numba wants the same arguments

    return found


@njit(**INNER)
def copy_lane(state: Any, lanes: int, source: int, target: int) -> None:
    """Copy all rows of a lane."""
    for row in range(state.size // lanes):
        state[row * lanes + target] = state[row * lanes + source]


@njit(**OPTIONS)
def with_room(path: Any, rows: int, most: int) -> Any:
    """A structured path with room for some rows, twice as long where it had less, up to `most`; itself beyond that."""
    if rows <= path.shape[0] or rows > most:
        return path
    longer = np.zeros(min(max(rows, 2 * path.shape[0]), most), path.dtype)
    for row in range(path.shape[0]):
        longer[row] = path[row]
    return longer


@njit(**QUEUE)
def run_queue(rules: Any, order: Any, counter: Any, path: Any) -> tuple[Any, int]:
    """Run cases, all with the same steps per sample.

    Parameters
    ----------
    rules : NamedTuple
        Those of the model, with its cases and their results; as of `Rules`.
    order : ndarray of int64, shape (m,)
        The cases to run, in this order.
    counter : ndarray of int64, shape (1,)
        Grows by the steps done; for progress.
    path : ndarray, shape (rows, …)
        Filled with the way of the first case; no rows to leave it out.

    Returns
    -------
    path : ndarray
        The path, in a longer copy where it was too short.
    noted : int
        How many of its rows were filled; −1 where there was no room, in which case the results are not complete.
    """
    rules = borrowed(rules)  # the caller holds on to them
    job, work = rules.job, workspace(rules)
    lanes, steps, results = job.lanes, job.at_once * job.weight, rules.results
    case, done, due = np.zeros(lanes, np.int64), np.zeros(lanes, np.int64), aligned(lanes)
    left_out = np.zeros(lanes, np.int64)
    # Not literals: the counters would have a type of their own, and all they are handed to be compiled twice.
    none = int(np.int64(0))
    active, head, noted, filled = none, none, none, none
    while True:
        while active < lanes and (head < order.size or filled < lanes):
            # Lanes that no case takes hold the first one: nothing undefined is computed beside the others.
            lane = active if head < order.size else filled
            case[lane] = order[head if head < order.size else 0]
            done[lane], left_out[lane] = int(results[case[lane]].steps), none
            start(rules, work, lane, case[lane])
            filled = max(filled, lane + 1)
            if head < order.size:
                active, head = active + 1, head + 1
        if active == 0 or noted < 0:
            return path, noted
        leave_out(rules, work, case, active, left_out)
        columns = (active + 7) // 8 * 8
        load(rules, work, case, columns)
        path, noted = advance(rules, work, columns, path, noted)
        counter[0] += active * steps
        spent = none
        for lane in range(active):
            done[lane] += steps
            spent += 1 if done[lane] >= job.budget else 0
        lane = none if count_due(rules, work, active, due) + spent > 0 else active
        while lane < active:
            status, over = GOES_ON, done[lane] >= job.budget
            if over or due[lane] > 0.0:
                status = ended(rules, work, lane, case[lane])
                # What breaks its bounds without an end in sight is over its budget all the same: a larger budget
                # changes nothing.
                status = Status.OVER_BUDGET if over and status != Status.SIMULATED else status
            if status == GOES_ON:
                lane += 1
                continue
            finish(rules, work, lane, case[lane], status)
            results[case[lane]].status, results[case[lane]].steps = status, done[lane]
            results[case[lane]].left_out = left_out[lane]
            # The last lane moves into the free place.
            active -= 1
            case[lane], done[lane], due[lane] = case[active], done[active], due[active]
            left_out[lane] = left_out[active]
            copy_lane(work.state, lanes, active, lane)


keep_compiled(run_queue)
