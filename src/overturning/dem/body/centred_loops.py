"""Loops of the centred scheme over the lanes of the body kernel; `centred` has the equations of one body."""

from functools import cache
from typing import Any, Final

from numba import njit

from overturning.dem.body.centred import contribution, is_fine, predict, predict_point, rim_point, solve
from overturning.dem.body.commit import AcceptedBodyStep, commit, correct, is_steady, step_findings, turns_fast
from overturning.dem.body.lying import (
    both_ends_rest,
    contact_is_deferred,
    landing_time,
    lands_flat,
    update_base_contacts,
)
from overturning.dem.body.state import (
    ROWS,
    VERTEX,
    BaseContactState,
    BodyAccount,
    BodyChange,
    BodyConstants,
    BodyPeaks,
    BodyShaking,
    BodyState,
    ContactSum,
    Equations,
    LargestFindings,
    Point,
    PredictedBody,
    PredictedPoint,
    Rejection,
    TerminationLimits,
    Vertex,
)
from overturning.dem.body.vectors import Matrix, apply, frame_of
from overturning.dem.kernel.clock import BODY, Attempt, Clock, next_attempt
from overturning.dem.kernel.lanes import INNER, arithmetic, select

load_body, load_shaking = ROWS.access(BodyConstants).load, ROWS.access(BodyShaking).load
load_frame, store_frame, _ = ROWS.access(Matrix)
load_state, _, store_state = ROWS.access(BodyState)
load_limits = ROWS.access(TerminationLimits).load
load_base_contact, store_base_contact, _ = ROWS.access(BaseContactState)
load_peaks, _, store_peaks = ROWS.access(BodyPeaks)
load_account, _, store_account = ROWS.access(BodyAccount)
load_attempt, store_attempt, _ = ROWS.access(Attempt)
load_rejection, store_rejection, _ = ROWS.access(Rejection)
load_clock = ROWS.access(Clock).load
load_predicted, store_predicted, _ = ROWS.access(PredictedBody)
load_equations, store_equations, _ = ROWS.access(Equations)
load_change, store_change, _ = ROWS.access(BodyChange)
load_sum, store_sum, _ = ROWS.access(ContactSum)
load_largest, store_largest, _ = ROWS.access(LargestFindings)
add_equations, add_sum, larger_of = (
    arithmetic(Equations).plus,
    arithmetic(ContactSum).plus,
    arithmetic(LargestFindings).largest,
)
load_vertex = VERTEX.access(Vertex).load
load_memory, _, store_memory = VERTEX.access(Point, "old")
load_point, store_point, _ = VERTEX.access(PredictedPoint)
load_next, store_next, _ = VERTEX.access(Point, "new")
OF_A_VERTEX: Final = VERTEX.size
SLID: Final = VERTEX.row(Point, "old.slid")


@njit(**INNER)
def predict_all(state: Any, columns: int, ticks: float) -> None:
    """Predict all bodies at the end of the step, without contact forces."""
    for j in range(columns):
        w = predict(
            load_body(state, j), load_state(state, j), load_attempt(state, j).length, load_shaking(state, j), ticks
        )
        store_predicted(state, j, w)
        store_frame(state, j, frame_of(w.turn))


@njit(**INNER)
def predict_vertices(state: Any, one: Any, other: Any, columns: int) -> None:
    """Predict a pair of opposite vertices of all bodies."""
    for j in range(columns):
        body, w, f = load_body(state, j), load_predicted(state, j), load_frame(state, j)
        fine = is_fine(load_clock(state, j), load_attempt(state, j))
        p, q, base_contact = load_vertex(one, j), load_vertex(other, j), load_base_contact(state, j)
        flat, new_landing = lands_flat(base_contact), landing_time(body, base_contact)
        a, b = apply(f, p.own), apply(f, q.own)
        left, right = load_memory(one, j), load_memory(other, j)
        store_point(
            one,
            j,
            predict_point(
                body,
                w,
                f,
                a,
                left,
                fine,
                False,
                (contact_is_deferred(body, base_contact, p, a.z, left), flat, new_landing),
            ),
        )
        store_point(
            other,
            j,
            predict_point(
                body,
                w,
                f,
                b,
                right,
                fine,
                False,
                (contact_is_deferred(body, base_contact, q, b.z, right), flat, new_landing),
            ),
        )


@njit(**INNER)
def predict_rim(state: Any, one: Any, other: Any, columns: int, ahead: float, aside: float) -> None:
    """Predict a pair of opposite points of the rim of all bodies."""
    for j in range(columns):
        body, w, f = load_body(state, j), load_predicted(state, j), load_frame(state, j)
        fine = is_fine(load_clock(state, j), load_attempt(state, j))
        left, right, between = (
            load_memory(one, j),
            load_memory(other, j),
            (aside != 0.0) & (not both_ends_rest(load_base_contact(state, j))),
        )
        base_contact = load_base_contact(state, j)
        flat, new_landing = lands_flat(base_contact), landing_time(body, base_contact)
        a, b = rim_point(body, f, ahead, aside), rim_point(body, f, -ahead, -aside)
        store_point(
            one, j, predict_point(body, w, f, a, left, fine, True, (between & (left.depth <= 0.0), flat, new_landing))
        )
        store_point(
            other,
            j,
            predict_point(body, w, f, b, right, fine, True, (between & (right.depth <= 0.0), flat, new_landing)),
        )


@njit(**INNER)
def contribute_all(state: Any, one: Any, other: Any, columns: int, more: Any) -> None:
    """Add the contributions of a pair of points to the equations; `more` is None for the first pair."""
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
    """Solve the equations of all bodies."""
    for j in range(columns):
        store_change(state, j, solve(
            load_body(state, j), load_state(state, j), load_predicted(state, j), load_equations(state, j)
        ))  # fmt: skip


@njit(**INNER)
def correct_all(state: Any, one: Any, other: Any, columns: int, round_: Any, more: Any) -> None:
    """Compute the forces of a pair of points at the solution; `more` is None for the first pair."""
    for j in range(columns):
        body, w, d = load_body(state, j), load_predicted(state, j), load_change(state, j)
        fine = is_fine(load_clock(state, j), load_attempt(state, j))
        a, findings_a, next_a = correct(body, w, load_point(one, j), load_memory(one, j), d, fine, round_)
        b, findings_b, next_b = correct(body, w, load_point(other, j), load_memory(other, j), d, fine, round_)
        store_next(one, j, next_a)
        store_next(other, j, next_b)
        forces, findings = add_sum(a, b), larger_of(findings_a, findings_b)
        if more is not None:
            forces, findings = add_sum(load_sum(state, j), forces), larger_of(load_largest(state, j), findings)
        store_sum(state, j, forces)
        store_largest(state, j, findings)


@njit(**INNER)
def commit_all(state: Any, columns: int, ticks: float, round_: Any) -> None:
    """Accept or reject the step of all bodies, and choose the next."""
    for j in range(columns):
        body, s, attempt, t = load_body(state, j), load_state(state, j), load_attempt(state, j), load_sum(state, j)
        most = load_largest(state, j)
        w, d = load_predicted(state, j), load_change(state, j)
        fast = turns_fast(s, w, most) if round_ else False
        steady = is_steady(load_shaking(state, j), w.shaking, ticks, load_limits(state, j).steady)
        findings = step_findings(most, t.force.z, fast, steady)
        again, sooner, following = next_attempt(
            BODY, load_clock(state, j), attempt, findings, s.tick + attempt.length, ticks
        )
        accepted = AcceptedBodyStep(s, load_peaks(state, j), load_account(state, j))
        accepted = commit(body, accepted, w, d, t, most.depth, attempt.length)
        store_attempt(state, j, following)
        store_rejection(state, j, Rejection(1.0 if again else 0.0, 1.0 if sooner else 0.0))
        store_state(state, j, again, accepted.state)
        store_peaks(state, j, again, accepted.peaks)
        store_account(state, j, again, accepted.account)


@njit(**INNER)
def remember_all(state: Any, one: Any, columns: int) -> None:
    """Store the new state of a point after accepted steps; after rejected ones, only whether it slid."""
    for j in range(columns):
        new, rejected = load_next(one, j), load_rejection(state, j)
        store_memory(one, j, rejected.again > 0.0, new)
        one[SLID + j] = select(rejected.sooner > 0.0, one[SLID + j], new.slid)


@cache
def loops(round_: bool) -> Any:
    """Return the function that computes the steps of a sample, for bodies with vertices or with a rim.

    The type of its argument `kind` makes the compiled names of the two variants differ.
    """

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
            update_base_contacts(state, vertices, half, base, columns, round_)
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
