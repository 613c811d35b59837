"""Figure of the overturning boundary by azimuth of the motion: a curve and an uncertainty band per friction."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from overturning.figures.cells import (
    extend_azimuths_to_full_circle,
    isolated_curve_point_indices,
    panel_row_and_column_counts,
)
from overturning.figures.compass import b_over_h_ring_labels, create_compass_grid
from overturning.figures.style import (
    SERIES_COLOURS,
    SERIES_LINE_STYLES,
    add_title_and_legend,
    mark_fault_normal_on_polar_rim,
)
from overturning.labels import friction_label


def _draw_overturning_boundary(axes: Any, boundary_by_azimuth: xr.Dataset, largest_simulated_b_over_h: float) -> None:
    """Draw on a polar axis the largest B/H at which blocks of one height fall, by azimuth of the motion.

    Triangles mark azimuths at which the block still falls at the largest B/H with a known outcome: the boundary lies
    beyond them.
    """
    azimuth = np.radians(boundary_by_azimuth["azimuth"].to_numpy().astype(np.float64))
    closed, around = np.append(azimuth, azimuth[0] + 2 * np.pi), np.arange(azimuth.size + 1) % azimuth.size

    for index, friction in enumerate(boundary_by_azimuth["friction"].to_numpy()):
        one = boundary_by_azimuth.isel(friction=index)
        beyond = one["falls_beyond"].to_numpy() == 1  # False where the outcome is missing
        largest, colour = one["largest_known"].to_numpy(), SERIES_COLOURS[index % len(SERIES_COLOURS)]
        radius, low, high = (
            np.where(beyond, largest, one[name].to_numpy()) for name in ("boundary", "boundary_low", "boundary_high")
        )
        if np.isfinite(low).any():
            # Matplotlib cannot compute the layout of a filled band that contains NaN: replace it by 0.
            ends = (np.nan_to_num(end, nan=0.0)[around] for end in (low, high))
            axes.fill_between(closed, *ends, where=np.isfinite(low)[around], color=colour, alpha=0.25, linewidth=0)
        axes.plot(
            closed, radius[around], color=colour, linestyle=SERIES_LINE_STYLES[index % len(SERIES_LINE_STYLES)],
            linewidth=1.5,
            label=friction_label(boundary_by_azimuth, friction),
        )  # fmt: skip
        # A line needs two neighbouring azimuths; an isolated azimuth is drawn as a point.
        if alone := isolated_curve_point_indices(radius[around]):
            axes.plot(azimuth[alone], radius[alone], ".", color=colour, markersize=5)
        if beyond.any():
            axes.plot(azimuth[beyond], largest[beyond], "^", color=colour, markersize=3)
    axes.set_ylim(0.0, largest_simulated_b_over_h * 1.04)


def overturning_boundary_figure(
    boundary_by_azimuth: xr.Dataset, largest_simulated_b_over_h: float, fault_normal_deg: float, title: str
) -> Figure:
    """Draw the largest B/H at which blocks fall under one record, by azimuth of the motion, one panel per height.

    `boundary_by_azimuth` carries the attributes of the results cube from which it was computed, if the cube belongs to
    a study. `largest_simulated_b_over_h` is the largest B/H of this cube. If the fault normal is NaN, none is drawn.
    """
    loaded = extend_azimuths_to_full_circle(boundary_by_azimuth.compute())
    heights = loaded["height"].to_numpy()
    rows, columns = panel_row_and_column_counts(heights.size, 1)
    side = {1: 3.6, 2: 2.9, 3: 1.95}[columns]
    figure, panels = create_compass_grid(
        rows, columns, max(side * columns, 4.0), (side + 0.3) * rows + 1.0, heights.size
    )
    rings, marked = (
        b_over_h_ring_labels(1.04 * largest_simulated_b_over_h, largest_simulated_b_over_h),
        np.isfinite(fault_normal_deg),
    )
    for axes, height in zip(panels.flat, heights, strict=False):
        axes.draw_compass(
            1.04 * largest_simulated_b_over_h, rings, leaves_room_for_rim_marks=bool(marked), has_spokes=True
        )
        _draw_overturning_boundary(axes, loaded.sel(height=height), largest_simulated_b_over_h)
        mark_fault_normal_on_polar_rim(axes, fault_normal_deg)
        axes.write_title(f"H = {height:g} m", 10.0)
    look: dict[str, Any] = {"color": "#555555", "marker": "^", "linestyle": "none", "markersize": 4}
    marks = [Line2D([], [], label="falls at the largest B/H of known outcome", **look)]
    beyond = marks if bool((loaded["falls_beyond"] == 1).any()) else []
    spread = bool((loaded["boundary_high"] > loaded["boundary_low"]).any())
    band = "\nband: between the two halves of the ensemble" if spread else ""
    legend_columns = 3 if figure.get_figwidth() > 5.0 or not (marked and beyond) else 1
    whole = f"{title}\nlargest B/H that falls, by azimuth of the motion{band}"
    add_title_and_legend(figure, whole, panels[0, 0], legend_columns, last_legend_handles=beyond)
    return figure
