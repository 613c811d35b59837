"""Figures of the fraction overturned in a population against the amplitude and the intensity of the motion."""

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from overturning.arrays import FloatArray
from overturning.figures.style import DASHED, FALLS, INK, SERIES, caption, grid, labels, set_logarithmic_ticks
from overturning.motion.jma_intensity import SURVEY_RULE
from overturning.statistics.fragility import Fragility
from overturning.statistics.fragility_files import is_openquake_measure

INTENSITY_SCALE: Final = (5.0, 5.5, 6.0, 6.5)
"""Lower bounds, in instrumental intensity, of the degrees 5+, 6−, 6+ and 7 of the JMA scale."""


def fall_rate_figure(
    amplitude: FloatArray,
    rates: FloatArray,
    levels: Mapping[str, FloatArray],
    curves: Sequence[Fragility],
    jma: FloatArray,
) -> Figure:
    """Draw the fraction overturned against amplitude (if there are several), PGA, PGV, SA and JMA intensity.

    Parameters
    ----------
    amplitude : array, shape (a,)
        Factors on the records.
    rates : array, shape (record, a)
        Fractions overturned, NaN if unknown.
    levels : mapping of str to array, shape (record, a)
        Values of each measure, in the unit of its curve, NaN if unknown.
    curves : sequence of Fragility
        Fragility curves of the whole population.
    jma : array, shape (record, a)
        JMA instrumental intensity, NaN if unknown.
    """
    with_jma = bool(np.isfinite(jma).any())
    shown = [one for one in curves if is_openquake_measure(one.measure)]
    several = amplitude.size > 1
    count = several + len(shown) + with_jma
    columns = min(count, 2)
    rows = math.ceil(count / columns)
    figure, panels = grid(rows, columns, 3.5 * columns, 2.9 * rows, count)
    first, *others = panels.flat if several else (None, *panels.flat)
    if first is not None:
        first.plot(amplitude, 100 * rates.T, color=SERIES[4], linewidth=0.7)
        first.plot(amplitude, 100 * np.nanmedian(rates, axis=0), color=INK, linewidth=2, label="median of the records")
        labels(first, "factor on the record", "")
    for panel, curve in zip(others, shown, strict=False):
        _draw_curve(panel, levels[curve.measure], rates, curve)
    if with_jma:
        _draw_intensity(others[len(shown)], jma, rates)
    for panel in panels.flat[:count]:
        panel.set_ylim(-2, 102)
        panel.grid(True)
    for panel in panels[:, 0]:
        panel.set_ylabel("fall rate, %", fontsize=8)
    caption(figure, "Fall rate of the population", first, 1)
    return figure


def _draw_curve(panel: Any, level: FloatArray, rates: FloatArray, curve: Fragility) -> None:
    """Draw the fraction overturned against one intensity measure, with its fragility curve."""
    panel.plot(level.ravel(), 100 * rates.ravel(), ".", color=SERIES[4], markersize=3)
    if math.isfinite(curve.median):
        x = np.geomspace(curve.least, curve.most, 100)
        panel.plot(x, 100 * curve.probability(x), color=FALLS, linewidth=1.8)
    panel.set_xscale("log")
    set_logarithmic_ticks(panel.xaxis)
    labels(panel, f"{curve.measure}, {curve.unit}", "")


def _draw_intensity(panel: Any, jma: FloatArray, rates: FloatArray) -> None:
    """Draw the fraction overturned against the JMA instrumental intensity."""
    known = np.isfinite(jma)
    panel.plot(jma[known], 100 * rates[known], ".", color=SERIES[4], markersize=3)
    right = panel.get_xlim()[1]
    for low, high, least, most, _ in SURVEY_RULE:
        if least < right:
            size = min(most, right) - least, 100 * (high - low)
            panel.add_patch(Rectangle((least, 100 * low), *size, color=SERIES[4], alpha=0.3))
    for bound in INTENSITY_SCALE:
        panel.axvline(bound, color=INK, linewidth=0.7, linestyle=DASHED)
    labels(panel, "JMA intensity", "")
