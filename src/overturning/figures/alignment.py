"""Figures of the alignment of falls with the fault normal, by earthquake, and with references, by B/H."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from overturning.arrays import FloatArray
from overturning.figures.answer import PlottedEstimate, fault_normal_alignment_by_earthquake_figure
from overturning.figures.style import SERIES_COLOURS, add_title_and_legend, create_panel_grid, label_axes
from overturning.statistics.bootstrap import MeanOverEarthquakes
from overturning.statistics.earthquakes import MeanFallAxisAndAlignmentOverEarthquakes
from overturning.statistics.reference_directions import MeanFallAlignmentByBOverH

MAX_EARTHQUAKES_OF_HOLLOW_MARKER = 2
"""A mean over at most this many earthquakes is drawn with a hollow marker, because it is not reliable."""


def fault_normal_alignment_figure_from_fall_axes(
    fall_axes_by_group: dict[str, xr.Dataset], summary_by_group: dict[str, MeanFallAxisAndAlignmentOverEarthquakes]
) -> Figure:
    """Draw each earthquake's alignment of falls with the fault normal, one panel per group of records."""
    values = {
        name: dict(zip(data["event"].to_numpy().astype(str).tolist(), data["cosine"].to_numpy().tolist(), strict=True))
        for name, data in fall_axes_by_group.items()
    }
    means = {
        name: convert_mean_to_plotted_estimate(one.mean_cos_of_doubled_angle_to_fault_normal)
        for name, one in summary_by_group.items()
    }
    return fault_normal_alignment_by_earthquake_figure(values, means)


def convert_mean_to_plotted_estimate(earthquake_mean: MeanOverEarthquakes) -> PlottedEstimate:
    """Convert a mean over earthquakes (value, interval, number of earthquakes) to a `PlottedEstimate`."""
    return PlottedEstimate(
        earthquake_mean.mean,
        earthquake_mean.interval_low,
        earthquake_mean.interval_high,
        earthquake_mean.earthquake_count,
    )


def fall_alignment_by_b_over_h_figure(
    alignment_with_references_by_group: dict[str, MeanFallAlignmentByBOverH], b_over_h_values: FloatArray
) -> Figure:
    """Draw the alignment of falls with reference directions against B/H, one column of panels per group of records.

    The upper row shows the mean of cos 2Δ (axes, period 180°), the lower row that of cos Δ (directions, period
    360°), with Δ the angle between fall and reference.
    `alignment_with_references_by_group` maps each group to its means, keyed by the name of the reference and by whether
    the reference is an axis. Each entry has one mean for each B/H of `b_over_h_values`.
    """
    figure, panels = create_panel_grid(
        2, len(alignment_with_references_by_group), max(3.4 * len(alignment_with_references_by_group), 4.4), 5.4
    )
    names = list(
        dict.fromkeys(
            name
            for group in alignment_with_references_by_group.values()
            for name, _ in group.cosines_per_b_over_h_by_reference_and_axial
        )
    )
    known = {
        name
        for group in alignment_with_references_by_group.values()
        for (name, _), means in group.cosines_per_b_over_h_by_reference_and_axial.items()
        if any(np.isfinite(mean.mean) for mean in means)
    }
    apart = 0.12 * float(np.diff(b_over_h_values).min(initial=0.05))
    for column, (group, of_group) in enumerate(alignment_with_references_by_group.items()):
        means = of_group.cosines_per_b_over_h_by_reference_and_axial
        for row, axial in enumerate((True, False)):
            axes = panels[row, column]
            axes.axhline(0.0, color="#c8c8c8", linewidth=0.8)
            for place, name in enumerate(names):
                if (name, axial) not in means or name not in known:  # the legend has no reference without a mean
                    continue
                value, low, high = np.array(
                    [(mean.mean, mean.interval_low, mean.interval_high) for mean in means[name, axial]]
                ).T
                x, colour = (
                    b_over_h_values + (place - 0.5 * (len(names) - 1)) * apart,
                    SERIES_COLOURS[place % len(SERIES_COLOURS)],
                )
                axes.vlines(x, low, high, color=colour, linewidth=1.0)
                few = np.array(
                    [mean.earthquake_count <= MAX_EARTHQUAKES_OF_HOLLOW_MARKER for mean in means[name, axial]]
                )
                marker = "osD^v"[place % 5]
                axes.plot(x[~few], value[~few], marker, color=colour, markersize=3.5, label=name)
                axes.plot(x[few], value[few], marker, color=colour, markersize=3.5, markerfacecolor="white")
            axes.set_ylim(-1.05, 1.05)
            axes.set_xlim(b_over_h_values.min() - 0.05, b_over_h_values.max() + 0.05)
            measure = "mean cos 2Δ of axes" if axial else "mean cos Δ of directions"
            label_axes(axes, "B/H" if row else "", measure if column == 0 else "")
            axes.grid(True, axis="y")
            if row == 0:
                axes.set_title(group, fontsize=9)
    add_title_and_legend(figure, "", panels[0, 0], 4 if len(alignment_with_references_by_group) > 1 else 2)
    return figure
