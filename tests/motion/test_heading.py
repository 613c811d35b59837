"""Azimuths of peaks and axis of the strongest pulse, for synthetic motions and records."""

import numpy as np
import pytest

from overturning.motion.heading import (
    azimuths_of_peak_acceleration_and_velocity,
    daubechies_wavelet_values,
    strongest_pulse_axis_deg_and_period_s,
)
from overturning.motion.motion import Motion
from tests.dem.near_field import near_field_motion_and_fault_component_azimuths


@pytest.mark.parametrize("azimuth", [0.0, 33.0, 90.0, 145.0, 260.0])
def test_axis_and_period_of_a_velocity_pulse_are_found_in_noise(azimuth: float) -> None:
    time = np.arange(0, 20, 0.01)
    velocity = np.exp(-(((time - 8.0) / 0.8) ** 2)) * np.cos(2 * np.pi * (time - 8.0) / 2.0 + 1.0)
    noise = np.cumsum(np.random.default_rng(2).normal(size=(2, time.size)), axis=1) * 2e-4
    angle = np.radians(azimuth)
    along = np.stack([velocity * np.cos(angle), velocity * np.sin(angle)]) + noise
    motion = Motion(*np.gradient(along, 0.01, axis=1), sampling_interval=0.01)
    axis, period = strongest_pulse_axis_deg_and_period_s(motion)
    assert abs((axis - azimuth + 90) % 180 - 90) < 3
    assert period == pytest.approx(2.0, rel=0.15)


def test_pulse_wavelet_values_match_pywavelets_db4() -> None:
    """Values are those of `Wavelet("db4")` in PyWavelets 1.9; energy is 1, moments and shifted products are 0."""
    wavelet, x = daubechies_wavelet_values(), np.arange(1793) / 256
    known = {1.5: 0.0449, 2.5: -0.0465, 3.0: -0.8872, 3.5: 1.0437, 4.0: -0.3975, 4.5: 0.0616, 5.5: 0.0026}
    assert np.interp(list(known), x, wavelet) == pytest.approx(list(known.values()), abs=5e-4)
    assert np.trapezoid(wavelet**2, x) == pytest.approx(1.0, abs=1e-6)
    assert [np.trapezoid(x**k * wavelet, x) for k in range(4)] == pytest.approx([0] * 4, abs=1e-4)
    assert [np.sum(wavelet[256 * k :] * wavelet[: -256 * k]) / 256 for k in (1, 2, 3)] == pytest.approx(
        [0] * 3, abs=1e-6
    )


@pytest.mark.parametrize(
    ("number", "axis", "period"), [(3, 85.73, 3.08), (16, 8.71, 0.79), (21, 80.57, 0.79), (28, 54.19, 12.0)]
)
def test_pulse_axes_match_a_wavelet_convolution_in_the_time_domain(number: int, axis: float, period: float) -> None:
    """Reference: PyWavelets' db4 convolved in time with the velocity; only samples at least 0.04 s apart are used."""
    found = strongest_pulse_axis_deg_and_period_s(
        near_field_motion_and_fault_component_azimuths(number, pulse=number < 15)[0]
    )
    assert abs((found[0] - axis + 90) % 180 - 90) < 0.2
    assert found[1] == pytest.approx(period, rel=0.01)


def test_azimuth_of_peak_acceleration_points_along_the_largest_motion_vector() -> None:
    north, east = np.zeros(200), np.zeros(200)
    north[50], east[50], north[120] = -3.0, 4.0, 4.9
    towards = azimuths_of_peak_acceleration_and_velocity(Motion(north, east, sampling_interval=0.01))
    assert towards["pga"] == pytest.approx(np.degrees(np.arctan2(4.0, -3.0)))
    still = Motion(np.zeros(10), np.zeros(10), sampling_interval=0.01)
    assert np.isnan(azimuths_of_peak_acceleration_and_velocity(still)["pgv"])
    assert np.isnan(strongest_pulse_axis_deg_and_period_s(still)[0])
