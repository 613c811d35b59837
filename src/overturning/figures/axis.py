"""The axis of a body in space, seen from above."""

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from overturning.figures.film_of_trajectory import outcome
from overturning.figures.hodograph import draw_hodograph
from overturning.figures.style import FALLS, INK, SERIES, caption, grid, labels
from overturning.motion.integration import integrate
from overturning.motion.motion import Motion
from overturning.units import CM

if TYPE_CHECKING:
    import xarray as xr


def axis_figure(path: "xr.Dataset", motion: Motion, title: str) -> Figure:
    """Figure of a body's axis seen from above, beside it hodographs of the ground's velocity and displacement."""
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
    axes.set_title(f"tilt of the axis, degrees\n{outcome(path).split('(')[0].split(' at ')[0].strip()}", fontsize=9)
    labels(axes, "east", "north")
    velocity = integrate(float(path.attrs["amplitude"]) * motion.horizontal, motion.sampling_interval)
    for panel, values, name, unit in (
        (panels[0, 1], velocity, "velocity of the ground", "cm/s"),
        (panels[0, 2], integrate(velocity, motion.sampling_interval), "displacement of the ground", "cm"),
    ):
        draw_hodograph(panel, values[0] / CM, values[1] / CM, name, unit, float("nan"))
    caption(figure, title, axes, 4)
    return figure
