"""From a survey back to the motion: which record or pulse, how strong, from which side, made stones fall as they did."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.stats import qmc

from overturning.arrays import FloatArray
from overturning.dem.cases import Cases
from overturning.dem.run import run_cases
from overturning.errors import ArgumentError
from overturning.motion.motion import Motion
from overturning.statistics.circular import sector
from overturning.study.population import Population
from overturning.surveys.prediction import BACKGROUND
from overturning.surveys.stones import Stone

STEP_DEG: Final = 10
"""Distance of the planes, of the motion's azimuths and of the directions of falls, degrees."""

PLANES: Final = 180 // STEP_DEG
WAYS: Final = 2 * PLANES
STOOD: Final = WAYS
"""Place of standing after the ways in which a stone can fall."""

DIRECTION_ERROR_DEG: Final = 10.0
"""Standard deviation of a measured direction, degrees."""

AMPLITUDES: Final = np.geomspace(0.1, 5.0, 18)
"""Factors on a motion that are tried."""

DRAWS: Final = 16
"""Draws of what is not known of a stone."""


@dataclass(frozen=True)
class Posterior:
    """What a survey says of the motion.

    Attributes
    ----------
    sources : tuple of str
        Names of the motions.
    amplitude : ndarray, shape (a,)
        Factors on them.
    azimuth : ndarray, shape (r,)
        Angles by which each motion is turned clockwise, degrees; of a pulse along north its azimuth.
    probability : ndarray, shape (s, a, r)
        Posterior probability; sums to 1.
    prior : ndarray, shape (s, a, r)
        Prior probability.
    """

    sources: tuple[str, ...]
    amplitude: FloatArray
    azimuth: FloatArray
    probability: FloatArray
    prior: FloatArray

    def interval(self, values: ArrayLike, level: float = 0.9, *, prior: bool = False) -> tuple[float, float]:
        """Equal-tailed credible interval of a positive quantity.

        Parameters
        ----------
        values : array_like, shape (s, a)
            The quantity for each motion and factor, for instance its PGA.
        level : float
            Probability inside.
        prior : bool
            Of the prior instead.

        Returns
        -------
        (float, float)
            Between neighbouring values the distribution is interpolated over the logarithm.
        """
        weight = (self.prior if prior else self.probability).sum(axis=2).ravel()
        logs = np.log(np.broadcast_to(np.asarray(values, dtype=np.float64), self.probability.shape[:2])).ravel()
        distinct, place = np.unique(logs.round(12), return_inverse=True)
        mass = np.bincount(place.ravel(), weight)
        if distinct.size == 1:
            return float(np.exp(distinct[0])), float(np.exp(distinct[0]))
        # Each value stands for the cell half way to its neighbours.
        middle = (distinct[1:] + distinct[:-1]) / 2
        edges = np.concatenate([[2 * distinct[0] - middle[0]], middle, [2 * distinct[-1] - middle[-1]]])
        below = np.concatenate([[0.0], np.cumsum(mass)])
        tail = (1 - level) / 2
        low, high = np.interp([tail, 1 - tail], below / below[-1], edges)
        return float(np.exp(low)), float(np.exp(high))

    def of_sources(self) -> FloatArray:
        """Probability of each motion, shape (s,)."""
        return np.asarray(self.probability.sum(axis=(1, 2)))

    def of_azimuths(self) -> FloatArray:
        """Probability of each azimuth, shape (r,)."""
        return np.asarray(self.probability.sum(axis=(0, 1)))


@dataclass(frozen=True)
class Kind:
    """What is known of a stone beforehand.

    Attributes
    ----------
    height, b_over_h : float or None
        m, and B/H of both its planes; None where it is not known.
    round : bool
        A column, which can fall in any plane.
    """

    height: float | None = None
    b_over_h: float | None = None
    round: bool = False

    @classmethod
    def of(cls, stone: Stone) -> "Kind":
        """That of a stone."""
        height, shape = (None if math.isnan(value) else value for value in (stone.height, stone.b_over_h))
        return cls(height, shape, stone.round)


class Responses:
    """What stones of some kinds do under some motions, for every amplitude; computed once, used for many surveys.

    Parameters
    ----------
    motions : mapping of str to Motion
        By name.
    kinds : sequence of Kind
        The stones' kinds.
    population : Population, optional
        From which height, B/H and friction are drawn where they are not known.
    amplitude : array_like, shape (a,)
        Factors on the motions.
    threads : int
        Threads.

    Raises
    ------
    ArgumentError
        If there is no motion or no kind.
    """

    def __init__(
        self,
        motions: Mapping[str, Motion],
        kinds: Sequence[Kind],
        population: Population | None = None,
        *,
        amplitude: ArrayLike = AMPLITUDES,
        threads: int = 1,
    ) -> None:
        if not motions or not kinds:
            raise ArgumentError(f"{len(motions)} motions, {len(kinds)} kinds of stones; at least one of each is needed")
        self.sources = tuple(motions)
        self.amplitude: FloatArray = np.asarray(amplitude, dtype=np.float64)
        self._population = population or Population()
        self._tables = {
            kind: np.stack([self._table(motion, kind, threads) for motion in motions.values()])
            for kind in dict.fromkeys(kinds)
        }

    def _table(self, motion: Motion, kind: Kind, threads: int) -> FloatArray:
        """Probability of each way and of standing, shape (a, faces, ways + 1), faces and ways counted from the motion's north."""
        plane, (height, shape, friction) = STEP_DEG * np.arange(PLANES), drawn(kind, self._population)
        cells = (self.amplitude.size, DRAWS, PLANES)
        columns = (plane, height[:, None], shape[:, None], friction[:, None], self.amplitude[:, None, None])
        found = run_cases(motion, Cases(*(np.broadcast_to(one, cells).ravel() for one in columns)), threads=threads)
        flag, time = found.overturned.reshape(cells), found.overturning_time.reshape(cells)
        if kind.round:
            ways = first_way(flag, time, np.arange(PLANES))
            return np.repeat(_shares(ways)[:, None], PLANES, axis=1)
        pairs = [np.array([face, (face + PLANES // 2) % PLANES]) for face in range(PLANES)]
        return np.stack([_shares(first_way(flag[..., pair], time[..., pair], pair)) for pair in pairs], axis=1)

    def likelihood(
        self,
        stone: Stone,
        *,
        background: float = BACKGROUND,
        fixed: float = 0.0,
        error_deg: float = DIRECTION_ERROR_DEG,
    ) -> FloatArray:
        """Likelihood of what one stone did, shape (s, a, r), by motion, amplitude and azimuth of the motion."""
        table = self._tables[Kind.of(stone)]
        turns = np.arange(WAYS)
        if math.isnan(stone.face_azimuth_deg):
            seen = np.repeat(table.mean(axis=2)[:, :, None], WAYS, axis=2)
        else:
            # The face as the motion sees it that is turned by each angle.
            face = np.round(stone.face_azimuth_deg / STEP_DEG).astype(int) - turns
            seen = table[:, :, face % PLANES]
        if not stone.fell:
            stands = (1 - background) * seen[..., STOOD] + background / 2
            return np.asarray(fixed + (1 - fixed) * stands)
        chance = np.zeros(seen.shape[:3])
        for turn in turns:
            chance[:, :, turn] = seen[:, :, turn, :WAYS] @ directions(stone, float(STEP_DEG * turn), error_deg)
        width = 45.0 if stone.octant else float(STEP_DEG)
        return np.asarray((1 - fixed) * ((1 - background) * chance + background / 2 * width / 360))

    def posterior(
        self,
        stones: Sequence[Stone],
        *,
        prior: ArrayLike | None = None,
        background: float = BACKGROUND,
        fixed: float = 0.0,
        error_deg: float = DIRECTION_ERROR_DEG,
    ) -> Posterior:
        """What a survey says of the motion.

        Parameters
        ----------
        stones : sequence of Stone
            The survey; stones are independent, given the motion. Without stones the posterior is the prior.
        prior : array_like, shape (s, a, r), optional
            Prior weights; the same for each motion, each factor of `amplitude` and each azimuth where not given.
        background : float
            Share of stones that do anything (pushed, badly founded).
        fixed : float
            Share of stones fixed to their base.
        error_deg : float
            Standard deviation of a measured direction, degrees.
        """
        shape = (len(self.sources), self.amplitude.size, WAYS)
        weight = np.ones(shape) if prior is None else np.broadcast_to(np.asarray(prior, dtype=np.float64), shape)
        weight = weight / weight.sum()
        with np.errstate(divide="ignore"):
            logs = np.log(weight)
        for stone in stones:
            found = self.likelihood(stone, background=background, fixed=fixed, error_deg=error_deg)
            logs = logs + stone.count * np.log(found)
        probability = np.exp(logs - logs.max())
        azimuth = STEP_DEG * np.arange(WAYS, dtype=np.float64)
        return Posterior(self.sources, self.amplitude, azimuth, probability / probability.sum(), weight)


def drawn(kind: Kind, population: Population, draws: int = DRAWS) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Heights, B/H and frictions of stones of a kind, each shape (draws,): what is not known from the population."""
    unit = qmc.Sobol(3, scramble=True, rng=np.random.Generator(np.random.PCG64(population.seed))).random(draws).T
    spreads = (population.height, population.width, population.friction)
    height, width, friction = (one.low + (one.high - one.low) * u for one, u in zip(spreads, unit, strict=True))
    if kind.height is not None:
        height = np.full(draws, kind.height)
    # A measured slenderness is known to some 3 %: edges are worn, and the stone rests on what touches.
    shape = width / height if kind.b_over_h is None else kind.b_over_h * (1 + 0.06 * (unit[1] - 0.5))
    return height, shape, friction


def first_way(flag: NDArray[np.int8], time: NDArray[np.float32], planes: NDArray[np.intp]) -> NDArray[np.intp]:
    """Way in which a stone falls that could fall in some planes (the last dimension): over the edge it is first past.

    Ways count the azimuths by `STEP_DEG` from the motion's north; `STOOD` where it falls in none, −1 where it is not known.
    """
    falls = np.abs(flag) == 1
    first = np.argmin(np.where(falls, time, np.inf), axis=-1)
    side = np.take_along_axis(flag, first[..., None], axis=-1)[..., 0]
    way = (planes[first] + np.where(side > 0, 0, PLANES)) % WAYS
    known = (np.abs(flag) <= 1).all(axis=-1)
    return np.where(falls.any(axis=-1), way, np.where(known, STOOD, -1))


def _shares(ways: NDArray[np.intp]) -> FloatArray:
    """Shares of the draws (the last dimension) that end each way, half a draw spread over all ends."""
    counts = np.stack([(ways == way).sum(axis=-1) for way in range(WAYS + 1)], axis=-1).astype(np.float64)
    blind = np.append(np.full(WAYS, 0.25 / WAYS), 0.25)
    return np.asarray((counts + blind) / (counts.sum(axis=-1, keepdims=True) + 0.5))


def directions(stone: Stone, turn_deg: float, error_deg: float) -> FloatArray:
    """Probability that a fall each way, turned by an angle, is measured as the stone's direction, shape (ways,)."""
    way = STEP_DEG * np.arange(WAYS) + turn_deg
    seen = STEP_DEG * np.arange(WAYS)
    apart = (way[:, None] - seen[None, :] + 180.0) % 360 - 180
    kernel = np.exp(-0.5 * (apart / max(error_deg, STEP_DEG / 4)) ** 2)
    kernel /= kernel.sum(axis=1, keepdims=True)
    if stone.octant:
        return np.asarray(kernel[:, sector(seen, 8) == sector(stone.azimuth_deg, 8)].sum(axis=1))
    return np.asarray(kernel[:, round(stone.azimuth_deg / STEP_DEG) % WAYS])
