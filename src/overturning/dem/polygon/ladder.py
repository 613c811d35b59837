"""How long each step of the centred scheme is: a ladder of lengths, each twice the one below, that a change of contact leads down."""

from typing import Any, Final

from numba import njit

from overturning.dem.lanes import INLINE, OPTIONS
from overturning.dem.mechanics import ONSET, TURN
from overturning.dem.polygon import rows
from overturning.dem.polygon.state import Attempt, Case, Found

MOST_HALVINGS: Final = 20
"""So often a step may be halved where a contact changes."""

TICKS: Final = 2**MOST_HALVINGS
"""Ticks of a whole step, the unit of a case's clock."""

FINEST: Final = 0.08
"""Longest step in which a contact may open or close, in 1/ω of the highest mode."""

DWELL: Final = 8.0
"""Steps of one length after a change of contact, before those of twice the length; more where the contact rings."""

FORESEEN: Final = 4.0
"""Up to so many finest steps the foreseen forces tell which ends press and slide."""

MOST_TRIES: Final = 2.0
"""A long step is done again so often with other ends taken to slide; then it is done in shorter ones."""

LONGEST_ROCKING: Final = 0.0125
"""Whole step in 1/p of the element that rocks fastest, p = √(3g/4R)."""

NO_FRACTION: Final = 2.0**52
"""A number that is added to this one and taken off again has lost its fraction."""

WHOLE: Final = float(TICKS)


@njit(**INLINE)
def next_attempt(case: Case, ticks: float) -> tuple[bool, Attempt]:
    """Whether the step has to be done again, and how the next one is to be taken.

    Unless it is the finest, a step in which a contact changes is not taken; one of half the length follows. After `dwell` steps
    of a length come those of twice the length, at a tick that is a multiple of it: so every step lies within a sample, over which
    the shaking is linear. A long step took each end to slide or to stick. Where that proves wrong it is done again as was found,
    at most `MOST_TRIES` times, then in shorter ones; so is one in which a sliding end has turned round, and one above `TURN` of a
    sample of `ticks` in which friction has changed its sign. Above `ONSET` of a sample steps are only while each pair is held.
    """
    attempt, found, tick = case.attempt, case.found, case.shaking.tick + case.attempt.length
    length, changed = attempt.length, found.changed > 0.0
    late, finest = length <= FORESEEN * case.finest, length <= case.finest
    shorter = changed & (not finest)
    wrong = (found.wrong > 0.0) & (not (late | shorter))
    slides = found.slides > 0.0
    onset = slides & (length > ONSET * ticks)
    back = (found.back > 0.0) & (length > TURN * ticks)
    halved = (((found.reversed > 0.0) | back) & (not (late | shorter))) | (
        wrong & (onset | (attempt.tries >= MOST_TRIES))
    )
    retry = wrong & (not halved)
    shorter = shorter | halved
    twice = tick * (0.5 / length)
    fits = (twice + NO_FRACTION) - NO_FRACTION == twice
    longer = (attempt.left <= 1.0) & (length < WHOLE) & fits & (not (slides & (2.0 * length > ONSET * ticks)))
    then, dwell = (2.0 * length if longer else length), (case.dwell if longer else attempt.left - 1.0)
    then, dwell = (length if changed | retry else then), (case.dwell if changed else dwell)
    then, dwell = (0.5 * length if shorter else then), (2.0 if shorter else dwell)
    return shorter | retry, Attempt(then, attempt.left if retry else dwell, attempt.tries + 1.0 if retry else 0.0)


@njit(**OPTIONS)
def judge(own: Any, ticks: float) -> None:
    """Take the step of each column or not, and say how the next one is to be tried."""
    for j in range(rows.COLUMNS):
        case = rows.load_case(own, j)
        again, attempt = next_attempt(case, ticks)
        rows.store_then(own, j, attempt)
        own[rows.AGAIN + j] = 1.0 if again else 0.0


@njit(**OPTIONS)
def go_on(own: Any) -> None:
    """Let the clock of each column go on where its step is taken."""
    for j in range(rows.COLUMNS):
        case = rows.load_case(own, j)
        tick = case.shaking.tick
        own[rows.TICK + j] = tick if case.verdict.again > 0.0 else tick + case.attempt.length
        rows.store_attempt(own, j, case.verdict.then)


@njit(**OPTIONS)
def begin(own: Any) -> None:
    """Nothing has been found yet."""
    for j in range(rows.COLUMNS):
        rows.store_found(own, j, Found(0.0, 0.0, 0.0, 0.0, 0.0))
