"""Cases of a 3-D study that resemble a surveyed stone, by orientation, height, B/H and D/B."""

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.model.symmetry import FULL_TURN_DEG
from overturning.surveys.stones import MAX_FACTOR_OUTSIDE_SIMULATED_RANGE, Stone


def stone_dimensions_described_from_side_nearer_to_grid(
    grid_values_by_dimension: Mapping[str, FloatArray], stone: Stone
) -> dict[str, float]:
    """Return face azimuth, height, B/H and D/B of a stone, with the side as face that suits a study's grid better.

    A stone with B/H 0.4 and D/B 0.5 may also be described by B/H 0.2 and D/B 2, with a face azimuth larger by 90°. Of
    these two descriptions the one with B/H and D/B nearer to values of the grid is returned; the one of the survey if
    they are equally near, or if the grid has no D/B.
    """
    front, side = stone.b_over_h_in_both_planes

    def stone_dimensions_seen_from_side(
        b_over_h_of_side_taken_as_face: float, b_over_h_of_other_side: float, azimuth_of_described_side_deg: float
    ) -> dict[str, float]:
        """Return height, B/H, D/B and face azimuth of the stone if the given side is taken as its face."""
        aspect = b_over_h_of_other_side / b_over_h_of_side_taken_as_face if b_over_h_of_side_taken_as_face else math.nan
        return {
            "height": stone.height_m, "b_over_h": b_over_h_of_side_taken_as_face, "aspect": aspect,
            "face_azimuth_deg": azimuth_of_described_side_deg,
        }  # fmt: skip

    def shape_distance_from_grid(stone_value_by_dimension: dict[str, float]) -> float:
        """Return |ln(nearest grid value/value of the stone)|, summed over B/H and D/B and rounded."""
        apart = (
            np.abs(np.log(grid_values_by_dimension[name] / stone_value_by_dimension[name])).min()
            for name in ("b_over_h", "aspect")
            if name in grid_values_by_dimension
        )
        return round(float(sum(apart)), 9)

    views = [
        stone_dimensions_seen_from_side(front, side, stone.face_azimuth_deg),
        stone_dimensions_seen_from_side(side, front, stone.face_azimuth_deg + 90.0),
    ]
    known = "aspect" in grid_values_by_dimension and math.isfinite(front) and front > 0.0 and side > 0.0
    return min(views, key=shape_distance_from_grid) if known else views[0]


def has_shape_far_outside_grid(
    grid_values_by_dimension: Mapping[str, FloatArray], stone_value_by_dimension: Mapping[str, float]
) -> bool:
    """True if B/H or D/B of a stone is known and lies far outside the values in the grid of a results cube."""
    return any(
        stone_value_by_dimension[name] * MAX_FACTOR_OUTSIDE_SIMULATED_RANGE < grid_values_by_dimension[name].min()
        or stone_value_by_dimension[name] > MAX_FACTOR_OUTSIDE_SIMULATED_RANGE * grid_values_by_dimension[name].max()
        for name in ("b_over_h", "aspect")
        if name in grid_values_by_dimension
    )


def nearest_grid_indices_of_stone(
    grid_values_by_dimension: Mapping[str, FloatArray], stone_value_by_dimension: Mapping[str, float]
) -> dict[str, NDArray[np.intp]]:
    """Return, by dimension of a results cube's grid, the index of the grid value that is closest to a stone's value.

    A dimension is left out if the value of the stone is unknown. `stone_value_by_dimension` is a result of
    `stone_dimensions_described_from_side_nearer_to_grid`.
    """
    found = {
        name: np.array([int(np.abs(np.log(grid_values_by_dimension[name] / stone_value_by_dimension[name])).argmin())])
        for name in ("height", "b_over_h", "aspect")
        if name in grid_values_by_dimension and math.isfinite(stone_value_by_dimension[name])
    }
    if "orientation" in grid_values_by_dimension and math.isfinite(stone_value_by_dimension["face_azimuth_deg"]):
        orientation = grid_values_by_dimension["orientation"].astype(np.float64)
        period = orientation.size * (orientation[1] - orientation[0]) if orientation.size > 1 else FULL_TURN_DEG
        apart = (orientation - stone_value_by_dimension["face_azimuth_deg"] + period / 2) % period - period / 2
        found["orientation"] = np.array([int(np.abs(apart).argmin())])
    return found
