"""Fall rates of a cemetery: stones drawn from a population, run under a record at several amplitudes."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

from overturning.arrays import FloatArray
from overturning.dem.cases import Cases
from overturning.dem.numerics import Numerics
from overturning.dem.results import Results
from overturning.dem.run import run
from overturning.dem.scene import Scene, gravestone
from overturning.motion.motion import Motion
from overturning.study.population import Population, Spread
from overturning.surveys.prediction import sector

OUTCOMES: Final = ("stands", "shifted", "fell")
"""What a stone does, by its code."""

UNKNOWN: Final = -1


@dataclass(frozen=True)
class Stones:
    """Stones of a population, each attribute an ndarray of shape (n,).

    Attributes
    ----------
    height, b_over_h, friction : ndarray
        m, B/H, µ.
    face : ndarray
        Azimuth that the front looks to, degrees.
    """

    height: FloatArray
    b_over_h: FloatArray
    friction: FloatArray
    face: FloatArray


def draw_stones(population: Population) -> Stones:
    """Draw the stones of a population that are not fixed, as scrambled Sobol points (Owen 1998, ACM TOMACS 8)."""
    generator = np.random.Generator(np.random.PCG64(population.seed))
    unit = qmc.Sobol(4, scramble=True, rng=generator).random(population.stones).T

    def between(spread: Spread, u: FloatArray) -> FloatArray:
        return spread.low + (spread.high - spread.low) * u

    width, height = between(population.width, unit[0]), between(population.height, unit[1])
    about = population.face_spread * (2 * unit[3] - 1)
    face = 360 * unit[3] if population.face is None else population.face + about
    return Stones(height, width / height, between(population.friction, unit[2]), face % 360)


def stone_outcomes(
    motion: Motion,
    stones: Stones,
    amplitude: FloatArray,
    *,
    shifted: float = 0.01,
    scene: Scene | None = None,
    numerics: Numerics | None = None,
) -> tuple[NDArray[np.int8], FloatArray]:
    """What each stone does under a record.

    A stone of square plan can fall in the planes of both its pairs of faces, and both are run. It falls where it falls in
    one of them; where in both, over the edge it is first past (the smaller ``overturning_time``). That a stone turns
    about its vertical axis no plane can show.

    Parameters
    ----------
    motion : Motion
        The ground's.
    stones : Stones
        n stones.
    amplitude : ndarray, shape (a,)
        Factors on the motion.
    shifted : float
        Residual slip, m, both planes together, from which a standing stone counts as shifted.
    scene : Scene, optional
        A single block, for its contact; the gravestone where not given.
    numerics : Numerics, optional
        As of `run`.

    Returns
    -------
    outcome : ndarray of int8, shape (a, n)
        Place in `OUTCOMES`; `UNKNOWN` where a plane has no answer and the other does not fall.
    azimuth : ndarray, shape (a, n)
        Azimuth towards which it fell, degrees; NaN where it did not.
    """
    shape = (amplitude.size, 2, stones.height.size)
    planes = np.stack([stones.face, stones.face + 90])

    def spread(values: FloatArray) -> FloatArray:
        return np.broadcast_to(values, shape).ravel()

    cases = Cases(
        spread(planes),
        spread(stones.height),
        spread(stones.b_over_h),
        spread(stones.friction),
        amplitude=spread(amplitude[:, None, None]),
    )
    found = run(scene or gravestone(), motion, cases, numerics)
    return _of_both_planes(found.element(0), planes, shape, shifted)


def _of_both_planes(
    found: Results, planes: FloatArray, shape: tuple[int, ...], shifted: float
) -> tuple[NDArray[np.int8], FloatArray]:
    flag, slip = (values.reshape(shape) for values in (found.overturned, found.residual_slip))
    known, falls = np.abs(flag) <= 1, np.abs(flag) == 1
    time = np.where(falls, found.overturning_time.reshape(shape), np.inf)
    first = np.argmin(time, axis=1)[:, None]
    fell = falls.any(axis=1)
    towards = np.where(flag > 0, planes, planes + 180) % 360
    azimuth = np.where(fell, np.take_along_axis(towards, first, axis=1)[:, 0], np.nan)
    moved = np.hypot(slip[:, 0], slip[:, 1]) >= shifted
    outcome = np.where(fell, OUTCOMES.index("fell"), moved).astype(np.int8)
    return np.where(fell | known.all(axis=1), outcome, UNKNOWN).astype(np.int8), azimuth


def rates(outcome: NDArray[np.int8], azimuth: FloatArray) -> dict[str, FloatArray]:
    """Rates of what `stone_outcomes` found.

    Returns
    -------
    dict of ndarray
        ``fall_rate`` and ``shift_rate`` of the stones that have an answer, shape (a,); ``unknown``, the share without
        one; ``fall_octant``, shape (a, 8), the share that fell towards each compass octant.
    """
    known = np.maximum((outcome != UNKNOWN).sum(axis=1), 1)
    fell = outcome == OUTCOMES.index("fell")
    octant = sector(np.nan_to_num(azimuth), 8)
    towards = np.stack([(fell & (octant == i)).sum(axis=1) for i in range(8)], axis=1)
    return {
        "fall_rate": fell.sum(axis=1) / known,
        "shift_rate": (outcome == OUTCOMES.index("shifted")).sum(axis=1) / known,
        "unknown": (outcome == UNKNOWN).mean(axis=1),
        "fall_octant": towards / known[:, None],
    }
