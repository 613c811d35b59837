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
def _implicit(  # type: ignore[no-untyped-def]
    matrix, right, rx, rz, depth, stretch, guess, pull, mid, half, stiff, dashpot, mu, inertia
):
    """Return the velocities at the end of a centred step: three linear equations, implicit springs and dashpots."""
    for p in range(3):
        matrix[p, 0] = matrix[p, 1] = matrix[p, 2] = 0.0
        matrix[p, p], right[p] = 1.0, mid[p] + half * pull[p]
    for q in range(2):
        rise, along = guess[1] - rx[q] * guess[2], guess[0] + rz[q] * guess[2]
        n, f = stiff * depth[q] - dashpot * rise, stiff * stretch[q] + dashpot * along
        if depth[q] <= 0.0 or n <= 0.0:
            continue
        d = dashpot + half * stiff
        normal, pressed = (0.0, d, -d * rx[q]), n + d * rise
        tangent, constant = (d, 0.0, d * rz[q]), -f + d * along
        if abs(f) > mu * n:
            sign = math.copysign(mu, f)
            tangent, constant = (0.0, -sign * d, sign * d * rx[q]), -sign * pressed
        for row, t, m in ((0, 1.0, 0.0), (1, 0.0, 1.0), (2, inertia * rz[q], -inertia * rx[q])):
            for p in range(3):
                matrix[row, p] += half * (t * tangent[p] + m * normal[p])
            right[row] += half * (t * constant + m * pressed)
    for p in range(3):
        for row in range(p + 1, 3):
            factor = matrix[row, p] / matrix[p, p]
            for column in range(p, 3):
                matrix[row, column] -= factor * matrix[p, column]
            right[row] -= factor * right[p]
    w2 = right[2] / matrix[2, 2]
    w1 = (right[1] - matrix[1, 2] * w2) / matrix[1, 1]
    return (right[0] - matrix[0, 1] * w1 - matrix[0, 2] * w2) / matrix[0, 0], w1, w2


@njit
def run(centred, motion, interval, steps, b, h, stiff, dashpot, mu):  # type: ignore[no-untyped-def]
    """Return the largest rotation (rad) of a block under a motion, and the number of block steps.

    The scheme is the centred one or Cundall's, in fixed steps of each sampling interval, s. The block has half width b
    and half height h, m; K/m, 1/s², and h/m, 1/s, are those of a corner; the motion is the ground's acceleration,
    m/s².
    """
    inertia, dt, peak = 3.0 / (b * b + h * h), interval / steps, 0.0
    place, v, a = np.array([0.0, h - 0.5 * G / stiff, 0.0]), np.zeros(3), np.zeros(3)
    depth, spring, at = np.full(2, 0.5 * G / stiff), np.zeros(2), np.array([-b, b])
    pull, guess, new, stretch, along = np.array([0.0, -G, 0.0]), np.zeros(3), np.zeros(2), np.zeros(2), np.zeros(2)
    matrix, right, mid = np.zeros((3, 3)), np.zeros(3), np.zeros(3)
    for step in range(motion.size * steps - steps):
        sample, part = step // steps, (step % steps) / steps
        pull[0] = -(motion[sample] + (motion[sample + 1] - motion[sample]) * part)
        for p in range(3):
            mid[p] = v[p] + 0.5 * dt * a[p] if centred else v[p]
            place[p] += dt * mid[p] if centred else 0.0
        c, s = math.cos(place[2]), math.sin(place[2])
        rx, rz = (-b * c - h * s, b * c - h * s), (b * s - h * c, -b * s - h * c)
        for q in range(2):
            new[q], along[q] = -(place[1] + rz[q]), place[0] + rx[q]
            stretch[q] = spring[q] + along[q] - at[q] if depth[q] > 0.0 else 0.0
        if centred:
            for p in range(3):
                guess[p] = mid[p] + 0.5 * dt * a[p]
            end = _implicit(
                matrix, right, rx, rz, new, stretch, guess, pull, mid, 0.5 * dt, stiff, dashpot, mu, inertia
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
            rate = (new[q] - depth[q]) / dt if not centred else -(end[1] - rx[q] * end[2])
            slide = (along[q] - at[q]) / dt if not centred else end[0] + rz[q] * end[2]
            n = max(stiff * new[q] + dashpot * rate, 0.0) if new[q] > 0.0 else 0.0
            f = -stiff * stretch[q] - dashpot * slide
            if abs(f) > mu * n:
                f = math.copysign(mu * n, f)
                stretch[q] = min(max(stretch[q], -mu * n / stiff), mu * n / stiff)
            a[0], a[1], a[2] = a[0] + f, a[1] + n, a[2] + inertia * (rz[q] * f - rx[q] * n)
            depth[q], spring[q], at[q] = new[q], stretch[q], along[q]
        for p in range(3):
            v[p] = mid[p] + 0.5 * dt * a[p] if centred else v[p] + dt * a[p]
            if not centred:
                place[p] += dt * v[p]
        peak = max(peak, abs(place[2]))
    return peak, (motion.size - 1) * steps
