"""Polar maps of the falls of 2-D blocks: by azimuth of the motion and B/H."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import Normal, withStroke
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.figures import style
from overturning.figures.cells import (
    azimuth_cell_edges_rad,
    azimuths_simulated_or_known_by_symmetry_deg,
    b_over_h_cell_edges,
    count_b_over_h_rings_to_draw,
    extend_azimuths_to_full_circle,
    isolated_curve_point_indices,
    panel_row_and_column_counts,
    symmetric_polar_curve_angles_rad_and_radii,
)
from overturning.figures.compass import COLOUR_BAR_AXES_LABEL, b_over_h_ring_labels, create_compass_grid
from overturning.figures.film_words import station_and_event_text_of_cube
from overturning.labels import friction_label
from overturning.model.planes import fall_probabilities_towards_and_away
from overturning.motion.direction import angle_between_azimuths
from overturning.statistics.reference_directions import azimuth_away_from_epicentre
from overturning.units import CM

PANEL_WIDTH_INCHES_BY_COLUMN_COUNT: Final = {1: 4.1, 2: 3.0, 3: 2.15}
"""Width of a panel, inches, by the number of panels in a row, so that a full row fills the page."""

TITLE_LETTER_WIDTH_INCHES: Final = 0.075
"""Width of a letter of a panel's title, inches."""

MAX_UNSPLIT_CELL_WIDTH_DEG: Final = 2.0
"""Largest width of a drawn cell, degrees: wider cells are split, so that their edges look like arcs, not chords."""

PROBABILITY_COLOURMAP: Final = LinearSegmentedColormap.from_list("probability", style.PROBABILITY_COLOUR_STOPS)
"""Colours of the probability of falling towards an azimuth, 0 to 1, with monotonically decreasing lightness."""

OUTLINED_FALL_PROBABILITY: Final = 0.5
"""Share of runs that fall, to either side, along the black line."""

_HALF_PROBABILITY_LINE_STYLE: Final[dict[str, Any]] = {
    "color": "black",
    "linewidth": 1.2,
    "solid_capstyle": "projecting",
}
_PEAK_VELOCITY_LINE_STYLE: Final[dict[str, Any]] = {"color": style.SERIES_COLOURS[2], "linewidth": 0.9}
_SIMULATED_AREA_EDGE_COLOUR: Final = "#777777"
_SIMULATED_AREA_EDGE_STYLE: Final[dict[str, Any]] = {"linewidth": 0.5, "zorder": 2.4}
_STANDS_PATCH_STYLE: Final = {"facecolor": style.STANDS_COLOUR, "edgecolor": style.HATCH_COLOUR, "hatch": "/////"}
_NO_OUTCOME_PATCH_STYLE: Final = {"facecolor": style.MISSING_COLOUR, "edgecolor": "white", "hatch": "xxxx"}


@dataclass(frozen=True)
class PolarMapPanel:
    """Polar map of the outcomes of one block under one record, by azimuth and B/H.

    Attributes
    ----------
    record_friction_and_height_labels : tuple of str
        Record, friction and height.
    fall_probability_cells : Dataset
        Over the full circle, (b_over_h, azimuth): ``towards`` and ``away``, the probabilities of falling towards the
        azimuth and the opposite one, and ``stands``, True if neither the case nor any of its runs falls.
    is_azimuth_simulated : ndarray of bool
        For each azimuth of the cells, True if it was simulated; the other azimuths only fill gaps in the circle.
    fault_normal_and_radial_deg : tuple of float
        Azimuth of the fault normal, and azimuth of the direction away from the epicentre; NaN if unknown.
    peak_velocity_by_azimuth : DataArray or None
        Peak velocity by azimuth, m/s.
    """

    record_friction_and_height_labels: tuple[str, str, str]
    fall_probability_cells: xr.Dataset
    is_azimuth_simulated: NDArray[np.bool_]
    fault_normal_and_radial_deg: tuple[float, float]
    peak_velocity_by_azimuth: xr.DataArray | None

    @property
    def b_over_h_edges(self) -> FloatArray:
        """Edges of the map's cells along the radius, in B/H, ascending."""
        return b_over_h_cell_edges(self.fall_probability_cells["b_over_h"].to_numpy().astype(np.float64))


def fall_map_by_azimuth_figure(
    cubes: xr.Dataset | Sequence[xr.Dataset], title: str, peak_velocities_by_azimuth: Sequence[xr.DataArray | None] = ()
) -> Figure:
    """Draw polar maps of the falls by azimuth and B/H: one map per record, height and friction, on one scale.

    A cell is grey and hatched if none of its runs falls; otherwise it is white to dark by the probability of falling
    towards its azimuth. A black line encloses the cells of which half of the runs fall, to either side. Nothing is
    drawn where nothing was simulated: a sector is as wide as the grid's step, or 5° wide for a single plane (one
    azimuth, or two opposite ones), which has no step. A height or friction that all panels share is written once above
    them.

    Parameters
    ----------
    cubes : Dataset or sequence of Dataset
        Cubes of one record each: any datasets with ``overturned`` over azimuth, height, b_over_h and friction. The
        probabilities of an ensemble are shown if a cube has them; otherwise a probability is 0 or 1.
    title : str
        Title above all panels.
    peak_velocities_by_azimuth : sequence of DataArray or None
        Peak velocity by azimuth, m/s, of each record; drawn as a line around the middle of its maps.
    """
    records = [cubes] if isinstance(cubes, xr.Dataset) else list(cubes)
    panels = _create_map_panels_by_record_height_and_friction(records, peak_velocities_by_azimuth)
    outer = len(records) if len(records) > 1 else records[0].sizes["height"]
    rows, columns = panel_row_and_column_counts(outer, len(panels) // outer)
    size = (
        max(PANEL_WIDTH_INCHES_BY_COLUMN_COUNT[columns] * columns + 0.2, 4.3),
        (PANEL_WIDTH_INCHES_BY_COLUMN_COUNT[columns] + 0.1) * rows + (1.85 if columns == 1 else 1.5),
    )
    figure, grid = create_compass_grid(rows, columns, *size, visible_count=len(panels))
    top = max(float(panel.b_over_h_edges[-1]) for panel in panels)
    rim = round_up_velocity_at_map_rim(
        max(
            (float(one.peak_velocity_by_azimuth.max()) for one in panels if one.peak_velocity_by_azimuth is not None),
            default=0,
        )
    )
    shared = [len({panel.record_friction_and_height_labels[place] for panel in panels}) == 1 for place in range(3)]
    used = grid.ravel()[: len(panels)].tolist()
    for axes, panel in zip(used, panels, strict=True):
        own = [
            name
            for name, same in zip(panel.record_friction_and_height_labels, shared, strict=True)
            if name and not same
        ]
        mesh = _draw_polar_fall_map_and_return_mesh(axes, panel, top, rim)
        axes.write_title(
            _panel_title(own, int(PANEL_WIDTH_INCHES_BY_COLUMN_COUNT[columns] / TITLE_LETTER_WIDTH_INCHES))
        )
    write_radius_meaning_with_arrow(used[0], "stouter")
    spread = any("probability_towards" in one and bool(one["probability_towards"].notnull().any()) for one in records)
    if spread:
        below = figure.add_axes((0.2, 0.1, 0.6, 0.02), label=COLOUR_BAR_AXES_LABEL)  # the layout moves it
        bar = figure.colorbar(mesh, cax=below, orientation="horizontal")
        bar.set_label("probability of falling towards this azimuth", fontsize=8)
        bar.ax.tick_params(labelsize=8)
    common = ", ".join(
        name for name, same in zip(panels[0].record_friction_and_height_labels, shared, strict=True) if name and same
    )
    # A line that is broken at its end could not be translated.
    heading = ("\n" if style.is_drawing_for_phone() else "; ").join(filter(None, [common, "radius: slenderness B/H"]))
    style.add_title_and_legend(
        figure,
        f"{title}\n{heading}",
        used[0],
        min(columns, 2),
        legend_handles_before_panel_marks=_polar_map_legend_entries(panels, spread, rim),
    )
    return figure


def _panel_title(parts: Sequence[str], max_letters_per_line: int) -> str:
    """Return the title of a polar map in lines of limited length, from its parts: record, friction and height.

    Quantities such as "H = 0.6 m" stay in one line, since a text broken within a quantity could not be translated.
    """
    title = ", ".join(parts)
    if len(title) <= max_letters_per_line:
        return title
    quantities = [name for name in parts if "=" in name]
    record = [
        line for name in parts if "=" not in name for line in style.wrap_name_into_lines(name, max_letters_per_line)
    ]
    return "\n".join(filter(None, [*record, ", ".join(quantities)]))


def _create_map_panels_by_record_height_and_friction(
    record_cubes: Sequence[xr.Dataset], peak_velocities_by_azimuth: Sequence[xr.DataArray | None]
) -> list[PolarMapPanel]:
    """Return the data of one polar map per record, height and friction, all cut to the same range of B/H."""
    outcomes = {"overturned", "probability_towards", "probability_away"}
    # Each operation of xarray merges all coordinates, of which a record has dozens: keep those of the cells.
    bare = [one[sorted(outcomes.intersection(one))].reset_coords(drop=True) for one in record_cubes]
    whole = [extend_azimuths_to_full_circle(one) for one in bare]
    chance = [fall_probabilities_towards_and_away(one)[["towards", "away"]].compute() for one in whole]
    falls = [abs(one["overturned"]).compute() for one in whole]
    either = [one["towards"] + one["away"] for one in chance]
    rings = max(count_b_over_h_rings_to_draw(*both) for both in zip(either, falls, strict=True))
    panels = []
    for cube, one, any_run, fell, velocity in zip(
        record_cubes, chance, either, falls, [*peak_velocities_by_azimuth, *len(record_cubes) * [None]], strict=False
    ):
        shown = one.assign(stands=(any_run == 0) & ~(fell > 0)).isel(b_over_h=slice(None, rings))
        simulated = np.isin(shown["azimuth"].to_numpy(), azimuths_simulated_or_known_by_symmetry_deg(cube))
        marks = (
            float(cube["fault_normal"]) if "fault_normal" in cube.variables else np.nan,
            float(azimuth_away_from_epicentre(cube)),
        )
        record = station_and_event_text_of_cube(cube)
        labels = [friction_label(cube, friction) for friction in one["friction"].to_numpy().tolist()]
        for height, friction in product(range(one.sizes["height"]), range(one.sizes["friction"])):
            cells = shown.isel(height=height, friction=friction).transpose("b_over_h", "azimuth")
            block = labels[friction], f"H = {float(cells['height']):g} m"
            panels.append(
                PolarMapPanel((record if len(record_cubes) > 1 else "", *block), cells, simulated, marks, velocity)
            )
    return panels


def _draw_polar_fall_map_and_return_mesh(
    axes: Any, panel: PolarMapPanel, rim_b_over_h: float, rim_velocity_m_s: float
) -> Any:
    """Draw one polar map of falls, and return the mesh of its cells for the colour bar.

    The rim of the compass is at the B/H ``rim_b_over_h`` and at the peak velocity ``rim_velocity_m_s``, m/s.
    """
    cells, radius = panel.fall_probability_cells, panel.b_over_h_edges
    axes.draw_compass(
        rim_b_over_h,
        b_over_h_ring_labels(rim_b_over_h, float(radius.mean())),
        azimuth_deg_for_radius_labels(cells, *panel.fault_normal_and_radial_deg),
        leaves_room_for_rim_marks=bool(np.isfinite(panel.fault_normal_and_radial_deg[0])),
        ring_labels_in_front_of_lines=True,
    )
    edges = azimuth_cell_edges_rad(cells["azimuth"].to_numpy().astype(np.float64))
    parts = int(np.ceil(np.degrees(np.diff(edges).max()) / MAX_UNSPLIT_CELL_WIDTH_DEG))
    theta = np.append((edges[:-1, None] + np.diff(edges)[:, None] * np.arange(parts) / parts).ravel(), edges[-1])
    _draw_simulated_area(axes, edges, radius, panel.is_azimuth_simulated)
    towards, stands = (cells[name].to_numpy() for name in ("towards", "stands"))
    hidden = np.repeat(stands | np.isnan(towards), parts, axis=1)
    values = np.ma.masked_where(hidden, np.repeat(towards, parts, axis=1))
    look: dict[str, Any] = {"rasterized": True, "shading": "flat", "zorder": 1.2}
    mesh = axes.pcolormesh(theta, radius, values, cmap=PROBABILITY_COLOURMAP, vmin=0.0, vmax=1.0, **look)
    for ring, missing in enumerate(np.isnan(towards) & panel.is_azimuth_simulated):
        for start, width in start_and_width_rad_of_selected_cell_ranges(missing, edges):
            look = {"bottom": radius[ring], "align": "edge", "linewidth": 0.0, "zorder": 1.4, **_NO_OUTCOME_PATCH_STYLE}
            axes.bar(start, radius[ring + 1] - radius[ring], width, **look)
    axes.plot(
        *half_probability_cell_outline(towards + cells["away"].to_numpy(), edges, radius, parts),
        **_HALF_PROBABILITY_LINE_STYLE,
        zorder=2.5,
    )
    if panel.peak_velocity_by_azimuth is not None and rim_velocity_m_s:
        angles = panel.peak_velocity_by_azimuth["azimuth"].to_numpy().astype(np.float64)
        theta, peaks = symmetric_polar_curve_angles_rad_and_radii(
            angles, panel.peak_velocity_by_azimuth.to_numpy() * rim_b_over_h / rim_velocity_m_s
        )
        casing = [withStroke(linewidth=2.4, foreground="white"), Normal()]
        points = {"marker": ".", "markevery": isolated_curve_point_indices(peaks)}
        axes.plot(theta, peaks, **_PEAK_VELOCITY_LINE_STYLE, **points, zorder=2.6, path_effects=casing)
    normal, radial = panel.fault_normal_and_radial_deg
    style.mark_fault_normal_on_polar_rim(axes, normal)
    style.mark_direction_away_from_epicentre_on_polar_rim(axes, radial)
    return mesh


def _draw_simulated_area(
    axes: Any, azimuth_edges_rad: FloatArray, b_over_h_edges: FloatArray, is_azimuth_simulated: NDArray[np.bool_]
) -> None:
    """Hatch and outline the simulated range of azimuth and B/H; cells with falls are drawn over the hatching."""
    size: dict[str, Any] = {"bottom": b_over_h_edges[0], "align": "edge"}
    for start, width in start_and_width_rad_of_selected_cell_ranges(is_azimuth_simulated, azimuth_edges_rad):
        axes.bar(
            start, b_over_h_edges[-1] - b_over_h_edges[0], width, linewidth=0.0, zorder=1, **size, **_STANDS_PATCH_STYLE
        )
        if width < 2.0 * np.pi:
            axes.bar(
                start,
                b_over_h_edges[-1] - b_over_h_edges[0],
                width,
                facecolor="none",
                edgecolor=_SIMULATED_AREA_EDGE_COLOUR,
                **_SIMULATED_AREA_EDGE_STYLE,
                **size,
            )
            continue
        around = np.linspace(0.0, 2.0 * np.pi, 181)
        for edge in b_over_h_edges[[0, -1]]:
            axes.plot(
                around, np.full(around.size, edge), color=_SIMULATED_AREA_EDGE_COLOUR, **_SIMULATED_AREA_EDGE_STYLE
            )


def start_and_width_rad_of_selected_cell_ranges(
    is_cell_selected: NDArray[np.bool_], azimuth_edges_rad: FloatArray
) -> list[tuple[float, float]]:
    """Return start and width, radians, of each range of adjacent selected azimuth cells on a full circle."""
    if is_cell_selected.all():
        return [(float(azimuth_edges_rad[0]), float(azimuth_edges_rad[-1] - azimuth_edges_rad[0]))]
    found = []
    for start in np.flatnonzero(is_cell_selected & ~np.roll(is_cell_selected, 1)):
        count = int(np.argmin(np.roll(is_cell_selected, -start)))
        widths = np.roll(np.diff(azimuth_edges_rad), -start)[:count]
        found.append((float(azimuth_edges_rad[start]), float(widths.sum())))
    return found


def half_probability_cell_outline(
    fall_probability: FloatArray, azimuth_edges_rad: FloatArray, b_over_h_edges: FloatArray, chords_per_arc: int = 1
) -> tuple[FloatArray, FloatArray]:
    """Return the outline of the cells of a polar map whose fall probability is at least one half.

    The outline runs along the edges of cells, and not next to a cell without an outcome.

    Parameters
    ----------
    fall_probability : array, shape (r, a)
        Probability of a fall to either side, NaN if unknown.
    azimuth_edges_rad : array, shape (a + 1,)
        Edges of the azimuth cells, radians; a line closes around a full circle.
    b_over_h_edges : array, shape (r + 1,)
        Edges of the B/H cells.
    chords_per_arc : int
        Number of chords of an arc.

    Returns
    -------
    tuple of ndarray
        Angles (radians) and radii of the outline's points, with NaN between pieces.
    """
    inside, known = fall_probability >= OUTLINED_FALL_PROBABILITY, ~np.isnan(fall_probability)
    angles, radii = list[FloatArray](), list[FloatArray]()
    pause = np.array([np.nan])
    for ring, cell in np.argwhere((inside[1:] != inside[:-1]) & known[1:] & known[:-1]):
        angles += [np.linspace(azimuth_edges_rad[cell], azimuth_edges_rad[cell + 1], chords_per_arc + 1), pause]
        radii += [np.full(chords_per_arc + 1, b_over_h_edges[ring + 1]), pause]
    beside, beside_known = np.roll(inside, -1, axis=1), np.roll(known, -1, axis=1)
    meets = (inside != beside) & known & beside_known
    meets[:, -1] &= np.isclose(azimuth_edges_rad[-1] - azimuth_edges_rad[0], 2.0 * np.pi)
    for ring, cell in np.argwhere(meets):
        angles += [azimuth_edges_rad[[cell + 1, cell + 1]], pause]
        radii += [b_over_h_edges[[ring, ring + 1]], pause]
    return (np.concatenate(angles), np.concatenate(radii)) if angles else (pause, pause)


def round_up_velocity_at_map_rim(peak_velocity_m_s: float) -> float:
    """Round a peak velocity (m/s) up to a round value in cm/s that is at least 5 % higher; return it in m/s."""
    if not peak_velocity_m_s > 0:
        return 0.0
    needed = peak_velocity_m_s / CM / 0.95
    power = 10.0 ** np.floor(np.log10(needed))
    return float(CM * power * next(one for one in (1, 1.5, 2, 3, 4, 5, 6, 8, 10) if one * power >= needed))


def azimuth_deg_for_radius_labels(map_cells: xr.Dataset, *marked_deg: float) -> float:
    """Return the azimuth, degrees, at which to write the B/H labels: between named directions, where few blocks fall.

    The azimuth has the fewest falls around it, and is not within 20° of a marked axis (`marked_deg`).
    """
    towards, away = (map_cells[name].transpose("b_over_h", "azimuth").to_numpy() for name in ("towards", "away"))
    falls = np.nan_to_num(towards + away, nan=1.0).sum(axis=0)
    azimuth = map_cells["azimuth"].to_numpy().astype(np.float64)
    count = {}
    for middle in np.arange(22.5, 360.0, 45.0):
        away = angle_between_azimuths(azimuth, middle)
        marked = any(abs((middle - axis + 90.0) % 180.0 - 90.0) < 20.0 for axis in marked_deg)
        count[float(middle)] = float(falls[away <= 12.0].sum()) + 1e6 * marked
    return min(count, key=lambda middle: (count[middle], abs(middle - 112.5)))


def write_radius_meaning_with_arrow(axes: Any, outward_meaning: str, font_size_pt: float = 7.5) -> None:
    """Write the meaning of a larger radius, such as "stouter", with an outward arrow at the rim of a polar axis."""
    azimuth = axes.get_rlabel_position() % 360.0
    turn, right = 90.0 - azimuth, azimuth < 180.0
    text, align, pad = (f"{outward_meaning} →", "left", 3.0) if right else (f"← {outward_meaning}", "right", 3.0)
    outward = np.radians(turn)
    axes.annotate(
        text, (np.radians(azimuth), axes.get_ylim()[1]), (pad * np.cos(outward), pad * np.sin(outward)),
        textcoords="offset points", rotation=turn if right else turn + 180.0, rotation_mode="anchor",
        ha=align, va="center", fontsize=font_size_pt, annotation_clip=False,
    )  # fmt: skip


def _polar_map_legend_entries(panels: Sequence[PolarMapPanel], is_ensemble: bool, rim_velocity_m_s: float) -> list[Any]:
    """Return the legend entries of everything that is drawn in at least one polar map."""
    if is_ensemble:
        marks = [style.legend_patch(_STANDS_PATCH_STYLE, "no run falls, to either side")]
        marks.append(Line2D([], [], **_HALF_PROBABILITY_LINE_STYLE, label="half of the runs fall, to either side"))
    else:
        marks = [style.legend_patch(PROBABILITY_COLOURMAP(1.0), "falls towards this azimuth")]
        marks += [
            style.legend_patch(PROBABILITY_COLOURMAP(0.0), "falls to the other side"),
            style.legend_patch(_STANDS_PATCH_STYLE, "stands"),
        ]
    if any(
        bool((panel.fall_probability_cells["towards"].isnull() & panel.is_azimuth_simulated).any()) for panel in panels
    ):
        marks.append(style.legend_patch(_NO_OUTCOME_PATCH_STYLE, "no outcome"))
    if (inner := min(float(panel.b_over_h_edges[0]) for panel in panels)) > 0:
        marks.append(style.legend_patch("none", f"not computed (B/H below {inner:.3g})"))
    if not all(panel.is_azimuth_simulated.all() for panel in panels):
        marks.append(style.legend_patch("none", "not computed (azimuths outside the outline)"))
    if rim_velocity_m_s:
        label = f"peak velocity by azimuth (rim: {rim_velocity_m_s / CM:g} cm/s)"
        marks.append(Line2D([], [], **_PEAK_VELOCITY_LINE_STYLE, label=label))
    return marks
