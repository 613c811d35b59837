"""Cundall's scheme: springs at the whole step, dashpots half a step earlier, from differences of penetration and place.

Central differences: forces and accelerations at the whole step, velocities half a step later, poses one step later.
"""

from typing import Any, NamedTuple

from numba import njit

from overturning.dem.kernel.ground import base_acceleration_at_tick
from overturning.dem.kernel.lanes import INLINE_OPTIONS, INTERNAL_COMPILE_OPTIONS, NO_ALIAS_COMPILE_OPTIONS, select
from overturning.dem.kernel.mechanics import clamp_magnitude, updated_maximum
from overturning.dem.polygon import rows
from overturning.dem.polygon.faces import ContactSegment, PlanarContactPoint, find_contact_segment
from overturning.dem.polygon.landing import (
    RelativeVelocityAndConstantsOfPair,
    contact_points_with_flat_landing_lever_arms,
    pair_lands_flat,
    results_with_slip_corrected_for_friction_work,
    slides_in_landing_and_signed_friction_coefficient,
)
from overturning.dem.polygon.mechanics import (
    PlanarContactPointForce,
    PlanarContactPointResult,
    element_acceleration_relative_to_base,
    element_force_sums_with_pair_force_added,
    extrapolate_pose,
    extrapolate_velocity,
    friction_force_and_its_limit_and_slip_flag,
    pair_history_after_step,
    power_against_inertial_or_fixing_forces,
    sum_contact_point_forces,
    trial_tangential_spring_stretch,
    velocity_of_a_relative_to_b,
)
from overturning.dem.polygon.search import update_nearest_faces_and_check_possible_contact
from overturning.dem.polygon.state import (
    ContactPointConstants,
    ElementStepMotionWorkAndPeaks,
    PlanarContactPointStateAfterLastStep,
    PlanarMotionOrForce,
)
from overturning.dem.polygon.suspended_pairs import (
    keep_contact_tests_unless_distant,
    sum_motions_and_resume_contact_tests,
)


class SceneCundallSchemeConstants(NamedTuple):
    """Constants of Cundall's scheme: lag of velocities behind poses, and ticks (time units) in a whole step."""

    velocity_lag_behind_pose_steps: float = 0.5
    """Lag of velocities behind poses, steps."""
    ticks_per_whole_step: float = 1.0
    """Ticks in a whole step."""


@njit(**INLINE_OPTIONS)
def planar_contact_point_result_of_cundall_step(
    contact_law: ContactPointConstants,
    point_history: PlanarContactPointStateAfterLastStep,
    contact_point: PlanarContactPoint,
    contact_segment: ContactSegment,
    steps_per_second: float,
    lands_flat_slides_and_signed_friction: tuple[bool, bool, float],
) -> PlanarContactPointResult:
    """Return force, penetration and slip at a contact point of two elements from spring, dashpot and friction.

    `overturning.dem.polygon.mechanics.friction_force_and_its_limit_and_slip_flag` describes the argument
    `lands_flat_slides_and_signed_friction`.
    """
    fade = contact_law.dashpot_coefficient * steps_per_second
    n = contact_law.normal_stiffness * contact_point.penetration + fade * (
        contact_point.penetration - contact_point.previous_step_penetration
    )
    n = n if contact_point.is_in_contact & (lands_flat_slides_and_signed_friction[0] | (n > 0.0)) else 0.0
    drag = fade * contact_point.slip_of_a_in_step
    stretch = trial_tangential_spring_stretch(
        point_history, contact_point, contact_segment, contact_law.tangential_compliance_or_zero_without_spring, drag
    )
    t = -(contact_law.tangential_stiffness * stretch) - drag
    # The spring of a slipping point is shortened to the force that friction can hold.
    held, drifts, drift = lands_flat_slides_and_signed_friction
    force, holds, slips = friction_force_and_its_limit_and_slip_flag(
        t, n, contact_law, (held & contact_point.is_in_contact, drifts, drift)
    )
    spring = (
        clamp_magnitude(stretch, holds * contact_law.tangential_compliance_or_zero_without_spring) if slips else stretch
    )
    return PlanarContactPointResult(
        PlanarContactPointForce(n, force, spring),
        contact_point.penetration,
        contact_point.slip_of_a_in_step,
        contact_point.is_in_contact,
    )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def add_pair_forces_and_store_contact_history(
    pair_state_rows: Any, element_a_state_rows: Any, element_b_state_rows: Any, scene_state_rows: Any
) -> None:
    """Add the contact forces between two elements to both of them, and store the contact's new state."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        pair, first, second = (
            rows.load_pair_state(pair_state_rows, j),
            rows.load_element_state(element_a_state_rows, j),
            rows.load_element_state(element_b_state_rows, j),
        )
        case, old = rows.load_scene_state(scene_state_rows, j), pair.history
        segment = find_contact_segment(pair, first.pose, second.pose)
        u, own_a, own_b = (
            velocity_of_a_relative_to_b(first.velocity, second.velocity),
            first.constants,
            second.constants,
        )
        held = pair_lands_flat(pair.contact_law, old, segment, RelativeVelocityAndConstantsOfPair(u, own_a, own_b))
        point_1, point_2 = contact_points_with_flat_landing_lever_arms(
            pair.contact_law, segment, RelativeVelocityAndConstantsOfPair(u, own_a, own_b), held
        )
        flat_one = (
            held,
            *slides_in_landing_and_signed_friction_coefficient(
                pair.contact_law, segment.point_1, u, own_a, own_b, held
            ),
        )
        flat_two = (
            held,
            *slides_in_landing_and_signed_friction_coefficient(
                pair.contact_law, segment.point_2, u, own_a, own_b, held
            ),
        )
        one = planar_contact_point_result_of_cundall_step(
            pair.contact_law, old.point_1, segment.point_1, segment, case.ticks_per_second, flat_one
        )
        two = planar_contact_point_result_of_cundall_step(
            pair.contact_law, old.point_2, segment.point_2, segment, case.ticks_per_second, flat_two
        )
        on_a, on_b = element_force_sums_with_pair_force_added(
            first.contact_force_sum,
            second.contact_force_sum,
            sum_contact_point_forces(point_1, point_2, one.force, two.force),
        )
        rows.store_contact_force_sum(element_a_state_rows, j, on_a)
        rows.store_contact_force_sum(element_b_state_rows, j, on_b)
        results = results_with_slip_corrected_for_friction_work(segment, (point_1, point_2), (one, two))
        rows.store_contact_history(
            pair_state_rows,
            j,
            pair_history_after_step(
                old, segment, segment.face_vertex_positions, results, pair.contact_law, case.tick_duration
            ),
        )


@njit(**NO_ALIAS_COMPILE_OPTIONS)
def advance_element_motion_one_step(
    upward_base_acceleration_or_none: Any, element_state_rows: Any, scene_state_rows: Any, gravity: float
) -> None:
    """Advance the motion of an element by a step of Cundall's scheme, for all cases in parallel."""
    for j in range(rows.PARALLEL_CASE_COUNT):
        item, case = rows.load_element_state(element_state_rows, j), rows.load_scene_state(scene_state_rows, j)
        dt, shaking, half, old = (
            case.tick_duration,
            case.base_acceleration,
            0.5 * case.tick_duration,
            item.step_motion_with_work_and_peaks_so_far,
        )
        ground = (
            base_acceleration_at_tick(shaking.horizontal, shaking.ticks_since_sample_start)
            * item.constants.has_inertial_forces_in_base_frame
        )
        lift = 0.0
        if upward_base_acceleration_or_none is not None:
            lift = (
                base_acceleration_at_tick(shaking.vertical, shaking.ticks_since_sample_start)
                * item.constants.has_inertial_forces_in_base_frame
            )
        a = element_acceleration_relative_to_base(item, ground, lift, gravity)
        v = extrapolate_velocity(item.velocity, a, dt)
        work = old.work_by_base_and_fixing_forces_so_far - dt * power_against_inertial_or_fixing_forces(
            item, ground, lift, extrapolate_velocity(item.velocity, a, half)
        )
        pose = extrapolate_pose(item.pose, v, dt)
        on = pose.angle
        upright = (on < item.constants.max_recoverable_rotation_to_plus_x) & (
            -on < item.constants.max_recoverable_rotation_to_minus_x
        )
        last = select(upright, shaking.ticks_since_sample_start + 1.0, old.last_recoverable_tick_in_sample)
        back, on = updated_maximum(old.peak_rotation_to_minus_x, -on), updated_maximum(old.peak_rotation_to_plus_x, on)
        far, turn = dt * (abs(v.x) + abs(v.z)), abs(dt * v.angular)
        rows.store_pose(element_state_rows, j, pose)
        rows.store_velocity(element_state_rows, j, v)
        rows.store_acceleration(element_state_rows, j, a)
        rows.store_contact_force_sum(element_state_rows, j, PlanarMotionOrForce(0.0, 0.0, 0.0))
        rows.store_step_motion_work_and_peaks(
            element_state_rows, j, ElementStepMotionWorkAndPeaks(far, turn, work, back, on, last, 0.0)
        )


@njit(**INTERNAL_COMPILE_OPTIONS)
def advance_scene_one_step(
    upward_base_acceleration_or_none: Any,
    case_states: Any,
    equation_submatrices_of_all_cases: Any,  # noqa: ARG001, used by the centred scheme only
    nonzero_pattern: Any,  # noqa: ARG001
    pair_contact_test_schedule: Any,
    moves_relative_to_base_by_element: Any,
    scene_arrays: Any,
    ticks_per_sample: float,  # noqa: ARG001, each step is one tick
) -> None:
    """Advance a scene by a step of Cundall's scheme, for all cases in parallel; vertical base motion may be None."""
    sum_motions_and_resume_contact_tests(
        case_states, scene_arrays, pair_contact_test_schedule, moves_relative_to_base_by_element.size
    )
    kept = 0
    for n in range(pair_contact_test_schedule.active_pair_count[0]):
        p = pair_contact_test_schedule.indices_of_pairs_tested_each_step[n]
        q, a, b = rows.slice_pair_and_element_rows(case_states, scene_arrays, p)
        near = update_nearest_faces_and_check_possible_contact(
            case_states,
            q,
            a,
            b,
            scene_arrays.pair_element_and_piece_indices[p, 2],
            scene_arrays.pair_element_and_piece_indices[p, 3],
            scene_arrays.piece_vertex_counts,
            scene_arrays.piece_face_tables,
        )
        if near:
            add_pair_forces_and_store_contact_history(q, a, b, case_states)
        if near or keep_contact_tests_unless_distant(q, a, b, p, pair_contact_test_schedule):
            pair_contact_test_schedule.indices_of_pairs_tested_each_step[kept] = p
            kept += 1
    pair_contact_test_schedule.active_pair_count[0] = kept
    for i in range(moves_relative_to_base_by_element.size):
        # Free and held elements move; a driven one rests in the frame of the base.
        if moves_relative_to_base_by_element[i]:
            advance_element_motion_one_step(
                upward_base_acceleration_or_none,
                rows.slice_element_rows(case_states, i),
                case_states,
                scene_arrays.gravity,
            )
    for j in range(rows.PARALLEL_CASE_COUNT):
        case_states[rows.TICKS_SINCE_SAMPLE_START_ROW_OFFSET + j] = (
            case_states[rows.TICKS_SINCE_SAMPLE_START_ROW_OFFSET + j] + 1.0
        )
