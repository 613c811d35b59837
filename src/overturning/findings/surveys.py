"""Surveys of fallen stones: comparison with the prediction, and inferred motion."""

import math
from collections.abc import Sequence

from pydantic import Field

from overturning.findings.observed import ObservedStoneShare, observed_stone_share_with_interval
from overturning.findings.results import StudyResults
from overturning.findings.values import FindingBaseClass, OptionalNumberOrInfinity
from overturning.statistics.circular import MIN_RESULTANT_WITH_MEAN_DIRECTION
from overturning.surveys.comparison import SurveyPredictionComparison
from overturning.surveys.ground import SoilBelowSurveySite
from overturning.surveys.prediction import STANDING_OR_FALL_SIDES
from overturning.surveys.stones import OCTANTS
from overturning.surveys.stored_comparison import StoredSurveyComparison
from overturning.units import STANDARD_GRAVITY


class StatisticalTestFinding(FindingBaseClass):
    """Name, sample size, statistic and p-value of a statistical test on a survey."""

    name: str
    """Name of the test."""
    sample_size: int
    """Number of stones."""
    statistic: OptionalNumberOrInfinity
    """Test statistic."""
    p_value: OptionalNumberOrInfinity
    """p-value."""


class FallShareWithRangeOverHeightsAndFrictions(FindingBaseClass):
    """Computed share of a survey's stones that fall: mean and range over heights and frictions.

    These are the heights and friction coefficients for which the study has simulated blocks.
    """

    value: OptionalNumberOrInfinity
    """Mean over the grid; None if no outcome is known."""
    low: OptionalNumberOrInfinity
    """Smallest share of a height and friction; None if the share is the same for all of them."""
    high: OptionalNumberOrInfinity
    """Largest share of a height and friction; None if the share is the same for all of them."""


class SurveySiteSoilAmplification(FindingBaseClass):
    """Soil layers below a survey site, and the PGA of the record on rock and at the soil surface."""

    site: str
    """Name of the site; empty for all sites of the survey that have no layers of their own."""
    soil_thickness_m: OptionalNumberOrInfinity
    """Thickness of all layers, m."""
    mean_shear_wave_velocity_m_s: OptionalNumberOrInfinity
    """Mean shear-wave velocity of the layers: thickness over travel time, m/s."""
    has_equivalent_linear_layer: bool
    """True if a layer softens with strain."""
    equivalent_linear_iteration_converged: bool
    """False if the equivalent-linear computation did not converge."""
    strain_exceeds_curve: bool
    """True if the effective strain of a layer exceeds the largest strain of its curve."""
    rock_pga_g: OptionalNumberOrInfinity
    """Peak acceleration of the larger horizontal component of the record, g."""
    surface_pga_g: OptionalNumberOrInfinity
    """Peak acceleration of the larger horizontal component at the surface, g."""


class SurveySitePredictionFindings(FindingBaseClass):
    """Comparison of the observed falls at one site of a survey with the predicted falls."""

    site: str
    """Name of the site; empty for stones without one."""
    fell: int
    """Number of stones that fell."""
    stood: int
    """Number of stones that stood."""
    falls_in_known_direction: int
    """Number of falls whose direction is known."""
    observed_fall_share: ObservedStoneShare | None
    """Share of the stones that fell; None if no stone that stood is listed."""
    computed_fall_share: FallShareWithRangeOverHeightsAndFrictions
    """Share computed for the stones of the site under the record of the survey."""
    log_likelihood_ratio: OptionalNumberOrInfinity
    """Sum over fallen stones of ln(predicted/uniform); above 0 if the prediction is better than random directions."""
    likelihood_ratio_p_value_if_directions_random: OptionalNumberOrInfinity
    """Share of surveys of stones that fall in random directions with a ratio at least as large."""


class SurveyPredictionFindings(FindingBaseClass):
    """Comparison of the observed falls of a survey with the falls predicted for its site."""

    survey_file_name: str
    """Name of the survey file."""
    sha256: str
    """SHA-256 hash of the survey file."""
    record: str
    """Record for whose site the prediction is made."""
    survey_file_warnings: list[str]
    """Doubts about the survey file, such as the unit of its azimuths."""
    survey_file_comments: list[str]
    """Comment lines at the start of the survey file that are not empty."""
    fell: int
    """Number of stones that fell."""
    stood: int
    """Number of stones that stood."""
    fell_in_unknown_direction: int
    """Number of stones that fell in an unknown direction."""
    falls_in_known_direction: int
    """Number of falls whose direction is known."""
    has_few_falls_in_known_direction: bool
    """True if some falls have a known direction, but fewer than 40, five to an octant."""
    observed_mean_direction_deg: OptionalNumberOrInfinity
    """Mean fall direction; None if the falls show no common direction (p > 0.05)."""
    observed_fall_direction_resultant_length: OptionalNumberOrInfinity
    """Length of the mean of the fall directions as unit vectors, 0 to 1."""
    predicted_mean_direction_deg: OptionalNumberOrInfinity
    """Mean of the predicted directions of the stones that fell; None if they have no common direction."""
    predicted_fall_direction_resultant_length: OptionalNumberOrInfinity
    """Length of the mean of the predicted directions as unit vectors, 0 to 1."""
    observed_fall_share: ObservedStoneShare | None
    """Share of the stones that fell; None if the survey lists no stone that stood, and thus perhaps only the fallen.

    Only those sites count that list a stone that stood.
    """
    sites_with_fallen_stones_only: list[str] = Field(default_factory=list)
    """Sites that list fallen stones only, while other sites list standing ones."""
    computed_fall_share: FallShareWithRangeOverHeightsAndFrictions
    """Share computed for the survey's stones under the record.

    A stone counts with its face, B/H and height, as far as the survey gives them (outside the grid: the nearest grid
    values). A stone without B/H has the mean over all B/H of the grid, one without height the mean over all heights,
    and one without face the mean over all azimuths. `assumed_random_direction_share` is not included.
    """
    observed_falls_by_octant: dict[str, OptionalNumberOrInfinity]
    """Number of fallen stones in each octant of fall direction; a direction between two (NNE) counts in both."""
    predicted_falls_by_octant: dict[str, OptionalNumberOrInfinity]
    """Predicted number of fallen stones in each octant."""
    log_likelihood_ratio: OptionalNumberOrInfinity
    """Sum over fallen stones of ln(predicted/uniform); above 0 if the prediction is better than a guess."""
    likelihood_ratio_p_value_if_directions_random: OptionalNumberOrInfinity
    """Share of surveys of stones that fall in random directions with a ratio at least as large."""
    goodness_of_fit_tests: list[StatisticalTestFinding]
    """Tests of the agreement of observed and predicted directions."""
    uniformity_test: StatisticalTestFinding
    """Test of a uniform distribution of the observed directions."""
    stones_with_correct_most_probable_outcome: int | None
    """Number of `stones_with_checked_most_probable_outcome` in which the stone did what was most probable."""
    stones_with_checked_most_probable_outcome: int | None
    """Number of stones of known face and B/H with a computed outcome; None if there are none."""
    predicted_side_counts_by_observed_side: dict[str, list[int]]
    """Stones of known face by the side to which they fell: their most probable sides, in the same order."""
    has_falls_with_known_face_and_b_over_h: bool
    """True if the directions of some falls are predicted edge by edge only."""
    known_direction_falls_without_face_or_b_over_h: int
    """Falls without face azimuth or B/H, for which all orientations are assumed."""
    known_direction_falls_without_any_computed_fall: int
    """Falls of stones like which none falls in the study; their predicted direction is random."""
    stones_without_computed_outcome: int
    """Stones without a computed outcome, although no B/H of theirs lies more than a quarter outside the grid.

    They do not count in `computed_fall_share` and `stones_with_checked_most_probable_outcome`.
    """
    known_direction_falls_without_computed_outcome: int
    """Stones of `stones_without_computed_outcome` that fell in a known direction, which is predicted at random."""
    known_direction_falls_without_prediction: int
    """Stones without a computed outcome, or without a prediction, that fell in a known direction."""
    falls_with_predicted_direction: int
    """Number of `falls_in_known_direction` whose predicted direction is not random: such a stone falls in the study."""
    known_direction_falls_without_face_azimuth: int
    """Number of stones without a face azimuth that fell in a known direction."""
    known_direction_falls_without_b_over_h: int
    """Number of stones without a B/H that fell in a known direction."""
    stones_with_b_over_h_slightly_outside_grid: int
    """Number of stones with a B/H outside the grid, which take its nearest value."""
    stones_with_b_over_h_far_outside_grid: int
    """Number of stones without a prediction, because a B/H lies more than a quarter outside the grid."""
    has_no_stone_with_prediction: bool
    """True if no stone of the survey has a prediction."""
    stones_with_height_outside_grid: int
    """Number of stones with a height outside the grid; their `computed_fall_share` is that of its nearest height."""
    assumed_random_direction_share: float
    """Assumed share of the stones that fall in a random direction."""
    sites: list[SurveySitePredictionFindings] = Field(default_factory=list)
    """Comparison for each site by itself, with the same record; empty if the survey has only one site."""
    cemetery_soil_findings: list[SurveySiteSoilAmplification] = Field(default_factory=list)
    """Soil below the cemeteries; empty if the record is used as it is for all stones."""


SMALL_SURVEY_FALL_THRESHOLD = 5 * len(OCTANTS)
"""Falls of known direction below which the report calls a survey small: a chi-square test over octants expects five."""


def observed_and_predicted_falls_by_survey(results: StudyResults) -> list[SurveyPredictionFindings]:
    """Return, for each survey of a study, the comparison of observed and predicted falls."""
    return [survey_prediction_findings(one) for one in results.survey_comparisons]


def survey_prediction_findings(stored_survey_comparison: StoredSurveyComparison) -> SurveyPredictionFindings:
    """Return the report's numbers on one survey: its comparison with the falls predicted for its site."""
    found, confusion = stored_survey_comparison.comparison, stored_survey_comparison.comparison.confusion_matrix

    def stone_counts_by_octant(stone_counts_in_octant_order: list[float]) -> dict[str, OptionalNumberOrInfinity]:
        """Return numbers of stones by name of the compass octant, given in the order of `OCTANTS`."""
        return dict(zip(OCTANTS, stone_counts_in_octant_order, strict=True))

    def statistical_test_finding(test_attribute_of_comparison: str) -> StatisticalTestFinding:
        """Return statistic and p-value of a test, given its attribute name in the comparison of survey and study."""
        one = getattr(found, test_attribute_of_comparison)
        return StatisticalTestFinding(name=one.name, sample_size=one.n, statistic=one.statistic, p_value=one.p_value)

    return SurveyPredictionFindings(
        survey_file_name=stored_survey_comparison.survey_file_name,
        sha256=stored_survey_comparison.sha256,
        record=stored_survey_comparison.record,
        survey_file_warnings=list(stored_survey_comparison.survey_warnings),
        survey_file_comments=list(stored_survey_comparison.survey_file_comments),
        fell=found.fallen,
        stood=found.stood,
        fell_in_unknown_direction=found.falls_without_direction,
        falls_in_known_direction=found.fallen_count_in_known_direction,
        has_few_falls_in_known_direction=0 < found.fallen_count_in_known_direction < SMALL_SURVEY_FALL_THRESHOLD,
        observed_mean_direction_deg=found.observed_mean_direction_deg,
        observed_fall_direction_resultant_length=found.observed_resultant_length,
        predicted_mean_direction_deg=(
            found.predicted_mean_direction_deg
            if found.predicted_resultant_length >= MIN_RESULTANT_WITH_MEAN_DIRECTION
            else math.nan
        ),
        predicted_fall_direction_resultant_length=found.predicted_resultant_length,
        observed_fall_share=observed_stone_share_with_interval(
            found.fallen_count_at_sites_with_standing_stones, found.stone_count_at_sites_with_standing_stones
        )
        if found.stone_count_at_sites_with_standing_stones
        else None,
        computed_fall_share=FallShareWithRangeOverHeightsAndFrictions(
            value=found.computed_fall_share,
            low=found.lowest_computed_fall_share,
            high=found.highest_computed_fall_share,
        ),
        observed_falls_by_octant=stone_counts_by_octant(found.observed_count_by_octant.round(2).tolist()),
        predicted_falls_by_octant=stone_counts_by_octant(found.predicted_count_by_octant.tolist()),
        log_likelihood_ratio=found.log_likelihood_ratio,
        likelihood_ratio_p_value_if_directions_random=found.likelihood_ratio_p,
        goodness_of_fit_tests=[
            statistical_test_finding(name)
            for name in ("octant_chi_square_test", "octant_watson_u2_test", "exact_azimuth_watson_u2_test")
        ],
        uniformity_test=statistical_test_finding("octant_uniformity_test"),
        stones_with_correct_most_probable_outcome=None if confusion is None else int(confusion.trace()),
        stones_with_checked_most_probable_outcome=None if confusion is None else int(confusion.sum()),
        predicted_side_counts_by_observed_side={}
        if confusion is None
        else dict(zip(STANDING_OR_FALL_SIDES, confusion.tolist(), strict=True)),
        has_falls_with_known_face_and_b_over_h=found.known_direction_falls_without_face_or_b_over_h
        < found.fallen_count_in_known_direction,
        known_direction_falls_without_face_or_b_over_h=found.known_direction_falls_without_face_or_b_over_h,
        known_direction_falls_without_any_computed_fall=found.known_direction_falls_without_any_computed_fall,
        stones_without_computed_outcome=found.stones_without_computed_outcome,
        known_direction_falls_without_computed_outcome=found.known_direction_falls_without_computed_outcome,
        known_direction_falls_without_prediction=found.known_direction_falls_without_prediction,
        falls_with_predicted_direction=found.fallen_count_in_known_direction
        - found.known_direction_falls_without_any_computed_fall
        - found.known_direction_falls_without_prediction,
        known_direction_falls_without_face_azimuth=found.known_direction_falls_without_face_azimuth,
        known_direction_falls_without_b_over_h=found.known_direction_falls_without_b_over_h,
        stones_with_b_over_h_slightly_outside_grid=found.stones_outside_b_over_h_grid
        - found.stones_far_outside_b_over_h_grid,
        stones_with_b_over_h_far_outside_grid=found.stones_far_outside_b_over_h_grid,
        has_no_stone_with_prediction=found.stones_far_outside_b_over_h_grid == found.fallen + found.stood,
        stones_with_height_outside_grid=found.stones_outside_height_grid,
        assumed_random_direction_share=found.assumed_random_fall_direction_share,
        sites=[_site_prediction_findings(site, one) for site, one in stored_survey_comparison.comparisons_by_site],
        sites_with_fallen_stones_only=[
            site
            for site, one in stored_survey_comparison.comparisons_by_site
            if one.fallen and not one.stood and found.stood
        ],
        cemetery_soil_findings=soil_findings_of_survey_sites(stored_survey_comparison.soil_by_site),
    )


def soil_findings_of_survey_sites(
    site_names_and_soils: Sequence[tuple[str, SoilBelowSurveySite]],
) -> list[SurveySiteSoilAmplification]:
    """Return the report's numbers on the soil layers below the sites of a survey."""
    return [
        SurveySiteSoilAmplification(
            site=site,
            soil_thickness_m=ground.thickness_m,
            mean_shear_wave_velocity_m_s=ground.mean_shear_wave_velocity_m_s,
            has_equivalent_linear_layer=ground.equivalent_linear,
            equivalent_linear_iteration_converged=ground.converged,
            strain_exceeds_curve=ground.strain_exceeds_soil_curve,
            rock_pga_g=ground.rock_pga / STANDARD_GRAVITY,
            surface_pga_g=ground.surface_pga / STANDARD_GRAVITY,
        )
        for site, ground in site_names_and_soils
    ]


def _site_prediction_findings(site_name: str, comparison: SurveyPredictionComparison) -> SurveySitePredictionFindings:
    """Return the report's numbers on one site of a survey: its observed and predicted falls."""
    return SurveySitePredictionFindings(
        site=site_name,
        fell=comparison.fallen,
        stood=comparison.stood,
        falls_in_known_direction=comparison.fallen_count_in_known_direction,
        observed_fall_share=observed_stone_share_with_interval(
            comparison.fallen_count_at_sites_with_standing_stones, comparison.stone_count_at_sites_with_standing_stones
        )
        if comparison.stone_count_at_sites_with_standing_stones
        else None,
        computed_fall_share=FallShareWithRangeOverHeightsAndFrictions(
            value=comparison.computed_fall_share,
            low=comparison.lowest_computed_fall_share,
            high=comparison.highest_computed_fall_share,
        ),
        log_likelihood_ratio=comparison.log_likelihood_ratio,
        likelihood_ratio_p_value_if_directions_random=comparison.likelihood_ratio_p,
    )
