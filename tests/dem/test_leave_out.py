"""Skipping times at rest changes no more outcomes than a relative change of the motion by 1e-9, over a large grid."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from overturning.dem.block import plan as block_plan
from overturning.dem.body import plan as body_plan
from overturning.dem.kernel.ground import (
    CHECKED_SAMPLES_PER_REST_CHECK_BLOCK,
    LEAD_TIME_BEFORE_POSSIBLE_MOVEMENT_S,
    SAMPLES_PER_REST_CHECK_BLOCK,
    max_acceleration_in_window_by_rest_check,
)
from overturning.dem.numerics import NumericalOptions
from overturning.dem.polygon import plan as polygon_plan
from overturning.dem.quiet import dynamic_to_static_force_ratio_upper_bound
from overturning.dem.run import run_cases, simulate_cases
from overturning.dem.simulate import simulate_as_arrays
from overturning.dem.stack import plan as stack_plan
from overturning.dem.trajectory import trajectory
from overturning.model.cases import Cases
from overturning.model.contact import Contact
from overturning.model.scene import Scene, gravestone
from overturning.model.stack import Stack
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from tests.dem.near_field import near_field_motion_and_fault_component_azimuths
from tests.dem.polygon_scenes import GROUND, block_element, load_shipped_scene, scene_of_elements
from tests.dem.test_stack_answers import shaft_off_centre

NEAR_FAULT_RECORD_NUMBERS_AND_PULSE_FLAGS = ((6, True), (8, True), (9, True), (18, False), (21, False))
"""Near-fault records (number, with pulse); the third gets vertical motion, so that thresholds vary with time."""
BLOCK_GRID_WITH_TWO_THREADS: dict[str, Any] = {
    "azimuth_deg": np.arange(0.0, 360.0, 15.0), "height": [0.6, 1.2], "b_over_h": np.arange(0.1, 0.61, 0.1),
    "friction": [0.08, 0.33, 0.58, 1.0], "threads": 2,
}  # fmt: skip


def read_near_fault_motion(number: int, pulse: bool) -> Motion:
    """Return a near-field record; number 9 gets an artificial vertical component."""
    motion, _, _ = near_field_motion_and_fault_component_azimuths(number, pulse)
    up = 0.7 * motion.east if number == 9 else None
    return Motion(motion.north, motion.east, up, sampling_interval=motion.sampling_interval)


@pytest.mark.long
@pytest.mark.parametrize(("number", "pulse"), NEAR_FAULT_RECORD_NUMBERS_AND_PULSE_FLAGS)
def test_skipping_quiet_cases_and_quiet_starts_and_ends_changes_no_overturning_flag(
    number: int, pulse: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Cases at rest and quiet starts and ends of records are skipped; the skipping of quiet times between is off."""
    monkeypatch.setattr(block_plan, "largest_acceleration_without_motion_g", lambda lifts, *_: 0.0 * lifts)
    motion = read_near_fault_motion(number, pulse)
    short = simulate_as_arrays(motion, **BLOCK_GRID_WITH_TWO_THREADS)
    full = simulate_as_arrays(motion, **BLOCK_GRID_WITH_TWO_THREADS, leave_out=False)
    assert (full["status"] == 0).all()
    different = short["overturned"] != full["overturned"]
    assert different.sum() == 0, f"{different.sum()} of {different.size}"
    # The full simulation of a skipped case stays far from overturning.
    resting = short["status"] == 1
    assert full["peak_rotation"][resting].max(initial=0.0) < 0.05
    assert short["block_steps"].sum() < 0.6 * full["block_steps"].sum()


@pytest.mark.long
def test_skipping_times_at_rest_changes_no_more_falls_than_a_1e_9_amplitude_change() -> None:
    changed = np.zeros(3, int)
    for motion in (read_near_fault_motion(*one) for one in NEAR_FAULT_RECORD_NUMBERS_AND_PULSE_FLAGS):
        short = simulate_as_arrays(motion, **BLOCK_GRID_WITH_TWO_THREADS)
        full, more, less = (
            simulate_as_arrays(motion.scaled_by(factor), **BLOCK_GRID_WITH_TWO_THREADS, leave_out=False)
            for factor in (1.0, 1 + 1e-9, 1 - 1e-9)
        )
        falls = full["overturned"] != 0
        changed += [((other["overturned"] != 0) != falls).sum() for other in (short, more, less)]
        assert short["block_steps"].sum() < 0.6 * full["block_steps"].sum()
    assert changed[0] <= changed[1:].max(), changed


@pytest.mark.long
def test_skipping_times_at_rest_of_stacks_changes_falls_like_a_1e_9_amplitude_change() -> None:
    """Skipping changes no more flags than amplitude changes of 1e-9 do: at most mean + 2 √mean of their numbers."""
    skipped, disturbed = 0, np.zeros(4, int)
    stacks: dict[str, Any] = {
        "model": Stack(load_shipped_scene("three-tier")), "orientation_deg": np.arange(0.0, 90.0, 15.0),
        "height": [0.8], "b_over_h": [0.25, 0.35, 0.45], "friction": [0.3, 0.5, 0.7, 0.9], "threads": 2,
    }  # fmt: skip
    for motion in (read_near_fault_motion(*one) for one in NEAR_FAULT_RECORD_NUMBERS_AND_PULSE_FLAGS[2:]):
        short = simulate_as_arrays(motion, **stacks)
        full, *others = (
            simulate_as_arrays(motion.scaled_by(factor), **stacks, leave_out=False)
            for factor in (1.0, 1 + 1e-9, 1 - 1e-9, 1 + 2e-9, 1 - 2e-9)
        )
        skipped += int((short["overturned"] != full["overturned"]).sum())
        disturbed += [(other["overturned"] != full["overturned"]).sum() for other in others]
        assert short["block_steps"].sum() < full["block_steps"].sum()
    assert skipped <= disturbed.mean() + 2.0 * np.sqrt(disturbed.mean()), (skipped, disturbed)


SOFT_CONTACT = Contact(static_penetration=2e-5)
"""A soft contact: Cundall's step shrinks with the stiffness."""
GRID = {
    "azimuth_deg": np.arange(0.0, 180.0, 15.0), "height": [0.6, 1.2], "b_over_h": np.arange(0.1, 0.61, 0.1),
}  # fmt: skip


@pytest.mark.parametrize("scheme", ["centred", pytest.param("cundall", marks=pytest.mark.long)])
def test_motion_without_vertical_gives_the_same_bits_as_zero_vertical_motion(scheme: str) -> None:
    motion, _, _ = near_field_motion_and_fault_component_azimuths(8, True)
    level = Motion(motion.north, motion.east, 0 * motion.north, sampling_interval=motion.sampling_interval)
    without, with_zeros = (
        simulate_as_arrays(which, gravestone(SOFT_CONTACT), **GRID, friction=[0.33, 1.0], scheme=scheme)
        for which in (motion, level)
    )
    assert (without["overturned"] != 0).any()
    for name, values in without.items():
        np.testing.assert_array_equal(values, with_zeros[name], err_msg=name)


@pytest.mark.long
def test_zero_friction_without_tangential_springs_agrees_with_tiny_friction() -> None:
    t = np.arange(400) * 0.01
    # Without friction only strong vertical motion, or an initial tilt, can make a block rock.
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


MODELS_AND_PLAN_MODULES: dict[str, tuple[Any, Any]] = {
    "block": (None, block_plan),
    "scene": (load_shipped_scene("three-tier"), polygon_plan),
    "space": ("rectangle", body_plan),
}


def weak_motion_interrupted_by_strong_pulse(wave: str, vertical: bool, level: float) -> Motion:
    """Return 6 s of motion below the rocking threshold of B/H 0.3 (steps, zigzag or slow sine), with a strong pulse."""
    t, quiet = np.arange(1200) * 0.005, level * STANDARD_GRAVITY
    along = {
        "steps": quiet * np.sign(np.sin(9.0 * t)),
        "zigzag": quiet * (-1.0) ** np.arange(t.size),
        "slow": quiet * np.sin(5.0 * t),
    }[wave]
    along[:40] = 2.0 * quiet  # strong enough to be simulated at the start
    along[500:560] = 6.0 * np.sin(np.pi * np.arange(60) / 30)
    up = 0.1 * STANDARD_GRAVITY * np.cos(7.0 * t) if vertical else None
    return Motion(along, 0.3 * along, up, sampling_interval=0.005)


@pytest.mark.parametrize("vertical", [False, True])
@pytest.mark.parametrize("wave", ["steps", "zigzag", "slow"])
@pytest.mark.parametrize("name", MODELS_AND_PLAN_MODULES)
def test_skipping_times_at_rest_does_not_change_the_fall_of_a_body(
    name: str, wave: str, vertical: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Worst case: motion just below the rest threshold, near the contact's resonance, until a strong pulse."""
    model, plan = MODELS_AND_PLAN_MODULES[name]
    cases = Cases(np.repeat(np.arange(0.0, 180.0, 20.0), 4), 0.6, np.tile([0.3, 0.34, 0.4, 0.5], 9), 0.9)
    motion = weak_motion_interrupted_by_strong_pulse(wave, vertical, 0.07 if name == "scene" else 0.13)
    short = simulate_cases(model, motion, cases)
    monkeypatch.setattr(plan, "largest_acceleration_without_motion_g", lambda lifts, *_: 0.0 * lifts)
    full = simulate_cases(model, motion, cases)
    assert (full.samples_left_out == 0).all()
    assert short.samples_left_out.mean() > 100
    # After a skip, a stack may take some more steps than in the full simulation.
    assert (short.block_steps <= (1.001 if name == "scene" else 1.0) * full.block_steps).all()
    np.testing.assert_array_equal(short.overturned, full.overturned)
    peak = "peak_tilt" if name == "space" else "peak_rotation"
    stands = full.overturned == 0
    np.testing.assert_allclose(getattr(short, peak)[stands], getattr(full, peak)[stands], rtol=0.02, atol=1e-3)


@pytest.mark.parametrize("vertical", [False, True])
@pytest.mark.parametrize("wave", ["steps", "slow"])
def test_skipping_times_at_rest_does_not_change_the_outcome_of_a_stack(
    wave: str, vertical: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Worst case: motion just below the rest threshold. A joint with µ = 0.2 slides in a pulse and is then at rest."""
    motion = weak_motion_interrupted_by_strong_pulse(wave, vertical, 0.08)
    given: dict[str, Any] = {"orientation_deg": [0.0, 20.0, 40.0, 80.0], "friction": [0.2, 0.6]}
    model = Stack(load_shipped_scene("three-tier"))
    short = simulate_as_arrays(motion, model=model, **given)
    monkeypatch.setattr(stack_plan, "MAX_REST_LIMIT_TO_CORNER_SLIP_ACCELERATION_RATIO", 0.0)
    full = simulate_as_arrays(motion, model=model, **given)
    assert (full["samples_left_out"] == 0).all()
    assert short["samples_left_out"].mean() > 100
    assert (short["block_steps"] <= full["block_steps"]).all()
    assert short["block_steps"].sum() < full["block_steps"].sum()
    np.testing.assert_array_equal(short["overturned"], full["overturned"])
    stands = full["overturned"] == 0
    for variable, tolerance in (("peak_tilt", 0.1), ("residual_slip_north", 1e-3), ("residual_slip_east", 1e-3)):
        np.testing.assert_allclose(short[variable][stands], full[variable][stands], rtol=0.02, atol=tolerance)


def test_skipping_times_at_rest_does_not_change_the_flight_of_a_fallen_stone() -> None:
    motion = weak_motion_interrupted_by_strong_pulse("slow", False, 0.05)
    case = {"orientation_deg": 0.0, "friction": 0.6, "b_over_h": 0.15}
    short, full = (
        trajectory(motion, load_shipped_scene("three-tier"), **case, aftermath=5.0, leave_out=one)
        for one in (True, False)
    )
    for path in (short, full):
        assert path["overturned"].to_numpy().tolist() == [0.0, 0.0, 1.0]
        assert np.diff(path["time"]).max() < 2.0 * 0.005
    gone = full["simulated"].sel(element="shaft").to_numpy() == 0.0
    assert gone.sum() > 200
    at = full["time"].to_numpy()
    for path in (short, full):
        assert np.abs(path["place"]).max() < 1.5
    # One case: skips change it by rounding only.
    again = np.stack([np.interp(at, short["time"], row) for row in short["place"].sel(element="shaft").to_numpy().T])
    np.testing.assert_allclose(again[:, gone].T, full["place"].sel(element="shaft").to_numpy()[gone], atol=0.05)


@pytest.mark.parametrize(("level", "falls"), [(0.9, 0.0), (1.2, 1.0)])
@pytest.mark.parametrize("towards", [0.0, 180.0])
def test_the_rest_threshold_is_that_of_the_weakest_direction(towards: float, level: float, falls: float) -> None:
    """A shaft whose centre is 5 mm from the rim of its base tips at 0.017 g, after seconds at rest that are skipped."""
    time, onset = np.arange(1600) * 0.005, 0.005 / 0.3 * STANDARD_GRAVITY
    # The shaft tips towards the rim when the base moves away from it.
    base = np.where(time < 0.05, 1.5, np.where((time > 4.0) & (time < 7.0), level, 0.0)) * -onset
    given: dict[str, Any] = {"model": Stack(shaft_off_centre(0.245)), "orientation_deg": [towards], "friction": [0.6]}
    turned = Motion(np.cos(np.radians(towards)) * base, 0.0 * base, sampling_interval=0.005)
    short, full = (simulate_as_arrays(turned, **given, leave_out=one) for one in (True, False))
    assert short["samples_left_out"].item() > 300
    for one in (short, full):
        assert one["overturned"].ravel()[1] == falls


@pytest.mark.parametrize(("strength", "falls"), [(0.9, 0.0), (1.5, 1.0)])
def test_a_stack_whose_counterweight_falls_first_is_simulated_to_the_end(strength: float, falls: float) -> None:
    """The middle stone overhangs to 0.5 mm from tipping, and is held by a slender stone of lead, which falls first.

    Then 0.002 g tip it, a hundredth of what moves the complete stack.
    """
    lead: dict[str, Any] = {"name": "lead", "width": 0.06, "depth": 0.1, "height": 0.5, "stands_on": "stone"}
    made = Scene.model_validate({
        "name": "balanced", "materials": {"stone": {"density": 2650}, "lead": {"density": 11340}},
        "elements": [
            {"name": "ground", "kind": "driven", "width": 40.0, "height": 1.0, "at": [0.0, -1.0]},
            {"name": "base", "width": 0.5, "depth": 0.5, "height": 0.3, "stands_on": "ground"},
            {"name": "stone", "width": 0.4, "depth": 0.4, "height": 0.5, "stands_on": "base", "at": [0.2495, 0.0]},
            lead | {"at": [-0.15, 0.0], "material": "lead"},
        ],
    })  # fmt: skip
    time, onset = np.arange(3600) * 0.01, 0.0005 / 0.25 * STANDARD_GRAVITY
    aside = 5.0 * np.sin(2.0 * np.pi * time) * ((time >= 2.0) & (time < 3.0))
    # The base moves away from the overhang, slowly, long after the lead has fallen aside.
    ahead = strength * onset * np.sin(0.1 * np.pi * (time - 25.0)) * ((time >= 25.0) & (time < 35.0))
    motion = Motion(ahead, aside, sampling_interval=0.01)
    for one in (True, False):
        found = simulate_as_arrays(motion, model=Stack(made), orientation_deg=[180.0], friction=[1.0], leave_out=one)
        assert found["overturned"].ravel().tolist() == [0.0, falls, 1.0]


@pytest.mark.parametrize("vertical", [False, True])
@pytest.mark.parametrize("gravity", [1.62, 24.8])
def test_rest_thresholds_of_a_scene_use_its_own_gravity(gravity: float, vertical: bool) -> None:
    """The rest threshold is proportional to the weight: on the Moon a stone rocks under weaker motion."""
    made = scene_of_elements(GROUND, block_element("stone", 0.12, 0.6), gravity=gravity)
    time = np.arange(0.0, 12.0, 0.01)
    wave = gravity * np.where((time > 5) & (time < 6.5), np.sin(2 * np.pi * (time - 5) / 0.75), 0.0)
    axes = [30.0, 90.0], [0.6, 1.2], [0.1, 0.2, 0.3], [0.15, 0.3, 0.6, 1.2]
    azimuth, height, b_over_h, strength = (axis.ravel() for axis in np.meshgrid(*axes, indexing="ij"))
    cases = Cases(azimuth, height, b_over_h, 1.0, strength)
    motion = Motion(wave, 0.3 * wave, 0.5 * wave if vertical else None, sampling_interval=0.01)
    short, full = (simulate_cases(made, motion, cases, NumericalOptions(leave_out=one)) for one in (True, False))
    np.testing.assert_array_equal(short.overturned, full.overturned)
    moved = full.peak_rotation > 0.02
    np.testing.assert_allclose(short.peak_rotation[moved], full.peak_rotation[moved], rtol=1e-3)
    for level in np.unique(strength):
        assert short.block_steps[strength == level].sum() < full.block_steps[strength == level].sum()


def test_contact_force_amplification_bound_matches_the_damped_oscillator() -> None:
    """Soft, lightly damped contacts amplify resonant motion, so that fewer samples are left out."""
    stiff, bare = 2e4**2, 0.02
    assert dynamic_to_static_force_ratio_upper_bound(np.array([stiff]), 6.0 / 2e4, 0.005) < 1.3
    assert dynamic_to_static_force_ratio_upper_bound(np.array([45.0**2]), 2.0 * bare / 45.0, 0.005) > 30.0
    # Compared with the integral of the oscillator's impulse response.
    frequency, damping, t = 30.0, 0.2, np.arange(400_000) * 1e-5
    fast = np.sqrt(1.0 - damping**2) * frequency
    force = np.exp(-damping * frequency * t) * np.sin(fast * t + 2.0 * np.arcsin(damping)) * frequency**2 / fast
    found = dynamic_to_static_force_ratio_upper_bound(np.array([frequency**2]), 2.0 * damping / frequency, 0.001)
    np.testing.assert_allclose(found, np.abs(force).sum() * 1e-5, rtol=1e-3)


@given(
    samples=st.integers(1, 200),
    interval=st.sampled_from([0.001, 0.0025, 0.004, 0.005, 0.01, 0.02, 0.05, 0.1, 0.5, 1.0]),
    seed=st.integers(0, 1000),
)
def test_the_largest_acceleration_ahead_is_the_maximum_of_its_window(samples: int, interval: float, seed: int) -> None:
    """The result equals the maximum over the samples ahead; it is infinite if these samples go beyond the record."""
    size = np.zeros((2, samples + 3))
    size[:, :samples] = np.random.default_rng(seed).random((2, samples))
    found = max_acceleration_in_window_by_rest_check(size, interval)
    assert found.shape == (2, samples // SAMPLES_PER_REST_CHECK_BLOCK + 1, CHECKED_SAMPLES_PER_REST_CHECK_BLOCK)
    for (row, leap, look), largest in np.ndenumerate(found):
        at = SAMPLES_PER_REST_CHECK_BLOCK * leap + look
        window = size[
            row,
            at : at + SAMPLES_PER_REST_CHECK_BLOCK + int(np.ceil(LEAD_TIME_BEFORE_POSSIBLE_MOVEMENT_S / interval)) + 1,
        ]
        assert largest == (window.max() if at + SAMPLES_PER_REST_CHECK_BLOCK <= samples else np.inf)
