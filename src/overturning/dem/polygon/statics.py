"""What each contact carries at rest, how the scene sinks into its springs, and how fast it can vibrate."""

from dataclasses import dataclass

import numpy as np

from overturning.arrays import FloatArray
from overturning.dem.polygon.geometry import End, Placed, resting
from overturning.dem.polygon.linear import highest_eigenvalue, solve
from overturning.dem.scene import Scene

Touch = tuple[int, int, End]


@dataclass(frozen=True)
class Laws:
    """Contact law of each pair.

    Attributes
    ----------
    normal, tangential : ndarray, shape (pairs,)
        K_n and K_s, N/m.
    dashpot : ndarray, shape (pairs,)
        h, N·s/m, in both directions.
    friction : ndarray, shape (pairs,)
        µ; −1 where it is the one that is swept.
    carried : ndarray, shape (pairs,)
        Weight that each pair carries at rest, N.
    """

    normal: FloatArray
    tangential: FloatArray
    dashpot: FloatArray
    friction: FloatArray
    carried: FloatArray


def _numbers(placed: list[Placed]) -> dict[int, int]:
    return {i: 3 * n for n, i in enumerate(k for k, item in enumerate(placed) if not item.fixed)}


def _stretches(placed: list[Placed], pairs: list[tuple[int, int]], touch: Touch) -> tuple[FloatArray, FloatArray]:
    """How the normal approach and the slip of an end depend on all displacements (x, z, clockwise rotation)."""
    number = _numbers(placed)
    approach, slip = np.zeros(3 * len(number)), np.zeros(3 * len(number))
    index, _, end = touch
    for k, sign in ((pairs[index][0], 1.0), (pairs[index][1], -1.0)):
        if placed[k].fixed:
            continue
        rx, rz = end.point[0] - placed[k].x, end.point[1] - placed[k].z
        at = number[k]
        for row, (ux, uz), direction in ((approach, end.normal, -1.0), (slip, end.tangent, 1.0)):
            row[at : at + 3] = sign * direction * np.array([ux, uz, ux * rz - uz * rx])
    return approach, slip


def _stiffness(
    placed: list[Placed], pairs: list[tuple[int, int]], touches: list[Touch], normal: FloatArray, tangential: FloatArray
) -> FloatArray:
    size = 3 * len(_numbers(placed))
    matrix = np.zeros((size, size))
    for touch in touches:
        approach, slip = _stretches(placed, pairs, touch)
        matrix += normal[touch[0]] * np.outer(approach, approach) + tangential[touch[0]] * np.outer(slip, slip)
    return matrix


def _load(scene: Scene, placed: list[Placed]) -> FloatArray:
    load = np.zeros(3 * len(_numbers(placed)))
    for k, at in _numbers(placed).items():
        load[at + 1] = -placed[k].mass * scene.gravity
    return load


def rest(
    scene: Scene,
    placed: list[Placed],
    pairs: list[tuple[int, int]],
    normal: FloatArray,
    tangential: FloatArray,
) -> tuple[FloatArray, list[tuple[Touch, float, float]]] | None:
    """Static equilibrium on the springs of the contacts, without tension.

    Parameters
    ----------
    scene, placed, pairs
        The scene.
    normal, tangential : ndarray, shape (pairs,)
        Springs, N/m.

    Returns
    -------
    displacement : ndarray, shape (elements, 3)
        x, z and rotation of each element, m and rad.
    ends : list of (touch, approach, slip)
        Loaded ends with their springs' stretches, m.
        The whole is None where the scene cannot rest: something slides off or falls by itself.
    """
    touches = resting(placed, pairs)
    # Without friction a tangential spring would hold for a moment only; a minute one keeps the system regular.
    held = np.maximum(tangential, 1e-9 * normal)
    while touches:
        solution = solve(_stiffness(placed, pairs, touches, normal, held), _load(scene, placed))
        if solution is None:
            return None
        ends = []
        for touch in touches:
            approach, slip = _stretches(placed, pairs, touch)
            ends.append((touch, float((approach * solution).sum()), float((slip * solution).sum())))
        pulled = [item for item in ends if item[1] <= 1e-9 * max(other[1] for other in ends)]
        if not pulled:
            displacement = np.zeros((len(placed), 3))
            for k, at in _numbers(placed).items():
                displacement[k] = solution[at : at + 3]
            return displacement, ends
        weakest = min(pulled, key=lambda item: item[1])
        touches = [touch for touch in touches if touch is not weakest[0]]
    return None


def contact_laws(scene: Scene, placed: list[Placed], pairs: list[tuple[int, int]]) -> Laws:
    """Springs, dashpots and friction of each pair; stiffness auto from the weight that the pair carries at rest.

    A pair that carries weight W over a common stretch of width B sinks in by δ = W/(2 K_n), a stated share of B. A
    pair that does not touch at rest has the spring of its lighter free element standing on its smaller side.
    """
    ones = np.ones(len(pairs))
    equilibrium = rest(scene, placed, pairs, ones, ones)
    carried = np.zeros(len(pairs))
    if equilibrium is not None:
        for touch, approach, _ in equilibrium[1]:
            carried[touch[0]] += approach
    width = np.full(len(pairs), np.nan)
    points: dict[int, list[tuple[float, float]]] = {}
    for index, _, end in resting(placed, pairs):
        points.setdefault(index, []).append(end.point)
    for index, ends in points.items():
        if len(ends) == 2:
            # np.hypot is libm's, whose last digit depends on the processor.
            width[index] = np.sqrt((ends[0][0] - ends[1][0]) ** 2 + (ends[0][1] - ends[1][1]) ** 2)
    normal, tangential, dashpot, friction = (np.zeros(len(pairs)) for _ in range(4))
    for index, (i, j) in enumerate(pairs):
        a, b = placed[i], placed[j]
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
            assert law.static_penetration is not None  # `Scene.law` gives it
            normal[index] = weight / (2.0 * law.static_penetration * stretch)
        else:
            normal[index] = law.stiffness * depth
        tangential[index] = law.stiffness_ratio * normal[index]
        if law.damping is not None:
            dashpot[index] = law.damping * depth
        else:
            ratio = 1.0 if law.damping_ratio is None else law.damping_ratio
            dashpot[index] = 2.0 * ratio * np.sqrt(0.5 * normal[index] * (weight / scene.gravity))
        friction[index] = -1.0 if law.friction is None else law.friction
    return Laws(normal, tangential, dashpot, friction, carried)


def highest_modes(placed: list[Placed], pairs: list[tuple[int, int]], laws: Laws) -> tuple[float, float]:
    """Largest eigenvalues of springs (ω², 1/s²) and of dashpots (1/s), as `overturning.dem.time_step` takes them.

    The larger of those of the scene at rest and of each pair on a single vertex at the farthest lever, K (1/m + r²/I)
    summed over both elements; for a rectangle on a fixed one the latter is 4 K/m.
    """
    touches = resting(placed, pairs)
    inverse = np.zeros(3 * len(_numbers(placed)))
    for k, at in _numbers(placed).items():
        inverse[at : at + 3] = 1.0 / placed[k].mass, 1.0 / placed[k].mass, 1.0 / placed[k].inertia
    root = np.sqrt(inverse)
    values = []
    for normal, tangential in ((laws.normal, laws.tangential), (laws.dashpot, laws.dashpot)):
        matrix = _stiffness(placed, pairs, touches, normal, tangential)
        highest = highest_eigenvalue(root[:, None] * matrix * root)
        for index, pair in enumerate(pairs):
            compliance = 0.0
            for item in (placed[k] for k in pair):
                if not item.fixed:
                    radius = float((item.shape.vertices**2).sum(axis=1).max())
                    compliance += 1.0 / item.mass + radius / item.inertia
            highest = max(highest, max(normal[index], tangential[index]) * compliance)
        values.append(highest)
    square, rate = values
    return float(square), float(rate)
