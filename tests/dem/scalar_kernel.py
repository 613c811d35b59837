"""The second opinion: the same mechanics for one block, a plain loop written from the equations of docs/method.md.

It shares no code with the lane-parallel kernel: angles through sin and cos, contacts through ifs, a general solution
of the three equations for the velocities by elimination; but the lengths of fine steps are shared. It knows no corners that jam (μ from 4/3 on). `frame="inertial"` shakes the base instead of the frame.
"""

import math

import numpy as np
from numba import njit

from overturning.dem.columns import EARLY_TICKS, LATE_STEP, MOST_TRIES, TAIL_STEP, TICKS

G = 9.80665


@njit
def _corners(z, angle, b, h):
    c, s = math.cos(angle), math.sin(angle)
    rx = (-b * c - h * s, b * c - h * s)
    rz = (b * s - h * c, -b * s - h * c)
    return rx, rz, (-(z + rz[0]), -(z + rz[1]))


@njit
def run(centred, motion, up, interval, steps, b, h, k, ks, dash, mu, window, tail, tilt, first, inertial):
    """Side, largest |θ|, largest slip of the base's midpoint, block steps."""
    inertia, alpha = 3.0 / (b * b + h * h), math.atan(b / h)
    angle, x, z = tilt, 0.0, 0.0
    if tilt == 0.0:
        z = h - 0.5 * G / k
    else:
        z = b * abs(math.sin(tilt)) + h * math.cos(tilt) - G / k
        x = math.copysign(b * (1.0 - math.cos(tilt)), tilt) + h * math.sin(tilt)
    v, a, spring = np.zeros(3), np.zeros(3), np.zeros(2)
    rx, rz, old = _corners(z, angle, b, h)
    oldx = (x + rx[0], x + rx[1])
    a[1] = k * (max(old[0], 0.0) + max(old[1], 0.0)) - G
    a[2] = -inertia * k * (rx[0] * max(old[0], 0.0) + rx[1] * max(old[1], 0.0))
    base_x, base_v = 0.0, 0.0  # of the base, where it is what moves
    tick, sample, fine, count, tries = 0, first, (window if centred else 0), 0, 0
    peak, slip = abs(tilt), 0.0
    barrier = G * (math.sqrt(b * b + h * h) - h)
    limit = motion.size + math.ceil(20.0 * math.sqrt(math.sqrt(b * b + h * h) * 4 / 3 / G) / interval)
    un, ut, stretch, slid, pressed = np.zeros(2), np.zeros(2), np.zeros(2), np.zeros(2), np.zeros(2)
    slips = np.zeros(2, np.bool_)
    vh, drift, pull, guess = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
    matrix, right_side, jump = np.zeros((3, 3)), np.zeros(3), np.zeros(3)
    while sample < limit:
        count += 1
        early, late = fine > window - EARLY_TICKS, fine > tail
        length = 1 if early else LATE_STEP if late else TAIL_STEP if fine > 0 else TICKS
        if not centred:
            length = TICKS
        dt = interval / steps * length / TICKS
        for q in range(3):
            # Cundall's positions of this step are those that the last one left.
            vh[q] = v[q] + 0.5 * dt * a[q] if centred else v[q]
            drift[q] = dt * vh[q] if centred else 0.0
        here, there = tick + length, TICKS * steps
        if not centred:
            here = tick
        i, part = sample + here // there, (here % there) / there
        left = motion[i] if i < motion.size else 0.0
        right = motion[i + 1] if i + 1 < motion.size else 0.0
        ground = left + (right - left) * part
        lift = 0.0
        if up.size:
            left = up[i] if i < up.size else 0.0
            right = up[i + 1] if i + 1 < up.size else 0.0
            lift = left + (right - left) * part
        nx, nz, turned = x + drift[0], z + drift[1], angle + drift[2]
        new_base_x, new_base_v = base_x, base_v
        if inertial and centred:
            # The base follows the same rule as the block, the trapezoidal one.
            last = motion[min(sample, motion.size - 1)] if sample < motion.size else 0.0
            following = motion[sample + 1] if sample + 1 < motion.size else 0.0
            old_ground = last + (following - last) * tick / there
            new_base_x = base_x + dt * (base_v + 0.25 * dt * (old_ground + ground))
            new_base_v = base_v + 0.5 * dt * (old_ground + ground)
        rx, rz, u = _corners(nz, turned, b, h)
        cx = (nx + rx[0], nx + rx[1])
        inside, was = (u[0] > 0.0, u[1] > 0.0), (old[0] > 0.0, old[1] > 0.0)
        for q in range(2):
            stretch[q] = spring[q] + (cx[q] - oldx[q]) - (new_base_x - base_x) if was[q] else 0.0
        pull[0], pull[1] = (0.0 if inertial else -ground), -(G + lift)
        if centred:
            for q in range(3):
                matrix[q, 0] = matrix[q, 1] = matrix[q, 2] = 0.0
                matrix[q, q] = 1.0
                right_side[q], guess[q] = vh[q] + 0.5 * dt * pull[q], vh[q] + 0.5 * dt * a[q]
            for q in range(2):
                # Foreseen velocities of the corner, and its forces with them.
                rise, along = guess[1] - rx[q] * guess[2], guess[0] - new_base_v + rz[q] * guess[2]
                n, f = k * u[q] - dash * rise, ks * stretch[q] + dash * along
                if late:
                    on, slides, sign = inside[q] and n > 0.0, abs(f) > mu * n, math.copysign(mu, f)
                else:
                    on, slides, sign = (inside[q] and n > 0.0) or pressed[q] > 0.0, slid[q] != 0.0, slid[q]
                if not on:
                    continue
                # Spring and dashpot at the end of the step: force = constant − rows · v, half a step ahead of the
                # foreseen place for what the velocity differs from the foreseen one.
                dn, dt_ = dash + 0.5 * dt * k, dash + 0.5 * dt * ks
                normal_row, most = (0.0, dn, -dn * rx[q]), n + dn * rise
                if slides:
                    tangent_row, constant = (0.0, -sign * dn, sign * dn * rx[q]), -sign * most
                else:
                    tangent_row, constant = (dt_, 0.0, dt_ * rz[q]), -f + dt_ * (along + new_base_v)
                for row, arm_t, arm_n in ((0, 1.0, 0.0), (1, 0.0, 1.0), (2, inertia * rz[q], -inertia * rx[q])):
                    for p in range(3):
                        matrix[row, p] += 0.5 * dt * (arm_t * tangent_row[p] + arm_n * normal_row[p])
                    right_side[row] += 0.5 * dt * (arm_t * constant + arm_n * most)
            for p in range(3):
                for row in range(p + 1, 3):
                    factor = matrix[row, p] / matrix[p, p]
                    for column in range(p, 3):
                        matrix[row, column] -= factor * matrix[p, column]
                    right_side[row] -= factor * right_side[p]
            w2 = right_side[2] / matrix[2, 2]
            w1 = (right_side[1] - matrix[1, 2] * w2) / matrix[1, 1]
            w0 = (right_side[0] - matrix[0, 1] * w1 - matrix[0, 2] * w2) / matrix[0, 0]
            changed = False
            moved = (0.5 * dt * (w0 - guess[0]), 0.5 * dt * (w1 - guess[1]), 0.5 * dt * (w2 - guess[2]))
            nx, nz, turned = nx + moved[0], nz + moved[1], turned + moved[2]
            met = u
            for q in range(2):
                stretch[q] += moved[0] + rz[q] * moved[2]
                un[q], ut[q] = w1 - rx[q] * w2, w0 - new_base_v + rz[q] * w2
            u = (u[0] - moved[1] + rx[0] * moved[2], u[1] - moved[1] + rx[1] * moved[2])
            cx = (cx[0] + moved[0] + rz[0] * moved[2], cx[1] + moved[0] + rz[1] * moved[2])
            inside = (u[0] > 0.0, u[1] > 0.0)
            for q in range(2):
                changed = changed or inside[q] != was[q] or (met[q] > 0.0 and not was[q])
            again, wrong, back = changed and not early, False, False
            for q in range(2):
                n, f = k * u[q] - dash * un[q] if inside[q] else 0.0, ks * stretch[q] + dash * ut[q]
                slips[q] = abs(f) > mu * max(n, 0.0)
                if mu * n > 0.0 and not late:
                    wrong = wrong or (math.copysign(mu, f) if slips[q] else 0.0) != slid[q]
                    back = back or slid[q] * ut[q] < 0.0
            retry = not again and not back and wrong and tries < MOST_TRIES
            for q in range(2):
                n, f = k * u[q] - dash * un[q] if inside[q] else 0.0, ks * stretch[q] + dash * ut[q]
                if mu * n > 0.0 or not retry:
                    slid[q] = math.copysign(mu, f) if slips[q] else 0.0
            tries = tries + 1 if retry else 0
            if again:
                fine = window if late else window - EARLY_TICKS if fine > 0 else tail
            elif (wrong or back) and not retry:
                fine = tail + TAIL_STEP if fine > 0 else TICKS
            if again or wrong or back:
                continue
        else:
            for q in range(2):
                un[q], ut[q] = -(u[q] - old[q]) / dt, (cx[q] - oldx[q]) / dt
        for q in range(3):
            a[q], jump[q] = pull[q], 0.0
        for q in range(2):
            n = max(k * u[q] - dash * un[q], 0.0) if inside[q] else 0.0
            f = -ks * stretch[q] - dash * ut[q]
            spring[q] = stretch[q]
            if abs(f) > mu * n:
                f, most = math.copysign(mu * n, f), mu * n / ks if ks > 0 else 0.0
                spring[q] = min(max(stretch[q], -most), most)
            pressed[q] = n
            kick = (f, n, inertia * (rz[q] * f - rx[q] * n))
            new = (u[q] / (u[q] - old[q]) - 0.5) * dt if centred and inside[q] and not was[q] else 0.0
            for p in range(3):
                a[p] += kick[p]
                jump[p] += new * kick[p]
        for q in range(3):
            v[q] = vh[q] + (0.5 * dt * a[q] + jump[q] if centred else dt * a[q])
        if centred:
            x, z, angle = nx, nz, turned
        else:
            x, z, angle = x + dt * v[0], z + dt * v[1], angle + dt * v[2]
        base_x, base_v = new_base_x, new_base_v
        old, oldx = u, cx
        fine = window if centred and changed else fine - length
        tick += length
        peak = max(peak, abs(angle))
        slip = max(slip, abs(x - base_x - h * math.sin(angle)))
        if tick >= there:
            tick, sample = tick - there, sample + 1
            if math.cos(angle) <= 0.0:
                return (1 if angle > 0 else -1), peak / alpha, slip, count
            vx = v[0] - base_v
            energy = 0.5 * (vx * vx + v[1] * v[1] + v[2] * v[2] / inertia) + G * (z - h)
            if sample >= motion.size and energy < 0.99 * barrier and abs(angle) < alpha and abs(vx) < 1e-4:
                return 0, peak / alpha, slip, count
    return 0, peak / alpha, slip, count
