"""Cases whose energy does not balance are computed again with finer steps, for all models."""

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.model.status import Status

ENERGY_BOUND: Final = 1e-2
"""Largest energy error of a simulated case; beyond it work and energy do not balance and the flag is missing."""

FINER: Final = 4
"""A case whose energy does not balance is computed again with steps so many times shorter, all of them,"""

MOST_AGAIN: Final = 2
"""and so often, before it is marked."""


def until_balanced(run: Callable[[NDArray[np.int64], int], None], status: NDArray[Any], error: NDArray[Any]) -> None:
    """Run cases, those in which work and energy do not balance again with finer steps, and mark what still does not.

    Parameters
    ----------
    run : callable
        ``run(rows, finer)`` fills these rows of the results with steps so many times finer than planned. It counts on
        from the steps that it finds there, so that the budget of a case is that of all its runs.
    status, error : ndarray, shape (n,)
        Views of the results: `Status` and energy error.
    """
    rows = np.arange(status.size)
    for again in range(1 + MOST_AGAIN):
        run(rows, FINER**again)
        rows = rows[(status[rows] == Status.SIMULATED) & ~(error[rows] <= ENERGY_BOUND)]
        if not rows.size:
            return
    status[rows] = Status.UNSTABLE
