"""Overturning boundaries along B/H."""

import numpy as np
import pytest
import xarray as xr

from overturning.statistics.boundary import boundary, crossing_bounds, crossing_values, easiest_azimuth


def test_all_crossings_are_found() -> None:
    grid = [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]
    found = crossing_values([1, 1, 0, 1, 0.25, 0], grid, 4)
    assert found[:3] == pytest.approx([0.25, 0.35, 0.4 + 0.1 * 0.5 / 0.75])
    assert np.isnan(found[3])


def test_every_crossing_has_its_interval() -> None:
    """Falls, stands, falls, stands: each crossing with the nearest likewise of either scramble."""
    grid = [0.1, 0.2, 0.3, 0.4, 0.5]
    whole, one, two = [1, 0, 1, 1, 0], [1, 0.25, 1, 1, 0], [1, 0, 0.25, 1, 0]
    assert crossing_values(whole, grid, 3) == pytest.approx([0.15, 0.25, 0.45])
    bounds = crossing_bounds(whole, one, two, grid, 3)
    assert bounds[0] == pytest.approx([0.15, 0.1 + 0.1 * 0.5 / 0.75])
    assert bounds[1] == pytest.approx([0.2 + 0.1 * 0.25 / 0.75, 0.3 + 0.1 * 0.25 / 0.75])
    assert bounds[2] == pytest.approx([0.45, 0.45])
    # A crossing that one scramble does not have has no interval.
    only_one = crossing_bounds(whole, [1, 1, 1, 1, 0], whole, grid, 3)
    assert np.isfinite(only_one[:, 0]).tolist() == [True, False, True]


def test_none_and_gap() -> None:
    assert np.isnan(crossing_values([[0, 0, 0], [1, 1, 1]], [0.1, 0.2, 0.3], 2)).all()
    assert crossing_values([1, np.nan, 0], [0.1, 0.2, 0.3], 1) == pytest.approx([0.2])


def test_of_too_many_the_last_are_kept() -> None:
    assert crossing_values([1, 0, 1, 0], [0.1, 0.2, 0.3, 0.4], 1) == pytest.approx([0.35])


def test_boundary_of_a_cube(make_cube, sector) -> None:
    cube = make_cube(sector(60, 20, largest=0.3))
    bounds = boundary(cube)
    inside = bounds["boundary"].sel(azimuth=[60, 75, 240])
    assert inside.values == pytest.approx(0.35)
    assert bounds["boundary"].sel(azimuth=150).isnull().all()
    assert bounds["stands_throughout"].sel(azimuth=150).all()
    assert not bounds["falls_beyond"].any()
    assert easiest_azimuth(bounds, cube["b_over_h"])["easiest_axis"].values == pytest.approx(60)


def test_falls_beyond_the_grid(make_cube, sector) -> None:
    cube = make_cube(sector(60, 20))
    bounds = boundary(cube)
    assert bounds["falls_beyond"].sel(azimuth=60).all()
    assert bounds["boundary"].isnull().all()
    easiest = easiest_azimuth(bounds, cube["b_over_h"])
    assert not easiest["bounded"].any()
    assert easiest["ratio"].values == pytest.approx(0.5 / 0.1)


def test_how_much_easier(make_cube) -> None:
    def rule(azimuth, height, slender, friction):
        limit = 0.25 + 0.2 * np.cos(np.radians(azimuth - 30)) ** 2
        return np.where(slender <= limit, np.where(np.cos(np.radians(azimuth - 30)) >= 0, 1, -1), 0)

    cube = make_cube(rule, b_over_h=np.round(np.arange(0.1, 0.6, 0.01), 2))
    easiest = easiest_azimuth(boundary(cube), cube["b_over_h"])
    assert easiest["easiest_axis"].values == pytest.approx(30, abs=0.1)
    assert easiest["ratio"].values == pytest.approx(0.455 / 0.255, abs=0.02)
    assert easiest["bounded"].all()


def test_interval_between_scrambles(make_cube, sector) -> None:
    cube = make_cube(sector(60, 20, largest=0.3))
    towards = xr.full_like(cube["overturned"], np.nan)
    towards[{"b_over_h": 2}] = 0.75
    towards[{"b_over_h": 3}] = 0.25
    gap = xr.zeros_like(towards).where(towards.isnull(), 0.25)
    cube = cube.assign(
        probability_towards=towards,
        probability_away=towards * 0,
        scramble_difference_towards=gap,
        scramble_difference_away=gap * 0,
    )
    bounds = boundary(cube).sel(azimuth=60).isel(record=0, height=0, friction=0)
    assert float(bounds["boundary"]) == pytest.approx(0.35)
    # Scrambles of 0.875/0.375 and 0.625/0.125.
    assert float(bounds["boundary_low"]) == pytest.approx(0.3 + 0.1 * 0.125 / 0.5)
    assert float(bounds["boundary_high"]) == pytest.approx(0.3 + 0.1 * 0.375 / 0.5)
    assert float(bounds["crossing_low"][0]) == pytest.approx(float(bounds["boundary_low"]))
    assert float(bounds["crossing_high"][0]) == pytest.approx(float(bounds["boundary_high"]))
    assert bounds["crossing_low"][1:].isnull().all()


def test_lazy_is_the_same(make_cube, sector) -> None:
    cube = make_cube(sector(60, 20, largest=0.3))
    lazy = boundary(cube.chunk({"azimuth": 10, "b_over_h": 2}))
    assert lazy["crossing_b_over_h"].chunks is not None
    xr.testing.assert_allclose(lazy.compute(), boundary(cube))


def test_nothing_falls(make_cube) -> None:
    cube = make_cube(lambda azimuth, *_rest: np.zeros_like(azimuth))
    easiest = easiest_azimuth(boundary(cube), cube["b_over_h"])
    assert easiest["easiest_axis"].isnull().all()
    assert easiest["ratio"].isnull().all()
