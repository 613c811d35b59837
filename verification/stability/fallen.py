"""From which rotation an element of a scene has fallen, worked out from its shape and springs, not by the kernel's rule.

A scene counts a rotation of 90° as a fall. An overdamped stone that falls on its side creeps towards 90° and need not
reach them, and one that is caught on its way, when the case ends, has not reached them yet. So there are two angles,
between which both answers are right: what has turned farther than `lies_from` has fallen, what has turned less than
`falls_from` has not.
"""

from typing import Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.polygon.geometry import Placed
from overturning.dem.polygon.prepare import Prepared
from overturning.units import STANDARD_GRAVITY

LEVEL: Final = 0.5 * np.pi
"""Rotation that brings an upright face down, rad."""

LAST_GAP: Final = 0.01
"""Of the length of a face that comes down: its far end is then so far above the ground. Gravity alone, 3 g/(2 L) about
the near end, closes that in 0.12 √(L/g), 0.03 s for 0.6 m; no motion throws the stone back in this time."""

ROUNDING: Final = 1e-6
"""Of a rotation that is kept as a share of the critical angle in single precision."""


def lies_from(prepared: Prepared) -> FloatArray:
    """Rotation from which each free element surely has fallen, rad.

    A stone that lies level on a face of length L presses both ends in by δ = m g/(2 K_n). With the near end in by δ the
    far end touches at asin(δ/L) before level: from there on the face bears on both ends. K_n is that of the softest
    contact that the element can make. Only a face that is upright at first comes down at 90°; an element without one,
    or whose scene asks for another rotation, has fallen at the rotation itself. Results keep rotations up to 90° only;
    infinite where more is asked for.

    Parameters
    ----------
    prepared : Prepared
        The scene at its size.
    """
    angle = _asked(prepared)
    for place, index in enumerate(prepared.free):
        item = prepared.placed[index]
        length = _upright_face(item)
        if angle[place] == LEVEL and length > 0.0:
            mine = [k for k, pair in enumerate(prepared.pairs) if index in pair]
            pressed = item.mass * STANDARD_GRAVITY / (2.0 * prepared.laws.normal[mine].min())
            angle[place] -= np.arcsin(min(pressed / length, 1.0))
    return np.where(angle > LEVEL, np.inf, angle)


def falls_from(prepared: Prepared) -> FloatArray:
    """Rotation below which no free element has fallen, rad: that of its scene, less `LAST_GAP` for 90°; 0 where it may drop.

    Parameters
    ----------
    prepared : Prepared
        The scene at its size.
    """
    asked = _asked(prepared)
    drops = [prepared.placed[index].element.fallen_drop is not None for index in prepared.free]
    return np.where(drops, 0.0, np.where(asked == LEVEL, LEVEL - np.arcsin(LAST_GAP), np.minimum(asked, LEVEL)))


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
    return np.radians([prepared.placed[index].element.fallen_rotation_deg for index in prepared.free])


def _upright_face(item: Placed) -> float:
    """Length of the longest upright face, m; 0 where there is none."""
    along = np.roll(item.points, -1, axis=0) - item.points
    upright = np.abs(along[:, 0]) < 1e-9 * item.size
    return float(np.abs(along[upright, 1]).max(initial=0.0))
