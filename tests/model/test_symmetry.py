"""Cells that represent others by symmetry, by hand."""

import numpy as np
import pytest

from overturning.model.plane_weights import plane_weights_by_azimuth_spacing
from overturning.model.symmetry import (
    copy_with_mirrored_planes_marked,
    first_equivalent_of_each_direction,
    nearest_simulated_directions,
    nearest_simulated_planes,
)


@pytest.mark.parametrize(
    ("azimuth", "asked", "cell", "mirrored"),
    [
        ([0, 60, 120], [250, 70, 359, 181, 62], [1, 1, 0, 0, 1], [True, False, False, True, False]),
        ([180, 240, 300], [250, 70, 359, 1], [1, 1, 0, 0], [False, True, True, True]),
        # What the grid holds itself is not taken from behind.
        ([70, 250], [250, 70, 245], [1, 0, 1], [False, False, False]),
        # Half way the plane before it, anticlockwise, also across north and from behind.
        ([0, 90, 180, 270], [45, 315, 225, -45], [0, 3, 2, 3], [False] * 4),
        ([0, 90], [45, 135, 225, 315], [0, 1, 0, 1], [False, False, True, True]),
        ([30], [29, 119, 121, 210], [0, 0, 0, 0], [False, False, True, True]),
    ],
)
def test_the_nearest_simulated_plane_is_selected_and_mirrored_if_needed(
    azimuth: list[float], asked: list[float], cell: list[int], mirrored: list[bool]
) -> None:
    found = nearest_simulated_planes(azimuth, asked)
    assert found.simulated_direction_index.tolist() == cell
    assert found.is_mirrored.tolist() == mirrored
    assert found.clockwise_rotation_from_simulated_deg.tolist() == [180.0 * one for one in mirrored]


def test_the_nearest_simulated_orientation_is_selected_by_rotational_symmetry() -> None:
    """Orientations 0, 30 and 60° serve all azimuths at a symmetry of 90° (square), but not without one (360°)."""
    found = nearest_simulated_directions([0, 30, 60], [1, 121, 260, -29], 90.0)
    assert (found.simulated_direction_index.tolist(), found.clockwise_rotation_from_simulated_deg.tolist()) == (
        [0, 1, 0, 2],
        [0, 90, 270, 270],
    )
    assert nearest_simulated_directions([0, 30, 60], [200, 220, 359], 360.0).simulated_direction_index.tolist() == [
        2,
        0,
        0,
    ]
    column = nearest_simulated_directions([5], [200, 5], 0.0)
    assert (column.simulated_direction_index.tolist(), column.clockwise_rotation_from_simulated_deg.tolist()) == (
        [0, 0],
        [195, 0],
    )
    assert not found.is_mirrored.any()


def test_grid_directions_equal_by_symmetry_share_the_cell_of_the_first_one() -> None:
    planes = copy_with_mirrored_planes_marked(
        first_equivalent_of_each_direction(np.array([0, 30, 180, 210, 359, 0]), 180.0), 180.0
    )
    assert planes.simulated_direction_index.ravel().tolist() == [0, 1, 0, 1, 4, 0]
    assert planes.is_mirrored.ravel().tolist() == [False, False, True, True, False, False]
    assert first_equivalent_of_each_direction([5], 0.0).simulated_direction_index.tolist() == [[0]]
    bodies = first_equivalent_of_each_direction(np.arange(0, 180, 30), [90.0, 180.0, 0.0])
    assert bodies.simulated_direction_index.T.tolist() == [[0, 1, 2, 0, 1, 2], [0, 1, 2, 3, 4, 5], [0] * 6]
    assert bodies.clockwise_rotation_from_simulated_deg[:, 0].tolist() == [0, 0, 0, 90, 90, 90]


def test_rotational_symmetry_of_360_over_7_degrees_is_recognised() -> None:
    """Orientations of a seven-sided prism that differ by multiples of 360/7 degrees count as one."""
    turns = 10 + np.arange(7) * 360 / 7
    assert first_equivalent_of_each_direction(turns, 360 / 7).simulated_direction_index.ravel().tolist() == [0] * 7
    assert nearest_simulated_directions([10, 30], turns, 360 / 7).simulated_direction_index.tolist() == [0] * 7


@pytest.mark.parametrize(
    ("planes", "weights"),
    [
        ([0, 90], [1 / 2, 1 / 2]),
        ([0, 45, 90, 135], [1 / 4] * 4),
        ([0, 30, 90], [(90 + 30) / 360, (30 + 60) / 360, (60 + 90) / 360]),
        ([0, 10, 90, 100], [(80 + 10) / 360, (10 + 80) / 360, (80 + 10) / 360, (10 + 80) / 360]),
        ([37], [1.0]),
    ],
)
def test_the_weight_of_a_plane_is_half_the_gap_to_its_neighbours(planes: list[float], weights: list[float]) -> None:
    """Weights, computed by hand, are shares of 180°; the first and the last plane are neighbours, too."""
    np.testing.assert_allclose(
        plane_weights_by_azimuth_spacing(planes, divide_uncomputed_gaps_between_neighbours=True), weights, rtol=1e-12
    )
