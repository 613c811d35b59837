"""Compasses: polar panels with north at the top, of few drawing objects, and a layout of several of them.

The ticks of a polar panel take most of the time to draw it: each has three lines and two texts, and Matplotlib measures
it several times. A panel of this module has no ticks, but one path for all rings, and one text for each name.
"""

import warnings
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from matplotlib import rcParams
from matplotlib.backends.backend_agg import RendererAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.patches import PathPatch
from matplotlib.path import Path
from matplotlib.projections.polar import PolarAxes
from matplotlib.text import Text
from matplotlib.ticker import MaxNLocator
from matplotlib.transforms import Bbox, ScaledTranslation

from overturning.arrays import FloatArray
from overturning.figures.style import create_panel_grid

COMPASS_DIRECTION_NAMES: Final = ("N", "NE", "E", "SE", "S", "SW", "W", "NW")

COLOUR_BAR_AXES_LABEL: Final = "<colorbar>"
"""Label of the axes of a colour bar, as Matplotlib gives it."""

_DIRECTION_NAME_FONT_SIZE_PT: Final = 9.0
"""Size of the names of directions, pt."""

_DIRECTION_NAME_DISTANCE_FROM_RIM_PT: Final = 7.0
"""Distance of the middle of a name from the rim, pt, if nothing is marked at the rim."""

_EXTRA_NAME_DISTANCE_FOR_MARKS_PT: Final = 4.0
"""Distance by which names move outward to make room for marks at the rim, pt."""

_COLOUR_BAR_TICK_AND_LABEL_SPACE_PT: Final = 28.0
"""Height of the tick labels and of the label below a colour bar, pt."""

_COLOUR_BAR_HEIGHT_PT: Final = 6.0
"""Height of a colour bar, pt."""

_FIGURE_MARGIN_PT: Final = 3.0
"""Margin at the edge of a figure, pt."""

_GAP_BETWEEN_FIGURE_PARTS_PT: Final = 4.0
"""Distance between texts of neighbouring compasses, and between the parts of a figure, pt."""

_MIN_COMPASS_DIAMETER_PT: Final = 12.0
"""Smallest diameter of a compass that is drawn, pt."""


class CompassAxes(PolarAxes):
    """Polar panel with north at the top and clockwise angles.

    Its direction names are texts, and its rings are one path.

    Attributes
    ----------
    direction_and_ring_labels : list of Text
        The names of directions and the labels of rings, which are the same in all panels of a figure.
    """

    direction_and_ring_labels: list[Text]
    _is_initialised: bool = False

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, theta_offset=np.pi / 2.0, theta_direction=-1, **kwargs)
        self._name_distance = _DIRECTION_NAME_DISTANCE_FROM_RIM_PT
        self._is_initialised = True

    def clear(self) -> None:
        """Remove everything drawn in the compass; the second clearing of a new, empty panel is skipped to save time."""
        if not self._is_initialised and hasattr(self, "fixed_texts"):
            return  # Matplotlib clears new polar panels twice, which takes a fifth of the time of a map
        super().clear()
        self.direction_and_ring_labels = []

    def draw_compass(
        self, compass_rim_radius: float, ring_label_by_radius: Mapping[float, str],
        ring_label_azimuth_deg: float = 112.5,
        *, leaves_room_for_rim_marks: bool = False, has_spokes: bool = False,
        ring_labels_in_front_of_lines: bool = False,
    ) -> None:  # fmt: skip
        """Draw direction names and rings of a compass, and limit its radius to ``compass_rim_radius``; call it once.

        Parameters
        ----------
        compass_rim_radius : float
            Radius of the rim.
        ring_label_by_radius : mapping
            Labels of the rings, by radius.
        ring_label_azimuth_deg : float
            Azimuth at which the rings are labelled, degrees.
        leaves_room_for_rim_marks : bool
            True to leave room between the rim and the names.
        has_spokes : bool
            True to draw lines from the centre towards the named directions.
        ring_labels_in_front_of_lines : bool
            True to draw the labels of rings in front of lines, not behind them.
        """
        self.set_ylim(0.0, compass_rim_radius)
        self.set_rlabel_position(ring_label_azimuth_deg)
        self.xaxis.set_visible(False)
        self.yaxis.set_visible(False)
        self.spines["polar"].set_linewidth(0.6)
        self._draw_compass_rings([radius / compass_rim_radius for radius in ring_label_by_radius], has_spokes)
        self._name_distance = _DIRECTION_NAME_DISTANCE_FROM_RIM_PT + (
            _EXTRA_NAME_DISTANCE_FOR_MARKS_PT if leaves_room_for_rim_marks else 0.0
        )
        scale = self.figure.dpi_scale_trans
        for number, name in enumerate(COMPASS_DIRECTION_NAMES):
            outward = _unit_vector_towards_azimuth(45.0 * number)
            right, up = (float(part) * self._name_distance / 72.0 for part in outward)
            shifted = self.transAxes + ScaledTranslation(right, up, scale)
            self._write_direction_or_ring_label(
                0.5 + 0.5 * outward, name, transform=shifted, ha="center", fontsize=_DIRECTION_NAME_FONT_SIZE_PT
            )
        behind = {"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.85}  # legible on any background
        for radius, label in ring_label_by_radius.items():
            place = 0.5 + 0.5 * radius / compass_rim_radius * _unit_vector_towards_azimuth(ring_label_azimuth_deg)
            look = {"va": "bottom", "ha": "left", "fontsize": 8, "bbox": behind}
            look |= {"zorder": 2.8} if ring_labels_in_front_of_lines else {}
            self._write_direction_or_ring_label(place, label, transform=self.transAxes, **look)

    def write_title(self, title: str, font_size_pt: float = 9.0) -> None:
        """Write a title, of one or more lines, above the name of north."""
        # Half of the name's line and the descenders of the title, as shares of the font sizes.
        pad = self._name_distance + 0.6 * _DIRECTION_NAME_FONT_SIZE_PT + 0.25 * font_size_pt
        self.set_title(title, fontsize=font_size_pt, pad=pad, y=1.0, parse_math=False)

    def _draw_compass_rings(self, ring_to_outer_radius_ratios: Sequence[float], has_spokes: bool) -> None:
        """Draw rings (radii as shares of the outer one) and lines to the named directions of a compass, as one path."""
        lines = [Path.circle((0.5, 0.5), 0.5 * radius) for radius in ring_to_outer_radius_ratios]
        if has_spokes:
            lines += [
                Path(0.5 + np.array([[0.0], [0.5]]) * _unit_vector_towards_azimuth(45.0 * number))
                for number in range(8)
            ]
        if lines:
            width = 0.5 if has_spokes else 0.4
            look = {"edgecolor": rcParams["grid.color"], "linewidth": width, "zorder": 1.5}
            path = Path.make_compound_path(*lines)
            self.add_artist(PathPatch(path, fill=False, clip_on=False, transform=self.transAxes, **look))

    def _write_direction_or_ring_label(self, position_in_axes_fractions: FloatArray, text: str, **look: Any) -> None:
        """Add a direction name or ring label to the compass; vertically centred unless `look` states otherwise."""
        x, y = position_in_axes_fractions.tolist()
        self.direction_and_ring_labels.append(self.text(x, y, text, **{"va": "center", "zorder": 1.5, **look}))


def _unit_vector_towards_azimuth(azimuth_deg: float) -> FloatArray:
    """Return the unit vector (right, up) towards an azimuth, degrees clockwise from the top."""
    angle = np.radians(azimuth_deg)
    return np.array([np.sin(angle), np.cos(angle)])


def labels_of_rings_at_round_radii(max_ring_radius: float) -> dict[float, str]:
    """Return labels for up to four rings at round numbers, not larger than an outer radius, keyed by radius."""
    steps = np.asarray(MaxNLocator(4).tick_values(0.0, max_ring_radius))
    radii = steps[(steps > 0.0) & (steps <= max_ring_radius * (1.0 + 1e-9))]
    decimals = next(digits for digits in range(12) if np.allclose(np.round(radii, digits), radii, rtol=1e-6, atol=0.0))
    return {round(float(radius), decimals): f"{radius:.{decimals}f}" for radius in radii}


def b_over_h_ring_labels(rim_b_over_h: float, ring_b_over_h_if_no_round_one_fits: float) -> dict[float, str]:
    """Return labels of rings at round B/H, keyed by B/H.

    If no round B/H is below that of the rim, the only ring is at `ring_b_over_h_if_no_round_one_fits`.
    """
    steps = (0.1, 0.2, 0.3) if rim_b_over_h <= 0.4 else (0.2, 0.4, 0.6, 0.8, 1.0)
    rings = [step for step in steps if step < rim_b_over_h] or [round(ring_b_over_h_if_no_round_one_fits, 2)]
    return {ring: f"{ring:g}" for ring in rings}


def create_compass_grid(
    row_count: int, column_count: int, width_inches: float, height_inches: float, visible_count: int | None = None
) -> Any:
    """Return a figure of a given size, inches, and its compasses as an array of shape (row_count, column_count).

    Only the first `visible_count` compasses are visible, by default all; on a phone all stand below each other.
    """
    return create_panel_grid(
        row_count, column_count, width_inches, height_inches, visible_count,
        polar=CompassAxes, layout_engine=CompassGridLayout(),
    )  # fmt: skip


class CompassGridLayout(ConstrainedLayoutEngine):
    """Layout of compasses of one size in rows and columns: below the title, above a colour bar and the legend.

    Matplotlib's own constrained layout measures all texts several times. Here, texts that all panels share are measured
    once, because their distance from the rim hardly depends on the size of the compass. All lengths are in points.
    """

    def execute(self, fig: Figure) -> None:
        """Place the compasses, the colour bar and the title of a figure; the legend stays at the lower edge."""
        renderer, point = RendererAgg(1, 1, fig.dpi), fig.dpi / 72.0
        width, height = 72.0 * fig.get_size_inches()
        panels = [axes for axes in fig.axes if isinstance(axes, CompassAxes) and axes.get_visible()]
        bars = [axes for axes in fig.axes if axes.get_label() == COLOUR_BAR_AXES_LABEL]
        if not panels:
            return
        low, high = _FIGURE_MARGIN_PT, height - _FIGURE_MARGIN_PT
        for legend in fig.legends:
            low = max(low, legend.get_window_extent(renderer).y1 / point + _GAP_BETWEEN_FIGURE_PARTS_PT)
        for title in (text for text in fig.texts if text.get_text() and text.get_text() == fig.get_suptitle()):
            title.set_y(high / height)
            high -= title.get_window_extent(renderer).height / point + _GAP_BETWEEN_FIGURE_PARTS_PT
        bar_low = low + _COLOUR_BAR_TICK_AND_LABEL_SPACE_PT
        low = bar_low + _COLOUR_BAR_HEIGHT_PT + _GAP_BETWEEN_FIGURE_PARTS_PT if bars else low
        estimate = min(width / _panel_grid_shape(panels[0])[1], (high - low) / _panel_grid_shape(panels[0])[0])
        for axes in panels:  # distances of texts from the rim hardly depend on its size
            size = max(_MIN_COMPASS_DIAMETER_PT, estimate - 4.0 * _DIRECTION_NAME_DISTANCE_FROM_RIM_PT)
            _set_panel_position(axes, 0.0, 0.0, size / width, size / height)
        across, down = _text_overhang_pt_by_column_and_row(panels, renderer)
        size = min(
            _largest_compass_diameter_pt(width - 2.0 * _FIGURE_MARGIN_PT, across),
            _largest_compass_diameter_pt(high - low, down),
        )
        if size < _MIN_COMPASS_DIAMETER_PT:
            warnings.warn("constrained_layout not applied: no room for the compasses", stacklevel=2)
            return
        left = _compass_left_or_upper_edges_pt(_FIGURE_MARGIN_PT, width - _FIGURE_MARGIN_PT, across, size)
        top = _compass_left_or_upper_edges_pt(height - high, height - low, down, size)
        for axes in panels:
            row, column = _panel_row_and_column(axes)
            x, y = left[column], height - top[row] - size
            _set_panel_position(axes, x / width, y / height, size / width, size / height)
        share = 0.6 if len(left) > 1 else 0.8
        span, middle = share * (left[-1] + size - left[0]), 0.5 * (left[-1] + size + left[0])
        for bar in bars:
            bar.set_position(
                ((middle - 0.5 * span) / width, bar_low / height, span / width, _COLOUR_BAR_HEIGHT_PT / height)
            )
            bar.set_in_layout(True)


def _panel_grid_shape(axes: Any) -> tuple[int, int]:
    """Return the numbers of rows and columns of the grid of panels to which a panel belongs."""
    rows, columns = axes.get_subplotspec().get_gridspec().get_geometry()
    return rows, columns


def _panel_row_and_column(axes: Any) -> tuple[int, int]:
    """Return the row and the column, counted from 0, of a panel in its grid of panels."""
    place = axes.get_subplotspec()
    return place.rowspan.start, place.colspan.start


def _text_overhang_pt_by_column_and_row(
    panels: Sequence[CompassAxes], renderer: RendererAgg
) -> tuple[FloatArray, FloatArray]:
    """Return the space that the texts of compasses need outside the rims, for each column and row of compasses.

    Returns
    -------
    across : ndarray, shape (columns, 2)
        Distances to the left and to the right of each column, pt.
    down : ndarray, shape (rows, 2)
        Distances above and below each row, pt.
    """
    rows, columns = _panel_grid_shape(panels[0])
    shared = _text_overhang_beyond_rim_pt(panels[0], panels[0].direction_and_ring_labels, renderer)
    across, down = np.tile(shared[:2], (columns, 1)), np.tile(shared[2:], (rows, 1))
    for axes in panels:
        row, column = _panel_row_and_column(axes)
        own = _text_overhang_beyond_rim_pt(
            axes, [text for text in axes.texts if text not in axes.direction_and_ring_labels], renderer
        )
        across[column] = np.maximum(across[column], own[:2])
        down[row] = np.maximum(down[row], own[2:])
        down[row, 0] = max(down[row, 0], _text_overhang_beyond_rim_pt(axes, [axes.title], renderer)[2])
    return across, down


def _text_overhang_beyond_rim_pt(axes: CompassAxes, texts: Sequence[Text], renderer: RendererAgg) -> FloatArray:
    """Return how far texts reach beyond the rim of a compass to the left, to the right, above and below, pt."""
    boxes = [text.get_window_extent(renderer) for text in texts if text.get_text()]
    if not boxes:
        return np.zeros(4)
    rim, texts_box = axes.bbox, Bbox.union(boxes)
    beyond = rim.x0 - texts_box.x0, texts_box.x1 - rim.x1, texts_box.y1 - rim.y1, rim.y0 - texts_box.y0
    return np.maximum(beyond, 0.0) * 72.0 / axes.figure.dpi


def _set_panel_position(
    axes: CompassAxes,
    left_figure_fraction: float,
    bottom_figure_fraction: float,
    width_figure_fraction: float,
    height_figure_fraction: float,
) -> None:
    """Set the position of a panel, as shares of the figure, and keep the panel in Matplotlib's layout."""
    axes.set_position((left_figure_fraction, bottom_figure_fraction, width_figure_fraction, height_figure_fraction))
    axes.set_in_layout(True)


def _largest_compass_diameter_pt(
    row_or_column_length_pt: float, text_lengths_before_and_after_compass_pt: FloatArray
) -> float:
    """Return the largest diameter, pt, at which a row (or column) of compasses and their texts fit into a length.

    `text_lengths_before_and_after_compass_pt` are the lengths that texts need before and after each compass, shape
    (compasses, 2).
    """
    count = len(text_lengths_before_and_after_compass_pt)
    gaps = (count - 1) * _min_gap_between_neighbouring_compasses_pt(text_lengths_before_and_after_compass_pt)
    return (
        float(
            row_or_column_length_pt
            - text_lengths_before_and_after_compass_pt[0, 0]
            - text_lengths_before_and_after_compass_pt[-1, 1]
            - gaps
        )
        / count
    )


def _compass_left_or_upper_edges_pt(
    row_or_column_start_pt: float,
    row_or_column_end_pt: float,
    text_lengths_before_and_after_compass_pt: FloatArray,
    compass_diameter_pt: float,
) -> FloatArray:
    """Return the left (or upper) edges, pt, of compasses in a row (or column) with the spare length divided evenly.

    `text_lengths_before_and_after_compass_pt` is defined in `_largest_compass_diameter_pt`.
    """
    count = len(text_lengths_before_and_after_compass_pt)
    largest = _largest_compass_diameter_pt(
        row_or_column_end_pt - row_or_column_start_pt, text_lengths_before_and_after_compass_pt
    )
    spare = count * (largest - compass_diameter_pt) / (count + 1)
    step = (
        compass_diameter_pt
        + _min_gap_between_neighbouring_compasses_pt(text_lengths_before_and_after_compass_pt)
        + spare
    )
    return row_or_column_start_pt + text_lengths_before_and_after_compass_pt[0, 0] + spare + step * np.arange(count)


def _min_gap_between_neighbouring_compasses_pt(text_lengths_before_and_after_compass_pt: FloatArray) -> float:
    """Return the least distance, pt, between the rims of neighbouring compasses at which their texts do not overlap."""
    return (
        float(
            np.max(
                text_lengths_before_and_after_compass_pt[:-1, 1] + text_lengths_before_and_after_compass_pt[1:, 0],
                initial=0.0,
            )
        )
        + _GAP_BETWEEN_FIGURE_PARTS_PT
    )
