"""Blocks against the exact solution of Housner's rocking block, and against known outcomes for real records."""

import numpy as np
import pytest

from overturning.dem.block.rigid import simulate_rigid_rocking
from overturning.dem.run import run_cases
from overturning.dem.simulate import simulate_as_arrays
from overturning.model.cases import Cases
from overturning.model.contact import Contact
from overturning.model.results import CaseResults
from overturning.model.scene import gravestone
from overturning.model.status import CaseStatus
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from tests.dem.near_field import near_field_motion_and_fault_component_azimuths

INTERVAL = 0.005
OVERTURNING_RECORDS = {7: "Petrolia", 9: "Rinaldi", 10: "Sylmar Olive View"}


def sine_cycle(period: float) -> np.ndarray:
    """Return one cycle of a sine with amplitude 1."""
    t = np.arange(round(period / INTERVAL) + 1) * INTERVAL
    return np.sin(2 * np.pi * t / period)


def outcomes_housner_sides_and_robustness_mask(
    waveform: np.ndarray, axes: tuple[object, ...], friction: float, relative_amplitude_change: float
) -> tuple[CaseResults, np.ndarray, np.ndarray]:
    """Return the kernel's results, Housner's fall sides, and a mask of robust cases.

    `axes` are heights, B/H, and amplitudes over g·B/H; the cases are all their combinations. A case is robust if
    Housner's side does not change when the amplitude changes by ± `relative_amplitude_change`.
    """
    height, ratio, share = (values.ravel() for values in np.meshgrid(*axes, indexing="ij"))
    motion, amplitude = Motion(waveform, 0 * waveform, sampling_interval=INTERVAL), share * ratio * STANDARD_GRAVITY
    spreads = ((1 - relative_amplitude_change) * amplitude, amplitude, (1 + relative_amplitude_change) * amplitude)
    expected = np.array(
        [simulate_rigid_rocking(motion, Cases(0.0, height, ratio, friction, one)).overturned for one in spreads]
    )
    found = run_cases(motion, Cases(0.0, height, ratio, friction, amplitude))
    return found, expected[1], (expected == expected[1]).all(axis=0)


def test_falls_and_fall_sides_under_pulses_agree_with_the_rocking_solution() -> None:
    axes = [0.5, 1.0, 1.7, 2.5], [0.1, 0.2, 0.3, 0.4, 0.5], np.linspace(0.8, 6.0, 40)
    robust = agree = 0
    for period in (0.3, 0.5, 0.7, 0.9, 1.2, 1.5, 2.0):
        found, expected, firm = outcomes_housner_sides_and_robustness_mask(sine_cycle(period), axes, 10.0, 0.01)
        assert (found.status <= 1).all()
        robust += int(firm.sum())
        agree += int((found.overturned == expected)[firm].sum())
    assert robust >= 5000
    assert agree >= 0.999 * robust


@pytest.mark.parametrize("friction", [300.0, 1e3, 1e6])
def test_any_large_friction_gives_a_block_that_cannot_slide(friction: float) -> None:
    axes = [0.3, 1.0], [0.2, 0.3, 0.4, 0.45], np.linspace(1.1, 6.0, 12)
    found, expected, firm = outcomes_housner_sides_and_robustness_mask(sine_cycle(0.5), axes, friction, 0.03)
    assert (found.status == CaseStatus.SIMULATED).all()
    assert np.unique(expected[firm]).size > 1
    assert (found.overturned == expected)[firm].all()


@pytest.mark.parametrize("scheme", ["centred", "cundall"])
def test_peak_rotation_after_a_short_pulse_agrees_with_the_rocking_block(scheme: str) -> None:
    """The largest rotation may occur after the end of the record, while the block still rocks."""
    shape = np.append(sine_cycle(0.3), 0.0)
    height, ratio = np.array([2.28, 1.67, 1.91, 0.91]), np.array([0.134, 0.195, 0.273, 0.256])
    amplitude = np.array([3.2, 3.9, 4.2, 2.5]) * ratio * STANDARD_GRAVITY
    cases = Cases(0.0, height, ratio, 10.0, amplitude)
    short, long = (Motion(wave, 0 * wave, sampling_interval=INTERVAL) for wave in (shape, np.pad(shape, (0, 400))))
    found, longer = (run_cases(motion, cases, scheme=scheme) for motion in (short, long))
    assert found.overturned.tolist() == [0] * 4
    assert found.peak_rotation == pytest.approx(simulate_rigid_rocking(short, cases).peak_rotation, rel=0.02)
    assert found.peak_rotation == pytest.approx(longer.peak_rotation, rel=2e-5)


@pytest.mark.parametrize("damping_ratio", [0.5, 1.0])
@pytest.mark.parametrize("number", range(1, 15))
def test_three_pulse_records_overturn_in_fault_normal_component_only(number: int, damping_ratio: float) -> None:
    """Three of fourteen pulse records overturn B/H = 0.4, in the fault-normal component only."""
    motion, normal, parallel = near_field_motion_and_fault_component_azimuths(number)
    grid = {"azimuth_deg": [normal, parallel], "height": [0.6], "b_over_h": [0.39, 0.4, 0.42], "friction": [1.0]}
    found = simulate_as_arrays(motion, gravestone(Contact(damping_ratio=damping_ratio)), **grid)
    assert (found["status"] <= 1).all()
    falls = (found["overturned"] != 0)[:, 0, :, 0]
    assert falls.tolist() == [[number in OVERTURNING_RECORDS] * 3, [False] * 3]
