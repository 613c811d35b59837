"""Figure of the motion inferred from a survey: its axis, its strength and the most likely motions of a library."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from overturning.arrays import FloatArray
from overturning.figures.style import (
    FALL_COLOUR,
    INK,
    PHONE_FIGURE_WIDTH_INCHES,
    SERIES_COLOURS,
    create_figure,
    is_drawing_for_phone,
    label_axes,
    set_logarithmic_ticks,
    turn_axes_into_compass,
)

COLOUR_OUTSIDE_CREDIBLE_ARC = "#e9c3a8"

_MAX_DRAWN_MOTIONS = 10
"""Number of motions shown: those with the highest probability."""


def inferred_motion_posterior_figure(
    title: str,
    posterior_probability_by_velocity_axis: FloatArray,
    credible_arc_middle_and_width_deg: tuple[float, float],
    posterior_probability_by_motion_name: Mapping[str, float],
    strength_cdfs_and_interval_by_measure: Mapping[str, tuple[FloatArray, FloatArray, FloatArray, tuple[float, float]]],
) -> Figure:
    """Draw the motion inferred from fallen stones: posterior distributions of velocity axis, record, PGA and PGV.

    Parameters
    ----------
    title : str
        Title of the figure.
    posterior_probability_by_velocity_axis : array, shape (n,)
        Probabilities of n axes, evenly spaced from north over 180°.
    credible_arc_middle_and_width_deg : tuple of float
        Middle and width of the 90 % credible arc of the velocity axis, degrees.
    posterior_probability_by_motion_name : mapping
        Probability of each motion, by name.
    strength_cdfs_and_interval_by_measure : mapping
        For each measure, named with its unit: ascending values, their posterior probability of not being exceeded, the
        same probability of the prior, and the 90 % credible interval, whose ends may be 0 or infinite.
    """
    rows, columns = (4, 1) if is_drawing_for_phone() else (2, 2)
    figure = create_figure(*((PHONE_FIGURE_WIDTH_INCHES, 10.8) if is_drawing_for_phone() else (9.5, 5.4)))
    polar: Any = figure.add_subplot(rows, columns, 1, projection="polar")
    turn_axes_into_compass(polar)
    # Areas are proportional to probabilities; sectors outside the stated arc are pale.
    both = np.sqrt(np.tile(posterior_probability_by_velocity_axis, 2))
    angle, middle, half = (
        2 * np.pi * np.arange(both.size) / both.size,
        np.radians(credible_arc_middle_and_width_deg[0]),
        np.radians(credible_arc_middle_and_width_deg[1] / 2),
    )
    inside = np.abs((angle - middle + np.pi / 2) % np.pi - np.pi / 2) <= half + 1e-9
    polar.bar(
        angle,
        both,
        width=2 * np.pi / both.size,
        color=np.where(inside, FALL_COLOUR, COLOUR_OUTSIDE_CREDIBLE_ARC),
        zorder=2,
    )
    for end in (middle, middle + np.pi):
        polar.plot(np.linspace(end - half, end + half, 60), np.full(60, 1.04 * both.max()), color=INK, linewidth=2)
    polar.set_yticks([])
    polar.set_title("axis of the largest velocity", fontsize=9)
    bars = figure.add_subplot(rows, columns, 2)
    best = sorted(posterior_probability_by_motion_name.items(), key=lambda item: -item[1])[:_MAX_DRAWN_MOTIONS][::-1]
    bars.barh([name for name, _ in best], [100 * share for _, share in best], color=SERIES_COLOURS[0])
    bars.tick_params(axis="y", labelsize=8)
    label_axes(bars, "probability, %", "")
    for place, (name, (values, below, before, (low, high))) in enumerate(strength_cdfs_and_interval_by_measure.items()):
        axes = figure.add_subplot(rows, columns, 3 + place)
        axes.plot(values, before, color=INK, linewidth=1, linestyle=(0, (3, 1.5)), label="before the survey")
        axes.plot(values, below, color=FALL_COLOUR, linewidth=1.8, label="after it")
        ends = max(low, values[0]), min(high, values[-1])
        axes.axvspan(*ends, color=FALL_COLOUR, alpha=0.15, linewidth=0, label="90 %")
        axes.set_xscale("log")
        set_logarithmic_ticks(axes.xaxis)
        axes.xaxis.set_minor_locator(NullLocator())
        for open_end, at, toward in ((np.isinf(high), 0.985, 1), (low == 0, 0.015, -1)):
            if open_end:
                arrow = {"arrowstyle": "->", "color": INK}
                axes.annotate("", (at, 0.06), (at - 0.12 * toward, 0.06), "axes fraction", arrowprops=arrow)
        axes.grid(True)
        label_axes(axes, name, "probability not exceeded")
    figure.legend(handles=axes.get_legend_handles_labels()[0], loc="outside lower center", ncols=3, fontsize=8)
    figure.suptitle(title, fontsize=10)
    return figure
