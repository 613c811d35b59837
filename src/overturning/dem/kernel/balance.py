"""Rerun, with finer steps, of cases whose energy does not balance; for all models."""

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from overturning.model.status import CaseStatus

MAX_ENERGY_ERROR_TO_INPUT_ENERGY_RATIO: Final = 1e-2
"""Largest energy error of a valid case; above it, work and energy do not balance and the flag is missing."""

STEP_DIVISOR_PER_RERUN: Final = 4
"""Refinement factor for each rerun of a case whose energy does not balance."""

MAX_RERUNS: Final = 2
"""Maximum number of reruns before a case is marked unstable."""


def run_cases_until_energy_balances(
    run_case_rows: Callable[[NDArray[np.int64], int], None], status: NDArray[Any], energy_error: NDArray[Any]
) -> None:
    """Simulate cases; repeat those whose energy balance has too large an error, with finer and finer steps.

    Cases whose energy still does not balance after `MAX_RERUNS` reruns get the status `unstable`.

    Parameters
    ----------
    run_case_rows : callable
        ``run_case_rows(rows, step_divisor)`` fills rows of the results, with steps divided by ``step_divisor``. It adds
        to the number of steps in these rows, so that the budget of a case covers all its runs.
    status, energy_error : ndarray, shape (n,)
        Columns of the results of the n cases, which ``run_case_rows`` fills: `CaseStatus` and energy error.
    """
    rows = np.arange(status.size)
    for again in range(1 + MAX_RERUNS):
        run_case_rows(rows, STEP_DIVISOR_PER_RERUN**again)
        rows = rows[
            (status[rows] == CaseStatus.SIMULATED) & ~(energy_error[rows] <= MAX_ENERGY_ERROR_TO_INPUT_ENERGY_RATIO)
        ]
        if not rows.size:
            return
    status[rows] = CaseStatus.UNSTABLE
