"""Trajectory of a scene: columns of its rows, functions that fill them, and conversion to a `PlanarSceneTrajectory`.

A row holds time and ground acceleration, six columns for each element, and five for each of the two ends of each pair.
"""

from typing import Any, Final

import numpy as np
from numba import njit

from overturning.arrays import FloatArray
from overturning.dem.kernel.ground import base_acceleration_at_tick
from overturning.dem.kernel.lanes import INTERNAL_COMPILE_OPTIONS
from overturning.dem.path import PlanarSceneTrajectory
from overturning.dem.polygon import rows
from overturning.dem.polygon.contact_history import (
    contact_vertex_position_from_centre_of_a,
    normal_force_direction_on_element_a,
)
from overturning.dem.polygon.prepare import SceneEquilibriumStiffnessAndRockingLimits
from overturning.dem.polygon.state import CONTACT_CODE_OPEN, CONTACT_CODE_VERTEX_OF_A

TIME_COLUMN, BASE_ACCELERATION_COLUMN = range(2)
TRAJECTORY_COLUMNS_PER_ELEMENT: Final = 6
"""Columns of an element: x, z, rotation and their rates."""
(
    FORCE_X_COLUMN_OFFSET,
    FORCE_Z_COLUMN_OFFSET,
    NORMAL_FORCE_COLUMN_OFFSET,
    NORMAL_FORCE_TIMES_X_COLUMN_OFFSET,
    NORMAL_FORCE_TIMES_Z_COLUMN_OFFSET,
) = range(5)
TRAJECTORY_COLUMNS_PER_CONTACT_POINT: Final = 5
"""Columns of an end: mean force on the pair's first element until the next sample (x, z), mean normal force, and
mean of normal force × place (x, z)."""


@njit(**INTERNAL_COMPILE_OPTIONS)
def record_base_and_element_motion_of_first_case(
    case_states: Any, element_count: int, sampling_interval: float, ticks_per_sample: float, trajectory_row_out: Any
) -> None:
    """Fill a trajectory row of the first case: time, base acceleration, pose and velocity of each element."""
    case = rows.load_scene_state(case_states, 0)
    trajectory_row_out[TIME_COLUMN] = (
        case.current_sample + case.base_acceleration.ticks_since_sample_start / ticks_per_sample
    ) * sampling_interval
    trajectory_row_out[BASE_ACCELERATION_COLUMN] = base_acceleration_at_tick(
        case.base_acceleration.horizontal, case.base_acceleration.ticks_since_sample_start
    )
    half = case.velocity_lag_behind_pose
    for e in range(element_count):
        item = rows.load_element_state(rows.slice_element_rows(case_states, e), 0)
        pose, v, a = item.pose, item.velocity, item.acceleration
        at = 2 + TRAJECTORY_COLUMNS_PER_ELEMENT * e
        trajectory_row_out[at], trajectory_row_out[at + 1], trajectory_row_out[at + 2] = pose.x, pose.z, pose.angle
        trajectory_row_out[at + 3], trajectory_row_out[at + 4], trajectory_row_out[at + 5] = (
            v.x + half * a.x,
            v.z + half * a.z,
            v.angular + half * a.angular,
        )


@njit(**INTERNAL_COMPILE_OPTIONS)
def add_first_case_contact_forces_to_trajectory(
    case_states: Any,
    scene_arrays: Any,
    time_weight_in_sample_mean: float,
    trajectory_rows: Any,
    trajectory_row_index: int,
) -> None:
    """Add the contact forces of the first case, times `time_weight_in_sample_mean`, to a row of the trajectory.

    The weights of all steps of a sample sum to 1, so that the row finally holds the mean forces of the sample.
    """
    for p in range(scene_arrays.pair_element_and_piece_indices.shape[0]):
        q, first, second = rows.slice_pair_and_element_rows(case_states, scene_arrays, p)
        pair, a, b = rows.load_pair_state(q, 0), rows.load_pose(first, 0), rows.load_pose(second, 0)
        for end in range(2):
            memory = pair.history.point_1 if end == 0 else pair.history.point_2
            if memory.contact_vertex_status_code == CONTACT_CODE_OPEN:
                continue
            n, tangent, mine = (
                time_weight_in_sample_mean * memory.normal_force,
                time_weight_in_sample_mean * memory.tangential_force,
                memory.contact_vertex_status_code == CONTACT_CODE_VERTEX_OF_A,
            )
            (rx, rz), (nx, nz) = (
                contact_vertex_position_from_centre_of_a(pair, a, b, end, mine),
                normal_force_direction_on_element_a(a, b, pair.nearest_face_of_a, pair.nearest_face_of_b, mine),
            )
            at = (
                2
                + TRAJECTORY_COLUMNS_PER_ELEMENT * scene_arrays.fall_and_support_table.shape[1]
                + TRAJECTORY_COLUMNS_PER_CONTACT_POINT * (2 * p + end)
            )
            trajectory_rows[trajectory_row_index, at + FORCE_X_COLUMN_OFFSET] += n * nx + tangent * nz
            trajectory_rows[trajectory_row_index, at + FORCE_Z_COLUMN_OFFSET] += n * nz - tangent * nx
            trajectory_rows[trajectory_row_index, at + NORMAL_FORCE_COLUMN_OFFSET] += n
            trajectory_rows[trajectory_row_index, at + NORMAL_FORCE_TIMES_X_COLUMN_OFFSET] += n * (a.x + rx)
            trajectory_rows[trajectory_row_index, at + NORMAL_FORCE_TIMES_Z_COLUMN_OFFSET] += n * (a.z + rz)


def count_trajectory_columns(prepared_scene: SceneEquilibriumStiffnessAndRockingLimits) -> int:
    """Return the number of columns of the trajectory of a scene."""
    return (
        2
        + TRAJECTORY_COLUMNS_PER_ELEMENT * len(prepared_scene.elements)
        + 2 * TRAJECTORY_COLUMNS_PER_CONTACT_POINT * len(prepared_scene.pairs)
    )


def planar_trajectory_of_scene(
    prepared_scene: SceneEquilibriumStiffnessAndRockingLimits, trajectory_rows: FloatArray
) -> PlanarSceneTrajectory:
    """Convert the kernel's trajectory rows of a scene to a `PlanarSceneTrajectory`."""
    placed, ends = prepared_scene.elements, 2 * len(prepared_scene.pairs)
    poses_end = 2 + TRAJECTORY_COLUMNS_PER_ELEMENT * len(placed)
    forces = trajectory_rows[:, poses_end:].reshape(len(trajectory_rows), ends, TRAJECTORY_COLUMNS_PER_CONTACT_POINT)
    force, load = (
        forces[:, :, [FORCE_X_COLUMN_OFFSET, FORCE_Z_COLUMN_OFFSET]],
        forces[:, :, [NORMAL_FORCE_COLUMN_OFFSET]],
    )
    contacts: list[tuple[str, str]] = []
    for index, pair in enumerate(prepared_scene.pairs):
        # Force on the later element, which stands on the earlier one; on the earlier one if the later is fixed.
        on, by = sorted(
            (pair.first_element_index, pair.second_element_index), key=lambda k: (placed[k].has_prescribed_motion, -k)
        )
        if on == pair.second_element_index:
            force[:, 2 * index : 2 * index + 2] *= -1.0
        contacts += 2 * [(placed[on].element.name, placed[by].element.name)]
    return PlanarSceneTrajectory(
        scene=prepared_scene.scene,
        placed_elements=placed,
        critical_angles_by_free_element=prepared_scene.tipping_angles,
        time=trajectory_rows[:, TIME_COLUMN],
        base_acceleration_towards_azimuth=trajectory_rows[:, BASE_ACCELERATION_COLUMN],
        poses_and_rates=trajectory_rows[:, 2:poses_end].reshape(
            len(trajectory_rows), len(placed), TRAJECTORY_COLUMNS_PER_ELEMENT
        ),
        mean_contact_forces_until_next_row=force,
        contact_force_points=forces[:, :, [NORMAL_FORCE_TIMES_X_COLUMN_OFFSET, NORMAL_FORCE_TIMES_Z_COLUMN_OFFSET]]
        / np.where(load > 0.0, load, np.nan),
        contact_element_names=contacts,
    )
