"""Grids of compasses with slenderness as radius, one panel per block: what the polar maps have in common."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from overturning.arrays import FloatArray
from overturning.figures.style import compass, grid, mark_fault_normal, slenderness_ticks

MOST_IN_A_ROW = 4
"""Panels side by side where only one of height and friction varies; more go into further rows."""


def case_panels(blocks: xr.Dataset | xr.DataArray, *, more_width: float = 0.0) -> tuple[Figure, Any]:
    """A figure with a compass per friction (columns) and height (rows), or in rows of four where there is one of either only.

    ``more_width`` is room for a colour bar, inches. Panels that stay empty are hidden; take them by `blocks_of`.
    """
    rows, columns = blocks["height"].size, blocks["friction"].size
    count = rows * columns
    if min(rows, columns) == 1 and count > 1:
        columns = min(count, MOST_IN_A_ROW if columns == 1 and count > 3 else columns, MOST_IN_A_ROW)
        rows = -(-count // columns)
    apart = ConstrainedLayoutEngine(h_pad=0.11)  # the letters below a panel stay clear of the title of the next
    width = max(2.35 * columns, 4.4) + more_width
    figure, panels = grid(rows, columns, width, 2.45 * rows + 1.05, polar=True, layout=apart)
    for axes in panels.flat[count:]:
        axes.set_visible(False)
    return figure, panels


def blocks_of(blocks: Any, panels: Any) -> Iterator[tuple[Any, Any]]:
    """Each panel with its block, its title set: heights outside, frictions inside."""
    places = np.ndindex(blocks["height"].size, blocks["friction"].size)
    for axes, (row, column) in zip(panels.flat, places, strict=False):
        one = blocks.isel(height=row, friction=column)
        axes.set_title(f"µ = {float(one['friction']):g}, H = {float(one['height']):g} m", pad=3, fontsize=9)
        yield axes, one


def cell_edges(centres: FloatArray) -> FloatArray:
    """Edges of cells half-way between their centres, the outer ones symmetric; a single cell spans a tenth of its value."""
    if centres.size == 1:
        return np.array([0.95, 1.05]) * centres[0]
    between = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - between[0]], between, [2 * centres[-1] - between[-1]]])


def azimuth_edges(azimuth_deg: FloatArray) -> FloatArray:
    """Edges of azimuth cells closed around the compass, radians: one more than azimuths, ascending over one turn."""
    if azimuth_deg.size == 1:
        return np.radians(azimuth_deg[0] + np.array([-2.5, 2.5]))
    next_one = np.append(azimuth_deg[1:], azimuth_deg[0] + 360.0)
    after = (azimuth_deg + next_one) / 2
    return np.radians(np.append(after[-1] - 360.0, after))


def draw_cells(axes: Any, cells: xr.DataArray, values: Any, **colours: Any) -> Any:
    """Colour the cells of a compass by ``values`` (b_over_h, azimuth), and return the mesh for a colour bar."""
    compass(axes)
    axes.grid(False)
    theta = azimuth_edges(cells["azimuth"].to_numpy().astype(np.float64))
    radius = cell_edges(cells["b_over_h"].to_numpy().astype(np.float64))
    mesh = axes.pcolormesh(theta, radius, values, rasterized=True, shading="flat", **colours)
    slenderness_ticks(axes, radius[-1], float(radius.mean()))
    axes.yaxis.grid(True, linewidth=0.4)
    return mesh


def mark_normals(cube: xr.Dataset, panels: Any) -> None:
    """Mark the fault normal of a cube of one record, where it is known, on every panel that is shown."""
    for axes in panels.flat:
        if axes.get_visible() and "fault_normal" in cube.variables:
            mark_fault_normal(axes, float(cube["fault_normal"]))
