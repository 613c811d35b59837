"""The ensemble: each case run again in a stated neighbourhood, and how often it falls to which side.

It is the spread over that neighbourhood, no more: it says how far the answer depends on what is not known exactly, not
how probable the neighbourhood is.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from statistics import NormalDist
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.dem.numerics import Progress
from overturning.model.cases import Cases
from overturning.model.grid import Grid
from overturning.model.model import Model
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion
from overturning.study.members import Members

Z_95: Final = NormalDist().inv_cdf(0.975)
"""Two-sided 95 % point of the normal distribution."""

REACH = 2
"""Cells on either side of a change of flag along B/H that `where: boundary` runs."""

BATCH: Final = 8
"""Members that are run together, half of them of each scramble; after each batch a cell may be settled."""

MOST_GROUND_VALUES = 20_000_000
"""Samples of rotated motion held at a time (160 MB)."""

MOST_MEMBERS: Final = 1_000_000
"""Cases of members run at a time (300 MB)."""

Runner = Callable[[Any, Progress | None], Any]
"""What runs cases under the motion of the nominal ones."""

Arrays = dict[str, NDArray[Any]]


def cells_to_run(overturned: NDArray[np.int8], everywhere: bool, dimensions: int = 4) -> NDArray[np.bool_]:
    """Which cells the ensemble runs.

    Parameters
    ----------
    overturned : ndarray, shape (a, h, b, …) or (a, h, b, …, elements)
        Nominal flags; a missing one differs from every other. A change of any element counts.
    everywhere : bool
        All cells.
    dimensions : int
        Of the grid.

    Returns
    -------
    ndarray of bool, shape (a, h, b, …)
        Cells within two steps along B/H of a change of flag. With a single B/H there is no such neighbour to tell, and
        all cells are run.
    """
    shape = overturned.shape[:dimensions]
    if everywhere or shape[2] == 1:
        return np.ones(shape, dtype=bool)
    change = overturned[:, :, 1:] != overturned[:, :, :-1]
    change = change.any(axis=dimensions) if change.ndim > dimensions else change
    count = shape[2]
    chosen = np.zeros(shape, dtype=bool)
    for step in range(1 - REACH, REACH + 1):  # a change between i and i + 1 concerns i − 1 to i + 2
        low, high = max(0, -step), min(count - 1, count - step)
        chosen[:, :, low + step : high + step] |= change[:, :, low:high]
    return chosen


def wilson(count: ArrayLike, total: ArrayLike) -> tuple[FloatArray, FloatArray]:
    """95 % interval of a share (Wilson 1927, Journal of the American Statistical Association 22).

    Written out here because scipy's takes one share at a time, and a sweep should not wait for it; a test holds it to
    scipy's.

    Parameters
    ----------
    count, total : array_like
        Cases counted, of so many.

    Returns
    -------
    (low, high) : ndarray, of the shape of both
        0 and 1 without cases.
    """
    n, k = np.asarray(total, np.float64), np.asarray(count, np.float64)
    known = np.maximum(n, 1.0)
    share, square = k / known, Z_95 * Z_95 / known
    middle = (share + 0.5 * square) / (1.0 + square)
    half = Z_95 / (1.0 + square) * np.sqrt(share * (1.0 - share) / known + 0.25 * square / known)
    return np.where(k == 0, 0.0, middle - half), np.where(k == n, 1.0, middle + half)


def settled(flags: NDArray[np.int8], widest: float) -> NDArray[np.bool_]:
    """Which cells need no further members: both probabilities of every element are known to within ±`widest`.

    Parameters
    ----------
    flags : ndarray, shape (cells, members) or (cells, members, elements)
        Outcomes so far; members without an outcome, or not run yet, are missing.
    widest : float
        Largest half width of the 95 % interval (`wilson`).

    Returns
    -------
    ndarray of bool, shape (cells,)
        A function of each cell's own flags.
    """
    known = (flags != INT8_MISSING).sum(axis=1)
    ends = [wilson((flags == side).sum(axis=1), known) for side in (1, -1)]
    narrow = [high - low <= 2.0 * widest for low, high in ends]
    return np.asarray(np.logical_and(*narrow).reshape(len(flags), -1).all(axis=1))


@dataclass(frozen=True)
class CellEnsemble:
    """The ensemble of a study.

    Attributes
    ----------
    model : Model
        What it runs again.
    members : Members
        What each member changes.
    everywhere : bool
        Run all cells, not only those near a change of flag.
    widest : float
        A cell gets no further members once it is `settled` to within this; 0 runs all members of every cell.
    """

    model: Model
    members: Members
    everywhere: bool = True
    widest: float = 0.0

    def run(
        self,
        motion: Motion,
        grid: Grid,
        nominal: Mapping[str, NDArray[Any]],
        run: Runner,
        progress: Progress | None = None,
    ) -> tuple[Arrays, int]:
        """Run the ensemble beside a nominal outcome.

        Parameters
        ----------
        motion : Motion
            The ground's.
        grid : Grid
            The cases.
        nominal : mapping of str to ndarray
            The nominal outcome: `overturned`, shape (a, h, b, …) or (a, h, b, …, elements), and what marks cells for
            which others answer, (a, h, b, …). These are not run: they mirror their member's tilt with everything else.
        run : callable
            Runs the members' cases.
        progress : callable, optional
            Called now and then with the work done and the whole work.

        Returns
        -------
        arrays : dict of ndarray, shape (a, h, b, …)
            The variables, missing floats as NaN; those of single elements with their dimension where `overturned` has
            it.
        block_steps : int
            Work done.
        """
        overturned, marked, members = nominal["overturned"], nominal[self.model.copied], self.members
        chosen = cells_to_run(overturned, self.everywhere, len(grid.shape)) & (marked == 0)
        arrays: Arrays = {
            variable.name: np.zeros(grid.shape, variable.dtype)
            if variable.dtype == "i2"
            else np.full(overturned.shape if variable.per_element else grid.shape, np.nan, variable.dtype)
            for variable in self.model.ensemble_variables
        }
        directions = np.flatnonzero(chosen.any(axis=tuple(range(1, chosen.ndim))))
        together = max(1, min(BATCH, members.size))
        cells_of_each = max(1, int(np.prod(chosen.shape[1:])))
        group = max(
            1, min(MOST_GROUND_VALUES // (together * motion.samples), MOST_MEMBERS // (together * cells_of_each))
        )
        work, done, block_steps = max(1, int(chosen.sum())), 0, 0
        for start in range(0, directions.size, group):
            some = np.zeros_like(chosen)
            some[directions[start : start + group]] = True
            cells = np.argwhere(chosen & some)

            def step(share: float, before: int = done, count: int = len(cells)) -> None:
                if progress:
                    progress(int(1000 * (before + count * share)), 1000 * work)

            flags = np.full((len(cells), members.size, *overturned.shape[len(grid.shape) :]), INT8_MISSING)
            azimuth = np.full((len(cells), members.size), np.nan)
            block_steps += self._run_batches(grid, cells, run, flags, azimuth, step if progress else None)
            found = self.model.tally(flags, azimuth - members.azimuth_deg, members.scramble)
            for name, values in found.items():
                arrays[name][tuple(cells.T)] = values
            done += len(cells)
        self._copy(grid, arrays, marked)
        return arrays, block_steps

    def _run_batches(
        self,
        grid: Grid,
        cells: NDArray[np.int64],
        run: Runner,
        flags: NDArray[np.int8],
        azimuth: FloatArray,
        step: Callable[[float], None] | None,
    ) -> int:
        """Fill in flags and, in space, fall azimuths of some cells, until they are settled; return block steps."""
        batches, block_steps = self.members.batches(BATCH), 0
        unsettled = np.arange(len(cells))
        for index, batch in enumerate(batches):

            def part_of_batch(part: int, whole: int, before: int = index) -> None:
                if step:
                    step((before + part / max(whole, 1)) / len(batches))

            cases = self._cases(grid, cells[unsettled], self.members.some(batch))
            results = run(cases, part_of_batch if step else None)
            block_steps += int(results.block_steps.sum())
            new = results.overturned.reshape(unsettled.size, batch.size, *flags.shape[2:])
            flags[unsettled[:, None], batch] = new
            if (towards := getattr(results, "fall_azimuth", None)) is not None:
                azimuth[unsettled[:, None], batch] = towards.reshape(unsettled.size, batch.size)
            unsettled = unsettled[~settled(flags[unsettled], self.widest)]
            if unsettled.size == 0:
                break
        if step:
            step(1.0)
        return block_steps

    def _cases(self, grid: Grid, cells: NDArray[np.int64], members: Members) -> Cases:
        """Every member of every cell, the members of a cell together."""
        nominal = {name: grid[name][cells[:, at]].astype(np.float64) for at, name in enumerate(grid.names)}
        # In the frame of a sensor that is turned the other way a plane, or a body, faces as much further clockwise.
        direction = (nominal.pop(grid.names[0])[:, None] + members.azimuth_deg).ravel()
        same = np.ones(members.size)
        columns = {name: (at[:, None] * getattr(members, name, same)).ravel() for name, at in nominal.items()}
        alike = {
            "amplitude": members.amplitude,
            "damping_factor": members.damping,
            "initial_tilt": members.initial_tilt,
        }
        return Cases(direction, **columns, **{name: np.tile(one, len(cells)) for name, one in alike.items()})

    def _copy(self, grid: Grid, arrays: Arrays, marked: NDArray[Any]) -> None:
        """Fill the marked cells from those that answer for them."""
        source = self.model.sources(grid).cell
        for column in range(source.shape[1]):
            # In space the period depends on the aspect, the dimension before friction.
            rest = (slice(None), slice(None), column) if source.shape[1] > 1 else ()
            alike = marked[(slice(None), *rest)]
            behind = np.flatnonzero(alike.any(axis=tuple(range(1, alike.ndim))))
            where = (source[behind, column], *rest)
            seen = {item.name: item.mirrored(arrays, where) for item in self.model.ensemble_variables}
            for name, values in seen.items():
                arrays[name][(behind, *rest)] = values
