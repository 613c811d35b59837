"""Compiled functions that load the tuples of a stack, its stones, joints and points from a lane, and store them.

A name says what is loaded or stored: ``load_stone(rows, lane)``, ``store_stone(rows, lane, value)``, and
``store_stone_unless(rows, lane, keep, value)``, which leaves the lane as it is if `keep` is true. Histories and points
are those before the step; ``next_`` stands for those after it.
"""

from overturning.dem.body.state import BodyBaseMotion, StepRejectionFlags
from overturning.dem.body.vectors import Matrix3, Vector3
from overturning.dem.kernel.clock import CaseStepControl, StepAttempt
from overturning.dem.kernel.ending import CaseProgress
from overturning.dem.kernel.lanes import create_elementwise_tuple_functions, create_window_slicer
from overturning.dem.stack.joint_state import (
    JOINT,
    POINT,
    ClippedSide,
    ContactPointPosition,
    FaceCorner,
    JointAtStepStartAndEnd,
    JointConstants,
    JointEquations,
    JointFriction,
    JointLandingTimes,
    JointNormalForceSums,
    JointPose,
    JointRelativeMotion,
    PointAtStepStartAndEnd,
    RimLoad,
    RimSide,
    SolvedJointPointSums,
    SumOfForceTimesDistance,
)
from overturning.dem.stack.state import (
    CASE,
    STONE,
    DiagonalBlockAndRightSide,
    EliminatedStone,
    JointEnergyLosses,
    LargestContactChanges,
    PredictedStone,
    StackClock,
    StackConstants,
    StackEnergyAccount,
    StackRestState,
    StoneConstants,
    StoneContactForceSums,
    StoneFallState,
    StonePeakTilt,
    StoneState,
    StoneVelocityChange,
)

of_stone = create_window_slicer(STONE.size, CASE.size)
"""Return the rows of a stone."""

load_account, store_account, store_account_unless = CASE.lane_access(StackEnergyAccount)
load_attempt, store_attempt, _ = CASE.lane_access(StepAttempt)
load_case, store_case, _ = CASE.lane_access(StackConstants)
load_clock, store_clock, _ = CASE.lane_access(CaseStepControl)
load_course, store_course, _ = CASE.lane_access(CaseProgress)
load_findings, store_findings, _ = CASE.lane_access(LargestContactChanges)
load_inertial, store_inertial, _ = CASE.lane_access(Vector3)
load_losses, store_losses, _ = CASE.lane_access(JointEnergyLosses)
load_rejection, store_rejection, _ = CASE.lane_access(StepRejectionFlags)
load_rest, store_rest, _ = CASE.lane_access(StackRestState)
load_shaking, store_shaking, _ = CASE.lane_access(BodyBaseMotion)
load_time, store_time, _ = CASE.lane_access(StackClock)

load_axes, store_axes, _ = STONE.lane_access(Matrix3)
load_change, store_change, _ = STONE.lane_access(StoneVelocityChange)
load_constants, store_constants, _ = STONE.lane_access(StoneConstants)
load_diagonal, store_diagonal, _ = STONE.lane_access(DiagonalBlockAndRightSide)
load_elimination, store_elimination, _ = STONE.lane_access(EliminatedStone)
load_outcome, store_outcome, _ = STONE.lane_access(StoneFallState)
load_peaks, store_peaks, store_peaks_unless = STONE.lane_access(StonePeakTilt)
load_predicted, store_predicted, _ = STONE.lane_access(PredictedStone)
load_stone, store_stone, store_stone_unless = STONE.lane_access(StoneState)
load_sum, store_sum, _ = STONE.lane_access(StoneContactForceSums)
store_turn = STONE.lane_access(StoneState, "turn").store

load_arm, store_arm, _ = JOINT.lane_access(SumOfForceTimesDistance)
load_equations, store_equations, _ = JOINT.lane_access(JointEquations)
load_frame, store_frame, _ = JOINT.lane_access(JointRelativeMotion)
load_friction, store_friction, _ = JOINT.lane_access(JointFriction)
load_history, store_history, store_history_unless = JOINT.lane_access(JointAtStepStartAndEnd, "old")
load_joint, store_joint, _ = JOINT.lane_access(JointConstants)
load_joint_change, store_joint_change, _ = JOINT.lane_access(JointEquations, "wrench")
load_joint_pose, store_joint_pose, _ = JOINT.lane_access(JointPose)
load_landing, store_landing, _ = JOINT.lane_access(JointLandingTimes)
load_next_history, store_next_history, _ = JOINT.lane_access(JointAtStepStartAndEnd, "new")
load_normal, store_normal, _ = JOINT.lane_access(JointNormalForceSums)
load_rim, store_rim, _ = JOINT.lane_access(RimLoad)
load_point_sum, store_point_sum, _ = JOINT.lane_access(SolvedJointPointSums, "at_end")

load_clip, store_clip, _ = POINT.lane_access(ClippedSide)
load_next_point, store_next_point, _ = POINT.lane_access(PointAtStepStartAndEnd, "new")
load_outline, store_outline, _ = POINT.lane_access(FaceCorner)
load_place, store_place, _ = POINT.lane_access(ContactPointPosition)
load_rim_side, store_rim_side, _ = POINT.lane_access(RimSide)
load_point, _, store_point_unless = POINT.lane_access(PointAtStepStartAndEnd, "old")

add_losses, no_losses = (
    create_elementwise_tuple_functions(JointEnergyLosses).plus,
    create_elementwise_tuple_functions(JointEnergyLosses).zero,
)
larger_of, no_findings = (
    create_elementwise_tuple_functions(LargestContactChanges).largest,
    create_elementwise_tuple_functions(LargestContactChanges).zero,
)
