"""Overturning boundaries along B/H."""

import numpy as np
import pytest
import xarray as xr

from overturning.statistics.boundary import (
    boundary_b_over_h_and_whether_stoutest_falls,
    easiest_axis_and_extreme_overturning_boundaries,
    overturning_boundary_b_over_h_by_azimuth,
)


@pytest.mark.parametrize(
    ("probability", "crossing", "falls"),
    [
        ([1, 1, 0, 1, 0.25, 0], 0.4 + 0.1 * 0.5 / 0.75, False),
        ([1, 0.25, 0, 0, 0, 0], 0.1 + 0.1 * 0.5 / 0.75, False),
        ([0, 0, 0, 0, 0.25, 1], 0.5 + 0.1 * 0.25 / 0.75, True),
        ([0, 0, 0, 0, 0, 0], np.nan, False),
        ([1, 1, 1, 1, 1, 1], np.nan, True),
        # Neighbours of a gap are joined across it; the last known value is the end.
        ([1, np.nan, 0, 0, np.nan, np.nan], 0.2, False),
        ([0, 1, np.nan, np.nan, np.nan, np.nan], 0.15, True),
        ([np.nan] * 6, np.nan, False),
    ],
)
def test_boundary_is_the_last_b_over_h_where_probability_crosses_one_half(
    probability: list[float], crossing: float, falls: bool
) -> None:
    found = boundary_b_over_h_and_whether_stoutest_falls(probability, [0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    assert found == (pytest.approx(crossing, nan_ok=True), falls)


def test_overturning_boundary_is_half_a_step_of_b_over_h_above_the_last_fall(
    make_cube_from_fall_rules, make_sector_fall_rule
) -> None:
    cube = make_cube_from_fall_rules(make_sector_fall_rule(60, 20, largest_b_over_h=0.3))
    bounds = overturning_boundary_b_over_h_by_azimuth(cube)
    inside = bounds["boundary"].sel(azimuth=[60, 75, 240])
    assert inside.values == pytest.approx(0.35)
    assert bounds["boundary"].sel(azimuth=150).isnull().all()
    assert bounds["stands_throughout"].sel(azimuth=150).all()
    assert not bounds["falls_beyond"].any()
    assert easiest_axis_and_extreme_overturning_boundaries(bounds, cube["b_over_h"])[
        "easiest_axis"
    ].values == pytest.approx(60)


def test_falls_at_the_largest_b_over_h_leave_the_boundary_unknown(
    make_cube_from_fall_rules, make_sector_fall_rule
) -> None:
    cube = make_cube_from_fall_rules(make_sector_fall_rule(60, 20))
    bounds = overturning_boundary_b_over_h_by_azimuth(cube)
    assert bounds["falls_beyond"].sel(azimuth=60).all()
    assert bounds["boundary"].isnull().all()
    easiest = easiest_axis_and_extreme_overturning_boundaries(bounds, cube["b_over_h"])
    assert not easiest["bounded"].any()
    assert easiest["ratio"].values == pytest.approx(0.5 / 0.1)


def test_boundary_is_only_known_to_exceed_the_last_b_over_h_with_an_outcome(
    make_cube_from_fall_rules, make_sector_fall_rule
) -> None:
    """Towards 60° outcomes above B/H 0.3 are missing: the boundary lies above 0.3, not above 0.5."""
    cube = make_cube_from_fall_rules(make_sector_fall_rule(60, 20))
    untold = (cube["azimuth"] % 180 == 60) & (cube["b_over_h"] > 0.3)
    bounds = overturning_boundary_b_over_h_by_azimuth(cube.assign(overturned=cube["overturned"].where(~untold)))
    assert bounds["falls_beyond"].sel(azimuth=60).all()
    assert bounds["largest_known"].sel(azimuth=60).values == pytest.approx(0.3)
    assert bounds["largest_known"].sel(azimuth=65).values == pytest.approx(0.5)
    easiest = easiest_axis_and_extreme_overturning_boundaries(bounds.sel(azimuth=[60, 150, 240, 330]), cube["b_over_h"])
    assert easiest["highest_boundary"].values == pytest.approx(0.3)
    assert not easiest["bounded"].any()


def test_boundary_ratio_of_easiest_to_hardest_plane_matches_the_fall_rule(make_cube_from_fall_rules) -> None:
    def signed_falls_below_limiting_b_over_h(azimuth, height, slender, friction):
        limit = 0.25 + 0.2 * np.cos(np.radians(azimuth - 30)) ** 2
        return np.where(slender <= limit, np.where(np.cos(np.radians(azimuth - 30)) >= 0, 1, -1), 0)

    cube = make_cube_from_fall_rules(
        signed_falls_below_limiting_b_over_h, b_over_h=np.round(np.arange(0.1, 0.6, 0.01), 2)
    )
    easiest = easiest_axis_and_extreme_overturning_boundaries(
        overturning_boundary_b_over_h_by_azimuth(cube), cube["b_over_h"]
    )
    assert easiest["easiest_axis"].values == pytest.approx(30, abs=0.1)
    assert easiest["ratio"].values == pytest.approx(0.455 / 0.255, abs=0.02)
    assert easiest["bounded"].all()


def test_boundary_interval_spans_the_boundaries_of_both_sobol_scrambles(
    make_cube_from_fall_rules, make_sector_fall_rule
) -> None:
    cube = make_cube_from_fall_rules(make_sector_fall_rule(60, 20, largest_b_over_h=0.3))
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
    bounds = overturning_boundary_b_over_h_by_azimuth(cube).sel(azimuth=60).isel(record=0, height=0, friction=0)
    assert float(bounds["boundary"]) == pytest.approx(0.35)
    # Scrambles of 0.875/0.375 and 0.625/0.125.
    assert float(bounds["boundary_low"]) == pytest.approx(0.3 + 0.1 * 0.125 / 0.5)
    assert float(bounds["boundary_high"]) == pytest.approx(0.3 + 0.1 * 0.375 / 0.5)


@pytest.mark.parametrize(
    ("probability", "difference", "boundary", "low", "high"),
    [
        # One half of the ensemble still falls at the largest B/H.
        ([1, 1, 0.75, 0.45], [0, 0, 0.2, 0.2], 0.3 + 0.1 * 0.25 / 0.3, 0.35, 0.4),
        # That half, of 1, 0.45, 0.65, 0.55, stands at 0.2: its only crossing is from standing to falling.
        ([1, 0.55, 0.55, 0.45], [0, -0.2, 0.2, 0.2], 0.35, 0.3 - 0.1 * 0.05 / 0.2, 0.4),
        # One half never falls.
        ([0.55, 0.2, 0.1, 0], [0.2, 0, 0, 0], 0.1 + 0.1 * 0.05 / 0.35, 0.1, 0.1 + 0.1 * 0.15 / 0.45),
        # Both halves fall farther than the mean of the two.
        ([0.7, 0.4, 0.4, 0], [0, 0.4, -0.4, 0], 0.1 + 0.1 * 0.2 / 0.3, 0.1 + 0.1 * 0.2 / 0.3, 0.3 + 0.1 * 0.1 / 0.6),
    ],
)
def test_boundary_interval_from_ensemble_halves_includes_the_boundary(
    probability: list[float], difference: list[float], boundary: float, low: float, high: float
) -> None:
    def variable_on_azimuth_and_b_over_h(values: list[float]) -> tuple[tuple[str, str], np.ndarray]:
        return ("azimuth", "b_over_h"), np.array([values], np.float64)

    cube = xr.Dataset(
        {
            "overturned": variable_on_azimuth_and_b_over_h([float(p >= 0.5) for p in probability]),
            "probability_towards": variable_on_azimuth_and_b_over_h(probability),
            "probability_away": variable_on_azimuth_and_b_over_h([0.0] * 4),
            "scramble_difference_towards": variable_on_azimuth_and_b_over_h(difference),
            "scramble_difference_away": variable_on_azimuth_and_b_over_h([0.0] * 4),
        },
        {"azimuth": ("azimuth", [0.0], {"period": 180.0}), "b_over_h": [0.1, 0.2, 0.3, 0.4]},
    )
    found = overturning_boundary_b_over_h_by_azimuth(cube).isel(azimuth=0)
    ends = [float(found[name]) for name in ("boundary", "boundary_low", "boundary_high")]
    assert ends == pytest.approx([boundary, low, high])


def test_boundary_of_a_lazy_cube_is_that_of_a_loaded_one(make_cube_from_fall_rules, make_sector_fall_rule) -> None:
    cube = make_cube_from_fall_rules(make_sector_fall_rule(60, 20, largest_b_over_h=0.3))
    lazy = overturning_boundary_b_over_h_by_azimuth(cube.chunk({"azimuth": 10, "b_over_h": 2}))
    assert lazy["boundary"].chunks is not None
    xr.testing.assert_allclose(lazy.compute(), overturning_boundary_b_over_h_by_azimuth(cube))


def test_missing_outcomes_do_not_count_as_falls_in_the_boundary(make_cube_from_fall_rules) -> None:
    cube = make_cube_from_fall_rules(lambda azimuth, *_rest: np.zeros_like(azimuth))
    cube["overturned"][{"b_over_h": 2}] = np.nan
    assert overturning_boundary_b_over_h_by_azimuth(cube)["stands_throughout"].all()
    easiest = easiest_axis_and_extreme_overturning_boundaries(
        overturning_boundary_b_over_h_by_azimuth(cube), cube["b_over_h"]
    )
    assert easiest["easiest_axis"].isnull().all()
    assert easiest["ratio"].isnull().all()


def test_a_plane_without_outcomes_is_not_taken_as_the_hardest_to_overturn(make_cube_from_fall_rules) -> None:
    """Blocks fall up to B/H = 0.3 ± 0.1, along 60° more easily than across.

    The plane of 30°, which has no outcomes, does not change the ratio of the boundaries.
    """
    cube = make_cube_from_fall_rules(
        lambda a, _, s, __: np.where(s <= 0.3 + 0.1 * np.cos(np.radians(2 * (a - 60))), 1, 0)
    )
    cube["overturned"][{"azimuth": cube["azimuth"] % 180 == 30}] = np.nan
    easiest = easiest_axis_and_extreme_overturning_boundaries(
        overturning_boundary_b_over_h_by_azimuth(cube), cube["b_over_h"]
    )
    assert np.unique(easiest["ratio"]) == pytest.approx([3.0])
    assert easiest["bounded"].all()
    cube["overturned"][:] = cube["overturned"] * 0
    assert (
        easiest_axis_and_extreme_overturning_boundaries(
            overturning_boundary_b_over_h_by_azimuth(cube), cube["b_over_h"]
        )["ratio"]
        .isnull()
        .all()
    )
