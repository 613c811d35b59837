"""Tilts at which stones of a 3-D stack would meet a face below with points outside the contact at rest.

In a stack, a stone touches only the stone below, and only with its base. A stone that is wider just above its base than
at its base would meet the face below with its outline while it tilts, and roll on. A stone that overhangs the stone
below would meet a stone further below, or the ground.
"""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.model.stack_stones import (
    LEVEL_FACE_TOLERANCE_TO_STONE_HEIGHT_RATIO,
    StackStone,
    contact_patches_at_rest,
)

TILT_DIRECTION_COUNT: Final = 360
"""Number of directions of tilt that are examined, at equal angles; those along and across the plane are among them."""

TOUCH_CHECK_PARTS_PER_OUTLINE_SIDE: Final = 64
"""Number of equal parts into which a side of an outline is divided: its points, too, can meet the rim of a face."""

TOUCH_CHECK_PARTS_PER_STONE_DEPTH_OR_BASE_RADIUS: Final = 8
"""Number of equal parts into which the depth of a stone, and the radius of a base, is divided."""

RELATIVE_ROUNDING_TOLERANCE: Final = 1e-9
"""Relative difference of lengths or angles that counts as none."""


class FaceTouchableByTiltingStone(NamedTuple):
    """Face that a tilting stone could touch: the upper face of a stone below, or the ground."""

    name_of_stone_with_face: str  # stone that has the face; "" for the ground
    corners_or_none_if_unbounded: (
        FloatArray | None
    )  # horizontal positions, anticlockwise, shape (n, 2), m; None for a plane without end
    depth_below_base_of_tipping_stone: float  # depth of the face below the base of the stone, m


class TiltAtFurtherContactBeforeTipping(NamedTuple):
    """Tilt at which a stone touches a further face below, before the stone tips over the edge of its contact area."""

    tipping_stone_name: str
    touched_face: FaceTouchableByTiltingStone  # upper face of a stone below, or the ground
    tilt_when_touching_face_below_rad: float  # rad
    tipping_tilt_rad: float  # tilt at which the stone balances on that edge, rad


def lower_faces_touched_before_tipping(stones: list[StackStone]) -> list[TiltAtFurtherContactBeforeTipping]:
    """Return the faces below that stones of a stack, from the lowest up, touch outside their contact before they tip.

    Parameters
    ----------
    stones : list of StackStone
        Stones from the lowest up, each with its centre of mass above its contact with the stone below.

    Returns
    -------
    list of TiltAtFurtherContactBeforeTipping
        One entry for each stone and each face that it touches, with the least tilt over all directions of tilt and
        points of the stone; entries of one stone in the order of tilt.
    """
    level = np.concatenate(
        [[0.0], np.cumsum([stone.centre_height_above_base + stone.upper_face_height_above_centre for stone in stones])]
    )
    found = []
    for k, (stone, patch) in enumerate(zip(stones, contact_patches_at_rest(stones), strict=True)):
        faces = [FaceTouchableByTiltingStone("", None, float(level[k]))]
        for below, top in zip(stones[:k], level[1:], strict=False):
            faces.append(
                FaceTouchableByTiltingStone(
                    below.name,
                    below.upper_face_corners_xy_from_centre_of_mass + np.array([below.centre_of_mass_x_at_rest, 0.0]),
                    float(level[k] - top),
                )
            )
        touches = [
            touch
            for face in faces
            if (touch := _first_contact_with_face(stone, patch.corners_xy_in_stack_axes, face)) is not None
        ]
        found += sorted(touches, key=lambda touch: touch.tilt_when_touching_face_below_rad)
    return found


def _first_contact_with_face(
    stone: StackStone, contact_patch_corners: FloatArray, face: FaceTouchableByTiltingStone
) -> TiltAtFurtherContactBeforeTipping | None:
    """Return the first contact of a tilting stone with a face below; None if the stone tips without touching it.

    `contact_patch_corners` has the corners (m) of the stone's contact area at rest.
    """
    azimuth = 2.0 * np.pi * np.arange(TILT_DIRECTION_COUNT) / TILT_DIRECTION_COUNT
    ahead = np.stack([np.cos(azimuth), np.sin(azimuth)])
    edge = (contact_patch_corners @ ahead).max(axis=0)
    critical = np.arctan2(edge - stone.centre_of_mass_x_at_rest * ahead[0], stone.centre_height_above_base)
    # On a plane without end, a vertex touches before all points between vertices.
    tilt = _least_tilt_for_point_to_touch_face(
        stone,
        _surface_points_to_test_for_contact(stone, 1, 1),
        ahead,
        edge,
        face._replace(corners_or_none_if_unbounded=None),
    )
    early = critical * (1.0 - RELATIVE_ROUNDING_TOLERANCE)
    if face.corners_or_none_if_unbounded is not None and np.any(tilt < early):
        points = _surface_points_to_test_for_contact(
            stone, TOUCH_CHECK_PARTS_PER_OUTLINE_SIDE, TOUCH_CHECK_PARTS_PER_STONE_DEPTH_OR_BASE_RADIUS
        )
        tilt = np.minimum(
            _least_tilt_for_point_to_touch_face(stone, points, ahead, edge, face),
            _least_tilt_for_base_to_touch_face_corner(
                stone, ahead, edge, face.corners_or_none_if_unbounded, face.depth_below_base_of_tipping_stone
            ),
        )
    tilt = np.where(tilt < early, tilt, np.inf)
    direction = int(np.argmin(tilt))
    if np.isinf(tilt[direction]):
        return None
    return TiltAtFurtherContactBeforeTipping(stone.name, face, float(tilt[direction]), float(critical[direction]))


def _least_tilt_for_point_to_touch_face(
    stone: StackStone,
    points: FloatArray,
    horizontal_unit_vector_by_tilt_direction: FloatArray,
    edge_distance_by_tilt_direction: FloatArray,
    face: FaceTouchableByTiltingStone,
) -> FloatArray:
    """Return, per tilt direction, the least tilt (rad) at which a stone's point touches a face; infinite if none does.

    The points have the shape (n, 3), m, and `horizontal_unit_vector_by_tilt_direction` (2, directions).
    `edge_distance_by_tilt_direction`, (directions,), is the distance (m) from the origin of the stack's axes to the
    edge about which the stone tilts.
    """
    if face.depth_below_base_of_tipping_stone == 0.0:
        points = points[
            points[:, 2]
            > LEVEL_FACE_TOLERANCE_TO_STONE_HEIGHT_RATIO * np.ptp(stone.outline_xz_from_centre_of_mass[:, 1])
        ]
    beyond = points[:, :2] @ horizontal_unit_vector_by_tilt_direction - edge_distance_by_tilt_direction
    radius = np.sqrt(beyond**2 + points[:, 2:] ** 2)
    reaches = (beyond > RELATIVE_ROUNDING_TOLERANCE * stone.depth_along_y) & (
        radius > face.depth_below_base_of_tipping_stone
    )
    sine = np.divide(face.depth_below_base_of_tipping_stone, radius, out=np.zeros_like(radius), where=reaches)
    if face.corners_or_none_if_unbounded is not None:
        # The point turns about the edge until it has the depth of the face.
        shift = radius * np.sqrt(1.0 - sine**2) - beyond
        place = points[:, :2, None] + shift[:, None] * horizontal_unit_vector_by_tilt_direction
        reaches &= _mask_of_points_inside_polygon(
            place, face.corners_or_none_if_unbounded, RELATIVE_ROUNDING_TOLERANCE * stone.depth_along_y
        )
    tilt = np.where(reaches, np.arctan2(points[:, 2:], beyond) + np.arcsin(sine), np.inf)
    return np.asarray(tilt.min(axis=0, initial=np.inf))


def _least_tilt_for_base_to_touch_face_corner(
    stone: StackStone,
    horizontal_unit_vector_by_tilt_direction: FloatArray,
    edge_distance_by_tilt_direction: FloatArray,
    face_corners: FloatArray,
    face_depth_below_base: float,
) -> FloatArray:
    """Return, per tilt direction, the least tilt (rad) at which a stone's base touches a corner of a face, or infinity.

    The face is `face_depth_below_base` (m) below the base. For directions and edge distances, see
    `_least_tilt_for_point_to_touch_face`.
    """
    beyond = face_corners @ horizontal_unit_vector_by_tilt_direction - edge_distance_by_tilt_direction
    # The point of the base that meets the corner, before the tilt.
    place = (
        face_corners[:, :, None]
        + (np.sqrt(beyond**2 + face_depth_below_base**2) - beyond)[:, None] * horizontal_unit_vector_by_tilt_direction
    )
    base = stone.base_corners_xy_from_centre_of_mass + np.array([stone.centre_of_mass_x_at_rest, 0.0])
    meets = (beyond > RELATIVE_ROUNDING_TOLERANCE * stone.depth_along_y) & _mask_of_points_inside_polygon(
        place, base, RELATIVE_ROUNDING_TOLERANCE * stone.depth_along_y
    )
    return np.asarray(np.where(meets, np.arctan2(face_depth_below_base, beyond), np.inf).min(axis=0))


def _mask_of_points_inside_polygon(
    touch_place_xy_by_point_and_tilt_direction: FloatArray,
    polygon_vertices: FloatArray,
    min_distance_from_polygon_sides: float,
) -> NDArray[np.bool_]:
    """Return a mask (n, directions) of points (n, 2, directions) inside an anticlockwise polygon by a distance (m)."""
    inside = np.ones(
        (len(touch_place_xy_by_point_and_tilt_direction), touch_place_xy_by_point_and_tilt_direction.shape[2]),
        np.bool_,
    )
    for (x, y), (dx, dy) in zip(
        polygon_vertices, np.roll(polygon_vertices, -1, axis=0) - polygon_vertices, strict=True
    ):
        inside &= dx * (touch_place_xy_by_point_and_tilt_direction[:, 1] - y) - dy * (
            touch_place_xy_by_point_and_tilt_direction[:, 0] - x
        ) > min_distance_from_polygon_sides * np.sqrt(dx * dx + dy * dy)
    return inside


def _surface_points_to_test_for_contact(
    stone: StackStone, parts_per_outline_side: int, parts_per_depth_or_radius: int
) -> FloatArray:
    """Return points on the surface of a stone, to test for contact with faces below, shape (n, 3), m.

    Coordinates are the horizontal position (2) in the axes of the stack, and the height above the base of the stone.

    For an extruded outline, the points divide each side of the outline, and the depth, into equal parts. For a prism on
    a polygon, the points are those of the base, since these are lowest: they divide each side, and the radius, into
    equal parts. All vertices of the outline or the base are included.
    """
    ring = (
        stone.outline_xz_from_centre_of_mass
        if stone.has_rectangular_faces
        else stone.base_corners_xy_from_centre_of_mass
    )
    share = np.arange(parts_per_outline_side)[:, None, None] / parts_per_outline_side
    sides = (ring + share * (np.roll(ring, -1, axis=0) - ring)).reshape(-1, 2)
    if not stone.has_rectangular_faces:
        base = (
            sides * (np.arange(1, parts_per_depth_or_radius + 1)[:, None, None] / parts_per_depth_or_radius)
        ).reshape(-1, 2)
        return np.column_stack([base + np.array([stone.centre_of_mass_x_at_rest, 0.0]), np.zeros(len(base))])
    depths = stone.depth_along_y * (np.arange(parts_per_depth_or_radius + 1) / parts_per_depth_or_radius - 0.5)
    x, z = sides.T
    return np.stack([
        np.repeat(x + stone.centre_of_mass_x_at_rest, depths.size), np.tile(depths, x.size),
        np.repeat(z + stone.centre_height_above_base, depths.size),
    ], axis=1)  # fmt: skip
