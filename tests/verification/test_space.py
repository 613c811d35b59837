"""Bodies in space converge with the step."""

import pytest

from verification.space import convergence_order_and_errors_by_quantity

pytestmark = pytest.mark.long


def test_tilt_and_fall_azimuth_of_3d_bodies_converge_with_the_time_step() -> None:
    for name, (order, errors) in convergence_order_and_errors_by_quantity("centred").items():
        assert order >= 1.0, (name, order, errors)
        assert errors[0] < 1e-3, (name, errors)
