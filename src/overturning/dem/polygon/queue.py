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
from overturning.dem.mechanics import line, renormalised
from overturning.dem.polygon import centred, cundall, rows
from overturning.dem.polygon import tables as t
from overturning.dem.polygon.energy import energy, springs
from overturning.dem.polygon.memory import load_at_rest
from overturning.dem.polygon.note import note, note_forces
from overturning.dem.polygon.rows import Case, Law, Pose, Shaking
from overturning.dem.polygon.search import search
from overturning.dem.polygon.step import step_of
from overturning.dem.polygon.verdict import GOES_ON, finish, note_standing, verdict
from overturning.dem.status import Status
from overturning.dem.time_step import Scheme

SCHEMES: Final[dict[Scheme, tuple[Any, Any]]] = {
    Scheme.CUNDALL: (cundall.Cundall(), cundall.contact),
    Scheme.CENTRED: (centred.Centred(), centred.contact),
}
"""What the kernel is told of each scheme, and the loop that computes a pair's forces; the type of the one picks the other."""

LOOK: Final = 0.1
"""A case is looked at after each so many seconds of its record, or each sample where that is longer."""


def chosen_step(scheme: Any, upward: Any) -> Any:
    """The step of a scheme, without the vertical component where `upward` is None; for compiled code, by their types."""
    contact = next(contact for told, contact in SCHEMES.values() if type(told) is scheme.instance_class)
    return step_of(contact, not isinstance(upward, types.NoneType))


@overload(chosen_step)
def _chosen_step(scheme: Any, upward: Any) -> Any:
    step = chosen_step(scheme, upward)

    def chosen(scheme: Any, upward: Any) -> Any:  # noqa: ARG001, Numba wants the same arguments
        return step

    return chosen


@njit(**OPTIONS)
def start(
    state: Any, j: int, case: Any, initial: Any, layout: Any, sizes: Any, shapes: Any, interval: float, steps: int,
    gravity: float,
) -> None:  # fmt: skip
    """Put a case into column j: the scene's column at rest, its own friction, damping and amplitude."""
    for row in range(initial.size):
        state[row * rows.COLUMNS + j] = initial[row]
    step, still = interval / steps, Shaking(0.0, 0.0, 0.0, 0.0, 0.0)
    now, calm, after = case[t.P_FIRST], case[t.P_CALM], case[t.P_AFTER]
    rows.store_case(state, j, Case(still, step, steps / interval, case[t.P_AMPLITUDE], now, calm, after, 0.0))
    for i in range(sizes.size):
        e = rows.of_element(state, i)
        e[rows.UPRIGHT_UNTIL + j] = now * interval
        e[rows.SAFE_FROM + j] = case[t.PARAMETERS + i]
    for p in range(layout.shape[0]):
        i, k = layout[p, 0], layout[p, 1]
        q, a, b = rows.of_pair(state, sizes.size, p), rows.of_element(state, i), rows.of_element(state, k)
        pair = rows.load_pair(q, j)
        law, settled = pair.law, pair.nearest.limit == np.inf
        friction = law.friction if law.friction >= 0.0 else case[t.P_FRICTION]
        dashpot = law.dashpot * case[t.P_DAMPING]
        rows.store_law(q, j, Law(law.normal, law.tangential, dashpot, friction, law.compliance))
        search(q, a, b, j, step, shapes[i, : sizes[i]], shapes[k, : sizes[k]])
        if settled:
            q[rows.LIMIT + j], q[rows.REACH + j] = np.inf, -1.0
        load_at_rest(q, a, b, j)
        q[rows.TAKEN + j] = springs(rows.load_pair(q, j))
    state[rows.ENERGY + j] = energy(state, j, layout, sizes.size, gravity)


@njit(**OPTIONS)
def copy_column(state: Any, count: int, source: int, target: int) -> None:
    """Copy all rows of a column to another one."""
    for r in range(count):
        state[r * rows.COLUMNS + target] = state[r * rows.COLUMNS + source]


@njit(**OPTIONS)
def next_sample(state: Any, elements: int, row: Any, ground: Any, upward: Any, steps: int) -> None:
    """Bring the turning pairs back to length 1 and load the ground motion of each column's sample."""
    for i in range(elements):
        e = rows.of_element(state, i)
        for j in range(rows.COLUMNS):
            pose = rows.load_pose(e, j)
            cos, sin = renormalised(pose.cos, pose.sin)
            rows.store_pose(e, j, Pose(pose.x, pose.z, pose.angle, cos, sin))
    scale, last = 1.0 / steps, ground.shape[1] - 3
    for j in range(rows.COLUMNS):
        case = rows.load_case(state, j)
        i, factor = min(int(case.sample), last), case.amplitude
        base, slope = line(ground[row[j], i] * factor, ground[row[j], i + 1] * factor, scale)
        up_base, up_slope = 0.0, 0.0
        if upward is not None:
            up_base, up_slope = line(upward[i] * factor, upward[i + 1] * factor, scale)
        rows.store_shaking(state, j, Shaking(base, slope, up_base, up_slope, 0.0))


@njit(**OPTIONS)
def end_sample(state: Any, elements: int, rules: Any, steps: int, interval: float) -> None:
    """Each element's slip, and the last time at which a standing one's rotation was below the critical angle."""
    for i in range(elements):
        if rules[i, t.IS_FREE] > 0.0:
            e = rows.of_element(state, i)
            note_standing(e, rows.of_element(state, int(rules[i, t.SUPPORT])), state, 1.0 / steps, interval)
    for j in range(rows.COLUMNS):
        state[rows.SAMPLE + j] = state[rows.SAMPLE + j] + 1.0


@njit(nogil=True, **OPTIONS)
def run_queue(
    scheme: Any, queue: Any, cases: Any, row_of_case: Any, variant_of_case: Any, initial: Any, layout: Any, sizes: Any,
    shapes: Any, rules: Any, limits: Any, ground: Any, upward: Any, samples: int, interval: float, steps: int,
    gravity: float, budget: int, counter: Any, path: Any, results: Any, each: Any,
) -> int:  # fmt: skip
    """Run cases of equal steps per sample, a finished column taking the next one, and return how many rows of `path` were filled.

    Parameters
    ----------
    scheme, queue, cases : NamedTuple of `SCHEMES`, ndarray of int64, shape (m,), ndarray, shape (n, PARAMETERS)
        Rows of the case table to run, in this order; and that table.
    row_of_case, variant_of_case : ndarray of int64, shape (n,)
        Row of `ground` that shakes each case, and its variant of the scene.
    initial, rules, limits : ndarray, shape (variants, rows), (variants, elements, RULES), (variants, LIMITS)
        A column at rest; when an element has fallen; when a case has failed or rests.
    layout, sizes, shapes : ndarray of int64, shape (pairs, 2), (elements,), ndarray, shape (variants, elements, vertices, 9)
        The two elements of each pair; vertices of each element; faces: both ends, normal, distance, middle, half length.
    ground, upward : ndarray, shape (azimuths, samples + 3), (samples + 3,) or None
        Acceleration of the base towards the azimuth and up, m/s², padded with zeros; no upward one compiles a kernel without.
    samples, interval, steps, gravity, budget : int, float, int, float, int
        Length of the record, s between samples, steps per sample, m/s², largest number of steps of a case.
    path : ndarray, shape (rows, 2 + 6 elements) or (rows, 2 + 6 elements + 10 pairs)
        Zeros, filled with the first column's state at each sample and, where there is room, the forces at both ends of
        each pair; no rows to leave out.
    counter, results, each : ndarray of int64, shape (1,), ndarray, shape (n, RESULTS), (n, elements, ELEMENT_RESULTS)
        Grows by the element steps done, for progress; filled in the rows of the queue.
    """
    count, elements = initial.shape[1], sizes.size
    owner = aligned(count * rows.COLUMNS)
    state: Any = rows.borrowed(owner)  # type: ignore[call-arg]
    case, row = np.zeros(rows.COLUMNS, np.int64), np.zeros(rows.COLUMNS, np.int64)
    variant, done = np.zeros(rows.COLUMNS, np.int64), np.zeros(rows.COLUMNS, np.int64)
    step = chosen_step(scheme, upward)
    free = 0
    for i in range(elements):
        free += 1 if rules[0, i, t.IS_FREE] > 0.0 else 0
    # Not literals: for those Numba would compile everything that they go into once more.
    active, head, noted, filled = np.int64(0), np.int64(0), np.int64(0), np.int64(0)
    stride = max(int(LOOK / interval), 1)
    with_forces = path.shape[0] > 0 and path.shape[1] > 2 + 6 * elements
    while True:
        while active < rows.COLUMNS and head < queue.size:
            n = queue[head]
            v = variant_of_case[n]
            case[active], row[active], variant[active], done[active] = n, row_of_case[n], v, 0
            start(state, active, cases[n], initial[v], layout, sizes, shapes[v], interval, steps, gravity)
            active, head = active + 1, head + 1
        if active == 0:
            owner[0] = noted  # held until here
            return noted
        # Columns that never held a case repeat the first, so that nothing undefined is computed beside the others.
        filled = max(filled, active)
        while filled < rows.COLUMNS:
            row[filled], variant[filled] = row[0], variant[0]
            copy_column(state, count, 0, filled)
            filled += 1
        next_sample(state, elements, row, ground, upward, steps)
        if noted < path.shape[0]:
            note(state, 0, elements, interval, path[noted])
            noted += 1
        for _ in range(steps):
            step(state, layout, sizes, shapes, variant, gravity)
            if with_forces and noted > 0:
                # By its row: a slice of the path would be counted, in a locked instruction that every step would pay.
                note_forces(state, 0, layout, elements, 1.0 / steps, path, noted - 1)
        end_sample(state, elements, rules[0], steps, interval)
        counter[0] += active * steps * free
        for j in range(active - 1, -1, -1):
            done[j] += steps
            n, v, spent = case[j], variant[j], done[j] >= budget
            if int(state[rows.SAMPLE + j]) % stride != 0 and not spent:
                continue
            ended = verdict(state, j, layout, elements, rules[v], limits[v], float(samples), gravity)
            ended = Status.OVER_BUDGET if spent and ended == GOES_ON else ended
            if ended != GOES_ON:
                finish(state, j, layout, elements, limits[v], ended, done[j], gravity, results[n], each[n])
                # The last column, already looked at, moves into the free place.
                active -= 1
                case[j], row[j], variant[j], done[j] = case[active], row[active], variant[active], done[active]
                copy_column(state, count, active, j)


keep_compiled(run_queue)
