"""Start of a case of a 3-D stack: constants and initial state of its stones and joints."""

from typing import Any

from numba import njit

from overturning.dem.body.state import lean_as_squared_sine
from overturning.dem.body.vectors import Quaternion, SymmetricMatrix, Vector3, rotation_matrix
from overturning.dem.kernel.clock import CaseStepControl, NextStepToAttempt
from overturning.dem.kernel.ending import CaseProgress
from overturning.dem.kernel.lanes import INTERNAL_COMPILE_OPTIONS
from overturning.dem.stack.access import (
    slice_stone_rows,
    store_attempt,
    store_case,
    store_clock,
    store_constants,
    store_course,
    store_history,
    store_joint,
    store_outcome,
    store_outline,
    store_peaks,
    store_rest,
    store_stone,
)
from overturning.dem.stack.joint_state import (
    JOINT_ROW_LAYOUT,
    POINT_ROW_LAYOUT,
    FaceCorner,
    JointConstants,
    JointContactState,
    TangentTwistVector,
)
from overturning.dem.stack.state import (
    CASE_ROW_LAYOUT,
    PARALLEL_CASE_COUNT,
    STONE_ROW_LAYOUT,
    StackRestFlagAndLimits,
    StackTickLengthAndLimits,
    StoneConstants,
    StoneFallState,
    StonePeakTilt,
    StoneState,
)
from overturning.dem.stack.step import state_array_length_per_joint

CASE_SIZE, STONE_SIZE, JOINT_SIZE, P = (
    CASE_ROW_LAYOUT.size, STONE_ROW_LAYOUT.size, JOINT_ROW_LAYOUT.size, POINT_ROW_LAYOUT.size,
)  # fmt: skip


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_initial_stack_state(
    state: Any, lane: int, case: Any, stones_and_joints: tuple[Any, Any], friction: Any, outlines: Any, corners: Any,
    sampling_interval_and_ticks: tuple[float, float],
) -> None:  # fmt: skip
    """Load a stack at rest into column `lane` of the state array.

    `sampling_interval_and_ticks` is the sampling interval in seconds and in ticks, the unit of time of the steps.
    """
    (stones, joints), (sampling_interval, ticks_per_sample) = stones_and_joints, sampling_interval_and_ticks
    for row in range(state.size // PARALLEL_CASE_COUNT):
        state[row * PARALLEL_CASE_COUNT + lane] = 0.0
    first, size = CASE_SIZE + stones.size * STONE_SIZE, state_array_length_per_joint(outlines.shape[2])
    steps = case.steps_before_doubling_after_contact_change
    store_clock(state, lane, CaseStepControl(
        case.shortest_step_ticks, case.longest_step_at_rest_ticks, steps, case.long_steps_before_doubling,
    ))  # fmt: skip
    store_case(state, lane, StackTickLengthAndLimits(
        sampling_interval / ticks_per_sample, case.max_penetration, case.max_acceleration_for_sample_long_steps_g,
        case.max_kinetic_energy_at_rest, case.min_side_distance_of_mass_centre_above_joint
    ))  # fmt: skip
    store_rest(
        state,
        lane,
        StackRestFlagAndLimits(case.max_share_of_onset_acceleration_at_rest, case.max_base_acceleration_at_rest_g, 0.0),
    )
    store_attempt(state, lane, NextStepToAttempt(case.shortest_step_ticks, steps, 0.0))
    for s in range(stones.size):
        at, stone = first + s * size, stones[s]
        write_initial_stone_state(slice_stone_rows(state, s), lane, stone)
        write_initial_joint_state(
            state[at : at + size], lane, joints[s], friction[s], case.damping_factor, stone.centre_height,
            stone.nearest_base_side_distance,
        )  # fmt: skip
        for i in range(corners[s]):
            begin = at + JOINT_SIZE + i * P
            o = outlines[s, 0, i]
            store_outline(state[begin : begin + P], lane, FaceCorner(o[0], o[1], o[2], o[3], o[4], o[5]))
        if s > 0:
            for i in range(corners[s - 1]):
                begin = at + JOINT_SIZE + (corners[s] + i) * P
                o = outlines[s - 1, 1, i]
                store_outline(state[begin : begin + P], lane, FaceCorner(o[0], o[1], o[2], o[3], o[4], o[5]))
    store_course(state, lane, CaseProgress(
        case.amplitude_factor, case.first_simulated_sample, case.last_onset_sample, case.end_sample_if_undecided,
        case.first_simulated_sample * sampling_interval, case.spring_energy_at_rest,
        case.min_overturning_energy,
    ))  # fmt: skip


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_initial_stone_state(rows: Any, lane: int, constants: Any) -> None:
    """Write the constants and the initial state of a stone into column `lane` of its rows of the state array."""
    store_constants(
        rows,
        lane,
        StoneConstants(
            inverse_of_inertia_per_mass=SymmetricMatrix(
                constants.inverse_of_inertia_per_mass_xx,
                constants.inverse_of_inertia_per_mass_yy,
                constants.inverse_of_inertia_per_mass_zz,
                constants.inverse_of_inertia_per_mass_xy,
                constants.inverse_of_inertia_per_mass_xz,
                constants.inverse_of_inertia_per_mass_yz,
            ),
            inertia_per_mass=SymmetricMatrix(
                constants.inertia_per_mass_xx,
                constants.inertia_per_mass_yy,
                constants.inertia_per_mass_zz,
                constants.inertia_per_mass_xy,
                constants.inertia_per_mass_xz,
                constants.inertia_per_mass_yz,
            ),
            mass=constants.mass,
            centre_height=constants.centre_height,
            upper_face_height_above_centre=constants.upper_face_height_above_centre,
            critical_lean_squared_sine_on_contact_patch=constants.critical_lean_squared_sine_on_contact_patch,
            critical_lean_squared_sine_on_whole_base=constants.critical_lean_squared_sine_on_whole_base,
            fall_tilt_cosine=constants.fall_tilt_cosine,
            max_centre_drop_without_fall=constants.max_centre_drop_without_fall,
        ),
    )
    at, still = constants.start, Vector3(0.0, 0.0, 0.0)
    turn = Quaternion(at.qw, at.qx, at.qy, at.qz)
    store_stone(rows, lane, StoneState(Vector3(at.x, at.y, at.z), turn, still, still, still, still))
    store_peaks(rows, lane, StonePeakTilt(lean_as_squared_sine(rotation_matrix(turn)), -1.0))
    store_outcome(rows, lane, StoneFallState(1.0, 0.0, 0.0))


@njit(**INTERNAL_COMPILE_OPTIONS)
def write_initial_joint_state(
    rows: Any,
    lane: int,
    constants: Any,
    friction: float,
    damping_factor: float,
    centre_height: float,
    edge_distance: float,
) -> None:
    """Write contact constants and load at rest of a stone's contact with its support into column `lane`."""
    store_joint(rows, lane, JointConstants(
        normal_stiffness=constants.normal_stiffness, normal_dashpot=constants.normal_dashpot * damping_factor,
        tangential_stiffness=constants.tangential_stiffness, tangential_compliance=constants.tangential_compliance,
        tangential_dashpot=constants.tangential_dashpot * damping_factor, friction=friction,
        flat_landing_duration_s=constants.flat_landing_duration_s * damping_factor,
        tilting_friction_share_in_flat_landing=0.0 if friction * centre_height <= edge_distance else 1.0,
        min_rim_distance_for_deferred_contact=constants.min_rim_distance_for_deferred_contact,
        upper_base_corner_count=constants.upper_base_corner_count,
    ))  # fmt: skip
    still = TangentTwistVector(0.0, 0.0, 0.0)
    store_history(
        rows,
        lane,
        JointContactState(
            still,
            still,
            constants.pressure_centre_x,
            constants.pressure_centre_y,
            constants.mean_force_distance_from_pressure_centre,
            constants.normal_force,
            0.0,
            0.0,
        ),
    )
