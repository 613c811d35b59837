"""Numerical options of a simulation: scheme, time step, limits, and whether needless computations are skipped."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from overturning.dem.time_step import DEFAULT_SCHEME
from overturning.errors import REASON_SEPARATOR, ArgumentError

if TYPE_CHECKING:
    from distributed import Client

ProgressCallback = Callable[[int, int], None]
"""Callback that receives the block steps done and the block steps expected."""

DEFAULT_MAX_BLOCK_STEPS_PER_CASE: Final = 2_000_000_000
"""Default largest number of block steps of one case."""

MAX_BUDGET_IN_BLOCK_STEPS: Final = 10**15
"""Largest budget, in block steps: a case would run for years."""

MAX_REFINEMENT: Final = 65_536
"""Largest refinement: numbers of steps then stay below the largest integer of the kernels."""

BODY_STEP_COST_IN_BLOCK_STEPS: Final = 5
"""Block steps charged to the budget for one step of a 3-D body, in proportion to its processor time."""

ELEMENT_STEP_COST_IN_BLOCK_STEPS: Final = 20
"""Block steps charged to the budget for one step of one scene element."""


@dataclass(frozen=True)
class NumericalOptions:
    """Numerical options of a simulation, the same for all its cases.

    Parameters
    ----------
    scheme : str
        Integration scheme, "centred", or "cundall" for planar models; see docs/method.md.
    time_step : float or str
        Largest step, s; "auto"; or a fraction of the stable step such as "0.25 stable".
    leave_out : bool
        Skip computations that cannot change the outcome: mirrored azimuths, cases below the thresholds of rocking and
        sliding, and times at which the input motion cannot move a body at rest.
    refinement : int
        Number of parts into which each step is divided; for verification.
    budget : int
        Largest number of block steps of one case, including rejected steps and reruns; beyond it the case is marked
        `CaseStatus.OVER_BUDGET`. One step of a 3-D body counts as `BODY_STEP_COST_IN_BLOCK_STEPS`, of a scene element
        as `ELEMENT_STEP_COST_IN_BLOCK_STEPS` block steps.
    threads : int
        Number of threads; results are bit-equal for any number.
    progress : callable, optional
        Callback that receives the block steps done and the block steps expected.
    client : dask.distributed.Client, optional
        Cluster whose workers compute the cases; results are bit-equal, also if a worker is lost.
    general : bool
        Use the general scene kernel even for a single block.

    Raises
    ------
    ArgumentError
        If a number is below 1 or above its bound (`MAX_REFINEMENT`, `MAX_BUDGET_IN_BLOCK_STEPS`). Scheme and step are
        checked with the cases.
    """

    scheme: str = DEFAULT_SCHEME
    time_step: float | str = "auto"
    leave_out: bool = True
    refinement: int = 1
    budget: int = DEFAULT_MAX_BLOCK_STEPS_PER_CASE
    threads: int = 1
    progress: ProgressCallback | None = None
    general: bool = False
    client: "Client | None" = None

    def __post_init__(self) -> None:
        faults = [
            f"{name}: {value!r}; give a whole number, at least 1"
            for name in ("threads", "refinement", "budget")
            if isinstance(value := getattr(self, name), bool | np.bool_)
            or not isinstance(value, int | np.integer)
            or value < 1
        ]
        faults += [
            f"{name}: {str(value)[:40]}; give at most {largest}"
            for name, largest in (("refinement", MAX_REFINEMENT), ("budget", MAX_BUDGET_IN_BLOCK_STEPS))
            if isinstance(value := getattr(self, name), int | np.integer) and value > largest
        ]
        faults += [
            f"{name}: {value!r}; give True or False"
            for name in ("leave_out", "general")
            if not isinstance(value := getattr(self, name), bool | np.bool_)
        ]
        if isinstance(self.time_step, bool) or not isinstance(self.time_step, str | int | float | np.number):
            faults.append(f"time_step: {self.time_step!r}; give a number of seconds, 'auto', or such as '0.25 stable'")
        if self.progress is not None and not callable(self.progress):
            faults.append(f"progress: {self.progress!r}; give a function of two numbers, or leave it out")
        if self.client is not None and not hasattr(self.client, "submit"):
            faults.append(f"client: {type(self.client).__name__}; give a dask.distributed.Client()")
        if faults:
            raise ArgumentError(REASON_SEPARATOR.join(faults))
