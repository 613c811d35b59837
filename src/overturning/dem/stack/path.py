"""Trajectory of the stones of a 3-D stack."""

from dataclasses import dataclass
from functools import partial
from typing import Any, Final

import numpy as np
from numba import njit
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.body.path import current_directions_of_axis_vertical_at_rest, rotate_to_east_north_up
from overturning.dem.body.rotation import angular_velocity_from_momentum
from overturning.dem.body.vectors import rotation_matrix
from overturning.dem.kernel.ground import base_acceleration_at_tick
from overturning.dem.kernel.lanes import INTERNAL_COMPILE_OPTIONS
from overturning.dem.path import dataset_variable_tuple
from overturning.dem.plan import check_trajectory_size
from overturning.dem.stack.access import (
    load_case_progress,
    load_clock_within_sample,
    load_fall_flags_and_last_upright_time,
    load_inertial_and_upward_base_accelerations,
    load_stone_constants,
    load_stone_state,
    slice_stone_rows,
)
from overturning.model.results import CaseResults
from overturning.model.stack import STACK_OUTCOME_VARIABLES
from overturning.model.stack_stones import StackStone
from overturning.units import STANDARD_GRAVITY

TRAJECTORY_COLUMN_COUNT_BEFORE_STONES: Final = 4
"""Columns of a row before those of the stones: time (s), and base acceleration along x, y and z (m/s²)."""

TRAJECTORY_COLUMN_COUNT_PER_STONE: Final = 14
"""Columns of a stone: position (3), quaternion (4), velocity (3), angular velocity (3), and 1 until it has fallen."""


@dataclass(frozen=True)
class StackTrajectory:
    """Trajectory of a 3-D stack in one case, in the frame that moves with the base."""

    rows: FloatArray  # shape (times, 4 + 14 · stones): see the numbers of columns above
    orientation_unit_vector_north_east: tuple[float, float]  # direction cosines of the orientation, north and east
    stones_in_initial_position: list[StackStone]
    name_of_element_shown_by_default: str  # name of the element that is shown by default
    critical_angle_by_stone_rad: FloatArray  # critical angle of each stone, rad, shape (stones,)

    def variables_coordinates_and_attributes(
        self, results: CaseResults
    ) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
        """Return the variables (with the case's outcomes), coordinates and attributes of the trajectory's dataset."""
        to_east_north_up = partial(
            rotate_to_east_north_up, orientation_unit_vector_north_east=self.orientation_unit_vector_north_east
        )

        columns = self.rows[:, TRAJECTORY_COLUMN_COUNT_BEFORE_STONES:].reshape(
            len(self.rows), len(self.stones_in_initial_position), TRAJECTORY_COLUMN_COUNT_PER_STONE
        )
        quaternion, present = columns[:, :, 3:7], columns[:, :, 13]
        axis = to_east_north_up(current_directions_of_axis_vertical_at_rest(quaternion))
        drawn = [stone.drawn_corners_and_edges() for stone in self.stones_in_initial_position]
        outline = np.full((len(drawn), max(len(corners) for corners, _ in drawn), 3), np.nan)
        edges = np.full((len(drawn), max(len(pairs) for _, pairs in drawn), 2), -1)
        for index, (corners, pairs) in enumerate(drawn):
            outline[index, : len(corners)], edges[index, : len(pairs)] = corners, pairs
        of_stone = "time element enu"
        variables: dict[str, Any] = {
            "place": dataset_variable_tuple(
                of_stone, to_east_north_up(columns[:, :, 0:3]), "m", "centre of mass, in the frame of the base"
            ),
            "quaternion": dataset_variable_tuple(
                "time element wxyz",
                np.concatenate([quaternion[..., :1], to_east_north_up(quaternion[..., 1:])], axis=-1),
                "1",
                "rotation from the upright pose",
            ),
            "velocity": dataset_variable_tuple(
                of_stone, to_east_north_up(columns[:, :, 7:10]), "m s-1", "of the centre, relative to the base"
            ),
            "angular_velocity": dataset_variable_tuple(
                of_stone, to_east_north_up(columns[:, :, 10:13]), "rad s-1", "angular velocity"
            ),
            "tilt_north": dataset_variable_tuple(
                "time element", axis[..., 1], "1", "northward component of the stone's axis"
            ),
            "tilt_east": dataset_variable_tuple(
                "time element", axis[..., 0], "1", "eastward component of the stone's axis"
            ),
            "critical_angle": dataset_variable_tuple("element", self.critical_angle_by_stone_rad, "rad",
            "critical angle"),
            "simulated": dataset_variable_tuple(
                "time element", present, "1", "1 until the stone has fallen; then it is drawn in free flight"
            ),
            "ground_acceleration": dataset_variable_tuple(
                "time enu", to_east_north_up(self.rows[:, 1:4]), "m s-2", "acceleration of the base"
            ),
            "outline": dataset_variable_tuple(
                "element corner enu", to_east_north_up(outline), "m",
                "corners at rest, from the centre; NaN beyond the last",
            ),
            "edges": (("element", "edge", "end"), edges),
        }  # fmt: skip
        for item in STACK_OUTCOME_VARIABLES:
            if item.name != "repeated":
                values = getattr(results, item.name)[0]
                dimensions = ("element",) if item.has_element_dimension else ()
                values = (
                    np.reshape(values, (len(self.stones_in_initial_position),))
                    if item.has_element_dimension
                    else values
                )
                variables[item.name] = (dimensions, item.decode(values), item.cf_attributes)
        coordinates = {
            "time": dataset_variable_tuple("time", self.rows[:, 0], "s", "time after the record's start"),
            "element": ("element", [stone.name for stone in self.stones_in_initial_position]),
            "enu": ("enu", ["east", "north", "up"]),
        }
        weight = STANDARD_GRAVITY * sum(stone.mass for stone in self.stones_in_initial_position)
        return variables, coordinates, {"reference": self.name_of_element_shown_by_default, "weight": weight}


def append_rows_for_flight_of_fallen_stones(
    trajectory_rows: FloatArray,
    has_fallen_by_stone: NDArray[np.bool_],
    sampling_interval_s: float,
    added_duration_s: float,
) -> FloatArray:
    """Return a trajectory extended by `added_duration_s` seconds with copies of its last row at later times.

    The added rows are `sampling_interval_s` (s) apart, and mark fallen stones as not simulated. No row is added if no
    stone has fallen at the end of the case (`has_fallen_by_stone`, shape (stones,)).
    """
    if not has_fallen_by_stone.any():
        return trajectory_rows
    count = np.ceil(added_duration_s / sampling_interval_s)
    check_trajectory_size((len(trajectory_rows) + count) * trajectory_rows.shape[1])
    more = np.repeat(trajectory_rows[-1:], int(count), axis=0)
    more[:, 0] += sampling_interval_s * np.arange(1, len(more) + 1)
    columns = more[:, TRAJECTORY_COLUMN_COUNT_BEFORE_STONES:].reshape(
        len(more), has_fallen_by_stone.size, TRAJECTORY_COLUMN_COUNT_PER_STONE
    )
    columns[:, has_fallen_by_stone, 13] = 0.0
    return np.concatenate([trajectory_rows, more])


def fill_in_free_flight_of_fallen_stones(trajectory_rows: FloatArray, stones: list[StackStone]) -> None:
    """Fill in, in each row in which a stone is not simulated, its pose in free flight until it meets the ground.

    A stone that has fallen is no longer simulated; its path in free flight is for drawing only.
    """
    columns = trajectory_rows[:, TRAJECTORY_COLUMN_COUNT_BEFORE_STONES:].reshape(
        len(trajectory_rows), len(stones), TRAJECTORY_COLUMN_COUNT_PER_STONE
    )
    for index, stone in enumerate(stones):
        gone = np.flatnonzero(columns[:, index, 13] == 0.0)
        if gone.size:
            begin = max(int(gone[0]) - 1, 0)
            _fill_in_stone_poses_in_free_flight(
                columns[begin:, index], trajectory_rows[begin:, :TRAJECTORY_COLUMN_COUNT_BEFORE_STONES], stone
            )


def _fill_in_stone_poses_in_free_flight(
    stone_trajectory_columns: FloatArray, time_and_base_acceleration_columns: FloatArray, stone: StackStone
) -> None:
    """Fill in the poses of a stone in free flight after the first row, until the stone meets the ground.

    Positions are relative to the base, so the stone has the acceleration of gravity less that of the base, which is
    linear between the rows.
    """
    place, turn, velocity, spin = np.split(stone_trajectory_columns[0, :13].copy(), (3, 7, 10))
    from scipy.spatial.transform import Rotation

    time, step = time_and_base_acceleration_columns[:, 0], np.diff(time_and_base_acceleration_columns[:, 0])[:, None]
    pull = np.array([0.0, 0.0, -STANDARD_GRAVITY]) - time_and_base_acceleration_columns[:, 1:]
    speeds = velocity + np.concatenate([np.zeros((1, 3)), np.cumsum(step * (pull[:-1] + pull[1:]) / 2.0, axis=0)])
    places = place + np.cumsum(step * (speeds[:-1] + step * (2.0 * pull[:-1] + pull[1:]) / 6.0), axis=0)
    corners, lies = stone.drawn_corners_and_edges()[0], False
    start = Rotation.from_quat(turn, scalar_first=True)
    for row, there, passed in zip(stone_trajectory_columns[1:], places, (time - time[0])[1:], strict=True):
        if not lies:
            turned = Rotation.from_rotvec(passed * spin) * start
            low = float((there + turned.apply(corners))[:, 2].min())
            lies = low <= 0.0
            last = there - np.array([0.0, 0.0, min(low, 0.0)]), turned.as_quat(scalar_first=True)
        row[0:3], row[3:7], row[7:13] = *last, 0.0


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_stack_trajectory_row(
    stack_states: Any, stone_count: int, sampling_interval_s: float, ticks_per_sample: float, trajectory_row: Any
) -> None:
    """Write time, base acceleration and motion of all stones of the stack in column 0 into a trajectory row."""
    time, shaking = (
        load_clock_within_sample(stack_states, 0),
        load_inertial_and_upward_base_accelerations(stack_states, 0),
    )
    trajectory_row[0] = (
        load_case_progress(stack_states, 0).current_sample + time.ticks_since_sample_start / ticks_per_sample
    ) * sampling_interval_s
    trajectory_row[1], trajectory_row[2] = (
        -base_acceleration_at_tick(shaking.negative_of_base_acceleration_x, time.ticks_since_sample_start),
        -base_acceleration_at_tick(shaking.inertial_acceleration_y, time.ticks_since_sample_start),
    )
    trajectory_row[3] = base_acceleration_at_tick(shaking.upward_base_acceleration, time.ticks_since_sample_start)
    for s in range(stone_count):
        constants = load_stone_constants(slice_stone_rows(stack_states, s), 0)
        stone = load_stone_state(slice_stone_rows(stack_states, s), 0)
        spin, at = (
            angular_velocity_from_momentum(
                constants.mass_times_inverse_inertia, rotation_matrix(stone.rotation), stone.angular_momentum_per_mass
            ),
            TRAJECTORY_COLUMN_COUNT_BEFORE_STONES + TRAJECTORY_COLUMN_COUNT_PER_STONE * s,
        )
        trajectory_row[at], trajectory_row[at + 1], trajectory_row[at + 2] = stone.centre_position
        trajectory_row[at + 3], trajectory_row[at + 4], trajectory_row[at + 5], trajectory_row[at + 6] = stone.rotation
        trajectory_row[at + 7], trajectory_row[at + 8], trajectory_row[at + 9] = stone.velocity_relative_to_base
        trajectory_row[at + 10], trajectory_row[at + 11], trajectory_row[at + 12] = spin
        trajectory_row[at + 13] = load_fall_flags_and_last_upright_time(
            slice_stone_rows(stack_states, s), 0
        ).is_still_simulated
