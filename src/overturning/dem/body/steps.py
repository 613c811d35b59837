"""The steps of a body in space: how many whole ones a sample has, and how fine they become where a contact changes."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.kernel.clock import BODY
from overturning.dem.numerics import Numerics
from overturning.dem.time_step import Scheme, contact_time, steps_per_sample

TICKS: Final = BODY.whole


class Pace(NamedTuple):
    """Steps of each body, shape (n,)."""

    steps: NDArray[np.int64]
    """Whole ones in a sample;"""
    finest: FloatArray
    """ticks of the finest,"""
    dwell: FloatArray
    """and how many of these follow a change of contact."""


def pace_of(numerics: Numerics, square: FloatArray, rate: FloatArray, interval: float, period: FloatArray) -> Pace:
    """The steps of bodies with ω² (1/s²), twice the damping rate (1/s) and 1/p (s) under samples of an interval (s).

    Raises
    ------
    ArgumentError
        If the time step is not stable, or longer than the longest.
    """
    # Stable with any step: the limit is what it resolves, given as the one of an oscillator without damping.
    whole = BODY.longest * period
    wanted = "1 stable" if numerics.time_step == "auto" else numerics.time_step
    steps = steps_per_sample(Scheme.CUNDALL, wanted, (2.0 / whole) ** 2, np.zeros(whole.size), interval, period)
    tick = interval / steps / TICKS
    share = np.minimum(interval / steps / whole, 1.0)
    contact = contact_time(square, rate)
    ticks = np.clip(BODY.finest * share * contact / tick, 1.0, TICKS)
    finest = np.exp2(np.frexp(ticks)[1] - 1.0)
    # The ticks of a finer step are shorter.
    dwell = np.ceil(BODY.dwell * contact / (finest * tick)) * numerics.refinement
    return Pace(steps * numerics.refinement, finest, dwell)
