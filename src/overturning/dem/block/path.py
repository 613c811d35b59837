"""The path of a single block as that of a scene, with the forces at its lower corners, which follow from its motion."""

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.path import PlanePath
from overturning.model.cases import Cases
from overturning.model.geometry import place_elements
from overturning.model.scene import Scene
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY


def block_path(scene: Scene, motion: Motion, cases: Cases, rows: NDArray[np.void], critical: float) -> PlanePath:
    """The path of a case's block, of tipping angle α, and its ground, from the kernel's rows with the rest before."""
    azimuth, height, ratio, amplitude = (
        float(getattr(cases, name)[0]) for name in ("azimuth_deg", "height", "b_over_h", "amplitude")
    )
    placed = place_elements(scene, height, ratio)
    ground, block = placed
    time = rows["time"]
    poses = np.zeros((len(rows), 2, 6))
    poses[:, 0, :2] = ground.x, ground.z
    poses[:, 1] = np.stack([rows[name] for name in ("x", "z", "angle", "vx", "vz", "vw")], axis=1)
    along, lift = (
        _mean_between(time, amplitude * values, motion.sampling_interval)
        for values in (motion.along(azimuth), np.zeros(1) if motion.up is None else motion.up)
    )
    point, force = corner_forces(time, poses[:, 1], along, lift, np.array([ratio * height, height]) / 2)
    # The kernel's origin is the middle of the ground's upper side.
    origin = np.array([ground.x, float(ground.points[:, 1].max())])
    poses[:, 1, :2] += origin
    names = (block.element.name, ground.element.name)
    return PlanePath(
        scene=scene,
        placed=placed,
        critical=np.array([np.nan, critical]),
        time=time,
        ground=rows["ground"],
        poses=poses,
        force=force * block.mass,
        place=point + origin,
        contacts=[names, names],
    )


def corner_forces(
    time: FloatArray, poses: FloatArray, ground: FloatArray, lift: FloatArray, half: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Where the lower corners are, and the mean forces there from each row to the next, per unit of mass.

    They follow from the path by the equations of motion: the sum is the change of momentum less the weight,
    F/m = Δv/Δt + ü_base + g. So an impact, which lasts a few milliseconds, shows as its impulse over the time to the
    next row, and since the contact's forces keep to the slider at every instant, so do their means. A corner that is up
    carries nothing; where both are down the moment I Δω/Δt = Σ r × f shares the force, both corners' being
    inclined alike.

    The block's `poses` have the shape (rows, 6), z from the ground on; `ground` and `lift`, shape (rows − 1,), are
    the mean accelerations of the base from each row to the next, `half` is (B/2, H/2). Results have the shape
    (rows, 2, 2): over time, corner (left, right) and (x, z), m and m/s², NaN where the corner is up; the last row
    repeats the one before it.
    """
    x, z, angle, vx, vz, vw = poses.T
    cosine, sine = np.cos(angle), np.sin(angle)
    arm = np.stack(
        [np.stack([side * half[0] * cosine - half[1] * sine, -half[1] * cosine - side * half[0] * sine], axis=1)
         for side in (-1.0, 1.0)], axis=1,
    )  # fmt: skip
    along = _rate(vx, time) + ground
    upward = np.maximum(_rate(vz, time) + STANDARD_GRAVITY + lift, 0.0)  # 0 in flight: the rounding of the difference
    inclination = np.divide(along, upward, out=np.zeros_like(along), where=upward > 1e-9)
    down = z[:, None] + arm[:, :, 1] < 0.0
    down, arm = down[1:] | down[:-1], _mean(arm)
    # Moment about the centre, clockwise, of a unit of normal force at each corner with its share of the horizontal one.
    lever = arm[:, :, 1] * inclination[:, None] - arm[:, :, 0]
    moment = _rate(vw, time) * (half**2).sum() / 3.0
    apart = lever[:, 0] - lever[:, 1]
    left = np.divide(moment - upward * lever[:, 1], apart, out=np.zeros_like(moment), where=np.abs(apart) > 1e-12)
    left = np.where(down[:, 0] & down[:, 1], np.clip(left, 0.0, upward), np.where(down[:, 0], upward, 0.0))
    right = np.where(down.any(axis=1), upward - left, 0.0)
    normal = np.stack([left, right], axis=1)
    force = np.stack([normal * inclination[:, None], normal], axis=2)
    point = np.where(down[:, :, None], _mean(np.stack([x, z], axis=1))[:, None, :] + arm, np.nan)
    return tuple(np.concatenate([values, values[-1:]]) for values in (point, force))  # type: ignore[return-value]


def _rate(values: FloatArray, time: FloatArray) -> FloatArray:
    """Mean rate of change from each row to the next; 0 where no time passes."""
    span = np.diff(time)
    return np.divide(np.diff(values), span, out=np.zeros_like(span), where=span > 0)


def _mean(values: FloatArray) -> FloatArray:
    """Mean from each row to the next of what is linear between them."""
    return np.asarray(0.5 * (values[1:] + values[:-1]))


def _mean_between(time: FloatArray, acceleration: FloatArray, interval: float) -> FloatArray:
    """Mean from each time to the next of an acceleration that is linear between its samples, and 0 after the last."""
    padded = np.concatenate([acceleration, np.zeros(2)])
    velocity = np.concatenate([[0.0], np.cumsum(_mean(padded))]) * interval
    index = np.minimum((time / interval + 1e-9).astype(np.int64), acceleration.size)
    past = np.minimum(time - index * interval, interval)
    slope = (padded[index + 1] - padded[index]) / interval
    return _rate(velocity[index] + (padded[index] + 0.5 * slope * past) * past, time)
