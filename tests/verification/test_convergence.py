"""Order of convergence, measured on continuous errors, and errors against rigid solutions."""

import numpy as np
import pytest

from overturning.dem.run import run_cases
from overturning.model.cases import Cases
from overturning.model.contact import DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO
from overturning.motion.motion import Motion
from verification.inputs import CaseGroup, case_grid, groups_with_every_nth_case, rocking_case_groups_under_sine_pulses
from verification.measures import convergence_order, median_peak_rotation_error_over_alpha, run_case_groups
from verification.work_precision.boundaries import (
    RELATIVE_BRACKET_HALF_WIDTH,
    bisect_boundaries,
    boundaries_between_falling_and_standing_cases,
    falling_and_standing_b_over_h,
)
from verification.work_precision.parts import (
    SchemeStepAndPenetration,
    fall_sides_and_peak_rotations_of_rigid_blocks,
    flags_and_peak_rotations_over_alpha,
)

pytestmark = pytest.mark.long

RELATIVE_STEPS = np.array([0.5, 0.25, 0.125])


def soft_contact_setting(scheme: str, step: float) -> SchemeStepAndPenetration:
    """Setting with a contact so soft that the error of the time step far exceeds the effects of chaos and rounding."""
    return SchemeStepAndPenetration(scheme, step, 2e-5)


def blocks_under_decaying_sine() -> CaseGroup:
    """Cases of blocks that rock, some of which slide, under one strong motion of 3 s."""
    time = np.arange(300) * 0.01
    north = 5.0 * np.sin(2 * np.pi * time / 0.8) * np.exp(-time)
    motion = Motion(north, 0 * north, sampling_interval=0.01)
    return CaseGroup(motion, case_grid(0.0, [0.6, 1.0], np.linspace(0.2, 0.4, 12), [0.45, 1.0]))


def test_convergence_order_is_exact_for_a_power_law() -> None:
    assert convergence_order(RELATIVE_STEPS, 3.0 * RELATIVE_STEPS**2) == pytest.approx(2.0)
    assert np.isnan(convergence_order(RELATIVE_STEPS, np.zeros(3)))


@pytest.mark.parametrize(("scheme", "least"), [("centred", 1.0), ("cundall", 0.9)])
def test_peak_rotation_converges_with_the_time_step(scheme: str, least: float) -> None:
    groups = [blocks_under_decaying_sine()]
    right = flags_and_peak_rotations_over_alpha(groups, soft_contact_setting("centred", 0.004))
    errors = [
        median_peak_rotation_error_over_alpha(
            *flags_and_peak_rotations_over_alpha(groups, soft_contact_setting(scheme, step)), *right
        )
        for step in RELATIVE_STEPS
    ]
    assert errors[0] > errors[-1] > 0
    assert convergence_order(RELATIVE_STEPS, np.array(errors)) >= least


def test_a_stiff_contact_has_smaller_rotation_errors_at_the_longest_stable_step() -> None:
    """At the longest stable step, rotation errors on a stiff contact are less than half those on a soft one.

    The forces of a stiff contact change within less than the finest step, so errors converge more slowly than on a
    soft contact.
    """
    cases = case_grid(0.0, np.linspace(0.5, 1.2, 8), np.linspace(0.2, 0.4, 24), [0.45, 1.0])
    groups, steps = [CaseGroup(blocks_under_decaying_sine().motion, cases)], np.array([1.0, 0.5, 0.25, 0.125])

    def median_rotation_errors_by_time_step(penetration: float) -> np.ndarray:
        right = flags_and_peak_rotations_over_alpha(groups, SchemeStepAndPenetration("centred", 0.016, penetration))
        found = [
            flags_and_peak_rotations_over_alpha(groups, SchemeStepAndPenetration("centred", step, penetration))
            for step in steps
        ]
        return np.array([median_peak_rotation_error_over_alpha(*one, *right) for one in found])

    rigid, soft_one = (
        median_rotation_errors_by_time_step(DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO),
        median_rotation_errors_by_time_step(2e-5),
    )
    assert convergence_order(steps, rigid) >= 0.7
    assert convergence_order(steps, soft_one) >= 1.5
    assert rigid[0] < 0.5 * soft_one[0]
    assert rigid[0] < 5e-5


@pytest.mark.parametrize("scheme", ["centred", "cundall"])
def test_the_energy_balance_error_converges_with_the_time_step(scheme: str) -> None:
    group, steps = blocks_under_decaying_sine(), [*RELATIVE_STEPS, 0.0625]
    residual = [
        run_case_groups([group], **soft_contact_setting(scheme, step).run_cases_arguments).results.energy_error.mean()
        for step in steps
    ]
    assert convergence_order(np.array(steps), np.array(residual)) >= 0.9


@pytest.mark.parametrize(("scheme", "least"), [("centred", 1.2), ("cundall", 0.9)])
def test_the_overturning_boundary_converges_with_the_time_step(scheme: str, least: float) -> None:
    """The B/H at which the overturning flag changes, found by bisection, converges with the time step.

    The value at a far finer time step is the reference.
    """
    cases = case_grid(0.0, [0.5, 0.8, 1.3], np.linspace(0.15, 0.45, 16), [0.45, 0.6, 1.0, 2.0])
    groups = [CaseGroup(blocks_under_decaying_sine().motion, cases)]
    where = boundaries_between_falling_and_standing_cases(groups, run_case_groups(groups).results.overturned, 30)
    assert len(where) >= 12
    low, high = falling_and_standing_b_over_h(where)
    near = bisect_boundaries(groups, where, {}, low, high, 24)

    def bisected_b_over_h_at_overturning_boundaries(scheme: str, step: float) -> np.ndarray:
        return bisect_boundaries(
            groups,
            where,
            soft_contact_setting(scheme, step).run_cases_arguments,
            near * (1 - RELATIVE_BRACKET_HALF_WIDTH),
            near * (1 + RELATIVE_BRACKET_HALF_WIDTH),
            20,
        )

    exact = bisected_b_over_h_at_overturning_boundaries("centred", 0.015)
    assert np.isfinite(exact).sum() >= 10
    shifts = [
        float(np.nanmedian(np.abs(bisected_b_over_h_at_overturning_boundaries(scheme, step) / exact - 1.0)))
        for step in RELATIVE_STEPS
    ]
    assert shifts[0] > shifts[-1] > 0
    assert convergence_order(RELATIVE_STEPS, np.array(shifts)) >= least


def test_the_bisected_boundary_b_over_h_separates_falling_and_standing() -> None:
    groups = groups_with_every_nth_case([blocks_under_decaying_sine()], 2)
    where = boundaries_between_falling_and_standing_cases(groups, run_case_groups(groups).results.overturned, 3)
    assert where
    low, high = falling_and_standing_b_over_h(where)
    found = bisect_boundaries(groups, where, {}, low, high)
    assert (low < found).all()
    assert (found < high).all()
    for factor, falls in ((0.9995, True), (1.0005, False)):
        cases = Cases(b_over_h=found * factor, **{
            name: [place.parameters_of_falling_case[name] for place in where]
            for name in ("azimuth_deg", "height", "friction")
        })  # fmt: skip
        assert ((run_cases(groups[0].motion, cases).overturned != 0) == falls).all()


def test_an_overturning_boundary_without_a_bracket_is_nan() -> None:
    groups = [blocks_under_decaying_sine()]
    where = boundaries_between_falling_and_standing_cases(groups, run_case_groups(groups).results.overturned, 2)
    low, high = falling_and_standing_b_over_h(where)
    exact = bisect_boundaries(groups, where, {}, low, high, 3)
    low[0] = np.nan
    found = bisect_boundaries(groups, where, {}, low, high, 3)
    assert np.isnan(found[0])
    np.testing.assert_array_equal(found[1:], exact[1:])


def test_the_difference_from_the_rigid_block_is_smaller_on_a_stiffer_contact() -> None:
    groups = rocking_case_groups_under_sine_pulses(pulse_count=3, block_count_per_pulse=12)
    right = fall_sides_and_peak_rotations_of_rigid_blocks(groups)
    errors = [
        median_peak_rotation_error_over_alpha(
            *flags_and_peak_rotations_over_alpha(groups, SchemeStepAndPenetration("centred", 0.5, delta)), *right
        )
        for delta in (2e-4, 2e-5)
    ]
    assert errors[1] < 0.5 * errors[0]
    assert errors[1] < 0.01
