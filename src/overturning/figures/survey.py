"""Figure of surveys of fallen stones: directions and share of the falls, observed next to computed."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from overturning.arrays import FloatArray
from overturning.figures.answer import (
    ROW_HEIGHT_INCHES,
    VALUE_FONT_SIZE_PT,
    PlottedEstimate,
    draw_estimate_with_interval,
    format_estimate,
    scale_estimate,
)
from overturning.figures.style import (
    FALL_COLOUR,
    INK,
    PAGE_WIDTH_INCHES,
    PHONE_FIGURE_WIDTH_INCHES,
    SERIES_COLOURS,
    add_title_and_legend,
    create_figure,
    is_drawing_for_phone,
    label_axes,
    legend_patch,
    set_outer_radius_and_radius_ticks,
    turn_axes_into_compass,
)

OCTANT_WIDTH_RAD: Final = np.pi / 4
"""Width of a sector, radians."""

MAX_ROSES_PER_ROW: Final = 3

_FALL_COUNTS_FOR_RADIUS_LABELS: Final = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000)
_COMPUTED_ROSE_LINE_STYLE: Final[dict[str, Any]] = {"color": SERIES_COLOURS[0], "linewidth": 1.6}
_OBSERVED_SHARE_MARKER_STYLE: Final[dict[str, Any]] = {
    "color": FALL_COLOUR,
    "marker": "o",
    "markersize": 6,
    "linestyle": "none",
}
_COMPUTED_SHARE_MARKER_STYLE: Final[dict[str, Any]] = {
    "color": SERIES_COLOURS[0], "marker": "D", "markersize": 5.5, "markerfacecolor": "white", "linestyle": "none"
}  # fmt: skip


@dataclass(frozen=True)
class SurveyFigureData:
    """Observed and computed numbers of falls by direction, and shares of fallen stones, of one survey for its figure.

    Attributes
    ----------
    name : str
        Name of the survey.
    observed_falls_by_octant, computed_fall_count_by_octant : ndarray, shape (8,)
        Number of stones that fell towards each octant, from N clockwise, and as many as are computed.
    observed_mean_fall_direction_deg, computed_mean_fall_direction_deg : float or None
        Mean fall directions, degrees; None if there is none.
    observed_fallen_share, computed_fallen_share : PlottedEstimate
        Share of the stones that fell, 0 to 1, with its interval or range.
    """

    name: str
    observed_falls_by_octant: FloatArray
    computed_fall_count_by_octant: FloatArray
    observed_mean_fall_direction_deg: float | None
    computed_mean_fall_direction_deg: float | None
    observed_fallen_share: PlottedEstimate
    computed_fallen_share: PlottedEstimate


def survey_falls_figure(drawn_surveys: Sequence[SurveyFigureData]) -> Figure:
    """Draw for each survey the roses of observed and computed falls, and the shares of stones that fell."""
    count = len(drawn_surveys)
    rows = -(-count // MAX_ROSES_PER_ROW)
    if count == 1 and is_drawing_for_phone():
        figure = create_figure(PHONE_FIGURE_WIDTH_INCHES, 4.9)
        halves = figure.add_gridspec(2, 1, height_ratios=(3.0, 1.0))
        places, below = [halves[0]], halves[1]
    elif count == 1:
        figure = create_figure(PAGE_WIDTH_INCHES, 3.6)
        halves = figure.add_gridspec(1, 2, width_ratios=(1.0, 1.05))
        places, below = [halves[0]], halves[1].subgridspec(3, 1, height_ratios=(0.75, 1.0, 0.75))[1]
    else:
        figure = create_figure(PAGE_WIDTH_INCHES, 2.7 * rows + 2.1 * ROW_HEIGHT_INCHES * count + 1.1)
        whole = figure.add_gridspec(2, 1, height_ratios=(2.6 * rows, 2.1 * ROW_HEIGHT_INCHES * count + 0.4))
        roses = whole[0].subgridspec(rows, min(count, MAX_ROSES_PER_ROW))
        places, below = [roses[divmod(place, MAX_ROSES_PER_ROW)] for place in range(count)], whole[1]
    for survey, place in zip(drawn_surveys, places, strict=True):
        axes = figure.add_subplot(place, projection="polar")
        _draw_survey_rose(axes, survey)
        if count > 1:
            axes.set_title(survey.name, fontsize=8.5, pad=9, parse_math=False)
    _draw_observed_and_computed_fall_shares(figure.add_subplot(below), drawn_surveys)
    marks = [
        legend_patch(FALL_COLOUR, "observed falls (area: number)"),
        Line2D([], [], **_COMPUTED_ROSE_LINE_STYLE, label="computed for as many falls"),
    ]
    if any(one.observed_mean_fall_direction_deg is not None for one in drawn_surveys):
        marks.append(
            Line2D(
                [], [], **_mean_direction_marker_style(0.0, FALL_COLOUR, FALL_COLOUR), label="mean azimuth, observed"
            )
        )
    if any(one.computed_mean_fall_direction_deg is not None for one in drawn_surveys):
        marks.append(
            Line2D(
                [], [], **_mean_direction_marker_style(0.0, SERIES_COLOURS[0], "white"), label="mean azimuth, computed"
            )
        )
    if count > 1:
        marks += [
            Line2D([], [], **_OBSERVED_SHARE_MARKER_STYLE, label="observed share, 95 % interval"),
            Line2D([], [], **_COMPUTED_SHARE_MARKER_STYLE, label="computed share, range over the grid"),
        ]
    add_title_and_legend(
        figure, drawn_surveys[0].name if count == 1 else "", None, 2, legend_handles_before_panel_marks=marks
    )
    return figure


def _draw_survey_rose(axes: Any, drawn_survey: SurveyFigureData) -> None:
    """Draw a rose of a survey: observed falls as sectors, computed falls as an outline."""
    turn_axes_into_compass(axes)
    centres = np.arange(8) * OCTANT_WIDTH_RAD
    observed, computed = (
        np.sqrt(drawn_survey.observed_falls_by_octant),
        np.sqrt(drawn_survey.computed_fall_count_by_octant),
    )
    top = 1.06 * max(1.0, float(observed.max()), float(computed.max()))
    axes.bar(centres, observed, width=OCTANT_WIDTH_RAD, color=FALL_COLOUR, edgecolor="white", linewidth=0.6, zorder=2)
    around = np.linspace(-0.5, 0.5, 16) * OCTANT_WIDTH_RAD
    outline, radius = (centres[:, None] + around).ravel(), np.repeat(computed, around.size)
    axes.plot(
        np.append(outline, outline[0] + 2 * np.pi), np.append(radius, radius[0]), zorder=3, **_COMPUTED_ROSE_LINE_STYLE
    )
    for centre, radius, number in zip(centres, observed, drawn_survey.observed_falls_by_octant, strict=True):
        if radius > 0.25 * top:
            axes.text(
                centre,
                0.68 * radius,
                f"{number:g}",
                color="white",
                fontsize=VALUE_FONT_SIZE_PT,
                ha="center",
                va="center",
                zorder=4,
            )
    if not drawn_survey.observed_falls_by_octant.any():
        axes.text(0.0, 0.0, "no fall in a\nknown direction", fontsize=8, ha="center", va="center")
    shown = [n for n in _FALL_COUNTS_FOR_RADIUS_LABELS if 0.4 * top < np.sqrt(n) <= 0.97 * top][-2:] or [1]
    set_outer_radius_and_radius_ticks(axes, top, {float(np.sqrt(n)): str(n) for n in shown}, zorder=5)
    # On the border of two octants, where least is drawn.
    most = np.maximum(observed, computed)
    axes.set_rlabel_position(22.5 + 45.0 * int(np.argmin(most + np.roll(most, -1))))
    axes.tick_params(axis="x", pad=5)
    for azimuth, face, edge in (
        (drawn_survey.computed_mean_fall_direction_deg, "white", SERIES_COLOURS[0]),
        (drawn_survey.observed_mean_fall_direction_deg, FALL_COLOUR, FALL_COLOUR),
    ):
        if azimuth is not None:
            axes.plot(
                np.radians(azimuth),
                1.0 * top,
                **_mean_direction_marker_style(azimuth, edge, face),
                zorder=6,
                clip_on=False,
            )
    axes.set_ylim(0.0, top)


def _mean_direction_marker_style(
    azimuth_deg: float, marker_edge_colour: str, marker_face_colour: str
) -> dict[str, Any]:
    """Return Matplotlib keywords for the triangle that marks a mean fall direction."""
    return {
        "marker": (3, 0, -azimuth_deg), "markersize": 10, "markeredgecolor": marker_edge_colour,
        "markerfacecolor": marker_face_colour, "markeredgewidth": 1.4, "linestyle": "none",
    }  # fmt: skip


def _draw_observed_and_computed_fall_shares(axes: Any, drawn_surveys: Sequence[SurveyFigureData]) -> None:
    """Draw for each survey the shares of fallen stones: observed with interval, computed with range over the grid."""
    ticks = []
    for row, survey in enumerate(drawn_surveys):
        for offset, look, estimate, name in (
            (-0.2, _OBSERVED_SHARE_MARKER_STYLE, survey.observed_fallen_share, "observed\n(95 % interval)"),
            (0.2, _COMPUTED_SHARE_MARKER_STYLE, survey.computed_fallen_share, "computed\n(range over grid)"),
        ):
            share = scale_estimate(estimate, 100.0)
            draw_estimate_with_interval(axes, share, row + offset, look, 1.8)
            text = f"{format_estimate(share, 0)}"
            axes.annotate(
                text, (1.0, row + offset), (6, 0), xycoords=("axes fraction", "data"), textcoords="offset points",
                va="center", fontsize=VALUE_FONT_SIZE_PT, color=look["color"],
            )  # fmt: skip
            ticks.append((row + offset, name))
    if len(drawn_surveys) == 1:
        axes.set_yticks([at for at, _ in ticks], [name for _, name in ticks])
    else:
        axes.set_yticks(range(len(drawn_surveys)), [one.name for one in drawn_surveys], parse_math=False)
        for row in range(1, len(drawn_surveys)):
            axes.axhline(row - 0.5, color=INK, linewidth=0.4)
    axes.set_ylim(len(drawn_surveys) - 0.5, -0.5)
    axes.set_xlim(0, 100)
    axes.grid(True, axis="x")
    axes.tick_params(axis="y", length=0)
    label_axes(axes, "stones that fell, %", "")
