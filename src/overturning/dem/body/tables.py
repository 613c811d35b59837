"""Tables of the body kernel (cases, bodies, results, trajectories): their columns, and the rows of bodies."""

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.kernel.clock import CaseStepLengthsAndDoublingCounts
from overturning.dem.kernel.tuples import table_dtype_of_named_tuples
from overturning.dem.limits import MAX_PENETRATION_TO_HALF_SIDE_RATIO
from overturning.model.solid import RigidSolid
from overturning.model.tipping import FALL_TILT_TO_RESTING_TILT_RATIO


class BodyInitialStateTableRow(NamedTuple):
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
    """Angular velocity along the same axes x, y and z, rad/s."""
    wy: float
    wz: float


class BodyCaseTableRow(NamedTuple):
    """Parameters of a case of a 3-D body: some of the columns of the kernel's table of cases."""

    point_normal_stiffness_per_mass: float
    """Normal stiffness of a point per mass, 1/s²."""
    point_tangential_stiffness_per_mass: float
    """Tangential stiffness of a point per mass, 1/s²."""
    point_dashpot_constant_per_mass: float
    """Dashpot of a point per mass, 1/s."""
    friction: float
    """Coefficient of friction."""
    amplitude_factor: float
    """Factor on the motion."""
    max_base_acceleration_without_motion_g: float
    """Horizontal acceleration over g up to which the body stays at rest."""
    max_base_acceleration_for_sample_long_steps_g: float
    """Horizontal acceleration, as a share of the weight, below which a standing body takes sample-long steps."""
    first_simulated_sample: float
    """First sample that is computed."""
    cannot_start_moving_from_sample: float
    """Sample from which on the input motion cannot start any movement."""
    end_sample_if_undecided: float
    """Sample at which the case ends as undecided."""


class BodyConstantTableRow(NamedTuple):
    """Constants of a solid body of one size: columns of the kernel's table of bodies."""

    mass_times_inverse_inertia_xx: float
    """Inverse of the inertia tensor about the centre per mass, m/I, 1/m²."""
    mass_times_inverse_inertia_yy: float
    mass_times_inverse_inertia_zz: float
    mass_times_inverse_inertia_xy: float
    mass_times_inverse_inertia_xz: float
    mass_times_inverse_inertia_yz: float
    inertia_per_mass_xx: float
    """Inertia tensor about the centre per mass, m²."""
    inertia_per_mass_yy: float
    inertia_per_mass_zz: float
    inertia_per_mass_xy: float
    inertia_per_mass_xz: float
    inertia_per_mass_yz: float
    centre_height: float
    """Height of the centre above the base, m."""
    round_base_radius_or_zero: float
    """Radius of a round base, m; 0 for a base with vertices."""
    min_base_edge_distance_from_centre: float
    """Smallest horizontal distance from the centre to an edge of the base, m."""
    critical_lean_as_continued_squared_sine: float
    """Lean (sin² of the tilt) beyond which the body falls over its nearest edge."""
    fall_tilt_cosine: float
    """Cosine of the tilt from which the body has fallen."""
    max_penetration: float
    """Penetration beyond which a case has failed, m."""
    extreme_vertex_tolerance_to_height_range: float
    """Share of the rise from the lowest to the highest base vertex within which vertices belong to the ends."""


class BodyResultTableRow(NamedTuple):
    """Results of a case of a 3-D body: columns of the kernel's table of results."""

    status: float
    """`CaseStatus` as a number."""
    fallen: float
    """1 if the body has fallen, else 0."""
    last_upright_time_if_fallen: float
    """Last time at which the body leant less than its critical angle, s; NaN if it has not fallen."""
    peak_lean_as_continued_squared_sine: float
    """Largest lean: sin² of the tilt up to 90°, 2 − sin² beyond."""
    peak_slip: float
    """Largest slip of the base, m."""
    slip_x_at_end: float
    """Slip of the base at the end along x and y, m."""
    slip_y_at_end: float
    peak_penetration: float
    """Largest penetration, m."""
    energy_error: float
    """Error of the energy balance, as a share of the energy supplied or, if more, that needed to overturn."""
    vertical_angular_momentum_error_ratio: float
    """Error of the vertical angular momentum, as a share of that of a free swing."""
    block_steps: float
    """Number of steps."""
    samples_left_out: float
    """Number of samples that were skipped at rest."""
    qw_at_end: float
    """Quaternion of the rotation at the end."""
    qx_at_end: float
    qy_at_end: float
    qz_at_end: float


class BaseAccelerationPartOfTrajectoryRow(NamedTuple):
    """Base acceleration, m/s², in a row of a trajectory, in the body's frame (see `BodyInitialStateTableRow`)."""

    base_acceleration_x: float
    base_acceleration_y: float
    base_acceleration_z: float


INITIAL_STATE_DTYPE: Final = table_dtype_of_named_tuples(BodyInitialStateTableRow)
CASE_TABLE_DTYPE: Final = np.dtype(
    [
        ("body", "i8"),
        *table_dtype_of_named_tuples(BodyCaseTableRow, CaseStepLengthsAndDoublingCounts).descr,
        ("start", INITIAL_STATE_DTYPE),
    ]
)
BODY_TABLE_DTYPE: Final = table_dtype_of_named_tuples(BodyConstantTableRow)
RESULT_TABLE_DTYPE: Final = table_dtype_of_named_tuples(BodyResultTableRow)
TRAJECTORY_ROW_DTYPE: Final = np.dtype(
    [
        ("time", "f8"),
        *table_dtype_of_named_tuples(BodyInitialStateTableRow, BaseAccelerationPartOfTrajectoryRow).descr,
    ]
)

EDGE_DISTANCE_PLACEHOLDER_M: Final = 1e300
"""Distance in place of that of an edge for a vertex that is not of the base, m; finite, since 0 × ∞ is no number."""


MIN_FALL_TILT_WITH_ONLY_UPSIDE_DOWN_REST_RAD: Final = np.radians(179.0)
"""Fall tilt above which a body can only rest upside down, where its tilt approaches 180° without reaching it, rad."""


def initial_conditions_at_rest(rest_position_and_rotation_vector: FloatArray) -> NDArray[np.void]:
    """Convert a static equilibrium pose, shape (6,), to a record of initial conditions with zero velocities."""
    half = 0.5 * rest_position_and_rotation_vector[3:]
    begin = np.zeros((), INITIAL_STATE_DTYPE)
    begin["x"], begin["y"], begin["z"] = rest_position_and_rotation_vector[:3]
    begin["qw"], begin["qx"], begin["qy"], begin["qz"] = np.array([1.0, *half]) / np.sqrt(1.0 + np.sum(half * half))
    return begin


def body_constant_and_vertex_tables(solids_by_size: list[RigidSolid]) -> tuple[NDArray[np.void], FloatArray]:
    """Return the kernel's input tables of the bodies: constants (type `BODY_TABLE_DTYPE`) and vertices.

    An odd number of vertices is padded with a vertex at the centre of the body.
    """
    count = len(solids_by_size[0].contact_points_from_centre_of_mass)
    points = np.zeros((len(solids_by_size), count + count % 2, 6))
    table = np.zeros(len(solids_by_size), BODY_TABLE_DTYPE)
    points[:, :, 5] = EDGE_DISTANCE_PLACEHOLDER_M
    pairs = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
    for index, body in enumerate(solids_by_size):
        points[index, :count, :3] = body.contact_points_from_centre_of_mass
        if body.rim_radius == 0.0:
            points[index, : body.base_vertex_count, 3:5], points[index, : body.base_vertex_count, 5] = (
                body.base_edge_normals, body.base_edge_distances_from_centre,
            )  # fmt: skip
        for name, at in pairs.items():
            table[index][f"mass_times_inverse_inertia_{name}"], table[index][f"inertia_per_mass_{name}"] = (
                body.inverse_inertia_per_mass[at], body.inertia_per_mass[at],
            )  # fmt: skip
        foot, reach = body.centre_height, body.min_base_edge_distance_from_centre
        # A body that lies on springs on another face, as at a fall tilt that depends on the direction or upside down,
        # may have a slightly smaller tilt.
        fallen = body.least_tilt_to_rest_on_another_face_rad
        lies_on_springs = (
            len(body.lean_sector_start_vector_and_min_fall_dot_product) > 0
            or fallen > MIN_FALL_TILT_WITH_ONLY_UPSIDE_DOWN_REST_RAD
        )
        fallen *= FALL_TILT_TO_RESTING_TILT_RATIO if lies_on_springs else 1.0
        values = {
            "centre_height": foot,
            "round_base_radius_or_zero": body.rim_radius,
            "min_base_edge_distance_from_centre": reach,
            "critical_lean_as_continued_squared_sine": reach**2 / (reach**2 + foot**2),
            "fall_tilt_cosine": np.round(np.cos(fallen), 12),
            "max_penetration": MAX_PENETRATION_TO_HALF_SIDE_RATIO * min(reach, foot),
            "extreme_vertex_tolerance_to_height_range": body.lowest_vertex_tolerance_over_base_height_range,
        }
        for name, value in values.items():
            table[index][name] = value
    return table, points
