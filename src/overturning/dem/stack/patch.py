"""Patch of a joint: the part that the upper base and the lower face have in common, and the stiffness of its points.

The patch is taken in the plane of the lower face. Its rim consists of parts of the sides of the upper base and parts of
the sides of the lower face. A point stands for half of each part of the rim that ends at it, so its share of
the joint's stiffness is continuous where corners appear or vanish (docs/method.md).
"""

from typing import Any, Final

from numba import njit

from overturning.dem.body.vectors import (
    cross_product,
)
from overturning.dem.kernel.lanes import (
    INLINE_OPTIONS,
    INTERNAL_COMPILE_OPTIONS,
    NO_ALIAS_COMPILE_OPTIONS,
    assume_lane_count_is_multiple_of_8,
    select,
)
from overturning.dem.stack.access import (
    IS_SIMULATED_ROW_OFFSET,
    STIFFNESS_SHARE_AT_STEP_START_ROW_OFFSET,
    STIFFNESS_SHARE_IN_ATTEMPTED_STEP_ROW_OFFSET,
    USES_NON_CORNER_AT_STEP_START_ROW_OFFSET,
    load_face_corner,
    load_point_position,
    load_relative_motion,
    load_side_part_in_contact_patch,
    store_point_position,
)
from overturning.dem.stack.clip import slice_contact_point_rows
from overturning.dem.stack.joint_state import (
    JOINT_ROW_LAYOUT,
    ContactPointPosition,
    FaceCorner,
    JointRelativePoseAndVelocity,
)

MIN_BASE_CORNER_DISTANCE_INSIDE_RIM_ROW_OFFSET: Final = JOINT_ROW_LAYOUT.row_offset_of_field(
    JointRelativePoseAndVelocity, "smallest_distance_of_base_corners_inside_rim"
)
"""Array index, in the rows of a joint, at which the least distances of its base from the rim start."""


@njit(**INLINE_OPTIONS)
def base_corner_contact_point(
    relative_motion: JointRelativePoseAndVelocity, base_corner: FaceCorner, one_if_stone_is_still_simulated: float
) -> ContactPointPosition:
    """Return a base corner as a contact point: its position, and its share of stiffness if the whole base rests."""
    return ContactPointPosition(
        relative_motion.upper_base_centre.x
        + (
            base_corner.x_from_face_centre * relative_motion.upper_x_axis.x
            + base_corner.y_from_face_centre * relative_motion.upper_y_axis.x
        ),
        relative_motion.upper_base_centre.y
        + (
            base_corner.x_from_face_centre * relative_motion.upper_x_axis.y
            + base_corner.y_from_face_centre * relative_motion.upper_y_axis.y
        ),
        relative_motion.upper_base_centre.z
        + (
            base_corner.x_from_face_centre * relative_motion.upper_x_axis.z
            + base_corner.y_from_face_centre * relative_motion.upper_y_axis.z
        ),
        base_corner.joint_stiffness_share_if_whole_base_rests * one_if_stone_is_still_simulated,
    )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def predict_base_corner_position(
    upper_stone_rows: Any, joint_rows: Any, rows_of_one_base_corner: Any, lane_count: int
) -> None:
    """Compute the predicted position of one corner of a stone's base on its support, for all stacks in parallel."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        is_still_simulated = upper_stone_rows[IS_SIMULATED_ROW_OFFSET + j]
        place = base_corner_contact_point(
            load_relative_motion(joint_rows, j), load_face_corner(rows_of_one_base_corner, j), is_still_simulated
        )
        store_point_position(rows_of_one_base_corner, j, place)


@njit(**INTERNAL_COMPILE_OPTIONS)
def predict_base_corner_positions(
    upper_stone_rows: Any, joint_rows: Any, joint_point_rows: Any, base_corner_count: int, lane_count: int
) -> None:
    """Compute the predicted positions of all corners of a stone's base on its support, for all stacks in parallel."""
    for i in range(base_corner_count):
        predict_base_corner_position(
            upper_stone_rows, joint_rows, slice_contact_point_rows(joint_point_rows, i), lane_count
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def include_corner_in_min_rim_distance(
    joint_rows: Any, rows_of_one_base_corner: Any, lower_side_rows: Any, lane_count: int
) -> None:
    """Reduce the least distance of base corners from the rim below if one corner is nearer to one side of the rim.

    The distance is negative for a corner beyond the rim. All stacks are treated in parallel.
    """
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        place, limit = load_point_position(rows_of_one_base_corner, j), load_face_corner(lower_side_rows, j)
        free = limit.next_side_distance_from_face_centre - (
            limit.next_side_outward_normal_x * place.x_in_lower_face_frame
            + limit.next_side_outward_normal_y * place.y_in_lower_face_frame
        )
        free = free if place.joint_stiffness_share > 0.0 else 1e300
        least = joint_rows[MIN_BASE_CORNER_DISTANCE_INSIDE_RIM_ROW_OFFSET + j]
        joint_rows[MIN_BASE_CORNER_DISTANCE_INSIDE_RIM_ROW_OFFSET + j] = select(free < least, free, least)


@njit(**INTERNAL_COMPILE_OPTIONS)
def update_corner_rim_distance_and_check_full_support(
    joint_rows: Any, joint_point_rows: Any, base_corner_count: int, lower_face_corner_count: int, lane_count: int
) -> bool:
    """Update the least distance of base corners from the rim below; True if, in all stacks, the whole base rests.

    A base rests as a whole if all its corners lie within the face below, now and after the last step.
    """
    for i in range(base_corner_count):
        for k in range(lower_face_corner_count):
            side = slice_contact_point_rows(joint_point_rows, base_corner_count + k)
            include_corner_in_min_rim_distance(
                joint_rows, slice_contact_point_rows(joint_point_rows, i), side, lane_count
            )
    number = 0
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        number += (
            1
            if (joint_rows[MIN_BASE_CORNER_DISTANCE_INSIDE_RIM_ROW_OFFSET + j] < 0.0)
            | (joint_rows[USES_NON_CORNER_AT_STEP_START_ROW_OFFSET + j] > 0.0)
            else 0
        )
    return number == 0


@njit(**INTERNAL_COMPILE_OPTIONS)
def any_stack_uses_contact_point(point_rows: Any, lane_count: int) -> bool:
    """True if a contact point has a share of stiffness above 0 in any of the stacks, now or after the last step."""
    number = 0
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        number += (
            1
            if (point_rows[STIFFNESS_SHARE_IN_ATTEMPTED_STEP_ROW_OFFSET + j] > 0.0)
            | (point_rows[STIFFNESS_SHARE_AT_STEP_START_ROW_OFFSET + j] > 0.0)
            else 0
        )
    return number > 0


@njit(**INLINE_OPTIONS)
def contact_point_on_side(
    a: ContactPointPosition, b: ContactPointPosition, fraction_from_a: float, joint_stiffness_share: float
) -> ContactPointPosition:
    """Return the contact point with a given share of stiffness on the side from a to b, at a fraction of its length."""
    return ContactPointPosition(
        a.x_in_lower_face_frame + fraction_from_a * (b.x_in_lower_face_frame - a.x_in_lower_face_frame),
        a.y_in_lower_face_frame + fraction_from_a * (b.y_in_lower_face_frame - a.y_in_lower_face_frame),
        a.upper_base_height_above_lower_face
        + fraction_from_a * (b.upper_base_height_above_lower_face - a.upper_base_height_above_lower_face),
        joint_stiffness_share,
    )


@njit(**INLINE_OPTIONS)
def point_of_upper_stone_base_above_lower_face(
    relative_motion: JointRelativePoseAndVelocity,
    x_in_lower_face_frame: float,
    y_in_lower_face_frame: float,
    joint_stiffness_share: float,
) -> ContactPointPosition:
    """Return the point of a stone's base above point (x, y) of the lower face, with its share of the stiffness."""
    normal = cross_product(relative_motion.upper_x_axis, relative_motion.upper_y_axis)
    # A base that stands on edge has no height above the face; its stone has fallen.
    up = normal.z if normal.z > 0.1 else 0.1
    centre = relative_motion.upper_base_centre
    z = centre.z - (normal.x * (x_in_lower_face_frame - centre.x) + normal.y * (y_in_lower_face_frame - centre.y)) / up
    return ContactPointPosition(x_in_lower_face_frame, y_in_lower_face_frame, z, joint_stiffness_share)


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def place_contact_points_of_lower_face_side(
    joint_rows: Any,
    lower_side_rows: Any,
    next_lower_corner_rows: Any,
    previous_lower_side_rows: Any,
    part_begin_point_rows: Any,
    part_end_point_rows: Any,
    lane_count: int,
) -> None:
    """Store positions and shares of stiffness of the three possible contact points of one side of a lower face.

    They are the corner at which the side starts, and both ends of the side after clipping to the upper stone's base.
    """
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        frame = load_relative_motion(joint_rows, j)
        c = load_face_corner(lower_side_rows, j)
        d = load_face_corner(next_lower_corner_rows, j)
        own, previous = (
            load_side_part_in_contact_patch(lower_side_rows, j),
            load_side_part_in_contact_patch(previous_lower_side_rows, j),
        )
        unit = 0.5 / (frame.contact_patch_perimeter if frame.contact_patch_perimeter > 0.0 else 1.0)
        part = unit * own.length if frame.smallest_distance_of_base_corners_inside_rim < 0.0 else 0.0
        other = unit * previous.length if frame.smallest_distance_of_base_corners_inside_rim < 0.0 else 0.0
        corner = (part if own.begin_side_fraction == 0.0 else 0.0) + (
            other if previous.end_side_fraction == 1.0 else 0.0
        )
        at, to = own.begin_side_fraction, own.end_side_fraction
        x, y = c.x_from_face_centre, c.y_from_face_centre
        side_x, side_y = d.x_from_face_centre - x, d.y_from_face_centre - y
        begin = point_of_upper_stone_base_above_lower_face(
            frame, x + at * side_x, y + at * side_y, part if at > 0.0 else 0.0
        )
        end = point_of_upper_stone_base_above_lower_face(
            frame, x + to * side_x, y + to * side_y, part if to < 1.0 else 0.0
        )
        store_point_position(lower_side_rows, j, point_of_upper_stone_base_above_lower_face(frame, x, y, corner))
        store_point_position(part_begin_point_rows, j, begin)
        store_point_position(part_end_point_rows, j, end)


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def store_contact_points_at_clipped_side_ends(
    joint_rows: Any,
    base_side_rows: Any,
    next_base_corner_rows: Any,
    previous_base_side_rows: Any,
    part_begin_point_rows: Any,
    part_end_point_rows: Any,
    lane_count: int,
) -> None:
    """Store the contact points at the ends of a side of a stone's base, clipped to the face below.

    The shares of stiffness of both ends, and of the corner at which the side starts, are stored with them.
    """
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        frame = load_relative_motion(joint_rows, j)
        a = load_point_position(base_side_rows, j)
        b = load_point_position(next_base_corner_rows, j)
        own, previous = (
            load_side_part_in_contact_patch(base_side_rows, j),
            load_side_part_in_contact_patch(previous_base_side_rows, j),
        )
        unit = 0.5 / (frame.contact_patch_perimeter if frame.contact_patch_perimeter > 0.0 else 1.0)
        within = frame.smallest_distance_of_base_corners_inside_rim >= 0.0
        part, other = (0.0 if within else unit * own.length), (0.0 if within else unit * previous.length)
        corner = (part if own.begin_side_fraction == 0.0 else 0.0) + (
            other if previous.end_side_fraction == 1.0 else 0.0
        )
        store_point_position(
            part_begin_point_rows,
            j,
            contact_point_on_side(a, b, own.begin_side_fraction, part if own.begin_side_fraction > 0.0 else 0.0),
        )
        store_point_position(
            part_end_point_rows,
            j,
            contact_point_on_side(a, b, own.end_side_fraction, part if own.end_side_fraction < 1.0 else 0.0),
        )
        base_side_rows[STIFFNESS_SHARE_IN_ATTEMPTED_STEP_ROW_OFFSET + j] = select(
            within, a.joint_stiffness_share, corner
        )


@njit(**INTERNAL_COMPILE_OPTIONS)
def place_partial_patch_points_with_stiffness(
    joint_rows: Any, joint_point_rows: Any, base_corner_count: int, lower_face_corner_count: int, lane_count: int
) -> None:
    """Compute place and stiffness of all contact points where only a part of a stone's base rests on the face below."""
    corners, crossings = base_corner_count + lower_face_corner_count, 2 * (base_corner_count + lower_face_corner_count)
    for k in range(lower_face_corner_count):
        following = (k + 1) % lower_face_corner_count
        before = (k + lower_face_corner_count - 1) % lower_face_corner_count
        place_contact_points_of_lower_face_side(
            joint_rows,
            slice_contact_point_rows(joint_point_rows, base_corner_count + k),
            slice_contact_point_rows(joint_point_rows, base_corner_count + following),
            slice_contact_point_rows(joint_point_rows, base_corner_count + before),
            slice_contact_point_rows(joint_point_rows, corners + base_corner_count + k),
            slice_contact_point_rows(joint_point_rows, crossings + base_corner_count + k),
            lane_count,
        )
    for i in range(base_corner_count):
        following, before = (i + 1) % base_corner_count, (i + base_corner_count - 1) % base_corner_count
        store_contact_points_at_clipped_side_ends(
            joint_rows,
            slice_contact_point_rows(joint_point_rows, i),
            slice_contact_point_rows(joint_point_rows, following),
            slice_contact_point_rows(joint_point_rows, before),
            slice_contact_point_rows(joint_point_rows, corners + i),
            slice_contact_point_rows(joint_point_rows, crossings + i),
            lane_count,
        )
