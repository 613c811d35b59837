"""From trajectories of the gravestone scene to a film."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.figures.film import FRAME_INTERVAL, Body, Film, Panel, about_the_peak, frame_times
from overturning.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    import xarray as xr


INT8_MISSING = -128

FORCE_NOTE = "Contact forces: means over two sampling intervals, from the block's motion."
"""What the arrows of a film are."""


def compass_name(azimuth_deg: float) -> str:
    """An azimuth as it is written beside a film: N60°E, with no more digits than it has."""
    return f"N{round(azimuth_deg % 360.0, 2):g}°E"


def overturning_time(path: "xr.Dataset") -> float:
    """The last time abs(θ) passed arctan(B/H), s after the record's start; NaN where the block does not fall."""
    if path.attrs["overturned"] in (0, INT8_MISSING):
        return float("nan")
    beyond = np.abs(path["rotation"].to_numpy()) > np.arctan(path.attrs["b_over_h"])
    at = int(np.flatnonzero(~beyond)[-1]) + 1 if (~beyond).any() else 0
    return float(path["time"][min(at, beyond.size - 1)])


def outcome(path: "xr.Dataset") -> str:
    """What the block does, in a few words with a number."""
    side, azimuth = path.attrs["overturned"], path.attrs["azimuth_deg"]
    if side == INT8_MISSING or path.attrs["status"] not in (0, 1):
        return "no outcome: the simulation is not valid"
    if side == 0:
        return f"stands (largest rotation {path.attrs['peak_rotation']:.2f} α)"
    towards = compass_name(azimuth if side > 0 else azimuth + 180.0)
    return f"falls towards {towards} at {overturning_time(path):.2f} s"


def movement(path: "xr.Dataset") -> tuple[float, float] | None:
    """First and last time, s, at which the block rocks (by 0.5 % of α) or slides (by 0.5 mm from where it began or ends).

    None where it does neither.
    """
    theta, slip, time = (path[name].to_numpy() for name in ("rotation", "base_slip", "time"))
    away = np.minimum(np.abs(slip - slip[0]), np.abs(slip - slip[-1])) > 5e-4
    moving = np.flatnonzero((np.abs(theta) > 5e-3 * np.arctan(path.attrs["b_over_h"])) | away)
    return (float(time[moving[0]]), float(time[moving[-1]])) if moving.size else None


def window(paths: Sequence["xr.Dataset"]) -> tuple[float, float]:
    """Time worth showing, s: from the first movement of any trajectory to the last, or about the peak of the motion."""
    found = [times for path in paths if (times := movement(path)) is not None]
    if found:
        return min(first for first, _ in found), max(last for _, last in found)
    return about_the_peak(paths[0]["time"].to_numpy(), paths[0]["ground_acceleration"].to_numpy())


def _mean_rate(values: FloatArray, time: FloatArray) -> FloatArray:
    """Mean rate of change between the two neighbours of each sample (at the ends: between it and its neighbour)."""
    after, before = np.append(values[1:], values[-1]), np.append(values[0], values[:-1])
    span = np.append(time[1:], time[-1]) - np.append(time[0], time[:-1])
    return np.divide(after - before, span, out=np.zeros_like(values), where=span > 0)


def _mean(values: FloatArray, time: FloatArray) -> FloatArray:
    """Mean over the same span of something that is linear between samples."""
    pieces = 0.5 * (values[1:] + values[:-1]) * np.diff(time)
    return _mean_rate(np.concatenate([[0.0], np.cumsum(pieces)]), time)


def contact_forces(path: "xr.Dataset", upward_acceleration: FloatArray | float = 0.0) -> tuple[FloatArray, FloatArray]:
    """Places of the two lower corners and the forces there on the block, in weights.

    They are means over the time from the sample before to the sample after, and follow from the trajectory by the
    equations of motion: the sum is the change of momentum less the weight, F = m (Δv/Δt + ü_base + g). So an impact,
    which lasts a few milliseconds, shows as its impulse over that time, and since the contact's forces keep to the
    slider at every instant, so do their means. A corner that is up carries nothing; where both are down the moment
    I Δω/Δt = Σ r × f shares the force, both corners' being inclined alike.

    Parameters
    ----------
    path : xarray.Dataset
        From `dem.simulate.trajectory`.
    upward_acceleration : ndarray, shape (n,), or float
        Of the base at the times of the path, m/s².

    Returns
    -------
    point, force : ndarray, shape (n, 2, 2)
        Over time, corner (left, right), and (s, z).
    """
    theta, x, z, time = (path[name].to_numpy() for name in ("rotation", "x", "z", "time"))
    half = np.array([path.attrs["b_over_h"] * path.attrs["height"], path.attrs["height"]]) / 2
    cosine, sine = np.cos(theta), np.sin(theta)
    arm = np.empty((theta.size, 2, 2))
    for corner, side in enumerate((-1.0, 1.0)):
        s, up = side * half[0], -half[1]
        arm[:, corner] = np.stack([s * cosine + up * sine, up * cosine - s * sine], axis=1)
    lifted = np.broadcast_to(np.asarray(upward_acceleration, dtype=np.float64), time.shape)
    along = _mean_rate(path["velocity_x"].to_numpy(), time) + _mean(path["ground_acceleration"].to_numpy(), time)
    upward = _mean_rate(path["velocity_z"].to_numpy(), time) + STANDARD_GRAVITY + _mean(lifted, time)
    upward = np.maximum(upward, 0.0)  # in flight: the rounding of the difference
    inclination = np.divide(along, upward, out=np.zeros_like(along), where=upward > 1e-9)
    # Moment about the centre, clockwise, of a unit of normal force at each corner with its share of the horizontal one.
    lever = arm[:, :, 1] * inclination[:, None] - arm[:, :, 0]
    moment = _mean_rate(path["angular_velocity"].to_numpy(), time) * (half**2).sum() / 3.0
    apart = lever[:, 0] - lever[:, 1]
    left = np.divide(moment - upward * lever[:, 1], apart, out=np.zeros_like(moment), where=np.abs(apart) > 1e-12)
    down = np.stack([path["penetration_left"].to_numpy(), path["penetration_right"].to_numpy()]) > 0.0
    down[:, 1:-1] |= down[:, 2:] | down[:, :-2]
    left = np.where(down[0] & down[1], np.clip(left, 0.0, upward), np.where(down[0], upward, 0.0))
    right = np.where(down[0] | down[1], upward - left, 0.0)
    normal = np.stack([left, right], axis=1) / STANDARD_GRAVITY
    force = np.stack([normal * inclination[:, None], normal], axis=2)
    return np.stack([x, z], axis=1)[:, None, :] + arm, force


def _poses(path: "xr.Dataset") -> tuple[FloatArray, FloatArray]:
    """Times, and x, z and rotation then; at the end a block that falls goes on about its corner until it lies.

    The path ends with the last sample before 90°, which for a coarse record is some degrees earlier.
    """
    clock = path["time"].to_numpy()
    poses = np.stack([path[name].to_numpy() for name in ("x", "z", "rotation")], axis=1)
    side, speed = path.attrs["overturned"], abs(float(path["angular_velocity"][-1]))
    left = 0.5 * np.pi - abs(poses[-1, 2])
    if side in (0, INT8_MISSING) or left <= 0.0 or speed <= 0.0:
        return clock, poses
    x, _, theta = poses[-1]
    b, h = 0.5 * path.attrs["b_over_h"] * path.attrs["height"], 0.5 * path.attrs["height"]
    corner = x + side * b * np.cos(theta) - h * np.sin(theta)
    lying = [corner + side * h, b, side * 0.5 * np.pi]
    return np.append(clock, clock[-1] + left / speed), np.concatenate([poses, [lying]])


def film_of(
    paths: Sequence["xr.Dataset"],
    accelerations: Sequence[FloatArray],
    sampling_interval: float,
    title: str,
    *,
    headings: Sequence[str] | None = None,
    note: str = "",
    upward: FloatArray | None = None,
) -> Film:
    """A film of trajectories in step.

    Parameters
    ----------
    paths : sequence of xarray.Dataset
        From `dem.simulate.trajectory`.
    accelerations : sequence of ndarray
        The base's acceleration along the azimuth of each, m/s², from time 0.
    sampling_interval : float
        Of the accelerations, s.
    title : str
        Heading.
    headings : sequence of str, optional
        One per trajectory; the azimuth where not given.
    note : str
        Line below the film; what the contact forces are is added to it.
    upward : ndarray, optional
        The base's upward acceleration, m/s², from time 0; at rest where not given.

    Returns
    -------
    Film
        From shortly before the first movement to shortly after the last.

    Raises
    ------
    ArgumentError
        If there is no trajectory.
    """
    if not paths:
        raise ArgumentError("paths: none; a film needs at least one trajectory")
    time = frame_times(*window(paths))
    reach = 2.0 + max(float(np.abs(path["x"]).max()) + 2 * float(path.attrs["height"]) for path in paths)
    base = np.array([[-reach, -0.4], [reach, -0.4], [reach, 0.0], [-reach, 0.0]])
    panels = []
    for index, (path, acceleration) in enumerate(zip(paths, accelerations, strict=True)):
        clock, azimuth = path["time"].to_numpy(), float(path.attrs["azimuth_deg"])
        longer, poses = _poses(path)
        x, z, theta = (np.interp(time, longer, column) for column in poses.T)
        width, height = path.attrs["b_over_h"] * path.attrs["height"], path.attrs["height"]
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * np.array([width, height]) / 2
        up = 0.0 if upward is None else np.interp(clock, np.arange(upward.size) * sampling_interval, upward, right=0.0)
        point, force = contact_forces(path, up)
        last = int(np.searchsorted(time, clock[-1]))
        force = np.stack([np.interp(time, clock, column) for column in force.reshape(clock.size, 4).T], axis=1)
        force[last + 1 :] = 0.0  # the simulation ends at 90°, where the block hits the ground
        point = np.stack([np.interp(time, clock, column) for column in point.reshape(clock.size, 4).T], axis=1)
        panels.append(
            Panel(
                title=headings[index] if headings else compass_name(azimuth),
                outcome=outcome(path),
                outcome_time=overturning_time(path),
                left=compass_name(azimuth + 180.0),
                right=compass_name(azimuth),
                bodies=(
                    Body("base", base, np.zeros((1, 2)), np.zeros(1), free=False),
                    Body("block", corners, np.stack([x, z], axis=1), theta),
                ),
                acceleration=np.asarray(acceleration, dtype=np.float64),
                sampling_interval=sampling_interval,
                force_point=point.reshape(-1, 2, 2),
                force=force.reshape(-1, 2, 2),
            )
        )
    return Film(title, float(time[0]), FRAME_INTERVAL, tuple(panels), note=f"{note} {FORCE_NOTE}".strip())
