"""The motion of the base, linear between two samples, as the lanes of all kernels load it."""

import math
from functools import reduce
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

LOOKS: Final = 2
"""So many samples of each leap, the first ones, are looked at: one alone may be passed over by steps of a sample."""

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
    """largest horizontal acceleration ahead, as of `loudest_ahead`, shape (directions, leaps, LOOKS),"""
    loudest_up: FloatArray
    """and vertical one, up or down, shape (leaps, LOOKS)."""


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
    """Largest of a sample and those of the next `LEAP` samples and `LEAD`; infinite where a leap ends too late.

    The maximum of each leap serves all windows that cover it: taken sample by sample, windows of long records took half
    of the time of a sweep.

    Parameters
    ----------
    size : ndarray, shape (…, samples + 3)
        Length of the acceleration, m/s², with zeros after the record.
    interval : float
        Time between samples, s.

    Returns
    -------
    ndarray, shape (…, samples // LEAP + 1, LOOKS)
        Of the first samples of each leap.
    """
    samples = size.shape[-1] - 3
    window, count = LEAP + int(np.ceil(LEAD / interval)) + 1, samples // LEAP + 1
    padded = np.zeros((count + window // LEAP + 1, LEAP))
    late = [LEAP * np.arange(count) + look > samples - LEAP for look in range(LOOKS)]
    rows = size.reshape(-1, size.shape[-1])
    ahead = np.empty((len(rows), count, LOOKS))
    # Direction by direction, whose samples stay in the cache of a processor.
    for row, found in zip(rows, ahead, strict=True):
        padded.flat[: samples + 1] = row[: samples + 1]
        by_place = np.ascontiguousarray(padded.T)
        whole = by_place.max(axis=0)
        for look in range(LOOKS):
            # The window covers the rest of its own leap, so many further ones, and what is left of it in the last.
            further, left = divmod(window - (LEAP - look), LEAP)
            parts = [*by_place[look:, :count], *(whole[leap : leap + count] for leap in range(1, 1 + further))]
            parts += [*by_place[:left, 1 + further : 1 + further + count]]
            found[:, look] = np.where(late[look], np.inf, reduce(np.maximum, parts))
    return ahead.reshape(*size.shape[:-1], count, LOOKS)


@njit(**INLINE)
def is_looked_at(sample: float) -> bool:
    """Whether a case at this time, in samples, may be found at rest: in the first `LOOKS` of each `LEAP` samples."""
    leaps = sample * (1.0 / LEAP)
    return leaps - math.floor(leaps) < LOOKS / LEAP


@njit(**INLINE)
def cannot_move(ground: Ground, row: int, sample: float, factor: float, bears: float) -> bool:
    """Whether no acceleration up to the end of the next leap, nor soon after it, exceeds what a body at rest bears.

    The motion is multiplied by a `factor`; the body bears a horizontal acceleration of `bears` times its weight. An
    acceleration is linear between samples, so that it is largest at one of them.
    """
    leap, look = min(int(sample) // LEAP, ground.loudest_up.shape[0] - 1), int(sample) % LEAP
    across, up = ground.loudest[row, leap, look], ground.loudest_up[leap, look]
    return bool(abs(factor) * (across + UNLOADED * bears * up) < bears * GRAVITY)


@njit(**INNER)
def samples_at_rest(ground: Ground, row: int, sample: float, factor: float, bears: float) -> int:
    """For how many samples a body at rest stays so, in leaps in which it `cannot_move`."""
    count = 0
    while cannot_move(ground, row, sample + count, factor, bears):
        count += LEAP
    return count
