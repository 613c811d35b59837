"""Figure of the share of a cemetery's stones that fall, by peak velocity and by JMA intensity."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from overturning.arrays import FloatArray
from overturning.figures.style import (
    DASHED_LINE_STYLE,
    FALL_COLOUR,
    INK,
    SERIES_COLOURS,
    add_title_and_legend,
    create_panel_grid,
    label_axes,
    legend_patch,
    set_logarithmic_ticks,
)
from overturning.motion.jma_intensity import JMA_DEGREE_RANGES_BY_OVERTURNED_FRACTION
from overturning.statistics.fragility import FittedFragilityCurve

JMA_DEGREE_BY_LOWER_BOUND: Final = {5.0: "5+", 5.5: "6−", 6.0: "6+", 6.5: "7"}
"""Degrees of the JMA scale by their lower bounds, in instrumental intensity."""

MIN_LABELLED_JMA_DEGREE_WIDTH_IN_INTENSITY: Final = 0.1
"""Smallest width, in instrumental intensity, of the part of a degree that is labelled at the left of the panel."""

_FALL_SHARE_RANGE_OF_JMA_DEGREE_STYLE: Final[dict[str, Any]] = {"color": SERIES_COLOURS[4], "alpha": 0.3}


def overturned_fraction_by_intensity_figure(
    fallen_fraction_by_record_and_factor: FloatArray,
    intensity_by_record_and_factor: FloatArray,
    fragility_curve: FittedFragilityCurve,
    jma_intensity_by_record_and_factor: FloatArray,
) -> Figure:
    """Draw the fraction overturned by an intensity measure, with a fragility curve; in a second panel by JMA intensity.

    Parameters
    ----------
    fallen_fraction_by_record_and_factor : array, shape (record, factor)
        Share of the stones that overturn under each record times each amplitude factor, NaN if unknown.
    intensity_by_record_and_factor : array, shape (record, factor)
        Values of the intensity measure of `fragility_curve`, in its unit, NaN if unknown.
    fragility_curve : FittedFragilityCurve
        Fragility curve of the whole population; it is drawn with the 95 % interval of its median if it has one.
    jma_intensity_by_record_and_factor : array, shape (record, factor)
        JMA instrumental intensity, NaN if unknown; if all values are NaN, the second panel is left out.
    """
    with_jma = bool(np.isfinite(jma_intensity_by_record_and_factor).any())
    figure, panels = create_panel_grid(1, 1 + with_jma, 3.5 * (1 + with_jma), 2.9 + 0.2 * with_jma, 1 + with_jma)
    _draw_fragility_curve(
        panels.flat[0], intensity_by_record_and_factor, fallen_fraction_by_record_and_factor, fragility_curve
    )
    if with_jma and _draw_jma_fall_rates_and_tell_if_ranges_shown(
        panels.flat[1], jma_intensity_by_record_and_factor, fallen_fraction_by_record_and_factor
    ):
        add_title_and_legend(
            figure,
            "",
            legend_handles_before_panel_marks=[
                legend_patch(_FALL_SHARE_RANGE_OF_JMA_DEGREE_STYLE, "share from which surveys infer the degree")
            ],
        )
    for panel in panels.flat[: 1 + with_jma]:
        panel.set_ylim(-2, 102)
        panel.grid(True)
    panels.flat[0].set_ylabel("stones that fall, %", fontsize=8)
    return figure


def fragility_curves_figure(
    fallen_fraction_by_record_and_factor: FloatArray,
    intensities_by_measure: Mapping[str, FloatArray],
    fragility_curves: Sequence[FittedFragilityCurve],
) -> Figure:
    """Draw the fraction overturned by intensity with its fragility curve, one panel for each intensity measure.

    Parameters
    ----------
    fallen_fraction_by_record_and_factor : array, shape (record, factor)
        Share of the stones that overturn under each record times each amplitude factor, NaN if unknown.
    intensities_by_measure : mapping of str to array, shape (record, factor)
        Values of each intensity measure, in the unit of its fragility curve, NaN if unknown.
    fragility_curves : sequence of FittedFragilityCurve
        Fragility curves of the same stones, one for each panel; see `overturned_fraction_by_intensity_figure`.
    """
    count = len(fragility_curves)
    # One below the other: a curve for PGA and one for PGV fit a column of a journal.
    figure, panels = create_panel_grid(count, 1, 3.5, 2.2 * count + 0.4)
    for panel, curve in zip(panels.flat, fragility_curves, strict=False):
        _draw_fragility_curve(panel, intensities_by_measure[curve.measure], fallen_fraction_by_record_and_factor, curve)
        panel.get_legend().remove()
        panel.set_ylim(-2, 102)
        panel.grid(True)
        panel.set_ylabel("stones that fall, %", fontsize=8)
    add_title_and_legend(figure, "", panels.flat[0], 2)
    return figure


def _draw_fragility_curve(
    panel: Any,
    intensity_by_record_and_factor: FloatArray,
    fallen_fraction_by_record_and_factor: FloatArray,
    fragility_curve: FittedFragilityCurve,
) -> None:
    """Draw the share of stones that overturn against intensity, with fragility curve and 95 % band of its median."""
    panel.plot(
        intensity_by_record_and_factor.ravel(),
        100 * fallen_fraction_by_record_and_factor.ravel(),
        ".",
        color=SERIES_COLOURS[4],
        markersize=3,
        label="a record and factor",
    )
    if math.isfinite(fragility_curve.median):
        x = np.geomspace(
            fragility_curve.min_intensity_of_validity_range, fragility_curve.max_intensity_of_validity_range, 100
        )
        low, high = fragility_curve.median_interval
        if math.isfinite(low) and math.isfinite(high):
            ends = [
                100 * fragility_curve.fall_probability(x * (fragility_curve.median / median)) for median in (high, low)
            ]
            panel.fill_between(x, *ends, color=FALL_COLOUR, alpha=0.2, linewidth=0, label="95 % interval of the median")
        panel.plot(
            x, 100 * fragility_curve.fall_probability(x), color=FALL_COLOUR, linewidth=1.8, label="lognormal curve"
        )
    panel.set_xscale("log")
    set_logarithmic_ticks(panel.xaxis)
    label_axes(panel, f"{fragility_curve.measure}, {fragility_curve.unit}", "")
    panel.legend(loc="upper left", fontsize=7, frameon=False)


def _draw_jma_fall_rates_and_tell_if_ranges_shown(
    panel: Any, jma_intensity_by_record_and_factor: FloatArray, fallen_fraction_by_record_and_factor: FloatArray
) -> bool:
    """Draw the fraction overturned by JMA intensity, with the limits of the JMA degrees and the rule of field surveys.

    The rule infers a JMA degree from a range of the fraction. Returns True if at least one such range is drawn.
    """
    known = np.isfinite(jma_intensity_by_record_and_factor)
    panel.plot(
        jma_intensity_by_record_and_factor[known],
        100 * fallen_fraction_by_record_and_factor[known],
        ".",
        color=SERIES_COLOURS[4],
        markersize=3,
    )
    left, right = panel.get_xlim()
    for low, high, least, most, _ in JMA_DEGREE_RANGES_BY_OVERTURNED_FRACTION:
        if least < right:
            size = min(most, right) - least, 100 * (high - low)
            panel.add_patch(Rectangle((least, 100 * low), *size, **_FALL_SHARE_RANGE_OF_JMA_DEGREE_STYLE))
    ends = [*list(JMA_DEGREE_BY_LOWER_BOUND)[1:], math.inf]
    for (bound, name), end in zip(JMA_DEGREE_BY_LOWER_BOUND.items(), ends, strict=True):
        panel.axvline(bound, color=INK, linewidth=0.7, linestyle=DASHED_LINE_STYLE)
        begins = max(bound, left)
        if begins < right and (begins == bound or end - begins > MIN_LABELLED_JMA_DEGREE_WIDTH_IN_INTENSITY):
            panel.text(begins + 0.03, 96, name, fontsize=7, va="top")
    panel.set_xlim(left, right)
    label_axes(panel, "JMA instrumental intensity", "")
    return bool(panel.patches)
