"""`python -m verification.soft_ground`: write the effect of soft ground (config/soft-ground.yaml) into the docs.

Requires `results/soft-ground`, from `make soil run STUDY=config/soft-ground.yaml`.
"""

from typing import Final

import pandas as pd

from overturning.findings.opening import open_study_results
from overturning.findings.results import StudyResults
from overturning.findings.soil import (
    SoilProfileFallRatesAtAmplitude,
    notes_on_unconverged_soil_analyses,
    population_fall_rates_by_soil_and_amplitude,
)
from overturning.study.load import load_study
from overturning.study.scenes import NAME_OF_STUDY_ITSELF_AMONG_VARIANTS, settings_changed_by_variant
from overturning.units import STANDARD_GRAVITY
from verification.tables import (
    RESULT_TABLE_FOLDER,
    ROOT,
    markdown_table,
    update_marked_tables_and_sentences_in_docs,
    wrap_text,
    write_csv,
)

SOFT_GROUND_STUDY_RESULT_FOLDER: Final = ROOT / "results" / "soft-ground"


def fall_rate_and_axis_table_by_ground(results: StudyResults) -> pd.DataFrame:
    """Return a table of fall rate and fall axis for each record, ground and amplitude."""
    rows = []
    for ground_name, found in results.population_rates_by_variant.items():
        table = found[["fall_rate", "fall_axis", "fall_resultant"]].to_dataframe().reset_index()
        table.insert(0, "ground", "rock" if ground_name == NAME_OF_STUDY_ITSELF_AMONG_VARIANTS else ground_name)
        rows.append(table.drop(columns=["record", "event"], errors="ignore"))
    return pd.concat(rows)


def soil_fundamental_periods_text(results: StudyResults) -> str:
    """Return the fundamental periods, s, of the soil columns of the study's variants as text, in their order."""
    found = []
    for name in results.study.variants:
        site = settings_changed_by_variant(results.study, name).site
        if site is not None:
            found.append(4 * sum(one.thickness_m / one.velocity_m_s for one in site.layers))
    return ", ".join(f"{one:.2f} s" for one in found)


def ground_name(rates: SoilProfileFallRatesAtAmplitude) -> str:
    """Return a name for a ground: its layers from the surface down, or "rock" without layers."""
    layers = (f"{layer.thickness_m:g} m of soil ({layer.shear_wave_velocity_m_s:g} m/s)" for layer in rates.layers)
    return " over ".join(layers) or "rock"


def markdown_by_marker(results: StudyResults) -> dict[str, str]:
    """Return tables and sentences on soft ground as Markdown, by marker."""
    found, failed = population_fall_rates_by_soil_and_amplitude(results), notes_on_unconverged_soil_analyses(results)
    rows, answers = [], []
    for one in found:
        turned = (
            "–"
            if one.median_angle_to_fall_axis_without_soil_deg is None
            else f"{one.median_angle_to_fall_axis_without_soil_deg:.0f}° "
            f"({one.records_with_fall_axis_with_and_without_soil})"
        )
        fall_rates = [f"{100 * (rate or 0.0):.0f} %" for rate in (one.mean_fall_rate, one.median_fall_rate)]
        pga = (one.median_pga_m_s2 or 0.0) / STANDARD_GRAVITY
        rows.append(
            (
                f"{one.amplitude_factor:g}",
                ground_name(one),
                f"{pga:.2f}",
                *fall_rates,
                one.records_with_at_least_half_fallen,
                turned,
            )
        )
        if one.amplitude_factor == 1.0:
            text = f"On the ground “{ground_name(one)}”, the mean fall rate over all records is {fall_rates[0]}."
            if one.median_angle_to_fall_axis_without_soil_deg is not None:
                text += (
                    f" The axis of the falls on “{ground_name(one)}” differs from the axis on rock by "
                    f"{one.median_angle_to_fall_axis_without_soil_deg:.0f}° (median over "
                    f"{one.records_with_fall_axis_with_and_without_soil} records)."
                )
            answers.append(text)
    heads = ("factor", "ground", "PGA, g, median", "fall rate, mean", "median", "records with half or more")
    text = (
        f"The equivalent-linear computation did not converge for {len(failed)} of the surface motions. The "
        "fundamental periods of the soil layers at small strain are "
        f"{soil_fundamental_periods_text(results)} (in the order of "
        "the table of fall rates)."
    )
    return {
        "soft-ground": markdown_table((*heads, "axis turned, median (records)"), rows),
        "soft-ground-answer": wrap_text(" ".join(answers)),
        "soft-ground-convergence": wrap_text(text),
    }


def main() -> None:
    """Write verification/results/soft-ground.csv, and the tables and sentences on soft ground into the docs."""
    study = load_study(ROOT / "config" / "soft-ground.yaml")
    with open_study_results(SOFT_GROUND_STUDY_RESULT_FOLDER, study) as results:
        write_csv(fall_rate_and_axis_table_by_ground(results), RESULT_TABLE_FOLDER / "soft-ground.csv")
        update_marked_tables_and_sentences_in_docs(markdown_by_marker(results))


if __name__ == "__main__":
    main()
