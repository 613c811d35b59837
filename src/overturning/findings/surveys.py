"""Surveys of fallen stones: comparison with the prediction, and inferred motion."""

from overturning.findings.results import Results
from overturning.findings.values import Finding, Number
from overturning.surveys.comparison import SurveyResult
from overturning.surveys.posterior import LEVEL, InversionResult
from overturning.surveys.stones import OCTANTS


class TestFinding(Finding):
    """Result of a statistical test."""

    name: str
    """Name of the test."""
    sample_size: int
    """Number of stones."""
    statistic: Number
    """Test statistic."""
    p_value: Number
    """p-value."""


class SurveyFindings(Finding):
    """Comparison of a survey with the prediction for its site."""

    stones: str
    """Name of the survey file."""
    sha256: str
    """SHA-256 hash of the survey file."""
    record: str
    """Record for whose site the prediction is made."""
    fell: int
    """Number of stones that fell."""
    stood: int
    """Number of stones that stood."""
    fell_in_unknown_direction: int
    """Number of stones that fell in an unknown direction."""
    mean_direction_deg: Number
    """Mean fall direction."""
    resultant: Number
    """Length of the mean of the fall directions as unit vectors, 0 to 1."""
    observed_by_octant: dict[str, Number]
    """Number of fallen stones in each octant of fall direction."""
    predicted_by_octant: dict[str, Number]
    """Predicted number of fallen stones in each octant."""
    log_likelihood_ratio: Number
    """Sum over fallen stones of ln(predicted/uniform); above 0 if the prediction is better than a guess."""
    log_likelihood_ratio_p_value: Number
    """Share of surveys of stones that fall in random directions with a ratio at least as large."""
    fit_tests: list[TestFinding]
    """Tests of the agreement of observed and predicted directions."""
    uniformity_test: TestFinding
    """Test of a uniform distribution of the observed directions."""
    correct_predictions: int | None
    """Number of `checked_predictions` in which the stone did what was most probable."""
    checked_predictions: int | None
    """Number of stones of known face and B/H; None if there are none."""
    stones_without_face: int
    """Number of stones whose face azimuth is not known."""
    stones_without_b_over_h: int
    """Number of stones whose B/H is not known."""
    stones_beyond_grid: int
    """Number of stones with a B/H outside the grid, which take its nearest value."""
    share_in_random_direction: float
    """Assumed share of the stones that fall in a random direction."""


class InferredStrength(Finding):
    """Credible interval of an intensity measure before (prior) and after (posterior) the survey."""

    measure: str
    """Intensity measure."""
    posterior_low: Number
    """Lower end of the interval after the survey."""
    posterior_high: Number
    """Upper end of the interval after the survey."""
    prior_low: Number
    """Lower end of the interval before the survey."""
    prior_high: Number
    """Upper end of the interval before the survey."""


class InferredMotion(Finding):
    """Axis and strength of the motion inferred from a survey of stones."""

    stones: str
    """Name of the survey file."""
    fell: int
    """Number of stones that fell."""
    stood: int
    """Number of stones that stood."""
    level: float = LEVEL
    """Probability of the credible intervals and of the arc."""
    velocity_axis_deg: Number
    """Middle of the credible arc of the axis of the largest velocity, 0 to 180."""
    velocity_axis_arc_deg: Number
    """Width of the arc of the axis of the largest velocity."""
    strengths: list[InferredStrength]
    """Interval of each intensity measure."""
    fit_p_value: Number
    """p-value of the posterior predictive check; small if no motion fits the survey."""
    likeliest_motions: dict[str, Number]
    """The likeliest motions with their probability."""


MOTIONS_LISTED = 12


def all_survey_findings(results: Results) -> list[SurveyFindings]:
    """Return the comparisons of the study's surveys with its predictions."""
    return [survey_findings(one) for one in results.surveys]


def survey_findings(result: SurveyResult) -> SurveyFindings:
    """Return the comparison of a survey with the prediction for its site."""
    found, confusion = result.comparison, result.comparison.confusion

    def by_octant(values: list[float]) -> dict[str, Number]:
        return dict(zip(OCTANTS, values, strict=True))

    def test(name: str) -> TestFinding:
        one = getattr(found, name)
        return TestFinding(name=one.name, sample_size=one.n, statistic=one.statistic, p_value=one.p_value)

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
        log_likelihood_ratio_p_value=found.likelihood_ratio_p,
        fit_tests=[test(name) for name in ("fit_octants", "fit_octants_watson", "fit_exact")],
        uniformity_test=test("uniform_octants"),
        correct_predictions=None if confusion is None else int(confusion.trace()),
        checked_predictions=None if confusion is None else int(confusion.sum()),
        stones_without_face=found.without_face,
        stones_without_b_over_h=found.without_b_over_h,
        stones_beyond_grid=found.beyond,
        share_in_random_direction=found.background,
    )


def inferred_motions(results: Results) -> list[InferredMotion]:
    """Return the motions inferred from the study's surveys."""
    return [inferred_motion(one) for one in results.inferred_motions]


def inferred_motion(inversion: InversionResult) -> InferredMotion:
    """Return the motion inferred from a survey."""
    one, strengths = inversion.posterior, []
    for name, values in inversion.strengths.items():
        (low, high), (least, most) = one.credible_interval(values), one.credible_interval(values, use_prior=True)
        strengths.append(
            InferredStrength(measure=name, posterior_low=low, posterior_high=high, prior_low=least, prior_high=most)
        )
    middle, width = inversion.axis_arc
    shares = one.source_probabilities()
    order = (-shares).argsort(kind="stable")[:MOTIONS_LISTED]
    return InferredMotion(
        stones=inversion.name,
        fell=inversion.fell,
        stood=inversion.stood,
        velocity_axis_deg=middle,
        velocity_axis_arc_deg=width,
        strengths=strengths,
        fit_p_value=inversion.fit,
        likeliest_motions={one.sources[place]: float(shares[place]) for place in order},
    )
