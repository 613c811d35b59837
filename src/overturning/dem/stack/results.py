"""Conversion of the results of the stack kernel to outcome variables."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.model.status import CaseStatus


def stack_outcomes(
    results: NDArray[np.void], each: NDArray[np.void], orientation_deg: FloatArray, cosines: FloatArray
) -> dict[str, Any]:
    """Return the outcome variables and ``block_steps`` of n cases with k stones each, shape (n,) or (n, k).

    Parameters
    ----------
    results, each : ndarray
        Results of the cases, shape (n,), and of their stones, shape (n, k).
    orientation_deg : ndarray, shape (n,)
        Orientation of each case, degrees.
    cosines : ndarray, shape (n, 2)
        Direction cosines of the orientation, north and east.
    """
    with np.errstate(invalid="ignore", over="ignore"):
        fell = (results["status"] == CaseStatus.SIMULATED)[:, None] & (each["fallen"] > 0)
        azimuth = np.mod(orientation_deg[:, None] - _degrees(np.arctan2(each["top_y"], each["top_x"])), 360.0)
        lean = np.clip(each["lean"], 0.0, 2.0)
        sine = np.sqrt(np.minimum(lean, 2.0 - lean))
        tilt = np.where(lean <= 1.0, np.arcsin(sine), np.pi - np.arcsin(sine))
        north, east, x, y = cosines[:, :1], cosines[:, 1:], each["slip_x"], each["slip_y"]
        found = {
            "overturned": fell,
            "status": results["status"],
            "fall_azimuth": np.where(fell, azimuth, np.nan),
            "peak_tilt": _degrees(tilt),
            "overturning_time": np.where(fell, each["overturning_time"], np.nan),
            "residual_slip_north": np.where(fell, np.nan, x * north + y * east),
            "residual_slip_east": np.where(fell, np.nan, x * east - y * north),
            "residual_twist": np.where(fell, np.nan, -_degrees(each["twist"])),
            "slid_off": fell & (each["slid_off"] > 0),
            "peak_penetration": results["peak_penetration"],
            "energy_error": results["energy_error"],
            "block_steps": results["block_steps"],
            "samples_left_out": results["samples_left_out"],
        }
    if each.shape[1] > 1:
        return found
    return {name: values[:, 0] if np.ndim(values) == 2 else values for name, values in found.items()}


def _degrees(radians: FloatArray) -> FloatArray:
    """Convert radians to degrees, rounded: libm and SIMD versions differ in the last digit between processors."""
    return np.asarray(np.round(np.degrees(radians), 9))
