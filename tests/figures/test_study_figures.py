"""Maps and roses show falls at their azimuths, also for unusual studies."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
import xarray as xr
from matplotlib.quiver import Quiver

from overturning import open_cube, plot
from overturning.errors import ArgumentError
from overturning.figures.cells import (
    azimuth_cell_edges_rad,
    azimuths_simulated_or_known_by_symmetry_deg,
    cell_edges,
    extend_azimuths_to_full_circle,
    panel_row_and_column_counts,
)
from overturning.figures.explore import explorer_page_data
from overturning.figures.illustrative import block_label, simulate_block_trajectories
from overturning.figures.maps import AZIMUTH_COLOURMAP, fall_azimuths_by_orientation_and_b_over_h_figure
from overturning.figures.polar_map import fall_map_by_azimuth_figure
from overturning.figures.rose import fall_roses_by_group_figure
from overturning.figures.style import (
    compass_bearing_text,
    gap_azimuths_one_step_from_simulated_ones,
    use_package_matplotlib_settings,
)
from overturning.figures.write import save_figure_files
from overturning.model.plane_weights import case_weights_by_azimuth_spacing
from overturning.motion.motion import Motion
from overturning.statistics.circular import fall_shares_by_sector
from overturning.study.intensity import write_intensity_measures
from overturning.study.load import study_from_content
from tests.expect import expect_error
from tests.figures.test_explore import random_3d_cube
from tests.study.small_study import simulate_study_cube, sine_cycle_record
from tests.study.test_config import SCENE_WITH_ITS_OWN_FRICTION


@pytest.fixture
def cube_of_falls_to_the_side_of_azimuth_30() -> xr.Dataset:
    """Return a cube of two records: all blocks fall to the side of 30°, but stand along 120° and 300°."""
    azimuth = np.arange(0, 360, 30, dtype=np.int16)
    flags = np.sign(np.round(np.cos(np.radians(azimuth - 30.0)), 3))[None, :, None, None, None] * np.ones(
        (2, 1, 1, 2, 2)
    )
    return xr.Dataset(
        {"overturned": (("record", "azimuth", "height", "b_over_h", "friction"), flags)},
        coords={
            "azimuth": azimuth,
            "height": [0.6],
            "b_over_h": [0.2, 0.4],
            "friction": [0.5, 1.0],
            "event": ("record", ["A", "B"]),
            "fault_normal": ("record", [30.0, np.nan]),
            "pulse": ("record", [1.0, np.nan]),
        },
    )


def test_map_cells_meet_half_way_between_grid_values_and_cover_the_circle() -> None:
    np.testing.assert_allclose(cell_edges(np.array([0.1, 0.2, 0.4])), [0.05, 0.15, 0.3, 0.5])
    edges = np.degrees(azimuth_cell_edges_rad(np.array([0.0, 90.0, 100.0, 270.0])))
    np.testing.assert_allclose(edges, [-45, 45, 95, 185, 315])


def test_rose_sectors_are_centred_on_north_and_shares_sum_to_one() -> None:
    shares = fall_shares_by_sector(np.array([352.6, 7.4, 7.6, 180.0]), np.ones(4))
    assert shares[0] == 0.5
    assert shares[1] == 0.25
    assert shares[12] == 0.25
    assert fall_shares_by_sector(np.array([10.0]), np.zeros(1)).sum() == 0


def test_azimuth_added_to_the_grid_shares_the_weight_of_its_neighbours() -> None:
    regular = np.arange(0.0, 360.0, 30.0)
    np.testing.assert_allclose(case_weights_by_azimuth_spacing(regular), 1.0)
    added = np.sort(np.append(regular, [32.0, 212.0]))
    weight = case_weights_by_azimuth_spacing(added)
    assert weight[added == 32.0] == weight[added == 212.0]
    # Of seven planes: 30° and 32° have half of the 32° and of the 30° between their neighbours, 30° is regular.
    assert weight[added == 30.0] == pytest.approx(7 * 16 / 180)
    assert weight[added == 32.0] == pytest.approx(7 * 15 / 180)
    assert weight[added == 120.0] == pytest.approx(7 * 30 / 180)


def test_maps_and_roses_are_drawn_without_falls_without_outcomes_and_for_one_azimuth(
    cube_of_falls_to_the_side_of_azimuth_30: xr.Dataset, tmp_path: Path
) -> None:
    with use_package_matplotlib_settings():
        for name, odd in {
            "none": cube_of_falls_to_the_side_of_azimuth_30.assign(
                overturned=cube_of_falls_to_the_side_of_azimuth_30["overturned"] * 0
            ),
            "unknown": cube_of_falls_to_the_side_of_azimuth_30.assign(
                overturned=cube_of_falls_to_the_side_of_azimuth_30["overturned"] * np.nan
            ),
            "single": cube_of_falls_to_the_side_of_azimuth_30.isel(azimuth=[1], b_over_h=[0]),
        }.items():
            save_figure_files(fall_map_by_azimuth_figure(odd.isel(record=1), name), tmp_path / f"{name}.png", dpi=50)
            save_figure_files(fall_roses_by_group_figure(odd), tmp_path / f"rose-{name}.png", dpi=50)
    assert len(list(tmp_path.iterdir())) == 6


@pytest.mark.parametrize(
    ("heights", "frictions", "expected"), [(1, 1, (1, 1)), (2, 3, (2, 3)), (1, 5, (2, 3)), (4, 1, (2, 2))]
)
def test_a_row_of_maps_has_at_most_three_panels(heights: int, frictions: int, expected: tuple[int, int]) -> None:
    assert panel_row_and_column_counts(heights, frictions) == expected


def test_azimuths_are_written_as_quadrant_bearings() -> None:
    names = {
        0: "N",
        60: "N60°E",
        90: "E",
        152: "S28°E",
        180: "S",
        212.5: "S32.5°W",
        332: "N28°W",
        360: "N",
        -30: "N30°W",
    }
    assert {azimuth: compass_bearing_text(azimuth) for azimuth in names} == names


DEUTERANOPIA_MATRIX = np.array(
    [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
)
"""Simulation of colour blindness in linear RGB (Machado et al. 2009, IEEE Trans. Visual. Comput. Graphics 15)."""


def linear_srgb_to_cielab(linear: np.ndarray) -> np.ndarray:
    """Convert linear sRGB to CIELAB, white point D65 (IEC 61966-2-1, CIE 15)."""
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    xyz = linear @ to_xyz.T / to_xyz.sum(axis=1)
    f = np.where(xyz > (6 / 29) ** 3, np.cbrt(xyz), xyz / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)


@pytest.mark.parametrize("seen", [np.eye(3), DEUTERANOPIA_MATRIX], ids=["all colours", "without green"])
def test_azimuth_colours_differ_with_red_green_blindness(seen: np.ndarray) -> None:
    """Colours 60° apart differ by over 20 in CIELAB (2.3 is visible); with hue alone, 233° and 293° differ by 7."""
    given = AZIMUTH_COLOURMAP(np.arange(256))[:, :3]
    linear = np.where(given <= 0.04045, given / 12.92, ((given + 0.055) / 1.055) ** 2.4)
    lab = linear_srgb_to_cielab(np.clip(linear @ seen.T, 0.0, 1.0))
    for apart in range(43, 129):  # 60° and more
        assert np.linalg.norm(lab - np.roll(lab, apart, axis=0), axis=1).min() > 20


def test_map_is_blank_only_in_azimuth_gaps_wider_than_the_step() -> None:
    """If only 60°, 70°, 240° and 250° are simulated, the map is blank from one step (10°) beyond them."""
    unknown = {(60, 70, 240, 250): [50, 80, 230, 260], (60, 150, 240, 330): [], (0, 30, 90, 180, 210, 270): []}
    for azimuth, ends in unknown.items():
        np.testing.assert_allclose(np.sort(gap_azimuths_one_step_from_simulated_ones(np.array(azimuth))), ends)
    full = np.sort([*range(0, 360, 5), 152.0])
    assert (
        gap_azimuths_one_step_from_simulated_ones(full).size
        == gap_azimuths_one_step_from_simulated_ones(full.repeat(2)).size
        == 0
    )


@pytest.mark.parametrize("azimuth", [[40], [220], [40, 220]])
def test_map_of_a_single_plane_has_a_sector_on_either_side(azimuth: list[int]) -> None:
    """With cases in one vertical plane only, a map over azimuth has a 5° sector at both ends of the plane."""
    flags = np.where(np.array(azimuth) < 180, 1.0, -1.0)  # towards 40°
    whole = extend_azimuths_to_full_circle(xr.Dataset({"overturned": ("azimuth", flags)}, {"azimuth": azimuth}))
    angles = whole["azimuth"].to_numpy().astype(float)
    edges = np.degrees(azimuth_cell_edges_rad(angles))
    shown = [(edges[k], edges[k + 1]) for k in np.flatnonzero(whole["overturned"].notnull())]
    np.testing.assert_allclose(shown, [(37.5, 42.5), (217.5, 222.5)])
    assert whole["overturned"].sel(azimuth=[40, 220]).to_numpy().tolist() == [1.0, -1.0]
    np.testing.assert_array_equal(
        azimuths_simulated_or_known_by_symmetry_deg(whole.sel(azimuth=azimuth)), [40.0, 220.0]
    )


@pytest.mark.parametrize(("step", "ratios"), [(45, 2), (15, 3), (5, 8)])
def test_arrows_of_an_orientation_map_are_20_to_100_per_cent_of_a_cell_long(step: int, ratios: int) -> None:
    """Each arrow is as long as 20 to 100 % of the smaller side of a cell, also if the map has few cells."""
    orientation, ratio = np.arange(0, 90, step), np.linspace(0.1, 0.4, ratios)
    shape = (orientation.size, 1, ratios, 1)
    names = ("orientation", "height", "b_over_h", "friction")
    falls = {"overturned": (names, np.ones(shape)), "fall_azimuth": (names, np.full(shape, 45.0))}
    sizes = {"orientation": orientation, "height": [0.6], "b_over_h": ratio, "friction": [0.7]}
    record = {"fault_normal": np.nan, "event": "E"}
    with use_package_matplotlib_settings():
        figure = fall_azimuths_by_orientation_and_b_over_h_figure(xr.Dataset(falls, coords=sizes | record), "A")
    axes = figure.axes[0]
    arrows = next(one for one in axes.collections if isinstance(one, Quiver))
    cell = min(axes.bbox.width / orientation.size, axes.bbox.height / ratios)
    plt.close(figure)
    assert 0.2 <= axes.bbox.width / arrows.scale / cell <= 1.0


def test_rose_next_to_3d_maps_shows_only_the_falls_of_these_maps() -> None:
    """The rose shows the falls of the heights and frictions in the maps, not of all."""
    whole = random_3d_cube().assign_coords(pulse=("record", [1, 1])).isel(record=0)
    one = whole.sel(friction=[0.5])
    with use_package_matplotlib_settings():
        around = fall_azimuths_by_orientation_and_b_over_h_figure(one, "A").axes[-1]
        plt.close("all")
    shares = np.array([bar.get_height() ** 2 for bar in around.patches])
    falls = one["fall_azimuth"].to_numpy().ravel()
    sectors = np.round(falls[np.isfinite(falls)] / 15.0).astype(int) % 24
    np.testing.assert_allclose(shares, np.bincount(sectors, minlength=24) / sectors.size)
    assert around.get_title() == "falls of these maps"


def test_figures_omit_a_friction_that_the_scene_overrides(tmp_path: Path) -> None:
    """Regression: a scene with its own µ = 0.1 was labelled µ = 1, the friction of the study."""
    grid = {"azimuth": {"step": 90}, "b_over_h": [0.2, 0.4], "friction": [0.2, 1.0], "ensemble": {"members": 0}}
    scenes = {"scene": SCENE_WITH_ITS_OWN_FRICTION, "variants": {"other": {"scene": "gravestone"}}}
    settings = study_from_content({"name": "icy", "records": {"use": ["a"]}, **grid, **scenes}, "icy")
    record = sine_cycle_record()
    write_intensity_measures(settings, [record], tmp_path / "intensity.nc")
    block = {"height": 0.6, "b_over_h": 0.2, "friction": 0.2}
    for variant, said in (("nominal", ["µ of the scene"] * 2), ("other", ["µ = 0.2", "µ = 1"])):
        with open_cube(simulate_study_cube(settings, [record], tmp_path, variant)) as cube:
            drawn = plot.fall_maps_by_block(cube)
            heading = drawn.get_suptitle().splitlines()[-1].partition(",")[0]
            assert [panel.get_title().strip() or heading for panel in drawn.axes] == said
            if variant == "nominal":  # on ice the stone slides and stands
                with expect_error(ArgumentError, "boundary: nothing to draw: none of the 16 cases"):
                    plot.overturning_boundary(cube)
            else:
                assert [one.get_text() for one in plot.overturning_boundary(cube).legends[0].get_texts()][:2] == said
            assert plot.outcomes_by_pga_and_pgv_ratio(cube).get_suptitle().endswith(said[-1])
            titles = plot.fall_map(cube).get_suptitle(), explorer_page_data(cube)["title"]
            assert ["variant other" in title for title in titles] == [variant == "other"] * 2
    assert block_label(settings, block).endswith("m, µ of the scene")
    (path,) = simulate_block_trajectories(settings, Motion.of(record), block, [0.0])
    assert path.attrs["friction"] == 1.0, "which is not looked at"
