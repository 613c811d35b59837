"""What is left out changes no flag and no side, over a large real grid."""

import numpy as np
import pytest

from overturning.dem.run import run_cases
from overturning.dem.simulate import simulate_arrays
from overturning.model.cases import Cases
from overturning.model.contact import SCENE_STATIC_PENETRATION, Contact
from overturning.model.scene import gravestone
from overturning.motion.motion import Motion
from tests.dem.near_field import near_field


@pytest.mark.parametrize(("number", "pulse"), [(6, True), (8, True), (9, True), (18, False), (21, False)])
def test_flags_and_sides_are_equal_with_and_without(number: int, pulse: bool) -> None:
    motion, _, _ = near_field(number, pulse)
    if number == 9:
        # With vertical motion the thresholds change from sample to sample.
        motion = Motion(motion.north, motion.east, 0.7 * motion.east, sampling_interval=motion.sampling_interval)
    grid = {
        "azimuth_deg": np.arange(0.0, 360.0, 15.0), "height": [0.6, 1.2], "b_over_h": np.arange(0.1, 0.61, 0.1),
        "friction": [0.08, 0.33, 0.58, 1.0],
    }  # fmt: skip
    short = simulate_arrays(motion, **grid, threads=2)
    full = simulate_arrays(motion, **grid, leave_out=False, threads=2)
    assert (full["status"] == 0).all()
    different = short["overturned"] != full["overturned"]
    assert different.sum() == 0, f"{different.sum()} of {different.size}"
    # A case that was left out never came near to falling.
    resting = short["status"] == 1
    assert full["peak_rotation"][resting].max(initial=0.0) < 0.05
    assert short["block_steps"].sum() < 0.6 * full["block_steps"].sum()


SOFT = Contact(static_penetration=SCENE_STATIC_PENETRATION)
"""Cundall's steps shrink with the stiffness."""
GRID = {
    "azimuth_deg": np.arange(0.0, 180.0, 15.0), "height": [0.6, 1.2], "b_over_h": np.arange(0.1, 0.61, 0.1),
}  # fmt: skip


@pytest.mark.parametrize("scheme", ["centred", "cundall"])
def test_a_kernel_without_the_vertical_component_gives_the_same_bits(scheme: str) -> None:
    motion, _, _ = near_field(8, True)
    level = Motion(motion.north, motion.east, 0 * motion.north, sampling_interval=motion.sampling_interval)
    without, with_zeros = (
        simulate_arrays(which, gravestone(SOFT), **GRID, friction=[0.33, 1.0], scheme=scheme)
        for which in (motion, level)
    )
    assert (without["overturned"] != 0).any()
    for name, values in without.items():
        np.testing.assert_array_equal(values, with_zeros[name], err_msg=name)


def test_a_kernel_without_tangential_springs_gives_the_answers_of_next_to_no_friction() -> None:
    t = np.arange(400) * 0.01
    # A jump down and up: without friction only the vertical motion, and a start on one corner, can rock a block.
    motion = Motion(2.0 * np.sin(5.0 * t), 0 * t, 12.0 * np.sin(9.0 * t) * (t < 2.0), sampling_interval=0.01)
    axes = np.meshgrid([0.6, 1.2], np.arange(0.1, 0.61, 0.05), [0.3, 0.6, 0.9], indexing="ij")
    height, ratio, share = (values.ravel() for values in axes)
    tilt = np.round(share * np.arctan(ratio), 6)
    smooth, rough = (
        run_cases(motion, Cases(0.0, height, ratio, friction, initial_tilt=tilt), time_step="0.06 stable")
        for friction in (0.0, 1e-12)
    )
    np.testing.assert_array_equal(smooth.overturned, rough.overturned)
    assert (smooth.overturned != 0).any()
    assert (smooth.overturned == 0).any()
    stands = smooth.overturned == 0
    np.testing.assert_allclose(smooth.peak_rotation[stands], rough.peak_rotation[stands], rtol=2e-3, atol=1e-6)
    assert (smooth.energy_error < 1e-2).all()
