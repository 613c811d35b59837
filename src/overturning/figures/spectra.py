"""Fourier and response spectra of several azimuths on one axis (the paper's figure 5)."""

from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from overturning.figures.style import DASHES, PAGE_WIDTH, SERIES, caption, compass_name, grid, labels
from overturning.units import CM, GAL


def _draw_spectrum(axes: Any, spectra: xr.DataArray, along: str, factor: float, label: str) -> None:
    """Draw a spectrum per azimuth ``along`` period (s) or frequency (Hz), over ``factor``, on logarithmic axes."""
    x = spectra[along].to_numpy()
    for index, azimuth in enumerate(spectra["azimuth"].to_numpy()):
        values = spectra.isel(azimuth=index).to_numpy() / factor
        keep = (x > 0) & (values > 0)
        axes.plot(
            x[keep], values[keep], color=SERIES[index % len(SERIES)], linestyle=DASHES[index % len(DASHES)],
            linewidth=1.3, label=compass_name(float(azimuth)),
        )  # fmt: skip
    axes.set(xscale="log", yscale="log")
    labels(axes, "period, s" if along == "period" else "frequency, Hz", label)
    axes.grid(True, which="major")


def spectra_figure(fourier: xr.DataArray, response: xr.DataArray, title: str, damping: float = 0.05) -> Figure:
    """Figure with the Fourier amplitude spectra and the response spectra.

    Parameters
    ----------
    fourier : xarray.DataArray, dimensions azimuth, frequency
        Fourier amplitude of the acceleration, m/s.
    response : xarray.DataArray, dimensions azimuth, period
        Spectral acceleration, m/s².
    damping : float
        Damping ratio of the response spectra.
    """
    figure, ((left, right),) = grid(1, 2, PAGE_WIDTH, 3.4)
    _draw_spectrum(left, fourier, "frequency", CM, "Fourier amplitude, Gal·s")
    _draw_spectrum(right, response, "period", GAL, f"spectral acceleration (damping {damping:.0%}), Gal")
    caption(figure, title, right, 4)
    return figure
