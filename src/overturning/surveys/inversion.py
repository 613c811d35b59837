"""From a survey back to the motion: how strong it was, along which axis, and which motions could have been it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.errors import ResultError
from overturning.files import atomic_write
from overturning.statistics.circular import sector
from overturning.surveys.prediction import BACKGROUND
from overturning.surveys.responses import (
    LEVELS,
    ORIENTATION_STEP_DEG,
    STOOD,
    WAY_DEG,
    WAYS,
    Responses,
    StoneKind,
    blind,
)
from overturning.surveys.stones import Stone
from overturning.units import CM, STANDARD_GRAVITY

TURN_DEG: Final = 10
"""Step by which each motion is turned, degrees."""

TURNS: Final = 360 // TURN_DEG

POWER: Final = 0.3
"""Power of the likelihood of the directions.

Those of one survey share what is wrong with a motion that is not the true one, so they count less than as many
independent ones; how much less `verification/backwards_coverage.py` finds.
"""

EVERY: Final = np.arange(WAYS + 1)
"""All ways, and standing."""

_OCTANT: Final = np.append(sector(WAY_DEG * np.arange(WAYS), 8), 8)
"""Compass octant of each way; standing comes after them."""

LEVEL: Final = 0.9
"""Probability inside a stated interval."""

REPLICATES: Final = 200
"""Surveys that are drawn to see whether the library fits."""

NO_FIT: Final = 0.01
"""p of that check below which a survey is said not to fit."""

_STORED: Final = {
    "level": "level", "turn": "turn", "probability": ("source", "level", "turn"), "prior": ("source", "level", "turn"),
    "pga": "source", "axis": "source",
}  # fmt: skip
"""Attributes of a `Posterior` in its file, with their dimensions."""


@dataclass(frozen=True)
class Posterior:
    """Probability of motion, level and turn, after a survey and before it.

    Attributes
    ----------
    sources : tuple of str
        Names of the motions.
    level : ndarray, shape (l,)
        Peak velocities to which each is scaled, m/s; peaks are the largest over all azimuths.
    turn : ndarray, shape (r,)
        Angles by which each motion is turned clockwise, degrees.
    probability, prior : ndarray, shape (s, l, r)
        After and before the survey; each sums to 1.
    pga : ndarray, shape (s,)
        PGA of each motion where its peak velocity is 1 m/s, m/s².
    axis : ndarray, shape (s,)
        Azimuth of each motion's largest velocity where it is not turned, degrees.
    """

    sources: tuple[str, ...]
    level: FloatArray
    turn: FloatArray
    probability: FloatArray
    prior: FloatArray
    pga: FloatArray
    axis: FloatArray

    @property
    def pgv(self) -> FloatArray:
        """PGV, m/s, shape (s, l)."""
        return np.broadcast_to(self.level, self.probability.shape[:2])

    def edges(self) -> tuple[float, float]:
        """Probability of the weakest and of the strongest level."""
        weight = self.probability.sum(axis=(0, 2))
        return float(weight[0]), float(weight[-1])

    def interval(self, values: ArrayLike, *, prior: bool = False) -> tuple[float, float]:
        """Equal-tailed credible interval of a quantity that grows with the level, of probability `LEVEL`.

        Parameters
        ----------
        values : array_like, shape (s, l)
            The quantity for each motion and level, positive.
        prior : bool
            Before the survey instead.

        Returns
        -------
        (float, float)
            Between neighbouring values the distribution is interpolated over the logarithm. Where more than a tail lies
            on the weakest or strongest level, the library ends before the answer does: that end is 0 or infinite.
        """
        weight = (self.prior if prior else self.probability).sum(axis=2).ravel()
        logs = np.log(np.asarray(values, dtype=np.float64)).ravel()
        distinct, place = np.unique(logs.round(12), return_inverse=True)
        mass = np.bincount(place.ravel(), weight)
        # Each value stands for the cell half way to its neighbours.
        middle = (distinct[1:] + distinct[:-1]) / 2
        edges = np.concatenate([[2 * distinct[0] - middle[0]], middle, [2 * distinct[-1] - middle[-1]]])
        below, tail = np.concatenate([[0.0], np.cumsum(mass)]), (1 - LEVEL) / 2
        low, high = np.exp(np.interp([tail, 1 - tail], below / below[-1], edges))
        weakest, strongest = (0.0, 0.0) if prior else self.edges()
        return 0.0 if weakest > tail else float(low), math.inf if strongest > tail else float(high)

    def of_sources(self) -> FloatArray:
        """Probability of each motion, shape (s,)."""
        return np.asarray(self.probability.sum(axis=(1, 2)))

    def of_axes(self) -> FloatArray:
        """Probability of each azimuth of the largest velocity, in steps of `TURN_DEG`; shape (180 / step,)."""
        place, weight = (self.axis[:, None] + self.turn) / TURN_DEG, self.probability.sum(axis=1)
        below, count = np.floor(place).astype(np.intp), 180 // TURN_DEG
        # An axis between two steps is shared out to both.
        parts = ((below, 1 - (place - below)), (below + 1, place - below))
        shares = [np.bincount((at % count).ravel(), (part * weight).ravel(), count) for at, part in parts]
        return np.asarray(shares[0] + shares[1])

    def axis_arc(self) -> tuple[float, float]:
        """Middle (0 to 180) and width of the shortest arc that holds `LEVEL` of the axis's probability, degrees."""
        share = self.of_axes()
        total = np.concatenate([[0.0], np.cumsum(np.tile(share, 2))])
        for bins in range(1, share.size + 1):
            held = total[bins : bins + share.size] - total[: share.size]
            if held.max() >= LEVEL * share.sum() - 1e-12:
                middle = TURN_DEG * (int(held.argmax()) + (bins - 1) / 2)
                return middle % 180, float(TURN_DEG * bins)
        return math.nan, 180.0


@dataclass(frozen=True)
class Inversion:
    """How surveys are asked about their motion.

    Parameters
    ----------
    responses : Responses
        Of all kinds of their stones.
    background : float
        Share of stones that do anything (pushed, badly founded).
    fixed : float
        Share of stones fixed to their base.
    """

    responses: Responses
    background: float = BACKGROUND
    fixed: float = 0.0

    def chances(self, stone: Stone, ways: NDArray[np.intp] = EVERY) -> NDArray[np.float32]:
        """Probability that a stone is found to have fallen each of some ways, or to stand, shape (s, l, r, ways)."""
        table = self.responses.table(StoneKind.of(stone))
        turn, face = TURN_DEG * np.arange(TURNS), stone.narrow_face_deg
        place, apart = np.zeros(TURNS, np.intp), np.zeros(TURNS, np.float64)
        if table.shape[2] > 1 and math.isnan(face):
            table = table.mean(axis=2, keepdims=True)
        elif table.shape[2] > 1:
            place = np.round((face - turn) / ORIENTATION_STEP_DEG).astype(np.intp)
            apart = np.asarray(face - turn - ORIENTATION_STEP_DEG * place, np.float64)
        # A way counted from true north, as seen from the north of the motion and from the face that was computed.
        back = np.round((turn + apart) / WAY_DEG).astype(np.intp)[:, None]
        seen = table[:, :, (place % table.shape[2])[:, None], np.where(ways == STOOD, STOOD, (ways - back) % WAYS)]
        free = (1 - self.background) * seen + self.background * blind()[ways].astype(np.float32)
        return np.asarray((1 - self.fixed) * free + np.float32(self.fixed) * (ways == STOOD))

    def log_likelihood(self, stones: Sequence[Stone]) -> FloatArray:
        """Logarithms of the likelihood of a survey of independent stones, shape (2, s, l, r).

        The first is of which stones fell, the second of the directions of those that did.
        """
        total = np.zeros((2, len(self.responses.motions), LEVELS.size, TURNS))
        for stone in stones:
            chance = self.chances(stone, np.append(found(stone), STOOD))
            stands, falls = chance[..., -1], 1 - chance[..., -1]
            total[0] += stone.count * np.log(falls if stone.fell else stands)
            if stone.fell:
                total[1] += stone.count * np.log(chance[..., :-1].sum(axis=-1) / falls)
        return total

    def posterior(self, logs: FloatArray, *, prior: ArrayLike = 1.0, power: float = POWER) -> Posterior:
        """What a survey says of the motion.

        Parameters
        ----------
        logs : ndarray, shape (2, s, l, r)
            Its `log_likelihood`.
        prior : array_like
            Prior weights that broadcast to (s, l, r); every motion, level and turn alike where not given.
        power : float
            Of the likelihood of the directions, see `POWER`.
        """
        logs = logs[0] + power * logs[1]
        weight = np.broadcast_to(np.asarray(prior, dtype=np.float64), logs.shape)
        probability, motions = weight * np.exp(logs - logs[weight > 0].max()), self.responses.motions
        return Posterior(
            sources=tuple(one.name for one in motions),
            level=LEVELS,
            turn=np.arange(0.0, 360.0, TURN_DEG),
            probability=probability / probability.sum(),
            prior=weight / weight.sum(),
            pga=np.array([one.pga / one.pgv for one in motions]),
            axis=np.array([one.axis for one in motions]),
        )

    def fit(self, stones: Sequence[Stone], posterior: Posterior, seed: int = 1) -> float:
        """Posterior predictive p-value: how often a survey drawn from the answer fits its best motion no better.

        Replicates have the stones of the survey (Gelman, Meng & Stern 1996, Statistica Sinica 6, 733). How well one
        fits is the largest, over the motions, levels and turns of the prior, of the log probability that each stone
        falls or stands as it did, and of the density of its direction over the largest of any direction: a density by
        itself grows as directions are told more finely.
        """
        generator = np.random.Generator(np.random.PCG64(seed))
        possible = np.flatnonzero(posterior.prior.ravel() > 0)
        share = posterior.probability.ravel()[possible]
        drawn = generator.choice(possible.size, REPLICATES, p=share / share.sum())
        totals = np.zeros((possible.size, 1 + REPLICATES), np.float32)
        for stone in stones:
            chance = self.chances(stone).reshape(-1, WAYS + 1)[possible]
            own = int(found(stone)[0])
            if stone.octant:
                chance = np.stack([chance[:, place == _OCTANT].sum(axis=1) for place in range(9)], axis=1)
                own = int(sector(stone.azimuth_deg, 8))
            below, falls = chance[drawn].cumsum(axis=1), chance[:, :-1]
            density = falls / falls.max(axis=1, keepdims=True)
            good = np.log(np.append(density * falls.sum(axis=1, keepdims=True), chance[:, -1:], 1))
            for _ in range(stone.count):
                lot = generator.random(REPLICATES)[:, None] * below[:, -1:]
                totals += good[:, np.append(own, (lot >= below).sum(axis=1))]
        best = totals.max(axis=0)
        return float((1 + (best[1:] <= best[0] + 1e-4).sum()) / (1 + REPLICATES))


def found(stone: Stone) -> NDArray[np.intp]:
    """The ways that are what a stone did: standing, the way of its direction, or those of its octant."""
    if not stone.fell:
        return np.array([STOOD])
    if stone.octant:
        return np.flatnonzero(_OCTANT[:STOOD] == sector(stone.azimuth_deg, 8))
    return np.array([round(stone.azimuth_deg / WAY_DEG) % WAYS])


@dataclass(frozen=True)
class Backwards:
    """The answer to a survey, with what a reader has to know of the survey.

    Attributes
    ----------
    name : str
        Of the survey's file.
    fell, stood : int
        Stones.
    fixed : float
        Share taken to be fixed.
    fit : float
        p-value of the check whether the library fits, see `Inversion.fit`.
    posterior : Posterior
        Of motion, level and turn.
    """

    name: str
    fell: int
    stood: int
    fixed: float
    fit: float
    posterior: Posterior

    @classmethod
    def of(cls, name: str, stones: Sequence[Stone], inversion: Inversion) -> "Backwards":
        """Ask a survey about its motion."""
        posterior = inversion.posterior(inversion.log_likelihood(stones))
        fell, stood = (sum(one.count for one in stones if one.fell is kind) for kind in (True, False))
        return cls(name, fell, stood, inversion.fixed, inversion.fit(stones, posterior), posterior)

    @property
    def strengths(self) -> dict[str, FloatArray]:
        """PGV in cm/s and PGA in g, largest over all azimuths, of each motion at each level, shape (s, l)."""
        pgv = self.posterior.pgv
        return {"PGV, cm/s": pgv / CM, "PGA, g": self.posterior.pga[:, None] * pgv / STANDARD_GRAVITY}


def write_backwards(answer: Backwards, path: Path) -> None:
    """Write an answer (NetCDF)."""
    table = xr.Dataset(
        {name: (dims, getattr(answer.posterior, name)) for name, dims in _STORED.items()},
        {"source": list(answer.posterior.sources)},
        {"survey": answer.name, **{name: getattr(answer, name) for name in ("fell", "stood", "fixed", "fit")}},
    )
    with atomic_write(path) as part:
        table.to_netcdf(part, engine="netcdf4")


def read_backwards(path: Path) -> Backwards:
    """Read what `write_backwards` wrote; a ResultError where it is missing or of another kind."""
    try:
        with xr.open_dataset(path, engine="netcdf4") as stored:
            table = stored.load()
        sources, about = tuple(str(name) for name in table["source"].to_numpy()), table.attrs
        posterior = Posterior(sources, **{name: np.asarray(table[name]) for name in _STORED})
        numbers = (int(about["fell"]), int(about["stood"]), float(about["fixed"]), float(about["fit"]))
        return Backwards(str(about["survey"]), *numbers, posterior)
    except (OSError, ValueError, KeyError) as error:
        raise ResultError(f"{path}: cannot be read ({error}); run the study again") from None
