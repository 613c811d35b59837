"""Start of a case of a 3-D stack: constants and initial state of its stones and joints."""

from typing import Any

from numba import njit

from overturning.dem.body.state import squared_sine_of_lean_continued_beyond_90_deg
from overturning.dem.body.vectors import Quaternion, SymmetricMatrix, Vector3, rotation_matrix
from overturning.dem.kernel.clock import CaseStepLengthsAndDoublingCounts, NextStepToAttempt
from overturning.dem.kernel.ending import CaseProgress
from overturning.dem.kernel.lanes import INTERNAL_COMPILE_OPTIONS
from overturning.dem.stack.access import (
    VALUE_COUNT_PER_CASE_IN_ALL_LANES,
    VALUE_COUNT_PER_JOINT_IN_ALL_LANES,
    VALUE_COUNT_PER_POINT_IN_ALL_LANES,
    VALUE_COUNT_PER_STONE_IN_ALL_LANES,
    slice_stone_rows,
    store_case_progress,
    store_face_corner,
    store_fall_flags_and_last_upright_time,
    store_joint_constants,
    store_joint_state_at_step_start,
    store_next_step_to_attempt,
    store_peaks_and_last_upright_tick,
    store_rest_flag_and_acceleration_limits,
    store_step_lengths_and_doubling_counts,
    store_stone_constants,
    store_stone_state,
    store_tick_length_failure_and_rest_limits,
)
from overturning.dem.stack.joint_state import (
    FaceCorner,
    JointConstants,
    JointContactState,
    TangentialVectorWithScaledTwist,
)
from overturning.dem.stack.state import (
    PARALLEL_CASE_COUNT,
    StackRestFlagAndAccelerationLimits,
    StackTickLengthFailureAndRestLimits,
    StoneConstants,
    StoneFallState,
    StonePeakLeanAndLastUprightTick,
    StoneState,
)
from overturning.dem.stack.step import state_array_length_per_joint


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_stack_constants_and_initial_state(
    stack_states: Any, lane: int, case_table_row: Any, stone_and_joint_table_rows: tuple[Any, Any],
    friction_by_joint: Any, base_and_top_corner_values_by_stone: Any, corner_count_by_stone: Any,
    sampling_interval_s_and_ticks: tuple[float, float],
) -> None:  # fmt: skip
    """Load a stack at rest into column `lane` of the state array.

    `sampling_interval_s_and_ticks` is the sampling interval in seconds and in ticks, the unit of time of the steps.
    """
    (stones, joints), (sampling_interval, ticks_per_sample) = stone_and_joint_table_rows, sampling_interval_s_and_ticks
    for row in range(stack_states.size // PARALLEL_CASE_COUNT):
        stack_states[row * PARALLEL_CASE_COUNT + lane] = 0.0
    first = VALUE_COUNT_PER_CASE_IN_ALL_LANES + stones.size * VALUE_COUNT_PER_STONE_IN_ALL_LANES
    size = state_array_length_per_joint(base_and_top_corner_values_by_stone.shape[2])
    steps = case_table_row.steps_before_doubling_after_contact_change
    store_step_lengths_and_doubling_counts(stack_states, lane, CaseStepLengthsAndDoublingCounts(
        case_table_row.min_allowed_step_ticks, case_table_row.longest_step_with_all_contacts_closed_ticks, steps,
        case_table_row.long_steps_before_doubling,
    ))  # fmt: skip
    store_tick_length_failure_and_rest_limits(stack_states, lane, StackTickLengthFailureAndRestLimits(
        sampling_interval / ticks_per_sample, case_table_row.max_penetration,
        case_table_row.max_base_acceleration_for_sample_long_steps_g,
        case_table_row.max_kinetic_energy_at_rest, case_table_row.min_distance_of_mass_centre_above_to_joint_side
    ))  # fmt: skip
    store_rest_flag_and_acceleration_limits(
        stack_states,
        lane,
        StackRestFlagAndAccelerationLimits(
            case_table_row.rest_limit_to_onset_acceleration_ratio,
            case_table_row.max_possible_base_acceleration_without_motion_g,
            0.0,
        ),
    )
    store_next_step_to_attempt(stack_states, lane, NextStepToAttempt(case_table_row.min_allowed_step_ticks, steps, 0.0))
    for s in range(stones.size):
        at, stone = first + s * size, stones[s]
        write_stone_constants_and_initial_state(slice_stone_rows(stack_states, s), lane, stone)
        write_joint_constants_and_initial_state(
            stack_states[at : at + size], lane, joints[s], friction_by_joint[s], case_table_row.damping_factor,
            stone.centre_height, stone.nearest_base_side_distance,
        )  # fmt: skip
        for i in range(corner_count_by_stone[s]):
            begin = at + VALUE_COUNT_PER_JOINT_IN_ALL_LANES + i * VALUE_COUNT_PER_POINT_IN_ALL_LANES
            o = base_and_top_corner_values_by_stone[s, 0, i]
            store_face_corner(
                stack_states[begin : begin + VALUE_COUNT_PER_POINT_IN_ALL_LANES],
                lane,
                FaceCorner(o[0], o[1], o[2], o[3], o[4], o[5]),
            )
        if s > 0:
            for i in range(corner_count_by_stone[s - 1]):
                begin = (
                    at
                    + VALUE_COUNT_PER_JOINT_IN_ALL_LANES
                    + (corner_count_by_stone[s] + i) * VALUE_COUNT_PER_POINT_IN_ALL_LANES
                )
                o = base_and_top_corner_values_by_stone[s - 1, 1, i]
                store_face_corner(
                    stack_states[begin : begin + VALUE_COUNT_PER_POINT_IN_ALL_LANES],
                    lane,
                    FaceCorner(o[0], o[1], o[2], o[3], o[4], o[5]),
                )
    store_case_progress(stack_states, lane, CaseProgress(
        case_table_row.amplitude_factor, case_table_row.first_simulated_sample,
        case_table_row.cannot_start_moving_from_sample,
        case_table_row.end_sample_if_undecided,
        case_table_row.first_simulated_sample * sampling_interval, case_table_row.spring_energy_at_rest,
        case_table_row.min_overturning_energy,
    ))  # fmt: skip


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_stone_constants_and_initial_state(stone_rows: Any, lane: int, stone_table_row: Any) -> None:
    """Write the constants and the initial state of a stone into column `lane` of its rows of the state array."""
    store_stone_constants(
        stone_rows,
        lane,
        StoneConstants(
            mass_times_inverse_inertia=SymmetricMatrix(
                stone_table_row.mass_times_inverse_inertia_xx,
                stone_table_row.mass_times_inverse_inertia_yy,
                stone_table_row.mass_times_inverse_inertia_zz,
                stone_table_row.mass_times_inverse_inertia_xy,
                stone_table_row.mass_times_inverse_inertia_xz,
                stone_table_row.mass_times_inverse_inertia_yz,
            ),
            inertia_per_mass=SymmetricMatrix(
                stone_table_row.inertia_per_mass_xx,
                stone_table_row.inertia_per_mass_yy,
                stone_table_row.inertia_per_mass_zz,
                stone_table_row.inertia_per_mass_xy,
                stone_table_row.inertia_per_mass_xz,
                stone_table_row.inertia_per_mass_yz,
            ),
            mass=stone_table_row.mass,
            centre_height=stone_table_row.centre_height,
            upper_face_height_above_centre=stone_table_row.upper_face_height_above_centre,
            critical_lean_squared_sine_on_contact_at_rest=stone_table_row.critical_lean_squared_sine_on_contact_at_rest,
            critical_lean_squared_sine_on_whole_base=stone_table_row.critical_lean_squared_sine_on_whole_base,
            fall_tilt_cosine=stone_table_row.fall_tilt_cosine,
            max_centre_drop_without_fall=stone_table_row.max_centre_drop_without_fall,
        ),
    )
    at, still = stone_table_row.start, Vector3(0.0, 0.0, 0.0)
    turn = Quaternion(at.qw, at.qx, at.qy, at.qz)
    store_stone_state(stone_rows, lane, StoneState(Vector3(at.x, at.y, at.z), turn, still, still, still, still))
    store_peaks_and_last_upright_tick(
        stone_rows,
        lane,
        StonePeakLeanAndLastUprightTick(squared_sine_of_lean_continued_beyond_90_deg(rotation_matrix(turn)), -1.0),
    )
    store_fall_flags_and_last_upright_time(stone_rows, lane, StoneFallState(1.0, 0.0, 0.0))


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_joint_constants_and_initial_state(
    joint_rows: Any,
    lane: int,
    joint_table_row: Any,
    friction: float,
    damping_factor: float,
    centre_height_above_base: float,
    nearest_base_side_distance: float,
) -> None:
    """Write constants and load at rest of a stone's contact with its support into column `lane` of `joint_rows`."""
    store_joint_constants(joint_rows, lane, JointConstants(
        normal_stiffness=joint_table_row.normal_stiffness,
        normal_dashpot=joint_table_row.normal_dashpot * damping_factor,
        tangential_stiffness=joint_table_row.tangential_stiffness,
        tangential_compliance_or_zero_without_spring=joint_table_row.tangential_compliance_or_zero_without_spring,
        tangential_dashpot=joint_table_row.tangential_dashpot * damping_factor, friction=friction,
        flat_landing_duration_s=joint_table_row.flat_landing_duration_s * damping_factor,
        tilting_share_of_friction_moment_in_flat_landing=(
            0.0 if friction * centre_height_above_base <= nearest_base_side_distance else 1.0
        ),
        min_rim_distance_to_defer_flat_landing_contact=joint_table_row.min_rim_distance_to_defer_flat_landing_contact,
        upper_base_corner_count=joint_table_row.upper_base_corner_count,
    ))  # fmt: skip
    still = TangentialVectorWithScaledTwist(0.0, 0.0, 0.0)
    store_joint_state_at_step_start(
        joint_rows,
        lane,
        JointContactState(
            still,
            still,
            joint_table_row.pressure_centre_x,
            joint_table_row.pressure_centre_y,
            joint_table_row.mean_distance_of_forces_from_pressure_centre,
            joint_table_row.normal_force,
            0.0,
            0.0,
        ),
    )
