"""Probability of falling towards each azimuth, by slenderness: the polar map of an ensemble, or of the mean of many cases."""

from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.figures.polar import azimuth_edges, cell_edges
from overturning.figures.style import MISSING, compass, mark_fault_normal, probability_colours
from overturning.statistics.planes import fall_probability

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure


def draw_probability_map(axes: Any, towards: "xr.DataArray") -> Any:
    """Draw one panel.

    Parameters
    ----------
    axes : polar Axes
        Where to draw.
    towards : xarray.DataArray, dimensions azimuth, b_over_h
        Probability of falling towards the azimuth, 0 to 1, NaN where it was not found.

    Returns
    -------
    QuadMesh
        For a colour bar.
    """
    compass(axes)
    axes.grid(False)
    values = np.ma.masked_invalid(towards.transpose("b_over_h", "azimuth").to_numpy())
    theta = azimuth_edges(towards["azimuth"].to_numpy().astype(np.float64))
    radius = cell_edges(towards["b_over_h"].to_numpy().astype(np.float64))
    axes.set_facecolor(MISSING if values.mask.any() else "white")
    mesh = axes.pcolormesh(theta, radius, values, cmap=probability_colours(), vmin=0.0, vmax=1.0, rasterized=True)
    if values.mask.any():  # the hole in the middle is no cell
        axes.bar(0.0, radius[0], width=2 * np.pi, color="white", zorder=1.5)
    axes.set_ylim(0.0, radius[-1])
    ticks = [tick for tick in (0.2, 0.4, 0.6, 0.8, 1.0) if tick < radius[-1]] or [round(float(radius.mean()), 2)]
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_rlabel_position(112.5)
    axes.tick_params(axis="y", labelsize=7)
    axes.yaxis.grid(True, linewidth=0.4)
    return mesh


def probability_map_figure(cube: "xr.Dataset", title: str) -> "Figure":
    """Figure of one record: a panel per friction (columns) and height (rows).

    Parameters
    ----------
    cube : xarray.Dataset
        One record of the cube; with the ensemble's probabilities, or flags as 0 and 1.
    title : str
        Title of the figure.

    Returns
    -------
    matplotlib Figure
    """
    import matplotlib.pyplot as plt
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    towards = fall_probability(cube)["towards"].compute()
    heights, frictions = towards["height"].to_numpy(), towards["friction"].to_numpy()
    figure, panels = plt.subplots(
        heights.size,
        frictions.size,
        figsize=(max(2.35 * frictions.size, 4.4) + 0.5, 2.45 * heights.size + 1.05),
        subplot_kw={"projection": "polar"},
        squeeze=False,
        layout=ConstrainedLayoutEngine(h_pad=0.11),
    )
    normal = float(cube["fault_normal"]) if "fault_normal" in cube.coords or "fault_normal" in cube else float("nan")
    mesh: Any = None
    for row, height in enumerate(heights):
        for column, friction in enumerate(frictions):
            axes = panels[row, column]
            mesh = draw_probability_map(axes, towards.isel(height=row, friction=column))
            mark_fault_normal(axes, normal, axes.get_ylim()[1])
            axes.set_title(f"µ = {friction:g}, H = {height:g} m", pad=3, fontsize=9)
    bar = figure.colorbar(mesh, ax=panels, shrink=0.7, pad=0.02, aspect=30)
    bar.set_label("probability of falling towards the azimuth", fontsize=8)
    bar.ax.tick_params(labelsize=7)
    lines, names = panels[0, 0].get_legend_handles_labels()
    if lines:
        figure.legend(lines, names, loc="outside lower center", fontsize=8)
    figure.suptitle(f"{title}\nradius: slenderness B/H", fontsize=10)
    return figure
