"""Loops of the centred scheme over the bodies computed in parallel; `centred` has the equations of one body."""

from functools import cache
from typing import Any, Final

from numba import njit

from overturning.dem.body.access import (
    VALUE_COUNT_PER_VERTEX_IN_ALL_LANES,
    load_body_axes,
    load_body_constants,
    load_body_point_state_at_step_end,
    load_body_state,
    load_contact_force_sum,
    load_energy_account,
    load_extreme_vertices_and_landing_state,
    load_forces_and_velocity_derivatives,
    load_inertial_and_upward_base_accelerations,
    load_largest_contact_changes,
    load_next_step_to_attempt,
    load_peaks_and_last_upright_tick,
    load_point_state_at_step_start,
    load_predicted_body,
    load_predicted_point,
    load_step_lengths_and_doubling_counts,
    load_step_rejection_flags,
    load_termination_limits,
    load_velocity_correction,
    load_vertex,
    store_body_axes,
    store_body_point_state_at_step_end,
    store_body_state_unless_rejected,
    store_contact_force_sum,
    store_energy_and_momentum_unless_rejected,
    store_forces_and_velocity_derivatives,
    store_largest_contact_changes,
    store_next_step_to_attempt,
    store_peaks_and_upright_tick_unless_rejected,
    store_point_state_at_step_start_unless_rejected,
    store_predicted_body,
    store_predicted_point,
    store_step_rejection_flags,
    store_velocity_correction,
)
from overturning.dem.body.base_contact import (
    compute_base_contact_states,
    is_body_in_flat_landing,
    lowest_and_highest_base_points_rest,
    remaining_landing_time_of_new_contact,
    vertex_carries_no_load_until_base_ends_rest,
)
from overturning.dem.body.centred import (
    FlatLandingInputsOfContactPoint,
    contact_force_and_derivatives_of_point,
    predict_body_with_step_start_forces,
    predict_contact_point,
    rim_point_position_from_centre,
    solve_velocity_correction,
    step_is_short_enough_for_predicted_forces,
)
from overturning.dem.body.commit import (
    BodyAfterAcceptedStep,
    base_acceleration_allows_sample_long_steps,
    complete_body_step,
    compute_point_forces,
    contact_changes_in_body_step,
    lowest_rim_point_moves_too_far_in_step,
)
from overturning.dem.body.state import (
    VERTEX_ROW_LAYOUT,
    ContactForceAndMomentSum,
    ContactForcesAndNegatedVelocityDerivatives,
    ContactPointAtStepStartAndEnd,
    LargestContactChangesOfBody,
    StepRejectedAndSameContactStateFlags,
)
from overturning.dem.body.vectors import matrix_times_vector, rotation_matrix
from overturning.dem.kernel.clock import (
    BODY_STEP_CONTROL,
    decide_rejection_sliding_and_next_step,
)
from overturning.dem.kernel.lanes import (
    INTERNAL_COMPILE_OPTIONS,
    NO_ALIAS_COMPILE_OPTIONS,
    assume_lane_count_is_multiple_of_8,
    create_tuple_sum_difference_and_maximum_functions,
    select,
)

add_contact_forces_and_derivatives = create_tuple_sum_difference_and_maximum_functions(
    ContactForcesAndNegatedVelocityDerivatives
).plus
add_contact_force_and_moment_sums = create_tuple_sum_difference_and_maximum_functions(ContactForceAndMomentSum).plus
larger_value_of_each_contact_change = create_tuple_sum_difference_and_maximum_functions(
    LargestContactChangesOfBody
).largest
SLID_IN_LAST_STEP_OR_ATTEMPT_ROW_OFFSET: Final = VERTEX_ROW_LAYOUT.row_offset_of_field(
    ContactPointAtStepStartAndEnd, "at_step_start.slid_in_last_step_or_rejected_attempt"
)
"""Array index at which the flags `BodyContactPointState.slid_in_last_step_or_rejected_attempt` start."""


@njit(**INTERNAL_COMPILE_OPTIONS)
def predict_poses_and_velocities_at_step_end(body_states: Any, lane_count: int, ticks_per_sample: float) -> None:
    """Predict pose and velocities of all bodies at their step ends, with constant acceleration and contact moment."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        w = predict_body_with_step_start_forces(
            load_body_constants(body_states, j),
            load_body_state(body_states, j),
            load_next_step_to_attempt(body_states, j).length_in_ticks,
            load_inertial_and_upward_base_accelerations(body_states, j),
            ticks_per_sample,
        )
        store_predicted_body(body_states, j, w)
        store_body_axes(body_states, j, rotation_matrix(w.rotation))


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def predict_penetration_and_sliding_of_vertex_pair(
    body_states: Any, vertex_rows: Any, opposite_rows: Any, lane_count: int
) -> None:
    """Predict penetration, contact and sliding of two opposite vertices of each body at the end of the step."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        body = load_body_constants(body_states, j)
        w = load_predicted_body(body_states, j)
        f = load_body_axes(body_states, j)
        fine = step_is_short_enough_for_predicted_forces(
            load_step_lengths_and_doubling_counts(body_states, j), load_next_step_to_attempt(body_states, j)
        )
        p = load_vertex(vertex_rows, j)
        q = load_vertex(opposite_rows, j)
        base_contact = load_extreme_vertices_and_landing_state(body_states, j)
        flat = is_body_in_flat_landing(base_contact)
        new_landing = remaining_landing_time_of_new_contact(body, base_contact)
        tilting_share = base_contact.tilting_share_of_friction_moment_in_flat_landing
        a = matrix_times_vector(f, p.position_from_centre_in_body_axes)
        b = matrix_times_vector(f, q.position_from_centre_in_body_axes)
        left, right = load_point_state_at_step_start(vertex_rows, j), load_point_state_at_step_start(opposite_rows, j)
        waits = vertex_carries_no_load_until_base_ends_rest(body, base_contact, p, a.z, left)
        landing = FlatLandingInputsOfContactPoint(waits, flat, new_landing, tilting_share)
        store_predicted_point(vertex_rows, j, predict_contact_point(body, w, f, a, left, fine, False, landing))
        waits = vertex_carries_no_load_until_base_ends_rest(body, base_contact, q, b.z, right)
        landing = FlatLandingInputsOfContactPoint(waits, flat, new_landing, tilting_share)
        store_predicted_point(opposite_rows, j, predict_contact_point(body, w, f, b, right, fine, False, landing))


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def predict_contact_of_opposite_rim_points(
    body_states: Any,
    point_rows: Any,
    opposite_rows: Any,
    lane_count: int,
    unit_component_along_lean: float,
    unit_component_across_lean: float,
) -> None:
    """Predict penetration, contact and sliding of two opposite points of each body's base rim at the end of the step.

    `unit_component_along_lean` and `unit_component_across_lean` select the points (see
    `rim_point_position_from_centre`).
    """
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        body = load_body_constants(body_states, j)
        w = load_predicted_body(body_states, j)
        f = load_body_axes(body_states, j)
        fine = step_is_short_enough_for_predicted_forces(
            load_step_lengths_and_doubling_counts(body_states, j), load_next_step_to_attempt(body_states, j)
        )
        left, right, between = (
            load_point_state_at_step_start(point_rows, j),
            load_point_state_at_step_start(opposite_rows, j),
            (unit_component_across_lean != 0.0)
            & (not lowest_and_highest_base_points_rest(load_extreme_vertices_and_landing_state(body_states, j))),
        )
        base_contact = load_extreme_vertices_and_landing_state(body_states, j)
        flat = is_body_in_flat_landing(base_contact)
        new_landing = remaining_landing_time_of_new_contact(body, base_contact)
        tilting_share = base_contact.tilting_share_of_friction_moment_in_flat_landing
        a = rim_point_position_from_centre(body, f, unit_component_along_lean, unit_component_across_lean)
        b = rim_point_position_from_centre(body, f, -unit_component_along_lean, -unit_component_across_lean)
        waits = between & (left.penetration <= 0.0)
        landing = FlatLandingInputsOfContactPoint(waits, flat, new_landing, tilting_share)
        store_predicted_point(point_rows, j, predict_contact_point(body, w, f, a, left, fine, True, landing))
        waits = between & (right.penetration <= 0.0)
        landing = FlatLandingInputsOfContactPoint(waits, flat, new_landing, tilting_share)
        store_predicted_point(opposite_rows, j, predict_contact_point(body, w, f, b, right, fine, True, landing))


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def add_point_pair_terms_to_body_velocity_equations(
    body_states: Any, point_rows: Any, opposite_rows: Any, lane_count: int, none_if_first_pair: Any
) -> None:
    """Add two opposite contact points' terms to the equations for the body's velocities, for all cases in parallel.

    `none_if_first_pair` is None for the first two points of a body: their terms replace those of the last step.
    """
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        body, half = load_body_constants(body_states, j), load_predicted_body(body_states, j).half_step_length_s
        fine = step_is_short_enough_for_predicted_forces(
            load_step_lengths_and_doubling_counts(body_states, j), load_next_step_to_attempt(body_states, j)
        )
        a = contact_force_and_derivatives_of_point(
            body, half, load_predicted_point(point_rows, j), load_point_state_at_step_start(point_rows, j), fine
        )
        b = contact_force_and_derivatives_of_point(
            body, half, load_predicted_point(opposite_rows, j), load_point_state_at_step_start(opposite_rows, j), fine
        )
        part = add_contact_forces_and_derivatives(a, b)
        if none_if_first_pair is not None:
            part = add_contact_forces_and_derivatives(load_forces_and_velocity_derivatives(body_states, j), part)
        store_forces_and_velocity_derivatives(body_states, j, part)


@njit(**INTERNAL_COMPILE_OPTIONS)
def solve_velocity_corrections(body_states: Any, lane_count: int) -> None:
    """Solve the equations of the step for the velocity corrections of all bodies, in parallel."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        store_velocity_correction(body_states, j, solve_velocity_correction(
            load_body_constants(body_states, j), load_body_state(body_states, j), load_predicted_body(body_states, j),
            load_forces_and_velocity_derivatives(body_states, j),
        ))  # fmt: skip


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def compute_forces_and_states_of_opposite_points(
    body_states: Any, point_rows: Any, opposite_rows: Any, lane_count: int, base_is_round: Any, none_if_first_pair: Any
) -> None:
    """Compute forces and new states of two opposite contact points at the step end, for all cases in parallel.

    The forces and contact changes are added to those of the whole body.

    `none_if_first_pair` is None for the first two points of a body: their forces replace those of the last step.
    """
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        body = load_body_constants(body_states, j)
        w = load_predicted_body(body_states, j)
        d = load_velocity_correction(body_states, j)
        fine = step_is_short_enough_for_predicted_forces(
            load_step_lengths_and_doubling_counts(body_states, j), load_next_step_to_attempt(body_states, j)
        )
        a, findings_a, next_a = compute_point_forces(
            body,
            w,
            load_predicted_point(point_rows, j),
            load_point_state_at_step_start(point_rows, j),
            d,
            fine,
            base_is_round,
        )
        b, findings_b, next_b = compute_point_forces(
            body,
            w,
            load_predicted_point(opposite_rows, j),
            load_point_state_at_step_start(opposite_rows, j),
            d,
            fine,
            base_is_round,
        )
        store_body_point_state_at_step_end(point_rows, j, next_a)
        store_body_point_state_at_step_end(opposite_rows, j, next_b)
        forces, findings = (
            add_contact_force_and_moment_sums(a, b),
            larger_value_of_each_contact_change(findings_a, findings_b),
        )
        if none_if_first_pair is not None:
            forces, findings = (
                add_contact_force_and_moment_sums(load_contact_force_sum(body_states, j), forces),
                larger_value_of_each_contact_change(load_largest_contact_changes(body_states, j), findings),
            )
        store_contact_force_sum(body_states, j, forces)
        store_largest_contact_changes(body_states, j, findings)


@njit(**INTERNAL_COMPILE_OPTIONS)
def accept_or_reject_steps(body_states: Any, lane_count: int, ticks_per_sample: float, base_is_round: Any) -> None:
    """Accept (store the new state) or reject each body's attempted step, and choose the length of the next attempt."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        body = load_body_constants(body_states, j)
        s = load_body_state(body_states, j)
        attempt = load_next_step_to_attempt(body_states, j)
        t = load_contact_force_sum(body_states, j)
        most = load_largest_contact_changes(body_states, j)
        w, d = load_predicted_body(body_states, j), load_velocity_correction(body_states, j)
        fast = lowest_rim_point_moves_too_far_in_step(s, w, most) if base_is_round else False
        steady = base_acceleration_allows_sample_long_steps(
            load_inertial_and_upward_base_accelerations(body_states, j),
            w.negative_horizontal_and_upward_base_acceleration,
            ticks_per_sample,
            load_termination_limits(body_states, j).max_base_acceleration_for_sample_long_steps_g,
        )
        findings = contact_changes_in_body_step(most, t.force_per_mass.z, fast, steady)
        again, sooner, following = decide_rejection_sliding_and_next_step(
            BODY_STEP_CONTROL,
            load_step_lengths_and_doubling_counts(body_states, j),
            attempt,
            findings,
            s.ticks_since_sample_start + attempt.length_in_ticks,
            ticks_per_sample,
        )
        accepted = BodyAfterAcceptedStep(
            s, load_peaks_and_last_upright_tick(body_states, j), load_energy_account(body_states, j)
        )
        accepted = complete_body_step(body, accepted, w, d, t, most.largest_penetration, attempt.length_in_ticks)
        store_next_step_to_attempt(body_states, j, following)
        store_step_rejection_flags(
            body_states, j, StepRejectedAndSameContactStateFlags(1.0 if again else 0.0, 1.0 if sooner else 0.0)
        )
        store_body_state_unless_rejected(body_states, j, again, accepted.state)
        store_peaks_and_upright_tick_unless_rejected(body_states, j, again, accepted.peak_values_so_far)
        store_energy_and_momentum_unless_rejected(body_states, j, again, accepted.energy_account)


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def update_contact_point_states_after_attempted_steps(body_states: Any, point_rows: Any, lane_count: int) -> None:
    """Store a contact point's new state if its step is accepted; if not, at most the flag whether it slid."""
    for j in range(assume_lane_count_is_multiple_of_8(lane_count)):
        new, rejected = load_body_point_state_at_step_end(point_rows, j), load_step_rejection_flags(body_states, j)
        store_point_state_at_step_start_unless_rejected(point_rows, j, rejected.is_step_rejected > 0.0, new)
        point_rows[SLID_IN_LAST_STEP_OR_ATTEMPT_ROW_OFFSET + j] = select(
            rejected.next_attempt_keeps_slip_assumption > 0.0,
            point_rows[SLID_IN_LAST_STEP_OR_ATTEMPT_ROW_OFFSET + j],
            new.slid_in_last_step_or_rejected_attempt,
        )


@cache
def build_time_stepping_loop(base_is_round: bool) -> Any:
    """Return the compiled time-stepping loop for bodies with a round rim (`base_is_round`) or with base vertices.

    The loop's argument `marker_whose_type_selects_base_shape_loop` has a different type for each of the two loops, so
    that their compiled names differ.
    """

    @njit(**INTERNAL_COMPILE_OPTIONS)
    def attempt_time_steps(
        marker_whose_type_selects_base_shape_loop: Any,  # noqa: ARG001
        body_states: Any,
        vertex_rows: Any,
        vertex_count: int,
        base_vertex_count: int,
        lane_count: int,
        attempted_step_count: int,
        ticks_per_sample: float,
    ) -> None:
        """Attempt `attempted_step_count` time steps of all bodies in parallel; a rejected step is attempted again."""
        half = vertex_count // 2 * VALUE_COUNT_PER_VERTEX_IN_ALL_LANES
        for _ in range(attempted_step_count):
            predict_poses_and_velocities_at_step_end(body_states, lane_count, ticks_per_sample)
            compute_base_contact_states(body_states, vertex_rows, half, base_vertex_count, lane_count, base_is_round)
            for pair in range(0, half, VALUE_COUNT_PER_VERTEX_IN_ALL_LANES):
                one = vertex_rows[pair : pair + VALUE_COUNT_PER_VERTEX_IN_ALL_LANES]
                other = vertex_rows[half + pair : half + pair + VALUE_COUNT_PER_VERTEX_IN_ALL_LANES]
                if base_is_round:
                    ahead = 1.0 if pair == 0 else 0.0
                    predict_contact_of_opposite_rim_points(body_states, one, other, lane_count, ahead, 1.0 - ahead)
                else:
                    predict_penetration_and_sliding_of_vertex_pair(body_states, one, other, lane_count)
                if pair == 0:
                    add_point_pair_terms_to_body_velocity_equations(body_states, one, other, lane_count, None)
                else:
                    add_point_pair_terms_to_body_velocity_equations(body_states, one, other, lane_count, 1)
            solve_velocity_corrections(body_states, lane_count)
            for pair in range(0, half, VALUE_COUNT_PER_VERTEX_IN_ALL_LANES):
                one = vertex_rows[pair : pair + VALUE_COUNT_PER_VERTEX_IN_ALL_LANES]
                other = vertex_rows[half + pair : half + pair + VALUE_COUNT_PER_VERTEX_IN_ALL_LANES]
                if pair == 0:
                    compute_forces_and_states_of_opposite_points(
                        body_states, one, other, lane_count, base_is_round, None
                    )
                else:
                    compute_forces_and_states_of_opposite_points(body_states, one, other, lane_count, base_is_round, 1)
            accept_or_reject_steps(body_states, lane_count, ticks_per_sample, base_is_round)
            for point in range(0, 2 * half, VALUE_COUNT_PER_VERTEX_IN_ALL_LANES):
                update_contact_point_states_after_attempted_steps(
                    body_states, vertex_rows[point : point + VALUE_COUNT_PER_VERTEX_IN_ALL_LANES], lane_count
                )

    return attempt_time_steps
