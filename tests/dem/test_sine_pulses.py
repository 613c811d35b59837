"""One-cycle sine pulses against Housner's rocking block, solved event by event."""

import numpy as np
import pytest

from overturning.dem.run import run_cases
from overturning.model.cases import Cases
from overturning.model.status import Status
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from verification.reference.rocking import rocking_outcome

AMPLITUDES = np.linspace(0.8, 6.0, 40)
WIDTHS = [0.1, 0.2, 0.3, 0.4, 0.5]
HEIGHTS = [0.5, 1.0, 1.7, 2.5]
PERIODS = [0.3, 0.5, 0.7, 0.9, 1.2, 1.5, 2.0]
INTERVAL = 0.005


def pulse(period: float) -> np.ndarray:
    t = np.arange(round(period / INTERVAL) + 1) * INTERVAL
    return np.sin(2 * np.pi * t / period)


def test_flags_and_sides_of_pulses_agree_with_the_rocking_solution() -> None:
    robust = agree = 0
    for period in PERIODS:
        shape = pulse(period)
        axes = np.meshgrid(HEIGHTS, WIDTHS, AMPLITUDES, indexing="ij")
        height, ratio, share = (values.ravel() for values in axes)
        amplitude = share * ratio * STANDARD_GRAVITY
        expected = np.array(
            [
                [rocking_outcome(factor * a * shape, INTERVAL, h, r)[0] for factor in (0.99, 1.0, 1.01)]
                for h, r, a in zip(height, ratio, amplitude, strict=True)
            ]
        )
        found = run_cases(
            Motion(shape, 0 * shape, sampling_interval=INTERVAL), Cases(0.0, height, ratio, 10.0, amplitude=amplitude)
        )
        assert (found.status <= 1).all()
        firm = (expected == expected[:, :1]).all(axis=1)
        robust += int(firm.sum())
        agree += int((found.overturned == expected[:, 1])[firm].sum())
    assert robust >= 5000
    assert agree >= 0.999 * robust


@pytest.mark.parametrize("friction", [300.0, 1e3, 1e6])
def test_any_large_friction_is_that_of_a_block_that_cannot_slide(friction: float) -> None:
    shape, ratio = pulse(0.5), np.array([0.2, 0.3, 0.4, 0.45])
    height, ratio, share = (x.ravel() for x in np.meshgrid([0.3, 1.0], ratio, np.linspace(1.1, 6.0, 12), indexing="ij"))
    amplitude = share * ratio * STANDARD_GRAVITY
    wave = Motion(shape, 0 * shape, sampling_interval=INTERVAL)
    found = run_cases(wave, Cases(0.0, height, ratio, friction, amplitude=amplitude))
    assert found.status.tolist() == [Status.SIMULATED] * ratio.size
    factors = (0.97, 1.0, 1.03)
    expected = np.array(
        [
            [rocking_outcome(factor * a * shape, INTERVAL, h, r)[0] for factor in factors]
            for h, r, a in zip(height, ratio, amplitude, strict=True)
        ]
    )
    firm = (expected == expected[:, :1]).all(axis=1)
    assert np.unique(expected[firm]).size > 1
    assert (found.overturned == expected[:, 1])[firm].all()
