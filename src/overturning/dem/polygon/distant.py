"""Sleeping pairs: pairs too far apart to touch soon are skipped until their elements have moved far enough.

Any two of n elements can meet, but a stone in a stack touches only two others. A pair sleeps as long as the sum over
all steps of the largest motion of any element is too small to bring it into contact. While it sleeps, each element adds
up its own motion; the pair gets these sums when it wakes, so that its nearest faces are searched in the same step as if
it had never slept.
"""

from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit

from overturning.dem.kernel.lanes import APART, INNER, OWNER
from overturning.dem.kernel.mechanics import larger
from overturning.dem.polygon import rows
from overturning.dem.polygon.state import Travel

AWAKE: Final = -1.0
"""Value of `Pairs.wakes` for a pair that is awake."""


class ActivePairs(NamedTuple):
    """Pairs that are awake, and the motion at which the others wake."""

    awake: Any
    """Indices of the awake pairs, ascending, shape (pairs,); the first `count` are valid."""
    near: Any
    """True for a pair that could touch in this step, shape (pairs,)."""
    wakes: Any
    """Sum of motions at which each pair wakes (m), or `AWAKE`, shape (pairs,)."""
    count: Any
    """Number of awake pairs, shape (1,)."""
    travel: Any
    """Largest sum of motions of two elements so far (m), sum at which the next pair wakes (m), and longest lever arm of
    a sleeping pair (m), shape (3,)."""
    largest: Any
    """Largest motion (m) and rotation (rad) of any element in the last step, then the same as predicted for this step;
    four rows with a column per case, shape (4 columns,)."""


TRAVEL, NEXT, LEVER = 0, 1, 2


@njit(**OWNER)
def all_awake(count: int) -> Any:
    """Return the state in which all `count` pairs are awake."""
    travel = np.zeros(3)
    travel[NEXT] = np.inf
    number = np.zeros(1, np.int64)
    number[0] = count
    return ActivePairs(
        np.arange(count), np.zeros(count, np.bool_), np.full(count, AWAKE), number, travel, np.zeros(4 * rows.COLUMNS)
    )


@njit(**APART)
def update_largest_motion(e: Any, largest: Any) -> None:
    """Update the largest motions of any element with those of element `e`."""
    for j in range(rows.COLUMNS):
        item = rows.load_element(e, j)
        largest[j] = larger(largest[j], item.totals.moved)
        largest[rows.COLUMNS + j] = larger(largest[rows.COLUMNS + j], item.totals.turned)
        largest[2 * rows.COLUMNS + j] = larger(largest[2 * rows.COLUMNS + j], item.trial.moved)
        largest[3 * rows.COLUMNS + j] = larger(largest[3 * rows.COLUMNS + j], item.trial.turned)


@njit(**APART)
def add_travel(e: Any) -> None:
    """Add the motion of an element in the last step to the sum of its motions."""
    for j in range(rows.COLUMNS):
        item = rows.load_element(e, j)
        rows.store_travel(e, j, Travel(item.travel.moved + item.totals.moved, item.travel.turned + item.totals.turned))


@njit(**APART)
def fall_asleep(q: Any, a: Any, b: Any) -> None:
    """Subtract the summed motions of both elements from the motion of the pair, which falls asleep."""
    for j in range(rows.COLUMNS):
        lever, on, by = rows.load_nearest(q, j).lever, rows.load_element(a, j).travel, rows.load_element(b, j).travel
        q[rows.USED + j] = q[rows.USED + j] - ((on.moved + by.moved) + lever * (on.turned + by.turned))


@njit(**APART)
def wake_up(q: Any, a: Any, b: Any) -> None:
    """Add the summed motions of both elements to the motion of the pair, which wakes."""
    for j in range(rows.COLUMNS):
        lever, on, by = rows.load_nearest(q, j).lever, rows.load_element(a, j).travel, rows.load_element(b, j).travel
        q[rows.USED + j] = q[rows.USED + j] + ((on.moved + by.moved) + lever * (on.turned + by.turned))


@njit(**INNER)
def motion_to_contact(q: Any) -> tuple[float, float]:
    """Return the motion before a pair could touch in any case, m, and its longest lever arm, m; 0, 0 if it is close."""
    slack, lever = np.inf, 0.0
    for j in range(rows.COLUMNS):
        reach, ahead = q[rows.REACH + j], q[rows.AHEAD + j]
        # Written so that NaN keeps the pair awake.
        if not ahead < 0.5 * reach:
            return 0.0, 0.0
        slack, lever = min(slack, reach - ahead), max(lever, q[rows.PAIR_LEVER + j])
    return slack, lever


@njit(**INNER)
def wake(state: Any, scene: Any, pairs: ActivePairs, travel: float) -> None:
    """Wake the pairs that could touch after a sum of motions `travel` (m); infinity wakes all."""
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
def begin_step(state: Any, scene: Any, pairs: ActivePairs, size: int) -> None:
    """Wake the pairs that could touch in this step by its predicted motion; add up the motion of the last step."""
    if pairs.count[0] == pairs.wakes.size:
        return
    largest, lever = pairs.largest, pairs.travel[LEVER]
    for k in range(largest.size):
        largest[k] = 0.0
    for i in range(size):
        update_largest_motion(rows.of_element(state, i), largest)
    last, ahead = 0.0, 0.0
    for j in range(rows.COLUMNS):
        moved, turned = largest[j], largest[rows.COLUMNS + j]
        far, turn = largest[2 * rows.COLUMNS + j], largest[3 * rows.COLUMNS + j]
        last, ahead = max(last, moved + lever * turned), max(ahead, far + lever * turn)
    # Factor 2: both elements of a pair may move. Predicted motion counts twice, as in `search.count_motion`.
    pairs.travel[TRAVEL] += 2.0 * last
    travel = pairs.travel[TRAVEL] + 4.0 * ahead
    if not travel < pairs.travel[NEXT]:
        wake(state, scene, pairs, travel)
    for i in range(size):
        add_travel(rows.of_element(state, i))


@njit(**INNER)
def stays_awake(q: Any, a: Any, b: Any, p: int, pairs: ActivePairs) -> bool:
    """Put a pair to sleep if it is out of reach; return True if it stays awake."""
    slack, lever = motion_to_contact(q)
    if slack <= 0.0:
        return True
    fall_asleep(q, a, b)
    pairs.wakes[p] = pairs.travel[TRAVEL] + (1.0 - 1e-9) * slack
    pairs.travel[NEXT] = min(pairs.travel[NEXT], pairs.wakes[p])
    pairs.travel[LEVER] = max(pairs.travel[LEVER], lever)
    return False
