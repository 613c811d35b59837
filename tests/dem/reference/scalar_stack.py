"""Independent reference for stacks: one block on another by the equations of docs/method.md, in short fixed steps.

It shares no code with the package's kernels or with the reference for one block. Both blocks may rotate, so contacts
are computed in the frame of the supporting block. Every force is explicit, and the step is a fraction of the shortest
contact time scale.
"""

import math

import numpy as np
from numba import njit

from overturning.arrays import FloatArray
from overturning.kernel_cache import cache_compiled_kernel

G = 9.80665


@cache_compiled_kernel
@njit
def integrate_stack_of_two_blocks(
    along, interval, sizes, springs, dashes, mu, step_over_contact_time_scale, samples_after_record
):
    """Return poses and velocities (x, z, θ, vx, vz, vw) of both blocks at each sample, shape (samples, 2, 6).

    `along`: acceleration of the ground, m/s², every `interval` s. `sizes`: widths and heights, m. `springs`, `dashes`:
    normal and tangential spring (m²/s²) and dashpot (m²/s) of a corner under each block, with the area as its mass.
    """
    mass = np.array([sizes[0, 0] * sizes[0, 1], sizes[1, 0] * sizes[1, 1]])
    inertia = np.array([mass[i] * (sizes[i, 0] ** 2 + sizes[i, 1] ** 2) / 12.0 for i in range(2)])
    fastest = 0.0
    for i in range(2):
        fastest = max(fastest, math.sqrt(8.0 * springs[i] / mass[1]), 8.0 * dashes[i] / mass[1])
    steps = math.ceil(interval * fastest / step_over_contact_time_scale)
    dt = interval / steps
    now = np.zeros((2, 6))
    sunk = 0.5 * G * (mass[0] + mass[1]) / springs[0]
    now[0, 1] = 0.5 * sizes[0, 1] - sunk
    now[1, 1] = sizes[0, 1] + 0.5 * sizes[1, 1] - sunk - 0.5 * G * mass[1] / springs[1]
    rates, ends = np.zeros((2, 3)), np.zeros((2, 6))
    place, stretch, touched = np.zeros((2, 2)), np.zeros((2, 2)), np.zeros((2, 2), np.bool_)
    path = np.zeros((along.size + samples_after_record, 2, 6))
    for sample in range(along.size + samples_after_record):
        path[sample] = now
        first = along[sample] if sample < along.size else 0.0
        second = along[sample + 1] if sample + 1 < along.size else 0.0
        for step in range(steps):
            now[:, 3:] += 0.5 * dt * rates
            now[:, :3] += dt * now[:, 3:]
            ends[:] = now
            ends[:, 3:] += 0.5 * dt * rates
            rates[:, 0] = -(first + (second - first) * (step + 1.0) / steps)
            rates[:, 1], rates[:, 2] = -G, 0.0
            for i in range(2):
                c, s = math.cos(ends[i, 2]), math.sin(ends[i, 2])
                for side in range(2):
                    across = (side - 0.5) * sizes[i, 0]
                    rx, rz = across * c - 0.5 * sizes[i, 1] * s, -across * s - 0.5 * sizes[i, 1] * c
                    x, z = ends[i, 0] + rx, ends[i, 1] + rz
                    vx, vz = ends[i, 3] + rz * ends[i, 5], ends[i, 4] - rx * ends[i, 5]
                    p, q, fx, fz = 1.0, 0.0, 0.0, 0.0  # cosine and sine of the supporting block
                    if i == 1:
                        p, q = math.cos(ends[0, 2]), math.sin(ends[0, 2])
                        fx, fz = x - ends[0, 0], z - ends[0, 1]
                        vx, vz = vx - ends[0, 3] - fz * ends[0, 5], vz - ends[0, 4] + fx * ends[0, 5]
                    away = (fx if i == 1 else x, fz if i == 1 else z)
                    here = p * away[0] - q * away[1]
                    depth = (0.5 * sizes[0, 1] if i == 1 else 0.0) - q * away[0] - p * away[1]
                    if depth > 0.0:
                        stretch[i, side] = stretch[i, side] + here - place[i, side] if touched[i, side] else 0.0
                        n = max(springs[i] * depth - dashes[i] * (q * vx + p * vz), 0.0)
                        f = -springs[i] * stretch[i, side] - dashes[i] * (p * vx - q * vz)
                        if abs(f) > mu * n:
                            f = math.copysign(mu * n, f)
                            most = mu * n / springs[i]
                            stretch[i, side] = min(max(stretch[i, side], -most), most)
                        gx, gz = p * f + q * n, p * n - q * f
                        rates[i, 0] += gx / mass[i]
                        rates[i, 1] += gz / mass[i]
                        rates[i, 2] += (rz * gx - rx * gz) / inertia[i]
                        if i == 1:
                            rates[0, 0] -= gx / mass[0]
                            rates[0, 1] -= gz / mass[0]
                            rates[0, 2] -= (fz * gx - fx * gz) / inertia[0]
                    touched[i, side], place[i, side] = depth > 0.0, here
            now[:, 3:] += 0.5 * dt * rates
    return path


def trajectory_of_two_stacked_blocks(
    along: FloatArray, interval: float, sizes: FloatArray, penetration: float, mu: float, samples_after_record: int
) -> FloatArray:
    """Return the path of two blocks by `integrate_stack_of_two_blocks`, with a damping ratio of 1.

    `penetration`: static penetration over width. `samples_after_record`: number of samples after the record.
    """
    mass = sizes.prod(axis=1)
    carried = np.array([mass.sum(), mass[1]])
    springs = G * carried / (2.0 * penetration * sizes[:, 0])
    return integrate_stack_of_two_blocks(
        along, interval, sizes, springs, 2.0 * np.sqrt(0.5 * springs * carried), mu, 0.04, samples_after_record
    )
