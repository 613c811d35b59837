"""Compiled functions that load the tuples of a stack, its stones, joints and points from a lane, and store them.

A name says what is loaded or stored: ``load_stone(rows, lane)``, ``store_stone(rows, lane, value)``, and
``store_stone_unless(rows, lane, keep, value)``, which leaves the lane as it is if `keep` is true. Histories and points
are those before the step; ``next_`` stands for those after it.
"""

from typing import Final

from overturning.dem.body.state import InertialAccelerations3D, StepRejectionFlags
from overturning.dem.body.vectors import Matrix3, Vector3
from overturning.dem.kernel.clock import CaseStepControl, NextStepToAttempt
from overturning.dem.kernel.ending import CaseProgress
from overturning.dem.kernel.lanes import create_elementwise_tuple_functions, create_window_slicer
from overturning.dem.stack.joint_state import (
    JOINT_ROW_LAYOUT,
    POINT_ROW_LAYOUT,
    BaseOverhangAtSide,
    ContactNormalSums,
    ContactPointPosition,
    FaceCorner,
    FlatLandingTimesAndPointHeights,
    JointAtStepStartAndEnd,
    JointConstants,
    JointEquations,
    JointFrameAxesAndOrigin,
    JointFrictionInStepEquations,
    JointNormalForceSums,
    JointPointAtStepStartAndEnd,
    JointRelativeMotion,
    SidePartInContactPatch,
    SolvedContactForceSums,
    SumOfForceTimesDistance,
)
from overturning.dem.stack.state import (
    CASE_ROW_LAYOUT,
    STONE_ROW_LAYOUT,
    ContactEnergyLosses,
    DiagonalBlockAndRightSide,
    EliminatedStoneSolution,
    PredictedStone,
    StackClockWithinSample,
    StackContactChangesInStep,
    StackEnergyAccount,
    StackRestFlagAndLimits,
    StackTickLengthAndLimits,
    StoneConstants,
    StoneContactForceSums,
    StoneFallState,
    StonePeakTilt,
    StoneState,
    StoneVelocityCorrection,
)

slice_stone_rows = create_window_slicer(STONE_ROW_LAYOUT.array_length, CASE_ROW_LAYOUT.array_length)
"""Return the rows of a stone."""

load_account, store_account, store_account_unless = CASE_ROW_LAYOUT.tuple_reader_and_writer(StackEnergyAccount)
load_attempt, store_attempt, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(NextStepToAttempt)
load_case, store_case, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(StackTickLengthAndLimits)
load_clock, store_clock, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(CaseStepControl)
load_course, store_course, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(CaseProgress)
load_findings, store_findings, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(StackContactChangesInStep)
load_inertial, store_inertial, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(Vector3)
load_losses, store_losses, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(ContactEnergyLosses)
load_rejection, store_rejection, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(StepRejectionFlags)
load_rest, store_rest, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(StackRestFlagAndLimits)
load_shaking, store_shaking, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(InertialAccelerations3D)
load_time, store_time, _ = CASE_ROW_LAYOUT.tuple_reader_and_writer(StackClockWithinSample)

load_axes, store_axes, _ = STONE_ROW_LAYOUT.tuple_reader_and_writer(Matrix3)
load_change, store_change, _ = STONE_ROW_LAYOUT.tuple_reader_and_writer(StoneVelocityCorrection)
load_constants, store_constants, _ = STONE_ROW_LAYOUT.tuple_reader_and_writer(StoneConstants)
load_diagonal, store_diagonal, _ = STONE_ROW_LAYOUT.tuple_reader_and_writer(DiagonalBlockAndRightSide)
load_elimination, store_elimination, _ = STONE_ROW_LAYOUT.tuple_reader_and_writer(EliminatedStoneSolution)
load_outcome, store_outcome, _ = STONE_ROW_LAYOUT.tuple_reader_and_writer(StoneFallState)
load_peaks, store_peaks, store_peaks_unless = STONE_ROW_LAYOUT.tuple_reader_and_writer(StonePeakTilt)
load_predicted, store_predicted, _ = STONE_ROW_LAYOUT.tuple_reader_and_writer(PredictedStone)
load_stone, store_stone, store_stone_unless = STONE_ROW_LAYOUT.tuple_reader_and_writer(StoneState)
load_sum, store_sum, _ = STONE_ROW_LAYOUT.tuple_reader_and_writer(StoneContactForceSums)
store_rotation = STONE_ROW_LAYOUT.tuple_reader_and_writer(StoneState, "rotation").store

load_arm, store_arm, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(SumOfForceTimesDistance)
load_equations, store_equations, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(JointEquations)
load_frame, store_frame, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(JointRelativeMotion)
load_friction, store_friction, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(JointFrictionInStepEquations)
load_history, store_history, store_history_unless = JOINT_ROW_LAYOUT.tuple_reader_and_writer(
    JointAtStepStartAndEnd, "old"
)
load_joint, store_joint, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(JointConstants)
load_joint_change, store_joint_change, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(
    JointEquations, "force_and_moment_or_velocity_change"
)
load_joint_pose, store_joint_pose, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(JointFrameAxesAndOrigin)
load_landing, store_landing, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(FlatLandingTimesAndPointHeights)
load_next_history, store_next_history, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(JointAtStepStartAndEnd, "new")
load_normal, store_normal, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(JointNormalForceSums)
load_rim, store_rim, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(ContactNormalSums)
load_point_sum, store_point_sum, _ = JOINT_ROW_LAYOUT.tuple_reader_and_writer(
    SolvedContactForceSums, "sums_of_points_at_step_end"
)

load_clip, store_clip, _ = POINT_ROW_LAYOUT.tuple_reader_and_writer(SidePartInContactPatch)
load_next_point, store_next_point, _ = POINT_ROW_LAYOUT.tuple_reader_and_writer(JointPointAtStepStartAndEnd, "new")
load_outline, store_outline, _ = POINT_ROW_LAYOUT.tuple_reader_and_writer(FaceCorner)
load_place, store_place, _ = POINT_ROW_LAYOUT.tuple_reader_and_writer(ContactPointPosition)
load_rim_side, store_rim_side, _ = POINT_ROW_LAYOUT.tuple_reader_and_writer(BaseOverhangAtSide)
load_point, _, store_point_unless = POINT_ROW_LAYOUT.tuple_reader_and_writer(JointPointAtStepStartAndEnd, "old")

add_losses, no_losses = (
    create_elementwise_tuple_functions(ContactEnergyLosses).plus,
    create_elementwise_tuple_functions(ContactEnergyLosses).zero,
)
larger_of, no_findings = (
    create_elementwise_tuple_functions(StackContactChangesInStep).largest,
    create_elementwise_tuple_functions(StackContactChangesInStep).zero,
)

IS_SIMULATED_ROW_OFFSET: Final = STONE_ROW_LAYOUT.row_offset_of_field(StoneFallState, "is_simulated")
"""Array index, in the rows of a stone, at which the flags `StoneFallState.is_simulated` start."""
STIFFNESS_SHARE_ROW_OFFSET: Final = POINT_ROW_LAYOUT.row_offset_of_field(ContactPointPosition, "joint_stiffness_share")
"""Array index, in the rows of a contact point, at which its stiffness shares in the attempted step start."""
STIFFNESS_SHARE_AT_STEP_START_ROW_OFFSET: Final = POINT_ROW_LAYOUT.row_offset_of_field(
    JointPointAtStepStartAndEnd, "old.joint_stiffness_share"
)
"""Array index, in the rows of a contact point, at which its stiffness shares after the last step start."""
USES_NON_CORNER_AT_STEP_START_ROW_OFFSET, USES_NON_CORNER_AT_STEP_END_ROW_OFFSET = (
    JOINT_ROW_LAYOUT.row_offset_of_field(JointAtStepStartAndEnd, f"{end}.uses_non_corner_point")
    for end in ("old", "new")
)
