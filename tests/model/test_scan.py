"""Scanned stones: mass properties of non-convex solids, holes, footprint, stable pose, and agreement with polyhedra."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from overturning.errors import ArgumentError
from overturning.model.outline import simplified_convex_hull_vertices
from overturning.model.scan import ScannedStone, nearest_stable_pose, stone_in_nearest_stable_pose_from_surface
from overturning.model.shapes import Polyhedron
from overturning.model.surface import (
    TriangleSurface,
    mass_properties_inside_surface,
    open_edges,
    repair_surface_and_close_base,
)
from tests.expect import expect_error
from tests.model.solids import (
    FUNCTIONS_MAKING_SURFACES_OF_SOLIDS,
    box,
    column_with_overhanging_slab,
    l_shaped_prism,
    mass_properties_of_solid_from_its_boxes,
    rectangular_ring,
    rotate_surface,
)

ROUGHNESS_M = 0.004
"""Largest height of the rough base of `block_surface_with_rough_base`, m."""


@pytest.mark.parametrize("name", FUNCTIONS_MAKING_SURFACES_OF_SOLIDS)
def test_mass_properties_of_non_convex_solids_match_the_sum_of_boxes(name: str) -> None:
    """Volume, centre and inertia equal sums over the boxes that the solid consists of."""
    volume, centre, inertia = mass_properties_of_solid_from_its_boxes(name)
    surface = FUNCTIONS_MAKING_SURFACES_OF_SOLIDS[name]()
    found = mass_properties_inside_surface(surface.triangle_corners)
    assert found.signed_volume == pytest.approx(volume, rel=1e-12)
    np.testing.assert_allclose(found.centre_of_mass, centre, atol=1e-12)
    np.testing.assert_allclose(found.inertia_per_mass, inertia, atol=1e-12)
    assert ConvexHull(surface.vertices).volume > 1.2 * volume
    assert len(open_edges(surface.triangles)) == 0


def test_a_scanned_ring_has_the_inertia_of_its_volume_not_of_its_hull() -> None:
    """The ring is a body with a hole: its hull would have a quarter less inertia about the vertical."""
    _, _, inertia = mass_properties_of_solid_from_its_boxes("ring")
    scan = stone_in_nearest_stable_pose_from_surface(rectangular_ring(), [], "ring")
    np.testing.assert_allclose(scan.shape.solid(0.25, 1.0, 1.0).inertia_per_mass, inertia, atol=1e-8)
    assert scan.shape.solid(0.25, 1.0, 1.0).base_vertex_count == 4


def test_clockwise_mesh_faces_are_turned_outwards() -> None:
    inside_out = l_shaped_prism()._replace(triangles=l_shaped_prism().triangles[:, ::-1])
    assert mass_properties_inside_surface(inside_out.triangle_corners).signed_volume < 0
    surface, notes = repair_surface_and_close_base(inside_out)
    assert mass_properties_inside_surface(surface.triangle_corners).signed_volume == pytest.approx(
        mass_properties_of_solid_from_its_boxes("l-shape")[0]
    )
    assert "clockwise" in notes[0]


def translate_surface(surface: TriangleSurface, *by: float) -> TriangleSurface:
    """Return a surface moved by the given distances along the axes."""
    return surface._replace(vertices=surface.vertices + np.array(by))


def concatenate_surfaces(*surfaces: TriangleSurface) -> TriangleSurface:
    """Return one surface of several, whose vertices are numbered one after the other."""
    first = np.cumsum([0, *(len(one.vertices) for one in surfaces)])
    triangles = [one.triangles + start for one, start in zip(surfaces, first, strict=False)]
    return TriangleSurface(np.concatenate([one.vertices for one in surfaces]), np.concatenate(triangles))


@pytest.mark.parametrize("away", [5.0, 0.3], ids=["apart", "overlapping"])
def test_a_mesh_of_several_bodies_is_refused(away: float) -> None:
    """The volume where bodies overlap would count twice, and stones that do not touch would move as one body."""
    with expect_error(ArgumentError, "2 separate parts", "one rigid body", brief=True):
        repair_surface_and_close_base(
            concatenate_surfaces(l_shaped_prism(), translate_surface(l_shaped_prism(), away, 0.0, 0.0))
        )


def test_a_mesh_with_a_second_body_inside_out_is_refused() -> None:
    """A second body with inward faces has a negative volume, like a cavity, and would be subtracted."""
    small = translate_surface(box((0.1, 0.1, 0.3)), 0.8, 0.0, 0.0)
    inside_out = small._replace(triangles=small.triangles[:, ::-1])
    for several in (
        concatenate_surfaces(l_shaped_prism(), inside_out),
        concatenate_surfaces(inside_out, l_shaped_prism()),
    ):
        with expect_error(ArgumentError, "2 separate parts", "0.003", "one rigid body", brief=True):
            repair_surface_and_close_base(several)


def merge_surfaces_and_equal_vertices(*surfaces: TriangleSurface) -> TriangleSurface:
    """Return one surface of several, in which equal vertices are merged, as in a mesh file that is read."""
    whole = concatenate_surfaces(*surfaces)
    vertices, number = np.unique(whole.vertices, axis=0, return_inverse=True)
    return TriangleSurface(vertices, number.reshape(-1)[whole.triangles])


def surface_of_unit_cubes(filled: list[list[list[int]]]) -> TriangleSurface:
    """Return the surface of the cubes of 1 m whose entry is 1 in an array over x, y and z."""
    inside = np.pad(np.array(filled), 1)
    quads = []
    for place in np.argwhere(inside):
        for axis in range(3):
            for side in (-1, 1):
                step = side * np.eye(3, dtype=int)[axis]
                if not inside[tuple(place + step)]:
                    one, two = (np.eye(3)[(axis + k) % 3] for k in ((1, 2) if side > 0 else (2, 1)))
                    corner = place + 0.5 + 0.5 * step - 0.5 * one - 0.5 * two
                    quads.append([corner, corner + one, corner + one + two, corner + two])
    faces = np.array(quads).reshape(-1, 3)
    triangles = 4 * np.arange(len(quads))[:, None, None] + np.array([[0, 1, 2], [0, 2, 3]])
    return merge_surfaces_and_equal_vertices(TriangleSurface(faces, triangles.reshape(-1, 3)))


BASE, SHAFT = box((0.5, 0.5, 0.2)), translate_surface(box((0.5, 0.5, 0.8)), 0.0, 0.0, 0.2)


@pytest.mark.parametrize(
    "solids",
    [
        pytest.param(surface_of_unit_cubes([[[1, 0], [0, 0]], [[0, 0], [0, 1]]]), id="touch at a corner"),
        pytest.param(surface_of_unit_cubes([[[1], [0]], [[0], [1]]]), id="touch along an edge"),
        pytest.param(merge_surfaces_and_equal_vertices(BASE, SHAFT), id="two stones of equal width"),
        pytest.param(
            merge_surfaces_and_equal_vertices(box((0.5, 0.5, 0.9)), box((0.2, 0.1, 0.5))),
            id="overlap from a common corner",
        ),
    ],
)
@pytest.mark.parametrize("turn_deg", [0.0, 33.0])
def test_touching_solids_count_as_several_bodies(solids: TriangleSurface, turn_deg: float) -> None:
    """Rotated coordinates are rounded, so that faces that coincide differ a little."""
    with expect_error(ArgumentError, "2 separate parts", "one rigid body", brief=True):
        repair_surface_and_close_base(rotate_surface(solids, 0, turn_deg))


@pytest.mark.parametrize("turn_deg", [0.0, 33.0])
def test_a_solid_that_touches_itself_along_an_edge_counts_as_one_body(turn_deg: float) -> None:
    """Two cubes that share an edge stand on a slab of four."""
    surface, notes = repair_surface_and_close_base(
        rotate_surface(surface_of_unit_cubes([[[1, 1], [1, 0]], [[1, 0], [1, 1]]]), 0, turn_deg)
    )
    assert mass_properties_inside_surface(surface.triangle_corners).signed_volume == pytest.approx(6.0)
    assert notes == []


@pytest.mark.parametrize("x", [-0.1, 0.4])
def test_a_mesh_whose_cavity_breaks_through_the_wall_is_refused(x: float) -> None:
    whole, hole = box((0.5, 0.5, 0.9)), translate_surface(box((0.2, 0.1, 0.1)), x, 0.2, 0.3)
    with expect_error(ArgumentError, "2 separate parts", brief=True):
        repair_surface_and_close_base(concatenate_surfaces(whole, hole._replace(triangles=hole.triangles[:, ::-1])))


def test_a_flap_of_two_opposite_mesh_faces_adds_no_volume() -> None:
    flap = TriangleSurface(
        np.array([[2.0, 0.0, 0.0], [2.1, 0.0, 0.0], [2.0, 0.1, 0.0]]), np.array([[0, 1, 2], [0, 2, 1]])
    )
    surface, _ = repair_surface_and_close_base(concatenate_surfaces(l_shaped_prism(), flap))
    assert mass_properties_inside_surface(surface.triangle_corners).signed_volume == pytest.approx(
        mass_properties_of_solid_from_its_boxes("l-shape")[0], rel=1e-12
    )


@pytest.mark.parametrize("all_of_it", [True, False])
def test_mesh_triangles_that_are_listed_twice_count_once(all_of_it: bool) -> None:
    """Repeated triangles, whose lists start at another corner, are left out with a note."""
    whole = l_shaped_prism()
    again = np.roll(whole.triangles, 1, axis=1)[: None if all_of_it else 1]
    surface, notes = repair_surface_and_close_base(whole._replace(triangles=np.concatenate([whole.triangles, again])))
    assert mass_properties_inside_surface(surface.triangle_corners).signed_volume == pytest.approx(
        mass_properties_of_solid_from_its_boxes("l-shape")[0], rel=1e-12
    )
    assert f"{len(again)} left out" in notes[0]


def test_a_cavity_in_a_mesh_is_not_taken_for_a_second_body() -> None:
    hole = translate_surface(
        column_with_overhanging_slab()._replace(vertices=0.1 * column_with_overhanging_slab().vertices), 0.1, 0.15, 0.05
    )
    hollow = concatenate_surfaces(l_shaped_prism(), hole._replace(triangles=hole.triangles[:, ::-1]))
    surface, notes = repair_surface_and_close_base(hollow)
    expected = (
        mass_properties_of_solid_from_its_boxes("l-shape")[0]
        - 1e-3 * mass_properties_of_solid_from_its_boxes("statue")[0]
    )
    assert mass_properties_inside_surface(surface.triangle_corners).signed_volume == pytest.approx(expected, rel=1e-9)
    assert notes == []


def test_an_open_planar_base_of_a_mesh_is_closed() -> None:
    """Mass properties stay the same if the base faces are removed and closed again, for one rim or two (a ring)."""
    for whole in (l_shaped_prism(), rectangular_ring(), column_with_overhanging_slab()):
        bottom = (whole.triangle_corners[:, :, 2] == 0.0).all(axis=1)
        assert bottom.sum() >= 2
        surface, notes = repair_surface_and_close_base(whole._replace(triangles=whole.triangles[~bottom]))
        assert "open base" in notes[0]
        for one, other in zip(
            mass_properties_inside_surface(surface.triangle_corners),
            mass_properties_inside_surface(whole.triangle_corners),
            strict=True,
        ):
            np.testing.assert_allclose(one, other, atol=1e-12)


def test_a_mesh_hole_outside_the_base_is_refused_and_its_edges_are_counted() -> None:
    whole = l_shaped_prism()
    top = int(np.flatnonzero((whole.triangle_corners[:, :, 2] == 0.8).all(axis=1))[0])
    with expect_error(ArgumentError, "not closed at 3 edges", "0.8]", "fill the holes", brief=True):
        repair_surface_and_close_base(whole._replace(triangles=np.delete(whole.triangles, top, axis=0)))
    # A base whose rim is not flat.
    bent = whole.vertices.copy()
    bent[whole.vertices[:, 2] == 0.0, 2] += [0.0, 0.1, 0.0, 0.0]
    open_below = whole.triangles[~(whole.triangle_corners[:, :, 2] == 0.0).all(axis=1)]
    with expect_error(ArgumentError, "not closed at 4 edges", brief=True):
        repair_surface_and_close_base(TriangleSurface(bent, open_below))
    with expect_error(ArgumentError, "without faces", "closed mesh", brief=True):
        repair_surface_and_close_base(TriangleSurface(whole.vertices, np.zeros((0, 3), np.int64)))


def test_a_mesh_with_one_face_turned_inwards_is_refused() -> None:
    whole = box((0.4, 0.3, 0.8))
    turned = whole.triangles.copy()
    turned[-1] = turned[-1, ::-1]
    with expect_error(ArgumentError, "not closed", "point outwards", brief=True):
        repair_surface_and_close_base(whole._replace(triangles=turned))


@pytest.mark.parametrize(("axis", "direction"), [(1, 0.0), (0, -90.0)])
@pytest.mark.parametrize("tilt", [0.5, 7.0, 20.0])
def test_a_tilted_scan_is_placed_upright_and_its_tilt_is_stored(axis: int, direction: float, tilt: float) -> None:
    """Rotated about y its top leans towards +x; placed upright it is the box again, at the same azimuth."""
    scan = stone_in_nearest_stable_pose_from_surface(rotate_surface(box((0.4, 0.3, 0.8)), axis, tilt), [], "box")
    assert scan.rotation_to_stable_pose.scan_tilt_from_stable_pose_deg == pytest.approx(tilt, abs=1e-6)
    # The pose turns the top back, opposite to the lean.
    assert abs(
        (scan.rotation_to_stable_pose.scan_tilt_direction_ccw_from_x_deg - direction - 180.0 + 180.0) % 360.0 - 180.0
    ) == pytest.approx(0.0, abs=1e-6)
    solid = scan.shape.solid(0.8, 1.0, 1.0)
    np.testing.assert_allclose(np.abs(solid.contact_points_from_centre_of_mass[:4, :2]), [[0.2, 0.15]] * 4, atol=2e-6)
    assert solid.b_over_h == pytest.approx(0.15 / 0.4, abs=1e-5)


def test_a_scanned_wedge_is_placed_on_its_nearest_face() -> None:
    """A slender wedge that stands on its edge leans by half of its opening angle onto the nearer side."""
    half = np.radians(15.0)
    outline = np.array([(0.0, 0.0), (np.sin(half), np.cos(half)), (-np.sin(half), np.cos(half))])
    points = np.array([[x, y, z] for y in (-0.3, 0.3) for x, z in outline])
    centre = points.mean(axis=0)
    pose = nearest_stable_pose(points, centre)
    assert pose.scan_tilt_from_stable_pose_deg == pytest.approx(75.0, abs=1e-6)


@pytest.mark.parametrize("slope_deg", [0.001, 0.02, 0.046, 0.07, 1.0])
def test_a_base_of_two_inclined_facets_rests_on_the_facet_below_the_centre(slope_deg: float) -> None:
    """The base has a ridge beside the point below the centre of mass: on the facet beyond, the body would fall."""
    drop = np.tan(np.radians(slope_deg))
    outline = [(0.3, 0.9), (-0.3, 0.9), (-0.3, 0.25 * drop), (-0.05, 0.0), (0.3, 0.0)]
    points = np.array([[x, y, z] for y in (-0.2, 0.2) for x, z in outline])
    assert nearest_stable_pose(points, np.array([0.0, 0.0, 0.45])).scan_tilt_from_stable_pose_deg == pytest.approx(
        0.0, abs=1e-9
    )
    pose = nearest_stable_pose(points, np.array([-0.1, 0.0, 0.45]))
    assert pose.scan_tilt_from_stable_pose_deg == pytest.approx(slope_deg, rel=1e-6)
    # A foot on the ridge: facets inclined by less than 0.08° count as rounded parts of one face and carry the body.
    on_ridge = nearest_stable_pose(points, np.array([-0.05, 0.0, 0.45])).scan_tilt_from_stable_pose_deg
    assert on_ridge == pytest.approx(0.0 if slope_deg < 0.08 else slope_deg, abs=1e-9)


def block_surface_with_rough_base(generator: np.random.Generator) -> TriangleSurface:
    """Return a block with a flat top and a rough base, a grid of points with random heights up to `ROUGHNESS_M`."""
    n = 9
    x, y = np.meshgrid(np.linspace(-0.2, 0.2, n), np.linspace(-0.15, 0.15, n), indexing="ij")
    low = np.column_stack([x.ravel(), y.ravel(), generator.uniform(0.0, ROUGHNESS_M, n * n)])
    high = np.column_stack([x.ravel(), y.ravel(), np.full(n * n, 0.7)])
    cells = np.arange(n * n).reshape(n, n)
    a, b, c, d = cells[:-1, :-1].ravel(), cells[1:, :-1].ravel(), cells[1:, 1:].ravel(), cells[:-1, 1:].ravel()
    top = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    rim = np.concatenate([cells[:, 0], cells[-1, 1:], cells[-2::-1, -1], cells[0, -2:0:-1]])
    after = np.roll(rim, -1)
    m = n * n
    sides = np.concatenate([np.column_stack([rim, after, rim + m]), np.column_stack([after, after + m, rim + m])])
    return TriangleSurface(np.concatenate([low, high]), np.concatenate([top[:, ::-1], top + m, sides]))


def test_a_scan_footprint_is_the_hull_of_points_up_to_the_relief_height() -> None:
    surface, _ = repair_surface_and_close_base(block_surface_with_rough_base(np.random.default_rng(4)))
    stone = stone_in_nearest_stable_pose_from_surface(surface, [], "rough", 0.0).shape
    assert isinstance(stone, ScannedStone)
    pose = nearest_stable_pose(
        surface.vertices, mass_properties_inside_surface(surface.triangle_corners).centre_of_mass
    )
    placed = surface.vertices @ pose.rotation_matrix_from_scan_axes.T
    above = placed[:, 2] - placed[:, 2].min()
    slenderness = []
    for relief in (0.0005, 0.001, 0.002, 0.004, 0.01):
        solid = stone.with_base_relief(relief).unscaled_solid
        hull = ConvexHull(placed[above <= relief, :2])
        x, y = solid.contact_points_from_centre_of_mass[: solid.base_vertex_count, :2].T
        area = 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
        # The simplification may leave out a strip of 1 ‰ of the size along the outline.
        assert hull.volume - 7e-4 * hull.area <= area <= hull.volume + 1e-6
        slenderness.append(solid.b_over_h)
    assert slenderness == sorted(slenderness)
    assert slenderness[0] < 0.8 * slenderness[-1]
    whole = Polyhedron(box((0.4, 0.3, 0.7)).vertices).unscaled_solid
    assert slenderness[-1] == pytest.approx(whole.b_over_h, rel=0.03)


def test_a_convex_mesh_equals_the_polyhedron_of_its_vertices_bit_for_bit() -> None:
    """A convex mesh and the polyhedron of its vertices have the same bits, so that studies keep their results."""
    frustum = box((0.5, 0.4, 0.7))
    points = frustum.vertices * np.where(frustum.vertices[:, 2:] > 0, [[0.6, 0.7, 1.0]], 1.0)
    scan = stone_in_nearest_stable_pose_from_surface(frustum._replace(vertices=points), [], "frustum")
    own, other = scan.shape.solid(0.7, 1.0, 1.0), Polyhedron(points).solid(0.7, 1.0, 1.0)
    assert isinstance(scan.shape, Polyhedron)
    for name in (
        "contact_points_from_centre_of_mass",
        "inertia_per_mass",
        "resting_face_normals_after_fall",
        "lean_sector_start_vector_and_min_fall_dot_product",
    ):
        assert getattr(own, name).tobytes() == getattr(other, name).tobytes()
    # As a scan with a relief of its own it differs by the rounding to micrometres only.
    scanned = stone_in_nearest_stable_pose_from_surface(frustum._replace(vertices=points), [], "frustum", 0.001).shape
    assert isinstance(scanned, ScannedStone)
    np.testing.assert_allclose(
        np.sort(scanned.unscaled_solid.contact_points_from_centre_of_mass, axis=0),
        np.sort(own.contact_points_from_centre_of_mass, axis=0),
        atol=2e-6,
    )
    np.testing.assert_allclose(scanned.unscaled_solid.inertia_per_mass, own.inertia_per_mass, atol=1e-8)


def test_points_outside_a_simplified_hull_are_within_the_tolerance() -> None:
    points = np.random.default_rng(2).normal(size=(4000, 3))
    points /= np.linalg.norm(points, axis=1)[:, None]
    counts = []
    for tolerance in (0.002, 0.005, 0.02):
        kept = simplified_convex_hull_vertices(points, tolerance)
        equations = ConvexHull(kept).equations
        beyond = points @ equations[:, :3].T + equations[:, 3]
        assert beyond[:, equations[:, 2] <= -np.cos(np.radians(45.0))].max() <= tolerance + 1e-12
        counts.append(len(kept))
    assert counts == sorted(counts, reverse=True)
    assert len(simplified_convex_hull_vertices(points[:, :2], 0.01)) < 40
    whole = simplified_convex_hull_vertices(points[:, :2], 0.0)
    assert {tuple(one) for one in whole} == {tuple(one) for one in points[ConvexHull(points[:, :2]).vertices, :2]}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"max_load_bearing_base_point_height_m": 0.05}, ["relief", "0.05", "0.03"]),
        ({"max_load_bearing_base_point_height_m": -0.001}, ["relief", "-0.001"]),
        ({"inertia_moments_and_products_per_mass": (1.0, 1.0, 3.0, 0, 0, 0)}, ["inertia", "no body"]),
        ({"centre_of_mass": (0.5, 0.0, 0.4)}, ["outside its base"]),
    ],
)
def test_scanned_stones_with_impossible_relief_inertia_or_centre_are_refused(change: dict, words: list[str]) -> None:
    points = box((0.4, 0.3, 0.8)).vertices - [0.2, 0.15, 0.0]
    own = {
        "centre_of_mass": (0.0, 0.0, 0.4),
        "inertia_moments_and_products_per_mass": (0.06, 0.07, 0.02, 0, 0, 0),
        "max_load_bearing_base_point_height_m": 0.002,
    }
    ScannedStone(points, **own)
    with expect_error(ArgumentError, *words, brief=True):
        ScannedStone(points, **own | change)
