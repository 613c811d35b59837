"""Where a scene's elements stand, which faces are nearest, and where they touch at rest."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from overturning.arrays import FloatArray
from overturning.dem.element import Element, Material
from overturning.dem.polygon.shape import Polygon, polygon, rectangle
from overturning.errors import ArgumentError

TOUCHING: Final = 1e-7
"""Gap, as a share of the smaller element's size, up to which two elements touch at rest."""

FAR: Final = 4.0
"""Pairs farther apart than this many times the size of all free elements together never meet."""

WIDE: Final = 20.0
"""Width of the ground, in widths or heights of the block, that is more than any slide."""


class Stage(Protocol):
    """What of a scene says where its elements stand."""

    @property
    def elements(self) -> tuple[Element, ...]:
        """The elements, each after the one on which it stands."""

    @property
    def materials(self) -> Mapping[str, Material]:
        """What they are made of."""

    @property
    def reference_name(self) -> str:
        """The element whose height and slenderness are swept."""


@dataclass(frozen=True)
class Placed:
    """An element in its place.

    Attributes
    ----------
    element : Element
        What it is.
    shape : Polygon
        Its polygon about its centre.
    x, z : float
        The centre, m.
    mass, inertia : float
        kg and kg·m².
    """

    element: Element
    shape: Polygon
    x: float
    z: float
    mass: float
    inertia: float

    @property
    def points(self) -> FloatArray:
        """Vertices in the plane, shape (n, 2), m."""
        return self.shape.vertices + np.array([self.x, self.z])

    @property
    def size(self) -> float:
        """Smaller of width and height, m."""
        return min(self.shape.width, self.shape.height)

    @property
    def fixed(self) -> bool:
        """Whether forces do not move it."""
        return self.element.kind != "free"


@dataclass(frozen=True)
class End:
    """One end of the common stretch of two nearest faces.

    Attributes
    ----------
    gap : float
        Negative where the elements overlap, m; infinite where there is no common stretch.
    point : tuple of float
        The vertex, m.
    normal, tangent : tuple of float
        Normal from the second element to the first, and the direction in which slip of the first counts.
    """

    gap: float
    point: tuple[float, float]
    normal: tuple[float, float]
    tangent: tuple[float, float]


def place(scene: Stage, height: float | None = None, b_over_h: float | None = None) -> list[Placed]:
    """Put the elements into their places.

    Parameters
    ----------
    scene : Stage
        The scene.
    height : float, optional
        Height of the reference element, m; all lengths of the scene scale with it.
    b_over_h : float, optional
        Width over height of the reference element, which alone becomes wider or narrower.

    Returns
    -------
    list of Placed

    Raises
    ------
    ArgumentError
        If a polygon is degenerate, clockwise or not convex.
    """
    own = next(element for element in scene.elements if element.name == scene.reference_name)
    reference = polygon(own.name, _vertices(own))
    scale = 1.0 if height is None else height / reference.height
    placed: list[Placed] = []
    for element in scene.elements:
        points = _vertices(element)
        if b_over_h is not None and element.name == scene.reference_name:
            middle = 0.5 * (points[:, 0].max() + points[:, 0].min())
            # One rounding only, as in a block of width B/H · H.
            points[:, 0] = (points[:, 0] - middle) * (b_over_h * reference.height / reference.width) + middle
        shape = polygon(element.name, points * scale)
        shift_x, shift_z = element.at[0] * scale, element.at[1] * scale
        x, z = shape.centre[0] + shift_x, shape.centre[1] + shift_z
        if element.stands_on is not None:
            below = next(other for other in placed if other.element.name == element.stands_on)
            x = below.x + x
            z = float(below.points[:, 1].max()) + shift_z - float(shape.vertices[:, 1].min())
        # An element in the middle is exactly there, so that a symmetric scene is exactly so.
        x = 0.0 if abs(x) < 1e-9 * shape.width else x
        density = scene.materials[element.material].density
        per_area = density * element.depth
        placed.append(Placed(element, shape, x, z, per_area * shape.area, per_area * shape.polar))
    return placed


def symmetric(placed: list[Placed]) -> bool:
    """Whether a scene is its own mirror image, element by element, so that φ+180° mirrors φ exactly."""
    return all(item.x == 0.0 and item.shape.symmetric for item in placed)


def native_size(scene: Stage) -> tuple[float, float]:
    """Height (m) and B/H of a scene's reference element as the file gives it."""
    shape = next(item.shape for item in place(scene) if item.element.name == scene.reference_name)
    return shape.height, shape.width / shape.height


def _vertices(element: Element) -> FloatArray:
    if element.vertices is not None:
        points = np.array(element.vertices, dtype=np.float64)
    else:
        assert element.width is not None  # one form is given: the model's own check
        assert element.height is not None
        points = rectangle(element.width, element.height)
    if element.rotation_deg:
        # Rounded, since libm differs between processors in the last digit.
        c, s = (round(float(f(np.radians(element.rotation_deg))), 12) for f in (np.cos, np.sin))
        points = np.column_stack([c * points[:, 0] + s * points[:, 1], c * points[:, 1] - s * points[:, 0]])
    return points


def separations(one: Placed, other: Placed) -> FloatArray:
    """Signed distance of the other's nearest vertex from each face of one, m, positive outside."""
    faces = one.shape.faces()
    points = other.points - np.array([one.x, one.z])
    reach = faces[:, 4:5] * points[:, 0] + faces[:, 5:6] * points[:, 1]
    return np.asarray(reach.min(axis=1) - faces[:, 6])


def nearest_faces(a: Placed, b: Placed) -> tuple[int, int, float]:
    """The nearest faces of two elements, by the rule of docs/scenes.md.

    Returns
    -------
    face_a, face_b : int
        Indices; face i runs from vertex i to vertex i + 1.
    separation : float
        m, negative where they overlap.
    """
    faces_a, faces_b = a.shape.faces(), b.shape.faces()
    products = faces_a[:, 4:5] * faces_b[:, 4] + faces_a[:, 5:6] * faces_b[:, 5]
    candidates: list[tuple[float, float, int, int, int]] = []
    for k, gap in enumerate(separations(a, b)):
        other = int(np.argmin(products[k]))
        candidates.append((-float(gap), float(products[k, other]), len(candidates), k, other))
    for k, gap in enumerate(separations(b, a)):
        other = int(np.argmin(products[:, k]))
        candidates.append((-float(gap), float(products[other, k]), len(candidates), other, k))
    best = min(candidates)
    return best[3], best[4], float(-best[0])


def common_stretch(a: Placed, b: Placed) -> tuple[End, End]:
    """Both ends of the common stretch of the nearest faces: at each end the inner one of two vertices."""
    face_a, face_b, _ = nearest_faces(a, b)
    fa, fb = a.shape.faces()[face_a], b.shape.faces()[face_b]
    delta = np.array([a.x - b.x, a.z - b.z])
    center_a, center_b = np.array([a.x, a.z]), np.array([b.x, b.z])

    def seen(face: FloatArray, point: FloatArray) -> tuple[float, float]:
        gap = face[4] * point[0] + face[5] * point[1] - face[6]
        return float(gap), float(face[4] * point[1] - face[5] * point[0] - face[7])

    ends = []
    for first in (True, False):
        mine, theirs = (fa[0:2], fb[2:4]) if first else (fa[2:4], fb[0:2])
        gap_mine, along_mine = seen(fb, mine + delta)
        gap_theirs, along_theirs = seen(fa, theirs - delta)
        inner = along_mine <= fb[8] if first else along_mine >= -fb[8]
        if inner:
            nx, nz = float(fb[4]), float(fb[5])
            gap, point, inside = gap_mine, mine + center_a, abs(along_mine) <= fb[8]
        else:
            nx, nz = -float(fa[4]), -float(fa[5])
            gap, point, inside = gap_theirs, theirs + center_b, abs(along_theirs) <= fa[8]
        ends.append(
            End(gap if inside else np.inf, (float(point[0]), float(point[1])), (nx, nz), (nz, -nx))
        )  # fmt: skip
    return ends[0], ends[1]


def pairs_of(placed: list[Placed]) -> list[tuple[int, int]]:
    """Pairs that could ever meet: one of them free, and not too far apart."""
    extent = sum(item.shape.width + item.shape.height for item in placed if not item.fixed)
    pairs = []
    for i, a in enumerate(placed):
        for j, b in enumerate(placed[:i]):
            if a.fixed and b.fixed:
                continue
            gap = max(separations(a, b).max(), separations(b, a).max())
            if gap <= FAR * extent:
                pairs.append((i, j))
    return sorted(pairs, key=lambda pair: (pair[1], pair[0]))


def resting(placed: list[Placed], pairs: list[tuple[int, int]]) -> list[tuple[int, int, End]]:
    """Ends that touch: index of the pair, end (0 or 1), and the end."""
    touches = []
    for index, (i, j) in enumerate(pairs):
        a, b = placed[i], placed[j]
        for side, end in enumerate(common_stretch(a, b)):
            if end.gap <= TOUCHING * min(a.size, b.size):
                touches.append((index, side, end))
    return touches


def check_geometry(scene: Stage) -> None:
    """Refuse elements that overlap or hang in the air.

    Raises
    ------
    ArgumentError
        Names element and remedy.
    """
    placed = place(scene)
    for i, a in enumerate(placed):
        for b in placed[:i]:
            if a.fixed and b.fixed:
                continue
            depth = -max(separations(a, b).max(), separations(b, a).max())
            if depth > 1e-6 * min(a.size, b.size):
                raise ArgumentError(
                    f"element {a.element.name}: overlaps {b.element.name} by {depth:.3g} m; move it, or place it with "
                    f"stands_on: {b.element.name}"
                )
    pairs = pairs_of(placed)
    carried = {i for i, item in enumerate(placed) if item.fixed}
    ends = resting(placed, pairs)
    while True:
        more = {
            up
            for index, _, end in ends
            for up, low, sign in ((*pairs[index], 1.0), (*pairs[index][::-1], -1.0))
            if low in carried and up not in carried and sign * end.normal[1] > 1e-3
        }
        if not more:
            break
        carried |= more
    for i, item in enumerate(placed):
        if i not in carried:
            raise ArgumentError(
                f"element {item.element.name}: hangs in the air, nothing carries it; place it with stands_on: and an element "
                "listed before it"
            )
