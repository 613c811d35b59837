"""Fragility: the share of stones that fall over the intensity of the motion, as a lognormal curve, and its formats."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final
from xml.sax.saxutils import quoteattr

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import log_ndtr, ndtr

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.files import atomic_write
from overturning.statistics.bootstrap import Interval, bootstrap

LEVELS: Final = 25
"""Intensities at which a curve is written."""

MOST_ITERATIONS: Final = 100
"""Steps of a fit before it counts as without end."""

LARGEST_STEP: Final = 2.0
"""Change of a fit's constant or slope, in standard deviations of the data, in one step."""

MOST_AT_ONCE: Final = 500_000
"""Values that are fitted in one go: samples times shares."""


@dataclass(frozen=True)
class Fragility:
    """A lognormal fragility curve P(fall) = Φ(ln(x/median)/spread).

    Attributes
    ----------
    name : str
        Of the class of stones.
    measure, unit : str
        Intensity measure and its unit.
    median, spread : float
        Median in that unit, and standard deviation of the logarithm; NaN where no curve fits.
    median_interval : Interval
        95 % interval of the median, by bootstrap over earthquakes.
    least, most : float
        Range of the intensities that it was fitted to: it says nothing outside.
    told : float, Interval, float
        Median, its interval and the spread as far as the data reach: infinite above `most`, 0 below `least`; no spread
        where the median lies beyond.
    """

    name: str
    measure: str
    unit: str
    median: float
    spread: float
    median_interval: Interval
    least: float
    most: float

    @property
    def told(self) -> tuple[float, Interval, float]:  # noqa: D102
        median, low, high = (
            math.inf if one > self.most else 0.0 if one < self.least else one
            for one in (self.median, *self.median_interval)
        )
        return median, Interval(low, high), self.spread if self.least <= median <= self.most else math.nan

    def probability(self, intensity: ArrayLike) -> FloatArray:
        """Probability of falling."""
        return np.asarray(ndtr(np.log(np.asarray(intensity, dtype=np.float64) / self.median) / self.spread))


def lognormal_fit(intensity: ArrayLike, share: ArrayLike, weight: ArrayLike | None = None) -> tuple[float, float]:
    """Median and logarithmic spread that make the shares likeliest (Baker 2015, Earthquake Spectra 31, eq. 11).

    Parameters
    ----------
    intensity, share, weight : array_like, shape (n,)
        Intensities above 0, share of stones that fell, 0 to 1, and weight of each, 1 where not given.

    Returns
    -------
    (float, float)
        NaN where nothing falls, everything does, or the shares hardly grow with the intensity.

    Raises
    ------
    ArgumentError
        If shapes differ, an intensity is not positive or a share lies outside 0 to 1.
    """
    x, y = np.asarray(intensity, dtype=np.float64), np.asarray(share, dtype=np.float64)
    w = np.ones_like(y) if weight is None else np.asarray(weight, dtype=np.float64)
    if x.shape != y.shape:
        raise ArgumentError(f"share: shape {y.shape}, intensity {x.shape}; one share per intensity")
    if x.size and not (x.min() > 0 and y.min() >= 0 and y.max() <= 1):
        raise ArgumentError("intensities must be positive, and shares lie in 0 to 1")
    if x.size < 2 or y.min() == y.max():
        return math.nan, math.nan
    (median,), (spread,) = _fits(np.log(x), y, w[None])
    return float(median), float(spread)


def _fits(logs: FloatArray, y: FloatArray, weight: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Medians and spreads, shape (m,), of `lognormal_fit` with each row of weights, shape (m, n), by Fisher scoring.

    McCullagh & Nelder 1989, Generalized Linear Models, section 2.5. A step that lowers the likelihood, which is
    concave, is halved: without that the iteration may go to and fro for ever.
    """
    middle, width = float(logs.mean()), max(float(logs.std()), 1e-3)
    scaled = (logs - middle) / width
    # Constant and slope of each row with their likelihood, the step they try next, and which rows still move.
    found, moving = np.tile([0.0, 1.0], (len(weight), 1)), np.ones(len(weight), bool)
    likelihood, trying = np.full(len(weight), -np.inf), np.zeros_like(found)
    for _ in range(MOST_ITERATIONS):
        if not moving.any():
            break
        tried = found + trying
        z = tried[:, :1] + tried[:, 1:] * scaled
        below, above = log_ndtr(z), log_ndtr(-z)
        reached = (weight * (y * below + (1 - y) * above)).sum(axis=1)
        worse = moving & (reached < likelihood - 1e-12 * np.abs(reached))
        trying[worse] /= 2
        better = moving & ~worse
        found[better], likelihood[better] = tried[better], reached[better]
        w, z, below, above = weight[better], z[better], below[better], above[better]
        density = -0.5 * z * z - 0.5 * math.log(2 * math.pi)
        falls, stands = np.exp(density - below), np.exp(density - above)
        score, information = w * (y * falls - (1 - y) * stands), w * falls * stands
        gradient = np.stack([score.sum(axis=1), score @ scaled], axis=1)
        a, b, c = information.sum(axis=1), information @ scaled, information @ scaled**2
        with np.errstate(divide="ignore", invalid="ignore"):
            step = np.stack([c * gradient[:, 0] - b * gradient[:, 1], a * gradient[:, 1] - b * gradient[:, 0]], axis=1)
            step /= (a * c - b * b)[:, None]
        step *= np.minimum(1.0, LARGEST_STEP / np.maximum(np.abs(step).max(axis=1), LARGEST_STEP))[:, None]
        trying[better] = step
        moving[better] = np.abs(gradient).max(axis=1) > 1e-9 * w.sum(axis=1)
    found = np.where(moving[:, None], np.nan, found + trying)
    slope = found[:, 1] / width
    # A slope without bound separates falls from stands; a spread above 3 says that the shares hardly grow with it.
    slope = np.where((slope > 1 / 3) & (slope < 1e3), slope, np.nan)
    return np.exp(middle - found[:, 0] / slope), 1 / slope


def fragility(
    name: str,
    measure: tuple[str, str],
    intensity: FloatArray,
    share: FloatArray,
    event: NDArray[np.str_],
) -> Fragility:
    """Fragility curve of a class of stones with the interval of its median; arrays have shape (n,)."""
    known = np.isfinite(share) & (intensity > 0)
    intensity, share, event = intensity[known], share[known], event[known]
    median, spread = lognormal_fit(intensity, share)
    names, member = np.unique(event, return_inverse=True)

    def medians(drawn: NDArray[np.intp]) -> FloatArray:
        count = (drawn[:, :, None] == np.arange(names.size)).sum(axis=1, dtype=np.float64)
        parts = np.array_split(count, math.ceil(len(drawn) * share.size / MOST_AT_ONCE))
        return np.concatenate([_fits(np.log(intensity), share, part[:, member])[0] for part in parts])

    ends_of_median = Interval()
    if math.isfinite(median):
        ends_of_median = bootstrap(medians, np.arange(names.size))
    ends = (float(intensity.min()), float(intensity.max())) if intensity.size else (math.nan, math.nan)
    return Fragility(name, *measure, median, spread, ends_of_median, *ends)


def write_fragility_csv(curves: Sequence[Fragility], path: Path) -> None:
    """Write curves as a table: class, measure, unit, median and its interval, spread, all as `told`, range.

    Where the median lies beyond the data, the spread is missing too: both would be a curve where nothing is known.
    """
    lines = ["stones,measure,unit,median,median_low,median_high,log_spread,least,most"]
    for one in curves:
        median, ends, spread = one.told
        values = (median, *ends, spread, one.least, one.most)
        lines.append(f'"{one.name}",{one.measure},{one.unit},' + ",".join(f"{value:.6g}" for value in values))
    with atomic_write(path) as part:
        part.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_openquake(curves: Sequence[Fragility], path: Path, identifier: str) -> None:
    """Write the curves of one measure as an OpenQuake fragility model (NRML 0.5, discrete functions).

    The limit state is ``fallen``; curves that do not exist are left out. Levels are those of the data alone, also where
    the probability has not reached one half at the last. PGA is in g and PGV in cm/s, as OpenQuake has it.

    Raises
    ------
    ArgumentError
        If the curves are of several measures, or of one that OpenQuake does not know.
    """
    measures = {one.measure for one in curves}
    if len(measures) != 1 or not measures <= {"PGA", "PGV"}:
        raise ArgumentError(f"curves of {', '.join(sorted(measures)) or 'nothing'}; give those of PGA or those of PGV")
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<nrml xmlns="http://openquake.org/xmlns/nrml/0.5">',
        f'<fragilityModel id={quoteattr(identifier)} assetCategory="contents" lossCategory="contents">',
        "<description>Falls of gravestones, computed; nothing is known beyond the levels of a function</description>",
        "<limitStates>fallen</limitStates>",
    ]
    for one in curves:
        if not math.isfinite(one.median):
            continue
        levels = np.geomspace(one.least, one.most, LEVELS)
        intensities = " ".join(f"{value:.6g}" for value in levels)
        probabilities = " ".join(f"{value:.6f}" for value in one.probability(levels))
        lines += [
            f'<fragilityFunction id={quoteattr(one.name)} format="discrete">',
            f'<imls imt="{one.measure}" noDamageLimit="{one.least:.6g}">{intensities}</imls>',
            f'<poes ls="fallen">{probabilities}</poes>',
            "</fragilityFunction>",
        ]
    lines += ["</fragilityModel>", "</nrml>"]
    with atomic_write(path) as part:
        part.write_text("\n".join(lines) + "\n", encoding="utf-8")
