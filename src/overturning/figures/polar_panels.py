"""Grids of compasses with slenderness as radius, one panel per block: what the polar maps have in common."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine

from overturning.arrays import FloatArray
from overturning.figures.style import compass, grid, mark_fault_normal, slenderness_ticks
from overturning.statistics.falls import whole_circle

PANEL = {1: 4.6, 2: 2.9, 3: 1.95}
"""Width of a panel, inches, by the number in a row: together they fill a page. More panels go into further rows."""

STEP_DEG = 2.0
"""Cells are drawn in parts no wider than this, so that their inner and outer edges are arcs and not chords."""


def rows_and_columns(heights: int, frictions: int) -> tuple[int, int]:
    """Rows and columns of panels for heights and frictions: a row per height where they fit, at most three columns."""
    count = heights * frictions
    columns = frictions if heights > 1 and 1 < frictions <= max(PANEL) else min(count, max(PANEL))
    columns = 2 if count == 4 else columns
    return -(-count // columns), columns


def case_panels(blocks: xr.Dataset | xr.DataArray, *, more_width: float = 0.0) -> tuple[Figure, Any]:
    """A figure with a compass per height and friction, laid out by `rows_and_columns`.

    ``more_width`` is room for a colour bar, inches. Panels that stay empty are hidden; take them by `blocks_of`.
    """
    rows, columns = rows_and_columns(blocks["height"].size, blocks["friction"].size)
    apart = ConstrainedLayoutEngine(h_pad=0.11)  # the letters below a panel stay clear of the title of the next
    side = PANEL[columns]
    figure, panels = grid(
        rows, columns, side * columns + more_width, (side + 0.2) * rows + 0.8, polar=True, layout=apart
    )
    for axes in panels.flat[blocks["height"].size * blocks["friction"].size :]:
        axes.set_visible(False)
    return figure, panels


def blocks_of(blocks: Any, panels: Any) -> Iterator[tuple[Any, Any]]:
    """Each panel with its block, its title set: heights outside, frictions inside."""
    places = np.ndindex(blocks["height"].size, blocks["friction"].size)
    for axes, (row, column) in zip(panels.flat, places, strict=False):
        one = blocks.isel(height=row, friction=column)
        axes.set_title(f"µ = {float(one['friction']):g}, H = {float(one['height']):g} m", pad=3, fontsize=9)
        yield axes, one


def closed(cube: xr.Dataset) -> xr.Dataset:
    """A cube whose cells reach round the compass: half of the azimuths give the others; a single one stays alone."""
    return whole_circle(cube) if cube["azimuth"].size > 1 else cube


def cell_edges(centres: FloatArray) -> FloatArray:
    """Edges of cells half-way between centres, the outer ones symmetric; a single cell spans a tenth of its value."""
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
    edges = azimuth_edges(cells["azimuth"].to_numpy().astype(np.float64))
    parts = int(np.ceil(np.degrees(np.diff(edges).max()) / STEP_DEG))
    theta = np.append((edges[:-1, None] + np.diff(edges)[:, None] * np.arange(parts) / parts).ravel(), edges[-1])
    radius = cell_edges(cells["b_over_h"].to_numpy().astype(np.float64))
    mesh = axes.pcolormesh(theta, radius, np.repeat(values, parts, axis=1), rasterized=True, shading="flat", **colours)
    slenderness_ticks(axes, radius[-1], float(radius.mean()))
    axes.yaxis.grid(True, linewidth=0.4)
    return mesh


def mark_normals(cube: xr.Dataset, panels: Any) -> None:
    """Mark the fault normal of a cube of one record, where it is known, on every panel that is shown."""
    for axes in panels.flat:
        if axes.get_visible() and "fault_normal" in cube.variables:
            mark_fault_normal(axes, float(cube["fault_normal"]))
