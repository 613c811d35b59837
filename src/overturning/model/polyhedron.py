"""Body from the vertices of a convex polyhedron: mass properties, resting faces, vertices that can touch."""

from typing import Final

import numpy as np
import scipy
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.model.rest import FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO, mask_of_resting_faces
from overturning.model.solid import RigidSolid
from overturning.model.surface import mass_properties_inside_surface
from overturning.model.tipping import ConvexHull, fall_tilt_by_lean_direction

DECIMALS_OF_LENGTH_TO_BODY_SIZE_RATIO: Final = 12
"""Decimals to which lengths relative to the body's size are rounded: the last digit differs between processors."""


def solid_from_vertices(vertices: FloatArray) -> RigidSolid:
    """Return the rigid body of a convex polyhedron on its lowest face; see `Polyhedron` for vertices and errors."""
    return solid_from_hull(_hull_of_checked_convex_vertices(vertices))


def solid_from_hull(hull: ConvexHull, min_resting_tilt_counted_as_fall_rad: float = 0.0) -> RigidSolid:
    """Return the rigid body of a convex hull in its given pose, in which it stands on its lowest face.

    Parameters
    ----------
    hull : ConvexHull
        Convex hull about the body's centre of mass, with the body's inertia.
    min_resting_tilt_counted_as_fall_rad : float
        Tilt, rad, below which resting on another face does not count as a fall.

    Raises
    ------
    ArgumentError
        If the body has fewer than three base vertices, its centre lies outside its base, or too many vertices can touch
        the ground.
    """
    size = float(np.ptp(hull.vertices_from_centre_of_mass, axis=0).max())
    bottom = float(hull.vertices_from_centre_of_mass[:, 2].min())
    below = np.flatnonzero(
        hull.vertices_from_centre_of_mass[:, 2] <= bottom + FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO * size
    )
    if below.size < 3:
        raise ArgumentError(
            f"body: it stands on {below.size} vert{'ex' if below.size == 1 else 'ices'}; turn it so that a face lies "
            "on z = const"
        )
    try:
        base = below[scipy.spatial.ConvexHull(hull.vertices_from_centre_of_mass[below, :2]).vertices]  # anticlockwise
    except scipy.spatial.QhullError:
        raise ArgumentError("body: it stands on an edge; turn it so that a face lies on z = const") from None
    tilt, faces = _least_resting_tilt_on_other_faces_and_normals(hull, size, min_resting_tilt_counted_as_fall_rad)
    fall = fall_tilt_by_lean_direction(hull, size, tilt, faces, min_resting_tilt_counted_as_fall_rad)
    kept = np.concatenate(
        [
            base,
            np.setdiff1d(
                np.append(
                    _indices_of_vertices_that_can_touch_ground(hull, tilt), fall.touchable_vertex_indices_until_fall
                ),
                below,
            ),
        ]
    )
    points = np.round(hull.vertices_from_centre_of_mass[kept] / size, DECIMALS_OF_LENGTH_TO_BODY_SIZE_RATIO) * size
    points[: base.size, 2] = np.round(bottom / size, DECIMALS_OF_LENGTH_TO_BODY_SIZE_RATIO) * size
    inertia = np.round(hull.inertia_per_mass / size**2, DECIMALS_OF_LENGTH_TO_BODY_SIZE_RATIO) * size**2
    normals = np.unique(
        np.round(
            hull.outward_triangle_normals[
                -hull.outward_triangle_normals[:, 2]
                > np.cos(fall.fall_tilt_towards_faces_rad(hull.outward_triangle_normals))
                - FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO
            ],
            5,
        ),
        axis=0,
    )
    heights = hull.vertices_from_centre_of_mass[kept] @ normals.T
    facets = [np.flatnonzero(column > column.max() - 1e-4 * size) for column in heights.T]
    return RigidSolid(
        points,
        base.size,
        inertia,
        tilt,
        faces,
        point_indices_by_non_base_contact_face=tuple(facets),
        lean_sector_start_vector_and_min_fall_dot_product=fall.lean_sector_start_vector_and_min_fall_dot_product,
    )


def _hull_of_checked_convex_vertices(vertices: FloatArray) -> ConvexHull:
    """Return the convex hull of vertices about their centre of mass; raise an ArgumentError if they are not convex."""
    if vertices.ndim != 2 or vertices.shape[1] != 3 or len(vertices) < 4 or not np.isfinite(vertices).all():
        raise ArgumentError(f"body: vertices of shape {vertices.shape}; give at least 4 finite points [x, y, z]")
    size = float(np.ptp(vertices, axis=0).max())
    try:
        hull = scipy.spatial.ConvexHull(vertices)
    except scipy.spatial.QhullError:
        raise ArgumentError("body: its vertices lie in one plane, so it has no volume") from None
    if not hull.volume > FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO * size**3:
        raise ArgumentError(
            f"body: a volume of {hull.volume:.3g} m³ in a size of {size:.3g} m; its vertices lie in one plane"
        )
    inside = -(vertices @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)
    if inside.max() > FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO * size:
        raise ArgumentError(
            f"body: not convex; vertex {inside.argmax()} lies {inside.max():.3g} m inside the hull of the others: "
            "leave it out"
        )
    return hull_with_origin_at_centre_of_mass(vertices, hull)


def hull_with_origin_at_centre_of_mass(
    vertices: FloatArray,
    hull: "scipy.spatial.ConvexHull",
    centre_of_mass_and_inertia_per_mass: tuple[FloatArray, FloatArray] | None = None,
) -> ConvexHull:
    """Return a convex hull with vertices, shape (n, 3), m, relative to the centre of mass of the body.

    The centre (3,), m, and the inertia per mass (3, 3), m², are computed from the hull's volume if they are not given.
    """
    # Qhull does not order the vertices of a triangle; make all anticlockwise seen from outside.
    corners = vertices[hull.simplices]
    outward = np.sum(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) * hull.equations[:, :3], axis=1
    )
    simplices, neighbours = hull.simplices.astype(np.int64), hull.neighbors.astype(np.int64)
    turned = outward < 0
    simplices[turned], neighbours[turned] = simplices[turned][:, [0, 2, 1]], neighbours[turned][:, [0, 2, 1]]
    if centre_of_mass_and_inertia_per_mass is None:
        centre_of_mass_and_inertia_per_mass = mass_properties_inside_surface(vertices[simplices])[1:]
    centre, inertia = centre_of_mass_and_inertia_per_mass
    normals = hull.equations[:, :3]
    return ConvexHull(
        vertices - centre, simplices, neighbours, normals, -hull.equations[:, 3] - normals @ centre, inertia
    )


def _least_resting_tilt_on_other_faces_and_normals(
    hull: ConvexHull, largest_extent: float, min_resting_tilt_counted_as_fall_rad: float
) -> tuple[float, FloatArray]:
    """Return the least tilt (rad) at which a body can rest on a face other than base and top; normals of such faces.

    Faces on which the body rests at a tilt below `min_resting_tilt_counted_as_fall_rad`, rad, are left out. Without any
    face the tilt is π.
    """
    _, first = np.unique(np.round(hull.outward_triangle_normals, 5), axis=0, return_index=True)
    normals, offsets = hull.outward_triangle_normals[first], hull.plane_distances_from_centre[first]
    down = -normals[:, 2]
    # Exclude the base and a face opposite to it: a body falls onto a side first.
    stable = mask_of_resting_faces(normals, offsets, largest_extent) & (
        np.abs(down) < 1.0 - FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO
    )
    stable &= down <= np.cos(min_resting_tilt_counted_as_fall_rad)
    if not stable.any():
        return np.pi, np.zeros((0, 3))
    tilt = float(np.round(np.arccos(np.clip(down[stable].max(), -1.0, 1.0)), DECIMALS_OF_LENGTH_TO_BODY_SIZE_RATIO))
    # Triangles of a face are not exactly coplanar if the file rounds its vertices: see `mask_of_resting_faces`.
    faces = normals[stable]
    faces = faces[~np.tril(faces @ faces.T > 1.0 - FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO, -1).any(axis=1)]
    # Rounded: otherwise a face along x, up to the last digit, could come last instead of first.
    turn = np.round(-np.arctan2(faces[:, 1], faces[:, 0]), 9) % (2.0 * np.pi)
    return tilt, np.round(faces[np.argsort(turn, kind="stable")], DECIMALS_OF_LENGTH_TO_BODY_SIZE_RATIO)


def _indices_of_vertices_that_can_touch_ground(hull: ConvexHull, max_tilt_rad: float) -> NDArray[np.int64]:
    """Return the indices of the vertices that become the body's lowest point at a tilt below `max_tilt_rad`, rad.

    A vertex is lowest while the downward vertical, in the body's axes, lies in the spherical polygon of the normals of
    the triangles at the vertex. The sides of this polygon are arcs between normals of neighbouring triangles. So a
    vertex becomes lowest if one of its arcs comes nearer to −z than the tilt.
    """
    n1 = hull.outward_triangle_normals[:, None, :].repeat(3, axis=1).reshape(-1, 3)
    n2 = hull.outward_triangle_normals[hull.triangle_sharing_edge_opposite_each_vertex].reshape(-1, 3)
    nearest = _max_cosine_to_straight_down_on_arcs(n1, n2).reshape(-1, 3)
    reached = nearest > np.cos(max_tilt_rad) + 1e-9  # vertices that only touch after the fall are not needed
    vertices = []
    for k in range(3):  # the edge opposite to vertex k
        pair = hull.triangle_vertex_indices[:, [(k + 1) % 3, (k + 2) % 3]]
        vertices.append(pair[reached[:, k]].ravel())
    return np.unique(np.concatenate(vertices))


def _max_cosine_to_straight_down_on_arcs(
    unit_normals_at_first_arc_ends: FloatArray, unit_normals_at_second_arc_ends: FloatArray
) -> FloatArray:
    """Return, for each great-circle arc between two unit normals, the cosine of its least angle to straight down."""
    ends = np.maximum(-unit_normals_at_first_arc_ends[:, 2], -unit_normals_at_second_arc_ends[:, 2])
    axis = np.cross(unit_normals_at_first_arc_ends, unit_normals_at_second_arc_ends)
    length = np.sqrt(np.sum(axis * axis, axis=1))
    arc = length > 1e-9
    axis = axis / np.where(arc, length, 1.0)[:, None]
    # Point of the great circle nearest to down; it counts only if it lies between the ends of the arc.
    point = np.array([0.0, 0.0, -1.0]) + axis[:, 2:] * axis
    norm = np.sqrt(np.sum(point * point, axis=1))
    point = point / np.where(norm > 1e-12, norm, 1.0)[:, None]
    between = (np.sum(np.cross(unit_normals_at_first_arc_ends, point) * axis, axis=1) >= 0) & (
        np.sum(np.cross(point, unit_normals_at_second_arc_ends) * axis, axis=1) >= 0
    )
    return np.where(arc & between, norm, ends)


def convex_vertices_from_mass_centre_and_edges(vertices: FloatArray) -> tuple[FloatArray, NDArray[np.int64]]:
    """Return a convex body's vertices relative to the centre of mass, m, and its edges as pairs of vertex indices."""
    hull = _hull_of_checked_convex_vertices(vertices)
    edges = set()
    for triangle, neighbours, normal in zip(
        hull.triangle_vertex_indices,
        hull.triangle_sharing_edge_opposite_each_vertex,
        hull.outward_triangle_normals,
        strict=True,
    ):
        for k, other in enumerate(neighbours):
            if hull.outward_triangle_normals[other] @ normal < 1.0 - FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO:
                edges.add(tuple(sorted((int(triangle[(k + 1) % 3]), int(triangle[(k + 2) % 3])))))
    return hull.vertices_from_centre_of_mass, np.array(sorted(edges), np.int64)
