"""The page of a record's time histories: the same each time, with what it is to show, and light."""

import re
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from overturning.figures.history import (
    TIME_BIN_COUNT_OF_DRAWN_ENVELOPE,
    min_max_envelope,
    record_before_and_after_processing_figure,
    start_time_relative_to_unprocessed_record,
)
from overturning.figures.style import create_panel_grid, label_logarithmic_ticks, use_package_matplotlib_settings
from overturning.figures.write import save_figure_and_return_text_layout_warning, save_figure_files
from overturning.records.processing import process_record
from overturning.records.record import Record
from overturning.records.steps import Cut, Highpass, RemoveMean

SharedFolderMaker = Callable[[str, Callable[[Path], object]], Path]

SAMPLE_TIMES_OF_60_S = np.arange(0, 60, 0.01)
SAMPLE_TIMES_OF_15_S = np.arange(0, 15, 0.01)


def random_record(up: bool = True) -> Record:
    """Return a record of one minute of noise that sets in after 20 s and decays."""
    random = np.random.default_rng(8)
    shape = np.where(SAMPLE_TIMES_OF_60_S > 20, np.exp(-(SAMPLE_TIMES_OF_60_S - 20) / 8), 0.002)
    north, east, vertical = (shape * random.normal(size=SAMPLE_TIMES_OF_60_S.size) + 0.05 for _ in range(3))
    return Record("r", north, east, vertical if up else None, 0.01, station="Here", event="$Then$")


def offset_record_before_and_after_processing(up: bool = True) -> tuple[Record, Record]:
    """Return a record with an offset of −3 m/s², before and after processing."""
    before = random_record(up).with_changed_components(lambda samples: samples - 3.0)
    return before, process_record(before, [RemoveMean(), Highpass(corner_hz=0.2)])


def write_time_history_page_of_offset_record(folder: Path) -> None:
    """Write the time history page of a record with an offset as page.svg into a folder."""
    with use_package_matplotlib_settings():
        save_figure_files(
            record_before_and_after_processing_figure(*offset_record_before_and_after_processing()), folder / "page.svg"
        )


@pytest.fixture(scope="module", params=[True, False])
def vertical_flag_svg_and_figure_of_history(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> tuple[bool, str, Figure]:
    """Return if a record with an offset has vertical motion, the SVG text of its history page, and the figure."""
    path = tmp_path_factory.mktemp("history") / "page.svg"
    with use_package_matplotlib_settings():
        figure = record_before_and_after_processing_figure(*offset_record_before_and_after_processing(request.param))
        save_figure_files(figure, path)
        figure.draw_without_rendering()
    return request.param, path.read_text(encoding="utf-8"), figure


def test_time_history_page_states_the_processing_and_is_reproducible(
    vertical_flag_svg_and_figure_of_history: tuple[bool, str, Figure], make_folder_once: SharedFolderMaker
) -> None:
    up, text, _ = vertical_flag_svg_and_figure_of_history
    if up:
        again = make_folder_once("history-page", write_time_history_page_of_offset_record) / "page.svg"
        assert text == again.read_text(encoding="utf-8")
    words = re.sub(r"<[^>]+>", " ", text)
    for word in (
        "Here",
        "$Then$",
        "raw",
        "onset at",
        "high-pass 0.2 Hz",
        "0.2 Hz",
        "Husid",
        "signal-to-noise",
        "removed",
        "RotD00",
        "RotD50",
        "RotD100",
    ):
        assert word in words, word
    assert ("up" in words.split()) == up
    assert len(text) < 400_000


def test_scale_labels_of_a_large_offset_do_not_cover_the_next_panel(
    vertical_flag_svg_and_figure_of_history: tuple[bool, str, Figure],
) -> None:
    """An offset of 3 m/s² gives a displacement of 5.4 km in a minute: numbers of six digits on the right."""
    up, _, figure = vertical_flag_svg_and_figure_of_history
    right = [axes for axes in figure.axes if axes.yaxis.get_ticks_position() == "right"]
    assert len(right) == 3 * (2 + up)
    numbers = [label.get_window_extent() for axes in right for label in axes.get_yticklabels() if label.get_text()]
    names = [axes.yaxis.label.get_window_extent() for axes in figure.axes if axes.get_ylabel()]
    assert not [number for number in numbers if any(number.overlaps(name) for name in names)]
    assert max(number.x1 for number in numbers) < figure.bbox.x1


@pytest.fixture(scope="module")
def time_history_figure_of_unprocessed_record() -> Figure:
    """Return the history figure of a record that is not processed."""
    record = random_record()
    with use_package_matplotlib_settings():
        return record_before_and_after_processing_figure(record, record)


@pytest.mark.parametrize("kind", ["svg", "png"])
def test_time_history_page_in_any_file_format_gives_no_overlap_warning(
    tmp_path: Path, kind: str, time_history_figure_of_unprocessed_record: Figure
) -> None:
    """A file has another resolution than the figure on screen, so that the positions of labels in pixels differ."""
    assert (
        save_figure_and_return_text_layout_warning(
            time_history_figure_of_unprocessed_record, tmp_path / f"a.{kind}", dpi=200, width_inches=None
        )
        == ""
    )
    if kind == "svg":
        words = re.sub(r"<[^>]+>", " ", (tmp_path / "a.svg").read_text(encoding="utf-8"))
        assert "nothing done here" in words, "one line, and no removed part"
        assert "before processing" not in words


@pytest.mark.parametrize("up", [True, False])
def test_rotd_spectra_of_motion_along_one_line_match_closed_forms(up):
    """Along one line, RotD50 is RotD100 times cos 45°, RotD00 is zero, and a stiff oscillator follows the ground."""
    pulse = np.sin(2 * np.pi * SAMPLE_TIMES_OF_15_S) * (SAMPLE_TIMES_OF_15_S < 1)
    along = [pulse * np.cos(np.radians(30)), pulse * np.sin(np.radians(30)), pulse if up else None]
    one = Record("r", *along, 0.01)
    with use_package_matplotlib_settings():
        figure = record_before_and_after_processing_figure(one, one)
    (panel,) = [axes for axes in figure.axes if axes.get_xlabel() == "period, s"]
    lines = {line.get_label(): line.get_ydata() for line in panel.lines}
    assert list(lines) == ["RotD00", "RotD50", "RotD100"]
    np.testing.assert_allclose(lines["RotD50"], lines["RotD100"] / np.sqrt(2), rtol=0.01)
    assert (lines["RotD00"] < 1e-9 * lines["RotD100"]).all()
    # An oscillator that is far stiffer than the motion follows the ground: 1 m/s².
    assert lines["RotD100"][0] == pytest.approx(100, rel=0.02)


def notes_in_empty_panels(before: Record, after: Record) -> dict[str, list[str]]:
    """Return the notes on empty panels of the page of a record (before and after processing), by axis label."""
    with use_package_matplotlib_settings(), warnings.catch_warnings(action="error"):
        figure = record_before_and_after_processing_figure(before, after)
        figure.draw_without_rendering()
    notes: dict[str, list[str]] = {}
    for axes in figure.axes:
        found = [text.get_text() for text in axes.texts if text.get_fontsize() == 8.0]
        notes.setdefault(axes.get_ylabel(), []).extend(found)
    return {label: found for label, found in notes.items() if found}


@pytest.mark.parametrize("moving", ["", "up", "north"])
def test_components_without_motion_have_notes_instead_of_spectra(moving: str) -> None:
    """No curve is drawn at an invented amplitude, and no warning of an empty logarithmic axis is given."""
    wave = (
        np.sin(2 * np.pi * SAMPLE_TIMES_OF_15_S) * np.sin(np.pi * SAMPLE_TIMES_OF_15_S / SAMPLE_TIMES_OF_15_S[-1]) ** 2
    )
    components = {name: wave * (name == moving) for name in ("north", "east", "up")}
    record = Record("r", **components, sampling_interval=0.01)
    notes = notes_in_empty_panels(record, process_record(record, [Highpass(corner_hz=0.1)]))
    assert notes["Fourier amplitude, Gal·s"] == ["no motion"] * (2 if moving else 3)
    assert notes.get("Husid: Arias intensity, %") == (None if moving else ["no motion"])
    assert notes.get("pseudo-acceleration, Gal") == (None if moving == "north" else ["no horizontal motion"])


@pytest.mark.parametrize("count", [2, 3, 4])
def test_record_of_few_samples_has_no_fourier_spectrum(count: int) -> None:
    few = Record("r", *np.eye(2, count), None, 0.01, extra={"processed": True})
    assert notes_in_empty_panels(few, few)["Fourier amplitude, Gal·s"] == ["too short for a spectrum"] * 2


def test_no_removed_motion_is_drawn_for_a_record_that_was_only_cut() -> None:
    """Sample times of the record before it is cut and after differ by rounding, which must not be drawn as a motion."""
    before = random_record()
    figure = record_before_and_after_processing_figure(before, process_record(before, [Cut(start_s=5, end_s=6)]))
    (panel,) = (axes for axes in figure.axes if axes.get_ylabel() == "removed, Gal")
    assert all(not np.any(line.get_ydata()) for line in panel.lines)


def test_envelope_of_a_long_curve_keeps_peaks_and_order_of_time():
    values = np.random.default_rng(1).normal(size=50_000)
    time, drawn = min_max_envelope(np.arange(50_000.0), values)
    assert drawn.max() == values.max()
    assert drawn.min() == values.min()
    assert (np.diff(time) >= 0).all()
    assert time.size <= 2 * TIME_BIN_COUNT_OF_DRAWN_ENVELOPE


def test_the_start_shift_of_a_processed_record_includes_padding_and_cut():
    done = process_record(random_record(), [Highpass(corner_hz=0.2), Cut(start_s=20, end_s=60)])
    assert start_time_relative_to_unprocessed_record(done) == pytest.approx(-15 + 20)
    whole = process_record(random_record(), [Highpass(corner_hz=0.2)])
    np.testing.assert_array_equal(done.north, whole.north[2000:6001])


def test_labels_of_logarithmic_axes_are_numbers_or_powers_of_ten() -> None:
    """An axis from 0.001 to 1000 has plain numbers; one to 10⁷ has powers of ten, as Matplotlib writes them."""
    with use_package_matplotlib_settings():
        figure, ((axes,),) = create_panel_grid(1, 1, 3.0, 3.0)
        axes.set(xscale="log", yscale="log", xlim=(2e-3, 2e3), ylim=(2e-2, 2e7))
        for axis in (axes.xaxis, axes.yaxis):
            label_logarithmic_ticks(axis)
        figure.draw_without_rendering()
    assert {"0.01", "1", "100"} <= {text.get_text() for text in axes.get_xticklabels()}
    powers = [text.get_text() for text in axes.get_yticklabels()]
    assert powers == [rf"$\mathdefault{{10^{{{np.log10(value):.0f}}}}}$" for value in axes.get_yticks()]
