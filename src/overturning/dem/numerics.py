"""Numerical options of a simulation: scheme, time step, omissions, and limits."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from overturning.dem.time_step import DEFAULT_SCHEME
from overturning.errors import ArgumentError

Progress = Callable[[int, int], None]
"""Callback that receives the block steps done and the block steps expected."""

BUDGET: Final = 2_000_000_000
"""Default largest number of block steps of one case."""

BODY_STEP: Final = 5
"""Block steps charged to the budget for one step of a 3-D body, in proportion to its processor time."""

ELEMENT_STEP: Final = 20
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
        `over_budget`. One step of a 3-D body counts as `BODY_STEP`, of a scene element as `ELEMENT_STEP` block steps.
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
        If a number is below 1. Scheme and step are checked with the cases.
    """

    scheme: str = DEFAULT_SCHEME
    time_step: float | str = "auto"
    leave_out: bool = True
    refinement: int = 1
    budget: int = BUDGET
    threads: int = 1
    progress: Progress | None = None
    general: bool = False
    client: Any = None

    def __post_init__(self) -> None:
        for name in ("threads", "refinement", "budget"):
            if getattr(self, name) < 1:
                raise ArgumentError(f"{name}: {getattr(self, name)}; at least 1")
        if self.client is not None and not hasattr(self.client, "submit"):
            raise ArgumentError(f"client: {type(self.client).__name__}; give a dask.distributed.Client()")
