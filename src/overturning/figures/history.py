"""Figure of a record before and after its processing: time histories, spectra and the removed acceleration."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from overturning.arrays import FloatArray
from overturning.figures.style import (
    DASHED_LINE_STYLE,
    FALL_COLOUR,
    INK,
    MISSING_COLOUR,
    SERIES_COLOURS,
    create_panel_grid,
    format_at_least_three_significant_digits,
    indices_and_values_of_minima_and_maxima,
    label_axes,
    label_logarithmic_ticks,
    wrap_name_into_lines,
    write_note_in_empty_panel,
)
from overturning.motion.fourier import rms_fourier_amplitude_in_bands
from overturning.motion.integration import integrate
from overturning.motion.motion import Motion
from overturning.motion.noise import SignalNoiseSpectra, shortest_usable_noise_window_s, signal_and_noise_spectra
from overturning.motion.spectra import rotd_percentile_measures
from overturning.records.processing import MIN_SIGNAL_TO_NOISE_RATIO
from overturning.records.record import Record, processing_entry_text, processing_state_label
from overturning.study.intensity import ROTD_PERCENTILES, SPECTRUM_PERIODS_S
from overturning.units import CM, GAL

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

RECORD_COMPONENT_NAMES: Final = ("north", "east", "up")
TIME_HISTORY_LABELS_AND_UNITS: Final = (("acceleration, Gal", GAL), ("velocity, cm/s", CM), ("displacement, cm", CM))
RESPONSE_SPECTRUM_PERIODS_S: Final = SPECTRUM_PERIODS_S[SPECTRUM_PERIODS_S >= 0.05]
"""Periods of the response spectra, s: twenty per decade; their damping ratio is 0.05."""

TIME_BIN_COUNT_OF_DRAWN_ENVELOPE: Final = 600
"""Number of bins along the time axis; only the smallest and the largest sample of each are drawn (below a pixel)."""


def record_before_and_after_processing_figure(unprocessed_record: Record, processed_record: Record) -> "Figure":
    """Draw time histories and spectra of a record before and after processing, a column per component.

    Rows: acceleration, velocity and displacement before (grey) and after processing; Fourier amplitudes with the
    corner frequencies and the noise before the onset; Husid plot, signal-to-noise ratio and removed acceleration;
    response spectra over all azimuths after processing.

    Parameters
    ----------
    unprocessed_record, processed_record : Record
        The record before and after processing; one and the same object if it was not processed.
    """
    names = [name for name in RECORD_COMPONENT_NAMES if getattr(processed_record, name) is not None]
    wide = len(names) > 2
    figure, panels = create_panel_grid(6, len(names), 3.5 * len(names), 2.04 * 6, layout_engine=None)
    for panel in panels[5, 1:] if wide else ():
        panel.remove()
    if wide:
        panels[5, 0].set_subplotspec(panels[5, 0].get_gridspec()[5, :])
    _draw_rotd_spectra(panels[5, 0 if wide else 1], rotd_pseudo_acceleration_spectra(processed_record))
    moving = [getattr(unprocessed_record, name) for name in names]
    noise = signal_and_noise_spectra(moving, unprocessed_record.sampling_interval)
    for column, name in enumerate(names):
        _draw_component_time_histories(panels[:3, column], unprocessed_record, processed_record, name)
        panels[0, column].set_title(name, fontsize=9, y=1.0)  # a place that needs no measurement of the ticks
        _draw_fourier_spectra(panels[3, column], unprocessed_record, processed_record, name)
        for panel in panels[1:3, column]:
            panel.sharex(panels[0, column])
        for panel in panels[:2, column]:
            panel.tick_params(labelbottom=False)
    _draw_husid(panels[4, 0], processed_record, names)
    shown = [name for name, samples in zip(names, moving, strict=True) if np.ptp(samples) > 0]
    _draw_signal_to_noise_ratio(
        panels[4, 1], noise, shown, shortest_usable_noise_window_s(unprocessed_record.sampling_interval)
    )
    _draw_removed_acceleration(panels[4, 2] if wide else panels[5, 0], unprocessed_record, processed_record, names)
    _add_title_and_legend(figure, panels, unprocessed_record, processed_record, noise)
    return figure


def _add_title_and_legend(
    figure: "Figure",
    panels: Any,
    unprocessed_record: Record,
    processed_record: Record,
    signal_noise_spectra: SignalNoiseSpectra | None,
) -> None:
    """Add the title (station, event and processing steps), the legend and the margins to a record's figure."""
    ahead = (
        "no noise before the onset"
        if signal_noise_spectra is None
        else f"onset at {signal_noise_spectra.onset_s:.1f} s"
    )
    steps = _processing_step_lines(processed_record.processing)
    agency = (
        [str(unprocessed_record.extra["agency_processing"])] if "agency_processing" in unprocessed_record.extra else []
    )
    lines = [
        ", ".join(
            text for text in (processed_record.station or processed_record.record_id, processed_record.event) if text
        ),
        "; ".join([processing_state_label(unprocessed_record), *agency, ahead]),
        *(["here: " + steps[0], *steps[1:]] if steps else ["nothing done here"]),
    ]
    wrapped = [part for line in lines for part in wrap_name_into_lines(line, 50 * panels.shape[1])]
    figure.suptitle("\n".join(wrapped), fontsize=8, parse_math=False, y=0.995)
    from matplotlib.lines import Line2D

    marks = [
        Line2D([], [], color=MISSING_COLOUR, label="before processing"),
        Line2D([], [], color=INK, label="as used"),
    ]
    if unprocessed_record is not processed_record:
        figure.legend(handles=marks, loc="lower center", ncols=2, fontsize=8)
    # Fixed margins: a constrained layout would take most of the drawing time.
    wide = panels.shape[1] > 2
    height = figure.get_figheight()
    top = 1.0 - (0.14 * len(wrapped) + 0.35) / height
    gap = 0.46 if any(axes.yaxis.get_ticks_position() == "right" for axes in figure.axes) else 0.34
    figure.subplots_adjust(0.07 if wide else 0.1, 0.75 / height, 0.94 if wide else 0.91, top, wspace=gap, hspace=0.42)


def _processing_step_lines(processing_steps: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return lines of text on processing steps: each step with a reason on its own line, others joined in one line.

    The text of a step with a reason is translated as a whole, even if the figure breaks it into several lines.
    """
    lines: list[str] = []
    alone = True
    for step in processing_steps:
        text, explained = processing_entry_text(step), "chosen" in step or step["step"] == "common_window"
        if alone or explained:
            lines.append(text)
        else:
            lines[-1] += f"; {text}"
        alone = explained
    return lines


def min_max_envelope(sample_times: FloatArray, samples: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the times and values of the smallest and largest sample per time bin; all samples if there are few."""
    width = -(-sample_times.size // TIME_BIN_COUNT_OF_DRAWN_ENVELOPE)
    if width <= 2:
        return sample_times, samples
    places, drawn = indices_and_values_of_minima_and_maxima(samples, width)
    return sample_times[np.minimum(places, sample_times.size - 1)], drawn


def start_time_relative_to_unprocessed_record(processed_record: Record) -> float:
    """Return the start time of a processed record relative to the start of the unprocessed one, s.

    Padding moves the start to earlier times, cutting to later ones.
    """
    return float(sum(step.get("shift_s", 0.0) for step in processed_record.processing))


def _sample_times(record: Record, first_sample_time: float = 0.0) -> FloatArray:
    """Return the times of a record's samples, s; the first sample is at the time `first_sample_time`."""
    return np.asarray(np.arange(record.north.size) * record.sampling_interval + first_sample_time, dtype=np.float64)


def _acceleration_velocity_displacement(record: Record, component_name: str) -> list[FloatArray]:
    """Return acceleration (m/s²), velocity (m/s) and displacement (m) of one component of a record."""
    samples: FloatArray = getattr(record, component_name)
    velocity = integrate(samples, record.sampling_interval)
    return [samples, velocity, integrate(velocity, record.sampling_interval)]


def _draw_component_time_histories(
    acceleration_velocity_displacement_panels: Any,
    unprocessed_record: Record,
    processed_record: Record,
    component_name: str,
) -> None:
    """Draw acceleration, velocity and displacement of a component in three panels, before and after processing."""
    rows = zip(
        acceleration_velocity_displacement_panels,
        TIME_HISTORY_LABELS_AND_UNITS,
        _acceleration_velocity_displacement(unprocessed_record, component_name),
        _acceleration_velocity_displacement(processed_record, component_name),
        strict=True,
    )
    for panel, (label, unit), old, new in rows:
        peak = np.abs(new).max() / unit
        if unprocessed_record is not processed_record:
            # An offset integrates to metres of displacement; on a common scale the motion would look like a line.
            own = np.abs(old).max() / unit > 2.0 * peak
            behind = panel.twinx() if own else panel
            behind.plot(
                *min_max_envelope(_sample_times(unprocessed_record), old / unit), color=MISSING_COLOUR, linewidth=0.6
            )
            if own:
                behind.tick_params(labelsize=6, colors=MISSING_COLOUR)
                behind.locator_params(axis="y", nbins=5)
                panel.set_zorder(behind.get_zorder() + 1)
                panel.patch.set_visible(False)
        panel.plot(
            *min_max_envelope(
                _sample_times(processed_record, start_time_relative_to_unprocessed_record(processed_record)), new / unit
            ),
            color=INK,
            linewidth=0.6,
        )
        label_axes(panel, "time, s" if panel is acceleration_velocity_displacement_panels[-1] else "", label)
        panel.annotate(
            f"peak {format_at_least_three_significant_digits(peak)}",
            (0.98, 0.96),
            xycoords="axes fraction",
            ha="right",
            va="top",
            fontsize=7,
            color=INK,
        )


def _filter_corner_frequencies(processing_steps: tuple[Mapping[str, Any], ...]) -> list[float]:
    """Return the corner frequencies, Hz, of the filters with which a record was processed."""
    return [step["corner_hz"] for step in processing_steps if "corner_hz" in step]


def _draw_fourier_spectra(
    panel: "Axes", unprocessed_record: Record, processed_record: Record, component_name: str
) -> None:
    """Draw the Fourier amplitudes of a component before and after processing."""
    label_axes(panel, "frequency, Hz", "Fourier amplitude, Gal·s")
    drawn = False
    for record, colour in (
        ((unprocessed_record, MISSING_COLOUR), (processed_record, INK))
        if unprocessed_record is not processed_record
        else ((processed_record, INK),)
    ):
        samples = getattr(record, component_name)
        low, high = max(0.02, 1.0 / record.duration), 0.45 / record.sampling_interval
        if not samples.any() or high < 2.0 * low:
            continue
        frequency = np.geomspace(low, high, 90)
        amplitude = rms_fourier_amplitude_in_bands(samples, record.sampling_interval, frequency) / CM
        panel.plot(frequency, np.maximum(amplitude, 1e-12 * amplitude.max()), color=colour, linewidth=0.9)
        drawn = True
    if not drawn:
        moves = getattr(processed_record, component_name).any()
        write_note_in_empty_panel(panel, "too short for a spectrum" if moves else "no motion")
        return
    for corner in _filter_corner_frequencies(processed_record.processing):
        panel.axvline(corner, color=FALL_COLOUR, linewidth=0.8, linestyle=DASHED_LINE_STYLE)
        panel.annotate(
            f"{corner:g} Hz",
            (corner, 0.03),
            xycoords=("data", "axes fraction"),
            fontsize=7,
            color=FALL_COLOUR,
            rotation=90,
        )
    _set_logarithmic_axes(panel)


def _set_logarithmic_axes(panel: "Axes") -> None:
    """Set both axes of a panel to logarithmic scales with ticks at powers of ten only."""
    from matplotlib.ticker import NullLocator

    panel.set(xscale="log", yscale="log")
    for axis in (panel.xaxis, panel.yaxis):  # minor ticks would take most of the drawing time
        axis.set_minor_locator(NullLocator())
        label_logarithmic_ticks(axis)


def _draw_husid(panel: "Axes", processed_record: Record, component_names: list[str]) -> None:
    """Draw the cumulative squared acceleration of the components (Husid plot)."""
    label_axes(panel, "time, s", "Husid: Arias intensity, %")
    if not any(getattr(processed_record, name).any() for name in component_names):
        write_note_in_empty_panel(panel, "no motion")
        return
    time = _sample_times(processed_record, start_time_relative_to_unprocessed_record(processed_record))
    for name, colour in zip(component_names, SERIES_COLOURS, strict=False):
        energy = np.cumsum(getattr(processed_record, name) ** 2)
        if energy[-1] > 0:
            panel.plot(*min_max_envelope(time, 100.0 * energy / energy[-1]), color=colour, linewidth=1.0, label=name)
    for share in (5, 95):
        panel.axhline(share, color=MISSING_COLOUR, linewidth=0.5, linestyle=DASHED_LINE_STYLE)
    panel.legend(fontsize=7, loc="lower right")


def _draw_signal_to_noise_ratio(
    panel: "Axes",
    signal_noise_spectra: SignalNoiseSpectra | None,
    component_names: list[str],
    min_noise_duration_s: float,
) -> None:
    """Draw the signal-to-noise ratio by frequency, or a note if the noise is shorter than `min_noise_duration_s`, s."""
    label_axes(panel, "frequency, Hz", "signal-to-noise ratio")
    if signal_noise_spectra is None:
        write_note_in_empty_panel(panel, f"no noise of {min_noise_duration_s:g} s\nbefore the onset")
        return
    for row, (name, colour) in enumerate(zip(component_names, SERIES_COLOURS, strict=False)):
        panel.plot(
            signal_noise_spectra.band_centre_frequencies_hz,
            signal_noise_spectra.signal_over_noise_plus_offset_spectrum[row],
            color=colour,
            linewidth=1.0,
            label=name,
        )
    panel.axhline(MIN_SIGNAL_TO_NOISE_RATIO, color=FALL_COLOUR, linewidth=0.8, linestyle=DASHED_LINE_STYLE)
    _set_logarithmic_axes(panel)
    panel.legend(fontsize=7, loc="best")


def rotd_pseudo_acceleration_spectra(record: Record) -> FloatArray:
    """Return RotD00, RotD50, RotD100 of pseudo-acceleration at `RESPONSE_SPECTRUM_PERIODS_S`, m/s², shape (3, n)."""
    return rotd_percentile_measures(
        Motion.of(record), RESPONSE_SPECTRUM_PERIODS_S, percentiles_over_azimuths=ROTD_PERCENTILES
    )["psa"]


def _draw_rotd_spectra(panel: "Axes", rotd00_rotd50_rotd100_m_s2: FloatArray) -> None:
    """Draw RotD00, RotD50 and RotD100 of the pseudo-acceleration (m/s²), given in this order, by period."""
    label_axes(panel, "period, s", "pseudo-acceleration, Gal")
    if not rotd00_rotd50_rotd100_m_s2.any():
        write_note_in_empty_panel(panel, "no horizontal motion")
        return
    for percentile, spectrum, colour in zip(ROTD_PERCENTILES, rotd00_rotd50_rotd100_m_s2, SERIES_COLOURS, strict=False):
        panel.plot(
            RESPONSE_SPECTRUM_PERIODS_S, spectrum / GAL, color=colour, linewidth=0.9, label=f"RotD{percentile:02.0f}"
        )
    _set_logarithmic_axes(panel)
    # RotD00 of a motion along one azimuth is 0.
    panel.set_ylim(bottom=1e-4 * float(rotd00_rotd50_rotd100_m_s2[-1].max()) / GAL)
    panel.legend(fontsize=7, loc="best")


def _draw_removed_acceleration(
    panel: "Axes", unprocessed_record: Record, processed_record: Record, component_names: list[str]
) -> None:
    """Draw what processing removed: the acceleration before processing minus that after it."""
    label_axes(panel, "time, s", "removed, Gal")
    if unprocessed_record is processed_record:
        write_note_in_empty_panel(panel, "nothing")
        return
    time, later = (
        _sample_times(unprocessed_record),
        _sample_times(processed_record, start_time_relative_to_unprocessed_record(processed_record)),
    )
    inside = (time >= later[0] - 1e-9) & (time <= later[-1] + 1e-9)
    for name, colour in zip(component_names, SERIES_COLOURS, strict=False):
        before = getattr(unprocessed_record, name)
        away = before[inside] - np.interp(time[inside], later, getattr(processed_record, name))
        away[np.abs(away) < 1e-9 * np.abs(before).max()] = 0.0  # rounding of the interpolation
        panel.plot(*min_max_envelope(time[inside], away / GAL), color=colour, linewidth=0.8, label=name)
    panel.legend(fontsize=7, loc="best")
