"""Where blocks fall under a record: polar maps of planes by slenderness, and maps of bodies in space by orientation."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.colors import LinearSegmentedColormap, ListedColormap
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import MultipleLocator

from overturning.arrays import FloatArray
from overturning.figures import style
from overturning.figures.rose import draw_rose
from overturning.model.falls import model_of
from overturning.model.planes import fall_probability
from overturning.statistics.earthquakes import radial_azimuth
from overturning.statistics.falls import whole_circle
from overturning.statistics.roses import rose_of
from overturning.study.cube import friction_said

PANEL: Final = {1: 4.3, 2: 2.9, 3: 1.95}
"""Width of a panel, inches, by the number in a row: together they fill a page. More panels go into further rows."""

STEP_DEG: Final = 2.0
"""Cells are drawn in parts no wider than this, so that their inner and outer edges are arcs and not chords."""

MORE_LIKELY: Final = 0.5
"""A cell whose block falls to one side with a larger probability than this is of that kind."""

_KINDS: Final = {
    "stands": style.STANDS,
    "falls to the other side": style.OTHER_SIDE,
    "falls towards the azimuth": style.FALLS,
    "no outcome": style.MISSING,
}

_COLOUR_OF_KIND: Final = ListedColormap(list(_KINDS.values()))

_CHANCE: Final = LinearSegmentedColormap.from_list(
    "probability", [style.STANDS, "#f6c9a0", "#e58a4b", style.FALLS, style.DARKEST]
)
"""Probability from 0 (paper) to 1 (the colour of falls, then darker): lightness falls all the way."""

_TURN = np.linspace(0.0, 2.0 * np.pi, 256, endpoint=False)[:, None]
COLOURS: Final = ListedColormap(
    0.56 + 0.26 * np.cos(_TURN) + np.sin(_TURN) * np.array([0.18, 0.04, -0.28])  # light and dark; yellow and blue
)
"""Of azimuths: light to the north and dark to the south, ochre to the east and blue to the west.

Those who see no red or green see both; arrows say the same.
"""

MOST_ARROWS: Final = 36
"""Arrows along each side of a map."""


def plane_map_figure(cube: xr.Dataset, title: str) -> Figure:
    """Azimuth of the fall × slenderness of one record of a cube, a compass per friction and height.

    Any dataset with ``overturned`` over azimuth, height, b_over_h and friction will do; where it has the ensemble's
    probabilities, these are shown.
    """
    spread = "probability_towards" in cube and bool(cube["probability_towards"].notnull().any())
    whole = closed(cube)
    chance = fall_probability(whole)[["towards", "away"]].compute()
    blocks = list(np.ndindex(chance["height"].size, chance["friction"].size))
    rows, columns = rows_and_columns(chance["height"].size, chance["friction"].size)
    # The letters below a panel stay clear of the title of the next.
    apart = ConstrainedLayoutEngine(h_pad=0.11 if rows > 1 else 0.02)
    width, height = PANEL[columns] * columns + 0.85 * spread, (PANEL[columns] + 0.2) * rows + 0.8
    figure, panels = style.grid(rows, columns, width, height, used=len(blocks), polar=True, layout=apart)
    shown = out_to_the_first_ring_without_falls(chance, chance["towards"] + chance["away"], abs(whole["overturned"]))
    shown = shown.transpose("height", "friction", "b_over_h", "azimuth")
    normal = float(cube["fault_normal"]) if "fault_normal" in cube.variables else float("nan")
    radial = float(radial_azimuth(cube))
    for axes, (row, column) in zip(panels.flat, blocks, strict=False):
        cells = shown.isel(height=row, friction=column)
        friction = friction_said(cube, float(cells["friction"]))
        axes.set_title(f"{friction}, H = {float(cells['height']):g} m", pad=3, fontsize=9)
        towards, away = (cells[name].to_numpy() for name in ("towards", "away"))
        kinds = np.select([np.isnan(towards), away > MORE_LIKELY, towards > MORE_LIKELY], [3, 1, 2], 0)
        layers: list[tuple[Any, dict[str, Any]]] = []
        if spread:
            shaded = (kinds == 0) | (kinds == 2)
            layers.append((np.ma.masked_where(~shaded, towards), {"cmap": _CHANCE, "vmin": 0.0, "vmax": 1.0}))
            kinds = np.ma.masked_where(shaded, kinds)
        layers.append((kinds, {"cmap": _COLOUR_OF_KIND, "vmin": -0.5, "vmax": 3.5}))
        mesh, *_ = draw_cells(axes, cells, layers)
        axes.set_rlabel_position(free_sector(cells, normal, radial))
        style.mark_fault_normal(axes, normal)
        style.mark_radial(axes, radial)
    marks = [style.patch(colour, kind) for kind, colour in _KINDS.items()]
    if spread:
        last = next(axes for axes in panels[0][::-1] if axes.get_visible())
        bar = figure.colorbar(mesh, cax=last.inset_axes([1.16, 0.0, 0.05, 1.0]))
        between = " " if columns == 1 else "\n"
        bar.set_label(f"probability of falling{between}towards the azimuth", fontsize=8)
        bar.ax.tick_params(labelsize=8)
        del marks[2]
    if bool(chance["towards"].notnull().all()):
        del marks[-1]
    style.caption(figure, f"{title}\nradius: slenderness B/H", panels[0, 0], 2, first=marks)
    return figure


def out_to_the_first_ring_without_falls(cube: xr.Dataset, *falls: xr.DataArray) -> xr.Dataset:
    """A dataset out to the first B/H at and beyond which no fall is possible; all of it where none is anywhere.

    A fall is possible where a flag or probability of `falls` is above 0, since a block may fall of whose neighbourhood
    nothing does, or not known, but in directions of which nothing at all is known: these were not computed.
    """

    def possible(one: xr.DataArray) -> xr.DataArray:
        computed = one.notnull().any([name for name in one.dims if name not in {"azimuth", "orientation"}])
        return ((one.isnull() & computed) | (one > 0)).any([name for name in one.dims if name != "b_over_h"])

    last = np.flatnonzero(sum(map(possible, falls)))
    return cube.isel(b_over_h=slice(None, int(last[-1]) + 2)) if last.size else cube


def free_sector(cells: xr.Dataset, *marked_deg: float) -> float:
    """Azimuth, half-way between two of the eight that are named, at which the fewest cells fall: room for letters.

    Not within 20° of an axis that is marked there.
    """
    towards, away = (cells[name].transpose("b_over_h", "azimuth").to_numpy() for name in ("towards", "away"))
    falls = np.nan_to_num(towards + away, nan=1.0).sum(axis=0)
    azimuth = cells["azimuth"].to_numpy().astype(np.float64)
    count = {}
    for middle in np.arange(22.5, 360.0, 45.0):
        away = np.abs((azimuth - middle + 180.0) % 360.0 - 180.0)
        marked = any(abs((middle - axis + 90.0) % 180.0 - 90.0) < 20.0 for axis in marked_deg)
        count[float(middle)] = float(falls[away <= 12.0].sum()) + 1e6 * marked
    return min(count, key=lambda middle: (count[middle], abs(middle - 112.5)))


def rows_and_columns(heights: int, frictions: int) -> tuple[int, int]:
    """Rows and columns of panels for heights and frictions: a row per height where they fit, at most three columns."""
    count = heights * frictions
    columns = frictions if heights > 1 and 1 < frictions <= max(PANEL) else min(count, max(PANEL))
    columns = 2 if count == 4 else columns
    return -(-count // columns), columns


def closed(cube: xr.Dataset) -> xr.Dataset:
    """A cube whose cells reach round the compass: half of the azimuths give the others; a single one stays alone.

    Between azimuths that a study leaves out, as of the part of a circle, nothing is known.
    """
    whole = whole_circle(cube) if cube["azimuth"].size > 1 else cube
    unknown = style.beyond_the_grid(whole["azimuth"].to_numpy())
    return whole.reindex(azimuth=np.union1d(whole["azimuth"], unknown)) if unknown.size else whole


def cell_edges(centres: FloatArray) -> FloatArray:
    """Edges of cells half-way between centres, the outer ones symmetric; a single cell spans a tenth of its value."""
    if centres.size == 1:
        return np.array([0.95, 1.05]) * centres[0]
    between = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - between[0]], between, [2 * centres[-1] - between[-1]]])


def slenderness_edges(b_over_h: FloatArray) -> FloatArray:
    """Edges of cells of B/H: none lies below 0, where a compass would leave out the whole ring."""
    return np.maximum(cell_edges(b_over_h), 0.0)


def azimuth_edges(azimuth_deg: FloatArray) -> FloatArray:
    """Edges of azimuth cells closed around the compass, radians: one more than azimuths, ascending over one turn."""
    if azimuth_deg.size == 1:
        return np.radians(azimuth_deg[0] + np.array([-2.5, 2.5]))
    next_one = np.append(azimuth_deg[1:], azimuth_deg[0] + 360.0)
    after = (azimuth_deg + next_one) / 2
    return np.radians(np.append(after[-1] - 360.0, after))


def draw_cells(axes: Any, cells: xr.Dataset, layers: Sequence[tuple[Any, dict[str, Any]]]) -> list[Any]:
    """Colour the cells of a compass by layers of values (b_over_h, azimuth), each with its colours; their meshes."""
    axes.xaxis.grid(False)
    style.compass(axes)
    edges = azimuth_edges(cells["azimuth"].to_numpy().astype(np.float64))
    parts = int(np.ceil(np.degrees(np.diff(edges).max()) / STEP_DEG))
    theta = np.append((edges[:-1, None] + np.diff(edges)[:, None] * np.arange(parts) / parts).ravel(), edges[-1])
    radius = slenderness_edges(cells["b_over_h"].to_numpy().astype(np.float64))
    meshes = [
        axes.pcolormesh(theta, radius, np.repeat(values, parts, axis=1), rasterized=True, shading="flat", **colours)
        for values, colours in layers
    ]
    style.slenderness_ticks(axes, radius[-1], float(radius.mean()))
    axes.yaxis.grid(True, linewidth=0.4)
    return meshes


def space_map_figure(cube: xr.Dataset, title: str) -> Figure:
    """Fall azimuth by orientation and B/H of one record, a panel per friction, height and aspect; and its rose."""
    cube = out_to_the_first_ring_without_falls(cube, cube["overturned"])
    blocks = [(height, aspect) for height in cube["height"].to_numpy() for aspect in cube["aspect"].to_numpy()]
    frictions = cube["friction"].to_numpy()
    figure, panels = style.grid(len(blocks), len(frictions) + 1, 2.2 * (len(frictions) + 1), 1.95 * len(blocks) + 0.9)
    for row, (height, aspect) in enumerate(blocks):
        for column, friction in enumerate(frictions):
            axes = panels[row, column]
            _draw_orientations(axes, cube.sel(height=height, aspect=aspect, friction=friction))
            several = f", D/B = {aspect:g}" if cube.sizes["aspect"] > 1 else ""
            axes.set_title(f"µ = {friction:g}, H = {height:g} m{several}", fontsize=8)
            style.labels(axes, "orientation, degrees" if row == len(blocks) - 1 else "", "B/H" if column == 0 else "")
        panels[row, -1].set_visible(False)
    around = figure.add_subplot(panels[0, -1].get_subplotspec(), projection="polar")
    draw_rose(around, rose_of(cube.expand_dims("record")))
    around.set_yticklabels([])
    around.tick_params(labelsize=7)
    top = around.get_ylim()[1]
    around.set_ylim(0.0, 1.22 * top)
    ring, rim = np.linspace(0.0, 2.0 * np.pi, 73), [1.08 * top, 1.22 * top]
    hues = ((ring[:-1] + ring[1:]) / 2)[None, :]
    around.pcolormesh(ring, rim, hues, cmap=COLOURS, vmin=0, vmax=2 * np.pi, rasterized=True)
    style.mark_fault_normal(around, float(cube["fault_normal"]))
    style.mark_radial(around, float(radial_azimuth(cube)))
    around.set_title("falls of these maps", fontsize=8, pad=3)
    marks = [style.patch(style.STANDS, "stands")]
    if bool(cube["overturned"].isnull().any()):
        marks.append(style.patch(style.MISSING, "not found"))
    style.caption(figure, f"{title}\ncolour and arrow: azimuth of the fall, north up", around, 3, first=marks)
    return figure


def _draw_orientations(axes: Any, cells: xr.Dataset) -> None:
    x, y = (cells[name].to_numpy().astype(np.float64) for name in ("orientation", "b_over_h"))
    azimuth = np.radians(cells["fall_azimuth"].transpose("b_over_h", "orientation").to_numpy().astype(np.float64))
    missing = cells["overturned"].isnull().transpose("b_over_h", "orientation").to_numpy()
    edges = cell_edges(x) if x.size > 1 else x[0] + np.array([-2.5, 2.5]), slenderness_edges(y)
    axes.set_facecolor(style.STANDS)
    axes.pcolormesh(*edges, np.ma.masked_invalid(azimuth), cmap=COLOURS, vmin=0.0, vmax=2.0 * np.pi, rasterized=True)
    if missing.any():
        axes.pcolormesh(
            *edges, np.ma.masked_where(~missing, missing), cmap=ListedColormap([style.MISSING]), rasterized=True
        )
    across, up = np.meshgrid(x, y)
    # Of finer grids arrows of every second cell, or third: more could not be told apart.
    fell = np.zeros(azimuth.shape, bool)
    thin = tuple(slice(None, None, -(-count // MOST_ARROWS)) for count in azimuth.shape)
    fell[thin] = np.isfinite(azimuth)[thin]
    shown = azimuth[fell]
    axes.quiver(
        across[fell], up[fell], np.sin(shown), np.cos(shown), pivot="mid", angles="uv", scale=30, width=0.006,
        headwidth=4, headlength=4, headaxislength=3.5, color=np.where(np.cos(shown) > -0.3, style.INK, "white"),
    )  # fmt: skip
    axes.set(xlim=(edges[0][0], edges[0][-1]), ylim=(edges[1][0], edges[1][-1]))
    axes.xaxis.set_major_locator(MultipleLocator(30 if np.ptp(x) <= 100 else 60 if np.ptp(x) <= 200 else 90))


_OF_DIRECTION: Final = {"azimuth": plane_map_figure, "orientation": space_map_figure}


def map_figure(cube: xr.Dataset, title: str) -> Figure:
    """Where the blocks of one record of a cube fall: round the compass, or, of bodies in space, by orientation."""
    return _OF_DIRECTION[model_of(cube).direction](cube, title)
