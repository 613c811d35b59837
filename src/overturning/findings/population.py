"""Share of a population of stones that falls, by record, amplitude and intensity."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.findings.results import StudyResults
from overturning.findings.values import FindingBaseClass, OptionalNumberOrInfinity
from overturning.motion.jma_intensity import (
    ASSUMED_JMA_INTENSITY_ADDED_BY_VERTICAL_MOTION,
    JMA_DEGREE_RANGES_BY_OVERTURNED_FRACTION,
    is_published_intensity_in_range,
    round_and_truncate_to_published_intensity,
)
from overturning.statistics.bootstrap import ConfidenceInterval, bootstrap_interval, exact_interval_if_all_0_or_all_1
from overturning.study.scenes import NAME_OF_STUDY_ITSELF_AMONG_VARIANTS
from overturning.surveys.population import jma_intensities_of_scaled_motions

JMA_DEGREES_WITH_INTENSITY_RANGES: Final = (
    ("5 upper", 5.0, 5.5),
    ("6 lower", 5.5, 6.0),
    ("6 upper", 6.0, 6.5),
    ("7", 6.5, math.inf),
)
"""Degrees of the JMA scale, with their range of instrumental intensity."""

MIN_MOTIONS_FOR_FALL_RATE: Final = 3
"""Smallest number of motions for which the fall rate at an intensity is reported."""

BoolArray = NDArray[np.bool_]
StrArray = NDArray[np.str_]


class MotionRecordAndEarthquakeCounts(FindingBaseClass):
    """Number of motions (each a record times an amplitude factor), and of their records and earthquakes."""

    motions: int
    """Number of motions."""
    records: int
    """Number of their records."""
    earthquakes: int
    """Number of their earthquakes."""


class ShareOfMotionsWithInterval(FindingBaseClass):
    """Share of motions, such as those with the intensity inferred from falls, with 95 % interval over earthquakes."""

    value: OptionalNumberOrInfinity
    """Share."""
    low: OptionalNumberOrInfinity
    """Lower end of the interval."""
    high: OptionalNumberOrInfinity
    """Upper end of the interval."""


class MedianFallRateAtJmaDegree(FindingBaseClass):
    """Median share of stones that fall, over the motions of one degree of the JMA intensity scale."""

    jma_degree: str
    """Degree of the JMA intensity scale, such as "6 lower"."""
    median_fall_rate: OptionalNumberOrInfinity
    """Median over motions of the share of the stones that fall."""
    count: MotionRecordAndEarthquakeCounts
    """Number of motions of this degree."""


class JmaIntensityFromFallShareRuleCheck(FindingBaseClass):
    """Check of one published rule that infers the JMA intensity from the share of stones that fell."""

    rule_fall_rate_lower_limit: float
    """Lower end of the share of the stones that fall."""
    rule_fall_rate_upper_limit: OptionalNumberOrInfinity
    """Upper end of the share of the stones that fall; infinite if the rule has no upper end."""
    inferred_jma_degree: str
    """Degree of the JMA scale that the rule infers."""
    median_jma_intensity_in_fall_rate_range: OptionalNumberOrInfinity
    """Median of the instrumental intensity of these motions."""
    count: MotionRecordAndEarthquakeCounts
    """Number of motions with such a share."""
    share_with_intensity_of_inferred_degree: ShareOfMotionsWithInterval
    """Share of these motions whose intensity is of the inferred degree."""
    share_with_intensity_above_inferred_degree: ShareOfMotionsWithInterval | None
    """Share with a higher intensity; None for the highest degree."""
    share_of_inferred_degree_with_vertical_increment: ShareOfMotionsWithInterval | None
    """Share that agrees if `assumed_jma_intensity_added_by_vertical_motion` is added for a missing vertical
    component."""


class FragilityCurve(FindingBaseClass):
    """Lognormal fragility curve of a class of stones for one intensity measure.

    A median, or an end of its interval, above (below) the intensities of the data is given as `inf` (0).
    """

    stone_class: str
    """Name of the class of stones."""
    measure: str
    """Intensity measure."""
    unit: str
    """Unit of the intensity measure."""
    median: OptionalNumberOrInfinity
    """Intensity at which half of the stones fall."""
    low: OptionalNumberOrInfinity
    """Lower end of the 95 % interval of the median."""
    high: OptionalNumberOrInfinity
    """Upper end of the 95 % interval of the median."""
    log_std: OptionalNumberOrInfinity
    """Standard deviation of the logarithm of the intensity at which a stone falls."""
    log_std_between_records: OptionalNumberOrInfinity
    """Part of `log_std` between records; the squares of both parts add up."""
    log_std_within_record: OptionalNumberOrInfinity
    """Part of `log_std` between stones and their orientations under one record."""
    data_minimum: float
    """Smallest intensity in the data."""
    data_maximum: float
    """Largest intensity in the data."""


class PopulationFallRateUnderRecord(FindingBaseClass):
    """Share of the stone population that falls under one record at its recorded amplitude, with its interval.

    The interval (Wilson) is that of a sample with as many stones as the population.
    """

    record: str
    """Identifier of the record."""
    fall_rate: OptionalNumberOrInfinity
    """Share of the stones that fall."""
    low: OptionalNumberOrInfinity
    """Lower end of the interval."""
    high: OptionalNumberOrInfinity
    """Upper end of the interval."""
    shifted_standing_share_of_all_stones: OptionalNumberOrInfinity
    """Share of the stones that stand shifted; None for planar models."""
    rotated_standing_share_of_all_stones: OptionalNumberOrInfinity
    """Share of the stones that stand rotated; None for planar models."""
    most_frequent_fall_octant_deg: OptionalNumberOrInfinity
    """Centre of the octant towards which most stones fall; None without falls."""
    share_falling_towards_most_frequent_octant: OptionalNumberOrInfinity
    """Share of the stones that fall towards this octant."""


class StonePopulationFindings(FindingBaseClass):
    """Shares of a random stone population that fall under the records of a study, and its fragility curves."""

    stones: int
    """Number of stones of the population."""
    share_fixed: float = 0.0
    """Share of the stones that are fixed to their base and do not fall; shares of the stones count them."""
    share_outside_grid: OptionalNumberOrInfinity
    """Share of the stones outside the grid of the study, which take the outcome of its nearest block."""
    mean_share_of_stones_without_outcome: OptionalNumberOrInfinity
    """Mean share of the stones without an outcome."""
    max_share_of_stones_without_outcome: OptionalNumberOrInfinity
    """Largest share of the stones without an outcome under one record."""
    max_share_of_stones_without_outcome_at_any_factor: OptionalNumberOrInfinity = 0.0
    """The same over all amplitude factors of the records."""
    median_shifted_standing_share_of_all_stones: OptionalNumberOrInfinity
    """Median share of the stones that stand shifted; None for planar models."""
    median_rotated_standing_share_of_all_stones: OptionalNumberOrInfinity
    """Median share of the stones that stand rotated; None for planar models."""
    median_fall_rate: OptionalNumberOrInfinity
    """Median over records (amplitude 1) of the share of the stones that fall."""
    lower_quartile_of_fall_rate_over_records: OptionalNumberOrInfinity
    """First quartile over records of the share of the stones that fall."""
    upper_quartile_of_fall_rate_over_records: OptionalNumberOrInfinity
    """Third quartile over records of the share of the stones that fall."""
    smallest_fall_rate: OptionalNumberOrInfinity
    """Smallest share of the stones that fall under a record."""
    largest_fall_rate: OptionalNumberOrInfinity
    """Largest share of the stones that fall under a record."""
    by_record: list[PopulationFallRateUnderRecord]
    """Fall rate under each record."""
    records_without_vertical_motion: int
    """Number of records without a vertical component."""
    assumed_jma_intensity_added_by_vertical_motion: float = ASSUMED_JMA_INTENSITY_ADDED_BY_VERTICAL_MOTION
    """Instrumental intensity that a vertical component usually adds."""
    median_fall_rate_by_jma_degree: list[MedianFallRateAtJmaDegree]
    """Fall rate for each degree of the JMA scale."""
    checks_of_jma_intensity_rules: list[JmaIntensityFromFallShareRuleCheck]
    """Check of each rule that infers an intensity from the share of the stones not fixed to their base that fall."""
    fragility_curves: list[FragilityCurve]
    """Lognormal fragility curves of the stones that are not fixed to their base."""


def population_findings(results: StudyResults) -> StonePopulationFindings | None:
    """Compute the shares of a stone population that fall, and fragility curves; None without a population."""
    stones = results.study.population
    if stones is None:
        return None
    found = results.population_rates_by_variant[NAME_OF_STUDY_ITSELF_AMONG_VARIANTS]
    own, jma = found.sel(amplitude=1.0), jma_intensities_of_scaled_motions(found, results.intensity_measures)
    horizontal = results.intensity_measures["jma_intensity"].isnull().to_numpy()
    rate = own["fall_rate"].dropna("record").to_numpy()
    quantiles = np.quantile(rate, [0.0, 0.25, 0.5, 0.75, 1.0]).tolist() if rate.size else [math.nan] * 5
    rates, free_rates = found["fall_rate"].to_numpy(), found["free_fall_rate"].to_numpy()
    events = found["event"].to_numpy().astype(str)
    known = np.isfinite(jma) & np.isfinite(rates)
    return StonePopulationFindings(
        stones=stones.stones,
        share_fixed=stones.fixed,
        share_outside_grid=float(found.attrs["outside"]),
        mean_share_of_stones_without_outcome=float(own["unknown"].mean()),
        max_share_of_stones_without_outcome=float(own["unknown"].max()),
        max_share_of_stones_without_outcome_at_any_factor=float(found["unknown"].max()),
        median_shifted_standing_share_of_all_stones=float(own["shift_rate"].median())
        if results.model.can_rotate_about_vertical
        else math.nan,
        median_rotated_standing_share_of_all_stones=float(own["rotation_rate"].median())
        if results.model.can_rotate_about_vertical
        else math.nan,
        smallest_fall_rate=quantiles[0],
        lower_quartile_of_fall_rate_over_records=quantiles[1],
        median_fall_rate=quantiles[2],
        upper_quartile_of_fall_rate_over_records=quantiles[3],
        largest_fall_rate=quantiles[4],
        by_record=[
            _population_fall_rate_under_record(results, index) for index in range(len(results.record_ids_and_names))
        ],
        records_without_vertical_motion=int(horizontal.sum()),
        median_fall_rate_by_jma_degree=[
            MedianFallRateAtJmaDegree(
                jma_degree=degree,
                median_fall_rate=float(np.median(rates[at])),
                count=_count_motions_records_and_earthquakes(at, events),
            )
            for degree, low, high in JMA_DEGREES_WITH_INTENSITY_RANGES
            if (at := known & is_published_intensity_in_range(jma, low, high)).sum() >= MIN_MOTIONS_FOR_FALL_RATE
        ],
        checks_of_jma_intensity_rules=[
            _compare_jma_inferred_from_falls_with_motions(rule, known, free_rates, jma, horizontal, events)
            for rule in JMA_DEGREE_RANGES_BY_OVERTURNED_FRACTION
            if _motions_with_fall_rate_in_rule_range(rule, known, free_rates).sum() >= MIN_MOTIONS_FOR_FALL_RATE
        ],
        fragility_curves=[
            FragilityCurve(
                stone_class=one.stone_class,
                measure=one.measure,
                unit=one.unit,
                median=one.median_interval_and_log_std_censored_to_data[0],
                low=one.median_interval_and_log_std_censored_to_data[1].low,
                high=one.median_interval_and_log_std_censored_to_data[1].high,
                log_std=one.median_interval_and_log_std_censored_to_data[2],
                log_std_between_records=one.log_std_between_records_and_between_stones[0],
                log_std_within_record=one.log_std_between_records_and_between_stones[1],
                data_minimum=one.min_intensity_of_validity_range,
                data_maximum=one.max_intensity_of_validity_range,
            )
            for one in results.fragility_curves
            if math.isfinite(one.median)
        ],
    )


def _population_fall_rate_under_record(
    results: StudyResults, record_index_in_cube: int
) -> PopulationFallRateUnderRecord:
    """Return the share of the stone population that falls under one record, with its interval."""
    own = (
        results.population_rates_by_variant[NAME_OF_STUDY_ITSELF_AMONG_VARIANTS]
        .isel(record=record_index_in_cube)
        .sel(amplitude=1.0)
    )
    rate, ends = float(own["fall_rate"]), own["fall_interval"].to_numpy().tolist()
    most = own.isel(octant=int(np.argmax(own["fall_octant"].to_numpy()))) if rate > 0 else None
    twists = results.model.can_rotate_about_vertical
    return PopulationFallRateUnderRecord(
        record=results.record_ids_and_names[record_index_in_cube].id,
        fall_rate=rate,
        low=ends[0],
        high=ends[1],
        shifted_standing_share_of_all_stones=float(own["shift_rate"]) if twists else math.nan,
        rotated_standing_share_of_all_stones=float(own["rotation_rate"]) if twists else math.nan,
        most_frequent_fall_octant_deg=math.nan if most is None else float(most["octant"]),
        share_falling_towards_most_frequent_octant=math.nan if most is None else float(most["fall_octant"]),
    )


def _motions_with_fall_rate_in_rule_range(
    fall_rate_and_jma_range_of_rule: tuple[float, float, float, float, str],
    mask_of_motions_with_known_rate_and_jma: BoolArray,
    fall_rate_of_free_stones_by_motion: FloatArray,
) -> BoolArray:
    """Return a mask, shape (records, amplitudes), of the motions with a fall rate in the range of a survey rule.

    The rule infers the JMA intensity from the share of stones that fell (fall rate).
    """
    low, high, *_ = fall_rate_and_jma_range_of_rule
    return (
        mask_of_motions_with_known_rate_and_jma
        & (fall_rate_of_free_stones_by_motion >= low)
        & ((fall_rate_of_free_stones_by_motion < high) | (high >= 1))
    )


def _compare_jma_inferred_from_falls_with_motions(
    fall_rate_and_jma_range_of_rule: tuple[float, float, float, float, str],
    mask_of_motions_with_known_rate_and_jma: BoolArray,
    fall_rate_of_free_stones_by_motion: FloatArray,
    jma_intensity_by_motion: FloatArray,
    mask_of_records_without_vertical_motion: BoolArray,
    earthquake_by_record: StrArray,
) -> JmaIntensityFromFallShareRuleCheck:
    """Compare the JMA intensity that a survey rule infers from the share of fallen stones with that of the motions.

    The rule is the range of the fall rate, the range of the intensity, and the degree inferred. Arrays have shape
    (records, amplitudes); `mask_of_records_without_vertical_motion` and `earthquake_by_record` have shape (records,).
    """
    low, high, least, most, text = fall_rate_and_jma_range_of_rule
    selected = _motions_with_fall_rate_in_rule_range(
        fall_rate_and_jma_range_of_rule, mask_of_motions_with_known_rate_and_jma, fall_rate_of_free_stones_by_motion
    )
    more = (
        jma_intensity_by_motion
        + ASSUMED_JMA_INTENSITY_ADDED_BY_VERTICAL_MOTION * mask_of_records_without_vertical_motion[:, None]
    )
    agreeing, agreeing_more, above = (
        selected & is_published_intensity_in_range(one, a, b)
        for one, a, b in (
            (jma_intensity_by_motion, least, most),
            (more, least, most),
            (jma_intensity_by_motion, most, math.inf),
        )
    )
    lacking = bool((selected & mask_of_records_without_vertical_motion[:, None]).any())
    return JmaIntensityFromFallShareRuleCheck(
        rule_fall_rate_lower_limit=low,
        rule_fall_rate_upper_limit=high if high < 1 else math.inf,
        inferred_jma_degree=text,
        median_jma_intensity_in_fall_rate_range=float(
            round_and_truncate_to_published_intensity(np.median(jma_intensity_by_motion[selected]))
        ),
        count=_count_motions_records_and_earthquakes(selected, earthquake_by_record),
        share_with_intensity_of_inferred_degree=share_of_compared_motions_with_interval(
            agreeing, selected, earthquake_by_record
        ),
        share_with_intensity_above_inferred_degree=share_of_compared_motions_with_interval(
            above, selected, earthquake_by_record
        )
        if math.isfinite(most) and most < 99
        else None,
        share_of_inferred_degree_with_vertical_increment=share_of_compared_motions_with_interval(
            agreeing_more, selected, earthquake_by_record
        )
        if lacking
        else None,
    )


def _count_motions_records_and_earthquakes(
    mask_of_counted_motions: BoolArray, earthquake_by_record: StrArray
) -> MotionRecordAndEarthquakeCounts:
    """Return the numbers of motions selected by a mask, and of their records and earthquakes.

    The mask has shape (records, amplitudes), and `earthquake_by_record` shape (records,).
    """
    records = mask_of_counted_motions.any(axis=1)
    return MotionRecordAndEarthquakeCounts(
        motions=int(mask_of_counted_motions.sum()),
        records=int(records.sum()),
        earthquakes=int(np.unique(earthquake_by_record[records]).size),
    )


def share_of_compared_motions_with_interval(
    mask_of_agreeing_motions: BoolArray, mask_of_all_compared_motions: BoolArray, earthquake_by_record: StrArray
) -> ShareOfMotionsWithInterval:
    """Return the share of the compared motions that agree with a survey rule, and its 95 % interval over earthquakes.

    The rule infers the JMA intensity from the share of fallen stones. The masks have shape (records, amplitudes).
    """
    records = mask_of_all_compared_motions.any(axis=1)
    names, member = np.unique(earthquake_by_record[records], return_inverse=True)
    counts = np.stack(
        [
            np.bincount(member, each[records].sum(axis=1), names.size)
            for each in (mask_of_agreeing_motions, mask_of_all_compared_motions)
        ],
        axis=1,
    )
    interval = exact_interval_if_all_0_or_all_1(counts[:, 0] / counts[:, 1]) or ConfidenceInterval(
        *bootstrap_interval(
            lambda drawn: drawn[..., 0].sum(axis=1) / drawn[..., 1].sum(axis=1), counts, statistic_bounds=(0.0, 1.0)
        )
    )
    return ShareOfMotionsWithInterval(
        value=mask_of_agreeing_motions.sum() / mask_of_all_compared_motions.sum(), low=interval.low, high=interval.high
    )
