"""Shifts and twists of the standing stones of surveys, next to those of the standing stones of a 3-D study."""

import math

from pydantic import Field

from overturning.findings.results import StudyResults
from overturning.findings.surveys import SurveySiteSoilAmplification, soil_findings_of_survey_sites
from overturning.findings.values import FindingBaseClass, OptionalNumberOrInfinity
from overturning.statistics.circular import MIN_RESULTANT_WITH_MEAN_DIRECTION
from overturning.surveys.directions_in_space import FallDirectionComparisonIn3D
from overturning.surveys.displacement_results import (
    ComparedStatisticName,
    FallAndDisplacementComparison,
    StoredDisplacementComparison,
)
from overturning.surveys.displacements import MIN_SHIFT_COUNTED_AS_SHIFTED_M, MIN_TWIST_COUNTED_AS_TWISTED_DEG
from overturning.surveys.stones import OCTANTS
from overturning.units import CM


class ObservedShareOrMedianWithInterval(FindingBaseClass):
    """Observed share or median of a survey's stones, with its exact 95 % interval."""

    value: OptionalNumberOrInfinity
    """Share or median; None without stones."""
    low: OptionalNumberOrInfinity
    """Lower end of the interval; None without stones, and for a median of fewer than six stones."""
    high: OptionalNumberOrInfinity
    """Upper end of the interval."""
    level: float = 0.95
    """Probability of the interval."""


class ShareOrMedianWithRangeOverFrictions(FindingBaseClass):
    """Computed share or median over a survey's stones: mean and range over the friction coefficients of the study."""

    value: OptionalNumberOrInfinity
    """Mean over frictions; None if nothing of the kind was computed."""
    low: OptionalNumberOrInfinity
    """Smallest value of a friction; None if the study has one friction."""
    high: OptionalNumberOrInfinity
    """Largest value of a friction; None if the study has one friction."""


class DisplacementMeasureFinding(FindingBaseClass):
    """Observed and computed value of a share (0 to 1), a median shift (cm) or a median twist (degrees)."""

    share_or_median_name: ComparedStatisticName
    """Share that fell, share of the standing stones that are shifted or twisted, share of clockwise twists, medians."""
    observed_stone_count: int
    """Number of observed stones of the share or median."""
    observed: ObservedShareOrMedianWithInterval
    computed: ShareOrMedianWithRangeOverFrictions


class FallDirectionFindingsIn3D(FindingBaseClass):
    """Observed fall directions of a survey's stones, and the directions in which similar stones of a 3-D study fall."""

    falls_in_known_direction: int
    """Number of stones that fell in a known direction."""
    observed_mean_direction_deg: OptionalNumberOrInfinity
    """Mean fall direction; None if the falls show no common direction (p > 0.05)."""
    observed_fall_direction_resultant_length: OptionalNumberOrInfinity
    """Length of the mean of the fall directions as unit vectors, 0 to 1."""
    predicted_mean_direction_deg: OptionalNumberOrInfinity
    """Mean of the predicted directions of these stones; None if they have no common direction."""
    predicted_fall_direction_resultant_length: OptionalNumberOrInfinity
    """Length of the mean of the predicted directions as unit vectors, 0 to 1."""
    observed_falls_by_octant: dict[str, OptionalNumberOrInfinity]
    """Number of fallen stones in each octant of fall direction; a direction between two (NNE) counts in both."""
    predicted_falls_by_octant: dict[str, OptionalNumberOrInfinity]
    """Predicted number of fallen stones in each octant."""
    log_likelihood_ratio: OptionalNumberOrInfinity
    """Sum over these stones of ln(predicted/uniform); above 0 if the prediction is better than a guess."""
    likelihood_ratio_p_value_if_directions_random: OptionalNumberOrInfinity
    """Share of surveys of stones that fall in random directions with a ratio at least as large."""
    known_direction_falls_without_any_computed_fall: int
    """Falls of stones like which none falls in the study; their predicted direction is random."""
    known_direction_falls_without_prediction: int
    """Falls without an outcome, or with a B/H or D/B far outside the study; their predicted direction is random."""
    falls_with_predicted_direction: int
    """Number of `falls_in_known_direction` whose predicted direction is not random."""
    has_no_stone_with_prediction: bool
    """True if B/H or D/B of all stones of the survey lies far outside the study."""
    assumed_random_direction_share: float
    """Assumed share of the stones that fall in a random direction."""


class SiteFallAndDisplacementFindings(FindingBaseClass):
    """Observed and computed falls, shifts and twists of the stones at one survey site, or at all sites together."""

    site: str
    """Name of the site; empty for stones without one, and for all sites together."""
    fell: int
    """Number of stones that fell."""
    stood: int
    """Number of stones that stood."""
    matching_computed_cases: int
    """Number of different computed cases that resemble the stones."""
    standing_stones_without_standing_simulation: int
    """Standing stones like which none stands in the study; they are compared in no displacement."""
    stones_without_computed_outcome: int
    """Stones like which no computed case has an outcome; they are compared in no computed value."""
    stones_far_outside_b_over_h_or_aspect_range: int
    """Stones whose B/H or D/B lies more than a quarter outside the study; they are compared in no computed value."""
    compared_shares_and_medians: list[DisplacementMeasureFinding]
    fall_direction_findings: FallDirectionFindingsIn3D | None = None
    """Fall directions; None if no stone fell in a known direction."""


class SurveyFallAndDisplacementFindings(FindingBaseClass):
    """Comparison of a survey with a 3-D study: falls and their directions, shifts and twists of the stones."""

    survey_file_name: str
    """Name of the survey file."""
    sha256: str
    """SHA-256 hash of the survey file."""
    record: str
    """Record for whose site the study was computed."""
    survey_file_warnings: list[str]
    """Doubts about the survey file, such as the unit of its azimuths."""
    survey_file_comments: list[str]
    """Comment lines at the start of the survey file that are not empty."""
    min_shift_counted_as_shifted_cm: float = MIN_SHIFT_COUNTED_AS_SHIFTED_M / CM
    """Shift from which a standing stone counts as shifted, cm."""
    min_twist_counted_as_twisted_deg: float = MIN_TWIST_COUNTED_AS_TWISTED_DEG
    """Absolute twist from which a standing stone counts as twisted, degrees."""
    all_sites: SiteFallAndDisplacementFindings
    """All sites together."""
    sites: list[SiteFallAndDisplacementFindings] = Field(default_factory=list)
    """Each site by itself; empty if the survey has only one."""
    cemetery_soil_findings: list[SurveySiteSoilAmplification] = Field(default_factory=list)
    """Soil below the cemeteries; empty if the record is used as it is for all stones."""


def observed_and_computed_displacements_by_survey(results: StudyResults) -> list[SurveyFallAndDisplacementFindings]:
    """Return, for each survey of a 3-D study, observed and computed falls, shifts and twists; [] for a 2-D study."""
    return [survey_displacement_findings(one) for one in results.survey_displacement_comparisons]


def survey_displacement_findings(stored_comparison: StoredDisplacementComparison) -> SurveyFallAndDisplacementFindings:
    """Return the report's numbers on falls, shifts and twists of the stones of a survey."""
    return SurveyFallAndDisplacementFindings(
        survey_file_name=stored_comparison.survey_file_name,
        sha256=stored_comparison.sha256,
        record=stored_comparison.record,
        survey_file_warnings=list(stored_comparison.survey_warnings),
        survey_file_comments=list(stored_comparison.survey_file_comments),
        all_sites=_site_displacement_findings("", stored_comparison.all_sites_comparison),
        sites=[_site_displacement_findings(site, one) for site, one in stored_comparison.comparisons_by_site],
        cemetery_soil_findings=soil_findings_of_survey_sites(stored_comparison.soil_by_site),
    )


def _site_displacement_findings(
    site_name: str, comparison: FallAndDisplacementComparison
) -> SiteFallAndDisplacementFindings:
    """Return the report's numbers on falls, shifts and twists of the stones at one site."""
    measures = []
    for one in comparison.compared_statistics:
        scale = 1 / CM if one.name == "shift_m" else 1.0
        observed, computed = (
            {
                end: scale * getattr(one, f"{kind}{suffix}")
                for end, suffix in (("value", ""), ("low", "_low"), ("high", "_high"))
            }
            for kind in ("observed", "computed")
        )
        measures.append(
            DisplacementMeasureFinding(
                share_or_median_name=one.name,
                observed_stone_count=one.observed_stone_count,
                observed=ObservedShareOrMedianWithInterval(**observed),
                computed=ShareOrMedianWithRangeOverFrictions(**computed),
            )
        )
    return SiteFallAndDisplacementFindings(
        site=site_name,
        fell=comparison.fell,
        stood=comparison.stood,
        matching_computed_cases=comparison.similar_computed_case_count,
        standing_stones_without_standing_simulation=comparison.standing_stones_without_standing_simulation,
        stones_without_computed_outcome=comparison.stones_without_computed_outcome,
        stones_far_outside_b_over_h_or_aspect_range=comparison.stones_far_outside_b_over_h_or_aspect_range,
        compared_shares_and_medians=measures,
        fall_direction_findings=None
        if comparison.fall_direction_comparison is None
        else _fall_direction_findings_in_3d(comparison, comparison.fall_direction_comparison),
    )


def _fall_direction_findings_in_3d(
    comparison: FallAndDisplacementComparison, fall_direction_comparison: FallDirectionComparisonIn3D
) -> FallDirectionFindingsIn3D:
    """Return the report's numbers on observed fall directions of stones and those computed in a 3-D study."""
    has_mean = fall_direction_comparison.predicted_resultant_length >= MIN_RESULTANT_WITH_MEAN_DIRECTION
    observed, predicted = (
        fall_direction_comparison.observed_count_by_octant.round(2).tolist(),
        fall_direction_comparison.predicted_count_by_octant.tolist(),
    )
    compared = fall_direction_comparison
    return FallDirectionFindingsIn3D(
        falls_in_known_direction=compared.fallen_in_known_direction,
        observed_mean_direction_deg=compared.observed_mean_direction_deg,
        observed_fall_direction_resultant_length=compared.observed_resultant_length,
        predicted_mean_direction_deg=compared.predicted_mean_direction_deg if has_mean else math.nan,
        predicted_fall_direction_resultant_length=compared.predicted_resultant_length,
        observed_falls_by_octant=dict(zip(OCTANTS, observed, strict=True)),
        predicted_falls_by_octant=dict(zip(OCTANTS, predicted, strict=True)),
        log_likelihood_ratio=compared.log_likelihood_ratio,
        likelihood_ratio_p_value_if_directions_random=compared.likelihood_ratio_p,
        known_direction_falls_without_any_computed_fall=compared.known_direction_falls_without_any_computed_fall,
        known_direction_falls_without_prediction=compared.known_direction_falls_without_computed_outcome,
        falls_with_predicted_direction=compared.fallen_in_known_direction
        - compared.known_direction_falls_without_any_computed_fall
        - compared.known_direction_falls_without_computed_outcome,
        has_no_stone_with_prediction=comparison.stones_far_outside_b_over_h_or_aspect_range
        == comparison.fell + comparison.stood,
        assumed_random_direction_share=compared.assumed_random_fall_direction_share,
    )
