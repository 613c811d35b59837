"""Tilts at which stones of a 3-D stack would meet the face below with points outside the contact at rest.

In a stack, only the base of a stone touches. A stone that is wider just above its base than at its base would meet the
face below with its outline while it tilts, and roll on.
"""

from typing import Final, NamedTuple

import numpy as np

from overturning.arrays import FloatArray
from overturning.model.stack_stones import LEVEL_TOLERANCE, StackStone, patches_at_rest

DIRECTIONS: Final = 360
"""Number of directions of tilt that are examined, at equal angles; those along and across the plane are among them."""

SIDE_PARTS: Final = 64
"""Number of equal parts into which a side of an outline is divided: its points, too, can meet the rim of a face."""

DEPTH_PARTS: Final = 8
"""Number of equal parts into which the depth of a stone is divided."""

ROUNDING: Final = 1e-9
"""Relative difference of lengths or angles that counts as none."""


class EarlyTouch(NamedTuple):
    """Tilt at which a stone's outline meets the face below, before the stone tips over the edge of its contact."""

    stone: str
    touching_tilt: float  # rad
    critical_angle: float  # tilt at which the stone balances on that edge, rad


def touches_before_tipping(stones: list[StackStone]) -> list[EarlyTouch]:
    """Return the stones of a stack that meet the face below with their outline before they tip, lowest stone first.

    Parameters
    ----------
    stones : list of StackStone
        Stones from the lowest up, each with its centre of mass above its contact with the stone below.

    Returns
    -------
    list of EarlyTouch
        For each such stone the least tilt, over all directions and points, at which it touches before it tips.
    """
    patches = patches_at_rest(stones)
    faces = [None, *(below.upper + np.array([below.x, 0.0]) for below in stones[:-1])]
    found = (
        _earliest_touch(stone, patch.corners, face) for stone, patch, face in zip(stones, patches, faces, strict=True)
    )
    return [touch for touch in found if touch is not None]


def _earliest_touch(stone: StackStone, patch: FloatArray, face: FloatArray | None) -> EarlyTouch | None:
    """Return the touch of a stone, if any, on the face below (corners, m), with the patch as contact at rest.

    Without a face, the stone stands on the ground, a plane without end.
    """
    size = float(np.ptp(stone.outline, axis=0).max())
    if not stone.is_box or np.ptp(stone.outline[:, 0]) <= np.ptp(stone.base[:, 0]) + ROUNDING * size:
        return None  # nothing of the stone is outside its base
    # On a plane without end, a vertex touches before all points between vertices.
    touch = _earliest_touch_of_points(stone, _outline_points(stone, 1, 1), patch, None)
    if touch is None or face is None:
        return touch
    return _earliest_touch_of_points(stone, _outline_points(stone, SIDE_PARTS, DEPTH_PARTS), patch, face)


def _earliest_touch_of_points(
    stone: StackStone, points: FloatArray, patch: FloatArray, face: FloatArray | None
) -> EarlyTouch | None:
    """Return the touch of given points, (n, 3), of a stone on the face below; see `_earliest_touch`."""
    points = points[points[:, 2] > LEVEL_TOLERANCE * np.ptp(stone.outline[:, 1])]
    azimuth = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
    ahead = np.stack([np.cos(azimuth), np.sin(azimuth)])
    edge = (patch @ ahead).max(axis=0)
    critical = np.arctan2(edge - stone.x * ahead[0], stone.foot)
    beyond = points[:, :2] @ ahead - edge
    touching = np.arctan2(points[:, 2:], beyond)
    early = (beyond > 0.0) & (touching < critical * (1.0 - ROUNDING))
    if face is not None:
        # A point meets the plane of the face as far from the edge as it was before the tilt.
        shift = np.sqrt(beyond**2 + points[:, 2:] ** 2) - beyond
        for (x, y), (dx, dy) in zip(face, np.roll(face, -1, axis=0) - face, strict=True):
            to_x, to_y = points[:, :1] + shift * ahead[0] - x, points[:, 1:2] + shift * ahead[1] - y
            early &= dx * to_y - dy * to_x > ROUNDING * np.sqrt(dx * dx + dy * dy) * stone.depth
    if not early.any():
        return None
    tilt = np.where(early, touching, np.inf)
    direction = int(np.argmin(tilt.min(axis=0)))
    return EarlyTouch(stone.name, float(tilt.min()), float(critical[direction]))


def _outline_points(stone: StackStone, side_parts: int, depth_parts: int) -> FloatArray:
    """Return points on the surface of an extruded outline, shape (n, 3), m: horizontal position, height above its base.

    They divide each side of the outline, and the depth, into equal parts; all vertices are among them.
    """
    share = np.arange(side_parts)[:, None, None] / side_parts
    sides = stone.outline + share * (np.roll(stone.outline, -1, axis=0) - stone.outline)
    x, z = sides.reshape(-1, 2).T
    depths = stone.depth * (np.arange(depth_parts + 1) / depth_parts - 0.5)
    return np.stack([
        np.repeat(x + stone.x, depths.size), np.tile(depths, x.size), np.repeat(z + stone.foot, depths.size)
    ], axis=1)  # fmt: skip
