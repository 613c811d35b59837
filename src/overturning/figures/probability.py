"""Probability of falling towards each azimuth, by slenderness: the polar map of an ensemble, or of the mean of many cases."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from overturning.figures.polar_panels import blocks_of, case_panels, cell_edges, draw_cells, mark_normals
from overturning.figures.style import FALLS, MISSING, STANDS, caption
from overturning.statistics.planes import fall_probability


def probability_map_figure(cube: xr.Dataset, title: str) -> Figure:
    """Figure of one record: a panel per friction and height.

    Parameters
    ----------
    cube : xarray.Dataset
        One record of the cube; with the ensemble's probabilities, or flags as 0 and 1.
    """
    towards = fall_probability(cube)["towards"].compute()
    figure, panels = case_panels(towards, more_width=0.5)
    # Probability from 0 (paper) to 1 (the colour of falls, then darker): lightness falls all the way.
    colours = LinearSegmentedColormap.from_list("probability", [STANDS, "#f6c9a0", "#e58a4b", FALLS, "#6e2300"])
    mesh: Any = None
    for axes, cells in blocks_of(towards, panels):
        values = np.ma.masked_invalid(cells.transpose("b_over_h", "azimuth").to_numpy())
        mesh = draw_cells(axes, cells, values, cmap=colours, vmin=0.0, vmax=1.0)
        axes.set_facecolor(MISSING if values.mask.any() else "white")
        if values.mask.any():  # the hole in the middle is no cell
            hole = cell_edges(cells["b_over_h"].to_numpy().astype(np.float64))[0]
            axes.bar(0.0, hole, width=2 * np.pi, color="white", zorder=1.5)
    mark_normals(cube, panels)
    bar = figure.colorbar(mesh, ax=panels, shrink=0.7, pad=0.02, aspect=30)
    bar.set_label("probability of falling towards the azimuth", fontsize=8)
    bar.ax.tick_params(labelsize=7)
    caption(figure, f"{title}\nradius: slenderness B/H", panels[0, 0])
    return figure
