"""Bodies in space converge with the step."""

import numpy as np

from verification.space import orders

ROUNDING = np.radians(np.spacing(np.float32(360.0)))
"""Of an azimuth in single precision, rad: two that are rounded may differ by as much more than what they stand for."""


def test_tilt_and_azimuth_of_the_fall_converge() -> None:
    for name, (order, errors) in orders("centred").items():
        assert order >= 1.0 or (name == "fall_azimuth" and errors.max() <= 2 * ROUNDING), (name, order, errors)
        assert errors[0] < 1e-3, (name, errors)
