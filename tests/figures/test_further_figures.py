"""Further figures: reproducible files, no text cut off at three sizes, closed curves, correct directions."""

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.text import Text

from overturning.dem.trajectory import trajectory
from overturning.figures.alignment import (
    fall_alignment_by_b_over_h_figure,
    fault_normal_alignment_figure_from_fall_axes,
)
from overturning.figures.answer import PlottedEstimate, fault_normal_alignment_by_earthquake_figure
from overturning.figures.boundary import overturning_boundary_figure
from overturning.figures.film_of_trajectory import outcome_sentence
from overturning.figures.ground import (
    fourier_and_response_spectra_figure,
    hodograph_figure,
    pga_and_pgv_by_azimuth_figure,
)
from overturning.figures.intensity_plane import (
    CRITERION_LINE_STYLES,
    motion_pga_pgv_ratio_and_block_fall_probability,
    outcomes_by_pga_and_pgv_over_pga_figure,
)
from overturning.figures.observed_rose import ObservedFallRoseCounts, observed_fall_roses_figure
from overturning.figures.polar_map import fall_map_by_azimuth_figure
from overturning.figures.response import rotation_slip_and_uplift_figure
from overturning.figures.rose import fall_roses_by_earthquake_figure, fall_roses_by_group_figure
from overturning.figures.scene import draw_scenes_side_by_side
from overturning.figures.site_map import (
    EarthquakeMapContent,
    StationOnMap,
    draw_station_and_fall_axis_maps_of_earthquakes,
)
from overturning.figures.style import FALL_COLOUR, PAGE_WIDTH_INCHES, use_package_matplotlib_settings
from overturning.figures.survey import OCTANT_WIDTH_RAD, SurveyFigureData, survey_falls_figure
from overturning.figures.ticks import limit_ticks_to_axis_range
from overturning.figures.write import remove_layout_engine_and_check_if_text_cut_or_overlaps, save_figure_files
from overturning.model.scene import load_scene
from overturning.model.status import CaseStatus
from overturning.motion.motion import Motion
from overturning.statistics.bootstrap import MeanOverEarthquakes
from overturning.statistics.boundary import overturning_boundary_b_over_h_by_azimuth
from overturning.statistics.earthquakes import fall_axes_from_fault_normal_by_earthquake, summarise_fall_axes
from overturning.statistics.logistic import PREDICTOR_NAMES, LogisticFit, fit_logistic_overturning_model

AZIMUTHS_DEG = np.arange(0, 360, 15)


def cube_of_falls_around_azimuth_40() -> xr.Dataset:
    """Return a cube of five records: falls within 68° (B/H 0.2, no ensemble) to 41° (B/H 0.4) of the 40° axis."""
    slender = np.array([0.2, 0.3, 0.4])
    offset = (AZIMUTHS_DEG - 40 + 180) % 360 - 180
    sign = np.where(np.abs(offset) < 90, 1, -1)
    falls = np.abs(np.cos(np.radians(offset)))[:, None] > slender[None, :] * 1.9
    one = (sign[:, None] * falls).astype(np.float32)
    flags = np.broadcast_to(one[None, :, None, :, None], (5, AZIMUTHS_DEG.size, 2, 3, 2)).copy()
    towards = np.where(flags > 0, 0.9, 0.05).astype(np.float32)
    towards[:, :, :, 0] = np.nan
    dims = ("record", "azimuth", "height", "b_over_h", "friction")
    return xr.Dataset(
        {
            "overturned": (dims, flags),
            "probability_towards": (dims, towards),
            "probability_away": (dims, np.roll(towards, 12, axis=1)),
            "scramble_difference_towards": (dims, np.where(np.isnan(towards), np.nan, 0.1)),
            "scramble_difference_away": (dims, np.where(np.isnan(towards), np.nan, 0.0)),
        },
        coords={
            "azimuth": AZIMUTHS_DEG,
            "height": [0.6, 1.2],
            "b_over_h": slender,
            "friction": [0.5, 1.0],
            "event": ("record", [f"E {i}" for i in range(5)]),
            "fault_normal": ("record", [30.0, 40.0, 60.0, 45.0, 20.0]),
            "pulse": ("record", np.ones(5)),
        },
    )


def motion_with_one_pulse() -> Motion:
    """Return a motion of 6 s: a sine cycle of 7 m/s² to the north, and half of it to the east 0.15 s later."""
    time = np.arange(0, 6, 0.01)
    pulse = np.where((time > 2) & (time < 3), 7.0 * np.sin(2 * np.pi * (time - 2)), 0.02 * np.sin(40 * time))
    return Motion(pulse, 0.5 * np.roll(pulse, 15), sampling_interval=0.01)


def pga_and_pgv_of_five_records() -> xr.Dataset:
    """Return peak acceleration and velocity by azimuth of five records, largest along 40°."""
    pga = 3 + 2 * np.cos(np.radians(AZIMUTHS_DEG - 40)) ** 2 + np.arange(5)[:, None]
    coordinates = {"azimuth": AZIMUTHS_DEG}
    return xr.Dataset(
        {"pga": (("record", "azimuth"), pga), "pgv": (("record", "azimuth"), 0.1 * pga**1.2)}, coordinates
    )


def draw_hodograph() -> Figure:
    return hodograph_figure(motion_with_one_pulse(), 60.0, "A long station name with $ and _, an earthquake")


def draw_fall_alignment_by_earthquake() -> Figure:
    found = fall_axes_from_fault_normal_by_earthquake(cube_of_falls_around_azimuth_40())
    return fault_normal_alignment_figure_from_fall_axes(
        {"all records": found}, {"all records": summarise_fall_axes(found)}
    )


def draw_station_map() -> Figure:
    known = StationOnMap("ttrh02", 35.23, 133.39, fault_strike_deg=150.0, mean_fall_axis_deg=60.0)
    trace = (((35.3, 133.3), (35.2, 133.4)),)
    return draw_station_and_fall_axis_maps_of_earthquakes(
        [EarthquakeMapContent("Western $Tottori", [known, StationOnMap("S$1", 35.3, 133.2)], (35.27, 133.35), trace)]
    )


def draw_rotation_slip_and_uplift() -> Figure:
    return rotation_slip_and_uplift_figure(trajectories_along_two_azimuths(), "A block")


def test_response_figure_of_a_block_at_rest_is_not_scaled_to_rounding_errors() -> None:
    """Regression: the vertical axis was scaled to a rotation of 1e-17°, a rounding error."""
    weak = Motion(0.1 * motion_with_one_pulse().north, 0 * motion_with_one_pulse().north, sampling_interval=0.01)
    figure = rotation_slip_and_uplift_figure([trajectory(weak, azimuth_deg=0, height=0.6, b_over_h=0.5)], "A block")
    assert [axes.get_ylim() for axes in figure.axes[1:]] == 3 * [(-1.0, 1.0)]
    moves = rotation_slip_and_uplift_figure(trajectories_along_two_azimuths()[:1], "A block")
    assert moves.axes[1].get_ylim()[1] > 10.0


def test_missing_outcome_is_not_labelled_as_standing() -> None:
    one = trajectories_along_two_azimuths()[0].copy()
    one["status"], one["overturned"] = 0 * one["status"] + int(CaseStatus.UNDECIDED), np.nan * one["overturned"]
    told = [
        rotation_slip_and_uplift_figure([path], "A block").axes[0].get_title().partition(": ")[2]
        for path in (one, *trajectories_along_two_azimuths())
    ]
    assert told == [
        "no outcome",
        *(outcome_sentence(path).split()[0].rstrip(";") for path in trajectories_along_two_azimuths()),
    ]


@cache
def trajectories_along_two_azimuths() -> list[xr.Dataset]:
    """Compute the trajectories of a block along 0° and 120° once for all tests."""
    block = {"height": 0.6, "b_over_h": 0.3, "friction": 1.0}
    return [trajectory(motion_with_one_pulse(), azimuth_deg=a, **block) for a in (0, 120)]


OBSERVED_FALLS_BY_OCTANT = np.array([0.0, 3, 1, 0, 0, 1, 0, 0])
COMPUTED_FALLS_BY_OCTANT = np.array([0.5, 1.5, 2, 0.5, 0.1, 0.2, 0.1, 0.1])


OBSERVED_ROSE = ObservedFallRoseCounts(
    "", np.array([0.0, 1, 1, 2, 5, 9.5, 7, 2, 0, 0, 0, 1, 2, 4, 1, 0]), 135.0, 20.0, 130.0, 9.0
)


def draw_observed_and_computed_survey_falls(count: int = 1) -> Figure:
    """Draw observed and computed falls of `count` surveys with equal data."""
    share, computed = PlottedEstimate(0.6, 0.36, 0.81), PlottedEstimate(0.35, 0.2, 0.5)
    one = SurveyFigureData(
        "survey.csv, S$1", OBSERVED_FALLS_BY_OCTANT, COMPUTED_FALLS_BY_OCTANT, 41.0, 250.0, share, computed
    )
    return survey_falls_figure([one] * count)


@cache
def logistic_overturning_fit():  # type: ignore[no-untyped-def]
    """Fit the logistic model of overturning to the cube once for all tests."""
    return fit_logistic_overturning_model(cube_of_falls_around_azimuth_40(), pga_and_pgv_of_five_records())


FUNCTIONS_MAKING_FIGURES_BY_NAME: dict[str, Callable[[], Figure]] = {
    "falls": lambda: fall_map_by_azimuth_figure(
        cube_of_falls_around_azimuth_40()[["overturned"]].isel(record=0), "A <script>"
    ),
    "rose": lambda: fall_roses_by_group_figure(cube_of_falls_around_azimuth_40()),
    "intensity": lambda: pga_and_pgv_by_azimuth_figure(pga_and_pgv_of_five_records().isel(record=0), 30.0, "A"),
    "probability": lambda: fall_map_by_azimuth_figure(
        cube_of_falls_around_azimuth_40().isel(record=0), "Station, earthquake"
    ),
    "boundary": lambda: overturning_boundary_figure(
        overturning_boundary_b_over_h_by_azimuth(cube_of_falls_around_azimuth_40().isel(record=0)),
        0.4,
        30.0,
        "Station, earthquake",
    ),
    "plane": lambda: outcomes_by_pga_and_pgv_over_pga_figure(
        cube_of_falls_around_azimuth_40(), pga_and_pgv_of_five_records(), logistic_overturning_fit(), 1.0
    ),
    "hodograph": draw_hodograph,
    "axes": draw_fall_alignment_by_earthquake,
    "map": draw_station_map,
    "response": draw_rotation_slip_and_uplift,
    "spectra": lambda: fourier_and_response_spectra_figure(motion_with_one_pulse(), [0.0, 60.0], "StationOnMap"),
    "survey": draw_observed_and_computed_survey_falls,
    "surveys": lambda: draw_observed_and_computed_survey_falls(5),
    "observed rose": lambda: observed_fall_roses_figure([OBSERVED_ROSE]),
    "observed roses": lambda: observed_fall_roses_figure(
        [
            replace(OBSERVED_ROSE, name="all sites"),
            *[replace(OBSERVED_ROSE, name="survey, S$1", mean_direction_deg=None)] * 3,
        ]
    ),
}


@cache
def cached_figure_at_size_factor(name: str, factor: float) -> Figure:
    """Return a figure at `factor` times its size, laid out once for all tests, which must not change it."""
    with use_package_matplotlib_settings():
        figure = FUNCTIONS_MAKING_FIGURES_BY_NAME[name]()
        figure.set_size_inches(*(factor * figure.get_size_inches()))
        limit_ticks_to_axis_range(figure)
        figure.get_layout_engine().execute(figure)
    return figure


@pytest.mark.long
@pytest.mark.parametrize("name", FUNCTIONS_MAKING_FIGURES_BY_NAME)
def test_figure_files_are_reproducible(name: str, tmp_path: Path) -> None:
    """Each figure is written twice as SVG, and one figure in each format."""
    files = [f"{name}.svg", *([f"{name}.png", f"{name}.pdf"] if name == "boundary" else [])]
    for folder in ("one", "two"):
        with use_package_matplotlib_settings():
            save_figure_files(FUNCTIONS_MAKING_FIGURES_BY_NAME[name](), *(tmp_path / folder / file for file in files))
    for file in files:
        assert (tmp_path / "one" / file).read_bytes() == (tmp_path / "two" / file).read_bytes(), file


@pytest.mark.parametrize("factor", [0.85, *(pytest.param(factor, marks=pytest.mark.long) for factor in (1.0, 1.6))])
@pytest.mark.parametrize("name", FUNCTIONS_MAKING_FIGURES_BY_NAME)
def test_no_figure_text_is_cut_off(name: str, factor: float) -> None:
    figure = cached_figure_at_size_factor(name, factor)
    with use_package_matplotlib_settings():
        box = figure.get_tightbbox()
    width, height = figure.get_size_inches()
    margin = 0.02
    assert box.x0 >= -margin
    assert box.y0 >= -margin
    assert box.x1 <= width + margin
    assert box.y1 <= height + margin


def test_overturning_boundary_of_an_asymmetric_scene_shows_only_simulated_azimuths() -> None:
    """At 30° the block falls at the smallest and the largest of three B/H; azimuths beyond 90° are not simulated."""
    flags = np.zeros((4, 1, 3, 1))
    flags[:, :, 0], flags[1, 0, 2, 0] = 1, -1
    azimuth = ("azimuth", [0, 30, 60, 90], {"period": 360.0})
    cases = {"azimuth": azimuth, "height": [1.0], "b_over_h": [0.2, 0.3, 0.4], "friction": [1.0]}
    found = overturning_boundary_b_over_h_by_azimuth(xr.Dataset({"overturned": (tuple(cases), flags)}, cases))
    with use_package_matplotlib_settings():
        figure = overturning_boundary_figure(found, 0.4, np.nan, "A")
        (beyond,) = [line for line in figure.axes[0].lines if line.get_marker() == "^"]
        assert np.degrees(beyond.get_xdata()) == pytest.approx([30])
        assert "falls at the largest B/H of known outcome" in [
            text.get_text() for text in figure.legends[0].get_texts()
        ]
        plt.close(figure)


def test_title_explains_the_interval_band_of_an_overturning_boundary_if_drawn() -> None:
    found = overturning_boundary_b_over_h_by_azimuth(cube_of_falls_around_azimuth_40().isel(record=0))
    wide = found.assign(boundary_high=found["boundary"] + 0.05, boundary_low=found["boundary"] - 0.05)
    alone = found.assign(boundary_high=found["boundary"], boundary_low=found["boundary"])
    with use_package_matplotlib_settings():
        for one, named in ((wide, True), (alone, False)):
            figure = overturning_boundary_figure(one, 0.4, 30.0, "A")
            assert ("band: between the two halves of the ensemble" in figure.get_suptitle()) == named
            plt.close(figure)


def test_overturning_boundary_curves_close_around_the_circle() -> None:
    with use_package_matplotlib_settings():
        figure = overturning_boundary_figure(
            overturning_boundary_b_over_h_by_azimuth(cube_of_falls_around_azimuth_40().isel(record=0)), 0.4, 30.0, "A"
        )
        lines = [line for line in figure.axes[0].get_lines() if line.get_label().startswith("µ")]
        assert len(lines) == 2
        for line in lines:
            x, y = line.get_data()
            assert x[-1] - x[0] == pytest.approx(2 * np.pi)
            assert y[-1] == pytest.approx(y[0], nan_ok=True)
        plt.close(figure)


def test_logistic_fit_without_intervals_is_drawn_as_half_probability_line() -> None:
    """With few earthquakes a fit has no intervals, but the fitted probability along the line is still ½."""
    number = np.zeros(4)
    fit = LogisticFit(
        ("intercept", *PREDICTOR_NAMES),
        np.array([1.0, 2.0, 1.5, 0.5, -0.3]),
        *[number] * 3,
        9,
        3,
        *[number] * 2,
        "no interval",
    )
    with use_package_matplotlib_settings():
        figure = outcomes_by_pga_and_pgv_over_pga_figure(
            cube_of_falls_around_azimuth_40(), pga_and_pgv_of_five_records(), fit, 1.0
        )
        (line,) = [line for line in figure.axes[0].lines if str(line.get_label()).startswith("fit")]
        assert line.get_label() == "fit of all µ together: probability ½", "its points are of one"
        plt.close(figure)
        alone = outcomes_by_pga_and_pgv_over_pga_figure(
            cube_of_falls_around_azimuth_40().isel(friction=[0]),
            pga_and_pgv_of_five_records(),
            fit,
            float(cube_of_falls_around_azimuth_40()["friction"][0]),
        )
        assert "fit: probability ½" in [line.get_label() for line in alone.axes[0].lines]
        plt.close(alone)
    (shape, height), (pga, ratio) = (0.2, 0.6), line.get_data()
    over_west = np.log(pga / 100 / (9.80665 * shape))
    rows = np.stack(np.broadcast_arrays(over_west, np.log(ratio), np.log(shape), np.log(height)), axis=1)
    np.testing.assert_allclose(fit.fall_probability(rows), 0.5, rtol=1e-9)


def test_points_of_pga_and_fall_probability_are_one_per_record_and_plane() -> None:
    pga, ratio, falls = motion_pga_pgv_ratio_and_block_fall_probability(
        cube_of_falls_around_azimuth_40(), pga_and_pgv_of_five_records(), 0.6, 0.3, 1.0
    )
    assert pga.size == 5 * 12
    assert ratio == pytest.approx(0.1 * pga**0.2)
    assert 0 < falls.mean() < 1


def test_survey_figure_shows_observed_and_computed_falls_on_one_scale() -> None:
    """Areas of sectors and outline are proportional to falls, north is up, and shares and means are at their values."""
    with use_package_matplotlib_settings():
        figure = draw_observed_and_computed_survey_falls()
        rose, shares = figure.axes
        bars = [(bar.get_x() + bar.get_width() / 2, bar.get_height()) for bar in rose.patches]
        outline, *means = rose.lines
        azimuth, radius = outline.get_data()
        lines = {tuple(np.round(line.get_xdata(), 6)) for line in shares.lines}
        words = [text.get_text() for text in shares.texts]
        numbers = [text.get_text() for text in rose.texts]
        assert (rose.get_theta_direction(), rose.get_theta_offset()) == (-1, pytest.approx(np.pi / 2))
        plt.close(figure)
    assert np.array(bars) == pytest.approx(
        np.stack([np.arange(8) * OCTANT_WIDTH_RAD, np.sqrt(OBSERVED_FALLS_BY_OCTANT)], axis=1)
    )
    middle = [radius[np.argmin(np.abs(azimuth - place * OCTANT_WIDTH_RAD))] ** 2 for place in range(8)]
    assert middle == pytest.approx(COMPUTED_FALLS_BY_OCTANT)
    assert azimuth[-1] - azimuth[0] == pytest.approx(2 * np.pi)
    marks = {line.get_markerfacecolor(): np.degrees(line.get_xdata()[0]) for line in means}
    assert marks == {FALL_COLOUR: pytest.approx(41.0), "white": pytest.approx(250.0)}
    assert lines >= {(60.0,), (36.0, 81.0), (35.0,), (20.0, 50.0)}
    assert words == ["60 (36 to 81)", "35 (20 to 50)"]
    assert numbers == ["3", "1", "1"]


def test_survey_figure_has_no_mark_of_an_unknown_direction_or_share() -> None:
    nothing, unknown = np.zeros(8), PlottedEstimate(None)
    with use_package_matplotlib_settings():
        figure = survey_falls_figure(
            [SurveyFigureData("a", nothing, nothing, None, None, unknown, PlottedEstimate(0.4))]
        )
        rose, shares = figure.axes
        assert len(rose.lines) == 1
        assert [text.get_text() for text in rose.texts] == ["no fall in a\nknown direction"]
        assert [text.get_text() for text in shares.texts] == ["not known", "40"]
        assert len(figure.legends[0].get_texts()) == 2
        plt.close(figure)


@pytest.mark.parametrize("name", ["spectra", "hodograph", "response"])
def test_figure_text_is_legible_at_page_width(name: str) -> None:
    factor = 0.85  # that of another test: the size of a letter does not depend on that of its figure
    figure = cached_figure_at_size_factor(name, factor)
    shrunk = min(1.0, PAGE_WIDTH_INCHES / (figure.get_figwidth() / factor))
    sizes = [text.get_fontsize() for text in figure.findobj(Text) if text.get_text() and text.get_visible()]
    assert min(sizes) * shrunk >= 7.8


def draw_without_layout(figure: Figure) -> Figure:
    """Draw a figure without its layout, to save time: only its curves and notes are examined."""
    figure.set_layout_engine("none")
    limit_ticks_to_axis_range(figure)
    figure.draw_without_rendering()
    return figure


@pytest.mark.parametrize(("azimuths", "drawn"), [([60.0, 150.0], [True, False]), ([150.0, 330.0], [False, False])])
def test_spectra_have_no_curve_along_an_azimuth_without_motion(azimuths: list[float], drawn: list[bool]) -> None:
    """Across a linear motion there are rounding errors, twelve decades lower, or nothing: neither is drawn."""
    linear = Motion.sine(3.0, 0.8, azimuth_deg=60.0)
    with use_package_matplotlib_settings():
        figure = draw_without_layout(fourier_and_response_spectra_figure(linear, azimuths, "Pulse"))
    for axes in figure.axes:
        assert [line.get_xdata().size > 0 for line in axes.lines] == drawn
        assert [text.get_text() for text in axes.texts] == ([] if any(drawn) else ["no motion along this azimuth"])
        assert not any(drawn) or np.ptp(np.log10(axes.get_ylim())) < 8


@pytest.mark.parametrize("count", range(2, 14))
def test_fourier_spectra_of_few_samples_do_not_exceed_the_nyquist_frequency(count: int) -> None:
    few = Motion(np.arange(count) + 1.0, np.zeros(count), sampling_interval=0.01)
    with use_package_matplotlib_settings():
        figure = draw_without_layout(fourier_and_response_spectra_figure(few, [0.0], "Few"))
    fourier, response = figure.axes
    frequency = fourier.lines[0].get_xdata()
    assert frequency.max(initial=0.0) <= 50.0
    assert [text.get_text() for text in fourier.texts] == ([] if frequency.size else ["too short for a spectrum"])
    assert response.lines[0].get_xdata().size == 60


def test_axes_of_the_hodograph_are_labelled_with_units() -> None:
    with use_package_matplotlib_settings():
        figure = draw_hodograph()
        names = [(axes.get_xlabel(), axes.get_ylabel()) for axes in figure.axes]
        plt.close(figure)
    assert names == [(f"east, {unit}", f"north, {unit}") for unit in ("Gal", "cm/s", "cm")]


def test_response_figure_names_each_element_and_ends_with_the_trajectory() -> None:
    scene = load_scene("three-tier", Path(__file__).parents[2])
    path = trajectory(motion_with_one_pulse(), scene, azimuth_deg=0, height=0.636, b_over_h=0.38, friction=1.0)
    with use_package_matplotlib_settings():
        figure = rotation_slip_and_uplift_figure(
            [path], "A long title of a record, its earthquake and everything else there is to say of it"
        )
        figure.canvas.draw()
        names = [text.get_text() for text in figure.legends[0].get_texts()]
        box, last = figure._suptitle.get_window_extent(), figure.axes[0].get_xlim()[1]
        assert box.x0 >= 0
        assert box.x1 <= figure.bbox.width
        plt.close(figure)
    assert names == ["lower-base", "upper-base", "shaft"]
    assert last <= float(path["time"][-1]) + 1e-9


def test_response_figure_shows_slip_of_an_upper_stone_over_the_ground() -> None:
    """Only the stones below slide on the ground; the upper stone hardly slips on these, but moves with them."""
    scene = load_scene("three-tier", Path(__file__).parents[2])
    path = trajectory(motion_with_one_pulse(), scene, azimuth_deg=0, height=0.636, b_over_h=0.38, friction=0.2)
    slips = rotation_slip_and_uplift_figure([path], "A stack").axes[2]
    (drawn,) = (np.abs(line.get_ydata()).max() for line in slips.lines if line.get_label() == "shaft")
    assert drawn > 10 * 100 * float(path["peak_slip"].sel(element="shaft"))
    assert slips.get_ylabel() == "slip over ground, cm"


def test_smaller_pdf_has_the_given_width_and_keeps_letters_as_text(tmp_path: Path) -> None:
    figure = Figure(figsize=(4, 3))
    figure.add_axes((0.1, 0.1, 0.8, 0.8)).set_title("µ, φ")
    with use_package_matplotlib_settings():
        save_figure_files(figure, tmp_path / "small.pdf", width_inches=2.0)
    page = (tmp_path / "small.pdf").read_bytes()
    assert re.search(rb"MediaBox ?\[ ?0 0 144 108\]", page), "2 by 1.5 inches of 72 points"
    assert b"DejaVuSans" in page, "letters are text in Matplotlib's font, no outlines"


def test_a_long_title_of_a_scene_is_not_cut_off(tmp_path: Path) -> None:
    titled = load_scene("three-tier").model_copy(update={"title": "Two stacked stones beside a neighbour"})
    with use_package_matplotlib_settings():
        figure = draw_scenes_side_by_side([titled])
        save_figure_files(figure, tmp_path / "scene.svg")
    assert not remove_layout_engine_and_check_if_text_cut_or_overlaps(figure)


LONG_NAME = "The Great Earthquake of the Northern Coastal Province and Its Many Aftershocks 1999"
LONG_JAPANESE_NAME = (
    "輪島市門前町走出総合支所強震観測点地表面加速度計観測小屋、令和六年能登半島地震本震および余震群の記録"
)


def draw_overturning_boundary_with_title(name: str) -> Figure:
    found = overturning_boundary_b_over_h_by_azimuth(
        cube_of_falls_around_azimuth_40().isel(record=0, height=[0], friction=[0])
    )
    return overturning_boundary_figure(found.assign(falls_beyond=found["falls_beyond"] * 0 + 1), 0.4, 30.0, name)


def draw_fall_alignments_with_earthquake_name(name: str) -> Figure:
    values = {f"{name} {number}": 0.5 - 0.2 * number for number in range(3)}
    return fault_normal_alignment_by_earthquake_figure(
        {"all records": values}, {"all records": PlottedEstimate(0.3, 0.1, 0.5, 3)}
    )


@pytest.mark.parametrize("name", ["A", LONG_NAME, LONG_JAPANESE_NAME], ids=["short", "long", "Japanese"])
@pytest.mark.parametrize(
    "draw",
    [
        pytest.param(draw_overturning_boundary_with_title, id="boundary with three marks in the legend"),
        pytest.param(lambda name: hodograph_figure(motion_with_one_pulse(), 30.0, name), id="hodograph"),
        pytest.param(draw_fall_alignments_with_earthquake_name, id="alignments by earthquake"),
        pytest.param(
            lambda name: fall_roses_by_earthquake_figure(
                cube_of_falls_around_azimuth_40().assign_coords(
                    event=("record", [f"{name} {number}" for number in (0, 0, 1, 1, 2)])
                )
            ),
            id="roses by earthquake",
        ),
    ],
)
def test_long_and_japanese_names_in_titles_are_not_cut_off(
    name: str, draw: Callable[[str], Figure], tmp_path: Path, recwarn: pytest.WarningsRecorder
) -> None:
    with use_package_matplotlib_settings():
        figure = draw(name)
        save_figure_files(figure, tmp_path / "a.svg")
    assert not [one for one in recwarn if "constrained_layout" in str(one.message)]
    assert not remove_layout_engine_and_check_if_text_cut_or_overlaps(figure)


def test_legend_of_fall_alignment_by_b_over_h_has_only_known_reference_directions() -> None:
    """If the fault normal of no record is known, the legend does not have it."""
    mean, unknown = MeanOverEarthquakes(5, 0.5, 0.2, 0.8), MeanOverEarthquakes(0, np.nan, np.nan, np.nan)
    means = {("peak velocity", True): [mean, mean], ("fault normal", True): [unknown, unknown]}
    with use_package_matplotlib_settings():
        groups: Any = {"all records": SimpleNamespace(cosines_per_b_over_h_by_reference_and_axial=means)}
        figure = fall_alignment_by_b_over_h_figure(groups, np.array([0.2, 0.3]))
    assert [text.get_text() for text in figure.legends[0].get_texts()] == ["peak velocity"]


def test_lines_of_overturning_criteria_differ_in_their_dashes() -> None:
    assert len({str(dashes) for _, dashes in CRITERION_LINE_STYLES}) == len(CRITERION_LINE_STYLES)
