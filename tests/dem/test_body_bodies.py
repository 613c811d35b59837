"""3-D bodies: mass properties, contact vertices, fall tilt, pose at rest, and refused shapes."""

from collections.abc import Callable

import numpy as np
import pytest

from overturning.dem.body.statics import body_pose_at_rest_on_springs, smallest_squared_frequency_on_unit_springs
from overturning.dem.simulate import simulate, simulate_as_arrays
from overturning.errors import ArgumentError
from overturning.model.body import Body, InitialState
from overturning.model.contact import VertexContact
from overturning.model.scan import ScannedStone
from overturning.model.shapes import (
    Cylinder,
    Polyhedron,
    RectangularPrism,
    RegularPrism,
    orientations_over_symmetry_period_deg,
    shape_from_name_or_sides,
)
from overturning.model.solid import RigidSolid
from overturning.model.variables import MAX_FACE_COUNT_OF_BODY_WITH_NUMBERED_FACES
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from tests.dem.body_starts import motion_at_rest, state_of_leaning_rotating_body
from tests.expect import expect_error

BOX = np.array([[x, y, z] for x in (-0.1, 0.1) for y in (-0.2, 0.2) for z in (0.0, 0.6)])
WEDGE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.4, 0.4, 0.8], [0.4, 0.6, 0.8]], dtype=float)


def centre_and_inertia_by_grid_summation(body_vertices: np.ndarray, count: int = 60) -> tuple[np.ndarray, np.ndarray]:
    """Return the centre and the inertia per mass of a convex hull, by summing over grid cells inside."""
    from scipy.spatial import ConvexHull

    hull = ConvexHull(body_vertices)
    low, high = body_vertices.min(axis=0), body_vertices.max(axis=0)
    axes = [low[k] + (np.arange(count) + 0.5) / count * (high[k] - low[k]) for k in range(3)]
    cells = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    cells = cells[(cells @ hull.equations[:, :3].T + hull.equations[:, 3] < 0).all(axis=1)]
    centre = cells.mean(axis=0)
    r = cells - centre
    return centre, np.sum(r**2) / len(r) * np.eye(3) - r.T @ r / len(r)


def test_polyhedron_of_box_vertices_equals_rectangular_prism() -> None:
    box, prism = Polyhedron(BOX).solid(0.6, 0, 0), RectangularPrism().solid(0.6, 1 / 3, 2.0)
    np.testing.assert_allclose(box.inertia_per_mass, prism.inertia_per_mass, atol=1e-12)
    assert {tuple(p) for p in np.round(box.contact_points_from_centre_of_mass, 9)} == {
        tuple(p) for p in np.round(prism.contact_points_from_centre_of_mass, 9)
    }
    assert box.least_tilt_to_rest_on_another_face_rad == pytest.approx(np.pi / 2)
    np.testing.assert_allclose(box.resting_face_normals_after_fall, prism.resting_face_normals_after_fall, atol=1e-9)
    t = np.arange(200) * 0.01
    motion = Motion(6.0 * np.sin(7 * t), 4.0 * np.cos(5 * t), sampling_interval=0.01)
    same = {"orientation_deg": [10.0, 50.0], "friction": [0.5]}
    boxes = simulate_as_arrays(motion, Body(Polyhedron(BOX), VertexContact(2e-5)), **same)
    prisms = simulate_as_arrays(
        motion, Body(RectangularPrism(), VertexContact(2e-5)), height=0.6, b_over_h=1 / 3, aspect=2.0, **same
    )
    assert boxes["overturned"].any()
    for name in ("overturned", "fall_face"):
        np.testing.assert_array_equal(boxes[name], prisms[name])
    np.testing.assert_allclose(boxes["fall_azimuth"], prisms["fall_azimuth"], atol=0.1)


@pytest.mark.parametrize("vertices", [WEDGE, np.random.default_rng(3).normal(size=(9, 3))])
def test_mass_properties_agree_with_numerical_integration(vertices: np.ndarray) -> None:
    from overturning.model.polyhedron import _hull_of_checked_convex_vertices

    hull = _hull_of_checked_convex_vertices(
        np.concatenate([vertices[:0], vertices[np.unique(hull_vertex_indices(vertices))]])
    )
    kept = vertices[np.unique(hull_vertex_indices(vertices))]
    centre, inertia = centre_and_inertia_by_grid_summation(vertices)
    np.testing.assert_allclose(kept[0] - hull.vertices_from_centre_of_mass[0], centre, atol=0.01 * np.ptp(vertices))
    np.testing.assert_allclose(hull.inertia_per_mass, inertia, atol=0.01 * np.trace(inertia))


def hull_vertex_indices(vertices: np.ndarray) -> np.ndarray:
    """Return the indices of the points that are vertices of the convex hull."""
    from scipy.spatial import ConvexHull

    return ConvexHull(vertices).vertices


def test_regular_prisms_agree_with_the_square_and_the_cylinder() -> None:
    square, prism = RegularPrism(4).solid(0.6, 0.4, 1.0), RectangularPrism().solid(0.6, 0.4, 1.0)
    np.testing.assert_allclose(square.inertia_per_mass, prism.inertia_per_mass, atol=1e-12)
    np.testing.assert_allclose(
        square.contact_points_from_centre_of_mass, prism.contact_points_from_centre_of_mass, atol=1e-12
    )
    np.testing.assert_allclose(
        RegularPrism(96).solid(0.6, 0.4, 1.0).inertia_per_mass,
        Cylinder().solid(0.6, 0.4, 1.0).inertia_per_mass,
        rtol=2e-3,
    )
    assert [
        RegularPrism(6).solid(1, 0.5, 1).symmetry_period_deg,
        prism.symmetry_period_deg,
        RectangularPrism().solid(1, 0.5, 2).symmetry_period_deg,
    ] == [
        60.0,
        90.0,
        180.0,
    ]


def test_the_fall_tilt_of_a_wedge_is_that_of_rest_on_another_face() -> None:
    body = Polyhedron(WEDGE).unscaled_solid
    # From statics: the body is rotated until a face lies on the ground, with the centre above that face.
    tilts = [np.degrees(np.arccos(-normal[2])) for normal in body.resting_face_normals_after_fall]
    assert np.degrees(body.least_tilt_to_rest_on_another_face_rad) == pytest.approx(min(tilts), abs=1e-3)
    assert 90.0 < min(tilts) < 180.0
    assert len(body.contact_points_from_centre_of_mass) == 4  # the upper edge touches only when it has fallen


def test_vertices_that_cannot_touch_the_ground_are_removed_from_a_body() -> None:
    body = Polyhedron(BOX).unscaled_solid
    assert len(body.contact_points_from_centre_of_mass) == 4
    # At each tilt below the fall tilt, in any direction, the lowest vertex is not among the dropped ones.
    rng = np.random.default_rng(1)
    lump = rng.normal(size=(40, 3))
    lump = lump / np.linalg.norm(lump, axis=1)[:, None] * [0.3, 0.3, 0.2]
    low = np.array([[0.12, 0.1, -0.15], [-0.13, 0.1, -0.15], [-0.1, -0.12, -0.15], [0.11, -0.1, -0.15]])
    whole = np.concatenate([low, lump[lump[:, 2] > -0.1]])
    whole = whole[hull_vertex_indices(whole)]
    stone = Polyhedron(whole).unscaled_solid
    centred = whole - whole[0]
    for _ in range(300):
        turn, tilt = rng.uniform(0, 2 * np.pi), rng.uniform(0, stone.least_tilt_to_rest_on_another_face_rad)
        down = np.array([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), -np.cos(tilt)])
        assert (stone.contact_points_from_centre_of_mass @ down).max() - stone.contact_points_from_centre_of_mass[
            0
        ] @ down >= (centred @ down).max() - (
            given_coordinates_of_first_body_vertex(stone, whole) - whole[0]
        ) @ down - 1e-9


def given_coordinates_of_first_body_vertex(stone: RigidSolid, whole: np.ndarray) -> np.ndarray:
    """Return, as given, the vertex that is the first contact point of a body's base.

    It is found among the given vertices `whole`, shape (n, 3), by the horizontal distances of the base's vertices from
    it.
    """
    lowest = whole[whole[:, 2] < whole[:, 2].min() + 1e-9]
    differences = (
        stone.contact_points_from_centre_of_mass[: stone.base_vertex_count, :2]
        - stone.contact_points_from_centre_of_mass[0, :2]
    )
    return next(
        p for p in lowest if all(np.abs(lowest[:, :2] - p[:2] - d).sum(axis=1).min() < 1e-9 for d in differences)
    )


def test_an_eccentric_body_rests_in_equilibrium_on_its_contact_springs() -> None:
    body = Polyhedron(WEDGE).unscaled_solid
    pose = body_pose_at_rest_on_springs(body, 1e6)
    x, y = body.contact_points_from_centre_of_mass[: body.base_vertex_count, :2].T
    sunk = (body.centre_height - pose[2]) - (pose[3] * y - pose[4] * x)
    assert (sunk > 0).all()
    np.testing.assert_allclose(
        [sunk.sum(), (sunk * x).sum(), (sunk * y).sum()], [STANDARD_GRAVITY / 1e6, 0, 0], atol=1e-15
    )
    still = Motion(np.zeros(100), np.zeros(100), sampling_interval=0.01)
    found = simulate_as_arrays(still, Polyhedron(WEDGE), orientation_deg=0.0, leave_out=False)
    assert found["overturned"].item() == 0
    assert found["peak_tilt"].item() < 1e-3


LEANING_BOX = np.concatenate([BOX[BOX[:, 2] == 0], BOX[BOX[:, 2] > 0] + [0.5, 0, 0]])
KEEL_BODY = np.array([[0, 0, 0], [0.5, 0, 0], [1, 0, 0], *([x, y, 0.6] for x in (0, 1) for y in (-0.5, 0.5))])
CIRCLE_OF_VERTICES = np.stack(
    [np.cos(np.arange(150) * 0.0418879), np.sin(np.arange(150) * 0.0418879), np.zeros(150)], axis=1
)


@pytest.mark.parametrize(
    ("vertices", "words"),
    [
        (np.concatenate([BOX, [[0.0, 0.0, 0.3]]]), ["not convex", "vertex 8"]),
        (BOX * [1, 1, 0], ["no volume"]),
        (LEANING_BOX, ["outside its base", "falls by itself"]),
        (BOX * 1000, ["600 m", "millimetres"]),
        (BOX * 0.01, ["0.006 m"]),
        (np.concatenate([CIRCLE_OF_VERTICES, np.add(CIRCLE_OF_VERTICES, [0, 0, 1])]), ["150 vertices", "128"]),
        (WEDGE @ np.array([[1, 0, 0.3], [0, 1, 0.1], [-0.3, -0.1, 1]]), ["stands on 1 vertex"]),
        (KEEL_BODY, ["stands on an edge", "a face lies on z"]),
        (BOX[:3], ["shape (3, 3)"]),
    ],
)
def test_vertices_of_impossible_bodies_are_refused_with_the_reason(vertices: np.ndarray, words: list[str]) -> None:
    with expect_error(ArgumentError, *words, brief=True):
        Polyhedron(vertices)


def test_bad_body_arguments_are_refused_and_a_motion_without_vertical_is_noted() -> None:
    motion = Motion(np.ones(10), np.ones(10), sampling_interval=0.01)
    grid = {"orientation_deg": [0.0], "height": [0.6], "b_over_h": [0.4]}
    for change, words in (
        ({"height": [600.0]}, ["height", "600", "millimetres"]),
        ({"b_over_h": None}, ["b_over_h", "not given"]),
        ({"model": "ball"}, ["model", "ball", "circle"]),
        ({"model": 2}, ["2 sides"]),
        ({"model": "circle", "aspect": [1.0, 2.0]}, ["aspect", "rectangle"]),
        ({"model": Polyhedron(BOX)}, ["b_over_h", "its own"]),
        ({"friction": [-0.1]}, ["friction", "-0.1"]),
        ({"scheme": "polygon"}, ["scheme", "polygon"]),
        ({"time_step": 1.0}, ["time_step", "not stable"]),
        ({"model": Body("rectangle", VertexContact(1e-14))}, ["stiffness"]),
    ):
        with expect_error(ArgumentError, *words):
            simulate_as_arrays(motion, **{"model": "rectangle", **grid, **change})
    with expect_error(ArgumentError, "static_penetration", "0"):
        VertexContact(0.0)
    assert "two components" in simulate(motion, "rectangle", **grid).vertical_motion
    assert shape_from_name_or_sides(6).name == "6 sides"


@pytest.mark.parametrize("sides", [3, 4, 6, 7])
def test_faces_of_a_prism_given_by_vertices_are_numbered_from_the_x_axis(sides: int) -> None:
    """The numbers of the faces equal those of the named prism, also if the vertices differ in their last digit."""
    own = RegularPrism(sides).solid(0.6, 0.3, 1.0)
    ring = own.contact_points_from_centre_of_mass[:sides, :2]
    for turned in (0.0, 1e-15, -1e-15):
        x, y = ring.T
        around = np.column_stack([x - turned * y, y + turned * x])
        body = Polyhedron(
            np.concatenate([np.column_stack([around, np.full(sides, z)]) for z in (0.0, 0.6)])
        ).unscaled_solid
        np.testing.assert_allclose(body.resting_face_normals_after_fall, own.resting_face_normals_after_fall, atol=1e-9)


def test_faces_of_a_body_with_too_many_faces_are_not_numbered() -> None:
    """A rounded scan has hundreds of facets on which it could rest; its falls are detected all the same."""
    stone = ScannedStone(
        points_of_ball_with_flat_base(), [0.0, 0.0, 0.3], [0.03, 0.03, 0.03, 0.0, 0.0, 0.0], 0.003, "round"
    )
    assert len(stone.unscaled_solid.resting_face_normals_after_fall) > MAX_FACE_COUNT_OF_BODY_WITH_NUMBERED_FACES
    push = Motion(np.repeat([3.0, 0.0], [100, 300]), np.zeros(400), sampling_interval=0.01)
    found = simulate(push, stone, orientation_deg=[0.0, 100.0, 200.0], height=None, friction=[0.7])
    assert (found.overturned == 1).all()
    assert found.fall_face.isnull().all()
    np.testing.assert_allclose(np.cos(np.radians(found.fall_azimuth)), -1.0, atol=0.1)


def points_of_ball_with_flat_base() -> np.ndarray:
    """Return points of a ball, evenly spread by the golden angle, with a small flat base."""
    height = 1.0 - 2.0 * (np.arange(500) + 0.5) / 500
    level, turn = np.sqrt(1.0 - height**2), np.pi * (1.0 + 5.0**0.5) * np.arange(500)
    points = 0.3 * np.column_stack([level * np.cos(turn), level * np.sin(turn), height]) + [0.0, 0.0, 0.3]
    return points[points[:, 2] > 0.008]


@pytest.mark.parametrize("decimals", [4, 5, 6, 7, 16])
def test_a_side_with_rounded_vertex_coordinates_counts_as_one_face(decimals: int) -> None:
    """An obelisk from a mesh file has four faces to fall onto, at the azimuths of its outline."""
    for turn in np.linspace(0.05, 1.5, 12):
        angle = turn + 0.5 * np.pi * np.arange(4)  # directions of the sides, anticlockwise from x
        ring = np.column_stack([np.cos(angle + 0.25 * np.pi), np.sin(angle + 0.25 * np.pi)])
        levels = [np.column_stack([r * ring, np.full(4, z)]) for r, z in ((0.15, 0.0), (0.1, 0.8))]
        faces = Polyhedron(np.round(np.concatenate(levels), decimals)).unscaled_solid.resting_face_normals_after_fall
        clockwise = np.sort(-angle % (2.0 * np.pi))
        np.testing.assert_allclose(np.arctan2(-faces[:, 1], faces[:, 0]) % (2.0 * np.pi), clockwise, atol=2e-3)


def test_the_initial_state_rotates_with_the_body_at_equivalent_orientations() -> None:
    """The body starts at its tipping angle over its first side, moving downwards."""
    alpha, radius = np.arctan(0.4), 0.3 / np.cos(np.arctan(0.4))
    start = state_of_leaning_rotating_body(alpha, np.array([0.0, 0.0, -radius]), np.array([0.0, 0.5, 0.0]))
    body, around = (
        Body("rectangle", start=start),
        {"height": 0.6, "b_over_h": 0.4, "orientation_deg": [0.0, 90.0, 180.0]},
    )
    for several in (around, around | {"orientation_deg": 90.0}, around | {"orientation_deg": -10.0}):
        with expect_error(ArgumentError, "start: it turns with the body", "leave_out=False"):
            simulate_as_arrays(motion_at_rest(0.5), body, **several)
    alone = simulate_as_arrays(motion_at_rest(0.5), body, **around | {"orientation_deg": 30.0})
    assert alone["fall_azimuth"].item() == pytest.approx(30.0, abs=1e-3)
    found = simulate_as_arrays(motion_at_rest(0.5), body, **around, leave_out=False)
    np.testing.assert_allclose(found["fall_azimuth"].ravel(), around["orientation_deg"], atol=1e-3)
    with expect_error(ArgumentError, "start: quaternion", "length must be 1"):
        start = InitialState((0.0, 0.0, 0.3), (2.0, 0.0, 0.0, 0.0))
        simulate_as_arrays(motion_at_rest(0.5), Body("circle", start=start), **around | {"orientation_deg": 0.0})


def test_a_grid_of_orientations_covers_one_symmetry_period() -> None:
    grids = [
        orientations_over_symmetry_period_deg(5.0, RectangularPrism()),
        orientations_over_symmetry_period_deg(5.0, RectangularPrism(), [1.0, 2.0]),
        orientations_over_symmetry_period_deg(5.0, Cylinder()),
    ]
    assert [(grid.size, grid[-1]) for grid in grids] == [(18, 85.0), (36, 175.0), (1, 0.0)]
    with expect_error(ArgumentError, "orientation", "7°", "90°", brief=True):
        orientations_over_symmetry_period_deg(7.0, RectangularPrism())


def test_the_spring_eigenvalue_of_a_size_is_computed_once_for_all_records() -> None:
    """A study plans the simulations of each record separately, with stones of the same sizes."""
    motion = Motion(np.zeros(50), np.zeros(50), sampling_interval=0.02)
    arguments = {"height": [0.7, 0.9], "b_over_h": [0.21, 0.31], "friction": 0.6}
    simulate_as_arrays(motion, "rectangle", orientation_deg=[0.0], **arguments)
    before = smallest_squared_frequency_on_unit_springs.cache_info()
    simulate_as_arrays(motion.scaled_by(2.0), "rectangle", orientation_deg=[0.0, 10.0], **arguments)
    after = smallest_squared_frequency_on_unit_springs.cache_info()
    assert after.misses == before.misses
    assert after.hits == before.hits + 4


def slab_with_bevelled_rim(bottom: float, middle: float, top: float, height: float) -> Polyhedron:
    """Return a square slab by its half widths at bottom, middle and top, m; it can rest on no side."""
    rings = ((bottom, 0.0), (middle, height / 2), (top, height))
    corners = ((1, 1), (-1, 1), (-1, -1), (1, -1))
    return Polyhedron(np.array([[x * half, y * half, z] for half, z in rings for x, y in corners]))


@pytest.mark.parametrize("speed", [11.0, 14.0, 18.0])
@pytest.mark.parametrize(
    "slab", [(0.14, 0.15, 0.14, 0.04), (0.13, 0.15, 0.13, 0.10), (0.12, 0.15, 0.145, 0.05)], ids=str
)
def test_a_slab_that_turns_upside_down_has_fallen(slab: tuple[float, float, float, float], speed: float) -> None:
    """The slab rotates about an edge of its base faster than gravity stops it; its tilt approaches 180° on its top."""
    shape = slab_with_bevelled_rim(*slab)
    high, wide = shape.unscaled_solid.centre_height, slab[0]
    begin = InitialState(
        (0.0, 0.0, high), (1.0, 0.0, 0.0, 0.0), centre_velocity=(speed * high, 0.0, speed * wide),
        angular_velocity=(0.0, speed, 0.0),
    )  # fmt: skip
    still = Motion(np.zeros(1200), np.zeros(1200), sampling_interval=0.01)
    found = simulate(still, Body(shape, start=begin), orientation_deg=0.0, friction=0.8)
    assert found["overturned"].item() == 1.0
    assert found["peak_tilt"].item() > 179.8


@pytest.mark.parametrize(
    ("made", "words"),
    [
        (lambda: InitialState((0.0, 0.0), (1.0, 0.0, 0.0, 0.0)), ["centre_position: shape (2,)", "shape (3,)"]),
        (
            lambda: InitialState((0.0, 0.0, 0.5), (1.0, 0.0, 0.0)),
            ["rest_to_initial_quaternion_wxyz: shape (3,)", "shape (4,)"],
        ),
        (lambda: InitialState((0, 0, np.nan), (1, 0, 0, 0)), ["centre_position: nan", "finite"]),
        (
            lambda: InitialState((0, 0, 1), (1, 0, 0, 0), centre_velocity=(np.inf, 0, 0)),
            ["centre_velocity: inf", "finite"],
        ),
        (lambda: Body(start="tilted"), ["start: a str", "InitialState"]),
        (lambda: Polyhedron("abc"), ["vertices: 'abc'", "number"]),
        (lambda: Polyhedron([[0, 0, 0], [1, 1]]), ["vertices", "number"]),
        (lambda: Polyhedron(BOX[:, :2]), ["vertices: shape (8, 2)", "shape (n, 3)"]),
        (lambda: Polyhedron(BOX * np.nan), ["vertices: nan", "finite"]),
        (lambda: ScannedStone(BOX[:, :2], [0, 0, 0.3], [0.1, 0.1, 0.02, 0, 0, 0]), ["vertices: shape (8, 2)"]),
        (lambda: ScannedStone(BOX, [0, 0, np.nan], [0.1, 0.1, 0.02, 0, 0, 0]), ["centre_of_mass: nan", "finite"]),
        (lambda: ScannedStone(BOX, [0, 0, -0.5], [0.1, 0.1, 0.02, 0, 0, 0]), ["centre_of_mass: -0.5 m", "0 and 0.6 m"]),
        (lambda: ScannedStone(BOX, [0, 0, 3.0], [0.1, 0.1, 0.02, 0, 0, 0]), ["centre_of_mass: 3 m", "0 and 0.6 m"]),
        (lambda: RegularPrism(2), ["sides: 2", "from 3 to 96"]),
        (lambda: RegularPrism(4.5), ["sides: 4.5", "whole number"]),  # type: ignore[arg-type]
    ],
)  # fmt: skip
def test_invalid_arguments_of_a_body_are_named_in_the_error(made: Callable[[], object], words: list[str]) -> None:
    with expect_error(ArgumentError, *words):
        made()


def test_a_numpy_integer_is_accepted_as_number_of_sides() -> None:
    assert shape_from_name_or_sides(np.int64(5)) == RegularPrism(5)  # type: ignore[arg-type]
