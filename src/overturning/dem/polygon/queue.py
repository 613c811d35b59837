"""The general kernel: convex polygons that meet at vertices and faces, many cases side by side.

Signs: x points to the azimuth, z up, rotation is positive clockwise (towards the azimuth). The point (p, q) of an
element is at ``(x + c p + s q, z − s p + c q)`` with c, s the cosine and sine of its rotation; a force (X, Z) at the
place (p', q') from the centre has the moment ``q' X − p' Z``. The tangent of a face with outward normal n is
``(−n_z, n_x)``; an end's force is ``f_n n + f_t (n_z, −n_x)`` on the pair's first element.

A queue of cases goes through the columns; a finished column takes the next one. docs/scenes.md derives the rules,
`overturning.dem.polygon.rows` says what is known of a case, `overturning.dem.polygon.step` is one step. A scheme is one file,
with a named tuple and the loop `contact`, and one row of `SCHEMES`.
"""

from typing import Any, Final

import numpy as np
from numba import njit, types
from numba.extending import overload

from overturning.dem.cache import keep_compiled
from overturning.dem.lanes import OPTIONS, aligned
from overturning.dem.mechanics import renormalised
from overturning.dem.polygon import centred, cundall, rows
from overturning.dem.polygon import tables as t
from overturning.dem.polygon.energy import energy, springs
from overturning.dem.polygon.equations import BLOCK_SIZE
from overturning.dem.polygon.memory import load_at_rest
from overturning.dem.polygon.note import note, note_forces
from overturning.dem.polygon.search import search
from overturning.dem.polygon.state import Attempt, Case, Found, Law, Line, Pose, Shaking, Verdict
from overturning.dem.polygon.step import step_of, trapezoidal_step
from overturning.dem.polygon.verdict import GOES_ON, finish, note_carried, note_standing, verdict
from overturning.dem.status import Status
from overturning.dem.time_step import Scheme

SCHEMES: Final[dict[Scheme, tuple[Any, Any]]] = {
    Scheme.CUNDALL: (cundall.Cundall(), lambda vertical: step_of(cundall.contact, vertical)),
    Scheme.CENTRED: (centred.Centred(), trapezoidal_step),
}
"""What the kernel is told of each scheme, and what makes its step; the type of the one picks the other."""

LOOK: Final = 0.1
"""A case is looked at after each so many seconds of its record, or each sample where that is longer."""


def chosen_step(scheme: Any, upward: Any) -> Any:
    """The step of a scheme, without the vertical component where `upward` is None; for compiled code, by their types."""
    make = next(make for told, make in SCHEMES.values() if type(told) is scheme.instance_class)
    return make(not isinstance(upward, types.NoneType))


@overload(chosen_step)
def _chosen_step(scheme: Any, upward: Any) -> Any:
    step = chosen_step(scheme, upward)

    def chosen(scheme: Any, upward: Any) -> Any:  # noqa: ARG001, Numba wants the same arguments
        return step

    return chosen


@njit(**OPTIONS)
def start(
    state: Any, j: int, case: Any, initial: Any, elements: int, layout: Any, sizes: Any, shapes: Any, interval: float,
    ticks: float, lag: float, gravity: float,
) -> None:  # fmt: skip
    """Put a case into column j: the scene's column at rest, its own friction, damping and amplitude."""
    for row in range(initial.size):
        state[row * rows.COLUMNS + j] = initial[row]
    step, none = interval / ticks, Line(0.0, 0.0, 0.0)
    now, calm, after, finest, dwell = (
        case[t.P_FIRST],
        case[t.P_CALM],
        case[t.P_AFTER],
        case[t.P_FINEST],
        case[t.P_DWELL],
    )
    rows.store_case(state, j, Case(
        Shaking(none, none, 0.0), step, ticks / interval, lag * step, finest, dwell, Attempt(finest, dwell, 0.0),
        Found(0.0, 0.0, 0.0, 0.0, 0.0), Verdict(0.0, Attempt(0.0, 0.0, 0.0)), case[t.P_AMPLITUDE], now, calm, after, 0.0,
    ))  # fmt: skip
    for i in range(elements):
        e = rows.of_element(state, i)
        e[rows.UPRIGHT_UNTIL + j] = e[rows.CARRIED_UNTIL + j] = now * interval
    for p in range(layout.shape[0]):
        i, k = layout[p, 0], layout[p, 1]
        m, n = layout[p, 2], layout[p, 3]
        q, a, b = rows.of_pair(state, elements, p), rows.of_element(state, i), rows.of_element(state, k)
        pair = rows.load_pair(q, j)
        law, settled = pair.law, pair.nearest.limit == np.inf
        friction = law.friction if law.friction >= 0.0 else case[t.P_FRICTION]
        dashpot = law.dashpot * case[t.P_DAMPING]
        rows.store_law(q, j, Law(law.normal, law.tangential, dashpot, friction, law.compliance))
        search(q, a, b, j, 2.0 * lag * step, shapes[m, : sizes[m]], shapes[n, : sizes[n]])
        if settled:
            q[rows.LIMIT + j], q[rows.REACH + j] = np.inf, -1.0
        load_at_rest(q, j)
        q[rows.TAKEN + j] = springs(rows.load_pair(q, j))
    state[rows.ENERGY + j] = energy(state, j, layout, elements, gravity)


@njit(**OPTIONS)
def copy_column(state: Any, count: int, source: int, target: int) -> None:
    """Copy all rows of a column to another one."""
    for r in range(count):
        state[r * rows.COLUMNS + target] = state[r * rows.COLUMNS + source]


@njit(**OPTIONS)
def next_sample(state: Any, elements: int, row: Any, ground: Any, upward: Any, ticks: float) -> None:
    """Bring the turning pairs back to length 1 and load the ground motion of each column's sample."""
    for i in range(elements):
        e = rows.of_element(state, i)
        for j in range(rows.COLUMNS):
            pose = rows.load_pose(e, j)
            cos, sin = renormalised(pose.cos, pose.sin)
            rows.store_pose(e, j, Pose(pose.x, pose.z, pose.angle, cos, sin))
    scale, last = 1.0 / ticks, ground.shape[1] - 3
    for j in range(rows.COLUMNS):
        case = rows.load_case(state, j)
        i, factor = min(int(case.sample), last), case.amplitude
        rows.store_base(state, j, piece(ground[row[j]], i, factor, scale))
        if upward is not None:
            rows.store_up(state, j, piece(upward, i, factor, scale))


@njit(**OPTIONS)
def piece(motion: Any, i: int, factor: float, scale: float) -> Line:
    """A component of the motion over a sample, by its ticks, of which `scale` is 1 over their number."""
    a0, a1, a2 = motion[i] * factor, motion[i + 1] * factor, motion[i + 2] * factor
    return Line(a0, (a1 - a0) * scale, ((a2 - a1) - (a1 - a0)) * scale)


@njit(**OPTIONS)
def end_sample(state: Any, layout: Any, elements: int, rules: Any, ticks: float, interval: float) -> None:
    """Each element's slip, and until when a standing one could come back and was on what carried it."""
    for i in range(elements):
        if rules[i, t.IS_FREE] > 0.0:
            e = rows.of_element(state, i)
            note_standing(e, rows.of_element(state, int(rules[i, t.SUPPORT])), state, 1.0 / ticks, interval)
    for p in range(layout.shape[0]):
        a, b = rows.of_element(state, layout[p, 0]), rows.of_element(state, layout[p, 1])
        note_carried(rows.of_pair(state, elements, p), a, b, state, 1.0 / ticks, interval)
    for j in range(rows.COLUMNS):
        sample, tick = state[rows.SAMPLE + j], state[rows.TICK + j]
        state[rows.SAMPLE + j] = sample + 1.0 if tick >= ticks else sample
        state[rows.TICK + j] = tick - ticks if tick >= ticks else tick


@njit(**OPTIONS)
def ending(
    state: Any, j: int, case: Any, layout: Any, parts: Any, elements: int, rules: Any, limits: Any, end: float, gravity: float,
    spent: bool,
) -> int:  # fmt: skip
    """`Status` of a column at the end of a sample, also where it has spent its steps, or `GOES_ON`."""
    ended = verdict(state, j, case, layout, parts, elements, rules, limits, end, gravity)
    return Status.OVER_BUDGET if spent and ended == GOES_ON else ended


@njit(**OPTIONS)
def movable(initial: Any, rules: Any, moves: Any) -> int:
    """Fill in which elements of a scene move, and count those that are free."""
    free = 0
    for i in range(moves.size):
        moves[i] = initial[(rows.CASE_SIZE + i * rows.ELEMENT_SIZE + rows.FRAME) // rows.COLUMNS] != 0.0
        free += 1 if rules[i, t.IS_FREE] > 0.0 else 0
    return free


@njit(nogil=True, **OPTIONS)
def run_queue(
    scheme: Any, queue: Any, cases: Any, row_of_case: Any, variant_of_case: Any, initial: Any, layout: Any, parts: Any,
    sizes: Any, shapes: Any, rules: Any, limits: Any, ground: Any, upward: Any, samples: int, interval: float, steps: int,
    gravity: float, budget: int, counter: Any, path: Any, results: Any, each: Any,
) -> int:  # fmt: skip
    """Run cases of equal steps per sample, a finished column taking the next one, and return how many rows of `path` were filled.

    Parameters
    ----------
    scheme, queue, cases : NamedTuple of `SCHEMES`, ndarray of int64, shape (m,), ndarray, shape (n, PARAMETERS + parts)
        Rows of the case table to run, in this order; and that table.
    row_of_case, variant_of_case : ndarray of int64, shape (n,)
        Row of `ground` that shakes each case, and its variant of the scene.
    initial, rules, limits : ndarray, shape (variants, rows), (variants, elements, RULES), (variants, LIMITS)
        A column at rest; when an element has fallen; when a case has failed or rests.
    layout, parts, sizes : ndarray of int64, shape (pairs, 4), (parts, 2), (pieces,)
        The two elements of each pair and their convex pieces; of all that can move as one, the lowest element and the one
        listed last; vertices of each piece.
    shapes : ndarray, shape (variants, pieces, vertices, 12)
        Faces as of `Polygon.faces`.
    ground, upward : ndarray, shape (azimuths, samples + 3), (samples + 3,) or None
        Acceleration of the base towards the azimuth and up, m/s², padded with zeros; no upward one compiles a kernel without.
    samples, interval, steps, gravity, budget : int, float, int, float, int
        Length of the record, s between samples, steps per sample, m/s², largest number of element steps of a case.
    path : ndarray, shape (rows, 2 + 6 elements) or (rows, 2 + 6 elements + 10 pairs)
        Zeros, filled with the first column's state at each sample and, where there is room, the forces at both ends of
        each pair; no rows to leave out.
    counter, results, each : ndarray of int64, shape (1,), ndarray, shape (n, RESULTS), (n, elements, ELEMENT_RESULTS)
        Grows by the element steps done, for progress; filled in the rows of the queue, the steps found there counting.
    """
    count, elements = initial.shape[1], rules.shape[1]
    owner = aligned(count * rows.COLUMNS)
    state: Any = rows.borrowed(owner)  # type: ignore[call-arg]
    case, row = np.zeros(rows.COLUMNS, np.int64), np.zeros(rows.COLUMNS, np.int64)
    variant, done = np.zeros(rows.COLUMNS, np.int64), np.zeros(rows.COLUMNS, np.int64)
    looked = np.zeros(rows.COLUMNS, np.int64)
    step, ticks = chosen_step(scheme, upward), 1.0 * scheme.ticks * steps
    # Blocks of the equations and which of them are used; below them, which pairs are in reach.
    matrix = aligned(elements * elements * BLOCK_SIZE)
    used, moves = np.zeros((elements + 1, max(elements, layout.shape[0])), np.bool_), np.zeros(elements, np.bool_)
    free = movable(initial[0], rules[0], moves)
    # Not literals: for those Numba would compile everything that they go into once more.
    active, head, noted, filled = np.int64(0), np.int64(0), np.int64(0), np.int64(0)
    stride = max(int(LOOK / interval), 1)
    early = np.zeros((1, path.shape[1]))
    with_forces = path.shape[0] > 0 and path.shape[1] > 2 + 6 * elements
    while True:
        while active < rows.COLUMNS and head < queue.size:
            n = queue[head]
            v = variant_of_case[n]
            case[active], row[active], variant[active] = n, row_of_case[n], v
            done[active] = int(results[n, t.R_STEPS])
            looked[active] = int(cases[n, t.P_FIRST]) // stride
            start(
                state, active, cases[n], initial[v], elements, layout, sizes, shapes[v], interval, ticks, scheme.lag, gravity
            )  # fmt: skip
            active, head = active + 1, head + 1
        if active == 0:
            owner[0] = noted  # held until here
            return noted
        # Columns that never held a case repeat the first, so that nothing undefined is computed beside the others.
        for j in range(max(filled, active), rows.COLUMNS):
            row[j], variant[j] = row[0], variant[0]
            copy_column(state, count, 0, j)
        filled = np.int64(rows.COLUMNS)
        next_sample(state, elements, row, ground, upward, ticks)
        for _ in range(steps):
            if path.shape[0] == 0:
                step(state, matrix, used, moves, layout, sizes, shapes, variant, ticks, gravity)
                continue
            tick, share = state[rows.TICK], state[rows.LENGTH] / ticks
            # Once for each sample, also where its first step has to be done again.
            if (tick == 0.0 or tick == ticks) and not state[rows.AGAIN] > 0.0 and noted < path.shape[0]:
                note(state, 0, elements, interval, ticks, path[noted])
                noted += 1
            # What the forces at the begin of the step do in it counts only if the step is taken.
            # By its row: a slice of the path would be counted, in a locked instruction that every step would pay.
            if with_forces:
                early[:] = 0.0
                note_forces(state, 0, layout, elements, (0.5 - scheme.lag) * share, early, 0)
            step(state, matrix, used, moves, layout, sizes, shapes, variant, ticks, gravity)
            if with_forces and not state[rows.AGAIN] > 0.0:
                path[noted - 1] += early[0]
                note_forces(state, 0, layout, elements, (0.5 + scheme.lag) * share, path, noted - 1)
        end_sample(state, layout, elements, rules[0], ticks, interval)
        counter[0] += active * steps * free
        for j in range(active - 1, -1, -1):
            done[j] += steps * free
            n, v, spent = case[j], variant[j], done[j] >= budget
            part = int(state[rows.SAMPLE + j]) // stride
            if part == looked[j] and not spent:
                continue
            looked[j] = part
            ended = ending(
                state, j, cases[n], layout, parts, elements, rules[v], limits[v], float(samples), gravity, spent
            )  # fmt: skip
            if ended != GOES_ON:
                finish(
                    state, j, layout, elements, rules[v], limits[v], ended, done[j], gravity, results[n], each[n]
                )  # fmt: skip
                # The last column, already looked at, moves into the free place.
                active -= 1
                case[j], row[j], variant[j], done[j] = case[active], row[active], variant[active], done[active]
                looked[j] = looked[active]
                copy_column(state, count, active, j)


keep_compiled(run_queue)
