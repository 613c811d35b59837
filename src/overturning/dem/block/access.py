"""Compiled functions that load the tuples of a block from a lane, and store them.

A name says what is loaded or stored: ``load_block_state(rows, lane)`` and ``store_block_state(rows, lane, value)``. A
row offset is the array index at which the values of one field start.
"""

from typing import Final

from overturning.dem.block.state import (
    STATE_ROW_LAYOUT,
    BlockAccelerationsFromBaseMotion,
    BlockConstants,
    BlockEnergyAccount,
    BlockPeaksAndLastUprightTick,
    BlockState,
    SignedFrictionCoefficientOrZeroIfSticking,
)
from overturning.dem.kernel.clock import CaseStepLengthsAndDoublingCounts, NextStepToAttempt
from overturning.dem.kernel.ending import (
    CaseProgress,
    LargestTiltRatioInSecondHalfAfterRecord,
    RestAccelerationLimitAndAtRestFlag,
)

STATE_ROW_COUNT: Final = STATE_ROW_LAYOUT.row_count
"""Number of rows, of one value per lane, that hold a block."""

load_block_constants, store_block_constants, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(BlockConstants)
load_block_state, store_block_state, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(BlockState)
load_peaks_and_last_upright_tick, store_peaks_and_last_upright_tick, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(
    BlockPeaksAndLastUprightTick
)
load_energy_account = STATE_ROW_LAYOUT.tuple_reader_and_writer(BlockEnergyAccount).load
load_case_progress, store_case_progress, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(CaseProgress)
load_accelerations_from_base_motion = STATE_ROW_LAYOUT.tuple_reader_and_writer(BlockAccelerationsFromBaseMotion).load
store_next_step_to_attempt = STATE_ROW_LAYOUT.tuple_reader_and_writer(NextStepToAttempt).store
load_step_lengths_and_doubling_counts, store_step_lengths_and_doubling_counts, _ = (
    STATE_ROW_LAYOUT.tuple_reader_and_writer(CaseStepLengthsAndDoublingCounts)
)
load_signed_friction_or_zero_if_sticking, store_signed_friction_or_zero, _ = STATE_ROW_LAYOUT.tuple_reader_and_writer(
    SignedFrictionCoefficientOrZeroIfSticking
)
store_inertial_acceleration_x = STATE_ROW_LAYOUT.tuple_reader_and_writer(
    BlockAccelerationsFromBaseMotion, "negative_of_base_acceleration_x"
).store
store_upward_base_acceleration = STATE_ROW_LAYOUT.tuple_reader_and_writer(
    BlockAccelerationsFromBaseMotion, "upward_base_acceleration"
).store

ROTATION_COSINE_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(BlockState, "cos")
ROTATION_SINE_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(BlockState, "sin")
TICKS_SINCE_SAMPLE_START_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(BlockState, "ticks_since_sample_start")
LAST_UPRIGHT_TICK_OF_SAMPLE_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(
    BlockPeaksAndLastUprightTick, "last_tick_in_sample_below_critical_angle"
)
NEXT_STEP_LENGTH_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(NextStepToAttempt, "length_in_ticks")
REST_ACCELERATION_LIMIT_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(
    RestAccelerationLimitAndAtRestFlag, "max_base_acceleration_without_motion_g"
)
AT_REST_AT_SAMPLE_START_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(
    RestAccelerationLimitAndAtRestFlag, "was_at_rest_at_sample_start"
)
CURRENT_SAMPLE_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(CaseProgress, "current_sample")
LAST_UPRIGHT_TIME_ROW_OFFSET = STATE_ROW_LAYOUT.row_offset_of_field(CaseProgress, "last_time_below_critical_angle")
LARGEST_TILT_RATIO_AT_END_ROW_OFFSET: Final = STATE_ROW_LAYOUT.row_offset_of_field(
    LargestTiltRatioInSecondHalfAfterRecord, "largest_tilt_over_critical_angle"
)
