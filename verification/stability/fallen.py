"""From which rotation an element of a scene has fallen, by its shape and springs, not by the kernel's rule.

An element has fallen for good where it can rest on another face, a rectangle at 90°. An overdamped stone that falls on
its side creeps towards that angle and need not reach it. One that ends past its tipping angle, that has dropped or that
has lost its support has fallen too. So there are two angles, between which both answers are right: what has turned
farther than `lies_from` has fallen, what has turned less than `falls_from` has not.
"""

from itertools import combinations
from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.polygon.prepare import Prepared
from overturning.model.geometry import Placed
from overturning.units import STANDARD_GRAVITY

LEVEL: Final = 0.5 * np.pi
"""Rotation that brings an upright face down, rad."""

ROUNDING: Final = 1e-6
"""Of a rotation that is kept as a share of the critical angle in single precision."""


def lies_from(prepared: Prepared) -> FloatArray:
    """Rotation from which each free element surely has fallen, rad.

    A stone that lies level on a face of length L presses both ends in by δ = m g/(2 K_n). With the near end in by δ the
    far end touches at asin(δ/L) before level: from there on the face bears on both ends. K_n is that of the softest
    contact that the element can make. An element whose scene asks for a rotation has fallen at that itself, but for 90°
    of one with an upright face. Results keep rotations up to 90° only; infinite where more is asked for.

    Parameters
    ----------
    prepared : Prepared
        The scene at its size.
    """
    angle = _asked(prepared)
    for place, index in enumerate(prepared.free):
        item = prepared.placed[index]
        length = coming_down(item, angle[place])
        if length > 0.0:
            mine = [k for k, pair in enumerate(prepared.pairs) if index in pair]
            pressed = item.mass * STANDARD_GRAVITY / (2.0 * prepared.laws.normal[mine].min())
            angle[place] -= np.arcsin(min(pressed / length, 1.0))
    return np.where(angle > LEVEL, np.inf, angle)


def falls_from(prepared: Prepared) -> FloatArray:
    """Rotation below which no free element has fallen, rad: its tipping angle; 0 where it may drop or lose its support.

    Parameters
    ----------
    prepared : Prepared
        The scene at its size.
    """
    found = []
    for index, asked in zip(prepared.free, _asked(prepared), strict=True):
        item = prepared.placed[index]
        on_ground = all(prepared.placed[k].fixed for k in prepared.carriers[index])
        x, z = item.shape.vertices.T
        base = x[z < z.min() + 1e-9 * item.size]
        tips = float(np.arctan2(min(base.max(), -base.min()), -z.min()))
        found.append(min(asked, tips, LEVEL) if on_ground and item.element.fallen_drop is None else 0.0)
    return np.array(found)


def flags_fit(prepared: Prepared, fallen: NDArray[np.bool_], rotation: FloatArray) -> bool:
    """Whether the flags of the free elements go with their largest rotations.

    Parameters
    ----------
    prepared : Prepared
        The scene at its size.
    fallen : ndarray of bool, shape (free elements,)
        Their flags.
    rotation : ndarray, shape (free elements,)
        Their largest absolute rotations, rad, cut at 90°.
    """
    early = fallen & (rotation < falls_from(prepared) - ROUNDING)
    missed = ~fallen & (rotation > lies_from(prepared) - ROUNDING)
    return not (early | missed).any()


def _asked(prepared: Prepared) -> FloatArray:
    items = [prepared.placed[index] for index in prepared.free]
    asked = [item.element.fallen_rotation_deg for item in items]
    return np.array(
        [rests_at(item) if angle is None else np.radians(angle) for item, angle in zip(items, asked, strict=True)]
    )


def rests_at(item: Placed) -> float:
    """Least rotation, rad, at which an element can rest on a level but as it stands: its centre is lowest there."""
    tilts = [angle for angle, _ in _faces(item)]
    stable = np.array(
        [angle for angle in tilts if _height(item, angle) < min(_height(item, angle + d) for d in (-1e-6, 1e-6))]
    )
    stands = min(tilts, key=abs)
    return float(np.abs(stable[stable != stands]).min(initial=np.pi))


def coming_down(item: Placed, rotation: float) -> float:
    """Length of the longest face that a rotation either way brings down, m; 0 where there is none."""
    return max((length for angle, length in _faces(item) if abs(abs(angle) - rotation) < 1e-9), default=0.0)


def _faces(item: Placed) -> list[tuple[float, float]]:
    """Rotation that brings each face down, rad, and the distance of its ends, m: two vertices that are lowest then."""
    found = []
    for first, second in combinations(item.shape.vertices, 2):
        x, z = second - first
        turns = (float(np.arctan2(z, x)), float(np.arctan2(-z, -x)))
        lowest = (t for t in turns if first[1] * np.cos(t) - first[0] * np.sin(t) < 1e-9 * item.size - _height(item, t))
        found += [(turn, float(np.hypot(x, z))) for turn in lowest]
    return found


def _height(item: Placed, rotation: float) -> float:
    """Height of the centre over the level on which an element stands when it is rotated, m."""
    x, z = item.shape.vertices.T
    return float((x * np.sin(rotation) - z * np.cos(rotation)).max())
