"""Normal of contact of two stones where the upper stone leans over the rim of the lower one.

Where corners of the upper base touch the lower face, the normal of contact is that of the lower face. Where the rim of
the lower face carries the upper base, the normal is that of the upper base, as far as the base is inclined across that
side of the rim. The frame of a joint takes the mean of both, weighted by the loads, so that the contact force of a
stone that tips over a rim does no work where the stone slides along its base (docs/method.md).
"""

import math
from typing import Any, Final

from numba import njit

from overturning.dem.body.state import squared_sine_of_lean_continued_beyond_90_deg
from overturning.dem.body.vectors import (
    Matrix3,
    Vector3,
    cross_product,
    matrix_product,
    matrix_times_vector,
    minus,
    plus,
    scale_vector,
    transpose,
)
from overturning.dem.kernel.lanes import (
    INLINE_OPTIONS,
    INTERNAL_COMPILE_OPTIONS,
    NO_ALIAS_COMPILE_OPTIONS,
    assume_lane_count_is_multiple_of_8,
)
from overturning.dem.stack.access import (
    load_base_overhang_and_normal_slopes,
    load_contact_load_sums_for_normal,
    load_face_corner,
    load_joint_frame,
    load_point_position,
    load_relative_motion,
    load_stone_axes,
    load_stone_constants,
    store_contact_load_sums_for_normal,
    store_joint_frame,
    store_point_position,
    store_relative_motion,
)
from overturning.dem.stack.clip import slice_contact_point_rows
from overturning.dem.stack.joint_state import (
    ContactPointPosition,
    JointFrameAxesAndOrigin,
    JointRelativePoseAndVelocity,
    LoadSumsToFindContactNormal,
)
from overturning.dem.stack.relative_motion import predicted_motion_relative_to_contact_frame

OVERHANG_TO_SIDE_DISTANCE_FOR_FULL_RIM_NORMAL: Final = 0.005
"""Overhang from which the rim's normal counts in full, as a share of the distance of that side from the centre.

Below it the normal turns in proportion, so that forces are continuous when a corner passes the rim."""


@njit(**INLINE_OPTIONS)
def slopes_of_upper_base_normal(relative_motion: JointRelativePoseAndVelocity) -> tuple[float, float]:
    """Return the horizontal components of the normal of the upper stone's base, divided by the vertical one."""
    normal = cross_product(relative_motion.upper_x_axis, relative_motion.upper_y_axis)
    up = normal.z if normal.z > 0.1 else 0.1
    return normal.x / up, normal.y / up


@njit(**INLINE_OPTIONS)
def contact_normal_weight_of_rim_side(base_overhang_beyond_side: float, side_distance_from_face_centre: float) -> float:
    """Return the weight, 0 to 1, with which the normal at a side of the lower face's rim counts in the contact normal.

    The weight is proportional to the overhang of the upper base beyond this side, and 1 from an overhang of
    `OVERHANG_TO_SIDE_DISTANCE_FOR_FULL_RIM_NORMAL` × `side_distance_from_face_centre`.
    """
    share = base_overhang_beyond_side / (OVERHANG_TO_SIDE_DISTANCE_FOR_FULL_RIM_NORMAL * side_distance_from_face_centre)
    share = share if share > 0.0 else 0.0
    return share if share < 1.0 else 1.0


@njit(**INLINE_OPTIONS)
def add_point_to_contact_normal_sums(
    contact_normal_sums: LoadSumsToFindContactNormal,
    point_position: ContactPointPosition,
    contact_normal_slope_xy_at_point: tuple[float, float],
) -> LoadSumsToFindContactNormal:
    """Return the load-weighted sums for the contact normal, with a point added whose normal has the given slope."""
    load = point_position.joint_stiffness_share * (
        -point_position.upper_base_height_above_lower_face
        if point_position.upper_base_height_above_lower_face < 0.0
        else 0.0
    )
    return LoadSumsToFindContactNormal(
        contact_normal_sums.stiffness_share_times_penetration + load,
        contact_normal_sums.stiffness_share_times_penetration_times_x + load * point_position.x_in_lower_face_frame,
        contact_normal_sums.stiffness_share_times_penetration_times_y + load * point_position.y_in_lower_face_frame,
        contact_normal_sums.stiffness_share_times_penetration_times_slope_x
        + load * contact_normal_slope_xy_at_point[0],
        contact_normal_sums.stiffness_share_times_penetration_times_slope_y
        + load * contact_normal_slope_xy_at_point[1],
    )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def clear_contact_normal_sums(joint_rows: Any, lane_count: int) -> None:
    """Clear the sums from which the normal of contact of two stones follows, for all stacks in parallel."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        store_contact_load_sums_for_normal(joint_rows, j, LoadSumsToFindContactNormal(0.0, 0.0, 0.0, 0.0, 0.0))


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def add_base_corner_to_normal_sums(joint_rows: Any, rows_of_one_base_corner: Any, lane_count: int) -> None:
    """Add a corner of the upper stone's base to the load-weighted sums for the contact normal, for all stacks."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        store_contact_load_sums_for_normal(
            joint_rows,
            j,
            add_point_to_contact_normal_sums(
                load_contact_load_sums_for_normal(joint_rows, j),
                load_point_position(rows_of_one_base_corner, j),
                (0.0, 0.0),
            ),
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def add_lower_corner_and_side_ends_to_normal_sums(
    joint_rows: Any,
    lower_side_rows: Any,
    previous_lower_side_rows: Any,
    part_begin_point_rows: Any,
    part_end_point_rows: Any,
    lane_count: int,
) -> None:
    """Add a corner of the lower face and both ends of its clipped side to the sums for the contact normal."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        own, previous = load_face_corner(lower_side_rows, j), load_face_corner(previous_lower_side_rows, j)
        slope_x, slope_y = slopes_of_upper_base_normal(load_relative_motion(joint_rows, j))
        rim, other = (
            load_base_overhang_and_normal_slopes(lower_side_rows, j),
            load_base_overhang_and_normal_slopes(previous_lower_side_rows, j),
        )
        full, corner = (
            contact_normal_weight_of_rim_side(
                rim.max_base_corner_distance_beyond_side, own.next_side_distance_from_face_centre
            ),
            contact_normal_weight_of_rim_side(
                other.max_base_corner_distance_beyond_side, previous.next_side_distance_from_face_centre
            ),
        )
        corner = full if full < corner else corner
        # Sides that cross at a small angle would have a horizontal normal.
        most = math.sqrt(slope_x * slope_x + slope_y * slope_y)
        begin = full * (
            rim.contact_normal_slope_at_clipped_side_start
            if rim.contact_normal_slope_at_clipped_side_start < most
            else most
        )
        last = full * (
            rim.contact_normal_slope_at_clipped_side_end
            if rim.contact_normal_slope_at_clipped_side_end < most
            else most
        )
        loads = add_point_to_contact_normal_sums(
            load_contact_load_sums_for_normal(joint_rows, j),
            load_point_position(lower_side_rows, j),
            (corner * slope_x, corner * slope_y),
        )
        loads = add_point_to_contact_normal_sums(
            loads,
            load_point_position(part_begin_point_rows, j),
            (begin * own.next_side_outward_normal_x, begin * own.next_side_outward_normal_y),
        )
        store_contact_load_sums_for_normal(
            joint_rows,
            j,
            add_point_to_contact_normal_sums(
                loads,
                load_point_position(part_end_point_rows, j),
                (last * own.next_side_outward_normal_x, last * own.next_side_outward_normal_y),
            ),
        )


@njit(**INLINE_OPTIONS)
def rotation_from_z_axis_to_normal(unit_normal: Vector3) -> Matrix3:
    """Return the smallest rotation that turns the z axis to a normal (unit vector with positive z)."""
    x, y, z = unit_normal.x, unit_normal.y, unit_normal.z
    unit = 1.0 / (1.0 + z)
    return Matrix3(
        1.0 - x * (x * unit), -(x * (y * unit)), x, -(x * (y * unit)), 1.0 - y * (y * unit), y, -x, -y, z
    )  # fmt: skip


@njit(**INLINE_OPTIONS)
def contact_frame_with_mean_normal(contact_normal_sums: LoadSumsToFindContactNormal) -> JointFrameAxesAndOrigin:
    """Return axes and origin of the coordinate frame of a contact, with the mean normal, in the lower face's frame.

    The origin is the foot of the perpendicular from the centre of the lower face to the plane with this normal through
    the mean position of the loads.
    """
    one = 1.0 / (
        contact_normal_sums.stiffness_share_times_penetration
        if contact_normal_sums.stiffness_share_times_penetration > 0.0
        else 1.0
    )
    x = contact_normal_sums.stiffness_share_times_penetration_times_slope_x * one
    y = contact_normal_sums.stiffness_share_times_penetration_times_slope_y * one
    z = 1.0 / math.sqrt(1.0 + (x * x + y * y))
    normal = Vector3(x * z, y * z, z)
    height = (
        normal.x * contact_normal_sums.stiffness_share_times_penetration_times_x
        + normal.y * contact_normal_sums.stiffness_share_times_penetration_times_y
    ) * one
    return JointFrameAxesAndOrigin(rotation_from_z_axis_to_normal(normal), scale_vector(height, normal))


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def express_point_in_mean_normal_frame(joint_rows: Any, point_rows: Any, lane_count: int) -> None:
    """Express one contact point in the frame rotated to the mean normal: position in the plane, distance along z."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        pose = contact_frame_with_mean_normal(load_contact_load_sums_for_normal(joint_rows, j))
        place = load_point_position(point_rows, j)
        turned = matrix_times_vector(
            transpose(pose.axes),
            minus(Vector3(place.x_in_lower_face_frame, place.y_in_lower_face_frame, 0.0), pose.origin),
        )
        store_point_position(
            point_rows,
            j,
            ContactPointPosition(
                turned.x, turned.y, pose.axes.zz * place.upper_base_height_above_lower_face, place.joint_stiffness_share
            ),
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def rotate_contact_frame_and_motion_to_mean_normal(
    upper_stone_rows: Any, lower_stone_rows: Any, joint_rows: Any, lane_count: int
) -> None:
    """Rotate the coordinate frame of two stones' contact to the mean normal; express their relative motion in it."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        turn = contact_frame_with_mean_normal(load_contact_load_sums_for_normal(joint_rows, j))
        pose = load_joint_frame(joint_rows, j)
        old = load_relative_motion(joint_rows, j)
        axes = matrix_product(pose.axes, turn.axes)
        origin = plus(pose.origin, matrix_times_vector(pose.axes, turn.origin))
        new = predicted_motion_relative_to_contact_frame(upper_stone_rows, lower_stone_rows, j, axes, origin)
        store_joint_frame(joint_rows, j, JointFrameAxesAndOrigin(axes, origin))
        store_relative_motion(joint_rows, j, JointRelativePoseAndVelocity(
            new.upper_base_centre, new.upper_x_axis, new.upper_y_axis, new.velocity_at_origin, new.angular_velocity,
            old.smallest_distance_of_base_corners_inside_rim, old.contact_patch_perimeter
        ))  # fmt: skip


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def keep_lower_face_normal_beyond_critical_lean(upper_stone_rows: Any, joint_rows: Any, lane_count: int) -> None:
    """Use the lower face's normal as contact normal where a stone leans beyond its base's critical angle.

    This is done for all stacks. Such a stone has fallen as soon as a corner of its base is below the rim
    (`base_corner_hangs_below_supporting_face`).
    """
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        rim, axes = load_contact_load_sums_for_normal(joint_rows, j), load_stone_axes(upper_stone_rows, j)
        upright = (
            squared_sine_of_lean_continued_beyond_90_deg(axes)
            < load_stone_constants(upper_stone_rows, j).critical_lean_squared_sine_on_whole_base
        )
        store_contact_load_sums_for_normal(
            joint_rows,
            j,
            LoadSumsToFindContactNormal(
                rim.stiffness_share_times_penetration,
                rim.stiffness_share_times_penetration_times_x,
                rim.stiffness_share_times_penetration_times_y,
                rim.stiffness_share_times_penetration_times_slope_x if upright else 0.0,
                rim.stiffness_share_times_penetration_times_slope_y if upright else 0.0,
            ),
        )


@njit(**INTERNAL_COMPILE_OPTIONS)
def sum_contact_loads_positions_and_normals(
    upper_stone_rows: Any,
    joint_rows: Any,
    joint_point_rows: Any,
    base_corner_count: int,
    lower_face_corner_count: int,
    lane_count: int,
) -> None:
    """Sum loads, positions and normals of two stones' contact points, from which their mean normal of contact follows.

    This is for bases of which only a part rests on the face below.
    """
    corners, crossings = base_corner_count + lower_face_corner_count, 2 * (base_corner_count + lower_face_corner_count)
    clear_contact_normal_sums(joint_rows, lane_count)
    for i in range(base_corner_count):
        add_base_corner_to_normal_sums(joint_rows, slice_contact_point_rows(joint_point_rows, i), lane_count)
    for k in range(lower_face_corner_count):
        add_lower_corner_and_side_ends_to_normal_sums(
            joint_rows,
            slice_contact_point_rows(joint_point_rows, base_corner_count + k),
            slice_contact_point_rows(
                joint_point_rows, base_corner_count + (k + lower_face_corner_count - 1) % lower_face_corner_count
            ),
            slice_contact_point_rows(joint_point_rows, corners + base_corner_count + k),
            slice_contact_point_rows(joint_point_rows, crossings + base_corner_count + k),
            lane_count,
        )
    keep_lower_face_normal_beyond_critical_lean(upper_stone_rows, joint_rows, lane_count)
