"""Peak ground acceleration and velocity along every azimuth."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from overturning.figures.style import (
    SERIES,
    caption,
    compass,
    compass_name,
    grid,
    mark_fault_normal,
    radius_ticks,
    short,
)
from overturning.units import CM, GAL


def intensity_figure(intensity: xr.Dataset, fault_normal_deg: float, title: str) -> Figure:
    """Polar curves of PGA (Gal) and PGV (cm/s) of one record.

    Parameters
    ----------
    intensity : xarray.Dataset
        ``pga`` (m/s²) and ``pgv`` (m/s) over azimuth (degrees), one record.
    fault_normal_deg : float
        Azimuth of the fault normal, degrees, or NaN.
    """
    azimuth = intensity["azimuth"].to_numpy().astype(np.float64)
    # A peak is an absolute value: opposite azimuths share it, and the curve closes on itself.
    around = np.concatenate([azimuth, azimuth + 180.0]) % 360.0
    order = np.argsort(around, kind="stable")
    theta = np.radians(around[order])
    figure, panels = grid(1, 2, 6.4, 3.7, polar=True)
    measures = (("pga", GAL, "PGA, Gal", SERIES[1]), ("pgv", CM, "PGV, cm/s", SERIES[2]))
    for axes, (name, factor, label, colour) in zip(panels.flat, measures, strict=True):
        values = np.tile(intensity[name].to_numpy() / factor, 2)[order]
        compass(axes)
        axes.plot(np.append(theta, theta[0] + 2 * np.pi), np.append(values, values[0]), color=colour, linewidth=1.4)
        radius_ticks(axes, float(values.max()) * 1.08 or 1.0)
        axes.yaxis.set_major_locator(MaxNLocator(4))
        mark_fault_normal(axes, fault_normal_deg)
        along = float(around[order][values.argmax()] % 180)
        axes.set_title(f"{label}\nlargest {short(values.max())} along {compass_name(along)}", pad=4)
    caption(figure, title, panels[0, 0])
    return figure
