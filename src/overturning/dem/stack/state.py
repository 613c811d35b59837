"""State of a 3-D stack: named tuples, and their layout in the rows of arrays.

The frame moves with the ground and is rotated to the orientation of the stack: x points to the azimuth, y 90°
anticlockwise of it, z up. A *joint* is the contact of a stone with what it stands on; its quantities are in the frame
of the lower face: origin at the centre of that face, axes of the lower stone. Velocities and moments of stones are per
mass of the stone, as in `overturning.dem.body.state`; forces of a joint are in N.

The rows of a lane are those of the case, then those of each stone, then those of each joint, each of which is followed
by the rows of its contact points.
"""

from typing import Final, NamedTuple

from overturning.dem.body.state import (
    InertialAndUpwardBaseAccelerations3D,
    LoadedBaseMotionSampleNumber,
    StepRejectedAndSameContactStateFlags,
)
from overturning.dem.body.vectors import Matrix3, Quaternion, SymmetricMatrix, Vector3
from overturning.dem.kernel.clock import STACK_STEP_CONTROL, CaseStepLengthsAndDoublingCounts, NextStepToAttempt
from overturning.dem.kernel.ending import CaseProgress, LastSampleOfContinuedSlidingCase
from overturning.dem.kernel.lanes import TupleRowLayout

PARALLEL_CASE_COUNT: Final = 8
"""Number of stacks computed side by side: one widest vector."""

TICKS_PER_WHOLE_STEP: Final = STACK_STEP_CONTROL.ticks_per_whole_step
"""Ticks of a whole step."""


class StackTickLengthFailureAndRestLimits(NamedTuple):
    """Constants of a simulated stack: length of a tick (time unit), and limits for failure, long steps and rest."""

    tick_length_s: float
    """Length of a tick, s."""
    max_penetration: float
    """Penetration beyond which the case has failed, m."""
    max_base_acceleration_for_sample_long_steps_g: float
    """Horizontal acceleration, as a share of the weight, below which a standing stack takes sample-long steps."""
    max_kinetic_energy_at_rest: float
    """Largest kinetic energy of a stack at rest, J."""
    min_distance_of_mass_centre_above_to_joint_side: float
    """Least distance, over all joints, of the centre of mass above from the nearest side of the joint, m."""


class StackRestFlagAndAccelerationLimits(NamedTuple):
    """Limits of base acceleration up to which a stack stays at rest, and a flag (1 or 0): it may be at rest."""

    rest_limit_to_onset_acceleration_ratio: float
    """Ratio of the acceleration up to which a stack at rest stays at rest to that which slides or unloads a joint."""
    max_possible_base_acceleration_without_motion_g: float
    """Upper bound of the base acceleration over g up to which the stack stays at rest; 0 if no sample is skipped."""
    may_be_at_rest_at_sample_start: float
    """1 if the stack may be at rest at the beginning of the sample, else 0."""


class StackClockWithinSample(NamedTuple):
    """Clock of one stack: time within the sample (ticks), and half the length of the attempted step (s)."""

    ticks_since_sample_start: float
    half_step_length_s: float


class StackEnergyAccountAndPeakPenetration(NamedTuple):
    """Energy account of a stack: work of the ground and losses (J), their rates (W), and largest penetration (m)."""

    base_motion_work: float
    dissipated_or_removed_energy: float
    base_motion_power_at_step_end: float
    dissipated_power_at_step_end: float
    peak_penetration: float
    """Largest penetration so far, m."""


class LargestContactChangesOfStack(NamedTuple):
    """Maxima over a stack's contacts of the flags of contact changes in an attempted step, and of the penetration."""

    positive_if_contact_opened_or_closed: float
    """Above 0 if a contact opened or closed."""
    has_wrong_slip_assumption: float
    """1 if a joint stuck or slid contrary to the assumption."""
    has_friction_opposite_to_assumption: float
    """1 if the friction of a joint assumed to slide acts against the assumed direction."""
    has_sticking_loaded_joint: float
    """1 if a loaded joint sticks."""
    friction_sign_changed_in_step: float
    """1 if a joint slides whose friction had the opposite sign before."""
    some_point_carries_no_load: float
    """1 if a point within a joint carries no load."""
    largest_penetration: float
    """Largest penetration, m."""
    has_loaded_joint: float
    """1 if a joint carries load."""


class ContactPowerLossAndLostSpringEnergy(NamedTuple):
    """Power lost in a stack's contacts (W), and spring energy released without work, as when contacts open (J)."""

    dissipated_power_at_step_end: float
    lost_spring_energy_in_step: float


class StoneConstants(NamedTuple):
    """Mass, inertia, dimensions and fall limits of a stone, which do not change during a case."""

    mass_times_inverse_inertia: SymmetricMatrix
    """Inverse inertia in the stone's own axes, m/I, 1/m²."""
    inertia_per_mass: SymmetricMatrix
    """Inertia in the stone's own axes, I/m, m²."""
    mass: float
    """Mass, kg."""
    centre_height: float
    """Height of the centre above the base, m."""
    upper_face_height_above_centre: float
    """Height of the upper face above the centre, m."""
    critical_lean_squared_sine_on_contact_at_rest: float
    """`squared_sine_of_lean_continued_beyond_90_deg` at which the stone balances on the nearest side of its contact
    at rest."""
    critical_lean_squared_sine_on_whole_base: float
    """`squared_sine_of_lean_continued_beyond_90_deg` at which the stone, on a plane, would balance on the nearest
    side of its base."""
    fall_tilt_cosine: float
    """Cosine of the smallest tilt at which the stone has fallen."""
    max_centre_drop_without_fall: float
    """Depth of the centre below its place on the face that carries the stone, beyond which the stone has fallen, m."""


class StoneState(NamedTuple):
    """Position, rotation, velocities and accelerations of a stone."""

    centre_position: Vector3
    """Position of the centre, m."""
    rotation: Quaternion
    """Rotation from rest."""
    velocity_relative_to_base: Vector3
    """Velocity of the centre relative to the ground, m/s."""
    angular_momentum_per_mass: Vector3
    """Angular momentum per mass, m²/s."""
    acceleration_relative_to_base: Vector3
    """Acceleration of the centre relative to the ground at the end of the last step, m/s²."""
    contact_moment_per_mass: Vector3
    """Moment of the contact forces about the centre per mass at the end of the last step, m²/s²."""


class StonePeakLeanAndLastUprightTick(NamedTuple):
    """Largest lean of a stone so far (sin² of its tilt), and last tick (time unit) with a lean below the critical one.

    Beyond 90° the lean is 2 − sin². The tick is −1 if the stone has leant more during the whole sample so far.
    """

    peak_lean_as_continued_squared_sine: float
    last_upright_tick_in_sample: float


class StoneFallState(NamedTuple):
    """Fall of a stone: simulated or already fallen, last time upright, and whether it slid off its support."""

    is_still_simulated: float
    """1 while the stone is computed, 0 after it has fallen."""
    last_upright_time_s: float
    """Last time at which the stone leant less than its critical angle, s."""
    slid_off_support: float
    """1 if the stone lost its support while its tilt was below the critical angle."""


class PredictedStone(NamedTuple):
    """Predicted pose and velocities of a stone at the end of a step, before the step's equations are solved."""

    centre_position: Vector3
    rotation: Quaternion
    velocity_at_half_step: Vector3
    """Velocity after half of the step, m/s."""
    angular_momentum_per_mass_at_half_step: Vector3
    """Angular momentum per mass after half of the step, m²/s."""
    end_velocity: Vector3
    """Velocity at the end of the step, m/s."""
    end_angular_velocity: Vector3
    """Angular velocity at the end of the step, rad/s."""


class VelocityToForceBlocks(NamedTuple):
    """6 × 6 matrix from velocity and angular velocity (columns) to force and moment (rows), as four 3 × 3 blocks."""

    force_per_velocity: Matrix3
    force_per_angular_velocity: Matrix3
    moment_per_velocity: Matrix3
    moment_per_angular_velocity: Matrix3


class ForceAndMomentOrVelocities(NamedTuple):
    """Force and moment (N, N·m), or velocity and angular velocity (m/s, rad/s)."""

    force_or_velocity: Vector3
    moment_or_angular_velocity: Vector3


class DiagonalBlockAndRightSide(NamedTuple):
    """Diagonal 6 × 6 block and right-hand side of one stone in the equations of a step."""

    diagonal_block: VelocityToForceBlocks
    impulse_right_hand_side: ForceAndMomentOrVelocities


class StoneCorrectionFromStoneBelow(NamedTuple):
    """Velocity correction of a stone eliminated from the equations, as a function of that of the stone below.

    The correction is `constant_part_of_correction` + `factor_of_correction_below` × (correction of the stone below).
    """

    factor_of_correction_below: VelocityToForceBlocks
    constant_part_of_correction: ForceAndMomentOrVelocities


class StoneVelocityCorrection(NamedTuple):
    """Correction of a stone's predicted velocity (m/s) and angular velocity (rad/s) from a step's equations."""

    velocity: Vector3
    angular_velocity: Vector3


class StoneContactForceSums(NamedTuple):
    """Sums over a stone's contacts: force and moment, and extra impulses of points that closed early in the step."""

    force_and_moment_at_step_end: ForceAndMomentOrVelocities
    extra_impulses_of_early_contacts: ForceAndMomentOrVelocities


CASE_ROW_LAYOUT: Final = TupleRowLayout(
    PARALLEL_CASE_COUNT, CaseStepLengthsAndDoublingCounts, StackTickLengthFailureAndRestLimits,
    StackRestFlagAndAccelerationLimits,
    StackClockWithinSample,
    StackEnergyAccountAndPeakPenetration, InertialAndUpwardBaseAccelerations3D, LoadedBaseMotionSampleNumber,
    CaseProgress, NextStepToAttempt,
    StepRejectedAndSameContactStateFlags, LargestContactChangesOfStack, ContactPowerLossAndLostSpringEnergy, Vector3,
    LastSampleOfContinuedSlidingCase
)  # fmt: skip
STONE_ROW_LAYOUT: Final = TupleRowLayout(
    PARALLEL_CASE_COUNT, StoneConstants, StoneState, StonePeakLeanAndLastUprightTick, StoneFallState, PredictedStone,
    Matrix3,
    DiagonalBlockAndRightSide, StoneCorrectionFromStoneBelow, StoneVelocityCorrection, StoneContactForceSums
)  # fmt: skip
