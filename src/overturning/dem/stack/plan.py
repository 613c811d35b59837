"""Plan of the cases of a 3-D stack: stones, joints, time steps, and samples that can be skipped."""

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.body.plan import (
    SimulationPlan3D,
    base_motion_indices_cosines_and_accelerations,
    sample_ranges_able_to_move_3d_model_at_rest,
)
from overturning.dem.limits import (
    MAX_PENETRATION_TO_HALF_SIDE_RATIO,
    MAX_ROCKING_TIME_CONSTANTS_AFTER_RECORD,
    static_penetration_exceeds_limit,
)
from overturning.dem.linear import highest_eigenvalue, lowest_eigenvalue
from overturning.dem.numerics import NumericalOptions
from overturning.dem.plan import check_trajectory_size
from overturning.dem.quiet import (
    MAX_REST_LIMIT_TO_CORNER_SLIP_ACCELERATION_RATIO,
    MAX_REST_LIMIT_TO_ONSET_ACCELERATION_RATIO,
    dynamic_to_static_force_ratio_upper_bound,
)
from overturning.dem.stack.path import (
    TRAJECTORY_COLUMN_COUNT_BEFORE_STONES,
    TRAJECTORY_COLUMN_COUNT_PER_STONE,
    StackTrajectory,
    append_rows_for_flight_of_fallen_stones,
    fill_in_free_flight_of_fallen_stones,
)
from overturning.dem.stack.results import outcome_variables_of_stacks
from overturning.dem.stack.rules import StackKernelInput
from overturning.dem.stack.state import PARALLEL_CASE_COUNT, TICKS_PER_WHOLE_STEP
from overturning.dem.stack.statics import (
    ContactSpringsAndPatchesOfStack,
    base_x_relative_to_support_centre_at_rest,
    eigenvalue_bound_factor_for_inertia_products,
    joint_constants_of_stack,
    kernel_rows_of_face_corners,
    no_movement_below_acceleration_g_by_case,
    scale_factors_for_unit_mass_diagonal,
    scaled_stiffness_matrix_of_stack_at_rest,
    spring_energy_at_rest,
    stone_constants_and_initial_states_table,
)
from overturning.dem.stack.step_control import steps_per_sample_and_step_control_of_stacks
from overturning.dem.stack.tables import CASE_TABLE_DTYPE, RESULT_TABLE_DTYPE, STONE_RESULT_TABLE_DTYPE
from overturning.dem.time_step import IntegrationScheme, parse_scheme, rocking_time_constant
from overturning.errors import ArgumentError
from overturning.model.cases import Cases
from overturning.model.stack import Stack
from overturning.model.stack_checks import reasons_stones_do_not_stand
from overturning.model.stack_stones import StackStone
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY

STACK_TO_BODY_WHOLE_STEP_LENGTH_RATIO: Final = 2.0
"""Whole step over that of a single 3-D body.

Flags, fall azimuths and peak tilts of three stones are as near to those of steps divided by 8 as with 1.0."""


@dataclass(frozen=True, kw_only=True)
class StackSimulationPlan(SimulationPlan3D):
    """Plan of the simulation of n cases of a 3-D stack of stones."""

    result_dtype: ClassVar[Any] = RESULT_TABLE_DTYPE
    index_or_field_name_of_trajectory_time: ClassVar[Any] = (..., 0)
    trajectory_columns_of_base_acceleration: ClassVar[Any] = ((..., 1), (..., 2), (..., 3))
    ticks_per_whole_step: ClassVar[float] = TICKS_PER_WHOLE_STEP

    model: Stack
    stone_table_by_stack: NDArray[np.void]  # shape (stacks, stones)
    joint_table_by_stack: NDArray[np.void]  # shape (stacks, stones)
    base_and_upper_face_corners_by_stack: (
        FloatArray  # shape (stacks, stones, 2, corners, 6): base and upper face of each stone
    )
    corner_counts_by_stone: NDArray[np.int64]  # number of corners of the faces of each stone, shape (stones,)
    friction_by_case_and_joint: FloatArray  # shape (n, stones)

    def create_result_tables(self, case_count: int) -> dict[str, NDArray[np.void]]:
        """Return tables for the kernel to fill: ``results`` of cases (cases,), ``each`` of stones (cases, stones)."""
        each = np.zeros((case_count, self.stone_table_by_stack.shape[1]), STONE_RESULT_TABLE_DTYPE)
        return {"results": np.zeros(case_count, RESULT_TABLE_DTYPE), "each": each}

    def kernel_input(
        self, case_numbers: NDArray[np.int64], result_tables: dict[str, NDArray[np.void]], step_divisor: int
    ) -> StackKernelInput:
        """Return the input of the stack kernel for cases with equal numbers of time steps per sample.

        The time steps are divided by `step_divisor`.
        """
        queued = self.kernel_input_fields_common_to_3d_models(
            case_numbers, result_tables, step_divisor, PARALLEL_CASE_COUNT
        )
        return StackKernelInput(
            **queued,
            stone_results=result_tables["each"],
            friction_by_case_and_joint=self.friction_by_case_and_joint[case_numbers],
            stone_table_by_stack=self.stone_table_by_stack,
            joint_table_by_stack=self.joint_table_by_stack,
            corner_counts_by_stone=self.corner_counts_by_stone,
            base_and_upper_face_corners_by_stack=self.base_and_upper_face_corners_by_stack,
        )

    def outcome_arrays_by_variable_name(
        self, case_numbers: NDArray[np.int64], result_tables: dict[str, NDArray[np.void]]
    ) -> dict[str, Any]:
        """Return the outcome variables of the cases in `case_numbers` by name, shape (cases,) or (cases, stones)."""
        orientation = np.asarray(self.cases.azimuth_deg)[case_numbers]
        # Slip is counted from the position at rest.
        each, stack = result_tables["each"].copy(), self.case_table["stack"][case_numbers]
        each["slip_x_on_support_at_end"] -= base_x_relative_to_support_centre_at_rest(self.stone_table_by_stack)[stack]
        return outcome_variables_of_stacks(
            result_tables["results"], each, orientation, self.orientation_unit_vector_north_east[case_numbers]
        )

    def create_trajectory_buffer(self, is_recorded: bool) -> FloatArray:
        """Return an array of zeros for the kernel's trajectory, shape (rows, columns).

        The array has no rows if `is_recorded` is False.
        """
        columns = (
            TRAJECTORY_COLUMN_COUNT_BEFORE_STONES
            + TRAJECTORY_COLUMN_COUNT_PER_STONE * self.stone_table_by_stack.shape[1]
        )
        rows = (
            int(self.case_table[0]["end_sample_if_undecided"] - self.first_simulated_sample[0]) + 3
            if is_recorded
            else 0
        )
        check_trajectory_size(rows * columns)
        return np.zeros((rows, columns))

    def trajectory_rows_at_rest(self, sample_count: int) -> FloatArray:
        """Return trajectory rows with the stack at rest, one for each of the first `sample_count` samples."""
        count, amplitude = self.stone_table_by_stack.shape[1], float(self.case_table[0]["amplitude_factor"])
        rows = np.zeros(
            (sample_count, TRAJECTORY_COLUMN_COUNT_BEFORE_STONES + TRAJECTORY_COLUMN_COUNT_PER_STONE * count)
        )
        rows[:, 0] = np.arange(sample_count) * self.motion.sampling_interval
        rows[:, 1:3] = self.base_accelerations_by_direction[0, :, :sample_count].T * amplitude
        rows[:, 3] = self.unscaled_upward_acceleration[:sample_count] * amplitude
        for stone, columns in zip(
            self.stone_table_by_stack[0],
            np.split(rows[:, TRAJECTORY_COLUMN_COUNT_BEFORE_STONES:], count, axis=1),
            strict=True,
        ):
            columns[:, 0:7] = [stone["start"][name] for name in ("x", "y", "z", "qw", "qx", "qy", "qz")]
            columns[:, 13] = 1.0
        return rows

    def extend_trajectory_rows_of_scene_or_stack(
        self, trajectory_rows: FloatArray, added_time_s: float, has_fallen_by_element: NDArray[np.bool_]
    ) -> FloatArray:
        """Return a trajectory extended by `added_time_s`, in which fallen stones continue in free flight."""
        at_rest = self.trajectory_rows_at_rest(self.motion.sample_count)
        # A flight needs a row for each sample, also while the stones below rest and samples are skipped.
        trajectory = self.insert_skipped_sample_rows(trajectory_rows, at_rest)
        longer = append_rows_for_flight_of_fallen_stones(
            trajectory, has_fallen_by_element, self.motion.sampling_interval, added_time_s
        )
        new, samples = slice(len(trajectory), None), np.arange(self.motion.sample_count) * self.motion.sampling_interval
        for column in (1, 2, 3):
            longer[new, column] = np.interp(longer[new, 0], samples, at_rest[:, column], right=0.0)
        fill_in_free_flight_of_fallen_stones(longer, self._stones_of_first_case)
        return longer

    def convert_trajectory_rows(self, trajectory_rows: FloatArray) -> StackTrajectory:
        """Convert the kernel's output rows of the plan's only case to a `StackTrajectory`."""
        cosine, sine = self.orientation_unit_vector_north_east[0].tolist()
        critical = np.arcsin(np.sqrt(self.stone_table_by_stack[0]["critical_lean_squared_sine_on_contact_at_rest"]))
        reference = self.model.scene.name_of_element_shown_by_default
        return StackTrajectory(trajectory_rows, (cosine, sine), self._stones_of_first_case, reference, critical)

    @property
    def _stones_of_first_case(self) -> list[StackStone]:
        """Stones of the stack in the plan's first case, from the lowest up."""
        height, b_over_h = (float(np.asarray(getattr(self.cases, name))[0]) for name in ("height", "b_over_h"))
        return self.model.stones(height, b_over_h)


def _check_that_stacks_can_stand(heights_and_b_over_h: FloatArray, stones_by_stack: list[list[StackStone]]) -> None:
    """Raise an `ArgumentError` if a stack with one of the `heights_and_b_over_h` (height, B/H) cannot stand."""
    for (height, ratio), stones in zip(heights_and_b_over_h.tolist(), stones_by_stack, strict=True):
        if faults := reasons_stones_do_not_stand(stones):
            raise ArgumentError(
                f"b_over_h: {ratio:g} at the height {height:g} m; then {faults[0]}: choose B/H and height nearer to "
                "those of the scene"
            )


def _check_stack_arguments(cases: Cases, numerics: NumericalOptions) -> None:
    """Raise an `ArgumentError` if a 3-D stack cannot be simulated with these cases or this scheme."""
    if parse_scheme(numerics.scheme) != IntegrationScheme.CENTRED:
        raise ArgumentError(f"scheme: {numerics.scheme!r}; a 3-D stack supports only 'centred'")
    if np.asarray(cases.initial_tilt).any():
        raise ArgumentError("initial_tilt: a 3-D stack starts at rest; leave it at 0")
    if (np.asarray(cases.aspect) != 1.0).any():
        raise ArgumentError(f"aspect: {np.unique(cases.aspect).tolist()}; a stack has the depths of its scene")


def _rest_limit_to_onset_acceleration_ratio_by_case(
    stones_by_stack: list[list[StackStone]],
    joint_constants_by_stack: list[ContactSpringsAndPatchesOfStack],
    stack_index_by_case: NDArray[np.int64],
    dashpot_factor_by_case: FloatArray,
    sampling_interval_s: float,
) -> FloatArray:
    """Return, per case, the fraction of the onset acceleration up to which a stack at rest surely stays at rest.

    At the onset acceleration a contact slides or opens statically; the fraction allows for dynamic overshoot. Damping
    is that of the contact with the smallest ratio of dashpot to spring, which damps least.
    """
    slowest = np.array(
        [
            lowest_eigenvalue(
                scaled_stiffness_matrix_of_stack_at_rest(stones, table, scale_factors_for_unit_mass_diagonal(stones))
            )
            for stones, table in zip(stones_by_stack, joint_constants_by_stack, strict=True)
        ]
    )
    delay = np.array([float(table.dashpot_to_stiffness_ratios.min()) for table in joint_constants_by_stack])
    overshoot = dynamic_to_static_force_ratio_upper_bound(
        slowest[stack_index_by_case], delay[stack_index_by_case] * dashpot_factor_by_case, sampling_interval_s
    )
    return np.asarray(
        np.minimum(
            MAX_REST_LIMIT_TO_ONSET_ACCELERATION_RATIO, MAX_REST_LIMIT_TO_CORNER_SLIP_ACCELERATION_RATIO / overshoot
        )
    )


def _least_overturning_energy_over_joints(joint_constants: ContactSpringsAndPatchesOfStack) -> float:
    """Return the smallest energy (J) that overturns all stones above a joint of a stack over its nearest side."""
    return min(
        patch.mass_above
        * STANDARD_GRAVITY
        * (
            math.sqrt(distance**2 + patch.height_of_centre_of_all_mass_above**2)
            - patch.height_of_centre_of_all_mass_above
        )
        for distance, patch in zip(
            joint_constants.nearest_side_distances_from_projected_mass_centre,
            joint_constants.contact_patches,
            strict=True,
        )
    )


def _face_corner_table(stones_by_stack: list[list[StackStone]]) -> FloatArray:
    """Return the corners of all bases and upper faces, shape (stacks, stones, 2, corners, fields of `FaceCorner`)."""
    outlines = np.zeros(
        (
            len(stones_by_stack),
            len(stones_by_stack[0]),
            2,
            max(len(stone.base_corners_xy_from_centre_of_mass) for stone in stones_by_stack[0]),
            6,
        )
    )
    for index, stones in enumerate(stones_by_stack):
        for number, stone in enumerate(stones):
            for side, face in enumerate(
                (stone.base_corners_xy_from_centre_of_mass, stone.upper_face_corners_xy_from_centre_of_mass)
            ):
                outlines[index, number, side, : len(face)] = kernel_rows_of_face_corners(face)
    return outlines


def _upper_bound_of_omega_squared(stones: list[StackStone], joint_constants: ContactSpringsAndPatchesOfStack) -> float:
    """Return an upper bound of the highest squared angular frequency of a stack on its contact springs, 1/s²."""
    scale_factors = scale_factors_for_unit_mass_diagonal(stones)
    stiffness = scaled_stiffness_matrix_of_stack_at_rest(stones, joint_constants, scale_factors)
    return highest_eigenvalue(stiffness) * eigenvalue_bound_factor_for_inertia_products(stones)


def _longest_rocking_time_constant_over_joints_s(joint_constants: ContactSpringsAndPatchesOfStack) -> float:
    """Return the longest rocking time constant, s, over a stack's contacts; all stones above each one rock together."""
    half_width = joint_constants.nearest_side_distances_from_projected_mass_centre
    return float(
        rocking_time_constant(
            2.0 * half_width, 2.0 * joint_constants.heights_of_centre_of_all_stones_above_joints
        ).max()
    )


def plan_stack_simulation(
    model: Stack, motion: Motion, cases: Cases, numerics: NumericalOptions
) -> StackSimulationPlan:
    """Check the arguments and return the plan for simulating n cases of a 3-D stack (see `simulate_cases`)."""
    _check_stack_arguments(cases, numerics)
    sizes, which = np.unique(np.stack([cases.height, cases.b_over_h], axis=1), axis=0, return_inverse=True)
    stacks = [model.stones(float(height), float(ratio)) for height, ratio in sizes]
    _check_that_stacks_can_stand(sizes, stacks)
    joints = [joint_constants_of_stack(stones, model.contact) for stones in stacks]
    tables = np.stack(
        [stone_constants_and_initial_states_table(stones, table) for stones, table in zip(stacks, joints, strict=True)]
    )
    given = np.array([np.nan if (mu := stone.base_joint_friction) is None else mu for stone in stacks[0]])
    friction = np.where(np.isnan(given), np.asarray(cases.friction)[:, None], given)
    square = np.array([_upper_bound_of_omega_squared(*one) for one in zip(stacks, joints, strict=True)])
    delay = np.array([float(table.dashpot_to_stiffness_ratios.max()) for table in joints])
    foot, reach = tables["centre_height"], tables["nearest_base_side_distance"]
    # Not np.hypot: its last digit differs between processors.
    period = np.sqrt(np.sqrt(foot**2 + reach**2) / (0.75 * STANDARD_GRAVITY)).min(axis=1)
    late = MAX_ROCKING_TIME_CONSTANTS_AFTER_RECORD * np.array(
        [_longest_rocking_time_constant_over_joints_s(one) for one in joints]
    )
    interval, samples = motion.sampling_interval, motion.sample_count
    damping = np.asarray(cases.damping_factor)
    rate = (square * delay)[which] * damping
    steps, pace = steps_per_sample_and_step_control_of_stacks(
        numerics, square[which], rate, interval, STACK_TO_BODY_WHOLE_STEP_LENGTH_RATIO * period[which]
    )
    rest_share = np.zeros(cases.case_count)
    if numerics.leave_out:
        rest_share = _rest_limit_to_onset_acceleration_ratio_by_case(stacks, joints, which, damping, interval)
    amplitude = np.asarray(cases.amplitude)
    row, cosines, along = base_motion_indices_cosines_and_accelerations(motion, cases)
    threshold = np.zeros(cases.case_count)
    for index, table in enumerate(joints):
        of_stack = which == index
        threshold[of_stack] = no_movement_below_acceleration_g_by_case(table, friction[of_stack])
    first, calm, at_rest = sample_ranges_able_to_move_3d_model_at_rest(motion, amplitude, threshold, numerics.leave_out)
    weight = tables["mass"].sum(axis=1) * STANDARD_GRAVITY
    barrier = np.array([_least_overturning_energy_over_joints(table) for table in joints])
    springs = np.array([spring_energy_at_rest(stones, table) for stones, table in zip(stacks, joints, strict=True)])
    side = np.array([table.nearest_side_distances_from_projected_mass_centre.min() for table in joints])
    case_table = np.zeros(cases.case_count, CASE_TABLE_DTYPE)
    columns = {
        "stack": which, "amplitude_factor": amplitude, "damping_factor": damping,
        "max_penetration": (MAX_PENETRATION_TO_HALF_SIDE_RATIO * np.minimum(reach, foot).min(axis=1))[which],
        "max_base_acceleration_for_sample_long_steps_g": MAX_REST_LIMIT_TO_ONSET_ACCELERATION_RATIO * threshold,
        "max_kinetic_energy_at_rest": (1e-9 * weight * reach.min(axis=1))[which],
        "min_distance_of_mass_centre_above_to_joint_side": side[which],
        "rest_limit_to_onset_acceleration_ratio": rest_share,
        "max_possible_base_acceleration_without_motion_g": rest_share * friction.min(axis=1),
        "first_simulated_sample": first, "cannot_start_moving_from_sample": calm,
        "min_overturning_energy": barrier[which],
        "spring_energy_at_rest": springs[which], "end_sample_if_undecided": samples + np.ceil(late[which] / interval),
        **pace,
    }  # fmt: skip
    for name, values in columns.items():
        case_table[name] = values
    sunk = np.array([float(table.mean_penetration_at_rest.max()) for table in joints])
    return StackSimulationPlan(
        model=model,
        motion=motion,
        cases=cases,
        numerics=numerics,
        stone_table_by_stack=tables,
        friction_by_case_and_joint=friction,
        joint_table_by_stack=np.stack([table.joint_table for table in joints]),
        base_and_upper_face_corners_by_stack=_face_corner_table(stacks),
        corner_counts_by_stone=np.array([len(stone.base_corners_xy_from_centre_of_mass) for stone in stacks[0]]),
        orientation_unit_vector_north_east=cosines,
        motion_row_by_case=row,
        base_accelerations_by_direction=along,
        steps_per_sample=steps,
        first_simulated_sample=first,
        case_table=case_table,
        stays_at_rest=at_rest,
        has_too_soft_contacts=static_penetration_exceeds_limit(sunk, 2.0 * np.minimum(foot, reach).min(axis=1))[which],
    )
