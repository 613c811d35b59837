"""Azimuths of peaks, and the axis of the strongest pulse, of motions made for it."""

import numpy as np
import pytest

from overturning.motion.heading import peak_azimuths, pulse_axis
from overturning.motion.motion import Motion


@pytest.mark.parametrize("azimuth", [0.0, 33.0, 90.0, 145.0, 260.0])
def test_axis_and_period_of_a_pulse_are_found_under_noise(azimuth: float) -> None:
    time = np.arange(0, 20, 0.01)
    velocity = np.exp(-(((time - 8.0) / 0.8) ** 2)) * np.cos(2 * np.pi * (time - 8.0) / 2.0 + 1.0)
    noise = np.cumsum(np.random.default_rng(2).normal(size=(2, time.size)), axis=1) * 2e-4
    angle = np.radians(azimuth)
    along = np.stack([velocity * np.cos(angle), velocity * np.sin(angle)]) + noise
    motion = Motion(*np.gradient(along, 0.01, axis=1), sampling_interval=0.01)
    axis, period = pulse_axis(motion)
    assert abs((axis - azimuth + 90) % 180 - 90) < 3
    assert period == pytest.approx(2.0, rel=0.15)


def test_peaks_point_where_the_vector_is_largest() -> None:
    north, east = np.zeros(200), np.zeros(200)
    north[50], east[50], north[120] = -3.0, 4.0, 4.9
    towards = peak_azimuths(Motion(north, east, sampling_interval=0.01))
    assert towards["pga"] == pytest.approx(np.degrees(np.arctan2(4.0, -3.0)))
    still = Motion(np.zeros(10), np.zeros(10), sampling_interval=0.01)
    assert np.isnan(peak_azimuths(still)["pgv"])
    assert np.isnan(pulse_axis(still)[0])
