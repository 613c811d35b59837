"""Contacts in the centred scheme: trapezoidal rule, springs and dashpots at the end of the step (docs/scenes.md).

`add_pair_to_equations` enters a pair in the equations of a step, `overturning.dem.polygon.equations` solves them,
`compute_pair_forces_after_solution` computes the forces of the pair from the solution, and
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
    create_elementwise_tuple_functions,
    select,
)
from overturning.dem.kernel.mechanics import clamp_magnitude
from overturning.dem.polygon import rows
from overturning.dem.polygon.equations import add_pair_force_to_right_sides, add_pair_matrix_to_submatrices
from overturning.dem.polygon.faces import ContactSegment, PlanarContactPoint, find_contact_segment
from overturning.dem.polygon.landing import (
    PairMotionAndInertia,
    contact_points_with_landing_lever_arms,
    correct_slip_for_friction_work,
    flat_landing_slip_flag_and_signed_mu,
    pair_lands_flat,
)
from overturning.dem.polygon.mechanics import (
    AssumedPlanarContactSlip,
    PairRelativeVector,
    PairVelocityToForceMatrix,
    PlanarContactPointForce,
    PlanarContactPointResult,
    add_pair_force_to_elements,
    contact_vertex_owner,
    limit_friction_force,
    opening_and_slip_rates,
    pair_history_after_step,
    sum_contact_point_forces,
    tangential_spring_stretch,
    velocity_of_a_relative_to_b,
)
from overturning.dem.polygon.state import (
    OPEN,
    ContactPointLaw,
    FaceVertexPositions,
    PlanarContactPointHistory,
    SceneState,
    StepContactChangesAsFloats,
    VertexPositionAtFace,
)

MAX_VIBRATION_RESOLVING_STEP_RATIO: Final = SCENE_STEP_CONTROL.max_step_using_predicted_forces

MIN_NORMAL_MOBILITY_RATIO_TO_SLIDE: Final = 0.25
"""Least effect of a normal force on a sliding point, as a share of that on free particles; below it, it sticks."""


class PredictedPlanarContactPoint(NamedTuple):
    """Predicted forces and contact state at a contact point of two elements, input of a step's equations."""

    n: float
    """Predicted normal force, N."""
    tangential_force: float
    """Predicted tangential force, N."""
    tangential_stretch: float
    """Predicted stretch of the tangential spring, m."""
    is_in_contact: bool
    """True if the point is in contact."""
    slides: bool
    """True if the point slides."""
    signed_friction: float
    """±μ if the point slides."""
    is_pushed_out_while_sliding: bool
    """True if a normal force pushes the point out while it slides."""


plus = create_elementwise_tuple_functions(PairVelocityToForceMatrix).plus


@njit(**INLINE_OPTIONS)
def predict_planar_contact_point(
    contact_law: ContactPointLaw,
    point_history: PlanarContactPointHistory,
    signed_friction: float,
    contact_point: PlanarContactPoint,
    contact_segment: ContactSegment,
    pair_motion: PairMotionAndInertia,
    step_and_landing_flags: tuple[bool, bool],
) -> PredictedPlanarContactPoint:
    """Predict contact and friction at a contact point of two elements, for the equations of a step.

    In a step that does not resolve the contact vibration, the predicted forces would be too large, and the contact
    state after the last step is used. A normal force on a sliding point must push it out; where friction would rotate
    an element further in instead (Painlevé's paradox), the point sticks. `step_and_landing_flags` holds whether the
    predicted forces decide about contact, and whether the pair is in a flat landing.
    """
    (fine, held), a, b = step_and_landing_flags, pair_motion.a, pair_motion.b
    opening, slipping = opening_and_slip_rates(contact_point, pair_motion.velocity)
    drag, n = contact_law.dashpot * slipping, contact_law.normal_stiffness * contact_point.depth
    n -= contact_law.dashpot * opening
    stretch = tangential_spring_stretch(
        point_history, contact_point, contact_segment, contact_law.tangential_compliance, drag
    )
    t = -(contact_law.tangential_stiffness * stretch) - drag
    pressed = (held | (n > 0.0)) & (contact_point.closed > 0.0)
    on = (pressed | ((not fine) & (point_history.normal_force != 0.0))) & (contact_point.vertex_is_opposite_face > 0.0)
    excess = abs(t) - contact_law.friction * n if fine else abs(signed_friction)
    signed_friction = math.copysign(contact_law.friction, t) if fine else signed_friction
    drifts, drift = flat_landing_slip_flag_and_signed_mu(contact_law, contact_point, pair_motion.velocity, a, b, held)
    signed_friction = drift if held else signed_friction
    particles = a.inverse_mass + b.inverse_mass
    lever_a, lever_b = contact_point.lever_a, contact_point.lever_b
    along = a.inverse_inertia * (lever_a.n * (lever_a.n + signed_friction * lever_a.t))
    freedom = particles + (along + b.inverse_inertia * (lever_b.n * (lever_b.n + signed_friction * lever_b.t)))
    slides = drifts if held else (excess > 0.0) | (contact_law.friction == 0.0)
    return PredictedPlanarContactPoint(
        n, t, stretch, on, slides, signed_friction, freedom > MIN_NORMAL_MOBILITY_RATIO_TO_SLIDE * particles
    )


@njit(**INLINE_OPTIONS)
def matrix_of_force_per_velocity(
    coefficient: float, force_direction: PairRelativeVector, velocity_direction: PairRelativeVector
) -> PairVelocityToForceMatrix:
    """Return the matrix of a force along `force_direction`: `coefficient` × velocity along `velocity_direction`."""
    f = force_direction
    x, z, a, b = (
        coefficient * velocity_direction.x, coefficient * velocity_direction.z,
        coefficient * velocity_direction.rotation_a, coefficient * velocity_direction.rotation_b,
    )  # fmt: skip
    return PairVelocityToForceMatrix(
        f.x * x, f.x * z, f.z * x, f.z * z, f.x * a, f.z * a, f.x * b, f.z * b,
        f.rotation_a * x, f.rotation_a * z, f.rotation_b * x, f.rotation_b * z,
        f.rotation_a * a, f.rotation_a * b, f.rotation_b * a, f.rotation_b * b,
    )  # fmt: skip


@njit(**INLINE_OPTIONS)
def planar_contact_equation_terms(
    contact_law: ContactPointLaw,
    half_step_time: float,
    contact_point: PlanarContactPoint,
    predicted_point: PredictedPlanarContactPoint,
    other_predicted_point: PredictedPlanarContactPoint,
) -> tuple[PairVelocityToForceMatrix, PlanarContactPointForce, float]:
    """Return the equation matrix of a contact point of two elements, its forces, and ±μ if the point slides (else 0).

    A point sticks where sliding would turn an element into the other (Painlevé's paradox), unless the other contact
    point of the pair already sticks.
    """
    free = predicted_point.is_pushed_out_while_sliding | (
        other_predicted_point.is_in_contact & (not other_predicted_point.slides)
    )
    slides = predicted_point.slides & free
    slid = predicted_point.signed_friction if slides else 0.0
    touches = predicted_point.is_in_contact
    press = contact_law.dashpot + half_step_time * contact_law.normal_stiffness if touches else 0.0
    stick = contact_law.dashpot + half_step_time * contact_law.tangential_stiffness if touches else 0.0
    stick = 0.0 if slides else stick
    n = predicted_point.n if touches else 0.0
    t = slid * n if slides else predicted_point.tangential_force
    t = t if touches else 0.0
    along, across = (
        PairRelativeVector(contact_point.nx, contact_point.nz, contact_point.lever_a.n, contact_point.lever_b.n),
        PairRelativeVector(contact_point.nz, -contact_point.nx, contact_point.lever_a.t, contact_point.lever_b.t),
    )
    # The force of a sliding point is inclined by the friction angle.
    inclined = PairRelativeVector(
        along.x + slid * across.x,
        along.z + slid * across.z,
        along.rotation_a + slid * across.rotation_a,
        along.rotation_b + slid * across.rotation_b,
    )
    normal, tangent = (
        matrix_of_force_per_velocity(press, inclined, along),
        matrix_of_force_per_velocity(stick, across, across),
    )
    return plus(normal, tangent), PlanarContactPointForce(n, t, predicted_point.tangential_stretch), slid


@njit(**INLINE_OPTIONS)
def step_resolves_contact_vibration(case: SceneState) -> bool:
    """True if the step of a case resolves the contact vibration, so that predicted forces decide contact and slip.

    Longer steps use the contact state after the last step.
    """
    return case.attempt.length_in_ticks <= MAX_VIBRATION_RESOLVING_STEP_RATIO * case.step_control.shortest_step


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def add_pair_to_equations(
    pair_rows: Any, element_a_rows: Any, element_b_rows: Any, case_rows: Any, submatrices: Any, empty_flags: Any
) -> None:
    """Add the contact terms of two elements to the equations of a step, for all cases in parallel.

    `equations.mark_nonzero_and_return_pair_submatrices` returns `submatrices` and `empty_flags`.
    """
    for j in range(rows.PARALLEL_CASE_COUNT):
        pair, first, second = (
            rows.load_pair(pair_rows, j), rows.load_element(element_a_rows, j), rows.load_element(element_b_rows, j),
        )  # fmt: skip
        case, law, old = rows.load_case(case_rows, j), pair.law, pair.history
        fine, half = step_resolves_contact_vibration(case), 0.5 * (case.tick_length * case.attempt.length_in_ticks)
        segment = find_contact_segment(pair, first.predicted.pose, second.predicted.pose)
        rows.store_segment(pair_rows, j, segment)
        both = PairMotionAndInertia(
            velocity_of_a_relative_to_b(first.predicted.end_velocity, second.predicted.end_velocity), first.constants,
            second.constants,
        )  # fmt: skip
        kind = (fine, pair_lands_flat(law, old, segment, both))
        point_1, point_2 = contact_points_with_landing_lever_arms(law, segment, both, kind[1])
        slid_1, slid_2, one, two = pair.signed_friction_1, pair.signed_friction_2, segment.point_1, segment.point_2
        g1 = predict_planar_contact_point(law, old.point_1, slid_1, one, segment, both, kind)
        g2 = predict_planar_contact_point(law, old.point_2, slid_2, two, segment, both, kind)
        p1, f1, slid_1 = planar_contact_equation_terms(law, half, point_1, g1, g2)
        p2, f2, slid_2 = planar_contact_equation_terms(law, half, point_2, g2, g1)
        rows.store_predicted_one(pair_rows, j, AssumedPlanarContactSlip(g1.tangential_stretch, slid_1))
        rows.store_predicted_two(pair_rows, j, AssumedPlanarContactSlip(g2.tangential_stretch, slid_2))
        add_pair_matrix_to_submatrices(
            submatrices, empty_flags, j, plus(p1, p2), half, first.constants, second.constants
        )
        action = sum_contact_point_forces(point_1, point_2, f1, f2)
        on, by = first.predicted.velocity_correction, second.predicted.velocity_correction
        on, by = add_pair_force_to_right_sides(on, by, action, half, first.constants, second.constants)
        rows.store_change(element_a_rows, j, on)
        rows.store_change(element_b_rows, j, by)


class SolvedPlanarContactPoint(NamedTuple):
    """Contact state at a contact point of two elements after the equations of a step are solved."""

    end_of_step: PlanarContactPointResult
    added_slip: float
    """Slip added by the solution, m."""
    signed_friction: float
    """±μ if the point slips, else 0."""
    contact_changed: bool
    """True if the point has opened or closed."""
    has_wrong_slip_assumption: bool
    """True if the point sticks or slides contrary to the assumption."""
    has_slip_reversal: bool
    """True if the point was assumed to slide against its velocity (slip reversal)."""
    has_friction_reversal: bool
    """True if its friction had the opposite sign before."""


@njit(**INLINE_OPTIONS)
def solved_planar_contact_point(
    contact_law: ContactPointLaw,
    point_history: PlanarContactPointHistory,
    contact_point: PlanarContactPoint,
    assumed_slip: AssumedPlanarContactSlip,
    motion_and_change: tuple[PairMotionAndInertia, PairRelativeVector],
    half_step_time: float,
    step_and_landing_flags: tuple[bool, bool],
) -> SolvedPlanarContactPoint:
    """Return the contact state at a contact point of two elements from solved velocities; friction limits the force.

    There is no tension except in a flat landing, and friction is at most μ times the normal force. The velocity
    corrections change the poses by half a step times the correction. The spring of a slipping point is shortened to the
    force that friction can hold. A point in the air is marked as sliding, which has no effect. `motion_and_change`
    holds the motion of the pair and the velocity correction, `step_and_landing_flags` whether the predicted forces
    decided about contact and whether the pair is in a flat landing.
    """
    ((u, a, b), d), (fine, held) = motion_and_change, step_and_landing_flags
    opening, slipping = opening_and_slip_rates(contact_point, u)
    more_open, more_slip = opening_and_slip_rates(contact_point, d)
    opening, slipping = opening + more_open, slipping + more_slip
    depth, stretch = (
        contact_point.depth - half_step_time * more_open,
        assumed_slip.tangential_stretch + half_step_time * more_slip,
    )
    touches, was = contact_point.vertex_is_opposite_face > 0.0, point_history.vertex_owner != OPEN
    inside = (depth > 0.0) & touches
    n = contact_law.normal_stiffness * depth - contact_law.dashpot * opening
    n = (n if held | (n > 0.0) else 0.0) if inside else 0.0
    most = contact_law.friction * n
    t = -(contact_law.tangential_stiffness * stretch) - contact_law.dashpot * slipping
    whole = PairRelativeVector(u.x + d.x, u.z + d.z, u.rotation_a + d.rotation_a, u.rotation_b + d.rotation_b)
    (drifts, drift), loaded = (
        flat_landing_slip_flag_and_signed_mu(contact_law, contact_point, whole, a, b, held), most > 0.0,
    )  # fmt: skip
    force, holds, slips = limit_friction_force(t, n, contact_law, (held & inside, drifts, drift))
    found = (drift if held else math.copysign(contact_law.friction, t)) if slips else 0.0
    spring = clamp_magnitude(stretch, holds * contact_law.tangential_compliance) if slips else stretch
    spring = spring if inside else 0.0
    assumed = 0.0 if fine else assumed_slip.signed_friction
    changed = (
        (inside != was)
        | ((not was) & (touches & (contact_point.depth > 0.0)))
        | (was & (point_history.vertex_owner != contact_vertex_owner(contact_point)))
    )
    wrong, back = (found != assumed) & loaded, (found * point_history.tangential_force < 0.0) & loaded
    now = PlanarContactPointResult(
        PlanarContactPointForce(n, force, spring), depth, contact_point.slip + half_step_time * more_slip, inside
    )
    return SolvedPlanarContactPoint(
        now, half_step_time * more_slip, found, changed, wrong, (assumed * slipping > 0.0) & loaded, back
    )


@njit(**INLINE_OPTIONS)
def vertex_positions_from_contact_solution(
    vertex_a: VertexPositionAtFace,
    vertex_b: VertexPositionAtFace,
    contact_point: PlanarContactPoint,
    point_solution: SolvedPlanarContactPoint,
) -> tuple[VertexPositionAtFace, VertexPositionAtFace]:
    """Return the positions of both vertices near a contact point, after the equations are solved."""
    mine, depth = contact_point.vertex_is_of_a > 0.0, point_solution.end_of_step.depth
    return (
        VertexPositionAtFace(
            depth if mine else vertex_a.depth,
            vertex_a.position_along_face - point_solution.added_slip if mine else vertex_a.position_along_face,
        ),
        VertexPositionAtFace(
            vertex_b.depth if mine else depth,
            vertex_b.position_along_face if mine else vertex_b.position_along_face + point_solution.added_slip,
        ),
    )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def compute_pair_forces_after_solution(
    pair_rows: Any, element_a_rows: Any, element_b_rows: Any, case_rows: Any
) -> None:
    """Add the solved contact forces between two elements to both; store the contact's new state for acceptance."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        pair, step, first, second = (
            rows.load_pair(pair_rows, j), rows.load_step(pair_rows, j), rows.load_element(element_a_rows, j),
            rows.load_element(element_b_rows, j),
        )  # fmt: skip
        case, on, by, law, segment = (
            rows.load_case(case_rows, j), first.predicted, second.predicted, pair.law, step.segment,
        )  # fmt: skip
        fine, half, old = (
            step_resolves_contact_vibration(case), 0.5 * (case.tick_length * case.attempt.length_in_ticks),
            case.contact_changes,
        )  # fmt: skip
        moves = (
            PairMotionAndInertia(
                velocity_of_a_relative_to_b(on.end_velocity, by.end_velocity), first.constants, second.constants
            ),
            velocity_of_a_relative_to_b(on.velocity_correction, by.velocity_correction),
        )
        kind = (fine, pair_lands_flat(law, pair.history, segment, moves[0]))
        (u, d), inertia_a, inertia_b = (moves[0].velocity, moves[1]), first.constants, second.constants
        solved = PairMotionAndInertia(
            PairRelativeVector(u.x + d.x, u.z + d.z, u.rotation_a + d.rotation_a, u.rotation_b + d.rotation_b),
            inertia_a, inertia_b,
        )  # fmt: skip
        point_1, point_2 = contact_points_with_landing_lever_arms(law, segment, solved, kind[1])
        history, one, two = pair.history, segment.point_1, segment.point_2
        s1 = solved_planar_contact_point(law, history.point_1, one, step.assumed_slip_1, moves, half, kind)
        s2 = solved_planar_contact_point(law, history.point_2, two, step.assumed_slip_2, moves, half, kind)
        end_1, end_2 = s1.end_of_step, s2.end_of_step
        on_a, on_b = add_pair_force_to_elements(
            first.force, second.force, sum_contact_point_forces(point_1, point_2, end_1.force, end_2.force)
        )
        rows.store_force(element_a_rows, j, on_a)
        rows.store_force(element_b_rows, j, on_b)
        vertices = segment.vertex_positions
        a1, b2 = vertex_positions_from_contact_solution(vertices.a1, vertices.b2, one, s1)
        a2, b1 = vertex_positions_from_contact_solution(vertices.a2, vertices.b1, two, s2)
        rows.store_corrected(pair_rows, j, pair_history_after_step(
            history, segment, FaceVertexPositions(a1, a2, b1, b2),
            correct_slip_for_friction_work(segment, (point_1, point_2), (end_1, end_2)), law, 2.0 * half
        ))  # fmt: skip
        pair_rows[rows.SLID_ONE + j], pair_rows[rows.SLID_TWO + j] = s1.signed_friction, s2.signed_friction
        slide = (s1.signed_friction != 0.0) & (s2.signed_friction != 0.0) & (end_1.force.n + end_2.force.n > 0.0)
        rows.store_findings(case_rows, j, StepContactChangesAsFloats(
            1.0 if s1.contact_changed | s2.contact_changed else old.contact_changed,
            1.0 if s1.has_wrong_slip_assumption | s2.has_wrong_slip_assumption else old.has_wrong_slip_assumption,
            1.0 if s1.has_slip_reversal | s2.has_slip_reversal else old.has_slip_reversal,
            1.0 if slide else old.slides_on_all_points,
            1.0 if s1.has_friction_reversal | s2.has_friction_reversal else old.has_friction_reversal,
        ))  # fmt: skip


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def store_accepted_pair_history(pair_rows: Any, case_rows: Any) -> None:
    """Replace the contact state of two elements by the new one, in each case whose step is accepted."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        step, decision = rows.load_step(pair_rows, j), rows.load_case(case_rows, j).decision
        rows.keep_history(pair_rows, j, decision.is_rejected > 0.0, step.history_after_step)
        pair_rows[rows.SLID_ONE + j] = select(
            decision.keeps_assumed_slip > 0.0, step.assumed_slip_1.signed_friction, pair_rows[rows.SLID_ONE + j]
        )
        pair_rows[rows.SLID_TWO + j] = select(
            decision.keeps_assumed_slip > 0.0, step.assumed_slip_2.signed_friction, pair_rows[rows.SLID_TWO + j]
        )
