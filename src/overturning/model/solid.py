"""Rigid convex body on its base: inertia, contact points, and the tilt at which it has fallen."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError

MAX_CONTACT_VERTICES: Final = 128
"""Maximum number of contact vertices; each one is tested in every step."""

MAX_BASE_VERTICES_SHARING_WEIGHT_EQUALLY: Final = 4
"""Most vertices of a base that share its weight equally; see `RigidSolid.assumed_weight_sharing_point_count`."""

UNIT_RADIUS_RIM_CONTACT_POINTS: Final = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
"""Contact points of a circular base that stands flat, in units of its radius."""


class TooManyContactVerticesError(ArgumentError):
    """Error for a body with more vertices that can touch the ground than `MAX_CONTACT_VERTICES`."""


@dataclass(frozen=True, eq=False)
class RigidSolid:
    """Homogeneous rigid body; coordinates (m) are from its centre of mass, with z up in the pose at rest.

    Parameters
    ----------
    contact_points_from_centre_of_mass : ndarray, shape (n, 3)
        Vertices that can touch the ground before the body has fallen: first those of the base, anticlockwise from
        above. For a round body, four points of its rim.
    base_vertex_count : int
        Number of vertices of the base.
    inertia_per_mass : ndarray, shape (3, 3)
        Moments and negative products of inertia per mass, m².
    least_tilt_to_rest_on_another_face_rad : float
        Least tilt at which the body can rest on another face than its base, rad.
    resting_face_normals_after_fall : ndarray, shape (faces, 3)
        Outward normals of the faces on which the body can come to rest after a fall, clockwise from above.
    symmetry_period_deg : float
        Rotation about the vertical after which the body coincides with itself, degrees: 360 without symmetry, 0 for a
        body of revolution.
    rim_radius : float
        Radius of the rim of a round base, m; 0 for a body with vertices.
    point_indices_by_non_base_contact_face : tuple of ndarray of int
        Indices of the points of each face, other than the base, that can lie flat on the ground before a fall.
    lean_sector_start_vector_and_min_fall_dot_product : ndarray, shape (sectors, 5)
        Sectors of the direction of lean, if the tilt from which the body has fallen depends on this direction; empty
        if it is `least_tilt_to_rest_on_another_face_rad` in all directions.
        Columns: start of the sector (0 to 4, in quarter turns), a vector in the body's axes (3), and the least dot
        product of that vector with the downward vertical at which the body has fallen.
    """

    contact_points_from_centre_of_mass: FloatArray
    base_vertex_count: int
    inertia_per_mass: FloatArray
    least_tilt_to_rest_on_another_face_rad: float
    resting_face_normals_after_fall: FloatArray
    symmetry_period_deg: float = 360.0
    rim_radius: float = 0.0
    point_indices_by_non_base_contact_face: tuple[NDArray[np.int64], ...] = ()
    lean_sector_start_vector_and_min_fall_dot_product: FloatArray = field(default_factory=lambda: np.zeros((0, 5)))

    def __post_init__(self) -> None:
        if len(self.contact_points_from_centre_of_mass) > MAX_CONTACT_VERTICES:
            raise TooManyContactVerticesError(
                f"body: {len(self.contact_points_from_centre_of_mass)} vertices can touch; at most "
                f"{MAX_CONTACT_VERTICES}: simplify the mesh, or take 'circle' for a round body"
            )
        if not self.min_base_edge_distance_from_centre > 0.0:
            raise ArgumentError(
                f"body: its centre is {-self.min_base_edge_distance_from_centre:.3g} m outside its base, so "
                "it falls by itself; stand it on another face"
            )

    @property
    def centre_height(self) -> float:
        """Height of the centre of mass above the base, m."""
        return -float(self.contact_points_from_centre_of_mass[0, 2])

    @property
    def assumed_weight_sharing_point_count(self) -> int:
        """Number of contact points assumed to share the weight; it sets the spring and dashpot constants.

        This is the number of base vertices up to `MAX_BASE_VERTICES_SHARING_WEIGHT_EQUALLY`. With more, or a rim, it is
        2 as in the 2-D model: such a body rocks on a single point, which is then as stiff and as damped as a corner of
        the 2-D block.
        """
        return (
            2
            if self.rim_radius or self.base_vertex_count > MAX_BASE_VERTICES_SHARING_WEIGHT_EQUALLY
            else self.base_vertex_count
        )

    @property
    def lowest_vertex_tolerance_over_base_height_range(self) -> float:
        """Height above the lowest vertex of a tilted base up to which vertices count as lowest, over its height range.

        In a regular polygon, these are then both ends of the edge over which the base leans, or a single vertex.
        """
        return float(np.round(0.4995 * (1.0 - np.cos(2.0 * np.pi / self.base_vertex_count)), 12))

    @cached_property
    def base_edge_distances_from_centre(self) -> FloatArray:
        """Distance (m) of each base edge from the point below the centre of mass; negative if that point is outside."""
        if self.rim_radius:
            return np.array([self.rim_radius])
        x, y = self.contact_points_from_centre_of_mass[: self.base_vertex_count, :2].T
        dx, dy = np.roll(x, -1) - x, np.roll(y, -1) - y
        return np.asarray((x * dy - y * dx) / np.sqrt(dx * dx + dy * dy))

    @property
    def base_edge_normals(self) -> FloatArray:
        """Outward normals of a polygonal base, in the order of `base_edge_distances_from_centre`, shape (edges, 2)."""
        x, y = self.contact_points_from_centre_of_mass[: self.base_vertex_count, :2].T
        dx, dy = np.roll(x, -1) - x, np.roll(y, -1) - y
        return np.stack([dy, -dx], axis=1) / np.sqrt(dx * dx + dy * dy)[:, None]

    @property
    def min_base_edge_distance_from_centre(self) -> float:
        """Least horizontal distance from the point of the base below the centre of mass to an edge of the base, m."""
        return float(self.base_edge_distances_from_centre.min())

    @property
    def b_over_h(self) -> float:
        """Slenderness B/H: tangent of the tilt α at which the centre of mass is above the nearest base edge."""
        return self.min_base_edge_distance_from_centre / self.centre_height

    @cached_property
    def inverse_inertia_per_mass(self) -> FloatArray:
        """Inverse of the inertia per mass, 1/m², shape (3, 3), by cofactors."""
        a = self.inertia_per_mass
        cofactors = np.array([np.cross(a[1], a[2]), np.cross(a[2], a[0]), np.cross(a[0], a[1])])
        return np.asarray(cofactors / np.sum(a[0] * cofactors[0]))

    def scaled_by(self, length_factor: float) -> Self:
        """Return the body with all lengths multiplied by a factor."""
        return replace(
            self,
            contact_points_from_centre_of_mass=self.contact_points_from_centre_of_mass * length_factor,
            inertia_per_mass=self.inertia_per_mass * length_factor**2,
            rim_radius=self.rim_radius * length_factor,
        )
