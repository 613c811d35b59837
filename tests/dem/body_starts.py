"""Bodies in space that begin in motion, on a base at rest."""

import numpy as np

from overturning.model.body import Start
from overturning.motion.motion import Motion


def level(duration: float, interval: float = 0.01) -> Motion:
    """A base at rest."""
    samples = int(duration / interval) + 1
    return Motion(np.zeros(samples), np.zeros(samples), sampling_interval=interval)


def leaning(tilt: float, arm: np.ndarray, turning: np.ndarray, *, sunk: float = 0.0, rolls: bool = True) -> Start:
    """A body that leans towards x (rad) and turns (rad/s) about the point of contact, `arm` from its centre; m.

    The contact is sunk in, m. Where it does not roll, the centre moves only up and down.
    """
    velocity = -np.cross(turning, arm)
    if not rolls:
        velocity[:2] = 0.0
    quaternion = (float(np.cos(tilt / 2)), 0.0, float(np.sin(tilt / 2)), 0.0)
    return Start((0.0, 0.0, float(-arm[2] - sunk)), quaternion, tuple(velocity), tuple(turning))


def axes(tilt: float) -> tuple[np.ndarray, np.ndarray]:
    """Axis of a body that leans towards x, and the direction from its axis to its deepest side."""
    return np.array([np.sin(tilt), 0.0, np.cos(tilt)]), np.array([np.cos(tilt), 0.0, -np.sin(tilt)])
