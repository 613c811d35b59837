"""Step control of a case: acceptance of an attempted step and length of the next (docs/method.md, "The clock").

A whole step is as long as the motion allows. A step in which a contact would open or close is rejected and halved, down
to the finest step, which resolves the contact. After the change, each length is kept for some steps before it doubles.
Lengths are in ticks. A longer step begins only at a multiple of its length, so that each step lies within one sample,
over which the input motion is linear.
"""

from typing import Final, NamedTuple

import numpy as np
from numba import njit

from overturning.arrays import FloatArray
from overturning.dem.kernel.lanes import INLINE
from overturning.dem.time_step import MAX_ROCKING_STEP


class StepControl(NamedTuple):
    """Constants of the step control of a kernel: limits of its step lengths, and numbers of steps and repetitions."""

    longest: float
    """Longest whole step, in 1/p; p = √(3g/4R) of the element that rocks fastest."""
    finest: float
    """Longest step in which a contact may open or close, in 1/ω of the highest mode of the contact."""
    whole: float
    """Ticks of a whole step: a power of two, whose exponent is the largest number of halvings."""
    fine: float
    """Longest step, in finest steps, that uses predicted forces for contact and slip; longer ones the last state."""
    tries: float
    """Number of repetitions of a longer step with corrected sliding points before it is shortened."""
    dwell: float
    """Steps of one length after a contact change before the length doubles; more for a lightly damped contact."""
    settled_above: float
    """Length, in finest steps, above which steps no longer resolve the vibration after a contact change."""
    settled: float
    """Steps of each length above `settled_above`, and of a length to which a step was shortened."""

    @property
    def max_halvings(self) -> int:
        """Largest number of halvings of a whole step."""
        return int(self.whole).bit_length() - 1

    def steps_before_doubling(self, squared_frequency: FloatArray, damping_rate: FloatArray) -> FloatArray:
        """Return the number of steps after a contact change before the step length doubles.

        Arguments are ω² (1/s²) and twice the damping rate (1/s) of the highest mode, arrays of the same shape.

            The number grows if the damping ratio is below one half.
        """
        return np.asarray(self.dwell * np.clip(np.sqrt(squared_frequency) / np.maximum(damping_rate, 1e-300), 1.0, 8.0))


# Measured in docs/measurements.md (rigid limit, default step), by `python -m verification.scenes steps` (scenes) and
# `python -m verification.space` (3-D bodies). A 3-D body needs shorter steps: its lowest point moves along a rim.
BLOCK: Final = StepControl(
    longest=MAX_ROCKING_STEP, finest=0.08, whole=2.0**24, fine=4.0, tries=2.0, dwell=8.0, settled_above=8.0, settled=2.0
)
SCENE: Final = StepControl(
    longest=0.0125, finest=0.16, whole=2.0**20, fine=4.0, tries=2.0, dwell=8.0, settled_above=8.0, settled=2.0
)
BODY: Final = StepControl(
    longest=0.004, finest=0.1, whole=2.0**9, fine=2.0, tries=3.0, dwell=8.0, settled_above=8.0, settled=4.0
)

MAX_SLIDING_STEP: Final = 0.25
"""Longest step of a body that slides on all its contacts, in samples; it could stop or start within a longer one."""

MAX_SLIP_ONSET_STEP: Final = 0.0625
"""Longest step in which a body begins to slide, in samples; it is assumed to slide during the whole step."""

MAX_FRICTION_REVERSAL_STEP: Final = 0.015625
"""Longest step in which friction changes its sign, in samples; half of it still has the old sign."""

INTEGER_ROUNDING: Final = 2.0**52
"""2**52: adding and subtracting it rounds a positive float64 to an integer."""


class Clock(NamedTuple):
    """Step lengths of a case (ticks), and numbers of steps of one length before the length doubles."""

    finest: float
    """Finest step, ticks."""
    standing: float
    """Step while the body rests on all contacts (≥ whole step), ticks."""
    dwell: float
    """Steps of one length after a contact change."""
    settled: float
    """Steps of one length above `StepControl.settled_above`."""


class StepAttempt(NamedTuple):
    """Length of the next step to attempt, number of steps left at this length, and number of repetitions so far."""

    length: float
    """Length, ticks."""
    left: float
    """Steps of this length before longer ones may be tried."""
    tries: float
    """Number of repetitions of this step with other sliding points."""


class StepFindings(NamedTuple):
    """Contact changes and sliding in an attempted step; they decide whether it is accepted."""

    changed: bool
    """True if a contact opens or closes."""
    fast: bool
    """True if the motion requires a shorter step."""
    gentle: bool
    """True if the step may be accepted anyway."""
    wrong: bool
    """True if the sticking or sliding of a point differs from the assumption."""
    reversed: bool
    """True if a point slides against its velocity (slip reversal)."""
    back: bool
    """True if the friction of a sliding point had the opposite sign before, so that it changes sign in the step."""
    slides: bool
    """True if all contact points of a body slide."""
    stands: bool
    """True if all contacts are closed at the end of the step."""


@njit(**INLINE)
def choose_next_attempt(
    step_control: StepControl,
    clock: Clock,
    step_attempt: StepAttempt,
    step_findings: StepFindings,
    end_tick: float,
    ticks_per_sample: float,
) -> tuple[bool, bool, StepAttempt]:
    """Accept or reject an attempted step, and choose the next attempt.

    Returns (True if rejected, True if the assumed sliding is kept, next attempt). `end_tick` is the end of the attempt.
    A body may begin to slide in a step of up to `MAX_SLIP_ONSET_STEP` of a sample, and friction may change its sign in
    one of up to `MAX_FRICTION_REVERSAL_STEP`. If a step in which a body begins to slide is halved, the points that
    stuck are assumed to stick again.
    """
    length = step_attempt.length
    shorter = (step_findings.changed | step_findings.fast) & (length > clock.finest) & (not step_findings.gentle)
    wrong = step_findings.wrong & (not shorter)
    onset = step_findings.slides & (length > MAX_SLIP_ONSET_STEP * ticks_per_sample)
    back = step_findings.back & (length > MAX_FRICTION_REVERSAL_STEP * ticks_per_sample)
    halved = ((step_findings.reversed | back) & (not shorter)) | (
        wrong & (onset | (step_attempt.tries >= step_control.tries))
    )
    retry, sooner = wrong & (not halved), wrong & onset & (not step_findings.reversed)
    shorter = shorter | halved
    longest = clock.standing if step_findings.stands else step_control.whole
    above = 2.0 * length if length < step_control.whole else clock.standing
    times = end_tick / above
    fits = (times + INTEGER_ROUNDING) - INTEGER_ROUNDING == times
    longer = (
        (step_attempt.left <= 1.0)
        & (length < longest)
        & fits
        & (not (step_findings.slides & (above > MAX_SLIDING_STEP * ticks_per_sample)))
    )
    left = (
        (clock.settled if length >= step_control.settled_above * clock.finest else clock.dwell)
        if longer
        else step_attempt.left - 1.0
    )
    left = clock.dwell if step_findings.changed else left
    left = clock.settled if shorter else left
    left = step_attempt.left if retry else left
    then = above if longer & (not (step_findings.changed | retry)) else length
    then = 0.5 * length if shorter else then
    then = step_control.whole if (length > step_control.whole) & (shorter | (not step_findings.stands)) else then
    return shorter | retry, sooner, StepAttempt(then, left, step_attempt.tries + 1.0 if retry else 0.0)
