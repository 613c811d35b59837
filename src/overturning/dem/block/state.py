"""State of a single block: named tuples, and their layout in the rows of an array.

Quantities are per mass: stiffness K/m (1/s²), dashpot h/m (1/s), force as acceleration (m/s²). Coordinates and signs
are those of docs/method.md, "The block and its base"; `overturning.dem.kernel.lanes` describes the memory layout.
"""

from typing import Final, NamedTuple

from numba import njit

from overturning.dem.kernel.clock import BLOCK_STEP_CONTROL, CaseStepLengthsAndDoublingCounts, NextStepToAttempt
from overturning.dem.kernel.ending import (
    CaseProgress,
    LargestTiltRatioInSecondHalfAfterRecord,
    RestAccelerationLimitAndAtRestFlag,
)
from overturning.dem.kernel.ground import LinearBaseAcceleration
from overturning.dem.kernel.lanes import INLINE_OPTIONS, TupleRowLayout

PARALLEL_CASE_COUNT: Final = 48
"""Number of blocks computed side by side: enough to hide the latency of operations, few enough for the L1 cache."""

TICKS_PER_WHOLE_STEP: Final = BLOCK_STEP_CONTROL.ticks_per_whole_step
"""Ticks of a whole step."""

MAX_CONTACT_CHANGE_TRAVEL_OVER_B_P_ALPHA_MIN_DT: Final = 0.3
"""Largest travel of a corner in a step in which it opens or closes, for which the step is not halved.

In units of the travel in a finest step at the speed B p α, about that of a corner of a block that just falls.
"""

MAX_UNHALVED_CONTACT_CHANGE_STEP_IN_SHORTEST_STEPS: Final = 8.0
"""Longest step in which a corner may open or close without the step being halved, in finest steps."""

MAX_SIMULATED_FRICTION_COEFFICIENT: Final = 100.0
"""Largest friction coefficient used in the computation; with it corners already do not slide.

With larger ones, the slip of a landing corner in one step can dissipate more than its energy, in particular with strong
damping.
"""

MIN_OMEGA_DT_FOR_STANDING_STEPS_OF_ONE_SAMPLE: Final = 100.0
"""Smallest ratio of sampling interval to 1/ω for which a block on both corners takes sample-long steps."""


class BlockConstants(NamedTuple):
    """Constants of a block: half width and half height (m), contact, length of a tick (time unit), flat landing."""

    half_width: float
    half_height: float
    mass_over_moment_of_inertia: float
    """Mass over moment of inertia about the centre, m/I, 1/m²."""
    normal_stiffness_per_mass: float
    """Normal stiffness of a corner, K/m, 1/s²."""
    tangential_stiffness_per_mass: float
    """Tangential stiffness of a corner, K_s/m, 1/s²."""
    mass_over_tangential_stiffness: float
    """Mass over the tangential stiffness, m/K_s, s²; 0 without tangential spring."""
    dashpot_constant_per_mass: float
    """Dashpot of a corner, h/m, 1/s."""
    friction: float
    """Coefficient of friction μ."""
    critical_angle: float
    """Critical angle α = arctan(B/H), rad."""
    seconds_per_tick: float
    """Length of a tick, s."""
    max_contact_change_travel_without_halving_step: float
    """Largest vertical travel of a corner that opens or closes in a step, for which the step is not halved, m."""
    prescribed_flat_landing_duration: float
    """Duration of a flat landing after the first touch, s."""
    max_time_between_touches_in_one_impact: float
    """Time within which the touches of both corners count as one impact, s."""
    friction_moment_factor_if_sliding_in_flat_landing: float
    """Factor on the moment of friction of a block that slides in a flat landing: 0 for μ ≤ B/H, else 1."""


class CornerState(NamedTuple):
    """Spring stretch, position, penetration and normal force of a block's lower corner after the last step."""

    tangential_stretch: float
    """Stretch of the tangential spring, m."""
    x_position: float
    """Position along s in the frame of the base, m."""
    penetration: float
    """Penetration, m; negative in the air."""
    normal_force_per_mass: float
    """Normal force per mass, m/s² (centred scheme)."""


class AssumedCornerContact(NamedTuple):
    """Contact of a corner as assumed in a step of the centred scheme: sticking or sliding, flat landing."""

    signed_mu_or_zero_if_sticking: float
    """±μ if the corner slides, else 0."""
    uses_predicted_forces_for_contact_and_sliding: bool
    """True if the step is fine, so that predicted forces, not the last step, decide about contact and sliding."""
    lands_flat: bool
    """True if the block lands flat, so that the dashpot may pull; see `dem.block.landing`."""
    slides_in_flat_landing: bool
    """True if the block slides while it lands flat."""
    flat_landing_signed_mu: float
    """±μ of the friction in a flat landing."""
    friction_moment_factor: float
    """Factor on the moment of friction that rotates the block; 1 except in a flat landing."""


class BlockState(NamedTuple):
    """State of a block in the frame of the base: position, rotation, velocities, accelerations and lower corners.

    The centre is at `centre_x` (along s, towards the azimuth) and `centre_z` (up), m. The rotation θ is `angle`, rad,
    with cosine `cos` and sine `sin`. Velocities (`centre_vx`, `centre_vz`, `angular_velocity`) are in m/s and rad/s,
    accelerations (`centre_ax`, `centre_az`, `angular_acceleration`) in m/s² and rad/s².
    """

    centre_x: float
    centre_z: float
    angle: float
    cos: float
    sin: float
    centre_vx: float
    centre_vz: float
    angular_velocity: float
    centre_ax: float
    centre_az: float
    angular_acceleration: float
    left: CornerState
    right: CornerState
    ticks_since_sample_start: float
    """Ticks since the start of the sample."""
    remaining_flat_landing_time: float
    """Remaining time of a flat landing, s; 0 or less if there is none."""


class SignedFrictionCoefficientOrZeroIfSticking(NamedTuple):
    """Friction that the next step of the centred scheme assumes at each corner: ±μ if sliding, 0 if sticking."""

    left_signed_mu_or_zero_if_sticking: float
    right_signed_mu_or_zero_if_sticking: float


class BlockPeaksAndLastUprightTick(NamedTuple):
    """Largest rotation (rad), slip (m) and penetration (m) so far, and last tick (time unit) below the critical angle.

    The tick is −1 if the block was not below its critical angle in this sample.
    """

    max_abs_angle: float
    max_abs_base_slip: float
    max_corner_penetration: float
    last_tick_in_sample_below_critical_angle: float


class BlockEnergyAccount(NamedTuple):
    """Work of the base motion on a block, and energy that the block lost, per mass: sums so far and present rates.

    `base_motion_work_per_mass` and `lost_energy_per_mass` are in m²/s², their rates `base_motion_power_per_mass` and
    `dissipated_power_per_mass` in m²/s³.
    """

    base_motion_work_per_mass: float
    lost_energy_per_mass: float
    base_motion_power_per_mass: float
    dissipated_power_per_mass: float


class BlockAccelerationsFromBaseMotion(NamedTuple):
    """Base accelerations in the equations of motion of a block relative to the base: −a along s; upward, m/s²."""

    negative_of_base_acceleration_x: LinearBaseAcceleration
    """−a along s."""
    upward_base_acceleration: LinearBaseAcceleration
    """Upward acceleration of the base, added to gravity."""


class BlockExtrapolatedToStepEnd(NamedTuple):
    """Position and velocities of a block at the end of a step, extrapolated with constant acceleration."""

    centre_x: float
    centre_z: float
    cos: float
    sin: float
    centre_vx: float
    centre_vz: float
    angular_velocity: float


class CornerPredictedAtStepEnd(NamedTuple):
    """Predicted position, velocity and spring stretch of a block's corner, relative to the base, at a step's end."""

    x_from_centre: float
    """Position from the centre along s, m."""
    depth_below_centre: float
    """Depth below the centre, m."""
    penetration: float
    """Penetration, m."""
    tangential_stretch: float
    """Stretch of the tangential spring, m."""
    velocity_x: float
    """Velocity along s, m/s."""
    velocity_z: float
    """Upward velocity, m/s."""


class BlockPredictedAtStepEnd(NamedTuple):
    """Predicted state of a block at the end of a step of the centred scheme, before its equations are solved.

    Pose (`centre_x`, `centre_z`, `angle`, `cos`, `sin`) at the end of the step, and velocities after half of the step
    and at its end, as in `BlockState`.
    """

    centre_x: float
    centre_z: float
    angle: float
    cos: float
    sin: float
    mid_step_centre_vx: float
    mid_step_centre_vz: float
    mid_step_angular_velocity: float
    step_end_centre_vx: float
    step_end_centre_vz: float
    step_end_angular_velocity: float
    negative_of_base_acceleration_x: float
    """−a at the end of the step, along s, m/s²."""
    upward_base_acceleration: float
    """Upward acceleration of the base at the end of the step, m/s²."""
    half_step_duration: float
    """Half the length of the step, s."""
    left: CornerPredictedAtStepEnd
    right: CornerPredictedAtStepEnd


class BlockVelocityCorrectionAndCornerFriction(NamedTuple):
    """Corrections of a block's predicted step-end velocities (m/s, rad/s), and ±μ of each corner, 0 if it sticks."""

    centre_vx: float
    centre_vz: float
    angular_velocity: float
    left_signed_mu_or_zero_if_sticking: float
    right_signed_mu_or_zero_if_sticking: float


class PredictedCornerForceAndAssumedSlidingFlag(NamedTuple):
    """Predicted tangential force at a block's corner, and whether a step's equations assume that the corner slides."""

    tangential_force_per_mass: float
    """Predicted tangential force per mass, m/s²."""
    slides: bool
    """True if the equations assume that the corner slides."""
    signed_mu_if_sliding: float
    """±μ with the sign of the friction that acts if the corner slides."""
    has_no_painleve_paradox_if_sliding: bool
    """True if a normal force on the sliding corner would push it out, so that it can slide (no Painlevé paradox)."""


class CornerEquationTerms(NamedTuple):
    """Contribution of a corner to the three equations for the velocities of a block, per mass.

    The two forces are those for zero velocity at the end of the step. The other fields are changes of these forces per
    velocity, times half the step.
    """

    normal_force_per_mass_at_zero_velocity: float
    """Normal force at the end of the step if the corner had no velocity, m/s²."""
    tangential_force_per_mass_at_zero_velocity: float
    """Tangential force at the end of the step if the corner had no velocity, m/s²."""
    half_step_times_normal_force_decrease_per_upward_velocity: float
    """Decrease of the normal force per upward velocity, times half the step; dimensionless."""
    half_step_times_sticking_force_per_velocity: float
    """Tangential force of a sticking corner per tangential velocity, times half the step; 0 if it slides."""
    half_step_times_slip_force_per_normal_velocity: float
    """Tangential force of a sliding corner per normal velocity, times half the step; 0 if it sticks."""


class SolvedCornerContact(NamedTuple):
    """Force, new state and contact changes of a block's corner, from the solution of the equations of a step."""

    new_corner: CornerState
    """State for the next step."""
    tangential_force_per_mass: float
    """Tangential force per mass, m/s²."""
    moment_per_mass: float
    """Moment of both forces about the centre, per mass, m²/s²."""
    dissipated_power_per_mass: float
    """Power dissipated by dashpots and friction, per mass, m²/s³."""
    released_tangential_energy_over_half_stiffness: float
    """Energy released by the tangential spring, over half its stiffness, m²."""
    released_normal_energy_over_half_stiffness: float
    """Energy released by the normal spring, over half its stiffness, m²."""
    has_closed_in_step: bool
    """True if the contact has closed in this step."""
    penetration_change_if_newly_closed_else_one: float
    """Change of penetration in the step if the contact has closed, else 1, m."""
    positive_if_contact_changed: float
    """Above 0 if the contact has opened or closed."""
    vertical_travel_if_contact_changed_else_zero: float
    """Vertical travel of the corner in the step if the contact has opened or closed, else 0, m."""
    signed_mu_or_zero_if_sticking: float
    """±μ if the corner slips, else 0."""
    has_wrong_slip_assumption: bool
    """True if the corner sticks or slips contrary to the assumption."""
    has_velocity_against_assumed_slip: bool
    """True if the corner was assumed to slide against its velocity (slip reversal)."""
    friction_sign_changed_in_step: bool
    """True if its friction had the opposite sign before."""


class SolvedCornerContactPair(NamedTuple):
    """Forces, new states and contact changes of both corners of a block, from the solved equations of a step."""

    left: SolvedCornerContact
    right: SolvedCornerContact


class BlockAfterAttemptedStep(NamedTuple):
    """State, peaks and energy account of a block after a step; they become valid if the step is accepted."""

    state: BlockState
    peaks: BlockPeaksAndLastUprightTick
    energy_account: BlockEnergyAccount


STATE_ROW_LAYOUT: Final = TupleRowLayout(
    PARALLEL_CASE_COUNT, BlockConstants, CaseStepLengthsAndDoublingCounts, BlockState, NextStepToAttempt,
    SignedFrictionCoefficientOrZeroIfSticking,
    BlockPeaksAndLastUprightTick,
    BlockEnergyAccount, BlockAccelerationsFromBaseMotion, CaseProgress, BlockPredictedAtStepEnd,
    BlockVelocityCorrectionAndCornerFriction,
    RestAccelerationLimitAndAtRestFlag,
    LargestTiltRatioInSecondHalfAfterRecord,
)  # fmt: skip


@njit(**INLINE_OPTIONS)
def corner_x_and_depth_from_centre(
    corner_sign: float, block: BlockConstants, cosine: float, sine: float
) -> tuple[float, float]:
    """Return a block's lower corner (`corner_sign` −1: left, 1: right) relative to its centre: x and depth, m."""
    b, h = corner_sign * block.half_width, block.half_height
    return b * cosine - h * sine, h * cosine + b * sine


@njit(**INLINE_OPTIONS)
def displacement_of_block_lower_side_middle(block: BlockConstants, centre_x: float, sine: float) -> float:
    """Return the displacement (m), in the frame of the base, of the middle of a block's lower side."""
    return centre_x - block.half_height * sine
