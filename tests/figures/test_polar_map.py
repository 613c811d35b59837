"""Polar maps: the appearance of a cell follows from its outcomes, at its azimuth, also for parts of a circle."""

from collections.abc import Callable

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text

from overturning.figures.boundary import overturning_boundary_figure
from overturning.figures.cells import isolated_curve_point_indices, symmetric_polar_curve_angles_rad_and_radii
from overturning.figures.explore import explorer_page_data
from overturning.figures.ground import pga_and_pgv_by_azimuth_figure
from overturning.figures.polar_map import (
    PROBABILITY_COLOURMAP,
    azimuth_deg_for_radius_labels,
    fall_map_by_azimuth_figure,
    half_probability_cell_outline,
    round_up_velocity_at_map_rim,
)
from overturning.figures.style import MISSING_COLOUR, PAGE_WIDTH_INCHES, use_package_matplotlib_settings
from overturning.statistics.boundary import overturning_boundary_b_over_h_by_azimuth
from tests.figures.test_explore import random_planar_cube
from tests.figures.test_further_figures import cube_of_falls_around_azimuth_40

AZIMUTH_STEP_DEG = 30
AZIMUTHS_DEG = np.arange(0, 360, AZIMUTH_STEP_DEG)
CUBE_DIMS = ("azimuth", "height", "b_over_h", "friction")


def cube_of_one_record_from_fall_shares(
    towards: np.ndarray, away: np.ndarray, flags: np.ndarray | None = None, ratios: tuple[float, ...] = (0.2, 0.4, 0.6)
) -> xr.Dataset:
    """Return a cube of one block and record from shares of runs that fall towards and away, and overturning flags."""
    shape = (AZIMUTHS_DEG.size, 1, len(ratios), 1)
    flags = np.sign(np.where(np.maximum(towards, away) >= 0.5, towards - away, 0.0)) if flags is None else flags
    values = {"overturned": flags, "probability_towards": towards, "probability_away": away}
    return xr.Dataset(
        {name: (CUBE_DIMS, np.asarray(of, np.float32).reshape(shape)) for name, of in values.items()},
        {"azimuth": AZIMUTHS_DEG, "height": [0.6], "b_over_h": list(ratios), "friction": [0.5]},
    )


def towards_and_away_fall_shares_from_cells(*cells: tuple[int, int, float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Return shares of runs that fall towards and away, (azimuth, ring), from given cells and their mirror images.

    A cell is (azimuth, ring, share towards, share away); a ring is the index of a B/H.
    """
    towards, away = np.zeros((2, AZIMUTHS_DEG.size, 3))
    for azimuth, ring, one, other in cells:
        towards[azimuth // AZIMUTH_STEP_DEG, ring], away[azimuth // AZIMUTH_STEP_DEG, ring] = one, other
        opposite = (azimuth + 180) % 360 // AZIMUTH_STEP_DEG
        towards[opposite, ring], away[opposite, ring] = other, one
    return towards, away


def rgb_pixels_in_radially_outer_half_of_map_cell(figure: Figure, azimuth: float, ratio: float) -> np.ndarray:
    """Return RGB values (n, 3), 0 to 1, in the outer half of a map cell; a grid line may cross the middle."""
    axes = figure.axes[0]
    picture = np.asarray(figure.canvas.buffer_rgba())[..., :3] / 255.0
    theta, radius = np.meshgrid(np.radians(azimuth + np.linspace(-6, 6, 25)), ratio + np.linspace(0.02, 0.07, 25))
    x, y = axes.transData.transform(np.column_stack([theta.ravel(), radius.ravel()])).T
    return picture[(picture.shape[0] - y).astype(int), x.astype(int)]


def make_figure_and_draw_its_pixels(made: Callable[[], Figure]) -> Figure:
    """Make a figure and draw it to pixels at 200 dpi."""
    with use_package_matplotlib_settings():
        figure = made()
        figure.set_dpi(200)
        figure.canvas.draw()
    return figure


def make_figure_and_lay_it_out(made: Callable[[], Figure]) -> Figure:
    """Make a figure and compute the positions of its texts and panels, without drawing pixels."""
    with use_package_matplotlib_settings():
        figure = made()
        figure.draw_without_rendering()
    return figure


def make_figure_in_project_style(made: Callable[[], Figure]) -> Figure:
    """Make a figure without drawing it, for tests of its lines and texts but not of their positions."""
    with use_package_matplotlib_settings():
        return made()


def grey_level(pixels: np.ndarray) -> np.ndarray:
    """Return the grey level of pixels as printed without colour (ITU-R BT.601)."""
    return pixels @ np.array([0.299, 0.587, 0.114])


def test_map_cell_with_falls_only_away_from_its_azimuth_is_white_not_hatched() -> None:
    """Cells where 20 to 50 % of runs fall, all to the other side, are white; cells where all stand are hatched."""
    shares = {60: 0.2, 90: 0.35, 120: 0.4, 150: 0.5}
    cells = towards_and_away_fall_shares_from_cells(*((azimuth, 1, 0.0, share) for azimuth, share in shares.items()))
    figure = make_figure_and_draw_its_pixels(
        lambda: fall_map_by_azimuth_figure(cube_of_one_record_from_fall_shares(*cells), "A")
    )
    for azimuth, share in shares.items():
        assert grey_level(rgb_pixels_in_radially_outer_half_of_map_cell(figure, azimuth, 0.4)).min() > 0.99, (
            "probability 0 is white"
        )
        opposite = rgb_pixels_in_radially_outer_half_of_map_cell(figure, azimuth + 180, 0.4)
        np.testing.assert_allclose(opposite.mean(axis=0), PROBABILITY_COLOURMAP(share)[:3], atol=0.01)
    for azimuth in (180, 210):
        stands = grey_level(rgb_pixels_in_radially_outer_half_of_map_cell(figure, azimuth, 0.4))
        assert stands.max() < 0.95, "no part of a standing cell is white"
        assert np.ptp(stands) > 0.15, "but it is hatched"
    plt.close(figure)


def test_cells_with_different_outcomes_differ_in_greyscale_print() -> None:
    cells = towards_and_away_fall_shares_from_cells((60, 1, 0.0, 1.0), (120, 1, 1 / 8, 0.0), (0, 1, 1.0, 0.0))
    figure = make_figure_and_draw_its_pixels(
        lambda: fall_map_by_azimuth_figure(cube_of_one_record_from_fall_shares(*cells), "A")
    )
    grey = {at: grey_level(rgb_pixels_in_radially_outer_half_of_map_cell(figure, at, 0.4)) for at in (60, 120, 0, 90)}
    plt.close(figure)
    white, pale, dark, stands = (grey[at].mean() for at in (60, 120, 0, 90))
    assert white - pale > 0.05
    assert white - stands > 0.1
    assert dark < 0.3
    assert np.ptp(grey[120]) < 0.02, "a pale cell is even"
    assert np.ptp(grey[90]) > 0.15, "a cell that stands is hatched"
    ramp = grey_level(PROBABILITY_COLOURMAP(np.linspace(0, 1, 101))[:, :3])
    assert (np.diff(ramp) < 0).all(), "darker with each per cent"
    assert ramp[0] == pytest.approx(1.0)


def test_map_cell_is_white_if_the_block_falls_but_no_run_of_its_ensemble_does() -> None:
    flags = np.zeros((AZIMUTHS_DEG.size, 3))
    flags[2, 1], flags[8, 1] = 1, -1
    figure = make_figure_and_draw_its_pixels(
        lambda: fall_map_by_azimuth_figure(
            cube_of_one_record_from_fall_shares(*towards_and_away_fall_shares_from_cells(), flags), "A"
        )
    )
    fell, stands = (
        rgb_pixels_in_radially_outer_half_of_map_cell(figure, 60, 0.4),
        rgb_pixels_in_radially_outer_half_of_map_cell(figure, 90, 0.4),
    )
    plt.close(figure)
    assert grey_level(fell).min() > 0.99
    assert grey_level(stands).max() < 0.95


def test_a_cell_without_an_outcome_differs_from_every_probability_in_greyscale() -> None:
    towards, away = towards_and_away_fall_shares_from_cells()
    towards[[2, 8], 1] = away[[2, 8], 1] = np.nan
    flags = np.where(np.isnan(towards), np.nan, 0.0)
    figure = make_figure_and_draw_its_pixels(
        lambda: fall_map_by_azimuth_figure(cube_of_one_record_from_fall_shares(towards, away, flags), "A")
    )
    unknown = rgb_pixels_in_radially_outer_half_of_map_cell(figure, 60, 0.4)
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    plt.close(figure)
    assert np.ptp(grey_level(unknown)) > 0.3, "crossed"
    assert grey_level(unknown).min() == pytest.approx(grey_level(np.array(to_rgb(MISSING_COLOUR))), abs=0.03)
    assert "no outcome" in legend


def test_map_is_blank_where_nothing_was_computed() -> None:
    """The hole within B/H 0.1 is blank, and so are azimuths other than 0° to 90° and 180° to 270°."""
    part = cube_of_one_record_from_fall_shares(*towards_and_away_fall_shares_from_cells()).isel(azimuth=slice(0, 4))
    figure = make_figure_and_draw_its_pixels(lambda: fall_map_by_azimuth_figure(part, "A"))
    assert grey_level(rgb_pixels_in_radially_outer_half_of_map_cell(figure, 140, 0.4)).min() > 0.99
    assert grey_level(rgb_pixels_in_radially_outer_half_of_map_cell(figure, 30, 0.4)).max() < 0.95
    assert grey_level(rgb_pixels_in_radially_outer_half_of_map_cell(figure, 210, 0.4)).max() < 0.95, "the mirror image"
    assert grey_level(rgb_pixels_in_radially_outer_half_of_map_cell(figure, 60, 0.015)).min() > 0.99
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    plt.close(figure)
    assert "not computed (B/H below 0.1)" in legend
    assert "not computed (azimuths outside the outline)" in legend
    assert "no outcome" not in legend
    whole = make_figure_and_draw_its_pixels(
        lambda: fall_map_by_azimuth_figure(
            cube_of_one_record_from_fall_shares(*towards_and_away_fall_shares_from_cells()), "A"
        )
    )
    assert not any("azimuths" in text.get_text() for text in whole.legends[0].get_texts())
    plt.close(whole)


@pytest.mark.parametrize(
    ("azimuths", "alone"),
    [([37.0], [37, 217]), ([0.0], [0, 180]), ([0.0, 5.0], []), ([170.0, 175.0, 0.0], [])],
)
def test_a_single_azimuth_gives_isolated_points_of_a_polar_curve(azimuths: list[float], alone: list[int]) -> None:
    theta, radii = symmetric_polar_curve_angles_rad_and_radii(np.array(azimuths), np.ones(len(azimuths)))
    assert np.degrees(theta[isolated_curve_point_indices(radii)]).round(9).tolist() == alone


def ends_of_line_pieces(line: tuple[np.ndarray, np.ndarray]) -> set[tuple[float, ...]]:
    """Return the straight pieces and arcs of a line, each as its two ends (degrees, radius), in order."""
    angle, radius = line
    breaks = np.flatnonzero(np.isnan(angle))
    parts = np.split(np.arange(angle.size), breaks)
    ends = [part[~np.isnan(angle[part])][[0, -1]] for part in parts if (~np.isnan(angle[part])).any()]
    return {tuple(np.round([np.degrees(angle[a]), radius[a], np.degrees(angle[b]), radius[b]], 6)) for a, b in ends}


def test_half_probability_line_encloses_cells_where_half_of_the_runs_fall() -> None:
    """In one inner cell, of four azimuths and two rings, half of the runs fall; no line borders an unknown cell."""
    theta, radius = np.radians(np.arange(-45.0, 360.0, 90.0)), np.array([0.1, 0.3, 0.5])
    falls = np.array([[0.2, 0.5, 0.49, 0.0], [0.0, 0.0, 0.0, 0.0]])
    around = {(45.0, 0.1, 45.0, 0.3), (135.0, 0.1, 135.0, 0.3), (45.0, 0.3, 135.0, 0.3)}
    assert ends_of_line_pieces(half_probability_cell_outline(falls, theta, radius, chords_per_arc=5)) == around
    falls[1, 1] = np.nan
    assert ends_of_line_pieces(half_probability_cell_outline(falls, theta, radius)) == around - {
        (45.0, 0.3, 135.0, 0.3)
    }
    falls[:] = [[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]]
    both = {(at, low, at, high) for at in (225.0, 315.0) for low, high in ((0.1, 0.3), (0.3, 0.5))}
    assert ends_of_line_pieces(half_probability_cell_outline(falls, theta, radius)) == both, (
        "it closes across the start, and not at the outer ring"
    )
    half = half_probability_cell_outline(falls[:, 2:], theta[2:], radius)
    assert ends_of_line_pieces(half) == {(225.0, 0.1, 225.0, 0.3), (225.0, 0.3, 225.0, 0.5)}, (
        "a part of a circle has two ends"
    )


def test_half_probability_line_is_of_summed_probability_of_both_sides() -> None:
    """30 % one way and 30 % the other way are more than half; 30 and 10 % are not."""
    for away, inside in ((0.3, True), (0.1, False)):
        figure = make_figure_in_project_style(
            lambda away=away: fall_map_by_azimuth_figure(
                cube_of_one_record_from_fall_shares(*towards_and_away_fall_shares_from_cells((60, 1, 0.3, away))),
                "A",
            )
        )
        black = [line for line in figure.axes[0].lines if line.get_color() == "black"]
        plt.close(figure)
        assert bool(ends_of_line_pieces(black[0].get_data())) == inside


def test_polar_map_shows_a_fall_at_its_azimuth() -> None:
    """The map of a block that falls towards N30°E is dark there and white opposite, with an ensemble or without."""
    flags = np.sign(np.round(np.cos(np.radians(AZIMUTHS_DEG - 30.0)), 3))[:, None] * np.ones(3)
    cube = cube_of_one_record_from_fall_shares(np.maximum(flags, 0), np.maximum(-flags, 0), flags)
    for one in (cube, cube[["overturned"]]):
        figure = make_figure_and_draw_its_pixels(lambda one=one: fall_map_by_azimuth_figure(one, "A"))
        axes = figure.axes[0]
        np.testing.assert_allclose(
            rgb_pixels_in_radially_outer_half_of_map_cell(figure, 30, 0.4).mean(axis=0),
            PROBABILITY_COLOURMAP(1.0)[:3],
            atol=0.01,
        )
        assert grey_level(rgb_pixels_in_radially_outer_half_of_map_cell(figure, 210, 0.4)).min() > 0.99
        assert grey_level(rgb_pixels_in_radially_outer_half_of_map_cell(figure, 120, 0.4)).max() < 0.95
        assert (axes.get_theta_direction(), np.degrees(axes.get_theta_offset())) == (-1, 90)
        legend = [text.get_text() for text in figure.legends[0].get_texts()]
        assert ("falls towards this azimuth" in legend) == ("probability_towards" not in one)
        plt.close(figure)


def test_peak_velocity_is_drawn_at_its_azimuth_on_a_stated_scale() -> None:
    """0.8 m/s along 60° and 0.4 m/s across it: the rim is 1 m/s, so the line reaches 0.8 and 0.4 of the radius."""
    azimuth = np.arange(0.0, 180.0, 30.0)
    peaks = xr.DataArray(0.6 + 0.2 * np.cos(np.radians(2 * (azimuth - 60))), {"azimuth": azimuth}, ["azimuth"])
    cube = cube_of_one_record_from_fall_shares(*towards_and_away_fall_shares_from_cells())
    figure = make_figure_in_project_style(lambda: fall_map_by_azimuth_figure([cube, cube], "A", [peaks, 0.5 * peaks]))
    for axes, factor in zip(figure.axes[:2], (1.0, 0.5), strict=True):
        (line,) = [one for one in axes.lines if one.get_path_effects()]
        angle, radius = line.get_data()
        top = axes.get_ylim()[1]
        for at, share in ((60, 0.8), (240, 0.8), (150, 0.4)):
            assert radius[np.isclose(np.degrees(angle) % 360, at)] == pytest.approx(factor * share * top)
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    plt.close(figure)
    assert "peak velocity by azimuth (rim: 100 cm/s)" in legend
    assert [round_up_velocity_at_map_rim(peak) for peak in (0.0, 0.019, 0.5, 0.96, 1.7)] == pytest.approx(
        [0, 0.02, 0.6, 1.5, 2.0]
    )


def test_maps_of_compared_records_share_radius_colour_bar_and_heading() -> None:
    """One record overturns blocks up to B/H 0.2, the other up to 0.6; both maps end at the same B/H."""
    small, large = (
        cube_of_one_record_from_fall_shares(*towards_and_away_fall_shares_from_cells((0, ring, 0.9, 0.0)))
        for ring in (0, 2)
    )
    named = [one.assign_coords(station=name, event="E") for one, name in ((small, "near"), (large, "far"))]
    figure = make_figure_in_project_style(lambda: fall_map_by_azimuth_figure(named, "Two records"))
    maps = [axes for axes in figure.axes if axes.name == "polar"]
    assert [axes.get_title() for axes in maps] == ["near, E", "far, E"]
    assert len({axes.get_ylim() for axes in maps}) == 1
    assert maps[0].get_ylim()[1] == pytest.approx(0.7)
    assert len(figure.axes) == 3, "two maps and one colour bar"
    heading = figure.get_suptitle()
    plt.close(figure)
    assert heading.count("H = 0.6 m") == heading.count("µ = 0.5") == 1


def test_records_without_a_station_are_named_by_their_ids() -> None:
    """Maps and explorer name two pulses of one shape, which have no station, by their ids."""
    one = cube_of_one_record_from_fall_shares(*towards_and_away_fall_shares_from_cells((0, 2, 0.9, 0.0)))
    text = {"station": "", "event": "sine pulse"}
    pulses = [one.assign_coords(text | {"record_id": name}) for name in ("short", "long")]
    figure = make_figure_in_project_style(lambda: fall_map_by_azimuth_figure(pulses, "Two pulses"))
    titles = [axes.get_title() for axes in figure.axes if axes.name == "polar"]
    plt.close(figure)
    names = ["short, sine pulse", "long, sine pulse"]
    assert titles == names
    both = random_planar_cube(records=2).assign_coords(record_id=("record", ["short", "long"]))
    both = both.assign_coords({name: ("record", 2 * [value]) for name, value in text.items()})
    assert [record["name"] for record in explorer_page_data(both)["records"]] == names


def test_titles_of_maps_state_how_their_blocks_differ() -> None:
    one = cube_of_falls_around_azimuth_40().isel(record=0)
    figure = make_figure_in_project_style(lambda: fall_map_by_azimuth_figure(one, "A"))
    titles, heading = [axes.get_title() for axes in figure.axes[:4]], figure.get_suptitle()
    plt.close(figure)
    assert titles == ["µ = 0.5, H = 0.6 m", "µ = 1, H = 0.6 m", "µ = 0.5, H = 1.2 m", "µ = 1, H = 1.2 m"]
    assert "µ" not in heading
    figure = make_figure_in_project_style(lambda: fall_map_by_azimuth_figure(one.isel(friction=[1]), "A"))
    titles, heading = [axes.get_title() for axes in figure.axes[:2]], figure.get_suptitle()
    plt.close(figure)
    assert titles == ["H = 0.6 m", "H = 1.2 m"]
    assert "µ = 1" in heading


@pytest.mark.parametrize("blocks", [(1, 1), (1, 2), (2, 2)])
def test_letters_of_a_map_have_at_least_7_points_at_the_printed_width(blocks: tuple[int, int]) -> None:
    """A figure wider than the page is reduced in print, so that its letters must be larger."""
    one = cube_of_falls_around_azimuth_40().isel(record=0, height=slice(blocks[0]), friction=slice(blocks[1]))
    figure = make_figure_and_lay_it_out(lambda: fall_map_by_azimuth_figure(one, "Station, earthquake"))
    sizes = [text.get_fontsize() for text in figure.findobj(Text) if text.get_text() and text.get_visible()]
    shrunk = min(1.0, PAGE_WIDTH_INCHES / figure.get_figwidth())
    plt.close(figure)
    assert min(sizes) * shrunk >= 7.0


@pytest.mark.parametrize("free", [22.5, 112.5, 247.5])
def test_stouter_arrow_is_outside_the_rim_and_points_outward(free: float) -> None:
    """The arrow stands outside the rim next to the labels of the radius; text on the left ends at the rim."""
    towards = (np.abs((AZIMUTHS_DEG - free + 180) % 360 - 180) > 20).astype(float)[:, None] * np.ones(3)
    figure = make_figure_and_lay_it_out(
        lambda: fall_map_by_azimuth_figure(cube_of_one_record_from_fall_shares(towards, 0 * towards), "A")
    )
    axes = figure.axes[0]
    (arrow,) = [text for text in axes.texts if "stouter" in text.get_text()]
    assert axes.get_rlabel_position() == pytest.approx(free)
    box, rim = arrow.get_window_extent(), axes.transData.transform((np.radians(free), axes.get_ylim()[1]))
    centre = axes.transData.transform((0.0, 0.0))
    plt.close(figure)
    outward = (np.mean(box.get_points(), axis=0) - rim) @ (rim - centre)
    assert outward > 0
    assert arrow.get_text().endswith("→") == (free < 180)


def test_map_marks_the_direction_away_from_the_epicentre_if_it_is_known() -> None:
    one = cube_of_one_record_from_fall_shares(*towards_and_away_fall_shares_from_cells((0, 1, 0.9, 0.0))).assign_coords(
        fault_normal=30.0
    )
    placed = {"epicentre_latitude": 35.0, "epicentre_longitude": 135.0, "station_latitude": 34.0}
    for known in (False, True):
        cube = one.assign_coords(placed | {"station_longitude": 135.0} if known else {})
        figure = make_figure_in_project_style(lambda cube=cube: fall_map_by_azimuth_figure(cube, "A"))
        legend = [text.get_text() for text in figure.legends[0].get_texts()]
        marks = [line for line in figure.axes[0].lines if line.get_label() == "away from the epicentre"]
        assert ("away from the epicentre" in legend, len(marks)) == (known, int(known))
        assert "fault normal" in legend
        plt.close(figure)
    (angle,), (radius,) = marks[0].get_data()
    assert np.degrees(angle) == pytest.approx(180.0)
    assert radius == pytest.approx(figure.axes[0].get_ylim()[1])


@pytest.mark.parametrize("step", [1, 3])
def test_polar_map_cells_are_fine_arcs_and_the_panel_is_80_to_120_mm_wide(step: int) -> None:
    one = cube_of_one_record_from_fall_shares(*towards_and_away_fall_shares_from_cells((0, 1, 0.9, 0.0))).isel(
        azimuth=slice(None, None, step)
    )
    figure = make_figure_and_lay_it_out(lambda: fall_map_by_azimuth_figure(one, "A"))
    axes = figure.axes[0]
    corners = axes.collections[0].get_coordinates()[0, :, 0]
    panel, width = axes.get_window_extent(), figure.get_figwidth()
    bar = figure.axes[1].get_window_extent()
    plt.close(figure)
    assert np.degrees(np.diff(corners)).max() <= 2.0 + 1e-9
    assert 80.0 <= 25.4 * panel.width / figure.dpi <= 120.0, "mm across on paper"
    assert bar.width <= panel.width + 1
    assert width <= PAGE_WIDTH_INCHES


def test_map_ends_at_the_first_b_over_h_without_falls_and_labels_avoid_falls() -> None:
    with use_package_matplotlib_settings():
        figure = fall_map_by_azimuth_figure(
            cube_of_one_record_from_fall_shares(*towards_and_away_fall_shares_from_cells((0, 0, 0.9, 0.0))), "A"
        )
        assert figure.axes[0].get_ylim()[1] == pytest.approx(0.5)
        plt.close(figure)
    azimuth = np.arange(0.0, 360.0, 5.0)
    for free in (22.5, 202.5, 337.5):
        falls = (np.abs((azimuth - free + 180) % 360 - 180) > 20).astype(float)[None]
        cells = xr.Dataset(
            {"towards": (("b_over_h", "azimuth"), falls), "away": (("b_over_h", "azimuth"), 0 * falls)},
            {"azimuth": azimuth},
        )
        assert azimuth_deg_for_radius_labels(cells, np.nan) == free
        assert azimuth_deg_for_radius_labels(cells, free + 5) != free


def test_map_and_boundary_of_a_partial_circle_end_where_it_was_simulated() -> None:
    """For azimuths 0° to 80° (and 180° to 260°), maps must not extend to 130°, and curves must not cross the gap."""
    azimuth = np.arange(0.0, 90.0, 10.0)
    flags = np.ones((azimuth.size, 1, 3, 1)) * [[1.0], [0.0], [0.0]]
    part = xr.Dataset(
        {"overturned": (CUBE_DIMS, flags)},
        {"azimuth": azimuth, "height": [0.6], "b_over_h": [0.2, 0.4, 0.6], "friction": [1.0]},
    )
    peaks = xr.Dataset({name: ("azimuth", 3.0 + np.cos(np.radians(azimuth))) for name in ("pga", "pgv")}, part.coords)
    figure = make_figure_and_draw_its_pixels(lambda: fall_map_by_azimuth_figure(part, "A"))
    seen = {
        at: grey_level(rgb_pixels_in_radially_outer_half_of_map_cell(figure, at, 0.2)).mean()
        for at in (8, 72, 98, 135, 172, 195, 225)
    }
    assert figure.axes[0].get_ylim()[1] == pytest.approx(0.5), "nothing falls from 0.4 on"
    plt.close(figure)
    assert {at for at, grey in seen.items() if grey < 0.3} == {8, 72}
    assert grey_level(rgb_pixels_in_radially_outer_half_of_map_cell(figure, 40, 0.4)).max() < 0.95
    with use_package_matplotlib_settings():
        for curves in (
            pga_and_pgv_by_azimuth_figure(peaks, np.nan, "A"),
            overturning_boundary_figure(overturning_boundary_b_over_h_by_azimuth(part), 0.4, np.nan, "A"),
        ):
            theta, radius = curves.axes[0].lines[0].get_data()
            shown = np.isfinite(radius[:-1] + radius[1:])
            between = np.degrees(theta[:-1] + theta[1:])[shown] / 2
            assert np.abs((between[:, None] - azimuth + 90.0) % 180.0 - 90.0).min(axis=1).max() <= 5.0 + 1e-9
            assert shown.sum() == 16, "eight steps on either side"
        band = [path.vertices[:, 1].min() for path in curves.axes[0].collections[0].get_paths()]
        assert min(band) > 0.2, "nor does it run to the middle where nothing is known"
        alone = (
            overturning_boundary_figure(
                overturning_boundary_b_over_h_by_azimuth(part.isel(azimuth=[2])), 0.4, np.nan, "A"
            )
            .axes[0]
            .lines[-1]
        )
        assert (alone.get_marker(), np.degrees(alone.get_xdata()).tolist()) == (".", [20.0, 200.0])
        plt.close("all")


def test_innermost_ring_of_a_map_is_drawn_if_b_over_h_values_are_far_apart() -> None:
    """Regression: for B/H 0.1 and 0.4 the inner edge of the first ring was negative, and the ring was not drawn."""
    ones = np.ones((AZIMUTHS_DEG.size, 2))
    figure = make_figure_and_draw_its_pixels(
        lambda: fall_map_by_azimuth_figure(cube_of_one_record_from_fall_shares(ones, 0 * ones, ones, (0.1, 0.4)), "A")
    )
    pixels = rgb_pixels_in_radially_outer_half_of_map_cell(figure, 60, 0.03)
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    plt.close(figure)
    np.testing.assert_allclose(pixels.mean(axis=0), PROBABILITY_COLOURMAP(1.0)[:3], atol=0.01)
    assert not any(text.startswith("not computed") for text in legend), "there is no hole"


def test_map_includes_a_nominal_fall_at_the_largest_b_over_h_if_all_its_ensemble_stands() -> None:
    """Regression: the map ended before a case that falls at the largest B/H while all of its ensemble stands."""
    flags = np.zeros((AZIMUTHS_DEG.size, 3))
    flags[3, 2], flags[9, 2] = 1, -1
    wide = cube_of_one_record_from_fall_shares(*towards_and_away_fall_shares_from_cells((90, 0, 0.0, 0.5)), flags)
    with use_package_matplotlib_settings():
        assert fall_map_by_azimuth_figure(wide, "A").axes[0].get_ylim()[1] == pytest.approx(0.7)
        plt.close("all")
    missing = dict.fromkeys(("peak_rotation", "overturning_time"), wide["overturned"] * np.nan)
    named = {name: ("record", ["a"]) for name in ("record_id", "station", "event")}
    cube = wide.assign(missing).expand_dims("record").assign_coords(named | {"fault_normal": ("record", [np.nan])})
    assert explorer_page_data(cube)["rings"] == 3
