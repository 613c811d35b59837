"""Findings on a survey by itself: stones by outcome, and directions of the observed falls."""

from pydantic import Field

from overturning.findings.values import FindingBaseClass, OptionalNumberOrInfinity
from overturning.statistics.bootstrap import exact_share_interval
from overturning.statistics.mean_direction import MeanDirectionWithInterval
from overturning.surveys.observed import ObservedOutcomesAndFallDirections, SurveySummary


class ObservedStoneShare(FindingBaseClass):
    """Share of the stones of a survey, such as those that fell, with its exact binomial interval (Clopper & Pearson).

    Stones are taken to fall independently of each other.
    """

    value: OptionalNumberOrInfinity
    """Share, 0 to 1."""
    low: OptionalNumberOrInfinity
    """Lower end of the interval."""
    high: OptionalNumberOrInfinity
    """Upper end of the interval."""
    level: float = 0.95
    """Probability of the interval."""


class MeanFallDirectionOrAxis(FindingBaseClass):
    """Mean direction or axis of observed falls, with its interval, and a test against random directions."""

    sample_size: int
    """Number of falls of known direction."""
    mean_deg: OptionalNumberOrInfinity
    """Mean, degrees clockwise from true north (axes: 0 to 180); None if the falls may well be in random directions."""
    interval_half_width_deg: OptionalNumberOrInfinity
    """Half the width of the interval of the mean; None for fewer than eight falls, or without mean."""
    mean_resultant_length: OptionalNumberOrInfinity
    """Mean resultant length, 0 to 1; for axes that of the doubled angles."""
    uniformity_p_value: OptionalNumberOrInfinity
    """Probability of a resultant at least as long if the stones fell in random directions."""
    level: float = 0.95
    """Probability of the interval."""


class ObservedFallsFinding(FindingBaseClass):
    """Numbers of stones by outcome, and directions of falls, at one survey site or at all sites together."""

    site: str
    """Name of the site; empty for stones without one, and for all sites together."""
    stones: int
    """Number of stones, also those that do not count."""
    fell: int
    """Number of stones that fell."""
    stands: int
    """Number of stones that stand, also shifted and twisted ones."""
    standing_shifted_or_twisted: int
    """Number of standing stones that are shifted or twisted."""
    not_counted: int
    """Number of stones that count neither as fallen nor as standing."""
    not_counted_by_reason: dict[str, int]
    """Number of stones that do not count by reason: fixed, repaired, broken, unknown."""
    fell_in_unknown_direction: int
    """Number of stones that fell in an unknown direction."""
    fell_share_of_counted: ObservedStoneShare | None
    """Share of the counted stones that fell; None if no standing stone is listed, and thus perhaps only the fallen.

    For all sites together only those sites count that list a standing stone.
    """
    stands_share_of_counted: ObservedStoneShare | None
    """Share of the counted stones that stand; None if no standing stone is listed."""
    not_counted_share: ObservedStoneShare
    """Share of all stones that do not count."""
    direction: MeanFallDirectionOrAxis
    """Mean direction of the falls, and test against no common direction."""
    axis: MeanFallDirectionOrAxis
    """Mean axis of the falls, and test against no common axis."""
    falls_by_sector: list[OptionalNumberOrInfinity]
    """Number of falls of known direction in each of 8 or 16 equal sectors, clockwise; the first is centred on north."""


class ObservedSurveyFindings(FindingBaseClass):
    """Summary of a survey, without comparison with a model: for all stones together, and by site."""

    survey_file_name: str
    """Name of the survey file."""
    doubts: list[str]
    """Doubts about the survey file, such as the unit of its azimuths."""
    smallest_magnetic_declination_deg: OptionalNumberOrInfinity
    """Smallest magnetic declination that was added to a direction, east positive; None without directions."""
    largest_magnetic_declination_deg: OptionalNumberOrInfinity
    """Largest magnetic declination that was added to a direction."""
    all_sites: ObservedFallsFinding
    """All sites together."""
    sites: list[ObservedFallsFinding] = Field(default_factory=list)
    """Each site by itself; empty if the survey has only one."""
    sites_with_fallen_stones_only: list[str] = Field(default_factory=list)
    """Sites that list fallen stones only, while other sites list standing ones."""


def observed_survey_findings(survey_summary: SurveySummary) -> ObservedSurveyFindings:
    """Return the report's numbers on a survey by itself: outcomes and fall directions, together and by site."""
    declinations = survey_summary.distinct_magnetic_declinations_deg or (None,)
    return ObservedSurveyFindings(
        survey_file_name=survey_summary.survey_file_name,
        doubts=list(survey_summary.warnings),
        smallest_magnetic_declination_deg=declinations[0],
        largest_magnetic_declination_deg=declinations[-1],
        all_sites=_observed_falls_finding(survey_summary.outcomes_at_all_sites),
        sites=[_observed_falls_finding(site) for site in survey_summary.outcomes_by_site],
        sites_with_fallen_stones_only=[
            one.site
            for one in survey_summary.outcomes_by_site
            if one.fell and not one.stands and survey_summary.outcomes_at_all_sites.stands
        ],
    )


def observed_stone_share_with_interval(matching_stone_count: int, stone_count: int) -> ObservedStoneShare:
    """Return the share `matching_stone_count`/`stone_count`, None without stones, with its exact 95 % interval."""
    low, high = exact_share_interval(matching_stone_count, stone_count)
    return ObservedStoneShare(value=matching_stone_count / stone_count if stone_count else None, low=low, high=high)


def _observed_falls_finding(observed_falls: ObservedOutcomesAndFallDirections) -> ObservedFallsFinding:
    """Return the report's numbers on one survey site: stones by outcome, and directions of the falls."""
    counted, not_counted = (
        observed_falls.fell + observed_falls.stands,
        sum(observed_falls.uncounted_stones_by_reason.values()),
    )

    return ObservedFallsFinding(
        site=observed_falls.site,
        stones=counted + not_counted,
        fell=observed_falls.fell,
        stands=observed_falls.stands,
        standing_shifted_or_twisted=observed_falls.standing_shifted_or_twisted,
        not_counted=not_counted,
        not_counted_by_reason=observed_falls.uncounted_stones_by_reason,
        fell_in_unknown_direction=observed_falls.fell_in_unknown_direction,
        fell_share_of_counted=observed_stone_share_with_interval(
            observed_falls.fallen_count_at_sites_with_standing_stones,
            observed_falls.stone_count_at_sites_with_standing_stones,
        )
        if observed_falls.stone_count_at_sites_with_standing_stones
        else None,
        stands_share_of_counted=(
            observed_stone_share_with_interval(
                observed_falls.stone_count_at_sites_with_standing_stones
                - observed_falls.fallen_count_at_sites_with_standing_stones,
                observed_falls.stone_count_at_sites_with_standing_stones,
            )
            if observed_falls.stone_count_at_sites_with_standing_stones
            else None
        ),
        not_counted_share=observed_stone_share_with_interval(not_counted, counted + not_counted),
        direction=_finding_from_mean_fall_direction(observed_falls.mean_fall_direction),
        axis=_finding_from_mean_fall_direction(observed_falls.mean_fall_axis),
        falls_by_sector=observed_falls.falls_by_sector.tolist(),
    )


def _finding_from_mean_fall_direction(mean_direction: MeanDirectionWithInterval) -> MeanFallDirectionOrAxis:
    """Return the report's numbers on a mean fall direction or axis: angle, interval, resultant and p-value."""
    return MeanFallDirectionOrAxis(
        sample_size=mean_direction.observation_count,
        mean_deg=mean_direction.significant_mean_deg,
        interval_half_width_deg=mean_direction.interval_half_width_deg,
        mean_resultant_length=mean_direction.mean_resultant_length,
        uniformity_p_value=mean_direction.test_of_no_common_direction.p_value,
    )
