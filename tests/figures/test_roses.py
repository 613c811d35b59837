"""Roses: opposite falls are one axis, areas are shares, the mean axis stands at the rim."""

from functools import cache

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.transforms import Bbox

from overturning.figures.rose import (
    FALL_COLOUR,
    axis_interval_arcs_from_minus_90_to_90_deg,
    draw_fall_rose,
    fall_roses_by_group_figure,
)
from overturning.figures.style import INK, create_panel_grid, use_package_matplotlib_settings
from overturning.statistics.bootstrap import MeanOverEarthquakes
from overturning.statistics.circular import ROSE_SECTOR_COUNT
from overturning.statistics.earthquakes import MeanFallAxisAndAlignmentOverEarthquakes
from overturning.statistics.roses import (
    FallShareRoseAveragedOverEarthquakes,
    fall_rose,
    fall_rose_from_fault_normal_if_known,
)
from tests.figures.test_explore import random_3d_cube
from tests.figures.test_further_figures import cube_of_falls_around_azimuth_40

NAN = float("nan")


def cube_of_earthquakes_with_one_record_each(count: int) -> xr.Dataset:
    """Return a cube of `count` earthquakes, at most ten, of one record each."""
    several = xr.concat(
        [cube_of_falls_around_azimuth_40(), cube_of_falls_around_azimuth_40()], "record", data_vars="all"
    )
    return several.assign_coords(event=("record", [f"E {place}" for place in range(10)])).isel(record=slice(count))


def fall_axis_summary_of_five_earthquakes(axis: float, half_width: float) -> MeanFallAxisAndAlignmentOverEarthquakes:
    """Return a summary of five earthquakes with a mean fall axis and the half-width of its interval, degrees."""
    return MeanFallAxisAndAlignmentOverEarthquakes(5, MeanOverEarthquakes(5, NAN, NAN, NAN), axis, half_width, 5, 5)


def draw_rose_of_falls_with_mean_axis(one: xr.Dataset, axis: float = NAN, half_width: float = NAN) -> Figure:
    """Draw the rose of a cube with a mean axis and the half-width of its interval, degrees, without a layout."""
    with use_package_matplotlib_settings():
        figure = fall_roses_by_group_figure(
            one, {"all records": fall_axis_summary_of_five_earthquakes(axis, half_width)}
        )
        figure.set_layout_engine("none")  # what is drawn is examined, not where
        figure.draw_without_rendering()
    return figure


def rose_sector_areas(figure: Figure) -> dict[float, float]:
    """Return the area of each dark sector, as its radius squared, by the azimuth of its middle, degrees."""
    dark = [
        bar
        for bar in figure.axes[0].patches
        if np.allclose(bar.get_facecolor()[:3], plt.matplotlib.colors.to_rgb(FALL_COLOUR))
    ]
    return {round(float(np.degrees(bar.get_x() + bar.get_width() / 2)), 3): bar.get_height() ** 2 for bar in dark}


def test_a_rose_of_2d_falls_counts_opposite_directions_as_one_axis() -> None:
    """A sector of axes holds the sector of directions and the opposite one; all areas add to 1."""
    one = cube_of_falls_around_azimuth_40().isel(record=[0])
    found = rose_sector_areas(draw_rose_of_falls_with_mean_axis(one))
    directions = fall_rose(one, measure_from_fault_normal=True)
    for middle in range(0, 90, 15):
        both = (
            directions.mean_fall_share_by_sector[middle // 15]
            + directions.mean_fall_share_by_sector[middle // 15 + ROSE_SECTOR_COUNT // 2]
        )
        assert found[middle] == pytest.approx(both)
    assert found[90.0] == found[-90.0], "the sector across the top has a half at either end"
    assert sum(area for middle, area in found.items() if -90 < middle <= 90) == pytest.approx(1.0)


def test_rose_angles_are_measured_from_the_fault_normal_where_it_is_known() -> None:
    """Falls towards 0° to 75° are at −40° to 35° from a fault normal of 40°, in the sectors −45° to 30°."""
    with_normal, without = (
        cube_of_falls_around_azimuth_40().assign_coords(fault_normal=("record", [angle] * 5)) for angle in (40.0, NAN)
    )
    found, north = fall_rose_from_fault_normal_if_known(with_normal), fall_rose_from_fault_normal_if_known(without)
    assert (found.is_measured_from_fault_normal, north.is_measured_from_fault_normal) == (True, False)
    assert np.flatnonzero(north.mean_fall_share_by_sector).tolist() == [0, 1, 2, 3, 4, 5]
    assert np.flatnonzero(found.mean_fall_share_by_sector).tolist() == [0, 1, 2, 9, 10, 11]
    assert found.mean_fall_share_by_sector.size == north.mean_fall_share_by_sector.size == ROSE_SECTOR_COUNT // 2
    figure = draw_rose_of_falls_with_mean_axis(without)
    names = [label.get_text() for label in figure.axes[0].get_xticklabels()]
    assert names == ["W", "NW", "N", "NE", "E"]
    assert "from north" in figure.axes[0].get_title()


def test_rose_of_3d_falls_is_folded_to_axes_only_with_a_fault_normal() -> None:
    one = random_3d_cube().assign_coords(pulse=("record", [1, 1]), fault_normal=("record", [NAN, NAN]))
    assert fall_rose_from_fault_normal_if_known(one).mean_fall_share_by_sector.size == ROSE_SECTOR_COUNT
    assert fall_rose_from_fault_normal_if_known(one.assign_coords(fault_normal=("record", [30.0, NAN]))).is_axial


def test_interval_of_the_share_along_an_axis_adds_both_directions_first() -> None:
    """Each earthquake has falls towards 0° or 180°: its share along this axis is 1, that towards 0° is 1 or 0."""
    one = cube_of_earthquakes_with_one_record_each(10)
    flags = np.zeros(one["overturned"].shape)
    flags[::2, 0], flags[1::2, 12] = 1, 1  # towards 0° under records 0, 2, 4, towards 180° under the others
    flags[::2, 12], flags[1::2, 0] = -1, -1
    one = one.assign(overturned=(one["overturned"].dims, flags)).assign_coords(fault_normal=("record", [0.0] * 10))
    both = fall_rose_from_fault_normal_if_known(one)
    assert (
        both.mean_fall_share_by_sector[0],
        both.share_interval_low_by_sector[0],
        both.share_interval_high_by_sector[0],
    ) == (1.0, pytest.approx(0.05 ** (1 / 10)), 1.0)
    alone = fall_rose(one, measure_from_fault_normal=True)
    assert alone.share_interval_low_by_sector[0] < 0.5 < alone.share_interval_high_by_sector[0]


@pytest.mark.parametrize(
    ("axis", "half_width", "expected"),
    [(10.0, 20.0, [(-10, 30)]), (70.0, 40.0, [(-90, -70), (30, 90)]), (-80.0, 15.0, [(-90, -65), (85, 90)])],
)
def test_interval_of_a_mean_axis_wraps_at_90_degrees(
    axis: float, half_width: float, expected: list[tuple[float, float]]
) -> None:
    """70° ± 40° reaches from 30° to 110°, which is −70° as an axis."""
    assert sorted(axis_interval_arcs_from_minus_90_to_90_deg(axis, half_width)) == expected
    (panel, *_) = draw_rose_of_falls_with_mean_axis(cube_of_falls_around_azimuth_40(), axis, half_width).axes
    lines = [line for line in panel.lines if line.get_color() == INK]
    spans = sorted(tuple(np.round(np.degrees(line.get_xdata())[[0, -1]], 6)) for line in lines)
    assert spans == sorted([(axis, axis), *expected])
    assert all((line.get_ydata() > panel.get_ylim()[1] * 1.0).any() for line in lines), "at the rim, off the sectors"


def test_a_rose_without_a_mean_axis_has_no_mark_of_it() -> None:
    figure = draw_rose_of_falls_with_mean_axis(cube_of_earthquakes_with_one_record_each(10))
    assert not [line for line in figure.axes[0].lines if line.get_color() == INK]
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert not any("mean axis" in text for text in legend)
    assert any("each sector by itself" in text for text in legend)


LARGEST_SECTOR_SHARES = (0.08, 0.17, 0.25, 0.36, 0.5, 0.7, 0.9)
"""Shares of the largest sector."""


@cache
def radius_label_boxes_by_largest_rose_share(axial: bool) -> dict[float, list[Bbox]]:
    """Return the boxes, pixels, of the radius labels of roses by the largest share of falls in a sector."""
    count = ROSE_SECTOR_COUNT // 2 if axial else ROSE_SECTOR_COUNT
    unknown, boxes = np.full(count, NAN), dict[float, list[Bbox]]()
    for pair in (LARGEST_SECTOR_SHARES[place : place + 2] for place in range(0, len(LARGEST_SECTOR_SHARES), 2)):
        with use_package_matplotlib_settings():
            figure, panels = create_panel_grid(1, 2, 6.6, 2.75 if axial else 4.3, polar=True)
            for axes, largest in zip(panels[0], pair, strict=False):
                shares = np.append(largest, np.full(count - 1, (1.0 - largest) / (count - 1)))
                draw_fall_rose(axes, FallShareRoseAveragedOverEarthquakes(10, shares, unknown, unknown, 3, True))
            figure.draw_without_rendering()
        for axes, largest in zip(panels[0], pair, strict=False):
            labels = [text for text in axes.get_yticklabels() if text.get_text()]
            boxes[largest] = [text.get_window_extent().padded(2.0) for text in labels]
    return boxes


@pytest.mark.parametrize("axial", [True, False])
@pytest.mark.parametrize("largest", LARGEST_SECTOR_SHARES)
def test_radius_labels_of_roses_do_not_touch(largest: float, axial: bool) -> None:
    """Regression: in a half circle the labels 10 and 20 per cent touched."""
    boxes = radius_label_boxes_by_largest_rose_share(axial)[largest]
    assert boxes
    assert not any(one.overlaps(other) for place, one in enumerate(boxes) for other in boxes[:place])
