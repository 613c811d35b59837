"""Cundall's scheme: central differences, spring at the whole step, dashpot at the half step before it (docs/method.md)."""

import math
from typing import Any

from numba import njit

# isort: off
from overturning.dem.columns import (
    ALPHA, ANGLE, AW, AX, AZ, BASE, COMPLIANCE, COS, DASHPOT, FRICTION, HALF_HEIGHT, HALF_WIDTH, INERTIA,
    LAST_UPRIGHT, LOST, OLD_UL, OLD_UR, OLD_XL, OLD_XR, OPTIONS, PEAK_ANGLE, PEAK_DEPTH, PEAK_SLIP, SIN, SLOPE,
    SPRING_L, SPRING_R, STEP, STIFFNESS, TANGENTIAL, TICK, TICKS, UP_BASE, UP_SLOPE, VW, VX, VZ, WORK, X, Z,
)  # fmt: skip
# isort: on


@njit(**OPTIONS)
def advance_cundall(state: Any, columns: int, steps: int, gravity: float, vertical: Any) -> None:
    """Take the steps of a sample.

    Parameters
    ----------
    state : ndarray
        The columns (`overturning.dem.columns`).
    columns : int
        How many of them to advance.
    steps : int
        Steps to take.
    gravity : float
        m/s².
    vertical : ndarray or None
        None where the base does not move up and down: what that takes is then not compiled.
    """
    for _ in range(steps):
        for j in range(columns):
            b, h, dt = state[HALF_WIDTH + j], state[HALF_HEIGHT + j], state[STEP + j] * TICKS
            k, ks, mu = state[STIFFNESS + j], state[TANGENTIAL + j], state[FRICTION + j]
            x, z, c, s = state[X + j], state[Z + j], state[COS + j], state[SIN + j]
            vx, vz, vw = state[VX + j], state[VZ + j], state[VW + j]
            tick = state[TICK + j]
            push = state[BASE + j] + state[SLOPE + j] * tick
            # Corners from the centre; (x, z) of a point of the block turned clockwise.
            rxl, rzl = -(b * c) - h * s, b * s - h * c
            rxr, rzr = b * c - h * s, -(b * s) - h * c
            xl, ul, xr, ur = x + rxl, -(z + rzl), x + rxr, -(z + rzr)
            dxl, dul = xl - state[OLD_XL + j], ul - state[OLD_UL + j]
            dxr, dur = xr - state[OLD_XR + j], ur - state[OLD_UR + j]
            was_l, was_r = state[OLD_UL + j] > 0.0, state[OLD_UR + j] > 0.0
            hdt = state[DASHPOT + j] / dt
            # Normal force: spring and dashpot while the corner is in, never tension.
            nl, nr = k * ul + hdt * dul, k * ur + hdt * dur
            nl = nl if (ul > 0.0) & (nl > 0.0) else 0.0
            nr = nr if (ur > 0.0) & (nr > 0.0) else 0.0
            # Tangential force with slider; a new contact starts with an unstretched spring.
            tl = state[SPRING_L + j] + dxl if was_l else 0.0
            tr = state[SPRING_R + j] + dxr if was_r else 0.0
            ml, mr = mu * nl, mu * nr
            fl, fr = -(ks * tl) - hdt * dxl, -(ks * tr) - hdt * dxr
            slips_l, slips_r = abs(fl) > ml, abs(fr) > mr
            fl, fr = (math.copysign(ml, fl) if slips_l else fl), (math.copysign(mr, fr) if slips_r else fr)
            # A corner that slips has its spring shortened to what friction holds.
            el, er = ml * state[COMPLIANCE + j], mr * state[COMPLIANCE + j]
            sl, sr = math.copysign(el, tl), math.copysign(er, tr)
            sl, sr = (sl if slips_l & (abs(tl) > el) else tl), (sr if slips_r & (abs(tr) > er) else tr)
            # Accelerations in the frame of the base; left and right corner as one pair.
            ax, az = (fl + fr) + push, (nl + nr) - gravity
            if vertical is not None:
                lift = state[UP_BASE + j] + state[UP_SLOPE + j] * tick
                az = (nl + nr) - (gravity + lift)
            aw = state[INERTIA + j] * ((rzl * fl - rxl * nl) + (rzr * fr - rxr * nr))
            # Velocities at the whole step, for the books only.
            half = 0.5 * dt
            cx, cz, cw = vx + half * ax, vz + half * az, vw + half * aw
            pl, pr = ul if ul > 0.0 else 0.0, ur if ur > 0.0 else 0.0
            ql, qr = (state[OLD_UL + j] if was_l else 0.0), (state[OLD_UR + j] if was_r else 0.0)
            ql, qr = (0.0 if ul > 0.0 else ql), (0.0 if ur > 0.0 else qr)
            gl, gr = state[SPRING_L + j], state[SPRING_R + j]
            lost_l = (nl - k * pl) * (cz - rxl * cw) + (fl + ks * sl) * (cx + rzl * cw)
            lost_r = (nr - k * pr) * (cz - rxr * cw) + (fr + ks * sr) * (cx + rzr * cw)
            # What springs let go: the normal ones that open, the tangential ones that are shortened, by their mean force.
            let_go = 0.5 * (k * (ql * ql + qr * qr) + ks * ((gl + sl) * (tl - sl) + (gr + sr) * (tr - sr)))
            power = push * cx
            if vertical is not None:
                power = push * cx - lift * cz
            state[WORK + j] = state[WORK + j] + dt * power
            state[LOST + j] = state[LOST + j] + (let_go - dt * (lost_l + lost_r))
            vx, vz, vw = vx + dt * ax, vz + dt * az, vw + dt * aw
            # Turn (c, s) by the small angle of the step.
            turn = dt * vw
            square = turn * turn
            sine = turn * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0)))
            versine = square * (0.5 - square * (1.0 / 24.0))
            angle = state[ANGLE + j] + turn
            state[COS + j] = c - (c * versine + s * sine)
            state[SIN + j] = s - (s * versine - c * sine)
            size = abs(angle)
            slip = abs((x + dt * vx) - h * state[SIN + j])
            depth = ul if ul > ur else ur
            state[PEAK_ANGLE + j] = size if size > state[PEAK_ANGLE + j] else state[PEAK_ANGLE + j]
            state[PEAK_SLIP + j] = slip if slip > state[PEAK_SLIP + j] else state[PEAK_SLIP + j]
            state[PEAK_DEPTH + j] = depth if depth > state[PEAK_DEPTH + j] else state[PEAK_DEPTH + j]
            state[LAST_UPRIGHT + j] = tick + 1.0 * TICKS if size < state[ALPHA + j] else state[LAST_UPRIGHT + j]
            state[X + j], state[Z + j], state[ANGLE + j] = x + dt * vx, z + dt * vz, angle
            state[VX + j], state[VZ + j], state[VW + j] = vx, vz, vw
            state[AX + j], state[AZ + j], state[AW + j] = ax, az, aw
            state[SPRING_L + j], state[SPRING_R + j] = sl, sr
            state[OLD_XL + j], state[OLD_UL + j] = xl, ul
            state[OLD_XR + j], state[OLD_UR + j] = xr, ur
            state[TICK + j] = tick + 1.0 * TICKS
