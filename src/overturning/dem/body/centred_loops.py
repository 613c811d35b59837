"""Bodies side by side: the centred scheme's loops over the lanes, around the equations of one body in `centred`."""

from functools import cache
from typing import Any, Final

from numba import njit

from overturning.dem.body.centred import contribution, is_fine, predict, predict_point, rim_point, solve
from overturning.dem.body.commit import Kept, commit, correct, found_of, is_steady, turns_fast
from overturning.dem.body.lying import landing_of, lands_flat, lie_all, lies, waits
from overturning.dem.body.state import (
    ROWS,
    VERTEX,
    Account,
    Body,
    Change,
    Equations,
    Largest,
    Lying,
    Peaks,
    Point,
    Predicted,
    PredictedPoint,
    Rejected,
    Shaking,
    Stance,
    State,
    Sum,
    Vertex,
)
from overturning.dem.body.vectors import Matrix, apply, frame_of
from overturning.dem.kernel.clock import BODY, Attempt, Clock, next_attempt
from overturning.dem.kernel.lanes import INNER, arithmetic, select

load_body, load_shaking = ROWS.access(Body).load, ROWS.access(Shaking).load
load_frame, store_frame, _ = ROWS.access(Matrix)
load_state, _, store_state = ROWS.access(State)
load_stance = ROWS.access(Stance).load
load_lying, store_lying, _ = ROWS.access(Lying)
load_peaks, _, store_peaks = ROWS.access(Peaks)
load_account, _, store_account = ROWS.access(Account)
load_attempt, store_attempt, _ = ROWS.access(Attempt)
load_rejected, store_rejected, _ = ROWS.access(Rejected)
load_clock = ROWS.access(Clock).load
load_predicted, store_predicted, _ = ROWS.access(Predicted)
load_equations, store_equations, _ = ROWS.access(Equations)
load_change, store_change, _ = ROWS.access(Change)
load_sum, store_sum, _ = ROWS.access(Sum)
load_largest, store_largest, _ = ROWS.access(Largest)
add_equations, add_sum, larger_of = arithmetic(Equations).plus, arithmetic(Sum).plus, arithmetic(Largest).largest
load_vertex = VERTEX.access(Vertex).load
load_memory, _, store_memory = VERTEX.access(Point, "old")
load_point, store_point, _ = VERTEX.access(PredictedPoint)
load_next, store_next, _ = VERTEX.access(Point, "new")
OF_A_VERTEX: Final = VERTEX.size
SLID: Final = VERTEX.row(Point, "old.slid")


@njit(**INNER)
def predict_all(state: Any, columns: int, ticks: float) -> None:
    """Where all bodies would be, and no force yet."""
    for j in range(columns):
        w = predict(
            load_body(state, j), load_state(state, j), load_attempt(state, j).length, load_shaking(state, j), ticks
        )
        store_predicted(state, j, w)
        store_frame(state, j, frame_of(w.turn))


@njit(**INNER)
def predict_vertices(state: Any, one: Any, other: Any, columns: int) -> None:
    """A pair of vertices of all bodies at the predicted end."""
    for j in range(columns):
        body, w, f = load_body(state, j), load_predicted(state, j), load_frame(state, j)
        fine = is_fine(load_clock(state, j), load_attempt(state, j))
        p, q, lying = load_vertex(one, j), load_vertex(other, j), load_lying(state, j)
        flat, begun = lands_flat(lying), landing_of(body, lying)
        a, b = apply(f, p.own), apply(f, q.own)
        left, right = load_memory(one, j), load_memory(other, j)
        store_point(
            one, j, predict_point(body, w, f, a, left, fine, False, (waits(body, lying, p, a.z, left), flat, begun))
        )
        store_point(
            other, j, predict_point(body, w, f, b, right, fine, False, (waits(body, lying, q, b.z, right), flat, begun))
        )


@njit(**INNER)
def predict_rim(state: Any, one: Any, other: Any, columns: int, ahead: float, aside: float) -> None:
    """The same for a pair of points of the rim."""
    for j in range(columns):
        body, w, f = load_body(state, j), load_predicted(state, j), load_frame(state, j)
        fine = is_fine(load_clock(state, j), load_attempt(state, j))
        left, right, between = (
            load_memory(one, j),
            load_memory(other, j),
            (aside != 0.0) & (not lies(load_lying(state, j))),
        )
        lying = load_lying(state, j)
        flat, begun = lands_flat(lying), landing_of(body, lying)
        a, b = rim_point(body, f, ahead, aside), rim_point(body, f, -ahead, -aside)
        store_point(
            one, j, predict_point(body, w, f, a, left, fine, True, (between & (left.depth <= 0.0), flat, begun))
        )
        store_point(
            other, j, predict_point(body, w, f, b, right, fine, True, (between & (right.depth <= 0.0), flat, begun))
        )


@njit(**INNER)
def contribute_all(state: Any, one: Any, other: Any, columns: int, more: Any) -> None:
    """The part of a pair in the equations; `more` is None of the first one, anything of those that are added to it."""
    for j in range(columns):
        body, half = load_body(state, j), load_predicted(state, j).half
        fine = is_fine(load_clock(state, j), load_attempt(state, j))
        a = contribution(body, half, load_point(one, j), load_memory(one, j), fine)
        b = contribution(body, half, load_point(other, j), load_memory(other, j), fine)
        part = add_equations(a, b)
        if more is not None:
            part = add_equations(load_equations(state, j), part)
        store_equations(state, j, part)


@njit(**INNER)
def solve_all(state: Any, columns: int) -> None:
    """The equations of all bodies."""
    for j in range(columns):
        store_change(state, j, solve(
            load_body(state, j), load_state(state, j), load_predicted(state, j), load_equations(state, j)
        ))  # fmt: skip


@njit(**INNER)
def correct_all(state: Any, one: Any, other: Any, columns: int, round_: Any, more: Any) -> None:
    """Forces of a pair of points at the solution; `more` as of `contribute_all`."""
    for j in range(columns):
        body, w, d = load_body(state, j), load_predicted(state, j), load_change(state, j)
        fine = is_fine(load_clock(state, j), load_attempt(state, j))
        a, worst_a, next_a = correct(body, w, load_point(one, j), load_memory(one, j), d, fine, round_)
        b, worst_b, next_b = correct(body, w, load_point(other, j), load_memory(other, j), d, fine, round_)
        store_next(one, j, next_a)
        store_next(other, j, next_b)
        forces, worst = add_sum(a, b), larger_of(worst_a, worst_b)
        if more is not None:
            forces, worst = add_sum(load_sum(state, j), forces), larger_of(load_largest(state, j), worst)
        store_sum(state, j, forces)
        store_largest(state, j, worst)


@njit(**INNER)
def commit_all(state: Any, columns: int, ticks: float, round_: Any) -> None:
    """The end of the step of all bodies, or its rejection."""
    for j in range(columns):
        body, s, attempt, t = load_body(state, j), load_state(state, j), load_attempt(state, j), load_sum(state, j)
        most = load_largest(state, j)
        w, d = load_predicted(state, j), load_change(state, j)
        fast = turns_fast(s, w, most) if round_ else False
        steady = is_steady(load_shaking(state, j), w.shaking, ticks, load_stance(state, j).steady)
        found = found_of(most, t.force.z, fast, steady)
        again, sooner, following = next_attempt(
            BODY, load_clock(state, j), attempt, found, s.tick + attempt.length, ticks
        )
        kept = Kept(s, load_peaks(state, j), load_account(state, j))
        kept = commit(body, kept, w, d, t, most.depth, attempt.length)
        store_attempt(state, j, following)
        store_rejected(state, j, Rejected(1.0 if again else 0.0, 1.0 if sooner else 0.0))
        store_state(state, j, again, kept.state)
        store_peaks(state, j, again, kept.peaks)
        store_account(state, j, again, kept.account)


@njit(**INNER)
def remember_all(state: Any, one: Any, columns: int) -> None:
    """What a point remembers of a step that was taken; of one that was not, what slid in it."""
    for j in range(columns):
        new, rejected = load_next(one, j), load_rejected(state, j)
        store_memory(one, j, rejected.again > 0.0, new)
        one[SLID + j] = select(rejected.sooner > 0.0, one[SLID + j], new.slid)


@cache
def loops(round_: bool) -> Any:
    """The steps of a sample, for bodies with vertices or with a rim; the type of `kind` is for the compiled name."""

    @njit(**INNER)
    def advance(
        kind: Any,  # noqa: ARG001
        state: Any,
        vertices: Any,
        count: int,
        base: int,
        columns: int,
        steps: int,
        ticks: float,
    ) -> None:
        half = count // 2 * OF_A_VERTEX
        for _ in range(steps):
            predict_all(state, columns, ticks)
            lie_all(state, vertices, half, base, columns, round_)
            for pair in range(0, half, OF_A_VERTEX):
                one, other = vertices[pair : pair + OF_A_VERTEX], vertices[half + pair : half + pair + OF_A_VERTEX]
                if round_:
                    ahead = 1.0 if pair == 0 else 0.0
                    predict_rim(state, one, other, columns, ahead, 1.0 - ahead)
                else:
                    predict_vertices(state, one, other, columns)
                if pair == 0:
                    contribute_all(state, one, other, columns, None)
                else:
                    contribute_all(state, one, other, columns, 1)
            solve_all(state, columns)
            for pair in range(0, half, OF_A_VERTEX):
                one, other = vertices[pair : pair + OF_A_VERTEX], vertices[half + pair : half + pair + OF_A_VERTEX]
                if pair == 0:
                    correct_all(state, one, other, columns, round_, None)
                else:
                    correct_all(state, one, other, columns, round_, 1)
            commit_all(state, columns, ticks, round_)
            for point in range(0, 2 * half, OF_A_VERTEX):
                remember_all(state, vertices[point : point + OF_A_VERTEX], columns)

    return advance
