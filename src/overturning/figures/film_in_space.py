"""From the trajectory of a body in space to its film and to the figure of its axis."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from overturning.arrays import FloatArray
from overturning.dem.kernel.status import Status
from overturning.figures.film import FRAME_INTERVAL, Film, SpacePanel, about_the_peak, frame_times
from overturning.figures.film_of_trajectory import compass_name
from overturning.figures.hodograph import draw_hodograph
from overturning.figures.style import FALLS, INK, SERIES, caption, grid, labels
from overturning.motion.integration import integrate
from overturning.motion.motion import Motion
from overturning.units import CM

if TYPE_CHECKING:
    import xarray as xr

MOVED = 1e-3
"""A body moves where its axis is so far from upright and from where it ends."""


def space_outcome(path: "xr.Dataset") -> str:
    """What a body in space does."""
    if int(path["status"]) not in (Status.SIMULATED, Status.AT_REST):
        return "no outcome: the simulation is not valid"
    if int(path["overturned"]) == 1:
        return f"falls towards {compass_name(round(float(path['fall_azimuth'])))} at {float(path['overturning_time']):.2f} s"
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


def space_window(path: "xr.Dataset") -> tuple[float, float]:
    """Time worth showing, s: from the first movement to the last, or about the peak of the motion."""
    time, place = path["time"].to_numpy(), path["place"].to_numpy()
    pose = np.column_stack([path["tilt_north"], path["tilt_east"], path["quaternion"], place])
    away = np.minimum(np.abs(pose - pose[:1]), np.abs(pose - pose[-1:])).max(axis=1) > MOVED
    moving = np.flatnonzero(away)
    if moving.size:
        return float(time[moving[0]]), float(time[min(moving[-1] + 1, time.size - 1)])
    return about_the_peak(time, np.hypot(*path["ground_acceleration"].to_numpy()[:, :2].T))


def film_in_space(paths: Sequence["xr.Dataset"], motion: Motion, title: str, note: str = "") -> Film:
    """A film of trajectories in space in step, of bodies under the same motion."""
    spans = [space_window(path) for path in paths]
    time = frame_times(min(first for first, _ in spans), max(last for _, last in spans))
    panels = []
    for path in paths:
        clock, factor = path["time"].to_numpy(), float(path.attrs["amplitude"])
        at = [
            np.stack([np.interp(time, clock, column) for column in path[name].to_numpy().T], axis=1)
            for name in ("place", "quaternion")
        ]
        outline = path["outline"].to_numpy()
        panels.append(
            SpacePanel(
                title=f"facing {compass_name(path.attrs['orientation_deg'])}",
                outcome=space_outcome(path),
                outcome_time=float(path["overturning_time"]),
                corners=outline,
                faces=faces_of(outline),
                position=at[0],
                quaternion=at[1],
                acceleration=factor * motion.horizontal,
                sampling_interval=motion.sampling_interval,
            )
        )
    return Film(title, float(time[0]), FRAME_INTERVAL, tuple(panels), note=note)


def axis_figure(path: "xr.Dataset", motion: Motion, title: str) -> Figure:
    """Figure of a body's axis seen from above, and beside it the hodographs of the ground's velocity and displacement."""
    figure, panels = grid(1, 3, 9.2, 3.9)
    axes = panels[0, 0]
    east, north = path["tilt_east"].to_numpy(), path["tilt_north"].to_numpy()
    up = np.sqrt(np.maximum(0.0, 1.0 - east**2 - north**2))
    angle = np.degrees(np.arctan2(np.hypot(east, north), up))
    length = np.hypot(east, north)
    scale = np.where(length > 0, angle / np.where(length > 0, length, 1.0), 0.0)
    x, y = east * scale, north * scale
    critical = np.degrees(np.arctan(float(path.attrs["b_over_h"])))
    largest = 1.12 * max(float(angle.max(initial=0.0)), critical)
    for radius, dash, name in ((critical, "--", "least critical angle"), (90.0, ":", "lying")):
        if radius < largest:
            turn = np.linspace(0.0, 2.0 * np.pi, 181)
            axes.plot(radius * np.cos(turn), radius * np.sin(turn), dash, color=INK, linewidth=0.8, label=name)
    axes.plot(x, y, color=SERIES[0], linewidth=0.8, label="axis of the body")
    axes.plot(x[-1], y[-1], "o", color=FALLS, markersize=4, label="end")
    axes.set(xlim=(-largest, largest), ylim=(-largest, largest), aspect="equal")
    axes.set_title(
        f"tilt of the axis, degrees\n{space_outcome(path).split('(')[0].split(' at ')[0].strip()}", fontsize=9
    )
    labels(axes, "east", "north")
    velocity = integrate(float(path.attrs["amplitude"]) * motion.horizontal, motion.sampling_interval)
    for panel, values, name, unit in (
        (panels[0, 1], velocity, "velocity of the ground", "cm/s"),
        (panels[0, 2], integrate(velocity, motion.sampling_interval), "displacement of the ground", "cm"),
    ):
        draw_hodograph(panel, values[0] / CM, values[1] / CM, name, unit, float("nan"))
    caption(figure, title, axes, 4)
    return figure
