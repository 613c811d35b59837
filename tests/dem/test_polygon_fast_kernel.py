"""Scene kernel against block kernel: a block on the ground under real records."""

from dataclasses import replace

import numpy as np
import pytest

from overturning.dem.block.tables import TRAJECTORY_ROW_DTYPE
from overturning.dem.numerics import ELEMENT_STEP_COST_IN_BLOCK_STEPS, NumericalOptions
from overturning.dem.polygon.plan import plan_scene_simulation
from overturning.dem.run import plan_simulation, run_cases, simulate_cases
from overturning.dem.simulate import simulate_as_arrays
from overturning.model.cases import Cases
from overturning.model.contact import Contact
from overturning.model.planes import PlanarModel
from overturning.model.scene import gravestone
from overturning.model.status import CaseStatus
from overturning.motion.motion import Motion
from tests.dem.near_field import strong_part_of_near_field_record
from tests.dem.polygon_scenes import load_shipped_scene

pytestmark = pytest.mark.long

SOFT_CONTACT = Contact(static_penetration=2e-5)
"""The contact of both kernels."""


def _amplified_strong_part_of_record(number: int) -> Motion:
    """Return ten seconds around the peak of a near-field record, multiplied by 1.5."""
    return strong_part_of_near_field_record(number, 4.0, 6.0).scaled_by(1.5)


def _cases_of_varied_blocks_and_azimuths(step: int = 36) -> Cases:
    """Return cases of blocks of two heights, four B/H and three frictions, with azimuths every `step` degrees."""
    grid = np.meshgrid(
        np.arange(0, 360, step) + 1.0, [0.6, 1.1], [0.15, 0.25, 0.35, 0.45], [0.3, 0.7, 2.0], indexing="ij"
    )
    return Cases(*(axis.ravel() for axis in grid))


@pytest.mark.parametrize("number", [6, 7])
def test_scene_and_block_kernels_give_the_same_flags_and_peaks(number: int) -> None:
    motion, cases = _amplified_strong_part_of_record(number), _cases_of_varied_blocks_and_azimuths()
    general = simulate_cases(
        gravestone(SOFT_CONTACT), motion, cases, NumericalOptions(scheme="cundall", leave_out=False, general=True)
    )
    fast = run_cases(motion, cases, gravestone(SOFT_CONTACT), scheme="cundall", leave_out=False)
    assert (general.status == CaseStatus.SIMULATED).all()
    assert (fast.overturned != 0).sum() > 20
    np.testing.assert_array_equal(general.overturned, fast.overturned)
    # Leave out chaotic cases: those that a relative change of the motion by 1e-12 moves by more than the tolerance.
    nudged = Motion((1 + 1e-12) * motion.north, (1 + 1e-12) * motion.east, sampling_interval=motion.sampling_interval)
    other = run_cases(nudged, cases, gravestone(SOFT_CONTACT), scheme="cundall", leave_out=False)
    firm = np.isclose(other.peak_rotation, fast.peak_rotation, rtol=1e-5, atol=1e-7)
    assert firm.mean() > 0.99
    # In the scene kernel an upper corner lands just before 90°, and strong damping keeps the block there.
    lying = 0.995 * 0.5 * np.pi / np.arctan(cases.b_over_h)
    found, expected = (np.minimum(peak, lying)[firm] for peak in (general.peak_rotation, fast.peak_rotation))
    np.testing.assert_allclose(found, expected, rtol=1e-5, atol=1e-7)
    fell = fast.overturned != 0
    np.testing.assert_allclose(general.overturning_time[fell], fast.overturning_time[fell], atol=1e-3)


def test_scene_and_block_kernels_give_the_same_motion_until_the_second_impact() -> None:
    """250 cases agree to 1e-9 m and rad until the second impact or, in a fall, the critical angle."""
    whole, cases = _amplified_strong_part_of_record(7), _cases_of_varied_blocks_and_azimuths(17)
    upto = round(6.5 / whole.sampling_interval)  # all second impacts occur before 4.8 s
    motion = Motion(whole.north[:upto], whole.east[:upto], sampling_interval=whole.sampling_interval)
    model = PlanarModel(gravestone(SOFT_CONTACT))
    numerics = NumericalOptions(scheme="cundall", leave_out=False)
    seen = 0
    first, counter = np.zeros(1, np.int64), np.zeros(1, np.int64)
    for index in np.linspace(0, cases.case_count - 1, 250).astype(int):
        one = Cases(*(getattr(cases, name)[[index]] for name in ("azimuth_deg", "height", "b_over_h", "friction")))
        _, fast = plan_simulation(model, motion, one, numerics).simulate_group_with_reruns_on_energy_error(
            first, counter, np.zeros(motion.sample_count, TRAJECTORY_ROW_DTYPE)
        )
        tilted = np.where(np.abs(fast["angle"]) < 1e-3, 0.0, np.sign(fast["angle"]))
        sides = np.flatnonzero((tilted[1:] != 0) & (np.abs(np.diff(tilted)) > 0))
        # A fall has no second impact; beyond the critical angle rounding errors grow with the fall.
        past = np.flatnonzero(np.abs(fast["angle"]) > np.arctan(one.b_over_h))
        end = min([*sides[2:3], *past[:1], len(fast), motion.sample_count])
        seen += sides.size > 2
        plan = plan_scene_simulation(model, motion, one, numerics)
        budget = (
            ELEMENT_STEP_COST_IN_BLOCK_STEPS * end * int(plan.steps_per_sample[0])
        )  # stop at the end of the comparison
        plan = replace(plan, numerics=replace(numerics, budget=budget))
        _, general = plan.simulate_group_with_reruns_on_energy_error(
            first, counter, np.zeros((motion.sample_count, 14))
        )
        # Both kernels have their origin at the middle of the base.
        for column, name in ((8, "centre_x"), (9, "centre_z"), (10, "angle")):
            np.testing.assert_allclose(general[: end - 1, column], fast[name][: end - 1], rtol=0, atol=1e-9)
    assert seen > 25


@pytest.mark.parametrize("friction", [0.15, 0.25, 0.35])
def test_a_sliding_and_rocking_block_agrees_between_both_kernels(friction: float) -> None:
    """Sliding friction must be proportional to the normal force within the step; otherwise energy does not balance."""
    time = np.arange(400) * 0.005
    wave = 4.5 * np.sin(2 * np.pi * time / 0.7) * (time < 0.7)
    motion = Motion(wave, 0 * wave, sampling_interval=0.005)
    grid = np.meshgrid([0.0], [0.6, 1.2], [0.12, 0.2, 0.25, 0.3, 0.4, 0.5], [friction], indexing="ij")
    cases = Cases(*(axis.ravel() for axis in grid))
    general = simulate_cases(gravestone(SOFT_CONTACT), motion, cases, NumericalOptions(general=True))
    fast = run_cases(motion, cases, gravestone(SOFT_CONTACT))
    assert general.energy_error.max() < 1e-3
    assert (general.status == CaseStatus.SIMULATED).all()
    np.testing.assert_array_equal(general.overturned, fast.overturned)
    stands = fast.overturned == 0  # a fallen block slips further until it lies
    assert fast.peak_slip[stands].min() > 5e-3
    np.testing.assert_allclose(general.peak_slip[stands], fast.peak_slip[stands], rtol=2e-4)


def test_the_gravestone_scene_is_computed_by_the_block_kernel() -> None:
    motion = _amplified_strong_part_of_record(6)
    grid = {"azimuth_deg": [0.0, 60.0, 180.0], "height": [0.6], "b_over_h": [0.2, 0.4], "friction": [0.5, 1.0]}
    scene = simulate_as_arrays(motion, load_shipped_scene("gravestone"), **grid)
    block = simulate_as_arrays(motion, **grid)
    assert scene.keys() == block.keys()
    for name, values in block.items():
        np.testing.assert_array_equal(scene[name], values)
