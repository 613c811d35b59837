"""Termination of a scene case: classify each element and the case at the end of a sample."""

from typing import Any, Final

import numpy as np
from numba import njit

from overturning.dem.kernel.ending import GOES_ON
from overturning.dem.kernel.lanes import APART, INLINE, INNER, select
from overturning.dem.kernel.mechanics import larger
from overturning.dem.polygon import rows
from overturning.dem.polygon.energy import (
    case_energy,
    contact_work_of_last_half_step,
    element_kinetic_energy,
    kinetic_and_gravitational_energy,
)
from overturning.dem.polygon.faces import rotate_to_scene_axes
from overturning.dem.polygon.resting import (
    all_in_place,
    any_airborne,
    any_sliding,
    count_contacts,
    has_left,
    has_tipped,
    support_until,
)
from overturning.dem.polygon.state import ElementState, Pose, RestPose, SampleRecord
from overturning.model.status import Status

SAFE_TILT: Final = 0.1
"""Largest rotation, over α, of an element that stands for good if the rest of the record cannot lift or slide it."""
SAFE_SLIP: Final = 1.0
"""Largest slip, over half its height, of an element that stands for good."""
SAFE_ENERGY: Final = 0.1
"""Largest kinetic energy, over its barrier, of an element that stands for good; also of all moving elements, over the
lowest barrier."""

SUPPORT_GAP: Final = 0.1
"""Largest gap between an element and its support, as a share of the penetration limit."""


@njit(**INNER)
def classify(state: Any, j: int, scene: Any, stands_from: Any, end: float) -> int:
    """Return the `Status` of a case at the end of a sample, or `GOES_ON`; the record ends at sample `end`.

    `stands_from` are the samples from which its parts stand for good, shape (parts,).
    """
    case = rows.load_case(state, j)
    rules, limits = scene.elements[int(case.variant)], scene.limits[int(case.variant)]
    check, moving, standing, fallen, safe, slid = count_standing(state, j, rules)
    if not np.isfinite(check) or deepest_penetration(state, j, scene) > limits.deepest:
        return Status.UNSTABLE
    gap = SUPPORT_GAP * limits.deepest
    # A fallen element may still hit, or slide into, one that stands.
    calm = moving < SAFE_ENERGY * limits.least_barrier
    weak = (
        fallen > 0
        and safe == standing
        and calm
        and rest_of_record_is_weak(state, j, stands_from, scene.parts, case.sample)
    )
    if standing == 0 or (weak and not any_airborne(state, j, scene, rules, gap)):
        return Status.SIMULATED
    if case.sample < end and case.sample < case.calm:
        return GOES_ON
    # A scene at rest after the last time at which it could start to move stays at rest: there is no kinetic energy,
    # and every standing element has at least two loaded ends.
    if moving < limits.rest_energy and count_loaded_ends(state, j, scene, rules) >= 2 * standing:
        return Status.SIMULATED
    if case.sample < end:
        return GOES_ON
    if fallen == 0 and not slid and all_in_place(state, j, scene, rules, gap):
        spare = case_energy(state, j, scene) - case.energy
        # No element can fall with less energy than this; the peak rotations are final if it cannot reach them again.
        over = spare < 0.5 * limits.least_barrier and not may_exceed_peak(state, j, rules, spare)
        if over and not any_sliding(state, j, scene):
            return Status.SIMULATED
    if case.sample < case.after:
        return GOES_ON
    still = moving < 1e-4 * limits.least_scale or not may_fall(state, j, rules, scene.gravity)
    return Status.SIMULATED if still and not any_airborne(state, j, scene, rules, gap) else Status.UNDECIDED


@njit(**INNER)
def count_standing(state: Any, j: int, rules: Any) -> tuple[float, float, int, int, int, bool]:
    """Count the elements that stand, have fallen, and stand for good; store the side of those that fall in this sample.

    Returns
    -------
    check, moving : float
        Sum that is finite if all poses and velocities are; kinetic energy of the free elements, J.
    standing, fallen, safe : int
        Numbers of elements that stand, that fell, and that stand for good if the record cannot lift them.
    slid : bool
        True if an element has slid by more than a tenth of half its height.
    """
    check, moving, standing, fallen, safe, slid = 0.0, 0.0, 0, 0, 0, False
    for i in range(rules.size):
        e = rows.of_element(state, i)
        item = rows.load_element(e, j)
        check += item.pose.x + item.pose.z + item.velocity.x + item.velocity.z + item.velocity.w + item.pose.cos
        if rules[i].is_free == 0.0:
            continue
        moving += element_kinetic_energy(item)
        slid = slid or abs(item.record.slip) > 0.1 * abs(item.home.base_z)
        if item.record.side == 0.0:
            e[rows.SIDE + j] = side_reached(item, rules[i])
        stands = e[rows.SIDE + j] == 0.0
        standing, fallen = standing + int(stands), fallen + int(not stands)
        safe += int(stands and stands_for_good(item, rules[i].barrier))
    return check, moving, standing, fallen, safe, slid


@njit(**INLINE)
def peak_angle(item: ElementState) -> float:
    """Return the largest rotation to either side, rad."""
    return larger(item.totals.peak_back, item.totals.peak_on)


@njit(**INNER)
def side_reached(item: ElementState, rules: Any) -> float:
    """Return the side (±1) to which an element has rotated so far that it has fallen for good; 0 if it has not.

    The limit depends on the side. If both limits are reached, the current rotation decides.
    """
    back, on = item.totals.peak_back >= rules.falls_back, item.totals.peak_on >= rules.falls_on
    if back and on:
        return 1.0 if item.pose.angle > 0.0 else -1.0
    return 1.0 if on else (-1.0 if back else 0.0)


@njit(**INNER)
def may_fall(state: Any, j: int, rules: Any, gravity: float) -> bool:
    """True if a standing element has enough energy to fall while the base is at rest.

    It needs its barrier or, without a tipping angle, 1 % of the potential energy that it loses down to its fall limit.
    """
    for i in range(rules.size):
        item = rows.load_element(rows.of_element(state, i), j)
        if rules[i].is_free == 0.0 or item.record.side != 0.0 or has_left(item, rules[i]):
            continue
        own, weight = rules[i].tips_on < np.inf, item.inertia.mass * gravity
        lift = weight * max(item.pose.z - item.home.z, 0.0) if own else 0.0
        needed = rules[i].barrier if own else 0.01 * weight * (item.home.z - item.home.lowest)
        if element_kinetic_energy(item) + lift > needed:
            return True
    return False


@njit(**INNER)
def mark_fallen(state: Any, j: int, scene: Any, rules: Any, gap: float) -> None:
    """Mark the free elements of a finished case that have fallen, with side and time.

    An element has fallen if it has rotated to where it can rest on another face or past the angle from which it can
    return, if it is below its fall limit, or if none of its supports carries it any more.
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
                until = item.record.upright_until
            if until < np.inf:
                e[rows.SIDE + j], e[rows.UPRIGHT_UNTIL + j], found = fall_side(item, rules[i]), until, True


@njit(**INNER)
def deepest_penetration(state: Any, j: int, scene: Any) -> float:
    """Return the largest penetration of any pair, m."""
    deepest = 0.0
    for p in range(scene.layout.shape[0]):
        q, _, _ = rows.pair_and_element_rows(state, scene, p)
        deepest = larger(deepest, rows.load_pair(q, j).history.deepest)
    return deepest


@njit(**INNER)
def count_loaded_ends(state: Any, j: int, scene: Any, rules: Any) -> int:
    """Count the touching ends of free elements that stand."""
    total = 0
    for p in range(scene.layout.shape[0]):
        q, a, b = rows.pair_and_element_rows(state, scene, p)
        for e, i in ((a, scene.layout[p, 0]), (b, scene.layout[p, 1])):
            if rules[i].is_free > 0.0 and e[rows.SIDE + j] == 0.0:
                total += count_contacts(rows.load_pair(q, j))
    return total


@njit(**INNER)
def fall_side(item: ElementState, rules: Any) -> float:
    """Return the side to which an element has fallen, ±1: that of its rotation if it tipped, else that of its centroid.

    An element that tips lies on that side of its own base, as a single block does, however far it slid meanwhile.
    """
    way = item.pose.angle if has_tipped(item, rules) else item.pose.x - item.home.x
    return 1.0 if way > 0.0 or (way == 0.0 and item.pose.angle > 0.0) else -1.0


@njit(**INNER)
def rest_of_record_is_weak(state: Any, j: int, stands_from: Any, parts: Any, sample: float) -> bool:
    """True if the rest of the record is too weak to lift or slide any standing group that can move as one."""
    for p in range(parts.shape[0]):
        lowest, last = rows.of_element(state, parts[p, 0]), rows.of_element(state, parts[p, 1])
        if lowest[rows.SIDE + j] == 0.0 and last[rows.SIDE + j] == 0.0 and sample < stands_from[p]:
            return False
    return True


@njit(**INNER)
def stands_for_good(e: ElementState, barrier: float) -> bool:
    """True if an element stands upright, nearly in place and nearly at rest."""
    return bool(
        abs(e.pose.angle) < SAFE_TILT * e.inertia.critical
        and abs(e.record.slip) < SAFE_SLIP * abs(e.home.base_z)
        and element_kinetic_energy(e) < SAFE_ENERGY * barrier
    )


@njit(**INNER)
def may_exceed_peak(state: Any, j: int, rules: Any, spare: float) -> bool:
    """True if the energy `spare` (J) could rotate an element beyond its peak rotation: E/E_max = 1 − (1 − θ/α)²."""
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
def point_position(pose: Pose, px: float, pz: float) -> tuple[float, float]:
    """Return the position of a point of an element."""
    x, z = rotate_to_scene_axes(pose, px, pz)
    return pose.x + x, pose.z + z


@njit(**APART)
def shift_home(e: Any, held: Any) -> None:
    """Shift the rest position of an element by the motion of the held element under it relative to the moving base."""
    for j in range(rows.COLUMNS):
        pose, at, home = rows.load_pose(held, j), rows.load_home(held, j), rows.load_home(e, j)
        x, z = pose.x - at.x, pose.z - at.z
        rows.store_home(e, j, RestPose(
            home.base_x, home.base_z, home.support_x, home.support_z, home.x + x, home.z + z, home.lowest + z
        ))  # fmt: skip


@njit(**APART)
def record_sample(e: Any, on: Any, own: Any, scale: float, interval: float) -> None:
    """Record the slip of an element on its support, and the last time at which it was upright above its fall limit."""
    for j in range(rows.COLUMNS):
        item, support, sample = rows.load_element(e, j), rows.load_pose(on, j), rows.load_case(own, j).sample
        old, home, passed = item.record, item.home, item.totals.last_upright
        x, z = point_position(item.pose, home.base_x, home.base_z)
        ox, oz = point_position(support, home.support_x, home.support_z)
        slip = support.cos * (x - ox) - support.sin * (z - oz)
        stood = (passed >= 0.0) & (old.side == 0.0) & (item.pose.z >= home.lowest)
        upright = select(stood, (sample + passed * scale) * interval, old.upright_until)
        rows.store_record(
            e, j, SampleRecord(upright, old.carried_until, old.side, larger(old.peak_slip, abs(slip)), slip)
        )
        e[rows.LAST_UPRIGHT + j] = -1.0


@njit(**APART)
def record_support_time(q: Any, a: Any, b: Any, own: Any, scale: float, interval: float) -> None:
    """Record the last time at which the upper element of a pair touched the lower one that carried it at rest."""
    for j in range(rows.COLUMNS):
        pair, case = rows.load_pair(q, j), rows.load_case(own, j)
        touches = count_contacts(pair) > 0
        now = (case.sample + case.shaking.tick * scale) * interval
        a[rows.CARRIED_UNTIL + j] = select(touches & (pair.stands > 0.0), now, a[rows.CARRIED_UNTIL + j])
        b[rows.CARRIED_UNTIL + j] = select(touches & (pair.stands < 0.0), now, b[rows.CARRIED_UNTIL + j])


@njit(**INNER)
def write_results(state: Any, j: int, scene: Any, out: Any, each: Any) -> None:
    """Mark the fallen elements of a case, and write its results."""
    v = int(state[rows.VARIANT + j])
    rules, limits = scene.elements[v], scene.limits[v]
    mark_fallen(state, j, scene, rules, SUPPORT_GAP * limits.deepest)
    work, absorbed = 0.0, contact_work_of_last_half_step(state, j, scene)
    for p in range(scene.layout.shape[0]):
        q, _, _ = rows.pair_and_element_rows(state, scene, p)
        absorbed += q[rows.ABSORBED + j]
    for e in range(rules.size):
        item = rows.load_element(rows.of_element(state, e), j)
        totals, record = item.totals, item.record
        work += totals.work
        each[e].overturned = record.side
        each[e].overturning_time = record.upright_until if record.side != 0.0 else np.nan
        each[e].peak_rotation = min(peak_angle(item), 0.5 * np.pi)
        each[e].peak_slip, each[e].residual_slip = record.peak_slip, record.slip
    balance = (kinetic_and_gravitational_energy(state, j, scene) - rows.load_case(state, j).energy) - work + absorbed
    out.peak_penetration = deepest_penetration(state, j, scene)
    out.energy_error = abs(balance) / max(work, limits.least_scale, absorbed)
