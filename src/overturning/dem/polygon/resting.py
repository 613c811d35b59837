"""Tests of elements of a scene: in place, in the air, sliding or at rest (docs/method.md); closed contacts."""

from typing import Any, Final

import numpy as np
from numba import njit

from overturning.dem.kernel.ending import MAX_TILT_RATIO_AT_REST, NEGLIGIBLE_REMAINING_SLIP_M, body_is_still
from overturning.dem.kernel.lanes import INLINE_OPTIONS, INTERNAL_COMPILE_OPTIONS
from overturning.dem.kernel.mechanics import updated_maximum
from overturning.dem.polygon import rows
from overturning.dem.polygon.faces import find_contact_segment_open_if_out_of_reach
from overturning.dem.polygon.state import (
    CONTACT_CODE_OPEN,
    ElementState,
    PairState,
    PlanarContactPointStateAfterLastStep,
)

MAX_REST_SLIP_OVER_ALPHA_TIMES_CENTRE_HEIGHT: Final = 0.2
"""Largest slip of an element at rest, as a share of α × height of its centre above the base: its contacts then carry
nearly their original load."""

CONTACT_POINTS_PER_PAIR: Final = 2
"""Number of contact points of two elements."""

MIN_SLIDING_FORCE_OVER_FRICTION_LIMIT: Final = 1.0 - 1e-9
"""A contact point slides if its friction force is at least this share of µ × normal force."""


@njit(**INTERNAL_COMPILE_OPTIONS)
def element_has_tipped(element: ElementState, fall_limits_of_element: Any) -> bool:
    """True if an element has rotated beyond the angle from which it can return to its support."""
    return bool(
        element.pose.angle > fall_limits_of_element.tipping_rotation_to_plus_x
        or -element.pose.angle > fall_limits_of_element.tipping_rotation_to_minus_x
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def element_has_tipped_or_dropped(element: ElementState, fall_limits_of_element: Any) -> bool:
    """True if an element has rotated beyond the angle from which it can return, or dropped below its fall limit."""
    return bool(
        element_has_tipped(element, fall_limits_of_element)
        or element.pose.z < element.rest_pose_and_slip_measurement_points.fallen_if_centre_z_below
    )


@njit(**INLINE_OPTIONS)
def count_closed_contact_points(pair: PairState) -> int:
    """Count the closed contact points of two elements, 0 to 2."""
    return (1 if pair.history.point_1.contact_vertex_status_code != CONTACT_CODE_OPEN else 0) + (
        1 if pair.history.point_2.contact_vertex_status_code != CONTACT_CODE_OPEN else 0
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def last_supported_time_or_inf_if_supported_now(
    case_states: Any, lane: int, scene_arrays: Any, element_index: int, max_support_gap: float
) -> float:
    """Return the last time (s) at which an element was on a standing support; infinity if it is on one now.

    An element is on its support if their distance is at most `max_support_gap` (m): a stone that hops a little has
    not left it.
    """
    until, had = rows.slice_element_rows(case_states, element_index)[rows.LAST_TIME_ON_SUPPORT_ROW_OFFSET + lane], False
    for p in range(scene_arrays.pair_element_and_piece_indices.shape[0]):
        if (
            scene_arrays.pair_element_and_piece_indices[p, 0] != element_index
            and scene_arrays.pair_element_and_piece_indices[p, 1] != element_index
        ):
            continue
        q, a, b = rows.slice_pair_and_element_rows(case_states, scene_arrays, p)
        pair = rows.load_pair_state(q, lane)
        if (
            pair.rest_support_sign_plus_if_a_on_b == 0.0
            or element_index
            != scene_arrays.pair_element_and_piece_indices[p, 0 if pair.rest_support_sign_plus_if_a_on_b > 0.0 else 1]
        ):
            continue
        had = True
        segment = find_contact_segment_open_if_out_of_reach(
            pair, rows.load_pose(a, lane), rows.load_pose(b, lane), True
        )
        if (segment.point_1.vertex_projects_onto_other_face and segment.point_1.penetration > -max_support_gap) or (
            segment.point_2.vertex_projects_onto_other_face and segment.point_2.penetration > -max_support_gap
        ):
            on = b if pair.rest_support_sign_plus_if_a_on_b > 0.0 else a
            if on[rows.FALL_SIDE_ROW_OFFSET + lane] == 0.0:
                return np.inf
            until = min(until, on[rows.LAST_TIME_ABLE_TO_RETURN_ROW_OFFSET + lane])
    return float(until) if had else np.inf


@njit(**INTERNAL_COMPILE_OPTIONS)
def no_element_tipped_dropped_or_unsupported(
    case_states: Any, lane: int, scene_arrays: Any, fall_and_support_table: Any, max_support_gap: float
) -> bool:
    """True if no free element of a case has tipped over, dropped below its fall limit or lost its support."""
    for i in range(fall_and_support_table.size):
        if fall_and_support_table[i].is_free > 0.0 and (
            element_has_tipped_or_dropped(
                rows.load_element_state(rows.slice_element_rows(case_states, i), lane),
                fall_and_support_table[i],
            )
            or last_supported_time_or_inf_if_supported_now(case_states, lane, scene_arrays, i, max_support_gap) < np.inf
        ):
            return False
    return True


@njit(**INTERNAL_COMPILE_OPTIONS)
def any_element_can_still_land(
    case_states: Any, lane: int, scene_arrays: Any, fall_and_support_table: Any, max_support_gap: float
) -> bool:
    """True if an element is more than `max_support_gap` (m) above its support and may land on it again."""
    for i in range(fall_and_support_table.size):
        e = rows.slice_element_rows(case_states, i)
        if (
            fall_and_support_table[i].is_free == 0.0
            or e[rows.FALL_SIDE_ROW_OFFSET + lane] != 0.0
            or element_has_tipped_or_dropped(rows.load_element_state(e, lane), fall_and_support_table[i])
        ):
            continue
        touching = 0
        for p in range(scene_arrays.pair_element_and_piece_indices.shape[0]):
            if (
                scene_arrays.pair_element_and_piece_indices[p, 0] == i
                or scene_arrays.pair_element_and_piece_indices[p, 1] == i
            ):
                q, _, _ = rows.slice_pair_and_element_rows(case_states, scene_arrays, p)
                touching += count_closed_contact_points(rows.load_pair_state(q, lane))
        if (
            touching == 0
            and last_supported_time_or_inf_if_supported_now(case_states, lane, scene_arrays, i, max_support_gap)
            < np.inf
        ):
            return True
    return False


@njit(**INLINE_OPTIONS)
def contact_point_is_sliding(pair: PairState, point_history: PlanarContactPointStateAfterLastStep) -> bool:
    """True if a contact point of two elements slides: its friction force has reached the limit."""
    return bool(
        point_history.contact_vertex_status_code != CONTACT_CODE_OPEN
        and abs(point_history.tangential_force)
        >= MIN_SLIDING_FORCE_OVER_FRICTION_LIMIT * pair.contact_law.friction_coefficient * point_history.normal_force
    )


@njit(**INLINE_OPTIONS)
def horizontal_velocity_above_centre(element: ElementState, height_above_centre: float) -> float:
    """Return the horizontal velocity of an element at a height above its centre, m/s; its tilt is neglected."""
    return float(element.velocity.x + element.velocity.angular * (element.pose.cos * height_above_centre))


@njit(**INTERNAL_COMPILE_OPTIONS)
def longest_time_until_sliding_stops(case_states: Any, lane: int, scene_arrays: Any) -> float:
    """Return the longest time (s) in which friction stops an element that slides on its support.

    The result is 0 if no element slides on by more than `NEGLIGIBLE_REMAINING_SLIP_M` (m); elements without friction do
    not count.
    """
    longest = 0.0
    for p in range(scene_arrays.pair_element_and_piece_indices.shape[0]):
        q, a, b = rows.slice_pair_and_element_rows(case_states, scene_arrays, p)
        pair = rows.load_pair_state(q, lane)
        if pair.rest_support_sign_plus_if_a_on_b == 0.0 or not (
            contact_point_is_sliding(pair, pair.history.point_1) or contact_point_is_sliding(pair, pair.history.point_2)
        ):
            continue
        upper, lower = (a, b) if pair.rest_support_sign_plus_if_a_on_b > 0.0 else (b, a)
        one, on = rows.load_element_state(upper, lane), rows.load_element_state(lower, lane)
        speed = horizontal_velocity_above_centre(
            one, one.rest_pose_and_slip_measurement_points.base_point_z_in_element_axes
        ) - horizontal_velocity_above_centre(on, one.rest_pose_and_slip_measurement_points.base_point_z_in_support_axes)
        deceleration = scene_arrays.gravity * pair.contact_law.friction_coefficient
        if speed * speed >= 2.0 * NEGLIGIBLE_REMAINING_SLIP_M * deceleration > 0.0:
            longest = max(longest, abs(speed) / deceleration)
    return longest


@njit(**INTERNAL_COMPILE_OPTIONS)
def all_free_elements_tilt_far_below_critical_angle(case_states: Any, lane: int, fall_and_support_table: Any) -> bool:
    """True if every free element is tilted by less than the share `MAX_TILT_RATIO_AT_REST` of its critical angle."""
    for i in range(fall_and_support_table.size):
        item = rows.load_element_state(rows.slice_element_rows(case_states, i), lane)
        if (
            fall_and_support_table[i].is_free > 0.0
            and abs(item.pose.angle) >= MAX_TILT_RATIO_AT_REST * item.constants.critical_angle_or_else_fall_rotation
        ):
            return False
    return True


@njit(**INTERNAL_COMPILE_OPTIONS)
def all_elements_at_rest_in_initial_position(case_states: Any, lane: int, scene_arrays: Any) -> bool:
    """True if each free element is near its initial place, still, and touches its supports on both points, not sliding.

    Two elements of which neither carries the other at rest must not touch.
    """
    case, height = rows.load_scene_state(case_states, lane), 0.0
    elements, step = (
        scene_arrays.fall_and_support_table[int(case.scene_variant_index)],
        case.tick_duration * case.current_step_length_and_repetitions.length_in_ticks,
    )
    if case.step_decision_and_next_attempt.positive_if_rejected > 0.0:
        return False
    for i in range(elements.size):
        item = rows.load_element_state(rows.slice_element_rows(case_states, i), lane)
        if elements[i].is_free == 0.0:
            continue
        height = abs(item.rest_pose_and_slip_measurement_points.base_point_z_in_element_axes)
        tilt, slip = abs(item.pose.angle), abs(item.slip_fall_side_and_last_upright_time.current_slip_on_support)
        if (
            item.slip_fall_side_and_last_upright_time.fall_side != 0.0
            or tilt > MAX_TILT_RATIO_AT_REST * item.constants.critical_angle_or_else_fall_rotation
        ):
            return False
        if (
            slip
            > MAX_REST_SLIP_OVER_ALPHA_TIMES_CENTRE_HEIGHT
            * item.constants.critical_angle_or_else_fall_rotation
            * height
        ):
            return False
        v, a = item.velocity, item.acceleration
        speed, change = abs(v.x) + abs(v.z) + height * abs(v.angular), abs(a.x) + abs(a.z) + height * abs(a.angular)
        if not body_is_still(speed, change, step, case.max_base_acceleration_without_motion_g):
            return False
    for p in range(scene_arrays.pair_element_and_piece_indices.shape[0]):
        q, _, _ = rows.slice_pair_and_element_rows(case_states, scene_arrays, p)
        pair = rows.load_pair_state(q, lane)
        slides = (
            pair.signed_mu_of_point_1_or_0_if_sticking != 0.0 or pair.signed_mu_of_point_2_or_0_if_sticking != 0.0
        )  # an open end may be marked as sliding
        if count_closed_contact_points(pair) != (
            0 if pair.rest_support_sign_plus_if_a_on_b == 0.0 else CONTACT_POINTS_PER_PAIR
        ) or (pair.rest_support_sign_plus_if_a_on_b != 0.0 and slides):
            return False
    return True


@njit(**INTERNAL_COMPILE_OPTIONS)
def largest_penetration_so_far(case_states: Any, lane: int, scene_arrays: Any) -> float:
    """Return the largest penetration (m) between any two elements so far, for the case in column `lane`."""
    deepest = 0.0
    for p in range(scene_arrays.pair_element_and_piece_indices.shape[0]):
        q, _, _ = rows.slice_pair_and_element_rows(case_states, scene_arrays, p)
        deepest = updated_maximum(deepest, rows.load_pair_state(q, lane).history.peak_penetration)
    return deepest


@njit(**INTERNAL_COMPILE_OPTIONS)
def count_closed_points_of_standing_elements(
    case_states: Any, lane: int, scene_arrays: Any, fall_and_support_table: Any
) -> int:
    """Count the closed contact points of standing free elements; a point between two such elements counts twice."""
    total = 0
    for p in range(scene_arrays.pair_element_and_piece_indices.shape[0]):
        q, a, b = rows.slice_pair_and_element_rows(case_states, scene_arrays, p)
        for e, i in (
            (a, scene_arrays.pair_element_and_piece_indices[p, 0]),
            (b, scene_arrays.pair_element_and_piece_indices[p, 1]),
        ):
            if fall_and_support_table[i].is_free > 0.0 and e[rows.FALL_SIDE_ROW_OFFSET + lane] == 0.0:
                total += count_closed_contact_points(rows.load_pair_state(q, lane))
    return total
