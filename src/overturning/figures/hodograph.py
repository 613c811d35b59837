"""Hodographs: the ground's acceleration, velocity and displacement seen from above."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from overturning.arrays import FloatArray
from overturning.figures.style import FALLS, FAULT, INK, SERIES, caption, labels, short
from overturning.units import CM, GAL


def _draw_hodograph(axes: Any, north: FloatArray, east: FloatArray, label: str, fault_normal_deg: float) -> None:
    """Draw one path in the unit of the label: east to the right, north up, one scale for both."""
    size = float(np.hypot(north, east).max(initial=0.0))
    largest = 1.12 * size or 1.0
    if np.isfinite(fault_normal_deg):
        s, c = np.sin(np.radians(fault_normal_deg)), np.cos(np.radians(fault_normal_deg))
        axes.plot(
            [-largest * s, largest * s], [-largest * c, largest * c], color=FAULT, linestyle=(0, (4, 2)), linewidth=1.0,
            label="fault normal", zorder=1,
        )  # fmt: skip
    axes.plot(east, north, color=SERIES[2], linewidth=0.6, rasterized=True)
    if size > 0:
        at = int(np.hypot(north, east).argmax())
        axes.plot(east[at], north[at], "o", color=FALLS, markersize=4, label="peak")
        toward = np.degrees(np.arctan2(east[at], north[at])) % 360
        axes.set_title(f"{label}\n{short(size)} towards {toward:.0f}°", fontsize=9)
    else:
        axes.set_title(label, fontsize=9)
    axes.set(xlim=(-largest, largest), ylim=(-largest, largest), aspect="equal")
    axes.axhline(0, color="#c8c8c8", linewidth=0.5, zorder=0)
    axes.axvline(0, color="#c8c8c8", linewidth=0.5, zorder=0)
    axes.locator_params(nbins=5)
    labels(axes, "east", "north")
    arrow = {"arrowstyle": "-|>", "color": INK, "linewidth": 0.8}
    axes.annotate("N", (0.93, 0.99), (0.93, 0.84), xycoords="axes fraction", ha="center", fontsize=8, arrowprops=arrow)


def hodograph_figure(motion: xr.Dataset, fault_normal_deg: float, title: str) -> Figure:
    """Figure of acceleration, velocity and displacement.

    Parameters
    ----------
    motion : xarray.Dataset, dimension time
        ``acceleration_north``, ``acceleration_east`` (m/s²), and the same of ``velocity`` (m/s) and ``displacement`` (m).
    fault_normal_deg : float
        Azimuth of the fault normal, degrees, or NaN.
    """
    import matplotlib.pyplot as plt

    figure, panels = plt.subplots(1, 3, figsize=(8.4, 3.7), layout="constrained")
    for axes, name, unit, label in (
        (panels[0], "acceleration", GAL, "acceleration, Gal"),
        (panels[1], "velocity", CM, "velocity, cm/s"),
        (panels[2], "displacement", CM, "displacement, cm"),
    ):
        north, east = motion[f"{name}_north"].to_numpy() / unit, motion[f"{name}_east"].to_numpy() / unit
        _draw_hodograph(axes, north, east, label, fault_normal_deg)
    caption(figure, title, panels[0], 2)
    return figure
