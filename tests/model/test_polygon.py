"""Area, centre and second moment of polygons against closed forms, and polygons that are refused."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from overturning.errors import ArgumentError
from overturning.model.polygon import make_polygon, rectangle_vertices


def test_area_and_inertia_of_a_rectangle_match_the_closed_form() -> None:
    shape = make_polygon("stone", rectangle_vertices(0.3, 0.8))
    assert shape.area == pytest.approx(0.24, rel=1e-14)
    assert shape.centroid_in_given_coordinates == pytest.approx((0.0, 0.4), abs=1e-15)
    assert shape.polar_second_moment_about_centroid == pytest.approx(0.24 * (0.3**2 + 0.8**2) / 12, rel=1e-14)


def test_area_and_inertia_of_a_triangle_match_the_closed_form() -> None:
    """A triangle's centre is the mean of its vertices, its polar moment A (a² + b² + c²)/36."""
    points = np.array([[0.0, 0.0], [3.0, 1.0], [1.0, 2.0]])
    shape = make_polygon("stone", points)
    sides = ((points - np.roll(points, 1, axis=0)) ** 2).sum()
    assert shape.centroid_in_given_coordinates == pytest.approx(tuple(points.mean(axis=0)), rel=1e-14)
    assert shape.polar_second_moment_about_centroid == pytest.approx(shape.area * sides / 36, rel=1e-13)


@pytest.mark.parametrize("corners", [3, 5, 6, 12])
def test_area_and_inertia_of_a_polygon_off_the_origin_match_the_closed_form(corners: int) -> None:
    """Regular n-gon of circumradius r: A = n r² sin(2π/n)/2, J = A r² (2 + cos(2π/n))/6."""
    angle = 2 * np.pi * np.arange(corners) / corners
    shape = make_polygon("stone", 2.0 * np.column_stack([np.cos(angle), np.sin(angle)]) + 1000.0)
    area = corners * 4.0 * np.sin(2 * np.pi / corners) / 2
    assert shape.area == pytest.approx(area, rel=1e-10)
    assert shape.centroid_in_given_coordinates == pytest.approx((1000.0, 1000.0), rel=1e-12)
    assert shape.polar_second_moment_about_centroid == pytest.approx(
        area * 4.0 * (2 + np.cos(2 * np.pi / corners)) / 6, rel=1e-9
    )


@settings(max_examples=60, deadline=None)
@given(st.integers(3, 9), st.integers(0, 10_000))
def test_polygon_properties_match_the_sum_of_its_triangles(corners: int, seed: int) -> None:
    """Sum of the triangles of a fan, each by its closed form and moved by the parallel axis theorem."""
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi, corners))
    if np.diff(np.append(angle, angle[0] + 2 * np.pi)).max() > 3.0 or np.diff(angle).min() < 0.05:
        return
    points = np.column_stack([1.5 * np.cos(angle), 0.7 * np.sin(angle)])
    shape = make_polygon("stone", points)
    area, first, second = 0.0, np.zeros(2), 0.0
    for u, w in itertools.pairwise(points[1:]):
        triangle = np.array([points[0], u, w])
        a = 0.5 * float(np.linalg.det(np.array([u - points[0], w - points[0]])))
        middle = triangle.mean(axis=0)
        area, first = area + a, first + a * middle
        second += a * ((triangle - np.roll(triangle, 1, axis=0)) ** 2).sum() / 36 + a * (middle @ middle)
    centre = first / area
    assert shape.area == pytest.approx(area, rel=1e-12)
    assert shape.centroid_in_given_coordinates == pytest.approx(tuple(centre), abs=1e-12)
    assert shape.polar_second_moment_about_centroid == pytest.approx(second - area * (centre @ centre), rel=1e-10)


def test_faces_of_a_symmetric_polygon_are_mirrored_exactly() -> None:
    shape = make_polygon("stone", [[-0.3, 0], [0.3, 0], [0.41, 0.37], [0.1, 0.93], [-0.1, 0.93], [-0.41, 0.37]])
    assert shape.is_convex_and_mirror_symmetric
    faces = {tuple(row) for row in shape.face_geometry_and_contact_flag_table[:, 4:9]}
    assert {(-nx, nz, offset, -middle, half) for nx, nz, offset, middle, half in faces} == faces


def test_an_asymmetric_polygon_is_not_taken_for_symmetric() -> None:
    assert not make_polygon("stone", [[-0.3, 0], [0.31, 0], [0.3, 1], [-0.3, 1]]).is_convex_and_mirror_symmetric


@pytest.mark.parametrize(
    ("points", "said"),
    [
        ([[0, 0], [0, 1], [1, 1], [1, 0]], "clockwise"),
        ([[0, 0], [1, 0], [2, 0]], "degenerate"),
        ([[0, 0], [2, 0], [2, 1], [2, 2]], "vertex 2 .* lies in line"),
        ([[0, 0], [1, 0], [1, 0], [0, 1]], "two vertices coincide"),
        ([[0, 0], [1, 0]], "at least three"),
        ([[0, 0], [1, 0], [np.nan, 1]], "finite"),
        ([[0, 1], [-0.59, -0.81], [0.95, 0.31], [-0.95, 0.31], [0.59, -0.81]], "crosses itself"),
    ],
)
def test_an_invalid_polygon_is_refused_by_the_name_of_its_element(points: list[list[float]], said: str) -> None:
    with pytest.raises(ArgumentError, match=f"element stone.*{said}"):
        make_polygon("stone", points)


L_SHAPE = [[0, 0], [1, 0], [1, 0.3], [0.4, 0.3], [0.4, 1.2], [0, 1.2]]
CROSS_SHAPE = [
    *([-0.1, 0], [0.1, 0], [0.1, 0.6], [0.35, 0.6], [0.35, 0.8], [0.1, 0.8]),
    *([0.1, 1.1], [-0.1, 1.1], [-0.1, 0.8], [-0.35, 0.8], [-0.35, 0.6], [-0.1, 0.6]),
]
S_SHAPE = [[0, 0], [3, 0], [3, 2], [1, 2], [1, 3], [3, 3], [3, 4], [0, 4], [0, 1.5], [2, 1.5], [2, 1], [0, 1]]


@pytest.mark.parametrize(
    ("points", "parts"),
    [
        (L_SHAPE, [(1.0, 0.3, 0.5, 0.15, 1), (0.4, 0.9, 0.2, 0.75, 1)]),
        (CROSS_SHAPE, [(0.2, 1.1, 0.0, 0.55, 1), (0.25, 0.2, 0.225, 0.7, 1), (0.25, 0.2, -0.225, 0.7, 1)]),
        (S_SHAPE, [(3.0, 4.0, 1.5, 2.0, 1), (2.0, 1.0, 2.0, 2.5, -1), (2.0, 0.5, 1.0, 1.25, -1)]),
    ],
    ids=["L", "cross", "S"],
)
def test_area_and_inertia_of_a_polygon_match_the_sum_of_its_rectangles(
    points: list[list[float]], parts: list[tuple[float, float, float, float, int]]
) -> None:
    """Rectangles b × h about (x, z), added or cut out: A = Σ b h, J = Σ b h ((b² + h²)/12 + d²) (Huygens–Steiner)."""
    b, h, x, z, sign = np.array(parts).T
    areas = sign * b * h
    centre = (areas @ x / areas.sum(), areas @ z / areas.sum())
    polar = (areas * ((b**2 + h**2) / 12 + (x - centre[0]) ** 2 + (z - centre[1]) ** 2)).sum()
    shape = make_polygon("stone", points)
    assert shape.area == pytest.approx(areas.sum(), rel=1e-12)
    assert shape.centroid_in_given_coordinates == pytest.approx(centre, abs=1e-12)
    assert shape.polar_second_moment_about_centroid == pytest.approx(polar, rel=1e-12)


def test_area_and_centre_of_a_trapezium_match_the_closed_form() -> None:
    """Parallel sides a = 0.8 (below) and b = 0.4, height 1: A = h (a + b)/2, z = h (a + 2b)/(3 (a + b)).

    The other sides lean inwards by atan 0.2: a rotation by 90° + atan 0.2 brings the trapezium to rest on one of them.
    """
    shape = make_polygon("stone", [[-0.4, 0], [0.4, 0], [0.2, 1], [-0.2, 1]])
    assert shape.area == pytest.approx(0.6)
    assert shape.centroid_in_given_coordinates == pytest.approx((0.0, 4 / 9))
    assert shape.smallest_rotations_to_other_resting_face_rad == pytest.approx([np.pi / 2 + np.arctan(0.2)] * 2)
