"""How well criteria of peak motion predict the falls of a cube: hits, false alarms and skill, by size and shape."""

from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.statistics.bootstrap import Interval, bootstrap
from overturning.statistics.limits import CRITERIA
from overturning.statistics.logistic import overturning_rows
from overturning.units import STANDARD_GRAVITY


@dataclass(frozen=True)
class Score:
    """Falls predicted, falls not predicted, falls predicted that did not come, and stands predicted, as weighted."""

    hits: float
    misses: float
    false_alarms: float
    rejections: float

    @property
    def hit_rate(self) -> float:
        """Share of the falls that were predicted; NaN without a fall."""
        return _share(self.hits, self.hits + self.misses)

    @property
    def false_alarm_rate(self) -> float:
        """Share of the stands for which a fall was predicted; NaN where nothing stands."""
        return _share(self.false_alarms, self.false_alarms + self.rejections)

    @property
    def skill(self) -> float:
        """Hit rate less false-alarm rate: 1 perfect, 0 no better than a guess (Peirce 1884, Science 4)."""
        return self.hit_rate - self.false_alarm_rate

    @property
    def right(self) -> float:
        """Share of all that was predicted rightly."""
        total = self.hits + self.misses + self.false_alarms + self.rejections
        return _share(self.hits + self.rejections, total)


def _share(part: float, of: float) -> float:
    return part / of if of > 0 else float("nan")


def score(predicted: ArrayLike, falls: ArrayLike, weight: ArrayLike | None = None) -> Score:
    """Score of what was predicted, yes or no, against what fell, a share of 0 to 1, each shape (n,)."""
    falling, fell = np.asarray(predicted, dtype=bool), np.asarray(falls, dtype=np.float64)
    w = np.ones_like(fell) if weight is None else np.asarray(weight, dtype=np.float64)
    counts = ((w * fell)[falling], (w * fell)[~falling], (w * (1 - fell))[falling], (w * (1 - fell))[~falling])
    return Score(*(float(each.sum()) for each in counts))


@dataclass(frozen=True)
class CriteriaScores:
    """Scores of `limits.CRITERIA`, in their order.

    Attributes
    ----------
    overall : tuple of Score
        Of all planes and cases.
    interval : tuple of Interval
        95 % interval of the skill, by bootstrap over earthquakes.
    blocks : dict of (float, float) to tuple of Score
        By height, m, and B/H.
    falls : dict of (float, float) to float
        Share that falls, likewise.
    """

    overall: tuple[Score, ...]
    interval: tuple[Interval, ...]
    blocks: dict[tuple[float, float], tuple[Score, ...]]
    falls: dict[tuple[float, float], float]


def criteria_scores(
    cube: xr.Dataset, intensity: xr.Dataset, *, draws: int = 500, seed: int = 1
) -> CriteriaScores | None:
    """Score the field's criteria on a cube, as of `overturning_rows`; None where no outcome is known.

    The cells' own outcomes count, not the ensemble's probabilities; draws and seed are those of the bootstrap.
    """
    predictors, falls, event, weight = overturning_rows(cube, intensity, ensemble=False)
    if not falls.size:
        return None
    over_west, ratio, slender, height = np.exp(predictors).T
    pga = over_west * STANDARD_GRAVITY * slender
    said = [pga >= one.acceleration(height, slender, ratio) for one in CRITERIA]
    # Round-off of the logarithm must not part equal values.
    sizes = np.stack([height, slender], axis=1).round(9)
    kinds, member = np.unique(sizes, axis=0, return_inverse=True)
    member = member.ravel()
    blocks, shares = {}, {}
    for index, (tall, shape) in enumerate(kinds.tolist()):
        own = member == index
        blocks[tall, shape] = tuple(score(one[own], falls[own], weight[own]) for one in said)
        shares[tall, shape] = float((falls * weight)[own].sum() / weight[own].sum())
    return CriteriaScores(
        tuple(score(one, falls, weight) for one in said),
        tuple(_interval(one, falls, weight, event, draws, seed) for one in said),
        blocks,
        shares,
    )


def _interval(
    said: NDArray[np.bool_], falls: FloatArray, weight: FloatArray, event: NDArray[np.intp], draws: int, seed: int
) -> Interval:
    """95 % interval of the skill, earthquakes drawn with replacement."""
    names, member = np.unique(event, return_inverse=True)
    columns = (weight * falls * said, weight * falls * ~said, weight * (1 - falls) * said, weight * (1 - falls) * ~said)
    counts = np.stack([np.bincount(member, column, names.size) for column in columns], axis=1)

    def skill(drawn: FloatArray) -> FloatArray:
        hits, misses, alarms, rejections = drawn.sum(axis=1).T
        with np.errstate(invalid="ignore"):
            return np.asarray(hits / (hits + misses) - alarms / (alarms + rejections))

    return bootstrap(skill, counts, draws=draws, seed=seed)
