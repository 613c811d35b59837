"""The ensemble: each case run again in a stated neighbourhood, and how often it falls to which side.

It is the spread over that neighbourhood, no more: it says how far the answer depends on what is not known exactly, not
how probable the neighbourhood is.
"""

from collections.abc import Callable
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.cases import Cases
from overturning.dem.variables import INT8_MISSING, Variable
from overturning.motion.motion import Motion
from overturning.study.grid import Grid
from overturning.study.members import Members

REACH = 2
"""Cells on either side of a change of flag along B/H that `where: boundary` runs."""

MOST_GROUND_VALUES = 20_000_000
"""Samples of rotated motion held at a time (160 MB)."""

ENSEMBLE_VARIABLES: Final = (
    Variable(
        "probability_towards",
        "f4",
        {
            "long_name": "share of ensemble members that fall towards the azimuth",
            "units": "1",
            "comment": "spread over the neighbourhood stated in the study; missing where the ensemble was not run",
        },
    ),
    Variable(
        "probability_away",
        "f4",
        {
            "long_name": "share of ensemble members that fall towards the azimuth plus 180 degrees",
            "units": "1",
            "comment": "spread over the neighbourhood stated in the study; missing where the ensemble was not run",
        },
    ),
    Variable(
        "scramble_difference_towards",
        "f4",
        {"long_name": "probability_towards of the first scramble minus that of the second", "units": "1"},
    ),
    Variable(
        "scramble_difference_away",
        "f4",
        {"long_name": "probability_away of the first scramble minus that of the second", "units": "1"},
    ),
    Variable("members", "i2", {"long_name": "ensemble members with an outcome", "units": "1"}),
)


class Runner(Protocol):
    """What runs cases: of blocks or of a scene."""

    def __call__(
        self, motion: Motion, cases: Cases, *, threads: int, progress: Callable[[int, int], None] | None
    ) -> tuple[NDArray[np.int8], int]:
        """Flags, shape (n,) or (n, elements), and the block steps they took."""
        ...


def blocks(**arguments: Any) -> Runner:
    """A runner of single blocks with arguments of `overturning.dem.cases.run_cases`: density, contact, scheme and so on."""
    from overturning.dem.cases import run_cases

    def run(
        motion: Motion, cases: Cases, *, threads: int, progress: Callable[[int, int], None] | None
    ) -> tuple[NDArray[np.int8], int]:
        found = run_cases(motion, cases, threads=threads, progress=progress, **arguments)
        return found.overturned, int(found.block_steps.sum())

    return run


def cells_to_run(overturned: NDArray[np.int8], everywhere: bool) -> NDArray[np.bool_]:
    """Which cells the ensemble runs.

    Parameters
    ----------
    overturned : ndarray, shape (a, h, b, f) or (a, h, b, f, elements)
        Nominal flags; a missing one differs from every other. A change of any element counts.
    everywhere : bool
        All cells.

    Returns
    -------
    ndarray of bool, shape (a, h, b, f)
        Cells within two steps along B/H of a change of flag. With a single B/H there is no such neighbour to tell, and
        all cells are run.
    """
    shape = overturned.shape[:4]
    if everywhere or shape[2] == 1:
        return np.ones(shape, dtype=bool)
    change = overturned[:, :, 1:, :] != overturned[:, :, :-1, :]
    change = change.any(axis=4) if change.ndim > 4 else change
    count = shape[2]
    chosen = np.zeros(shape, dtype=bool)
    for step in range(1 - REACH, REACH + 1):  # a change between i and i + 1 concerns i − 1 to i + 2
        low, high = max(0, -step), min(count - 1, count - step)
        chosen[:, :, low + step : high + step, :] |= change[:, :, low:high, :]
    return chosen


def run_ensemble(
    motion: Motion,
    grid: Grid,
    overturned: NDArray[np.int8],
    mirrored: NDArray[np.int8],
    members: Members,
    *,
    everywhere: bool,
    run: Runner,
    threads: int = 1,
    progress: Callable[[int, int], None] | None = None,
) -> tuple[dict[str, NDArray[Any]], int]:
    """Run the ensemble beside a nominal outcome.

    Parameters
    ----------
    motion : Motion
        The ground's.
    grid : Grid
        The cases.
    overturned, mirrored : ndarray, shape (a, h, b, f)
        The nominal outcome, `overturned` of a scene with a last dimension of elements. Mirrored cells are not run: they mirror their member's tilt with everything else.
    members : Members
        What each member changes.
    everywhere : bool
        Run all cells, not only those near a change of flag.
    run : Runner
        `blocks`, or `overturning.study.scene_sweep.scene_runner`.
    threads : int
        Threads to share the cases among.
    progress : callable, optional
        Called now and then with the work done and the whole work.

    Returns
    -------
    arrays : dict of ndarray, shape (a, h, b, f)
        The variables of `ENSEMBLE_VARIABLES`, missing floats as NaN; all but `members` with the dimension of elements
        where `overturned` has it.
    block_steps : int
        Work done.
    """
    shape = grid.shape
    chosen = cells_to_run(overturned, everywhere) & (mirrored == 0)
    arrays: dict[str, NDArray[Any]] = {
        variable.name: np.full(overturned.shape, np.nan, np.float32)
        if variable.dtype == "f4"
        else np.zeros(shape, np.int16)
        for variable in ENSEMBLE_VARIABLES
    }
    azimuths = np.flatnonzero(chosen.any(axis=(1, 2, 3)))
    group = max(1, MOST_GROUND_VALUES // max(1, members.size * motion.samples))
    work, done = max(1, int(chosen.sum())), 0
    block_steps = 0
    for start in range(0, azimuths.size, group):
        some = np.zeros_like(chosen)
        some[azimuths[start : start + group]] = True
        cells = np.argwhere(chosen & some)

        def step(part: int, whole: int, before: int = done, count: int = len(cells)) -> None:
            if progress:
                progress(int(1000 * (before + count * part / max(whole, 1))), 1000 * work)

        cases = _cases(grid, cells, members)
        found, steps = run(motion, cases, threads=threads, progress=step if progress else None)
        flags = found.reshape(len(cells), members.size, *found.shape[1:])
        _tally(arrays, cells, flags, members)
        done += len(cells)
        block_steps += steps
    _mirror(arrays, grid, mirrored)
    return arrays, block_steps


def _cases(grid: Grid, cells: NDArray[np.int64], members: Members) -> Cases:
    """Every member of every cell, the members of a cell together."""

    def spread(values: NDArray[np.generic], column: int, changed: FloatArray, add: bool) -> FloatArray:
        nominal = values[cells[:, column]].astype(np.float64)[:, None]
        return np.asarray((nominal + changed if add else nominal * changed).ravel())

    def every(changed: FloatArray) -> FloatArray:
        return np.tile(changed, len(cells))

    return Cases(
        azimuth_deg=spread(grid.azimuth, 0, members.azimuth_deg, add=True),
        height=spread(grid.height, 1, np.ones(members.size), add=False),
        b_over_h=spread(grid.b_over_h, 2, members.b_over_h, add=False),
        friction=spread(grid.friction, 3, members.friction, add=False),
        amplitude=every(members.amplitude),
        damping_factor=every(members.damping),
        initial_tilt=every(members.initial_tilt),
    )


def _tally(
    arrays: dict[str, NDArray[Any]], cells: NDArray[np.int64], flags: NDArray[np.int8], members: Members
) -> None:
    where = tuple(cells.T)
    known = flags != INT8_MISSING
    counted = known.sum(axis=1)
    arrays["members"][where] = counted if counted.ndim == 1 else counted.min(axis=1)
    for name, side in (("towards", 1), ("away", -1)):
        fell = flags == side
        shares = []
        for chosen in (np.ones(members.size, dtype=bool), members.scramble == 0, members.scramble == 1):
            count = known[:, chosen].sum(axis=1)
            with np.errstate(invalid="ignore"):
                shares.append(np.where(count > 0, fell[:, chosen].sum(axis=1) / np.maximum(count, 1), np.nan))
        arrays[f"probability_{name}"][where] = shares[0]
        arrays[f"scramble_difference_{name}"][where] = shares[1] - shares[2]


def _mirror(arrays: dict[str, NDArray[Any]], grid: Grid, mirrored: NDArray[np.int8]) -> None:
    """Fill the mirrored cells from those at φ + 180°, towards and away exchanged."""
    from overturning.dem.grid import opposite_azimuths

    source = opposite_azimuths(grid.azimuth.astype(np.float64))
    for index in np.flatnonzero(mirrored.any(axis=(1, 2, 3))):
        opposite = source[index]
        arrays["members"][index] = arrays["members"][opposite]
        for name in ("probability", "scramble_difference"):
            arrays[f"{name}_towards"][index] = arrays[f"{name}_away"][opposite]
            arrays[f"{name}_away"][index] = arrays[f"{name}_towards"][opposite]
