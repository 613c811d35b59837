"""Checks that a figure has something to show; each error names the missing data and a remedy."""

import numpy as np
import xarray as xr

from overturning.errors import ArgumentError
from overturning.statistics.earthquakes import FallAlignmentWithReferences
from overturning.statistics.falls import overturning_indicator
from overturning.statistics.logistic import LEAST_PGA
from overturning.units import GAL


def check_outcomes(cube: xr.Dataset, figure_kind: str) -> None:
    """Raise an ArgumentError if no case of a cube has an outcome."""
    if not bool(overturning_indicator(cube).notnull().any()):
        count = f"none of the {cube['overturned'].size:,} cases has an outcome"
        raise ArgumentError(f"{figure_kind}: nothing to draw: {count}; `status` in the cube gives the cause of each")


def check_falls(cube: xr.Dataset, figure_kind: str) -> None:
    """Raise an ArgumentError if no case of a cube overturns."""
    check_outcomes(cube, figure_kind)
    falls = overturning_indicator(cube)
    if not bool((falls > 0).any()):
        count = f"none of the {int(falls.notnull().sum()):,} cases with an outcome overturns"
        raise ArgumentError(f"{figure_kind}: nothing to draw: {count}; choose stronger records, or smaller B/H")


def check_axes(cube: xr.Dataset, groups: dict[str, xr.Dataset]) -> None:
    """Raise an ArgumentError if no earthquake has falls and a known fault normal."""
    if any(bool(data["cosine"].notnull().any()) for data in groups.values()):
        return
    check_falls(cube, "axes")
    if not bool(cube["fault_normal"].notnull().any()):
        raise ArgumentError(
            "axes: nothing to draw: the fault strike of no record is known; enter fault_strike_deg in the record table "
            "and run the study again"
        )
    why = "no record with a known fault strike has falls"
    raise ArgumentError(f"axes: nothing to draw: {why}; use more records, or draw the figure rose")


def check_alignments(cube: xr.Dataset, alignments: dict[str, FallAlignmentWithReferences]) -> None:
    """Raise an ArgumentError if no record with falls has a reference to compare them with."""
    means = [mean.value for group in alignments.values() for of_part in group.means.values() for mean in of_part]
    if not np.isfinite(means).any():
        check_falls(cube, "follow")
        raise ArgumentError(
            "follow: nothing to draw: no record with falls has a known peak, pulse or fault strike; choose others"
        )


def check_plane(cube: xr.Dataset, measures: xr.Dataset) -> None:
    """Raise an ArgumentError if no azimuth has both an outcome and a motion."""
    check_outcomes(cube, "plane")
    check_motion(float(measures["pga"].max()), "plane")


def check_motion(peak_acceleration: float, figure_kind: str) -> None:
    """Raise an ArgumentError if the ground is at rest: its peak acceleration, m/s², does not exceed `LEAST_PGA`."""
    if not peak_acceleration > LEAST_PGA:
        raise ArgumentError(
            f"{figure_kind}: nothing to draw: the ground does not move (peak {peak_acceleration / GAL:.2g} Gal); "
            "choose another motion"
        )
