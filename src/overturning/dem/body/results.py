"""What came of cases in space: names, types and meanings, and how the kernel's numbers become them."""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.model.status import Status
from overturning.model.variables import INT8_MISSING, SPACE_VARIABLES


@dataclass(frozen=True)
class SpaceResults:
    """What came of each case, shape (n,), named and typed like `SPACE_VARIABLES`; `block_steps` is the work done."""

    overturned: NDArray[np.int8]
    status: NDArray[np.int8]
    fall_azimuth: NDArray[np.float32]
    fall_face: NDArray[np.int8]
    peak_tilt: NDArray[np.float32]
    overturning_time: NDArray[np.float32]
    peak_slip: NDArray[np.float32]
    residual_slip_north: NDArray[np.float32]
    residual_slip_east: NDArray[np.float32]
    residual_twist: NDArray[np.float32]
    peak_penetration: NDArray[np.float32]
    energy_error: NDArray[np.float32]
    angular_momentum_error: NDArray[np.float32]
    block_steps: NDArray[np.int64]

    @classmethod
    def at_rest(cls, count: int) -> Self:
        """Results of cases none of which moves."""
        arrays = {item.name: np.zeros(count, item.dtype) for item in SPACE_VARIABLES}
        arrays["status"][:], arrays["fall_face"][:] = Status.AT_REST, INT8_MISSING
        arrays["fall_azimuth"][:] = arrays["overturning_time"][:] = np.nan
        return cls(**arrays, block_steps=np.zeros(count, np.int64))

    def taken(self, rows: NDArray[np.int64]) -> Self:
        """Results of some of the cases."""
        return type(self)(**{name: values[rows] for name, values in vars(self).items()})

    def store(
        self, chosen: NDArray[np.int64], out: NDArray[np.void], orientation: FloatArray, cosines: FloatArray, faces: list[FloatArray]
    ) -> None:  # fmt: skip
        """Put in what the kernel found for the chosen cases.

        `orientation` (degrees), its `cosines` (north, east) and the normals of the `faces` are those of each chosen case.
        """
        status = out["status"].astype(np.int8)
        w, x, y, z = (out[name] for name in ("qw", "qx", "qy", "qz"))
        top_x, top_y = 2.0 * (x * z + w * y), 2.0 * (y * z - w * x)
        with np.errstate(invalid="ignore", over="ignore"):
            answered = status == Status.SIMULATED
            fell = answered & (out["fallen"] > 0)
            # x points to the orientation, y 90° anticlockwise of it.
            azimuth = np.mod(orientation - _degrees(np.arctan2(top_y, top_x)), 360.0)
            lean = np.clip(out["lean"], 0.0, 2.0)
            sine = np.sqrt(np.minimum(lean, 2.0 - lean))
            tilt = np.where(lean <= 1.0, np.arcsin(sine), np.pi - np.arcsin(sine))
            twist = np.mod(_degrees(-2.0 * np.arctan2(z, w)) + 180.0, 360.0) - 180.0
            slip_x, slip_y = out["slip_x"], out["slip_y"]
            values = {
                "overturned": np.where(answered, fell, INT8_MISSING),
                "status": status,
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
            }
            for name, column in values.items():
                getattr(self, name)[chosen] = column


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
