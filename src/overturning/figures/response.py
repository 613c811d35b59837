"""Figures of the response to a motion: rotation, slip and uplift; 3-D: the axis from above."""

from collections.abc import Sequence
from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from overturning.figures import style
from overturning.figures.film_of_plane import trajectory_of_free_elements
from overturning.figures.film_of_trajectory import (
    film_start_and_end_times,
    outcome_sentence,
    trajectory_has_known_outcome,
)
from overturning.figures.ground import draw_hodographs
from overturning.motion.motion import Motion
from overturning.units import CM, GAL

ROW_LABELS_SINGLE_ELEMENT = ("base acceleration, Gal", "rotation, °", "slip of the base, cm", "uplift, cm")

ROW_LABELS_SEVERAL_ELEMENTS = (*ROW_LABELS_SINGLE_ELEMENT[:2], "slip over ground, cm", "uplift over ground, cm")
"""Labels for several elements: their motion is relative to the ground, since an element moves with those below it."""

_MAX_ROUNDING_ERROR_AT_REST_DEG_OR_CM = 1e-6
"""Largest rotation, degrees, and displacement, cm, that are rounding errors of a stone at rest."""

MAX_DRAWN_CRITICAL_ANGLE_OVER_LARGEST_ROTATION = 3.0
"""The critical angle is drawn if it is at most this multiple of the largest rotation; otherwise the scale would
hide the rotations."""


def element_rotation_deg_slip_cm_and_uplift_cm(element_trajectory: xr.Dataset) -> list[Any]:
    """Return rotation (degrees), slip of the base (cm) and uplift of the highest base vertex (cm) over time."""
    p, q = element_trajectory["vertices"].to_numpy()[np.isfinite(element_trajectory["vertices"].to_numpy()[:, 0])].T
    lower = q <= q.min() + 1e-9 * np.ptp(q)
    angle, z = (element_trajectory[name].to_numpy()[:, None] for name in ("rotation", "z"))
    level = z - p[lower] * np.sin(angle) + q[lower] * np.cos(angle)
    return [
        np.degrees(angle[:, 0]),
        element_trajectory["base_slip"].to_numpy() / CM,
        (level.max(axis=1) - level[0].max()) / CM,
    ]


def rotation_slip_and_uplift_figure(trajectories: Sequence[xr.Dataset], title: str) -> Figure:
    """Draw ground acceleration, rotation, slip and uplift over time (rows), one column per 2-D simulation.

    All columns have the same scales; the heading of a column is the azimuth of the motion and the outcome. Each free
    element has a curve, with a legend if there are several. Dashed lines mark its critical angle unless that is far
    above all rotations.
    """
    width = max(min(3.3 * len(trajectories), style.PAGE_WIDTH_INCHES), 4.4, 2.0 * len(trajectories))
    figure, rows = style.create_panel_grid(
        len(ROW_LABELS_SINGLE_ELEMENT), len(trajectories), width, 6.6, sharex=True, sharey="row"
    )
    start, end = film_start_and_end_times(trajectories)
    largest = max(
        float(np.abs(np.degrees(trajectory_of_free_elements(trajectory)["rotation"])).max())
        for trajectory in trajectories
    )
    several = trajectory_of_free_elements(trajectories[0]).sizes["element"] > 1
    names = ROW_LABELS_SEVERAL_ELEMENTS if several else ROW_LABELS_SINGLE_ELEMENT
    for column, trajectory in enumerate(trajectories):
        time, upper = trajectory["time"].to_numpy(), rows[0, column]
        upper.plot(time, trajectory["ground_acceleration"].to_numpy() / GAL, color="#555555", linewidth=0.8)
        for number, name in enumerate(trajectory_of_free_elements(trajectory)["element"].to_numpy()):
            one, look = (
                trajectory.sel(element=name),
                {"color": style.SERIES_COLOURS[number % len(style.SERIES_COLOURS)], "linewidth": 1.0},
            )
            for axes, values in zip(rows[1:, column], element_rotation_deg_slip_cm_and_uplift_cm(one), strict=True):
                axes.plot(
                    time,
                    values,
                    label=str(name),
                    linestyle=style.SERIES_LINE_STYLES[number % len(style.SERIES_LINE_STYLES)],
                    **look,
                )
            alpha = float(np.degrees(one["critical_angle"]))
            if alpha <= MAX_DRAWN_CRITICAL_ANGLE_OVER_LARGEST_ROTATION * largest:
                for sign in (1, -1):
                    rows[1, column].axhline(
                        sign * alpha, linestyle=style.DASHED_LINE_STYLE, **(look | {"linewidth": 0.7})
                    )
                position = {"xycoords": ("axes fraction", "data"), "va": "bottom", "fontsize": 8}
                # One beside the other: critical angles of several elements may be nearly equal.
                rows[1, column].annotate("α", (0.01 + 0.05 * number, alpha), color=look["color"], **position)
        for row, axes in enumerate(rows[:, column]):
            axes.axhline(0, color="#c8c8c8", linewidth=0.5, zorder=0)
            axes.locator_params(axis="y", nbins=5)
            style.label_axes(
                axes, "time, s" if row == len(ROW_LABELS_SINGLE_ELEMENT) - 1 else "", names[row] if column == 0 else ""
            )
        heading = style.compass_bearing_text(trajectory.attrs["azimuth_deg"])
        upper.set_title(
            fill(
                f"{heading}: {_outcome_label_of_2d_simulation(trajectory)}", int(18 * width / len(trajectories) / 1.25)
            ),
            fontsize=9,
            y=1.0,  # a place that needs no measurement of the ticks
            parse_math=False,
        )
    for row in rows[1:]:  # at rest nothing but rounding errors would be drawn, on a scale of 1e-17
        if (
            max(float(np.abs(line.get_ydata()).max()) for axes in row for line in axes.lines)
            < _MAX_ROUNDING_ERROR_AT_REST_DEG_OR_CM
        ):
            row[0].set_ylim(-1.0, 1.0)
    # End the time axis with the longest trajectory.
    last = min(end + 1.5, max(float(trajectory["time"][-1]) for trajectory in trajectories))
    start = max(0.0, start - 1.5)
    rows[0, 0].set_xlim(start, max(last, start + 0.1))
    figure.align_ylabels(rows[:, 0])
    style.add_title_and_legend(figure, title, rows[1, 0] if several else None, 3)
    return figure


def _outcome_label_of_2d_simulation(trajectory: xr.Dataset) -> str:
    """Return the outcome of a 2-D simulation as text: "no outcome", "stands", "falls", or which elements fall."""
    if not trajectory_has_known_outcome(trajectory):
        return "no outcome"
    free = trajectory_of_free_elements(trajectory)
    fell = [
        str(name)
        for name, side in zip(free["element"].to_numpy(), free["overturned"].to_numpy(), strict=True)
        if abs(side) == 1
    ]
    if not fell:
        return "stands"
    return "falls" if free.sizes["element"] == 1 else f"{', '.join(fell)} {'falls' if len(fell) == 1 else 'fall'}"


def _least_tilt_to_balance_on_edge_deg(trajectory: xr.Dataset) -> float:
    """Return the least tilt, degrees, at which a 3-D body or a stone of a stack balances on an edge."""
    if "element" in trajectory.coords:  # B/H of a stack is that of another stone, or not that of the narrower side
        return float(np.degrees(trajectory["critical_angle"]))
    across = float(trajectory.attrs.get("aspect", 1.0))  # D is the smaller side if D < B
    return float(np.degrees(np.arctan(float(trajectory.attrs["b_over_h"]) * min(1.0, across))))


def _fall_azimuth_or_largest_tilt_text_in_3d(trajectory: xr.Dataset) -> str:
    """Return the outcome of a 3-D body as a short text: no outcome, the azimuth of its fall, or its largest tilt."""
    if not trajectory_has_known_outcome(trajectory):
        return "no outcome"
    # The first two parts of "stands; largest tilt 1.2°; turned …", or "falls towards N60°E" of "… at 2.18 s".
    return ";".join(outcome_sentence(trajectory).split(" at ")[0].split(";")[:2])


def tilt_path_and_hodographs_figure(trajectory: xr.Dataset, motion: Motion, title: str) -> Figure:
    """Draw the tilt of a 3-D body's axis seen from above, and hodographs of ground velocity and displacement.

    Of a stack, only the axis of the reference element is drawn.
    """
    if "element" in trajectory.dims:
        trajectory = trajectory.sel(element=trajectory.attrs["reference"])
    figure, panels = style.create_panel_grid(1, 3, 9.2, 3.9)
    axes = panels[0, 0]
    east, north = trajectory["tilt_east"].to_numpy(), trajectory["tilt_north"].to_numpy()
    up = np.sqrt(np.maximum(0.0, 1.0 - east**2 - north**2))
    angle = np.degrees(np.arctan2(np.hypot(east, north), up))
    length = np.hypot(east, north)
    scale = np.where(length > 0, angle / np.where(length > 0, length, 1.0), 0.0)
    x, y = east * scale, north * scale
    critical = _least_tilt_to_balance_on_edge_deg(trajectory)
    largest = 1.12 * max(float(angle.max(initial=0.0)), critical)
    for radius, dash, name in ((critical, "--", "least critical angle"), (90.0, ":", "lying")):
        if radius < largest:
            turn = np.linspace(0.0, 2.0 * np.pi, 181)
            axes.plot(radius * np.cos(turn), radius * np.sin(turn), dash, color=style.INK, linewidth=0.8, label=name)
    axes.plot(x, y, color=style.SERIES_COLOURS[0], linewidth=0.8, label="axis of the body")
    axes.plot(x[-1], y[-1], "s", color=style.INK, markersize=4, label="end")  # unlike the peaks of the hodographs
    axes.set(xlim=(-largest, largest), ylim=(-largest, largest), aspect="equal")
    stone = f" of the {trajectory['element'].item()}" if "element" in trajectory.coords else ""
    axes.set_title(
        f"tilt of the axis{stone}, degrees\n{_fall_azimuth_or_largest_tilt_text_in_3d(trajectory)}",
        fontsize=9,
        parse_math=False,
    )
    style.label_axes(axes, "east", "north")
    draw_hodographs(panels[0, 1:], motion.scaled_by(float(trajectory.attrs["amplitude"])))
    peaks = panels[0, 1].get_legend_handles_labels()[0]
    style.add_title_and_legend(figure, title, axes, 5, last_legend_handles=peaks)
    return figure
