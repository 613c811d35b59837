"""Contacts in the centred scheme: trapezoidal rule, springs and dashpots at the end of the step (docs/scenes.md).

`couple` enters a pair in the equations of a step, `overturning.dem.polygon.equations` solves them, `correct` computes
the forces of the pair at the solution, and `overturning.dem.kernel.clock` chooses the next step.

Signs: an end's penetration u and opening velocity v give n = K u − h v, its stretch s and slip velocity w give
t = −(K_s s + h w).
"""

import math
from typing import Any, Final, NamedTuple

from numba import njit

from overturning.dem.kernel.clock import SCENE
from overturning.dem.kernel.lanes import APART, INLINE, arithmetic, select
from overturning.dem.kernel.mechanics import clamp
from overturning.dem.polygon import rows
from overturning.dem.polygon.equations import enter_loads, enter_pair
from overturning.dem.polygon.faces import End, Stretch, common_stretch
from overturning.dem.polygon.mechanics import (
    EndForce,
    EndResult,
    Outer,
    PredictedContact,
    Relative,
    add_action,
    apply_friction,
    carrier_of,
    combined_action,
    flat_landing_slip,
    lands_flat,
    next_history,
    rates,
    relative,
    spring_stretch,
)
from overturning.dem.polygon.state import OPEN, Case, Inertia, Law, Memory, Seen, StoredFindings, Vertices

FINE: Final = SCENE.fine

LEAST_FREEDOM: Final = 0.25
"""Least effect of a normal force on a sliding end, as a share of its effect on free particles; below it, it sticks."""


class Guess(NamedTuple):
    """State of a contact end that the equations of a step would assume."""

    n: float
    """Predicted normal force, N."""
    t: float
    """Predicted tangential force, N."""
    stretch: float
    """Predicted stretch of the tangential spring, m."""
    on: bool
    """True if the end is in contact."""
    slides: bool
    """True if the end slides."""
    slid: float
    """±μ if the end slides."""
    free: bool
    """True if a normal force pushes the end out while it slides."""


class PairMotion(NamedTuple):
    """Relative motion of the elements of a pair, and their inertia."""

    velocity: Relative
    a: Inertia
    b: Inertia


plus = arithmetic(Outer).plus


@njit(**INLINE)
def guess(
    law: Law, old: Memory, slid: float, end: End, ends: Stretch, both: PairMotion, kind: tuple[bool, bool]
) -> Guess:
    """Return the state of an end to assume: as predicted in fine steps, as at the last solution in longer ones.

    In long steps the prediction overshoots too far. A normal force on a sliding end must push it out; where friction
    would rotate an element further in instead (Painlevé's paradox), the end sticks. `kind` holds whether the step is
    fine, and whether the pair is held in a flat landing.
    """
    (fine, held), a, b = kind, both.a, both.b
    opening, slipping = rates(end, both.velocity)
    n, drag = law.normal * end.depth - law.dashpot * opening, law.dashpot * slipping
    stretch = spring_stretch(old, end, ends, law.compliance, drag)
    t = -(law.tangential * stretch) - drag
    pressed = (held | (n > 0.0)) & (end.closed > 0.0)
    on = (pressed | ((not fine) & (old.normal != 0.0))) & (end.faces > 0.0)
    excess = abs(t) - law.friction * n if fine else abs(slid)
    slid = math.copysign(law.friction, t) if fine else slid
    drifts, drift = flat_landing_slip(law, end, both.velocity, a, b, held)
    slid = drift if held else slid
    particles = a.inverse_mass + b.inverse_mass
    along = a.inverse_inertia * (end.a.n * (end.a.n + slid * end.a.t))
    freedom = particles + (along + b.inverse_inertia * (end.b.n * (end.b.n + slid * end.b.t)))
    slides = drifts if held else (excess > 0.0) | (law.friction == 0.0)
    return Guess(n, t, stretch, on, slides, slid, freedom > LEAST_FREEDOM * particles)


@njit(**INLINE)
def outer(c: float, f: Relative, v: Relative) -> Outer:
    """Return the matrix of a force that is c times a velocity; `f` and `v` are their directions with lever arms."""
    x, z, a, b = c * v.x, c * v.z, c * v.a, c * v.b
    return Outer(
        f.x * x, f.x * z, f.z * x, f.z * z, f.x * a, f.z * a, f.x * b, f.z * b, f.a * x, f.a * z, f.b * x, f.b * z,
        f.a * a, f.a * b, f.b * a, f.b * b,
    )  # fmt: skip


@njit(**INLINE)
def contribution(law: Law, half: float, end: End, one: Guess, other: Guess) -> tuple[Outer, EndForce, float]:
    """Return an end's matrix in the equations, its predicted forces, and ±μ if it slides (else 0).

    An end that is not free to slide sticks, unless the other end already sticks.
    """
    free = one.free | (other.on & (not other.slides))
    slides = one.slides & free
    slid = one.slid if slides else 0.0
    press = law.dashpot + half * law.normal if one.on else 0.0
    stick = law.dashpot + half * law.tangential if one.on else 0.0
    stick = 0.0 if slides else stick
    n = one.n if one.on else 0.0
    t = slid * n if slides else one.t
    t = t if one.on else 0.0
    along, across = Relative(end.nx, end.nz, end.a.n, end.b.n), Relative(end.nz, -end.nx, end.a.t, end.b.t)
    # The force of a sliding end is inclined by the friction angle.
    inclined = Relative(
        along.x + slid * across.x, along.z + slid * across.z, along.a + slid * across.a, along.b + slid * across.b
    )
    normal, tangent = outer(press, inclined, along), outer(stick, across, across)
    return plus(normal, tangent), EndForce(n, t, one.stretch), slid


@njit(**INLINE)
def is_fine(case: Case) -> bool:
    """True if a step is so fine that predicted forces decide about contact and slip."""
    return case.attempt.length <= FINE * case.clock.finest


@njit(**APART)
def couple(q: Any, a: Any, b: Any, own: Any, into: Any, fresh: Any) -> None:
    """Enter one pair in the equations of a step; see `overturning.dem.polygon.equations.place` for `into`, `fresh`."""
    for j in range(rows.COLUMNS):
        pair, first, second = rows.load_pair(q, j), rows.load_element(a, j), rows.load_element(b, j)
        case, law, old = rows.load_case(own, j), pair.law, pair.history
        fine, half = is_fine(case), 0.5 * (case.step * case.attempt.length)
        ends = common_stretch(pair, first.trial.pose, second.trial.pose)
        rows.store_ends(q, j, ends)
        both = PairMotion(relative(first.trial.end, second.trial.end), first.inertia, second.inertia)
        kind = (fine, lands_flat(law, old, ends))
        g1 = guess(law, old.one, pair.slid_one, ends.one, ends, both, kind)
        g2 = guess(law, old.two, pair.slid_two, ends.two, ends, both, kind)
        p1, f1, slid_1 = contribution(law, half, ends.one, g1, g2)
        p2, f2, slid_2 = contribution(law, half, ends.two, g2, g1)
        rows.store_predicted_one(q, j, PredictedContact(g1.stretch, slid_1))
        rows.store_predicted_two(q, j, PredictedContact(g2.stretch, slid_2))
        enter_pair(into, fresh, j, plus(p1, p2), half, first.inertia, second.inertia)
        action, on, by = combined_action(ends.one, ends.two, f1, f2), first.trial.change, second.trial.change
        on, by = enter_loads(on, by, action, half, first.inertia, second.inertia)
        rows.store_change(a, j, on)
        rows.store_change(b, j, by)


class EndSolution(NamedTuple):
    """State of a contact end at the solution of the equations."""

    now: EndResult
    further: float
    """Slip added by the solution, m."""
    found: float
    """±μ if the end slips, else 0."""
    changed: bool
    """True if the end has opened or closed."""
    wrong: bool
    """True if the end sticks or slides contrary to the assumption."""
    reversed: bool
    """True if the end was assumed to slide against its velocity (slip reversal)."""
    back: bool
    """True if its friction had the opposite sign before."""


@njit(**INLINE)
def solve_end(
    law: Law,
    old: Memory,
    end: End,
    predicted: PredictedContact,
    moves: tuple[PairMotion, Relative],
    half: float,
    kind: tuple[bool, bool],
) -> EndSolution:
    """Compute the state of an end at the solution, with forces within their limits.

    There is no tension except in a flat landing, and friction is at most μ times the normal force. Velocity corrections
    act on the poses over half a step. The spring of a slipping end is shortened to the force that friction can hold.
    (An end in the air counts as slipping; its direction is never used.) `moves` holds the motion of the pair and the
    velocity correction, `kind` whether the step is fine and whether the pair is held in a flat landing.
    """
    ((u, a, b), d), (fine, held) = moves, kind
    opening, slipping = rates(end, u)
    more_open, more_slip = rates(end, d)
    opening, slipping = opening + more_open, slipping + more_slip
    depth, stretch = end.depth - half * more_open, predicted.stretch + half * more_slip
    touches, was = end.faces > 0.0, old.carrier != OPEN
    inside = (depth > 0.0) & touches
    n = law.normal * depth - law.dashpot * opening
    n = (n if held | (n > 0.0) else 0.0) if inside else 0.0
    most = law.friction * n
    t = -(law.tangential * stretch) - law.dashpot * slipping
    whole = Relative(u.x + d.x, u.z + d.z, u.a + d.a, u.b + d.b)
    (drifts, drift), loaded = flat_landing_slip(law, end, whole, a, b, held), most > 0.0
    force, holds, slips = apply_friction(t, n, law, (held, drifts, drift))
    found = (drift if held else math.copysign(law.friction, t)) if slips else 0.0
    spring = clamp(stretch, holds * law.compliance) if slips else stretch
    spring = spring if inside else 0.0
    assumed = 0.0 if fine else predicted.slid
    changed = (inside != was) | ((not was) & (touches & (end.depth > 0.0))) | (was & (old.carrier != carrier_of(end)))
    wrong, back = (found != assumed) & loaded, (found * old.tangent < 0.0) & loaded
    now = EndResult(EndForce(n, force, spring), depth, end.slip + half * more_slip, inside)
    return EndSolution(now, half * more_slip, found, changed, wrong, (assumed * slipping > 0.0) & loaded, back)


@njit(**INLINE)
def contact_vertices(a: Seen, b: Seen, end: End, s: EndSolution) -> tuple[Seen, Seen]:
    """Return the positions of both vertices that may carry an end; the carrying one is moved to the solution."""
    mine, depth = end.mine > 0.0, s.now.depth
    return (
        Seen(depth if mine else a.depth, a.place - s.further if mine else a.place),
        Seen(b.depth if mine else depth, b.place if mine else b.place + s.further),
    )


@njit(**APART)
def correct(q: Any, a: Any, b: Any, own: Any) -> None:
    """Compute the forces of one pair at the solution; its new history is stored apart until the step is accepted."""
    for j in range(rows.COLUMNS):
        pair, step, first, second = (
            rows.load_pair(q, j),
            rows.load_step(q, j),
            rows.load_element(a, j),
            rows.load_element(b, j),
        )
        case, on, by, law, ends = rows.load_case(own, j), first.trial, second.trial, pair.law, step.ends
        fine, half, old = is_fine(case), 0.5 * (case.step * case.attempt.length), case.findings
        moves = PairMotion(relative(on.end, by.end), first.inertia, second.inertia), relative(on.change, by.change)
        kind = (fine, lands_flat(law, pair.history, ends))
        s1 = solve_end(law, pair.history.one, ends.one, step.one, moves, half, kind)
        s2 = solve_end(law, pair.history.two, ends.two, step.two, moves, half, kind)
        on_a, on_b = add_action(
            first.force, second.force, combined_action(ends.one, ends.two, s1.now.force, s2.now.force)
        )
        rows.store_force(a, j, on_a)
        rows.store_force(b, j, on_b)
        a1, b2 = contact_vertices(ends.now.a1, ends.now.b2, ends.one, s1)
        a2, b1 = contact_vertices(ends.now.a2, ends.now.b1, ends.two, s2)
        rows.store_corrected(q, j, next_history(
            pair.history, ends, Vertices(a1, a2, b1, b2), (s1.now, s2.now), law, 2.0 * half
        ))  # fmt: skip
        q[rows.SLID_ONE + j], q[rows.SLID_TWO + j] = s1.found, s2.found
        slide = (s1.found != 0.0) & (s2.found != 0.0) & (s1.now.force.n + s2.now.force.n > 0.0)
        rows.store_findings(own, j, StoredFindings(
            1.0 if s1.changed | s2.changed else old.changed, 1.0 if s1.wrong | s2.wrong else old.wrong,
            1.0 if s1.reversed | s2.reversed else old.reversed, 1.0 if slide else old.slides,
            1.0 if s1.back | s2.back else old.back,
        ))  # fmt: skip


@njit(**APART)
def keep(q: Any, own: Any) -> None:
    """Store the new contact history of a pair in the lanes whose step is accepted."""
    for j in range(rows.COLUMNS):
        step, decision = rows.load_step(q, j), rows.load_case(own, j).decision
        rows.keep_history(q, j, decision.again > 0.0, step.corrected)
        q[rows.SLID_ONE + j] = select(decision.sooner > 0.0, step.one.slid, q[rows.SLID_ONE + j])
        q[rows.SLID_TWO + j] = select(decision.sooner > 0.0, step.two.slid, q[rows.SLID_TWO + j])
