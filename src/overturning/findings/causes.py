"""Causes of falls: logistic fit, published criteria, and outcomes beside published ones."""

import math

from overturning.findings.results import Results
from overturning.findings.values import Estimate, Finding, Number, estimate
from overturning.labels import element_size_note
from overturning.statistics.criteria import PULSE_VALID, criteria_scores
from overturning.statistics.logistic import LEVEL, describe, overturning_fit


class Coefficient(Finding):
    """Coefficient of the logistic fit."""

    predictor: str
    value: Number
    low: Number
    high: Number
    data_minimum: Number
    data_maximum: Number
    odds_factor_doubled: Number
    """Factor on the odds of a fall if the quantity of the predictor doubles and the other predictors stay."""
    odds_factor_low: Number
    odds_factor_high: Number


class Fit(Finding):
    """Logistic fit of the probability of overturning, with intervals from the jackknife over earthquakes."""

    coefficients: list[Coefficient]
    rows: int
    earthquakes: int
    level: float
    note: str
    """Reason why there is no fit or no interval; otherwise empty."""


class CriterionScore(Finding):
    """Skill of a criterion: hit rate minus false-alarm rate."""

    criterion: str
    rule: str
    hit_rate: Number
    false_alarm_rate: Number
    skill: Estimate
    """Skill over all blocks together."""
    skill_within: Estimate
    """Mean skill over blocks of one height and B/H."""
    skill_within_valid: Number
    """The same without planes and blocks beyond the range of the pulse criterion."""


class Criteria(Finding):
    """Skill of published criteria, and of the best rule that ignores the motion (last)."""

    scores: list[CriterionScore]
    best_within: str
    """Criterion with the largest skill within blocks; empty if no skill is defined."""
    lead_within: dict[str, Estimate]
    """Skill within blocks of this criterion minus that of each other one."""
    beyond_pulse_range: Number
    """Share of planes and blocks for which the pulse criterion is far too low."""
    pulse_range: float = PULSE_VALID


class PublishedOutcome(Finding):
    """Outcome of a cell beside a published one."""

    variant: str
    record: str
    azimuth_deg: float
    height_m: float
    friction: float
    published: bool | None
    found: bool | None
    """None if the outcome is not known."""


def fit_of(results: Results) -> Fit | None:
    """Fit the probability of overturning; None in space, and for elements of several sizes."""
    if not results.model.one_component or element_size_note(results.cube):
        return None
    fit = overturning_fit(results.cube, results.intensity)
    rows = []
    for name, value, low, high, least, most in describe(fit):
        doubled = [2.0**one for one in (value, low, high)] if name != "intercept" else [math.nan] * 3
        rows.append(
            Coefficient(
                predictor=name,
                value=value,
                low=low,
                high=high,
                data_minimum=least,
                data_maximum=most,
                odds_factor_doubled=doubled[0],
                odds_factor_low=doubled[1],
                odds_factor_high=doubled[2],
            )
        )
    return Fit(coefficients=rows, rows=fit.rows, earthquakes=fit.clusters, level=LEVEL, note=fit.note)


def criteria_of(results: Results) -> Criteria | None:
    """Score the published criteria; None in space, for elements of several sizes, and without outcomes."""
    asked = results.model.one_component and not element_size_note(results.cube)
    found = criteria_scores(results.cube, results.intensity) if asked else None
    if found is None:
        return None
    scores = [
        CriterionScore(
            criterion=one.name,
            rule=one.rule,
            hit_rate=one.overall.hit_rate,
            false_alarm_rate=one.overall.false_alarm_rate,
            skill=estimate(one.skill, "skill over all blocks together"),
            skill_within=estimate(one.within, "mean skill over blocks of one height and B/H"),
            skill_within_valid=one.within_valid,
        )
        for one in found.rules
    ]
    leads = {name: estimate(lead, "difference of the skills within blocks") for name, lead in found.leads.items()}
    return Criteria(
        scores=scores,
        best_within=found.best.name if found.leads else "",
        lead_within=leads,
        beyond_pulse_range=found.beyond,
    )


def published_of(results: Results) -> list[PublishedOutcome]:
    """Return the outcomes where something was published, for each variant, height and friction."""
    if not results.study.published:
        return []
    return [
        PublishedOutcome(
            variant=variant,
            record=row.record,
            azimuth_deg=row.azimuth,
            height_m=round(height, 9),
            friction=round(friction, 9),
            published=row.overturns,
            found=overturns,
        )
        for variant in results.cubes
        for (height, friction), found in published_outcomes(results, variant).items()
        for row, overturns in zip(results.study.published, found, strict=True)
    ]


def published_outcomes(results: Results, variant: str) -> dict[tuple[float, float], tuple[bool | None, ...]]:
    """Return, by height and friction, if the block overturns where something was published; None if it is not known."""
    cube, ids = results.reference_cube(variant), [name.id for name in results.names]
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
