"""One step of all columns: nearest faces where they may have changed, forces of every pair, then the motion of the elements.

`cundall` goes by central differences: forces and accelerations at the whole step, velocities half a step later, poses one step
later. `centred` goes by the trapezoidal rule, each column by steps of its own length: all at the end of the step.
"""

from functools import cache
from typing import Any

from numba import njit

from overturning.dem.kernel.clock import SCENE, Found, next_attempt
from overturning.dem.kernel.ground import at_tick
from overturning.dem.kernel.lanes import INLINE, OPTIONS
from overturning.dem.kernel.mechanics import larger, turned
from overturning.dem.polygon import rows
from overturning.dem.polygon.centred import correct, couple, is_fine, keep
from overturning.dem.polygon.equations import add_pair, solve
from overturning.dem.polygon.search import changes, count_motion, search
from overturning.dem.polygon.state import Body, Case, Course, Element, Plane, Pose, Trial


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
    return Course(dt * (abs(v.x) + abs(v.z)), abs(dt * v.w), old.work + work, larger(old.peak_angle, size), last, 0.0)


@cache
def advance_on(vertical: bool) -> Any:
    """The motion of an element over the columns, on a base that moves up and down or does not."""

    @njit(**OPTIONS)
    def advance(kind: Any, e: Any, own: Any, gravity: float) -> None:  # noqa: ARG001
        for j in range(rows.COLUMNS):
            item, case = rows.load_element(e, j), rows.load_case(own, j)
            dt, shaking, half = case.step, case.shaking, 0.5 * case.step
            ground = (shaking.base.value + shaking.base.slope * shaking.tick) * item.body.frame
            up = (shaking.up.value + shaking.up.slope * shaking.tick) * item.body.frame if vertical else 0.0
            a = acceleration(item, ground, up, gravity)
            v = after(item.velocity, a, dt)
            work = -(dt * power(item, ground, up, after(item.velocity, a, half)))
            pose = moved(item.pose, v, dt)
            rows.store_pose(e, j, pose)
            rows.store_velocity(e, j, v)
            rows.store_acceleration(e, j, a)
            rows.store_force(e, j, Plane(0.0, 0.0, 0.0))
            rows.store_course(e, j, course_of(item, v, pose.angle, dt, shaking.tick, work))

    return advance


@njit(**INLINE)
def shaken(case: Case, body: Body, ticks: float, vertical: bool) -> tuple[float, float]:
    """Acceleration of the base under an element at the end of the step, along and up."""
    tick = case.shaking.tick + case.attempt.length
    past = tick - ticks
    past = past if past > 0.0 else 0.0
    up = at_tick(case.shaking.up, tick, past) * body.frame if vertical else 0.0
    return at_tick(case.shaking.base, tick, past) * body.frame, up


@cache
def motion_on(vertical: bool) -> tuple[Any, Any]:
    """The motion of an element over the columns by the trapezoidal rule: as predicted, and at the solution."""

    @njit(**OPTIONS)
    def predict(kind: Any, e: Any, own: Any, ticks: float, gravity: float) -> None:  # noqa: ARG001
        for j in range(rows.COLUMNS):
            item, case = rows.load_element(e, j), rows.load_case(own, j)
            dt, body, a = case.step * case.attempt.length, item.body, item.acceleration
            half = 0.5 * dt
            ground, up = shaken(case, body, ticks, vertical)
            v = after(item.velocity, a, half)
            # What the solution is to add, but for the contacts.
            fall = gravity * body.weight + up
            change = Plane(half * (-ground - a.x), half * (-fall - a.z), half * -a.w)
            far, turn = dt * (abs(v.x) + abs(v.z)), abs(dt * v.w)
            rows.store_trial(e, j, Trial(moved(item.pose, v, dt), v, after(v, a, half), far, turn, change))
            rows.store_force(e, j, Plane(0.0, 0.0, 0.0))

    @njit(**OPTIONS)
    def arrive(kind: Any, e: Any, own: Any, ticks: float, gravity: float) -> None:  # noqa: ARG001
        for j in range(rows.COLUMNS):
            item, case = rows.load_element(e, j), rows.load_case(own, j)
            dt, trial, old, again = case.step * case.attempt.length, item.trial, item.course, case.verdict.again > 0.0
            half, tick, d, p = 0.5 * dt, case.shaking.tick + case.attempt.length, trial.change, trial.pose
            ground, up = shaken(case, item.body, ticks, vertical)
            a = acceleration(item, ground, up, gravity)
            v = after(trial.half, a, half)
            turn = half * d.w
            pose = Pose(p.x + half * d.x, p.z + half * d.z, p.angle + turn, p.cos - p.sin * turn, p.sin + p.cos * turn)
            rate, size = power(item, ground, up, v), abs(pose.angle)
            last = tick if size < item.body.critical else old.last_upright
            work = old.work - half * (old.power + rate)
            far = abs(pose.x - item.pose.x) + abs(pose.z - item.pose.z)
            course = Course(far, abs(pose.angle - item.pose.angle), work, larger(old.peak_angle, size), last, rate)
            rows.keep_pose(e, j, again, pose)
            rows.keep_velocity(e, j, again, v)
            rows.keep_acceleration(e, j, again, a)
            rows.keep_course(e, j, again, course)
            e[rows.MOVED + j] = 0.0 if again else far
            e[rows.TURNED + j] = 0.0 if again else course.turned

    return predict, arrive


@njit(**OPTIONS)
def clear_marks(own: Any) -> None:
    """Nothing has been found yet."""
    for j in range(rows.COLUMNS):
        rows.store_marks(own, j, rows.no_marks())


@njit(**INLINE)
def found_of(case: Case) -> Found:
    """What an attempt at a step has found, for the clock; fine steps go by the predicted forces."""
    found, fine = case.found, is_fine(case)
    return Found(
        found.changed > 0.0, False, False, (found.wrong > 0.0) & (not fine), (found.reversed > 0.0) & (not fine),
        (found.back > 0.0) & (not fine), found.slides > 0.0, False,
    )  # fmt: skip


@njit(**OPTIONS)
def accept_or_reject(own: Any, ticks: float) -> None:
    """Accept the step of each lane or not, and say how the next one is to be tried."""
    for j in range(rows.COLUMNS):
        case = rows.load_case(own, j)
        tick = case.shaking.tick + case.attempt.length
        again, sooner, attempt = next_attempt(SCENE, case.clock, case.attempt, found_of(case), tick, ticks)
        rows.store_then(own, j, attempt)
        own[rows.AGAIN + j], own[rows.SOONER + j] = 1.0 if again else 0.0, 1.0 if sooner else 0.0


@njit(**OPTIONS)
def advance_clock(own: Any) -> None:
    """Let the clock of each lane advance where its step is accepted."""
    for j in range(rows.COLUMNS):
        case = rows.load_case(own, j)
        tick = case.shaking.tick
        own[rows.TICK + j] = tick if case.verdict.again > 0.0 else tick + case.attempt.length
        rows.store_attempt(own, j, case.verdict.then)


@cache
def step_of(contact: Any, vertical: bool) -> Any:
    """One step of all columns by Cundall's scheme, whose `contact` computes the forces of a pair."""
    advance = advance_on(vertical)

    @njit(**OPTIONS)
    def step(
        kind: Any,
        state: Any,
        matrix: Any,  # noqa: ARG001, of the equations that the other scheme solves
        used: Any,  # noqa: ARG001
        moves: Any,
        layout: Any,
        sizes: Any,
        shapes: Any,
        ticks: float,  # noqa: ARG001
        gravity: float,
    ) -> None:
        for p in range(layout.shape[0]):
            if in_reach(state, moves.size, layout, sizes, shapes, p):
                contact(
                    rows.of_pair(state, moves.size, p),
                    rows.of_element(state, layout[p, 0]),
                    rows.of_element(state, layout[p, 1]),
                    state,
                )
        for i in range(moves.size):
            # Free or held; a driven one rests in the frame of the base.
            if moves[i]:
                advance(kind, rows.of_element(state, i), state, gravity)
        for j in range(rows.COLUMNS):
            state[rows.TICK + j] = state[rows.TICK + j] + 1.0

    return step


@cache
def trapezoidal_step(vertical: bool) -> Any:
    """One step of all columns by the centred scheme."""
    predict, arrive = motion_on(vertical)

    @njit(**OPTIONS)
    def step(
        kind: Any, state: Any, matrix: Any, used: Any, moves: Any, layout: Any, sizes: Any, shapes: Any, ticks: float, gravity: float
    ) -> None:  # fmt: skip
        clear_marks(state)
        size = moves.size
        used[:] = False
        for i in range(size):
            predict(kind, rows.of_element(state, i), state, ticks, gravity)
        for p in range(layout.shape[0]):
            near = in_reach(state, size, layout, sizes, shapes, p)
            used[size, p] = near
            if near:
                q, i, k = rows.of_pair(state, size, p), layout[p, 0], layout[p, 1]
                couple(q, rows.of_element(state, i), rows.of_element(state, k), state)
                add_pair(state, matrix, used, moves, size, q, i, k)
        solve(state, matrix, used, size)
        for p in range(layout.shape[0]):
            if used[size, p]:
                correct(
                    rows.of_pair(state, size, p),
                    rows.of_element(state, layout[p, 0]),
                    rows.of_element(state, layout[p, 1]),
                    state,
                )
        accept_or_reject(state, ticks)
        for i in range(size):
            if moves[i]:
                arrive(kind, rows.of_element(state, i), state, ticks, gravity)
        for p in range(layout.shape[0]):
            if used[size, p]:
                keep(rows.of_pair(state, size, p), state)
        advance_clock(state)

    return step


@njit(**OPTIONS)
def in_reach(state: Any, elements: int, layout: Any, sizes: Any, shapes: Any, p: int) -> bool:
    """Whether a pair could touch in any column in this step; its nearest faces are searched where they may change."""
    m, n = layout[p, 2], layout[p, 3]
    q = rows.of_pair(state, elements, p)
    a, b = rows.of_element(state, layout[p, 0]), rows.of_element(state, layout[p, 1])
    near, due = count_motion(q, a, b)
    if due > 0:
        near = 0
        for j in range(rows.COLUMNS):
            if q[rows.AHEAD + j] >= q[rows.LIMIT + j]:
                scene, dt = int(state[rows.VARIANT + j]), 2.0 * rows.load_case(state, j).lag
                shape_a, shape_b = shapes[scene, m, : sizes[m]], shapes[scene, n, : sizes[n]]
                search(q, a, b, j, dt, shape_a, shape_b)
                if dt == 0.0 and changes(q, a, b, j, shape_a, shape_b):
                    state[rows.CHANGED + j] = 1.0
            near += 1 if q[rows.AHEAD + j] >= q[rows.REACH + j] else 0
    return near > 0
