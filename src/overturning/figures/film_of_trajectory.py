"""Films made from trajectories of the elements of a 2-D scene or of a 3-D body."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from overturning.arrays import FloatArray
from overturning.errors import ArgumentError
from overturning.figures.film import FRAME_INTERVAL, Film, FilmBody, Panel, frame_times
from overturning.figures.style import compass_name
from overturning.model.status import Status
from overturning.motion.motion import Motion

if TYPE_CHECKING:
    import xarray as xr

GROUND_WIDTH_FACTOR = 3.0
"""Half-width to which a very wide ground is cut, as a multiple of the scene's height."""

MOVEMENT_TOLERANCE = 1e-3
"""Smallest distance of a pose from its start and from its end that counts as movement.

The unit is m for positions and rad for rotations; direction cosines and quaternions have no unit.
"""

MAX_EXTENSION = 0.5
"""Longest time, s, by which a path that ends just before a stone lies down is extended."""


def free_elements(path: "xr.Dataset") -> "xr.Dataset":
    """Return the part of a trajectory that belongs to its free elements."""
    return path.isel(element=path["kind"].to_numpy() == "free")


def heading_of(path: "xr.Dataset") -> str:
    """Return the heading of a panel: the azimuth of the motion, or the direction that a 3-D body faces."""
    return _display_of(path).heading.format(compass_name(float(path.attrs[_display_of(path).direction])))


def is_valid(path: "xr.Dataset") -> bool:
    """True if a trajectory has an outcome."""
    return int(path["status"]) in (Status.SIMULATED, Status.AT_REST)


def outcome(path: "xr.Dataset") -> str:
    """Return the outcome of a trajectory as a sentence without a full stop."""
    if not is_valid(path):
        return "no outcome: the simulation is not valid"
    return _display_of(path).outcome(path)


def movement_interval(path: "xr.Dataset") -> tuple[float, float] | None:
    """Return the first and last time, s, at which a free body is away from both its first and its last pose.

    None if nothing moves.
    """
    poses, time = _display_of(path).poses(path), path["time"].to_numpy()
    away = np.minimum(np.abs(poses - poses[:1]), np.abs(poses - poses[-1:])).max(axis=1) > MOVEMENT_TOLERANCE
    moving = np.flatnonzero(away)
    return (float(time[moving[0]]), float(time[moving[-1]])) if moving.size else None


def window(paths: Sequence["xr.Dataset"]) -> tuple[float, float]:
    """Return start and end of the time to show, s: from the first movement in any trajectory to the last.

    If nothing moves: 3 s before to 3 s after the peak of the motion.
    """
    spans = [span for path in paths if (span := movement_interval(path)) is not None]
    if spans:
        return min(first for first, _ in spans), max(last for _, last in spans)
    ground, time = paths[0]["ground_acceleration"].to_numpy(), paths[0]["time"].to_numpy()
    size = np.hypot(*ground[:, :2].T) if ground.ndim > 1 else np.abs(ground)
    peak = float(time[int(size.argmax())])
    return max(0.0, peak - 3.0), min(float(time[-1]), peak + 3.0)


def film_of(paths: Sequence["xr.Dataset"], motion: Motion, title: str, *, note: str = "") -> Film:
    """Return a film that plays trajectories synchronously, from shortly before the first movement to after the last.

    Each trajectory was simulated under the motion times its own amplitude. `note` is the line below the film; hints on
    how to use the film are appended to it. Raises an ArgumentError if `paths` is empty.
    """
    if not paths:
        raise ArgumentError("paths: none given; a film needs at least one trajectory")
    time = frame_times(*window(paths))
    panels = tuple(_display_of(path).panel(path, motion, time, (heading_of(path), outcome(path))) for path in paths)
    return Film(title, float(time[0]), FRAME_INTERVAL, panels, note=f"{note} {_display_of(paths[0]).note}".strip())


def _frames(time: FloatArray, clock: FloatArray, values: FloatArray) -> FloatArray:
    """Interpolate columns sampled at the times `clock` to the times of a film's frames."""
    return np.stack([np.interp(time, clock, column) for column in values.T], axis=1)


def _plane_outcome(path: "xr.Dataset") -> str:
    """Return the number of elements that fall, and for each its name, direction and time, in order of time.

    The name is left out if the scene has only one free element.
    """
    free, azimuth = free_elements(path), path.attrs["azimuth_deg"]
    several = free.sizes["element"] > 1
    names, sides, times = (free[name].to_numpy().tolist() for name in ("element", "overturned", "overturning_time"))
    falls = sorted((time, name, side) for time, name, side in zip(times, names, sides, strict=True) if abs(side) == 1)
    if not falls:
        return f"{'everything ' if several else ''}stands (largest rotation {_largest_rotation(free)})"
    head = f"{len(falls)} of {len(names)} fall: " if several else ""
    return head + "; ".join(
        f"{name + ' ' if several else ''}falls towards {compass_name(azimuth if side > 0 else azimuth + 180.0)} at "
        f"{time:.2f} s"
        for time, name, side in falls
    )


def _largest_rotation(free: "xr.Dataset") -> str:
    """Return the largest rotation as text, in units of α, or in degrees for elements without α (leaning stones)."""
    peak, has = free["peak_rotation"].to_numpy(), np.isfinite(free["critical_angle"].to_numpy())
    texts = [f"{peak[has].max():.2f} α"] if has.any() else []
    if not has.all():
        texts.append(f"{peak[~has].max():.2g}°{' for elements without α' if has.any() else ''}")
    return ", ".join(texts)


def _plane_poses(path: "xr.Dataset") -> FloatArray:
    """Return positions and rotations of the free elements, shape (time, 3 × elements)."""
    free = free_elements(path)
    return np.concatenate(
        [free[name].transpose("time", "element").to_numpy() for name in ("x", "z", "rotation")], axis=1
    )


def _extend_to_lying(path: "xr.Dataset", index: int) -> tuple[FloatArray, FloatArray]:
    """Return the times and poses (x, z, rotation) of an element, extended until it lies on the ground.

    The path of a single block ends at the last sample before it has fallen, which for a coarse record is some degrees
    too early; one pose is appended in which the block has turned about its corner until it lies.
    """
    one, time = path.isel(element=index), path["time"].to_numpy()
    poses = np.stack([one[name].to_numpy() for name in ("x", "z", "rotation")], axis=1)
    side, speed = float(one["overturned"]), abs(float(one["angular_velocity"][-1]))
    x, _, angle = poses[-1]
    if path.sizes["element"] != 2 or abs(side) != 1:
        return time, poses
    fallen = float(one["fallen_angle"].sel(side=side))
    left = fallen - abs(angle)
    if not 0.0 < left < MAX_EXTENSION * speed:
        return time, poses
    level = float((path["z"][0] + path["vertices"][..., 1].max("vertex")).isel(element=1 - index))
    p, q = one["vertices"].to_numpy()[np.isfinite(one["vertices"].to_numpy()[:, 0])].T
    lowest = int(np.argmin(q * np.cos(angle) - p * np.sin(angle)))
    corner = x + p[lowest] * np.cos(angle) + q[lowest] * np.sin(angle)
    lies = side * fallen
    c, s = np.cos(lies), np.sin(lies)
    lying = [corner - (p[lowest] * c + q[lowest] * s), level + (p[lowest] * s - q[lowest] * c), lies]
    return np.append(time, time[-1] + left / speed), np.concatenate([poses, [lying]])


def _bodies(path: "xr.Dataset", time: FloatArray) -> tuple[FilmBody, ...]:
    vertices, x = path["vertices"].to_numpy(), path["x"].to_numpy()
    free = np.flatnonzero(path["kind"].to_numpy() == "free")
    levels = vertices[free, :, 1] + path["z"].to_numpy()[0, free, None]
    tall = float(np.nanmax(levels) - np.nanmin(levels))
    reach = GROUND_WIDTH_FACTOR * tall + float(np.abs(x[:, free]).max())
    bodies = []
    for index, name in enumerate(path["element"].to_numpy()):
        shape = vertices[index][np.isfinite(vertices[index, :, 0])]
        if index in free:
            clock, poses = _extend_to_lying(path, index)
            frames = _frames(time, clock, poses)
            bodies.append(FilmBody(str(name), shape, frames[:, :2], frames[:, 2]))
        else:
            place = np.array([[x[0, index], float(path["z"][0, index])]])
            if np.ptp(shape[:, 0]) > 2 * reach:  # cut the ground to the picture
                shape = np.column_stack([np.clip(shape[:, 0], -reach, reach), shape[:, 1]])
                shape[:, 1] = np.maximum(shape[:, 1], shape[:, 1].max() - 0.4 * tall)
            bodies.append(FilmBody(str(name), shape, place, np.zeros(1), free=False))
    return tuple(bodies)


def _forces(path: "xr.Dataset", time: FloatArray) -> tuple[FloatArray, FloatArray] | tuple[None, None]:
    """Return positions (m) and forces (in units of the weight) over frames of all contacts that carry a force.

    Forces are zero after the end of the case. (None, None) if no contact carries a force.
    """
    clock = path["time"].to_numpy()
    force, place = path["contact_force"].to_numpy() / path.attrs["weight"], path["contact_place"].to_numpy()
    ever = np.isfinite(place).any(axis=(0, 2))
    if not ever.any():
        return None, None
    force, place = _fill_missing(force[:, ever]), _fill_missing(place[:, ever])
    # Use the last sample up to each frame; the player interpolates between frames.
    at = np.clip(np.searchsorted(clock, time + 1e-9, side="right") - 1, 0, clock.size - 1)
    return place[at], np.where(time[:, None, None] <= clock[-1], force[at], 0.0)


def _fill_missing(values: FloatArray) -> FloatArray:
    """Replace missing values by the last known value before them, or at the start by the first known value."""
    known = np.isfinite(values)
    rows = np.arange(len(values)).reshape(-1, 1, 1)
    before = np.maximum.accumulate(np.where(known, rows, -1), axis=0)
    return np.take_along_axis(values, np.where(before >= 0, before, known.argmax(axis=0)), axis=0)


def _plane_panel(path: "xr.Dataset", motion: Motion, time: FloatArray, texts: tuple[str, str]) -> Panel:
    azimuth, times = float(path.attrs["azimuth_deg"]), path["overturning_time"].to_numpy()
    first = float(min(times[np.isfinite(times)], default=np.nan))
    moved = float(path.attrs["amplitude"]) * motion.along(azimuth)
    sides = (compass_name(azimuth + 180.0), compass_name(azimuth))
    return Panel(*texts, first, _bodies(path, time), moved, motion.sampling_interval, sides, *_forces(path, time))


def _space_outcome(path: "xr.Dataset") -> str:
    """Return the outcome of a 3-D body as a sentence without a full stop."""
    if float(path["overturned"]) == 1:
        towards = compass_name(round(float(path["fall_azimuth"])))
        return f"falls towards {towards} at {float(path['overturning_time']):.2f} s"
    tilt, twist = float(path["peak_tilt"]), float(path["residual_twist"])
    slip = 100.0 * float(np.hypot(path["residual_slip_north"], path["residual_slip_east"]))
    side = "clockwise" if twist >= 0 else "anticlockwise"
    # A cylinder may roll for minutes: its place of rest is not known at the end of the path.
    tilt_at_end = np.hypot(float(path["tilt_north"][-1]), float(path["tilt_east"][-1]))
    turning = max(tilt_at_end, float(np.abs(path["angular_velocity"][-1]).max())) > MOVEMENT_TOLERANCE
    still = ", where it still rocks or rolls" if turning else ""
    moved = f"turned {abs(twist):.1f}° {side}, slipped {slip:.1f} cm by the end{still}"
    return f"stands (largest tilt {tilt:.1f}°); {moved}"


def _space_poses(path: "xr.Dataset") -> FloatArray:
    """Return tilt, quaternion and position, shape (time, 9)."""
    return np.column_stack([path["tilt_north"], path["tilt_east"], path["quaternion"], path["place"]])


def _space_panel(path: "xr.Dataset", motion: Motion, time: FloatArray, texts: tuple[str, str]) -> Panel:
    clock, outline = path["time"].to_numpy(), path["outline"].to_numpy()
    position, quaternion = (_frames(time, clock, path[name].to_numpy()) for name in ("place", "quaternion"))
    body = FilmBody("body", outline, position, quaternion, faces=faces_of(outline))
    moved = float(path.attrs["amplitude"]) * motion.horizontal
    return Panel(*texts, float(path["overturning_time"]), (body,), moved, motion.sampling_interval)


def faces_of(corners: FloatArray) -> tuple[tuple[int, ...], ...]:
    """Return the faces of the convex hull of some corners.

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


class _TrajectoryDisplay(NamedTuple):
    """Functions and texts that show 2-D or 3-D trajectories."""

    direction: str  # name of the attribute with the direction, degrees
    heading: str  # format of a panel's heading, with the name of the direction
    outcome: Callable[["xr.Dataset"], str]  # sentence for the outcome of a valid simulation
    poses: Callable[["xr.Dataset"], FloatArray]  # poses that show whether anything moves, shape (time, n)
    panel: Callable[["xr.Dataset", Motion, FloatArray, tuple[str, str]], Panel]  # panel at the times of the frames
    note: str  # hint below the film


_PLANE: Final = _TrajectoryDisplay(
    "azimuth_deg", "{}", _plane_outcome, _plane_poses, _plane_panel,
    "Contact forces: means over a sampling interval, over the weight of all stones that are free.",
)  # fmt: skip
_SPACE: Final = _TrajectoryDisplay(
    "orientation_deg", "facing {}", _space_outcome, _space_poses, _space_panel, "Drag to turn the view."
)


def _display_of(path: "xr.Dataset") -> _TrajectoryDisplay:
    """Return the functions and texts that show a trajectory."""
    return _SPACE if "quaternion" in path else _PLANE
