"""Bodies in space converge with the step."""

import pytest

from verification.space import convergence_orders_and_median_errors

pytestmark = pytest.mark.long


def test_tilt_and_fall_azimuth_of_3d_bodies_converge_with_the_time_step() -> None:
    for name, (order, errors) in convergence_orders_and_median_errors("centred").items():
        assert order >= 1.0, (name, order, errors)
        assert errors[0] < 1e-3, (name, errors)
