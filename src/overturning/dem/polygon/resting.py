"""Which elements of a scene stand where they stood, and whether all are at rest (docs/method.md)."""

from typing import Any, Final

import numpy as np
from numba import njit

from overturning.dem.kernel.ending import STILL_TO_SLIDE, UPRIGHT, is_still
from overturning.dem.kernel.lanes import INLINE, INNER
from overturning.dem.polygon import rows
from overturning.dem.polygon.faces import stretch_of
from overturning.dem.polygon.state import OPEN, Element, Memory, Pair

IN_PLACE: Final = 0.2
"""At rest an element has slid by no more than this share of the arm that its tipping has, so that its joints bear
nearly what they did."""

BOTH: Final = 2
"""Ends of a joint."""

DRAGS: Final = 1.0 - 1e-9
"""An end slides whose friction is at least this share of the largest."""


@njit(**INNER)
def has_tipped(e: Element, rules: Any) -> bool:
    """Whether an element has turned past the angle from which it could come back."""
    return bool(e.pose.angle > rules.tips_on or -e.pose.angle > rules.tips_back)


@njit(**INNER)
def has_left(e: Element, rules: Any) -> bool:
    """Whether an element has turned past the angle from which it could come back, or is too low."""
    return bool(has_tipped(e, rules) or e.pose.z < e.home.lowest)


@njit(**INLINE)
def contacts(pair: Pair) -> int:
    """Number of ends that touch."""
    return (1 if pair.history.one.carrier != OPEN else 0) + (1 if pair.history.two.carrier != OPEN else 0)


@njit(**INNER)
def support_until(state: Any, j: int, scene: Any, i: int, gap: float) -> float:
    """Infinite where an element is still on something that carried it, and that has not fallen; else until when, s.

    It is on it where they are no farther apart than a `gap`, m: a stone that hops a little has not left.
    """
    until, had = rows.of_element(state, i)[rows.CARRIED_UNTIL + j], False
    for p in range(scene.layout.shape[0]):
        if scene.layout[p, 0] != i and scene.layout[p, 1] != i:
            continue
        q, a, b = rows.of_pair(state, scene, p)
        pair = rows.load_pair(q, j)
        if pair.stands == 0.0 or i != scene.layout[p, 0 if pair.stands > 0.0 else 1]:
            continue
        had = True
        ends = stretch_of(pair, rows.load_pose(a, j), rows.load_pose(b, j), True)
        if (ends.one.faces and ends.one.depth > -gap) or (ends.two.faces and ends.two.depth > -gap):
            on = b if pair.stands > 0.0 else a
            if on[rows.SIDE + j] == 0.0:
                return np.inf
            until = min(until, on[rows.UPRIGHT_UNTIL + j])
    return float(until) if had else np.inf


@njit(**INNER)
def all_in_place(state: Any, j: int, scene: Any, rules: Any, gap: float) -> bool:
    """Whether every free element of a column stands where it stood."""
    for i in range(rules.size):
        if rules[i].is_free > 0.0 and (
            has_left(rows.load_element(rows.of_element(state, i), j), rules[i])
            or support_until(state, j, scene, i, gap) < np.inf
        ):
            return False
    return True


@njit(**INNER)
def one_hops(state: Any, j: int, scene: Any, rules: Any, gap: float) -> bool:
    """Whether an element is in the air, higher than a `gap` over what carried it, and may come down on that again."""
    for i in range(rules.size):
        e = rows.of_element(state, i)
        if rules[i].is_free == 0.0 or e[rows.SIDE + j] != 0.0 or has_left(rows.load_element(e, j), rules[i]):
            continue
        touching = 0
        for p in range(scene.layout.shape[0]):
            if scene.layout[p, 0] == i or scene.layout[p, 1] == i:
                q, _, _ = rows.of_pair(state, scene, p)
                touching += contacts(rows.load_pair(q, j))
        if touching == 0 and support_until(state, j, scene, i, gap) < np.inf:
            return True
    return False


@njit(**INLINE)
def drags(pair: Pair, end: Memory) -> bool:
    """Whether friction drags on an end that touches, rather than holds it."""
    return bool(end.carrier != OPEN and abs(end.tangent) >= DRAGS * pair.law.friction * end.normal)


@njit(**INLINE)
def level_speed(e: Element, z: float) -> float:
    """Level velocity of a point of an element as high as z over its centre, but for its tilt, m/s."""
    return float(e.velocity.x + e.velocity.w * (e.pose.cos * z))


@njit(**INNER)
def one_slides(state: Any, j: int, scene: Any) -> bool:
    """Whether an element has way left to slide on what carries it that is worth waiting for; no friction stops none."""
    for p in range(scene.layout.shape[0]):
        q, a, b = rows.of_pair(state, scene, p)
        pair = rows.load_pair(q, j)
        if pair.stands == 0.0 or not (drags(pair, pair.history.one) or drags(pair, pair.history.two)):
            continue
        upper, lower = (a, b) if pair.stands > 0.0 else (b, a)
        one, on = rows.load_element(upper, j), rows.load_element(lower, j)
        speed = level_speed(one, one.home.base_z) - level_speed(on, one.home.support_z)
        if speed * speed >= 2.0 * STILL_TO_SLIDE * scene.gravity * pair.law.friction > 0.0:
            return True
    return False


@njit(**INNER)
def rests(state: Any, j: int, scene: Any) -> bool:
    """Whether all elements stand where they stood, on both ends of what carried them, and nothing moves or slides."""
    case, height = rows.load_case(state, j), 0.0
    elements, step = scene.elements[int(case.variant)], case.step * case.attempt.length
    if case.verdict.again > 0.0:
        return False
    for i in range(elements.size):
        item = rows.load_element(rows.of_element(state, i), j)
        if elements[i].is_free == 0.0:
            continue
        height = abs(item.home.base_z)
        tilt, slip = abs(item.pose.angle), abs(item.standing.slip)
        if item.standing.side != 0.0 or tilt > UPRIGHT * item.inertia.critical:
            return False
        if slip > IN_PLACE * item.inertia.critical * height:
            return False
        v, a = item.velocity, item.acceleration
        speed, change = abs(v.x) + abs(v.z) + height * abs(v.w), abs(a.x) + abs(a.z) + height * abs(a.w)
        if not is_still(speed, change, step, case.bears):
            return False
    for p in range(scene.layout.shape[0]):
        q, _, _ = rows.of_pair(state, scene, p)
        pair = rows.load_pair(q, j)
        slides = pair.slid_one != 0.0 or pair.slid_two != 0.0  # what is open may, too
        if contacts(pair) != (0 if pair.stands == 0.0 else BOTH) or (pair.stands != 0.0 and slides):
            return False
    return True
