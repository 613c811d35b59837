"""Rose diagrams of fall azimuths, for a whole study and by earthquake."""

from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from overturning.figures.style import FALLS, FAULT, INK, compass, grid, mark_fault_normal, radius_ticks
from overturning.statistics.roses import Rose, rose_of, study_roses

ROSES_IN_A_ROW: Final = 4


def draw_rose(axes: Any, rose: Rose, top: float | None = None) -> None:
    """Draw one rose; the area of a sector is proportional to its share, so that large shares do not look too large.

    Radii are square roots of shares, also for the intervals. The axis ends at radius ``top``, by default at `rim`.
    """
    compass(axes)
    width = 2.0 * np.pi / rose.shares.size
    centres = np.arange(rose.shares.size) * width
    axes.bar(centres, np.sqrt(rose.shares), width=width, color=FALLS, edgecolor="white", linewidth=0.4, zorder=3)
    for angle, low, high in zip(centres, rose.low, rose.high, strict=True):
        if np.isfinite(low):
            axes.plot([angle, angle], np.sqrt([low, high]), color=INK, linewidth=0.9, zorder=4)
    top = top or rim(rose)
    levels = [level for level in (0.01, 0.05, 0.1, 0.2, 0.4, 0.8) if 0.25 * top < np.sqrt(level) <= top]
    radius_ticks(axes, top, {float(np.sqrt(level)): f"{100 * level:.0f}\u00a0%" for level in levels}, zorder=6)
    axes.set_rlabel_position(_label_azimuth(rose))


def rim(*roses: Rose) -> float:
    """Return the radius of a polar axis that holds all the given roses."""
    most = [np.nanmax([rose.shares, rose.high]) if rose.falls else 0.0 for rose in roses]
    return max(float(np.sqrt(max(most, default=0.0))), 0.1) * 1.08


def _label_azimuth(rose: Rose) -> float:
    """Return the azimuth, degrees, for the labels of the radius: half-way between two names, at the lowest sectors."""
    most = np.fmax(rose.shares, rose.high)
    between = np.arange(22.5, 360.0, 45.0)
    centres = np.arange(most.size) * 360.0 / most.size
    near = [most[np.abs((centres - middle + 180.0) % 360.0 - 180.0) < 15.0].max() for middle in between]
    return float(between[int(np.argmin(near))])


def rose_figure(cube: xr.Dataset) -> Figure:
    """Draw the roses of a study (`study_roses`) on one scale: azimuths from north, and from the fault normal if known.

    If the study has records with and without a velocity pulse, each group has its own column.
    """
    roses = study_roses(cube)
    rows = 1 if any(below is None for _, below in roses.values()) else 2
    figure, panels = grid(rows, len(roses), max(3.3 * len(roses), 4.2), 3.5 * rows + 0.4, polar=True)
    top = rim(*(rose for pair in roses.values() for rose in pair if rose is not None))
    for (name, found), column in zip(roses.items(), panels.T, strict=True):
        (upper, *lower), (rose, relative) = column, found
        draw_rose(upper, rose, top)
        upper.set_title(f"{name}\n{rose.title}, from north", pad=4)
        if relative is not None:
            draw_rose(lower[0], relative, top)
            fault_frame(lower[0])
            of = "" if relative.earthquakes == rose.earthquakes else f"{relative.title}, "
            lower[0].set_title(f"{of}from the fault normal", pad=4)
    return figure


def earthquake_roses_figure(cube: xr.Dataset) -> Figure:
    """Draw a rose from north for each earthquake with falls, over all its records, on one scale, with fault normals."""
    events = cube["event"].to_numpy().astype(str)
    roses = {
        name: (rose_of(cube.isel(record=np.flatnonzero(events == name))), events == name)
        for name in dict.fromkeys(events)
    }
    shown = {name: found for name, found in roses.items() if found[0].falls}
    columns = min(ROSES_IN_A_ROW, max(1, len(shown)))
    rows = max(1, -(-len(shown) // columns))
    figure, panels = grid(rows, columns, max(2.1 * columns, 4.2), 2.35 * rows + 0.3, len(shown), polar=True)
    top = rim(*(rose for rose, _ in shown.values()))
    for axes, (name, (rose, members)) in zip(panels.flat, shown.items(), strict=False):
        draw_rose(axes, rose, top)
        axes.tick_params(axis="y", labelsize=6)
        axes.set_xticklabels(["N", "", "E", "", "S", "", "W", ""])
        for normal in cube["fault_normal"].to_numpy()[members]:
            mark_fault_normal(axes, float(normal), label=None)
        count = int(members.sum())
        axes.set_title(f"{name}\n{count} record{'s' * (count != 1)}", fontsize=8, pad=3, parse_math=False)
    return figure


def fault_frame(axes: Any) -> None:
    """Label a rose whose azimuths count from the fault normal."""
    compass(axes, ("normal", "45°", "90°", "135°", "normal", "225°", "270°", "315°"), pad=5)
    for label, text in zip(axes.get_xticklabels(), axes.get_xticks(), strict=True):
        label.set_fontsize(7.5)
        if np.isclose(text % np.pi, 0.0):
            label.set_color(FAULT)
    mark_fault_normal(axes, 0.0, label=None)
