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

MAX_RERUNS_UNTIL_ENERGY_BALANCES: Final = 2
"""Maximum number of reruns before a case is marked unstable."""


def rerun_until_energy_balances_or_mark_unstable(
    simulate_rows_with_step_divisor: Callable[[NDArray[np.int64], int], None],
    status_by_case: NDArray[Any],
    energy_error_to_input_ratio_by_case: NDArray[Any],
) -> None:
    """Simulate cases; repeat, at most twice and with finer steps, those with an energy error above 1 % of the input.

    Cases whose energy still does not balance after `MAX_RERUNS_UNTIL_ENERGY_BALANCES` reruns get the status `unstable`.

    Parameters
    ----------
    simulate_rows_with_step_divisor : callable
        ``simulate_rows_with_step_divisor(rows, step_divisor)`` fills rows of the results, with steps divided by
        ``step_divisor``. It adds to the number of steps in these rows, so that the budget of a case covers all its
        runs.
    status_by_case, energy_error_to_input_ratio_by_case : ndarray, shape (n,)
        Columns of the results of the n cases, which ``simulate_rows_with_step_divisor`` fills: `CaseStatus`, and error
        of the energy balance over the input energy.
    """
    rows = np.arange(status_by_case.size)
    for again in range(1 + MAX_RERUNS_UNTIL_ENERGY_BALANCES):
        simulate_rows_with_step_divisor(rows, STEP_DIVISOR_PER_RERUN**again)
        rows = rows[
            (status_by_case[rows] == CaseStatus.SIMULATED)
            & ~(energy_error_to_input_ratio_by_case[rows] <= MAX_ENERGY_ERROR_TO_INPUT_ENERGY_RATIO)
        ]
        if not rows.size:
            return
    status_by_case[rows] = CaseStatus.UNSTABLE
