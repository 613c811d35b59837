"""Falls that may go any way: a record's map, and what falls follow."""

from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from overturning.arrays import FloatArray
from overturning.figures.polar_panels import cell_edges
from overturning.figures.rose import draw_rose
from overturning.figures.style import INK, MISSING, SERIES, STANDS, caption, grid, labels, mark_fault_normal
from overturning.statistics.bootstrap import Mean
from overturning.statistics.roses import rose_of

_TURN = np.linspace(0.0, 2.0 * np.pi, 256, endpoint=False)[:, None]
COLOURS: Final = ListedColormap(np.clip(0.58 + 0.36 * np.cos(_TURN - np.radians([0.0, 130.0, 250.0])), 0.0, 1.0))
"""Of azimuths: a hue for each, north red; arrows say the same."""

MOST_ARROWS = 36
"""Arrows along each side of a map."""


def space_map_figure(cube: xr.Dataset, title: str) -> Figure:
    """Map of a record: fall azimuth by orientation and B/H, a panel per friction, height and aspect; and its rose.

    Parameters
    ----------
    cube : xarray.Dataset
        One record of a cube in space.
    """
    blocks = [(height, aspect) for height in cube["height"].to_numpy() for aspect in cube["aspect"].to_numpy()]
    frictions = cube["friction"].to_numpy()
    figure, panels = grid(len(blocks), len(frictions) + 1, 2.2 * (len(frictions) + 1), 1.95 * len(blocks) + 0.9)
    for row, (height, aspect) in enumerate(blocks):
        for column, friction in enumerate(frictions):
            axes = panels[row, column]
            _draw_map(axes, cube.sel(height=height, aspect=aspect, friction=friction))
            several = f", D/B = {aspect:g}" if cube.sizes["aspect"] > 1 else ""
            axes.set_title(f"µ = {friction:g}, H = {height:g} m{several}", fontsize=8)
            labels(axes, "orientation" if row == len(blocks) - 1 else "", "B/H" if column == 0 else "")
        panels[row, -1].set_visible(False)
    around = figure.add_subplot(panels[0, -1].get_subplotspec(), projection="polar")
    draw_rose(around, rose_of(cube.expand_dims("record")).shares)
    around.set_yticklabels([])
    around.tick_params(labelsize=7)
    top = around.get_ylim()[1]
    around.set_ylim(0.0, 1.22 * top)
    ring = np.linspace(0.0, 2.0 * np.pi, 73)
    around.pcolormesh(
        ring,
        [1.08 * top, 1.22 * top],
        ((ring[:-1] + ring[1:]) / 2)[None, :],
        cmap=COLOURS,
        vmin=0,
        vmax=2 * np.pi,
        rasterized=True,
    )
    mark_fault_normal(around, float(cube["fault_normal"]))
    around.set_title("all falls of the record", fontsize=8, pad=3)
    marks = [Patch(facecolor=STANDS, edgecolor="#777777", linewidth=0.4, label="stands")]
    if bool(cube["overturned"].isnull().any()):
        marks.append(Patch(facecolor=MISSING, label="not found"))
    caption(figure, f"{title}\ncolour and arrow: azimuth of the fall, north up", around, 3, first=marks)
    return figure


def _draw_map(axes: Any, cells: xr.Dataset) -> None:
    x, y = cells["orientation"].to_numpy().astype(np.float64), cells["b_over_h"].to_numpy().astype(np.float64)
    azimuth = np.radians(cells["fall_azimuth"].transpose("b_over_h", "orientation").to_numpy().astype(np.float64))
    missing = cells["overturned"].isnull().transpose("b_over_h", "orientation").to_numpy()
    edges = cell_edges(x) if x.size > 1 else x[0] + np.array([-2.5, 2.5]), cell_edges(y)
    axes.set_facecolor(STANDS)
    axes.pcolormesh(*edges, np.ma.masked_invalid(azimuth), cmap=COLOURS, vmin=0.0, vmax=2.0 * np.pi, rasterized=True)
    if missing.any():
        axes.pcolormesh(*edges, np.ma.masked_where(~missing, missing), cmap=ListedColormap([MISSING]), rasterized=True)
    across, up = np.meshgrid(x, y)
    # Of finer grids arrows of every second cell, or third: more could not be told apart.
    fell = np.zeros(azimuth.shape, bool)
    thin = tuple(slice(None, None, -(-cells // MOST_ARROWS)) for cells in azimuth.shape)
    fell[thin] = np.isfinite(azimuth)[thin]
    axes.quiver(
        across[fell], up[fell], np.sin(azimuth[fell]), np.cos(azimuth[fell]), pivot="mid", angles="uv", color=INK,
        scale=30, width=0.006, headwidth=4, headlength=4, headaxislength=3.5,
    )  # fmt: skip
    axes.set(xlim=(edges[0][0], edges[0][-1]), ylim=(edges[1][0], edges[1][-1]))
    axes.xaxis.set_major_locator(_multiples(x))


def _multiples(x: FloatArray) -> Any:
    from matplotlib.ticker import MultipleLocator

    return MultipleLocator(30 if np.ptp(x) <= 100 else 60 if np.ptp(x) <= 200 else 90)


def follow_figure(found: dict[str, dict[tuple[str, bool], list[Mean]]], b_over_h: FloatArray) -> Figure:
    """What falls follow, by slenderness: a column per group of records; above as axes, below with their heads.

    Parameters
    ----------
    found : dict
        By group, then by name of the reference and whether it is taken as an axis: its mean for each B/H.
    b_over_h : ndarray, shape (n,)
        The slendernesses.
    """
    figure, panels = grid(2, len(found), max(3.4 * len(found), 4.4), 5.4)
    names = list(dict.fromkeys(name for group in found.values() for name, _ in group))
    apart = 0.12 * float(np.diff(b_over_h).min(initial=0.05))
    for column, (group, means) in enumerate(found.items()):
        for row, axial in enumerate((True, False)):
            axes = panels[row, column]
            axes.axhline(0.0, color="#c8c8c8", linewidth=0.8)
            for place, name in enumerate(names):
                if (name, axial) not in means:
                    continue
                value, low, high = np.array([(one.value, one.low, one.high) for one in means[name, axial]]).T
                x, colour = b_over_h + (place - 0.5 * (len(names) - 1)) * apart, SERIES[place % len(SERIES)]
                axes.vlines(x, low, high, color=colour, linewidth=1.0)
                axes.plot(x, value, "osD^"[place % 4], color=colour, markersize=3.5, label=name)
            axes.set_ylim(-1.05, 1.05)
            labels(
                axes,
                "B/H" if row else "",
                ("mean cos 2Δ of axes" if axial else "mean cos Δ of directions") if column == 0 else "",
            )
            axes.grid(True, axis="y")
            if row == 0:
                axes.set_title(group, fontsize=9)
    caption(figure, "", panels[0, 0], 4 if len(found) > 1 else 2)
    return figure
