"""Figures for a phone: panels below each other, letters as large as on a page."""

from itertools import pairwise

import pytest

from overturning.figures.answer import PlottedEstimate, overturned_shares_and_difference_figure
from overturning.figures.polar_map import fall_map_by_azimuth_figure
from overturning.figures.site_map import (
    EarthquakeMapContent,
    StationOnMap,
    draw_station_and_fall_axis_maps_of_earthquakes,
)
from overturning.figures.style import (
    PHONE_FIGURE_WIDTH_INCHES,
    arrange_panels_for_phone,
    use_package_matplotlib_settings,
)
from tests.figures.test_explore import random_planar_cube


@pytest.mark.parametrize("narrow", [False, True])
def test_share_and_difference_panels_are_stacked_only_in_figures_for_a_phone(narrow: bool) -> None:
    shares = {"here": [PlottedEstimate(0.4, 0.2, 0.6)], "there": [PlottedEstimate(0.1, 0.0, 0.2)]}
    arguments = ["all cases"], shares, [PlottedEstimate(0.3, 0.2, 0.4)]
    with use_package_matplotlib_settings():
        if narrow:
            with arrange_panels_for_phone():
                figure = overturned_shares_and_difference_figure(*arguments)
        else:
            figure = overturned_shares_and_difference_figure(*arguments)
        figure.draw_without_rendering()
    left, right = (axes.get_position() for axes in figure.axes)
    assert bool(right.y1 < left.y0) is narrow
    assert bool(right.x0 > left.x1) is not narrow
    # 366 CSS pixels of a phone of 390; the smallest letter has 7.5 pt.
    assert bool(7.5 * 366 / (72 * figure.get_figwidth()) >= 11) is narrow
    assert bool(figure.get_figwidth() == PHONE_FIGURE_WIDTH_INCHES) is narrow


def test_figures_for_a_phone_have_two_station_maps_in_a_row() -> None:
    earthquakes = [
        EarthquakeMapContent(f"Event {number}", [StationOnMap("vale", 34.2, -118.4, 30.0, 10.0)], (34.3, -118.5))
        for number in range(5)
    ]
    with use_package_matplotlib_settings():
        page = draw_station_and_fall_axis_maps_of_earthquakes(earthquakes)
        with arrange_panels_for_phone():
            phone = draw_station_and_fall_axis_maps_of_earthquakes(earthquakes)
        columns = [figure.axes[0].get_gridspec().ncols for figure in (page, phone)]
        for figure in (page, phone):
            figure.draw_without_rendering()
    assert columns == [4, 2]
    assert phone.get_figwidth() == PHONE_FIGURE_WIDTH_INCHES
    widths = [figure.axes[0].get_position().width * figure.get_figwidth() for figure in (page, phone)]
    assert widths[1] == pytest.approx(widths[0], rel=0.1)
    assert [one.get_title() for one in phone.axes if one.get_visible()] == [one.name for one in earthquakes]


def test_polar_maps_on_a_phone_fill_its_width_with_gaps_of_less_than_half_a_map() -> None:
    """Each polar map has the width of the phone; space for colour bar and legend is left once, not below each map."""
    cube = random_planar_cube(records=3, step=90, heights=1, frictions=1, ratios=2).drop_vars("station")
    with use_package_matplotlib_settings(), arrange_panels_for_phone():
        figure = fall_map_by_azimuth_figure([cube.isel(record=number) for number in range(3)], "Three maps")
        figure.get_layout_engine().execute(figure)
    boxes = [axes.get_window_extent() for axes in figure.axes if axes.name == "polar"]
    assert all(box.width > 0.75 * figure.bbox.width for box in boxes)
    gaps = [(upper.y0 - lower.y1) / upper.height for upper, lower in pairwise(boxes)]
    assert all(0.2 < gap < 0.5 for gap in gaps)


@pytest.mark.parametrize("count", [1, 2, 3, 5])
def test_titles_of_station_maps_on_a_phone_are_not_cut_off_or_overlapped(count: int) -> None:
    """The legend has one line for each kind of mark; its height must not push the maps into each other."""
    trace = (((34.2, -118.5), (34.3, -118.3)),)
    stations = [StationOnMap("vale", 34.2, -118.4, 30.0, 10.0)]
    earthquakes = [EarthquakeMapContent(f"Event {number}", stations, (34.3, -118.5), trace) for number in range(count)]
    with use_package_matplotlib_settings(), arrange_panels_for_phone():
        figure = draw_station_and_fall_axis_maps_of_earthquakes(earthquakes)
        figure.draw_without_rendering()
    (legend,) = figure.legends
    assert len(legend.get_texts()) == 5
    panels = [axes for axes in figure.axes if axes.get_visible()]
    titles = [axes.title.get_window_extent() for axes in panels]
    assert max(box.y1 for box in titles) <= figure.bbox.y1
    scales = [text.get_window_extent() for axes in panels for text in axes.texts if text.get_text().endswith("km")]
    assert len(scales) == count
    assert not any(title.overlaps(scale) for title in titles for scale in scales)
    assert legend.get_window_extent().y1 <= min(box.y0 for box in scales)
