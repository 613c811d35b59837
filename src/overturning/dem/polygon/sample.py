"""Start of a sample in a 2-D scene: the base motion, and the cosine and sine of the elements."""

from typing import Any

from numba import njit

from overturning.dem.kernel.ground import (
    linear_base_acceleration_of_sample,
)
from overturning.dem.kernel.lanes import (
    INTERNAL_COMPILE_OPTIONS,
    NO_ALIAS_COMPILE_OPTIONS,
)
from overturning.dem.kernel.mechanics import normalise_cosine_and_sine
from overturning.dem.polygon import rows
from overturning.dem.polygon.state import Pose


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def normalise_element_cosine_and_sine(element_state_rows: Any) -> None:
    """Scale (cosine, sine) of an element's rotation angle to length 1, for all cases in parallel."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        pose = rows.load_pose(element_state_rows, j)
        rows.store_pose(
            element_state_rows, j, Pose(pose.x, pose.z, pose.angle, *normalise_cosine_and_sine(pose.cos, pose.sin))
        )


@njit(**INTERNAL_COMPILE_OPTIONS)
def load_base_motion_of_current_sample(
    upward_base_acceleration_or_none: Any,
    case_states: Any,
    horizontal_base_acceleration_by_motion_row: Any,
    motion_row_by_case: Any,
    case_index_by_lane: Any,
    samples_per_tick: float,
) -> None:
    """Load each case's base motion at its current sample; the vertical component may be None (no vertical motion)."""
    last = horizontal_base_acceleration_by_motion_row.shape[1] - 3
    for j in range(rows.PARALLEL_CASE_COUNT):
        case = rows.load_scene_state(case_states, j)
        i, factor = min(int(case.current_sample), last), case.amplitude_factor
        rows.store_horizontal_base_acceleration(
            case_states,
            j,
            linear_base_acceleration_of_sample(
                horizontal_base_acceleration_by_motion_row[motion_row_by_case[case_index_by_lane[j]]],
                i,
                factor,
                samples_per_tick,
            ),
        )
        if upward_base_acceleration_or_none is not None:
            rows.store_vertical_base_acceleration(
                case_states,
                j,
                linear_base_acceleration_of_sample(upward_base_acceleration_or_none, i, factor, samples_per_tick),
            )
