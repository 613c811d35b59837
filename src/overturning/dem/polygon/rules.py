"""What the queue asks of a scene of polygons: its rules, how a case begins, how a sample goes, how a case ends.

Signs: x points to the azimuth, z up, rotation is positive clockwise (towards the azimuth). The point (p, q) of an
element is at ``(x + c p + s q, z − s p + c q)`` with c, s the cosine and sine of its rotation; a force (X, Z) at the
place (p', q') from the centre has the moment ``q' X − p' Z``. The tangent of a face with outward normal n is
``(−n_z, n_x)``; an end's force is ``f_n n + f_t (n_z, −n_x)`` on the pair's first element.

docs/scenes.md derives the rules, `overturning.dem.polygon.rows` says what is known of a case. A scheme is one file,
with a named tuple of its constants and its `step`, and one row of `SCHEMES` and `STEPS`.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.kernel.clock import Attempt, Clock
from overturning.dem.kernel.ground import Ground, Line, cannot_move, is_looked_at, piece, samples_at_rest
from overturning.dem.kernel.lanes import APART, INLINE, INNER, aligned, borrowed
from overturning.dem.kernel.mechanics import renormalised
from overturning.dem.kernel.queue import Job, by_type, implement
from overturning.dem.polygon import cundall, rows, step
from overturning.dem.polygon.arrays import Arrays
from overturning.dem.polygon.distant import all_awake, wake
from overturning.dem.polygon.energy import energy, springs
from overturning.dem.polygon.equations import SIZE, SPARE, pattern_of
from overturning.dem.polygon.memory import load_at_rest
from overturning.dem.polygon.path import POSE_COLUMNS, note, note_forces
from overturning.dem.polygon.resting import rests
from overturning.dem.polygon.search import search
from overturning.dem.polygon.state import Case, Law, Pose, Shaking, Verdict
from overturning.dem.polygon.verdict import move_home, note_carried, note_standing, verdict, write_results
from overturning.dem.time_step import Scheme

SCHEMES: Final[dict[Scheme, Any]] = {Scheme.CUNDALL: cundall.Cundall(), Scheme.CENTRED: step.Centred()}
"""Constants of each scheme, whose type picks its step."""

STEPS: Final = {cundall.Cundall: cundall.step, step.Centred: step.step}

LOOK: Final = 0.1
"""A case is looked at after each so many seconds of its record, or each sample where that is longer."""


class SceneRules(NamedTuple):
    """Rules of cases of a scene, all with the same steps per sample."""

    job: Job
    cases: NDArray[np.void]
    """Table of `arrays.CASE`;"""
    row: NDArray[np.int64]
    results: NDArray[np.void]
    """table of `arrays.RESULT`;"""
    ground: Ground
    scheme: Any
    """constants of the scheme, from `SCHEMES`;"""
    stands_from: FloatArray
    """sample from which on each part that can move as one stands for good, shape (cases, parts);"""
    variant: NDArray[np.int64]
    """variant of the scene that each case is of;"""
    scene: Arrays
    each: NDArray[np.void]
    """table to fill beside the results, of `arrays.ELEMENT_RESULT`, shape (cases, elements)."""


class Work(NamedTuple):
    """What scenes are computed in."""

    state: Any
    """Rows of all lanes; a borrowed view of"""
    owner: Any
    """the array that holds them;"""
    matrix: Any
    """submatrices of the equations,"""
    pattern: Any
    """which of them are used;"""
    pairs: Any
    """which pairs are looked at;"""
    moves: Any
    """which elements move."""


step_of = by_type(STEPS)
"""The step of a scheme, by the type of its constants."""


def workspace(rules: Any) -> Any:
    """Rows of all lanes, and what the equations are solved in."""
    elements, pairs, initial = rules.scene.elements.shape[1], rules.scene.layout.shape[0], rules.scene.initial
    owner = aligned(initial.shape[1] * rows.COLUMNS)
    moves = np.zeros(elements, np.bool_)
    for i in range(elements):
        moves[i] = initial[0, (rows.CASE_SIZE + i * rows.ELEMENT_SIZE + rows.FRAME) // rows.COLUMNS] != 0.0
    matrix = aligned((elements * elements + SPARE) * SIZE)
    return Work(borrowed(owner), owner, matrix, pattern_of(elements), all_awake(pairs), moves)


@njit(**INLINE)
def lent(scene: Any) -> Any:
    """The arrays of a scene, all borrowed, for the steps."""
    layout, parts, sizes = borrowed(scene.layout), borrowed(scene.parts), borrowed(scene.sizes)
    shapes, elements, limits = borrowed(scene.shapes), borrowed(scene.elements), borrowed(scene.limits)
    return Arrays(borrowed(scene.initial), layout, parts, sizes, shapes, elements, limits, scene.gravity)


def start(rules: Any, work: Any, lane: int, case: int) -> None:
    """Put a case into a lane: the scene at rest, with its own friction, damping and amplitude."""
    state, scene, given, v = work.state, rules.scene, rules.cases[case], rules.variant[case]
    ticks, interval = rules.job.ticks, rules.job.interval
    wake(state, scene, work.pairs, np.inf)
    for row in range(scene.initial.shape[1]):
        state[row * rows.COLUMNS + lane] = scene.initial[v, row]
    begin(state, lane, given, float(v), interval, ticks, rules.scheme.lag)
    for i in range(scene.elements.shape[1]):
        e = rows.of_element(state, i)
        e[rows.UPRIGHT_UNTIL + lane] = e[rows.CARRIED_UNTIL + lane] = given.first * interval
    touch(state, lane, given, scene, scene.shapes[v])
    state[rows.ENERGY + lane] = energy(state, lane, scene)


@njit(**INNER)
def begin(state: Any, j: int, case: Any, variant: float, interval: float, ticks: float, lag: float) -> None:
    """Put the constants of a case into lane j."""
    step, none, looked = interval / ticks, Line(0.0, 0.0, 0.0), case.first // max(int(LOOK / interval), 1)
    first = Attempt(case.finest, case.dwell, 0.0)
    clock = Clock(case.finest, case.standing, case.dwell, case.settled)
    rows.store_case(state, j, Case(
        Shaking(none, none, 0.0), step, ticks / interval, lag * step, clock, first, rows.no_marks(),
        Verdict(0.0, 0.0, Attempt(0.0, 0.0, 0.0)), case.amplitude, case.bears, case.first, case.calm, case.after, 0.0,
        variant, looked,
    ))  # fmt: skip


@njit(**INNER)
def touch(state: Any, j: int, case: Any, scene: Any, shapes: Any) -> None:
    """Give the pairs of lane j their laws, their nearest faces and the springs that are loaded at rest."""
    lag = rows.load_case(state, j).lag
    for p in range(scene.layout.shape[0]):
        q, a, b = rows.of_pair(state, scene, p)
        m, n, pair = scene.layout[p, 2], scene.layout[p, 3], rows.load_pair(q, j)
        law, settled = pair.law, pair.nearest.limit == np.inf
        friction = law.friction if law.friction >= 0.0 else case.friction
        dashpot = law.dashpot * case.damping
        rows.store_law(q, j, Law(law.normal, law.tangential, dashpot, friction, law.compliance))
        search(q, a, b, j, 2.0 * lag, shapes[m, : scene.sizes[m]], shapes[n, : scene.sizes[n]])
        if settled:
            q[rows.LIMIT + j], q[rows.REACH + j] = np.inf, -1.0
        load_at_rest(q, j)
        q[rows.TAKEN + j] = springs(rows.load_pair(q, j))


def load(rules: Any, work: Any, cases: Any, columns: int) -> None:  # noqa: ARG001, all lanes are computed
    """Begin a sample: bring the turning pairs back to length 1 and load the ground motion of each lane's sample."""
    for i in range(work.moves.size):
        renormalise(rows.of_element(work.state, i))
    load_motion(rules.ground.up, work.state, rules.ground.along, rules.row, cases, 1.0 / rules.job.ticks)


@njit(**APART)
def renormalise(e: Any) -> None:
    """Bring the turning pairs of an element back to length 1."""
    for j in range(rows.COLUMNS):
        pose = rows.load_pose(e, j)
        rows.store_pose(e, j, Pose(pose.x, pose.z, pose.angle, *renormalised(pose.cos, pose.sin)))


@njit(**INNER)
def load_motion(up: Any, state: Any, along: Any, row: Any, cases: Any, scale: float) -> None:
    """Load the ground motion of each lane's sample; `up` is None where the base moves level."""
    last = along.shape[1] - 3
    for j in range(rows.COLUMNS):
        case = rows.load_case(state, j)
        i, factor = min(int(case.sample), last), case.amplitude
        rows.store_base(state, j, piece(along[row[cases[j]]], i, factor, scale))
        if up is not None:
            rows.store_up(state, j, piece(up, i, factor, scale))


def advance(rules: Any, work: Any, columns: int, path: Any, noted: int) -> tuple[Any, int]:  # noqa: ARG001
    """Compute the steps of a sample; the first lane is noted at its begin, with the forces that act until the next."""
    step = step_of(rules.scheme)
    scene, up, state, elements = lent(rules.scene), rules.ground.up, work.state, work.moves.size
    lag, interval, ticks, at_once = rules.scheme.lag, rules.job.interval, rules.job.ticks, rules.job.at_once
    # Borrowed, since each step would count their references.
    matrix, pattern, moves = borrowed(work.matrix), borrowed(work.pattern), borrowed(work.moves)
    pairs = borrowed(work.pairs)
    with_forces = path.shape[0] > 0 and path.shape[1] > 2 + POSE_COLUMNS * elements
    early = np.zeros((1, path.shape[1]))
    for _ in range(at_once):
        if path.shape[0] == 0:
            step(up, state, matrix, pattern, pairs, moves, scene, ticks)
            continue
        tick, share = state[rows.TICK], state[rows.LENGTH] / ticks
        # Once for each sample, also where its first step has to be done again.
        if (tick == 0.0 or tick == ticks) and not state[rows.AGAIN] > 0.0 and noted < path.shape[0]:
            note(state, elements, interval, ticks, path[noted])
            noted += 1
        # What the forces at the begin of the step do in it counts only if the step is taken.
        # By its row: a slice of the path would be counted, in a locked instruction that every step would pay.
        if with_forces:
            for column in range(early.shape[1]):  # a slice costs the compilation of its error message
                early[0, column] = 0.0
            note_forces(state, scene, (0.5 - lag) * share, early, early.shape[0] - 1)
        step(up, state, matrix, pattern, pairs, moves, scene, ticks)
        if with_forces and not state[rows.AGAIN] > 0.0:
            for column in range(early.shape[1]):
                path[noted - 1, column] += early[0, column]
            note_forces(state, scene, (0.5 + lag) * share, path, noted - 1)
    end_sample(state, scene, ticks, interval)
    return path, noted


@njit(**INNER)
def end_sample(state: Any, scene: Any, ticks: float, interval: float) -> None:
    """Each element's slip, and until when a standing one could come back and was on what carried it."""
    rules = scene.elements[0]
    for i in range(rules.size):
        if rules[i].rides >= 0.0 and rules[i].is_free > 0.0:
            move_home(rows.of_element(state, i), rows.of_element(state, int(rules[i].rides)))
    for i in range(rules.size):
        if rules[i].rides == i:
            move_home(rows.of_element(state, i), rows.of_element(state, i))
    for i in range(rules.size):
        if rules[i].is_free > 0.0:
            on = rows.of_element(state, int(rules[i].support))
            note_standing(rows.of_element(state, i), on, state, 1.0 / ticks, interval)
    for p in range(scene.layout.shape[0]):
        q, a, b = rows.of_pair(state, scene, p)
        note_carried(q, a, b, state, 1.0 / ticks, interval)
    for j in range(rows.COLUMNS):
        sample, tick = state[rows.SAMPLE + j], state[rows.TICK + j]
        state[rows.SAMPLE + j] = sample + 1.0 if tick >= ticks else sample
        state[rows.TICK + j] = tick - ticks if tick >= ticks else tick


def count_due(rules: Any, work: Any, active: int, due: Any) -> int:
    """Mark lanes that have come to the next part of their record."""
    stride, count = max(int(LOOK / rules.job.interval), 1), 0
    for j in range(active):
        part = work.state[rows.SAMPLE + j] // stride
        due[j] = 1.0 if part != work.state[rows.LOOKED + j] else 0.0
        work.state[rows.LOOKED + j] = part
        count += int(due[j])
    return count


def leave_out(rules: Any, work: Any, cases: Any, active: int, left_out: Any) -> None:
    """Leave out samples of lanes at rest."""
    state, ground, row, scene, ticks = work.state, rules.ground, rules.row, rules.scene, rules.scheme.ticks
    for j in range(active):
        case = rows.load_case(state, j)
        now = case.sample + case.shaking.tick * (1.0 / rules.job.ticks)
        long = case.attempt.length >= ticks and is_looked_at(now)
        # The shaking first, then the bodies, which take longer to look at.
        quiet = long and cannot_move(ground, row[cases[j]], now, case.amplitude, case.bears)
        if quiet and rests(state, j, scene):
            samples = samples_at_rest(ground, row[cases[j]], now, case.amplitude, case.bears)
            state[rows.SAMPLE + j] += samples
            left_out[j] += samples


def ended(rules: Any, work: Any, lane: int, case: int) -> int:
    """`Status` of a lane, or that it goes on."""
    return verdict(work.state, lane, rules.scene, rules.stands_from[case], float(rules.job.samples))


def finish(rules: Any, work: Any, lane: int, case: int, status: int) -> None:  # noqa: ARG001
    """Judge which elements of a lane have fallen, and write its results."""
    write_results(work.state, lane, rules.scene, rules.results[case], rules.each[case])


implement(SceneRules, workspace, start, load, advance, count_due, leave_out, ended, finish)
