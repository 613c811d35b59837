"""Plan of the cases of a scene of polygons: variants, time steps, and samples that can be skipped."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.kernel.clock import SCENE_STEP_CONTROL
from overturning.dem.limits import MAX_ROCKING_TIME_CONSTANTS_AFTER_RECORD
from overturning.dem.numerics import ELEMENT_STEP_COST_IN_BLOCK_STEPS, NumericalOptions
from overturning.dem.path import PlanarSceneTrajectory
from overturning.dem.plan import SimulationPlan, azimuth_row_by_case_and_base_accelerations, check_trajectory_size
from overturning.dem.polygon import arrays as t
from overturning.dem.polygon import tables
from overturning.dem.polygon.path import (
    BASE_ACCELERATION_COLUMN,
    TIME_COLUMN,
    TRAJECTORY_COLUMNS_PER_ELEMENT,
    count_trajectory_columns,
    planar_trajectory_of_scene,
)
from overturning.dem.polygon.prepare import SceneEquilibriumStiffnessAndRockingLimits, prepare_scene
from overturning.dem.polygon.rows import PARALLEL_CASE_COUNT
from overturning.dem.polygon.rules import SCHEME_CONSTANTS, SceneKernelInput
from overturning.dem.quiet import (
    MAX_SCENE_REST_LIMIT_TO_ONSET_ACCELERATION_RATIO,
    SIMULATION_START_TO_ONSET_THRESHOLD_RATIO,
    dynamic_to_static_force_ratio_upper_bound,
    largest_acceleration_without_motion_g,
    simulated_sample_ranges_and_stays_at_rest,
)
from overturning.dem.time_step import (
    DAMPING_RATIO_ABOVE_WHICH_CENTRED_STEP_SHRINKS,
    IntegrationScheme,
    parse_scheme,
    steps_per_sample,
    steps_per_sample_from_stable_step,
)
from overturning.errors import ArgumentError
from overturning.model.cases import Cases
from overturning.model.contact import check_static_penetration_exceeds_rounding
from overturning.model.planes import PlanarModel
from overturning.model.scene import Scene
from overturning.model.status import CaseStatus
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY

UPLIFT_ACCELERATION_SAFETY_FACTOR: Final = 0.7
"""Safety factor on the uplift acceleration of a group that can rock as one: weaker shaking leaves it standing, even
after another element has fallen."""


@dataclass(frozen=True, kw_only=True)
class PolygonSimulationPlan(SimulationPlan):
    """Plan of the simulation of n cases of a scene of polygons."""

    shares_long_queue_between_two_threads: ClassVar[bool] = True
    step_cost_in_block_steps: ClassVar[int] = ELEMENT_STEP_COST_IN_BLOCK_STEPS
    index_or_field_name_of_trajectory_time: ClassVar[Any] = (..., TIME_COLUMN)
    trajectory_columns_of_base_acceleration: ClassVar[Any] = ((..., BASE_ACCELERATION_COLUMN),)

    model: PlanarModel
    scheme: IntegrationScheme
    prepared_scenes_by_size_and_damping: list[SceneEquilibriumStiffnessAndRockingLimits]  # the scene at each size
    scene_variant_index_by_case: NDArray[np.int64]  # shape (n,): index of each case's variant
    rocking_groups_immovable_from_sample: FloatArray  # see `SceneKernelInput`
    scene_arrays: t.SceneArrays

    def create_result_tables(self, case_count: int) -> dict[str, NDArray[np.void]]:
        """Return the tables that the kernel fills: ``results``, shape (cases,), and ``each``, (cases, elements)."""
        each = (case_count, self.scene_arrays.fall_and_support_table.shape[1])
        return {
            "results": np.zeros(case_count, tables.RESULT_TABLE_DTYPE),
            "each": np.zeros(each, tables.ELEMENT_RESULT_TABLE_DTYPE),
        }

    def kernel_input(
        self, case_numbers: NDArray[np.int64], result_tables: dict[str, NDArray[np.void]], step_divisor: int
    ) -> SceneKernelInput:
        """Return the scene kernel's input for cases with equal steps per sample, steps divided by `step_divisor`."""
        scheme = SCHEME_CONSTANTS[self.scheme]
        return SceneKernelInput(
            **self.common_kernel_input_fields(
                case_numbers, result_tables, step_divisor, scheme.ticks_per_whole_step, PARALLEL_CASE_COUNT
            ),
            scheme_constants=scheme,
            rocking_groups_immovable_from_sample=self.rocking_groups_immovable_from_sample[case_numbers],
            scene_variant_index_by_case=self.scene_variant_index_by_case[case_numbers],
            scene_arrays=self.scene_arrays,
            element_result_table=result_tables["each"],
        )

    def outcome_arrays_by_variable_name(
        self, case_numbers: NDArray[np.int64], result_tables: dict[str, NDArray[np.void]]
    ) -> dict[str, Any]:
        """Return outcome variables of cases by name; a case becomes `UNSTABLE` if an element slid off the ground."""
        out, every, variant = (
            result_tables["results"],
            result_tables["each"],
            self.scene_variant_index_by_case[case_numbers],
        )
        edge = np.array(
            [item.slip_distance_to_ground_edge_by_element for item in self.prepared_scenes_by_size_and_damping]
        )[variant]
        off_the_edge = (every["peak_slip"] >= edge).any(axis=1) & (out["status"] == CaseStatus.SIMULATED)
        out["status"][off_the_edge] = CaseStatus.UNSTABLE
        every["peak_rotation"] /= np.stack(
            [item.tipping_angles_or_one_degree_in_rad for item in self.prepared_scenes_by_size_and_damping]
        )[variant]
        free = self.prepared_scenes_by_size_and_damping[0].free_element_indices
        each = every[:, free[0]] if len(free) == 1 else every[:, free]
        return {name: table[name] for table in (out, each) for name in table.dtype.names or ()}

    def create_trajectory_buffer(self, is_recorded: bool) -> FloatArray:
        """Return a trajectory array of zeros, shape (rows, columns); without rows if no trajectory `is_recorded`."""
        if not is_recorded:
            return np.zeros((0, 0))
        last = int(
            max(self.case_table[0]["end_sample_if_undecided"], self.case_table[0]["earliest_end_sample_if_decided"])
        )
        rows, columns = (
            last - int(self.first_simulated_sample[0]) + 3,
            count_trajectory_columns(self.prepared_scenes_by_size_and_damping[0]),
        )
        check_trajectory_size(rows * columns)
        return np.zeros((rows, columns))

    def extend_trajectory_rows_of_scene_or_stack(
        self,
        trajectory_rows: FloatArray,
        added_time_s: float,
        has_fallen_by_element: NDArray[np.bool_],  # noqa: ARG002
    ) -> FloatArray:
        """Return the trajectory of the case, computed again for `added_time_s` seconds longer than the given one.

        The given trajectory is returned if the longer computation does not reproduce its rows.
        """
        interval, table = self.motion.sampling_interval, self.case_table.copy()
        table["earliest_end_sample_if_decided"] = np.ceil((trajectory_rows[-1, TIME_COLUMN] + added_time_s) / interval)
        plan = replace(self, case_table=table)
        _, longer = plan.simulate_group_with_reruns_on_energy_error(
            np.zeros(1, np.int64), np.zeros(1, np.int64), plan.create_trajectory_buffer(is_recorded=True)
        )
        poses = slice(0, 2 + TRAJECTORY_COLUMNS_PER_ELEMENT * len(self.prepared_scenes_by_size_and_damping[0].elements))
        same = len(longer) > len(trajectory_rows) and np.array_equal(
            longer[: len(trajectory_rows), poses], trajectory_rows[:, poses]
        )
        return longer if same else trajectory_rows

    def trajectory_rows_at_rest(self, sample_count: int) -> FloatArray:
        """Return trajectory rows with the scene at rest, one for each of the first `sample_count` samples."""
        prepared = self.prepared_scenes_by_size_and_damping[0]
        rest, poses_end = (
            np.zeros((sample_count, count_trajectory_columns(prepared))),
            2 + TRAJECTORY_COLUMNS_PER_ELEMENT * len(prepared.elements),
        )
        rest[:, poses_end:] = np.nan
        rest[:, TIME_COLUMN] = np.arange(sample_count) * self.motion.sampling_interval
        rest[:, BASE_ACCELERATION_COLUMN] = (
            self.base_accelerations_by_direction[0, :sample_count] * self.case_table[0]["amplitude_factor"]
        )
        for index, item in enumerate(prepared.elements):
            pose = np.array([item.centre_of_mass_x, item.centre_of_mass_z, 0.0]) + prepared.static_displacements[index]
            rest[:, 2 + TRAJECTORY_COLUMNS_PER_ELEMENT * index : 5 + TRAJECTORY_COLUMNS_PER_ELEMENT * index] = pose
        return rest

    def convert_trajectory_rows(self, trajectory_rows: FloatArray) -> PlanarSceneTrajectory:
        """Convert the kernel's output rows of the plan's only case to a `PlanarSceneTrajectory`."""
        return planar_trajectory_of_scene(self.prepared_scenes_by_size_and_damping[0], trajectory_rows)


def plan_scene_simulation(
    model: PlanarModel, motion: Motion, cases: Cases, numerics: NumericalOptions
) -> PolygonSimulationPlan:
    """Check the arguments and return the plan for simulating n cases of a 2-D scene (see `simulate_cases`)."""
    scheme, scene = parse_scheme(numerics.scheme), model.scene
    if np.asarray(cases.initial_tilt).any():
        raise ArgumentError("initial_tilt: a scene starts at rest; rotate an element in the scene file instead")
    keys = np.stack([np.asarray(cases.height), np.asarray(cases.b_over_h), np.asarray(cases.damping_factor)], axis=1)
    distinct, variant = np.unique(keys, axis=0, return_inverse=True)
    variant = variant.reshape(-1)
    variants = [prepare_scene(scene, float(height), float(ratio)) for height, ratio, _ in distinct]
    _check_stiffness_and_same_contacts_at_all_sizes(scene, variants)
    row, ground = azimuth_row_by_case_and_base_accelerations(motion, cases)
    square = np.array([item.max_omega_squared_on_springs for item in variants])
    rate = np.array([item.max_dashpot_eigenvalue for item in variants]) * distinct[:, 2]
    time = np.array([item.shortest_rocking_time_constant for item in variants])
    per_sample, finest, divided = steps_per_sample_shortest_step_auto_to_requested_ratio(
        scheme, numerics.time_step, square, rate, motion.sampling_interval, time
    )
    # 1/p with p = √(3g/4R).
    slowest = np.sqrt(
        np.array([item.half_diagonal_of_scene_height_and_widest_element for item in variants]) / (0.75 * scene.gravity)
    )[variant]
    table = np.zeros(cases.case_count, tables.CASE_TABLE_DTYPE)
    table["amplitude_factor"], table["dashpot_coefficient_multiplier"] = cases.amplitude, cases.damping_factor
    table["friction_coefficient_if_law_has_none"] = cases.friction
    table["cannot_start_moving_from_sample"] = np.inf
    table["end_sample_if_undecided"] = motion.sample_count + np.ceil(
        MAX_ROCKING_TIME_CONSTANTS_AFTER_RECORD * slowest / motion.sampling_interval
    )
    table["min_allowed_step_ticks"] = finest[variant]
    # A shorter time step divides every step; the same time after a contact change then takes more of them.
    table["steps_before_doubling_after_contact_change"] = np.round(
        SCENE_STEP_CONTROL.steps_of_equal_length_before_doubling(square, rate) * divided * numerics.refinement
    )[variant]
    table["longest_step_with_all_contacts_closed_ticks"] = SCENE_STEP_CONTROL.ticks_per_whole_step
    table["long_steps_before_doubling"] = SCENE_STEP_CONTROL.long_steps_before_doubling
    first, stays_at_rest = np.zeros(cases.case_count, np.int64), np.zeros(cases.case_count, np.bool_)
    group_count = len(variants[0].lowest_and_last_element_index_by_rocking_group)
    groups_immovable_from = np.full((cases.case_count, group_count), np.inf)
    if numerics.leave_out:
        # Thresholds are shares of gravity: dividing amplitudes by this ratio gives the equivalent motion on Earth.
        share = scene.gravity / STANDARD_GRAVITY
        amplitude = np.asarray(cases.amplitude) / share
        quiet = partial(
            simulated_sample_ranges_and_stays_at_rest, motion, row, amplitude, ground[:, : motion.sample_count]
        )
        onset = np.zeros(cases.case_count)
        for number, item in enumerate(variants):
            onset[variant == number] = item.motion_onset_acceleration_g(np.asarray(cases.friction)[variant == number])
        first, calm, stays_at_rest = quiet(onset)
        first[onset <= 0], stays_at_rest[onset <= 0] = 0, False
        if scheme == IntegrationScheme.CENTRED:
            # Under lower gravity a vertical motion changes the weight by a larger share: do not skip samples then.
            rest_limit = _rest_acceleration_limits_g_of_cases(variants, variant, cases, onset, motion.sampling_interval)
            table["max_base_acceleration_without_motion_g"] = rest_limit * (
                share if motion.up is None else float(share >= 1.0)
            )
        table["first_simulated_sample"] = first
        table["cannot_start_moving_from_sample"] = np.where(onset <= 0, np.inf, calm)
        groups_immovable_from = _samples_from_which_rocking_element_groups_stay_at_rest(variants, variant, cases, quiet)
    return PolygonSimulationPlan(
        model=model, motion=motion, cases=cases, numerics=numerics, scheme=scheme, motion_row_by_case=row,
        base_accelerations_by_direction=ground, steps_per_sample=per_sample[variant] * numerics.refinement,
        first_simulated_sample=first, stays_at_rest=stays_at_rest,
        has_too_soft_contacts=np.array([item.has_too_soft_contacts_or_invalid_placement for item in variants])[variant],
        prepared_scenes_by_size_and_damping=variants, scene_variant_index_by_case=variant,
        case_table=table, rocking_groups_immovable_from_sample=groups_immovable_from,
        scene_arrays=t.build_scene_arrays(variants),
    )  # fmt: skip


def _samples_from_which_rocking_element_groups_stay_at_rest(
    prepared_scenes_by_size_and_damping: list[SceneEquilibriumStiffnessAndRockingLimits],
    scene_variant_index_by_case: NDArray[np.int64],
    cases: Cases,
    find_simulated_samples_by_onset_acceleration_g: Callable[
        [FloatArray], tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.bool_]]
    ],
) -> FloatArray:
    """Return the sample from which each group of elements that can rock as one body stays at rest.

    The result has the shape (cases, groups). `find_simulated_samples_by_onset_acceleration_g` calls
    `simulated_sample_ranges_and_stays_at_rest` for the motion, with the onset acceleration |a|/g of each case.
    """
    friction = np.asarray(cases.friction)
    # An element that starts to slide may slide off its support.
    grip = np.zeros(cases.case_count)
    for number, item in enumerate(prepared_scenes_by_size_and_damping):
        of_variant = scene_variant_index_by_case == number
        grip[of_variant] = item.sliding_onset_acceleration_g(friction[of_variant])
    groups = prepared_scenes_by_size_and_damping[0].lowest_and_last_element_index_by_rocking_group
    samples = np.zeros((cases.case_count, len(groups)))
    alike = all(
        np.array_equal(item.lowest_and_last_element_index_by_rocking_group, groups)
        for item in prepared_scenes_by_size_and_damping
    )
    for group in range(len(groups)):
        uplift = [
            item.rocking_onset_acceleration_g_by_group[group] if alike else 0.0
            for item in prepared_scenes_by_size_and_damping
        ]
        safe = UPLIFT_ACCELERATION_SAFETY_FACTOR * np.array(uplift)[scene_variant_index_by_case]
        samples[:, group] = find_simulated_samples_by_onset_acceleration_g(
            np.minimum(safe, grip) / SIMULATION_START_TO_ONSET_THRESHOLD_RATIO
        )[1]
    return samples


def _rest_acceleration_limits_g_of_cases(
    prepared_scenes_by_size_and_damping: list[SceneEquilibriumStiffnessAndRockingLimits],
    scene_variant_index_by_case: NDArray[np.int64],
    cases: Cases,
    no_movement_below_acceleration_g_by_case: FloatArray,
    sampling_interval: float,
) -> FloatArray:
    """Return the base acceleration |a|/g up to which a scene at rest stays at rest, for each case, shape (cases,)."""
    lifts, slowest = (
        np.array([getattr(item, name) for item in prepared_scenes_by_size_and_damping])
        for name in ("no_rocking_below_acceleration_g", "min_omega_squared_on_springs")
    )
    laws = [item.pair_contact_laws for item in prepared_scenes_by_size_and_damping]
    delay = np.array(
        [np.min(one.dashpot_coefficient / np.maximum(one.normal_stiffness, one.tangential_stiffness)) for one in laws]
    )[scene_variant_index_by_case]
    rings = dynamic_to_static_force_ratio_upper_bound(
        slowest[scene_variant_index_by_case], delay * np.asarray(cases.damping_factor), sampling_interval
    )
    # `onset`, the smallest of all frictions and thresholds, replaces the threshold of sliding.
    return largest_acceleration_without_motion_g(
        lifts[scene_variant_index_by_case],
        no_movement_below_acceleration_g_by_case,
        lifts[scene_variant_index_by_case],
        rings,
        MAX_SCENE_REST_LIMIT_TO_ONSET_ACCELERATION_RATIO,
    )


def steps_per_sample_shortest_step_auto_to_requested_ratio(
    scheme: IntegrationScheme,
    requested_time_step: float | str,
    max_omega_squared_by_variant: FloatArray,
    max_dashpot_eigenvalue_by_variant: FloatArray,
    sampling_interval: float,
    shortest_rocking_time_constant_by_variant: FloatArray,
) -> tuple[NDArray[np.int64], FloatArray, FloatArray]:
    """Return, for each scene variant (size and damping), steps per sample, finest step (ticks), and step ratio.

    The step ratio is the automatic time step over the requested one. `max_omega_squared_by_variant` and
    `max_dashpot_eigenvalue_by_variant` are the largest eigenvalues of contact springs (1/s²) and dashpots (1/s),
    `shortest_rocking_time_constant_by_variant` is 1/p (s).
    """
    if scheme != IntegrationScheme.CENTRED:
        return (
            steps_per_sample(
                scheme,
                requested_time_step,
                max_omega_squared_by_variant,
                max_dashpot_eigenvalue_by_variant,
                sampling_interval,
            ),
            np.ones(max_omega_squared_by_variant.size),
            np.ones(max_omega_squared_by_variant.size),
        )
    frequency = np.sqrt(max_omega_squared_by_variant)
    whole = np.minimum(
        SCENE_STEP_CONTROL.longest_whole_step_in_rocking_time_constants * shortest_rocking_time_constant_by_variant,
        sampling_interval,
    )
    heavy = np.maximum(
        0.5 * max_dashpot_eigenvalue_by_variant / frequency / DAMPING_RATIO_ABOVE_WHICH_CENTRED_STEP_SHRINKS, 1.0
    )
    fewest, steps = (
        steps_per_sample_from_stable_step(whole, whole, wanted, sampling_interval)
        for wanted in ("auto", requested_time_step)
    )
    # The number of halvings does not depend on the time step: a shorter one makes all steps shorter.
    halvings = np.clip(
        np.frexp(
            sampling_interval / fewest * frequency * heavy / SCENE_STEP_CONTROL.max_contact_change_step_times_omega
        )[1],
        0,
        SCENE_STEP_CONTROL.max_step_halvings,
    )
    return steps, np.ldexp(SCENE_STEP_CONTROL.ticks_per_whole_step, -halvings), steps / fewest


def _check_stiffness_and_same_contacts_at_all_sizes(
    scene: Scene, prepared_scenes_by_size_and_damping: list[SceneEquilibriumStiffnessAndRockingLimits]
) -> None:
    """Raise an `ArgumentError` if contacts are too stiff for float64, or the size changes which elements touch."""
    for item in prepared_scenes_by_size_and_damping:
        # Check as for a block as high as the scene. A contact that carries a trace of the weight is made for more.
        loaded = item.pair_contact_laws.carried_weight_at_rest > 0.0
        penetrations = item.pair_contact_laws.gravity_load_for_contact_stiffness[loaded] / (
            2.0 * item.pair_contact_laws.normal_stiffness[loaded]
        )
        check_static_penetration_exceeds_rounding(
            scene.gravity / (2.0 * penetrations), np.full(penetrations.size, item.top_height_of_free_elements), 0.0
        )
    alike = {
        (tuple(item.pairs), tuple(item.support_element_indices.tolist()), tuple(item.piece_vertex_counts))
        for item in prepared_scenes_by_size_and_damping
    }
    if len(alike) != 1:
        raise ArgumentError(
            f"scene {scene.name}: the elements that can touch depend on the size; sweep these sizes separately"
        )
