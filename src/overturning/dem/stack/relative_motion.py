"""Motion of a stone relative to the stone below, predicted for the step end."""

from typing import Any

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
    NO_ALIAS_COMPILE_OPTIONS,
    assume_lane_count_is_multiple_of_8,
)
from overturning.dem.stack.access import (
    load_predicted_stone,
    load_stone_axes,
    load_stone_constants,
    store_joint_frame,
    store_relative_motion,
)
from overturning.dem.stack.joint_state import (
    JointFrameAxesAndOrigin,
    JointRelativePoseAndVelocity,
)
from overturning.dem.stack.state import PredictedStone, StoneConstants


@njit(**INLINE_OPTIONS)
def predicted_upper_face_centre(
    stone_constants: StoneConstants, predicted_stone: PredictedStone, stone_axes: Matrix3
) -> Vector3:
    """Return the position (m) of the centre of a stone's upper face at the predicted end of a step."""
    return plus(
        predicted_stone.centre_position,
        scale_vector(
            stone_constants.upper_face_height_above_centre, Vector3(stone_axes.xz, stone_axes.yz, stone_axes.zz)
        ),
    )


@njit(**INLINE_OPTIONS)
def upper_stone_motion_relative_to_face_below(
    upper_stone_constants: StoneConstants,
    predicted_upper_stone: PredictedStone,
    upper_stone_axes: Matrix3,
    contact_frame_axes: Matrix3,
    contact_frame_origin: Vector3,
    lower_velocity_at_origin_and_spin: Any,
) -> JointRelativePoseAndVelocity:
    """Return pose and velocity of a stone relative to the face below it at the predicted end of a step.

    `lower_velocity_at_origin_and_spin` holds the velocity (m/s) of the lower stone at `contact_frame_origin`, and its
    angular velocity (rad/s).
    """
    to_face = transpose(contact_frame_axes)
    relative = matrix_product(to_face, upper_stone_axes)
    apart = matrix_times_vector(to_face, minus(predicted_upper_stone.centre_position, contact_frame_origin))
    at = minus(contact_frame_origin, predicted_upper_stone.centre_position)
    velocity = minus(
        plus(predicted_upper_stone.end_velocity, cross_product(predicted_upper_stone.end_angular_velocity, at)),
        lower_velocity_at_origin_and_spin[0],
    )
    x_axis, y_axis = Vector3(relative.xx, relative.yx, relative.zx), Vector3(relative.xy, relative.yy, relative.zy)
    return JointRelativePoseAndVelocity(
        upper_base_centre=minus(
            apart, scale_vector(upper_stone_constants.centre_height, Vector3(relative.xz, relative.yz, relative.zz))
        ),
        upper_x_axis=x_axis,
        upper_y_axis=y_axis,
        velocity_at_origin=matrix_times_vector(to_face, velocity),
        angular_velocity=matrix_times_vector(
            to_face, minus(predicted_upper_stone.end_angular_velocity, lower_velocity_at_origin_and_spin[1])
        ),
        smallest_distance_of_base_corners_inside_rim=1e300,
        contact_patch_perimeter=0.0,
    )


@njit(**INLINE_OPTIONS)
def predicted_motion_relative_to_contact_frame(
    upper_stone_rows: Any, lower_stone_rows: Any, lane: int, contact_frame_axes: Matrix3, contact_frame_origin: Vector3
) -> JointRelativePoseAndVelocity:
    """Return a stone's predicted motion relative to a frame (axes and origin) that is fixed to the stone below."""
    below = load_predicted_stone(lower_stone_rows, lane)
    lever_arm = minus(contact_frame_origin, below.centre_position)
    velocity = plus(below.end_velocity, cross_product(below.end_angular_velocity, lever_arm))
    return upper_stone_motion_relative_to_face_below(
        load_stone_constants(upper_stone_rows, lane), load_predicted_stone(upper_stone_rows, lane),
        load_stone_axes(upper_stone_rows, lane), contact_frame_axes, contact_frame_origin,
        (velocity, below.end_angular_velocity),
    )  # fmt: skip


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def predict_lowest_stone_motion_relative_to_ground(upper_stone_rows: Any, joint_rows: Any, lane_count: int) -> None:
    """Predict pose and velocity of the lowest stone relative to the ground, for all stacks in parallel."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        still = Vector3(0.0, 0.0, 0.0)
        level = Matrix3(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
        store_relative_motion(joint_rows, j, upper_stone_motion_relative_to_face_below(
            load_stone_constants(upper_stone_rows, j), load_predicted_stone(upper_stone_rows, j),
            load_stone_axes(upper_stone_rows, j), level, still, (still, still),
        ))  # fmt: skip


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def predict_motion_relative_to_stone_below(
    upper_stone_rows: Any, lower_stone_rows: Any, joint_rows: Any, lane_count: int
) -> None:
    """Predict pose and velocity of a stone relative to the upper face of the stone below, for all stacks."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        axes = load_stone_axes(lower_stone_rows, j)
        origin = predicted_upper_face_centre(
            load_stone_constants(lower_stone_rows, j), load_predicted_stone(lower_stone_rows, j), axes
        )
        store_joint_frame(joint_rows, j, JointFrameAxesAndOrigin(axes, origin))
        store_relative_motion(
            joint_rows,
            j,
            predicted_motion_relative_to_contact_frame(upper_stone_rows, lower_stone_rows, j, axes, origin),
        )
