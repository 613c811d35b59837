"""Plan of the cases of a single block: contact constants, time steps, and samples that can be skipped."""

from dataclasses import dataclass
from typing import Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.block.loops import CONSTANTS_AND_LOOP_CREATOR_BY_SCHEME
from overturning.dem.block.path import planar_trajectory_of_block
from overturning.dem.block.rules import BlockKernelInput
from overturning.dem.block.state import (
    MAX_CONTACT_CHANGE_TRAVEL_OVER_B_P_ALPHA_MIN_DT,
    MAX_SIMULATED_FRICTION_COEFFICIENT,
    MIN_OMEGA_DT_FOR_STANDING_STEPS_OF_ONE_SAMPLE,
    PARALLEL_CASE_COUNT,
    TICKS_PER_WHOLE_STEP,
)
from overturning.dem.block.tables import CASE_TABLE_DTYPE, RESULT_TABLE_DTYPE, TRAJECTORY_ROW_DTYPE
from overturning.dem.kernel.clock import BLOCK_STEP_CONTROL
from overturning.dem.limits import (
    MAX_PENETRATION_TO_HALF_SIDE_RATIO,
    MAX_ROCKING_TIME_CONSTANTS_AFTER_RECORD,
    static_penetration_exceeds_limit,
)
from overturning.dem.numerics import NumericalOptions
from overturning.dem.path import PlanarSceneTrajectory
from overturning.dem.plan import (
    SimulationPlan,
    azimuth_row_by_case_and_base_accelerations,
    evaluate_and_round_to_12_decimals,
    group_numbers_of_equal_cases,
)
from overturning.dem.quiet import (
    MAX_REST_LIMIT_TO_ONSET_ACCELERATION_RATIO,
    dynamic_to_static_force_ratio_upper_bound,
    largest_acceleration_without_motion_g,
    simulated_sample_ranges_and_stays_at_rest,
)
from overturning.dem.time_step import (
    IntegrationScheme,
    block_highest_eigenvalue_bound,
    block_lowest_eigenvalue,
    inverse_contact_frequency_reduced_at_high_damping,
    longest_stable_or_accurate_step,
    parse_scheme,
    requested_to_automatic_step_ratio,
    rocking_time_constant,
    steps_per_sample,
)
from overturning.model.cases import Cases
from overturning.model.contact import check_static_penetration_exceeds_rounding
from overturning.model.planes import PlanarModel
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY


@dataclass(frozen=True, kw_only=True)
class BlockSimulationPlan(SimulationPlan):
    """Plan of the simulation of a single block in n cases."""

    result_dtype: ClassVar[Any] = RESULT_TABLE_DTYPE
    trajectory_row_dtype: ClassVar[Any] = TRAJECTORY_ROW_DTYPE
    dataset_values_per_trajectory_row: ClassVar[int] = 24

    model: PlanarModel
    scheme: IntegrationScheme

    @property
    def parallel_group_by_case(self) -> NDArray[np.int64]:
        """Group number of each case, shape (n,); the cases of a group are computed in parallel.

        They have equal step lengths, and all or none of them have friction.
        """
        return group_numbers_of_equal_cases(
            self.steps_per_sample,
            self.case_table["longest_step_with_all_contacts_closed_ticks"],
            self.case_table["friction"] == 0,
        )

    def kernel_input(
        self, case_numbers: NDArray[np.int64], result_tables: dict[str, NDArray[np.void]], step_divisor: int
    ) -> BlockKernelInput:
        """Return the kernel's input for block cases with equal step lengths, all or none of them with friction.

        Each time step is divided by `step_divisor`.
        """
        scheme, queued = (
            CONSTANTS_AND_LOOP_CREATOR_BY_SCHEME[self.scheme][0],
            self.common_kernel_input_fields(
                case_numbers, result_tables, step_divisor, TICKS_PER_WHOLE_STEP, PARALLEL_CASE_COUNT
            ),
        )
        cases, settings = queued["cases"], queued.pop("settings")
        cases["long_steps_before_doubling"] *= step_divisor
        cases["max_contact_change_travel_without_halving_step"] /= step_divisor
        # Many steps between two tests of the lanes, but none beyond the next sample: the motion is loaded up to there.
        settings = settings._replace(
            attempted_steps_between_end_checks=int(
                settings.ticks_per_sample / float(cases["longest_step_with_all_contacts_closed_ticks"][0])
            )
            + scheme.max_steps_before_next_sample_is_loaded
        )
        with_friction = 0 if cases["friction"][0] > 0 else None
        return BlockKernelInput(
            settings,
            **queued,
            scheme_constants=scheme,
            none_if_all_cases_frictionless=with_friction,
            max_penetration_to_half_side_ratio=MAX_PENETRATION_TO_HALF_SIDE_RATIO,
        )

    def outcome_arrays_by_variable_name(
        self,
        case_numbers: NDArray[np.int64],  # noqa: ARG002, as in other plans
        result_tables: dict[str, NDArray[np.void]],
    ) -> dict[str, Any]:
        """Return each outcome variable by name, with a value per case: the columns of the kernel's table of results."""
        return {name: result_tables["results"][name] for name in RESULT_TABLE_DTYPE.names or ()}

    def trajectory_rows_at_rest(self, sample_count: int) -> NDArray[np.void]:
        """Return trajectory rows of a block at rest, one for each of the first `sample_count` samples."""
        rows, case = super().trajectory_rows_at_rest(sample_count), self.case_table[0]
        rows["centre_z"] = 0.5 * case["height"] - 0.5 * STANDARD_GRAVITY / case["normal_stiffness_per_mass"]
        rows["ground_acceleration"] = self.base_accelerations_by_direction[0, :sample_count] * case["amplitude_factor"]
        return rows

    def convert_trajectory_rows(self, trajectory_rows: NDArray[np.void]) -> PlanarSceneTrajectory:
        """Convert the kernel's output rows of the plan's only case to the trajectory of the block."""
        return planar_trajectory_of_block(
            self.model.scene, self.motion, self.cases, trajectory_rows, float(self.case_table[0]["critical_angle"])
        )


class StepLengthsByBlock(NamedTuple):
    """Lengths of the time steps of n blocks, arrays of shape (n,)."""

    whole_steps_per_sample: NDArray[np.int64]
    """Whole steps per sample."""
    longest_step_at_rest_in_whole_steps: NDArray[np.int64]
    """Length of a step while a block stands still on both corners, in whole steps."""
    longest_contact_change_step_s: FloatArray
    """Longest step in which a contact may open or close, s."""
    halvings_to_contact_change_step: NDArray[np.int64]
    """Halvings of a whole step down to at most that step; negative if the whole step is shorter."""
    requested_to_automatic_step_ratio: FloatArray | float
    """Ratio of the requested to the automatic step length, at most 1."""


def block_step_lengths(
    scheme: IntegrationScheme,
    numerics: NumericalOptions,
    omega_squared_of_highest_mode: FloatArray,
    two_xi_omega_of_highest_mode: FloatArray,
    sampling_interval: float,
    rocking_time_constant_by_case_s: FloatArray,
) -> StepLengthsByBlock:
    """Return the lengths of the time steps of blocks, from bounds of ω² and 2ξω of their highest contact mode.

    Arrays have a value for each case: bounds of ω² (1/s²) and of 2ξω (1/s), and the rocking time constant 1/p (s).
    `sampling_interval` is in s.
    """
    square, rate, interval, period = (
        omega_squared_of_highest_mode,
        two_xi_omega_of_highest_mode,
        sampling_interval,
        rocking_time_constant_by_case_s,
    )
    steps = steps_per_sample(scheme, numerics.time_step, square, rate, interval, period) * numerics.refinement
    standing = np.ones_like(steps)
    if scheme == IntegrationScheme.CENTRED:
        # Steps of one sample are enough while a block stands on a contact that is stiff compared with them. They are
        # divided if a shorter time step is set.
        usual = steps_per_sample(scheme, "auto", square, rate, interval, period)
        standing = np.where(
            np.sqrt(square) * interval >= MIN_OMEGA_DT_FOR_STANDING_STEPS_OF_ONE_SAMPLE, np.gcd(usual, steps), 1
        )
    # A shorter time step also shortens the finest step.
    ratio = (
        requested_to_automatic_step_ratio(
            scheme, numerics.time_step, longest_stable_or_accurate_step(scheme, square, rate, period)
        )
        / numerics.refinement
    )
    finest = (
        BLOCK_STEP_CONTROL.max_contact_change_step_times_omega
        * ratio
        * inverse_contact_frequency_reduced_at_high_damping(square, rate)
    )
    halvings = np.frexp(interval / steps / finest)[1].astype(np.int64)
    if scheme == IntegrationScheme.CENTRED:
        # If this needs more halvings than allowed, shorten the whole step.
        steps = steps << np.maximum(halvings - BLOCK_STEP_CONTROL.max_step_halvings, 0)
    return StepLengthsByBlock(steps, standing, finest, halvings, ratio)


def plan_block_simulation(
    model: PlanarModel, motion: Motion, cases: Cases, numerics: NumericalOptions
) -> BlockSimulationPlan:
    """Check the arguments and plan the simulation of a single block in n cases.

    Parameters
    ----------
    model : PlanarModel
        Single block, which gives contact law and density; height and B/H come from the cases.
    motion, cases, numerics
        See `overturning.dem.run.simulate_cases`.

    Raises
    ------
    ArgumentError
        If an argument is outside its bounds, or the time step is not stable.
    """
    ground_element, block = model.scene.elements
    law, density = model.scene.contact_law(ground_element, block), model.scene.materials[block.material].density
    scheme = parse_scheme(numerics.scheme)
    height, ratio = np.asarray(cases.height), np.asarray(cases.b_over_h)
    friction = np.asarray(cases.friction) if law.friction is None else np.full(cases.case_count, law.friction)
    amplitude, tilt = np.asarray(cases.amplitude), np.asarray(cases.initial_tilt)
    width = ratio * height
    normal, tangential, dashpot = law.contact_without_friction.corner_stiffness_and_damping_per_mass(
        width, height, density
    )
    dashpot = dashpot * np.asarray(cases.damping_factor)
    row, ground = azimuth_row_by_case_and_base_accelerations(motion, cases)
    check_static_penetration_exceeds_rounding(normal, height, 0.0)
    square = block_highest_eigenvalue_bound(normal, tangential, 0.5 * width, 0.5 * height)
    rate = block_highest_eigenvalue_bound(dashpot, dashpot, 0.5 * width, 0.5 * height)
    period = rocking_time_constant(width, height)
    interval, samples = motion.sampling_interval, motion.sample_count
    lengths = block_step_lengths(scheme, numerics, square, rate, interval, period)
    first, calm, stays_at_rest = (
        np.zeros(cases.case_count, np.int64),
        np.full(cases.case_count, np.inf),
        np.zeros(cases.case_count, np.bool_),
    )
    rest_limit = np.zeros(cases.case_count)
    if numerics.leave_out:
        first, quiet, stays_at_rest = simulated_sample_ranges_and_stays_at_rest(
            motion, row, amplitude, ground[:, :samples], np.minimum(ratio, friction)
        )
        first[tilt != 0], stays_at_rest[tilt != 0] = 0, False
        calm = quiet.astype(np.float64)
        if scheme == IntegrationScheme.CENTRED:
            slowest = block_lowest_eigenvalue(normal, tangential, 0.5 * width, 0.5 * height)
            delay = dashpot / np.maximum(normal, tangential)
            overshoot = dynamic_to_static_force_ratio_upper_bound(slowest, delay, interval)
            rest_limit = largest_acceleration_without_motion_g(
                ratio, friction, ratio, overshoot, MAX_REST_LIMIT_TO_ONSET_ACCELERATION_RATIO
            )
    table, alpha = np.zeros(cases.case_count, CASE_TABLE_DTYPE), evaluate_and_round_to_12_decimals(np.arctan, ratio)
    control, step_ratio = BLOCK_STEP_CONTROL, lengths.requested_to_automatic_step_ratio
    halvings = np.clip(lengths.halvings_to_contact_change_step, 0, control.max_step_halvings)
    columns = {
        "width": width, "height": height, "normal_stiffness_per_mass": normal,
        "tangential_stiffness_per_mass": tangential, "dashpot_constant_per_mass": dashpot,
        "friction": np.minimum(friction, MAX_SIMULATED_FRICTION_COEFFICIENT), "critical_angle": alpha,
        "amplitude_factor": amplitude, "initial_tilt": tilt, "first_simulated_sample": first,
        "initial_tilt_cosine": evaluate_and_round_to_12_decimals(np.cos, tilt),
        "initial_tilt_sine": evaluate_and_round_to_12_decimals(np.sin, tilt), "cannot_start_moving_from_sample": calm,
        "end_sample_if_undecided": samples + np.ceil(MAX_ROCKING_TIME_CONSTANTS_AFTER_RECORD * period / interval),
        "max_base_acceleration_without_motion_g": rest_limit,
        "max_contact_change_travel_without_halving_step": (
            MAX_CONTACT_CHANGE_TRAVEL_OVER_B_P_ALPHA_MIN_DT
            * lengths.longest_contact_change_step_s
            * width * alpha / period
        ),
        "min_allowed_step_ticks": np.ldexp(1.0, control.max_step_halvings - halvings),
        "longest_step_with_all_contacts_closed_ticks": (
            TICKS_PER_WHOLE_STEP * lengths.longest_step_at_rest_in_whole_steps
        ),
        "steps_before_doubling_after_contact_change": np.round(
            control.steps_of_equal_length_before_doubling(square, rate) / step_ratio
        ),
        "long_steps_before_doubling": np.round(control.long_steps_before_doubling / step_ratio),
    }  # fmt: skip
    for name, values in columns.items():
        table[name] = values
    sunk = 0.5 * STANDARD_GRAVITY / normal
    return BlockSimulationPlan(
        model=model, motion=motion, cases=cases, numerics=numerics, scheme=scheme, motion_row_by_case=row,
        base_accelerations_by_direction=ground, steps_per_sample=lengths.whole_steps_per_sample,
        first_simulated_sample=first,
        stays_at_rest=stays_at_rest, case_table=table,
        has_too_soft_contacts=static_penetration_exceeds_limit(sunk, np.minimum(width, height)),
    )  # fmt: skip
