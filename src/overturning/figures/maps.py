"""Maps of falls under one record: polar maps by azimuth and B/H (2-D), and maps by orientation and B/H (3-D)."""

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
from overturning.labels import friction_label
from overturning.model.falls import model_of
from overturning.model.planes import fall_probability
from overturning.statistics.earthquakes import radial_azimuth
from overturning.statistics.falls import whole_circle
from overturning.statistics.roses import rose_of

PANEL: Final = {1: 4.3, 2: 2.9, 3: 1.95}
"""Width of a panel, inches, by the number of panels in a row, so that a full row fills the page."""

STEP_DEG: Final = 2.0
"""Largest width of a drawn cell, degrees: wider cells are split, so that their edges look like arcs, not chords."""

MORE_LIKELY: Final = 0.5
"""Probability of falling to one side above which a cell has the colour of that side."""

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
"""Colours of probabilities from 0 to 1, with monotonically decreasing lightness."""

_TURN = np.linspace(0.0, 2.0 * np.pi, 256, endpoint=False)[:, None]
COLOURS: Final = ListedColormap(
    0.56 + 0.26 * np.cos(_TURN) + np.sin(_TURN) * np.array([0.18, 0.04, -0.28])  # light and dark; yellow and blue
)
"""Cyclic colours of azimuths: light for north, dark for south, ochre for east, blue for west.

They can be distinguished with red-green colour blindness; arrows show the same azimuths.
"""

MOST_ARROWS: Final = 36
"""Largest number of arrows along each axis of a map."""


def plane_map_figure(cube: xr.Dataset, title: str) -> Figure:
    """Draw polar maps of the falls of one record by azimuth and B/H, a panel per friction and height.

    `cube` is any dataset with ``overturned`` over azimuth, height, b_over_h and friction. If it has the probabilities
    of an ensemble, these are shown.
    """
    spread = "probability_towards" in cube and bool(cube["probability_towards"].notnull().any())
    whole = close_circle(cube)
    chance = fall_probability(whole)[["towards", "away"]].compute()
    blocks = list(np.ndindex(chance["height"].size, chance["friction"].size))
    rows, columns = rows_and_columns(chance["height"].size, chance["friction"].size)
    # Keep the tick labels of a panel clear of the title of the panel below.
    apart = ConstrainedLayoutEngine(h_pad=0.11 if rows > 1 else 0.02)
    width, height = PANEL[columns] * columns + 0.85 * spread, (PANEL[columns] + 0.2) * rows + 0.8
    figure, panels = style.grid(rows, columns, width, height, used=len(blocks), polar=True, layout=apart)
    shown = trim_empty_rings(chance, chance["towards"] + chance["away"], abs(whole["overturned"]))
    shown = shown.transpose("height", "friction", "b_over_h", "azimuth")
    normal = float(cube["fault_normal"]) if "fault_normal" in cube.variables else float("nan")
    radial = float(radial_azimuth(cube))
    for axes, (row, column) in zip(panels.flat, blocks, strict=False):
        cells = shown.isel(height=row, friction=column)
        friction = friction_label(cube, float(cells["friction"]))
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
        axes.set_rlabel_position(radius_label_azimuth(cells, normal, radial))
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


def trim_empty_rings(cube: xr.Dataset, *falls: xr.DataArray) -> xr.Dataset:
    """Return a dataset without the outer B/H rings in which no fall is possible, except the first of these.

    A fall is possible if a value of `falls` (flags or probabilities; a block may fall although its neighbours stand) is
    above 0, or missing in a direction that was simulated. The dataset is unchanged if no fall is possible anywhere.
    """

    def possible(one: xr.DataArray) -> xr.DataArray:
        computed = one.notnull().any([name for name in one.dims if name not in {"azimuth", "orientation"}])
        return ((one.isnull() & computed) | (one > 0)).any([name for name in one.dims if name != "b_over_h"])

    last = np.flatnonzero(sum(map(possible, falls)))
    return cube.isel(b_over_h=slice(None, int(last[-1]) + 2)) if last.size else cube


def radius_label_azimuth(cells: xr.Dataset, *marked_deg: float) -> float:
    """Return the azimuth, degrees, for the labels of the radius: half-way between two named directions.

    It is the one with the fewest falls around it that is not within 20° of a marked axis (`marked_deg`).
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
    """Return the numbers of rows and columns of panels: a row per height if it fits, at most three columns."""
    count = heights * frictions
    columns = frictions if heights > 1 and 1 < frictions <= max(PANEL) else min(count, max(PANEL))
    columns = 2 if count == 4 else columns
    return -(-count // columns), columns


def close_circle(cube: xr.Dataset) -> xr.Dataset:
    """Return a cube extended to the full circle of azimuths; a single azimuth stays as it is.

    The outcomes of opposite azimuths follow from each other. Gaps between azimuths that were not simulated are filled
    with missing values.
    """
    whole = whole_circle(cube) if cube["azimuth"].size > 1 else cube
    unknown = style.gap_edges(whole["azimuth"].to_numpy())
    return whole.reindex(azimuth=np.union1d(whole["azimuth"], unknown)) if unknown.size else whole


def cell_edges(centres: FloatArray) -> FloatArray:
    """Return the edges of cells: half-way between centres, symmetric at the ends; ± 5 % for a single cell."""
    if centres.size == 1:
        return np.array([0.95, 1.05]) * centres[0]
    between = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - between[0]], between, [2 * centres[-1] - between[-1]]])


def slenderness_edges(b_over_h: FloatArray) -> FloatArray:
    """Return the edges of B/H cells, at least 0: a polar axis would not draw a ring with a negative edge."""
    return np.maximum(cell_edges(b_over_h), 0.0)


def azimuth_edges(azimuth_deg: FloatArray) -> FloatArray:
    """Return the m + 1 edges of m azimuth cells, radians, ascending over the full circle."""
    if azimuth_deg.size == 1:
        return np.radians(azimuth_deg[0] + np.array([-2.5, 2.5]))
    next_one = np.append(azimuth_deg[1:], azimuth_deg[0] + 360.0)
    after = (azimuth_deg + next_one) / 2
    return np.radians(np.append(after[-1] - 360.0, after))


def draw_cells(axes: Any, cells: xr.Dataset, layers: Sequence[tuple[Any, dict[str, Any]]]) -> list[Any]:
    """Colour the cells of a polar map and return the meshes.

    Each layer is an array of values (b_over_h, azimuth) and the colour options of `pcolormesh`.
    """
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
    """Draw fall azimuths of one record by orientation and B/H, a panel per friction, height and aspect, and a rose."""
    cube = trim_empty_rings(cube, cube["overturned"])
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
        marks.append(style.patch(style.MISSING, "no outcome"))
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
    # On a fine grid draw only every second (third, …) arrow: more could not be distinguished.
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


_MAP_BY_DIRECTION: Final = {"azimuth": plane_map_figure, "orientation": space_map_figure}


def map_figure(cube: xr.Dataset, title: str) -> Figure:
    """Draw the map of falls of one record: by azimuth of the motion (2-D) or by orientation of the body (3-D)."""
    return _MAP_BY_DIRECTION[model_of(cube).direction](cube, title)
