"""Bodies in space converge with the step."""

import pytest

from verification.space_order import orders


@pytest.mark.parametrize(("scheme", "least"), [("centred", 1.0)])
def test_tilt_and_azimuth_of_the_fall_converge(scheme: str, least: float) -> None:
    for name, (order, errors) in orders(scheme).items():
        assert order >= least, (name, order, errors)
        assert errors[0] < 2e-3, (name, errors)
