"""How a case ends: what an element has done by the end of a sample, and what that means for its column."""

from typing import Any, Final

import numpy as np
from numba import njit

from overturning.dem.kernel.ending import GOES_ON
from overturning.dem.kernel.lanes import APART, INLINE, INNER, select
from overturning.dem.kernel.mechanics import larger
from overturning.dem.polygon import rows
from overturning.dem.polygon.energy import closing_work, energy, kinetic, moving_energy
from overturning.dem.polygon.faces import rotated
from overturning.dem.polygon.resting import (
    all_in_place,
    contacts,
    has_left,
    has_tipped,
    one_hops,
    one_slides,
    support_until,
)
from overturning.dem.polygon.state import Element, Home, Pose, Standing
from overturning.model.status import Status

SAFE_TILT: Final = 0.1
SAFE_SLIP: Final = 1.0
SAFE_ENERGY: Final = 0.1
"""After a fall: rotation over α, slip over half its height and kinetic energy over its barrier up to which an element
that the rest of the record cannot lift or slide is taken to stand for good, and of all that moves over the least
barrier."""

ON_IT: Final = 0.1
"""An element is on what carried it where the gap is no wider than this share of the deepest penetration allowed."""


@njit(**INNER)
def verdict(state: Any, j: int, scene: Any, stands_from: Any, end: float) -> int:
    """`Status` of a column at the end of a sample, or `GOES_ON`; the record ends at the sample `end`.

    `stands_from` are the samples from which on its parts stand for good.
    """
    case = rows.load_case(state, j)
    rules, limits = scene.elements[int(case.variant)], scene.limits[int(case.variant)]
    check, moving, standing, fallen, safe, slid = count_standing(state, j, rules)
    if not np.isfinite(check) or deepest_of(state, j, scene) > limits.deepest:
        return Status.UNSTABLE
    gap = ON_IT * limits.deepest
    # What has fallen may still be on its way down to what stands, or slide into it.
    calm = moving < SAFE_ENERGY * limits.least_barrier
    weak = fallen > 0 and safe == standing and calm and is_weak(state, j, stands_from, scene.parts, case.sample)
    if standing == 0 or (weak and not one_hops(state, j, scene, rules, gap)):
        return Status.SIMULATED
    if case.sample < end and case.sample < case.calm:
        return GOES_ON
    # A scene at rest after the last instant at which it could start stays as it is: nothing moves, and every standing
    # element has at least two loaded ends.
    if moving < limits.rest_energy and grip(state, j, scene, rules) >= 2 * standing:
        return Status.SIMULATED
    if case.sample < end:
        return GOES_ON
    if fallen == 0 and not slid and all_in_place(state, j, scene, rules, gap):
        spare = energy(state, j, scene) - case.energy
        # Nothing can fall then; the largest rotations are known once what is left cannot reach them again.
        over = spare < 0.5 * limits.least_barrier and not may_rise(state, j, rules, spare)
        if over and not one_slides(state, j, scene):
            return Status.SIMULATED
    if case.sample < case.after:
        return GOES_ON
    still = moving < 1e-4 * limits.least_scale or not may_fall(state, j, rules, scene.gravity)
    return Status.SIMULATED if still and not one_hops(state, j, scene, rules, gap) else Status.UNDECIDED


@njit(**INNER)
def count_standing(state: Any, j: int, rules: Any) -> tuple[float, float, int, int, int, bool]:
    """Count elements that stand, have fallen, and stand for good; note the side of those that fall now.

    Returns
    -------
    check, moving : float
        A sum that is finite if all poses and velocities are, and the kinetic energy of what is free, J.
    standing, fallen, safe : int
        How many stand, fell, and stand for good if the record cannot lift them.
    slid : bool
        Whether one has slid by more than a tenth of half its height.
    """
    check, moving, standing, fallen, safe, slid = 0.0, 0.0, 0, 0, 0, False
    for i in range(rules.size):
        e = rows.of_element(state, i)
        item = rows.load_element(e, j)
        check += item.pose.x + item.pose.z + item.velocity.x + item.velocity.z + item.velocity.w + item.pose.cos
        if rules[i].is_free == 0.0:
            continue
        moving += kinetic(item)
        slid = slid or abs(item.standing.slip) > 0.1 * abs(item.home.base_z)
        if item.standing.side == 0.0:
            e[rows.SIDE + j] = side_reached(item, rules[i])
        stands = e[rows.SIDE + j] == 0.0
        standing, fallen = standing + int(stands), fallen + int(not stands)
        safe += int(stands and is_safe(item, rules[i].barrier))
    return check, moving, standing, fallen, safe, slid


@njit(**INLINE)
def peak_angle(item: Element) -> float:
    """Largest rotation to either side, rad."""
    return larger(item.course.peak_back, item.course.peak_on)


@njit(**INNER)
def side_reached(item: Element, rules: Any) -> float:
    """Side to which an element has turned so far that it has fallen for good, ±1; 0 where it has not.

    The angle is that of the side over which it tips. Where both are reached, its present rotation decides.
    """
    back, on = item.course.peak_back >= rules.falls_back, item.course.peak_on >= rules.falls_on
    if back and on:
        return 1.0 if item.pose.angle > 0.0 else -1.0
    return 1.0 if on else (-1.0 if back else 0.0)


@njit(**INNER)
def may_fall(state: Any, j: int, rules: Any, gravity: float) -> bool:
    """Whether an element that stands, on a base at rest, has the energy to fall by itself.

    That is its barrier, or, without a tipping angle, a hundredth of what it loses where it is too low.
    """
    for i in range(rules.size):
        item = rows.load_element(rows.of_element(state, i), j)
        if rules[i].is_free == 0.0 or item.standing.side != 0.0 or has_left(item, rules[i]):
            continue
        own, weight = rules[i].tips_on < np.inf, item.inertia.mass * gravity
        lift = weight * max(item.pose.z - item.home.z, 0.0) if own else 0.0
        needed = rules[i].barrier if own else 0.01 * weight * (item.home.z - item.home.lowest)
        if kinetic(item) + lift > needed:
            return True
    return False


@njit(**INNER)
def judge_falls(state: Any, j: int, scene: Any, rules: Any, gap: float) -> None:
    """Say of every free element of a column that ends whether it has fallen: it no longer stands where it stood.

    It has turned to where it can rest on another face, or past the angle from which it could come back on what carried
    it, or it is too low, or nothing that carried it does so any more.
    """
    found = True
    while found:
        found = False
        for i in range(rules.size):
            e = rows.of_element(state, i)
            if rules[i].is_free == 0.0 or e[rows.SIDE + j] != 0.0:
                continue
            item, until = rows.load_element(e, j), support_until(state, j, scene, i, gap)
            if has_left(item, rules[i]):
                until = item.standing.upright_until
            if until < np.inf:
                e[rows.SIDE + j], e[rows.UPRIGHT_UNTIL + j], found = side_of(item, rules[i]), until, True


@njit(**INNER)
def deepest_of(state: Any, j: int, scene: Any) -> float:
    """Largest penetration of any pair, m."""
    deepest = 0.0
    for p in range(scene.layout.shape[0]):
        q, _, _ = rows.of_pair(state, scene, p)
        deepest = larger(deepest, rows.load_pair(q, j).history.deepest)
    return deepest


@njit(**INNER)
def grip(state: Any, j: int, scene: Any, rules: Any) -> int:
    """Loaded ends at free elements that stand."""
    total = 0
    for p in range(scene.layout.shape[0]):
        q, a, b = rows.of_pair(state, scene, p)
        for e, i in ((a, scene.layout[p, 0]), (b, scene.layout[p, 1])):
            if rules[i].is_free > 0.0 and e[rows.SIDE + j] == 0.0:
                total += contacts(rows.load_pair(q, j))
    return total


@njit(**INNER)
def side_of(item: Element, rules: Any) -> float:
    """To which side an element that ends fallen has gone, ±1: where it has tipped to, else where its centroid is now.

    What tips lies to that side of its own base, as a single block does, and however far it slid meanwhile.
    """
    way = item.pose.angle if has_tipped(item, rules) else item.pose.x - item.home.x
    return 1.0 if way > 0.0 or (way == 0.0 and item.pose.angle > 0.0) else -1.0


@njit(**INNER)
def is_weak(state: Any, j: int, stands_from: Any, parts: Any, sample: float) -> bool:
    """Whether the shaking to come is too weak for all that stands and can move as one."""
    for p in range(parts.shape[0]):
        lowest, last = rows.of_element(state, parts[p, 0]), rows.of_element(state, parts[p, 1])
        if lowest[rows.SIDE + j] == 0.0 and last[rows.SIDE + j] == 0.0 and sample < stands_from[p]:
            return False
    return True


@njit(**INNER)
def is_safe(e: Element, barrier: float) -> bool:
    """Whether an element stands upright, nearly in its place and nearly at rest."""
    return bool(
        abs(e.pose.angle) < SAFE_TILT * e.inertia.critical
        and abs(e.standing.slip) < SAFE_SLIP * abs(e.home.base_z)
        and kinetic(e) < SAFE_ENERGY * barrier
    )


@njit(**INNER)
def may_rise(state: Any, j: int, rules: Any, spare: float) -> bool:
    """Whether an energy could turn a rocking element farther than it has been: E/E_max = 1 − (1 − θ/α)²."""
    for e in range(rules.size):
        item = rows.load_element(rows.of_element(state, e), j)
        reached = peak_angle(item) / item.inertia.critical
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


@njit(**APART)
def move_home(e: Any, held: Any) -> None:
    """Move the home of an element as far as a held one under it has gone from its own: the base moves below both."""
    for j in range(rows.COLUMNS):
        pose, at, home = rows.load_pose(held, j), rows.load_home(held, j), rows.load_home(e, j)
        x, z = pose.x - at.x, pose.z - at.z
        rows.store_home(e, j, Home(
            home.base_x, home.base_z, home.support_x, home.support_z, home.x + x, home.z + z, home.lowest + z
        ))  # fmt: skip


@njit(**APART)
def note_standing(e: Any, on: Any, own: Any, scale: float, interval: float) -> None:
    """Slip of an element's base from its place on the support, and when it was last upright and not too low."""
    for j in range(rows.COLUMNS):
        item, support, sample = rows.load_element(e, j), rows.load_pose(on, j), rows.load_case(own, j).sample
        old, home, passed = item.standing, item.home, item.course.last_upright
        x, z = point_of(item.pose, home.base_x, home.base_z)
        ox, oz = point_of(support, home.support_x, home.support_z)
        slip = support.cos * (x - ox) - support.sin * (z - oz)
        stood = (passed >= 0.0) & (old.side == 0.0) & (item.pose.z >= home.lowest)
        upright = select(stood, (sample + passed * scale) * interval, old.upright_until)
        rows.store_standing(
            e, j, Standing(upright, old.carried_until, old.side, larger(old.peak_slip, abs(slip)), slip)
        )
        e[rows.LAST_UPRIGHT + j] = -1.0


@njit(**APART)
def note_carried(q: Any, a: Any, b: Any, own: Any, scale: float, interval: float) -> None:
    """When the upper element of a pair was last on the lower one that carried it at rest."""
    for j in range(rows.COLUMNS):
        pair, case = rows.load_pair(q, j), rows.load_case(own, j)
        touches = contacts(pair) > 0
        now = (case.sample + case.shaking.tick * scale) * interval
        a[rows.CARRIED_UNTIL + j] = select(touches & (pair.stands > 0.0), now, a[rows.CARRIED_UNTIL + j])
        b[rows.CARRIED_UNTIL + j] = select(touches & (pair.stands < 0.0), now, b[rows.CARRIED_UNTIL + j])


@njit(**INNER)
def write_results(state: Any, j: int, scene: Any, out: Any, each: Any) -> None:
    """Judge which elements of a column have fallen, and write its results."""
    v = int(state[rows.VARIANT + j])
    rules, limits = scene.elements[v], scene.limits[v]
    judge_falls(state, j, scene, rules, ON_IT * limits.deepest)
    work, taken = 0.0, closing_work(state, j, scene)
    for p in range(scene.layout.shape[0]):
        q, _, _ = rows.of_pair(state, scene, p)
        taken += q[rows.TAKEN + j]
    for e in range(rules.size):
        item = rows.load_element(rows.of_element(state, e), j)
        course, standing = item.course, item.standing
        work += course.work
        each[e].side = standing.side
        each[e].time = standing.upright_until if standing.side != 0.0 else np.nan
        each[e].angle = min(peak_angle(item), 0.5 * np.pi)
        each[e].slip, each[e].residual = standing.peak_slip, standing.slip
    balance = (moving_energy(state, j, scene) - rows.load_case(state, j).energy) - work + taken
    out.depth = deepest_of(state, j, scene)
    out.energy = abs(balance) / max(work, limits.least_scale, taken)
