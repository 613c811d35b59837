"""From trajectories of the gravestone scene to a film."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from overturning.errors import ArgumentError
from overturning.figures.film import FRAME_INTERVAL, LEAD_IN, LINGER, Body, Film, Panel
from overturning.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    import xarray as xr

FloatArray = NDArray[np.float64]

INT8_MISSING = -128


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
    path = paths[0]
    peak = float(path["time"][int(np.abs(path["ground_acceleration"].to_numpy()).argmax())])
    return max(0.0, peak - 3.0), min(float(path["time"][-1]), peak + 3.0)


def contact_forces(path: "xr.Dataset", upward_acceleration: FloatArray | float = 0.0) -> tuple[FloatArray, FloatArray]:
    """Places of the two lower corners and the forces there on the block, in weights, averaged over a sample.

    The resultant follows from the motion, F = m(ü + ü_base) + m g; it is shared between the corners in proportion to their
    penetration, which is what equal springs do.

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
    theta, x, z = (path[name].to_numpy() for name in ("rotation", "x", "z"))
    time = path["time"].to_numpy()
    half = np.array([path.attrs["b_over_h"] * path.attrs["height"], path.attrs["height"]]) / 2
    cosine, sine = np.cos(theta), np.sin(theta)
    point = np.empty((theta.size, 2, 2))
    for corner, side in enumerate((-1.0, 1.0)):
        s, up = side * half[0], -half[1]
        point[:, corner, 0] = x + s * cosine + up * sine
        point[:, corner, 1] = z - s * sine + up * cosine
    along = np.gradient(path["velocity_x"].to_numpy(), time) + path["ground_acceleration"].to_numpy()
    upward = np.gradient(path["velocity_z"].to_numpy(), time) + STANDARD_GRAVITY + upward_acceleration
    depth = np.stack([path["penetration_left"].to_numpy(), path["penetration_right"].to_numpy()], axis=1).clip(0.0)
    total = depth.sum(axis=1, keepdims=True)
    share = np.divide(depth, total, out=np.zeros_like(depth), where=total > 0)
    upward = np.maximum(upward, 0.0)  # a contact pushes, it never pulls
    resultant = np.stack([along, upward], axis=1) / STANDARD_GRAVITY
    return point, share[:, :, None] * resultant[:, None, :]


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
        Line below the film.
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
    first, last_movement = window(paths)
    start = max(0.0, np.floor((first - LEAD_IN) / FRAME_INTERVAL) * FRAME_INTERVAL)
    end = last_movement + LINGER
    time = start + FRAME_INTERVAL * np.arange(int(np.ceil((end - start) / FRAME_INTERVAL)) + 1)
    reach = 2.0 + max(float(np.abs(path["x"]).max()) + 2 * float(path.attrs["height"]) for path in paths)
    base = np.array([[-reach, -0.4], [reach, -0.4], [reach, 0.0], [-reach, 0.0]])
    panels = []
    for index, (path, acceleration) in enumerate(zip(paths, accelerations, strict=True)):
        clock, azimuth = path["time"].to_numpy(), float(path.attrs["azimuth_deg"])
        x, z, theta = (np.interp(time, clock, path[name].to_numpy()) for name in ("x", "z", "rotation"))
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
    return Film(title, float(start), FRAME_INTERVAL, tuple(panels), note=note)
