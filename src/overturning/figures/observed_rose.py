"""Roses of the falls that a survey observed, with mean direction and mean axis."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from overturning.arrays import FloatArray
from overturning.figures.style import (
    FALL_COLOUR,
    INK,
    PAGE_WIDTH_INCHES,
    PHONE_FIGURE_WIDTH_INCHES,
    SERIES_COLOURS,
    add_title_and_legend,
    create_figure,
    is_drawing_for_phone,
    legend_patch,
    set_outer_radius_and_radius_ticks,
    turn_axes_into_compass,
    wrap_name_into_lines,
)

MAX_ROSES_PER_ROW: Final = 3

_FALL_COUNTS_FOR_RADIUS_LABELS: Final = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000)
_MEAN_MARK_RADIUS_OVER_ROSE_RADIUS: Final = 1.07
"""Radius of the marks of means, in units of the radius of the rose."""
_MEAN_DIRECTION_LINE_STYLE: Final[dict[str, Any]] = {
    "color": INK,
    "linewidth": 1.6,
    "solid_capstyle": "butt",
    "clip_on": False,
}
_MEAN_AXIS_LINE_STYLE: Final[dict[str, Any]] = {
    "color": SERIES_COLOURS[0],
    "linewidth": 2.2,
    "solid_capstyle": "butt",
    "clip_on": False,
}


_TITLE_LETTER_WIDTH_INCHES: Final = 0.08
"""Width of a wide letter of a title, inches."""


@dataclass(frozen=True)
class ObservedFallRoseCounts:
    """Number of observed falls in each direction at one survey site or in the whole survey, for a rose diagram.

    Attributes
    ----------
    name : str
        Name above the rose; "" for none.
    falls_by_sector : ndarray, shape (8,) or (16,)
        Number of falls towards each sector, clockwise; the first is centred on north.
    mean_direction_deg, mean_axis_deg : float or None
        Mean direction and mean axis, degrees clockwise from north; None if there is none.
    mean_direction_interval_half_width_deg, mean_axis_interval_half_width_deg : float or None
        Half-widths of the 95 % intervals of mean direction and mean axis, degrees; None if there is no interval.
    """

    name: str
    falls_by_sector: FloatArray
    mean_direction_deg: float | None = None
    mean_direction_interval_half_width_deg: float | None = None
    mean_axis_deg: float | None = None
    mean_axis_interval_half_width_deg: float | None = None


def observed_fall_roses_figure(roses: Sequence[ObservedFallRoseCounts]) -> Figure:
    """Draw rose diagrams of observed falls, each on its own scale; one rose alone has the width of a text column."""
    count = len(roses)
    columns = 1 if is_drawing_for_phone() else min(count, MAX_ROSES_PER_ROW)
    rows = -(-count // columns)
    width = PHONE_FIGURE_WIDTH_INCHES if columns == 1 else PAGE_WIDTH_INCHES
    figure = create_figure(width, (width / columns + 0.35) * rows + 0.75)
    places = figure.add_gridspec(rows, columns)
    for number, rose in enumerate(roses):
        axes = figure.add_subplot(places[divmod(number, columns)], projection="polar")
        _draw_observed_fall_rose(axes, rose)
        if rose.name:
            title = "\n".join(wrap_name_into_lines(rose.name, int(width / columns / _TITLE_LETTER_WIDTH_INCHES)))
            axes.set_title(title, fontsize=8.5, pad=16, parse_math=False)
    marks: list[Any] = [legend_patch(FALL_COLOUR, "observed falls (area: number)")]
    if any(rose.mean_direction_deg is not None for rose in roses):
        marks.append(Line2D([], [], **_mean_direction_marker_style(0.0), label="mean direction, 95 % interval"))
    if any(rose.mean_axis_deg is not None for rose in roses):
        marks.append(Line2D([], [], **_MEAN_AXIS_LINE_STYLE, label="mean axis, 95 % interval"))
    add_title_and_legend(figure, "", None, 1 if columns == 1 else 2, legend_handles_before_panel_marks=marks)
    return figure


def _draw_observed_fall_rose(axes: Any, rose: ObservedFallRoseCounts) -> None:
    """Draw a rose diagram: sector areas proportional to numbers of falls; mean direction and mean axis at the rim."""
    turn_axes_into_compass(axes, name_distance_pt=13)
    counts = np.asarray(rose.falls_by_sector, np.float64)
    radius, width = np.sqrt(counts), 2.0 * np.pi / counts.size
    top = 1.03 * max(1.0, float(radius.max()))
    axes.bar(
        np.arange(counts.size) * width,
        radius,
        width=width,
        color=FALL_COLOUR,
        edgecolor="white",
        linewidth=0.5,
        zorder=2.5,
    )
    if not counts.any():
        axes.text(0.0, 0.0, "no fall in a\nknown direction", fontsize=8, ha="center", va="center")
    shown = [n for n in _FALL_COUNTS_FOR_RADIUS_LABELS if 0.45 * top < np.sqrt(n) <= 0.97 * top][-1:] or [1]
    set_outer_radius_and_radius_ticks(axes, top, {float(np.sqrt(n)): str(n) for n in shown}, zorder=5)
    axes.set_rlabel_position(_sector_border_with_fewest_falls_deg(counts))
    if rose.mean_axis_deg is not None:
        for end in (rose.mean_axis_deg, rose.mean_axis_deg + 180.0):
            axes.plot(np.radians([end, end]), [top, _MEAN_MARK_RADIUS_OVER_ROSE_RADIUS * top], **_MEAN_AXIS_LINE_STYLE)
            _draw_mean_direction_interval(
                axes, end, rose.mean_axis_interval_half_width_deg, 1.035 * top, _MEAN_AXIS_LINE_STYLE
            )
    if rose.mean_direction_deg is not None:
        at = np.radians(rose.mean_direction_deg)
        axes.plot(
            at,
            _MEAN_MARK_RADIUS_OVER_ROSE_RADIUS * top,
            **_mean_direction_marker_style(rose.mean_direction_deg),
            clip_on=False,
            zorder=6,
        )
        _draw_mean_direction_interval(
            axes,
            rose.mean_direction_deg,
            rose.mean_direction_interval_half_width_deg,
            _MEAN_MARK_RADIUS_OVER_ROSE_RADIUS * top,
            _MEAN_DIRECTION_LINE_STYLE,
        )
    axes.set_ylim(0.0, top)


def _draw_mean_direction_interval(
    axes: Any,
    mean_direction_deg: float,
    interval_half_width_deg: float | None,
    arc_radius: float,
    line_keywords: dict[str, Any],
) -> None:
    """Draw the confidence interval of a mean fall direction as an arc; draw nothing if the interval is unknown."""
    if interval_half_width_deg is not None:
        angles = np.radians(
            np.linspace(mean_direction_deg - interval_half_width_deg, mean_direction_deg + interval_half_width_deg, 60)
        )
        axes.plot(angles, np.full(60, arc_radius), **line_keywords | {"linewidth": 1.3})


def _mean_direction_marker_style(azimuth_deg: float) -> dict[str, Any]:
    """Return Matplotlib keywords for `plot` that draw the outward triangle marking a mean fall direction."""
    return {
        "marker": (3, 0, -azimuth_deg), "markersize": 8, "markeredgecolor": INK, "markerfacecolor": INK,
        "linestyle": "none",
    }  # fmt: skip


def _sector_border_with_fewest_falls_deg(fall_count_by_sector: FloatArray) -> float:
    """Return the azimuth, degrees, of the rose's sector border with the fewest falls next to it, for radius labels."""
    most = np.maximum(fall_count_by_sector, np.roll(fall_count_by_sector, -1))
    borders = (np.arange(fall_count_by_sector.size) + 0.5) * 360.0 / fall_count_by_sector.size
    # Names of directions stand at multiples of 45°; a border between two names comes first.
    near = np.abs((borders + 22.5) % 45.0 - 22.5)
    return float(borders[np.lexsort((-near, most))[0]])
