"""Statics of scenes: rest, limit of overhang, blocks on slopes, uplift, and critical angles."""

import numpy as np
import pytest

from overturning.dem.polygon.prepare import SceneEquilibriumStiffnessAndRockingLimits, prepare_scene
from overturning.dem.simulate import simulate_as_arrays
from overturning.dem.trajectory import trajectory
from overturning.model.scene import Scene
from tests.dem.polygon_scenes import (
    GROUND,
    SHIPPED_SCENES,
    block_element,
    load_shipped_scene,
    motion_at_rest,
    motion_towards_north,
    plan_single_case,
    run_planned_case,
    scene_of_elements,
)
from tests.dem.reference.particles import final_slip_on_slope

GRAVITY = 9.80665


@pytest.mark.parametrize("name", SHIPPED_SCENES)
def test_a_scene_rests_for_a_minute_without_creep(name: str) -> None:
    motion = motion_at_rest(60)
    _, _, poses = run_planned_case(plan_single_case(load_shipped_scene(name), motion, friction=0.5), motion)
    assert len(poses) == motion.sample_count
    assert np.abs(poses - poses[0]).max() <= 1e-8


def test_a_tower_of_ten_blocks_stands() -> None:
    made = scene_of_elements(
        *(block_element(f"b{n}", 0.4 + 0.01 * (n % 3), 0.2, "ground" if n == 0 else f"b{n - 1}") for n in range(10))
    )
    motion = motion_at_rest(5)
    answers, _, poses = run_planned_case(plan_single_case(made, motion), motion)
    assert answers.status[0] == 0
    assert np.abs(poses - poses[0]).max() <= 1e-8
    assert (answers.overturned == 0).all()


@pytest.mark.parametrize("blocks", [2, 4, 6])
@pytest.mark.parametrize("share", [0.98, 1.02])
def test_a_stack_stands_up_to_the_harmonic_overhang(blocks: int, share: float) -> None:
    """The k-th block from the top can overhang the one below by B/2k: 2 % less stands, 2 % more falls."""
    table = {"name": "table", "kind": "driven", "width": 2, "height": 1, "at": [-1, -1]}
    made = scene_of_elements(table, *_elements_of_overhanging_block_stack(blocks, share))
    motion = motion_at_rest(6)
    _, _, poses = run_planned_case(plan_single_case(made, motion), motion)
    fell = np.abs(poses[-1, 1:, 2]).max() > 0.05
    assert fell == (share > 1)
    assert prepare_scene(made).has_static_equilibrium == (share < 1)
    if share < 1:
        # It settles by less than the static penetration, as statics assume small rotations, and then stays.
        assert np.abs(poses - poses[0]).max() < 2e-5
        assert np.abs(poses[-1] - poses[300]).max() <= 1e-8


def _elements_of_overhanging_block_stack(blocks: int, share_of_limit_overhang: float) -> list[dict[str, object]]:
    """Return blocks that overhang each other by `share` of the limit B/2k, k counted from the top."""
    made = []
    for n in range(blocks):  # from the bottom; the edge of the table is at x = 0, its centre at −1
        overhang = share_of_limit_overhang * 1.0 / (2 * (blocks - n))
        x = 1.0 - 0.5 + overhang if n == 0 else overhang
        made.append(block_element(f"b{n}", 1.0, 0.2, "table" if n == 0 else f"b{n - 1}", x=x))
    return made


def _block_on_slope(tangent: float, width: float, height: float, **keys: object) -> Scene:
    """Return a scene of a block on a slope with the given tangent that moves with the base motion."""
    slope = {"name": "slope", "kind": "driven", "vertices": [[-5, 0], [5, 0], [5, 10 * tangent]]}
    stone = {
        "name": "stone", "width": width, "height": height, "at": [0, 5 * tangent],
        "rotation_deg": -float(np.degrees(np.arctan(tangent))),
    }  # fmt: skip
    return scene_of_elements(slope, stone, **keys)


@pytest.mark.parametrize("friction", [0.297, 0.303, 0.2])
def test_a_block_slips_on_a_slope_at_its_friction_angle(friction: float) -> None:
    motion = motion_at_rest(2)
    _, time, poses = run_planned_case(plan_single_case(_block_on_slope(0.3, 0.5, 0.5), motion, friction), motion)
    way = np.hypot(poses[:, 1, 0] - poses[0, 1, 0], poses[:, 1, 1] - poses[0, 1, 1])
    if friction > 0.3:
        # The lighter corner slips by a part of the static penetration (1e-5 m), and its load goes to the other.
        assert way.max() < 4e-6
        assert np.ptp(way[100:]) <= 1e-9
        finer = plan_single_case(_block_on_slope(0.3, 0.5, 0.5), motion, friction, time_step="0.125 stable")
        _, _, poses = run_planned_case(finer, motion)
        assert np.hypot(*(poses[:, 1, :2] - poses[0, 1, :2]).T).max() < 2e-6
    else:
        angle = np.arctan(0.3)
        exact = GRAVITY * (np.sin(angle) - friction * np.cos(angle))
        speed = np.hypot(poses[:, 1, 3], poses[:, 1, 4])
        assert (speed[-1] - speed[50]) / (time[-1] - time[50]) == pytest.approx(exact, rel=1e-3)
        assert poses[-1, 1, 0] < poses[0, 1, 0]


@pytest.mark.parametrize("b_over_h", [0.35, 0.5, 0.8])
@pytest.mark.parametrize("height", [0.6, 1.2])
def test_a_scaled_block_on_a_slope_is_a_rectangle_with_the_expected_rocking_threshold(
    height: float, b_over_h: float
) -> None:
    """A block of critical angle α on a slope β tips downhill from tan(α − β) g, and rests on its whole base."""
    prepared = prepare_scene(_block_on_slope(0.2, 0.3, 0.6), height, b_over_h)
    assert prepared.no_rocking_below_acceleration_g == pytest.approx(
        np.tan(np.arctan(b_over_h) - np.arctan(0.2)), rel=1e-9
    )
    sides = np.diff(prepared.elements[1].vertices_in_scene[:3], axis=0)
    assert np.hypot(*sides.T) == pytest.approx([b_over_h * height, height])
    assert sides[0] @ sides[1] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize(("friction", "share"), [(0.4, 0.8), (0.4, 1.2), (0.4, 1.6), (0.22, 1.5)])
def test_a_block_on_a_slope_is_simulated_above_its_sliding_threshold(friction: float, share: float) -> None:
    """On a slope t = 0.2 sliding starts at (µ − t)/(1 + µ t) g, less than µ g; tested from below to above it."""
    threshold = (friction - 0.2) / (1.0 + 0.2 * friction)
    time = np.arange(0.0, 6.0, 0.01)
    wave = np.where((time > 2.5) & (time < 5.5), np.sin(2 * np.pi * (time - 2.5)), 0.0)
    acceleration = share * threshold * GRAVITY * wave
    expected = final_slip_on_slope(acceleration, 0.01, friction, 0.2) / np.hypot(1.0, 0.2)
    motion = motion_towards_north(acceleration)
    found = simulate_as_arrays(motion, _block_on_slope(0.2, 0.4, 0.3), azimuth_deg=[0], friction=[friction])
    assert (found["status"].item() == 1) == (share < 1)
    assert (abs(expected) > 0.002) == (share > 1)
    assert found["residual_slip"].item() == pytest.approx(expected, rel=5e-3, abs=1e-4)


def test_a_block_sliding_down_a_slope_without_base_motion_counts_as_fallen() -> None:
    """With µ below the slope the block slides down and counts as fallen; µ is given by the scene or by the grid."""
    for keys in ({}, {"contacts": [{"between": ["stone", "stone"], "friction": 0.15}]}):
        made = _block_on_slope(0.2, 0.4, 0.3, **keys)
        found = simulate_as_arrays(motion_at_rest(4), made, azimuth_deg=[0], **({} if keys else {"friction": [0.15]}))
        assert found["overturned"].item() == -1


@pytest.mark.parametrize(("width", "height", "peak", "duration"), [(2.0, 2.0, 18.0, 0.09), (0.8, 0.5, 20.0, 0.03)])
def test_a_block_that_slides_as_the_record_ends_is_simulated_until_it_stops(
    width: float, height: float, peak: float, duration: float
) -> None:
    """The record ends with the pulse; a fifth of the slip occurs up to 0.1 s later."""
    time = np.arange(0.0, duration + 1e-9, 0.005)
    pulse = -peak * np.sin(np.pi * time / duration)
    expected = final_slip_on_slope(pulse, 0.005, 0.2, 0.0)
    plinth = {"name": "plinth", "kind": "driven", "width": 3.0 * width, "height": 0.5, "at": [0, -0.5]}
    found = simulate_as_arrays(
        motion_towards_north(pulse, 0.005),
        scene_of_elements(plinth, block_element("stone", width, height, "plinth")),
        azimuth_deg=[0],
        friction=[0.2],
    )
    assert found["overturned"].item() == 0
    for name in ("residual_slip", "peak_slip"):
        assert found[name].item() == pytest.approx(expected, rel=5e-3)


@pytest.mark.parametrize("slenderness", [0.297, 0.303])
def test_a_block_on_a_slope_steeper_than_its_b_over_h_tips(slenderness: float) -> None:
    motion = motion_at_rest(6)
    _, _, poses = run_planned_case(plan_single_case(_block_on_slope(0.3, slenderness, 1.0), motion, 2.0), motion)
    if slenderness > 0.3:
        assert np.abs(poses[-1, 1] - poses[0, 1]).max() < 5e-6
        assert np.abs(poses[-1, 1] - poses[300, 1]).max() <= 1e-8
    else:
        assert poses[-1, 1, 2] < -0.3


STACK_WITH_TALL_TOP = (block_element("lower", 0.6, 0.6), block_element("upper", 0.2, 1.0, "lower"))
SLIM_STACK = (block_element("lower", 0.3, 0.9), block_element("upper", 0.28, 0.3, "lower"))


@pytest.mark.parametrize(("elements", "moves"), [(STACK_WITH_TALL_TOP, "upper"), (SLIM_STACK, "both")])
def test_stacks_of_two_blocks_lift_off_at_the_static_threshold(
    elements: tuple[dict[str, object], ...], moves: str
) -> None:
    """Either the upper block lifts off at g b₂/h₂, or both together when their resultant leaves the base."""
    made = scene_of_elements(*elements)
    prepared = prepare_scene(made)
    lower, upper = prepared.elements[1:]
    alone = upper.shape.width / upper.shape.height
    mass = lower.mass + upper.mass
    together = (
        0.5 * lower.shape.width / ((lower.mass * lower.centre_of_mass_z + upper.mass * upper.centre_of_mass_z) / mass)
    )
    threshold = min(alone, together)
    assert (alone < together) == (moves == "upper")
    assert prepared.no_rocking_below_acceleration_g == pytest.approx(threshold, rel=1e-9)
    rate = 1.2 * threshold * GRAVITY / 3.0
    ramp = motion_towards_north(-rate * np.linspace(0, 3, 301))
    _, time, poses = run_planned_case(plan_single_case(made, ramp, 5.0), ramp)
    gaps = {
        name: np.array([_largest_gap_of_lower_corners_to_block_below(prepared, pose, index) for pose in poses])
        for name, index in (("lower", 1), ("upper", 2))
    }
    first = {name: rate * time[np.flatnonzero(gap > 0)[0]] if (gap > 0).any() else np.inf for name, gap in gaps.items()}
    index = "upper" if moves == "upper" else "lower"
    # One sample of the ramp is 0.4 % of the threshold.
    assert first[index] == pytest.approx(threshold * GRAVITY, rel=6e-3)
    assert first["lower" if index == "upper" else "upper"] > 1.02 * first[index]


def _largest_gap_of_lower_corners_to_block_below(
    prepared: SceneEquilibriumStiffnessAndRockingLimits, pose: np.ndarray, index: int
) -> float:
    """Return the gap (m) between the higher of a block's lower corners and the upper face of the block below."""
    item, below = prepared.elements[index], prepared.elements[index - 1]
    gaps = []
    for side in (-0.5, 0.5):
        p, q = side * item.shape.width, -0.5 * item.shape.height
        c, s = np.cos(pose[index, 2]), np.sin(pose[index, 2])
        dx = pose[index, 0] + c * p + s * q - pose[index - 1, 0]
        dz = pose[index, 1] - s * p + c * q - pose[index - 1, 1]
        c, s = np.cos(pose[index - 1, 2]), np.sin(pose[index - 1, 2])
        gaps.append(s * dx + c * dz - 0.5 * below.shape.height)
    return max(gaps)


def test_stacks_of_two_blocks_rock_in_the_four_patterns_of_the_literature() -> None:
    """Same sense, opposite senses, both as one body, or upper alone (Psycharis 1990; Spanos et al. 2001)."""
    seen = set()
    for elements in (STACK_WITH_TALL_TOP, SLIM_STACK):
        made = scene_of_elements(*elements)
        level = prepare_scene(made).no_rocking_below_acceleration_g * GRAVITY
        for period in (0.5, 1.0, 2.0):
            time = np.arange(0, 6, 0.01)
            pulse = motion_towards_north(np.where(time < period, -1.6 * level * np.sin(2 * np.pi * time / period), 0.0))
            _, _, poses = run_planned_case(plan_single_case(made, pulse, 5.0), pulse)
            lower, relative = poses[:, 1, 2], poses[:, 2, 2] - poses[:, 1, 2]
            up, turned = np.abs(lower) > 2e-3, np.abs(relative) > 2e-3
            seen |= {"one body"} if (up & ~turned).any() else set()
            seen |= {"upper alone"} if (~up & (np.abs(lower) < 1e-4) & turned).any() else set()
            seen |= {"same way"} if (up & turned & (lower * relative > 0)).any() else set()
            seen |= {"opposite ways"} if (up & turned & (lower * relative < 0)).any() else set()
    assert seen == {"one body", "upper alone", "same way", "opposite ways"}


def test_a_block_stopped_by_a_wall_leans_at_the_geometric_angle() -> None:
    wall = {"name": "wall", "kind": "driven", "width": 0.3, "height": 2, "at": [0.42 + 0.15, 0]}
    ground = {"name": "ground", "kind": "driven", "width": 40, "height": 1, "at": [0, -1]}
    made = scene_of_elements(ground, wall, block_element("stone", 0.24, 0.6))
    time = np.arange(0, 10, 0.01)
    pulse = motion_towards_north(np.where(time < 0.6, -6.0 * np.sin(np.pi * time / 0.6), 0.0))
    answers, _, poses = run_planned_case(plan_single_case(made, pulse, 3.0), pulse, samples_after_record=3000)
    x, _, angle = poses[-1, 2, :3]
    pivot = x + np.cos(angle) * 0.12 - np.sin(angle) * 0.3
    assert answers.status[0] == 0
    assert answers.overturned[0] == 1, "it stays leaning on the wall"
    assert np.abs(poses[-1, 2, 3:]).max() < 1e-3
    # Its upper corner touches the wall: H sin θ is the distance of the wall from the pivot.
    assert angle == pytest.approx(np.arcsin((0.42 - pivot) / 0.6), abs=1e-4)
    assert angle > np.arctan(0.4)
    # Without the wall the same pulse overturns it.
    free = scene_of_elements(block_element("stone", 0.24, 0.6))
    alone = simulate_as_arrays(pulse, free, azimuth_deg=[0], friction=[3.0], general=True, leave_out=False)
    assert alone["overturned"].item() == 1


def test_the_highest_contact_frequency_is_that_between_two_free_blocks() -> None:
    """Each of the two blocks adds K (1/m + r²/I) = 4 K/m to ω²; a block at rest on the ground has at most 6 K/m."""
    made = prepare_scene(
        scene_of_elements(block_element("one", 0.3, 0.3, x=-0.2), block_element("other", 0.3, 0.3, x=0.25))
    )
    masses = [item.mass for item in made.elements if not item.has_prescribed_motion]
    stiffness = made.pair_contact_laws.normal_stiffness[made.pairs.index((2, 1, 0, 0))]
    assert made.max_omega_squared_on_springs == pytest.approx(
        4.0 * stiffness * sum(1.0 / mass for mass in masses), rel=1e-9
    )


def test_a_case_ends_when_the_energy_is_too_low_to_overturn() -> None:
    """E/E_max = 1 − (1 − θ/α)² (Housner 1963): a case ends after its record when E is clearly below E_max."""
    time, alpha = np.arange(0, 0.605, 0.01), np.arctan(0.2)
    made = scene_of_elements(block_element("block", 0.12, 0.6))
    for peak, share, ended in ((2.6, 0.37, True), (3.0, 0.67, False)):
        motion = motion_towards_north(np.where(time < 0.3, peak * np.sin(2 * np.pi * time / 0.3), 0.0))
        answers, times, path = run_planned_case(plan_single_case(made, motion), motion, 300)
        angle = np.abs(path[:, 1, 2]) / alpha
        assert not answers.overturned.any()
        assert 1 - (1 - angle.max()) ** 2 == pytest.approx(share, abs=0.01)
        assert (times[-1] < motion.duration + 0.2) == ended
        assert (angle[-1] > 0.1) == ended, "it still rocks"
        # On one corner the static penetration is twice that on both corners (1e-7 B).
        turned = np.abs(path[:, 1, 2])
        height = path[:, 1, 1] - (0.3 * np.cos(turned) + 0.06 * np.sin(turned))
        assert np.median(height[angle > 0.05]) == pytest.approx(-2e-7 * 0.12, rel=0.05)


def leaning_shaft(lean: float, *more: dict[str, object]) -> Scene:
    """Return a shaft (0.2 m × 0.6 m) that leans towards the azimuth by `lean` (rad) on a wider base."""
    shaft = block_element("shaft", 0.2, 0.6, "base", rotation_deg=float(np.degrees(lean)))
    return scene_of_elements(GROUND, block_element("base", 0.6, 0.5), shaft, *more)


@pytest.mark.parametrize("lean_deg", [0.0, np.degrees(1e-9), np.degrees(1e-6), 0.001, 0.09, -0.09])
def test_a_shaft_leaning_less_than_a_tenth_of_a_degree_has_a_critical_angle(lean_deg: float) -> None:
    """α = atan(b/h) of the centre, minus the lean; the peak rotation is a share of this α, as in an upright shaft."""
    made = leaning_shaft(np.radians(lean_deg))
    prepared = prepare_scene(made)
    expected = np.arctan(1.0 / 3.0) - abs(np.radians(lean_deg))
    np.testing.assert_allclose(prepared.tipping_angles[1:], [np.arctan(0.6 / 0.5), expected], rtol=1e-9)
    time = np.arange(0.0, 2.0, 0.01)
    motion = motion_towards_north(4.0 * np.sin(2.0 * np.pi * 2.0 * time))
    found, upright = (
        trajectory(motion, one, azimuth_deg=0, friction=0.7).sel(element="shaft") for one in (made, leaning_shaft(0.0))
    )
    assert 0.3 < float(found["peak_rotation"]) < 1.0
    largest = float(np.abs(found["rotation"]).max())
    assert float(found["peak_rotation"]) == pytest.approx(largest / expected, rel=0.02)
    if abs(lean_deg) < 1e-4:
        assert float(found["peak_rotation"]) == pytest.approx(float(upright["peak_rotation"]), abs=1e-3)


def test_a_shaft_leaning_by_0_2_degrees_has_no_critical_angle_but_its_base_has() -> None:
    alpha = prepare_scene(leaning_shaft(np.radians(0.2))).tipping_angles
    assert np.isnan(alpha[2])
    assert alpha[1] == pytest.approx(np.arctan(0.6 / 0.5))


def test_a_shaft_leaning_slightly_against_a_wall_has_a_critical_angle() -> None:
    lean = np.radians(0.05)
    edge = prepare_scene(leaning_shaft(lean)).elements[2].vertices_in_scene[:, 0].max()
    wall = {"name": "wall", "kind": "driven", "width": 0.2, "height": 1.0, "at": [edge + 0.1, 0.6]}
    assert prepare_scene(leaning_shaft(lean, wall)).tipping_angles[2] == pytest.approx(
        np.arctan(1.0 / 3.0) - lean, rel=1e-6
    )
