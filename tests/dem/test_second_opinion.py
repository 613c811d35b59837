"""The block kernel against an independent plain loop (`scalar_kernel`), the reference.

Steps are so short that the remaining differences are discretisation errors of the reference. With steps twice as long,
its peak rotations over α change by at most 6e-6 (median of a record) and up to 2e-3 for nearly falling blocks, its
slips by 3e-8 m (median). The bounds below have that size.
"""

from itertools import product
from typing import Any

import numpy as np
import pytest

from overturning.dem.run import run_cases
from overturning.model.cases import Cases
from overturning.model.contact import DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO, Contact
from overturning.model.results import CaseResults
from overturning.model.scene import gravestone
from overturning.motion.motion import Motion
from tests.dem.near_field import strong_part_of_near_field_record
from tests.dem.reference.scalar_kernel import integrate_block_cases

FINE_STEP = "0.03 stable"
SOFT_CONTACT = Contact(static_penetration=2e-5, damping_ratio=1.0)
"""Default contact of the tests: soft, since the steps of the reference shrink with stiffness and damping."""
AZIMUTH_HEIGHT_RATIO_FRICTION_ROWS = list(
    product([0.0, 45.0, 90.0, 135.0], [0.6, 1.2], [0.15, 0.25, 0.35, 0.45], [0.33, 1.0])
)


def cases_from_azimuth_height_ratio_friction(cells: list[Any]) -> Cases:
    """Return cases from rows of azimuth (degrees), height (m), B/H and friction."""
    return Cases(*np.array(cells).T)


def side_agreement_and_peak_differences(
    found: CaseResults, plain: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a mask of equal fall sides, and the differences of peak rotation and of slip where both results stand."""
    same = found.overturned == plain[:, 0]
    stands = same & (found.overturned == 0)
    rotation, slip = np.abs(found.peak_rotation - plain[:, 1]), np.abs(found.peak_slip - plain[:, 2])
    return same, rotation[stands], slip[stands]


@pytest.mark.long
@pytest.mark.parametrize(("number", "pulse"), [(7, True), (10, True), (15, False)])
def test_fall_sides_rotations_and_slips_match_scalar_kernel(number: int, pulse: bool) -> None:
    motion = strong_part_of_near_field_record(
        number, 3.0, 3.0, pulse
    )  # short: the reference takes 100,000 steps per second of motion
    plain = integrate_block_cases(motion, AZIMUTH_HEIGHT_RATIO_FRICTION_ROWS)
    assert 0.2 < (plain[:, 0] != 0).mean() < 0.9
    for scheme in ("centred", "cundall"):
        found = run_cases(
            motion,
            cases_from_azimuth_height_ratio_friction(AZIMUTH_HEIGHT_RATIO_FRICTION_ROWS),
            gravestone(SOFT_CONTACT),
            scheme=scheme,
            leave_out=False,
            time_step=FINE_STEP,
        )
        assert (found.status == 0).all()
        same, rotation, slip = side_agreement_and_peak_differences(found, plain)
        # A rocking block amplifies small differences: a cell near the stability boundary may differ.
        assert same.mean() >= 0.98, scheme
        assert np.median(rotation) < 5e-6, scheme
        assert (rotation < 5e-3).mean() >= 0.95, scheme
        assert np.median(slip) < 5e-7, scheme
        assert (slip < 1e-4).mean() >= 0.95, scheme
    # With default steps, which are hundreds of times longer.
    same, rotation, slip = side_agreement_and_peak_differences(
        run_cases(
            motion,
            cases_from_azimuth_height_ratio_friction(AZIMUTH_HEIGHT_RATIO_FRICTION_ROWS),
            gravestone(SOFT_CONTACT),
            leave_out=False,
        ),
        plain,
    )
    assert same.mean() >= 0.95
    assert np.median(rotation) < 1e-3
    assert np.median(slip) < 1e-4


CHANGED_CONTACT_PARAMETERS = [{"damping_ratio": 0.1}, {"stiffness_ratio": 0.3}, {"stiffness": 1e7}]


@pytest.mark.parametrize("contact", CHANGED_CONTACT_PARAMETERS, ids=lambda contact: next(iter(contact)))
@pytest.mark.parametrize("scheme", ["centred", pytest.param("cundall", marks=pytest.mark.long)])
def test_other_contacts_with_vertical_motion_agree_with_an_independent_integration(
    contact: dict[str, float], scheme: str
) -> None:
    t = np.arange(300) * 0.01
    pulse = np.sin(2 * np.pi * t / 0.8) * (t < 1.6)
    motion = Motion(3.0 * pulse, 1.0 * pulse, 2.0 * np.sin(7.0 * t) * (t < 2), sampling_interval=0.01)
    cells = list(product([0.0, 90.0], [0.6, 1.2], [0.1, 0.2, 0.3, 0.4, 0.5], [0.33, 1.0]))
    # A stiffness cannot be combined with a static penetration.
    soft = (
        SOFT_CONTACT.model_copy(update={"static_penetration": DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO})
        if "stiffness" in contact
        else SOFT_CONTACT
    )
    changed = Contact(**soft.model_dump(exclude={"damping"}) | contact)
    found = run_cases(
        motion,
        cases_from_azimuth_height_ratio_friction(cells),
        gravestone(changed),
        scheme=scheme,
        leave_out=False,
        time_step=FINE_STEP,
    )
    assert (found.status == 0).all()
    same, rotation, slip = side_agreement_and_peak_differences(found, integrate_block_cases(motion, cells, **contact))
    assert same.mean() >= 0.97
    assert np.median(rotation) < 5e-5
    assert (rotation < 5e-3).mean() >= 0.95
    assert np.median(slip) < 5e-6


def test_fixed_and_moving_frames_of_reference_give_the_same_rocking() -> None:
    t = np.arange(200) * 0.01
    motion = Motion(4.0 * np.sin(2 * np.pi * t / 0.7) * (t < 0.7), 0 * t, sampling_interval=0.01)
    cells = [(0.0, 0.6, 0.2, 10.0), (0.0, 0.6, 0.3, 1.0), (0.0, 0.6, 0.5, 0.3)]
    base = integrate_block_cases(motion, cells, inertial=True)
    frame = run_cases(
        motion,
        cases_from_azimuth_height_ratio_friction(cells),
        gravestone(SOFT_CONTACT),
        leave_out=False,
        time_step=FINE_STEP,
    )
    np.testing.assert_array_equal(base[:, 0], frame.overturned)
    stands = frame.overturned == 0
    assert stands.any()
    np.testing.assert_allclose(base[stands, 1], frame.peak_rotation[stands], rtol=1e-5, atol=1e-8)


def test_a_block_released_on_one_corner_agrees_with_an_independent_integration() -> None:
    still = Motion(np.zeros(50), np.zeros(50), sampling_interval=0.01)
    cell = (0.0, 0.6, 0.3, 0.5)
    for scheme in ("centred", "cundall"):
        let_go = Cases(*cell, initial_tilt=0.2)
        found = run_cases(still, let_go, gravestone(SOFT_CONTACT), scheme=scheme, leave_out=False, time_step=FINE_STEP)
        plain = integrate_block_cases(still, [cell], tilt=0.2)
        np.testing.assert_allclose(found.peak_rotation, plain[:, 1], rtol=1e-6)
        np.testing.assert_allclose(found.peak_slip, plain[:, 2], rtol=1e-3, atol=1e-7)
