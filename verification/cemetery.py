"""`python -m verification.cemetery`: compare computed fall rates with published ones and with published criteria.

Requires `results/near-fault` and `results/in-space` from `make run`. Writes sections of docs/surveys.md and
docs/criteria.md, and the accuracy of the 2-D model for 3-D stones.
"""

import shutil
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd
import xarray as xr

from overturning.arrays import FloatArray
from overturning.dem.run import run_cases
from overturning.figures.style import (
    FALL_COLOUR,
    INK,
    SERIES_COLOURS,
    add_title_and_legend,
    create_panel_grid,
    label_axes,
    use_package_matplotlib_settings,
)
from overturning.figures.write import save_figure_files
from overturning.findings.causes import skill_of_published_criteria
from overturning.findings.opening import open_study_results
from overturning.findings.population import population_findings
from overturning.findings.results import StudyResults
from overturning.findings.values import Estimate
from overturning.model.cases import Cases
from overturning.records.store import read_record_from_motion_file
from overturning.report.drawings import write_population_fall_rates_figure
from overturning.report.filters import format_percent
from overturning.statistics.space import (
    count_agreeing_and_differing_2d_3d_outcomes,
    shares_of_agreeing_2d_and_3d_outcomes,
)
from overturning.study.cube import open_cube
from overturning.study.load import load_study
from overturning.study.scenes import NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, record_motion_with_up_only_if_variant_uses_it
from overturning.study.sweep import scale_motion
from overturning.surveys.population import sample_stones
from verification.tables import (
    RESULT_TABLE_FOLDER,
    ROOT,
    MeasuredNumber,
    iterate_rows,
    markdown_table,
    update_marked_tables_and_sentences_in_docs,
    wrap_text,
    write_measured_numbers,
)

NEAR_FAULT_STUDY_RESULT_FOLDER: Final = ROOT / "results" / "near-fault"
PUBLISHED_FALL_RATES_FILE: Final = ROOT / "surveys" / "published.csv"


def read_published_fall_rates(path: Path = PUBLISHED_FALL_RATES_FILE) -> pd.DataFrame:
    """Read the table of published fall rates."""
    return pd.read_csv(path)


def fall_rates_percent_of_unscaled_records(findings: xr.Dataset) -> FloatArray:
    """Return the share of a population of gravestones that falls under each unscaled record, percent."""
    return np.asarray(100 * findings["fall_rate"].sel(amplitude=1.0).to_numpy())


def text_comparing_published_and_computed_rates(
    published_fall_rate_low_percent: float,
    published_fall_rate_high_percent: float,
    computed_fall_rate_percent_by_record: FloatArray,
) -> str:
    """State whether a published range of fall rates, percent, overlaps the interquartile range of computed rates."""
    least, most = np.quantile(computed_fall_rate_percent_by_record, [0.25, 0.75])
    if published_fall_rate_high_percent < least:
        return "below the middle half"
    if published_fall_rate_low_percent > most:
        return "above the middle half"
    return "overlaps"


def published_fall_rate_label(fall_rate_low_percent: float, fall_rate_high_percent: float) -> str:
    """Return the label of a published range of fall rates, percent; an end that is not known is NaN."""
    if np.isnan(fall_rate_low_percent):
        return f"at most {fall_rate_high_percent:g} %"
    if np.isnan(fall_rate_high_percent):
        return f"more than {fall_rate_low_percent:g} %"
    return (
        f"{fall_rate_low_percent:g} %"
        if fall_rate_low_percent == fall_rate_high_percent
        else f"{fall_rate_low_percent:g} to {fall_rate_high_percent:g} %"
    )


def published_fall_rate_table(
    published_fall_rates: pd.DataFrame, computed_fall_rate_percent_by_record: FloatArray
) -> str:
    """Return a Markdown table of published near-field fall rates, compared with the computed ones."""
    lines = []
    for row in iterate_rows(published_fall_rates[published_fall_rates["near_field"] == "yes"]):
        low, high = row.rate_low_percent, row.rate_high_percent
        ends = (0.0 if np.isnan(low) else low, 100.0 if np.isnan(high) else high)
        lines.append(
            (
                row.event,
                row.where,
                published_fall_rate_label(low, high),
                text_comparing_published_and_computed_rates(*ends, computed_fall_rate_percent_by_record),
                row.source,
            )
        )
    return markdown_table(("earthquake", "where", "stated", "compared with the computed rates", "source"), lines)


def computed_fall_rate_sentence(computed_fall_rate_percent_by_record: FloatArray, findings: xr.Dataset) -> str:
    """Return text with the median, interquartile range and extremes of the computed fall rates of the records."""
    rates = computed_fall_rate_percent_by_record
    low, middle, high = np.quantile(rates, [0.25, 0.5, 0.75])
    events = len(set(findings["event"].to_numpy().astype(str)))
    none, most = int((rates < 1).sum()), int((rates > 99).sum())
    return wrap_text(
        f"The computed fall rates under the {rates.size} near-field records of {events} earthquakes, at amplitude 1, "
        f"have a median of {middle:.0f} %; the middle half of the records gives {low:.0f} to {high:.0f} %, and all "
        f"records give {rates.min():.0f} to {rates.max():.0f} %. Less than 1 % of the stones fall under {none} of the "
        f"{rates.size} records, and more than 99 % fall under {most} of the records."
    )


def draw_published_and_computed_fall_rates(
    published_fall_rates: pd.DataFrame, computed_fall_rate_percent_by_record: FloatArray, path: Path
) -> None:
    """Draw published fall rates as bars, and computed ones as points below them."""
    near = list(iterate_rows(published_fall_rates[published_fall_rates["near_field"] == "yes"]))
    with use_package_matplotlib_settings():
        figure, panels = create_panel_grid(1, 1, 8.0, 0.32 * len(near) + 1.8)
        axes: Any = panels[0, 0]
        for place, row in enumerate(near[::-1], 1):
            low = 0.0 if np.isnan(row.rate_low_percent) else row.rate_low_percent
            high = 100.0 if np.isnan(row.rate_high_percent) else row.rate_high_percent
            axes.plot([low, high], [place, place], color=SERIES_COLOURS[0], linewidth=6, solid_capstyle="butt")
            if low == high:
                axes.plot(low, place, "o", color=SERIES_COLOURS[0])
        axes.plot(
            computed_fall_rate_percent_by_record,
            np.zeros(computed_fall_rate_percent_by_record.size),
            "|",
            color=FALL_COLOUR,
            markersize=13,
        )
        axes.plot(np.median(computed_fall_rate_percent_by_record), 0, "D", color=INK, markersize=5)
        names = [f"{row.event}: {row.where}" for row in near[::-1]]
        axes.set_yticks(range(len(near) + 1), ["computed, each near-field record (median)", *names])
        axes.set_xlim(-2, 102)
        axes.grid(True, axis="x")
        label_axes(axes, "fall rate, %", "")
        add_title_and_legend(figure, "Published and computed fall rates in the near field")
        save_figure_files(figure, path)


def draw_population_fall_rates_and_return_markdown(results: StudyResults) -> str:
    """Draw the figure of the population's fall rates for the docs, and return the rates as Markdown."""
    found = population_findings(results)
    assert found is not None
    write_population_fall_rates_figure(results, ROOT / "docs" / "images" / "fall-rate.svg")
    low, middle, high = (
        100 * (one or 0.0)
        for one in (
            found.lower_quartile_of_fall_rate_over_records,
            found.median_fall_rate,
            found.upper_quartile_of_fall_rate_over_records,
        )
    )
    rows = [
        (
            one.jma_degree,
            f"{100 * (one.median_fall_rate or 0.0):.0f} %",
            one.count.motions,
            one.count.records,
            one.count.earthquakes,
        )
        for one in found.median_fall_rate_by_jma_degree
    ]
    text = wrap_text(
        f"The median fall rate under the records at amplitude 1 is {middle:.0f} %; the middle half of the records "
        f"gives {low:.0f} to {high:.0f} %. The next table gives the median fall rate over records and amplitudes."
    )
    intensity_table = markdown_table(("JMA intensity", "median fall rate", "motions", "records", "earthquakes"), rows)
    return f"{text}\n\n{intensity_table}\n"


def estimate_with_interval_text(estimate: Estimate) -> str:
    """Return a label with an estimate and its interval, if it has one."""
    text = (
        f"{estimate.value:.2f}"
        if estimate.low is None
        else f"{estimate.value:.2f} ({estimate.low:.2f} to {estimate.high:.2f})"
    )
    return text.replace("-", "−")


def copy_criteria_figure_and_return_skill_tables(results: StudyResults) -> dict[str, str]:
    """Copy the figure of published criteria to the docs; return tables of their skill as Markdown, by marker."""
    found = skill_of_published_criteria(results)
    assert found is not None
    shutil.copy(NEAR_FAULT_STUDY_RESULT_FOLDER / "figures" / "plane.svg", ROOT / "docs" / "images" / "criteria.svg")
    rows = [
        (one.criterion, one.predicted_fall_condition, format_percent(one.hit_rate),
        format_percent(one.false_alarm_rate),
         estimate_with_interval_text(one.skill),
         estimate_with_interval_text(one.mean_skill_at_fixed_height_and_b_over_h))
        for one in found.scores
    ]  # fmt: skip
    heads = ("criterion", "a block falls if", "hits", "false alarms", "skill, all blocks", "skill, blocks of one size")
    leads = [
        (found.largest_skill_criterion, name, estimate_with_interval_text(lead))
        for name, lead in found.best_minus_other_skill_by_other_criterion.items()
    ]
    return {
        "criteria": markdown_table(heads, rows),
        "criteria-blocks": markdown_table(("criterion", "compared with", "difference of the skills"), leads),
    }


def text_comparing_grid_and_per_stone_fall_rates(results: StudyResults) -> str:
    """Return a text that compares fall rates from grid cells with those of individually simulated stones.

    For the rates from the grid, each stone takes the outcome of a neighbouring cell. For the other rates, each stone
    is simulated with its own height, B/H and µ.
    """
    found, population_ = (
        results.population_rates_by_variant[NAME_OF_STUDY_ITSELF_AMONG_VARIANTS],
        results.study.population,
    )
    assert population_ is not None
    stones, rates = sample_stones(population_), []
    planes = np.concatenate([stones.face_azimuth_deg, stones.face_azimuth_deg + 90])
    cases = Cases(planes, np.tile(stones.height, 2), np.tile(stones.b_over_h, 2), np.tile(stones.friction, 2))
    for name in results.record_ids_and_names:
        motion = record_motion_with_up_only_if_variant_uses_it(
            results.study, read_record_from_motion_file(NEAR_FAULT_STUDY_RESULT_FOLDER / "motion" / f"{name.id}.nc")
        )
        for factor in found["amplitude"].to_numpy():
            flags = run_cases(scale_motion(motion, float(factor)), cases, threads=2).overturned
            rates.append(float((np.abs(flags) == 1).reshape(2, -1).any(axis=0).mean()))
    computed = found["fall_rate"].to_numpy().ravel()
    apart = 100 * np.abs(np.array(rates) - computed)
    return (
        f"The mean fall rate under the {apart.size} motions (records × amplitudes) is computed in two ways. If each "
        "stone takes the outcome of a neighbouring cell of the grid, as in the report, the mean fall rate is "
        f"{100 * computed.mean():.1f} %. If each stone is simulated with its own height, B/H and µ, the mean fall "
        f"rate is {100 * np.mean(rates):.1f} %. For a single motion, the fall rate from the grid differs from the fall "
        f"rate of the stones' own simulations by {apart.mean():.1f} percentage points on average, and by at most "
        f"{apart.max():.0f} percentage points."
    )


def planar_model_accuracy_against_3d_model() -> list[MeasuredNumber]:
    """Return how often the 2-D model in the planes of the faces predicts the falls and edges of the 3-D model."""
    with open_cube(ROOT / "results" / "in-space" / "cube.nc", chunks={"record": 1}) as cube:
        found = {
            name: float(one)
            for name, one in shares_of_agreeing_2d_and_3d_outcomes(
                count_agreeing_and_differing_2d_3d_outcomes(cube)
            ).items()
        }
    beside = 100 * found["flag_beside"]
    return [
        MeasuredNumber("cases in space", int(found["cases"])),
        MeasuredNumber("2-D model predicts correctly whether it falls", 100 * found["flag"], "%"),
        MeasuredNumber(
            "2-D model predicts correctly whether it falls, a neighbour in B/H has another flag", beside, "%"
        ),
        MeasuredNumber("2-D model predicts another edge than the one it falls over", 100 * (1 - found["face"]), "%"),
    ]


def main() -> None:
    """Compare published and computed fall rates, draw the figures and publish the tables."""
    write_measured_numbers(planar_model_accuracy_against_3d_model(), RESULT_TABLE_FOLDER / "in-space.csv")
    study = load_study(ROOT / "config" / "near-fault.yaml")
    with open_study_results(NEAR_FAULT_STUDY_RESULT_FOLDER, study) as results:
        found = results.population_rates_by_variant[NAME_OF_STUDY_ITSELF_AMONG_VARIANTS]
        comparison = draw_population_fall_rates_and_return_markdown(results)
        update_marked_tables_and_sentences_in_docs(
            {"population": f"{comparison}\n{wrap_text(text_comparing_grid_and_per_stone_fall_rates(results), '- ')}"}
        )
        update_marked_tables_and_sentences_in_docs(copy_criteria_figure_and_return_skill_tables(results))
        rows, rates = read_published_fall_rates(), fall_rates_percent_of_unscaled_records(found)
        draw_published_and_computed_fall_rates(rows, rates, ROOT / "docs" / "images" / "published-surveys.svg")
        update_marked_tables_and_sentences_in_docs(
            {
                "published-surveys": published_fall_rate_table(rows, rates),
                "published-surveys-computed": computed_fall_rate_sentence(rates, found),
            }
        )


if __name__ == "__main__":
    main()
