"""Trajectory of a single block in the form of a scene, with the forces at its lower corners derived from its motion."""

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.path import PlanarSceneTrajectory
from overturning.model.cases import Cases
from overturning.model.geometry import scale_and_place_elements
from overturning.model.scene import Scene
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY


def planar_trajectory_of_block(
    scene: Scene, motion: Motion, single_case: Cases, trajectory_rows: NDArray[np.void], critical_angle_rad: float
) -> PlanarSceneTrajectory:
    """Convert the trajectory rows of a single block to a `PlanarSceneTrajectory` of block and ground.

    `single_case` has one case; `critical_angle_rad` is α, rad.
    """
    azimuth, height, ratio, amplitude = (
        float(getattr(single_case, name)[0]) for name in ("azimuth_deg", "height", "b_over_h", "amplitude")
    )
    placed = scale_and_place_elements(scene, height, ratio)
    ground, block = placed
    time = trajectory_rows["time"]
    poses = np.zeros((len(trajectory_rows), 2, 6))
    poses[:, 0, :2] = ground.centre_of_mass_x, ground.centre_of_mass_z
    poses[:, 1] = np.stack(
        [
            trajectory_rows[name]
            for name in ("centre_x", "centre_z", "angle", "centre_vx", "centre_vz", "angular_velocity")
        ],
        axis=1,
    )
    along, lift = (
        _mean_acceleration_between_times(time, amplitude * values, motion.sampling_interval)
        for values in (motion.acceleration_along(azimuth), np.zeros(1) if motion.up is None else motion.up)
    )
    point, force = mean_corner_positions_and_forces_per_mass(
        time, poses[:, 1], along, lift, np.array([ratio * height, height]) / 2
    )
    # The origin of the kernel is the middle of the upper side of the ground.
    origin = np.array([ground.centre_of_mass_x, float(ground.vertices_in_scene[:, 1].max())])
    poses[:, 1, :2] += origin
    names = (block.element.name, ground.element.name)
    return PlanarSceneTrajectory(
        scene=scene,
        placed_elements=placed,
        critical_angles_by_free_element=np.array([np.nan, critical_angle_rad]),
        time=time,
        base_acceleration_towards_azimuth=trajectory_rows["ground_acceleration"],
        poses_and_rates=poses,
        mean_contact_forces_until_next_row=force * block.mass,
        contact_force_points=point + origin,
        contact_element_names=[names, names],
    )


def mean_corner_positions_and_forces_per_mass(
    row_times_s: FloatArray,
    pose_and_rates_by_row: FloatArray,
    mean_base_acceleration_x_between_rows_m_s2: FloatArray,
    mean_base_acceleration_z_between_rows_m_s2: FloatArray,
    half_width_and_half_height_m: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Compute mean positions of a block's lower corners and mean contact forces between successive output times.

    The forces per mass follow from the equations of motion. Their sum is F/m = Δv/Δt + ü_base + g. The force of an
    impact, which lasts a few milliseconds, is thus its impulse divided by the time between two rows. The forces obey
    the friction limit at every time, and so do their means. A corner in the air carries no force. If both corners
    touch, their forces have the same inclination, and follow from the moment I Δω/Δt = Σ r × f.

    Parameters
    ----------
    row_times_s : ndarray
        Time of each row, s, shape (rows,).
    pose_and_rates_by_row : ndarray
        x, z above the ground (m), rotation (rad) and their rates, shape (rows, 6).
    mean_base_acceleration_x_between_rows_m_s2, mean_base_acceleration_z_between_rows_m_s2 : ndarray
        Mean horizontal and vertical acceleration of the base between two rows, m/s², shape (rows − 1,).
    half_width_and_half_height_m : ndarray
        B/2 and H/2, m, shape (2,).

    Returns
    -------
    tuple of ndarray
        Positions (m) and forces (m/s²) by time, corner (left, right) and component (x, z), shape (rows, 2, 2). The
        position of a corner in the air is NaN. The last row repeats the one before it.
    """
    x, z, angle, vx, vz, vw = pose_and_rates_by_row.T
    cosine, sine = np.cos(angle), np.sin(angle)
    arm = np.stack(
        [np.stack([side * half_width_and_half_height_m[0] * cosine - half_width_and_half_height_m[1] * sine,
                   -half_width_and_half_height_m[1] * cosine - side * half_width_and_half_height_m[0] * sine], axis=1)
         for side in (-1.0, 1.0)], axis=1,
    )  # fmt: skip
    along = _mean_rate_between_successive_times(vx, row_times_s) + mean_base_acceleration_x_between_rows_m_s2
    # In flight the difference is zero except for rounding, which may be negative.
    upward = np.maximum(
        _mean_rate_between_successive_times(vz, row_times_s)
        + STANDARD_GRAVITY
        + mean_base_acceleration_z_between_rows_m_s2,
        0.0,
    )
    inclination = np.divide(along, upward, out=np.zeros_like(along), where=upward > 1e-9)
    down = z[:, None] + arm[:, :, 1] < 0.0
    down, arm = down[1:] | down[:-1], _mean_of_successive_rows(arm)
    # Clockwise moment about the centre per unit normal force at each corner, including the horizontal force.
    lever = arm[:, :, 1] * inclination[:, None] - arm[:, :, 0]
    moment = _mean_rate_between_successive_times(vw, row_times_s) * (half_width_and_half_height_m**2).sum() / 3.0
    apart = lever[:, 0] - lever[:, 1]
    left = np.divide(moment - upward * lever[:, 1], apart, out=np.zeros_like(moment), where=np.abs(apart) > 1e-12)
    left = np.where(down[:, 0] & down[:, 1], np.clip(left, 0.0, upward), np.where(down[:, 0], upward, 0.0))
    right = np.where(down.any(axis=1), upward - left, 0.0)
    normal = np.stack([left, right], axis=1)
    force = np.stack([normal * inclination[:, None], normal], axis=2)
    point = np.where(down[:, :, None], _mean_of_successive_rows(np.stack([x, z], axis=1))[:, None, :] + arm, np.nan)
    return tuple(np.concatenate([values, values[-1:]]) for values in (point, force))  # type: ignore[return-value]


def _mean_rate_between_successive_times(quantity_by_row: FloatArray, row_times_s: FloatArray) -> FloatArray:
    """Return the mean rate of change of a quantity between successive output times; 0 between equal times."""
    span = np.diff(row_times_s)
    return np.divide(np.diff(quantity_by_row), span, out=np.zeros_like(span), where=span > 0)


def _mean_of_successive_rows(quantity_by_row: FloatArray) -> FloatArray:
    """Return the mean of each two successive rows of a quantity that varies linearly between them."""
    return np.asarray(0.5 * (quantity_by_row[1:] + quantity_by_row[:-1]))


def _mean_acceleration_between_times(
    row_times_s: FloatArray, acceleration_by_sample_m_s2: FloatArray, sampling_interval: float
) -> FloatArray:
    """Return the mean of the base acceleration, m/s², over the time between successive `row_times_s`.

    `acceleration_by_sample_m_s2` holds a value for each sample; it is linear between samples and 0 after the record.
    """
    padded = np.concatenate([acceleration_by_sample_m_s2, np.zeros(2)])
    velocity = np.concatenate([[0.0], np.cumsum(_mean_of_successive_rows(padded))]) * sampling_interval
    index = np.minimum((row_times_s / sampling_interval + 1e-9).astype(np.int64), acceleration_by_sample_m_s2.size)
    past = np.minimum(row_times_s - index * sampling_interval, sampling_interval)
    slope = (padded[index + 1] - padded[index]) / sampling_interval
    return _mean_rate_between_successive_times(
        velocity[index] + (padded[index] + 0.5 * slope * past) * past, row_times_s
    )
