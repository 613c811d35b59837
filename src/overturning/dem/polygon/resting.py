"""Tests of elements of a scene: still in place, airborne, sliding, or at rest (docs/method.md)."""

from typing import Any, Final

import numpy as np
from numba import njit

from overturning.dem.kernel.ending import STILL_TO_SLIDE, UPRIGHT, body_is_still
from overturning.dem.kernel.lanes import INLINE, INNER
from overturning.dem.polygon import rows
from overturning.dem.polygon.faces import find_contact_segment_at_poses
from overturning.dem.polygon.state import OPEN, ElementState, PairState, PlanarContactPointHistory

IN_PLACE: Final = 0.2
"""Largest slip of an element at rest, as a share of α × height of its centre above the base: its joints then carry
nearly their original load."""

POINTS_PER_JOINT: Final = 2
"""Number of contact points of a joint (contact of two elements)."""

SLIDING_SHARE: Final = 1.0 - 1e-9
"""A contact point slides if its friction force is at least this share of µ × normal force."""


@njit(**INNER)
def element_has_tipped(element: ElementState, element_rules: Any) -> bool:
    """True if an element has rotated beyond the angle from which it can return to its support."""
    return bool(element.pose.angle > element_rules.tips_on or -element.pose.angle > element_rules.tips_back)


@njit(**INNER)
def element_has_tipped_or_dropped(element: ElementState, element_rules: Any) -> bool:
    """True if an element has rotated beyond the angle from which it can return, or dropped below its fall limit."""
    return bool(element_has_tipped(element, element_rules) or element.pose.z < element.home.lowest)


@njit(**INLINE)
def count_closed_contact_points(pair: PairState) -> int:
    """Count the contact points of two elements at which these touch, 0 to 2."""
    return (1 if pair.history.one.carrier != OPEN else 0) + (1 if pair.history.two.carrier != OPEN else 0)


@njit(**INNER)
def last_support_time(state: Any, lane: int, scene: Any, element_index: int, max_gap: float) -> float:
    """Return the last time (s) at which an element was on a standing support; infinity if it is on one now.

    An element is on its support if their distance is at most `max_gap` (m): a stone that hops a little has not left it.
    """
    until, had = rows.of_element(state, element_index)[rows.CARRIED_UNTIL + lane], False
    for p in range(scene.layout.shape[0]):
        if scene.layout[p, 0] != element_index and scene.layout[p, 1] != element_index:
            continue
        q, a, b = rows.pair_and_element_rows(state, scene, p)
        pair = rows.load_pair(q, lane)
        if pair.stands == 0.0 or element_index != scene.layout[p, 0 if pair.stands > 0.0 else 1]:
            continue
        had = True
        segment = find_contact_segment_at_poses(pair, rows.load_pose(a, lane), rows.load_pose(b, lane), True)
        if (segment.one.faces and segment.one.depth > -max_gap) or (segment.two.faces and segment.two.depth > -max_gap):
            on = b if pair.stands > 0.0 else a
            if on[rows.SIDE + lane] == 0.0:
                return np.inf
            until = min(until, on[rows.UPRIGHT_UNTIL + lane])
    return float(until) if had else np.inf


@njit(**INNER)
def all_elements_in_place(state: Any, lane: int, scene: Any, element_rules: Any, max_gap: float) -> bool:
    """True if no free element of a case has tipped over, dropped below its fall limit or lost its support."""
    for i in range(element_rules.size):
        if element_rules[i].is_free > 0.0 and (
            element_has_tipped_or_dropped(rows.load_element(rows.of_element(state, i), lane), element_rules[i])
            or last_support_time(state, lane, scene, i, max_gap) < np.inf
        ):
            return False
    return True


@njit(**INNER)
def any_element_airborne(state: Any, lane: int, scene: Any, element_rules: Any, max_gap: float) -> bool:
    """True if an element is more than `max_gap` (m) above its support and may land on it again."""
    for i in range(element_rules.size):
        e = rows.of_element(state, i)
        if (
            element_rules[i].is_free == 0.0
            or e[rows.SIDE + lane] != 0.0
            or element_has_tipped_or_dropped(rows.load_element(e, lane), element_rules[i])
        ):
            continue
        touching = 0
        for p in range(scene.layout.shape[0]):
            if scene.layout[p, 0] == i or scene.layout[p, 1] == i:
                q, _, _ = rows.pair_and_element_rows(state, scene, p)
                touching += count_closed_contact_points(rows.load_pair(q, lane))
        if touching == 0 and last_support_time(state, lane, scene, i, max_gap) < np.inf:
            return True
    return False


@njit(**INLINE)
def contact_point_is_sliding(pair: PairState, point_history: PlanarContactPointHistory) -> bool:
    """True if a contact point of two elements slides: its friction force has reached the limit."""
    return bool(
        point_history.carrier != OPEN
        and abs(point_history.tangent) >= SLIDING_SHARE * pair.law.friction * point_history.normal
    )


@njit(**INLINE)
def horizontal_velocity_at_height(element: ElementState, height: float) -> float:
    """Return the horizontal velocity of an element at a height above its centre, m/s; its tilt is neglected."""
    return float(element.velocity.x + element.velocity.w * (element.pose.cos * height))


@njit(**INNER)
def longest_sliding_time(state: Any, lane: int, scene: Any) -> float:
    """Return the longest time (s) in which friction stops an element that slides on its support.

    The result is 0 if no element slides on by more than `STILL_TO_SLIDE` (m); elements without friction do not count.
    """
    longest = 0.0
    for p in range(scene.layout.shape[0]):
        q, a, b = rows.pair_and_element_rows(state, scene, p)
        pair = rows.load_pair(q, lane)
        if pair.stands == 0.0 or not (
            contact_point_is_sliding(pair, pair.history.one) or contact_point_is_sliding(pair, pair.history.two)
        ):
            continue
        upper, lower = (a, b) if pair.stands > 0.0 else (b, a)
        one, on = rows.load_element(upper, lane), rows.load_element(lower, lane)
        speed = horizontal_velocity_at_height(one, one.home.base_z) - horizontal_velocity_at_height(
            on, one.home.support_z
        )
        deceleration = scene.gravity * pair.law.friction
        if speed * speed >= 2.0 * STILL_TO_SLIDE * deceleration > 0.0:
            longest = max(longest, abs(speed) / deceleration)
    return longest


@njit(**INNER)
def all_elements_upright(state: Any, lane: int, element_rules: Any) -> bool:
    """True if no free element has rotated by more than the share `UPRIGHT` of its critical angle."""
    for i in range(element_rules.size):
        item = rows.load_element(rows.of_element(state, i), lane)
        if element_rules[i].is_free > 0.0 and abs(item.pose.angle) >= UPRIGHT * item.inertia.critical:
            return False
    return True


@njit(**INNER)
def all_elements_at_rest(state: Any, lane: int, scene: Any) -> bool:
    """True if each free element is in place, nearly still, and in contact with its supports without sliding."""
    case, height = rows.load_case(state, lane), 0.0
    elements, step = scene.elements[int(case.variant)], case.step * case.attempt.length
    if case.decision.again > 0.0:
        return False
    for i in range(elements.size):
        item = rows.load_element(rows.of_element(state, i), lane)
        if elements[i].is_free == 0.0:
            continue
        height = abs(item.home.base_z)
        tilt, slip = abs(item.pose.angle), abs(item.record.slip)
        if item.record.side != 0.0 or tilt > UPRIGHT * item.inertia.critical:
            return False
        if slip > IN_PLACE * item.inertia.critical * height:
            return False
        v, a = item.velocity, item.acceleration
        speed, change = abs(v.x) + abs(v.z) + height * abs(v.w), abs(a.x) + abs(a.z) + height * abs(a.w)
        if not body_is_still(speed, change, step, case.rest_limit):
            return False
    for p in range(scene.layout.shape[0]):
        q, _, _ = rows.pair_and_element_rows(state, scene, p)
        pair = rows.load_pair(q, lane)
        slides = pair.slid_one != 0.0 or pair.slid_two != 0.0  # an open end may be marked as sliding
        if count_closed_contact_points(pair) != (0 if pair.stands == 0.0 else POINTS_PER_JOINT) or (
            pair.stands != 0.0 and slides
        ):
            return False
    return True
