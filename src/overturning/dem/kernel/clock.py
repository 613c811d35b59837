"""The clock of a case: how long its next step is, and whether the last one is accepted (docs/method.md, "The clock").

A whole step is as long as the motion allows. A step in which a contact would open or close is rejected and halved
until it is the finest one, which resolves the contact; after the change come some steps of each length before those of
twice the length. Lengths are in ticks. A longer step begins only at a multiple of its length: so each lies within a
sample, over which the shaking is linear.
"""

from typing import Final, NamedTuple

import numpy as np
from numba import njit

from overturning.arrays import FloatArray
from overturning.dem.kernel.lanes import INLINE
from overturning.dem.time_step import LONGEST_ROCKING


class Pace(NamedTuple):
    """Constants of a model's clock."""

    longest: float
    """Longest whole step, in 1/p, p = √(3g/4R) of what rocks fastest;"""
    finest: float
    """longest step in which a contact may open or close, in 1/ω of the highest mode of the contact;"""
    whole: float
    """ticks of a whole step, a power of two: so often it may be halved;"""
    fine: float
    """a step of up to so many finest ones is fine: there the predicted forces decide what is in contact and slides, in
    longer ones what was last found;"""
    tries: float
    """how often a longer step is done again where that proves wrong, before it is done in shorter ones;"""
    dwell: float
    """steps of one length after a change of contact, before those of twice the length; more where the contact rings;"""
    settled_above: float
    """steps longer than so many finest ones no longer resolve what the change has set off:"""
    settled: float
    """so many of each of these lengths, and of the length to which a step is shortened."""

    @property
    def halvings(self) -> int:
        """How often a whole step may be halved."""
        return int(self.whole).bit_length() - 1

    def dwell_of(self, square: FloatArray, rate: FloatArray) -> FloatArray:
        """Steps of a length after a change of contacts with ω² (1/s²) and twice the damping rate (1/s).

        More where one rings: where its damping ratio is below a half.
        """
        return np.asarray(self.dwell * np.clip(np.sqrt(square) / np.maximum(rate, 1e-300), 1.0, 8.0))


# Where measured: the rigid limit and the default step, docs/measurements.md; scenes, `python -m verification.scenes
# steps`; in space, `python -m verification.space`. A body in space takes shorter steps, since its deepest point runs
# round a rim.
BLOCK: Final = Pace(LONGEST_ROCKING, 0.08, 2.0**24, 4.0, 2.0, 8.0, 8.0, 2.0)
SCENE: Final = Pace(0.0125, 0.16, 2.0**20, 4.0, 2.0, 8.0, 8.0, 2.0)
BODY: Final = Pace(0.004, 0.1, 2.0**9, 2.0, 3.0, 8.0, 8.0, 4.0)

SLIDING: Final = 0.25
"""Longest step of what slides as a whole, in samples: within a longer one it could stop, or begin."""

ONSET: Final = 0.0625
"""Longest step in which a body begins to slide, in samples: it slides all through it."""

TURN: Final = 0.015625
"""Longest step in which friction changes its sign, in samples: half of it has the sign of before."""

NO_FRACTION: Final = 2.0**52
"""A positive number below it that is added to this one and taken off again has lost its fraction."""


class Clock(NamedTuple):
    """What the clock of a case goes by beside the constants of its model; lengths in ticks."""

    finest: float
    """Finest step,"""
    standing: float
    """and step of a body that stands, at least the whole one;"""
    dwell: float
    """steps of a length after a change of contact,"""
    settled: float
    """and of the longer ones of `Pace.settled_above`."""


class Attempt(NamedTuple):
    """How the next step is to be tried."""

    length: float
    """Its length in ticks;"""
    left: float
    """steps of this length until longer ones may be tried;"""
    tries: float
    """how often this step was done again with other points sliding."""


class Found(NamedTuple):
    """What an attempt has found."""

    changed: bool
    """Whether a contact opens or closes;"""
    fast: bool
    """whether the motion asks for a shorter step;"""
    gentle: bool
    """whether the step may be accepted all the same;"""
    wrong: bool
    """whether a point sticks or slides otherwise than taken,"""
    reversed: bool
    """whether one slides against its velocity: a slip reversal;"""
    back: bool
    """whether one slides that friction held the other way before, so that friction changes its sign within the step;"""
    slides: bool
    """whether all points that carry a body slide, so that nothing holds it;"""
    stands: bool
    """whether all contacts are closed at its end."""


@njit(**INLINE)
def next_attempt(
    pace: Pace, clock: Clock, tried: Attempt, found: Found, tick: float, ticks: float
) -> tuple[bool, bool, Attempt]:
    """Whether an attempt that would end at a tick is rejected, whether its points are taken as before, the next one.

    A body may begin to slide in a step of up to `ONSET` of a sample, which has so many `ticks`, and friction may change
    its sign in one of up to `TURN`. In the half of a step in which a body begins to slide, what stuck is taken to stick
    once more.
    """
    length = tried.length
    shorter = (found.changed | found.fast) & (length > clock.finest) & (not found.gentle)
    wrong = found.wrong & (not shorter)
    onset = found.slides & (length > ONSET * ticks)
    back = found.back & (length > TURN * ticks)
    halved = ((found.reversed | back) & (not shorter)) | (wrong & (onset | (tried.tries >= pace.tries)))
    retry, sooner = wrong & (not halved), wrong & onset & (not found.reversed)
    shorter = shorter | halved
    longest = clock.standing if found.stands else pace.whole
    above = 2.0 * length if length < pace.whole else clock.standing
    times = tick / above
    fits = (times + NO_FRACTION) - NO_FRACTION == times
    longer = (tried.left <= 1.0) & (length < longest) & fits & (not (found.slides & (above > SLIDING * ticks)))
    left = (
        (clock.settled if length >= pace.settled_above * clock.finest else clock.dwell) if longer else tried.left - 1.0
    )
    left = clock.dwell if found.changed else left
    left = clock.settled if shorter else left
    left = tried.left if retry else left
    then = above if longer & (not (found.changed | retry)) else length
    then = 0.5 * length if shorter else then
    then = pace.whole if (length > pace.whole) & (shorter | (not found.stands)) else then
    return shorter | retry, sooner, Attempt(then, left, tried.tries + 1.0 if retry else 0.0)
