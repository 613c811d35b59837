"""Predicted against observed fall directions of a survey."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.statistics.circular import (
    TestResult,
    chi_square_test,
    grouped_watson_test,
    resultant,
    sector,
    watson_u2_test,
)
from overturning.surveys.prediction import BACKGROUND, SIDES, SitePrediction, knows_face, observed_side
from overturning.surveys.stones import Stone


@dataclass(frozen=True)
class SurveyComparison:
    """How a survey agrees with the prediction for its site.

    Attributes
    ----------
    fallen, stood : int
        Stones.
    mean_direction_deg, resultant : float
        Of the observed falls.
    octant_observed, octant_predicted : ndarray, shape (8,)
        Stones per compass octant, and expected ones.
    log_likelihood_ratio : float
        Sum over fallen stones of ln(predicted/uniform); above 0 the prediction is better than "any way".
    likelihood_ratio_p : float
        Share of surveys drawn from "any way" with a ratio at least as large.
    fit_octants, fit_octants_watson : TestResult
        Chi-square and grouped Watson U² of the octants against the prediction; NaN without falls.
    fit_exact : TestResult
        Watson U² of exact azimuths against the prediction; n = 0 where none was given.
    uniform_octants : TestResult
        Grouped Watson U² of the octants against uniformity.
    confusion : ndarray, shape (5, 5), or None
        Stones of known face and B/H: observed (rows) against most probable (columns), both in the order of `SIDES`.
    turned_every_way : int
        Fallen stones without face or B/H, for which stones turned every way were assumed.
    background : float
        Share taken to fall any way.
    """

    fallen: int
    stood: int
    mean_direction_deg: float
    resultant: float
    octant_observed: FloatArray
    octant_predicted: FloatArray
    log_likelihood_ratio: float
    likelihood_ratio_p: float
    fit_octants: TestResult
    fit_octants_watson: TestResult
    fit_exact: TestResult
    uniform_octants: TestResult
    confusion: NDArray[np.int64] | None
    turned_every_way: int
    background: float


def _density(site: SitePrediction, stone: Stone) -> FloatArray:
    """Fall directions of a stone; where its face is known one sector of 90° about each of its four normals."""
    if not knows_face(stone):
        return site.density(stone.b_over_h)
    sides = site.sides(stone)[1:]
    quarter = sector(site.azimuth - stone.face_azimuth_deg, 4)
    mass = np.array([site.share[quarter == i].sum() for i in range(4)])
    p = sides / sides.sum()
    return np.asarray(p[quarter] * site.share / mass[quarter])


def compare_survey(
    stones: Sequence[Stone], cube: xr.Dataset, *, background: float = BACKGROUND, draws: int = 2000, seed: int = 1
) -> SurveyComparison:
    """Compare the stones of a survey with the cube of its site.

    Parameters
    ----------
    stones : sequence of Stone
        From `read_survey`.
    cube, background
        As in `SitePrediction`.
    draws, seed : int
        For the p-value of the likelihood ratio (a parametric bootstrap under "any way": Davison & Hinkley 1997,
        Bootstrap Methods and their Application, section 4.2).

    Raises
    ------
    ArgumentError
        If there is no stone.
    """
    if not stones:
        raise ArgumentError("stones: none; a survey needs at least one row")
    site = SitePrediction(cube, background=background)
    fallen = [stone for stone in stones if stone.fell for _ in range(stone.count)]
    densities = {id(stone): _density(site, stone) for stone in stones if stone.fell}
    uniform_octant = site.octants(site.share)
    observed = np.bincount([sector(stone.azimuth_deg, 8) for stone in fallen], minlength=8).astype(np.float64)
    octants = {key: site.octants(density) for key, density in densities.items()}
    predicted = sum((octants[id(stone)] for stone in fallen), np.zeros(8))
    ratio, p_value = _likelihood_ratio(site, fallen, densities, octants, draws, seed)
    share = predicted / predicted.sum() if fallen else uniform_octant
    exact = [stone for stone in fallen if not stone.octant]
    mean, length = resultant([stone.azimuth_deg for stone in fallen]) if fallen else (math.nan, math.nan)
    return SurveyComparison(
        fallen=len(fallen),
        stood=sum(stone.count for stone in stones if not stone.fell),
        mean_direction_deg=mean,
        resultant=length,
        octant_observed=observed,
        octant_predicted=predicted,
        log_likelihood_ratio=ratio,
        likelihood_ratio_p=p_value,
        fit_octants=chi_square_test(observed, share),
        fit_octants_watson=grouped_watson_test(observed, share),
        fit_exact=watson_u2_test([_distribution(site, densities[id(s)], s.azimuth_deg) for s in exact]),
        uniform_octants=grouped_watson_test(observed, uniform_octant),
        confusion=_confusion(site, stones),
        turned_every_way=sum(1 for stone in fallen if not knows_face(stone)),
        background=background,
    )


def _likelihood_ratio(
    site: SitePrediction,
    fallen: Sequence[Stone],
    densities: dict[int, FloatArray],
    octants: dict[int, FloatArray],
    draws: int,
    seed: int,
) -> tuple[float, float]:
    """Sum of ln(predicted/uniform) over the fallen stones, and the share of surveys of "any way" that reach it."""
    if not fallen:
        return math.nan, math.nan
    uniform_octant = site.octants(site.share)
    ratios, tables = [], []
    for stone in fallen:
        density = densities[id(stone)]
        if stone.octant:
            table, chance = octants[id(stone)] / uniform_octant, uniform_octant
            place = int(sector(stone.azimuth_deg, 8))
        else:
            table, chance, place = density / site.share, site.share, site.nearest(stone.azimuth_deg)
        ratios.append(math.log(table[place]))
        tables.append((np.log(table), chance))
    generator = np.random.Generator(np.random.PCG64(seed))
    simulated = np.zeros(draws)
    for table, chance in tables:
        simulated += table[generator.choice(chance.size, size=draws, p=chance / chance.sum())]
    total = float(np.sum(ratios))
    return total, (1 + int((simulated >= total - 1e-12).sum())) / (1 + draws)


def _confusion(site: SitePrediction, stones: Sequence[Stone]) -> NDArray[np.int64] | None:
    """Observed against most probable sides of the stones whose face and B/H are known; None without any."""
    known = [stone for stone in stones if knows_face(stone)]
    if not known:
        return None
    confusion = np.zeros((len(SIDES), len(SIDES)), dtype=np.int64)
    for stone in known:
        confusion[observed_side(stone), int(np.argmax(site.sides(stone)))] += stone.count
    return confusion


def _distribution(site: SitePrediction, density: FloatArray, azimuth_deg: float) -> float:
    """Distribution function of the predicted fall azimuth, even within each sector, from the first border."""
    edges = np.concatenate([[0.0], np.cumsum(site.share * 360)])
    below = np.concatenate([[0.0], np.cumsum(density)])
    return float(min(1.0, np.interp((azimuth_deg - site.start) % 360, edges, below)))
