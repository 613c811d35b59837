"""How a case ends: what an element has done by the end of a sample, and what that means for its column."""

from typing import Any, Final

import numpy as np
from numba import njit

from overturning.dem.lanes import INLINE, OPTIONS
from overturning.dem.mechanics import larger
from overturning.dem.polygon import rows
from overturning.dem.polygon import tables as t
from overturning.dem.polygon.energy import closing_work, energy, kinetic, moving_energy
from overturning.dem.polygon.faces import rotated
from overturning.dem.polygon.state import Element, Pose
from overturning.dem.status import Status

SAFE_TILT: Final = 0.1
SAFE_SLIP: Final = 1.0
SAFE_ENERGY: Final = 0.1
"""After a fall: rotation over α, slip over half its height and kinetic energy over its barrier up to which an element that
the rest of the record cannot lift is taken to stand for good."""

GOES_ON: Final = -1
"""Instead of a `Status`: the case has not ended."""


@njit(**OPTIONS)
def verdict(state: Any, j: int, layout: Any, elements: int, rules: Any, limits: Any, end: float, gravity: float) -> int:
    """`Status` of a column at the end of a sample, or `GOES_ON`."""
    case = rows.load_case(state, j)
    check, moving, standing, fallen, safe, slid = 0.0, 0.0, 0, 0, 0, False
    for i in range(elements):
        e = rows.of_element(state, i)
        item = rows.load_element(e, j)
        check += item.pose.x + item.pose.z + item.velocity.x + item.velocity.z + item.velocity.w + item.pose.cos
        if rules[i, t.IS_FREE] == 0.0:
            continue
        moving += kinetic(item)
        slid = slid or abs(item.standing.slip) > 0.1 * abs(item.standing.base_z)
        if item.standing.side == 0.0:
            e[rows.SIDE + j] = side_of(
                item, rows.load_pose(rows.of_element(state, int(rules[i, t.SUPPORT])), j), rules[i]
            )
        stands = e[rows.SIDE + j] == 0.0
        standing, fallen = standing + int(stands), fallen + int(not stands)
        safe += int(stands and is_safe(item, case.sample, rules[i, t.BARRIER]))
    if not np.isfinite(check) or deepest_of(state, j, layout, elements) > limits[t.DEEPEST_ALLOWED]:
        return Status.UNSTABLE
    if standing == 0 or (fallen > 0 and safe == standing):
        return Status.SIMULATED
    if case.sample < end and case.sample < case.calm:
        return GOES_ON
    # A scene at rest after the last instant at which it could start stays as it is: nothing moves, and every standing
    # element has at least two loaded ends.
    if moving < limits[t.REST_ENERGY] and grip(state, j, layout, elements, rules) >= 2 * standing:
        return Status.SIMULATED
    if case.sample >= end:
        spare = energy(state, j, layout, elements, gravity) - case.energy
        bound = fallen == 0 and not slid and spare < 0.5 * limits[t.LEAST_BARRIER]
        # Nothing can fall then; the largest rotations are known once what is left cannot reach them again.
        if bound and not may_rise(state, j, elements, rules, spare):
            return Status.SIMULATED
        return last_verdict(case.sample >= case.after, moving < 1e-4 * limits[t.LEAST_SCALE])
    return GOES_ON


@njit(**OPTIONS)
def last_verdict(late: bool, still: bool) -> int:
    """On a case whose elements could still fall after the record: undecided once it is late, unless they are still."""
    if not late:
        return GOES_ON
    return Status.SIMULATED if still else Status.UNDECIDED


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
            if rules[i, t.IS_FREE] > 0.0 and rows.of_element(state, i)[rows.SIDE + j] == 0.0:
                total += touching
    return total


@njit(**OPTIONS)
def side_of(item: Element, on: Pose, rules: Any) -> float:
    """To which side an element has fallen from what it stands on: ±1, or 0 where it has not."""
    if item.course.peak_angle >= rules[t.FALL_ANGLE]:
        return 1.0 if item.pose.angle > 0.0 else -1.0
    if item.pose.z < rules[t.LOWEST]:
        x, _ = point_of(item.pose, item.standing.base_x, item.standing.base_z)
        ox, _ = point_of(on, item.standing.support_x, item.standing.support_z)
        return 1.0 if x > ox else -1.0
    return 0.0


@njit(**OPTIONS)
def is_safe(e: Element, sample: float, barrier: float) -> bool:
    """Whether an element stands upright, nearly in its place and nearly at rest, and the shaking to come is too weak for it."""
    return bool(
        sample >= e.standing.safe_from
        and abs(e.pose.angle) < SAFE_TILT * e.body.critical
        and abs(e.standing.slip) < SAFE_SLIP * abs(e.standing.base_z)
        and kinetic(e) < SAFE_ENERGY * barrier
    )


@njit(**OPTIONS)
def may_rise(state: Any, j: int, elements: int, rules: Any, spare: float) -> bool:
    """Whether an energy could turn an element that has rocked farther than it has been: E/E_max = 1 − (1 − θ/α)²."""
    for e in range(elements):
        item = rows.load_element(rows.of_element(state, e), j)
        reached = item.course.peak_angle / item.body.critical
        if rules[e, t.IS_FREE] == 0.0 or reached < 1e-3:
            continue
        share = min(max(spare / rules[e, t.BARRIER], 0.0), 1.0)
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
    """Distance of an element's base from its place on the support, along it, and when it was last below the critical angle."""
    for j in range(rows.COLUMNS):
        item, support, sample = rows.load_element(e, j), rows.load_pose(on, j), rows.load_case(own, j).sample
        standing, passed = item.standing, item.course.last_upright
        x, z = point_of(item.pose, standing.base_x, standing.base_z)
        ox, oz = point_of(support, standing.support_x, standing.support_z)
        slip = support.cos * (x - ox) - support.sin * (z - oz)
        stood = (passed >= 0.0) & (standing.side == 0.0)
        e[rows.SLIP + j] = slip
        e[rows.PEAK_SLIP + j] = larger(standing.peak_slip, abs(slip))
        e[rows.UPRIGHT_UNTIL + j] = (sample + passed * scale) * interval if stood else standing.upright_until
        e[rows.LAST_UPRIGHT + j] = -1.0


@njit(**OPTIONS)
def finish(
    state: Any,
    j: int,
    layout: Any,
    elements: int,
    limits: Any,
    status: int,
    steps: int,
    gravity: float,
    out: Any,
    each: Any,
) -> None:
    """Write the results of a column."""
    work, taken = 0.0, closing_work(state, j, layout, elements)
    for p in range(layout.shape[0]):
        taken += rows.load_pair(rows.of_pair(state, elements, p), j).taken
    for e in range(elements):
        item = rows.load_element(rows.of_element(state, e), j)
        course, standing = item.course, item.standing
        work += course.work
        each[e, t.E_SIDE] = standing.side
        each[e, t.E_TIME] = standing.upright_until if standing.side != 0.0 else np.nan
        each[e, t.E_ANGLE] = min(course.peak_angle, 0.5 * np.pi) / item.body.critical
        each[e, t.E_SLIP], each[e, t.E_RESIDUAL] = standing.peak_slip, standing.slip
    balance = (moving_energy(state, j, elements, gravity) - rows.load_case(state, j).energy) - work + taken
    out[t.R_STATUS], out[t.R_DEPTH], out[t.R_STEPS] = status, deepest_of(state, j, layout, elements), steps
    out[t.R_ENERGY] = abs(balance) / max(work, limits[t.LEAST_SCALE], taken)
