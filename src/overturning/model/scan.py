"""Scanned stone: its mass from the true volume, its contact from the footprint, and its stable pose.

The mesh of a scan need not be convex. Only its convex hull can touch a flat ground. The real ground and the real base
are rough: all points of the base that are higher than its lowest points by less than a *relief* bear, too. Their
convex outline is the *footprint*.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar, Final, NamedTuple, Self

import numpy as np
import scipy
from typing_extensions import override

from overturning.arrays import ArrayLike, FloatArray, convert_argument_to_finite_array
from overturning.errors import ArgumentError
from overturning.model.cases import check_stone_heights_within_allowed_range
from overturning.model.outline import simplified_convex_hull_vertices
from overturning.model.polyhedron import hull_with_origin_at_centre_of_mass, solid_from_hull
from overturning.model.rest import FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO, mask_of_resting_faces
from overturning.model.shapes import CornersAndEdges, Polyhedron, Shape
from overturning.model.solid import MAX_CONTACT_VERTICES, RigidSolid, TooManyContactVerticesError
from overturning.model.surface import MassProperties, TriangleSurface, mass_properties_inside_surface

DEFAULT_LOAD_BEARING_BASE_RELIEF_M: Final = 0.002
"""Default relief, m: height above the lowest point of a scanned base up to which its points bear load."""

MAX_LOAD_BEARING_BASE_RELIEF_M: Final = 0.03
"""Largest relief (see `DEFAULT_LOAD_BEARING_BASE_RELIEF_M`), m; more would raise a small stone visibly."""

FOOTPRINT_TOLERANCE_TO_BODY_SIZE_RATIO: Final = 1e-3
"""Largest distance by which a simplified footprint is smaller, as a share of the body's size."""

HULL_TOLERANCE_TO_BODY_SIZE_RATIO: Final = 0.002
"""Distance by which the hull above the footprint is simplified, as a share of the size; doubled for too many points."""

MIN_RESTING_TILT_COUNTED_AS_FALLEN_RAD: Final = np.radians(10.0)
"""Tilt below which a scanned stone that rests on another part of its base has not fallen, rad."""

MAX_HULL_VOLUME_EXCESS_RATIO_OF_CONVEX_BODY: Final = 1e-3
"""Largest share of the hull's volume outside a body that counts as convex: rounding in the file."""

MAX_HULL_VERTICES_STORED_UNREDUCED: Final = 3000
"""Largest number of vertices of a hull that are stored as they are; a multiple of 10."""

STORED_POSITION_DECIMALS_OF_METRE: Final = 6
"""Decimals of stored positions, m: a micrometre."""


class RotationToStablePose(NamedTuple):
    """Rotation of a scanned stone to the nearest pose in which it can stand."""

    rotation_matrix_from_scan_axes: FloatArray
    """Rotation matrix from the axes of the scan, shape (3, 3)."""
    scan_tilt_from_stable_pose_deg: float
    """Angle between the vertical of the scan and that of the pose, degrees."""
    scan_tilt_direction_ccw_from_x_deg: float
    """Direction in which the top of the scan is tilted, degrees anticlockwise from the x axis of the scan."""


@dataclass(frozen=True, eq=False)
class ScannedStone(Shape):
    """Scanned stone with a convex outline for contact and the scan's mass properties, standing on its footprint.

    Parameters
    ----------
    vertices : array_like, shape (n, 3)
        Points that can touch a flat ground in the stable pose, m: z up, x along the azimuth of the orientation.
    centre_of_mass : array_like, shape (3,)
        Centre of mass of the whole volume in the same axes, m.
    inertia_moments_and_products_per_mass : array_like, shape (6,)
        Moments of inertia about the centre per mass, xx, yy, zz, and products xy, xz, yz (integrals of xy, …), m².
    max_load_bearing_base_point_height_m : float
        Relief: height above the lowest point up to which points bear load, m. Their convex outline is the footprint.
    name : str
        Name in datasets.
    hull_tolerance_to_size_ratio : float
        Tolerance with which the outline above the footprint is simplified, as a share of the stone's size; doubled
        while too many vertices can touch the ground.

    Raises
    ------
    ArgumentError
        If the stone cannot stand, its height or relief is out of range, or its mass properties are impossible.
    """

    vertices: ArrayLike
    centre_of_mass: ArrayLike
    inertia_moments_and_products_per_mass: ArrayLike
    max_load_bearing_base_point_height_m: float = DEFAULT_LOAD_BEARING_BASE_RELIEF_M
    name: str = "scan"
    hull_tolerance_to_size_ratio: float = HULL_TOLERANCE_TO_BODY_SIZE_RATIO
    slenderness_is_parameter: ClassVar[bool] = False

    def __post_init__(self) -> None:
        for name, shape in (
            ("vertices", (-1, 3)),
            ("centre_of_mass", (3,)),
            ("inertia_moments_and_products_per_mass", (6,)),
        ):
            object.__setattr__(self, name, convert_argument_to_finite_array(name, getattr(self, name), shape))
        if not 0.0 <= self.max_load_bearing_base_point_height_m <= MAX_LOAD_BEARING_BASE_RELIEF_M:
            raise ArgumentError(
                f"relief: {self.max_load_bearing_base_point_height_m:g} m; it must be from 0 to "
                f"{MAX_LOAD_BEARING_BASE_RELIEF_M:g} m"
            )
        moments = np.linalg.eigvalsh(self.inertia_matrix_per_mass)
        if not (moments[0] > 0.0 and moments[0] + moments[1] >= moments[2] * (1.0 - 1e-6)):
            raise ArgumentError(f"inertia: principal moments {moments.round(9).tolist()} m²; no body has these")
        heights, centre = np.asarray(self.vertices)[:, 2], float(np.asarray(self.centre_of_mass)[2])
        if not heights.min() < centre < heights.max():
            raise ArgumentError(
                f"centre_of_mass: {centre:g} m high; it must lie between the lowest and the highest vertex, "
                f"{heights.min():g} and {heights.max():g} m"
            )
        _ = self.unscaled_solid  # raises the errors

    @property
    def inertia_matrix_per_mass(self) -> FloatArray:
        """Moments and negative products of inertia about the centre of mass per mass, shape (3, 3), m²."""
        xx, yy, zz, xy, xz, yz = np.asarray(self.inertia_moments_and_products_per_mass).tolist()
        return np.array([[xx, -xy, -xz], [-xy, yy, -yz], [-xz, -yz, zz]])

    @property
    def unscaled_height(self) -> float:
        """Height of the stone as scanned, m."""
        return float(np.ptp(np.asarray(self.vertices)[:, 2]))

    @cached_property
    def footprint_corners_from_centre_of_mass(self) -> FloatArray:
        """Corners of the footprint relative to the foot of the centre of mass, anticlockwise, shape (n, 2), m."""
        solid = self.unscaled_solid
        return solid.contact_points_from_centre_of_mass[: solid.base_vertex_count, :2]

    @cached_property
    def possible_ground_contact_points(self) -> FloatArray:
        """Points of the stone that can touch the ground, with the footprint in one plane, shape (n, 3), m."""
        return _flatten_footprint_at_lowest_level(np.asarray(self.vertices), self.max_load_bearing_base_point_height_m)

    @cached_property
    def unscaled_solid(self) -> RigidSolid:
        """Rigid body of the stone as scanned."""
        check_stone_heights_within_allowed_range(self.unscaled_height)
        properties = np.asarray(self.centre_of_mass), self.inertia_matrix_per_mass
        size = float(np.ptp(np.asarray(self.vertices), axis=0).max())
        base = np.flatnonzero(
            self.possible_ground_contact_points[:, 2] == self.possible_ground_contact_points[:, 2].min()
        )
        tolerance = self.hull_tolerance_to_size_ratio * size
        while True:
            points = simplified_convex_hull_vertices(self.possible_ground_contact_points, tolerance, base)
            hull = hull_with_origin_at_centre_of_mass(points, scipy.spatial.ConvexHull(points), properties)
            try:
                return solid_from_hull(hull, MIN_RESTING_TILT_COUNTED_AS_FALLEN_RAD)
            except TooManyContactVerticesError:
                if tolerance > 0.1 * size:
                    raise
                tolerance *= 2.0

    def with_base_relief(self, max_load_bearing_base_point_height_m: float) -> Self:
        """Return a copy with another relief: height (m) above the lowest point up to which points bear load."""
        known: dict[float, Self] = self.__dict__.setdefault(
            "_of_relief", {self.max_load_bearing_base_point_height_m: self}
        )
        if max_load_bearing_base_point_height_m not in known:
            known[max_load_bearing_base_point_height_m] = replace(
                self, max_load_bearing_base_point_height_m=max_load_bearing_base_point_height_m
            )
        return known[max_load_bearing_base_point_height_m]

    @override
    def solid(self, height: float, b_over_h: float, depth_over_width: float) -> RigidSolid:
        return self.unscaled_solid.scaled_by(height / self.unscaled_height)

    @override
    def drawn_corners_and_edges(self, height: float, b_over_h: float, depth_over_width: float) -> CornersAndEdges:
        points = simplified_convex_hull_vertices(self.possible_ground_contact_points, 0.004 * self.unscaled_height)
        hull = scipy.spatial.ConvexHull(points)
        edges = np.unique(np.sort(np.concatenate([hull.simplices[:, [k, (k + 1) % 3]] for k in range(3)])), axis=0)
        return (points - np.asarray(self.centre_of_mass)) * (height / self.unscaled_height), edges.astype(np.int64)


def _flatten_footprint_at_lowest_level(points: FloatArray, max_load_bearing_base_point_height_m: float) -> FloatArray:
    """Replace the load-bearing points of a base by the corners of their convex outline, at the lowest level.

    Load-bearing points are at most `max_load_bearing_base_point_height_m` above the lowest one. The result, shape
    (n, 3), m, has these corners first, then all higher points.
    """
    size = float(np.ptp(points, axis=0).max())
    bottom = float(points[:, 2].min())
    low = points[:, 2] <= bottom + max(
        max_load_bearing_base_point_height_m, FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO * size
    )
    try:
        outline = simplified_convex_hull_vertices(points[low, :2], FOOTPRINT_TOLERANCE_TO_BODY_SIZE_RATIO * size)
    except (scipy.spatial.QhullError, ValueError):
        raise ArgumentError(
            f"body: fewer than three points, or points on one line, bear within a relief of "
            f"{1000 * max_load_bearing_base_point_height_m:g} mm; give a larger relief"
        ) from None
    return np.concatenate([np.column_stack([outline, np.full(len(outline), bottom)]), points[~low]])


def nearest_stable_pose(points: FloatArray, centre_of_mass: FloatArray) -> RotationToStablePose:
    """Return the rotation of a body to the nearest pose in which it is stable on flat ground.

    The body can rest on a face of its hull if the foot of its centre of mass lies on that face (see
    `overturning.model.rest.mask_of_resting_faces`). Of these faces, the one that needs the least tilt is taken. Points
    (n, 3) and centre (3,) are in m, z up.

    Raises
    ------
    ArgumentError
        If all points lie in one plane.
    """
    try:
        hull = scipy.spatial.ConvexHull(points)
    except scipy.spatial.QhullError:
        raise ArgumentError("body: its vertices lie in one plane, so it has no volume") from None
    normals = hull.equations[:, :3]
    offsets = -hull.equations[:, 3] - normals @ centre_of_mass
    size = float(np.ptp(points, axis=0).max())
    for index in np.argsort(normals[:, 2], kind="stable"):
        if mask_of_resting_faces(normals, offsets, size, slice(index, index + 1))[0]:
            return _pose_with_face_down(normals[index])
    return _pose_with_face_down(normals[offsets.argmin()])  # the face with the lowest centre of mass is always stable


def _pose_with_face_down(outward_face_normal: FloatArray) -> RotationToStablePose:
    """Return the smallest rotation that makes an outward face normal, shape (3,), of a body point down."""
    outward_face_normal = outward_face_normal / np.sqrt(outward_face_normal @ outward_face_normal)
    axis, cosine = np.cross(outward_face_normal, [0.0, 0.0, -1.0]), float(-outward_face_normal[2])
    sine = float(np.sqrt(axis @ axis))
    # A tilt below rounding leaves the scan as it is, so that a mesh that stands on a face keeps its coordinates.
    if cosine > 0.0 and sine < 1e-9:
        return RotationToStablePose(np.eye(3), 0.0, 0.0)
    if sine == 0.0:
        axis, sine = np.array([1.0, 0.0, 0.0]), 0.0
    else:
        axis = axis / sine
    x, y, z = axis
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation = np.eye(3) + sine * skew + (1.0 - cosine) * skew @ skew
    top = rotation[:2, 2]
    return RotationToStablePose(
        rotation, float(np.degrees(np.arctan2(sine, cosine))), float(np.degrees(np.arctan2(top[1], top[0])))
    )


def points_that_can_touch_ground(points: FloatArray) -> FloatArray:
    """Return points of a body that can touch the ground, shape (n, 3): hull vertices and low load-bearing points.

    Of more than `MAX_HULL_VERTICES_STORED_UNREDUCED` hull vertices, only those that are extreme in one of as many
    directions are returned. The low points are less than `MAX_LOAD_BEARING_BASE_RELIEF_M` above the lowest point, and
    lie, seen from above, outside the convex outline of all lower ones.
    """
    size = float(np.ptp(points, axis=0).max())
    hull = scipy.spatial.ConvexHull(points)
    low = np.flatnonzero(points[:, 2] <= points[:, 2].min() + MAX_LOAD_BEARING_BASE_RELIEF_M)
    low = low[np.argsort(points[low, 2], kind="stable")]
    chosen, outline = [], np.zeros((0, 3))
    for index in low:
        if (
            len(outline)
            and (outline[:, :2] @ points[index, :2] + outline[:, 2]).max()
            <= FOOTPRINT_TOLERANCE_TO_BODY_SIZE_RATIO * size
        ):
            continue
        chosen.append(index)
        if len(chosen) >= 3:
            try:
                outline = scipy.spatial.ConvexHull(points[chosen, :2]).equations
            except scipy.spatial.QhullError:
                continue
    if hull.vertices.size <= MAX_HULL_VERTICES_STORED_UNREDUCED:
        return points[np.union1d(hull.vertices, np.array(chosen, np.intp))]
    extreme = _extreme_points_in_spread_directions(points[hull.vertices], MAX_HULL_VERTICES_STORED_UNREDUCED)
    return np.unique(np.concatenate([extreme, points[chosen]]), axis=0)


def _extreme_points_in_spread_directions(points: FloatArray, direction_count: int) -> FloatArray:
    """Return the points that are extreme in at least one of many directions, evenly spread over the sphere."""
    number = np.arange(direction_count) + 0.5
    height, turn = 1.0 - 2.0 * number / direction_count, np.pi * (1.0 + 5.0**0.5) * number
    level = np.sqrt(1.0 - height * height)
    directions = np.column_stack([level * np.cos(turn), level * np.sin(turn), height])
    return points[np.unique(np.concatenate([(points @ part.T).argmax(axis=0) for part in np.split(directions, 10)]))]


class ScanResult(NamedTuple):
    """Stone read from a mesh file, in its nearest stable pose, with volume and notes on repairs of the mesh."""

    shape: Shape
    volume_m3: float
    """Volume, m³."""
    rotation_to_stable_pose: RotationToStablePose
    mesh_change_notes: list[str]
    """Changes of the mesh, in words."""

    def description_lines(self, density: float | None = None) -> list[str]:
        """Return lines to print: volume, mesh repairs, pose, footprint, and mass if a density (kg/m³) is given."""
        mass = "" if density is None else f", mass {self.volume_m3 * density:.4g} kg"
        lines = [f"as scanned: volume {self.volume_m3:.4g} m³{mass}", *self.mesh_change_notes]
        tilt_deg = self.rotation_to_stable_pose.scan_tilt_from_stable_pose_deg
        if tilt_deg > 0.0:
            lines.append(f"placed in its nearest stable pose, tilted by {tilt_deg:.2f}° from its own vertical")
        if isinstance(self.shape, ScannedStone):
            solid = self.shape.unscaled_solid
            lines.append(
                f"footprint within a relief of {1000 * self.shape.max_load_bearing_base_point_height_m:.3g} mm: "
                f"{solid.base_vertex_count} "
                "corners, nearest edge "
                f"{1000 * solid.min_base_edge_distance_from_centre:.3g} mm from the foot of the centre of mass"
            )
        return lines


def stone_in_nearest_stable_pose_from_surface(
    surface: TriangleSurface,
    mesh_change_notes: list[str],
    stone_name: str,
    max_load_bearing_base_point_height_m: float | None = None,
) -> ScanResult:
    """Return the stone bounded by a closed surface, rotated to the nearest pose in which it can stand.

    The stone is a `ScannedStone`. If no relief is given, a convex body that stands on a face as scanned is a
    `Polyhedron`, unless points just above its base bear load, or it has too many vertices.

    Raises
    ------
    ArgumentError
        If the body cannot stand, or its size is out of range; see `ScannedStone`.
    """
    found = mass_properties_inside_surface(surface.triangle_corners)
    used = surface.vertices[np.unique(surface.triangles)]
    pose = nearest_stable_pose(used, found.centre_of_mass)
    if (
        max_load_bearing_base_point_height_m is None
        and pose.scan_tilt_from_stable_pose_deg == 0.0
        and (solid := _scan_as_convex_polyhedron_if_possible(used, found, stone_name)) is not None
    ):
        return ScanResult(solid, found.signed_volume, pose, mesh_change_notes)
    placed = used @ pose.rotation_matrix_from_scan_axes.T
    origin = pose.rotation_matrix_from_scan_axes @ found.centre_of_mass
    origin[2] = placed[:, 2].min()
    touching = np.round(points_that_can_touch_ground(placed - origin), STORED_POSITION_DECIMALS_OF_METRE)
    inertia = pose.rotation_matrix_from_scan_axes @ found.inertia_per_mass @ pose.rotation_matrix_from_scan_axes.T
    six = [*np.diag(inertia), -inertia[0, 1], -inertia[0, 2], -inertia[1, 2]]
    shape = ScannedStone(
        touching,
        np.round(
            pose.rotation_matrix_from_scan_axes @ found.centre_of_mass - origin, STORED_POSITION_DECIMALS_OF_METRE
        ),
        np.round(six, 9),
        DEFAULT_LOAD_BEARING_BASE_RELIEF_M
        if max_load_bearing_base_point_height_m is None
        else max_load_bearing_base_point_height_m,
        stone_name,
    )
    return ScanResult(shape, found.signed_volume, pose, mesh_change_notes)


def _scan_as_convex_polyhedron_if_possible(
    points: FloatArray, mass_properties: MassProperties, stone_name: str
) -> Polyhedron | None:
    """Return a scan as a polyhedron; None if not convex, with points just above the base or too many vertices."""
    hull = scipy.spatial.ConvexHull(points)
    if abs(hull.volume - mass_properties.signed_volume) > MAX_HULL_VOLUME_EXCESS_RATIO_OF_CONVEX_BODY * hull.volume:
        return None
    size = float(np.ptp(points, axis=0).max())
    inside = -(points @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)
    height = points[:, 2] - points[:, 2].min()
    if (
        inside.max() > FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO * size
        or (
            (height > FLATNESS_TOLERANCE_TO_BODY_SIZE_RATIO * size) & (height <= DEFAULT_LOAD_BEARING_BASE_RELIEF_M)
        ).any()
    ):
        return None
    if len(points) > MAX_CONTACT_VERTICES:
        return None
    return Polyhedron(points, stone_name)
