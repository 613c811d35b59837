"""Probability of falling towards each azimuth, by slenderness: polar map of an ensemble, or of means over cases."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.colors import LinearSegmentedColormap, ListedColormap
from matplotlib.figure import Figure

from overturning.figures.polar_panels import blocks_of, case_panels, closed, draw_cells, mark_normals
from overturning.figures.style import DARKEST, FALLS, MISSING, OTHER_SIDE, STANDS, caption, patch
from overturning.model.planes import fall_probability

OTHER_SIDE_ABOVE = 0.5
"""A cell whose block falls to the other side with a larger probability than this is coloured for that."""


def probability_map_figure(cube: xr.Dataset, title: str) -> Figure:
    """Figure of one record: a panel per friction and height.

    Parameters
    ----------
    cube : xarray.Dataset
        One record of the cube; with the ensemble's probabilities, or flags as 0 and 1.
    """
    probability = fall_probability(closed(cube))[["towards", "away"]].compute()
    figure, panels = case_panels(probability, more_width=0.85)
    # Probability from 0 (paper) to 1 (the colour of falls, then darker): lightness falls all the way.
    colours = LinearSegmentedColormap.from_list("probability", [STANDS, "#f6c9a0", "#e58a4b", FALLS, DARKEST])
    mesh: Any = None
    for axes, cells in blocks_of(probability, panels):
        towards, away = (cells[name].transpose("b_over_h", "azimuth").to_numpy() for name in ("towards", "away"))
        other = away > OTHER_SIDE_ABOVE
        mesh = draw_cells(
            axes, cells, np.ma.masked_where(np.isnan(towards) | other, towards), cmap=colours, vmin=0.0, vmax=1.0
        )
        kinds = np.ma.masked_where(~other & ~np.isnan(towards), np.where(other, 0, 1))
        draw_cells(axes, cells, kinds, cmap=ListedColormap([OTHER_SIDE, MISSING]), vmin=-0.5, vmax=1.5)
    mark_normals(cube, panels)
    last = next(axes for axes in panels[0][::-1] if axes.get_visible())
    bar = figure.colorbar(mesh, cax=last.inset_axes([1.22, 0.0, 0.06, 1.0]))
    bar.set_label("probability of falling\ntowards the azimuth", fontsize=8)
    bar.ax.tick_params(labelsize=8)
    marks = [patch(STANDS, "stands"), patch(OTHER_SIDE, "falls to the other side")]
    if bool(probability["towards"].isnull().any()):
        marks.append(patch(MISSING, "no outcome"))
    caption(figure, f"{title}\nradius: slenderness B/H", panels[0, 0], 2, first=marks)
    return figure
