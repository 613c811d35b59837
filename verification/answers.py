"""`python -m verification.answers`: write the table of the findings of the shipped studies into README.md.

Requires the results of the studies in `ROW_FUNCTION_BY_STUDY` and of config/fine-map.yaml, from `make run STUDY=…`.
"""

import shutil
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Final

from overturning.figures.svg_translation import translate_svg
from overturning.findings.collect import Findings, findings
from overturning.findings.values import Estimate
from overturning.report.filters import (
    format_estimate_with_interval,
    format_number,
    format_percent,
    format_share_with_interval,
)
from overturning.study.load import load_study
from verification.tables import ROOT, markdown_table, update_marked_tables_and_sentences_in_docs

DOCS_IMAGE_FOLDER: Final = ROOT / "docs" / "images"
"""Folder of the images of README.md and README.ja.md."""

QuantityValueTextAndEarthquakeCount = tuple[str, str, int]
"""Quantity, its value with its 95 % interval, and the number of earthquakes."""

STUDY_NAME_BY_MAP_IMAGE: Final = {"rinaldi.svg": "fine-map", "rinaldi-in-space.svg": "in-space"}
"""Image in docs/images → study whose map of the Rinaldi record it shows."""


def _finding_row(
    quantity: str, estimate: Estimate, *, as_percentage: bool = False
) -> QuantityValueTextAndEarthquakeCount:
    """Return a table row with an estimate and its interval; no interval if there are too few earthquakes."""
    digits = 1 if estimate.value is not None and estimate.value < 0.1 else 0
    shown = (
        format_share_with_interval(estimate, digits, word_between_ends=" to ")
        if as_percentage
        else format_estimate_with_interval(estimate, word_between_ends=" to ")
    )
    return quantity, shown, estimate.earthquake_count


def _short_name_of_pulse_group(group_name: str) -> str:
    """Return “no pulse” or “velocity pulse” as the name of a group of records in the table of findings."""
    return "no pulse" if group_name.startswith("without") else "velocity pulse"


def _fault_normal_alignment_rows(study_findings: Findings) -> Iterator[QuantityValueTextAndEarthquakeCount]:
    """Yield a row for each group of records: alignment of the falls with the fault normal."""
    for group in study_findings.direction.groups:
        yield _finding_row(
            f"alignment with the fault normal, {_short_name_of_pulse_group(group.record_group)}",
            group.mean_cos_2_angle_to_fault_normal,
        )


def _fall_alignment_with_pgv_and_fault_normal_rows(
    study_findings: Findings,
) -> Iterator[QuantityValueTextAndEarthquakeCount]:
    """Yield rows for each group of records: alignment of the falls with the peak velocity and with the fault normal."""
    for group in study_findings.reference_alignments:
        axes = {one.reference: one for one in group.references if one.axis_or_direction == "axis"}
        for name in ("peak velocity", "fault normal"):
            yield _finding_row(
                f"alignment with the {name}, {_short_name_of_pulse_group(group.record_group)}",
                axes[name].alignment_over_all_b_over_h,
            )


def _rows_comparing_falls_in_study_and_variant(
    study_findings: Findings,
) -> Iterator[QuantityValueTextAndEarthquakeCount]:
    """Yield rows on falls in the study only, in its primary variant only, and in the same direction in both."""
    (one,) = (each for each in study_findings.contrasts if each.is_primary_comparison)
    yield _finding_row(
        f"falls in “{study_findings.study.name}” only", one.share_overturned_only_in_study, as_percentage=True
    )
    yield _finding_row(f"falls in “{one.variant}” only", one.share_overturned_only_in_variant, as_percentage=True)
    if one.share_within_45_deg_of_each_other_if_both_fall.value is not None:
        yield _finding_row(
            "falls the same way, where it falls in both",
            one.share_within_45_deg_of_each_other_if_both_fall,
            as_percentage=True,
        )


ROW_FUNCTION_BY_STUDY: Final[dict[str, Callable[[Findings], Iterator[QuantityValueTextAndEarthquakeCount]]]] = {
    "near-fault": _fault_normal_alignment_rows,
    "in-space": _fall_alignment_with_pgv_and_fault_normal_rows,
    "three-tier": _rows_comparing_falls_in_study_and_variant,
    "stack-3d": _rows_comparing_falls_in_study_and_variant,
    "waiau": _rows_comparing_falls_in_study_and_variant,
}


def write_japanese_copy_of_figure(path: Path) -> None:
    """Write a copy of a figure with Japanese texts for README.ja.md, as NAME.ja.svg next to NAME.svg."""
    translated = translate_svg(path.read_text(encoding="utf-8"), "ja")
    path.with_suffix(".ja.svg").write_text(translated, encoding="utf-8")


def stack_fall_slip_and_twist_table(study_findings: Findings) -> str:
    """Return a table of falls, slip and twist of each stone of the stack and of its variants."""
    shares = {(one.variant, one.element): one.share_overturned for one in study_findings.element_outcomes}
    lines = [
        (
            one.scene,
            one.element,
            format_percent(shares[one.variant, one.element]),
            format_percent(one.share_of_falls_by_sliding_off),
            format_number(one.percentile_90_slip_if_standing_cm, 1),
            format_number(one.percentile_90_abs_twist_if_standing_deg, 1),
        )
        for one in study_findings.element_displacements
    ]
    return markdown_table(
        ("scene", "stone", "cases with a fall", "of these, slid off", "slip, cm", "twist, degrees"), lines
    )


def main() -> None:
    """Write the table of findings into README.md and copy the maps of the studies, also with Japanese texts."""
    lines, stack = [], ""
    for name, rows in ROW_FUNCTION_BY_STUDY.items():
        study = load_study(ROOT / "config" / f"{name}.yaml")
        question = f"{study.question} ([{name}](config/{name}.yaml))"
        found = findings(ROOT / "results" / name, study)
        stack = stack_fall_slip_and_twist_table(found) if found.element_displacements else stack
        for quantity, value, earthquakes in rows(found):
            lines.append((question, quantity, value, earthquakes))
            question = ""
    for picture, study_name in STUDY_NAME_BY_MAP_IMAGE.items():
        drawn: Path = ROOT / "results" / study_name / "figures" / "polar" / "rinaldi.svg"
        shutil.copyfile(drawn, DOCS_IMAGE_FOLDER / picture)
        write_japanese_copy_of_figure(DOCS_IMAGE_FOLDER / picture)
    table = markdown_table(("question", "quantity", "result (95 % interval)", "earthquakes"), lines)
    update_marked_tables_and_sentences_in_docs({"found": table, "stack-3d": stack})


if __name__ == "__main__":
    main()
