"""The first film shows two blocks that both move."""

import numpy as np
import xarray as xr

from overturning.statistics.illustrative import illustrative_cases

DIMS = ("record", "azimuth", "height", "b_over_h", "friction")


def cube(rocks: list[float]) -> xr.Dataset:
    """Falls along the fault normal, 0°, at both B/H; along the fault the blocks stand and rock so far."""
    flags = np.zeros((1, 4, 1, 2, 1))
    flags[:, 0], flags[:, 2] = 1, -1
    rotation = np.ones_like(flags)
    rotation[:, 1] = rotation[:, 3] = np.reshape(rocks, (1, 2, 1))
    return xr.Dataset(
        {"overturned": (DIMS, flags), "peak_rotation": (DIMS, rotation)},
        coords={
            "azimuth": [0, 90, 180, 270],
            "height": [0.6],
            "b_over_h": [0.2, 0.4],
            "friction": [1.0],
            "fault_normal": ("record", [0.0]),
        },
    )


def test_of_two_blocks_the_one_that_rocks_along_the_fault_too() -> None:
    assert illustrative_cases(cube([0.5, 0.0]))[0].block["b_over_h"] == 0.2
    assert illustrative_cases(cube([0.5, 0.5]))[0].block["b_over_h"] == 0.4, "of those that rock the broadest"
    assert illustrative_cases(cube([0.0, 0.0]))[0].block["b_over_h"] == 0.4, "where none rocks, one that only stands"


def test_the_closest_call_is_the_largest_rotation_of_what_stands_and_none_where_nothing_moves() -> None:
    def closest(rocks: list[float]) -> list[float]:
        return [
            case.block["b_over_h"] for case in illustrative_cases(cube(rocks)) if case.title == "Stands, but only just"
        ]

    assert closest([0.3, 0.7]) == [0.4]
    assert closest([0.3, 0.0]) == [0.2]
    assert closest([0.0, 0.0]) == []
