"""Scene outcomes are bit-equal for any threads, order and other cases; mirrored and shortened cases agree."""

import numpy as np
import pytest

from overturning.dem.numerics import NumericalOptions
from overturning.dem.run import simulate_cases
from overturning.dem.simulate import simulate, simulate_as_arrays
from overturning.dem.trajectory import trajectory
from overturning.model.cases import Cases
from overturning.model.geometry import reference_element_height_and_b_over_h
from overturning.model.scene import Scene
from overturning.model.variables import PLANAR_OUTCOME_VARIABLES
from overturning.motion.motion import Motion
from tests.dem.near_field import strong_part_of_near_field_record
from tests.dem.polygon_scenes import block_element, load_shipped_scene, motion_towards_north, scene_of_elements

RESULT_FIELDS = (*(item.name for item in PLANAR_OUTCOME_VARIABLES if item.name != "mirrored"), "block_steps")


def noisy_motion() -> Motion:
    """Return 4 s of motion, sines with random noise, rounded to 1e-9 m/s²."""
    time = np.arange(0, 4, 0.01)
    rng = np.random.default_rng(7)
    noise = np.convolve(rng.normal(size=(time.size)), np.ones(12) / 12, "same")
    # Rounded as in motion.nc: the last digit of the sine depends on the processor.
    north, east = 9 * np.sin(5 * time) + 8 * noise, 6 * np.cos(4 * time) - 7 * noise[::-1]
    return Motion(np.round(north, 9), np.round(east, 9), sampling_interval=0.01)


def random_cases_of_scene(scene: Scene, count: int = 90) -> Cases:
    """Return random cases of a scene: azimuth, height, B/H and friction."""
    height, ratio = reference_element_height_and_b_over_h(scene)
    rng = np.random.default_rng(3)
    return Cases(
        rng.integers(0, 360, count).astype(float), height * rng.choice([1.0, 2.0], count),
        ratio * rng.choice([0.8, 1.0], count), rng.choice([0.3, 0.8, 3.0], count),
    )  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("name", ["three-tier", "against-a-wall", "boulder"])
def test_results_do_not_depend_on_threads_order_or_other_cases(name: str) -> None:
    made, motion = load_shipped_scene(name), noisy_motion()
    cases = random_cases_of_scene(made)
    nominal = simulate_cases(made, motion, cases)
    assert (nominal.overturned != 0).any()
    order = np.random.default_rng(1).permutation(cases.case_count)[:50]
    mixed = Cases(
        *(np.asarray(getattr(cases, key))[order] for key in ("azimuth_deg", "height", "b_over_h", "friction"))
    )
    threads = simulate_cases(made, motion, cases, NumericalOptions(threads=2))
    shuffled = simulate_cases(made, motion, mixed)
    for field in RESULT_FIELDS:
        np.testing.assert_array_equal(getattr(threads, field), getattr(nominal, field))
        np.testing.assert_array_equal(getattr(shuffled, field), getattr(nominal, field)[order])


def test_mirrored_outcomes_of_symmetric_scenes_equal_simulated_ones() -> None:
    made, motion = load_shipped_scene("three-tier"), noisy_motion()
    azimuths = [20.0, 75.0, 130.0, 200.0, 255.0, 310.0]
    both = simulate_as_arrays(motion, made, azimuth_deg=azimuths, friction=[0.4, 1.0], leave_out=False)
    half = simulate_as_arrays(motion, made, azimuth_deg=azimuths, friction=[0.4, 1.0])
    assert (both["overturned"] != 0).any()
    assert not both["mirrored"].any()
    assert half["mirrored"][3:].all()
    for name in ("overturned", "peak_rotation", "peak_slip", "residual_slip", "overturning_time"):
        sign = -1 if name in ("overturned", "residual_slip") else 1
        np.testing.assert_array_equal(both[name][3:], sign * both[name][:3])
    np.testing.assert_array_equal(half["overturned"], both["overturned"])


def test_outcomes_of_asymmetric_scenes_are_not_mirrored() -> None:
    arrays = simulate_as_arrays(
        noisy_motion(), load_shipped_scene("boulder"), azimuth_deg=[20.0, 200.0], friction=[1.0]
    )
    assert not arrays["mirrored"].any()
    assert arrays["overturning_time"][0] != arrays["overturning_time"][1]


def test_skipping_times_at_rest_changes_no_overturning_flag_of_a_scene() -> None:
    """Motions start and end quietly, with peaks below and above the rest threshold; only times at rest are skipped.

    Azimuths of one quadrant are enough: towards the others the motion and the scene are mirrored.
    """
    made, azimuths = load_shipped_scene("three-tier"), np.arange(0.0, 91.0, 15.0)
    time = np.arange(0, 12, 0.01)
    strong = np.where((time > 4) & (time < 7), 1.0, 0.02) * np.sin(6 * time)
    for level in (2.0, 4.5, 9.0):
        motion = motion_towards_north(level * strong)
        full = simulate_as_arrays(motion, made, azimuth_deg=azimuths, friction=[0.3, 1.0], leave_out=False)
        short = simulate_as_arrays(motion, made, azimuth_deg=azimuths, friction=[0.3, 1.0])
        np.testing.assert_array_equal(short["overturned"], full["overturned"])
        assert short["block_steps"].sum() < 0.9 * full["block_steps"].sum()


@pytest.mark.parametrize(("number", "factor"), [(6, 1.0), (7, 1.5), (9, 1.0)])
def test_ending_a_case_once_no_more_stones_can_fall_changes_no_flag(number: int, factor: float) -> None:
    """Under real records, once the shaft has fallen, the bases are simulated only while the record could lift them."""
    strong = strong_part_of_near_field_record(number, 4.0, 12.0).scaled_by(factor)
    height, _ = reference_element_height_and_b_over_h(load_shipped_scene("three-tier"))
    grid = np.meshgrid(np.arange(0, 180, 15.0), [height], [0.2, 0.3], [0.6, 1.0], indexing="ij")
    cases = Cases(*(axis.ravel() for axis in grid))
    whole = simulate_cases(load_shipped_scene("three-tier"), strong, cases, NumericalOptions(leave_out=False))
    ended = simulate_cases(load_shipped_scene("three-tier"), strong, cases)
    assert (whole.overturned[:, 2] != 0).mean() > 0.5
    np.testing.assert_array_equal(ended.overturned, whole.overturned)
    np.testing.assert_allclose(ended.peak_rotation[:, 2], whole.peak_rotation[:, 2], rtol=5e-3)
    assert ended.block_steps.sum() < 0.7 * whole.block_steps.sum()


def test_a_trajectory_has_the_outcome_of_the_same_case_in_a_sweep() -> None:
    made, motion = load_shipped_scene("three-tier"), noisy_motion()
    sweep = simulate(motion, made, azimuth_deg=[30.0, 120.0], friction=[0.8])
    path = trajectory(motion, made, azimuth_deg=120.0, friction=0.8)
    cell = sweep.isel(azimuth=1, height=0, b_over_h=0, friction=0)
    assert list(sweep["element"].values) == ["lower-base", "upper-base", "shaft"]
    assert list(path["element"].values) == ["ground", *sweep["element"].values]
    np.testing.assert_array_equal(path["overturned"], [np.nan, *cell["overturned"].values])
    np.testing.assert_array_equal(path["peak_rotation"].values[1:], cell["peak_rotation"].values)
    rotation = path["rotation"].sel(element="shaft").to_numpy()
    assert min(np.abs(rotation).max(), 0.5 * np.pi) / np.arctan(0.242 / 0.636) == pytest.approx(
        cell["peak_rotation"].values[2], rel=2e-2
    )


def test_bad_arguments_of_a_scene_simulation_are_refused() -> None:
    made = scene_of_elements(block_element("stone", 0.3, 0.6), block_element("cap", 0.2, 0.1, "stone"))
    motion = noisy_motion()
    from overturning.errors import ArgumentError

    with pytest.raises(ArgumentError, match="scheme: 'euler'"):
        simulate_as_arrays(motion, made, azimuth_deg=[0], scheme="euler")
    with pytest.raises(ArgumentError, match="threads: 0"):
        simulate_as_arrays(motion, made, azimuth_deg=[0], threads=0)
    with pytest.raises(ArgumentError, match="not stable; at most"):
        simulate_as_arrays(motion, made, azimuth_deg=[0], time_step=0.005)
    with pytest.raises(ArgumentError, match="rotate an element"):
        simulate_cases(made, motion, Cases([0.0], [0.6], [0.5], [1.0], initial_tilt=0.1))
