"""Non-convex polygons: outline of joined polygons, and decomposition of an outline into convex pieces.

An outline is cut along diagonals between vertices: it is divided into triangles by ear clipping, and triangles are
merged while the result is convex (Hertel and Mehlhorn 1983). So each side of the outline belongs to exactly one piece.
"""

from collections.abc import Sequence
from itertools import combinations, pairwise
from typing import Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError

JOIN_TOLERANCE_TO_OUTLINE_SIZE_RATIO: Final = 1e-6
"""Distance below which two vertices coincide, or a vertex lies on a side, as a share of the size."""

MAX_DOUBLED_COLLINEAR_AREA_TO_SIZE_SQUARED: Final = 1e-12
"""Twice the area of a corner below which its three vertices are collinear, as a share of the size squared."""


def signed_doubled_triangle_area(
    first_vertex: FloatArray, second_vertex: FloatArray, third_vertex: FloatArray
) -> float:
    """Return twice the area of the triangle of three vertices [x, z], m², positive if it runs counter-clockwise."""
    return float(
        (second_vertex[0] - first_vertex[0]) * (third_vertex[1] - first_vertex[1])
        - (second_vertex[1] - first_vertex[1]) * (third_vertex[0] - first_vertex[0])
    )


def polygon_crosses_itself(vertices: FloatArray) -> bool:
    """True if any two sides of a closed polygon cross."""
    n = len(vertices)
    for i, j in combinations(range(n), 2):
        a, b, c, d = (vertices[k % n] for k in (i, i + 1, j, j + 1))
        if (
            signed_doubled_triangle_area(a, b, c) * signed_doubled_triangle_area(a, b, d) < 0
            and signed_doubled_triangle_area(c, d, a) * signed_doubled_triangle_area(c, d, b) < 0
        ):
            return True
    return False


def outline_of_joined_pieces(element_name: str, vertices_of_each_piece: Sequence[FloatArray]) -> FloatArray:
    """Return the outer outline of convex polygons joined along common sides, without these common sides.

    Parameters
    ----------
    element_name : str
        Name of the element, for messages.
    vertices_of_each_piece : sequence of ndarray, shape (n, 2)
        Vertices of each convex piece, counter-clockwise, m; pieces in any order.

    Returns
    -------
    ndarray, shape (n, 2)
        Counter-clockwise from the lowest vertex, of several the leftmost; collinear vertices are omitted.

    Raises
    ------
    ArgumentError
        If pieces overlap, or do not form one outline without holes.
    """
    ordered = sorted(
        (np.asarray(piece, dtype=np.float64) for piece in vertices_of_each_piece), key=lambda piece: piece.tolist()
    )
    size = float(np.ptp(np.concatenate(ordered), axis=0).max())
    for (i, one), (j, other) in combinations(enumerate(ordered), 2):
        depth = -max(_separation_along_side_normals(one, other), _separation_along_side_normals(other, one))
        if depth > JOIN_TOLERANCE_TO_OUTLINE_SIZE_RATIO * size:
            raise ArgumentError(
                f"element {element_name}: the pieces with {_first_vertex_as_text(ordered[i])} and "
                f"{_first_vertex_as_text(ordered[j])} overlap by {depth:.3g} m; make them share a side, or give the "
                "outline as vertices"
            )
    points: list[FloatArray] = []
    loops = [
        [
            _index_of_known_or_appended_point(point, points, JOIN_TOLERANCE_TO_OUTLINE_SIZE_RATIO * size)
            for point in piece
        ]
        for piece in ordered
    ]
    places = np.array(points)
    sides = [
        side
        for loop in loops
        for first, second in zip(loop, loop[1:] + loop[:1], strict=True)
        for side in _split_side_at_points(first, second, places, JOIN_TOLERANCE_TO_OUTLINE_SIZE_RATIO * size)
    ]
    left = set(sides) - {(second, first) for first, second in sides}
    following = dict(left)
    at = min(following, key=lambda k: (places[k, 1], places[k, 0]))
    way = [at]
    while following[way[-1]] != at and len(way) < len(left):
        way.append(following[way[-1]])
    if len(way) != len(left) or len(following) != len(left):
        raise ArgumentError(
            f"element {element_name}: its pieces do not form one outline without holes; make each share a side with "
            "another"
        )
    line = places[way]
    before, after = np.roll(line, 1, axis=0), np.roll(line, -1, axis=0)
    area = [abs(signed_doubled_triangle_area(*corner)) for corner in zip(before, line, after, strict=True)]
    return np.asarray(
        line[area > JOIN_TOLERANCE_TO_OUTLINE_SIZE_RATIO * size * np.sqrt(((after - before) ** 2).sum(axis=1))]
    )


def _first_vertex_as_text(polygon_vertices: FloatArray) -> str:
    """Return the first vertex of a polygon as text for error messages."""
    return f"[{polygon_vertices[0, 0]:g}, {polygon_vertices[0, 1]:g}]"


def _separation_along_side_normals(polygon_vertices: FloatArray, other_polygon_vertices: FloatArray) -> float:
    """Return the gap (m) between two convex polygons, the largest across a side of the first; negative: no gap."""
    edge = np.roll(polygon_vertices, -1, axis=0) - polygon_vertices
    normal = np.stack([edge[:, 1], -edge[:, 0]], axis=1) / np.sqrt((edge**2).sum(axis=1))[:, None]
    return float(((other_polygon_vertices @ normal.T).min(axis=0) - (polygon_vertices * normal).sum(axis=1)).max())


def _index_of_known_or_appended_point(
    point: FloatArray, known_points_to_append_to: list[FloatArray], max_coordinate_difference: float
) -> int:
    """Return the index of the known point equal to `point` within a difference (m); append `point` if none is."""
    for number, other in enumerate(known_points_to_append_to):
        if np.abs(point - other).max() <= max_coordinate_difference:
            return number
    known_points_to_append_to.append(point)
    return len(known_points_to_append_to) - 1


def _split_side_at_points(
    side_start_point_index: int, side_end_point_index: int, points: FloatArray, max_distance_from_side: float
) -> list[tuple[int, int]]:
    """Return a polygon side split at each of `points` that lies on it, as pairs of point indices."""
    edge = points[side_end_point_index] - points[side_start_point_index]
    length = float(np.sqrt((edge**2).sum()))
    along = (points - points[side_start_point_index]) @ edge / length
    across = np.abs((points - points[side_start_point_index]) @ np.array([-edge[1], edge[0]])) / length
    on = np.flatnonzero(
        (across <= max_distance_from_side)
        & (along > max_distance_from_side)
        & (along < length - max_distance_from_side)
    )
    stops = [side_start_point_index, *on[np.argsort(along[on])].tolist(), side_end_point_index]
    return list(pairwise(stops))


def convex_piece_vertex_indices(outline_vertices: FloatArray) -> list[list[int]]:
    """Return the convex pieces of a polygon outline, each as vertex indices counter-clockwise.

    Parameters
    ----------
    outline_vertices : ndarray, shape (n, 2)
        Vertices counter-clockwise, no three neighbours collinear, m.

    Raises
    ------
    ArgumentError
        If the outline crosses or touches itself.
    """
    least = MAX_DOUBLED_COLLINEAR_AREA_TO_SIZE_SQUARED * float(np.ptp(outline_vertices, axis=0).max()) ** 2
    pieces = _triangulate_polygon(outline_vertices, least)
    merged = True
    while merged:
        merged = False
        for one, other in combinations(pieces, 2):
            joined = _merge_pieces_if_they_share_a_diagonal(one, other)
            if joined and all(
                signed_doubled_triangle_area(
                    outline_vertices[joined[k - 1]],
                    outline_vertices[at],
                    outline_vertices[joined[(k + 1) % len(joined)]],
                )
                > least
                for k, at in enumerate(joined)
            ):
                pieces = [piece for piece in pieces if piece is not one and piece is not other] + [joined]
                merged = True
                break
    return pieces


def _triangulate_polygon(outline_vertices: FloatArray, min_doubled_triangle_area: float) -> list[list[int]]:
    """Return a triangulation of a polygon outline, by ear clipping, each triangle as three vertex indices."""
    left, triangles = list(range(len(outline_vertices))), []
    while len(left) > 3:
        for k, at in enumerate(left):
            ear = [left[k - 1], at, left[(k + 1) % len(left)]]
            if _can_cut_off_triangle(outline_vertices, left, ear, min_doubled_triangle_area):
                triangles.append(ear)
                del left[k]
                break
        else:
            raise ArgumentError("the outline touches itself; move its vertices apart")
    return [*triangles, left]


def _can_cut_off_triangle(
    outline_vertices: FloatArray,
    remaining_vertex_indices: list[int],
    triangle_vertex_indices: list[int],
    min_doubled_triangle_area: float,
) -> bool:
    """True if a triangle of successive vertices is counter-clockwise and empty, so that it can be cut off."""
    a, b, c = outline_vertices[triangle_vertex_indices]
    if signed_doubled_triangle_area(a, b, c) <= min_doubled_triangle_area:
        return False
    others = (outline_vertices[k] for k in remaining_vertex_indices if k not in triangle_vertex_indices)
    return not any(
        min(
            signed_doubled_triangle_area(a, b, p),
            signed_doubled_triangle_area(b, c, p),
            signed_doubled_triangle_area(c, a, p),
        )
        >= -min_doubled_triangle_area
        for p in others
    )


def _merge_pieces_if_they_share_a_diagonal(
    first_piece_vertex_indices: list[int], second_piece_vertex_indices: list[int]
) -> list[int] | None:
    """Return the vertex indices of two polygon pieces merged at their common diagonal; None if they have none."""
    for k, first in enumerate(first_piece_vertex_indices):
        second = first_piece_vertex_indices[(k + 1) % len(first_piece_vertex_indices)]
        for m, at in enumerate(second_piece_vertex_indices):
            if at == second and second_piece_vertex_indices[(m + 1) % len(second_piece_vertex_indices)] == first:
                # Around the first piece from the diagonal's second end to its first, then around the other.
                return (
                    first_piece_vertex_indices[k + 1 :]
                    + first_piece_vertex_indices[: k + 1]
                    + (second_piece_vertex_indices[m:] + second_piece_vertex_indices[:m])[2:]
                )
    return None
