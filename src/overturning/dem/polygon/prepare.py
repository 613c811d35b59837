"""From a scene to the kernel's arrays: pairs, springs, the column at rest, the stable step, thresholds and rules."""

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.dem.cases import DEEPEST
from overturning.dem.polygon import tables as t
from overturning.dem.polygon.geometry import End, Placed, common_stretch, pairs_of, place
from overturning.dem.polygon.scene import Scene
from overturning.dem.polygon.statics import Laws, contact_laws, highest_modes, rest

FloatArray = NDArray[np.float64]

WIDE: Final = 20.0
"""Width of the ground, in widths or heights of the block, that is more than any slide."""

CALM_KINETIC: Final = 1e-9
"""Kinetic energy at rest, as a share of m g times the half of the smallest side of the lightest element."""


FLAT: Final = round(0.999 * 0.5 * np.pi, 12)
"""An element that lies on its side has turned by 90° less what its contacts give way, rad."""


@dataclass(frozen=True)
class Prepared:
    """One variant of a scene, ready to run.

    Attributes
    ----------
    placed : list of Placed
        Elements in their places.
    pairs : list of tuple of int
        Pairs that can meet, as indices of elements.
    laws : Laws
        Their contact laws.
    displacement : ndarray, shape (elements, 3)
        x, z and rotation at rest, from the places.
    springs : list of (pair, end, slip)
        Loaded ends at rest and the stretch of their tangential springs, m.
    at_rest : bool
        Whether the scene rests by itself.
    square, rate : float
        Largest eigenvalues of springs (1/s²) and dashpots (1/s).
    threshold : float
        Horizontal acceleration over g below which nothing can start to rock; 0 where it is not known.
    fixed_friction : float
        Smallest friction of the loaded pairs that the scene itself sets; infinite where it sets none.
    swept_friction : bool
        Whether a loaded pair has the swept friction.
    critical : ndarray, shape (elements,)
        α of each free element, rad; π/2 for others.
    barrier : ndarray, shape (elements,)
        Energy to overturn each free element, J.
    support : ndarray of int, shape (elements,)
        What each element stands on; itself for the fixed ones.
    base : ndarray, shape (elements, 2)
        Middle of the stretch on which it stands, m.
    radius : float
        Largest distance of a centre from the farthest vertex below it, for the time after the record, m.
    """

    scene: Scene
    placed: list[Placed]
    pairs: list[tuple[int, int]]
    laws: Laws
    displacement: FloatArray
    springs: list[tuple[int, int, float]]
    at_rest: bool
    square: float
    rate: float
    threshold: float
    fixed_friction: float
    swept_friction: bool
    critical: FloatArray
    barrier: FloatArray
    support: NDArray[np.int64]
    base: FloatArray
    radius: float

    @property
    def sunk(self) -> FloatArray:
        """Static penetration of the pairs that carry weight, both ends alike, m."""
        loaded = self.laws.carried > 0.0
        return self.laws.carried[loaded] / (2.0 * self.laws.normal[loaded])

    @property
    def bears(self) -> bool:
        """Whether the contact law holds at rest: the weight alone presses no pair in farther than a case may go."""
        return bool(np.max(self.sunk, initial=0.0) <= deepest_allowed(self.placed))

    @property
    def free(self) -> NDArray[np.int64]:
        """Indices of the free elements."""
        return np.array([k for k, item in enumerate(self.placed) if not item.fixed], dtype=np.int64)


def prepare(scene: Scene, height: float | None = None, b_over_h: float | None = None) -> Prepared:
    """Prepare one variant of a scene.

    Parameters
    ----------
    scene : Scene
        The scene.
    height, b_over_h : float, optional
        Height and slenderness of its reference element.

    Returns
    -------
    Prepared
    """
    placed = place(scene, height, b_over_h)
    pairs = pairs_of(placed)
    laws = contact_laws(scene, placed, pairs)
    found = rest(scene, placed, pairs, laws.normal, laws.tangential)
    displacement, loaded = (np.zeros((len(placed), 3)), []) if found is None else found
    springs = [(touch[0], touch[1], slip) for touch, _, slip in loaded]
    stands = _stands(placed, pairs, [(touch[0], touch[2]) for touch, _, _ in loaded])
    critical, barrier, support, base = _single(scene, placed, stands)
    moves_alone = any(item.element.kind == "held" for item in placed)
    threshold = 0.0 if found is None or moves_alone else _threshold(placed, stands)
    frictions = [laws.friction[index] for index in {touch[0] for touch, _, _ in loaded}]
    if any(mu >= 0 and _slips(loaded, laws, index) for index, mu in enumerate(laws.friction)):
        threshold = 0.0
    top = max(float(item.points[:, 1].max()) for item in placed if not item.fixed)
    low = min(float(item.points[:, 1].min()) for item in placed if not item.fixed)
    wide = max(item.shape.width for item in placed if not item.fixed)
    return Prepared(
        scene,
        placed,
        pairs,
        laws,
        displacement,
        springs,
        found is not None,
        *highest_modes(placed, pairs, laws),
        threshold,
        min((mu for mu in frictions if mu >= 0), default=np.inf),
        any(mu < 0 for mu in frictions),
        critical,
        barrier,
        support,
        base,
        0.5 * float(np.sqrt((top - low) ** 2 + wide**2)),
    )


def deepest_allowed(placed: list[Placed]) -> float:
    """Penetration beyond which the contact law no longer holds, m."""
    return DEEPEST * 0.5 * min(item.size for item in placed if not item.fixed)


def _slips(loaded: list[tuple[tuple[int, int, End], float, float]], laws: Laws, index: int) -> bool:
    mu = laws.friction[index]
    return any(
        touch[0] == index and laws.tangential[index] * abs(slip) > mu * laws.normal[index] * approach
        for touch, approach, slip in loaded
    )


Stands = dict[int, dict[int, list[End]]]


def _stands(placed: list[Placed], pairs: list[tuple[int, int]], loaded: list[tuple[int, End]]) -> Stands:
    """Of each free element: what carries it, with the loaded ends."""
    result: Stands = {}
    for index, end in loaded:
        i, j = pairs[index]
        upper, lower = (i, j) if end.normal[1] > 0 else (j, i)
        if not placed[upper].fixed and abs(end.normal[1]) > 1e-3:
            result.setdefault(upper, {}).setdefault(lower, []).append(end)
    return result


def _single(
    scene: Scene, placed: list[Placed], stands: Stands
) -> tuple[FloatArray, FloatArray, NDArray[np.int64], FloatArray]:
    count = len(placed)
    critical, barrier = np.full(count, 0.5 * np.pi), np.zeros(count)
    support, base = np.arange(count), np.array([[item.x, item.z] for item in placed])
    for k, item in enumerate(placed):
        if item.fixed:
            continue
        ends = [(lower, end.point) for lower, all_ends in stands.get(k, {}).items() for end in all_ends]
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
        critical[k] = max(min(reach), 1e-6)
        barrier[k] = item.mass * scene.gravity * max(min(lift), 1e-9 * item.size)
    return critical, barrier, support, base


def _threshold(placed: list[Placed], stands: Stands) -> float:
    """Least horizontal acceleration over g at which some part of the scene above an interface starts to rock.

    The part above an interface is the element that stands on it with all that it carries, directly or not. It lifts
    off when the resultant of weight and inertia leaves the interface: |a|/g > arm / height of the common centre.
    """
    least = np.inf
    for k, item in enumerate(placed):
        if item.fixed:
            continue
        below = stands.get(k, {})
        if len(below) != 1:
            return 0.0  # bridges and leaning elements: no closed form here, so nothing is left out
        part = {k}
        while True:
            more = {upper for upper, lowers in stands.items() if set(lowers) & part} - part
            if not more:
                break
            part |= more
        mass = sum(placed[n].mass for n in part)
        x = sum(placed[n].mass * placed[n].x for n in part) / mass
        z = sum(placed[n].mass * placed[n].z for n in part) / mass
        points = [end.point for ends in below.values() for end in ends]
        for side in (-1.0, 1.0):
            edge = max(points, key=lambda point: side * point[0])
            least = min(least, side * (edge[0] - x) / (z - edge[1]))
    return max(float(least), 0.0)


def kernel_column(prepared: Prepared) -> FloatArray:
    """The rows of a column at rest, as the kernel wants them, shape (rows,)."""
    from overturning.dem.polygon import columns as k

    placed = prepared.placed
    rows = np.zeros(k.OWN + len(placed) * k.BODY + len(prepared.pairs) * k.PAIR)

    def put(base: int, name: int, value: float) -> None:
        rows[base + name // k.COLUMNS] = value

    for index, item in enumerate(placed):
        at = k.OWN + index * k.BODY
        dx, dz, turn = prepared.displacement[index]
        # The pair that is turned keeps length 1 to the last digit for the minute rotations of a scene at rest.
        put(at, k.X, item.x + dx)
        put(at, k.Z, item.z + dz)
        put(at, k.ANGLE, turn)
        put(at, k.COS, 1.0 - 0.5 * turn * turn)
        put(at, k.SIN, turn * (1.0 - turn * turn / 6.0))
        if not item.fixed:
            put(at, k.INVERSE_MASS, 1.0 / item.mass)
            put(at, k.INVERSE_INERTIA, 1.0 / item.inertia)
            put(at, k.MASS, item.mass)
            put(at, k.WEIGHT, 1.0)
        put(at, k.FRAME, 0.0 if item.element.kind == "driven" else 1.0)
        put(at, k.HELD, 1.0 if item.element.kind == "held" else 0.0)
        put(at, k.CRITICAL, float(prepared.critical[index]))
        put(at, k.PEAK_ANGLE, abs(turn))
        put(at, k.LAST_UPRIGHT, -1.0)
        support, (x, z) = placed[prepared.support[index]], prepared.base[index]
        for name, value in zip(
            (k.BASE_X, k.BASE_Z, k.SUPPORT_X, k.SUPPORT_Z),
            (x - item.x, z - item.z, x - support.x, z - support.z),
            strict=True,
        ):
            put(at, name, value)
    laws = prepared.laws
    for index in range(len(prepared.pairs)):
        at = k.OWN + len(placed) * k.BODY + index * k.PAIR
        put(at, k.KN, float(laws.normal[index]))
        put(at, k.KS, float(laws.tangential[index]))
        put(at, k.COMPLIANCE, float(1.0 / laws.tangential[index]) if laws.tangential[index] > 0 else 0.0)
        put(at, k.DASHPOT, float(laws.dashpot[index]))
        put(at, k.FRICTION, float(laws.friction[index]))
        put(at, k.REACH, -1.0)
        put(at, k.FACE_A, -1.0)
        put(at, k.FACE_B, -1.0)
        put(at, k.LIMIT, np.inf if rests_on_one_face(placed) else 0.0)
    for index, side, slip in prepared.springs:
        at = k.OWN + len(placed) * k.BODY + index * k.PAIR
        put(at, k.SPRING + side * k.SECOND, slip)
        i, j = prepared.pairs[index]
        mine = _is_first(placed[i], placed[j], side)
        put(at, k.CONTACT + side * k.SECOND, k.MINE if mine else k.THEIRS)
    return rows


def rests_on_one_face(placed: list[Placed]) -> bool:
    """Whether the first nearest faces stay so until the case ends: one upright rectangle on a wide driven one.

    Its lower corners alone can touch the ground until it lies on its side, and then it has fallen.
    """
    if len(placed) != 2:
        return False
    ground, block = placed
    rectangles = all(item.element.vertices is None and item.element.rotation_deg == 0 for item in placed)
    return (
        rectangles
        and ground.element.kind == "driven"
        and block.element.kind == "free"
        and block.element.fallen_rotation_deg <= 90
        and abs(float(block.points[:, 1].min() - ground.points[:, 1].max())) <= 1e-9 * block.size
        and ground.shape.width > WIDE * max(block.shape.width, block.shape.height) + 2.0 * abs(block.x - ground.x)
    )


def _is_first(a: Placed, b: Placed, side: int) -> bool:
    """Whether the vertex of an end is the first element's."""
    point = common_stretch(a, b)[side].point
    return bool(min(np.hypot(x - point[0], z - point[1]) for x, z in a.points) < 1e-9 * a.size)


def kernel_shapes(prepared: Prepared) -> tuple[NDArray[np.int64], FloatArray]:
    """Numbers of vertices, shape (elements,), and faces, shape (elements, most vertices, 9)."""
    sizes = np.array([len(item.shape.vertices) for item in prepared.placed], dtype=np.int64)
    shapes = np.zeros((len(sizes), int(sizes.max()), 9))
    for index, item in enumerate(prepared.placed):
        shapes[index, : sizes[index]] = item.shape.faces()
    return sizes, shapes


def fallen_angle(fallen_rotation_deg: float) -> float:
    """Rotation at which an element counts as fallen, rad: that of its scene, `FLAT` for 90°."""
    return FLAT if fallen_rotation_deg == 90.0 else round(float(np.radians(fallen_rotation_deg)), 12)


def kernel_rules(prepared: Prepared) -> tuple[FloatArray, FloatArray]:
    """When elements have fallen, shape (elements, RULES), and when a case has failed or rests, shape (LIMITS,)."""
    rules = np.zeros((len(prepared.placed), t.RULES))
    free = [item for item in prepared.placed if not item.fixed]
    for index, item in enumerate(prepared.placed):
        drop = item.element.fallen_drop
        rules[index, t.IS_FREE] = 0.0 if item.fixed else 1.0
        rules[index, t.FALL_ANGLE] = fallen_angle(item.element.fallen_rotation_deg)
        rules[index, t.LOWEST] = -np.inf if drop is None else item.z - drop
        rules[index, t.SUPPORT] = prepared.support[index]
        rules[index, t.BARRIER] = prepared.barrier[index]
    lightest = min(free, key=lambda item: item.mass)
    limits = np.zeros(t.LIMITS)
    limits[t.DEEPEST_ALLOWED] = deepest_allowed(prepared.placed)
    limits[t.REST_ENERGY] = CALM_KINETIC * lightest.mass * prepared.scene.gravity * 0.5 * lightest.size
    limits[t.LEAST_BARRIER] = min(float(prepared.barrier[n]) for n in prepared.free)
    return rules, limits
