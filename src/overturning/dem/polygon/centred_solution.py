"""Contacts in the centred scheme after the equations of a step are solved: forces, slip, and the state to accept.

The signs are those of `overturning.dem.polygon.centred`.
"""

import math
from typing import Any, NamedTuple

from numba import njit

from overturning.dem.kernel.lanes import (
    INLINE_OPTIONS,
    NO_ALIAS_COMPILE_OPTIONS,
    select,
)
from overturning.dem.kernel.mechanics import clamp_magnitude
from overturning.dem.polygon import rows
from overturning.dem.polygon.centred import step_resolves_contact_vibration
from overturning.dem.polygon.faces import PlanarContactPoint
from overturning.dem.polygon.landing import (
    RelativeVelocityAndConstantsOfPair,
    contact_points_with_flat_landing_lever_arms,
    pair_lands_flat,
    results_with_slip_corrected_for_friction_work,
    slides_in_landing_and_signed_friction_coefficient,
)
from overturning.dem.polygon.mechanics import (
    PairRelativeVelocityOrDirectionWithLeverArms,
    PlanarContactPointForce,
    PlanarContactPointResult,
    PredictedStretchAndAssumedFriction,
    element_force_sums_with_pair_force_added,
    friction_force_and_its_limit_and_slip_flag,
    opening_and_slip_rates,
    owner_code_of_contact_vertex,
    pair_history_after_step,
    sum_contact_point_forces,
    velocity_of_a_relative_to_b,
)
from overturning.dem.polygon.state import (
    CONTACT_CODE_OPEN,
    ContactPointConstants,
    PlanarContactPointStateAfterLastStep,
    StepContactChangesAsFloats,
    VertexPositionAtFace,
    VertexPositionsAtOtherFace,
)


class SolvedPlanarContactPoint(NamedTuple):
    """Contact state at a contact point of two elements after the equations of a step are solved."""

    result_at_step_end: PlanarContactPointResult
    """Force, penetration and slip at the end of the step."""
    slip_from_velocity_correction: float
    """Slip added by the solution, m."""
    signed_friction_coefficient_or_zero_if_sticking: float
    """±μ if the point slips, else 0."""
    contact_opened_closed_or_switched_vertex: bool
    """True if the point has opened or closed, or now lies at another vertex."""
    has_wrong_slip_assumption: bool
    """True if the point sticks or slides contrary to the assumption."""
    has_velocity_against_assumed_slip: bool
    """True if the point was assumed to slide against its velocity (slip reversal)."""
    friction_sign_changed_in_step: bool
    """True if its friction had the opposite sign before."""


@njit(**INLINE_OPTIONS)
def solved_planar_contact_point(
    contact_law: ContactPointConstants,
    point_history: PlanarContactPointStateAfterLastStep,
    contact_point: PlanarContactPoint,
    predicted_stretch_and_assumed_friction: PredictedStretchAndAssumedFriction,
    predicted_motion_and_velocity_correction: tuple[
        RelativeVelocityAndConstantsOfPair, PairRelativeVelocityOrDirectionWithLeverArms
    ],
    half_step_time: float,
    step_resolves_vibration_and_pair_lands_flat: tuple[bool, bool],
) -> SolvedPlanarContactPoint:
    """Return the contact state at a contact point of two elements from solved velocities; friction limits the force.

    There is no tension except in a flat landing, and friction is at most μ times the normal force. A velocity
    correction changes penetration and slip by half the step time times this correction. The spring of a slipping point
    is shortened to the force that friction can hold. A point in the air is marked as sliding, which has no effect.
    """
    ((u, a, b), d), (fine, held) = predicted_motion_and_velocity_correction, step_resolves_vibration_and_pair_lands_flat
    opening, slipping = opening_and_slip_rates(contact_point, u)
    more_open, more_slip = opening_and_slip_rates(contact_point, d)
    opening, slipping = opening + more_open, slipping + more_slip
    depth, stretch = (
        contact_point.penetration - half_step_time * more_open,
        predicted_stretch_and_assumed_friction.tangential_spring_stretch + half_step_time * more_slip,
    )
    touches, was = (
        contact_point.vertex_projects_onto_other_face > 0.0,
        point_history.contact_vertex_status_code != CONTACT_CODE_OPEN,
    )
    inside = (depth > 0.0) & touches
    n = contact_law.normal_stiffness * depth - contact_law.dashpot_coefficient * opening
    n = (n if held | (n > 0.0) else 0.0) if inside else 0.0
    most = contact_law.friction_coefficient * n
    t = -(contact_law.tangential_stiffness * stretch) - contact_law.dashpot_coefficient * slipping
    whole = PairRelativeVelocityOrDirectionWithLeverArms(
        u.x + d.x,
        u.z + d.z,
        u.angular_velocity_or_lever_arm_of_a + d.angular_velocity_or_lever_arm_of_a,
        u.angular_velocity_or_lever_arm_of_b + d.angular_velocity_or_lever_arm_of_b,
    )
    (drifts, drift), loaded = (
        slides_in_landing_and_signed_friction_coefficient(contact_law, contact_point, whole, a, b, held), most > 0.0,
    )  # fmt: skip
    force, holds, slips = friction_force_and_its_limit_and_slip_flag(t, n, contact_law, (held & inside, drifts, drift))
    found = (drift if held else math.copysign(contact_law.friction_coefficient, t)) if slips else 0.0
    spring = (
        clamp_magnitude(stretch, holds * contact_law.tangential_compliance_or_zero_without_spring) if slips else stretch
    )
    spring = spring if inside else 0.0
    assumed = 0.0 if fine else predicted_stretch_and_assumed_friction.signed_friction_coefficient_or_zero_if_sticking
    changed = (
        (inside != was)
        | ((not was) & (touches & (contact_point.penetration > 0.0)))
        | (was & (point_history.contact_vertex_status_code != owner_code_of_contact_vertex(contact_point)))
    )
    wrong, back = (found != assumed) & loaded, (found * point_history.tangential_force < 0.0) & loaded
    now = PlanarContactPointResult(
        PlanarContactPointForce(n, force, spring),
        depth,
        contact_point.slip_of_a_in_step + half_step_time * more_slip,
        inside,
    )
    return SolvedPlanarContactPoint(
        now, half_step_time * more_slip, found, changed, wrong, (assumed * slipping > 0.0) & loaded, back
    )


@njit(**INLINE_OPTIONS)
def vertex_positions_from_contact_solution(
    predicted_position_of_vertex_a: VertexPositionAtFace,
    predicted_position_of_vertex_b: VertexPositionAtFace,
    contact_point: PlanarContactPoint,
    point_solution: SolvedPlanarContactPoint,
) -> tuple[VertexPositionAtFace, VertexPositionAtFace]:
    """Return positions of the vertices of a and b near a contact point, the contact vertex moved by the solution."""
    mine, depth = contact_point.vertex_is_of_a > 0.0, point_solution.result_at_step_end.penetration
    return (
        VertexPositionAtFace(
            depth if mine else predicted_position_of_vertex_a.depth,
            predicted_position_of_vertex_a.position_along_opposite_face - point_solution.slip_from_velocity_correction
            if mine
            else predicted_position_of_vertex_a.position_along_opposite_face,
        ),
        VertexPositionAtFace(
            predicted_position_of_vertex_b.depth if mine else depth,
            predicted_position_of_vertex_b.position_along_opposite_face
            if mine
            else predicted_position_of_vertex_b.position_along_opposite_face
            + point_solution.slip_from_velocity_correction,
        ),
    )


@njit(**INLINE_OPTIONS)
def contact_changes_including_pair(
    changes: StepContactChangesAsFloats, solved_1: SolvedPlanarContactPoint, solved_2: SolvedPlanarContactPoint
) -> StepContactChangesAsFloats:
    """Return the contact changes of a scene in a step, together with those of both contact points of a pair."""
    slide = (
        (solved_1.signed_friction_coefficient_or_zero_if_sticking != 0.0)
        & (solved_2.signed_friction_coefficient_or_zero_if_sticking != 0.0)
        & (solved_1.result_at_step_end.force.normal_force + solved_2.result_at_step_end.force.normal_force > 0.0)
    )
    changed = solved_1.contact_opened_closed_or_switched_vertex | solved_2.contact_opened_closed_or_switched_vertex
    wrong_slip = solved_1.has_wrong_slip_assumption | solved_2.has_wrong_slip_assumption
    against_slip = solved_1.has_velocity_against_assumed_slip | solved_2.has_velocity_against_assumed_slip
    reversed_friction = solved_1.friction_sign_changed_in_step | solved_2.friction_sign_changed_in_step
    return StepContactChangesAsFloats(
        1.0 if changed else changes.contact_or_nearest_faces_changed,
        1.0 if wrong_slip else changes.has_wrong_slip_assumption,
        1.0 if against_slip else changes.has_velocity_against_assumed_slip,
        1.0 if slide else changes.pair_slides_on_both_points,
        1.0 if reversed_friction else changes.friction_sign_changed_in_step,
    )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def add_solved_pair_forces_and_store_trial_history(
    pair_state_rows: Any, element_a_state_rows: Any, element_b_state_rows: Any, scene_state_rows: Any
) -> None:
    """Add solved contact forces to two elements; store contact changes and the history for an accepted step."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        pair, step, first, second = (
            rows.load_pair_state(pair_state_rows, j),
            rows.load_intermediate_step_results(pair_state_rows, j),
            rows.load_element_state(element_a_state_rows, j),
            rows.load_element_state(element_b_state_rows, j),
        )
        case, on, by, law, segment = (
            rows.load_scene_state(scene_state_rows, j),
            first.predicted,
            second.predicted,
            pair.contact_law,
            step.contact_segment,
        )
        fine, half = (
            step_resolves_contact_vibration(case),
            0.5 * (case.tick_duration * case.current_step_length_and_repetitions.length_in_ticks),
        )
        moves = (
            RelativeVelocityAndConstantsOfPair(
                velocity_of_a_relative_to_b(on.velocity_at_step_end, by.velocity_at_step_end),
                first.constants,
                second.constants,
            ),
            velocity_of_a_relative_to_b(on.step_end_velocity_correction, by.step_end_velocity_correction),
        )
        kind = (fine, pair_lands_flat(law, pair.history, segment, moves[0]))
        u, d = moves[0].relative_velocity, moves[1]
        solved = RelativeVelocityAndConstantsOfPair(
            PairRelativeVelocityOrDirectionWithLeverArms(
                u.x + d.x,
                u.z + d.z,
                u.angular_velocity_or_lever_arm_of_a + d.angular_velocity_or_lever_arm_of_a,
                u.angular_velocity_or_lever_arm_of_b + d.angular_velocity_or_lever_arm_of_b,
            ),
            first.constants,
            second.constants,
        )
        point_1, point_2 = contact_points_with_flat_landing_lever_arms(law, segment, solved, kind[1])
        history, one, two = pair.history, segment.point_1, segment.point_2
        s1 = solved_planar_contact_point(
            law, history.point_1, one, step.predicted_stretch_and_friction_at_point_1, moves, half, kind
        )
        s2 = solved_planar_contact_point(
            law, history.point_2, two, step.predicted_stretch_and_friction_at_point_2, moves, half, kind
        )
        end_1, end_2 = s1.result_at_step_end, s2.result_at_step_end
        on_a, on_b = element_force_sums_with_pair_force_added(
            first.contact_force_sum,
            second.contact_force_sum,
            sum_contact_point_forces(point_1, point_2, end_1.force, end_2.force),
        )
        rows.store_contact_force_sum(element_a_state_rows, j, on_a)
        rows.store_contact_force_sum(element_b_state_rows, j, on_b)
        vertices = segment.face_vertex_positions
        a1, b2 = vertex_positions_from_contact_solution(
            vertices.first_vertex_of_face_a, vertices.second_vertex_of_face_b, one, s1
        )
        a2, b1 = vertex_positions_from_contact_solution(
            vertices.second_vertex_of_face_a, vertices.first_vertex_of_face_b, two, s2
        )
        rows.store_history_after_step(pair_state_rows, j, pair_history_after_step(
            history, segment, VertexPositionsAtOtherFace(a1, a2, b1, b2),
            results_with_slip_corrected_for_friction_work(segment, (point_1, point_2), (end_1, end_2)), law, 2.0 * half
        ))  # fmt: skip
        (
            pair_state_rows[rows.POINT_1_SIGNED_FRICTION_OR_ZERO_ROW_OFFSET + j],
            pair_state_rows[rows.POINT_2_SIGNED_FRICTION_OR_ZERO_ROW_OFFSET + j],
        ) = (
            s1.signed_friction_coefficient_or_zero_if_sticking,
            s2.signed_friction_coefficient_or_zero_if_sticking,
        )
        rows.store_largest_contact_changes(
            scene_state_rows, j, contact_changes_including_pair(case.contact_changes, s1, s2)
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def store_accepted_pair_history(pair_state_rows: Any, scene_state_rows: Any) -> None:
    """Replace the contact state of two elements by the new one, in each case whose step is accepted.

    Where the next attempt must keep the assumption of sticking or sliding, the assumed ±μ (0: sticks) replaces the
    solved one.
    """
    for j in range(rows.PARALLEL_CASE_COUNT):
        step, decision = (
            rows.load_intermediate_step_results(pair_state_rows, j),
            rows.load_scene_state(scene_state_rows, j).step_decision_and_next_attempt,
        )
        rows.store_contact_history_unless_rejected(
            pair_state_rows, j, decision.positive_if_rejected > 0.0, step.contact_state_after_step
        )
        pair_state_rows[rows.POINT_1_SIGNED_FRICTION_OR_ZERO_ROW_OFFSET + j] = select(
            decision.next_attempt_keeps_slip_assumption > 0.0,
            step.predicted_stretch_and_friction_at_point_1.signed_friction_coefficient_or_zero_if_sticking,
            pair_state_rows[rows.POINT_1_SIGNED_FRICTION_OR_ZERO_ROW_OFFSET + j],
        )
        pair_state_rows[rows.POINT_2_SIGNED_FRICTION_OR_ZERO_ROW_OFFSET + j] = select(
            decision.next_attempt_keeps_slip_assumption > 0.0,
            step.predicted_stretch_and_friction_at_point_2.signed_friction_coefficient_or_zero_if_sticking,
            pair_state_rows[rows.POINT_2_SIGNED_FRICTION_OR_ZERO_ROW_OFFSET + j],
        )
