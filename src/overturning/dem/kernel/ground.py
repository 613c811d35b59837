"""The motion of the base, linear between two samples, as the lanes of all kernels load it."""

import math
from typing import Any, Final, NamedTuple

import numpy as np
from numba import njit

from overturning.arrays import FloatArray
from overturning.dem.kernel.lanes import INLINE, INNER
from overturning.units import STANDARD_GRAVITY as GRAVITY

LEAP: Final = 8
"""Samples that a body at rest is not followed for at once; where it may be is looked at once for so many."""

LEAD: Final = 0.5
"""Time for which it is followed before the shaking may move it, s: so its springs are as the shaking has left them."""

UNLOADED: Final = 2.0
"""How often the upward acceleration is taken off the weight of a body that is not followed: once, and for ringing."""


class Ground(NamedTuple):
    """The motion of the base, padded with zeros after the record."""

    along: FloatArray
    """Acceleration in each direction asked for, m/s²: towards +s, shape (azimuths, samples + 3), or along x and y of a
    body in space, shape (orientations, 2, samples + 3);"""
    up: FloatArray | None
    """upward acceleration, m/s², shape (samples + 3,); with None a kernel without it is compiled;"""
    loudest: FloatArray
    """largest horizontal acceleration from each sample on, as of `loudest_ahead`, shape (directions, samples + 1),"""
    loudest_up: FloatArray
    """and vertical one, up or down, shape (samples + 1,)."""


class Line(NamedTuple):
    """A component of the base's acceleration over a sample, m/s²."""

    value: float
    """Value at the sample's begin,"""
    slope: float
    """slope per tick of the clock,"""
    bend: float
    """and change of the slope at the sample's end."""


@njit(**INNER)
def piece(motion: Any, i: int, factor: float, scale: float) -> Line:
    """Line of a component from sample i on, times a factor; `scale` is 1 over the ticks of a sample."""
    a0, a1, a2 = motion[i] * factor, motion[i + 1] * factor, motion[i + 2] * factor
    return Line(a0, (a1 - a0) * scale, ((a2 - a1) - (a1 - a0)) * scale)


@njit(**INLINE)
def within_sample(line: Line, tick: float) -> float:
    """A component at a tick of its sample."""
    return line.value + line.slope * tick


@njit(**INLINE)
def at_tick(line: Line, tick: float, past: float) -> float:
    """A component at a tick of which `past` lie in the next sample."""
    return (line.value + line.slope * tick) + line.bend * past


def loudest_ahead(size: FloatArray, interval: float) -> FloatArray:
    """Largest of each sample and those of the next `LEAP` samples and `LEAD`; infinite where a leap ends too late.

    Parameters
    ----------
    size : ndarray, shape (…, samples + 3)
        Length of the acceleration, m/s², with zeros after the record.
    interval : float
        Time between samples, s.

    Returns
    -------
    ndarray, shape (…, samples + 1)
    """
    samples, ahead = size.shape[-1] - 3, np.full((*size.shape[:-1], size.shape[-1] - 2), np.inf)
    window, known = LEAP + int(np.ceil(LEAD / interval)) + 1, max(samples - LEAP + 1, 0)
    after = np.zeros((*size.shape[:-1], window))
    windows = np.lib.stride_tricks.sliding_window_view(np.concatenate([size, after], axis=-1), window, axis=-1)
    ahead[..., :known] = windows[..., :known, :].max(axis=-1)
    return ahead


@njit(**INLINE)
def is_looked_at(sample: float) -> bool:
    """Whether a case at this time, in samples, may be found at rest: in the first two of each `LEAP` samples."""
    leaps = sample * (1.0 / LEAP)
    return leaps - math.floor(leaps) < 2.0 / LEAP


@njit(**INNER)
def samples_at_rest(ground: Ground, row: int, sample: float, factor: float, bears: float) -> int:
    """For how many samples a body at rest stays so: no acceleration up to the next one exceeds what it bears.

    The motion is multiplied by a `factor`; the body bears a horizontal acceleration of `bears` times its weight. An
    acceleration is linear between samples, so that it is largest at one of them.
    """
    at, size, count = min(int(sample), ground.loudest_up.size - 1), abs(factor), 0
    while size * (ground.loudest[row, at] + UNLOADED * bears * ground.loudest_up[at]) < bears * GRAVITY:
        at, count = at + LEAP, count + LEAP
    return count
