"""Convex polygons: area, centre, inertia and faces, from closed forms."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

from overturning.arrays import FloatArray
from overturning.dem.rest import can_rest
from overturning.errors import ArgumentError

SYMMETRY: Final = 1e-9
"""Vertices that mirror each other to this share of the polygon's size are made to mirror each other exactly."""


@dataclass(frozen=True)
class Polygon:
    """A convex polygon about its centre of area."""

    vertices: FloatArray  # shape (n, 2), counter-clockwise, x to the right and z up, relative to the centre, m
    centre: tuple[float, float]  # in the coordinates in which the polygon was given, m
    area: float  # m²
    polar: float  # second moment of area about the centre, m⁴

    @property
    def symmetric(self) -> bool:
        """Whether it is its own mirror image about the vertical through its centre."""
        mirrored = {(-x, z) for x, z in self.vertices.tolist()}
        return mirrored == set(map(tuple, self.vertices.tolist()))

    @cached_property
    def width(self) -> float:
        """Extent in x, m."""
        return float(np.ptp(self.vertices[:, 0]))

    @cached_property
    def height(self) -> float:
        """Extent in z, m."""
        return float(np.ptp(self.vertices[:, 1]))

    @cached_property
    def fallen(self) -> float:
        """Least rotation, rad, at which it can rest on another face than the one that is most nearly below; π where on none.

        It is 90° for a rectangle. Rounded, since libm differs between processors in the last digit.
        """
        normals, offsets = self.faces[:, 4:6], self.faces[:, 6]
        tilts = np.abs(np.arctan2(normals[:, 0], -normals[:, 1]))
        stable = can_rest(normals, offsets, max(self.width, self.height))
        stable[np.argmin(tilts)] = False
        return round(float(np.min(tilts[stable], initial=np.pi)), 12)

    @cached_property
    def faces(self) -> FloatArray:
        """The faces as the kernel wants them, shape (n, 9).

        First and second end (4), outward normal (2), distance from the centre, place of the middle along the tangent
        (−n_z, n_x), half length. Of a symmetric polygon, mirrored faces have exactly mirrored numbers.
        """
        first, second = self.vertices, np.roll(self.vertices, -1, axis=0)
        edge = second - first
        length = np.sqrt(edge[:, 0] * edge[:, 0] + edge[:, 1] * edge[:, 1])
        tangent = edge / length[:, None]
        normal = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
        middle = 0.5 * (first + second)
        offset = normal[:, 0] * middle[:, 0] + normal[:, 1] * middle[:, 1]
        along = tangent[:, 0] * middle[:, 0] + tangent[:, 1] * middle[:, 1]
        table = np.column_stack([first, second, normal, offset, along, 0.5 * length])
        table.flags.writeable = False
        return table


def polygon(name: str, vertices: ArrayLike) -> Polygon:
    """Check a convex polygon and work out its constants.

    Area, centre and second moment are summed as the formulas for polygons of straight edges (Green's theorem) give them.
    Vertices have the shape (n, 2): counter-clockwise, x to the right, z up, m. A polygon that is degenerate, clockwise
    or not convex is an `ArgumentError` that names the element.
    """
    points = np.asarray(vertices, dtype=np.float64)
    if points.ndim != 2 or points.shape[1:] != (2,) or len(points) < 3 or not np.isfinite(points).all():
        raise ArgumentError(f"element {name}: a polygon has at least three vertices [x, z] of finite numbers")
    origin = points[0].copy()
    x, z = (points - origin).T  # near the origin, so that a polygon far away keeps its digits
    u, w = np.roll(x, -1), np.roll(z, -1)
    cross = x * w - u * z
    area = 0.5 * float(cross.sum())
    size = float(np.ptp(points, axis=0).max())
    if abs(area) <= 1e-9 * size**2 or size == 0:
        raise ArgumentError(
            f"element {name}: the polygon is degenerate, its area {abs(area):.3g} m²; move its vertices apart"
        )
    if area < 0:
        raise ArgumentError(f"element {name}: the polygon runs clockwise; list its vertices counter-clockwise")
    edge = np.stack([u - x, w - z], axis=1)
    following = np.roll(edge, -1, axis=0)
    bend = edge[:, 0] * following[:, 1] - edge[:, 1] * following[:, 0]
    if (np.hypot(edge[:, 0], edge[:, 1]) <= 1e-9 * size).any():
        raise ArgumentError(f"element {name}: the polygon is degenerate, two vertices coincide; leave one out")
    if (bend <= 1e-12 * size**2).any():
        corner = (int(np.argmin(bend)) + 1) % len(points)
        raise ArgumentError(
            f"element {name}: the polygon is not convex at vertex {corner} ({points[corner, 0]:g}, {points[corner, 1]:g}); "
            "leave the vertex out or split the element"
        )
    turns = np.arctan2(bend, edge[:, 0] * following[:, 0] + edge[:, 1] * following[:, 1]).sum()
    if turns > 1.5 * 2 * np.pi:
        raise ArgumentError(f"element {name}: the polygon crosses itself; list its vertices in order round it")
    cx = float(((x + u) * cross).sum()) / (6 * area)
    cz = float(((z + w) * cross).sum()) / (6 * area)
    local = _exactly_symmetric(np.stack([x - cx, z - cz], axis=1), size)
    return Polygon(local, (cx + float(origin[0]), cz + float(origin[1])), area, _polar(local))


def _polar(local: FloatArray) -> float:
    x, z = local.T
    u, w = np.roll(x, -1), np.roll(z, -1)
    return float(((x * w - u * z) * (x * x + x * u + u * u + z * z + z * w + w * w)).sum()) / 12.0


def _exactly_symmetric(local: FloatArray, size: float) -> FloatArray:
    """Remove the rounding that keeps a symmetric polygon from being its own mirror image bit by bit."""
    x, z = local.T
    distance = np.abs(x + x[:, None]) + np.abs(z - z[:, None])
    if (distance.min(axis=1) > SYMMETRY * size).any():
        return local
    # Both vertices of a pair come from the same two numbers, whichever is looked at first.
    partner = distance.argmin(axis=1)
    return np.asarray(0.5 * np.stack([x - x[partner], z + z[partner]], axis=1))


def rectangle(width: float, height: float) -> FloatArray:
    """Vertices of a rectangle on its lower side's middle, shape (4, 2), m."""
    half = 0.5 * width
    return np.array([[-half, 0.0], [half, 0.0], [half, height], [-half, height]])
