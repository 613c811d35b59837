"""Clipping of the sides of the upper base and of the lower face of a joint to the patch that both have in common."""

import math
from typing import Any, Final

from numba import njit

from overturning.dem.kernel.lanes import (
    INLINE_OPTIONS,
    INTERNAL_COMPILE_OPTIONS,
    NO_ALIAS_COMPILE_OPTIONS,
    assume_lane_count_is_multiple_of_8,
    create_window_slicer,
)
from overturning.dem.stack.access import (
    load_base_overhang_and_normal_slopes,
    load_face_corner,
    load_point_position,
    load_side_part_in_contact_patch,
    store_base_overhang_and_normal_slopes,
    store_side_part_in_contact_patch,
)
from overturning.dem.stack.joint_state import (
    JOINT_ROW_LAYOUT,
    POINT_ROW_LAYOUT,
    BaseOverhangAndContactNormalSlopesAtSide,
    ContactPointPosition,
    FaceCorner,
    JointRelativePoseAndVelocity,
    SidePartInContactPatch,
)

slice_contact_point_rows: Final = create_window_slicer(POINT_ROW_LAYOUT.array_length)
"""Return the rows of a point of a joint."""
PATCH_PERIMETER_ROW_OFFSET: Final = JOINT_ROW_LAYOUT.row_offset_of_field(
    JointRelativePoseAndVelocity, "contact_patch_perimeter"
)
"""Array index, in the rows of a joint, at which `JointRelativePoseAndVelocity.contact_patch_perimeter` starts."""


@njit(**INLINE_OPTIONS)
def clip_side_by_half_plane(
    side_part: SidePartInContactPatch, depth_inside_at_begin: float, depth_inside_at_end: float
) -> SidePartInContactPatch:
    """Clip a part of a face's side by a half plane, given how far the ends of the whole side lie inside.

    The depths of both ends are negative outside the half plane; their unit does not matter.
    """
    crosses = (depth_inside_at_begin < 0.0) != (depth_inside_at_end < 0.0)
    share = depth_inside_at_begin / (depth_inside_at_begin - depth_inside_at_end if crosses else 1.0)
    outside = (depth_inside_at_begin < 0.0) & (depth_inside_at_end < 0.0)
    begin = (
        share
        if crosses & (depth_inside_at_begin < 0.0) & (share > side_part.begin_side_fraction)
        else side_part.begin_side_fraction
    )
    end = (
        share
        if crosses & (depth_inside_at_end < 0.0) & (share < side_part.end_side_fraction)
        else side_part.end_side_fraction
    )
    return SidePartInContactPatch(begin, (-1.0 if outside else end), side_part.length)


@njit(**INLINE_OPTIONS)
def clipped_side_with_length(side_part: SidePartInContactPatch, whole_side_length: float) -> SidePartInContactPatch:
    """Return the clipped part of a face's side with its length, m; `whole_side_length` is that of the whole side, m."""
    part = side_part.end_side_fraction - side_part.begin_side_fraction
    return SidePartInContactPatch(
        side_part.begin_side_fraction, side_part.end_side_fraction, whole_side_length * part if part > 0.0 else 0.0
    )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def start_clipping_with_whole_side(side_rows: Any, lane_count: int) -> None:
    """Start the clipping of a side of a face with the whole side, for all stacks in parallel."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        store_side_part_in_contact_patch(side_rows, j, SidePartInContactPatch(0.0, 1.0, 0.0))


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def clip_base_side_by_lower_side(
    base_side_rows: Any, next_base_corner_rows: Any, lower_side_rows: Any, lane_count: int
) -> None:
    """Clip a side of the upper stone's base by the line of one side of the lower face, for all stacks in parallel."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        a = load_point_position(base_side_rows, j)
        b = load_point_position(next_base_corner_rows, j)
        limit = load_face_corner(lower_side_rows, j)
        store_side_part_in_contact_patch(
            base_side_rows,
            j,
            clip_side_by_half_plane(
                load_side_part_in_contact_patch(base_side_rows, j),
                limit.next_side_distance_from_face_centre
                - (
                    limit.next_side_outward_normal_x * a.x_in_lower_face_frame
                    + limit.next_side_outward_normal_y * a.y_in_lower_face_frame
                ),
                limit.next_side_distance_from_face_centre
                - (
                    limit.next_side_outward_normal_x * b.x_in_lower_face_frame
                    + limit.next_side_outward_normal_y * b.y_in_lower_face_frame
                ),
            ),
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def add_clipped_base_side_to_patch_perimeter(
    joint_rows: Any, base_side_rows: Any, next_base_corner_rows: Any, lane_count: int
) -> None:
    """Store the length of a clipped side of a stone's base, and add it to the contact patch's perimeter."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        a, b = load_point_position(base_side_rows, j), load_point_position(next_base_corner_rows, j)
        clip = clipped_side_with_length(
            load_side_part_in_contact_patch(base_side_rows, j),
            math.sqrt(
                (b.x_in_lower_face_frame - a.x_in_lower_face_frame) ** 2
                + (b.y_in_lower_face_frame - a.y_in_lower_face_frame) ** 2
            ),
        )
        store_side_part_in_contact_patch(base_side_rows, j, clip)
        joint_rows[PATCH_PERIMETER_ROW_OFFSET + j] += clip.length


@njit(**INTERNAL_COMPILE_OPTIONS)
def clip_base_sides_and_add_patch_perimeter(
    joint_rows: Any, joint_point_rows: Any, base_corner_count: int, lower_face_corner_count: int, lane_count: int
) -> None:
    """Clip all sides of a stone's base by the face below, and add their lengths to the contact patch's perimeter."""
    for i in range(base_corner_count):
        point, following = slice_contact_point_rows(joint_point_rows, i), (i + 1) % base_corner_count
        next_corner = slice_contact_point_rows(joint_point_rows, following)
        start_clipping_with_whole_side(point, lane_count)
        for k in range(lower_face_corner_count):
            clip_base_side_by_lower_side(
                point, next_corner, slice_contact_point_rows(joint_point_rows, base_corner_count + k), lane_count
            )
        add_clipped_base_side_to_patch_perimeter(joint_rows, point, next_corner, lane_count)


@njit(**INLINE_OPTIONS)
def double_signed_triangle_area(a: ContactPointPosition, b: ContactPointPosition, x: float, y: float) -> float:
    """Return twice the area (m²) of the triangle a, b, (x, y): positive if (x, y) lies to the left of side a–b."""
    return (b.x_in_lower_face_frame - a.x_in_lower_face_frame) * (y - a.y_in_lower_face_frame) - (
        b.y_in_lower_face_frame - a.y_in_lower_face_frame
    ) * (x - a.x_in_lower_face_frame)


@njit(**INLINE_OPTIONS)
def contact_normal_slope_at_crossing_sides(
    lower_side_start_corner: FaceCorner, a: ContactPointPosition, b: ContactPointPosition
) -> float:
    """Return the slope (≥ 0) of the contact normal where side a–b of the upper base crosses a lower face's side.

    The normal is perpendicular to both sides; its slope is measured across the side of the lower face.
    """
    across = lower_side_start_corner.next_side_outward_normal_x * (
        b.x_in_lower_face_frame - a.x_in_lower_face_frame
    ) + lower_side_start_corner.next_side_outward_normal_y * (b.y_in_lower_face_frame - a.y_in_lower_face_frame)
    slope = (a.upper_base_height_above_lower_face - b.upper_base_height_above_lower_face) / (
        across if across != 0.0 else 1.0
    )
    return slope if (across != 0.0) & (slope > 0.0) else 0.0


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def reset_base_overhang_before_clipping(lower_side_rows: Any, lane_count: int) -> None:
    """Reset base overhang and contact normal slopes at a side of the lower face, for all stacks in parallel."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        store_base_overhang_and_normal_slopes(
            lower_side_rows, j, BaseOverhangAndContactNormalSlopesAtSide(-1e300, 0.0, 0.0)
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def clip_lower_side_and_update_overhang(
    lower_side_rows: Any,
    next_lower_corner_rows: Any,
    base_side_start_corner_rows: Any,
    base_side_end_corner_rows: Any,
    lane_count: int,
) -> None:
    """Clip a side of the lower face by a side of the upper base; update overhang and normal slopes, in all stacks."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        a, b = load_point_position(base_side_start_corner_rows, j), load_point_position(base_side_end_corner_rows, j)
        c, d = load_face_corner(lower_side_rows, j), load_face_corner(next_lower_corner_rows, j)
        old, rim = (
            load_side_part_in_contact_patch(lower_side_rows, j),
            load_base_overhang_and_normal_slopes(lower_side_rows, j),
        )
        new = clip_side_by_half_plane(
            old,
            double_signed_triangle_area(a, b, c.x_from_face_centre, c.y_from_face_centre),
            double_signed_triangle_area(a, b, d.x_from_face_centre, d.y_from_face_centre),
        )
        slope = contact_normal_slope_at_crossing_sides(c, a, b)
        beyond = (
            c.next_side_outward_normal_x * a.x_in_lower_face_frame
            + c.next_side_outward_normal_y * a.y_in_lower_face_frame
        ) - c.next_side_distance_from_face_centre
        store_side_part_in_contact_patch(lower_side_rows, j, new)
        store_base_overhang_and_normal_slopes(
            lower_side_rows,
            j,
            BaseOverhangAndContactNormalSlopesAtSide(
                max_base_corner_distance_beyond_side=beyond
                if beyond > rim.max_base_corner_distance_beyond_side
                else rim.max_base_corner_distance_beyond_side,
                contact_normal_slope_at_clipped_side_start=slope
                if new.begin_side_fraction > old.begin_side_fraction
                else rim.contact_normal_slope_at_clipped_side_start,
                contact_normal_slope_at_clipped_side_end=slope
                if new.end_side_fraction < old.end_side_fraction
                else rim.contact_normal_slope_at_clipped_side_end,
            ),
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def add_clipped_lower_side_to_patch_perimeter(
    joint_rows: Any, lower_side_rows: Any, next_lower_corner_rows: Any, lane_count: int
) -> None:
    """Store the length of a clipped side of the lower face, and add it to the contact patch's perimeter."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        c, d = load_face_corner(lower_side_rows, j), load_face_corner(next_lower_corner_rows, j)
        clip = clipped_side_with_length(
            load_side_part_in_contact_patch(lower_side_rows, j),
            math.sqrt(
                (d.x_from_face_centre - c.x_from_face_centre) ** 2 + (d.y_from_face_centre - c.y_from_face_centre) ** 2
            ),
        )
        store_side_part_in_contact_patch(lower_side_rows, j, clip)
        joint_rows[PATCH_PERIMETER_ROW_OFFSET + j] += clip.length


@njit(**INTERNAL_COMPILE_OPTIONS)
def clip_lower_sides_and_add_lengths_to_perimeter(
    joint_rows: Any, joint_point_rows: Any, base_corner_count: int, lower_face_corner_count: int, lane_count: int
) -> None:
    """Clip all sides of the lower face by the upper stone's base, and add their lengths to the patch's perimeter."""
    for k in range(lower_face_corner_count):
        following = (k + 1) % lower_face_corner_count
        side = slice_contact_point_rows(joint_point_rows, base_corner_count + k)
        next_corner = slice_contact_point_rows(joint_point_rows, base_corner_count + following)
        start_clipping_with_whole_side(side, lane_count)
        reset_base_overhang_before_clipping(side, lane_count)
        for i in range(base_corner_count):
            n = (i + 1) % base_corner_count
            clip_lower_side_and_update_overhang(
                side,
                next_corner,
                slice_contact_point_rows(joint_point_rows, i),
                slice_contact_point_rows(joint_point_rows, n),
                lane_count,
            )
        add_clipped_lower_side_to_patch_perimeter(joint_rows, side, next_corner, lane_count)
