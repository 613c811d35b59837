"""Trajectory of a single 3-D body."""

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.path import dataset_variable_tuple
from overturning.model.results import CaseResults
from overturning.model.variables import BODY_OUTCOME_VARIABLES


def rotate_to_east_north_up(
    vectors_along_xyz: FloatArray, orientation_unit_vector_north_east: tuple[float, float]
) -> FloatArray:
    """Convert vectors, shape (…, 3), from the x, y and z axes of a body's frame to east, north and up.

    x points along the body's orientation, y 90° anticlockwise from it. `orientation_unit_vector_north_east` holds the
    north and east components of the unit vector along x.
    """
    cosine, sine = orientation_unit_vector_north_east
    x, y, z = np.moveaxis(vectors_along_xyz, -1, 0)
    return np.stack([x * sine - y * cosine, x * cosine + y * sine, z], axis=-1)


def current_directions_of_axis_vertical_at_rest(rest_to_current_quaternions_wxyz: FloatArray) -> FloatArray:
    """Return the body axis that is vertical at rest, unit vectors of shape (…, 3), from quaternions (w, x, y, z)."""
    w, x, y, z = np.moveaxis(rest_to_current_quaternions_wxyz, -1, 0)
    return np.stack([2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)], axis=-1)


@dataclass(frozen=True)
class BodyTrajectory:
    """Trajectory of a 3-D body in one case, in the frame that moves with the base."""

    rows: NDArray[np.void]  # samples, of type `overturning.dem.body.tables.TRAJECTORY_ROW_DTYPE`
    orientation_unit_vector_north_east: tuple[float, float]  # direction cosines of its orientation, north and east
    corner_positions_from_centre_at_rest: FloatArray  # positions at rest relative to the centre, shape (corners, 3), m
    edge_corner_indices: NDArray[np.int64]  # indices of the corners of each edge, shape (edges, 2)

    def variables_coordinates_and_attributes(
        self, results: CaseResults
    ) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
        """Return the variables (with the case's outcomes), coordinates and attributes of the trajectory's dataset."""
        to_east_north_up = partial(
            rotate_to_east_north_up, orientation_unit_vector_north_east=self.orientation_unit_vector_north_east
        )

        def trajectory_vectors_from_columns(*column_names: str) -> FloatArray:
            """Return the named columns of the trajectory rows as vectors, shape (samples, columns)."""
            return np.stack([self.rows[name] for name in column_names], axis=-1)

        quaternion = trajectory_vectors_from_columns("qw", "qx", "qy", "qz")
        axis = to_east_north_up(current_directions_of_axis_vertical_at_rest(quaternion))
        variables = {
            "place": dataset_variable_tuple(
                "time enu",
                to_east_north_up(trajectory_vectors_from_columns("x", "y", "z")),
                "m",
                "centre, in the frame of the base",
            ),
            "quaternion": dataset_variable_tuple(
                "time wxyz",
                np.concatenate([quaternion[:, :1], to_east_north_up(quaternion[:, 1:])], axis=1),
                "1",
                "rotation from the pose at rest",
            ),
            "velocity": dataset_variable_tuple(
                "time enu",
                to_east_north_up(trajectory_vectors_from_columns("vx", "vy", "vz")),
                "m s-1",
                "of the centre, relative to the base",
            ),
            "angular_velocity": dataset_variable_tuple(
                "time enu",
                to_east_north_up(trajectory_vectors_from_columns("wx", "wy", "wz")),
                "rad s-1",
                "angular velocity",
            ),
            "tilt_north": dataset_variable_tuple("time", axis[:, 1], "1", "northward component of the body's axis"),
            "tilt_east": dataset_variable_tuple("time", axis[:, 0], "1", "eastward component of the body's axis"),
            "ground_acceleration": dataset_variable_tuple(
                "time enu",
                to_east_north_up(
                    trajectory_vectors_from_columns("base_acceleration_x", "base_acceleration_y", "base_acceleration_z")
                ),
                "m s-2",
                "acceleration of the base",
            ),
            "outline": dataset_variable_tuple(
                "corner enu",
                to_east_north_up(self.corner_positions_from_centre_at_rest),
                "m",
                "corners at rest, from the centre",
            ),
            "edges": (("edge", "end"), self.edge_corner_indices),
        }
        for item in BODY_OUTCOME_VARIABLES:
            if item.name != "repeated":
                variables[item.name] = ((), item.decode(getattr(results, item.name)[0]), item.cf_attributes)
        coordinates = {
            "time": dataset_variable_tuple("time", self.rows["time"], "s", "time after the record's start"),
            "enu": ("enu", ["east", "north", "up"]),
        }
        return variables, coordinates, {}
