"""Conversion of the results of the stack kernel to outcome variables."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.body.results import degrees_rounded_to_9_decimals, tilt_deg_from_squared_sine
from overturning.model.status import CaseStatus


def outcome_variables_of_stacks(
    results: NDArray[np.void],
    stone_results: NDArray[np.void],
    orientation_deg: FloatArray,
    direction_cosines: FloatArray,
) -> dict[str, Any]:
    """Return the outcomes, and numbers of steps, of n cases with k stones each, by name, shape (n,) or (n, k).

    Parameters
    ----------
    results, stone_results : ndarray
        Results of the cases, shape (n,), and of their stones, shape (n, k).
    orientation_deg : ndarray, shape (n,)
        Orientation of each case, degrees.
    direction_cosines : ndarray, shape (n, 2)
        Direction cosines of the orientation, north and east.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        fell = (results["status"] == CaseStatus.SIMULATED)[:, None] & (stone_results["fallen"] > 0)
        azimuth = np.mod(
            orientation_deg[:, None]
            - degrees_rounded_to_9_decimals(
                np.arctan2(stone_results["stone_axis_y_at_end"], stone_results["stone_axis_x_at_end"])
            ),
            360.0,
        )
        north, east = direction_cosines[:, :1], direction_cosines[:, 1:]
        # From the axes of what the stone stands on at the end to those of the orientation.
        cosine, sine = stone_results["support_twist_cosine"], stone_results["support_twist_sine"]
        x = cosine * stone_results["slip_x_on_support_at_end"] - sine * stone_results["slip_y_on_support_at_end"]
        y = sine * stone_results["slip_x_on_support_at_end"] + cosine * stone_results["slip_y_on_support_at_end"]
        found = {
            "overturned": fell,
            "status": results["status"],
            "fall_azimuth": np.where(fell, azimuth, np.nan),
            "peak_tilt": tilt_deg_from_squared_sine(stone_results["peak_lean_squared_sine"]),
            "overturning_time": np.where(fell, stone_results["last_upright_time_if_fallen"], np.nan),
            "residual_slip_north": np.where(fell, np.nan, x * north + y * east),
            "residual_slip_east": np.where(fell, np.nan, x * east - y * north),
            "residual_twist": np.where(
                fell, np.nan, -degrees_rounded_to_9_decimals(stone_results["twist_relative_to_support_rad"])
            ),
            "slid_off": fell & (stone_results["slid_off_support"] > 0),
            "peak_penetration": results["peak_penetration"],
            "energy_error": results["energy_error"],
            "block_steps": results["block_steps"],
            "samples_left_out": results["samples_left_out"],
        }
    if stone_results.shape[1] > 1:
        return found
    return {name: values[:, 0] if np.ndim(values) == 2 else values for name, values in found.items()}
