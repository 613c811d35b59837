"""Independent reference for 3-D bodies: a box by the equations of docs/method.md, in short steps of fixed length.

It shares no code with the package's kernels: rotation matrices are updated by Rodrigues' formula, contacts are if
statements, every force is explicit, and the step is a fraction of the shortest contact time scale.
"""

import math

import numpy as np
from numba import njit

from overturning.arrays import FloatArray
from overturning.kernel_cache import cache_compiled_kernel
from overturning.motion.motion import Motion

G = 9.80665


@njit
def apply_rotation_vector_to_rotation_matrix(matrix, vector):
    """Return the rotation matrix of `matrix` followed by a rotation vector in fixed axes, by Rodrigues' formula."""
    angle = math.sqrt(np.sum(vector * vector))
    if angle == 0.0:
        return matrix.copy()
    x, y, z = vector / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return (np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * (cross @ cross)) @ matrix


@njit
def angular_velocity_from_momentum(matrix, inertia, momentum):
    """Return the angular velocity, rad/s, of a body with a rotation matrix and an angular momentum, in fixed axes."""
    return matrix @ ((matrix.T @ momentum) / inertia)


@cache_compiled_kernel
@njit
def integrate_box(
    times, ground, interval, size, initial_rotation_matrix, spring, dash, mu, step_over_contact_time_scale
):
    """Return positions of a box's centre (m) and rotations from rest, shapes (times, 3) and (times, 3, 3).

    `times`: ascending, s. `ground`: acceleration of the base to east, north and up, shape (samples, 3), m/s². `size`:
    edges of the box, m, along the columns of `frame`, its axes at rest. `spring`, `dash`: spring (1/s²) and dashpot
    (1/s) of a corner per mass.
    """
    inertia = np.array([size[1] ** 2 + size[2] ** 2, size[0] ** 2 + size[2] ** 2, size[0] ** 2 + size[1] ** 2]) / 12.0
    corners = np.array([[i * size[0], j * size[1], -size[2]] for i in (-1.0, 1.0) for j in (-1.0, 1.0)]) * 0.5
    # The effective mass at a corner is at least a tenth of the mass in any direction, also for a long box.
    steps = math.ceil(interval * max(math.sqrt(10.0 * spring), 10.0 * dash) / step_over_contact_time_scale)
    dt = interval / steps
    place, velocity, momentum = np.array([0.0, 0.0, 0.5 * size[2] - 0.25 * G / spring]), np.zeros(3), np.zeros(3)
    force, moment, rotation = np.zeros(3), np.zeros(3), initial_rotation_matrix.copy()
    last, stretch, touched = np.zeros((4, 2)), np.zeros((4, 2)), np.zeros(4, np.bool_)
    places, rotations, noted = np.zeros((len(times), 3)), np.zeros((len(times), 3, 3)), 0
    for sample in range(len(ground)):
        following = ground[sample + 1] if sample + 1 < len(ground) else np.zeros(3)
        for step in range(steps):
            velocity = velocity + 0.5 * dt * force
            momentum = momentum + 0.5 * dt * moment
            middle = apply_rotation_vector_to_rotation_matrix(
                rotation, 0.5 * dt * angular_velocity_from_momentum(rotation, inertia, momentum)
            )
            before, place = (place, rotation), place + dt * velocity
            rotation = apply_rotation_vector_to_rotation_matrix(
                rotation, dt * angular_velocity_from_momentum(middle, inertia, momentum)
            )
            while noted < len(times) and times[noted] <= sample * interval + (step + 1.0) * dt:
                share = (times[noted] - sample * interval) / dt - step
                places[noted] = before[0] + share * (place - before[0])
                rotations[noted] = (before[1] + share * (rotation - before[1])) @ initial_rotation_matrix.T
                noted += 1
            v, w = (
                velocity + 0.5 * dt * force,
                angular_velocity_from_momentum(rotation, inertia, momentum + 0.5 * dt * moment),
            )
            force = -(ground[sample] + (following - ground[sample]) * (step + 1.0) / steps)
            force[2] -= G
            moment = np.zeros(3)
            for i in range(4):
                arm = rotation @ corners[i]
                here, depth = (place + arm)[:2], -(place[2] + arm[2])
                if depth > 0.0:
                    moving = v + np.cross(w, arm)
                    stretch[i] = stretch[i] + (here - last[i]) if touched[i] else np.zeros(2)
                    f = np.zeros(3)
                    f[2] = max(spring * depth - dash * moving[2], 0.0)
                    f[:2] = -spring * stretch[i] - dash * moving[:2]
                    size_of, most = math.sqrt(f[0] ** 2 + f[1] ** 2), mu * f[2]
                    if size_of > most:
                        f[:2] *= most / size_of
                        long = math.sqrt(stretch[i, 0] ** 2 + stretch[i, 1] ** 2)
                        stretch[i] *= min(1.0, most / spring / long) if long > 0.0 else 1.0
                    force = force + f
                    moment = moment + np.cross(arm, f)
                touched[i], last[i] = depth > 0.0, here
            velocity = velocity + 0.5 * dt * force
            momentum = momentum + 0.5 * dt * moment
        left, _, right = np.linalg.svd(rotation)
        rotation = left @ right
    return places, rotations


def box_trajectory(
    times: FloatArray, motion: Motion, orientation_deg: float, size: FloatArray, mu: float, penetration: float
) -> tuple[FloatArray, FloatArray]:
    """Return positions and rotations of a box whose first edge faces an azimuth, by `integrate_box`.

    `penetration`: static penetration over the smaller width. The damping ratio is 1.
    """
    angle = np.radians(orientation_deg)
    frame = np.array([[np.sin(angle), -np.cos(angle), 0.0], [np.cos(angle), np.sin(angle), 0.0], [0.0, 0.0, 1.0]])
    ground = np.column_stack([motion.east, motion.north, 0 * motion.north if motion.up is None else motion.up])
    spring = G / (4.0 * penetration * size[:2].min())
    return integrate_box(
        times, ground, motion.sampling_interval, size, frame, spring, 2.0 * np.sqrt(spring / 4.0), mu, 0.04
    )
