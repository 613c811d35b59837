"""Figures of fall axes relative to the fault normal, by earthquake, and of alignment with references, by B/H."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from overturning.arrays import FloatArray
from overturning.figures.style import DASHED, FAULT, INK, SERIES, caption, grid, labels
from overturning.statistics.earthquakes import AxisSummary, ReferenceAlignment

MARKERS = ("o", "D", "s")

HOLLOW_MAX_EARTHQUAKES = 2
"""A mean over at most this many earthquakes is drawn with a hollow marker, because it is not reliable."""


def axes_figure(groups: dict[str, xr.Dataset], summaries: dict[str, AxisSummary]) -> Figure:
    """Draw the fall axis of each earthquake as a point, names from top to bottom, and below them the mean axes.

    `groups` come from `statistics.earthquakes.axes_by_group`. The size of a point shows the resultant length of the
    fall axes. Each mean axis has its confidence interval.
    """
    names = list(dict.fromkeys(str(event) for data in groups.values() for event in data["event"].values))
    figure, panels = grid(1, 1, 6.6, 1.6 + 0.27 * (len(names) + len(groups)))
    axes = panels[0, 0]
    means = [len(names) + 0.35 + 0.6 * index for index in range(len(groups))]
    for index, ((name, data), row) in enumerate(zip(groups.items(), means, strict=True)):
        colour, marker = SERIES[(1, 0, 2)[index % 3]], MARKERS[index % 3]
        filled, summary = colour if index == 0 else "white", summaries[name]
        height = [names.index(str(event)) + 0.16 * (index - (len(groups) - 1) / 2) for event in data["event"].values]
        angle, length = data["axis"].to_numpy(), data["resultant"].to_numpy()
        known = np.isfinite(angle)
        axes.scatter(
            angle[known], np.array(height)[known], s=25 + 220 * length[known], marker=marker,
            facecolor=filled, edgecolor=colour, linewidth=1.3, zorder=3, label=name,
        )  # fmt: skip
        mean, width = summary.axis_deg, summary.half_width_deg
        if np.isfinite(mean):
            # The axis has a period of 180°: an interval that leaves the panel on one side enters it on the other.
            for turn in (-180, 0, 180) if np.isfinite(width) else ():
                ends = [max(-90, mean - width + turn), min(90, mean + width + turn)]
                if ends[0] < ends[1]:
                    axes.plot(ends, [row, row], color=colour, linewidth=2.2, solid_capstyle="butt", clip_on=False)
            axes.plot(mean, row, marker, color=colour, markerfacecolor=filled, markersize=8, clip_on=False)
    axes.axvline(0, color=FAULT, linestyle=DASHED, linewidth=1.3, zorder=1, label="fault normal")
    axes.axhline(len(names) - 0.3, color=INK, linewidth=0.6)
    ticks = [*range(len(names)), *means]
    axes.set_yticks(ticks, [*names, *(f"mean, {name}" for name in groups)], fontsize=8, parse_math=False)
    axes.set_ylim(ticks[-1] + 0.5, -0.6)
    axes.set_xlim(-92, 92)
    axes.set_xticks(
        range(-90, 91, 45), ["−90°\n(parallel)", "−45°", "0°\n(normal)", "45°", "90°\n(parallel)"], fontsize=8
    )
    axes.set_xlabel("fall axis relative to the fault normal", fontsize=8)
    axes.grid(True, axis="x")
    caption(figure, "", axes, 3)
    return figure


def follow_figure(found: dict[str, ReferenceAlignment], b_over_h: FloatArray) -> Figure:
    """Draw the alignment of falls with their references by B/H, a column per group of records.

    The upper row compares axes (period 180°), the lower row directions (period 360°). `found` maps each group to its
    means, which are keyed by the name of the reference and by whether it is an axis; each has a value for each B/H.
    """
    figure, panels = grid(2, len(found), max(3.4 * len(found), 4.4), 5.4)
    names = list(dict.fromkeys(name for group in found.values() for name, _ in group.means))
    apart = 0.12 * float(np.diff(b_over_h).min(initial=0.05))
    for column, (group, of_group) in enumerate(found.items()):
        means = of_group.means
        for row, axial in enumerate((True, False)):
            axes = panels[row, column]
            axes.axhline(0.0, color="#c8c8c8", linewidth=0.8)
            for place, name in enumerate(names):
                if (name, axial) not in means:
                    continue
                value, low, high = np.array([(mean.value, mean.low, mean.high) for mean in means[name, axial]]).T
                x, colour = b_over_h + (place - 0.5 * (len(names) - 1)) * apart, SERIES[place % len(SERIES)]
                axes.vlines(x, low, high, color=colour, linewidth=1.0)
                few = np.array([mean.n <= HOLLOW_MAX_EARTHQUAKES for mean in means[name, axial]])
                marker = "osD^v"[place % 5]
                axes.plot(x[~few], value[~few], marker, color=colour, markersize=3.5, label=name)
                axes.plot(x[few], value[few], marker, color=colour, markersize=3.5, markerfacecolor="white")
            axes.set_ylim(-1.05, 1.05)
            axes.set_xlim(b_over_h.min() - 0.05, b_over_h.max() + 0.05)
            measure = "mean cos 2Δ of axes" if axial else "mean cos Δ of directions"
            labels(axes, "B/H" if row else "", measure if column == 0 else "")
            axes.grid(True, axis="y")
            if row == 0:
                axes.set_title(group, fontsize=9)
    caption(figure, "", panels[0, 0], 4 if len(found) > 1 else 2)
    return figure
