"""Compasses: names and rings at their places, panels of one size, and no text that is cut off or overlaps."""

from collections.abc import Callable
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.text import Text

from overturning.figures.boundary import overturning_boundary_figure
from overturning.figures.compass import (
    CompassAxes,
    b_over_h_ring_labels,
    create_compass_grid,
    labels_of_rings_at_round_radii,
)
from overturning.figures.ground import pga_and_pgv_by_azimuth_figure
from overturning.figures.polar_map import fall_map_by_azimuth_figure
from overturning.figures.style import (
    add_title_and_legend,
    arrange_panels_for_phone,
    mark_fault_normal_on_polar_rim,
    use_package_matplotlib_settings,
)
from overturning.figures.write import remove_layout_engine_and_check_if_text_cut_or_overlaps, save_figure_files
from overturning.statistics.boundary import overturning_boundary_b_over_h_by_azimuth
from overturning.translation.texts import use_translation_language
from tests.figures.test_further_figures import cube_of_falls_around_azimuth_40


def cube_of_one_record(heights: int = 2, frictions: int = 2) -> xr.Dataset:
    """Return a cube of one record with a fault normal of 40°."""
    return cube_of_falls_around_azimuth_40().isel(record=0, height=slice(heights), friction=slice(frictions))


def artificial_pga_and_pgv_by_azimuth(cube: xr.Dataset) -> xr.Dataset:
    """Return peak acceleration and velocity for the azimuths of a cube, largest along north."""
    angle = np.radians(cube["azimuth"].to_numpy().astype(float))
    return xr.Dataset({name: ("azimuth", 3.0 + np.cos(2 * angle)) for name in ("pga", "pgv")}, cube[["azimuth"]].coords)


def figure_of_one_fall_map_by_azimuth() -> Figure:
    return fall_map_by_azimuth_figure(cube_of_one_record(1, 1), "A station\nof an earthquake")


def figure_of_four_azimuth_maps() -> Figure:
    cube = cube_of_one_record()
    return fall_map_by_azimuth_figure(
        cube, "A station of an earthquake with a long name", [artificial_pga_and_pgv_by_azimuth(cube)["pgv"]]
    )


def azimuth_map_figure_of_two_records() -> Figure:
    named = [
        cube_of_one_record(1, 1).assign_coords(station=name, event="of an earthquake") for name in ("Here", "There")
    ]
    return fall_map_by_azimuth_figure(named, "Two stations")


def azimuth_map_figure_of_three_long_names() -> Figure:
    stations = ("Rinaldi Receiving Station", "TAPS Pump Sta. #10", "A station with a long name of many words")
    named = [cube_of_one_record(1, 1).assign_coords(station=name, event="Northridge 1994") for name in stations]
    return fall_map_by_azimuth_figure(named, "")


def figure_of_pga_and_pgv_by_azimuth() -> Figure:
    return pga_and_pgv_by_azimuth_figure(artificial_pga_and_pgv_by_azimuth(cube_of_one_record()), 40.0, "A station")


def figure_of_overturning_boundary() -> Figure:
    cube = cube_of_one_record()
    return overturning_boundary_figure(overturning_boundary_b_over_h_by_azimuth(cube), 0.6, 40.0, "A station")


FUNCTIONS_MAKING_COMPASS_FIGURES = (
    figure_of_one_fall_map_by_azimuth,
    figure_of_four_azimuth_maps,
    azimuth_map_figure_of_two_records,
    azimuth_map_figure_of_three_long_names,
    figure_of_pga_and_pgv_by_azimuth,
    figure_of_overturning_boundary,
)


@cache
def figure_drawn_once_for_all_tests(make: Callable[[], Figure], phone: bool) -> Figure:
    """Draw a figure with its layout once for all tests: they may draw it again, but must not change it."""
    with use_package_matplotlib_settings():
        if phone:
            with arrange_panels_for_phone():
                figure = make()
        else:
            figure = make()
        figure.draw_without_rendering()
    return figure


def visible_compasses(figure: Figure) -> list[CompassAxes]:
    return [axes for axes in figure.axes if isinstance(axes, CompassAxes) and axes.get_visible()]


def text_boxes(figure: Figure) -> dict[Text, tuple[float, float, float, float]]:
    """Return the boxes (left, low, right, high), pixels, of all texts of a figure that are drawn."""
    legend = [text for one in figure.legends for text in one.get_texts()]
    of_panels = [text for axes in visible_compasses(figure) for text in (axes.title, *axes.texts)]
    of_bars = [axes.xaxis.label for axes in figure.axes if not isinstance(axes, CompassAxes)]
    shown = [text for text in (*figure.texts, *legend, *of_panels, *of_bars) if text.get_text()]
    return {text: text.get_window_extent().extents for text in shown}


@pytest.mark.parametrize("phone", [False, True], ids=["page", "phone"])
@pytest.mark.parametrize("make", FUNCTIONS_MAKING_COMPASS_FIGURES)
def test_no_text_of_a_compass_figure_is_cut_off_or_overlaps(make: Callable[[], Figure], phone: bool) -> None:
    figure = figure_drawn_once_for_all_tests(make, phone)
    assert not remove_layout_engine_and_check_if_text_cut_or_overlaps(figure)
    whole = figure.bbox
    for text, (left, low, right, high) in text_boxes(figure).items():
        assert left >= whole.x0, text
        assert low >= whole.y0, text
        assert right <= whole.x1, text
        assert high <= whole.y1, text


@pytest.mark.parametrize("phone", [False, True], ids=["page", "phone"])
@pytest.mark.parametrize("make", FUNCTIONS_MAKING_COMPASS_FIGURES)
def test_compass_titles_stand_between_the_letter_n_and_the_row_above(make: Callable[[], Figure], phone: bool) -> None:
    figure = figure_drawn_once_for_all_tests(make, phone)
    all_boxes = text_boxes(figure)
    ceiling = min([all_boxes[text][1] for text in figure.texts if text in all_boxes], default=figure.bbox.y1)
    floor = max(legend.get_window_extent().y1 for legend in figure.legends)
    for bar in (axes for axes in figure.axes if not isinstance(axes, CompassAxes)):
        label, name = all_boxes[bar.xaxis.label], bar.get_window_extent()
        assert label[1] > floor
        assert label[3] < name.y0
        floor = name.y1
    for axes in visible_compasses(figure):
        own = {text.get_text(): all_boxes[text] for text in axes.texts}
        rim = axes.get_window_extent()
        assert own["N"][1] > rim.y1
        assert own["S"][3] < rim.y0
        assert own["S"][1] > floor
        assert own["E"][0] > rim.x1
        assert own["W"][2] < rim.x0
        above = own["N"]
        if axes.get_title():
            assert all_boxes[axes.title][1] >= above[3] - 1.0
            above = all_boxes[axes.title]
        assert above[3] < ceiling


@pytest.mark.parametrize("make", FUNCTIONS_MAKING_COMPASS_FIGURES)
def test_compasses_are_round_and_equal_and_do_not_touch(make: Callable[[], Figure]) -> None:
    figure = figure_drawn_once_for_all_tests(make, False)
    rims = [axes.get_window_extent() for axes in visible_compasses(figure)]
    for rim in rims:
        assert rim.width == pytest.approx(rim.height)
        assert rim.width == pytest.approx(rims[0].width)
        assert rim.width > 0.3 * figure.bbox.width / len({round(one.x0) for one in rims})
    for number, rim in enumerate(rims):
        assert not any(rim.overlaps(other) for other in rims[:number])
    lefts = sorted({round(rim.x0, 3) for rim in rims})
    assert np.ptp([after - before for before, after in pairwise(lefts)] or [0.0]) < 0.01, "evenly spaced"


@pytest.mark.parametrize(("kind", "language"), [("svg", "en"), ("png", "en"), ("svg", "ja")])
def test_a_map_drawn_twice_has_the_same_bytes(kind: str, language: str, tmp_path: Path) -> None:
    with use_package_matplotlib_settings(), use_translation_language(language):
        for name in ("one", "two"):
            save_figure_files(figure_of_four_azimuth_maps(), tmp_path / f"{name}.{kind}", dpi=50)
    assert (tmp_path / f"one.{kind}").read_bytes() == (tmp_path / f"two.{kind}").read_bytes()


def test_compass_directions_and_ring_labels_are_at_their_azimuths_and_radii() -> None:
    with use_package_matplotlib_settings():
        figure, ((axes,),) = create_compass_grid(1, 1, 3.0, 3.0)
        axes.draw_compass(2.0, {0.5: "half", 1.5: "one and a half"}, 67.5, has_spokes=True)
        figure.draw_without_rendering()
    centre = axes.transData.transform((0.0, 0.0))
    names = [text for text in axes.texts if text.get_text().isupper()]
    assert [text.get_text() for text in names] == ["N", "NE", "E", "SE", "S", "SW", "W", "NW"]
    for number, text in enumerate(names):
        across, up = np.mean(text.get_window_extent().get_points(), axis=0) - centre
        assert np.degrees(np.arctan2(across, up)) % 360.0 == pytest.approx(45.0 * number, abs=2.0)
        rim = axes.transData.transform((np.radians(45.0 * number), 2.0)) - centre
        assert np.hypot(across, up) > np.hypot(*rim)
    for text, radius in zip((text for text in axes.texts if not text.get_text().isupper()), (0.5, 1.5), strict=True):
        place = axes.transData.transform((np.radians(67.5), radius))
        np.testing.assert_allclose(text.get_transform().transform(text.get_position()), place)
    (path,) = [patch for patch in axes.patches if not patch.get_fill()]
    points = path.get_transform().transform(path.get_path().vertices) - centre
    largest = np.hypot(*points.T).max()
    assert largest == pytest.approx(np.hypot(*rim)), "spokes end at the rim"


def test_a_mark_at_the_rim_covers_no_compass_name() -> None:
    """A fault normal at 45° and 225° touches neither NE nor SW."""
    with use_package_matplotlib_settings():
        figure, ((axes,),) = create_compass_grid(1, 1, 3.0, 3.0)
        axes.draw_compass(1.0, {}, leaves_room_for_rim_marks=True)
        mark_fault_normal_on_polar_rim(axes, 45.0)
        figure.draw_without_rendering()
    (mark,) = axes.lines
    box = {text.get_text(): text.get_window_extent() for text in axes.texts}
    ends = axes.transData.transform(np.column_stack(mark.get_data()))
    assert np.degrees(mark.get_data()[0][[0, 3]]) == pytest.approx([45.0, 225.0])
    assert not any(box[name].contains(*end) for name in ("NE", "SW") for end in ends if np.isfinite(end).all())


def test_a_cleared_compass_is_empty() -> None:
    with use_package_matplotlib_settings():
        _, ((axes,),) = create_compass_grid(1, 1, 3.0, 3.0)
        axes.draw_compass(1.0, {0.5: "half"})
        axes.clear()
    assert [*axes.texts, *axes.patches, *axes.direction_and_ring_labels] == []
    assert (axes.get_theta_direction(), np.degrees(axes.get_theta_offset())) == (-1, 90)


def test_figure_without_room_for_compasses_gives_a_warning() -> None:
    with use_package_matplotlib_settings():
        figure, ((axes,),) = create_compass_grid(1, 1, 1.0, 0.7)
        axes.draw_compass(1.0, {})
        add_title_and_legend(figure, "two\nlines")
        with pytest.warns(UserWarning, match="no room for the compasses"):
            figure.draw_without_rendering()


def test_rings_of_a_compass_have_round_radii_inside_the_rim() -> None:
    assert labels_of_rings_at_round_radii(689.0) == {200.0: "200", 400.0: "400", 600.0: "600"}
    assert labels_of_rings_at_round_radii(1.2) == {0.3: "0.3", 0.6: "0.6", 0.9: "0.9", 1.2: "1.2"}
    assert list(labels_of_rings_at_round_radii(2.1).values()) == ["0.6", "1.2", "1.8"]
    assert b_over_h_ring_labels(0.4, 0.3) == {0.1: "0.1", 0.2: "0.2", 0.3: "0.3"}
    assert b_over_h_ring_labels(0.6, 0.3) == {0.2: "0.2", 0.4: "0.4"}
    assert b_over_h_ring_labels(0.08, 0.05) == {0.05: "0.05"}
