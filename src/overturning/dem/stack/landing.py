"""Flat landings of a joint (contact of two stones): landing times of its points, and points without load meanwhile."""

from typing import Final

from numba import njit

from overturning.dem.body.base_contact import longest_landing_time_including_point
from overturning.dem.body.state import LANDING_TIME_VALUE_FOR_BASE_IN_AIR
from overturning.dem.kernel.lanes import INLINE_OPTIONS
from overturning.dem.stack.joint_state import (
    ContactPointPosition,
    ContactPointState,
    JointConstants,
    RemainingFlatLandingTimes,
)

LANDING_TIME_WITHOUT_POINTS: Final = 1e300
"""Shortest landing time of a joint without points, s."""
MAX_FLAT_PATCH_HEIGHT_TO_PENETRATION_RATIO: Final = 20.0
"""Largest difference in height of the points of a flat patch, as a multiple of its largest penetration."""
RIM_DISTANCE_WITHOUT_DEFERRED_CONTACT: Final = 1e301
"""More than the distance of a base on the ground from a rim, m."""
MIN_RIM_DISTANCE_RATIO_FOR_DEFERRED_CONTACT: Final = 0.01
"""Distance of a base from the rim of the face below up to which no corner waits, as a share of the patch's width."""
MAX_HEIGHT_SHARE_OF_PATCH_END_POINT: Final = 0.05
"""Share of the difference in height within which a point lies at the far end of the patch."""


@njit(**INLINE_OPTIONS)
def contact_points_land_together(landing: RemainingFlatLandingTimes) -> bool:
    """True if all contact points of two stones touch down in one impact, a flat landing.

    Dashpots may pull during this impact.
    """
    return (landing.shortest > 0.0) & (landing.shortest < LANDING_TIME_WITHOUT_POINTS)


@njit(**INLINE_OPTIONS)
def point_contact_is_deferred(
    joint: JointConstants,
    landing: RemainingFlatLandingTimes,
    position: ContactPointPosition,
    previous: ContactPointState,
    distance_from_rim: float,
) -> bool:
    """True if a contact point between the two ends of a base that lands flat carries no load yet.

    A flat base that lands on all its corners at once is stopped by the impulse at its far end; corners in between take
    up their springs only afterwards (docs/method.md). No point is deferred while a corner of the base is near the rim
    of the face below (`distance_from_rim`, m, negative beyond it): the points where both rims cross move along them,
    and would be deferred again and again.
    """
    spread = landing.highest_point_height - landing.lowest_point_height
    is_open = (
        (previous.penetration <= 0.0) & (previous.stiffness_share > 0.0) & (previous.penetration_without_force == 0.0)
    )
    inner = (position.z > landing.lowest_point_height + MAX_HEIGHT_SHARE_OF_PATCH_END_POINT * spread) & (
        position.z < landing.highest_point_height - MAX_HEIGHT_SHARE_OF_PATCH_END_POINT * spread
    )
    inner = inner & (spread < MAX_FLAT_PATCH_HEIGHT_TO_PENETRATION_RATIO * -landing.lowest_point_height)
    whole = distance_from_rim >= joint.min_rim_distance_of_waiting_corners
    # A point that has taken up its spring does not wait again.
    still_waits = (
        (previous.penetration_without_force > 0.0)
        & (previous.remaining_flat_landing_time > 0.0)
        & (previous.penetration <= 0.0)
    )
    return whole & (still_waits | (is_open & inner))


@njit(**INLINE_OPTIONS)
def include_point_in_landing_times_and_heights(
    landing: RemainingFlatLandingTimes, point: ContactPointState, position: ContactPointPosition
) -> RemainingFlatLandingTimes:
    """Return the landing times and the range of heights of two stones' contact points with one more point included."""
    lowest = (
        position.z
        if (position.stiffness_share > 0.0) & (position.z < landing.lowest_point_height)
        else landing.lowest_point_height
    )
    highest = (
        position.z
        if (position.stiffness_share > 0.0) & (position.z > landing.highest_point_height)
        else landing.highest_point_height
    )
    counts = point.stiffness_share > 0.0
    left = (
        point.remaining_flat_landing_time
        if counts & (point.remaining_flat_landing_time < landing.shortest)
        else landing.shortest
    )
    longest = longest_landing_time_including_point(
        landing.longest, point.remaining_flat_landing_time, point.penetration
    )
    return RemainingFlatLandingTimes(left, longest if counts else landing.longest, lowest, highest)


@njit(**INLINE_OPTIONS)
def remaining_landing_time_of_new_contact(joint: JointConstants, landing: RemainingFlatLandingTimes) -> float:
    """Return the time left (s) in a flat landing for a point that comes into contact.

    It is that of the points already in contact, or the full duration if there are none.
    """
    return joint.landing_duration if landing.longest == LANDING_TIME_VALUE_FOR_BASE_IN_AIR else landing.longest
