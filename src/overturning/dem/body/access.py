"""Compiled functions that load the tuples of a body and of its base vertices from a lane, and store them.

A name says what is loaded or stored: ``load_body_state(rows, lane)``, ``store_body_state(rows, lane, value)``, and
``store_body_state_unless_rejected(rows, lane, keep, value)``, which leaves the lane as it is if `keep` is true. A row
offset is the array index at which the values of one field start.
"""

from typing import Final

from overturning.dem.body.state import (
    STATE_ROW_LAYOUT,
    VERTEX_ROW_LAYOUT,
    BodyBaseContactState,
    BodyConstants,
    BodyEnergyAndMomentumAccount,
    BodyPeaksAndLastUprightTick,
    BodyPredictedForStepEnd,
    BodyState,
    BodyTerminationLimits,
    BodyVelocityCorrection,
    BodyVertex,
    ContactForceAndMomentSum,
    ContactForcesAndNegatedVelocityDerivatives,
    ContactPointAtStepStartAndEnd,
    InertialAndUpwardBaseAccelerations3D,
    LargestContactChangesOfBody,
    LoadedBaseMotionSampleNumber,
    PredictedContactPoint,
    StepRejectedAndSameContactStateFlags,
)
from overturning.dem.body.vectors import Matrix3
from overturning.dem.kernel.clock import CaseStepLengthsAndDoublingCounts, NextStepToAttempt
from overturning.dem.kernel.ending import (
    CaseProgress,
    LargestTiltRatioInSecondHalfAfterRecord,
    LastSampleOfContinuedSlidingCase,
    RestAccelerationLimitAndAtRestFlag,
)

VALUE_COUNT_PER_VERTEX_IN_ALL_LANES: Final = VERTEX_ROW_LAYOUT.array_length
"""Number of values in the state array that hold one vertex or rim point, over all lanes."""
STATE_ROW_COUNT: Final = STATE_ROW_LAYOUT.row_count
"""Number of rows, of one value per lane, that hold a body without its vertices."""

load_body_constants, store_body_constants, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(BodyConstants)
load_body_state, store_body_state, store_body_state_unless_rejected = STATE_ROW_LAYOUT.tuple_reader_and_writer(
    BodyState
)
store_rotation_quaternion = STATE_ROW_LAYOUT.tuple_reader_and_writer(BodyState, "rotation").store
load_body_axes, store_body_axes, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(Matrix3)
load_peaks_and_last_upright_tick, store_peaks_and_last_upright_tick, store_peaks_and_upright_tick_unless_rejected = (
    STATE_ROW_LAYOUT.tuple_reader_and_writer(BodyPeaksAndLastUprightTick)
)
load_energy_account, _, store_energy_and_momentum_unless_rejected = STATE_ROW_LAYOUT.tuple_reader_and_writer(
    BodyEnergyAndMomentumAccount
)
load_case_progress, store_case_progress, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(CaseProgress)
load_termination_limits, store_termination_limits, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(BodyTerminationLimits)
load_inertial_and_upward_base_accelerations, store_inertial_and_upward_base_accelerations, _ = (
    STATE_ROW_LAYOUT.tuple_reader_and_writer(InertialAndUpwardBaseAccelerations3D)
)
load_next_step_to_attempt, store_next_step_to_attempt, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(NextStepToAttempt)
load_step_lengths_and_doubling_counts, store_step_lengths_and_doubling_counts, _ = (
    STATE_ROW_LAYOUT.tuple_reader_and_writer(CaseStepLengthsAndDoublingCounts)
)
load_step_rejection_flags, store_step_rejection_flags, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(
    StepRejectedAndSameContactStateFlags
)
load_extreme_vertices_and_landing_state, store_extreme_vertices_and_landing_state, _ = (
    STATE_ROW_LAYOUT.tuple_reader_and_writer(BodyBaseContactState)
)
load_predicted_body, store_predicted_body, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(BodyPredictedForStepEnd)
load_forces_and_velocity_derivatives, store_forces_and_velocity_derivatives, _ = (
    STATE_ROW_LAYOUT.tuple_reader_and_writer(ContactForcesAndNegatedVelocityDerivatives)
)
load_velocity_correction, store_velocity_correction, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(
    BodyVelocityCorrection
)
load_contact_force_sum, store_contact_force_sum, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(ContactForceAndMomentSum)
load_largest_contact_changes, store_largest_contact_changes, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(
    LargestContactChangesOfBody
)
load_vertex, store_vertex, _ = VERTEX_ROW_LAYOUT.tuple_reader_and_writer(BodyVertex)
load_point_state_at_step_start, store_point_state_at_step_start, store_point_state_at_step_start_unless_rejected = (
    VERTEX_ROW_LAYOUT.tuple_reader_and_writer(ContactPointAtStepStartAndEnd, "at_step_start")
)
load_body_point_state_at_step_end, store_body_point_state_at_step_end, _ = VERTEX_ROW_LAYOUT.tuple_reader_and_writer(
    ContactPointAtStepStartAndEnd, "at_step_end"
)
load_predicted_point, store_predicted_point, _ = VERTEX_ROW_LAYOUT.tuple_reader_and_writer(PredictedContactPoint)

TICKS_SINCE_SAMPLE_START_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(BodyState, "ticks_since_sample_start")
LAST_UPRIGHT_TICK_OF_SAMPLE_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(
    BodyPeaksAndLastUprightTick, "last_upright_tick_in_sample"
)
NEXT_STEP_TICKS_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(NextStepToAttempt, "length_in_ticks")
LOADED_SAMPLE_NUMBER_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(
    LoadedBaseMotionSampleNumber, "one_based_sample_number_or_zero"
)
REST_ACCELERATION_LIMIT_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(
    RestAccelerationLimitAndAtRestFlag, "max_base_acceleration_without_motion_g"
)
AT_REST_AT_SAMPLE_START_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(
    RestAccelerationLimitAndAtRestFlag, "was_at_rest_at_sample_start"
)
CURRENT_SAMPLE_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(CaseProgress, "current_sample")
LAST_UPRIGHT_TIME_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(CaseProgress, "last_time_below_critical_angle")
LARGEST_TILT_RATIO_AFTER_RECORD_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(
    LargestTiltRatioInSecondHalfAfterRecord, "largest_tilt_over_critical_angle"
)
SLIDING_CASE_END_SAMPLE_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(
    LastSampleOfContinuedSlidingCase, "end_sample_while_sliding_or_zero_if_unknown"
)
