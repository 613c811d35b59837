"""Observed and predicted falls of a survey by compass octant."""

import numpy as np
from matplotlib.figure import Figure

from overturning.figures.style import FALLS, INK, caption, grid, make_compass, set_radius_ticks
from overturning.surveys.comparison import SurveyComparison


def draw_survey_rose(comparison: SurveyComparison, title: str) -> Figure:
    """Figure of a survey's comparison: fallen stones by octant as sectors, and the expected ones as an outline.

    The radius is the root of the count.
    """
    figure, panels = grid(1, 1, 4.2, 4.6, polar=True)
    axes, width = panels[0, 0], np.pi / 4
    make_compass(axes)
    centres = np.arange(8) * width
    axes.bar(centres, np.sqrt(comparison.octant_observed), width=0.92 * width, color=FALLS, label="observed", zorder=2)
    axes.bar(
        centres, np.sqrt(comparison.octant_predicted), width=width, fill=False, edgecolor=INK, linewidth=1.4,
        linestyle=(0, (3, 1.5)), label="predicted", zorder=3,
    )  # fmt: skip
    top = max(1.0, float(np.sqrt(np.maximum(comparison.octant_observed, comparison.octant_predicted).max())))
    counts = [n for n in (1, 2, 5, 10, 20, 50, 100, 200, 500) if 0.3 * top < np.sqrt(n) <= top * 1.05] or [1]
    set_radius_ticks(axes, top * 1.08, {float(np.sqrt(n)): str(n) for n in counts})
    caption(figure, f"{title}\nfallen stones by octant", axes, 2)
    return figure
