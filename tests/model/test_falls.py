"""Falls of each model, by hand."""

import numpy as np
import pytest
import xarray as xr

from overturning.model.body import Body
from overturning.model.falls import default_model_of_same_kind_as_results_cube
from overturning.model.planes import PlanarModel

NAMES_OF_FALL_MEASURES = ("falls", "direction_cosine", "direction_sine", "axis_cosine", "axis_sine")


def test_a_planar_fall_is_counted_towards_or_away_from_its_azimuth() -> None:
    """¾ of the ensemble runs fall, three to the east for each to the west; outcomes at azimuth 0° are missing."""
    cube = xr.Dataset(
        {
            "overturned": ("azimuth", [np.nan, 1.0, np.nan, -1.0]),
            "probability_towards": ("azimuth", [np.nan, 0.5625, np.nan, 0.1875]),
            "probability_away": ("azimuth", [np.nan, 0.1875, np.nan, 0.5625]),
        },
        {"azimuth": [0, 90, 180, 270]},
    )
    assert isinstance(default_model_of_same_kind_as_results_cube(cube), PlanarModel)
    members, nominal = (
        default_model_of_same_kind_as_results_cube(cube).fall_probability_and_direction_by_case(cube, use_ensemble=one)
        for one in (True, False)
    )
    assert members["azimuth"].values.tolist() == [0, 90]
    assert members["weight"].values.tolist() == [0.5, 0.5]
    assert np.isnan([members[name].values[0] for name in NAMES_OF_FALL_MEASURES]).all()
    np.testing.assert_allclose(
        [members[name].values[1] for name in NAMES_OF_FALL_MEASURES], [0.75, 0, 0.375, -0.75, 0], atol=1e-15
    )
    np.testing.assert_allclose(
        [nominal[name].values[1] for name in NAMES_OF_FALL_MEASURES], [1, 0, 1, -1, 0], atol=1e-15
    )


def test_the_fall_direction_of_a_3d_body_is_its_fall_azimuth() -> None:
    """A body that faces north falls to the south-east; facing 45° it stands; at 60° its outcome is missing."""
    cube = xr.Dataset(
        {"overturned": ("orientation", [1.0, 0.0, np.nan]), "fall_azimuth": ("orientation", [135.0, np.nan, np.nan])},
        {"orientation": [0, 45, 60]},
    )
    assert isinstance(default_model_of_same_kind_as_results_cube(cube), Body)
    found = default_model_of_same_kind_as_results_cube(cube).fall_probability_and_direction_by_case(cube)
    np.testing.assert_allclose(found["weight"], 1 / 3)
    half = np.sqrt(0.5)
    values = np.array([found[name].values for name in NAMES_OF_FALL_MEASURES])
    np.testing.assert_allclose(values[:, 0], [1, -half, half, 0, -1], atol=1e-15)
    assert values[:, 1].tolist() == [0] * 5
    assert np.isnan(values[:, 2]).all()


@pytest.mark.parametrize(("spread", "apart"), [(14.0, False), (16.0, True)])
def test_members_that_all_fall_are_apart_if_their_azimuths_spread_beyond_15_degrees(spread: float, apart: bool) -> None:
    """Half of the ensemble members fall `spread` degrees clockwise of north, half as much anticlockwise of it."""
    cube = xr.Dataset(
        {
            "probability_falls": ("orientation", [1.0, 0.5]),
            "fall_north": ("orientation", [np.cos(np.radians(spread)), 0.1]),
            "fall_east": ("orientation", [0.0, 0.0]),
        },
        {"orientation": [0, 45]},
    )
    found = Body().ensemble_fall_shares_by_side_and_case(cube)
    assert found["agree"].values.tolist() == [True, False]
    assert found["apart"].values.tolist() == [apart, False]
