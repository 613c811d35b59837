"""Surveys of fallen stones: comparison with the prediction, and inferred motion."""

from overturning.findings.results import Results
from overturning.findings.values import Finding, Number
from overturning.surveys.comparison import SurveyResult
from overturning.surveys.posterior import LEVEL, InversionResult
from overturning.surveys.stones import OCTANTS


class Test(Finding):
    """Result of a statistical test."""

    name: str
    n: int
    statistic: Number
    p_value: Number


class SurveyFindings(Finding):
    """Comparison of a survey with the prediction for its site."""

    stones: str
    """Name of the survey file."""
    sha256: str
    record: str
    fell: int
    stood: int
    fell_in_unknown_direction: int
    mean_direction_deg: Number
    resultant: Number
    observed_by_octant: dict[str, Number]
    predicted_by_octant: dict[str, Number]
    log_likelihood_ratio: Number
    """Sum over fallen stones of ln(predicted/uniform); above 0 if the prediction is better than a guess."""
    log_likelihood_ratio_p: Number
    """Share of surveys of stones that fall in random directions with a ratio at least as large."""
    fit: list[Test]
    uniform: Test
    correct_sides: int | None
    """Stones of known face and B/H that did what was most probable; None if there are none."""
    stones_with_sides: int | None
    without_face: int
    without_b_over_h: int
    beyond_grid: int
    background: float


class InferredStrength(Finding):
    """Credible interval of a strength of the motion: before (prior) and after (posterior) the survey."""

    measure: str
    low: Number
    high: Number
    prior_low: Number
    prior_high: Number


class InferredMotion(Finding):
    """Motion inferred from a survey."""

    stones: str
    fell: int
    stood: int
    level: float = LEVEL
    """Probability of the intervals and of the arc."""
    axis_deg: Number
    """Middle of the arc of the axis of the largest velocity, 0 to 180."""
    axis_arc_deg: Number
    """Width of this arc."""
    strengths: list[InferredStrength]
    fit_p: Number
    """p-value of the posterior predictive check; small if no motion fits the survey."""
    likeliest: dict[str, Number]
    """The likeliest motions with their probability."""


MOTIONS_LISTED = 12


def surveys_of(results: Results) -> list[SurveyFindings]:
    """Return the comparisons of the study's surveys with its predictions."""
    return [survey_findings(one) for one in results.surveys]


def survey_findings(result: SurveyResult) -> SurveyFindings:
    """Return the comparison of a survey with the prediction for its site."""
    found, confusion = result.comparison, result.comparison.confusion

    def by_octant(values: list[float]) -> dict[str, Number]:
        return dict(zip(OCTANTS, values, strict=True))

    def test(name: str) -> Test:
        one = getattr(found, name)
        return Test(name=one.name, n=one.n, statistic=one.statistic, p_value=one.p_value)

    return SurveyFindings(
        stones=result.stones,
        sha256=result.sha256,
        record=result.record,
        fell=found.fallen,
        stood=found.stood,
        fell_in_unknown_direction=found.without_direction,
        mean_direction_deg=found.mean_direction_deg,
        resultant=found.resultant,
        observed_by_octant=by_octant(found.octant_observed.tolist()),
        predicted_by_octant=by_octant(found.octant_predicted.tolist()),
        log_likelihood_ratio=found.log_likelihood_ratio,
        log_likelihood_ratio_p=found.likelihood_ratio_p,
        fit=[test(name) for name in ("fit_octants", "fit_octants_watson", "fit_exact")],
        uniform=test("uniform_octants"),
        correct_sides=None if confusion is None else int(confusion.trace()),
        stones_with_sides=None if confusion is None else int(confusion.sum()),
        without_face=found.without_face,
        without_b_over_h=found.without_b_over_h,
        beyond_grid=found.beyond,
        background=found.background,
    )


def motions_of(results: Results) -> list[InferredMotion]:
    """Return the motions inferred from the study's surveys."""
    return [inferred_motion(one) for one in results.backwards]


def inferred_motion(found: InversionResult) -> InferredMotion:
    """Return the motion inferred from a survey."""
    one, strengths = found.posterior, []
    for name, values in found.strengths.items():
        (low, high), (least, most) = one.interval(values), one.interval(values, prior=True)
        strengths.append(InferredStrength(measure=name, low=low, high=high, prior_low=least, prior_high=most))
    middle, width = found.axis_arc
    shares = one.of_sources()
    order = (-shares).argsort(kind="stable")[:MOTIONS_LISTED]
    return InferredMotion(
        stones=found.name,
        fell=found.fell,
        stood=found.stood,
        axis_deg=middle,
        axis_arc_deg=width,
        strengths=strengths,
        fit_p=found.fit,
        likeliest={one.sources[place]: float(shares[place]) for place in order},
    )
