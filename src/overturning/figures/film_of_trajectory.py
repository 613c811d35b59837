"""From trajectories, of the elements of a scene or of a body in space, to a film."""

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

GROUND_SHOWN = 3.0
"""Half of the width to which a ground far wider than the picture is cut, as a multiple of the scene's height."""

MOVED = 1e-3
"""What moves is so far from where it began and from where it ends: m, rad, and parts of a direction or quaternion."""

LAST_TURN = 0.5
"""A path that ends with a stone about to lie down goes on while the rest of the turn takes no longer than this, s."""


def free_elements(path: "xr.Dataset") -> "xr.Dataset":
    """The part of a trajectory that is of its free elements."""
    return path.isel(element=path["kind"].to_numpy() == "free")


def heading_of(path: "xr.Dataset") -> str:
    """The azimuth of the motion, or what a body in space faces."""
    return _showing(path).heading.format(compass_name(float(path.attrs[_showing(path).direction])))


def is_valid(path: "xr.Dataset") -> bool:
    """Whether a trajectory has an outcome."""
    return int(path["status"]) in (Status.SIMULATED, Status.AT_REST)


def outcome(path: "xr.Dataset") -> str:
    """What happens in a trajectory, in a sentence without its end."""
    if not is_valid(path):
        return "no outcome: the simulation is not valid"
    return _showing(path).outcome(path)


def movement(path: "xr.Dataset") -> tuple[float, float] | None:
    """First and last time, s, at which anything free is away from where it began and where it ends; None if never."""
    poses, time = _showing(path).poses(path), path["time"].to_numpy()
    away = np.minimum(np.abs(poses - poses[:1]), np.abs(poses - poses[-1:])).max(axis=1) > MOVED
    moving = np.flatnonzero(away)
    return (float(time[moving[0]]), float(time[moving[-1]])) if moving.size else None


def window(paths: Sequence["xr.Dataset"]) -> tuple[float, float]:
    """Time worth showing, s: from the first movement of any trajectory to the last, or 3 s about the motion's peak."""
    spans = [span for path in paths if (span := movement(path)) is not None]
    if spans:
        return min(first for first, _ in spans), max(last for _, last in spans)
    ground, time = paths[0]["ground_acceleration"].to_numpy(), paths[0]["time"].to_numpy()
    size = np.hypot(*ground[:, :2].T) if ground.ndim > 1 else np.abs(ground)
    peak = float(time[int(size.argmax())])
    return max(0.0, peak - 3.0), min(float(time[-1]), peak + 3.0)


def film_of(paths: Sequence["xr.Dataset"], motion: Motion, title: str, *, note: str = "") -> Film:
    """A film of trajectories in step, from shortly before the first movement to shortly after the last.

    All are under the motion, times the amplitude of each. What can be done with the film is added to the `note`, the
    line below it. An ArgumentError where there is no trajectory.
    """
    if not paths:
        raise ArgumentError("paths: none; a film needs at least one trajectory")
    time = frame_times(*window(paths))
    panels = tuple(_showing(path).panel(path, motion, time, (heading_of(path), outcome(path))) for path in paths)
    return Film(title, float(time[0]), FRAME_INTERVAL, panels, note=f"{note} {_showing(paths[0]).note}".strip())


def _frames(time: FloatArray, clock: FloatArray, values: FloatArray) -> FloatArray:
    """Columns over a clock at the times of a film's frames."""
    return np.stack([np.interp(time, clock, column) for column in values.T], axis=1)


def _plane_outcome(path: "xr.Dataset") -> str:
    """How many elements fall and which, in the order in which they do; a single one goes without its name."""
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
    """In parts of α; in degrees of those that have none, as an arch stone or one that leans."""
    peak, has = free["peak_rotation"].to_numpy(), np.isfinite(free["critical_angle"].to_numpy())
    texts = [f"{peak[has].max():.2f} α"] if has.any() else []
    if not has.all():
        texts.append(f"{peak[~has].max():.2g}°{' of what has no α' if has.any() else ''}")
    return ", ".join(texts)


def _plane_poses(path: "xr.Dataset") -> FloatArray:
    """Places and rotations of the free elements, shape (time, 3 elements)."""
    free = free_elements(path)
    return np.concatenate(
        [free[name].transpose("time", "element").to_numpy() for name in ("x", "z", "rotation")], axis=1
    )


def _until_it_lies(path: "xr.Dataset", index: int) -> tuple[FloatArray, FloatArray]:
    """Times, and x, z and rotation of an element then.

    The path of a single block ends with the last sample before it has fallen, which for a coarse record is some degrees
    earlier; at the end it goes on about its corner until it lies.
    """
    one, time = path.isel(element=index), path["time"].to_numpy()
    poses = np.stack([one[name].to_numpy() for name in ("x", "z", "rotation")], axis=1)
    side, speed = float(one["overturned"]), abs(float(one["angular_velocity"][-1]))
    x, _, angle = poses[-1]
    if path.sizes["element"] != 2 or abs(side) != 1:
        return time, poses
    fallen = float(one["fallen_angle"].sel(side=side))
    left = fallen - abs(angle)
    if not 0.0 < left < LAST_TURN * speed:
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
    reach = GROUND_SHOWN * tall + float(np.abs(x[:, free]).max())
    bodies = []
    for index, name in enumerate(path["element"].to_numpy()):
        shape = vertices[index][np.isfinite(vertices[index, :, 0])]
        if index in free:
            clock, poses = _until_it_lies(path, index)
            frames = _frames(time, clock, poses)
            bodies.append(FilmBody(str(name), shape, frames[:, :2], frames[:, 2]))
        else:
            place = np.array([[x[0, index], float(path["z"][0, index])]])
            if np.ptp(shape[:, 0]) > 2 * reach:  # the ground, cut to the picture
                shape = np.column_stack([np.clip(shape[:, 0], -reach, reach), shape[:, 1]])
                shape[:, 1] = np.maximum(shape[:, 1], shape[:, 1].max() - 0.4 * tall)
            bodies.append(FilmBody(str(name), shape, place, np.zeros(1), free=False))
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


def _plane_panel(path: "xr.Dataset", motion: Motion, time: FloatArray, texts: tuple[str, str]) -> Panel:
    azimuth, times = float(path.attrs["azimuth_deg"]), path["overturning_time"].to_numpy()
    first = float(min(times[np.isfinite(times)], default=np.nan))
    moved = float(path.attrs["amplitude"]) * motion.along(azimuth)
    sides = (compass_name(azimuth + 180.0), compass_name(azimuth))
    return Panel(*texts, first, _bodies(path, time), moved, motion.sampling_interval, sides, *_forces(path, time))


def _space_outcome(path: "xr.Dataset") -> str:
    """What a body in space does."""
    if float(path["overturned"]) == 1:
        towards = compass_name(round(float(path["fall_azimuth"])))
        return f"falls towards {towards} at {float(path['overturning_time']):.2f} s"
    tilt, twist = float(path["peak_tilt"]), float(path["residual_twist"])
    slip = 100.0 * float(np.hypot(path["residual_slip_north"], path["residual_slip_east"]))
    side = "clockwise" if twist >= 0 else "anticlockwise"
    # A cylinder rolls on for minutes, and where it will rest is not known.
    tilt_at_end = np.hypot(float(path["tilt_north"][-1]), float(path["tilt_east"][-1]))
    turning = max(tilt_at_end, float(np.abs(path["angular_velocity"][-1]).max())) > MOVED
    still = ", where it still rocks or rolls" if turning else ""
    moved = f"turned {abs(twist):.1f}° {side}, slipped {slip:.1f} cm by the end{still}"
    return f"stands (largest tilt {tilt:.1f}°); {moved}"


def _space_poses(path: "xr.Dataset") -> FloatArray:
    """Tilt, quaternion and place, shape (time, 9)."""
    return np.column_stack([path["tilt_north"], path["tilt_east"], path["quaternion"], path["place"]])


def _space_panel(path: "xr.Dataset", motion: Motion, time: FloatArray, texts: tuple[str, str]) -> Panel:
    clock, outline = path["time"].to_numpy(), path["outline"].to_numpy()
    position, quaternion = (_frames(time, clock, path[name].to_numpy()) for name in ("place", "quaternion"))
    body = FilmBody("body", outline, position, quaternion, faces=faces_of(outline))
    moved = float(path.attrs["amplitude"]) * motion.horizontal
    return Panel(*texts, float(path["overturning_time"]), (body,), moved, motion.sampling_interval)


def faces_of(corners: FloatArray) -> tuple[tuple[int, ...], ...]:
    """Faces of the convex body of some corners: the positions of each one's corners, anticlockwise from outside."""
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


class _Showing(NamedTuple):
    """How trajectories in a plane, or in space, are shown."""

    direction: str  # attribute of the direction, degrees
    heading: str  # of a panel, around the name of that direction
    outcome: Callable[["xr.Dataset"], str]  # what happens, of a valid simulation
    poses: Callable[["xr.Dataset"], FloatArray]  # what tells whether it moves, shape (time, n)
    panel: Callable[["xr.Dataset", Motion, FloatArray, tuple[str, str]], Panel]  # at the times of the frames
    note: str  # what can be done with the film, or seen in it


_PLANE: Final = _Showing(
    "azimuth_deg", "{}", _plane_outcome, _plane_poses, _plane_panel,
    "Contact forces: means over a sampling interval, over the weight of all stones that are free.",
)  # fmt: skip
_SPACE: Final = _Showing(
    "orientation_deg", "facing {}", _space_outcome, _space_poses, _space_panel, "Drag to turn the view."
)


def _showing(path: "xr.Dataset") -> _Showing:
    """How a trajectory is shown."""
    return _SPACE if "quaternion" in path else _PLANE
