"""Polygons: area, centre, inertia and faces from closed forms; a non-convex polygon has convex pieces."""

from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from typing import Final

import numpy as np
import scipy
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.model.pieces import (
    MAX_DOUBLED_COLLINEAR_AREA_TO_SIZE_SQUARED,
    convex_piece_vertex_indices,
    polygon_crosses_itself,
)
from overturning.model.rest import mask_of_resting_faces

MAX_ASYMMETRY_TO_POLYGON_SIZE_RATIO: Final = 1e-9
"""Relative tolerance of mirror symmetry: vertices within it, as a share of the size, are made to mirror exactly."""


@dataclass(frozen=True)
class Polygon:
    """Polygon with vertices relative to its centre of area, or, for a convex piece, to that of the whole polygon."""

    vertices_from_whole_polygon_centroid: (
        FloatArray  # shape (n, 2), counter-clockwise, x to the right and z up, relative to the centre, m
    )
    centroid_in_given_coordinates: tuple[float, float]  # in the coordinates in which the polygon was given, m
    area: float  # m²
    polar_second_moment_about_centroid: float  # second moment of area about the centre, m⁴
    convex_pieces_if_not_convex: tuple[
        "Polygon", ...
    ] = ()  # convex pieces of a non-convex polygon; empty if it is convex
    load_bearing_ends_and_original_side_flags_by_face: FloatArray = field(default_factory=lambda: np.ones((1, 3)))
    """1 or 0 per face: first end can bear load; second end can; face is a side of the whole polygon, not a cut.

    Shape (n, 3), or (1, 3) if equal for all faces.
    """

    def __post_init__(self) -> None:
        self.vertices_from_whole_polygon_centroid.flags.writeable = False  # scenes share polygons

    @property
    def convex_parts(self) -> tuple["Polygon", ...]:
        """Convex pieces of the polygon, or the polygon itself if it is convex."""
        return self.convex_pieces_if_not_convex or (self,)

    @property
    def is_convex_and_mirror_symmetric(self) -> bool:
        """True if the polygon is convex and is its own mirror image about the vertical through its centre."""
        if self.convex_pieces_if_not_convex:
            return False
        mirrored = {(-x, z) for x, z in self.vertices_from_whole_polygon_centroid.tolist()}
        return mirrored == set(map(tuple, self.vertices_from_whole_polygon_centroid.tolist()))

    @cached_property
    def width(self) -> float:
        """Horizontal extent of the polygon, m."""
        return float(np.ptp(self.vertices_from_whole_polygon_centroid[:, 0]))

    @cached_property
    def height(self) -> float:
        """Vertical extent of the polygon, m."""
        return float(np.ptp(self.vertices_from_whole_polygon_centroid[:, 1]))

    @cached_property
    def smallest_rotations_to_other_resting_face_rad(self) -> tuple[float, float]:
        """Least rotations to −x and +x (rad) after which the polygon can rest on another face; π if it cannot.

        Both are 90° for a rectangle. The face that points most nearly down at rest is excluded. The rotations are
        rounded because the last digit of libm differs between processors.
        """
        hull = (
            self.vertices_from_whole_polygon_centroid[
                scipy.spatial.ConvexHull(self.vertices_from_whole_polygon_centroid).vertices
            ]
            if self.convex_pieces_if_not_convex
            else self.vertices_from_whole_polygon_centroid
        )
        faces = Polygon(hull, self.centroid_in_given_coordinates, 0.0, 0.0).face_geometry_and_contact_flag_table
        normals, offsets = faces[:, 4:6], faces[:, 6]
        tilts = np.arctan2(
            normals[:, 0], -normals[:, 1]
        )  # a face with its normal towards +x comes down by a rotation to +x
        stable = mask_of_resting_faces(normals, offsets, max(self.width, self.height))
        stable[np.argmin(np.abs(tilts))] = False
        back, on = (float(np.min(turns[stable & (turns > 0)], initial=np.pi)) for turns in (-tilts, tilts))
        return round(back, 12), round(on, 12)

    @cached_property
    def face_geometry_and_contact_flag_table(self) -> FloatArray:
        """Ends, outward normal and distances of each face of a convex polygon, for compiled code; shape (n, 12).

        Columns: first and second end (4), outward normal (2), distance from the centre, position of the middle along
        the tangent (−n_z, n_x), half length, `load_bearing_ends_and_original_side_flags_by_face` (3). Mirrored faces
        of a symmetric polygon have exactly mirrored numbers.
        """
        first, second = (
            self.vertices_from_whole_polygon_centroid,
            np.roll(self.vertices_from_whole_polygon_centroid, -1, axis=0),
        )
        edge = second - first
        length = np.sqrt(edge[:, 0] * edge[:, 0] + edge[:, 1] * edge[:, 1])
        tangent = edge / length[:, None]
        normal = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
        middle = 0.5 * (first + second)
        offset = normal[:, 0] * middle[:, 0] + normal[:, 1] * middle[:, 1]
        along = tangent[:, 0] * middle[:, 0] + tangent[:, 1] * middle[:, 1]
        carries = np.broadcast_to(self.load_bearing_ends_and_original_side_flags_by_face, (len(first), 3))
        table = np.column_stack([first, second, normal, offset, along, 0.5 * length, carries])
        table.flags.writeable = False
        return table


def make_polygon(element_name: str, vertices: ArrayLike) -> Polygon:
    """Return a checked polygon with area, centre and inertia and, if it is not convex, with its convex pieces.

    Area, centre and second moment follow from Green's theorem.

    Parameters
    ----------
    element_name : str
        Name of the element, for messages.
    vertices : array_like, shape (n, 2)
        Vertices counter-clockwise, x to the right, z up, m.

    Raises
    ------
    ArgumentError
        If the polygon is degenerate, runs clockwise or crosses itself.
    """
    points = np.asarray(vertices, dtype=np.float64)
    if points.ndim != 2 or points.shape[1:] != (2,) or len(points) < 3 or not np.isfinite(points).all():
        raise ArgumentError(f"element {element_name}: a polygon has at least three vertices [x, z] of finite numbers")
    return _polygon_from_vertex_bytes(element_name, points.tobytes())


@lru_cache(maxsize=1024)
def _polygon_from_vertex_bytes(element_name: str, vertex_bytes: bytes) -> Polygon:
    """Return the polygon with vertices given as bytes of float64 pairs, cached because scenes repeat polygons."""
    points = np.frombuffer(vertex_bytes).reshape(-1, 2)
    origin = points[0].copy()
    x, z = (points - origin).T  # near the origin, so that a polygon far away keeps its digits
    u, w = np.roll(x, -1), np.roll(z, -1)
    cross = x * w - u * z
    area = 0.5 * float(cross.sum())
    size = float(np.ptp(points, axis=0).max())
    if abs(area) <= 1e-9 * size**2 or size == 0:
        raise ArgumentError(
            f"element {element_name}: the polygon is degenerate, its area {abs(area):.3g} m²; move its vertices apart"
        )
    if area < 0:
        raise ArgumentError(f"element {element_name}: the polygon runs clockwise; list its vertices counter-clockwise")
    edge = np.stack([u - x, w - z], axis=1)
    following = np.roll(edge, -1, axis=0)
    corners = edge[:, 0] * following[:, 1] - edge[:, 1] * following[:, 0]
    if (np.hypot(edge[:, 0], edge[:, 1]) <= 1e-9 * size).any():
        raise ArgumentError(f"element {element_name}: the polygon is degenerate, two vertices coincide; leave one out")
    straight = np.abs(corners) <= MAX_DOUBLED_COLLINEAR_AREA_TO_SIZE_SQUARED * size**2
    if straight.any():
        corner = (int(np.argmax(straight)) + 1) % len(points)
        raise ArgumentError(
            f"element {element_name}: vertex {corner} ({points[corner, 0]:g}, {points[corner, 1]:g}) lies in line with "
            "its neighbours; leave it out"
        )
    turns = np.arctan2(corners, edge[:, 0] * following[:, 0] + edge[:, 1] * following[:, 1]).sum()
    if not 0.5 < turns / (2 * np.pi) < 1.5 or polygon_crosses_itself(points):
        raise ArgumentError(f"element {element_name}: the polygon crosses itself; list its vertices in order around it")
    cx = float(((x + u) * cross).sum()) / (6 * area)
    cz = float(((z + w) * cross).sum()) / (6 * area)
    local = _remove_rounding_asymmetry(np.stack([x - cx, z - cz], axis=1), size)
    pieces = _convex_pieces_of_polygon(element_name, local, corners < 0) if (corners < 0).any() else ()
    x, z = local.T
    u, w = np.roll(x, -1), np.roll(z, -1)
    polar = float(((x * w - u * z) * (x * x + x * u + u * u + z * z + z * w + w * w)).sum()) / 12.0
    return Polygon(local, (cx + float(origin[0]), cz + float(origin[1])), area, polar, pieces)


def _convex_pieces_of_polygon(
    element_name: str, vertices: FloatArray, has_reflex_end_by_side: NDArray[np.bool_]
) -> tuple[Polygon, ...]:
    """Divide the outline of a non-convex polygon into convex pieces.

    `has_reflex_end_by_side`, shape (n,), is True for each side that ends in a reflex vertex. A cut may end at a convex
    vertex. Only one of the pieces then has a contact point there, so that the corner does not count twice: the piece
    with the side, of the two at this vertex, whose outward normal points further down. At a reflex vertex, each of the
    two sides has a contact point at its end.
    """
    count, turns_in = len(vertices), np.roll(has_reflex_end_by_side, 1)
    try:
        loops = convex_piece_vertex_indices(vertices)
    except ArgumentError as error:
        raise ArgumentError(f"element {element_name}: {error}") from None
    owner = {
        vertex: piece
        for piece, loop in enumerate(loops)
        for vertex in loop
        if _side_facing_more_downward(vertices, vertex) in _vertex_index_pairs_of_loop(loop)
    }
    shapes = []
    for piece, loop in enumerate(loops):
        carries = []
        for first, second in _vertex_index_pairs_of_loop(loop):
            side = second == (first + 1) % count
            ends = [side if turns_in[k] else owner[k] == piece for k in (first, second)]
            carries.append([*ends, side])
        shapes.append(
            Polygon(
                vertices[loop],
                (0.0, 0.0),
                0.0,
                0.0,
                load_bearing_ends_and_original_side_flags_by_face=np.array(carries, dtype=np.float64),
            )
        )
    return tuple(shapes)


def _vertex_index_pairs_of_loop(vertex_indices_around_polygon: list[int]) -> list[tuple[int, int]]:
    """Return the pairs of successive vertex indices around a closed polygon."""
    return list(
        zip(
            vertex_indices_around_polygon,
            vertex_indices_around_polygon[1:] + vertex_indices_around_polygon[:1],
            strict=True,
        )
    )


def _side_facing_more_downward(vertices: FloatArray, vertex_index: int) -> tuple[int, int]:
    """Return, as a vertex index pair, the side of a polygon vertex whose outward normal points further down."""
    count = len(vertices)
    both = [((vertex_index - 1) % count, vertex_index), (vertex_index, (vertex_index + 1) % count)]

    def normal_upward_component(side_vertex_indices: tuple[int, int]) -> float:
        x, z = vertices[side_vertex_indices[1]] - vertices[side_vertex_indices[0]]
        return float(-x / np.sqrt(x * x + z * z))

    return min(both, key=normal_upward_component)


def _remove_rounding_asymmetry(vertices: FloatArray, largest_extent: float) -> FloatArray:
    """Return vertices corrected for rounding, so that a nearly symmetric polygon is exactly mirror-symmetric."""
    x, z = vertices.T
    distance = np.abs(x + x[:, None]) + np.abs(z - z[:, None])
    if (distance.min(axis=1) > MAX_ASYMMETRY_TO_POLYGON_SIZE_RATIO * largest_extent).any():
        return vertices
    # Both vertices of a pair are computed from the same two numbers, in the same order.
    partner = distance.argmin(axis=1)
    return np.asarray(0.5 * np.stack([x - x[partner], z + z[partner]], axis=1))


def rectangle_vertices(width: float, height: float) -> FloatArray:
    """Return the vertices of a rectangle, shape (4, 2), m; the origin is the middle of its lower side."""
    half = 0.5 * width
    return np.array([[-half, 0.0], [half, 0.0], [half, height], [-half, height]])
