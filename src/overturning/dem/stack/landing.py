"""Flat landings of a joint (contact of two stones): landing times of its points, and points without load meanwhile."""

from typing import Final

from numba import njit

from overturning.dem.body.base_contact import longest_remaining_landing_time_including_point
from overturning.dem.body.state import LONGEST_LANDING_TIME_WITHOUT_LOADED_POINTS_S
from overturning.dem.kernel.lanes import INLINE_OPTIONS
from overturning.dem.stack.joint_state import (
    ContactPointPosition,
    ContactPointState,
    FlatLandingTimesLeftAndPointHeights,
    JointConstants,
)

LANDING_TIME_PLACEHOLDER_WITHOUT_POINTS_S: Final = 1e300
"""Shortest landing time of a joint without points, s."""
MAX_FLAT_PATCH_HEIGHT_RANGE_TO_PENETRATION: Final = 20.0
"""Largest difference in height of the points of a flat patch, as a multiple of its largest penetration."""
RIM_DISTANCE_MARKING_NO_CONTACT_DEFERRAL_M: Final = 1e301
"""More than the distance of a base on the ground from a rim, m."""
MIN_RIM_DISTANCE_TO_DEFER_CORNER_CONTACT_TO_WIDTH: Final = 0.01
"""Distance of a base from the rim of the face below up to which no corner waits, as a share of the patch's width."""
HEIGHT_RANGE_SHARE_COUNTED_AS_PATCH_END: Final = 0.05
"""Share of the difference in height within which a point lies at the far end of the patch."""


@njit(**INLINE_OPTIONS)
def flat_landing_of_stone_is_under_way(landing_times_and_heights: FlatLandingTimesLeftAndPointHeights) -> bool:
    """True while a flat landing of a stone lasts: all contact points with its support touch down in one impact.

    Dashpots may pull during this impact.
    """
    return (landing_times_and_heights.shortest_remaining_impact_time_in_flat_landing > 0.0) & (
        landing_times_and_heights.shortest_remaining_impact_time_in_flat_landing
        < LANDING_TIME_PLACEHOLDER_WITHOUT_POINTS_S
    )


@njit(**INLINE_OPTIONS)
def point_contact_is_deferred(
    joint_constants: JointConstants,
    landing_times_and_heights: FlatLandingTimesLeftAndPointHeights,
    point_position: ContactPointPosition,
    point_state_at_step_start: ContactPointState,
    smallest_distance_of_base_corners_inside_rim: float,
) -> bool:
    """True if the spring of a contact point in the middle of a base that lands flat does not act yet.

    A base that lands on all its corners at once is stopped by the impulse at its far end; the springs of points between
    its lowest and its highest point act only afterwards (docs/method.md). No point is deferred while a corner of the
    base is near the rim of the face below (`smallest_distance_of_base_corners_inside_rim`, m, negative beyond it):
    points where the rim of the base crosses that of the face move along the rims, and would be deferred repeatedly.
    """
    spread = (
        landing_times_and_heights.highest_point_height_above_lower_face
        - landing_times_and_heights.lowest_point_height_above_lower_face
    )
    is_open = (
        (point_state_at_step_start.penetration <= 0.0)
        & (point_state_at_step_start.joint_stiffness_share > 0.0)
        & (point_state_at_step_start.force_free_penetration_in_flat_landing == 0.0)
    )
    inner = (
        point_position.upper_base_height_above_lower_face
        > landing_times_and_heights.lowest_point_height_above_lower_face
        + HEIGHT_RANGE_SHARE_COUNTED_AS_PATCH_END * spread
    ) & (
        point_position.upper_base_height_above_lower_face
        < landing_times_and_heights.highest_point_height_above_lower_face
        - HEIGHT_RANGE_SHARE_COUNTED_AS_PATCH_END * spread
    )
    inner = inner & (
        spread
        < MAX_FLAT_PATCH_HEIGHT_RANGE_TO_PENETRATION * -landing_times_and_heights.lowest_point_height_above_lower_face
    )
    whole = (
        smallest_distance_of_base_corners_inside_rim >= joint_constants.min_rim_distance_to_defer_flat_landing_contact
    )
    # A point that has taken up its spring does not wait again.
    still_waits = (
        (point_state_at_step_start.force_free_penetration_in_flat_landing > 0.0)
        & (point_state_at_step_start.remaining_flat_landing_time > 0.0)
        & (point_state_at_step_start.penetration <= 0.0)
    )
    return whole & (still_waits | (is_open & inner))


@njit(**INLINE_OPTIONS)
def add_point_to_landing_times_and_height_range(
    landing_times_and_heights: FlatLandingTimesLeftAndPointHeights,
    point_state_at_step_start: ContactPointState,
    point_position: ContactPointPosition,
) -> FlatLandingTimesLeftAndPointHeights:
    """Return flat-landing times and height range of two stones' contact points, updated for one more point."""
    lowest = (
        point_position.upper_base_height_above_lower_face
        if (point_position.joint_stiffness_share > 0.0)
        & (
            point_position.upper_base_height_above_lower_face
            < landing_times_and_heights.lowest_point_height_above_lower_face
        )
        else landing_times_and_heights.lowest_point_height_above_lower_face
    )
    highest = (
        point_position.upper_base_height_above_lower_face
        if (point_position.joint_stiffness_share > 0.0)
        & (
            point_position.upper_base_height_above_lower_face
            > landing_times_and_heights.highest_point_height_above_lower_face
        )
        else landing_times_and_heights.highest_point_height_above_lower_face
    )
    counts = point_state_at_step_start.joint_stiffness_share > 0.0
    left = (
        point_state_at_step_start.remaining_flat_landing_time
        if counts
        & (
            point_state_at_step_start.remaining_flat_landing_time
            < landing_times_and_heights.shortest_remaining_impact_time_in_flat_landing
        )
        else landing_times_and_heights.shortest_remaining_impact_time_in_flat_landing
    )
    longest = longest_remaining_landing_time_including_point(
        landing_times_and_heights.longest_flat_landing_time_left_of_loaded_points,
        point_state_at_step_start.remaining_flat_landing_time,
        point_state_at_step_start.penetration,
    )
    return FlatLandingTimesLeftAndPointHeights(
        left,
        longest if counts else landing_times_and_heights.longest_flat_landing_time_left_of_loaded_points,
        lowest,
        highest,
    )


@njit(**INLINE_OPTIONS)
def remaining_landing_time_of_new_contact(
    joint_constants: JointConstants, landing_times_and_heights: FlatLandingTimesLeftAndPointHeights
) -> float:
    """Return the time left (s) in a flat landing for a contact point that closes: the longest of the loaded points.

    If no point carries load yet, this is the full duration of the landing.
    """
    return (
        joint_constants.flat_landing_duration_s
        if landing_times_and_heights.longest_flat_landing_time_left_of_loaded_points
        == LONGEST_LANDING_TIME_WITHOUT_LOADED_POINTS_S
        else landing_times_and_heights.longest_flat_landing_time_left_of_loaded_points
    )
