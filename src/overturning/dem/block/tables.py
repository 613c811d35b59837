"""Columns of the tables of the block kernel (cases, results, trajectories) and of the rigid block (cases)."""

from typing import Final, NamedTuple

from overturning.dem.kernel.clock import CaseStepLengthsAndDoublingCounts
from overturning.dem.kernel.tuples import table_dtype_of_named_tuples


class BlockCaseTableRow(NamedTuple):
    """Parameters of a block case.

    Columns of the kernel's input table, followed by those of `CaseStepLengthsAndDoublingCounts`.
    """

    width: float
    """Width, m."""
    height: float
    """Height, m."""
    normal_stiffness_per_mass: float
    """Normal stiffness of a corner per mass, 1/s²."""
    tangential_stiffness_per_mass: float
    """Tangential stiffness of a corner per mass, 1/s²."""
    dashpot_constant_per_mass: float
    """Dashpot of a corner per mass, 1/s."""
    friction: float
    """Coefficient of friction."""
    critical_angle: float
    """Angle from the vertical of the line from a corner to the centre of mass, rad."""
    amplitude_factor: float
    """Factor on the motion."""
    initial_tilt: float
    """Initial rotation, rad, positive towards the azimuth."""
    initial_tilt_cosine: float
    """Cosine of the initial rotation."""
    initial_tilt_sine: float
    """Sine of the initial rotation."""
    first_simulated_sample: float
    """First sample that is computed."""
    cannot_start_moving_from_sample: float
    """Sample from which on the input motion cannot start any movement."""
    end_sample_if_undecided: float
    """Sample at which the case ends as undecided."""
    max_contact_change_travel_without_halving_step: float
    """Largest vertical travel of a corner that opens or closes in a step, for which the step is not halved, m."""
    max_base_acceleration_without_motion_g: float
    """Horizontal acceleration over g up to which the block stays at rest."""


class BlockResultTableRow(NamedTuple):
    """Results of a block case: columns of the kernel's table of results."""

    status: float
    """`CaseStatus` as a number."""
    overturned: float
    """Side of the fall: 1 towards the azimuth, −1 away from it, 0 standing."""
    overturning_time: float
    """Time of the fall, s."""
    peak_rotation: float
    """Largest rotation over α."""
    peak_slip: float
    """Largest slip of the base, m."""
    residual_slip: float
    """Slip of the base at the end, m."""
    peak_penetration: float
    """Largest penetration, m."""
    energy_error: float
    """Error of the energy balance, as a share of the input energy."""
    block_steps: float
    """Number of steps."""
    samples_left_out: float
    """Number of samples that were skipped at rest."""


class BlockTrajectoryTableRow(NamedTuple):
    """Time, pose, velocities and ground acceleration of a block: columns of its trajectory."""

    time: float
    """Time since the first sample, s."""
    centre_x: float
    """Horizontal displacement of the centre, m, in the frame of the base."""
    centre_z: float
    """Height of the centre, m."""
    angle: float
    """Rotation, rad."""
    centre_vx: float
    """Horizontal velocity, m/s."""
    centre_vz: float
    """Vertical velocity, m/s."""
    angular_velocity: float
    """Angular velocity, rad/s."""
    ground_acceleration: float
    """Ground acceleration, m/s²."""


CASE_TABLE_DTYPE: Final = table_dtype_of_named_tuples(BlockCaseTableRow, CaseStepLengthsAndDoublingCounts)
RESULT_TABLE_DTYPE: Final = table_dtype_of_named_tuples(BlockResultTableRow)
TRAJECTORY_ROW_DTYPE: Final = table_dtype_of_named_tuples(BlockTrajectoryTableRow)


class RigidRockingBlockCaseTableRow(NamedTuple):
    """Parameters of a case of the rigid rocking block: columns of the kernel's input table."""

    sine_of_critical_angle: float
    """Sine of the critical angle α."""
    cosine_of_critical_angle: float
    """Cosine of the critical angle α."""
    squared_product_of_p_and_sampling_interval: float
    """Square of p times the sampling interval."""
    restitution_coefficient: float
    """Coefficient of restitution."""
    steps_per_sample: float
    """Steps per sample."""
    max_rest_angular_velocity_rad_per_sample: float
    """Angular velocity below which the block comes to rest, rad per sample."""
    end_sample_if_undecided: float
    """Sample at which the case ends as undecided."""
    amplitude_factor: float
    """Factor on the motion."""
    initial_tilt: float
    """Initial rotation θ₀, rad."""
    sine_of_critical_angle_minus_initial_tilt: float
    """Sine of α − |θ₀|."""
    cosine_of_critical_angle_minus_initial_tilt: float
    """Cosine of α − |θ₀|."""


RIGID_CASE_TABLE_DTYPE: Final = table_dtype_of_named_tuples(RigidRockingBlockCaseTableRow)
