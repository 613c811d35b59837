"""Closed triangle surface of a body: open edges, a lid on an open base, volume, centre of mass, inertia."""

import itertools
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError

MAX_OPEN_BASE_RIM_DEVIATION_TO_SIZE_RATIO: Final = 0.01
"""Largest distance of the rim of an open base from its plane, as a share of the body's size."""

MIN_COSINE_OF_OPEN_BASE_INCLINATION: Final = np.cos(np.radians(45.0))
"""Least cosine of the angle between the plane of an open base and the horizontal."""

MAX_OPEN_EDGES_IN_MESSAGE: Final = 3
"""Largest number of open edges that an error message lists."""

MAX_ANGLE_OF_OVERLAPPING_FACES_AT_EDGE_RAD: Final = 1e-6
"""Angle between two faces below which they coincide, rad; coordinates in single precision are rounded to 10⁻⁷."""


class TriangleSurface(NamedTuple):
    """Surface of a body as triangles: vertex positions, and the three vertices of each triangle."""

    vertices: FloatArray
    """Positions, shape (n, 3), m, z up."""
    triangles: NDArray[np.int64]
    """Vertex indices, shape (m, 3), anticlockwise from outside."""

    @property
    def triangle_corners(self) -> FloatArray:
        """Positions of the corners of each triangle, shape (m, 3, 3), m."""
        return self.vertices[self.triangles]


class MassProperties(NamedTuple):
    """Volume, centre of mass and inertia per mass of a homogeneous body."""

    signed_volume: float
    """Volume, m³; negative if the triangles are clockwise from outside."""
    centre_of_mass: FloatArray
    """Centre of mass, shape (3,), m."""
    inertia_per_mass: FloatArray
    """Moments and negative products of inertia about the centre per mass, shape (3, 3), m²."""


def _six_times_signed_volumes(triangle_corners: FloatArray) -> FloatArray:
    """Return six times the signed volume (m³) of each tetrahedron between a triangle, shape (m, 3, 3), and the origin.

    The volume is negative if the triangle faces the origin.
    """
    return np.asarray(np.sum(np.cross(triangle_corners[:, 0], triangle_corners[:, 1]) * triangle_corners[:, 2], axis=1))


def mass_properties_inside_surface(triangle_corners: FloatArray) -> MassProperties:
    """Compute the mass properties of the body inside a closed surface, from its triangles, shape (m, 3, 3), m.

    Each triangle forms a tetrahedron with a common origin; its volume is negative if the triangle faces the origin.
    """
    origin = triangle_corners.reshape(-1, 3).mean(axis=0)
    a, b, c = (triangle_corners[:, k] - origin for k in range(3))
    volume = _six_times_signed_volumes(triangle_corners - origin)
    total = volume.sum()
    mean = (volume[:, None] * (a + b + c)).sum(axis=0) / (4.0 * total)
    second = np.zeros((3, 3))
    for i in range(3):
        for k in range(3):
            of = (a[:, i] + b[:, i] + c[:, i]) * (a[:, k] + b[:, k] + c[:, k]) + a[:, i] * a[:, k] + b[:, i] * b[:, k]
            second[i, k] = np.sum(volume * (of + c[:, i] * c[:, k])) / (20.0 * total)
    second -= np.outer(mean, mean)
    return MassProperties(float(total) / 6.0, origin + mean, np.trace(second) * np.eye(3) - second)


def open_edges(triangle_vertex_indices: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the directed edges, shape (n, 2), at which a triangle surface is open: no triangle has the reverse edge.

    An edge of four triangles, two in each direction, is closed: the surface touches itself there.
    """
    edges = np.concatenate([triangle_vertex_indices[:, [k, (k + 1) % 3]] for k in range(3)])
    number = int(triangle_vertex_indices.max(initial=0)) + 1
    forward, reverse = edges[:, 0] * number + edges[:, 1], edges[:, 1] * number + edges[:, 0]
    codes, counts = np.unique(forward, return_counts=True)
    place = np.minimum(np.searchsorted(codes, reverse), codes.size - 1)
    count, of_reverse = counts[np.searchsorted(codes, forward)], np.where(codes[place] == reverse, counts[place], 0)
    return edges[count > of_reverse]


def repair_surface_and_close_base(surface: TriangleSurface) -> tuple[TriangleSurface, list[str]]:
    """Return a surface with its open base closed and its triangles facing outwards, and a note on each change made.

    Raises
    ------
    ArgumentError
        If the surface has other holes, encloses no volume or bounds several separate bodies, or if neighbouring
        triangles face opposite sides.
    """
    if not len(surface.triangles):
        raise ArgumentError("body: points without faces enclose no volume; make a closed mesh of them")
    surface, repeated = _remove_repeated_triangles(surface)
    notes = [f"triangles that are listed more than once are used once; {repeated} left out"] if repeated else []
    edges = open_edges(surface.triangles)
    if len(edges):
        surface, deviation = _close_base_and_measure_rim_flatness(surface, edges)
        notes.append(
            f"the open base is closed by a flat lid; its {len(edges)} open edges lie within {1000 * deviation:.2g} mm "
            "of a plane"
        )
    size = float(np.ptp(surface.vertices, axis=0).max())
    corners = surface.triangle_corners - surface.triangle_corners.reshape(-1, 3).mean(axis=0)
    volume = float(np.sum(_six_times_signed_volumes(corners))) / 6.0
    if not abs(volume) > 1e-6 * size**3:
        raise ArgumentError(
            f"body: a volume of {volume:.3g} m³ in a size of {size:.3g} m; it is flat, or its parts cancel"
        )
    if volume < 0.0:
        notes.append("the faces were listed clockwise from outside; they are turned")
        surface = surface._replace(triangles=np.ascontiguousarray(surface.triangles[:, ::-1]))
    _check_surface_has_one_body(surface)
    return surface, notes


def _remove_repeated_triangles(surface: TriangleSurface) -> tuple[TriangleSurface, int]:
    """Return a surface without repeated triangles (same corners in the same sense), and the number of removed ones."""
    first = surface.triangles.argmin(axis=1)[:, None]
    turned = np.take_along_axis(surface.triangles, (first + np.arange(3)) % 3, axis=1)
    _, kept = np.unique(turned, axis=0, return_index=True)
    repeated = len(turned) - kept.size
    return (surface._replace(triangles=surface.triangles[np.sort(kept)]) if repeated else surface), repeated


def _check_surface_has_one_body(surface: TriangleSurface) -> None:
    """Raise an ArgumentError if a closed surface has several parts, other than cavities inside one of them."""
    part = _connected_part_of_each_triangle(surface)
    corners = surface.triangle_corners - surface.triangle_corners.reshape(-1, 3).mean(axis=0)
    volumes = np.bincount(part, _six_times_signed_volumes(corners)) / 6.0
    body = corners[part == volumes.argmax()]
    # A part of no volume, such as a double face, adds no mass; four parts are enough for a message.
    solid = (number for number in np.argsort(-volumes) if abs(volumes[number]) > 1e-9 * volumes.max())
    outside = (
        n
        for n in solid
        if volumes[n] > 0.0 or not _are_outermost_points_inside_body(body, corners[part == n].reshape(-1, 3))
    )
    separate = [volumes[number] for number in itertools.islice(outside, 4)]
    if len(separate) > 1:
        sizes = ", ".join(f"{one:.3g}" for one in np.sort(np.abs(separate))[::-1][:3]) + ", …" * (len(separate) > 3)
        number_text = f"{len(separate)}{' or more' * (len(separate) > 3)}"
        raise ArgumentError(
            f"body: the mesh has {number_text} separate parts ({sizes} m³), and a stone is one rigid body; keep one "
            "part, or join parts that touch or overlap in a mesh program"
        )


def _are_outermost_points_inside_body(body_triangle_corners: FloatArray, points: FloatArray) -> bool:
    """True if points, shape (n, 3), lie inside a body given by its triangles, as far as the outermost ones tell.

    Tested are the points farthest in each of 26 directions.
    """
    directions = [one for one in itertools.product((-1, 0, 1), repeat=3) if any(one)]
    outermost = points[np.unique((points @ np.transpose(directions)).argmax(axis=0))]
    return all(_winding_number(body_triangle_corners, point) > 0.5 for point in outermost)


def _winding_number(triangle_corners: FloatArray, point: FloatArray) -> float:
    """Return how often a closed surface encloses a point: 1 inside, 0 outside.

    The number is the sum of the solid angles of the triangles, shape (m, 3, 3), seen from the point, over 4π (van
    Oosterom & Strackee 1983, IEEE Transactions on Biomedical Engineering 30, 125).
    """
    corners = triangle_corners - point
    a, b, c = (corners[:, k] for k in range(3))
    ra, rb, rc = (np.sqrt(np.sum(one * one, axis=1)) for one in (a, b, c))
    along = ra * rb * rc + np.sum(a * b, axis=1) * rc + np.sum(b * c, axis=1) * ra + np.sum(c * a, axis=1) * rb
    return float(np.arctan2(_six_times_signed_volumes(corners), along).sum() / (2.0 * np.pi))


def _connected_part_of_each_triangle(surface: TriangleSurface) -> NDArray[np.int64]:
    """Return, for each triangle of a surface, the number of the connected part to which it belongs.

    Triangles with a common edge are connected. Solids that share a corner, an edge or a face are separate parts: at an
    edge of more than two triangles, two are connected only if the same solid lies between them.
    """
    import scipy.sparse  # the steps of a run without a scan do not need it

    count, triangles = len(surface.vertices), surface.triangles
    edges = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    owner = np.tile(np.arange(len(triangles)), 3)
    code = edges.min(axis=1) * count + edges.max(axis=1)
    order = np.argsort(code, kind="stable")
    starts = np.flatnonzero(np.diff(code[order], prepend=-1))
    sizes = np.diff(starts, append=code.size)
    first = starts[sizes == 2]
    links = [np.column_stack([owner[order[first]], owner[order[first + 1]]])]
    for start, size in zip(starts[sizes > 2], sizes[sizes > 2], strict=True):
        around = order[start : start + size]
        links.append(_triangle_pairs_of_same_solid_at_edge(surface, edges[around], owner[around]))
    pairs = np.concatenate(links)
    shape = (len(triangles), len(triangles))
    graph = scipy.sparse.coo_array((np.ones(len(pairs), bool), (pairs[:, 0], pairs[:, 1])), shape=shape)
    return np.asarray(scipy.sparse.csgraph.connected_components(graph, directed=False)[1], np.int64)


def _triangle_pairs_of_same_solid_at_edge(
    surface: TriangleSurface,
    edge_vertex_pair_by_triangle: NDArray[np.int64],
    triangle_indices_at_edge: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Return the pairs of triangles, shape (n, 2), that bound the same solid at an edge of more than two triangles.

    Parameters
    ----------
    surface : TriangleSurface
        Surface whose triangles are anticlockwise from outside.
    edge_vertex_pair_by_triangle : ndarray, shape (k, 2)
        The edge as a vertex pair, in the order in which each triangle runs along it.
    triangle_indices_at_edge : ndarray, shape (k,)
        Indices of the triangles at the edge.
    """
    begin, end = np.sort(edge_vertex_pair_by_triangle[0])
    third = surface.triangles[triangle_indices_at_edge].sum(axis=1) - begin - end
    axis = surface.vertices[end] - surface.vertices[begin]
    axis = axis / np.sqrt(axis @ axis)
    arm = surface.vertices[third] - surface.vertices[begin]
    across = arm[0] - (arm[0] @ axis) * axis
    angle = np.arctan2(arm @ np.cross(axis, across), arm @ across)
    with_axis = edge_vertex_pair_by_triangle[:, 0] == begin
    pairs = []
    for one in np.flatnonzero(with_axis):
        # The solid lies clockwise of a triangle that has the edge in the sense of the axis.
        turn = (angle[one] - angle[~with_axis] - MAX_ANGLE_OF_OVERLAPPING_FACES_AT_EDGE_RAD) % (2.0 * np.pi)
        if turn.size:
            pairs.append((triangle_indices_at_edge[one], triangle_indices_at_edge[~with_axis][turn.argmin()]))
    return np.array(pairs, np.int64).reshape(-1, 2)


def _close_base_and_measure_rim_flatness(
    surface: TriangleSurface, directed_open_edges: NDArray[np.int64]
) -> tuple[TriangleSurface, float]:
    """Close the open base of a surface with a fan of triangles; also return how far (m) its rim deviates from a plane.

    The triangles join each edge of the rim to the mean of the rim. They overlap if the rim is not convex or there are
    several rims; volume and moments are still right, because overlaps in one plane cancel.
    """
    rim, points = surface.vertices[directed_open_edges], surface.vertices
    size = float(np.ptp(points, axis=0).max())
    centre = rim.reshape(-1, 3).mean(axis=0)
    area = 0.5 * np.cross(rim[:, 1] - centre, rim[:, 0] - centre).sum(axis=0)
    length = float(np.sqrt(area @ area))
    normal = area / length if length > 0.0 else np.zeros(3)
    deviation = float(np.abs((rim - centre) @ normal).max()) if length > 0.0 else np.inf
    below = np.abs(normal[2]) >= MIN_COSINE_OF_OPEN_BASE_INCLINATION and _plane_is_below_points(
        points, centre, normal, MAX_OPEN_BASE_RIM_DEVIATION_TO_SIZE_RATIO * size
    )
    # An edge twice without its reverse belongs to a face of the wrong sense.
    single = len(np.unique(directed_open_edges, axis=0)) == len(directed_open_edges)
    if not (deviation <= MAX_OPEN_BASE_RIM_DEVIATION_TO_SIZE_RATIO * size and below and single):
        first = ", ".join(
            f"{one.round(4).tolist()} to {other.round(4).tolist()}" for one, other in rim[:MAX_OPEN_EDGES_IN_MESSAGE]
        )
        more = f" and {len(rim) - MAX_OPEN_EDGES_IN_MESSAGE} more" if len(rim) > MAX_OPEN_EDGES_IN_MESSAGE else ""
        raise ArgumentError(
            f"body: not closed at {len(rim)} edges, so its volume is undefined: {first}{more} (m); fill the holes and "
            "make all faces point outwards (only an open base in one plane, inclined by at most 45°, is closed here)"
        )
    vertices = np.concatenate([points, centre[None]])
    lid = np.column_stack(
        [directed_open_edges[:, 1], directed_open_edges[:, 0], np.full(len(directed_open_edges), len(points))]
    )
    return TriangleSurface(vertices, np.concatenate([surface.triangles, lid])), deviation


def _plane_is_below_points(
    points: FloatArray, point_in_plane: FloatArray, plane_normal: FloatArray, max_depth_below_plane: float
) -> bool:
    """True if no point is below a plane by more than a length (m); the normal of the plane may point down."""
    upward = plane_normal * np.sign(plane_normal[2])
    return bool(((points - point_in_plane) @ upward).min() >= -max_depth_below_plane)
