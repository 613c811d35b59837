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
from overturning.dem.kernel.lanes import INLINE, NO_ALIAS_COMPILE_OPTIONS, create_elementwise_tuple_functions, select
from overturning.dem.kernel.mechanics import clamp_magnitude
from overturning.dem.polygon import rows
from overturning.dem.polygon.equations import add_pair_force_to_right_sides, add_pair_matrix_to_submatrices
from overturning.dem.polygon.faces import ContactSegment, PlanarContactPoint, find_contact_segment
from overturning.dem.polygon.landing import (
    PairMotionAndInertia,
    contact_points_with_landing_lever_arms,
    correct_slip_for_friction_work,
    flat_landing_slip_flag_and_signed_friction,
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
    t: float
    """Predicted tangential force, N."""
    stretch: float
    """Predicted stretch of the tangential spring, m."""
    on: bool
    """True if the point is in contact."""
    slides: bool
    """True if the point slides."""
    slid: float
    """±μ if the point slides."""
    free: bool
    """True if a normal force pushes the point out while it slides."""


plus = create_elementwise_tuple_functions(PairVelocityToForceMatrix).plus


@njit(**INLINE)
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
    n, drag = contact_law.normal * contact_point.depth - contact_law.dashpot * opening, contact_law.dashpot * slipping
    stretch = tangential_spring_stretch(
        point_history, contact_point, contact_segment, contact_law.tangential_compliance, drag
    )
    t = -(contact_law.tangential_stiffness * stretch) - drag
    pressed = (held | (n > 0.0)) & (contact_point.closed > 0.0)
    on = (pressed | ((not fine) & (point_history.normal != 0.0))) & (contact_point.faces > 0.0)
    excess = abs(t) - contact_law.friction * n if fine else abs(signed_friction)
    signed_friction = math.copysign(contact_law.friction, t) if fine else signed_friction
    drifts, drift = flat_landing_slip_flag_and_signed_friction(
        contact_law, contact_point, pair_motion.velocity, a, b, held
    )
    signed_friction = drift if held else signed_friction
    particles = a.inverse_mass + b.inverse_mass
    along = a.inverse_inertia * (contact_point.a.n * (contact_point.a.n + signed_friction * contact_point.a.t))
    freedom = particles + (
        along + b.inverse_inertia * (contact_point.b.n * (contact_point.b.n + signed_friction * contact_point.b.t))
    )
    slides = drifts if held else (excess > 0.0) | (contact_law.friction == 0.0)
    return PredictedPlanarContactPoint(
        n, t, stretch, on, slides, signed_friction, freedom > MIN_NORMAL_MOBILITY_RATIO_TO_SLIDE * particles
    )


@njit(**INLINE)
def matrix_of_force_per_velocity(
    coefficient: float, force_direction: PairRelativeVector, velocity_direction: PairRelativeVector
) -> PairVelocityToForceMatrix:
    """Return the matrix of a force along `force_direction`: `coefficient` × velocity along `velocity_direction`."""
    f = force_direction
    x, z, a, b = (
        coefficient * velocity_direction.x,
        coefficient * velocity_direction.z,
        coefficient * velocity_direction.a,
        coefficient * velocity_direction.b,
    )
    return PairVelocityToForceMatrix(
        f.x * x, f.x * z, f.z * x, f.z * z, f.x * a, f.z * a, f.x * b, f.z * b, f.a * x, f.a * z, f.b * x, f.b * z,
        f.a * a, f.a * b, f.b * a, f.b * b,
    )  # fmt: skip


@njit(**INLINE)
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
    free = predicted_point.free | (other_predicted_point.on & (not other_predicted_point.slides))
    slides = predicted_point.slides & free
    slid = predicted_point.slid if slides else 0.0
    press = contact_law.dashpot + half_step_time * contact_law.normal if predicted_point.on else 0.0
    stick = contact_law.dashpot + half_step_time * contact_law.tangential_stiffness if predicted_point.on else 0.0
    stick = 0.0 if slides else stick
    n = predicted_point.n if predicted_point.on else 0.0
    t = slid * n if slides else predicted_point.t
    t = t if predicted_point.on else 0.0
    along, across = (
        PairRelativeVector(contact_point.nx, contact_point.nz, contact_point.a.n, contact_point.b.n),
        PairRelativeVector(contact_point.nz, -contact_point.nx, contact_point.a.t, contact_point.b.t),
    )
    # The force of a sliding point is inclined by the friction angle.
    inclined = PairRelativeVector(
        along.x + slid * across.x, along.z + slid * across.z, along.a + slid * across.a, along.b + slid * across.b
    )
    normal, tangent = (
        matrix_of_force_per_velocity(press, inclined, along),
        matrix_of_force_per_velocity(stick, across, across),
    )
    return plus(normal, tangent), PlanarContactPointForce(n, t, predicted_point.stretch), slid


@njit(**INLINE)
def predicted_forces_decide_contact(case: SceneState) -> bool:
    """True if the step of a case resolves the contact vibration, so that predicted forces decide contact and slip.

    Longer steps use the contact state after the last step.
    """
    return case.attempt.length <= MAX_VIBRATION_RESOLVING_STEP_RATIO * case.step_control.finest


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def add_pair_to_equations(
    pair_rows: Any, element_a_rows: Any, element_b_rows: Any, case_rows: Any, submatrices: Any, empty_flags: Any
) -> None:
    """Add the contact terms of two elements to the equations of a step, for all cases in parallel.

    `equations.mark_and_return_pair_submatrices` returns `submatrices` and `empty_flags`.
    """
    for j in range(rows.PARALLEL_CASE_COUNT):
        pair, first, second = (
            rows.load_pair(pair_rows, j),
            rows.load_element(element_a_rows, j),
            rows.load_element(element_b_rows, j),
        )
        case, law, old = rows.load_case(case_rows, j), pair.law, pair.history
        fine, half = predicted_forces_decide_contact(case), 0.5 * (case.tick_length * case.attempt.length)
        segment = find_contact_segment(pair, first.trial.pose, second.trial.pose)
        rows.store_segment(pair_rows, j, segment)
        both = PairMotionAndInertia(
            velocity_of_a_relative_to_b(first.trial.end, second.trial.end), first.inertia, second.inertia
        )
        kind = (fine, pair_lands_flat(law, old, segment, both))
        point_1, point_2 = contact_points_with_landing_lever_arms(law, segment, both, kind[1])
        g1 = predict_planar_contact_point(law, old.one, pair.signed_friction_1, segment.one, segment, both, kind)
        g2 = predict_planar_contact_point(law, old.two, pair.signed_friction_2, segment.two, segment, both, kind)
        p1, f1, slid_1 = planar_contact_equation_terms(law, half, point_1, g1, g2)
        p2, f2, slid_2 = planar_contact_equation_terms(law, half, point_2, g2, g1)
        rows.store_predicted_one(pair_rows, j, AssumedPlanarContactSlip(g1.stretch, slid_1))
        rows.store_predicted_two(pair_rows, j, AssumedPlanarContactSlip(g2.stretch, slid_2))
        add_pair_matrix_to_submatrices(submatrices, empty_flags, j, plus(p1, p2), half, first.inertia, second.inertia)
        action, on, by = sum_contact_point_forces(point_1, point_2, f1, f2), first.trial.change, second.trial.change
        on, by = add_pair_force_to_right_sides(on, by, action, half, first.inertia, second.inertia)
        rows.store_change(element_a_rows, j, on)
        rows.store_change(element_b_rows, j, by)


class SolvedPlanarContactPoint(NamedTuple):
    """Contact state at a contact point of two elements after the equations of a step are solved."""

    now: PlanarContactPointResult
    added_slip: float
    """Slip added by the solution, m."""
    found: float
    """±μ if the point slips, else 0."""
    changed: bool
    """True if the point has opened or closed."""
    has_wrong_slip_assumption: bool
    """True if the point sticks or slides contrary to the assumption."""
    has_slip_reversal: bool
    """True if the point was assumed to slide against its velocity (slip reversal)."""
    has_friction_reversal: bool
    """True if its friction had the opposite sign before."""


@njit(**INLINE)
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
    depth, stretch = contact_point.depth - half_step_time * more_open, assumed_slip.stretch + half_step_time * more_slip
    touches, was = contact_point.faces > 0.0, point_history.vertex_owner != OPEN
    inside = (depth > 0.0) & touches
    n = contact_law.normal * depth - contact_law.dashpot * opening
    n = (n if held | (n > 0.0) else 0.0) if inside else 0.0
    most = contact_law.friction * n
    t = -(contact_law.tangential_stiffness * stretch) - contact_law.dashpot * slipping
    whole = PairRelativeVector(u.x + d.x, u.z + d.z, u.a + d.a, u.b + d.b)
    (drifts, drift), loaded = (
        flat_landing_slip_flag_and_signed_friction(contact_law, contact_point, whole, a, b, held),
        most > 0.0,
    )
    force, holds, slips = limit_friction_force(t, n, contact_law, (held & inside, drifts, drift))
    found = (drift if held else math.copysign(contact_law.friction, t)) if slips else 0.0
    spring = clamp_magnitude(stretch, holds * contact_law.tangential_compliance) if slips else stretch
    spring = spring if inside else 0.0
    assumed = 0.0 if fine else assumed_slip.slid
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


@njit(**INLINE)
def vertex_positions_from_contact_solution(
    vertex_a: VertexPositionAtFace,
    vertex_b: VertexPositionAtFace,
    contact_point: PlanarContactPoint,
    point_solution: SolvedPlanarContactPoint,
) -> tuple[VertexPositionAtFace, VertexPositionAtFace]:
    """Return the positions of both vertices near a contact point, after the equations are solved."""
    mine, depth = contact_point.vertex_is_of_a > 0.0, point_solution.now.depth
    return (
        VertexPositionAtFace(
            depth if mine else vertex_a.depth, vertex_a.place - point_solution.added_slip if mine else vertex_a.place
        ),
        VertexPositionAtFace(
            vertex_b.depth if mine else depth, vertex_b.place if mine else vertex_b.place + point_solution.added_slip
        ),
    )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def compute_pair_forces_after_solution(
    pair_rows: Any, element_a_rows: Any, element_b_rows: Any, case_rows: Any
) -> None:
    """Add the solved contact forces between two elements to both; store the contact's new state for acceptance."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        pair, step, first, second = (
            rows.load_pair(pair_rows, j),
            rows.load_step(pair_rows, j),
            rows.load_element(element_a_rows, j),
            rows.load_element(element_b_rows, j),
        )
        case, on, by, law, segment = rows.load_case(case_rows, j), first.trial, second.trial, pair.law, step.segment
        fine, half, old = (
            predicted_forces_decide_contact(case),
            0.5 * (case.tick_length * case.attempt.length),
            case.findings,
        )
        moves = (
            PairMotionAndInertia(velocity_of_a_relative_to_b(on.end, by.end), first.inertia, second.inertia),
            velocity_of_a_relative_to_b(on.change, by.change),
        )
        kind = (fine, pair_lands_flat(law, pair.history, segment, moves[0]))
        (u, d), inertia_a, inertia_b = (moves[0].velocity, moves[1]), first.inertia, second.inertia
        solved = PairMotionAndInertia(
            PairRelativeVector(u.x + d.x, u.z + d.z, u.a + d.a, u.b + d.b), inertia_a, inertia_b
        )
        point_1, point_2 = contact_points_with_landing_lever_arms(law, segment, solved, kind[1])
        s1 = solved_planar_contact_point(law, pair.history.one, segment.one, step.one, moves, half, kind)
        s2 = solved_planar_contact_point(law, pair.history.two, segment.two, step.two, moves, half, kind)
        on_a, on_b = add_pair_force_to_elements(
            first.force, second.force, sum_contact_point_forces(point_1, point_2, s1.now.force, s2.now.force)
        )
        rows.store_force(element_a_rows, j, on_a)
        rows.store_force(element_b_rows, j, on_b)
        a1, b2 = vertex_positions_from_contact_solution(segment.now.a1, segment.now.b2, segment.one, s1)
        a2, b1 = vertex_positions_from_contact_solution(segment.now.a2, segment.now.b1, segment.two, s2)
        rows.store_corrected(pair_rows, j, pair_history_after_step(
            pair.history, segment, FaceVertexPositions(a1, a2, b1, b2),
            correct_slip_for_friction_work(segment, (point_1, point_2), (s1.now, s2.now)), law, 2.0 * half
        ))  # fmt: skip
        pair_rows[rows.SLID_ONE + j], pair_rows[rows.SLID_TWO + j] = s1.found, s2.found
        slide = (s1.found != 0.0) & (s2.found != 0.0) & (s1.now.force.n + s2.now.force.n > 0.0)
        rows.store_findings(case_rows, j, StepContactChangesAsFloats(
            1.0 if s1.changed | s2.changed else old.changed,
            1.0 if s1.has_wrong_slip_assumption | s2.has_wrong_slip_assumption else old.has_wrong_slip_assumption,
            1.0 if s1.has_slip_reversal | s2.has_slip_reversal else old.has_slip_reversal, 1.0 if slide else old.slides,
            1.0 if s1.has_friction_reversal | s2.has_friction_reversal else old.has_friction_reversal,
        ))  # fmt: skip


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def store_accepted_pair_history(pair_rows: Any, case_rows: Any) -> None:
    """Replace the contact state of two elements by the new one, in each case whose step is accepted."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        step, decision = rows.load_step(pair_rows, j), rows.load_case(case_rows, j).decision
        rows.keep_history(pair_rows, j, decision.again > 0.0, step.corrected)
        pair_rows[rows.SLID_ONE + j] = select(
            decision.keeps_assumed_slip > 0.0, step.one.slid, pair_rows[rows.SLID_ONE + j]
        )
        pair_rows[rows.SLID_TWO + j] = select(
            decision.keeps_assumed_slip > 0.0, step.two.slid, pair_rows[rows.SLID_TWO + j]
        )
