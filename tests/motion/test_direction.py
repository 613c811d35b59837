"""Differences of azimuths."""

import numpy as np
import pytest
import xarray as xr

from overturning.motion.direction import angle_between_azimuths


@pytest.mark.parametrize(
    ("first", "second", "apart"),
    [(10, 350, 20), (350, 10, 20), (0, 360, 0), (-170, 170, 20), (90, 270, 180), (0, 180, 180), (720, 45, 45)],
)
def test_azimuth_difference_is_measured_the_shorter_way_round(first: float, second: float, apart: float) -> None:
    assert angle_between_azimuths(first, second) == apart
    assert angle_between_azimuths(np.array([first, np.nan]), second)[0] == apart
    assert float(angle_between_azimuths(xr.DataArray([first]), float(second))[0]) == apart


def test_the_angle_between_directions_equals_that_of_their_unit_vectors() -> None:
    first, second = np.random.default_rng(1).uniform(-400.0, 400.0, (2, 200))
    cosine = np.cos(np.radians(first)) * np.cos(np.radians(second)) + np.sin(np.radians(first)) * np.sin(
        np.radians(second)
    )
    np.testing.assert_allclose(angle_between_azimuths(first, second), np.degrees(np.arccos(cosine)), atol=1e-5)
