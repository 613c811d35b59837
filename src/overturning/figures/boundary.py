"""The overturning boundary by azimuth of the motion, one curve per friction, with its band between scrambles."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from overturning.figures.polar_panels import MOST_IN_A_ROW
from overturning.figures.style import DASHES, SERIES, caption, compass, mark_fault_normal, radius_labels


def _draw_boundary(axes: Any, bounds: xr.Dataset, top: float) -> None:
    """Draw the curves of one height.

    Where the block still falls at the largest B/H of the cube, ``top``, the curve is drawn there with triangles.
    """
    compass(axes)
    azimuth = np.radians(bounds["azimuth"].to_numpy().astype(np.float64))
    closed = np.append(azimuth, azimuth[0] + 2 * np.pi)

    def around(values: Any) -> Any:
        return np.append(values, values[0])

    for index, friction in enumerate(bounds["friction"].to_numpy()):
        one = bounds.isel(friction=index)
        beyond = one["falls_beyond"].to_numpy()
        colour = SERIES[index % len(SERIES)]
        radius, low, high = (
            np.where(beyond, top, one[name].to_numpy()) for name in ("boundary", "boundary_low", "boundary_high")
        )
        if np.isfinite(low).any():
            # Where a band is not known it has no width; a gap would leave the layout without a size.
            low, high = np.nan_to_num(low, nan=0.0), np.where(np.isnan(low), 0.0, high)
            axes.fill_between(closed, around(low), around(high), color=colour, alpha=0.25, linewidth=0)
        axes.plot(
            closed, around(radius), color=colour, linestyle=DASHES[index % len(DASHES)], linewidth=1.5,
            label=f"µ = {friction:g}",
        )  # fmt: skip
        # A curve needs two neighbours; an azimuth alone is a point.
        known = np.isfinite(radius)
        alone = known & ~np.roll(known, 1) & ~np.roll(known, -1)
        if alone.any():
            axes.plot(azimuth[alone], radius[alone], ".", color=colour, markersize=5)
        if beyond.any():
            axes.plot(azimuth[beyond], np.full(int(beyond.sum()), top), "^", color=colour, markersize=3)
    axes.set_ylim(0.0, top * 1.04)
    ticks = [tick for tick in (0.2, 0.4, 0.6, 0.8, 1.0) if tick <= top] or [round(top, 2)]
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    radius_labels(axes)


def boundary_figure(bounds: xr.Dataset, top: float, fault_normal_deg: float, title: str) -> Figure:
    """Figure of one record: a panel per height.

    Parameters
    ----------
    bounds : xarray.Dataset
        One record of `statistics.boundary.boundary`: azimuth, height, friction.
    top : float
        Largest B/H of the cube.
    fault_normal_deg : float
        Azimuth of the fault normal, degrees, or NaN.
    """
    import matplotlib.pyplot as plt

    loaded = bounds.compute()
    heights = loaded["height"].to_numpy()
    columns = min(heights.size, MOST_IN_A_ROW)
    rows = -(-heights.size // columns)
    figure, panels = plt.subplots(
        rows,
        columns,
        figsize=(max(3.1 * columns, 4.0), 3.1 * rows + 1.0),
        subplot_kw={"projection": "polar"},
        squeeze=False,
        layout="constrained",
    )
    for axes in panels.flat[heights.size :]:
        axes.set_visible(False)
    for axes, height in zip(panels.flat, heights, strict=False):
        _draw_boundary(axes, loaded.sel(height=height), top)
        mark_fault_normal(axes, fault_normal_deg, axes.get_ylim()[1])
        axes.set_title(f"H = {height:g} m", pad=4)
    lines, names = panels[0, 0].get_legend_handles_labels()
    if bool(loaded["falls_beyond"].any()):
        lines.append(plt.Line2D([], [], color="#555555", marker="^", linestyle="none", markersize=4))
        names.append("falls at every B/H of the study")
    figure.legend(lines, names, loc="outside lower center", ncols=3, fontsize=8)
    caption(figure, f"{title}\nlargest B/H that falls, by azimuth of the motion")
    return figure
