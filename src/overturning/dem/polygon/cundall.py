"""Cundall's scheme: springs at the whole step, dashpots half a step earlier, from differences of penetration and place.

Central differences: forces and accelerations at the whole step, velocities half a step later, poses one step later.
"""

from typing import Any, NamedTuple

from numba import njit

from overturning.dem.kernel.ground import within_sample
from overturning.dem.kernel.lanes import APART, INLINE, INNER, select
from overturning.dem.kernel.mechanics import clamp, larger
from overturning.dem.polygon import rows
from overturning.dem.polygon.distant import begin_step, stays_awake
from overturning.dem.polygon.faces import End, Stretch, common_stretch
from overturning.dem.polygon.mechanics import (
    EndForce,
    EndResult,
    acceleration,
    add_action,
    apply_friction,
    combined_action,
    flat_landing_slip,
    lands_flat,
    next_history,
    pose_after,
    power,
    relative,
    spring_stretch,
    velocity_after,
)
from overturning.dem.polygon.search import in_reach
from overturning.dem.polygon.state import Law, Memory, Plane, StepTotals


class Cundall(NamedTuple):
    """Constants of Cundall's scheme."""

    lag: float = 0.5
    """Lag of velocities behind poses, steps."""
    ticks: float = 1.0
    """Ticks in a whole step."""


@njit(**INLINE)
def end_result(
    law: Law, old: Memory, end: End, ends: Stretch, rate: float, flat: tuple[bool, bool, float]
) -> EndResult:
    """Compute the force of an end from spring, dashpot and friction; `rate` is steps per second.

    See `overturning.dem.polygon.mechanics.apply_friction` for `flat`.
    """
    fade = law.dashpot * rate
    n = law.normal * end.depth + fade * (end.depth - end.before)
    n = n if end.closed & (flat[0] | (n > 0.0)) else 0.0
    drag = fade * end.slip
    stretch = spring_stretch(old, end, ends, law.compliance, drag)
    t = -(law.tangential * stretch) - drag
    # The spring of a slipping end is shortened to the force that friction can hold.
    force, holds, slips = apply_friction(t, n, law, flat)
    spring = clamp(stretch, holds * law.compliance) if slips else stretch
    return EndResult(EndForce(n, force, spring), end.depth, end.slip, end.closed)


@njit(**APART)
def contact(q: Any, a: Any, b: Any, own: Any) -> None:
    """Compute the forces of one pair: spring, dashpot and friction at both ends of the faces' common stretch."""
    for j in range(rows.COLUMNS):
        pair, first, second = rows.load_pair(q, j), rows.load_element(a, j), rows.load_element(b, j)
        case, old = rows.load_case(own, j), pair.history
        ends = common_stretch(pair, first.pose, second.pose)
        held = lands_flat(pair.law, old, ends)
        u, own_a, own_b = relative(first.velocity, second.velocity), first.inertia, second.inertia
        flat_one = (held, *flat_landing_slip(pair.law, ends.one, u, own_a, own_b, held))
        flat_two = (held, *flat_landing_slip(pair.law, ends.two, u, own_a, own_b, held))
        one = end_result(pair.law, old.one, ends.one, ends, case.rate, flat_one)
        two = end_result(pair.law, old.two, ends.two, ends, case.rate, flat_two)
        on_a, on_b = add_action(first.force, second.force, combined_action(ends.one, ends.two, one.force, two.force))
        rows.store_force(a, j, on_a)
        rows.store_force(b, j, on_b)
        rows.store_history(q, j, next_history(old, ends, ends.now, (one, two), pair.law, case.step))


@njit(**APART)
def advance(up: Any, e: Any, own: Any, gravity: float) -> None:
    """Advance the motion of an element by a step in all lanes."""
    for j in range(rows.COLUMNS):
        item, case = rows.load_element(e, j), rows.load_case(own, j)
        dt, shaking, half, old = case.step, case.shaking, 0.5 * case.step, item.totals
        ground = within_sample(shaking.base, shaking.tick) * item.inertia.frame
        lift = 0.0
        if up is not None:
            lift = within_sample(shaking.up, shaking.tick) * item.inertia.frame
        a = acceleration(item, ground, lift, gravity)
        v = velocity_after(item.velocity, a, dt)
        work = old.work - dt * power(item, ground, lift, velocity_after(item.velocity, a, half))
        pose = pose_after(item.pose, v, dt)
        on = pose.angle
        upright = (on < item.inertia.on) & (-on < item.inertia.back)
        last = select(upright, shaking.tick + 1.0, old.last_upright)
        back, on = larger(old.peak_back, -on), larger(old.peak_on, on)
        far, turn = dt * (abs(v.x) + abs(v.z)), abs(dt * v.w)
        rows.store_pose(e, j, pose)
        rows.store_velocity(e, j, v)
        rows.store_acceleration(e, j, a)
        rows.store_force(e, j, Plane(0.0, 0.0, 0.0))
        rows.store_totals(e, j, StepTotals(far, turn, work, back, on, last, 0.0))


@njit(**INNER)
def step(
    up: Any,
    state: Any,
    matrix: Any,  # noqa: ARG001, used by the centred scheme only
    pattern: Any,  # noqa: ARG001
    pairs: Any,
    moves: Any,
    scene: Any,
    ticks: float,  # noqa: ARG001, each step is one tick
) -> None:
    """Compute one step of all lanes; `up` is None if the base moves level."""
    begin_step(state, scene, pairs, moves.size)
    kept = 0
    for n in range(pairs.count[0]):
        p = pairs.awake[n]
        q, a, b = rows.of_pair(state, scene, p)
        near = in_reach(state, q, a, b, scene.layout[p, 2], scene.layout[p, 3], scene.sizes, scene.shapes)
        if near:
            contact(q, a, b, state)
        if near or stays_awake(q, a, b, p, pairs):
            pairs.awake[kept] = p
            kept += 1
    pairs.count[0] = kept
    for i in range(moves.size):
        # Free and held elements move; a driven one rests in the frame of the base.
        if moves[i]:
            advance(up, rows.of_element(state, i), state, scene.gravity)
    for j in range(rows.COLUMNS):
        state[rows.TICK + j] = state[rows.TICK + j] + 1.0
