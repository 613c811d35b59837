"""Fragility: the share of stones that fall over the intensity of the motion, as a lognormal curve, and its formats."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final
from xml.sax.saxutils import escape, quoteattr

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize
from scipy.special import log_ndtr, ndtr

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.files import atomic_write
from overturning.statistics.bootstrap import Interval, bootstrap

LEVELS: Final = 25
"""Intensities at which a curve is written."""


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
    """

    name: str
    measure: str
    unit: str
    median: float
    spread: float
    median_interval: Interval
    least: float
    most: float

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
    logs = np.log(x)

    def loss(parameters: FloatArray) -> float:
        z = parameters[0] + parameters[1] * logs
        return -float((w * (y * log_ndtr(z) + (1 - y) * log_ndtr(-z))).sum())

    slope = 1 / max(float(logs.std()), 1e-3)
    fit = minimize(loss, [-slope * float(logs.mean()), slope], method="BFGS")
    constant, slope = (float(value) for value in fit.x)
    # A slope without bound separates falls from stands; a spread above 3 says that the shares hardly grow with it.
    if not (1 / 3 < slope < 1e3 and math.isfinite(constant)):
        return math.nan, math.nan
    return math.exp(-constant / slope), 1 / slope


def fragility(
    name: str,
    measure: tuple[str, str],
    intensity: FloatArray,
    share: FloatArray,
    event: NDArray[np.str_],
    *,
    draws: int = 100,
    seed: int = 1,
) -> Fragility:
    """Fragility curve of a class of stones with the interval of its median; arrays have shape (n,)."""
    known = np.isfinite(share) & (intensity > 0)
    intensity, share, event = intensity[known], share[known], event[known]
    median, spread = lognormal_fit(intensity, share)
    names, member = np.unique(event, return_inverse=True)

    def medians(drawn: NDArray[np.intp]) -> FloatArray:
        counts = (np.bincount(events, minlength=names.size) for events in drawn)
        return np.array([lognormal_fit(intensity, share, count[member])[0] for count in counts])

    ends_of_median = Interval()
    if math.isfinite(median):
        ends_of_median = bootstrap(medians, np.arange(names.size), draws=draws, seed=seed)
    ends = (float(intensity.min()), float(intensity.max())) if intensity.size else (math.nan, math.nan)
    return Fragility(name, *measure, median, spread, ends_of_median, *ends)


def write_fragility_csv(curves: Sequence[Fragility], path: Path) -> None:
    """Write curves as a table: class, measure, unit, median and its interval, spread, range."""
    lines = ["stones,measure,unit,median,median_low,median_high,log_spread,least,most"]
    for one in curves:
        values = (one.median, *one.median_interval, one.spread, one.least, one.most)
        lines.append(f'"{one.name}",{one.measure},{one.unit},' + ",".join(f"{value:.6g}" for value in values))
    with atomic_write(path) as part:
        part.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_openquake(curves: Sequence[Fragility], path: Path, identifier: str) -> None:
    """Write the curves of one measure as an OpenQuake fragility model (NRML 0.5, discrete functions).

    The limit state is ``fallen``; curves that do not exist are left out. PGA is in g and PGV in cm/s, as OpenQuake has
    it.

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
        f"<description>{escape('Falls of gravestones, computed')}</description>",
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
