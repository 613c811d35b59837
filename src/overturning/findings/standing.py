"""Survival of stones under a hazard, and the bound that standing stones put on the rate of falls."""

import math
from collections.abc import Sequence
from typing import Final

from overturning.errors import ResultError
from overturning.findings.values import FindingBaseClass, OptionalNumberOrInfinity
from overturning.statistics.bootstrap import exact_share_interval
from overturning.surveys.hazard import hazard_unit_warning
from overturning.surveys.standing import (
    FALL_RATE_BOUND_PROBABILITY,
    MAX_SHARE_OF_FALLS_FROM_SHAKING_OUTSIDE_RECORDS,
    SurvivalProbabilityByStoneClass,
    annual_fall_rate_below_lowest_hazard_level,
    max_hazard_factor_allowed_by_standing_stones,
    upper_bound_of_annual_fall_rate,
)
from overturning.surveys.stones import Stone

MAX_UNREPORTED_FALL_SHARE_BELOW_FIRST_HAZARD_LEVEL: Final = 0.01
"""Share of the falls from shaking below the hazard's first level up to which it is not reported."""


class StoneClassSurvival(FindingBaseClass):
    """Probability that stones of a class survive a seismic hazard, computed with one intensity measure."""

    stone_class: str
    intensity_measure: str
    annual_fall_rate_per_stone: OptionalNumberOrInfinity
    survival_probability: OptionalNumberOrInfinity
    """Probability that a stone stands for the exposure time, with its 95 % interval."""
    survival_probability_low: OptionalNumberOrInfinity
    survival_probability_high: OptionalNumberOrInfinity
    surviving_share_with_constant_deviations: OptionalNumberOrInfinity
    """Share of the class that stands if the deviation of each stone from its class is constant."""
    share_of_falls_from_shaking_beyond_records: OptionalNumberOrInfinity
    """Share of the falls that come from shaking beyond the records."""
    hazard_factor_upper_bound: OptionalNumberOrInfinity
    """Upper bound of a factor on the hazard from standing stones; None without a bound."""
    share_of_stones_falling_at_lowest_hazard_level: OptionalNumberOrInfinity
    """Share of the stones that fall at the first level of the hazard; None if weaker shaking is negligible."""
    lowest_hazard_level: float
    intensity_unit: str
    annual_fall_rate_below_first_hazard_level: OptionalNumberOrInfinity
    """Falls from shaking down to a tenth of the first level, if the fragility curve holds there."""


class StoneClassWithoutFragilityCurve(FindingBaseClass):
    """Class of stones whose survival is unknown, because no median of its fragility curve could be fitted."""

    stone_class: str
    intensity_measure: str
    is_fragility_median_beyond_records: bool
    """True if the median lies beyond the records, False if no curve fits the falls."""


class SurveyStandingCountsAndAnnualFallRateBound(FindingBaseClass):
    """Numbers of standing and fallen stones in a survey, and the upper bound of the fall rate that they imply."""

    stood: int
    fell: int
    total: int
    fall_rate_upper_bound_per_year: OptionalNumberOrInfinity
    """Upper bound of the rate of falls if none fell; otherwise None."""
    confidence_of_fall_rate_bound: float
    standing_share: OptionalNumberOrInfinity
    """Share that stands, with its exact binomial 95 % interval."""
    standing_share_low: OptionalNumberOrInfinity
    standing_share_high: OptionalNumberOrInfinity


class StoneSurvivalUnderHazardFindings(FindingBaseClass):
    """Probability that each class of stones survives a seismic hazard for a number of years."""

    exposure_time_years: float
    hazard_unit_warnings: list[str]
    """Doubts about the units of the hazard curves."""
    survival_of_stone_classes: list[StoneClassSurvival]
    classes_without_fragility_curve: list[StoneClassWithoutFragilityCurve]
    survey_stone_counts: SurveyStandingCountsAndAnnualFallRateBound | None


def survival_findings(
    survival: SurvivalProbabilityByStoneClass, survey_stones: Sequence[Stone] | None
) -> StoneSurvivalUnderHazardFindings:
    """Return the report's numbers on the survival of stone classes, and the fall-rate bound from standing stones.

    `survey_stones` are the stones of a survey; None without a survey.

    Raises
    ------
    ResultError
        If the unit of a hazard curve is doubtful and most falls come from shaking outside the range of the records.
    """
    stood, fell = (sum(one.stone_count for one in survey_stones or () if one.fell is kind) for kind in (False, True))
    bound = upper_bound_of_annual_fall_rate(survival.exposure_time_years) if stood and not fell else math.nan
    return StoneSurvivalUnderHazardFindings(
        exposure_time_years=survival.exposure_time_years,
        hazard_unit_warnings=_check_hazard_levels_and_list_unit_warnings(survival),
        survival_of_stone_classes=[
            _survival_finding_of_stone_class(survival, place, bound)
            for place in range(len(survival.curves_with_standing_probabilities))
        ],
        classes_without_fragility_curve=[
            StoneClassWithoutFragilityCurve(
                stone_class=row.stones,
                intensity_measure=row.measure,
                is_fragility_median_beyond_records=not math.isnan(row.median),
            )
            for row in survival.fragility_rows_without_fitted_curve
        ],
        survey_stone_counts=None
        if survey_stones is None
        else _survey_standing_counts_and_rate_bound(stood, fell, bound),
    )


def _check_hazard_levels_and_list_unit_warnings(survival: SurvivalProbabilityByStoneClass) -> list[str]:
    """Return a warning for each hazard curve whose intensity levels are implausible in its unit.

    A `ResultError` is raised if the unit of a curve is doubtful and most falls come from shaking outside the range of
    the records.
    """
    doubts = {
        one.measure: f"{survival.hazard_table_name}: {why}"
        for one in survival.hazard_curve_by_measure.values()
        if (why := hazard_unit_warning(one))
    }
    for *_, one in survival.curves_with_standing_probabilities:
        if (
            one.intensity_measure in doubts
            and not one.fall_rate_share_outside_fragility_data <= MAX_SHARE_OF_FALLS_FROM_SHAKING_OUTSIDE_RECORDS
        ):
            share = (
                "no falls"
                if math.isnan(one.fall_rate_share_outside_fragility_data)
                else f"{100 * one.fall_rate_share_outside_fragility_data:.0f} % of the falls of {one.stone_class}"
            )
            raise ResultError(f"{doubts[one.intensity_measure]}; {share} come from levels beyond the records")
    return list(doubts.values())


def _survival_finding_of_stone_class(
    survival: SurvivalProbabilityByStoneClass, stone_class_index: int, survey_fall_rate_upper_bound_per_year: float
) -> StoneClassSurvival:
    """Return the report's numbers on the survival of a stone class, and the hazard bound from standing stones."""
    curve, hazard, one = survival.curves_with_standing_probabilities[stone_class_index]
    weaker = annual_fall_rate_below_lowest_hazard_level(curve, hazard)
    counts = weaker > MAX_UNREPORTED_FALL_SHARE_BELOW_FIRST_HAZARD_LEVEL * one.annual_fall_rate_per_stone
    return StoneClassSurvival(
        stone_class=one.stone_class,
        intensity_measure=one.intensity_measure,
        annual_fall_rate_per_stone=one.annual_fall_rate_per_stone,
        survival_probability=one.standing_probability,
        survival_probability_low=one.standing_probability_low,
        survival_probability_high=one.standing_probability_high,
        surviving_share_with_constant_deviations=one.standing_share_if_each_stone_keeps_its_deviation,
        share_of_falls_from_shaking_beyond_records=one.fall_rate_share_outside_fragility_data,
        hazard_factor_upper_bound=max_hazard_factor_allowed_by_standing_stones(
            curve, hazard, survival.exposure_time_years, survey_fall_rate_upper_bound_per_year
        ),
        share_of_stones_falling_at_lowest_hazard_level=one.fall_probability_at_lowest_hazard_level
        if counts
        else math.nan,
        lowest_hazard_level=float(hazard.intensity_levels[0]),
        intensity_unit=hazard.unit,
        annual_fall_rate_below_first_hazard_level=weaker if counts else math.nan,
    )


def _survey_standing_counts_and_rate_bound(
    standing_stone_count: int, fallen_stone_count: int, survey_fall_rate_upper_bound_per_year: float
) -> SurveyStandingCountsAndAnnualFallRateBound:
    """Return the counts and the share of standing stones in a survey, together with the given fall-rate bound."""
    low, high = exact_share_interval(standing_stone_count, standing_stone_count + fallen_stone_count)
    return SurveyStandingCountsAndAnnualFallRateBound(
        stood=standing_stone_count,
        fell=fallen_stone_count,
        total=standing_stone_count + fallen_stone_count,
        fall_rate_upper_bound_per_year=survey_fall_rate_upper_bound_per_year,
        confidence_of_fall_rate_bound=FALL_RATE_BOUND_PROBABILITY,
        standing_share=standing_stone_count / (standing_stone_count + fallen_stone_count)
        if standing_stone_count + fallen_stone_count
        else math.nan,
        standing_share_low=low,
        standing_share_high=high,
    )
