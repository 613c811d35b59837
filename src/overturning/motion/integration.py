"""Velocity and displacement from acceleration."""

import numpy as np

from overturning.arrays import FloatArray


def integrate(samples: FloatArray, sampling_interval: float) -> FloatArray:
    """Running integral by the trapezoidal rule, zero at the first sample.

    Parameters
    ----------
    samples : ndarray, shape (..., n)
        Evenly spaced samples along the last axis.
    sampling_interval : float
        Time between samples, s.

    Returns
    -------
    ndarray, shape (..., n)
        Same unit times second.
    """
    integral = np.zeros_like(samples)
    np.cumsum(0.5 * sampling_interval * (samples[..., 1:] + samples[..., :-1]), axis=-1, out=integral[..., 1:])
    return integral


def peaks(samples: FloatArray, sampling_interval: float) -> tuple[float, float, float]:
    """Largest absolute acceleration, velocity and displacement of any component, starting from rest.

    Parameters
    ----------
    samples : ndarray, shape (..., n)
        Acceleration of one or more components, m/s².
    sampling_interval : float
        Time between samples, s.

    Returns
    -------
    pga, pgv, pgd : float
        m/s², m/s, m.
    """
    velocity = integrate(samples, sampling_interval)
    displacement = integrate(velocity, sampling_interval)
    return tuple(float(np.abs(x).max()) for x in (samples, velocity, displacement))  # type: ignore[return-value]
