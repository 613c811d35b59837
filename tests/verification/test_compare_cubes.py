"""Changes from cube to cube, against counts by hand on cubes that are written out here."""

import numpy as np
import pytest
import xarray as xr

from overturning.errors import ResultError
from verification.compare_cubes import outcome_change_texts_by_quantity

DIMENSIONS = ("record", "azimuth", "b_over_h")


def cube_of_flags(flags: list[list[float]], rotation: float = 0.5, slip: float = 0.01, record: str = "a") -> xr.Dataset:
    """Cube of one record, four azimuths and two B/H; standing cases have the given peak rotation and slip."""
    overturned = np.array([flags])
    stands = overturned == 0
    values = {
        "overturned": overturned,
        "status": np.where(np.isnan(overturned), 2.0, 0.0),
        "peak_rotation": np.where(stands, rotation, 1.0),
        "peak_slip": np.where(stands, slip, 0.0),
    }
    coordinates = {"record_id": ("record", [record]), "azimuth": [0, 90, 180, 270], "b_over_h": [0.2, 0.3]}
    return xr.Dataset({name: (DIMENSIONS, array) for name, array in values.items()}, coordinates)


OLD_CUBE = cube_of_flags([[1, 1], [1, 1], [1, 0], [1, 0]])


def test_changes_between_two_cubes_are_counted() -> None:
    new = cube_of_flags([[-1, 1], [0, 1], [np.nan, 0], [1, 0]], rotation=0.6, slip=0.009)
    found = outcome_change_texts_by_quantity(OLD_CUBE, new)
    assert found["cells"] == "8"
    assert found["fall, before"] == "6 (75.00 %)"
    assert found["fall, after"] == "4 (57.14 %)"
    assert found["without an answer, before and after"] == "0, 1"
    assert found["cells with another status"] == "1"
    assert found["flags changed"] == "1"
    assert found["sides changed, of what falls in both"] == "1 of 4"
    # Of B/H 0.2 all azimuths fall, and of 0.3 the first two: their neighbours in B/H agree, and around the circle.
    assert found["of them where the neighbours agree"] == "1"
    assert found["of these where the neighbours agree"] == "1 of 1"
    assert found["peak rotation of what rocks and stands: change in α, median and 95 %"] == "+0.1, 0.1"
    assert found["peak slip of what stands: change in %, median and 95 %"] == "-10, 10"


def test_cubes_with_different_grid_values_are_not_compared() -> None:
    new = cube_of_flags([[1, 1]] * 4).assign_coords(b_over_h=[0.2, 0.4])
    with pytest.raises(ResultError, match="cubes of different b_over_h values; compare those of one study"):
        outcome_change_texts_by_quantity(OLD_CUBE, new)


def test_the_first_and_last_azimuth_of_a_cube_count_as_neighbours() -> None:
    # Beside the first azimuth of B/H 0.3 lies the last one, which stands: neither its fall nor the second's is firm.
    found = outcome_change_texts_by_quantity(OLD_CUBE, cube_of_flags([[1, 0], [1, 1], [1, 0], [1, 0]]))
    assert (found["flags changed"], found["of them where the neighbours agree"]) == ("1", "0")


def test_3d_falls_are_robust_only_if_neighbours_fall_in_the_same_direction() -> None:
    """Two changed fall directions are not robust, since in the old cube they differ from those of the neighbours.

    In the old cube, bodies fall east at the second of four orientations; all others fall north or nearly so.
    """
    old, new = cube_of_flags([[1, 1]] * 4), cube_of_flags([[1, 1]] * 4)
    for one, second in ((old, 90.0), (new, 0.0)):
        one["fall_azimuth"] = DIMENSIONS, np.array([[[0.0, 0.0], [second, second], [0.0, 0.0], [350.0, 350.0]]])
        one["peak_tilt"] = DIMENSIONS, np.full((1, 4, 2), 90.0)
    found = outcome_change_texts_by_quantity(old.rename(azimuth="orientation"), new.rename(azimuth="orientation"))
    assert found["sides changed, of what falls in both"] == "2 of 8"
    assert found["of these where the neighbours agree"] == "0 of 2"


def test_only_records_common_to_both_cubes_are_compared() -> None:
    other = cube_of_flags([[0, 0]] * 4, record="b")
    assert outcome_change_texts_by_quantity(
        xr.concat([other, OLD_CUBE], "record"), OLD_CUBE
    ) == outcome_change_texts_by_quantity(OLD_CUBE, OLD_CUBE)


def test_comparing_cubes_of_different_studies_is_refused() -> None:
    with pytest.raises(ResultError, match="of one study"):
        outcome_change_texts_by_quantity(OLD_CUBE, OLD_CUBE.isel(azimuth=slice(2)))
    with pytest.raises(ResultError, match="of one study"):
        outcome_change_texts_by_quantity(OLD_CUBE, cube_of_flags([[1, 1]] * 4, record="b"))


def test_slips_of_stack_cubes_are_compared_by_residual_slip() -> None:
    """Cubes of stacks have no peak slip; a residual slip of 4 mm to the north and 3 mm to the west counts as 5 mm."""

    def stack_cube_with_scaled_residual_slips(one: xr.Dataset, share: float) -> xr.Dataset:
        """Return a cube of stacks with residual slips of `share` times 4 mm to the north and 3 mm to the west."""
        still = xr.zeros_like(one.peak_slip)
        north, east = (still + share * value for value in (0.004, -0.003))
        return one.drop_vars("peak_slip").assign(residual_slip_north=north, residual_slip_east=east)

    changes = outcome_change_texts_by_quantity(
        stack_cube_with_scaled_residual_slips(OLD_CUBE, 1.0), stack_cube_with_scaled_residual_slips(OLD_CUBE, 1.1)
    )
    assert changes["peak slip of what stands: change in %, median and 95 %"] == "+10, 10"
