"""Energy account of one case: energy of its elements and springs, and work of its contacts."""

from typing import Any

from numba import njit

from overturning.dem.kernel.lanes import INTERNAL_COMPILE_OPTIONS
from overturning.dem.polygon import rows
from overturning.dem.polygon.earlier_positions import earlier_vertex_positions
from overturning.dem.polygon.faces import contact_vertex_position
from overturning.dem.polygon.state import CONTACT_CODE_OPEN, CONTACT_CODE_VERTEX_OF_B, ElementState, PairState


@njit(**INTERNAL_COMPILE_OPTIONS)
def scene_energy(case_states: Any, lane: int, scene_arrays: Any) -> float:
    """Return the energy of a scene, J: kinetic and gravitational of free elements, plus that of contact springs.

    In Cundall's scheme, kinetic and gravitational energy are those half a step ago, at the time of the velocities.
    """
    total = 0.0
    for p in range(scene_arrays.pair_element_and_piece_indices.shape[0]):
        q, _, _ = rows.slice_pair_and_element_rows(case_states, scene_arrays, p)
        total += pair_spring_energy(rows.load_pair_state(q, lane))
    return total + kinetic_and_gravitational_energy(case_states, lane, scene_arrays)


@njit(**INTERNAL_COMPILE_OPTIONS)
def kinetic_and_gravitational_energy(case_states: Any, lane: int, scene_arrays: Any) -> float:
    """Compute kinetic and gravitational energy (J) of the free elements of a scene at the time of their velocities.

    This time is half a step ago in Cundall's scheme, now in the centred scheme.
    """
    total, half = 0.0, rows.load_scene_state(case_states, lane).velocity_lag_behind_pose
    for e in range(scene_arrays.fall_and_support_table.shape[1]):
        item = rows.load_element_state(rows.slice_element_rows(case_states, e), lane)
        if item.constants.inverse_mass != 0.0:
            height = item.pose.z - half * item.velocity.z
            total += element_kinetic_energy(item) + item.constants.mass * scene_arrays.gravity * height
    return total


@njit(**INTERNAL_COMPILE_OPTIONS)
def pair_spring_energy(pair: PairState) -> float:
    """Compute the energy stored in the contact springs between two elements, J."""
    total, history = 0.0, pair.history
    for end in range(2):
        memory = history.point_1 if end == 0 else history.point_2
        if memory.contact_vertex_status_code != CONTACT_CODE_OPEN:
            depth = contact_vertex_position(memory, end, history.previous_vertex_positions).depth
            total += 0.5 * (
                pair.contact_law.normal_stiffness * depth * depth
                + pair.contact_law.tangential_stiffness
                * (memory.tangential_spring_stretch * memory.tangential_spring_stretch)
            )
    return total


@njit(**INTERNAL_COMPILE_OPTIONS)
def element_kinetic_energy(element: ElementState) -> float:
    """Compute the kinetic energy of a free element, J, from its stored velocities."""
    v, own = element.velocity, element.constants
    return float(0.5 * (own.mass * (v.x * v.x + v.z * v.z) + v.angular * v.angular / own.inverse_inertia))


@njit(**INTERNAL_COMPILE_OPTIONS)
def contact_force_work_while_velocities_lag_poses(case_states: Any, lane: int, scene_arrays: Any) -> float:
    """Return the work (J) of a scene's contact forces from their whole step to the time of the velocities.

    In Cundall's scheme this time is half a step later. A contact force does half of its work in the half step before
    its whole step, half in the half step after it; `pair_history_after_step` adds the second half only with the next
    step.
    """
    work = 0.0
    for p in range(scene_arrays.pair_element_and_piece_indices.shape[0]):
        q, a, b = rows.slice_pair_and_element_rows(case_states, scene_arrays, p)
        pair = rows.load_pair_state(q, lane)
        history = pair.history
        if (
            history.point_1.contact_vertex_status_code == CONTACT_CODE_OPEN
            and history.point_2.contact_vertex_status_code == CONTACT_CODE_OPEN
        ):
            continue
        later = earlier_vertex_positions(pair, rows.load_element_state(a, lane), rows.load_element_state(b, lane), 0.0)
        for end in range(2):
            memory = history.point_1 if end == 0 else history.point_2
            old, new = (
                contact_vertex_position(memory, end, history.previous_vertex_positions),
                contact_vertex_position(memory, end, later),
            )
            slip = old.position_along_opposite_face - new.position_along_opposite_face
            slip = -slip if memory.contact_vertex_status_code == CONTACT_CODE_VERTEX_OF_B else slip
            work += 0.5 * (memory.normal_force * (new.depth - old.depth) - memory.tangential_force * slip)
    return work
