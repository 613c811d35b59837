"""Independent reference for a block that slides, flies and lands without rotation."""

import math

import numpy as np
from numba import njit

from overturning.dem.kernel.cache import cache_compiled_kernel
from overturning.units import STANDARD_GRAVITY

STEPS_PER_SAMPLE = 200


@cache_compiled_kernel
@njit
def _slip_after_steps(along, up, dt, friction):  # type: ignore[no-untyped-def]
    """Return the slip (m) after time steps `dt` (s), with the base acceleration (m/s²) of each step."""
    x, z, vx, vz = 0.0, 0.0, 0.0, 0.0
    for step in range(along.size):
        vx -= dt * along[step]
        vz -= dt * (STANDARD_GRAVITY + up[step])
        impulse = max(-vz, 0.0) if z <= 0.0 else 0.0
        vz += impulse
        vx -= math.copysign(min(abs(vx), friction * impulse), vx)
        x, z = x + dt * vx, z + dt * vz
    return x


def stays_flat(along: np.ndarray, up: np.ndarray, interval: float, friction: float, amplitude: float = 1.0) -> float:
    """Compute the slip (m) of a block that slides, flies and lands without rotation, with 200 steps per sample.

    A plastic landing at velocity v reduces the horizontal velocity by µ·v, at most to zero. The computation continues
    for 3 s after the record.
    """
    dt = interval / STEPS_PER_SAMPLE
    time = np.arange(along.size * STEPS_PER_SAMPLE + round(3.0 / dt)) * dt
    samples = np.arange(along.size) * interval
    ground, lift = (np.interp(time, samples, amplitude * values) for values in (along, up))
    return float(_slip_after_steps(ground, lift, dt, friction))
