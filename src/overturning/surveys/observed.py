"""Summary of a survey by itself: numbers of stones by outcome, and directions of the observed falls."""

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from overturning.arrays import FloatArray
from overturning.statistics.circular import sector_index
from overturning.statistics.mean_direction import MeanDirectionWithInterval, mean_direction_with_interval
from overturning.surveys.counted_stones import fallen_and_all_stone_counts, stones_of_sites_with_standing_stones
from overturning.surveys.notation import OUTCOME_KINDS_NOT_COUNTED_AS_STANDING
from overturning.surveys.row import SurveyRow
from overturning.surveys.stones import Stone, SurveyTable


@dataclass(frozen=True)
class ObservedOutcomesAndFallDirections:
    """Numbers of stones by outcome, and directions of falls, at one survey site or all sites together.

    Attributes
    ----------
    site : str
        Name of the site; "" for stones without one, and for all sites together.
    fell, stands, standing_shifted_or_twisted : int
        Stones that fell; that stand; and, of the latter, that are shifted or twisted.
    uncounted_stones_by_reason : dict of str to int
        Stones that count neither as fallen nor as standing, by reason.
    fell_in_unknown_direction : int
        Fallen stones with unknown direction.
    fallen_count_at_sites_with_standing_stones, stone_count_at_sites_with_standing_stones : int
        Stones that fell, and stones that fell or stand, at the sites that list a standing stone; the share that fell is
        their ratio, and not known elsewhere.
    mean_fall_direction, mean_fall_axis : MeanDirectionWithInterval
        Mean direction and mean axis of the falls of known direction.
    falls_by_sector : ndarray, shape (8,) or (16,)
        Number of falls towards each sector of equal width; the first is centred on north.
    """

    site: str
    fell: int
    stands: int
    standing_shifted_or_twisted: int
    uncounted_stones_by_reason: dict[str, int]
    fell_in_unknown_direction: int
    fallen_count_at_sites_with_standing_stones: int
    stone_count_at_sites_with_standing_stones: int
    mean_fall_direction: MeanDirectionWithInterval
    mean_fall_axis: MeanDirectionWithInterval
    falls_by_sector: FloatArray


@dataclass(frozen=True)
class SurveySummary:
    """Summary of a survey: outcomes and fall directions of all stones together, and by site if there are several.

    ``outcomes_by_site`` is empty if there is only one site.

    ``distinct_magnetic_declinations_deg`` are the different magnetic declinations that were added to directions,
    ascending.
    """

    survey_file_name: str
    outcomes_at_all_sites: ObservedOutcomesAndFallDirections
    outcomes_by_site: tuple[ObservedOutcomesAndFallDirections, ...] = ()
    warnings: tuple[str, ...] = ()
    distinct_magnetic_declinations_deg: tuple[float, ...] = field(default=())


def summarise_survey(survey_table: SurveyTable) -> SurveySummary:
    """Summarise outcomes and fall directions of a survey's stones, for all together and by site."""
    sites = survey_table.site_names
    sector_count = rose_sector_count(survey_table.fallen_and_standing_stones)
    declinations = {
        row.magnetic_declination_deg
        for _, row in survey_table.rows
        if _row_has_fall_direction_or_face_azimuth(survey_table, row)
    }
    return SurveySummary(
        survey_table.survey_file_name,
        _summarise_observed_falls(survey_table, "", sector_count),
        tuple(
            _summarise_observed_falls(survey_table.select_site(site), site, sector_count)
            for site in sites
            if len(sites) > 1
        ),
        survey_table.warnings,
        tuple(sorted(declinations)),
    )


def rose_sector_count(stones: Sequence[Stone]) -> int:
    """Return the number of sectors for a rose diagram of falls: 8 if some directions are octants, otherwise 16."""
    return 8 if any(stone.has_octant_direction for stone in stones if stone.fell_in_known_direction) else 16


def fall_counts_by_rose_sector(stones: Sequence[Stone], number_of_rose_sectors: int) -> FloatArray:
    """Return the number of stones that fell towards each sector of a rose diagram, shape (sectors,).

    A direction given as one of 16 compass points is known to an interval; it is shared between the sectors that the
    interval overlaps.
    """
    counts = np.zeros(number_of_rose_sectors)
    fine = np.linspace(-1, 1, 401)[1::2]  # midpoints of equal parts of an interval
    for stone in stones:
        if stone.fell_in_known_direction:
            half = stone.direction_uncertainty_half_width_deg if stone.has_16_point_direction else 0.0
            towards = sector_index(stone.fall_azimuth_deg + half * fine, number_of_rose_sectors)
            counts += stone.stone_count * np.bincount(towards, minlength=number_of_rose_sectors) / fine.size
    return counts


def _row_has_fall_direction_or_face_azimuth(survey_table: SurveyTable, row: SurveyRow) -> bool:
    """True if a survey row has a fall direction or a face azimuth."""
    stone = survey_table.create_stone_from_row(0, row)
    return math.isfinite(stone.fall_azimuth_deg) or math.isfinite(stone.face_azimuth_deg)


def _summarise_observed_falls(
    survey_table: SurveyTable, site_name: str, number_of_rose_sectors: int
) -> ObservedOutcomesAndFallDirections:
    """Summarise outcomes and fall directions of all stones in a survey table.

    `site_name` is stored in the result: the site to which the table has been limited, or "" for all sites.
    """
    stones = survey_table.fallen_and_standing_stones
    reasons = Counter[str]()
    for _, row in survey_table.rows:
        if row.counted_as == "not counted":
            reasons[next(kind for kind in OUTCOME_KINDS_NOT_COUNTED_AS_STANDING if kind in row.stated_outcomes)] += (
                row.count
            )
    share_fell, share_stones = fallen_and_all_stone_counts(stones_of_sites_with_standing_stones(stones))
    directed = [stone for stone in stones if stone.fell_in_known_direction]
    angles, steps = (
        np.repeat([value(stone) for stone in directed], [stone.stone_count for stone in directed])
        for value in (lambda stone: stone.fall_azimuth_deg, lambda stone: stone.direction_recording_step_deg)
    )
    return ObservedOutcomesAndFallDirections(
        site=site_name,
        fell=sum(stone.stone_count for stone in stones if stone.fell),
        stands=sum(stone.stone_count for stone in stones if not stone.fell),
        standing_shifted_or_twisted=survey_table.count_stones(
            lambda row: row.counted_as == "stands" and bool({"shifted", "twisted"} & set(row.stated_outcomes))
        ),
        uncounted_stones_by_reason=dict(reasons),
        fell_in_unknown_direction=sum(
            stone.stone_count for stone in stones if stone.fell and not stone.fell_in_known_direction
        ),
        fallen_count_at_sites_with_standing_stones=share_fell,
        stone_count_at_sites_with_standing_stones=share_stones,
        mean_fall_direction=mean_direction_with_interval(angles, steps),
        mean_fall_axis=mean_direction_with_interval(angles, steps, axial=True),
        falls_by_sector=fall_counts_by_rose_sector(stones, number_of_rose_sectors),
    )
