"""Kinds of bodies: rectangular and regular prisms, cylinders, and any convex polyhedron."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.model.cases import check_heights
from overturning.model.polyhedron import hull_outline, solid_from_vertices
from overturning.model.solid import RIM_POINTS, Solid

MAX_SIDES: Final = 96
"""Of a regular prism; a body with more is a cylinder."""


DRAWN_SIDES: Final = 36
"""Of a cylinder, where it is drawn."""

Outline = tuple[FloatArray, NDArray[np.int64]]
"""Corners of a body and the edges between them."""


class Shape(ABC):
    """A kind of body, whose sizes are those of the cases."""

    sized: ClassVar[bool] = True
    """Whether slenderness is free; else it is the body's own."""
    oblong: ClassVar[bool] = False
    """Whether the aspect is."""

    @property
    @abstractmethod
    def name(self) -> str:
        """As in the dataset."""

    @abstractmethod
    def body(self, height: float, b_over_h: float, aspect: float) -> Solid:
        """The body of a height (m), slenderness B/H and aspect D/B."""

    def outline(self, height: float, b_over_h: float, aspect: float) -> Outline:
        """Its corners from the centre, shape (n, 3), m, and the edges between them, shape (m, 2): how it is drawn."""
        return _prism(self.body(height, b_over_h, aspect).points)


@dataclass(frozen=True)
class Rectangle(Shape):
    """A right prism B × D × H; B along the azimuth of its orientation, D = aspect · B across."""

    name: ClassVar[str] = "rectangle"
    oblong: ClassVar[bool] = True

    def body(self, height: float, b_over_h: float, aspect: float) -> Solid:
        """The prism."""
        B = b_over_h * height
        D = aspect * B
        b, d, h = 0.5 * B, 0.5 * D, 0.5 * height
        points = np.array([[b, d, -h], [-b, d, -h], [-b, -d, -h], [b, -d, -h]])
        x, y, z = B * B / 12.0, D * D / 12.0, height * height / 12.0
        inertia = np.diag([y + z, x + z, x + y])
        return Solid(points, 4, inertia, 0.5 * np.pi, _sides(4), 90.0 if B == D else 180.0)


@dataclass(frozen=True)
class Regular(Shape):
    """A right prism on a regular polygon; its sides are B/2 from the middle, the first faces its orientation."""

    sides: int

    @property
    def name(self) -> str:
        """As in the dataset."""
        return f"{self.sides} sides"

    def body(self, height: float, b_over_h: float, aspect: float) -> Solid:  # noqa: ARG002, it has none
        """The prism."""
        n, apothem, h = self.sides, 0.5 * b_over_h * height, 0.5 * height
        turn = 2.0 * np.pi * (np.arange(n) + 0.5) / n
        radius = apothem / np.round(np.cos(np.pi / n), 12)
        ring = radius * np.round(np.stack([np.cos(turn), np.sin(turn)], axis=1), 12)
        # ∫x² over the polygon, per area.
        square = radius * radius * (2.0 + np.round(np.cos(2.0 * np.pi / n), 12)) / 12.0
        z = height * height / 12.0
        points = np.concatenate([ring, np.full((n, 1), -h)], axis=1)
        return Solid(points, n, np.diag([square + z, square + z, 2.0 * square]), 0.5 * np.pi, _sides(n), 360.0 / n)


@dataclass(frozen=True)
class Circle(Shape):
    """A right circular cylinder of diameter B."""

    name: ClassVar[str] = "circle"

    def body(self, height: float, b_over_h: float, aspect: float) -> Solid:  # noqa: ARG002, it has none
        """The cylinder."""
        R, h = 0.5 * b_over_h * height, 0.5 * height
        points = np.concatenate([R * RIM_POINTS, np.full((4, 1), -h)], axis=1)
        across = (3.0 * R * R + height * height) / 12.0
        return Solid(points, 4, np.diag([across, across, 0.5 * R * R]), 0.5 * np.pi, np.zeros((0, 3)), 0.0, R)

    def outline(self, height: float, b_over_h: float, aspect: float) -> Outline:  # noqa: ARG002
        """As of `Shape.outline`, with polygons of many sides."""
        turn = 2.0 * np.pi * np.arange(DRAWN_SIDES) / DRAWN_SIDES
        ring = 0.5 * b_over_h * height * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        return _prism(np.concatenate([ring, np.full((DRAWN_SIDES, 1), -0.5 * height)], axis=1))


@dataclass(frozen=True, eq=False)
class Polyhedron(Shape):
    """A convex polyhedron that stands on its lowest face.

    Parameters
    ----------
    vertices : array_like, shape (n, 3)
        In its own axes, z up, m; x points to the azimuth of its orientation.
    name : str
        As in the dataset.

    Raises
    ------
    ArgumentError
        If it is not convex, has no volume, cannot stand, has too many vertices that can touch, or is no stone by its
        size.
    """

    vertices: ArrayLike
    name: str = "polyhedron"
    sized: ClassVar[bool] = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "vertices", np.array(self.vertices, dtype=np.float64))
        _ = self.own  # checked here

    @property
    def height(self) -> float:
        """Its own height, m."""
        return float(np.ptp(np.asarray(self.vertices)[:, 2]))

    @cached_property
    def own(self) -> Solid:
        """The body at its own size."""
        made = solid_from_vertices(np.asarray(self.vertices))
        check_heights(self.height)
        return made

    def body(self, height: float, b_over_h: float, aspect: float) -> Solid:  # noqa: ARG002, it has its own
        """The body, scaled to a height."""
        return self.own.scaled(height / self.height)

    def outline(self, height: float, b_over_h: float, aspect: float) -> Outline:  # noqa: ARG002
        """As of `Shape.outline`: the edges of its hull."""
        corners, edges = hull_outline(np.asarray(self.vertices))
        return corners * (height / self.height), edges


def shape_of(body: "str | int | Shape") -> Shape:
    """The kind of body of a name, "rectangle" or "circle", of a number of sides, or as it is given.

    Raises
    ------
    ArgumentError
        If there is none.
    """
    if isinstance(body, str):
        named: dict[str, Shape] = {shape.name: shape for shape in (Rectangle(), Circle())}
        if body not in named:
            raise ArgumentError(
                f"body: {body!r}; give 'rectangle', 'circle', a number of sides, or a scene by load_scene or --scene"
            )
        return named[body]
    if isinstance(body, int):
        if not 3 <= body <= MAX_SIDES:
            raise ArgumentError(f"body: {body} sides; from 3 to {MAX_SIDES}, or 'circle'")
        return Regular(body)
    if not isinstance(body, Shape):
        raise ArgumentError(f"model: a {type(body).__name__}; give a scene of load_scene or gravestone, or a body")
    return body


def _prism(ring: FloatArray) -> Outline:
    """Corners and edges of a right prism by the ring of its base."""
    n = len(ring)
    lower, after = np.arange(n), np.roll(np.arange(n), -1)
    edges = np.concatenate(
        [np.stack(pair, axis=1) for pair in ((lower, after), (lower + n, after + n), (lower, lower + n))]
    )
    return np.concatenate([ring, ring * [1.0, 1.0, -1.0]]), edges


def orientation_grid(step_deg: float, shape: Shape, aspect: ArrayLike = 1.0) -> FloatArray:
    """Orientations a step apart, degrees, up to the turn after which bodies of all these aspects look the same.

    Raises
    ------
    ArgumentError
        If the step does not divide that turn, or they are too many.
    """
    turns = {shape.body(1.0, 0.5, float(value)).period for value in np.atleast_1d(np.asarray(aspect))}
    turn = max(turns)
    if turn == 0.0:
        return np.zeros(1)
    count = round(turn / step_deg) if step_deg > 0 else 0
    if count < 1 or abs(count * step_deg - turn) > 1e-9 * turn:
        raise ArgumentError(
            f"orientation: a step of {step_deg:g}° does not divide {turn:g}°, after which the body looks the same"
        )
    if count > 36_000:
        raise ArgumentError(f"orientation: {count:,} by a step of {step_deg:g}°, at most 36,000; take a larger step")
    return np.asarray(np.arange(count) * step_deg, np.float64)


def _sides(n: int) -> FloatArray:
    """Outward normals of the sides, clockwise from the first, which faces x."""
    turn = -2.0 * np.pi * np.arange(n) / n
    return np.stack([np.round(np.cos(turn), 12), np.round(np.sin(turn), 12), np.zeros(n)], axis=1)
