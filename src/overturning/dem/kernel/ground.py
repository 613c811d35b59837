"""The motion of the base, linear between two samples, as the lanes of all kernels load it."""

from typing import Any, NamedTuple

from numba import njit

from overturning.arrays import FloatArray
from overturning.dem.kernel.lanes import INLINE, INNER


class Ground(NamedTuple):
    """The motion of the base, padded with zeros after the record."""

    along: FloatArray
    """Acceleration in each direction asked for, m/s²: towards +s, shape (azimuths, samples + 3), or along x and y of a
    body in space, shape (orientations, 2, samples + 3);"""
    up: FloatArray | None
    """upward acceleration, m/s², shape (samples + 3,); with None a kernel without it is compiled."""


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
