"""Independent reference for one block: the equations of docs/method.md, in short steps of fixed length.

It shares no code, constants or step control with the package's kernels. Angles use sin and cos, contacts are if
statements, every force is explicit, and the step is 1/25 of the shortest contact time scale, so that no equations are
solved. With `inertial` the base moves in an inertial frame; otherwise the frame moves with the base.
"""

import math

import numpy as np
from numba import njit

from overturning.kernel_cache import cache_compiled_kernel
from overturning.motion.motion import Motion

G = 9.80665
STEP_OVER_CONTACT_TIME_SCALE = 0.04
"""Step over the shortest contact time scale: that of a spring or a dashpot on the effective mass at a corner."""


@cache_compiled_kernel
@njit
def integrate_block(along, up, interval, b, h, k, ks, dash, mu, tilt, step_over_contact_time_scale, inertial):
    """Return the side to which a block falls, largest |θ|/α, largest slip of the base's midpoint (m), step count.

    `along`, `up`: acceleration of the base along the azimuth and upwards, m/s², every `interval` s. `b`, `h`: half
    width and half height, m. `k`, `ks`: normal and tangential spring of a corner per mass, 1/s². `dash`: dashpot of a
    corner per mass, 1/s.
    """
    inertia, alpha, radius = 3.0 / (b * b + h * h), math.atan(b / h), math.sqrt(b * b + h * h)
    # The effective mass at a corner is at least a quarter of the mass.
    fastest = max(math.sqrt(4.0 * max(k, ks)), 4.0 * dash)
    steps = math.ceil(interval * fastest / step_over_contact_time_scale)
    dt = interval / steps
    weight_depth = 0.5 * G / k if tilt == 0.0 else G / k
    angle, z = tilt, b * abs(math.sin(tilt)) + h * math.cos(tilt) - weight_depth
    x = math.copysign(b * (1.0 - math.cos(tilt)), tilt) + h * math.sin(tilt)
    vx, vz, vw, ax, az, aw = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    base_x, base_v, old_ground = 0.0, 0.0, along[0]
    place, stretch, touched = np.zeros(2), np.zeros(2), np.zeros(2, np.bool_)
    peak, slip, count = abs(tilt), 0.0, 0
    after = math.ceil(20.0 * math.sqrt(4.0 * radius / (3.0 * G)) / interval)
    for sample in range(along.size + after):
        for step in range(steps):
            count += 1
            # Half of the velocity change, the whole displacement, and the velocity predicted for the end of the step.
            vx, vz, vw = vx + 0.5 * dt * ax, vz + 0.5 * dt * az, vw + 0.5 * dt * aw
            x, z, angle = x + dt * vx, z + dt * vz, angle + dt * vw
            ex, ez, ew = vx + 0.5 * dt * ax, vz + 0.5 * dt * az, vw + 0.5 * dt * aw
            share, ground, lift = (step + 1.0) / steps, 0.0, 0.0
            if sample < along.size:
                following = along[sample + 1] if sample + 1 < along.size else 0.0
                ground = along[sample] + (following - along[sample]) * share
            if sample < up.size:
                following = up[sample + 1] if sample + 1 < up.size else 0.0
                lift = up[sample] + (following - up[sample]) * share
            if inertial:
                base_x += dt * (base_v + 0.25 * dt * (old_ground + ground))
                base_v += 0.5 * dt * (old_ground + ground)
                old_ground = ground
            ax, az, aw = (0.0 if inertial else -ground), -(G + lift), 0.0
            for side in range(2):
                corner = b if side == 1 else -b
                rx = corner * math.cos(angle) - h * math.sin(angle)
                rz = -corner * math.sin(angle) - h * math.cos(angle)
                u = -(z + rz)
                here = x + rx - base_x
                if u > 0.0:
                    stretch[side] = stretch[side] + (here - place[side]) if touched[side] else 0.0
                    n = max(k * u - dash * (ez - rx * ew), 0.0)
                    f = -ks * stretch[side] - dash * (ex + rz * ew - base_v)
                    if abs(f) > mu * n:
                        f = math.copysign(mu * n, f)
                        most = mu * n / ks
                        stretch[side] = min(max(stretch[side], -most), most)
                    ax, az, aw = ax + f, az + n, aw + inertia * (rz * f - rx * n)
                touched[side], place[side] = u > 0.0, here
            vx, vz, vw = vx + 0.5 * dt * ax, vz + 0.5 * dt * az, vw + 0.5 * dt * aw
            peak = max(peak, abs(angle))
            slip = max(slip, abs(x - base_x - h * math.sin(angle)))
        if math.cos(angle) <= 0.0:
            return (1 if angle > 0 else -1), peak / alpha, slip, count
        rate = vx - base_v
        energy = 0.5 * (rate * rate + vz * vz + vw * vw / inertia) + G * (z - h)
        if sample >= along.size and energy < 1e-3 * G * (radius - h) and abs(rate) < 1e-4:
            break
    return 0, peak / alpha, slip, count


def integrate_block_cases(
    motion: Motion,
    cases: list[tuple[float, float, float, float]],
    *,
    penetration: float = 2e-5,
    stiffness: float | None = None,
    damping_ratio: float = 1.0,
    stiffness_ratio: float = 1.0,
    tilt: float = 0.0,
    fraction: float = STEP_OVER_CONTACT_TIME_SCALE,
    inertial: bool = False,
) -> np.ndarray:
    """Return fall side, peak rotation over α, peak slip (m) and number of steps of each case, shape (n, 4).

    A case is azimuth (degrees), height (m), B/H and friction. The contact is given by the static penetration over width
    δ/B (or by K_n, N/m, for a block of 2650 kg/m³), the damping ratio ξ and K_s/K_n. A corner has, per mass m of the
    block, the normal spring K_n/m = g/2δ and the dashpot 2 ξ √(K_n/2m).
    """
    out = np.zeros((len(cases), 4))
    up = np.zeros(0) if motion.up is None else motion.up
    for row, (azimuth, height, ratio, friction) in enumerate(cases):
        along = motion.north * np.cos(np.radians(azimuth)) + motion.east * np.sin(np.radians(azimuth))
        k = G / (2.0 * penetration * ratio * height)
        if stiffness is not None:
            k = stiffness / (2650.0 * ratio * height * height)
        out[row] = integrate_block(
            along, up, motion.sampling_interval, 0.5 * ratio * height, 0.5 * height, k, stiffness_ratio * k,
            2.0 * damping_ratio * np.sqrt(0.5 * k), friction, tilt, fraction, inertial,
        )  # fmt: skip
    return out
