"""How the cases of a model are computed, from what its kernel has to know to their answers and the path of one."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.kernel.balance import rerun_until_balanced
from overturning.dem.kernel.ground import Ground, loudest_ahead
from overturning.dem.kernel.queue import Job, run_queue
from overturning.dem.numerics import Numerics
from overturning.errors import ArgumentError
from overturning.model.cases import Cases
from overturning.model.model import Model
from overturning.model.results import Results
from overturning.model.status import Status
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion

MAX_PATH_NUMBERS: Final = 100_000_000
"""Numbers that the dataset of a path may hold: 0.8 GB."""


def check_path(numbers: int) -> None:
    """Refuse a path of so many numbers or more, by an `ArgumentError`, where that is above `MAX_PATH_NUMBERS`."""
    if numbers > MAX_PATH_NUMBERS:
        raise ArgumentError(
            f"trajectory: a path of {8e-9 * numbers:.1f} GB or more, at most {8e-9 * MAX_PATH_NUMBERS:.1f} GB; cut "
            "the motion to its strong part, take a larger time_step or, in a scene, fewer elements"
        )


class Path(Protocol):
    """The way of a model in one case."""

    def dataset_parts(self, results: Results) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
        """Variables, coordinates and attributes of a dataset, with the results of the case."""


ANSWERS: Final = {
    "status": "status", "peak_penetration": "depth", "energy_error": "energy", "block_steps": "steps",
    "overturned": "side", "overturning_time": "time", "peak_rotation": "angle", "peak_slip": "slip",
    "residual_slip": "residual", "samples_left_out": "left_out",
}  # fmt: skip
"""Columns of the kernels' results in planes, by the variables that they are."""


def group_equal_cases(*columns: NDArray[Any]) -> NDArray[np.int64]:
    """Numbers of cases, shape (n,): the same where all columns, each of shape (n,), are."""
    return np.asarray(np.unique(np.stack(columns), axis=1, return_inverse=True)[1]).ravel()


@dataclass(frozen=True, kw_only=True)
class Plan(ABC):
    """How each of n cases is to be computed: functions of the case and its motion alone."""

    halved: ClassVar[bool] = False
    """Whether a long queue is divided, so that two threads share its work."""
    queue: ClassVar[Any] = staticmethod(run_queue)
    """What runs a queue of cases."""
    result: ClassVar[Any]
    """Columns of the kernel's results, with `status`, `energy` and `steps`."""
    path_row: ClassVar[Any]
    """Columns of a path's rows, with `time`, where they are structured."""
    time_column: ClassVar[Any] = "time"
    """Index of the time in a row of a path."""
    ground_columns: ClassVar[Any] = ("ground",)
    """Indices of the motion of the base in a row of a path."""
    path_numbers: ClassVar[int] = 1
    """Numbers of a path's dataset at each time, where the kernel bounds the rows."""
    step_cost: ClassVar[int] = 1
    """Block steps that a step counts as in the budget."""

    model: Model
    motion: Motion
    cases: Cases
    numerics: Numerics
    row: NDArray[np.int64]  # shape (n,): row of `ground`
    ground: FloatArray  # shape (directions, …, samples + 3): acceleration of the base in each direction, m/s²
    steps: NDArray[np.int64]  # shape (n,), per sample
    first: NDArray[np.int64]  # shape (n,): sample from which it is computed
    stays_at_rest: NDArray[np.bool_]  # shape (n,): below the thresholds of rocking and sliding for the whole record
    too_soft: NDArray[np.bool_]  # shape (n,): the weight alone `exceeds_penetration_limit`; no answer, and not computed
    table: NDArray[np.void]  # shape (n,): the kernel's cases

    @property
    def group(self) -> NDArray[np.int64]:
        """Cases with the same number share a queue."""
        return self.steps

    @property
    def upward(self) -> FloatArray | None:
        """Vertical acceleration of the base, m/s², with three zeros after the record; None where it moves level."""
        return None if self.motion.up is None else np.concatenate([self.motion.up, np.zeros(3)])

    @cached_property
    def loudest(self) -> tuple[FloatArray, FloatArray]:
        """Largest horizontal and vertical accelerations ahead, as of `Ground`."""
        across = np.abs(self.ground) if self.ground.ndim == 2 else np.sqrt((self.ground**2).sum(axis=1))
        up = np.zeros(self.ground.shape[-1]) if self.upward is None else np.abs(self.upward)
        interval = self.motion.sampling_interval
        return loudest_ahead(across, interval), loudest_ahead(up, interval)

    def initial_results(self) -> Results:
        """Results of all cases as long as none is computed: at rest, or without an answer."""
        results = Results.at_rest(self.model.variables, self.cases.size, len(self.model.elements))
        results.status[self.too_soft], results.overturned[self.too_soft] = Status.UNSTABLE, INT8_MISSING
        return results

    def compute(
        self, chosen: NDArray[np.int64], counter: NDArray[np.int64], path: NDArray[Any] | None = None
    ) -> tuple[dict[str, Any], NDArray[Any]]:
        """Answers to chosen cases of one group, finer of those whose energy does not balance, and the first one's path.

        `counter`, shape (1,), grows by the steps done, for progress. `path` has room for the rows, where there may be
        more than the plan can tell for the first ones; none is kept where it is not given.
        """
        tables = self.tables(chosen.size)
        found, room = tables["results"], self.room(False) if path is None else path
        kept = room

        def run(rows: NDArray[np.int64], finer: int) -> None:
            nonlocal kept
            room[:] = 0.0
            kept, noted = self.queue(self.rules(chosen, tables, finer), rows, counter, room)
            if noted < 0:  # there was no room
                check_path(2 * len(kept) * self.path_numbers)
            kept = kept[:noted]

        rerun_until_balanced(run, found["status"], found["energy"])
        return self.answers(chosen, tables), kept

    def trace(self) -> tuple[Results, Path]:
        """Result and path of a plan's only case."""
        results, path, only = self.initial_results(), self.room(True), np.zeros(1, np.int64)
        before = self.motion.samples
        if self.stays_at_rest[0] or self.too_soft[0]:
            path = path[:0]
        else:
            before = int(self.first[0])
            answers, path = self.compute(only, np.zeros(1, np.int64), path)
            results.store(only, answers)
        rest = self.rest_rows(self.motion.samples)
        return results, self.path(self.fill_skipped_samples(np.concatenate([rest[:before], path]), rest))

    def fill_skipped_samples(self, rows: NDArray[Any], rest: NDArray[Any]) -> NDArray[Any]:
        """Rows of a path with those of the samples that were left out: the body stays, and the ground goes on.

        `rest` has a row for each sample of the record, with the ground's motion.
        """
        interval, time = self.motion.sampling_interval, rows[self.time_column]
        missing = np.maximum(np.rint(np.diff(time, prepend=time[:1]) / interval).astype(np.int64) - 1, 0)
        after = np.repeat(np.arange(len(rows)), missing + 1)
        # How many samples before the row that follows it each new one is.
        ahead = np.repeat(np.cumsum(missing + 1), missing + 1) - 1 - np.arange(after.size)
        filled, new = rows[after], ahead > 0
        filled[self.time_column] = time[after] - ahead * interval
        for column in self.ground_columns:
            ground = np.interp(filled[self.time_column], rest[self.time_column], rest[column])
            filled[column] = np.where(new, ground, filled[column])
        return filled

    def common_rules(
        self, chosen: NDArray[np.int64], tables: dict[str, NDArray[np.void]], finer: int, ticks: float, lanes: int
    ) -> dict[str, Any]:
        """What the rules of all models hold, of `Rules`, for `Plan.rules`; `ticks` are those of a whole step."""
        cases, steps = self.table[chosen], int(self.steps[chosen[0]]) * finer
        # The shortest step is in ticks, which shrink with the whole one.
        cases["dwell"] *= finer
        job = Job(
            samples=self.motion.samples,
            interval=self.motion.sampling_interval,
            ticks=ticks * steps,
            at_once=steps,
            weight=len(self.model.elements),
            budget=self.numerics.budget // self.step_cost,
            most_rows=MAX_PATH_NUMBERS // self.path_numbers,
            lanes=lanes,
        )
        ground, row = Ground(self.ground, self.upward, *self.loudest), self.row[chosen]
        return {"job": job, "cases": cases, "row": row, "results": tables["results"], "ground": ground}

    def tables(self, count: int) -> dict[str, NDArray[np.void]]:
        """Tables that the kernel fills for so many cases: ``results`` and further ones."""
        return {"results": np.zeros(count, self.result)}

    @abstractmethod
    def rules(self, chosen: NDArray[np.int64], tables: dict[str, NDArray[np.void]], finer: int) -> Any:
        """What the queue has to know of chosen cases, to run them in steps so many times finer."""

    @abstractmethod
    def answers(self, chosen: NDArray[np.int64], tables: dict[str, NDArray[np.void]]) -> dict[str, Any]:
        """What was found of chosen cases, by the names of the variables and ``block_steps``."""

    def room(self, kept: bool) -> NDArray[Any]:
        """Rows of a path to fill, none where it is not kept."""
        rows = self.motion.samples if kept else 0
        check_path(rows * self.path_numbers)
        return np.zeros(rows, self.path_row)

    def rest_rows(self, count: int) -> NDArray[Any]:
        """Rows of as many samples at the begin of the record, in which the only case rests."""
        rows = np.zeros(count, self.path_row)
        rows["time"] = np.arange(count) * self.motion.sampling_interval
        return rows

    @abstractmethod
    def path(self, rows: NDArray[Any]) -> Path:
        """The path of the only case, by its rows."""


def ground_motions(motion: Motion, cases: Cases) -> tuple[NDArray[np.int64], FloatArray]:
    """Row of each case, and rows of the base's acceleration along the azimuths, m/s², three zeros after the record."""
    if (np.asarray(cases.aspect) != 1.0).any():
        raise ArgumentError(f"aspect: {np.unique(cases.aspect).tolist()}; only a rectangle in space has one")
    azimuths, row = np.unique(np.asarray(cases.azimuth_deg), return_inverse=True)
    ground = np.zeros((azimuths.size, motion.samples + 3))
    for index, azimuth in enumerate(azimuths):
        ground[index, : motion.samples] = motion.along(float(azimuth))
    return row, ground


def rounded(function: np.ufunc, values: FloatArray) -> FloatArray:
    """A function of an angle, rounded: libm and SIMD versions differ in the last digit between processors."""
    distinct, where = np.unique(values, return_inverse=True)
    return np.asarray(np.round(function(distinct), 12)[where])
