"""How a case is computed: scheme, step, what is left out, and what the computation may take."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from overturning.dem.time_step import DEFAULT_SCHEME
from overturning.errors import ArgumentError

Progress = Callable[[int, int], None]
"""Called now and then with the block steps done and those expected."""

BUDGET: Final = 2_000_000_000
"""Block steps of one case."""

BODY_STEP: Final = 5
"""Block steps that a step of a body in space counts as in the budget, by the time that it takes;"""

ELEMENT_STEP: Final = 20
"""and that of an element of a scene: what a case needs at most is then known within half a minute of processor time."""


@dataclass(frozen=True)
class Numerics:
    """How cases are computed, the same for all of them.

    Parameters
    ----------
    scheme : str
        Integration scheme, "centred", or in planes "cundall"; see docs/method.md.
    time_step : float or str
        Largest step, s; "auto"; or a fraction of the stable step such as "0.25 stable".
    leave_out : bool
        Leave out what a rigid block does not feel: mirrored azimuths, cases below the thresholds of rocking and
        sliding, the time before and after anything can move, and that for which a body that stands cannot be moved.
    refinement : int
        Each step is divided into so many; for verification.
    budget : int
        Block steps of one case, all attempts and reruns together, beyond which it is given up and marked `over_budget`;
        a step of a body counts as `BODY_STEP`, of an element of a scene as `ELEMENT_STEP` of them.
    threads : int
        Threads to share the cases among; the bits do not depend on it.
    progress : callable, optional
        Called now and then with the block steps done and those expected.
    client : dask.distributed.Client, optional
        Cluster whose workers compute the cases; the bits do not depend on it, and a worker that is lost costs time
        only.
    general : bool
        Take the general kernel also where the block's would do.

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
