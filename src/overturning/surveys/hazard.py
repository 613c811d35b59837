"""Hazard and fragility curves, and their files."""

import math
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BaseModel, Field
from scipy.special import log_ndtr, ndtr

from overturning.arrays import FloatArray
from overturning.errors import ResultError
from overturning.tables import read_table_rows

CAPACITY_POINTS_IN_STANDARD_DEVIATIONS: Final = np.linspace(-6.0, 6.0, 241)
"""Integration points for the capacity of a stone relative to its class, in standard deviations."""


MIN_LOG_SPREAD: Final = 1e-3
"""Smallest logarithmic spread of a fragility curve; smaller values are replaced by it."""


HIGHEST_HAZARD_LEVEL_RANGE_AND_OTHER_UNIT_BY_UNIT: Final = {
    "g": (0.05, 20.0, 981.0, "Gal"),
    "cm/s": (10.0, 2000.0, 0.01, "m/s"),
}
"""By unit: least and largest plausible highest level of a hazard curve, and the likely other unit: how many of it make
one of this unit, and its name."""


class FragilityCurveParametersRow(BaseModel, extra="forbid"):
    """Row of the table ``fragility.csv``: parameters of the fragility curve of one class of stones."""

    stones: str
    measure: str
    unit: str
    median: float
    median_low: float = math.nan
    median_high: float = math.nan
    log_spread: float = math.nan
    least: float = 0.0
    most: float = math.inf
    record_spread: float = math.nan
    other_spread: float = math.nan
    id: str = ""


class HazardCurveRow(BaseModel, extra="forbid"):
    """Row of a hazard table: an intensity level, and the annual rate at which shaking exceeds it."""

    measure: str
    unit: str
    level: float = Field(gt=0, allow_inf_nan=False)
    annual_rate: float = Field(gt=0, allow_inf_nan=False)


@dataclass(frozen=True)
class HazardCurve:
    """Hazard curve: annual rates at which intensity levels are exceeded, interpolated by power laws between levels.

    Attributes
    ----------
    measure, unit : str
        Intensity measure and its unit.
    intensity_levels, annual_exceedance_rates : ndarray, shape (n,)
        Ascending levels and their annual rates of exceedance, 1/year.
    """

    measure: str
    unit: str
    intensity_levels: FloatArray
    annual_exceedance_rates: FloatArray

    def interpolate_annual_exceedance_rates(self, at_intensity_levels: ArrayLike) -> FloatArray:
        """Return the annual rates, 1/year, at which shaking exceeds given intensity levels, by interpolation."""
        x, ln_rates = np.log(self.intensity_levels), np.log(self.annual_exceedance_rates)
        return np.asarray(np.exp(np.interp(np.log(at_intensity_levels), x, ln_rates)))

    def annual_fall_rate(
        self,
        fragility_medians: ArrayLike,
        log_spread: float,
        lowest_level: float = 0.0,
        highest_level: float = math.inf,
    ) -> FloatArray:
        """Compute annual rates of falls, 1/year, due to shaking between two levels, for several fragility medians.

        With the level x, exceedance rate ν and fall probability P = Φ(z), z = ln(x/m)/β (median m, spread β), the
        rate is ∫ P |dν| = P ν at the lower end − P ν at the upper end + ∫ ν dP. Where ν is a power law
        a x^−k, ∫ ν dP is exactly the difference of a m^−k exp(k²β²/2) Φ(z + kβ) between its ends
        (completing the square; Cornell, Jalayer, Hamburger & Foutch 2002, Journal of Structural Engineering 128, 526,
        for a single power law).

        Parameters
        ----------
        fragility_medians : array_like, shape (m,)
            Medians of lognormal fragility curves, in the unit of the levels.
        log_spread : float
            Standard deviation of the natural logarithm of the level at which a stone falls.
        lowest_level, highest_level : float
            Ends of the range of levels, in the same unit.

        Returns
        -------
        ndarray, shape (m,)
            Rate, 1/year; 0 if the range does not overlap with the levels of the hazard curve.
        """
        first_level = max(lowest_level, float(self.intensity_levels[0]))
        last_level = min(highest_level, float(self.intensity_levels[-1]))
        if first_level >= last_level:
            return np.zeros(np.size(fragility_medians))
        between = (self.intensity_levels > first_level) & (self.intensity_levels < last_level)
        level = np.concatenate([[first_level], self.intensity_levels[between], [last_level]])
        x, rate = np.log(level), np.log(self.interpolate_annual_exceedance_rates(level))
        m, log_spread = np.log(np.atleast_1d(fragility_medians))[:, None], max(log_spread, MIN_LOG_SPREAD)
        k = -np.diff(rate) / np.diff(x)
        below, above = ((x[part] - m) / log_spread + k * log_spread for part in (slice(None, -1), slice(1, None)))
        below, above = np.where(below > 0, -above, below), np.where(below > 0, -below, above)  # where Φ keeps digits
        inside = log_ndtr(above) + np.log1p(-np.exp(log_ndtr(below) - log_ndtr(above)))
        parts = np.exp(rate[:-1] + k * x[:-1] - k * m + 0.5 * (k * log_spread) ** 2 + inside)
        first, last = (ndtr((x[end] - m[:, 0]) / log_spread) * np.exp(rate[end]) for end in (0, -1))
        return np.asarray(first - last + parts.sum(axis=1))


def hazard_unit_warning(hazard_curve: HazardCurve) -> str:
    """Return a warning if the highest intensity of a hazard curve is implausible in its unit; else "".

    The warning names the likely unit. Hazard curves end where exceedance is very rare, at 0.05 to 20 g, or 10 to
    2000 cm/s. The highest level lies above this range if the levels are in a unit smaller by a factor of 100 or more,
    and below if they are in a larger one.
    """
    low, high, factor, other = HIGHEST_HAZARD_LEVEL_RANGE_AND_OTHER_UNIT_BY_UNIT.get(
        hazard_curve.unit, (0.0, math.inf, 1.0, "")
    )
    top = float(hazard_curve.intensity_levels[-1])
    if low <= top <= high:
        return ""
    meant = f"; are they in {other}? Divide them by {factor:g}" if low <= top / factor <= high else ""
    return (
        f"{hazard_curve.measure}: levels of {hazard_curve.intensity_levels[0]:g} to {top:g} {hazard_curve.unit}, of "
        f"which the highest is expected between {low:g} and {high:g} {hazard_curve.unit}{meant}"
    )


def read_fragility_curves(path: Path) -> list[FragilityCurveParametersRow]:
    """Read the fragility curves in a table ``fragility.csv``; raise a ResultError if the table is invalid."""
    return [
        row
        for _, row in read_table_rows(
            path, FragilityCurveParametersRow, delimiter=",", error_class=ResultError, table_kind="fragility table"
        )
    ]


def read_hazard_curves_by_intensity_measure(path: Path) -> dict[str, HazardCurve]:
    """Read hazard curves from a table; return them by intensity measure.

    A ResultError is raised if levels do not ascend, or rates grow with the level.
    """
    rows: dict[str, list[tuple[int, HazardCurveRow]]] = {}
    for line, row in read_table_rows(
        path, HazardCurveRow, delimiter=",", error_class=ResultError, table_kind="hazard table"
    ):
        rows.setdefault(row.measure, []).append((line, row))
    found = {}
    for measure, of_measure in rows.items():
        for (_, before), (line, row) in pairwise(of_measure):
            if row.level <= before.level or row.annual_rate > before.annual_rate or row.unit != before.unit:
                raise ResultError(
                    f"{path} line {line}: {measure} {row.level:g} {row.unit}, {row.annual_rate:g}/year after "
                    f"{before.level:g} {before.unit}, {before.annual_rate:g}/year; give ascending levels of one unit "
                    "with rates that do not grow"
                )
        if len(of_measure) < 2:
            raise ResultError(f"{path}: {measure} has one level; give two or more")
        level, rate = (np.array([getattr(row, of) for _, row in of_measure]) for of in ("level", "annual_rate"))
        found[measure] = HazardCurve(measure, of_measure[0][1].unit, level, rate)
    if not found:
        raise ResultError(f"{path}: no level; write one row per level below the header")
    return found
