"""Non-convex elements: their convex pieces, their statics, and agreement of divided and undivided elements."""

from itertools import permutations
from typing import Any

import numpy as np
import pytest

from overturning.dem.polygon.prepare import prepare_scene
from overturning.dem.run import simulate_cases
from overturning.errors import ConfigError
from overturning.model.cases import Cases
from overturning.model.geometry import reference_element_height_and_b_over_h, scale_and_place_elements
from overturning.model.pieces import (
    convex_piece_vertex_indices,
    outline_of_joined_pieces,
    polygon_crosses_itself,
    signed_doubled_triangle_area,
)
from overturning.model.results import CaseResults
from overturning.model.scene import Scene
from overturning.motion.motion import Motion
from tests.dem.near_field import near_field_motion_and_fault_component_azimuths
from tests.dem.polygon_scenes import GROUND, block_element, motion_towards_north, scene_of_elements

FOOT_OUTLINE = [[0, 0], [0.8, 0], [0.8, 0.3], [0, 0.3]]
STEM_OUTLINE = [[0, 0.3], [0.3, 0.3], [0.3, 1.1], [0, 1.1]]
L_OUTLINE = [[0, 0], [0.8, 0], [0.8, 0.3], [0.3, 0.3], [0.3, 1.1], [0, 1.1]]
CROSS_OUTLINE = [
    [-0.15, 0], [0.15, 0], [0.15, 0.6], [0.4, 0.6], [0.4, 0.9], [0.15, 0.9],
    [0.15, 1.2], [-0.15, 1.2], [-0.15, 0.9], [-0.4, 0.9], [-0.4, 0.6], [-0.15, 0.6],
]  # fmt: skip


def stone_element(**keys: Any) -> dict[str, Any]:
    """Return the element of a scene file for a stone on the ground; its shape is given by `keys`."""
    return {"name": "stone", "stands_on": "ground", **keys}


def signed_polygon_area(points: np.ndarray) -> float:
    """Return the area of a polygon, m²; positive if its vertices run anticlockwise."""
    x, z = points.T
    return 0.5 * float((x * np.roll(z, -1) - np.roll(x, -1) * z).sum())


def simulate_scene(made: Scene, motion: Motion, azimuths: Any = (0.0,), friction: float = 0.8) -> CaseResults:
    """Simulate a scene with the sizes of its file along some azimuths."""
    height, ratio = reference_element_height_and_b_over_h(made)
    return simulate_cases(made, motion, Cases(np.asarray(azimuths), height, ratio, friction))


def random_star_outline(generator: np.random.Generator, count: int) -> np.ndarray:
    """Return a star-shaped outline around the origin with random radii."""
    angles = 2 * np.pi / count * (np.arange(count) + generator.uniform(0, 0.9, count))
    return np.stack([np.cos(angles), np.sin(angles)], axis=1) * generator.uniform(0.2, 1.0, count)[:, None]


def test_pieces_are_convex_and_fill_the_outline_with_its_sides_unchanged() -> None:
    generator = np.random.default_rng(2)
    for number in range(60):
        points = random_star_outline(generator, 4 + number % 12)
        pieces = convex_piece_vertex_indices(points)
        assert sum(signed_polygon_area(points[loop]) for loop in pieces) == pytest.approx(
            signed_polygon_area(points), rel=1e-12
        )
        for loop in pieces:
            for k in range(len(loop)):
                assert signed_doubled_triangle_area(*points[[loop[k - 1], loop[k], loop[(k + 1) % len(loop)]]]) > 0
        sides = [(loop[k - 1], loop[k]) for loop in pieces for k in range(len(loop))]
        for k in range(len(points)):
            assert sides.count((k, (k + 1) % len(points))) == 1
        assert (
            len(pieces)
            <= sum(
                signed_doubled_triangle_area(points[k - 2], points[k - 1], points[k]) < 0 for k in range(len(points))
            )
            * 2
            + 1
        )


def test_an_outline_that_crosses_itself_is_detected() -> None:
    assert polygon_crosses_itself(np.array([[0, 0], [1, 1], [1, 0], [0, 1.0]]))
    assert not polygon_crosses_itself(np.array(L_OUTLINE, dtype=float))


def test_joined_pieces_have_the_outline_of_the_whole_in_any_order() -> None:
    for order in permutations((FOOT_OUTLINE, STEM_OUTLINE)):
        assert outline_of_joined_pieces("l", [np.array(piece, float) for piece in order]).tolist() == L_OUTLINE
    halves = [[[-0.1, 0], [0.02, 0], [-0.02, 0.5], [-0.1, 0.5]], [[0.02, 0], [0.1, 0], [0.1, 0.5], [-0.02, 0.5]]]
    for order in permutations(halves):
        whole = scale_and_place_elements(scene_of_elements(stone_element(pieces=list(order))))[1]
        assert whole.shape.convex_pieces_if_not_convex == ()
        np.testing.assert_allclose(
            whole.shape.vertices_from_whole_polygon_centroid,
            scale_and_place_elements(scene_of_elements(block_element("stone", 0.2, 0.5)))[
                1
            ].shape.vertices_from_whole_polygon_centroid,
            atol=1e-15,
        )


def test_mass_centre_and_inertia_are_those_of_the_pieces_together() -> None:
    """Expected values from two rectangles: masses, weighted centres, and the parallel axis theorem."""
    item = scale_and_place_elements(scene_of_elements(stone_element(vertices=L_OUTLINE, depth=0.4)))[1]
    parts = [(0.8, 0.3, 0.4, 0.15), (0.3, 0.8, 0.15, 0.7)]
    mass = [2650 * 0.4 * b * h for b, h, _, _ in parts]
    x, z = (np.average([part[k] for part in parts], weights=mass) for k in (2, 3))
    inertia = sum(
        m * ((b**2 + h**2) / 12 + (px - x) ** 2 + (pz - z) ** 2) for m, (b, h, px, pz) in zip(mass, parts, strict=True)
    )
    assert (item.mass, item.inertia_about_centre_of_mass) == pytest.approx((sum(mass), inertia))
    assert (item.centre_of_mass_x, item.centre_of_mass_z) == pytest.approx((x, z))


def test_an_l_shape_tips_at_arm_over_height_to_either_side() -> None:
    """Centre (0.275, 0.425), base from 0 to 0.8: it tips at 0.275/0.425 g, in the other direction at 0.525/0.425 g."""
    made = scene_of_elements(stone_element(vertices=L_OUTLINE))
    prepared = prepare_scene(made)
    assert prepared.no_rocking_below_acceleration_g == pytest.approx(0.275 / 0.425, rel=1e-12)
    assert prepared.weaker_side_critical_angles_else_fall_angles[1] == pytest.approx(np.arctan(0.275 / 0.425), rel=1e-9)
    # Fallen to +x it rests on the vertices (0.8, 0.3) and (0.3, 1.1).
    assert np.degrees(prepared.elements[1].fall_rotations_to_minus_and_plus_x_rad) == pytest.approx(
        [90, 90 + np.degrees(np.arctan2(0.5, 0.8))]
    )
    time = np.arange(0, 4, 0.01)
    for share, sign, stands in ((0.275, 1, True), (0.275, 1, False), (0.525, -1, True), (0.525, -1, False)):
        level = (0.97 if stands else 1.03) * sign * share / 0.425 * 9.80665
        # A base that accelerates towards +x tips it towards −x, the side of the stem.
        push = level * np.clip(time, 0, 1)
        motion = Motion(push, 0 * push, sampling_interval=0.01, trust_data=True)  # not a plausible ground motion
        found = simulate_scene(made, motion, friction=5.0)
        assert found.overturned[0] == (0 if stands else -sign), (share, stands)


def test_an_arch_rests_on_four_corners_with_the_static_loads() -> None:
    arch = [[-0.5, 0], [-0.3, 0], [-0.3, 0.5], [0.3, 0.5], [0.3, 0], [0.5, 0], [0.5, 0.8], [-0.5, 0.8]]
    prepared = prepare_scene(scene_of_elements(stone_element(vertices=arch)))
    assert len(prepared.contact_points_loaded_at_rest) == 4
    assert prepared.pair_contact_laws.carried_weight_at_rest == pytest.approx(
        prepared.elements[1].mass * 9.80665, rel=1e-9
    )
    assert prepared.no_rocking_below_acceleration_g == pytest.approx(
        0.5 / prepared.elements[1].centre_of_mass_z, rel=1e-9
    )


def test_a_rectangle_of_two_halves_behaves_like_the_undivided_one() -> None:
    motion, azimuths = near_field_motion_and_fault_component_azimuths(7)[0], np.arange(0, 360, 60.0)
    beside = block_element("beside", 0.1, 0.5, x=0.6)  # so that both use the scene kernel
    whole = simulate_scene(scene_of_elements(block_element("stone", 0.2, 0.6), beside), motion, azimuths)
    halves = [[[-0.1, 0], [0.0, 0], [0.05, 0.6], [-0.1, 0.6]], [[0.0, 0], [0.1, 0], [0.1, 0.6], [0.05, 0.6]]]
    divided = simulate_scene(scene_of_elements(stone_element(pieces=halves), beside), motion, azimuths)
    assert (whole.overturned != 0).any()
    np.testing.assert_array_equal(divided.overturned, whole.overturned)
    np.testing.assert_allclose(divided.peak_rotation, whole.peak_rotation, rtol=1e-6)


def test_a_corner_shared_by_two_pieces_of_a_stone_touches_the_ground_once() -> None:
    """A notch of 1e-7 m in the top divides a stone into two pieces with a common lower corner; outcomes are equal."""
    motion, azimuths = near_field_motion_and_fault_component_azimuths(7)[0], np.arange(0, 360, 45.0)
    corners = [[-0.12, 0], [0.12, 0], [0.13, 0.6], [-0.12, 0.6]]
    notched = [*corners[:3], [0.02, 0.6 - 1e-7], corners[3]]
    whole, divided = (
        scene_of_elements(stone_element(vertices=vertices), block_element("beside", 0.1, 0.5, x=0.6))
        for vertices in (corners, notched)
    )
    assert [len(scale_and_place_elements(made)[1].shape.convex_parts) for made in (whole, divided)] == [1, 2]
    one, other = (simulate_scene(made, motion, azimuths) for made in (whole, divided))
    assert 0 < (one.overturned[:, 0] != 0).sum() < azimuths.size
    np.testing.assert_array_equal(other.overturned, one.overturned)
    stands = one.overturned[:, 0] == 0
    np.testing.assert_allclose(other.peak_rotation[stands, 0], one.peak_rotation[stands, 0], rtol=1e-4)


def test_a_stone_pushed_into_an_inner_corner_does_not_penetrate() -> None:
    """A small stone rests on the foot next to the stem, is pushed against it, and neither penetrates nor leaves."""
    small = {"name": "small", "width": 0.3, "height": 0.2, "at": [0.45 + 1e-6, 0.3], "material": "ice"}
    made = scene_of_elements(
        stone_element(vertices=L_OUTLINE), small, materials={"stone": {}, "ice": {}},
        contacts=[{"between": ["stone", "ice"], "friction": 0.02}],
    )  # fmt: skip
    prepared = prepare_scene(made)
    assert prepared.has_static_equilibrium
    time = np.arange(0, 3, 0.01)
    found = simulate_scene(made, motion_towards_north(0.8 * np.sin(4 * np.pi * time)))
    assert found.overturned.tolist() == [[0, 0]]
    assert found.peak_slip[0, 1] > 1e-3
    assert found.peak_penetration[0] < 1e-4
    assert found.energy_error[0] < 1e-2


@pytest.mark.parametrize("vertices", [L_OUTLINE, CROSS_OUTLINE])
def test_energy_balances_and_mirrored_shapes_fall_to_the_opposite_side(vertices: list[list[float]]) -> None:
    motion, azimuths = near_field_motion_and_fault_component_azimuths(7)[0], np.array([0.0, 90.0, 180.0, 270.0])
    mirrored = [[-x, z] for x, z in vertices[::-1]]
    one, other = (
        simulate_scene(scene_of_elements(stone_element(vertices=points)), motion, azimuths)
        for points in (vertices, mirrored)
    )
    assert one.energy_error.max() < 1e-2
    np.testing.assert_array_equal(one.overturned, -other.overturned[[2, 3, 0, 1]])
    stands = one.overturned == 0
    assert stands.any()
    np.testing.assert_allclose(one.peak_rotation[stands], other.peak_rotation[[2, 3, 0, 1]][stands], rtol=1e-6)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"pieces": [FOOT_OUTLINE, [[0.2, 0.2], [0.3, 0.2], [0.3, 1.1], [0.2, 1.1]]]},
        "element stone: the pieces .* overlap by 0.1"),
        ({"pieces": [FOOT_OUTLINE, [[0.9, 0], [1, 0], [1, 1]]]}, "element stone: its pieces do not form one outline"),
        ({"pieces": [FOOT_OUTLINE, [[0.8, 0.3], [1, 0.3], [1, 1]]]},
        "element stone: its pieces do not form one outline"),
        ({"pieces": [L_OUTLINE]},
        "element stone: piece 1 is not convex; split it, or give the outline of all as vertices"),
        ({"pieces": [FOOT_OUTLINE, STEM_OUTLINE[::-1]]}, "element stone, piece 2: the polygon runs clockwise"),
        ({"pieces": [FOOT_OUTLINE], "width": 1}, "element stone: give either width and height, or vertices, or pieces"),
        ({"vertices": [[0, 0], [1, 0], [0.2, 1], [0.8, 1.2]]}, "element stone: the polygon crosses itself"),
        ({"vertices": [[0, 0], [1, 0], [1, 1], [0.5, 1], [0, 1]]}, r"element stone: vertex 3 \(0.5, 1\) lies in line"),
    ],
)  # fmt: skip
def test_bad_outlines_and_pieces_are_refused(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        scene_of_elements(GROUND, stone_element(**change))
