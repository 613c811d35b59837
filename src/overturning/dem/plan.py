"""What a kernel has to know of each case before it runs, and what its path holds: common to both kernels."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.numerics import Numerics
from overturning.dem.time_step import Scheme
from overturning.errors import ArgumentError
from overturning.model.cases import Cases
from overturning.model.geometry import Placed
from overturning.model.results import Answers, Results
from overturning.model.scene import Scene
from overturning.model.status import Status
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion

DEEPEST: Final = 0.2
"""Penetration, in half the smaller side, beyond which the contact law no longer holds."""

AFTERMATH: Final = 20.0
"""Time after the record, in 1/p, at which a block that may still fall is undecided."""

MOST_PATH: Final = 100_000_000
"""Numbers that a path may hold: 0.8 GB."""


def check_path(numbers: int) -> None:
    """Refuse a path of so many numbers or more, by an `ArgumentError`, where that is above `MOST_PATH`."""
    if numbers > MOST_PATH:
        raise ArgumentError(
            f"trajectory: a path of {8e-9 * numbers:.1f} GB or more, at most {8e-9 * MOST_PATH:.1f} GB; cut the motion to its "
            "strong part, take a larger time_step or, in a scene, fewer elements"
        )


def most_rows(row: np.dtype[np.void]) -> int:
    """Rows of a structured type that a path may have."""
    return MOST_PATH * 8 // row.itemsize


def sinks_too_far(sunk: FloatArray, size: FloatArray | float) -> NDArray[np.bool_]:
    """Whether a weight at rest presses a contact in beyond what its law holds for: such a case has no answer, shaken or not.

    `sunk` is the static penetration, m, `size` the smaller side of what rests, m.
    """
    return ~(sunk <= DEEPEST * 0.5 * np.asarray(size))


@dataclass(frozen=True)
class Path:
    """The way of all elements of a scene in one case."""

    placed: list[Placed]
    critical: FloatArray  # shape (elements,): α of each free element, rad
    time: FloatArray  # shape (rows,), s after the record's start
    ground: FloatArray  # shape (rows,): acceleration of the base towards the azimuth, m/s²
    poses: FloatArray  # shape (rows, elements, 6): x, z, rotation and their rates, in the frame of the base
    force: FloatArray  # shape (rows, contacts, 2): mean from this row to the next, on the first element, N
    place: FloatArray  # shape (rows, contacts, 2): where it acts, m; NaN where nothing touches or nothing is known
    contacts: list[tuple[str, str]]  # names of the two elements


@dataclass(frozen=True, kw_only=True)
class Plan(ABC):
    """How each of n cases is to be computed: functions of the case and its record alone."""

    halved: ClassVar[bool] = False
    """Whether a long queue is divided, so that two threads share its work."""

    scene: Scene
    motion: Motion
    cases: Cases
    numerics: Numerics
    scheme: Scheme
    row: NDArray[np.int64]  # shape (n,): row of `ground`
    ground: FloatArray  # shape (azimuths, samples + 3): acceleration of the base along each azimuth, m/s²
    steps: NDArray[np.int64]  # shape (n,), per sample
    first: NDArray[np.int64]  # shape (n,): sample from which it is computed
    never: NDArray[np.bool_]  # shape (n,): below the thresholds of rocking and sliding for the whole record
    hopeless: NDArray[np.bool_]  # shape (n,): the weight alone `sinks_too_far`; no answer, and not computed

    @property
    def free(self) -> int:
        """Number of free elements."""
        return len(self.scene.free)

    @property
    def group(self) -> NDArray[np.int64]:
        """Cases with the same number share a queue."""
        return self.steps

    def uncomputed(self) -> Results:
        """Results of all cases as long as none is computed: at rest, or without an answer."""
        results = Results.at_rest(self.cases.size, self.free)
        results.status[self.hopeless], results.overturned[self.hopeless] = Status.UNSTABLE, INT8_MISSING
        return results

    @abstractmethod
    def compute(
        self, chosen: NDArray[np.int64], counter: NDArray[np.int64], path: NDArray[Any] | None = None
    ) -> tuple[Answers, NDArray[Any]]:
        """Answers to chosen cases of one group from the kernel, and the rows of the first case's path.

        `counter`, shape (1,), grows by the steps done, for progress. `path` has room for the rows, where there may be more than
        the plan can tell for the first ones; none is kept where it is not given.
        """

    @abstractmethod
    def trace(self) -> tuple[Answers | None, Path]:
        """Answers, none where it is at rest throughout, and path of a plan's only case."""


def shaking(motion: Motion, cases: Cases) -> tuple[NDArray[np.int64], FloatArray]:
    """Row of each case, and rows of the base's acceleration along the azimuths, m/s², three zeros after the record."""
    azimuths, row = np.unique(np.asarray(cases.azimuth_deg), return_inverse=True)
    ground = np.zeros((azimuths.size, motion.samples + 3))
    for index, azimuth in enumerate(azimuths):
        ground[index, : motion.samples] = motion.along(float(azimuth))
    return row, ground


def rounded(function: np.ufunc, values: FloatArray) -> FloatArray:
    """A function of an angle, rounded: libm and SIMD versions differ in the last digit between processors."""
    distinct, where = np.unique(values, return_inverse=True)
    return np.asarray(np.round(function(distinct), 12)[where])
