"""A rigid convex body that stands on its base: inertia, points at which it can touch, and the statics of its fall."""

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError

MAX_CONTACT_VERTICES: Final = 128
"""Of those that can touch; each of them is looked at in every step."""

MAX_CARRYING_CORNERS: Final = 4
"""A base of so many vertices, or fewer, has none between its ends: each one carries its share of the body."""

RIM_POINTS: Final = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
"""Where a rim carries a body that stands flat, in radii."""


@dataclass(frozen=True)
class Solid:
    """A body of homogeneous stone; coordinates are its own axes, from its centre of mass, z up at rest, m.

    Parameters
    ----------
    points : ndarray, shape (n, 3)
        Vertices that can touch before it has fallen, those of the base first, anticlockwise from above; of a round body
        four points of its rim.
    base : int
        Number of vertices of the base.
    inertia : ndarray, shape (3, 3)
        Moments and negative products of inertia per mass, m².
    fall_tilt : float
        Least tilt at which it can rest on another face, rad.
    faces : ndarray, shape (faces, 3)
        Outward normals of the faces on which it can then lie, clockwise from above.
    period : float
        Turn about the vertical after which it looks the same, degrees; 360 where there is none, 0 where any one does.
    radius : float
        Of its rim, m; 0 where it has vertices.
    facets : tuple of ndarray of int
        Which points lie in each further face that can come to lie flat before it has fallen.
    sectors : ndarray, shape (sectors, 5)
        Where the tilt of its fall depends on the direction in which it leans: begin of each sector of directions, 0 to
        4, a quarter turn each; a vector in its own axes, and its least product with the downward vertical at which the
        body has fallen in that sector. None where the least tilt holds all round.
    """

    points: FloatArray
    base: int
    inertia: FloatArray
    fall_tilt: float
    faces: FloatArray
    period: float = 360.0
    radius: float = 0.0
    facets: tuple[NDArray[np.int64], ...] = ()
    sectors: FloatArray = field(default_factory=lambda: np.zeros((0, 5)))

    def __post_init__(self) -> None:
        if len(self.points) > MAX_CONTACT_VERTICES:
            raise ArgumentError(
                f"body: {len(self.points)} vertices can touch; at most {MAX_CONTACT_VERTICES}: simplify the mesh, or "
                "take 'circle' for a round body"
            )
        if not self.reach > 0.0:
            raise ArgumentError(
                f"body: its centre is {-self.reach:.3g} m outside its base, so it falls by itself; stand it on "
                "another face"
            )

    @property
    def foot(self) -> float:
        """Height of the centre above the base, m."""
        return -float(self.points[0, 2])

    @property
    def carriers(self) -> int:
        """Number of points for which springs and dashpots are sized: 2, as in the plane, on a rim or many vertices.

        One point of a rim, or of more than four vertices, carries the body as it rocks, so it is as stiff and as damped
        as a corner of the plane's block, however many there are.
        """
        return 2 if self.radius or self.base > MAX_CARRYING_CORNERS else self.base

    @property
    def ends(self) -> float:
        """Share of the rise from lowest to highest vertex of a tilted base within which vertices are ends of it.

        Of a regular polygon the two of the edge over which it leans; where it leans over a vertex that one alone.
        """
        return float(np.round(0.4995 * (1.0 - np.cos(2.0 * np.pi / self.base)), 12))

    @cached_property
    def edges(self) -> FloatArray:
        """Distances of the edges of the base from below the centre, m, negative where that lies outside."""
        if self.radius:
            return np.array([self.radius])
        x, y = self.points[: self.base, :2].T
        dx, dy = np.roll(x, -1) - x, np.roll(y, -1) - y
        return np.asarray((x * dy - y * dx) / np.sqrt(dx * dx + dy * dy))

    @property
    def reach(self) -> float:
        """Least distance of an edge of the base from below the centre, m."""
        return float(self.edges.min())

    @property
    def b_over_h(self) -> float:
        """Slenderness: tan α towards the nearest edge; B/H for a prism."""
        return self.reach / self.foot

    @cached_property
    def inverse_inertia(self) -> FloatArray:
        """1/m², shape (3, 3), by cofactors."""
        a = self.inertia
        cofactors = np.array([np.cross(a[1], a[2]), np.cross(a[2], a[0]), np.cross(a[0], a[1])])
        return np.asarray(cofactors / np.sum(a[0] * cofactors[0]))

    def scaled(self, factor: float) -> Self:
        """The same body with all lengths multiplied by a factor."""
        return replace(self, points=self.points * factor, inertia=self.inertia * factor**2, radius=self.radius * factor)
