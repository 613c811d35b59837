"""The centred scheme: the trapezoidal rule with springs and dashpots taken at the end of the step (docs/method.md).

A step is three loops over the columns, for speed alone: the chain of dependent operations of a whole step is longer than
what a processor looks ahead, that of a third of it is not.

Signs: a corner's penetration u and its upward velocity u̇_z give n = K u − h u̇_z upwards, its stretch t and velocity u̇_x
along s give f = K_s t + h u̇_x against s. Left and right corner are summed as one pair, which makes the mirrored case exact.
"""

import math
from typing import Any, Final

from numba import njit

from overturning.dem.commit import commit

# isort: off
from overturning.dem.columns import (
    ANGLE, ARM_L, ARM_R, AW, AX, AZ, BASE, BEND, COS, DASHPOT, DROP_L, DROP_R, EARLY_TICKS, END_VW, END_VX, END_VZ,
    END_XL, END_XR, END_ZL, END_ZR, FINE, FRICTION, HALF, HALF_HEIGHT, HALF_WIDTH, INERTIA, LATE_STEP, LIFT,
    MID_VW, MID_VX, MID_VZ, NEW_ANGLE, NEW_COS, NEW_SIN, NEW_SL, NEW_SR, NEW_UL, NEW_UR, NEW_X, NEW_Z, OLD_UL,
    OLD_UR, OLD_XL, OLD_XR, OPTIONS, PRESSED_L, PRESSED_R, PUSH, SIN, SLID_L, SLID_R, SLOPE, SPRING_L, SPRING_R,
    STEP, STIFFNESS, TAIL_STEP, TAIL_TICKS, TANGENTIAL, TICK, TICKS, UP_BASE, UP_BEND, UP_SLOPE, VW, VX, VZ, WINDOW,
    X, Z,
)  # fmt: skip
# isort: on

LEAST_FREEDOM: Final = 0.25
"""A sliding corner jams where less than this share of a normal force's effect on a free particle is left."""


@njit(**OPTIONS)
def foresee(state: Any, columns: int, ticks: float, vertical: Any, rough: Any) -> None:
    """Drift with the last acceleration: position and corners, and the velocities as they would be without a change."""
    for j in range(columns):
        b, h, c, s = state[HALF_WIDTH + j], state[HALF_HEIGHT + j], state[COS + j], state[SIN + j]
        fine, window, old_tick, step = state[FINE + j], state[WINDOW + j], state[TICK + j], state[STEP + j]
        tail_ticks = state[TAIL_TICKS + j]
        oax, oaz, oaw = state[AX + j], state[AZ + j], state[AW + j]
        ovx, ovz, ovw = state[VX + j], state[VZ + j], state[VW + j]
        x, z, old_angle = state[X + j], state[Z + j], state[ANGLE + j]
        base, slope, bend = state[BASE + j], state[SLOPE + j], state[BEND + j]
        gl, gr, oxl, oxr = state[SPRING_L + j], state[SPRING_R + j], state[OLD_XL + j], state[OLD_XR + j]
        oul, our = state[OLD_UL + j], state[OLD_UR + j]
        length = 1.0 * TAIL_STEP if fine > 0.0 else 1.0 * TICKS
        length = 1.0 * LATE_STEP if fine > tail_ticks else length
        length = 1.0 if fine > window - EARLY_TICKS else length
        dt = step * length
        tick = old_tick + length
        half = 0.5 * dt
        kx, kz, kw = half * oax, half * oaz, half * oaw
        vx, vz, vw = ovx + kx, ovz + kz, ovw + kw
        # Turn (c, s) by the small angle of the step.
        turn = dt * vw
        square = turn * turn
        sine = turn * (1.0 - square * (1.0 / 6.0 - square * (1.0 / 120.0)))
        versine = square * (0.5 - square * (1.0 / 24.0))
        nc, ns = c - (c * versine + s * sine), s - (s * versine - c * sine)
        nx, nz = x + dt * vx, z + dt * vz
        past = tick - ticks
        past = past if past > 0.0 else 0.0
        state[PUSH + j] = (base + slope * tick) + bend * past
        if vertical is not None:
            state[LIFT + j] = (state[UP_BASE + j] + state[UP_SLOPE + j] * tick) + state[UP_BEND + j] * past
        # Arms of the corners to either side of the centre and their drops below it.
        bc, bs, hc, hs = b * nc, b * ns, h * nc, h * ns
        al, ar, dl, dr = bc + hs, bc - hs, hc - bs, hc + bs
        ex, ez, ew = vx + kx, vz + kz, vw + kw
        state[HALF + j] = half
        state[NEW_X + j], state[NEW_Z + j], state[NEW_ANGLE + j] = nx, nz, old_angle + turn
        state[NEW_COS + j], state[NEW_SIN + j] = nc, ns
        state[MID_VX + j], state[MID_VZ + j], state[MID_VW + j] = vx, vz, vw
        state[END_VX + j], state[END_VZ + j], state[END_VW + j] = ex, ez, ew
        state[ARM_L + j], state[ARM_R + j], state[DROP_L + j], state[DROP_R + j] = al, ar, dl, dr
        state[NEW_UL + j], state[NEW_UR + j] = dl - nz, dr - nz
        if rough is not None:
            sl, sr = gl + ((nx - al) - oxl), gr + ((nx + ar) - oxr)
            sl, sr = (sl if oul > 0.0 else 0.0), (sr if our > 0.0 else 0.0)
            state[NEW_SL + j], state[NEW_SR + j] = sl, sr
            state[END_XL + j], state[END_XR + j] = ex - dl * ew, ex - dr * ew
        state[END_ZL + j], state[END_ZR + j] = ez + al * ew, ez - ar * ew


@njit(**OPTIONS)
def solve(state: Any, columns: int, gravity: float, vertical: Any, rough: Any) -> None:
    """Velocities at the end of the step, with springs and dashpots of the corners that press and stick taken there.

    Which ones do is judged in fine steps from the foreseen position and velocities, in long ones it is as last found. A
    slipping corner carries ±μ times its normal force. The three equations are solved by elimination without a pivot: the
    matrix is 1 plus something that only adds, but for sliding corners, which jam before they take too much away.
    """
    for j in range(columns):
        k, ks, mu, dash = state[STIFFNESS + j], state[TANGENTIAL + j], state[FRICTION + j], state[DASHPOT + j]
        inertia, half = state[INERTIA + j], state[HALF + j]
        al, ar, dl, dr = state[ARM_L + j], state[ARM_R + j], state[DROP_L + j], state[DROP_R + j]
        ul, ur, sl, sr = state[NEW_UL + j], state[NEW_UR + j], state[NEW_SL + j], state[NEW_SR + j]
        xl, xr, zl, zr = state[END_XL + j], state[END_XR + j], state[END_ZL + j], state[END_ZR + j]
        signed_l, signed_r = state[SLID_L + j], state[SLID_R + j]
        pressed_l, pressed_r = state[PRESSED_L + j], state[PRESSED_R + j]
        fine, tail_ticks = state[FINE + j], state[TAIL_TICKS + j]
        foreseen_x, foreseen_z, foreseen_w = state[END_VX + j], state[END_VZ + j], state[END_VW + j]
        vx, vz, vw, push = state[MID_VX + j], state[MID_VZ + j], state[MID_VW + j], state[PUSH + j]
        nl, nr = k * ul - dash * zl, k * ur - dash * zr
        # In a fine step the foreseen forces tell which corners press and slide. A longer one overshoots too far for that:
        # there they press, slide and stick as last found, and `commit` has the step done again where sliding proves wrong.
        late = fine > tail_ticks
        foreseen_l, foreseen_r = (nl if nl > 0.0 else 0.0), (nr if nr > 0.0 else 0.0)
        foreseen_l, foreseen_r = (foreseen_l if ul > 0.0 else 0.0), (foreseen_r if ur > 0.0 else 0.0)
        pressed_l, pressed_r = (0.0 if late else pressed_l), (0.0 if late else pressed_r)
        on_l, on_r = foreseen_l + pressed_l > 0.0, foreseen_r + pressed_r > 0.0
        normal, weight = dash + half * k, gravity
        if vertical is not None:
            weight = gravity + state[LIFT + j]
        bl, br = (half * normal if on_l else 0.0), (half * normal if on_r else 0.0)
        wl, wr = bl * al, br * ar
        a22, a23 = 1.0 + (bl + br), wl - wr
        if rough is not None:
            fl, fr = ks * sl + dash * xl, ks * sr + dash * xr
            excess_l, excess_r = abs(fl) - mu * nl, abs(fr) - mu * nr
            slide_l, slide_r = (excess_l if late else abs(signed_l)), (excess_r if late else abs(signed_r))
            sign_l, sign_r = math.copysign(mu, fl), math.copysign(mu, fr)
            signed_l, signed_r = (sign_l if late else signed_l), (sign_r if late else signed_r)
            # A normal force on a sliding corner must push it out. Where friction would turn the block in instead
            # (Painlevé's paradox, from μ = 4/3 on), the corner jams: it sticks.
            free_l, free_r = 1.0 + inertia * al * (al + signed_l * dl), 1.0 + inertia * ar * (ar - signed_r * dr)
            # It does not jam where the other corner sticks: the block can then only turn about that one.
            free_l, free_r = free_l > LEAST_FREEDOM, free_r > LEAST_FREEDOM
            slides_l, slides_r = slide_l > 0.0, slide_r > 0.0
            stick_l, stick_r = on_l & (not slides_l), on_r & (not slides_r)
            free_l, free_r = free_l | stick_r, free_r | stick_l
            signed_l, signed_r = (signed_l if free_l else 0.0), (signed_r if free_r else 0.0)
            slides_l, slides_r = slides_l & free_l, slides_r & free_r
            stick_l, stick_r = on_l & (not slides_l), on_r & (not slides_r)
            # What the forces would be at rest at the end of the step.
            tangential = dash + half * ks
            nl, nr = nl + normal * zl, nr + normal * zr
            fl, fr = fl - tangential * xl, fr - tangential * xr
            tangential = half * tangential
            tl, tr = (tangential if stick_l else 0.0), (tangential if stick_r else 0.0)
            ql, qr = (signed_l * bl if slides_l else 0.0), (signed_r * br if slides_r else 0.0)
            nl, nr = (nl if on_l else 0.0), (nr if on_r else 0.0)
            fl, fr = (fl if stick_l else signed_l * nl), (fr if stick_r else signed_r * nr)
            hx = vx + half * (push - (fl + fr))
            hz = vz + half * ((nl + nr) - weight)
            hw = vw + half * (inertia * ((al * nl + dl * fl) - (ar * nr - dr * fr)))
            el, er = wl + ql * dl, wr - qr * dr
            gl, gr = tl * dl, tr * dr
            lever = gl + gr
            a11, a12, a13 = 1.0 + (tl + tr), -(ql + qr), (qr * ar - ql * al) - lever
            a31, a32 = inertia * lever, inertia * (el - er)
            a33 = 1.0 + inertia * ((el * al + gl * dl) + (er * ar + gr * dr))
            both, first, second = a11 * a22, a31 * a22, a32 * a11 + a31 * a12
            last = (a33 * both + first * a13) - second * a23
            inverse = 1.0 / (both * last)
            ew = ((hw * both + first * hx) - second * hz) * (inverse * both)
            inverse = inverse * last
            ez = (hz - a23 * ew) * (inverse * a11)
            ex = ((hx - a12 * ez) - a13 * ew) * (inverse * a22)
            state[SLID_L + j], state[SLID_R + j] = signed_l, signed_r
        else:
            nl, nr = (nl + normal * zl if on_l else 0.0), (nr + normal * zr if on_r else 0.0)
            ex = vx + half * push
            hz = vz + half * ((nl + nr) - weight)
            hw = vw + half * (inertia * (al * nl - ar * nr))
            a32, a33 = inertia * a23, 1.0 + inertia * (wl * al + wr * ar)
            last = a33 * a22 - a32 * a23
            inverse = 1.0 / (a22 * last)
            ew = (hw * a22 - a32 * hz) * (inverse * a22)
            ez = (hz - a23 * ew) * (inverse * last)
        state[END_VX + j], state[END_VZ + j], state[END_VW + j] = ex - foreseen_x, ez - foreseen_z, ew - foreseen_w


@njit(**OPTIONS)
def advance_centred(state: Any, columns: int, steps: int, gravity: float, vertical: Any, rough: Any) -> None:
    """Take the steps of a sample, `TICKS` ticks long each where no contact changes.

    Parameters
    ----------
    state : ndarray
        The columns (`overturning.dem.columns`).
    columns : int
        How many of them to advance.
    steps : int
        Steps to take; a column that steps finely is then behind and goes on from there in the next call, by its own clock.
    gravity : float
        m/s².
    vertical : ndarray or None
        None where the base does not move up and down: what that takes is then not compiled.
    rough : bool or None
        None where no block has friction: there are then no tangential springs.
    """
    ticks = 1.0 * TICKS * steps
    for _ in range(steps):
        foresee(state, columns, ticks, vertical, rough)
        solve(state, columns, gravity, vertical, rough)
        commit(state, columns, gravity, vertical, rough)
