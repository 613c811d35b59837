"""What a kernel has to know of each case before it runs, and what its path holds: common to both kernels."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.cases import Cases
from overturning.dem.numerics import Numerics
from overturning.dem.polygon.geometry import Placed
from overturning.dem.results import Answers, Results
from overturning.dem.scene import Scene
from overturning.dem.status import Status
from overturning.dem.time_step import Scheme
from overturning.dem.variables import INT8_MISSING
from overturning.motion.motion import Motion

DEEPEST: Final = 0.2
"""Penetration, in half the smaller side, beyond which the contact law no longer holds."""

AFTERMATH: Final = 20.0
"""Time after the record, in 1/p, at which a block that may still fall is undecided."""


@dataclass(frozen=True)
class Path:
    """The way of all elements of a scene in one case.

    Attributes
    ----------
    placed : list of Placed
        The elements in their places.
    critical : ndarray, shape (elements,)
        α of each free element, rad.
    time, ground : ndarray, shape (rows,)
        s after the record's start; acceleration of the base towards the azimuth, m/s².
    poses : ndarray, shape (rows, elements, 6)
        x, z, rotation and their rates, in the frame of the base.
    force, place : ndarray, shape (rows, contacts, 2)
        Mean force from this row to the next on the first of the two elements of each contact, N, and where it acts, m;
        NaN where it is not known, of the place where nothing touches.
    contacts : list of (str, str)
        Names of the two elements.
    """

    placed: list[Placed]
    critical: FloatArray
    time: FloatArray
    ground: FloatArray
    poses: FloatArray
    force: FloatArray
    place: FloatArray
    contacts: list[tuple[str, str]]


@dataclass(frozen=True, kw_only=True)
class Plan(ABC):
    """How each case is to be computed: functions of the case and its record alone.

    Attributes
    ----------
    scene, motion, cases, numerics
        What it is the plan of.
    scheme : Scheme
        The integration scheme.
    row : ndarray of int64, shape (n,)
        Row of `ground` of each case.
    ground : ndarray, shape (azimuths, samples + 3)
        Acceleration of the base along each azimuth, m/s².
    steps : ndarray of int64, shape (n,)
        Steps per sample.
    first : ndarray of int64, shape (n,)
        First sample to compute.
    never : ndarray of bool, shape (n,)
        Below the thresholds of rocking and sliding for the whole record.
    """

    halved: ClassVar[bool] = False
    """Whether a long queue is divided, so that two threads share its work."""

    scene: Scene
    motion: Motion
    cases: Cases
    numerics: Numerics
    scheme: Scheme
    row: NDArray[np.int64]
    ground: FloatArray
    steps: NDArray[np.int64]
    first: NDArray[np.int64]
    never: NDArray[np.bool_]

    @property
    def free(self) -> int:
        """Number of free elements."""
        return len(self.scene.free)

    @property
    def group(self) -> NDArray[np.int64]:
        """Cases with the same number share a queue."""
        return self.steps

    @property
    def hopeless(self) -> NDArray[np.bool_]:
        """Cases that have no answer and are not computed."""
        return np.zeros(self.cases.size, np.bool_)

    def uncomputed(self) -> Results:
        """Results of all cases as long as none is computed: at rest, or without an answer."""
        results = Results.at_rest(self.cases.size, self.free)
        results.status[self.hopeless], results.overturned[self.hopeless] = Status.UNSTABLE, INT8_MISSING
        return results

    @abstractmethod
    def compute(self, chosen: NDArray[np.int64], counter: NDArray[np.int64], path: FloatArray) -> tuple[Answers, int]:
        """Run cases of one group with the kernel.

        Parameters
        ----------
        chosen : ndarray of int64
            The cases.
        counter : ndarray of int64, shape (1,)
            Grows by the block steps done; for progress.
        path : ndarray
            Filled with the rows of the first case; no rows to leave it out.

        Returns
        -------
        answers : Answers
            Of the chosen cases.
        noted : int
            Rows of the path that were filled.
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
