"""Maps of falls under one record: by azimuth and B/H (2-D, `polar_map`), or by orientation and B/H (3-D)."""

from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator

from overturning.arrays import FloatArray
from overturning.figures import style
from overturning.figures.cells import b_over_h_cell_edges, cell_edges, trim_rings_without_falls_except_innermost
from overturning.figures.polar_map import fall_map_by_azimuth_figure
from overturning.figures.rose import draw_fall_rose
from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.statistics.reference_directions import azimuth_away_from_epicentre
from overturning.statistics.roses import fall_rose

_FULL_CIRCLE_ANGLES_RAD = np.linspace(0.0, 2.0 * np.pi, 256, endpoint=False)[:, None]
AZIMUTH_COLOURMAP: Final = ListedColormap(
    0.56
    + 0.26 * np.cos(_FULL_CIRCLE_ANGLES_RAD)
    + np.sin(_FULL_CIRCLE_ANGLES_RAD) * np.array([0.18, 0.04, -0.28])  # light and dark; yellow and blue
)
"""Cyclic colours of azimuths: light for north, dark for south, ochre for east, blue for west.

They can be distinguished with red-green colour blindness; arrows show the same azimuths.
"""

MAX_ARROWS_PER_AXIS: Final = 36
"""Largest number of arrows along each axis of a map."""

_MIN_AND_MAX_ARROW_LENGTH_OVER_MAP_WIDTH: Final = (1 / 30, 1 / 10)
"""Least and largest length of an arrow, as a share of the width of its map."""


def fall_azimuths_by_orientation_and_b_over_h_figure(cube: xr.Dataset, title: str) -> Figure:
    """Draw the fall azimuths of 3-D bodies under one record by orientation and B/H, one panel per block, and a rose."""
    cube = trim_rings_without_falls_except_innermost(cube, cube["overturned"])
    cube = cube if "aspect" in cube.dims else cube.expand_dims(aspect=[1.0])
    blocks = [(height, aspect) for height in cube["height"].to_numpy() for aspect in cube["aspect"].to_numpy()]
    frictions = cube["friction"].to_numpy()
    columns = len(frictions) + 1
    # On a phone the map of one friction and its rose stay next to each other.
    narrow = style.is_drawing_for_phone() and columns == 2
    figure = style.create_figure(style.PHONE_FIGURE_WIDTH_INCHES if narrow else 2.2 * columns, 1.95 * len(blocks) + 0.9)
    panels = style.add_panel_grid(figure, len(blocks), columns)
    for row, (height, aspect) in enumerate(blocks):
        for column, friction in enumerate(frictions):
            axes = panels[row, column]
            _draw_fall_azimuths_by_orientation(axes, cube.sel(height=height, aspect=aspect, friction=friction))
            several = f", D/B = {aspect:g}" if cube.sizes["aspect"] > 1 else ""
            axes.set_title(f"µ = {friction:g}, H = {height:g} m{several}", fontsize=8)
            style.label_axes(
                axes, "orientation, degrees" if row == len(blocks) - 1 else "", "B/H" if column == 0 else ""
            )
        panels[row, -1].set_visible(False)
    around = figure.add_subplot(panels[0, -1].get_subplotspec(), projection="polar")
    draw_fall_rose(around, fall_rose(cube.expand_dims("record")))
    around.set_yticklabels([])
    around.tick_params(labelsize=7)
    top = around.get_ylim()[1]
    around.set_ylim(0.0, 1.22 * top)
    ring, rim = np.linspace(0.0, 2.0 * np.pi, 73), [1.08 * top, 1.22 * top]
    hues = ((ring[:-1] + ring[1:]) / 2)[None, :]
    around.pcolormesh(ring, rim, hues, cmap=AZIMUTH_COLOURMAP, vmin=0, vmax=2 * np.pi, rasterized=True)
    style.mark_fault_normal_on_polar_rim(around, float(cube["fault_normal"]))
    style.mark_direction_away_from_epicentre_on_polar_rim(around, float(azimuth_away_from_epicentre(cube)))
    around.set_title("falls of these maps", fontsize=8, pad=3)
    marks = [style.legend_patch(style.STANDS_COLOUR, "stands")]
    if bool(cube["overturned"].isnull().any()):
        marks.append(style.legend_patch(style.MISSING_COLOUR, "no outcome"))
    style.add_title_and_legend(
        figure,
        f"{title}\ncolour and arrow: azimuth of the fall, north up",
        around,
        3,
        legend_handles_before_panel_marks=marks,
    )
    return figure


def _draw_fall_azimuths_by_orientation(axes: Any, body_results_at_one_height_and_friction: xr.Dataset) -> None:
    """Draw the fall azimuths of a 3-D body of one height and friction by orientation and B/H, as colours and arrows."""
    x, y = (
        body_results_at_one_height_and_friction[name].to_numpy().astype(np.float64)
        for name in ("orientation", "b_over_h")
    )
    azimuth = np.radians(
        body_results_at_one_height_and_friction["fall_azimuth"]
        .transpose("b_over_h", "orientation")
        .to_numpy()
        .astype(np.float64)
    )
    missing = (
        body_results_at_one_height_and_friction["overturned"].isnull().transpose("b_over_h", "orientation").to_numpy()
    )
    edges = cell_edges(x) if x.size > 1 else x[0] + np.array([-2.5, 2.5]), b_over_h_cell_edges(y)
    axes.set_facecolor(style.STANDS_COLOUR)
    axes.pcolormesh(
        *edges, np.ma.masked_invalid(azimuth), cmap=AZIMUTH_COLOURMAP, vmin=0.0, vmax=2.0 * np.pi, rasterized=True
    )
    if missing.any():
        axes.pcolormesh(
            *edges, np.ma.masked_where(~missing, missing), cmap=ListedColormap([style.MISSING_COLOUR]), rasterized=True
        )
    across, up = np.meshgrid(x, y)
    # On a fine grid draw only every second (third, …) arrow: more could not be distinguished.
    fell = np.zeros(azimuth.shape, bool)
    thin = tuple(slice(None, None, -(-count // MAX_ARROWS_PER_AXIS)) for count in azimuth.shape)
    fell[thin] = np.isfinite(azimuth)[thin]
    shown = azimuth[fell]
    axes.quiver(
        across[fell], up[fell], np.sin(shown), np.cos(shown), pivot="mid", angles="uv",
        scale=1.0 / _fall_arrow_length_over_map_width(*edges),
        width=0.006, headwidth=4, headlength=4, headaxislength=3.5,
        color=np.where(np.cos(shown) > -0.3, style.INK, "white"),
    )  # fmt: skip
    axes.set(xlim=(edges[0][0], edges[0][-1]), ylim=(edges[1][0], edges[1][-1]))
    axes.xaxis.set_major_locator(MultipleLocator(30 if np.ptp(x) <= 100 else 60 if np.ptp(x) <= 200 else 90))


def _fall_arrow_length_over_map_width(orientation_cell_edges: FloatArray, b_over_h_edges: FloatArray) -> float:
    """Return the length of the fall arrows of a map, as a share of the map width, so that they fit into its cells."""
    across, up = (float(np.diff(edges).min() / np.ptp(edges)) for edges in (orientation_cell_edges, b_over_h_edges))
    return float(
        np.clip(min(0.6 * across, 0.45 * up), *_MIN_AND_MAX_ARROW_LENGTH_OVER_MAP_WIDTH)
    )  # a map is about 3/4 as high as wide


def fall_map_figure(cube: xr.Dataset, title: str, peak_velocity_by_azimuth: xr.DataArray | None = None) -> Figure:
    """Draw the falls under one record by B/H and azimuth of the motion (2-D) or orientation of the body (3-D).

    In 2-D, `peak_velocity_by_azimuth`, m/s, is drawn on the map if given; in 3-D it is not used.
    """
    if default_model_of_same_kind_as_results_cube(cube).is_planar:
        return fall_map_by_azimuth_figure(cube, title, [peak_velocity_by_azimuth])
    return fall_azimuths_by_orientation_and_b_over_h_figure(cube, title)
