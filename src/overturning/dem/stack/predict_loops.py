"""Loops over the stacks computed in parallel that predict a step and solve its equations."""

from typing import Any

from numba import njit

from overturning.dem.body.centred import step_is_short_enough_for_predicted_forces
from overturning.dem.body.rotation import rotation_and_angular_velocity_after_step
from overturning.dem.body.state import LONGEST_LANDING_TIME_WITHOUT_LOADED_POINTS_S
from overturning.dem.body.vectors import (
    SymmetricMatrix,
    Vector3,
    extrapolate_vector,
    minus,
    rotation_matrix,
    scale_vector,
)
from overturning.dem.kernel.ground import base_acceleration_in_this_or_next_sample as push_at
from overturning.dem.kernel.lanes import (
    INLINE_OPTIONS,
    NO_ALIAS_COMPILE_OPTIONS,
    assume_lane_count_is_multiple_of_8,
    create_tuple_sum_difference_and_maximum_functions,
)
from overturning.dem.stack.access import (
    create_zero_contact_changes,
    create_zero_energy_losses,
    load_clock_within_sample,
    load_diagonal_block_and_right_side,
    load_flat_landing_times_and_point_heights,
    load_gravity_and_inertial_acceleration,
    load_inertial_and_upward_base_accelerations,
    load_joint_constants,
    load_joint_equations,
    load_joint_frame,
    load_joint_state_at_step_start,
    load_next_step_to_attempt,
    load_normal_force_and_derivative_sums,
    load_point_position,
    load_point_state_at_step_start,
    load_predicted_stone,
    load_relative_motion,
    load_step_lengths_and_doubling_counts,
    load_stone_constants,
    load_stone_state,
    load_tick_length_failure_and_rest_limits,
    load_velocity_correction,
    load_velocity_correction_coefficients,
    store_assumed_joint_friction_state,
    store_clock_within_sample,
    store_diagonal_block_and_right_side,
    store_flat_landing_times_and_point_heights,
    store_force_sums,
    store_gravity_and_inertial_acceleration,
    store_joint_equations,
    store_largest_contact_changes,
    store_normal_force_and_derivative_sums,
    store_power_loss_and_lost_spring_energy,
    store_predicted_stone,
    store_stone_axes,
    store_velocity_correction,
    store_velocity_correction_coefficients,
)
from overturning.dem.stack.joint import predict_friction, predicted_joint_force_moment_and_derivatives
from overturning.dem.stack.joint_point import (
    normal_force_sum_terms_of_point,
    predicted_force_per_stiffness_share_and_contact,
)
from overturning.dem.stack.joint_state import (
    FlatLandingTimesLeftAndPointHeights,
    JointFrictionSolutionInputs,
    JointNormalForceSumsWithDerivatives,
)
from overturning.dem.stack.landing import (
    LANDING_TIME_PLACEHOLDER_WITHOUT_POINTS_S,
    add_point_to_landing_times_and_height_range,
    flat_landing_of_stone_is_under_way,
    point_contact_is_deferred,
)
from overturning.dem.stack.solve import (
    add_wrenches_or_velocities,
    eliminate_stone_from_equations,
    half_step_times_change_of_force_and_moment,
    mass_matrix_of_stone,
    matrix_6x6_times_wrench,
    rotate_contact_equations,
    solve_velocity_correction_of_lowest_stone,
)
from overturning.dem.stack.state import (
    DiagonalBlockAndRightSide,
    ForceAndMomentOrVelocities,
    PredictedStone,
    StackClockWithinSample,
    StoneContactForceSums,
    StoneState,
    StoneVelocityCorrection,
)
from overturning.units import STANDARD_GRAVITY as GRAVITY

add_normal_force_sums = create_tuple_sum_difference_and_maximum_functions(JointNormalForceSumsWithDerivatives).plus
create_zero_normal_force_sums = create_tuple_sum_difference_and_maximum_functions(
    JointNormalForceSumsWithDerivatives
).zero
create_zero_stone_force_and_impulse_sums = create_tuple_sum_difference_and_maximum_functions(StoneContactForceSums).zero
create_zero_wrench = create_tuple_sum_difference_and_maximum_functions(ForceAndMomentOrVelocities).zero


@njit(**INLINE_OPTIONS)
def predict_stone_at_step_end(
    mass_times_inverse_inertia: SymmetricMatrix, state_at_step_start: StoneState, step_length_s: float
) -> PredictedStone:
    """Predict pose and velocities of a stone at the end of a step, with constant force and moment."""
    half = 0.5 * step_length_s
    v, momentum = (
        extrapolate_vector(
            state_at_step_start.velocity_relative_to_base, half, state_at_step_start.acceleration_relative_to_base
        ),
        extrapolate_vector(
            state_at_step_start.angular_momentum_per_mass, half, state_at_step_start.contact_moment_per_mass
        ),
    )
    turn, spin = rotation_and_angular_velocity_after_step(
        mass_times_inverse_inertia,
        state_at_step_start.rotation,
        momentum,
        state_at_step_start.contact_moment_per_mass,
        step_length_s,
    )
    return PredictedStone(
        centre_position=extrapolate_vector(state_at_step_start.centre_position, step_length_s, v),
        rotation=turn,
        velocity_at_half_step=v,
        angular_momentum_per_mass_at_half_step=momentum,
        end_velocity=extrapolate_vector(v, half, state_at_step_start.acceleration_relative_to_base),
        end_angular_velocity=spin,
    )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def start_step_and_predict_inertial_acceleration(case_rows: Any, lane_count: int, ticks_per_sample: float) -> None:
    """Start each stack's attempted step: set its length, and the inertial acceleration (with gravity) at its end.

    Contact changes and energy losses of the step are cleared.
    """
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        length = load_next_step_to_attempt(case_rows, j).length_in_ticks
        time = load_clock_within_sample(case_rows, j)
        shaking = load_inertial_and_upward_base_accelerations(case_rows, j)
        tick = time.ticks_since_sample_start + length
        past = tick - ticks_per_sample
        past = past if past > 0.0 else 0.0
        store_gravity_and_inertial_acceleration(case_rows, j, Vector3(
            push_at(shaking.negative_of_base_acceleration_x, tick, past), push_at(shaking.inertial_acceleration_y, tick,
            past),
            -(GRAVITY + push_at(shaking.upward_base_acceleration, tick, past)),
        ))  # fmt: skip
        store_clock_within_sample(
            case_rows,
            j,
            StackClockWithinSample(
                time.ticks_since_sample_start,
                0.5 * (load_tick_length_failure_and_rest_limits(case_rows, j).tick_length_s * length),
            ),
        )
        store_largest_contact_changes(case_rows, j, create_zero_contact_changes())
        store_power_loss_and_lost_spring_energy(case_rows, j, create_zero_energy_losses())


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def predict_stone_motion_and_equations(case_rows: Any, stone_rows: Any, lane_count: int) -> None:
    """Predict pose and velocities of one stone of each stack at the step end, and set up its equations of motion."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        constants = load_stone_constants(stone_rows, j)
        state = load_stone_state(stone_rows, j)
        half = load_clock_within_sample(case_rows, j).half_step_length_s
        predicted = predict_stone_at_step_end(constants.mass_times_inverse_inertia, state, 2.0 * half)
        axes = rotation_matrix(predicted.rotation)
        store_predicted_stone(stone_rows, j, predicted)
        store_stone_axes(stone_rows, j, axes)
        store_diagonal_block_and_right_side(stone_rows, j, DiagonalBlockAndRightSide(
            mass_matrix_of_stone(constants.mass, constants.inertia_per_mass, axes),
            half_step_times_change_of_force_and_moment(
                half, constants.mass, create_zero_wrench(), load_gravity_and_inertial_acceleration(case_rows, j),
                ForceAndMomentOrVelocities(state.acceleration_relative_to_base, state.contact_moment_per_mass),
            ),
        ))  # fmt: skip
        store_force_sums(stone_rows, j, create_zero_stone_force_and_impulse_sums())


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def reset_landing_extremes_and_normal_force_sums(joint_rows: Any, lane_count: int) -> None:
    """Reset flat-landing times, height range and force sums of the contact points of two stones, for all stacks."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        # At the start of a case no point has a history yet, but the joint is loaded: its points do not land.
        longest = (
            0.0
            if load_joint_state_at_step_start(joint_rows, j).normal_force > 0.0
            else LONGEST_LANDING_TIME_WITHOUT_LOADED_POINTS_S
        )
        store_flat_landing_times_and_point_heights(
            joint_rows,
            j,
            FlatLandingTimesLeftAndPointHeights(
                LANDING_TIME_PLACEHOLDER_WITHOUT_POINTS_S,
                longest,
                LANDING_TIME_PLACEHOLDER_WITHOUT_POINTS_S,
                -LANDING_TIME_PLACEHOLDER_WITHOUT_POINTS_S,
            ),
        )
        store_normal_force_and_derivative_sums(joint_rows, j, create_zero_normal_force_sums())


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def include_point_in_joint_landing_times_and_heights(joint_rows: Any, point_rows: Any, lane_count: int) -> None:
    """Include a contact point in the flat-landing times and height range of two stones' contact, for all stacks."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        store_flat_landing_times_and_point_heights(
            joint_rows,
            j,
            add_point_to_landing_times_and_height_range(
                load_flat_landing_times_and_point_heights(joint_rows, j),
                load_point_state_at_step_start(point_rows, j),
                load_point_position(point_rows, j),
            ),
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def predict_normal_force_and_add_to_joint_sums(
    case_rows: Any, joint_rows: Any, point_rows: Any, lane_count: int
) -> None:
    """Predict the normal force at a contact point of two stones and add it to their contact's sums, in all stacks."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        joint = load_joint_constants(joint_rows, j)
        frame = load_relative_motion(joint_rows, j)
        place = load_point_position(point_rows, j)
        landing = load_flat_landing_times_and_point_heights(joint_rows, j)
        old = load_point_state_at_step_start(point_rows, j)
        half = load_clock_within_sample(case_rows, j).half_step_length_s
        waits = point_contact_is_deferred(
            joint, landing, place, old, frame.smallest_distance_of_base_corners_inside_rim
        )
        fine = step_is_short_enough_for_predicted_forces(
            load_step_lengths_and_doubling_counts(case_rows, j), load_next_step_to_attempt(case_rows, j)
        )
        pressure, on = predicted_force_per_stiffness_share_and_contact(
            joint, frame, place, old, (fine, flat_landing_of_stone_is_under_way(landing), waits)
        )
        terms = normal_force_sum_terms_of_point(joint, half, place, pressure, on)
        store_normal_force_and_derivative_sums(
            joint_rows, j, add_normal_force_sums(load_normal_force_and_derivative_sums(joint_rows, j), terms)
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def predict_joint_friction_and_equations(
    case_rows: Any, upper_stone_rows: Any, joint_rows: Any, lane_count: int
) -> None:
    """Predict the friction between a stone and its support, and the equation terms of their contact, for all stacks."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        joint = load_joint_constants(joint_rows, j)
        frame = load_relative_motion(joint_rows, j)
        sums = load_normal_force_and_derivative_sums(joint_rows, j)
        old = load_joint_state_at_step_start(joint_rows, j)
        half = load_clock_within_sample(case_rows, j).half_step_length_s
        flat = flat_landing_of_stone_is_under_way(load_flat_landing_times_and_point_heights(joint_rows, j))
        fine = step_is_short_enough_for_predicted_forces(
            load_step_lengths_and_doubling_counts(case_rows, j), load_next_step_to_attempt(case_rows, j)
        )
        foot = load_stone_constants(upper_stone_rows, j).centre_height
        friction = predict_friction(joint, frame, sums, old, JointFrictionSolutionInputs(half, fine, flat, foot))
        store_assumed_joint_friction_state(joint_rows, j, friction)
        normal = sums.normal_force if fine else old.normal_force
        store_joint_equations(
            joint_rows, j, predicted_joint_force_moment_and_derivatives(joint, sums, friction, half, normal)
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def rotate_joint_equations_to_ground_axes(joint_rows: Any, lane_count: int) -> None:
    """Rotate the contact force of two stones and its derivatives in the equations from contact to ground axes."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        axes = load_joint_frame(joint_rows, j).axes
        store_joint_equations(joint_rows, j, rotate_contact_equations(axes, load_joint_equations(joint_rows, j)))


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def eliminate_upper_stone_of_each_stack(
    case_rows: Any, upper_stone_rows: Any, lower_stone_rows: Any, joint_rows: Any, lane_count: int
) -> None:
    """Eliminate the velocity corrections of one upper stone of each stack from the equations of motion.

    All stacks are treated in parallel.
    """
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        below, origin = load_predicted_stone(lower_stone_rows, j), load_joint_frame(joint_rows, j).origin
        solution, rest = eliminate_stone_from_equations(
            load_diagonal_block_and_right_side(upper_stone_rows, j),
            load_diagonal_block_and_right_side(lower_stone_rows, j),
            load_joint_equations(joint_rows, j), load_clock_within_sample(case_rows, j).half_step_length_s,
            minus(origin, load_predicted_stone(upper_stone_rows, j).centre_position),
            minus(origin, below.centre_position),
        )  # fmt: skip
        store_velocity_correction_coefficients(upper_stone_rows, j, solution)
        store_diagonal_block_and_right_side(lower_stone_rows, j, rest)


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def solve_velocity_corrections_of_lowest_stones(
    case_rows: Any, lowest_stone_rows: Any, joint_rows: Any, lane_count: int
) -> None:
    """Solve the equations of the lowest stone of each stack for its velocity correction."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        arm = scale_vector(-1.0, load_predicted_stone(lowest_stone_rows, j).centre_position)
        e = solve_velocity_correction_of_lowest_stone(
            load_diagonal_block_and_right_side(lowest_stone_rows, j),
            load_joint_equations(joint_rows, j),
            load_clock_within_sample(case_rows, j).half_step_length_s,
            arm,
        )
        store_velocity_correction(
            lowest_stone_rows, j, StoneVelocityCorrection(e.force_or_velocity, e.moment_or_angular_velocity)
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def back_substitute_upper_stone_velocity_corrections(
    upper_stone_rows: Any, lower_stone_rows: Any, lane_count: int
) -> None:
    """Compute the velocity correction of an upper stone from that of the stone below, for all stacks in parallel."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        solution, below = (
            load_velocity_correction_coefficients(upper_stone_rows, j),
            load_velocity_correction(lower_stone_rows, j),
        )
        e = add_wrenches_or_velocities(
            solution.constant_part_of_correction,
            matrix_6x6_times_wrench(
                solution.factor_of_correction_below, ForceAndMomentOrVelocities(below.velocity, below.angular_velocity)
            ),
        )
        store_velocity_correction(
            upper_stone_rows, j, StoneVelocityCorrection(e.force_or_velocity, e.moment_or_angular_velocity)
        )
