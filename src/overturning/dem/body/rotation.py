"""Rotation of a body: inertial accelerations in its frame, and its angular velocity."""

from typing import Any

from numba import njit

from overturning.dem.body.state import BodyConstants, BodyState, InertialAndUpwardBaseAccelerations3D
from overturning.dem.body.vectors import (
    Matrix3,
    Quaternion,
    SymmetricMatrix,
    Vector3,
    expand_symmetric_matrix,
    extrapolate_vector,
    matrix_times_vector,
    rotate_quaternion,
    rotation_matrix,
    transpose,
)
from overturning.dem.kernel.ground import linear_base_acceleration_of_sample
from overturning.dem.kernel.lanes import INLINE_OPTIONS, INTERNAL_COMPILE_OPTIONS


@njit(**INTERNAL_COMPILE_OPTIONS)
def inertial_accelerations_until_next_sample(
    base_acceleration_xy: Any, upward_base_acceleration: Any, sample_index: int, amplitude_factor: float,
    samples_per_tick: float,
) -> InertialAndUpwardBaseAccelerations3D:  # fmt: skip
    """Return the inertial accelerations (m/s²) in the frame of the base, linear from a sample to the next one.

    `base_acceleration_xy` holds the base accelerations along x and y, shape (2, samples), m/s². All accelerations are
    multiplied by `amplitude_factor`. The horizontal ones are those of the base with the opposite sign; the upward one
    is that of the base.
    """
    return InertialAndUpwardBaseAccelerations3D(
        linear_base_acceleration_of_sample(base_acceleration_xy[0], sample_index, -amplitude_factor, samples_per_tick),
        linear_base_acceleration_of_sample(base_acceleration_xy[1], sample_index, -amplitude_factor, samples_per_tick),
        linear_base_acceleration_of_sample(upward_base_acceleration, sample_index, amplitude_factor, samples_per_tick),
    )


@njit(**INLINE_OPTIONS)
def angular_velocity_from_momentum(
    mass_times_inverse_inertia: SymmetricMatrix, body_axes: Matrix3, angular_momentum_per_mass: Vector3
) -> Vector3:
    """Return the angular velocity (rad/s) of a body from its angular momentum per mass, in the axes of the base."""
    own = matrix_times_vector(transpose(body_axes), angular_momentum_per_mass)
    inverse = expand_symmetric_matrix(mass_times_inverse_inertia)
    return matrix_times_vector(body_axes, matrix_times_vector(inverse, own))


@njit(**INLINE_OPTIONS)
def rotation_and_angular_velocity_after_step(
    mass_times_inverse_inertia: SymmetricMatrix, rotation_at_step_start: Quaternion,
    angular_momentum_per_mass_at_half_step: Vector3, contact_moment_per_mass: Vector3, step_length_s: float,
) -> tuple[Quaternion, Vector3]:  # fmt: skip
    """Return the rotation (quaternion) and angular velocity of a body after a step (s) with constant moment."""
    half, inverse, momentum = 0.5 * step_length_s, mass_times_inverse_inertia, angular_momentum_per_mass_at_half_step
    w = angular_velocity_from_momentum(inverse, rotation_matrix(rotation_at_step_start), momentum)
    mid_turn = rotate_quaternion(rotation_at_step_start, half, w)
    w = angular_velocity_from_momentum(inverse, rotation_matrix(mid_turn), momentum)
    end_turn = rotate_quaternion(rotation_at_step_start, step_length_s, w)
    end_momentum = extrapolate_vector(momentum, half, contact_moment_per_mass)
    return end_turn, angular_velocity_from_momentum(inverse, rotation_matrix(end_turn), end_momentum)


@njit(**INLINE_OPTIONS)
def angular_velocity_of_state(body: BodyConstants, state: BodyState) -> Vector3:
    """Return the angular velocity (rad/s) of a body in the axes of the base, from the angular momentum in `state`."""
    return angular_velocity_from_momentum(
        body.mass_times_inverse_inertia, rotation_matrix(state.rotation), state.angular_momentum_per_mass
    )
