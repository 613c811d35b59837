"""Where the block falls: azimuth of the fall × slenderness, north up, clockwise."""

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from overturning.figures.polar_panels import blocks_of, case_panels, mark_normals, radius_ticks
from overturning.figures.style import FALLS, FALLS_OPPOSITE, MISSING, STANDS, compass

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_KINDS = (
    (0, STANDS, "stands"),
    (1, FALLS_OPPOSITE, "falls the other way"),
    (2, FALLS, "falls towards this azimuth"),
    (3, MISSING, "not found"),
)


def cell_edges(centres: NDArray[np.float64]) -> NDArray[np.float64]:
    """Edges of cells half-way between their centres, the outer ones symmetric; a single cell spans a tenth of its value."""
    if centres.size == 1:
        return np.array([0.95, 1.05]) * centres[0]
    between = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - between[0]], between, [2 * centres[-1] - between[-1]]])


def azimuth_edges(azimuth_deg: NDArray[np.float64]) -> NDArray[np.float64]:
    """Edges of azimuth cells closed around the compass, radians: one more than azimuths, ascending over one turn."""
    if azimuth_deg.size == 1:
        return np.radians(azimuth_deg[0] + np.array([-2.5, 2.5]))
    next_one = np.append(azimuth_deg[1:], azimuth_deg[0] + 360.0)
    after = (azimuth_deg + next_one) / 2
    return np.radians(np.append(after[-1] - 360.0, after))


def draw_fall_map(axes: Any, cells: "xr.DataArray") -> None:
    """Draw one panel.

    Parameters
    ----------
    axes : polar Axes
        Where to draw.
    cells : xarray.DataArray, dimensions azimuth, b_over_h
        ``overturned`` by azimuth: +1, 0, −1, or NaN where it was not found.
    """
    from matplotlib.colors import ListedColormap

    values = cells.transpose("b_over_h", "azimuth").to_numpy()
    kinds = np.select([np.isnan(values), values > 0, values < 0], [3, 2, 1], 0)
    compass(axes)
    axes.grid(False)
    theta = azimuth_edges(cells["azimuth"].to_numpy().astype(np.float64))
    radius = cell_edges(cells["b_over_h"].to_numpy())
    colours = ListedColormap([colour for _, colour, _ in _KINDS])
    axes.pcolormesh(theta, radius, kinds, cmap=colours, vmin=-0.5, vmax=3.5, rasterized=True, shading="flat")
    radius_ticks(axes, radius[-1], float(radius.mean()))
    axes.yaxis.grid(True, linewidth=0.4)


def fall_map_figure(cube: "xr.Dataset", title: str) -> "Figure":
    """Figure of one record: a panel per friction and height.

    Parameters
    ----------
    cube : xarray.Dataset
        One record of the cube, or any dataset with ``overturned`` over azimuth, height, b_over_h and friction.
    title : str
        Title of the figure.

    Returns
    -------
    matplotlib Figure
    """
    from matplotlib.patches import Patch

    figure, panels = case_panels(cube["overturned"])
    for axes, cells in blocks_of(cube["overturned"], panels):
        draw_fall_map(axes, cells)
    mark_normals(cube, panels)
    found = bool(cube["overturned"].notnull().all())
    handles = [Patch(facecolor=colour, edgecolor="#777777", linewidth=0.4, label=text) for _, colour, text in _KINDS]
    lines, _ = panels[0, 0].get_legend_handles_labels()
    figure.legend(
        handles=(handles[:3] if found else handles) + lines,
        loc="outside lower center",
        ncols=2,
        fontsize=8,
    )
    figure.suptitle(f"{title}\nradius: slenderness B/H", fontsize=10, parse_math=False)
    return figure
