"""An element at rest in another pose than its initial one has fallen; fall angles from the height of the centre."""

from typing import Any

import numpy as np
import pytest

from overturning.dem.numerics import NumericalOptions
from overturning.dem.polygon.prepare import prepare_scene
from overturning.dem.run import simulate_cases
from overturning.dem.trajectory import trajectory
from overturning.figures.film_of_trajectory import outcome_sentence
from overturning.model.cases import Cases
from overturning.model.geometry import reference_element_height_and_b_over_h, scale_and_place_elements
from overturning.model.results import CaseResults
from overturning.model.scene import Scene
from overturning.model.status import CaseStatus
from overturning.motion.motion import Motion
from tests.dem.near_field import near_field_motion_and_fault_component_azimuths
from tests.dem.polygon_scenes import (
    GROUND,
    block_element,
    load_shipped_scene,
    motion_at_rest,
    motion_towards_north,
    scene_of_elements,
)
from tests.sources import shipped_files

REST_ROTATION_SEARCH_STEP_RAD = np.radians(0.02)
SHIPPED_SCENE_NAMES = sorted(path.stem for path in shipped_files("config/scenes/*.yaml"))


def rotations_of_polygon_at_rest_on_ground(vertices: np.ndarray) -> np.ndarray:
    """Return the rotations, rad, at which a body can rest on level ground: the height of its centre is a minimum."""
    angles = np.arange(-np.pi, np.pi, REST_ROTATION_SEARCH_STEP_RAD)
    height = (np.outer(np.sin(angles), vertices[:, 0]) - np.outer(np.cos(angles), vertices[:, 1])).max(axis=1)
    lowest = (height < np.roll(height, 1)) & (height < np.roll(height, -1))
    return angles[lowest]


def smallest_rotations_to_rest_on_other_side(vertices: np.ndarray) -> list[float]:
    """Return the smallest rotations to −x and to +x, rad, at which the body can rest on another side; π if none."""
    rests = rotations_of_polygon_at_rest_on_ground(vertices)
    rests = rests[np.abs(rests) > 2 * REST_ROTATION_SEARCH_STEP_RAD]
    return [float(turned[turned > 0].min(initial=np.pi)) for turned in (-rests, rests)]


@pytest.mark.parametrize("name", SHIPPED_SCENE_NAMES)
def test_fall_angles_of_shipped_scenes_are_rotations_to_rest_on_another_side(name: str) -> None:
    for item in scale_and_place_elements(load_shipped_scene(name)):
        if not item.has_prescribed_motion:
            assert item.fall_rotations_to_minus_and_plus_x_rad == pytest.approx(
                smallest_rotations_to_rest_on_other_side(item.shape.vertices_from_whole_polygon_centroid),
                abs=REST_ROTATION_SEARCH_STEP_RAD,
            ), item.element.name
            if item.element.width is not None:
                assert item.fall_rotations_to_minus_and_plus_x_rad == pytest.approx((0.5 * np.pi,) * 2, abs=1e-11)


def random_standing_polygon(generator: np.random.Generator) -> list[list[float]]:
    """Return a random convex polygon that stands on the side between its first two vertices."""
    while True:
        angles = np.sort(generator.uniform(0, 2 * np.pi, generator.integers(3, 9)))
        points = np.stack([np.cos(angles), generator.uniform(0.5, 1.5) * np.sin(angles)], axis=1)
        points = (points - points[0]) @ matrix_rotating_side_to_horizontal(points[1] - points[0])
        if is_convex(points) and 0.0 < x_distance_of_centre_from_first_vertex(points) < points[1, 0]:
            return points.tolist()


def x_distance_of_centre_from_first_vertex(points: np.ndarray) -> float:
    """Return the distance of a polygon's centre of mass from its first vertex along x, m."""
    (x, z), (right, up) = points.T, np.roll(points, -1, axis=0).T
    areas = x * up - right * z
    return float((areas * (x + right)).sum() / (3.0 * areas.sum()) - x[0])


def matrix_rotating_side_to_horizontal(side: np.ndarray) -> np.ndarray:
    """Return the matrix which rotates a side, a vector (x, z), into the horizontal."""
    x, z = side / np.linalg.norm(side)
    return np.array([[x, -z], [z, x]])


def is_convex(points: np.ndarray) -> bool:
    """True if a polygon is convex by a margin."""
    edges = np.roll(points, -1, axis=0) - points
    following = np.roll(edges, -1, axis=0)
    return bool((edges[:, 0] * following[:, 1] - edges[:, 1] * following[:, 0] > 0.02).all())


def test_fall_angles_of_random_polygons_are_rotations_to_rest_on_another_side() -> None:
    generator = np.random.default_rng(5)
    for _ in range(60):
        vertices = random_standing_polygon(generator)
        body = scale_and_place_elements(
            scene_of_elements({"name": "body", "vertices": vertices, "stands_on": "ground"})
        )[1]
        assert body.fall_rotations_to_minus_and_plus_x_rad == pytest.approx(
            smallest_rotations_to_rest_on_other_side(body.shape.vertices_from_whole_polygon_centroid),
            abs=2 * REST_ROTATION_SEARCH_STEP_RAD,
        ), vertices


def simulate_fall_flags_and_peak_rotations(made: Scene, motion: Motion, **keys: Any) -> tuple[np.ndarray, np.ndarray]:
    """Simulate a scene along azimuth 0; return overturning flags and peak rotations of its elements."""
    found = simulate_cases(made, motion, Cases([0.0], *reference_element_height_and_b_over_h(made), 0.7, **keys))
    return np.atleast_1d(found.overturned[0]), found.peak_rotation[0]


def slab_with_sides_leaning_to_minus_x(**keys: Any) -> Scene:
    """Return a slab 2.2 m wide and 1 m high with sides leaning 30° to −x; it tips at 58.4° to −x, 70.2° to +x."""
    outline = [[-1.1, 0.0], [1.1, 0.0], [0.523, 1.0], [-1.677, 1.0]]
    return scene_of_elements(
        GROUND | {"width": 200}, {"name": "slab", "vertices": outline, "stands_on": "ground"} | keys
    )


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("peak", [52.5, 52.8, 53.0, 53.2, 53.4])
def test_the_fall_angle_of_a_slab_with_leaning_sides_depends_on_the_side(peak: float, mirrored: bool) -> None:
    """The fall angle of 60° applies to −x only: a slab rotated by more than 60° to +x comes back."""
    push = np.zeros(1500)
    push[50:125] = peak if mirrored else -peak
    motion = Motion(push, 0 * push, sampling_interval=0.004, trust_data=True)
    shapes = [slab_with_sides_leaning_to_minus_x(**keys) for keys in ({}, {"fallen_rotation_deg": 100.0})]
    if mirrored:
        shapes = [copy_scene_with_mirrored_slab_outline(made) for made in shapes]
    found = [simulate_single_case(made, motion, 10.0) for made in shapes]
    assert [one.status[0] for one in found] == [CaseStatus.SIMULATED] * 2
    assert found[0].overturned[0] == found[1].overturned[0] == (peak > 53.1) * (-1 if mirrored else 1)
    if peak == 53.0:
        assert (
            60.0
            < np.degrees(
                found[0].peak_rotation[0] * prepare_scene(shapes[0]).weaker_side_critical_angles_else_fall_angles[1]
            )
            < 70.2
        )
    if peak > 53.1:
        np.testing.assert_array_equal(found[0].overturning_time, found[1].overturning_time)


def copy_scene_with_mirrored_slab_outline(made: Scene) -> Scene:
    """Return the scene with the outline of its slab mirrored left to right."""
    slab = made.elements[1]
    assert slab.vertices is not None
    outline = tuple((-x, z) for x, z in reversed(slab.vertices))
    return made.model_copy(update={"elements": (made.elements[0], slab.model_copy(update={"vertices": outline}))})


@pytest.mark.parametrize("peak", [8.0, 9.0])
def test_a_boulder_that_comes_to_rest_on_another_side_has_fallen(peak: float) -> None:
    time = np.arange(0, 1.005, 0.01)
    for sign in (1.0, -1.0):
        flags, _ = simulate_fall_flags_and_peak_rotations(
            load_shipped_scene("boulder"), motion_towards_north(sign * peak * np.sin(2 * np.pi * time))
        )
        assert flags[0] != 0, "it rests at 51° or 46°"


def test_a_leaning_stone_falls_after_less_than_a_right_angle() -> None:
    """A stone 0.1 m × 0.6 m tilted by 10°, beyond its critical angle of 9.5°, lies after another 80°."""
    made = scene_of_elements(GROUND, block_element("stone", 0.1, 0.6, rotation_deg=10.0))
    assert np.degrees(scale_and_place_elements(made)[1].fall_rotations_to_minus_and_plus_x_rad) == pytest.approx(
        [100.0, 80.0]
    )
    flags, _ = simulate_fall_flags_and_peak_rotations(made, motion_at_rest(1.0))
    assert flags.tolist() == [1]


def test_a_fall_angle_given_by_the_scene_is_used() -> None:
    for angle in (30.0, 90.0, 120.0):
        made = scene_of_elements(GROUND, block_element("stone", 0.1, 0.6, fallen_rotation_deg=angle))
        assert np.degrees(scale_and_place_elements(made)[1].fall_rotations_to_minus_and_plus_x_rad) == pytest.approx(
            [angle, angle]
        )
    assert load_shipped_scene("gravestone").can_use_single_block_kernel
    assert scene_of_elements(
        GROUND, block_element("stone", 0.1, 0.6, fallen_rotation_deg=90)
    ).can_use_single_block_kernel
    assert not scene_of_elements(
        GROUND, block_element("stone", 0.1, 0.6, fallen_rotation_deg=30)
    ).can_use_single_block_kernel


def simulate_single_case(
    made: Scene, motion: Motion, friction: float = 0.7, azimuth: float = 0.0, **options: Any
) -> CaseResults:
    """Simulate a scene with the sizes of its file along one azimuth."""
    return simulate_cases(
        made,
        motion,
        Cases([azimuth], *reference_element_height_and_b_over_h(made), friction),
        NumericalOptions(**options),
    )


def sine_motion(peak: float, frequency: float, cycles: float = 4.0) -> Motion:
    """Return a sine motion towards north: peak in m/s², frequency in Hz."""
    time = np.arange(0.0, cycles / frequency + 1e-9, 0.01)
    return motion_towards_north(peak * np.sin(2 * np.pi * frequency * time))


def gate_scene() -> Scene:
    """Return a gate: two pillars 2 m apart and a lintel on both."""
    pillars = (block_element(name, 0.3, 2.2, x=x) for name, x in (("left", -1.0), ("right", 1.0)))
    return scene_of_elements(GROUND, *pillars, block_element("lintel", 2.9, 0.3, "left", x=1.0))


@pytest.mark.parametrize(
    ("motion", "azimuth", "friction"),
    [
        (None, 30.0, 0.7),
        (sine_motion(3.0, 1.0), 0.0, 1.0),
        (sine_motion(3.0, 1.5), 0.0, 1.0),
        (sine_motion(-3.0, 1.0), 0.0, 1.0),
    ],
)
def test_a_gate_that_lies_on_its_own_rubble_has_fallen(motion: Motion | None, azimuth: float, friction: float) -> None:
    """In each case the pillars end rotated by over 45°, and the lintel more than 0.8 m below its initial place."""
    motion = near_field_motion_and_fault_component_azimuths(9)[0] if motion is None else motion
    path = trajectory(motion, gate_scene(), azimuth_deg=azimuth, friction=friction)
    turned, sunk = np.degrees(path["rotation"][-1]), path["z"][0] - path["z"][-1]
    assert (np.abs(turned[1:3]) > 45.0).all(), "the gate collapses"
    assert sunk[3] > 0.8
    assert (path["overturned"][1:] == np.sign(path["x"][-1] - path["x"][0])[1:]).all()
    # Overturning times: the last time at which a pillar was below its critical angle (7.8°), and at which the lintel
    # was less than a tenth of its height below its initial place.
    angle, level, time = np.abs(path["rotation"]), path["z"].sel(element="lintel"), path["time"].to_numpy()
    for name in ("left", "right"):
        last = time[angle.sel(element=name) < np.arctan(0.3 / 2.2)].max()
        assert path["overturning_time"].sel(element=name) == pytest.approx(last, abs=0.02)
    last = time[level > level[0] - 0.03].max()
    assert path["overturning_time"].sel(element="lintel") == pytest.approx(last, abs=0.02)


@pytest.mark.parametrize(("peak", "frequency", "rocks"), [(3.75, 2.0, 0.5), (2.0, 2.0, 0.1)])
def test_rocking_gate_without_overturning_counts_as_standing(peak: float, frequency: float, rocks: float) -> None:
    found = simulate_single_case(gate_scene(), sine_motion(peak, frequency), 1.0)
    assert (found.status[0], found.overturned[0].tolist()) == (CaseStatus.SIMULATED, [0, 0, 0])
    assert rocks < found.peak_rotation[0, 0] < 1.0
    assert np.isnan(found.overturning_time).all()


def motion_shifting_ground_by_distance(distance: float, duration: float) -> Motion:
    """Return one sine cycle of acceleration that moves the ground by `distance` (m) in `duration` (s)."""
    time = np.arange(0.0, duration + 0.005, 0.01)
    return motion_towards_north(2 * np.pi * distance / duration**2 * np.sin(2 * np.pi * time / duration))


def rectangle_fixed_in_space(name: str, width: float, height: float, x: float, z: float) -> dict[str, Any]:
    """Return a rectangular element of a scene file that is fixed in space; lengths in m."""
    return {"name": name, "kind": "held", "width": width, "height": height, "at": [x, z]}


def test_a_lintel_falls_when_its_pillars_move_apart() -> None:
    """One pillar moves with the ground, the other stands on a fixed shelf; the lintel rests on 0.2 m of each."""
    ground = {"name": "ground", "kind": "driven", "width": 3.0, "height": 1.0, "at": [-1.2, -1.0]}
    pillars = (block_element("left", 0.6, 0.6, x=0.8), block_element("right", 0.6, 0.6, "shelf", x=-0.8))
    made = scene_of_elements(
        ground,
        rectangle_fixed_in_space("shelf", 3.0, 1.0, 2.4, -1.0),
        *pillars,
        block_element("lintel", 1.8, 0.2, "left", x=1.0),
    )
    found = {way: simulate_single_case(made, motion_shifting_ground_by_distance(way, 2.0)) for way in (-0.8, -0.1)}
    assert found[-0.8].overturned[0].tolist()[2] != 0
    assert 0.5 < found[-0.8].overturning_time[0, 2] < 2.5
    # Both pillars stand; after a displacement of 0.1 m so does the lintel.
    assert found[-0.8].overturned[0].tolist()[:2] == found[-0.1].overturned[0].tolist()[:2] == [0, 0]
    assert found[-0.1].overturned[0, 2] == 0


def scene_with_plate_knocked_out_by_hammer(height: float) -> Scene:
    """Return a block on a slippery plate on a fixed shelf, and a hammer on the ground that can knock out the plate."""
    hammer = {"name": "hammer", "kind": "driven", "width": 0.2, "height": 0.8 * height, "at": [-0.35, 0.1 * height]}
    return scene_of_elements(
        rectangle_fixed_in_space("shelf", 40.0, 1.0, 0.0, -1.0) | {"material": "floor"},
        hammer,
        block_element("plate", 0.4, height, "shelf", material="ice"),
        block_element("top", 0.3, 0.4, "plate"),
        materials={"stone": {}, "ice": {}, "floor": {}},
        contacts=[{"between": ["stone", "ice"], "friction": 0.02}],
    )


@pytest.mark.parametrize("height", [0.05, 0.03])
def test_the_top_of_a_stack_whose_middle_slips_out_has_fallen(height: float) -> None:
    """The top drops by under a tenth of its height: it stays upright over a 3 cm plate and leans over a 5 cm plate."""
    path = trajectory(
        motion_shifting_ground_by_distance(0.65, 0.3), scene_with_plate_knocked_out_by_hammer(height), azimuth_deg=0.0
    )
    top = path.sel(element="top")
    assert 0.5 * height < top["z"][0] - top["z"][-1] < 0.04
    assert abs(float(top["rotation"][-1])) < (0.01 if height == 0.03 else 0.2) < float(top["critical_angle"])
    assert abs(float((path["x"].sel(element="plate") - top["x"])[-1])) > 0.4
    assert top["overturned"] != 0
    assert 0.05 < top["overturning_time"] < 0.5
    assert path["overturned"].sel(element="plate") == 0


def test_a_shaft_that_ends_leaning_on_a_wall_has_fallen() -> None:
    """Shaft 0.2 m wide and 1 m high, α = 11.3°; the wall is 0.5 m away."""
    wall = {"name": "wall", "kind": "driven", "width": 0.3, "height": 2.0, "at": [0.75, 0.0]}
    made = scene_of_elements(GROUND, wall, block_element("shaft", 0.2, 1.0))
    path = trajectory(sine_motion(3.0, 1.0, 1.0), made, azimuth_deg=0.0, friction=1.0).sel(element="shaft")
    assert 20.0 < np.degrees(path["rotation"][-1]) < 40.0
    assert (path["status"], path["overturned"]) == (CaseStatus.SIMULATED, 1)


def wall_leaning_on_neighbour_and_motion(peak: float) -> tuple[Scene, Motion]:
    """Return a wall (0.3 m × 2.2 m) leaning at 80° on a neighbour 0.2 m high, and a sine motion of `peak` m/s²."""
    c, s = np.cos(np.radians(80.0)), np.sin(np.radians(80.0))
    corner = 0.15 * c + 0.2 * s / c
    made = scene_of_elements(
        GROUND, block_element("neighbour", 0.4, 0.2, x=corner + 0.2), block_element("wall", 0.3, 2.2, rotation_deg=80.0)
    )
    return made, sine_motion(peak, 2.0)


def test_a_wall_tilted_against_its_neighbour_stands_if_it_does_not_move() -> None:
    made, quiet = wall_leaning_on_neighbour_and_motion(0.01)
    found = simulate_single_case(made, quiet, 1.0)
    assert (found.status[0], found.overturned[0].tolist()) == (CaseStatus.SIMULATED, [0, 0])
    assert found.peak_rotation[0, 1] < 0.1, "in degrees: it has no α"
    assert np.isnan(prepare_scene(made).tipping_angles[2])


def test_a_wall_that_comes_to_rest_on_its_neighbour_has_fallen() -> None:
    made = scene_of_elements(GROUND, block_element("neighbour", 0.4, 0.2, x=2.0), block_element("wall", 0.3, 2.2))
    path = trajectory(sine_motion(-3.0, 0.7, 1.0), made, azimuth_deg=0.0, friction=1.0)
    wall = path.sel(element="wall")
    assert 70.0 < np.degrees(wall["rotation"][-1]) < 88.0
    assert path["overturned"].to_numpy().tolist()[1:] == [0, 1]


def arch_scene() -> Scene:
    """Return a semicircular arch of three voussoirs, 0.3 m thick, with an inner radius of 0.8 m."""
    rays = np.radians([180.0, 120.0, 60.0, 0.0])
    inner, outer = (np.column_stack([r * np.cos(rays), r * np.sin(rays)]) for r in (0.8, 1.1))
    stones = [
        {"name": name, "vertices": [inner[k].tolist(), inner[k + 1].tolist(), outer[k + 1].tolist(), outer[k].tolist()]}
        for k, name in enumerate(("sp1", "key", "sp2"))
    ]
    return scene_of_elements(GROUND, *stones)


def test_the_stones_of_an_arch_have_no_tipping_angle_and_stand_in_weak_motion() -> None:
    made = arch_scene()
    assert np.isnan(prepare_scene(made).tipping_angles[1:]).all()
    path = trajectory(sine_motion(0.01, 2.0), made, azimuth_deg=0.0, friction=1.0)
    assert path["status"] == CaseStatus.SIMULATED
    assert path["overturned"][1:].to_numpy().tolist() == [0, 0, 0]
    turned = np.degrees(np.abs(path["rotation"][:, 1:]).max("time"))
    np.testing.assert_allclose(path["peak_rotation"][1:], turned, rtol=0.05, atol=1e-4)
    assert "α" not in outcome_sentence(path)
    assert "°" in outcome_sentence(path)


def test_an_arch_falls_only_after_it_starts_to_move() -> None:
    motion = near_field_motion_and_fault_component_azimuths(9)[0]
    path = trajectory(motion, arch_scene(), azimuth_deg=32.0, friction=0.7)
    assert path["status"] == CaseStatus.SIMULATED
    fell = path["overturned"][1:] != 0
    assert fell.any()
    sunk, height = (path["z"][0] - path["z"][-1])[1:], np.ptp(path["vertices"].to_numpy()[1:, :, 1], axis=1)
    assert (fell | (sunk < 0.1 * height)).all()
    first = path["time"][np.abs(path["rotation"][:, 1:]).max("element") > np.radians(1.0)].min()
    assert float(path["overturning_time"].min()) > float(first) - 0.5 > 0.5


def trapezoid_acceleration(time: np.ndarray, level: float, start: float, end: float, ramp: float = 0.1) -> np.ndarray:
    """Return an acceleration that rises to `level`, m/s², in `ramp` s, stays and falls again to 0 at `end`, s."""
    return level * np.clip(np.minimum(time - start, end - time) / ramp, 0.0, 1.0)


def test_a_case_goes_on_while_two_stones_may_tip_as_one() -> None:
    """At 0.56 g neither block (0.40 × 0.40, 0.36 × 0.40 m) tips alone, but both together tip from 0.5 g."""
    made = scene_of_elements(
        GROUND,
        block_element("lower", 0.40, 0.40),
        block_element("upper", 0.36, 0.40, "lower"),
        block_element("finial", 0.06, 0.40, "upper"),
    )
    time = np.arange(0.0, 12.0, 0.01)
    g = 9.80665
    push = trapezoid_acceleration(time, 0.3 * g, 2.5, 3.7) + trapezoid_acceleration(time, 0.56 * g, 8.0, 9.7)
    motion = Motion(push, 0 * push, sampling_interval=0.01, trust_data=True)
    short, full = (simulate_single_case(made, motion, 1.0, leave_out=leave_out) for leave_out in (True, False))
    assert full.overturned[0].tolist() == [-1, -1, -1]
    np.testing.assert_array_equal(short.overturned, full.overturned)


PEDESTAL_ELEMENT = {"name": "pedestal", "kind": "driven", "width": 0.4}


def test_a_stone_sliding_off_its_pedestal_after_another_fall_has_fallen() -> None:
    """A slim stone falls first. Later 3 m/s² for 1.2 s pull the pedestal 0.75 m from under a stone with µ = 0.2."""
    made = scene_of_elements(
        GROUND,
        PEDESTAL_ELEMENT | {"height": 0.5},
        block_element("low", 0.4, 0.3, "pedestal"),
        block_element("slim", 0.06, 0.6, x=5.0),
    )
    time = np.arange(0.0, 11.4, 0.01)
    pulse = np.where((time >= 1.0) & (time < 2.0), 3.0 * np.sin(2 * np.pi * time), 0.0)
    motion = motion_towards_north(pulse + 3.0 * ((time >= 7.0) & (time < 8.2)) - 3.0 * ((time >= 8.2) & (time < 9.4)))
    short, full = (simulate_single_case(made, motion, 0.2, leave_out=leave_out) for leave_out in (True, False))
    assert full.overturned[0].tolist() == [-1, -1]
    np.testing.assert_array_equal(short.overturned, full.overturned)
    np.testing.assert_array_equal(short.overturning_time, full.overturning_time)


def test_a_stone_hit_by_a_falling_stone_counts_as_fallen() -> None:
    """A stone falls from a pedestal onto a lower one, also if the motion is over before it hits: both have fallen."""
    made = scene_of_elements(
        GROUND,
        PEDESTAL_ELEMENT | {"height": 2.0},
        block_element("top", 0.12, 1.0, "pedestal"),
        block_element("near", 0.2, 0.6, x=1.5),
    )
    time = np.arange(0.0, 8.6, 0.01)
    motion = motion_towards_north(
        np.where((time >= 1.0) & (time < 2.6), -1.9 * np.sin(2 * np.pi * (time - 1.0) / 1.6), 0.0)
    )
    short, full = (simulate_single_case(made, motion, 1.0, leave_out=leave_out) for leave_out in (True, False))
    assert full.overturned[0].tolist() == [1, 1]
    np.testing.assert_array_equal(short.overturned, full.overturned)


def test_aftermath_of_a_stack_trajectory_keeps_the_outcome_and_ends_at_rest() -> None:
    """A trajectory with 5 s of aftermath begins like one without it, has the same outcome, and ends at rest."""
    motion, given = near_field_motion_and_fault_component_azimuths(9)[0], {"azimuth_deg": 30.0, "friction": 0.7}
    decided, lying = (
        trajectory(motion, load_shipped_scene("three-tier"), **given, aftermath=time) for time in (0.0, 5.0)
    )
    free = decided["kind"].to_numpy() == "free"
    for name in ("overturned", "overturning_time", "peak_rotation", "peak_slip"):
        np.testing.assert_array_equal(decided[name].to_numpy()[free], lying[name].to_numpy()[free])
    rows = decided.sizes["time"]
    for name in ("x", "z", "rotation", "angular_velocity"):
        np.testing.assert_array_equal(decided[name].to_numpy(), lying[name].to_numpy()[:rows])
    assert float(lying["time"][-1]) == pytest.approx(float(decided["time"][-1]) + 5.0, abs=0.11)
    speed = np.hypot(lying["velocity_x"], lying["velocity_z"]).to_numpy()
    assert speed[rows - 1].max() > 0.1, "the shaft is in mid-air when its fall is certain"
    assert speed[-1].max() < 1e-3
    x, z, angle = (lying[name].to_numpy()[-1, 3] for name in ("x", "z", "rotation"))
    corners = lying["vertices"].to_numpy()[3]
    low = z + corners[:, 1] * np.cos(angle) - corners[:, 0] * np.sin(angle)
    assert low.min() == pytest.approx(0.0, abs=1e-3), "the shaft reaches the ground"
    assert abs(x) > 0.3
