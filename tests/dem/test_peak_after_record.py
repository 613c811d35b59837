"""The largest rotation may come after a record that ends while the block rocks."""

import numpy as np
import pytest

from overturning.dem.run import run_cases
from overturning.model.cases import Cases
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from verification.reference.rocking import rocking_outcome


@pytest.mark.parametrize("scheme", ["centred", "cundall"])
def test_peak_rotation_after_a_short_pulse_is_that_of_the_rocking_block(scheme: str) -> None:
    interval, period = 0.005, 0.3
    time = np.arange(62) * interval
    pulse = np.where(time <= period, np.sin(2 * np.pi * time / period), 0.0)
    height, ratio = np.array([2.28, 1.67, 1.91, 0.91]), np.array([0.134, 0.195, 0.273, 0.256])
    amplitude = np.array([3.2, 3.9, 4.2, 2.5]) * ratio * STANDARD_GRAVITY
    motion = Motion(pulse, 0 * pulse, sampling_interval=interval)
    found = run_cases(motion, Cases(0.0, height, ratio, 10.0, amplitude), scheme=scheme)
    exact = [rocking_outcome(a * pulse, interval, h, r)[1] for a, h, r in zip(amplitude, height, ratio, strict=True)]
    assert found.overturned.tolist() == [0] * 4
    assert found.peak_rotation == pytest.approx(exact, rel=0.02)
    padded = Motion(np.pad(pulse, (0, 400)), np.zeros(462), sampling_interval=interval)
    longer = run_cases(padded, Cases(0.0, height, ratio, 10.0, amplitude), scheme=scheme)
    assert found.peak_rotation == pytest.approx(longer.peak_rotation, rel=2e-5)
