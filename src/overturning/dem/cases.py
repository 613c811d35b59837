"""Many cases under one motion: checked, planned, shared out to threads, and collected in their own order."""

from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from overturning.dem.blocks import Cases
from overturning.dem.contact import Contact
from overturning.dem.plan import DEEPEST, plan
from overturning.dem.status import Status
from overturning.dem.time_step import DEFAULT_SCHEME
from overturning.dem.variables import INT8_MISSING
from overturning.errors import ArgumentError
from overturning.motion.motion import Motion
from overturning.units import GRANITE_DENSITY, STANDARD_GRAVITY

FloatArray = NDArray[np.float64]
Progress = Callable[[int, int], None]

QUEUE: Final = 4096
"""Cases per call of the kernel: long enough to keep the columns full, short enough for the memory to stay flat."""

ENERGY_BOUND: Final = 1e-2
"""Largest `energy_error` of a simulated case; beyond it work and energy do not balance and the flag is missing."""

BUDGET: Final = 500_000_000
"""Block steps of one case."""


@dataclass(frozen=True)
class CaseResults:
    """What came of each case; arrays of shape (n,), named and typed like the cube's variables.

    Attributes
    ----------
    overturned : int8
        +1 fallen towards the azimuth, −1 away from it, 0 standing, −128 where there is no answer.
    status : int8
        A `Status`.
    overturning_time : float32
        s after the record's start; NaN where the block does not fall.
    peak_rotation : float32
        Largest abs(θ)/α.
    peak_slip, residual_slip : float32
        Of the base's midpoint, m; the peak is a magnitude, the residual positive towards the azimuth.
    peak_penetration : float32
        m.
    energy_error : float32
        Residual of work and energy over the larger of input and m g R (1 − cos α).
    block_steps : int64
        Steps computed.
    """

    overturned: NDArray[np.int8]
    status: NDArray[np.int8]
    overturning_time: NDArray[np.float32]
    peak_rotation: NDArray[np.float32]
    peak_slip: NDArray[np.float32]
    residual_slip: NDArray[np.float32]
    peak_penetration: NDArray[np.float32]
    energy_error: NDArray[np.float32]
    block_steps: NDArray[np.int64]

    @classmethod
    def at_rest(cls, count: int, *elements: int) -> Self:
        """Results of cases none of which moves; `elements` is the rest of the shape of what each element has."""
        shape = (count, *elements)
        return cls(
            np.zeros(shape, np.int8), np.full(count, Status.AT_REST, np.int8), np.full(shape, np.nan, np.float32),
            np.zeros(shape, np.float32), np.zeros(shape, np.float32), np.zeros(shape, np.float32),
            np.zeros(count, np.float32), np.zeros(count, np.float32), np.zeros(count, np.int64),
        )  # fmt: skip

    def store(
        self, chosen: NDArray[np.int64], status: FloatArray, depth: FloatArray, energy: FloatArray, steps: FloatArray,
        side: FloatArray, time: FloatArray, angle: FloatArray, slip: FloatArray, residual: FloatArray,
    ) -> None:  # fmt: skip
        """Put in what the kernel found for the chosen cases; where work and energy do not balance there is no answer.

        `side` and what follows it have the shape of `overturned`.
        """
        found = status.astype(np.int8)
        with np.errstate(invalid="ignore", over="ignore"):
            found[(found == Status.SIMULATED) & ~(energy <= ENERGY_BOUND)] = Status.UNSTABLE
            answered = (found == Status.SIMULATED).reshape(-1, *(1,) * (side.ndim - 1))
            self.status[chosen] = found
            self.overturned[chosen] = np.where(answered, side, INT8_MISSING).astype(np.int8)
            self.overturning_time[chosen] = np.where(answered, time, np.nan)
            self.peak_rotation[chosen] = angle
            self.peak_slip[chosen] = slip
            self.residual_slip[chosen] = residual
            self.peak_penetration[chosen] = depth
            self.energy_error[chosen] = energy
        self.block_steps[chosen] = steps.astype(np.int64)


def run_cases(
    motion: Motion,
    cases: Cases,
    *,
    density: float = GRANITE_DENSITY,
    contact: Contact | None = None,
    scheme: str = DEFAULT_SCHEME,
    time_step: float | str = "auto",
    leave_out: bool = True,
    refinement: int = 1,
    budget: int = BUDGET,
    threads: int = 1,
    progress: Progress | None = None,
) -> CaseResults:
    """Run cases under one motion.

    Parameters
    ----------
    motion : Motion
        The ground's.
    cases : Cases
        The blocks.
    density : float
        kg/m³; matters only where stiffness or damping are given in absolute terms.
    contact : Contact, optional
        Springs and dashpots; `Contact()` where not given.
    scheme : str
        Integration scheme.
    time_step : float or str
        Largest step, s; "auto"; or a fraction of the stable step such as "0.25 stable".
    leave_out : bool
        Leave out what changes no flag: cases below both thresholds, the time before and after they can move.
    refinement : int
        Each step is divided into so many; for verification.
    budget : int
        Block steps of one case, beyond which it is given up and marked `over_budget`.
    threads : int
        Threads to share the cases among; the bits do not depend on it.
    progress : callable, optional
        Called now and then with the block steps done and those expected.

    Returns
    -------
    CaseResults
        In the order of the cases.

    Raises
    ------
    ArgumentError
        If an argument is outside its bounds, or the time step is not stable.
    """
    from overturning.dem.block import queue as kernel
    from overturning.dem.block import tables as k

    check_positive(threads=threads, refinement=refinement, budget=budget)
    how = plan(
        motion, cases, density=density, contact=contact or Contact(), scheme=scheme, time_step=time_step,
        leave_out=leave_out, refinement=refinement,
    )  # fmt: skip
    results = CaseResults.at_rest(cases.size)
    counter = np.zeros(1, np.int64)
    moving = np.flatnonzero(~how.never)
    length = how.steps[moving] * np.maximum(motion.samples - how.first[moving], 1)
    # Cases with equal steps, all with friction or all without, share a queue; the longest first, so that the columns empty together.
    smooth = (np.asarray(cases.friction) == 0).astype(np.int64)
    kind = 2 * how.steps + smooth
    order = moving[np.lexsort((-length, kind[moving]))]
    total = int(length.sum())
    ground = kernel.Ground(how.ground, how.upward, motion.samples, motion.sampling_interval)
    limits = kernel.Limits(STANDARD_GRAVITY, DEEPEST, budget)

    def run(chosen: NDArray[np.int64]) -> None:
        out = np.empty((chosen.size, k.RESULTS))
        friction = np.asarray(cases.friction)[chosen] if smooth[chosen[0]] == 0 else None
        kernel.run_queue(
            kernel.SCHEMES[how.scheme][0], np.arange(chosen.size), how.table(chosen), how.row[chosen], friction, ground,
            int(how.steps[chosen[0]]), limits, counter, np.zeros((0, k.TRAJECTORY)), out,
        )  # fmt: skip
        results.store(
            chosen, out[:, k.R_STATUS], out[:, k.R_DEPTH], out[:, k.R_ENERGY], out[:, k.R_STEPS], out[:, k.R_SIDE],
            out[:, k.R_TIME], out[:, k.R_ANGLE], out[:, k.R_SLIP], out[:, k.R_RESIDUAL],
        )  # fmt: skip

    queues = shared_out(order, kind, lambda count: -(-count // QUEUE))
    run_queues(run, queues, threads, counter, total, progress)
    return results


def check_positive(**numbers: int) -> None:
    """Refuse a number below 1."""
    for name, number in numbers.items():
        if number < 1:
            raise ArgumentError(f"{name}: {number}; at least 1")


def shared_out(
    order: NDArray[np.int64], kind: NDArray[np.int64], parts: Callable[[int], int]
) -> list[NDArray[np.int64]]:
    """Queues of cases of one kind each, from cases ordered by kind; `parts` says into how many so many are divided."""
    queues = []
    for group in np.split(order, np.flatnonzero(np.diff(kind[order])) + 1):
        if group.size:
            count = parts(group.size)
            # Interleaved, so that each part has its share of long and short cases.
            queues += [group[part::count] for part in range(count)]
    return queues


def run_queues(
    run: Callable[[NDArray[np.int64]], None], queues: list[NDArray[np.int64]], threads: int, counter: NDArray[np.int64],
    total: int, progress: Progress | None,
) -> None:  # fmt: skip
    """Run queues on some threads and tell how far they are: `counter` of `total` steps."""
    with ThreadPoolExecutor(max_workers=threads) as pool:
        waiting = {pool.submit(run, chosen) for chosen in queues}
        while waiting:
            finished, waiting = wait(waiting, timeout=0.2 if progress else None, return_when=FIRST_COMPLETED)
            for future in finished:
                future.result()
            if progress:
                progress(min(int(counter[0]), total), total)
    if progress:
        progress(total, total)
