"""Conversion of the results of the stack kernel to outcome variables."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.body.results import degrees_rounded_to_9_decimals, tilt_deg_from_squared_sine
from overturning.model.status import CaseStatus


def outcome_variables_of_stacks(
    case_result_rows: NDArray[np.void],
    stone_result_rows: NDArray[np.void],
    orientation_azimuth_deg_by_case: FloatArray,
    orientation_unit_vector_north_east_by_case: FloatArray,
) -> dict[str, Any]:
    """Return the outcomes, and numbers of steps, of n cases with k stones each, by name, shape (n,) or (n, k).

    Parameters
    ----------
    case_result_rows, stone_result_rows : ndarray
        Results of the cases, shape (n,), and of their stones, shape (n, k).
    orientation_azimuth_deg_by_case : ndarray, shape (n,)
        Orientation of each case, degrees.
    orientation_unit_vector_north_east_by_case : ndarray, shape (n, 2)
        Direction cosines of the orientation, north and east.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        fell = (case_result_rows["status"] == CaseStatus.SIMULATED)[:, None] & (stone_result_rows["fallen"] > 0)
        azimuth = np.mod(
            orientation_azimuth_deg_by_case[:, None]
            - degrees_rounded_to_9_decimals(
                np.arctan2(
                    stone_result_rows["stone_axis_unit_vector_y_at_end"],
                    stone_result_rows["stone_axis_unit_vector_x_at_end"],
                )
            ),
            360.0,
        )
        north, east = (
            orientation_unit_vector_north_east_by_case[:, :1],
            orientation_unit_vector_north_east_by_case[:, 1:],
        )
        # From the axes of what the stone stands on at the end to those of the orientation.
        cosine, sine = stone_result_rows["support_twist_cosine"], stone_result_rows["support_twist_sine"]
        x = (
            cosine * stone_result_rows["slip_x_on_support_at_end"]
            - sine * stone_result_rows["slip_y_on_support_at_end"]
        )
        y = (
            sine * stone_result_rows["slip_x_on_support_at_end"]
            + cosine * stone_result_rows["slip_y_on_support_at_end"]
        )
        found = {
            "overturned": fell,
            "status": case_result_rows["status"],
            "fall_azimuth": np.where(fell, azimuth, np.nan),
            "peak_tilt": tilt_deg_from_squared_sine(stone_result_rows["peak_lean_as_continued_squared_sine"]),
            "overturning_time": np.where(fell, stone_result_rows["last_upright_time_if_fallen"], np.nan),
            "residual_slip_north": np.where(fell, np.nan, x * north + y * east),
            "residual_slip_east": np.where(fell, np.nan, x * east - y * north),
            "residual_twist": np.where(
                fell, np.nan, -degrees_rounded_to_9_decimals(stone_result_rows["twist_relative_to_support_rad"])
            ),
            "slid_off": fell & (stone_result_rows["slid_off_support"] > 0),
            "peak_penetration": case_result_rows["peak_penetration"],
            "energy_error": case_result_rows["energy_error"],
            "block_steps": case_result_rows["block_steps"],
            "samples_left_out": case_result_rows["samples_left_out"],
        }
    if stone_result_rows.shape[1] > 1:
        return found
    return {name: values[:, 0] if np.ndim(values) == 2 else values for name, values in found.items()}
