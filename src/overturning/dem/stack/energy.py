"""Energy of the stones of a stack and of their contacts."""

from typing import Any

import numpy as np
from numba import njit

from overturning.dem.body.rotation import angular_velocity_from_momentum
from overturning.dem.body.state import squared_sine_of_lean_continued_beyond_90_deg
from overturning.dem.body.vectors import (
    Matrix3,
    Vector3,
    dot_product,
    matrix_product,
    matrix_times_vector,
    minus,
    rotation_matrix,
    transpose,
)
from overturning.dem.kernel.lanes import INLINE_OPTIONS, INTERNAL_COMPILE_OPTIONS
from overturning.dem.stack.access import (
    VALUE_COUNT_PER_CASE_IN_ALL_LANES,
    VALUE_COUNT_PER_JOINT_IN_ALL_LANES,
    VALUE_COUNT_PER_POINT_IN_ALL_LANES,
    VALUE_COUNT_PER_STONE_IN_ALL_LANES,
    load_case_progress,
    load_fall_flags_and_last_upright_time,
    load_joint_constants,
    load_joint_state_at_step_start,
    load_point_state_at_step_start,
    load_stone_constants,
    load_stone_state,
    load_tick_length_failure_and_rest_limits,
    slice_stone_rows,
)
from overturning.dem.stack.joint_state import squared_length
from overturning.dem.stack.state import (
    StoneConstants,
    StoneState,
)
from overturning.dem.stack.step import state_array_length_per_joint
from overturning.units import STANDARD_GRAVITY as GRAVITY


@njit(**INLINE_OPTIONS)
def stone_state_sum_for_finite_check(state: StoneState) -> float:
    """Return the sum of a stone's position, rotation and velocity components: finite if each component is finite."""
    v, p, q = state.velocity_relative_to_base, state.centre_position, state.rotation
    return (v.x + v.y + v.z) + (p.x + p.y + p.z) + (q.w + q.x + q.y + q.z)


@njit(**INTERNAL_COMPILE_OPTIONS)
def stone_kinetic_energy(stone_constants: StoneConstants, state: StoneState) -> float:
    """Return the kinetic energy of a stone, J."""
    spin = angular_velocity_from_momentum(
        stone_constants.mass_times_inverse_inertia, rotation_matrix(state.rotation), state.angular_momentum_per_mass
    )
    return float(
        0.5
        * stone_constants.mass
        * (
            dot_product(state.velocity_relative_to_base, state.velocity_relative_to_base)
            + dot_product(state.angular_momentum_per_mass, spin)
        )
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def energy_of_unfallen_stones_and_contact_springs(
    stack_states: Any, lane: int, stone_count: int, max_corner_count_per_face: int, zero_energy_height_by_stone: Any
) -> float:
    """Return the energy (J) of the stones of a stack that have not fallen, and of the contact springs below them.

    `zero_energy_height_by_stone` holds the height of each centre from which its potential energy is counted, m.
    """
    total = 0.0
    first = VALUE_COUNT_PER_CASE_IN_ALL_LANES + stone_count * VALUE_COUNT_PER_STONE_IN_ALL_LANES
    size = state_array_length_per_joint(max_corner_count_per_face)
    for s in range(stone_count):
        rows = slice_stone_rows(stack_states, s)
        if not load_fall_flags_and_last_upright_time(rows, lane).is_still_simulated > 0.0:
            continue
        constants, stone = load_stone_constants(rows, lane), load_stone_state(rows, lane)
        total += stone_kinetic_energy(constants, stone) + constants.mass * GRAVITY * (
            stone.centre_position.z - zero_energy_height_by_stone[s]
        )
        at = first + s * size
        joint_rows = stack_states[at : at + VALUE_COUNT_PER_JOINT_IN_ALL_LANES]
        joint, old = load_joint_constants(joint_rows, lane), load_joint_state_at_step_start(joint_rows, lane)
        total += 0.5 * joint.tangential_stiffness * squared_length(old.tangential_spring_stretch)
        for i in range((size - VALUE_COUNT_PER_JOINT_IN_ALL_LANES) // VALUE_COUNT_PER_POINT_IN_ALL_LANES):
            begin = at + VALUE_COUNT_PER_JOINT_IN_ALL_LANES + i * VALUE_COUNT_PER_POINT_IN_ALL_LANES
            point = load_point_state_at_step_start(
                stack_states[begin : begin + VALUE_COUNT_PER_POINT_IN_ALL_LANES], lane
            )
            depth = max(point.penetration, 0.0)
            total += 0.5 * joint.normal_stiffness * point.joint_stiffness_share * depth * depth
    return total


@njit(**INLINE_OPTIONS)
def pose_relative_to_stone_below(
    upper_stone: StoneState, lower_stone_centre: Vector3, lower_stone_axes: Matrix3
) -> tuple[Vector3, Matrix3]:
    """Return position (m) and axes of a stone in the frame that moves with the stone below it."""
    to_lower = transpose(lower_stone_axes)
    return matrix_times_vector(to_lower, minus(upper_stone.centre_position, lower_stone_centre)), matrix_product(
        to_lower, rotation_matrix(upper_stone.rotation)
    )


@njit(**INTERNAL_COMPILE_OPTIONS)
def stack_energy_is_too_small_to_overturn(
    stack_states: Any, lane: int, max_corner_count_per_face: int, stone_table_rows: Any
) -> bool:
    """True if no stone has fallen or leans critically, and the energy cannot overturn the stones above any joint.

    Overturning needs the energy `CaseProgress.energy_needed_to_overturn`. A slip on another stone shortens the
    supported base: if a share s of the base is still supported, at least s² of this energy is needed. A slip on the
    ground, which has no rim, changes nothing. A joint is the contact of a stone with its support.
    """
    case, course = load_tick_length_failure_and_rest_limits(stack_states, lane), load_case_progress(stack_states, lane)
    # Horizontal position of the upper face below, and of the centre of its stone at rest.
    slip, x, y, start_x, start_y = 0.0, 0.0, 0.0, 0.0, 0.0
    for s in range(stone_table_rows.size):
        rows, start = slice_stone_rows(stack_states, s), stone_table_rows[s].start
        constants, stone = load_stone_constants(rows, lane), load_stone_state(rows, lane)
        own = rotation_matrix(stone.rotation)
        if (
            not load_fall_flags_and_last_upright_time(rows, lane).is_still_simulated > 0.0
            or squared_sine_of_lean_continued_beyond_90_deg(own)
            >= constants.critical_lean_squared_sine_on_contact_at_rest
        ):
            return False
        ahead = (stone.centre_position.x - constants.centre_height * own.xz - x) - (start.x - start_x)
        aside = (stone.centre_position.y - constants.centre_height * own.yz - y) - (start.y - start_y)
        # Not math.hypot: its last digit differs between processors.
        slip += np.sqrt(ahead * ahead + aside * aside) if s > 0 else 0.0
        x = stone.centre_position.x + constants.upper_face_height_above_centre * own.xz
        y = stone.centre_position.y + constants.upper_face_height_above_centre * own.yz
        start_x, start_y = start.x, start.y
    left = max(1.0 - slip / case.min_distance_of_mass_centre_above_to_joint_side, 0.0)
    heights = stone_table_rows.centre_height_at_rest
    energy = (
        energy_of_unfallen_stones_and_contact_springs(
            stack_states, lane, stone_table_rows.size, max_corner_count_per_face, heights
        )
        - course.initial_energy
    )
    return bool(energy < course.energy_needed_to_overturn * left * left)
