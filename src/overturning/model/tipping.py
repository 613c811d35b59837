"""Tilt at which a convex polyhedron has fallen, as a function of the direction in which it leans.

Seen from the side, a body that leans in one direction is a polygon about its centre. Like a polygon in 2-D, it has
fallen at the tilt at which it can rest on another side, which corresponds to an edge of the body. Edges from which it
rolls back onto its base are excluded. Directions are those of the downward vertical in the body's own axes.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.model.rest import FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO

LEAN_DIRECTION_COUNT: Final = 1440
"""Number of directions of lean that are examined: one in the middle of each quarter of a degree."""

FALL_TILT_TO_RESTING_TILT_RATIO: Final = 0.999
"""Share of the geometric tilt from which a body counts as fallen: elastic contacts let it rest slightly earlier."""

LEAN_SECTOR_TABLE_DECIMALS: Final = 12
"""Decimals to which sectors are rounded: the last digit of libm differs between processors."""


class ConvexHull(NamedTuple):
    """Convex hull of a body, in coordinates about its centre of mass."""

    vertices_from_centre_of_mass: FloatArray
    """Vertices, shape (n, 3), m."""
    triangle_vertex_indices: NDArray[np.int64]
    """Vertex indices of each triangle, shape (m, 3), anticlockwise from outside."""
    triangle_sharing_edge_opposite_each_vertex: NDArray[np.int64]
    """Index of the triangle opposite to each vertex of a triangle, shape (m, 3)."""
    outward_triangle_normals: FloatArray
    """Outward normals of the triangles, shape (m, 3)."""
    plane_distances_from_centre: FloatArray
    """Distances of the triangles' planes from the centre, shape (m,), m."""
    inertia_per_mass: FloatArray
    """Inertia per mass, shape (3, 3), m²."""


class FallTiltByLeanDirection(NamedTuple):
    """Tilt from which a body counts as fallen, for each direction in which the body leans."""

    least_tilt_to_rest_on_another_face_rad: float
    """Least tilt at which it can rest on another face, rad."""
    fall_tilt_in_each_direction_rad: FloatArray
    """Tilt of its fall in each of `LEAN_DIRECTION_COUNT` directions of lean, rad."""
    lean_sector_start_vector_and_min_fall_dot_product: FloatArray
    """Rows of the table of fall limits of `RigidSolid`; empty if all directions have the same tilt."""
    touchable_vertex_indices_until_fall: NDArray[np.int64]
    """Indices of the vertices that can touch at a tilt between the least one and the fall."""

    def fall_tilt_towards_faces_rad(self, face_normals: FloatArray) -> FloatArray:
        """Return the tilt (rad) from which a body counts as fallen towards each face, for face normals (faces, 3)."""
        turn = np.arctan2(face_normals[:, 1], face_normals[:, 0]) % (2.0 * np.pi)
        return self.fall_tilt_in_each_direction_rad[
            np.minimum((turn / (2.0 * np.pi) * LEAN_DIRECTION_COUNT).astype(np.int64), LEAN_DIRECTION_COUNT - 1)
        ]


class LowestVertexChangesOnLeaning(NamedTuple):
    """Changes of a body's lowest vertex with growing tilt, for all directions of lean; one entry per change."""

    lean_direction_index: NDArray[np.int64]
    """Index of the direction."""
    index_of_edge_lowest_at_change: NDArray[np.int64]
    """Index of the edge both ends of which are lowest at that tilt."""
    tilt_at_change_rad: FloatArray
    """Tilt, rad."""
    centre_height_derivatives_on_edge_ends: FloatArray
    """Derivative of the centre's height with respect to tilt, for rolling on either end of the edge, (n, 2), m."""
    triangle_index_rolled_towards: NDArray[np.int64]
    """Index of the triangle towards which the body rolls over the edge."""


def fall_tilt_by_lean_direction(
    hull: ConvexHull,
    largest_extent: float,
    least_tilt_to_rest_on_another_face_rad: float,
    resting_face_normals_after_fall: FloatArray,
    min_resting_tilt_counted_as_fall_rad: float = 0.0,
) -> FallTiltByLeanDirection:
    """Compute the tilt from which a convex body counts as fallen, for each direction in which the body leans.

    Parameters
    ----------
    hull : ConvexHull
        Convex hull of the body.
    largest_extent : float
        Largest extent of the body, m.
    least_tilt_to_rest_on_another_face_rad : float
        Least tilt at which the body can rest on another face, rad; no smaller tilt counts as a fall.
    resting_face_normals_after_fall : ndarray, shape (faces, 3)
        Outward normals of the other faces on which the body can rest; rest on any of them counts as a fall.
    min_resting_tilt_counted_as_fall_rad : float
        Tilt, rad, below which resting on an edge or face does not count as a fall.
    """
    ends, sides = _hull_edge_vertices_and_triangles(hull)
    found = _lowest_vertex_changes(hull, ends, sides)
    off_base = (
        -hull.outward_triangle_normals[
            _resting_triangle_after_rolling_by_triangle(hull, largest_extent)[found.triangle_index_rolled_towards], 2
        ]
        < 1.0 - FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO
    )
    rests = (
        off_base
        & (
            found.centre_height_derivatives_on_edge_ends.min(axis=1)
            < -FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO * largest_extent
        )
        & (
            found.centre_height_derivatives_on_edge_ends.max(axis=1)
            > FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO * largest_extent
        )
    )
    rests &= found.tilt_at_change_rad >= min_resting_tilt_counted_as_fall_rad
    limits, rows = np.full(LEAN_DIRECTION_COUNT, np.pi), np.zeros((LEAN_DIRECTION_COUNT, 4))
    rows[:, 3] = 1.0  # unreachable limit: there is no edge to rest on
    order = np.flatnonzero(rests)[np.argsort(-found.tilt_at_change_rad[rests], kind="stable")]
    limits[found.lean_direction_index[order]] = found.tilt_at_change_rad[
        order
    ]  # in order of decreasing tilt, so that the least one remains
    along = (
        hull.vertices_from_centre_of_mass[ends[found.index_of_edge_lowest_at_change[order], 1]]
        - hull.vertices_from_centre_of_mass[ends[found.index_of_edge_lowest_at_change[order], 0]]
    )
    along *= np.where(
        found.centre_height_derivatives_on_edge_ends[order, 1] > found.centre_height_derivatives_on_edge_ends[order, 0],
        1.0,
        -1.0,
    )[:, None]
    along /= np.sqrt(np.sum(along * along, axis=1))[:, None]
    rows[found.lean_direction_index[order]] = np.column_stack(
        [along, np.full(order.size, (FALL_TILT_TO_RESTING_TILT_RATIO - 1.0) * least_tilt_to_rest_on_another_face_rad)]
    )
    limits = np.maximum(limits, least_tilt_to_rest_on_another_face_rad)
    if (limits <= least_tilt_to_rest_on_another_face_rad + 1e-9).all():
        return FallTiltByLeanDirection(
            least_tilt_to_rest_on_another_face_rad,
            np.full(LEAN_DIRECTION_COUNT, least_tilt_to_rest_on_another_face_rad),
            np.zeros((0, 5)),
            np.zeros(0, np.int64),
        )
    touched = ends[
        found.index_of_edge_lowest_at_change[
            found.tilt_at_change_rad < limits[found.lean_direction_index] * (1.0 - 1e-6)
        ]
    ]
    _lower_fall_limits_for_resting_faces(limits, rows, resting_face_normals_after_fall)
    starts = _pseudo_angle_in_quarter_turns(2.0 * np.pi * np.arange(LEAN_DIRECTION_COUNT) / LEAN_DIRECTION_COUNT)
    first = np.any(rows != np.roll(rows, 1, axis=0), axis=1)
    first[0] = True
    sectors = np.asarray(np.round(np.column_stack([starts, rows])[first], LEAN_SECTOR_TABLE_DECIMALS), np.float64)
    return FallTiltByLeanDirection(least_tilt_to_rest_on_another_face_rad, limits, sectors, np.unique(touched))


def _lower_fall_limits_for_resting_faces(
    fall_tilt_by_lean_direction_rad: FloatArray,
    vector_and_min_fall_dot_product_by_lean_direction: FloatArray,
    resting_face_normals_after_fall: FloatArray,
) -> None:
    """Lower, in place, the tilts from which a body counts as fallen, so that rest on any of the faces is a fall."""
    for normal in resting_face_normals_after_fall:
        turn, tilt = np.arctan2(normal[1], normal[0]) % (2.0 * np.pi), float(np.arccos(np.clip(-normal[2], -1.0, 1.0)))
        number = min(int(turn / (2.0 * np.pi) * LEAN_DIRECTION_COUNT), LEAN_DIRECTION_COUNT - 1)
        if (
            vector_and_min_fall_dot_product_by_lean_direction[number, :3] @ normal
            < vector_and_min_fall_dot_product_by_lean_direction[number, 3]
        ):
            ahead = np.array([np.cos(tilt) * np.cos(turn), np.cos(tilt) * np.sin(turn), np.sin(tilt)])
            vector_and_min_fall_dot_product_by_lean_direction[number], fall_tilt_by_lean_direction_rad[number] = (
                np.append(ahead, (FALL_TILT_TO_RESTING_TILT_RATIO - 1.0) * tilt),
                tilt,
            )


def _pseudo_angle_in_quarter_turns(angles_rad: FloatArray) -> FloatArray:
    """Return, for each angle (rad), a number from 0 to 4 that increases with it and is computed without arctangent."""
    x, y = np.round(np.cos(angles_rad), 15), np.round(np.sin(angles_rad), 15)
    share = np.abs(x) / (np.abs(x) + np.abs(y))
    return np.asarray(
        np.where(y >= 0, np.where(x >= 0, 1.0 - share, 1.0 + share), np.where(x < 0, 3.0 - share, 3.0 + share))
    )


def _hull_edge_vertices_and_triangles(hull: ConvexHull) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Return the vertex indices and the triangle indices of each hull edge, two arrays of shape (edges, 2)."""
    ends, sides = [], []
    for k in range(3):
        one, other = np.arange(len(hull.triangle_vertex_indices)), hull.triangle_sharing_edge_opposite_each_vertex[:, k]
        once = one < other
        ends.append(hull.triangle_vertex_indices[once][:, [(k + 1) % 3, (k + 2) % 3]])
        sides.append(np.stack([one, other], axis=1)[once])
    return np.concatenate(ends), np.concatenate(sides)


def _lowest_vertex_changes(
    hull: ConvexHull, vertex_indices_by_edge: NDArray[np.int64], triangle_indices_by_edge: NDArray[np.int64]
) -> LowestVertexChangesOnLeaning:
    """Compute, for each direction of lean, the tilts at which the lowest vertex changes.

    At such a tilt, the downward vertical, in the body's axes, crosses the arc between the normals of two neighbouring
    triangles. Both ends of the edge between these triangles are then lowest.
    """
    turn = 2.0 * np.pi * (np.arange(LEAN_DIRECTION_COUNT) + 0.5) / LEAN_DIRECTION_COUNT
    cosine, sine = np.cos(turn), np.sin(turn)
    aside = hull.outward_triangle_normals[:, 1] * cosine[:, None] - hull.outward_triangle_normals[:, 0] * sine[:, None]
    left = aside >= 0.0
    direction, edge = np.nonzero(left[:, triangle_indices_by_edge[:, 0]] != left[:, triangle_indices_by_edge[:, 1]])
    one, other = triangle_indices_by_edge[edge].T
    down = (
        hull.outward_triangle_normals[one] * np.abs(aside[direction, other])[:, None]
        + hull.outward_triangle_normals[other] * np.abs(aside[direction, one])[:, None]
    )
    ahead = down[:, 0] * cosine[direction] + down[:, 1] * sine[direction]
    kept = ahead > 0.0  # otherwise it leans in the opposite direction
    direction, edge, one, other, down, ahead = (values[kept] for values in (direction, edge, one, other, down, ahead))
    tilt = np.arctan2(ahead, -down[:, 2])
    down /= np.sqrt(np.sum(down * down, axis=1))[:, None]
    level, upward = np.cos(tilt), np.sin(tilt)
    path = np.stack([level * cosine[direction], level * sine[direction], upward], axis=1)
    corners = hull.vertices_from_centre_of_mass[vertex_indices_by_edge[edge]]
    rises = np.sum(corners * path[:, None, :], axis=2)
    # The body rolls to the triangle towards which its centre descends.
    height = np.sum(corners[:, 0] * down, axis=1)
    sinks = hull.plane_distances_from_centre[one] < height * np.sum(down * hull.outward_triangle_normals[one], axis=1)
    return LowestVertexChangesOnLeaning(direction, edge, tilt, rises, np.where(sinks, one, other))


def _resting_triangle_after_rolling_by_triangle(hull: ConvexHull, largest_extent: float) -> NDArray[np.int64]:
    """Return, for each triangle of a hull, the triangle on which a body placed on it comes to rest after rolling.

    The body rolls over the edge beyond which the foot of its centre on the triangle's plane lies furthest, and stays
    if the foot lies inside the triangle.
    """
    feet, beyond = hull.outward_triangle_normals * hull.plane_distances_from_centre[:, None], []
    for k in range(3):
        start, end = (hull.vertices_from_centre_of_mass[hull.triangle_vertex_indices[:, (k + n) % 3]] for n in (1, 2))
        outward = np.cross(end - start, hull.outward_triangle_normals)
        length = np.sqrt(np.sum(outward * outward, axis=1))
        beyond.append(np.sum((feet - start) * outward, axis=1) / np.where(length > 0, length, 1.0))
    farthest = np.argmax(beyond, axis=0)
    own = np.arange(len(hull.triangle_vertex_indices))
    onto = np.where(
        np.max(beyond, axis=0) > FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO * largest_extent,
        hull.triangle_sharing_edge_opposite_each_vertex[own, farthest],
        own,
    )
    for _ in range(len(own).bit_length()):  # each pass doubles the number of edges rolled over
        onto = onto[onto]
    return np.asarray(onto)
