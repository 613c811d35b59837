"""From trajectories of a scene to a film of all its elements, and to the path of one of them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.figures.film import FRAME_INTERVAL, Body, Film, Panel, about_the_peak, frame_times
from overturning.figures.film_of_trajectory import compass_name

if TYPE_CHECKING:
    import xarray as xr


GROUND_SHOWN = 3.0
"""Half of the width to which a ground far wider than the picture is cut, as a multiple of the scene's height."""

FORCE_NOTE = "Contact forces: means over a sampling interval, over the weight of all stones that are free."
"""What the arrows of a film are."""


def scene_outcome(path: "xr.Dataset") -> str:
    """What the elements do, in the order in which they fall."""
    if path.attrs["status"] not in (0, 1):
        return "no outcome: the simulation is not valid"
    azimuth = path.attrs["azimuth_deg"]
    falls = sorted(
        (time, name, side)
        for time, name, side in zip(
            path.attrs["overturning_time"], path.attrs["free"], path.attrs["overturned"], strict=True
        )
        if side != 0
    )
    if not falls:
        highest = max(path.attrs["peak_rotation"], default=0.0)
        return f"everything stands (largest rotation {highest:.2f} α)"
    said = [
        f"{name} falls towards {compass_name(azimuth if side > 0 else azimuth + 180.0)} at {time:.2f} s"
        for time, name, side in falls
    ]
    return "; ".join(said)


def element_path(path: "xr.Dataset", name: str) -> "xr.Dataset":
    """The path of one element, with the variables that the path of a single block has.

    Parameters
    ----------
    path : xarray.Dataset
        From `dem.polygon.trajectory.scene_trajectory`.
    name : str
        A free element.

    Returns
    -------
    xarray.Dataset
        Over `time`: `rotation`, `x`, `z`, velocities, `base_slip` (of the middle of its lower side at rest, in the
        frame of the base) and `ground_acceleration`; heights count from where its lower side is at rest.
    """
    import xarray as xr

    one = path.sel(element=name)
    vertices = one["vertices"].to_numpy()
    low, width, height = (
        float(np.nanmin(vertices[:, 1])),
        float(np.nanmax(vertices[:, 0]) - np.nanmin(vertices[:, 0])),
        float(np.nanmax(vertices[:, 1]) - np.nanmin(vertices[:, 1])),
    )
    theta, x = one["rotation"].to_numpy(), one["x"].to_numpy()
    slip = x + low * np.sin(theta)
    index = path.attrs["free"].index(name)
    made = xr.Dataset(
        {key: ("time", one[key].to_numpy()) for key in ("rotation", "angular_velocity", "velocity_x", "velocity_z")},
        {"time": path["time"]},
        {key: value for key, value in path.attrs.items() if key not in ("free", "scene")},
    )
    made["x"] = ("time", x - x[0])
    made["z"] = ("time", one["z"].to_numpy() - float(one["z"][0]) + 0.5 * height)
    made["base_slip"] = ("time", slip - slip[0])
    made["ground_acceleration"] = path["ground_acceleration"]
    for key in ("overturned", "overturning_time", "peak_rotation"):
        made.attrs[key] = path.attrs[key][index]
    return made.assign_attrs(height=height, b_over_h=width / height)


def _moving(path: "xr.Dataset") -> tuple[float, float] | None:
    time = path["time"].to_numpy()
    poses = np.stack([path[name].to_numpy() for name in ("x", "z", "rotation")])
    away = np.minimum(np.abs(poses - poses[:, :1]), np.abs(poses - poses[:, -1:])).max(axis=(0, 2)) > 1e-3
    found = np.flatnonzero(away)
    return (float(time[found[0]]), float(time[found[-1]])) if found.size else None


def _bodies(path: "xr.Dataset", time: FloatArray) -> tuple[Body, ...]:
    clock = path["time"].to_numpy()
    vertices = path["vertices"].to_numpy()
    free = [index for index, kind in enumerate(path["kind"].to_numpy()) if kind == "free"]
    points = vertices[free] + np.stack([path["x"][0, free], path["z"][0, free]], axis=-1)[:, None, :]
    tall = float(np.nanmax(points[..., 1]) - np.nanmin(points[..., 1]))
    reach = GROUND_SHOWN * tall + float(np.abs(path["x"].to_numpy()[:, free]).max())
    bodies = []
    for index, name in enumerate(path["element"].to_numpy()):
        shape = vertices[index][np.isfinite(vertices[index, :, 0])]
        if index in free:
            pose = [np.interp(time, clock, path[key].to_numpy()[:, index]) for key in ("x", "z", "rotation")]
            bodies.append(Body(str(name), shape, np.stack(pose[:2], axis=1), pose[2]))
        else:
            place = np.array([[float(path["x"][0, index]), float(path["z"][0, index])]])
            if np.ptp(shape[:, 0]) > 2 * reach:  # the ground, cut to the picture
                shape = np.column_stack([np.clip(shape[:, 0], -reach, reach), shape[:, 1]])
                shape[:, 1] = np.maximum(shape[:, 1], shape[:, 1].max() - 0.4 * tall)
            bodies.append(Body(str(name), shape, place, np.zeros(1), free=False))
    return tuple(bodies)


def _forces(path: "xr.Dataset", time: FloatArray) -> tuple[FloatArray, FloatArray] | tuple[None, None]:
    """Places and forces of the contacts that ever carry one, over frames, in weights; none after the case has ended."""
    clock = path["time"].to_numpy()
    force, place = path["contact_force"].to_numpy() / path.attrs["weight"], path["contact_place"].to_numpy()
    ever = np.isfinite(place).any(axis=(0, 2))
    if not ever.any():
        return None, None
    force, place = _filled(force[:, ever]), _filled(place[:, ever])
    # The forces of the last sample up to each frame: between frames the player interpolates.
    at = np.clip(np.searchsorted(clock, time + 1e-9, side="right") - 1, 0, clock.size - 1)
    return place[at], np.where(time[:, None, None] <= clock[-1], force[at], 0.0)


def _filled(values: FloatArray) -> FloatArray:
    """Values over time in which what is missing is as before, or, at first, as soon as it is known."""
    known = np.isfinite(values)
    rows = np.arange(len(values)).reshape(-1, 1, 1)
    before = np.maximum.accumulate(np.where(known, rows, -1), axis=0)
    return np.take_along_axis(values, np.where(before >= 0, before, known.argmax(axis=0)), axis=0)


def film_of_scene(
    paths: Sequence["xr.Dataset"],
    accelerations: Sequence[FloatArray],
    sampling_interval: float,
    title: str,
    *,
    headings: Sequence[str] | None = None,
    note: str = "",
) -> Film:
    """A film of all elements of a scene.

    Parameters
    ----------
    paths : sequence of xarray.Dataset
        From `dem.polygon.trajectory.scene_trajectory`.
    accelerations, sampling_interval, title, headings, note
        As in `overturning.figures.film_of_trajectory.film_of`.

    Returns
    -------
    Film

    Raises
    ------
    ArgumentError
        If there is no trajectory.
    """
    if not paths:
        raise ArgumentError("paths: none; a film needs at least one trajectory")
    spans = [span for path in paths if (span := _moving(path)) is not None]
    if spans:
        first, last = min(span[0] for span in spans), max(span[1] for span in spans)
    else:
        first, last = about_the_peak(paths[0]["time"].to_numpy(), paths[0]["ground_acceleration"].to_numpy())
    time = frame_times(first, last)
    panels = []
    for index, (path, acceleration) in enumerate(zip(paths, accelerations, strict=True)):
        azimuth = float(path.attrs["azimuth_deg"])
        point, force = _forces(path, time)
        times = [value for value in path.attrs["overturning_time"] if np.isfinite(value)]
        panels.append(
            Panel(
                title=headings[index] if headings else compass_name(azimuth),
                outcome=scene_outcome(path),
                outcome_time=min(times, default=float("nan")),
                left=compass_name(azimuth + 180.0),
                right=compass_name(azimuth),
                bodies=_bodies(path, time),
                acceleration=np.asarray(acceleration, dtype=np.float64),
                sampling_interval=sampling_interval,
                force_point=point,
                force=force,
            )
        )
    return Film(title, float(time[0]), FRAME_INTERVAL, tuple(panels), note=f"{note} {FORCE_NOTE}".strip())
