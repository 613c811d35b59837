import numpy as np
import pytest

from overturning.errors import ArgumentError
from overturning.motion.intensity import intensity_by_azimuth
from overturning.motion.motion import Motion


def test_a_sine_has_the_peaks_of_calculus():
    """A = A sin ωt from rest: v = A/ω (1 − cos ωt), PGV 2A/ω; d = A/ω t − A/ω² sin ωt, at one period 2πA/ω²."""
    amplitude, period = 3.0, 1.0
    omega = 2 * np.pi / period
    time = np.arange(0, 1.0005, 0.001)
    motion = Motion(amplitude * np.sin(omega * time), np.zeros_like(time), sampling_interval=0.001)
    found = intensity_by_azimuth(motion, [0, 60, 90, 180])
    np.testing.assert_allclose(found.pga, amplitude * np.array([1, 0.5, 0, 1]), atol=1e-9)
    np.testing.assert_allclose(found.pgv, 2 * amplitude / omega * np.array([1, 0.5, 0, 1]), rtol=1e-5)
    np.testing.assert_allclose(found.pgd, 2 * np.pi * amplitude / omega**2 * np.array([1, 0.5, 0, 1]), rtol=1e-4)
    assert found.pga.attrs["units"] == "m s-2"
    assert found.azimuth.attrs["units"] == "degree"


def test_opposite_azimuths_have_the_same_peaks_bit_for_bit():
    random = np.random.default_rng(1)
    motion = Motion(random.normal(size=300), random.normal(size=300), sampling_interval=0.01)
    azimuths = np.arange(0, 180)
    for name in ("pga", "pgv", "pgd"):
        np.testing.assert_array_equal(
            intensity_by_azimuth(motion, azimuths)[name], intensity_by_azimuth(motion, azimuths + 180)[name]
        )


@pytest.mark.parametrize("azimuths", [[], [[0, 1]], [np.nan]])
def test_senseless_azimuths_are_refused(azimuths):
    with pytest.raises(ArgumentError, match="azimuth_deg"):
        intensity_by_azimuth(Motion([0, 1], [0, 1], sampling_interval=1), azimuths)
