"""A study beside published values: peaks of the motion, and where a published finding holds."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from overturning.report.blocks import Column, Paragraph, Section, Table, number_columns, text_columns
from overturning.report.results import Results, reference_cube
from overturning.report.text import percent
from overturning.study.sections import Published
from overturning.units import CM, GAL

# How far a peak may lie from a published one whose processing is not known: each integration lets its choices in.
_PEAKS: Final = (
    ("pga", "pga_gal", "PGA, Gal", GAL, 0.01),
    ("pgv", "pgv_cm_s", "PGV, cm/s", CM, 0.05),
    ("pgd", "pgd_cm", "PGD, cm", CM, 0.20),
)


@dataclass(frozen=True)
class Finding:
    """Whether the published outcomes are found for one size of the block.

    Attributes
    ----------
    variant : str
        Contact setting.
    height, friction : float
        Height of the block, m, and friction coefficient.
    overturns : tuple of (bool or None)
        Whether the study's block overturns, for each published outcome; None: not found.
    holds : bool
        Whether every outcome is the published one.
    """

    variant: str
    height: float
    friction: float
    overturns: tuple[bool | None, ...]
    holds: bool


def published(results: Results) -> Section | None:
    """Peaks and findings beside the published ones; none where nothing was published."""
    if not results.study.published:
        return None
    findings = compare_findings(results)
    heads = (f"{_label(row)}: {_does(row.overturns)}" for row in results.study.published)
    return Section(
        "Beside the published values",
        (
            Paragraph(summary(findings)),
            Table(
                text_columns("component", "quantity")
                + number_columns("published", "found", "difference", "expected within")
                + text_columns(""),
                tuple(_peak_rows(results)),
            ),
            Table(
                (Column("contact", "text"), *number_columns("H, m", "µ"), *text_columns(*heads, "finding")),
                tuple(
                    (
                        *(row.variant, f"{row.height:g}", f"{row.friction:g}"),
                        *map(_does, row.overturns),
                        "holds" if row.holds else "does not hold",
                    )
                    for row in findings
                ),
            ),
        ),
        anchor="published",
    )


def _peak_rows(results: Results) -> list[tuple[str, ...]]:
    """Peaks along the published azimuths beside the published peaks."""
    ids = [name.id for name in results.names]
    rows: list[tuple[str, ...]] = []
    for row in results.study.published:
        measures = results.intensity.isel(record=ids.index(row.record)).sel(azimuth=row.azimuth)
        for name, key, quantity, unit, tolerance in _PEAKS:
            there = getattr(row, key)
            if there is not None:
                found = float(measures[name]) / unit
                difference = found / there - 1
                shown = f"{100 * difference:+.1f}\u00a0%".replace("-", "−")
                agrees = "agrees" if abs(difference) <= tolerance else "differs"
                rows.append((_label(row), quantity, f"{there:.1f}", f"{found:.1f}", shown, percent(tolerance), agrees))
    return rows


def compare_findings(results: Results) -> list[Finding]:
    """Published outcomes beside those of every contact setting, height and friction of the study."""
    ids = [name.id for name in results.names]
    rows = []
    for variant, elements in results.cubes.items():
        cube = reference_cube(results.study, variant, elements)
        # The published cells only: a cube larger than memory is not read.
        cells = [
            cube["overturned"]
            .isel(record=ids.index(row.record))
            .sel(azimuth=row.azimuth, b_over_h=row.b_over_h)
            .transpose("height", "friction")
            .to_numpy()
            for row in results.study.published
        ]
        there = tuple(row.overturns for row in results.study.published)
        for i, height in enumerate(cube["height"].to_numpy()):
            for j, friction in enumerate(cube["friction"].to_numpy()):
                found = tuple(None if np.isnan(cell[i, j]) else bool(cell[i, j] != 0) for cell in cells)
                rows.append(Finding(variant, float(height), float(friction), found, found == there))
    return rows


def summary(findings: list[Finding]) -> str:
    """Where the published finding holds, in one sentence per contact setting."""
    sentences = []
    for variant in dict.fromkeys(row.variant for row in findings):
        rows = [row for row in findings if row.variant == variant]
        holding = [row for row in rows if row.holds]
        sizes = ", ".join(f"{height:g}" for height in sorted({row.height for row in holding}))
        where = f"for H = {sizes} m" if holding else "for none of the sizes"
        sentences.append(
            f"With the {variant} contact the published outcomes are found {where} ({len(holding)} of {len(rows)})."
        )
    return " ".join(sentences)


def _does(overturns: bool | None) -> str:
    return "not found" if overturns is None else ("overturns" if overturns else "stands")


def _label(row: Published) -> str:
    return row.label or f"{row.record}, {row.azimuth:g}°"
