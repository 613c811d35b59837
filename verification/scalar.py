"""Reference for the speed of the kernel: one block at a time in a plain scalar loop with branches for contacts.

Both schemes use fixed steps and the equations of docs/method.md only: no short steps after a change of contact, no
energy account. The loop shows the cost of a block step without vectorisation; its results are not used.
"""

import math

import numpy as np
from numba import njit

from overturning.units import STANDARD_GRAVITY

G = STANDARD_GRAVITY


@njit
def _solve_implicit_step(  # type: ignore[no-untyped-def]
    equation_matrix_workspace,
    right_side_workspace,
    lower_corner_arms_x,
    corner_arm_z,
    corner_penetrations,
    corner_tangential_spring_stretches,
    predicted_velocity_at_step_end,
    gravity_and_inertial_acceleration,
    known_velocity_at_mid_step,
    half_time_step,
    corner_stiffness_per_mass,
    corner_dashpot_constant_per_mass,
    friction,
    mass_over_moment_of_inertia,
):
    """Return the velocities (x, z, rotation) of a block at the end of a centred step, with implicit contact forces.

    The sequences over the two lower corners are positions from the centre of mass, penetrations and stretches, m.
    Stiffness, 1/s², and dashpot constant, 1/s, are those of a corner, divided by the mass; the inverse of the radius of
    gyration squared, 1/m², is `mass_over_moment_of_inertia`. The contents of both workspaces are overwritten.
    """
    for p in range(3):
        equation_matrix_workspace[p, 0] = equation_matrix_workspace[p, 1] = equation_matrix_workspace[p, 2] = 0.0
        equation_matrix_workspace[p, p], right_side_workspace[p] = (
            1.0,
            known_velocity_at_mid_step[p] + half_time_step * gravity_and_inertial_acceleration[p],
        )
    for q in range(2):
        rise, along = (
            predicted_velocity_at_step_end[1] - lower_corner_arms_x[q] * predicted_velocity_at_step_end[2],
            predicted_velocity_at_step_end[0] + corner_arm_z[q] * predicted_velocity_at_step_end[2],
        )
        n, f = (
            corner_stiffness_per_mass * corner_penetrations[q] - corner_dashpot_constant_per_mass * rise,
            corner_stiffness_per_mass * corner_tangential_spring_stretches[q]
            + corner_dashpot_constant_per_mass * along,
        )
        if corner_penetrations[q] <= 0.0 or n <= 0.0:
            continue
        d = corner_dashpot_constant_per_mass + half_time_step * corner_stiffness_per_mass
        normal, pressed = (0.0, d, -d * lower_corner_arms_x[q]), n + d * rise
        tangent, constant = (d, 0.0, d * corner_arm_z[q]), -f + d * along
        if abs(f) > friction * n:
            sign = math.copysign(friction, f)
            tangent, constant = (0.0, -sign * d, sign * d * lower_corner_arms_x[q]), -sign * pressed
        for row, t, m in (
            (0, 1.0, 0.0),
            (1, 0.0, 1.0),
            (2, mass_over_moment_of_inertia * corner_arm_z[q], -mass_over_moment_of_inertia * lower_corner_arms_x[q]),
        ):
            for p in range(3):
                equation_matrix_workspace[row, p] += half_time_step * (t * tangent[p] + m * normal[p])
            right_side_workspace[row] += half_time_step * (t * constant + m * pressed)
    for p in range(3):
        for row in range(p + 1, 3):
            factor = equation_matrix_workspace[row, p] / equation_matrix_workspace[p, p]
            for column in range(p, 3):
                equation_matrix_workspace[row, column] -= factor * equation_matrix_workspace[p, column]
            right_side_workspace[row] -= factor * right_side_workspace[p]
    w2 = right_side_workspace[2] / equation_matrix_workspace[2, 2]
    w1 = (right_side_workspace[1] - equation_matrix_workspace[1, 2] * w2) / equation_matrix_workspace[1, 1]
    return (
        (right_side_workspace[0] - equation_matrix_workspace[0, 1] * w1 - equation_matrix_workspace[0, 2] * w2)
        / equation_matrix_workspace[0, 0],
        w1,
        w2,
    )


@njit
def peak_rotation_and_steps_by_scalar_loop(  # type: ignore[no-untyped-def]
    uses_centred_scheme,
    ground_acceleration,
    sampling_interval,
    steps_per_sample,
    half_width,
    half_height,
    corner_stiffness_per_mass,
    corner_dashpot_constant_per_mass,
    friction,
):
    """Return the largest absolute rotation (rad) of a block under a horizontal motion, and the number of its steps.

    The scheme is the centred one or Cundall's, in fixed steps of each sampling interval, s. Lengths are in m,
    the ground acceleration is in m/s²; stiffness, 1/s², and dashpot, 1/s, are those of a corner, divided by the mass.
    """
    inertia, dt, peak = (
        3.0 / (half_width * half_width + half_height * half_height),
        sampling_interval / steps_per_sample,
        0.0,
    )
    place, v, a = np.array([0.0, half_height - 0.5 * G / corner_stiffness_per_mass, 0.0]), np.zeros(3), np.zeros(3)
    depth, spring, at = (
        np.full(2, 0.5 * G / corner_stiffness_per_mass),
        np.zeros(2),
        np.array([-half_width, half_width]),
    )
    pull, guess, new, stretch, along = np.array([0.0, -G, 0.0]), np.zeros(3), np.zeros(2), np.zeros(2), np.zeros(2)
    matrix, right, mid = np.zeros((3, 3)), np.zeros(3), np.zeros(3)
    for step in range(ground_acceleration.size * steps_per_sample - steps_per_sample):
        sample, part = step // steps_per_sample, (step % steps_per_sample) / steps_per_sample
        pull[0] = -(
            ground_acceleration[sample] + (ground_acceleration[sample + 1] - ground_acceleration[sample]) * part
        )
        for p in range(3):
            mid[p] = v[p] + 0.5 * dt * a[p] if uses_centred_scheme else v[p]
            place[p] += dt * mid[p] if uses_centred_scheme else 0.0
        c, s = math.cos(place[2]), math.sin(place[2])
        rx, rz = (
            (-half_width * c - half_height * s, half_width * c - half_height * s),
            (half_width * s - half_height * c, -half_width * s - half_height * c),
        )
        for q in range(2):
            new[q], along[q] = -(place[1] + rz[q]), place[0] + rx[q]
            stretch[q] = spring[q] + along[q] - at[q] if depth[q] > 0.0 else 0.0
        if uses_centred_scheme:
            for p in range(3):
                guess[p] = mid[p] + 0.5 * dt * a[p]
            end = _solve_implicit_step(
                matrix,
                right,
                rx,
                rz,
                new,
                stretch,
                guess,
                pull,
                mid,
                0.5 * dt,
                corner_stiffness_per_mass,
                corner_dashpot_constant_per_mass,
                friction,
                inertia,
            )
            for p in range(3):  # update the position with the new velocities
                guess[p] = 0.5 * dt * (end[p] - guess[p])
                place[p] += guess[p]
            for q in range(2):
                new[q] += rx[q] * guess[2] - guess[1]
                along[q] += guess[0] + rz[q] * guess[2]
                stretch[q] += guess[0] + rz[q] * guess[2]
        else:
            end = (v[0], v[1], v[2])
        a[0], a[1], a[2] = pull[0], pull[1], pull[2]
        for q in range(2):
            rate = (new[q] - depth[q]) / dt if not uses_centred_scheme else -(end[1] - rx[q] * end[2])
            slide = (along[q] - at[q]) / dt if not uses_centred_scheme else end[0] + rz[q] * end[2]
            n = (
                max(corner_stiffness_per_mass * new[q] + corner_dashpot_constant_per_mass * rate, 0.0)
                if new[q] > 0.0
                else 0.0
            )
            f = -corner_stiffness_per_mass * stretch[q] - corner_dashpot_constant_per_mass * slide
            if abs(f) > friction * n:
                f = math.copysign(friction * n, f)
                stretch[q] = min(
                    max(stretch[q], -friction * n / corner_stiffness_per_mass), friction * n / corner_stiffness_per_mass
                )
            a[0], a[1], a[2] = a[0] + f, a[1] + n, a[2] + inertia * (rz[q] * f - rx[q] * n)
            depth[q], spring[q], at[q] = new[q], stretch[q], along[q]
        for p in range(3):
            v[p] = mid[p] + 0.5 * dt * a[p] if uses_centred_scheme else v[p] + dt * a[p]
            if not uses_centred_scheme:
                place[p] += dt * v[p]
        peak = max(peak, abs(place[2]))
    return peak, (ground_acceleration.size - 1) * steps_per_sample
