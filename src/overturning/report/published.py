"""A study beside published values: peaks of the motion, and where a published finding holds."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np

from overturning.study.config import Study
from overturning.study.cube import open_cube
from overturning.study.scenes import NOMINAL, variant_names
from overturning.study.sections import Published
from overturning.units import CM, GAL

if TYPE_CHECKING:
    import xarray as xr

# How far a peak may lie from a published one whose processing is not known: each integration lets its choices in.
_PEAKS: Final = (
    ("pga", "pga_gal", "PGA, Gal", GAL, 0.01),
    ("pgv", "pgv_cm_s", "PGV, cm/s", CM, 0.05),
    ("pgd", "pgd_cm", "PGD, cm", CM, 0.20),
)


@dataclass(frozen=True)
class PeakComparison:
    """One peak beside the published one.

    Attributes
    ----------
    component, quantity : str
        What is compared, with its unit.
    published, found, difference, tolerance : float
        Values; difference and tolerance as shares of the published value.
    """

    component: str
    quantity: str
    published: float
    found: float
    difference: float
    tolerance: float

    @property
    def within(self) -> bool:
        """Whether the difference is within the tolerance."""
        return abs(self.difference) <= self.tolerance


@dataclass(frozen=True)
class FindingComparison:
    """Whether the published outcomes are found for one size of the block.

    Attributes
    ----------
    variant : str
        Contact setting.
    height, friction : float
        Height of the block, m, and friction coefficient.
    outcomes : tuple of (str, bool, bool or None)
        Component, whether it overturns according to the publication, and according to the study (None: not found).
    """

    variant: str
    height: float
    friction: float
    outcomes: tuple[tuple[str, bool, bool | None], ...]

    @property
    def holds(self) -> bool:
        """Whether every outcome is the published one."""
        return all(published == found for _, published, found in self.outcomes)


def compare_peaks(study: Study, intensity: "xr.Dataset") -> list[PeakComparison]:
    """Peaks along the published azimuths beside the published peaks."""
    ids = [str(name) for name in intensity["record_id"].to_numpy()]
    rows = []
    for row in study.published:
        measures = intensity.isel(record=ids.index(row.record)).sel(azimuth=row.azimuth)
        for name, key, quantity, unit, tolerance in _PEAKS:
            published = getattr(row, key)
            if published is not None:
                found = float(measures[name]) / unit
                rows.append(PeakComparison(_label(row), quantity, published, found, found / published - 1, tolerance))
    return rows


def compare_findings(study: Study, results: Path) -> list[FindingComparison]:
    """Published outcomes beside those of every contact setting, height and friction of the study."""
    rows = []
    for variant in variant_names(study) if study.published else ():
        with open_cube(
            results / ("cube.nc" if variant == NOMINAL else f"cube.{variant}.nc"), chunks={"record": 1}
        ) as cube:
            ids = [str(name) for name in cube["record_id"].to_numpy()]
            # The published cells only: a cube larger than memory is not read.
            cells = [
                cube["overturned"]
                .isel(record=ids.index(row.record))
                .sel(azimuth=row.azimuth, b_over_h=row.b_over_h)
                .transpose("height", "friction")
                .to_numpy()
                for row in study.published
            ]
            for i, height in enumerate(cube["height"].to_numpy()):
                for j, friction in enumerate(cube["friction"].to_numpy()):
                    outcomes = tuple(
                        (_label(row), row.overturns, None if np.isnan(values[i, j]) else bool(values[i, j] != 0))
                        for row, values in zip(study.published, cells, strict=True)
                    )
                    rows.append(FindingComparison(variant, float(height), float(friction), outcomes))
    return rows


def summary(findings: list[FindingComparison]) -> str:
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


def _label(row: Published) -> str:
    return row.label or f"{row.record}, {row.azimuth:g}°"
