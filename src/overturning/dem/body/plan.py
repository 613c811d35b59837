"""Plan of the cases of a 3-D body: solids, contact constants, time steps, and samples that can be skipped."""

from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from overturning.arrays import FloatArray
from overturning.dem.body.path import BodyTrajectory
from overturning.dem.body.results import outcome_variables_of_bodies
from overturning.dem.body.rules import BodyKernelInput, PolygonalBaseTimeSteppingLoopTag, RoundBaseTimeSteppingLoopTag
from overturning.dem.body.state import PARALLEL_CASE_COUNT, TICKS_PER_WHOLE_STEP
from overturning.dem.body.statics import (
    MAX_CACHED_SOLIDS,
    body_pose_at_rest_on_springs,
    largest_squared_frequency_on_springs_of_any_face,
    smallest_squared_frequency_on_unit_springs,
    unloading_acceleration_g_and_min_to_mean_load,
)
from overturning.dem.body.step_control import longest_step_count_per_sample_and_step_control
from overturning.dem.body.tables import (
    CASE_TABLE_DTYPE,
    INITIAL_STATE_DTYPE,
    RESULT_TABLE_DTYPE,
    TRAJECTORY_ROW_DTYPE,
    body_constant_and_vertex_tables,
    initial_conditions_at_rest,
)
from overturning.dem.limits import (
    MAX_ROCKING_TIME_CONSTANTS_AFTER_RECORD,
    static_penetration_exceeds_limit,
)
from overturning.dem.numerics import BODY_STEP_COST_IN_BLOCK_STEPS, NumericalOptions
from overturning.dem.plan import SimulationPlan, group_numbers_of_equal_cases
from overturning.dem.quiet import (
    MAX_REST_LIMIT_TO_ONSET_ACCELERATION_RATIO,
    dynamic_to_static_force_ratio_upper_bound,
    largest_acceleration_without_motion_g,
    simulated_sample_ranges_and_stays_at_rest,
)
from overturning.dem.time_step import (
    IntegrationScheme,
    parse_scheme,
)
from overturning.errors import ArgumentError
from overturning.model.body import Body
from overturning.model.cases import Cases
from overturning.model.contact import check_static_penetration_exceeds_rounding
from overturning.model.shapes import Shape
from overturning.model.solid import RigidSolid
from overturning.motion.direction import cosine_and_sine_of_azimuth
from overturning.motion.motion import Motion
from overturning.units import STANDARD_GRAVITY


@dataclass(frozen=True, kw_only=True)
class SimulationPlan3D(SimulationPlan):
    """Plan of the simulation of n cases of a 3-D model, a body or a stack."""

    shares_long_queue_between_two_threads: ClassVar[bool] = True
    step_cost_in_block_steps: ClassVar[int] = BODY_STEP_COST_IN_BLOCK_STEPS

    ticks_per_whole_step: ClassVar[float] = TICKS_PER_WHOLE_STEP

    orientation_unit_vector_north_east: FloatArray  # shape (n, 2): direction cosines of the orientation, north and east

    @property
    def parallel_group_by_case(self) -> NDArray[np.int64]:
        """Group number of each case, shape (n,).

        The cases of a group have equal step lengths and are computed in parallel.
        """
        return group_numbers_of_equal_cases(
            self.steps_per_sample, self.case_table["longest_step_with_all_contacts_closed_ticks"]
        )

    @property
    def unscaled_upward_acceleration(self) -> FloatArray:
        """Vertical base acceleration, m/s², shape (samples + 3,): 0 after the record or without vertical motion."""
        up = super().unscaled_upward_acceleration
        return np.zeros(self.motion.sample_count + 3) if up is None else up

    def kernel_input_fields_common_to_3d_models(
        self, case_numbers: NDArray[np.int64], result_tables: dict[str, NDArray[np.void]], step_divisor: int,
        parallel_case_count: int,
    ) -> dict[str, Any]:  # fmt: skip
        """Return the kernel input fields common to all 3-D models, for a group of cases with equal step lengths.

        The time steps are divided by `step_divisor`; `parallel_case_count` cases are computed in parallel.
        """
        ticks = self.ticks_per_whole_step
        queued = self.common_kernel_input_fields(case_numbers, result_tables, step_divisor, ticks, parallel_case_count)
        # Test the lanes at the latest after the longest step: the next sample must be loaded by then.
        settings, standing = (
            queued["settings"],
            float(queued["cases"]["longest_step_with_all_contacts_closed_ticks"][0]),
        )
        queued["settings"] = settings._replace(
            attempted_steps_between_end_checks=int(settings.ticks_per_sample / standing)
        )
        queued["cases"]["long_steps_before_doubling"] *= step_divisor
        return queued


@dataclass(frozen=True, kw_only=True)
class BodySimulationPlan(SimulationPlan3D):
    """Plan of the simulation of n cases of a single rigid 3-D body."""

    result_dtype: ClassVar[Any] = RESULT_TABLE_DTYPE
    trajectory_row_dtype: ClassVar[Any] = TRAJECTORY_ROW_DTYPE
    trajectory_columns_of_base_acceleration: ClassVar[Any] = (
        "base_acceleration_x",
        "base_acceleration_y",
        "base_acceleration_z",
    )
    dataset_values_per_trajectory_row: ClassVar[int] = 19

    model: Body
    solids_by_size: list[RigidSolid]  # one for each size
    body_constants_by_size: NDArray[np.void]  # of the solids, of type `overturning.dem.body.tables.BODY_TABLE_DTYPE`
    vertices_and_base_edges_by_size: (
        FloatArray  # shape (bodies, vertices, 6): see `BodyKernelInput.vertices_and_base_edges_by_size`
    )

    @property
    def marker_whose_type_selects_base_shape_loop(self) -> Any:
        """Empty tuple whose type selects the compiled time loop: for a round base, or for a base with vertices."""
        return (
            RoundBaseTimeSteppingLoopTag()
            if self.solids_by_size[0].rim_radius > 0
            else PolygonalBaseTimeSteppingLoopTag()
        )

    def kernel_input(
        self, case_numbers: NDArray[np.int64], result_tables: dict[str, NDArray[np.void]], step_divisor: int
    ) -> BodyKernelInput:
        """Return the body kernel's input for cases with equal step lengths, each step divided by `step_divisor`."""
        return BodyKernelInput(
            **self.kernel_input_fields_common_to_3d_models(
                case_numbers, result_tables, step_divisor, PARALLEL_CASE_COUNT
            ),
            marker_whose_type_selects_base_shape_loop=self.marker_whose_type_selects_base_shape_loop,
            body_constants_by_size=self.body_constants_by_size,
            vertices_and_base_edges_by_size=self.vertices_and_base_edges_by_size,
            base_vertex_count=self.solids_by_size[0].base_vertex_count,
            lean_sector_vectors_and_fall_limits_by_size=np.stack(
                [body.lean_sector_start_vector_and_min_fall_dot_product for body in self.solids_by_size]
            ),
        )

    def outcome_arrays_by_variable_name(
        self, case_numbers: NDArray[np.int64], result_tables: dict[str, NDArray[np.void]]
    ) -> dict[str, Any]:
        """Return the outcome variables of the cases in `case_numbers` by name, each of shape (cases,)."""
        faces = [
            self.solids_by_size[index].resting_face_normals_after_fall
            for index in self.case_table["body"][case_numbers]
        ]
        orientation = np.asarray(self.cases.azimuth_deg)[case_numbers]
        cosines = self.orientation_unit_vector_north_east[case_numbers]
        return outcome_variables_of_bodies(result_tables["results"], orientation, cosines, faces)

    def trajectory_rows_at_rest(self, sample_count: int) -> NDArray[np.void]:
        """Return trajectory rows of a body at rest, one for each of the first `sample_count` samples."""
        rows, case = super().trajectory_rows_at_rest(sample_count), self.case_table[0]
        for name in INITIAL_STATE_DTYPE.names or ():
            rows[name] = case["start"][name]
        rows["base_acceleration_x"], rows["base_acceleration_y"] = (
            self.base_accelerations_by_direction[0, :, :sample_count] * case["amplitude_factor"]
        )
        rows["base_acceleration_z"] = self.unscaled_upward_acceleration[:sample_count] * case["amplitude_factor"]
        return rows

    def convert_trajectory_rows(self, trajectory_rows: NDArray[np.void]) -> BodyTrajectory:
        """Convert the kernel's trajectory rows of the plan's only case to a `BodyTrajectory`."""
        size = (float(getattr(self.cases, name)[0]) for name in ("height", "b_over_h", "aspect"))
        cosine, sine = self.orientation_unit_vector_north_east[0].tolist()
        return BodyTrajectory(trajectory_rows, (cosine, sine), *self.model.shape.drawn_corners_and_edges(*size))


def sample_ranges_able_to_move_3d_model_at_rest(
    motion: Motion,
    amplitude_factor_by_case: FloatArray,
    onset_acceleration_g_by_case: FloatArray,
    skips_quiet_samples: bool,
) -> tuple[NDArray[np.int64], FloatArray, NDArray[np.bool_]]:
    """Find the range of samples outside which a motion is too weak, in any direction, to move a 3-D model at rest.

    Return, for each case, the first sample of this range, the sample after its last one, and True if no sample can
    move the model.
    """
    count = amplitude_factor_by_case.size
    if not skips_quiet_samples:
        return np.zeros(count, np.int64), np.full(count, np.inf), np.zeros(count, np.bool_)
    # Uplift over the nearest edge needs the smallest acceleration. Between samples the length of the acceleration
    # vector is convex, so that its maximum is at a sample.
    strongest = np.sqrt(motion.north**2 + motion.east**2)[None, :]
    first, calm, rests = simulated_sample_ranges_and_stays_at_rest(
        motion, np.zeros(count, np.int64), amplitude_factor_by_case, strongest, onset_acceleration_g_by_case
    )
    return first, calm.astype(np.float64), rests


def plan_body_simulation(model: Body, motion: Motion, cases: Cases, numerics: NumericalOptions) -> BodySimulationPlan:
    """Check the arguments and return the plan for simulating n cases of a 3-D body (see `simulate_cases`)."""
    _check_body_arguments(model, cases, numerics)
    shape, contact, start = model.shape, model.contact, model.start
    sizes, which = np.unique(
        np.stack([cases.height, cases.b_over_h, cases.aspect], axis=1), axis=0, return_inverse=True
    )
    made = [_cached_solid_of_shape(shape, *size) for size in sizes.tolist()]
    laws = np.array([contact.corner_stiffness_and_damping_per_mass(body) for body in made])
    modes = np.array([largest_squared_frequency_on_springs_of_any_face(body) for body in made])
    foot = np.array([body.centre_height for body in made])
    reach = np.array([body.min_base_edge_distance_from_centre for body in made])
    base = made[0].base_vertex_count
    check_static_penetration_exceeds_rounding(0.5 * base * laws[:, 0], 2.0 * foot, 0.0)
    square = np.maximum(laws[:, 0], laws[:, 1]) * modes
    period = np.sqrt(np.sqrt(foot**2 + reach**2) / (0.75 * STANDARD_GRAVITY))
    interval, samples = motion.sampling_interval, motion.sample_count
    dashpot = laws[which, 2] * np.asarray(cases.damping_factor)
    steps, pace = longest_step_count_per_sample_and_step_control(
        numerics, square[which], dashpot * modes[which], interval, period[which]
    )
    friction, amplitude = np.asarray(cases.friction), np.asarray(cases.amplitude)
    row, cosines, along = base_motion_indices_cosines_and_accelerations(motion, cases)
    rest_limit, threshold = np.zeros(cases.case_count), np.minimum((reach / foot)[which], friction)
    leaves_out = numerics.leave_out and start is None
    first, calm, stays_at_rest = sample_ranges_able_to_move_3d_model_at_rest(motion, amplitude, threshold, leaves_out)
    if leaves_out:
        rest_limit = _rest_acceleration_limit_g_by_case(made, which, laws, dashpot, friction, interval)
    table = np.zeros(cases.case_count, CASE_TABLE_DTYPE)
    has_vertices_at_rest = start is None and made[0].rim_radius == 0.0
    columns = {
        "body": which, "point_normal_stiffness_per_mass": laws[which, 0],
        "point_tangential_stiffness_per_mass": laws[which, 1],
        "point_dashpot_constant_per_mass": dashpot, "friction": friction,
        "amplitude_factor": amplitude,
        "max_base_acceleration_without_motion_g": rest_limit,
        "first_simulated_sample": first,
        "cannot_start_moving_from_sample": calm,
        "end_sample_if_undecided": (
            samples + np.ceil(MAX_ROCKING_TIME_CONSTANTS_AFTER_RECORD * period[which] / interval)
        ),
        # The points of a rim store velocities, which would oscillate in steps of a sample.
        "max_base_acceleration_for_sample_long_steps_g": (
            MAX_REST_LIMIT_TO_ONSET_ACCELERATION_RATIO * threshold if has_vertices_at_rest else 0.0
        ),
        **pace,
    }  # fmt: skip
    for name, values in columns.items():
        table[name] = values
    poses = [body_pose_at_rest_on_springs(body, float(law[0])) for body, law in zip(made, laws, strict=True)]
    sunk = np.array([_largest_penetration_at_rest(body, pose) for body, pose in zip(made, poses, strict=True)])
    if start is None:
        table["start"] = np.array([initial_conditions_at_rest(pose) for pose in poses])[which]
    else:
        table["start"] = (
            *start.centre_position,
            *start.rest_to_initial_quaternion_wxyz,
            *start.centre_velocity,
            *start.angular_velocity,
        )
    bodies, points = body_constant_and_vertex_tables(made)
    return BodySimulationPlan(
        model=model,
        motion=motion,
        cases=cases,
        numerics=numerics,
        solids_by_size=made,
        body_constants_by_size=bodies,
        vertices_and_base_edges_by_size=points,
        orientation_unit_vector_north_east=cosines,
        motion_row_by_case=row,
        base_accelerations_by_direction=along,
        steps_per_sample=steps,
        first_simulated_sample=first,
        case_table=table,
        stays_at_rest=stays_at_rest,
        has_too_soft_contacts=static_penetration_exceeds_limit(sunk, 2.0 * np.minimum(foot, reach))[which],
    )


@lru_cache(MAX_CACHED_SOLIDS)
def _cached_solid_of_shape(shape: Shape, height: float, b_over_h: float, aspect: float) -> RigidSolid:
    """Return the solid of a shape; the same object for the same size, so that its statics are computed once."""
    return shape.solid(height, b_over_h, aspect)


def _check_body_arguments(model: Body, cases: Cases, numerics: NumericalOptions) -> None:
    """Raise an `ArgumentError` if a 3-D body cannot be simulated with these cases, scheme or initial state."""
    if parse_scheme(numerics.scheme) != IntegrationScheme.CENTRED:
        raise ArgumentError(f"scheme: {numerics.scheme!r}; a 3-D body supports only 'centred'")
    if np.asarray(cases.initial_tilt).any():
        raise ArgumentError("initial_tilt: a 3-D body starts at rest; leave it at 0")
    if not model.shape.depth_over_width_is_parameter and (np.asarray(cases.aspect) != 1.0).any():
        raise ArgumentError(f"aspect: {np.unique(cases.aspect).tolist()}; only a rectangle has one")
    start = model.start
    if start is not None and not abs(np.sum(np.square(start.rest_to_initial_quaternion_wxyz)) - 1.0) < 1e-6:
        raise ArgumentError(f"start: quaternion {start.rest_to_initial_quaternion_wxyz}; its length must be 1")


def _rest_acceleration_limit_g_by_case(
    solids_by_size: list[RigidSolid],
    solid_index_by_case: NDArray[np.int64],
    stiffnesses_and_dashpot_per_mass_by_solid: FloatArray,
    point_dashpot_constant_per_mass_by_case: FloatArray,
    friction_by_case: FloatArray,
    sampling_interval_s: float,
) -> FloatArray:
    """Return, for each case, the base acceleration |a|/g up to which a body at rest stays at rest, shape (cases,).

    See `overturning.dem.quiet.largest_acceleration_without_motion_g`. `stiffnesses_and_dashpot_per_mass_by_solid` holds
    normal and tangential stiffness (1/s²) and dashpot (1/s) of a contact point, shape (solids, 3).
    `solid_index_by_case`, `point_dashpot_constant_per_mass_by_case` (1/s) and `friction_by_case` have shape (cases,).
    """
    slowest, unloads = (
        np.array([function(body) for body in solids_by_size])
        for function in (smallest_squared_frequency_on_unit_springs, unloading_acceleration_g_and_min_to_mean_load)
    )
    ratio = np.array([body.min_base_edge_distance_from_centre / body.centre_height for body in solids_by_size])
    stiffer = np.maximum(*stiffnesses_and_dashpot_per_mass_by_solid[solid_index_by_case, :2].T)
    rings = dynamic_to_static_force_ratio_upper_bound(
        (np.minimum(*stiffnesses_and_dashpot_per_mass_by_solid[:, :2].T) * slowest)[solid_index_by_case],
        point_dashpot_constant_per_mass_by_case / stiffer,
        sampling_interval_s,
    )
    return largest_acceleration_without_motion_g(
        ratio[solid_index_by_case], friction_by_case * unloads[solid_index_by_case, 1],
        unloads[solid_index_by_case, 0], rings, MAX_REST_LIMIT_TO_ONSET_ACCELERATION_RATIO,
    )  # fmt: skip


def base_motion_indices_cosines_and_accelerations(
    motion: Motion, cases: Cases
) -> tuple[NDArray[np.int64], FloatArray, FloatArray]:
    """Return the index of each case's base motion, the direction cosines of its orientation, and all base motions.

    The shapes are (n,), (n, 2) for north and east, and (orientations, 2, samples + 3) for the base accelerations
    (m/s²) along x and y.
    """
    distinct, row = np.unique(np.asarray(cases.azimuth_deg), return_inverse=True)
    along = np.zeros((distinct.size, 2, motion.sample_count + 3))
    cosines = np.array([cosine_and_sine_of_azimuth(float(value)) for value in distinct])
    for index, orientation in enumerate(distinct):
        along[index, 0, : motion.sample_count] = motion.acceleration_along(float(orientation))
        along[index, 1, : motion.sample_count] = motion.acceleration_along(float(orientation) - 90.0)
    return row, cosines[row], along


def _largest_penetration_at_rest(body: RigidSolid, rest_position_and_rotation_vector: FloatArray) -> float:
    """Return the largest penetration (m) of a base vertex into the ground, in the pose of a body at rest."""
    x, y = body.contact_points_from_centre_of_mass[: body.base_vertex_count, :2].T
    return float(
        np.max(
            body.centre_height
            - rest_position_and_rotation_vector[2]
            - (rest_position_and_rotation_vector[3] * y - rest_position_and_rotation_vector[4] * x)
        )
    )
