"""Where the block falls: azimuth of the fall × slenderness, north up, clockwise."""

import numpy as np
import xarray as xr
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from overturning.figures.polar_panels import blocks_of, case_panels, closed, draw_cells, mark_normals
from overturning.figures.style import FALLS, MISSING, OTHER_SIDE, STANDS, caption, patch

_KINDS = {
    "stands": STANDS,
    "falls to the other side": OTHER_SIDE,
    "falls towards the azimuth": FALLS,
    "no outcome": MISSING,
}


def fall_map_figure(cube: xr.Dataset, title: str) -> Figure:
    """Figure of one record: a panel per friction and height.

    Parameters
    ----------
    cube : xarray.Dataset
        One record of the cube, or any dataset with ``overturned`` over azimuth, height, b_over_h and friction.
    """
    flags = closed(cube[["overturned"]])["overturned"]
    figure, panels = case_panels(flags)
    colours = ListedColormap(list(_KINDS.values()))
    for axes, cells in blocks_of(flags, panels):
        values = cells.transpose("b_over_h", "azimuth").to_numpy()
        kinds = np.select([np.isnan(values), values > 0, values < 0], [3, 2, 1], 0)
        draw_cells(axes, cells, kinds, cmap=colours, vmin=-0.5, vmax=3.5)
    mark_normals(cube, panels)
    marks = [patch(colour, kind) for kind, colour in _KINDS.items()]
    shown = marks[:3] if bool(cube["overturned"].notnull().all()) else marks
    caption(figure, f"{title}\nradius: slenderness B/H", panels[0, 0], 2, first=shown)
    return figure
