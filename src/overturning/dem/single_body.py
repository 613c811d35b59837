"""What the kernels of a single body, in a plane or in space, share: the motion of the base, the course of a case, the scheme."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numba import njit

from overturning.arrays import FloatArray
from overturning.dem.lanes import INLINE, INNER, OPTIONS
from overturning.dem.plan import MOST_PATH
from overturning.dem.time_step import Scheme


class Ground(NamedTuple):
    """The motion of the base, padded with zeros after the record."""

    along: FloatArray
    """Acceleration in each direction asked for, m/s²: towards +s, shape (azimuths, samples + 3), or along x and y of the body,
    shape (orientations, 2, samples + 3);"""
    up: FloatArray | None
    """upward, shape (samples + 3,); None where there is none, which compiles a block's kernel without it;"""
    samples: int
    interval: float
    """time between them, s."""


class Line(NamedTuple):
    """A component of the shaking over a sample: value at its begin, slope per tick, change of slope at its end."""

    value: float
    slope: float
    bend: float


class Course(NamedTuple):
    """How far a case is and when it may end; looked at once per sample only."""

    amplitude: float
    """Factor on the motion;"""
    sample: float
    """the sample it is in,"""
    calm: float
    """the one from which on the shaking can start nothing,"""
    after: float
    """and the one at which it is undecided;"""
    upright_until: float
    """last time at which it leant less than α, s;"""
    energy: float
    """energy at the start,"""
    barrier: float
    """what it takes to overturn the body;"""
    look: float
    """1 where there may be something to say at the end of this sample."""


Schemes = Mapping[Scheme, tuple[Any, Any]]
"""What a kernel is told of each scheme, a named tuple, and the function that makes its loops."""


def maker(schemes: Schemes, told: Any) -> Any:
    """The function that makes the loops of the scheme whose named tuple has, for compiled code, the type `told`."""
    return next(make for one, make in schemes.values() if type(one) is told.instance_class)


@njit(**INNER)
def piece(motion: Any, i: int, factor: float, scale: float) -> Line:
    """A component of the motion over a sample, by its ticks, of which `scale` is 1 over their number."""
    a0, a1, a2 = motion[i] * factor, motion[i + 1] * factor, motion[i + 2] * factor
    return Line(a0, (a1 - a0) * scale, ((a2 - a1) - (a1 - a0)) * scale)


@njit(**INLINE)
def within_sample(line: Line, tick: float) -> float:
    """A component of the shaking at a tick."""
    return line.value + line.slope * tick


@njit(**INLINE)
def at_tick(line: Line, tick: float, past: float) -> float:
    """The same where `past` ticks of the next sample are over."""
    return (line.value + line.slope * tick) + line.bend * past


@njit(**OPTIONS)
def with_room(path: Any, noted: int) -> Any:
    """A path with room for a row more: twice as long where all rows are filled; as it is where that would be above `MOST_PATH`."""
    if noted < path.shape[0] or 2 * path.size > MOST_PATH:
        return path
    longer = np.zeros((2 * noted, path.shape[1]))
    longer[:noted] = path
    return longer
