"""Groups of records by their coordinates."""

import numpy as np
import pytest
import xarray as xr

from overturning.errors import ArgumentError
from overturning.statistics import by_record
from overturning.statistics.by_record import record_masks_by_group
from overturning.statistics.earthquakes import (
    fall_axes_from_fault_normal_by_group,
    fall_sums_for_direction_statistics_by_record,
)


@pytest.fixture
def cube_of_records_with_grouping_variables(make_cube_from_fall_rules, make_sector_fall_rule):
    """Return a cube of four records, with wall (text), vs30 (number) and pulse (1 or 0) to group the records by."""
    rules = [make_sector_fall_rule(60.0 + offset, 10) for offset in (0, 0, 80, 80)]
    described = {"wall": ["hanging", "", "foot", "hanging"], "vs30": [200.0, 360.0, 800.0, np.nan]}
    made = make_cube_from_fall_rules(
        rules, azimuth=range(0, 360, 5), events=["A", "B", "C", "D"], fault_normal=60.0, pulse=[1, 1, 0, 0]
    )
    return made.assign_coords({name: ("record", values) for name, values in described.items()})


def test_statistics_of_records_in_batches_equal_those_of_single_records(
    cube_of_records_with_grouping_variables, monkeypatch
):
    together = fall_sums_for_direction_statistics_by_record(cube_of_records_with_grouping_variables, "b_over_h")
    for cells in (1, 2 * cube_of_records_with_grouping_variables["overturned"].size // 4):  # one at a time, and by two
        monkeypatch.setattr(by_record, "TARGET_CASES_PER_READ_BATCH", cells)
        xr.testing.assert_identical(
            fall_sums_for_direction_statistics_by_record(cube_of_records_with_grouping_variables, "b_over_h"), together
        )


def record_indices_by_group(groups):
    """Return the indices of the records of each group."""
    return {name: np.flatnonzero(mask).tolist() for name, mask in groups.items()}


def test_records_are_grouped_by_pulse_by_text_and_by_numeric_range(cube_of_records_with_grouping_variables):
    assert record_indices_by_group(record_masks_by_group(cube_of_records_with_grouping_variables)) == {
        "with a velocity pulse": [0, 1],
        "without (control)": [2, 3],
    }
    assert record_indices_by_group(record_masks_by_group(cube_of_records_with_grouping_variables, "wall")) == {
        "wall foot": [2],
        "wall hanging": [0, 3],
    }
    found = record_indices_by_group(
        record_masks_by_group(cube_of_records_with_grouping_variables, "vs30", [360.0, 760.0])
    )
    assert found == {"vs30 below 360": [0], "vs30 from 360 to below 760": [1], "vs30 from 760": [2]}


def test_fall_axes_are_computed_for_each_group_of_records(cube_of_records_with_grouping_variables):
    axes = fall_axes_from_fault_normal_by_group(cube_of_records_with_grouping_variables, "vs30", [500.0])
    assert list(axes) == ["vs30 below 500", "vs30 from 500"]
    assert axes["vs30 below 500"]["axis"].values == pytest.approx([0, 0], abs=1e-6)
    assert axes["vs30 from 500"]["axis"].values == pytest.approx([80])


def test_error_names_an_unknown_coordinate_by_which_to_group_records(cube_of_records_with_grouping_variables):
    with pytest.raises(ArgumentError, match=r"coordinate: 'geology'; records are described by .*vs30, wall"):
        record_masks_by_group(cube_of_records_with_grouping_variables, "geology")
    with pytest.raises(ArgumentError, match="edges"):
        record_masks_by_group(cube_of_records_with_grouping_variables, "vs30")
    with pytest.raises(ArgumentError, match="ascending"):
        record_masks_by_group(cube_of_records_with_grouping_variables, "vs30", [700.0, 360.0])
