"""Figures of the number that answers a study's question, from plain numbers: alignment, references, contrast."""

import math
from collections.abc import Mapping, Sequence
from textwrap import fill
from typing import Any, Final, NamedTuple

from matplotlib.figure import Figure

from overturning.figures.style import (
    DASHED_LINE_STYLE,
    INK,
    PAGE_WIDTH_INCHES,
    SERIES_COLOURS,
    add_title_and_legend,
    create_panel_grid,
    is_drawing_for_phone,
    label_axes,
    wrap_name_into_lines,
)

RECORD_GROUP_MARKERS: Final = ("o", "D", "s")
RECORD_GROUP_COLOURS: Final = (SERIES_COLOURS[1], SERIES_COLOURS[0], SERIES_COLOURS[2])
"""Colours of groups of records, in order; the first group is filled, others are hollow."""

ROW_HEIGHT_INCHES: Final = 0.22
"""Height of a row, inches."""

VALUE_FONT_SIZE_PT: Final = 7.5
"""Size of printed values, pt."""


_ANNOTATE_ARGUMENTS_RIGHT_OF_PANEL: Final[dict[str, Any]] = {
    "xycoords": ("axes fraction", "data"),
    "textcoords": "offset points",
    "va": "center",
    "fontsize": VALUE_FONT_SIZE_PT,
}
"""Place of a text to the right of a panel, at a row."""


class PlottedEstimate(NamedTuple):
    """Value to draw, with the ends of its confidence interval and the number of earthquakes; NaN or None if unknown."""

    value: float | None
    interval_low: float | None = None
    interval_high: float | None = None
    earthquake_count: int = 0


def fault_normal_alignment_by_earthquake_figure(
    alignment_by_group_and_earthquake: Mapping[str, Mapping[str, float]],
    mean_alignment_by_group: Mapping[str, PlottedEstimate],
) -> Figure:
    """Draw each earthquake's alignment of falls with the fault normal, sorted, with its mean; a panel per group.

    Parameters
    ----------
    alignment_by_group_and_earthquake : mapping of str to mapping of str to float
        For each group of records the alignment of each earthquake by name: 1 if all stones fall across the fault, −1
        if all fall along it, NaN if it is not known (no falls, no fault normal, or only azimuths within a sector
        simulated).
    mean_alignment_by_group : mapping of str to PlottedEstimate
        Mean over the earthquakes of each group, with its interval.
    """
    rows = max(len(of_group) for of_group in alignment_by_group_and_earthquake.values())
    wide = PAGE_WIDTH_INCHES if len(alignment_by_group_and_earthquake) > 1 else 4.6
    max_letters_per_line = int(7.4 * wide / len(alignment_by_group_and_earthquake))  # half of the width of a panel
    every = [name for of_group in alignment_by_group_and_earthquake.values() for name in of_group]
    most_lines = max((len(wrap_name_into_lines(name, max_letters_per_line)) for name in every), default=1)
    high = ROW_HEIGHT_INCHES * (rows + 2) * (1.0 + 0.4 * (most_lines - 1)) + 1.05
    figure, panels = create_panel_grid(1, len(alignment_by_group_and_earthquake), wide, high)
    for place, ((group, of_group), axes) in enumerate(
        zip(alignment_by_group_and_earthquake.items(), panels[0], strict=True)
    ):
        look, mean = _marker_style_of_record_group(place), mean_alignment_by_group[group]
        ordered = sorted(
            of_group.items(), key=lambda item: (not _is_finite(item[1]), -item[1] if _is_finite(item[1]) else 0.0)
        )
        for row, (_, value) in enumerate(ordered):
            if not _is_finite(value):
                axes.text(0.06, row, "no alignment", va="center", fontsize=VALUE_FONT_SIZE_PT)
                continue
            axes.plot([0.0, value], [row, row], color="#bbbbbb", linewidth=1.2, zorder=1)
            axes.plot(value, row, **look, zorder=3)
            side = 1.0 if value >= 0 else -1.0
            align = "left" if value >= 0 else "right"
            axes.text(
                value + 0.1 * side,
                row,
                format_with_typographic_minus(value),
                va="center",
                ha=align,
                fontsize=VALUE_FONT_SIZE_PT,
            )
        if _is_finite(mean.interval_low) and _is_finite(mean.interval_high):
            axes.axvspan(mean.interval_low, mean.interval_high, color=look["color"], alpha=0.12, linewidth=0, zorder=0)
        at = len(ordered) + 0.25
        axes.axhline(len(ordered) - 0.4, color=INK, linewidth=0.6)
        draw_estimate_with_interval(axes, mean, at, look | {"marker": "s", "markersize": 7}, 2.4)
        names = ["\n".join(wrap_name_into_lines(name, max_letters_per_line)) for name, _ in ordered]
        axes.set_yticks([*range(len(ordered)), at], [*names, "mean"], fontsize=8, parse_math=False)
        axes.set_ylim(rows + 0.95, -0.7)  # rows of all panels line up
        _set_x_axis_from_minus_1_to_1(
            axes, ("along\nthe fault", "neither", "across\nthe fault"), x_margin_beyond_ends=0.6
        )
        gap = "\n" if is_drawing_for_phone() else ", "
        heading = f"{group}{gap}{_earthquake_count_label(mean.earthquake_count)}\nmean {format_estimate(mean)}"
        axes.set_title(heading, fontsize=8.5, parse_math=False)
    figure.supxlabel("alignment of the falls with the fault normal", fontsize=8)
    return figure


def fall_alignment_with_reference_axes_figure(
    alignment_by_group_and_reference: Mapping[str, Mapping[str, PlottedEstimate]],
) -> Figure:
    """Draw the alignment of falls with several reference directions, with intervals, one marker per group of records.

    Parameters
    ----------
    alignment_by_group_and_reference : mapping of str to mapping of str to PlottedEstimate
        For each group of records the alignment by the name of the reference: 1 if all stones fall along its axis, −1
        if all fall across it. The first group sets the order of references.
    """
    first = next(iter(alignment_by_group_and_reference.values()))
    every = dict.fromkeys(name for of_group in alignment_by_group_and_reference.values() for name in of_group)
    names = sorted(
        every,
        key=lambda name: (
            -(_nan_if_none(first[name].value) if _is_finite(first.get(name, PlottedEstimate(None)).value) else -9)
        ),
    )
    figure, panels = create_panel_grid(
        1,
        1,
        PAGE_WIDTH_INCHES,
        1.35 * ROW_HEIGHT_INCHES * len(names) * max(1.3, 0.75 * len(alignment_by_group_and_reference)) + 1.2,
    )
    axes, marks = panels[0, 0], []
    apart = 0.28
    for place, (group, of_group) in enumerate(alignment_by_group_and_reference.items()):
        look = _marker_style_of_record_group(place)
        for row, name in enumerate(names):
            dot, at = (
                of_group.get(name, PlottedEstimate(None)),
                row + apart * (place - (len(alignment_by_group_and_reference) - 1) / 2),
            )
            draw_estimate_with_interval(axes, dot, at, look, 1.6)
            text = format_estimate(dot) if _is_finite(dot.value) else "not known"
            axes.annotate(text, (1.0, at), (6, 0), color=look["color"], **_ANNOTATE_ARGUMENTS_RIGHT_OF_PANEL)
        count = max((dot.earthquake_count for dot in of_group.values()), default=0)
        (mark,) = axes.plot([], [], **look, label=f"{group}, {_earthquake_count_label(count)}")
        marks.append(mark)
    shown = [fill(name, 12) for name in names] if is_drawing_for_phone() else names
    axes.set_yticks(range(len(names)), shown, fontsize=8.5, parse_math=False)
    axes.set_ylim(len(names) - 0.5, -0.5)
    _set_x_axis_from_minus_1_to_1(axes, ("across it", "neither", "along it"), x_margin_beyond_ends=0.05)
    if is_drawing_for_phone():
        axes.set_xticks([-1, 0, 1], ["−1\nacross it", "0\nneither", "1\nalong it"], fontsize=VALUE_FONT_SIZE_PT)
    axes.grid(True, axis="x")
    axes.set_xlabel("alignment of the falls with each reference", fontsize=8)
    add_title_and_legend(figure, "", None, 2, legend_handles_before_panel_marks=marks)
    return figure


def overturned_shares_and_difference_figure(
    row_names: Sequence[str],
    overturned_share_by_setting_and_row: Mapping[str, Sequence[PlottedEstimate]],
    share_difference_by_row: Sequence[PlottedEstimate],
) -> Figure:
    """Draw the shares of cases that overturn under two settings, and their difference; a row per group of cases.

    Parameters
    ----------
    row_names : sequence of str
        Names of the rows, from the top, such as all cases and then each B/H.
    overturned_share_by_setting_and_row : mapping of str to sequence of PlottedEstimate
        Shares, 0 to 1, by the name of the setting, one for each row.
    share_difference_by_row : sequence of PlottedEstimate
        Share under the first setting minus that under the second, one for each row.
    """
    figure, ((left, right),) = create_panel_grid(
        1, 2, PAGE_WIDTH_INCHES, ROW_HEIGHT_INCHES * len(row_names) * 1.15 + 1.3, width_ratios=(1.25, 1.0), sharey=True
    )
    for place, (setting, dots) in enumerate(overturned_share_by_setting_and_row.items()):
        look = _marker_style_of_record_group(place)
        for row, dot in enumerate(dots):
            share = scale_estimate(dot, 100.0)
            draw_estimate_with_interval(left, share, row + 0.14 * (2 * place - 1), look, 1.4)
            text = format_estimate(PlottedEstimate(share.value), 1) if _is_finite(share.value) else "–"
            left.annotate(
                text,
                (1.0, row),
                (31 * place + 29, 0),
                color=look["color"],
                ha="right",
                **_ANNOTATE_ARGUMENTS_RIGHT_OF_PANEL,
            )
        left.plot([], [], **look, label=setting)
    for row, pair in enumerate(zip(*overturned_share_by_setting_and_row.values(), strict=True)):
        if all(_is_finite(dot.value) for dot in pair):
            ends = [100.0 * _nan_if_none(dot.value) for dot in pair]
            left.plot(ends, [row - 0.14, row + 0.14], color="#bbbbbb", linewidth=1.2, zorder=1)
    for row, dot in enumerate(share_difference_by_row):
        points = scale_estimate(dot, 100.0)
        draw_estimate_with_interval(
            right, points, row, {"color": INK, "marker": "s", "markersize": 4.5, "linestyle": "none"}, 1.4
        )
        if _is_finite(points.value):
            right.annotate(format_estimate(points, 1), (1.0, row), (5, 0), **_ANNOTATE_ARGUMENTS_RIGHT_OF_PANEL)
    right.axvline(0.0, color=INK, linestyle=DASHED_LINE_STYLE, linewidth=1.0, zorder=0)
    ends = [100.0 * _nan_if_none(end) for dot in share_difference_by_row for end in dot[:3] if _is_finite(end)]
    reach = 1.12 * max([*map(abs, ends), 2.0])
    if is_drawing_for_phone():
        # Short lines of names, and no empty half, leave room for the dots.
        row_names = [fill(name, 11) for name in row_names]
        right.set_xlim(min([*ends, -0.2 * reach]) - 0.1 * reach, max([*ends, 0.2 * reach]) + 0.1 * reach)
        right.tick_params(labelleft=True, labelsize=8)
    else:
        right.set_xlim(-reach, reach)
        right.tick_params(labelleft=False, left=False)
    left.set_yticks(range(len(row_names)), row_names, fontsize=8, parse_math=False)
    left.set_ylim(len(row_names) - 0.4, -0.6)
    left.set_xlim(-3, 103)
    for axes in (left, right):
        axes.grid(True, axis="x")
    label_axes(left, "share that falls, %", "")
    label_axes(right, "difference, percentage points", "")
    left.tick_params(axis="y", labelsize=8)
    add_title_and_legend(figure, "", left, 2)
    return figure


def format_with_typographic_minus(value: float, decimal_count: int = 2) -> str:
    """Return a number as text with `decimal_count` decimals and a typographic minus sign; no sign if it rounds to 0."""
    return f"{value:z.{decimal_count}f}".replace("-", "−")


def format_estimate(estimate: PlottedEstimate, decimal_count: int = 2) -> str:
    """Return an estimate as text, such as "0.42 (0.10 to 0.60)", with its interval if that is known."""
    if not _is_finite(estimate.value):
        return "not known"
    text = format_with_typographic_minus(_nan_if_none(estimate.value), decimal_count)
    if _is_finite(estimate.interval_low) and _is_finite(estimate.interval_high):
        low, high = (
            format_with_typographic_minus(_nan_if_none(end), decimal_count)
            for end in (estimate.interval_low, estimate.interval_high)
        )
        text += f" ({low} to {high})"
    return text


def _set_x_axis_from_minus_1_to_1(
    axes: Any, names_at_minus_1_0_and_1: tuple[str, str, str], x_margin_beyond_ends: float
) -> None:
    """Set the horizontal axis to −1 … 1; write `names_at_minus_1_0_and_1` below its ticks −1, 0 and 1."""
    axes.axvline(0.0, color=INK, linestyle=DASHED_LINE_STYLE, linewidth=1.0, zorder=0)
    axes.set_xlim(-1.0 - x_margin_beyond_ends, 1.0 + x_margin_beyond_ends)
    low, middle, high = names_at_minus_1_0_and_1
    labels = [f"−1\n{low}", "−0.5", f"0\n{middle}", "0.5", f"1\n{high}"]
    axes.set_xticks([-1, -0.5, 0, 0.5, 1], labels, fontsize=VALUE_FONT_SIZE_PT)


def draw_estimate_with_interval(
    axes: Any, estimate: PlottedEstimate, y_position: float, marker_style: dict[str, Any], interval_line_width: float
) -> None:
    """Draw an estimate as a marker, and its interval as a line, at the height `y_position`; draw nothing if unknown."""
    if not _is_finite(estimate.value):
        return
    if _is_finite(estimate.interval_low) and _is_finite(estimate.interval_high):
        axes.plot(
            [estimate.interval_low, estimate.interval_high],
            [y_position, y_position],
            color=marker_style["color"],
            linewidth=interval_line_width,
            solid_capstyle="butt",
            zorder=2,
        )
    axes.plot(estimate.value, y_position, **marker_style, zorder=3)


def _marker_style_of_record_group(position_in_drawing_order: int) -> dict[str, Any]:
    """Return Matplotlib keywords for the markers of a record group or setting: filled for the first, else hollow."""
    colour = RECORD_GROUP_COLOURS[position_in_drawing_order % len(RECORD_GROUP_COLOURS)]
    face = colour if position_in_drawing_order == 0 else "white"
    return {
        "color": colour, "marker": RECORD_GROUP_MARKERS[position_in_drawing_order % len(RECORD_GROUP_MARKERS)],
        "markerfacecolor": face, "markersize": 5.5,
        "linestyle": "none",
    }  # fmt: skip


def scale_estimate(estimate: PlottedEstimate, factor: float) -> PlottedEstimate:
    """Multiply an estimate and the ends of its interval by a factor."""
    value, low, high = (factor * _nan_if_none(end) if _is_finite(end) else None for end in estimate[:3])
    return PlottedEstimate(value, low, high, estimate.earthquake_count)


def _earthquake_count_label(earthquake_count: int) -> str:
    """Return a number of earthquakes as text, such as "3 earthquakes"."""
    return f"{earthquake_count} earthquake{'s' * (earthquake_count != 1)}"


def _is_finite(value: float | None) -> bool:
    """True if a value is a finite number."""
    return value is not None and math.isfinite(value)


def _nan_if_none(value: float | None) -> float:
    """Convert None to NaN."""
    return math.nan if value is None else float(value)
