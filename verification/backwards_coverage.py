"""`python -m verification.backwards_coverage [ruin] [coverage]`: coverage of the intervals of `overturning backwards`.

``ruin`` computes the example ruin of docs/surveys.md, ``coverage`` the table of coverage; without arguments both.

Each survey is simulated under a record of one earthquake; all records of this earthquake are removed from the library.
The peak velocity lies between the levels of the library. Each stone is simulated by itself, with the friction, scatter,
random outcomes and restitution of the survey. The earthquakes are split into two halves. On the surveys of one half the
exponent of the likelihood of directions is chosen: the largest of `CANDIDATE_LIKELIHOOD_EXPONENTS` with which each of
the three intervals covers at least `TARGET_COVERAGE`. The surveys of the other half are reported with this exponent.
Then the halves are exchanged. The shipped exponent should be the smaller of the two.
"""

from dataclasses import dataclass
from typing import Annotated, Final

import numpy as np
import pandas as pd
import typer

from overturning.arrays import FloatArray
from overturning.dem.run import simulate_cases
from overturning.findings.inferred_motion import inferred_motion_findings
from overturning.findings.survey_commands import ResultsPrintedBySurveyCommands
from overturning.model.cases import Cases
from overturning.model.shapes import Cylinder, RectangularPrism
from overturning.report.drawings import write_ground_motion_posterior_figure
from overturning.report.render import parse_markdown_and_number_figures_and_tables, render_template_as_markdown
from overturning.report.terminal import plain_text_of_uncollapsed_paragraphs
from overturning.statistics.bootstrap import ConfidenceInterval, bootstrap_interval, exact_interval_if_all_0_or_all_1
from overturning.surveys.counted_stones import read_counted_stones
from overturning.surveys.inversion import DIRECTION_LIKELIHOOD_EXPONENT, MIN_FIT_P_VALUE, SurveyInversion
from overturning.surveys.library import CandidateMotion, candidate_motions
from overturning.surveys.posterior import MotionPosterior
from overturning.surveys.responses import StoneHeightAndSideRatios, StoneOutcomeProbabilities
from overturning.surveys.stone_outcomes import SIMULATED_PGV_M_S
from overturning.surveys.stones import Stone
from verification.tables import (
    RESULT_TABLE_FOLDER,
    ROOT,
    markdown_table,
    named_parts_or_all_if_none,
    update_marked_tables_and_sentences_in_docs,
    wrap_text,
    write_csv,
)

SELECTABLE_PARTS: Final = ("ruin", "coverage")
RUIN_SURVEY_FILE: Final = ROOT / "surveys" / "example-ruin.csv"
DEFAULT_SURVEY_COUNT: Final = 392
SEED: Final = 26
CANDIDATE_LIKELIHOOD_EXPONENTS: Final = (0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5, 0.7, 1.0)
TARGET_COVERAGE: Final = 0.9
FIT_CHECK_EVERY_NTH_SURVEY: Final = 16
"""Every sixteenth survey is also checked for fit."""

INTERVAL_COVERAGE_COLUMNS: Final = ["pgv_holds", "pga_holds", "axis_holds"]
"""Columns that are True if an interval contains the true value."""


@dataclass(frozen=True)
class SimulatedSurveyWithTrueMotion:
    """Simulated survey of fallen and standing stones, with its true motion, peak velocity and axis."""

    true_motion_before_scaling: CandidateMotion
    true_pgv: float
    """Peak velocity to which the motion is scaled at the site, m/s."""
    true_pgv_axis_azimuth_deg: float
    """Azimuth of the axis of the largest velocity, 0 to 180."""
    stones: list[Stone]


def random_log_uniform(
    generator: np.random.Generator, lower_bound: float, upper_bound: float, value_count: int
) -> FloatArray:
    """Return random values between two bounds, whose logarithm is uniformly distributed."""
    return np.asarray(np.exp(generator.uniform(np.log(lower_bound), np.log(upper_bound), value_count)))


def simulate_survey(motion: CandidateMotion, generator: np.random.Generator) -> SimulatedSurveyWithTrueMotion:
    """Simulate a survey of 12 to 60 stones under a motion: columns, or in a third of the surveys square prisms."""
    draw, count = generator, int(generator.integers(12, 61))
    level, turn = (
        float(random_log_uniform(draw, SIMULATED_PGV_M_S[0], SIMULATED_PGV_M_S[-1], 1)[0]),
        draw.uniform(0, 360),
    )
    # Scatter between stones, scatter of the motion over the site, and share of random outcomes in this survey.
    alike, site, lapses = draw.uniform(0, 0.12), draw.uniform(0, 0.15), draw.uniform(0, 0.06)
    friction = draw.uniform(0.45, 0.95) + draw.uniform(-0.05, 0.05, count)
    damping = np.exp(draw.uniform(-np.log(2), np.log(2)))
    columns = draw.random() < 2 / 3
    if columns:
        height, shape = random_log_uniform(draw, 0.6, 3.6, count), random_log_uniform(draw, 0.1, 0.6, count)
        face = np.full(count, np.nan)
    else:
        height = draw.uniform(0.6, 1.0, count)
        shape = random_log_uniform(draw, 0.15, 0.6, count)
        face = draw.uniform(0, 360) + draw.uniform(-10, 10, count)
    turned = turn + draw.normal(0, 5, count)
    cases = Cases(
        np.nan_to_num(face) - turned,
        height,
        shape * np.exp(draw.normal(0, alike, count)),
        friction,
        level / motion.pgv_m_s * np.exp(draw.normal(0, site, count)),
        damping,
    )
    result = simulate_cases(Cylinder() if columns else RectangularPrism(), motion.motion, cases)
    azimuth = result.fall_azimuth + turned + draw.normal(0, 8, count)
    fell = result.overturned == 1
    lapse = draw.random(count) < lapses
    fell, azimuth = (
        np.where(lapse, draw.random(count) < 0.5, fell),
        np.where(lapse, draw.uniform(0, 360, count), azimuth),
    )
    stones = [
        Stone(bool(fell[i]), float(azimuth[i] % 360) if fell[i] else np.nan, False, b_over_h=float(shape[i]),
              face_azimuth_deg=float(face[i]), height_m=float(height[i]), has_round_plan=columns)
        for i in range(count) if lapse[i] or result.overturned[i] in (0, 1)
    ]  # fmt: skip
    return SimulatedSurveyWithTrueMotion(motion, level, (motion.peak_velocity_azimuth_deg + turn) % 180, stones)


def interval_coverage_and_widths(posterior: MotionPosterior, survey: SimulatedSurveyWithTrueMotion) -> dict[str, float]:
    """Return, by column name, whether each interval of the inferred motion holds the true value, and its width.

    The widths for PGV and PGA are upper over lower bound, with and without the survey; that of the axis is in degrees.
    Two further columns tell whether the interval of PGA lacks a bound.
    """
    found: dict[str, float] = {}
    pga = posterior.pga_m_s2_at_pgv_1_m_s[:, None] * posterior.pgv_by_motion_and_level
    true_pga = survey.true_pgv * survey.true_motion_before_scaling.pga_m_s2 / survey.true_motion_before_scaling.pgv_m_s
    for name, values, true in (("pgv", posterior.pgv_by_motion_and_level, survey.true_pgv), ("pga", pga, true_pga)):
        (low, high), (least, most) = (
            posterior.credible_interval(values),
            posterior.credible_interval(values, uses_prior_instead_of_posterior=True),
        )
        found[f"{name}_holds"] = low <= true <= high
        # A missing bound is replaced by that of the prior.
        found[f"{name}_ratio"] = (most if high == np.inf else high) / (low or least)
        found[f"{name}_before"] = most / least
    weakest, strongest = posterior.credible_interval(pga)
    middle, width = posterior.credible_axis_arc_middle_and_width_deg(
        all_stones_of_survey_fell=all(stone.fell for stone in survey.stones)
    )
    found["axis_holds"] = abs((survey.true_pgv_axis_azimuth_deg - middle + 90) % 180 - 90) <= width / 2
    return found | {"axis_width": width, "no_upper": strongest == np.inf, "no_lower": weakest == 0}


def measure_interval_coverage(survey_count: int, threads: int) -> pd.DataFrame:
    """Infer the motions of simulated surveys and check their intervals; a row per survey and likelihood exponent.

    Motions of a survey's true earthquake get a prior weight of zero.
    """
    library = candidate_motions()
    true = [one for one in library if one.earthquake_name]
    events = sorted({one.earthquake_name for one in true})
    truths = [simulate_survey(true[k % len(true)], np.random.default_rng([SEED, k])) for k in range(survey_count)]
    kinds = [
        StoneHeightAndSideRatios.from_stone_with_nearest_d_over_b(stone) for truth in truths for stone in truth.stones
    ]
    inversion, rows = SurveyInversion(StoneOutcomeProbabilities(library, kinds, thread_count=threads)), []
    for number, truth in enumerate(truths):
        prior = np.array(
            [float(one.earthquake_name != truth.true_motion_before_scaling.earthquake_name) for one in library]
        )[:, None, None]
        logs = inversion.fall_and_direction_log_likelihoods_of_survey(truth.stones)
        for power in CANDIDATE_LIKELIHOOD_EXPONENTS:
            one = inversion.compute_posterior(logs, prior_weights=prior, direction_likelihood_exponent=power)
            checked = power == DIRECTION_LIKELIHOOD_EXPONENT and number % FIT_CHECK_EVERY_NTH_SURVEY == 0
            about = {
                "half": events.index(truth.true_motion_before_scaling.earthquake_name) % 2, "power": power,
                "event": truth.true_motion_before_scaling.earthquake_name,
                "record": truth.true_motion_before_scaling.name,
                "stones": len(truth.stones), "fell": np.mean([stone.fell for stone in truth.stones]),
                "round": truth.stones[0].has_round_plan,
                "fit": inversion.posterior_predictive_p_value(truth.stones, one) if checked else np.nan,
            }  # fmt: skip
            rows.append(about | interval_coverage_and_widths(one, truth))
    return pd.DataFrame(rows)


def choose_likelihood_exponent(survey_exponent_rows: pd.DataFrame) -> float:
    """Return the largest likelihood exponent with which the intervals of PGV, PGA and axis have enough coverage.

    Each interval must hold the true value in a share `TARGET_COVERAGE` of surveys. If no exponent suffices, return
    the smallest.
    """
    covered = survey_exponent_rows.groupby("power")[INTERVAL_COVERAGE_COLUMNS].mean().min(axis=1)
    good = covered.index[covered >= TARGET_COVERAGE]
    return float(good.max()) if good.size else CANDIDATE_LIKELIHOOD_EXPONENTS[0]


def survey_rows_with_cross_validated_exponent(survey_exponent_rows: pd.DataFrame) -> pd.DataFrame:
    """Return each survey's row for the exponent chosen from the half of earthquakes without the survey's own."""
    halves = [
        (half, choose_likelihood_exponent(survey_exponent_rows[survey_exponent_rows["half"] != half]))
        for half in (0, 1)
    ]
    return pd.concat(
        [
            survey_exponent_rows[(survey_exponent_rows["half"] == half) & (survey_exponent_rows["power"] == power)]
            for half, power in halves
        ]
    )


def confidence_interval_of_coverage(survey_rows: pd.DataFrame, coverage_column: str) -> ConfidenceInterval:
    """Compute the 95 % interval of the share of surveys for which `coverage_column` is true.

    Surveys under one earthquake share its motions, so earthquakes are resampled (`bootstrap_interval`), each with all
    its surveys. There is no interval for fewer than eight earthquakes. If all surveys agree, the bound is exact (pⁿ
    for n of n earthquakes).
    """
    held_by_event = survey_rows.groupby("event")[coverage_column]
    of_event = np.column_stack([held_by_event.sum(), held_by_event.size()]).astype(np.float64)
    exact = exact_interval_if_all_0_or_all_1(of_event[:, 0] / of_event[:, 1])
    if exact is not None:
        return exact

    def covered_share_of_sample(covered_and_all_survey_counts_by_sample: FloatArray) -> FloatArray:
        """Return the covered share in each bootstrap sample of earthquakes.

        The last axis of `covered_and_all_survey_counts_by_sample` has the numbers of covered and of all surveys.
        """
        held, surveys = covered_and_all_survey_counts_by_sample.sum(axis=1).T
        return np.asarray(held / surveys)

    return bootstrap_interval(covered_share_of_sample, of_event)


def covered_share_with_interval_text(survey_rows: pd.DataFrame, coverage_column: str) -> str:
    """Return a label with the share of surveys for which `coverage_column` is true, and any interval of it."""
    low, high = confidence_interval_of_coverage(survey_rows, coverage_column)
    bounds = "" if np.isnan(low) else f" ({100 * low:.0f} to {100 * high:.0f})"
    return f"{100 * survey_rows[coverage_column].mean():.0f} %{bounds}"


def coverage_table_row(survey_group_name: str, survey_rows: pd.DataFrame) -> tuple[str, ...]:
    """Return a table row with coverage and widths of the intervals for a group of surveys."""
    powers = " and ".join(f"{power:g}" for power in sorted(survey_rows["power"].unique()))
    held = (covered_share_with_interval_text(survey_rows, each) for each in INTERVAL_COVERAGE_COLUMNS)
    shares = (f"{100 * survey_rows[each].mean():.0f} %" for each in ("no_upper", "no_lower"))
    widths = (f"{survey_rows[each].median():.3g}" for each in ("pgv_ratio", "pga_ratio", "axis_width"))
    return (
        survey_group_name,
        f"{len(survey_rows)}",
        f"{survey_rows['event'].nunique()}",
        powers,
        *held,
        *shares,
        *widths,
    )


def coverage_markdown_by_marker(rows: pd.DataFrame) -> dict[str, str]:
    """Return text and table on coverage as Markdown, by the name of the marker in the docs that they replace."""
    shown, shipped = (
        survey_rows_with_cross_validated_exponent(rows),
        rows[rows["power"] == DIRECTION_LIKELIHOOD_EXPONENT],
    )
    few = shown["stones"] < 36
    parts = {
        "**reported: all**": shown,
        **{f"half {half + 1} of the earthquakes": shown[shown["half"] == half] for half in (0, 1)},
        "columns": shown[shown["round"]], "gravestones": shown[~shown["round"]],
        "less than a tenth fell": shown[shown["fell"] < 0.1],
        "a tenth to nine tenths fell": shown[shown["fell"].between(0.1, 0.9)],
        "more than nine tenths fell, not all": shown[(shown["fell"] > 0.9) & (shown["fell"] < 1.0)],
        "every stone fell": shown[shown["fell"] == 1.0],
        "12 to 35 stones": shown[few], "36 to 60 stones": shown[~few],
        **{f"all, exponent {power:g}": rows[rows["power"] == power] for power in CANDIDATE_LIKELIHOOD_EXPONENTS},
    }  # fmt: skip
    head = (
        "surveys", "number", "earthquakes", "exponent", "PGV covered", "PGA covered", "axis covered", "no upper bound",
        "no lower bound", "PGV, upper/lower", "PGA, upper/lower", "axis, width",
    )  # fmt: skip
    held = [100 * shown[each].mean() for each in INTERVAL_COVERAGE_COLUMNS]
    ends = dict.fromkeys(f"{end:.0f}" for end in (min(held), max(held)))
    fits = shipped["fit"].dropna()
    text = (
        f"The estimated intervals have a nominal coverage of {100 * TARGET_COVERAGE:.0f} %, and contain the true value "
        f"in {' to '.join(ends)} % of the reported surveys. Numbers in brackets are 95 % confidence intervals of the "
        "coverage, from a bootstrap over earthquakes. If all intervals of a line of the coverage table contain "
        "the true value, or none does, one end of the confidence interval is an exact bound. The coverage table gives "
        "no confidence interval for fewer than eight earthquakes. If every stone of a survey fell, the survey does not "
        "determine the axis of the ground motion; the coverage table then uses the arc that holds without a survey. "
        "The last three columns of the coverage table give medians of the widths of the 90 % intervals. If an interval "
        "has no upper "
        "bound, its width is computed with the strongest level of shaking in the library; if it has no lower bound, "
        "with the weakest level. Without a survey, the upper end divided by the lower end of the 90 % interval is "
        f"{rows['pgv_before'].median():.3g} for PGV and {rows['pga_before'].median():.3g} for PGA, and the arc of the "
        f"axis is 162° of 180°. With the default exponent {DIRECTION_LIKELIHOOD_EXPONENT:g}, "
        "the check whether any motion fits the survey "
        f"rejects {100 * (fits < MIN_FIT_P_VALUE).mean():.1f} % of {fits.size} tested surveys."
    )
    lines = [coverage_table_row(*part) for part in parts.items()]
    return {"backwards-coverage": f"{wrap_text(text)}\n\n{markdown_table(head, lines)}"}


def draw_ruin_motion_figure_and_return_markdown(threads: int) -> str:
    """Infer the motion from the example survey of a ruin, draw its figure, and return a Markdown list on the motion."""
    stones = read_counted_stones(RUIN_SURVEY_FILE)
    inversion = SurveyInversion(
        StoneOutcomeProbabilities(
            candidate_motions(),
            [StoneHeightAndSideRatios.from_stone_with_nearest_d_over_b(stone) for stone in stones],
            thread_count=threads,
        )
    )
    result = inversion.invert_survey(RUIN_SURVEY_FILE.name, stones)
    write_ground_motion_posterior_figure(result, ROOT / "docs" / "images" / "example-ruin.svg")
    p_value = result.goodness_of_fit_p_value
    fit = f"The check whether any motion of the library fits the survey has the p-value {p_value:.2g}."
    tree = parse_markdown_and_number_figures_and_tables(
        render_template_as_markdown(
            ResultsPrintedBySurveyCommands(inferred_motions=[inferred_motion_findings(result, stones)]),
            template_name="motions",
        )
    )
    return "\n".join(wrap_text(text, "- ") for text in (*plain_text_of_uncollapsed_paragraphs(tree), fit))


def main(
    parts: Annotated[list[str] | None, typer.Argument(help=f"{', '.join(SELECTABLE_PARTS)}; default: both")] = None,
    surveys: Annotated[int, typer.Option(min=20, help="number of surveys")] = DEFAULT_SURVEY_COUNT,
    threads: Annotated[int, typer.Option(min=1, help="number of threads")] = 2,
) -> None:
    """Simulate surveys, estimate their motions, and publish the tables."""
    named = named_parts_or_all_if_none(parts, SELECTABLE_PARTS)
    if "ruin" in named:
        update_marked_tables_and_sentences_in_docs(
            {"example-ruin": draw_ruin_motion_figure_and_return_markdown(threads)}
        )
    if "coverage" not in named:
        return
    rows = measure_interval_coverage(surveys, threads)
    write_csv(survey_rows_with_cross_validated_exponent(rows), RESULT_TABLE_FOLDER / "backwards-coverage.csv")
    update_marked_tables_and_sentences_in_docs(coverage_markdown_by_marker(rows))
    print(
        f"powers chosen on the other half: {choose_likelihood_exponent(rows[rows['half'] == 1])}, "
        f"{choose_likelihood_exponent(rows[rows['half'] == 0])}; "
        f"shipped {DIRECTION_LIKELIHOOD_EXPONENT}"
    )


if __name__ == "__main__":
    typer.run(main)
