"""One step of all columns: nearest faces where they may have changed, forces of every pair, then the motion of the elements.

Central differences: forces and accelerations at the whole step, velocities half a step later, poses one step later.
"""

from functools import cache
from typing import Any

from numba import njit

from overturning.dem.lanes import INLINE, OPTIONS
from overturning.dem.mechanics import larger, turned
from overturning.dem.polygon import rows
from overturning.dem.polygon.rows import Course, Element, Plane, Pose
from overturning.dem.polygon.search import count_motion, search


@njit(**INLINE)
def acceleration(item: Element, ground: float, up: float, gravity: float) -> Plane:
    """Of an element in the frame of the base, under its contacts, its weight and the base's acceleration."""
    force, body = item.force, item.body
    return Plane(
        force.x * body.inverse_mass - ground,
        force.z * body.inverse_mass - (gravity * body.weight + up),
        force.w * body.inverse_inertia,
    )


@njit(**INLINE)
def after(v: Plane, a: Plane, dt: float) -> Plane:
    """A velocity a time dt later."""
    return Plane(v.x + dt * a.x, v.z + dt * a.z, v.w + dt * a.w)


@njit(**INLINE)
def moved(pose: Pose, v: Plane, dt: float) -> Pose:
    """A pose a time dt later."""
    c, s = turned(pose.cos, pose.sin, dt * v.w)
    return Pose(pose.x + dt * v.x, pose.z + dt * v.z, pose.angle + dt * v.w, c, s)


@njit(**INLINE)
def power(item: Element, ground: float, up: float, v: Plane) -> float:
    """Of the inertia that the moving base causes, and of what holds an element, W."""
    body, force = item.body, item.force
    return body.mass * (ground * v.x + up * v.z) + body.held * (force.x * v.x + force.z * v.z)


@njit(**INLINE)
def course_of(item: Element, v: Plane, angle: float, dt: float, tick: float, work: float) -> Course:
    """What is noted of an element's step."""
    size, old = abs(angle), item.course
    last = tick + 1.0 if size < item.body.critical else old.last_upright
    return Course(dt * (abs(v.x) + abs(v.z)), abs(dt * v.w), old.work + work, larger(old.peak_angle, size), last)


@cache
def advance_on(vertical: bool) -> Any:
    """The motion of an element over the columns, on a base that moves up and down or does not."""

    @njit(**OPTIONS)
    def advance(e: Any, own: Any, gravity: float) -> None:
        for j in range(rows.COLUMNS):
            item, case = rows.load_element(e, j), rows.load_case(own, j)
            dt, shaking, half = case.step, case.shaking, 0.5 * case.step
            ground = (shaking.base + shaking.slope * shaking.tick) * item.body.frame
            up = (shaking.up_base + shaking.up_slope * shaking.tick) * item.body.frame if vertical else 0.0
            a = acceleration(item, ground, up, gravity)
            v = after(item.velocity, a, dt)
            work = -(dt * power(item, ground, up, after(item.velocity, a, half)))
            pose = moved(item.pose, v, dt)
            rows.store_pose(e, j, pose)
            rows.store_velocity(e, j, v)
            rows.store_acceleration(e, j, a)
            # At the next whole step, were the forces to stay.
            rows.store_now(e, j, after(v, a, half))
            rows.store_force(e, j, Plane(0.0, 0.0, 0.0))
            rows.store_course(e, j, course_of(item, v, pose.angle, dt, shaking.tick, work))

    return advance


@cache
def step_of(contact: Any, vertical: bool) -> Any:
    """One step of all columns by a scheme, whose `contact` computes the forces of a pair."""
    advance = advance_on(vertical)

    @njit(**OPTIONS)
    def step(state: Any, layout: Any, sizes: Any, shapes: Any, variant: Any, gravity: float) -> None:
        for p in range(layout.shape[0]):
            i, k = layout[p, 0], layout[p, 1]
            q, a, b = rows.of_pair(state, sizes.size, p), rows.of_element(state, i), rows.of_element(state, k)
            near, due = count_motion(q, a, b)
            if due > 0:
                near = 0
                for j in range(rows.COLUMNS):
                    if q[rows.USED + j] >= q[rows.LIMIT + j]:
                        scene, dt = variant[j], rows.load_case(state, j).step
                        search(q, a, b, j, dt, shapes[scene, i, : sizes[i]], shapes[scene, k, : sizes[k]])
                    near += 1 if q[rows.USED + j] >= q[rows.REACH + j] else 0
            if near > 0:
                contact(q, a, b, state)
        for i in range(sizes.size):
            e = rows.of_element(state, i)
            # Free or held; a driven one rests in the frame of the base.
            if rows.load_element(e, 0).body.frame != 0.0:
                advance(e, state, gravity)
        for j in range(rows.COLUMNS):
            state[rows.TICK + j] = state[rows.TICK + j] + 1.0

    return step
