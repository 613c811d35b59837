"""What a scene at one size asks of the kernel: pairs, springs, rest, the stable step, thresholds."""

from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.limits import sinks_too_far
from overturning.dem.polygon.statics import (
    Laws,
    Loaded,
    bearing_ends,
    contact_laws,
    highest_modes,
    joints_of,
    rest,
    slowest_mode,
)
from overturning.model.geometry import (
    ElementPair,
    PlacedElement,
    StretchEnd,
    element_pairs,
    ground_name,
    place_elements,
    placement_error,
)
from overturning.model.scene import Scene


@dataclass(frozen=True)
class Prepared:
    """One variant of a scene, ready to run."""

    scene: Scene
    placed: list[PlacedElement]
    pairs: list[ElementPair]  # elements that can meet
    laws: Laws
    displacement: FloatArray  # shape (elements, 3): x, z (m) and rotation (rad) at rest, from the places
    loaded: list[Loaded]  # ends that carry something at rest
    at_rest: bool  # whether the scene rests by itself
    square: float  # largest eigenvalue of the springs, 1/s²
    rate: float  # and of the dashpots, 1/s
    slowest: float  # smallest eigenvalue of the springs at rest, 1/s²
    threshold: float  # horizontal acceleration over g below which nothing can start to rock; 0 where it is not known
    parts: NDArray[np.int64]  # shape (parts, 2): lowest element of those that can move as one, and the one listed last
    safe: FloatArray  # shape (parts,): horizontal acceleration over g below which they cannot
    tips: FloatArray  # shape (elements, 2): rotation to −x and +x that tips it off its support, rad; infinite: none
    critical: FloatArray  # shape (elements,): α, the smaller of both, rad; without one the angle of its fall
    barrier: FloatArray  # shape (elements,): energy to overturn each free element, J
    support: NDArray[np.int64]  # shape (elements,): the first that carries it; itself where nothing does
    base: FloatArray  # shape (elements, 2): middle of the stretch on which it stands, m
    carriers: list[set[int]]  # what carries each element at rest
    fits: bool  # whether no element overlaps another or hangs in the air at this B/H

    @property
    def free(self) -> NDArray[np.int64]:
        """Indices of the free elements."""
        return np.array([k for k, item in enumerate(self.placed) if not item.fixed], dtype=np.int64)

    @property
    def sizes(self) -> list[int]:
        """Numbers of vertices of all convex pieces."""
        return [len(part.vertices) for item in self.placed for part in item.shape.parts]

    @property
    def alpha(self) -> FloatArray:
        """α of each element, the smaller of both sides, rad; NaN where it has none."""
        return np.where(np.isfinite(self.tips).all(axis=1), self.critical, np.nan)

    @property
    def comes_back(self) -> FloatArray:
        """Rotations to −x and +x up to which each element can come back, rad, shape (elements, 2).

        The tipping angles; the angle of its fall where it has none.
        """
        return np.where(np.isfinite(self.tips), self.tips, self.critical[:, None])

    @property
    def unit(self) -> FloatArray:
        """What its largest rotation is given in, rad: its α, a degree where it has none, shape (elements,)."""
        return np.where(np.isnan(self.alpha), np.radians(1.0), self.critical)

    @property
    def sunk(self) -> FloatArray:
        """Static penetration of the pairs that carry weight, both ends alike, m."""
        loaded = self.laws.carried > 0.0
        return self.laws.carried[loaded] / (2.0 * self.laws.normal[loaded])

    @property
    def sinks(self) -> bool:
        """Whether its weight alone presses a pair in too far; faces may even have passed one another then."""
        return bool(sinks_too_far(self.sunk, smallest(self.placed)).any())

    @property
    def unanswered(self) -> bool:
        """Whether there is no answer whatever the motion: weight presses a pair in too far, or an element misfits."""
        return self.sinks or not self.fits

    @property
    def rocking_time(self) -> float:
        """1/p of the element that rocks fastest, s: p = √(3g/4R), R its farthest vertex."""
        square = min(float((self.placed[k].shape.vertices ** 2).sum(axis=1).max()) for k in self.free)
        return float(np.sqrt(np.sqrt(square) / (0.75 * self.scene.gravity)))

    @property
    def height(self) -> float:
        """Highest level of the free elements, m."""
        return max(float(self.placed[k].points[:, 1].max()) for k in self.free)

    @property
    def radius(self) -> float:
        """Largest distance of a centre from the farthest vertex below it, m, for the time after the record."""
        low = min(float(self.placed[k].points[:, 1].min()) for k in self.free)
        wide = max(self.placed[k].shape.width for k in self.free)
        return 0.5 * float(np.sqrt((self.height - low) ** 2 + wide**2))

    @cached_property
    def edge(self) -> FloatArray:
        """Slip of each element that takes it past the end of the ground, m; infinite on anything else."""
        ground = ground_name(self.scene)
        far = [0.5 * item.shape.width if item.element.name == ground else np.inf for item in self.placed]
        return np.array(
            [far[on] - abs(x - self.placed[on].x) for on, (x, _) in zip(self.support, self.base, strict=True)]
        )

    def stands_on(self, k: int) -> tuple[int, int]:
        """What carries an element, and the held one on which it stands, directly or not; −1 for none."""
        last = k
        while not self.placed[last].fixed and self.support[last] != last:
            last = int(self.support[last])
        return int(self.support[k]), last if self.placed[last].element.kind == "held" else -1

    def onset(self, friction: FloatArray) -> FloatArray:
        """Horizontal acceleration over g below which nothing can start to move, with the friction that is swept."""
        return np.minimum(self.threshold, self.grip(friction))

    def grip(self, friction: FloatArray) -> FloatArray:
        """Least horizontal acceleration over g that lets something slide on what carries it, 0 where it slides at rest.

        On a level face that is µ, on one of tangent t (µ − t)/(1 + µ t); `friction` is the one that is swept.
        """
        least = np.full(friction.shape, np.inf)
        for end in self.loaded:
            coefficient, (x, z) = self.laws.friction[end.pair], np.abs(end.end.normal)
            held = friction if coefficient < 0 else np.full(friction.shape, coefficient)
            least = np.minimum(least, np.maximum(held * z - x, 0.0) / np.maximum(z + held * x, 1e-300))
        return least


def prepare(scene: Scene, height: float | None = None, b_over_h: float | None = None) -> Prepared:
    """Prepare a scene whose reference element has a height (m) and slenderness; its own where they are not given."""
    placed = place_elements(scene, height, b_over_h)
    pairs = element_pairs(placed)
    joints = joints_of(placed, pairs)
    laws = contact_laws(scene, placed, pairs, joints)
    equilibrium = rest(scene, placed, joints, laws.normal, laws.tangential)
    displacement, loaded = equilibrium or (np.zeros((len(placed), 3)), [])
    bearing = bearing_ends(scene, placed, pairs, joints, loaded)
    stands = _stands(placed, pairs, bearing)
    threshold, parts, safe = _lifting(placed, stands)
    if equilibrium is None or any(item.element.kind == "held" for item in placed):  # what is held moves alone
        threshold, safe = 0.0, 0.0 * safe
    if any(
        laws.friction[k] >= 0 and laws.tangential[k] * abs(slip) > laws.friction[k] * laws.normal[k] * approach
        for k, _, _, approach, slip in loaded
    ):
        threshold = 0.0  # it slides by itself
    tips, critical, barrier, support, base = _single(scene, placed, stands, _upright(placed, pairs, bearing))
    return Prepared(
        scene, placed, pairs, laws, displacement, loaded, equilibrium is not None,
        *highest_modes(placed, pairs, joints, laws), slowest_mode(placed, joints, laws),
        threshold, parts, safe, tips, critical, barrier, support, base,
        [set(stands.get(k, {})) for k in range(len(placed))], b_over_h is None or not placement_error(placed),
    )  # fmt: skip


def critical_angles(scene: Scene, b_over_h: FloatArray) -> FloatArray:
    """α of each free element at each slenderness of the reference element, degrees, shape (b, free); NaN for none."""
    prepared = (prepare(scene, None, float(ratio)) for ratio in b_over_h)
    return np.stack([np.degrees(item.alpha[item.free]) for item in prepared])


CRITICAL: Final = {
    "units": "degree",
    "long_name": "critical angle, at which an element tips off what carries it as it stands in the scene",
    "comment": "missing where it has none of its own, as an arch stone or one that leans: "
    "its peak_rotation is in degrees",
}
"""CF attributes of the critical angles of a scene."""


def smallest(placed: list[PlacedElement]) -> float:
    """Smaller side of the smallest free element, m."""
    return min(item.size for item in placed if not item.fixed)


Stands = dict[int, dict[int, list[StretchEnd]]]

ALIKE: Final = 0.05
"""Sine of the angle between two directions up to which they are one."""

LEAST_TIP: Final = 1e-6
"""A tipping angle below this is none, rad."""


def _stands(placed: list[PlacedElement], pairs: list[ElementPair], loaded: list[Loaded]) -> Stands:
    """Of each free element: what carries it, with the loaded ends."""
    result: Stands = {}
    for index, _, end, _, _ in loaded:
        i, j = pairs[index][:2]
        upper, lower = (i, j) if end.normal[1] > 0 else (j, i)
        if not placed[upper].fixed and abs(end.normal[1]) > 1e-3:
            result.setdefault(upper, {}).setdefault(lower, []).append(end)
    return result


def _upright(placed: list[PlacedElement], pairs: list[ElementPair], loaded: list[Loaded]) -> NDArray[np.bool_]:
    """Which elements stand by themselves on what carries them: all that bears on them at rest bears in one direction.

    An arch stone, one in a groove and one that leans on a wall are held by faces that are turned to each other; there
    is no angle at which they tip off.
    """
    normals: list[list[tuple[float, float]]] = [[] for _ in placed]
    for index, _, end, _, _ in loaded:
        for k in pairs[index][:2]:
            normals[k].append(end.normal)
    result = np.zeros(len(placed), np.bool_)
    for k, found in enumerate(normals):
        directions = np.array(found).reshape(-1, 2)
        across = np.outer(directions[:, 0], directions[:, 1])
        result[k] = not placed[k].fixed and len(found) > 0 and bool((np.abs(across - across.T) < ALIKE).all())
    return result


def _single(
    scene: Scene, placed: list[PlacedElement], stands: Stands, upright: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray, FloatArray, NDArray[np.int64], FloatArray]:
    """Of each element by itself: tipping angles to both sides, α, barrier, support and middle of its base."""
    count = len(placed)
    tips, critical, barrier = np.full((count, 2), np.inf), np.full(count, 0.5 * np.pi), np.zeros(count)
    support, base = np.arange(count), np.array([[item.x, item.z] for item in placed])
    for k, item in enumerate(placed):
        if item.fixed:
            continue
        ends = [(lower, end.point) for lower, all_ends in stands.get(k, {}).items() for end in all_ends]
        rests = bool(ends)
        if not ends:  # not at rest on anything: its lowest vertices take the place of the support
            low = item.points[:, 1].min()
            ends = [(k, (float(x), float(z))) for x, z in item.points if z < low + 0.01 * item.size]
        support[k] = ends[0][0]
        base[k] = np.mean([point for _, point in ends], axis=0)
        reach, lift = [], []
        for side in (-1.0, 1.0):
            _, point = max(ends, key=lambda entry: side * entry[1][0])
            arm, rise = side * (point[0] - item.x), item.z - point[1]
            # Rounded, since libm differs between processors in the last digit.
            reach.append(round(float(np.arctan2(max(arm, 0.0), rise)), 12))
            lift.append(np.sqrt(arm * arm + rise * rise) - rise if arm > 0 else 0.0)
        if upright[k] and min(reach) > LEAST_TIP:
            tips[k] = reach
            critical[k], least = min(reach), min(lift)
        else:
            critical[k], least = min(item.fallen_rotations) if rests else max(min(reach), LEAST_TIP), 0.0
        barrier[k] = item.mass * scene.gravity * max(least, 1e-9 * item.size)
    return tips, critical, barrier, support, base


def _lifting(placed: list[PlacedElement], stands: Stands) -> tuple[float, NDArray[np.int64], FloatArray]:
    """Horizontal acceleration over g below which no part of the scene that can move as one starts to rock.

    A part is an element with what stands on it, directly or not. It lifts off when the resultant of weight and inertia
    leaves its base: |a|/g > arm / height of the common centre.

    Returns
    -------
    threshold : float
        The least of the elements with all that they carry.
    parts : ndarray of int64, shape (parts, 2)
        The lowest element of a part, and the one that the scene lists last: without either the part is none.
    least : ndarray, shape (parts,)
        The least of the parts with these two. All is 0 where anything bridges or leans: there is no closed form.
    """
    free = [k for k, item in enumerate(placed) if not item.fixed]
    if any(len(stands.get(k, {})) != 1 for k in free):
        return 0.0, np.array([(k, k) for k in free]), np.zeros(len(free))
    threshold = np.inf
    parts: dict[tuple[int, int], float] = {}
    for k in free:
        points = [end.point for ends in stands[k].values() for end in ends]
        for side in (-1.0, 1.0):
            edge = max(points, key=lambda point: side * point[0])
            whole = _part(placed, stands, k, max(free), edge, side, -np.inf)
            threshold = min(threshold, _lifts(placed, whole, edge, side))
            for last in whole:
                least = _lifts(placed, _part(placed, stands, k, last, edge, side, -np.inf), edge, side)
                # What rather holds a part down at this acceleration is left away, until nothing changes.
                while (less := _lifts(placed, _part(placed, stands, k, last, edge, side, least), edge, side)) < least:
                    least = less
                parts[k, last] = min(parts.get((k, last), np.inf), max(least, 0.0))
    return max(threshold, 0.0), np.array(list(parts)), np.array(list(parts.values()))


def _lifts(placed: list[PlacedElement], part: list[int], edge: tuple[float, float], side: float) -> float:
    """Horizontal acceleration over g at which a part starts to turn about an edge to a side."""
    mass = sum(placed[n].mass for n in part)
    x = sum(placed[n].mass * placed[n].x for n in part) / mass
    z = sum(placed[n].mass * placed[n].z for n in part) / mass
    return float(side * (edge[0] - x) / (z - edge[1]))


def _part(
    placed: list[PlacedElement],
    stands: Stands,
    root: int,
    last: int,
    edge: tuple[float, float],
    side: float,
    level: float,
) -> list[int]:
    """An element with what stands on it, up to the one listed last, that an acceleration (over g), `level`, helps turn.

    All of it where that is −infinity.
    """

    def grown(k: int) -> tuple[float, list[int]]:
        item, whole = placed[k], level == -np.inf
        held = 0.0 if whole else item.mass * (side * (edge[0] - item.x) - level * (item.z - edge[1]))
        part = [k]
        for moment, more in map(grown, (n for n in range(last + 1) if k in stands.get(n, ()))):
            if whole or moment < 0.0 or last in more:
                held, part = held + moment, part + more
        return held, part

    return sorted(grown(root)[1])
