"""Figures of the ground motion: hodographs, spectra along several azimuths, peaks along every azimuth."""

from typing import Any

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from overturning.arrays import FloatArray
from overturning.figures import style
from overturning.figures.cells import isolated_curve_point_indices, symmetric_polar_curve_angles_rad_and_radii
from overturning.figures.compass import create_compass_grid, labels_of_rings_at_round_radii
from overturning.motion.fourier import fourier_amplitude_spectrum, konno_ohmachi_smoothed_amplitude
from overturning.motion.integration import integrate
from overturning.motion.motion import Motion
from overturning.motion.spectra import pseudo_acceleration_spectra
from overturning.units import CM, GAL

FrequenciesOrPeriodsAndSpectraByAzimuth = tuple[FloatArray, list[FloatArray]]
"""Frequencies or periods, and the spectral values at these along each azimuth."""


def draw_hodographs(panels: Any, motion: Motion, fault_normal_deg: float = float("nan")) -> None:
    """Draw hodographs (paths seen from above) of a motion, one quantity per panel.

    Three panels show acceleration, velocity and displacement; two show velocity and displacement, one displacement.
    """
    velocity = integrate(motion.horizontal_components, motion.sampling_interval)
    kinds = (
        ("acceleration", motion.horizontal_components / GAL, "Gal"),
        ("velocity", velocity / CM, "cm/s"),
        ("displacement", integrate(velocity, motion.sampling_interval) / CM, "cm"),
    )
    whose = "" if len(panels) == len(kinds) else " of the ground"
    for axes, (name, (north, east), unit) in zip(panels, kinds[-len(panels) :], strict=True):
        _draw_hodograph(axes, north, east, (f"{name}{whose}", unit), fault_normal_deg)


def _draw_hodograph(
    axes: Any,
    north_component: FloatArray,
    east_component: FloatArray,
    quantity_name_and_unit: tuple[str, str],
    fault_normal_deg: float,
) -> None:
    """Draw the path of a horizontal vector quantity, such as velocity, seen from above: east right, north up."""
    radius, (title, unit) = np.hypot(north_component, east_component), quantity_name_and_unit
    size = float(radius.max(initial=0.0))
    largest = 1.12 * size or 1.0
    if np.isfinite(fault_normal_deg):
        look = {"linestyle": style.DASHED_LINE_STYLE, "linewidth": 1.0, "label": "fault normal", "zorder": 1}
        style.draw_line_through_origin(axes, fault_normal_deg, largest, **look)
    axes.plot(east_component, north_component, color=style.SERIES_COLOURS[2], linewidth=0.6, rasterized=True)
    if size > 0:
        at = int(radius.argmax())
        axes.plot(east_component[at], north_component[at], "o", color=style.FALL_COLOUR, markersize=4, label="peak")
        toward = round(float(np.degrees(np.arctan2(east_component[at], north_component[at])))) % 360
        title += f"\n{style.format_at_least_three_significant_digits(size)} {unit} towards {toward}°"
    axes.set_title(title, fontsize=9)
    axes.set(xlim=(-largest, largest), ylim=(-largest, largest), aspect="equal")
    for zero in (axes.axhline, axes.axvline):
        zero(0, color="#c8c8c8", linewidth=0.5, zorder=0)
    axes.locator_params(nbins=3)
    style.label_axes(axes, f"east, {unit}", f"north, {unit}")
    arrow = {"arrowstyle": "-|>", "color": style.INK, "linewidth": 0.8}
    axes.annotate("N", (0.93, 0.99), (0.93, 0.84), xycoords="axes fraction", ha="center", fontsize=8, arrowprops=arrow)


def hodograph_figure(motion: Motion, fault_normal_deg: float, title: str) -> Figure:
    """Draw hodographs of acceleration, velocity and displacement of a motion.

    The azimuth of the fault normal, degrees, can be NaN.
    """
    figure, panels = style.create_panel_grid(1, 3, style.PAGE_WIDTH_INCHES, 3.2)
    draw_hodographs(panels[0], motion, fault_normal_deg)
    style.add_title_and_legend(figure, title, panels[0, 0], 2)
    return figure


def smoothed_fourier_spectra(motion: Motion, azimuths_deg: list[float]) -> FrequenciesOrPeriodsAndSpectraByAzimuth:
    """Return frequencies (Hz) and, for each azimuth, Fourier amplitudes (m/s), smoothed by Konno and Ohmachi.

    There are no frequencies if the motion is too short for a spectrum.
    """
    low, high = max(0.1, 2.0 / motion.duration), min(25.0, 0.4 / motion.sampling_interval)
    at = np.geomspace(low, high, 120 if high > low else 0)
    pairs = (
        fourier_amplitude_spectrum(motion.acceleration_along(angle), motion.sampling_interval) for angle in azimuths_deg
    )
    return at, [konno_ohmachi_smoothed_amplitude(frequency, amplitude, at) for frequency, amplitude in pairs]


def pseudo_acceleration_spectra_along_azimuths(
    motion: Motion, azimuths_deg: list[float]
) -> FrequenciesOrPeriodsAndSpectraByAzimuth:
    """Return periods (s) and, for each azimuth, pseudo-accelerations (m/s²) at a damping ratio of 0.05."""
    periods = np.geomspace(0.05, 10.0, 60)
    return periods, list(pseudo_acceleration_spectra(motion, periods, azimuths_deg).T)


def fourier_and_response_spectra_figure(motion: Motion, azimuths_deg: list[float], title: str) -> Figure:
    """Draw Fourier spectra of a motion along several azimuths in one panel, and response spectra in another.

    An azimuth without motion has no curve.
    """
    largest = float(np.hypot(*motion.horizontal_components).max())
    moves = [float(np.abs(motion.acceleration_along(azimuth)).max()) > 1e-9 * largest for azimuth in azimuths_deg]
    figure, ((left, right),) = style.create_panel_grid(1, 2, style.PAGE_WIDTH_INCHES, 3.4)
    for axes, (x, spectra), unit, across, up in (
        (left, smoothed_fourier_spectra(motion, azimuths_deg), CM, "frequency, Hz", "Fourier amplitude, Gal·s"),
        (
            right,
            pseudo_acceleration_spectra_along_azimuths(motion, azimuths_deg),
            GAL,
            "period, s",
            "spectral acceleration (damping 5%), Gal",
        ),
    ):
        style.label_axes(axes, across, up)
        shown = [(x > 0) & (values > 0) & moving for values, moving in zip(spectra, moves, strict=True)]
        for index, (azimuth, values, keep) in enumerate(zip(azimuths_deg, spectra, shown, strict=True)):
            axes.plot(
                x[keep], values[keep] / unit, color=style.SERIES_COLOURS[index % len(style.SERIES_COLOURS)],
                linestyle=style.SERIES_LINE_STYLES[index % len(style.SERIES_LINE_STYLES)], linewidth=1.3,
                label=style.compass_bearing_text(azimuth),
            )  # fmt: skip
        if not any(keep.any() for keep in shown):
            note = "too short for a spectrum" if any(moves) else "no motion along this azimuth"
            style.write_note_in_empty_panel(axes, note)
            continue
        axes.set(xscale="log", yscale="log")
        axes.grid(True, which="major")
    style.add_title_and_legend(figure, title, right, 4)
    return figure


def pga_and_pgv_by_azimuth_figure(pga_and_pgv_by_azimuth: xr.Dataset, fault_normal_deg: float, title: str) -> Figure:
    """Draw polar curves of one record's ``pga`` (m/s²) and ``pgv`` (m/s) by azimuth (degrees), in Gal and cm/s.

    The azimuth of the fault normal, degrees, can be NaN.
    """
    azimuth = pga_and_pgv_by_azimuth["azimuth"].to_numpy().astype(np.float64)
    figure, panels = create_compass_grid(1, 2, 6.4, 3.7)
    measures = (("pga", GAL, "PGA, Gal", style.SERIES_COLOURS[1]), ("pgv", CM, "PGV, cm/s", style.SERIES_COLOURS[2]))
    for axes, (name, factor, label, colour) in zip(panels.flat, measures, strict=True):
        peaks = pga_and_pgv_by_azimuth[name].to_numpy() / factor
        largest = float(peaks.max())
        outer, marked = largest * 1.08 or 1.0, bool(np.isfinite(fault_normal_deg))
        axes.draw_compass(
            outer, labels_of_rings_at_round_radii(outer), leaves_room_for_rim_marks=marked, has_spokes=True
        )
        theta, around = symmetric_polar_curve_angles_rad_and_radii(azimuth, peaks)  # a peak is an absolute value
        axes.plot(theta, around, ".-", color=colour, linewidth=1.4, markevery=isolated_curve_point_indices(around))
        axes.set_ylim(0.0, outer)
        style.mark_fault_normal_on_polar_rim(axes, fault_normal_deg)
        along = style.compass_bearing_text(float(azimuth[peaks.argmax()] % 180))
        axes.write_title(
            f"{label}\nlargest {style.format_at_least_three_significant_digits(largest)} along {along}", 10.0
        )
    style.add_title_and_legend(figure, title, panels[0, 0])
    return figure
