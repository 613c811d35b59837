"""Columns of the stack kernel's tables: cases, stones, joints and results."""

from typing import Final, NamedTuple

import numpy as np

from overturning.dem.body.tables import BodyInitialStateTableRow
from overturning.dem.kernel.clock import CaseStepLengthsAndDoublingCounts
from overturning.dem.kernel.tuples import table_dtype_of_named_tuples
from overturning.dem.stack.joint_state import JointConstants
from overturning.dem.stack.state import StoneConstants


class StackCaseTableRow(NamedTuple):
    """Parameters of a case of a 3-D stack: columns of the kernel's table of cases.

    The columns of `CaseStepLengthsAndDoublingCounts` follow in the same table.
    """

    amplitude_factor: float
    """Factor on the motion."""
    damping_factor: float
    """Factor on all dashpots."""
    max_penetration: float
    """Penetration beyond which the case has failed, m."""
    max_base_acceleration_for_sample_long_steps_g: float
    """Horizontal acceleration, as a share of the weight, below which a standing stack takes sample-long steps."""
    max_kinetic_energy_at_rest: float
    """Largest kinetic energy of a stack at rest, J."""
    min_distance_of_mass_centre_above_to_joint_side: float
    """Least distance, over all joints, of the centre of mass above from the nearest side of the joint, m."""
    rest_limit_to_onset_acceleration_ratio: float
    """Share of the acceleration that slides or unloads a joint, up to which a stack at rest stays at rest."""
    max_possible_base_acceleration_without_motion_g: float
    """Upper bound of the base acceleration over g up to which the stack stays at rest; 0 if no sample is skipped."""
    first_simulated_sample: float
    """First sample that is computed."""
    cannot_start_moving_from_sample: float
    """Sample from which on the input motion cannot start any movement."""
    end_sample_if_undecided: float
    """Sample at which the case ends as undecided."""
    min_overturning_energy: float
    """Smallest energy that overturns a part of the stack, J."""
    spring_energy_at_rest: float
    """Energy of the springs at rest, J."""


class JointLoadAtRest(NamedTuple):
    """Normal force and centre of pressure between two stones at rest, with which a case begins."""

    normal_force: float
    """Normal force, N."""
    pressure_centre_x: float
    """Centre of pressure along x, m."""
    pressure_centre_y: float
    """Centre of pressure along y, m."""
    mean_distance_of_forces_from_pressure_centre: float
    """Mean distance of the normal forces from the centre of pressure, m."""


class StoneResultTableRow(NamedTuple):
    """Results of one stone of a 3-D stack: columns of the kernel's table, one row per case and stone."""

    fallen: float
    """1 if the stone has fallen, else 0."""
    slid_off_support: float
    """1 if the stone lost its support before its tilt reached the critical angle."""
    last_upright_time_if_fallen: float
    """Last time at which the stone leant less than its critical angle, s; NaN if it has not fallen."""
    peak_lean_as_continued_squared_sine: float
    """Largest lean: sin² of the tilt up to 90°, 2 − sin² beyond."""
    slip_x_on_support_at_end: float
    """Displacement at the end relative to what the stone stands on, in the axes of that stone, m."""
    slip_y_on_support_at_end: float
    support_twist_cosine: float
    """Cosine of the rotation, since the start, of what the stone stands on about its normal, anticlockwise."""
    support_twist_sine: float
    """Sine of that rotation."""
    twist_relative_to_support_rad: float
    """Rotation about the normal of what the stone stands on, anticlockwise from above, rad."""
    stone_axis_unit_vector_x_at_end: float
    """Horizontal components of the stone's axis at the end."""
    stone_axis_unit_vector_y_at_end: float


class StackResultTableRow(NamedTuple):
    """Results of a case of a 3-D stack: columns of the kernel's table, one row per case."""

    status: float
    """`CaseStatus` as a number."""
    peak_penetration: float
    """Largest penetration, m."""
    energy_error: float
    """Error of the energy balance, as a share of the input energy."""
    block_steps: float
    """Number of steps times stones."""
    samples_left_out: float
    """Number of samples that were skipped at rest."""


INITIAL_STATE_DTYPE: Final = table_dtype_of_named_tuples(BodyInitialStateTableRow)
CASE_TABLE_DTYPE: Final = np.dtype(
    [("stack", "i8"), *table_dtype_of_named_tuples(StackCaseTableRow, CaseStepLengthsAndDoublingCounts).descr]
)
STONE_TABLE_DTYPE: Final = np.dtype(
    [
        (name, "f8")
        for name in (
            *(
                f"{tensor}_{axes}"
                for tensor in ("mass_times_inverse_inertia", "inertia_per_mass")
                for axes in ("xx", "yy", "zz", "xy", "xz", "yz")
            ),
            *(
                name
                for name in StoneConstants._fields
                if name not in {"mass_times_inverse_inertia", "inertia_per_mass"}
            ),
            "nearest_base_side_distance",
            "centre_height_at_rest",
        )
    ]
    + [("start", INITIAL_STATE_DTYPE)]
)
JOINT_TABLE_DTYPE: Final = table_dtype_of_named_tuples(JointConstants, JointLoadAtRest)
RESULT_TABLE_DTYPE: Final = table_dtype_of_named_tuples(StackResultTableRow)
STONE_RESULT_TABLE_DTYPE: Final = table_dtype_of_named_tuples(StoneResultTableRow)
