"""How the numbers of the kernel in space become the variables of an outcome."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.model.status import Status
from overturning.model.variables import INT8_MISSING


def answers_of(
    out: NDArray[np.void], orientation: FloatArray, cosines: FloatArray, faces: list[FloatArray]
) -> dict[str, Any]:
    """Values of the variables, and ``block_steps``, by what the kernel found of cases.

    `orientation` (degrees), its `cosines` (north, east) and the normals of the `faces` are those of each case.
    """
    w, x, y, z = (out[name] for name in ("qw", "qx", "qy", "qz"))
    top_x, top_y = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x)
    with np.errstate(invalid="ignore", over="ignore"):
        answered = out["status"] == Status.SIMULATED
        fell = answered & (out["fallen"] > 0)
        # x points to the orientation, y 90° anticlockwise of it.
        azimuth = np.mod(orientation - _degrees(np.arctan2(top_y, top_x)), 360.0)
        lean = np.clip(out["lean"], 0.0, 2.0)
        sine = np.sqrt(np.minimum(lean, 2.0 - lean))
        tilt = np.where(lean <= 1.0, np.arcsin(sine), np.pi - np.arcsin(sine))
        twist = np.mod(_degrees(-2.0 * np.arctan2(z, w)) + 180.0, 360.0) - 180.0
        slip_x, slip_y = out["slip_x"], out["slip_y"]
        return {
            "overturned": fell,
            "status": out["status"],
            "fall_azimuth": np.where(fell, azimuth, np.nan),
            "fall_face": [
                _lowest(side, one) if is_down and len(side) else INT8_MISSING
                for side, one, is_down in zip(faces, np.stack([w, x, y, z], axis=1), fell, strict=True)
            ],
            "peak_tilt": _degrees(tilt),
            "overturning_time": np.where(fell, out["time"], np.nan),
            "peak_slip": out["slip"],
            "residual_slip_north": slip_x * cosines[:, 0] + slip_y * cosines[:, 1],
            "residual_slip_east": slip_x * cosines[:, 1] - slip_y * cosines[:, 0],
            "residual_twist": np.where(fell, np.nan, twist),
            "peak_penetration": out["depth"],
            "energy_error": out["energy"],
            "angular_momentum_error": out["spin"],
            "block_steps": out["steps"],
            "samples_left_out": out["left_out"],
        }


def _degrees(angle: FloatArray) -> FloatArray:
    """Degrees, rounded: libm and SIMD versions differ in the last digit between processors."""
    return np.asarray(np.round(np.degrees(angle), 9))


def _lowest(faces: FloatArray, quaternion: FloatArray) -> int:
    """The face whose normal points most nearly down."""
    w, x, y, z = quaternion
    down = -(
        2.0 * (x * z - w * y) * faces[:, 0]
        + 2.0 * (y * z + w * x) * faces[:, 1]
        + (1.0 - 2.0 * (x * x + y * y)) * faces[:, 2]
    )
    return int(np.argmax(np.round(down, 9)))
