"""Velocity and displacement from acceleration."""

import numpy as np

from overturning.arrays import FloatArray


def integrate(samples: FloatArray, sampling_interval: float) -> FloatArray:
    """Return the cumulative integral of samples over time by the trapezoidal rule, zero at the first sample.

    Time is the last axis of the array. The sampling interval is in s, so the unit of the result is that of the samples
    times s.
    """
    integral = np.zeros_like(samples)
    np.cumsum(0.5 * sampling_interval * (samples[..., 1:] + samples[..., :-1]), axis=-1, out=integral[..., 1:])
    return integral
