"""Rose diagrams of fall directions and axes, for a whole study and by earthquake."""

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from overturning.figures import style
from overturning.figures.style import (
    FALL_COLOUR,
    FAULT_COLOUR,
    INK,
    PAGE_WIDTH_INCHES,
    create_panel_grid,
    mark_fault_normal_on_polar_rim,
    set_outer_radius_and_radius_ticks,
    turn_axes_into_compass,
    wrap_name_into_lines,
)
from overturning.motion.direction import angle_between_azimuths
from overturning.statistics.circular import ROSE_SECTOR_COUNT
from overturning.statistics.earthquakes import MeanFallAxisAndAlignmentOverEarthquakes
from overturning.statistics.roses import FallShareRoseAveragedOverEarthquakes, fall_rose, fall_rose_by_record_group

MAX_ROSES_PER_ROW: Final = 4

SECTOR_CONFIDENCE_INTERVAL_COLOUR: Final = "#f3cdb0"
"""Colour of the interval of a sector."""

_MEAN_AXIS_LINE_STYLE: Final[dict[str, Any]] = {
    "color": INK,
    "linewidth": 2.2,
    "solid_capstyle": "butt",
    "clip_on": False,
}
_MEAN_AXIS_MARK_RADIUS_OVER_ROSE_RADIUS: Final = 1.08
"""Radius of the mark of a mean axis, in units of the radius of the rose."""


def draw_fall_rose(
    axes: Any, rose: FallShareRoseAveragedOverEarthquakes, radial_axis_limit_as_root_of_share: float | None = None
) -> None:
    """Draw a rose diagram of fall directions or axes; sector areas are proportional to shares of the falls.

    Radii are square roots of shares. The confidence interval of a sector's share runs from a white line to the outer
    edge of the pale part of the sector. A rose of axes is a half disk with 0° at its top. The outer radius of the rose
    is ``radial_axis_limit_as_root_of_share``, by default `common_rose_radius_as_root_of_share`.
    """
    turn_axes_into_compass(axes)
    radial_axis_limit_as_root_of_share = radial_axis_limit_as_root_of_share or common_rose_radius_as_root_of_share(rose)
    centres = np.arange(rose.mean_fall_share_by_sector.size) * 2.0 * np.pi / ROSE_SECTOR_COUNT
    values = [rose.mean_fall_share_by_sector, rose.share_interval_low_by_sector, rose.share_interval_high_by_sector]
    if rose.is_axial:  # the sector across the top has one half at either end
        axes.set(thetamin=-90.0, thetamax=90.0)
        centres = np.append(centres, centres - np.pi)
        values = [np.tile(one, 2) for one in values]
    share, low, high = (np.sqrt(one) for one in values)
    known = np.isfinite(low)
    look = {"width": 2.0 * np.pi / ROSE_SECTOR_COUNT, "edgecolor": "white", "linewidth": 0.4}
    axes.bar(centres, share, color=FALL_COLOUR, zorder=3, **look)
    axes.bar(
        centres[known],
        (high - share)[known],
        bottom=share[known],
        color=SECTOR_CONFIDENCE_INTERVAL_COLOUR,
        zorder=3,
        **look,
    )
    for angle, radius in zip(centres[known], low[known], strict=True):
        across = angle + np.linspace(-np.pi, np.pi, 5) / ROSE_SECTOR_COUNT
        axes.plot(across, np.full(5, radius), color="white", linewidth=1.1, solid_capstyle="butt", zorder=4)
    apart = 0.36 if rose.is_axial else 0.27  # below a half circle labels stand side by side; they are wider than high
    shown = list[float]()  # labels of the radius, not so close that they overlap
    for level in (0.8, 0.4, 0.2, 0.1, 0.05, 0.02, 0.01):
        if (
            0.25 * radial_axis_limit_as_root_of_share
            < np.sqrt(level)
            <= min(
                radial_axis_limit_as_root_of_share,
                *(np.sqrt(one) - apart * radial_axis_limit_as_root_of_share for one in shown),
                radial_axis_limit_as_root_of_share,
            )
        ):
            shown.append(level)
    set_outer_radius_and_radius_ticks(
        axes,
        radial_axis_limit_as_root_of_share,
        {float(np.sqrt(level)): f"{100 * level:.0f}\u00a0%" for level in shown[::-1]},
        zorder=6,
    )
    axes.yaxis.grid(True, linewidth=0.4)
    if rose.is_axial:
        _label_fall_axis_angles(axes, rose.is_measured_from_fault_normal)
    else:
        axes.set_rlabel_position(_azimuth_deg_for_radius_labels(rose))


def _label_fall_axis_angles(axes: Any, is_measured_from_fault_normal: bool) -> None:
    """Label the angles of a half-circle rose of fall axes, measured from the fault normal or from north."""
    names = ("along\nfault", "−45°", "across the fault (normal)", "45°", "along\nfault")
    names = names if is_measured_from_fault_normal else ("W", "NW", "N", "NE", "E")
    axes.set_xticks(np.radians([-90, -45, 0, 45, 90]), names, fontsize=8)
    axes.tick_params(axis="x", pad=10)
    axes.set_rlabel_position(-90.0)
    if is_measured_from_fault_normal:
        top = axes.get_ylim()[1]
        axes.plot([0, 0], [0.93 * top, 1.03 * top], color=FAULT_COLOUR, linewidth=2.6, zorder=5, clip_on=False)
        axes.set_ylim(0.0, top)


def mark_mean_fall_axis(axes: Any, mean_axis_deg: float, interval_half_width_deg: float) -> None:
    """Mark a mean fall axis and its confidence interval at the rim of a rose; draw nothing if the axis is NaN.

    An interval that extends beyond ±90° continues at the other end of the half disk.
    """
    if not np.isfinite(mean_axis_deg):
        return
    top = axes.get_ylim()[1]
    axes.plot(
        np.radians([mean_axis_deg, mean_axis_deg]),
        [
            (_MEAN_AXIS_MARK_RADIUS_OVER_ROSE_RADIUS - 0.05) * top,
            (_MEAN_AXIS_MARK_RADIUS_OVER_ROSE_RADIUS + 0.05) * top,
        ],
        **_MEAN_AXIS_LINE_STYLE,
    )
    for low, high in (
        axis_interval_arcs_from_minus_90_to_90_deg(mean_axis_deg, interval_half_width_deg)
        if np.isfinite(interval_half_width_deg)
        else ()
    ):
        angles = np.radians(np.linspace(low, high, 60))
        axes.plot(
            angles,
            np.full(60, _MEAN_AXIS_MARK_RADIUS_OVER_ROSE_RADIUS * top),
            **_MEAN_AXIS_LINE_STYLE | {"linewidth": 1.4},
        )
    axes.set_ylim(0.0, top)


def axis_interval_arcs_from_minus_90_to_90_deg(
    mean_axis_deg: float, interval_half_width_deg: float
) -> list[tuple[float, float]]:
    """Return the confidence interval of an axis as arcs (start, end), degrees, within −90° to 90°."""
    ends = (
        (mean_axis_deg - interval_half_width_deg + turn, mean_axis_deg + interval_half_width_deg + turn)
        for turn in (-180.0, 0.0, 180.0)
    )
    clipped = ((max(-90.0, low), min(90.0, high)) for low, high in ends)
    return [(low, high) for low, high in clipped if low < high]


def common_rose_radius_as_root_of_share(*roses: FallShareRoseAveragedOverEarthquakes) -> float:
    """Return the outer radius that fits all given roses, as the square root of a share of falls."""
    most = [
        np.nanmax([rose.mean_fall_share_by_sector, rose.share_interval_high_by_sector]) if rose.fall_count else 0.0
        for rose in roses
    ]
    return max(float(np.sqrt(max(most, default=0.0))), 0.1) * 1.08


def _azimuth_deg_for_radius_labels(rose: FallShareRoseAveragedOverEarthquakes) -> float:
    """Return the azimuth, degrees, at which to write the radius labels of a rose: where few stones fall."""
    most = np.fmax(rose.mean_fall_share_by_sector, rose.share_interval_high_by_sector)
    between = np.arange(22.5, 360.0, 45.0)
    centres = np.arange(most.size) * 360.0 / most.size
    near = [most[angle_between_azimuths(centres, middle) < 15.0].max() for middle in between]
    return float(between[int(np.argmin(near))])


def fall_roses_by_group_figure(
    cube: xr.Dataset, summary_by_group: Mapping[str, MeanFallAxisAndAlignmentOverEarthquakes] | None = None
) -> Figure:
    """Draw a rose of falls for each group of records, such as those with a velocity pulse, on one scale.

    If `summary_by_group` has a mean axis for a group, the axis and its 95 % interval are drawn at the rim.
    """
    roses, means = fall_rose_by_record_group(cube), summary_by_group or {}
    width = max(3.3 * len(roses), 4.3)
    axial = all(rose.is_axial for rose in roses.values())
    figure, panels = create_panel_grid(1, len(roses), width, 2.75 if axial else 4.3, polar=True)
    top = common_rose_radius_as_root_of_share(*roses.values())
    for (name, rose), axes in zip(roses.items(), panels[0], strict=True):
        draw_fall_rose(axes, rose, top)
        frame = "" if rose.is_measured_from_fault_normal else ", from north"
        axes.set_title(f"{name}\n{rose.earthquake_count_title}{frame}", pad=12, fontsize=9)
        if rose.is_measured_from_fault_normal and name in means:
            mark_mean_fall_axis(
                axes, means[name].mean_axis_from_fault_normal_deg, means[name].mean_axis_interval_half_width_deg
            )
    marked = any(
        np.isfinite(means[name].mean_axis_from_fault_normal_deg)
        for name, rose in roses.items()
        if rose.is_measured_from_fault_normal and name in means
    )
    style.add_title_and_legend(
        figure,
        "",
        legend_column_count=1 if width < 5 else 2,
        legend_handles_before_panel_marks=_rose_legend_entries(list(roses.values()), marked),
    )
    return figure


def _rose_legend_entries(roses: list[FallShareRoseAveragedOverEarthquakes], has_mean_axis: bool) -> list[Any]:
    """Return the legend entries of fall roses: shares, their intervals, and the mean axis if drawn."""
    marks = [style.legend_patch(FALL_COLOUR, "share of the falls (area)")]
    if any(np.isfinite(rose.share_interval_low_by_sector).any() for rose in roses):
        marks.append(
            style.legend_patch(
                SECTOR_CONFIDENCE_INTERVAL_COLOUR, "95 % interval of each sector by itself, from the white line"
            )
        )
    if has_mean_axis:
        marks.append(Line2D([], [], **_MEAN_AXIS_LINE_STYLE, label="mean axis with its 95 % interval"))
    return marks


def fall_roses_by_earthquake_figure(cube: xr.Dataset) -> Figure:
    """Draw a rose of fall azimuths for each earthquake with falls, on one scale, with the fault normals."""
    events = cube["event"].to_numpy().astype(str)
    roses = {
        name: (fall_rose(cube.isel(record=np.flatnonzero(events == name))), events == name)
        for name in dict.fromkeys(events)
    }
    shown = {name: found for name, found in roses.items() if found[0].fall_count}
    columns = min(MAX_ROSES_PER_ROW, max(1, len(shown)))
    rows = max(1, -(-len(shown) // columns))
    wide = max(PAGE_WIDTH_INCHES / 4 * columns, 4.2)
    # A letter of a title is about 4.7 pt wide.
    titles = [wrap_name_into_lines(name, int(72.0 * wide / columns / 4.7)) for name in shown]
    high = (2.0 + 0.12 * (max(map(len, titles), default=1) - 1)) * rows + 0.2
    figure, panels = create_panel_grid(rows, columns, wide, high, len(shown), polar=True)
    top = common_rose_radius_as_root_of_share(*(rose for rose, _ in shown.values()))
    for axes, title, (rose, members) in zip(panels.flat, titles, shown.values(), strict=False):
        draw_fall_rose(axes, rose, top)
        axes.tick_params(axis="both", labelsize=7)
        axes.set_xticklabels(["N", "", "E", "", "S", "", "W", ""])
        for normal in cube["fault_normal"].to_numpy()[members]:
            mark_fault_normal_on_polar_rim(axes, float(normal), label=None)
        count = int(members.sum())
        lines = [*title, f"{count} record{'s' * (count != 1)}"]
        axes.set_title("\n".join(lines), fontsize=8, pad=3, parse_math=False)
    return figure
