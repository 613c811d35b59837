"""Initial states of 3-D bodies that start in motion on a base at rest."""

import numpy as np

from overturning.model.body import InitialState
from overturning.motion.motion import Motion


def motion_at_rest(duration: float, interval: float = 0.01) -> Motion:
    """Return the motion of a base at rest; duration and sampling interval in s."""
    samples = int(duration / interval) + 1
    return Motion(np.zeros(samples), np.zeros(samples), sampling_interval=interval)


def state_of_leaning_rotating_body(
    tilt: float, arm: np.ndarray, turning: np.ndarray, *, sunk: float = 0.0, rolls: bool = True
) -> InitialState:
    """Return a body that leans towards x by `tilt` (rad) and rotates about its contact point.

    `arm`: vector from centre to contact point (m). `turning`: angular velocity (rad/s). `sunk`: penetration (m).
    If the body does not roll (`rolls` False), the centre moves only vertically.
    """
    velocity = -np.cross(turning, arm)
    if not rolls:
        velocity[:2] = 0.0
    quaternion = (float(np.cos(tilt / 2)), 0.0, float(np.sin(tilt / 2)), 0.0)
    return InitialState((0.0, 0.0, float(-arm[2] - sunk)), quaternion, tuple(velocity), tuple(turning))


def body_axis_and_direction_to_lowest_side(tilt: float) -> tuple[np.ndarray, np.ndarray]:
    """Return unit vectors along the axis of a body that leans towards x, and from its axis to its lowest side."""
    return np.array([np.sin(tilt), 0.0, np.cos(tilt)]), np.array([np.cos(tilt), 0.0, -np.sin(tilt)])
