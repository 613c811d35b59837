"""What each contact carries at rest, how the scene sinks into its springs, and how fast it can vibrate."""

from dataclasses import dataclass, replace
from itertools import combinations
from typing import Final, NamedTuple

import numpy as np

from overturning.arrays import FloatArray
from overturning.dem.linear import highest_eigenvalue, lowest_eigenvalue, solve
from overturning.model.contact import DAMPING_RATIO
from overturning.model.geometry import ElementPair, PlacedElement, StretchEnd, TouchingEnd, touching_ends
from overturning.model.scene import Scene

FLUSH: Final = np.radians(0.1)
"""What leans by less stands on its face, where its tipping angle is concerned, rad."""


BOTH: Final = 2
"""Ends of a face that stands flush."""


class Loaded(NamedTuple):
    """An end that carries something at rest: its pair, which of the two ends it is, and its springs' stretches, m."""

    pair: int
    side: int
    end: StretchEnd
    approach: float
    slip: float


class Joint(NamedTuple):
    """An end that touches, and how its normal approach and its slip depend on all displacements, shape (3 · free,)."""

    touch: TouchingEnd
    approach: FloatArray
    slip: FloatArray


@dataclass(frozen=True)
class Laws:
    """Contact constants of each pair at each end, shape (pairs,)."""

    normal: FloatArray  # K_n, N/m
    tangential: FloatArray  # K_s, N/m
    dashpot: FloatArray  # h, N·s/m, in both directions
    friction: FloatArray  # µ; −1 where it is the one that is swept
    carried: FloatArray  # weight at rest, N


def _numbers(placed: list[PlacedElement]) -> dict[int, slice]:
    """Where the displacements (x, z, clockwise rotation) of each free element stand among those of all."""
    free = [i for i, item in enumerate(placed) if not item.fixed]
    return {i: slice(3 * n, 3 * n + 3) for n, i in enumerate(free)}


def joints_of(placed: list[PlacedElement], pairs: list[ElementPair], lean: float = 0.0) -> list[Joint]:
    """The ends that touch; `lean` as in `overturning.model.geometry.resting`."""
    return _joints(placed, pairs, touching_ends(placed, pairs, lean))


def _joints(placed: list[PlacedElement], pairs: list[ElementPair], ends: list[TouchingEnd]) -> list[Joint]:
    return [Joint(touch, *_stretches(placed, pairs[touch.pair], touch.end)) for touch in ends]


def bearing_ends(
    scene: Scene, placed: list[PlacedElement], pairs: list[ElementPair], joints: list[Joint], loaded: list[Loaded]
) -> list[Loaded]:
    """Return the ends by which elements stand: the `loaded` ones, with a lean of less than `FLUSH` taken as none.

    Without that, a lean of a millionth would leave the whole scene without a rest, and without tipping angles. An
    element that leans by more is left out where it keeps the others from resting.
    """
    flush = joints_of(placed, pairs, FLUSH)
    if len(flush) == len(joints) and (loaded or not joints):
        return loaded
    upper = [pairs[pair].a if end.normal[1] > 0 else pairs[pair].b for (pair, _, end), _, _ in flush]
    leaning = {k for k, item in enumerate(placed) if not item.fixed and upper.count(k) < BOTH}
    held = [
        replace(item, element=item.element.model_copy(update={"kind": "held"})) if k in leaning else item
        for k, item in enumerate(placed)
    ]
    ones = np.ones(len(pairs))
    # A wall beside what leans carries none of its weight: without friction on faces where it has to be.
    for items, tangential in ((placed, ones), (placed, 0.0 * ones), (held, ones)):
        free = {k for k, item in enumerate(items) if not item.fixed}
        ends = [joint.touch for joint in flush if free.intersection(pairs[joint.touch.pair][:2])]
        found = rest(scene, items, _joints(items, pairs, ends), ones, tangential) if free else None
        if found is not None:
            return found[1]
    return []


def _stretches(placed: list[PlacedElement], pair: ElementPair, end: StretchEnd) -> tuple[FloatArray, FloatArray]:
    number = _numbers(placed)
    approach, slip = np.zeros(3 * len(number)), np.zeros(3 * len(number))
    for k, sign in ((pair.a, 1.0), (pair.b, -1.0)):
        if k in number:
            rx, rz = end.point[0] - placed[k].x, end.point[1] - placed[k].z
            for row, (ux, uz), direction in ((approach, end.normal, -1.0), (slip, end.tangent, 1.0)):
                row[number[k]] = sign * direction * np.array([ux, uz, ux * rz - uz * rx])
    return approach, slip


def _stiffness(size: int, joints: list[Joint], normal: FloatArray, tangential: FloatArray) -> FloatArray:
    matrix = np.zeros((size, size))
    for touch, approach, slip in joints:
        matrix += normal[touch.pair] * np.outer(approach, approach) + tangential[touch.pair] * np.outer(slip, slip)
    return matrix


def rest(
    scene: Scene, placed: list[PlacedElement], joints: list[Joint], normal: FloatArray, tangential: FloatArray
) -> tuple[FloatArray, list[Loaded]] | None:
    """Static equilibrium on the springs of the contacts (N/m of each pair), without tension.

    Displacements of the elements, shape (elements, 3), m and rad, and the loaded ends; None where the scene cannot
    rest: something slides off or falls by itself.
    """
    # Without friction a tangential spring would hold for a moment only; a minute one keeps the system regular.
    held, joints = np.maximum(tangential, 1e-9 * normal), joints.copy()
    number = _numbers(placed)
    load = np.concatenate([(0.0, -placed[k].mass * scene.gravity, 0.0) for k in number])
    while joints:
        solution = solve(_stiffness(load.size, joints, normal, held), load)
        if solution is None:
            return None
        ends = [
            Loaded(*touch, float((approach * solution).sum()), float((slip * solution).sum()))
            for touch, approach, slip in joints
        ]
        least = min(ends, key=lambda end: end.approach)
        if least.approach > 1e-9 * max(end.approach for end in ends):
            displacement = np.zeros((len(placed), 3))
            for k, at in number.items():
                displacement[k] = solution[at]
            return displacement, ends
        del joints[ends.index(least)]  # it is pulled
    return None


def contact_laws(scene: Scene, placed: list[PlacedElement], pairs: list[ElementPair], joints: list[Joint]) -> Laws:
    """Springs, dashpots and friction of each pair; stiffness auto from the weight that the pair carries at rest.

    A pair that carries weight W over a common stretch of width B sinks in by δ = W/(2 K_n), a stated share of B. A
    pair that does not touch at rest has the spring of its lighter free element standing on its smaller side.
    """
    ones = np.ones(len(pairs))
    equilibrium = rest(scene, placed, joints, ones, ones)
    whole = [pair[:2] for pair in pairs]
    together = np.array([whole.index(both) for both in whole], dtype=np.int64)  # all pieces of two elements
    carried, width = np.zeros(len(pairs)), np.zeros(len(pairs))
    for end in equilibrium[1] if equilibrium is not None else ():
        carried[together[end.pair]] += end.approach
    for one, other in combinations((joint.touch for joint in joints), 2):
        if together[one.pair] == together[other.pair]:
            (x, z), (u, w) = one.end.point, other.end.point
            apart = np.sqrt((x - u) ** 2 + (z - w) ** 2)  # libm's hypot depends on the processor
            width[together[one.pair]] = max(width[together[one.pair]], apart)
    carried, width = carried[together], width[together]
    normal, tangential, dashpot, friction = (np.zeros(len(pairs)) for _ in range(4))
    for index, pair in enumerate(pairs):
        a, b = placed[pair.a], placed[pair.b]
        law = scene.law(a.element, b.element)
        free = [item for item in (a, b) if not item.fixed]
        depth = min(a.element.depth, b.element.depth)
        lightest = min(free, key=lambda item: item.mass)
        weight = carried[index]
        # A contact that carries next to nothing must still stop a blow.
        if weight < 0.01 * lightest.mass * scene.gravity:
            weight = lightest.mass * scene.gravity
        stretch = width[index] if width[index] > 0.01 * lightest.size else lightest.size
        if law.stiffness == "auto":
            normal[index] = weight / (2.0 * law.static_penetration * stretch)
        else:
            normal[index] = law.stiffness * depth
        tangential[index] = law.stiffness_ratio * normal[index]
        if law.damping is not None:
            dashpot[index] = law.damping * depth
        else:
            ratio = DAMPING_RATIO if law.damping_ratio is None else law.damping_ratio
            dashpot[index] = 2.0 * ratio * np.sqrt(0.5 * normal[index] * (weight / scene.gravity))
        friction[index] = -1.0 if law.friction is None else law.friction
    return Laws(normal, tangential, dashpot, friction, carried)


def highest_modes(
    placed: list[PlacedElement], pairs: list[ElementPair], joints: list[Joint], laws: Laws
) -> tuple[float, float]:
    """Largest eigenvalues of springs (ω², 1/s²) and of dashpots (1/s), as `overturning.dem.time_step` takes them.

    The larger of those of the scene at rest and of each pair on a single vertex at the farthest lever, K (1/m + r²/I)
    summed over both elements; for a rectangle on a fixed one the latter is 4 K/m.
    """
    root, values = _over_masses(placed), []
    for normal, tangential in ((laws.normal, laws.tangential), (laws.dashpot, laws.dashpot)):
        matrix = _stiffness(root.size, joints, normal, tangential)
        highest = highest_eigenvalue(root[:, None] * matrix * root)
        for index, pair in enumerate(pairs):
            compliance = 0.0
            for item in (placed[k] for k in pair[:2] if not placed[k].fixed):
                radius = float((item.shape.vertices**2).sum(axis=1).max())
                compliance += 1.0 / item.mass + radius / item.inertia
            highest = max(highest, max(normal[index], tangential[index]) * compliance)
        values.append(float(highest))
    return values[0], values[1]


def slowest_mode(placed: list[PlacedElement], joints: list[Joint], laws: Laws) -> float:
    """Smallest eigenvalue of the scene at rest on its springs, 1/s²; 0 where something can move without force."""
    root = _over_masses(placed)
    matrix = _stiffness(root.size, joints, laws.normal, laws.tangential)
    return lowest_eigenvalue(root[:, None] * matrix * root)


def _over_masses(placed: list[PlacedElement]) -> FloatArray:
    """1 over the roots of masses and moments of inertia, by displacements."""
    free = [item for item in placed if not item.fixed]
    return np.sqrt(np.concatenate([(1.0 / item.mass, 1.0 / item.mass, 1.0 / item.inertia) for item in free]))
