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
from overturning.dem.lanes import OPTIONS, aligned
from overturning.dem.mechanics import line, renormalised
from overturning.dem.polygon import columns as c
from overturning.dem.polygon import tables as t
from overturning.dem.polygon.advance import advance
from overturning.dem.polygon.centred import contact_centred
from overturning.dem.polygon.columns import COLUMNS, Case, Law, Pose, Shaking, element_rows, pair_rows
from overturning.dem.polygon.cundall import contact_cundall
from overturning.dem.polygon.energy import energy, springs
from overturning.dem.polygon.memory import end_place, load_at_rest
from overturning.dem.polygon.search import count_motion, search
from overturning.dem.polygon.verdict import GOING_ON, finish, note_slip, note_upright, verdict
from overturning.dem.status import Status
from overturning.dem.time_step import Scheme

LOOK: Final = 0.1
"""A case is looked at after each so many seconds of its record, or each sample where that is longer."""


@njit(**OPTIONS)
def start(
    state: Any, j: int, case: Any, initial: Any, layout: Any, sizes: Any, shapes: Any, interval: float, steps: int, gravity: float
) -> None:
    """Put a case into column j: the scene's column at rest, its own friction, damping and amplitude."""
    for row in range(initial.size):
        state[row * COLUMNS + j] = initial[row]
    step, still = interval / steps, Shaking(0.0, 0.0, 0.0, 0.0, 0.0)
    now, calm, after = case[t.P_FIRST], case[t.P_CALM], case[t.P_AFTER]
    c.store_case(state, j, Case(still, step, steps / interval, case[t.P_AMPLITUDE], now, calm, after, 0.0))
    for e in range(sizes.size):
        rows = element_rows(state, e)
        rows[c.UPRIGHT_UNTIL + j] = case[t.P_FIRST] * interval
        rows[c.SAFE_FROM + j] = case[t.PARAMETERS + e]
    for p in range(layout.shape[0]):
        i, k = layout[p, 0], layout[p, 1]
        q, a, b = pair_rows(state, sizes.size, p), element_rows(state, i), element_rows(state, k)
        pair = c.load_pair(q, j)
        law, settled = pair.law, pair.nearest.limit == np.inf
        friction = law.friction if law.friction >= 0.0 else case[t.P_FRICTION]
        dashpot = law.dashpot * case[t.P_DAMPING]
        c.store_law(q, j, Law(law.normal, law.tangential, dashpot, friction, law.compliance))
        search(q, a, b, j, step, shapes[i, : sizes[i]], shapes[k, : sizes[k]])
        if settled:
            q[c.LIMIT + j], q[c.REACH + j] = np.inf, -1.0
        load_at_rest(q, a, b, j)
        q[c.TAKEN + j] = springs(c.load_pair(q, j))
    state[c.ENERGY + j] = energy(state, j, layout, sizes.size, gravity)


@njit(**OPTIONS)
def next_sample(state: Any, elements: int, row: Any, ground: Any, upward: Any, steps: int) -> None:
    """Bring the turning pairs back to length 1 and load the ground motion of each column's sample."""
    for e in range(elements):
        rows = element_rows(state, e)
        for j in range(COLUMNS):
            pose = c.load_pose(rows, j)
            cos, sin = renormalised(pose.cos, pose.sin)
            c.store_pose(rows, j, Pose(pose.x, pose.z, pose.angle, cos, sin))
    scale, last = 1.0 / steps, ground.shape[1] - 3
    for j in range(COLUMNS):
        case = c.load_case(state, j)
        i, factor = min(int(case.sample), last), case.amplitude
        base, slope = line(ground[row[j], i] * factor, ground[row[j], i + 1] * factor, scale)
        up_base, up_slope = 0.0, 0.0
        if upward.size > 0:
            up_base, up_slope = line(upward[i] * factor, upward[i + 1] * factor, scale)
        c.store_shaking(state, j, Shaking(base, slope, up_base, up_slope, 0.0))


@njit(**OPTIONS)
def end_sample(state: Any, elements: int, rules: Any, steps: int, interval: float) -> None:
    """Each element's slip, and the last time at which a standing one's rotation was below the critical angle."""
    for e in range(elements):
        if rules[e, t.IS_FREE] > 0.0:
            rows = element_rows(state, e)
            note_slip(rows, element_rows(state, int(rules[e, t.SUPPORT])))
            note_upright(rows, state, 1.0 / steps, interval)
    for j in range(COLUMNS):
        state[c.SAMPLE + j] = state[c.SAMPLE + j] + 1.0


@njit(**OPTIONS)
def note(state: Any, j: int, elements: int, interval: float, path: Any) -> None:
    """Write a column's state into a row of its trajectory, velocities brought to the whole step."""
    case = c.load_case(state, j)
    path[t.T_TIME] = case.sample * interval
    path[t.T_GROUND] = case.shaking.base
    half = 0.5 * case.step
    for e in range(elements):
        item = c.load_element(element_rows(state, e), j)
        pose, v, a = item.pose, item.velocity, item.acceleration
        to = 2 + 6 * e
        path[to + t.T_X], path[to + t.T_Z], path[to + t.T_ANGLE] = pose.x, pose.z, pose.angle
        path[to + t.T_VX], path[to + t.T_VZ] = v.x + half * a.x, v.z + half * a.z
        path[to + t.T_VW] = v.w + half * a.w


@njit(**OPTIONS)
def note_forces(state: Any, j: int, layout: Any, elements: int, share: float, path: Any, row: int) -> None:
    """Add a step's share of a column's contact forces to the row of its trajectory, with the places where they act."""
    for p in range(layout.shape[0]):
        pair = c.load_pair(pair_rows(state, elements, p), j)
        a, b = c.load_pose(element_rows(state, layout[p, 0]), j), c.load_pose(element_rows(state, layout[p, 1]), j)
        for end in range(2):
            memory = pair.one if end == 0 else pair.two
            if memory.carrier == c.OPEN:
                continue
            n, tangent = share * memory.normal, share * memory.tangent
            rx, rz, nx, nz = end_place(pair, a, b, end, memory.carrier == c.MINE)
            to = 2 + 6 * elements + t.FORCE_COLUMNS * (2 * p + end)
            path[row, to + t.T_FX] += n * nx + tangent * nz
            path[row, to + t.T_FZ] += n * nz - tangent * nx
            path[row, to + t.T_LOAD] += n
            path[row, to + t.T_LOAD_X] += n * (a.x + rx)
            path[row, to + t.T_LOAD_Z] += n * (a.z + rz)


@njit(**OPTIONS)
def step(state: Any, scheme: int, layout: Any, sizes: Any, shapes: Any, variant: Any, gravity: float) -> None:
    """One step of all columns."""
    for p in range(layout.shape[0]):
        i, k = layout[p, 0], layout[p, 1]
        q, a, b = pair_rows(state, sizes.size, p), element_rows(state, i), element_rows(state, k)
        near, due = count_motion(q, a, b)
        if due > 0:
            near = 0
            for j in range(COLUMNS):
                if q[c.USED + j] >= q[c.LIMIT + j]:
                    v, dt = variant[j], c.load_case(state, j).step
                    search(q, a, b, j, dt, shapes[v, i, : sizes[i]], shapes[v, k, : sizes[k]])
                near += 1 if q[c.USED + j] >= q[c.REACH + j] else 0
        if near > 0:
            if scheme == Scheme.CENTRED:
                contact_centred(q, a, b, state)
            else:
                contact_cundall(q, a, b, state)
    for e in range(sizes.size):
        rows = element_rows(state, e)
        # Free or held; a driven one rests in the frame of the base.
        if c.load_element(rows, 0).body.frame != 0.0:
            advance(rows, state, gravity)
    for j in range(COLUMNS):
        state[c.TICK + j] = state[c.TICK + j] + 1.0


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
    owner = aligned(rows * COLUMNS)
    state: Any = c.borrowed(owner)  # type: ignore[call-arg]
    case, row = np.zeros(COLUMNS, np.int64), np.zeros(COLUMNS, np.int64)
    variant, done = np.zeros(COLUMNS, np.int64), np.zeros(COLUMNS, np.int64)
    free = 0
    for e in range(elements):
        free += 1 if rules[0, e, t.IS_FREE] > 0.0 else 0
    # Not literals: for those Numba would compile everything that they go into once more.
    active, head, noted, filled = np.int64(0), np.int64(0), np.int64(0), np.int64(0)
    stride = max(int(LOOK / interval), 1)
    with_forces = path.shape[0] > 0 and path.shape[1] > 2 + 6 * elements
    while True:
        while active < COLUMNS and head < queue.size:
            number = queue[head]
            case[active], row[active] = number, row_of_case[number]
            variant[active], done[active] = variant_of_case[number], 0
            start(
                state, active, cases[number], initial[variant[active]], layout, sizes, shapes[variant[active]], interval,
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
            if int(state[c.SAMPLE + j]) % stride != 0 and done[j] < budget:
                continue
            scene = variant[j]
            ended = verdict(state, j, layout, elements, rules[scene], limits[scene], float(samples), gravity)
            if ended == GOING_ON and done[j] >= budget:
                ended = Status.OVER_BUDGET
            if ended == GOING_ON:
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
