"""Results of the comparison of falls, shifts and twists of surveyed stones with a 3-D study."""

from dataclasses import dataclass
from typing import Literal

from overturning.stored import StoredFloatOrNan
from overturning.surveys.directions_in_space import FallDirectionComparisonIn3D
from overturning.surveys.ground import SoilBelowSurveySite

ComparedStatisticName = Literal["fell", "shifted", "twisted", "clockwise", "shift_m", "twist_deg"]
"""Share of the stones that fell; of the standing ones that are shifted, and twisted; of the twisted ones that are
twisted clockwise; median shift of the shifted, m; median absolute twist of the twisted, degrees."""


@dataclass(frozen=True)
class ObservedAndComputedStatistic:
    """Observed and computed value of one statistic, such as the share of stones that fell or the median shift.

    Attributes
    ----------
    name : ComparedStatisticName
        Name of the statistic.
    observed_stone_count : int
        Number of observed stones of the share or median.
    observed, observed_low, observed_high : float
        Observed value and its exact 95 % interval. All are NaN without stones; the interval of a median also for fewer
        than six stones.
    computed, computed_low, computed_high : float
        Computed value, and its range over the frictions of the study. All are NaN if no computed case counts for the
        share or median; the range also for a study with one friction.
    """

    name: ComparedStatisticName
    observed_stone_count: int
    observed: StoredFloatOrNan
    observed_low: StoredFloatOrNan
    observed_high: StoredFloatOrNan
    computed: StoredFloatOrNan
    computed_low: StoredFloatOrNan
    computed_high: StoredFloatOrNan


@dataclass(frozen=True)
class FallAndDisplacementComparison:
    """Comparison of the observed falls, shifts and twists of stones with the computed ones.

    Attributes
    ----------
    fell, stood : int
        Number of stones.
    similar_computed_case_count : int
        Number of different computed cases that resemble the stones.
    standing_stones_without_standing_simulation : int
        Standing stones for which no similar computed stone stands; their displacements are not compared.
    stones_without_computed_outcome : int
        Stones for which no similar computed case has an outcome; they are not compared with computed values.
    stones_far_outside_b_over_h_or_aspect_range : int
        Stones whose B/H or D/B lies far outside the grid of the study (`has_shape_far_outside_grid`); they are not
        compared with computed values either, and do not count in `stones_without_computed_outcome`.
    compared_statistics : tuple of ObservedAndComputedStatistic
        Statistics in a fixed order.
    fall_direction_comparison : FallDirectionComparisonIn3D or None
        Observed and computed fall directions; None if no stone fell in a known direction.
    """

    fell: int
    stood: int
    similar_computed_case_count: int
    standing_stones_without_standing_simulation: int
    compared_statistics: tuple[ObservedAndComputedStatistic, ...]
    stones_without_computed_outcome: int = 0
    stones_far_outside_b_over_h_or_aspect_range: int = 0
    fall_direction_comparison: FallDirectionComparisonIn3D | None = None


@dataclass(frozen=True)
class StoredDisplacementComparison:
    """Content of a result file: displacements of the stones of a survey compared with those of a 3-D study.

    The comparison is made for all sites together (``all_sites_comparison``) and for each site
    (``comparisons_by_site``). The other fields are those of
    `overturning.surveys.stored_comparison.StoredSurveyComparison`.
    """

    survey_file_name: str
    sha256: str
    record: str
    all_sites_comparison: FallAndDisplacementComparison
    survey_warnings: tuple[str, ...] = ()
    survey_file_comments: tuple[str, ...] = ()
    comparisons_by_site: tuple[tuple[str, FallAndDisplacementComparison], ...] = ()
    soil_by_site: tuple[tuple[str, SoilBelowSurveySite], ...] = ()
