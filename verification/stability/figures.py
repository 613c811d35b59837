"""Diagrams of the stability maps: outcomes of extreme cases over dimensionless groups."""

from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from overturning.figures.style import use_package_matplotlib_settings
from overturning.figures.write import save_figure_files
from verification.stability.cases import SCENE_NAMES
from verification.stability.checks import StabilityCheckVerdict

_LABELS_AND_COLOURS_OF_OUTCOMES: Final = (
    ("right", (StabilityCheckVerdict.ALL_CHECKS_HOLD,), "#9ecae1"),
    ("at rest", (StabilityCheckVerdict.NOT_SIMULATED_AT_REST,), "#cfcfca"),
    ("undecided", (StabilityCheckVerdict.UNDECIDED_AT_END_TIME,), "#009e73"),
    ("unstable", (StabilityCheckVerdict.NUMERICALLY_UNSTABLE, StabilityCheckVerdict.STOPPED_BY_ERROR), "#d55e00"),
    ("over budget", (StabilityCheckVerdict.OVER_STEP_BUDGET,), "#cc79a7"),
    ("refused", (StabilityCheckVerdict.ARGUMENT_REFUSED,), "#222222"),
    ("silent", (StabilityCheckVerdict.WRONG_WITHOUT_WARNING,), "#ff0000"),
)
_AXIS_LABEL_BY_DIMENSIONLESS_GROUP: Final = {
    "penetration_ratio": "δ/B",
    "damping": "ξ",
    "step_ratio": "Δt / Δt stable",
    "acceleration_ratio": "a / (g·B/H)",
    "friction_ratio": "µ·H/B",
}
_AXIS_LIMITS_BY_DIMENSIONLESS_GROUP: Final = {
    "penetration_ratio": (1e-12, 1e4),
    "damping": (1e-4, 1e3),
    "step_ratio": (1e-3, 1.0),
    "acceleration_ratio": (1e-4, 1e3),
    "friction_ratio": (1e-3, 1e3),
}
_DIMENSIONLESS_GROUPS_X_AND_Y_BY_PANEL: Final = (
    ("penetration_ratio", "damping"),
    ("penetration_ratio", "step_ratio"),
    ("penetration_ratio", "acceleration_ratio"),
    ("friction_ratio", "acceleration_ratio"),
)
_BIN_COUNT_PER_DIMENSIONLESS_GROUP: Final = 24


def draw_block_outcomes_over_dimensionless_groups(rows: pd.DataFrame, path: Path) -> None:
    """Draw every case of single blocks as a point over four pairs of dimensionless groups.

    Values outside a panel are drawn at its edge.
    """
    import matplotlib.pyplot as plt

    with use_package_matplotlib_settings():
        figure, axes = plt.subplots(2, 2, figsize=(8.2, 7.6), layout="constrained")
        for axis, (across, up) in zip(axes.ravel(), _DIMENSIONLESS_GROUPS_X_AND_Y_BY_PANEL, strict=True):
            _draw_outcomes_over_two_dimensionless_numbers(axis, rows, across, up, 1.6)
            axis.set_xlabel(_AXIS_LABEL_BY_DIMENSIONLESS_GROUP[across])
            axis.set_ylabel(_AXIS_LABEL_BY_DIMENSIONLESS_GROUP[up])
        _add_outcome_legend(figure, rows)
        save_figure_files(figure, path)


def draw_scene_outcomes_over_dimensionless_groups(rows: pd.DataFrame, path: Path) -> None:
    """Draw each scene's cases: acceleration over rocking threshold against each of three dimensionless groups."""
    import matplotlib.pyplot as plt

    labels = _AXIS_LABEL_BY_DIMENSIONLESS_GROUP | {
        "acceleration_ratio": "a / (g · threshold)",
        "friction_ratio": "µ / threshold",
    }
    across_of = ("penetration_ratio", "damping", "friction_ratio")
    with use_package_matplotlib_settings():
        figure, axes = plt.subplots(
            3, len(SCENE_NAMES), figsize=(10.0, 8.0), layout="constrained", sharex="row", sharey=True
        )
        for column, scene in enumerate(SCENE_NAMES):
            for axis, across in zip(axes[:, column], across_of, strict=True):
                _draw_outcomes_over_two_dimensionless_numbers(
                    axis, rows[rows["scene"] == scene], across, "acceleration_ratio", 2.4
                )
                axis.set_xlabel(labels[across])
                if column == 0:
                    axis.set_ylabel(labels["acceleration_ratio"])
            axes[0, column].set_title(scene)
        _add_outcome_legend(figure, rows)
        save_figure_files(figure, path)


def _draw_outcomes_over_two_dimensionless_numbers(
    axes: Any,
    rows: pd.DataFrame,
    x_dimensionless_group_name: str,
    y_dimensionless_group_name: str,
    marker_side_pt: float,
) -> None:
    """Draw each case as a coloured point over two dimensionless groups."""
    # Points are drawn in a fixed random order, so that no kind hides the others. Squares without antialiasing: smoothed
    # edges would make the image in the SVG four times as large.
    rows = rows[np.isfinite(rows[x_dimensionless_group_name]) & np.isfinite(rows[y_dimensionless_group_name])]
    rows = rows.iloc[np.random.Generator(np.random.PCG64(1)).permutation(len(rows))]
    colour_of = {int(ending): colour for _, endings, colour in _LABELS_AND_COLOURS_OF_OUTCOMES for ending in endings}
    x, y = (
        np.clip(rows[group], *_AXIS_LIMITS_BY_DIMENSIONLESS_GROUP[group])
        for group in (x_dimensionless_group_name, y_dimensionless_group_name)
    )
    colours = [colour_of[ending] for ending in rows["ending"]]
    axes.scatter(x, y, s=marker_side_pt**2, c=colours, marker="s", linewidths=0, antialiaseds=False, rasterized=True)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(*_AXIS_LIMITS_BY_DIMENSIONLESS_GROUP[x_dimensionless_group_name])
    axes.set_ylim(*_AXIS_LIMITS_BY_DIMENSIONLESS_GROUP[y_dimensionless_group_name])


def _add_outcome_legend(figure: Any, rows: pd.DataFrame) -> None:
    """Add a legend of the outcomes that occur."""
    from matplotlib.lines import Line2D

    handles = [
        Line2D([], [], linestyle="none", marker="o", markersize=7, markeredgewidth=0, color=colour, label=name)
        for name, endings, colour in _LABELS_AND_COLOURS_OF_OUTCOMES
        if np.isin(rows["ending"], endings).any()
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=len(handles))


def draw_outcome_shares_by_dimensionless_group(rows: pd.DataFrame, path: Path) -> None:
    """Draw the shares of the outcomes of the cases along each dimensionless group."""
    import matplotlib.pyplot as plt

    with use_package_matplotlib_settings():
        figure, axes = plt.subplots(2, 3, figsize=(9.0, 5.2), layout="constrained", sharey=True)
        for axis, group in zip(axes.ravel(), _AXIS_LABEL_BY_DIMENSIONLESS_GROUP, strict=False):
            low, high = _AXIS_LIMITS_BY_DIMENSIONLESS_GROUP[group]
            edges = np.geomspace(low, high, _BIN_COUNT_PER_DIMENSIONLESS_GROUP + 1)
            known = rows[np.isfinite(rows[group])]  # a refused case may have no time step
            place = np.clip(known[group], low, high * (1 - 1e-9))
            total = np.histogram(place, edges)[0]
            bottom = np.zeros(_BIN_COUNT_PER_DIMENSIONLESS_GROUP)
            for name, endings, colour in _LABELS_AND_COLOURS_OF_OUTCOMES:
                counted = np.histogram(place[np.isin(known["ending"], endings)], edges)[0]
                # No share is drawn for fewer than ten cases.
                top = bottom + np.where(total >= 10, counted / np.maximum(total, 1), 0.0)
                if counted.any():
                    axis.stairs(top, edges, baseline=bottom, fill=True, color=colour, label=name)
                bottom = top
            axis.set_xscale("log")
            axis.set_xlim(low, high)
            axis.set_ylim(0, 1)
            axis.set_xlabel(_AXIS_LABEL_BY_DIMENSIONLESS_GROUP[group])
        for axis in axes[:, 0]:
            axis.set_ylabel("share of cases")
        axes[1, 2].axis("off")
        handles, labels = axes[0, 0].get_legend_handles_labels()
        axes[1, 2].legend(handles, labels, loc="center")
        save_figure_files(figure, path)
