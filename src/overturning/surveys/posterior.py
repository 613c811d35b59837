"""What a survey says of its motion: probability of each motion, strength and turn, and how it is kept."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.errors import ResultError
from overturning.files import atomic_write
from overturning.units import CM, STANDARD_GRAVITY

TURN_DEG: Final = 10
"""Step by which each motion is turned, degrees."""

TURNS: Final = 360 // TURN_DEG

LEVEL: Final = 0.9
"""Probability inside a stated interval."""

NO_AXIS_DEG: Final = 180.0 * LEVEL
"""Width of an arc that holds an axis of which nothing is known with probability `LEVEL`, degrees.

A survey in which every stone fell tells no axis: in such simulated surveys arcs of 71 % of the half turn on average
held the true axis in 73 % (`verification/backwards_coverage.py`), as often as if they had been laid at random.
"""

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

    def axis_arc(self, *, everything_fell: bool = False) -> tuple[float, float]:
        """Middle (0 to 180) and width of the arc stated for the axis, degrees.

        It is the shortest arc that holds `LEVEL` of the axis's probability, widened to `NO_AXIS_DEG` where every stone
        of the survey fell (`everything_fell`).
        """
        middle, width = self._shortest_arc()
        return middle, max(width, NO_AXIS_DEG) if everything_fell else width

    def _shortest_arc(self) -> tuple[float, float]:
        share = self.of_axes()
        total = np.concatenate([[0.0], np.cumsum(np.tile(share, 2))])
        for bins in range(1, share.size + 1):
            held = total[bins : bins + share.size] - total[: share.size]
            if held.max() >= LEVEL * share.sum() - 1e-12:
                middle = TURN_DEG * (int(held.argmax()) + (bins - 1) / 2)
                return middle % 180, float(TURN_DEG * bins)
        return math.nan, 180.0


@dataclass(frozen=True)
class InversionResult:
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

    @property
    def everything_fell(self) -> bool:
        """True if stones fell and none stood."""
        return self.fell > 0 and self.stood == 0

    @property
    def axis_arc(self) -> tuple[float, float]:
        """Middle and width of the arc stated for the axis, degrees; see `Posterior.axis_arc`."""
        return self.posterior.axis_arc(everything_fell=self.everything_fell)

    @property
    def strengths(self) -> dict[str, FloatArray]:
        """PGV in cm/s and PGA in g, largest over all azimuths, of each motion at each level, shape (s, l)."""
        pgv = self.posterior.pgv
        return {"PGV, cm/s": pgv / CM, "PGA, g": self.posterior.pga[:, None] * pgv / STANDARD_GRAVITY}


def write_inversion(answer: InversionResult, path: Path) -> None:
    """Write an answer (NetCDF)."""
    table = xr.Dataset(
        {name: (dims, getattr(answer.posterior, name)) for name, dims in _STORED.items()},
        {"source": list(answer.posterior.sources)},
        {"survey": answer.name, **{name: getattr(answer, name) for name in ("fell", "stood", "fixed", "fit")}},
    )
    with atomic_write(path) as part:
        table.to_netcdf(part, engine="netcdf4")


def read_inversion(path: Path) -> InversionResult:
    """Read what `write_inversion` wrote; a ResultError where it is missing or of another kind."""
    try:
        with xr.open_dataset(path, engine="netcdf4") as stored:
            table = stored.load()
        sources, about = tuple(str(name) for name in table["source"].to_numpy()), table.attrs
        posterior = Posterior(sources, **{name: np.asarray(table[name]) for name in _STORED})
        numbers = (int(about["fell"]), int(about["stood"]), float(about["fixed"]), float(about["fit"]))
        return InversionResult(str(about["survey"]), *numbers, posterior)
    except (OSError, ValueError, KeyError) as error:
        raise ResultError(f"{path}: cannot be read ({error}); run the study again") from None
