"""Share of a cemetery's stones that fall, by record, amplitude and intensity."""

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.findings.results import Results
from overturning.findings.values import Finding, Number
from overturning.motion.jma_intensity import SURVEY_RULE, VERTICAL_INTENSITY_INCREMENT, published_intensity
from overturning.statistics.bootstrap import Interval, bootstrap, unanimous_share_interval
from overturning.study.scenes import NOMINAL
from overturning.surveys.population import jma_intensities

JMA_DEGREES: Final = (("5 upper", 5.0, 5.5), ("6 lower", 5.5, 6.0), ("6 upper", 6.0, 6.5), ("7", 6.5, math.inf))
"""Degrees of the JMA scale, with their range of instrumental intensity."""

FEWEST_MOTIONS: Final = 3
"""Smallest number of motions for which a rate by intensity is given."""

BoolArray = NDArray[np.bool_]
StrArray = NDArray[np.str_]


class MotionCount(Finding):
    """Number of motions (records times factors), and of their records and earthquakes."""

    motions: int
    records: int
    earthquakes: int


class ShareOfMotions(Finding):
    """Share of motions with its 95 % interval over earthquakes: exact if all earthquakes agree."""

    value: Number
    low: Number
    high: Number


class RateAtIntensity(Finding):
    """Fall rate at one degree of the JMA scale."""

    degree: str
    median_rate: Number
    of: MotionCount


class SurveyRuleCheck(Finding):
    """Check of the rule by which surveys infer the JMA intensity from the share of stones that fell."""

    rate_from: float
    rate_below: float
    """Upper end of the fall rate; infinite if the rule has no upper end."""
    inferred: str
    """Intensity that the rule infers."""
    median_intensity: Number
    """Median of the instrumental intensity of these motions."""
    of: MotionCount
    agrees: ShareOfMotions
    higher: ShareOfMotions | None
    """Share with a higher intensity; None for the highest degree."""
    agrees_with_vertical: ShareOfMotions | None
    """Share that agrees if the missing vertical component adds `vertical_increment`."""


class FragilityCurve(Finding):
    """Lognormal fragility curve; `inf` for values above the range of the data, 0 for values below."""

    stones: str
    measure: str
    unit: str
    median: Number
    low: Number
    high: Number
    spread: Number
    """Standard deviation of the logarithm."""
    spread_between_records: Number
    spread_within: Number
    data_minimum: float
    data_maximum: float


class RecordRate(Finding):
    """Share of the stones that fall under a record as it is, with the interval of a cemetery of so many stones."""

    record: str
    fall_rate: Number
    low: Number
    high: Number
    shifted: Number
    """Share that stands shifted; None for planar models."""
    rotated: Number
    octant_deg: Number
    """Centre of the octant towards which most stones fall; None without falls."""
    share_towards_octant: Number


class PopulationFindings(Finding):
    """Falls of the study's population of stones."""

    stones: int
    outside_grid: Number
    """Share of the stones outside the grid of the study, which take the outcome of its nearest block."""
    without_outcome: Number
    """Mean share of the stones without an outcome."""
    most_without_outcome: Number
    """Largest such share under one record."""
    median_shifted: Number
    """Median share of the stones that stand shifted; None for planar models."""
    median_rotated: Number
    median_rate: Number
    """Quantiles of the fall rate over the records as they are."""
    quarter_rate: Number
    three_quarter_rate: Number
    least_rate: Number
    largest_rate: Number
    by_record: list[RecordRate]
    records_without_vertical: int
    vertical_increment: float = VERTICAL_INTENSITY_INCREMENT
    """Instrumental intensity that a vertical component usually adds."""
    by_intensity: list[RateAtIntensity]
    survey_rules: list[SurveyRuleCheck]
    curves: list[FragilityCurve]


def population_of(results: Results) -> PopulationFindings | None:
    """Compute the falls of the study's population; None without one."""
    stones = results.study.population
    if stones is None:
        return None
    found = results.populations[NOMINAL]
    own, jma = found.sel(amplitude=1.0), jma_intensities(found, results.intensity)
    horizontal = results.intensity["jma_intensity"].isnull().to_numpy()
    rate = own["fall_rate"].dropna("record").to_numpy()
    quantiles = np.quantile(rate, [0.0, 0.25, 0.5, 0.75, 1.0]).tolist() if rate.size else [math.nan] * 5
    rates, events = found["fall_rate"].to_numpy(), found["event"].to_numpy().astype(str)
    known = np.isfinite(jma) & np.isfinite(rates)
    return PopulationFindings(
        stones=stones.stones,
        outside_grid=float(found.attrs["outside"]),
        without_outcome=float(own["unknown"].mean()),
        most_without_outcome=float(own["unknown"].max()),
        median_shifted=float(own["shift_rate"].median()) if results.model.twists else math.nan,
        median_rotated=float(own["rotation_rate"].median()) if results.model.twists else math.nan,
        least_rate=quantiles[0],
        quarter_rate=quantiles[1],
        median_rate=quantiles[2],
        three_quarter_rate=quantiles[3],
        largest_rate=quantiles[4],
        by_record=[_record_rate(results, index) for index in range(len(results.names))],
        records_without_vertical=int(horizontal.sum()),
        by_intensity=[
            RateAtIntensity(degree=degree, median_rate=float(np.median(rates[at])), of=_count(at, events))
            for degree, low, high in JMA_DEGREES
            if (at := known & (jma >= low) & (jma < high)).sum() >= FEWEST_MOTIONS
        ],
        survey_rules=[
            _rule_check(rule, known, rates, jma, horizontal, events)
            for rule in SURVEY_RULE
            if _within_rule(rule, known, rates).sum() >= FEWEST_MOTIONS
        ],
        curves=[
            FragilityCurve(
                stones=one.name,
                measure=one.measure,
                unit=one.unit,
                median=one.within_data[0],
                low=one.within_data[1].low,
                high=one.within_data[1].high,
                spread=one.within_data[2],
                spread_between_records=one.spreads[0],
                spread_within=one.spreads[1],
                data_minimum=one.least,
                data_maximum=one.most,
            )
            for one in results.fragility_curves
            if math.isfinite(one.median)
        ],
    )


def _record_rate(results: Results, index: int) -> RecordRate:
    own = results.populations[NOMINAL].isel(record=index).sel(amplitude=1.0)
    rate, ends = float(own["fall_rate"]), own["fall_interval"].to_numpy().tolist()
    most = own.isel(octant=int(np.argmax(own["fall_octant"].to_numpy()))) if rate > 0 else None
    twists = results.model.twists
    return RecordRate(
        record=results.names[index].id,
        fall_rate=rate,
        low=ends[0],
        high=ends[1],
        shifted=float(own["shift_rate"]) if twists else math.nan,
        rotated=float(own["rotation_rate"]) if twists else math.nan,
        octant_deg=math.nan if most is None else float(most["octant"]),
        share_towards_octant=math.nan if most is None else float(most["fall_octant"]),
    )


def _within_rule(rule: tuple[float, float, float, float, str], known: BoolArray, rates: FloatArray) -> BoolArray:
    """Return True for motions whose fall rate lies in the range of a rule."""
    low, high, *_ = rule
    return known & (rates >= low) & ((rates < high) | (high >= 1))


def _rule_check(
    rule: tuple[float, float, float, float, str],
    known: BoolArray,
    rates: FloatArray,
    jma: FloatArray,
    horizontal: BoolArray,
    events: StrArray,
) -> SurveyRuleCheck:
    """Check a rule on its motions, with and without the increment for the missing vertical component."""
    low, high, least, most, text = rule
    own = _within_rule(rule, known, rates)
    more = jma + VERTICAL_INTENSITY_INCREMENT * horizontal[:, None]
    hits, hits_more, above = (
        own & (one >= a) & (one < b) for one, a, b in ((jma, least, most), (more, least, most), (jma, most, math.inf))
    )
    lacking = bool((own & horizontal[:, None]).any())
    return SurveyRuleCheck(
        rate_from=low,
        rate_below=high if high < 1 else math.inf,
        inferred=text,
        median_intensity=float(published_intensity(np.median(jma[own]))),
        of=_count(own, events),
        agrees=share_of_motions(hits, own, events),
        higher=share_of_motions(above, own, events) if math.isfinite(most) and most < 99 else None,
        agrees_with_vertical=share_of_motions(hits_more, own, events) if lacking else None,
    )


def _count(own: BoolArray, events: StrArray) -> MotionCount:
    """Count motions, shape (records, amplitudes), their records and earthquakes."""
    records = own.any(axis=1)
    return MotionCount(
        motions=int(own.sum()), records=int(records.sum()), earthquakes=int(np.unique(events[records]).size)
    )


def share_of_motions(hits: BoolArray, own: BoolArray, events: StrArray) -> ShareOfMotions:
    """Compute a share of motions with its interval over earthquakes; exact if all earthquakes agree."""
    records = own.any(axis=1)
    names, member = np.unique(events[records], return_inverse=True)
    counts = np.stack([np.bincount(member, each[records].sum(axis=1), names.size) for each in (hits, own)], axis=1)
    interval = unanimous_share_interval(counts[:, 0] / counts[:, 1]) or Interval(
        *bootstrap(lambda drawn: drawn[..., 0].sum(axis=1) / drawn[..., 1].sum(axis=1), counts)
    )
    return ShareOfMotions(value=hits.sum() / own.sum(), low=interval.low, high=interval.high)
