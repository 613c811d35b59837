"""West's and Ishiyama's limits."""

import math

import numpy as np
import pytest

from overturning.errors import ArgumentError
from overturning.statistics.limits import ishiyama_velocity, west_acceleration


def test_west() -> None:
    assert west_acceleration([0.1, 0.4]) == pytest.approx([0.980665, 3.92266])


def test_ishiyama_in_closed_form() -> None:
    height, slender = 1.0, 0.4
    alpha, radius = math.atan(slender), math.hypot(height, slender * height) / 2
    expected = 0.4 * math.sqrt(8 * 9.80665 * radius / 3 * (1 - math.cos(alpha)) / math.cos(alpha) ** 2)
    assert ishiyama_velocity(height, slender) == pytest.approx(expected)


def test_ishiyama_rule_of_thumb_for_slender_blocks() -> None:
    height_cm, width_cm = np.array([50.0, 100.0, 200.0]), np.array([5.0, 10.0, 20.0])
    cm_s = 100 * ishiyama_velocity(height_cm / 100, width_cm / height_cm)
    assert cm_s == pytest.approx(10 * width_cm / np.sqrt(height_cm), rel=0.04)


@pytest.mark.parametrize("value", [0.0, -0.1, math.nan, math.inf])
def test_refuses(value: float) -> None:
    with pytest.raises(ArgumentError, match="positive"):
        west_acceleration(value)
    with pytest.raises(ArgumentError, match="positive"):
        ishiyama_velocity(value, 0.4)
