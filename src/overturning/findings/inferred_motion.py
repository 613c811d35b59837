"""Motion inferred from a survey of fallen stones: intervals of strength and axis, and the likeliest motions."""

import math
from collections.abc import Sequence

from pydantic import Field

from overturning.findings.results import StudyResults
from overturning.findings.values import FindingBaseClass, OptionalNumberOrInfinity
from overturning.settings import StonePopulation
from overturning.surveys.inversion import DIRECTION_LIKELIHOOD_EXPONENT, MIN_FIT_P_VALUE
from overturning.surveys.posterior import CREDIBLE_INTERVAL_PROBABILITY, SurveyInversionResult
from overturning.surveys.stones import Stone
from overturning.units import CM


class IntensityCredibleIntervals(FindingBaseClass):
    """Credible intervals of an intensity measure without the survey (prior) and with it (posterior)."""

    measure: str
    """Intensity measure, such as PGV."""
    unit: str
    """Unit of the bounds."""
    posterior_low: OptionalNumberOrInfinity
    """Lower end of the interval after the survey."""
    posterior_high: OptionalNumberOrInfinity
    """Upper end of the interval after the survey."""
    prior_low: OptionalNumberOrInfinity
    """Lower end of the interval before the survey."""
    prior_high: OptionalNumberOrInfinity
    """Upper end of the interval before the survey."""


class CandidateMotionProbabilities(FindingBaseClass):
    """Candidate motion, and its probability without the survey (prior) and with it (posterior)."""

    motion_name: str
    posterior_probability: OptionalNumberOrInfinity
    prior_probability: OptionalNumberOrInfinity


class StoneHeightOrWidthRange(FindingBaseClass):
    """Range of the heights or widths of stones, m."""

    low_m: float
    high_m: float


class InferredMotionOfSite(FindingBaseClass):
    """Axis and strength of the ground motion inferred from the stones of one survey site alone."""

    site: str
    """Name of the site; empty for stones without one."""
    fell: int
    """Number of stones that fell."""
    stood: int
    """Number of stones that stood."""
    strengths: list[IntensityCredibleIntervals]
    """Interval of each intensity measure."""
    peak_velocity_axis_credible_arc_middle_deg: OptionalNumberOrInfinity
    """Middle of the credible arc of the axis of the largest velocity, 0 to 180."""
    velocity_axis_credible_arc_width_deg: OptionalNumberOrInfinity
    """Width of this arc."""
    velocity_axis_credible_arc_half_width_deg: OptionalNumberOrInfinity
    """Half of the width of this arc."""
    everything_fell: bool
    """True if every stone fell: then the site shows no axis."""
    fit_p_value: OptionalNumberOrInfinity
    """p-value of the posterior predictive check; small if no motion fits the stones of the site."""
    any_motion_fits: bool
    """False if the check rejects every motion."""


class InferredMotionOfSurvey(FindingBaseClass):
    """Axis and strength of the ground motion that are inferred from the fallen stones of a survey."""

    survey_file_name: str
    """Name of the survey file."""
    fell: int
    """Number of stones that fell."""
    stood: int
    """Number of stones that stood."""
    credible_interval_probability: float = CREDIBLE_INTERVAL_PROBABILITY
    """Probability of the credible intervals and of the arc."""
    peak_velocity_axis_credible_arc_middle_deg: OptionalNumberOrInfinity
    """Middle of the credible arc of the axis of the largest velocity, 0 to 180."""
    velocity_axis_credible_arc_width_deg: OptionalNumberOrInfinity
    """Width of the arc of the axis of the largest velocity."""
    strengths: list[IntensityCredibleIntervals]
    """Interval of each intensity measure."""
    everything_fell: bool
    """True if every stone fell: then the survey shows no axis."""
    velocity_axis_credible_arc_half_width_deg: OptionalNumberOrInfinity
    """Half of the width of the arc of the axis."""
    posterior_probability_of_strongest_pgv_level: float
    """Share of the probability on the strongest level of the motions."""
    posterior_probability_of_weakest_pgv_level: float
    """Share of the probability on the weakest level of the motions."""
    lowest_candidate_pgv_level_cm_s: float
    highest_candidate_pgv_level_cm_s: float
    assumed_fixed_stone_share: float
    """Share of stones taken to be fixed to their base."""
    fit_p_value: OptionalNumberOrInfinity
    """p-value of the posterior predictive check; small if no motion fits the survey."""
    any_motion_fits: bool
    """False if the check rejects every motion."""
    has_no_upper_strength_bound: bool
    """True if so much probability lies on the strongest level that no upper bound can be given."""
    has_no_lower_strength_bound: bool
    direction_likelihood_exponent: float
    """Power of the likelihood of directions (see docs/surveys.md)."""
    likeliest_motions: list[CandidateMotionProbabilities]
    """Motions with the largest probabilities, in descending order."""
    stones_without_height: int
    """Stones without a height, and those without B/H, of a survey whose stones are given; otherwise 0."""
    stones_without_b_over_h: int
    has_assumed_sizes: bool
    assumed_range_of_unknown_heights_m: StoneHeightOrWidthRange
    """Height of the stones without one, and width of those without B/H."""
    assumed_range_of_unknown_widths_m: StoneHeightOrWidthRange
    sites: list[InferredMotionOfSite] = Field(default_factory=list)
    """Motion inferred from each site by itself; empty if the survey has only one site."""


MAX_LISTED_MOTIONS = 12


def inferred_motions_of_all_surveys(results: StudyResults) -> list[InferredMotionOfSurvey]:
    """Return, for each survey of a study, the report's numbers on the inferred ground motion."""
    return [inferred_motion_findings(one) for one in results.inferred_motions]


def inferred_motion_findings(
    inversion_result: SurveyInversionResult, stones: Sequence[Stone] = ()
) -> InferredMotionOfSurvey:
    """Return the report's numbers on the ground motion that is inferred from a survey.

    `stones` are the stones of the survey, of which those without height or B/H are counted; empty if they are unknown.
    """
    one = inversion_result.posterior
    middle, width = inversion_result.credible_axis_arc_middle_and_width_deg
    weakest, strongest = (float(share) for share in one.probabilities_of_lowest_and_highest_pgv())
    high = sum(int(each.stone_count) for each in stones if math.isnan(each.height_m))
    wide = sum(int(each.stone_count) for each in stones if math.isnan(each.b_over_h_in_both_planes[0]))
    assumed = StonePopulation()
    shares, prior = one.posterior_probability_of_each_motion(), one.prior_probability.sum(axis=(1, 2))
    order = (-shares).argsort(kind="stable")[:MAX_LISTED_MOTIONS]
    return InferredMotionOfSurvey(
        survey_file_name=inversion_result.survey_or_site_name,
        fell=inversion_result.fell,
        stood=inversion_result.stood,
        peak_velocity_axis_credible_arc_middle_deg=middle,
        velocity_axis_credible_arc_width_deg=width,
        strengths=_prior_and_posterior_intensity_intervals(inversion_result),
        everything_fell=inversion_result.everything_fell,
        velocity_axis_credible_arc_half_width_deg=width / 2,
        posterior_probability_of_weakest_pgv_level=weakest,
        posterior_probability_of_strongest_pgv_level=strongest,
        has_no_lower_strength_bound=weakest > (1 - CREDIBLE_INTERVAL_PROBABILITY) / 2,
        has_no_upper_strength_bound=strongest > (1 - CREDIBLE_INTERVAL_PROBABILITY) / 2,
        direction_likelihood_exponent=DIRECTION_LIKELIHOOD_EXPONENT,
        lowest_candidate_pgv_level_cm_s=float(one.pgv_levels_m_s[0]) / CM,
        highest_candidate_pgv_level_cm_s=float(one.pgv_levels_m_s[-1]) / CM,
        assumed_fixed_stone_share=inversion_result.assumed_fixed_stone_share,
        fit_p_value=inversion_result.goodness_of_fit_p_value,
        any_motion_fits=not inversion_result.goodness_of_fit_p_value < MIN_FIT_P_VALUE,
        likeliest_motions=[
            CandidateMotionProbabilities(
                motion_name=one.motion_names[place],
                posterior_probability=float(shares[place]),
                prior_probability=float(prior[place]),
            )
            for place in order
        ],
        stones_without_height=int(high),
        stones_without_b_over_h=int(wide),
        has_assumed_sizes=bool(high or wide),
        assumed_range_of_unknown_heights_m=StoneHeightOrWidthRange(
            low_m=assumed.height.low, high_m=assumed.height.high
        ),
        assumed_range_of_unknown_widths_m=StoneHeightOrWidthRange(low_m=assumed.width.low, high_m=assumed.width.high),
        sites=[_inferred_motion_of_site(each) for each in inversion_result.site_results],
    )


def _prior_and_posterior_intensity_intervals(
    inversion_result: SurveyInversionResult,
) -> list[IntensityCredibleIntervals]:
    """Return the credible intervals of each intensity measure without (prior) and with the survey (posterior)."""
    one, strengths = inversion_result.posterior, []
    for name, values in inversion_result.pgv_and_pga_by_motion_and_level.items():
        (low, high), (least, most) = (
            one.credible_interval(values),
            one.credible_interval(values, uses_prior_instead_of_posterior=True),
        )
        strengths.append(
            IntensityCredibleIntervals(
                measure=name.split(", ")[0],
                unit=name.split(", ")[1],
                posterior_low=low,
                posterior_high=high,
                prior_low=least,
                prior_high=most,
            )
        )
    return strengths


def _inferred_motion_of_site(site_result: SurveyInversionResult) -> InferredMotionOfSite:
    """Return the report's numbers on the ground motion that is inferred from one site of a survey."""
    middle, width = site_result.credible_axis_arc_middle_and_width_deg
    return InferredMotionOfSite(
        site=site_result.survey_or_site_name,
        fell=site_result.fell,
        stood=site_result.stood,
        strengths=_prior_and_posterior_intensity_intervals(site_result),
        peak_velocity_axis_credible_arc_middle_deg=middle,
        velocity_axis_credible_arc_width_deg=width,
        velocity_axis_credible_arc_half_width_deg=width / 2,
        everything_fell=site_result.everything_fell,
        fit_p_value=site_result.goodness_of_fit_p_value,
        any_motion_fits=not site_result.goodness_of_fit_p_value < MIN_FIT_P_VALUE,
    )
