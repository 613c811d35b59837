"""Whether an answer of the map holds, by checks that share no rule with the kernels.

An element of a scene has fallen for good where it can rest on another face, a rectangle at 90°. An overdamped stone
that falls on its side creeps towards that angle and need not reach it. One that ends past its tipping angle, that has
dropped or that has lost its support has fallen too. So there are two angles, between which both answers are right: what
has turned farther than `lies_from` has fallen, what has turned less than `falls_from` has not.
"""

from collections.abc import Sequence
from enum import IntEnum
from itertools import combinations
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.kernel.balance import ENERGY_BOUND
from overturning.dem.limits import MAX_PENETRATION
from overturning.dem.polygon.prepare import Prepared
from overturning.model.geometry import PlacedElement
from overturning.model.results import Results
from overturning.model.status import Status
from overturning.model.variables import INT8_MISSING
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY
from verification.stability.cases import StabilityCase

LEVEL: Final = 0.5 * np.pi
"""Rotation that brings an upright face down, rad."""

ROUNDING: Final = 1e-6
"""Of a rotation that is kept as a share of the critical angle in single precision."""

SMALL_SLIDE: Final = 1e-9
"""Slip that a block at rest may show, per metre of its size: rounding."""


class Ending(IntEnum):
    """How a case of the map ends."""

    RIGHT = 0
    """Computed, and every check holds."""
    AT_REST = 1
    """Left out, and below both thresholds for the whole motion by an independent look at the motion."""
    UNDECIDED = 2
    UNSTABLE = 3
    FAILED = 4
    OVER_BUDGET = 5
    REFUSED = 6
    """An error that names the argument."""
    SILENT = 7
    """A flag that a check contradicts. There must be none."""


class Bounds(NamedTuple):
    """What a case can do, worked out from shapes, contacts and motion alone."""

    sunk: float
    """Largest static penetration, m,"""
    size: float
    """the smallest side of an element, m, on which the penetration that the contact law allows depends,"""
    width: float
    """and the length beside which the static penetration of a stiff contact is small, m."""
    demand: float
    """Largest horizontal over vertical acceleration of the motion."""
    rests: float
    """Demand up to which nothing moves."""
    stands: float
    """Demand below which nothing falls while contacts are stiff."""
    slides: float = np.inf
    """Slip above which it has moved without motion, m."""


def contradiction(bounds: Bounds, found: Results, row: int, fits: bool) -> str:
    """The first check that an answer does not hold; empty where all hold.

    A marked case must have no flag. A flag must come with energy balance, bounded penetration, finite numbers, and
    agree with what rigid elements under this motion can do: below both thresholds they neither fall nor slide. Whether
    its flags go with its rotations is given as `fits`.
    """
    limit = MAX_PENETRATION * 0.5 * bounds.size
    if found.status[row] not in (Status.SIMULATED, Status.AT_REST):
        return "" if np.all(found.overturned[row] == INT8_MISSING) else "flag in spite of the mark"
    if not np.isin(found.overturned[row], (-1, 0, 1)).all():
        return "no flag and no mark"
    numbers = (found.energy_error, found.peak_penetration, found.peak_rotation, found.peak_slip, found.residual_slip)
    if not all(np.isfinite(values[row]).all() for values in numbers):
        return "a number is not finite"
    if bounds.sunk > limit or found.peak_penetration[row] > limit * (1 + 1e-6):
        return "penetration"
    if found.energy_error[row] > ENERGY_BOUND:
        return "energy balance"
    fallen = found.overturned[row] != 0
    if not fits:
        return "flag and rotation"
    if np.any(np.isfinite(found.overturning_time[row]) != fallen):
        return "flag and time"
    if found.status[row] == Status.AT_REST and bounds.demand > bounds.rests:
        return "left out above a threshold"
    if bounds.demand == 0.0 and np.any(fallen | (found.peak_slip[row] > bounds.slides)):
        return "moved without motion"
    if np.any(fallen) and bounds.demand < 0.2 * bounds.stands and bounds.sunk < 1e-4 * bounds.width:
        return "fell below the threshold of rocking"
    return ""


def demand_of(motion: Motion) -> float:
    """Largest abs(a)/(g + a_up) of the motion, towards north; infinite where the ground falls faster than the block."""
    weight = STANDARD_GRAVITY + (np.zeros(motion.samples) if motion.up is None else motion.up)
    if (weight <= 0).any():
        return float("inf")
    return float(np.max(np.abs(motion.north) / weight))


def static_penetration(case: StabilityCase) -> float:
    """Static penetration δ = m g/(2 K_n), m."""
    return case.density * case.b_over_h * case.height**2 * STANDARD_GRAVITY / (2.0 * case.stiffness)


def block_contradiction(case: StabilityCase, motion: Motion, found: Results) -> str:
    """`contradiction` of a block; a fall below the threshold counts only of one that slides long before it rocks."""
    width, ratio = case.b_over_h * case.height, case.b_over_h
    stands = ratio if case.friction < 0.5 * ratio else 0.0
    bounds = Bounds(
        static_penetration(case), min(width, case.height), width, demand_of(motion), min(ratio, case.friction), stands,
        SMALL_SLIDE * (width + case.height),
    )  # fmt: skip
    lies = found.peak_rotation[0] * np.arctan(ratio) >= LEVEL * (1 - ROUNDING)
    return contradiction(bounds, found, 0, bool((found.overturned[0] != 0) == lies))


def scene_contradiction(prepared: Prepared, friction: float, motion: Motion, found: Results, row: int = 0) -> str:
    """`contradiction` of a case of a scene at its size, with μ of all contacts, under the case's own motion."""
    size = min(item.size for item in prepared.placed if not item.fixed)
    bound = min(rocking_bound(prepared.placed), friction)
    bounds = Bounds(deepest_at_rest(prepared), size, size, demand_of(motion), bound * (1 + 1e-9), bound)
    turned = found.peak_rotation[row] * prepared.rotation_unit[prepared.free]
    return contradiction(bounds, found, row, flags_fit(prepared, np.atleast_1d(found.overturned[row]) != 0, turned))


def deepest_at_rest(prepared: Prepared) -> float:
    """Largest static penetration, m: the weight that a pair carries, on both of its ends."""
    return float(np.max(prepared.laws.carried / (2.0 * prepared.laws.normal), initial=0.0))


def rocking_bound(placed: Sequence[PlacedElement]) -> float:
    """Least |a|/(g + a_up) at which the rigid scene can start to rock: arm over height of each with all above it.

    Worked out from the shapes alone, for scenes in which each element stands in the middle of one other.
    """
    free = sorted((item for item in placed if not item.fixed), key=lambda item: item.z)
    least = np.inf
    for k, item in enumerate(free):
        above = free[k:]
        mass = sum(part.mass for part in above)
        x = sum(part.mass * part.x for part in above) / mass
        z = sum(part.mass * part.z for part in above) / mass
        level = item.points[:, 1].min()
        foot = item.points[item.points[:, 1] < level + 1e-9 * item.size][:, 0]
        if k > 0:
            below = free[k - 1].points
            top = below[below[:, 1] > level - 1e-6 * item.size][:, 0]
            foot = np.clip(foot, top.min(), top.max())
        least = min(least, (foot.max() - x) / (z - level), (x - foot.min()) / (z - level))
    return float(max(least, 0.0))


def flags_fit(prepared: Prepared, fallen: NDArray[np.bool_], rotation: FloatArray) -> bool:
    """Whether the flags of the free elements go with their largest absolute rotations, rad, cut at 90°."""
    early = fallen & (rotation < falls_from(prepared) - ROUNDING)
    missed = ~fallen & (rotation > lies_from(prepared) - ROUNDING)
    return not (early | missed).any()


def lies_from(prepared: Prepared) -> FloatArray:
    """Rotation from which each free element of a scene surely has fallen, whichever way it turned, rad.

    A stone that lies level on a face of length L presses both ends in by δ = m g/(2 K_n). With the near end in by δ
    the far end touches at asin(δ/L) before level: from there on the face bears on both ends. K_n is that of the
    softest contact that the element can make. An element whose scene asks for a rotation has fallen at that itself, but
    for 90° of one with an upright face. Results keep rotations up to 90° only; infinite where more is asked for.
    """
    angle = _asked(prepared)
    for place, index in enumerate(prepared.free):
        item = prepared.placed[index]
        # The longest face that this rotation brings down.
        length = max((length for turn, length in _faces(item) if abs(abs(turn) - angle[place]) < 1e-9), default=0.0)
        if length > 0.0:
            mine = [k for k, pair in enumerate(prepared.pairs) if index in pair[:2]]
            pressed = item.mass * STANDARD_GRAVITY / (2.0 * prepared.laws.normal[mine].min())
            angle[place] -= np.arcsin(min(pressed / length, 1.0))
    return np.where(angle > LEVEL, np.inf, angle)


def falls_from(prepared: Prepared) -> FloatArray:
    """Rotation below which no free element has fallen, rad: its tipping angle; 0 where it may lose its support."""
    found = []
    for index, asked in zip(prepared.free, _asked(prepared), strict=True):
        item = prepared.placed[index]
        on_ground = all(prepared.placed[k].fixed for k in prepared.carriers[index])
        x, z = item.shape.vertices.T
        base = x[z < z.min() + 1e-9 * item.size]
        tips = float(np.arctan2(min(base.max(), -base.min()), -z.min()))
        found.append(min(asked, tips, LEVEL) if on_ground and item.element.fallen_drop is None else 0.0)
    return np.array(found)


def _asked(prepared: Prepared) -> FloatArray:
    items = [prepared.placed[index] for index in prepared.free]
    asked = [item.element.fallen_rotation_deg for item in items]
    return np.array([
        max(_rests_at(item)) if angle is None else np.radians(angle) for item, angle in zip(items, asked, strict=True)
    ])  # fmt: skip


def _rests_at(item: PlacedElement) -> tuple[float, float]:
    """Least rotation either way, rad, at which an element can rest but as it stands: its centre is lowest there."""
    tilts = [angle for angle, _ in _faces(item)]
    stable = np.array(
        [angle for angle in tilts if _height(item, angle) < min(_height(item, angle + d) for d in (-1e-6, 1e-6))]
    )
    stands = min(tilts, key=abs)
    others = stable[stable != stands]
    return float((-others[others < 0]).min(initial=np.pi)), float(others[others > 0].min(initial=np.pi))


def _faces(item: PlacedElement) -> list[tuple[float, float]]:
    """Rotation that brings each face down, rad, and the distance of its ends, m: two vertices that are lowest then."""
    found = []
    for first, second in combinations(item.shape.vertices, 2):
        x, z = second - first
        turns = (float(np.arctan2(z, x)), float(np.arctan2(-z, -x)))
        lowest = (t for t in turns if first[1] * np.cos(t) - first[0] * np.sin(t) < 1e-9 * item.size - _height(item, t))
        found += [(turn, float(np.hypot(x, z))) for turn in lowest]
    return found


def _height(item: PlacedElement, rotation: float) -> float:
    """Height of the centre over the level on which an element stands when it is rotated, m."""
    x, z = item.shape.vertices.T
    return float((x * np.sin(rotation) - z * np.cos(rotation)).max())
