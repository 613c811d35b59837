"""How far a case is, and what all kernels ask before they say that it has ended (docs/method.md, "How a case ends")."""

from typing import Final, NamedTuple

GOES_ON: Final = -1
"""Instead of a `Status`: the case has not ended."""

REST_ENERGY: Final = 1e-9
"""Kinetic energy of a body at rest on its base: less than this share of m g times half the width of the base."""

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
    """energy that overturning takes, per mass, m²/s²;"""
    due: float
    """1 where the case may have ended by the end of this sample."""
