"""What a scene at one size asks of the kernel: pairs, springs, rest, the stable step, thresholds."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.plan import DEEPEST
from overturning.dem.polygon.geometry import End, Placed, pairs_of, place
from overturning.dem.polygon.statics import Laws, Loaded, contact_laws, highest_modes, rest
from overturning.dem.scene import Scene


@dataclass(frozen=True)
class Prepared:
    """One variant of a scene, ready to run."""

    scene: Scene
    placed: list[Placed]
    pairs: list[tuple[int, int]]  # elements that can meet
    laws: Laws
    displacement: FloatArray  # shape (elements, 3): x, z (m) and rotation (rad) at rest, from the places
    springs: list[tuple[int, int, float]]  # loaded ends at rest: pair, end, stretch of the tangential spring (m)
    at_rest: bool  # whether the scene rests by itself
    square: float  # largest eigenvalue of the springs, 1/s²
    rate: float  # and of the dashpots, 1/s
    threshold: float  # horizontal acceleration over g below which nothing can start to rock; 0 where it is not known
    fixed_friction: float  # smallest of the loaded pairs that the scene itself sets; infinite where it sets none
    swept_friction: bool  # whether a loaded pair has the swept friction
    critical: FloatArray  # shape (elements,): α of each free element, rad; π/2 for others
    barrier: FloatArray  # shape (elements,): energy to overturn each free element, J
    support: NDArray[np.int64]  # shape (elements,): what each stands on; itself for the fixed ones
    base: FloatArray  # shape (elements, 2): middle of the stretch on which it stands, m
    radius: float  # largest distance of a centre from the farthest vertex below it, m, for the time after the record

    @property
    def sunk(self) -> FloatArray:
        """Static penetration of the pairs that carry weight, both ends alike, m."""
        loaded = self.laws.carried > 0.0
        return self.laws.carried[loaded] / (2.0 * self.laws.normal[loaded])

    @property
    def period(self) -> float:
        """1/p of the element that rocks fastest, s: p = √(3g/4R), R its farthest vertex."""
        square = min(float((self.placed[k].shape.vertices ** 2).sum(axis=1).max()) for k in self.free)
        return float(np.sqrt(np.sqrt(square) / (0.75 * self.scene.gravity)))

    @property
    def bears(self) -> bool:
        """Whether the contact law holds at rest: the weight alone presses no pair in farther than a case may go."""
        return bool(np.max(self.sunk, initial=0.0) <= deepest_allowed(self.placed))

    @property
    def free(self) -> NDArray[np.int64]:
        """Indices of the free elements."""
        return np.array([k for k, item in enumerate(self.placed) if not item.fixed], dtype=np.int64)


def prepare(scene: Scene, height: float | None = None, b_over_h: float | None = None) -> Prepared:
    """Prepare a scene whose reference element has a height (m) and slenderness; its own where they are not given."""
    placed = place(scene, height, b_over_h)
    pairs = pairs_of(placed)
    laws = contact_laws(scene, placed, pairs)
    equilibrium = rest(scene, placed, pairs, laws.normal, laws.tangential)
    displacement, loaded = equilibrium or (np.zeros((len(placed), 3)), [])
    stands = _stands(placed, pairs, loaded)
    critical, barrier, support, base = _single(scene, placed, stands)
    moves_alone = any(item.element.kind == "held" for item in placed)
    threshold = 0.0 if equilibrium is None or moves_alone else _threshold(placed, stands)
    frictions = [laws.friction[index] for index in {end.pair for end in loaded}]
    if any(
        laws.friction[k] >= 0 and laws.tangential[k] * abs(slip) > laws.friction[k] * laws.normal[k] * approach
        for k, _, _, approach, slip in loaded
    ):
        threshold = 0.0  # it slides by itself
    free = [item for item in placed if not item.fixed]
    top = max(float(item.points[:, 1].max()) for item in free)
    low = min(float(item.points[:, 1].min()) for item in free)
    wide = max(item.shape.width for item in free)
    square, rate = highest_modes(placed, pairs, laws)
    return Prepared(
        scene=scene,
        placed=placed,
        pairs=pairs,
        laws=laws,
        displacement=displacement,
        springs=[(end.pair, end.side, end.slip) for end in loaded],
        at_rest=equilibrium is not None,
        square=square,
        rate=rate,
        threshold=threshold,
        fixed_friction=min((mu for mu in frictions if mu >= 0), default=np.inf),
        swept_friction=any(mu < 0 for mu in frictions),
        critical=critical,
        barrier=barrier,
        support=support,
        base=base,
        radius=0.5 * float(np.sqrt((top - low) ** 2 + wide**2)),
    )


def deepest_allowed(placed: list[Placed]) -> float:
    """Penetration beyond which the contact law no longer holds, m."""
    return DEEPEST * 0.5 * min(item.size for item in placed if not item.fixed)


Stands = dict[int, dict[int, list[End]]]


def _stands(placed: list[Placed], pairs: list[tuple[int, int]], loaded: list[Loaded]) -> Stands:
    """Of each free element: what carries it, with the loaded ends."""
    result: Stands = {}
    for index, _, end, _, _ in loaded:
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
        while more := {upper for upper, lowers in stands.items() if set(lowers) & part} - part:
            part |= more
        mass = sum(placed[n].mass for n in part)
        x = sum(placed[n].mass * placed[n].x for n in part) / mass
        z = sum(placed[n].mass * placed[n].z for n in part) / mass
        points = [end.point for ends in below.values() for end in ends]
        for side in (-1.0, 1.0):
            edge = max(points, key=lambda point: side * point[0])
            least = min(least, side * (edge[0] - x) / (z - edge[1]))
    return max(float(least), 0.0)
