"""Panels of films made from trajectories of a 3-D body."""

from typing import TYPE_CHECKING

import numpy as np

from overturning.arrays import FloatArray
from overturning.figures.film import FilmBody, FilmPanel, ground_displacement_at_times, interpolate_to_frame_times
from overturning.figures.film_words import fall_sentence, standing_body_sentence
from overturning.motion.motion import Motion

if TYPE_CHECKING:
    import xarray as xr

STILL = 1e-3
"""Largest tilt (direction cosine) and angular velocity, rad/s, of a body at rest."""


def body_outcome_sentence(trajectory: "xr.Dataset") -> str:
    """Return the outcome of a 3-D body as a sentence without a full stop."""
    if float(trajectory["overturned"]) == 1:
        return fall_sentence(round(float(trajectory["fall_azimuth"])), float(trajectory["overturning_time"]))
    slip = float(np.hypot(trajectory["residual_slip_north"], trajectory["residual_slip_east"]))
    # A cylinder may roll for minutes: its place of rest is not known at the end of the trajectory.
    tilt_at_end = np.hypot(float(trajectory["tilt_north"][-1]), float(trajectory["tilt_east"][-1]))
    moves = max(tilt_at_end, float(np.abs(trajectory["angular_velocity"][-1]).max())) > STILL
    return standing_body_sentence(
        float(trajectory["peak_tilt"]), float(trajectory["residual_twist"]), slip, still_moves=bool(moves)
    )


def body_poses_by_time(trajectory: "xr.Dataset") -> FloatArray:
    """Return tilt (north, east), quaternion and position of a 3-D body, shape (times, 9)."""
    return np.column_stack(
        [trajectory["tilt_north"], trajectory["tilt_east"], trajectory["quaternion"], trajectory["place"]]
    )


def body_film_panel(
    trajectory: "xr.Dataset", motion: Motion, frame_times: FloatArray, heading_and_outcome: tuple[str, str]
) -> FilmPanel:
    """Return the film panel of a 3-D body at `frame_times`, s, titled by `heading_and_outcome`."""
    clock, outline = trajectory["time"].to_numpy(), trajectory["outline"].to_numpy()
    position, quaternion = (
        interpolate_to_frame_times(frame_times, clock, trajectory[name].to_numpy()) for name in ("place", "quaternion")
    )
    body = FilmBody("body", outline, position, quaternion, faces=convex_hull_faces(outline))
    amplitude, interval = float(trajectory.attrs["amplitude"]), motion.sampling_interval
    level, up = amplitude * motion.horizontal, None if motion.up is None else amplitude * motion.up
    ground = ground_displacement_at_times((level[1], level[0], up), interval, frame_times)  # east, north, up
    when = float(trajectory["overturning_time"])
    return FilmPanel(*heading_and_outcome, when, (body,), level, interval, vertical=up, ground=ground)


def convex_hull_faces(corners: FloatArray) -> tuple[tuple[int, ...], ...]:
    """Return the faces of the convex hull of points, an array of shape (n, 3).

    Each face is a tuple of indices into `corners`, anticlockwise seen from outside.
    """
    from scipy.spatial import ConvexHull

    hull = ConvexHull(corners)
    faces = []
    for normal in np.unique(np.round(hull.equations, 6), axis=0):
        on = np.flatnonzero(np.abs(corners @ normal[:3] + normal[3]) < 1e-5 * np.ptp(corners))
        middle = corners[on].mean(axis=0)
        first = corners[on[0]] - middle
        second = np.cross(normal[:3], first)
        turn = np.arctan2((corners[on] - middle) @ second, (corners[on] - middle) @ first)
        faces.append(tuple(int(one) for one in on[np.argsort(turn)]))
    return tuple(faces)
