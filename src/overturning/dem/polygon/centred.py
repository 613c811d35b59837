"""The centred scheme: the trapezoidal rule with springs and dashpots taken at the end of the step (docs/scenes.md).

What a pair of elements does in a step: `couple` finds its part in the equations, `correct` its forces at the solution.
`overturning.dem.polygon.equations` solves them, `overturning.dem.kernel.clock` says how long the next step is.

Signs: an end's penetration u and opening velocity v give n = K u − h v, its stretch s and slip velocity w give
t = −(K_s s + h w).
"""

import math
from typing import Any, Final, NamedTuple

from numba import njit

from overturning.dem.kernel.clock import SCENE
from overturning.dem.kernel.lanes import APART, INLINE, arithmetic, select
from overturning.dem.kernel.mechanics import within
from overturning.dem.polygon import rows
from overturning.dem.polygon.equations import enter_loads, enter_pair
from overturning.dem.polygon.faces import End, Stretch, common_stretch
from overturning.dem.polygon.mechanics import (
    Force,
    Loaded,
    Outer,
    Relative,
    Taken,
    action_of,
    carrier_of,
    drift_of,
    history_of,
    lands_flat,
    pushed,
    rates,
    relative,
    slider,
    stretched,
)
from overturning.dem.polygon.state import OPEN, Case, Inertia, Law, Marks, Memory, Seen, Vertices

FINE: Final = SCENE.fine

LEAST_FREEDOM: Final = 0.25
"""An end sticks where sliding would leave less than this share of a normal force's effect on free particles."""


class Guess(NamedTuple):
    """What an end is taken to do in a step."""

    n: float
    """Forces as predicted, N;"""
    t: float
    stretch: float
    on: bool
    """whether it is in contact,"""
    slides: bool
    slid: float
    """±μ where it slides;"""
    free: bool
    """whether a normal force pushes it out while it slides."""


class Both(NamedTuple):
    """Both elements of a pair: how they move against each other, and their inertia."""

    velocity: Relative
    a: Inertia
    b: Inertia


plus = arithmetic(Outer).plus


@njit(**INLINE)
def guess(law: Law, old: Memory, slid: float, end: End, ends: Stretch, both: Both, kind: tuple[bool, bool]) -> Guess:
    """What an end would do: in fine steps as predicted, in long ones, where that overshoots too far, as last found.

    A normal force on a sliding end must push it out. Where friction would turn an element in instead (Painlevé's
    paradox), the end sticks.
    """
    (fine, held), a, b = kind, both.a, both.b
    opening, slipping = rates(end, both.velocity)
    n, drag = law.normal * end.depth - law.dashpot * opening, law.dashpot * slipping
    stretch = stretched(old, end, ends, law.compliance, drag)
    t = -(law.tangential * stretch) - drag
    pressed = (held | (n > 0.0)) & (end.closed > 0.0)
    on = (pressed | ((not fine) & (old.normal != 0.0))) & (end.faces > 0.0)
    excess = abs(t) - law.friction * n if fine else abs(slid)
    slid = math.copysign(law.friction, t) if fine else slid
    drifts, drift = drift_of(law, end, both.velocity, a, b, held)
    slid = drift if held else slid
    particles = a.inverse_mass + b.inverse_mass
    along = a.inverse_inertia * (end.a.n * (end.a.n + slid * end.a.t))
    freedom = particles + (along + b.inverse_inertia * (end.b.n * (end.b.n + slid * end.b.t)))
    slides = drifts if held else (excess > 0.0) | (law.friction == 0.0)
    return Guess(n, t, stretch, on, slides, slid, freedom > LEAST_FREEDOM * particles)


@njit(**INLINE)
def outer(c: float, f: Relative, v: Relative) -> Outer:
    """A force for c times a velocity, each with its direction and its levers."""
    x, z, a, b = c * v.x, c * v.z, c * v.a, c * v.b
    return Outer(
        f.x * x, f.x * z, f.z * x, f.z * z, f.x * a, f.z * a, f.x * b, f.z * b, f.a * x, f.a * z, f.b * x, f.b * z,
        f.a * a, f.a * b, f.b * a, f.b * b,
    )  # fmt: skip


@njit(**INLINE)
def contribution(law: Law, half: float, end: End, one: Guess, other: Guess) -> tuple[Outer, Force, float]:
    """An end's part in the equations, its forces as predicted, and ±μ where it slides.

    One that is not free to slide sticks, unless the other one does.
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
    # The force of a sliding end is inclined.
    inclined = Relative(
        along.x + slid * across.x, along.z + slid * across.z, along.a + slid * across.a, along.b + slid * across.b
    )
    normal, tangent = outer(press, inclined, along), outer(stick, across, across)
    return plus(normal, tangent), Force(n, t, one.stretch), slid


@njit(**INLINE)
def is_fine(case: Case) -> bool:
    """Whether a step is so fine that the predicted forces decide what an end does."""
    return case.attempt.length <= FINE * case.clock.finest


@njit(**APART)
def couple(q: Any, a: Any, b: Any, own: Any, into: Any, fresh: Any) -> None:
    """Enter one pair in the equations of a step, as of `overturning.dem.polygon.equations.place`."""
    for j in range(rows.COLUMNS):
        pair, first, second = rows.load_pair(q, j), rows.load_element(a, j), rows.load_element(b, j)
        case, law, old = rows.load_case(own, j), pair.law, pair.history
        fine, half = is_fine(case), 0.5 * (case.step * case.attempt.length)
        ends = common_stretch(pair, first.trial.pose, second.trial.pose)
        rows.store_ends(q, j, ends)
        both = Both(relative(first.trial.end, second.trial.end), first.inertia, second.inertia)
        kind = (fine, lands_flat(law, old, ends))
        g1 = guess(law, old.one, pair.slid_one, ends.one, ends, both, kind)
        g2 = guess(law, old.two, pair.slid_two, ends.two, ends, both, kind)
        p1, f1, slid_1 = contribution(law, half, ends.one, g1, g2)
        p2, f2, slid_2 = contribution(law, half, ends.two, g2, g1)
        rows.store_taken_one(q, j, Taken(g1.stretch, slid_1))
        rows.store_taken_two(q, j, Taken(g2.stretch, slid_2))
        enter_pair(into, fresh, j, plus(p1, p2), half, first.inertia, second.inertia)
        action, on, by = action_of(ends.one, ends.two, f1, f2), first.trial.change, second.trial.change
        on, by = enter_loads(on, by, action, half, first.inertia, second.inertia)
        rows.store_change(a, j, on)
        rows.store_change(b, j, by)


class Solved(NamedTuple):
    """An end at the solution."""

    now: Loaded
    further: float
    """Slip that the solution adds, m;"""
    found: float
    """±μ where it slips,"""
    changed: bool
    """whether it has opened or closed,"""
    wrong: bool
    """was taken to do otherwise,"""
    reversed: bool
    """slides against its velocity, a slip reversal,"""
    back: bool
    """and was held the other way before."""


@njit(**INLINE)
def solved(
    law: Law, old: Memory, end: End, taken: Taken, moves: tuple[Both, Relative], half: float, kind: tuple[bool, bool]
) -> Solved:
    """Forces of an end at the solution, within their limits: never tension but in a flat landing, friction.

    What the solution adds to the velocities moves the elements by half a step of it. The spring of an end that slips is
    shortened to what friction holds. (An end in the air "slips"; nothing asks which way.)
    """
    ((u, a, b), d), (fine, held) = moves, kind
    opening, slipping = rates(end, u)
    more_open, more_slip = rates(end, d)
    opening, slipping = opening + more_open, slipping + more_slip
    depth, stretch = end.depth - half * more_open, taken.stretch + half * more_slip
    touches, was = end.faces > 0.0, old.carrier != OPEN
    inside = (depth > 0.0) & touches
    n = law.normal * depth - law.dashpot * opening
    n = (n if held | (n > 0.0) else 0.0) if inside else 0.0
    most = law.friction * n
    t = -(law.tangential * stretch) - law.dashpot * slipping
    whole = Relative(u.x + d.x, u.z + d.z, u.a + d.a, u.b + d.b)
    (drifts, drift), loaded = drift_of(law, end, whole, a, b, held), most > 0.0
    force, holds, slips = slider(t, n, law, (held, drifts, drift))
    found = (drift if held else math.copysign(law.friction, t)) if slips else 0.0
    spring = within(stretch, holds * law.compliance) if slips else stretch
    spring = spring if inside else 0.0
    guessed = 0.0 if fine else taken.slid
    changed = (inside != was) | ((not was) & (touches & (end.depth > 0.0))) | (was & (old.carrier != carrier_of(end)))
    wrong, back = (found != guessed) & loaded, (found * old.tangent < 0.0) & loaded
    now = Loaded(Force(n, force, spring), depth, end.slip + half * more_slip, inside)
    return Solved(now, half * more_slip, found, changed, wrong, (guessed * slipping > 0.0) & loaded, back)


@njit(**INLINE)
def now_of(a: Seen, b: Seen, end: End, s: Solved) -> tuple[Seen, Seen]:
    """Both vertices that may carry an end, the one that does at the solution."""
    mine, depth = end.mine > 0.0, s.now.depth
    return (
        Seen(depth if mine else a.depth, a.place - s.further if mine else a.place),
        Seen(b.depth if mine else depth, b.place if mine else b.place + s.further),
    )


@njit(**APART)
def correct(q: Any, a: Any, b: Any, own: Any) -> None:
    """Forces of one pair at the solution, kept beside what it remembers until it is known whether the step is taken."""
    for j in range(rows.COLUMNS):
        pair, step, first, second = (
            rows.load_pair(q, j),
            rows.load_step(q, j),
            rows.load_element(a, j),
            rows.load_element(b, j),
        )
        case, on, by, law, ends = rows.load_case(own, j), first.trial, second.trial, pair.law, step.ends
        fine, half, old = is_fine(case), 0.5 * (case.step * case.attempt.length), case.found
        moves = Both(relative(on.end, by.end), first.inertia, second.inertia), relative(on.change, by.change)
        kind = (fine, lands_flat(law, pair.history, ends))
        s1 = solved(law, pair.history.one, ends.one, step.one, moves, half, kind)
        s2 = solved(law, pair.history.two, ends.two, step.two, moves, half, kind)
        on_a, on_b = pushed(first.force, second.force, action_of(ends.one, ends.two, s1.now.force, s2.now.force))
        rows.store_force(a, j, on_a)
        rows.store_force(b, j, on_b)
        a1, b2 = now_of(ends.now.a1, ends.now.b2, ends.one, s1)
        a2, b1 = now_of(ends.now.a2, ends.now.b1, ends.two, s2)
        rows.store_corrected(q, j, history_of(
            pair.history, ends, Vertices(a1, a2, b1, b2), (s1.now, s2.now), law, 2.0 * half
        ))  # fmt: skip
        q[rows.SLID_ONE + j], q[rows.SLID_TWO + j] = s1.found, s2.found
        slide = (s1.found != 0.0) & (s2.found != 0.0) & (s1.now.force.n + s2.now.force.n > 0.0)
        rows.store_marks(own, j, Marks(
            1.0 if s1.changed | s2.changed else old.changed, 1.0 if s1.wrong | s2.wrong else old.wrong,
            1.0 if s1.reversed | s2.reversed else old.reversed, 1.0 if slide else old.slides,
            1.0 if s1.back | s2.back else old.back,
        ))  # fmt: skip


@njit(**APART)
def keep(q: Any, own: Any) -> None:
    """Keep what a pair is at the solution, where the step is accepted."""
    for j in range(rows.COLUMNS):
        step, verdict = rows.load_step(q, j), rows.load_case(own, j).verdict
        rows.keep_history(q, j, verdict.again > 0.0, step.corrected)
        q[rows.SLID_ONE + j] = select(verdict.sooner > 0.0, step.one.slid, q[rows.SLID_ONE + j])
        q[rows.SLID_TWO + j] = select(verdict.sooner > 0.0, step.two.slid, q[rows.SLID_TWO + j])
