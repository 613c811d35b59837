"""From the trajectory of a body in space to its part of a film."""

from typing import TYPE_CHECKING

import numpy as np

from overturning.arrays import FloatArray
from overturning.figures.film import SpacePanel
from overturning.figures.style import compass_name
from overturning.motion.motion import Motion

if TYPE_CHECKING:
    import xarray as xr

MOVED = 1e-3
"""A body moves where its axis is so far from upright and from where it ends."""


def space_outcome(path: "xr.Dataset") -> str:
    """What a body in space does."""
    if int(path["overturned"]) == 1:
        towards = compass_name(round(float(path["fall_azimuth"])))
        return f"falls towards {towards} at {float(path['overturning_time']):.2f} s"
    tilt, twist = float(path["peak_tilt"]), float(path["residual_twist"])
    slip = 100.0 * float(np.hypot(path["residual_slip_north"], path["residual_slip_east"]))
    side = "clockwise" if twist >= 0 else "anticlockwise"
    return f"stands (largest tilt {tilt:.1f}°); turned {abs(twist):.1f}° {side}, slipped {slip:.1f} cm by the end"


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


def space_movement(path: "xr.Dataset") -> tuple[float, float] | None:
    """First and last time, s, at which a body is away from where it began and from where it ends; None if never."""
    time = path["time"].to_numpy()
    pose = np.column_stack([path["tilt_north"], path["tilt_east"], path["quaternion"], path["place"].to_numpy()])
    away = np.minimum(np.abs(pose - pose[:1]), np.abs(pose - pose[-1:])).max(axis=1) > MOVED
    moving = np.flatnonzero(away)
    return (float(time[moving[0]]), float(time[min(moving[-1] + 1, time.size - 1)])) if moving.size else None


def space_panel(path: "xr.Dataset", motion: Motion, time: FloatArray, texts: tuple[str, str]) -> SpacePanel:
    """The panel of a body in space at the times of a film's frames; the texts are heading and outcome."""
    clock, outline = path["time"].to_numpy(), path["outline"].to_numpy()
    position, quaternion = (
        np.stack([np.interp(time, clock, column) for column in path[name].to_numpy().T], axis=1)
        for name in ("place", "quaternion")
    )
    return SpacePanel(
        title=texts[0],
        outcome=texts[1],
        outcome_time=float(path["overturning_time"]),
        corners=outline,
        faces=faces_of(outline),
        position=position,
        quaternion=quaternion,
        acceleration=float(path.attrs["amplitude"]) * motion.horizontal,
        sampling_interval=motion.sampling_interval,
    )
