"""Panels of films made from trajectories of the elements of a 2-D scene."""

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
from overturning.figures.film_words import fall_sentence, join_fall_sentences, standing_elements_sentence
from overturning.figures.style import compass_bearing_text
from overturning.motion.motion import Motion

if TYPE_CHECKING:
    import xarray as xr

MIN_ENDLESS_GROUND_HALF_WIDTH_OVER_SCENE_HEIGHT = 3.0
"""Half-width from which an element is drawn as endless ground, as a multiple of the scene's height."""

GROUND_HALF_WIDTH_AND_DEPTH_OVER_SCENE_HEIGHT = 20.0
"""Half-width and depth with which endless ground is drawn, as a multiple of the scene's height: beyond the edges of the
picture, also if the ground sinks, or stones of another panel slide far or are thrown up."""

MAX_TIME_ADDED_UNTIL_STONE_LIES_S = 0.5
"""Longest time, s, by which a trajectory that ends just before a stone lies down is extended."""


def trajectory_of_free_elements(trajectory: "xr.Dataset") -> "xr.Dataset":
    """Return the simulated motions of the free elements, without elements that are fixed or move with the ground."""
    return trajectory.isel(element=trajectory["kind"].to_numpy() == "free")


def scene_outcome_sentence(trajectory: "xr.Dataset") -> str:
    """Return a sentence on the outcome of a 2-D scene: name, direction and time of each fall, in order of time.

    The name is left out if the scene has only one free element.
    """
    free, azimuth = trajectory_of_free_elements(trajectory), trajectory.attrs["azimuth_deg"]
    several = free.sizes["element"] > 1
    names, sides, times = (free[name].to_numpy().tolist() for name in ("element", "overturned", "overturning_time"))
    falls = sorted((time, name, side) for time, name, side in zip(times, names, sides, strict=True) if abs(side) == 1)
    if falls:
        texts = [
            fall_sentence(azimuth if side > 0 else azimuth + 180.0, time, name if several else "")
            for time, name, side in falls
        ]
        return join_fall_sentences(texts, len(names))
    peak, has = free["peak_rotation"].to_numpy(), np.isfinite(free["critical_angle"].to_numpy())
    share = float(peak[has].max()) if has.any() else None  # in parts of α
    return standing_elements_sentence(
        share, None if has.all() else float(peak[~has].max()), has_several_free_stones=several
    )


def free_element_poses_by_time(trajectory: "xr.Dataset") -> FloatArray:
    """Return the coordinates x and z (m) and the rotation (rad) of all free elements, shape (times, 3 × elements)."""
    free = trajectory_of_free_elements(trajectory)
    return np.concatenate(
        [free[name].transpose("time", "element").to_numpy() for name in ("x", "z", "rotation")], axis=1
    )


def _element_poses_by_time(trajectory: "xr.Dataset", element_index: int) -> FloatArray:
    """Return the coordinates x and z (m) and the rotation (rad) of one element of a 2-D scene, shape (times, 3)."""
    return np.stack([trajectory[name].to_numpy()[:, element_index] for name in ("x", "z", "rotation")], axis=1)


def _times_and_poses_with_added_lying_pose(
    trajectory: "xr.Dataset", element_index: int
) -> tuple[FloatArray, FloatArray]:
    """Return times (s) and poses (x and z, m; rotation, rad) of a scene element; a fallen single block lies at last.

    The trajectory of a single block ends at the last sample before the block lies: some degrees too early if the
    sampling interval is large. One pose is added in which the block has turned about its corner until it lies.
    """
    one, time, poses = (
        trajectory.isel(element=element_index),
        trajectory["time"].to_numpy(),
        _element_poses_by_time(trajectory, element_index),
    )
    side, speed = float(one["overturned"]), abs(float(one["angular_velocity"][-1]))
    x, _, angle = poses[-1]
    if trajectory.sizes["element"] != 2 or abs(side) != 1:
        return time, poses
    fallen = float(one["fallen_angle"].sel(side=side))
    left = fallen - abs(angle)
    if not 0.0 < left < MAX_TIME_ADDED_UNTIL_STONE_LIES_S * speed:
        return time, poses
    level = float((trajectory["z"][0] + trajectory["vertices"][..., 1].max("vertex")).isel(element=1 - element_index))
    p, q = one["vertices"].to_numpy()[np.isfinite(one["vertices"].to_numpy()[:, 0])].T
    lowest = int(np.argmin(q * np.cos(angle) - p * np.sin(angle)))
    corner = x + p[lowest] * np.cos(angle) + q[lowest] * np.sin(angle)
    lies = side * fallen
    c, s = np.cos(lies), np.sin(lies)
    lying = [corner - (p[lowest] * c + q[lowest] * s), level + (p[lowest] * s - q[lowest] * c), lies]
    return np.append(time, time[-1] + left / speed), np.concatenate([poses, [lying]])


def _film_bodies_of_scene(
    trajectory: "xr.Dataset", frame_times: FloatArray, ground_displacement_by_frame: FloatArray
) -> tuple[FilmBody, ...]:
    """Return the bodies of a 2-D scene at the times `frame_times`; very wide ground is cut outside the picture."""
    vertices, x = trajectory["vertices"].to_numpy(), trajectory["x"].to_numpy()
    free = np.flatnonzero(trajectory["kind"].to_numpy() == "free")
    levels = vertices[free, :, 1] + trajectory["z"].to_numpy()[0, free, None]
    tall = float(np.nanmax(levels) - np.nanmin(levels))
    reach = (
        MIN_ENDLESS_GROUND_HALF_WIDTH_OVER_SCENE_HEIGHT * tall
        + float(np.abs(x[:, free]).max())
        + float(np.abs(ground_displacement_by_frame).max())
    )
    bodies = []
    for index, name in enumerate(trajectory["element"].to_numpy()):
        shape, is_free = vertices[index][np.isfinite(vertices[index, :, 0])], index in free
        clock, poses = (
            _times_and_poses_with_added_lying_pose(trajectory, index)
            if is_free
            else (trajectory["time"].to_numpy(), _element_poses_by_time(trajectory, index))
        )
        frames = interpolate_to_frame_times(frame_times, clock, poses)
        if not is_free:
            frames = frames if np.ptp(frames, axis=0).any() else frames[:1]  # held elements move relative to the base
            if np.ptp(shape[:, 0]) > 2 * reach:
                shape = _clip_wide_ground(shape, reach + GROUND_HALF_WIDTH_AND_DEPTH_OVER_SCENE_HEIGHT * tall)
        bodies.append(FilmBody(str(name), shape, frames[:, :2], frames[:, 2], is_free=is_free))
    return tuple(bodies)


def _clip_wide_ground(ground_vertices: FloatArray, clipped_half_width_and_depth_m: float) -> FloatArray:
    """Return the vertices of very wide ground, m, cut to half-width and depth `clipped_half_width_and_depth_m`."""
    s, z = (
        np.clip(ground_vertices[:, 0], -clipped_half_width_and_depth_m, clipped_half_width_and_depth_m),
        ground_vertices[:, 1],
    )
    return np.column_stack([s, np.where(z == z.min(), z.max() - clipped_half_width_and_depth_m, z)])


def _contact_points_and_forces(
    trajectory: "xr.Dataset", frame_times: FloatArray
) -> tuple[FloatArray, FloatArray] | tuple[None, None]:
    """Return positions (m) and forces (over the weight of the stones) of k contacts by frame, both (frames, k, 2).

    Forces are zero after the end of the simulation. Returns (None, None) if there is no contact at any time.
    """
    clock = trajectory["time"].to_numpy()
    force, place = (
        trajectory["contact_force"].to_numpy() / trajectory.attrs["weight"],
        trajectory["contact_place"].to_numpy(),
    )
    ever = np.isfinite(place).any(axis=(0, 2))
    if not ever.any():
        return None, None
    force, place = (
        _fill_missing_with_last_or_first_known(force[:, ever]),
        _fill_missing_with_last_or_first_known(place[:, ever]),
    )
    # Use the last sample up to each frame; the player interpolates between frames.
    at = np.clip(np.searchsorted(clock, frame_times + 1e-9, side="right") - 1, 0, clock.size - 1)
    return place[at], np.where(frame_times[:, None, None] <= clock[-1], force[at], 0.0)


def _fill_missing_with_last_or_first_known(values_by_time: FloatArray) -> FloatArray:
    """Replace each NaN by the last known value before it, or by the first known one (time is the first axis)."""
    known = np.isfinite(values_by_time)
    rows = np.arange(len(values_by_time)).reshape(-1, 1, 1)
    before = np.maximum.accumulate(np.where(known, rows, -1), axis=0)
    return np.take_along_axis(values_by_time, np.where(before >= 0, before, known.argmax(axis=0)), axis=0)


def scene_film_panel(
    trajectory: "xr.Dataset",
    motion: Motion,
    frame_times: FloatArray,
    heading_and_outcome: tuple[str, str],
    first_sample_time: float = 0.0,
) -> FilmPanel:
    """Return the film panel of a 2-D scene, with its elements at the times `frame_times`, s.

    `first_sample_time` is the time of the first sample of the motion, s.
    """
    azimuth, falls = float(trajectory.attrs["azimuth_deg"]), fall_times_of_fallen_stones(trajectory)
    amplitude = float(trajectory.attrs["amplitude"])
    along, up = amplitude * motion.acceleration_along(azimuth), None if motion.up is None else amplitude * motion.up
    interval = motion.sampling_interval
    ground = ground_displacement_since_first_time((along, up), interval, frame_times - first_sample_time)
    point, force = _contact_points_and_forces(trajectory, frame_times)
    return FilmPanel(
        *heading_and_outcome,
        max(falls, default=math.nan),
        _film_bodies_of_scene(trajectory, frame_times, ground),
        samples_from_time_zero(along, interval, first_sample_time),
        interval,
        left_and_right_bearings=(compass_bearing_text(azimuth + 180.0), compass_bearing_text(azimuth)),
        contact_positions_by_frame=point,
        contact_forces_over_weight=force,
        vertical_base_acceleration=None if up is None else samples_from_time_zero(up, interval, first_sample_time),
        ground_displacement_by_frame=ground,
        first_fall_time=min(falls, default=math.nan),
    )
