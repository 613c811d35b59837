import numpy as np
import xarray as xr

from overturning.statistics.elements import falls_by_element
from overturning.statistics.falls import falls_towards, near_boundary, overturns


def cube(azimuth: list[int], overturned: list[float]) -> xr.Dataset:
    return xr.Dataset(
        {"overturned": ("azimuth", np.array(overturned))}, coords={"azimuth": np.array(azimuth, np.int16)}
    )


def test_each_fall_stands_once_at_the_azimuth_it_goes_to() -> None:
    # A block under 30° falls back to 210°; the opposite motion says the same.
    both = falls_towards(cube([30, 120, 210, 300], [-1, 0, 1, 0]))
    assert both.to_series().to_dict() == {30: 0, 120: 0, 210: 1, 300: 0}


def test_opposites_that_the_cube_does_not_hold_are_added() -> None:
    half = falls_towards(cube([30, 120], [-1, 1]))
    assert half.to_series().to_dict() == {30: 0, 120: 1, 210: 1, 300: 0}


def test_missing_outcomes_stay_missing() -> None:
    known = falls_towards(cube([0, 180], [np.nan, np.nan]))
    assert np.isnan(known).all()
    np.testing.assert_array_equal(overturns(cube([0, 90], [np.nan, -1])), [np.nan, 1])


def test_lazy_cubes_stay_lazy() -> None:
    lazy = falls_towards(cube([0, 90, 180, 270], [1, 0, -1, 0]).chunk({"azimuth": 2}))
    assert lazy.chunks is not None


def test_blocks_near_the_boundary_fall_in_some_planes_and_in_at_most_half() -> None:
    flags = np.array([[0, 1, 1, 1], [0, 0, -1, -1], [0, 0, 1, np.nan], [0, 0, 0, 1]], dtype=float)
    data = xr.Dataset({"overturned": (("azimuth", "b_over_h"), flags)}, coords={"azimuth": [0, 45, 90, 135]})
    assert near_boundary(data).values.tolist() == [False, True, False, False]
    assert near_boundary(data.isel(azimuth=[0, 1, 3], b_over_h=[2])).values.tolist() == [False]


def test_something_falls_where_any_element_does() -> None:
    """Of five cases one has no outcome; in the others none, the lintel, a pillar before it, and the pillar fall."""
    flags = np.array([[[0, 0], [0, 1], [-1, 1], [1, 0], [np.nan, np.nan]]])
    times = np.array([[[np.nan, np.nan], [np.nan, 3.0], [1.0, 2.0], [5.0, np.nan], [np.nan, np.nan]]])
    dims = ("record", "azimuth", "element")
    made = xr.Dataset(
        {"overturned": (dims, flags), "overturning_time": (dims, times)}, {"element": ["pillar", "lintel"]}
    )
    pillar, lintel, anything = falls_by_element(made)
    assert (pillar.cases, pillar.falls, pillar.first) == (4, 2, 2)
    assert (lintel.cases, lintel.falls, lintel.first) == (4, 2, 1)
    assert (anything.cases, anything.falls, anything.share, anything.median_time) == (4, 3, 0.75, 3.0)
