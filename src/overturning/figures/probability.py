"""Probability of falling towards each azimuth, by slenderness: the polar map of an ensemble, or of the mean of many cases."""

from typing import TYPE_CHECKING, Any

import numpy as np

from overturning.figures.polar import azimuth_edges, cell_edges
from overturning.figures.polar_panels import blocks_of, case_panels, mark_normals, radius_ticks
from overturning.figures.style import MISSING, compass, probability_colours
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
    radius_ticks(axes, radius[-1], float(radius.mean()))
    axes.yaxis.grid(True, linewidth=0.4)
    return mesh


def probability_map_figure(cube: "xr.Dataset", title: str) -> "Figure":
    """Figure of one record: a panel per friction and height.

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
    towards = fall_probability(cube)["towards"].compute()
    figure, panels = case_panels(towards, more_width=0.5)
    mesh: Any = None
    for axes, cells in blocks_of(towards, panels):
        mesh = draw_probability_map(axes, cells)
    mark_normals(cube, panels)
    bar = figure.colorbar(mesh, ax=panels, shrink=0.7, pad=0.02, aspect=30)
    bar.set_label("probability of falling towards the azimuth", fontsize=8)
    bar.ax.tick_params(labelsize=7)
    lines, names = panels[0, 0].get_legend_handles_labels()
    if lines:
        figure.legend(lines, names, loc="outside lower center", fontsize=8)
    figure.suptitle(f"{title}\nradius: slenderness B/H", fontsize=10, parse_math=False)
    return figure
