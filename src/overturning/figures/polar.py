"""Where the block falls: azimuth of the fall × slenderness, north up, clockwise."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from overturning.figures.polar_panels import blocks_of, case_panels, draw_cells, mark_normals
from overturning.figures.style import FALLS, FALLS_OPPOSITE, MISSING, STANDS, caption

_KINDS = (
    (0, STANDS, "stands"),
    (1, FALLS_OPPOSITE, "falls the other way"),
    (2, FALLS, "falls towards this azimuth"),
    (3, MISSING, "not found"),
)


def _draw_fall_map(axes: Any, cells: xr.DataArray) -> None:
    """Draw one panel: ``overturned`` by azimuth and B/H, +1, 0, −1, or NaN where it was not found."""
    values = cells.transpose("b_over_h", "azimuth").to_numpy()
    kinds = np.select([np.isnan(values), values > 0, values < 0], [3, 2, 1], 0)
    colours = ListedColormap([colour for _, colour, _ in _KINDS])
    draw_cells(axes, cells, kinds, cmap=colours, vmin=-0.5, vmax=3.5)


def fall_map_figure(cube: xr.Dataset, title: str) -> Figure:
    """Figure of one record: a panel per friction and height.

    Parameters
    ----------
    cube : xarray.Dataset
        One record of the cube, or any dataset with ``overturned`` over azimuth, height, b_over_h and friction.
    """
    figure, panels = case_panels(cube["overturned"])
    for axes, cells in blocks_of(cube["overturned"], panels):
        _draw_fall_map(axes, cells)
    mark_normals(cube, panels)
    handles = [Patch(facecolor=colour, edgecolor="#777777", linewidth=0.4, label=text) for _, colour, text in _KINDS]
    lines, _ = panels[0, 0].get_legend_handles_labels()
    shown = handles[:3] if bool(cube["overturned"].notnull().all()) else handles
    figure.legend(handles=shown + lines, loc="outside lower center", ncols=2, fontsize=8)
    caption(figure, f"{title}\nradius: slenderness B/H")
    return figure
