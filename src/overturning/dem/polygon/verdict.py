"""How a case ends: what an element has done by the end of a sample, and what that means for its column."""

from typing import Any, Final

import numpy as np
from numba import njit

from overturning.dem.kernel.ending import GOES_ON
from overturning.dem.kernel.lanes import INLINE, OPTIONS
from overturning.dem.kernel.mechanics import larger
from overturning.dem.polygon import rows
from overturning.dem.polygon.energy import closing_work, energy, kinetic, moving_energy
from overturning.dem.polygon.faces import rotated, stretch_of
from overturning.dem.polygon.state import Element, Pose
from overturning.model.status import Status

SAFE_TILT: Final = 0.1
SAFE_SLIP: Final = 1.0
SAFE_ENERGY: Final = 0.1
"""After a fall: rotation over α, slip over half its height and kinetic energy over its barrier up to which an element that
the rest of the record cannot lift is taken to stand for good."""

ON_IT: Final = 0.1
"""An element is on what carried it where the gap is no wider than this share of the deepest penetration that is allowed."""


@njit(**OPTIONS)
def verdict(
    state: Any, j: int, stands_from: Any, layout: Any, parts: Any, rules: Any, limits: Any, end: float, gravity: float
) -> int:  # fmt: skip
    """`Status` of a column at the end of a sample, or `GOES_ON`.

    `stands_from` are the samples from which on its parts stand for good; `rules` and `limits` are of its variant.
    """
    elements = rules.size
    case = rows.load_case(state, j)
    check, moving, standing, fallen, safe, slid = 0.0, 0.0, 0, 0, 0, False
    for i in range(elements):
        e = rows.of_element(state, i)
        item = rows.load_element(e, j)
        check += item.pose.x + item.pose.z + item.velocity.x + item.velocity.z + item.velocity.w + item.pose.cos
        if rules[i].is_free == 0.0:
            continue
        moving += kinetic(item)
        slid = slid or abs(item.standing.slip) > 0.1 * abs(item.standing.base_z)
        if item.standing.side == 0.0 and item.course.peak_angle >= rules[i].fall_angle:
            e[rows.SIDE + j] = 1.0 if item.pose.angle > 0.0 else -1.0
        stands = e[rows.SIDE + j] == 0.0
        standing, fallen = standing + int(stands), fallen + int(not stands)
        safe += int(stands and is_safe(item, rules[i].barrier))
    if not np.isfinite(check) or deepest_of(state, j, layout, elements) > limits.deepest:
        return Status.UNSTABLE
    if standing == 0 or (fallen > 0 and safe == standing and is_weak(state, j, stands_from, parts, case.sample)):
        return Status.SIMULATED
    if case.sample < end and case.sample < case.calm:
        return GOES_ON
    # A scene at rest after the last instant at which it could start stays as it is: nothing moves, and every standing
    # element has at least two loaded ends.
    if moving < limits.rest_energy and grip(state, j, layout, elements, rules) >= 2 * standing:
        return Status.SIMULATED
    if case.sample < end:
        return GOES_ON
    gap = ON_IT * limits.deepest
    if fallen == 0 and not slid and all_in_place(state, j, layout, elements, rules, gap):
        spare = energy(state, j, layout, elements, gravity) - case.energy
        bound = spare < 0.5 * limits.least_barrier
        # Nothing can fall then; the largest rotations are known once what is left cannot reach them again.
        if bound and not may_rise(state, j, elements, rules, spare):
            return Status.SIMULATED
    if case.sample < case.after:
        return GOES_ON
    still = moving < 1e-4 * limits.least_scale
    return Status.SIMULATED if still or not may_fall(state, j, elements, rules, gravity) else Status.UNDECIDED


@njit(**OPTIONS)
def may_fall(state: Any, j: int, elements: int, rules: Any, gravity: float) -> bool:
    """Whether an element that stands, on a base at rest, has the energy to fall by itself.

    That is its barrier, or, without a tipping angle, a hundredth of what it loses where it is too low.
    """
    for i in range(elements):
        item = rows.load_element(rows.of_element(state, i), j)
        if rules[i].is_free == 0.0 or item.standing.side != 0.0 or has_left(item, rules[i]):
            continue
        own, weight = rules[i].tips_on < np.inf, item.body.mass * gravity
        lift = weight * max(item.pose.z - item.standing.home_z, 0.0) if own else 0.0
        needed = rules[i].barrier if own else 0.01 * weight * (item.standing.home_z - item.standing.lowest)
        if kinetic(item) + lift > needed:
            return True
    return False


@njit(**OPTIONS)
def has_left(e: Element, rules: Any) -> bool:
    """Whether an element has turned past the angle from which it could come back, or is too low."""
    return bool(has_tipped(e, rules) or e.pose.z < e.standing.lowest)


@njit(**OPTIONS)
def has_tipped(e: Element, rules: Any) -> bool:
    """Whether an element has turned past the angle from which it could come back."""
    return bool(e.pose.angle > rules.tips_on or -e.pose.angle > rules.tips_back)


@njit(**OPTIONS)
def support_until(state: Any, j: int, layout: Any, elements: int, i: int, gap: float) -> float:
    """Infinite where an element is still on something that carried it, and that has not fallen; else until when it was, s.

    It is on it where they are no farther apart than a `gap`, m: a stone that hops a little has not left.
    """
    e = rows.of_element(state, i)
    until, had = e[rows.CARRIED_UNTIL + j], False
    for p in range(layout.shape[0]):
        a, b = layout[p, 0], layout[p, 1]
        pair = rows.load_pair(rows.of_pair(state, elements, p), j)
        if pair.stands == 0.0 or i != (a if pair.stands > 0.0 else b):
            continue
        had = True
        ends = stretch_of(
            pair, rows.load_pose(rows.of_element(state, a), j), rows.load_pose(rows.of_element(state, b), j), True
        )
        if (ends.one.faces and ends.one.depth > -gap) or (ends.two.faces and ends.two.depth > -gap):
            on = rows.of_element(state, b if pair.stands > 0.0 else a)
            if on[rows.SIDE + j] == 0.0:
                return np.inf
            until = min(until, on[rows.UPRIGHT_UNTIL + j])
    return float(until) if had else np.inf


@njit(**OPTIONS)
def all_in_place(state: Any, j: int, layout: Any, elements: int, rules: Any, gap: float) -> bool:
    """Whether every free element of a column stands where it stood."""
    for i in range(elements):
        if rules[i].is_free > 0.0 and (
            has_left(rows.load_element(rows.of_element(state, i), j), rules[i])
            or support_until(state, j, layout, elements, i, gap) < np.inf
        ):
            return False
    return True


@njit(**OPTIONS)
def judge_falls(state: Any, j: int, layout: Any, elements: int, rules: Any, gap: float) -> None:
    """Say of every free element of a column that ends whether it has fallen: it no longer stands where it stood.

    It has turned to where it can rest on another face, or past the angle from which it could come back on what carried it, or
    it is too low, or nothing that carried it does so any more.
    """
    for _ in range(elements):
        found = False
        for i in range(elements):
            e = rows.of_element(state, i)
            if rules[i].is_free == 0.0 or e[rows.SIDE + j] != 0.0:
                continue
            item = rows.load_element(e, j)
            until = support_until(state, j, layout, elements, i, gap)
            if has_left(item, rules[i]):
                until = item.standing.upright_until
            if until < np.inf:
                e[rows.SIDE + j], e[rows.UPRIGHT_UNTIL + j], found = side_of(item, rules[i]), until, True
        if not found:
            return


@njit(**OPTIONS)
def deepest_of(state: Any, j: int, layout: Any, elements: int) -> float:
    """Largest penetration of any pair, m."""
    deepest = 0.0
    for p in range(layout.shape[0]):
        deepest = larger(deepest, rows.load_pair(rows.of_pair(state, elements, p), j).deepest)
    return deepest


@njit(**OPTIONS)
def grip(state: Any, j: int, layout: Any, elements: int, rules: Any) -> int:
    """Loaded ends at free elements that stand."""
    total = 0
    for p in range(layout.shape[0]):
        pair = rows.load_pair(rows.of_pair(state, elements, p), j)
        touching = (1 if pair.one.carrier != rows.OPEN else 0) + (1 if pair.two.carrier != rows.OPEN else 0)
        for i in (layout[p, 0], layout[p, 1]):
            if rules[i].is_free > 0.0 and rows.of_element(state, i)[rows.SIDE + j] == 0.0:
                total += touching
    return total


@njit(**OPTIONS)
def side_of(item: Element, rules: Any) -> float:
    """To which side an element that ends fallen has gone, ±1: where it has tipped to, else where its centroid is now.

    What tips lies to that side of its own base, as a single block does, and however far it slid meanwhile.
    """
    way = item.pose.angle if has_tipped(item, rules) else item.pose.x - item.standing.home_x
    return 1.0 if way > 0.0 or (way == 0.0 and item.pose.angle > 0.0) else -1.0


@njit(**OPTIONS)
def is_weak(state: Any, j: int, stands_from: Any, parts: Any, sample: float) -> bool:
    """Whether the shaking to come is too weak for all that stands and can move as one."""
    for p in range(parts.shape[0]):
        lowest, last = rows.of_element(state, parts[p, 0]), rows.of_element(state, parts[p, 1])
        if lowest[rows.SIDE + j] == 0.0 and last[rows.SIDE + j] == 0.0 and sample < stands_from[p]:
            return False
    return True


@njit(**OPTIONS)
def is_safe(e: Element, barrier: float) -> bool:
    """Whether an element stands upright, nearly in its place and nearly at rest."""
    return bool(
        abs(e.pose.angle) < SAFE_TILT * e.body.critical
        and abs(e.standing.slip) < SAFE_SLIP * abs(e.standing.base_z)
        and kinetic(e) < SAFE_ENERGY * barrier
    )


@njit(**OPTIONS)
def may_rise(state: Any, j: int, elements: int, rules: Any, spare: float) -> bool:
    """Whether an energy could turn an element that has rocked farther than it has been: E/E_max = 1 − (1 − θ/α)²."""
    for e in range(elements):
        item = rows.load_element(rows.of_element(state, e), j)
        reached = item.course.peak_angle / item.body.critical
        if rules[e].is_free == 0.0 or reached < 1e-3:
            continue
        share = min(max(spare / rules[e].barrier, 0.0), 1.0)
        if 1.0 - np.sqrt(1.0 - share) > reached:
            return True
    return False


@njit(**INLINE)
def point_of(pose: Pose, px: float, pz: float) -> tuple[float, float]:
    """Where a point of an element is."""
    x, z = rotated(pose, px, pz)
    return pose.x + x, pose.z + z


@njit(**OPTIONS)
def note_standing(e: Any, on: Any, own: Any, scale: float, interval: float) -> None:
    """Distance of an element's base from its place on the support, along it, and when it was last upright and not too low."""
    for j in range(rows.COLUMNS):
        item, support, sample = rows.load_element(e, j), rows.load_pose(on, j), rows.load_case(own, j).sample
        standing, passed = item.standing, item.course.last_upright
        x, z = point_of(item.pose, standing.base_x, standing.base_z)
        ox, oz = point_of(support, standing.support_x, standing.support_z)
        slip = support.cos * (x - ox) - support.sin * (z - oz)
        stood = (passed >= 0.0) & (standing.side == 0.0) & (item.pose.z >= standing.lowest)
        e[rows.SLIP + j] = slip
        e[rows.PEAK_SLIP + j] = larger(standing.peak_slip, abs(slip))
        e[rows.UPRIGHT_UNTIL + j] = (sample + passed * scale) * interval if stood else standing.upright_until
        e[rows.LAST_UPRIGHT + j] = -1.0


@njit(**OPTIONS)
def note_carried(q: Any, a: Any, b: Any, own: Any, scale: float, interval: float) -> None:
    """When the upper element of a pair was last on the lower one that carried it at rest."""
    for j in range(rows.COLUMNS):
        pair, shaking = rows.load_pair(q, j), rows.load_case(own, j).shaking
        touches = (pair.one.carrier != rows.OPEN) | (pair.two.carrier != rows.OPEN)
        now = (own[rows.SAMPLE + j] + shaking.tick * scale) * interval
        a[rows.CARRIED_UNTIL + j] = now if touches & (pair.stands > 0.0) else a[rows.CARRIED_UNTIL + j]
        b[rows.CARRIED_UNTIL + j] = now if touches & (pair.stands < 0.0) else b[rows.CARRIED_UNTIL + j]


@njit(**OPTIONS)
def finish_case(
    state: Any, j: int, layout: Any, rules: Any, limits: Any, gravity: float, out: Any, each: Any
) -> None:  # fmt: skip
    """Judge which elements of a column have fallen, and write its results."""
    elements = rules.size
    judge_falls(state, j, layout, elements, rules, ON_IT * limits.deepest)
    work, taken = 0.0, closing_work(state, j, layout, elements)
    for p in range(layout.shape[0]):
        taken += rows.load_pair(rows.of_pair(state, elements, p), j).taken
    for e in range(elements):
        item = rows.load_element(rows.of_element(state, e), j)
        course, standing = item.course, item.standing
        work += course.work
        each[e].side = standing.side
        each[e].time = standing.upright_until if standing.side != 0.0 else np.nan
        each[e].angle = min(course.peak_angle, 0.5 * np.pi)
        each[e].slip, each[e].residual = standing.peak_slip, standing.slip
    balance = (moving_energy(state, j, elements, gravity) - rows.load_case(state, j).energy) - work + taken
    out.depth = deepest_of(state, j, layout, elements)
    out.energy = abs(balance) / max(work, limits.least_scale, taken)
