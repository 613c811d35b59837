"""Panels of films made from trajectories of a 3-D body or stack."""

import math
from typing import TYPE_CHECKING

import numpy as np

from overturning.arrays import FloatArray
from overturning.figures.film import (
    FilmBody,
    FilmPanel,
    fall_times_of_fallen_stones,
    ground_displacement_since_first_time,
    interpolate_to_frame_times,
    samples_from_time_zero,
)
from overturning.figures.film_words import fall_sentence, join_fall_sentences, standing_body_sentence
from overturning.motion.motion import Motion

if TYPE_CHECKING:
    import xarray as xr

MAX_TILT_SINE_AND_ANGULAR_VELOCITY_AT_REST = 1e-3
"""Largest tilt (direction cosine) and angular velocity, rad/s, of a body at rest."""


def _trajectory_of_each_stone(trajectory: "xr.Dataset") -> list["xr.Dataset"]:
    """Return a list with the simulated motion of each stone; a single body is one stone, named "body"."""
    if "element" not in trajectory.dims:
        return [trajectory.assign_coords(element="body")]
    return [trajectory.isel(element=index) for index in range(trajectory.sizes["element"])]


def body_outcome_sentence(trajectory: "xr.Dataset") -> str:
    """Return a sentence on the outcome of a 3-D body: azimuth and time of the fall, or tilt, twist and slip.

    The sentence has no full stop.
    """
    if float(trajectory["overturned"]) == 1:
        return fall_sentence(round(float(trajectory["fall_azimuth"])), float(trajectory["overturning_time"]))
    return _largest_motion_of_standing_stones_sentence([trajectory])


def _largest_motion_of_standing_stones_sentence(trajectory_by_stone: list["xr.Dataset"]) -> str:
    """Return a sentence, without full stop, with the largest tilt, twist and slip of stones that stand.

    If there are several stones, the sentence names those that tilt, twist and slip most.
    """
    # A cylinder may roll for minutes: its place of rest is not known at the end of the trajectory.
    last = [one.isel(time=-1) for one in trajectory_by_stone]
    tilts_at_end = [float(np.hypot(one["tilt_north"], one["tilt_east"])) for one in last]
    moves = (
        max(*tilts_at_end, *(float(np.abs(one["angular_velocity"]).max()) for one in last))
        > MAX_TILT_SINE_AND_ANGULAR_VELOCITY_AT_REST
    )

    def value_of_largest_magnitude_and_stone_name(value_by_stone: list[float]) -> tuple[float, str]:
        """Return the value of largest magnitude, with its sign, and the name of its stone; "" for a single stone."""
        place = int(np.argmax(np.abs(value_by_stone)))
        return value_by_stone[place], str(trajectory_by_stone[place]["element"].item()) if len(
            trajectory_by_stone
        ) > 1 else ""

    return standing_body_sentence(
        value_of_largest_magnitude_and_stone_name([float(one["peak_tilt"]) for one in trajectory_by_stone]),
        value_of_largest_magnitude_and_stone_name([float(one["residual_twist"]) for one in trajectory_by_stone]),
        value_of_largest_magnitude_and_stone_name(
            [float(np.hypot(one["residual_slip_north"], one["residual_slip_east"])) for one in trajectory_by_stone]
        ),
        still_moves=bool(moves),
    )


def stack_outcome_sentence(trajectory: "xr.Dataset") -> str:
    """Return a sentence, without full stop, on the outcome of a 3-D stack: the stones that fall, or all stand.

    Each falling stone has a name, azimuth and time. If all stand, the sentence gives the largest tilt, twist and slip
    of any stone, each with the name of the stone.
    """
    stones = _trajectory_of_each_stone(trajectory)
    falls = sorted(
        (float(one["overturning_time"]), str(one["element"].item()), round(float(one["fall_azimuth"])))
        for one in stones
        if float(one["overturned"]) == 1
    )
    if not falls:
        return _largest_motion_of_standing_stones_sentence(stones)
    several = len(stones) > 1
    texts = [fall_sentence(azimuth, time, name if several else "") for time, name, azimuth in falls]
    return join_fall_sentences(texts, len(stones))


def stack_tilts_quaternions_positions_by_time(trajectory: "xr.Dataset") -> FloatArray:
    """Return tilt (north, east), quaternion and position (m) of all stones of a stack, shape (times, 9 × stones)."""
    return np.concatenate(
        [tilt_north_east_quaternion_and_position_by_time(one) for one in _trajectory_of_each_stone(trajectory)], axis=1
    )


def tilt_north_east_quaternion_and_position_by_time(trajectory: "xr.Dataset") -> FloatArray:
    """Return the tilt components north and east, quaternion and position (m) of a 3-D body, shape (times, 9)."""
    return np.column_stack(
        [trajectory["tilt_north"], trajectory["tilt_east"], trajectory["quaternion"], trajectory["place"]]
    )


def body_or_stack_film_panel(
    trajectory: "xr.Dataset",
    motion: Motion,
    frame_times: FloatArray,
    heading_and_outcome: tuple[str, str],
    first_sample_time: float = 0.0,
) -> FilmPanel:
    """Return the film panel of a 3-D body or stack, with its poses at the times `frame_times`, s.

    `first_sample_time` is the time of the first sample of the motion, s.
    """
    bodies = tuple(
        _film_body_of_trajectory(one, frame_times, str(one["element"].item()))
        for one in _trajectory_of_each_stone(trajectory)
    )
    amplitude, interval = float(trajectory.attrs["amplitude"]), motion.sampling_interval
    level, up = amplitude * motion.horizontal_components, None if motion.up is None else amplitude * motion.up
    east_north_up = (level[1], level[0], up)
    ground = ground_displacement_since_first_time(east_north_up, interval, frame_times - first_sample_time)
    level = samples_from_time_zero(level, interval, first_sample_time)
    up = None if up is None else samples_from_time_zero(up, interval, first_sample_time)
    falls = fall_times_of_fallen_stones(trajectory)
    return FilmPanel(
        *heading_and_outcome,
        max(falls, default=math.nan),
        bodies,
        level,
        interval,
        vertical_base_acceleration=up,
        ground_displacement_by_frame=ground,
        first_fall_time=min(falls, default=math.nan),
    )


def _film_body_of_trajectory(trajectory: "xr.Dataset", frame_times: FloatArray, body_name: str) -> FilmBody:
    """Return a 3-D body of a film: its convex hull, and its position and rotation at `frame_times`, s."""
    outline = trajectory["outline"].to_numpy()
    outline = outline[np.isfinite(outline).all(axis=1)]
    clock = trajectory["time"].to_numpy()
    position, quaternion = (
        interpolate_to_frame_times(frame_times, clock, trajectory[one].to_numpy()) for one in ("place", "quaternion")
    )
    return FilmBody(body_name, outline, position, quaternion, face_vertex_indices=convex_hull_faces(outline))


def convex_hull_faces(corners: FloatArray) -> tuple[tuple[int, ...], ...]:
    """Return the plane faces, with three or more corners, of the convex hull of points `corners`, shape (n, 3).

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
