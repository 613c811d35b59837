"""Shapes of 3-D bodies: rectangular and regular prisms, cylinders, and convex polyhedra."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray
from typing_extensions import override

from overturning.arrays import FloatArray, convert_argument_to_finite_array
from overturning.errors import ArgumentError
from overturning.model.cases import check_stone_heights_within_allowed_range
from overturning.model.polyhedron import convex_vertices_from_mass_centre_and_edges, solid_from_vertices
from overturning.model.solid import UNIT_RADIUS_RIM_CONTACT_POINTS, RigidSolid

MAX_PRISM_SIDES: Final = 96
"""Largest number of sides of a regular prism; use a cylinder for more."""

DRAWN_CYLINDER_SIDES: Final = 36
"""Number of sides of the polygon with which a cylinder is drawn."""

CornersAndEdges = tuple[FloatArray, NDArray[np.int64]]
"""Corners of a body from its centre, shape (n, 3), m, and edges as pairs of corner indices, shape (m, 2)."""


class Shape(ABC):
    """Shape of a 3-D body; each case gives its size by height, slenderness B/H and aspect ratio D/B."""

    slenderness_is_parameter: ClassVar[bool] = True
    """True if B/H is a parameter; False if it is fixed by the shape."""
    depth_over_width_is_parameter: ClassVar[bool] = False
    """True if the aspect D/B is a parameter."""

    @property
    @abstractmethod
    def name(self) -> str:
        """Name of the shape in datasets, such as "rectangle"."""

    @abstractmethod
    def solid(self, height: float, b_over_h: float, depth_over_width: float) -> RigidSolid:
        """Return the rigid body of this shape with a height (m), slenderness B/H and aspect D/B."""

    def drawn_corners_and_edges(self, height: float, b_over_h: float, depth_over_width: float) -> CornersAndEdges:
        """Return the corners of the body for drawing, shape (corners, 3), m, and its edges as corner index pairs."""
        return _prism_corners_and_edges(
            self.solid(height, b_over_h, depth_over_width).contact_points_from_centre_of_mass
        )


@dataclass(frozen=True)
class RectangularPrism(Shape):
    """Rectangular prism B × D × H, with the width B along the azimuth that it faces and the depth D = aspect · B."""

    name: ClassVar[str] = "rectangle"
    depth_over_width_is_parameter: ClassVar[bool] = True

    @override
    def solid(self, height: float, b_over_h: float, depth_over_width: float) -> RigidSolid:
        B = b_over_h * height
        D = depth_over_width * B
        b, d, h = 0.5 * B, 0.5 * D, 0.5 * height
        points = np.array([[b, d, -h], [-b, d, -h], [-b, -d, -h], [b, -d, -h]])
        x, y, z = B * B / 12.0, D * D / 12.0, height * height / 12.0
        inertia = np.diag([y + z, x + z, x + y])
        return RigidSolid(points, 4, inertia, 0.5 * np.pi, _regular_prism_side_normals(4), 90.0 if B == D else 180.0)


@dataclass(frozen=True)
class RegularPrism(Shape):
    """Right prism on a regular polygon with inscribed circle of diameter B; its first side faces the orientation."""

    sides: int

    def __post_init__(self) -> None:
        if not isinstance(self.sides, int | np.integer) or not 3 <= self.sides <= MAX_PRISM_SIDES:
            raise ArgumentError(
                f"sides: {self.sides!r}; give a whole number from 3 to {MAX_PRISM_SIDES}, or a Cylinder"
            )
        object.__setattr__(self, "sides", int(self.sides))

    @property
    @override
    def name(self) -> str:
        return f"{self.sides} sides"

    @override
    def solid(self, height: float, b_over_h: float, depth_over_width: float) -> RigidSolid:
        n, apothem, h = self.sides, 0.5 * b_over_h * height, 0.5 * height
        turn = 2.0 * np.pi * (np.arange(n) + 0.5) / n
        radius = apothem / np.round(np.cos(np.pi / n), 12)
        ring = radius * np.round(np.stack([np.cos(turn), np.sin(turn)], axis=1), 12)
        # Mean of x² over the area of the polygon.
        square = radius * radius * (2.0 + np.round(np.cos(2.0 * np.pi / n), 12)) / 12.0
        z = height * height / 12.0
        points = np.concatenate([ring, np.full((n, 1), -h)], axis=1)
        return RigidSolid(
            points,
            n,
            np.diag([square + z, square + z, 2.0 * square]),
            0.5 * np.pi,
            _regular_prism_side_normals(n),
            360.0 / n,
        )


@dataclass(frozen=True)
class Cylinder(Shape):
    """Right circular cylinder of diameter B and height H."""

    name: ClassVar[str] = "circle"

    @override
    def solid(self, height: float, b_over_h: float, depth_over_width: float) -> RigidSolid:
        R, h = 0.5 * b_over_h * height, 0.5 * height
        points = np.concatenate([R * UNIT_RADIUS_RIM_CONTACT_POINTS, np.full((4, 1), -h)], axis=1)
        across = (3.0 * R * R + height * height) / 12.0
        return RigidSolid(points, 4, np.diag([across, across, 0.5 * R * R]), 0.5 * np.pi, np.zeros((0, 3)), 0.0, R)

    @override
    def drawn_corners_and_edges(self, height: float, b_over_h: float, depth_over_width: float) -> CornersAndEdges:
        turn = 2.0 * np.pi * np.arange(DRAWN_CYLINDER_SIDES) / DRAWN_CYLINDER_SIDES
        ring = 0.5 * b_over_h * height * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        return _prism_corners_and_edges(
            np.concatenate([ring, np.full((DRAWN_CYLINDER_SIDES, 1), -0.5 * height)], axis=1)
        )


@dataclass(frozen=True, eq=False)
class Polyhedron(Shape):
    """Shape of a stone: any convex polyhedron, given by its vertices; it stands on its lowest face.

    Parameters
    ----------
    vertices : array_like, shape (n, 3)
        Vertices in the body's axes, m: z up, x along the azimuth of the orientation.
    name : str
        Name in datasets.

    Raises
    ------
    ArgumentError
        If the body is not convex, has no volume, cannot stand, has too many vertices that can touch the ground, or its
        height is out of range.
    """

    vertices: ArrayLike
    name: str = "polyhedron"
    slenderness_is_parameter: ClassVar[bool] = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", convert_argument_to_finite_array("vertices", self.vertices, (-1, 3)))
        _ = self.unscaled_solid  # raises the errors

    @property
    def unscaled_height(self) -> float:
        """Height (m) of the polyhedron with its vertices as given, before scaling to the height of a case."""
        return float(np.ptp(np.asarray(self.vertices)[:, 2]))

    @cached_property
    def unscaled_solid(self) -> RigidSolid:
        """Rigid body with the polyhedron's vertices as given, before scaling to the height of a case."""
        made = solid_from_vertices(np.asarray(self.vertices))
        check_stone_heights_within_allowed_range(self.unscaled_height)
        return made

    @override
    def solid(self, height: float, b_over_h: float, depth_over_width: float) -> RigidSolid:
        return self.unscaled_solid.scaled_by(height / self.unscaled_height)

    @override
    def drawn_corners_and_edges(self, height: float, b_over_h: float, depth_over_width: float) -> CornersAndEdges:
        corners, edges = convex_vertices_from_mass_centre_and_edges(np.asarray(self.vertices))
        return corners * (height / self.unscaled_height), edges


def shape_from_name_or_sides(name_sides_or_shape: "str | int | Shape", argument_name: str = "model") -> Shape:
    """Return the shape for a name ("rectangle", "circle") or number of sides; return a given shape unchanged.

    Error messages name the argument `argument_name`.

    Raises
    ------
    ArgumentError
        If the name or number is unknown, or the argument is of another type.
    """
    if isinstance(name_sides_or_shape, str):
        named: dict[str, Shape] = {shape.name: shape for shape in (RectangularPrism(), Cylinder())}
        if name_sides_or_shape not in named:
            raise ArgumentError(
                f"{argument_name}: {name_sides_or_shape!r}; give 'rectangle', 'circle', a number of sides from "
                f"3 to {MAX_PRISM_SIDES}, or a scene by load_scene or --scene"
            )
        return named[name_sides_or_shape]
    if isinstance(name_sides_or_shape, int | np.integer):
        if not 3 <= name_sides_or_shape <= MAX_PRISM_SIDES:
            raise ArgumentError(
                f"{argument_name}: {name_sides_or_shape} sides; from 3 to {MAX_PRISM_SIDES}, or 'circle'"
            )
        return RegularPrism(int(name_sides_or_shape))
    if not isinstance(name_sides_or_shape, Shape):
        raise ArgumentError(
            f"{argument_name}: a {type(name_sides_or_shape).__name__}; give a scene of load_scene or gravestone, "
            "or a body"
        )
    return name_sides_or_shape


def _prism_corners_and_edges(base_vertices_from_centre: FloatArray) -> CornersAndEdges:
    """Return corners and edges of a right prism, for drawing, from the vertices of its base, shape (n, 3), m."""
    n = len(base_vertices_from_centre)
    lower, after = np.arange(n), np.roll(np.arange(n), -1)
    edges = np.concatenate(
        [np.stack(pair, axis=1) for pair in ((lower, after), (lower + n, after + n), (lower, lower + n))]
    )
    return np.concatenate([base_vertices_from_centre, base_vertices_from_centre * [1.0, 1.0, -1.0]]), edges


def orientations_over_symmetry_period_deg(
    orientation_step_deg: float, shape: Shape, depth_over_width: ArrayLike = 1.0
) -> FloatArray:
    """Return equally spaced orientations, degrees, over a body's symmetry period: the longest of its aspects D/B.

    Raises
    ------
    ArgumentError
        If the step does not divide the period, or there are too many orientations.
    """
    turns = {
        shape.solid(1.0, 0.5, float(value)).symmetry_period_deg for value in np.atleast_1d(np.asarray(depth_over_width))
    }
    turn = max(turns)
    if turn == 0.0:
        return np.zeros(1)
    count = round(turn / orientation_step_deg) if orientation_step_deg > 0 else 0
    if count < 1 or abs(count * orientation_step_deg - turn) > 1e-9 * turn:
        raise ArgumentError(
            f"orientation: a step of {orientation_step_deg:g}° does not divide {turn:g}°, after which the body "
            "looks the same"
        )
    if count > 36_000:
        raise ArgumentError(
            f"orientation: {count:,} with a step of {orientation_step_deg:g}°, at most 36,000; take a larger step"
        )
    return np.asarray(np.arange(count) * orientation_step_deg, np.float64)


def _regular_prism_side_normals(side_count: int) -> FloatArray:
    """Return the n outward side normals of a regular prism, shape (n, 3), clockwise from above, the first along +x."""
    turn = -2.0 * np.pi * np.arange(side_count) / side_count
    return np.stack([np.round(np.cos(turn), 12), np.round(np.sin(turn), 12), np.zeros(side_count)], axis=1)
