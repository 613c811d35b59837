"""Checks that a figure has something to show; each error names the missing data and a remedy."""

from collections.abc import Sequence

import numpy as np
import xarray as xr

from overturning.errors import ArgumentError
from overturning.model.plane_weights import azimuths_in_results_bias_mean_fall_axis
from overturning.motion.motion import Accelerogram
from overturning.statistics.earthquakes import mean_fall_directions_and_axes_by_record
from overturning.statistics.logistic import MAX_PGA_FROM_ROUNDING_M_S2
from overturning.statistics.opposite_azimuths import overturning_indicator
from overturning.statistics.reference_directions import MeanFallAlignmentByBOverH
from overturning.units import GAL


def check_is_results_cube(cube: object, figure_function_name: str) -> None:
    """Raise an ArgumentError unless the argument of a figure function is a results cube, a dataset with outcomes."""
    if isinstance(cube, xr.Dataset) and "overturned" in cube and "time" not in cube.dims:
        return
    what = "a dataset without outcomes by case" if isinstance(cube, xr.Dataset) else f"a {type(cube).__name__}"
    motion = "; time_histories and spectra draw a motion" if isinstance(cube, Accelerogram) else ""
    raise ArgumentError(
        f"{figure_function_name}: {what}; give a cube of overturning.open_cube or run_study, "
        f"or outcomes of simulate{motion}"
    )


def check_has_outcomes(cube: xr.Dataset, figure_description: str) -> None:
    """Raise an ArgumentError if no case in a results cube has an outcome, since the figure would be empty."""
    if not bool(overturning_indicator(cube).notnull().any()):
        count = f"none of the {cube['overturned'].size:,} cases has an outcome"
        raise ArgumentError(
            f"{figure_description}: nothing to draw: {count}; `status` in the cube gives the cause of each"
        )


def check_has_falls(cube: xr.Dataset, figure_description: str) -> None:
    """Raise an ArgumentError if no case in a results cube overturns, since the figure would be empty."""
    check_has_outcomes(cube, figure_description)
    falls = overturning_indicator(cube)
    if not bool((falls > 0).any()):
        count = f"none of the {int(falls.notnull().sum()):,} cases with an outcome overturns"
        raise ArgumentError(f"{figure_description}: nothing to draw: {count}; choose stronger records, or smaller B/H")


def check_has_falls_and_fault_normal(cube: xr.Dataset, fall_axes_by_group: dict[str, xr.Dataset]) -> None:
    """Raise an ArgumentError if no earthquake with a known fault normal has falls, since the figure would be empty."""
    if any(bool(data["cosine"].notnull().any()) for data in fall_axes_by_group.values()):
        return
    check_has_falls(cube, "axes")
    if not bool(cube["fault_normal"].notnull().any()):
        raise ArgumentError(
            "axes: nothing to draw: the fault strike of no record is known; enter fault_strike_deg in the record table "
            "and run the study again"
        )
    if azimuths_in_results_bias_mean_fall_axis(cube):
        raise ArgumentError(
            "axes: nothing to draw: the planes are one, or a sector of the circle, so their axis is that of the falls; "
            "give azimuths of a range of 180°, or draw the figure rose"
        )
    if bool(mean_fall_directions_and_axes_by_record(cube)["is_imposed"].any()):
        raise ArgumentError(
            "axes: nothing to draw: the unknown outcomes are spread unevenly over the circle, so the axis of the falls "
            "is that of the other azimuths; `status` in the cube gives the cause of each"
        )
    why = "no record with a known fault strike has falls"
    raise ArgumentError(f"axes: nothing to draw: {why}; use more records, or draw the figure rose")


def check_has_fall_alignment(
    cube: xr.Dataset, alignment_with_references_by_group: dict[str, MeanFallAlignmentByBOverH]
) -> None:
    """Raise an ArgumentError if no alignment of falls with a reference is known, since the figure would be empty."""
    means = [
        mean.mean
        for group in alignment_with_references_by_group.values()
        for of_part in group.cosines_per_b_over_h_by_reference_and_axial.values()
        for mean in of_part
    ]
    if not np.isfinite(means).any():
        check_has_falls(cube, "follow")
        raise ArgumentError(
            "follow: nothing to draw: no record with falls has a known peak, pulse or fault strike; choose others"
        )


def check_has_outcomes_and_nonzero_motion(cube: xr.Dataset, intensity_measures: xr.Dataset) -> None:
    """Raise an ArgumentError if no case of a results cube has an outcome, or if all its input motions are zero."""
    check_has_outcomes(cube, "plane")
    check_ground_moves(float(intensity_measures["pga"].max()), "plane")


def check_are_trajectories_in_2d(trajectories: Sequence[xr.Dataset]) -> None:
    """Raise an ArgumentError unless there are datasets, all of them 2-D results of `overturning.trajectory`."""
    if not trajectories:
        raise ArgumentError("rotation_slip_and_uplift: no trajectory; give datasets of overturning.trajectory")
    for one in trajectories:
        if not (isinstance(one, xr.Dataset) and "time" in one.dims):
            what = "outcomes without a time axis" if isinstance(one, xr.Dataset) else f"a {type(one).__name__}"
            raise ArgumentError(f"rotation_slip_and_uplift: {what}; give datasets of overturning.trajectory")
        if "kind" not in one:
            raise ArgumentError(
                "rotation_slip_and_uplift: a 3-D trajectory; overturning one --body --response draws its axis"
            )


def check_ground_moves(peak_acceleration: float, figure_description: str) -> None:
    """Raise an ArgumentError if the ground does not move: its peak acceleration, m/s², is zero within rounding."""
    if not peak_acceleration > MAX_PGA_FROM_ROUNDING_M_S2:
        raise ArgumentError(
            f"{figure_description}: nothing to draw: the ground does not move (peak {peak_acceleration / GAL:.2g} Gal)"
            "; choose another motion"
        )
