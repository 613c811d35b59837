"""Rest of a 3-D stack: the stacks that stand still, and the base acceleration up to which they stay at rest."""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit

from overturning.dem.body.rotation import angular_velocity_from_momentum
from overturning.dem.body.state import squared_sine_of_lean_continued_beyond_90_deg
from overturning.dem.body.vectors import (
    Matrix3,
    Vector3,
    matrix_times_vector,
    minus,
    rotation_matrix,
    transpose,
    vector_length,
)
from overturning.dem.kernel.ending import (
    MAX_ACCELERATION_AT_REST_TO_REST_LIMIT_RATIO,
    MAX_TILT_RATIO_AT_REST,
    NEGLIGIBLE_REMAINING_SLIP_M,
    body_is_still,
)
from overturning.dem.kernel.lanes import INTERNAL_COMPILE_OPTIONS
from overturning.dem.stack.access import (
    VALUE_COUNT_PER_CASE_IN_ALL_LANES,
    VALUE_COUNT_PER_JOINT_IN_ALL_LANES,
    VALUE_COUNT_PER_POINT_IN_ALL_LANES,
    VALUE_COUNT_PER_STONE_IN_ALL_LANES,
    load_fall_flags_and_last_upright_time,
    load_flat_landing_times_and_point_heights,
    load_joint_constants,
    load_joint_state_at_step_start,
    load_next_step_to_attempt,
    load_point_position,
    load_point_state_at_step_start,
    load_rest_flag_and_acceleration_limits,
    load_stone_constants,
    load_stone_state,
    load_tick_length_failure_and_rest_limits,
    slice_stone_rows,
)
from overturning.dem.stack.landing import (
    MAX_FLAT_PATCH_HEIGHT_RANGE_TO_PENETRATION,
    RIM_DISTANCE_MARKING_NO_CONTACT_DEFERRAL_M,
)
from overturning.dem.stack.state import CASE_ROW_LAYOUT, TICKS_PER_WHOLE_STEP, StackRestFlagAndAccelerationLimits
from overturning.dem.stack.step import state_array_length_per_joint
from overturning.units import STANDARD_GRAVITY as GRAVITY

MAY_BE_AT_REST_ROW_OFFSET: Final = CASE_ROW_LAYOUT.row_offset_of_field(
    StackRestFlagAndAccelerationLimits, "may_be_at_rest_at_sample_start"
)
"""Array index at which the flags `StackRestFlagAndAccelerationLimits.may_be_at_rest_at_sample_start` start."""

MIN_WIDTH_TO_LENGTH_RATIO_FOR_PRESSURE_PLANE: Final = 1e-3
"""Least width of a contact patch, as a share of its length, whose points give a plane of pressure."""


class MassAndMassMomentAboveJoint(NamedTuple):
    """Stones above a joint (contact of two stones): their mass (kg), and mass times position of their centre (kg m)."""

    mass: float
    mass_times_x: float
    mass_times_y: float
    mass_times_z: float


class StiffnessShareMoments(NamedTuple):
    """Sums over the contact points of two stones: shares of stiffness, and their first and second moments."""

    stiffness_share_sum: float
    stiffness_share_times_x: float
    stiffness_share_times_y: float
    stiffness_share_times_xx: float
    stiffness_share_times_xy: float
    stiffness_share_times_yy: float


@njit(**INTERNAL_COMPILE_OPTIONS)
def mark_possibly_resting_stacks(stack_states: Any, stone_count: int, active_lane_count: int) -> int:
    """Mark (`may_be_at_rest_at_sample_start` = 1) and count the stacks that may be at rest, by a quick test."""
    number = 0
    for j in range(active_lane_count):
        length = load_next_step_to_attempt(stack_states, j).length_in_ticks
        most = (
            1.001
            * MAX_ACCELERATION_AT_REST_TO_REST_LIMIT_RATIO
            * load_rest_flag_and_acceleration_limits(stack_states, j).max_possible_base_acceleration_without_motion_g
            * GRAVITY
        )
        slow = most * (load_tick_length_failure_and_rest_limits(stack_states, j).tick_length_s * length)
        may = (length >= TICKS_PER_WHOLE_STEP) & (most > 0.0)
        for s in range(stone_count):
            rows = slice_stone_rows(stack_states, s)
            stone, gone = (
                load_stone_state(rows, j),
                not load_fall_flags_and_last_upright_time(rows, j).is_still_simulated > 0.0,
            )
            a, v = stone.acceleration_relative_to_base, stone.velocity_relative_to_base
            still = (abs(a.x) < most) & (abs(a.y) < most) & (abs(a.z) < most) & (2.0 * abs(v.z) < slow)
            may = may & (still | gone)
        stack_states[MAY_BE_AT_REST_ROW_OFFSET + j] = 1.0 if may else 0.0
        number += 1 if may else 0
    return number


@njit(**INTERNAL_COMPILE_OPTIONS)
def all_points_under_unfallen_stones_carry_load(
    stack_states: Any, lane: int, stone_count: int, max_corner_count_per_face: int
) -> bool:
    """True if all contact points of all stones that have not fallen carry load.

    Bases with more than four corners are not tested while they lie flat: some of their corners may carry nothing.
    """
    first, size = (
        VALUE_COUNT_PER_CASE_IN_ALL_LANES + stone_count * VALUE_COUNT_PER_STONE_IN_ALL_LANES,
        state_array_length_per_joint(max_corner_count_per_face),
    )
    for s in range(stone_count):
        if not load_fall_flags_and_last_upright_time(slice_stone_rows(stack_states, s), lane).is_still_simulated > 0.0:
            continue
        at = first + s * size
        landing = load_flat_landing_times_and_point_heights(
            stack_states[at : at + VALUE_COUNT_PER_JOINT_IN_ALL_LANES], lane
        )
        lies_flat = (
            landing.highest_point_height_above_lower_face - landing.lowest_point_height_above_lower_face
            < MAX_FLAT_PATCH_HEIGHT_RANGE_TO_PENETRATION * -landing.lowest_point_height_above_lower_face
        )
        if (
            load_joint_constants(
                stack_states[at : at + VALUE_COUNT_PER_JOINT_IN_ALL_LANES], lane
            ).min_rim_distance_to_defer_flat_landing_contact
            < RIM_DISTANCE_MARKING_NO_CONTACT_DEFERRAL_M
            and lies_flat
        ):
            continue
        for i in range((size - VALUE_COUNT_PER_JOINT_IN_ALL_LANES) // VALUE_COUNT_PER_POINT_IN_ALL_LANES):
            begin = at + VALUE_COUNT_PER_JOINT_IN_ALL_LANES + i * VALUE_COUNT_PER_POINT_IN_ALL_LANES
            point = load_point_state_at_step_start(
                stack_states[begin : begin + VALUE_COUNT_PER_POINT_IN_ALL_LANES], lane
            )
            if point.joint_stiffness_share > 1e-3 and not point.force_per_stiffness_share > 0.0:
                return False
    return True


@njit(**INTERNAL_COMPILE_OPTIONS)
def sum_and_moments_of_stiffness_shares(joint_point_rows: Any, lane: int) -> StiffnessShareMoments:
    """Return sum, first and second moments of the shares of stiffness of two stones' contact points."""
    total = StiffnessShareMoments(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    for i in range(joint_point_rows.size // VALUE_COUNT_PER_POINT_IN_ALL_LANES):
        rows = joint_point_rows[i * VALUE_COUNT_PER_POINT_IN_ALL_LANES : (i + 1) * VALUE_COUNT_PER_POINT_IN_ALL_LANES]
        w, at = load_point_state_at_step_start(rows, lane).joint_stiffness_share, load_point_position(rows, lane)
        total = StiffnessShareMoments(
            total.stiffness_share_sum + w,
            total.stiffness_share_times_x + w * at.x_in_lower_face_frame,
            total.stiffness_share_times_y + w * at.y_in_lower_face_frame,
            total.stiffness_share_times_xx + w * at.x_in_lower_face_frame * at.x_in_lower_face_frame,
            total.stiffness_share_times_xy + w * at.x_in_lower_face_frame * at.y_in_lower_face_frame,
            total.stiffness_share_times_yy + w * at.y_in_lower_face_frame * at.y_in_lower_face_frame,
        )
    return total


@njit(**INTERNAL_COMPILE_OPTIONS)
def first_point_unloading_acceleration_g(
    joint_point_rows: Any, lane: int, mass_centre_above_in_lower_face_frame: Vector3
) -> float:
    """Return the least base acceleration over g, in the worst direction, that unloads a contact point of two stones.

    `mass_centre_above_in_lower_face_frame` is the centre of mass of the stones above, m. The pressure is a linear
    function of the position in the contact. The result is 0 for a contact without width, or if a point carries no load.
    """
    total = sum_and_moments_of_stiffness_shares(joint_point_rows, lane)
    if not total.stiffness_share_sum > 0.0:
        return 0.0
    x, y = (
        total.stiffness_share_times_x / total.stiffness_share_sum,
        total.stiffness_share_times_y / total.stiffness_share_sum,
    )
    xx = total.stiffness_share_times_xx - total.stiffness_share_times_x * x
    xy = total.stiffness_share_times_xy - total.stiffness_share_times_x * y
    yy = total.stiffness_share_times_yy - total.stiffness_share_times_y * y
    area, width = xx * yy - xy * xy, MIN_WIDTH_TO_LENGTH_RATIO_FOR_PRESSURE_PLANE * (xx + yy)
    if not area > width * width:
        return 0.0
    least = np.inf
    off_x = mass_centre_above_in_lower_face_frame.x - x
    off_y = mass_centre_above_in_lower_face_frame.y - y
    for i in range(joint_point_rows.size // VALUE_COUNT_PER_POINT_IN_ALL_LANES):
        rows = joint_point_rows[i * VALUE_COUNT_PER_POINT_IN_ALL_LANES : (i + 1) * VALUE_COUNT_PER_POINT_IN_ALL_LANES]
        if not load_point_state_at_step_start(rows, lane).joint_stiffness_share > 0.0:
            continue
        at = load_point_position(rows, lane)
        dx, dy = at.x_in_lower_face_frame - x, at.y_in_lower_face_frame - y
        gx, gy = (yy * dx - xy * dy) / area, (xx * dy - xy * dx) / area
        # Both per weight of the stones above: pressure at rest, and its change by a base acceleration of 1 g.
        pressure = 1.0 / total.stiffness_share_sum + (gx * off_x + gy * off_y)
        change = abs(mass_centre_above_in_lower_face_frame.z) * np.sqrt(gx * gx + gy * gy)
        least = min(least, pressure / change if change > 0.0 else np.inf)
    return max(float(least), 0.0)


@njit(**INTERNAL_COMPILE_OPTIONS)
def onset_acceleration_g_of_current_stack_state(
    stack_states: Any, lane: int, stone_count: int, max_corner_count_per_face: int
) -> float:
    """Return the base acceleration over g at which a contact of a stack at rest slides, or a contact point unloads.

    Stones that have slid count at their current position; fallen stones do not count. The result is 0 if a contact is
    open or slides.
    """
    first, size = (
        VALUE_COUNT_PER_CASE_IN_ALL_LANES + stone_count * VALUE_COUNT_PER_STONE_IN_ALL_LANES,
        state_array_length_per_joint(max_corner_count_per_face),
    )
    onset, above = np.inf, MassAndMassMomentAboveJoint(0.0, 0.0, 0.0, 0.0)
    for k in range(stone_count):
        s = stone_count - 1 - k
        rows = slice_stone_rows(stack_states, s)
        if not load_fall_flags_and_last_upright_time(rows, lane).is_still_simulated > 0.0:
            continue
        mass, place = load_stone_constants(rows, lane).mass, load_stone_state(rows, lane).centre_position
        above = MassAndMassMomentAboveJoint(
            above.mass + mass,
            above.mass_times_x + mass * place.x,
            above.mass_times_y + mass * place.y,
            above.mass_times_z + mass * place.z,
        )
        joint = stack_states[first + s * size : first + (s + 1) * size]
        old = load_joint_state_at_step_start(joint[:VALUE_COUNT_PER_JOINT_IN_ALL_LANES], lane)
        friction = load_joint_constants(joint[:VALUE_COUNT_PER_JOINT_IN_ALL_LANES], lane).friction
        if not old.normal_force > 0.0 or old.slid_in_last_step_or_rejected_attempt > 0.0:
            return 0.0
        origin, axes = Vector3(0.0, 0.0, 0.0), Matrix3(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
        level = 0.0
        if s > 0:
            below = slice_stone_rows(stack_states, s - 1)
            lower = load_stone_state(below, lane)
            origin = lower.centre_position
            axes = rotation_matrix(lower.rotation)
            level = load_stone_constants(below, lane).upper_face_height_above_centre
        one = 1.0 / above.mass
        centre = matrix_times_vector(
            transpose(axes),
            minus(Vector3(one * above.mass_times_x, one * above.mass_times_y, one * above.mass_times_z), origin),
        )
        raised = Vector3(centre.x, centre.y, centre.z - level)
        onset = min(
            onset,
            first_point_unloading_acceleration_g(joint[VALUE_COUNT_PER_JOINT_IN_ALL_LANES:], lane, raised),
            friction,
        )
    return onset if above.mass > 0.0 else 0.0


@njit(**INTERNAL_COMPILE_OPTIONS)
def rest_acceleration_limit_g_or_0_if_moving(
    stack_states: Any, lane: int, stone_count: int, max_corner_count_per_face: int
) -> float:
    """Return the base acceleration over g up to which a stack at rest stays at rest; 0 if the stack is not at rest."""
    if not all_points_under_unfallen_stones_carry_load(stack_states, lane, stone_count, max_corner_count_per_face):
        return 0.0
    limit = load_rest_flag_and_acceleration_limits(
        stack_states, lane
    ).rest_limit_to_onset_acceleration_ratio * onset_acceleration_g_of_current_stack_state(
        stack_states, lane, stone_count, max_corner_count_per_face
    )
    return (
        limit if limit > 0.0 and unfallen_stones_are_upright_and_still(stack_states, lane, stone_count, limit) else 0.0
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def unfallen_stones_are_upright_and_still(
    stack_states: Any, lane: int, stone_count: int, max_base_acceleration_without_motion_g: float
) -> bool:
    """True if all stones that have not fallen are upright, with speeds and accelerations as small as at rest."""
    step = (
        load_tick_length_failure_and_rest_limits(stack_states, lane).tick_length_s
        * load_next_step_to_attempt(stack_states, lane).length_in_ticks
    )
    for s in range(stone_count):
        rows = slice_stone_rows(stack_states, s)
        if not load_fall_flags_and_last_upright_time(rows, lane).is_still_simulated > 0.0:
            continue
        constants, stone = load_stone_constants(rows, lane), load_stone_state(rows, lane)
        axes, arm = rotation_matrix(stone.rotation), constants.centre_height + constants.upper_face_height_above_centre
        spin = angular_velocity_from_momentum(
            constants.mass_times_inverse_inertia, axes, stone.angular_momentum_per_mass
        )
        turning = angular_velocity_from_momentum(
            constants.mass_times_inverse_inertia, axes, stone.contact_moment_per_mass
        )
        speed = vector_length(stone.velocity_relative_to_base) + arm * vector_length(spin)
        acceleration = vector_length(stone.acceleration_relative_to_base) + arm * vector_length(turning)
        if not body_is_still(speed, acceleration, step, max_base_acceleration_without_motion_g):
            return False
        if (
            not squared_sine_of_lean_continued_beyond_90_deg(axes)
            < MAX_TILT_RATIO_AT_REST * MAX_TILT_RATIO_AT_REST * constants.critical_lean_squared_sine_on_contact_at_rest
        ):
            return False
    return True


@njit(**INTERNAL_COMPILE_OPTIONS)
def time_until_upright_stack_stops_sliding(
    stack_states: Any, lane: int, stone_count: int, max_corner_count_per_face: int
) -> float:
    """Return the time (s) until friction has stopped all sliding contacts of the stones of an upright stack.

    The result is 0 if a stone leans, or if no contact would slide farther than `NEGLIGIBLE_REMAINING_SLIP_M` before it
    stops.
    """
    longest = 0.0
    first = VALUE_COUNT_PER_CASE_IN_ALL_LANES + stone_count * VALUE_COUNT_PER_STONE_IN_ALL_LANES
    size = state_array_length_per_joint(max_corner_count_per_face)
    for s in range(stone_count):
        rows = slice_stone_rows(stack_states, s)
        if not load_fall_flags_and_last_upright_time(rows, lane).is_still_simulated > 0.0:
            continue
        if squared_sine_of_lean_continued_beyond_90_deg(rotation_matrix(load_stone_state(rows, lane).rotation)) >= (
            MAX_TILT_RATIO_AT_REST
            * MAX_TILT_RATIO_AT_REST
            * load_stone_constants(rows, lane).critical_lean_squared_sine_on_contact_at_rest
        ):
            return 0.0
        joint = stack_states[first + s * size : first + s * size + VALUE_COUNT_PER_JOINT_IN_ALL_LANES]
        old, deceleration = (
            load_joint_state_at_step_start(joint, lane),
            GRAVITY * load_joint_constants(joint, lane).friction,
        )
        v = old.slip_velocity_at_pressure_centre
        square = v.x * v.x + v.y * v.y + v.twist_times_radius * v.twist_times_radius
        if (
            old.slid_in_last_step_or_rejected_attempt > 0.0
            and deceleration > 0.0
            and square >= 2.0 * NEGLIGIBLE_REMAINING_SLIP_M * deceleration
        ):
            longest = max(longest, np.sqrt(square) / deceleration)
    return longest
