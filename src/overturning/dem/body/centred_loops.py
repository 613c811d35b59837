"""The centred scheme in space on bodies side by side: loops over the columns around the equations of one body in `centred`."""

from functools import cache
from typing import Any, Final

from numba import njit

from overturning.dem.body.centred import (
    WHOLE,
    commit,
    foresee,
    found_of,
    is_late,
    meet,
    rim_point,
    touch,
    turns_fast,
)
from overturning.dem.body.centred_rows import Change, Equations, Foreseen, Largest, Refused, Sum, Touch
from overturning.dem.body.equations import share, solve
from overturning.dem.body.lying import lie_all, lies, waits
from overturning.dem.body.state import (
    ROWS,
    VERTEX,
    Account,
    Body,
    Frame,
    Lying,
    Peaks,
    Point,
    Shaking,
    State,
    Vertex,
    frame_of,
    in_space,
)  # fmt: skip
from overturning.dem.kernel.clock import BODY, Attempt, Clock, next_attempt
from overturning.dem.kernel.lanes import INNER, arithmetic

load_body, load_shaking = ROWS.access(Body).load, ROWS.access(Shaking).load
load_frame, store_frame, _ = ROWS.access(Frame)
load_state, _, store_state = ROWS.access(State)
load_lying, store_lying, _ = ROWS.access(Lying)
load_peaks, _, store_peaks = ROWS.access(Peaks)
load_account, _, store_account = ROWS.access(Account)
load_attempt, store_attempt, _ = ROWS.access(Attempt)
load_refused, store_refused, _ = ROWS.access(Refused)
load_clock = ROWS.access(Clock).load
load_foreseen, store_foreseen, _ = ROWS.access(Foreseen)
load_equations, store_equations, _ = ROWS.access(Equations)
load_change, store_change, _ = ROWS.access(Change)
load_sum, store_sum, _ = ROWS.access(Sum)
load_largest, store_largest, _ = ROWS.access(Largest)
no_equations, add_equations = arithmetic(Equations).zero, arithmetic(Equations).plus
no_sum, add_sum = arithmetic(Sum).zero, arithmetic(Sum).plus
nothing, larger_of = arithmetic(Largest).zero, arithmetic(Largest).largest
load_vertex = VERTEX.access(Vertex).load
load_memory, _, store_memory = VERTEX.access(Point, "old")
load_touch, store_touch, _ = VERTEX.access(Touch)
load_next, store_next, _ = VERTEX.access(Point, "new")
OF_A_VERTEX: Final = VERTEX.size
SLID: Final = VERTEX.row(Point, "old.slid")


@njit(**INNER)
def foresee_all(state: Any, columns: int, ticks: float) -> None:
    """Where all bodies would be, and no force yet."""
    for j in range(columns):
        w = foresee(
            load_body(state, j), load_state(state, j), load_attempt(state, j).length, load_shaking(state, j), ticks
        )
        store_foreseen(state, j, w)
        store_frame(state, j, frame_of(w.qw, w.qx, w.qy, w.qz))
        store_equations(state, j, no_equations())
        store_sum(state, j, no_sum())
        store_largest(state, j, nothing())


@njit(**INNER)
def touch_all(state: Any, one: Any, other: Any, columns: int) -> None:
    """A pair of vertices of all bodies at the foreseen end."""
    for j in range(columns):
        body, w, f = load_body(state, j), load_foreseen(state, j), load_frame(state, j)
        late = is_late(load_clock(state, j), load_attempt(state, j))
        p, q, lying = load_vertex(one, j), load_vertex(other, j), load_lying(state, j)
        a, b = in_space(f, p.px, p.py, p.pz), in_space(f, q.px, q.py, q.pz)
        left, right = load_memory(one, j), load_memory(other, j)
        store_touch(one, j, touch(body, w, f, a, left, late, False, waits(body, lying, p, a.z, left)))
        store_touch(other, j, touch(body, w, f, b, right, late, False, waits(body, lying, q, b.z, right)))


@njit(**INNER)
def roll_all(state: Any, one: Any, other: Any, columns: int, ahead: float, aside: float) -> None:
    """The same for a pair of points of the rim."""
    for j in range(columns):
        body, w, f = load_body(state, j), load_foreseen(state, j), load_frame(state, j)
        late = is_late(load_clock(state, j), load_attempt(state, j))
        left, right, between = (
            load_memory(one, j),
            load_memory(other, j),
            (aside != 0.0) & (not lies(load_lying(state, j))),
        )
        a, b = rim_point(body, f, ahead, aside), rim_point(body, f, -ahead, -aside)
        store_touch(one, j, touch(body, w, f, a, left, late, True, between & (left.depth <= 0.0)))
        store_touch(other, j, touch(body, w, f, b, right, late, True, between & (right.depth <= 0.0)))


@njit(**INNER)
def share_all(state: Any, one: Any, other: Any, columns: int) -> None:
    """Their parts in the equations."""
    for j in range(columns):
        body, half = load_body(state, j), load_foreseen(state, j).half
        late = is_late(load_clock(state, j), load_attempt(state, j))
        a = share(body, half, load_touch(one, j), load_memory(one, j), late)
        b = share(body, half, load_touch(other, j), load_memory(other, j), late)
        store_equations(state, j, add_equations(load_equations(state, j), add_equations(a, b)))


@njit(**INNER)
def solve_all(state: Any, columns: int) -> None:
    """The equations of all bodies."""
    for j in range(columns):
        store_change(state, j, solve(
            load_body(state, j), load_state(state, j), load_foreseen(state, j), load_equations(state, j)
        ))  # fmt: skip


@njit(**INNER)
def meet_all(state: Any, one: Any, other: Any, columns: int, round_: Any) -> None:
    """Forces of a pair of points at the solution."""
    for j in range(columns):
        body, w, d = load_body(state, j), load_foreseen(state, j), load_change(state, j)
        late = is_late(load_clock(state, j), load_attempt(state, j))
        a, worst_a, next_a = meet(body, w, load_touch(one, j), load_memory(one, j), d, late, round_)
        b, worst_b, next_b = meet(body, w, load_touch(other, j), load_memory(other, j), d, late, round_)
        store_next(one, j, next_a)
        store_next(other, j, next_b)
        store_sum(state, j, add_sum(load_sum(state, j), add_sum(a, b)))
        store_largest(state, j, larger_of(load_largest(state, j), larger_of(worst_a, worst_b)))


@njit(**INNER)
def commit_all(state: Any, columns: int, ticks: float, round_: Any) -> None:
    """The end of the step of all bodies, or its refusal."""
    for j in range(columns):
        body, s, attempt, t = load_body(state, j), load_state(state, j), load_attempt(state, j), load_sum(state, j)
        most = load_largest(state, j)
        fast = turns_fast(s, load_foreseen(state, j), most) if round_ else False
        again, sooner, following = next_attempt(
            BODY, load_clock(state, j), attempt, found_of(most, t.fz, fast), s.tick + attempt.length, ticks
        )
        moved, peaks, account = commit(
            body,
            s,
            load_peaks(state, j),
            load_account(state, j),
            load_foreseen(state, j),
            load_change(state, j),
            t,
            most.depth,
            attempt.length,
        )
        store_attempt(state, j, following)
        store_refused(state, j, Refused(1.0 if again else 0.0, 1.0 if sooner else 0.0))
        store_state(state, j, again, moved)
        store_peaks(state, j, again, peaks)
        store_account(state, j, again, account)


@njit(**INNER)
def remember_all(state: Any, one: Any, columns: int) -> None:
    """What a point remembers of a step that was taken; of one that was not, what slid in it."""
    for j in range(columns):
        new, refused = load_next(one, j), load_refused(state, j)
        store_memory(one, j, refused.again > 0.0, new)
        one[SLID + j] = one[SLID + j] if refused.sooner > 0.0 else new.slid


@cache
def loops(round_: bool) -> Any:
    """The steps of a sample, for bodies with vertices or with a rim, whose type `kind` is for the compiled function's name."""

    @njit(**INNER)
    def advance(
        kind: Any,  # noqa: ARG001
        state: Any,
        vertices: Any,
        count: int,
        base: int,
        columns: int,
        steps: int,
    ) -> None:
        half = count // 2 * OF_A_VERTEX
        for _ in range(steps):
            foresee_all(state, columns, WHOLE * steps)
            lie_all(state, vertices, half, base, columns, round_)
            for pair in range(0, half, OF_A_VERTEX):
                one, other = vertices[pair : pair + OF_A_VERTEX], vertices[half + pair : half + pair + OF_A_VERTEX]
                if round_:
                    ahead = 1.0 if pair == 0 else 0.0
                    roll_all(state, one, other, columns, ahead, 1.0 - ahead)
                else:
                    touch_all(state, one, other, columns)
                share_all(state, one, other, columns)
            solve_all(state, columns)
            for pair in range(0, half, OF_A_VERTEX):
                one, other = vertices[pair : pair + OF_A_VERTEX], vertices[half + pair : half + pair + OF_A_VERTEX]
                meet_all(state, one, other, columns, round_)
            commit_all(state, columns, WHOLE * steps, round_)
            for point in range(0, 2 * half, OF_A_VERTEX):
                remember_all(state, vertices[point : point + OF_A_VERTEX], columns)

    return advance
