"""Columns of the body kernel's tables: cases, bodies, results and trajectories."""

from typing import Final, NamedTuple

import numpy as np

from overturning.dem.kernel.clock import CaseStepControl
from overturning.dem.kernel.tuples import table_dtype_of_named_tuples


class BodyInitialStateTableColumns(NamedTuple):
    """Initial pose and velocities of a body: columns of the kernel's table of cases.

    The axis x points towards the azimuth of the orientation, y left of x, z up.
    """

    x: float
    """Position of the centre along x, m."""
    y: float
    """Position of the centre along y, m."""
    z: float
    """Height of the centre, m."""
    qw: float
    """Quaternion of the rotation from the pose at rest."""
    qx: float
    qy: float
    qz: float
    vx: float
    """Velocity, m/s."""
    vy: float
    vz: float
    wx: float
    """Angular velocity in the frame of the body, rad/s."""
    wy: float
    wz: float


class BodyCaseTableColumns(NamedTuple):
    """Parameters of a case of a 3-D body: columns of the kernel's table of cases, among others."""

    normal_stiffness_per_mass: float
    """Normal stiffness of a point per mass, 1/s²."""
    tangential_stiffness_per_mass: float
    """Tangential stiffness of a point per mass, 1/s²."""
    dashpot_constant_per_mass: float
    """Dashpot of a point per mass, 1/s."""
    friction: float
    """Coefficient of friction."""
    amplitude_factor: float
    """Factor on the motion."""
    rest_acceleration_limit_g: float
    """Horizontal acceleration over g up to which the body stays at rest."""
    max_acceleration_for_sample_long_steps_g: float
    """Horizontal acceleration, as a share of the weight, below which a standing body takes sample-long steps."""
    first_simulated_sample: float
    """First sample that is computed."""
    last_onset_sample: float
    """First sample after which the motion cannot start any movement."""
    end_sample_if_undecided: float
    """Sample at which the case ends as undecided."""


class BodyConstantTableColumns(NamedTuple):
    """Constants of a solid body of one size: columns of the kernel's table of bodies."""

    inverse_inertia_xx: float
    """Inverse inertia tensor about the centre, m/I, 1/m²."""
    inverse_inertia_yy: float
    inverse_inertia_zz: float
    inverse_inertia_xy: float
    inverse_inertia_xz: float
    inverse_inertia_yz: float
    inertia_xx: float
    """Inertia tensor about the centre per mass, m²."""
    inertia_yy: float
    inertia_zz: float
    inertia_xy: float
    inertia_xz: float
    inertia_yz: float
    centre_height: float
    """Height of the centre above the base, m."""
    base_radius: float
    """Radius of a round base, m; 0 for a base with vertices."""
    min_edge_distance: float
    """Smallest horizontal distance from the centre to an edge of the base, m."""
    critical_lean_squared_sine: float
    """Lean (sin² of the tilt) beyond which the body falls over its nearest edge."""
    fall_tilt_cosine: float
    """Cosine of the tilt from which the body has fallen."""
    max_penetration: float
    """Penetration beyond which a case has failed, m."""
    end_vertex_height_tolerance: float
    """Share of the rise from the lowest to the highest base vertex within which vertices belong to the ends."""


class BodyResultTableColumns(NamedTuple):
    """Results of a case of a 3-D body: columns of the kernel's table of results."""

    status: float
    """`CaseStatus` as a number."""
    fallen: float
    """1 if the body has fallen, else 0."""
    overturning_time: float
    """Time of the fall, s."""
    peak_lean_squared_sine: float
    """Largest lean: sin² of the tilt up to 90°, 2 − sin² beyond."""
    peak_slip: float
    """Largest slip of the base, m."""
    slip_x: float
    """Slip of the base at the end along x and y, m."""
    slip_y: float
    peak_penetration: float
    """Largest penetration, m."""
    energy_error: float
    """Error of the energy balance, as a share of the input energy."""
    angular_momentum_error: float
    """Error of the vertical angular momentum, as a share of that of a free swing."""
    block_steps: float
    """Number of steps."""
    samples_left_out: float
    """Number of samples that were skipped at rest."""
    qw: float
    """Quaternion of the rotation at the end."""
    qx: float
    qy: float
    qz: float


class BaseAccelerationTrajectoryColumns(NamedTuple):
    """Base acceleration, m/s², in a row of a trajectory, in the body's frame (see `BodyInitialStateTableColumns`)."""

    ground_x: float
    ground_y: float
    ground_z: float


INITIAL_STATE_DTYPE: Final = table_dtype_of_named_tuples(BodyInitialStateTableColumns)
CASE_TABLE_DTYPE: Final = np.dtype(
    [
        ("body", "i8"),
        *table_dtype_of_named_tuples(BodyCaseTableColumns, CaseStepControl).descr,
        ("start", INITIAL_STATE_DTYPE),
    ]
)
BODY_TABLE_DTYPE: Final = table_dtype_of_named_tuples(BodyConstantTableColumns)
RESULT_TABLE_DTYPE: Final = table_dtype_of_named_tuples(BodyResultTableColumns)
TRAJECTORY_ROW_DTYPE: Final = np.dtype(
    [
        ("time", "f8"),
        *table_dtype_of_named_tuples(BodyInitialStateTableColumns, BaseAccelerationTrajectoryColumns).descr,
    ]
)
