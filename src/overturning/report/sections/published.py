"""A study beside published values: peaks of the motion, and where a published finding holds."""

from typing import Final

import numpy as np

from overturning.report.blocks import Paragraph, Section, Table
from overturning.report.results import Results
from overturning.report.text import percent
from overturning.study.sections import Published
from overturning.units import CM, GAL

# How far a peak may lie from a published one whose processing is not known: each integration lets its choices in.
_PEAKS: Final = (
    ("pga", "pga_gal", "PGA, Gal", GAL, 0.01),
    ("pgv", "pgv_cm_s", "PGV, cm/s", CM, 0.05),
    ("pgd", "pgd_cm", "PGD, cm", CM, 0.20),
)


def published(results: Results) -> Section | None:
    """Peaks and findings beside the published ones; none where nothing was published."""
    there = results.study.published
    if not there:
        return None
    rows, sentences = [], []
    for variant in results.cubes:
        found = outcomes(results, variant)
        holding = {size for size, overturns in found.items() if overturns == tuple(row.overturns for row in there)}
        heights = ", ".join(f"{height:g}" for height in sorted({height for height, _ in holding}))
        where = f"for H = {heights} m" if holding else "for none of the sizes"
        count = f"({len(holding)} of {len(found)})"
        sentences.append(f"With the {variant} contact the published outcomes are found {where} {count}.")
        for size, overturns in found.items():
            holds = "holds" if size in holding else "does not hold"
            rows.append((variant, *(f"{value:g}" for value in size), *map(_does, overturns), holds))
    heads = (f"{_label(row)}: {_does(row.overturns)}" for row in there)
    findings = Table(("contact", "H, m", "µ", *heads, "finding"), tuple(rows), "tnn" + "t" * (len(there) + 1))
    return Section(
        "Beside the published values",
        (Paragraph(" ".join(sentences)), _peaks(results), findings),
        anchor="published",
    )


def _peaks(results: Results) -> Table:
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
    heads = ("component", "quantity", "published", "found", "difference", "expected within", "")
    return Table(heads, tuple(rows), "ttnnnnt")


def outcomes(results: Results, variant: str) -> dict[tuple[float, float], tuple[bool | None, ...]]:
    """Whether the block overturns where something was published, None where it is not known, by height and friction."""
    cube, ids = results.reference_cube(variant), [name.id for name in results.names]
    # The published cells only: a cube larger than memory is not read.
    cells = [
        cube["overturned"]
        .isel(record=ids.index(row.record))
        .sel(azimuth=row.azimuth, b_over_h=row.b_over_h)
        .transpose("height", "friction")
        .to_numpy()
        for row in results.study.published
    ]
    return {
        (float(height), float(friction)): tuple(
            None if np.isnan(cell[i, j]) else bool(cell[i, j] != 0) for cell in cells
        )
        for i, height in enumerate(cube["height"].to_numpy())
        for j, friction in enumerate(cube["friction"].to_numpy())
    }


def _does(overturns: bool | None) -> str:
    return "not found" if overturns is None else ("overturns" if overturns else "stands")


def _label(row: Published) -> str:
    return row.label or f"{row.record}, {row.azimuth:g}°"
