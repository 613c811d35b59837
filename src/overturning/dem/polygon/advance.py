"""Central differences: the elements' accelerations, velocities half a step later and poses one step later."""

from typing import Any

from numba import njit

from overturning.dem.lanes import INLINE, OPTIONS
from overturning.dem.mechanics import larger, turned
from overturning.dem.polygon.columns import (
    COLUMNS,
    Course,
    Element,
    Plane,
    Pose,
    load_case,
    load_element,
    store_acceleration,
    store_course,
    store_force,
    store_now,
    store_pose,
    store_velocity,
)


@njit(**INLINE)
def accelerations(item: Element, ground: float, up: float, gravity: float) -> Plane:
    """Of an element in the frame of the base, under its contacts, its weight and the base's acceleration."""
    force, body = item.force, item.body
    return Plane(
        force.x * body.inverse_mass - ground,
        force.z * body.inverse_mass - (gravity * body.weight + up),
        force.w * body.inverse_inertia,
    )


@njit(**INLINE)
def moved(pose: Pose, v: Plane, dt: float) -> Pose:
    """A pose one step later."""
    c, s = turned(pose.cos, pose.sin, dt * v.w)
    return Pose(pose.x + dt * v.x, pose.z + dt * v.z, pose.angle + dt * v.w, c, s)


@njit(**INLINE)
def after(v: Plane, a: Plane, dt: float) -> Plane:
    """A velocity a time dt later."""
    return Plane(v.x + dt * a.x, v.z + dt * a.z, v.w + dt * a.w)


@njit(**OPTIONS)
def advance(e: Any, own: Any, gravity: float) -> None:
    """Accelerations at the whole step, velocities half a step later, pose one step later."""
    for j in range(COLUMNS):
        item, case = load_element(e, j), load_case(own, j)
        dt, shaking, body, force = case.step, case.shaking, item.body, item.force
        ground = (shaking.base + shaking.slope * shaking.tick) * body.frame
        up = (shaking.up_base + shaking.up_slope * shaking.tick) * body.frame
        a = accelerations(item, ground, up, gravity)
        half = 0.5 * dt
        whole = after(item.velocity, a, half)
        power = body.mass * (ground * whole.x + up * whole.z) + body.held * (force.x * whole.x + force.z * whole.z)
        v = after(item.velocity, a, dt)
        pose = moved(item.pose, v, dt)
        size, course = abs(pose.angle), item.course
        store_pose(e, j, pose)
        store_velocity(e, j, v)
        store_acceleration(e, j, a)
        # At the next whole step, were the forces to stay.
        store_now(e, j, after(v, a, half))
        store_force(e, j, Plane(0.0, 0.0, 0.0))
        store_course(
            e,
            j,
            Course(
                dt * (abs(v.x) + abs(v.z)),
                abs(dt * v.w),
                course.work - dt * power,
                larger(course.peak_angle, size),
                shaking.tick + 1.0 if size < body.critical else course.last_upright,
            ),
        )
