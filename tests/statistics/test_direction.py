"""Shares, mean directions and axes of cubes whose answer is known."""

import numpy as np
import pytest
import xarray as xr

from overturning.errors import ResultError
from overturning.model.falls import model_of
from overturning.model.planes import Planes, fall_probability, plane_index, plane_weight
from overturning.statistics.direction import fall_axis, fall_direction, fall_shares
from overturning.statistics.falls import falls_towards, whole_circle


def test_a_plane_is_counted_once(make_cube, sector) -> None:
    cube = make_cube(sector(60, 20))
    whole = fall_shares(cube)["share_overturned"]
    half = fall_shares(cube.isel(azimuth=cube["azimuth"] < 180))["share_overturned"]
    assert whole.values == pytest.approx(9 / 36)  # 40° to 80° by 5° of 36 planes
    xr.testing.assert_allclose(whole, half)
    assert model_of(cube).falls(cube).sizes["azimuth"] == 36


def test_direction_and_axis(make_cube, sector) -> None:
    cube = make_cube(sector(60, 20))
    assert fall_direction(cube)["mean_direction"].values == pytest.approx(60)
    assert fall_axis(cube)["mean_axis"].values == pytest.approx(60)
    opposite = make_cube(sector(60, 20, side=-1))
    assert fall_direction(opposite)["mean_direction"].values == pytest.approx(240)
    assert fall_axis(opposite)["mean_axis"].values == pytest.approx(60)


def test_falls_both_ways_have_an_axis_and_no_direction(make_cube) -> None:
    def rule(azimuth, height, slender, friction):
        near = np.abs((azimuth - 30 + 90) % 180 - 90) <= 10
        return np.where(near, np.where(azimuth.astype(int) % 2 == 0, 1, -1), 0)

    cube = make_cube(rule, azimuth=range(360))
    assert fall_axis(cube)["mean_axis"].values == pytest.approx(30)
    # Eleven planes towards, ten away: nearly, not exactly, cancelled.
    assert (fall_direction(cube)["direction_resultant"] < 0.06).all()
    assert (fall_axis(cube)["axis_resultant"] > 0.9).all()


def test_nothing_fell(make_cube) -> None:
    cube = make_cube(lambda azimuth, *_rest: np.zeros_like(azimuth))
    assert (fall_shares(cube)["share_overturned"] == 0).all()
    for answer in (fall_direction(cube), fall_axis(cube)):
        assert all(variable.isnull().all() for variable in answer.values())


def test_everything_fell_alike(make_cube) -> None:
    cube = make_cube(lambda azimuth, *_rest: np.where(azimuth < 180, 1, -1))
    axis = fall_axis(cube)
    assert (fall_shares(cube)["share_overturned"] == 1).all()
    assert axis["mean_axis"].isnull().all()
    assert axis["axis_resultant"].values == pytest.approx(0, abs=1e-9)


def test_missing_is_not_standing(make_cube, sector) -> None:
    cube = make_cube(sector(60, 20))
    cube["overturned"] = cube["overturned"].where(cube["azimuth"] % 180 != 0)
    shares = fall_shares(cube)
    assert shares["share_overturned"].values == pytest.approx(9 / 35)
    assert shares["share_missing"].values == pytest.approx(1 / 36)
    raw = cube.assign(overturned=cube["overturned"].fillna(-128).astype("int8"))
    xr.testing.assert_allclose(fall_shares(raw), shares)
    assert fall_shares(cube.where(False))["share_overturned"].isnull().all()


def test_over_more_dimensions(make_cube, sector) -> None:
    cube = make_cube(sector(60, 20, largest=0.3))
    shares = fall_shares(cube, over=Planes.case_dims)
    assert float(shares["share_overturned"][0]) == pytest.approx(9 / 36 * 3 / 5)
    assert shares["share_overturned"].dims == ("record",)


def test_lazy_is_the_same(make_cube, sector) -> None:
    cube = make_cube(sector(100, 30), events=("A", "B", "C"))
    lazy = cube.chunk({"record": 1, "azimuth": 12})
    for function in (fall_shares, fall_direction, fall_axis):
        answer = function(lazy)
        assert all(variable.chunks is not None for variable in answer.values())
        xr.testing.assert_allclose(answer.compute(), function(cube))


def test_extra_azimuths_share_a_weight(make_cube, sector) -> None:
    regular = make_cube(sector(60, 20))
    extra = make_cube(sector(60, 20), azimuth=sorted([*range(0, 360, 5), 61, 62, 63, 64, 241, 242, 243, 244]))
    assert plane_weight(extra["azimuth"].values[plane_index(extra["azimuth"].values)]).sum() == pytest.approx(1)
    assert float(fall_shares(extra, over=("record", *Planes.case_dims))["share_overturned"]) == pytest.approx(9 / 36)
    assert fall_axis(extra)["mean_axis"].values == pytest.approx(fall_axis(regular)["mean_axis"].values, abs=0.01)


def test_a_scene_without_mirror_image_is_two_cases_at_opposite_azimuths(make_cube) -> None:
    """It falls away from its wall: towards the azimuth of every motion, from 0 to 175° only, from 180° on it stands."""
    cube = make_cube(lambda azimuth, *_: np.where(azimuth < 180, 1, 0))
    cube["azimuth"].attrs["period"] = 360.0
    assert fall_shares(cube)["share_overturned"].values == pytest.approx(0.5)
    falling = make_cube(lambda azimuth, *_: np.ones_like(azimuth))
    falling["azimuth"].attrs["period"] = 360.0
    assert fall_direction(falling)["direction_resultant"].values == pytest.approx(0, abs=1e-9)
    xr.testing.assert_identical(whole_circle(cube), cube)
    towards = falls_towards(cube.isel(record=0, height=0, b_over_h=0, friction=0))
    assert towards.sel(azimuth=[0, 175, 180, 355]).values.tolist() == [1, 1, 0, 0]
    away = falls_towards(-cube.isel(record=0, height=0, b_over_h=0, friction=0))
    assert away.sel(azimuth=[0, 175, 180, 355]).values.tolist() == [0, 0, 1, 1]
    # The whole of the eastern half, seen from −2.5 to 177.5°: its middle is 87.5°.
    assert fall_direction(cube)["mean_direction"].values == pytest.approx(87.5)


def test_ensemble_before_flag(make_cube, sector) -> None:
    cube = make_cube(sector(60, 20))
    towards = xr.full_like(cube["overturned"], np.nan)
    towards[{"b_over_h": 1}] = 0.25
    cube = cube.assign(probability_towards=towards, probability_away=towards * 0 + 0.5)
    p = fall_probability(cube)
    assert (p["towards"].isel(b_over_h=1) == 0.25).all()
    assert (p["away"].isel(b_over_h=1) == 0.5).all()
    nominal = fall_probability(cube, ensemble=False)
    xr.testing.assert_equal(p.isel(b_over_h=0), nominal.isel(b_over_h=0))
    assert set(np.unique(nominal["towards"])) == {0, 1}


def test_a_single_azimuth(make_cube) -> None:
    cube = make_cube(lambda azimuth, *_rest: np.ones_like(azimuth), azimuth=(32,))
    assert fall_axis(cube)["mean_axis"].values == pytest.approx(32)
    assert (fall_shares(cube)["share_overturned"] == 1).all()


def test_not_a_cube() -> None:
    with pytest.raises(ResultError, match="overturned"):
        fall_probability(xr.Dataset({"x": 1}))
