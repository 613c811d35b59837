"""Conversion of the 3-D kernel's results to outcome variables."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.model.status import CaseStatus
from overturning.model.variables import INT8_MISSING, MAX_FACE_COUNT_OF_BODY_WITH_NUMBERED_FACES


def outcome_variables_of_bodies(
    case_result_rows: NDArray[np.void],
    orientation_azimuth_deg_by_case: FloatArray,
    orientation_unit_vector_north_east_by_case: FloatArray,
    face_normals_at_rest_by_case: list[FloatArray],
) -> dict[str, Any]:
    """Return the outcomes of n cases by variable name, each of shape (n,), and ``block_steps``: numbers of time steps.

    Parameters
    ----------
    case_result_rows : ndarray
        Results of the kernel, of type `overturning.dem.body.tables.RESULT_TABLE_DTYPE`, shape (n,).
    orientation_azimuth_deg_by_case : ndarray
        Orientation of each case, degrees, shape (n,).
    orientation_unit_vector_north_east_by_case : ndarray
        Direction cosines of the orientation, north and east, shape (n, 2).
    face_normals_at_rest_by_case : list of ndarray
        Outward normals of the faces of the body at rest, one array of shape (faces, 3) per case.
    """
    w, x, y, z = (case_result_rows[name] for name in ("qw_at_end", "qx_at_end", "qy_at_end", "qz_at_end"))
    top_x, top_y = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x)
    with np.errstate(invalid="ignore", over="ignore"):
        answered = case_result_rows["status"] == CaseStatus.SIMULATED
        fell = answered & (case_result_rows["fallen"] > 0)
        # x points towards the orientation, y 90° anticlockwise from it.
        azimuth = np.mod(
            orientation_azimuth_deg_by_case - degrees_rounded_to_9_decimals(np.arctan2(top_y, top_x)), 360.0
        )
        twist = np.mod(degrees_rounded_to_9_decimals(-2.0 * np.arctan2(z, w)) + 180.0, 360.0) - 180.0
        slip_x, slip_y = case_result_rows["slip_x_at_end"], case_result_rows["slip_y_at_end"]
        return {
            "overturned": fell,
            "status": case_result_rows["status"],
            "fall_azimuth": np.where(fell, azimuth, np.nan),
            "fall_face": [
                _index_of_most_downward_face(side, one)
                if is_down and 0 < len(side) <= MAX_FACE_COUNT_OF_BODY_WITH_NUMBERED_FACES
                else INT8_MISSING
                for side, one, is_down in zip(
                    face_normals_at_rest_by_case, np.stack([w, x, y, z], axis=1), fell, strict=True
                )
            ],
            "peak_tilt": tilt_deg_from_squared_sine(case_result_rows["peak_lean_as_continued_squared_sine"]),
            "overturning_time": np.where(fell, case_result_rows["last_upright_time_if_fallen"], np.nan),
            "peak_slip": case_result_rows["peak_slip"],
            "residual_slip_north": slip_x * orientation_unit_vector_north_east_by_case[:, 0]
            + slip_y * orientation_unit_vector_north_east_by_case[:, 1],
            "residual_slip_east": slip_x * orientation_unit_vector_north_east_by_case[:, 1]
            - slip_y * orientation_unit_vector_north_east_by_case[:, 0],
            "residual_twist": np.where(fell, np.nan, twist),
            "peak_penetration": case_result_rows["peak_penetration"],
            "energy_error": case_result_rows["energy_error"],
            "angular_momentum_error": case_result_rows["vertical_angular_momentum_error_ratio"],
            "block_steps": case_result_rows["block_steps"],
            "samples_left_out": case_result_rows["samples_left_out"],
        }


def tilt_deg_from_squared_sine(squared_sine_or_two_minus_it: FloatArray) -> FloatArray:
    """Return the tilt in degrees from a lean: sin² of the tilt up to 90°, 2 − sin² of the tilt beyond."""
    squared_sine_or_two_minus_it = np.clip(squared_sine_or_two_minus_it, 0.0, 2.0)
    angle = np.arcsin(np.sqrt(np.minimum(squared_sine_or_two_minus_it, 2.0 - squared_sine_or_two_minus_it)))
    return degrees_rounded_to_9_decimals(np.where(squared_sine_or_two_minus_it <= 1.0, angle, np.pi - angle))


def degrees_rounded_to_9_decimals(angles_rad: FloatArray) -> FloatArray:
    """Convert radians to degrees, rounded to 9 decimals, because the last digits differ between processors."""
    return np.asarray(np.round(np.degrees(angles_rad), 9))


def _index_of_most_downward_face(face_normals_at_rest: FloatArray, rest_to_final_quaternion_wxyz: FloatArray) -> int:
    """Return the index of the face that points most nearly down after the body is rotated by the given quaternion."""
    w, x, y, z = rest_to_final_quaternion_wxyz
    down = -(
        2.0 * (x * z - w * y) * face_normals_at_rest[:, 0]
        + 2.0 * (y * z + w * x) * face_normals_at_rest[:, 1]
        + (1.0 - 2.0 * (x * x + y * y)) * face_normals_at_rest[:, 2]
    )
    return int(np.argmax(np.round(down, 9)))
