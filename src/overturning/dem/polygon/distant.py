"""Pairs too far apart to touch soon: no step looks at them until the elements have moved so far that they could.

Of n elements each two can meet, but a stone of a stack touches two others. A pair sleeps while even the largest motion
of any element in each step, added up, leaves it out of reach. Until then the motion that it counts is added up by its
elements, so that its nearest faces are searched in the same step as if it had never slept.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit

from overturning.dem.kernel.lanes import APART, INNER, OWNER
from overturning.dem.kernel.mechanics import larger
from overturning.dem.polygon import rows
from overturning.dem.polygon.state import Travel

AWAKE: Final = -1.0
"""In place of the travel at which a pair wakes: it is awake."""


class Pairs(NamedTuple):
    """Which pairs a step looks at."""

    awake: Any
    """Numbers of the pairs that are awake, ascending, shape (pairs,)."""
    near: Any
    """True where a pair could touch in this step, shape (pairs,)."""
    wakes: Any
    """Travel at which each pair wakes, m, or `AWAKE`, shape (pairs,)."""
    count: Any
    """Number of pairs that are awake, shape (1,)."""
    travel: Any
    """Largest sum of motions of two elements so far (m), travel at which the next pair wakes (m), and longest lever of
    a pair that sleeps (m), shape (3,)."""
    largest: Any
    """Largest motion (m) and rotation (rad) of any element in the last step, and in this one as predicted, a row each,
    shape (4 columns,)."""


TRAVEL, NEXT, LEVER = 0, 1, 2


@njit(**OWNER)
def all_awake(count: int) -> Any:
    """All pairs, awake."""
    travel = np.zeros(3)
    travel[NEXT] = np.inf
    number = np.zeros(1, np.int64)
    number[0] = count
    return Pairs(
        np.arange(count), np.zeros(count, np.bool_), np.full(count, AWAKE), number, travel, np.zeros(4 * rows.COLUMNS)
    )


@njit(**APART)
def note_largest(e: Any, largest: Any) -> None:
    """Raise the largest motions to those of an element."""
    for j in range(rows.COLUMNS):
        item = rows.load_element(e, j)
        largest[j] = larger(largest[j], item.course.moved)
        largest[rows.COLUMNS + j] = larger(largest[rows.COLUMNS + j], item.course.turned)
        largest[2 * rows.COLUMNS + j] = larger(largest[2 * rows.COLUMNS + j], item.trial.moved)
        largest[3 * rows.COLUMNS + j] = larger(largest[3 * rows.COLUMNS + j], item.trial.turned)


@njit(**APART)
def add_travel(e: Any) -> None:
    """Add an element's motion in the last step to all of its motion."""
    for j in range(rows.COLUMNS):
        item = rows.load_element(e, j)
        rows.store_travel(e, j, Travel(item.travel.moved + item.course.moved, item.travel.turned + item.course.turned))


@njit(**APART)
def fall_asleep(q: Any, a: Any, b: Any) -> None:
    """Take what the elements of a pair have moved off the motion that it counts."""
    for j in range(rows.COLUMNS):
        lever, on, by = rows.load_nearest(q, j).lever, rows.load_element(a, j).travel, rows.load_element(b, j).travel
        q[rows.USED + j] = q[rows.USED + j] - ((on.moved + by.moved) + lever * (on.turned + by.turned))


@njit(**APART)
def wake_up(q: Any, a: Any, b: Any) -> None:
    """Add what the elements of a pair have moved to the motion that it counts."""
    for j in range(rows.COLUMNS):
        lever, on, by = rows.load_nearest(q, j).lever, rows.load_element(a, j).travel, rows.load_element(b, j).travel
        q[rows.USED + j] = q[rows.USED + j] + ((on.moved + by.moved) + lever * (on.turned + by.turned))


@njit(**INNER)
def slack_of(q: Any) -> tuple[float, float]:
    """Motion before a pair could touch in any column, m, and its longest lever, m; 0 where it is near that."""
    slack, lever = np.inf, 0.0
    for j in range(rows.COLUMNS):
        reach, ahead = q[rows.REACH + j], q[rows.AHEAD + j]
        # What is not a number keeps it awake.
        if not ahead < 0.5 * reach:
            return 0.0, 0.0
        slack, lever = min(slack, reach - ahead), max(lever, q[rows.PAIR_LEVER + j])
    return slack, lever


@njit(**INNER)
def wake(state: Any, scene: Any, pairs: Pairs, travel: float) -> None:
    """Wake the pairs that could touch after a `travel`, m; all where that is infinite."""
    count, following = 0, np.inf
    for p in range(pairs.wakes.size):
        at = pairs.wakes[p]
        if at != AWAKE and not travel < at:
            q, a, b = rows.of_pair(state, scene, p)
            wake_up(q, a, b)
            pairs.wakes[p] = at = AWAKE
        if at == AWAKE:
            pairs.awake[count] = p
            count += 1
        else:
            following = min(following, at)
    pairs.count[0], pairs.travel[NEXT] = count, following
    if count == pairs.wakes.size:
        pairs.travel[TRAVEL] = pairs.travel[LEVER] = 0.0


@njit(**INNER)
def begin_step(state: Any, scene: Any, pairs: Pairs, size: int) -> None:
    """Wake the pairs that could touch in this step, whose motion is predicted; add up the motion of the last step."""
    if pairs.count[0] == pairs.wakes.size:
        return
    largest, lever = pairs.largest, pairs.travel[LEVER]
    for k in range(largest.size):
        largest[k] = 0.0
    for i in range(size):
        note_largest(rows.of_element(state, i), largest)
    last, ahead = 0.0, 0.0
    for j in range(rows.COLUMNS):
        moved, turned = largest[j], largest[rows.COLUMNS + j]
        far, turn = largest[2 * rows.COLUMNS + j], largest[3 * rows.COLUMNS + j]
        last, ahead = max(last, moved + lever * turned), max(ahead, far + lever * turn)
    # Both elements of a pair may move, and what is predicted counts twice, as in `search.count_motion`.
    pairs.travel[TRAVEL] += 2.0 * last
    travel = pairs.travel[TRAVEL] + 4.0 * ahead
    if not travel < pairs.travel[NEXT]:
        wake(state, scene, pairs, travel)
    for i in range(size):
        add_travel(rows.of_element(state, i))


@njit(**INNER)
def stays_awake(q: Any, a: Any, b: Any, p: int, pairs: Pairs) -> bool:
    """False if a pair out of reach falls asleep."""
    slack, lever = slack_of(q)
    if slack <= 0.0:
        return True
    fall_asleep(q, a, b)
    pairs.wakes[p] = pairs.travel[TRAVEL] + (1.0 - 1e-9) * slack
    pairs.travel[NEXT] = min(pairs.travel[NEXT], pairs.wakes[p])
    pairs.travel[LEVER] = max(pairs.travel[LEVER], lever)
    return False
