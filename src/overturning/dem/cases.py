"""Many cases under one motion: checked, planned, shared out to threads, and collected in their own order."""

from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait
from dataclasses import dataclass, fields
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.dem.contact import Contact, check_precision
from overturning.dem.quiet import quiet_windows
from overturning.dem.status import Status
from overturning.dem.time_step import DEFAULT_SCHEME, Scheme, scheme_of, stable_step, steps_per_sample
from overturning.dem.variables import INT8_MISSING
from overturning.errors import ArgumentError
from overturning.motion.motion import Motion
from overturning.units import GRANITE_DENSITY, STANDARD_GRAVITY

FloatArray = NDArray[np.float64]
Progress = Callable[[int, int], None]

MOST_CASES: Final = 50_000_000
"""Cases of one call; more would not fit into the memory of an ordinary machine."""

BYTES_PER_CASE: Final = 300
"""Inputs, plan and results together."""

QUEUE: Final = 4096
"""Cases per call of the kernel: long enough to keep the columns full, short enough for the memory to stay flat."""

DEEPEST: Final = 0.2
"""Penetration, in half the smaller side, beyond which the contact law no longer holds."""

ENERGY_BOUND: Final = 1e-2
"""Largest `energy_error` of a simulated case; beyond it work and energy do not balance and the flag is missing."""

BUDGET: Final = 500_000_000
"""Block steps of one case."""

AFTERMATH: Final = 20.0
"""Time after the record, in 1/p, at which a block that may still fall is undecided."""


@dataclass(frozen=True)
class Cases:
    """Blocks to run, one row per case.

    Parameters
    ----------
    azimuth_deg : array_like
        Azimuth of the vertical plane, degrees clockwise from north.
    height : array_like
        H, m.
    b_over_h : array_like
        B/H.
    friction : array_like
        μ.
    amplitude : array_like
        Factor on the whole motion.
    damping_factor : array_like
        Factor on the contact's dashpots.
    initial_tilt : array_like
        θ at the start of the record, rad, at rest on one corner; towards the azimuth where positive.

    Raises
    ------
    ArgumentError
        If lengths differ or a value is outside its bounds.
    """

    azimuth_deg: ArrayLike
    height: ArrayLike
    b_over_h: ArrayLike
    friction: ArrayLike
    amplitude: ArrayLike = 1.0
    damping_factor: ArrayLike = 1.0
    initial_tilt: ArrayLike = 0.0

    def __post_init__(self) -> None:
        given = {item.name: np.asarray(getattr(self, item.name), dtype=np.float64) for item in fields(self)}
        for name, values in given.items():
            if values.ndim > 1:
                raise ArgumentError(f"{name}: shape {values.shape}; give one row with a value per case")
        try:
            arrays = np.broadcast_arrays(*(np.atleast_1d(values) for values in given.values()))
        except ValueError:
            sizes = ", ".join(f"{name} {values.size}" for name, values in given.items())
            raise ArgumentError(f"cases: lengths differ ({sizes}); give one value per case, or one for all") from None
        for name, values in zip(given, arrays, strict=True):
            object.__setattr__(self, name, values)
            lowest, strict = _BOUNDS.get(name, (-np.inf, False))
            wrong = ~np.isfinite(values) | (values < lowest) | (strict & (values == lowest))
            if wrong.any():
                bound = "" if lowest == -np.inf else f" and {'above' if strict else 'at least'} {lowest:g}"
                raise ArgumentError(f"{name}: {values[wrong][0]}; it must be finite{bound}")
        check_count(self.size)
        tilt = np.tan(np.abs(np.minimum(np.abs(np.asarray(self.initial_tilt)), 1.57)))
        if (tilt >= np.asarray(self.b_over_h)).any():
            raise ArgumentError("initial_tilt: the block would fall by itself; it must stay below arctan(B/H)")

    @property
    def size(self) -> int:
        """Number of cases."""
        return int(np.asarray(self.azimuth_deg).size)


_BOUNDS: Final = {
    "height": (0.0, True),
    "b_over_h": (0.0, True),
    "friction": (0.0, False),
    "amplitude": (0.0, False),
    "damping_factor": (0.0, False),
}


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


def check_count(count: int) -> None:
    """Refuse more cases than one call can hold.

    Raises
    ------
    ArgumentError
        With the memory they would take.
    """
    if count == 0:
        raise ArgumentError("cases: none; give at least one azimuth, height, B/H and friction")
    if count > MOST_CASES:
        raise ArgumentError(
            f"cases: {count} at once would take {count * BYTES_PER_CASE / 2**30:.0f} GiB; "
            f"ask for at most {MOST_CASES} per call"
        )


@dataclass(frozen=True)
class Plan:
    """How each case is to be computed: functions of the case and its record alone."""

    scheme: Scheme
    cases: Cases
    row: NDArray[np.int64]
    ground: FloatArray
    upward: FloatArray
    steps: NDArray[np.int64]
    first: NDArray[np.int64]
    calm: FloatArray
    never: NDArray[np.bool_]
    after: FloatArray
    normal: FloatArray
    tangential: FloatArray
    dashpot: FloatArray

    def table(self, chosen: NDArray[np.int64]) -> FloatArray:
        """Rows of the kernel's case table."""
        from overturning.dem import kernel as k

        cases = self.cases
        height, ratio = np.asarray(cases.height)[chosen], np.asarray(cases.b_over_h)[chosen]
        tilt = np.asarray(cases.initial_tilt)[chosen]
        table = np.zeros((chosen.size, k.PARAMETERS))
        table[:, k.P_WIDTH], table[:, k.P_HEIGHT] = ratio * height, height
        table[:, k.P_STIFFNESS], table[:, k.P_TANGENTIAL] = self.normal[chosen], self.tangential[chosen]
        table[:, k.P_DASHPOT] = self.dashpot[chosen]
        table[:, k.P_FRICTION] = np.asarray(cases.friction)[chosen]
        table[:, k.P_ALPHA] = _rounded(np.arctan, ratio)
        table[:, k.P_AMPLITUDE] = np.asarray(cases.amplitude)[chosen]
        table[:, k.P_TILT] = tilt
        table[:, k.P_TILT_COS], table[:, k.P_TILT_SIN] = _rounded(np.cos, tilt), _rounded(np.sin, tilt)
        table[:, k.P_FIRST], table[:, k.P_CALM] = self.first[chosen], self.calm[chosen]
        table[:, k.P_AFTER] = self.after[chosen]
        return table


def _rounded(function: np.ufunc, values: FloatArray) -> FloatArray:
    # libm and SIMD versions of these differ in the last digit between processors; rounding hides it.
    distinct, where = np.unique(values, return_inverse=True)
    return np.round(function(distinct), 12)[where]


def plan(
    motion: Motion,
    cases: Cases,
    *,
    density: float,
    contact: Contact,
    scheme: str,
    time_step: float | str,
    leave_out: bool,
) -> Plan:
    """Check the arguments and work out what each case needs."""
    if not (np.isfinite(density) and density > 0):
        raise ArgumentError(f"density: {density}; it must be finite and above 0 kg/m³")
    method = scheme_of(scheme)
    height, ratio = np.asarray(cases.height), np.asarray(cases.b_over_h)
    width, friction = ratio * height, np.asarray(cases.friction)
    normal, tangential, dashpot = contact.specific(width, height, density)
    dashpot = dashpot * np.asarray(cases.damping_factor)
    azimuths, row = np.unique(np.asarray(cases.azimuth_deg), return_inverse=True)
    ground = np.zeros((azimuths.size, motion.samples + 3))
    for index, azimuth in enumerate(azimuths):
        ground[index, : motion.samples] = motion.along(float(azimuth))
    check_precision(normal, height, 0.0)
    stable = stable_step(method, normal, tangential, dashpot, 0.5 * width, 0.5 * height)
    steps = steps_per_sample(method, time_step, stable, motion.sampling_interval)
    samples = motion.samples
    # 20/p with p = √(3g/4R).
    period = np.sqrt(np.sqrt(width**2 + height**2) / (1.5 * STANDARD_GRAVITY))
    after = samples + np.ceil(AFTERMATH * period / motion.sampling_interval)
    if leave_out:
        first, quiet, never = quiet_windows(
            motion, row, np.asarray(cases.amplitude), ground[:, :samples], np.minimum(ratio, friction)
        )
        tilted = np.asarray(cases.initial_tilt) != 0
        first[tilted], never[tilted] = 0, False
        calm = quiet.astype(np.float64)
    else:
        first, calm, never = np.zeros(cases.size, np.int64), np.full(cases.size, np.inf), np.zeros(cases.size, np.bool_)
    upward = np.zeros(0) if motion.up is None else np.concatenate([motion.up, np.zeros(3)])
    return Plan(
        method, cases, row, ground, upward, steps, first, calm, never, after, normal, tangential, dashpot
    )  # fmt: skip


def run_cases(
    motion: Motion,
    cases: Cases,
    *,
    density: float = GRANITE_DENSITY,
    contact: Contact | None = None,
    scheme: str = DEFAULT_SCHEME,
    time_step: float | str = "auto",
    leave_out: bool = True,
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
    from overturning.dem import kernel as k

    if threads < 1:
        raise ArgumentError(f"threads: {threads}; at least 1")
    how = plan(
        motion, cases, density=density, contact=contact or Contact(), scheme=scheme, time_step=time_step,
        leave_out=leave_out,
    )  # fmt: skip
    results = _empty(cases.size)
    counter = np.zeros(1, np.int64)
    moving = np.flatnonzero(~how.never)
    length = how.steps[moving] * np.maximum(motion.samples - how.first[moving], 1)
    # Cases with equal steps share a queue; the longest first, so that the columns empty together.
    order = moving[np.lexsort((-length, how.steps[moving]))]
    total = int(length.sum())

    def run(chosen: NDArray[np.int64]) -> None:
        out = np.empty((chosen.size, k.RESULTS))
        k.run_queue(
            int(how.scheme), np.arange(chosen.size), how.table(chosen), how.row[chosen], how.ground, how.upward,
            motion.samples, motion.sampling_interval, int(how.steps[chosen[0]]), STANDARD_GRAVITY, DEEPEST, BUDGET,
            counter, np.zeros((0, k.TRAJECTORY)), out,
        )  # fmt: skip
        _store(results, chosen, out)

    with ThreadPoolExecutor(max_workers=threads) as pool:
        waiting = {pool.submit(run, chosen) for chosen in _queues(order, how.steps)}
        while waiting:
            finished, waiting = wait(waiting, timeout=0.2 if progress else None, return_when=FIRST_COMPLETED)
            for future in finished:
                future.result()
            if progress:
                progress(min(int(counter[0]), total), total)
    if progress:
        progress(total, total)
    return results


def _queues(order: NDArray[np.int64], steps: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    queues = []
    for group in np.split(order, np.flatnonzero(np.diff(steps[order])) + 1):
        if group.size:
            parts = -(-group.size // QUEUE)
            # Interleaved, so that each part has its share of long and short cases.
            queues += [group[part::parts] for part in range(parts)]
    return queues


def _empty(count: int) -> CaseResults:
    nothing, zero = np.full(count, np.nan, np.float32), np.zeros(count, np.float32)
    return CaseResults(
        np.zeros(count, np.int8), np.full(count, Status.AT_REST, np.int8), nothing,
        zero, zero.copy(), zero.copy(), zero.copy(), zero.copy(), np.zeros(count, np.int64),
    )  # fmt: skip


def _store(results: CaseResults, chosen: NDArray[np.int64], out: FloatArray) -> None:
    from overturning.dem import kernel as k

    status = out[:, k.R_STATUS].astype(np.int8)
    with np.errstate(invalid="ignore", over="ignore"):
        unbalanced = (status == Status.SIMULATED) & ~(out[:, k.R_ENERGY] <= ENERGY_BOUND)
        status[unbalanced] = Status.UNSTABLE
        answered = status == Status.SIMULATED
        results.status[chosen] = status
        results.overturned[chosen] = np.where(answered, out[:, k.R_SIDE], INT8_MISSING).astype(np.int8)
        results.overturning_time[chosen] = np.where(answered, out[:, k.R_TIME], np.nan)
        results.peak_rotation[chosen] = out[:, k.R_ANGLE]
        results.peak_slip[chosen] = out[:, k.R_SLIP]
        results.residual_slip[chosen] = out[:, k.R_RESIDUAL]
        results.peak_penetration[chosen] = out[:, k.R_DEPTH]
        results.energy_error[chosen] = out[:, k.R_ENERGY]
    results.block_steps[chosen] = out[:, k.R_STEPS].astype(np.int64)
