"""What a computation costs: the least processor time of several runs, which a shared machine disturbs least."""

import time
from collections.abc import Callable
from typing import TypeVar

Result = TypeVar("Result")


def measured(
    run: Callable[[], Result], repeats: int = 3, warm_up: Callable[[], object] | None = None
) -> tuple[Result, float]:
    """Result of a computation and its least processor time, all threads together.

    Parameters
    ----------
    run : callable
        The computation.
    repeats : int
        Runs that are timed.
    warm_up : callable, optional
        What is run before them, to compile; the computation itself where not given.
    """
    (warm_up or run)()
    times = []
    for _ in range(repeats):
        begin = time.process_time()
        result = run()
        times.append(time.process_time() - begin)
    return result, min(times)


def fastest(run: Callable[[], object], repeats: int = 3) -> float:
    """Least processor time of several runs after a warm-up, s."""
    return measured(run, repeats)[1]
