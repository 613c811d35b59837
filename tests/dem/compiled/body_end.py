"""End of a case of a 3-D body; called by Python."""

import numpy as np
from numba import njit

from overturning.dem.body.ending import body_has_fallen
from overturning.dem.body.state import BodyTerminationLimits
from overturning.dem.body.vectors import Quaternion, rotation_matrix
from overturning.kernel_cache import cache_compiled_kernel


@cache_compiled_kernel
@njit
def is_body_fallen_in_kernel(
    w: float, x: float, y: float, cosine_of_smallest_fall_tilt: float, fall_limits_by_lean_sector: np.ndarray
) -> bool:
    """True if the 3-D kernel counts a body as fallen that is rotated by the quaternion (w, x, y, 0).

    `fall_limits_by_lean_sector`: limits of the tilt by direction of the lean.
    """
    return bool(
        body_has_fallen(
            rotation_matrix(Quaternion(w, x, y, 0.0)),
            BodyTerminationLimits(0.0, 1.0, cosine_of_smallest_fall_tilt, 1.0, 0.0),
            fall_limits_by_lean_sector,
        )
    )
