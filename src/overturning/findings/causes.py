"""Causes of falls: logistic fit, skill of published criteria, and comparison with published outcomes."""

import math
from collections.abc import Mapping, Sequence

from overturning.findings.results import StudyResults
from overturning.findings.values import (
    Estimate,
    FindingBaseClass,
    OptionalNumberOrInfinity,
    estimate_from_mean,
    negate_estimate,
)
from overturning.labels import note_if_sizes_are_not_those_of_shown_stone
from overturning.statistics.criteria import MAX_VALID_PULSE_TO_BLOCK_FREQUENCY_RATIO, score_overturning_criteria
from overturning.statistics.logistic import CONFIDENCE_LEVEL, coefficient_interval_and_predictor_range_rows

QUANTITY_TO_DOUBLE_BY_COEFFICIENT_INDEX = {1: "PGA and PGV", 2: "PGV alone", 4: "size of the block"}
"""Quantity that doubles if a predictor of `statistics.logistic.PREDICTOR_NAMES` grows by ln 2, by coefficient index."""


class LogisticCoefficient(FindingBaseClass):
    """Coefficient of one predictor in the logistic regression of falls, with its confidence interval."""

    predictor: str
    """Name of the predictor; "intercept" for the constant."""
    value: OptionalNumberOrInfinity
    """Change of the log-odds of a fall per unit of the predictor."""
    low: OptionalNumberOrInfinity
    """Lower end of the interval of `value`."""
    high: OptionalNumberOrInfinity
    """Upper end of the interval of `value`."""
    data_minimum: OptionalNumberOrInfinity
    """Smallest value of the predictor in the data."""
    data_maximum: OptionalNumberOrInfinity
    """Largest value of the predictor in the data."""
    odds_factor_per_doubling: OptionalNumberOrInfinity
    """Factor on the odds of a fall if the quantity doubles and the other predictors stay; None for the intercept."""
    odds_factor_per_doubling_low: OptionalNumberOrInfinity
    """Lower end of the interval of `odds_factor_per_doubling`."""
    odds_factor_per_doubling_high: OptionalNumberOrInfinity
    """Upper end of the interval of `odds_factor_per_doubling`."""


class FallProbabilityFromHalfAfterDoubling(FindingBaseClass):
    """Fall probability, with interval, after a quantity such as PGV doubles, if the probability was 0.5 before."""

    doubled_quantity: str
    """Quantity that doubles, the others fixed: "PGA and PGV", "PGV alone", or "size of the block"."""
    fall_probability_after_doubling_from_half: OptionalNumberOrInfinity
    """Probability of a fall after doubling if it was 0.5 before."""
    fall_probability_after_doubling_from_half_low: OptionalNumberOrInfinity = None
    """Lower end of the interval of `fall_probability_after_doubling_from_half`."""
    fall_probability_after_doubling_from_half_high: OptionalNumberOrInfinity = None
    """Upper end of the interval of `fall_probability_after_doubling_from_half`."""


class LogisticFitFindings(FindingBaseClass):
    """Logistic regression of falls on the motion and the block, with jackknife intervals over earthquakes."""

    coefficients: list[LogisticCoefficient]
    """Coefficient of each predictor."""
    fitted_outcome_count: int
    """Number of fitted rows: outcomes of a block in a plane under a record."""
    earthquake_count: int
    """Number of earthquakes."""
    confidence_level: float
    """Probability of the intervals."""
    fall_probabilities_after_doubling: list[FallProbabilityFromHalfAfterDoubling]
    """Factors on the odds as probabilities, for the predictors whose interval excludes no effect."""
    reason_for_missing_fit_or_interval: str
    """Reason why there is no fit or no interval; otherwise empty."""


class CriterionScore(FindingBaseClass):
    """Skill with which a criterion predicts falls: hit rate minus false-alarm rate."""

    criterion: str
    """Name of the criterion."""
    predicted_fall_condition: str
    """Condition under which the criterion predicts a fall."""
    hit_rate: OptionalNumberOrInfinity
    """Share of the falls that the criterion predicts."""
    false_alarm_rate: OptionalNumberOrInfinity
    """Share of the standing blocks for which the criterion predicts a fall."""
    skill: Estimate
    """Skill over all blocks together."""
    mean_skill_at_fixed_height_and_b_over_h: Estimate
    """Mean over heights and B/H of the skill among the blocks of one height and B/H."""
    mean_skill_within_pulse_criterion_range: OptionalNumberOrInfinity
    """Mean skill at fixed height and B/H without planes and blocks beyond the range of the pulse criterion."""


class SkillDifferenceOfTwoCriteria(FindingBaseClass):
    """Skill of the criterion listed first minus that of the one listed second, among blocks of equal height and B/H."""

    first_criterion: str
    """Name of the criterion that is listed first."""
    second_criterion: str
    """Name of the criterion that is listed second."""
    first_minus_second: Estimate
    """Value of `mean_skill_at_fixed_height_and_b_over_h` of the first criterion minus that of the second."""


class CriteriaFindings(FindingBaseClass):
    """Skill of published overturning criteria; the last score is that of the best prediction from B/H alone."""

    scores: list[CriterionScore]
    """Score of each criterion."""
    significantly_best_criterion: str
    """Criterion with the largest mean skill at fixed height and B/H; empty unless it leads all others significantly."""
    largest_skill_criterion: str
    """Criterion with the largest mean skill at fixed height and B/H; empty if no skill is defined."""
    best_minus_other_skill_by_other_criterion: dict[str, Estimate]
    """Mean skill at fixed height and B/H of `largest_skill_criterion` minus that of each other criterion."""
    insignificant_differences_from_best_skill: list[SkillDifferenceOfTwoCriteria]
    """Values of `best_minus_other_skill_by_other_criterion` with intervals that include 0, in the order of `scores`."""
    share_of_cases_beyond_pulse_criterion_range: OptionalNumberOrInfinity
    """Share of planes and blocks for which the pulse criterion is far too low."""
    max_valid_pulse_to_block_frequency_ratio: float = MAX_VALID_PULSE_TO_BLOCK_FREQUENCY_RATIO
    """Largest frequency ratio ω/p for which the pulse criterion is valid."""


class PublishedAndComputedBlockOutcome(FindingBaseClass):
    """Published and computed outcome of one block under one record along one azimuth."""

    variant: str
    """Name of the variant; "nominal" for the study itself."""
    record: str
    """Identifier of the record."""
    motion_azimuth_deg: float
    """Azimuth of the motion, degrees."""
    height_m: float
    """Height of the block, m."""
    friction: float
    """Friction coefficient."""
    published_overturns: bool | None
    """True if the block overturns according to the publication; None if it is not known."""
    computed_overturns: bool | None
    """True if the block overturns in the study; None if the outcome is not known."""


def logistic_fit_findings(results: StudyResults) -> LogisticFitFindings | None:
    """Return the report's numbers on the logistic fit of the fall probability to the motion and the block.

    None for 3-D models, or if height and B/H are not those of the stone whose outcomes are fitted.
    """
    if (fit := results.logistic_fit) is None:
        return None
    rows = []
    for name, value, low, high, least, most in coefficient_interval_and_predictor_range_rows(fit):
        doubled = [2.0**one for one in (value, low, high)] if name != "intercept" else [math.nan] * 3
        rows.append(
            LogisticCoefficient(
                predictor=name,
                value=value,
                low=low,
                high=high,
                data_minimum=least,
                data_maximum=most,
                odds_factor_per_doubling=doubled[0],
                odds_factor_per_doubling_low=doubled[1],
                odds_factor_per_doubling_high=doubled[2],
            )
        )
    fitted = (
        {}
        if fit.reason_without_estimate_or_interval.startswith("no fit")
        else {rows[place].predictor: name for place, name in QUANTITY_TO_DOUBLE_BY_COEFFICIENT_INDEX.items()}
    )
    chances = [
        _fall_probability_if_quantity_doubles(fitted[one.predictor], one) for one in rows if one.predictor in fitted
    ]
    return LogisticFitFindings(
        coefficients=[] if fit.reason_without_estimate_or_interval.startswith("no fit") else rows,
        fitted_outcome_count=fit.row_count,
        earthquake_count=fit.earthquake_cluster_count,
        confidence_level=CONFIDENCE_LEVEL,
        fall_probabilities_after_doubling=[one for one in chances if one is not None],
        reason_for_missing_fit_or_interval=fit.reason_without_estimate_or_interval,
    )


def _fall_probability_if_quantity_doubles(
    doubled_quantity: str, coefficient: LogisticCoefficient
) -> FallProbabilityFromHalfAfterDoubling | None:
    """Return the fall probability after a quantity, such as PGV, doubles, if the probability was 0.5 before.

    None if the effect is not significant: the interval of the factor on the odds includes 1.
    """
    odds = (
        coefficient.odds_factor_per_doubling,
        coefficient.odds_factor_per_doubling_low,
        coefficient.odds_factor_per_doubling_high,
    )
    known = [one for one in odds if one is not None]
    if len(known) < len(odds) or known[1] <= 1.0 <= known[2]:
        return None
    value, low, high = (1.0 - 1.0 / (1.0 + one) for one in known)  # also for a factor too large for a number
    return FallProbabilityFromHalfAfterDoubling(
        doubled_quantity=doubled_quantity,
        fall_probability_after_doubling_from_half=value,
        fall_probability_after_doubling_from_half_low=low,
        fall_probability_after_doubling_from_half_high=high,
    )


def skill_of_published_criteria(results: StudyResults) -> CriteriaFindings | None:
    """Compute the skill (hit rate minus false-alarm rate) of published overturning criteria for a study's outcomes.

    None for 3-D models, if height and B/H are not those of the stone whose outcomes are shown, or if no outcome is
    known.
    """
    asked = results.model.is_planar and not note_if_sizes_are_not_those_of_shown_stone(results.reference_element_cube)
    found = score_overturning_criteria(results.reference_element_cube, results.intensity_measures) if asked else None
    if found is None:
        return None
    scores = [
        CriterionScore(
            criterion=one.name,
            predicted_fall_condition=one.rule_text,
            hit_rate=one.counts_over_all_cases.hit_rate,
            false_alarm_rate=one.counts_over_all_cases.false_alarm_rate,
            skill=estimate_from_mean(one.peirce_skill_over_all_cases, "skill over all blocks together"),
            mean_skill_at_fixed_height_and_b_over_h=estimate_from_mean(
                one.weighted_mean_skill_over_block_sizes, "mean skill over blocks of one height and B/H"
            ),
            mean_skill_within_pulse_criterion_range=one.weighted_mean_skill_in_pulse_valid_range,
        )
        for one in found.rule_scores
    ]
    leads = {
        name: estimate_from_mean(lead, "difference of the skills within blocks")
        for name, lead in found.best_minus_other_skill_by_criterion_name.items()
    }
    return CriteriaFindings(
        scores=scores,
        significantly_best_criterion=found.score_of_best_criterion.name
        if leads and all(one.excludes_zero for one in leads.values())
        else "",
        largest_skill_criterion=found.score_of_best_criterion.name if leads else "",
        best_minus_other_skill_by_other_criterion=leads,
        insignificant_differences_from_best_skill=_insignificant_skill_differences(
            found.score_of_best_criterion.name, leads, [one.criterion for one in scores]
        ),
        share_of_cases_beyond_pulse_criterion_range=found.case_share_above_valid_pulse_frequency_ratio,
    )


def _insignificant_skill_differences(
    criterion_with_largest_skill: str,
    skill_lead_by_other_criterion: Mapping[str, Estimate],
    criterion_names_in_listed_order: Sequence[str],
) -> list[SkillDifferenceOfTwoCriteria]:
    """Return those differences in skill between the best and another criterion whose interval includes 0."""
    differences = []
    for other, lead in skill_lead_by_other_criterion.items():
        if lead.excludes_zero:
            continue
        if criterion_names_in_listed_order.index(criterion_with_largest_skill) < criterion_names_in_listed_order.index(
            other
        ):
            first, second, difference = criterion_with_largest_skill, other, lead
        else:
            first, second, difference = other, criterion_with_largest_skill, negate_estimate(lead)
        differences.append(
            SkillDifferenceOfTwoCriteria(first_criterion=first, second_criterion=second, first_minus_second=difference)
        )
    return differences


def compare_outcomes_with_published(results: StudyResults) -> list[PublishedAndComputedBlockOutcome]:
    """Compare computed outcomes with published ones, for each variant, height and friction of the study.

    Empty if the study names no published outcomes.
    """
    if not results.study.published:
        return []
    return [
        PublishedAndComputedBlockOutcome(
            variant=variant,
            record=row.record,
            motion_azimuth_deg=row.azimuth,
            height_m=round(height, 9),
            friction=round(friction, 9),
            published_overturns=row.overturns,
            computed_overturns=overturns,
        )
        for variant in results.cubes_by_variant
        for (height, friction), found in published_cases_recomputed_by_height_and_friction(results, variant).items()
        for row, overturns in zip(results.study.published, found, strict=True)
    ]


def published_cases_recomputed_by_height_and_friction(
    results: StudyResults, variant_name: str
) -> dict[tuple[float, float], tuple[bool | None, ...]]:
    """Return, by (height, friction), the computed outcomes of the cases whose outcome is published.

    The outcomes are in the order of the published cases, each of which has a record, azimuth and B/H. An outcome is
    True if the block overturns, False if it stands, None if it is unknown.
    """
    cube, ids = results.cube_of_default_element(variant_name), [name.id for name in results.record_ids_and_names]
    # The published cells only: a cube larger than memory is not read.
    cells = [
        cube["overturned"]
        .isel(record=ids.index(row.record))
        .sel(azimuth=row.azimuth, b_over_h=row.b_over_h)
        .stack(size=("height", "friction"))
        for row in results.study.published
    ]
    flags = zip(*(cell.to_numpy().tolist() for cell in cells), strict=True)
    known = (tuple(None if math.isnan(flag) else flag != 0 for flag in each) for each in flags)
    return dict(zip(cells[0]["size"].to_numpy().tolist(), known, strict=True))
