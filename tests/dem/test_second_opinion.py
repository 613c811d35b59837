"""The lane-parallel kernel against a plain scalar one written from the equations."""

import numpy as np
import pytest

from overturning.dem.cases import Cases
from overturning.dem.contact import Contact
from overturning.dem.run import run_cases
from overturning.motion.motion import Motion
from tests.dem.near_field import near_field
from tests.dem.second_opinion import scalar_outcomes


def grid(azimuths: int) -> Cases:
    axes = (np.arange(azimuths) * 180.0 / azimuths, [0.6, 1.2], [0.1, 0.2, 0.3, 0.4, 0.5], [0.33, 0.58, 1.0])
    return Cases(*(values.ravel() for values in np.meshgrid(*axes, indexing="ij")))


@pytest.mark.parametrize("scheme", ["centred", "cundall"])
@pytest.mark.parametrize(("number", "pulse"), [(7, True), (10, True), (15, False)])
def test_flags_and_peak_rotation_equal_the_scalar_kernel(scheme: str, number: int, pulse: bool) -> None:
    motion, _, _ = near_field(number, pulse)
    cases = grid(4)
    fast = run_cases(motion, cases, scheme=scheme, leave_out=False)
    plain = scalar_outcomes(motion, cases, scheme=scheme)
    assert (fast.status == 0).all()
    # Rounding differs, and a rocking block amplifies it: a handful of cells per thousand may part.
    same = fast.overturned == plain[:, 0]
    assert same.mean() >= 0.99
    stands = same & (fast.overturned == 0)
    difference = np.abs(fast.peak_rotation - plain[:, 1])[stands]
    assert np.median(difference) < 1e-7
    assert (difference < 1e-4).mean() > 0.95
    slip = np.abs(fast.peak_slip - plain[:, 2])[stands]
    assert np.median(slip) < 1e-8
    assert (slip < 1e-5).mean() > 0.95


@pytest.mark.parametrize("contact", [Contact(damping_ratio=0.1), Contact(stiffness_ratio=0.3), Contact(stiffness=1e7)])
def test_other_contacts_and_vertical_motion_equal_the_scalar_kernel(contact: Contact) -> None:
    t = np.arange(300) * 0.01
    pulse = np.sin(2 * np.pi * t / 0.8) * (t < 1.6)
    motion = Motion(3.0 * pulse, 1.0 * pulse, 2.0 * np.sin(7.0 * t) * (t < 2), sampling_interval=0.01)
    cases = grid(2)
    fast = run_cases(motion, cases, contact=contact, leave_out=False, time_step="0.5 stable")
    plain = scalar_outcomes(motion, cases, contact=contact, time_step="0.5 stable")
    known = fast.status == 0
    assert known.mean() > 0.9
    np.testing.assert_array_equal(fast.overturned[known], plain[known, 0])
    stands = known & (fast.overturned == 0)
    np.testing.assert_allclose(fast.peak_rotation[stands], plain[stands, 1], rtol=1e-4, atol=1e-7)


def test_shaking_the_base_and_shaking_the_frame_give_the_same_motion() -> None:
    t = np.arange(200) * 0.01
    motion = Motion(4.0 * np.sin(2 * np.pi * t / 0.7) * (t < 0.7), 0 * t, sampling_interval=0.01)
    cases = Cases(0.0, 0.6, [0.2, 0.3, 0.5], [10.0, 1.0, 0.3])
    base = scalar_outcomes(motion, cases, inertial=True)
    frame = run_cases(motion, cases, leave_out=False)
    np.testing.assert_array_equal(base[:, 0], frame.overturned)
    stands = frame.overturned == 0
    assert stands.any()
    np.testing.assert_allclose(base[stands, 1], frame.peak_rotation[stands], rtol=1e-6, atol=1e-9)
