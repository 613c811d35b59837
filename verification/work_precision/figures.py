"""Error against run time, log-log, one line per method, the default setting marked."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
import pandas as pd

from overturning.figures.style import DASHES, INK, SERIES, save, style
from overturning.model.contact import STATIC_PENETRATION
from verification.work_precision.boundaries import RESOLUTION
from verification.work_precision.page import over_steps

_LOOK: Final = {
    name: (SERIES[index], DASHES[index], marker)
    for index, (name, marker) in enumerate(
        zip(("centred", "cundall", "stiffness", "Box2D", "pymunk", "MuJoCo"), "osD^vP", strict=True)
    )
}
_LABELS: Final = {
    "wrong_flags": "wrong flags, share",
    "wrong_sides": "wrong sides, share",
    "rotation_error": "peak rotation,\nmedian error / α",
    "boundary_shift": "overturning boundary,\nmedian shift / (B/H)",
    "slip_error": "peak slip,\nlargest error, share",
    "energy_error": "work and energy,\nmean residual",
}
_SCHEMES: Final = {"centred": "centred, over time steps", "cundall": "cundall, over time steps"}
_COUNTED: Final = {"wrong_flags": "cases", "wrong_sides": "fallen"}


def draw_against_finer_steps(rows: pd.DataFrame, path: Path) -> None:
    """Draw the error of both schemes over time steps, and of springs over stiffness, on real records.

    Parameters
    ----------
    rows : DataFrame
        The table of `verification.work_precision`.
    path : Path
        SVG or PNG file to make.
    """
    import matplotlib.pyplot as plt

    measures = ("wrong_flags", "wrong_sides", "rotation_error", "boundary_shift")
    with style():
        figure, axes = plt.subplots(len(measures), 2, figsize=(7.6, 9.6), sharex="col", squeeze=False)
        for column, kind in enumerate(("rocking", "sliding")):
            chosen = over_steps(rows, kind)
            springs = (rows["cases_of"] == f"records, {kind}") & (rows["against"] == "stiffest springs")
            for axis, measure in zip(axes[:, column], measures, strict=True):
                for method in ("centred", "cundall"):
                    _line(axis, rows[chosen & (rows["method"] == method)], "seconds_per_case", measure, method)
                label = measure == "rotation_error"
                _line(axis, rows[springs], "seconds_per_case", measure, "stiffness", label_penetration=label)
                _finish(axis, measure, first=column == 0)
            limits = np.array([_decades(axis, 0) for axis in axes[:, column]])  # shared: the widest holds for all
            axes[0, column].set_xlim(limits[:, 0].min(), limits[:, 1].max())
            friction = {"rocking": "µ = 1 and 10", "sliding": "µ = 0.33 and 0.58"}[kind]
            axes[0, column].set_title(f"six records, {friction}")
            axes[-1, column].set_xlabel("processor time per case, s")
        methods = _SCHEMES | {"stiffness": "centred, δ/B 2e-3 to 2e-8, against 2e-8"}
        figure.legend(handles=_handles(methods), loc="lower center", ncols=2, bbox_to_anchor=(0.5, 0.0))
        figure.subplots_adjust(left=0.13, right=0.98, top=0.96, bottom=0.15, hspace=0.12, wspace=0.2)
        save(figure, path)


def draw_against_rigid_solutions(rows: pd.DataFrame, path: Path) -> None:
    """Draw the error of kernel and rigid-body engines against the rigid block's rocking and sliding."""
    import matplotlib.pyplot as plt

    own = np.isclose(rows["penetration_ratio"], STATIC_PENETRATION)
    engine = rows["penetration_ratio"].isna()
    default_step = rows["step_fraction"] == rows["step_fraction"][rows["default"] == 1].iloc[0]
    slides, energy = rows["cases_of"] == "sliding blocks", rows["against"] == "energy balance"
    with style():
        figure, axes = plt.subplots(3, 2, figsize=(7.6, 9.6), layout="constrained")
        for line, (set_of, title) in enumerate(
            (("sine pulses", "sine pulses, rigid rocking"), ("records, no sliding", "six records, rigid rocking"))
        ):
            mine = (rows["cases_of"] == set_of) & (rows["against"] == "rigid rocking")
            stiffness = mine & ~engine & (rows["method"] == "centred") & default_step
            for axis, measure in zip(axes[line], ("wrong_flags", "rotation_error"), strict=True):
                for method in ("centred", "cundall"):
                    _line(axis, rows[mine & own & (rows["method"] == method)], "seconds_per_case", measure, method)
                label = measure == "rotation_error"
                _line(axis, rows[stiffness], "seconds_per_case", measure, "stiffness", label_penetration=label)
                if measure == "wrong_flags":
                    for method in ("Box2D", "pymunk", "MuJoCo"):
                        _line(axis, rows[mine & (rows["method"] == method)], "seconds_per_case", measure, method)
                _finish(axis, measure, first=True)
                axis.set_title(title)
                axis.set_xlabel("processor time per case, s")
        slip, balance = axes[2]
        for method in ("centred", "cundall"):
            mine = rows["method"] == method
            _line(slip, rows[slides & mine], "seconds_per_case", "slip_error", method)
            _line(balance, rows[energy & mine], "step_fraction", "energy_error", method)
        for axis, measure, title in (
            (slip, "slip_error", "sliding blocks, exact sliding"),
            (balance, "energy_error", "six records"),
        ):
            _finish(axis, measure, first=True)
            axis.set_title(title)
            axis.set_xlabel("Δt / Δt stable" if axis is balance else "processor time per case, s")
        engines = [name for name in ("Box2D", "pymunk", "MuJoCo") if (rows["method"] == name).any()]
        methods = _SCHEMES | {"stiffness": "centred, δ/B 2e-3 to 2e-8"} | {name: name for name in engines}
        figure.legend(handles=_handles(methods), loc="outside lower center", ncols=3)
        save(figure, path)


def _handles(methods: Mapping[str, str]) -> list[Any]:
    """The legend: methods, and what hollow marks and rings mean."""
    from matplotlib.lines import Line2D

    handles = [
        Line2D(
            [], [], color=_LOOK[name][0], linestyle=_LOOK[name][1], marker=_LOOK[name][2], markersize=4.5, label=label
        )
        for name, label in methods.items()
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


def _line(
    axis: Any,
    rows: pd.DataFrame,
    across: str,
    measure: str,
    method: str,
    label_penetration: bool = False,
) -> None:
    if rows.empty:
        return
    colour, dash, marker = _LOOK[method]
    rows = rows.sort_values(across, kind="stable")
    x, y, default = rows[across].to_numpy(), rows[measure].to_numpy(), rows["default"].to_numpy() == 1
    none = np.zeros(y.size, bool)
    if measure in _COUNTED:
        none = y == 0
        # A logarithm has no zero: no wrong case is drawn, hollow, at half a case.
        y = np.where(none, 0.5, y) / np.maximum(rows[_COUNTED[measure]].to_numpy(), 1)
    if measure == "boundary_shift":
        none = y == 0
        y = np.where(none, 0.5 * RESOLUTION, y)
    good = np.isfinite(y)
    axis.plot(x[good], y[good], color=colour, linestyle=dash, linewidth=1.3)
    for filled, part in ((True, good & ~none), (False, good & none)):
        axis.plot(
            x[part], y[part], color=colour, linestyle="none", marker=marker, markersize=4.5,
            markerfacecolor=colour if filled else "white", clip_on=False, in_layout=False, zorder=3,
        )  # fmt: skip
    mine = default & good
    axis.plot(
        x[mine],
        y[mine],
        linestyle="none",
        marker="o",
        markersize=11,
        markerfacecolor="none",
        color=INK,
        clip_on=False,
        in_layout=False,
    )
    if label_penetration:
        for left, top, delta in zip(x, y, rows["penetration_ratio"], strict=True):
            # The last beside its mark, where no other line passes.
            offset = (4, 5) if left < x.max() else (7, -3)
            axis.annotate(f"{delta:.0e}", (left, top), xytext=offset, textcoords="offset points", fontsize=7)


def _finish(axis: Any, measure: str, first: bool) -> None:
    from matplotlib.ticker import NullFormatter

    axis.set_xscale("log")
    axis.set_yscale("log")
    # Whole decades, so that every axis has at least two labelled ticks.
    axis.set_xlim(*_decades(axis, 0))
    axis.set_ylim(*_decades(axis, 1))
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.yaxis.set_minor_formatter(NullFormatter())
    axis.grid(True, which="major")
    if first:
        axis.set_ylabel(_LABELS[measure])


def _decades(axis: Any, which: int) -> tuple[float, float]:
    values = np.concatenate([np.asarray(line.get_data()[which], float) for line in axis.lines] or [np.ones(1)])
    values = values[np.isfinite(values) & (values > 0)]
    if values.size == 0:
        return 0.1, 1.0
    low, high = np.floor(np.log10(values.min() * 0.95)), np.ceil(np.log10(values.max() * 1.1))
    return 10.0**low, 10.0 ** max(high, low + 1)
