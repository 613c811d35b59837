"""Hodographs: the ground's acceleration, velocity and displacement seen from above."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from overturning.arrays import FloatArray
from overturning.figures.style import (
    DASHED,
    FALLS,
    INK,
    PAGE_WIDTH,
    SERIES,
    caption,
    grid,
    labels,
    line_through_origin,
    short,
)
from overturning.units import CM, GAL


def draw_hodograph(
    axes: Any, north: FloatArray, east: FloatArray, label: str, unit: str, fault_normal_deg: float
) -> None:
    """Draw one path in its unit: east to the right, north up, one scale for both."""
    radius = np.hypot(north, east)
    size, title = float(radius.max(initial=0.0)), label
    largest = 1.12 * size or 1.0
    if np.isfinite(fault_normal_deg):
        look = {"linestyle": DASHED, "linewidth": 1.0, "label": "fault normal", "zorder": 1}
        line_through_origin(axes, fault_normal_deg, largest, **look)
    axes.plot(east, north, color=SERIES[2], linewidth=0.6, rasterized=True)
    if size > 0:
        at = int(radius.argmax())
        axes.plot(east[at], north[at], "o", color=FALLS, markersize=4, label="peak")
        toward = np.degrees(np.arctan2(east[at], north[at])) % 360
        title = f"{label}\n{short(size)} {unit} towards {toward:.0f}°"
    axes.set_title(title, fontsize=9)
    axes.set(xlim=(-largest, largest), ylim=(-largest, largest), aspect="equal")
    for zero in (axes.axhline, axes.axvline):
        zero(0, color="#c8c8c8", linewidth=0.5, zorder=0)
    axes.locator_params(nbins=3)
    labels(axes, f"east, {unit}", f"north, {unit}")
    arrow = {"arrowstyle": "-|>", "color": INK, "linewidth": 0.8}
    axes.annotate("N", (0.93, 0.99), (0.93, 0.84), xycoords="axes fraction", ha="center", fontsize=8, arrowprops=arrow)


def hodograph_figure(motion: xr.Dataset, fault_normal_deg: float, title: str) -> Figure:
    """Figure of acceleration, velocity and displacement.

    Parameters
    ----------
    motion : xarray.Dataset, dimension time
        ``acceleration_north``, ``acceleration_east`` (m/s²), and the same of ``velocity`` (m/s) and ``displacement``
        (m).
    fault_normal_deg : float
        Azimuth of the fault normal, degrees, or NaN.
    """
    figure, panels = grid(1, 3, PAGE_WIDTH, 3.2)
    units = (("acceleration", GAL, "Gal"), ("velocity", CM, "cm/s"), ("displacement", CM, "cm"))
    for axes, (name, unit, called) in zip(panels.flat, units, strict=True):
        north, east = (motion[f"{name}_{side}"].to_numpy() / unit for side in ("north", "east"))
        draw_hodograph(axes, north, east, name, called, fault_normal_deg)
    caption(figure, title, panels[0, 0], 2)
    return figure
