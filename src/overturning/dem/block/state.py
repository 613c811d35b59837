"""State of a single block: named tuples, and their layout in the rows of an array.

Quantities are per mass: stiffness K/m (1/s²), dashpot h/m (1/s), force as acceleration (m/s²). Coordinates and signs
are those of docs/method.md, "The block and its base"; `overturning.dem.kernel.lanes` describes the memory layout.
"""

from typing import Final, NamedTuple

from numba import njit

from overturning.dem.kernel.clock import BLOCK_STEP_CONTROL, CaseStepControl, NextStepToAttempt
from overturning.dem.kernel.ending import CaseProgress, CaseRestState, LargestTiltNearCaseEnd
from overturning.dem.kernel.ground import LinearBaseAcceleration
from overturning.dem.kernel.lanes import INLINE_OPTIONS, TupleRowLayout

PARALLEL_CASE_COUNT: Final = 48
"""Number of blocks computed side by side: enough to hide the latency of operations, few enough for the L1 cache."""

TICKS_PER_WHOLE_STEP: Final = BLOCK_STEP_CONTROL.ticks_per_whole_step
"""Ticks of a whole step."""

MAX_CORNER_TRAVEL_RATIO_WITHOUT_REFINEMENT: Final = 0.3
"""Largest travel of a corner that opens or closes in a gentle step, which is accepted without refinement.

In units of the travel in a finest step at the speed B p α, about that of a corner of a marginally falling block.
"""

MAX_CONTACT_CHANGE_STEP_IN_SHORTEST_STEPS: Final = 8.0
"""Longest gentle step, in finest steps."""

MAX_FRICTION: Final = 100.0
"""Largest friction coefficient used in the computation; with it corners already do not slide.

With larger ones, the slip of a landing corner in one step can dissipate more than its energy, in particular with strong
damping.
"""

MIN_OMEGA_DT_FOR_STEPS_OF_ONE_SAMPLE: Final = 100.0
"""Smallest ratio of sampling interval to 1/ω for which a block on both corners takes sample-long steps."""


class BlockConstants(NamedTuple):
    """Size, contact constants and step settings of a block; half width and half height in m."""

    half_width: float
    half_height: float
    inverse_inertia: float
    """Inverse inertia per mass, m/I, 1/m²."""
    normal_stiffness_per_mass: float
    """Normal stiffness of a corner, K/m, 1/s²."""
    tangential_stiffness_per_mass: float
    """Tangential stiffness of a corner, K_s/m, 1/s²."""
    tangential_compliance: float
    """1 over the tangential stiffness, s²; 0 without tangential spring."""
    dashpot_constant_per_mass: float
    """Dashpot of a corner, h/m, 1/s."""
    friction: float
    """Coefficient of friction μ."""
    alpha: float
    """Critical angle α = arctan(B/H), rad."""
    tick_length: float
    """Length of a tick, s."""
    max_travel_in_gentle_step: float
    """Largest travel of a corner that opens or closes in a gentle step, m."""
    landing_duration: float
    """Duration of a flat landing after the first touch, s."""
    max_interval_of_one_impact: float
    """Time within which the touches of both corners count as one impact, s."""
    friction_moment_share: float
    """Share of the moment of friction that rotates a block that slides in a flat landing: 0 for μ ≤ B/H, else 1."""


class CornerState(NamedTuple):
    """Spring stretch, position, penetration and normal force of a block's lower corner after the last step."""

    tangential_stretch: float
    """Stretch of the tangential spring, m."""
    x_position: float
    """Position along s, m."""
    penetration: float
    """Penetration, m; negative in the air."""
    normal_force: float
    """Normal force per mass, m/s² (centred scheme)."""


class AssumedCornerContact(NamedTuple):
    """Contact of a corner as assumed in a step of the centred scheme: sticking or sliding, flat landing."""

    signed_friction: float
    """±μ if the corner slides, else 0."""
    forces_decide_contact: bool
    """True if the step is fine, so that predicted forces decide instead."""
    lands_flat: bool
    """True if the block lands flat, so that the dashpot may pull; see `dem.block.landing`."""
    slides_in_flat_landing: bool
    """True if the block slides while it lands flat."""
    flat_landing_signed_friction: float
    """±μ of the friction in a flat landing."""
    friction_moment_share: float
    """Share of the moment of friction that rotates the block; 1 except in a flat landing."""


class BlockState(NamedTuple):
    """State of a block in the frame of the base: position, rotation, velocities and both lower corners.

    Centre (`x` along s, `z` up; m), rotation θ (`angle`, rad) with cosine and sine, velocities (`vx`, `vz`,
    `angular_velocity`) and accelerations (`ax`, `az`, `angular_acceleration`) of these (m, rad, s).
    """

    x: float
    z: float
    angle: float
    cos: float
    sin: float
    vx: float
    vz: float
    angular_velocity: float
    ax: float
    az: float
    angular_acceleration: float
    left: CornerState
    right: CornerState
    ticks_since_sample_start: float
    """Ticks since the start of the sample."""
    remaining_flat_landing_time: float
    """Remaining time of a flat landing, s; 0 or less if there is none."""


class AssumedFrictionCoefficientIfSliding(NamedTuple):
    """Friction that the next step of the centred scheme assumes at each corner: ±μ if sliding, 0 if sticking."""

    left: float
    right: float


class BlockPeakValues(NamedTuple):
    """Largest rotation (rad), slip (m) and penetration (m) so far, and last tick (time unit) below the critical angle.

    The tick is −1 if the block was not below its critical angle in this sample.
    """

    angle: float
    slip: float
    penetration: float
    last_upright_tick: float


class BlockEnergyAccount(NamedTuple):
    """Work done by the base on a block and energy lost so far, per mass, and their present rates.

    `base_motion_work` and `lost_energy` are in m²/s², their rates `base_motion_power` and
    `dissipated_power` in m²/s³.
    """

    base_motion_work: float
    lost_energy: float
    base_motion_power: float
    dissipated_power: float


class BlockInertialAccelerations(NamedTuple):
    """Accelerations of a block, in the frame of the base, that the motion of the base causes, m/s²."""

    inertial_acceleration_x: LinearBaseAcceleration
    """−a along s."""
    upward_base_acceleration: LinearBaseAcceleration
    """Upward acceleration of the base, added to gravity."""


class ExtrapolatedBlock(NamedTuple):
    """Position and velocities of a block at the end of a step, extrapolated with constant acceleration."""

    x: float
    z: float
    cos: float
    sin: float
    vx: float
    vz: float
    angular_velocity: float


class PredictedCorner(NamedTuple):
    """Predicted position, velocity and spring stretch of a corner of a block at the end of a step."""

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


class PredictedBlock(NamedTuple):
    """Predicted state of a block at the end of a step of the centred scheme, before its equations are solved.

    Pose (`x`, `z`, `angle`, `cos`, `sin`), velocities after half of the step (`vx`, `vz`, `angular_velocity`) and at
    its end (`end_vx`, `end_vz`, `end_angular_velocity`), as in `BlockState`.
    """

    x: float
    z: float
    angle: float
    cos: float
    sin: float
    vx: float
    vz: float
    angular_velocity: float
    end_vx: float
    end_vz: float
    end_angular_velocity: float
    inertial_acceleration_x: float
    """−a at the end of the step, along s, m/s²."""
    upward_base_acceleration: float
    """Upward acceleration of the base at the end of the step, m/s²."""
    half_step: float
    """Half the length of the step, s."""
    left: PredictedCorner
    right: PredictedCorner


class BlockVelocityCorrection(NamedTuple):
    """Corrections of a block's predicted velocities (m/s, rad/s), and friction ±μ of each corner (0: it sticks)."""

    vx: float
    vz: float
    angular_velocity: float
    left_signed_friction: float
    right_signed_friction: float


class TrialCornerFriction(NamedTuple):
    """Predicted tangential force at a block's corner, and whether a step's equations assume that the corner slides."""

    tangential_force: float
    """Predicted tangential force per mass, m/s²."""
    slides: bool
    """True if the corner slides."""
    signed_friction: float
    """±μ if the corner slides."""
    is_pushed_out_while_sliding: bool
    """True if a normal force pushes the corner out while it slides."""


class CornerEquationTerms(NamedTuple):
    """Contribution of a corner to the three equations for the velocities of a block, per mass.

    The forces are those for zero velocity at the end of the step. `normal_force_velocity_factor`,
    `sticking_force_velocity_factor` and `sliding_force_per_normal_velocity` are the factors of the velocities: of the
    normal force, and of the tangential force of a sticking and of a sliding corner.
    """

    normal_force: float
    """Normal force, m/s²."""
    tangential_force: float
    """Tangential force, m/s²."""
    normal_force_velocity_factor: float
    """Normal force per normal velocity, times half the step; dimensionless."""
    sticking_force_velocity_factor: float
    """Tangential force of a sticking corner per tangential velocity, times half the step."""
    sliding_force_per_normal_velocity: float
    """Tangential force of a sliding corner per normal velocity, times half the step."""


class SolvedCornerContact(NamedTuple):
    """Force, new state and contact changes of a block's corner, from the solution of the equations of a step."""

    new_corner: CornerState
    """State for the next step."""
    tangential_force: float
    """Tangential force per mass, m/s²."""
    moment: float
    """Moment of both forces per mass, m²/s²."""
    dissipated_power: float
    """Power dissipated by dashpots and friction, per mass, m²/s³."""
    released_tangential_stretch_squared: float
    """Energy released by the tangential spring, over half its stiffness, m²."""
    released_normal_stretch_squared: float
    """Energy released by the normal spring, over half its stiffness, m²."""
    has_closed_in_step: bool
    """True if the contact has closed in this step."""
    penetration_change_if_closed: float
    """Change of penetration in the step if the contact has closed, else 1, m."""
    contact_changed: float
    """Above 0 if the contact has opened or closed."""
    vertical_travel_if_changed: float
    """Vertical travel of the corner in the step if the contact has opened or closed, else 0, m."""
    signed_friction: float
    """±μ if the corner slips, else 0."""
    has_wrong_slip_assumption: bool
    """True if the corner sticks or slips contrary to the assumption."""
    has_slip_reversal: bool
    """True if the corner was assumed to slide against its velocity (slip reversal)."""
    has_friction_reversal: bool
    """True if its friction had the opposite sign before."""


class SolvedCornerContactPair(NamedTuple):
    """Forces, new states and contact changes of both corners of a block, from the solved equations of a step."""

    left: SolvedCornerContact
    right: SolvedCornerContact


class BlockAfterStep(NamedTuple):
    """State, peaks and energy account of a block after a step; they become valid if the step is accepted."""

    state: BlockState
    peaks: BlockPeakValues
    energy_account: BlockEnergyAccount


STATE_ROW_LAYOUT: Final = TupleRowLayout(
    PARALLEL_CASE_COUNT, BlockConstants, CaseStepControl, BlockState, NextStepToAttempt,
    AssumedFrictionCoefficientIfSliding,
    BlockPeakValues,
    BlockEnergyAccount, BlockInertialAccelerations, CaseProgress, PredictedBlock, BlockVelocityCorrection,
    CaseRestState,
    LargestTiltNearCaseEnd,
)  # fmt: skip


@njit(**INLINE_OPTIONS)
def corner_x_and_depth_from_centre(
    side: float, block: BlockConstants, cosine: float, sine: float
) -> tuple[float, float]:
    """Return a block's lower corner (`side` −1: left, 1: right) relative to its centre: along x and down, m."""
    b, h = side * block.half_width, block.half_height
    return b * cosine - h * sine, h * cosine + b * sine


@njit(**INLINE_OPTIONS)
def displacement_of_block_base(block: BlockConstants, centre_x: float, sine: float) -> float:
    """Return the displacement (m) of the middle of a block's base, from the displacement of its centre and sin θ."""
    return centre_x - block.half_height * sine
