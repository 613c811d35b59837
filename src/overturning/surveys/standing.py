"""Survival of stones under a seismic hazard, and bounds on the hazard from stones that still stand."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BaseModel, Field
from scipy.optimize import brentq
from scipy.special import log_ndtr, ndtr

from overturning.arrays import FloatArray
from overturning.errors import ResultError
from overturning.tables import read_table_rows

CAPACITY_POINTS_IN_STANDARD_DEVIATIONS: Final = np.linspace(-6.0, 6.0, 241)
"""Integration points for the capacity of a stone relative to its class, in standard deviations."""

MIN_LOG_SPREAD: Final = 1e-3
"""Smallest logarithmic spread of a fragility curve; smaller values are replaced by it."""

FALL_RATE_BOUND_PROBABILITY: Final = 0.95
"""Probability that the rate of falls lies below its upper bound."""

MAX_SEARCHED_HAZARD_FACTOR: Final = 1e6
"""Largest factor on the hazard; if stones survive even this, there is no bound."""


MAX_SHARE_OF_FALLS_FROM_SHAKING_OUTSIDE_RECORDS: Final = 0.9
"""Largest share of falls from shaking outside the range of the records; above it, implausible levels are refused."""

HIGHEST_HAZARD_LEVEL_RANGE_AND_OTHER_UNIT_BY_UNIT: Final = {
    "g": (0.05, 20.0, 981.0, "Gal"),
    "cm/s": (10.0, 2000.0, 0.01, "m/s"),
}
"""By unit: least and largest plausible highest level of a hazard curve, and the likely other unit: how many of it make
one of this unit, and its name."""


class FragilityCurveParametersRow(BaseModel, extra="forbid"):
    """Row of the table ``fragility.csv``: parameters of the fragility curve of one class of stones."""

    stones: str
    measure: str
    unit: str
    median: float
    median_low: float = math.nan
    median_high: float = math.nan
    log_spread: float = math.nan
    least: float = 0.0
    most: float = math.inf
    record_spread: float = math.nan
    other_spread: float = math.nan
    id: str = ""


class HazardCurveRow(BaseModel, extra="forbid"):
    """Row of a hazard table: an intensity level, and the annual rate at which shaking exceeds it."""

    measure: str
    unit: str
    level: float = Field(gt=0, allow_inf_nan=False)
    annual_rate: float = Field(gt=0, allow_inf_nan=False)


@dataclass(frozen=True)
class HazardCurve:
    """Hazard curve: annual rates at which intensity levels are exceeded; between levels, a power law.

    Attributes
    ----------
    measure, unit : str
        Intensity measure and its unit.
    intensity_levels, annual_exceedance_rates : ndarray, shape (n,)
        Ascending levels and their annual rates of exceedance, 1/year.
    """

    measure: str
    unit: str
    intensity_levels: FloatArray
    annual_exceedance_rates: FloatArray

    def interpolate_annual_exceedance_rates(self, at_intensity_levels: ArrayLike) -> FloatArray:
        """Return the annual rates, 1/year, at which shaking exceeds given intensity levels, by interpolation."""
        x, ln_rates = np.log(self.intensity_levels), np.log(self.annual_exceedance_rates)
        return np.asarray(np.exp(np.interp(np.log(at_intensity_levels), x, ln_rates)))

    def annual_fall_rate(
        self,
        fragility_medians: ArrayLike,
        log_spread: float,
        lowest_level: float = 0.0,
        highest_level: float = math.inf,
    ) -> FloatArray:
        """Compute annual rates of falls, 1/year, due to shaking between two levels, for several fragility medians.

        ∫ P |dν| = P ν at the lower end − P ν at the upper end + ∫ ν dP, whose part over a power law a x^−k
        is exactly a m^−k exp(k²β²/2) [Φ(z + kβ)], z = ln(x/m)/β, between its ends (completing the square;
        Cornell, Jalayer, Hamburger & Foutch 2002, Journal of Structural Engineering 128, 526, for a single power law).

        Parameters
        ----------
        fragility_medians : array_like, shape (m,)
            Medians of lognormal fragility curves, in the unit of the levels.
        log_spread : float
            Standard deviation of the natural logarithm of the level at which a stone falls.
        lowest_level, highest_level : float
            Ends of the range of levels, in the same unit.

        Returns
        -------
        ndarray, shape (m,)
            Rate, 1/year; 0 if the levels do not overlap.
        """
        first_level = max(lowest_level, float(self.intensity_levels[0]))
        last_level = min(highest_level, float(self.intensity_levels[-1]))
        if first_level >= last_level:
            return np.zeros(np.size(fragility_medians))
        between = (self.intensity_levels > first_level) & (self.intensity_levels < last_level)
        level = np.concatenate([[first_level], self.intensity_levels[between], [last_level]])
        x, rate = np.log(level), np.log(self.interpolate_annual_exceedance_rates(level))
        m, log_spread = np.log(np.atleast_1d(fragility_medians))[:, None], max(log_spread, MIN_LOG_SPREAD)
        k = -np.diff(rate) / np.diff(x)
        below, above = ((x[part] - m) / log_spread + k * log_spread for part in (slice(None, -1), slice(1, None)))
        below, above = np.where(below > 0, -above, below), np.where(below > 0, -below, above)  # where Φ keeps digits
        inside = log_ndtr(above) + np.log1p(-np.exp(log_ndtr(below) - log_ndtr(above)))
        parts = np.exp(rate[:-1] + k * x[:-1] - k * m + 0.5 * (k * log_spread) ** 2 + inside)
        first, last = (ndtr((x[end] - m[:, 0]) / log_spread) * np.exp(rate[end]) for end in (0, -1))
        return np.asarray(first - last + parts.sum(axis=1))


@dataclass(frozen=True)
class SurvivalProbabilityEstimate:
    """Probability that stones of a class survive a seismic hazard for T years.

    Attributes
    ----------
    stone_class, intensity_measure : str
        Class and intensity measure.
    annual_fall_rate_per_stone : float
        Annual rate of falls λ, 1/year; stronger shaking than the last level counts with the probability there.
    standing_probability, standing_probability_low, standing_probability_high : float
        Probability exp(−λT) that a stone stands after T years, and its values at the ends of the interval of the
        median (NaN without interval). The lower end also assumes that every stone falls above the last level of the
        hazard.
    standing_share_if_each_stone_keeps_its_deviation : float
        Share of the class that stands if the deviation of each stone from its class is constant over T years; at least
        `standing_probability`. NaN if the components of the spread are unknown.
    fall_rate_share_outside_fragility_data : float
        Share of λ from levels outside the range of the fragility data.
    fall_probability_at_lowest_hazard_level : float
        Probability of falling at the first level of the hazard; weaker shaking is not counted.
    """

    stone_class: str
    intensity_measure: str
    annual_fall_rate_per_stone: float
    standing_probability: float
    standing_probability_low: float
    standing_probability_high: float
    standing_share_if_each_stone_keeps_its_deviation: float
    fall_rate_share_outside_fragility_data: float
    fall_probability_at_lowest_hazard_level: float


def estimate_standing_probability(
    fragility_curve: FragilityCurveParametersRow, hazard_curve: HazardCurve, exposure_years: float
) -> SurvivalProbabilityEstimate:
    """Compute the probability that stones still stand after `exposure_years`, from their fragility and a hazard curve.

    The fragility curve must have a fitted median.
    """
    last, seldom = float(hazard_curve.intensity_levels[-1]), float(hazard_curve.annual_exceedance_rates[-1])

    def fall_probability(intensity_level: float, fragility_medians: ArrayLike, log_spread: float) -> FloatArray:
        """Return the probability of a fall at one intensity level, for each of several fragility medians."""
        ln_ratios = np.log(intensity_level / np.atleast_1d(fragility_medians))
        return np.asarray(ndtr(ln_ratios / max(log_spread, MIN_LOG_SPREAD)))

    def annual_fall_rates_with_capped_intensity(fragility_medians: ArrayLike, log_spread: float) -> FloatArray:
        """Return the annual rate of falls, 1/year, for each of several fragility medians.

        Shaking above the last level of the hazard curve counts with the fall probability of that level.
        """
        within = hazard_curve.annual_fall_rate(fragility_medians, log_spread)
        return np.asarray(within + seldom * fall_probability(last, fragility_medians, log_spread))

    spread = fragility_curve.log_spread
    # An end outside the data is 0 or infinite: all shaking overturns the stone, or none.
    medians = np.clip(
        [fragility_curve.median, fragility_curve.median_low, fragility_curve.median_high],
        1e-9 * hazard_curve.intensity_levels[0],
        1e9 * last,
    )
    rate, strong, weak = (float(one) for one in annual_fall_rates_with_capped_intensity(medians, spread))
    strong += seldom * float(1 - fall_probability(last, medians[1], spread)[0])
    known = float(
        hazard_curve.annual_fall_rate(fragility_curve.median, spread, fragility_curve.least, fragility_curve.most)[0]
    )
    if fragility_curve.least <= last <= fragility_curve.most:  # above the last level, with the probability there
        known += seldom * float(fall_probability(last, fragility_curve.median, spread)[0])
    share = math.nan
    if math.isfinite(fragility_curve.other_spread):
        each = annual_fall_rates_with_capped_intensity(
            fragility_curve.median * np.exp(CAPACITY_POINTS_IN_STANDARD_DEVIATIONS * fragility_curve.other_spread),
            fragility_curve.record_spread,
        )
        weight = np.exp(-0.5 * CAPACITY_POINTS_IN_STANDARD_DEVIATIONS**2)
        share = float(np.sum(weight * np.exp(-each * exposure_years)) / weight.sum())
    first = float(fall_probability(float(hazard_curve.intensity_levels[0]), fragility_curve.median, spread)[0])
    stands, low, high = (math.exp(-one * exposure_years) for one in (rate, strong, weak))
    beyond = 1 - known / rate if rate > 0 else math.nan
    return SurvivalProbabilityEstimate(
        fragility_curve.stones, fragility_curve.measure, rate, stands, low, high, share, beyond, first
    )


@dataclass(frozen=True)
class SurvivalProbabilityByStoneClass:
    """Probability that each class of stones in a fragility table survives the hazard for a number of years.

    Attributes
    ----------
    exposure_time_years : float
        Exposure time, years.
    hazard_table_name : str
        Name of the hazard table, for messages.
    hazard_curve_by_measure : dict
        Hazard curves by measure.
    curves_with_standing_probabilities : tuple
        Curve, hazard and estimate of each class with a fragility curve for a measure of the hazard.
    fragility_rows_without_fitted_curve : tuple of FragilityCurveParametersRow
        Classes whose median or spread is unknown.
    """

    exposure_time_years: float
    hazard_table_name: str
    hazard_curve_by_measure: dict[str, HazardCurve]
    curves_with_standing_probabilities: tuple[
        tuple[FragilityCurveParametersRow, HazardCurve, SurvivalProbabilityEstimate], ...
    ]
    fragility_rows_without_fitted_curve: tuple[FragilityCurveParametersRow, ...]


def survival_probability_by_stone_class(
    fragility_curves: Sequence[FragilityCurveParametersRow],
    hazard_curve_by_measure: dict[str, HazardCurve],
    exposure_years: float,
    fragility_and_hazard_file_names: tuple[str, str],
) -> SurvivalProbabilityByStoneClass:
    """Compute the survival probability of each class of stones whose intensity measure has a hazard curve.

    A ResultError with `fragility_and_hazard_file_names` is raised if a unit differs between the two tables, or if the
    tables have no measure in common.
    """
    fragility, hazard = fragility_and_hazard_file_names
    units = {one.measure: one.unit for one in fragility_curves}
    for measure in hazard_curve_by_measure.keys() & units.keys():
        own = hazard_curve_by_measure[measure].unit
        if own != units[measure]:
            raise ResultError(f"{hazard}: {measure} in {own}, but {fragility} has it in {units[measure]}; convert it")
    shared = [one for one in fragility_curves if one.measure in hazard_curve_by_measure]
    if not shared:
        raise ResultError(
            f"{hazard}: {', '.join(hazard_curve_by_measure)}; {fragility} has {', '.join(units)}: give one of these"
        )
    known = [one for one in shared if math.isfinite(one.log_spread)]
    estimates = (
        (
            one,
            hazard_curve_by_measure[one.measure],
            estimate_standing_probability(one, hazard_curve_by_measure[one.measure], exposure_years),
        )
        for one in known
    )
    rest = tuple(one for one in shared if one not in known)
    return SurvivalProbabilityByStoneClass(exposure_years, hazard, hazard_curve_by_measure, tuple(estimates), rest)


def hazard_unit_warning(hazard_curve: HazardCurve) -> str:
    """Return a warning if the highest intensity of a hazard curve is implausible in its unit; else "".

    The warning names the likely unit.

    The highest level is judged: curves end where exceedance is very rare, at 0.05 to 20 g, or 10 to 2000 cm/s. Levels
    in a unit that is smaller by a factor of 100 or more then lie above, and in a larger one below.
    """
    low, high, factor, other = HIGHEST_HAZARD_LEVEL_RANGE_AND_OTHER_UNIT_BY_UNIT.get(
        hazard_curve.unit, (0.0, math.inf, 1.0, "")
    )
    top = float(hazard_curve.intensity_levels[-1])
    if low <= top <= high:
        return ""
    meant = f"; are they in {other}? Divide them by {factor:g}" if low <= top / factor <= high else ""
    return (
        f"{hazard_curve.measure}: levels of {hazard_curve.intensity_levels[0]:g} to {top:g} {hazard_curve.unit}, of "
        f"which the highest is expected between {low:g} and {high:g} {hazard_curve.unit}{meant}"
    )


def upper_bound_of_annual_fall_rate(years_without_fall: float) -> float:
    """Return the upper bound of the annual fall rate, 1/year, that follows if no stone fell for a number of years.

    The rate lies below it with the probability `FALL_RATE_BOUND_PROBABILITY`.

    The posterior of λ after T years without a fall is T exp(−λT), from a flat prior; stones of one place share
    their earthquakes and count as one (Gelman et al. 2013, Bayesian Data Analysis, section 2.6: gamma posterior of a
    rate).
    """
    return -math.log1p(-FALL_RATE_BOUND_PROBABILITY) / years_without_fall


def max_hazard_factor_allowed_by_standing_stones(
    fragility_curve: FragilityCurveParametersRow,
    hazard_curve: HazardCurve,
    exposure_years: float,
    survey_fall_rate_upper_bound_per_year: float,
) -> float:
    """Return the largest factor on the hazard that standing stones allow: with it, only 5 % of stones would stand.

    The bound follows from stones that still stand: a larger factor would have overturned more of them.

    The deviation of each stone from its class is constant, and standing stones are the strong ones, so the factor is
    larger than ``survey_fall_rate_upper_bound_per_year`` divided by the mean rate of the class. It equals this ratio if
    the components of the spread are unknown. NaN without a bound.
    """
    rate = estimate_standing_probability(fragility_curve, hazard_curve, exposure_years).annual_fall_rate_per_stone
    if math.isnan(survey_fall_rate_upper_bound_per_year) or not rate > 0:
        return math.nan

    def standing_share_minus_five_percent(ln_hazard_factor: float) -> float:
        """Return the share of stones that stand if the hazard is multiplied by exp(`ln_hazard_factor`), minus 5 %."""
        return estimate_standing_probability(
            fragility_curve, hazard_curve, exposure_years * math.exp(ln_hazard_factor)
        ).standing_share_if_each_stone_keeps_its_deviation - (1 - FALL_RATE_BOUND_PROBABILITY)

    # Twice the time has the same effect as twice the hazard.
    first, last = (
        math.log(survey_fall_rate_upper_bound_per_year / rate),
        math.log(MAX_SEARCHED_HAZARD_FACTOR * max(1.0, survey_fall_rate_upper_bound_per_year / rate)),
    )
    if math.isnan(standing_share_minus_five_percent(first)) or standing_share_minus_five_percent(first) <= 0:
        return survey_fall_rate_upper_bound_per_year / rate
    return (
        math.exp(brentq(standing_share_minus_five_percent, first, last))
        if standing_share_minus_five_percent(last) < 0
        else math.nan
    )


def annual_fall_rate_below_lowest_hazard_level(
    fragility_curve: FragilityCurveParametersRow, hazard_curve: HazardCurve
) -> float:
    """Estimate the annual rate of falls due to shaking below the hazard curve's first level, by extrapolation."""
    steepness = np.log(hazard_curve.annual_exceedance_rates[0] / hazard_curve.annual_exceedance_rates[1]) / np.log(
        hazard_curve.intensity_levels[1] / hazard_curve.intensity_levels[0]
    )
    level = hazard_curve.intensity_levels[0] * np.array([0.1, 1.0])
    below = HazardCurve(
        hazard_curve.measure,
        hazard_curve.unit,
        level,
        hazard_curve.annual_exceedance_rates[0] * (level / level[1]) ** -steepness,
    )
    return float(below.annual_fall_rate(fragility_curve.median, fragility_curve.log_spread)[0])


def read_fragility_curves(path: Path) -> list[FragilityCurveParametersRow]:
    """Read the fragility curves in a table ``fragility.csv``; raise a ResultError if the table is invalid."""
    return [
        row
        for _, row in read_table_rows(
            path, FragilityCurveParametersRow, delimiter=",", error_class=ResultError, table_kind="fragility table"
        )
    ]


def read_hazard_curves_by_intensity_measure(path: Path) -> dict[str, HazardCurve]:
    """Read hazard curves from a table; return them by intensity measure.

    A ResultError is raised if levels do not ascend, or rates grow with the level.
    """
    rows: dict[str, list[tuple[int, HazardCurveRow]]] = {}
    for line, row in read_table_rows(
        path, HazardCurveRow, delimiter=",", error_class=ResultError, table_kind="hazard table"
    ):
        rows.setdefault(row.measure, []).append((line, row))
    found = {}
    for measure, of_measure in rows.items():
        for (_, before), (line, row) in pairwise(of_measure):
            if row.level <= before.level or row.annual_rate > before.annual_rate or row.unit != before.unit:
                raise ResultError(
                    f"{path} line {line}: {measure} {row.level:g} {row.unit}, {row.annual_rate:g}/year after "
                    f"{before.level:g} {before.unit}, {before.annual_rate:g}/year; give ascending levels of one unit "
                    "with rates that do not grow"
                )
        if len(of_measure) < 2:
            raise ResultError(f"{path}: {measure} has one level; give two or more")
        level, rate = (np.array([getattr(row, of) for _, row in of_measure]) for of in ("level", "annual_rate"))
        found[measure] = HazardCurve(measure, of_measure[0][1].unit, level, rate)
    if not found:
        raise ResultError(f"{path}: no level; write one row per level below the header")
    return found
