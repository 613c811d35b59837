"""Patch of a joint: the part that the upper base and the lower face have in common, and the stiffness of its points.

The patch is taken in the plane of the lower face. Its rim consists of parts of the sides of the upper base and parts of
the sides of the lower face. A point stands for half of each part of the rim that ends at it, so its share of
the joint's stiffness is continuous where corners appear or vanish (docs/method.md).
"""

import math
from typing import Any, Final

from numba import njit

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
    create_window_slicer,
    round_to_vector_multiple,
    select,
)
from overturning.dem.stack.access import (
    IS_SIMULATED_ROW,
    OLD_NON_CORNER_LOAD_ROW,
    OLD_STIFFNESS_SHARE_ROW,
    STIFFNESS_SHARE_ROW,
    load_axes,
    load_clip,
    load_constants,
    load_frame,
    load_outline,
    load_place,
    load_predicted,
    load_rim_side,
    store_clip,
    store_frame,
    store_joint_pose,
    store_place,
    store_rim_side,
)
from overturning.dem.stack.joint_state import (
    JOINT_ROW_LAYOUT,
    POINT_ROW_LAYOUT,
    BaseOverhangAtSide,
    ContactPointPosition,
    FaceCorner,
    JointFrameAxesAndOrigin,
    JointRelativeMotion,
    SidePartInContactPatch,
)
from overturning.dem.stack.state import PredictedStone, StoneConstants

point_window: Final = create_window_slicer(POINT_ROW_LAYOUT.size)
"""Return the rows of a point of a joint."""
RIM_DISTANCE_ROW: Final = JOINT_ROW_LAYOUT.row_offset_of_field(JointRelativeMotion, "min_rim_distance")
PATCH_PERIMETER_ROW: Final = JOINT_ROW_LAYOUT.row_offset_of_field(JointRelativeMotion, "patch_perimeter")


@njit(**INLINE_OPTIONS)
def upper_face_centre(constants: StoneConstants, stone: PredictedStone, axes: Matrix3) -> Vector3:
    """Return the position (m) of the centre of a stone's upper face at the predicted end of a step."""
    return plus(stone.position, scale_vector(constants.upper_face_height, Vector3(axes.xz, axes.yz, axes.zz)))


@njit(**INLINE_OPTIONS)
def relative_motion_at_lower_face(
    upper: StoneConstants, stone: PredictedStone, axes: Matrix3, lower_axes: Matrix3, origin: Vector3, lower: Any
) -> JointRelativeMotion:
    """Return pose and velocity of a stone relative to the face below it at the predicted end of a step.

    `lower` holds the velocity of the lower stone at the origin and its angular velocity.
    """
    to_face = transpose(lower_axes)
    relative = matrix_product(to_face, axes)
    apart = matrix_times_vector(to_face, minus(stone.position, origin))
    at = minus(origin, stone.position)
    velocity = minus(plus(stone.end_velocity, cross_product(stone.end_angular_velocity, at)), lower[0])
    x_axis, y_axis = Vector3(relative.xx, relative.yx, relative.zx), Vector3(relative.xy, relative.yy, relative.zy)
    return JointRelativeMotion(
        base_centre=minus(apart, scale_vector(upper.centre_height, Vector3(relative.xz, relative.yz, relative.zz))),
        upper_x_axis=x_axis, upper_y_axis=y_axis, velocity=matrix_times_vector(to_face, velocity),
        angular_velocity=matrix_times_vector(to_face, minus(stone.end_angular_velocity, lower[1])),
        min_rim_distance=1e300, patch_perimeter=0.0,
    )  # fmt: skip


@njit(**INLINE_OPTIONS)
def relative_motion_in_contact_frame(
    upper_rows: Any, lower_rows: Any, j: int, axes: Matrix3, origin: Vector3
) -> JointRelativeMotion:
    """Return a stone's predicted motion relative to a frame (axes and origin) that is fixed to the stone below."""
    below = load_predicted(lower_rows, j)
    velocity = plus(below.end_velocity, cross_product(below.end_angular_velocity, minus(origin, below.position)))
    return relative_motion_at_lower_face(
        load_constants(upper_rows, j), load_predicted(upper_rows, j), load_axes(upper_rows, j), axes, origin,
        (velocity, below.end_angular_velocity),
    )  # fmt: skip


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def predict_motion_relative_to_ground(upper_rows: Any, joint_rows: Any, lane_count: int) -> None:
    """Predict pose and velocity of the lowest stone relative to the ground, for all stacks in parallel."""
    for j in range(round_to_vector_multiple(lane_count)):
        still = Vector3(0.0, 0.0, 0.0)
        level = Matrix3(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
        store_frame(joint_rows, j, relative_motion_at_lower_face(
            load_constants(upper_rows, j), load_predicted(upper_rows, j), load_axes(upper_rows, j), level, still,
            (still, still),
        ))  # fmt: skip


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def predict_motion_relative_to_stone_below(upper_rows: Any, lower_rows: Any, joint_rows: Any, lane_count: int) -> None:
    """Predict pose and velocity of a stone relative to the upper face of the stone below, for all stacks."""
    for j in range(round_to_vector_multiple(lane_count)):
        axes = load_axes(lower_rows, j)
        origin = upper_face_centre(load_constants(lower_rows, j), load_predicted(lower_rows, j), axes)
        store_joint_pose(joint_rows, j, JointFrameAxesAndOrigin(axes, origin))
        store_frame(joint_rows, j, relative_motion_in_contact_frame(upper_rows, lower_rows, j, axes, origin))


@njit(**INLINE_OPTIONS)
def base_corner_contact_point(frame: JointRelativeMotion, corner: FaceCorner, present: float) -> ContactPointPosition:
    """Return the position of a base corner on the lower face, and its share of the stiffness if all corners rest."""
    return ContactPointPosition(
        frame.base_centre.x + (corner.x * frame.upper_x_axis.x + corner.y * frame.upper_y_axis.x),
        frame.base_centre.y + (corner.x * frame.upper_x_axis.y + corner.y * frame.upper_y_axis.y),
        frame.base_centre.z + (corner.x * frame.upper_x_axis.z + corner.y * frame.upper_y_axis.z),
        corner.stiffness_share * present,
    )  # fmt: skip


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def predict_base_corner_position(upper_rows: Any, joint_rows: Any, point: Any, lane_count: int) -> None:
    """Compute the predicted position of one corner of a stone's base on its support, for all stacks in parallel."""
    for j in range(round_to_vector_multiple(lane_count)):
        is_simulated = upper_rows[IS_SIMULATED_ROW + j]
        place = base_corner_contact_point(load_frame(joint_rows, j), load_outline(point, j), is_simulated)
        store_place(point, j, place)


@njit(**INTERNAL_COMPILE_OPTIONS)
def predict_base_corner_positions(
    upper_rows: Any, joint_rows: Any, points: Any, upper_count: int, lane_count: int
) -> None:
    """Compute the predicted positions of all corners of a stone's base on its support, for all stacks in parallel."""
    for i in range(upper_count):
        predict_base_corner_position(upper_rows, joint_rows, point_window(points, i), lane_count)


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def include_corner_in_min_rim_distance(joint_rows: Any, point: Any, side: Any, lane_count: int) -> None:
    """Update the least distance of base corners from the rim of the face below by one corner and one side.

    The distance of the corner from the side is taken if it is the least so far; this is done for all stacks.
    """
    for j in range(round_to_vector_multiple(lane_count)):
        place, limit = load_place(point, j), load_outline(side, j)
        free = limit.side_distance - (limit.side_normal_x * place.x + limit.side_normal_y * place.y)
        free = free if place.stiffness_share > 0.0 else 1e300
        least = joint_rows[RIM_DISTANCE_ROW + j]
        joint_rows[RIM_DISTANCE_ROW + j] = select(free < least, free, least)


@njit(**INTERNAL_COMPILE_OPTIONS)
def all_bases_on_lower_face(joint_rows: Any, points: Any, upper_count: int, lower_count: int, lane_count: int) -> bool:
    """True if, in all stacks, a stone's whole base rests on the face below, now and after the last step."""
    for i in range(upper_count):
        for k in range(lower_count):
            side = point_window(points, upper_count + k)
            include_corner_in_min_rim_distance(joint_rows, point_window(points, i), side, lane_count)
    number = 0
    for j in range(round_to_vector_multiple(lane_count)):
        number += 1 if (joint_rows[RIM_DISTANCE_ROW + j] < 0.0) | (joint_rows[OLD_NON_CORNER_LOAD_ROW + j] > 0.0) else 0
    return number == 0


@njit(**INTERNAL_COMPILE_OPTIONS)
def any_stack_uses_contact_point(point: Any, lane_count: int) -> bool:
    """True if a contact point has a share of stiffness above 0 in any of the stacks, now or after the last step."""
    number = 0
    for j in range(round_to_vector_multiple(lane_count)):
        number += 1 if (point[STIFFNESS_SHARE_ROW + j] > 0.0) | (point[OLD_STIFFNESS_SHARE_ROW + j] > 0.0) else 0
    return number > 0


@njit(**INLINE_OPTIONS)
def clip_side_by_half_plane(clip: SidePartInContactPatch, at_begin: float, at_end: float) -> SidePartInContactPatch:
    """Clip a part of a face's side by a half plane, given how far both ends of the side lie inside the half plane."""
    crosses = (at_begin < 0.0) != (at_end < 0.0)
    share = at_begin / (at_begin - at_end if crosses else 1.0)
    outside = (at_begin < 0.0) & (at_end < 0.0)
    begin = share if crosses & (at_begin < 0.0) & (share > clip.begin) else clip.begin
    end = share if crosses & (at_end < 0.0) & (share < clip.end) else clip.end
    return SidePartInContactPatch(begin, (-1.0 if outside else end), clip.length)


@njit(**INLINE_OPTIONS)
def set_length_of_clipped_side(clip: SidePartInContactPatch, length: float) -> SidePartInContactPatch:
    """Return the clipped part of a face's side with its length, m; `length` is that of the whole side, m."""
    part = clip.end - clip.begin
    return SidePartInContactPatch(clip.begin, clip.end, length * part if part > 0.0 else 0.0)


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def reset_clipped_side(point: Any, lane_count: int) -> None:
    """Start the clipping of a side of a face with the whole side, for all stacks in parallel."""
    for j in range(round_to_vector_multiple(lane_count)):
        store_clip(point, j, SidePartInContactPatch(0.0, 1.0, 0.0))


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def clip_base_side(point: Any, next_corner: Any, side: Any, lane_count: int) -> None:
    """Clip a side of the upper stone's base by the line of one side of the lower face, for all stacks in parallel."""
    for j in range(round_to_vector_multiple(lane_count)):
        a, b, limit = load_place(point, j), load_place(next_corner, j), load_outline(side, j)
        store_clip(point, j, clip_side_by_half_plane(
            load_clip(point, j), limit.side_distance - (limit.side_normal_x * a.x + limit.side_normal_y * a.y),
            limit.side_distance - (limit.side_normal_x * b.x + limit.side_normal_y * b.y),
        ))  # fmt: skip


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def add_clipped_base_side_length(joint_rows: Any, point: Any, next_corner: Any, lane_count: int) -> None:
    """Compute the length of a side of a stone's base after clipping, and add it to the contact patch's perimeter."""
    for j in range(round_to_vector_multiple(lane_count)):
        a, b = load_place(point, j), load_place(next_corner, j)
        clip = set_length_of_clipped_side(load_clip(point, j), math.sqrt((b.x - a.x) ** 2 + (b.y - a.y) ** 2))
        store_clip(point, j, clip)
        joint_rows[PATCH_PERIMETER_ROW + j] += clip.length


@njit(**INTERNAL_COMPILE_OPTIONS)
def clip_base_sides(joint_rows: Any, points: Any, upper_count: int, lower_count: int, lane_count: int) -> None:
    """Clip all sides of a stone's base by the face below, and add their lengths to the contact patch's perimeter."""
    for i in range(upper_count):
        point, following = point_window(points, i), (i + 1) % upper_count
        next_corner = point_window(points, following)
        reset_clipped_side(point, lane_count)
        for k in range(lower_count):
            clip_base_side(point, next_corner, point_window(points, upper_count + k), lane_count)
        add_clipped_base_side_length(joint_rows, point, next_corner, lane_count)


@njit(**INLINE_OPTIONS)
def double_signed_area(a: ContactPointPosition, b: ContactPointPosition, x: float, y: float) -> float:
    """Return twice the area (m²) of the triangle a, b, (x, y): positive if (x, y) lies to the left of side a–b."""
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)


@njit(**INLINE_OPTIONS)
def normal_slope_at_crossing_of_sides(lower: FaceCorner, a: ContactPointPosition, b: ContactPointPosition) -> float:
    """Return the slope (≥ 0) of the contact normal where side a–b of the upper base crosses a lower face's side.

    The normal is perpendicular to both sides; the slope is that across the side of the lower face.
    """
    across = lower.side_normal_x * (b.x - a.x) + lower.side_normal_y * (b.y - a.y)
    slope = (a.z - b.z) / (across if across != 0.0 else 1.0)
    return slope if (across != 0.0) & (slope > 0.0) else 0.0


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def clear_overhang_and_normal_slopes(side: Any, lane_count: int) -> None:
    """Clear overhang and slopes of the contact normals of a side of the lower face, for all stacks in parallel."""
    for j in range(round_to_vector_multiple(lane_count)):
        store_rim_side(side, j, BaseOverhangAtSide(-1e300, 0.0, 0.0))


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def clip_side_of_lower_face(side: Any, next_corner: Any, begin: Any, end: Any, lane_count: int) -> None:
    """Clip a side of the lower face by one side of the upper stone's base, for all stacks in parallel."""
    for j in range(round_to_vector_multiple(lane_count)):
        a, b = load_place(begin, j), load_place(end, j)
        c, d = load_outline(side, j), load_outline(next_corner, j)
        old, rim = load_clip(side, j), load_rim_side(side, j)
        new = clip_side_by_half_plane(old, double_signed_area(a, b, c.x, c.y), double_signed_area(a, b, d.x, d.y))
        slope = normal_slope_at_crossing_of_sides(c, a, b)
        beyond = (c.side_normal_x * a.x + c.side_normal_y * a.y) - c.side_distance
        store_clip(side, j, new)
        store_rim_side(side, j, BaseOverhangAtSide(
            overhang=beyond if beyond > rim.overhang else rim.overhang,
            normal_slope_at_begin=slope if new.begin > old.begin else rim.normal_slope_at_begin,
            normal_slope_at_end=slope if new.end < old.end else rim.normal_slope_at_end,
        ))  # fmt: skip


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def add_clipped_lower_side_length(joint_rows: Any, side: Any, next_corner: Any, lane_count: int) -> None:
    """Compute the length of a side of the lower face after clipping, and add it to the contact patch's perimeter."""
    for j in range(round_to_vector_multiple(lane_count)):
        c, d = load_outline(side, j), load_outline(next_corner, j)
        clip = set_length_of_clipped_side(load_clip(side, j), math.sqrt((d.x - c.x) ** 2 + (d.y - c.y) ** 2))
        store_clip(side, j, clip)
        joint_rows[PATCH_PERIMETER_ROW + j] += clip.length


@njit(**INTERNAL_COMPILE_OPTIONS)
def clip_sides_of_lower_face(joint_rows: Any, points: Any, upper_count: int, lower_count: int, lane_count: int) -> None:
    """Clip all sides of the lower face by the upper stone's base, and add their lengths to the patch's perimeter."""
    for k in range(lower_count):
        following = (k + 1) % lower_count
        side = point_window(points, upper_count + k)
        next_corner = point_window(points, upper_count + following)
        reset_clipped_side(side, lane_count)
        clear_overhang_and_normal_slopes(side, lane_count)
        for i in range(upper_count):
            n = (i + 1) % upper_count
            clip_side_of_lower_face(side, next_corner, point_window(points, i), point_window(points, n), lane_count)
        add_clipped_lower_side_length(joint_rows, side, next_corner, lane_count)


@njit(**INLINE_OPTIONS)
def contact_point_on_side(
    a: ContactPointPosition, b: ContactPointPosition, t: float, stiffness: float
) -> ContactPointPosition:
    """Return the point on the side from a to b at the share t of its length from a, with a share of stiffness."""
    return ContactPointPosition(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), a.z + t * (b.z - a.z), stiffness)


@njit(**INLINE_OPTIONS)
def base_point_above_lower_face(frame: JointRelativeMotion, x: float, y: float, share: float) -> ContactPointPosition:
    """Return the point of a stone's base above point (x, y) of the lower face, with its share of the stiffness."""
    normal = cross_product(frame.upper_x_axis, frame.upper_y_axis)
    # A base that stands on edge has no height above the face; its stone has fallen.
    up = normal.z if normal.z > 0.1 else 0.1
    z = frame.base_centre.z - (normal.x * (x - frame.base_centre.x) + normal.y * (y - frame.base_centre.y)) / up
    return ContactPointPosition(x, y, z, share)


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def place_contact_points_of_lower_side(
    joint_rows: Any, side: Any, next_corner: Any, previous_side: Any, start: Any, end: Any, lane_count: int
) -> None:
    """Store positions and shares of stiffness of the three possible contact points of one side of a lower face.

    They are the corner at which the side starts and both ends of the side after clipping to the upper face.
    """
    for j in range(round_to_vector_multiple(lane_count)):
        frame, c, d = load_frame(joint_rows, j), load_outline(side, j), load_outline(next_corner, j)
        own, previous = load_clip(side, j), load_clip(previous_side, j)
        unit = 0.5 / (frame.patch_perimeter if frame.patch_perimeter > 0.0 else 1.0)
        part = unit * own.length if frame.min_rim_distance < 0.0 else 0.0
        other = unit * previous.length if frame.min_rim_distance < 0.0 else 0.0
        corner = (part if own.begin == 0.0 else 0.0) + (other if previous.end == 1.0 else 0.0)
        at, to = own.begin, own.end
        store_place(side, j, base_point_above_lower_face(frame, c.x, c.y, corner))
        store_place(start, j, base_point_above_lower_face(
            frame, c.x + at * (d.x - c.x), c.y + at * (d.y - c.y), part if at > 0.0 else 0.0
        ))  # fmt: skip
        store_place(end, j, base_point_above_lower_face(
            frame, c.x + to * (d.x - c.x), c.y + to * (d.y - c.y), part if to < 1.0 else 0.0
        ))  # fmt: skip


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def place_contact_points_of_base_side(
    joint_rows: Any, point: Any, next_corner: Any, previous_side: Any, start: Any, end: Any, lane_count: int
) -> None:
    """Store the contact points at the ends of a clipped side of a stone's base, with shares of stiffness."""
    for j in range(round_to_vector_multiple(lane_count)):
        frame, a, b = load_frame(joint_rows, j), load_place(point, j), load_place(next_corner, j)
        own, previous = load_clip(point, j), load_clip(previous_side, j)
        unit = 0.5 / (frame.patch_perimeter if frame.patch_perimeter > 0.0 else 1.0)
        within = frame.min_rim_distance >= 0.0
        part, other = (0.0 if within else unit * own.length), (0.0 if within else unit * previous.length)
        corner = (part if own.begin == 0.0 else 0.0) + (other if previous.end == 1.0 else 0.0)
        store_place(start, j, contact_point_on_side(a, b, own.begin, part if own.begin > 0.0 else 0.0))
        store_place(end, j, contact_point_on_side(a, b, own.end, part if own.end < 1.0 else 0.0))
        point[STIFFNESS_SHARE_ROW + j] = select(within, a.stiffness_share, corner)


@njit(**INTERNAL_COMPILE_OPTIONS)
def place_contact_points_of_partial_patch(
    joint_rows: Any, points: Any, upper_count: int, lower_count: int, lane_count: int
) -> None:
    """Compute place and stiffness of all contact points where only a part of a stone's base rests on the face below."""
    corners, crossings = upper_count + lower_count, 2 * (upper_count + lower_count)
    for k in range(lower_count):
        following, before = (k + 1) % lower_count, (k + lower_count - 1) % lower_count
        place_contact_points_of_lower_side(
            joint_rows, point_window(points, upper_count + k), point_window(points, upper_count + following),
            point_window(points, upper_count + before), point_window(points, corners + upper_count + k),
            point_window(points, crossings + upper_count + k), lane_count,
        )  # fmt: skip
    for i in range(upper_count):
        following, before = (i + 1) % upper_count, (i + upper_count - 1) % upper_count
        place_contact_points_of_base_side(
            joint_rows, point_window(points, i), point_window(points, following), point_window(points, before),
            point_window(points, corners + i), point_window(points, crossings + i), lane_count,
        )  # fmt: skip
