import numpy as np
import xarray as xr

from overturning.statistics.falls import falls_towards, overturns
from overturning.statistics.fault import axial_distance, compare_group, shares_by_direction


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


def test_axial_distance_does_not_tell_opposites_apart() -> None:
    np.testing.assert_allclose(axial_distance(np.array([10.0, 190.0, 100.0, 355.0]), 10.0), [0, 0, 90, 15])


def records() -> xr.Dataset:
    azimuth = np.arange(0, 360, 10, dtype=np.int16)
    # Two records of one earthquake whose planes near N30E overturn, one of another that overturns near N120E.
    near = axial_distance(azimuth.astype(float), 30.0) <= 20
    along = axial_distance(azimuth.astype(float), 120.0) <= 20
    flags = np.stack([near, np.zeros_like(near), along]).astype(float)
    return xr.Dataset(
        {"overturned": (("record", "azimuth", "height", "b_over_h", "friction"), flags[:, :, None, None, None])},
        coords={
            "azimuth": azimuth,
            "fault_normal": ("record", [30.0, 30.0, 30.0]),
            "event": ("record", ["one", "one", "other"]),
            "pulse": ("record", [1.0, 1.0, 1.0]),
        },
    )


def test_earthquakes_are_counted_and_their_records_averaged_first() -> None:
    shares = shares_by_direction(records())
    np.testing.assert_allclose(shares["normal"], [1.0, 0.0, 0.0])
    np.testing.assert_allclose(shares["parallel"], [0.0, 0.0, 1.0])
    group = compare_group(shares, "all")
    assert (group.records, group.earthquakes, group.falling) == (3, 2, 2)
    assert (group.more_normal, group.more_parallel) == (1, 1)
    assert (group.normal, group.parallel) == (0.25, 0.5)


def test_unknown_faults_take_no_part() -> None:
    unknown = records().assign_coords(fault_normal=("record", [np.nan, np.nan, np.nan]))
    group = compare_group(shares_by_direction(unknown), "all")
    assert group.falling == 0
    assert np.isnan(group.normal)
