"""How far a case is, and what all kernels ask before they say that it has ended (docs/method.md, "How a case ends")."""

from typing import Final, NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import INLINE
from overturning.units import STANDARD_GRAVITY as GRAVITY

GOES_ON: Final = -1
"""Instead of a `Status`: the case has not ended."""

REST_ENERGY: Final = 1e-9
"""Kinetic energy of a body at rest on its base: less than this share of m g times half the width of the base."""

STILL: Final = 0.05
"""What changes a velocity in a body at rest is below this share of the acceleration that it bears."""

UPRIGHT: Final = 0.01
"""At rest a body leans by no more than this share of its tipping angle."""

STILL_TO_SLIDE: Final = 1e-6
"""Distance that a single body may have left to slide when its case ends, m."""


class Course(NamedTuple):
    """How far the case of a single body is and when it may end; looked at once per sample only."""

    amplitude: float
    """Factor on the motion;"""
    sample: float
    """sample of the record that the case is in;"""
    calm: float
    """sample from which on the shaking can start nothing;"""
    after: float
    """sample at which the case is undecided;"""
    upright_until: float
    """last time at which the body leant less than its tipping angle, s;"""
    energy: float
    """energy at the start, per mass, m²/s²;"""
    barrier: float
    """energy that overturning takes, per mass, m²/s²."""


class Rest(NamedTuple):
    """Whether a case is at rest."""

    bears: float
    """Horizontal acceleration that leaves it so, as a share of its weight, 0 where it is followed all the same;"""
    found: float
    """1 where it was found at rest at the begin of a sample."""


@njit(**INLINE)
def begin_sample(
    course: Course, tick: float, last_upright: float, ticks: float, interval: float
) -> tuple[float, float, float]:
    """Sample, tick in it and last time upright of a case whose last sample has ended, there upright until a tick."""
    then = (course.sample + last_upright * (1.0 / ticks)) * interval
    over = (1.0 if tick >= ticks else 0.0) + (1.0 if tick >= 2.0 * ticks else 0.0)
    return course.sample + over, tick - over * ticks, then if last_upright >= 0.0 else course.upright_until


@njit(**INLINE)
def surely_goes_on(course: Course, tick: float, ticks: float, end: float, total: float, sound: bool) -> bool:
    """Whether there is nothing to say of a case: one that is sound, in a sample in which something can still start.

    `total` is a sum of all that must be finite.
    """
    sample, until = course.sample + tick * (1.0 / ticks), course.calm if course.calm < end else end
    # Not finite minus not finite is never 0.
    return (total - total == 0.0) & sound & (sample < until)


@njit(**INLINE)
def is_still(speed: float, change: float, step: float, bears: float) -> bool:
    """Whether a body on its contacts neither moves nor rings, by its speed, acceleration and last step (m/s, m/s², s).

    What rings slower than the step shows in its acceleration, what rings faster in its speed over half of the step.
    """
    least = STILL * bears * GRAVITY
    return bool((2.0 * speed < least * step) & (change < least))
