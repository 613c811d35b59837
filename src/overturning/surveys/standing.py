"""Survival of stones under a seismic hazard, and bounds on the hazard from stones that still stand."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq
from scipy.special import ndtr

from overturning.arrays import FloatArray
from overturning.errors import ResultError
from overturning.surveys.hazard import (
    CAPACITY_POINTS_IN_STANDARD_DEVIATIONS,
    MIN_LOG_SPREAD,
    FragilityCurveParametersRow,
    HazardCurve,
)

FALL_RATE_BOUND_PROBABILITY: Final = 0.95
"""Probability that the rate of falls lies below its upper bound."""

MAX_SEARCHED_HAZARD_FACTOR: Final = 1e6
"""Largest factor on the hazard; if stones survive even this, there is no bound."""


MAX_SHARE_OF_FALLS_FROM_SHAKING_OUTSIDE_RECORDS: Final = 0.9
"""Largest share of falls from shaking outside the range of the records; above it, implausible levels are refused."""


@dataclass(frozen=True)
class SurvivalProbabilityEstimate:
    """Probability that stones of a class survive a seismic hazard for T years.

    Attributes
    ----------
    stone_class, intensity_measure : str
        Class and intensity measure.
    annual_fall_rate_per_stone : float
        Annual rate of falls λ, 1/year; shaking above the highest hazard level counts with the fall probability at this
        level.
    standing_probability, standing_probability_low, standing_probability_high : float
        Probability exp(−λT) that a stone stands after T years, and its values for both ends of the interval of
        the fragility median (NaN without interval). The low value also assumes that every stone falls in shaking
        above the highest hazard level.
    standing_share_if_each_stone_keeps_its_deviation : float
        Share of the class that stands after T years if each stone is stronger or weaker than its class by a constant
        factor; at least `standing_probability`. NaN if the spreads among records and among stones are unknown.
    fall_rate_share_outside_fragility_data : float
        Share of λ from levels outside the range of the fragility data.
    fall_probability_at_lowest_hazard_level : float
        Probability of falling at the lowest hazard level; weaker shaking is not counted in λ.
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


def upper_bound_of_annual_fall_rate(years_without_fall: float) -> float:
    """Return the upper bound of the annual fall rate, 1/year, that follows if no stone fell for a number of years.

    The rate lies below it with the probability `FALL_RATE_BOUND_PROBABILITY`.

    With a flat prior, the posterior density of the rate λ after T years without a fall is T exp(−λT) (Gelman et al.
    2013, Bayesian Data Analysis, section 2.6: gamma posterior of a rate). Stones of one place share their earthquakes
    and count as one.
    """
    return -math.log1p(-FALL_RATE_BOUND_PROBABILITY) / years_without_fall


def max_hazard_factor_allowed_by_standing_stones(
    fragility_curve: FragilityCurveParametersRow,
    hazard_curve: HazardCurve,
    exposure_years: float,
    survey_fall_rate_upper_bound_per_year: float,
) -> float:
    """Return the largest factor on the hazard that standing stones allow: with it, only 5 % of stones would stand.

    Each stone is stronger or weaker than its class by a constant factor, and those that still stand are the strong
    ones. So the factor on the hazard is larger than ``survey_fall_rate_upper_bound_per_year`` divided by the fall rate
    of the class; it equals this ratio if the spreads among records and among stones are unknown. NaN if there is no
    bound.
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
