"""Contacts in the centred scheme: trapezoidal rule, springs and dashpots at the end of the step (docs/scenes.md).

`add_pair_contact_terms_to_equations` enters a pair in the equations of a step, `overturning.dem.polygon.equations`
solves them, `overturning.dem.polygon.centred_solution` computes the forces of the pair from the solution, and
`overturning.dem.kernel.clock` chooses the next step.

Signs: at a contact point, penetration u and opening velocity v give n = K u − h v; spring stretch s and slip
velocity w give t = −(K_s s + h w).
"""

import math
from typing import Any, Final, NamedTuple

from numba import njit

from overturning.dem.kernel.clock import SCENE_STEP_CONTROL
from overturning.dem.kernel.lanes import (
    INLINE_OPTIONS,
    NO_ALIAS_COMPILE_OPTIONS,
    create_tuple_sum_difference_and_maximum_functions,
)
from overturning.dem.polygon import rows
from overturning.dem.polygon.equations import (
    add_pair_contact_matrix_to_equation_submatrices,
    right_hand_sides_with_pair_force_added,
)
from overturning.dem.polygon.faces import ContactSegment, PlanarContactPoint, find_contact_segment
from overturning.dem.polygon.landing import (
    RelativeVelocityAndConstantsOfPair,
    contact_points_with_flat_landing_lever_arms,
    pair_lands_flat,
    slides_in_landing_and_signed_friction_coefficient,
)
from overturning.dem.polygon.mechanics import (
    PairRelativeVelocityOrDirectionWithLeverArms,
    PairVelocityToForceMatrix,
    PlanarContactPointForce,
    PredictedStretchAndAssumedFriction,
    opening_and_slip_rates,
    sum_contact_point_forces,
    trial_tangential_spring_stretch,
    velocity_of_a_relative_to_b,
)
from overturning.dem.polygon.state import (
    ContactPointConstants,
    PlanarContactPointStateAfterLastStep,
    SceneStateAndConstants,
)

MAX_VIBRATION_RESOLVING_STEP_IN_SHORTEST_STEPS: Final = SCENE_STEP_CONTROL.max_predicted_force_step_in_shortest_steps
"""Longest step, over the case's shortest step, that resolves the vibration of the contacts."""

MIN_RELATIVE_MOBILITY_OF_SLIDING_POINT: Final = 0.25
"""Least opening acceleration per normal force at a sliding contact point, over that of two free particles with the
masses of its elements; a point below it sticks."""


class PredictedPlanarContactForceAndState(NamedTuple):
    """Predicted forces and contact state at a contact point of two elements, input of a step's equations."""

    normal_force: float
    """Predicted normal force, N."""
    tangential_force: float
    """Predicted tangential force, N."""
    tangential_spring_stretch: float
    """Predicted stretch of the tangential spring, m."""
    is_in_contact: bool
    """True if the point is in contact."""
    slides: bool
    """True if the point slides."""
    signed_friction_coefficient_valid_if_sliding: float
    """±μ with the sign of the friction force if the point slides; without meaning if it sticks."""
    normal_force_pushes_sliding_point_out: bool
    """True if a normal force pushes the point out while it slides."""


add_velocity_to_force_matrices = create_tuple_sum_difference_and_maximum_functions(PairVelocityToForceMatrix).plus


@njit(**INLINE_OPTIONS)
def predict_planar_contact_point(
    contact_law: ContactPointConstants,
    point_history: PlanarContactPointStateAfterLastStep,
    previous_signed_friction_coefficient: float,
    contact_point: PlanarContactPoint,
    contact_segment: ContactSegment,
    pair_motion_and_inertia: RelativeVelocityAndConstantsOfPair,
    step_resolves_vibration_and_pair_lands_flat: tuple[bool, bool],
) -> PredictedPlanarContactForceAndState:
    """Predict contact and friction at a contact point of two elements, for the equations of a step.

    If the step is too long to resolve the contact vibration, the predicted forces would be too large to decide contact
    and slip; those after the last step are used. The result tells whether a normal force would push a sliding point
    out: where friction would instead rotate an element further in (Painlevé's paradox), the point must stick.
    `previous_signed_friction_coefficient` is ±μ if the point slid in the last solution, else 0.
    """
    (fine, held), a, b = (
        step_resolves_vibration_and_pair_lands_flat,
        pair_motion_and_inertia.constants_of_a,
        pair_motion_and_inertia.constants_of_b,
    )
    opening, slipping = opening_and_slip_rates(contact_point, pair_motion_and_inertia.relative_velocity)
    drag, n = contact_law.dashpot_coefficient * slipping, contact_law.normal_stiffness * contact_point.penetration
    n -= contact_law.dashpot_coefficient * opening
    stretch = trial_tangential_spring_stretch(
        point_history, contact_point, contact_segment, contact_law.tangential_compliance_or_zero_without_spring, drag
    )
    t = -(contact_law.tangential_stiffness * stretch) - drag
    pressed = (held | (n > 0.0)) & (contact_point.is_in_contact > 0.0)
    on = (pressed | ((not fine) & (point_history.normal_force != 0.0))) & (
        contact_point.vertex_projects_onto_other_face > 0.0
    )
    excess = abs(t) - contact_law.friction_coefficient * n if fine else abs(previous_signed_friction_coefficient)
    signed_friction_coefficient_or_zero_if_sticking = (
        math.copysign(contact_law.friction_coefficient, t) if fine else previous_signed_friction_coefficient
    )
    drifts, drift = slides_in_landing_and_signed_friction_coefficient(
        contact_law, contact_point, pair_motion_and_inertia.relative_velocity, a, b, held
    )
    signed_friction_coefficient_or_zero_if_sticking = drift if held else signed_friction_coefficient_or_zero_if_sticking
    particles = a.inverse_mass + b.inverse_mass
    lever_a, lever_b = contact_point.lever_arms_about_a, contact_point.lever_arms_about_b
    along = a.inverse_inertia * (
        lever_a.of_normal_force
        * (lever_a.of_normal_force + signed_friction_coefficient_or_zero_if_sticking * lever_a.of_tangential_force)
    )
    freedom = particles + (
        along
        + b.inverse_inertia
        * (
            lever_b.of_normal_force
            * (lever_b.of_normal_force + signed_friction_coefficient_or_zero_if_sticking * lever_b.of_tangential_force)
        )
    )
    slides = drifts if held else (excess > 0.0) | (contact_law.friction_coefficient == 0.0)
    return PredictedPlanarContactForceAndState(
        n,
        t,
        stretch,
        on,
        slides,
        signed_friction_coefficient_or_zero_if_sticking,
        freedom > MIN_RELATIVE_MOBILITY_OF_SLIDING_POINT * particles,
    )


@njit(**INLINE_OPTIONS)
def matrix_of_force_per_velocity(
    force_per_velocity: float,
    force_direction: PairRelativeVelocityOrDirectionWithLeverArms,
    velocity_direction: PairRelativeVelocityOrDirectionWithLeverArms,
) -> PairVelocityToForceMatrix:
    """Return the velocity-to-force matrix of a force along one direction caused by the velocity along another.

    The force is `force_per_velocity` (N s/m) times the velocity.
    """
    fx, fz, fa, fb = force_direction
    vx, vz, va, vb = velocity_direction
    x, z, a, b = force_per_velocity * vx, force_per_velocity * vz, force_per_velocity * va, force_per_velocity * vb
    return PairVelocityToForceMatrix(
        fx * x, fx * z, fz * x, fz * z, fx * a, fz * a, fx * b, fz * b,
        fa * x, fa * z, fb * x, fb * z, fa * a, fa * b, fb * a, fb * b,
    )  # fmt: skip


@njit(**INLINE_OPTIONS)
def planar_contact_matrix_forces_and_signed_friction(
    contact_law: ContactPointConstants,
    half_step_time: float,
    contact_point: PlanarContactPoint,
    predicted_point: PredictedPlanarContactForceAndState,
    other_predicted_point: PredictedPlanarContactForceAndState,
) -> tuple[PairVelocityToForceMatrix, PlanarContactPointForce, float]:
    """Return a contact point's matrix of forces per velocity, its predicted forces, and ±μ if it slides (else 0).

    A point sticks where sliding would rotate one element further into the other (Painlevé's paradox), unless the other
    contact point of the two elements already sticks.
    """
    free = predicted_point.normal_force_pushes_sliding_point_out | (
        other_predicted_point.is_in_contact & (not other_predicted_point.slides)
    )
    slides = predicted_point.slides & free
    slid = predicted_point.signed_friction_coefficient_valid_if_sliding if slides else 0.0
    touches = predicted_point.is_in_contact
    press = contact_law.dashpot_coefficient + half_step_time * contact_law.normal_stiffness if touches else 0.0
    stick = contact_law.dashpot_coefficient + half_step_time * contact_law.tangential_stiffness if touches else 0.0
    stick = 0.0 if slides else stick
    n = predicted_point.normal_force if touches else 0.0
    t = slid * n if slides else predicted_point.tangential_force
    t = t if touches else 0.0
    along, across = (
        PairRelativeVelocityOrDirectionWithLeverArms(
            contact_point.normal_towards_a_x,
            contact_point.normal_towards_a_z,
            contact_point.lever_arms_about_a.of_normal_force,
            contact_point.lever_arms_about_b.of_normal_force,
        ),
        PairRelativeVelocityOrDirectionWithLeverArms(
            contact_point.normal_towards_a_z,
            -contact_point.normal_towards_a_x,
            contact_point.lever_arms_about_a.of_tangential_force,
            contact_point.lever_arms_about_b.of_tangential_force,
        ),
    )
    # The force of a sliding point is inclined by the friction angle.
    inclined = PairRelativeVelocityOrDirectionWithLeverArms(
        along.x + slid * across.x,
        along.z + slid * across.z,
        along.angular_velocity_or_lever_arm_of_a + slid * across.angular_velocity_or_lever_arm_of_a,
        along.angular_velocity_or_lever_arm_of_b + slid * across.angular_velocity_or_lever_arm_of_b,
    )
    normal, tangent = (
        matrix_of_force_per_velocity(press, inclined, along),
        matrix_of_force_per_velocity(stick, across, across),
    )
    return (
        add_velocity_to_force_matrices(normal, tangent),
        PlanarContactPointForce(n, t, predicted_point.tangential_spring_stretch),
        slid,
    )


@njit(**INLINE_OPTIONS)
def step_resolves_contact_vibration(scene_state: SceneStateAndConstants) -> bool:
    """True if the step of a case resolves the contact vibration, so that predicted forces decide contact and slip.

    Longer steps use the contact state after the last step.
    """
    return (
        scene_state.current_step_length_and_repetitions.length_in_ticks
        <= MAX_VIBRATION_RESOLVING_STEP_IN_SHORTEST_STEPS * scene_state.case_step_length_settings.min_allowed_step_ticks
    )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def add_pair_contact_terms_to_equations(
    pair_state_rows: Any,
    element_a_state_rows: Any,
    element_b_state_rows: Any,
    scene_state_rows: Any,
    pair_equation_submatrices: Any,
    unset_flags_of_submatrices_aa_ab_bb: Any,
) -> None:
    """Add the contact terms of two elements to the equations of a step, for all cases in parallel.

    `equations.mark_nonzero_and_return_pair_submatrices` returns `pair_equation_submatrices` and
    `unset_flags_of_submatrices_aa_ab_bb`.
    """
    for j in range(rows.PARALLEL_CASE_COUNT):
        pair, first, second = (
            rows.load_pair_state(pair_state_rows, j),
            rows.load_element_state(element_a_state_rows, j),
            rows.load_element_state(element_b_state_rows, j),
        )
        case, law, old = rows.load_scene_state(scene_state_rows, j), pair.contact_law, pair.history
        fine, half = (
            step_resolves_contact_vibration(case),
            0.5 * (case.tick_duration * case.current_step_length_and_repetitions.length_in_ticks),
        )
        segment = find_contact_segment(pair, first.predicted.pose, second.predicted.pose)
        rows.store_contact_segment(pair_state_rows, j, segment)
        both = RelativeVelocityAndConstantsOfPair(
            velocity_of_a_relative_to_b(first.predicted.velocity_at_step_end, second.predicted.velocity_at_step_end),
            first.constants, second.constants,
        )  # fmt: skip
        kind = (fine, pair_lands_flat(law, old, segment, both))
        point_1, point_2 = contact_points_with_flat_landing_lever_arms(law, segment, both, kind[1])
        slid_1, slid_2, one, two = (
            pair.signed_mu_of_point_1_or_0_if_sticking,
            pair.signed_mu_of_point_2_or_0_if_sticking,
            segment.point_1,
            segment.point_2,
        )
        g1 = predict_planar_contact_point(law, old.point_1, slid_1, one, segment, both, kind)
        g2 = predict_planar_contact_point(law, old.point_2, slid_2, two, segment, both, kind)
        p1, f1, slid_1 = planar_contact_matrix_forces_and_signed_friction(law, half, point_1, g1, g2)
        p2, f2, slid_2 = planar_contact_matrix_forces_and_signed_friction(law, half, point_2, g2, g1)
        rows.store_predicted_stretch_and_friction_at_point_1(
            pair_state_rows, j, PredictedStretchAndAssumedFriction(g1.tangential_spring_stretch, slid_1)
        )
        rows.store_predicted_stretch_and_friction_at_point_2(
            pair_state_rows, j, PredictedStretchAndAssumedFriction(g2.tangential_spring_stretch, slid_2)
        )
        add_pair_contact_matrix_to_equation_submatrices(
            pair_equation_submatrices,
            unset_flags_of_submatrices_aa_ab_bb,
            j,
            add_velocity_to_force_matrices(p1, p2),
            half,
            first.constants,
            second.constants,
        )
        action = sum_contact_point_forces(point_1, point_2, f1, f2)
        on, by = first.predicted.step_end_velocity_correction, second.predicted.step_end_velocity_correction
        on, by = right_hand_sides_with_pair_force_added(on, by, action, half, first.constants, second.constants)
        rows.store_step_end_velocity_correction(element_a_state_rows, j, on)
        rows.store_step_end_velocity_correction(element_b_state_rows, j, by)
