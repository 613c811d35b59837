"""Compiled functions that load the tuples of a stack, its stones, joints and points from a lane, and store them.

A name says what is loaded or stored: ``load_stone_state(rows, lane)``, ``store_stone_state(rows, lane, value)``, and
``store_stone_state_unless_rejected(rows, lane, keep, value)``, which leaves the lane as it is if `keep` is true. States
of joints and points are those before the step, unless the name ends with ``at_step_end``.
"""

from typing import Final

from overturning.dem.body.state import InertialAndUpwardBaseAccelerations3D, StepRejectedAndSameContactStateFlags
from overturning.dem.body.vectors import Matrix3, Vector3
from overturning.dem.kernel.clock import CaseStepLengthsAndDoublingCounts, NextStepToAttempt
from overturning.dem.kernel.ending import CaseProgress
from overturning.dem.kernel.lanes import create_tuple_sum_difference_and_maximum_functions, create_window_slicer
from overturning.dem.stack.joint_state import (
    JOINT_ROW_LAYOUT,
    POINT_ROW_LAYOUT,
    AssumedJointFrictionInStep,
    BaseOverhangAndContactNormalSlopesAtSide,
    ContactPointPosition,
    FaceCorner,
    FlatLandingTimesLeftAndPointHeights,
    JointAtStepStartAndEnd,
    JointConstants,
    JointFrameAxesAndOrigin,
    JointNormalForceSumsWithDerivatives,
    JointPointAtStepStartAndEnd,
    JointRelativePoseAndVelocity,
    LoadSumsToFindContactNormal,
    PredictedJointForceAndDerivatives,
    SidePartInContactPatch,
    SolvedContactForceSums,
    SumOfForceTimesDistanceToPressureCentre,
)
from overturning.dem.stack.state import (
    CASE_ROW_LAYOUT,
    STONE_ROW_LAYOUT,
    ContactPowerLossAndLostSpringEnergy,
    DiagonalBlockAndRightSide,
    LargestContactChangesOfStack,
    PredictedStone,
    StackClockWithinSample,
    StackEnergyAccountAndPeakPenetration,
    StackRestFlagAndAccelerationLimits,
    StackTickLengthFailureAndRestLimits,
    StoneConstants,
    StoneContactForceSums,
    StoneCorrectionFromStoneBelow,
    StoneFallState,
    StonePeakLeanAndLastUprightTick,
    StoneState,
    StoneVelocityCorrection,
)

VALUE_COUNT_PER_CASE_IN_ALL_LANES: Final = CASE_ROW_LAYOUT.array_length
"""Number of values in the state array that hold the rows of a case without stones and joints, over all lanes."""
VALUE_COUNT_PER_STONE_IN_ALL_LANES: Final = STONE_ROW_LAYOUT.array_length
"""Number of values in the state array that hold one stone, over all lanes."""
VALUE_COUNT_PER_JOINT_IN_ALL_LANES: Final = JOINT_ROW_LAYOUT.array_length
"""Number of values in the state array that hold one joint without its contact points, over all lanes."""
VALUE_COUNT_PER_POINT_IN_ALL_LANES: Final = POINT_ROW_LAYOUT.array_length
"""Number of values in the state array that hold one contact point, over all lanes."""

slice_stone_rows = create_window_slicer(VALUE_COUNT_PER_STONE_IN_ALL_LANES, VALUE_COUNT_PER_CASE_IN_ALL_LANES)
"""Return the rows of a stone."""

load_energy_account, store_energy_account, store_energy_and_penetration_unless_rejected = (
    CASE_ROW_LAYOUT.tuple_reader_and_writer(StackEnergyAccountAndPeakPenetration)
)
load_next_step_to_attempt, store_next_step_to_attempt, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(NextStepToAttempt)
load_tick_length_failure_and_rest_limits, store_tick_length_failure_and_rest_limits, _ = (
    CASE_ROW_LAYOUT.tuple_reader_and_writer(StackTickLengthFailureAndRestLimits)
)
load_step_lengths_and_doubling_counts, store_step_lengths_and_doubling_counts, _ = (
    CASE_ROW_LAYOUT.tuple_reader_and_writer(CaseStepLengthsAndDoublingCounts)
)
load_case_progress, store_case_progress, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(CaseProgress)
load_largest_contact_changes, store_largest_contact_changes, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(
    LargestContactChangesOfStack
)
load_gravity_and_inertial_acceleration, store_gravity_and_inertial_acceleration, _ = (
    CASE_ROW_LAYOUT.tuple_reader_and_writer(Vector3)
)
load_power_loss_and_lost_spring_energy, store_power_loss_and_lost_spring_energy, _ = (
    CASE_ROW_LAYOUT.tuple_reader_and_writer(ContactPowerLossAndLostSpringEnergy)
)
load_step_rejection_flags, store_step_rejection_flags, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(
    StepRejectedAndSameContactStateFlags
)
load_rest_flag_and_acceleration_limits, store_rest_flag_and_acceleration_limits, _ = (
    CASE_ROW_LAYOUT.tuple_reader_and_writer(StackRestFlagAndAccelerationLimits)
)
load_inertial_and_upward_base_accelerations, store_inertial_and_upward_base_accelerations, _ = (
    CASE_ROW_LAYOUT.tuple_reader_and_writer(InertialAndUpwardBaseAccelerations3D)
)
load_clock_within_sample, store_clock_within_sample, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(StackClockWithinSample)

load_stone_axes, store_stone_axes, _ = STONE_ROW_LAYOUT.tuple_reader_and_writer(Matrix3)
load_velocity_correction, store_velocity_correction, _ = STONE_ROW_LAYOUT.tuple_reader_and_writer(
    StoneVelocityCorrection
)
load_stone_constants, store_stone_constants, _ = STONE_ROW_LAYOUT.tuple_reader_and_writer(StoneConstants)
load_diagonal_block_and_right_side, store_diagonal_block_and_right_side, _ = STONE_ROW_LAYOUT.tuple_reader_and_writer(
    DiagonalBlockAndRightSide
)
load_velocity_correction_coefficients, store_velocity_correction_coefficients, _ = (
    STONE_ROW_LAYOUT.tuple_reader_and_writer(StoneCorrectionFromStoneBelow)
)
load_fall_flags_and_last_upright_time, store_fall_flags_and_last_upright_time, _ = (
    STONE_ROW_LAYOUT.tuple_reader_and_writer(StoneFallState)
)
load_peaks_and_last_upright_tick, store_peaks_and_last_upright_tick, store_peaks_and_upright_tick_unless_rejected = (
    STONE_ROW_LAYOUT.tuple_reader_and_writer(StonePeakLeanAndLastUprightTick)
)
load_predicted_stone, store_predicted_stone, _ = STONE_ROW_LAYOUT.tuple_reader_and_writer(PredictedStone)
load_stone_state, store_stone_state, store_stone_state_unless_rejected = STONE_ROW_LAYOUT.tuple_reader_and_writer(
    StoneState
)
load_force_sums, store_force_sums, _ = STONE_ROW_LAYOUT.tuple_reader_and_writer(StoneContactForceSums)
store_rotation = STONE_ROW_LAYOUT.tuple_reader_and_writer(StoneState, "rotation").store

load_force_times_pressure_centre_distance, store_force_times_pressure_centre_distance, _ = (
    JOINT_ROW_LAYOUT.tuple_reader_and_writer(SumOfForceTimesDistanceToPressureCentre)
)
load_joint_equations, store_joint_equations, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(
    PredictedJointForceAndDerivatives
)
load_relative_motion, store_relative_motion, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(JointRelativePoseAndVelocity)
load_assumed_joint_friction_state, store_assumed_joint_friction_state, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(
    AssumedJointFrictionInStep
)
load_joint_state_at_step_start, store_joint_state_at_step_start, store_joint_state_at_step_start_unless_rejected = (
    JOINT_ROW_LAYOUT.tuple_reader_and_writer(JointAtStepStartAndEnd, "at_step_start")
)
load_joint_constants, store_joint_constants, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(JointConstants)
load_joint_wrench_or_velocity_change, store_joint_wrench_or_velocity_change, _ = (
    JOINT_ROW_LAYOUT.tuple_reader_and_writer(
        PredictedJointForceAndDerivatives, "predicted_wrench_replaced_by_velocity_change"
    )
)
load_joint_frame, store_joint_frame, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(JointFrameAxesAndOrigin)
load_flat_landing_times_and_point_heights, store_flat_landing_times_and_point_heights, _ = (
    JOINT_ROW_LAYOUT.tuple_reader_and_writer(FlatLandingTimesLeftAndPointHeights)
)
load_joint_state_at_step_end, store_joint_state_at_step_end, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(
    JointAtStepStartAndEnd, "at_step_end"
)
load_normal_force_and_derivative_sums, store_normal_force_and_derivative_sums, _ = (
    JOINT_ROW_LAYOUT.tuple_reader_and_writer(JointNormalForceSumsWithDerivatives)
)
load_contact_load_sums_for_normal, store_contact_load_sums_for_normal, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(
    LoadSumsToFindContactNormal
)
load_joint_force_and_impulse_sums, store_joint_force_and_impulse_sums, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(
    SolvedContactForceSums, "point_force_and_impulse_sums_at_step_end"
)

load_side_part_in_contact_patch, store_side_part_in_contact_patch, _ = POINT_ROW_LAYOUT.tuple_reader_and_writer(
    SidePartInContactPatch
)
load_point_state_at_step_end, store_point_state_at_step_end, _ = POINT_ROW_LAYOUT.tuple_reader_and_writer(
    JointPointAtStepStartAndEnd, "at_step_end"
)
load_face_corner, store_face_corner, _ = POINT_ROW_LAYOUT.tuple_reader_and_writer(FaceCorner)
load_point_position, store_point_position, _ = POINT_ROW_LAYOUT.tuple_reader_and_writer(ContactPointPosition)
load_base_overhang_and_normal_slopes, store_base_overhang_and_normal_slopes, _ = (
    POINT_ROW_LAYOUT.tuple_reader_and_writer(BaseOverhangAndContactNormalSlopesAtSide)
)
load_point_state_at_step_start, _, store_point_state_at_step_start_unless_rejected = (
    POINT_ROW_LAYOUT.tuple_reader_and_writer(JointPointAtStepStartAndEnd, "at_step_start")
)

add_energy_losses = create_tuple_sum_difference_and_maximum_functions(ContactPowerLossAndLostSpringEnergy).plus
create_zero_energy_losses = create_tuple_sum_difference_and_maximum_functions(ContactPowerLossAndLostSpringEnergy).zero
larger_value_of_each_contact_change = create_tuple_sum_difference_and_maximum_functions(
    LargestContactChangesOfStack
).largest
create_zero_contact_changes = create_tuple_sum_difference_and_maximum_functions(LargestContactChangesOfStack).zero

IS_SIMULATED_ROW_OFFSET: Final = STONE_ROW_LAYOUT.row_offset_of_field(StoneFallState, "is_still_simulated")
"""Array index, in the rows of a stone, at which the flags `StoneFallState.is_still_simulated` start."""
STIFFNESS_SHARE_IN_ATTEMPTED_STEP_ROW_OFFSET: Final = POINT_ROW_LAYOUT.row_offset_of_field(
    ContactPointPosition, "joint_stiffness_share"
)
"""Array index, in the rows of a contact point, at which its stiffness shares in the attempted step start."""
STIFFNESS_SHARE_AT_STEP_START_ROW_OFFSET: Final = POINT_ROW_LAYOUT.row_offset_of_field(
    JointPointAtStepStartAndEnd, "at_step_start.joint_stiffness_share"
)
"""Array index, in the rows of a contact point, at which its stiffness shares after the last step start."""
USES_NON_CORNER_AT_STEP_START_ROW_OFFSET, USES_NON_CORNER_AT_STEP_END_ROW_OFFSET = (
    JOINT_ROW_LAYOUT.row_offset_of_field(JointAtStepStartAndEnd, f"{end}.uses_non_corner_point")
    for end in ("at_step_start", "at_step_end")
)
