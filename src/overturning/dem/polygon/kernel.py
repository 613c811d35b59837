"""The general kernel: convex polygons that meet at vertices and faces, many cases side by side.

Signs: x points to the azimuth, z up, rotation is positive clockwise (towards the azimuth). The point (p, q) of an
element is at ``(x + c p + s q, z − s p + c q)`` with c, s the cosine and sine of its rotation; a force (X, Z) at the
place (p', q') from the centre has the moment ``q' X − p' Z``. The tangent of a face with outward normal n is
``(−n_z, n_x)``; an end's force is ``f_n n + f_t (n_z, −n_x)`` on the pair's first element.

One step: nearest faces where the motion since the last search could have changed them (`search`), forces of every pair
at the whole step (`contact_cundall`, `contact_centred`), accelerations, velocities half a step later, poses (`advance`).
docs/scenes.md derives the rules; `overturning.dem.polygon.columns` has the layout of the columns.
"""

from typing import Any, Final

import numpy as np
from numba import njit

from overturning.dem.cache import keep_compiled
from overturning.dem.polygon.advance import advance, count_motion, shake
from overturning.dem.polygon.centred import contact_centred

# isort: off
from overturning.dem.polygon.columns import (
    AFTER, AMPLITUDE, ANGLE, AW, AX, AZ, BASE, CALM, COLUMNS, CONTACT, COS, DASHPOT, ENERGY, FRAME, FRICTION, LIMIT, MINE,
    NORMAL, OPEN, OPTIONS, OWN, RATE, REACH, SAFE_FROM, SAMPLE, SECOND, SIN, SLOPE, STEP, TAKEN, TANGENT, TICK,
    UPRIGHT_UNTIL, UP_BASE, UP_SLOPE, USED, VW, VX, VZ, X, Z, borrowed, element_rows, pair_rows,
)  # fmt: skip
from overturning.dem.polygon.cundall import contact_cundall
from overturning.dem.polygon.energy import energy, springs
from overturning.dem.polygon.memory import end_place, load_at_rest
from overturning.dem.polygon.search import search
from overturning.dem.polygon.tables import (
    FORCE_COLUMNS, IS_FREE, P_AFTER, P_AMPLITUDE, P_CALM, P_DAMPING, P_FIRST, P_FRICTION, PARAMETERS, SUPPORT, T_ANGLE,
    T_FX, T_FZ, T_GROUND, T_LOAD, T_LOAD_X, T_LOAD_Z, T_TIME, T_VW, T_VX, T_VZ, T_X, T_Z,
)  # fmt: skip

# isort: on
from overturning.dem.polygon.verdict import book_slip, book_upright, finish, verdict

CENTRED: Final = 1
"""The number of the centred scheme."""

LOOK: Final = 0.1
"""A case is looked at after each so many seconds of its record, or each sample where that is longer."""


@njit(**OPTIONS)
def start(
    state: Any, j: int, case: Any, initial: Any, layout: Any, sizes: Any, shapes: Any, interval: float, steps: int,
    gravity: float,
) -> None:  # fmt: skip
    """Put a case into column j: the scene's column at rest, its own friction, damping and amplitude."""
    for row in range(initial.size):
        state[row * COLUMNS + j] = initial[row]
    own = state[: OWN * COLUMNS]
    own[STEP + j], own[RATE + j] = interval / steps, steps / interval
    own[AMPLITUDE + j], own[SAMPLE + j] = case[P_AMPLITUDE], case[P_FIRST]
    own[CALM + j], own[AFTER + j] = case[P_CALM], case[P_AFTER]
    for e in range(sizes.size):
        body = element_rows(state, e)
        body[UPRIGHT_UNTIL + j] = case[P_FIRST] * interval
        body[SAFE_FROM + j] = case[PARAMETERS + e]
    for p in range(layout.shape[0]):
        first, second = layout[p, 0], layout[p, 1]
        q, a, b = pair_rows(state, sizes.size, p), element_rows(state, first), element_rows(state, second)
        q[FRICTION + j] = q[FRICTION + j] if q[FRICTION + j] >= 0.0 else case[P_FRICTION]
        q[DASHPOT + j] = q[DASHPOT + j] * case[P_DAMPING]
        settled = q[LIMIT + j] == np.inf
        search(q, a, b, own, j, sizes[first], sizes[second], shapes[first], shapes[second])
        if settled:
            q[LIMIT + j], q[REACH + j] = np.inf, -1.0
        load_at_rest(q, a, b, j)
        q[TAKEN + j] = springs(q, j)
    own[ENERGY + j] = energy(state, j, layout, sizes.size, gravity)


@njit(**OPTIONS)
def next_sample(state: Any, elements: int, row: Any, ground: Any, upward: Any, steps: int) -> None:
    """Bring the turning pairs back to length 1 and load the ground motion of each column's sample."""
    scale = 1.0 / steps
    last = ground.shape[1] - 3
    for e in range(elements):
        body = element_rows(state, e)
        for j in range(COLUMNS):
            c, s = body[COS + j], body[SIN + j]
            unit = 1.5 - 0.5 * (c * c + s * s)
            body[COS + j], body[SIN + j] = c * unit, s * unit
    for j in range(COLUMNS):
        i = min(int(state[SAMPLE + j]), last)
        factor = state[AMPLITUDE + j]
        a0, a1 = ground[row[j], i] * factor, ground[row[j], i + 1] * factor
        state[BASE + j], state[SLOPE + j] = a0, (a1 - a0) * scale
        if upward.size > 0:
            a0, a1 = upward[i] * factor, upward[i + 1] * factor
            state[UP_BASE + j], state[UP_SLOPE + j] = a0, (a1 - a0) * scale
        state[TICK + j] = 0.0


@njit(**OPTIONS)
def end_sample(state: Any, elements: int, rules: Any, steps: int, interval: float) -> None:
    """Each element's slip, and the last time at which a standing one's rotation was below the critical angle."""
    own = state[: OWN * COLUMNS]
    for k in range(elements):
        if rules[k, IS_FREE] == 0.0:
            continue
        body = element_rows(state, k)
        book_slip(body, element_rows(state, int(rules[k, SUPPORT])))
        book_upright(body, own, 1.0 / steps, interval)
    for j in range(COLUMNS):
        own[SAMPLE + j] = own[SAMPLE + j] + 1.0


@njit(**OPTIONS)
def note(state: Any, j: int, elements: int, interval: float, path: Any) -> None:
    """Write a column's state into a row of its trajectory, velocities brought to the whole step."""
    path[T_TIME] = state[SAMPLE + j] * interval
    path[T_GROUND] = state[BASE + j]
    half = 0.5 * state[STEP + j]
    for e in range(elements):
        body = element_rows(state, e)
        to = 2 + 6 * e
        path[to + T_X], path[to + T_Z], path[to + T_ANGLE] = body[X + j], body[Z + j], body[ANGLE + j]
        path[to + T_VX] = body[VX + j] + half * body[AX + j]
        path[to + T_VZ] = body[VZ + j] + half * body[AZ + j]
        path[to + T_VW] = body[VW + j] + half * body[AW + j]


@njit(**OPTIONS)
def note_forces(state: Any, j: int, layout: Any, elements: int, share: float, path: Any, row: int) -> None:
    """Add a step's share of a column's contact forces to the row of its trajectory, with the places where they act."""
    for p in range(layout.shape[0]):
        q, a = pair_rows(state, elements, p), element_rows(state, layout[p, 0])
        b = element_rows(state, layout[p, 1])
        for end in range(2):
            at = end * SECOND + j
            if q[CONTACT + at] == OPEN:
                continue
            n, t = share * q[NORMAL + at], share * q[TANGENT + at]
            rx, rz, nx, nz = end_place(q, a, b, j, end, q[CONTACT + at] == MINE)
            to = 2 + 6 * elements + FORCE_COLUMNS * (2 * p + end)
            path[row, to + T_FX] += n * nx + t * nz
            path[row, to + T_FZ] += n * nz - t * nx
            path[row, to + T_LOAD] += n
            path[row, to + T_LOAD_X] += n * (a[X + j] + rx)
            path[row, to + T_LOAD_Z] += n * (a[Z + j] + rz)


@njit(**OPTIONS)
def step(state: Any, scheme: int, layout: Any, sizes: Any, shapes: Any, variant: Any, gravity: float) -> None:
    """One step of all columns."""
    own = state[: OWN * COLUMNS]
    shake(own)
    elements = sizes.size
    for p in range(layout.shape[0]):
        first, second = layout[p, 0], layout[p, 1]
        q, a, b = pair_rows(state, elements, p), element_rows(state, first), element_rows(state, second)
        flags = count_motion(q, a, b)
        if flags >= 1024:
            for j in range(COLUMNS):
                if q[USED + j] >= q[LIMIT + j]:
                    search(
                        q, a, b, own, j, sizes[first], sizes[second], shapes[variant[j], first],
                        shapes[variant[j], second],
                    )  # fmt: skip
            flags = 0
            for j in range(COLUMNS):
                flags += 1 if q[USED + j] >= q[REACH + j] else 0
        if flags > 0:
            if scheme == CENTRED:
                contact_centred(q, a, b, own)
            else:
                contact_cundall(q, a, b, own)
    for e in range(elements):
        body = element_rows(state, e)
        # Free or held; a driven one rests in the frame of the base.
        if body[FRAME] != 0.0:
            advance(body, own, gravity)
    for j in range(COLUMNS):
        own[TICK + j] = own[TICK + j] + 1.0


@njit(nogil=True, **OPTIONS)
def run_queue(
    scheme: int, queue: Any, cases: Any, row_of_case: Any, variant_of_case: Any, initial: Any, layout: Any, sizes: Any, shapes: Any,
    rules: Any, limits: Any, ground: Any, upward: Any, samples: int, interval: float, steps: int, gravity: float,
    budget: int, counter: Any, path: Any, results: Any, each: Any,
) -> int:  # fmt: skip
    """Run the cases of a queue, all with the same number of steps per sample; a finished column takes the next one.

    Parameters
    ----------
    scheme : int
        A `overturning.dem.time_step.Scheme`.
    queue : ndarray of int64, shape (m,)
        Rows of `cases` to run, in this order.
    cases : ndarray, shape (n, PARAMETERS)
        The case table.
    row_of_case, variant_of_case : ndarray of int64, shape (n,)
        Row of `ground` that shakes each case, and its variant of the scene.
    initial : ndarray, shape (variants, rows)
        A column at rest.
    layout : ndarray of int64, shape (pairs, 2)
        The two elements of each pair.
    sizes : ndarray of int64, shape (elements,)
        Number of vertices of each element.
    shapes : ndarray, shape (variants, elements, vertices, 9)
        Faces: both ends, normal, distance, middle, half length.
    rules, limits : ndarray, shape (variants, elements, RULES), (variants, LIMITS)
        When an element has fallen, when a case has failed or rests.
    ground : ndarray, shape (azimuths, samples + 3)
        Acceleration of the base towards the azimuth, m/s², padded with zeros.
    upward : ndarray, shape (samples + 3,) or (0,)
        Upward acceleration, m/s².
    samples, interval, steps : int, float, int
        Length of the record, time between samples (s), steps per sample.
    gravity : float
        m/s².
    budget : int
        Largest number of steps of one case.
    counter : ndarray of int64, shape (1,)
        Grows by the element steps done; for progress.
    path : ndarray, shape (rows, 2 + 6 elements) or (rows, 2 + 6 elements + 10 pairs)
        Zeros, filled with the first column's state at each sample and, where there is room, the forces at both ends of
        each pair; no rows to leave out.
    results, each : ndarray, shape (n, RESULTS), (n, elements, ELEMENT_RESULTS)
        Filled in the rows of the queue.

    Returns
    -------
    int
        Rows of `path` that were filled.
    """
    rows, elements = initial.shape[1], sizes.size
    owner = np.zeros(rows * COLUMNS)
    state: Any = borrowed(owner)  # type: ignore[call-arg]
    case, row = np.zeros(COLUMNS, np.int64), np.zeros(COLUMNS, np.int64)
    variant, done = np.zeros(COLUMNS, np.int64), np.zeros(COLUMNS, np.int64)
    free = 0
    for e in range(elements):
        free += 1 if rules[0, e, IS_FREE] > 0.0 else 0
    # Not literals: for those Numba would compile everything that they go into once more.
    active, head, noted, filled = np.int64(0), np.int64(0), np.int64(0), np.int64(0)
    stride = max(int(LOOK / interval), 1)
    with_forces = path.shape[0] > 0 and path.shape[1] > 2 + 6 * elements
    while True:
        while active < COLUMNS and head < queue.size:
            c = queue[head]
            case[active], row[active], variant[active], done[active] = c, row_of_case[c], variant_of_case[c], 0
            start(
                state, active, cases[c], initial[variant[active]], layout, sizes, shapes[variant[active]], interval,
                steps, gravity,
            )  # fmt: skip
            active, head = active + 1, head + 1
        if active == 0:
            owner[0] = noted  # held until here
            return noted
        # Columns that never held a case repeat the first, so that nothing undefined is computed beside the others.
        filled = max(filled, active)
        while filled < COLUMNS:
            row[filled], variant[filled] = row[0], variant[0]
            for r in range(rows):
                state[r * COLUMNS + filled] = state[r * COLUMNS]
            filled += 1
        next_sample(state, elements, row, ground, upward, steps)
        if noted < path.shape[0]:
            note(state, 0, elements, interval, path[noted])
            noted += 1
        for _ in range(steps):
            step(state, scheme, layout, sizes, shapes, variant, gravity)
            if with_forces and noted > 0:
                # By its row: a slice of the path would be counted, in a locked instruction that every step would pay.
                note_forces(state, 0, layout, elements, 1.0 / steps, path, noted - 1)
        end_sample(state, elements, rules[0], steps, interval)
        counter[0] += active * steps * free
        for j in range(active - 1, -1, -1):
            done[j] += steps
            if int(state[SAMPLE + j]) % stride != 0 and done[j] < budget:
                continue
            scene = variant[j]
            ended = verdict(state, j, layout, elements, rules[scene], limits[scene], float(samples), gravity)
            if ended < 0 and done[j] >= budget:
                ended = 5
            if ended < 0:
                continue
            finish(
                state, j, layout, elements, limits[scene], ended, done[j], gravity, results[case[j]],
                each[case[j]],
            )  # fmt: skip
            # The last column, already looked at, moves into the free place.
            active -= 1
            case[j], row[j], variant[j], done[j] = case[active], row[active], variant[active], done[active]
            for r in range(rows):
                state[r * COLUMNS + j] = state[r * COLUMNS + active]


keep_compiled(run_queue)
