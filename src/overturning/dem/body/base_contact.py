"""Contact of a base that lands flat: its lowest and highest points carry load first; duration of such a landing.

In a plastic landing of a rigid body the impulse acts at the far end only, because all other points lift off (see
docs/method.md). Springs at points in between would share it while they still come down.
"""

import math
from typing import Any, Final

from numba import njit

from overturning.dem.body.access import (
    VALUE_COUNT_PER_VERTEX_IN_ALL_LANES,
    load_body_axes,
    load_body_constants,
    load_body_state,
    load_extreme_vertices_and_landing_state,
    load_point_state_at_step_start,
    load_vertex,
    store_extreme_vertices_and_landing_state,
)
from overturning.dem.body.state import (
    LONGEST_LANDING_TIME_WITHOUT_LOADED_POINTS_S,
    STATE_ROW_LAYOUT,
    VERTEX_ROW_LAYOUT,
    BodyBaseContactState,
    BodyConstants,
    BodyContactPointState,
    BodyVertex,
    ContactPointAtStepStartAndEnd,
)
from overturning.dem.body.vectors import Matrix3, Vector3, matrix_times_vector, transpose
from overturning.dem.kernel.lanes import (
    INLINE_OPTIONS,
    INTERNAL_COMPILE_OPTIONS,
    NO_ALIAS_COMPILE_OPTIONS,
    assume_lane_count_is_multiple_of_8,
)
from overturning.model.solid import MAX_BASE_VERTICES_SHARING_WEIGHT_EQUALLY

MIN_BASE_VERTEX_DEPTH_TO_CENTRE_HEIGHT_RATIO: Final = 1.0 - 1e-6
"""Smallest depth of a base vertex below the centre, as a share of the height of the centre above the base."""

MAX_DASHPOT_TO_SPRING_FORCE_AT_REST: Final = 0.5
"""Largest force of the dashpot of a resting point, as a share of the force of its spring."""


@njit(**INLINE_OPTIONS)
def vertex_belongs_to_base(body: BodyConstants, vertex: BodyVertex) -> bool:
    """True if a vertex of a body is as deep below the centre as the base, so that it is a vertex of the base."""
    return (
        vertex.position_from_centre_in_body_axes.z <= -MIN_BASE_VERTEX_DEPTH_TO_CENTRE_HEIGHT_RATIO * body.centre_height
    )


@njit(**INLINE_OPTIONS)
def one_if_point_penetrates_nearly_at_rest(
    body: BodyConstants, point_state_at_step_start: BodyContactPointState
) -> float:
    """Return 1 if a point penetrates and its normal force differs by less than half from its spring force; else 0."""
    spring = body.point_normal_stiffness_per_mass * point_state_at_step_start.penetration
    return (
        1.0
        if (point_state_at_step_start.penetration > 0.0)
        & (abs(point_state_at_step_start.normal_force_per_mass - spring) < MAX_DASHPOT_TO_SPRING_FORCE_AT_REST * spring)
        else 0.0
    )


@njit(**INLINE_OPTIONS)
def update_lowest_and_highest_base_vertex(
    body: BodyConstants,
    base_contact_state_of_earlier_vertices: BodyBaseContactState,
    body_axes: Matrix3,
    vertex: BodyVertex,
    point_state_at_step_start: BodyContactPointState,
) -> BodyBaseContactState:
    """Return a base's contact state, updated if `vertex` is the lowest or highest of the base vertices so far."""
    height = matrix_times_vector(body_axes, vertex.position_from_centre_in_body_axes).z
    below = vertex_belongs_to_base(body, vertex)
    still = one_if_point_penetrates_nearly_at_rest(body, point_state_at_step_start)
    # Among equally low or high vertices choose one that rests, so that mirror images are exact.
    low = below & (
        (height < base_contact_state_of_earlier_vertices.lowest_base_vertex_height_above_centre)
        | (
            (height == base_contact_state_of_earlier_vertices.lowest_base_vertex_height_above_centre)
            & (still > base_contact_state_of_earlier_vertices.lowest_vertex_is_loaded_and_nearly_at_rest)
        )
    )
    high = below & (
        (height > base_contact_state_of_earlier_vertices.highest_base_vertex_height_above_centre)
        | (
            (height == base_contact_state_of_earlier_vertices.highest_base_vertex_height_above_centre)
            & (still > base_contact_state_of_earlier_vertices.highest_vertex_is_loaded_and_nearly_at_rest)
        )
    )
    return BodyBaseContactState(
        height if low else base_contact_state_of_earlier_vertices.lowest_base_vertex_height_above_centre,
        height if high else base_contact_state_of_earlier_vertices.highest_base_vertex_height_above_centre,
        still if low else base_contact_state_of_earlier_vertices.lowest_vertex_is_loaded_and_nearly_at_rest,
        still if high else base_contact_state_of_earlier_vertices.highest_vertex_is_loaded_and_nearly_at_rest,
        base_contact_state_of_earlier_vertices.shortest_remaining_impact_time_of_base_points,
        base_contact_state_of_earlier_vertices.longest_landing_time_left_of_loaded_points,
        base_contact_state_of_earlier_vertices.tilting_share_of_friction_moment_in_flat_landing,
    )


@njit(**INLINE_OPTIONS)
def vertex_carries_no_load_until_base_ends_rest(
    body: BodyConstants,
    base_contact_state_of_earlier_vertices: BodyBaseContactState,
    vertex: BodyVertex,
    vertex_height_above_centre: float,
    point_state_at_step_start: BodyContactPointState,
) -> bool:
    """True if a vertex between the lowest and highest one of a landing base carries no load until both rest.

    The lowest and the highest vertex are the ends of the base. A rigid base that lands flat is stopped by the impulse
    at its ends; springs in between would share this impulse. `vertex_height_above_centre` is the height of the vertex
    relative to the centre, m.
    """
    slack = body.extreme_vertex_tolerance_to_height_range * (
        base_contact_state_of_earlier_vertices.highest_base_vertex_height_above_centre
        - base_contact_state_of_earlier_vertices.lowest_base_vertex_height_above_centre
    )
    between = (
        (
            vertex_height_above_centre
            > base_contact_state_of_earlier_vertices.lowest_base_vertex_height_above_centre + slack
        )
        & (
            vertex_height_above_centre
            < base_contact_state_of_earlier_vertices.highest_base_vertex_height_above_centre - slack
        )
        & vertex_belongs_to_base(body, vertex)
    )
    return (
        between
        & (point_state_at_step_start.penetration <= 0.0)
        & (not lowest_and_highest_base_points_rest(base_contact_state_of_earlier_vertices))
    )


@njit(**INLINE_OPTIONS)
def is_body_in_flat_landing(base_contact_state_of_earlier_vertices: BodyBaseContactState) -> bool:
    """True while a body lands flat: all points of its base touch in one impact, and their dashpots may pull.

    See `overturning.dem.block.landing`.
    """
    return base_contact_state_of_earlier_vertices.shortest_remaining_impact_time_of_base_points > 0.0


@njit(**INLINE_OPTIONS)
def longest_remaining_landing_time_including_point(
    longest_landing_time_so_far: float, remaining_landing_time_of_point: float, point_penetration: float
) -> float:
    """Return the longest time (s) left of a flat landing among the contact points so far and this one.

    This point counts only if it penetrates the ground.
    """
    return (
        remaining_landing_time_of_point
        if (point_penetration > 0.0) & (remaining_landing_time_of_point > longest_landing_time_so_far)
        else longest_landing_time_so_far
    )


@njit(**INLINE_OPTIONS)
def remaining_landing_time_of_new_contact(
    body: BodyConstants, base_contact_state_of_earlier_vertices: BodyBaseContactState
) -> float:
    """Return the time (s) left of a flat landing for a contact point that touches now.

    It is the longest time left of the points already in contact, or the full duration of a flat landing if no point is
    in contact.
    """
    return (
        body.flat_landing_duration_s
        if base_contact_state_of_earlier_vertices.longest_landing_time_left_of_loaded_points
        == LONGEST_LANDING_TIME_WITHOUT_LOADED_POINTS_S
        else base_contact_state_of_earlier_vertices.longest_landing_time_left_of_loaded_points
    )


@njit(**INLINE_OPTIONS)
def lowest_and_highest_base_points_rest(
    base_contact_state_of_earlier_vertices: BodyBaseContactState,
) -> bool:
    """True if the lowest and the highest vertex of a body's base both rest on the ground."""
    return (base_contact_state_of_earlier_vertices.lowest_vertex_is_loaded_and_nearly_at_rest > 0.0) & (
        base_contact_state_of_earlier_vertices.highest_vertex_is_loaded_and_nearly_at_rest > 0.0
    )


POINT_REMAINING_LANDING_TIME_ROW_OFFSET, POINT_PENETRATION_AT_STEP_START_ROW_OFFSET = (
    VERTEX_ROW_LAYOUT.row_offset_of_field(ContactPointAtStepStartAndEnd, "at_step_start.remaining_flat_landing_time"),
    VERTEX_ROW_LAYOUT.row_offset_of_field(ContactPointAtStepStartAndEnd, "at_step_start.penetration"),
)
SHORTEST_REMAINING_LANDING_TIME_ROW_OFFSET, LONGEST_REMAINING_LANDING_TIME_ROW_OFFSET = (
    STATE_ROW_LAYOUT.row_offset_of_field(BodyBaseContactState, "shortest_remaining_impact_time_of_base_points"),
    STATE_ROW_LAYOUT.row_offset_of_field(BodyBaseContactState, "longest_landing_time_left_of_loaded_points"),
)
TILTING_SHARE_OF_FRICTION_MOMENT_ROW_OFFSET: Final = STATE_ROW_LAYOUT.row_offset_of_field(
    BodyBaseContactState, "tilting_share_of_friction_moment_in_flat_landing"
)
"""Array index at which the values of `tilting_share_of_friction_moment_in_flat_landing` start."""


@njit(**INTERNAL_COMPILE_OPTIONS)
def any_body_base_lands_flat(body_states: Any, lane_count: int) -> bool:
    """True if a flat landing (all points of the base in one impact) is under way in any case computed in parallel."""
    number = 0
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        number += 1 if is_body_in_flat_landing(load_extreme_vertices_and_landing_state(body_states, j)) else 0
    return number > 0


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def use_full_friction_moment_where_friction_tips_body(
    body_states: Any, vertex_rows: Any, length_of_vertex_rows: int, lane_count: int
) -> None:
    """Let the whole moment of friction tilt each body that friction tips over a base edge in a flat landing.

    The function sets `BodyBaseContactState.tilting_share_of_friction_moment_in_flat_landing` to 1; this share is read
    only for bodies whose base lands flat. The resultant of normal forces and friction passes through the centre if they
    act at the distance μ h ahead of it, in the direction of sliding; h is the height of the centre. If that point lies
    within the base, the normal forces balance the moment of friction.
    """
    for point in range(0, length_of_vertex_rows, VALUE_COUNT_PER_VERTEX_IN_ALL_LANES):
        one = vertex_rows[point : point + VALUE_COUNT_PER_VERTEX_IN_ALL_LANES]
        for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
            body = load_body_constants(body_states, j)
            v = load_body_state(body_states, j).velocity_relative_to_base
            edge = load_vertex(one, j)
            own = matrix_times_vector(transpose(load_body_axes(body_states, j)), Vector3(v.x, v.y, 0.0))
            ahead = (
                body.friction
                * body.centre_height
                * (edge.starting_edge_outward_normal_x * own.x + edge.starting_edge_outward_normal_y * own.y)
            )
            outside = edge.starting_edge_distance_from_point_below_centre * math.sqrt(v.x * v.x + v.y * v.y) < ahead
            body_states[TILTING_SHARE_OF_FRICTION_MOMENT_ROW_OFFSET + j] = (
                1.0 if outside else body_states[TILTING_SHARE_OF_FRICTION_MOMENT_ROW_OFFSET + j]
            )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def compute_base_contact_states(
    body_states: Any,
    vertex_rows: Any,
    start_index_of_second_vertices_of_pairs: int,
    base_vertex_count: int,
    lane_count: int,
    base_is_round: Any,
) -> None:
    """Recompute the contact state of each body's base, from the base vertices or from the points of a round rim.

    The vertices form opposite pairs; the rows of the second vertices of the pairs start at index
    `start_index_of_second_vertices_of_pairs` of `vertex_rows`.
    """
    if base_is_round:
        # The ends are the lowest and the highest point of the rim.
        for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
            body = load_body_constants(body_states, j)
            ahead = load_point_state_at_step_start(vertex_rows[:VALUE_COUNT_PER_VERTEX_IN_ALL_LANES], j)
            behind = load_point_state_at_step_start(
                vertex_rows[
                    start_index_of_second_vertices_of_pairs : start_index_of_second_vertices_of_pairs
                    + VALUE_COUNT_PER_VERTEX_IN_ALL_LANES
                ],
                j,
            )
            landing = (
                ahead.remaining_flat_landing_time
                if ahead.remaining_flat_landing_time < behind.remaining_flat_landing_time
                else behind.remaining_flat_landing_time
            )
            longest = longest_remaining_landing_time_including_point(
                longest_remaining_landing_time_including_point(
                    LONGEST_LANDING_TIME_WITHOUT_LOADED_POINTS_S, ahead.remaining_flat_landing_time, ahead.penetration
                ),
                behind.remaining_flat_landing_time,
                behind.penetration,
            )
            tilting = 0.0 if body.friction * body.centre_height <= body.round_base_radius_or_zero else 1.0
            store_extreme_vertices_and_landing_state(
                body_states,
                j,
                BodyBaseContactState(
                    0.0,
                    0.0,
                    one_if_point_penetrates_nearly_at_rest(body, ahead),
                    one_if_point_penetrates_nearly_at_rest(body, behind),
                    landing,
                    longest,
                    tilting,
                ),
            )
        return
    few = base_vertex_count <= MAX_BASE_VERTICES_SHARING_WEIGHT_EQUALLY
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        first = BodyBaseContactState(0.0, 0.0, 1.0, 1.0, 1e300, LONGEST_LANDING_TIME_WITHOUT_LOADED_POINTS_S, 0.0)
        other = BodyBaseContactState(1e300, -1e300, 0.0, 0.0, 1e300, LONGEST_LANDING_TIME_WITHOUT_LOADED_POINTS_S, 0.0)
        store_extreme_vertices_and_landing_state(body_states, j, first if few else other)
    for point in range(0, 2 * start_index_of_second_vertices_of_pairs, VALUE_COUNT_PER_VERTEX_IN_ALL_LANES):
        one = vertex_rows[point : point + VALUE_COUNT_PER_VERTEX_IN_ALL_LANES]
        for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
            of_base = vertex_belongs_to_base(load_body_constants(body_states, j), load_vertex(one, j))
            left, least = (
                one[POINT_REMAINING_LANDING_TIME_ROW_OFFSET + j],
                body_states[SHORTEST_REMAINING_LANDING_TIME_ROW_OFFSET + j],
            )
            body_states[SHORTEST_REMAINING_LANDING_TIME_ROW_OFFSET + j] = left if of_base & (left < least) else least
            longest = body_states[LONGEST_REMAINING_LANDING_TIME_ROW_OFFSET + j]
            body_states[LONGEST_REMAINING_LANDING_TIME_ROW_OFFSET + j] = (
                longest_remaining_landing_time_including_point(
                    longest, left, one[POINT_PENETRATION_AT_STEP_START_ROW_OFFSET + j]
                )
                if of_base
                else longest
            )
    if any_body_base_lands_flat(body_states, lane_count):
        use_full_friction_moment_where_friction_tips_body(
            body_states, vertex_rows, 2 * start_index_of_second_vertices_of_pairs, lane_count
        )
    if few:
        return
    for point in range(0, 2 * start_index_of_second_vertices_of_pairs, VALUE_COUNT_PER_VERTEX_IN_ALL_LANES):
        one = vertex_rows[point : point + VALUE_COUNT_PER_VERTEX_IN_ALL_LANES]
        for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
            base_contact = load_extreme_vertices_and_landing_state(body_states, j)
            store_extreme_vertices_and_landing_state(body_states, j, update_lowest_and_highest_base_vertex(
                load_body_constants(body_states, j), base_contact, load_body_axes(body_states, j), load_vertex(one, j),
                load_point_state_at_step_start(one, j),
            ))  # fmt: skip
