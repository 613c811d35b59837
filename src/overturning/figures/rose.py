"""Rose of fall azimuths over a whole study."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from overturning.arrays import FloatArray
from overturning.figures.style import FALLS, FAULT, compass, grid, mark_fault_normal, radius_ticks
from overturning.statistics.circular import sector_shares
from overturning.statistics.falls import falls_towards, near_boundary
from overturning.statistics.groups import record_groups
from overturning.statistics.planes import azimuth_weight


def draw_rose(axes: Any, shares: FloatArray) -> None:
    """Draw one rose: sectors with an area in proportion to their share, so that a wide one does not look too large."""
    compass(axes)
    width = 2.0 * np.pi / shares.size
    centres = np.arange(shares.size) * width
    axes.bar(centres, np.sqrt(shares), width=width, color=FALLS, edgecolor="white", linewidth=0.4, zorder=3)
    top = max(float(np.sqrt(shares.max(initial=0.0))), 0.1) * 1.08
    levels = [level for level in (0.01, 0.05, 0.1, 0.2, 0.4, 0.8) if 0.25 * top < np.sqrt(level) <= top]
    radius_ticks(axes, top, {float(np.sqrt(level)): f"{level:.0%}" for level in levels}, zorder=6)


def rose_figure(cube: xr.Dataset) -> Figure:
    """Rose of the falls that tell most about direction: by azimuth from north, and from the fault normal where it is known.

    They are those of blocks near the boundary (`near_boundary`), or all where there is none. Each plane of motion counts once, and azimuths added to the grid share the weight of their neighbourhood. Records with
    and without a velocity pulse have a column of their own where the study has both.
    """
    near = near_boundary(cube)
    what = "falls near the boundary" if bool(near.any()) else "falls"
    falls = falls_towards(cube).where(near | (not bool(near.any()))).sum(["height", "b_over_h", "friction"]).compute()
    azimuth = falls["azimuth"].to_numpy().astype(np.float64)
    counts = falls.transpose("record", "azimuth").to_numpy().astype(np.float64)
    weighted = counts * azimuth_weight(azimuth)
    normals = cube["fault_normal"].to_numpy()
    groups = record_groups(cube)
    rows = 2 if np.isfinite(normals).any() else 1
    figure, panels = grid(rows, len(groups), max(3.3 * len(groups), 4.2), 3.5 * rows + 0.4, polar=True)
    for (name, members), (upper, *lower) in zip(groups.items(), panels.T, strict=True):
        draw_rose(upper, sector_shares(azimuth, weighted[members].sum(axis=0)))
        upper.set_title(f"{name}\n{counts[members].sum():.0f} {what}, from north", pad=4)
        for axes in lower:
            known = members & np.isfinite(normals)
            relative = (azimuth[None, :] - normals[known][:, None]) % 360.0
            draw_rose(axes, sector_shares(relative.ravel(), weighted[known].ravel()))
            fault_frame(axes)
            axes.set_title("from the fault normal", pad=4)
    return figure


def fault_frame(axes: Any) -> None:
    """Turn a rose into one whose zero is the fault normal."""
    compass(axes, ("normal", "45°", "90°", "135°", "normal", "225°", "270°", "315°"), pad=5)
    for label, text in zip(axes.get_xticklabels(), axes.get_xticks(), strict=True):
        label.set_fontsize(7.5)
        if np.isclose(text % np.pi, 0.0):
            label.set_color(FAULT)
    mark_fault_normal(axes, 0.0, label=None)
