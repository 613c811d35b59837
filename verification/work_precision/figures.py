"""Log-log diagrams of error against run time: one line per method, the default setting marked."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from overturning.figures.style import INK, SERIES_COLOURS, SERIES_LINE_STYLES, use_package_matplotlib_settings
from overturning.figures.write import save_figure_files
from overturning.model.contact import DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO
from verification.work_precision.boundaries import RELATIVE_BOUNDARY_RESOLUTION
from verification.work_precision.page import mask_of_finer_step_rows_at_default_stiffness

_LINE_STYLE_BY_METHOD: Final = {
    name: ((*SERIES_COLOURS, INK)[index], (*SERIES_LINE_STYLES, "-")[index], marker)
    for index, (name, marker) in enumerate(
        zip(("centred", "cundall", "stiffness", "Box2D", "pymunk", "MuJoCo", "exact"), "osD^vP*", strict=True)
    )
}
MIN_DRAWN_ROTATION_ERROR_OVER_ALPHA: Final = 1e-8
"""Smallest error of peak rotation that is drawn, far below the errors of springs and steps."""
_Y_AXIS_LABELS: Final = {
    "wrong_flags": "wrong flags, share",
    "wrong_sides": "wrong sides, share",
    "disagree": "other flag or side, share\nof the engines' cases",
    "rotation_error": "peak rotation,\nmedian error / α",
    "boundary_shift": "overturning boundary,\nmedian shift / (B/H)",
    "slip_error": "peak slip,\nlargest error, share",
    "energy_error": "work and energy,\nmean residual",
}
_SCHEME_LABELS: Final = {"centred": "centred, over time steps", "cundall": "cundall, over time steps"}
_X_AXIS_LABELS: Final = {"seconds_per_case": "processor time per case, s", "step_fraction": "Δt / Δt stable"}
_DENOMINATOR_COLUMN_BY_COUNT_COLUMN: Final = {"wrong_flags": "cases", "wrong_sides": "fallen", "disagree": "shared"}


def draw_errors_against_finer_steps_or_stiffer_springs(rows: pd.DataFrame, path: Path) -> None:
    """Draw error against run time under real records: both schemes over time steps, the default one over stiffness."""
    import matplotlib.pyplot as plt

    measures = ("wrong_flags", "wrong_sides", "rotation_error", "boundary_shift")
    with use_package_matplotlib_settings():
        figure, axes = plt.subplots(len(measures), 2, figsize=(7.6, 9.6), sharex="col", squeeze=False)
        for column, (kind, friction) in enumerate((("rocking", "µ = 1 and 10"), ("sliding", "µ = 0.33 and 0.58"))):
            over = rows[mask_of_finer_step_rows_at_default_stiffness(rows, kind)]
            springs = rows[(rows["cases_of"] == f"records, {kind}") & (rows["against"] == "stiffest springs")]
            for axis, measure in zip(axes[:, column], measures, strict=True):
                _draw_error_panel(axis, over, measure, stiffness_rows=springs, has_y_label=column == 0)
                axis.set_xlabel("")
            limits = np.array(
                [_whole_decade_limits(axis, 0) for axis in axes[:, column]]
            )  # shared axis: use the widest limits
            axes[0, column].set_xlim(limits[:, 0].min(), limits[:, 1].max())
            axes[0, column].set_title(f"six records, {friction}")
            axes[-1, column].set_xlabel(_X_AXIS_LABELS["seconds_per_case"])
        methods = _SCHEME_LABELS | {"stiffness": "centred, δ/B 2e-3 to 2e-8, against 2e-8"}
        figure.legend(
            handles=_method_hollow_mark_and_ring_legend_handles(methods),
            loc="lower center",
            ncols=2,
            bbox_to_anchor=(0.5, 0.0),
        )
        figure.subplots_adjust(left=0.13, right=0.98, top=0.96, bottom=0.15, hspace=0.12, wspace=0.2)
        save_figure_files(figure, path)


def draw_errors_against_rigid_solutions(rows: pd.DataFrame, path: Path) -> None:
    """Draw the errors of kernel, exact block and engines against rigid rocking and sliding."""
    import matplotlib.pyplot as plt

    own = (
        np.isclose(rows["penetration_ratio"], DEFAULT_2D_STATIC_PENETRATION_TO_WIDTH_RATIO)
        | rows["penetration_ratio"].isna()
    )
    default_step = rows["step_fraction"] == rows["step_fraction"][rows["default"] == 1].iloc[0]
    with use_package_matplotlib_settings():
        figure, axes = plt.subplots(3, 2, figsize=(7.6, 9.6), layout="constrained")
        for line, title in zip(axes, ("sine pulses", "records, no sliding"), strict=False):
            mine = (rows["cases_of"] == title) & (rows["against"] == "rigid rocking")
            springs = rows[mine & default_step & (rows["method"] == "centred")]
            for axis, measure in zip(line, ("disagree", "rotation_error"), strict=True):
                _draw_error_panel(axis, rows[mine & own], measure, stiffness_rows=springs)
                axis.set_title(f"{title.replace('records, no sliding', 'six records')}, rigid rocking")
        _draw_error_panel(axes[2, 0], rows[rows["cases_of"] == "sliding blocks"], "slip_error")
        axes[2, 0].set_title("sliding blocks, exact sliding")
        _draw_error_panel(
            axes[2, 1], rows[rows["against"] == "energy balance"], "energy_error", x_column="step_fraction"
        )
        axes[2, 1].set_title("six records")
        methods = _SCHEME_LABELS | {"stiffness": "centred, δ/B 2e-3 to 2e-8"}
        methods |= {name: f"{name}, over substeps" for name in list(_LINE_STYLE_BY_METHOD)[3:-1]}
        methods = {
            name: text for name, text in methods.items() if (rows["method"] == name).any() or name == "stiffness"
        }
        methods |= {"exact": "exact rigid block, over orders"}
        figure.legend(handles=_method_hollow_mark_and_ring_legend_handles(methods), loc="outside lower center", ncols=2)
        save_figure_files(figure, path)


def _draw_error_panel(
    axes: Any,
    rows: pd.DataFrame,
    error_column: str,
    *,
    x_column: str = "seconds_per_case",
    stiffness_rows: pd.DataFrame | None = None,
    has_y_label: bool = True,
) -> None:
    """Draw one error as a line per method, and a line over stiffness if given, on log axes of whole decades."""
    from matplotlib.ticker import NullFormatter

    for method in _LINE_STYLE_BY_METHOD:
        own = rows[rows["method"] == method] if method != "stiffness" else stiffness_rows
        if own is not None:
            _draw_method_line(axes, own, x_column, error_column, method)
    axes.set_xscale("log")
    axes.set_yscale("log")
    # Whole decades, so that every axis has at least two labelled ticks.
    axes.set_xlim(*_whole_decade_limits(axes, 0))
    axes.set_ylim(*_whole_decade_limits(axes, 1))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.yaxis.set_minor_formatter(NullFormatter())
    axes.grid(True, which="major")
    axes.set_xlabel(_X_AXIS_LABELS[x_column])
    if has_y_label:
        axes.set_ylabel(_Y_AXIS_LABELS[error_column])


def _method_hollow_mark_and_ring_legend_handles(label_by_method: Mapping[str, str]) -> list[Any]:
    """Return the legend: methods, and the meaning of hollow marks and rings."""
    from matplotlib.lines import Line2D

    handles = [
        Line2D(
            [],
            [],
            color=_LINE_STYLE_BY_METHOD[name][0],
            linestyle=_LINE_STYLE_BY_METHOD[name][1],
            marker=_LINE_STYLE_BY_METHOD[name][2],
            markersize=4.5,
            label=label,
        )
        for name, label in label_by_method.items()
    ]
    common: dict[str, Any] = {"linestyle": "none", "marker": "o", "color": INK}
    return [
        *handles,
        Line2D([], [], markersize=11, markerfacecolor="none", label="default setting", **common),
        Line2D(
            [], [], markersize=4.5, markerfacecolor="white", label="hollow: none wrong, drawn at half a case;", **common
        ),
        Line2D([], [], linestyle="none", label="shift too small to see, at half the least"),
    ]


def _draw_method_line(axes: Any, rows: pd.DataFrame, x_column: str, error_column: str, method: str) -> None:
    """Draw the errors of one method over cost or step: hollow marks for no error, a ring for the default."""
    colour, dash, marker = _LINE_STYLE_BY_METHOD[method]
    rows = rows[np.isfinite(rows[error_column])].sort_values(x_column, kind="stable")
    if rows.empty:
        return
    x, y, default = rows[x_column].to_numpy(), rows[error_column].to_numpy(), rows["default"].to_numpy() == 1
    none = (y == 0) & (error_column in {*_DENOMINATOR_COLUMN_BY_COUNT_COLUMN, "boundary_shift"})
    # A logarithmic axis has no zero: draw no wrong case as half a case, and a shift below the resolution as half of it.
    if error_column in _DENOMINATOR_COLUMN_BY_COUNT_COLUMN:
        y = np.where(none, 0.5, y) / np.maximum(rows[_DENOMINATOR_COLUMN_BY_COUNT_COLUMN[error_column]].to_numpy(), 1)
    y = np.where(none & (y == 0), 0.5 * RELATIVE_BOUNDARY_RESOLUTION, y)
    if error_column == "rotation_error":
        y = np.maximum(y, MIN_DRAWN_ROTATION_ERROR_OVER_ALPHA)
    axes.plot(x, y, color=colour, linestyle=dash, linewidth=1.3)
    common: dict[str, Any] = {"linestyle": "none", "clip_on": False, "in_layout": False}
    for face, part in ((colour, ~none), ("white", none)):
        look = {"color": colour, "marker": marker, "markersize": 4.5, "markerfacecolor": face, "zorder": 3}
        axes.plot(x[part], y[part], **common, **look)
    axes.plot(x[default], y[default], marker="o", markersize=11, markerfacecolor="none", color=INK, **common)
    if method == "stiffness" and error_column == "rotation_error":
        for left, top, delta in zip(x, y, rows["penetration_ratio"], strict=True):
            # The last label is next to its mark, where no other line passes.
            offset = (4, 5) if left < x.max() else (7, -3)
            axes.annotate(f"{delta:.0e}", (left, top), xytext=offset, textcoords="offset points", fontsize=7)


def _whole_decade_limits(axes: Any, x_or_y_index: int) -> tuple[float, float]:
    """Return the limits of an axis (0: x, 1: y) as whole powers of ten around its data."""
    values = np.concatenate([np.asarray(line.get_data()[x_or_y_index], float) for line in axes.lines] or [np.ones(1)])
    values = values[np.isfinite(values) & (values > 0)]
    if values.size == 0:
        return 0.1, 1.0
    low, high = np.floor(np.log10(values.min() * 0.95)), np.ceil(np.log10(values.max() * 1.1))
    return 10.0**low, 10.0 ** max(high, low + 1)
