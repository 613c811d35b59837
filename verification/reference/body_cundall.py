"""Cundall's scheme for a 3-D body, the reference for the centred scheme (docs/method.md).

Inside ``with enable_cundall():`` bodies accept the scheme "cundall". As in 2-D it uses central differences: springs at
the whole step, dashpots half a step earlier. Momenta are known at half steps, positions at whole steps. The angular
momentum in space changes only by the moment of the contact forces. The rotation of a step uses the angular velocity in
its middle, for which the body is first rotated by half of the step with the angular velocity at its start. The forces
of opposite vertices are summed first. Between samples, where the package reads the state, momenta are stored at whole
steps; `shift_all` converts them.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import cache
from typing import Any, ClassVar, Final, NamedTuple
from unittest import mock

import numpy as np
from numba import njit

from overturning.dem.body import plan as body_plan
from overturning.dem.body.base_contact import (
    base_lands_flat,
    both_base_ends_rest,
    contact_is_deferred,
    landing_time_at_touch,
    update_base_contacts,
)
from overturning.dem.body.centred import centre_acceleration, flat_landing_slip, rim_point_position
from overturning.dem.body.rules import LOOPS
from overturning.dem.body.state import (
    COLUMNS,
    ROWS,
    TICKS,
    VERTEX,
    BaseContactState,
    BodyBalanceAccount,
    BodyPeaks,
    BodyShaking,
    BodyState,
    BodyVertex,
    PointBeforeAndAfter,
    VertexHistory,
    angular_velocity,
    lean_measure,
)
from overturning.dem.body.state import BodyConstants as Constants
from overturning.dem.body.statics import largest_unit_spring_eigenvalue
from overturning.dem.body.vectors import (
    Matrix,
    Vector,
    cross_product,
    dot_product,
    extrapolate_vector,
    matrix_times_vector,
    plus,
    rotate_quaternion,
    rotation_matrix,
)
from overturning.dem.kernel.cache import cache_compiled_kernel
from overturning.dem.kernel.ground import motion_at_tick
from overturning.dem.kernel.lanes import INLINE, INNER, OPTIONS, OWNER, RowLayout, aligned_zeros, tuple_arithmetic
from overturning.dem.kernel.mechanics import clamp_friction, updated_maximum
from overturning.dem.kernel.queue import run_queue
from overturning.dem.numerics import Numerics
from overturning.dem.time_step import Scheme, parse_scheme, steps_per_sample
from overturning.model.body import Body
from overturning.model.cases import Cases
from overturning.motion.motion import Motion

WHOLE: Final = TICKS


class CundallVertices(NamedTuple):
    """Marker of bodies with vertices that this scheme computes."""

    round: bool = False


class CundallRim(NamedTuple):
    """Marker of bodies with a rim that this scheme computes."""

    round: bool = True


class Wrench(NamedTuple):
    """Contact force of the base on the body with its moment, summed over contact points, per mass."""

    force: Vector
    moment: Vector
    """Moment about the centre."""
    damping: Vector
    """Force without the springs."""
    braking: Vector
    """Moment of the force without the springs."""
    opened: float
    """Energy released by normal springs, over half their stiffness, m²."""
    shortened: float
    """Energy released by tangential springs, over half their stiffness, m²."""


class ContactSums(NamedTuple):
    """Contact force on a body in a step, and its largest penetration."""

    wrench: Wrench
    depth: float
    """Largest penetration, m."""


sum_of = tuple_arithmetic(Wrench).plus


class ContactPoint(NamedTuple):
    """Contact point: position from the centre, penetration, and displacement in the last step, m."""

    arm: Vector
    depth: float
    slip_x: float
    slip_y: float
    sinking: float


@njit(**INLINE)
def vertex_moved(s: BodyState, f: Matrix, vertex: BodyVertex, old: VertexHistory) -> ContactPoint:
    """Return the state of a vertex; its displacement is the difference from its last position."""
    arm = matrix_times_vector(f, vertex.own)
    place = plus(s.place, arm)
    return ContactPoint(arm, -place.z, place.x - old.x, place.y - old.y, -place.z - old.depth)


@njit(**INLINE)
def rim_moved(body: Constants, s: BodyState, f: Matrix, ahead: float, aside: float, dt: float) -> ContactPoint:
    """Return the state of a point of the rim; its displacement is that of the body at this point."""
    arm = rim_point_position(body, f, ahead, aside)
    v = plus(s.velocity, cross_product(s.spin, arm))
    return ContactPoint(arm, -(s.place.z + arm.z), dt * v.x, dt * v.y, -(dt * v.z))


@njit(**INLINE)
def apply_contact_law(
    body: Constants, s: BodyState, at: ContactPoint, old: VertexHistory, rate: float, rule: tuple[bool, bool, float]
) -> tuple[Wrench, VertexHistory]:
    """Apply the contact law at a point; `rate` is the dashpot over the step, so that it multiplies displacements.

    `rule` holds whether the point carries only later, whether the body lands flat, and the landing time of the point if
    it touches now (s).
    """
    waiting, flat, begun = rule
    depth = 0.0 if waiting & (at.depth > 0.0) else at.depth
    inside, was = depth > 0.0, old.depth > 0.0
    # Spring and dashpot while the point is in, never tension but in a flat landing.
    # A vertex that has waited does not remember how deep it was.
    sinking = 0.0 if old.depth == 0.0 else at.sinking
    n = body.stiffness * depth + rate * sinking
    n = n if inside & (flat | (n > 0.0)) else 0.0
    # A new contact starts with unstretched springs; those of a slipping one are shortened to the friction limit.
    tx, ty = (old.sx + at.slip_x if was else 0.0), (old.sy + at.slip_y if was else 0.0)
    most = body.friction * n
    hx, hy = -(body.tangential * tx) - rate * at.slip_x, -(body.tangential * ty) - rate * at.slip_y
    drift_x, drift_y, drifts, tilting = flat_landing_slip(body, at.arm, s.velocity, s.spin, flat)
    hx, hy = (-drift_x if drifts else hx), (-drift_y if drifts else hy)
    fx, fy, kx, ky, _ = clamp_friction(hx, hy, tx, ty, most, body.compliance, (flat, drifts))
    landing = (old.landing if was else begun) - body.step * WHOLE
    landing = landing if inside else 0.0
    force = Vector(fx, fy, n)
    spring = body.stiffness * (depth if inside else 0.0)
    damping = Vector(fx + body.tangential * kx, fy + body.tangential * ky, n - spring)
    opened = old.depth * old.depth if was & (not inside) else 0.0
    # One that has waited is met by a spring that is pressed in already.
    opened = -(depth * depth) if inside & (old.depth == 0.0) else opened
    shortened = (old.sx + kx) * (tx - kx) + (old.sy + ky) * (ty - ky)
    lever = Vector(at.arm.x, at.arm.y, tilting * at.arm.z)
    wrench = Wrench(force, cross_product(lever, force), damping, cross_product(lever, damping), opened, shortened)
    return wrench, VertexHistory(
        sx=kx, sy=ky, x=s.place.x + at.arm.x, y=s.place.y + at.arm.y, depth=depth, normal=n, slid=0.0, landing=landing
    )


@njit(**INLINE)
def add_pair(so_far: ContactSums, a: Wrench, b: Wrench, depth_a: float, depth_b: float) -> ContactSums:
    """Add a pair of contact points to those so far."""
    return ContactSums(
        sum_of(so_far.wrench, sum_of(a, b)), updated_maximum(so_far.depth, updated_maximum(depth_b, depth_a))
    )


@njit(**INLINE)
def step(
    body: Constants,
    s: BodyState,
    f: Matrix,
    acting: ContactSums,
    peaks: BodyPeaks,
    account: BodyBalanceAccount,
    shaking: BodyShaking,
) -> tuple[BodyState, BodyPeaks, BodyBalanceAccount]:
    """Compute one step of one body under the contact force of the base."""
    t, dt = acting.wrench, body.step * WHOLE
    half = 0.5 * dt
    push = Vector(
        motion_at_tick(shaking.push_x, s.tick),
        motion_at_tick(shaking.push_y, s.tick),
        motion_at_tick(shaking.lift, s.tick),
    )
    a = centre_acceleration(t.force, push)
    # The accounts take the velocities at the whole step.
    c = extrapolate_vector(s.velocity, half, a)
    w = angular_velocity(body, f, extrapolate_vector(s.momentum, half, t.moment))
    work = account.work + dt * ((push.x * c.x + push.y * c.y) - push.z * c.z)
    let_go = 0.5 * (body.stiffness * t.opened + body.tangential * t.shortened)
    loss = account.lost + (let_go + dt * -(dot_product(t.damping, c) + dot_product(t.braking, w)))
    spin = account.spin + dt * (t.moment.z + (s.place.x * a.y - s.place.y * a.x))
    # Update the peaks and the last time before the critical tilt.
    lean, bx, by = lean_measure(f), s.place.x - body.foot * f.xz, s.place.y - body.foot * f.yz
    peaks = BodyPeaks(
        updated_maximum(peaks.lean, lean), updated_maximum(peaks.slip, bx * bx + by * by),
        updated_maximum(peaks.depth, acting.depth),
        s.tick if lean < body.critical else peaks.last_upright,
    )  # fmt: skip
    # Momenta half a step later, position one step later.
    v, momentum = extrapolate_vector(s.velocity, dt, a), extrapolate_vector(s.momentum, dt, t.moment)
    w = angular_velocity(body, f, momentum)
    w = angular_velocity(body, rotation_matrix(rotate_quaternion(s.turn, half, w)), momentum)
    place, turn = extrapolate_vector(s.place, dt, v), rotate_quaternion(s.turn, dt, w)
    moved = BodyState(
        place=place,
        turn=turn,
        velocity=v,
        momentum=momentum,
        spin=w,
        acceleration=a,
        moment=t.moment,
        tick=s.tick + WHOLE,
    )
    return moved, peaks, BodyBalanceAccount(work, loss, spin, 0.0, 0.0, 0.0)


# Side by side ---------------------------------------------------------------------------------------------------------

UNUSED: Final = ("power", "loss", "torque", "slid", "bend")
load_body, load_state, load_frame = (ROWS.access(of).load for of in (Constants, BodyState, Matrix))
load_base_contact, store_base_contact, _ = ROWS.access(BaseContactState)
ACTING: Final = RowLayout(COLUMNS, ContactSums)
ACTING_SIZE: Final = ACTING.size
load_acting, store_acting, _ = ACTING.access(ContactSums)
no_wrench = tuple_arithmetic(Wrench).zero
load_shaking = ROWS.access(BodyShaking, unused_fields=UNUSED).load
load_peaks, load_account = ROWS.access(BodyPeaks).load, ROWS.access(BodyBalanceAccount, unused_fields=UNUSED).load
store_state, store_frame = (ROWS.access(of).store for of in (BodyState, Matrix))
store_peaks, store_account = ROWS.access(BodyPeaks).store, ROWS.access(BodyBalanceAccount, unused_fields=UNUSED).store
load_vertex, (load_memory, store_memory, _) = (
    VERTEX.access(BodyVertex).load,
    VERTEX.access(PointBeforeAndAfter, "old", unused_fields=UNUSED),
)
OF_A_VERTEX: Final = VERTEX.size


@njit(**INNER)
def place_all(state: Any, acting: Any, columns: int) -> None:
    """Compute the axes of all bodies, and reset their contact forces."""
    for j in range(columns):
        s = load_state(state, j)
        store_frame(state, j, rotation_matrix(s.turn))
        store_acting(acting, j, ContactSums(no_wrench(), -1.0))


@njit(**INNER)
def touch_all(state: Any, acting: Any, one: Any, other: Any, columns: int) -> None:
    """Compute the contact forces at a pair of opposite vertices of all bodies."""
    for j in range(columns):
        body, s, f = load_body(state, j), load_state(state, j), load_frame(state, j)
        rate, left, right = body.dashpot / (body.step * WHOLE), load_memory(one, j), load_memory(other, j)
        p, q, base_contact = load_vertex(one, j), load_vertex(other, j), load_base_contact(state, j)
        at, on = vertex_moved(s, f, p, left), vertex_moved(s, f, q, right)
        a, left = apply_contact_law(
            body,
            s,
            at,
            left,
            rate,
            (
                contact_is_deferred(body, base_contact, p, at.arm.z, left),
                base_lands_flat(base_contact),
                landing_time_at_touch(body, base_contact),
            ),
        )
        b, right = apply_contact_law(
            body,
            s,
            on,
            right,
            rate,
            (
                contact_is_deferred(body, base_contact, q, on.arm.z, right),
                base_lands_flat(base_contact),
                landing_time_at_touch(body, base_contact),
            ),
        )
        store_memory(one, j, left)
        store_memory(other, j, right)
        store_acting(acting, j, add_pair(load_acting(acting, j), a, b, left.depth, right.depth))


@njit(**INNER)
def roll_all(state: Any, acting: Any, one: Any, other: Any, columns: int, ahead: float, aside: float) -> None:
    """Compute the contact forces at a pair of opposite points of the rim of all bodies."""
    for j in range(columns):
        body, s, f = load_body(state, j), load_state(state, j), load_frame(state, j)
        dt = body.step * WHOLE
        rate, left, right = body.dashpot / dt, load_memory(one, j), load_memory(other, j)
        base_contact = load_base_contact(state, j)
        between, flat, begun = (
            (aside != 0.0) & (not both_base_ends_rest(base_contact)),
            base_lands_flat(base_contact),
            landing_time_at_touch(body, base_contact),
        )
        at, on = rim_moved(body, s, f, ahead, aside, dt), rim_moved(body, s, f, -ahead, -aside, dt)
        a, left = apply_contact_law(body, s, at, left, rate, (between & (left.depth <= 0.0), flat, begun))
        b, right = apply_contact_law(body, s, on, right, rate, (between & (right.depth <= 0.0), flat, begun))
        store_memory(one, j, left)
        store_memory(other, j, right)
        store_acting(acting, j, add_pair(load_acting(acting, j), a, b, left.depth, right.depth))


@njit(**INNER)
def move_all(state: Any, acting: Any, columns: int) -> None:
    """Compute the step of all bodies."""
    for j in range(columns):
        s, peaks, account = step(
            load_body(state, j), load_state(state, j), load_frame(state, j), load_acting(acting, j),
            load_peaks(state, j), load_account(state, j), load_shaking(state, j),
        )  # fmt: skip
        store_state(state, j, s)
        store_peaks(state, j, peaks)
        store_account(state, j, account)


@njit(**INNER)
def shift_all(state: Any, columns: int, by: float) -> None:
    """Advance momenta, and the account of the vertical angular momentum, by a number of steps with the last forces."""
    for j in range(columns):
        s, account = load_state(state, j), load_account(state, j)
        time = by * WHOLE * load_body(state, j).step
        v, momentum = (
            extrapolate_vector(s.velocity, time, s.acceleration),
            extrapolate_vector(s.momentum, time, s.moment),
        )
        store_state(
            state,
            j,
            BodyState(
                place=s.place,
                turn=s.turn,
                velocity=v,
                momentum=momentum,
                spin=s.spin,
                acceleration=s.acceleration,
                moment=s.moment,
                tick=s.tick,
            ),
        )
        torque = s.moment.z + (s.place.x * s.acceleration.y - s.place.y * s.acceleration.x)
        store_account(
            state, j, BodyBalanceAccount(account.work, account.lost, account.spin + time * torque, 0.0, 0.0, 0.0)
        )


@cache
def loops(round_: bool) -> Any:
    """Return the function that computes the steps of a sample, for bodies with vertices or with a rim.

    The type of its argument `kind` makes the compiled names of both variants differ; otherwise variants compiled by
    different processes would be confused in a process that loads both.
    """

    @njit(**OWNER)
    def advance(
        kind: Any,  # noqa: ARG001
        state: Any,
        vertices: Any,
        count: int,
        base: int,
        columns: int,
        steps: int,
        ticks: float,  # noqa: ARG001
    ) -> None:
        half, acting = count // 2 * OF_A_VERTEX, aligned_zeros(ACTING_SIZE)
        shift_all(state, columns, -0.5)
        for _ in range(steps):
            place_all(state, acting, columns)
            update_base_contacts(state, vertices, half, base, columns, round_)
            for pair in range(0, half, OF_A_VERTEX):
                one, other = (
                    vertices[pair : pair + OF_A_VERTEX],
                    vertices[half + pair : half + pair + OF_A_VERTEX],
                )
                if round_:
                    ahead = 1.0 if pair == 0 else 0.0
                    roll_all(state, acting, one, other, columns, ahead, 1.0 - ahead)
                else:
                    touch_all(state, acting, one, other, columns)
            move_all(state, acting, columns)
        shift_all(state, columns, 0.5)

    return advance


LOOPS.update({CundallVertices: loops(False), CundallRim: loops(True)})
_queue = njit(nogil=True, **OPTIONS)(run_queue.py_func)


@njit(nogil=True, **OPTIONS)
def run_cundall(inputs: Any, order: Any, counter: Any, path: Any) -> tuple[Any, int]:
    """Run a queue like `run_queue`; cached separately, so that the package's cache does not depend on this module."""
    return _queue(inputs, order, counter, path)


cache_compiled_kernel(run_cundall)


class CundallPlan(body_plan.BodySimulationPlan):
    """Plan for cases of a 3-D body with Cundall's scheme."""

    queue: ClassVar[Any] = staticmethod(run_cundall)

    @property
    def body_marker(self) -> Any:
        """Marker whose type selects the loops; see `BodySimulationPlan.body_marker`."""
        return CundallRim() if self.solids[0].radius > 0 else CundallVertices()


@contextmanager
def enable_cundall() -> Iterator[None]:
    """Let 3-D bodies use the scheme "cundall", whose automatic step is half the stable one."""
    plan_centred = body_plan.plan_body_simulation

    def plan(model: Body, motion: Motion, cases: Cases, numerics: Numerics) -> body_plan.BodySimulationPlan:
        if parse_scheme(numerics.scheme) != Scheme.CUNDALL:
            return plan_centred(model, motion, cases, numerics)
        planned = plan_centred(model, motion, cases, replace(numerics, scheme="centred", time_step="auto"))
        modes = np.array([largest_unit_spring_eigenvalue(solid) for solid in planned.solids])[planned.table["body"]]
        square = np.maximum(planned.table["stiffness"], planned.table["tangential"]) * modes
        rate, interval = planned.table["dashpot"] * modes, motion.sampling_interval
        steps = steps_per_sample(Scheme.CUNDALL, numerics.time_step, square, rate, interval)
        planned.table["finest"] = planned.table["dwell"] = 1.0
        planned.table["standing"] = WHOLE
        return CundallPlan(**vars(planned) | {"steps": steps * numerics.refinement})

    with mock.patch("overturning.dem.body.plan.plan_body_simulation", plan):
        yield
